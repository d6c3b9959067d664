"""What a family is, whoever found it: one family (a row of the table), one corank's summary, and their parts.

Between an arm's own unit of length and the one it was given in angles stay as they are; values of slides change, and so
do the coefficients of equations in which slides stand. Lost directions are in `counted` lengths and stay, and those of
`lost_freedoms` have the given unit from the start.

The conditions of a family are `Pin`s and `Equation`s, and where they were derived exactly `ExactConditions`; its
evidence says how it was found: exactly, from a sample of the whole joint space, or from the neighbourhood of one
configuration. Exact conditions are those of the arm in its given unit from the start, and stay.
`Derivation` is the exact derivation that an analysis rests on; its printed form is made in `text/families.py`.
`families_at` says on which families a configuration lies.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError, ResultFileError
from rankdrop.families.contradiction import Contradiction
from rankdrop.families.evidence import FamilyEvidence
from rankdrop.families.lost import LostFreedom
from rankdrop.families.name import FamilyName
from rankdrop.families.not_derived import NotDerived, NotDerivedKind
from rankdrop.formula.equation import Equation, System
from rankdrop.kinematics import one_configuration
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.sections import Section, html, words_of
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import exponent, in_metres, into_metres, metre_exponent, shift_decimal, task_in_metres

if TYPE_CHECKING:
    from rankdrop.algebra.zeroset import ZeroSet
    from rankdrop.formula.writing import AnglePin, Condition


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


@dataclass(frozen=True, slots=True)
class SpeedDistance:
    """From which distance of a family the tool keeps a speed.

    Attributes:
        family: its id.
        number, joint: a joint that stands at a value on the family, from 1, and its name; of a residual the joint in
            which the region goes on to the family.
        value: that value nearest to the middle of the region [rad]; of a residual where it vanishes, the other joints
            as in the middle.
        end: of the region: no distance in it is larger.
        kept_from: proven for every configuration of the region at least so far from the family; None: for none.
        slower_at: the largest distance at which a slower configuration was found; None: none was found.
        slower_speed: of the tool there, in its slowest direction [m/s].
        boxes: that were enclosed.
        spent: the budget ended the work: a smaller distance may hold.
        measure: "joint": distance of the joint from its value; "joints": the largest distance of several joints from
            their values; "residual": the size of the only condition, which couples joints.
        unit: of distances: "rad"; of a residual "m" where it is a length of the arm, else "1".
        numbers: of the joints that the measure takes, from 1; empty: the one joint.
        values: of those joints on the family [rad]; empty for a residual.
    """

    family: str
    number: int
    joint: str
    value: float
    end: float
    kept_from: float | None
    slower_at: float | None
    slower_speed: float | None
    boxes: int
    spent: bool
    measure: str = "joint"
    unit: str = "rad"
    numbers: tuple[int, ...] = ()
    values: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class SpeedDistances:
    """Distances from families that keep a speed of the tool, in a region around a posture.

    Attributes:
        tool_speed: of straight motions in any direction, the tool not turning [m/s].
        around: (n,) middle of the region [rad, m].
        span: half its width in each joint, inside the joint limits; slides divided by the length scale [rad].
        free: numbers of the joints that may have any value: the speed does not depend on them.
        distances: for each family with joints at values, or with one condition on several joints.
        others: ids of the other families of the smallest corank.
    """

    tool_speed: float
    around: tuple[float, ...]
    span: float
    free: tuple[int, ...]
    distances: tuple[SpeedDistance, ...]
    others: tuple[str, ...]


class Estimator(StrEnum):
    """How the share of unseen sets was estimated: from the pieces of points, or where no start converged; or a sentence
    of a file that states neither."""

    NO_POINT = "no point"
    GOOD_TURING = "Good–Turing"
    NO_START = "no start"
    STORED = "old sentence"


@dataclass(frozen=True, slots=True)
class Unseen:
    """Share of the search's convergence mass that lies on sets without a point.

    Attributes:
        estimate: Good–Turing.
        upper: upper bound at 95 % confidence; where `once` is 0, or no start converged, by the rule of three.
        estimator: how both were estimated.
        once: number of pieces with one point.
        pieces: number of pieces with points.
        number: of points on these pieces; of starts where none converged.
        text: of the estimator STORED, the sentence.
    """

    estimate: float
    upper: float
    estimator: Estimator
    once: int = 0
    pieces: int = 0
    number: int = 0
    text: str = ""

    @property
    def how(self) -> str:
        """The estimator in words, with the counts it used."""
        how: str = words_of(self).unseen_words(self)
        return how


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


@dataclass(frozen=True, slots=True)
class CorankSummary:
    """What the search met at one corank.

    Attributes:
        corank, rank: corank k and the rank kept.
        starts, converged, near_misses, slow: of the cloud the families were made from.
        smallest_near_miss: smallest σ of a nonzero local minimum; None when there was none.
        completeness: fresh points of exactly this corank, and how many of them some named row explains.
        higher: fresh points whose corank is higher; they belong to the table of that corank and are not counted above.
        unseen: what sampling may have missed.
    """

    corank: int
    rank: int
    starts: int
    converged: int
    near_misses: int
    slow: int
    smallest_near_miss: float | None
    completeness: Check
    higher: int
    unseen: Unseen


@dataclass(frozen=True, slots=True)
class CorankFamilies:
    """All rows of one corank with their summary.

    Attributes:
        summary: what the search met.
        families: in their order.
        contradictions: derived families that points solved on them contradict, each with the largest dimension that the
            singular set can have there; None where no point of it is singular to its corank.
        mistaken: how many points the searches took for singular, σ being below its threshold, that are not.
        lowest: the smallest of the minima of σ next to these, worked out with 50 digits; inf where there are none.
    """

    summary: CorankSummary
    families: tuple[Family, ...]
    contradictions: tuple[tuple[Family, int | None], ...] = ()
    mistaken: int = 0
    lowest: float = inf


Order = tuple[int, tuple[int, ...], tuple[int, ...], tuple[tuple[float, ...], ...], tuple[str, ...]]


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


def family_out_of_units(family: Family, robot: Robot) -> Family:
    """A family of `in_units(robot)` as one of the arm itself."""
    return _with_slides(family, robot, exponent(robot))


def family_in_units(family: Family, robot: Robot) -> Family:
    """A family of an arm as one of `in_units(robot)`."""
    return _with_slides(family, robot, -exponent(robot))


def family_in_metres(family: Family, robot: Robot) -> Family:
    """A family of an arm as one of `in_metres(robot)`."""
    return _with_slides(family, robot, -metre_exponent(robot))


def family_from_metres(family: Family, robot: Robot, power: int) -> Family:
    """A family of an arm in metres as one of the same arm with lengths 10 to a power as large in numbers."""
    lost = tuple(freedom.rescaled(power) for freedom in family.lost_freedoms)
    return replace(_with_slides(family, robot, power), lost_freedoms=lost)


def _with_slides(family: Family, robot: Robot, power: int) -> Family:
    """The family where the numbers of slides are 10 to a power times as large."""
    if robot.exponent is not None or not power:
        return family
    slides = slides_of(robot)
    if not slides:
        return family
    return replace(
        family,
        pinned=tuple(rescaled_pin(pin, slides, power) for pin in family.pinned),
        equations=tuple(rescale_equation(equation, slides, power) for equation in family.equations),
        witness=tuple(shift_decimal(x, power) if i in slides else x for i, x in enumerate(family.witness)),
    )


def slides_of(robot: Robot) -> tuple[int, ...]:
    """Variables (from 0) that are lengths."""
    return tuple(i for i, joint in enumerate(robot.variables) if joint.kind is JointKind.PRISMATIC)


def rescaled_pin(pin: Pin, slides: Sequence[int], power: int) -> Pin:
    """The pin where the numbers of slides are 10 to a power times as large."""
    if pin.number - 1 in slides:
        return replace(pin, values=tuple(shift_decimal(x, power) for x in pin.values))
    return pin


def rescale_equation(equation: Equation, slides: Sequence[int], power: int) -> Equation:
    """The equation where the numbers of slides are 10 to a power times as large; its largest coefficient is 1 again.

    Args:
        equation: of one arm.
        slides: variables (from 0) that are lengths; powers of helical joints are powers of an angle.
        power: of ten.

    Example:
        >>> from rankdrop.formula.equation import Term
        >>> slide = Equation((Term(1.0, "cos", (0, 0), (0, 1)), Term(-0.3, "cos", (2, 0), (0, 0))))
        >>> print(slide, "|", rescale_equation(slide, [1], 3))
        q2 − 0.3 cos θ1 | 0.003333 q2 − cos θ1
    """
    lengths = [sum(term.powers[i] for i in slides) for term in equation.terms]
    if not power or not any(lengths):
        return equation
    values = [shift_decimal(term.coefficient, -power * n) for term, n in zip(equation.terms, lengths, strict=True)]
    largest = max(map(abs, values))
    return Equation(
        tuple(replace(term, coefficient=value / largest) for value, term in zip(values, equation.terms, strict=True))
    )


AGREES, DIFFERS, NOT_DERIVED = "agrees", "differs", "not derived"
ASKED = ("auto", "on", "off")


@dataclass(frozen=True, slots=True)
class Derivation:
    """The exact derivation of the families of an arm; what it gives for each of them is `Family.exact`.

    Attributes:
        status: "agrees": derived, and no numerical test contradicts it; "differs": some do; "not derived": the families
            of the analysis are fitted to points.
        asked: "auto" or "on".
        seconds: the time limit; not what was spent, which no file holds.
        reason: why nothing was derived, `str` gives the words; None where the families were derived.
        letters: lengths that are symbols, and their values [m].
        shifts: θ = q + shift, per joint: exact conditions speak of θ [rad, m].
        disagreements: none where derivation and numerical tests agree; `str` gives a sentence.
        first_derived: of an analysis that is "not derived": its families of corank 1 are derived all the same, from
            det J.
    """

    status: str
    asked: str
    seconds: float
    reason: NotDerived | None = None
    letters: Mapping[str, float] | None = None
    shifts: tuple[float, ...] = ()
    disagreements: tuple[Contradiction, ...] = ()
    first_derived: bool = False

    @property
    def agrees(self) -> bool:
        """Whether the families were derived, and all tests hold."""
        return self.status == AGREES

    @property
    def derived(self) -> bool:
        """Whether the families are those derived."""
        return self.status != NOT_DERIVED

    @property
    def holds(self) -> bool:
        """Whether nothing contradicts the derivation; under "auto" also where nothing was derived."""
        return self.agrees or (not self.derived and self.asked == "auto")

    @property
    def interrupted(self) -> bool:
        """Whether the user asked to stop (Ctrl-C) before the conditions were derived."""
        return self.reason is not None and self.reason.kind is NotDerivedKind.INTERRUPTED


_ON = 1e-9  # |f|/|∇f| and √|f| of every equation below this: on the family, no way to walk [rad]
_WITHIN = 1e-2  # longest way to a family that is walked [rad]
_LOOKS = 6  # points looked at on such a way


@dataclass(frozen=True, slots=True)
class Incidence:
    """A family and how near a configuration is to it.

    Attributes:
        family: from an atlas, or found on the spot.
        residual: distance to it [rad; metres divided by the length scale]: the way walked to it by Gauss–Newton.
        source: where the family is from: "catalogue", "analysis" or "on the spot".
    """

    family: Family
    residual: float
    source: str


def families_at(
    families: Sequence[Family],
    robot: Robot,
    q: ArrayLike,
    task: Task,
    tolerances: Tolerances = DEFAULT,
    source: str = "analysis",
) -> tuple[Incidence, ...]:
    """The families that a singular configuration lies on, the one that says most about it first.

    A family holds at q when the way from q to its zero set, walked by Gauss–Newton, is at most `explained`. Where
    sheets cross, σ is of higher order in the distance and q is known less well: then a family holds, too, when σ stays
    zero within the tolerance on the whole way, because nothing tells q from its foot on the family.

    Order: corank, high first; then dimension, small first (a family inside another says more); then distance. A family
    whose corank is higher than that of q does not hold there. Where the first corank is below that of q, larger
    families meet at q and none of those given is of its corank.

    Args:
        families: of this arm and task; those without equations never hold.
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: from `resolve_task`.
        tolerances: `singular` and `explained`.
        source: what `Incidence.source` says.

    Raises:
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.families.table import families
        >>> from rankdrop.families.searching import search
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("scara")
        >>> known = families(search(arm, 1, starts=100)).families
        >>> [met.family.dimension for met in families_at(known, arm, [0.3, 0.0, 0.1, 0.2], resolve_task(None, arm))]
        [3]
    """
    configuration = one_configuration(robot, q)
    problem = Problem(in_metres(robot), task_in_metres(task, robot), tolerances=tolerances)
    at = into_metres(robot, configuration)
    sigma, generic = problem.sigma(at), problem.generic_rank
    corank = generic - int((sigma[:generic] > tolerances.singular).sum())
    met = []
    for family in families:
        if family.equations and 1 <= family.corank <= corank:
            if family.corank == problem.corank:  # most often: what the problem keeps serves again
                problem_of_corank = problem
            else:
                problem_of_corank = problem.at(family.corank)
            length = float(ways_to(problem_of_corank, family_in_metres(family, robot).system, at[None])[0])
            if length < inf:
                met.append(Incidence(family, length, source))
    met.sort(key=lambda incidence: (-incidence.family.corank, incidence.family.dimension, incidence.residual))
    return tuple(met)


def ways_to(
    problem: Problem, system: System, q: Array, within: float = _WITHIN, zero: float | None = None
) -> Array:
    """Distances from configurations to a zero set that is of the problem's corank.

    Args:
        problem: the arm, and the corank.
        system: the equations of the set; without any it is everything.
        q: (N, n).
        within: longest way that is walked [rad].
        zero: σ at or below this is zero where sheets cross; None for `singular`.

    Returns:
        (N,) [rad]: at most `explained`, or longer where σ is zero on the whole way; else inf.
    """
    if not system.equations or not len(q):
        return np.zeros(len(q))
    f, a = system.linear(q)
    scaled = a * problem.scale
    size, slope = np.abs(f), np.sqrt(np.add.reduce(scaled * scaled, axis=-1))
    first = np.minimum(size / np.maximum(slope, 1e-300), np.sqrt(size)).max(axis=1)
    result = np.where(first <= _ON, first, inf)
    rows = np.flatnonzero((first > _ON) & (first <= 4 * within))
    if not len(rows):
        return np.asarray(result)
    lengths, feet = system.nearest(q[rows], within)
    crossing = np.flatnonzero((lengths > problem.tolerances.explained) & np.isfinite(lengths))
    if not len(crossing):
        result[rows] = lengths
        return np.asarray(result)
    part = np.linspace(0.0, 1.0, _LOOKS)[:, None, None]
    sigma = problem.sigma((1 - part) * q[rows[crossing]] + part * feet[crossing])[..., problem.rank]
    lengths[crossing[(sigma > (problem.tolerances.singular if zero is None else zero)).any(axis=0)]] = inf
    result[rows] = lengths
    return np.asarray(result)
