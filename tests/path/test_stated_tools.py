"""The tool that a program states for all its moves is added to the arm: its poses are those of the tool point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from path.read_programs import checked, written
from rankdrop.kinematics import pose
from rankdrop.path.check.program import ProgramCheck
from rankdrop.path.read.program_file import read_program
from rankdrop.path.read.program_record import Program
from rankdrop.robot.model import Array, Robot, with_tool
from rankdrop.robot.open import open_robot

TOOL = np.eye(4)
TOOL[:3, :3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]  # turned by 90° about Y
TOOL[:3, 3] = [0.02, -0.03, 0.15]
HALF = float(np.sqrt(0.5))
PROGRAMS = {
    "krl.src": ("kr6r900", """DEF weld()
$TOOL = {X 20, Y -30, Z 150, A 0, B 90, C 0}
PTP {A1 0, A2 -80, A3 90, A4 10, A5 60, A6 0}
$VEL.CP=0.1
LIN {X 560, Y -40, Z 580, A 156, B -68, C -153}
LIN {X 560, Y 20, Z 580, A 156, B -60, C -153}
END
"""),
    "data.src": ("kr6r900", """DEF weld()
TOOL_DATA[3] = {X 20, Y -30, Z 150, A 0, B 90, C 0}
BAS(#TOOL, 3)
PTP {A1 0, A2 -80, A3 90, A4 10, A5 60, A6 0}
LIN {X 560, Y -40, Z 580, A 156, B -68, C -153}
END
"""),
    "rapid.mod": ("irb120", f"""MODULE weld
PERS tooldata tGun := [TRUE,[[20,-30,150],[{HALF},0,{HALF},0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
PROC main()
MoveAbsJ [[0,10,10,20,50,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
MoveL [[400,40,320],[0.6,0,-0.8,0],[9E9,9E9,9E9,9E9],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tGun;
MoveL [[400,60,340],[0.6,0,-0.8,0],[9E9,9E9,9E9,9E9],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tGun;
ENDPROC
ENDMODULE
"""),
    "ur.script": ("ur5e", """def weld():
  set_tcp(p[0.02,-0.03,0.15,0,d2r(90),0], "gun")
  movej([0,-1.57,1.57,-1.57,-1.57,0])
  movel(p[-0.4,-0.2,0.4,2.2,2.2,0], v=0.1)
  movel(p[-0.4,-0.25,0.4,2.2,2.2,0], v=0.1)
end
"""),
}  # fmt: skip


def ends(robot: Robot, found: ProgramCheck) -> list[Array]:
    """Where the tip of an arm is at the end of each move that was made."""
    (part,) = found.parts
    assert part.check is not None
    rows = np.concatenate([part.check.curve.control[:, 0], part.check.curve.control[-1:, -1]])
    lasts = [int(np.flatnonzero(part.owner == index)[-1]) + 1 for index in np.unique(part.owner)]
    return [pose(robot, rows[last]) for last in lasts]


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_tool_point_reaches_the_targets(name: str, tmp_path: Path) -> None:
    arm, text = PROGRAMS[name]
    robot = open_robot(arm)
    found = checked(robot, written(tmp_path, name, text))
    assert found.program.tool == pytest.approx(TOOL, abs=1e-12)
    assert [skipped.reason.value for skipped in found.program.skipped if "tool" in skipped.reason.value] == []
    assert found.parts[0].ended is None
    tool = with_tool(robot, TOOL[:3, 3], [0.0, np.pi / 2, 0.0])
    goals = [move.target.pose for move in found.program.moves if move.target.pose is not None]
    reached = ends(tool, found)[-len(goals) :]
    for goal, tip in zip(goals, reached, strict=True):
        assert tip == pytest.approx(goal, abs=1e-9)
    assert found.robot.home == pytest.approx(tool.home, abs=1e-12)
    assert any(line.startswith("Tool: (20.0, −30.0, 150.0) mm") for line in found.summary)


@pytest.mark.parametrize("name", ["krl.src", "ur.script"])
def test_a_tool_point_of_the_user_takes_its_place(name: str, tmp_path: Path) -> None:
    arm, text = PROGRAMS[name]
    own = with_tool(open_robot(arm), [0.0, 0.0, 0.05])
    found = checked(own, written(tmp_path, name, text), at_tool_point=True)
    assert found.tool is None
    assert any("which is not added" in line for line in found.summary)
    assert found.robot.home == pytest.approx(own.home)


MOVES = "movel(p[-0.4,-0.2,0.4,2.2,2.2,0])\n"


@pytest.mark.parametrize(("text", "lines", "moves"), [
    (f"set_tcp(p[0,0,0.1,0,0,0])\n{MOVES}set_tcp(p[0,0,0.2,0,0,0])\n{MOVES}", [], []),
    (f"{MOVES}set_tcp(p[0,0,0.2,0,0,0])\n{MOVES}", [], [1]),
    (f"set_tcp(p[0,0,0.1,0,0,0])\n{MOVES}set_tcp(gripper)\n{MOVES}", [3], [4]),
    (f"set_tcp(gripper)\n{MOVES}", [1], [2]),
])  # fmt: skip
def test_a_tool_that_is_not_known_is_named_with_its_moves(
    text: str, lines: list[int], moves: list[int], tmp_path: Path
) -> None:
    program: Program = read_program(written(tmp_path, "a.script", text))
    assert program.tool is None
    assert [skipped.line for skipped in program.skipped if skipped.reason.value == "tool frame"] == lines
    assert [move.line for move in program.moves if "tool" in move.assumed] == moves


def test_each_move_is_made_with_its_own_tool(tmp_path: Path) -> None:
    """The tip of either tool is at the target of its line; with the first tool alone the second would be 50 mm off."""
    text = (
        "set_tcp(p[0,0,0.1,0,0,0])\nmovel(p[-0.4,-0.2,0.4,3.14159,0,0], v=0.1)\n"
        "movel(p[-0.4,-0.3,0.4,3.14159,0,0], v=0.1)\nset_tcp(p[0.02,0,0.15,0,0.3,0])\n"
        "movel(p[-0.45,-0.3,0.35,3.14159,0,0], v=0.1)\n"
    )
    arm = open_robot("ur5e")
    found = checked(arm, written(tmp_path, "a.script", text))
    (part,) = found.parts
    assert (part.ended, found.assumptions, found.tool) == (None, {}, None)
    first, second = (with_tool(arm, place, turn) for place, turn in
                     (([0.0, 0.0, 0.1], [0.0, 0.0, 0.0]), ([0.02, 0.0, 0.15], [0.0, 0.3, 0.0])))  # fmt: skip
    assert part.check is not None
    rows = np.concatenate([part.check.curve.control[:, 0], part.check.curve.control[-1:, -1]])
    last = {index: int(np.flatnonzero(part.owner == index)[-1]) + 1 for index in np.unique(part.owner)}
    assert pose(first, rows[last[1]])[:3, 3] == pytest.approx([-0.4, -0.3, 0.4], abs=1e-9)
    assert pose(second, rows[-1])[:3, 3] == pytest.approx([-0.45, -0.3, 0.35], abs=1e-9)
    assert pose(second, rows[-1]) == pytest.approx(found.program.moves[-1].target.pose, abs=1e-9)
    ways = pose(second, rows[last[1] :])[:, :3, 3]
    line = ways[-1] - ways[0]
    off = np.cross(ways - ways[0], line / np.linalg.norm(line))
    assert np.linalg.norm(off, axis=1).max() < 2e-5
    assert any(line.startswith("Tool: 2 tools") for line in found.summary)


def test_one_tool_that_is_set_again_is_one_tool(tmp_path: Path) -> None:
    text = f"set_tcp(p[0,0,0.1,0,0,0])\n{MOVES}set_tcp(p[0,0,0.1,0,0,0])\n{MOVES}"
    program = read_program(written(tmp_path, "a.script", text))
    assert (program.tool is not None, program.skipped) == (True, ())


def test_a_tool_that_the_robot_does_not_hold_is_not_its_tool(tmp_path: Path) -> None:
    text = PROGRAMS["rapid.mod"][1].replace("[TRUE,[[20", "[FALSE,[[20")
    program = read_program(written(tmp_path, "a.mod", text))
    assert program.tool is None
    assert [skipped.reason.value for skipped in program.skipped] == ["tool frame", "tool frame"]


def test_a_program_that_begins_with_a_pose_and_states_its_posture_begins_there(tmp_path: Path) -> None:
    text = "movej(get_inverse_kin(p[-0.4,-0.2,0.3,3.14159,0,0], qnear=[0.2,-1.6,2.1,-2.1,-1.6,1.7]))\n" + MOVES
    found = checked(open_robot("ur5e"), written(tmp_path, "a.script", text))
    assert [part.begins for part in found.parts] == ["stated"]
    assert any("one in the posture that it states is taken" in line for line in found.summary)
    assert found.parts[0].check is not None
    first = found.parts[0].check.curve.control[0, 0]
    assert np.abs(first - [0.2, -1.6, 2.1, -2.1, -1.6, 1.7]).max() < 0.3


def test_after_a_line_that_ends_the_next_target_is_reached_in_another_posture(tmp_path: Path) -> None:
    """Joint 4 ends at its limit in line 4; the target of line 5 has six solutions inside the limits."""
    text = """DEF weld()
$TOOL = {X 0, Y 0, Z 100, A 0, B 0, C 0}
PTP {A1 18.6, A2 -66.5, A3 124.6, A4 -150, A5 53, A6 160}
LIN {X 600, Y 200, Z 500, A 0, B 90, C 0}
LIN {X 600, Y 200, Z 550, A 0, B 90, C 0}
LIN {X 600, Y 180, Z 550, A 0, B 90, C 0}
END
"""
    found = checked(open_robot("kr6r900"), written(tmp_path, "a.src", text))
    first, second = found.parts
    assert first.ended is not None
    assert (first.ended.move.line, second.ended) == (4, None)
    assert [move.line for move in second.moves] == [5, 6]


GUN = "{X 0, Y 0, Z 150, A 0, B 0, C 0}"
WELD = "LIN {X 560, Y -40, Z 580, A 156, B -68, C -153}"


def tools(program: Program) -> list[float | None]:
    """How far the tool of each move is from the flange along Z [m]; None: not known."""
    return [None if move.tool is None else float(move.tool[2, 3]) for move in program.moves]


@pytest.mark.parametrize(("lines", "expected"), [
    ([f"S{WELD} WITH $TOOL = {GUN}", WELD], [0.15, 0.0]),
    ([f"S{WELD} WITH $TOOL = GRIPPER", WELD], [None, 0.0]),
    ([f"SPLINE WITH $TOOL = {GUN}", f"S{WELD}", "ENDSPLINE", WELD], [0.15, 0.0]),
    ([f"$TOOL = {GUN}", f"S{WELD} WITH $TOOL = $NULLFRAME", WELD], [0.0, 0.15]),
    ([f"$TOOL = {GUN}", WELD, "BAS(#TOOL, 0)", WELD], [0.15, 0.0]),
])  # fmt: skip
def test_a_tool_behind_with_is_that_of_its_move_or_block_alone(
    lines: list[str], expected: list[float | None], tmp_path: Path
) -> None:
    program = read_program(written(tmp_path, "a.src", "\n".join(["DEF a()", *lines, "END", ""])))
    assert tools(program) == expected
    assert program.tool is None


def test_a_move_relative_to_a_pose_of_another_tool_is_not_read(tmp_path: Path) -> None:
    text = f"DEF a()\n{WELD}\n$TOOL = {GUN}\nLIN_REL {{Z 10}}\nEND\n"
    program = read_program(written(tmp_path, "a.src", text))
    assert [skipped.reason.value for skipped in program.skipped] == ["relative"]
