"""What mends a path: one change of it, what it gains, and the judgement of the path that it makes."""

from __future__ import annotations

from dataclasses import dataclass

from rankdrop.motion.result import PathCheck
from rankdrop.motion.retime import Usage
from rankdrop.motion.trajectory import Trajectory

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
