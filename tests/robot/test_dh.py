"""DH tables: pose by the screws equals the product of DH matrices, in both conventions."""

from __future__ import annotations

from math import cos, inf, pi, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference.kinematics import pose

from rankdrop.errors import RobotError
from rankdrop.robot.dh import DHRow, from_dh
from rankdrop.robot.model import Array, JointKind
from rankdrop.robot.transform import from_xyz_rpy


def rz_tz(theta: float, d: float) -> Array:
    c, s = cos(theta), sin(theta)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, d], [0, 0, 0, 1]])


def tx_rx(a: float, alpha: float) -> Array:
    c, s = cos(alpha), sin(alpha)
    return np.array([[1, 0, 0, a], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])


def product(rows: list[DHRow], q: Array, convention: str) -> list[Array]:
    """Pose of every DH frame: the table multiplied out."""
    poses, result = [], np.eye(4)
    for row, x in zip(rows, q, strict=True):
        turn = 0.0 if row.kind is JointKind.PRISMATIC else x
        shift = {JointKind.PRISMATIC: x, JointKind.HELICAL: row.pitch * x}.get(row.kind, 0.0)
        own, link = rz_tz(row.theta + turn, row.d + shift), tx_rx(row.a, row.alpha)
        result = result @ (own @ link if convention == "standard" else link @ own)
        poses.append(result)
    return poses


numbers = st.floats(-2.0, 2.0)


@st.composite
def rows_and_q(draw: Any) -> tuple[list[DHRow], Array]:
    rows = []
    for _ in range(draw(st.integers(1, 7))):
        kind = draw(st.sampled_from(list(JointKind)))
        alpha = draw(st.sampled_from([0.0, pi / 2, -pi / 2, pi]) | numbers)
        a, d, theta, pitch = (draw(numbers) for _ in range(4))
        rows.append(DHRow(a, alpha, d, theta, kind, pitch or 0.25 if kind is JointKind.HELICAL else 0.0))
    return rows, np.array([draw(numbers) for _ in rows])


@pytest.mark.by_hand_at("standard")
@pytest.mark.slow_at("standard")
@pytest.mark.parametrize("convention", ["standard", "modified"])
@given(case=rows_and_q())
def test_pose_equals_the_product_of_dh_matrices(convention: Any, case: tuple[list[DHRow], Array]) -> None:
    rows, q = case
    robot = from_dh(rows, convention=convention)
    assert pose(robot, q) == pytest.approx(product(rows, q, convention)[-1], abs=1e-13)


@pytest.mark.parametrize("convention", ["standard", "modified"])
@given(case=rows_and_q())
def test_joint_frame_is_the_dh_frame_at_zero(convention: Any, case: tuple[list[DHRow], Array]) -> None:
    rows, _ = case
    robot = from_dh(rows, convention=convention)
    frames = [joint.frame for joint in robot.joints]
    assert np.array(frames) == pytest.approx(np.array(product(rows, np.zeros(len(rows)), convention)), abs=1e-13)


def test_the_conventions_agree_on_one_arm(rng: np.random.Generator) -> None:
    a, alpha, d, theta = rng.uniform(-1, 1, (4, 6))
    standard = from_dh(list(zip(a, alpha, d, theta, strict=True)), convention="standard")
    shifted = zip(np.roll(a, 1) * (np.arange(6) > 0), np.roll(alpha, 1) * (np.arange(6) > 0), d, theta, strict=True)
    modified = from_dh(list(shifted), convention="modified", tool=tx_rx(a[-1], alpha[-1]))
    for one, other in zip(standard.joints, modified.joints, strict=True):
        assert one.screw == pytest.approx(other.screw, abs=1e-14)
    assert standard.home == pytest.approx(modified.home, abs=1e-14)


def test_base_and_tool_stand_before_and_after(rng: np.random.Generator) -> None:
    rows = [DHRow(*rng.uniform(-1, 1, 4)) for _ in range(3)]
    base, tool = from_xyz_rpy([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]), from_xyz_rpy([1, 2, 3], [0.1, -0.2, 0.3])
    q = rng.uniform(-3, 3, 3)
    robot = from_dh(rows, convention="standard", base=base, tool=tool)
    assert pose(robot, q) == pytest.approx(base @ product(rows, q, "standard")[-1] @ tool, abs=1e-13)


def test_right_angles_leave_exact_zeros_in_the_screws() -> None:
    rows = [(0, "pi/2", 0.5, 0), (0.3, "-pi/2", 0, "pi"), (0.2, "90 deg", 0.1, "-pi/2"), (0, "-270 deg", 0.4, 0)]
    for joint in from_dh(rows, convention="standard").joints:
        assert set(np.abs(joint.screw[3:])) == {0.0, 1.0}


def test_rows_may_be_sequences_mappings_or_records() -> None:
    record = DHRow(0.1, pi / 2, 0.2, pi)
    forms = [record, {"a": "100 mm", "alpha": "pi/2", "d": 0.2, "theta": "180 deg"}, (0.1, "pi/2", 0.2, "pi")]
    screws = [from_dh([form, form], convention="standard").joints[1].screw for form in forms]
    assert np.ptp(np.array(screws), axis=0) == pytest.approx(0.0, abs=1e-16)


def test_kinds_override_and_limits_have_the_unit_of_the_joint() -> None:
    rows = [{"lower": "-90 deg", "velocity": "180 deg/s"}, {"upper": "210 mm", "velocity": 0.5}]
    joints = from_dh(rows, convention="standard", kinds="RP").joints
    assert [joint.kind for joint in joints] == ["revolute", "prismatic"]
    assert (joints[0].lower, joints[0].upper, joints[0].velocity) == (-pi / 2, inf, pi)
    assert (joints[1].lower, joints[1].upper, joints[1].velocity) == (-inf, 0.21, 0.5)


@pytest.mark.parametrize(
    ("rows", "options", "words"),
    [
        ([(1, 0, 0, 0)], {"convention": "craig"}, "convention must be named"),
        ([(1, 0, 0)], {}, "four numbers"),
        ([(1, 0, 0, "ninety")], {}, "DH row 1, theta: the unit"),
        ([{"alfa": 1}], {}, "DH row 1, alfa: unknown key; got 'alfa'; allowed: a, alpha"),
        ([{"kind": "ball"}], {}, "no such kind of joint; got 'ball'; allowed: revolute"),
        ([(float("nan"), 0, 0, 0)], {}, "DH row 1, a: the value is not finite"),
        ([{"lower": 1, "upper": 0}], {}, "lower limit above upper limit"),
        ([{"velocity": 0}], {}, "velocity is not positive"),
        ([{"pitch": 1}], {}, "only a helical joint"),
        ([(1, 0, 0, 0)], {"kinds": "RR"}, "one entry per row"),
        ([(1, 0, 0, 0)], {"tool": np.ones((4, 4))}, "not a rigid transform"),
        ([(1, 0, 0, 0)], {"base": np.eye(3)}, "a pose is"),
        ([], {}, "no moving joint"),
    ],
)
def test_what_cannot_be_used_is_said_in_one_line(rows: Any, options: dict[str, Any], words: str) -> None:
    with pytest.raises(RobotError, match=words) as caught:
        from_dh(rows, **{"convention": "standard", **options})
    assert "\n" not in str(caught.value)
