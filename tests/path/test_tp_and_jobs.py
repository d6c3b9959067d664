"""Programs of FANUC TP and INFORM as engineers have them: offsets, skips, increments, shifts, wrist joint motion."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.path.read import fanuc_tp, inform
from rankdrop.path.read.program_record import Program

POSITIONS = """/POS
P[1:"start"]{
   GP1:
    UF : 0, UT : 0,     CONFIG : 'N U T, 0, 0, 0',
    X =   420.000  mm,  Y =   -80.000  mm,  Z =   180.000  mm,
    W =   180.000 deg,  P =     0.000 deg,  R =     0.000 deg
};
P[2]{
   GP1:
    UF : 0, UT : 0,     CONFIG : 'N U T, 0, 0, 0',
    X =     0.000  mm,  Y =     0.000  mm,  Z =    50.000  mm,
    W =     0.000 deg,  P =     0.000 deg,  R =     0.000 deg
};
P[3]{
   GP1:
    UF : 0, UT : 0,
    J1=    10.000 deg, J2=   5.000 deg, J3=  -20.000 deg,
    J4=     0.000 deg, J5=  -50.000 deg, J6=    0.000 deg
};
/END
"""


def listing(*lines: str) -> Program:
    numbered = "".join(f"  {count}:{line} ;\n" for count, line in enumerate(lines, start=1))
    return fanuc_tp.read(f"/MN\n{numbered}{POSITIONS}", "a.ls")


def job(*lines: str) -> Program:
    head = (
        "/JOB\n//NAME A\n//POS\n///NPOS 2,0,0,0,0,0\n///TOOL 0\n///POSTYPE BASE\n///RECTAN\n///RCONF 0,0,0,0,0,0,0,0\n"
    )
    head += "C00000=400.000,100.000,200.000,180.0000,0.0000,0.0000\n//INST\n///DATE 2024/01/01 10:00\nNOP\n"
    return inform.read(head + "".join(f"{line}\n" for line in lines) + "END\n", "a.jbi")


def reasons(program: Program) -> list[str]:
    return [item.reason.value for item in program.skipped]


@pytest.mark.parametrize(("rest", "reason"), [
    ("Offset,PR[1]", "offset"), ("Tool_Offset,PR[2]", "offset"), ("Skip,LBL[1]", "ends early"), ("Wjnt", "other move"),
    ("RTCP", "other move"), ("COORD", "other move"), ("INC", "relative"), ("ACC50", None), ("TA  0.10sec,CALL X", None),
])  # fmt: skip
def test_words_behind_a_target_that_lead_elsewhere(rest: str, reason: str | None) -> None:
    program = listing(f'L P[1:"start"] 250mm/sec FINE {rest}')
    assert reasons(program) == [reason] * (reason is not None)
    assert len(program.moves) == (reason is None)


def test_increments_are_added_to_the_target_before() -> None:
    program = listing("L P[1] 250mm/sec FINE", "L P[2] 100mm/sec FINE INC", "L P[2] 100mm/sec CNT50 INC")
    assert not program.skipped
    heights = [round(float(move.target.pose[2, 3]), 9) for move in program.moves if move.target.pose is not None]
    assert heights == [0.18, 0.23, 0.28]
    last = program.moves[-1].target.pose
    assert last is not None
    np.testing.assert_allclose(last[:3, :3], np.diag([1, -1, -1]), atol=1e-12)
    joints = listing("J P[3] 50% FINE", "J P[3] 50% FINE INC")
    assert joints.moves[-1].target.joints == (20, 10, -40, 0, -100, 0)


@pytest.mark.parametrize(("lines", "reason"), [
    (("J P[3] 50% FINE", "L P[2] 9mm/sec FINE INC"), "after joint values"),
    (("L P[1] 9mm/sec FINE", "J P[3] 50% FINE INC"), "after a pose"),
    (("L P[1] 9mm/sec FINE", "L P[1] 9mm/sec FINE INC"), "relative turn"),
    (("L P[1] 9mm/sec FINE", "LBL[1]", "L P[2] 9mm/sec FINE INC"), "relative"),
    (("OVERRIDE=50%", "L P[1] 9mm/sec FINE"), "override"),
])  # fmt: skip
def test_increments_that_are_not_known_are_not_guessed(lines: tuple[str, ...], reason: str) -> None:
    assert reason in reasons(listing(*lines))


def test_jobs_name_moves_that_end_elsewhere() -> None:
    shift = ["SFTON P001 BF", "MOVL C00000 V=100.0", "SFTOF", "MOVL C00000 V=100.0 PL=0"]
    program = job(
        "'approach", *shift, "MOVL C00000 V=50.0 UNTIL IN#(1)=ON", "+MOVJ C00000 VJ=10.00", "SMOVL C00000 V=9.0"
    )
    assert reasons(program) == ["other", "shifted", "other", "ends early", "other move", "other move"]
    assert [(move.speed.linear, move.blend) for move in program.moves] == [(0.1, False)]


def test_a_line_is_shown_with_its_number_in_the_program() -> None:
    """An engineer looks for 3:L on the pendant, not for the fourth line of the listing."""
    lines = "   1:  WAIT .50(sec) ;\n   3:L P[1] 250mm/sec FINE ;\n"
    text = f"/PROG A\n/MN\n{lines}/POS\nP[1]{{\n GP1:\n J1= 0 deg, J2= 0 deg\n}};\n/END\n"
    program = fanuc_tp.read(text, "a.ls")
    shown = [(item.line, item.text) for item in program.items]
    assert shown == [(3, "1:WAIT .50(sec)"), (4, "3:L P[1] 250mm/sec FINE")]
