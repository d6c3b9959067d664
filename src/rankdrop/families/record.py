"""Which conditions, lost motions and evidence make up one family of singular configurations, whoever found it?

The conditions of a family are `Pin`s and `Equation`s, and where they were derived exactly `ExactConditions`; its
evidence says how it was found: exactly, from a sample of the whole joint space, or from the neighbourhood of one
configuration. Exact conditions are those of the arm in its given unit from the start, and stay.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.errors import OptionError, ResultFileError
from rankdrop.families.evidence import FamilyEvidence
from rankdrop.families.lost import LostFreedom
from rankdrop.families.name import FamilyName
from rankdrop.formula.equation import Equation, System
from rankdrop.robot.model import Array
from rankdrop.sections import Section, html, words_of

if TYPE_CHECKING:
    from rankdrop.algebra.zeroset import ZeroSet
    from rankdrop.formula.writing import AnglePin, Condition

Order = tuple[int, tuple[int, ...], tuple[int, ...], tuple[tuple[float, ...], ...], tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Pin:
    """A joint that stands at one of a few values on the whole family.

    Attributes:
        joint: name.
        number: counted from 1.
        values: in (−π, π] [rad], or [m] for a prismatic joint; every combination of the values of a family's pinned
            joints belongs to the family.
    """

    joint: str
    number: int
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Check:
    """Of `tested` points that were tried, `agree` are as claimed: singular, on the family, of the rank expected."""

    tested: int
    agree: int

    @property
    def holds(self) -> bool:
        """All of them, and there was at least one."""
        return 0 < self.tested == self.agree


@dataclass(frozen=True, slots=True)
class WrittenCondition:
    """A condition as a file of `analyze` holds it: its words, without the polynomial.

    Attributes:
        words: for people: "θ4 = 0 or π", "a2 c2 + a3 c23 = 0".
        mathematics: the same as LaTeX.
    """

    words: str
    mathematics: str

    def text(self) -> str:
        """For people."""
        return self.words

    def latex(self) -> str:
        """The same in LaTeX, without delimiters."""
        return self.mathematics


@dataclass(frozen=True, eq=False)
class ExactConditions:
    """The conditions of one family as they were derived exactly.

    Attributes:
        pinned: joints at fixed values of q; their conditions are the first of `stated`.
        stated: every condition: joints at simple angles, every combination of which belongs to the family, then
            irreducible polynomials, all of which vanish; read from a file of `analyze` the words of these.
        not_negative: expressions in the lengths; the family is real if and only if none of them is negative.
        rank_check: exact rank modulo a prime at random points of the family: is it as claimed? None read from a file
            of `analyze`, which has none of what follows either.
        numbers: values of the letters [m].
        shifts: θ = q + shift, per joint [rad].
        pieces: its irreducible sets, one for each combination of pins; none of shipped conditions.
        written: `stated` in words, where these were stored too: making them takes longest.
    """

    pinned: tuple[Pin, ...]
    stated: tuple[AnglePin | Condition | WrittenCondition, ...]
    not_negative: tuple[str, ...]
    rank_check: Check = Check(0, 0)
    numbers: Mapping[str, float] = field(default_factory=dict)
    shifts: tuple[float, ...] = ()
    pieces: tuple[ZeroSet, ...] = ()
    written: tuple[WrittenCondition, ...] = ()

    @cached_property
    def conditions(self) -> tuple[str, ...]:
        """Every condition for people: "θ4 = 0 or π", "a2 c2 + a3 c23 = 0"."""
        return tuple(condition.text() for condition in self.written or self.stated)

    @cached_property
    def latex(self) -> tuple[str, ...]:
        """Every condition as LaTeX mathematics."""
        return tuple(condition.latex() for condition in self.written or self.stated)

    @property
    def reality(self) -> str:
        """When the family has real points, in words; "" where it has some whatever the lengths are."""
        sentence: str = words_of(self).reality_words(self)
        return sentence

    @property
    def pins(self) -> tuple[AnglePin, ...]:
        """The joints at simple angles; none read from a file of `analyze`."""
        from rankdrop.formula.writing import AnglePin  # who shows words does without

        return tuple(condition for condition in self.stated if isinstance(condition, AnglePin))

    @property
    def polynomials(self) -> tuple[Condition, ...]:
        """The conditions that are irreducible polynomials; none read from a file of `analyze`."""
        from rankdrop.formula.writing import Condition

        return tuple(condition for condition in self.stated if isinstance(condition, Condition))

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy for another process has the words: polynomials belong to the ring of this one."""
        return written_conditions, (self.pinned, self.conditions, self.latex, self.not_negative)


def written_conditions(
    pinned: tuple[Pin, ...], texts: Sequence[str], latex: Sequence[str], not_negative: tuple[str, ...]
) -> ExactConditions:
    """Exact conditions as a file of `analyze` holds them.

    Args:
        pinned, not_negative: as of `ExactConditions`.
        texts: every condition for people.
        latex: the same as LaTeX mathematics.

    Raises:
        ResultFileError: other numbers of texts.
    """
    if len(latex) != len(texts):
        raise ResultFileError("one LaTeX text for each condition", got=str(len(latex)), allowed=str(len(texts)))
    return ExactConditions(pinned, tuple(map(WrittenCondition, texts, latex)), not_negative)


@dataclass(frozen=True)
class LocalConditions:
    """Conditions that hold on a family around one configuration, beyond joints at fixed values.

    Attributes:
        relations: whole numbers mᵢ and the value of Σ mᵢ θᵢ [rad].
        residual: other equations, in the unit of length of the arm as given.
        complete: the equations of coupled joints are all known.
        isolated: no other configuration of this corank is around it.
    """

    relations: tuple[tuple[tuple[int, ...], float], ...] = ()
    residual: tuple[Equation, ...] = ()
    complete: bool = True
    isolated: bool = False


@dataclass(frozen=True, eq=False)
class Family:
    """One family of singular configurations: a piece of the singular set with conditions of one form.

    Attributes:
        id: "k1.f1": corank 1, first row; empty for a family that stands in no table.
        called: its name as facts.
        named: False for a family whose points were found but whose conditions were not.
        corank: rank lost on the family.
        dimension: of the family in joint space; for a family that is not named an upper bound (dim ker D).
        pinned: joints at fixed values.
        free: numbers of the joints that the family does not depend on.
        coupled: numbers of the joints bound together by the remaining equations.
        equations: every condition, those of the pinned joints included; the family is their common zero set.
            Empty where not all of them are known.
        witness: a configuration on the family, of exactly this corank.
        lost_directions: (k, 6) rows (v; ω), orthonormal, at the witness; none from a neighbourhood, nor where the
            derivation alone knows the family.
        lost_freedoms: what the tool cannot do, one for each freedom lost; none from a neighbourhood.
        evidence: how the conditions were obtained.
        soundness: the equations solved from random starts, and how many solutions have the corank or more; none were
            from a neighbourhood.
        explained: the fresh points of this corank, and how many lie on this family; none were tried from a
            neighbourhood.
        local: of a neighbourhood: its conditions beyond pinned joints, of which only the values that are met there are
            known, while a row of a table holds all; None for a row of a table, and where families meet.
        slides: of a neighbourhood: numbers of the joints that slide; elsewhere the equations show them.
        parts: of a neighbourhood: the families that meet at the configuration; empty where it lies on one only.
        exact: its exact conditions; None where the families were not derived exactly.
    """

    id: str
    called: FamilyName
    named: bool = field(default=True, kw_only=True)
    corank: int
    dimension: int
    pinned: tuple[Pin, ...]
    free: tuple[int, ...]
    coupled: tuple[int, ...]
    equations: tuple[Equation, ...]
    witness: tuple[float, ...]
    lost_directions: Array  # (k, 6)
    lost_freedoms: tuple[LostFreedom, ...]
    evidence: FamilyEvidence
    soundness: Check = Check(0, 0)
    explained: Check = Check(0, 0)
    local: LocalConditions | None = None
    slides: tuple[int, ...] = ()
    parts: tuple[Family, ...] = ()
    exact: ExactConditions | None = None

    def __post_init__(self) -> None:
        directions = np.round(np.array(self.lost_directions, dtype=np.float64), 12) + 0.0  # the same on every BLAS
        directions.flags.writeable = False
        object.__setattr__(self, "lost_directions", directions)

    @cached_property
    def name(self) -> str:
        """Its name in words: "wrist: axes 4 and 6 aligned"."""
        return str(self.called)

    @property
    def codimension(self) -> int:
        """Number of joints less the dimension."""
        return len(self.witness) - self.dimension

    @property
    def texts(self) -> tuple[str, ...]:
        """Every condition for people: exactly where it was derived, else with decimals."""
        if self.exact is None:
            return tuple(f"{equation} = 0" for equation in self.equations)
        return self.exact.conditions

    @property
    def latex(self) -> tuple[str, ...]:
        """The same as LaTeX mathematics."""
        if self.exact is None:
            return tuple(f"{equation.latex()} = 0" for equation in self.equations)
        return self.exact.latex

    @cached_property
    def system(self) -> System:
        """The equations, as they are solved: made once."""
        return System(self.equations)

    def _repr_html_(self) -> str:
        """For notebooks: what the family asks, what is lost, how it was tested."""
        sections: tuple[Section, ...] = words_of(self).sections_of(self)
        return html(sections)


def exact_of(family: Family) -> ExactConditions:
    """The exact conditions of a derived family.

    Raises:
        OptionError: it was not derived exactly.
    """
    if family.exact is None:
        raise OptionError("the family was not derived exactly", where=f"family {family.id}")
    return family.exact


def with_exact(families: Iterable[Family], derived: Iterable[Family]) -> tuple[Family, ...]:
    """Families of an analysis with the exact conditions of those derived later: the same id, name and corank."""
    by_name = {(family.id, family.name, family.corank): family.exact for family in derived}
    return tuple(replace(family, exact=by_name.get((family.id, family.name, family.corank))) for family in families)


def place_of(dimension: int, pinned: Iterable[Pin], coupled: Iterable[int], texts: Iterable[str]) -> Order:
    """What decides the place of a family among those of its corank, hence its id: the set, not how it was found.

    Large families first; then by joints that are pinned, joints that are coupled, values, and the conditions in words.

    Args:
        dimension: of the family.
        pinned: joints at fixed values of q.
        coupled: numbers of the joints bound together.
        texts: its conditions for people.
    """
    pins = sorted(pinned, key=lambda pin: pin.number)
    values = tuple(tuple(sorted(round(value, 6) + 0.0 for value in pin.values)) for pin in pins)
    return -dimension, tuple(pin.number for pin in pins), tuple(sorted(coupled)), values, tuple(texts)


def number_families(rows: Sequence[Family], corank: int, after: int = 0) -> tuple[Family, ...]:
    """Rows in their places with the ids that go with them; those without conditions come last.

    Args:
        rows: of one corank.
        corank: of all of them.
        after: the number of the family before the first.
    """

    def place(row: Family) -> tuple[bool, Order]:
        texts = (str(equation) for equation in row.equations)
        return not row.named, place_of(row.dimension, row.pinned, row.coupled, texts)

    ordered = sorted(rows, key=place)
    return tuple(replace(row, id=f"k{corank}.f{number}") for number, row in enumerate(ordered, after + 1))
