"""A judged path as plain data: docs/json.md and schema/path.schema.json. Rows and joints are numbered from 1."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rankdrop.local.block import generic_rank
from rankdrop.motion.data import CROSSING, TOUCHING, Place, Stretch, ToolMotion
from rankdrop.results.codec import Record, plain, robot_to_dict
from rankdrop.units import heading

if TYPE_CHECKING:
    from rankdrop.motion.result import PathCheck

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
