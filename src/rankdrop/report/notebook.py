"""An arm inline in a notebook: a picture that can be turned, in a frame that asks for nothing from anywhere."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import ConfigurationError
from rankdrop.family import Family
from rankdrop.kinematics import link_poses
from rankdrop.local import blame, lost_directions, singular_values, start_posture
from rankdrop.report.data import first_view, robot_data
from rankdrop.report.page import whole_page
from rankdrop.robot import Array, Robot
from rankdrop.task import Task, link_index, resolve_task
from rankdrop.tolerances import DEFAULT
from rankdrop.version import VERSION

_SCRIPTS = ("kinematics.js", "scene.js", "arm.js", "inline.js")
_LEFT = "<style>footer { display: none; } #arm { display: block; width: 100%; height: 100vh; cursor: grab; }</style>"


@dataclass(frozen=True, eq=False)
class ArmView:
    """An arm at one configuration, which a notebook shows as a picture to be turned.

    Attributes:
        robot, task: the arm.
        q: (n,) [rad, m].
        height: of the picture [px].
    """

    robot: Robot
    task: Task
    q: Array
    height: int = 420

    def page(self) -> str:
        """The picture as an HTML page that stands alone."""
        lost, blamed = self._lost()
        words = f"The arm {self.robot.name}; arrow keys turn it"
        body = f'{_LEFT}<canvas id="arm" role="img" tabindex="0" aria-label="{escape(words)}"></canvas>'
        data = {"robot": robot_data(self.robot, self.task), "view": first_view(self.robot), "q": self.q.tolist(),
                "arrows": lost, "blamed": blamed}  # fmt: skip
        return whole_page(self.robot.name, body, data, _SCRIPTS, version=VERSION)

    def _lost(self) -> tuple[list[dict[str, Any]], list[int]]:
        """Arrows of what is lost at q in the base frame, and the joints to blame; none where q is regular."""
        sigma = singular_values(self.robot, self.q, self.task)
        corank = int((sigma <= DEFAULT.singular).sum())
        if not corank:
            return [], []
        frame = self.task.frame
        axes = link_poses(self.robot, self.q)[link_index(frame.axes, len(self.robot.joints), "axes"), :3, :3]
        turned = lost_directions(self.robot, self.q, self.task, corank).reshape(-1, 2, 3) @ axes.T
        numbers = sorted({number for one in blame(self.robot, self.q, self.task) for number in one.numbers})
        return [{"v": v.tolist(), "w": w.tolist(), "faint": False} for v, w in turned], numbers

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="{escape(self.robot.name)}" sandbox="allow-scripts" srcdoc="{escape(self.page())}" '
            f'style="width: 100%; height: {self.height}px; border: 0"></iframe>'
        )


def arm_view(robot: Robot, at: ArrayLike | Family | None = None, task: Task | str | None = None) -> ArmView:
    """The arm to be turned in a notebook; where it is singular, with what is lost and the joints to blame.

    Args:
        robot: the arm.
        at: (n,) a configuration [rad, m], or a family, which is shown at its witness; None for a good posture.
        task: as `rankdrop.task.resolve_task` takes it.

    Raises:
        ConfigurationError: `at` does not have one finite number for each joint.
        TaskError: no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> arm_view(open_robot("ur5")).q.shape
        (6,)
    """
    found = resolve_task(task, robot)
    where = at.witness if isinstance(at, Family) else at
    q = start_posture(robot, found) if where is None else np.array(where, dtype=np.float64)
    if q.shape != (robot.n,) or not np.isfinite(q).all():
        raise ConfigurationError("a configuration has one finite number for each joint", where=f"robot {robot.name!r}",
                                 got=f"shape {q.shape}", allowed=f"({robot.n},)")  # fmt: skip
    return ArmView(robot, found, q)
