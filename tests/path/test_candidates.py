"""Other joint paths for a tool path: null-space motion mends crossing paths that a self-motion avoids."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from known.members import members

import rankdrop
from rankdrop.cli import main
from rankdrop.kinematics import pose
from rankdrop.local.block import singular_values
from rankdrop.path import mend_path
from rankdrop.path.mend.record import NULL
from rankdrop.poses.inverse import Aim
from rankdrop.results.known import known_analysis
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task

WIDE = 0.05  # of σ_6: a self-motion that keeps it along the tool path is a way past
ROWS = 81


def crossing_paths(robot: Robot, task: Task, count: int, seed: int) -> list[Array]:
    """Paths through singular configurations of corank 1 that are not at the edge of the reach: others at that pose are
    regular. From random members of the families, along random ways, inside the limits.
    """
    rng = np.random.default_rng(seed)
    families = [one for one in known_analysis(robot, task).families if one.corank == 1 and one.equations]
    aim, found = Aim(robot, task), []
    low, high = np.maximum(robot.lower, -np.pi) + 0.25, np.minimum(robot.upper, np.pi) - 0.25
    for _ in range(60):
        family = families[rng.integers(len(families))]
        there = members(robot, task, family, 40, seed=int(rng.integers(1 << 30)), starts=200)
        there = (there + np.pi) % (2 * np.pi) - np.pi
        there = there[((there > low) & (there < high)).all(axis=1)]
        for middle in there[:2]:
            others = aim.solve_from(pose(robot, middle), rng.uniform(low, high, (60, robot.n)))
            others = others[((others > robot.lower) & (others < robot.upper)).all(axis=1)]
            if not len(others) or singular_values(robot, others, task)[:, 5].max() < 2 * WIDE:
                continue
            way = rng.normal(size=robot.n) * 0.08
            found.append(middle + np.linspace(-1, 1, ROWS)[:, None] * way)
            if len(found) == count:
                return found
    return found


def self_motion_is_wide(robot: Robot, task: Task, q: Array) -> bool:
    """Whether small steps of a fixed size along the null space of the first pose come to a configuration from which the
    shortest joint motion runs the whole tool path with σ wide, inside the limits: by other code than the plan's.
    """
    aim, poses = Aim(robot, task), pose(robot, q)
    for sign in (1.0, -1.0):
        at, last = q[0].copy(), None
        for number in range(240):
            null = np.linalg.svd(aim.jacobian(at[None])[0])[2][6]
            null = null if last is None else null * np.sign(null @ last)
            last = null if last is not None else null * sign
            at, arrived = (part[0] for part in aim.solve(poses[:1], (at + 0.05 * last)[None]))
            if not arrived or ((at < robot.lower) | (at > robot.upper)).any():
                break
            if number % 6 == 5 and marched(robot, task, aim, poses, at):
                return True
    return False


def marched(robot: Robot, task: Task, aim: Aim, poses: Array, start: Array) -> bool:
    made = [start]
    for wanted in poses[1:]:
        there, arrived = aim.solve(wanted[None], made[-1][None])
        if not arrived[0] or np.abs(there[0] - made[-1]).max() > 0.1:
            return False
        made.append(there[0])
    q = np.array(made)
    inside = ((q >= robot.lower) & (q <= robot.upper)).all()
    return bool(inside and singular_values(robot, q, task)[:, 5].min() > WIDE)


@pytest.mark.by_hand
@pytest.mark.parametrize("name", ["panda", "iiwa14", "pa10", "gen3"])
def test_crossing_paths_that_a_self_motion_avoids_are_mended_by_one(name: str, tmp_path: Path, capsys) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    had, got, same, missed = 0, 0, 0, []
    for number, q in enumerate(crossing_paths(robot, task, 6, 7)):
        found = rankdrop.check_path(robot, q)
        if found.verdict == "free":
            continue
        there = self_motion_is_wide(robot, task, q)
        mended = mend_path(found)
        one = next((part for part in mended.remedies if part.kind == NULL), None)
        had += there
        if one is None:
            if there:
                missed.append((number, mended.notes))
            continue
        got += 1
        same += bool((one.trajectory.q[0] == q[0]).all())
        assert rankdrop.check_path(robot, one.trajectory.q).verdict == "free"
        last = q, one
    print(name, "paths that a self-motion avoids", had, "mended by null-space motion", got, "from the same start", same)
    assert not missed
    assert got >= 3
    q, one = last
    np.save(tmp_path / "bad.npy", q)
    assert main.run(["path", name, str(tmp_path / "bad.npy"), "--fixed", str(tmp_path / "good.csv"), "--quiet"]) == 3
    assert main.run(["path", name, str(tmp_path / "good.csv"), "--json", str(tmp_path / "again.json"), "--quiet"]) == 0
    assert json.loads((tmp_path / "again.json").read_text())["verdict"] == "free"
