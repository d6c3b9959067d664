"""The data of the figures of ML, GR, KG and JL, where there are numbers in them."""

from __future__ import annotations

import numpy as np

from rankdrop.frames import SPACE as BASE
from rankdrop.kinematics import jacobian, link_poses
from rankdrop.local import readable_basis
from rankdrop.reproduce import kg_text
from rankdrop.reproduce.elbow import LENGTHS, elbow_arm
from rankdrop.reproduce.gr import example
from rankdrop.reproduce.jl import WRIST_CENTRE, axes_and_points
from rankdrop.reproduce.kg_arm import arm
from rankdrop.reproduce.ml import PLANAR, blow_up
from rankdrop.reproduce.picture import BLACK, BLUE, GREY, ORANGE, RED, Arrow, Line, Panel, Picture, against
from rankdrop.robot import Array


def joint_rates() -> Picture:
    """ML: the joint rates of the planar arm near θ2 = 0."""
    theta, rates = blow_up()
    size = np.abs(rates)
    lines = (
        Line("|θ̇1| for 1 m/s along x", against(theta, size[:, 0, 0]), BLUE),
        Line("|θ̇2| for 1 m/s along x", against(theta, size[:, 1, 0]), RED),
        Line("|θ̇1|, |θ̇2| for 1 m/s across", against(theta, size[:, 0, 1]), BLACK, "--"),
    )
    caption = f"Planar arm, a1 = {PLANAR['a1']} m, a2 = {PLANAR['a2']} m: only motion along it costs without bound."
    return Picture("ML", "Joint rates", caption, (
        Panel("", lines, x="θ2 [deg]", y="joint rate [rad/s]", log="xy"),
    ))  # fmt: skip


def screw_axes() -> Picture:
    """GR Figure 2: the axes of the seven screws."""
    lines, colours = [], (BLUE, ORANGE, RED, RED, BLUE, BLACK, BLACK)
    data = []
    for number, (screw, colour) in enumerate(zip(example().screws, colours, strict=True), start=1):
        turns = bool(np.linalg.norm(screw[:3]) > 0.0)
        direction = screw[:3] if turns else screw[3:]
        point = np.cross(screw[:3], screw[3:]) if turns else np.zeros(3)
        ends = point + np.outer([-4.0, 4.0], direction / np.linalg.norm(direction))
        lines.append(Line(f"${number}", ends, colour, "-" if turns else ":"))
        data.append({"number": number, "revolute": turns, "direction": direction.tolist(), "point": point.tolist()})
    return Picture("GR", "Figure 2", "The axes at the singular configuration; $2, a slide, dotted.", (
        Panel("", tuple(lines), x="X", y="Y", z="Z", tall=True),
    ), {"axes": data})  # fmt: skip


def canadarm2() -> Picture:
    """KG Figure 1: the zero-displacement configuration and the link parameters."""
    robot = arm()
    poses = link_poses(robot, np.zeros(7))
    origins = poses[:, :3, 3]
    lines = jacobian(robot, np.zeros(7), BASE).T
    z = tuple(
        Arrow(f"z{j}", origins[j], screw[3:], False, BLUE if j in (3, 4, 5) else GREY)
        for j, screw in enumerate(lines, start=1)
    )
    columns = ("a_{j-1}", "alpha_{j-1}", "d_j")
    table = [dict(zip(columns, row, strict=True)) | {"theta_j": f"theta_{j}"} for j, row in enumerate(kg_text.DH, 1)]
    return Picture("KG", "Figure 1", "Canadarm2 at θ = 0: axes 3, 4, 5 (blue) are parallel.", (
        Panel("", (Line("", origins, BLACK, marks=True),), z, x="x [m]", y="y [m]", z="z [m]", tall=True),
    ), {"link_parameters": table, "lengths": kg_text.LENGTHS})  # fmt: skip


def lost_by_elbow_and_shoulder() -> Picture:
    """JL: elbow and shoulder singularity, and the linear motion lost by the wrist centre."""
    theta2 = 0.7
    theta3 = float(np.arccos(-LENGTHS["a2"] * np.cos(theta2) / LENGTHS["a3"])) - theta2
    places = {"elbow singularity": (0.3, theta2, 0.0, 0.6, 0.5, 0.2), "shoulder singularity": (0.3, theta2, theta3,
        0.6, 0.5, 0.2)}
    panels = []
    for title, q in places.items():
        _, points, _ = axes_and_points(np.array([q]))
        panels.append(Panel(
            title, (Line("", points[0, :4], BLACK, marks=True), Line("z0", np.array([[0, 0, -0.2], [0, 0, 0.8]]), GREY,
            "--")),
            (Arrow("lost", points[0, 3], lost_by_centre(np.array(q)), False, BLUE),), x="x [m]", y="y [m]", z="z [m]",
            tall=True,
        ))  # fmt: skip
    return Picture("JL", "Arm singularities", "The linear motion that the wrist centre loses.", tuple(panels))


def lost_by_centre(q: Array) -> Array:
    """(3,) the direction in which the wrist centre of the elbow arm cannot move at an arm singularity [1]."""
    moves = jacobian(elbow_arm(), q, WRIST_CENTRE)[:3, :3]
    return np.asarray(readable_basis(np.linalg.svd(moves)[0][:, 2:])[:, 0])
