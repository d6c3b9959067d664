"""Programs of KRL as engineers have them: inline forms, settings behind WITH, blocks, statements over several lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.path.read.krl import read
from rankdrop.path.read.program_file import read_program
from rankdrop.path.read.program_record import Posture, Program

FIRST = "LIN {X 500, Y 100, Z 600, A 90, B 0, C 0}\n"
JOINTS = "PTP {A1 10, A2 -90, A3 90, A4 0, A5 20, A6 0}\n"


def of(text: str, declarations: str = "") -> Program:
    return read(f"DEF a()\n{text}END\n", "a.src", declarations)


def reasons(program: Program) -> dict[int, str]:
    return {item.line: item.reason.value for item in program.skipped}


def places(program: Program) -> list[list[float]]:
    made = [move.target.pose for move in program.moves]
    return [[round(1e3 * value, 6) for value in pose[:3, 3]] for pose in made if pose is not None]


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


def test_values_that_are_left_out_are_those_of_the_move_before() -> None:
    base = "$BASE = {X 10, Y 20, Z 30, A 90, B 0, C 0}\n"
    program = of(f"{base}{FIRST}LIN {{Z 400}}\nLIN {{X 0, A 0, B 90, C 0}}\n{JOINTS}PTP {{A3 45}}\n")
    assert not program.skipped
    # of the base: X of it is Y of the arm, Y of it is −X of the arm
    assert places(program) == [[-90, 520, 630], [-90, 520, 430], [-90, 20, 430]]
    first, second = (program.moves[at].target.pose[:3, :3] for at in (0, 1))
    np.testing.assert_allclose(second, first, atol=1e-15)
    assert program.moves[-1].target.joints == (10, -90, 45, 0, 20, 0)


@pytest.mark.parametrize("text", [
    "LIN {Z 400}\n",
    JOINTS + "LIN {Z 400}\n",
    FIRST + "PTP {A1 3}\n",
    FIRST + "LIN {A 10}\n",
    FIRST + "$BASE = {X 1, Y 0, Z 0, A 0, B 0, C 0}\nLIN {Z 400}\n",
    FIRST + "$TOOL = TOOL_DATA[2]\nLIN {Z 400}\n",
    FIRST + "LIN XP9\nLIN {Z 400}\n",
])  # fmt: skip
def test_values_that_the_move_before_does_not_give_are_not_guessed(text: str) -> None:
    program = of(text)
    assert program.skipped[-1].reason.value == "incomplete"


DAT = """DEFDAT a
DECL E6POS XP1={X 500.0,Y 0.0,Z 600.0,A 180.0,B 0.0,C 180.0,S 2,T 35,E1 0.0,E2 0.0}
DECL FDAT FP0={TOOL_NO 0,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " "}
DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,POINT2[] " "}
DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 100.0,APO_FAC 50.0,ORI_TYP #VAR}
ENDDAT
"""


def test_an_inline_form_is_in_the_base_of_its_fdat() -> None:
    form = ";FOLD PTP P1 Vel=100 % PDAT1 Tool[{0}] Base[{0}];%{{PE}}\n$BWDSTART=FALSE\nPDAT_ACT=PPDAT1\n" \
           "FDAT_ACT=FP{0}\nBAS(#PTP_PARAMS,100)\nPTP XP1\n;ENDFOLD\n"  # fmt: skip
    program = of(form.format(0) + form.format(1), DAT)
    assert places(program) == [[500, 0, 600]]
    assert reasons(program) == {12: "tool frame", 14: "base frame"}


def test_settings_behind_with_are_those_of_one_move() -> None:
    form = "SLIN XP1 WITH $VEL=SVEL_CP(0.3, , LCPDAT1), $TOOL=STOOL2(FP{0}), $BASE=SBASE(FP{0}.BASE_NO), " \
           "$IPO_MODE=SIPO_MODE(FP{0}.IPO_FRAME), $APO=SAPO(LCPDAT1) C_SPL\n"  # fmt: skip
    joint = "SPTP XP1 WITH $VEL_AXIS[1]=SVEL_JOINT(25.0), $TOOL=STOOL2(FP0), $BASE=SBASE(FP0.BASE_NO)\n"
    program = of(form.format(0) + form.format(1) + joint, DAT)
    assert [item.reason.value for item in program.skipped] == ["tool frame", "base frame"]
    assert [move.line for move in program.moves] == [2, 4]
    assert (program.moves[0].speed.linear, program.moves[1].speed.share) == (0.3, 0.25)


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


def test_elements_of_arrays_bits_and_numbers_of_declarations() -> None:
    text = "DECL E6POS P[2]\nDECL REAL V = 0.25\nP[1]={X 1, Y 2, Z 3, A 0, B 0, C 0, S 'B010', T 'B000010'}\n" \
           "$VEL.CP=V\nLIN P[1]\nPTP P[1]\nLIN P[2]\n"  # fmt: skip
    program = of(text)
    assert places(program) == [[1, 2, 3]] * 2
    assert program.moves[0].speed.linear == 0.25
    assert program.moves[1].target.posture == Posture(signs=2)
    assert reasons(program) == {8: "variable"}
    assert reasons(of(text + "P[I]={X 9, Y 2, Z 3, A 0, B 0, C 0}\n"))[6] == "changed"
    assert reasons(of(text + "P[1].Z=9\n"))[6] == "changed"


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
