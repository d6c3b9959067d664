"""The singular configurations around one of them, sorted by the families through it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.linear import Linear, wrap
from rankdrop.families.sampling import Setting, smooth
from rankdrop.families.searching import refine
from rankdrop.families.signature import Inspection, Signature
from rankdrop.local.block import joint_scale
from rankdrop.robot.model import Array

SIZES = (0.01, 0.05, 0.2, 0.6)  # steps from q [rad, length scales]
EACH = 24  # starts for each size
FEW = 3  # neighbours that make a family
CLOSE = 0.1  # so near the set is its tangent, within a tenth [rad, length scales]
BACK = 3.0  # what comes back farther away than so many steps is another place of the set
HELD = 1e-5  # a value of q and one of the neighbourhood that differ by less are the same [rad, length scales]
Found = list[tuple[Signature, NDArray[np.int64]]]


def neighbourhood(setting: Setting, q: Array, at: Inspection, seed: int) -> Inspection:
    """Singular configurations of exactly this corank around q; the first one is q itself, polished."""
    rng = np.random.default_rng(seed)
    scale = joint_scale(setting.robot, setting.task)
    sizes = np.repeat(SIZES, EACH)
    steps = rng.standard_normal((len(sizes), len(q)))
    tangential = np.arange(len(sizes)) % 2 == 0
    steps[tangential] = steps[tangential] @ at.tangent[0]
    steps *= scale * sizes[:, None] / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-12)
    starts = np.vstack([q, q + steps])
    back = refine(
        setting.robot, starts, setting.corank, task=setting.task, seed=seed, iterations=40, threads=1,
        tolerances=replace(setting.tolerances, target=1e-15),
    )  # fmt: skip
    way = np.where(setting.robot.periodic, wrap(back.q - q), back.q - q)
    near = np.linalg.norm(way / scale, axis=1) <= BACK * np.append(SIZES[0], sizes)
    good = near & (back.sigma[:, setting.rank] <= setting.tolerances.singular)
    good[0] = True
    return setting.inspect(q + way[good])


def conormal_rank(at: Inspection) -> int:
    """Rank of D at the first point: the dimension of the conormal space."""
    return int(at.q.shape[1]) - round(float(np.trace(at.tangent[0])))


def _usual_rank(around: Inspection) -> int:
    """The rank of D at most of the neighbours."""
    ranks = sorted(signature.rank for signature in around.signatures[1:] if signature is not None)
    return ranks[len(ranks) // 2] if ranks else -1


def groups_through(setting: Setting, q: Array, at: Inspection, around: Inspection, seed: int) -> Found:
    """Signatures of the neighbourhood whose linear conditions hold at q, each with its points.

    Where the set is smooth at q there is one family: the signature most neighbours of that rank have. Else every
    signature that is met next to q is a family through it. Groups where ker D is not the tangent space tell nothing.
    """
    groups: dict[Signature, list[int]] = {}
    for i, signature in enumerate(around.signatures):
        if i and signature is not None and signature.rank:
            groups.setdefault(replace(signature, bound=()), []).append(i)
    groups = {signature: _holding(setting, signature, q, around.q, members) for signature, members in groups.items()}
    scale = joint_scale(setting.robot, setting.task)
    far = np.linalg.norm(wrap(around.q - q) / scale, axis=1)
    rng = np.random.default_rng([seed, 3])
    ordered = [
        (signature, np.array(members))
        for signature, members in sorted(groups.items(), key=lambda item: (item[0].rank, -len(item[1]), item[0]))
        if len(members) >= FEW
        and smooth(setting, around, np.array(members), rng)
        and _filled(wrap(around.q[members] - q) / scale, far[members], len(q) - signature.rank)
    ]
    rank = conormal_rank(at)
    if rank == _usual_rank(around):
        alike = [item for item in ordered if item[0].rank == rank]
        return [max(alike, key=lambda item: len(item[1]))] if alike else []
    return [(signature, members) for signature, members in ordered if far[members].min() <= BACK * SIZES[0]]


def _filled(ways: Array, lengths: Array, dimension: int) -> bool:
    """Whether neighbours lie in as many directions from q as ker D has.

    One direction too many in ker D, in which the condition is of second order, is met by none of them: they come back
    to within √σ of the set, a hundredth of their step. Too few neighbours decide nothing.
    """
    near = lengths <= CLOSE
    if near.sum() < dimension + 3:
        return True
    spread = np.linalg.svd(ways[near] / np.maximum(lengths[near, None], 1e-12), compute_uv=False)
    return int((spread > 0.05 * spread[0]).sum()) >= dimension


def _holding(setting: Setting, signature: Signature, q: Array, points: Array, members: list[int]) -> list[int]:
    """Those of the members at which the pinned joints and relations have the same values as at q."""
    linear = Linear.of(setting.robot, signature.covectors(len(q)))
    off = linear.values(points[members]) - linear.values(q[None])
    off = np.where(linear.periodic, wrap(off), off)
    same = np.abs(off).max(axis=1, initial=0.0) <= HELD * max(1.0, setting.task.scale(setting.robot))
    return [members[i] for i in np.flatnonzero(same)]
