"""Circuits: inclusion-minimal dependent sets of joints, the smallest culprits of a loss of rank.

With columns J_i of the task Jacobian a set C is a circuit when Σ_{i∈C} c_i J_i = 0 for some c without a zero entry, and
no smaller set inside C is dependent. Every dependency of the columns is a combination of such c. KG suppress dependent
screws one by one, GR look at runs of neighbours only; the circuits are all of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, groupby
from math import e

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.errors import OptionError
from rankdrop.kinematics import one_configuration, task_jacobian
from rankdrop.local.axes import Scene
from rankdrop.local.block import generic_rank, sigma_of, singular_values, structural_sample, svd
from rankdrop.local.dependence import describe
from rankdrop.robot.model import Array, Robot, once
from rankdrop.task import Task
from rankdrop.tolerances import DEPENDENT

LARGEST_CHAIN = 20
"""Joints; with more of them the number of sets to look at is beyond a fraction of a second."""
MOST_LISTED = 1000
"""Circuits of one configuration that an explanation lists; a regular arm with 14 joints has 3,432."""

_REGULAR = 8  # regular configurations that tell what is dependent everywhere
_TOGETHER = 256  # sets that are tried at random configurations at once
_ROUNDING = 1e-11  # of a determinant of at most 20 rows with entries up to 1
_TIE = 1e-9  # coefficients closer than this share tie for the largest

Sets = tuple[NDArray[np.intp], NDArray[np.intp]]


@dataclass(frozen=True, slots=True)
class Circuit:
    """A set of joints whose columns are dependent while those of no smaller set inside it are.

    Attributes:
        numbers: joints from 1, increasing.
        coefficients: c of Σ c_i J_i = 0: joint rates that leave the task still. The largest is 1.
        units: of each coefficient, "rad" (per second) or "m" (per second).
        generic: dependent at almost every configuration too, as any m + 1 joints of a redundant arm are.
        sigma: smallest singular value of the columns scaled to unit length (0 where there are more columns than rows).
        words: what the axes have in common.
    """

    numbers: tuple[int, ...]
    coefficients: tuple[float, ...]
    units: tuple[str, ...]
    generic: bool
    sigma: float
    words: str


def circuits_at(
    robot: Robot, q: ArrayLike, task: Task, tolerance: float = DEPENDENT, *, most: int | None = None
) -> tuple[Circuit, ...]:
    """Every circuit at one configuration, small ones first, then by their numbers.

    Args:
        robot: the arm; at most `LARGEST_CHAIN` variables.
        q: (n,) configuration [rad, m].
        task: rows that count; the circuits do not depend on its frame's axes or its length scale.
        tolerance: columns scaled to unit length are dependent where their smallest σ is at or below it [1].
        most: so many of them, the first ones; None: all.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: more joints than `LARGEST_CHAIN`.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("rcrrrr")
        >>> [circuit.numbers for circuit in circuits_at(arm, [0.0] * 7, resolve_task("pose", arm))]
        [(1, 3, 4, 5), (3, 4, 6, 7), (1, 3, 5, 6, 7), (1, 4, 5, 6, 7)]
    """
    configuration = one_configuration(robot, q)
    if robot.n > LARGEST_CHAIN:
        raise OptionError(
            "there are too many joints to list every circuit", where=f"robot {robot.name!r}", got=robot.n,
            allowed=f"at most {LARGEST_CHAIN}",
        )  # fmt: skip
    columns = task_jacobian(robot, configuration[None, :], task)
    sets = shared_circuits(columns, tolerance, most=most)
    scene = Scene.at(robot, configuration)
    generic = _dependent(_usual_columns(robot, task), sets, tolerance)
    dependencies, least = _dependencies(columns[0], sets)
    units = robot.units
    return tuple(
        Circuit(
            numbers=tuple(i + 1 for i in members),
            coefficients=tuple(dependency[list(members)].tolist()),
            units=tuple(units[i] for i in members),
            generic=held,
            sigma=sigma,
            words=describe(scene, members, task),
        )
        for members, held, dependency, sigma in zip(sets, generic, dependencies, least, strict=True)
    )


@once
def _usual_columns(robot: Robot, task: Task) -> Array:
    """(N, m, n) unit columns of the task Jacobian at regular configurations."""
    return _unit_columns(task_jacobian(robot, structural_sample(robot, task, _REGULAR), task))


def blame(robot: Robot, q: ArrayLike, task: Task, tolerance: float = DEPENDENT) -> tuple[Circuit, ...]:
    """The smallest circuits, special to this configuration, that bring as many new dependencies as rank is lost.

    Dependencies count as new when they do not follow from those taken before and from the ones that hold everywhere.
    None at a regular configuration; fewer than the corank where only the whole arm tells (then `circuits_at` has none
    left either).

    Args, Raises: as `circuits_at`.
    """
    circuits = circuits_at(robot, q, task, tolerance)
    corank = generic_rank(robot, task) - int((singular_values(robot, q, task) > tolerance).sum())
    return make_all(circuits, robot.n, corank)


def make_all(circuits: Sequence[Circuit], n: int, nullity: int) -> tuple[Circuit, ...]:
    """The smallest circuits, special to this configuration, from which all its dependencies follow.

    For an arm without redundancy these are the ones of `blame`. A redundant one has n − r dependencies everywhere, and
    a single further set of dependent joints need not cost it any rank: only all of them together tell of the loss.

    Args:
        circuits: all circuits, from `circuits_at`.
        n: number of joints.
        nullity: independent dependencies, n − rank.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> found = circuits_at(arm, [0.0] * 7, resolve_task("pose", arm))
        >>> [circuit.numbers for circuit in make_all(found, 7, 4)]  # rank 3
        [(1, 3), (1, 5), (1, 7), (2, 4, 6)]
    """
    known = [_vector(circuit, n) for circuit in circuits if circuit.generic]
    special = [circuit for circuit in circuits if not circuit.generic]
    chosen = _independent(known, [_vector(circuit, n) for circuit in special], nullity)
    return tuple(special[i] for i in chosen)


def _vector(circuit: Circuit, n: int) -> Array:
    result = np.zeros(n)
    result[[number - 1 for number in circuit.numbers]] = circuit.coefficients
    return result


def to_blame(columns: Array, generic: Array, corank: int) -> list[tuple[int, ...]]:
    """The smallest circuits that bring as many independent dependencies as rank is lost; fewer if there are no more.

    Args:
        columns: (N, m, n) task Jacobians at the points of a family: the circuits hold at all of them.
        generic: (M, m, n) task Jacobians at random configurations, where they do not.
        corank: how many are wanted.

    Returns:
        Tuples of indices from 0.
    """
    special = _not_everywhere(columns, generic)
    chosen: list[tuple[int, ...]] = []
    vectors: list[Array] = []
    while len(chosen) < corank:
        members = next(special, None)
        if members is None:
            break
        vector = _dependency(columns[0], members)
        if _independent(vectors, [vector], 1):
            chosen.append(members)
            vectors.append(vector)
    return chosen


def _not_everywhere(columns: Array, generic: Array) -> Iterator[tuple[int, ...]]:
    """Circuits that hold at every point and not at random configurations, small ones first."""
    usual = _unit_columns(generic)
    for members in _circuits_by_size(columns, DEPENDENT):
        for begin in range(0, len(members), _TOGETHER):
            some = members[begin : begin + _TOGETHER]
            held = _all_dependent(usual, some, DEPENDENT)
            yield from map(tuple, some[~held].tolist())


def shared_circuits(
    columns: Array, tolerance: float = DEPENDENT, *, most: int | None = None
) -> list[tuple[int, ...]]:
    """Circuits that hold at every one of some points: smallest σ of the unit columns at or below the tolerance.

    Args:
        columns: (N, m, n) task Jacobians.
        tolerance: [1].
        most: so many of them, the first ones; None: all.

    Returns:
        Tuples of indices from 0, small ones first.
    """
    supports: list[tuple[int, ...]] = []
    for members in _circuits_by_size(columns, tolerance):
        supports += map(tuple, members[:most].tolist())
        if most is not None and len(supports) >= most:
            return supports[:most]
    return supports


def _circuits_by_size(columns: Array, tolerance: float) -> Iterator[NDArray[np.intp]]:
    """(B, size) the shared circuits of each size, from 1.

    A set is looked at when none of the sets with one member less is dependent. One with more members than all columns
    have rank is dependent: a matrix has no smaller singular values than one made of some of its columns.
    """
    rows, n = columns.shape[1:]
    unit = _unit_columns(columns)
    rank = int((sigma_of(unit) > tolerance).sum(axis=1).max())
    dependent = np.zeros(1 << n, dtype=bool)
    for size in range(1, min(rows + 1, n) + 1):
        members, masks = _sets(n, size)
        inside = dependent[masks[:, None] ^ (1 << members)].any(axis=1)
        new = ~inside
        if size <= rank:
            new[new] = _all_dependent(unit, members[new], tolerance)
        dependent[masks[inside | new]] = True
        yield members[new]


@lru_cache(maxsize=256)
def _sets(n: int, size: int) -> Sets:
    """(B, size) all sets of `size` out of n, and (B,) their bit masks."""
    members = np.array(list(combinations(range(n), size)), dtype=np.intp).reshape(-1, size)
    return members, (1 << members).sum(axis=1)


def _all_dependent(unit: Array, members: NDArray[np.intp], tolerance: float) -> NDArray[np.bool_]:
    """(B,) whether each set (B, s) is dependent at every point; more columns than rows always are."""
    points, rows, _ = unit.shape
    count, size = members.shape
    if size > rows or count == 0:
        return np.ones(count, dtype=bool)
    result = _maybe_dependent(unit[0], members, tolerance)
    few = members[result]
    parts = unit[:, :, few].transpose(0, 2, 1, 3).reshape(-1, rows, size)
    sigma = sigma_of(parts)[:, -1].reshape(points, len(few))
    result[result] = (sigma <= tolerance).all(axis=0)
    return result


def _maybe_dependent(unit: Array, members: NDArray[np.intp], tolerance: float) -> NDArray[np.bool_]:
    """(B,) false where columns (m, n) of length 1 are independent for sure.

    The determinant of their inner products is Π σᵢ², and Σ σᵢ² = s: where the smallest σ is at most the tolerance, it
    is at most tolerance² (s/(s − 1))^(s − 1) < e tolerance².
    """
    inner = unit.T @ unit
    determinants = np.linalg.det(inner[members[:, :, None], members[:, None, :]])
    return np.asarray(determinants <= e * tolerance**2 + _ROUNDING)


def _dependent(unit: Array, sets: Sequence[tuple[int, ...]], tolerance: float) -> list[bool]:
    """Whether each set, small ones first, is dependent at every point; sets of one size are tested together."""
    held: list[bool] = []
    for _, same_size in groupby(sets, key=len):
        members = np.array(list(same_size), dtype=np.intp)
        held += _all_dependent(unit, members, tolerance).tolist()
    return held


def _dependency(columns: Array, members: tuple[int, ...]) -> Array:
    """(n,) c with Σ c_i J_i = 0 over a circuit, the largest entry 1 (the first of equals)."""
    return _dependencies(columns, [members])[0][0]


def _dependencies(columns: Array, sets: Sequence[tuple[int, ...]]) -> tuple[list[Array], list[float]]:
    """Of each circuit, small ones first: (n,) c with Σ c_i J_i = 0, the largest entry 1 (the first of equals); and the
    smallest singular value of its columns at length 1, 0 where there are more columns than rows.

    Circuits of one size are taken apart together.

    Args:
        columns: (m, n) task Jacobian.
        sets: indices from 0.
    """
    rows, n = columns.shape
    dependencies: list[Array] = []
    least: list[float] = []
    for size, same_size in groupby(sets, key=len):
        members = np.array(list(same_size), dtype=np.intp)  # (B, size)
        own = columns[:, members].swapaxes(0, 1)  # (B, m, size)
        lengths = _lengths(own)
        _, sigma, v = svd(own / lengths)
        rates = v[..., -1] / lengths[:, 0]
        sizes = np.abs(rates)
        first_largest = (sizes >= sizes.max(axis=1, keepdims=True) * (1 - _TIE)).argmax(axis=1)
        each = np.arange(len(members))
        found = np.zeros((len(members), n))
        found[each[:, None], members] = rates / rates[each, first_largest][:, None]
        dependencies += list(found)
        least += [0.0] * len(members) if size > rows else sigma[:, -1].tolist()
    return dependencies, least


def _independent(known: list[Array], vectors: Iterable[Array], count: int) -> list[int]:
    """Indices of the first vectors, at most `count`, that are independent of each other and of the known ones."""
    taken, chosen = list(known), list[int]()
    if taken:
        rank = int(np.linalg.matrix_rank(np.array(taken), tol=1e-6))
    else:
        rank = 0
    for i, vector in enumerate(vectors):
        if len(chosen) >= count:
            break
        if np.linalg.matrix_rank(np.array([*taken, vector]), tol=1e-6) > rank:
            chosen.append(i)
            taken.append(vector)
            rank += 1
    return chosen


def _lengths(columns: Array) -> Array:
    """Lengths of the columns; 1 for those that are rounding."""
    length = np.linalg.norm(columns, axis=-2, keepdims=True)
    return np.asarray(np.where(length > DEPENDENT, length, 1.0))


def _unit_columns(columns: Array) -> Array:
    return np.asarray(columns / _lengths(columns))
