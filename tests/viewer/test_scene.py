"""What is drawn stands where kinematics says: bodies on the links, arrows along the lost directions."""

from __future__ import annotations

import numpy as np
import pytest
from known.arms import KINDS

from rankdrop.kinematics import jacobian, link_poses, pose
from rankdrop.results.known import known_analysis
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import JointKind
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.scene import (
    LENGTH,
    Live,
    arrows,
    axis_lines,
    barrel_mesh,
    body_of,
    capsule_mesh,
    circuit_of,
    rods,
    task_frame,
    turn_onto,
    wxyz,
)

ARMS = KINDS


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Signed volume of a closed surface: positive where its triangles face outwards."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize("name", ARMS)
def test_the_spine_is_connected_from_the_base_to_the_tip(name: str) -> None:
    arm = open_robot(name)
    body, size = body_of(arm), reach(arm)
    links = link_poses(arm, np.zeros(arm.n))
    ends = [np.zeros(3), arm.home[:3, 3]]
    for one in body["link"]:
        frame = links[one.link]
        ends += [frame[:3, :3] @ point + frame[:3, 3] for point in (one.start, one.end)]
    for end in ends:  # every end is an end of another piece, on an axis, or the tip
        others = sum(np.linalg.norm(end - other) < 1e-6 * size for other in ends)
        assert others >= 2 or np.linalg.norm(end) < 1e-9 * size or any(  # a bare wrist has no length
            np.linalg.norm(np.cross(end - np.cross(j.screw[3:], j.screw[:3]), j.screw[3:])) < 1e-6
            for j in arm.joints if j.kind is JointKind.REVOLUTE
        )  # fmt: skip


def test_the_arm_of_a_scara_stands_on_its_pillar() -> None:
    arm = open_robot("scara")  # link 1 at 0.387 m
    links = link_poses(arm, np.zeros(4))
    frames = [(one, links[one.link][:3, :3], links[one.link][:3, 3]) for one in body_of(arm)["link"]]
    ends = np.array([[turn @ point + at for point in (one.start, one.end)] for one, turn, at in frames])
    assert ends[0] == pytest.approx(np.array([[0, 0, 0], [0, 0, 0.387]]))
    assert ends[1:, :, 2] == pytest.approx(0.387)


@pytest.mark.parametrize("name", ARMS)
def test_axes_are_drawn_on_the_screws(name: str) -> None:
    arm = open_robot(name)
    body = body_of(arm)
    q = np.linspace(0.2, 0.9, arm.n)
    links = link_poses(arm, q)
    numbers = [i + 1 for i, joint in enumerate(arm.variables) if joint.kind is JointKind.REVOLUTE]
    from rankdrop.task import SPACE

    screws = jacobian(arm, q, SPACE)
    leaders = {joint.mimic.leader for joint in arm.joints if joint.mimic is not None}
    for number, (low, high) in zip(numbers, axis_lines(body, links, numbers), strict=True):
        if arm.variables[number - 1].name in leaders:
            continue
        v, omega = screws[:3, number - 1], screws[3:, number - 1]
        assert np.abs(np.cross(high - low, omega)).max() < 1e-9
        assert np.abs(np.cross(low, omega) - v).max() < 1e-9  # the line is the axis


def test_a_slide_carries_its_rod() -> None:
    arm = open_robot("stanford")
    body = body_of(arm)
    q = np.array([0.3, 0.4, 0.5, 0.1, 0.2, 0.3])
    low, high = rods(body, link_poses(arm, q))[0]
    assert np.linalg.norm(high - low) == pytest.approx(0.5)


@pytest.mark.parametrize("name", ["ur5", "pa10", "puma560", "stanford", "scara", "planar3r"])
def test_arrows_point_along_the_lost_directions(name: str) -> None:
    arm = open_robot(name)
    task = resolve_task(None, arm)
    known = known_analysis(arm, task)
    assert known is not None
    live = Live(arm, task, known.families)
    for family in known.families:
        now = live.look(np.array(family.witness))
        assert now.verdict == "singular"
        assert now.seen.corank == family.corank
        assert now.lost.shape == (family.corank, 6)
        screws = jacobian(arm, now.q)[list(task.rows)]  # base axes at the tip, as the task's frame
        assert [arrow.number for arrow in now.arrows] == list(range(family.corank))  # one for each freedom
        for arrow in now.arrows:
            direction = now.lost[arrow.number]
            assert np.abs(direction[list(task.rows)] @ screws).max() < 1e-8  # no joint rate makes it
            part = direction[3:] if arrow.turns else direction[:3]
            way = arrow.end - arrow.start
            assert np.abs(np.cross(way, part)).max() < 1e-9
            assert way @ part > 0
            tip = pose(arm, now.q)[:3, 3]
            assert np.abs(arrow.start - tip).max() < 1e-9
            mixed = min(np.linalg.norm(direction[:3]), np.linalg.norm(direction[3:])) >= 0.02
            assert bool(len(arrow.ring)) == mixed
            round_about = arrow.ring[:-3].reshape(-1, 3) - tip  # without its head
            assert np.abs(round_about @ direction[3:]).max(initial=0.0) < 1e-9  # square to the rotation
            turns = np.cross(round_about[::2], round_about[1::2]) @ direction[3:]
            assert (turns > 0).all()


def test_arrows_turn_with_a_frame_that_moves() -> None:
    from rankdrop.task import BODY

    arm = open_robot("ur5")
    task = resolve_task("pose", arm, frame=BODY)
    links = link_poses(arm, [0.4, -1.0, 0.6, 0.3, 0.2, 0.5])
    axes, point = task_frame(links, task)
    assert np.allclose(axes, links[-1, :3, :3])
    found = arrows(np.array([[0, 0, 1.0, 0, 0, 0], [0, 0, 0, 1.0, 0, 0]]), links, task, 1.0)
    assert [arrow.turns for arrow in found] == [False, True]
    assert np.allclose(found[0].end - found[0].start, LENGTH * axes[:, 2])
    assert np.allclose(found[1].start, point)
    dashes = found[1].segments()
    assert dashes.shape == (7, 2, 3)
    assert np.allclose(dashes[0, 0], point)


def test_a_joint_of_two_circuits_belongs_to_the_smaller() -> None:
    assert circuit_of([(3, 5), (1, 2, 3)]) == {3: 0, 5: 0, 1: 1, 2: 1}


def test_quaternions_are_those_of_the_rotations() -> None:
    rng = np.random.default_rng(0)
    q = rng.standard_normal((200, 4))
    q[:8] = np.vstack([np.eye(4), [[0, 1, 1, 0], [0, 0, 1, 1], [0, 1, 0, 1], [1, 0, 0, 1e-9]]])
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    w, x, y, z = q.T
    turns = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]).transpose(2, 0, 1)  # fmt: skip
    same = np.abs(np.einsum("ij,ij->i", wxyz(turns), q))
    assert np.allclose(same, 1.0)


@pytest.mark.parametrize("axis", [[0, 0, 1.0], [0, 0, -1.0], [1.0, 0, 0], [0.6, 0, -0.8]])
def test_solids_are_closed_and_face_outwards(axis: list[float]) -> None:
    way = np.array(axis)
    assert np.allclose(turn_onto(way) @ [0, 0, 1], way)
    start = np.array([0.1, 0.2, 0.3])
    vertices, faces = capsule_mesh(start, start + 2.0 * way, 0.5)
    exact = np.pi * 0.25 * 2 + 4 / 3 * np.pi * 0.125
    assert volume(vertices, faces) == pytest.approx(exact, rel=0.05)
    vertices, faces = barrel_mesh(start - way, start + way, 0.5)
    assert volume(vertices, faces) == pytest.approx(np.pi * 0.25 * 2, rel=0.02)
