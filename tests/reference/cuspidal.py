"""Cuspidal arms with a path from one solution of a pose to another, and a judge of certificates of them, in doubles.

The judge multiplies the joints' motions out as 4 × 4 matrices and looks at det J at places of the path.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from rankdrop.aspects import change_certificate, posture_certificate
from rankdrop.aspects.count import AspectCount
from rankdrop.aspects.posture_paths import Change, Postures
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.posture_changes import OPEN, Decision, decide_postures
from rankdrop.questions import AspectsOptions
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, revolute
from rankdrop.task import resolve_task

H = np.pi / 2
WENGER = [[-3.03774645687452, 1.9683349641197863, 2.5934197786078093],
          [-2.124062423220418, 1.3484880361575255, 4.191217161235883],
          [-1.737419186302787, 0.630296146755486, 4.09039042004785]]  # fmt: skip
"""Between two solutions of Wenger's arm (a = 1, 2, 1.5; d₂ = 1), found by `aspects_of`."""
CRX = [[0.7652630391888651, -0.7304694400137146, 4.365096372709623, 3.189020732203279, 1.1651470070340428,
        1.1817043924685215],
       [-1.0170573579218356, -1.7174940016276787, 3.1305832543731045, -2.188122239574819, 0.4847795471339893,
        1.1905277377374612],
       [-1.819880175237881, -3.065057804173684, 3.986859495777469, -1.7276420316079144, -1.4403198673653157,
        1.1945020977450365],
       [-2.3761701600196274, -2.7710632762723457, 4.36406237361155, -0.043571965752470465, -1.6411031152025632,
        1.1972560013716456]]  # fmt: skip
"""Of a CRX-10iA, inside its joint limits."""


def wenger() -> Robot:
    """Three turning joints that move a point, the arm on which Wenger showed a change of posture."""
    rows = [(0, 1, -H), (1, 2, H), (0, 1.5, 0)]
    table = [{"d": float(d), "a": float(a), "alpha": float(x)} for d, a, x in rows]
    return from_dh(table, convention="standard", task="position", name="arm")


def postures(robot: Robot, q: Any, *, limits: bool = False, task: str | None = None) -> Postures:
    """As `aspects_of` returns them, with this path."""
    change = None if q is None else Change(np.array(q), 0.0, 0)
    return Postures(robot, resolve_task(task, robot), AspectsOptions(limits=limits), AspectCount(), Decision(OPEN), (),
                    change, None, True)  # fmt: skip


PARALLEL = [[0.7249860371262926, -0.7308754819569288, 3.124062163134476, 3.0211775357715274, 1.1657946707540434,
             0.9453635139748178],
            [2.1589409891556253, -2.849316147518223, 1.0351022171297126, -1.6080413909161813, 3.8666926508995583,
             -1.5127883295511233]]  # fmt: skip
"""Between two solutions of `three_parallel`."""


def three_parallel() -> Robot:
    """Axes 2, 3 and 4 are parallel, and no other axes are or meet: dimensions of our own."""
    rows = [(0.2, 0.1, np.pi / 3), (0, 0.5, 0), (0, 0.4, 0), (0.1, 0.2, np.pi / 4), (0.3, 0.15, -np.pi / 3),
            (0.1, 0, 0)]  # fmt: skip
    table = [{"d": float(d), "a": float(a), "alpha": float(x)} for d, a, x in rows]
    return from_dh(table, convention="standard", task="pose", name="parallel")


ELIAS_WEN = [[-2.4, -0.9, 1.1, -0.8, 2.3, -1.3], [0.994, -1.4391, 0.953, 1.2368, 1.0004, 1.5942]]
"""Two solutions of `elias_wen`, as published: the second to four places."""


def elias_wen() -> Robot:
    """Three parallel axes: A. J. Elias and J. T. Wen, "Path Planning and Optimization for Cuspidal 6R Manipulators".

    Axes and points of the base frame at q = 0 are sums of the vectors that the authors' public code holds.
    """
    x, y, z = np.eye(3)
    steps = np.array([[0, 0, 0], [0.1, 0.7, 0], [0, 0, 0.7], [0, 0, 0.7], [0, 0, 0.7], [0.3, 0, 0.9], [0, 0.5, 0]])
    points = steps.cumsum(axis=0)
    home = np.eye(4)
    home[:3, 3] = points[6]
    joints = [revolute(axis, point) for axis, point in zip((z, y, y, y, x, y), points[:6], strict=True)]
    return from_screws(joints, order="linear-first", home=home, task="pose", name="elias-wen")


STRUCTURED = {
    "axes 1, 2 meet": [(0.3, 0, H), (0.4, 0.7, 0.4), (0.2, 0.9, 0)],
    "axes 1, 2 parallel": [(0.3, 0.8, 0), (0.4, 0.7, 0.6), (0.2, 0.9, 0)],
    "axes 2, 3 parallel": [(0.3, 0.2, H), (0.4, 0.7, 0), (0.2, 0.9, 0)],
    "axes 2, 3 meet": [(0.3, 0.2, 0.7), (0, 0, H), (0.2, 0.9, 0)],
}
"""Rows (d, a, α) of three turning joints that move a point: each of these has that structure and no other."""


def structured(structure: str) -> Robot:
    """Three turning joints of a structure, its axes in base coordinates so as the file of a certificate has them."""
    rows, task = STRUCTURED.get(structure, [(0.3, 0.2, 0.7), (0.1, 0.4, 0.9), (0.2, 0.9, 0)]), "position"
    if structure == "orientation":
        task = "orientation"
    table = [{"d": float(d), "a": float(a), "alpha": float(x)} for d, a, x in rows]
    return from_dh(table, convention="standard", task=task, name="arm")


def decided(robot: Robot) -> Postures:
    """As `aspects_of` returns them, without a path."""
    task = resolve_task(None, robot)
    return replace(postures(robot, None), decision=decide_postures(exact_chain(robot, task)))


def sign_proofs() -> dict[str, dict[str, Any]]:
    """Of an arm with three parallel axes, of one with a spherical wrist, of one that moves a point, and of a SCARA."""
    return {
        "sign proof": posture_certificate(decided(open_robot("ur5e"))),
        "sign proof with a wrist": posture_certificate(decided(open_robot("irb120"))),
        "sign proof of a point": posture_certificate(decided(structured("axes 2, 3 parallel"))),
        "sign proof in a plane": posture_certificate(decided(open_robot("scara"))),
    }


def certificates() -> dict[str, dict[str, Any]]:
    """One of a point and one of a pose, the latter inside the joint limits."""
    return {
        "posture change": change_certificate(postures(wenger(), WENGER)),
        "posture change within limits": change_certificate(postures(open_robot("crx10ia"), CRX, limits=True)),
    }


def _seen(arm: dict[str, Any], rows: list[int], q: Array) -> tuple[Array, Array]:
    """(N, 4, 4) poses of the tip, and (N, m, n) Jacobians, about the tip's point in the axes of the base."""
    pose = np.tile(np.eye(4), (len(q), 1, 1))
    columns = []
    for joint in arm["joints"]:
        v, w = np.array(joint["screw"][:3]), np.array(joint["screw"][3:])
        turn, at = pose[:, :3, :3], pose[:, :3, 3]
        axis = turn @ w
        columns.append((joint, turn @ v + np.cross(at, axis), axis))
        angle = (joint["multiplier"] * q[:, joint["variable"] - 1] + joint["offset"])[:, None, None]
        hat, step = np.cross(np.eye(3), w), np.tile(np.eye(4), (len(q), 1, 1))
        step[:, :3, :3] += np.sin(angle) * hat + (1 - np.cos(angle)) * hat @ hat
        carries = angle * np.eye(3) + (1 - np.cos(angle)) * hat + (angle - np.sin(angle)) * hat @ hat
        step[:, :3, 3] = carries @ v
        pose = pose @ step
    pose = pose @ np.array(arm["home"])
    whole = np.zeros((len(q), 6, q.shape[1]))
    for joint, v, w in columns:
        twist = np.concatenate([v + np.cross(w, pose[:, :3, 3]), w], axis=1)
        whole[:, :, joint["variable"] - 1] += joint["multiplier"] * twist
    return pose, whole[:, rows]


def true(record: dict[str, Any]) -> bool:
    """Does a certificate state what is so?"""
    if record["kind"] == "sign proof":
        return _has_structure(record)
    return _changes_posture(record)


def _has_structure(record: dict[str, Any]) -> bool:
    """Axes meet and are parallel to 1e-12."""
    screws = [np.array(joint["screw"]) for joint in record["arm"]["joints"]]
    structure = record["claim"]["structure"]
    if structure == "planar":
        return _in_a_plane(record)

    def parallel(i: int, j: int) -> bool:
        return bool(np.abs(np.cross(screws[i - 1][3:], screws[j - 1][3:])).max() < 1e-12)

    def meet(i: int, j: int) -> bool:
        return not parallel(i, j) and abs(float(screws[i - 1] @ np.roll(screws[j - 1], 3))) < 1e-12

    if structure == "three parallel":
        return parallel(2, 3) and parallel(3, 4) and meet(5, 6)
    first, second = (1, 2) if "1" in structure else (2, 3)
    centre = len(screws) == 3 or (meet(4, 5) and meet(5, 6))
    return centre and (parallel if structure.endswith("parallel") else meet)(first, second)


def _in_a_plane(record: dict[str, Any]) -> bool:
    """All axes are along one axis z of base and task, and the rows are those of a plane across it."""
    arm, task = record["arm"], record["task"]
    screws = np.array([joint["screw"] for joint in arm["joints"]])
    slides = np.array([joint["kind"] == "prismatic" for joint in arm["joints"]])
    axes = np.where(slides[:, None], screws[:, :3], screws[:, 3:])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)  # a slide has the direction of its axis, of whatever length
    z = int(np.abs(axes[0]).argmax())
    frame = {0: np.eye(4), len(screws): np.array(arm["last"])}.get(task["frame"]["axes"], np.array(arm["home"]))
    along = (np.abs(np.abs(np.vstack([axes, frame[:3, z]])) - np.eye(3)[z]) < 1e-12).all()
    turning = int((~slides).sum())
    rows = {0, 1, 2, 3 + z} - {z} - ({3 + z} if turning == 2 else set()) | ({z} if slides.any() else set())
    return bool(along and turning in (2, 3) and slides.sum() <= 1 and task["rows"] == sorted(rows)
                and task["frame"]["origin"] != 0)  # fmt: skip


def _changes_posture(record: dict[str, Any]) -> bool:
    """One pose at both ends, and det J of one sign along the path."""
    arm, rows = record["arm"], record["task"]["rows"]
    points = np.array(record["claim"]["points"], dtype=np.float64)
    share = np.linspace(0, 1, 25)[:, None]
    along = np.concatenate([a + share * (b - a) for a, b in pairwise(points)])
    poses, slopes = _seen(arm, rows, along)
    first, last = poses[0], poses[-1]
    turn = last[:3, :3] @ first[:3, :3].T
    twist = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    off = np.linalg.solve(slopes[-1], np.concatenate([last[:3, 3] - first[:3, 3], twist])[rows])
    whole = rows == [0, 1, 2] or np.trace(turn) > 0.0
    gap = points[-1] - points[0]
    apart = np.abs(gap - 2 * np.pi * np.round(gap / (2 * np.pi))).max()
    free = len(set(np.sign(np.linalg.det(slopes)).tolist())) == 1
    return bool(np.abs(off).max() <= record["claim"]["radius"] * 1.1 + 1e-12 and whole and free and apart > 1e-9)
