"""Ellipsoids of velocity and force, manipulability and conditioning, translations and rotations apart."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, prod

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.configuration import Configuration, configuration_at
from rankdrop.local.block import read_only, svd
from rankdrop.local.rates import rate_limits
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.sections import words_of
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

_PER_RATE = {"translation": "m/rad", "rotation": "1", "task": "1"}  # unit of σ: speed per joint rate
_PER_BALL = {"translation": "m/s", "rotation": "rad/s", "task": "rad/s"}  # speed, since the ball has no unit


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """One ellipsoid about the reference point of the task's frame, in its axes.

    Attributes:
        axes: (k, d) unit vectors u_i as rows, d = 3 (translation or rotation) or 6 (task: (v/ℓ; ω), wrench (ℓf; τ)).
        half_lengths: (k,) for a velocity ellipsoid descending and 0 in lost directions, for a force ellipsoid
            ascending and inf in blocked ones.
        semi_axes: (k, d) the semi-axes as twists [m/s, rad/s] or wrenches [N, N m]: half-length times axis, the length
            scale taken out again. Where the half-length is infinite, so are the entries that are not zero.
        unit: of the half-lengths: "m/s" or "rad/s", "N" or "N m"; for the whole task ℓ m/s count as 1 rad/s.
    """

    axes: Array
    half_lengths: Array
    semi_axes: Array
    unit: str


@dataclass(frozen=True, slots=True)
class Index:
    """One number by which arms are compared.

    Attributes:
        name: "σ_min", "condition number" or "manipulability".
        value: of it; a singular value below the tolerance counts as zero.
        unit: of it; "1" for a pure number.
        length_scale: the length that divides translations [m]; None where nothing is mixed.
    """

    name: str
    value: float
    unit: str
    length_scale: float | None


@dataclass(frozen=True, slots=True)
class JacobianPart:
    """Ellipsoids and indices of one part of the Jacobian.

    Attributes:
        name: "translation", "rotation" or "task".
        velocity, force: the two ellipsoids.
        sigma_min: the smallest of the min(m, n) singular values.
        condition: σ_max/σ_min, inf where σ_min is zero.
        manipulability: √det(AAᵀ) = Π σ_i, taken from the singular values, never from a determinant (√det(AᵀA) where
            the arm has fewer joints than the part has rows).
    """

    name: str
    velocity: Ellipsoid
    force: Ellipsoid
    sigma_min: Index
    condition: Index
    manipulability: Index


@dataclass(frozen=True, slots=True)
class PartSet:
    """The three parts for one unit ball of joint rates.

    Attributes:
        by_limits: joint rates count as shares of their limits; else 1 rad/s of every joint counts as one.
        slide_length: so much of a slide counts as 1 rad [m]; None where no joint slides, or by limits.
        joints: (n,) the rate of each joint that counts as one [rad/s, m/s].
        translation, rotation: None where the task has no such rows.
        task: all rows of the task, translations divided by the length scale.
    """

    by_limits: bool
    slide_length: float | None
    joints: tuple[float, ...]
    translation: JacobianPart | None
    rotation: JacobianPart | None
    task: JacobianPart

    @property
    def ball(self) -> str:
        """The unit balls of joint rates and of joint torques, in words."""
        balls: str = words_of(self).unit_balls(self)
        return balls


@dataclass(frozen=True, slots=True)
class Ellipsoids:
    """Ellipsoids at one configuration.

    Attributes:
        unit_rates: every joint counts alike: 1 rad/s, and the length scale per second for a slide.
        rate_limits: joint rates as shares of their velocity limits; None unless all limits are given.
        length_scale: in use [m].
    """

    unit_rates: PartSet
    rate_limits: PartSet | None
    length_scale: float


def ellipsoids(
    robot: Robot | Configuration, q: ArrayLike | None = None, task: Task | str | None = None, *,
    tolerances: Tolerances = DEFAULT,
) -> Ellipsoids:  # fmt: skip
    """Velocity and force ellipsoids with σ_min, condition number and manipulability.

    With A the part of the Jacobian that counts, its joint columns weighted, A = U Σ Vᵀ:

        velocity   {A ẋ : ‖ẋ‖ ≤ 1}        half-lengths σ_i along u_i
        force      {f : ‖Aᵀf‖ ≤ 1}         half-lengths 1/σ_i along the same u_i, infinite where nothing can move

    Translation takes the task's rows among vx, vy, vz as they are [m/s per rad/s], rotation those among wx, wy, wz. A
    part has as many axes as the task has rows in it, so a planar arm is not called singular for never leaving its
    plane. The force ellipsoid belongs to the ball of joint torques that is dual to the ball of rates: where a joint
    counts with rate w, its torque τ counts as w τ.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        tolerances: σ ≤ `singular`, translations divided by the length scale and turning joints in rad/s, is zero.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        TaskError: there is no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = ellipsoids(open_robot("planar2r"), [0.4, 0.0]).unit_rates.translation
        >>> found.velocity.half_lengths.round(4).tolist(), found.force.half_lengths.round(4).tolist()
        ([1.8385, 0.0], [0.5439, inf])
        >>> found.manipulability.value, found.condition.value, found.sigma_min.unit
        (0.0, inf, 'm/rad')
    """
    here = configuration_at(robot, q, task, tolerances)
    weights, limits, zero = here.scale, rate_limits(here.robot), here.tolerances.singular
    length = here.task.scale(here.robot)
    slides = any(joint.kind is JointKind.PRISMATIC for joint in here.robot.variables)
    plain = _shapes(here.jacobian * weights, here.task, length, weights, _PER_RATE, zero)
    if slides:
        plain = replace(plain, slide_length=length)
    bounded = None
    if np.isfinite(limits).all():
        zero *= float((limits / weights).max())
        bounded = _shapes(here.jacobian * limits, here.task, length, limits, _PER_BALL, zero)
        bounded = replace(bounded, by_limits=True)
    return Ellipsoids(plain, bounded, length)


def _shapes(
    scaled: Array, task: Task, length: float, weights: Array, units: dict[str, str], zero: float
) -> PartSet:
    """The three parts of the task Jacobian (translations divided by `length`) with weighted columns."""
    rows, parts = np.array(task.rows), {}
    for name, chosen, size in (("translation", rows < 3, length), ("rotation", rows >= 3, 1.0)):
        if chosen.any():
            parts[name] = _part(name, size * scaled[chosen], rows[chosen] % 3, np.ones(3), units[name], size * zero)
    whole = _part("task", scaled, rows, np.repeat([length, 1.0], 3), units["task"], zero, length)
    return PartSet(False, None, tuple(weights.tolist()), parts.get("translation"), parts.get("rotation"), whole)


def _part(
    name: str, block: Array, places: Array, to_si: Array, unit: str, zero: float, length: float | None = None
) -> JacobianPart:
    """Ellipsoids of the rows `block` (k, n), which stand at `places` among the entries of an axis."""
    u, measured, _ = svd(block)
    values = np.where(measured > zero, measured, 0.0)
    speeds, axes = np.zeros(len(places)), np.zeros((len(places), len(to_si)))
    speeds[: len(values)] = values
    axes[:, places] = u.T
    forces = np.array([1.0 / value if value > 0.0 else inf for value in speeds])
    velocity, force = (
        Ellipsoid(read_only(axes), read_only(lengths), read_only(_scaled_axes(axes, lengths) * to_given), of)
        for lengths, to_given, of in (
            (speeds, to_si, _PER_BALL[name]), (forces, 1.0 / to_si, "N" if name == "translation" else "N m"),
        )
    )  # fmt: skip
    count, smallest = len(values), float(values[-1])
    return JacobianPart(
        name, velocity, force,
        Index("σ_min", smallest, unit, length),
        Index("condition number", float(values[0]) / smallest if smallest > 0.0 else inf, "1", length),
        Index("manipulability", prod(values.tolist()), unit if unit == "1" or count == 1 else f"({unit})^{count}",
              length),
    )  # fmt: skip


def _scaled_axes(axes: Array, lengths: Array) -> Array:
    """Axis times half-length; an infinite one leaves entries that are zero (1e-12) at zero."""
    finite = np.where(np.isfinite(lengths), lengths, 0.0)[:, None] * axes
    endless = np.where(np.abs(axes) > 1e-12, np.copysign(inf, axes), 0.0)
    return np.where(np.isfinite(lengths)[:, None], finite, endless)
