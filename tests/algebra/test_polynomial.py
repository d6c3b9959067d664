"""Polynomials with roots in their coefficients: one form each."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from algebra.number_fields import RING, number_of, numbers
from hypothesis import given, settings

from rankdrop.algebra.polynomial import flint, norm, primitive, reciprocal, reduced_roots
from rankdrop.algebra.ring import numeric_terms
from rankdrop.algebra.roots import ROOTS, root_values, sums_over_roots
from rankdrop.formula.writing import Condition


@given(numbers())
@settings(deadline=None, max_examples=30)
def test_a_number_times_its_reciprocal_is_1(values) -> None:
    x = RING.half.constant(0) + number_of(values)
    assert reduced_roots(x * reciprocal(x)) == 1
    assert norm(x)[0].is_constant()


@pytest.mark.parametrize("power", [8, 30, 120])
def test_coefficients_over_roots_keep_their_digits(power: int) -> None:
    """(2 − √3)^k = a − b √3 is 0.268^k with a and b some 3.7^k; in floats nothing is left of it at k = 30."""
    x, h = RING.t[1], RING.letter_half
    f = reduced_roots((2 - h["sqrt3"]) ** power * x - 3)
    numbers = {"a": 1.0, **root_values(ROOTS)}
    found = {powers[0]: number for number, powers in numeric_terms(f, numbers, unit=flint().fmpq(1))}
    assert found[0] == -3.0
    assert found[1] == pytest.approx((2 + np.sqrt(3)) ** -power, rel=1e-13)
    terms = [("none", Fraction(3), (("sqrt3", 0),)), ("none", Fraction(-1), (("sqrt3", 2),))]
    assert sums_over_roots(terms) == {"none": 0}
    equation = Condition(RING, f).equation({}, 2)
    angle = 2 * np.arctan(3 * (2 + np.sqrt(3)) ** power)
    assert abs(equation(np.array([[angle, 0.3]]))[0]) < 1e-12


def test_a_polynomial_has_one_primitive_form() -> None:
    x, w = RING.t[1], RING.letter_half["sqrt2"]
    assert str(primitive(w * x - 2)) == str(primitive(x - w)) == str(primitive(reduced_roots((3 - w) * (x - w))))
