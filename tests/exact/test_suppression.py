"""Dependent-screw suppression on many arms: sound modulo p, disjoint, nothing that a numeric search finds left over."""

import random
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

pytest.importorskip("flint")

from rankdrop.algebra.field import holds, rank, value_at
from rankdrop.algebra.polynomial import Equality
from rankdrop.algebra.work import Work
from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.derivation import _suppression_differences
from rankdrop.exact.stratum import Stratum
from rankdrop.exact.suppression import Case, _Recursion, suppress
from rankdrop.exact.tree import OpenCase, RankTree, rank_tree
from rankdrop.families.contradiction import TREE
from rankdrop.families.searching import Outcome, search
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.text.by_hand import left_text

QUICK = ["puma560", "ur5", "stanford", "xarm6", "pa10", "iiwa14", "canadarm2", "rcrrrr", "rail", "xarm7", "panda",
         "fetch8"]  # fmt: skip
LONG = ["gen3", "sawyer"]
GROWN = ["puma560", "canadarm2", "panda", "rail", "xarm7", "fetch8"]  # whose rank trees take a second or more
HOLDS = 1e-4  # |p| ≤ this times the sum of its terms' sizes: p = 0; σ tells powers and products of the p only
FOUND = {}


def arm(name):
    if name != "rail":
        return open_robot(name)
    # an arm with spherical shoulder and wrist on a rail along the ground
    rows = [(0, "pi/2", 0, 0), (0, "-pi/2", 0.4, 0), (0, "pi/2", 0, 0), (0, "-pi/2", 0.45, 0), (0, "pi/2", 0, 0),
            (0, "-pi/2", 0.5, 0), (0, "pi/2", 0, 0), (0, 0, 0.1, 0)]  # fmt: skip
    return from_dh(rows, convention="standard", kinds="PRRRRRRR", name="rail")


def derived(name):
    if name not in FOUND:
        FOUND[name] = suppress(exact_chain(arm(name)))
    return FOUND[name]


def size(chain, p, q):
    """|p| over the sum of its terms' sizes, at the configurations q (N, n)."""
    ring, theta = chain.ring, q + chain.shifts
    values = [f(theta[:, j - 1]) for j in ring.revolute for f in (np.sin, np.cos)]
    values += [theta[:, j - 1] for j in ring.prismatic]
    values += [np.full(len(q), chain.numbers[name]) for name in ring.letters]
    total, sizes = np.zeros(len(q)), 0.0
    for powers, coefficient in p.terms():
        term = np.full(len(q), int(coefficient.p) / int(coefficient.q))
        for value, power in zip(values, powers, strict=True):
            term = term * value ** int(power)
        own = powers[len(powers) - len(ring.letters) :]
        scale = np.prod([abs(chain.numbers[x]) ** int(e) for x, e in zip(ring.letters, own, strict=True)])
        total, sizes = total + term, sizes + abs(int(coefficient.p) / int(coefficient.q)) * float(scale)
    return np.abs(total) / sizes


def singular_configurations(robot, starts):
    found = search(robot, 1, starts=starts, threads=1, seed=3)
    return found.q[found.outcome == Outcome.CONVERGED]


def closures(found, q):
    """(N, families) whether all equalities of a family hold."""
    return np.array(
        [np.all([size(found.chain, p, q) < HOLDS for p in f.equalities], axis=0) for f in found.families]
    ).T


def strictly(found, q, inside, margin):
    """(N, families) whether the inequalities of a family hold, too, by a margin."""
    others = [
        np.all([size(found.chain, p, q) > margin for p in f.stratum.inequalities], axis=0) for f in found.families
    ]
    return inside & np.array([np.broadcast_to(one, len(q)) for one in others]).T


@pytest.mark.slow_at("fetch8", "rail", "panda", "xarm7")
@pytest.mark.parametrize("name", [*QUICK, *(pytest.param(x, marks=pytest.mark.slow) for x in LONG)])
class TestEveryArm:
    @pytest.mark.by_hand_at("fetch8", "gen3", "panda", "rail", "sawyer")
    def test_is_finished(self, name):
        found = derived(name)
        assert found.complete
        assert found.families

    @pytest.mark.by_hand_at("gen3", "sawyer")
    def test_is_sound_modulo_p(self, name):
        """Every family has rank 5 at random points, for random lengths."""
        for family in derived(name).families:
            assert family.ranks == (5,), family.family

    @pytest.mark.by_hand_at("sawyer", "gen3")
    def test_has_families_that_do_not_meet(self, name):
        families = derived(name).families
        for one, two in combinations(families, 2):
            assert one.stratum.separating_polynomial(two.stratum) is not None, (one.number, two.number)

    @pytest.mark.by_hand_at("xarm7", "fetch8")
    def test_explains_every_singular_configuration_found_numerically(self, name):
        found = derived(name)
        q = singular_configurations(found.chain.robot, 300)
        assert len(q) > 100
        inside = closures(found, q)
        assert inside.any(axis=1).all(), f"{(~inside.any(axis=1)).sum()} of {len(q)} left over"
        assert (strictly(found, q, inside, 100 * HOLDS).sum(axis=1) <= 1).all()
        assert strictly(found, q, inside, 1e-4 * HOLDS).any(axis=1).all()

    @pytest.mark.by_hand_at("gen3", "sawyer")
    def test_proves_what_it_suppresses(self, name):
        """At random points of every case the proof's minors are not all zero and the screw lies in the others' span."""
        found = derived(name)
        rng, seen = random.Random(5), 0

        def walk(case):
            nonlocal seen
            if case.dependence is not None:
                seen += 1
                screw, on, proof = case.dependence.screw, case.dependence.on, case.dependence.proof
                for piece in case.stratum.pieces:
                    point = piece.point(rng)
                    ring, prime = found.chain.ring, point.prime
                    matrix = {j: [value_at(ring, x, point) for x in found.columns[j - 1]] for j in (screw, *on)}
                    assert rank([matrix[j] for j in on], prime) == len(on) == rank(list(matrix.values()), prime)
                    assert any(value_at(ring, p, point) for p in proof.polynomials)
            for inner in case.cases:
                walk(inner)

        walk(found.start)
        assert (seen > 0) == (found.chain.n > 6)


@pytest.mark.spread(13)
@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK + LONG)
def test_a_thousand_starts_leave_nothing_unexplained(name):
    found = derived(name)
    q = singular_configurations(found.chain.robot, 1000)
    assert strictly(found, q, closures(found, q), 1e-4 * HOLDS).any(axis=1).all()


def test_six_joints_have_the_factors_of_their_determinant():
    found = derived("puma560")
    assert [len(family.equalities) for family in found.families] == [1, 1, 1]
    assert found.determinant.count("(") == 2
    assert found.start.cases[0].dependence is None


@pytest.mark.slow
def test_assumptions_are_told_for_the_panda():
    assert [str(p) for p in derived("panda").assumptions] == ["d3 + d5", "d3 - d5"]


@pytest.mark.slow
def test_a_time_limit_holds_and_what_is_left_is_told():
    found = suppress(exact_chain(arm("panda")), seconds=0.2)
    assert not found.complete
    assert {what for what, _ in found.left} <= {"time", "determinant"}
    assert all(left_text(one).startswith(("case ", "the determinant")) for one in found.left)
    nothing = suppress(exact_chain(arm("panda")), seconds=-1.0)
    assert nothing.left
    assert (nothing.families, nothing.determinant) == ((), "")


@pytest.mark.parametrize(
    ("given", "words"),
    [({"frame": 7}, "frame"), ({"basic": (1, 2, 3)}, "basic"), ({"basic": (1, 2, 3, 5, 6, 7)}, "basic")],
)
def test_wrong_choices_are_named(given, words):
    with pytest.raises(OptionError, match=words):
        suppress(exact_chain(arm("pa10")), **given)


def test_an_arm_with_too_few_joints_is_refused():
    with pytest.raises(TaskError):
        suppress(exact_chain(arm("scara")))


@pytest.mark.by_hand_at("fetch8", "canadarm2", "pa10")
@pytest.mark.by_hand_at("panda", "xarm7")
@pytest.mark.by_hand_at("rail")
@pytest.mark.parametrize("name", ["ur5", *(pytest.param(x, marks=pytest.mark.slow) for x in ("pa10", *GROWN))])
def test_every_set_of_the_rank_tree_lies_in_one_family(name):
    """Another derivation, of all coranks: a random point of each of its sets satisfies exactly one family, modulo p."""
    found = derived(name)
    rng = random.Random(7)
    tree = rank_tree(found.chain, Work(60.0))
    points = [point for drop in tree.drops for point in drop.piece.points(rng, 3)]
    assert len(points) > 6
    for point in points:
        holding = [
            family.number
            for family in found.families
            if all(value_at(found.chain.ring, p, point) == 0 for p in family.equalities)
            and all(value_at(found.chain.ring, p, point) != 0 for p in family.stratum.inequalities)
        ]
        assert len(holding) == 1, (holding, point)


@pytest.mark.slow
def test_the_choice_of_kg_gives_the_same_set():
    """Basic screws 2–7 in frame 5, or 1–6 in frame 3: as many families, each holding the points of the other's."""
    chain = exact_chain(open_robot("canadarm2"))
    one, two = suppress(chain, frame=5, basic=(2, 3, 4, 5, 6, 7)), suppress(chain, frame=3, basic=(1, 2, 3, 4, 5, 6))
    assert (one.basic, one.frame, one.frame_asked) == ((2, 3, 4, 5, 6, 7), 5, True)
    assert (two.basic, two.frame) == ((1, 2, 3, 4, 5, 6), 3)
    assert one.complete
    assert two.complete
    rng = random.Random(3)
    for mine, theirs in ((one, two), (two, one)):
        pieces = [piece for family in mine.families for piece in family.stratum.pieces]
        points = [point for piece in pieces for point in [piece.point(rng)] if point is not None]
        assert len(points) >= 5
        for point in points:
            assert any(all(holds(chain.ring, p, point) for p in family.equalities) for family in theirs.families)


def test_a_case_in_which_the_rank_is_full_is_told_and_is_no_family():
    """PA-10, sin θ3 = 0: all six freedoms are left at almost every point."""
    chain = exact_chain(open_robot("pa10"))
    ring = chain.ring
    derivation = _Recursion(chain, None, None, Work(60.0))
    regular, elbow = (Stratum.whole(ring).meet(Equality((), ring.s[joint])) for joint in (3, 4))
    for stratum in (regular, elbow.avoid(Equality((), ring.s[2])).meet(Equality((), ring.s[2])), elbow):
        derivation.family(Case("1", stratum, tuple(range(1, 8))))
    assert [family.stratum for family in derivation.families] == [elbow]
    assert [what for what, _ in derivation.left] == ["full rank", "no point"]


def test_sets_that_the_rank_tree_left_open_are_no_disagreement() -> None:
    """A set that is among its drops, its cases or its sets without points is its own; one that is nowhere is missed."""
    chain = exact_chain(open_robot("iiwa14"))
    tree, suppression = rank_tree(chain, Work(20.0), lowest=5), derived("iiwa14")
    lost, *others = [drop for drop in tree.drops if drop.rank == 5]
    shorter = replace(tree, drops=others)

    def missed(found: RankTree) -> int:
        different = _suppression_differences(chain, suppression, found, Work(20.0))
        return sum(one.number for one in different if one.other == TREE)

    assert missed(tree) == 0
    assert missed(shorter) > 0
    assert missed(replace(shorter, cases=[OpenCase(lost.piece, 6)])) == 0
    assert missed(replace(shorter, without_points=[(lost.piece, 6, False)])) == 0
