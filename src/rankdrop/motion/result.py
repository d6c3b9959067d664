"""A path judged, as what `check_path` returns.

As plain data it has the names of docs/json.md; rows and joints are numbered from 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rankdrop.local.block import generic_rank
from rankdrop.motion.curve import Curve
from rankdrop.motion.data import CROSSING, FREE, TOUCHING, PathSettings, Place, Profile, Stretch, ToolMotion
from rankdrop.motion.text import path_sections
from rankdrop.results.codec import Record, plain, robot_to_dict
from rankdrop.robot.model import Robot
from rankdrop.sections import Section, html, text
from rankdrop.task import Task
from rankdrop.units import heading


@dataclass(frozen=True, eq=False)
class PathCheck:
    """A path judged.

    Attributes:
        robot, task: the arm and its task, its length scale worked out.
        curve: the path.
        rows: number of samples.
        settings: what was asked.
        verdict: "free", "crossing", "touching", "too near" or "undecided".
        sentence: the verdict for people.
        stretches: all parts, worst first.
        free_share: of the length in joint space, proven free.
        undecided_share, undecided_length, undecided_time: what is undecided: share of the length, length [rad], and
            time [s; None without times].
        margin: what is known of `min_distance`: "kept" (proven), "violated" (a nearer singular configuration was
            found), "not proven"; None where none was asked for.
        evaluations: enclosures spent.
        source: where the families are from: "catalogue", "analysis" or "on the spot".
        notes: what a reader should know, limits that are left for one.
        complete: False where it was interrupted.
        profile: for drawings.
        tool: how joint values were found, where poses of the tip were given; else None.
    """

    robot: Robot
    task: Task
    curve: Curve
    rows: int
    settings: PathSettings
    verdict: str
    sentence: str
    stretches: tuple[Stretch, ...]
    free_share: float
    undecided_share: float
    undecided_length: float
    undecided_time: float | None
    margin: str | None
    evaluations: int
    source: str
    notes: tuple[str, ...]
    complete: bool
    profile: Profile
    tool: ToolMotion | None = None

    @property
    def holds(self) -> bool:
        """Proven free, and the distance asked for proven to be kept."""
        return self.verdict == FREE and self.complete

    @property
    def free_words(self) -> str:
        """The share that is proven free in per cent, never rounded up to the whole: a crossing is a point of it."""
        text = f"{100 * self.free_share:.6g}"
        all_of_it = self.free_share == 1.0 and not self.crossings
        return "more than 99.9999 %" if text == "100" and not all_of_it else f"{text} %"

    @property
    def crossings(self) -> tuple[Stretch, ...]:
        """Where it meets singularities, crossing or touching, in order along the path."""
        met = [one for one in self.stretches if one.verdict in (CROSSING, TOUCHING)]
        return tuple(sorted(met, key=lambda one: (one.start.row, one.start.share)))

    def to_dict(self) -> dict[str, Any]:
        """The record that `rankdrop path --json` writes."""
        return path_to_dict(self)

    def sections(self, *, deg: bool = True, full: bool = False) -> tuple[Section, ...]:
        """As sections of text; `full`: every stretch, not the ten worst."""
        return path_sections(self, deg=deg, full=full)

    def __str__(self) -> str:
        return text(self.sections())

    def _repr_html_(self) -> str:
        return html(self.sections())


SCHEMA = "rankdrop/path/1"


def path_to_dict(check: PathCheck) -> Record:
    """Everything but the samples."""
    met = [one for one in check.stretches if one.verdict in (CROSSING, TOUCHING)]
    met.sort(key=lambda one: (one.start.row, one.start.share))
    return {
        **heading(SCHEMA),
        "robot": robot_to_dict(check.robot, check.task, generic_rank(check.robot, check.task)),
        "settings": plain(check.settings),
        "rows": check.rows,
        "verdict": check.verdict,
        "sentence": check.sentence,
        "free_share": check.free_share,
        "undecided": {
            "time": check.undecided_time, "share": check.undecided_share, "length": check.undecided_length
        },
        "min_distance": check.margin,
        "crossings": [_crossing(one) for one in met],
        "stretches": [_stretch(one) for one in check.stretches],
        "profile": plain(check.profile),
        "evaluations": check.evaluations,
        "source": check.source,
        "notes": list(check.notes),
        "complete": check.complete,
        "tool": None if check.tool is None else _tool(check.tool),
    }  # fmt: skip


def _tool(tool: ToolMotion) -> Record:
    return {
        "poses": tool.poses, "complete": tool.complete, "reached": tool.reached, "reason": tool.reason,
        "words": tool.words, "start": list(tool.start), "chosen": tool.chosen, "off": tool.off,
    }  # fmt: skip


def _span(stretch: Stretch, start: Place, end: Place) -> Record:
    timed = start.time is not None and end.time is not None
    return {
        "rows": [_row(start), _row(end)],
        "time": [start.time, end.time] if timed else None,
        "family": stretch.family,
        "name": stretch.name,
    }


def _row(place: Place) -> float:
    """Row with the share of the way to the next as a fraction."""
    return place.row + place.share


def _crossing(stretch: Stretch) -> Record:
    return {
        **_span(stretch, *stretch.bracket),
        "corank": stretch.corank,
        "q": stretch.closest.q.tolist(),
        "touching": stretch.verdict == TOUCHING,
        "lies": stretch.lies,
        "how": stretch.how,
    }


def _stretch(stretch: Stretch) -> Record:
    closest = stretch.closest
    return {
        **_span(stretch, stretch.start, stretch.end),
        "verdict": stretch.verdict,
        "corank": stretch.corank,
        "how": stretch.how,
        "closest": {
            "row": _row(closest.place),
            "time": closest.place.time,
            "q": closest.q.tolist(),
            "distance_rad": plain(closest.distance),
            "singular_q": closest.foot.tolist() or None,
            "sigma": closest.sigma,
            "weak_share": _number(closest.weak),
        },
        "lost": list(stretch.lost),
        "null_share": _number(stretch.null_share),
        "rates": stretch.rates.tolist() or None,
        "speed_factor": _number(stretch.speed_factor),
        "slowest": stretch.slowest or None,
    }


def _number(value: float) -> float | None:
    """A number, or null where there is none."""
    return None if value != value else value
