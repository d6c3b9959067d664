"""Common divisors and quotients of polynomials, and their images modulo primes."""

from __future__ import annotations

import pytest
from algebra.number_fields import RING
from algebra.polynomials import long_polynomial

from rankdrop.algebra import field
from rankdrop.algebra.field import ModularPoint, roots_at, value_at
from rankdrop.algebra.gcd import _Images, gcd, image_modulo, quotient
from rankdrop.algebra.polynomial import flint, is_number, primitive, reduced_roots
from rankdrop.algebra.roots import ROOTS, embeddings, primes_with


def test_images_read_once_are_those_of_the_polynomial() -> None:
    f = long_polynomial(3) * flint().fmpq(2, 15)
    images = _Images(f)
    for prime in primes_with(ROOTS)[:2]:
        for roots in embeddings(ROOTS, prime):
            assert images.with_roots(roots, prime) == image_modulo(f, roots, prime)


def test_values_before_and_after_an_image_is_made_are_the_same() -> None:
    f = long_polynomial(4) * flint().fmpq(3, 7)
    for prime in primes_with(ROOTS)[:2]:
        point = ModularPoint({name: 5 + place for place, name in enumerate(RING.names)}, prime)
        point.update(roots_at(RING, prime))
        values = {value_at(RING, f, point) for _ in range(field._SEEN)}
        uses = RING.images[id(f), prime]
        assert isinstance(uses, field.Uses)
        assert uses.f is f  # an id is that of a polynomial that is kept
        image = image_modulo(f, point, prime)
        assert {*values, value_at(RING, f, point)} == {int(image(*[0] * len(RING.names)))}
        assert not isinstance(RING.images[id(f), prime], field.Uses)


def test_a_common_divisor_over_the_roots() -> None:
    x, w = RING.t[1], RING.letter_half["sqrt2"]
    assert gcd(x**2 - 2, reduced_roots((x - w) * (x + 3))) == primitive(x - w)
    assert is_number(gcd(x - w, x + w))


@pytest.mark.slow
def test_common_divisors_and_quotients_with_coefficients_of_thousands_of_bits() -> None:
    x, y, w = RING.t[1], RING.t[2], RING.letter_half["sqrt2"]
    long = x + (3**1500) * w * y + 7**1000
    f, g = reduced_roots(long * (x - w * y)), reduced_roots(long * (y + 3 * w))
    assert gcd(f, g) == primitive(long)
    assert quotient(f, primitive(long)) is not None
    assert quotient(f, x + y + w) is None
