"""Guards against a missing family, each with a case in which nothing else would notice."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.letters import covered_by_numeric_tree, decided_by_numbers, splits
from rankdrop.exact.tree import Drop, rank_tree
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions
from rankdrop.verbs.deriving import _cloud


@pytest.mark.by_hand
def test_a_configuration_of_corank_two_is_not_explained_by_a_family_of_corank_one() -> None:
    """PA-10: what loses two freedoms lies on families of corank 1 too; without those of corank 2 it is left over."""
    found = conditions(open_robot("pa10"), points=0, special=False, coranks=2)
    work = Work(60.0, 0)
    check, over, _ = _cloud(found.chain, 6, 4, found.families, 200, work, [])
    assert (check.tested > 200, over) == (True, [])
    _, over, _ = _cloud(found.chain, 6, 4, found.of_corank(1), 200, work, [])
    assert len(over) == 1
    assert over[0].startswith("corank 2: ")


@pytest.mark.by_hand
def test_a_drop_that_numbers_have_and_letters_have_not_is_not_covered() -> None:
    chain = exact_chain(open_robot("puma560"))
    tree = rank_tree(chain, Work(60.0, 0))
    plain = rank_tree(replace(chain, letters={}, written={}), Work(60.0, 0))
    assert covered_by_numeric_tree(chain, tree, plain)
    for missing in range(len(tree.drops)):
        less = replace(tree, drops=[drop for i, drop in enumerate(tree.drops) if i != missing])
        assert not covered_by_numeric_tree(chain, less, plain), tree.drops[missing]


@pytest.mark.by_hand
def test_what_numbers_leave_open_settles_nothing_with_letters() -> None:
    """A set without points, or a system not taken apart, may hold what letters have not."""
    chain = exact_chain(open_robot("puma560"))
    tree = rank_tree(chain, Work(60.0, 0))
    plain = rank_tree(replace(chain, letters={}, written={}), Work(60.0, 0))
    clear = replace(plain, without_points=[])
    assert decided_by_numbers(chain, tree, clear)
    assert not decided_by_numbers(chain, tree, replace(clear, without_points=[(plain.drops[0].piece, 5, True)]))
    assert not decided_by_numbers(chain, tree, replace(clear, unresolved=["t1 = 0; t2 = 0; t3 = 0"]))
    assert not decided_by_numbers(chain, tree, replace(clear, complete=False))
    assert not decided_by_numbers(chain, replace(tree, complete=False), clear)


@pytest.mark.slow
def test_a_square_at_these_lengths_is_seen() -> None:
    ring_of = exact_chain(open_robot("puma560"))
    tree = rank_tree(ring_of, Work(60.0, 0))
    assert not splits(ring_of, tree)
    (a, x), (b, y) = list(ring_of.letters.items())[:2]
    ring = ring_of.ring
    one, two, t = ring.letter_half[a], ring.letter_half[b], ring.t[5]
    f = one * (1 + t**2) - two * t * 2
    drop = Drop(ZeroSet(ring, {}, rest=(f,), equations=(f,)), 5)
    same = replace(ring_of, letters={**ring_of.letters, b: x})
    assert x != y
    assert not splits(ring_of, replace(tree, drops=[drop]))
    assert splits(same, replace(tree, drops=[drop]))


@pytest.mark.slow
def test_factors_and_angles_at_these_lengths_are_seen() -> None:
    """a (1 + t² s) − b t (1 + s) has the factors 1 − t and 1 − t s where a = b; (a − b) t + a + b has θ5 = π there."""
    chain = exact_chain(open_robot("puma560"))
    tree = rank_tree(chain, Work(60.0, 0))
    (a, x), (b, y) = list(chain.letters.items())[:2]
    ring = chain.ring
    one, two, t, s = ring.letter_half[a], ring.letter_half[b], ring.t[5], ring.t[4]
    same = replace(chain, letters={**chain.letters, b: x})
    for f in (one * (1 + t**2 * s) - two * t * (1 + s), (one - two) * t + one + two * s, (one - two) * (t + 3)):
        drop = Drop(ZeroSet(ring, {}, rest=(f,), equations=(f,)), 5)
        assert not splits(chain, replace(tree, drops=[drop]))
        assert splits(same, replace(tree, drops=[drop]))
    assert x != y


@pytest.mark.by_hand
def test_rounded_axes_of_an_arm_make_no_family_regular() -> None:
    """The axes of jaka_a5 are rounded to 1e-16: σ4 on k3.f1 is 1.3e-15, with any number of digits."""
    found = conditions(open_robot("jaka_a5"), method="tree", points=0, fresh=True)
    assert found.verified
