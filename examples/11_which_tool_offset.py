"""Which tool offset is best?

For the full pose a tool changes no singularity: the rank does not depend on the point of the end effector. If only the
position of the tool point matters, it does: beside the wrist centre, the other joints can make up for more.
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


for task, rows in (("pose", range(6)), ("position", range(3))):
    print(f"task {task}")
    for x, z in ((0.0, 0.0), (0.0, 0.2), (0.1, 0.2)):
        robot = with_tool(x, z)
        same = rankdrop.Task(task, tuple(rows), length_scale=1.0)  # one scale for all: σ can be compared
        sigma = rankdrop.singular_values(robot, sample(robot, same, 20000, seed=0), same)[:, -1]
        found = rankdrop.analyze(robot, same, starts=200, exact="off").of_corank(1)
        largest = max(family.dimension for family in found)
        print(f"  tool point x = {x:.1f} m, z = {z:.1f} m: median of the smallest σ {np.median(sigma):.3f},")
        print(f"    singular set of dimension {largest} of {robot.n}")
        if task == "pose":
            print("    " + "; ".join(family.name for family in found))
