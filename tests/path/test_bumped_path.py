"""A joint path with bumps: untouched outside its windows, smooth inside, and the tool where it is promised."""

from __future__ import annotations

import numpy as np
import pytest

import rankdrop
from rankdrop.kinematics import pose
from rankdrop.path.mend.bumped_path import Bump, BumpedPath, ends_of, window_of
from rankdrop.path.mend.joint_tool_path import tool_path
from rankdrop.path.mend.singular_parts import Core, SingularParts
from rankdrop.robot.open import open_robot

ARM = open_robot("planar3r")
TIMES = np.linspace(0.0, 4.0, 201)
WAY = np.array([0.2, -1.0, 0.5])


def parts_of(rows: int = 201, task: str = "planar", **options: object) -> SingularParts:
    share = np.linspace(0.0, 1.0, rows)
    q = np.stack([0.2 + 0.5 * share, 0.9 + 0.2 * np.sin(3 * share), -0.7 + 0.3 * share**2], axis=1)
    times = np.linspace(0.0, 4.0, rows)
    check = rankdrop.check_path(ARM, q, times, task=task, **options)  # type: ignore[arg-type]
    return SingularParts(check, tool_path(check.robot, check.task, check.curve))


def bump_at(low: float, high: float, **given: object) -> Bump:
    """Rows between which the bump has its height, and ramps of 0.5 s and 0.7 s."""
    plain = {"way": WAY, "height": 0.1, "null": False, "ramps": (0.5, 0.7)}
    return Bump(Core(low, high, (), crossed=False), **(plain | given))  # type: ignore[arg-type]


def test_rows_outside_the_windows_stay_to_the_last_bit_and_the_core_is_lifted() -> None:
    parts = parts_of()
    path = BumpedPath(parts, [bump_at(60.0, 80.0), bump_at(140.0, 150.0, height=-0.05)])
    trajectory = path.trajectory()
    rows = np.searchsorted(trajectory.times, TIMES)
    q, old = trajectory.q[rows], parts.path.samples
    same = (q == old).all(axis=1)
    assert same[:36].all()
    assert same[186:].all()
    assert not same[36:114].any()
    np.testing.assert_allclose(q[60:81] - old[60:81], np.broadcast_to(0.1 * WAY, (21, 3)), atol=1e-12)
    np.testing.assert_allclose(q[140:151] - old[140:151], np.broadcast_to(-0.05 * WAY, (11, 3)), atol=1e-12)


def test_the_window_is_the_core_and_its_ramps() -> None:
    parts, bump = parts_of(), bump_at(60.0, 80.5)
    low, high = window_of(parts, bump)
    assert (low, high) == (pytest.approx(60.0 - 25.0), pytest.approx(80.5 + 35.0))
    assert [row + share for row, share in ends_of(parts, bump)] == [pytest.approx(low), pytest.approx(high)]


def test_a_bump_has_two_continuous_derivatives() -> None:
    """Of its own share of the motion: no jump of the second difference at the ends of ramps, beyond the grid's."""
    parts = parts_of()
    place = np.linspace(20.0, 130.0, 44001)
    lift = (BumpedPath(parts, [bump_at(60.0, 80.0)]).configurations(place) - parts.configurations(place)) @ WAY
    step = (place[1] - place[0]) * 0.02
    bend = np.diff(lift, 2) / step**2
    assert np.abs(bend).max() > 1.0
    assert np.abs(np.diff(bend)).max() < 0.02 * np.abs(bend).max()


@pytest.mark.parametrize("how", ["cubic", "quintic"])
def test_rates_of_a_smooth_path_are_those_of_its_configurations(how: str) -> None:
    share = np.linspace(0.0, 1.0, 201)
    q = np.stack([0.2 + 0.5 * share, 0.9 + 0.2 * np.sin(3 * share), -0.7 + 0.3 * share**2], axis=1)
    velocities = np.gradient(q, TIMES, axis=0, edge_order=2)
    rates = {"velocities": velocities, "interpolate": how}
    if how == "quintic":
        rates["accelerations"] = np.gradient(velocities, TIMES, axis=0, edge_order=2)
    path = BumpedPath(parts_of(**rates), [bump_at(60.0, 80.0)])
    trajectory = path.trajectory()
    assert trajectory.velocities is not None
    assert (trajectory.accelerations is not None) == (how == "quintic")
    outside = np.abs(trajectory.times - 1.4) > 1.0
    rows = np.searchsorted(TIMES, trajectory.times[outside])
    np.testing.assert_array_equal(trajectory.q[outside], q[rows])
    h = 1e-3  # of a row
    place = path.places()
    inner = (place > 30.0) & (place < 120.0) & (place != 60.0) & (place != 80.0)
    before, here, after = (path.configurations(place[inner] + shift) for shift in (-h, 0.0, h))
    np.testing.assert_allclose(trajectory.velocities[inner], (after - before) / (2 * h * 0.02), atol=2e-4)
    if trajectory.accelerations is not None:
        wanted = (after - 2 * here + before) / (h * 0.02) ** 2
        np.testing.assert_allclose(trajectory.accelerations[inner], wanted, atol=2e-2)


def test_a_null_motion_leaves_the_tool_where_it_was() -> None:
    parts = parts_of(task="planar-position")
    jacobian = rankdrop.jacobian(ARM, parts.path.samples[70])[:2]
    null = np.linalg.svd(jacobian)[2][2]
    path = BumpedPath(parts, [bump_at(60.0, 80.0, way=null, null=True)])
    place = np.linspace(0.0, 200.0, 801)
    old, new = (pose(ARM, q)[:, :2, 3] for q in (parts.configurations(place), path.configurations(place)))
    np.testing.assert_allclose(new, old, atol=1e-9)
    assert path.off()[0] < 1e-9
    assert np.abs(path.most_moved()).max() > 0.05


def test_a_tool_that_is_led_aside_is_off_its_path_by_the_twist_alone() -> None:
    parts = parts_of()
    twist = np.array([0.01, 0.0, 0.0])
    path = BumpedPath(parts, [bump_at(60.0, 80.0, height=1e-3, twist=twist)])
    place = np.linspace(0.0, 200.0, 801)
    old, new = (pose(ARM, q) for q in (parts.configurations(place), path.configurations(place)))
    np.testing.assert_allclose(new[:, :3, :3], old[:, :3, :3], atol=1e-9)
    shift = (new - old)[:, :3, 3]
    length = parts.check.length_scale
    core = (place >= 60.0) & (place <= 80.0)
    np.testing.assert_allclose(shift[core], np.broadcast_to([0.01 * length, 0.0, 0.0], (core.sum(), 3)), atol=1e-9)
    np.testing.assert_allclose(shift[:, 1:], 0.0, atol=1e-9)
    low, high = window_of(parts, path.bumps[0])
    np.testing.assert_array_equal(shift[(place <= low) | (place >= high)], 0.0)
    assert (np.diff(shift[(place > low) & (place < 60.0), 0]) > 0.0).all()
    assert path.off()[0] == pytest.approx(0.01 * length, rel=1e-3)


def test_the_deviation_and_the_largest_motion_are_those_of_the_rows() -> None:
    parts = parts_of()
    path = BumpedPath(parts, [bump_at(60.0, 80.0)])
    np.testing.assert_allclose(path.most_moved(), 0.1 * WAY, atol=1e-12)
    trajectory = path.trajectory()
    old = parts.configurations(parts.place_at(trajectory.times))
    apart = np.linalg.norm((pose(ARM, trajectory.q) - pose(ARM, old))[:, :3, 3], axis=1)
    assert path.off()[0] == pytest.approx(apart.max())
    assert path.off()[1] == pytest.approx(abs(0.1 * WAY.sum()))


def test_ramps_of_a_path_of_few_rows_get_rows_of_their_own() -> None:
    parts = parts_of(rows=9)
    bump = bump_at(3.2, 3.6)
    path = BumpedPath(parts, [bump])
    place = path.places()
    assert set(np.arange(9.0)) <= set(place)
    low, high = window_of(parts, bump)
    assert {low, 3.2, 3.6, high} <= set(place)
    ramp = place[(place >= low) & (place <= 3.2)]
    assert np.diff(parts.time(ramp)).max() <= 0.5 / 24 * (1 + 1e-9)
    assert (path.places(2.0, 5.0) == place[(place >= 2.0) & (place <= 5.0)]).all()
    assert BumpedPath(parts, ()).places().tolist() == list(range(9))
