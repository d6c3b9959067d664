"""Arms for the tests: DH tables made into screws here, not by the product, and random chains of every joint kind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rankdrop.robot.model import Array, Joint, JointKind, Mimic, Robot
from reference import kinematics

HALF = np.pi / 2


def rigid(rng: np.random.Generator, shift: float = 1.0) -> Array:
    """A random rigid motion."""
    motion = np.eye(4)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    motion[:3, :3] = turn * np.sign(np.linalg.det(turn))
    motion[:3, 3] = rng.normal(size=3) * shift
    return motion


def adjoint(motion: Array) -> Array:
    """(6, 6) matrix that carries a twist (v; ω) along a rigid motion."""
    turn, shift = motion[:3, :3], motion[:3, 3]
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = matrix[3:, 3:] = turn
    matrix[:3, 3:] = np.cross(shift, turn, axisb=0).T
    return matrix


def standard_dh(name: str, rows: list[tuple[float, ...]], task: str = "pose") -> Robot:
    """Standard DH, T = Rz(θ) Tz(d) Tx(a) Rx(α), rows (a, α, d, θ offset[, 1 for prismatic])."""
    motion, joints = np.eye(4), []
    for number, (a, alpha, d, theta, *prismatic) in enumerate(rows, 1):
        z, origin = motion[:3, 2], motion[:3, 3]
        kind = JointKind.PRISMATIC if any(prismatic) else JointKind.REVOLUTE
        screw = np.r_[z, 0, 0, 0] if any(prismatic) else np.r_[np.cross(origin, z), z]
        about_z = kinematics.exponential(np.array([0, 0, 0, 0, 0, 1.0]), theta)
        about_x = kinematics.exponential(np.array([0, 0, 0, 1.0, 0, 0]), alpha)
        about_z[2, 3], about_x[0, 3] = d, a
        motion = motion @ about_z @ about_x
        joints.append(Joint(f"joint{number}", kind, screw, frame=motion))
    return Robot(name, tuple(joints), home=motion, task=task)


def pa10() -> Robot:
    """AM Table 2."""
    alpha = (-HALF, HALF, -HALF, HALF, -HALF, HALF, 0.0)
    return standard_dh("pa10", [(0, x, d, 0) for x, d in zip(alpha, (0, 0, 0.45, 0, 0.5, 0, 0.45), strict=True)])


def almarkhi4() -> Robot:
    """AM Table 1, a regional arm for the position task."""
    root2 = 2**0.5
    rows = [(root2, HALF, 0, 0), (root2, -HALF, 1, 0), (root2, HALF, -1, 0), (3**0.5 / 2, 0, 0.5, 0)]
    return standard_dh("almarkhi4", rows, task="position")


def puma() -> Robot:
    """A PUMA-like 6R with shoulder offset and spherical wrist."""
    arm = [(0, HALF, 0, 0), (0.43, 0, 0.15, 0), (0.02, -HALF, 0, 0)]
    wrist = [(0, HALF, 0.43, 0), (0, -HALF, 0, 0), (0, 0, 0.06, 0)]
    return standard_dh("puma", [*arm, *wrist])


def scara() -> Robot:
    """Two parallel turns, a slide, a turn: generic rank 4 of the pose."""
    return standard_dh("scara", [(0.4, 0, 0.3, 0), (0.3, np.pi, 0, 0), (0, 0, 0, 0, 1), (0, 0, 0.05, 0)], task="scara")


def planar3r() -> Robot:
    """Three parallel axes."""
    return standard_dh("planar3r", [(0.5, 0, 0, 0), (0.4, 0, 0, 0), (0.2, 0, 0, 0)], task="planar")


def random_chain(rng: np.random.Generator, kinds: str) -> Robot:
    """A chain of random screws; one letter a joint: r, p, h (revolute, prismatic, helical), m a revolute mimic joint.

    A mimic joint follows the first joint that is not one, before or behind it in the chain.
    """
    leader = next(i for i, kind in enumerate(kinds) if kind != "m")
    joints = []
    for i, letter in enumerate(kinds):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        pitch = rng.normal() * 0.3 if letter == "h" else 0.0
        turning = np.r_[np.cross(rng.normal(size=3), axis) + pitch * axis, axis]
        kind = {"p": JointKind.PRISMATIC, "h": JointKind.HELICAL}.get(letter, JointKind.REVOLUTE)
        mimic = Mimic(f"j{leader}", rng.uniform(-2, 2), rng.normal()) if letter == "m" else None
        screw = np.r_[axis, 0, 0, 0] if letter == "p" else turning
        joints.append(Joint(f"j{i}", kind, screw, lower=-np.pi, upper=np.pi, frame=rigid(rng), mimic=mimic))
    return Robot(f"random {kinds}", tuple(joints), home=rigid(rng))


_CHAINS = "r p rrr rpr rhr rrrrrr rrprrr hrprhr rrrrrrr rrmrrrr mrrhpmr rrrrrrrr rrrprrrrr"
CHAINS = tuple(_CHAINS.split())
"""Kinds of chain that every law is tried on: each joint kind, 1 to 9 joints, mimic before its leader too."""


def remade(robot: Robot, *, motion: Array | None = None, length: float = 1.0, sign: float = 1.0) -> Robot:
    """The arm mounted elsewhere, in another unit of length (`length` of them to the old one), with reversed joints."""
    motion = np.eye(4) if motion is None else motion

    def moved(matrix: Array) -> Array:
        scaled = matrix.copy()
        scaled[:3, 3] *= length
        return motion @ scaled

    joints = []
    for joint in robot.joints:
        screw = joint.screw.copy()
        if joint.kind is not JointKind.PRISMATIC:
            screw[:3] *= length
        limit = length if joint.kind is JointKind.PRISMATIC else 1.0
        joints.append(
            replace(
                joint,
                screw=sign * adjoint(motion) @ screw,
                frame=moved(joint.frame),
                lower=joint.lower * limit,
                upper=joint.upper * limit,
                mimic=joint.mimic and replace(joint.mimic, offset=sign * joint.mimic.offset),
            )
        )
    return replace(robot, joints=tuple(joints), home=moved(robot.home))


def reversed_chain(robot: Robot) -> Robot:
    """The same mechanism held at its tip: T'(q reversed) = T(q)⁻¹."""
    back = np.linalg.inv(robot.home)
    turned = [Joint(j.name, j.kind, -adjoint(back) @ j.screw) for j in reversed(robot.joints)]
    return Robot(f"{robot.name} reversed", tuple(turned), home=back, task=robot.task)


def in_other_words(robot: Robot, rng: np.random.Generator) -> tuple[Robot, Robot, Robot]:
    """What does not change the arm at q = 0: another base, another tool, all joints counted the other way."""
    elsewhere = remade(robot, motion=rigid(rng, 2.0))
    return elsewhere, replace(robot, home=robot.home @ rigid(rng)), remade(robot, sign=-1.0)


def singular_configurations(name: str, rng: np.random.Generator, count: int) -> tuple[Robot, Array]:
    """An arm and `count` exactly singular configurations of it, from closed forms; the other joints at random.

    pa10: the rows of AM's Tables 3 to 5 in turn. puma: θ5 ∈ {0, π}. scara, planar3r: θ2 ∈ {0, π}.
    """
    robot = {"pa10": pa10, "puma": puma, "scara": scara, "planar3r": planar3r}[name]()
    rows: list[dict[int, tuple[float, ...]]] = {
        "pa10": PA10_ROWS,
        "puma": [{5: (0.0, np.pi)}],
        "scara": [{2: (0.0, np.pi)}],
        "planar3r": [{2: (0.0, np.pi)}],
    }[name]
    q = rng.uniform(-np.pi, np.pi, (count, robot.n))
    for b in range(count):
        for joint, values in rows[b % len(rows)].items():
            q[b, joint - 1] = rng.choice(values)
    return robot, q


_FLAT, _RIGHT = (0.0, np.pi), (HALF, -HALF)
PA10_ROWS: list[dict[int, tuple[float, ...]]] = [
    {2: _FLAT, 3: _RIGHT},  # AM Table 3, corank 1
    {2: _FLAT, 6: _FLAT},
    {4: _FLAT},
    {5: _RIGHT, 6: _FLAT},
    {2: _FLAT, 3: _FLAT, 4: _FLAT},  # AM Table 4, corank 2
    {2: _FLAT, 4: _FLAT, 6: _FLAT},
    {4: _FLAT, 5: _FLAT, 6: _FLAT},
    {2: _FLAT, 3: _RIGHT, 5: _RIGHT, 6: _FLAT},
    {2: _FLAT, 3: _FLAT, 4: _FLAT, 5: _FLAT, 6: _FLAT},  # AM Table 5, corank 3
]
"""Singular rows of the PA-10: joint number to the values it may take."""
