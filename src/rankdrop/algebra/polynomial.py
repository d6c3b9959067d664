"""Polynomials over the rationals and over some square roots, by python-flint, and the irreducible conditions they are.

python-flint is asked for only where it is used. An irreducible condition is a joint at a simple angle, or a polynomial
in half-angle tangents = 0.

Twists of 15° and 18° and their multiples are rounded nowhere. A ring over ℚ(√2, √3, √5, cos 18°) is one over ℚ with a
variable for each root w, reduced by w² = r. A product of such polynomials is reduced again; division, common divisors
and factors go through the norm Π σ(f), the product over all choices of signs of the roots, which has rational
coefficients (Trager). Polynomials without roots take the plain way.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Container, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache, reduce
from itertools import islice, product
from math import gcd as whole_gcd
from math import isqrt, lcm, prod
from types import ModuleType
from typing import Any, NamedTuple, TypeVar

from rankdrop.algebra.halt import Halt, HaltKind, TooLong
from rankdrop.algebra.matrix import entries
from rankdrop.errors import MissingExtraError
from rankdrop.lists import flat_map

_watching: list[Callable[[], None]] = []


@contextmanager
def watched(check: Callable[[], None]) -> Iterator[None]:
    """Until the end of the block the loops of this file call `check`, which raises `OutOfTime` at a limit."""
    _watching.append(check)
    try:
        yield
    finally:
        _watching.pop()


def _look() -> None:
    """Stop where the limit of the derivation in progress has passed: called in every loop that may be long."""
    if _watching:
        _watching[-1]()


Polynomial = Any
"""A `flint.fmpq_mpoly`; which ring it lives in is said where the name is used."""


def flint() -> ModuleType:
    """The module `flint`.

    Raises:
        MissingExtraError: python-flint is not installed.
    """
    try:
        import flint as module
    except ImportError as error:
        raise MissingExtraError("python-flint", None, "deriving exact conditions") from error
    return module


def used(f: Polynomial) -> list[int]:
    """Places of the variables that occur in f."""
    return [place for place, degree in enumerate(f.degrees()) if degree > 0]


def used_by(polynomials: Iterable[Polynomial]) -> set[int]:
    """Places of the variables that occur in any of them."""
    return set(flat_map(used, polynomials))


def coefficients(f: Polynomial, place: int) -> list[Polynomial]:
    """f as a polynomial in one variable: coefficients from power 0 up."""
    context = f.context()
    parts: dict[int, dict[tuple[int, ...], Any]] = {}
    for e, value in f.terms():
        parts.setdefault(e[place], {})[(*e[:place], 0, *e[place + 1 :])] = value
    return [context.from_dict(parts.get(power, {})) for power in range(max(parts, default=0) + 1)]


def coefficient(f: Polynomial, place: int, power: int) -> Polynomial:
    """The one of `coefficients` at one power."""
    found = {(*e[:place], 0, *e[place + 1 :]): value for e, value in f.terms() if e[place] == power}
    return f.context().from_dict(found)


SIMPLE = ("0", "pi", "pi/2", "-pi/2")
"""Angles a revolute joint can be pinned at: tan(θ/2) = 0, ∞, 1, −1."""
COS_SIN = {"0": (1, 0), "pi": (-1, 0), "pi/2": (0, 1), "-pi/2": (0, -1)}
"""(cos, sin) there."""
TANGENT = {"0": 0, "pi/2": 1, "-pi/2": -1}
"""tan(θ/2) there; infinite at π."""


@dataclass(frozen=True)
class Atom:
    """One irreducible condition: joint `joint` stands at `value`, or the polynomial `f` vanishes.

    Attributes:
        joint: number of a revolute joint that is pinned; 0 where `f` holds the condition.
        value: one of `SIMPLE`; "" where `f` holds the condition.
        f: irreducible primitive polynomial of the half-angle ring; None for a pinned joint.
        key: text that is the same for equal atoms; equality and hash are its.
    """

    joint: int
    value: str
    f: Polynomial
    key: str

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Atom) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    @property
    def pinned(self) -> bool:
        """Whether the condition is one joint at a simple angle."""
        return self.f is None

    @property
    def weight(self) -> int:
        """How long the condition is: 1 for a pinned joint, else 2 + number of terms."""
        if self.f is None:
            return 1
        return 2 + len(self.f)


class Factors(NamedTuple):
    """A polynomial on the torus, taken apart.

    Attributes:
        letters: factors in lengths alone, with multiplicities: they vanish for special arms only.
        atoms: factors that depend on the configuration, with multiplicities.
    """

    letters: tuple[tuple[Polynomial, int], ...]
    atoms: tuple[tuple[Atom, int], ...]


@dataclass(frozen=True)
class Equality:
    """One polynomial that vanishes, or, in a list of what does not, one that does not.

    Attributes:
        atoms: its irreducible factors: it vanishes where one of them does; empty where it was not factored.
        whole: the trigonometric polynomial itself; None where the atoms say it.
    """

    atoms: tuple[Atom, ...]
    whole: Polynomial | None = None

    @property
    def terms(self) -> int:
        """Number of terms: of `whole`, or of all atoms together."""
        if self.whole is not None:
            return len(self.whole)
        return sum(1 if atom.f is None else len(atom.f) for atom in self.atoms)


def order(atom: Atom) -> tuple[Any, ...]:
    """Sort key of atoms: pinned joints by number and value, then polynomials by length."""
    if atom.pinned:
        return (0, atom.joint, SIMPLE.index(atom.value), "")
    return (1, len(atom.f), 0, atom.key)


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

_SQUARES: dict[str, dict[tuple[str, ...], Fraction]] = {
    "cos18": {(): Fraction(5, 8), ("sqrt5",): Fraction(1, 8)},
    "sqrt2": {(): Fraction(2)},
    "sqrt3": {(): Fraction(3)},
    "sqrt5": {(): Fraction(5)},
}
ROOTS = tuple(_SQUARES)
"""Names of the roots, in the order of their variables: a root comes before those in its square."""
WRITTEN = {"cos18": "cos 18°", "sqrt2": "√2", "sqrt3": "√3", "sqrt5": "√5"}
"""The roots as people write them."""
_ROOTS_BITS = 16  # of powers of roots, and of the whole numbers that they are divided by
_DIGITS = 10**60  # of the rational that stands for a root where a sign is asked for


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
    return with_inner({name for one in numbers if isinstance(one, Surd) for names, _ in one.terms for name in names})


def with_inner(names: Container[str]) -> list[str]:
    """Those of some names that are roots, and the roots in their squares, in the order of `ROOTS`."""
    used = {name for name in ROOTS if name in names}
    used |= {name for root in used for inner in _SQUARES[root] for name in inner}
    return [name for name in ROOTS if name in used]


@cache
def approximation(name: str) -> Fraction:
    """The positive value of a root, to sixty digits."""
    square = sum(value * prod(map(approximation, names)) for names, value in _SQUARES[name].items())
    return Fraction(isqrt(int(square * _DIGITS**2)), _DIGITS)


@lru_cache(maxsize=64)
def _in_bits(name: str, bits: int) -> int:
    """The positive value of a root times 2^bits, rounded down."""
    square = Fraction(0)
    for names, value in _SQUARES[name].items():
        square += value * prod(Fraction(_in_bits(inner, bits), 1 << bits) for inner in names)
    return isqrt(int(square * (1 << 2 * bits)))


def _times_roots(value: int, powers: Sequence[tuple[str, int]], bits: int) -> int:
    """value · Π w^e, in units of 2^−bits."""
    for name, power in powers:
        for _ in range(power):
            value = value * _in_bits(name, bits) >> bits
    return value


Key = TypeVar("Key", bound=Hashable)


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
    found = terms[angle]
    if any(names for names, _ in found):
        return Surd(found)
    return sum((value for _, value in found), Fraction(0))


@lru_cache
def residues_of_roots(names: tuple[str, ...], prime: int) -> dict[str, int] | None:
    """Values of roots, and of those in their squares, modulo a prime; None where one of them does not exist."""
    return next(iter(_embeddings(tuple(with_inner(names)), prime)), None)


def _embeddings(names: tuple[str, ...], prime: int) -> Iterator[dict[str, int]]:
    """The values of roots modulo a prime p ≡ 3 mod 4 for every choice of signs."""
    for signs in product((1, -1), repeat=len(names)):
        values: dict[str, int] = {}
        for name, sign in reversed(list(zip(names, signs, strict=True))):
            square = sum(
                value.numerator * pow(value.denominator, -1, prime) * prod(values[one] for one in inner)
                for inner, value in _SQUARES[name].items()
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


def roots_in(f: Polynomial) -> tuple[str, ...]:
    """Names of the roots among the variables of a polynomial."""
    return tuple(name for name in _names(f.context()) if name in _SQUARES)


@lru_cache
def _names(context: Any) -> tuple[str, ...]:
    return tuple(map(str, context.names()))


@lru_cache
def _relations(context: Any) -> tuple[tuple[int, Polynomial], ...]:
    """(place, w² − r) of every root among the variables."""
    names = _names(context)
    made = dict(zip(names, context.gens(), strict=True))

    def value(terms: Mapping[tuple[str, ...], Fraction]) -> Polynomial:
        parts = (flint().fmpq(c.numerator, c.denominator) * prod(made[one] for one in inner)
                 for inner, c in terms.items())  # fmt: skip
        return sum(parts, context.constant(0))

    return tuple((k, made[name] ** 2 - value(_SQUARES[name])) for k, name in enumerate(names) if name in _SQUARES)


def reduced_roots(f: Polynomial) -> Polynomial:
    """f with every root at most once in a term."""
    for place, relation in _relations(f.context()):
        if f.degrees()[place] > 1:
            f = f % relation
    return f


def _conjugate(f: Polynomial, place: int) -> Polynomial:
    return f.context().from_dict({e: -c if e[place] % 2 else c for e, c in f.terms()})


def norm(f: Polynomial) -> tuple[Polynomial, Polynomial]:
    """(norm, cofactor): the product of f with its conjugates, and that of the conjugates alone; norm = f · cofactor."""
    cofactor = f.context().constant(1)
    for place, _ in _relations(f.context()):
        if f.degrees()[place]:
            _look()
            other = _conjugate(f, place)
            cofactor, f = reduced_roots(cofactor * other), reduced_roots(f * other)
    return f, cofactor


def leading_number(f: Polynomial) -> Polynomial:
    """The number in front of the first power product of f, which is not 0: a polynomial in the roots alone."""
    places = [place for place, _ in _relations(f.context())]
    first = [e for place, e in enumerate(next(iter(f.monoms()))) if place not in places]
    leading = {}
    for powers, value in f.terms():  # lexicographic, the roots last: these terms come first
        if [e for place, e in enumerate(powers) if place not in places] != first:
            break
        leading[tuple(e if place in places else 0 for place, e in enumerate(powers))] = value
    return f.context().from_dict(leading)


def number_value(number: Polynomial) -> Fraction:
    """The value of a polynomial in the roots alone, to some sixty digits.

    Example:
        >>> root = flint().fmpq_mpoly_ctx.get(["sqrt2"], flint().Ordering.lex).gens()[0]
        >>> round(float(number_value(1 - root)), 6)
        -0.414214
    """
    value = Fraction(0)
    for powers, part in number.terms():
        names = zip(_names(number.context()), powers, strict=True)
        value += Fraction(int(part.p), int(part.q)) * prod(approximation(name) ** int(e) for name, e in names if e)
    return value


def rational_square(name: str) -> Fraction | None:
    """The square of a root where that is a rational number; None where it is not, and for what is no root."""
    square = _SQUARES.get(name, {})
    if square.keys() == {()}:
        return square[()]
    return None


def monic(f: Polynomial) -> Polynomial:
    """f divided by the number in front of its first power product, where that has a root in it."""
    if f == 0 or not _relations(f.context()):
        return f
    number = leading_number(f)
    if number.is_constant():
        return f
    return reduced_roots(f * norm(number)[1])


def primitive(f: Polynomial) -> Polynomial:
    """f times a number, with whole coprime coefficients, the first one positive and rational."""
    f = monic(f)
    values = f.coeffs()
    if not values:
        return f
    top, bottom = 0, 1
    for value in values:
        top, bottom = whole_gcd(top, int(value.p)), lcm(bottom, int(value.q))
    return f * flint().fmpq(bottom, -top if values[0] < 0 else top)


def reciprocal(number: Polynomial) -> Polynomial:
    """1 / number, for a polynomial without other variables than roots."""
    bottom, cofactor = norm(number)
    return cofactor / bottom.coeffs()[0]


def is_number(f: Polynomial) -> bool:
    """Whether no variable but roots occurs."""
    places = {place for place, _ in _relations(f.context())}
    return all(place in places for place, degree in enumerate(f.degrees()) if degree > 0)


def quotient(f: Polynomial, g: Polynomial) -> Polynomial | None:
    """f / g; None where g does not divide f. Over the roots from images modulo primes, tested modulo one more.

    Raises:
        TooLong: the primes do not suffice for its coefficients.
    """
    if not any(g.degrees()[place] for place, _ in _relations(g.context())):
        return _exact(f, g)
    return _from_images(f, g, _exact, lambda h, f, g: h * g == f)


def _exact(f: Polynomial, g: Polynomial) -> Polynomial | None:
    result, rest = divmod(f, g)
    return result if rest == 0 else None


def divides(h: Polynomial, f: Polynomial) -> bool:
    """Whether a polynomial divides another one that is not 0; over the roots modulo a prime of 61 bits."""
    if f == 0:
        return False
    if roots_in(f):
        f, prime = _image(f)
        h, _ = _image(h, prime)
    return bool(divmod(f, h)[1] == 0)


def gcd(f: Polynomial, g: Polynomial) -> Polynomial:
    """A greatest common divisor: over the roots from its images modulo primes, tested modulo one more.

    Raises:
        TooLong: the primes do not suffice for its coefficients.
    """
    _look()
    if not (roots_in(f) and f != 0 and g != 0):
        return f.gcd(g)
    found = _from_images(f, g, _common, lambda h, f, g: divmod(f, h)[1] == 0 and divmod(g, h)[1] == 0)
    if found is None:
        return f.context().constant(1)
    return primitive(found)


def _common(f: Polynomial, g: Polynomial) -> Polynomial | None:
    common = f.gcd(g)
    if common.is_constant():
        return None
    return common


_LIFTED = 256  # primes, for coefficients of 8,000 bits


def _lifting(names: tuple[str, ...]) -> Iterator[int]:
    """Primes modulo which roots exist: all of `primes_with` but the last, then those below `PRIMES`."""
    known = primes_with(names)[:-1]
    yield from known
    below = (p for p in range(PRIMES[-1] - 4, 0, -4) if flint().fmpz(p).is_prime())
    further = (p for p in below if residues_of_roots(names, p) is not None)
    yield from islice(further, _LIFTED - len(known))


Combine = Callable[[Polynomial, Polynomial], Polynomial | None]


def _from_images(
    f: Polynomial, g: Polynomial, combine: Combine, holds: Callable[[Polynomial, Polynomial, Polynomial], bool]
) -> Polynomial | None:
    """What two polynomials over the roots are combined into, from its images modulo primes; None where one has none.

    Args:
        f, g: the polynomials.
        combine: their images, for one choice of signs of the roots.
        holds: whether an image of the result is right for those of both, modulo a prime that it was not made from.
    """
    names = roots_in(f)
    last = primes_with(names)[-1]
    both = (_Images(f), _Images(g))
    there = [one.at(residues_of_roots(names, last) or {}, last) for one in both]
    known: dict[tuple[int, ...], int] = {}
    modulus = 1
    for number, prime in enumerate(_lifting(names), 1):
        _look()
        image = _combined(both, names, prime, combine)
        if image is None:
            return None
        step = pow(modulus, -1, prime)
        known = {e: (a := known.get(e, 0)) + modulus * ((image.get(e, 0) - a) * step % prime)
                 for e in {*known, *image}}  # fmt: skip
        modulus *= prime
        if number < 8 or number % 8 == 0:
            found = _rational(known, modulus, f.context())
        else:
            found = None
        if found is not None and holds(_image(found, last)[0], *there):
            return found
    raise TooLong(Halt(HaltKind.COEFFICIENTS))


def _combined(
    images_of: tuple[_Images, _Images], names: tuple[str, ...], prime: int, combine: Combine
) -> dict[tuple[int, ...], int] | None:
    """Coefficients modulo a prime of the combination of two polynomials, by the powers of all variables."""
    f, g = images_of
    places = f.root_places
    basis = list(product((0, 1), repeat=len(places)))
    choices, images = list(_embeddings(names, prime)), []
    for choice in choices:
        _look()
        both = combine(f.at(choice, prime), g.at(choice, prime))
        if both is None:
            return None
        images.append({tuple(map(int, e)): int(c) for e, c in both.to_dict().items()})
    rows = [[prod(choice[name] ** e for name, e in zip(names, powers, strict=True)) % prime for powers in basis]
            for choice in choices]  # fmt: skip
    inverse = flint().nmod_mat(len(rows), len(rows), entries(rows), prime).inv().tolist()
    result: dict[tuple[int, ...], int] = {}
    for e in set(entries(images)):
        values = [image.get(e, 0) for image in images]
        for powers, row in zip(basis, inverse, strict=True):
            value = sum(int(x) * y for x, y in zip(row, values, strict=True)) % prime
            if value:
                whole = list(e)
                for place, power in zip(places, powers, strict=True):
                    whole[place] = power
                result[tuple(whole)] = value
    return result


def image_modulo(f: Polynomial, values: Mapping[str, int], prime: int) -> Polynomial:
    """f modulo a prime with values for some variables (`flint.nmod_mpoly` in the same variables).

    Values of the last variables (roots) are put in term by term: fewer terms are converted, which takes most of the
    time.
    """
    module, names = flint(), _names(f.context())
    context = module.nmod_mpoly_ctx.get(list(names), prime, module.Ordering.lex)
    first = len(names)
    while first and names[first - 1] in values:
        first -= 1
    zeros = (0,) * (len(names) - first)
    shares: dict[tuple[int, ...], int] = {}
    terms: dict[tuple[int, ...], int] = {}
    for powers, number in zip(f.monoms(), f.coeffs(), strict=True):
        value = int(number.p) % prime
        if number.q != 1:
            value = value * pow(int(number.q), -1, prime) % prime
        tail = powers[first:]
        share = shares.get(tail)
        if share is None:
            share = prod(pow(values[name], int(e), prime) for name, e in zip(names[first:], tail, strict=True)) % prime
            shares[tail] = share
        key = powers[:first] + zeros
        terms[key] = (terms.get(key, 0) + value * share) % prime
    before = {name: value for name, value in values.items() if name in names[:first]}
    image = context.from_dict({powers: value for powers, value in terms.items() if value})
    if before:
        return image.subs(before)
    return image


class _Images:
    """Images of a polynomial over the roots modulo primes: its terms are read once, and converted once for a prime.

    Args:
        f: the polynomial, Σ w^e · f_e with powers w^e of the roots and rational f_e.
    """

    def __init__(self, f: Polynomial) -> None:
        self._names = _names(f.context())
        self._first = len(self._names) - len(_relations(f.context()))
        zeros = (0,) * (len(self._names) - self._first)
        values = f.coeffs()
        self._bottom = lcm(*(int(value.q) for value in values))
        self._parts: dict[tuple[int, ...], dict[tuple[int, ...], int]] = {}
        for powers, value in zip(f.monoms(), values, strict=True):
            whole = int(value.p) * (self._bottom // int(value.q))
            self._parts.setdefault(powers[self._first :], {})[powers[: self._first] + zeros] = whole
        self._prime = 0
        self._images: list[tuple[tuple[int, ...], Polynomial]] = []

    @property
    def root_places(self) -> range:
        """Places of the roots among the variables: the last ones."""
        return range(self._first, len(self._names))

    def at(self, roots: Mapping[str, int], prime: int) -> Polynomial:
        """f modulo a prime for one choice of signs of the roots (`flint.nmod_mpoly` in the same variables)."""
        module = flint()
        context = module.nmod_mpoly_ctx.get(list(self._names), prime, module.Ordering.lex)
        if prime != self._prime:
            self._prime = prime
            self._images = [
                (powers, context.from_dict({e: rest for e, value in part.items() if (rest := value % prime)}))
                for powers, part in self._parts.items()
            ]
        total, inverse = context.constant(0), pow(self._bottom, -1, prime)
        for powers, image in self._images:
            power_of = zip(self._names[self._first :], powers, strict=True)
            share = prod(pow(roots[name], int(e), prime) for name, e in power_of) % prime
            total += image * (share * inverse % prime)
        return total


def _rational(terms: Mapping[tuple[int, ...], int], modulus: int, context: Any) -> Polynomial | None:
    """The polynomial with small rational coefficients that are these modulo a number; None where one is not small."""
    bound, found = isqrt(modulus // 2), {}
    for e, value in terms.items():
        (a, b), (s, t) = (modulus, value % modulus), (0, 1)
        while b > bound:
            a, b, s, t = b, a % b, t, s - a // b * t
        if abs(t) > bound or t == 0:
            return None
        found[e] = flint().fmpq(b if t > 0 else -b, abs(t))
    return context.from_dict(found)


def factor(f: Polynomial) -> list[tuple[Polynomial, int]]:
    """Irreducible factors with their multiplicities; over the roots they are primitive.

    Most long polynomials are irreducible already on slices in two variables, which costs least: flint takes from 0.1 to
    11 s for minors of 3,500 terms that are alike.
    Over the roots a multiplicity is that modulo a prime of 61 bits: the factors are known to divide.
    """
    _look()
    if not roots_in(f):
        if len(f) > _SLICED_FROM and _slices_irreducible(f):
            return [(primitive(f), 1)]
        return [(one, int(power)) for one, power in f.factor()[1]]
    variables, f = _without_variables(f)
    if is_number(f):
        return variables
    if _slices_irreducible(f):
        return [*variables, (primitive(f), 1)]
    return [*variables, *_factors_over_roots(f)]


def _without_variables(f: Polynomial) -> tuple[list[tuple[Polynomial, int]], Polynomial]:
    """The variables, but for roots, that divide a polynomial, with multiplicities, and the polynomial without them."""
    lowest = [min(powers) for powers in zip(*f.monoms(), strict=True)]
    roots = {place for place, _ in _relations(f.context())}
    gens = f.context().gens()
    found = [(gens[place], int(power)) for place, power in enumerate(lowest) if power and place not in roots]
    if not found:
        return [], f
    shared = prod((x**power for x, power in found), start=f.context().constant(1))
    return found, divmod(f, shared)[0]


def _factors_over_roots(f: Polynomial) -> list[tuple[Polynomial, int]]:
    """`factor` of a polynomial with roots that no variable divides."""
    rational = reduce(lambda a, b: a.gcd(b), _components(f))
    pieces = [piece for one, _ in rational.factor()[1] for piece in ([one] if 1 in one.degrees() else _split(one))]
    rest = quotient(f, rational)
    if not is_number(rest):
        pieces += _split(rest)
    distinct = {str(one): one for one in map(primitive, pieces)}.values()
    if len(distinct) == 1:
        piece = next(iter(distinct))
        return [(piece, _degree(f) // _degree(piece))]
    image, prime = _image(f)
    return [(piece, _multiplicity(image, _image(piece, prime)[0], prime)) for piece in distinct]


def _image(f: Polynomial, prime: int = 0) -> tuple[Polynomial, int]:
    """f modulo a prime with its roots, the first one if none is given; and the prime."""
    prime = prime or primes_with(roots_in(f))[0]
    return image_modulo(f, residues_of_roots(roots_in(f), prime) or {}, prime), prime


def _multiplicity(f: Polynomial, g: Polynomial, prime: int) -> int:
    """How often an irreducible g divides f, both modulo a prime of 61 bits: counted on a random line along one axis.

    On a line g meets another factor of f where their resultant is zero: for a share of deg f · deg g / prime of all
    lines. Division by g of all variables, which ends with a long remainder, takes minutes where f has 50,000 terms.
    """
    if f == 0:
        raise ArithmeticError("zero has every factor without end; it is to be noticed before factoring")
    degrees = g.degrees()
    place = min((place for place, degree in enumerate(degrees) if degree), key=lambda place: int(degrees[place]))
    rng = random.Random(_SLICED)
    others = [name for at, name in enumerate(_names(g.context())) if at != place]
    while True:
        values = {name: rng.randrange(prime) for name in others}
        on_line, divisor = f.subs(values), g.subs(values)
        if divisor.degrees()[place] == degrees[place] and on_line != 0:
            break
    power = 0
    while True:
        on_line, rest = divmod(on_line, divisor)
        if rest != 0:
            return power
        power += 1


def _components(f: Polynomial) -> list[Polynomial]:
    """The rational polynomials that the products of roots are multiplied by."""
    places = [place for place, _ in _relations(f.context())]
    parts: dict[tuple[int, ...], dict[tuple[int, ...], Any]] = {}
    for e, value in f.terms():
        rest = tuple(0 if place in places else x for place, x in enumerate(e))
        parts.setdefault(tuple(e[place] for place in places), {})[rest] = value
    return [f.context().from_dict(part) for part in parts.values()]


_SMALL = ((1 << 31) - 249, (1 << 31) - 2289)  # modulo which all roots exist; flint factors by no larger ones
_SHIFTS = 8  # each fails for few polynomials only


def _split(f: Polynomial) -> list[Polynomial]:
    """The different irreducible factors of a polynomial over the roots."""
    if _stays_irreducible(f):
        return [f]
    content = _content(f)
    if content is not None:
        return flat_map(_split, (content, quotient(f, content)))
    for shift in range(_SHIFTS):
        _look()
        turned = _shifted(f, shift)
        found = norm(turned)[0].factor()[1]
        parts = [_shifted(gcd(turned, one), -shift) for one, _ in found]
        if len(found) > 1:
            return flat_map(_split, (part for part in parts if not is_number(part)))
        if found[0][1] == 1 and all(turned.degrees()[place] for place, _ in _relations(f.context())):
            return [f]
        if (root := _squarefree(f)) is not None:
            return _split(root)
    raise TooLong(Halt(HaltKind.NORM))


def _content(f: Polynomial) -> Polynomial | None:
    """A factor without one of the variables of f; None where every factor has them all."""
    roots = {place for place, _ in _relations(f.context())}
    for place in used(f):
        if place in roots:
            continue
        content = f.context().constant(0)
        for part in coefficients(f, place):
            if part != 0:
                content = gcd(content, part)
            else:
                content = content
            if content != 0 and is_number(content):
                break
        if not is_number(content):
            return content
    return None


def _stays_irreducible(f: Polynomial) -> bool:
    """Whether f is irreducible modulo one of two primes, each with the roots; then it is so over them."""
    for prime in _SMALL:
        image = image_modulo(f, residues_of_roots(roots_in(f), prime) or {}, prime)
        if image.total_degree() == _degree(f) and [power for _, power in image.factor()[1]] == [1]:
            return True
    return False


_SLICED = 10_000  # slices are at random whole numbers below this
_SLICED_FROM = 500  # terms from which slices are taken first where there are no roots


def _slices_irreducible(f: Polynomial) -> bool:
    """Whether slices of f in two variables x, y prove it irreducible over the roots, for one x and each other y.

    On each slice the other variables stand at whole numbers, and it is taken modulo a prime with the roots. Let its
    degrees in x and y be those of f. If f = g h, one of g and h has no x and no y where the slice is irreducible. It is
    the same one for each y, the one without x: it is a number.

    Returns:
        False where a slice has factors, which need not be those of f, or f has fewer than three variables.
    """
    roots = {place for place, _ in _relations(f.context())}
    degrees = f.degrees()
    places = [place for place in used(f) if place not in roots]
    if len(places) < 3:
        return False
    x = min(places, key=lambda place: int(degrees[place]))
    rng = random.Random(_SLICED)
    for y in places:
        if y != x and not any(_slice_irreducible(f, x, y, places, prime, rng) for prime in _SMALL):
            return False
    return True


def _slice_irreducible(
    f: Polynomial, x: int, y: int, places: Sequence[int], prime: int, rng: random.Random
) -> bool:
    """Whether f is irreducible modulo a prime, and has its degrees in x and y, on one random slice in x and y."""
    names, degrees = _names(f.context()), f.degrees()
    values = {names[place]: rng.randrange(2, _SLICED) for place in places if place not in (x, y)}
    image = image_modulo(f.subs(values), residues_of_roots(roots_in(f), prime) or {}, prime)
    if image == 0 or any(image.degrees()[place] != degrees[place] for place in (x, y)):
        return False
    return [power for _, power in image.factor()[1]] == [1]


def _degree(f: Polynomial) -> int:
    """Total degree of a polynomial, roots not counted."""
    roots = {place for place, _ in _relations(f.context())}
    return max(sum(int(x) for place, x in enumerate(e) if place not in roots) for e in f.monoms())


def _squarefree(f: Polynomial) -> Polynomial | None:
    """f without repeated factors where it has one; None where it has none in its first variable."""
    name = next(name for name, degree in zip(_names(f.context()), f.degrees(), strict=True) if degree)
    common = gcd(f, f.derivative(name))
    if is_number(common):
        return None
    return quotient(f, common)


def _shifted(f: Polynomial, shift: int) -> Polynomial:
    """f(x + shift · Σ k w_k) for one of its variables: its norm has no square for almost every shift."""
    if shift == 0:
        return f
    gens, relations = f.context().gens(), dict(_relations(f.context()))
    place = next(k for k, degree in enumerate(f.degrees()) if degree and k not in relations)
    step = sum(((2 * k + 1) * gens[w] for k, w in enumerate(relations)), f.context().constant(0)) * shift
    return reduced_roots(f.compose(*(x + step if k == place else x for k, x in enumerate(gens)), ctx=f.context()))

