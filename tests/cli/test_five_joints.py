"""Arms of five joints are asked about position and tool axis, and what they can never do is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from printed import one_line

from rankdrop.distance.monitor import Monitor, arm_header
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import jacobian, pose
from rankdrop.local.pointing import asked_task, level_task, pointing_task, tool_stays_level, turn_follows
from rankdrop.path.check.check import check_path
from rankdrop.path.check.tool_path import check_poses
from rankdrop.poses.branches import inverse
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.robot.transform import nearest_rotation, rotation
from rankdrop.task import BODY, resolve_task, task_names
from rankdrop.verbs.explain import explain

REPORT = Path(__file__).parents[1] / "data" / "reports"
KUKA, ACROSS = str(REPORT / "05-kr120-without-a6.toml"), str(REPORT / "05-five-joints.csv")
NEVER = "can never turn about its tool axis"


def test_a_wrist_of_five_joints_is_singular_at_zero(run) -> None:
    """The determinant of position and tool axis is proportional to sin θ5."""
    arm = open_robot(KUKA)
    q = np.radians([[0, -60, 90, 0, angle] for angle in (10, 20, -10)])
    by_hand = np.linalg.det(jacobian(arm, q, BODY)[:, :5])
    assert by_hand / by_hand[0] == pytest.approx(np.sin(q[:, 4]) / np.sin(q[0, 4]), rel=1e-9)
    done = run("explain", KUKA, "--deg", "--q", "0,-60,90,0,0")
    assert (done.code, NEVER in one_line(done.out)) == (4, True)
    assert "is singular" in done.out.splitlines()[0]
    assert explain(arm, np.radians([0, -60, 90, 0, 0]), evaluations=0).verdict == "singular"


def test_the_pose_alone_says_what_it_leaves_out(run) -> None:
    done = run("explain", KUKA, "--deg", "--q", "0,-60,90,0,0", "--task", "pose")
    text = one_line(done.out)
    assert (done.code, NEVER in text) == (0, True)
    assert "(--task tool-axis-free) it is singular here, rank 4 of 5" in text
    assert "no direction of the tool is lost" not in text


@pytest.mark.slow
def test_a_path_across_the_wrist_is_not_free(run) -> None:
    done = run("path", KUKA, ACROSS)
    assert (done.code, NEVER in one_line(done.out)) == (3, True)
    assert "Crosses a singularity once (proven)" in one_line(done.out)
    rows = [[0, -1, 1.5, 0.2, -0.5], [0.2, -1, 1.5, 0.3, 0.5]]
    assert check_path(open_robot(KUKA), rows, task="pose").verdict == "free"


@pytest.mark.slow
def test_poses_are_reached_as_poses_and_checked_as_position_and_axis() -> None:
    arm = open_robot("px150")
    ends = pose(arm, [[0.1, -0.3, 0.5, 0.2, 0.3], [0.1, -0.2, 0.6, 0.2, 0.3]])
    found = check_poses(arm, ends, start=[0.1, -0.3, 0.5, 0.2, 0.3])
    assert (found.verdict, found.task.name) == ("free", "tool-axis-free")
    turned = ends.copy()
    turned[1, :3, :3] = turned[1, :3, :3] @ [[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]]
    assert not check_poses(arm, turned, start=[0.1, -0.3, 0.5, 0.2, 0.3]).tool.complete
    free = check_poses(arm, turned, start=[0.1, -0.3, 0.5, 0.2, 0.3], task="tool-axis-free")
    assert (free.tool.complete, free.verdict) == (True, "free")


ROUNDED = {
    "px150": np.array([[0.1, -0.3, 0.5, 0.2, 0.3], [0.1, -0.2, 0.6, 0.2, 0.3]]),
    KUKA: np.radians([[10, -60, 90, 0, 20], [10, -50, 80, 0, 25]]),
}


def rounded_poses(name: str, digits: int) -> np.ndarray:
    """Poses of the arm as another program prints them: so many digits, made orthonormal again."""
    made = np.round(pose(open_robot(name), ROUNDED[name]), digits)
    made[:, :3, :3] = [nearest_rotation(nearest_rotation(turn)) for turn in made[:, :3, :3]]
    return made


@pytest.mark.slow
@pytest.mark.parametrize("name", ROUNDED, ids=["px150", "kuka"])
@pytest.mark.parametrize("digits", [6, 9])
def test_rounded_poses_are_reached_and_the_miss_is_printed(name: str, digits: int) -> None:
    """No pose of six digits is exactly one of five joints; such poses were refused."""
    arm, poses = open_robot(name), rounded_poses(name, digits)
    found = inverse(arm, poses[0])
    assert found.missed is not None
    nearest = min(found.branches, key=lambda branch: np.abs(branch.q - ROUNDED[name][0]).max())
    np.testing.assert_allclose(nearest.q, ROUNDED[name][0], atol=10.0 ** (1 - digits))
    assert found.missed[0] < 10.0**-digits
    assert found.missed[1] < 2 * 10.0**-digits
    said = one_line("\n".join(str(section) for section in found.sections()))
    assert "5 joints take the nearest pose in reach: the tool misses the pose by up to " in said
    assert "(at most 0.05 mm and 0.0029°, for rounded poses)" in said
    check = check_poses(arm, poses, start=ROUNDED[name][0], branches=False)
    assert (check.verdict, check.tool.complete) == ("free", True)
    assert check.tool.off <= 1e-4
    assert "5 joints take the nearest pose in reach: the tool misses the pose by up to" in one_line(str(check))
    assert check_poses(arm, poses).verdict == "free"


@pytest.mark.slow
def test_exact_poses_are_reached_without_a_word_of_a_miss() -> None:
    arm = open_robot("px150")
    poses = pose(arm, ROUNDED["px150"])
    assert inverse(arm, poses[0]).missed is None
    assert "nearest pose in reach" not in one_line(str(check_poses(arm, poses)))


@pytest.mark.slow
def test_a_pose_farther_off_than_rounding_is_answered_with_the_task_to_ask_for() -> None:
    arm, there = open_robot("px150"), [0.1, -0.3, 0.5, 0.2, 0.3]
    turned = pose(arm, there)
    turned[:3, :3] = turned[:3, :3] @ rotation("z", 1e-3)[:3, :3]
    with pytest.raises(ConfigurationError, match=r"5 joints cannot take pose 1 in full.*'tool-axis-free' leaves free"):
        check_poses(arm, [turned, turned])
    found = inverse(arm, turned, starts=64)
    assert found.unreached is not None
    assert "tool-axis-free leaves free what they cannot do" in one_line(found.sentence).replace("'", "")
    other = inverse(arm, turned, "tool-axis-free", starts=64)
    assert min(np.abs(one.q - np.array(there)).max() for one in other.branches) < 1e-5


@pytest.mark.slow
def test_a_palletiser_is_asked_about_position_and_yaw() -> None:
    """Joints that follow shoulder and elbow hold the tool level; by hand x = r cos q1, r = a + l2 s2 + l3 c23."""
    arm = open_robot(str(REPORT / "palletiser.urdf"))
    there = np.array([0.3, 0.3, 0.4, 0.2])
    assert (level_task(arm, resolve_task("pose", arm)).name, arm.n) == ("scara", 4)
    found = explain(arm, there, evaluations=0)
    assert (found.task.name, found.verdict) == ("scara", "regular")
    assert found.summary.slowest is not None
    q1, q2, q3, _ = there
    radius = 0.56 + 1.28 * np.sin(q2) + 1.35 * np.cos(q2 + q3)
    place = [radius * np.cos(q1), radius * np.sin(q1), 0.61 + 1.28 * np.cos(q2) - 1.35 * np.sin(q2 + q3)]
    assert pose(arm, there)[:3, 3] == pytest.approx(place, abs=1e-12)
    stretched = explain(arm, [0.3, 0.3, np.pi / 2, 0.2], evaluations=0)
    assert (stretched.verdict, stretched.rank.rank) == ("singular", 3)
    ends = pose(arm, [there, there + 0.1])
    ends[:, :3, 3] = np.round(ends[:, :3, 3], 4)
    ends[:, :3, :3] = [rounded_turn(one) for one in ends[:, :3, :3]]
    check = check_poses(arm, ends)
    assert (check.verdict, check.task.name) == ("free", "scara")
    assert "This arm never tilts its tool." in one_line(str(check))
    tilted = ends.copy()
    tilted[1, :3, :3] = ends[1, :3, :3] @ rotation("y", np.radians(10.0))[:3, :3]
    with pytest.raises(ConfigurationError, match=r"pose 2 is tilted; got 10° off; .*give it the tilt of the tool"):
        check_poses(arm, tilted)
    found = inverse(arm, tilted[1])
    assert (found.unreached.kind, found.branches) == ("tilt", ())
    assert found.unreached.turn == pytest.approx(np.radians(10.0), abs=1e-3)


def test_a_pose_tilted_for_a_scara_is_told_so() -> None:
    """Position and yaw are its own task; a tilted pose was out of reach by 5e-14 mm, and one of 0° not reached."""
    arm = open_robot("scara")
    assert not tool_stays_level(arm, resolve_task("scara", arm))
    ends = pose(arm, [[0.3, 0.5, 0.1, 0.0], [0.4, 0.5, 0.1, 0.0]])
    assert check_poses(arm, ends).verdict == "free"
    up = ends.copy()
    up[:, :3, :3] = np.eye(3)
    for task in (None, "scara"):
        with pytest.raises(ConfigurationError, match="never tilt the tool, and pose 1 is tilted; got 180° off"):
            check_poses(arm, up, task=task)
    found = inverse(arm, up[0])
    assert (found.unreached.kind, found.unreached.turn) == ("tilt", pytest.approx(np.pi))
    assert "Give it the tilt of the tool: roll 180.00°, pitch 0.00°" in one_line(found.sentence)
    assert found.unreached.position < 1e-6
    assert len(inverse(arm, ends[0]).branches) == 2


def test_a_program_that_tilts_a_level_tool_is_refused_with_its_line(run, tmp_path: Path) -> None:
    program = tmp_path / "stack.script"
    program.write_text("movel(p[1.5, 0.0, 1.0, 3.14159265, 0, 0], v=0.2)\nmovel(p[1.5, 0.2, 1.0, 2.96, 0, 0], v=0.2)\n")
    done = run("path", str(REPORT / "palletiser.urdf"), str(program))
    assert done.code == 2
    assert "line 2" in done.err
    assert "is tilted; got 10.4° off" in done.err


def rounded_turn(turn: np.ndarray) -> np.ndarray:
    """A rotation of which the file has four digits."""
    return np.asarray(nearest_rotation(np.round(turn, 4)))


def test_only_arms_of_five_joints_are_asked() -> None:
    """Joint 5 of an M-430iA/2F turns the tool about its own axis: position and axis are fixed by four joints."""
    for name, expected in (("px150", True), ("m430ia2f", False), ("ur5e", False), ("scara", False)):
        arm = open_robot(name)
        other = pointing_task(arm, resolve_task("pose", arm))
        assert (other is not None, turn_follows(arm, resolve_task("tool-axis-free", arm))) == (expected, expected)
    palletiser = open_robot(str(REPORT / "palletiser.urdf"))
    assert level_task(palletiser, resolve_task("pose", palletiser)).name == "scara"
    assert level_task(arm, resolve_task("position", arm)) is None


def test_a_monitor_proves_rows_in_tool_axes() -> None:
    """Its bound is not beyond θ5 = 0; the header for C++ looks from the tip, which is turned against the last link."""
    arm = open_robot("px150")
    task = resolve_task("tool-axis-free", arm)
    monitor = Monitor(arm, task, ())
    assert monitor.ruler.at_least(np.array([[0.1, -0.3, 0.5, 0.2, 0.3]]))[0] > 0.0
    header = arm_header(monitor)
    frames = header.split("_frames[] = {")[1].split("}")[0].replace("\n", " ").split(",")
    numbers = [float(one) for one in frames if one.strip()]
    last, tip = numbers[-24:-12], numbers[-12:]
    assert last == tip == [*arm.home[:3, :3].ravel(), *arm.home[:3, 3]]
    assert "/* bounds */" in header


@pytest.mark.slow
def test_help_lists_every_task(run) -> None:
    for command in ("path", "compare"):
        text = one_line(run(command, "--help").out)
        assert ", ".join(task_names()) in text


@pytest.mark.parametrize(("q", "singular"), [("-0.5,0.4,0", True), ("-0.5,-0.6,1.2", True), ("-0.5,0.4,0.8", False)])
def test_three_joints_that_place_a_tool_are_asked_about_its_position(
    run, tmp_path: Path, q: str, *, singular: bool
) -> None:
    """The pose has rank 3 of 6 even where the arm is stretched, or its tip on axis 1. Lengths of ikpy issue 164."""
    path = tmp_path / "three.toml"
    path.write_text("""convention = "standard"
[[joints]]
alpha = "-pi/2"
d = 0.1138
[[joints]]
a = 0.12
theta = "-pi/2"
[[joints]]
a = 0.12
""")
    arm = open_robot(path)
    sigma = np.linalg.svd(jacobian(arm, np.array([float(x) for x in q.split(",")]))[:3], compute_uv=False)
    assert (sigma[-1] < 1e-12) == singular
    done = run("explain", str(path), "--q", q)
    assert (done.code, " is singular" in done.out.splitlines()[0]) == (4 if singular else 0, singular)
    assert "It is checked for position." in one_line(done.out)
    assert "rank 3 of 3" in one_line(run("explain", str(path), "--q", q, "--task", "pose").out)


def test_poses_for_three_joints_name_the_task_that_fits(run, tmp_path: Path) -> None:
    path = tmp_path / "three.toml"
    path.write_text('convention = "standard"\n[[joints]]\nalpha = "-pi/2"\n' + "[[joints]]\na = 0.12\n" * 2)
    done = run("explain", str(path), "--pose", "0.1,0.05,0.1,0,0,0")
    assert "--task position leaves free what they cannot do" in one_line(done.out)


def test_a_roll_beside_the_tip_leaves_no_singularity_behind() -> None:
    """SO-101, two configurations of lerobot pull request 1001: five columns of rank 5, 0.024 and more, on the way."""
    arm = open_robot("so101")
    ends = np.array([[-1.5708, -1.5708, 1.5708, 1.5708, -1.5708], [-1.5708, -1.7102, 1.1232, 1.3598, -1.5709]])
    way = ends[0] + np.linspace(0, 1, 50)[:, None] * (ends[1] - ends[0])
    assert np.linalg.svd(jacobian(arm, way), compute_uv=False)[:, 4].min() > 0.02
    found = check_path(arm, ends)
    assert found.verdict == "free"
    assert found.task.name == "pose"
    assert not turn_follows(arm, resolve_task("tool-axis-free", arm))


@pytest.mark.parametrize(("last", "singular"), [(-0.5529290801934681, True), (-0.1, False)])
def test_four_joints_say_where_the_position_alone_is_singular(
    run, tmp_path: Path, last: float, *, singular: bool
) -> None:
    """With the tip on axis 1 the pose keeps rank 4: joint 1 still turns the tool."""
    path = tmp_path / "four.toml"
    path.write_text('convention = "standard"\n[[joints]]\nd = 0.1\nalpha = "-pi/2"\n[[joints]]\na = 0.13\n'
                    'theta = "-pi/2"\n' + "[[joints]]\na = 0.12\n" * 2)  # fmt: skip
    sigma = np.linalg.svd(jacobian(open_robot(path), np.array([0.3, -0.6, 1.2, last]))[:3], compute_uv=False)
    assert (sigma[2] < 1e-12) == singular
    text = one_line(run("explain", str(path), "--q", f"0.3,-0.6,1.2,{last!r}").out)
    assert ("For position alone (--task position) it is singular here, rank 2 of 3." in text) == singular


@pytest.mark.parametrize(("rows", "singular"), [
    ([(0.4, 0.0, 0.0), (0.3, 0.0, 0.0)], 0.0),
    ([(0.0, np.pi / 2, 0.2), (0.3, 0.0, 0.0)], np.pi / 2),
])  # fmt: skip
def test_two_joints_that_place_a_tool_are_asked_about_its_position(
    rows: list[tuple[float, float, float]], singular: float
) -> None:
    """By hand: two links in a plane lose rank where stretched; pan and tilt where the tip is above axis 1."""
    arm = from_dh([(a, alpha, d, 0.0) for a, alpha, d in rows], convention="standard")
    asked = asked_task(arm, resolve_task("pose", arm))
    assert asked.name == "position"
    step = 1e-6  # the Jacobian by differences
    for second, rank in ((singular, 1), (singular + 0.7, 2)):
        q = np.array([0.3, second])
        columns = [(pose(arm, q + step * axis)[:3, 3] - pose(arm, q - step * axis)[:3, 3]) / (2 * step)
                   for axis in np.eye(2)]  # fmt: skip
        assert np.linalg.matrix_rank(np.array(columns), tol=1e-6) == rank
        assert explain(arm, q, asked, evaluations=0).rank.rank == rank


def test_poses_that_five_joints_cannot_take_get_another_task_and_no_detour(run, tmp_path: Path) -> None:
    """Both ends are reached; between them the yaw of the line is not the direction of its points from axis 1."""
    file = tmp_path / "five.csv"
    file.write_text("x,y,z,roll,pitch,yaw\n0.25,0.0,0.15,0,0.5,0\n0.25,0.08,0.15,0,0.5,0.3097\n", encoding="utf-8")
    ended = run("path", "px150", str(file), "--quiet")
    assert "--task tool-axis-free" in ended.out
    assert "etour" not in ended.out
    assert run("path", "px150", str(file), "--quiet", "--task", "tool-axis-free").out.startswith("Free")


@pytest.mark.parametrize("command", ["cover", "conditions"])
def test_a_command_that_takes_the_pose_names_the_task_that_three_joints_do_in_full(run, command, tmp_path) -> None:
    """A pose of this arm is never singular, its position is where the arm is stretched: explain answered that."""
    table = tmp_path / "arm.txt"
    table.write_text("standard DH\n| i | a | alpha | d | theta |\n| 1 | 0 | 90 | 0.4 | q1 |\n"
                     "| 2 | 0.3 | 0 | 0 | q2 |\n| 3 | 0.25 | 0 | 0 | q3 |\n", encoding="utf-8")  # fmt: skip
    done = run(command, str(table), "--quiet")
    assert "3 joints, too few for a pose" in one_line(done.err)
    assert "--task position" in one_line(done.err)
    named = run(command, str(table), "--task", "position", "--quiet")
    assert "too few" not in named.err
    assert "too few" not in run(command, "planar3r", "--quiet").err
