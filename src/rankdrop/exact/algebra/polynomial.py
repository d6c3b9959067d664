"""Polynomials over the rationals, by python-flint, and the irreducible conditions that they are on the torus.

python-flint is asked for only where it is used. An irreducible condition is a joint at a simple angle, or a polynomial
in half-angle tangents = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any, NamedTuple

from rankdrop.errors import MissingExtraError

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


def coefficients(f: Polynomial, place: int) -> list[Polynomial]:
    """f as a polynomial in one variable: coefficients from power 0 up."""
    context = f.context()
    parts: dict[int, dict[tuple[int, ...], Any]] = {}
    for e, value in f.terms():
        parts.setdefault(e[place], {})[(*e[:place], 0, *e[place + 1 :])] = value
    return [context.from_dict(parts.get(power, {})) for power in range(max(parts, default=0) + 1)]


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
        return 1 if self.f is None else 2 + len(self.f)


class Factors(NamedTuple):
    """A polynomial on the torus, taken apart.

    Attributes:
        content: rational factor.
        letters: factors in lengths alone, with multiplicities: they vanish for special arms only.
        atoms: factors that depend on the configuration, with multiplicities.
    """

    content: Any
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
