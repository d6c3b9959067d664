"""Several equations at once: values, Jacobian, solutions from any start, and the distance to the common zero set."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.family.equation import Equation, compiled
from rankdrop.robot.model import Array
from rankdrop.solve import CUT

Mask = NDArray[np.bool_]

CLOSE = 1e-8  # steps shorter than this add nothing to a distance [rad]
REACHED = 1e-9  # |f| at a foot: long fitted equations agree with each other to 1e-11
SOLVED = 1e-12  # |f| of a solution, the equations having coefficients of size one

_NOTHING = 1e-15  # |f| that no step can better
_NEAR = 1e-11  # |f|/|∇f| of a zero that Newton has come to rest at [rad]
_ROUNDING = 1e-15  # |f| of a zero whose derivative vanishes, for coefficients that add up to 1


@dataclass(frozen=True)
class System:
    """f_1(q) = … = f_e(q) = 0.

    Attributes:
        equations: the f_i; coefficients of size one.
    """

    equations: tuple[Equation, ...]

    def __reduce__(self) -> tuple[type[System], tuple[tuple[Equation, ...]]]:
        return System, (self.equations,)  # what the core keeps is made anew in another process

    @cached_property
    def compiled(self) -> _core.Families:
        """The equations as the core takes them; there is at least one."""
        return compiled(self.equations)

    @cached_property
    def moves(self) -> Mask:
        """(n,) joints that occur; there is at least one equation."""
        occurs = [(np.abs(m) + p).sum(axis=0) > 0 for m, _, _, _, p in (one.tables for one in self.equations)]
        found = np.asarray(np.logical_or.reduce(occurs))
        found.flags.writeable = False
        return found

    def values(self, q: Array) -> Array:
        """(N, e) values at q (N, n)."""
        return _core.equations(self.compiled, np.ascontiguousarray(q, dtype=np.float64), slopes=False)

    def jacobian(self, q: Array) -> Array:
        """(N, e, n) derivatives at q (N, n)."""
        return self.linear(q)[1]

    def linear(self, q: Array) -> tuple[Array, Array]:
        """(N, e) values and (N, e, n) derivatives at once."""
        return _core.equations(self.compiled, np.ascontiguousarray(q, dtype=np.float64))

    def residuals(self, q: Array) -> tuple[Mask, Array, Array]:
        """As `linear`, for `solve.newton`: no start is ever done before its steps are."""
        return np.ones(len(q), dtype=np.bool_), *self.linear(q)

    def zero(self, q: Array) -> Mask:
        """(N,) whether every equation is zero at q (N, n), to rounding or to first order.

        Where its derivative all but vanishes too, a small value is none: near a place where an equation is zero to the
        fourth order it is below 1e-12 a thousandth of a radian away.
        """
        f, slope = self.linear(q)
        rounding = np.array([_ROUNDING * sum(abs(term.coefficient) for term in one.terms) for one in self.equations])
        return np.asarray((np.abs(f) <= _NEAR * np.linalg.norm(slope, axis=-1) + rounding).all(axis=-1))

    def rank(self, q: Array, tolerance: float = 1e-5) -> NDArray[np.int64]:
        """(N,) rank of the Jacobian: the codimension the equations give, at regular points."""
        if not self.equations:
            return np.zeros(len(q), dtype=np.int64)
        return np.asarray((np.linalg.svd(self.jacobian(q), compute_uv=False) > tolerance).sum(axis=-1))

    def solve(
        self, q: Array, *, along: Array | None = None, iterations: int = 40, step: float = 0.5, still: float = 1e-14
    ) -> tuple[Array, Mask]:
        """Gauss–Newton with the shortest step −A⁺f, capped, from every start.

        Args:
            q: (N, n) starts.
            along: (n, d) orthonormal basis of the directions that may be used; None for all.
            iterations: at most.
            step: longest step [rad].
            still: a start whose step gets shorter has arrived [rad].

        Returns:
            (N, n) end points and (N,) whether |f| ≤ 1e-12 there.
        """
        q = np.array(q, dtype=np.float64)
        if not self.equations or not len(q):
            return q, np.ones(len(q), dtype=np.bool_)
        if along is not None and not along.size:
            return q, np.abs(self.values(q)).max(axis=1) <= SOLVED
        directions = [] if along is None else along.ravel().tolist()
        settings = _core.ZeroSettings(
            iterations=iterations, step=step, still=still, enough=_NOTHING, cut=CUT, along=directions
        )
        end, worst = _core.zeros(self.compiled, np.ascontiguousarray(q, dtype=np.float64), settings)
        return end, worst <= SOLVED

    def nearest(self, q: Array, within: float = 1e-3) -> tuple[Array, Array]:
        """Way from points to the zero set.

        |f|/|∇f| is wrong where ∇f vanishes (two sheets crossing), so the way is walked: Gauss–Newton to the end.

        Args:
            q: (N, n) points.
            within: longest way looked at [rad].

        Returns:
            (N,) length of the way [rad], inf where it is longer or does not get there, and (N, n) the foot.
        """
        length, foot = np.full(len(q), np.inf), np.array(q, dtype=np.float64)
        if not self.equations:
            return np.zeros(len(q)), foot
        near = np.flatnonzero(self._first_order(q) <= 4 * within)
        end, _ = self.solve(q[near], iterations=40, step=within, still=CLOSE)
        there = np.abs(self.values(end)).max(axis=1) <= REACHED
        way = np.linalg.norm(end - q[near], axis=1)
        length[near] = np.where(there & (way <= within), way, np.inf)
        foot[near] = end
        return length, foot

    def _first_order(self, q: Array) -> Array:
        """Largest |f_i|/|∇f_i|, with |f|^½ where the gradient is small: never far above the distance."""
        f, slope = self.linear(q)
        f, slope = np.abs(f), np.linalg.norm(slope, axis=-1)
        return np.asarray(np.minimum(f / np.maximum(slope, 1e-300), np.sqrt(f)).max(axis=1))
