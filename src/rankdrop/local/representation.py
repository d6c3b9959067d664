"""Analytical Jacobians, and the singularities that belong to the coordinates of the orientation, not to the arm.

Coordinates φ of the orientation turn at φ̇ with ω = E(φ) φ̇ (base axes), so that

    (ṗ; φ̇) = J_a q̇,    J_a = diag(I, E⁻¹) J.

Where E is singular, J_a does not exist or blows up although the arm moves freely: a *representation singularity*. It
goes away with other coordinates. The rank of J, the arm's own affair, does not know of it.

    zyz          R = Rz(α) Ry(β) Rz(γ)              det E = −sin β        singular at β = 0, π
    rpy          R = Rz(yaw) Ry(pitch) Rx(roll)     det E = cos(pitch)    singular at pitch = ±π/2
    rotvec       R = exp([φ])                       det E = 2(1 − cos‖φ‖)/‖φ‖²   at ‖φ‖ = 2π; the coordinates, kept to
                                                    ‖φ‖ ≤ π, never get there, but jump at ‖φ‖ = π
    quaternion   (w, x, y, z), w ≥ 0                ω = 2 Q(q)ᵀ q̇, E is 3 × 4 with all σ = 2: never singular
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import jacobian, pose
from rankdrop.local.bracket import hat
from rankdrop.local.verdict import Rank, one_configuration, rank_at
from rankdrop.robot.model import Array, Robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances

NAMES: dict[str, tuple[str, ...]] = {
    "zyz": ("α", "β", "γ"),
    "rpy": ("roll", "pitch", "yaw"),
    "quaternion": ("w", "x", "y", "z"),
    "rotvec": ("φx", "φy", "φz"),
}
"""The representations and the names of their coordinates, in order."""

NEAR = 0.1
"""Closer than this to a representation singularity is near [rad]: coordinate rates are up to ten times ‖ω‖ there."""


@dataclass(frozen=True, slots=True)
class Representation:
    """One set of coordinates at one pose.

    Attributes:
        name: "zyz", "rpy", "quaternion" or "rotvec".
        names: of the coordinates.
        coordinates: their values [rad; 1 for a quaternion]. At a singularity of zyz and rpy, where only a sum or a
            difference is determined, the last angle of zyz and the roll are zero.
        sigma_min: smallest singular value of E.
        determinant: of E; None for the quaternion, whose E is not square.
        angle: to the nearest orientation where E is singular [rad]; inf if there is none.
        jump: angle to where the coordinates jump, ‖φ‖ = π (the quaternion's w = 0) [rad]; inf for zyz and rpy.
        singular, near: E is singular here (to the tolerance); or closer than `NEAR`, and not singular.
        words: what it means.
    """

    name: str
    names: tuple[str, ...]
    coordinates: tuple[float, ...]
    sigma_min: float
    determinant: float | None
    angle: float
    jump: float
    singular: bool
    near: bool
    words: str


@dataclass(frozen=True, slots=True)
class Representations:
    """All representations at one configuration, beside the arm's own verdict.

    Attributes:
        arm: rank of the geometric Jacobian for the whole pose.
        zyz, rpy, quaternion, rotvec: one each.
        words: who is singular here: the arm, coordinates, both or neither.
    """

    arm: Rank
    zyz: Representation
    rpy: Representation
    quaternion: Representation
    rotvec: Representation
    words: str


def orientation_coordinates(rotation: ArrayLike, representation: str) -> Array:
    """Coordinates of rotation matrices.

    Args:
        rotation: (..., 3, 3).
        representation: "zyz", "rpy", "quaternion" or "rotvec".

    Returns:
        (..., 3) [rad], or (..., 4) the unit quaternion (w, x, y, z) with w ≥ 0.

    Raises:
        OptionError: no such representation.
    """
    r = np.asarray(rotation, dtype=np.float64)
    _known(representation)
    if representation == "quaternion":
        return _quaternion(r)
    if representation == "rotvec":
        quaternion = _quaternion(r)
        vector = quaternion[..., 1:]
        length = np.linalg.norm(vector, axis=-1, keepdims=True)
        angle = 2.0 * np.arctan2(length, quaternion[..., :1])
        return np.asarray(vector * np.where(length > 0.0, angle / np.where(length > 0.0, length, 1.0), 2.0))
    if representation == "zyz":
        beta = np.arctan2(np.hypot(r[..., 0, 2], r[..., 1, 2]), r[..., 2, 2])
        alpha = np.arctan2(r[..., 1, 2], r[..., 0, 2])
        gimbal = np.sin(beta) <= DEFAULT.singular
        alpha = np.where(gimbal, np.arctan2(-r[..., 0, 1], r[..., 1, 1]), alpha)
        # what Rz(α)Ry(β) leaves of R is Rz(γ): no loss of digits near the singularity
        last = np.arctan2(
            -np.sin(alpha) * r[..., 0, 0] + np.cos(alpha) * r[..., 1, 0],
            -np.sin(alpha) * r[..., 0, 1] + np.cos(alpha) * r[..., 1, 1],
        )
        return np.stack([alpha, beta, np.where(gimbal, 0.0, last)], axis=-1)
    pitch = np.arctan2(-r[..., 2, 0], np.hypot(r[..., 0, 0], r[..., 1, 0]))
    yaw = np.arctan2(r[..., 1, 0], r[..., 0, 0])
    gimbal = np.cos(pitch) <= DEFAULT.singular
    yaw = np.where(gimbal, np.arctan2(-r[..., 0, 1], r[..., 1, 1]), yaw)
    roll = np.arctan2(
        np.sin(yaw) * r[..., 0, 2] - np.cos(yaw) * r[..., 1, 2],
        -np.sin(yaw) * r[..., 0, 1] + np.cos(yaw) * r[..., 1, 1],
    )
    return np.stack([np.where(gimbal, 0.0, roll), pitch, yaw], axis=-1)


def rate_matrix(coordinates: ArrayLike, representation: str) -> Array:
    """E with ω = E φ̇: from rates of the coordinates to the angular velocity in base axes.

    Args:
        coordinates: (..., 3) or (..., 4), as from `orientation_coordinates`.
        representation: "zyz", "rpy", "quaternion" or "rotvec".

    Returns:
        (..., 3, 3), or (..., 3, 4) for the quaternion.

    Raises:
        OptionError: no such representation, or the wrong number of coordinates.
    """
    _known(representation)
    c = np.asarray(coordinates, dtype=np.float64)
    if c.ndim == 0 or c.shape[-1] != len(NAMES[representation]):
        raise OptionError("wrong number of coordinates", got=c.shape, allowed=", ".join(NAMES[representation]))
    if representation == "quaternion":
        w, vector = c[..., :1, None], c[..., 1:]
        return 2.0 * np.concatenate([-vector[..., :, None], w * np.eye(3) + hat(vector)], axis=-1)
    if representation == "rotvec":
        angle = np.linalg.norm(c, axis=-1)[..., None, None]
        half = np.sinc(angle / (2 * pi))  # sin(θ/2)/(θ/2)
        turned = hat(c)
        small = angle < 1e-2
        safe = np.where(small, 1.0, angle)
        cubic = np.where(small, 1 / 6 - angle**2 / 120 + angle**4 / 5040, (safe - np.sin(safe)) / safe**3)
        return np.asarray(np.eye(3) + 0.5 * half**2 * turned + cubic * (turned @ turned))
    zero, one = np.zeros(c.shape[:-1]), np.ones(c.shape[:-1])
    if representation == "zyz":
        sa, ca, sb, cb = np.sin(c[..., 0]), np.cos(c[..., 0]), np.sin(c[..., 1]), np.cos(c[..., 1])
        rows = [[zero, -sa, ca * sb], [zero, ca, sa * sb], [one, zero, cb]]
    else:
        sp, cp, sy, cy = np.sin(c[..., 1]), np.cos(c[..., 1]), np.sin(c[..., 2]), np.cos(c[..., 2])
        rows = [[cy * cp, -sy, zero], [sy * cp, cy, zero], [-sp, zero, one]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def analytical_jacobian(robot: Robot, q: ArrayLike, representation: str) -> Array:
    """J_a = diag(I, E⁻¹) J: rates of position and orientation coordinates per joint rate, tip in base axes.

    For the quaternion E⁻¹ stands for E⁺ = ½ Q, the rate that keeps its norm.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        representation: "zyz", "rpy", "quaternion" or "rotvec".

    Returns:
        (..., 6, n), or (..., 7, n) for the quaternion.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite, or lies on a representation singularity, where J_a
            does not exist.
        OptionError: no such representation.
    """
    _known(representation)
    geometric = jacobian(robot, q)
    coordinates = orientation_coordinates(pose(robot, q)[..., :3, :3], representation)
    turn = geometric[..., 3:, :]
    matrix = rate_matrix(coordinates, representation)
    if representation == "quaternion":
        rates = np.asarray(0.25 * matrix.swapaxes(-1, -2) @ turn)
    else:
        bad = np.abs(_determinant(coordinates, representation)) <= DEFAULT.singular
        if bad.any():
            index = tuple(int(i) for i in np.argwhere(bad)[0])
            raise ConfigurationError(
                f"the {representation} coordinates are singular at this pose; the arm need not be",
                got=f"{coordinates[index].tolist()}" + (f" at index {index}" if index else ""),
                mend="use the quaternion, or the geometric Jacobian",
            )
        rates = np.asarray(np.linalg.solve(matrix, turn), dtype=np.float64)
    return np.concatenate([geometric[..., :3, :], rates], axis=-2)


def representation_at(robot: Robot, q: ArrayLike, *, tolerances: Tolerances = DEFAULT) -> Representations:
    """How far the pose is from the singularities of each representation, beside the arm's own rank.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        tolerances: `singular` decides for E and for J.

    Raises:
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = representation_at(open_robot("pa10"), [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
        >>> found.zyz.singular, found.quaternion.angle, found.arm.corank
        (False, inf, 0)
    """
    configuration = one_configuration(robot, q)
    arm = rank_at(robot, configuration, resolve_task("pose", robot), tolerances)
    rotation = pose(robot, configuration)[:3, :3]
    found = {name: _describe(rotation, name, tolerances) for name in NAMES}
    singular = [part.name for part in found.values() if part.singular]
    if arm.corank:
        words = "the arm is singular for the whole pose" + (f", and so are the coordinates {', '.join(singular)}"
                                                            if singular else "; no coordinates are")  # fmt: skip
    elif singular:
        words = f"only the coordinates {', '.join(singular)} are singular; the arm moves freely: use the quaternion"
    else:
        words = "neither the arm nor any of the coordinates is singular"
    return Representations(arm, found["zyz"], found["rpy"], found["quaternion"], found["rotvec"], words)


def _describe(rotation: Array, name: str, tolerances: Tolerances) -> Representation:
    coordinates = orientation_coordinates(rotation, name)
    matrix = rate_matrix(coordinates, name)
    sigma = float(np.linalg.svd(matrix, compute_uv=False)[-1])
    turned = float(np.linalg.norm(orientation_coordinates(rotation, "rotvec")))
    jump = max(0.0, pi - turned) if name in ("rotvec", "quaternion") else inf
    angle = {
        "zyz": min(abs(coordinates[1]), pi - abs(coordinates[1])),
        "rpy": pi / 2 - abs(coordinates[1]),
        "rotvec": 2 * pi - turned,
        "quaternion": inf,
    }[name]
    singular = sigma <= tolerances.singular
    near = not singular and angle <= NEAR
    if name == "quaternion":
        words = "a quaternion has no singularity"
    elif singular:
        words = f"{name} coordinates are singular here: a matter of coordinates, not of the arm"
    elif near:
        words = f"{name} coordinates are near a singularity of theirs: their rates are large, not the arm's"
    else:
        words = f"{name} coordinates are regular here"
    determinant = None if name == "quaternion" else float(_determinant(coordinates, name))
    values = tuple(coordinates.tolist())
    return Representation(
        name, NAMES[name], values, sigma, determinant, float(angle), float(jump), singular, near, words
    )


def _determinant(coordinates: Array, name: str) -> Array:
    if name == "zyz":
        return np.asarray(-np.sin(coordinates[..., 1]))
    if name == "rpy":
        return np.asarray(np.cos(coordinates[..., 1]))
    return np.asarray(np.sinc(np.linalg.norm(coordinates, axis=-1) / (2 * pi)) ** 2)


def _quaternion(r: Array) -> Array:
    """(w, x, y, z), w ≥ 0: the column of 4 q qᵀ with the largest diagonal entry, so that no digits are lost."""
    trace = r[..., 0, 0] + r[..., 1, 1] + r[..., 2, 2]
    outer = np.empty((*r.shape[:-2], 4, 4))
    outer[..., 0, 0] = 1.0 + trace
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        outer[..., i + 1, i + 1] = 1.0 + 2.0 * r[..., i, i] - trace
        outer[..., 0, i + 1] = outer[..., i + 1, 0] = r[..., k, j] - r[..., j, k]
        outer[..., i + 1, j + 1] = outer[..., j + 1, i + 1] = r[..., i, j] + r[..., j, i]
    largest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    column = np.take_along_axis(outer, largest[..., None, None], axis=-1)[..., 0]
    unit = column / np.linalg.norm(column, axis=-1, keepdims=True)
    return np.asarray(unit * np.where(unit[..., :1] < 0.0, -1.0, 1.0))


def _known(representation: str) -> None:
    if representation not in NAMES:
        raise OptionError("there is no such representation", got=repr(representation), allowed=", ".join(NAMES))
