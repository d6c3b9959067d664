"""Moves of a program one after the other: where joint moves end, in which posture, and how long each lasts."""

from __future__ import annotations

from itertools import product
from math import pi

import numpy as np
import pytest
from reference.kinematics import pose

from path.program_data import ASK
from rankdrop.path.check.moves import EndCause
from rankdrop.path.check.program import check_program
from rankdrop.path.read import krl, urscript
from rankdrop.poses.branches import inverse
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot

START = np.array([0.2, -1.3, 1.5, -1.1, 1.2, -0.8])
STEP = np.array([0.1, -0.4, 0.2, 0.3, -0.1, 0.05])


def ends_and_times(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Configurations at the rows of a URScript program of a UR5e, and their times."""
    (part,) = check_program(open_robot("ur5e"), urscript.read(text, "a.script"), ASK).parts
    curve = part.check.curve
    return np.concatenate([curve.control[:, 0], curve.control[-1:, -1]]), curve.times


@pytest.mark.parametrize(("how", "seconds"), [("t=3.5", 3.5), ("v=0.5", 0.4 / 0.5), ("a=1.0, v=0.1", 0.4 / 0.1)])
def test_a_joint_move_lasts_as_stated_or_as_its_fastest_joint_needs(how: str, seconds: float) -> None:
    q, times = ends_and_times(f"movej({START.tolist()})\nmovej({(START + STEP).tolist()}, {how})\n")
    np.testing.assert_allclose(q, [START, START + STEP], atol=1e-12)
    assert times[-1] - times[0] == pytest.approx(seconds)


def test_a_joint_move_with_a_share_of_the_rates_keeps_to_every_limit() -> None:
    """25 % of the largest rates: the joint that needs longest decides, and no joint exceeds its share."""
    robot = open_robot("kr6r900")
    joints = "A1 {0}, A2 -90, A3 {1}, A4 0, A5 60, A6 {2}"
    text = f"DEF a()\nBAS(#VEL_PTP,25)\nPTP {{{joints.format(0, 90, 0)}}}\nPTP {{{joints.format(20, 80, 90)}}}\nEND\n"
    (part,) = check_program(robot, krl.read(text, "a.src"), ASK).parts
    rates = np.array([joint.velocity for joint in robot.variables])
    shares = np.radians([20, 0, 10, 0, 0, 90]) / part.check.curve.times[-1] / rates
    assert shares.max() == pytest.approx(0.25, rel=1e-6)
    assert shares.max() <= 0.25


def with_turns(robot: Robot, goal: np.ndarray) -> list[np.ndarray]:
    """All solutions of a pose with all whole turns inside the joint limits."""
    found = [np.array(branch.q) for branch in inverse(robot, goal).branches]
    every = [solution + 2 * pi * np.array(turns) for solution in found for turns in product((-1, 0, 1), repeat=6)]
    return [one for one in every if (one >= robot.lower).all() and (one <= robot.upper).all()]


@pytest.mark.parametrize(("first", "last"), [(0.0, 0.0), (-5.5, 0.0), (0.0, 5.5), (0.0, 3.0), (0.0, -5.0)])
def test_a_joint_move_to_a_pose_ends_at_its_nearest_solution(first: float, last: float) -> None:
    """Joints 1 and 6 of a UR5e turned before the move: of what a turn leads to only what the limits allow counts."""
    robot = open_robot("ur5e")
    begin = START + np.array([first, 0, 0, 0, 0, last])
    goal = pose(robot, START + STEP)
    q, _ = ends_and_times(f"movej({begin.tolist()})\nmovej(p{rotation_vector_pose(goal)})\n")
    nearest = min(with_turns(robot, goal), key=lambda one: float(np.linalg.norm(one - begin)))
    np.testing.assert_allclose(q[-1], nearest, atol=1e-7)
    assert pose(robot, q[-1]) == pytest.approx(goal, abs=1e-9)


def rotation_vector_pose(goal: np.ndarray) -> list[float]:
    """x, y, z, and the axis times the angle of the rotation, as URScript writes poses."""
    turn = goal[:3, :3]
    angle = float(np.arccos((np.trace(turn) - 1) / 2))
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / (2 * np.sin(angle))
    return [*goal[:3, 3].tolist(), *(angle * axis).tolist()]


FRAME = "X 500, Y 60, Z 600, A 170, B 40, C 170"
FIRST = "PTP {A1 0, A2 -90, A3 90, A4 0, A5 60, A6 0}\n"


def test_a_target_with_signs_is_reached_with_these_alone() -> None:
    """Bit k of KRL's T: joint k + 1 is negative. Every set of signs that some solution has, and two that none has."""
    robot = open_robot("kr6r900")
    start = np.radians([0, -90, 90, 0, 60, 0])
    goal = krl.read(f"DEF a()\n{FIRST}PTP {{{FRAME}}}\nEND\n", "a.src").moves[-1].target.pose
    of_signs: dict[int, list[np.ndarray]] = {}
    for solution in with_turns(robot, goal):
        of_signs.setdefault(sum(1 << k for k in np.flatnonzero(solution < 0.0).tolist()), []).append(solution)
    assert len(of_signs) >= 4
    for signs, solutions in of_signs.items():
        text = f"DEF a()\n{FIRST}PTP {{{FRAME}, T {signs}}}\nEND\n"
        (part,) = check_program(robot, krl.read(text, "a.src"), ASK).parts
        assert part.ended is None
        nearest = min(solutions, key=lambda one: float(np.linalg.norm(one - start)))
        np.testing.assert_allclose(part.check.curve.control[-1, -1], nearest, atol=1e-7)
    for signs in [signs for signs in range(64) if signs not in of_signs][:2]:
        for before in (FIRST, ""):  # after another move, and as the first one
            text = f"DEF a()\n{before}PTP {{{FRAME}, T {signs}}}\n{FIRST}END\n"
            parts = check_program(robot, krl.read(text, "a.src"), ASK).parts
            assert parts[0].ended is not None
            assert parts[0].ended.cause is EndCause.POSTURE


def test_a_pose_out_of_reach_ends_the_part_there() -> None:
    text = f"DEF a()\n{FIRST}PTP {{X 5000, Y 0, Z 600, A 180, B 40, C 180}}\n{FIRST}END\n"
    ended = [part.ended for part in check_program(open_robot("kr6r900"), krl.read(text, "a.src"), ASK).parts]
    assert ended[0] is not None
    assert (ended[0].cause, ended[0].move.line) == (EndCause.UNREACHED, 3)
