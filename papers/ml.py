"""ML: Memon's lecture Kinematic Singularities: the planar arm, and why singularities matter."""

from __future__ import annotations

from math import degrees

import numpy as np

from papers import ml_decoupling
from papers.elbow import angles, elbow_arm, rank_of, worst
from papers.formula import matrix, value
from papers.item import Sheet, Shown, listed, rounded
from papers.planar import planar_two_link, rate_table
from rankdrop import conditions, explain
from rankdrop.kinematics import jacobian, pose
from rankdrop.local import generic_rank, lost_directions, rate_growth, representation_at
from rankdrop.robot import Array, open_robot, reach
from rankdrop.task import Frame, Task, resolve_task

PLANAR = {"a1": 1.0, "a2": 0.7}
"""Lengths for the letters of the lecture [m]."""
J = """-a1 s1 - a2 s12 | -a2 s12
a1 c1 + a2 c12 | a2 c12
0 | 0
0 | 0
0 | 0
1 | 1"""
J_LINK_1 = """-a2 s2 | -a2 s2
a1 + a2 c2 | a2 c2"""
TURN = """c1 | s1
-s1 | c1"""
INVERSE = """a2 c2/(a1 a2 s2) | a2 s2/(a1 a2 s2)
(-a1 - a2 c2)/(a1 a2 s2) | -a2 s2/(a1 a2 s2)"""
RATES = """c2/(a1 s2) | 1/a1
-(a1 + a2 c2)/(a1 a2 s2) | -1/a1"""


def definition(sheet: Sheet) -> None:
    """The Jacobian, its rank, what a singular configuration is."""
    robot = open_robot("puma560")
    q = angles(robot, 1, 1)[0]
    rates = np.array([0.3, -0.2, 0.5, 0.1, 0.4, -0.6])
    total = sum(rate * column for rate, column in zip(rates, jacobian(robot, q).T, strict=True))
    sheet.identity("The Jacobian", "ξ as a combination of the columns of J (PUMA 560)", "ξ = J1 q̇1 + … + Jn q̇n",
                   worst(jacobian(robot, q) @ rates, total))  # fmt: skip
    at_wrist = q.copy()
    at_wrist[4] = 0.0
    ranks = [rank_of(robot, one) for one in (q, at_wrist)]
    sheet.numbers("Singular configurations", "rank of the PUMA 560's J at a random configuration and with θ5 = 0",
                  "6 5",
                  ranks, layout="the maximum (6); less than its maximum (below 6)")  # fmt: skip


def consequences(sheet: Sheet) -> None:
    """Why do we care."""
    planar, puma = open_robot("planar2r"), open_robot("puma560")
    task = resolve_task(None, planar)
    lost = lost_directions(planar, np.zeros(2), task, 1)
    sheet.claim("Why do we care", "motion not possible at a singularity (planar arm stretched along x)",
                "motion in some directions not possible", f"cannot move along {listed(lost[0, :2])}",
                worst(np.abs(lost[0, :2]), np.array([1.0, 0.0])) < 1e-9)  # fmt: skip
    growth = rate_growth(planar, [0.3, 0.0], [0, 1])
    sheet.claim("Why do we care", "joint rates near a singularity for unit speed", "unbounded or large",
                f"they grow as 1/distance^{growth.power:.1f}: {growth.rates[0]:.0f} at {growth.distances[0]:g} rad, "
                f"{growth.rates[-1]:.0f} at {growth.distances[-1]:g} rad", abs(growth.power - 1.0) < 0.05)  # fmt: skip
    wrench = explain(puma, [0.1, 0.2, 0.3, 0.4, 0.0, 0.5]).lost.directions[0]
    torque = jacobian(puma, [0.1, 0.2, 0.3, 0.4, 0.0, 0.5]).T @ wrench
    sheet.identity("Why do we care", "joint torques Jᵀw of a wrench w carried at a singularity (PUMA 560, θ5 = 0)",
                   "bounded torques may produce unbounded forces", float(np.abs(torque).max()),
                   ours=f"largest torque for a unit wrench: {rounded(float(np.abs(torque).max()), 6)}",
                   tolerance=1e-9)  # fmt: skip
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.0, 0.5])
    other = q + 0.7 * np.array([0, 0, 0, 1, 0, -1])
    sheet.identity("Why do we care", "pose with θ4 + 0.7 and θ6 − 0.7 at θ5 = 0 (PUMA 560)",
                   "infinite solutions to the inverse kinematic problem may exist", worst(pose(puma, q), pose(puma,
                   other)),
                   ours=f"the pose changes by {rounded(worst(pose(puma, q), pose(puma, other)), 6)}")  # fmt: skip
    away = float(np.linalg.norm(pose(planar, np.zeros(2))[:3, 3]))
    sheet.claim("Why do we care", "the planar arm's singularity θ2 = 0 is on the workspace boundary",
                "often occur along workspace boundary", f"at {rounded(away)} m, its reach",
                abs(away - reach(planar)) < 1e-12)  # fmt: skip
    q = np.array([0.0, 0.3, -0.7, 0.0, 0.4, 0.0])  # the last axis is vertical
    found = representation_at(elbow_arm(), q)
    sheet.claim("How do we determine", "a singularity of the coordinates that is not one of the arm",
                "the analytical Jacobian's include representational singularities",
                f"at one pose ZYZ angles are singular, the rank of J is {found.arm.rank}",
                found.zyz.singular and found.arm.corank == 0)  # fmt: skip


def planar_arm(sheet: Sheet) -> None:
    """Two-links planar arm."""
    robot = open_robot("planar2r")
    q = angles(robot, 50, 2)
    sheet.identity("Two-links planar arm", "J", "rows " + J.replace("\n", "; "), worst(matrix(J, q, PLANAR),
                   jacobian(robot, q)))
    sheet.numbers("Two-links planar arm", "maximal rank", "2", generic_rank(robot, resolve_task("pose", robot)))
    top = jacobian(robot, q)[:, :2]
    sheet.identity("Two-links planar arm", "determinant of the first 4 entries", "a1 a2 s2",
                   worst(np.linalg.det(top), value("a1 a2 s2", q, PLANAR)))  # fmt: skip
    sheet.numbers(
        "Two-links planar arm", "size of the matrix made of these 4 entries", "4", top.shape[-1],
        layout="determinant of 4×4 matrix", reason="Four entries make a 2×2 matrix.",
        shown=Shown("J has two columns: no 4×4 matrix is in it.", jacobian(robot, q).shape[-2:] == (6, 2)),
    )  # fmt: skip
    (family,) = conditions(robot, points=0).families
    sheet.same("Two-links planar arm", "where it is singular", "θ2 = 0 or π", family.texts[0])
    link = Task("planar-position", resolve_task(None, robot).rows, Frame(1, -1), 1.0)
    there = np.array([0.4, 0.0])
    lost = lost_directions(robot, there, link, 1)[0]
    sheet.claim("At singularity", "the lost motion, in the axes of link 1", "we cannot move in direction of x1",
                f"x1, {listed(lost[:2])}", worst(np.abs(lost[:2]), np.array([1.0, 0.0])) < 1e-9)  # fmt: skip
    at_link = jacobian(robot, q, Frame(1, -1))[:, :2]
    sheet.identity("¹J", "¹R₀ ⁰J", "[[c1, s1], [−s1, c1]] ⁰J", worst(matrix(TURN, q, PLANAR) @ top, at_link))
    sheet.identity("¹J", "¹J", J_LINK_1.replace("\n", "; "), worst(matrix(J_LINK_1, q, PLANAR), at_link))
    sheet.identity("¹J", "¹J at the singularity θ2 = 0", "0 | 0; a1 + a2 | a2", worst(
        matrix("0 | 0\na1 + a2 | a2", there, PLANAR), jacobian(robot, there, Frame(1, -1))[:2]))  # fmt: skip


def rates(sheet: Sheet) -> None:
    """The inverse of ¹J and the joint rates near θ2 = 0."""
    q = np.array([[0.0, t] for t in (0.9, -2.0, 0.1, 0.01)])
    ours = [planar_two_link(PLANAR["a1"], PLANAR["a2"], t) for t in q[:, 1]]
    inverses = np.array([one.inverse for one in ours])
    sheet.identity("¹J⁻¹", "inverse of ¹J", INVERSE.replace("\n", "; "), worst(matrix(INVERSE, q, PLANAR), inverses),
                   reason="As it stands in the copy at hand; in others entries have lost their factor a2.")  # fmt: skip
    sheet.identity("¹J⁻¹", "δθ̇1, δθ̇2 for δẋ and for δẏ", RATES.replace("\n", "; "),
                   worst(matrix(RATES, q, PLANAR), inverses))  # fmt: skip
    table = rate_table(PLANAR["a1"], PLANAR["a2"], (1e-1, 1e-3))
    near = planar_two_link(PLANAR["a1"], PLANAR["a2"], 1e-3)
    sheet.claim("θ2 close to zero", "joint rates for small δẋ", "large even for small δẋ",
                f"{near.rates_x[0]:.0f} and {near.rates_x[1]:.0f} rad/s for 1 m/s at θ2 = 0.001",
                bool(abs(near.rates_x[0]) > 900 and np.isfinite(table).all()))  # fmt: skip
    sheet.claim(
        "θ2 close to zero", "joint rates for small δẏ", "large even for small δẏ",
        f"{rounded(near.rates_y[0])} and {rounded(near.rates_y[1])} rad/s for 1 m/s, at every θ2",
        bool(abs(near.rates_y[0]) > 10),
        reason="Only the entries of δẋ have s2 below the line; δẏ costs 1/a1.",
        shown=Shown("", worst(np.array(near.rates_y), np.array([1.0, -1.0]) / PLANAR["a1"]) < 1e-9),
    )  # fmt: skip


def blow_up() -> tuple[Array, Array]:
    """(k,) angles θ2 [deg] and (k, 2, 2) joint rates for unit speed: rows joints, columns x and y of link 1."""
    theta = np.radians(np.geomspace(0.05, 80.0, 80))
    found = [planar_two_link(PLANAR["a1"], PLANAR["a2"], float(t)) for t in theta]
    return np.array([degrees(t) for t in theta]), np.array([np.transpose([f.rates_x, f.rates_y]) for f in found])


SECTIONS = (
    ("definition", definition), ("consequences", consequences), ("planar arm", planar_arm), ("joint rates", rates),
    *ml_decoupling.SECTIONS,
)  # fmt: skip
