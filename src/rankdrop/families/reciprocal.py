"""Exact singular configurations without a search: joints at which a wrench does no work on any joint.

An arm is singular exactly where some wrench u ≠ 0 of the task is reciprocal to all its screws, u · S_i = 0, of corank
k where k independent ones are. Three ways to begin, each a *stratum*, and every one of them is drawn from:

- joints a … b: the values between them are drawn, so that their screws are known in a link among them, and u is drawn
  from the wrenches reciprocal to these. Then each next joint outwards is solved for by itself:

      u · S_i(q) = A cos q + B sin q + C = 0        (a slide: linear)

  Where A = B = C = 0 a joint is free, and is drawn. Random wrenches never have that; those reciprocal to a longer
  block, as all joints of a spherical wrist, do, and families as shoulder and elbow are found there.
- joint p alone: all the others are drawn, and the zeros of the determinant (of a redundant arm, of two of its minors
  combined) as a function of q_p are solved for: a trigonometric polynomial of low degree. Families that pin p.
- joints p, q … together (and a slide alone; of a higher corank, joints alone too): all the others are drawn, these
  begin anywhere, and U₂ᵀ J V₂ = 0 (`rankdrop.local.block`) is solved by Newton's method in these joints alone. A family
  of codimension c is, almost everywhere, a graph over all joints but some c: every family is met by a stratum of as
  many joints as it has conditions, if enough are drawn.
- joint p at 0, ±π/2 or π, the others by Newton's method together, each step the shortest: families of many conditions
  have few starts that lead to them, and hardly one of them is without such a joint.

The first two are of corank 1 (or more), of joints each for itself that turn or slide, of arms that fill their task,
and in closed form. Every configuration is looked at once more: σ_r is at most `EXACT` times σ_1, else it is dropped
and drawn anew.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import OptionError
from rankdrop.kinematics import jacobian, task_jacobian
from rankdrop.lists import flat_map
from rankdrop.local.block import block, sample, sampling_box, singular_values
from rankdrop.problem import Problem, into_one_turn
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.solve import iterate, shortest
from rankdrop.task import Task

EXACT = 1e-13
"""Largest σ_r / σ_1 of a configuration that is given out: some hundred roundings."""
_ZERO = 1e-11  # coefficients of a joint's equation below this leave it free [arms of size one]
_ROUNDS, _BATCH = 200, 16_384  # rounds in which what failed is drawn anew, and how many at one go
_TRIED, _TRIED_TOGETHER = 8192, 256  # draws of a stratum before it is given up
_SETS = 512  # of joints solved for together, at most: those of few joints first
_STEPS, _STEP = 24, 0.5  # of Newton's method, and how long one is at most [arms of size one]
_SIFTED = {5: 0.2, 9: 1e-2, 14: 1e-5}  # after so many steps those whose σ/σ_1 is still larger are given up
_ONE_BATCH = 2048
_DEGREE = 4  # of the trigonometric polynomials, at most
_ON_CIRCLE = 1e-4  # how far a root may be from the unit circle before it is no angle
_ABSENT = 1e-11  # rows of the Jacobian below this share of its size are zero for this arm
_RIGHT_ANGLES = {"0": 0.0, "π": np.pi, "π/2": np.pi / 2, "−π/2": -np.pi / 2}
_MEND = "methods lm, gradient and almarkhi search any arm and task"
_TYPED = "--method lm"

Waves = NDArray[np.complexfloating]
Draw = Callable[[int, np.random.Generator], Array]
"""(count, generator) -> (M, n) candidates, M ≤ count or a few times it."""

_Drawn = tuple[Array, Array, int]
"""(N, n) configurations, (N, min(m, n)) their singular values, and the number of their stratum."""


def draw_singular(
    problem: Problem, count: int, seed: int, progress: Callable[[int, int], None] | None = None
) -> tuple[Array, Array, NDArray[np.int32], tuple[str, ...], bool]:
    """Draw exact singular configurations, the same number from every stratum that has any.

    Args:
        problem: the arm, of size one (`in_units`), and the corank that they have, or more.
        count: how many.
        seed: of every random choice.
        progress: progress(done, count).

    Returns:
        (N, n) configurations; (N, min(m, n)) their singular values; (N,) which stratum each is from; the strata, by
        what they begin with: "wrenches of joints 4-6", "joint 3 alone", "joints 2, 5 together", "joint 4 at 0"; and
        whether as many were drawn as were asked for, or there are no more: False after Ctrl-C.

    Raises:
        OptionError: no stratum that has a singular configuration.
    """
    robot, task = problem.robot, problem.task
    arm = _ScrewArm(robot, task, problem.limits)
    strata = _strata(arm, problem)
    parts: list[_Drawn] = [(np.zeros((0, robot.n)), np.zeros((0, min(task.m, robot.n))), 0)]
    complete, have = True, 0
    try:
        for part in _in_turn(arm, strata, problem.rank + 1, count, seed):
            parts.append(part)
            have += len(part[0])
            if progress is not None:
                progress(min(have, count), count)
    except KeyboardInterrupt:
        complete = False
    if not have and complete:
        raise OptionError(
            "no reciprocal wrench was found: there may be no singular configuration of this corank, or hardly any",
            where="method", got="reciprocal", mend=_MEND, typed=_TYPED,
        )  # fmt: skip
    q, sigma, stratum = _interleave(parts, count)
    names = tuple(wrench_set.name for wrench_set in strata) if have else ()
    return q, sigma, stratum, names, complete


@dataclass(frozen=True)
class _Sampler:
    """A way to draw singular configurations.

    Attributes:
        name: what it begins with: "wrenches of joints 4-6".
        draw: draws candidates.
        patience: draws without a singular configuration before it is given up.
    """

    name: str
    draw: Draw
    patience: int


def _strata(arm: _ScrewArm, problem: Problem) -> list[_Sampler]:
    """Strata of an arm: in closed form where its corank is 1 and its joints allow it, then by Newton's method."""
    closed: list[tuple[str, Draw]] = []
    if problem.corank == 1 and _in_closed_form(problem.robot, problem.task, problem.generic_rank):
        closed = [*arm.wrenches(), *arm.single_joints(problem.generic_rank)]
    alone = not closed or problem.corank > 1
    iterated = [*arm.solved_strata(problem.rank, alone=alone), *arm.pinned_strata(problem.rank)]
    return [
        *(_Sampler(name, draw, _TRIED) for name, draw in closed),
        *(_Sampler(name, draw, _TRIED_TOGETHER) for name, draw in iterated),
    ]


def _interleave(parts: Sequence[_Drawn], count: int) -> tuple[Array, Array, NDArray[np.int32]]:
    """The first `count` of all configurations, one stratum after the other, so that a part has all of them."""
    q, sigma = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    stratum = np.concatenate([np.full(len(points), k, dtype=np.int32) for points, _, k in parts])
    turn = np.zeros(len(q), dtype=np.int64)
    for k in np.unique(stratum):
        turn[stratum == k] = np.arange(int((stratum == k).sum()))
    order = np.lexsort((stratum, turn))[:count]
    return q[order], sigma[order], stratum[order]


def _in_turn(
    arm: _ScrewArm, strata: Sequence[_Sampler], rank: int, count: int, seed: int
) -> Iterator[_Drawn]:
    """Configurations of one stratum after the other, with their singular values, until there are enough in all.

    Strata that have none after so many draws as their patience says are given up.
    """
    rng, alive, share = np.random.default_rng(seed), set(range(len(strata))), -(-count // len(strata))
    have, tried = np.zeros((2, len(strata)), dtype=np.int64)
    for _ in range(_ROUNDS):
        waiting = [k for k in sorted(alive) if have[k] < share]
        if not waiting:  # those that have any make up for those that have none
            share *= 2
            waiting = sorted(alive)
        if have.sum() >= count or not waiting:
            break
        for k in waiting:
            rate = (have[k] + 1) / (tried[k] + 2)
            wanted = int(np.clip(1.5 * (share - have[k]) / rate, 64, _BATCH))
            q, sigma = arm.keep_singular(strata[k].draw(wanted, rng), rank, int(share - have[k]))
            have[k] += len(q)
            tried[k] += wanted
            if not have[k] and tried[k] >= strata[k].patience:
                alive.discard(k)
            yield q, sigma, k


def _in_closed_form(robot: Robot, task: Task, rank: int) -> bool:
    """Whether wrenches of the task can be told, and joints solved for one by one.

    Not where a joint follows another or screws, where some wrench is reciprocal to the arm wherever it stands, or
    where the task takes some rows only and their wrenches depend on where the arm stands.
    """
    if any(joint.mimic is not None or joint.kind is JointKind.HELICAL for joint in robot.joints) or rank != task.m:
        return False
    blocks = [block for block in ((0, 1, 2), (3, 4, 5)) if set(block) & set(task.rows)]
    missing = [row for row in flat_map(list, blocks) if row not in task.rows]
    if not missing:
        return True
    full = jacobian(robot, sample(robot, task, 16, seed=5), task.frame)
    return bool(np.abs(full[:, missing]).max() <= _ABSENT * np.abs(full).max())


class _ScrewArm:
    """An arm: its variables, and its screws at q = 0 in base coordinates, linear part first; joints and links from 0.

    Wrenches, and joints solved for one by one, are for arms `_in_closed_form`.
    """

    def __init__(self, robot: Robot, task: Task, limits: bool) -> None:
        self.robot, self.task, self.n = robot, task, robot.n
        self.low, self.high = sampling_box(robot, task, limits=limits)
        self.slides = np.array([joint.kind is JointKind.PRISMATIC for joint in robot.variables])
        # a slide is drawn inside its limits; what is solved for may be a reach beyond them where they do not count
        room = 0.0 if limits else reach(robot)
        self.bound = self.slides | limits
        self.least, self.most = self.low - room * self.slides, self.high + room * self.slides
        self.screws = np.array([joint.screw for joint in robot.joints])
        self.ads = np.array([_ad(screw) for screw in self.screws])
        self.whole = task.rows == (0, 1, 2, 3, 4, 5)
        self.basis = self._basis()

    def draw_at_random(self, count: int, rng: np.random.Generator) -> Array:
        """(count, n) configurations at random."""
        return rng.uniform(self.low, self.high, (count, self.n))

    def keep_singular(self, q: Array, rank: int, most: int) -> tuple[Array, Array]:
        """Those that are singular to rounding, angles in (−π, π]; within the limits where these count."""
        q = into_one_turn(self.robot, q[np.isfinite(q).all(axis=1)])
        q = q[((q >= self.least) & (q <= self.most) | ~self.bound).all(axis=1)]
        if not len(q):
            return q, np.zeros((0, min(self.task.m, self.n)))
        sigma = singular_values(self.robot, q, self.task)
        good = np.flatnonzero(sigma[:, rank - 1] <= EXACT * sigma[:, 0])[:most]
        return q[good], sigma[good]

    def solved_strata(self, kept: int, *, alone: bool) -> list[tuple[str, Draw]]:
        """Strata in which some joints are solved for by Newton's method; those of few joints first.

        As many joints as the rank's fall to `kept` is conditions, (m − r)(n − r) at most, and two at least.

        Args:
            kept: the rank r that is left.
            alone: turning joints alone, too; slides always.
        """
        most = min(max(2, (self.task.m - kept) * (self.n - kept)), max(1, self.n - 1))
        strata: list[tuple[str, Draw]] = []
        for count in range(1, most + 1):
            for joints in combinations(range(self.n), count):
                if (count > 1 or alone or self.slides[joints[0]]) and len(strata) < _SETS:
                    name = f"joints {', '.join(str(j + 1) for j in joints)} together"
                    by_itself = f"joint {joints[0] + 1} alone"
                    strata.append((name if count > 1 else by_itself, self._newton(list(joints), kept)))
        return strata

    def pinned_strata(self, kept: int) -> list[tuple[str, Draw]]:
        """Strata in which a turning joint stands at a multiple of a right angle, and all others are solved for."""
        strata: list[tuple[str, Draw]] = []
        for p in range(self.n):
            others = [j for j in range(self.n) if j != p]
            for name, value in _RIGHT_ANGLES.items():
                if others and not self.slides[p] and (not self.bound[p] or self.low[p] <= value <= self.high[p]):
                    strata.append((f"joint {p + 1} at {name}", self._newton(others, kept, (p, value))))
        return strata

    def _newton(self, joints: list[int], kept: int, pin: tuple[int, float] | None = None) -> Draw:
        def draw(count: int, rng: np.random.Generator) -> Array:
            q = self.draw_at_random(min(count, _ONE_BATCH), rng)
            if pin is not None:
                q[:, pin[0]] = pin[1]
            done = [np.zeros((0, self.n))]
            for step in range(_STEPS):
                solved = block(self.robot, q, self.task, kept)
                share = solved.sigma[:, kept] / solved.sigma[:, 0]
                done.append(q[share <= EXACT])
                left = (share > EXACT) & (share <= _SIFTED.get(step, np.inf))
                q = q[left].copy()
                if not len(q):
                    break
                f, d = solved.f[left].reshape(len(q), -1), solved.d[left][..., joints]
                move = shortest(d.reshape(len(q), -1, len(joints)), f, 1e-9)
                size = np.linalg.norm(move, axis=1, keepdims=True)
                q[:, joints] -= move * np.minimum(1.0, _STEP / np.maximum(size, _STEP))
            return np.concatenate(done)

        return draw


    def _basis(self) -> Array:
        """(6, m) wrenches of the task in the frame of the last link, as it stands at q = 0."""
        frame, joints = self.task.frame, len(self.robot.joints)

        def pose(link: int) -> Array:
            if link == 0:
                return np.eye(4)
            if link in (-1, joints + 1):
                return self.robot.home
            return self.robot.joints[link - 1].frame

        axes, origin = pose(frame.axes)[:3, :3], pose(frame.origin)
        point = origin[:3, :3] @ np.array(frame.point) + origin[:3, 3]
        basis = np.zeros((6, self.task.m))
        for place, row in enumerate(self.task.rows):
            axis = axes[:, row % 3]
            basis[:, place] = np.concatenate([axis, np.cross(point, axis)] if row < 3 else [np.zeros(3), axis])
        return basis

    def wrenches(self) -> list[tuple[str, Draw]]:
        """Strata that begin with the wrenches reciprocal to a block of joints."""
        strata: list[tuple[str, Draw]] = []
        rng = np.random.default_rng(0)
        for first, last in self._blocks():
            link = first + 1 if self.whole else self.n
            known = self._wrenches_on_screws(first, last, link, self.draw_at_random(8, rng))
            null = known.shape[2] - int(np.linalg.matrix_rank(known, tol=1e-9).max())
            if null and last - first < self.n - 1:
                if last > first:
                    name = f"joints {first + 1}-{last + 1}"
                else:
                    name = f"joint {first + 1}"
                strata.append((f"wrenches of {name}", self._from_block(first, last, link, null)))
        return strata

    def _blocks(self) -> Iterator[tuple[int, int]]:
        """First and last joint of the blocks: of six rows two joints or more anywhere, else any up to the last."""
        if self.whole:
            yield from combinations(range(self.n), 2)
        else:
            yield from ((first, self.n - 1) for first in range(self.n))

    def _wrenches_on_screws(self, first: int, last: int, link: int, q: Array) -> Array:
        """(B, joints, m) what the wrenches of the task do on the screws of a block, seen from a link."""
        seen = np.empty((len(q), last - first + 1, 6))
        motion = np.tile(np.eye(6), (len(q), 1, 1))
        for i in range(link, last + 1):
            seen[:, i - first] = motion @ self.screws[i]
            motion = motion @ self._motion(i, q[:, i])
        motion = np.tile(np.eye(6), (len(q), 1, 1))
        for i in range(link - 1, first - 1, -1):
            seen[:, i - first] = motion @ self.screws[i]
            motion = motion @ self._motion(i, -q[:, i])
        if self.whole:
            return seen
        return seen @ self.basis

    def _motion(self, i: int, q: Array) -> Array:
        """(B, 6, 6) Ad(exp(S_i q))."""
        ad = self.ads[i]
        if self.slides[i]:
            with np.errstate(invalid="ignore"):  # NaN where a joint before had no solution
                return np.asarray(np.eye(6) + q[:, None, None] * ad)
        sine, versine = np.sin(q)[:, None, None], 2 * np.sin(q / 2)[:, None, None] ** 2
        return np.asarray(np.eye(6) + sine * ad + versine * (ad @ ad))

    def _from_block(self, first: int, last: int, link: int, null: int) -> Draw:
        def draw(count: int, rng: np.random.Generator) -> Array:
            q = self.draw_at_random(count, rng)
            known = self._wrenches_on_screws(first, last, link, q)
            v = np.linalg.svd(known)[2][:, known.shape[2] - null :]  # (B, null, m)
            u = np.einsum("bk,bkm->bm", rng.standard_normal((count, null)), v)
            u /= np.linalg.norm(u, axis=1, keepdims=True)
            u = u if self.whole else u @ self.basis.T
            for side, sign in (
                (range(link, self.n - 1), 1), (range(min(link, self.n) - 1, 0, -1), -1)
            ):
                left = u
                for i in side:
                    beyond = i + sign
                    if not (first <= i <= last and first <= beyond <= last):
                        q[:, i] = self._solve_joint(left, i, beyond, sign, q[:, i], rng)
                    left = np.einsum("bi,bij->bj", left, self._motion(i, sign * q[:, i]))
            return q

        return draw

    def _solve_joint(self, u: Array, i: int, beyond: int, sign: int, given: Array, rng: np.random.Generator) -> Array:
        """(B,) values of joint i at which u does no work on the joint beyond it; NaN where there are none.

        Args:
            u: (B, 6) the wrench, carried to joint i.
            i, beyond: the joint that is solved for, and the one whose screw it turns.
            sign: 1 outwards, −1 towards the base.
            given: values that a joint takes which is free.
            rng: chooses between two solutions.
        """
        ad, screw = self.ads[i], self.screws[beyond]
        once = sign * (u @ (ad @ screw))
        if self.slides[i]:
            start = u @ screw
            free = (np.abs(once) < _ZERO) & (np.abs(start) < _ZERO)
            with np.errstate(divide="ignore", invalid="ignore"):
                return np.where(free, given, -start / once)
        twice = u @ (ad @ (ad @ screw))
        constant = u @ screw + twice
        size = np.hypot(once, twice)
        free = (size < _ZERO) & (np.abs(constant) < _ZERO)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = constant / size
            share = np.where((np.abs(share) > 1.0) & (np.abs(share) < 1.0 + 1e-14), np.sign(share), share)
            half = np.arccos(np.clip(share, -1.0, 1.0))
            value = np.arctan2(-once, twice) + np.where(rng.random(len(u)) < 0.5, half, -half)
        value = np.where(np.abs(share) <= 1.0, value, np.nan)
        return np.where(free, given, value)

    def single_joints(self, rank: int) -> list[tuple[str, Draw]]:
        """Strata in which one turning joint is solved for."""
        return [(f"joint {p + 1} alone", self._one_joint(p, rank)) for p in range(self.n) if not self.slides[p]]

    def _one_joint(self, p: int, rank: int) -> Draw:
        if self.n == rank:
            mix = np.eye(self.n)
        else:
            mix = np.random.default_rng(p + 1).standard_normal((self.n, rank))

        def draw(count: int, rng: np.random.Generator) -> Array:
            count = min(count, _ONE_BATCH)
            q = self.draw_at_random(count, rng)
            points = 2 * _DEGREE + 1
            angles = 2 * np.pi * np.arange(points) / points
            at = np.repeat(q[:, None, :], points, axis=1)
            at[:, :, p] = angles
            values = np.linalg.det(task_jacobian(self.robot, at.reshape(-1, self.n), self.task) @ mix)
            waves = np.fft.fft(values.reshape(count, points), axis=1) / points
            zeros = []
            for slope in (False, True):  # double zeros of the determinant are simple ones of its derivative
                rows, roots = _zeros(waves, slope)
                singular = q[rows]
                singular[:, p] = roots
                zeros.append(singular)
            return np.concatenate(zeros)

        return draw


def _zeros(waves: Waves, slope: bool) -> tuple[NDArray[np.int64], Array]:
    """(rows, angles) zeros of Σ_k w_k e^{ikq}, or of its derivative; waves (B, 2 d + 1) as `fft` orders them."""
    top = waves.shape[1] // 2
    k = np.concatenate([np.arange(top + 1), np.arange(-top, 0)])
    waves = waves * (1j * k if slope else 1.0)
    sizes = np.abs(waves).max(axis=0)
    largest = float(sizes.max())
    counted = (exponent for exponent, size in zip(k, sizes, strict=True) if size > 1e-12 * largest)
    degree = max((int(abs(exponent)) for exponent in counted), default=0)
    if not degree or not largest:
        return np.zeros(0, np.int64), np.zeros(0)
    rows = np.flatnonzero(np.abs(waves[:, degree]) > 1e-9 * largest)
    order = [*range(-degree, degree + 1)]
    row = waves[rows][:, order]  # coefficients of z^0 … z^2d, z = e^{iq}
    row = row / row[:, -1:]
    size = 2 * degree
    companion = np.zeros((len(rows), size, size), dtype=np.complex128)
    companion[:, np.arange(1, size), np.arange(size - 1)] = 1.0
    companion[:, :, -1] = -row[:, :-1]
    roots = np.linalg.eigvals(companion)
    which, place = np.nonzero(np.abs(np.abs(roots) - 1.0) < _ON_CIRCLE)
    angle = np.angle(roots[which, place])
    numbers = np.arange(-degree, degree + 1)
    coefficients = waves[rows[which]][:, order]

    def step(at: Array, active: NDArray[np.intp]) -> Array:
        """Newton's, of a real variable."""
        waves = coefficients[active] * np.exp(1j * at * numbers)
        value, rate = waves.sum(axis=1).real, (waves * 1j * numbers).sum(axis=1).real
        return np.asarray(-np.divide(value, rate, out=np.zeros_like(rate), where=rate != 0.0)[:, None])

    return rows[which], iterate(step, angle[:, None], iterations=4, longest=1e-3)[:, 0]


def _ad(screw: Array) -> Array:
    """(6, 6) ad_S, linear part first."""
    v, w = (np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]]) for a in (screw[:3], screw[3:]))
    return np.block([[w, v], [np.zeros((3, 3)), w]])
