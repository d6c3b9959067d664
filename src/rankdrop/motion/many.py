"""Many paths of one arm: a table, worst first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from rankdrop.errors import RankdropError
from rankdrop.motion.data import CROSSING, TOUCHING, VERDICTS
from rankdrop.motion.result import PathCheck
from rankdrop.results.codec import Record, number_or_null
from rankdrop.results.explanation.words import short
from rankdrop.robot.model import Robot
from rankdrop.sections import Section
from rankdrop.units import heading

SCHEMA = "rankdrop/paths/1"


@dataclass(frozen=True, eq=False)
class Judged:
    """One file.

    Attributes:
        file: as it was named.
        result: None where it could not be read.
        error: why.
    """

    file: Path
    result: PathCheck | None
    error: str

    @property
    def verdict(self) -> str:
        """Of the path; "bad input" where there is none."""
        return "bad input" if self.result is None else self.result.verdict

    @property
    def nearest(self) -> float:
        """Least distance from a singularity known, 0 where one is met; inf where none is known."""
        if self.result is None:
            return float("inf")
        return min((one.closest.distance for one in self.result.stretches), default=float("inf"))


def judged(files: Sequence[Path], check: Callable[[Path], PathCheck]) -> list[Judged]:
    """Every file judged, worst first; Ctrl-C ends it and keeps those that are done.

    Args:
        files: to be read.
        check: reads one and judges it.
    """
    done: list[Judged] = []
    try:
        for file in files:
            try:
                done.append(Judged(file, check(file), ""))
            except RankdropError as error:
                done.append(Judged(file, None, error.on_command_line()))
            if (last := done[-1].result) is not None and not last.complete:
                break
    except KeyboardInterrupt:
        pass  # the table says how many of the files there are in it
    order = ("bad input", *VERDICTS)
    return sorted(done, key=lambda one: (order.index(one.verdict), one.nearest, str(one.file)))


def many_section(many: Sequence[Judged]) -> Section:
    """The table."""
    holds = sum(one.result is not None and one.result.holds for one in many)
    rows = []
    for one in many:
        if one.result is None:
            rows.append((str(one.file), one.verdict, "", "", "", ""))
            continue
        met = [part for part in one.result.stretches if part.verdict in (CROSSING, TOUCHING)]
        first = one.result.stretches[0] if one.result.stretches else None
        near = short(one.nearest, 3) if isfinite(one.nearest) and not met else ""
        rows.append((
            str(one.file), one.verdict, str(one.result.rows), str(len(met)), near, first.name if first else "",
        ))  # fmt: skip
    return Section(
        f"{holds} of {len(many)} paths proven free",
        columns=("file", "verdict", "rows", "met", "nearest [rad]", "family"), rows=tuple(rows), texts=(0, 1, 5),
        after=tuple(one.error for one in many if one.error),
    )  # fmt: skip


def paths_to_dict(robot: Robot, many: Sequence[Judged]) -> Record:
    """For a file: each path in short."""
    return {
        **heading(SCHEMA),
        "robot": robot.name,
        "paths": [
            {
                "file": str(one.file),
                "verdict": one.verdict,
                "sentence": one.error if one.result is None else one.result.sentence,
                "rows": None if one.result is None else one.result.rows,
                "free_share": None if one.result is None else one.result.free_share,
                "met": None if one.result is None else len(one.result.crossings),
                "nearest_rad": number_or_null(one.nearest),
                "complete": one.result is not None and one.result.complete,
            }
            for one in many
        ],
    }
