"""The handle at the tip: pull it, and the arm follows."""

from __future__ import annotations

from typing import Any

import numpy as np

from rankdrop.robot import Array
from rankdrop.viewer.controls import Controls
from rankdrop.viewer.live import Now
from rankdrop.viewer.pulled import pulled
from rankdrop.viewer.scene import wxyz

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
        target = np.eye(4)
        target[:3, :3], target[:3, 3] = matrix(np.array(self._gizmo.wxyz)), np.array(self._gizmo.position)
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


def matrix(quaternion: Array) -> Array:
    """(3, 3) the rotation of a quaternion (w, x, y, z)."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
