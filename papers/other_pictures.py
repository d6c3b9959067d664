"""The data of the figures of GR and KG, and of ML and JL: the planar arm, the mapping of velocities, the elbow arm.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from papers import kg_text
from papers.elbow import LENGTHS, elbow_arm
from papers.gr import example
from papers.jl import WRIST_CENTRE, axes_and_points
from papers.kg_arm import arm
from papers.ml import PLANAR, blow_up
from papers.picture import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    Arm,
    Arrow,
    Line,
    Panel,
    Picture,
    against,
    arm_at,
)
from rankdrop.kinematics import jacobian, link_poses, pose
from rankdrop.local import readable_basis, redundancy
from rankdrop.robot import Array, Robot, open_robot
from rankdrop.task import SPACE as BASE
from rankdrop.task import resolve_task

REGULAR = (0.3, 0.7, 0.9, 0.6, 0.8, 0.2)
"""A configuration with nothing special about it."""
FROM = (24.0, -20.0)
"""Where the arm is seen from, so that axes z1 and z2 are not seen end on: elevation and azimuth [deg]."""
WRIST = 0.3
"""Length that the wrist is drawn in proportion to [m]; the links of the arm are longer."""


def elbow_and_shoulder() -> dict[str, Array]:
    """(6,) a configuration at each arm singularity."""
    theta2 = REGULAR[1]
    theta3 = float(np.arccos(-LENGTHS["a2"] * np.cos(theta2) / LENGTHS["a3"])) - theta2
    places = {"elbow": 0.0, "shoulder": theta3}
    return {name: np.array([*REGULAR[:2], value, *REGULAR[3:]]) for name, value in places.items()}


def elbow_arm_figure(document: str) -> Picture:
    """The arm with its axes z0 … z5."""
    q = np.array(REGULAR)
    z, p, _ = axes_and_points(q[None])
    colours = (BLUE, RED, GREEN, ORANGE, BLACK, GREY)
    axes = tuple(
        Arrow(f"z{i}", p[0, i], 0.7 * z[0, i], False, colour) for i, colour in zip(range(6), colours, strict=True)
    )
    caption = (
        f"Elbow arm with spherical wrist, a2 = {LENGTHS['a2']} m, a3 = {LENGTHS['a3']} m, α1 = π/2: axes z0 and z1 "
        "meet in p0 = p1, axes z3, z4, z5 in the wrist centre p3 = p4 = p5."
    )
    name = {"ML": "Articulated arm", "JL": "Anthropomorphic arm"}[document]
    return Picture(document, name, caption, (
        Panel("", (), axes, z="z [m]", tall=True, arms=(arm_at(elbow_arm(), q),), view=FROM),
    ), {"points": p[0].tolist()})  # fmt: skip


def arm_singularities(document: str) -> Picture:
    """Elbow and shoulder singularity, and the linear motion that the wrist centre loses."""
    panels = []
    for title, q in elbow_and_shoulder().items():
        _, points, _ = axes_and_points(q[None])
        marked = {"elbow": (2, 3), "shoulder": (1,)}[title]
        panels.append(Panel(
            f"{title} singularity", (Line("z0", np.array([[0, 0, -0.2], [0, 0, 0.9]]), GREY, "--"),),
            (Arrow("lost by the wrist centre", points[0, 3], lost_by_centre(q), False, BLUE),), z="z [m]", tall=True,
            arms=(arm_at(elbow_arm(), q, marked),), view=FROM,
        ))  # fmt: skip
    caption = (
        "Elbow: θ3 = 0, the wrist centre cannot move along the third link. Shoulder: a2 c2 + a3 c23 = 0, the wrist "
        "centre is on z0 and cannot move along z1."
    )
    return Picture(document, "Arm singularities", caption, tuple(panels))


def lost_by_centre(q: Array) -> Array:
    """(3,) the direction in which the wrist centre of the elbow arm cannot move at an arm singularity [1]."""
    moves = jacobian(elbow_arm(), q, WRIST_CENTRE)[:3, :3]
    return np.asarray(readable_basis(np.linalg.svd(moves)[0][:, 2:])[:, 0])


def spherical_wrist(document: str) -> Picture:
    """The wrist at θ5 ≠ 0 and at its singularities, with the rotation lost there."""
    panels = []
    for title, theta5 in (("θ5 = 0.8", REGULAR[4]), ("θ5 = 0", 0.0), ("θ5 = π", np.pi)):
        q = np.array([*REGULAR[:4], theta5, REGULAR[5]])
        z, p, _ = axes_and_points(q[None])
        centre, singular = p[0, 3], abs(np.sin(theta5)) < 1e-9
        axes = [
            Arrow(f"z{i}", centre, (1.0 if i < 5 else 1.25) * z[0, i], False, colour)
            for i, colour in ((3, BLUE), (4, RED), (5, GREEN))
        ]
        if singular:
            axes.append(Arrow("rotation lost", centre, lost_by_wrist(q), True, BLACK))
        panels.append(Panel(
            title, (Line("", p[0, 3] - np.outer([0.15, 0.0], forearm(q)), GREY),), tuple(axes), z="z [m]", tall=True,
            arms=(wrist_at(q, (4, 6) if singular else ()),),
        ))  # fmt: skip
    caption = (
        "Spherical wrist. At θ5 = 0 and π axes z3 and z5 are aligned, and the end effector cannot rotate about the "
        "dotted axis, which is orthogonal to z3 and z4. Joints are drawn apart on their axes, which meet in one point."
    )
    return Picture(document, "Spherical wrist", caption, tuple(panels))


def lost_by_wrist(q: Array) -> Array:
    """(3,) the axis about which the wrist cannot turn the end effector at its singularity [1]."""
    turns = jacobian(elbow_arm(), q, WRIST_CENTRE)[3:, 3:]
    return np.asarray(np.linalg.svd(turns)[0][:, 2])


def forearm(q: Array) -> Array:
    """(3,) direction of the third link [1]."""
    poses = link_poses(elbow_arm(), q)
    return np.asarray((poses[3, :3, 3] - poses[2, :3, 3]) / LENGTHS["a3"])


def wrist_at(q: Array, marked: tuple[int, ...]) -> Arm:
    """Joints 4 to 6 of the elbow arm and its hand; two points of its links belong to each joint, after the base."""
    whole = arm_at(elbow_arm(), q, marked)
    drawn = whole.drawn
    part = replace(
        drawn, links=drawn.links[7:], middles=drawn.middles[3:], axes=drawn.axes[3:], slides=drawn.slides[3:],
        numbers=drawn.numbers[3:],
    )  # fmt: skip
    return replace(whole, drawn=part, size=WRIST)


def pictures(document: str) -> tuple[Picture, ...]:
    """Those of one lecture, ML or JL."""
    return (elbow_arm_figure(document), spherical_wrist(document), arm_singularities(document))


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
