"""Programs of RAPID as engineers have them: headers, Offs, RelTool, work objects, displacements, moves in blocks."""

from __future__ import annotations

from path.rapid_text import GO, HEAD, of, place, reasons


def test_a_header_hides_no_declaration() -> None:
    program = of(f"MoveL p10,{GO};")
    assert (reasons(program), place(program)) == ([], [400, 0, 500])


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
