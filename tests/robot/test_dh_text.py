"""Tables as they stand in code, in papers and in questions: the arm is that of the table, computed here another way.

Numbers of real tables: uw-biorobotics/IKBT#39 (printed by Robotics Toolbox), petercorke/robotics-toolbox-python#286
(UR5 as three lists), KUKA KR 210 as many courses write it, PUMA 560 as MATLAB prints it.
"""

from __future__ import annotations

from math import inf, pi
from pathlib import Path

import numpy as np
import pytest

from rankdrop.errors import RobotError
from rankdrop.kinematics import jacobian, pose
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot

H = pi / 2
Row = tuple[float, float, float, float]


def turned(axis: int, angle: float) -> np.ndarray:
    matrix = np.eye(4)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    matrix[[i, j], [i, j]] = np.cos(angle)
    matrix[i, j], matrix[j, i] = -np.sin(angle), np.sin(angle)
    return matrix


def moved(axis: int, length: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[axis, 3] = length
    return matrix


def tip(rows: list[Row], q: np.ndarray, convention: str, kinds: str) -> np.ndarray:
    """Pose of the last frame, (a, alpha, d, theta) by row; rows behind the last joint are fixed."""
    place = np.eye(4)
    values = dict(enumerate(q))
    for number, (a, alpha, d, theta) in enumerate(rows):
        value = values.get(number, 0.0)
        slides = kinds[number : number + 1] == "P"
        turn = turned(2, theta + (0.0 if slides else value)) @ moved(2, d + (value if slides else 0.0))
        twist = moved(0, a) @ turned(0, alpha)
        place = place @ (twist @ turn if convention == "modified" else turn @ twist)
    return place


PRINTED = """\
DHRobot: KINOVA, 6 joints (PPRRRR), standard DH parameters
┏━━━━━━━┳━━━━━━━━━━┳━━━━━━┳━━━━━━━━━━━━━━━━━━━━━┳━━━━━━━━━┳━━━━━━━━┓
┃  θⱼ   ┃    dⱼ    ┃  aⱼ  ┃         ⍺ⱼ          ┃   q⁻    ┃   q⁺   ┃
┣━━━━━━━╋━━━━━━━━━━╋━━━━━━╋━━━━━━━━━━━━━━━━━━━━━╋━━━━━━━━━╋━━━━━━━━┫
┃0.0°   ┃       q1 ┃    0 ┃              -90.0° ┃   -0.33 ┃   0.33 ┃
┃-90.0° ┃       q2 ┃    0 ┃               90.0° ┃   -0.33 ┃   0.33 ┃
┃ q3    ┃      0.1 ┃    0 ┃               90.0° ┃ -180.0° ┃ 180.0° ┃
┃ q4    ┃     0.01 ┃ 0.25 ┃ 29.999999999999996° ┃  -30.0° ┃  90.0° ┃
┃ q5    ┃     0.07 ┃    0 ┃ 239.99999999999997° ┃ -180.0° ┃ 180.0° ┃
┃ q6    ┃ -0.05831 ┃ 0.05 ┃                0.0° ┃  -60.0° ┃  30.0° ┃
┗━━━━━━━┻━━━━━━━━━━┻━━━━━━┻━━━━━━━━━━━━━━━━━━━━━┻━━━━━━━━━┻━━━━━━━━┛
"""
MATLAB_PRINTED = """\
Puma 560 [Unimation]:: 6 axis, RRRRRR, stdDH, fastRNE
+---+-----------+-----------+-----------+-----------+-----------+
| j |     theta |         d |         a |     alpha |    offset |
+---+-----------+-----------+-----------+-----------+-----------+
|  1|         q1|          0|          0|     1.5708|          0|
|  2|         q2|          0|     0.4318|          0|          0|
|  3|         q3|    0.15005|     0.0203|    -1.5708|          0|
|  4|         q4|     0.4318|          0|     1.5708|          0|
|  5|         q5|          0|          0|    -1.5708|          0|
|  6|         q6|          0|          0|          0|     1.5708|
+---+-----------+-----------+-----------+-----------+-----------+
"""
PUMA: list[Row] = [(0, H, 0, 0), (0.4318, 0, 0, 0), (0.0203, -H, 0.15005, 0), (0, H, 0.4318, 0), (0, -H, 0, 0),
                   (0, 0, 0, H)]  # fmt: skip
UR5: list[Row] = [(0, H, 0.089459, 0), (-0.425, 0, 0, 0), (-0.39225, 0, 0, 0), (0, H, 0.10915, 0), (0, -H, 0.09465, 0),
                  (0, 0, 0.0823, 0)]  # fmt: skip
KR210: list[Row] = [(0, 0, 0.75, 0), (0.35, -H, 0, -H), (1.25, 0, 0, 0), (-0.054, -H, 1.5, 0), (0, H, 0, 0),
                    (0, -H, 0, 0), (0, 0, 0.303, 0)]  # fmt: skip
THREE: list[Row] = [(0, 0, 0.0675, pi), (-0.0225, H, 0, 0), (0.1131, 0, 0, H)]
TABLES: dict[str, tuple[str, str, list[Row], str]] = {
    "printed by Python": (PRINTED, "standard", [(0, -H, 0, 0), (0, H, 0, -H), (0, H, 0.1, 0), (0.25, pi / 6, 0.01, 0),
                          (0, 4 * pi / 3, 0.07, 0), (0.05, 0, -0.05831, 0)], "PPRRRR"),
    "printed by MATLAB": (MATLAB_PRINTED, "standard", PUMA, "RRRRRR"),
    "lists": ("# standard DH\na = [0, -0.42500, -0.39225, 0, 0, 0]\nd = [0.089459, 0, 0, 0.10915, 0.09465, 0.0823]\n"
              "alpha = [pi/2, 0, 0, np.pi/2, -np.pi/2, 0]\n", "standard", UR5, "RRRRRR"),
    "numbered names": ("s = {alpha0: 0, a0: 0, d1: 0.75, q1: q1,\n alpha1: -pi/2, a1: 0.35, d2: 0, q2: q2 - pi/2,\n"
                       " alpha2: 0, a2: 1.25, d3: 0, q3: q3,\n alpha3: -pi/2, a3: -0.054, d4: 1.50, q4: q4,\n"
                       " alpha4: pi/2, a4: 0, d5: 0, q5: q5,\n alpha5: -pi/2, a5: 0, d6: 0, q6: q6,\n"
                       " alpha6: 0, a6: 0, d7: 0.303, q7: 0}\n", "modified", KR210, "RRRRRR"),
    "calls with names and values": (
        "deg = pi/180; a3 = 203/10000;\nL(1) = Link('d', 0, 'a', 0, 'alpha', pi/2, 'qlim', [-160 160]*deg);\n"
        "L(2) = Link('d', 0, 'a', 0.4318, 'alpha', 0);\nL(3) = Link('d', 0.15005, 'a', a3, 'alpha', -pi/2);\n"
        "L(4) = Link('d', 0.4318, 'a', 0, 'alpha', pi/2);\n% L(5) = Link('d', 9, 'a', 9, 'alpha', 9);\n"
        "L(5) = Link('d', 0, 'a', 0, 'alpha', -pi/2);\nL(6) = Link('d', 0, 'a', 0, 'alpha', 0);\nL(6).offset = pi/2;\n",
        "standard", PUMA, "RRRRRR"),
    "calls with one bracket": (
        "L1 = Link([0 67.5 0 0 0 pi], 'modified'); L2 = Link([0, 0, -22.5, pi/2], 'modified');\n"
        "L3 = Link([0 0 113.1 0 0 pi/2], 'modified');\nbot = SerialLink([L1 L2 L3]);", "modified", THREE, "RRR"),
    "calls with keywords": (
        "links = [\n rtb.RevoluteMDH(d=67.5, offset=np.pi),  # base\n rtb.RevoluteMDH(a=-22.5, alpha=np.pi / 2),\n"
        " rtb.RevoluteMDH(a=113.1, offset=math.pi/2),\n]\n", "modified", THREE, "RRR"),
    "a comment above an array": (
        "# mDH = [a, alpha, d, theta0]\nmDH_params = np.array([\n    [0,     0,   67.5, 180],   # Joint 1\n"
        "    [-22.5, 90,    0,   0],    # Joint 2\n    [113.1, 0,     0,  90],\n])\n", "modified", THREE, "RRR"),
    "Markdown": ("Craig's convention\n\n| i | α_{i-1} | a_{i-1} [mm] | d_i [mm] | θ_i |\n|---|---|---|---|---|\n"
                 "| 1 | 0° | 0 | 67.5 | θ1 + 180° |\n| 2 | 90° | −22.5 | 0 | θ2 |\n| 3 | 0 | 113.1 | 0 | 90° + θ3 |\n",
                 "modified", THREE, "RRR"),
    "LaTeX": ("$\\alpha_{i-1}$ & $a_{i-1}$ & $d_i$ & $\\theta_i$ \\\\ \\hline\n"
              "0 & 0 & 0.0675 & $\\theta_1 + \\pi$ \\\\\n"
              "$\\pi/2$ & -0.0225 & 0 & $\\theta_2$ \\\\\n0 & 0.1131 & 0 & $\\theta_3+\\pi/2$ \\\\\n", "modified",
              THREE, "RRR"),
    "LaTeX with fractions and lines": (
        "\\begin{table} Denavit-Hartenberg (modified)\n\\begin{tabular}{|c|c|c|c|c|}\n\\hline\n"
        "$i$ & $\\alpha_{i-1}$ & $a_{i-1}$ & $d_i$ & $\\theta_i$ \\\\ \\hline\n"
        "1 & $0^\\circ$ & 0 & $l_1$ & $\\theta_1 + \\dfrac{2\\pi}{2}$ \\\\ \\hline\n"
        "2 & $\\frac{\\pi}{2}$ & $-l_{2}$ & $0$ & $\\theta_{2}$ \\\\[2pt] \\cline{1-5}\n"
        "3 & $0$ & 0.1131 & 0 & $\\theta_3^* - \\left(-90^{\\circ}\\right)$ \\\\ \\hline\n\\end{tabular}\n"
        "with $l_1 = 0.0675$ and $l_2 = 0.0225$.\n", "modified", THREE, "RRR"),
    "LaTeX in one line": (
        "\\begin{tabular}{cccc} \\toprule \\textbf{$a_{i-1}$} & $\\alpha_{i-1}\\,[^\\circ]$ & $d_i$ & $\\theta_i$ \\\\ "
        "\\midrule 0 & 0 & 0.0675 & $q_1+\\frac{2}{2}\\pi$ \\\\ -0.0225 & 90 & 0 & $q_2$ \\\\ 0.1131 & 0 & 0 & "
        "$q_3 + \\ang{90}$ \\\\ \\bottomrule \\end{tabular}", "modified", THREE, "RRR"),
    "a slide called d2": (
        "DH (standard)\nlink, theta, d, a, alpha\n1, t1, 0.4, 0, 90\n2, 0, d2, 0, -90\n3, 30, 0.1 + d_3, 0.3, 0\n"
        "4, t4, l, 0, 0\nl = 0.2\n", "standard",
        [(0, H, 0.4, 0), (0, -H, 0, 0), (0.3, 0, 0.1, pi / 6), (0, 0, 0.2, 0)], "RPPR"),
    "three slides called d1 to d3": (
        "DH (standard)\ni theta d a alpha\n1 0 d1 0 -90\n2 -90 d2 0 -90\n3 0 d3 0.25 0\n", "standard",
        [(0, -H, 0, 0), (0, -H, 0, -H), (0.25, 0, 0, 0)], "PPP"),
    "units behind named numbers": (
        "| i | α(i−1) | a(i−1) | d(i) | θ(i) |\n|---|---|---|---|---|\n| 1 | 0 | 0 | d1 | θ1 + b |\n"
        "| 2 | −c | −a2 | 0 | θ2 |\n| 3 | 0 | 2*a3 + 100*a2/1 - 100*a2 | 0 | 90° + θ3 |\n"
        "a2 = 22.5 mm\na3 = 5.655 cm, d1 = 0.0675 m, b = 180 deg, c = -90°\n", "modified", THREE, "RRR"),
    "names with a unit in a table of degrees": (
        "standard\na [mm] alpha [deg] d [mm] theta [deg]\n0 h l1 q1\n-l2 0 0 q2\nl1 = 0.5 m, h = pi/2, l2=25 cm\n",
        "standard", [(0, H, 0.5, 0), (-0.25, 0, 0, 0)], "RR"),
    "lists as the calibration of a UR is printed": (  # of Universal_Robots_Client_Library, KinematicsInfo
        "standard DH, m, rad\ndh_theta: [0 0.5 -0.25 ]\n\ndh_a: [0.0002 -0.0566 0.1 ]\n\n"
        "dh_d: [0.0888 5.7425 -5.0736 ]\n\ndh_alpha: [1.5703 -0.0007 0 ]\n", "standard",
        [(0.0002, 1.5703, 0.0888, 0), (-0.0566, -0.0007, 5.7425, 0.5), (0.1, 0, -5.0736, -0.25)], "RRR"),
    "lists with a suffix": (  # OstermD/EAIK#15
        "# standard DH, all in m and rad\nalpha_test = np.array([-np.pi/2, 0.5])\na_test = np.array([11, 12])\n"
        "d_test = np.array([0.0, 0.9954])\n# a_test = np.array([1, 2])\n", "standard",
        [(11, -H, 0, 0), (12, 0.5, 0.9954, 0)], "RR"),
    "multiples of π next to degrees": (
        "modified\na alpha d theta\n0 0 0.0675 q1+pi\n-0.0225 90 0 q2\n0.1131 0 0 q3+90\n", "modified", THREE, "RRR"),
    "letters in capitals": ("modified\na alpha d theta\n0 0 L1 θ1+π\n-L2 π/2 0 θ2\nL3 0 0 θ3+1π/2\n"
                            "L1 = 0.0675, L2 = 0.0225, L3 = 0.1131\n", "modified", THREE, "RRR"),
    "decimal commas": ("convention;modified\njoint;a [m];alpha [deg];d [m];theta [deg]\n1;0;0;0,0675;180\n"
                       "2;-0,0225;90;0;0\n3;0,1131;0;0;90\n", "modified", THREE, "RRR"),
    "lengths called d and r": ("j alpha d theta r\n1 0 0 q1+180 0.0675\n2 90 -0.0225 q2 0\n3 0 0.1131 q3+90 0\n",
                               "modified", THREE, "RRR"),
    "a slide": ("standard DH\nLink   a     alpha   d     theta\n1      0.325 0       0.387 q1\n"
                "2      0.275 180     0     q2\n"
                "3      0     0       q3    0\n4      0     0       0.1   q4\n", "standard",
                [(0.325, 0, 0.387, 0), (0.275, pi, 0, 0), (0, 0, 0, 0), (0, 0, 0.1, 0)], "RRPR"),
}  # fmt: skip


def opened(folder: Path, text: str) -> Robot:
    path = folder / "arm.txt"
    path.write_text(text, encoding="utf-8")
    return open_robot(path)


@pytest.mark.parametrize("name", TABLES)
def test_the_arm_is_that_of_the_table(name: str, tmp_path: Path, rng: np.random.Generator) -> None:
    text, convention, rows, kinds = TABLES[name]
    arm = opened(tmp_path, text)
    assert "".join(joint.kind.value[0].upper() for joint in arm.joints) == kinds
    assert any(f"{convention} convention" in str(note) for note in arm.notes)
    for q in rng.uniform(-1.0, 1.0, (5, arm.n)):
        assert np.abs(pose(arm, q) - tip(rows, q, convention, kinds)).max() < 1e-12


def test_an_angle_that_is_converted_to_degrees_is_one_of_its_column(tmp_path: Path) -> None:
    arm = opened(tmp_path, "standard\na alpha[deg] d theta\n1 0.5*180/pi 0 q1\n")
    assert np.abs(pose(arm, [0.0]) - tip([(1, 0.5, 0, 0)], np.zeros(1), "standard", "R")).max() < 1e-12


def test_fixed_rows_before_the_first_joint_are_the_base(tmp_path: Path, rng: np.random.Generator) -> None:
    """Kinova's tables of the Gen3 begin with "0 (from base)": its tip is that of the arm below the fixed transform."""
    rows: list[Row] = [(0, H, -0.2848, 0), (0.1, H, -0.0118, pi), (0, pi, -0.1674, pi)]
    head = "Kinova, classical DH\ni | alpha_i (rad) | a_i (m) | d_i (m) | theta_i (rad)\n"
    joints = ["1 | pi/2 | 0.0 | -(0.1564 + 0.1284) | q1", "2 | pi/2 | 0.1 | -(0.0054 + 0.0064) | q2 + pi",
              "3 (to interface) | pi | 0.0 | -0.1674 | q3 + pi"]  # fmt: skip
    arm = opened(tmp_path, head + "\n".join(["0 (from base) | pi | 0.0 | 0.0 | 0", *joints]))
    assert [joint.name for joint in arm.joints] == ["joint1", "joint2", "joint3"]
    for q in rng.uniform(-1.0, 1.0, (3, 3)):
        assert np.abs(pose(arm, q) - turned(0, pi) @ tip(rows, q, "standard", "RRR")).max() < 1e-12


def test_a_joint_that_is_taken_for_a_slide_is_named_in_a_note(tmp_path: Path) -> None:
    notes = [str(note) for note in opened(tmp_path, TABLES["a slide called d2"][0]).notes]
    assert any("joint 'joint2' slides: no number is given for d2" in note for note in notes)


@pytest.mark.parametrize(
    ("text", "change"),
    [("standard\na alpha d theta\n0.001 90 574.2 0\n", ("standard", "standard, lengths in cm")),
     ("standard\na alpha d theta\n0.001 90 574.2 0\n", ("standard\na ", "standard\na [cm] ")),
     ("standard, rad\na alpha d theta\n0 90 1 q1\n", ("90", "90deg")),
     ("a=[1]\nd=[0]\nalpha=[0]\n", ("a=[1]", "standard\na=[1]")),
     ("standard\na alpha d theta\n0 0 0 q1\n0 0 1 0\n0 0 0 q3\n", ("0 0 1 0", "0 0 1 q2"))],
)  # fmt: skip
def test_a_text_is_read_after_the_fix_of_its_refusal(text: str, change: tuple[str, str], tmp_path: Path) -> None:
    with pytest.raises(RobotError):
        opened(tmp_path, text)
    opened(tmp_path, text.replace(*change, 1))


def test_limits_are_read_in_the_unit_of_the_form(tmp_path: Path) -> None:
    arm = opened(tmp_path, PRINTED)
    assert [(joint.lower, joint.upper) for joint in arm.joints[:2]] == [(-0.33, 0.33)] * 2
    assert (arm.joints[3].lower, arm.joints[3].upper) == pytest.approx((-pi / 6, H))
    calls = opened(tmp_path, TABLES["calls with names and values"][0])
    assert (calls.joints[0].upper, calls.joints[1].upper) == pytest.approx((8 * pi / 9, inf))


def test_the_singularities_are_those_of_the_same_arm_in_the_catalogue(tmp_path: Path) -> None:
    """UR5 as three lists: joint 5 at 0 is its wrist singularity, whatever the rest."""
    arm = opened(tmp_path, TABLES["lists"][0])
    values = np.linalg.svd(jacobian(arm, [0.3, -1.0, 1.2, 0.4, 0.0, 0.7]), compute_uv=False)
    assert values[-1] < 1e-9 < values[-2]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,alpha,d,theta\n0,1.5708,0.1,0\n0.4,0,0,0\n", "convention of the table is in doubt; got none is named"),
        ("standard or modified?\na,alpha,d,theta\n0,1.5708,0.1,0\n", "got both are named"),
        ("L(1) = Link([0 0.1 0 90]);\n", r"many turns in radians; got 90; fix: write pi/2"),
        ("standard, angles in degrees\na,alpha,d,theta\n0,1,0.1,0\n", "unit of the angles is in doubt; got 1"),
        ("modified\na,alpha,d,theta\n0,10,0.1,0\n", "unit of the angles is in doubt; got 10"),
        ("standard\na,alpha,d,theta\n43.18,90,0,0\n2,0,12.5,0\n", "lengths is in doubt; got 2 at least, 43.18 at most"),
        ("a2 = 0.25;\na2 = 0.26;\nL1 = Link('d',0,'a',a2,'alpha',0);\n", r"line 3, .*two values; got .* 0.25 \| 0.26"),
        ("L = [RevoluteDH(a=a[i], alpha=0, d=0)]\n", "gives this name no number; got a"),
        ("L1 = Link('d',0,'a',1,'alpha',0);\nL1 = Link('d',0,'a',2,'alpha',0);\n", "two arms; got L1 again"),
        ("L1 = RevoluteDH(a=1,\n    d=0.5\n", r"line 1: a call has no end; got RevoluteDH\("),
        ("L1 = RevoluteDH(a=1, d=0)\nL2 = RevoluteMDH(a=1, d=0)\n", "links are of both conventions"),
        ("modified\na alpha d theta\n0 0 0 q1\n0 0 1 0\n0 0 0 q3\n", "line 4: the row has no joint .*fix: .*q2"),
        ("standard\nlink a alpha d theta\n1 0 0 0.1 0\n2 0 90 0 q2\n", "line 3: the row has no joint .*fix: .*q1"),
        ("standard\ni,theta,d,a,alpha\n1,0,d1,0,90\n2,0,d2,1,0\nd1 = 0.1\n", "line 3: the row has no joint variable"),
        ("standard\ni,theta,d,a,alpha\n1,0,d1,0,90\n2,0,0,0.4,0\n", "line 4: the row has no joint variable"),
        ("standard\ni,theta,d,a,alpha\n1,0,0,0,90\n2,0,0.1,0,0\n3,q2,0,1,0\n", "line 3: the row has no joint variable"),
        ("standard\ni,theta,d,a,alpha\n1,q1,d1,0,90\n", "gives this name no number; got d1"),
        ("standard\ni,theta,d,a,alpha\n1,q1,1,0,90\ntool,0,d2,0,0\n", "gives this name no number; got d2"),
        ("standard\na alpha d theta\nb 90 0 q1\nb = 90 deg\n", "line 3, row 1, a, b: the unit does not fit"),
        ("standard, units m\nall in mm\na alpha d theta\n0 0 1 q1\n", "in doubt; got 1 at least, 1 at most and m and"),
        ("standard\na alpha d theta\n0.001 90 574.2 0\n0.4 0 0 0\n", "in doubt; got 0.001 at least, 574.2 at most"),
        ("standard, rad\na alpha d theta\n0 90 1 q1\n", "unit of the angles is in doubt; got 90"),
        ("standard\na_x=[1]\nd_x=[0]\nalpha_x=[0]\na_y=[1]\nd_y=[0]\nalpha_y=[0]\n", "two arms; got 2 lists of alpha"),
        ("standard\na=[1]\nd=[0]\nalpha=[0]\na=[2]\n", "the file has two arms; got a again"),
        ("modified\na & alpha & d & theta\n0 & $\\varrho$ & 1 & q1\n", r"LaTeX is not read; got \\varrho; fix: write"),
        ("modified\na alpha[deg] d theta\n0 pi/2 1 q1\n", r"angle is in doubt; got pi/2 in degrees; fix: .*: pi/2rad"),
        ("0 0 0.1 0\n", "six numbers .*fix: rows of four numbers of a DH table need a heading: a, alpha, d, theta"),
        ("dh = Matrix([[th_1, pi/2, 0, d_1]])\n", "a table has a heading: a, alpha, d, theta"),
    ],
)
def test_what_is_in_doubt_is_refused_with_what_to_write(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=said):
        opened(tmp_path, text)


def test_a_name_without_a_number_is_read_after_the_line_that_the_refusal_proposes(tmp_path: Path) -> None:
    """A proposed fix works: it named commands of LaTeX, "write frac = 0.1"."""
    text = "modified\n$a_i$ & $\\alpha_i$ & $d_i$ & $\\theta_i$ \\\\\n0 & 0 & $H_1$ & $q_1$ \\\\\n0.5 & 0 & 0 & $q_2$\n"
    with pytest.raises(RobotError, match=r"line 3, .*got H_1; fix: write .* line of its own: H_1 = 0\.1$") as refused:
        opened(tmp_path, text)
    line = refused.value.parts["mend"].rpartition(": ")[2]
    assert opened(tmp_path, f"{text}{line}\n").home[2, 3] == 0.1


def test_a_tool_of_the_text_is_named_as_not_read(tmp_path: Path) -> None:
    text = TABLES["calls with keywords"][0]
    assert not any("tool" in str(note) for note in opened(tmp_path, text).notes)
    assert any("tool" in str(note) for note in opened(tmp_path, text + "robot.tool = SE3.Tx(0.28)\n").notes)


def test_toml_stays_toml(tmp_path: Path) -> None:
    """Its keys look like lists and names with numbers."""
    path = tmp_path / "arm.dh"
    path.write_text('convention = "standard"\n[[joints]]\na = 1\nalpha = 0\nd = 0.25\n', encoding="utf-8")
    assert open_robot(path).home[0, 3] == 1.0
