"""Fault tolerance over self-motions: where a joint may be locked for the tool still to reach a pose.

A joint that fails stands still at some value v. The pose x stays in reach if a configuration with q_j = v has it:

    {q : the tool is at x}  =  self-motions, curves for an arm with one joint to spare,
    x is in reach with joint j locked at v   ⇔   v is a value of joint j on one of the curves.

A curve is connected, so a joint takes every value between its smallest and its largest along it. The share of its range
that the curves cover is the share of values at which the joint may fail. Along the same curves the measure of
`rankdrop.distance.tolerant`, the least σ_r of all failures at a configuration, says where at the pose the arm stands
best.

The curves are those that the inverse finds from random starts; a curve may be missed, so that shares are lower bounds.
"""

from __future__ import annotations

import numpy as np

from rankdrop.distance.tolerant import LockedJoint, SelfMotions
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import pose as pose_of
from rankdrop.local.failures import worst_case
from rankdrop.poses.branches import self_motion_curves
from rankdrop.poses.inverse import Aim, within_limits
from rankdrop.poses.solution_search import SelfMotionCurve
from rankdrop.problem import into_limits, whole_turns
from rankdrop.questions import InverseOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

FINER = 8
"""Points between two of a curve as it was followed: some 0.01 rad apart then."""
_JUMP = 0.5  # of a joint between two neighbours: it was turned by a whole turn to stay inside its limits [rad]

Range = tuple[float, float]


def self_motions(
    robot: Robot, q: Array, task: Task, *, relative: bool = False, limits: bool = False, seed: int = 0
) -> SelfMotions:
    """Follow the self-motions of the tool pose at q.

    Args:
        robot: the arm, with one joint more than the rank of its task.
        q: (n,) configuration [rad, m].
        task: from `resolve_task`.
        relative: the measure is divided by σ_1 of the whole arm.
        limits: only configurations inside the joint limits count.
        seed: of the search for curves.

    Raises:
        ConfigurationError: no curve of regular configurations was found at this pose.
        TaskError: the pose of the tip does not determine what the task wants.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("planar3r")
        >>> found = self_motions(arm, np.array([0.3, 0.8, 0.9]), resolve_task("planar-position", arm))
        >>> found.curves, [round(joint.share, 2) for joint in found.joints]
        (1, [0.21, 0.46, 0.6])
    """
    aim, pose = Aim(robot, task), pose_of(robot, q)
    curves, more = self_motion_curves(robot, pose, task, options=InverseOptions(seed=seed))
    arcs, usable = list[Array](), 0
    for curve in curves:
        points = _finer(aim, pose, curve)
        if limits:
            pieces = _pieces_within(robot, points)
        else:
            pieces = [points]
        usable += bool(pieces)
        arcs += pieces
    if not arcs:
        raise ConfigurationError("no self-motion was found at the pose of this configuration", where="q",
                                 got=q.tolist(), mend="take a configuration that is not singular")  # fmt: skip
    points = np.concatenate([q[None], *arcs])
    values = worst_case(robot, points, task, relative=relative)
    best = int(values.argmax())
    place = points[best]
    if not limits:
        place = place - whole_turns(robot, place)
    return SelfMotions(
        pose, q, float(values[0]), place, float(values[best]), float(values.min()),
        len(curves), usable, all(curve.complete for curve in curves) and not more,
        tuple(_locked_joint(robot, j, arcs, limits=limits) for j in range(robot.n)),
    )  # fmt: skip


def _finer(aim: Aim, pose: Array, curve: SelfMotionCurve) -> Array:
    """(K, n) points of a curve, and those between them, each solved for the pose."""
    points = curve.points
    if curve.closed:  # the way from the last point to the first one, wherever whole turns have led
        way = points[0] - points[-1]
        points = np.concatenate([points, points[-1:] + way - whole_turns(aim.robot, way)])
    ways = np.linspace(0.0, 1.0, FINER, endpoint=False)[:, None]
    guesses = (points[:-1, None] * (1.0 - ways) + points[1:, None] * ways).reshape(-1, points.shape[1])
    guesses = np.concatenate([guesses, points[-1:]])
    solved, arrived = aim.solve(np.broadcast_to(pose, (len(guesses), 4, 4)), guesses)
    near = np.abs(solved - guesses).max(axis=1) < _JUMP
    return np.asarray(solved[arrived & near])


def _pieces_within(robot: Robot, points: Array) -> list[Array]:
    """The pieces of a curve inside the joint limits, angles turned by whole turns into them."""
    placed = into_limits(robot, points)
    there = within_limits(robot, placed)
    jumps = np.abs(np.diff(placed, axis=0)).max(axis=1, initial=0.0) > _JUMP
    cuts = np.flatnonzero(jumps | (there[1:] != there[:-1])) + 1
    pieces = zip(np.split(placed, cuts), np.split(there, cuts), strict=True)
    return [piece for piece, good in pieces if len(piece) and good[0]]


def _locked_joint(robot: Robot, j: int, arcs: list[Array], *, limits: bool) -> LockedJoint:
    """The values that joint j takes on the arcs, and their share of its range."""
    lower, upper = float(robot.lower[j]), float(robot.upper[j])
    turns, bounded = bool(robot.periodic[j]), np.isfinite(lower) and np.isfinite(upper)
    taken = [(float(arc[:, j].min()), float(arc[:, j].max())) for arc in arcs]
    if turns and limits and bounded:
        ranges = union_of_ranges(_angles_between(taken, lower, upper))
        share: float | None = min(1.0, _length(ranges) / (upper - lower))
    elif turns:
        ranges = union_of_ranges(_on_circle(taken))
        share = _length(ranges) / (2.0 * np.pi)
    else:
        ranges = union_of_ranges(taken)
        share = None
    if not turns and bounded:
        share = min(1.0, _length(ranges) / (upper - lower))
    return LockedJoint(j + 1, robot.variables[j].name, ranges, share)


def _angles_between(taken: list[Range], lower: float, upper: float) -> list[Range]:
    """The angles of ranges that lie between two limits, at every whole turn."""
    ranges, most = list[Range](), int(np.ceil((upper - lower) / (2.0 * np.pi)))
    for low, high in taken:
        for turn in 2.0 * np.pi * np.arange(-most, most + 1):
            if high + turn >= lower and low + turn <= upper:
                ranges.append((max(low + turn, lower), min(high + turn, upper)))
    return ranges


def _on_circle(taken: list[Range]) -> list[Range]:
    """The angles of ranges in [−π, π], each as one range or two."""
    ranges: list[Range] = []
    for low, high in taken:
        start = float((low + np.pi) % (2.0 * np.pi) - np.pi)
        end = start + high - low
        if high - low >= 2.0 * np.pi:
            ranges.append((-np.pi, np.pi))
        elif end <= np.pi:
            ranges.append((start, end))
        else:
            ranges += [(start, np.pi), (-np.pi, end - 2.0 * np.pi)]
    return ranges


def union_of_ranges(ranges: list[Range]) -> tuple[Range, ...]:
    """The union of ranges, in order."""
    union: list[Range] = []
    for low, high in sorted(ranges):
        if union and low <= union[-1][1]:
            union[-1] = (union[-1][0], max(union[-1][1], high))
        else:
            union.append((low, high))
    return tuple(union)


def _length(ranges: tuple[Range, ...]) -> float:
    return float(sum(high - low for low, high in ranges))
