"""Points that no row explains: nothing is hidden, each kind of them becomes a family without a name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.linear import Linear
from rankdrop.families.sampling import Setting
from rankdrop.families.signature import Inspection
from rankdrop.family.system import Mask
from rankdrop.robot.model import Array

VALUES = 12  # values of a pinned joint that are listed at most
SMALL = 0.5  # a group with less than this share of another's points is small beside it
Joints = tuple[int, ...]
Shape = tuple[bool, int, Joints, Joints, Joints]
"""Regular or not; rank of D; joints pinned, free, coupled."""


@dataclass(frozen=True, eq=False)
class Leftover:
    """Unexplained points whose tangent has one shape.

    Attributes:
        q: (N, n) the points, those of the cloud first.
        cloud, fresh: how many come from the cloud and from the fresh points.
        dimension: n − rank D; an upper bound where the points are irregular.
        pinned, free, coupled: joints from 0, as the tangent has them.
        witness: (n,) the point farthest from a higher corank.
        evidence: one sentence.
    """

    q: Array
    cloud: int
    fresh: int
    dimension: int
    pinned: tuple[int, ...]
    free: tuple[int, ...]
    coupled: tuple[int, ...]
    witness: Array
    evidence: str

    def values(self, setting: Setting, joint: int) -> tuple[float, ...]:
        """Different values of a joint over the points, at most twelve."""
        linear = Linear.of(setting.robot, [tuple(int(i == joint) for i in range(self.q.shape[1]))])
        found = linear.combinations(self.q, np.ones(len(self.q)), 1e-5)
        return tuple(sorted(values[0] for values in found)[:VALUES])


def leftovers(
    setting: Setting, cloud: Inspection, left_cloud: Mask, fresh: Inspection, left_fresh: Mask
) -> list[Leftover]:
    """Group the points of exactly this corank that are left, largest group first.

    Args:
        setting: arm, task, corank.
        cloud, fresh: the two clouds.
        left_cloud, left_fresh: (N,) points that no row explains.
    """
    q = np.concatenate([cloud.q[left_cloud & cloud.exact], fresh.q[left_fresh & fresh.exact]])
    from_cloud = int((left_cloud & cloud.exact).sum())
    if not len(q):
        return []
    inspection = setting.inspect(q)
    groups: dict[Shape, list[int]] = {}
    for i, signature in enumerate(inspection.signatures):
        key = (
            (True, signature.rank, signature.pinned, signature.free, signature.coupled)
            if signature is not None
            else _shape(inspection, i, setting)
        )
        groups.setdefault(key, []).append(i)
    ordered = sorted(_joined(groups).items(), key=lambda item: (-len(item[1]), item[1][0]))
    return [_leftover(setting, inspection, key, np.array(members), from_cloud) for key, members in ordered]


def _joined(groups: dict[Shape, list[int]]) -> dict[Shape, list[int]]:
    """Put groups with the same pinned joints together where one is small beside the other.

    Near a degenerate geometry (offsets of a fraction of a millimetre) tangents of one set come in many shapes. What is
    coupled in one of them is coupled; the larger dimension is the bound.
    """
    joined: dict[Shape, list[int]] = {}
    for shape, members in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        home = next((s for s in joined if s[2] == shape[2] and len(members) < SMALL * len(joined[s])), None)
        if home is None:
            joined[shape] = list(members)
            continue
        everyone = sorted(joined.pop(home) + members)
        coupled = tuple(sorted({*home[4], *shape[4]}))
        free = tuple(j for j in home[3] if j not in coupled)
        joined[(home[0] and shape[0], min(home[1], shape[1]), home[2], free, coupled)] = everyone
    return joined


def _shape(inspection: Inspection, i: int, setting: Setting) -> Shape:
    """Irregular points are told apart by the dimension of ker D alone; joints that never matter are free."""
    dimension = round(float(np.trace(inspection.tangent[i])))
    n = setting.robot.n
    free = tuple(int(j) for j in np.flatnonzero(setting.irrelevant))
    return (False, n - dimension, (), free, tuple(j for j in range(n) if j not in free))


def _leftover(
    setting: Setting,
    inspection: Inspection,
    key: Shape,
    members: NDArray[np.int64],
    from_cloud: int,
) -> Leftover:
    regular, rank, pinned, free, coupled = key
    cloud = int((members < from_cloud).sum())
    gap = inspection.sigma[members, setting.rank - 1] if setting.rank else np.ones(len(members))
    kind = "" if regular else "; D has no clear rank there, so that the dimension is an upper bound"
    return Leftover(
        q=inspection.q[members],
        cloud=cloud,
        fresh=len(members) - cloud,
        dimension=setting.robot.n - rank,
        pinned=pinned,
        free=free,
        coupled=coupled,
        witness=inspection.q[members[int(np.argmax(gap))]],
        evidence=f"{cloud} points of the cloud and {len(members) - cloud} fresh ones, no condition found{kind}",
    )
