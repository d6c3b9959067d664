"""The exact conditions beside an analysis: what was derived, whether it is what was found, and one partition for both.

`Comparison` is the record for JSON; what is said of it stands in `text/families.py`.

Sampling sees a set by its values: it lists θ3 = 0.4 and θ3 = −1.9 apart where one irreducible condition holds both, and
puts two conditions into one row where their joints are the same; and fitted equations may hold at a few regular places.
What has been matched with exact families takes their partition, so that a family has one id and one name in every
output; its evidence stays numerical.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from rankdrop.compare.cloud import Cloud, explained
from rankdrop.compare.match import Agreement, Match, Wider, lies_on, solutions
from rankdrop.exact.family import ExactFamily
from rankdrop.family.naming import lost_motions
from rankdrop.family.record import Check, CorankFamilies, CorankSummary, Family, Pin, Sampled, numbered
from rankdrop.problem import Problem, wrap
from rankdrop.robot.model import Array

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
    points = solutions(problem, family, rng)
    if points.elsewhere and len(over) == 1:  # where each side's conditions hold too widely, both together may not
        both = replace(over[0], equations=(*equations, *over[0].equations))
        together = solutions(problem, both, rng)
        if together.solved > together.elsewhere == 0:
            equations, points = both.equations, together
    inside = points.q[problem.allowed(points.q)]
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
            Check(points.solved, points.solved - points.elsewhere),
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
