"""One verb: the Jacobian seen from a link, in closed form and at a configuration, with its closed inverse (ML, KG)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from math import atan2

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.algebra.matrix import each_entry
from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.work import OutOfTime, Work
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.arm.geometry import first_and_last
from rankdrop.exact.arm.structure import check_frame, frame_jacobian, sizes
from rankdrop.exact.closed_inverse import ClosedInverse, closed_inverse
from rankdrop.formula.shortest import single_angles
from rankdrop.formula.value import Quotient, number_at
from rankdrop.kinematics import check_robot, jacobian, one_configuration, pose
from rankdrop.local.block import sample
from rankdrop.results.jacobian_in_frame import Agreement, CheckKind, JacobianNumbers, LinkJacobian, regular
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.transform import rotation, translation
from rankdrop.task import Task
from rankdrop.units import out_of_units

TRIED = 5
"""Random configurations at which the closed forms are held against the numeric Jacobian."""
AGREE = 1e-9
"""They agree to this part of the largest entry."""


def link_jacobian(
    robot: Robot,
    frame: int | None = None,
    task: str | Task | None = None,
    *,
    at: int | None = None,
    q: ArrayLike | None = None,
    symbolic: bool = True,
    inverse: bool = False,
    lengths: str | Mapping[str, float] = "auto",
    seconds: float = 60.0,
) -> LinkJacobian:
    """The Jacobian seen from a link, in closed form, at a configuration, or both.

    Args:
        robot: revolute and prismatic joints; a joint that follows another one is of its kind, with a whole multiplier
            where it turns.
        frame: link 1 … n whose axes are taken; None for the one in which it is shortest (numbers alone: link 1).
        task: as in `resolve_task`.
        at: reference point: the origin of this link's frame; None for the tip.
        q: a configuration [rad, m] for numbers.
        symbolic: closed forms; needs python-flint.
        inverse: the inverse, too: closed where closed forms are asked for, and of the numbers.
        lengths: as in `exact_chain`.
        seconds: limit on work for the closed inverse; of the processor's time fifteen times as much.

    Raises:
        RobotError: a helical joint, or one that follows another in a way that is not algebraic.
        TaskError: rows that would be others in the axes of a link.
        OptionError: no such link; neither closed forms nor a configuration; an inverse of a matrix that is not square;
            the limit was met.
        MissingExtraError: closed forms without python-flint.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = link_jacobian(open_robot("planar2r"), 1, inverse=True)
        >>> found.texts()
        (('−a2 s2', '−a2 s2'), ('a1 + a2 c2', 'a2 c2'))
        >>> found.inverse_texts()
        (('c2 / (a1 s2)', '1 / a1'), ('−(a1 + a2 c2) / (a1 a2 s2)', '−1 / a1'))
    """
    check_robot(robot)
    if not symbolic and q is None:
        raise OptionError("nothing is asked for", mend="closed forms: symbolic=True, or a configuration: q=…")
    chain = exact_chain(robot, task, lengths=lengths)
    _check_asked(chain, frame, at, inverse=inverse)
    ordered = tuple(sizes(chain)) if symbolic else ()
    k = frame or _shortest_frame(ordered, at)
    rows: Sequence[Sequence[Polynomial]] = ()
    closed = None
    if symbolic:
        rows = frame_jacobian(chain, k, at)
        closed = _inverse(chain, rows, seconds) if inverse else None
    numbers = None
    if q is not None:
        numbers = _numbers_at(chain, one_configuration(robot, q), k, at, inverse)
    return LinkJacobian(
        robot=robot,
        task=chain.task,
        frame=k,
        at=at,
        letters=chain.numbers,
        shifts=tuple(float(x) for x in chain.shifts),
        rows=tuple(map(tuple, rows)),
        shortest=ordered,
        closed=closed,
        numbers=numbers,
        checks=tuple(_checks(chain, k, at, rows, closed, numbers)),
        chain=chain,
    )


def _check_asked(chain: Chain, frame: int | None, at: int | None, *, inverse: bool) -> None:
    """Refuse a link that the chain does not have, and an inverse of a matrix that is not square."""
    check_frame(chain, 1 if frame is None else frame, at)
    if inverse and chain.n != chain.task.m:
        raise OptionError(
            "only a square Jacobian has an inverse", where=f"robot {chain.robot.name!r}",
            got=f"{chain.task.m} rows, {chain.n} joints", mend="a task with as many rows as joints",
            typed="--task with as many rows as joints",
        )  # fmt: skip


def _shortest_frame(ordered: Sequence[tuple[int, int, int | None]], at: int | None) -> int:
    """The link with the axes that make the closed form at a reference point shortest; 1 without closed forms."""
    return next((link for _, link, point in ordered if point == at), 1)


def numeric(chain: Chain, q: Array, k: int, at: int | None) -> Array:
    """(m, n) rows of the task at one configuration, lengths in metres: the core's Jacobian at the tip, turned into the
    axes of link k and moved to the origin of the frame of link `at`.
    """
    robot = chain.robot
    turn = _frame(chain, q, k)[:3, :3]
    value = jacobian(robot, q)
    linear, angular = value[:3], value[3:]
    if at is not None:
        way = _frame(chain, q, at)[:3, 3] - pose(robot, q)[:3, 3]
        linear = linear + np.cross(angular, way, axis=0)
    whole = np.concatenate([turn.T @ linear, turn.T @ angular])
    return np.asarray(whole[list(chain.task.rows)])


def _frame(chain: Chain, q: Array, k: int) -> Array:
    """(4, 4) pose in the base of the frame of link k: z along axis k, x along the normal after it."""
    frame = first_and_last(chain.robot)[0]
    theta = q + chain.shifts
    for j, section in enumerate(chain.sections[:k], 1):
        angle = atan2(float(section.phase.sin), float(section.phase.cos))
        slide = float(section.d)
        moved = float(section.multiplier) * float(theta[section.variable - 1])
        if section.kind is JointKind.REVOLUTE:
            angle += moved
        else:
            slide += moved
        frame = frame @ rotation("z", angle) @ translation(0.0, 0.0, slide)
        if j < k:
            twist = atan2(float(section.twist.sin), float(section.twist.cos))
            frame = frame @ rotation("x", twist) @ translation(float(section.a), 0.0, 0.0)
    return np.asarray(frame)


def _inverse(chain: Chain, rows: Sequence[Sequence[Polynomial]], seconds: float) -> ClosedInverse:
    try:
        return closed_inverse(chain.ring, rows, Work(seconds))
    except OutOfTime as end:
        raise OptionError(
            "the closed inverse takes longer than it may", got=str(end),
            mend="allow more time, another frame, or numbers: q=… with symbolic=False",
            typed="allow more time (--time-limit), another frame, or numbers alone: --q",
        ) from end  # fmt: skip


def _numbers_at(chain: Chain, q: Array, k: int, at: int | None, inverse: bool) -> JacobianNumbers:
    matrix = numeric(chain, q, k, at)
    sigma = np.linalg.svd(matrix, compute_uv=False)
    square = matrix.shape[0] == matrix.shape[1]
    inverted = inverse and square and regular(matrix)
    return JacobianNumbers(
        tuple(float(x) for x in q), matrix, float(np.linalg.det(matrix)) if square else None,
        np.asarray(np.linalg.inv(matrix), dtype=np.float64) if inverted else None,
        tuple(float(x) for x in sigma),
    )  # fmt: skip


def _checks(
    chain: Chain,
    k: int,
    at: int | None,
    rows: Sequence[Sequence[Polynomial]],
    closed: ClosedInverse | None,
    numbers: JacobianNumbers | None,
) -> Iterator[Agreement]:
    """Agreement of the closed forms with the numeric Jacobian, and of the inverses with the matrices."""
    if rows:
        places = list(out_of_units(chain.robot, sample(chain.own, chain.own_task, TRIED, 0)))
        matrices = [numeric(chain, q, k, at) for q in places]
        worst = _largest_difference(chain, rows, places, matrices)
        yield Agreement(CheckKind.CLOSED_FORM, worst <= AGREE, worst, TRIED)
        if closed is not None:
            yield from _checks_of_inverse(chain, closed, places, matrices)
    if numbers is not None and numbers.inverse is not None:
        worst = float(np.abs(numbers.inverse @ numbers.matrix - np.eye(len(numbers.q))).max())
        yield Agreement(CheckKind.NUMERIC_INVERSE, worst <= AGREE, worst)


def _largest_difference(
    chain: Chain, rows: Sequence[Sequence[Polynomial]], places: Sequence[Array], matrices: Sequence[Array]
) -> float:
    """Largest difference of closed and numeric Jacobians at places (n,), of the largest entry there."""
    forms = each_entry(lambda x: single_angles(chain.ring, x), rows)
    worst = 0.0
    for q, matrix in zip(places, matrices, strict=True):
        here = partial(number_at, theta=q + chain.shifts, letters=chain.numbers)
        values: Array = np.array(each_entry(here, forms))
        worst = max(worst, float(np.abs(values - matrix).max() / np.abs(matrix).max()))
    return worst


def _checks_of_inverse(
    chain: Chain, closed: ClosedInverse, places: Sequence[Array], matrices: Sequence[Array]
) -> Iterator[Agreement]:
    """Agreement of the closed inverse with the closed Jacobian modulo a prime, and with the numeric one at places."""
    yield Agreement(CheckKind.ADJUGATE, closed.agree == closed.tested, None, closed.tested, closed.agree)
    gap = 0.0
    for q, matrix in zip(places, matrices, strict=True):
        gap = max(gap, _gap(closed.entries, q + chain.shifts, chain.numbers, matrix))
    yield Agreement(CheckKind.CLOSED_INVERSE, gap <= AGREE, gap, TRIED)


def _gap(entries: Sequence[Sequence[Quotient]], theta: Array, letters: Mapping[str, float], matrix: Array) -> float:
    """Largest entry of J⁻¹ J − 1, over the size of J⁻¹ times that of J."""
    values: Array = np.array(each_entry(lambda x: float(x.at(theta, letters)), entries))
    size = np.linalg.norm(values) * np.linalg.norm(matrix)
    return float(np.abs(values @ matrix - np.eye(len(matrix))).max() / max(size, 1.0))
