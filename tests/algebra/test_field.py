"""Numbers modulo primes, and the roots that exist there."""

from __future__ import annotations

from itertools import combinations

import pytest

from rankdrop.algebra.field import PRIMES, ModularPoint, P, modulo, roots_at, value_at
from rankdrop.algebra.polynomial import flint, reduced_roots
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.roots import FURTHER, ROOTS, primes_with, residues_of_roots


def test_roots_exist_modulo_their_primes() -> None:
    for names in combinations(ROOTS, 2):
        ring = Ring([1], letters=names)
        for prime in ring.primes:
            point = ModularPoint(roots_at(ring, prime), prime)
            assert all(value_at(ring, w * w - reduced_roots(w * w), point) == 0 for w in ring.letter_half.values())
        assert len(primes_with(names)) >= 12
    assert primes_with(()) == PRIMES
    assert residues_of_roots(("cos18", "sqrt5"), PRIMES[3]) is None


def test_all_primes_have_the_small_roots_and_none_has_that_of_minus_one() -> None:
    every = (*PRIMES, *FURTHER)
    assert list(every) == sorted({*every}, reverse=True)
    for p in every:
        assert pow(2, p - 1, p) == 1
        assert p % 120 in (71, 119)
        assert all(pow(q, (p - 1) // 2, p) == 1 for q in (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43))


@pytest.mark.parametrize("bottom", [1, 2, 3, 10, 2**40])
def test_a_rational_number_modulo_a_prime_times_its_denominator_is_its_numerator(bottom: int) -> None:
    assert modulo(flint().fmpq(7, bottom)) * bottom % P == 7
