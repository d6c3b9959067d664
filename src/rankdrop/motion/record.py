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


def path_to_dict(found: PathCheck) -> Record:
    """Everything but the samples."""
    met = [one for one in found.stretches if one.verdict in (CROSSING, TOUCHING)]
    met.sort(key=lambda one: (one.start.row, one.start.share))
    return {
        **heading(SCHEMA),
        "robot": robot_to_dict(found.robot, found.task, generic_rank(found.robot, found.task)),
        "settings": plain(found.settings),
        "rows": found.rows,
        "verdict": found.verdict,
        "sentence": found.sentence,
        "free_share": found.free_share,
        "undecided": {
            "time": found.undecided_time, "share": found.undecided_share, "length": found.undecided_length
        },
        "min_distance": found.margin,
        "crossings": [_crossing(one) for one in met],
        "stretches": [_stretch(one) for one in found.stretches],
        "profile": plain(found.profile),
        "evaluations": found.evaluations,
        "source": found.source,
        "notes": list(found.notes),
        "complete": found.complete,
        "tool": None if found.tool is None else _tool(found.tool),
    }  # fmt: skip


def _tool(tool: ToolMotion) -> Record:
    return {
        "poses": tool.poses, "complete": tool.complete, "reached": tool.reached, "reason": tool.reason,
        "words": tool.words, "start": list(tool.start), "chosen": tool.chosen, "off": tool.off,
    }  # fmt: skip


def _span(one: Stretch, start: Place, end: Place) -> Record:
    timed = start.time is not None and end.time is not None
    return {
        "rows": [_row(start), _row(end)],
        "time": [start.time, end.time] if timed else None,
        "family": one.family,
        "name": one.name,
    }


def _row(place: Place) -> float:
    """Row with the share of the way to the next as a fraction."""
    return place.row + place.share


def _crossing(one: Stretch) -> Record:
    return {
        **_span(one, *one.bracket),
        "corank": one.corank,
        "q": one.closest.q.tolist(),
        "touching": one.verdict == TOUCHING,
        "lies": one.lies,
        "how": one.how,
    }


def _stretch(one: Stretch) -> Record:
    closest = one.closest
    return {
        **_span(one, one.start, one.end),
        "verdict": one.verdict,
        "corank": one.corank,
        "how": one.how,
        "closest": {
            "row": _row(closest.place),
            "time": closest.place.time,
            "q": closest.q.tolist(),
            "distance_rad": plain(closest.distance),
            "singular_q": closest.foot.tolist() or None,
            "sigma": closest.sigma,
            "weak_share": _number(closest.weak),
        },
        "lost": list(one.lost),
        "null_share": _number(one.null_share),
        "rates": one.rates.tolist() or None,
        "speed_factor": _number(one.speed_factor),
        "slowest": one.slowest or None,
    }


def _number(value: float) -> float | None:
    """A number, or null where there is none."""
    return None if value != value else value
