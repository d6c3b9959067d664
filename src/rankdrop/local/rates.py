"""What motion costs the joints: inverses of the task Jacobian, joint rates, largest speeds, slowest straight motion.

One decomposition S J W = U Σ Vᵀ serves every inverse, with the rank decided on σ. S divides translation rows by the
length scale ℓ, W multiplies prismatic joints by it (`joint_scale`), so that neither Ĵ = S J W nor its singular values
have a unit. Twists are measured as ‖(v/ℓ; ω)‖, joint rates as ‖W⁻¹q̇‖. The inverses q̇ = W (Σ g_i v_i u_iᵀ) S ξ differ in
the gains g_i alone:

    pseudo-inverse        g_i = 1/σ_i, and 0 beyond the rank
    damped least squares  g_i = σ_i/(σ_i² + λ²)
    selective             g_i = σ_i/(σ_i² + λ_i²), λ_i = 0 for σ_i ≥ threshold

What depends on ℓ: which σ are small and how strongly a damping acts; at a singular configuration, which attainable
twist is nearest to one that is not; and with prismatic joints, which of many rates is smallest. At full row rank
without prismatic joints the pseudo-inverse is Jᵀ(JJᵀ)⁻¹ whatever ℓ is.

Joint rates and speeds for a twist d:

    rates needed      q̇ = J⁺ d, the smallest that make the twist d
    with these rates  s = min_i limit_i / |q̇_i|
    at best           s = max {s : J q̇ = s d, |q̇_i| ≤ limit_i}, which a redundant arm reaches by other rates

Near a singularity the rates along the weakest direction grow as 1/σ_r; in a lost direction no rate helps, and the speed
is exactly zero. The largest speed is a small linear programme, solved exactly. All solutions of A ẋ = s d are
ẋ = s (b + N z), b = A⁺d, N a basis of the null space, so that 1/s = min_z max_i |b_i + N_i z| / l_i: the best
approximation of b in the maximum norm. Its dual is a maximum over the vertices of
{y : Σ_i y_i N_i / l_i = 0, Σ|y_i| ≤ 1}, the circuits of the weighted rows of N: minimal dependent sets of at most k + 1
rows for k null motions. For a handful of joints all are listed, and serve every d.

The slowest straight motion, translations and rotations apart, is min s(d) over unit d. Attainable twists form a
zonotope, so that min s(d) is its distance from the origin to the nearest facet, measured in the subspace of straight
motions: with A = J diag(l) and y normal to a facet, scaled so that Σ|Aᵀy| = 1,

    slowest translation = min over facets of 1/|y_v|,   in the direction y_v.

The vectors c = Aᵀy of facets are the circuits of the null space: c ⟂ N, at most p + 1 entries for p null motions. A
joint that enters c is at its limit there. For as many joints as rows c has one entry, and y is a row of A⁻¹.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from math import comb, inf, prod, sqrt
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.configuration import Configuration, at
from rankdrop.errors import OptionError
from rankdrop.kinematics import configurations, one_configuration, task_jacobian
from rankdrop.local.block import decompose, generic_rank, joint_scale, read_only, row_scale, sigma_of, svd
from rankdrop.local.directions import lost_directions
from rankdrop.options import check_value, option
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Task, resolve_task, six_rows
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import counted, in_metres, into_metres, task_in_metres


@dataclass(frozen=True, slots=True)
class Factored:
    """S J W = U Σ Vᵀ at a batch of configurations.

    Attributes:
        u: (..., m, m) left singular vectors as columns.
        sigma: (..., min(m, n)) singular values, descending; those beyond the rank are exactly zero [1].
        v: (..., n, n) right singular vectors as columns.
        rank: (...) number of singular values of the task Jacobian above the tolerance.
        rows: (m,) diagonal of S [1/m or 1].
        joints: (n,) diagonal of W [1 or m].
    """

    u: Array
    sigma: Array
    v: Array
    rank: Array
    rows: Array
    joints: Array

    def inverse(self, squared: Array | float = 0.0, kept: NDArray[np.bool_] | bool = True) -> Array:
        """(..., n, m) the matrix W V diag(g) Uᵀ S, from SI twists to rates in rad/s and m/s.

        Args:
            squared: λ² of the gains g = σ/(σ² + λ²), which are zero beyond the rank, even where λ is.
            kept: other directions have the gain zero.
        """
        count, safe = self.sigma.shape[-1], np.where(self.sigma > 0.0, self.sigma, 1.0)
        gains = np.where((self.sigma > 0.0) & kept, 1.0 / (safe + squared / safe), 0.0)
        v, u = self.v[..., :count], self.u[..., :count]
        return np.asarray((self.joints[:, None] * v * gains[..., None, :]) @ (u * self.rows[:, None]).swapaxes(-1, -2))


def factor(robot: Robot, q: ArrayLike, task: Task, tolerances: Tolerances = DEFAULT) -> Factored:
    """Decompose the task Jacobian with the length scale on both sides.

    Singular values of the task Jacobian (W = 1) at or below `tolerances.singular` are zero.
    With prismatic joints Σ belongs to S J W, and as many of its last values are zero.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: from `resolve_task`.
        tolerances: `singular` decides.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
    """
    parts, joints = decompose(robot, q, task), joint_scale(robot, task)
    rank = (parts.sigma > tolerances.singular).sum(axis=-1)
    u, sigma, v = parts.u, parts.sigma, parts.v
    if (joints != 1.0).any():
        u, sigma, v = svd(task_jacobian(robot, q, task) * joints)
    sigma = np.where(np.arange(sigma.shape[-1]) < rank[..., None], sigma, 0.0)
    return Factored(u, sigma, v, rank, row_scale(robot, task), joints)


def task_sigma(robot: Robot, q: ArrayLike, task: Task) -> Array:
    """(..., min(m, n)) singular values of S J W; those of the task Jacobian where no joint is prismatic."""
    return sigma_of(task_jacobian(robot, q, task) * joint_scale(robot, task))


def pseudo_inverse(
    robot: Robot, q: ArrayLike, task: Task | str | None = None, *, tolerances: Tolerances = DEFAULT
) -> Array:
    """J⁺: of all joint rates that come nearest to a twist, the smallest; right at singular configurations too.

    q̇ = J⁺ξ minimises ‖S(Jq̇ − ξ)‖ and among those ‖W⁻¹q̇‖. Directions with σ ≤ `tolerances.singular` are left out; just
    above it the rates are as large as they truly have to be, up to 1/σ. See `damped_inverse` for bounded ones.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        tolerances: `singular` decides the rank.

    Returns:
        (..., n, m) from twists of the task's rows [m/s, rad/s] to joint rates [rad/s, m/s].

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: there is no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> pseudo_inverse(open_robot("planar2r"), [0.0, 0.0]).round(4).tolist()  # stretched: no motion along x
        [[0.0, 0.503], [0.0, 0.2071]]
    """
    return factor(robot, q, resolve_task(task, robot), tolerances).inverse()


def damped_inverse(
    robot: Robot,
    q: ArrayLike,
    task: Task | str | None = None,
    *,
    damping: float = 0.05,
    threshold: float | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Array:
    """Damped least squares: q̇ = argmin ‖S(Jq̇ − ξ)‖² + λ²‖W⁻¹q̇‖², gains σ_i/(σ_i² + λ²) ≤ 1/(2λ).

    Every direction pays with a tracking error of the share λ²/(σ_i² + λ²), also those that are far from lost
    (Nakamura and Hanafusa; Wampler). With a `threshold` ε the damping follows the smallest singular value,

        λ² = (1 − (σ_r/ε)²) λ₀² for σ_r < ε, else 0,

    (form of Maciejewski and Klein), so that it vanishes, continuously, away from singularities. r is the generic rank:
    what an arm can never do does not damp the rest for ever.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        damping: λ, or λ₀ with a threshold, compared with σ (without unit: translation divided by the length scale).
        threshold: ε on σ; None for constant damping.
        tolerances: `singular` decides the rank.

    Returns:
        (..., n, m) from twists [m/s, rad/s] to joint rates [rad/s, m/s].

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: there is no such task.
        OptionError: damping negative, or threshold not positive.
    """
    resolved = resolve_task(task, robot)
    check_value("damping", _NOT_NEGATIVE, damping)
    if threshold is not None:
        check_value("threshold", _POSITIVE, threshold)
    parts = factor(robot, q, resolved, tolerances)
    squared = np.full(parts.rank.shape, damping**2)
    if threshold is not None:
        weakest = parts.sigma[..., generic_rank(robot, resolved) - 1]
        squared *= np.maximum(0.0, 1.0 - (weakest / threshold) ** 2)
    return parts.inverse(squared[..., None])


def selective_inverse(
    robot: Robot,
    q: ArrayLike,
    task: Task | str | None = None,
    *,
    threshold: float = 0.05,
    damping: float | None = None,
    drop: bool = False,
    tolerances: Tolerances = DEFAULT,
) -> Array:
    """Direction-selective inverse: only directions with σ below the threshold are damped or dropped, the rest is exact.

        q̇ = Σ_i σ_i/(σ_i² + λ_i²) v_i (u_iᵀ ξ),  λ_i² = (1 − (σ_i/ε)²) λ₀² for σ_i < ε, else 0

    The tracking error S(Jq̇ − ξ) therefore has no component along any u_i with σ_i ≥ ε: what is not about to be lost is
    followed exactly, at any corank, for any n and m. The gains are continuous in σ; with the default λ₀ none of those
    below the threshold exceeds 2/(√3 ε). With `drop` the gain jumps from 1/ε to 0 at the threshold.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        threshold: ε on σ (without unit: translation divided by the length scale).
        damping: λ₀ on the same scale; None for ε/2.
        drop: leave the directions below the threshold out instead of damping them.
        tolerances: `singular` decides the rank.

    Returns:
        (..., n, m) from twists [m/s, rad/s] to joint rates [rad/s, m/s].

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: there is no such task.
        OptionError: damping negative, or threshold not positive.
    """
    check_value("threshold", _POSITIVE, threshold)
    if damping is None:
        base = threshold / 2
    else:
        base = damping
    check_value("damping", _NOT_NEGATIVE, base)
    parts = factor(robot, q, resolve_task(task, robot), tolerances)
    if drop:
        return parts.inverse(kept=parts.sigma >= threshold)
    return parts.inverse(base**2 * np.maximum(0.0, 1.0 - (parts.sigma / threshold) ** 2))


_POSITIVE, _NOT_NEGATIVE = Annotated[float, option("", gt=0)], Annotated[float, option("", ge=0)]


def rate_limits(robot: Robot) -> Array:
    """(n,) largest rate of every variable [rad/s or m/s]; inf where the source gives none.

    A mimic joint turns at |multiplier| times the rate of its leader; its own limit holds the leader back as well.
    """
    limits = {joint.name: max(0.0, joint.velocity) for joint in robot.variables}
    for joint in robot.joints:
        if joint.mimic is not None and joint.mimic.multiplier != 0.0:
            shared = max(0.0, joint.velocity) / abs(joint.mimic.multiplier)
            limits[joint.mimic.leader] = min(limits[joint.mimic.leader], shared)
    return np.array([limits[joint.name] for joint in robot.variables])


MOST = 200_000  # vertices that are listed at most; 8 joints need 70
_FLAT = 1e-12  # singular values of weighted null motions below this share are zero: rounding of unit vectors


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
    circuits = _circuits(u[None, :, :rank].swapaxes(1, 2), np.arange(count), MOST)
    if circuits is None:
        return np.eye(count), False
    return circuits[0] / np.maximum(np.abs(circuits[0]).sum(axis=1, keepdims=True), _TINY), True


def _standing(particular: Array, null: Array, stuck: Array) -> tuple[Array, Array, Array]:
    """Solutions in which the stuck joints stand still: new b and N, and where there are any."""
    u, sigma, vt = np.linalg.svd(null[stuck])
    rank = int((sigma > _FLAT).sum())
    z = -(particular[:, stuck] @ u[:, :rank] / sigma[:rank]) @ vt[:rank]
    moved = particular + z @ null.T
    size = np.abs(particular).max(axis=1, initial=0.0)
    reachable = np.abs(moved[:, stuck]).max(axis=1, initial=0.0) <= 1e-9 * np.maximum(size, np.finfo(float).tiny)
    return moved, null @ vt[rank:].T, reachable


_NOTHING = 1e-12  # a share below it is rounding
WEAKEST = "weakest direction"
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
    here = at(robot, q, task, tolerances)
    robot, resolved, verdict = here.robot, here.task, here.measured
    parts = factor(robot, here.q, resolved, here.tolerances)
    limits = rate_limits(robot)
    rows, rank = list(resolved.rows), verdict.rank
    motions = [(_AXES[row], np.eye(6)[row]) for row in rows]
    lengths = np.repeat([counted(robot), 1.0], 3)
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
    every = _along(robot, parts, motions, resolved, limits, rank, here.tolerances)
    m = resolved.m
    remaining = dict(zip(left, every[given:], strict=True))
    return Rates(
        tuple(every[:m]), every[m] if rank else None, tuple(every[m + bool(rank) : given]),
        tuple(limits.tolist()), resolved.scale(robot), tuple(shares.tolist()),
        tuple(remaining.get(row) for row in range(m)),
    )  # fmt: skip


def _along(
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
    found = []
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
        found.append(DirectionRates(name, tuple(twist.tolist()), unit, *costs))
    return found


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


def joint_direction(robot: Robot, direction: ArrayLike) -> Array:
    """(n,) the direction of a joint motion.

    Raises:
        OptionError: not one finite number per joint, or all zero.
    """
    way = np.asarray(direction, dtype=np.float64)
    if way.shape != (robot.n,) or not np.isfinite(way).all() or not way.any():
        raise OptionError("a direction of the joints is one finite number per joint, not all zero", got=way.tolist())
    return way


MOST_FACETS = 1_000
"""Candidates for a facet that are listed at most; 8 joints have 56."""
_TINY = 1e-100  # its square is still a number


@dataclass(frozen=True, eq=False)
class Slowest:
    """The slowest straight motions of one kind at N configurations.

    Attributes:
        unit: "m/s" or "rad/s".
        speed: (N,) largest speed in the slowest direction; inf where rate limits bind no direction.
        direction: (N, 3) that direction, a unit vector in the task's axes.
        joint: (N,) the joint, from 1, that limits it most.
        normal: (N, m) normal y of the facet in the task's rows: directions that are slow there.
        exact: False where the arm has too many joints to list facets: the slowest motion is no faster than `speed`.
    """

    unit: str
    speed: Array
    direction: Array
    joint: NDArray[np.intp]
    normal: Array
    exact: bool


@dataclass(frozen=True, slots=True)
class StraightMotion:
    """The slowest straight motion of one kind: the tool translates without turning, or turns about its point.

    Attributes:
        unit: of speeds: "m/s" or "rad/s".
        speed: the largest within the rate limits of the joints; `limit`: below it the motion is slow.
        direction: (3,) unit vector in the axes of the task.
        number, joint: the joint that limits it most, from 1, and its name.
        exact: False for an arm of so many joints that this is a bound: the slowest motion is no faster.
    """

    unit: str
    speed: float
    limit: float
    direction: tuple[float, ...]
    number: int
    joint: str
    exact: bool


def slowest_motions(robot: Robot, q: ArrayLike, task: Task) -> tuple[Slowest, ...]:
    """Slowest straight translation (the tool does not turn) and rotation (the tool point stands still), batched.

    Args:
        robot: the arm; `Joint.velocity` are its rate limits, those of mimic joints included.
        q: (..., n) configurations [rad, m].
        task: rows that count; a kind of motion without rows in the task is left out.

    Returns:
        One record per kind, translation first. None at all without rate limits, or with more rows than joints.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("gen3")
        >>> slow = slowest_motions(arm, [0.3, 0.5, 0.2, 0.02, 0.4, 0.8, 0.1], resolve_task(None, arm))[0]
        >>> f"{slow.speed[0]:.4f} {slow.unit}", int(slow.joint[0])
        ('0.0022 m/s', 4)
    """
    rows, _ = configurations(robot, q)
    here, inside = in_metres(robot), task_in_metres(task, robot)
    limits = rate_limits(here)
    bounded = np.flatnonzero(np.isfinite(limits))
    spare = robot.n - task.m
    if spare < 0 or len(bounded) <= spare:
        return ()
    columns = task_jacobian(here, into_metres(robot, rows), inside) * np.where(np.isfinite(limits), limits, 1.0)
    u, sigma, vt = np.linalg.svd(columns)
    facets = _circuits(vt[:, task.m :], bounded, MOST_FACETS)
    exact = facets is not None
    if facets is None:  # directions that cost most stand in: each bounds the slowest speed from above
        facets = vt[:, : task.m] * np.isfinite(limits)
    facets = facets / np.maximum(np.abs(facets).sum(axis=-1, keepdims=True), _TINY)
    normals = (facets @ vt[:, : task.m].swapaxes(1, 2) / np.maximum(sigma, _TINY)[:, None]) @ u.swapaxes(1, 2)
    scale = np.array([inside.scale(here) if row < 3 else 1.0 for row in task.rows])
    normals = normals / scale  # of twists in m/s and rad/s
    parts = (("m/s", [i for i, row in enumerate(task.rows) if row < 3]),
             ("rad/s", [i for i, row in enumerate(task.rows) if row >= 3]))  # fmt: skip
    return tuple(_slowest(unit, part, facets, normals, task, exact) for unit, part in parts if part)


@lru_cache(maxsize=4)
def _choices(joints: tuple[int, ...], size: int) -> NDArray[np.intp]:
    """(C, size) all sets of `size` joints."""
    chosen = np.array(list(combinations(joints, size)))
    chosen.flags.writeable = False
    return chosen


def _circuits(null: Array, bounded: NDArray[np.intp], most: int) -> Array | None:
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
        entries = np.stack([parts[..., 0, 1], -parts[..., 0, 0]], axis=-1)
    else:
        entries = np.linalg.svd(parts)[2][..., -1, :]
    np.put_along_axis(circuits, np.broadcast_to(chosen, entries.shape), entries, axis=-1)
    return circuits


def _slowest(unit: str, part: list[int], facets: Array, normals: Array, task: Task, exact: bool) -> Slowest:
    """The nearest facet for motions in the rows `part` alone."""
    size = np.linalg.norm(normals[..., part], axis=-1)
    best = size.argmax(axis=1)
    each = np.arange(len(best))
    longest = size[each, best]
    normal = normals[each, best]
    direction = np.zeros((len(best), 3))
    direction[:, [task.rows[i] % 3 for i in part]] = normal[:, part] / np.maximum(longest, _TINY)[:, None]
    speed = np.where(longest > 0.0, 1.0 / np.maximum(longest, _TINY), np.inf)
    return Slowest(unit, speed, direction, np.abs(facets[each, best]).argmax(axis=1) + 1, normal, exact)


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
class Part:
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
        ball: the unit balls of joint rates and of joint torques, in words.
        joints: (n,) the rate of each joint that counts as one [rad/s, m/s].
        translation, rotation: None where the task has no such rows.
        task: all rows of the task, translations divided by the length scale.
    """

    ball: str
    joints: tuple[float, ...]
    translation: Part | None
    rotation: Part | None
    task: Part


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
    here = at(robot, q, task, tolerances)
    weights, limits, zero = here.scale, rate_limits(here.robot), here.tolerances.singular
    length = here.task.scale(here.robot)
    slides = any(joint.kind is JointKind.PRISMATIC for joint in here.robot.variables)
    ball = "Σ q̇² ≤ (1 rad/s)²" + (f", slides in units of {length:.4g} m" if slides else "") + "; Σ τ² ≤ (1 N m)²"
    plain = _shapes(here.jacobian * weights, here.task, length, ball, weights, _PER_RATE, zero)
    bounded = None
    if np.isfinite(limits).all():
        ball = "Σ (q̇/limit)² ≤ 1; Σ (τ · limit)² ≤ (1 W)²"
        zero *= float((limits / weights).max())
        bounded = _shapes(here.jacobian * limits, here.task, length, ball, limits, _PER_BALL, zero)
    return Ellipsoids(plain, bounded, length)


_PER_RATE = {"translation": "m/rad", "rotation": "1", "task": "1"}  # unit of σ: speed per joint rate
_PER_BALL = {"translation": "m/s", "rotation": "rad/s", "task": "rad/s"}  # speed, since the ball has no unit


def _shapes(
    scaled: Array, task: Task, length: float, ball: str, weights: Array, units: dict[str, str], zero: float
) -> PartSet:
    """The three parts of the task Jacobian (translations divided by `length`) with weighted columns."""
    rows, parts = np.array(task.rows), {}
    for name, chosen, size in (("translation", rows < 3, length), ("rotation", rows >= 3, 1.0)):
        if chosen.any():
            parts[name] = _part(name, size * scaled[chosen], rows[chosen] % 3, np.ones(3), units[name], size * zero)
    whole = _part("task", scaled, rows, np.repeat([length, 1.0], 3), units["task"], zero, length)
    return PartSet(ball, tuple(weights.tolist()), parts.get("translation"), parts.get("rotation"), whole)


def _part(
    name: str, block: Array, places: Array, to_si: Array, unit: str, zero: float, length: float | None = None
) -> Part:
    """Ellipsoids of the rows `block` (k, n), which stand at `places` among the entries of an axis."""
    u, measured, _ = svd(block)
    values = np.where(measured > zero, measured, 0.0)
    speeds, axes = np.zeros(len(places)), np.zeros((len(places), len(to_si)))
    speeds[: len(values)] = values
    axes[:, places] = u.T
    forces = np.array([1.0 / value if value > 0.0 else inf for value in speeds])
    velocity, force = (
        Ellipsoid(read_only(axes), read_only(lengths), read_only(_stretched(axes, lengths) * to_given), of)
        for lengths, to_given, of in (
            (speeds, to_si, _PER_BALL[name]), (forces, 1.0 / to_si, "N" if name == "translation" else "N m"),
        )
    )  # fmt: skip
    count, smallest = len(values), float(values[-1])
    return Part(
        name, velocity, force,
        Index("σ_min", smallest, unit, length),
        Index("condition number", float(values[0]) / smallest if smallest > 0.0 else inf, "1", length),
        Index("manipulability", prod(values.tolist()), unit if unit == "1" or count == 1 else f"({unit})^{count}",
              length),
    )  # fmt: skip


def _stretched(axes: Array, lengths: Array) -> Array:
    """Axis times half-length; an infinite one leaves entries that are zero (1e-12) at zero."""
    finite = np.where(np.isfinite(lengths), lengths, 0.0)[:, None] * axes
    endless = np.where(np.abs(axes) > 1e-12, np.copysign(inf, axes), 0.0)
    return np.where(np.isfinite(lengths)[:, None], finite, endless)
