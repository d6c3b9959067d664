"""How to leave a singular configuration: motions of the joints that restore the rank, and edges of the reach.

A joint a moved alone changes the block of the lost directions by D(e_a) = U₂ᵀ dJ(e_a) V₂, which GR build from the Lie
products [S_a, S_i] (sections 3 and 4); its rank is the rank regained at first order, its singular values the rates.
Where it falls short, higher orders decide (`rankdrop.local.departure`). Every prediction is judged by a finite motion;
σ is that of the task Jacobian with translation rows over the length scale, so rates depend on that scale, while ranks,
orders and joints do not.

The second order says what the null space does to the lost motions. Move along q + sΔ + ½s²a with Δ in the null space of
J. The end effector's twist is s (J a + dJ(Δ)Δ) + O(s²), so

    Q_u(Δ) = u · dJ(Δ)Δ,   u a lost direction (uᵀJ = 0)

is what the joints cannot take back: the end effector moves along u at second order. Q_u is a quadratic form on the null
space. Where it is not zero, the lost direction can be reached so (type 1); where it vanishes, only an internal motion
leaves (type 2). A self-motion needs Q_u(Δ) = 0 for every u; where some Q_u is definite there is none through q, not
even one that starts with a cusp: the leading term c sᵏ of an analytic curve has Q_u(c) = 0 too.

Null motions that can be tangents of a self-motion are traced a short way, all at once, to leave a singularity with the
end effector at rest: steps ahead, each put back to where the end effector was (`Displacement`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.configuration import LEAST, Configuration, configuration_at
from rankdrop.kinematics import jacobian
from rankdrop.local.departure import (
    Departure,
    best_motion,
    best_pair,
    departures,
    measured_gains,
    release_mimics,
    single_motions,
)
from rankdrop.local.directions import lost_directions
from rankdrop.local.orientation import Displacement, determined_by_pose
from rankdrop.options import check_value, option
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import brackets, unit
from rankdrop.sections import html, words_of
from rankdrop.solve import iterate, shortest_of_small
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, ENTRY, Tolerances
from rankdrop.units import counted_as_radian, out_of_metres

StillReason = Literal["always moves", "definite", "rows", "no tangent", "regular", "left", "stayed", "stayed so far",
                      "too small", "untraced"]  # fmt: skip
"""Why a singularity can be left with the tool held still ("left"), or cannot, or is not known to be."""
EdgeReason = Literal["open", "never whole", "several", "both signs", "one sign", "flat"]
"""What decides whether the tool is at an edge of its reach: the sign of the form on the null space, or why not."""

_STEP = Annotated[float, option("Length of motions", unit="rad", ge=1e-3, le=1.0)]
_SEED = Annotated[int, option("Seed", ge=0)]

FLAT = DEFAULT.block_rank
"""A form with entries below this is zero: the cut of D, for the same reason [1/rad]."""
_STARTS = 48  # random starts for directions on which all forms vanish
_NEWTON = 12  # steps of each
_ARRIVED = 1e-14  # one that moves no farther has arrived
_APART = 0.05  # unit vectors nearer than this, up to sign, are the same direction
_SAMPLES = 256  # combinations of lost directions tried for a definite one

_MOST = 4  # tangents that are traced, both ways
_STEPS = 4  # of a trace
_LENGTH = 0.12  # at least so far, so that the ends are 0.1 rad away even where the curve bends
_LEFT = 1e-5  # σ_r that a trace has to reach: where it is of second order an error of 1e-12 hides σ of 1e-6
_STAYED = 1e-6  # σ_r up to which a trace counts as singular all along
_FIRST = 1e-6  # singular values of D along a tangent below this are zero

Traces = tuple[Array, Array, Array, NDArray[np.bool_]]
"""Short self-motions from q, one per tangent: (c, steps + 1, n) configurations, the first q itself [rad, m];
(c, steps + 1) σ_r there, r the generic rank; (c,) largest displacement of the task on the way, translations over the
length scale; (c,) whether the end effector stood still and the arm did move."""


def receptors(place: Configuration) -> tuple[tuple[int, ...], ...]:
    """Per actuator a, the joints i (from 1) whose change leaves the span of all screws, and that are dependent at q.

    For the whole pose the change is [S_a, S_i], i > a. Tasks with fewer rows take the change of the task Jacobian's
    column, which is also there for joints before a when the reference point moves.

    What the receptors bring can cancel: an actuator with receptors need not restore the rank. D says whether it does.
    """
    if not place.corank:
        return ((),) * len(place.q)
    chain, values, _ = release_mimics(place.robot, place.q)
    if place.task.m == 6 and chain is place.robot:
        change = brackets(jacobian(chain, values, place.task.frame))
        change[:, :3] /= place.task.scale(place.robot)
    else:
        change = np.moveaxis(place.derivative, -1, 0)
    leaves = np.linalg.norm(np.einsum("mp,ami->api", place.u2, change), axis=1) > ENTRY
    depends = np.linalg.norm(place.v2, axis=1) > ENTRY
    return tuple(tuple(int(i) + 1 for i in np.flatnonzero(row & depends)) for row in leaves)


@dataclass(frozen=True, slots=True)
class JointEscape:
    """One joint moved alone.

    Attributes:
        number, joint: of the variable, from 1, and its name.
        gain: rank regained by this joint alone for small motions, predicted from the Taylor series of J.
        order: power of its motion at which σ_r leaves zero, r the generic rank; None where it alone never restores it
            (looked for up to order 4 for a turning or sliding joint and whole poses, positions or orientations: more
            cannot be; up to 8 else).
        rate: σ_r ≈ rate · |t|^order [1/rad^order or 1/m^order]; 0.0 where order is None. At a regular configuration
            the slope dσ_r/dt with its sign, and order is 1.
        first_order: singular values of D(e_j), descending, as many as the corank [1/rad or 1/m].
        receptors: GR: joints (from 1) that the motion carries out of the span of all screws, among those that take
            part in a dependency.
        measured_gain: rank after a finite motion (0.3 and 0.7 rad to both sides) minus rank before.
        step: the signed motion that was tried, inside limits [rad or m]; 0.0 where there is no room.
        sigma_after: σ_r after it.
        within_limits: there is room for a motion inside the limits.
        agrees: prediction and finite motion say the same.
    """

    number: int
    joint: str
    gain: int
    order: int | None
    rate: float
    first_order: tuple[float, ...]
    receptors: tuple[int, ...]
    measured_gain: int
    step: float
    sigma_after: float
    within_limits: bool
    agrees: bool


@dataclass(frozen=True, slots=True)
class Direction:
    """A motion of several joints.

    Attributes:
        delta: (n,) unit vector in scaled joint coordinates, given in rad and m: q + step · delta is where it leads.
        numbers: joints that move, from 1.
        gain: rank regained for small motions.
        order, rate: σ_r ≈ rate · t^order, t in scaled coordinates; None and 0.0 where σ_r does not leave zero.
        step: length of the motion in scaled coordinates [rad; metres over the length scale].
        sigma_after: σ_r after it.
        restores: σ_r after it is above what counts as zero.
        within_limits: it stays inside the limits.
        measured_gain: rank after it minus rank before.
    """

    delta: tuple[float, ...]
    numbers: tuple[int, ...]
    gain: int
    order: int | None
    rate: float
    step: float
    sigma_after: float
    restores: bool
    within_limits: bool
    measured_gain: int


@dataclass(frozen=True, slots=True)
class LostMotion:
    """One lost direction at second order.

    Attributes:
        direction: (6,) as from `lost_directions`: vx vy vz wx wy wz in the task's frame.
        type: 1 where the end effector can move along it at second order by Δ in the null space; 2 where not: it is
            left only by internal motion.
        form: eigenvalues of u · dJ(Δ)Δ on the null space, ascending, u of unit length in the scaled task [1/rad].
    """

    direction: tuple[float, ...]
    type: int
    form: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Escape:
    """How to leave one configuration.

    Attributes:
        corank: task freedoms lost; 0 at a regular configuration: motions then lead away from the nearest loss.
        single: all joints, best first: those that restore the full rank by σ_r reached, then the others.
        best_pair: two joints; None for an arm with one.
        best_direction: all joints.
        still: a self-motion that restores the rank, traced; its `delta` is the tangent at q, `step` its length.
        avoidable: True: such a self-motion was traced. False: there is none. None: none was found, which is no proof.
        avoidable_reason: what says so.
        still_error: largest task error on the way of `still`, translations over the length scale; 0 for none.
        types: each lost direction at second order.
        boundary: True: q maps to the boundary of the workspace, near q; False: to its interior; None: undecided.
        boundary_reason: what says so.
        nearby: q is only near a singularity: both answers hold if it were one.
        floor: a singular value at or below it does not count as regained.
    """

    corank: int
    single: tuple[JointEscape, ...]
    best_pair: Direction | None
    best_direction: Direction
    still: Direction | None
    avoidable: bool | None
    avoidable_reason: StillReason
    still_error: float
    types: tuple[LostMotion, ...]
    boundary: bool | None
    boundary_reason: EdgeReason
    nearby: bool
    floor: float

    def _repr_html_(self) -> str:
        """For notebooks: per joint what it does alone, then the best direction and the self-motion."""
        return html(words_of(self).sections_of(self))


def escape(
    robot: Robot | Configuration,
    q: ArrayLike | None = None,
    task: Task | str | None = None,
    *,
    tolerances: Tolerances = DEFAULT,
    seed: int = 0,
    step: float = 0.1,
    corank: int | None = None,
) -> Escape:
    """Which motions lead out of a singular configuration (GR sections 3 and 4, made exact and checked).

    Args:
        robot: the arm, or a `Configuration`, which stands for the first four.
        q: (n,) configuration [rad, m].
        task: a Task, a name, or None for the arm's own.
        tolerances: `singular` decides what is zero.
        seed: of the random starts for the best and the still direction.
        step: length of the motions that are compared [rad; length scales for a slide], 1e-3 … 1.
        corank: treat q, near a singularity, as if it had this corank; None: the corank it has.

    Returns:
        An `Escape`. Near a singularity, with `corank` given, a rank counts as regained where σ grows tenfold.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: step, seed or corank outside what is allowed.
        TaskError: no such task, or one the arm does not move in at all.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> out = escape(open_robot("rcrrrr"), [0] * 7, resolve_task(None, open_robot("rcrrrr"), length_scale=1.0))
        >>> [(joint.number, joint.order, round(joint.rate, 4)) for joint in out.single if joint.gain]
        [(4, 1, 2.0713), (3, 1, 0.7036)]
    """
    here = configuration_at(robot, q, task, tolerances, corank)
    here.check_moves()
    place = here.metric
    check_value("step", _STEP, step)
    check_value("seed", _SEED, seed)
    basis = null_basis(place)
    each = forms(place, basis)
    single = _single(place, step)
    still, avoidable, reason, error = find_still(place, basis, each, step, seed)
    pair, best = _several(place, step, seed, single)
    edge, edge_reason = boundary(place, each)
    nearby = bool(place.corank and place.sigma[place.rank] > place.tolerances.singular)
    if nearby:  # q itself is regular: denials hold elsewhere
        avoidable, edge = avoidable or None, None
    ways_out = Escape(
        corank=place.corank,
        single=single,
        best_pair=pair,
        best_direction=best,
        still=still,
        avoidable=avoidable,
        avoidable_reason=reason,
        still_error=error,
        types=lost_motions(place, basis),
        boundary=edge,
        boundary_reason=edge_reason,
        nearby=nearby,
        floor=place.floor,
    )
    if place is here:
        return ways_out
    return _out_of_metres(ways_out, here.robot)


def _out_of_metres(escape: Escape, robot: Robot) -> Escape:
    """Motions of `in_metres(robot)` as those of the arm itself."""
    unit = out_of_metres(robot, np.ones(robot.n))  # of slides

    def several(one: Direction) -> Direction:
        return replace(one, delta=tuple((unit * one.delta).tolist()))

    def escape_alone(joint: JointEscape) -> JointEscape:
        own = float(unit[joint.number - 1])
        first = tuple(value / own for value in joint.first_order)
        return replace(joint, rate=joint.rate / own ** (joint.order or 0), first_order=first, step=joint.step * own)

    return replace(
        escape, single=tuple(map(escape_alone, escape.single)),
        best_pair=escape.best_pair and several(escape.best_pair),
        best_direction=several(escape.best_direction),
        still=escape.still and several(escape.still),
    )


def _single(place: Configuration, step: float) -> tuple[JointEscape, ...]:
    """Every joint alone, ranked."""
    units = np.eye(len(place.q))
    leaving = departures(place, units)
    gains = measured_gains(place, units)
    steps, sigma = single_motions(place, step)
    receives = receptors(place)
    down, up = place.room
    out = []
    for j, joint in enumerate(place.robot.variables):
        (gain, order, rate, first), unit = leaving[j], float(place.scale[j])
        out.append(
            JointEscape(
                number=j + 1,
                joint=joint.name,
                gain=gain,
                order=order,
                rate=rate / unit ** (order or 0),
                first_order=tuple(value / unit for value in first),
                receptors=receives[j],
                measured_gain=int(gains[j]),
                step=float(steps[j]) * unit,
                sigma_after=float(sigma[j]),
                within_limits=bool(max(down[j], up[j]) >= LEAST),
                agrees=bool(gains[j] == gain),
            )
        )
    return tuple(sorted(out, key=lambda joint: _standing(joint, place)))


def _standing(joint: JointEscape, place: Configuration) -> tuple[float, ...]:
    """Sorts: joints that restore by σ_r reached, then the others by what they gain; rounding decides nothing."""
    restores = joint.gain == place.corank
    if joint.sigma_after > place.floor:
        reached = float(f"{joint.sigma_after:.9e}")
    else:
        reached = 0.0
    return (not restores, 0 if restores else -joint.gain, -reached, joint.number)


def _several(
    place: Configuration, step: float, seed: int, single: tuple[JointEscape, ...]
) -> tuple[Direction | None, Direction]:
    """The best pair and the best direction; the second starts from the first and from the single joints."""
    moves = np.zeros((len(single), len(place.q)))
    for row, joint in enumerate(single):
        moves[row, joint.number - 1] = joint.step / place.scale[joint.number - 1]
    moves = moves[np.abs(moves).max(axis=1) > 0]
    if len(place.q) > 1:
        pair = best_pair(place, step)
    else:
        pair = None
    if pair is None:
        known = moves
    else:
        known = np.concatenate([pair[None], moves])
    whole = best_motion(place, step, seed, known)
    motions = np.stack([whole] if pair is None else [whole, pair])
    described = _describe_motions(place, motions)
    return (described[1] if pair is not None else None), described[0]


def _describe_motions(place: Configuration, motions: Array) -> list[Direction]:
    """Directions with their order and rate. A motion that the limits leave no room for is shown without them."""
    lengths = np.linalg.norm(motions, axis=1)
    inside = lengths >= LEAST
    units = np.where(inside[:, None], motions / np.maximum(lengths, 1e-300)[:, None], 0.0)
    units[~inside, 0] = 1.0  # no motion at all: some unit vector has to stand there
    lengths = np.where(inside, lengths, 0.0)
    leaving = departures(place, units)
    sigma = place.singular_values(place.q + units * lengths[:, None] * place.scale)[:, : place.generic]
    ranks = (sigma > place.floor).sum(axis=-1)
    return [
        _direction(place, units[i], made, float(lengths[i]), float(sigma[i, -1]), gain=int(ranks[i]) - place.rank,
                   inside=bool(inside[i]))
        for i, made in enumerate(leaving)
    ]  # fmt: skip


def _direction(
    place: Configuration, unit: Array, made: Departure, step: float, sigma: float, *, gain: int, inside: bool
) -> Direction:
    """A motion along a unit vector (n,) in scaled coordinates as a record."""
    return Direction(
        delta=tuple((unit * place.scale).tolist()),
        numbers=tuple(int(j) + 1 for j in np.flatnonzero(np.abs(unit) > ENTRY)),
        gain=made[0],
        order=made[1],
        rate=made[2],
        step=step,
        sigma_after=sigma,
        restores=sigma > place.floor,
        within_limits=inside,
        measured_gain=gain,
    )


def null_basis(place: Configuration) -> Array:
    """(n, s) orthonormal basis of the null space of J in scaled joint coordinates."""
    return np.asarray(np.linalg.qr(place.v2 / place.scale[:, None])[0])


def forms(place: Configuration, basis: Array) -> Array:
    """(m − rank, s, s) symmetric matrices of Q_u on the null space, u the columns of U₂."""
    return _forms_of(place, basis, place.u2.T)


def lost_motions(place: Configuration, basis: Array) -> tuple[LostMotion, ...]:
    """Each lost direction with its form and its type."""
    if not place.corank:
        return ()
    rows = lost_directions(place.robot, place.q, place.task, place.corank)
    scaled = rows * np.repeat([place.task.scale(place.robot) / counted_as_radian(place.robot), 1.0], 3)
    each = _forms_of(place, basis, unit(scaled[:, list(place.task.rows)]))
    return tuple(
        LostMotion(tuple(row.tolist()), 1 if np.abs(values).max(initial=0.0) > FLAT else 2, tuple(values.tolist()))
        for row, values in zip(rows, np.linalg.eigvalsh(each), strict=True)
    )


def _forms_of(place: Configuration, basis: Array, lost: Array) -> Array:
    """(p, s, s) symmetric matrices of u · dJ(N_a) N_b, u the rows of `lost` (p, m), N the columns of a basis (n, s)."""
    first = place.derivative_along(basis.T) @ (basis * place.scale[:, None])
    each = np.einsum("pm,amb->pab", lost, first)
    return np.asarray((each + np.swapaxes(each, -1, -2)) / 2)


def definite(each: Array, seed: int) -> bool:
    """Whether some combination of the forms (p, s, s) is definite; a search: False is not a proof."""
    if not each.size:
        return False
    if len(each) == 1:
        weights = np.array([[1.0], [-1.0]])
    else:
        weights = unit(np.random.default_rng(seed).normal(size=(_SAMPLES, len(each))))
    least = np.linalg.eigvalsh(np.einsum("wp,pab->wab", weights, each))[:, 0]
    return bool(least.max() > FLAT)


def vanishing(each: Array, seed: int) -> tuple[Array, bool]:
    """Unit vectors on which all forms vanish, by Gauss–Newton on the sphere from random starts.

    Args:
        each: (p, s, s) forms.
        seed: of the starts.

    Returns:
        (c, s) vectors, and whether the forms are zero as a whole (every vector counts then).
    """
    size = each.shape[-1]
    starts = np.random.default_rng(seed).normal(size=(_STARTS, size))
    if size > 1:
        starts = np.concatenate([np.eye(size), starts])
    else:
        starts = np.eye(1)
    x = unit(starts)
    if not each.size or float(np.abs(each).max()) <= FLAT:
        return x, True
    _, sigma, vt = np.linalg.svd(each.reshape(-1, size))
    x = np.concatenate([x, vt[int((sigma > FLAT).sum()) :]])  # every form sends these to zero: Newton finds them slowly

    def along_sphere(x: Array, _active: NDArray[np.intp]) -> Array:
        image = (each @ x.T).transpose(2, 0, 1)  # (c, p, s)
        return unit(x - shortest_of_small(2 * image, (image @ x[:, :, None])[:, :, 0])) - x

    x = iterate(along_sphere, x, iterations=_NEWTON, still=_ARRIVED)
    left = np.abs(np.einsum("pab,ca,cb->cp", each, x, x)).max(axis=1)
    return x[left <= 1e-10 * max(1.0, float(np.abs(each).max()))], False


def distinct(vectors: Array, order: NDArray[np.intp]) -> list[int]:
    """Indices of unit vectors (c, n) that differ by more than a sign, the first of each in the given order."""
    near = np.abs(vectors @ vectors.T) >= 1.0 - _APART**2 / 2
    kept: list[int] = []
    for i in order:
        if not near[i, kept].any():
            kept.append(int(i))
    return kept


def boundary(place: Configuration, each: Array) -> tuple[bool | None, EdgeReason]:
    """Whether q maps to the boundary of the workspace, and why; from the form on the null space, corank 1 only.

    The form's kernel holds the null motions that are tangent to the same singular family (D vanishes on them, for D is
    symmetric on the null space). Modulo them a definite form keeps the end effector on one side.
    """
    if not place.corank:
        full = place.generic == place.task.m
        if full:
            return (False, "open")
        return (None, "never whole")
    if place.corank > 1 or place.generic < place.task.m:
        return None, "several"
    eigenvalues = np.linalg.eigvalsh(each[0])
    up, down = bool(eigenvalues[-1] > FLAT), bool(eigenvalues[0] < -FLAT)
    if up and down:
        return False, "both signs"
    if up or down:
        return True, "one sign"
    return None, "flat"


Stillness = tuple[Direction | None, bool | None, StillReason, float]
"""A self-motion that restores the rank, whether there is one and why, and the largest task error on its way."""


def find_still(place: Configuration, basis: Array, each: Array, step: float, seed: int) -> Stillness:
    """Look for a self-motion through q that restores the rank, and say what is known if there is none.

    Args:
        place: where.
        basis: (n, s) of the null space, scaled coordinates.
        each: (m − rank, s, s) the forms on it, from `forms`.
        step: length of a trace, at least 0.12.
        seed: of random starts.
    """
    if not basis.shape[1]:
        return None, False, "always moves", 0.0
    if place.corank and definite(each, seed):
        return None, False, "definite", 0.0
    if not determined_by_pose(place.task):
        return None, None, "rows", 0.0
    vectors, all_vanish = vanishing(each, seed)
    if not len(vectors):
        return None, None, "no tangent", 0.0
    tangents, promise = _chosen(place, vectors @ basis.T)
    q, sigma, error, valid = trace(place, tangents, max(step, _LENGTH))
    least = max(_LEFT, place.floor) if place.corank else sigma[:, 0]
    leaves = valid & (sigma[:, -1] > least)
    if not leaves.any():
        return None, *_why_it_stays(place, sigma, valid, all_vanish or _few(each)), 0.0
    moved, (down, up) = (q - place.q) / place.scale, place.room
    inside = np.asarray(((moved >= -down - 1e-9) & (moved <= up + 1e-9)).all(axis=(1, 2)))
    reached = np.round(sigma[:, -1], 9) + 1e3 * inside  # inside the limits if any is; rounding decides nothing
    best = int(np.argmax(np.where(leaves, reached, -1.0)))
    length = float(np.linalg.norm(moved[best, -1]))
    order, rate = _order_along(sigma[best], float(promise[best]), length)
    still = _direction(
        place, tangents[best], (place.corank, order, rate, ()), length, float(sigma[best, -1]), gain=place.corank,
        inside=bool(inside[best]),
    )  # fmt: skip
    return still, True if place.corank else None, "left", float(error[best])


def trace(place: Configuration, tangents: Array, length: float) -> Traces:
    """Follow self-motions with the given tangents.

    Args:
        place: where they start.
        tangents: (c, n) unit vectors in scaled coordinates, in the null space of J.
        length: how far to go, in scaled coordinates.

    Returns:
        What came of each; not valid where the corrector did not bring the end effector back.
    """
    where = Displacement(place.robot, place.q, place.task)
    path, valid = [np.broadcast_to(place.q, tangents.shape)], np.ones(len(tangents), dtype=bool)
    ahead = tangents
    for _ in range(_STEPS):
        reached, arrived = where.back(path[-1] + ahead * (length / _STEPS) * place.scale)
        ahead = unit((reached - path[-1]) / place.scale)
        path.append(reached)
        valid &= arrived
    q = np.stack(path, axis=1)
    sigma = place.last(q)
    gone = np.linalg.norm((q[:, -1] - place.q) / place.scale, axis=1)
    return q, sigma, np.linalg.norm(where.error(q), axis=-1).max(axis=1), valid & (gone >= 0.6 * length)


def _few(each: Array) -> bool:
    """Whether the directions on which the forms vanish are a few lines, which are then all found.

    One form on a plane vanishes on two lines at most, a semidefinite one on its kernel only.
    """
    size = each.shape[-1]
    if size == 1 or (size == 2 and len(each) == 1):
        return True
    if len(each) != 1:
        return False
    eigenvalues = np.linalg.eigvalsh(each[0])
    one_sided = eigenvalues[0] >= -FLAT or eigenvalues[-1] <= FLAT
    return bool(one_sided and (np.abs(eigenvalues) <= FLAT).sum() == 1)


def _chosen(place: Configuration, tangents: Array) -> tuple[Array, Array]:
    """The most promising tangents, both ways, and the k-th singular value of D along each."""
    tangents = unit(tangents)
    slopes = place.derivative_along(tangents)
    if place.corank:
        first = place.u2.T @ slopes @ place.v2
        promise = _core.svd(np.ascontiguousarray(first), False)[:, place.corank - 1]
    else:
        r = place.generic - 1
        promise = np.abs(place.u[:, r] @ slopes @ place.v[:, r])
    kept = distinct(tangents, np.lexsort((np.arange(len(promise)), -np.round(promise, 9))))[:_MOST]
    return np.concatenate([tangents[kept], -tangents[kept]]), np.concatenate([promise[kept], promise[kept]])


def _why_it_stays(
    place: Configuration, sigma: Array, valid: NDArray[np.bool_], complete: bool
) -> tuple[bool | None, StillReason]:
    """No trace restores the rank: whether those were all there are."""
    if not place.corank:
        return None, "regular"
    stayed = bool((sigma.max(axis=1) <= max(_STAYED, place.floor)).all())
    if complete and stayed and valid.all():
        return False, "stayed"
    if valid.any():
        return None, "stayed so far" if stayed else "too small"
    return None, "untraced"


def _order_along(sigma: Array, promise: float, length: float) -> tuple[int, float]:
    """Order and rate of σ_r along a trace with evenly spaced points."""
    if promise > _FIRST:
        return 1, promise
    quarter = length / (len(sigma) - 1)
    ratio = float(sigma[2] / max(sigma[1], 1e-300))
    order = max(1, round(np.log2(max(ratio, 1e-300))))
    return order, float(sigma[1]) / quarter**order
