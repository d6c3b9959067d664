"""The rank tree: sound at random points, complete against planted and numeric ones, and always in time."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from math import pi

import numpy as np
import pytest
from reference.arms import in_other_words, random_chain, remade, reversed_chain, standard_dh

pytest.importorskip("flint")

from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work, work_spent
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact import tree as rank_trees
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.arm.verify import rank_modulo
from rankdrop.exact.families import reality
from rankdrop.exact.tree import Drop, _bending, largest, rank_tree
from rankdrop.families.record import exact_of
from rankdrop.formula.equation import System
from rankdrop.local.block import singular_values
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions

HALF = pi / 2
FAST = ["anthropomorphic", "stanford", "irb140", "rcrrrr", "almarkhi4", "scara", "planar3r", "puma560", "ur5", "vx300s"]
SLOW = ["pa10", "canadarm2", "panda", "gen3", "fetch", "fetch8", "xarm6", "xarm7", "z1", "sawyer", "iiwa14", "ur10e"]


def slow(*names: str) -> list:
    """Parameters that are tried on request only."""
    return [pytest.param(name, marks=pytest.mark.slow) for name in names]


def tree_of(robot, task=None, seconds: float = 60.0, **options):
    chain = exact_chain(robot, task, **options)
    return chain, rank_tree(chain, Work(seconds))


@pytest.mark.slow_at("almarkhi4")
@pytest.mark.spread(2)
@pytest.mark.slow_at("irb140", "anthropomorphic")
@pytest.mark.parametrize("name", [*FAST[:7], *slow(*FAST[7:])])
def test_the_rank_is_as_claimed_at_random_points_of_every_set(name: str) -> None:
    chain, tree = tree_of(open_robot(name))
    assert tree.complete
    assert tree.drops
    for drop in tree.drops:
        assert {rank_modulo(chain, point) for point in drop.piece.samples} == {drop.rank}


@pytest.mark.slow_at("anthropomorphic")
@pytest.mark.spread(2)
@pytest.mark.by_hand_at(
    "panda", "gen3", "fetch8", "almarkhi4", "fetch", "iiwa14", "pa10", "puma560", "ur10e", "xarm6", "z1",
)
@pytest.mark.by_hand_at("canadarm2", "sawyer")
@pytest.mark.by_hand_at("xarm7")
@pytest.mark.slow_at("puma560")
@pytest.mark.parametrize("name", ["puma560", "anthropomorphic", *slow("ur5", *FAST[1:7], *SLOW)])
def test_conditions_hold_at_singular_configurations_only(name: str) -> None:
    found = conditions(open_robot(name), points=0, special=False)
    rng = np.random.default_rng(5)
    for family in found.families:
        q, good = System(family.equations).solve(rng.uniform(-pi, pi, (100, found.robot.n)), iterations=100)
        assert good.sum() > 10
        sigma = singular_values(found.robot, q[good], found.task)
        assert sigma[:, found.generic_rank - family.corank].max() < 1e-4, family.texts


@pytest.mark.spread(3)
@pytest.mark.by_hand_at(
    "xarm7", "canadarm2", "sawyer", "z1", "fetch8", "almarkhi4", "anthropomorphic", "fetch", "gen3", "iiwa14",
    "pa10", "panda", "puma560", "ur10e", "ur5", "vx300s", "xarm6",
)  # fmt: skip
@pytest.mark.slow
@pytest.mark.parametrize("name", [*FAST, *SLOW])
def test_families_explain_a_thousand_configurations(name: str) -> None:
    found = conditions(open_robot(name), special=False)
    assert found.explained.tested >= 1000
    assert found.verified, (found.left, found.disagreements)


@pytest.mark.spread(1)
@pytest.mark.slow_at("anthropomorphic")
@pytest.mark.parametrize("name", ["anthropomorphic", "stanford", *slow("ur5", "irb140")])
def test_families_explain_some_configurations_of_every_corank(name: str) -> None:
    found = conditions(open_robot(name), points=200, special=False)
    assert found.explained.tested >= 200
    assert found.verified, (found.left, found.disagreements)


@pytest.mark.slow
def test_a_set_in_the_meeting_of_two_is_not_left_by_both_to_the_other() -> None:
    """The rail arm is singular at θ5, θ7 ∈ {0, π} with a condition, inside a meeting of two sets that are cut."""
    _, tree = tree_of(open_robot("fetch8"))
    pins = [dict(drop.piece.pins) for drop in tree.drops if len(drop.piece.equations) == 1]
    for one in ("0", "pi"):
        for two in ("0", "pi"):
            assert {5: one, 7: two} in pins


@pytest.mark.by_hand
def test_srs_has_the_rows_of_am() -> None:
    """AM Tables 3 to 5: 4, 4 and 1 rows; in single angles 14, 40 and 32."""
    _chain, tree = tree_of(open_robot("pa10"))
    single = Counter(tree.generic_rank - drop.rank for drop in tree.drops)
    assert single == {1: 14, 2: 40, 3: 32}
    found = conditions(open_robot("pa10"), points=0, special=True)
    assert Counter(family.corank for family in found.families) == {1: 4, 2: 4, 3: 1}
    assert {family.texts for family in found.of_corank(1)} == {
        ("θ4 = 0 or π",),
        ("θ2 = 0 or π", "θ3 = ±π/2"),
        ("θ2 = 0 or π", "θ6 = 0 or π"),
        ("θ5 = ±π/2", "θ6 = 0 or π"),
    }
    (special,) = found.assumptions
    assert special.text == "d3 ≠ d5"
    assert special.words.startswith("if d3 = d5, θ4 = π alone loses two freedoms")


@pytest.mark.slow
def test_an_arm_that_breaks_the_assumption_has_the_further_family() -> None:
    alpha = (-HALF, HALF, -HALF, HALF, -HALF, HALF, 0.0)
    d = (0, 0, 0.45, 0, 0.45, 0, 0.1)
    robot = standard_dh("equal", [(0, x, y, 0) for x, y in zip(alpha, d, strict=True)])
    found = conditions(robot, points=100)
    assert found.verified, (found.left, found.disagreements)
    assert ("θ4 = π",) in {family.texts for family in found.of_corank(2)}


@pytest.mark.slow
def test_canadarm2_has_the_irreducible_form_of_kg() -> None:
    lengths = {"a": 0.635, "c": 0.504, "d": 6.85}
    found = conditions(open_robot("canadarm2"), points=0, special=False, coranks=1, lengths=lengths)
    texts = [" & ".join(family.texts) for family in found.families]
    assert any("θ5 = θ3 + π" in text for text in texts)
    assert any("θ3 + θ5" in text or "θ5 = −θ3" in text for text in texts)


@pytest.mark.parametrize(
    ("name", "texts"),
    [
        ("scara", {("θ2 = 0 or π",)}),
        ("planar3r", {("θ2 = 0 or π",)}),
        ("planar2r", {("θ2 = 0 or π",)}),
    ],
)
def test_textbook_arms(name: str, texts: set[tuple[str, ...]]) -> None:
    found = conditions(open_robot(name), points=50)
    assert found.verified
    assert {family.texts for family in found.families} == texts


def test_a_set_of_higher_rank_lies_in_none_of_lower_rank() -> None:
    _, tree = tree_of(open_robot("scara"))
    one, two = tree.drops
    assert largest([one, two]) == [one, two]
    assert len(largest([one, one])) == 1
    assert len(largest([one, Drop(one.piece, one.rank + 1)])) == 2


@pytest.mark.slow
def test_strays_are_seen() -> None:
    """Two equations of a set of UR5 without the third hold at regular configurations, too."""
    from dataclasses import replace

    found = conditions(open_robot("ur5"), points=0, special=False, coranks=2)
    chain = exact_chain(open_robot("ur5"))
    long = [family for family in found.families if len(exact_of(family).polynomials) > 2]
    assert long
    piece = exact_of(long[0]).pieces[0]
    met = reality(chain, replace(piece, equations=piece.equations[:2]), 4, np.random.default_rng(1))
    assert len(met.strays)
    assert not len(reality(chain, piece, 4, np.random.default_rng(1)).strays)


ODD = {
    "one joint": standard_dh("one", [(0.3, 0, 0.1, 0)]),
    "two joints": standard_dh("two", [(0.3, HALF, 0.1, 0), (0.2, 0, 0, 0)]),
    "slides": standard_dh("slides", [(0, HALF, 0, 0.3, 1), (0, HALF, 0, HALF, 1), (0, 0, 0, 0, 1)]),
    "planar in space": standard_dh("planar", [(0.5, 0, 0, 0), (0.4, 0, 0, 0), (0.2, 0, 0, 0)]),
    "no lengths": standard_dh("nothing", [(0, HALF, 0, 0), (0, HALF, 0, 0), (0, HALF, 0, 0), (0, 0, 0, 0)]),
    "same axis twice": standard_dh("twice", [(0, 0, 0.3, 0), (0, HALF, 0.2, 0), (0.4, 0, 0, 0), (0, HALF, 0, 0)]),
    "offsets only": standard_dh("offsets", [(0, HALF, 0.3, 0), (0, -HALF, 0.2, 0), (0, HALF, 0.4, 0), (0, 0, 0.1, 0)]),
}


@pytest.mark.parametrize("name", ODD)
def test_odd_arms_do_not_fail(name: str) -> None:
    found = conditions(ODD[name], points=50, seconds=20)
    assert found.verified, (found.left, found.disagreements)
    for task in ("position", "orientation"):
        assert conditions(ODD[name], task, points=20, seconds=20).generic_rank <= 3


@pytest.mark.by_hand
@pytest.mark.parametrize("kinds", ["rrrrrr", *slow("rrrrrrr", "rrrrrrrr")])
def test_the_limit_holds_on_arms_without_structure(kinds: str) -> None:
    robot = random_chain(np.random.default_rng(1), kinds)
    before = work_spent()
    found = conditions(robot, seconds=2.0)
    assert work_spent() - before < 2.0 * 1.2 + 1.0
    assert not found.complete
    assert found.left


def test_what_is_found_before_an_interruption_is_kept() -> None:
    calls = 0

    def interrupt(label: str, done: int, total: int) -> None:
        nonlocal calls
        calls += label.endswith("rank < 5")
        if calls == 5:
            calls += 1
            raise KeyboardInterrupt

    found = conditions(open_robot("anthropomorphic"), progress=interrupt)
    assert not found.complete
    assert any("interrupted" in str(one) for one in found.left)
    assert Counter(family.corank for family in found.families)[1] == 3


@pytest.mark.by_hand_at("puma560", "ur5")
@pytest.mark.slow
@pytest.mark.parametrize("name", ["stanford", "puma560", "ur5"])
def test_base_tool_units_signs_and_direction_change_no_family(name: str) -> None:
    robot = open_robot(name)
    kinds = []
    others = in_other_words(robot, np.random.default_rng(1))
    for one in (robot, *others, remade(robot, length=1000.0), reversed_chain(robot)):
        found = conditions(one, points=50, special=False)
        assert found.verified, (found.left, found.disagreements)
        own = [(family.corank, family.codimension, len(exact_of(family).pieces)) for family in found.families]
        kinds.append(sorted(own))
    assert kinds[0]
    assert all(kind == kinds[0] for kind in kinds)


def test_every_phase_tells_how_far_it_is() -> None:
    labels = set()
    conditions(open_robot("scara"), points=20, progress=lambda label, done, total: labels.add(label.split(" for")[0]))
    assert labels >= {"sets derived", "sets with real points", "families described", "checks"}


def test_joints_are_counted_that_columns_depend_on_by_a_sine_alone() -> None:
    ring = Ring([1, 2, 3], prismatic=[4], letters=["a"])
    s, c, a = ring.s, ring.c, ring.letter["a"]
    for columns, count in (([[s[1]]], 1), ([[c[1]]], 1), ([[a]], 0), ([[s[3], a], [c[2] + s[2], a * ring.q[4]]], 3)):
        assert _bending(columns, ring) == count


def test_a_set_that_binds_every_joint_of_the_matrix_is_not_cut_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its rank is one and the same: planted here, four joints of which three bend the matrix, all at right angles."""
    robot = standard_dh("four", [(0, HALF, 0, 0), (0.4, 0, 0, 0), (0.3, 0, 0, 0), (0.2, 0, 0, 0)])
    chain = exact_chain(robot, "position")
    planted = ZeroSet(chain.ring, {2: "pi/2", 3: "pi/2", 4: "pi/2"})
    cut, given = rank_trees._cut, list[str]()

    def recorded(columns, order, piece, bending, work):
        given.append(piece.key)
        assert planted.codimension == bending
        assert rank_trees.rank_on(columns, planted) >= 2
        return [*cut(columns, order, piece, bending, work), planted]

    monkeypatch.setattr(rank_trees, "_cut", recorded)
    found = rank_tree(chain, Work(20.0), lowest=1)
    assert found.complete
    assert given
    assert planted.key not in given


def test_a_tree_that_is_not_wanted_ends_after_one_set() -> None:
    tree = rank_tree(exact_chain(open_robot("puma560")), Work(60.0), unwanted=lambda: True)
    assert not tree.complete
    assert tree.visited == 1


@pytest.mark.parametrize(
    ("lengths", "known", "lower"), [((1, 1), False, True), ((1, 2), False, False), ((1, 1), True, False)]
)
def test_a_rank_is_lower_for_these_lengths_where_no_drop_holds(lengths, known, lower) -> None:
    """The entry is a c1 - b, at θ1 = 0: zero for equal lengths. A drop with that point is no news."""
    ring, work = Ring([1], letters=["a", "b"]), Work()
    work.lengths = dict(zip("ab", map(Fraction, lengths), strict=True))
    columns = [[ring.letter["a"] * ring.c[1] - ring.letter["b"]]]
    point = ZeroSet.where_atom(ring, ring.pin(1, "0"))
    drops = [Drop(point, 0)] if known else []
    assert rank_trees._lower_for_these_lengths(columns, 1, [point], drops, work) == lower
