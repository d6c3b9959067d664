"""ML, second part: singularities of arms with a spherical wrist, decoupled; elbow and shoulder."""

from __future__ import annotations

import numpy as np

from papers.elbow import (
    FOREARM_LINE,
    angles,
    arm_sign,
    decoupled,
    elbow_arm,
    on_shoulder,
    rank_of,
    shoulder_text,
    worst,
)
from papers.item import Sheet, Shown, listed, rounded
from rankdrop import conditions
from rankdrop.kinematics import jacobian, link_poses
from rankdrop.local import relations_at, singular_values
from rankdrop.robot import Robot, open_robot
from rankdrop.task import BODY, SPACE, Frame, resolve_task


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
        worst(columns[:, :3, 3:], arms.swapaxes(1, 2)), worst(columns[:, 3:, 3:], z[:, 3:].swapaxes(1, 2))))


def decoupling(sheet: Sheet) -> None:
    """Decoupling singularities."""
    found, robot = decoupled(), elbow_arm()
    steps = {step.title: step.lines for step in conditions(robot, coranks=1, steps=True, points=0).steps}
    why = steps["Decoupling"][0]
    sheet.claim("Decoupling", "why J takes the form [[J11, 0], [J21, J22]]", "the wrist axes intersect at one point",
                why.rstrip("."), found.form.kind == "point")  # fmt: skip
    zero = all(found.chain.ring.reduce(x) == 0 for column in found.form.columns[3:] for x in column[:3])
    sheet.claim("Decoupling", "upper right block at the wrist centre", "0", "0, exactly" if zero else "not 0", zero)
    q = angles(robot, 20, 4)
    centre = jacobian(robot, q, Frame(0, 5))
    whole = np.linalg.det(centre)
    blocks = np.linalg.det(centre[:, :3, :3]) * np.linalg.det(centre[:, 3:, 3:])
    sheet.identity("Decoupling", "det J", "det J = det J11 det J22", worst(whole, blocks))
    sheet.identity("Decoupling", "det J at the tip and at the wrist centre", "only used to determine singularities",
                   worst(whole, np.linalg.det(jacobian(robot, q))))  # fmt: skip
    apart = worst(centre, jacobian(robot, q))
    sheet.claim("Decoupling", "J at the wrist centre relates other velocities than J at the tip",
                "will not give you the correct relation between velocities",
                f"columns differ by up to {rounded(apart, 2)} m; the tip is 0.1 m from the wrist",
                abs(apart - 0.1) < 0.02)  # fmt: skip
    wrist = found.blocks[1].parts[0]
    sheet.same("Spherical wrist", "where it is singular", "θ5 = 0 or π", wrist.text)
    there = np.array([0.3, 0.4, 0.5, 0.6, 0.0, 0.7])
    there_aligned = [relation.words for relation in relations_at(robot, there) if "aligned" in relation.words]
    sheet.claim("Spherical wrist", "what the axes do there", "z3 and z5 are collinear", "; ".join(there_aligned),
                "axes 4, 6 aligned" in there_aligned)  # fmt: skip
    redundant = open_robot("pa10")
    q7 = np.array([0.3, -0.4, 1.1, 0.9, -0.7, 0.0, 0.5])
    aligned = any(relation.words == "axes 5, 7 aligned" for relation in relations_at(redundant, q7))
    rank, sigma = rank_of(redundant, q7), singular_values(redundant, q7, resolve_task(None, redundant))[5]
    sheet.claim(
        "Spherical wrist", "two collinear revolute axes",
        "whenever two revolute joint axes are collinear, a singularity "
        "results", f"not for a redundant arm: PA-10 with axes 5 and 7 aligned has rank {rank}", rank < 6,
        reason="True of arms that have no joint too many.",
        shown=Shown(f"θ6 = 0, nothing else special: σ6 = {sigma:.3f}.",
                    aligned and rank == 6),
    )  # fmt: skip


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
    sheet.same("Arm singularities", "elbow", "θ3 = 0 or π", texts[0],
               reason="Named by the geometry: " + block.parts[0].name)
    shoulder = on_shoulder()
    sheet.same("Arm singularities", "shoulder", f"{FOREARM_LINE} = 0", shoulder_text())
    sheet.identity("Arm singularities", "shoulder: det J11 where a2 c2 + a3 c23 = 0", f"{FOREARM_LINE} = 0",
                   worst(np.linalg.det(jacobian(robot, shoulder, Frame(0, 5))[:, :3, :3]), np.zeros(len(shoulder))),
                   reason="Named by the geometry: " + block.parts[1].name)  # fmt: skip
    offset(sheet)


def offset(sheet: Sheet) -> None:
    """The shoulder singularity of an arm with an offset."""
    robot = open_robot("puma560")
    families = conditions(robot, coranks=1, points=0, special=False).families
    family = next(one for one in families if one.texts == ("a2 c2 + a3 c23 − d4 s23 = 0",))
    q = np.array(family.witness)
    rank = rank_of(robot, q)
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
                "the points become unreachable", f"{rounded(_closest(robot), 5)} m",
                _closest(robot) > 0.15005 - 1e-9)  # fmt: skip


def _closest(robot: Robot) -> float:
    """Smallest distance of the wrist centre from axis 1 over random configurations [m]."""
    return min(float(np.hypot(*link_poses(robot, q)[5][:2, 3])) for q in angles(robot, 500, 8))


SECTIONS = (("frames", frames), ("decoupling", decoupling), ("arm", arm))
