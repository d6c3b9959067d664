"""Programs of RAPID as engineers have them: headers, Offs, RelTool, work objects, displacements, moves in blocks."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.path.read.program_record import Program
from rankdrop.path.read.rapid import read

END = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
DOWN = "[0,0,1,0]"  # X of the tool is −X of the base, Z of the tool is −Z
HEAD = f"""%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE Main
  CONST robtarget p10:=[[400,0,500],{DOWN},{END};
  CONST num up:=50;
  PROC main()
"""
GO = "v100,fine,tool0"


def of(*statements: str) -> Program:
    return read(HEAD + "".join(f"{line}\n" for line in statements), "a.mod")


def reasons(program: Program) -> list[tuple[int, str]]:
    first = len(HEAD.splitlines())
    return [(item.line - first, item.reason.value) for item in program.skipped]


def place(program: Program) -> list[float]:
    pose = program.moves[-1].target.pose
    assert pose is not None
    return [round(1e3 * value, 6) for value in pose[:3, 3]]


def test_a_header_hides_no_declaration() -> None:
    program = of(f"MoveL p10,{GO};")
    assert (reasons(program), place(program)) == ([], [400, 0, 500])


def test_offs_goes_along_the_axes_of_the_object() -> None:
    assert place(of(f"MoveL Offs(p10,10,-20,up),{GO};")) == [410, -20, 550]
    work = 'PERS wobjdata w:=[FALSE,TRUE,"",[[100,0,0],[0.70710678,0,0,0.70710678]],[[0,50,0],[1,0,0,0]]];'
    assert place(of(work, f"MoveL Offs(p10,10,0,0),{GO}\\WObj:=w;")) == pytest.approx([100 - 50, 410, 500], abs=1e-4)


def test_reltool_goes_along_the_axes_of_the_tool_and_turns_about_them() -> None:
    program = of(f"MoveL RelTool(p10,10,0,-50\\Rz:=90),{GO};")
    assert place(program) == [390, 0, 550]
    made = program.moves[-1].target.pose
    assert made is not None
    np.testing.assert_allclose(made[:3, 0], [0, 1, 0], atol=1e-12)  # X turns to where Y of the tool was
    turned = of(f"MoveL RelTool(p10,0,0,0\\Rx:=90\\Rz:=90),{GO};").moves[-1].target.pose
    assert turned is not None
    np.testing.assert_allclose(turned[:3, 0], [0, 0, -1], atol=1e-12)  # about X, then the new Z: X turns to the new Y


@pytest.mark.parametrize(("text", "reason"), [
    ("MoveL Offs(p10,0,0,height),", "offset"),
    ("MoveL Offs(p77,0,0,1),", "variable"),
    ("MoveL RelTool(p10,0,0,1\\Rx:=a),", "offset"),
    ("MoveL Offs(CRobT(),0,0,1),", "expression"),
    ("MoveL " + "Offs(" * 3_000 + "p10" + ",0,0,1)" * 3_000 + ",", "expression"),
])  # fmt: skip
def test_offsets_that_are_no_numbers_are_not_guessed(text: str, reason: str) -> None:
    if len(text) > 20_000:
        text = text[:10_000]
    program = of(f"{text}{GO};", f"MoveL p10,{GO};")
    assert reasons(program)[:1] == [(1, reason)]


@pytest.mark.parametrize("held", ["[TRUE,TRUE", "[FALSE,FALSE"])
def test_a_work_object_that_moves_has_no_frame(held: str) -> None:
    work = f'PERS wobjdata w:={held},"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];'
    assert reasons(of(work, f"MoveL p10,{GO}\\WObj:=w;")) == [(2, "base frame")]
    other = 'PERS wobjdata w:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];'
    assert reasons(of(other, "w.oframe.trans.z:=3;", f"MoveL p10,{GO}\\WObj:=w;"))[-1] == (3, "base frame")


def test_moves_on_the_line_of_a_block_are_read_and_the_branch_ends_behind_them() -> None:
    program = of(f"IF n=1 THEN MoveL p10,{GO}; ENDIF", f"IF n=1 MoveL p10,{GO};", f"CASE 1: MoveJ p10,{GO};")
    assert [move.line - len(HEAD.splitlines()) for move in program.moves] == [1, 2, 3]
    kinds = ["branch", "move", "branch", "branch", "move", "branch", "branch", "move"]
    assert [getattr(item, "reason", "move") for item in program.items] == kinds
    plain = of('IF s="MoveL x" THEN', "IF arcL = 1 THEN", f"MoveL p10,{GO};")
    assert reasons(plain) == [(1, "branch"), (2, "branch")]


def test_a_displacement_moves_poses_and_not_joint_values() -> None:
    joints = "MoveAbsJ [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs"
    program = of("PDispSet pe1;", f"MoveL p10,{GO};", f"{joints},{GO};", "PDispOff;", f"MoveL p10,{GO};")
    assert reasons(program) == [(1, "other"), (2, "shifted"), (4, "other")]


def test_instructions_are_no_calls() -> None:
    lines = ["WaitTime 1;", "SetDO do1,1;", "rPick;", '%"a"%;', "VelSet 50,800;", "VelSet 100,5000;", "arcOn:=TRUE;"]
    program = of(*lines, f"MoveL p10,{GO};")
    expected = ["other", "other", "call", "call", "override", "other"]
    assert [reason for _, reason in reasons(program)] == expected
