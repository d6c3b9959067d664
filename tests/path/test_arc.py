"""Circular moves: the tip goes on the circle through three places, the tool turns in proportion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from rankdrop.kinematics import pose
from rankdrop.path.check.moves import EndCause
from rankdrop.path.check.path_file import PathQuestion
from rankdrop.path.check.program import ProgramCheck, check_any_file
from rankdrop.path.read.arc import arc_angle, arc_poses
from rankdrop.path.read.program_file import read_program
from rankdrop.questions import PathOptions
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

DOWN = "3.141592653589793,0,0"


def circle(rng: np.random.Generator) -> tuple[Array, Array, Array, float]:
    """Centre, two directions of the plane at right angles (3,), and a radius."""
    frame = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()
    return rng.normal(size=3), frame[0], frame[1], float(rng.uniform(0.05, 2.0))


@pytest.mark.parametrize("seed", range(20))
def test_poses_are_on_the_circle_and_the_chords_near_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    centre, one, other, radius = circle(rng)
    between, whole = np.sort(rng.uniform(0.05, 6.2, 2))
    angles = np.array([0.0, between, whole])
    places = centre + radius * (np.cos(angles)[:, None] * one + np.sin(angles)[:, None] * other)
    begin, end = np.eye(4), np.eye(4)
    begin[:3, :3], end[:3, :3] = Rotation.random(2, random_state=seed).as_matrix()
    begin[:3, 3], end[:3, 3] = places[0], places[2]
    made = arc_poses(begin, places[1], end, 1e-4)
    assert made is not None
    assert arc_angle(*places) == pytest.approx(whole, abs=1e-9)
    share = np.linspace(0.0, 1.0, len(made))
    wanted = centre + radius * (np.cos(whole * share)[:, None] * one + np.sin(whole * share)[:, None] * other)
    np.testing.assert_allclose(made[:, :3, 3], wanted, atol=1e-9)
    middles = (made[1:, :3, 3] + made[:-1, :3, 3]) / 2.0
    assert radius - np.linalg.norm(middles - centre, axis=1).min() <= 1e-4 * (1 + 1e-6)
    turned = Slerp([0.0, 1.0], Rotation.from_matrix([begin[:3, :3], end[:3, :3]]))(share).as_matrix()
    np.testing.assert_allclose(made[:, :3, :3], turned, atol=1e-9)


@pytest.mark.parametrize("via", [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
def test_three_places_on_a_line_are_no_circle(via: list[float]) -> None:
    end = np.eye(4)
    end[0, 3] = 2.0
    assert arc_poses(np.eye(4), np.array(via), end, 1e-4) is None


PROGRAMS = {
    "a.script": ("ur5e", f"""movej([0.16,-1.61,2.11,-2.07,-1.57,1.73])
movel(p[-.40,-.20,.30,{DOWN}], v=0.2)
movec(p[-.35,-.15,.30,{DOWN}], p[-.30,-.20,.30,{DOWN}], a=1.2, v=0.1, r=0, mode=0)
"""),
    "a.src": ("kr6r900", """DEF a()
$VEL.CP=0.1
PTP {A1 0, A2 -90, A3 90, A4 0, A5 60, A6 0}
LIN {X 500, Y 0, Z 600, A 180, B 40, C 180}
CIRC {X 520, Y 60, Z 600}, {X 560, Y 80, Z 600, A 180, B 40, C 180}
END
"""),
    "a.mod": ("irb120", """MODULE a
PROC main()
MoveAbsJ [[0,10,10,0,50,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
MoveL [[350,0,450],[0.6,0,0.8,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
MoveC [[370,40,450],[0.6,0,0.8,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
      [[350,80,450],[0.6,0,0.8,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
ENDPROC
ENDMODULE
"""),
    "a.ls": ("lrmate200id", """/PROG  A
/MN
   1:J P[1] 50% FINE ;
   2:L P[2] 100mm/sec FINE ;
   3:C P[3]
    :  P[4] 100mm/sec FINE ;
/POS
"""
    + "".join(f"""P[{k}]{{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'N U T, 0, 0, 0',
	X = {x}.000  mm,	Y = {y}.000  mm,	Z = 100.000  mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
}};
""" for k, (x, y) in enumerate([(420, -100), (450, -100), (500, -50), (450, 0)], start=1)) + "/END\n"),
}  # fmt: skip
PLACES = {
    "a.script": [[-0.40, -0.20, 0.30], [-0.35, -0.15, 0.30], [-0.30, -0.20, 0.30]],
    "a.src": [[0.5, 0.0, 0.6], [0.52, 0.06, 0.6], [0.56, 0.08, 0.6]],
    "a.mod": [[0.35, 0.0, 0.45], [0.37, 0.04, 0.45], [0.35, 0.08, 0.45]],
    "a.ls": [[0.45, -0.1, 0.43], [0.5, -0.05, 0.43], [0.45, 0.0, 0.43]],  # Z from the height of axis 2, 330 mm
}


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_tip_of_a_checked_program_stays_on_the_circle(name: str, tmp_path: Path) -> None:
    """The circle's centre is found here by least squares: |x − c|² = r² at three places and c in their plane."""
    arm, text = PROGRAMS[name]
    robot = open_robot(arm)
    found = check_any_file(robot, written(tmp_path, name, text), PathQuestion(None, None, PathOptions()))
    assert isinstance(found, ProgramCheck)
    (part,) = found.parts
    assert (part.ended, part.moves[-1].kind) == (None, "arc")
    places = np.array(PLACES[name])
    normal = np.cross(places[1] - places[0], places[2] - places[0])
    rows = np.array([places[1] - places[0], places[2] - places[0], normal])
    sides = [(places[1] @ places[1] - places[0] @ places[0]) / 2, (places[2] @ places[2] - places[0] @ places[0]) / 2]
    centre = np.linalg.solve(rows, [*sides, normal @ places[0]])
    radius = np.linalg.norm(places[0] - centre)
    assert part.check is not None
    index = len(part.moves) - 1
    control = part.check.curve.control[part.owner == index]
    share = np.linspace(0.0, 1.0, 9)[None, :, None]
    q = (control[:, :1] + share * (control[:, -1:] - control[:, :1])).reshape(-1, robot.n)
    tips = pose(robot, q)
    off = np.hypot(np.linalg.norm(tips[:, :3, 3] - centre, axis=1) - radius,
                   (tips[:, :3, 3] - centre) @ normal / np.linalg.norm(normal))  # fmt: skip
    assert off.max() <= min(part.off, 1e-4)
    assert np.linalg.norm(tips[0, :3, 3] - places[0]) < 1e-9
    assert np.linalg.norm(tips[-1, :3, 3] - places[2]) < 1e-9
    assert np.linalg.norm(tips[:, :3, 3] - places[1], axis=1).min() < 2e-3
    assert np.abs(tips[:, :3, :3] - tips[0, :3, :3]).max() < 1e-3
    angle = arc_angle(*places)
    assert angle is not None
    assert found.moves[-1].seconds == pytest.approx(angle * radius / 0.1, rel=1e-3)
    assert "1 circular" in " ".join(found.summary)


TURNED = PROGRAMS["a.mod"][1].replace("[[350,80,450],[0.6,0,0.8,0]", "[[350,80,450],[0.8,0,0.6,0]")
LONG = PROGRAMS["a.mod"][1].replace("[[370,40,450]", "[[420,40,450]")


FANUC = PROGRAMS["a.ls"][1]
CALLED = PROGRAMS["a.mod"][1].replace("MoveC", "Grip;\nMoveC")
OTHER_TOOL = PROGRAMS["a.mod"][1].replace("MoveC", "MoveC", 1).replace(
    "]],v100,fine,tool0;\nENDPROC", "]],v100,fine,tGun;\nENDPROC")  # fmt: skip


@pytest.mark.parametrize(("name", "text"), [
    ("a.mod", CALLED), ("a.mod", OTHER_TOOL), ("a.mod", TURNED), ("a.mod", LONG),
    ("a.src", PROGRAMS["a.src"][1].replace("C 180}\nEND", "C 180}, CA 90\nEND")),
    ("a.src", PROGRAMS["a.src"][1].replace("$VEL.CP=0.1", "$CIRC_TYPE = #PATH")),
    ("a.src", PROGRAMS["a.src"][1].replace("$VEL.CP=0.1", "$ORI_TYPE = #JOINT")),
    ("a.script", PROGRAMS["a.script"][1].replace("mode=0", "mode=1")),
    ("a.ls", FANUC.replace("P = 0.000 deg", "P = 5.000 deg", 3)),
    ("a.ls", FANUC.replace("Y = -50.000", "Y = 300.000")),
    ("a.ls", FANUC.replace("P = 0.000 deg", "P = 0.0 deg", 2).replace("P = 0.000 deg", "P = 5.000 deg", 1)),
])  # fmt: skip
def test_an_arc_on_which_the_turn_of_the_tool_is_not_known_is_not_read(name: str, text: str, tmp_path: Path) -> None:
    assert text != PROGRAMS[name][1]
    program = read_program(written(tmp_path, name, text))
    assert "circle" in [skipped.reason.value for skipped in program.skipped]
    assert "arc" not in [move.kind for move in program.moves]


def test_an_arc_through_places_on_a_line_is_not_made(tmp_path: Path) -> None:
    text = PROGRAMS["a.src"][1].replace("{X 520, Y 60, Z 600}", "{X 530, Y 40, Z 600}")
    file = written(tmp_path, "a.src", text)
    found = check_any_file(open_robot("kr6r900"), file, PathQuestion(None, None, PathOptions()))
    assert isinstance(found, ProgramCheck)
    assert found.parts[0].ended is not None
    assert found.parts[0].ended.cause is EndCause.NO_CIRCLE
    assert "lie on one line" in found.sentence
