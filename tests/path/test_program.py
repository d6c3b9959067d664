"""Robot programs: targets, units and angles of each language; lines that are not read; and the checked moves."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from path.program_data import ASK, DATA
from path.read_programs import about, moves, skipped
from rankdrop.cli import main
from rankdrop.errors import OptionError
from rankdrop.kinematics import pose
from rankdrop.path.check import program
from rankdrop.path.check.path_file import PathQuestion
from rankdrop.path.check.program import check_any_file, check_program
from rankdrop.path.read import krl, urscript
from rankdrop.path.read.program_file import read_program
from rankdrop.path.read.program_record import Posture
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.questions import PathOptions
from rankdrop.robot.open import open_robot


def test_krl_turns_about_z_then_the_new_y_then_the_new_x() -> None:
    program = read_program(DATA / "krl.src")
    found = moves(program)[12].target
    # turns about new axes are applied from the left to the right
    np.testing.assert_allclose(found.pose[:3, :3], about("z", 20) @ about("y", 70) @ about("x", -15), atol=1e-15)
    np.testing.assert_allclose(found.pose[:3, 3], [0.480, 0.120, 0.620], atol=1e-15)
    assert found.posture == Posture(signs=2)
    assert moves(program)[9].target.joints == (-10, -80, 80, 10, 40, -10)
    assert [one.kind for one in program.moves] == ["joint", "line", "line", "line", "line"]
    assert [one.speed.linear for one in program.moves] == [None, 0.25, 0.25, 0.25, 0.1]
    assert [one.blend for one in program.moves] == [False, True, False, False, False]


def test_a_base_of_krl_is_applied_and_an_unknown_one_is_not_guessed() -> None:
    program = read_program(DATA / "krl.src")
    found = moves(program)[23].target.pose
    own = np.array([0.020, -0.360, 0.550])
    np.testing.assert_allclose(found[:3, 3], about("z", 90) @ own + [0.1, -0.02, 0.05], atol=1e-15)
    np.testing.assert_allclose(found[:3, :3], about("y", 80), atol=1e-15)
    assert skipped(program)[25] == "base frame"


def test_krl_reads_the_declarations_next_to_it(tmp_path: Path) -> None:
    (tmp_path / "a.src").write_text("DEF a()\nBAS(#PTP_PARAMS,40)\nPTP XP1\nLIN XP2\nEND\n")
    with pytest.raises(TrajectoryError, match=r"no move of this KRL program.*line 3: PTP XP1"):
        read_program(tmp_path / "a.src")
    (tmp_path / "a.dat").write_text("DEFDAT a\nDECL E6AXIS XP1={A1 1,A2 -90,A3 90,A4 0,A5 30,A6 0,E1 0}\nENDDAT\n")
    program = read_program(tmp_path / "a.src")
    assert program.moves[0].target.joints == (1, -90, 90, 0, 30, 0)
    assert program.moves[0].speed.share == 0.4
    assert skipped(program) == {4: "variable"}


def test_rapid_has_the_real_part_first() -> None:
    program = read_program(DATA / "rapid.mod")
    found = moves(program)[13].target
    w, x, y, z = np.array([0.0616284, -0.2418448, 0.9659258, -0.0690992])
    size = np.sqrt(w * w + x * x + y * y + z * z)
    u, s = np.array([x, y, z]) / size, w / size
    for v in np.eye(3):  # v' = v + 2 s u × v + 2 u × (u × v)
        turned = v + 2 * s * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v))
        np.testing.assert_allclose(found.pose[:3, :3] @ v, turned, atol=1e-14)
    np.testing.assert_allclose(found.pose[:3, 3], [0.35, -0.06, 0.42], atol=1e-15)
    assert found.posture == Posture(quarters=(-1, 0, -1))
    assert moves(program)[10].target.joints == (0, -20, 30, 0, 60, 0)
    speeds = {line: one.speed.linear for line, one in moves(program).items()}
    assert speeds == pytest.approx({10: None, 11: 0.1, 12: 0.04, 13: 0.025, 15: 0.1, 22: None})
    assert moves(program)[12].speed.angular == pytest.approx(np.pi / 2)
    assert {line for line, one in moves(program).items() if one.blend} == {11}


def test_urscript_has_rotation_vectors_in_radians() -> None:
    program = read_program(DATA / "urscript.script")
    found = moves(program)[7].target.pose
    vector = np.array([0.3, 2.2, 0.3])
    cross = np.cross(vector, np.eye(3)).T  # cross @ v is vector × v
    series, term = np.eye(3), np.eye(3)
    for k in range(1, 40):  # the exponential series
        term = term @ cross / k
        series = series + term
    np.testing.assert_allclose(found[:3, :3], series, atol=1e-13)
    np.testing.assert_allclose(found[:3, 3], [-0.35, -0.25, 0.5])
    assert moves(program)[7].speed.linear == 0.2, "a name of a number"
    assert moves(program)[6].speed.joint == 1.05
    assert moves(program)[9].speed.joint == 1.05, "by place: a, v"
    assert moves(program)[10].speed.time == 2.0
    assert not program.degrees


@pytest.mark.slow
def test_a_line_goes_on_from_where_the_joint_move_ended() -> None:
    """Straight lines start at the pose of the joints before them, and keep their branch and their time."""
    arm = open_robot("ur5e")
    start = np.array([0.2, -1.3, 1.5, -1.1, 1.2, 0.3])
    text = f"movej({start.tolist()})\nmovel(p[-0.35, -0.25, 0.5, 0.3, 2.2, 0.3], v=0.1)\n"
    found = check_program(arm, urscript.read(text, "a.script"), ASK)
    (part,) = found.parts
    curve = part.check.curve
    rows = np.concatenate([curve.control[:, 0], curve.control[-1:, -1]])
    np.testing.assert_allclose(rows[0], start, atol=1e-12)
    ends = pose(arm, rows)
    np.testing.assert_allclose(ends[-1][:3, 3], [-0.35, -0.25, 0.5], atol=1e-9)
    way = ends[-1][:3, 3] - ends[0][:3, 3]
    length = np.linalg.norm(way)
    off = np.linalg.norm(np.cross(ends[:, :3, 3] - ends[0][:3, 3], way / length), axis=1)
    assert off.max() < 1e-9, "every row is on the line"
    assert curve.times[-1] == pytest.approx(length / 0.1)
    assert part.off <= 1e-4


@pytest.mark.slow
def test_a_program_with_unread_moves_is_not_called_free() -> None:
    arm = open_robot("ur5e")
    text = "movej([0.2,-1.3,1.5,-1.1,1.2,0.3])\nmovej([0.3,-1.3,1.5,-1.1,1.2,0.3])\n"
    whole = check_program(arm, urscript.read(text, "a.script"), ASK)
    assert (whole.verdict.value, whole.holds) == ("free", True)
    part = check_program(arm, urscript.read(f"{text}movel(target)\n", "a.script"), ASK)
    assert (part.verdict.value, part.holds) == ("undecided", False)
    assert part.sentence.startswith("Undecided: 1 move of the program was not read")


def test_a_line_of_known_speed_near_a_singularity_is_not_called_unknown() -> None:
    """Two parts, split by a move that is not read: the one near a singularity has its speed, the other has none."""
    lines = [
        "DEF A()", "PTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}",
        "LIN {X 322.291412, Y 0, Z 586.510622, A 180, B 60, C 180}", "PTP XHOME", "$VEL.CP=0.05",
        "PTP {A1 0, A2 -90, A3 90, A4 0, A5 2, A6 0}", "LIN {X 332.293819, Y 0, Z 621.393159, A 180, B 88, C 180}",
        "END", "",
    ]  # fmt: skip
    found = check_program(open_robot("kr3r540"), krl.read("\n".join(lines), "a.src"), ASK)
    assert [part.untimed is None for part in found.parts] == [False, True]
    assert min(move.distance for move in found.moves) < 0.05
    assert "are not known" not in found.sentence


def test_a_line_through_a_singularity_is_not_called_free() -> None:
    """Its joints are free of it before and after, as the branch goes on; the line passes through it all the same."""
    arm = open_robot("ur5e")
    text = "movej([0.2,-1.3,1.5,-1.1,1.2,0.3])\nmovej([0.3,-1.3,1.5,-1.1,1.2,0.3])\n"
    whole = check_program(arm, urscript.read(text, "a.script"), ASK)
    through = replace(whole, parts=tuple(replace(part, passed=(1,)) for part in whole.parts))
    assert (through.verdict.value, through.holds) == ("touching", False)
    assert [one.verdict for one in through.moves] == [None, through.verdict]


@pytest.mark.slow
def test_lines_alone_of_the_kr3_from_the_start_of_the_report(tmp_path: Path) -> None:
    """Report 14: no crossing, joint 5 comes to 3.73°, joint 4 turns by 173°; computed by other code."""
    lines = (DATA / "report-14.src").read_text().splitlines()
    (tmp_path / "a.src").write_text("\n".join(one for one in lines if not one.startswith("PTP")))
    start = tuple(np.radians([-25.0, -60, 60, 40, 20, -40]).tolist())
    question = PathQuestion(None, None, PathOptions(), start=start)
    found = check_any_file(open_robot("kr3r540"), tmp_path / "a.src", question)
    assert (found.verdict.value, found.holds) == ("free", True)
    (move,) = [one for one in found.moves if one.verdict is not None]
    assert (move.line, move.joint, round(np.degrees(move.turn))) == (5, 4, 173)
    assert round(np.degrees(move.distance), 2) == 3.73
    assert move.seconds == pytest.approx(3.0)


@pytest.mark.slow
def test_the_report_of_the_kr3(capsys: pytest.CaptureFixture[str]) -> None:
    """Joints, then two lines: no crossing; the branch of this start takes joint 4 to its limit half way."""
    assert main.run(["path", "kr3r540", str(DATA / "report-14.src"), "--quiet"]) == 3
    printed = " ".join(capsys.readouterr().out.split())
    assert printed.startswith("Cannot be followed in line 6: LIN {X 420, Y 150")
    assert "joint 4 (joint_a4) reaches its limit" in printed
    assert "crosses" not in printed


def test_a_folder_has_programs_in_its_table(tmp_path: Path) -> None:
    (tmp_path / "a.script").write_text("movej([0.3,0.4,0.1])\nmovej([0.5,-0.2,0.3])\n")
    (tmp_path / "b.ls").write_text("/MN\n/POS\n")
    out = tmp_path / "o.json"
    names = [str(tmp_path / "a.script"), str(tmp_path / "b.ls")]
    assert main.run(["path", "planar3r", *names, "--json", str(out), "--quiet"]) == 2
    first, second = json.loads(out.read_text())["paths"]
    assert (first["verdict"], second["verdict"]) == ("bad input", "crossing")
    assert "in line 2: movej([0.5,-0.2,0.3])" in second["sentence"]


def test_options_that_do_not_fit_programs_are_refused(tmp_path: Path) -> None:
    arm, file = open_robot("ur5e"), DATA / "urscript.script"
    with pytest.raises(OptionError, match="topics"):
        check_any_file(arm, file, PathQuestion(None, None, PathOptions(), topic="/a"))
    with pytest.raises(OptionError, match="moves of a program are its own"):
        check_any_file(arm, file, PathQuestion(None, None, PathOptions(interpolate="cubic")))
    with pytest.raises(OptionError, match="start: a start is for programs that begin with a pose"):
        check_any_file(arm, file, PathQuestion(None, None, PathOptions(), start=(0.0,) * 6))
    assert main.run(["path", "ur5e", str(file), "--html", str(tmp_path / "a.html")]) == 2
    assert main.run(["path", "ur5e", str(file), "--remedies"]) == 2
    with pytest.raises(TrajectoryError, match=r"line 5: the target has another number of joints.*allowed: 7 of panda"):
        check_any_file(open_robot("panda"), file, ASK)


def test_the_number_of_parts_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(program, "_MOST_PARTS", 2)
    text = "movej([0.3,0.4,0.1])\nmovel(p)\n"
    arm = open_robot("planar3r")
    assert len(check_program(arm, urscript.read(text * 2, "a.script"), ASK).parts) == 2
    with pytest.raises(TrajectoryError, match=r"a.script, line 5: the program has too many parts.*at most 2"):
        check_program(arm, urscript.read(text * 3, "a.script"), ASK)


PAST_WRIST = """DEF weld()
PTP {A1 9.663754, A2 -68.967221, A3 88.562604, A4 -85.186016, A5 9.102425, A6 88.473993}
$VEL.CP=0.1
LIN {X 662.388311, Y 100.0, Z 689.308148, A 180.0, B 69.9, C 180.0}
END
"""


@pytest.mark.slow
def test_a_singularity_has_one_name_in_the_lines_of_an_answer() -> None:
    """The singularities on the way were of joint 5 at 0°, the nearest one was that of axes 4 and 6 aligned."""
    found = check_program(open_robot("kr6r900"), krl.read(PAST_WRIST, "weld.src"), ASK)
    (nearest,) = {stretch.name for stretch in found.stretches if stretch.closest.distance < 0.01}
    text = " ".join("\n".join(str(section) for section in found.sections()).split())
    assert nearest == "wrist: axes 4 and 6 aligned"
    assert "Nearest singularity: wrist: joint 5 at 0°, 0.001745 rad (0.1°) away, in line 4" in text
    assert nearest not in text
    assert "Turns: joint 6 turns 143° within 0.0655 s in line 4." in text
