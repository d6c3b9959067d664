"""What certificates speak of, in plain NumPy: joint columns seen from a link, their derivatives, U₁ᵀ J V₁ − Σ."""

from __future__ import annotations

from typing import Any

import numpy as np

from rankdrop.robot.model import Array, Joint, JointKind, Mimic, Robot
from reference import kinematics as oracle
from reference.arms import adjoint


def columns(robot: Robot, q: Array, setting: Any) -> Array:
    """(..., N, 6) joint screws, without multipliers, in axes and at the point of the setting's link, in its length."""
    motions = oracle.carried(robot, q)
    axes = oracle.link_pose(robot, motions, setting.link)[0]
    point = (axes[..., :3, :3] @ np.array(setting.point) + axes[..., :3, 3])[..., None, :]
    s = oracle.screws(robot, motions)
    v = s[..., :3] + oracle.cross(s[..., 3:], point)
    turn = axes[..., None, :3, :3].swapaxes(-1, -2)
    return np.concatenate(
        [(turn @ v[..., None])[..., 0] / setting.length, (turn @ s[..., 3:, None])[..., 0]], axis=-1
    )  # fmt: skip


def jacobian(robot: Robot, q: Array, setting: Any) -> Array:
    """(..., m, n) rows of the setting."""
    full = columns(robot, q, setting).swapaxes(-1, -2) @ oracle.coupling(robot)[0]
    return full[..., list(setting.rows), :]


def change(robot: Robot, q: Array, setting: Any, delta: Array, sigma: Array, u: Array, v: Array) -> Array:
    """(..., r, r) E = U₁ᵀ J(q + δ) V₁ − Σ, δ in units of the setting's scale."""
    return u.T @ jacobian(robot, q + delta * setting.scale, setting) @ v - np.diag(sigma)


def derivatives(robot: Robot, q: Array, setting: Any) -> tuple[list[tuple[int, int, float]], ...]:
    """Of every column i: (i, number of slides, norm) of all first, second and third derivatives by joint values.

    Brackets with the joints between column and link, the outermost nearest to the link, in lengths of the setting.
    """
    s = columns(robot, q, setting)
    rows = list(setting.rows)
    unit = np.array([setting.length if joint.kind is JointKind.PRISMATIC else 1.0 for joint in robot.joints])
    out: tuple[list[tuple[int, int, float]], ...] = ([], [], [])

    def deeper(i: int, twist: Array, between: list[int], slides: int, order: int) -> None:
        for place, k in enumerate(between):
            moved = oracle.bracket(s[k] * unit[k], twist)
            count = slides + (robot.joints[k].kind is JointKind.PRISMATIC)
            out[order].append((i, count, float(np.linalg.norm(moved[rows]))))
            if order < 2:
                deeper(i, moved, between[place:], count, order + 1)

    for i in range(len(s)):  # `between` runs from the column to the link
        between = list(range(i + 1, setting.link)) if i < setting.link else list(range(i - 1, setting.link - 1, -1))
        deeper(i, s[i], between, 0, 0)
    return out




def moved_base(robot: Robot, motion: Array) -> Robot:
    """The same arm elsewhere."""
    carry = adjoint(motion)
    joints = [
        Joint(joint.name, joint.kind, carry @ joint.screw, joint.lower, joint.upper, joint.velocity,
              motion @ joint.frame, joint.mimic)
        for joint in robot.joints
    ]  # fmt: skip
    return Robot(robot.name, tuple(joints), motion @ robot.home, robot.task)


def scaled(robot: Robot, factor: float) -> Robot:
    """The same arm so many times larger, slides and their travel included."""

    def pose(frame: Array) -> Array:
        out = frame.copy()
        out[:3, 3] *= factor
        return out

    joints = []
    for joint in robot.joints:
        slide = joint.kind is JointKind.PRISMATIC
        screw = joint.screw if slide else joint.screw * np.r_[[factor] * 3, 1, 1, 1]
        low, high = (joint.lower * factor, joint.upper * factor) if slide else (joint.lower, joint.upper)
        joints.append(Joint(joint.name, joint.kind, screw, low, high, joint.velocity, pose(joint.frame), joint.mimic))
    return Robot(robot.name, tuple(joints), pose(robot.home), robot.task)


def flipped(robot: Robot, which: list[int]) -> Robot:
    """The same arm with some joints counted the other way."""
    joints = [
        Joint(joint.name, joint.kind, -joint.screw if i in which else joint.screw, frame=joint.frame, mimic=joint.mimic)
        for i, joint in enumerate(robot.joints)
    ]  # fmt: skip
    return Robot(robot.name, tuple(joints), robot.home, robot.task)


def coupled(rng: np.random.Generator, words: str) -> Robot:
    """A random chain with mimic joints of every sort: one word a joint, r p h, and for a mimic joint leader:multiplier.

    "r p r1:0.3 p1:-0.4 r" is: turn, slide, a turn that follows joint 1 at 0.3 rad/m, a slide that follows it, turn.
    """
    joints = []
    for i, word in enumerate(words.split()):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        pitch = 0.2 if word[0] == "h" else 0.0
        turning = np.r_[np.cross(0.5 * rng.normal(size=3), axis) + pitch * axis, axis]
        kind = {"p": JointKind.PRISMATIC, "h": JointKind.HELICAL}.get(word[0], JointKind.REVOLUTE)
        mimic = None
        if len(word) > 1:
            leader, multiplier = word[1:].split(":")
            mimic = Mimic(f"j{leader}", float(multiplier), 0.1)
        frame = np.eye(4)
        frame[:3, 3] = 0.3 * rng.normal(size=3)
        screw = np.r_[axis, 0, 0, 0] if word[0] == "p" else turning
        joints.append(Joint(f"j{i}", kind, screw, lower=-1.0, upper=1.0, frame=frame, mimic=mimic))
    home = np.eye(4)
    home[:3, 3] = 0.3 * rng.normal(size=3)
    return Robot(words, tuple(joints), home)
