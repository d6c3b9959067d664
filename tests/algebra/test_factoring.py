"""Factors of polynomials with roots in their coefficients."""

from __future__ import annotations

from math import prod
from typing import Any

import pytest
from algebra.number_fields import RING
from algebra.polynomials import long_polynomial

from rankdrop.algebra import factoring
from rankdrop.algebra.factoring import factor
from rankdrop.algebra.polynomial import primitive, reduced_roots
from rankdrop.algebra.roots import ROOTS


@pytest.mark.parametrize(
    ("text", "count"),
    [("x**2 - 2", 2), ("x**2 - 7", 1), ("8*x**2 - 5 - sqrt5", 2), ("x**2 - 3*a**2", 2), ("x**2 + 2*y**2", 1),
     ("x**4 - 10*x**2 + 1", 4), ("(x - sqrt2)**2 * (x + sqrt2)", 2), ("x**2 - sqrt2*sqrt3", 1),
     ("x*y + sqrt2*x + sqrt3*y + sqrt2*sqrt3", 2), ("(x**2 + y**2 + sqrt2)**2", 1)],
)  # fmt: skip
def test_known_factors(text: str, count: int) -> None:
    names = {"x": RING.t[1], "y": RING.t[2], "a": RING.letter_half["a"], **{w: RING.letter_half[w] for w in ROOTS}}
    assert len(factor(reduced_roots(eval(text, {}, names)))) == count


def test_multiplicities_are_those_of_the_product() -> None:
    x, y, h = RING.t[1], RING.t[2], RING.letter_half
    f = (x * y + h["sqrt2"]) ** 3 * (x - h["sqrt3"] * y) ** 2 * (x + y + 1)
    assert sorted(power for _, power in factor(reduced_roots(f))) == [1, 2, 3]


def test_zero_in_the_disguise_of_a_root_is_not_factored_for_ever() -> None:
    """(√3² − 3)(x² − 1)(y² − 1): every factor divides it again and again."""
    x, y, h = RING.t[1], RING.t[2], RING.letter_half
    with pytest.raises(ArithmeticError, match="zero"):
        factor((h["sqrt3"] ** 2 - 3) * (x**2 - 1) * (y**2 - 1))


def test_slices_prove_a_long_polynomial_irreducible(monkeypatch: pytest.MonkeyPatch) -> None:
    """No norm is factored for it: that takes some twenty times as long."""
    monkeypatch.setattr(factoring, "_split", None)
    f = long_polynomial(1)
    assert factor(f) == [(primitive(f), 1)]


@pytest.mark.parametrize("place", range(4))
def test_slices_find_no_product_irreducible(place: int) -> None:
    """Not even one with a factor in a single variable, which is a number on every slice without that variable."""
    x, y, a, w = RING.t[1], RING.t[2], RING.letter_half["a"], RING.letter_half["sqrt2"]
    factors = (x + w, y - 3 * w, a**2 + w, x * y + a * w)
    f = reduced_roots(long_polynomial(2, 20) * factors[place])
    assert not factoring._slices_irreducible(f)
    assert len(factor(f)) == 2


def test_a_long_polynomial_without_roots_is_irreducible_on_slices_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """The factors of one minor of a general arm of seven joints take flint 11 s; of one that is alike 0.1 s."""
    calls: list[int] = []
    slices = factoring._slices_irreducible

    def counted(f: Any) -> bool:
        calls.append(len(f))
        return slices(f)

    monkeypatch.setattr(factoring, "_slices_irreducible", counted)
    x, y, a = RING.t[1], RING.t[2], RING.letter_half["a"]
    f = (x + 2 * y + 3 * a + 1) ** 15 + x * y + 7
    assert factor(f) == [(primitive(f), 1)]
    assert calls == [len(f)]
    g = f * (x * y + a + 5)
    assert {str(one) for one, _ in factor(g)} == {str(primitive(one)) for one in (f, x * y + a + 5)}


def test_a_factor_that_is_a_number_modulo_the_primes_is_no_number() -> None:
    """Its slices have lower degrees than it, and are not taken."""
    x, y, a, w = RING.t[1], RING.t[2], RING.letter_half["a"], RING.letter_half["sqrt2"]
    large = prod(factoring._SMALL)
    f = reduced_roots((x * y + a * w + 1) * (large * (x + y + a) + 1))
    assert not factoring._slices_irreducible(f)
    assert len(factor(f)) == 2


def test_variables_that_divide_a_polynomial_are_factors_and_roots_are_not() -> None:
    x, y, a, w = RING.t[1], RING.t[2], RING.letter_half["a"], RING.letter_half["sqrt2"]
    found = {str(one): power for one, power in factor(reduced_roots(w * a * x**3 * (x + w * y + 1)))}
    assert found == {str(a): 1, str(x): 3, str(primitive(x + w * y + 1)): 1}


def test_factors_without_a_variable_are_split_off_and_counted() -> None:
    x, y, w = RING.t[1], RING.t[2], RING.letter_half["sqrt2"]
    whole = reduced_roots((x - w) ** 3 * (x * y + w * y + 1) * (y**2 + w))
    assert sorted(power for _, power in factor(whole)) == [1, 1, 3]
