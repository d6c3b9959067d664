"""The result of an analysis: a frozen record that goes to JSON and back unchanged and can re-check itself.

And its file: what JSON says beside the fields (the joints as a reader wants them, the terms of an equation, shares with
their intervals), and how it is read. Infinities (limits that the source does not give) are null; joints are numbered
from 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any, ClassVar, get_type_hints

import msgspec
import numpy as np

from rankdrop.codec import Record as Record
from rankdrop.codec import Result, check_record, encode, record_of, restore, table_of, value_in_error
from rankdrop.codec import json_text as json_text
from rankdrop.codec import plain as plain
from rankdrop.distance.share import JointSpaceShares, SlowShare
from rankdrop.errors import RankdropError, ResultFileError
from rankdrop.families.corank_families import CorankSummary
from rankdrop.families.derivation import Derivation
from rankdrop.families.record import Family
from rankdrop.families.speed_distance import SpeedDistances
from rankdrop.families.summary import FamilySummary, Verdict
from rankdrop.formula.equation import Equation
from rankdrop.local.block import singular_values
from rankdrop.results.aspect_summary import AspectSummary
from rankdrop.results.contradictions import derivation_from_dict
from rankdrop.results.estimate import evidence_of_sentence, unseen_of_sentence
from rankdrop.results.names import name_of
from rankdrop.results.old_files import conditions_of_derivation, exact_from_dict, freedoms_of_sentences
from rankdrop.results.settings import Residual as Residual
from rankdrop.results.settings import Settings as Settings
from rankdrop.results.validate import check_analysis, with_place
from rankdrop.robot.files import read_text
from rankdrop.robot.model import Robot
from rankdrop.robot.note import NoteOn
from rankdrop.sections import Section, words_of
from rankdrop.task import Task

SCHEMA = "rankdrop/analysis/1"


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
        speeds: how far from each family the tool keeps a speed; None where it was not asked for.
        slow: share of the configurations inside the limits at which the tool is slower than that speed; None likewise.
        aspects: how many aspects the arm has, joint limits ignored; None for arms outside the catalogue where it was
            not asked for.
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
    near: JointSpaceShares | None = None
    speeds: SpeedDistances | None = None
    slow: SlowShare | None = None
    aspects: AspectSummary | None = None
    FILE: ClassVar[str] = "analysis"

    @property
    def verdict(self) -> Verdict:
        """What may be claimed, in one sentence; the exit code follows it."""
        verdict: Verdict = words_of(self).of_analysis(self)
        return verdict

    @property
    def summary(self) -> FamilySummary:
        """Facts of the answer: families by rank, and how they were verified."""
        summary: FamilySummary = words_of(self).summary_of_analysis(self)
        return summary

    @property
    def answer(self) -> str:
        """What the arm has, in one sentence."""
        answer: str = words_of(self).opening(self.summary)
        return answer

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
            max((residual.equation for residual in each), default=0.0),
            max((residual.sigma for residual in each), default=0.0),
            min((residual.kept for residual in each), default=float("inf")),
        )  # fmt: skip

    def residual_of(self, family: Family) -> Residual:
        """Evaluate the equations and singular values of one family again at its witness."""
        q = np.array(family.witness)
        sigma, kept = singular_values(self.robot, q, self.task), self.generic_rank - family.corank
        values = [abs(float(equation(q))) for equation in family.equations]
        return Residual(max(values, default=0.0), float(sigma[kept]), float(sigma[kept - 1]) if kept else float("inf"))

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Analysis):
            return self.to_dict() == other.to_dict()
        return NotImplemented

    __hash__ = None  # type: ignore[assignment]  # equality is by value, of arrays too

    def to_dict(self) -> Record:
        """The analysis as plain data: see docs/json.md."""
        record = super().to_dict()
        if self.settings.limits:
            for row, family in zip(record["families"], self.families, strict=True):
                row["inside"] = record_of("inside", words_of(self).inside_limits(family, self.robot))
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
        if isinstance(record, dict):
            schema = record.get("schema")
        else:
            schema = None
        if schema != SCHEMA:
            got = value_in_error(schema)
            raise ResultFileError("this is not an analysis that can be read", got=got, allowed=SCHEMA)
        if believe:
            return cls._from_dict(record)
        check_record("analysis", record)
        with np.errstate(all="ignore"):  # of numbers that no arm has, which are refused
            made = cls._from_dict(record)
            check_analysis(made, record)
        return made

    @classmethod
    def _from_dict(cls, record: Record) -> Analysis:
        settings: Settings = restore(Settings, record["settings"])
        robot = with_place("$.robot", lambda: robot_from_dict(record["robot"]))
        task = with_place("$.robot.frame", lambda: task_from_dict(record["robot"], settings.length_scale))
        families = tuple(
            with_place(f"$.families[{i}]", partial(family_from_dict, stored, robot, task))
            for i, stored in enumerate(record["families"])
        )
        return cls(
            robot=robot,
            task=task,
            generic_rank=record["robot"]["generic_rank"],
            settings=settings,
            coranks=tuple(corank_from_dict(stored) for stored in record["coranks"]),
            families=with_place("$.exact.families", lambda: conditions_of_derivation(families, record)),
            complete=record["complete"],
            unfinished=record["unfinished"],
            notes=tuple(record["notes"]),
            exact=with_place("$.exact", lambda: _derivation(record)),
            near=_part(record, "near", JointSpaceShares),
            speeds=_part(record, "speeds", SpeedDistances),
            slow=_part(record, "slow", SlowShare),
            aspects=with_place("$.aspects", lambda: _aspects(record)),
        )

    def sections(self) -> tuple[Section, ...]:
        """The answer, then one section for each corank."""
        sections: tuple[Section, ...] = words_of(self).sections_of(self)
        return sections

    def latex(self) -> str:
        """Its tables as AM print them, one for each corank, for a paper: see `rankdrop.text.latex.latex_tables`."""
        tables: str = words_of(self).latex_of(self)
        return tables

    @classmethod
    def load(cls, path: str | Path) -> Analysis:
        """Read an analysis from a JSON file.

        Raises:
            ResultFileError: the file cannot be read or is not an analysis.
        """
        try:
            return cls.from_dict(read_record(path))
        except ResultFileError as error:
            if error.where in (None, str(path)):
                where = str(path)
            else:
                where = f"{path}, {error.where}"
            raise ResultFileError(
                error.what, where=where, got=error.got, allowed=error.allowed, mend=error.mend, typed=error.typed
            ) from error


def read_record(path: str | Path) -> Any:
    """The data in a JSON file.

    Raises:
        ResultFileError: the file cannot be read, is too large, or is not JSON; NaN and infinities are none.
    """
    try:
        Path(path).stat()
        return msgspec.json.decode(read_text(Path(path)))
    except OSError as error:
        raise ResultFileError(f"the file cannot be read: {error.strerror or error}", where=str(path)) from error
    except RankdropError as error:
        raise ResultFileError(error.what, where=error.where, got=error.got, allowed=error.allowed) from error
    except RecursionError:
        what = "the file cannot be read as JSON: its lists and objects are nested too deeply"
        raise ResultFileError(what, where=str(path)) from None
    except (ValueError, msgspec.MsgspecError) as error:
        raise ResultFileError("the file cannot be read as JSON", where=str(path), got=str(error)[:200]) from error


def robot_to_dict(robot: Robot, task: Task, generic_rank: int) -> Record:
    """The arm as analysed: what a reader wants first, then `chain`, from which the robot is built again."""
    return encode(table_of("robot"), (robot, task, generic_rank))


def robot_from_dict(record: Record) -> Robot:
    """The robot of a record made by `robot_to_dict`."""
    lengths = list(record.get("lengths", {}).items())
    chain = [{key: value for key, value in joint.items() if value is not None} for joint in record["chain"]]
    notes = [{"kind": NoteOn.GIVEN, "text": note} for note in record["notes"]]
    fields = {"joints": chain, "task": record["made_for"], "lengths": lengths, "notes": notes}
    robot: Robot = restore(Robot, record | fields)
    return robot


def task_from_dict(record: Record, length_scale: float) -> Task:
    """The task of a record made by `robot_to_dict`; its length scale [m] stands among the settings."""
    task: Task = restore(Task, {**record, "name": record["task"], "length_scale": length_scale})
    return task


def _check(record: Record, agree: str) -> Record:
    return {"tested": record["tested"], "agree": record[agree]}


def corank_from_dict(record: Record) -> CorankSummary:
    """The summary of a record made by `SUMMARY`."""
    entries = record | {"completeness": _check(record["completeness"], "explained")}
    given = {name: restore(kind, entries[name]) for name, kind in _summary_types().items() if name != "unseen"}
    unseen = record["unseen"]
    estimate, upper = float(unseen["estimate"]), float(unseen["upper"])
    return CorankSummary(**given, unseen=unseen_of_sentence(unseen["how"], estimate, upper))


@cache
def _summary_types() -> dict[str, Any]:
    """Field of the summary of a corank -> its type."""
    return get_type_hints(CorankSummary)


@cache
def _family_types() -> dict[str, Any]:
    """Field of a family -> its type: looked up once, which takes a millisecond."""
    return get_type_hints(Family)


def family_from_dict(record: Record, robot: Robot, task: Task) -> Family:
    """The family of a record made by `FAMILY`.

    Args:
        record: of any version.
        robot, task: the arm, for what versions up to 0.2 wrote as sentences.

    Raises:
        ResultFileError: an equation whose text and terms say different things.
    """
    checks = {name: _check(record[name], agree) for name, agree in (("soundness", "singular"), ("explained",) * 2)}
    kinds, own = _family_types(), record.keys() - {"called", "equations", "evidence", "exact"}
    given = {name: restore(kind, (record | checks)[name]) for name, kind in kinds.items() if name in own}
    if "lost_freedoms" not in own:
        given["lost_freedoms"] = freedoms_of_sentences(
            record["lost_words"], robot, task, record["corank"], record["witness"]
        )
    given["called"] = name_of(record)
    given["evidence"] = evidence_of_sentence(record["evidence"])
    if "exact" in record:
        given["exact"] = exact_from_dict(record["exact"])
    family = Family(**given, equations=tuple(Equation.from_dict({"terms": terms}) for terms in record["terms"]))
    if plain(family.equations) != record["equations"]:
        raise ResultFileError("equations and terms of a family disagree", where=f"family {record['id']}")
    return family


def _derivation(record: Record) -> Derivation | None:
    """The entry `exact`; None where the record has none."""
    if "exact" not in record:
        return None
    return derivation_from_dict(record["exact"])


def _part(record: Record, entry: str, kind: type[Any]) -> Any:
    """An entry that is absent where it was not computed."""
    if entry not in record:
        return None
    return with_place(f"$.{entry}", lambda: restore(kind, record[entry]))


def _aspects(record: Record) -> AspectSummary | None:
    """The entry `aspects`; None where the record has none."""
    if "aspects" not in record:
        return None
    aspects: AspectSummary = restore(AspectSummary, record["aspects"])
    return aspects
