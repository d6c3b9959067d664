"""How many connected regions of regular configurations an arm has within its joint limits.

An aspect may fall apart there, where limits cut it, or lie outside of them as a whole: the number may be larger or
smaller than that of joints that turn as they like. A joint with limits is a line, not a circle: θ and θ + 2π are two
places, and a joint that may turn twice gives each region twice. A joint without limits turns round.

Joints are not peeled off: the arc over a value of the other joints may fall apart at a limit. Conditions that share
joints are counted on cells of these (`cells.py`), so that they may depend on three joints at most. The joints that no
condition depends on are intervals or circles, in one piece. Sets of codimension 2 separate nothing in a box either.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from rankdrop.algebra.work import OutOfTime, Work, watched
from rankdrop.aspects.cells import ONE, Box, Parts, Positive, count_parts
from rankdrop.aspects.count import (
    MOST_FACTORS,
    MOST_JOINTS,
    AspectCount,
    Left,
    SignCount,
    head_of,
    joints_of,
    polynomial_of,
    sharing,
    wave_of_factor,
)
from rankdrop.aspects.waves import Wave
from rankdrop.exact.signs import Signs
from rankdrop.robot.model import JointKind, Robot

COUNTING = 20.0
"""Work that counting may take [s of an idle machine]."""
INWARD = 1e-9
"""By which limits are moved inward [rad]."""


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
    head = head_of(signs)
    if len(signs.factors) > MOST_FACTORS:
        return replace(head, left=Left.FACTORS)
    if not all(factor.periodic for factor in signs.factors):
        return replace(head, left=Left.SIGN)
    ring, polynomials = signs.chain.ring, list(map(polynomial_of, signs.factors))
    joints = {i: joints_of(ring, p) for i, p in enumerate(polynomials)}
    groups = sharing(joints)
    left = _not_countable(robot, joints, groups)
    if left is not None:
        return replace(head, left=left)
    waves = [wave_of_factor(ring, signs.chain.numbers, [p])[0] for p in polynomials]
    box, work = box_of(robot, signs), Work(COUNTING)
    try:
        with watched(work.check):
            known = [_by_signs(waves, group, box, work) for group in groups]
    except OutOfTime:
        return replace(head, left=Left.WORK)
    each = tuple(_product(vector, groups, known) for vector in product((1, -1), repeat=len(waves)))
    return replace(head, each=each, cells=_union(joints, joints))


def _union(joints: Mapping[int, set[int]], factors: Iterable[int]) -> tuple[int, ...]:
    """The joints that some factors depend on, sorted."""
    return tuple(sorted(set[int]().union(*map(joints.__getitem__, factors))))


def _not_countable(robot: Robot, joints: Mapping[int, set[int]], groups: Sequence[tuple[int, ...]]) -> Left | None:
    """Why the joints of factors that are counted together cannot be cut into cells; None where they can."""
    kinds = {robot.variables[joint - 1].kind for joint in _union(joints, joints)}
    if not kinds <= {JointKind.REVOLUTE}:
        return Left.SLIDE
    if any(len(_union(joints, group)) > MOST_JOINTS for group in groups):
        return Left.JOINTS
    return None


def _by_signs(
    waves: Sequence[Wave], group: tuple[int, ...], box: Box, work: Work
) -> dict[tuple[int, ...], Parts]:
    """The parts for every sign vector of the factors of a group."""
    own = [waves[i] for i in group]
    vectors = product((1, -1), repeat=len(own))
    return {vector: count_parts(list(map(Positive, own, vector)), work, box) for vector in vectors}


def _product(
    vector: tuple[int, ...], groups: Sequence[tuple[int, ...]], known: Sequence[Mapping[tuple[int, ...], Parts]]
) -> SignCount:
    """The regions of one sign vector of all factors: the parts of the groups, multiplied."""
    parts = ONE
    for group, own in zip(groups, known, strict=True):
        parts = parts * own[tuple(vector[i] for i in group)]
    return SignCount(vector, parts)


def box_of(robot: Robot, signs: Signs) -> Box:
    """Joint (from 1) -> lower and upper limit of the angle θ of the conditions [rad]; joints with both limits only.

    Limits are moved inward by `INWARD`, so that one that stands on a singularity leaves no sliver behind it.
    """
    box = {}
    ends = zip(robot.lower + signs.chain.shifts, robot.upper + signs.chain.shifts, strict=True)
    for joint, (low, high) in enumerate(ends, start=1):
        if np.isfinite(high - low):
            margin = min(INWARD, 0.25 * float(high - low))
            box[joint] = (float(low) + margin, float(high) - margin)
    return box
