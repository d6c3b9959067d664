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
from functools import partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.codec import Result
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import check_robot, one_configuration, pose, task_jacobian, task_jacobian_derivative
from rankdrop.local.block import generic_rank, joint_scale
from rankdrop.motion.inverse import Aim, check_axes, rotation
from rankdrop.motion.text import joint_cells, joint_heads
from rankdrop.motion.trajectory import csv_text
from rankdrop.problem import Mask
from rankdrop.results.explanation.words import minus
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.solve import newton
from rankdrop.task import ROWS, Task, resolve_task
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

_SPAN = 0.1  # of σ to either side [rad]: four digits of a fifth-order term are left
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
    FILE: ClassVar[str] = "through"

    @property
    def trackable(self) -> bool:
        """Whether the path leads through, from one side of the configuration to the other."""
        return self.kind in TRACKABLE

    @property
    def sentence(self) -> str:
        """In words."""
        k = self.order
        if self.kind == PASSES:
            return (f"Trackable through the singularity with s = c t^{k}: the path stands still there for an instant; "
                    f"at constant speed joint rates grow as |s|^(−{(k or 1) - 1}/{k}).")  # fmt: skip
        side = "ahead of it" if self.side > 0 else "before it"
        return {
            REGULAR: "Not singular: trackable with any smooth time law.",
            TANGENT: "Trackable through the singularity at any speed: the path is in the image of J to second order.",
            CORNER: f"Trackable through the singularity with a stop at it, where the joints change direction: s = ± c "
            f"t^{2 * (k or 1)}.",
            TURNS: f"Not trackable through: the path is within reach only {side}. With s = c t^{k} the arm reaches the "
            "singularity and comes back on the path in another posture, at finite joint rates.",
            NOT: "Not trackable: no joint motion from this configuration follows the path, on either side of it.",
            UNDECIDED: f"Undecided: nothing is settled by terms up to order {HIGHEST}.",
        }[self.kind]

    def sections(self, *, deg: bool = False) -> Iterator[Section]:
        """For people: the verdict first and last."""
        yield Section(self.sentence)
        rows = ", ".join(f"{ROWS[row]} {value:g}" for row, value in zip(self.task.rows, self.along, strict=True))
        lines = [f"path along {rows} [m, rad], {100 * abs(self.outside):.3g} % of it lost to first order"]
        if len(self.s):
            ends = f"s = {self.s[0]:.4g} to {self.s[-1]:.4g}"
            lines.append(f"followed from {ends}: off the path by {self.off:.1e} at most")
            law = "at path speed 1" if self.kind == TANGENT else f"under the law, in {self.times[-1] * 2:.3g} s"
            lines.append(f"joint rates {law}: {self.rate:.3g} rad/s at most")
        if self.exponent:
            lines.append(f"joint rates at constant path speed grow as |s|^{self.exponent:.3f} (measured)")
        yield Section(f"{self.robot.name}, {self.task.name}", lines=tuple(minus(x) for x in lines))
        if len(self.s):
            yield self._table(deg=deg)
        yield Section(self.sentence)

    def path_csv(self) -> str:
        """The motion with its times as a file that `rankdrop path` reads [s; rad, m]; empty where there is none."""
        names = [joint.name for joint in self.robot.variables]
        return csv_text(names, self.joints, self.times - self.times[0]) if len(self.s) else ""

    def _table(self, *, deg: bool) -> Section:
        some = range(0, len(self.s), max(1, len(self.s) // 8))
        rows = tuple((minus(f"{self.times[i]:.3f}"), minus(f"{self.s[i]:.3e}"),
                      *joint_cells(self.robot, self.joints[i], deg=deg)) for i in some)  # fmt: skip
        head = ("t [s]", "s", *joint_heads(self.robot, deg=deg))
        return Section("The motion", columns=head, rows=rows, texts=())


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
    length = out_of_metres_factor(robot, resolved, there_task)
    direction, curved = (_vector(name, value, resolved) for name, value in (("along", along), ("bend", bend)))
    if not direction.any():
        raise OptionError("the path has no direction", where="along", got=direction.tolist())
    found = _Path(there, there_task, into_metres(robot, at), direction * length, curved * length).classified()
    joints = out_of_metres(robot, found.joints) if len(found.joints) else found.joints
    return replace(found, robot=robot, task=resolved, q=at, along=direction, bend=curved, joints=joints)


def out_of_metres_factor(robot: Robot, task: Task, there: Task) -> Array:
    """(m,) by which the rows of a twist in the robot's unit are multiplied to get them in metres and rad."""
    ratio = float(there.scale(in_metres(robot)) / task.scale(robot))
    return np.array([ratio if row < 3 else 1.0 for row in task.rows])


class _Path:
    """A path at a configuration, everything in scaled joints and scaled rows."""

    def __init__(self, robot: Robot, task: Task, q: Array, along: Array, bend: Array) -> None:
        self.robot, self.task, self.q = robot, task, q
        self.scale = joint_scale(robot, task)
        self.unit = np.array([1.0 / task.scale(robot) if row < 3 else 1.0 for row in task.rows])
        self.along, self.bend, self.home = along, bend, pose(robot, q)
        self.xi, self.curve = along * self.unit, bend * self.unit
        size = float(np.linalg.norm(self.xi))
        self.size = size
        self.aim = Aim(robot, task)
        u, sigma, vt = np.linalg.svd(task_jacobian(robot, q, task) * self.scale)
        self.rank = int((sigma > DEFAULT.singular).sum())
        self.full = generic_rank(robot, task)
        if self.full < task.m or self.rank < self.full - 1:
            raise ConfigurationError("the configuration is of corank 2 or more, or the arm is singular everywhere",
                                     got=f"rank {self.rank} of {task.m}", allowed="corank 1 at most")  # fmt: skip
        self.u, self.kernel = u[:, self.rank:][:, :1], vt[self.rank:].T
        lost = 0.0 if self.rank == self.full else float(self.u[:, 0] @ self.xi / size)
        self.outside = lost if abs(lost) > _NOTHING else 0.0

    def _through(self, kind: str, *rest: Any) -> Through:
        return Through(self.robot, self.task, self.q, self.along, self.bend, kind, self.outside, *rest)

    def classified(self) -> Through:
        """The kind, the order, and the law checked by finite motion."""
        if self.rank == self.full:
            return self._through(REGULAR, 1)
        return self._leaving() if self.outside else self._tangent()

    def _leaving(self) -> Through:
        """u·ξ ≠ 0: along the kernel."""
        q2 = self._quadric() / (2.0 * self.outside * self.size)
        values, vectors = np.linalg.eigh(q2)
        if values[0] < -_NOTHING and values[-1] > _NOTHING:
            return self._corner(vectors[:, 0], vectors[:, -1])
        e = vectors[:, np.argmax(np.abs(values))]
        sigma, s, joints, off = self._followed(e)
        order = _order(sigma, s, self.size)
        alone = self._alone(values, vectors)  # else other directions of the kernel may do what this one does not
        if order is None:
            still = float(np.abs(s).max()) * self.size < _CLOSE * 1e3
            return self._through(NOT if still and alone else UNDECIDED)
        if order % 2 == 0 and not alone:
            return self._through(UNDECIDED)
        exponent = _exponent(s, joints / self.scale)
        rate = float(np.abs(np.gradient(joints / self.scale, sigma, axis=0)).max())
        kind = PASSES if order % 2 else TURNS
        side = 0 if order % 2 else int(np.sign(s[-1]))
        return self._through(kind, order, side, sigma, s, joints, off, rate, exponent)

    def _alone(self, values: Array, vectors: Array) -> bool:
        """Whether the terms of second order, or a kernel of one dimension, say how s goes in every direction.

        s has there a minimum or maximum, or one along a curve of self-motion (Morse and Bott): a single direction
        without a term of second order, in which the tool stays where it is.
        """
        flat = np.flatnonzero(np.abs(values) <= _NOTHING)
        if len(values) == 1 or not len(flat):
            return True
        if len(flat) > 1:
            return False
        _, s, _, _ = self._followed(vectors[:, flat[0]])
        return float(np.abs(s).max()) * self.size < _CLOSE * 1e3

    def _corner(self, behind: Array, ahead: Array) -> Through:
        """In along one direction of the kernel, out along another; σ = t², so that the joints rest between."""
        halves = []
        for e in (behind, ahead):
            sigma, s, joints, off = self._followed(e)
            keep = sigma >= 0.0
            halves.append((np.sqrt(sigma[keep]), s[keep], joints[keep], off))
        (t0, s0, q0, off0), (t1, s1, q1, off1) = halves
        times, s = np.concatenate([-t0[::-1], t1[1:]]), np.concatenate([s0[::-1], s1[1:]])
        joints = np.concatenate([q0[::-1], q1[1:]])
        rate = float(np.abs(np.diff(joints / self.scale, axis=0) / np.diff(times)[:, None]).max())
        return self._through(CORNER, 2, 0, times, s, joints, max(off0, off1), rate, _exponent(s1, q1 / self.scale))

    def _tangent(self) -> Through:
        """u·ξ = 0: the quadric decides."""
        jacobian = task_jacobian(self.robot, self.q, self.task) * self.scale
        particular = np.linalg.lstsq(jacobian, self.xi, rcond=DEFAULT.singular)[0]
        bracket = self._second()
        linear = 0.5 * (np.einsum("ik,i->k", np.einsum("ijk,j->ik", bracket, particular), self.u[:, 0])
                        + np.einsum("ij,i->j", np.einsum("ijk,k->ij", bracket, particular), self.u[:, 0]))  # fmt: skip
        b = self.kernel.T @ linear
        g = float(self.u[:, 0] @ (np.einsum("ijk,j,k->i", bracket, particular, particular) - self.curve))
        for mu in _on_quadric(self._quadric(), b, g):
            found = self._at_speed(particular + self.kernel @ mu)
            if found is not None:
                return found
        return self._through(NOT if _none(self._quadric(), b, g) else UNDECIDED)

    def _at_speed(self, slope: Array) -> Through | None:
        """The path followed at constant speed from a first guess of dq/ds; None where it is not followed."""
        span = _SPAN / max(1.0, float(np.linalg.norm(slope)))
        steps = span * np.arange(1, _POINTS + 1) / _POINTS
        sides = []
        for sign in (-1.0, 1.0):
            rows: list[Array] = []
            q, before, last = self.q / self.scale, slope * sign, 0.0
            for step in steps:
                solved = self._solved(q + (step - last) * before, sign * step)
                if solved is None:
                    return None
                q, before, last = solved, (solved - q) / (step - last), step
                rows.append(q)
            sides.append(np.array(rows))
        joints = np.concatenate([sides[0][::-1], self.q[None] / self.scale, sides[1]])
        s = np.concatenate([-steps[::-1], [0.0], steps])
        rates = np.diff(joints, axis=0) / np.diff(s)[:, None]
        if np.abs(np.diff(rates, axis=0)).max() > 0.5 * (1.0 + np.abs(rates).max()):
            return None  # another branch was caught
        return self._through(TANGENT, 1, 0, s, s, joints * self.scale, self._off(joints, s), float(np.abs(rates).max()))

    def _solved(self, q: Array, s: float) -> Array | None:
        """Configuration at s near a first guess, by Newton's method with least change."""
        target = self._target(s)

        def missed(q: Array) -> tuple[Mask, Array, Array]:
            e = self.aim.error(target, q * self.scale)
            slope = task_jacobian(self.robot, q * self.scale, self.task) * self.scale
            return np.linalg.norm(e, axis=1) > _CLOSE, -e, slope

        found = newton(missed, q[None], iterations=_MOST, step=np.inf, cut=1e-12)
        return None if missed(found)[0][0] else np.asarray(found[0])

    def _followed(self, e: Array) -> tuple[Array, Array, Array, float]:
        """σ, s, joints on the curve whose kernel part is σ e, and the deviation from the path; s(0) = 0."""
        steps = _SPAN * np.arange(1, _POINTS + 1) / _POINTS
        sides = []
        for sign in (-1.0, 1.0):
            y, rows = np.append(self.q / self.scale, 0.0), []
            for step in steps:
                y = self._corrected(y, sign * step * e)
                rows.append(y)
            sides.append(np.array(rows))
        y = np.concatenate([sides[0][::-1], np.append(self.q / self.scale, 0.0)[None], sides[1]])
        sigma = np.concatenate([-steps[::-1], [0.0], steps])
        joints, s = y[:, :-1], y[:, -1] / self.size
        return sigma, s, joints * self.scale, self._off(joints, s)

    def _corrected(self, y: Array, wanted: Array) -> Array:
        """Newton's method on: the tool is on the path at s, and the kernel part of q − q(0) is as wanted."""
        n = self.robot.n

        def missed(rows: Array) -> tuple[Mask, Array, Array]:
            y = rows[0]
            q, s = y[:n] * self.scale, y[n] / self.size
            e = np.concatenate([self.aim.error(self._target(s), q[None])[0],
                                wanted - self.kernel.T @ (y[:n] - self.q / self.scale)])  # fmt: skip
            slope = -(self.xi + s * self.curve)[:, None] / self.size
            top = np.hstack([task_jacobian(self.robot, q, self.task) * self.scale, slope])
            bottom = np.hstack([self.kernel.T, np.zeros((self.kernel.shape[1], 1))])
            return np.array([np.linalg.norm(e) > _CLOSE]), -e[None], np.vstack([top, bottom])[None]

        return np.asarray(newton(missed, y[None], iterations=_MOST, step=np.inf, cut=1e-13)[0])

    def _off(self, joints: Array, s: Array) -> float:
        """Largest distance of the tool from the path, in the rows of the task."""
        gaps = (self.aim.error(self._target(float(x)), (q * self.scale)[None])[0]
                for q, x in zip(joints, s, strict=True))  # fmt: skip
        return max(float(np.linalg.norm(gap)) for gap in gaps)

    def _target(self, s: float) -> Array:
        six = np.zeros(6)
        six[list(self.task.rows)] = s * self.along + 0.5 * s * s * self.bend
        found = self.home.copy()
        found[:3, 3] += six[:3]
        found[:3, :3] = rotation(six[None, 3:])[0] @ self.home[:3, :3]
        return found

    def _second(self) -> Array:
        """(m, n, n) dJ[:, j]/dq_k in scaled rows and joints."""
        return np.asarray(task_jacobian_derivative(self.robot, self.q, self.task) * self.scale[:, None] * self.scale)

    def _quadric(self) -> Array:
        """Q, symmetric, on the kernel."""
        whole = np.einsum("ijk,i->jk", self._second(), self.u[:, 0])
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
    fitting = [i for i in np.flatnonzero(there) if values[i] * left < 0.0]
    return [centre + sign * np.sqrt(-left / values[i]) * vectors[:, i] for i in fitting for sign in (1.0, -1.0)]


def _none(q: Array, b: Array, g: float) -> bool:
    """Whether it is clear that the quadric has no real point."""
    values, vectors = np.linalg.eigh(q)
    there = np.abs(values) > _NOTHING
    if not there.any():
        return bool(np.linalg.norm(b) <= _NOTHING < abs(g))
    part = (vectors[:, there].T @ b) / values[there]
    left = g - float(part**2 @ values[there])
    flat = float(np.linalg.norm(vectors[:, ~there].T @ b))
    return bool(flat <= _NOTHING < abs(left) and (values[there] * left > 0.0).all())


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
    found = np.asarray(value, dtype=np.float64)
    if found.shape != (task.m,) or not np.isfinite(found).all():
        raise OptionError("one finite number for each row of the task is needed", where=name, got=str(value),
                          allowed=f"{task.m} numbers: {task.name}")  # fmt: skip
    return found
