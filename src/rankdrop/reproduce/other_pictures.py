"""The data of the figures of GR and KG, and of the planar arm and the mapping of velocities of ML and JL."""

from __future__ import annotations

import numpy as np

from rankdrop.kinematics import jacobian, link_poses, pose
from rankdrop.local import redundancy
from rankdrop.reproduce import kg_text
from rankdrop.reproduce.gr import example
from rankdrop.reproduce.kg_arm import arm
from rankdrop.reproduce.ml import PLANAR, blow_up
from rankdrop.reproduce.picture import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    Arrow,
    Line,
    Panel,
    Picture,
    against,
    arm_at,
)
from rankdrop.robot import Array, Robot, open_robot
from rankdrop.task import SPACE as BASE
from rankdrop.task import resolve_task

TYPICAL = (0.4, -0.6, 0.5, 1.2, -0.4, 0.8, 0.3)
"""A configuration of a typical redundant arm, the PA-10, at which it is not singular."""


def joint_rates() -> Picture:
    """ML: the planar arm with the axes of link 1, and its joint rates near θ2 = 0."""
    robot, near = open_robot("planar2r"), np.array([0.5, 0.15])
    theta, rates = blow_up()
    size = np.abs(rates)
    lines = (
        Line("|θ̇1| for 1 m/s along x1", against(theta, size[:, 0, 0]), BLUE),
        Line("|θ̇2| for 1 m/s along x1", against(theta, size[:, 1, 0]), RED),
        Line("|θ̇1|, |θ̇2| for 1 m/s along y1", against(theta, size[:, 0, 1]), BLACK, "--"),
    )
    caption = (
        f"Planar arm, a1 = {PLANAR['a1']} m, a2 = {PLANAR['a2']} m, θ2 = {near[1]} rad on the left. Velocities are "
        "those of the tip, along the axes x1 and y1 of link 1: only motion along it costs without bound."
    )
    return Picture("ML", "Joint rates", caption, (
        Panel("(a) axes of link 1", (), link_axes(robot, near, 1, 2), z="z [m]", tall=True,
              arms=(arm_at(robot, near),), view=(60.0, -80.0)),
        Panel("(b)", lines, x="θ2 [deg]", y="joint rate [rad/s]", log="xy"),
    ))  # fmt: skip


def link_axes(robot: Robot, q: Array, link: int, count: int = 3) -> tuple[Arrow, ...]:
    """x, y, z of a link, drawn at the end effector, where the velocities along them are meant."""
    axes, tip = link_poses(robot, q)[link, :3, :3], pose(robot, q)[:3, 3]
    return tuple(
        Arrow(f"{name}{link}", tip, axis, False, colour)
        for name, axis, colour in zip("xyz"[:count], axes.T, (BLUE, RED, GREEN), strict=False)
    )


def planar_arm() -> Picture:
    """ML: the planar arm at its singularities, and the motion that it cannot make there."""
    robot = open_robot("planar2r")
    panels = []
    for title, theta2 in (("θ2 = 0", 0.0), ("θ2 = π", np.pi)):
        q = np.array([0.5, theta2])
        along = link_poses(robot, q)[1, :3, 0]
        tip = pose(robot, q)[:3, 3]
        drawn = (Arrow("lost", tip, along, False, BLUE), Arrow("y1, left", tip, _across(along), False, GREY))
        panels.append(Panel(title, (), drawn, z="z [m]", tall=True, arms=(arm_at(robot, q),), view=(60.0, -80.0)))
    return Picture("ML", "Planar arm", "At its singularities the tip cannot move along x1, the line of link 1.",
                   tuple(panels))  # fmt: skip


def _across(direction: Array) -> Array:
    return np.array([-direction[1], direction[0], 0.0])


def typical_arm() -> Picture:
    """GR Figure 1: a serial redundant manipulator, its links from 0 to m, and the screw of each of its pairs."""
    robot, q = open_robot("pa10"), np.array(TYPICAL)
    drawn = arm_at(robot, q)
    colours = (BLUE, ORANGE, GREEN, RED, BLACK, GREY, BLUE)
    screws = tuple(
        Arrow(f"s{number}", middle, 0.6 * axis, False, colour)
        for number, middle, axis, colour in zip(
            drawn.drawn.numbers, drawn.drawn.middles, drawn.drawn.axes, colours, strict=True)
    )  # fmt: skip
    ends = (
        Line("link 0, the base", np.zeros((1, 3)), BLACK, marks=True),
        Line("link m, the end effector", pose(robot, q)[None, :3, 3], RED, marks=True),
    )
    caption = "A typical serial redundant manipulator. GR name none; ours is the PA-10, m = 7, with its screws."
    return Picture("GR", "Figure 1", caption, (
        Panel("", ends, screws, x="X [m]", y="Y [m]", z="Z [m]", tall=True, arms=(drawn,)),
    ), {"order": list(drawn.drawn.numbers)})  # fmt: skip


def screw_axes() -> Picture:
    """GR Figure 2: the RCRRRR arm and the axes of its seven screws."""
    lines, colours = [], (BLUE, ORANGE, RED, RED, BLUE, BLACK, BLACK)
    data = []
    for number, (screw, colour) in enumerate(zip(example().screws, colours, strict=True), start=1):
        turns = bool(np.linalg.norm(screw[:3]) > 0.0)
        direction = screw[:3] if turns else screw[3:]
        point = np.cross(screw[:3], screw[3:]) if turns else np.zeros(3)
        ends = point + np.outer([-4.0, 4.0], direction / np.linalg.norm(direction))
        lines.append(Line(f"${number}", ends, colour, "-" if turns else ":"))
        data.append({"number": number, "revolute": turns, "direction": direction.tolist(), "point": point.tolist()})
    return Picture("GR", "Figure 2", "The arm and its axes at the singular configuration; $2, a slide, dotted.", (
        Panel("", tuple(lines), x="X", y="Y", z="Z", tall=True, arms=(arm_at(open_robot("rcrrrr"), np.zeros(7)),)),
    ), {"axes": data})  # fmt: skip


def canadarm2() -> Picture:
    """KG Figure 1: the zero-displacement configuration and the link parameters."""
    robot = arm()
    poses = link_poses(robot, np.zeros(7))
    origins = poses[:, :3, 3]
    lines = jacobian(robot, np.zeros(7), BASE).T
    z = tuple(
        Arrow(f"z{j}", origins[j], 0.5 * screw[3:], False, ORANGE if j in (3, 4, 5) else GREY)
        for j, screw in enumerate(lines, start=1)
    )
    columns = ("a_{j-1}", "alpha_{j-1}", "d_j")
    table = [dict(zip(columns, row, strict=True)) | {"theta_j": f"theta_{j}"} for j, row in enumerate(kg_text.DH, 1)]
    return Picture("KG", "Figure 1", "Canadarm2 at θ = 0: axes 3, 4, 5 (orange) are parallel.", (
        Panel("", (), z, z="z [m]", tall=True, arms=(arm_at(robot, np.zeros(7), (3, 4, 5)),)),
    ), {"link_parameters": table, "lengths": kg_text.LENGTHS})  # fmt: skip


def mapping() -> Picture:
    """JL: what J makes of joint rates, at full rank and at a singularity; N(J) and R(J).

    The arm is redundant and small enough to be drawn: three parallel axes, the velocity of the tip in their plane.
    """
    robot = open_robot("planar3r")
    task = resolve_task("planar-position", robot)
    panels, numbers = [], {}
    for name, q in (("full rank", (0.4, 0.9, -0.6)), ("singular", (0.4, 0.0, 0.0))):
        place = np.array(q)
        found = redundancy(robot, place, task)
        J = jacobian(robot, place)[:2]
        rates, null = joint_rate_circles(found.null_basis, row_space(found.projector))
        told = f"dim N(J) = {found.check.nullity}", f"dim R(J) = {found.check.rank}"
        panels += [
            Panel(f"{name}: joint rates, {told[0]}", (*rates, *null), x="θ̇1 [rad/s]", y="θ̇2 [rad/s]", z="θ̇3 [rad/s]",
                  tall=True),
            Panel(f"{name}: velocities, {told[1]}", (
                *(Line(line.label, line.points @ J.T, line.colour, line.dashes) for line in rates),
                Line("N(J), mapped to 0", (null[0].points @ J.T)[:1], RED, marks=True),
            ), x="ẋ [m/s]", y="ẏ [m/s]", tall=True),
        ]  # fmt: skip
        numbers[name] = {"q": list(q), "rank": found.check.rank, "nullity": found.check.nullity}
    caption = (
        "Joint rates and the velocities of the tip that they make, arm with three parallel axes. What is moved along "
        "N(J), red, makes the same velocities, and N(J) itself none; at the singularity R(J) is a line, N(J) a plane."
    )
    return Picture("JL", "Joint to operation", caption, tuple(panels), {"places": numbers})


def row_space(projector: Array) -> Array:
    """(rank, n) orthonormal rows: the joint rates that are orthogonal to the null space."""
    values, vectors = np.linalg.eigh(np.eye(len(projector)) - projector)
    return np.asarray(vectors[:, values > 0.5].T)


def joint_rate_circles(null: Array, rows: Array) -> tuple[tuple[Line, ...], tuple[Line, ...]]:
    """A circle in the row space, or its diameter where that is a line, the same moved along N(J), and N(J)."""
    turn = np.linspace(0.0, 2 * np.pi, 73)
    if len(rows) == 2:
        inside = np.cos(turn)[:, None] * rows[0] + np.sin(turn)[:, None] * rows[1]
    else:
        inside = np.linspace(-1.0, 1.0, 73)[:, None] * rows[0]
    lines = [Line("across N(J), length at most 1", inside, BLUE)]
    lines += [
        Line("the same, moved along N(J)" if share > 0 else "", inside + share * null[0], GREY, dashes)
        for share, dashes in ((0.7, "--"), (-0.7, ":"))
    ]
    ends = [Line("N(J)", np.outer([-1.0, 1.0], null[0]), RED)]
    if len(null) == 2:
        ends.append(Line("", np.cos(turn)[:, None] * null[0] + np.sin(turn)[:, None] * null[1], RED))
    return tuple(lines), tuple(ends)
