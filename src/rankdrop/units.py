"""The unit of length an arm is worked on in: the power of ten nearest to its reach.

The same arm may be written in µm, mm, m or km, and nothing but the numbers that carry a length may differ in what is
found. So every analysis is made of the arm in its own unit, where its reach lies between 0.32 and 3.2, and what was
found is told in the lengths that were given. "m" in documentation is the unit the arm was given in.

Dividing by a power of ten leaves decimals decimals, and lengths are then rounded where only rounding is left. So an arm
given in mm and the same arm given in m are one arm here, to the last bit; with them all that follows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, wraps
from math import floor, log10
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, Joint, JointKind, Mimic, Robot
from rankdrop.task import Task

_Length = TypeVar("_Length", float, Array)

WRITTEN = {
    "angle": "rad",
    "length": "m",
    "time": "s",
    "joint": "rad where it turns, m where it slides",
    "distance": "rad over all joints, slides divided by the length scale",
}
"""Units of what every JSON file holds; `unit` in its schema says which of them an entry has (docs/json.md)."""

DECIMALS = 14
"""Places kept of a length in its arm's unit: some fifty times what rounding leaves, a tenth of `Tolerances.target`."""

_Made = TypeVar("_Made")


def heading(schema: str) -> dict[str, Any]:
    """The first entries of every JSON file: what it is, and in which units.

    Example:
        >>> heading("rankdrop/analysis/1")["units"]["angle"]
        'rad'
    """
    return {"schema": schema, "units": dict(WRITTEN)}


def _once(make: Callable[[Robot], _Made]) -> Callable[[Robot], _Made]:
    """A function that is called once for each robot, which never changes."""
    known: WeakKeyDictionary[Robot, _Made] = WeakKeyDictionary()

    @wraps(make)
    def cached_for_robot(robot: Robot) -> _Made:
        result = known.get(robot)
        if result is None:
            result = known[robot] = make(robot)
        return result

    return cached_for_robot


def in_units(robot: Robot) -> Robot:
    """The arm in its own unit of length; itself where it is in it already. Made once for each robot."""
    if robot.exponent is not None:
        return robot
    return _in_own_unit(robot)


@_once
def _in_own_unit(robot: Robot) -> Robot:
    return _with_exponent(robot, exponent(robot))


def _with_exponent(robot: Robot, power: int) -> Robot:
    return replace(_with_lengths(scale_lengths(robot, -power), _round_length), exponent=power)


def exponent(robot: Robot) -> int:
    """Of the arm's unit of length: 10 to this power is nearest to the reach, by its logarithm."""
    if robot.exponent is None:
        return round(log10(reach(robot)))
    return robot.exponent


def task_in_units(task: Task, robot: Robot) -> Task:
    """The task of an arm for `in_units(robot)`: its length scale and its reference point in that unit."""
    if robot.exponent is None:
        power = -exponent(robot)
    else:
        power = 0
    return _moved_task(task, power)


@lru_cache(maxsize=256)
def _moved_task(task: Task, power: int) -> Task:
    if not power:
        return task
    x, y, z = (shift_decimal(part, power) for part in task.frame.point)
    if task.length_scale is None:
        length = None
    else:
        length = shift_decimal(task.length_scale, power)
    return replace(task, frame=replace(task.frame, point=(x, y, z)), length_scale=length)


def into_units(robot: Robot, q: ArrayLike) -> Array:
    """Configurations (..., n) of an arm as those of `in_units(robot)`: slides in its unit."""
    return _slid(robot, q, -exponent(robot) if robot.exponent is None else 0)


def out_of_units(robot: Robot, q: ArrayLike) -> Array:
    """Configurations (..., n) of `in_units(robot)` as those of the arm itself."""
    return _slid(robot, q, exponent(robot) if robot.exponent is None else 0)


def as_given(robot: Robot, q: ArrayLike) -> Array:
    """Configurations (..., n) of a robot as the user's: for sentences written where only `in_units` is at hand."""
    return _slid(robot, q, given_exponent(robot))


def given_exponent(robot: Robot) -> int:
    """Power of ten by which lengths of a robot are told larger than they stand there: that of `in_units`, else 0."""
    return robot.exponent or 0


def _slid(robot: Robot, q: ArrayLike, power: int) -> Array:
    array = np.array(q, dtype=np.float64)
    if not power:
        return array
    slides = [i for i, joint in enumerate(robot.variables) if joint.kind is JointKind.PRISMATIC]
    if slides:
        array[..., slides] = shift_decimal(array[..., slides], power)
    return array


def shift_decimal(length: _Length, power: int) -> _Length:
    """A length times 10 to a power, rounded once."""
    if power >= 0:
        return length * 10.0**power
    return length / 10.0**-power


def metre_exponent(robot: Robot) -> int:
    """Power of ten between an arm and the same arm in metres: that of `counted_length`; 0 for one that is in them.

    At one configuration σ is that of joint rates in rad/s and m/s, as GR and AM have it: of an arm in mm, its slides'
    rates would count a thousandfold. So it is looked at as if its numbers were metres.
    """
    if robot.exponent is None:
        return counted_exponent(robot)
    return 0


def in_metres(robot: Robot) -> Robot:
    """The arm with its lengths divided by 10 to the power of `metre_exponent`; mostly itself."""
    if metre_exponent(robot):
        return _metres(robot)
    return robot


@_once
def _metres(robot: Robot) -> Robot:
    return _with_exponent(robot, metre_exponent(robot))


def task_in_metres(task: Task, robot: Robot) -> Task:
    """The task of an arm for `in_metres(robot)`."""
    return _moved_task(task, -metre_exponent(robot))


def into_metres(robot: Robot, q: ArrayLike) -> Array:
    """Configurations (..., n) of an arm as those of `in_metres(robot)`."""
    return _slid(robot, q, -metre_exponent(robot))


def out_of_metres(robot: Robot, q: ArrayLike) -> Array:
    """Configurations (..., n) of `in_metres(robot)` as those of the arm itself."""
    return _slid(robot, q, metre_exponent(robot))


def counted_as_radian(robot: Robot) -> float:
    """The length that counts as 1 rad where a lost motion is told, in the robot's unit of length.

    1 m for an arm given in metres, as AM have it. What is told must not depend on the unit, so it is the power of 1000
    nearest to the reach: 1 for a reach from 0.032 to 31.6, 1000 for an arm given in mm.
    """
    return 10.0 ** (counted_exponent(robot) - given_exponent(robot))


def counted_length(robot: Robot) -> float:
    """The same length in the unit that the arm was given in [m]."""
    return 10.0 ** counted_exponent(robot)


@_once
def counted_exponent(robot: Robot) -> int:
    """Power of ten of `counted_length`: a multiple of three."""
    return 3 * floor((log10(reach(robot)) + given_exponent(robot)) / 3 + 0.5)


def scale_lengths(robot: Robot, power: int) -> Robot:
    """The same arm with all lengths, those of its slides' limits too, times 10 to a power."""
    if not power:
        return robot
    kinds = {joint.name: joint.kind for joint in robot.joints}

    def scale_mimic(joint: Joint) -> Joint:
        """Its mimic, which has the unit of the joint over that of its leader."""
        if joint.mimic is None:
            return joint
        follower, leader = (power * (kind is JointKind.PRISMATIC) for kind in (joint.kind, kinds[joint.mimic.leader]))
        multiplier = shift_decimal(joint.mimic.multiplier, follower - leader)
        offset = shift_decimal(joint.mimic.offset, follower)
        return replace(joint, mimic=Mimic(joint.mimic.leader, multiplier, offset))

    scaled = _with_lengths(robot, lambda length: shift_decimal(length, power))
    lengths = tuple((letter, shift_decimal(value, power)) for letter, value in robot.lengths)
    return replace(scaled, joints=tuple(map(scale_mimic, scaled.joints)), lengths=lengths)


def _with_lengths(robot: Robot, change: Callable[[Any], Any]) -> Robot:
    """The arm with other lengths: of axes, of frames, and of what slides do."""

    def scale_joint(joint: Joint) -> Joint:
        joint = replace(joint, frame=_pose(joint.frame, change))
        if joint.kind is JointKind.PRISMATIC:
            ends = {name: change(getattr(joint, name)) for name in ("lower", "upper", "velocity")}
            return replace(joint, **ends)
        return replace(joint, screw=np.concatenate([change(joint.screw[:3]), joint.screw[3:]]))

    return replace(robot, joints=tuple(map(scale_joint, robot.joints)), home=_pose(robot.home, change))


def _pose(pose: Array, change: Callable[[Any], Any]) -> Array:
    moved = pose.copy()
    moved[:3, 3] = change(pose[:3, 3])
    return moved


def _round_length(length: Any) -> Any:
    """A length, or an array of them, rounded to `DECIMALS` places."""
    if isinstance(length, float):
        if np.isfinite(length):
            return round(length, DECIMALS)
        return length
    return np.round(length, DECIMALS) + 0.0
