"""Twists of 15° and 18° and their multiples are exact: roots of numbers as variables, and what is rounded is said."""

from __future__ import annotations

from math import cos, pi, prod, radians

import numpy as np
import pytest
from algebra.number_fields import RING, number_of, numbers
from hypothesis import given, settings
from hypothesis import strategies as st

from rankdrop.algebra.factoring import factor
from rankdrop.algebra.gcd import quotient
from rankdrop.algebra.polynomial import Equality, is_number, reduced_roots
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.roots import ROOTS, root_values, surd
from rankdrop.algebra.solving import Solved
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.stratum import atoms_on
from rankdrop.families.record import exact_of
from rankdrop.kinematics import jacobian
from rankdrop.robot.dh import from_dh
from rankdrop.verbs.conditions import conditions


def b44(twist: float = pi / 4):
    """Six joints, four twists of 45°, modified convention."""
    rows = [(0.25, twist, 0.25), (0.0, 0.0, 0.0), (0.25, twist, 0.0), (0.0, twist, 0.0), (0.0, twist, 0.25),
            (0.0, pi / 2, 0.0)]  # fmt: skip
    return from_dh([{"a": a, "alpha": alpha, "d": d} for a, alpha, d in rows], convention="modified", name="b44")


@pytest.mark.slow
def test_the_family_at_45_degrees_is_found() -> None:
    """Known answer: at θ3 = −90°, θ4 = 0, θ5 = 45° the rank is 3 or less (σ4 = 9.8e-52 in 60 digits)."""
    q = np.radians([0.0, 0.0, -90.0, 0.0, 45.0, 0.0])
    assert np.linalg.svd(jacobian(b44(), q), compute_uv=False)[3] < 1e-15
    found = conditions(b44(), method="tree", points=0)
    (family,) = [one for one in found.of_corank(2) if all(abs(f(q[None])) < 1e-12 for f in one.equations)]
    assert (family.dimension, exact_of(family).rank_check.holds) == (3, True)
    assert found.verdict.claims == ("derived exactly",)


def test_a_rounded_twist_is_not_called_exact() -> None:
    """A twist of 44.9° has no short algebraic form: the verdict says which number was rounded, and by how much."""
    found = conditions(b44(radians(44.9)), method="tree", points=0, coranks=1)
    assert found.verdict.claims == ()
    assert "44.9° is rounded by" in found.verdict.sentence
    assert "exactly" not in found.verdict.sentence
    assert {one.kind for one in found.chain.effective_roundings} == {"twist"}
    assert all(0 < abs(one.miss) < 1e-11 for one in found.chain.effective_roundings)


def test_a_length_that_is_no_decimal_is_rounded_unless_it_is_a_letter() -> None:
    rows = [{"a": 0.1 * 2**0.5, "alpha": 0.0, "d": 0.0}, {"a": 0.2, "alpha": 0.0, "d": 0.0},
            {"a": 0.0, "alpha": 0.0, "d": 0.0}]  # fmt: skip
    arm = from_dh(rows, convention="standard")
    assert [one.kind for one in exact_chain(arm, "vx,vy,wz", lengths="numbers").effective_roundings] == ["a"]
    assert exact_chain(arm, "vx,vy,wz", lengths="letters").effective_roundings == ()


def test_a_ring_has_the_roots_in_the_squares_of_its_roots() -> None:
    assert Ring([1], letters=["b", "cos18"]).letters == ("b", "cos18", "sqrt5")


@pytest.mark.slow
@given(st.lists(st.tuples(numbers(), numbers(), numbers()), min_size=1, max_size=3))
@settings(deadline=None, max_examples=25)
def test_factors_multiply_to_the_polynomial(parts) -> None:
    x, y, a = RING.t[1], RING.t[2], RING.letter_half["a"]
    f = prod((x * number_of(u) + a * y * number_of(v) + number_of(w) for u, v, w in parts), start=RING.half.constant(1))
    f = reduced_roots(f)
    whole = prod((one**power for one, power in factor(f)), start=RING.half.constant(1))
    left = quotient(f, reduced_roots(whole))
    assert left is not None
    assert is_number(left)
    assert sum(power for _, power in factor(f)) == len(parts)


def test_a_solution_with_a_root_put_in_is_reduced() -> None:
    """t1 = √3 makes t1² − 3 zero, and (t1² − 3) t2 + t2 − 5 a condition on θ2 alone."""
    x, y, root = RING.t[1], RING.t[2], RING.letter_half["sqrt3"]
    piece = ZeroSet(RING, {}, solved=(Solved(0, root, root**0),), equations=(x - root,))
    assert atoms_on(piece, Equality((RING.atom((x**2 - 3) * (y**2 - 1)),))) is None
    (left,) = atoms_on(piece, Equality((RING.atom((x**2 - 3) * y + y - 5),)))
    assert str(left.f) == "t2 - 5"


def test_the_greatest_value_of_a_root_is_its_own() -> None:
    values = root_values(ROOTS)
    assert values == pytest.approx({"cos18": cos(pi / 10), "sqrt2": 2**0.5, "sqrt3": 3**0.5, "sqrt5": 5**0.5})
    assert float(surd(36)[0]) == pytest.approx(cos(pi / 5))


@pytest.mark.by_hand
def test_conditions_on_a_variable_each_are_no_system_left_over() -> None:
    """Half-angle tangents of three joints, roots of quadratics without a root modulo any of the primes."""
    table = [(0, 90, 0.2), (0.3, 30, 0.1), (0, 75, 0.42), (0, -15, 0), (0, 90, 0.1), (0.25, 0, 0)]
    rows = [(a, radians(twist), d, 0) for a, twist, d in table]
    found = conditions(from_dh(rows, convention="standard"), points=200)
    assert found.complete
    assert found.explained.agree == found.explained.tested
