"""Which joints lie in one proper subgroup of the rigid motions, at one configuration.

The connected subgroups, as Lie algebras of twists (all there are up to the choice of axis, point and pitch):

    dimension 1  turns about a line, screws of one pitch along a line, slides along a direction
    dimension 2  cylindrical (a line), translations of a plane
    dimension 3  spherical (a point), planar (a normal), translations of space, planar with a screw (a normal, a pitch)
    dimension 4  Schönflies (a direction): translations of space and turns about parallel axes

A set of joints inside one of them stays inside when joints of the set move; so it does when a joint moves that only
maps the subgroup onto itself, that is one of its normaliser.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rankdrop.local.bracket import bracket
from rankdrop.local.lines import Lines
from rankdrop.local.vectors import cross
from rankdrop.robot.model import Array


@dataclass(frozen=True, slots=True)
class Member:
    """The largest set of joints inside one subgroup.

    Attributes:
        kind: "coaxial", "translational", "cylindrical", "spherical", "planar", "planar with a screw" or "Schönflies".
        dimension: of the subgroup.
        joints: indices from 0 in `Robot.joints`, mimic joints included.
        keepers: all joints, of the set or not, whose motion maps the subgroup onto itself.
    """

    kind: str
    dimension: int
    joints: tuple[int, ...]
    keepers: frozenset[int]


def members(lines: Lines) -> list[Member]:
    """The largest set of joints for every subgroup that two joints at least lie in; a set once, in the smallest."""
    found: dict[tuple[int, ...], Member] = {}
    for member in _all_members(lines):
        known = found.get(member.joints)
        if len(member.joints) > 1 and (known is None or member.dimension < known.dimension):
            found[member.joints] = member
    return list(found.values())


def closure(screws: Array, tolerance: float = 1e-7, most: int = 6) -> Array:
    """Orthonormal basis (d, 6) of the Lie algebra that some twists (N, 6) generate, lengths in one unit.

    Brackets of the basis are added until the dimension stays, or exceeds `most`: then the rest is not looked for.
    Directions below the tolerance are rounding [1].
    """
    basis = _span(screws, tolerance)
    while True:
        if len(basis) > most:
            return basis
        brackets = [bracket(a, b) for a, b in combinations(basis, 2)]
        grown = _span(np.array([*basis, *brackets]), tolerance)
        if len(grown) == len(basis):
            return basis
        basis = grown


def _all_members(lines: Lines) -> Iterator[Member]:
    turns, slides = lines.turns, lines.slides
    straight = [i for i in turns if abs(lines.h[i]) < lines.tolerance * lines.length]
    for i in turns:
        axis = [j for j in turns if lines.one_line(i, j)]
        along = [j for j in slides if lines.parallel(i, j)]
        bundle = [j for j in turns if lines.parallel(i, j)]
        keep_line, keep_direction = axis + along, bundle + slides
        across = [j for j in slides if lines.normal(i, j)]
        pitched = [j for j in bundle if lines.one_pitch(i, j)]
        yield _member("coaxial", 1, [j for j in axis if lines.one_pitch(i, j)], keep_line)
        yield _member("cylindrical", 2, axis + along, keep_line)
        yield _member("planar" if i in straight else "planar with a screw", 3, pitched + across, keep_direction)
        yield _member("Schönflies", 4, keep_direction, keep_direction)
    for i, j in combinations(straight, 2):
        point = lines.meeting_point(i, j)
        if point is not None:
            on = lines.through(point)
            ball = [k for k in straight if on[k]]
            yield _member("spherical", 3, ball, ball)
    yield from _translations(lines)


def _translations(lines: Lines) -> Iterator[Member]:
    turns, slides = lines.turns, lines.slides
    for i in slides:
        keepers = slides + [j for j in turns if lines.parallel(i, j)]
        yield _member("translational", 1, [j for j in slides if lines.parallel(i, j)], keepers)
    for i, j in combinations(slides, 2):
        if not lines.parallel(i, j):
            normal = cross(lines.z[i], lines.z[j]) / lines.cross[i, j]
            plane = [k for k in slides if abs(normal @ lines.z[k]) < lines.tolerance]
            keepers = slides + [k for k in turns if np.linalg.norm(cross(normal, lines.z[k])) < lines.tolerance]
            yield _member("translational", 2, plane, keepers)
    yield _member("translational", 3, slides, turns + slides)


def _member(kind: str, dimension: int, joints: list[int], keepers: list[int]) -> Member:
    return Member(kind, dimension, tuple(sorted(joints)), frozenset(keepers))


def _span(rows: Array, tolerance: float) -> Array:
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    kept = rows[size[:, 0] > tolerance]
    if len(kept) == 0:
        return np.zeros((0, 6))
    _, sigma, vt = np.linalg.svd(kept / np.linalg.norm(kept, axis=1, keepdims=True))
    return np.asarray(vt[: int((sigma > tolerance).sum())])
