"""Checks that know nothing of the derivation: they agree with the numeric Jacobian, and they see a wrong answer."""

from __future__ import annotations

import random
from fractions import Fraction
from math import atan, pi

import numpy as np
import pytest

from rankdrop.algebra.field import ModularPoint, P, complete, rank, value_at
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.arm.verify import random_points, rank_agreement, rank_check, rank_modulo
from rankdrop.families.linear_conditions import vanishing_on
from rankdrop.families.points import cloud, count_explained
from rankdrop.families.record import Check
from rankdrop.families.searching import search
from rankdrop.families.table import families
from rankdrop.formula.equation import Equation, Term
from rankdrop.local.block import singular_values
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = ["ur5", "puma560", "anthropomorphic", "stanford", "scara", "planar3r", "pa10", "canadarm2", "panda", "rcrrrr"]
SIX_ROWS = ["ur5", "puma560", "stanford", "pa10", "canadarm2", "panda"]


def chain_of(name: str) -> Chain:
    return exact_chain(open_robot(name))


def rational_point(chain: Chain, tangents: list[Fraction]) -> tuple[ModularPoint, np.ndarray]:
    """The same rational half-angle tangents modulo P (the arm's own lengths) and as a configuration q."""
    values = {name: value.numerator * pow(value.denominator, -1, P) % P for name, value in chain.letters.items()}
    q = np.zeros(chain.n)
    for j, t in enumerate(tangents, 1):
        residue = t.numerator * pow(t.denominator, -1, P) % P
        values[f"t{j}" if j in chain.ring.revolute else f"q{j}"] = residue
        q[j - 1] = 2 * atan(t) if j in chain.ring.revolute else float(t)
    point = complete(chain.ring, ModularPoint(values), {})
    assert point is not None
    return point, q - chain.shifts


@pytest.mark.parametrize("name", SIX_ROWS)
def test_the_modular_kinematics_and_the_symbolic_screws_have_the_same_rank_of_every_subset(name: str) -> None:
    chain = chain_of(name)
    rng = random.Random(3)
    for point in random_points(chain, 5):
        for j in chain.ring.revolute:
            if rng.random() < 0.4:
                point[f"s{j}"], point[f"c{j}"] = 0, rng.choice([1, P - 1])
        columns = [[value_at(chain.ring, x, point) for x in column] for column in chain.columns]
        assert rank_modulo(chain, point) == rank(columns)


@pytest.mark.parametrize("name", ARMS[:-1])
def test_the_rank_modulo_p_is_the_numeric_rank_at_rational_points(name: str) -> None:
    chain = chain_of(name)
    rng = random.Random(5)
    seen = set()
    for _ in range(30):
        tangents = [Fraction(rng.choice([0, 0, 1, -1, rng.randint(1, 9)]), rng.randint(1, 9)) for _ in range(chain.n)]
        point, q = rational_point(chain, tangents)
        sigma = singular_values(chain.robot, q, chain.task)
        numeric = int((sigma > 1e-9).sum())
        assert rank_modulo(chain, point) == numeric
        seen.add(numeric)
    assert len(seen) > 1, "only regular points were met"


@pytest.mark.parametrize("task", ["position", "orientation", "planar", "vx,vz,wy"])
def test_a_task_of_some_rows_has_its_own_rank(task: str) -> None:
    chain = exact_chain(open_robot("puma560"), task)
    for tangents in ([Fraction(1, 3)] * 6, [Fraction(2), Fraction(0), Fraction(1, 5), *[Fraction(0)] * 3]):
        point, q = rational_point(chain, tangents)
        assert rank_modulo(chain, point) == int((singular_values(chain.robot, q, chain.task) > 1e-9).sum())


def test_a_wrist_stretched_out_is_seen_and_a_wrong_claim_too() -> None:
    chain = chain_of("puma560")
    points = random_points(chain, 20)
    assert rank_check(chain, points) == (6,) * 20
    for point in points:
        point["s5"], point["c5"] = 0, 1
    assert rank_agreement(chain, points, 5) == Check(20, 20)
    assert rank_agreement(chain, points, 6) == Check(20, 0)


@pytest.mark.parametrize("name", ["ur5", "pa10", "canadarm2", "scara"])
def test_a_cloud_is_singular_as_it_says(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    found = cloud(robot, task, 1, 200)
    assert (found.corank == 1).sum() >= 200
    sigma = singular_values(robot, found.q, task)
    assert ((sigma <= 1e-9).sum(axis=1) == found.corank).all()


def test_a_cloud_holds_higher_coranks_too() -> None:
    robot = open_robot("pa10")
    found = cloud(robot, resolve_task(None, robot), 1, 200)
    assert set(found.corank.tolist()) == {1, 2, 3}


def test_an_arm_that_is_never_singular_so_has_an_empty_cloud() -> None:
    robot = open_robot("scara")
    assert len(cloud(robot, resolve_task(None, robot), 2, 50).q) == 0


@pytest.mark.by_hand_at("canadarm2", "panda")
@pytest.mark.parametrize("name", [*ARMS[:7], *(pytest.param(name, marks=pytest.mark.slow) for name in ARMS[7:])])
def test_the_numeric_families_explain_a_thousand_points(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    known = [family.equations for family in families(search(robot, 1, task=task, starts=400)).families]
    check, left = count_explained(cloud(robot, task, 1, 1000, seed=9), known)
    assert check.agree == check.tested >= 1000
    assert check.agree == check.tested
    assert len(left) == 0


def test_a_family_left_out_leaves_its_points_over() -> None:
    robot = open_robot("puma560")
    points = cloud(robot, resolve_task(None, robot), 1, 300)
    known = families(search(robot, 1, starts=400)).families
    wrist = vanishing_on([0, 0, 0, 0, 1, 0], [0.0, pi], periodic=True)
    others = [family.equations for family in known if not np.allclose(wrist(family.witness), 0)]
    assert 0 < len(others) < len(known)
    check, left = count_explained(points, others)
    assert 0 < len(left) == check.tested - check.agree
    assert np.abs(wrist(points.q[left])).max() < 1e-6


def test_points_of_an_equation_without_slope_are_not_lost() -> None:
    robot = open_robot("scara")
    points = cloud(robot, resolve_task(None, robot), 1, 50)
    still = (0, 0, 0, 0)
    square = Equation((Term(1.0, "cos", still, still), Term(-1.0, "cos", (0, 4, 0, 0), still)))  # 2 sin² θ2
    check, left = count_explained(points, [(square,)])
    assert check.agree == check.tested >= 50
    assert left.tolist() == []


def test_nothing_explains_nothing() -> None:
    robot = open_robot("scara")
    points = cloud(robot, resolve_task(None, robot), 1, 50)
    check, left = count_explained(points, [])
    assert check.agree == 0
    assert len(left) == check.tested


def test_the_modular_kinematics_of_slides_at_odd_angles_agree_with_the_numeric_rank() -> None:
    rows = [[0.3, pi / 2, 0.3, 0.0], [0.4, 0.9, 0.0, 0.7], [0.2, -pi / 2, 0.1, pi / 2]]
    wrist = [[0.0, pi / 2, 0.2, 0.0], [0.0, -pi / 2, 0.0, 0.0], [0.0, 0.0, 0.1, 0.0]]
    robot = from_dh([*rows, *wrist], convention="standard", kinds="RPRRRR")
    chain = exact_chain(robot)
    ranks = set()
    for tangents in ([1, 2, 3, 4, 5, 6], [0, 1, 0, 2, 0, 0], [1, 0, 1, 0, 1, 1], [0, 0, 0, 0, 1, 0]):
        point, q = rational_point(chain, [Fraction(t) for t in tangents])
        ranks.add(rank_modulo(chain, point))
        assert rank_modulo(chain, point) == int((singular_values(robot, q, chain.task) > 1e-9).sum())
    assert len(ranks) > 1
