"""Detours of a planar arm, checked on a fine grid."""

from __future__ import annotations

from functools import cache

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.path.check.record import PathCheck
from rankdrop.path.check.tool_path import check_poses
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

STARTS = {"kr6r900": (0, -80, 90, 20, 12, 0), "pa10": (0, 30, 20, 20, 20, 40, 0), "ur10e": (-2, -71, 85, -79, 45, 2)}
JOINT = {"kr6r900": 4, "pa10": 3, "ur10e": 4}
CLEARANCE = float(np.radians(0.2))


@cache
def checked(name: str) -> tuple[Array, Array, PathCheck]:
    """120 poses within 2.4 s, of a joint path whose wrist, or elbow, goes from one side to the other; with the elbow
    the poses are 1 mm out of reach in the middle.
    """
    arm, t = open_robot(name), np.linspace(0.0, 2.4, 120)
    share = t / t[-1]
    q = np.radians(np.array(STARTS[name], dtype=np.float64) + share[:, None] * np.linspace(2, 5, arm.n))
    q[:, JOINT[name]] = np.radians(STARTS[name][JOINT[name]]) * np.cos(np.pi * share)
    poses = pose(arm, q)
    if name == "pa10":
        out = poses[60, :3, 3] - np.array([0.0, 0.0, 0.3])
        poses[:, :3, 3] += 1e-3 * np.exp(-(((t - 1.2) / 0.1) ** 2))[:, None] * out / np.linalg.norm(out)
    return poses, t, check_poses(arm, poses, t, start=q[0], branches=False)


@cache
def planar() -> tuple[Array, Array, PathCheck]:
    """Poses 0.3 mm beyond the reach of the first two of three links in the middle."""
    arm, t = open_robot("planar3r"), np.linspace(0.0, 2.4, 60)
    q = np.stack([0.2 + 0.1 * t, 0.5 * np.cos(np.pi * t / 2.4), 0.4 + 0.1 * t], axis=1)
    poses = pose(arm, q)
    out = poses[30, :3, 3] / np.linalg.norm(poses[30, :3, 3])
    poses[:, :3, 3] += 3e-4 * np.exp(-(((t - 1.2) / 0.1) ** 2))[:, None] * out
    return poses, t, check_poses(arm, poses, t, start=q[0], branches=False)
