"""Remedies: proven free by a new judgement, on the tool path that they promise, inside limits and bounds."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import rankdrop
from rankdrop import path as paths
from rankdrop.errors import OptionError
from rankdrop.kinematics import pose
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.path.mend import verifier
from rankdrop.path.mend.mend import mend_path
from rankdrop.path.mend.record import KINDS, LOCAL, Mending
from rankdrop.path.read.files import WRITTEN, read_trajectory, trajectory_bytes
from rankdrop.robot.open import open_robot
from rankdrop.task import Frame, Task
from rankdrop.units import scale_lengths

WRIST = np.linspace([0.0, 0.7, -0.2, 0.3, 0.4, 0.1], [0.2, 0.8, -0.1, 0.2, -0.4, 0.3], 41)  # puma560, through θ5 = 0
CORNER = np.array([[0.3, 0.4, 0.1], [0.5, -0.2, 0.3], [0.9, 0.5, 0.3]])  # planar3r, through θ2 = 0 and back
INNER = np.linspace([0.3, 0.4, np.pi - 0.5], [0.6, -0.4, np.pi + 0.5], 41)  # planar3r in position: θ2 = 0, θ3 = π
TILT, SHIFT = np.radians(10), 0.05
WHOLE = tuple(kind for kind in KINDS if kind not in LOCAL)  # local ones have their tests in `test_local_remedies`


@cache
def wrist(kinds: tuple[str, ...] = ("flip", "retime")) -> Mending:
    """What the PUMA has for a wrist crossing: in a second, or of all kinds."""
    found = rankdrop.check_path(open_robot("puma560"), WRIST, np.linspace(0.0, 3.0, 41))
    assert found.verdict == "crossing"
    return mend_path(found, kinds=kinds, tool_tilt=TILT, base_shift=SHIFT, acceleration=6.0)


@cache
def inner() -> Mending:
    """Null-space motion past an inner singularity."""
    robot = open_robot("planar3r")
    found = rankdrop.check_path(robot, INNER, np.linspace(0.0, 3.0, 41), task="planar-position")
    assert found.verdict != "free"
    return mend_path(found, kinds=WHOLE)


def at_old_rows(one, old_rows: np.ndarray) -> np.ndarray:
    """Configurations of a mended path where the tool path's own rows are, whatever the new time law."""
    tool = pose(one.check.robot, one.trajectory.q)
    return np.array([np.abs(tool - wanted).max(axis=(1, 2)).argmin() for wanted in old_rows])


def test_it_is_a_public_name() -> None:
    assert paths.mend_path is mend_path


@pytest.mark.by_hand
def test_every_remedy_is_proven_free_and_gains_distance() -> None:
    every = wrist(WHOLE)
    assert [one.kind for one in every.remedies] == ["flip", "tool tilt", "base shift", "retime"]
    for one in every.remedies[:3]:
        assert one.check.holds
        before, after = one.gains["distance"]
        assert before == 0.0
        assert after > 0.03
        made = one.trajectory
        again = rankdrop.check_path(open_robot("puma560"), made.q, made.times)
        assert again.verdict == "free"
    assert every.best is every.remedies[0]


@pytest.mark.slow
def test_a_flip_keeps_the_tool_path_and_is_another_branch() -> None:
    robot, one = open_robot("puma560"), wrist().remedies[0]
    wanted = pose(robot, WRIST)
    rows = at_old_rows(one, wanted)
    assert np.abs(pose(robot, one.trajectory.q[rows]) - wanted).max() < 1e-9
    assert (np.diff(rows) > 0).all()
    gap = one.trajectory.q[0] - WRIST[0]
    assert np.linalg.norm(gap - 2 * np.pi * np.round(gap / (2 * np.pi))) > 0.5
    middle = (one.trajectory.q[1:] + one.trajectory.q[:-1]) / 2  # between rows: near some point of the old tool path
    dense = pose(robot, np.linspace(WRIST[0], WRIST[-1], 20_001))[:, :3, 3]
    apart = [np.linalg.norm(dense - point, axis=1).min() for point in pose(robot, middle)[::20, :3, 3]]
    assert max(apart) < one.off[0] + 1e-5


@pytest.mark.by_hand
def test_a_tilt_turns_the_tool_about_its_tip_by_no_more_than_the_bound() -> None:
    robot, one = open_robot("puma560"), wrist(WHOLE).remedies[1]
    angle, axis = one.parameters[0][1], np.array(one.parameters[1][1])
    assert 0.0 < angle <= TILT
    assert axis[2] == 0.0
    wanted = pose(robot, WRIST)
    turn = np.eye(4)
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn[:3, :3] += np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    rows = at_old_rows(one, wanted @ turn)
    found = pose(robot, one.trajectory.q[rows])
    np.testing.assert_allclose(found, wanted @ turn, atol=1e-9)
    np.testing.assert_allclose(found[:, :3, 3], wanted[:, :3, 3], atol=1e-9)
    between = orientation_coordinates(wanted[:, :3, :3].swapaxes(1, 2) @ found[:, :3, :3], "rotvec")
    np.testing.assert_allclose(np.linalg.norm(between, axis=1), angle, atol=1e-9)


@pytest.mark.by_hand
def test_a_shift_moves_the_base_by_no_more_than_the_bound() -> None:
    robot, one = open_robot("puma560"), wrist(WHOLE).remedies[2]
    shift = np.array(one.parameters[0][1])
    assert 0.0 < np.linalg.norm(shift) <= SHIFT * (1 + 1e-12)
    wanted = pose(robot, WRIST)
    moved = np.eye(4)
    moved[:3, 3] = shift  # the tool in the old base frame: the moved base, then the arm
    rows = at_old_rows(one, np.linalg.inv(moved) @ wanted)
    np.testing.assert_allclose(moved @ pose(robot, one.trajectory.q[rows]), wanted, atol=1e-9)


@pytest.mark.by_hand
def test_null_space_motion_keeps_the_tool_and_the_joints_move_otherwise() -> None:
    robot, mended = open_robot("planar3r"), inner()
    one = mended.remedies[0]
    assert (one.kind, one.check.holds) == ("null-space", True)
    wanted = pose(robot, INNER)[:, :2, 3]
    tool = pose(robot, one.trajectory.q)[:, :2, 3]
    assert max(np.linalg.norm(tool - point, axis=1).min() for point in wanted) < 1e-9
    assert one.gains["distance"][1] > 0.1
    np.testing.assert_allclose(one.trajectory.times[[0, -1]], [0.0, 3.0])


@pytest.mark.by_hand
def test_a_corner_is_cut_within_the_bound_and_the_rest_stays() -> None:
    robot = open_robot("planar3r")
    found = rankdrop.check_path(robot, CORNER, [0.0, 1.0, 2.0])
    mended = mend_path(found, kinds=WHOLE, blend=0.01)
    (one,) = mended.remedies
    assert (one.kind, one.check.verdict) == ("blend", "free")
    legs = [np.linspace(*CORNER[k : k + 2], 4001) for k in (0, 1)]
    dense = pose(robot, np.concatenate(legs))
    off = [np.linalg.norm(dense[:, :2, 3] - point, axis=1).min() for point in pose(robot, one.trajectory.q)[:, :2, 3]]
    assert 0.0 < max(off) < one.off[0] + 1e-4
    assert one.off[0] <= 0.01
    np.testing.assert_array_equal(one.trajectory.q[[0, -1]], CORNER[[0, -1]])
    assert mend_path(found, kinds=WHOLE, blend=1e-4).remedies == ()


@pytest.mark.slow
def test_limits_are_kept_by_every_remedy_in_time() -> None:
    for one in wrist().remedies:
        assert one.usage is not None
        assert one.usage.slower <= 1.0 + 1e-9
        speed = np.diff(one.trajectory.q, axis=0) / np.diff(one.trajectory.times)[:, None]
        middle = (one.trajectory.times[1:] + one.trajectory.times[:-1]) / 2
        assert np.abs(np.diff(speed, axis=0) / np.diff(middle)[:, None]).max() <= 6.0 * (1 + 1e-7)


@pytest.mark.slow
def test_retime_keeps_the_path_and_says_that_it_still_crosses() -> None:
    one = wrist().remedies[-1]
    assert one.check.verdict == "crossing"
    assert "still meets a singularity" in wrist().sentence
    near = [np.abs(one.trajectory.q - row).max(axis=1).min() for row in WRIST]
    assert max(near) < 1e-12
    line = (one.trajectory.q - WRIST[0]) @ (WRIST[-1] - WRIST[0]) / np.linalg.norm(WRIST[-1] - WRIST[0]) ** 2
    np.testing.assert_allclose(one.trajectory.q, WRIST[0] + line[:, None] * (WRIST[-1] - WRIST[0]), atol=1e-12)


@pytest.mark.slow
def test_a_mended_path_needs_no_remedy() -> None:
    robot = open_robot("puma560")
    for one in wrist().remedies[:1]:
        again = mend_path(rankdrop.check_path(robot, one.trajectory.q, one.trajectory.times), acceleration=6.0)
        assert not again.needed
        assert again.remedies == ()
    assert "none is needed" in again.sentence


@pytest.mark.slow
def test_a_free_path_that_is_too_fast_is_slowed_down_and_nothing_else() -> None:
    robot = open_robot("ur5e")
    q = np.linspace([0.0, -1.2, 1.2, 0.3, 0.9, 0.1], [1.0, -1.0, 1.4, 0.1, 1.3, 0.5], 30)
    mended = mend_path(rankdrop.check_path(robot, q, np.linspace(0, 0.2, 30)))
    (one,) = mended.remedies
    assert (one.kind, one.check.holds) == ("slow-down", True)
    assert one.gains["speed"] == (pytest.approx(robot.variables[0].velocity / 5.0), pytest.approx(1.0))


@pytest.mark.by_hand
def test_a_distance_that_is_asked_for_is_kept_by_the_remedy() -> None:
    robot = open_robot("ur5e")
    q = np.linspace([0.0, -1.2, 1.2, 0.3, 0.4, 0.1], [0.2, -1.1, 1.3, 0.2, 0.06, 0.3], 21)
    found = rankdrop.check_path(robot, q, min_distance=0.1)
    assert found.verdict == "too near"
    mended = mend_path(found, kinds=WHOLE, tool_tilt=TILT)
    assert mended.needed
    assert mended.remedies
    assert all(one.check.margin == "kept" for one in mended.remedies)


def test_a_path_to_the_edge_of_the_workspace_has_none_and_it_says_so() -> None:
    robot = open_robot("planar2r")
    found = rankdrop.check_path(robot, [[0.0, 0.5], [0.4, 0.0], [0.8, 0.5]])
    mended = mend_path(found, bump=0.0, detour=0.0)
    assert mended.needed
    assert mended.remedies == ()
    assert mended.best is None
    assert "no proof that there is none" in mended.sentence
    assert any(note.startswith("flip: 1 tried") for note in mended.notes)


@pytest.mark.by_hand
@pytest.mark.slow_at("quintic", "cubic")
@pytest.mark.parametrize("how", ["cubic", "quintic"])
def test_cubics_and_quintics_are_mended_as_such(how: str) -> None:
    robot, t = open_robot("puma560"), np.linspace(0.0, 3.0, 41)
    smooth = lambda x: 6 * x**5 - 15 * x**4 + 10 * x**3  # noqa: E731
    s = t / 3.0
    way = WRIST[-1] - WRIST[0]
    q, v = WRIST[0] + smooth(s)[:, None] * way, (30 * s**4 - 60 * s**3 + 30 * s**2)[:, None] * way / 3
    a = (120 * s**3 - 180 * s**2 + 60 * s)[:, None] * way / 9
    found = rankdrop.check_path(robot, q, t, velocities=v, accelerations=a, interpolate=how)
    assert found.verdict == "crossing"
    one = mend_path(found, kinds=WHOLE).remedies[0]
    assert (one.kind, one.interpolate, one.check.options.interpolate) == ("flip", how, how)
    assert one.trajectory.velocities is not None
    assert (one.trajectory.accelerations is None) == (how == "cubic")
    assert one.off[0] < 1e-5


@pytest.mark.slow
def test_what_is_not_proven_free_is_no_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    found = wrist().before
    monkeypatch.setattr(verifier, "check_path", lambda *args, **kwargs: found)
    mended = mend_path(found, kinds=WHOLE)
    assert mended.remedies == ()
    assert any(note.startswith("flip") and "none was proven free" in note for note in mended.notes)


@pytest.mark.slow
def test_a_task_that_no_pose_tells_is_said_to_have_no_tool_path() -> None:
    task = Task("part", (0, 1), Frame(1, -1))  # rows in axes that turn
    found = rankdrop.check_path(open_robot("planar2r"), [[0.0, 0.5], [0.4, -0.1], [0.8, 0.5]], task=task)
    assert found.verdict == "crossing"
    mended = mend_path(found, kinds=WHOLE, blend=0.5, tool_tilt=TILT)
    assert [one.kind for one in mended.remedies] == ["blend"]
    assert "cannot be followed: the pose of the tip does not determine" in mended.notes[0]


@pytest.mark.slow
def test_interrupted_it_keeps_what_is_done() -> None:
    told: list[tuple[str, int, int]] = []

    def stop(kind: str, done: int, total: int) -> None:
        told.append((kind, done, total))
        if kind == "tool tilt":
            raise KeyboardInterrupt

    mended = mend_path(wrist().before, kinds=WHOLE, tool_tilt=TILT, base_shift=SHIFT, progress=stop)
    assert [one.kind for one in mended.remedies] == ["flip"]
    assert not mended.complete
    assert "interrupted" in mended.sentence
    assert {kind for kind, _, _ in told} == {"flip", "tool tilt"}


@pytest.mark.slow_at(".csv")
@pytest.mark.parametrize("ending", WRITTEN)
def test_a_file_is_read_back_to_the_last_bit(tmp_path, ending: str) -> None:
    robot, made = open_robot("puma560"), wrist().remedies[0].trajectory
    if ending != ".csv":
        made = replace(made, velocities=made.q * 0.1, accelerations=made.q * 0.3)
    file = tmp_path / f"made{ending}"
    file.write_bytes(trajectory_bytes(made, robot, str(file)))
    read = read_trajectory(file, robot)
    np.testing.assert_array_equal(read.q, made.q)
    np.testing.assert_array_equal(read.times, made.times)
    for one, two in ((read.velocities, made.velocities), (read.accelerations, made.accelerations)):
        assert (one is None) == (two is None)
        assert one is None or np.array_equal(one, two)
    untimed = replace(made, timed=False, velocities=None, accelerations=None)
    file.write_bytes(trajectory_bytes(untimed, robot, str(file)))
    again = read_trajectory(file, robot, deg=ending == ".csv")  # the unit stands in a CSV file
    assert not again.timed
    np.testing.assert_array_equal(again.q, made.q)
    with pytest.raises(OptionError, match="holds no velocities"):
        trajectory_bytes(replace(made, velocities=made.q), robot, "a.csv")
    with pytest.raises(OptionError, match="names no format"):
        trajectory_bytes(made, robot, "a.xls")


@pytest.mark.by_hand
def test_an_arm_in_millimetres_is_mended_alike() -> None:
    robot = open_robot("planar3r")
    other = scale_lengths(robot, 3)
    mended = [
        mend_path(rankdrop.check_path(arm, CORNER), kinds=WHOLE, base_shift=size * 0.05, blend=size * 0.01)
        for arm, size in ((robot, 1.0), (other, 1000.0))
    ]
    one, two = (part.remedies for part in mended)
    told = [[line for line in str(part).splitlines() if "the tool is within" in line] for part in mended]
    assert told[0] == told[1] != []
    assert [part.kind for part in one] == [part.kind for part in two] == ["blend", "base shift"]
    for a, b in zip(one, two, strict=True):
        assert b.gains["distance"][1] == pytest.approx(a.gains["distance"][1], abs=1e-6)
        np.testing.assert_allclose(a.trajectory.q[-1], b.trajectory.q[-1], atol=1e-6)


BAD = {
    "tool_tilt": {"tool_tilt": -0.1}, "base_shift": {"base_shift": np.inf}, "blend": {"blend": "5mm"},
    "acceleration": {"acceleration": 0.0}, "one for each joint": {"acceleration": [1.0, 2.0]},
}  # fmt: skip


@pytest.mark.parametrize("said", BAD)
def test_bounds_out_of_range_are_refused(said: str) -> None:
    found = rankdrop.check_path(open_robot("planar3r"), CORNER)
    with pytest.raises(OptionError) as error:
        mend_path(found, **BAD[said])
    assert said in str(error.value)


def test_the_next_step_knows_which_remedies_were_found() -> None:
    """A remedy that is known is the next step; only without one is a search, or wider bounds."""
    arm = open_robot("planar3r")
    crossing = rankdrop.check_path(arm, CORNER)
    blend, none = mend_path(crossing, kinds=["blend"], blend=0.5), mend_path(crossing, kinds=["blend"])
    assert (len(blend.remedies), len(none.remedies)) == (1, 0)

    def step(mending: Mending | None, *, listed: bool = False, target: str | None = None) -> str:
        first = crossing.sections(mending=mending, listed=listed, target=target)[0]
        assert ("Remedy: " in " ".join(first.lines)) is (mending is blend and not listed)
        return next(line for line in first.lines if line.startswith("Next: "))

    assert step(blend, listed=True, target="out.csv") == "Next: run out.csv, the path mended by blend: free (proven)."
    assert step(blend, listed=True).endswith(" writes the path mended by blend: free (proven).")
    assert "for a tool move take the remedy below" in step(blend)
    assert "no remedy was found" in step(none, listed=True, target="out.csv")
    for mending in (none, None):
        assert "mend_path computes changes for a tool move" in step(mending)
