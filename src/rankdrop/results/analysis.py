"""The result of an analysis: a frozen record that goes to JSON and back unchanged and can re-check itself.

How an analysis was checked, in sentences that the terminal and the report share; every number is in the JSON too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import ClassVar

import numpy as np

from rankdrop.codec import Result, check_record, record_of, shown
from rankdrop.errors import ResultFileError
from rankdrop.families.share import Near
from rankdrop.family.record import CorankSummary, Derivation, Family
from rankdrop.local.block import singular_values
from rankdrop.results.codec import (
    Record,
    corank_from_dict,
    family_from_dict,
    read_record,
    restored,
    robot_from_dict,
    task_from_dict,
)
from rankdrop.results.validate import at, check_analysis
from rankdrop.results.verdict import Verdict, of_analysis
from rankdrop.robot.model import Robot
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.text.families import inside_limits, overview, share_text
from rankdrop.text.latex import latex_tables
from rankdrop.tolerances import Tolerances

SCHEMA = "rankdrop/analysis/1"


@dataclass(frozen=True, slots=True)
class Settings:
    """What the analysis was asked to do; together with the robot and the version it determines the result.

    Attributes:
        seed: every random choice comes from it.
        starts: random starts for each corank.
        limits: starts and fresh points within the joint limits only.
        length_scale: translation rows were divided by it [m].
        tolerances: every threshold used.
        version: of rankdrop.
    """

    seed: int
    starts: int
    limits: bool
    length_scale: float
    tolerances: Tolerances
    version: str


@dataclass(frozen=True, slots=True)
class Residual:
    """A witness, or the worst of several, evaluated again.

    Attributes:
        equation: largest |equation| at the witness (0 where the family has none).
        sigma: largest of the singular values that have to vanish.
        kept: smallest of those that must not.
    """

    equation: float
    sigma: float
    kept: float

    def holds(self, tolerances: Tolerances) -> bool:
        """Whether the witness satisfies its equations and has exactly the corank of its family."""
        return self.equation <= tolerances.explained and self.sigma <= tolerances.singular < self.kept


@dataclass(frozen=True, eq=False)
class Analysis(Result):
    """Every family of singular configurations that was found, of every corank, with what speaks for it.

    Attributes:
        robot: the arm.
        task: the task, its length scale resolved.
        generic_rank: rank of the task Jacobian almost everywhere; corank k means rank `generic_rank − k`.
        settings: seed, starts, tolerances, version.
        coranks: one summary per corank searched, the last one (nothing found) included.
        families: rows of all coranks, in order.
        complete: False when the analysis was interrupted.
        unfinished: the corank that was being worked on then.
        notes: what the reader should be told.
        exact: the exact derivation of the families; None where it was not asked for.
        near: share of the joint space near each family; None where it was not asked for.
    """

    robot: Robot
    task: Task
    generic_rank: int
    settings: Settings
    coranks: tuple[CorankSummary, ...]
    families: tuple[Family, ...]
    complete: bool = True
    unfinished: int | None = None
    notes: tuple[str, ...] = ()
    exact: Derivation | None = None
    near: Near | None = None
    FILE: ClassVar[str] = "analysis"

    @property
    def verdict(self) -> Verdict:
        """What may be claimed, in one sentence; the exit code follows it."""
        return of_analysis(self)

    @property
    def verified(self) -> bool:
        """Whether the families hold numerically, and nothing derived exactly says otherwise."""
        return self.verdict.holds

    @property
    def sound_and_complete(self) -> bool:
        """Whether every fresh point is explained, every row has equations, and every row is sound."""
        explained = all(row.completeness.agree == row.completeness.tested for row in self.coranks)
        sound = all(row.named and row.soundness.agree == row.soundness.tested for row in self.families)
        return explained and sound

    def of_corank(self, corank: int) -> tuple[Family, ...]:
        """The families of one corank."""
        return tuple(family for family in self.families if family.corank == corank)

    def residual(self) -> Residual:
        """Evaluate all equations and singular values again at the witnesses: the worst of each."""
        each = [self.residual_of(family) for family in self.families]
        return Residual(
            max((one.equation for one in each), default=0.0), max((one.sigma for one in each), default=0.0),
            min((one.kept for one in each), default=float("inf")),
        )  # fmt: skip

    def residual_of(self, family: Family) -> Residual:
        """Evaluate the equations and singular values of one family again at its witness."""
        q = np.array(family.witness)
        sigma, kept = singular_values(self.robot, q, self.task), self.generic_rank - family.corank
        values = [abs(float(equation(q))) for equation in family.equations]
        return Residual(max(values, default=0.0), float(sigma[kept]), float(sigma[kept - 1]) if kept else float("inf"))

    def __eq__(self, other: object) -> bool:
        return self.to_dict() == other.to_dict() if isinstance(other, Analysis) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # equality is by value, of arrays too

    def to_dict(self) -> Record:
        """The analysis as plain data: see docs/json.md."""
        record = super().to_dict()
        if self.settings.limits:
            for row, family in zip(record["families"], self.families, strict=True):
                row["inside"] = record_of("inside", inside_limits(family, self.robot))
        return record

    @classmethod
    def from_dict(cls, record: Record, *, believe: bool = False) -> Analysis:
        """Build the analysis of a record made by `to_dict`, and hold it against its schema and its own arm.

        Args:
            record: plain data.
            believe: take it as it is: for what was made by this process or is shipped with the package.

        Raises:
            ResultFileError: another schema, or an element that is missing, makes no sense, or contradicts the arm:
                generic rank, and rank, σ, equations and lost directions at every witness are computed again. Names the
                path of the element.
        """
        found = record.get("schema") if isinstance(record, dict) else None
        if found != SCHEMA:
            raise ResultFileError("this is not an analysis that can be read", got=shown(found), allowed=SCHEMA)
        if believe:
            return cls._from_dict(record)
        check_record("analysis", record)
        with np.errstate(all="ignore"):  # of numbers that no arm has, which are refused
            made = cls._from_dict(record)
            check_analysis(made, record)
        return made

    @classmethod
    def _from_dict(cls, record: Record) -> Analysis:
        settings: Settings = restored(Settings, record["settings"])
        families = enumerate(record["families"])
        return cls(
            robot=at("$.robot", lambda: robot_from_dict(record["robot"])),
            task=at("$.robot.frame", lambda: task_from_dict(record["robot"], settings.length_scale)),
            generic_rank=record["robot"]["generic_rank"],
            settings=settings,
            coranks=tuple(corank_from_dict(one) for one in record["coranks"]),
            families=tuple(at(f"$.families[{i}]", partial(family_from_dict, one)) for i, one in families),
            complete=record["complete"],
            unfinished=record["unfinished"],
            notes=tuple(record["notes"]),
            exact=at("$.exact", lambda: _derivation(record["exact"])) if "exact" in record else None,
            near=at("$.near", lambda: restored(Near, record["near"])) if "near" in record else None,
        )

    def sections(self) -> tuple[Section, ...]:
        """One section for each corank."""
        return tuple(overview(self.robot, self.generic_rank, self.coranks, self.families, self.exact,
                              limits=self.settings.limits))  # fmt: skip

    def __str__(self) -> str:
        return f"{self.robot.name}: {self.verdict.sentence}\n\n{super().__str__()}"

    def latex(self) -> str:
        """Its tables as AM print them, one for each corank, for a paper: see `rankdrop.text.latex.latex_tables`."""
        return latex_tables(self.robot, self.generic_rank, self.coranks, self.families, self.exact,
                            limits=self.settings.limits)  # fmt: skip

    @classmethod
    def load(cls, path: str | Path) -> Analysis:
        """Read an analysis from a JSON file.

        Raises:
            ResultFileError: the file cannot be read or is not an analysis.
        """
        try:
            return cls.from_dict(read_record(path))
        except ResultFileError as error:
            where = str(path) if error.where in (None, str(path)) else f"{path}, {error.where}"
            raise ResultFileError(
                error.what, where=where, got=error.got, allowed=error.allowed, mend=error.mend, typed=error.typed
            ) from error


def _derivation(record: Record) -> Derivation:
    """The entry `exact`; up to 0.2 derived families were matched with fitted rows and might have their own numbers."""
    derivation: Derivation = restored(Derivation, record)
    if "matches" not in record:
        return derivation
    same = {one["row"] for one in record["matches"] if one["families"] == [one["row"]] and not one["parts"]}
    return replace(derivation, families=tuple(one for one in derivation.families if one.id in same))


def sampled(analysis: Analysis) -> str:
    """How many solutions of the rows' conditions are singular, how many fresh points the rows explain; "" for none."""
    if not analysis.families:
        return ""
    solved = sum(row.soundness.tested for row in analysis.families)
    singular = sum(row.soundness.agree for row in analysis.families)
    fresh = sum(row.completeness.tested for row in analysis.coranks)
    explained = sum(row.completeness.agree for row in analysis.coranks)
    return (
        f"Tested: {singular:,} of {solved:,} points solved from the rows' conditions are singular "
        f"(σ ≤ {analysis.settings.tolerances.singular:g}). "
        f"Explained: {explained:,} of {fresh:,} fresh singular points, none of which made the rows "
        f"({share_text(explained, fresh)})."
    )


def unseen(analysis: Analysis) -> str:
    """What the searches may have missed, at the corank where that is most; "" where nothing converged."""
    found = [row for row in analysis.coranks if row.converged]
    if not found:
        return ""
    worst = max(found, key=lambda row: row.unseen.upper)
    share = f"an estimated {100 * worst.unseen.estimate:.2f} %, at most {100 * worst.unseen.upper:.2f} % (95 %)"
    how = f"{worst.unseen.how[0].upper()}{worst.unseen.how[1:]}"
    return f"What sampling may have missed: {share} of its searches, worst at corank {worst.corank}. {how}."
