"""The block: what the smallest singular directions see, and how every joint moves it.

U₂ (m × (m − r)) and V₂ (n × (n − r)) span the left and right singular directions of the task Jacobian J beyond rank r.

    F = U₂ᵀ J V₂        vanishes exactly where rank J ≤ r
    D(Δ) = U₂ᵀ dJ(Δ) V₂   is what a joint motion Δ does to F, dJ from the bracket

With r = generic rank − k, F = 0 is a singularity of corank k. D answers the rest: its columns for k = 1 are the
gradient of σ_i (AM eq. 7), its kernel the tangent space of the singular set, D(e_j) what joint j alone can do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop._core import decompose_one, sigma_one
from rankdrop.errors import OptionError
from rankdrop.kinematics import chain_of, configurations, handles_of, rows_of, task_view, view_of
from rankdrop.robot.arm_reach import reach, travel_limits
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.units import in_units, task_in_units

STRUCTURE_SEED = 20231
"""Of the configurations that tell what holds almost everywhere."""


class Decomposition(NamedTuple):
    """J = U Σ Vᵀ; a tuple, which is made in half the time of a dataclass.

    Attributes:
        u: (..., m, m) left singular vectors as columns: twists of the task, lost ones last.
        sigma: (..., min(m, n)) singular values, descending.
        v: (..., n, n) right singular vectors as columns: joint motions, the null space last.
    """

    u: Array
    sigma: Array
    v: Array


@dataclass(frozen=True, slots=True)
class Block:
    """F and D at a configuration, for a kept rank r; p = m − r, s = n − r.

    Attributes:
        f: (..., p, s) U₂ᵀ J V₂.
        d: (..., p, s, n) D of each joint, [1/rad or 1/m].
        u2: (..., m, p) left directions beyond rank r.
        v2: (..., n, s) right directions beyond rank r, the null space included.
        sigma: (..., min(m, n)) singular values, descending.
    """

    f: Array
    d: Array
    u2: Array
    v2: Array
    sigma: Array


def read_only(array: Array) -> Array:
    """The array itself, which can no longer be written to."""
    array.flags.writeable = False
    return array


def svd(matrices: Array) -> tuple[Array, Array, Array]:
    """U (..., m, m), σ (..., min(m, n)) and V (..., n, n) of matrices (..., m, n), by one-sided Jacobi."""
    parts = _core.svd(np.ascontiguousarray(matrices).reshape(-1, *matrices.shape[-2:]))
    u, sigma, v = (part.reshape(matrices.shape[:-2] + part.shape[1:]) for part in parts)
    return u, sigma, v


def sigma_of(matrices: Array) -> Array:
    """(..., min(m, n)) singular values of matrices (..., m, n), descending."""
    sigma = _core.svd(np.ascontiguousarray(matrices).reshape(-1, *matrices.shape[-2:]), False)
    return sigma.reshape(matrices.shape[:-2] + sigma.shape[1:])


def singular_values(robot: Robot, q: ArrayLike, task: Task | str | None = None, *, out: Array | None = None) -> Array:
    """Singular values of the task Jacobian, descending, by one-sided Jacobi; error at most 4 · eps · ‖J‖.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad or m].
        task: name, `Task`, or None for the task the arm is made for.
        out: where to write the result, an array of its shape and float64.

    Returns:
        (..., min(m, n)) [1, with the translation rows divided by the length scale].

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: the task does not exist.
        OptionError: out has another shape or type, or shares memory with q.
    """
    view = view_of(robot, task)
    single = sigma_one(robot, q, out, view)
    if single is not None:
        return single
    rows, batch = configurations(robot, q)
    into = rows_of(out, rows, batch, (min(view.m, robot.n),))
    sigma = _core.singular_values(chain_of(robot), view, rows, into)
    if out is None:
        return sigma.reshape(*batch, sigma.shape[1])
    return out


def decompose(robot: Robot, q: ArrayLike, task: Task | str | None = None) -> Decomposition:
    """Singular value decomposition of the task Jacobian (AM eq. 3), full bases on both sides.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: the task does not exist.
    """
    view = view_of(robot, task)
    parts = decompose_one(robot, q, view)
    if parts is not None:
        return tuple.__new__(Decomposition, parts)  # its own constructor takes three times as long
    rows, batch = configurations(robot, q)
    u, sigma, v = _core.decompose(chain_of(robot), view, rows)
    return Decomposition(*(part.reshape(batch + part.shape[1:]) for part in (u, sigma, v)))


def block(robot: Robot, q: ArrayLike, task: Task | str | None, rank: int) -> Block:
    """F, D and the bases they are written in.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad or m].
        task: name, `Task`, or None for the task the arm is made for.
        rank: the kept rank r, 0 … min(m, n) − 1; generic rank − k for corank k.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: the task does not exist.
        OptionError: there is no block beyond that rank.
    """
    resolved = resolve_task(task, robot)
    smallest = min(resolved.m, robot.n)
    if not 0 <= rank < smallest:
        raise OptionError("there is no block beyond this rank", got=rank, allowed=f"0 … {smallest - 1}")
    rows, batch = configurations(robot, q)
    parts = _core.block(chain_of(robot), task_view(robot, resolved), rows, rank)
    f, d, u2, v2, sigma = (part.reshape(batch + part.shape[1:]) for part in parts)
    return Block(f, d, u2, v2, sigma)


def sample(robot: Robot, task: Task, count: int, seed: int, *, limits: bool = False) -> Array:
    """Uniform random configurations in `sampling_box`.

    Args:
        robot: the arm.
        task: gives the length scale.
        count: how many.
        seed: of the generator; same seed, same configurations.
        limits: keep every joint inside its limits.

    Returns:
        (count, n) [rad or m].
    """
    low, high = sampling_box(robot, task, limits=limits)
    return np.random.default_rng(seed).uniform(low, high, (count, robot.n))


def sampling_box(robot: Robot, task: Task, *, limits: bool) -> tuple[Array, Array]:
    """Lower and upper corner (n,) of the configurations worth sampling.

    A turning joint goes round the full circle, or as many as `Robot.turns` says, unless `limits`. A sliding joint
    always keeps its limits. A limit that is missing, or so far away that it says nothing (`travel_limits`), leaves room
    for as much, or for twice the reach.
    """
    low, high = np.empty(robot.n), np.empty(robot.n)
    for i, joint in enumerate(robot.variables):
        slides = joint.kind is JointKind.PRISMATIC
        room = reach(robot) if slides else np.pi * max(robot.turns[i], 1)
        if limits or slides:
            lower, upper = (joint.lower, joint.upper)
        else:
            lower, upper = (-np.inf, np.inf)
        if slides:
            lower, upper = travel_limits(robot, joint)
        if not np.isfinite(lower):
            if not np.isfinite(upper):
                lower = -room
            else:
                lower = min(-room, upper - 2 * room)
        if not np.isfinite(upper):
            upper = max(room, lower + 2 * room)
        if slides:  # limits that are far from zero, too
            lower = max(min(lower, joint.upper - (upper - lower)), joint.lower)
            if upper <= lower:
                upper = min(max(upper, lower + 2 * room), joint.upper)
            else:
                upper = min(upper, joint.upper)
        low[i], high[i] = lower, upper
    return low, high


def limit_box(robot: Robot, task: Task) -> tuple[Array, Array]:
    """Lower and upper corner (n,) of where a motion may go within limits: `sampling_box`, slides up to their ends."""
    low, high = sampling_box(robot, task, limits=True)
    slides = np.array([joint.kind is JointKind.PRISMATIC for joint in robot.variables])
    low = np.where(slides & np.isfinite(robot.lower), robot.lower, low)
    return low, np.where(slides & np.isfinite(robot.upper), robot.upper, high)


def joint_scale(robot: Robot, task: Task) -> Array:
    """(n,) what one unit of joint motion is measured by: 1 for a turning joint [rad], the length scale for a slide [m].

    Norms of joint motions and distances in joint space are taken of Δ divided by it.
    """
    length = task.scale(robot)
    scales = handles_of(robot).scales
    if length not in scales:
        every = [length if joint.kind is JointKind.PRISMATIC else 1.0 for joint in robot.variables]
        scales[length] = read_only(np.array(every))
    return scales[length]


def row_scale(robot: Robot, task: Task) -> Array:
    """(m,) what every task row of a twist is multiplied by: 1/ℓ for translations [1/m], 1 for rotations."""
    length = task.scale(robot)
    return np.array([1.0 / length if row < 3 else 1.0 for row in task.rows])


def structural_sample(robot: Robot, task: Task, count: int) -> Array:
    """(count, n) random configurations, always the same ones, that stand for almost all: what holds there is structure.
    """
    samples = handles_of(robot).samples
    key = (count, task.scale(robot))
    if key not in samples:
        samples[key] = read_only(sample(robot, task, count, STRUCTURE_SEED))
    return samples[key]


def generic_rank(robot: Robot, task: Task) -> int:
    """Largest rank of the task Jacobian over random configurations: the rank of almost all of them.

    Below min(m, n) the arm is singular at every configuration for this task. Found once for each robot and task.
    """
    ranks = handles_of(robot).ranks
    key = (task.frame, task.rows, task.scale(robot))
    if key not in ranks and robot.exponent is None:
        ranks[key] = generic_rank(in_units(robot), task_in_units(task, robot))
    elif key not in ranks:
        sigma = singular_values(robot, structural_sample(robot, task, 64), task)
        noise = 1e3 * np.finfo(float).eps * sigma[:, :1]
        ranks[key] = int((sigma > noise).sum(axis=1).max())
    return ranks[key]
