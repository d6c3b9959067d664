"""What a motion costs nearby: joint rates per unit of end-effector speed, and the speed that the joint limits leave.

    rates needed      q̇ = J⁺ d, the smallest that make the twist d
    with these rates  s = min_i limit_i / |q̇_i|
    at best           s = max {s : J q̇ = s d, |q̇_i| ≤ limit_i}, which a redundant arm reaches by other rates

Near a singularity the rates along the weakest direction grow as 1/σ_r; in a lost direction no rate helps, and the speed
is exactly zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError
from rankdrop.local.directions import lost_directions
from rankdrop.local.factored import Factored, factor, task_sigma
from rankdrop.local.rate_limits import rate_limits
from rankdrop.local.speed import largest_speeds
from rankdrop.local.verdict import one_configuration, rank_at
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import counted

_AXES = ("along X", "along Y", "along Z", "about X", "about Y", "about Z")


@dataclass(frozen=True, slots=True)
class DirectionRates:
    """What one unit of speed in one direction takes.

    Attributes:
        name: "along X", "about Z", "weakest direction", "lost direction 1".
        direction: (6,) the twist (v; ω) that unit speed means [m/s, rad/s], in the task's frame.
        unit: of the speeds: "m/s", "rad/s"; "1" where the direction mixes both: multiples of `direction` per second.
        possible: whether any joint rates make this twist.
        joint_rates: (n,) smallest rates for unit speed [rad/s, m/s]; empty if not possible.
        norm: their norm ‖W⁻¹q̇‖, slides in units of the length scale; inf if not possible.
        worst: number (from 1) of the joint nearest to its velocity limit, by |rate|/limit; where no joint has a limit,
            of the fastest joint; None if not possible.
        worst_joint: its name, or None.
        speed_smallest_rates: largest speed with multiples of `joint_rates` inside the limits; inf without limits.
        speed: largest speed over all joint rates inside the limits; 0 in lost directions, exactly; inf without limits.
        exact: False if `speed` is only the bound from `joint_rates`, because the arm has too many joints to list.
    """

    name: str
    direction: tuple[float, ...]
    unit: str
    possible: bool
    joint_rates: tuple[float, ...]
    norm: float
    worst: int | None
    worst_joint: str | None
    speed_smallest_rates: float
    speed: float
    exact: bool


@dataclass(frozen=True, slots=True)
class Rates:
    """Joint rates at one configuration.

    Attributes:
        axes: one for every row of the task.
        weakest: along u_r, r the rank: the direction that can still be made and costs most. Its twist is a unit vector
            of (v/ℓ; ω). None where nothing can be made at all.
        lost: one for every lost direction of `lost_directions`.
        limits: (n,) joint velocity limits in use [rad/s, m/s]; inf where there is none.
        length_scale: ℓ [m].
    """

    axes: tuple[DirectionRates, ...]
    weakest: DirectionRates | None
    lost: tuple[DirectionRates, ...]
    limits: tuple[float, ...]
    length_scale: float


def joint_rates(
    robot: Robot, q: ArrayLike, task: Task | str | None = None, *, tolerances: Tolerances = DEFAULT
) -> Rates:
    """Joint rates needed for unit speed along every axis, the weakest and the lost directions, against the limits.

    Args:
        robot: the arm; `Joint.velocity` are its limits, those of mimic joints included.
        q: (n,) configuration [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        tolerances: `singular` decides the rank; a direction whose part outside the range is larger than this (or than
            rounding, eps ‖J‖/σ_r) is not possible.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        TaskError: there is no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> along_x, along_y = joint_rates(open_robot("planar2r"), [0.0, 0.01]).axes
        >>> [round(rate, 2) for rate in along_x.joint_rates], along_x.worst_joint  # a2 c2/(a1 a2 s2), almost stretched
        ([100.0, -242.86], 'joint2')
        >>> joint_rates(open_robot("planar2r"), [0.0, 0.0]).axes[0].speed  # stretched
        0.0
    """
    resolved = resolve_task(task, robot)
    configuration = one_configuration(robot, q)
    verdict = rank_at(robot, configuration, resolved, tolerances)
    parts = factor(robot, configuration, resolved, tolerances)
    limits = rate_limits(robot)
    names = [_AXES[row] for row in resolved.rows]
    twists = [np.eye(6)[row] for row in resolved.rows]
    if verdict.rank:
        weakest = np.zeros(6)
        weakest[list(resolved.rows)] = parts.u[:, verdict.rank - 1] / parts.rows
        names.append("weakest direction")
        twists.append(weakest * np.copysign(1.0, weakest[np.argmax(np.abs(weakest))]))
    if verdict.corank:
        lost = lost_directions(robot, configuration, resolved, verdict.corank)
        names += [f"lost direction {i}" for i in range(1, len(lost) + 1)]
        twists += list(lost * np.repeat([counted(robot), 1.0], 3))
    found = _along(robot, parts, np.array(twists)[:, list(resolved.rows)], limits, verdict.rank, tolerances)
    every = [_named(robot, name, twist, part) for name, twist, part in zip(names, twists, found, strict=True)]
    m = resolved.m
    return Rates(
        tuple(every[:m]), every[m] if verdict.rank else None, tuple(every[m + bool(verdict.rank) :]),
        tuple(limits.tolist()), resolved.scale(robot),
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Found:
    rates: Array | None
    norm: float
    worst: int | None
    smallest: float
    speed: float
    exact: bool


def _along(
    robot: Robot, parts: Factored, twists: Array, limits: Array, rank: int, tolerances: Tolerances
) -> list[_Found]:
    """Rates and speeds for unit twists (k, m) in SI units."""
    scaled = twists * parts.rows
    outside = np.linalg.norm(scaled @ parts.u[:, rank:], axis=1) / np.linalg.norm(scaled, axis=1)
    weakest = float(parts.sigma[rank - 1]) if rank else 1.0
    rounding = 16 * np.finfo(float).eps * float(parts.sigma[0]) / weakest if rank else 0.0
    possible = outside <= max(tolerances.singular, rounding)
    rates = twists @ parts.inverse(parts.reciprocal).T
    null = parts.joints[:, None] * parts.v[:, rank:]
    speeds, exact = largest_speeds(rates, null, limits)
    found = []
    for rate, speed, can in zip(rates, speeds, possible, strict=True):
        if not can:
            found.append(_Found(None, inf, None, 0.0, 0.0, True))
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(rate == 0.0, 0.0, np.abs(rate) / limits)
        size = np.abs(rate / parts.joints)
        worst = int(np.argmax(share if share.any() else size))
        smallest = 1.0 / share.max() if share.any() else inf
        found.append(_Found(rate, float(np.linalg.norm(size)), worst, float(smallest), float(speed), exact))
    return found


def _named(robot: Robot, name: str, twist: Array, found: _Found) -> DirectionRates:
    moves, turns = bool(twist[:3].any()), bool(twist[3:].any())
    unit = "1" if moves and turns else "m/s" if moves else "rad/s"
    if unit == "m/s" and name == "weakest direction":
        unit = "1"  # the twist of ℓ m/s is the unit
    possible = found.rates is not None
    return DirectionRates(
        name=name,
        direction=tuple(twist.tolist()),
        unit=unit,
        possible=possible,
        joint_rates=tuple(found.rates.tolist()) if found.rates is not None else (),
        norm=found.norm,
        worst=None if found.worst is None else found.worst + 1,
        worst_joint=None if found.worst is None else robot.variables[found.worst].name,
        speed_smallest_rates=found.smallest,
        speed=found.speed,
        exact=found.exact,
    )


@dataclass(frozen=True, slots=True)
class RateGrowth:
    """How the rates along the weakest direction grow on the way into a singularity.

    Attributes:
        distances: (k,) distances from it in scaled joint coordinates, descending [rad].
        rates: (k,) norm 1/σ_r of the smallest rates for unit speed (of (v/ℓ; ω)) along the weakest direction [1].
        power: p in rates ≈ c / distance^p, fitted to the nearer half; 1 at most singularities, 2 where the first
            derivative of σ_r vanishes along the way; 0 if the way does not lead into a singularity.
    """

    distances: Array
    rates: Array
    power: float


def rate_growth(
    robot: Robot,
    singular: ArrayLike,
    away: ArrayLike,
    task: Task | str | None = None,
    *,
    distances: ArrayLike = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4),
) -> RateGrowth:
    """The power law of the rates at steps towards a singular configuration.

    Args:
        robot: the arm.
        singular: (n,) the configuration approached [rad, m].
        away: (n,) joint motion along which it is approached [rad, m]; only its direction counts.
        task: name, `Task`, or None for the task the arm is made for.
        distances: how far away, in scaled joint coordinates [rad].

    Raises:
        ConfigurationError: not one configuration of this arm.
        OptionError: `away` is zero or of the wrong shape, or fewer than two positive distances.
        TaskError: there is no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> round(rate_growth(open_robot("planar2r"), [0.3, 0.0], [0, 1]).power, 3)
        1.0
    """
    resolved = resolve_task(task, robot)
    start = one_configuration(robot, singular)
    scale = factor(robot, start, resolved).joints
    way, steps = np.asarray(away, dtype=np.float64), np.sort(np.asarray(distances, dtype=np.float64))[::-1]
    if way.shape != (robot.n,) or not np.isfinite(way).all() or not way.any():
        raise OptionError("the way needs one finite number per joint, not all zero", got=way.tolist())
    if steps.ndim != 1 or len(steps) < 2 or not (np.isfinite(steps).all() and steps[-1] > 0.0):
        raise OptionError("two positive distances are needed at least", got=steps.tolist())
    unit = way / np.linalg.norm(way / scale)
    sigma = task_sigma(robot, start + steps[:, None] * unit, resolved)
    generic = rank_at(robot, start, resolved).generic_rank
    with np.errstate(divide="ignore"):
        rates = 1.0 / sigma[:, generic - 1]
    near = slice(len(steps) // 2, None) if len(steps) > 3 else slice(None)
    power = -float(np.polyfit(np.log(steps[near]), np.log(rates[near]), 1)[0])
    for array in (steps, rates):
        array.flags.writeable = False
    return RateGrowth(steps, rates, power)
