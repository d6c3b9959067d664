"""Fifty paths built to cross: those that have a remedy of a kind, found here by small steps of fixed size from many
starts and in many directions, get one of that kind, and what they get is proven free.
"""

from __future__ import annotations

import numpy as np
import pytest

import rankdrop
from rankdrop.kinematics import pose, task_jacobian
from rankdrop.local.block import singular_values
from rankdrop.path import mend_path
from rankdrop.path.check.record import CROSSING, PathCheck
from rankdrop.path.mend.record import BLEND, FLIP, NULL, RETIME, SHIFT, TILT
from rankdrop.results.known import known_analysis
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task

pytestmark = pytest.mark.by_hand
ANGLE, LENGTH = np.radians(10.0), 0.05
WIDE = 0.03  # of σ_r: a path that keeps it is one that has to be found
ROWS = 161


def crosses(check: PathCheck) -> bool:
    """Whether a singularity is crossed; the verdict of the whole path holds rates and joint limits as well."""
    return check.complete and any(one.verdict == CROSSING for one in check.stretches)


def crossing_paths(name: str, count: int, seed: int) -> list[Array]:
    """Straight joint paths through random configurations that cross once or more, inside the limits."""
    robot, rng = open_robot(name), np.random.default_rng(seed)
    low, high = np.maximum(robot.lower, -np.pi) + 0.5, np.minimum(robot.upper, np.pi) - 0.5
    found: list[Array] = []
    while len(found) < count:
        middle, way = rng.uniform(low, high), rng.normal(size=robot.n) * 0.25
        q = middle + np.linspace(-1, 1, ROWS)[:, None] * way
        if ((q >= robot.lower) & (q <= robot.upper)).all() and crosses(rankdrop.check_path(robot, q)):
            found.append(q)
    return found


def error(robot: Robot, task: Task, wanted: Array, q: Array) -> Array:
    """Scaled difference of poses to first order."""
    now = pose(robot, q)
    turn = wanted[:3, :3] @ now[:3, :3].T
    twist = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    return np.concatenate([(wanted[:3, 3] - now[:3, 3]) / task.scale(robot), twist])


def newton(robot: Robot, task: Task, wanted: Array, q: Array, rounds: int) -> Array | None:
    """Plain Newton from q; None where it does not arrive."""
    for _ in range(rounds):
        off = error(robot, task, wanted, q)
        if np.linalg.norm(off) < 1e-11:
            return q
        step = np.linalg.pinv(task_jacobian(robot, q, task)) @ off
        q = q + step / max(1.0, float(np.linalg.norm(step)))
    return q if np.linalg.norm(error(robot, task, wanted, q)) < 1e-9 else None


def wide(robot: Robot, task: Task, poses: Array, start: Array) -> bool:
    """Whether a march of small steps runs all poses, inside the limits, with σ_r wide everywhere."""
    q, rows = start, [start]
    for wanted in poses[1:]:
        there = newton(robot, task, wanted, q, 6)
        if there is None or np.abs(there - q).max() > 0.15:
            return False
        q = there
        rows.append(q)
    made = np.array(rows)
    inside = bool(((made >= robot.lower) & (made <= robot.upper)).all())
    return inside and float(singular_values(robot, made, task)[:, 5].min()) > WIDE


def other_branch(robot: Robot, task: Task, q: Array, rng: np.random.Generator) -> bool:
    """Whether some branch that is begun elsewhere runs the tool path of q."""
    poses, seen = pose(robot, q), [q[0]]
    for start in rng.uniform(np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi), (50, robot.n)):
        there = newton(robot, task, poses[0], start, 40)
        if there is None:
            continue
        there = there + 2 * np.pi * np.round((q[0] - there) / (2 * np.pi))
        gap = np.abs(np.array(seen) - there).max(axis=1).min()
        inside = ((there >= robot.lower) & (there <= robot.upper)).all()
        if gap < 1e-4 or not inside:
            continue
        seen.append(there)
        if wide(robot, task, poses, there):
            return True
    return False


def moved(robot: Robot, task: Task, q: Array, rng: np.random.Generator, *, tilt: bool) -> bool:
    """Whether the tool tilted, or the base moved, by the whole bound in one of 16 directions makes the path wide."""
    poses = pose(robot, q)
    for _ in range(16):
        left, right = np.eye(4), np.eye(4)
        if tilt:
            turn = rng.uniform(0, 2 * np.pi)
            axis = np.array([np.cos(turn), np.sin(turn), 0.0])
            k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
            right[:3, :3] += np.sin(ANGLE) * k + (1 - np.cos(ANGLE)) * k @ k
        else:
            way = rng.normal(size=3)
            left[:3, 3] = LENGTH * way / np.linalg.norm(way)
        target = left @ poses @ right
        start = newton(robot, task, target[0], q[0], 10)
        if start is not None and np.abs(start - q[0]).max() < 0.5 and wide(robot, task, target, start):
            return True
    return False


@pytest.mark.parametrize("name", ["ur5e", "puma560"])
def test_ten_crossing_paths_of_six_joints(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    rng = np.random.default_rng(3)
    had = dict.fromkeys((FLIP, TILT, SHIFT), 0)
    missed = []
    for number, q in enumerate(crossing_paths(name, 10, 1)):
        mended = mend_path(rankdrop.check_path(robot, q), tool_tilt=ANGLE, base_shift=LENGTH)
        kinds = {one.kind for one in mended.remedies}
        for one in mended.remedies:
            assert rankdrop.check_path(robot, one.trajectory.q).clear
        has = {
            FLIP: other_branch(robot, task, q, rng), TILT: moved(robot, task, q, rng, tilt=True),
            SHIFT: moved(robot, task, q, rng, tilt=False),
        }  # fmt: skip
        for kind, there in has.items():
            had[kind] += there
            if there and kind not in kinds:
                missed.append((number, kind, mended.notes))
    print(name, had)
    assert not missed
    assert sum(had.values()) >= 5


@pytest.mark.parametrize("name", ["panda", "pa10", "lbr_iiwa_7_r800"])
def test_singular_paths_of_seven_joints(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    known = known_analysis(robot, task)
    assert known is not None
    rng = np.random.default_rng(4)
    had, missed, number = 0, [], 0
    for family in [one for one in known.families if one.corank == 1]:
        middle = np.clip(np.array(family.witness), robot.lower + 0.3, robot.upper - 0.3)
        q = middle + np.linspace(-1, 1, ROWS)[:, None] * rng.normal(size=7) * 0.15
        found = rankdrop.check_path(robot, q)
        if found.clear:  # the witness is outside the limits
            continue
        number += 1
        mended = mend_path(found, tool_tilt=ANGLE)
        kinds = {one.kind for one in mended.remedies}
        for one in mended.remedies:
            assert rankdrop.check_path(robot, one.trajectory.q).clear
        there = other_branch(robot, task, q, rng)
        had += there
        if there and not kinds & {NULL, FLIP}:
            missed.append((family.id, mended.notes))
        if moved(robot, task, q, rng, tilt=True) and TILT not in kinds:
            missed.append((family.id, mended.notes))
    print(name, number, had)
    assert not missed
    assert number >= 3
    assert had >= 1


@pytest.mark.parametrize("name", ["planar3r", "ur5e"])
def test_six_corners_just_past_a_singularity(name: str) -> None:
    robot = open_robot(name)
    rng = np.random.default_rng(5)
    joint = {"planar3r": 1, "ur5e": 4}[name]
    for _ in range(6):
        corner = rng.uniform(-1.0, 1.0, robot.n)
        corner[[1, 2] if name == "ur5e" else [0]] = (-1.2, 1.4) if name == "ur5e" else 0.2
        corner[joint] = -0.01
        ends = corner + rng.normal(size=(2, robot.n)) * 0.1
        ends[:, joint] = rng.uniform(0.3, 0.5, 2)
        found = rankdrop.check_path(robot, [ends[0], corner, ends[1]], [0.0, 1.0, 2.0])
        assert crosses(found)
        kinds = {one.kind: one for one in mend_path(found, blend=0.1).remedies}
        assert BLEND in kinds
        assert kinds[BLEND].check.holds


@pytest.mark.parametrize("seed", range(8))
def test_eight_paths_that_are_too_fast(seed: int) -> None:
    robot = open_robot("ur5e")
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.5, 90)
    w, phase = rng.uniform(1.0, 6.0, (2, 6))
    angle = t[:, None] * w + phase
    q, v = np.sin(angle), w * np.cos(angle)
    for how in ("linear", "cubic"):
        found = rankdrop.check_path(robot, q, t, velocities=v, interpolate=how)
        one = {part.kind: part for part in mend_path(found, acceleration=10.0).remedies}[RETIME]
        assert one.usage is not None
        assert one.usage.slower <= 1.0 + 1e-9
        assert {part.verdict for part in one.check.stretches} == {part.verdict for part in found.stretches}
