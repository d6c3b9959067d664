"""How many connected regions of regular configurations an arm has within its joint limits.

An aspect may fall apart there, where limits cut it, or lie outside of them as a whole: the number may be larger or
smaller than that of joints that turn as they like. A joint with limits is a line, not a circle: θ and θ + 2π are two
places, and a joint that may turn twice gives each region twice. A joint without limits turns round.

A turning joint with limits is not peeled off: the arc over a value of the other joints may fall apart at a limit.
Joints without limits are peeled off, and slides that stand in one condition only, as A + B q: they leave an interval.
Conditions that share joints are counted on cells of these (`cells.py`), so that they may depend on three joints at most
after that. The joints that no condition depends on are intervals or circles, in one piece. Sets of codimension 2
separate nothing in a box either.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rankdrop.algebra.work import OutOfTime, Work, calling_in_loops
from rankdrop.aspects.cells import Box
from rankdrop.aspects.count import AspectCount, Left, count_in_box, head_of
from rankdrop.exact.signs import Signs
from rankdrop.robot.model import Robot
from rankdrop.units import into_units

COUNTING = 20.0
"""Work that counting may take [s of an idle machine]."""
INWARD = 1e-9
"""By which limits are moved inward [rad, m]."""


def count_within_limits(robot: Robot, signs: Signs) -> AspectCount:
    """Count the connected regions of regular configurations within the joint limits.

    Args:
        robot: the arm; its limits count.
        signs: of its factors, from `count_of_arm`.

    Returns:
        The number with its bounds; `left` says why nothing was counted.

    Example:
        >>> from rankdrop.aspects.arm import count_of_arm
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("irb120")
        >>> count, signs = count_of_arm(arm, resolve_task(None, arm))
        >>> within = count_within_limits(arm, signs)
        >>> count.at_least, within.at_least, within.exact
        (8, 10, True)
    """
    work = Work(COUNTING)
    try:
        with calling_in_loops(work.check):
            return count_in_box(signs, box_of(robot, signs), work)
    except OutOfTime:
        return replace(head_of(signs), left=Left.WORK)


def box_of(robot: Robot, signs: Signs) -> Box:
    """Joint (from 1) -> lower and upper limit of its variable in the conditions [rad, slides in the arm's own unit];
    joints with both limits only.

    Limits are moved inward by `INWARD`, so that one that stands on a singularity leaves no sliver behind it.
    """
    box = {}
    lower, upper = (into_units(signs.chain.robot, limits) + signs.chain.shifts for limits in (robot.lower, robot.upper))
    ends = zip(lower, upper, strict=True)
    for joint, (low, high) in enumerate(ends, start=1):
        if np.isfinite(high - low):
            margin = min(INWARD, 0.25 * float(high - low))
            unit = 1.0
            if joint in signs.chain.ring.prismatic:
                unit = 10.0**signs.chain.power
            box[joint] = (unit * (float(low) + margin), unit * (float(high) - margin))
    return box
