"""Which exact sets have real points, and for which lengths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.exact.algebra.polynomial import Polynomial, coefficients, used
from rankdrop.exact.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.letters import letters_text, sign_of
from rankdrop.exact.writing.condition import RADIANS, Condition
from rankdrop.family.system import System
from rankdrop.local.block import sampling_box, singular_values
from rankdrop.robot.model import Array
from rankdrop.tolerances import DEFAULT

STARTS = 96
"""Random starts from which a real point of a set is looked for."""
_HIGHER = 1e-4  # σ above this: the rank is higher; where sheets cross, σ is small over a long way
_SMOOTH = 5e-7  # singular values of the gradients above this: smooth there; |f| ≤ 1e-15 leaves 1e-7 at a double zero


@dataclass(frozen=True, eq=False)
class Reality:
    """Real points of an irreducible set.

    Attributes:
        points: (k, n) real configurations of `Chain.own` on it, of the rank claimed; none where it is not real.
        smooth: at one of them the gradients have full rank: near it the real set has the dimension claimed.
        proof: why it is not real, where that is proven; "" where none was found only.
        condition: when it is real, in words; "" where that is plain.
        strays: (k, n) real configurations of higher rank that satisfy the conditions of the set, too.
        unclear: at so many more the conditions hold, and the rank is neither lost nor clearly higher: they are near
            points at which conditions touch zero only.
    """

    points: Array
    smooth: bool
    proof: str
    condition: str
    strays: Array
    unclear: int = 0

    @property
    def real(self) -> bool:
        """Whether real points of the dimension claimed were found."""
        return self.smooth and len(self.points) > 0


def reality(chain: Chain, piece: ZeroSet, rank: int, rng: np.random.Generator) -> Reality:
    """Look for real points on a set, with the arm's own lengths.

    Args:
        chain: the arm.
        piece: irreducible set.
        rank: of the task Jacobian almost everywhere on it.
        rng: source of starts.
    """
    n = chain.n
    words: list[str] = []
    for f in piece.equations:
        found = _discriminant(piece, f)
        if found is None:
            continue
        text = letters_text(chain.ring, found)
        if sign_of(chain, found) < 0:
            none = np.empty((0, n))
            return Reality(none, False, f"{text} ≥ 0 does not hold", text, none)
        if text and not _always(chain, found):
            words.append(f"{text} ≥ 0")
    points, smooth, strays, unclear = _met(chain, piece, rank, rng)
    condition = "real if and only if " + " and ".join(words) if words else ""
    return Reality(points, smooth, "", condition, strays, unclear)


def real_points(chain: Chain, piece: ZeroSet, rank: int, rng: np.random.Generator) -> tuple[Array, bool, Array]:
    """(k, n) real configurations of `Chain.own` on a set with exactly its rank, whether the set is smooth at one of
    them, and those of higher rank that satisfy its conditions.
    """
    return _met(chain, piece, rank, rng)[:3]


def _met(chain: Chain, piece: ZeroSet, rank: int, rng: np.random.Generator) -> tuple[Array, bool, Array, int]:
    """`real_points`, and at how many more its conditions hold and the rank is neither lost nor clearly higher."""
    n = chain.n
    theta = rng.uniform(-np.pi, np.pi, (STARTS, n))
    low, high = sampling_box(chain.own, chain.own_task, limits=False)
    for j in chain.ring.prismatic:  # of their travel
        theta[:, j - 1] = low[j - 1] + (high[j - 1] - low[j - 1]) * (theta[:, j - 1] + np.pi) / (2 * np.pi)
    pinned = list(piece.pins)
    for j, value in piece.pins.items():
        theta[:, j - 1] = RADIANS[value]
    q = theta - chain.shifts
    shifts = chain.shifts.tolist()
    equations = tuple(
        Condition(chain.ring, chain.own_polynomial(f)).equation(chain.own_numbers, n, shifts) for f in piece.equations
    )
    system = System(equations)
    moving = np.delete(np.eye(n), [j - 1 for j in pinned], axis=1)
    good = np.ones(STARTS, dtype=np.bool_)
    if equations:
        q, good = system.solve(q, along=moving, iterations=60)
    sigma = singular_values(chain.own, q, chain.own_task)
    full = sigma[:, rank] if rank < sigma.shape[1] else np.zeros(STARTS)
    strays = q[good & (full > _HIGHER)]
    unclear = int((good & (full > DEFAULT.singular) & (full <= _HIGHER)).sum())
    good &= full <= DEFAULT.singular
    good &= (sigma[:, rank - 1] > 1e3 * DEFAULT.singular) if rank else True
    q = q[good]
    if not equations or not len(q):
        return q, len(q) > 0, strays, unclear
    smooth = full_rank(system.jacobian(q) @ moving, piece.codimension - len(pinned))
    return (q[smooth], True, strays, unclear) if smooth.any() else (q, False, strays, unclear)


def full_rank(gradients: Array, wanted: int) -> NDArray[np.bool_]:
    """(k,) whether gradients (k, conditions, joints) of rank `wanted` are more than what rounding leaves of none."""
    return np.asarray((np.linalg.svd(gradients, compute_uv=False) > _SMOOTH).sum(axis=1) >= wanted)


def _discriminant(piece: ZeroSet, f: Polynomial) -> Polynomial | None:
    """b² − 4ac of a condition on one angle alone; None for another one."""
    ring = piece.ring
    places = [place for place in used(f) if place < ring.moving]
    if len(places) != 1 or f.degrees()[places[0]] != 2:
        return None
    c, b, a = coefficients(f, places[0])
    return b * b - 4 * a * c


def _always(chain: Chain, f: Polynomial) -> bool:
    """Whether f ≥ 0 for a plain reason: a number, a sum of squares times positive numbers."""
    return all(value > 0 and not any(e % 2 for e in powers) for powers, value in f.terms())
