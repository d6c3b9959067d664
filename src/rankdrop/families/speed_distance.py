"""From which distance of a family does the tool keep a speed?"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SpeedDistance:
    """From which distance of a family the tool keeps a speed.

    Attributes:
        family: its id.
        number, joint: a joint that stands at a value on the family, from 1, and its name; of a residual the joint in
            which the region goes on to the family.
        value: that value nearest to the middle of the region [rad]; of a residual where it vanishes, the other joints
            as in the middle.
        end: of the region: no distance in it is larger.
        kept_from: proven for every configuration of the region at least so far from the family; None: for none.
        slower_at: the largest distance at which a slower configuration was found; None: none was found.
        slower_speed: of the tool there, in its slowest direction [m/s].
        boxes: that were enclosed.
        spent: the budget ended the work: a smaller distance may hold.
        measure: "joint": distance of the joint from its value; "joints": the largest distance of several joints from
            their values; "residual": the size of the only condition, which couples joints.
        unit: of distances: "rad"; of a residual "m" where it is a length of the arm, else "1".
        numbers: of the joints that the measure takes, from 1; empty: the one joint.
        values: of those joints on the family [rad]; empty for a residual.
    """

    family: str
    number: int
    joint: str
    value: float
    end: float
    kept_from: float | None
    slower_at: float | None
    slower_speed: float | None
    boxes: int
    spent: bool
    measure: str = "joint"
    unit: str = "rad"
    numbers: tuple[int, ...] = ()
    values: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class SpeedDistances:
    """Distances from families that keep a speed of the tool, in a region around a posture.

    Attributes:
        tool_speed: of straight motions in any direction, the tool not turning [m/s].
        around: (n,) middle of the region [rad, m].
        span: half its width in each joint, inside the joint limits; slides divided by the length scale [rad].
        free: numbers of the joints that may have any value: the speed does not depend on them.
        distances: for each family with joints at values, or with one condition on several joints.
        others: ids of the other families of the smallest corank.
    """

    tool_speed: float
    around: tuple[float, ...]
    span: float
    free: tuple[int, ...]
    distances: tuple[SpeedDistance, ...]
    others: tuple[str, ...]
