"""The exact chain against the numeric Jacobian: same row space at random configurations, for every arm and task."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from reference.arms import in_other_words, random_chain, remade, reversed_chain, standard_dh

pytest.importorskip("flint")

from known.arms import KINDS

from rankdrop.errors import OptionError, RobotError, TaskError
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.letters import letters_text, never_zero, sign_of, value_of
from rankdrop.kinematics import jacobian, task_jacobian
from rankdrop.robot.open import open_robot
from rankdrop.task import BODY, Task

HALF = pi / 2


def numeric(chain: Chain, q: np.ndarray) -> np.ndarray:
    """(m, n) the chain's columns at a configuration, floats."""
    theta = q + chain.shifts
    values = dict(chain.numbers)
    for j in chain.ring.revolute:
        values[f"s{j}"], values[f"c{j}"] = np.sin(theta[j - 1]), np.cos(theta[j - 1])
    for j in chain.ring.prismatic:
        values[f"q{j}"] = theta[j - 1]
    names = [str(g) for g in chain.ring.trig.gens()]

    def value(p) -> float:
        return sum(
            int(c.p) / int(c.q) * np.prod([values[name] ** int(e) for name, e in zip(names, powers, strict=True)])
            for powers, c in p.terms()
        )

    return np.array([[value(x) for x in column] for column in chain.columns]).T


def assert_same_row_space(one: np.ndarray, two: np.ndarray, tolerance: float = 1e-8) -> None:
    """Two m × n matrices whose rows span the same space, as null spaces and ranks have it."""
    both = np.linalg.svd(np.vstack([one / np.abs(one).max(), two / np.abs(two).max()]), compute_uv=False)
    ranks = {
        int((np.linalg.svd(x / np.abs(x).max(), compute_uv=False) > 1e-6).sum()) for x in (one, two)
    }
    assert len(ranks) == 1
    assert ranks != {0}
    assert not (both[ranks.pop() :] > tolerance).any()


def assert_exact(robot, task=None, *, tolerance: float = 1e-8, **options) -> None:
    chain = exact_chain(robot, task, **options)
    rng = np.random.default_rng(4)
    for _ in range(4):
        q = rng.uniform(-pi, pi, robot.n)
        assert_same_row_space(numeric(chain, q), task_jacobian(robot, q, chain.task), tolerance)


@pytest.mark.spread(28)
@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("lengths", ["auto", "numbers"])
def test_every_arm_of_the_catalogue(name: str, lengths: str) -> None:
    assert_exact(open_robot(name), lengths=lengths)


@pytest.mark.spread(16)
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kinds", ["rrrrrr", "rprrrr", "rrrrrrr", "prrprrrr"])
def test_random_screws(kinds: str, seed: int) -> None:
    robot = random_chain(np.random.default_rng(seed), kinds)
    assert_exact(robot, tolerance=1e-5)


@pytest.mark.parametrize("seed", range(12))
def test_tables_with_zeros_quarter_turns_and_slides(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = [
        (
            rng.choice([0, 0.3, -0.2]),
            rng.choice([0, HALF, -HALF, pi, 0.4]),
            rng.choice([0, 0.25, -0.1]),
            rng.choice([0, HALF, 0.7]),
            *([1] if rng.random() < 0.2 else []),
        )
        for _ in range(6)
    ]
    robot = standard_dh("table", rows)
    assert_exact(robot, tolerance=1e-5)
    assert_exact(robot, lengths="letters", tolerance=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("task", ["position", "orientation", "planar", "vx,vz,wy", "vz,wx,wy"])
@pytest.mark.parametrize("name", ["puma560", "pa10", "stanford", "scara"])
def test_tasks_of_some_rows(name: str, task: str) -> None:
    assert_exact(open_robot(name), task)


@pytest.mark.parametrize("name", ["puma560", "stanford", "scara", "almarkhi4"])
def test_base_tool_units_and_signs_of_joints(name: str) -> None:
    robot = open_robot(name)
    others = (*in_other_words(robot, np.random.default_rng(2)), remade(robot, length=1000.0), reversed_chain(robot))
    for other in others:
        assert_exact(other, tolerance=1e-6)


def test_one_and_two_joints() -> None:
    for rows in ([(0.3, 0, 0.1, 0)], [(0, HALF, 0.2, 0), (0.4, 0, 0, 0)], [(0, 0, 0, 0, 1)]):
        assert_exact(standard_dh("short", rows))


def test_equal_lengths_share_a_letter_with_their_sign() -> None:
    rows = [(0, HALF, 0.1, 0), (0.4, 0, 0.2, 0), (-0.4, 0, 0.3, 0.3), (0, HALF, 0.2, 0), (0, 0, 0.1, 0)]
    robot = standard_dh("equal", rows)
    chain = exact_chain(robot, "position")
    assert set(chain.letters) >= {"a2"}
    assert {name for name in chain.letters if name[0] == "a"} == {"a2"}
    signs = {sign for (_, which), (sign, letter) in chain.written.items() if letter == "a2" and which == "a"}
    assert signs == {1, -1}
    assert_exact(robot, "position")


def test_names_that_mean_something_else_and_lengths_that_are_not_there_are_refused() -> None:
    robot = open_robot("puma560")
    for wrong in ({"s2": 0.4318}, {"pi": 0.4318}, {"x": 17.0}):
        with pytest.raises(OptionError):
            exact_chain(robot, lengths=wrong)
    with pytest.raises(OptionError):
        exact_chain(robot, lengths="words")
    with pytest.raises((TaskError, OptionError)):
        exact_chain(robot, "nonsense")


def test_helical_joints_and_multipliers_that_are_not_whole_are_refused() -> None:
    for kinds in ("rhr", "rrm"):
        with pytest.raises(RobotError):
            exact_chain(random_chain(np.random.default_rng(0), kinds))


def test_values_and_signs_of_lengths() -> None:
    chain = exact_chain(open_robot("puma560"))
    a2, d4 = chain.ring.letter_half["a2"], chain.ring.letter_half["d4"]
    numbers = chain.numbers
    assert value_of(chain, a2 * d4 - 1) == pytest.approx(numbers["a2"] * numbers["d4"] - 1)
    assert sign_of(chain, a2 - a2) == 0
    assert sign_of(chain, a2**2 + 1) == 1
    assert sign_of(chain, -(a2**2)) == -1
    assert never_zero(chain, a2**2 + d4**2)
    assert not never_zero(chain, a2**2 - d4**2)
    assert letters_text(chain.ring, a2**2 - d4**2) in ("(a2 − d4) (a2 + d4)", "(a2 + d4) (a2 − d4)")


def test_the_home_of_the_tool_moves_the_rows_of_a_position_only() -> None:
    robot = open_robot("puma560")
    tool = np.eye(4)
    tool[2, 3] = 0.2
    longer = replace(robot, home=robot.home @ tool)
    assert_exact(longer, "position")
    q = np.full(robot.n, 0.3)
    assert jacobian(robot, q).shape == (6, robot.n)


@pytest.mark.parametrize("rows", [(0, 1, 5), (0, 2, 4), (0, 1)])
def test_rows_may_be_those_of_the_tool(rows: tuple[int, ...]) -> None:
    assert_exact(open_robot("puma560"), Task("rows of the tool", rows, BODY))
