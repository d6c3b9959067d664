"""What became other in an arm that was made exact: which number of the chain, from what to what."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import degrees, floor, hypot, log10

import numpy as np

from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.numbers import Numbers, along, numbers_of, parallel_runs, wrapped
from rankdrop.tolerances import NOTHING


@dataclass(frozen=True, slots=True)
class Change:
    """One number of the chain that was made exact.

    Attributes:
        kind: "twist" (angle from one axis to the next), "angle" (about an axis, from one common normal to the next),
            "distance" (between two axes along their normal), "offset" (along an axis, between two normals; of axes that
            are parallel, the sum), "base" and "tip" (how far the first axis is turned in the base, the tip in the last
            link; 0 after).
        joints: numbers from 1 in the chain, mimic joints counted: the two joints of a twist or a distance, the one of
            all else, all those of parallel axes.
        before, after: its value [rad, m].
    """

    kind: str
    joints: tuple[int, ...]
    before: float
    after: float

    @property
    def by(self) -> float:
        """How far it was moved [rad, m]; 180° and −180° are the same."""
        by = self.after - self.before
        return abs(wrapped(by) if self.turns else by)

    @property
    def name(self) -> str:
        """Denavit and Hartenberg's letter with the number of the joint: "α2", "d4", "d2 + d3"; else "base", "tip"."""
        letter = {"twist": "α", "angle": "θ", "distance": "a", "offset": "d"}.get(self.kind)
        if letter is None:
            return self.kind
        numbers = self.joints if self.kind == "offset" else self.joints[:1]
        return " + ".join(f"{letter}{number}" for number in numbers)

    @property
    def text(self) -> str:
        """In words: "d4 from 0.3 mm to 0", "α2 from 90.06° to 90°", "tip turned by 0.0006°"."""
        if self.kind in ("base", "tip"):
            return f"{self.kind} turned by {degrees(self.by):.2g}°"
        return f"{self.name} from {self._written(self.before)} to {self._written(self.after)}"

    def _written(self, value: float) -> str:
        """With one digit more than it was moved by."""
        if value == 0.0 and not self.turns:
            return "0"
        factor, unit = (degrees(1.0), "°") if self.turns else (1e3, " mm")
        places = max(0, 1 - floor(log10(self.by * factor)))
        text = f"{round(value * factor, places) + 0.0:.{places}f}"
        return (text.rstrip("0").rstrip(".") if places else text).replace("-", "−") + unit

    @property
    def turns(self) -> bool:
        """Whether it is an angle."""
        return self.kind not in ("distance", "offset")


def changes_between(old: Robot, new: Robot, *, angle: float, length: float) -> tuple[Change, ...]:
    """Every number of the chain that differs by more than a nanometre or a billionth of a radian.

    Args:
        old, new: the same chain, its normals chosen alike: the second made of the first.
        angle, length: the tolerances it was made with.
    """
    before = numbers_of(old, angle=angle, length=length)
    after = numbers_of(new, angle=angle, length=length)
    first, last = (_apart(x, y) for x, y in zip(_ends(old), _ends(new), strict=True))
    found = [*_differences(before, after), Change("base", (1,), first, 0.0), Change("tip", (len(before),), last, 0.0)]
    return tuple(change for change in found if change.by > NOTHING)


def _differences(before: Sequence[Numbers], after: Sequence[Numbers]) -> Iterator[Change]:
    for run in parallel_runs(after):
        for i in run:
            one, other, pair = before[i], after[i], (i + 1, i + 2)
            if i == run[0]:
                yield Change("offset", tuple(k + 1 for k in run), sum(along(before, run)), sum(along(after, run)))
            yield Change("angle", (i + 1,), one.phase, other.phase)
            yield Change("distance", pair, one.a, other.a)
            lean = abs(one.tilt) > NOTHING
            turned = hypot(wrapped(one.twist - other.twist), one.tilt)
            yield Change("twist", pair, other.twist + turned if lean else one.twist, other.twist)


def _ends(robot: Robot) -> tuple[Array, Array]:
    """Direction of the first axis in the base, axes of the tip in the last link (its frame)."""
    first = robot.joints[0]
    direction = first.screw[:3] if first.kind is JointKind.PRISMATIC else first.screw[3:]
    return direction, robot.joints[-1].frame[:3, :3].T @ robot.home[:3, :3]


def _apart(one: Array, two: Array) -> float:
    """Angle between two directions or two rotations that are near [rad]."""
    return float(np.linalg.norm(one - two)) / (np.sqrt(2.0) if one.ndim == 2 else 1.0)
