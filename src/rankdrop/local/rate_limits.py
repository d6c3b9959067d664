"""The joint velocity limits of the n variables, those of the joints that follow them included."""

from __future__ import annotations

import numpy as np

from rankdrop.robot.model import Array, Robot


def rate_limits(robot: Robot) -> Array:
    """(n,) largest rate of every variable [rad/s or m/s]; inf where the source gives none.

    A mimic joint turns at |multiplier| times the rate of its leader; its own limit holds the leader back as well.
    """
    limits = {joint.name: max(0.0, joint.velocity) for joint in robot.variables}
    for joint in robot.joints:
        if joint.mimic is not None and joint.mimic.multiplier != 0.0:
            shared = max(0.0, joint.velocity) / abs(joint.mimic.multiplier)
            limits[joint.mimic.leader] = min(limits[joint.mimic.leader], shared)
    return np.array([limits[joint.name] for joint in robot.variables])
