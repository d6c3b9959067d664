"""Range and null space of the task Jacobian, the projector on the null space, and motion inside it (JL).

    rank J + dim N(J) = n,     P = I − J⁺J,     q̇ = J⁺ξ + P q̇₀

J⁺ rests on a singular value decomposition whose rank is decided on σ, so that everything is right at exactly singular
configurations. JL writes the projector P = I − Jᵀ(JJᵀ)†J. It is the same matrix, and as good where no σ is small, or
where σ is zero and the rank is given, as here. In between it loses half of the digits, because JJᵀ holds σ²: P is off
by about eps/σ², and below σ ≈ 3e-8 ‖J‖ the direction drowns in rounding. Largest entry of the difference, PA-10,
θ4 → 0:

    σ_min        1e-2    1e-3    1e-4    1e-5    1e-6    1e-7    1e-8    0
    difference   3e-12   1e-11   1e-8    1e-6    2e-4    3e-3    0.5     2e-15

while J P stays below 3e-16 for the projector by SVD at all of them. `away_from_limits`, `away_from_singularity` and
`towards` are secondary objectives for `null_space_motion`, batched over q.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.configuration import Configuration, Rank, configuration_at
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import configurations
from rankdrop.local.block import block, generic_rank, joint_scale, read_only
from rankdrop.local.directions import readable_basis
from rankdrop.local.inverses import Factored, factor
from rankdrop.problem import whole_turns
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import html, words_of
from rankdrop.task import Task, resolve_task, six_rows
from rankdrop.tolerances import DEFAULT, Tolerances

_COUPLED = 1e-12  # entries of a projector below this do not join two coordinates
_READABLE = 3  # a block of more dimensions gets a basis by pivoting: the readable search takes too long


def away_from_limits(robot: Robot, q: ArrayLike) -> Array:
    """Towards the middle of every joint's range: the gradient of −½ Σ ((q_i − middle_i)/(range_i/2))².

    In joint rates, metric taken out: q̇_i = −(q_i − middle_i), weighted with 1 for every joint, so that slides need no
    length scale: each joint returns to its middle at the same relative pace. Joints without both limits rest.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].

    Returns:
        (..., n) [rad/s, m/s], zero where a joint is in its middle or has no limits.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
    """
    rows, batch = configurations(robot, q)
    low, high = (np.where(np.isfinite(robot.upper - robot.lower), end, np.nan) for end in (robot.lower, robot.upper))
    return np.nan_to_num(0.5 * (low + high) - rows).reshape(*batch, robot.n)


def away_from_singularity(robot: Robot, q: ArrayLike, task: Task | str | None = None) -> Array:
    """Gradient of the smallest singular value that is not always zero: ∂σ_r/∂q_j = u_rᵀ (∂J/∂q_j) v_r (AM eq. 7).

    r is the generic rank. At a singular configuration σ_r has a kink: σ_r grows along the result and along its
    opposite alike, and the sign is arbitrary; where several σ are equal, so is the choice among them; where all first
    derivatives vanish (PA-10 at its zero pose, say) the result is zero, and second order decides.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        task: name, `Task`, or None for the task the arm is made for.

    Returns:
        (..., n) joint rates of steepest ascent in scaled coordinates: gradient times `joint_scale`².

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        TaskError: there is no such task.
    """
    resolved = resolve_task(task, robot)
    at_points = block(robot, q, resolved, generic_rank(robot, resolved) - 1)
    left, _, right = np.linalg.svd(at_points.f)  # u_r and v_r in the bases of the block
    gradient = np.einsum("...a,...abj,...b->...j", left[..., :, 0], at_points.d, right[..., 0, :])
    return np.asarray(gradient * joint_scale(robot, resolved) ** 2)


def towards(robot: Robot, q: ArrayLike, preferred: ArrayLike) -> Array:
    """Towards a preferred configuration: q̇ = preferred − q, whole turns of periodic joints left out.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        preferred: (n,) configuration [rad, m].

    Returns:
        (..., n) [rad/s, m/s].

    Raises:
        ConfigurationError: q or preferred has the wrong shape or is not finite.
    """
    rows, batch = configurations(robot, q)
    goal, extra = configurations(robot, preferred)
    if extra:
        raise ConfigurationError("one preferred configuration is needed", got=np.shape(preferred), allowed=(robot.n,))
    way = goal - rows
    return np.asarray(way - whole_turns(robot, way)).reshape(*batch, robot.n)


@dataclass(frozen=True, slots=True)
class RankNullity:
    """rank + nullity = n, the two counted apart from each other.

    Attributes:
        rank: number of independent directions in the range (singular values above the tolerance).
        nullity: number of independent joint motions v that were tried in J and found to move nothing.
        n: number of joints.
        holds: rank + nullity == n.
        largest: largest ‖Ĵv‖ over the null motions, ‖v‖ = 1 [1].
    """

    rank: int
    nullity: int
    n: int
    holds: bool
    largest: float


@dataclass(frozen=True, slots=True)
class Redundancy:
    """What the joints can do at one configuration, and what they can do unseen.

    Attributes:
        rank: the verdict on σ; its `nullity` is the redundancy, its `corank` the task freedoms lost.
        check: rank–nullity, counted.
        range_basis: (rank, 6) rows: end-effector twists (v; ω) that can be made [m/s, rad/s], in the task's frame,
            orthonormal with 1 m = 1 rad as lost directions are, and orthogonal to these.
        null_basis: (nullity, n) rows: joint rates [rad/s, m/s] that leave the task still, orthonormal in scaled rates
            q̇ / `joint_scale`.
        projector: (n, n) P = I − J⁺J. Orthogonal (symmetric) in scaled rates.
        closed_form: (n, n) JL's I − Jᵀ(JJᵀ)†J, † with as many eigenvalues as the rank tells.
        difference: largest entry of projector − closed_form.
        idempotent: largest entry of PP − P.
        annihilates: largest entry of Ĵ P, translation rows divided by the length scale [1].
        closed_annihilates: the same for the closed form.
        joint_scale: (n,) the joint motion that counts as one: 1 rad, or the length scale [m].
    """

    rank: Rank
    check: RankNullity
    range_basis: Array
    null_basis: Array
    projector: Array
    closed_form: Array
    difference: float
    idempotent: float
    annihilates: float
    closed_annihilates: float
    joint_scale: Array

    def _repr_html_(self) -> str:
        """For notebooks: range, null space and projector with their checks."""
        return html(words_of(self).redundancy_sections(self))


def redundancy(
    robot: Robot | Configuration, q: ArrayLike | None = None, task: Task | str | None = None, *,
    tolerances: Tolerances = DEFAULT,
) -> Redundancy:  # fmt: skip
    """Bases of range and null space, the rank–nullity check and the projector in two forms.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        tolerances: `singular` decides the rank.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        TaskError: there is no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = redundancy(open_robot("pa10"), [0.0] * 7)
        >>> found.check.rank, found.check.nullity, found.check.holds
        (3, 4, True)
        >>> found.null_basis[-1].round(3).tolist()  # joints 2, 4, 6 together
        [0.0, -0.43, 0.0, 0.816, 0.0, -0.387, 0.0]
    """
    here = configuration_at(robot, q, task, tolerances)
    verdict, parts = here.measured, factor(here.robot, here.q, here.task, here.tolerances)
    scaled = here.jacobian * parts.joints
    null = parts.v[:, verdict.rank :]
    projector = null @ null.T
    closed = _closed_form(scaled, verdict.rank)
    twists = six_rows(parts.u[:, : verdict.rank].T / parts.rows, here.task)
    given, form = (np.asarray(parts.joints[:, None] * matrix / parts.joints) for matrix in (projector, closed))
    return Redundancy(
        rank=verdict,
        check=_check(scaled, parts, verdict.rank, here.tolerances.singular),
        range_basis=read_only(readable_parts(np.linalg.qr(twists.T)[0]).T),  # orthonormal in metres and radians
        null_basis=read_only(readable_parts(null).T * parts.joints),
        projector=read_only(given),
        closed_form=read_only(form),
        difference=float(np.abs(given - form).max()),
        idempotent=float(np.abs(projector @ projector - projector).max()),
        annihilates=float(np.abs(scaled @ projector).max()),
        closed_annihilates=float(np.abs(scaled @ closed).max()),
        joint_scale=read_only(parts.joints),
    )


def null_space_motion(
    robot: Robot,
    q: ArrayLike,
    twist: ArrayLike,
    secondary: ArrayLike,
    task: Task | str | None = None,
    *,
    tolerances: Tolerances = DEFAULT,
) -> Array:
    """Joint rates that follow a twist and use what is left over for a second objective: q̇ = J⁺ξ + P q̇₀ (JL).

    P q̇₀ is the part of q̇₀ that the end effector does not notice; with an empty null space it is zero.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        twist: (..., m) wanted twist, the task's rows in the task's frame [m/s, rad/s].
        secondary: (..., n) wished joint rates q̇₀ [rad/s, m/s], such as a gradient from `rankdrop.local.redundant`.
        task: name, `Task`, or None for the task the arm is made for.
        tolerances: `singular` decides the rank.

    Returns:
        (..., n) joint rates [rad/s, m/s].

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        OptionError: twist or secondary has the wrong shape or is not finite.
        TaskError: there is no such task.
    """
    resolved = resolve_task(task, robot)
    parts = factor(robot, q, resolved, tolerances)
    batch = parts.rank.shape
    xi = _vectors("twist", twist, resolved.m, batch)
    wished = _vectors("secondary", secondary, robot.n, batch) / parts.joints
    kept = parts.v * (np.arange(robot.n) < parts.rank[..., None])[..., None, :]  # columns of V that move the task
    unseen = wished - (kept @ (kept.swapaxes(-1, -2) @ wished[..., None]))[..., 0]
    return np.asarray((parts.inverse() @ xi[..., None])[..., 0] + parts.joints * unseen)


def readable_parts(columns: Array) -> Array:
    """Readable orthonormal basis of a subspace, block by block of the coordinates that it couples.

    The blocks are read off the projector. A block of more than three dimensions gets a basis by pivoted elimination of
    the projector's columns, which also depends on the subspace only.

    Args:
        columns: (n, k) orthonormal columns.

    Returns:
        (n, k) orthonormal columns, blocks in the order of their first coordinate.
    """
    size, count = columns.shape
    if count in (0, size):
        return np.eye(size)[:, :count]
    projector = columns @ columns.T
    parts = []
    for members in _blocks(np.abs(projector) > _COUPLED):
        inner = projector[np.ix_(members, members)]
        dimension = round(float(np.trace(inner)))
        if dimension == 0:
            continue
        basis = np.linalg.eigh(inner)[1][:, -dimension:]
        if dimension <= _READABLE or dimension == len(members):
            local = readable_basis(basis)
        else:
            local = _pivot_columns(inner)
        placed = np.zeros((size, dimension))
        placed[members] = local[:, :dimension]
        parts.append(placed)
    return np.concatenate(parts, axis=1)


def _blocks(coupled: NDArray[np.bool_]) -> list[list[int]]:
    """Coordinates joined by a symmetric relation, in groups."""
    size = len(coupled)
    joined = np.linalg.matrix_power(coupled + np.eye(size), size) > 0.0
    return [np.flatnonzero(row).tolist() for i, row in enumerate(joined) if not row[:i].any()]


def _pivot_columns(projector: Array) -> Array:
    """Orthonormal columns from the projector's own, the longest remaining one first (earlier ones win ties)."""
    rest, pivots = projector.copy(), []
    for _ in range(round(float(np.trace(projector)))):
        lengths = np.linalg.norm(rest, axis=0)
        pivot = int(np.argmax(lengths >= lengths.max() - 1e-9))
        unit = rest[:, pivot] / lengths[pivot]
        pivots.append(unit)
        rest = rest - np.outer(unit, unit @ rest)
    return np.column_stack(pivots)


def _closed_form(scaled: Array, rank: int) -> Array:
    """I − Jᵀ(JJᵀ)†J, † by the eigenvalues of JJᵀ."""
    values, vectors = np.linalg.eigh(scaled @ scaled.T)
    values, vectors = values[::-1][:rank], vectors[:, ::-1][:, :rank]
    told = values > len(scaled) * np.finfo(float).eps * values.max(initial=0.0)  # the rest is rounding of JJᵀ
    values, vectors = values[told], vectors[:, told]
    return np.asarray(np.eye(scaled.shape[1]) - scaled.T @ (vectors / values) @ vectors.T @ scaled)


def _check(scaled: Array, parts: Factored, rank: int, tolerance: float) -> RankNullity:
    motions = parts.joints[:, None] * parts.v
    motions /= np.linalg.norm(motions, axis=0)  # the tolerance speaks of σ of the Jacobian without joint scale
    seen = np.linalg.norm((scaled / parts.joints) @ motions, axis=0)
    nullity = int((seen <= tolerance).sum())
    n = scaled.shape[1]
    return RankNullity(rank, nullity, n, rank + nullity == n, float(seen[rank:].max(initial=0.0)))


def _vectors(name: str, value: ArrayLike, size: int, batch: tuple[int, ...]) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != size or not np.isfinite(array).all():
        raise OptionError(f"{name} needs {size} finite numbers", got=array.shape, allowed=f"shape (..., {size})")
    try:
        np.broadcast_shapes(array.shape[:-1], batch)
    except ValueError:
        raise OptionError(f"{name} and q have different batch axes", got=array.shape[:-1], allowed=batch) from None
    return array
