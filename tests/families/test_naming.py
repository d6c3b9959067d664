"""Names come from the geometry of the axes: the same for the same geometry, and none where there is none."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from families.named import H, name, ur

from rankdrop.errors import ConfigurationError
from rankdrop.exact.families import _one_of_each_first
from rankdrop.families.naming import name_family
from rankdrop.families.searching import search
from rankdrop.results.known import shipped
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

Z = (0.0, pi)  # 0 and π
Q = (H, -H)  # ±π/2


def pa10() -> Robot:
    rows = [(0, -H, 0, 0), (0, H, 0, 0), (0, -H, 0.45, 0), (0, H, 0, 0), (0, -H, 0.5, 0), (0, H, 0, 0), (0, 0, 0.45, 0)]
    return from_dh(rows, convention="standard", name="a")


def puma(offset: float = 0.15, elbow: float = 0.02) -> Robot:
    rows = [(0, H, 0, 0), (0.43, 0, 0, 0), (elbow, -H, offset, 0), (0, H, 0.4, 0), (0, -H, 0, 0), (0, 0, 0.06, 0)]
    return from_dh(rows, convention="standard", name="b")


def canadarm() -> Robot:
    a, c, d = 0.635, 0.504, 6.85
    rows = [(0, 0, 0, 0), (0, H, a, 0), (0, -H, c, 0), (d, 0, 0, 0), (d, 0, c, 0), (0, H, a, 0), (0, -H, 0, 0)]
    return from_dh(rows, convention="modified", name="d")


def scara() -> Robot:
    rows = [(0.3, 0, 0.2, 0), (0.25, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 0)]
    return from_dh(rows, convention="standard", kinds="RRPR", name="e", task="scara")


def planar(count: int, task: str) -> Robot:
    return from_dh([(1.0 - 0.2 * i, 0, 0, 0) for i in range(count)], convention="standard", name="f", task=task)


def random_arm(count: int, seed: int = 0, task: str = "pose") -> Robot:
    rng = np.random.default_rng(seed)
    rows = [(rng.uniform(0.1, 0.5), rng.uniform(-1.5, 1.5), rng.uniform(0.1, 0.5), 0) for _ in range(count)]
    return from_dh(rows, convention="standard", name="g", task=task)


def points(robot: Robot, pinned: dict[int, tuple[float, ...]], count: int = 8, seed: int = 3) -> Array:
    rng = np.random.default_rng(seed)
    q = rng.uniform(-pi, pi, (count, robot.n))
    for number, values in pinned.items():
        q[:, number - 1] = rng.choice(values, count)
    return np.asarray(q)


PA10_ROWS = [
    ({2: Z, 3: Q}, "shoulder: axes 1 and 3 aligned, 2 ⟂ 4"),
    ({2: Z, 6: Z}, "shoulder and wrist: axes 1, 3 and 5, 7 aligned"),
    ({4: Z}, "elbow: arm stretched or folded"),
    ({5: Q, 6: Z}, "wrist: axes 5 and 7 aligned, 4 ⟂ 6"),
    ({2: Z, 3: Z, 4: Z}, "shoulder and elbow: axes 1, 3, 5 aligned, 2 ∥ 4"),
    ({2: Z, 4: Z, 6: Z}, "shoulder, elbow and wrist: axes 1, 3, 5, 7 aligned"),
    ({4: Z, 5: Z, 6: Z}, "elbow and wrist: axes 3, 5, 7 aligned, 4 ∥ 6"),
    ({2: Z, 3: Q, 5: Q, 6: Z}, "shoulder and wrist: axes 1, 3 and 5, 7 aligned, 2 ⟂ 4, 4 ⟂ 6"),
    ({2: Z, 3: Z, 4: Z, 5: Z, 6: Z}, "shoulder, elbow and wrist: axes 1, 3, 5, 7 aligned, 2 ∥ 4 ∥ 6"),
]


@pytest.mark.parametrize(("pinned", "expected"), PA10_ROWS)
def test_the_rows_of_am_tables_3_to_5(pinned: dict[int, tuple[float, ...]], expected: str) -> None:
    assert name(pa10(), points(pa10(), pinned)) == expected


@pytest.mark.parametrize(("pinned", "expected"), PA10_ROWS)
def test_one_point_other_lengths_another_base_and_another_tool_give_the_same_name(
    pinned: dict[int, tuple[float, ...]], expected: str
) -> None:
    rows = [(0, -H, 0, 0), (0, H, 0, 0), (0, -H, 0.3, 0), (0, H, 0, 0), (0, -H, 0.41, 0), (0, H, 0, 0), (0, 0, 0, 0)]
    base = np.eye(4)
    base[:3, :3] = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
    base[:3, 3] = 1.0, -2.0, 0.5
    tool = np.eye(4)
    tool[:3, 3] = 0.1, 0.2, 0.3
    other = from_dh(rows, convention="standard", name="a", base=base, tool=tool)
    assert name(other, points(other, pinned, count=1, seed=9)) == expected


@pytest.mark.parametrize(
    ("robot", "pinned", "expected"),
    [
        (puma(), {5: Z}, "wrist: axes 4 and 6 aligned"),
        (puma(0.0, 0.0), {3: Q}, "elbow: axes 2, 3 and wrist centre coplanar"),
        (ur(), {3: Z}, "elbow: axes 2, 3, 4 coplanar"),
        (ur(), {5: Z}, "wrist: axis 6 parallel to 2, 3, 4"),
        (scara(), {2: Z}, "elbow: axes 1, 2, 4 coplanar"),
        (planar(3, "planar"), {2: Z}, "elbow: axes 1, 2, 3 coplanar"),
        (planar(3, "planar-position"), {2: Z, 3: Z}, "elbow: axes 1, 2, 3 and tip coplanar"),
        (planar(2, "planar-position"), {2: Z}, "elbow: axes 1, 2 and tip coplanar"),
        (canadarm(), {2: Z, 6: Z}, "shoulder and wrist: axes 1, 7 parallel to 3, 4, 5"),
    ],
)
def test_pinned_families_of_known_arms(robot: Robot, pinned: dict[int, tuple[float, ...]], expected: str) -> None:
    assert name(robot, points(robot, pinned)) == expected


def test_two_losses_of_rank_at_once_are_told_with_what_joins_them() -> None:
    found = search(ur(), 2, task=resolve_task(None, ur()), starts=60, seed=0).converged
    both = found[(np.abs(np.sin(found[:, 2])) < 1e-9) & (np.abs(np.sin(found[:, 4])) < 1e-9)]
    assert name(ur(), both) == "elbow and wrist, axes 2, 3, 4, 6 parallel and coplanar"


def test_the_shoulder_of_an_arm_with_offset_is_a_plane_and_without_it_an_axis() -> None:
    def shoulder(robot: Robot, offset: float) -> Array:
        q = points(robot, {})
        # a2 c2 + a3 c23 − d4 s23 = 0 for q2
        a = 0.43 + offset * np.cos(q[:, 2]) - 0.4 * np.sin(q[:, 2])
        b = -offset * np.sin(q[:, 2]) - 0.4 * np.cos(q[:, 2])
        q[:, 1] = np.arctan2(-a, b)
        return q

    assert name(puma(), shoulder(puma(), 0.02)) == "shoulder: wrist centre in plane of axes 1, 2"
    assert name(puma(0.0), shoulder(puma(0.0), 0.02)) == "shoulder: wrist centre on axis 1"


def test_three_axes_of_a_bare_wrist() -> None:
    wrist = from_dh([(0, H, 0, 0), (0, -H, 0, 0), (0, 0, 0.1, 0)], convention="standard", name="h", task="orientation")
    assert name(wrist, points(wrist, {2: Z})) == "axes 1 and 3 aligned"


def test_a_stanford_arm_has_its_wrist_centre_on_axis_2_or_its_slide_along_axis_1() -> None:
    rows = [(0, -H, 0.4, 0), (0, H, 0.15, 0), (0, 0, 0.3, 0), (0, -H, 0, 0), (0, H, 0, 0), (0, 0, 0.2, 0)]
    stanford = from_dh(rows, convention="standard", kinds="RRPRRR", name="i")
    assert name(stanford, points(stanford, {3: (-0.3,)})) == "wrist centre on axis 2"
    assert name(stanford, points(stanford, {2: Z})) == "shoulder: wrist centre in plane of axes 1, 2"
    assert name(stanford, points(stanford, {5: Z})) == "wrist: axes 4 and 6 aligned"


@pytest.mark.parametrize(
    ("robot", "expected"),
    [
        (random_arm(6), "joints 1–6 dependent"),
        (random_arm(7), "joints 1–7 of rank 5"),
        (random_arm(4, task="position"), "a line through the tip meets all axes"),
    ],
)
def test_no_part_of_the_arm_is_blamed_where_the_geometry_names_none(robot: Robot, expected: str) -> None:
    found = search(robot, 1, task=resolve_task(None, robot), starts=20, seed=0).converged
    assert name(robot, found) == expected


def test_a_family_that_needs_more_than_its_facts_says_so() -> None:
    found = search(canadarm(), 1, task=resolve_task(None, canadarm()), starts=60, seed=0).converged
    stretched = found[np.abs(np.sin(found[:, 3])) < 1e-9]
    task = resolve_task(None, canadarm())
    told = name_family(canadarm(), task, stretched, [4], coupled=[2, 3, 5, 6])
    assert str(told) == "elbow: axes 3, 4, 5 coplanar, with a condition on θ2, θ3, θ5, θ6"
    assert name(canadarm(), stretched) == "elbow: axes 3, 4, 5 coplanar"


def test_values_that_are_no_simple_angles_tell_the_posture() -> None:
    panda = open_robot("panda")
    rng = np.random.default_rng(0)
    q = rng.uniform(-3, 3, (24, 7))
    stretched = np.arctan2(0.0825 * (0.316 + 0.384), 0.0825**2 - 0.316 * 0.384)
    q[:, 3] = np.where(np.arange(24) % 2, stretched, stretched - np.pi)
    q[:, 4] = np.where(np.arange(24) % 3, 0.0, np.pi)
    told = name_family(panda, resolve_task(None, panda), q, [4, 5], coupled=[])
    assert str(told) == "elbow: arm nearly stretched or folded, 4 ∥ 6 (θ4 = −26.8° or 153.2°)"
    alone = name_family(panda, resolve_task(None, panda), q[::2], [4, 5], coupled=[])
    assert str(alone) == "elbow: arm nearly stretched or folded, 4 ∥ 6 (θ4 = −26.8°)"


def test_the_name_does_not_depend_on_what_the_arm_is_called() -> None:
    renamed = replace(pa10(), name="elbowless")
    assert name(renamed, points(renamed, {4: Z})) == "elbow: arm stretched or folded"


def test_joints_told_to_be_pinned_are_explained() -> None:
    task = resolve_task(None, pa10())
    assert str(name_family(pa10(), task, points(pa10(), {4: Z}), [4])) == "elbow: arm stretched or folded"


@pytest.mark.parametrize(
    "q", [np.zeros((0, 7)), np.zeros(7), np.zeros((2, 6)), np.full((1, 7), np.nan), np.full((1, 7), 0.7)]
)
def test_what_is_not_a_singular_family_is_refused(q: Array) -> None:
    with pytest.raises(ConfigurationError):
        name(pa10(), q)


def test_an_angle_that_is_nearly_a_right_one_is_not_written_as_one() -> None:
    jaka = [one.name for one in shipped("jaka_zu3").families]
    assert "elbow: axes 2, 3, 4 coplanar (θ3 = −0.003° or 179.997°)" in jaka


def test_a_name_is_read_off_points_of_every_set_of_a_family() -> None:
    parts = [np.full((20, 2), 0.0), np.full((3, 2), 1.0), np.full((5, 2), 2.0)]
    assert _one_of_each_first(parts)[:9, 0].tolist() == [0.0, 1.0, 2.0] * 3
    assert len(_one_of_each_first(parts)) == 28
