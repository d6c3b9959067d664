"""Polynomials over the rationals and over some square roots, by python-flint, and the irreducible conditions they are.

python-flint is asked for only where it is used. An irreducible condition is a joint at a simple angle, or a polynomial
in half-angle tangents = 0.

Twists of 15° and 18° and their multiples are rounded nowhere. A ring over ℚ(√2, √3, √5, cos 18°) is one over ℚ with a
variable for each root w, reduced by w² = r. A product of such polynomials is reduced again; division, common divisors
and factors go through the norm Π σ(f), the product over all choices of signs of the roots, which has rational
coefficients (Trager). Polynomials without roots take the plain way."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import gcd as whole_gcd
from math import lcm, prod
from types import ModuleType
from typing import Any, NamedTuple

from rankdrop.algebra.roots import SQUARES, approximation
from rankdrop.errors import MissingExtraError
from rankdrop.lists import flat_map

_watching: list[Callable[[], None]] = []

Polynomial = Any
"""A `flint.fmpq_mpoly`; which ring it lives in is said where the name is used."""

SIMPLE = ("0", "pi", "pi/2", "-pi/2")
"""Angles a revolute joint can be pinned at: tan(θ/2) = 0, ∞, 1, −1."""
COS_SIN = {"0": (1, 0), "pi": (-1, 0), "pi/2": (0, 1), "-pi/2": (0, -1)}
"""(cos, sin) there."""
TANGENT = {"0": 0, "pi/2": 1, "-pi/2": -1}
"""tan(θ/2) there; infinite at π."""


@contextmanager
def calling_in_loops(check: Callable[[], None]) -> Iterator[None]:
    """Until the end of the block the loops of this file call `check`, which raises `OutOfTime` at a limit."""
    _watching.append(check)
    try:
        yield
    finally:
        _watching.pop()


def look() -> None:
    """Stop where the limit of the derivation in progress has passed: called in every loop that may be long."""
    if _watching:
        _watching[-1]()


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


def variables_in(f: Polynomial) -> list[int]:
    """Places of the variables that occur in f."""
    return [place for place, degree in enumerate(f.degrees()) if degree > 0]


def used_by(polynomials: Iterable[Polynomial]) -> set[int]:
    """Places of the variables that occur in any of them."""
    return set(flat_map(variables_in, polynomials))


def coefficients(f: Polynomial, place: int) -> list[Polynomial]:
    """f as a polynomial in one variable: coefficients from power 0 up."""
    context = f.context()
    parts: dict[int, dict[tuple[int, ...], Any]] = {}
    for e, value in f.terms():
        parts.setdefault(e[place], {})[(*e[:place], 0, *e[place + 1 :])] = value
    return [context.from_dict(parts.get(power, {})) for power in range(max(parts, default=0) + 1)]


def coefficient(f: Polynomial, place: int, power: int) -> Polynomial:
    """The one of `coefficients` at one power."""
    terms = {(*e[:place], 0, *e[place + 1 :]): value for e, value in f.terms() if e[place] == power}
    return f.context().from_dict(terms)


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
    def is_pin(self) -> bool:
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
    if atom.is_pin:
        return (0, atom.joint, SIMPLE.index(atom.value), "")
    return (1, len(atom.f), 0, atom.key)


def roots_in(f: Polynomial) -> tuple[str, ...]:
    """Names of the roots among the variables of a polynomial."""
    return tuple(name for name in variables_of(f.context()) if name in SQUARES)


@lru_cache
def variables_of(context: Any) -> tuple[str, ...]:
    """Names of the variables of a ring."""
    return tuple(map(str, context.names()))


@lru_cache
def root_relations(context: Any) -> tuple[tuple[int, Polynomial], ...]:
    """(place, w² − r) of every root among the variables."""
    names = variables_of(context)
    made = dict(zip(names, context.gens(), strict=True))

    def value(terms: Mapping[tuple[str, ...], Fraction]) -> Polynomial:
        parts = (flint().fmpq(c.numerator, c.denominator) * prod(made[root] for root in inner)
                 for inner, c in terms.items())  # fmt: skip
        return sum(parts, context.constant(0))

    return tuple((k, made[name] ** 2 - value(SQUARES[name])) for k, name in enumerate(names) if name in SQUARES)


def reduced_roots(f: Polynomial) -> Polynomial:
    """f with every root at most once in a term."""
    for place, relation in root_relations(f.context()):
        if f.degrees()[place] > 1:
            f = f % relation
    return f


def _conjugate(f: Polynomial, place: int) -> Polynomial:
    return f.context().from_dict({e: -c if e[place] % 2 else c for e, c in f.terms()})


def norm(f: Polynomial) -> tuple[Polynomial, Polynomial]:
    """(norm, cofactor): the product of f with its conjugates, and that of the conjugates alone; norm = f · cofactor."""
    cofactor = f.context().constant(1)
    for place, _ in root_relations(f.context()):
        if f.degrees()[place]:
            look()
            other = _conjugate(f, place)
            cofactor, f = reduced_roots(cofactor * other), reduced_roots(f * other)
    return f, cofactor


def leading_number(f: Polynomial) -> Polynomial:
    """The number in front of the first power product of f, which is not 0: a polynomial in the roots alone."""
    places = [place for place, _ in root_relations(f.context())]
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
        names = zip(variables_of(number.context()), powers, strict=True)
        value += Fraction(int(part.p), int(part.q)) * prod(approximation(name) ** int(e) for name, e in names if e)
    return value


def monic(f: Polynomial) -> Polynomial:
    """f divided by the number in front of its first power product, where that has a root in it."""
    if f == 0 or not root_relations(f.context()):
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
    places = {place for place, _ in root_relations(f.context())}
    return all(place in places for place, degree in enumerate(f.degrees()) if degree > 0)
