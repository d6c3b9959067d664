"""What a sweep found: every variant with its measures, what differs between neighbours, the Pareto-optimal variants.

Of a Pareto-optimal variant, every better value of one measure costs something else.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from rankdrop.codec import Result
from rankdrop.designs.ranking import NeighbourChange, Ranking, SameFamilies, changes, neighbours, rank, structures
from rankdrop.designs.spec import GOALS, UNRANKED, Parameter, Spec
from rankdrop.errors import OptionError
from rankdrop.lists import flat_map
from rankdrop.robot import Robot
from rankdrop.sections import Section, words_of
from rankdrop.task import Task
from rankdrop.text.designs import MEANINGS as MEANINGS
from rankdrop.text.designs import UNITS as UNITS


@dataclass(frozen=True, eq=False)
class Designs(Result):
    """A finished sweep.

    Attributes:
        spec: the arm, its parameters, the task, what is measured.
        records: of every variant, by its number; docs/howto/comparing-designs.md says what is in them.
        exact: one variant of each of the commonest sets of families, derived exactly with letters for the lengths:
            its families, and for which lengths they are real; empty where not asked for or not derived.
        folder: where parts and tables are kept; None: nowhere.
    """

    spec: Spec
    records: Sequence[Mapping[str, Any]]
    exact: tuple[Mapping[str, Any], ...] = ()
    folder: Path | None = None
    FILE: ClassVar[str] = "sweep"

    @property
    def robot(self) -> str:
        """Name of the arm that was varied."""
        return self.spec.drawing.nominal.name

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What was varied, in order."""
        return self.spec.parameters

    @property
    def measures(self) -> list[str]:
        """Names of the measures, in their order."""
        return measures_of(self.records)

    @cached_property
    def failed(self) -> tuple[int, ...]:
        """Numbers of the variants with an error, from 0."""
        return tuple(int(record["number"]) for record in self.records if record["error"] is not None)

    @cached_property
    def unverified(self) -> tuple[int, ...]:
        """Numbers of the variants whose families were asked for and do not hold, from 0."""
        doubted = (record for record in self.records if record.get("verdict", "verified") != "verified")
        return tuple(int(record["number"]) for record in doubted)

    @property
    def holds(self) -> bool:
        """Whether every variant was measured and its families are verified."""
        return not self.failed and not self.unverified

    @cached_property
    def structures(self) -> list[SameFamilies]:
        """Variants by their set of families."""
        return structures(self.records)

    @cached_property
    def changes(self) -> list[NeighbourChange]:
        """What differs between neighbours."""
        names = [parameter.name for parameter in self.parameters]
        return changes(self.records, names, neighbours(self.spec, self.records))

    @cached_property
    def ranking(self) -> Ranking:
        """The variants that no other one dominates beyond the error of the samples."""
        return rank(self.records, self.spec.goals)

    @property
    def pareto(self) -> list[int]:
        """Their numbers, from 0."""
        return self.ranking.best

    def values(self, measure: str) -> list[float | None]:
        """One measure of every variant.

        Raises:
            OptionError: there is no such measure.
        """
        if measure not in self.measures:
            raise OptionError("there is no such measure", got=measure, allowed=", ".join(self.measures))
        return [record["measures"].get(measure) for record in self.records]

    @property
    def sentence(self) -> str:
        """What was found, in one sentence."""
        sentence: str = words_of(self).sweep_sentence(self)
        return sentence

    @property
    def summary(self) -> tuple[str, ...]:
        """The lines printed first: the result, the best variant or one of several, ranges of measures, what is next."""
        lines: tuple[str, ...] = words_of(self).sweep_summary(self)
        return lines

    def sections(self, *, every: bool = False) -> Iterator[Section]:
        """As sections of text; `every`: all variants, not only the Pareto-optimal ones."""
        sections: Iterator[Section] = words_of(self).sweep_sections(self, every=every)
        return sections

    def row(self, record: Mapping[str, Any]) -> tuple[str, ...]:
        """Parameters and measures of a variant, for people."""
        row: tuple[str, ...] = words_of(self).variant_row(self, record)
        return row


def measures_of(records: Sequence[Mapping[str, Any]]) -> list[str]:
    """Names of the measures of records, in their order."""
    names = set(flat_map(lambda record: record["measures"], records))
    return [name for name in UNITS if name in names]


def in_doubt(record: Mapping[str, Any]) -> bool:
    """Whether an arm could not be measured as a whole, or its families are not verified."""
    return record["error"] is not None or record.get("verdict", "verified") != "verified"


@dataclass(frozen=True, eq=False)
class SideBySide(Result):
    """Arms measured for the same task.

    Attributes:
        names: of the arms, as they were given.
        robots: the arms.
        task: with the length scale of σ, the same for all.
        limits: inside the joint limits.
        seed: of every random choice.
        records: of the arms, in their order; as those of a sweep.
    """

    names: tuple[str, ...]
    robots: tuple[Robot, ...]
    task: Task
    limits: bool
    seed: int
    records: Sequence[Mapping[str, Any]]
    FILE: ClassVar[str] = "side-by-side"

    @property
    def measures(self) -> list[str]:
        """Names of the measures, in their order."""
        return measures_of(self.records)

    @property
    def holds(self) -> bool:
        """Whether every arm was measured and its families, where asked for, are verified."""
        return not any(map(in_doubt, self.records))

    def best(self, measure: str) -> tuple[int, ...]:
        """The arms, from 0, that are best by one measure; those within the error of the best are too."""
        records = [{**record, "error": None} for record in self.records]
        return tuple(rank(records, {measure: GOALS[measure]}).best)

    @property
    def doubtful(self) -> tuple[str, ...]:
        """The arms that could not be measured as a whole, or have families that are not verified."""
        return tuple(name for name, record in zip(self.names, self.records, strict=True) if in_doubt(record))

    def distinguished(self, measure: str) -> tuple[int, ...]:
        """The arms, from 0, that are best by a measure of which less or more is better; () where none stands out."""
        best = self.best(measure)
        if measure not in UNRANKED and len(best) < len(self.names):
            return best
        return ()

    @property
    def sentence(self) -> str:
        """What was found, in one sentence."""
        sentence: str = words_of(self).compared_arms_sentence(self)
        return sentence

    def sections(self, *, full: bool = True) -> Iterator[Section]:
        """As sections of text: a column for each arm; then each arm with all its families, or without `full` in a line.
        """
        sections: Iterator[Section] = words_of(self).compared_arms_sections(self, full=full)
        return sections
