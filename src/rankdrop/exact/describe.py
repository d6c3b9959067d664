"""What an exact family is called, what it takes away, and a configuration to show it at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rankdrop.exact.arm.chain import Chain
from rankdrop.family.lost import told
from rankdrop.family.naming import name_family
from rankdrop.local.block import singular_values
from rankdrop.robot.model import Array
from rankdrop.tolerances import DEFAULT
from rankdrop.units import out_of_units

_ROUND = 0.1  # free angles of a witness stand at multiples of this [rad]


@dataclass(frozen=True, slots=True)
class _Pinned:
    number: int


def described(
    chain: Chain, generic_rank: int, corank: int, points: Array, pins: Mapping[int, tuple[str, ...]], coupled: bool
) -> tuple[str, tuple[str, ...], tuple[float, ...]]:
    """(name, sentences on the motions lost, witness) of a family, seen at real points of it.

    Args:
        chain: the arm.
        generic_rank: of the task Jacobian.
        corank: of the family.
        points: (k, n) real configurations of `Chain.own` on it, of exactly this corank; k ≥ 1.
        pins: its pinned joints.
        coupled: whether it has other conditions.
    """
    robot, task = chain.own, chain.own_task
    at = _witness(chain, generic_rank - corank, points, pins)
    name = name_family(robot, task, points, [_Pinned(joint) for joint in sorted(pins)], coupled=coupled)
    _, sentences = told(robot, at, points, task, corank)
    return name, sentences, tuple(float(x) for x in out_of_units(chain.robot, at))


def _witness(chain: Chain, rank: int, points: Array, pins: Mapping[int, tuple[str, ...]]) -> Array:
    """The point whose next singular value is largest, joints on which nothing depends set to 0, free ones rounded."""
    q = np.where(chain.own.periodic, np.pi - np.mod(np.pi - points, 2 * np.pi), points)
    rounded = q.copy()
    for joint in range(chain.n):
        tried = rounded.copy()
        tried[:, joint] = 0.0 if joint in (0, chain.n - 1) else np.round(tried[:, joint] / _ROUND) * _ROUND
        if joint + 1 not in pins and _holds(chain, rank, tried):
            rounded = tried
    sigma = singular_values(chain.own, rounded, chain.own_task)
    best = rounded[int(np.argmax(sigma[:, rank - 1] if rank else sigma[:, 0]))]
    return np.asarray(np.where(np.abs(best) < 1e-15, 0.0, np.round(best, 15)))


def _holds(chain: Chain, rank: int, q: Array) -> bool:
    """Whether every configuration has exactly this rank."""
    sigma = singular_values(chain.own, q, chain.own_task)
    low = sigma[:, rank:].max(axis=1) if rank < sigma.shape[1] else np.zeros(len(q))
    high = sigma[:, rank - 1] if rank else np.ones(len(q))
    return bool((low <= DEFAULT.singular).all() and (high > 1e3 * DEFAULT.singular).all())
