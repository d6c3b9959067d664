"""Lost directions of arms: true, independent of the length scale, exactly as many as the corank."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import jacobian, link_poses
from rankdrop.local.directions import (
    lost_directions,
    lost_in_sparsest_frame,
    lost_over_family,
    seen_in_frames,
    words,
)
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Array, Joint, Mimic, Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import revolute
from rankdrop.task import BODY, SPACE, TIP, WORLD_ALIGNED, Frame, resolve_task, six_rows

H = pi / 2


@pytest.fixture
def pa10() -> Robot:
    rows = [(0, -H, 0, 0), (0, H, 0, 0), (0, -H, 0.45, 0), (0, H, 0, 0), (0, -H, 0.5, 0), (0, H, 0, 0), (0, 0, 0.45, 0)]
    return from_dh(rows, convention="standard", name="seven")


@pytest.fixture
def scara() -> Robot:
    rows = [(0.3, 0, 0.2, 0), (0.25, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 0)]
    return from_dh(rows, convention="standard", kinds="RRPR", name="four", task="scara")


SINGULAR = [
    ([0.3, 0.4, 0.5, 0.0, 0.2, 0.4, 1.0], 1),
    ([0.3, 0.0, H, 0.7, 0.2, 0.4, 1.0], 1),
    ([0.3, 0.0, 0.4, 0.7, 0.2, pi, 1.0], 1),
    ([0.3, 0.0, 0.0, 0.0, 0.2, 0.3, 1.0], 2),
    ([0.3, pi, -H, 0.4, H, 0.0, 1.0], 2),
    ([0.3, 0.0, 0.0, pi, 0.0, 0.0, 1.0], 3),
]


@pytest.mark.parametrize(("q", "corank"), SINGULAR)
@pytest.mark.parametrize("length_scale", [None, 1.0, 0.05, 100.0])
def test_no_joint_rate_has_a_component_along_a_lost_direction(
    pa10: Robot, q: list[float], corank: int, length_scale: float | None
) -> None:
    lost = lost_directions(pa10, q, resolve_task("pose", pa10, length_scale=length_scale), corank)
    assert lost.shape == (corank, 6)
    assert np.abs(lost @ lost.T - np.eye(corank)).max() < 1e-12
    assert np.abs(lost @ jacobian(pa10, np.array(q))).max() < 1e-12
    reference = lost_directions(pa10, q, resolve_task("pose", pa10), corank)
    assert np.abs(lost - reference).max() < 1e-9, "the length scale decides nothing"


@pytest.mark.parametrize("frame", [BODY, SPACE, WORLD_ALIGNED, Frame(3, 2, (0.1, 0.0, -0.2))])
@pytest.mark.parametrize(("q", "corank"), SINGULAR)
def test_directions_are_in_the_frame_of_the_task(pa10: Robot, q: list[float], corank: int, frame: Frame) -> None:
    lost = lost_directions(pa10, q, resolve_task("pose", pa10, frame=frame), corank)
    assert np.abs(lost @ jacobian(pa10, np.array(q), frame)).max() < 1e-12


@pytest.mark.parametrize(("q", "corank"), SINGULAR)
def test_another_base_changes_nothing_seen_from_the_end_effector(pa10: Robot, q: list[float], corank: int) -> None:
    base = np.eye(4)
    base[:3, :3] = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    base[:3, :3] *= np.linalg.det(base[:3, :3])
    base[:3, 3] = 0.3, -2.0, 0.7
    moved = _on_base(pa10, base)
    task = resolve_task("pose", pa10, frame=BODY)
    assert np.abs(lost_directions(pa10, q, task, corank) - lost_directions(moved, q, task, corank)).max() < 1e-9


@pytest.mark.parametrize(("q", "corank"), SINGULAR)
def test_the_chosen_frame_has_no_more_entries_and_the_directions_are_lost_in_it(
    pa10: Robot, q: list[float], corank: int
) -> None:
    task = resolve_task("pose", pa10)
    chosen = lost_in_sparsest_frame(pa10, q, task, corank)
    assert np.abs(chosen.directions @ jacobian(pa10, np.array(q), chosen.frame)).max() < 1e-12
    own = lost_directions(pa10, q, task, corank)
    assert (np.abs(chosen.directions) > 1e-6).sum() <= (np.abs(own) > 1e-6).sum()


@pytest.mark.parametrize("frame", [BODY, SPACE, Frame(3, 2, (0.1, 0.0, -0.2)), Frame(4, 4)])
@pytest.mark.parametrize(("q", "corank"), SINGULAR)
def test_from_whatever_frame_the_task_has_the_chosen_frame_is_right(
    pa10: Robot, q: list[float], corank: int, frame: Frame
) -> None:
    joints = np.array(q) + 0.0
    chosen = lost_in_sparsest_frame(pa10, joints, resolve_task("pose", pa10, frame=frame), corank)
    assert np.abs(chosen.directions @ jacobian(pa10, joints, chosen.frame)).max() < 1e-12
    points = np.tile(joints, (3, 1))
    points[1, 0], points[2, 6] = 1.0, 0.6
    steady = lost_over_family(pa10, points, resolve_task("pose", pa10, frame=frame), corank)
    if steady is not None:
        for point in points:
            assert np.abs(steady.directions @ jacobian(pa10, point, steady.frame)).max() < 1e-12


@pytest.mark.parametrize("own", [BODY, SPACE, WORLD_ALIGNED, Frame(3, 2, (0.1, 0.0, -0.2))])
def test_what_is_blocked_is_blocked_in_every_frame_it_is_rewritten_in(pa10: Robot, own: Frame) -> None:
    q = np.array(SINGULAR[4][0])
    lost = lost_directions(pa10, q, resolve_task("pose", pa10, frame=own), 2)
    frames = [own, *(Frame(axes, origin) for axes in (*range(8), TIP) for origin in (*range(8), TIP))]
    seen = seen_in_frames(lost, link_poses(pa10, q), own, frames)
    for rows, frame in zip(seen, frames, strict=True):
        assert np.abs(rows @ jacobian(pa10, q, frame)).max() < 1e-12


def test_an_elbow_blocks_a_force_along_the_stretched_arm(pa10: Robot) -> None:
    chosen = lost_in_sparsest_frame(pa10, SINGULAR[0][0], resolve_task("pose", pa10), 1)
    assert words(chosen.directions[0], chosen.name) == "cannot translate along Y of link 5 at its origin"


def test_the_stretched_arm_loses_two_translations_and_a_rotation(pa10: Robot) -> None:
    chosen = lost_in_sparsest_frame(pa10, np.zeros(7), resolve_task("pose", pa10), 3)
    assert [words(direction, chosen.name) for direction in chosen.directions] == [
        "cannot translate along Y of the base",
        "cannot translate along Z of the base",
        "cannot rotate about X of the base",
    ]


@pytest.mark.parametrize("task", ["scara", "pose", "vx,vy,wx"])
def test_what_an_arm_never_does_is_not_told_as_lost(scara: Robot, task: str) -> None:
    q = [0.3, 0.0, 0.1, 0.2]
    lost = lost_directions(scara, q, resolve_task(task, scara), 1)
    assert np.allclose(lost, [[np.cos(0.3), np.sin(0.3), 0, 0, 0, 0]], atol=1e-9)


def test_an_arm_whose_constant_losses_turn_with_it_still_gives_one_direction_for_corank_one() -> None:
    rows = [(0, H, 0.3, 0), (0.4, 0, 0, 0), (0.3, 0, 0, 0), (0, H, 0, 0), (0, 0, 0.1, 0)]
    five = from_dh(rows, convention="standard", name="five")
    q = np.array([0.3, 0.5, 0.0, 0.4, 0.2])  # stretched
    lost = lost_directions(five, q, resolve_task("pose", five), 1)
    assert lost.shape == (1, 6)
    assert np.abs(lost @ jacobian(five, q)).max() < 1e-12


def test_rows_outside_the_task_are_zero() -> None:
    rows = [(0.5, 0, 0, 0), (0.4, 0, 0, 0)]
    two = from_dh(rows, convention="standard", name="two", task="planar-position")
    lost = lost_directions(two, [0.0, 0.0], resolve_task(None, two), 1)
    assert np.abs(lost - [1, 0, 0, 0, 0, 0]).max() < 1e-12


def test_a_joint_that_follows_another_is_carried_along() -> None:
    joints = (
        Joint("a", "revolute", revolute([0, 0, 1], [0, 0, 0])),  # type: ignore[arg-type]
        Joint("b", "revolute", revolute([0, 0, 1], [1, 0, 0])),  # type: ignore[arg-type]
        Joint("c", "revolute", revolute([0, 0, 1], [2, 0, 0]), mimic=Mimic("b", 2.0, 0.1)),  # type: ignore[arg-type]
    )
    home = np.eye(4)
    home[0, 3] = 2.5
    robot = Robot("coupled", joints, home, task="planar-position")
    task = resolve_task(None, robot)
    angles = np.linspace(-3.0, 3.0, 20001)
    flat = np.stack([np.zeros_like(angles), angles], axis=1)
    q = flat[np.argmin(np.linalg.svd(jacobian(robot, flat)[:, :2], compute_uv=False)[:, 1])]
    chosen = lost_in_sparsest_frame(robot, q, task, 1)
    assert np.abs(chosen.directions @ jacobian(robot, q, chosen.frame)).max() < 1e-3


def test_wrong_questions_are_refused(pa10: Robot) -> None:
    task = resolve_task("pose", pa10)
    with pytest.raises(ConfigurationError):
        lost_directions(pa10, np.zeros((2, 7)), task, 1)
    for corank in (0, 7):
        with pytest.raises(OptionError, match="allowed: 1 … 6"):
            lost_directions(pa10, np.zeros(7), task, corank)


def _on_base(robot: Robot, base: Array) -> Robot:
    def screw(given: Array) -> Array:
        w = base[:3, :3] @ given[3:]
        return np.concatenate([base[:3, :3] @ given[:3] + np.cross(base[:3, 3], w), w])

    joints = tuple(replace(joint, screw=screw(joint.screw), frame=base @ joint.frame) for joint in robot.joints)
    return replace(robot, joints=joints, home=base @ robot.home)


@pytest.mark.parametrize(
    ("pins", "corank"), [({4: 0.0}, 1), ({4: np.pi}, 1), ({2: 0.0, 3: np.pi / 2, 5: np.pi / 2, 6: 0.0}, 2)]
)
def test_directions_over_a_family_are_lost_at_every_point_of_it(pins, corank, rng):
    robot = open_robot("pa10")
    task = resolve_task("pose", robot)
    q = rng.uniform(-2.5, 2.5, (6, 7))
    for joint, value in pins.items():
        q[:, joint - 1] = value
    steady = lost_over_family(robot, q, task, corank)
    assert steady is not None
    for point in q:
        columns = jacobian(robot, point, steady.frame)
        assert np.abs(steady.directions @ columns).max() < 1e-12


def test_no_frame_is_claimed_where_directions_move(rng):
    robot = open_robot("pa10")
    q = rng.uniform(-2.5, 2.5, (6, 7))
    q[:, 1] = q[:, 5] = 0.0  # shoulder and wrist: AM Table 3, row 2
    assert lost_over_family(robot, q, resolve_task("pose", robot), 1) is None


def test_rows_of_a_task_keep_their_places_among_all_six() -> None:
    task = resolve_task("vy,vz,wx", open_robot("pa10"))
    assert six_rows(np.array([[1.0, 2.0, 3.0]]), task).tolist() == [[0.0, 1.0, 2.0, 3.0, 0.0, 0.0]]
