"""Sets that are one row: every combination of their angles, or a sum of angles at 0 and π."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.rows import merge, row_of_set
from rankdrop.exact.tree import rank_tree
from rankdrop.robot.open import open_robot


@pytest.fixture(scope="module")
def chain() -> Chain:
    return exact_chain(open_robot("anthropomorphic"))


def test_angles_in_all_combinations_make_one_row(chain: Chain) -> None:
    ring = chain.ring
    pieces = [ZeroSet(ring, {3: one, 5: two}) for one in ("0", "pi") for two in ("0", "pi")]
    (row,) = merge(pieces)
    assert row.pins == {3: ("0", "pi"), 5: ("0", "pi")}
    assert len(row.pieces) == 4
    assert row.texts == ("θ3 = 0 or π", "θ5 = 0 or π")
    assert sorted(len(row.pieces) for row in merge(pieces[:3])) == [1, 2]
    assert row_of_set(pieces[0]).pins == {3: ("0",), 5: ("0",)}
    f = ring.t[2] - ring.t[4]
    assert len(merge([pieces[0], replace(pieces[1], solved=(), equations=(f,))])) == 2


def test_a_sum_of_angles_at_0_and_at_pi_is_one_row_and_at_half_pi_is_not() -> None:
    ring = Ring([3, 5])
    t3, t5 = ring.t[3], ring.t[5]
    polynomials = (t3 - t5, t3 * t5 + 1, t3 * t5 + t3 - t5 + 1)  # θ3 − θ5 is 0, π, −π/2
    same, opposite, quarter = (ZeroSet(ring, {}, rest=(f,), equations=(f,)) for f in polynomials)
    (row,) = merge([same, opposite])
    assert row.texts == ("s(θ3 − θ5) = 0",)
    assert row.pieces == (same, opposite)
    assert len(merge([same, quarter])) == 2


@pytest.mark.slow
def test_exact_sets_become_one_row_only_with_every_combination_of_their_angles() -> None:
    """PA-10, corank 3: θ2 … θ6 = 0 or π are 32 sets in one row; without one of them there is no such row."""
    chain = exact_chain(open_robot("pa10"))
    drops = rank_tree(chain, Work(60.0, 0)).drops
    pieces = [drop.piece for drop in drops if drop.rank == 3]
    (row,) = merge(pieces)
    product = 1
    for values in row.pins.values():
        product *= len(values)
    assert product == len(row.pieces) == len(pieces) == 32
    for less in merge(pieces[:-1]):
        product = 1
        for values in less.pins.values():
            product *= len(values)
        assert product == len(less.pieces)
        assert less.pins != row.pins
