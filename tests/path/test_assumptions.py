"""What moves of a program are followed with where its file does not tell: nothing of it is called proven.

Configurations are compared with `pose` and joint values by hand; the lines are those of controllers' manuals.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from path.read_programs import checked, written
from rankdrop.kinematics import pose
from rankdrop.path.check.program import ProgramCheck
from rankdrop.path.read.program_file import read_program
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.open import open_robot

KRL = "DEF a()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\n$VEL.CP=0.3\n"
FIRST = "PTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0}\n"
RAPID = "MODULE M\nPROC main()\nMoveAbsJ [[0,0,0,0,30,0],[0,9E9,9E9,9E9,9E9,9E9]],v1000,fine,tool0;\n"
UNUSED = "[9E9,9E9,9E9,9E9,9E9,9E9]"


def found(name: str, text: str, arm: str, tmp_path: Path) -> ProgramCheck:
    return checked(open_robot(arm), written(tmp_path, name, text))


@pytest.mark.parametrize(("external", "assumed"), [
    (("E1 0.0", "E1 0.0"), []), (("", ""), []), (("E1 0.0", "E1 1500.0"), [6]), (("E1 10.0", "E1 10.0"), [5, 6]),
])  # fmt: skip
def test_external_axes_away_from_zero_or_moving_leave_krl_undecided(
    external: tuple[str, str], assumed: list[int], tmp_path: Path
) -> None:
    targets = [f"{{X 705,Y {y},Z 900,A 0,B 90,C 0,S 2,T 10{',' if e else ''}{e}}}"
               for y, e in zip((-200, -100), external, strict=True)]  # fmt: skip
    check = found("a.src", f"{KRL}PTP {targets[0]}\nLIN {targets[1]}\nEND\n", "kr10r1100", tmp_path)
    assert list(check.assumptions.get("external axes", ())) == assumed
    assert check.verdict == ("undecided" if assumed else "free")
    assert check.holds is not bool(assumed)
    assert ("are taken not to carry the arm" in check.sentence) == bool(assumed)


@pytest.mark.parametrize(("value", "moved"), [(0, False), (1500, True)])
def test_external_axes_of_rapid(value: int, moved: bool, tmp_path: Path) -> None:
    target = f"[[474,-150,632],[0.707106781,0,0.707106781,0],[-1,0,-1,0],[{value},9E9,9E9,9E9,9E9,9E9]]"
    check = found("a.mod", f"{RAPID}MoveJ {target},v500,fine,tool0;\nENDPROC\nENDMODULE\n", "irb120", tmp_path)
    assert ("external axes" in check.assumptions) == moved


def test_a_group_of_a_positioner_that_stands_at_zero_carries_nothing(tmp_path: Path) -> None:
    def listing(angle: float) -> str:
        place = "X = 450.0 mm, Y = -200.0 mm, Z = 100.0 mm,\nW = 180.0 deg, P = 0.0 deg, R = 0.0 deg"
        return (
            "/PROG A\n/MN\n   1:J P[1] 50% FINE ;\n/POS\n"
            f"P[1]{{\n   GP1:\n UF : 0, UT : 0, CONFIG : 'N U T, 0, 0, 0',\n {place}\n"
            f"   GP2:\n UF : 0, UT : 1,\n J1= {angle} deg\n}};\n/END\n"
        )

    still, turned = (read_program(written(tmp_path, "a.ls", listing(angle))) for angle in (0.0, 90.0))
    assert still.moves[0].assumed == frozenset()
    assert turned.moves[0].assumed == {"external axes"}
    assert turned.moves[0].target.pose == pytest.approx(still.moves[0].target.pose)


def test_a_base_axis_of_inform_that_moves_is_named(tmp_path: Path) -> None:
    job = (
        "/JOB\n//POS\n///TOOL 0\n///POSTYPE ROBOT\n///RECTAN\nC00000=450,-150,100,180,0,0\nC00001=450,150,100,180,0,0\n"
        "//INST\nMOVJ C00000 VJ=50.00\nMOVL C00001 BC00001 V=250.0\n"
    )
    program = read_program(written(tmp_path, "a.jbi", job))
    assert [sorted(move.assumed) for move in program.moves] == [[], ["external axes"]]


@pytest.mark.parametrize(("values", "assumed"), [
    (("0.0,0.0", "0.0,0.0"), [[], []]), (("0.0,0.0", "300.0,0.0"), [[], ["external axes"]]),
    (("300.0,0.0", "300.0,0.0"), [["external axes"], ["external axes"]]),
])  # fmt: skip
def test_a_base_axis_of_inform_counts_by_its_values(
    values: tuple[str, str], assumed: list[list[str]], tmp_path: Path
) -> None:
    job = (
        "/JOB\n//POS\n///TOOL 0\n///POSTYPE ROBOT\n///RECTAN\nC00000=450,-150,100,180,0,0\n"
        f"C00001=450,150,100,180,0,0\n///POSTYPE PULSE\n///PULSE\nBC00000={values[0]}\nBC00001={values[1]}\n"
        "//INST\nMOVJ C00000 BC00000 VJ=50.00\nMOVL C00001 BC00001 V=250.0\n"
    )
    program = read_program(written(tmp_path, "a.jbi", job))
    assert [sorted(move.assumed) for move in program.moves] == assumed


@pytest.mark.parametrize(("data", "assumed"), [
    ("DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 100.0}\n", []),
    ("LDAT LCPDAT1={VEL 2.0,ORI_TYP #JOINT}\n", ["turns"]),
    ("DECL LDAT LCPDAT1={VEL 2.0}\nLCPDAT1={VEL 1.0}\n", ["turns"]),
    ("", ["turns"]),
])  # fmt: skip
def test_line_data_turn_about_one_axis_unless_they_say_otherwise(
    data: str, assumed: list[str], tmp_path: Path
) -> None:
    written(tmp_path, "a.dat", f"DEFDAT A\n{data}ENDDAT\n")
    line = "LIN {X 600,Y 0,Z 900,A 0,B 90,C 0}\n"
    program = read_program(written(tmp_path, "a.src", f"{KRL}{FIRST}LDAT_ACT=LCPDAT1\n{line}END\n"))
    assert sorted(program.moves[-1].assumed) == assumed


@pytest.mark.parametrize(("first", "assumed"), [
    ("movel(p[-0.4,-0.2,0.5,3.14159,0,0], v=0.1)", ["tool"]), ("movej([0.3,-1.5,1.57,-1.57,-1.57,0])", []),
])  # fmt: skip
def test_a_part_begins_with_the_assumptions_of_the_one_before(first: str, assumed: list[str], tmp_path: Path) -> None:
    """After a line that is not read the arm goes on from where it was, or from joint values."""
    text = (
        "set_tcp(p[0,0,0,0,0,0])\nmovel(p[-0.4,-0.2,0.4,3.14159,0,0], v=0.1)\nset_tcp(gripper)\n"
        f"movel(p[-0.4,-0.3,0.4,3.14159,0,0], v=0.1)\nset_tcp(p[0,0,0,0,0,0])\nmovel(target)\n{first}\n"
    )
    check = found("a.script", text, "ur5e", tmp_path)
    assert len(check.parts) == 2
    assert [sorted(move.assumed) for move in check.moves] == [[], ["tool"], assumed]
    assert check.assumptions == {"tool": (4,)}


@pytest.mark.parametrize("where", ["$ORI_TYPE=#CONSTANT\n", "behind", "LDAT_ACT=LCPDAT1\n"])
def test_a_constant_orientation_is_that_at_the_beginning_of_the_line(where: str, tmp_path: Path) -> None:
    """The target's angles are left out by the controller: by them the line would cross A5 = 0."""
    before, behind = ("", " WITH $ORI_TYPE=#CONSTANT") if where == "behind" else (where, "")
    text = f"{KRL}{FIRST}{before}SLIN {{X 600,Y 0,Z 900,A 0,B 90,C 0}}{behind}\nEND\n"
    if "LDAT" in where:
        data = "LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 100.0,APO_FAC 50.0,ORI_TYP #CONSTANT}"
        written(tmp_path, "a.dat", f"DEFDAT A\nDECL LDAT {data}\nENDDAT\n")
    arm = open_robot("kr10r1100")
    check = found("a.src", text, "kr10r1100", tmp_path)
    assert check.verdict == "free"
    curve = check.parts[0].check.curve
    ends = pose(arm, np.stack([curve.control[0, 0], curve.control[-1, -1]]))
    assert ends[1, :3, :3] == pytest.approx(ends[0, :3, :3], abs=1e-8)
    assert ends[1, :3, 3] == pytest.approx([0.6, 0.0, 0.9], abs=1e-8)
    varied = found("a.src", text.replace("CONSTANT", "VAR").replace("LDAT_ACT=LCPDAT1\n", ""), "kr10r1100", tmp_path)
    assert varied.verdict == "crossing"


def test_a_wrist_that_is_turned_in_proportion_is_not_called_too_fast(tmp_path: Path) -> None:
    line = "PTP {X 705,Y -200,Z 997,A 0,B 90,C 0,S 2,T 10}\n{}LIN {X 705,Y 200,Z 997,A 0,B 90,C 0}\nEND\n"
    plain = found("a.src", KRL.replace("0.3", "2.0") + line.replace("{}", ""), "kr10r1100", tmp_path)
    turned = found("a.src", KRL.replace("0.3", "2.0") + line.replace("{}", "$ORI_TYPE=#JOINT\n"), "kr10r1100", tmp_path)
    assert (plain.verdict, turned.verdict) == ("too fast", "undecided")
    assert turned.sentence.startswith("Undecided: $ORI_TYPE is not known, or lets the tool turn otherwise in line 7")
    assert "As it was read: not possible at the programmed speed" in turned.sentence


def test_the_mode_lasts_until_it_is_set_anew(tmp_path: Path) -> None:
    line = "LIN {X 600,Y 0,Z 900,A 0,B 90,C 0}\n"
    text = f"{KRL}{FIRST}$ORI_TYPE=#JOINT\n{line}$ORI_TYPE=#CONSTANT\n{line}BAS(#INITMOV,0)\n{line}END\n"
    _, *moves = read_program(written(tmp_path, "a.src", text)).moves
    assert [(move.keeps_turn, sorted(move.assumed)) for move in moves] == [
        (False, ["turns"]), (True, []), (False, [])]  # fmt: skip
    joint = f"{KRL}$ORI_TYPE=#CONSTANT\n{FIRST}$ORI_TYPE=#JOINT\n{FIRST}END\n"
    first, second = read_program(written(tmp_path, "b.src", joint)).moves
    assert (first.keeps_turn, second.assumed) == (False, frozenset())


@pytest.mark.parametrize(("mode", "known"), [("VAR", True), ("CONSTANT", False)])
def test_after_a_line_of_constant_orientation_a_turn_relative_to_its_target_is_not_known(
    mode: str, known: bool, tmp_path: Path
) -> None:
    line = "LIN {X 600,Y 0,Z 900,A 0,B 90,C 0}\nLIN_REL {X 0,Y 0,Z 10,A 0,B 5,C 0} #TOOL\n"
    text = f"{KRL}$ORI_TYPE=#{mode}\n{line}END\n"
    assert (len(read_program(written(tmp_path, "a.src", text)).moves) == 2) == known


@pytest.mark.parametrize(("mode", "assumed"), [
    ("SingArea \\Wrist;", True), ("SingArea \\LockAxis4;", True), ("SingArea \\Off;", False), ("", False),
    ("SingArea \\Wrist;\nSingArea \\Off;", False),
])  # fmt: skip
def test_lines_with_singarea_are_undecided(mode: str, assumed: bool, tmp_path: Path) -> None:
    turn = "[0.707106781,0,0.707106781,0]"
    text = (
        f"{RAPID}{mode}\nMoveJ [[474,-150,632],{turn},[-1,0,-1,0],{UNUSED}],v500,fine,tGun;\n"
        f"MoveL [[474,150,632],{turn},[0,-1,0,0],{UNUSED}],v50,fine,tGun;\nENDPROC\nENDMODULE\n"
        "PERS tooldata tGun:=[TRUE,[[0,0,100],[1,0,0,0]],[1.2,[0,0,40],[1,0,0,0],0,0,0]];\n"
    )
    check = found("a.mod", text, "irb120", tmp_path)
    assert ("wrist" in check.assumptions) == assumed
    assert [move.kind for move in check.program.moves if "wrist" in move.assumed] == ["line"] * assumed
    assert [move.verdict for move in check.moves][-1] == "too fast"
    assert check.verdict == ("undecided" if assumed else "too fast")


@pytest.mark.parametrize(("other", "mode", "assumed"), [
    (0, "", False), (2, "", True), (2, "ConfL \\Off;\n", False), (2, "ConfL \\Off;\nConfL \\On;\n", True),
])  # fmt: skip
def test_a_line_that_arrives_in_another_configuration(other: int, mode: str, assumed: bool, tmp_path: Path) -> None:
    """cf1, cf4 and cf6 are the quarter turns, rounded down, of joints 1, 4 and 6 where the line ends."""
    def text(mode: str, stated: str) -> str:
        target = f"[[450,-150,532],[0.707106781,0,0.707106781,0],[{stated},0],{UNUSED}]"
        return f"{RAPID}{mode}MoveL {target},v50,fine,tool0;\nENDPROC\nENDMODULE\n"

    plain = found("a.mod", text("ConfL \\Off;\n", "0,0,0"), "irb120", tmp_path)
    (part,) = plain.parts
    assert part.ended is None
    assert part.check is not None
    first, fourth, sixth = np.floor(part.check.curve.control[-1, -1][[0, 3, 5]] / (np.pi / 2)).astype(int).tolist()
    check = found("a.mod", text(mode, f"{first},{fourth + other},{sixth}"), "irb120", tmp_path)
    assert ("arrival" in check.assumptions) == assumed
    assert (plain.verdict, check.verdict) == ("free", "undecided" if assumed else "free")


@pytest.mark.parametrize(("posture", "assumed"), [("N U T", False), ("F U T", True), ("N D B", True)])
def test_another_posture_of_config_is_not_read(posture: str, assumed: bool, tmp_path: Path) -> None:
    text = (
        "/PROG A\n/MN\n   1:J P[1] 50% FINE ;\n   2:L P[2] 250mm/sec FINE ;\n/POS\n"
        + "".join(
            f"P[{k}]{{\n   GP1:\n UF : 0, UT : 0, CONFIG : '{posture}, 0, 0, 0',\n X = 450.0 mm, Y = {y} mm, "
            "Z = 100.0 mm,\nW = 180.0 deg, P = 0.0 deg, R = 0.0 deg\n};\n" for k, y in ((1, -200.0), (2, 200.0)))
        + "/END\n"
    )  # fmt: skip
    check = found("a.ls", text, "lrmate200id", tmp_path)
    assert ("configuration" in check.assumptions) == assumed
    assert check.verdict == ("undecided" if assumed else "free")
    assert check.parts[0].check is not None
    first = check.parts[0].check.curve.control[0, 0]
    started = checked(open_robot("lrmate200id"), written(tmp_path, "a.ls", text), start=first)
    assert started.assumptions == {}


@pytest.mark.parametrize(("turn", "assumed"), [(np.pi, True), (3.0, False)])
def test_half_a_turn_has_two_ways_round(turn: float, assumed: bool, tmp_path: Path) -> None:
    text = f"movel(p[-0.4,-0.3,0.4,0,3.14159265,0], v=0.1)\nmovel(p[-0.4,-0.3,0.35,{turn},0,0], v=0.1)\n"
    if not assumed:
        text = "movel(p[-0.4,-0.3,0.4,3.14159265,0,0], v=0.1)\nmovel(p[-0.4,-0.3,0.35,3.0,0,0], v=0.1)\n"
    check = found("a.script", text, "ur5e", tmp_path)
    assert ("half a turn" in check.assumptions) == assumed
    placed = checked(open_robot("ur5e"), written(tmp_path, "a.script", text), task="position")
    assert placed.assumptions == {}


def test_where_the_tip_decides_several_tools_leave_it_open(tmp_path: Path) -> None:
    """Singularities of the whole pose are those of the arm with any tool; those of the position are not."""
    text = (
        "set_tcp(p[0,0,0.1,0,0,0])\nmovel(p[-0.4,-0.2,0.4,3.14159,0,0], v=0.1)\n"
        "set_tcp(p[0,0,0.2,0,0,0])\nmovel(p[-0.4,-0.3,0.4,3.14159,0,0], v=0.1)\n"
    )
    path = written(tmp_path, "a.script", text)
    assert checked(open_robot("ur5e"), path).assumptions == {}
    assert checked(open_robot("ur5e"), path, task="position").assumptions == {"tool": (2, 4)}


def test_joint_values_end_what_an_unknown_tool_leaves_open(tmp_path: Path) -> None:
    """The move to joint values begins where the tool decides; what comes after it does not depend on it."""
    text = (
        "set_tcp(gripper)\nmovej([0.3,-1.57,1.57,-1.57,-1.57,0])\nmovel(p[-0.4,-0.3,0.4,3.14159,0,0], v=0.1)\n"
        "movej([0.3,-1.57,1.57,-1.57,-1.57,0])\nmovej([0.4,-1.5,1.5,-1.5,-1.5,0])\n"
    )
    check = found("a.script", text, "ur5e", tmp_path)
    assert [sorted(move.assumed) for move in check.moves] == [[], ["tool"], ["tool"], []]
    assert check.assumptions == {"tool": (3,)}
    assert check.verdict == "undecided"
    given = checked(open_robot("ur5e"), written(tmp_path, "a.script", text), at_tool_point=True)
    assert given.assumptions == {}
    assert given.verdict == "free"


def test_what_is_certain_stays_certain(tmp_path: Path) -> None:
    """A joint move that crosses the wrist, and a line of an unknown tool behind it."""
    text = (
        "set_tcp(gripper)\nmovej([0.3,-1.57,1.57,-1.57,-0.5,0])\nmovej([0.3,-1.57,1.57,-1.57,0.5,0])\n"
        "movel(p[-0.4,-0.3,0.4,3.14159,0,0], v=0.1)\n"
    )
    check = found("a.script", text, "ur5e", tmp_path)
    assert check.verdict == "crossing"
    assert check.sentence.startswith("Crosses a singularity once (proven)")
    assert "Not certain: the tool of line 4 is not in the file" in check.sentence


@pytest.mark.parametrize(("first", "verdict"), [(0, "touching"), (-40, "crossing")])
def test_a_joint_move_may_begin_at_a_singularity_or_cross_it(first: int, verdict: str, tmp_path: Path) -> None:
    """KUKA's HOME has A5 = 0: a program of PTP moves that begins there has nothing to mend."""
    moves = f"PTP {{A1 0,A2 -90,A3 90,A4 0,A5 {first},A6 0}}\nPTP {{A1 30,A2 -80,A3 100,A4 0,A5 40,A6 0}}\n"
    check = found("a.src", f"{KRL}{moves}END\n", "kr10r1100", tmp_path)
    assert check.verdict == verdict
    assert any("a joint move may: nothing needs to be done there" in line for line in check.summary)


@pytest.mark.parametrize(("line", "words"), [
    ("movej([0,-90,90,-90,-90,0])", "joint values look like degrees"),
    ("movel(p[300,200,300,0,3.14,0])", "lengths look like millimetres"),
])  # fmt: skip
def test_a_script_in_degrees_or_millimetres_is_refused_with_its_line(line: str, words: str, tmp_path: Path) -> None:
    text = f"movej([0.3,-1.57,1.57,-1.57,-1.57,0])\n{line}\n"
    with pytest.raises(TrajectoryError, match=words) as refused:
        read_program(written(tmp_path, "a.script", text))
    assert "line 2" in str(refused.value)
    counts = "numbers = [100, 200, 300]\n"  # no target
    assert len(read_program(written(tmp_path, "b.script", counts + text.splitlines()[0])).moves) == 1
