"""Checks of exact conditions that know nothing of how they were derived: ranks modulo a prime, and a numeric cloud.

Ranks modulo P come from modular forward kinematics of the exact twists and lengths, never from the polynomials that
conditions are made of. The cloud is searched for with the numeric Jacobian alone.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from rankdrop.exact.algebra.field import P, Point, complete, modulus, rank, residue, trig_evaluator
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.check import Check
from rankdrop.families.searching import search
from rankdrop.family.equation import Equation, normalised
from rankdrop.family.system import System
from rankdrop.family.which import families_at
from rankdrop.local.block import generic_rank
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

ROUNDS = 20
"""The search for a cloud is begun anew so many times at most; less than a tenth of `count` in a round ends it."""
WITHIN = 1e-3
"""Longest way from a point of a cloud to a family that is walked [rad]."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """Singular configurations found numerically.

    Attributes:
        robot, task: of the arm.
        q: (N, n) configurations [rad, m].
        corank: (N,) rank lost at each.
    """

    robot: Robot
    task: Task
    q: Array
    corank: NDArray[np.int64]

    def up_to(self, corank: int) -> Cloud:
        """The configurations that lose no more than so many ranks."""
        kept = self.corank <= corank
        return Cloud(self.robot, self.task, self.q[kept], self.corank[kept])


def random_points(chain: Chain, count: int, seed: int = 0) -> list[Point]:
    """Points of the whole joint space modulo P, lengths random too: what almost every arm of this kind does.

    Args:
        chain: the arm.
        count: how many.
        seed: of the points.
    """
    rng = random.Random(seed)
    found: list[Point] = []
    while len(found) < count:
        point = complete(chain.ring, {name: rng.randrange(1, P) for name in chain.ring.names}, {})
        if point is not None:
            found.append(point)
    return found


def rank_modulo(chain: Chain, point: Point) -> int:
    """Rank of the task Jacobian at a point modulo P.

    For all six rows by forward kinematics of residues along the chain, from the first axis on; the symbolic screws are
    not used. A task of some rows only speaks of the tip, and of the axes of the base or of the tip: its rank is that
    of the values of `Chain.columns`.

    Args:
        chain: the arm.
        point: sines, cosines, slides and letters modulo P, as from `Variety.point` or `random_points`.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> chain = exact_chain(open_robot("pa10"))
        >>> rank_modulo(chain, random_points(chain, 1)[0])
        6
    """
    if chain.task.m == 6:
        return rank(_twists(chain, point), modulus(point))
    evaluate = trig_evaluator(chain.ring)
    return rank([[evaluate(entry, point) for entry in column] for column in chain.columns], modulus(point))


def rank_check(chain: Chain, points: Iterable[Point]) -> tuple[int, ...]:
    """`rank_modulo` at each of the points."""
    return tuple(rank_modulo(chain, point) for point in points)


def rank_agreement(chain: Chain, points: Iterable[Point], claimed: int) -> Check:
    """At how many of the points, one or more of every piece of a family, the rank is exactly as claimed."""
    ranks = rank_check(chain, points)
    return Check(len(ranks), sum(found == claimed for found in ranks))


def cloud(robot: Robot, task: Task, corank: int, count: int, seed: int = 0, seconds: float = inf) -> Cloud:
    """Singular configurations of one corank and of every higher one, found from random starts.

    Args:
        robot: the arm.
        task: from `resolve_task`.
        corank: k ≥ 1.
        count: configurations of exactly this corank at least, where the search finds as many; of each higher corank
            a tenth of that is looked for.
        seed: of the starts.
        seconds: no search is begun after these.

    Returns:
        Cloud, polished as `search` does; empty where nothing was found, which proves nothing.

    Raises:
        OptionError: no such corank for this arm and task.
    """
    generic, end = generic_rank(robot, task), monotonic() + seconds
    parts: list[Array] = [np.zeros((0, robot.n))]
    coranks: list[NDArray[np.int64]] = [np.zeros(0, dtype=np.int64)]
    for wanted in range(corank, generic + 1):
        enough = count if wanted == corank else max(count // 10, 1)
        found, lost = 0, 0
        for part in range(ROUNDS):
            run = search(robot, wanted, task=task, starts=enough, seed=seed + 1000 * wanted + part)
            if not run.complete:
                raise KeyboardInterrupt  # the core met Ctrl-C and handed over what it had
            kept = run.outcome == 0
            parts.append(run.converged)
            coranks.append(generic - (run.sigma[kept][:, :generic] > run.tolerances.singular).sum(axis=1))
            new = int((coranks[-1] == wanted).sum())
            found, lost = found + new, lost + int(kept.sum())
            if found >= enough or new < enough / 10 or monotonic() > end:
                break
        if not lost or monotonic() > end:
            break
    return Cloud(robot, task, np.concatenate(parts), np.concatenate(coranks))


def explained(
    points: Cloud, families: Sequence[Sequence[Equation]], tolerances: Tolerances = DEFAULT
) -> tuple[Check, NDArray[np.int64]]:
    """How many points of a cloud lie on one of the families, each given by all of its equations.

    A point lies on a family when the way to its zero set, walked by Gauss–Newton, is at most `explained`; where sheets
    cross, also when σ stays zero on the whole way (`families_at`).

    Args:
        points: from `cloud`.
        families: the equations of each family, all of which hold on it; a family without equations holds everywhere.
        tolerances: `explained` and `singular`.

    Returns:
        (Check, (L,) indices of the points left over).
    """
    systems = [System(tuple(normalised(equation.terms) for equation in family)) for family in families]
    left = np.arange(len(points.q))
    for system in systems:
        way, _ = system.nearest(points.q[left], WITHIN)
        left = left[way > tolerances.explained]
        if not len(left):
            break
    crossing = [_Given(system.equations) for system in systems]
    over = [i for i in left if not families_at(crossing, points.robot, points.q[i], points.task, tolerances)]
    return Check(len(points.q), len(points.q) - len(over)), np.array(over, dtype=np.int64)


@dataclass(frozen=True)
class _Given:
    """Equations as `families_at` reads a family; the rank lost at a point is at least 1, which is all that is asked."""

    equations: tuple[Equation, ...]
    name: str = ""
    corank: int = 1
    dimension: int = 0


def _twists(chain: Chain, point: Point) -> list[list[int]]:
    """Joint screws (v; ω) in the frame before joint 1, as residues: v = p × z for a point p of the axis z."""
    prime = modulus(point)
    turned = [[int(i == j) for j in range(3)] for i in range(3)]
    place = [0, 0, 0]
    found = []
    for number, section in enumerate(chain.sections, 1):
        z = [row[2] for row in turned]
        cosine, sine = residue(section.phase.cos, prime), residue(section.phase.sin, prime)
        d = _length(chain, number - 1, "d", point)
        if section.kind is JointKind.PRISMATIC:
            d += point[f"q{number}"]
            found.append([*z, 0, 0, 0])
        else:
            moment = [(place[i - 2] * z[i - 1] - place[i - 1] * z[i - 2]) % prime for i in range(3)]
            found.append([*moment, *z])
            c, s = point[f"c{number}"], point[f"s{number}"]
            cosine, sine = c * cosine - s * sine, s * cosine + c * sine
        turned = _times(turned, [[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]], prime)
        a = _length(chain, number - 1, "a", point)
        place = [(place[i] + d * z[i] + a * turned[i][0]) % prime for i in range(3)]
        cosine, sine = residue(section.twist.cos, prime), residue(section.twist.sin, prime)
        turned = _times(turned, [[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]], prime)
    return found


def _length(chain: Chain, place: int, which: str, point: Point) -> int:
    if (place, which) in chain.written:
        sign, letter = chain.written[place, which]
        return sign * point[letter]
    return residue(getattr(chain.sections[place], which), modulus(point))


def _times(one: list[list[int]], two: list[list[int]], prime: int) -> list[list[int]]:
    return [[sum(one[i][k] * two[k][j] for k in range(3)) % prime for j in range(3)] for i in range(3)]
