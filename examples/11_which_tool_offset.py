"""Which tool offset is best?

For the full pose a tool changes nothing: the rank does not depend on the point of the end effector, and neither do the
families. If only the position of the tool point matters, it does: the families move with it.
"""

from dataclasses import replace

import numpy as np

import rankdrop
from rankdrop.local.block import sample

arm = rankdrop.open_robot("puma560")


def with_tool(x: float, z: float) -> rankdrop.Robot:
    """The arm with its tool point at (x, 0, z) of the flange [m]."""
    tool = np.eye(4)
    tool[:3, 3] = x, 0, z
    return replace(arm, home=arm.home @ tool)


for task in ("pose", "position"):
    print(f"task {task}")
    for x, z in ((0.0, 0.0), (0.0, 0.2), (0.1, 0.2)):
        robot = with_tool(x, z)
        # one length scale for all, so that σ can be compared
        same = rankdrop.Task(task, (0, 1, 2, 3, 4, 5) if task == "pose" else (0, 1, 2), length_scale=1.0)
        sigma = rankdrop.singular_values(robot, sample(robot, same, 20000, seed=0), same)[:, -1]
        found = rankdrop.analyze(robot, same, starts=400)
        families = "; ".join(f"{f.name} (dim {f.dimension})" for f in found.of_corank(1))
        print(f"  tool x = {x:.1f} m, z = {z:.1f} m: smallest σ in the middle {np.median(sigma):.3f}; {families}")
