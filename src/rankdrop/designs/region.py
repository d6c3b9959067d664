"""σ over a region of the workspace: the smallest, over its poses, of the σ of the best posture, between proven bounds.

    W = min over poses x of the region of  s(x),      s(x) = max over postures q that reach x of σ_r(J(q))

W does not depend on a seed. Random choices decide how narrow the interval is, never whether it holds.

Lower bound: the region is halved into cells. A cell with centre x₀ has a posture q₀ that reaches x₀. With
U₁ᵀ J V₁ = Σ + E, |E| ≤ B over the box q₀ ± |V₁| Y (`rankdrop.cover.setting`), the motion
q̇ = V₁ (Σ + E)⁻¹ U₁ᵀ ξ carries the tool straight from x₀ to any pose of the cell, and stays in the box, if

    (Σ − B) Y > p,     p_i ≥ |u_iᵀ ξ|,   ξ the twist of the straight line

Σ − B is an M-matrix then, and |(Σ + E)⁻¹| ≤ (Σ − B)⁻¹ entry by entry. So every pose of the cell is reached by a posture
in that box, and σ of all of them is at least 1/‖(Σ' − B')⁻¹‖₂ with Σ', B' of the task. The cell of the smallest bound
is halved next. A cell that is not proven has the bound 0.

Upper bound: W ≤ s(x) for any pose x; the worst pose found is taken. s(x) is bounded by branch and bound over all
configurations: a box of joint space is left out where the linear part of the pose error and a bound on its second
derivatives exclude x, or where its σ is at most that of the best posture known,
σ_r(J(q)) ≤ σ_r(J(c)) + ‖J(q) − J(c)‖_F.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rankdrop.cover.ball import coupling_of
from rankdrop.cover.setting import Setting, enclose, regular, setting_at_tip
from rankdrop.designs.postures import CLOSE, EDGE, ROWS_OF_POSITION, Postures, poses_at
from rankdrop.errors import OptionError
from rankdrop.kinematics import jacobian, pose
from rankdrop.problem import Mask, Problem, wrap_joints
from rankdrop.robot import Array, Robot
from rankdrop.task import WORLD_ALIGNED

BUDGET = 5_000
"""Boxes that each of the two bounds may take, up to 1 ms each."""
NARROW = 0.01
"""Bounds that differ by less than this share of the upper one are not improved."""
_KEPT = 3  # postures of a cell
_CELLS, _BOXES = 128, 256  # halved at one time
_THOROUGH = 8  # times the random starts, where no posture or the worst pose was found
_LEVELS = 3  # halvings after which cells have random starts of their own
_AGAIN = 8  # poses at which postures are sought once more, in one round
_TRIED = 8  # starts from boxes that are left
_SAME = 1e-4  # postures closer than this are one [rad, m]
_ROUNDING = 1e-12
_WEAK = 1e-6  # directions that move the pose less are not solved for: no rounding above 1e-10 comes in
_OUTWARDS = 1.0 + 1e-9  # of every bound computed here


@dataclass(frozen=True, slots=True)
class RegionBounds:
    """Proven bounds of the smallest σ of the best posture over a region.

    Attributes:
        lower: W is at least this; 0 where it is not proven that every pose of the region is reached.
        upper: W is at most this; inf where nothing is proven.
        sigma: the smallest σ of a best posture found; the bound itself where the bounds prove that there is a better
            posture, or a worse pose.
        at: (3,) the place of that pose [m].
        q: (n,) that posture [rad, m].
        covered: every pose of the region is proven to be reached.
        spent: a bound ended with its budget, so that the interval is wider than `NARROW`.
        tested: cells and boxes tested.
    """

    lower: float
    upper: float
    sigma: float
    at: Array
    q: Array
    covered: bool
    spent: bool
    tested: int


class _Worst(NamedTuple):
    """A pose and the best posture found there: σ, the place (3,) [m], the posture (n,)."""

    sigma: float
    at: Array
    q: Array


def region_bounds(
    problem: Problem, lower: Array, upper: Array, rpy: Array | None, bounds: tuple[Array, Array, Array], *,
    starts: int, seed: int, budget: int = BUDGET,
) -> RegionBounds:  # fmt: skip
    """Proven bounds of W over a box of the workspace.

    Args:
        problem: the arm, the task of which σ counts, and whether postures have to be inside the joint limits.
        lower, upper: (3,) corners in the base frame [m].
        rpy: orientation of the tool [rad]; None: places alone.
        found: from `reached`, of the poses at which a posture was found, one or more: σ (P,), places (P, 3) [m],
            postures (P, n).
        starts: random starts for a pose.
        seed: of them; the bounds hold for any.
        budget: boxes tested for each bound, at most; 0: none, and nothing is proven.
    """
    first = int(bounds[0].argmin())
    worst = _Worst(float(bounds[0][first]), bounds[1][first], bounds[2][first])
    open_ = RegionBounds(0.0, np.inf, *worst, covered=False, spent=True, tested=0)
    if budget == 0:
        return open_
    try:
        proof = _RegionBounds(problem, rpy, starts, seed)
    except OptionError:  # no enclosure for this task
        return open_
    low, worst, cells, covered = proof.lower(lower, upper, proof.worst_of(*bounds, np.inf) or worst, budget)
    high, worst, boxes = proof.posture_bound(worst, budget)
    narrow = covered and low >= (1.0 - 2.5 * NARROW) * high
    return RegionBounds(low, high, float(np.clip(worst.sigma, low, high)), worst.at, worst.q, covered, not narrow,
                        cells + boxes)  # fmt: skip


class _RegionBounds:
    """Both bounds, for one arm, task and orientation.

    Raises:
        OptionError: the task cannot be certified at the tip, or poses of the region do not determine it.
    """

    def __init__(self, problem: Problem, rpy: Array | None, starts: int, seed: int) -> None:
        self.problem, self.robot, self.rpy, self.starts = problem, problem.robot, rpy, starts
        self.rng = np.random.default_rng([seed, 11])
        self.postures = Postures(problem, oriented=rpy is not None)
        self.aim = self.postures.aim
        wanted = self.postures.wanted
        self.reach = setting_at_tip(self.robot, wanted)
        self.task = setting_at_tip(self.robot, problem.task)
        linear = {row for row in wanted.rows if row < ROWS_OF_POSITION}
        if self.reach.rank != wanted.m or not linear or (self.aim.with_tip and len(linear) < ROWS_OF_POSITION):
            raise OptionError("the poses of a region do not determine what this task asks for", got=problem.task.name)
        self.moved = np.array([self.aim.with_tip or row in linear for row in range(ROWS_OF_POSITION)])
        self.upright = {3, 4, 5} <= set(wanted.rows)  # the tool does not turn on its way
        self.coupling = coupling_of(self.robot)
        self.turning = np.array([not joint.slides for joint in self.robot.joints])

    # The lower bound

    def lower(self, lower: Array, upper: Array, worst: _Worst, budget: int) -> tuple[float, _Worst, int, bool]:
        """Bound from below, the worst pose found on the way, cells tested, and whether every pose is reached."""
        cells = _Cells((lower + upper)[None] / 2, ((upper - lower) / 2 * self.moved)[None], np.zeros(1),
                       np.zeros((1, _KEPT, self.robot.n)), np.zeros(1, dtype=np.intp))  # fmt: skip
        begun, tested, chosen = False, 0, np.arange(1)
        while True:
            if begun:
                enough = (1.0 - NARROW) * worst.sigma
                open_ = np.flatnonzero(cells.bound < enough)
                most = min(_CELLS, (budget - tested) // 2)
                if not len(open_) or most < 1 or not cells.half.any():
                    break
                lowest = open_[np.argsort(cells.bound[open_], kind="stable")[:most]]
                cells = _halve_cells(cells, lowest)
                chosen = np.arange(len(cells.bound) - 2 * len(lowest), len(cells.bound))
            places = cells.centre[chosen]
            known = cells.postures[chosen] if begun else None
            q, sigma = self.postures_at(places, known, cells.depth[chosen])
            begun, tested = True, tested + len(chosen)
            if not np.isfinite(sigma[:, 0]).all():
                return 0.0, worst, tested, False  # a pose for which no posture is found
            worst = self.worst_of(sigma[:, 0], places, q[:, 0], (1.0 - NARROW / 4) * worst.sigma) or worst
            new = cells.bound[chosen]
            for k in range(_KEPT):  # no posture proves more than its own σ
                rows = np.flatnonzero((sigma[:, k] > new) & (new < (1.0 - NARROW) * worst.sigma))
                if len(rows):
                    new[rows] = np.maximum(new[rows], self.proven(places[rows], q[rows, k], cells.half[chosen[rows]]))
            cells.bound[chosen], cells.postures[chosen] = new, q
        return float(cells.bound.min()), worst, tested, bool((cells.bound > 0.0).all())

    def worst_of(self, sigma: Array, places: Array, q: Array, below: float) -> _Worst | None:
        """The pose with the smallest σ (P,) of the best posture, sought once more there; None: none is much below."""
        best: dict[int, _Worst] = {}
        sigma = sigma.copy()
        for _ in range(_AGAIN):
            i = int(sigma.argmin())
            if i in best or not sigma[i] < below:
                break
            best[i] = self.sought_again(_Worst(float(sigma[i]), places[i], q[i]))
            sigma[i] = best[i].sigma
        least = min(best.values(), key=lambda posture: posture.sigma, default=None)
        if least is not None and least.sigma < below:
            return least
        return None

    def sought_again(self, posture: _Worst) -> _Worst:
        """The best posture at a pose, by more starts."""
        goal = poses_at(posture.at[None], self.rpy)
        q, sigma = self.postures.sought(goal, _THOROUGH * self.starts, int(self.rng.integers(2**31)))
        q = np.concatenate([q, posture.q[None, None]], axis=1)
        sigma = np.concatenate([sigma, [[posture.sigma]]], axis=1)
        q, sigma = _different(self.robot, q, sigma)
        for _ in range(2):
            q, sigma = self.postures.climb(goal, q, sigma, self.rng)
        best = int(sigma[0].argmax())
        return posture._replace(sigma=float(sigma[0, best]), q=q[0, best])

    def postures_at(self, places: Array, known: Array | None, depth: NDArray[np.intp]) -> tuple[Array, Array]:
        """(P, K, n) different postures at the poses, and (P, K) their σ, the largest first; −inf: there are no more.

        Args:
            places: (P, 3) of the poses [m].
            known: (P, K, n) postures of poses near them.
            depth: (P,) halvings of their cells: there are random starts too for the first few, and where none is known.
        """
        goals = poses_at(places, self.rpy)
        count, n = len(goals), self.robot.n
        q, sigma = np.zeros((count, 0, n)), np.zeros((count, 0))
        if known is not None:
            flat, value = self.postures.solve(np.repeat(goals, _KEPT, axis=0), known.reshape(-1, n))
            q, sigma = flat.reshape(count, -1, n), value.reshape(count, -1)
        for times, deepest in ((1, _LEVELS), (_THOROUGH, -1)):
            rows = np.flatnonzero((depth <= deepest) | ~np.isfinite(sigma.max(axis=1, initial=-np.inf)))
            wide = np.full((count, times * self.starts), -np.inf)
            wider = np.zeros((*wide.shape, n))
            if len(rows):
                seed = int(self.rng.integers(2**31))
                wider[rows], wide[rows] = self.postures.sought(goals[rows], times * self.starts, seed)
                q, sigma = np.concatenate([q, wider], axis=1), np.concatenate([sigma, wide], axis=1)
        q, sigma = _different(self.robot, q, sigma)
        q, sigma = self.postures.climb(goals, q, sigma, self.rng)
        return _different(self.robot, q, sigma)

    def proven(self, places: Array, q: Array, half: Array) -> Array:
        """(P,) what σ of the best posture is at least at every pose of cells, by the posture q (P, n) at their centres.

        Args:
            places: (P, 3) centres [m].
            q: (P, n) postures there.
            half: (P, 3) half-widths of the cells [m].
        """
        robot, reach, count = self.robot, self.reach, len(q)
        missing = np.linalg.norm(self.aim.error(poses_at(places, self.rpy), q), axis=1)  # lengths by the length scale
        _, _, _, sigma, u, v, _ = enclose(robot, reach, q, np.zeros_like(q))
        lines = u[:, [row < ROWS_OF_POSITION for row in reach.rows]].swapaxes(1, 2)  # (P, r, 3)
        axes_of_tool = pose(robot, q)[:, :3, :3].swapaxes(1, 2)
        straight = (np.abs(lines @ axes_of_tool) @ half[:, :, None])[:, :, 0] / reach.length
        far = np.linalg.norm(half, axis=1)[:, None] / reach.length
        longest = np.linalg.norm(lines, axis=2) * far

        def push(rows: NDArray[np.intp], turned: Array) -> Array:
            """(R, r) bounds of |u_iᵀ ξ| while the tool turns by `turned` (R,) at most."""
            aligned = straight[rows] + turned[:, None] * far[rows]
            return np.asarray(np.minimum(longest[rows], aligned) + missing[rows, None] + _ROUNDING)

        every = np.arange(count)
        y = 1.1 * push(every, np.zeros(count)) / np.maximum(sigma, 1e-300)
        box = np.zeros_like(q)
        done: Mask = np.zeros(count, dtype=np.bool_)
        for _ in range(8):
            rows = np.flatnonzero(~done & np.isfinite(y).all(axis=1) & (y.max(axis=1) < np.pi))
            if not len(rows):
                break
            wide = (np.abs(v[rows]) @ y[rows, :, None])[:, :, 0] * _OUTWARDS
            if self.upright:
                turned = np.zeros(len(rows))
            else:
                turned = wide @ self.coupling.T @ self.turning
            needed = push(rows, turned)
            bound = enclose(robot, reach, q[rows], wide / np.asarray(reach.scale) * _OUTWARDS)[2]
            matrix = -bound
            matrix[:, np.arange(reach.rank), np.arange(reach.rank)] += sigma[rows]
            enough = np.asarray(((matrix @ y[rows, :, None])[:, :, 0] > needed * _OUTWARDS).all(axis=1))
            done[rows[enough]] = True
            box[rows[enough]] = wide[enough]
            larger = _solve_each(matrix, needed)
            positive = np.asarray((larger > 0.0).all(axis=1))  # else no M-matrix: the cell is too wide
            larger = np.where(positive[:, None], larger, np.inf)
            y[rows] = np.where(enough[:, None], y[rows], 1.1 * larger)
        if self.problem.limits:
            inside = (q - box >= robot.lower - EDGE) & (q + box <= robot.upper + EDGE)
            done = np.asarray(done & inside.all(axis=1))
        proven, rows = np.zeros(count), np.flatnonzero(done)
        if len(rows):
            proven[rows] = self._least(q[rows], box[rows])
        return proven

    def _least(self, q: Array, box: Array) -> Array:
        """(P,) σ_r is at least this in boxes q ± box (P, n); 0 where the rank may fall."""
        task = self.task
        _, _, bound, sigma, _, _, _ = enclose(self.robot, task, q, box / np.asarray(task.scale) * _OUTWARDS)
        free = regular(sigma, bound)
        matrix = -bound
        matrix[:, np.arange(task.rank), np.arange(task.rank)] += sigma
        matrix[~free] = np.eye(task.rank)
        size = np.linalg.norm(np.linalg.inv(matrix), ord=2, axis=(1, 2))
        return np.where(free, 1.0 / (size * _OUTWARDS), 0.0)

    # The upper bound

    def posture_bound(self, best: _Worst, budget: int) -> tuple[float, _Worst, int]:
        """What σ of no posture at the pose of `best` exceeds, the best posture known there, and boxes tested."""
        goal = poses_at(best.at[None], self.rpy)[0]
        span = self._span()
        if span is None:
            return np.inf, best, 0
        centre, half, top = span[0][None], span[1][None], np.full(1, np.inf)
        weight, tested = self._weights(), 0
        while True:
            open_ = np.flatnonzero(top > best.sigma * (1.0 + NARROW))
            most = min(_BOXES, (budget - tested) // 2)
            if not len(open_) or most < 1:
                break
            chosen = open_[np.argsort(-top[open_], kind="stable")[:most]]
            rest = np.setdiff1d(open_, chosen)
            c, h = self._boxes_left(goal, *_split(centre[chosen], half[chosen], weight))
            tested += 2 * len(chosen)
            if len(c):
                value = self._most(c, h)
            else:
                value = np.zeros(0)
            best = self._better(goal, c[np.argsort(-value, kind="stable")[:_TRIED]], best)
            centre, half, top = (np.concatenate([x[rest], new]) for x, new in ((centre, c), (half, h), (top, value)))
        return max(float(top.max(initial=0.0)), best.sigma * (1.0 + NARROW)), best, tested

    def _better(self, goal: Array, starts: Array, best: _Worst) -> _Worst:
        """The best posture at the pose (4, 4), of that known and those found from starts (N, n)."""
        if not len(starts):
            return best
        q, sigma = self.postures.solve(np.repeat(goal[None], len(starts), axis=0), starts)
        k = int(sigma.argmax())
        if sigma[k] > best.sigma:
            return best._replace(sigma=float(sigma[k]), q=q[k])
        return best

    def _span(self) -> tuple[Array, Array] | None:
        """Centre and half-widths (n,) of all configurations; None where a joint without limits has no whole turn."""
        robot, limits = self.robot, self.problem.limits
        low, high = robot.lower.copy(), robot.upper.copy()
        turn = robot.periodic & (~np.isfinite(high - low) | (high - low >= 2 * np.pi) | (not limits))
        low[turn], high[turn] = -np.pi, np.pi
        if not np.isfinite(high - low).all() or (not limits and not robot.periodic.all()):
            return None
        low, high = low - 2 * EDGE * ~turn, high + 2 * EDGE * ~turn
        centre, half = (low + high) / 2, (high - low) / 2
        half[self._idle()] = 0.0
        return centre, half

    def _idle(self) -> NDArray[np.bool_]:
        """(n,) the variables on which neither the place nor σ depends: last joints that turn about the point itself.

        σ of a task with rotations depends on all of them but the last.
        """
        idle = np.zeros(self.robot.n, dtype=np.bool_)
        if self.postures.wanted.rows[-1] >= ROWS_OF_POSITION:
            return idle
        drivers, arm = self.robot.drivers, np.asarray(self.reach.arm)
        if self.task.rows[-1] >= ROWS_OF_POSITION:
            most = 1
        else:
            most = len(drivers)
        for i in range(len(drivers) - 1, len(drivers) - 1 - most, -1):
            joint = self.robot.joints[i]
            if joint.slides or joint.pitch or arm[i] > _ROUNDING * self.reach.length or drivers.count(drivers[i]) > 1:
                break
            idle[drivers[i]] = True
        return idle

    def _weights(self) -> Array:
        """(n,) how much the pose and the Jacobian move with each variable."""
        arm = np.asarray(self.task.arm) / self.task.length + 0.3
        return np.asarray(np.where(self.turning, arm, 1.0 / self.task.length) @ self.coupling)

    def _boxes_left(self, goal: Array, centre: Array, half: Array) -> tuple[Array, Array]:
        """Boxes (M, n) less those of which no configuration reaches the pose, narrowed to what may reach it."""
        for _ in range(3):
            if not len(centre):
                break
            error, slope, rest = self._linear(goal, centre, half)
            inverse = np.linalg.pinv(slope, rcond=_WEAK)
            product = inverse @ slope
            shift = (inverse @ error[:, :, None])[:, :, 0]
            loose = (np.abs(inverse) @ rest[:, :, None])[:, :, 0] * _OUTWARDS + _ROUNDING
            span = (np.abs(slope) @ half[:, :, None])[:, :, 0]
            out = (np.abs(error) > (span + rest) * _OUTWARDS + 10 * CLOSE).any(axis=1)
            # row k: G_kk δ_k = −shift_k − Σ_{l≠k} G_kl δ_l − …, |δ_l| ≤ h_l
            diagonal = np.einsum("mkk->mk", product)
            others = (np.abs(product) @ half[:, :, None])[:, :, 0] - np.abs(diagonal) * half
            safe = np.where(diagonal > 0.1, diagonal, 1.0)
            middle, wide = -shift / safe, (others + loose) * _OUTWARDS / safe + 10 * CLOSE
            low, high = np.maximum(-half, middle - wide), np.minimum(half, middle + wide)
            low, high = np.where(diagonal > 0.1, low, -half), np.where(diagonal > 0.1, high, half)
            out |= (low > high).any(axis=1)
            keep = ~out
            narrower = bool(((high - low)[keep] < 1.4 * half[keep]).any())
            centre, half = (centre + (low + high) / 2)[keep], (high - low)[keep] / 2 * _OUTWARDS
            if not narrower:
                break
        return centre, half

    def _linear(self, goal: Array, centre: Array, half: Array) -> tuple[Array, Array, Array]:
        """What is missing of a pose as a function of the joints, about the centres of boxes (M, n).

        Returns:
            (M, k) the value F at the centre, lengths divided by the length scale; (M, k, n) its slope; (M, k) how far
            F(c + δ) − F(c) − slope δ goes: half of Σ |F_jl| δ_j δ_l, with |F_jl| at most the lever of the later joint.
        """
        robot, length, aim = self.robot, self.reach.length, self.aim
        now = pose(robot, centre)
        whole = jacobian(robot, centre, WORLD_ALIGNED)
        turned = now[:, :3, :3]
        offset = turned @ aim.point
        omega = whole[:, 3:].swapaxes(1, 2)  # (M, n, 3)
        speed = whole[:, :3].swapaxes(1, 2) + np.cross(omega, offset[:, None, :])
        place = now[:, :3, 3] + offset - goal[:3, 3] - goal[:3, :3] @ aim.point
        joints = half @ self.coupling.T
        lever = self._levers(self.reach, centre, half)
        turns = np.where(self.turning, joints, 0.0)
        before = np.cumsum(turns, axis=1) - turns
        bend = (lever * joints * (before + turns / 2)).sum(axis=1)  # ½ Σ_k Σ_l of the later one's lever
        angle = turns.sum(axis=1) ** 2 / 2
        rows = np.flatnonzero(self.moved)
        slope = speed[:, :, rows].swapaxes(1, 2) / length
        parts = [(place[:, rows] / length, slope, np.repeat(bend[:, None], len(rows), 1))]
        for value, vector in self._directions(turned, goal[:3, :3]):
            parts.append((value, np.cross(omega, vector[:, None, :]).swapaxes(1, 2), np.repeat(angle[:, None], 3, 1)))
        error, slope, rest = (np.concatenate(parts_of_kind, axis=1) for parts_of_kind in zip(*parts, strict=True))
        return error, slope, rest * _OUTWARDS + _ROUNDING

    def _directions(self, rotations: Array, goal: Array) -> list[tuple[Array, Array]]:
        """Directions (M, 3) of the tool that the task fixes, each with what it is off; none is left out wrongly.

        Where one heading alone is asked for, none is used.
        """
        turns = [row for row in self.postures.wanted.rows if row >= ROWS_OF_POSITION]
        axes = [0, 1, 2] if len(turns) == 3 else []
        if len(turns) == 2 and self.aim.with_tip and self.aim.free is not None:
            axes = [self.aim.free]
        return [(rotations[:, :, axis] - goal[:, axis], rotations[:, :, axis]) for axis in axes]

    def _levers(self, setting: Setting, centre: Array, half: Array) -> Array:
        """(M, N) how far the point moves for a unit of each joint, at most, in boxes; divided by the length scale."""
        bound = enclose(self.robot, setting, centre, half / np.asarray(setting.scale))[6]
        bound = bound / np.array([abs(joint.multiplier) for joint in self.robot.joints])
        turned = self.turning & (setting.rows[-1] >= ROWS_OF_POSITION)  # √(1 + lever²) is given then
        return np.asarray(np.sqrt(np.maximum(bound**2 - turned, 0.0)) * _OUTWARDS)

    def _most(self, centre: Array, half: Array) -> Array:
        """(M,) σ_r is at most this in boxes.

        The smallest of three: σ_r at the centre and how far the Jacobian can change; ‖J‖_F/√r; and of a square Jacobian
        the length of row r of Σ + E, |E| ≤ B.
        """
        task, robot = self.task, self.robot
        _, _, bound, sigma, _, _, _ = enclose(robot, task, centre, half / np.asarray(task.scale))
        lever = self._levers(task, centre, half)
        if task.rows[-1] >= ROWS_OF_POSITION:
            lever = np.where(self.turning, np.hypot(lever, 1.0), lever)
        joints = half @ self.coupling.T
        turns, slides = np.where(self.turning, joints, 0.0), np.where(self.turning, 0.0, joints) / task.length
        after = turns.sum(axis=1, keepdims=True) - np.cumsum(turns, axis=1)
        moved = slides.sum(axis=1, keepdims=True) - np.cumsum(slides, axis=1)
        last = task.rank - 1
        most = sigma[:, last] + np.linalg.norm((lever * after + moved) @ self.coupling, axis=1)
        most = np.minimum(most, np.linalg.norm(lever @ self.coupling, axis=1) / np.sqrt(task.rank))
        if task.rank == robot.n == len(task.rows):
            row = bound[:, last].copy()
            row[:, last] += sigma[:, last]
            most = np.minimum(most, np.linalg.norm(row, axis=1))
        return np.asarray(most * _OUTWARDS + _ROUNDING)


def _solve_each(matrix: Array, push: Array) -> Array:
    """(P, r) y of matrix y = push; inf where the matrix is singular."""
    flat = np.abs(np.linalg.det(matrix)) <= 1e-300
    safe = np.where((flat | ~np.isfinite(matrix).all(axis=(1, 2)))[:, None, None], np.eye(matrix.shape[1]), matrix)
    y = np.linalg.solve(safe, push[:, :, None])[:, :, 0]
    return np.where(flat[:, None], np.inf, y)


def _different(robot: Robot, q: Array, sigma: Array) -> tuple[Array, Array]:
    """(P, `_KEPT`, n) postures of each row, the largest σ first, equal ones once; −inf where there are fewer."""
    short = max(0, 2 * _KEPT - sigma.shape[1])
    sigma = np.pad(sigma, ((0, 0), (0, short)), constant_values=-np.inf)
    q = np.pad(q, ((0, 0), (0, short), (0, 0)))
    order = np.argsort(-sigma, axis=1, kind="stable")
    sigma, q = np.take_along_axis(sigma, order, axis=1), np.take_along_axis(q, order[:, :, None], axis=1)
    for k in range(1, sigma.shape[1]):
        apart = wrap_joints(robot, q[:, :k] - q[:, k : k + 1])
        sigma[(np.abs(apart).max(axis=2) < _SAME).any(axis=1), k] = -np.inf
    order = np.argsort(-sigma, axis=1, kind="stable")[:, :_KEPT]
    return np.take_along_axis(q, order[:, :, None], axis=1), np.take_along_axis(sigma, order, axis=1)


class _Cells(NamedTuple):
    """Cells of the region: centres and half-widths (C, 3) [m], bounds (C,), postures (C, K, n), halvings (C,)."""

    centre: Array
    half: Array
    bound: Array
    postures: Array
    depth: NDArray[np.intp]


def _halve_cells(cells: _Cells, chosen: NDArray[np.intp]) -> _Cells:
    """Cells with those chosen replaced by their halves, which come last."""
    centre, half = _split(cells.centre[chosen], cells.half[chosen], np.ones(cells.half.shape[1]))
    rest, double = np.setdiff1d(np.arange(len(cells.bound)), chosen), np.tile(chosen, 2)
    return _Cells(
        np.concatenate([cells.centre[rest], centre]), np.concatenate([cells.half[rest], half]),
        np.concatenate([cells.bound[rest], cells.bound[double]]),
        np.concatenate([cells.postures[rest], cells.postures[double]]),
        np.concatenate([cells.depth[rest], cells.depth[double] + 1]),
    )  # fmt: skip


def _split(centre: Array, half: Array, weight: Array) -> tuple[Array, Array]:
    """Boxes (M, d) halved along the side that counts most: all first halves, then all second ones."""
    axis, every = (half * weight).argmax(axis=1), np.arange(len(half))
    smaller = half.copy()
    smaller[every, axis] /= 2
    shift = np.zeros_like(half)
    shift[every, axis] = smaller[every, axis]
    outwards = smaller * _OUTWARDS
    return np.concatenate([centre - shift, centre + shift]), np.concatenate([outwards, outwards])
