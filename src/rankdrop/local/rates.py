"""What motion costs the joints: joint rates and largest speeds.

Joint rates and speeds for a twist d, with J⁺ of `rankdrop.local.inverses`:

    rates needed      q̇ = J⁺ d, the smallest that make the twist d
    with these rates  s = min_i limit_i / |q̇_i|
    at best           s = max {s : J q̇ = s d, |q̇_i| ≤ limit_i}, which a redundant arm reaches by other rates

Near a singularity the rates along the weakest direction grow as 1/σ_r; in a lost direction no rate helps, and the speed
is exactly zero. The largest speed is a small linear programme, solved exactly. All solutions of A ẋ = s d are
ẋ = s (b + N z), b = A⁺d, N a basis of the null space, so that 1/s = min_z max_i |b_i + N_i z| / l_i: the best
approximation of b in the maximum norm. Its dual is a maximum over the vertices of
{y : Σ_i y_i N_i / l_i = 0, Σ|y_i| ≤ 1}, the circuits of the weighted rows of N: minimal dependent sets of at most k + 1
rows for k null motions. For a handful of joints all are listed, and serve every d.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from math import comb, inf, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.configuration import Configuration, configuration_at
from rankdrop.errors import OptionError
from rankdrop.kinematics import one_configuration
from rankdrop.local.block import generic_rank, joint_scale, read_only
from rankdrop.local.directions import lost_directions
from rankdrop.local.inverses import Factored, factor, task_sigma
from rankdrop.robot.model import Array, Robot, once
from rankdrop.task import Task, resolve_task, six_rows
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import counted_as_radian

TINY = 1e-100
"""Its square is still a number."""

MOST = 200_000  # vertices that are listed at most; 8 joints need 70
_FLAT = 1e-12  # singular values of weighted null motions below this share are zero: rounding of unit vectors

_NOTHING = 1e-12  # a share below it is rounding
WEAKEST = "weakest direction"
_AXES = ("along X", "along Y", "along Z", "about X", "about Y", "about Z")

_CROSSWISE = np.array([1.0, -1.0])
"""(a, b) is normal to (b, a) times these."""


@once
def rate_limits(robot: Robot) -> Array:
    """(n,) largest rate of every variable [rad/s or m/s]; inf where the source gives none.

    A mimic joint turns at |multiplier| times the rate of its leader; its own limit holds the leader back as well.
    """
    limits = {joint.name: max(0.0, joint.velocity) for joint in robot.variables}
    for joint in robot.joints:
        if joint.mimic is not None and joint.mimic.multiplier != 0.0:
            shared = max(0.0, joint.velocity) / abs(joint.mimic.multiplier)
            limits[joint.mimic.leader] = min(limits[joint.mimic.leader], shared)
    return read_only(np.array([limits[joint.name] for joint in robot.variables]))


def largest_speeds(particular: Array, null: Array, limits: Array) -> tuple[Array, bool]:
    """Largest s with ẋ = s (b + N z) inside |ẋ_i| ≤ l_i, for many b at once.

    Args:
        particular: (k, n) joint rates b for unit speed along each direction, any solution of A b = d.
        null: (n, p) basis of the null space of A; p = 0 allowed.
        limits: (n,) l_i ≥ 0, inf allowed. A joint with l_i = 0 stands still.

    Returns:
        (k,) speeds: 0 where only motion of a joint with limit 0 would do it, inf where no limit holds it back. Then
        whether they are the exact maxima; if there were too many vertices, they are those of the best of b alone.

    Example:
        >>> speeds, exact = largest_speeds(np.array([[0.5, 0.5]]), np.array([[1.0], [-1.0]]), np.array([1.0, 3.0]))
        >>> speeds.round(9).tolist(), exact  # two joints in line: their limits add
        ([4.0], True)
    """
    stuck = limits == 0.0
    reachable = np.ones(len(particular), dtype=bool)
    if stuck.any():
        particular, null, reachable = _standing(particular, null, stuck)
    bounded = np.isfinite(limits) & ~stuck
    wanted = particular[:, bounded] / limits[bounded]
    rows = null[bounded] / limits[bounded, None]
    vertices, exact = _vertices(rows)
    needed = np.abs(wanted @ vertices.T).max(axis=1, initial=0.0)
    noise = 1e-14 * np.abs(wanted).max(axis=1, initial=0.0)  # what remains of a rate that others take over completely
    speeds = np.where(needed > noise, 1.0 / np.where(needed > noise, needed, 1.0), np.inf)
    return np.where(reachable, speeds, 0.0), exact


def _vertices(rows: Array) -> tuple[Array, bool]:
    """(c, n) vertices y of the dual, Σ|y| = 1, up to sign; and whether they are all."""
    count = len(rows)
    if rows.shape[1] == 0 or count == 0:
        return np.eye(count), True
    u, sigma, _ = np.linalg.svd(rows, full_matrices=False)
    rank = int((sigma > _FLAT * max(sigma[0], np.finfo(float).tiny)).sum())
    if rank == 0:
        return np.eye(count), True
    if rank == count:
        return np.zeros((1, count)), True  # every rate can be taken over by null motion
    circuits = null_circuits(u[None, :, :rank].swapaxes(1, 2), np.arange(count), MOST)
    if circuits is None:
        return np.eye(count), False
    return circuits[0] / np.maximum(np.abs(circuits[0]).sum(axis=1, keepdims=True), TINY), True


def _standing(particular: Array, null: Array, stuck: Array) -> tuple[Array, Array, Array]:
    """Solutions in which the stuck joints stand still: new b and N, and where there are any."""
    u, sigma, vt = np.linalg.svd(null[stuck])
    rank = int((sigma > _FLAT).sum())
    z = -(particular[:, stuck] @ u[:, :rank] / sigma[:rank]) @ vt[:rank]
    moved = particular + z @ null.T
    size = np.abs(particular).max(axis=1, initial=0.0)
    reachable = np.abs(moved[:, stuck]).max(axis=1, initial=0.0) <= 1e-9 * np.maximum(size, np.finfo(float).tiny)
    return moved, null @ vt[rank:].T, reachable


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
        lost_shares: of each axis e the part |P e|², P onto what cannot be made, 1 m counted as 1 rad; 0 where it is
            possible, 1 where nothing of it is left.
        remaining: of each axis the motion that can be made and is nearest to it, (e − P e)/(1 − |P e|²): its part along
            the axis is one unit of speed, so `speed` is the best that remains along it. None where nothing is left.
    """

    axes: tuple[DirectionRates, ...]
    weakest: DirectionRates | None
    lost: tuple[DirectionRates, ...]
    limits: tuple[float, ...]
    length_scale: float
    lost_shares: tuple[float, ...] = ()
    remaining: tuple[DirectionRates | None, ...] = ()


def joint_rates(
    robot: Robot | Configuration, q: ArrayLike | None = None, task: Task | str | None = None, *,
    tolerances: Tolerances = DEFAULT,
) -> Rates:  # fmt: skip
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
    here = configuration_at(robot, q, task, tolerances)
    robot, resolved, verdict = here.robot, here.task, here.measured
    parts = factor(robot, here.q, resolved, here.tolerances)
    limits = rate_limits(robot)
    rows, rank = list(resolved.rows), verdict.rank
    motions = [(_AXES[row], np.eye(6)[row]) for row in rows]
    lengths = np.repeat([counted_as_radian(robot), 1.0], 3)
    unit = lengths[rows]
    gone = np.linalg.qr((parts.u[:, rank:].T * parts.rows * unit).T)[0].T  # spans what cannot be made, orthonormal
    shares = np.einsum("ij,ij->j", gone, gone)
    shares[shares < _NOTHING] = 0.0
    left = [row for row, share in enumerate(shares) if share < 1.0 - _NOTHING]
    if rank:
        weakest = six_rows(parts.u[:, rank - 1] / parts.rows, resolved)
        motions.append((WEAKEST, weakest * np.copysign(1.0, weakest[np.argmax(np.abs(weakest))])))
    if verdict.corank:
        lost = lost_directions(robot, here.q, resolved, verdict.corank)
        motions += [(f"lost direction {i}", row * lengths) for i, row in enumerate(lost, start=1)]
    given = len(motions)
    for row in left:
        nearest = (np.eye(resolved.m)[row] - gone.T @ gone[:, row]) / (1.0 - shares[row]) * unit / unit[row]
        motions.append((motions[row][0], six_rows(nearest, resolved)))
    every = _rates_along(robot, parts, motions, resolved, limits, rank, here.tolerances)
    m = resolved.m
    remaining = dict(zip(left, every[given:], strict=True))
    return Rates(
        tuple(every[:m]), every[m] if rank else None, tuple(every[m + bool(rank) : given]),
        tuple(limits.tolist()), resolved.scale(robot), tuple(shares.tolist()),
        tuple(remaining.get(row) for row in range(m)),
    )  # fmt: skip


def _rates_along(
    robot: Robot, parts: Factored, motions: list[tuple[str, Array]], task: Task, limits: Array, rank: int,
    tolerances: Tolerances,
) -> list[DirectionRates]:  # fmt: skip
    """Rates and speeds for unit twists (6,) in SI units, each with its name."""
    twists = np.array([twist for _, twist in motions])[:, list(task.rows)]
    scaled = twists * parts.rows
    outside = np.linalg.norm(scaled @ parts.u[:, rank:], axis=1) / np.linalg.norm(scaled, axis=1)
    weakest = float(parts.sigma[rank - 1]) if rank else 1.0
    rounding = 16 * np.finfo(float).eps * float(parts.sigma[0]) / weakest if rank else 0.0
    possible = outside <= max(tolerances.singular, rounding)
    rates = twists @ parts.inverse().T
    speeds, exact = largest_speeds(rates, parts.joints[:, None] * parts.v[:, rank:], limits)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(rates == 0.0, 0.0, np.abs(rates) / limits)
    sizes, largest = np.abs(rates / parts.joints), shares.max(axis=1)
    worst = np.where(largest > 0.0, shares.argmax(axis=1), sizes.argmax(axis=1)).tolist()
    in_directions = []
    for row, (name, twist) in enumerate(motions):
        unit = "rad/s"
        if twist[:3].any():  # of the weakest ℓ m/s is the unit
            if twist[3:].any() or name == WEAKEST:
                unit = "1"
            else:
                unit = "m/s"
        costs: tuple[Any, ...] = (False, (), inf, None, None, 0.0, 0.0, True)
        if possible[row]:
            most, number, norm = float(largest[row]), worst[row], sqrt(float(sizes[row] @ sizes[row]))
            costs = (True, tuple(rates[row].tolist()), norm, number + 1, robot.variables[number].name,
                     1.0 / most if most else inf, float(speeds[row]), exact)  # fmt: skip
        in_directions.append(DirectionRates(name, tuple(twist.tolist()), unit, *costs))
    return in_directions


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
    scale = joint_scale(robot, resolved)
    way, steps = joint_direction(robot, away), np.sort(np.asarray(distances, dtype=np.float64))[::-1]
    if steps.ndim != 1 or len(steps) < 2 or not (np.isfinite(steps).all() and steps[-1] > 0.0):
        raise OptionError("two positive distances are needed at least", got=steps.tolist())
    unit = way / np.linalg.norm(way / scale)
    sigma = task_sigma(robot, start + steps[:, None] * unit, resolved)
    generic = generic_rank(robot, resolved)
    with np.errstate(divide="ignore"):
        rates = 1.0 / sigma[:, generic - 1]
    if len(steps) > 3:
        near = slice(len(steps) // 2, None)
    else:
        near = slice(None)
    power = -float(np.polyfit(np.log(steps[near]), np.log(rates[near]), 1)[0])
    return RateGrowth(read_only(steps), read_only(rates), power)


@lru_cache(maxsize=4)
def _choices(joints: tuple[int, ...], size: int) -> NDArray[np.intp]:
    """(C, size) all sets of `size` joints."""
    chosen = np.array(list(combinations(joints, size)))
    chosen.flags.writeable = False
    return chosen


def null_circuits(null: Array, bounded: NDArray[np.intp], most: int) -> Array | None:
    """(N, C, n) circuits of null spaces (N, p, n) among bounded joints; None where they are more than `most`."""
    count, spare, n = null.shape
    if comb(len(bounded), spare + 1) > most:
        return None
    chosen = _choices(tuple(bounded.tolist()), spare + 1)  # (C, p + 1)
    circuits = np.zeros((count, len(chosen), n))
    parts = null[:, :, chosen].swapaxes(1, 2)  # (N, C, p, p + 1)
    if spare == 0:
        entries = np.ones((count, len(chosen), 1))
    elif spare == 1:
        entries = parts[..., 0, ::-1] * _CROSSWISE
    else:
        entries = np.linalg.svd(parts)[2][..., -1, :]
    circuits[:, np.arange(len(chosen))[:, None], chosen] = entries
    return circuits


def joint_direction(robot: Robot, direction: ArrayLike) -> Array:
    """(n,) the direction of a joint motion.

    Raises:
        OptionError: not one finite number per joint, or all zero.
    """
    way = np.asarray(direction, dtype=np.float64)
    if way.shape != (robot.n,) or not np.isfinite(way).all() or not way.any():
        raise OptionError("a direction of the joints is one finite number per joint, not all zero", got=way.tolist())
    return way
