"""The nearest point of a family whose joints are coupled:

    minimise ½‖x‖²  subject to  f(q) = 0,   x = (q − q0)/joint scale,

by Newton's method on the conditions x = Aᵀλ, f = 0 (A = ∂f/∂x, with second derivatives) from
many starts at once.
"""

from __future__ import annotations

import numpy as np

from rankdrop.family.record import Family
from rankdrop.family.system import REACHED, System
from rankdrop.robot.model import Array, Robot

STARTS = 24
_RADII = (0.3, 1.0, 2.5)  # of the balls the starts come from [rad]
_ITERATIONS = 25
_STILL = 1e-9  # steps shorter than this change the distance by their square [rad]
_LONGEST = 0.7  # step [rad]
_DIFFERENCE = 1e-5  # of the gradients [rad, or length scales]
_RANK = 1e-7  # singular values of A below this share of the largest are zero
_FLATTEST = 1e-2  # curvatures of the Lagrangian are taken for at least this


class Coupled:
    """The nearest points of one family with coupled joints; the joints it does not depend on stay where they are."""

    def __init__(self, family: Family, robot: Robot, centre: Array, scale: Array, box: Array, seed: int) -> None:
        self.family, self.robot, self.box = family, robot, box
        self.centre = np.clip(centre, box[0], box[1])  # free joints of a q outside the limits go to the limit
        self.system = System(family.equations)
        # on more equations than are independent Newton stays where no residual gets smaller: these are walked alone too
        self.ways = [self.system]
        if 0 < robot.n - family.dimension < len(family.equations):
            self.ways.append(System(family.equations[: robot.n - family.dimension]))
        self.moves = np.zeros(robot.n, dtype=np.bool_)
        for equation in family.equations:
            self.moves[[number - 1 for number in equation.joints]] = True
        self.columns = np.flatnonzero(self.moves)
        self.scale = scale
        self.target = centre
        self.rng = np.random.default_rng(seed)

    def points(self) -> Array:
        """Ends of all starts."""
        starts = self._starts(np.resize(_RADII, STARTS))
        first = np.concatenate([self._walk(starts.copy(), system) for system in self.ways])
        solved = np.abs(self.system.values(first)).max(axis=1) <= REACHED
        distance = np.linalg.norm((first - self.target) / self.scale, axis=1)[solved]
        if not len(distance) or distance.min() == 0:
            return first
        starts = self._starts(np.full(STARTS // 2, 1.25 * distance.min()))
        return np.concatenate([first, *(self._walk(starts.copy(), system) for system in self.ways)])

    def _starts(self, radii: Array) -> Array:
        """The configuration itself, and points in balls around it; pinned joints at any of their values."""
        x = self.rng.standard_normal((len(radii), self.robot.n)) * self.moves
        x *= (radii * self.rng.random(len(radii)) ** (1 / self.moves.sum()) / np.linalg.norm(x, axis=1))[:, None]
        x[0] = 0
        q = self.centre + x * self.scale
        for joint in self.family.pinned:
            j = joint.number - 1
            periodic = bool(self.robot.periodic[j])
            options = nearest_turns(np.array(joint.values), self.centre[j], periodic, self.box[:, j])
            if len(options):
                options = options[np.abs(options - self.centre[j]).argsort()][: len(joint.values)]
                q[:, j] = options[self.rng.integers(len(options), size=len(q))]
        return np.clip(q, self.box[0], self.box[1])

    def _walk(self, q: Array, system: System) -> Array:
        """Newton steps of all starts until they stand still, then straight onto the family."""
        active = np.arange(len(q))
        for _ in range(_ITERATIONS):
            step = self._step(q[active], system)
            length = np.linalg.norm(step, axis=1)
            step *= np.minimum(1.0, _LONGEST / np.maximum(length, 1e-300))[:, None]
            q[active] = np.clip(q[active] + step * self.scale, self.box[0], self.box[1])
            active = active[length > _STILL]
            if not len(active):
                break
        q = self._brought_near(q)
        for _ in range(3):
            f, slopes = self.system.linear(q)
            back = (_inverse(slopes * self.scale)[0] @ f[..., None])[..., 0]
            q = np.clip(q - back * self.scale, self.box[0], self.box[1])
        return q

    def _brought_near(self, q: Array) -> Array:
        turns = np.where(self.robot.periodic, np.round((q - self.target) / (2 * np.pi)), 0.0)
        near = q - 2 * np.pi * turns
        return np.where((near < self.box[0]) | (near > self.box[1]), q, near)

    def _step(self, q: Array, system: System) -> Array:
        """(N, n) Newton's step in scaled variables; joints at a limit that would cross it are held."""
        at = self.columns
        exact = system.quadratic(q)
        if exact is None:
            (f, slopes), hessians = system.linear(q), self._hessians(q, system)
        else:
            f, slopes, second = exact
            hessians = second[:, :, at[:, None], at] * np.outer(self.scale[at], self.scale[at])
        a = slopes[:, :, at] * self.scale[at]
        x = ((q - self.target) / self.scale)[:, at]
        free = np.ones(x.shape, dtype=np.bool_)
        part = _newton(x, f, a, hessians)
        bounded = np.isfinite(self.box[:, at]).any()
        for _ in range(len(at) if bounded else 0):
            low, high = q[:, at] <= self.box[0, at], q[:, at] >= self.box[1, at]
            held = free & ((low & (part < 0)) | (high & (part > 0)))
            if not held.any():
                break
            free &= ~held
            loose = hessians * free[:, None, :, None] * free[:, None, None]
            part = _newton(x * free, f, a * free[:, None], loose) * free
        step = np.zeros_like(q)
        step[:, at] = part
        return step

    def _hessians(self, q: Array, system: System) -> Array:
        """(N, e, c, c) second derivatives by the joints that matter, scaled, from differences of gradients."""
        at = self.columns
        shifts = np.zeros((2, len(at), 1, len(self.scale)))
        shifts[0, np.arange(len(at)), 0, at] = _DIFFERENCE * self.scale[at]
        shifts[1] = -shifts[0]
        slopes = system.jacobian((q + shifts).reshape(-1, len(self.scale)))[:, :, at] * self.scale[at]
        slopes = slopes.reshape(2, len(at), len(q), -1, len(at))
        return np.asarray(np.moveaxis((slopes[0] - slopes[1]) / (2 * _DIFFERENCE), 0, -1))


def _inverse(a: Array) -> tuple[Array, Array]:
    """A⁺ (N, c, e), and the projector A⁺A (N, c, c) on the row space; small singular values are left out."""
    u, s, vt = np.linalg.svd(a, full_matrices=False)
    keep = s > np.maximum(_RANK * s[:, :1], 1e-12)
    v = vt.swapaxes(1, 2) * keep[:, None]
    inverse = (v / np.where(keep, s, 1.0)[:, None]) @ u.swapaxes(1, 2)
    return inverse, v @ v.swapaxes(1, 2)


def _newton(x: Array, f: Array, a: Array, hessians: Array) -> Array:
    """(N, c) the step: −A⁺f across the family, and along it to the nearest point of the quadratic model.

    With λ = (A⁺)ᵀx the Lagrangian ½‖x‖² − λ·f has the second derivative H = 1 − Σ λ_i ∇²f_i. Directions in which it is
    not convex are turned round, so that every step goes down.
    """
    inverse, across = _inverse(a)
    normal = -(inverse @ f[..., None])  # (N, c, 1)
    multipliers = x[:, None] @ inverse  # (N, 1, e)
    one = np.eye(x.shape[1])
    curved = one - (multipliers[:, 0, :, None, None] * hessians).sum(axis=1)
    along = one - across
    size, axes = np.linalg.eigh(along @ curved @ along + across)
    slope = along @ (x[..., None] + curved @ normal)
    tangent = along @ (axes @ ((axes.swapaxes(1, 2) @ slope) / np.maximum(np.abs(size), _FLATTEST)[..., None]))
    return np.asarray((normal - tangent)[..., 0])


def nearest_turns(values: Array, at: float, periodic: bool, bounds: Array) -> Array:
    """Values moved by whole turns to where they are nearest to `at` and inside the bounds."""
    if periodic:
        turns = np.round((at - values) / (2 * np.pi)) + np.arange(-2, 3)[:, None]
        values = (values + 2 * np.pi * turns).ravel()
    rounding = 1e-9  # a limit of 3.14159265359 is meant to allow π
    inside = (values >= bounds[0] - rounding) & (values <= bounds[1] + rounding)
    return np.asarray(values[inside])
