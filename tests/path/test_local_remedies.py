"""Local remedies: bumps of the joints that keep the rest of a file, and detours of the tool around a crossing."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import rankdrop
from path.dipping import DEPTH, MIDDLE, dipping, mended, smooth
from rankdrop.cli import main
from rankdrop.kinematics import pose
from rankdrop.local.block import singular_values
from rankdrop.path.curve import Curve, curve
from rankdrop.path.mend import local_remedies
from rankdrop.path.mend.bumps import CLEARANCE
from rankdrop.path.mend.local_change import tool_off
from rankdrop.path.mend.mend import mend_path
from rankdrop.path.mend.record import LOCAL, Mending, Remedy
from rankdrop.path.read.files import read_trajectory
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

DIP = 4.3  # what five lines of NumPy need at joint 5 [°]


def crossing(name: str, rows: int) -> tuple[Array, Array]:
    """A program whose wrist goes from 30° to −25° and stays there."""
    q, t = dipping(name, rows, to=30.0)
    q[:, 4] -= np.radians(55.0) * smooth((t - t[-1] / 2) / 2.0 + 0.5)
    return q, t


@cache
def led_around(name: str) -> tuple[Array, Array, Remedy]:
    """The rows and times of a program that crosses for good, and its detour."""
    q, t = crossing(name, 1000)
    best = mend_path(rankdrop.check_path(open_robot(name), q, t), kinds=LOCAL).best
    assert best is not None
    return q, t, best


@pytest.mark.by_hand_at("irb120", "puma560")
@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(MIDDLE))
def test_a_wrist_that_dips_across_zero_is_lifted_and_the_rest_stays_to_the_last_bit(name: str) -> None:
    q, found = mended(name)
    assert len(found.before.crossings) == 2
    best = found.best
    assert best is not None
    assert best.kind == "bump"
    again = rankdrop.check_path(open_robot(name), best.trajectory.q, best.trajectory.times)
    assert again.holds
    (change,) = best.changes
    rows = np.arange(1, len(q) + 1)
    outside = (rows <= change.start.position) | (rows >= change.end.position)
    np.testing.assert_array_equal(best.trajectory.q[outside], q[outside])
    np.testing.assert_array_equal(best.trajectory.times, found.before.curve.times)
    assert 0 < (~outside).sum() < 250
    assert np.degrees(np.abs(best.trajectory.q - q)[:, 4].max()) <= DIP
    off = tool_off(open_robot(name), q, best.trajectory.q)
    np.testing.assert_allclose(off, best.off, rtol=2e-2)
    assert np.degrees(off[1]) < DEPTH + 0.2 + 0.05  # joint 5 alone turns the tool by that


@pytest.mark.slow
def test_five_dips_are_mended_together() -> None:
    q, found = mended("irb120", rows=5000, dips=5)
    assert len(found.before.crossings) == 10
    best = found.best
    assert best is not None
    assert len(best.changes) == 5
    assert best.check.holds
    moved = (best.trajectory.q != q).any(axis=1)
    assert len(np.flatnonzero(np.diff(moved.astype(int)) == 1)) == 5
    assert moved.mean() < 0.25


@pytest.mark.slow
def test_fifty_thousand_rows_are_mended() -> None:
    q, found = mended("irb120", rows=50_000, dips=5)
    assert found.best is not None
    assert found.best.check.holds
    assert (found.best.trajectory.q != q).any(axis=1).mean() < 0.03


@pytest.mark.slow
def test_a_wrist_that_comes_too_near_is_kept_away_by_what_is_asked_for() -> None:
    q, t = dipping("ur5e", 1000, to=DEPTH)
    found = rankdrop.check_path(open_robot("ur5e"), q, t, min_distance=np.radians(2.0))
    assert found.verdict == "too near"
    best = mend_path(found, kinds=LOCAL).best
    assert best is not None
    assert (best.kind, best.check.margin) == ("bump", "kept")
    assert np.degrees(np.abs(best.trajectory.q - q).max()) < 2.0


@pytest.mark.slow
def test_limits_that_are_known_are_kept_by_longer_ramps() -> None:
    robot = open_robot("irb120")
    q, t = dipping("irb120", 1000)
    found = rankdrop.check_path(robot, q, t)
    speed = np.diff(q, axis=0) / 0.01
    own = np.abs(np.diff(speed, axis=0) / 0.01).max()
    quick, gentle = (mend_path(found, kinds=("bump",), acceleration=limit).best for limit in (None, 1.02 * own))
    assert quick is not None
    assert gentle is not None
    bend = np.abs(np.diff(np.diff(gentle.trajectory.q, axis=0), axis=0)).max() / 1e-4
    assert bend <= 1.02 * own * (1 + 1e-6)
    assert not gentle.retimed
    widths = [one.changes[0].end.position - one.changes[0].start.position for one in (quick, gentle)]
    assert widths[1] >= widths[0]


@pytest.mark.slow
def test_the_bound_that_would_do_is_named_and_does() -> None:
    q, t = dipping("ur5e", 1000)
    found = rankdrop.check_path(open_robot("ur5e"), q, t)
    tight = mend_path(found, kinds=("bump",), bump=np.radians(0.5))
    assert tight.best is None
    (note,) = tight.notes
    assert "no joint motion within bump=0.00873 avoids it; bump=" in note
    needed = float(note.split("; bump=")[1].split()[0])
    assert np.radians(DEPTH) < needed < np.radians(DEPTH + 0.5)
    assert mend_path(found, kinds=("bump",), bump=needed).best is not None


def at_times(path: Curve, time: Array) -> Array:
    """(N, n) configurations of a path in time."""
    assert path.times is not None
    return path.at(*path.split(np.interp(time, path.times, np.arange(len(path.times)))))


def densely(q: Array, parts: int) -> Array:
    """Configurations with so many places to each step."""
    place = np.linspace(0.0, len(q) - 1.0, parts * (len(q) - 1) + 1)
    return np.stack([np.interp(place, np.arange(len(q)), joint) for joint in q.T], axis=1)


def apart_by_place(old: Array, new: Array, scale: float) -> tuple[float, float]:
    """How far poses are from a path of poses at most [m], [rad], each from the nearest place of the path.

    Nearest is by lengths divided by `scale` and turns; between two poses of the path place and turn go straight.
    """
    flat = [np.concatenate([poses[:, :3, 3] / scale, poses[:, :3, :3].reshape(-1, 9) / np.sqrt(2.0)], axis=1)
            for poses in (old, new)]  # fmt: skip
    start, way = flat[0][:-1], np.diff(flat[0], axis=0)
    square, least = (way * way).sum(axis=1), []
    for at in flat[1]:  # all stretches: a path can come back along itself
        away = at - start
        away -= np.einsum("ij,ij->i", away, way).clip(0.0, square)[:, None] / square[:, None] * way
        least.append(away[np.einsum("ij,ij->i", away, away).argmin()])
    apart = np.array(least)
    return scale * float(np.linalg.norm(apart[:, :3], axis=1).max()), float(np.linalg.norm(apart[:, 3:], axis=1).max())


ELBOWS = {"iiwa7": (3, (0, 30, 20, 60, 20, 40, 0)), "ur5e": (2, (0, -80, 60, -60, 50, 0))}


@cache
def elbow_dips(name: str) -> tuple[Array, Array]:
    """A program whose elbow goes to −0.8° and comes back."""
    joint, middle = ELBOWS[name]
    t = np.arange(601) * 0.01
    slow = np.sin(np.pi * t / t[-1])[:, None] ** 2 * np.array([8, 6, 8, 0, 6, 4, 5])
    degrees = np.array(middle, dtype=np.float64) + slow[:, : len(middle)]
    degrees[:, joint] = 30.0 - (30.0 + 0.8) * smooth(1.5 - np.abs(t - 3.0))
    return np.radians(degrees), t


@pytest.mark.parametrize("name", ["iiwa7", pytest.param("ur5e", marks=pytest.mark.slow)])
def test_an_elbow_that_dips_is_kept_bent_and_the_tool_stays_where_it_is(name: str) -> None:
    robot, (q, t) = open_robot(name), elbow_dips(name)
    found = rankdrop.check_path(robot, q, t)
    assert len(found.crossings) == 2
    best = mend_path(found, kinds=LOCAL).best
    assert best is not None
    assert (best.kind, best.retimed) == ("bump", False)
    assert best.check.holds
    assert best.rank[2] == 0.0  # a bump alone: 5e-4 and more
    away, turned = tool_off(robot, q, best.trajectory.q)
    assert away < 1e-4 * found.length_scale
    assert turned < 1e-9
    moved = best.trajectory.q - q
    assert 0.8 < np.degrees(np.abs(moved).max()) < 4.0
    (change,) = best.changes
    rows = np.arange(1, len(q) + 1)
    outside = (rows <= change.start.position) | (rows >= change.end.position)
    np.testing.assert_array_equal(best.trajectory.q[outside], q[outside])
    assert (~outside).mean() < 0.35
    third = np.diff(moved, 3, axis=0)  # at the ends of the window a jump of the acceleration would be the largest
    ends = np.flatnonzero(np.diff(outside))
    near = np.concatenate([third[end - 3 : end + 2] for end in ends])
    assert np.abs(near).max() < 0.2 * np.abs(third).max()


@pytest.mark.slow
def test_an_elbow_kept_bent_keeps_the_limits_that_are_known() -> None:
    q, t = elbow_dips("iiwa7")
    found = rankdrop.check_path(open_robot("iiwa7"), q, t)

    def largest(limit: float | None) -> tuple[Remedy, float]:
        best = mend_path(found, kinds=("bump",), acceleration=limit).best
        assert best is not None
        return best, float(np.abs(np.diff(best.trajectory.q, 2, axis=0)).max() / 0.01**2)

    _, free = largest(None)
    kept, slower = largest(0.8 * free)
    assert not kept.retimed
    assert slower <= 0.8 * free


@pytest.mark.slow
def test_no_joint_of_an_elbow_kept_bent_moves_farther_than_is_allowed() -> None:
    q, t = elbow_dips("iiwa7")
    found = rankdrop.check_path(open_robot("iiwa7"), q, t)
    wide, narrow = (mend_path(found, kinds=("bump",), bump=np.radians(most)).best for most in (10.0, 1.5))
    assert wide is not None
    assert narrow is not None
    assert np.degrees(np.abs(wide.trajectory.q - q).max()) > 1.5
    assert np.degrees(np.abs(narrow.trajectory.q - q).max()) <= 1.5
    assert wide.rank < narrow.rank


def test_an_elbow_of_a_few_rows_is_kept_bent_and_what_is_printed_holds_between_them() -> None:
    robot, (q, t) = open_robot("iiwa7"), elbow_dips("iiwa7")
    q, t = q[::20], t[::20]
    best = mend_path(rankdrop.check_path(robot, q, t), kinds=("bump",)).best
    assert best is not None
    assert best.rank[2] == 0.0
    made = best.trajectory
    many = np.linspace(made.times[:-1], made.times[1:], 16, endpoint=False).ravel()
    old, new = curve(q, t), curve(made.q, made.times)
    off = tool_off(robot, at_times(old, many), at_times(new, many))
    np.testing.assert_allclose(off, best.off, rtol=0.02)


@pytest.mark.slow
def test_an_elbow_kept_bent_keeps_the_distance_that_is_asked_for() -> None:
    q, t = elbow_dips("iiwa7")
    found = rankdrop.check_path(open_robot("iiwa7"), q, t, min_distance=np.radians(2.0))
    best = mend_path(found, kinds=("bump",)).best
    assert best is not None
    assert best.check.margin == "kept"
    assert 1e-4 < best.rank[2] < 3e-4  # a bump alone: 1.6e-3


@pytest.mark.slow
def test_what_a_detour_in_a_new_time_prints_is_the_distance_from_the_old_tool_path() -> None:
    robot, (dips, t) = open_robot("iiwa7"), elbow_dips("iiwa7")
    low, q = int(dips[:, 3].argmin()), dips.copy()
    q[low:, 3] = 2 * q[low, 3] - q[low:, 3]  # stays on the other side
    found = rankdrop.check_path(robot, q, t)
    best = mend_path(found, kinds=("detour",), acceleration=5.0).best
    assert best is not None
    assert best.retimed
    old, new = (pose(robot, densely(rows, parts)) for rows, parts in ((q, 8), (best.trajectory.q, 1)))
    away, turned = apart_by_place(old, new, found.length_scale)
    assert away == pytest.approx(best.off[0], rel=0.02)
    assert 0.5 < turned / best.off[1] < 1.02  # the nearest place need not be the one with the least turn


@pytest.mark.slow
def test_a_path_that_stays_on_the_other_side_has_no_bump_and_says_why() -> None:
    q, t = crossing("irb120", 1000)
    found = mend_path(rankdrop.check_path(open_robot("irb120"), q, t), kinds=("bump",))
    assert found.remedies == ()
    assert "which every joint path there crosses" in found.notes[0]


@pytest.mark.by_hand
@pytest.mark.parametrize("name", ["irb120", "ur5e"])
def test_the_tool_is_led_around_what_the_joints_have_to_cross(name: str) -> None:
    robot = open_robot(name)
    q, _, best = led_around(name)
    assert best.kind == "detour"
    assert best.check.holds  # in a new time law
    (change,) = best.changes
    first, last = int(np.floor(change.start.position)), int(np.ceil(change.end.position))
    np.testing.assert_array_equal(best.trajectory.q[:first], q[:first])
    rest = len(q) - last
    np.testing.assert_allclose(pose(robot, best.trajectory.q[-rest:]), pose(robot, q[last:]), atol=1e-9)
    assert np.degrees(np.abs(change.at_end).max()) > 90.0
    sigma = singular_values(robot, best.trajectory.q, best.check.task)[:, -1]
    assert sigma.min() > 1e-4
    assert best.off[0] < 0.01
    assert np.degrees(best.off[1]) < 2.0
    dense = pose(robot, q)[:, :3, 3]
    new = pose(robot, best.trajectory.q[::7])[:, :3, 3]
    assert max(np.linalg.norm(dense - point, axis=1).min() for point in new) < best.off[0] + 2e-3


@pytest.mark.slow
def test_a_detour_of_two_rows_keeps_the_tool_between_them() -> None:
    """Rows are put in after the window: straight from its end to the last row the tool would leave its path far."""
    robot = open_robot("planar3r")
    q = np.array([[0.3, 0.4, 0.1], [1.5, -1.4, 0.3]])
    best = mend_path(rankdrop.check_path(robot, q), kinds=("detour",)).best
    assert best is not None
    assert best.check.clear
    assert best.off[0] < 1e-3
    old = pose(robot, np.linspace(q[0], q[1], 20_001))[:, :2, 3]
    new = pose(robot, (best.trajectory.q[1:] + best.trajectory.q[:-1]) / 2)[:, :2, 3]
    assert max(np.linalg.norm(old - point, axis=1).min() for point in new) < best.off[0] + 1e-4
    np.testing.assert_allclose(pose(robot, best.trajectory.q[-1]), pose(robot, q[-1]), atol=1e-9)
    assert np.abs(np.sin(best.trajectory.q[:, 1])).min() > 1e-3


@pytest.mark.slow
def test_a_detour_is_no_larger_than_its_clearance_needs() -> None:
    """UR5e: axis 4 is level, axis 6 turns with the tool, and joint 5 is the angle between both. At a small length scale
    the tip stays in its place and axis 4 with it, and the least detour is a turn by the clearance that is kept.
    """
    robot = open_robot("ur5e")
    q, t = crossing("ur5e", 400)
    task = resolve_task("pose", robot, length_scale=0.02)
    best = mend_path(rankdrop.check_path(robot, q, t, task=task), kinds=("detour",)).best
    assert best is not None
    assert best.off[0] < 1e-5
    assert best.off[1] == pytest.approx(0.9 * CLEARANCE, rel=0.05)


@pytest.mark.slow
def test_a_detour_says_which_joint_turns_how_far() -> None:
    _, _, best = led_around("irb120")
    assert best.off[1] < 1e-4  # the tool moves aside, which is the smaller change here, and does not turn
    turned = {turn.joint: np.degrees(abs(turn.angle)) for turn in best.turns}
    assert turned[4] == pytest.approx(180.0, abs=8.0)
    assert "joint 4 turns 1" in str(mend_text(best))


def mend_text(best: Remedy) -> str:
    """The remedy as it is printed."""
    return str(Mending(best.check, (best,), (), True, True))


def test_a_path_that_touches_the_edge_of_reach_stays_inside() -> None:
    robot = open_robot("planar2r")
    q = np.array([[0.0, 0.5], [0.4, 0.0], [0.8, 0.5]])
    best = mend_path(rankdrop.check_path(robot, q), kinds=("bump",)).best
    assert best is not None
    assert best.kind == "bump"
    np.testing.assert_array_equal(best.trajectory.q[[0, -1]], q[[0, -1]])
    assert np.abs(np.sin(best.trajectory.q[:, 1])).min() > 1e-3
    assert best.off[0] < 2e-5
    assert np.isnan(best.off[1])  # its task leaves the orientation free


def touch_and_crossing() -> Array:
    """(4, 6) rows of an IRB 120 on which joint 5 touches 0° and crosses it."""
    home = np.array([0.2, 0.3, -0.2, 0.7, 0.0, 0.4])
    step = np.array([0.4, 0.1, 0.0, 0.5, 0.0, 0.0])
    q = home + step * np.arange(4.0)[:, None]
    q[:, 4] = (0.5, 0.0, 0.5, -0.5)
    return q


def test_where_a_bump_takes_the_tool_off_its_path_it_is_led_around_as_well() -> None:
    """One touch and one crossing: a bump would do for the touch, and leaves the path by more."""
    q, robot = touch_and_crossing(), open_robot("irb120")
    best = mend_path(rankdrop.check_path(robot, q), kinds=("detour",)).best
    assert best is not None
    assert (best.how, len(best.changes)) == (("detour", 2), 2)
    bump = mend_path(rankdrop.check_path(robot, q[:3]), kinds=("bump",)).best
    assert bump is not None
    assert best.deviation[0] < 0.8 * bump.deviation[0]


def test_a_bump_that_keeps_the_tool_on_its_path_stands_beside_a_detour() -> None:
    """What the task leaves free is no deviation: the arm has two joints, and its task no orientation."""
    q = np.array([[0.0, 0.5], [0.4, 0.0], [0.8, 0.5], [1.2, -0.5]])
    best = mend_path(rankdrop.check_path(open_robot("planar2r"), q), kinds=("detour",)).best
    assert best is not None
    assert (best.how, len(best.changes)) == (("detour", 1), 2)
    assert best.deviation[0] < 2e-5


@pytest.mark.slow
def test_remedies_are_ranked_by_how_far_the_tool_leaves_its_path() -> None:
    """A wrist that dips: a detour leaves it by a millimetre in a new time, a bump of joint 5 by more in the same."""
    q, t = dipping("irb120", 1000)
    detour, bump = mend_path(rankdrop.check_path(open_robot("irb120"), q, t), kinds=LOCAL).remedies
    assert (detour.kind, detour.retimed, bump.kind, bump.retimed) == ("detour", True, "bump", False)
    assert detour.deviation[0] < 0.2 * bump.deviation[0]
    np.testing.assert_array_equal(bump.trajectory.times, t)
    assert detour.trajectory.times[-1] > t[-1]


@pytest.mark.parametrize(("bumps", "far", "failed", "unfree", "chosen"), [
    (1, 0, 1, (1, 1), 0), (1, 0, 1, (2, 1), 1), (1, 0, 1, (2, 2), 1), (1, 0, 2, (2, 2), 0),
    (0, 0, 1, (1, 1), None), (1, 0, 0, (1, 1), None),
    (1, 1, 0, (1, 1), 0), (1, 1, 1, (2, 2), 0), (0, 2, 0, (1, 1), None),
])  # fmt: skip
def test_bumps_before_detours_leave_no_singularity_but_those_without_a_bump(
    bumps: int, far: int, failed: int, unfree: tuple[int, int], chosen: int | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Of two proposals, which leave so many stretches that are not free, the first that does; else the last. A bump
    that is left out counts as none.
    """
    checks = [SimpleNamespace(stretches=[SimpleNamespace(verdict="crossing")] * count) for count in unfree]
    proposals = [SimpleNamespace(trajectory=check, number=k) for k, check in enumerate(checks)]
    core = SimpleNamespace(stretches=(None,))
    put_in: list[object] = []
    monkeypatch.setattr(
        local_remedies, "bump_proposals", lambda bumper, near, room: put_in.extend(near) or iter(proposals)
    )
    near_bumps = [SimpleNamespace(core=core, off=0.02)] * bumps
    far_bumps = [SimpleNamespace(core=core, off=0.04)] * far
    every = local_remedies.FoundBumps(near_bumps + far_bumps, [SimpleNamespace(core=core)] * failed)
    mender = SimpleNamespace(
        clearance=CLEARANCE, verifier=SimpleNamespace(check_changed=lambda changed: changed)
    )  # fmt: skip
    found = local_remedies.LocalMender.bumps_before_detours(mender, SimpleNamespace(), near_bumps, every)
    assert found == (None if chosen is None else (proposals[chosen], checks[chosen]))
    assert put_in == ([] if chosen is None else near_bumps)


@pytest.mark.slow
def test_where_a_bump_takes_the_tool_far_off_a_detour_goes_first() -> None:
    """An elbow that is folded 9° beyond its edge of reach, and comes back: on its side the tool would be far off."""
    t = np.linspace(0.0, 3.0, 120)
    q = np.radians([-137.0, -86.0, 60.0, 200.0, 139.0, 119.0, 153.0]) + 0.1 * t[:, None]
    q[:, 3] = np.radians(188.0 - 17.0 * np.sin(np.pi * t / 3.0))
    found = mend_path(rankdrop.check_path(open_robot("pa10"), q, t), kinds=LOCAL)
    first, second = found.remedies
    assert (first.kind, second.kind, first.check.verdict, second.check.verdict) == ("detour", "bump", "free", "free")
    assert first.deviation[0] < 1e-3 < 0.03 < second.deviation[0]
    np.testing.assert_array_equal(first.trajectory.q[0], q[0])
    np.testing.assert_array_equal(second.trajectory.q[[0, -1]], q[[0, -1]])


@pytest.mark.by_hand_at("cubic")
@pytest.mark.slow
@pytest.mark.parametrize("how", ["cubic", "quintic"])
def test_smooth_paths_get_smooth_bumps(how: str) -> None:
    q, t = dipping("irb120", 1000)
    v = np.gradient(q, t, axis=0)
    a = np.gradient(v, t, axis=0)
    found = rankdrop.check_path(open_robot("irb120"), q, t, velocities=v, accelerations=a, interpolate=how)
    best = mend_path(found, kinds=LOCAL).best
    assert best is not None
    assert best.check.holds
    made = best.trajectory
    assert made.velocities is not None
    np.testing.assert_allclose(made.velocities, np.gradient(made.q, made.times, axis=0), atol=2e-3)
    assert (made.accelerations is None) == (how == "cubic")


@pytest.mark.by_hand
def test_remedies_come_in_the_order_of_how_far_the_tool_leaves_its_path() -> None:
    q, t = dipping("ur5e", 300)
    found = mend_path(rankdrop.check_path(open_robot("ur5e"), q, t), kinds=("bump", "tool tilt"), tool_tilt=0.2)
    assert found.remedies
    ranks = [one.rank for one in found.remedies]
    assert ranks == sorted(ranks)
    assert found.best is found.remedies[0]


@pytest.mark.slow
def test_the_command_names_the_best_remedy_and_the_option_writes_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    q, _ = mended("irb120")
    file, out = tmp_path / "program.npy", tmp_path / "mended.npz"
    np.save(file, np.column_stack([np.arange(len(q)) * 0.01, q]))
    assert main.run(["path", "irb120", str(file), "--quiet"]) == 3
    said = capsys.readouterr().out
    assert "Remedy: the tool led around it" in said
    assert "--remedy detour --fixed FILE writes it" in said
    assert "Or in the same time: joint 5 by 1.5°" in said
    assert "--remedy bump --fixed FILE writes it" in said
    assert main.run(["path", "irb120", str(file), "--quiet", "--remedy", "bump", "--fixed", str(out)]) == 3
    assert main.run(["path", "irb120", str(out), "--quiet"]) == 0
    made = read_trajectory(out, open_robot("irb120")).q
    assert (made == q).all(axis=1).mean() > 0.5


@pytest.mark.slow
def test_without_a_remedy_the_command_names_the_bound(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    file = tmp_path / "program.npy"
    np.save(file, mended("irb120")[0])
    assert main.run(["path", "irb120", str(file), "--quiet", "--bump", "0.5deg", "--detour", "0"]) == 3
    said = capsys.readouterr().out
    assert "No local remedy. Bump: " in said
    assert "--bump 0.5deg avoids it; --bump 1.6deg does" in said


def test_detours_beside_bumps_are_told_in_rows_of_the_file() -> None:
    """One row a second: where a bump before a detour has many rows of its own, rows and times agree all the same."""
    q, t = np.array([[0.0, 0.5], [0.4, 0.0], [0.8, 0.5], [1.2, -0.5]]), np.arange(4.0)
    remedy = mend_path(rankdrop.check_path(open_robot("planar2r"), q, t), kinds=("detour",)).best
    assert remedy is not None
    assert len(remedy.changes) == 2
    for change in remedy.changes:
        assert change.start.position == pytest.approx(1.0 + change.start.time, abs=1e-9)
        assert change.end.position == pytest.approx(1.0 + change.end.time, abs=1e-9)
