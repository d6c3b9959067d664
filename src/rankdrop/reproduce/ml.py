"""ML: Memon's lecture Kinematic Singularities. The planar arm, why singularities matter, decoupling, elbow and shoulder."""

from __future__ import annotations

from functools import cache
from math import degrees, pi

import numpy as np

from rankdrop.conditions import conditions
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.decoupling.decouple import Decoupling, decouple
from rankdrop.explain import explain
from rankdrop.frames import BODY, SPACE, Frame
from rankdrop.kinematics import jacobian, link_poses, pose
from rankdrop.local.block import generic_rank, sample, singular_values
from rankdrop.local.directions import lost_directions
from rankdrop.local.planar import planar_two_link, rate_table
from rankdrop.local.rates import rate_growth
from rankdrop.local.relations import relations_at
from rankdrop.local.representation import representation_at
from rankdrop.reach import reach
from rankdrop.reproduce.formula import matrix, value
from rankdrop.reproduce.item import Sheet, Shown, listed, rounded
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task

PLANAR = {"a1": 1.0, "a2": 0.7}
LENGTHS = {"a2": 0.5, "a3": 0.4}
"""Lengths for the letters of the lectures [m]."""
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
FOREARM_LINE = "a2 c2 + a3 c23"


def angles(robot: Robot, count: int, seed: int) -> Array:
    """(count, n) random configurations."""
    return sample(robot, resolve_task(None, robot), count, seed)


def worst(one: Array, other: Array) -> float:
    """Largest difference."""
    return float(np.abs(np.asarray(one) - np.asarray(other)).max())


@cache
def elbow_arm() -> Robot:
    """The lectures' elbow arm with spherical wrist: links a2 = 0.5 m, a3 = 0.4 m, wrist centre to tip 0.1 m; the origins
    of frames 3, 4, 5 are in the wrist centre, and θ3 = 0 is the straight arm."""
    rows = [(0, "pi/2", 0, 0), (LENGTHS["a2"], 0, 0, 0), (LENGTHS["a3"], "pi/2", 0, 0),
            (0, "-pi/2", 0, 0), (0, "pi/2", 0, 0), (0, 0, 0.1, 0)]  # fmt: skip
    return from_dh(rows, convention="standard", name="elbow arm")


@cache
def decoupled() -> Decoupling:
    """The elbow arm with spherical wrist taken apart into arm and wrist."""
    found = decouple(exact_chain(elbow_arm(), lengths=LENGTHS))
    assert found is not None
    return found


@cache
def shoulder_text() -> str:
    """The exact condition of the elbow arm that ties joints 2 and 3."""
    found = conditions(elbow_arm(), lengths=LENGTHS, coranks=1, points=0, special=False)
    return next(family.texts[0] for family in found.families if family.coupled)


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
    ranks = [_rank(robot, one) for one in (q, at_wrist)]
    sheet.numbers("Singular configurations", "rank of the PUMA 560's J at a random configuration and with θ5 = 0", "6 5",
                  ranks, layout="the maximum (6); less than its maximum (below 6)")  # fmt: skip


def _rank(robot: Robot, q: Array, task: str | Task | None = None) -> int:
    return int((singular_values(robot, q, resolve_task(task, robot)) > 1e-9).sum())


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
                   ours="none: a wrench of any size is carried with torques of zero", tolerance=1e-9)  # fmt: skip
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.0, 0.5])
    other = q + 0.7 * np.array([0, 0, 0, 1, 0, -1])
    sheet.identity("Why do we care", "pose with θ4 + 0.7 and θ6 − 0.7 at θ5 = 0 (PUMA 560)",
                   "infinite solutions to the inverse kinematic problem may exist", worst(pose(puma, q), pose(puma, other)),
                   ours="the same pose, and so for every number in place of 0.7")  # fmt: skip
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
    sheet.identity("Two-links planar arm", "J", "rows " + J.replace("\n", "; "), worst(matrix(J, q, PLANAR), jacobian(robot, q)))
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
                abs(near.rates_x[0]) > 900 and np.isfinite(table).all())  # fmt: skip
    sheet.claim(
        "θ2 close to zero", "joint rates for small δẏ", "large even for small δẏ",
        f"{rounded(near.rates_y[0])} and {rounded(near.rates_y[1])} rad/s for 1 m/s, at every θ2", abs(near.rates_y[0]) > 10,
        reason="Only the entries of δẋ have s2 below the line; δẏ costs 1/a1.",
        shown=Shown("", worst(np.array(near.rates_y), np.array([1.0, -1.0]) / PLANAR["a1"]) < 1e-9),
    )  # fmt: skip


def frames(sheet: Sheet) -> None:
    """Do we really have to solve determinant equations."""
    robot = open_robot("puma560")
    q = angles(robot, 5, 3)
    q[2:, 4] = 0.0
    ranks = [[int((np.linalg.svd(jacobian(robot, one, frame), compute_uv=False) > 1e-9).sum()) for one in q]
             for frame in (SPACE, BODY, Frame(3, 3), Frame(6, 0, (0.1, 0.2, 0.3)))]  # fmt: skip
    sheet.claim("Singular configurations", "rank of J in four frames at five configurations of the PUMA 560",
                "independent of the choice of base or end frames", f"{listed(ranks[0])} in each of the frames",
                all(row == ranks[0] for row in ranks))  # fmt: skip
    columns = jacobian(robot, q)
    axes = [link_poses(robot, one) for one in q]
    z = np.array([[poses[i][:3, 2] for i in range(6)] for poses in axes])
    o = np.array([[poses[i][:3, 3] for i in range(7)] for poses in axes])
    arms = np.cross(z[:, 3:], o[:, 6:] - o[:, 3:6])
    sheet.identity("J_O", "columns 4 to 6 of J", "z_{i−1} × (o6 − o_{i−1}); z_{i−1}", max(
        worst(columns[:, :3, 3:], arms.swapaxes(1, 2)), worst(columns[:, 3:, 3:], z[:, 3:].swapaxes(1, 2))))  # fmt: skip


def decoupling(sheet: Sheet) -> None:
    """Decoupling singularities."""
    found, robot = decoupled(), elbow_arm()
    sheet.claim("Decoupling", "why J takes the form [[J11, 0], [J21, J22]]", "the wrist axes intersect at one point",
                found.reason, found.kind == "point")  # fmt: skip
    zero = all(found.chain.ring.reduce(x) == 0 for column in found.columns[3:] for x in column[:3])
    sheet.claim("Decoupling", "upper right block at the wrist centre", "0", "0, exactly" if zero else "not 0", zero)
    q = angles(robot, 20, 4)
    centre = jacobian(robot, q, Frame(0, 5))
    whole = np.linalg.det(centre)
    blocks = np.linalg.det(centre[:, :3, :3]) * np.linalg.det(centre[:, 3:, 3:])
    sheet.identity("Decoupling", "det J", "det J = det J11 det J22", worst(whole, blocks))
    sheet.identity("Decoupling", "det J at the tip and at the wrist centre", "only used to determine singularities",
                   worst(whole, np.linalg.det(jacobian(robot, q))))  # fmt: skip
    sheet.claim("Decoupling", "J at the wrist centre relates other velocities than J at the tip",
                "will not give you the correct relation between velocities",
                "columns differ by up to the distance from wrist to tip, 0.1 m",
                abs(worst(centre, jacobian(robot, q)) - 0.1) < 0.02)  # fmt: skip
    wrist = found.blocks[1].parts[0]
    sheet.same("Spherical wrist", "where it is singular", "θ5 = 0 or π", wrist.text)
    there = np.array([0.3, 0.4, 0.5, 0.6, 0.0, 0.7])
    sheet.claim("Spherical wrist", "what the axes do there", "z3 and z5 are collinear", "axes 4, 6 aligned",
                any(relation.words == "axes 4, 6 aligned" for relation in relations_at(robot, there)))  # fmt: skip
    redundant = open_robot("pa10")
    q7 = np.array([0.3, -0.4, 1.1, 0.9, -0.7, 0.0, 0.5])
    aligned = any(relation.words == "axes 5, 7 aligned" for relation in relations_at(redundant, q7))
    rank = _rank(redundant, q7)
    sheet.claim(
        "Spherical wrist", "two collinear revolute axes", "whenever two revolute joint axes are collinear, a singularity "
        "results", f"not for a redundant arm: PA-10 with axes 5 and 7 aligned has rank {rank}", rank < 6,
        reason="True of arms that have no joint too many.",
        shown=Shown(f"θ6 = 0, nothing else special: σ6 = {singular_values(redundant, q7, resolve_task(None, redundant))[5]:.3f}.",
                    aligned and rank == 6),
    )  # fmt: skip


def arm_sign(alpha: str) -> Array:
    """(20,) det J11 of the elbow arm divided by a2 a3 s3 (a2 c2 + a3 c23): its sign for α1 = ±π/2."""
    rows = [(0, alpha, 0, 0), (LENGTHS["a2"], 0, 0, 0), (LENGTHS["a3"], 0, 0, 0)]
    arm = from_dh(rows, convention="standard", task="position")
    q = angles(arm, 20, 5)
    return np.asarray(np.linalg.det(jacobian(arm, q)[:, :3]) / value(f"a2 a3 s3 ({FOREARM_LINE})", q, LENGTHS))


def arm(sheet: Sheet) -> None:
    """Arm singularities of the articulated arm."""
    robot, block = elbow_arm(), decoupled().blocks[0]
    q = angles(robot, 20, 6)
    poses = [link_poses(robot, one) for one in q]
    columns = [[np.cross(p[i][:3, 2], p[5][:3, 3] - p[i][:3, 3]) for i in range(3)] for p in poses]
    centre = jacobian(robot, q, Frame(0, 5))[:, :3, :3]
    sheet.identity("J11", "columns of J11, the reference point at the wrist centre", "z_{i−1} × (o − o_{i−1})",
                   worst(centre, np.array(columns).swapaxes(1, 2)))  # fmt: skip
    signs = {alpha: arm_sign(alpha) for alpha in ("pi/2", "-pi/2")}
    sheet.identity(
        "det J11", "det J11 of the elbow arm", f"a2 a3 s3 ({FOREARM_LINE})", worst(signs["-pi/2"], np.ones(20)),
        reason="The sign is that of α1 = −π/2; with α1 = π/2 it is the opposite, as JL print it. The figure with the "
        "frames is not in the document; the zeros are the same.",
    )  # fmt: skip
    texts = [part.text for part in block.parts]
    sheet.same("Arm singularities", "elbow", "θ3 = 0 or π", texts[0], reason="Named by the geometry: " + block.parts[0].name)
    shoulder = _on_shoulder(robot)
    sheet.same("Arm singularities", "shoulder", f"{FOREARM_LINE} = 0", shoulder_text())
    sheet.identity("Arm singularities", "shoulder: det J11 where a2 c2 + a3 c23 = 0", f"{FOREARM_LINE} = 0",
                   worst(np.linalg.det(jacobian(robot, shoulder, Frame(0, 5))[:, :3, :3]), np.zeros(len(shoulder))),
                   reason="Named by the geometry: " + block.parts[1].name)  # fmt: skip
    offset(sheet)


def _on_shoulder(robot: Robot) -> Array:
    """Configurations with a2 c2 + a3 c23 = 0: θ3 from θ2."""
    q = angles(robot, 60, 7)
    ratio = -LENGTHS["a2"] * np.cos(q[:, 1]) / LENGTHS["a3"]
    q = q[np.abs(ratio) < 1.0]
    q[:, 2] = np.arccos(ratio[np.abs(ratio) < 1.0].clip(-1, 1)) - q[:, 1]
    return q


def offset(sheet: Sheet) -> None:
    """The shoulder singularity of an arm with an offset."""
    robot = open_robot("puma560")
    families = conditions(robot, coranks=1, points=0, special=False).families
    family = next(one for one in families if one.texts == ("a2 c2 + a3 c23 − d4 s23 = 0",))
    q = np.array(family.witness)
    rank = _rank(robot, q)
    centre = link_poses(robot, q)[5][:3, 3]
    away = float(np.hypot(centre[0], centre[1]))
    sheet.claim(
        "Shoulder singularity", "of an arm with a shoulder offset (PUMA 560, d3 = 0.15 m)",
        "not possible with an offset, but the points become unreachable",
        f"rank {rank} where {family.texts[0]}", rank == 6,
        reason="The points of axis 1 are out of reach, as printed; the rank falls all the same, beside the axis.",
        shown=Shown(f"σ6 = 0 with the wrist centre {rounded(away, 3)} m from axis 1, which is d3.",
                    rank == 5 and abs(away - 0.15005) < 1e-6),
    )  # fmt: skip
    sheet.claim("Shoulder singularity", "smallest distance of the PUMA's wrist centre from axis 1",
                "the points become unreachable", "d3 = 0.15005 m: the axis is out of reach",
                _closest(robot) > 0.15005 - 1e-9)  # fmt: skip


def _closest(robot: Robot) -> float:
    """Smallest distance of the wrist centre from axis 1 over random configurations [m]."""
    return min(float(np.hypot(*link_poses(robot, q)[5][:2, 3])) for q in angles(robot, 500, 8))


def blow_up() -> tuple[Array, Array]:
    """(k,) angles θ2 [deg] and (k, 2, 2) joint rates for unit speed: rows joints, columns x and y of link 1."""
    theta = np.radians(np.concatenate([np.geomspace(0.05, 90.0, 80)]))
    found = [planar_two_link(PLANAR["a1"], PLANAR["a2"], float(t)) for t in theta]
    return np.array([degrees(t) for t in theta]), np.array([np.transpose([f.rates_x, f.rates_y]) for f in found])


SECTIONS = (
    ("definition", definition), ("consequences", consequences), ("planar arm", planar_arm), ("joint rates", rates),
    ("frames", frames), ("decoupling", decoupling), ("arm", arm),
)  # fmt: skip
