"""Programs of KRL as engineers have them: inline forms, settings behind WITH, blocks, statements over several lines."""

from __future__ import annotations

from pathlib import Path

from path.krl_text import DAT, FIRST, JOINTS, of, places, reasons
from rankdrop.path.read.program_file import read_program


def test_a_statement_goes_on_while_a_bracket_is_open() -> None:
    text = "LIN {X 500,\n  Y 100, ; to the left\n\n  Z 600, A 90,\nB 0, C 0} C_DIS\n"
    text += "DECL E6POS XP={X 1,\nY 2, Z 3, A 0, B 0, C 0}\nPTP XP\n"
    program = of(text)
    assert not program.skipped
    assert [(move.line, move.kind, move.blend) for move in program.moves] == [(2, "line", True), (9, "joint", False)]
    assert places(program) == [[500, 100, 600], [1, 2, 3]]


def test_a_bracket_that_is_never_closed_ends_at_the_next_statement() -> None:
    program = of("LIN {X 500, Y 100,\n" + JOINTS)
    assert reasons(program) == {2: "expression"}
    assert [move.line for move in program.moves] == [3]




def test_straight_lines_of_a_spline_block_are_read_and_its_curves_are_not() -> None:
    text = (
        "$VEL.CP=1\n"
        + FIRST
        + "SPLINE WITH $VEL.CP=0.2\nSLIN {X 500, Y 0, Z 600, A 90, B 0, C 0}\nSPL XP1\nENDSPLINE\n"
        + FIRST
    )
    program = of(text + "PTP_SPLINE\nSPTP XP1\nENDSPLINE\n", DAT)
    assert reasons(program) == {6: "spline", 10: "spline"}
    assert [move.speed.linear for move in program.moves] == [1.0, 0.2, 1.0]


def test_poses_of_a_fixed_tool_are_not_read() -> None:
    program = of("$IPO_MODE=#TCP\n" + FIRST + "$IPO_MODE=#BASE\n" + FIRST)
    assert reasons(program) == {3: "base frame"}
    assert len(program.moves) == 1


def test_a_move_to_where_the_arm_is_does_nothing() -> None:
    assert [item.line for item in of("PTP $AXIS_ACT\n" + JOINTS).items] == [3]


def test_the_share_of_the_axes_is_known_where_all_have_the_same() -> None:
    every = "".join(f"$VEL_AXIS[{axis}]=30\n" for axis in range(1, 7))
    assert of(every + JOINTS).moves[0].speed.share == 0.3
    assert of("BAS(#VEL_PTP,50)\n$VEL_AXIS[1]=30\n" + JOINTS).moves[0].speed.share is None


def test_small_letters_and_a_dat_file_in_capitals(tmp_path: Path) -> None:
    (tmp_path / "a.src").write_text(
        "def a()\nptp xp1\n$vel.cp=0.1\nlin {x 500, y 1, z 600, a 180, b 0, c 180} c_dis\nend\n"
    )
    (tmp_path / "a.DAT").write_text(DAT)
    program = read_program(tmp_path / "a.src")
    assert [(move.kind, move.speed.linear, move.blend) for move in program.moves] == [
        ("joint", None, False), ("line", 0.1, True)]  # fmt: skip
