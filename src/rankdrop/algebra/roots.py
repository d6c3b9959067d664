"""Numbers over √2, √3, √5 and cos 18°: values, powers in many bits, cosines of multiples of 15° and 18°, residues.

Polynomials have a variable for each root that occurs; `reduced_roots` of `algebra/polynomial.py` lowers its powers.
"""

from __future__ import annotations

from collections.abc import Container, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from itertools import product
from math import isqrt, lcm, prod
from typing import TypeVar

_BELOW = (
    11_913, 636_873, 2_465_193, 5_454_201, 7_198_593, 8_757_921, 9_646_521, 10_176_081, 10_526_961, 11_201_481,
    12_427_041, 14_400_441, 16_867_161, 21_450_993, 22_957_953, 25_261_473, 25_265_841, 25_306_761, 26_721_321,
    26_768_241, 27_325_953, 30_620_601, 31_134_561, 34_449_873, 34_751_601, 35_367_513, 40_584_753, 40_940_841,
    42_313_113, 45_697_833, 46_343_121, 47_089_353,
)  # fmt: skip
PRIMES = tuple((1 << 61) - below for below in _BELOW)
"""The largest primes below 2^61 modulo which all primes up to 43 are squares and −1 is not."""
_FURTHER_BELOW = (
    47_235_633, 49_741_521, 50_120_913, 51_894_321, 53_335_881, 53_929_593, 54_180_153, 58_655_481, 60_071_913,
    60_775_473, 61_708_401, 62_398_881, 63_656_193, 64_022_601, 64_888_401, 65_153_913, 65_273_961, 67_788_633,
    70_183_593, 73_017_753, 73_904_793, 74_588_961, 74_944_041, 75_290_361, 76_172_121, 76_706_241, 77_050_473,
    79_309_521, 81_901_761, 84_248_721, 87_376_041, 87_808_713, 89_282_673, 89_711_913, 90_008_673, 90_125_361,
    90_830_361, 90_920_913, 93_289_353, 98_588_361, 99_684_393, 100_879_713, 101_590_401, 102_864_633, 102_880_641,
    104_895_753, 105_208_953, 105_256_833, 106_700_313, 112_003_833, 112_622_121, 112_994_361, 113_009_721,
    114_540_873, 117_920_193, 120_501_321, 120_655_161, 124_025_121, 125_720_073, 126_693_633, 126_738_513,
    130_842_081, 131_634_873, 133_680_033,
)  # fmt: skip
FURTHER = tuple((1 << 61) - below for below in _FURTHER_BELOW)
"""The next ones: tried where roots of other numbers exist modulo none of `PRIMES`."""

SQUARES: dict[str, dict[tuple[str, ...], Fraction]] = {
    "cos18": {(): Fraction(5, 8), ("sqrt5",): Fraction(1, 8)},
    "sqrt2": {(): Fraction(2)},
    "sqrt3": {(): Fraction(3)},
    "sqrt5": {(): Fraction(5)},
}
ROOTS = tuple(SQUARES)
"""Names of the roots, in the order of their variables: a root comes before those in its square."""
WRITTEN = {"cos18": "cos 18°", "sqrt2": "√2", "sqrt3": "√3", "sqrt5": "√5"}
"""The roots as people write them."""
_ROOTS_BITS = 16  # of powers of roots, and of the whole numbers that they are divided by
_DIGITS = 10**60  # of the rational that stands for a root where a sign is asked for

Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True)
class Surd:
    """An irrational number Σ c · Π roots.

    Attributes:
        terms: (names of different roots, rational) in order.
    """

    terms: tuple[tuple[tuple[str, ...], Fraction], ...]

    def __float__(self) -> float:
        return float(sum(value * prod(map(approximation, names)) for names, value in self.terms))

    def __mul__(self, factor: Fraction | int) -> Surd:
        return Surd(tuple((names, value * factor) for names, value in self.terms))

    def __bool__(self) -> bool:
        return True

    def __neg__(self) -> Surd:
        return self * -1


Number = Fraction | Surd
"""An exact number."""


def roots_of(numbers: Sequence[Number]) -> list[str]:
    """Names of the roots in numbers, and of those in their squares, in the order of `ROOTS`."""
    irrational = [number for number in numbers if isinstance(number, Surd)]
    return with_inner({name for number in irrational for names, _ in number.terms for name in names})


def with_inner(names: Container[str]) -> list[str]:
    """Those of some names that are roots, and the roots in their squares, in the order of `ROOTS`."""
    used = {name for name in ROOTS if name in names}
    used |= {name for root in used for inner in SQUARES[root] for name in inner}
    return [name for name in ROOTS if name in used]


@cache
def approximation(name: str) -> Fraction:
    """The positive value of a root, to sixty digits."""
    square = sum(value * prod(map(approximation, names)) for names, value in SQUARES[name].items())
    return Fraction(isqrt(int(square * _DIGITS**2)), _DIGITS)


@lru_cache(maxsize=64)
def _in_bits(name: str, bits: int) -> int:
    """The positive value of a root times 2^bits, rounded down."""
    square = Fraction(0)
    for names, value in SQUARES[name].items():
        square += value * prod(Fraction(_in_bits(inner, bits), 1 << bits) for inner in names)
    return isqrt(int(square * (1 << 2 * bits)))


def _times_roots(value: int, powers: Sequence[tuple[str, int]], bits: int) -> int:
    """value · Π w^e, in units of 2^−bits."""
    for name, power in powers:
        for _ in range(power):
            value = value * _in_bits(name, bits) >> bits
    return value


def sums_over_roots(terms: Iterable[tuple[Key, Fraction, Sequence[tuple[str, int]]]]) -> dict[Key, Fraction]:
    """Σ c · Π w^e of all terms (key, c, powers e of roots w) with the same key, each to 64 bits of itself.

    In floats a − b √3 with a² ≈ 3 b² ≈ 10^80 keeps no digit. A sum of D conjugates below 2^size, its coefficients
    whole, is 0 or above 2^(−(D−1)·size): so many bits are taken.
    """
    gathered = list(terms)
    bottom = lcm(*(number.denominator for _, number, _ in gathered))
    whole = [number.numerator * (bottom // number.denominator) for _, number, _ in gathered]
    names = set().union(*(dict(powers) for _, _, powers in gathered))
    size = max(map(abs, whole), default=0).bit_length() + len(gathered).bit_length() + _ROOTS_BITS
    bits = 64 + 2 ** len(with_inner(names)) * size
    totals: dict[Key, int] = {}
    for (key, _, powers), number in zip(gathered, whole, strict=True):
        totals[key] = totals.get(key, 0) + _times_roots(number << bits, powers, bits)
    for key, value in totals.items():
        if abs(value) >> size == 0:  # what rounding leaves
            totals[key] = 0
    return {key: Fraction(value, bottom << bits) for key, value in totals.items()}


def root_values(names: Iterable[str]) -> dict[str, float]:
    """The positive values of roots."""
    return {name: float(approximation(name)) for name in names}


def surd(angle: int) -> tuple[Number, Number]:
    """(cos, sin) of an angle in degrees: a multiple of 15 or 18, between 0 and 90.

    Example:
        >>> surd(45)[0].terms
        ((('sqrt2',), Fraction(1, 2)),)
    """
    return _cosine(angle), _cosine(90 - angle)


def _cosine(angle: int) -> Number:
    """cos of 15, 18, 30, 36 … degrees."""
    quarter, half = Fraction(1, 4), Fraction(1, 2)
    terms: dict[int, tuple[tuple[tuple[str, ...], Fraction], ...]] = {
        0: (((), Fraction(1)),), 60: (((), half),), 90: (),
        15: ((("sqrt2",), quarter), (("sqrt2", "sqrt3"), quarter)),
        75: ((("sqrt2",), -quarter), (("sqrt2", "sqrt3"), quarter)),
        30: ((("sqrt3",), half),), 45: ((("sqrt2",), half),),
        36: (((), quarter), (("sqrt5",), quarter)), 72: (((), -quarter), (("sqrt5",), quarter)),
        18: ((("cos18",), Fraction(1)),), 54: ((("cos18",), -half), (("cos18", "sqrt5"), half)),
    }  # fmt: skip
    cosine = terms[angle]
    if any(names for names, _ in cosine):
        return Surd(cosine)
    return sum((value for _, value in cosine), Fraction(0))


@lru_cache
def residues_of_roots(names: tuple[str, ...], prime: int) -> dict[str, int] | None:
    """Values of roots, and of those in their squares, modulo a prime; None where one of them does not exist."""
    return next(iter(embeddings(tuple(with_inner(names)), prime)), None)


def embeddings(names: tuple[str, ...], prime: int) -> Iterator[dict[str, int]]:
    """The values of roots modulo a prime p ≡ 3 mod 4 for every choice of signs."""
    for signs in product((1, -1), repeat=len(names)):
        values: dict[str, int] = {}
        for name, sign in reversed(list(zip(names, signs, strict=True))):
            square = sum(
                value.numerator * pow(value.denominator, -1, prime) * prod(values[root] for root in inner)
                for inner, value in SQUARES[name].items()
            )
            root = pow(square % prime, (prime + 1) // 4, prime)
            if (root * root - square) % prime:
                return
            values[name] = sign * root % prime
        yield values


@lru_cache
def primes_with(names: tuple[str, ...], primes: tuple[int, ...] = PRIMES) -> tuple[int, ...]:
    """The primes modulo which roots exist."""
    return tuple(prime for prime in primes if residues_of_roots(names, prime) is not None)


def rational_square(name: str) -> Fraction | None:
    """The square of a root where that is a rational number; None where it is not, and for what is no root."""
    square = SQUARES.get(name, {})
    if square.keys() == {()}:
        return square[()]
    return None
