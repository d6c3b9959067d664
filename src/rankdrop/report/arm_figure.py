"""The arm at a witness for papers: links, axes, and the lost directions as AM draw them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop._handles import check_robot
from rankdrop.errors import MissingExtraError
from rankdrop.family import Family
from rankdrop.kinematics import link_poses, pose
from rankdrop.reach import reach
from rankdrop.report.content import arrows
from rankdrop.report.skeleton import skeleton
from rankdrop.results import Analysis
from rankdrop.robot import Array, JointKind, Robot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ARROWS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Of the lost directions: blue, red, green as in AM, in tones that all eyes tell apart."""
BLAME, LINK, AXIS = "#E07B00", "#7C8B9B", "#A9B4C0"
_ARROW, _LONG, _SHORT = 0.32, 0.28, 0.09  # lengths per reach


def arm_figure(analysis: Analysis, family: Family, blamed: Sequence[int] = ()) -> Figure:
    """The arm at the witness of a family; solid arrows: translation lost, dotted: rotation.

    Args:
        analysis: of the arm.
        family: one of its families.
        blamed: numbers (from 1) of the joints whose axes are marked.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", None, "a figure for papers") from error
    robot = analysis.robot
    check_robot(robot)
    drawn = Figure(figsize=(3.8, 3.8))
    axes: Any = drawn.add_subplot(projection="3d")
    points, middles, directions = placed(robot, np.array(family.witness))
    size = reach(robot)
    axes.plot(*points.T, color=LINK, lw=4, solid_capstyle="round", solid_joinstyle="round")
    names = [joint.name for joint in robot.variables]
    for joint, middle, direction in zip(robot.joints, middles, directions, strict=True):
        number = names.index(joint.mimic.leader if joint.mimic else joint.name) + 1
        marked = number in blamed
        body = np.stack([middle - 0.045 * size * direction, middle + 0.045 * size * direction])
        axes.plot(*body.T, color=BLAME if marked else "#4F6073", lw=8, solid_capstyle="butt")
        reached = (_LONG if marked else _SHORT) * size
        line = np.stack([middle - reached * direction, middle + reached * direction])
        axes.plot(*line.T, color=BLAME if marked else AXIS, lw=1.2 if marked else 0.8, ls="-.")
        axes.text(*(middle + 1.15 * reached * direction), str(number), fontsize=7, color=BLAME if marked else "black")
    at, twists = arrows(analysis, family)
    for twist, tone in zip(twists, ARROWS * len(twists), strict=False):
        for vector, style in ((twist[:3], "-"), (twist[3:], ":")):
            if np.linalg.norm(vector) > 0.02:
                step = _ARROW * size * vector
                axes.quiver(*at, *step, color=tone, lw=2.0, ls=style, arrow_length_ratio=0.18)
    _framed(axes, np.vstack([points, at[None]]), size)
    drawn.suptitle(f"{family.id}: {family.name}", fontsize=8, y=0.96)
    return drawn


def placed(robot: Robot, q: Array) -> tuple[Array, Array, Array]:
    """Where the drawn arm is at q.

    Returns:
        (P, 3) points of its links from the base to the tip; (N, 3) where the joints are drawn; (N, 3) their axes.
    """
    at_home, drawn = skeleton(robot)
    links = link_poses(robot, q)
    frames = [np.eye(4), *(joint.frame for joint in robot.joints)]
    moved = [links[i] @ np.linalg.inv(frames[i]) for i in range(len(robot.joints) + 1)]
    points, middles, axes = [np.zeros(3)], [], []
    for i, joint in enumerate(robot.joints):
        held, carried = moved[i], moved[i + 1]
        points += [_apply(held, at_home[i]), _apply(carried, at_home[i])]
        middles.append(_apply(held, drawn[i]))
        axis = joint.screw[:3] if joint.kind is JointKind.PRISMATIC else joint.screw[3:]
        axes.append(held[:3, :3] @ axis)
    points.append(pose(robot, q)[:3, 3])
    return np.array(points), np.array(middles), np.array(axes)


def _apply(moved: Array, point: Array) -> Array:
    return np.asarray(moved[:3, :3] @ point + moved[:3, 3])


def _framed(axes: Any, points: Array, size: float) -> None:
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = max(float(np.ptp(points, axis=0).max()) / 2, 0.2 * size) + 0.12 * size
    axes.set(
        xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half),
        zlim=(middle[2] - half, middle[2] + half),
    )  # fmt: skip
    axes.set_box_aspect((1, 1, 1), zoom=1.1)
    axes.tick_params(labelsize=6)
    for name, set_name in (("x", axes.set_xlabel), ("y", axes.set_ylabel), ("z", axes.set_zlabel)):
        set_name(f"{name} [m]", fontsize=7)
