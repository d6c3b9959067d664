"""Which joints move inside one proper subgroup of the rigid motions.

The connected subgroups, as Lie algebras of twists (all of them up to the choice of axis, point and pitch):

    dimension 1  turns about a line, screws of one pitch along a line, slides along a direction
    dimension 2  cylindrical (a line), translations of a plane
    dimension 3  spherical (a point), planar (a normal), translations of space, planar with a screw (a normal, a pitch)
    dimension 4  Schönflies (a direction): translations of space and turns about parallel axes

A set of joints inside one of them stays inside when joints of the set move, and when a joint moves that maps the
subgroup onto itself: a joint of its normaliser.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from rankdrop.local.axes import Scene, Verdicts, indices, inner_product
from rankdrop.robot.model import Array
from rankdrop.robot.transform import bracket, cross, unit

Subgroup = tuple[str, int, tuple[int, ...], frozenset[int]]
"""Kind and dimension of a subgroup; the joints in it, from 0 in `Robot.joints`, mimic joints included; and its keepers:
all joints, of the set or not, whose motion maps the subgroup onto itself."""


def subgroups(scene: Scene) -> list[Subgroup]:
    """The largest set of joints for every subgroup that two joints at least lie in; a set once, in the smallest.

    The scene has one configuration, and mimic joints as joints of their own.
    """
    smallest: dict[tuple[int, ...], Subgroup] = {}
    for kind, dimension, members, keepers in _every_subgroup(scene):
        joints = indices(members)
        if len(joints) > 1 and (joints not in smallest or dimension < smallest[joints][1]):
            smallest[joints] = kind, dimension, joints, frozenset(indices(keepers))
    return list(smallest.values())


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


def _every_subgroup(scene: Scene) -> Iterator[tuple[str, int, Verdicts, Verdicts]]:
    """Kind, dimension, members and keepers (n,) of every subgroup that an axis, a slide, or two of them choose."""
    slides, turns = scene.slides, ~scene.slides
    parallel, line, square = (pairs[..., 0] for pairs in (scene.parallel, scene.aligned, scene.perpendicular))
    z, zero = scene.z[:, 0], scene.tolerance * scene.length
    pitches = inner_product(scene.screws[0, :3].T, scene.screws[0, 3:].T)  # [m/rad]
    straight = turns & (np.abs(pitches) < zero)
    meet, on = (verdicts[..., 0] for verdicts in scene.crossings)
    for i in indices(turns):
        axis, bundle, pitch = turns & line[i], turns & parallel[i], np.abs(pitches - pitches[i]) < zero
        along = axis | (slides & parallel[i])
        yield "coaxial", 1, axis & pitch, along
        yield "cylindrical", 2, along, along
        if straight[i]:
            kind = "planar"
        else:
            kind = "planar with a screw"
        yield kind, 3, (bundle & pitch) | (slides & square[i]), bundle | slides
        yield "Schönflies", 4, bundle | slides, bundle | slides
    for i, j in combinations(indices(straight), 2):
        if meet[i, j]:
            yield "spherical", 3, on[i, j] & straight, on[i, j] & straight
    for i in indices(slides):
        yield "translational", 1, slides & parallel[i], slides | (turns & parallel[i])
    for i, j in combinations(indices(slides), 2):
        if not parallel[i, j]:
            normal = unit(cross(z[i], z[j]))
            keepers = slides | (turns & scene.small(cross(normal, z)))
            yield "translational", 2, slides & (np.abs(z @ normal) < scene.tolerance), keepers
    yield "translational", 3, slides, turns | slides


def _span(rows: Array, tolerance: float) -> Array:
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    kept = rows[size[:, 0] > tolerance]
    if len(kept) == 0:
        return np.zeros((0, 6))
    _, sigma, vt = np.linalg.svd(kept / np.linalg.norm(kept, axis=1, keepdims=True))
    return np.asarray(vt[: int((sigma > tolerance).sum())])
