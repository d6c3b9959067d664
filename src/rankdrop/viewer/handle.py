"""The handle at the tip: pull it, and the arm follows.

Inverse kinematics of the handle at the tip: the damped inverse of the product, step by step after the hand.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.local import damped_inverse
from rankdrop.robot import Array, Robot
from rankdrop.task import WORLD_ALIGNED, Task
from rankdrop.viewer.controls import Controls
from rankdrop.viewer.live import Now
from rankdrop.viewer.scene import wxyz

STEPS = 12  # of one pull: what a hand moves in a thirtieth of a second takes three
DAMPING, THRESHOLD = 0.08, 0.12  # λ₀ and ε of `damped_inverse`: no damping away from singularities
_MOST = 0.25  # of one step, in joints [rad] and lengths per length scale
_THERE = 1e-6  # what may be missing at the end [length scales, rad]


def pulled(robot: Robot, task: Task, q: Array, target: Array) -> tuple[Array, float]:
    """From q towards a pose of the tip, inside the joint limits.

        q ← q + J⁺(λ) e,  e = (Δp; θ u)

    with the damped inverse of `rankdrop.local.damped_inverse`. Only what the task asks for is followed: an arm for
    positions keeps its orientation free.

    Args:
        robot, task: the arm.
        q: (n,) where it is [rad, m].
        target: (4, 4) pose of the tip in the base frame.

    Returns:
        (n,) the nearest configuration met, and what is missing there: ‖(Δp / length scale; θ)‖ of the task's rows.
    """
    along = replace(task, frame=WORLD_ALIGNED)
    lower, upper = np.minimum(robot.lower, q), np.maximum(robot.upper, q)  # where it stands beyond a limit it may stay
    best, missing = q, _missing(robot, along, q, target)
    for _ in range(STEPS):
        if missing <= _THERE:
            break
        twist = _twist(robot, best, target)[list(along.rows)]
        step = damped_inverse(robot, best, along, damping=DAMPING, threshold=THRESHOLD) @ twist
        step *= min(1.0, _MOST / max(float(np.abs(step).max()), 1e-12))
        further = np.clip(best + step, lower, upper)
        left = _missing(robot, along, further, target)
        if left >= missing:
            break
        best, missing = further, left
    return best, missing


def _twist(robot: Robot, q: Array, target: Array) -> Array:
    """(6,) what is missing from the pose at q to the target, in the axes of the base [m, rad]."""
    at = pose(robot, q)
    turned = target[:3, :3] @ at[:3, :3].T
    axis = 0.5 * np.array([turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]])
    sine = float(np.linalg.norm(axis))
    angle = np.arctan2(sine, 0.5 * (np.trace(turned) - 1.0))
    turn = axis * (angle / sine) if sine > 1e-12 else axis
    return np.concatenate([target[:3, 3] - at[:3, 3], turn])


def _missing(robot: Robot, task: Task, q: Array, target: Array) -> float:
    twist = _twist(robot, q, target) / np.array([task.scale(robot)] * 3 + [1.0] * 3)
    return float(np.linalg.norm(twist[list(task.rows)]))


_FAR = 0.02  # what is missing from here on is told [length scales, rad]


class Handle:
    """Arrows and rings at the tip; hidden until asked for.

    Args:
        controls: the panel, whose message tells what cannot be reached.
    """

    def __init__(self, controls: Controls) -> None:
        self.controls = controls
        size = controls.live.body.size
        self._gizmo = controls.server.scene.add_transform_controls("/handle", scale=0.22 * size, visible=False)
        self._gizmo.on_update(self._moved)

    def show(self, shown: bool) -> None:
        """Show or hide it."""
        self._gizmo.visible = shown
        if shown and self.controls.now is not None:
            self.shown(self.controls.now, None)

    def _moved(self, event: Any) -> None:
        if getattr(event, "client_id", None) is None:  # `shown` placed it, no hand
            return
        from viser.transforms import SO3

        target = np.eye(4)
        target[:3, :3], target[:3, 3] = SO3(np.array(self._gizmo.wxyz)).as_matrix(), np.array(self._gizmo.position)
        self.controls.attempt(lambda: self.pull(target))

    def pull(self, target: Array) -> None:
        """Move the arm towards a pose (4, 4) of its tip."""
        live, session = self.controls.live, self.controls.session
        q, missing = pulled(live.robot, live.task, session.q, target)
        session.set(q, self)
        if missing > _FAR:
            self.controls.say("the tip cannot follow to there from here: a limit, a singularity, or out of reach")

    def shown(self, now: Now, source: object) -> None:
        """Follow the arm, unless the arm follows the handle."""
        if source is not self and self._gizmo.visible:
            self._gizmo.position = now.links[-1][:3, 3]
            self._gizmo.wxyz = wxyz(now.links[-1][:3, :3])
