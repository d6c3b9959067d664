"""How to get out of a singularity: joint by joint, by two joints, by all of them, and without moving the end effector.

A joint a moved alone changes the block of the lost directions by D(e_a) = U₂ᵀ dJ(e_a) V₂, which GR build from the Lie
products [S_a, S_i]; its rank is the rank regained at first order, its singular values the rates. Where it falls short,
higher orders decide (`departure`). Every prediction is judged by a finite motion; σ is that of the task Jacobian with
translation rows over the length scale, so rates depend on that scale, while ranks, orders and joints do not.

Actuators and receptors: which joint carries which screws out of what the screws span (GR sections 3 and 4).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.configuration import LEAST, Configuration, at
from rankdrop.errors import OptionError
from rankdrop.kinematics import jacobian
from rankdrop.local import departure as finite_motions
from rankdrop.local.bracket import brackets
from rankdrop.local.departure import Departure, departures, taylor, unlocked
from rankdrop.local.notebook import escape_html
from rankdrop.local.second_order import (
    EdgeReason,
    LostMotion,
    Stillness,
    StillReason,
    boundary,
    find_still,
    lost_motions,
    null_basis,
)
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, ENTRY, Tolerances
from rankdrop.units import out_of_metres


def receptors(place: Configuration) -> tuple[tuple[int, ...], ...]:
    """Per actuator a, the joints i (from 1) whose change leaves the span of all screws, and that are dependent at q.

    For the whole pose the change is [S_a, S_i], i > a. Tasks with fewer rows take the change of the task Jacobian's
    column, which is also there for joints before a when the reference point moves.

    What the receptors bring can cancel: an actuator with receptors need not restore the rank. D says whether it does.
    """
    if not place.corank:
        return ((),) * len(place.q)
    chain, values, _ = unlocked(place.robot, place.q)
    if place.task.m == 6 and chain is place.robot:
        change = brackets(jacobian(chain, values, place.task.frame))
        change[:, :3] /= place.task.scale(place.robot)
    else:
        change = taylor(place.robot, place.q, place.task, np.eye(len(place.q)), 1)[1]
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
        return escape_html(self)


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
    here = at(robot, q, task, tolerances, corank)
    here.check_moves()
    place = here.metric
    check_step(step)
    if seed < 0:
        raise OptionError("seed is outside the range", got=seed, allowed="a whole number from 0 up")
    basis = null_basis(place)
    single = _single(place, step)
    stillness = find_still(place, basis, step, seed)
    pair, best = _several(place, step, seed, single)
    avoidable = stillness.avoidable
    edge, edge_reason = boundary(place, stillness.forms)
    nearby = bool(place.corank and place.sigma[place.rank] > place.tolerances.singular)
    if nearby:  # q itself is regular: denials hold elsewhere
        avoidable, edge = avoidable or None, None
    found = Escape(
        corank=place.corank,
        single=single,
        best_pair=pair,
        best_direction=best,
        still=_still_direction(place, stillness),
        avoidable=avoidable,
        avoidable_reason=stillness.reason,
        still_error=stillness.error,
        types=lost_motions(place, basis),
        boundary=edge,
        boundary_reason=edge_reason,
        nearby=nearby,
        floor=place.floor,
    )
    return found if place is here else _out_of_metres(found, here.robot)


def check_step(step: float) -> None:
    """Refuse a length of motions that is not compared.

    Raises:
        OptionError: outside 1e-3 … 1.
    """
    if not 1e-3 <= step <= 1.0:
        raise OptionError("the step is outside the range", got=step, allowed="1e-3 … 1 (rad, or length scales)")


def _out_of_metres(escape: Escape, robot: Robot) -> Escape:
    """Motions of `in_metres(robot)` as those of the arm itself."""
    unit = out_of_metres(robot, np.ones(robot.n))  # of slides

    def several(one: Direction | None) -> Direction | None:
        return None if one is None else replace(one, delta=tuple((unit * one.delta).tolist()))

    def alone(joint: JointEscape) -> JointEscape:
        own = float(unit[joint.number - 1])
        first = tuple(value / own for value in joint.first_order)
        return replace(joint, rate=joint.rate / own ** (joint.order or 0), first_order=first, step=joint.step * own)

    best = several(escape.best_direction)
    assert best is not None
    return replace(
        escape, single=tuple(alone(one) for one in escape.single), best_pair=several(escape.best_pair),
        best_direction=best, still=several(escape.still),
    )  # fmt: skip


def _single(place: Configuration, step: float) -> tuple[JointEscape, ...]:
    """Every joint alone, ranked."""
    units = np.eye(len(place.q))
    found = departures(place, units) if place.corank else _slopes(place, units)
    gains = finite_motions.measured_gains(place, units)
    steps, sigma = finite_motions.single_motions(place, step)
    receives = receptors(place)
    down, up = place.room
    out = []
    for j, joint in enumerate(place.robot.variables):
        made, unit = found[j], float(place.scale[j])
        out.append(
            JointEscape(
                number=j + 1,
                joint=joint.name,
                gain=made.gain,
                order=made.order,
                rate=made.rate / unit ** (made.order or 0),
                first_order=tuple(value / unit for value in made.first),
                receptors=receives[j],
                measured_gain=int(gains[j]),
                step=float(steps[j]) * unit,
                sigma_after=float(sigma[j]),
                within_limits=bool(max(down[j], up[j]) >= LEAST),
                agrees=bool(gains[j] == made.gain),
            )
        )
    return tuple(sorted(out, key=lambda joint: _standing(joint, place)))


def _standing(joint: JointEscape, place: Configuration) -> tuple[float, ...]:
    """Sorts: joints that restore by σ_r reached, then the others by what they gain; rounding decides nothing."""
    restores = joint.gain == place.corank
    reached = float(f"{joint.sigma_after:.9e}") if joint.sigma_after > place.floor else 0.0
    return (not restores, 0 if restores else -joint.gain, -reached, joint.number)


def _several(
    place: Configuration, step: float, seed: int, single: tuple[JointEscape, ...]
) -> tuple[Direction | None, Direction]:
    """The best pair and the best direction; the second starts from the first and from the single joints."""
    moves = np.zeros((len(single), len(place.q)))
    for row, joint in enumerate(single):
        moves[row, joint.number - 1] = joint.step / place.scale[joint.number - 1]
    moves = moves[np.abs(moves).max(axis=1) > 0]
    pair = finite_motions.best_pair(place, step) if len(place.q) > 1 else None
    known = moves if pair is None else np.concatenate([pair[None], moves])
    whole = finite_motions.best_motion(place, step, seed, known)
    motions = np.stack([whole] if pair is None else [whole, pair])
    described = _described(place, motions)
    return (described[1] if pair is not None else None), described[0]


def _described(place: Configuration, motions: Array) -> list[Direction]:
    """Directions with their order and rate. A motion that the limits leave no room for is shown without them."""
    lengths = np.linalg.norm(motions, axis=1)
    inside = lengths >= LEAST
    units = np.where(inside[:, None], motions / np.maximum(lengths, 1e-300)[:, None], 0.0)
    units[~inside, 0] = 1.0  # no motion at all: some unit vector has to stand there
    lengths = np.where(inside, lengths, 0.0)
    found = departures(place, units) if place.corank else _slopes(place, units)
    reached = finite_motions.scores(place, units * lengths[:, None])
    sigma = place.last(place.q + units * lengths[:, None] * place.scale)
    return [
        Direction(
            delta=tuple(float(x) for x in units[i] * place.scale),
            numbers=tuple(int(j) + 1 for j in np.flatnonzero(np.abs(units[i]) > ENTRY)),
            gain=made.gain,
            order=made.order,
            rate=made.rate,
            step=float(lengths[i]),
            sigma_after=float(sigma[i]),
            restores=bool(sigma[i] > place.floor),
            within_limits=bool(inside[i]),
            measured_gain=int(reached[i, 0]) - place.rank,
        )
        for i, made in enumerate(found)
    ]


def _slopes(place: Configuration, directions: Array) -> tuple[Departure, ...]:
    """At a regular configuration: dσ_r/dt, with its sign (AM eq. 7)."""
    first = taylor(place.robot, place.q, place.task, directions * place.scale, 1)[1]
    r = place.generic - 1
    slopes = place.u[:, r] @ first @ place.v[:, r]
    return tuple(Departure(0, 1, float(slope), ()) for slope in slopes)


def _still_direction(place: Configuration, found: Stillness) -> Direction | None:
    """The traced self-motion that restores, as a direction at q."""
    if found.tangent is None:
        return None
    return Direction(
        delta=tuple(float(x) for x in found.tangent * place.scale),
        numbers=tuple(int(j) + 1 for j in np.flatnonzero(np.abs(found.tangent) > ENTRY)),
        gain=found.gain,
        order=found.order,
        rate=found.rate,
        step=found.length,
        sigma_after=found.sigma_after,
        restores=found.sigma_after > place.floor,
        within_limits=found.within_limits,
        measured_gain=found.gain,
    )
