"""JL: Jin's Lecture 13, Singularity and Redundancy. Decoupling, the motions lost, null space, range and projector."""

from __future__ import annotations

from math import pi

import numpy as np

from papers.elbow import (
    FOREARM_LINE,
    LENGTHS,
    angles,
    arm_sign,
    decoupled,
    elbow_arm,
    on_shoulder,
    shoulder_text,
    worst,
)
from papers.item import Sheet, Shown, listed, rounded
from rankdrop.kinematics import jacobian, link_poses
from rankdrop.local import generic_rank, null_space_motion, rate_growth, redundancy
from rankdrop.robot import Array, open_robot
from rankdrop.task import Frame, resolve_task

WRIST_CENTRE = Frame(0, 5)


def axes_and_points(q: Array) -> tuple[Array, Array, Array]:
    """(B, 6, 3) z_0 … z_5, (B, 6, 3) p_0 … p_5 and (B, 3) p_e of the elbow arm, JL's frames."""
    poses = np.array([link_poses(elbow_arm(), one) for one in q])
    return poses[:, :6, :3, 2], poses[:, :6, :3, 3], poses[:, -1, :3, 3]


def definition(sheet: Sheet) -> None:
    """The Jacobian and singularity."""
    robot = elbow_arm()
    task = resolve_task(None, robot)
    there = np.array([0.3, 0.4, 0.0, 0.6, 0.5, 0.7])
    found = redundancy(robot, there)
    sheet.numbers("Singularity", "rank of J where θ3 = 0 (elbow arm, r = 6)", "5", found.rank.rank,
                  layout="rank J < r", reason="Any rank below 6 is meant; a single condition takes one.")  # fmt: skip
    sheet.claim("Singularity", "mobility at a singularity", "mobility is reduced",
                f"{generic_rank(robot, task) - found.rank.rank} of 6 motions lost",
                generic_rank(robot, task) > found.rank.rank)  # fmt: skip
    growth = rate_growth(robot, there, [0, 0, 1, 0, 0, 0])
    sheet.claim("Singularity", "joint rates near a singularity",
                "small velocities in the operational space can correspond to large velocities in the joint space",
                f"along the weakest direction they grow as 1/distance^{growth.power:.1f}", abs(growth.power - 1) < 0.1)


def blocks(sheet: Sheet) -> None:
    """Singularity decoupling: the blocks of J, before and after the row operations."""
    robot = elbow_arm()
    q = angles(robot, 20, 1)
    J, (z, p, e) = jacobian(robot, q), axes_and_points(q)
    columns = np.cross(z, e[:, None] - p).swapaxes(1, 2)
    third = np.cross(z[:, 2], e - p[:, 0])
    sheet.identity("J11", "columns 1 and 2", "z0 × (pe − p0), z1 × (pe − p1)", worst(columns[..., :2], J[:, :3, :2]))
    _third(sheet, "J11", "z2 × (pe − p0)", "z2 × (pe − p2)", third, columns[..., 2], J[:, :3, 2])
    sheet.identity("J21, J22", "rotation rows", "z0 … z5", worst(z.swapaxes(1, 2), J[:, 3:]))
    sheet.identity("J12", "columns 4 to 6", "z_i × (pe − p_i), i = 3, 4, 5", worst(columns[..., 3:], J[:, :3, 3:]))
    sheet.identity("decoupling", "origins of frames 3, 4, 5", "p3 = p4 = p5", max(worst(p[:, 3], p[:, 4]), worst(p[:,
                   4], p[:, 5])))
    centre = jacobian(robot, q, WRIST_CENTRE)
    moved = np.cross(z, p[:, 3:4] - p).swapaxes(1, 2)
    sheet.identity("J̄11", "columns 1 and 2", "z0 × (p3 − p0), z1 × (p3 − p1)", worst(moved[..., :2], centre[:, :3, :2]))
    _third(sheet, "J̄11", "z2 × (p3 − p1)", "z2 × (p3 − p2)", np.cross(z[:, 2], p[:, 3] - p[:, 1]), moved[..., 2],
           centre[:, :3, 2])  # fmt: skip
    sheet.identity("J̄", "upper right block", "0", float(np.abs(centre[:, :3, 3:]).max()))
    arm = e - p[:, 3]
    reduced = J[:, :3] - np.cross(J[:, 3:], arm[:, :, None], axis=1)
    sheet.identity("J̄", "rows of J after the row operations with pe − p3", "first rows − (second rows) × (pe − p3)",
                   worst(reduced, centre[:, :3]))  # fmt: skip
    determinants = np.linalg.det(centre[:, :3, :3]) * np.linalg.det(centre[:, 3:, 3:])
    sheet.identity("det J", "det J and det J̄", "det J = det J̄ = det J̄11 det J̄22",
                   max(worst(np.linalg.det(J), determinants), worst(np.linalg.det(centre), determinants)))  # fmt: skip


def _third(sheet: Sheet, item: str, printed: str, right: str, theirs: Array, corrected: Array, measured: Array) -> None:
    """The third column of J11, where a point has the wrong index."""
    error, own = worst(theirs, measured), worst(corrected, measured)
    sheet.identity(item, "column 3", printed, error, ours=right, reason="Axis 3 passes through p2.",
                   shown=Shown(f"As printed it is off by up to {rounded(error, 2)} m per rad; with p2 it is column 3.",
                               error > 0.05 and own < 1e-12))  # fmt: skip


def wrist(sheet: Sheet) -> None:
    """Wrist singularity."""
    part = decoupled().blocks[1].parts[0]
    sheet.same("Wrist singularity", "where det J̄22 = 0", "θ5 = 0 or π", part.text)
    q = np.array([[0.3, 0.4, 0.5, 0.6, end, 0.7] for end in (0.0, pi)])
    z, _, _ = axes_and_points(q)
    turns = jacobian(elbow_arm(), q, WRIST_CENTRE)[:, 3:, 3:]
    lost = np.linalg.svd(turns)[0][:, :, 2]
    sheet.identity("Wrist singularity", "axes z3 and z5 there", "aligned", float(np.abs(np.cross(z[:, 3], z[:,
                   5])).max()))
    sheet.identity("Wrist singularity", "rotation lost: its axis against z4 and z3", "orthogonal to z4 and z3",
                   float(max(np.abs(np.einsum("bi,bi->b", lost, z[:, i])).max() for i in (3, 4))),
                   reason="Ours in words: " + part.statement + ".")  # fmt: skip


def arm(sheet: Sheet) -> None:
    """Arm singularity: elbow and shoulder."""
    robot, (elbow, shoulder) = elbow_arm(), decoupled().blocks[0].parts
    sheet.identity("det J̄11", "of the elbow arm, α1 = π/2", f"−a2 a3 s3 ({FOREARM_LINE})",
                   worst(arm_sign("pi/2"), -np.ones(20)))  # fmt: skip
    sheet.same("Elbow singularity", "where", "θ3 = 0 or π", elbow.text)
    q = np.array([[0.3, 0.7, 0.0, 0.6, 0.5, 0.2], [-1.0, 0.4, pi, 0.6, 0.5, 0.2]])
    z, p, _ = axes_and_points(q)
    lost = np.linalg.svd(jacobian(robot, q, WRIST_CENTRE)[:, :3, :3])[0][:, :, 2]
    forearm = (p[:, 3] - p[:, 2]) / LENGTHS["a3"]
    sheet.identity("Elbow singularity", "linear motion lost by the wrist centre",
                   "along the direction of the third link",
                   float(np.abs(np.cross(lost, forearm)).max()), reason="Ours in words: " + elbow.statement + ".")
    sheet.identity("Elbow singularity", "the same direction against z2", "perpendicular to z2",
                   float(np.abs(np.einsum("bi,bi->b", lost, z[:, 2])).max()))  # fmt: skip
    along = np.abs(np.einsum("bi,bi->b", lost, z[:, 0]))
    sheet.identity(
        "Elbow singularity", "the same direction against z0", "perpendicular to z0", float(along.max()),
        ours=f"at {rounded(float(np.degrees(np.arccos(along[0]))), 1)}° to z0 where θ2 = 0.7, θ3 = 0",
        reason="The third link is perpendicular to z0 only where it is level.",
        shown=Shown(f"|u·z0| = {listed(along, 3)} = |sin θ2| at two elbow singularities.",
                    bool(worst(along, np.abs(np.sin(q[:, 1]))) < 1e-9)),
    )  # fmt: skip
    there = on_shoulder()
    z, p, _ = axes_and_points(there)
    sheet.identity("Shoulder singularity", "det J̄11 where a2 c2 + a3 c23 = 0", f"{FOREARM_LINE} = 0",
                   float(np.abs(np.linalg.det(jacobian(robot, there, WRIST_CENTRE)[:, :3, :3])).max()),
                   reason="The exact condition is " + shoulder_text() + ".")  # fmt: skip
    sheet.identity("Shoulder singularity", "distance of the wrist point from axis z0", "lies on axis z0",
                   float(np.abs(p[:, 3, :2]).max()))  # fmt: skip
    lost = np.linalg.svd(jacobian(robot, there, WRIST_CENTRE)[:, :3, :3])[0][:, :, 2]
    sheet.identity("Shoulder singularity", "linear motion lost by the wrist centre", "along the z1 direction",
                   float(np.abs(np.cross(lost, z[:, 1])).max()), reason="Ours in words: " + shoulder.statement + ".")


def spaces(sheet: Sheet) -> None:
    """Redundancy: range, null space, their dimensions."""
    robot = open_robot("pa10")
    regular = np.array([0.3, -0.4, 1.1, 0.9, -0.7, 1.3, 0.5])
    singular = np.where(np.arange(7) == 3, 0.0, regular)
    rows = []
    for q, name in ((regular, "full rank"), (singular, "at a singularity")):
        found = redundancy(robot, q)
        rows.append(found)
        sheet.claim(
            "Redundancy", f"PA-10, {name}: dim R(J), dim N(J)",
            "r, n − r" if name == "full rank" else "smaller, larger, sum n",
            f"{found.check.rank}, {found.check.nullity} of n = 7",
            found.check.holds and (found.check.rank, found.check.nullity) == ((6, 1) if name == "full rank" else (5,
            2)),
        )  # fmt: skip
    sheet.identity("Redundancy", "null motions leave the end effector still", "J q̇ = 0 for q̇ in N(J)",
                   max(worst(jacobian(robot, q) @ found.null_basis.T, np.zeros((6, found.check.nullity)))
                       for q, found in zip((regular, singular), rows, strict=True)))  # fmt: skip
    twist = np.array([0.1, 0.2, -0.1, 0.3, 0.1, 0.2])
    made = null_space_motion(robot, regular, twist, np.zeros(7))
    sheet.identity("Redundancy", "at full rank every end-effector velocity can be generated", "R(J) spans ℝʳ",
                   worst(jacobian(robot, regular) @ made, twist))  # fmt: skip
    lost = np.linalg.svd(jacobian(robot, singular))[0][:, 5]
    short = jacobian(robot, singular) @ np.linalg.pinv(jacobian(robot, singular), rcond=1e-9) @ lost
    sheet.claim("Redundancy", "at a singularity some velocities never can", "no matter what joint velocities",
                f"J J⁺u of a lost direction u has length {rounded(float(np.linalg.norm(short)), 6)}",
                float(np.abs(short).max()) < 1e-9)  # fmt: skip


def projector(sheet: Sheet) -> None:
    """The projection matrix on the null space."""
    robot = open_robot("pa10")
    regular = np.array([0.3, -0.4, 1.1, 0.9, -0.7, 1.3, 0.5])
    for q, name in ((regular, "regular"), (np.where(np.arange(7) == 3, 0.0, regular), "singular")):
        found = redundancy(robot, q)
        P = found.projector
        sheet.identity("P", f"I − Jᵀ(J Jᵀ)†J against I − J⁺J, PA-10, {name}", "P = I − Jᵀ(J Jᵀ)†J", found.difference,
                       reason="Near a singularity, not at it, the printed form loses half of the digits.")  # fmt: skip
        sheet.identity("P", f"J P, PP − P, and rank of P, {name}", "R(P) ≡ N(J)",
                       max(worst(jacobian(robot, q) @ P, np.zeros((6, 7))), worst(P @ P, P),
                           abs(float(np.trace(P)) - found.check.nullity)))  # fmt: skip
    planar = redundancy(open_robot("planar2r"), [0.3, 0.8])
    sheet.claim(
        "P", "when there is a projector to be found", "if N(J) ≠ ∅",
        f"planar arm: nullity {planar.check.nullity}, rank of P {np.linalg.matrix_rank(planar.projector, tol=1e-9)}",
        planar.check.nullity > 0,
        reason="A null space is never empty: N(J) ≠ {0} is meant.",
        shown=Shown(f"Nullity {planar.check.nullity} there.",
        planar.check.nullity == 0 and not planar.projector.round(9).any()),
    )  # fmt: skip
    twist, secondary = np.array([0.1, 0.2, -0.1, 0.3, 0.1, 0.2]), np.arange(1.0, 8.0)
    both = null_space_motion(robot, regular, twist, secondary)
    sheet.identity("P (commented out in the source)", "J q̇ for q̇ = q̇* + P q̇0", "is a solution",
                   worst(jacobian(robot, regular) @ both, twist))  # fmt: skip


SECTIONS = (
    ("definition", definition), ("decoupling", blocks), ("wrist", wrist), ("arm", arm), ("spaces", spaces),
    ("projector", projector),
)  # fmt: skip
