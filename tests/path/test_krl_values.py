"""Values of KRL: those left out, elements of arrays, bits, and settings behind WITH."""

from __future__ import annotations

import numpy as np
import pytest

from path.krl_text import DAT, FIRST, JOINTS, of, places, reasons
from rankdrop.path.read.program_record import Posture


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
