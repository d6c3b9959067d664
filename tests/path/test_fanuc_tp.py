"""Listings of FANUC TP as engineers have them: offsets, skips, increments, wrist joint motion; how joint 3 counts."""

from __future__ import annotations

import numpy as np
import pytest

from path.program_data import ASK, DATA
from path.read_programs import about, moves
from rankdrop.kinematics import pose
from rankdrop.path.check.program import check_program
from rankdrop.path.read import fanuc_tp
from rankdrop.path.read.program_file import read_program
from rankdrop.path.read.program_record import Program
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.open import open_robot

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


def test_a_line_is_shown_with_its_number_in_the_program() -> None:
    """An engineer looks for 3:L on the pendant, not for the fourth line of the listing."""
    lines = "   1:  WAIT .50(sec) ;\n   3:L P[1] 250mm/sec FINE ;\n"
    text = f"/PROG A\n/MN\n{lines}/POS\nP[1]{{\n GP1:\n J1= 0 deg, J2= 0 deg\n}};\n/END\n"
    program = fanuc_tp.read(text, "a.ls")
    shown = [(item.line, item.text) for item in program.items]
    assert shown == [(3, "1:WAIT .50(sec)"), (4, "3:L P[1] 250mm/sec FINE")]


def test_fanuc_turns_about_fixed_axes() -> None:
    program = read_program(DATA / "tp.ls")
    found = moves(program)[8].target.pose
    # turns about fixed axes are applied from the right to the left
    np.testing.assert_allclose(found[:3, :3], about("z", 5) @ about("y", -10) @ about("x", 178), atol=1e-15)
    np.testing.assert_allclose(found[:3, 3], [0.42, -0.08, 0.18], atol=1e-15)
    assert moves(program)[7].target.joints == (0, 10, -20, 0, -50, 0)
    assert moves(program)[7].speed.share == 0.5
    assert moves(program)[8].speed.linear == 0.25
    assert moves(program)[10].speed.linear == pytest.approx(12.0 / 60.0), "1200 cm/min"
    assert [one.blend for one in program.moves] == [False, True, False]


@pytest.mark.slow
def test_fanuc_counts_joint_3_from_the_horizontal_and_z_from_axis_2() -> None:
    """The forearm keeps its direction while J2 moves alone; the world frame is at the height of axis 2."""
    arm = open_robot("lrmate200id")

    def program(a: str, b: str) -> Program:
        blocks = "".join(f"P[{k}]{{\n GP1:\n UF : 0, UT : 0,\n {text}\n}};\n" for k, text in ((1, a), (2, b)))
        return fanuc_tp.read(f"/MN\n 1:J P[1] 100% FINE ;\n 2:J P[2] 100% FINE ;\n/POS\n{blocks}/END\n", "a.ls")

    joints = "J1=0 deg, J2={} deg, J3=-20 deg, J4=5 deg, J5=-50 deg, J6=8 deg"
    found = check_program(arm, program(joints.format(0), joints.format(25)), ASK)
    ends = found.parts[0].check.curve.control[0]
    first, second = pose(arm, ends)
    np.testing.assert_allclose(first[:3, :3], second[:3, :3], atol=1e-12)
    assert abs(first[2, 3] - second[2, 3]) > 0.01
    x, y, z = 1e3 * (first[:3, 3] - [0, 0, 0.330])  # 330 mm: data sheet of the LR Mate 200iD
    roll, pitch, yaw = np.degrees([np.arctan2(first[2, 1], first[2, 2]), -np.arcsin(first[2, 0]),
                                   np.arctan2(first[1, 0], first[0, 0])])  # fmt: skip
    posed = f"X={x:.9f} mm, Y={y:.9f} mm, Z={z:.9f} mm, W={roll:.9f} deg, P={pitch:.9f} deg, R={yaw:.9f} deg"
    again = check_program(arm, program(joints.format(0), posed), ASK)
    assert again.raised == pytest.approx(0.330)
    assert len(again.parts) == 1
    step = np.ptp(again.parts[0].check.curve.control[:, :], axis=(0, 1))
    assert step.max() < 1e-9, "the second move leads to where the arm is"


def test_joint_values_of_fanuc_need_axes_2_and_3_against_each_other() -> None:
    with pytest.raises(TrajectoryError, match="line 7: J3 is counted from the horizontal"):
        check_program(open_robot("irb120"), read_program(DATA / "tp.ls"), ASK)
