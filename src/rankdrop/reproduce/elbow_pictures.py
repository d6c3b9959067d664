"""The data of ML's and JL's figures of the elbow arm: the arm, its wrist, and its singularities."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rankdrop.kinematics import jacobian, link_poses
from rankdrop.local import readable_basis
from rankdrop.reproduce.elbow import LENGTHS, elbow_arm
from rankdrop.reproduce.jl import WRIST_CENTRE, axes_and_points
from rankdrop.reproduce.picture import (
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
    arm_at,
)
from rankdrop.robot import Array

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
