"""The factors of a block as named parts of the arm, each with the motion that is lost there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rankdrop.errors import ConfigurationError
from rankdrop.exact.algebra.atom import Atom
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.signs.signs import simple_pair
from rankdrop.exact.signs.zeros import real_points
from rankdrop.exact.writing.condition import Condition
from rankdrop.family.naming import name_family
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.local.directions import lost_in_sparsest_frame, lost_over_family
from rankdrop.local.sentences import words
from rankdrop.robot.model import Array
from rankdrop.tolerances import DEFAULT
from rankdrop.units import counted_length, out_of_units

POINTS = 8
"""Real configurations at which the geometry of a part is looked at."""
ROLES = ("shoulder", "elbow", "wrist")
_PIN = {"0": "0", "pi": "π", "pi/2": "π/2", "-pi/2": "−π/2"}


@dataclass(frozen=True, slots=True)
class Place:
    """Where a part was looked at.

    Attributes:
        name: as `analyze` names such a family; "" where no configuration is real, or singular of corank 1.
        roles: out of "shoulder", "elbow", "wrist", as the name says.
        points: (N, n) real configurations on the part, those of corank 1 where there are such; of `Chain.own`.
        lost: one sentence on each direction lost, in a frame where it stands still or at the first point.
    """

    name: str
    roles: tuple[str, ...]
    points: Array
    lost: tuple[str, ...]


UNSEEN = Place("", (), np.zeros((0, 0)), ())
"""A part that was not looked at, or of which no real configuration was found."""


def merged(atoms: Sequence[Atom]) -> tuple[tuple[Atom, ...], ...]:
    """Atoms one by one, but θ = 0 with θ = π, and π/2 with −π/2, of one joint together."""
    groups: list[tuple[Atom, ...]] = []
    for atom in atoms:
        pair = next((group for group in groups if simple_pair((*group, atom))), None)
        if pair is None:
            groups.append((atom,))
        else:
            groups[groups.index(pair)] = (*pair, atom)
    return tuple(groups)


def condition_text(ring: Ring, atoms: Sequence[Atom]) -> str:
    """When the atoms hold: "θ3 = 0 or π", or a polynomial = 0."""
    if atoms[0].pinned:
        return f"θ{atoms[0].joint} = {' or '.join(_PIN[atom.value] for atom in atoms)}"
    return Condition(ring, atoms[0].f).text()


def look(chain: Chain, atoms: Sequence[Atom]) -> Place:
    """Name a part by the geometry of real configurations on it, and say what is lost there.

    Names and lost directions are seen at `POINTS` random configurations; they are not proofs.
    """
    robot, task = chain.own, chain.own_task
    points = real_points(chain, atoms, POINTS)
    if not len(points):
        return UNSEEN
    rank = generic_rank(robot, task)
    sigma = singular_values(robot, points, task)
    simple = (sigma[:, rank - 1] <= DEFAULT.singular) & (rank == 1 or sigma[:, max(rank - 2, 0)] > DEFAULT.explained)
    if not simple.any():  # the part lies in a family of higher corank
        return Place("", (), points, ())
    points = points[simple]
    try:
        name = name_family(robot, task, points)
    except ConfigurationError:
        name = ""
    head, colon, _ = name.partition(":")
    roles = tuple(role for role in ROLES if colon and role in head)
    return Place(name, roles, points, _lost(chain, points))


def _lost(chain: Chain, points: Array) -> tuple[str, ...]:
    robot, task = chain.own, chain.own_task
    still = lost_over_family(robot, points, task, 1)
    found = still or lost_in_sparsest_frame(robot, points[0], task, 1)
    at = out_of_units(chain.robot, points[0])
    where = "" if still else f" at q = ({', '.join(f'{x:.4g}' for x in at)})"
    length = counted_length(robot)
    return tuple(words(direction, found.name, length) + where for direction in np.asarray(found.directions))
