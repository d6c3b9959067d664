"""The exact conditions beside an analysis: what was derived, whether it is what was found, and one partition for both.

`Comparison` is the record for JSON; what is said of it stands in `text/families.py`.

Sampling sees a set by its values: it lists θ3 = 0.4 and θ3 = −1.9 apart where one irreducible condition holds both, and
puts two conditions into one row where their joints are the same; and fitted equations may hold at a few regular places.
What has been matched with exact families takes their partition, so that a family has one id and one name in every
output; its evidence stays numerical.

Families found numerically are held against families derived exactly: have they the same points (`match`)? Neither side
knows how the other came about. Random points of each family, solutions of its own equations from random starts, are
tried on the families of the other side: every point has to lie on one of them, of the same corank and dimension. What
is one family here may be several there, so a union is as good as a single one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rankdrop.compare.cloud import WITHIN, Cloud, explained
from rankdrop.exact.family import ExactFamily
from rankdrop.families.signature import HIGHER
from rankdrop.family.equation import REACHED, Mask, System, normalised
from rankdrop.family.naming import lost_motions
from rankdrop.family.record import Check, CorankFamilies, CorankSummary, Family, Pin, Sampled, numbered
from rankdrop.problem import Problem, wrap
from rankdrop.robot.model import Array
from rankdrop.tolerances import Tolerances
from rankdrop.units import as_given

STARTS = 256
"""Random starts for the points of each family: 32 combinations of values get eight each."""
CONDITIONED = 1e-3
"""Points where a family's equations have a smaller slope are known too inexactly to be tried."""
FLAT = 1e-7
"""Where no point has a slope of `CONDITIONED` but one above this, that is the equations' own, and "smaller" is measured
by it: |f| ≤ 1e-15 is 1e-8 rad."""
COMMON = 3
"""So many random points of a family on another one make them kin: a single one may be near where the two cross."""


Side = Family | ExactFamily
"""A family of either side."""


@dataclass(frozen=True, slots=True)
class Match:
    """The exact families that a numeric one consists of.

    Attributes:
        row: id of the numeric family.
        families: ids of the exact ones that lie on it.
        parts: ids of exact ones that share some of their points with it, and the rest with other rows.
    """

    row: str
    families: tuple[str, ...]
    parts: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Wider:
    """A family of either side whose conditions hold on more than the family.

    Of several sets that the conditions describe together only some are meant; the others are of a lower corank.

    Attributes:
        family: its id on its own side.
        solved, elsewhere: random solutions of its conditions, and how many of them have a lower corank.
    """

    family: str
    solved: int
    elsewhere: int


@dataclass(frozen=True, slots=True)
class Difference:
    """What does not go together: a family of one side, and in words what is wrong with it on the other.

    Attributes:
        side: "numeric" or "exact".
        family: its id on that side.
        name: in words.
        text: what is wrong.
    """

    side: str
    family: str
    name: str
    text: str

    def __str__(self) -> str:
        return f"{self.side} {self.family} ({self.name}): {self.text}"


@dataclass(frozen=True, slots=True)
class Agreement:
    """How two sets of families go together.

    Attributes:
        matches: one for each numeric family, in order.
        numeric: points of numeric families, and how many lie on an exact one.
        exact: points of exact families, and how many lie on a numeric one.
        differences: none where every point lies on both sides.
        wider: exact families to be read with care.
        loose: numeric ones; their points of a lower corank were not tried on the other side.
    """

    matches: tuple[Match, ...]
    numeric: Check
    exact: Check
    differences: tuple[Difference, ...]
    wider: tuple[Wider, ...] = ()
    loose: tuple[Wider, ...] = ()


def match(
    problem: Problem, rows: Sequence[Side], families: Sequence[Side], *, seed: int = 0
) -> Agreement:
    """Try random points of each family on the families of the other side.

    A family and another share a component when points of one lie on the other and their dimensions agree: random
    points of an irreducible set lie on another set only if all of it does.

    Args:
        problem: the arm of both sides, of whatever corank. Where it asks for limits only points within them count, and
            a family without any is left out; `explained` is the longest way from a point to a family that holds there.
        rows: found numerically. One without equations is known by its witness alone, its dimension not at all.
        families: derived exactly, of the same coranks.
        seed: of the starts.

    Returns:
        Agreement.

    Example:
        >>> from rankdrop.families.table import families
        >>> from rankdrop.families.searching import search
        >>> from rankdrop.problem import Problem
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("scara")
        >>> rows = families(search(arm, 1, starts=100)).families
        >>> match(Problem(arm, resolve_task(None, arm)), rows, rows).matches
        (Match(row='k1.f1', families=('k1.f1',), parts=()),)
    """
    kin: set[tuple[str, str]] = set()
    inside: set[tuple[str, str]] = set()
    counts = {True: Check(0, 0), False: Check(0, 0)}
    said: list[Difference] = []
    wider: dict[bool, list[Wider]] = {True: [], False: []}
    for corank in sorted({one.corank for one in (*rows, *families)}):
        here = problem.at(corank)
        mine = [row for row in rows if row.corank == corank]
        other = [family for family in families if family.corank == corank]
        for numeric, tried, there in ((True, mine, other), (False, other, mine)):
            rng = np.random.default_rng([seed, corank, numeric])
            own, others = ("numeric", "exact") if numeric else ("exact", "numeric")
            for one in tried:
                witness, random, solved = solutions(here, one, rng)
                met, related, around, wrong = _tried(here, one, witness, random, there, others)
                counts[numeric] = Check(counts[numeric].tested + met.tested, counts[numeric].agree + met.agree)
                said += [Difference(own, one.id, one.name, text) for text in wrong]
                kin |= {(one.id, name) if numeric else (name, one.id) for name in related}
                if not numeric:
                    inside |= {(name, one.id) for name in around}
                if solved.agree < solved.tested:
                    wider[numeric].append(Wider(one.id, solved.tested, solved.tested - solved.agree))
    matches = tuple(_match(row.id, families, kin, inside) for row in rows)
    return Agreement(matches, counts[True], counts[False], tuple(said), tuple(wider[False]), tuple(wider[True]))


def _match(row: str, families: Sequence[Side], kin: set[tuple[str, str]], inside: set[tuple[str, str]]) -> Match:
    related = [family.id for family in families if (row, family.id) in kin]
    whole = tuple(name for name in related if (row, name) in inside)
    return Match(row, whole, tuple(name for name in related if name not in whole))


def _tried(
    problem: Problem, family: Side, witness: Array, random: Array, others: Sequence[Side], theirs: str
) -> tuple[Check, list[str], list[str], list[str]]:
    """Points of one family, from `solutions`, tried on those of the other side, which is called `theirs`.

    Returns:
        How many of the points lie on one of the others; ids of the others that some point lies on and whose dimension
        is the same, and of those on which all of them lie; sentences on what does not go together.
    """
    q, wrong = np.concatenate([witness, random]), list[str]()
    if not len(q):
        if not problem.limits:
            wrong.append("no configuration satisfies its own conditions, its witness included")
        return Check(0, 0), [], [], wrong
    on = np.array([lies_on(other, q, problem.tolerances) for other in others], dtype=np.bool_).reshape(-1, len(q))
    left = np.flatnonzero(~on.any(axis=0))
    if len(left):  # where sheets cross, the way to a family is not told from its square
        cloud = Cloud(problem.robot, problem.task, q[left], np.full(len(left), problem.corank))
        _, over = explained(cloud, [other.equations for other in others if other.equations], problem.tolerances)
        left = left[over]
    generic = on[:, len(witness) :] if len(random) else on
    met = [k for k, mask in enumerate(generic) if mask.sum() >= min(COMMON, len(mask))]
    vague = not family.equations or any(not others[k].equations for k in met)
    kin = [k for k in met if vague or others[k].dimension == family.dimension]
    if len(left):
        at = ", ".join(f"{x:.6g}" for x in as_given(problem.robot, q[left[0]]))
        wrong.append(
            f"{len(left)} of {len(q)} of its points lie on no {theirs} family of this corank, q = ({at}) is one"
        )
    if met and not kin:
        dimensions = ", ".join(map(str, sorted({others[k].dimension for k in met})))
        wrong.append(f"dimension {family.dimension}, but the {theirs} families on it have {dimensions}")
    around = [others[k].id for k in kin if generic[k].all()]
    return Check(len(q), len(q) - len(left)), [others[k].id for k in kin], around, wrong


def solutions(problem: Problem, family: Side, rng: np.random.Generator) -> tuple[Array, Array, Check]:
    """Solutions of a family's equations from random starts, where these are well conditioned.

    Those of a lower corank are left out, and counted.

    Args:
        problem: the arm and the corank.
        family: of either side.
        rng: of the starts.

    Returns:
        (W, n) its witness, none where that does not satisfy the equations; (N, n) random points; and of all solutions
        of the equations, how many have the corank.
    """
    witness = np.array([family.witness], dtype=np.float64)
    if not family.equations:
        return witness, witness[:0], Check(0, 0)
    system = _system(family)
    witness = witness[np.abs(system.values(witness)).max(axis=1) <= problem.tolerances.explained]
    q, _ = system.solve(problem.random(STARTS, rng), iterations=60)
    q = q[np.abs(system.values(q)).max(axis=1) <= REACHED]
    slopes = np.linalg.svd(system.jacobian(q), compute_uv=False)
    slope = slopes[:, min(problem.n - family.dimension, slopes.shape[1]) - 1]
    best = float(slope.max(initial=0.0))
    q = q[slope > CONDITIONED * (best if FLAT < best < CONDITIONED else 1.0)]
    singular = problem.sigma(q)[:, problem.rank] <= HIGHER
    q = q[singular | system.zero(q)]  # what is regular and all but a zero is neither here nor there
    singular = problem.sigma(q)[:, problem.rank] <= HIGHER
    solved, q = Check(len(q), int(singular.sum())), q[singular]
    return witness[problem.allowed(witness)], q[problem.allowed(q)], solved


def _system(family: Side) -> System:
    return System(tuple(normalised(equation.terms) for equation in family.equations))


def lies_on(other: Side, q: Array, tolerances: Tolerances) -> Mask:
    """(N,) which points lie on a family; one without equations is known by its witness alone."""
    if not other.equations:
        near: NDArray[np.bool_] = np.linalg.norm(q - np.array(other.witness), axis=1) <= tolerances.explained
        return near
    way, _ = _system(other).nearest(q, WITHIN)
    return np.asarray(way <= tolerances.explained)


AGREES, DIFFERS, NOT_DERIVED = "agrees", "differs", "not derived"
INTERRUPTED = "interrupted"
ASKED = ("auto", "on", "off")
UNTRIED = Check(0, 0)


@dataclass(frozen=True, slots=True)
class ExactRow:
    """One exact family, ready to be shown.

    Attributes:
        id: "k1.f1", among the exact families.
        name: in words.
        corank, dimension: as of a numeric family.
        pinned: joints at fixed values of q; their conditions are the first of `conditions`.
        conditions: for people: "θ4 = 0 or π", "a2 c2 + a3 c23 = 0".
        latex: the same as LaTeX mathematics.
        reality: "" where the family is real whatever the lengths are; else when it is.
    """

    id: str
    name: str
    corank: int
    dimension: int
    pinned: tuple[Pin, ...]
    conditions: tuple[str, ...]
    latex: tuple[str, ...]
    reality: str


@dataclass(frozen=True, slots=True)
class Comparison:
    """The exact families of an arm, held against the numeric ones.

    Attributes:
        status: "agrees", "differs" or "not derived".
        asked: "auto" or "on".
        seconds: the time limit; not what was spent, which no file holds.
        reason: why nothing was derived; else "".
        letters: lengths that are symbols, and their values [m].
        shifts: θ = q + shift, per joint: exact conditions speak of θ [rad, m].
        families: exact ones, of every corank.
        matches: for each numeric family the exact ones it consists of.
        numeric: points of numeric families, and how many lie on an exact one.
        exact: points of exact families, and how many lie on a numeric one.
        disagreements: sentences; none where the two agree.
        wider: exact families whose conditions hold on more than the family.
    """

    status: str
    asked: str
    seconds: float
    reason: str = ""
    letters: Mapping[str, float] | None = None
    shifts: tuple[float, ...] = ()
    families: tuple[ExactRow, ...] = ()
    matches: tuple[Match, ...] = ()
    numeric: Check = UNTRIED
    exact: Check = UNTRIED
    disagreements: tuple[str, ...] = ()
    wider: tuple[Wider, ...] = ()

    @property
    def agrees(self) -> bool:
        """Whether both sides have the same families."""
        return self.status == AGREES

    @property
    def derived(self) -> bool:
        """Whether there is an exact side."""
        return self.status != NOT_DERIVED

    @property
    def holds(self) -> bool:
        """Whether the two agree; under "auto" also where nothing was derived."""
        return self.agrees or (not self.derived and self.asked == "auto")

    @property
    def interrupted(self) -> bool:
        """Whether the user asked to stop (Ctrl-C) before the conditions were derived."""
        return self.reason == INTERRUPTED

    def of_row(self, row: str) -> tuple[tuple[ExactRow, ...], tuple[ExactRow, ...]]:
        """(exact families on a numeric one, exact families that are partly on it), by the id of the numeric one."""
        known = {family.id: family for family in self.families}
        for match in self.matches:
            if match.row == row:
                return tuple(known[i] for i in match.families), tuple(known[i] for i in match.parts)
        return (), ()


_SAME = 1e-6  # values of a pinned joint that differ by less are the same [rad, m]
_POINTS = 24  # random points of a family that its lost motions are told from


def in_exact_terms(
    problem: Problem, sampled: CorankFamilies, families: Sequence[ExactFamily], agreement: Agreement, seed: int
) -> tuple[CorankFamilies, tuple[Match, ...], dict[str, str]]:
    """The rows of one corank, one for each exact family that was met; rows that match none keep what they have.

    Args:
        problem: the arm in its own unit of length, and the corank.
        sampled: its rows, and the fresh points that were tried on them.
        families: the exact ones of this corank, in the same unit.
        agreement: which row consists of which families.
        seed: of random points.

    Returns:
        Rows with the ids and names of the exact families, in their order, then the others with further numbers, the
        fresh points counted anew where a row has other equations now; which exact families each row consists of; and
        for the id of each row given what it is called now.
    """
    by_row = {match.row: match for match in agreement.matches}
    loose = {one.family: one for one in agreement.loose}
    rows, matches, now = [], [], dict[str, str]()
    for number, family in enumerate(families):
        over = [row for row in sampled.families if family.id in (*by_row[row.id].families, *by_row[row.id].parts)]
        if not over:
            continue
        one = by_row[over[0].id]
        sound = one.row not in loose and over[0].soundness.holds
        alone = len(over) == 1 and one.families == (family.id,) and not one.parts and sound
        rng = np.random.default_rng([seed, number, 9])
        made = over[0] if alone else _measured(problem, sampled, family, over, rng)
        if made is None:
            continue
        now |= {row.id: " and ".join(filter(None, (now.get(row.id), family.id))) for row in over}
        rows.append(replace(made, id=family.id, name=family.name))
        matches.append(Match(family.id, (family.id,)))
    strangers = [_judged(row, loose.get(row.id)) for row in sampled.families if row.id not in now]
    named = numbered(strangers, problem.corank, after=len(families))  # in the order they have already
    matches += [replace(by_row[row.id], row=new.id) for row, new in zip(strangers, named, strict=True)]
    now |= {row.id: new.id for row, new in zip(strangers, named, strict=True)}
    together = (*rows, *named)
    given = {(row.equations, row.witness) for row in sampled.families}
    same = {(row.equations, row.witness) for row in together} == given
    summary = sampled.summary if same else _recounted(problem, sampled, together)
    return replace(sampled, summary=summary, families=together), tuple(matches), now


def _recounted(problem: Problem, sampled: CorankFamilies, rows: Sequence[Family]) -> CorankSummary:
    """The summary with the fresh points that the rows explain as they are now."""
    if not len(sampled.fresh):
        return sampled.summary
    fresh = Cloud(problem.robot, problem.task, sampled.fresh, np.full(len(sampled.fresh), problem.corank))
    check, _ = explained(fresh, [row.equations for row in rows if row.equations], problem.tolerances)
    return replace(sampled.summary, completeness=Check(check.tested, check.agree))


def _judged(row: Family, loose: Wider | None) -> Family:
    """A row with the regular solutions of its equations that were met since counted in its soundness."""
    if loose is None:
        return row
    tested, singular = row.soundness.tested, row.soundness.agree
    sound = Check(tested + loose.solved, singular + loose.solved - loose.elsewhere)
    return replace(row, evidence=Sampled(row.evidence.how, sound, row.explained))


def _measured(
    problem: Problem, sampled: CorankFamilies, family: ExactFamily, over: Sequence[Family], rng: np.random.Generator
) -> Family | None:
    """A row with the equations of an exact family, its soundness and its share taken anew; None without a point."""
    equations = family.equations
    witness, random, solved = solutions(problem, family, rng)
    if solved.agree < solved.tested and len(over) == 1:  # each side's conditions may hold too widely, both together not
        both = replace(over[0], equations=(*equations, *over[0].equations))
        together = solutions(problem, both, rng)
        if together[2].holds:
            equations, (witness, random, solved) = both.equations, together
    inside = np.concatenate([witness, random])
    if not len(inside):
        return None
    share = int(lies_on(family, sampled.fresh, problem.tolerances).sum()) if len(sampled.fresh) else 0
    pinned = _pinned(problem, family, over, inside)
    at = inside[0]
    directions, sentences = lost_motions(problem, at, inside[:_POINTS])
    held = {one.number for one in pinned}
    return Family(
        id=family.id,
        name=family.name,
        corank=family.corank,
        dimension=family.dimension,
        pinned=pinned,
        free=family.free,
        coupled=tuple(joint for joint in family.coupled if joint not in held),
        equations=equations,
        witness=tuple(float(x) for x in at),
        lost_directions=directions,
        lost_words=sentences,
        evidence=Sampled(
            f"exact condition; points found numerically: {', '.join(dict.fromkeys(row.evidence.how for row in over))}",
            solved,
            Check(sampled.summary.completeness.tested, share),
        ),
    )


def _pinned(problem: Problem, family: ExactFamily, over: Sequence[Family], points: Array) -> tuple[Pin, ...]:
    """Joints that stand at one of a few values at all points, where every combination of their values is met."""
    values: dict[int, list[float]] = {}
    for joint in {one.number for row in over for one in row.pinned}:
        options: list[float] = []
        for value in (value for row in over for one in row.pinned if one.number == joint for value in one.values):
            if not any(abs(_apart(problem, joint, value, other)) <= _SAME for other in options):
                options.append(value)
        away = np.array([np.abs(_apart(problem, joint, points[:, joint - 1], value)) for value in options])
        met = [value for value, near in zip(options, away, strict=True) if near.min() <= _SAME]
        if (away.min(axis=0) <= _SAME).all():
            values[joint] = sorted(met)
    joints = sorted(values)
    labels = np.array([
        np.abs([_apart(problem, joint, points[:, joint - 1], value) for value in values[joint]]).argmin(axis=0)
        for joint in joints
    ]).reshape(len(joints), len(points))  # fmt: skip
    if len({tuple(column) for column in labels.T}) < len(list(product(*values.values()))):
        return tuple(one for one in family.pinned(problem.robot) if one.number in values)
    names = problem.robot.variables
    return tuple(Pin(names[joint - 1].name, joint, tuple(values[joint])) for joint in joints)


def _apart(problem: Problem, joint: int, one: Array | float, other: float) -> Array:
    """The difference of values of a joint, turns left out where it turns."""
    off = np.asarray(one - other, dtype=np.float64)
    return wrap(off) if problem.robot.periodic[joint - 1] else off
