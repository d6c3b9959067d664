"""What an exact derivation found, as plain attributes.

Exact conditions as plain data: the names of docs/json.md and schema/conditions.schema.json.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.family import Assumption, ExactFamily
from rankdrop.exact.writing.notation import Step
from rankdrop.family.record import Check
from rankdrop.results.codec import Record, counted, plain, robot_to_dict
from rankdrop.results.verdict import Verdict, of_conditions
from rankdrop.robot.model import Robot
from rankdrop.task import Task
from rankdrop.units import heading

if TYPE_CHECKING:
    from rankdrop.exact.determinants import Determinants


@dataclass(frozen=True, slots=True)
class ConditionSettings:
    """What the derivation was asked to do; with the robot and the version it determines the result.

    Attributes:
        method: asked for, for corank 1.
        lengths: "auto", "letters", "numbers", or values by letter [m].
        coranks: the highest one asked for; None for all.
        seconds: time limit. The result depends on it only where it was met.
        seed: of every random choice.
        points: numerically found configurations tried, of corank 1.
        special: whether arms of special lengths were derived too.
        steps: whether the derivation was written down.
        version: of rankdrop.
        basic: numbers of the basic screws asked for; None for none.
        frame: link whose frame was asked for; None for none.
    """

    method: str
    lengths: str | Mapping[str, float]
    coranks: int | None
    seconds: float
    seed: int
    points: int
    special: bool
    steps: bool
    version: str
    basic: tuple[int, ...] | None = None
    frame: int | None = None


@dataclass(frozen=True, eq=False, repr=False)
class ConditionsData:
    """The singularity conditions of an arm, exactly; `Conditions` adds what can be done with them.

    Attributes:
        robot, task: the arm, and the rows that matter.
        generic_rank: of the task Jacobian almost everywhere; corank k means rank `generic_rank − k`.
        letters: the lengths that are symbols, and their values [m].
        shifts: θ = q + shift, per joint: conditions speak of θ [rad, m].
        remarks: what was rounded, or is nearly so.
        method, reason: how the conditions of corank 1 were derived, and why so.
        steps: that derivation, step by step.
        families: of every corank that was derived, large ones first.
        lowest: rank down to which drops were looked for.
        assumptions: lengths for which more happens.
        not_real: sets without a real point for the arm's lengths, and why.
        explained: of singular configurations found numerically, how many lie on a family.
        disagreements: whatever two methods, or the derivation and a check, say differently. None is as it should be.
        complete: nothing was left unfinished.
        interrupted: Ctrl-C ended it.
        left: what was not finished, in words.
        seconds: spent.
        settings: what was asked for.
        chain: the arm over the exact ring, in which conditions are polynomials.
        determinants: the determinant of the Jacobian, or its minors, in factors; None where no steps were asked for.
        anew: None for what was derived just now; for the shipped conditions of a catalogue arm what derives them anew.
    """

    robot: Robot
    task: Task
    generic_rank: int
    letters: Mapping[str, float]
    shifts: tuple[float, ...]
    remarks: tuple[str, ...]
    method: str
    reason: str
    steps: tuple[Step, ...]
    families: tuple[ExactFamily, ...]
    lowest: int
    assumptions: tuple[Assumption, ...]
    not_real: tuple[str, ...]
    explained: Check
    disagreements: tuple[str, ...]
    complete: bool
    interrupted: bool
    left: tuple[str, ...]
    seconds: float
    settings: ConditionSettings
    chain: Chain
    determinants: Determinants | None = None
    anew: Callable[[], ConditionsData] | None = None

    @property
    def verified(self) -> bool:
        """Whether every check that was made holds and nothing was left unfinished."""
        return self.verdict.holds

    @property
    def verdict(self) -> Verdict:
        """What may be claimed, in one sentence; the exit code follows it."""
        return of_conditions(self)

    def of_corank(self, corank: int) -> tuple[ExactFamily, ...]:
        """The families of one corank."""
        return tuple(family for family in self.families if family.corank == corank)


SCHEMA = "rankdrop/conditions/1"


def conditions_to_dict(found: ConditionsData) -> Record:
    """All of it but the time spent: the same robot and settings give the same record."""
    return {
        **heading(SCHEMA),
        "robot": robot_to_dict(found.robot, found.task, found.generic_rank),
        **_entries(found, "settings", "letters", "shifts", "remarks", "method", "reason", "steps"),
        "determinants": None if found.determinants is None else found.determinants.to_dict(found.shifts),
        **found.verdict.to_dict(),
        **_entries(found, "complete", "interrupted", "verified", "left", "disagreements", "lowest"),
        "families": [_family(found, family) for family in found.families],
        **_entries(found, "assumptions", "not_real"),
        "explained": counted(found.explained, "explained"),
    }


def _entries(record: object, *names: str) -> Record:
    return {name: plain(getattr(record, name)) for name in names}


def _family(found: ConditionsData, family: ExactFamily) -> Record:
    """The entries of a family of an analysis that make sense here, and what is known exactly."""
    pinned = [replace(one, values=tuple(sorted(one.values))) for one in family.pinned(found.robot)]
    return {
        **_entries(family, "id", "name", "corank", "dimension", "codimension"),
        "pinned": plain(pinned),
        **_entries(family, "free", "coupled"),
        "conditions": list(family.texts),
        **_entries(family, "latex", "equations"),
        "terms": [equation.to_dict()["terms"] for equation in family.equations],
        **_entries(family, "reality", "witness", "lost_words", "rank_check"),
    }
