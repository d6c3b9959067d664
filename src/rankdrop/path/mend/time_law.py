"""Tool paths through a singular configuration, and the time law that keeps the joint rates finite (Chevallereau).

A tool path x(s) is tracked by joints q(s) with J q′ = ξ, ξ = dx/ds. At a singularity of corank 1, u the direction lost
and V the kernel of J, take s as one more joint: y = (q, s), [J, −ξ] y′ = 0.

Where u·ξ ≠ 0 the path leaves the image of J. The curve y(σ) is smooth, starts in the kernel, q′ = v, s′ = 0, and

    s(σ) = c_k σ^k + …,    c₂ = u·dJ(v) v / (2 u·ξ).

k odd: the path goes through; k even: it is met on one side only, and the arm comes back on it in another posture. With
the time law s = c_k (ρt)^k, σ = ρt, the path stands still at the singular point, and the joint rates are finite; at
constant path speed they grow as |s|^−(k−1)/k. Joints to spare may come along one direction of the kernel and leave
along another: then the arm has to stop between.

Where u·ξ = 0 the path is tangent to the image, and is tracked at any speed along q′ = q₀ + V μ, J q₀ = ξ, if

    μᵀQμ + 2 b·μ + g = 0,   Q = u·dJ(V) V,   b = ½ u·(dJ(V) q₀ + dJ(q₀) V),   g = u·(dJ(q₀) q₀ − dξ/ds)

has a real solution: orthogonal to the lost direction at first order, and in the image at second.

Source: C. Chevallereau, ICRA 1996 and Int. J. Robotics Research 17 (1998), as quoted by Gallardo-Alvarado and
Rico-Martínez; the orders and the curve are derived here. What is claimed is checked by finite motion: the curve is
followed on the path itself, and rates are those of the joints followed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.codec import Result
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import check_robot, one_configuration, pose, task_jacobian, task_jacobian_derivative
from rankdrop.local.block import generic_rank, joint_scale
from rankdrop.path.check.passing import Turn, internal_turn
from rankdrop.path.read.csv_file import csv_text
from rankdrop.poses.inverse import Aim, check_axes, rotation
from rankdrop.problem import Mask
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.solve import newton
from rankdrop.task import Task, resolve_task
from rankdrop.text import through as text
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

_SPAN = 0.1  # of σ to either side [rad]: four digits of a fifth-order term are left
_TURN_SPAN = 0.1  # of the path after an internal turn [rad; lengths by the length scale]
_POINTS = 12  # on each side
_NOTHING = 1e-7  # coefficients of s(σ), u·ξ and the quadric below this are zero; finite motion leaves 1e-10
_CLOSE = 1e-12
_MOST = 30  # steps of Newton's method


HIGHEST = 6
"""Order that is looked for."""
REGULAR, PASSES, TANGENT, TURNS, CORNER, NOT, UNDECIDED = (
    "regular", "passes", "tangent", "turns back", "corner", "not trackable", "undecided",
)  # fmt: skip
TRACKABLE = (REGULAR, PASSES, TANGENT, CORNER)


@dataclass(frozen=True, eq=False)
class Through(Result):
    """What is known of a tool path at one configuration.

    Attributes:
        robot, task, q: where.
        along: (m,) dx/ds of the path in the rows of the task, in the base's axes [m, rad].
        bend: (m,) d²x/ds².
        kind: `PASSES` (through, standing still for an instant), `TANGENT` (through, at any speed), `CORNER` (through,
            with a stop at which the joints change direction), `TURNS` (only on one side; the arm comes back in another
            posture), `NOT`, `UNDECIDED`, `REGULAR` (not singular).
        order: k of s = c t^k; 1 where any smooth time law will do; None where there is none.
        outside: u·ξ/|ξ|: share of the path's direction that is lost [1].
        side: of s on which the path is tracked where it turns back: +1 or −1; else 0.
        times: (T,) [s] and
        s: (T,) the law that keeps the joint rates finite,
        joints: (T, n) and the configurations [rad, m] that were followed; empty where there are none.
        off: largest deviation of the tool from the path on the way, lengths by the length scale [1].
        rate: largest joint rate under that law [rad/s; slides scaled].
        exponent: measured power of |s| by which joint rates per path speed grow near the singularity; 0 where they do
            not; expected is −(k − 1)/k.
        turn: of a path that is not trackable from here, the internal turn after which it goes on ahead; None where none
            was found within the joint limits, or the path is bent.
    """

    robot: Robot
    task: Task
    q: Array
    along: Array
    bend: Array
    kind: str
    outside: float
    order: int | None = None
    side: int = 0
    times: Array = field(default_factory=partial(np.zeros, 0))
    s: Array = field(default_factory=partial(np.zeros, 0))
    joints: Array = field(default_factory=partial(np.zeros, 0))
    off: float = 0.0
    rate: float = 0.0
    exponent: float = 0.0
    turn: Turn | None = None
    FILE: ClassVar[str] = "through"

    @property
    def trackable(self) -> bool:
        """Whether the path leads through, from one side of the configuration to the other."""
        return self.kind in TRACKABLE

    @property
    def sentence(self) -> str:
        """In words."""
        return text.through_sentence(self, HIGHEST)

    def sections(self, *, deg: bool = False) -> Iterator[Section]:
        """For people: the verdict first and last."""
        return text.through_sections(self, deg=deg)

    def path_csv(self) -> str:
        """The motion with its times as a file that `rankdrop path` reads [s; rad, m]; empty where there is none."""
        names = [joint.name for joint in self.robot.variables]
        if len(self.s):
            return csv_text(names, self.joints, self.times - self.times[0])
        return ""


def through(
    robot: Robot,
    q: ArrayLike,
    along: ArrayLike,
    task: Task | str | None = None,
    *,
    bend: ArrayLike | None = None,
) -> Through:
    """Whether a tool path through a configuration can be tracked, and with which time law.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        along: (m,) direction of the path in the rows of the task, in the base's axes [m, rad]: the tool is at
            x(s) = x(0) + s along + ½ s² bend, turned by exp of its angular part.
        task: name, rows or Task; None is the task the arm is made for.
        bend: (m,) of the same kind; None: a straight path.

    Returns:
        The kind, and what was followed.

    Raises:
        ConfigurationError: q is not one configuration, or of corank 2 or more.
        OptionError: along or bend is not one finite number per row, or along is zero.
        TaskError: no such task, or rows not in the base's axes.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("planar2r")
        >>> through(arm, [0, 0], [-1, 0]).kind, through(arm, [0, 0], [0, 1]).kind     # stretched: inwards, sideways
        ('turns back', 'not trackable')
    """
    check_robot(robot)
    resolved = resolve_task(task, robot)
    check_axes(resolved)
    at = one_configuration(robot, q)
    there, there_task = in_metres(robot), task_in_metres(resolved, robot)
    ratio = float(there_task.scale(there) / resolved.scale(robot))  # rows of a twist in metres and rad
    length = np.array([ratio if row < 3 else 1.0 for row in resolved.rows])
    direction, curved = (_vector(name, value, resolved) for name, value in (("along", along), ("bend", bend)))
    if not direction.any():
        raise OptionError("the path has no direction", where="along", got=direction.tolist())
    law = _Path(there, there_task, into_metres(robot, at), direction * length, curved * length).classify()
    if len(law.joints):
        joints = out_of_metres(robot, law.joints)
    else:
        joints = law.joints
    turn = law.turn
    if turn is not None:
        turn = Turn(turn.place, at, out_of_metres(robot, turn.to[None])[0])
    return replace(law, robot=robot, task=resolved, q=at, along=direction, bend=curved, joints=joints, turn=turn)


class _Path:
    """A path at a configuration, everything in scaled joints and scaled rows."""

    def __init__(self, robot: Robot, task: Task, q: Array, along: Array, bend: Array) -> None:
        self.robot, self.task, self.q = robot, task, q
        self.scale = joint_scale(robot, task)
        unit = np.array([1.0 / task.scale(robot) if row < 3 else 1.0 for row in task.rows])
        self.along, self.bend, self.home = along, bend, pose(robot, q)
        self.xi, self.curve = along * unit, bend * unit
        self.size = float(np.linalg.norm(self.xi))
        self.aim = Aim(robot, task)
        u, sigma, vt = np.linalg.svd(task_jacobian(robot, q, task) * self.scale)
        self.rank = int((sigma > DEFAULT.singular).sum())
        self.full = generic_rank(robot, task)
        if self.full < task.m or self.rank < self.full - 1:
            raise ConfigurationError("the configuration is of corank 2 or more, or the arm is singular everywhere",
                                     got=f"rank {self.rank} of {task.m}", allowed="corank 1 at most")  # fmt: skip
        self.u, self.kernel = u[:, self.rank:][:, :1], vt[self.rank:].T
        if self.rank == self.full:
            lost = 0.0
        else:
            lost = float(self.u[:, 0] @ self.xi / self.size)
        if abs(lost) > _NOTHING:
            self.outside = lost
        else:
            self.outside = 0.0

    def _through(self, kind: str, *rest: Any) -> Through:
        return Through(self.robot, self.task, self.q, self.along, self.bend, kind, self.outside, *rest)

    def classify(self) -> Through:
        """The kind, the order, and the law checked by finite motion."""
        if self.rank == self.full:
            return self._through(REGULAR, 1)
        if self.outside:
            law = self._leaving()
        else:
            law = self._tangent()
        if law.kind == NOT and not self.bend.any():
            return replace(law, turn=self._internal_turn())
        return law

    def _internal_turn(self) -> Turn | None:
        """The internal turn after which the path goes on ahead."""
        poses = self._target(np.array([0.0, _TURN_SPAN / self.size]))
        end = internal_turn(self.aim, poses, 0.0, self.q, limits=True)
        if end is None:
            return None
        return Turn(1.0, self.q, end)

    def _leaving(self) -> Through:
        """u·ξ ≠ 0: along the kernel."""
        values, vectors = np.linalg.eigh(self._quadric / (2.0 * self.outside * self.size))
        if values[0] < -_NOTHING and values[-1] > _NOTHING:
            return self._corner(vectors[:, 0], vectors[:, -1])
        sigma, s, joints, off = self._follow_kernel(vectors[:, np.argmax(np.abs(values))])
        order = _order(sigma, s, self.size)
        decided = self._second_order_decides(values, vectors)  # else another direction may do what this one does not
        if order is None:
            return self._through(NOT if decided and self._still(s) else UNDECIDED)
        if order % 2 == 0 and not decided:
            return self._through(UNDECIDED)
        rate = float(np.abs(np.gradient(joints, sigma, axis=0)).max())
        if order % 2:
            kind, side = (PASSES, 0)
        else:
            kind, side = (TURNS, int(np.sign(s[-1])))
        return self._through(kind, order, side, sigma, s, joints * self.scale, off, rate, _exponent(s, joints))

    def _still(self, s: Array) -> bool:
        """The tool stays where it is."""
        return float(np.abs(s).max()) * self.size < _CLOSE * 1e3

    def _second_order_decides(self, values: Array, vectors: Array) -> bool:
        """Whether the terms of second order, or a kernel of one dimension, say how s goes in every direction.

        s has there a minimum or maximum, or one along a curve of self-motion (Morse and Bott): a single direction
        without a term of second order, in which the tool stays where it is.
        """
        flat = np.flatnonzero(np.abs(values) <= _NOTHING)
        if len(values) == 1 or not len(flat):
            return True
        return len(flat) == 1 and self._still(self._follow_kernel(vectors[:, flat[0]])[1])

    def _corner(self, behind: Array, ahead: Array) -> Through:
        """In along one direction of the kernel, out along another; σ = t², so that the joints rest between."""
        (_, s0, q0, off0), (sigma, s1, q1, off1) = map(self._follow_kernel, (behind, ahead))
        keep = sigma >= 0.0
        t = np.sqrt(sigma[keep])
        s0, q0, s1, q1 = s0[keep], q0[keep], s1[keep], q1[keep]
        times, s = np.concatenate([-t[::-1], t[1:]]), np.concatenate([s0[::-1], s1[1:]])
        joints = np.concatenate([q0[::-1], q1[1:]])
        rate = float(np.abs(np.diff(joints, axis=0) / np.diff(times)[:, None]).max())
        return self._through(CORNER, 2, 0, times, s, joints * self.scale, max(off0, off1), rate, _exponent(s1, q1))

    def _tangent(self) -> Through:
        """u·ξ = 0: the quadric decides."""
        jacobian = task_jacobian(self.robot, self.q, self.task) * self.scale
        particular = np.linalg.lstsq(jacobian, self.xi, rcond=DEFAULT.singular)[0]
        bent = np.einsum("ijk,i->jk", self._second, self.u[:, 0])
        b = self.kernel.T @ (0.5 * (bent + bent.T) @ particular)
        g = float(particular @ bent @ particular - self.u[:, 0] @ self.curve)
        points = _on_quadric(self._quadric, b, g)
        for mu in points:
            through = self._at_speed(particular + self.kernel @ mu)
            if through is not None:
                return through
        return self._through(UNDECIDED if points else NOT)

    def _at_speed(self, slope: Array) -> Through | None:
        """The path followed at constant speed from a first guess of dq/ds; None where it is not followed."""
        n = self.robot.n
        span = _SPAN / max(1.0, float(np.linalg.norm(slope)))
        only_s = np.append(np.zeros(n), 1.0)[None]
        s, y, solved = self._curve(span, only_s, np.array([self.size]), np.append(slope, self.size))
        joints = y[:, :n]
        rates = np.diff(joints, axis=0) / np.diff(s)[:, None]
        if not solved or np.abs(np.diff(rates, axis=0)).max() > 0.5 * (1.0 + np.abs(rates).max()):
            return None  # not followed, or another branch was caught
        off, rate = self._off(joints, s), float(np.abs(rates).max())
        return self._through(TANGENT, 1, 0, s, s, joints * self.scale, off, rate)

    def _follow_kernel(self, e: Array) -> tuple[Array, Array, Array, float]:
        """σ, s, scaled joints on the curve whose kernel part is σ e, and the deviation from the path; s(0) = 0."""
        rows = np.hstack([self.kernel.T, np.zeros((self.kernel.shape[1], 1))])
        sigma, y, _ = self._curve(_SPAN, rows, e, np.zeros(self.robot.n + 1))
        joints, s = y[:, :-1], y[:, -1] / self.size
        return sigma, s, joints, self._off(joints, s)

    def _curve(self, span: float, rows: Array, way: Array, slope: Array) -> tuple[Array, Array, bool]:
        """The path followed to both sides, y = (scaled joints, s |ξ|), with C (y − y(0)) = σ w.

        Args:
            span: of σ to either side.
            rows, way: C and w.
            slope: first guess of dy/dσ; zero: each point is begun at the one before it.

        Returns:
            (K,) σ and (K, n + 1) y, and whether every point was reached.
        """
        start = np.append(self.q / self.scale, 0.0)
        steps = span * np.arange(1, _POINTS + 1) / _POINTS
        sides, solved = [], True
        for sign in (-1.0, 1.0):
            y, before, last, side = start, sign * slope, 0.0, []
            for step in steps.tolist():
                missed = partial(self._equations, rows, rows @ start + sign * step * way)
                root = newton(missed, (y + (step - last) * before)[None], iterations=_MOST, step=np.inf, cut=1e-13)[0]
                solved = solved and not missed(root[None])[0][0]
                if slope.any():
                    before = (root - y) / (step - last)
                else:
                    before = before
                y, last = root, step
                side.append(y)
            sides.append(side)
        sigma = np.concatenate([-steps[::-1], [0.0], steps])
        return sigma, np.array([*sides[0][::-1], start, *sides[1]]), solved

    def _equations(self, rows: Array, wanted: Array, guesses: Array) -> tuple[Mask, Array, Array]:
        """What is missing at y (1, n + 1): the tool is on the path at s, and C y is as wanted."""
        y = guesses[0]
        q, s = y[:-1] * self.scale, np.array([y[-1] / self.size])
        e = np.concatenate([self.aim.error(self._target(s), q[None])[0], wanted - rows @ y])
        slope = -(self.xi + s * self.curve)[:, None] / self.size
        top = np.hstack([task_jacobian(self.robot, q, self.task) * self.scale, slope])
        return np.array([np.linalg.norm(e) > _CLOSE]), -e[None], np.vstack([top, rows])[None]

    def _off(self, joints: Array, s: Array) -> float:
        """Largest distance of the tool from the path, in the rows of the task."""
        return float(np.linalg.norm(self.aim.error(self._target(s), joints * self.scale), axis=1).max())

    def _target(self, s: Array) -> Array:
        """(N, 4, 4) poses of the path."""
        six, s = np.zeros((len(s), 6)), s[:, None]
        six[:, list(self.task.rows)] = s * self.along + 0.5 * s * s * self.bend
        targets = np.repeat(self.home[None], len(s), axis=0)
        targets[:, :3, 3] += six[:, :3]
        targets[:, :3, :3] = rotation(six[:, 3:]) @ self.home[:3, :3]
        return targets

    @cached_property
    def _second(self) -> Array:
        """(m, n, n) dJ[:, j]/dq_k in scaled rows and joints."""
        return np.asarray(task_jacobian_derivative(self.robot, self.q, self.task) * self.scale[:, None] * self.scale)

    @cached_property
    def _quadric(self) -> Array:
        """Q, symmetric, on the kernel."""
        whole = np.einsum("ijk,i->jk", self._second, self.u[:, 0])
        return np.asarray(self.kernel.T @ (0.5 * (whole + whole.T)) @ self.kernel)


def _on_quadric(q: Array, b: Array, g: float) -> list[Array]:
    """Points μ with μᵀQμ + 2 b·μ + g = 0, [] where there is none that is real."""
    values, vectors = np.linalg.eigh(q)
    there = np.abs(values) > _NOTHING
    flat = vectors[:, ~there]
    loose = flat @ (flat.T @ b)
    if np.linalg.norm(loose) > _NOTHING:
        return [-g * loose / (2.0 * float(loose @ loose))]
    centre = -vectors[:, there] @ ((vectors[:, there].T @ b) / values[there])
    left = float(centre @ q @ centre + 2.0 * b @ centre + g)
    if abs(left) <= _NOTHING:
        return [centre]
    points = []
    for i in np.flatnonzero(there):
        if values[i] * left < 0.0:
            away = np.sqrt(-left / values[i]) * vectors[:, i]
            points += [centre + away, centre - away]
    return points


def _order(sigma: Array, s: Array, size: float) -> int | None:
    """k of the first term of s(σ), a polynomial through the points; None where no term up to `HIGHEST` counts."""
    scaled = sigma / _SPAN
    basis = scaled[:, None] ** np.arange(1, 2 * HIGHEST + 1)
    c = np.linalg.lstsq(basis, s * size, rcond=None)[0] / _SPAN ** np.arange(1, 2 * HIGHEST + 1)
    for k in range(2, HIGHEST + 1):
        if abs(c[k - 1]) > _NOTHING * 10.0 ** (2 * (k - 2)):  # what rounding leaves grows as σ^−k
            return k
    return None


def _exponent(s: Array, joints: Array) -> float:
    """Power of |s| in |dq/ds|, by central differences at the points ahead of the singularity."""
    ahead = len(s) - _POINTS + np.arange(3, 8)
    gap = np.linalg.norm(joints[ahead + 1] - joints[ahead - 1], axis=1)
    steps = np.abs(s[ahead + 1] - s[ahead - 1])
    return float(np.polyfit(np.log(np.abs(s[ahead])), np.log(gap / steps), 1)[0])


def _vector(name: str, value: ArrayLike | None, task: Task) -> Array:
    if value is None:
        return np.zeros(task.m)
    vector = np.asarray(value, dtype=np.float64)
    if vector.shape != (task.m,) or not np.isfinite(vector).all():
        raise OptionError("one finite number for each row of the task is needed", where=name, got=str(value),
                          allowed=f"{task.m} numbers: {task.name}")  # fmt: skip
    return vector
