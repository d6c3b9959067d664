"""Joints on one axis: only the sum of their angles matters, and one of them stands for both.

Where the axes of joints i and j are one line at every configuration, singular values depend on θ_i + s θ_j alone, with
s = ±1 as they turn the same way or not. An equation is fitted in one joint less, at θ_j = 0, and written with the sum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rankdrop.family.equation import Equation, Term, normalised
from rankdrop.local.block import singular_values, structural_sample
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

SAMPLES = 8  # configurations at which the sum is tried
SAME = 1e-12  # singular values that differ by less are the same [1]


class Twin(NamedTuple):
    """Joints on one axis, from 0: wherever θ_j occurs it stands in θ_first + sign·θ_second."""

    first: int
    second: int
    sign: int


def twins_of(robot: Robot, task: Task, irrelevant: Sequence[bool]) -> tuple[Twin, ...]:
    """Pairs of turning joints of which only the sum or the difference matters; of three on one axis two pairs.

    Args:
        robot, task: the arm.
        irrelevant: (n,) joints that do not matter at all; they are nobody's twin.
    """
    q = structural_sample(robot, task, SAMPLES)
    sigma = singular_values(robot, q, task)
    joints = [j for j in range(robot.n) if robot.periodic[j] and not irrelevant[j]]
    found: list[Twin] = []
    for place, first in enumerate(joints):
        if any(first == twin.second for twin in found):
            continue
        for second in joints[place + 1 :]:
            for sign in (1, -1):
                moved = q.copy()
                moved[:, first] += 0.7
                moved[:, second] -= sign * 0.7
                if np.abs(singular_values(robot, moved, task) - sigma).max() < SAME:
                    found.append(Twin(first, second, sign))
                    break
    return tuple(found)


def gathered(q: Array, twins: Sequence[Twin]) -> Array:
    """(N, n) the same configurations as far as singular values go, the second of each pair at zero."""
    q = np.array(q)
    for first, second, sign in twins:
        q[:, first] += sign * q[:, second]
        q[:, second] = 0.0
    return q


def gathered_tangent(tangent: Array, twins: Sequence[Twin]) -> Array:
    """(N, n, n) projectors on the tangent space of the part of a family where the second of each pair is at zero.

    A covector that vanishes on the family has c_second = sign·c_first: without that entry it is one of the part.
    """
    if not twins:
        return tangent
    n = tangent.shape[1]
    conormal = np.eye(n) - tangent
    seconds = [twin.second for twin in twins]
    conormal[:, :, seconds] = 0.0
    _, s, vt = np.linalg.svd(conormal)
    inside = (s > 0.1).astype(np.float64)  # a covector keeps at least 1/√3 of its length
    return np.asarray(np.eye(n) - np.einsum("nij,ni,nik->njk", vt, inside, vt))


def spread(equation: Equation, twins: Sequence[Twin]) -> Equation:
    """The equation with θ_first + sign·θ_second in place of θ_first."""
    if not twins:
        return equation
    return normalised([_spread(term, twins) for term in equation.terms])


def _spread(term: Term, twins: Sequence[Twin]) -> Term:
    harmonics = list(term.harmonics)
    for first, second, sign in twins:
        harmonics[second] = sign * harmonics[first]
    return replace(term, harmonics=tuple(harmonics))
