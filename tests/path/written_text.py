"""A file of poses as text: quaternions or angles, decimal points or commas, JSON."""

from __future__ import annotations

import json

import numpy as np

from rankdrop.robot.model import Array


def text_of_poses(poses: Array, turn: str) -> str:
    from scipy.spatial.transform import Rotation

    found = Rotation.from_matrix(poses[:, :3, :3])
    if turn == "json":
        rows = [{"time": float(i), "position": {k: 1e3 * float(x) for k, x in zip("xyz", p[:3, 3], strict=True)},
                 "orientation": [-float(x) for x in one.as_quat()]}
                for i, (p, one) in enumerate(zip(poses, found, strict=True))]  # fmt: skip
        return json.dumps({"poses": rows, "length": "mm", "frame": "table"})
    columns = [np.arange(2.0), *poses[:, :3, 3].T]
    if turn == "rpy":
        head, columns = "t,x,y,z,roll,pitch,yaw", [*columns, *found.as_euler("xyz").T]
    else:
        head, columns = "t,x,y,z,qx,qy,qz,qw", [*columns, *found.as_quat().T]
    lines = [head, *(",".join(repr(float(x)) for x in row) for row in zip(*columns, strict=True))]
    if turn == "commas":
        lines = [line.replace(",", ";").replace(".", ",") for line in lines]
    return "\n".join(lines) + "\n"
