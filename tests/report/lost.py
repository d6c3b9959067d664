"""The lost directions of a family in the base frame, worked out apart from what is drawn."""

from __future__ import annotations

import numpy as np

from rankdrop.families.record import Family
from rankdrop.kinematics import link_poses
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array


def arrows(analysis: Analysis, family: Family) -> tuple[Array, Array]:
    """(3,) the reference point of the task's frame at the witness [m], and (k, 6) lost directions (v; ω)."""
    links = link_poses(analysis.robot, family.witness)
    frame = analysis.task.frame
    axes, carrier = links[frame.axes][:3, :3], links[frame.origin]
    point = carrier[:3, :3] @ np.array(frame.point) + carrier[:3, 3]
    turned = family.lost_directions.reshape(-1, 2, 3) @ axes.T
    return point, turned.reshape(-1, 6)
