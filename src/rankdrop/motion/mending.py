"""What `mend_path` returns: remedies, each one change of a path with what it gains and the judgement of the path that
it makes; for people, as a record, and as a file.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, isfinite, isnan
from typing import Any

from rankdrop.motion.record import PathCheck
from rankdrop.motion.retime import Usage
from rankdrop.motion.trajectory import Trajectory
from rankdrop.results.codec import number_or_null
from rankdrop.results.explanation.words import fixed, short
from rankdrop.robot.model import Robot
from rankdrop.sections import Section, html, text
from rankdrop.units import counted_length

RETIME, NULL, FLIP, BLEND, TILT, SHIFT = "retime", "null-space", "flip", "blend", "tool tilt", "base shift"
KINDS = (NULL, FLIP, BLEND, TILT, SHIFT, RETIME)
"""Those that leave the tool's path come first; retime changes the time only."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number, or some, that a remedy is made with.

    Attributes:
        name: of what.
        value: one number, or one for each joint or axis.
        unit: "rad", "m", "s", "rad, m" for joint values, or "" for a number without.
    """

    name: str
    value: float | tuple[float, ...]
    unit: str


@dataclass(frozen=True, slots=True)
class Gain:
    """A number before and after.

    Attributes:
        what: "distance" (joint space, to the nearest singular configuration known; 0 where the path meets one),
            "speed" (factor, at most 1, that keeps the limits of the joints) or "duration".
        before, after: inf or nan where not known.
        unit: "rad", "" or "s".
    """

    what: str
    before: float
    after: float
    unit: str


@dataclass(frozen=True, eq=False)
class Remedy:
    """A path that was mended and judged again.

    Attributes:
        kind: one of `KINDS`.
        words: what is done, as a sentence.
        parameters: what with.
        gains: what it gains.
        trajectory: the new path; in time where the old one is.
        interpolate: between its rows.
        check: the new judgement: free, proven, with the distance asked for kept. Of retime, which keeps the path, it
            may be any; that kind is judged by its limits.
        usage: shares of the rate and acceleration limits that it nowhere exceeds, at most 1; None without times or
            limits.
        off: how far the tool is from the path meant, at most, in the middle between two of its rows [m], [rad];
            at the rows it is on it. Of a blend: from the old path, anywhere it was looked at.
        retimed: it has a new time law as well, because the old one would break limits.
    """

    kind: str
    words: str
    parameters: tuple[Parameter, ...]
    gains: tuple[Gain, ...]
    trajectory: Trajectory
    interpolate: str
    check: PathCheck
    usage: Usage | None
    off: tuple[float, float]
    retimed: bool


@dataclass(frozen=True, eq=False)
class Mending:
    """What was tried of a path.

    Attributes:
        before: the judgement of the path as it was.
        remedies: found and proven, in the order of `KINDS`.
        notes: for each kind without one, what was tried and what came of it.
        needed: the path needs one: it is not proven free and far enough, or breaks limits.
        complete: False where it was interrupted; what was found until then holds.
    """

    before: PathCheck
    remedies: tuple[Remedy, ...]
    notes: tuple[str, ...]
    needed: bool
    complete: bool

    @property
    def best(self) -> Remedy | None:
        """The first that is proven free, in the order of `KINDS`; None where there is none."""
        return next((one for one in self.remedies if one.check.clear), None)

    def sections(self, *, deg: bool = True) -> tuple[Section, ...]:
        """As sections of text."""
        return (Section(self.sentence, lines=tuple(line for one in self.remedies for line in _lines(one, deg=deg))),
                *([Section("Remedies that were not found", lines=self.notes)] if self.notes else []))  # fmt: skip

    @property
    def sentence(self) -> str:
        """One line for people."""
        if not self.needed:
            return "Remedies: none is needed."
        stopped = "" if self.complete else ", interrupted: not all kinds were tried"
        if not self.remedies:
            return f"Remedies: none was found{stopped}; that is no proof that there is none."
        free = [one.kind for one in self.remedies if one.check.clear]
        kept = [one.kind for one in self.remedies if not one.check.clear]
        parts = [f"{', '.join(free)} (judged again: free, proven)"] if free else []
        parts += [f"{', '.join(kept)} (limits kept; it still meets a singularity)"] if kept else []
        return f"Remedies: {'; '.join(parts)}{stopped}."

    def to_dict(self) -> dict[str, Any]:
        """The entry `remedies` of the record that `rankdrop path --json` writes."""
        return {
            "needed": self.needed,
            "sentence": self.sentence,
            "found": [_record(one) for one in self.remedies],
            "notes": list(self.notes),
            "complete": self.complete,
        }

    def __str__(self) -> str:
        return text(self.sections())

    def _repr_html_(self) -> str:
        return html(self.sections())


def _lines(remedy: Remedy, *, deg: bool) -> list[str]:
    lines = [f"{remedy.kind}: {remedy.words}"]
    robot = remedy.check.robot
    lines += [f"    {parameter.name}: {_value(parameter, robot, deg=deg)}" for parameter in remedy.parameters]
    lines += [f"    {_gain(gain)}" for gain in remedy.gains if not isnan(gain.before) or not isnan(gain.after)]
    lines.append(f"    judged again: {remedy.check.sentence}")
    if remedy.usage is not None:
        retimed = "new time law; " if remedy.retimed and remedy.kind != RETIME else ""
        used = [f"{_percent(share)} of the {what} limits" for share, what in
                ((remedy.usage.rate, "rate"), (remedy.usage.acceleration, "acceleration")) if share > 0.0]  # fmt: skip
        lines.append(f"    {retimed}at most {' and '.join(used)} at every instant ({remedy.usage.how})")
    if remedy.off[0] > 0.0:
        turn = "" if isnan(remedy.off[1]) else f", {_small(degrees(remedy.off[1]))}°"
        where = "of its path between rows, measured in their middles" if turn else "of the old path where it leaves it"
        off = 1000 * remedy.off[0] / counted_length(robot)
        lines.append(f"    the tool is within {_small(off)} mm{turn} {where}")
    return lines


def _gain(gain: Gain) -> str:
    names = {"distance": "distance to the nearest singularity known", "speed": "speed that keeps the limits",
             "duration": "duration"}  # fmt: skip
    unit = f" {gain.unit}" if gain.unit else ""
    shown = [short(value) if isfinite(value) else "not known" for value in (gain.before, gain.after)]
    return f"{names[gain.what]}: {shown[0]} → {shown[1]}{unit}"


def _value(parameter: Parameter, robot: Robot, *, deg: bool) -> str:
    value = parameter.value
    if parameter.unit == "rad, m" and isinstance(value, tuple):
        parts = []
        for joint, number in zip(robot.variables, value, strict=True):
            angle = joint.unit == "rad"
            shown = f"{fixed(degrees(number), 2)}°" if angle and deg else f"{fixed(number)} {joint.unit}"
            parts.append(f"{joint.name} {shown}")
        return ", ".join(parts)
    values = value if isinstance(value, tuple) else (value,)
    if parameter.unit == "rad" and deg:
        return f"{', '.join(short(degrees(number)) for number in values)}°"
    unit = f" {parameter.unit}" if parameter.unit else ""
    inside = ", ".join(short(number + 0.0) for number in values)
    return f"({inside}){unit}" if isinstance(value, tuple) else f"{inside}{unit}"


def _percent(share: float) -> str:
    return f"{short(100 * share)} %"


def _small(value: float) -> str:
    """A deviation; what is below 1e-9 is rounding."""
    return short(value, 2) if value >= 1e-9 else "0"


def _record(remedy: Remedy) -> dict[str, Any]:
    made = remedy.trajectory
    return {
        "kind": remedy.kind,
        "words": remedy.words,
        "parameters": [
            {"name": part.name, "value": list(part.value) if isinstance(part.value, tuple) else part.value,
             "unit": part.unit} for part in remedy.parameters
        ],
        "gains": [
            {"what": gain.what, "before": number_or_null(gain.before), "after": number_or_null(gain.after),
             "unit": gain.unit} for gain in remedy.gains
        ],
        "verdict": remedy.check.verdict,
        "sentence": remedy.check.sentence,
        "limits": None if remedy.usage is None else {
            "rate": remedy.usage.rate, "acceleration": remedy.usage.acceleration, "how": remedy.usage.how
        },
        "tool_off": {"m": remedy.off[0], "rad": number_or_null(remedy.off[1])},
        "retimed": remedy.retimed,
        "trajectory": {
            "interpolate": remedy.interpolate,
            "t": made.times.tolist() if made.timed else None,
            "q": made.q.tolist(),
            "velocities": None if made.velocities is None else made.velocities.tolist(),
            "accelerations": None if made.accelerations is None else made.accelerations.tolist(),
        },
    }  # fmt: skip
