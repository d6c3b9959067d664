"""Analytical Jacobians, and the singularities that belong to the coordinates of the orientation, not to the arm.

Coordinates φ of the orientation turn at φ̇ with ω = E(φ) φ̇ (base axes), so that

    (ṗ; φ̇) = J_a q̇,    J_a = diag(I, E⁻¹) J.

Where E is singular, J_a does not exist or blows up although the arm moves freely: a *representation singularity*. It
goes away with other coordinates. The rank of J, the arm's own affair, does not know of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import jacobian, one_configuration, pose
from rankdrop.local.orientation import (
    EULER,
    JUMPING,
    MAIN,
    NAMES,
    check_known,
    euler_angles,
    euler_rates,
    orientation_coordinates,
    rate_determinant,
    rate_matrix,
)
from rankdrop.local.verdict import Rank, rank_at
from rankdrop.robot.model import Array, Robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances

NEAR = 0.1
"""Closer than this to a representation singularity is near [rad]: coordinate rates are up to ten times ‖ω‖ there."""


@dataclass(frozen=True, slots=True)
class Representation:
    """One set of coordinates at one pose.

    Attributes:
        name: one of `orientation.NAMES`.
        names: of the coordinates.
        coordinates: their values [rad; 1 for a quaternion and Rodrigues parameters]. At a singularity of Euler angles,
            where only a sum or a difference is determined, the last angle is zero, and the roll.
        sigma_min: smallest singular value of E.
        determinant: of E; None for the quaternion, whose E is not square.
        angle: to the nearest orientation where E is singular [rad]; inf if there is none.
        jump: angle to where the coordinates jump, half a turn (the quaternion's w = 0) [rad]; inf for Euler angles and
            Rodrigues parameters.
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
        others: the other orders of Euler angles, Rodrigues and modified Rodrigues parameters.
        words: who is singular here: the arm, coordinates, both or neither.
    """

    arm: Rank
    zyz: Representation
    rpy: Representation
    quaternion: Representation
    rotvec: Representation
    words: str
    others: tuple[Representation, ...] = ()

    @property
    def every(self) -> tuple[Representation, ...]:
        """All of them, those most used first."""
        return (self.zyz, self.rpy, self.quaternion, self.rotvec, *self.others)

    def of(self, name: str) -> Representation:
        """One of them by its name.

        Raises:
            OptionError: no such representation.
        """
        check_known(name)
        return next(one for one in self.every if one.name == name)


def analytical_jacobian(robot: Robot, q: ArrayLike, representation: str) -> Array:
    """J_a = diag(I, E⁻¹) J: rates of position and orientation coordinates per joint rate, tip in base axes.

    For the quaternion E⁻¹ stands for E⁺ = ½ Q, the rate that keeps its norm.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        representation: one of `orientation.NAMES`.

    Returns:
        (..., 6, n), or (..., 7, n) for the quaternion.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite, or lies on a representation singularity, where J_a
            does not exist.
        OptionError: no such representation.
    """
    check_known(representation)
    geometric = jacobian(robot, q)
    coordinates = orientation_coordinates(pose(robot, q)[..., :3, :3], representation)
    turn = geometric[..., 3:, :]
    if representation == "quaternion":
        matrix = rate_matrix(coordinates, representation)
        rates = np.asarray(0.25 * matrix.swapaxes(-1, -2) @ turn)
    else:
        finite = np.isfinite(coordinates).all(axis=-1)
        bad = ~finite | (np.abs(rate_determinant(coordinates, representation)) <= DEFAULT.singular)
        if bad.any():
            index = tuple(int(i) for i in np.argwhere(bad)[0])
            raise ConfigurationError(
                f"the {representation} coordinates are singular at this pose; the arm need not be",
                got=f"{coordinates[index].tolist()}" + (f" at index {index}" if index else ""),
                mend="use the quaternion, or the geometric Jacobian",
            )
        rates = np.asarray(np.linalg.solve(rate_matrix(coordinates, representation), turn), dtype=np.float64)
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
    angles = dict(zip(EULER, euler_angles(rotation, EULER), strict=True))
    coordinates = {name: angles[name] if name in angles else orientation_coordinates(rotation, name) for name in NAMES}
    sigma = _smallest(coordinates)
    turned = float(np.linalg.norm(coordinates["rotvec"]))
    found = {name: _describe(name, coordinates[name], sigma[name], turned, tolerances) for name in NAMES}
    singular = [part.name for part in found.values() if part.singular]
    if arm.corank:
        words = "the arm is singular for the whole pose" + (f", and so are the coordinates {', '.join(singular)}"
                                                            if singular else "; no coordinates are")  # fmt: skip
    elif singular:
        words = f"only the coordinates {', '.join(singular)} are singular; the arm moves freely: use the quaternion"
    else:
        words = "neither the arm nor any of the coordinates is singular"
    others = tuple(part for name, part in found.items() if name not in MAIN)
    return Representations(arm, found["zyz"], found["rpy"], found["quaternion"], found["rotvec"], words, others)


def _smallest(coordinates: dict[str, Array]) -> dict[str, float]:
    """Smallest singular values of E, by name; 0 where coordinates are not finite."""
    finite = [name for name, values in coordinates.items() if np.isfinite(values).all()]
    square = [name for name in finite if len(coordinates[name]) == 3]
    found = dict.fromkeys(coordinates, 0.0)
    rates = dict(zip(EULER, euler_rates(np.stack([coordinates[name] for name in EULER]), EULER), strict=True))
    every = [rates[name] if name in rates else rate_matrix(coordinates[name], name) for name in square]
    sigma = _core.svd(np.stack(every), vectors=False)
    found |= dict(zip(square, sigma[:, -1].tolist(), strict=True))
    for name in finite:
        if name not in square:
            found[name] = float(np.linalg.svd(rate_matrix(coordinates[name], name), compute_uv=False)[-1])
    return found


def _describe(
    name: str, coordinates: Array, sigma: float, turned: float, tolerances: Tolerances
) -> Representation:
    """One set of coordinates, with the smallest singular value of E and the angle of the whole turn."""
    finite = bool(np.isfinite(coordinates).all())
    jump = max(0.0, pi - turned) if name in JUMPING else inf
    if name in ("zyz", "rpy", *EULER):
        back = name == "zyz" or name[0] == name[2]  # the first axis comes back
        angle = min(abs(coordinates[1]), pi - abs(coordinates[1])) if back else pi / 2 - abs(coordinates[1])
    else:
        angle = max({"rotvec": 2 * pi, "mrp": 2 * pi, "rodrigues": pi, "quaternion": inf}[name] - turned, 0.0)
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
    determinant = None if name == "quaternion" else float(rate_determinant(coordinates, name)) if finite else 0.0
    values = tuple(coordinates.tolist())
    return Representation(
        name, NAMES[name], values, sigma, determinant, float(angle), float(jump), singular, near, words
    )
