"""Coordinates φ of a rotation, their singularities, and the displacement of a task from a start.

The rates of the coordinates obey ω = E(φ) φ̇ (base axes):

    zyz          R = Rz(α) Ry(β) Rz(γ)              det E = −sin β        singular at β = 0, π
    rpy          R = Rz(yaw) Ry(pitch) Rx(roll)     det E = cos(pitch)    singular at pitch = ±π/2
    rotvec       R = exp([φ])                       det E = 2(1 − cos‖φ‖)/‖φ‖²   at ‖φ‖ = 2π; the coordinates, kept to
                                                    ‖φ‖ ≤ π, never get there, but jump at ‖φ‖ = π
    quaternion   (w, x, y, z), w ≥ 0                ω = 2 Q(q)ᵀ q̇, E is 3 × 4 with all σ = 2: never singular
    xyz, zxz, …  R = Ra(α) Rb(β) Rc(γ), every other order of axes, each about the axes as turned before:
                 det E = −sin β where the first axis comes back, else ± cos β      singular at β = 0, π, or at ±π/2
    rodrigues    g = tan(θ/2) n of a turn θ about n   det E = 8/(1 + g²)²          singular, and infinite, at θ = π
    mrp          p = tan(θ/4) n (modified Rodrigues)  det E = 64/(1 + p²)³         at θ = 2π; kept to θ ≤ π, jump there

The analytical Jacobian of (ṗ; φ̇) = J_a q̇ is J_a = diag(I, E⁻¹) J. Where E is singular, J_a does not exist or grows
without bound although the arm moves freely: a *representation singularity*, which other coordinates do not have. The
rank of J does not depend on the coordinates.

The displacement from a start q0, its derivative, and the way back:

    d(q) = (Aᵀ(p(q) − p(q0)) ; Aᵀ log(R(q) R(q0)ᵀ)),  its task rows, translations divided by the length scale

A are the axes of the task's frame at the start, p its reference point. At q0 the derivative is the task Jacobian. For a
task that leaves some rotations free, `log` makes "no rotation about Z" a condition on where the arm is, and not only on
how it moves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.configuration import Rank, configuration_at
from rankdrop.errors import ConfigurationError, OptionError, TaskError
from rankdrop.kinematics import chain_of, frame_view, jacobian, link_poses, one_configuration, pose
from rankdrop.local.block import joint_scale, row_scale, sigma_of, svd
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import hat
from rankdrop.sections import words_of
from rankdrop.task import BASE, TIP, Frame, Task, link_index
from rankdrop.tolerances import DEFAULT, Tolerances

NAMES: dict[str, tuple[str, ...]] = {
    "zyz": ("α", "β", "γ"),
    "rpy": ("roll", "pitch", "yaw"),
    "quaternion": ("w", "x", "y", "z"),
    "rotvec": ("φx", "φy", "φz"),
    **dict.fromkeys(("xyx", "xzx", "yxy", "yzy", "zxz"), ("α", "β", "γ")),
    **dict.fromkeys(("xyz", "xzy", "yxz", "yzx", "zxy", "zyx"), ("α", "β", "γ")),
    "rodrigues": ("gx", "gy", "gz"),
    "mrp": ("px", "py", "pz"),
}
"""The representations and the names of their coordinates, in order."""
MAIN = ("zyz", "rpy", "quaternion", "rotvec")
"""Those most used."""
EULER = tuple(name for name in NAMES if name not in (*MAIN, "rodrigues", "mrp"))
"""Orders of Euler angles that are written with their axes, besides ZYZ."""
_ORDERS = {"zyz": "zyz", "rpy": "zyx", **{name: name for name in EULER}}
"""Angles about three axes, and these in their order; roll, pitch, yaw are those of zyx the other way round."""
_WIDE = -0.85  # cos θ below which a rotation vector is taken from the quaternion: its skew part fades out at π
JUMPING = ("rotvec", "quaternion", "mrp")
"""Coordinates that jump at half a turn."""

_Axes = NDArray[np.intp]

WEAK = 1e-6
"""σ below which the way back leaves a direction alone: what is off along it is of second order in σ."""
_STILL = 1e-9  # a correction so short leaves rounding [rad]
_LONGEST = 0.5  # a correction is cut to this [rad]
_ACCEPTED = 1e-11  # far above rounding, far below the 1e-10 that self-motions promise
_ROUNDS = 12  # Gauss–Newton converges in three or four

NEAR = 0.1
"""Closer than this to a representation singularity is near [rad]: coordinate rates are up to ten times ‖ω‖ there."""


def orientation_coordinates(rotation: ArrayLike, representation: str) -> Array:
    """Coordinates of rotation matrices.

    Args:
        rotation: (..., 3, 3).
        representation: one of `NAMES`.

    Returns:
        (..., 3) [rad; Rodrigues parameters 1, infinite at half a turn], or (..., 4) the unit quaternion (w, x, y, z)
        with w ≥ 0.

    Raises:
        OptionError: no such representation.
    """
    r = np.asarray(rotation, dtype=np.float64)
    _check_known(representation)
    if representation in _ORDERS:
        angles = euler_angles(r, (_ORDERS[representation],))[..., 0, :]
        if representation == "rpy":
            return angles[..., ::-1]
        return angles
    return _of_quaternion(_quaternion(r), representation)


def _of_quaternion(quaternion: Array, representation: str) -> Array:
    """The coordinates that are made of the unit quaternion (..., 4), itself included."""
    vector = quaternion[..., 1:]
    if representation == "quaternion":
        return quaternion
    if representation == "rotvec":
        length = np.linalg.norm(vector, axis=-1, keepdims=True)
        angle = 2.0 * np.arctan2(length, quaternion[..., :1])
        return np.asarray(vector * np.where(length > 0.0, angle / np.where(length > 0.0, length, 1.0), 2.0))
    below = quaternion[..., :1] + (representation == "mrp")
    half = below <= DEFAULT.singular * 0.5
    return np.asarray(np.where(half, np.copysign(np.inf, vector), vector / np.where(half, 1.0, below)))


def rate_matrix(coordinates: ArrayLike, representation: str) -> Array:
    """E with ω = E φ̇: from rates of the coordinates to the angular velocity in base axes.

    Args:
        coordinates: (..., 3) or (..., 4), as from `orientation_coordinates`.
        representation: one of `NAMES`.

    Returns:
        (..., 3, 3), or (..., 3, 4) for the quaternion.

    Raises:
        OptionError: no such representation, or the wrong number of coordinates.
    """
    _check_known(representation)
    c = np.asarray(coordinates, dtype=np.float64)
    if c.ndim == 0 or c.shape[-1] != len(NAMES[representation]):
        raise OptionError("wrong number of coordinates", got=c.shape, allowed=", ".join(NAMES[representation]))
    if representation == "quaternion":
        w, vector = c[..., :1, None], c[..., 1:]
        return 2.0 * np.concatenate([-vector[..., :, None], w * np.eye(3) + hat(vector)], axis=-1)
    if representation == "rotvec":
        angle = np.linalg.norm(c, axis=-1)[..., None, None]
        half = np.sinc(angle / (2 * pi))  # sin(θ/2)/(θ/2)
        turned = hat(c)
        small = angle < 1e-2
        safe = np.where(small, 1.0, angle)
        cubic = np.where(small, 1 / 6 - angle**2 / 120 + angle**4 / 5040, (safe - np.sin(safe)) / safe**3)
        return np.asarray(np.eye(3) + 0.5 * half**2 * turned + cubic * (turned @ turned))
    if representation in _ORDERS:
        turn = -1 if representation == "rpy" else 1
        return euler_rates(c[..., None, ::turn], (_ORDERS[representation],))[..., 0, :, ::turn]
    square = np.sum(c * c, axis=-1)[..., None, None]
    if representation == "rodrigues":
        return np.asarray(2.0 / (1.0 + square) * (np.eye(3) + hat(c)))
    outer = c[..., :, None] * c[..., None, :]
    return np.asarray(4.0 / (1.0 + square) ** 2 * ((1.0 - square) * np.eye(3) + 2.0 * hat(c) + 2.0 * outer))


def _turns(axis: _Axes, angle: Array) -> Array:
    """(..., o, 3, 3) turns about one axis each (o,) by angles (..., o)."""
    turns = np.zeros((*angle.shape, 3, 3))
    each, i, j = np.arange(len(axis)), (axis + 1) % 3, (axis + 2) % 3
    sine, cosine = np.sin(angle), np.cos(angle)
    turns[..., each, axis, axis] = 1.0
    turns[..., each, i, i] = turns[..., each, j, j] = cosine
    turns[..., each, j, i], turns[..., each, i, j] = sine, -sine
    return turns


def _axes(orders: Sequence[str]) -> Iterator[_Axes]:
    """First, second and third axes of some orders: "zxz" gives 2, 0, 2."""
    yield from np.array([["xyz".index(letter) for letter in order] for order in orders]).T


def euler_angles(r: Array, orders: Sequence[str]) -> Array:
    """(..., o, 3) α, β, γ of rotations (..., 3, 3) = Ra(α) Rb(β) Rc(γ) for several of `EULER`.

    Where only α ± γ is determined, γ = 0.
    """
    i, j, k = _axes(orders)
    other, sign = 3 - i - j, np.where((j - i) % 3 == 1, 1.0, -1.0)
    back = i == k  # the first axis comes back
    size = np.hypot(r[..., j, k], np.where(back, r[..., other, k], r[..., k, k]))
    middle = np.arctan2(np.where(back, size, sign * r[..., i, k]), np.where(back, r[..., i, i], size))
    first = np.arctan2(
        np.where(back, r[..., j, i], -sign * r[..., j, k]), np.where(back, -sign * r[..., other, i], r[..., k, k])
    )
    gimbal = np.where(back, np.sin(middle), np.cos(middle)) <= DEFAULT.singular
    first = np.where(gimbal, np.arctan2(sign * r[..., other, j], r[..., j, j]), first)
    left = np.swapaxes(_turns(i, first) @ _turns(j, middle), -1, -2) @ r[..., None, :, :]  # Rc(γ)
    each, u, v = np.arange(len(i)), (k + 1) % 3, (k + 2) % 3
    last = np.where(gimbal, 0.0, np.arctan2(left[..., each, v, u], left[..., each, u, u]))
    return np.stack([first, middle, last], axis=-1)


def euler_rates(angles: Array, orders: Sequence[str]) -> Array:
    """(..., o, 3, 3) E of angles (..., o, 3) of several of `EULER`: its columns are the three axes as they stand."""
    i, j, k = _axes(orders)
    first = _turns(i, angles[..., 0])
    second = first @ _turns(j, angles[..., 1])
    each, rates = np.arange(len(i)), np.zeros((*angles.shape, 3))
    rates[..., each, i, 0] = 1.0
    axes = np.eye(3)
    rates[..., 1], rates[..., 2] = (first @ axes[j][..., None])[..., 0], (second @ axes[k][..., None])[..., 0]
    return rates


def _outer() -> Array:
    """(9, 16) what each entry of R adds to each of 4 q qᵀ; the diagonal has 1 besides."""
    table = np.zeros((3, 3, 4, 4))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        table[i, i, 0, 0] = table[i, i, i + 1, i + 1] = 1.0
        table[i, i, j + 1, j + 1] = table[i, i, k + 1, k + 1] = -1.0
        table[k, j, 0, i + 1] = table[k, j, i + 1, 0] = 1.0
        table[j, k, 0, i + 1] = table[j, k, i + 1, 0] = -1.0
        for entry in ((i, j), (j, i)):
            table[(*entry, i + 1, j + 1)] = table[(*entry, j + 1, i + 1)] = 1.0
    return table.reshape(9, 16)


_OUTER, _ONES = _outer(), np.eye(4).ravel()


def _quaternion(r: Array) -> Array:
    """(w, x, y, z), w ≥ 0: the column of 4 q qᵀ with the largest diagonal entry, so that no digits are lost."""
    outer = (r.reshape(*r.shape[:-2], 9) @ _OUTER + _ONES).reshape(*r.shape[:-2], 4, 4)
    largest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    column = np.take_along_axis(outer, largest[..., None, None], axis=-1)[..., 0]
    unit = column / np.linalg.norm(column, axis=-1, keepdims=True)
    return np.asarray(unit * np.where(unit[..., :1] < 0.0, -1.0, 1.0))


def _check_known(representation: str) -> None:
    if representation not in NAMES:
        raise OptionError("there is no such representation", got=repr(representation), allowed=", ".join(NAMES))


def determined_by_pose(task: Task) -> bool:
    """Whether "these rows stand still" says where the arm is, and not only how it moves.

    All six rows, or the three of the orientation, do so in every frame; three translations in every axes at a point of
    the tip; other rows at a point of the tip in base or tip axes, single translations in base axes only: axes that turn
    make of them a condition on velocities.
    """
    if task.rows in ((0, 1, 2, 3, 4, 5), (3, 4, 5)):
        return True
    if task.frame.origin != TIP:
        return False
    sliding = tuple(row for row in task.rows if row < 3)
    return (
        task.rows == (0, 1, 2) or task.frame.axes == BASE or (task.frame.axes == TIP and sliding in ((), (0, 1, 2)))
    )


class Displacement:
    """The displacement from `start`; joint motions are measured in scaled coordinates q / `joint_scale`.

    Raises:
        TaskError: the task's reference point does not move with the tip.
    """

    def __init__(self, robot: Robot, start: Array, task: Task) -> None:
        last = len(robot.joints) + 1
        anywhere = task.rows in ((0, 1, 2, 3, 4, 5), (3, 4, 5))  # these stand still at any point, or have none
        if link_index(task.frame.origin, len(robot.joints), "point") != last and not anywhere:
            raise TaskError(
                "the reference point of this task does not move with the tip", got=f"link {task.frame.origin}",
                allowed="TIP", mend="give the task a frame with its origin at the tip",
            )  # fmt: skip
        self.robot, self.start, self.joints = robot, start, joint_scale(robot, task)
        self._rows, self._row_scale = list(task.rows), row_scale(robot, task)
        if anywhere:
            point = (0.0, 0.0, 0.0)
        else:
            point = task.frame.point
        self._frame, self._point = Frame(BASE, TIP, point), np.array([*point, 1.0])
        self._home = pose(robot, start)
        self._axes = link_poses(robot, start)[link_index(task.frame.axes, len(robot.joints), "axes"), :3, :3]

    def error(self, q: Array) -> Array:
        """(..., m) displacement of the task's rows at configurations (..., n), without unit."""
        return self._error_and_turn(q)[0]

    def derivative(self, q: Array) -> Array:
        """(..., m, n) of the error by scaled joint coordinates."""
        return self._derivative(q, self._error_and_turn(q)[1])

    def split(self, q: Array) -> tuple[Array, Array, Array]:
        """U, σ, V of the derivative at configurations (..., n)."""
        return svd(self.derivative(q))

    def back(self, q: Array) -> tuple[Array, NDArray[np.bool_]]:
        """The configurations without displacement nearest to q (..., n), by Gauss–Newton, and where it converged.

        Converged means an error of 1e-11 at most; the other configurations are worth nothing.
        """
        rows = np.ascontiguousarray(q).reshape(-1, q.shape[-1])
        ends, off = _core.back_to_start(
            chain_of(self.robot), self._six, self._core_displacement, rows,
            weak=WEAK, longest=_LONGEST, still=_STILL, rounds=_ROUNDS,
        )
        return ends.reshape(q.shape), (off <= _ACCEPTED).reshape(q.shape[:-1])

    @cached_property
    def _six(self) -> _core.View:
        """All six rows at the reference point, in axes of the base."""
        return frame_view(self.robot, self._frame)

    @cached_property
    def _core_displacement(self) -> _core.Displacement:
        """The displacement as the core takes it."""
        return _core.make_displacement(
            rows=self._rows, row_scale=self._row_scale.tolist(), joints=self.joints.tolist(),
            point=list(self._frame.point), axes=np.ascontiguousarray(self._axes), home=self._home,
        )  # fmt: skip

    def _error_and_turn(self, q: Array) -> tuple[Array, Array]:
        """(..., m) the displacement, and (..., 3) the rotation vector of the turn from the start."""
        now = pose(self.robot, q)
        turn = rotation_vector(now[..., :3, :3] @ self._home[:3, :3].T)
        shift = (now - self._home)[..., :3, :] @ self._point
        both = np.concatenate([shift @ self._axes, turn @ self._axes], axis=-1)
        return np.asarray(both[..., self._rows] * self._row_scale), turn

    def _derivative(self, q: Array, turn: Array) -> Array:
        columns = jacobian(self.robot, q, self._frame) * self.joints
        turning = _vector_rates(turn, columns[..., 3:, :])
        both = np.concatenate([self._axes.T @ columns[..., :3, :], self._axes.T @ turning], axis=-2)
        return np.asarray(both[..., self._rows, :] * self._row_scale[:, None])


def rotation_vector(turn: Array) -> Array:
    """(..., 3) θ n of rotations (..., 3, 3), 0 ≤ θ ≤ π; at half a turn π about the axis of (R + 1)/2.

    Up to about 150° from the skew part, which is sin θ n and keeps its digits at small angles; beyond, where sin θ n
    vanishes, from the quaternion.
    """
    cosine = 0.5 * (np.trace(turn, axis1=-2, axis2=-1) - 1.0)
    axial = 0.5 * (turn[..., (2, 0, 1), (1, 2, 0)] - turn[..., (1, 2, 0), (2, 0, 1)])
    sine = np.sqrt((axial * axial).sum(axis=-1))
    share = np.where(sine > 0.0, np.arctan2(sine, cosine) / np.maximum(sine, 1e-300), 1.0)
    vector = np.asarray(axial * share[..., None])
    wide = cosine < _WIDE
    if wide.any():
        vector[wide] = orientation_coordinates(turn[wide], "rotvec")
    return vector


def _vector_rates(vector: Array, omega: Array) -> Array:
    """E⁻¹ω (..., 3, n) of the rotation vector φ: ω − ½ φ × ω + κ φ × (φ × ω), κ = (1 − ½θ cot ½θ)/θ²."""
    angle = np.sqrt((vector * vector).sum(axis=-1))[..., None, None]
    safe = np.where(angle < 1e-2, 1.0, angle)
    share = np.where(angle < 1e-2, 1 / 12 + angle**2 / 720, (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2)
    once = hat(vector) @ omega
    return np.asarray(omega - 0.5 * once + share * (hat(vector) @ once))


@dataclass(frozen=True, slots=True)
class Representation:
    """One set of coordinates at one pose.

    Attributes:
        name: one of `orientation.NAMES`.
        names: of the coordinates.
        coordinates: their values [rad; 1 for a quaternion and Rodrigues parameters]. At a singularity of Euler angles,
            where only a sum or a difference is determined, the last angle is zero, and the roll.
        sigma_min: smallest singular value of E.
        determinant: of E; None for the quaternion, whose E is not square.
        angle: to the nearest orientation where E is singular [rad]; inf if there is none.
        jump: angle to where the coordinates jump, half a turn (the quaternion's w = 0) [rad]; inf for Euler angles and
            Rodrigues parameters.
        singular, near: E is singular here (to the tolerance); or closer than `NEAR`, and not singular.
    """

    name: str
    names: tuple[str, ...]
    coordinates: tuple[float, ...]
    sigma_min: float
    determinant: float | None
    angle: float
    jump: float
    singular: bool
    near: bool

    @property
    def words(self) -> str:
        """What it means, in a sentence."""
        words: str = words_of(self).representation_words(self)
        return words


@dataclass(frozen=True, slots=True)
class Representations:
    """All representations at one configuration, beside the arm's own verdict.

    Attributes:
        arm: rank of the geometric Jacobian for the whole pose.
        zyz, rpy, quaternion, rotvec: one each.
        others: the other orders of Euler angles, Rodrigues and modified Rodrigues parameters.
    """

    arm: Rank
    zyz: Representation
    rpy: Representation
    quaternion: Representation
    rotvec: Representation
    others: tuple[Representation, ...] = ()

    @property
    def every(self) -> tuple[Representation, ...]:
        """All of them, those most used first."""
        return (self.zyz, self.rpy, self.quaternion, self.rotvec, *self.others)

    @property
    def words(self) -> str:
        """Who is singular here: the arm, coordinates, both or neither."""
        words: str = words_of(self).representations_words(self)
        return words

    def of(self, name: str) -> Representation:
        """One of them by its name.

        Raises:
            OptionError: no such representation.
        """
        _check_known(name)
        return next(representation for representation in self.every if representation.name == name)


def analytical_jacobian(robot: Robot, q: ArrayLike, representation: str) -> Array:
    """J_a = diag(I, E⁻¹) J: rates of position and orientation coordinates per joint rate, tip in base axes.

    For the quaternion E⁻¹ stands for E⁺ = ½ Q, the rate that keeps its norm.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad, m].
        representation: one of `orientation.NAMES`.

    Returns:
        (..., 6, n), or (..., 7, n) for the quaternion.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite, or lies on a representation singularity, where J_a
            does not exist.
        OptionError: no such representation.
    """
    _check_known(representation)
    geometric = jacobian(robot, q)
    coordinates = orientation_coordinates(pose(robot, q)[..., :3, :3], representation)
    turn = geometric[..., 3:, :]
    if representation == "quaternion":
        matrix = rate_matrix(coordinates, representation)
        rates = np.asarray(0.25 * matrix.swapaxes(-1, -2) @ turn)
    else:
        finite = np.asarray(np.isfinite(coordinates).all(axis=-1))
        matrix = rate_matrix(np.where(finite[..., None], coordinates, 0.0), representation)
        bad = ~finite | (np.abs(np.linalg.det(matrix)) <= DEFAULT.singular)
        if bad.any():
            index = tuple(int(i) for i in np.argwhere(bad)[0])
            raise ConfigurationError(
                f"the {representation} coordinates are singular at this pose; the arm need not be",
                got=f"{coordinates[index].tolist()}" + (f" at index {index}" if index else ""),
                mend="use the quaternion, or the geometric Jacobian",
            )
        rates = np.asarray(np.linalg.solve(matrix, turn), dtype=np.float64)
    return np.concatenate([geometric[..., :3, :], rates], axis=-2)


def representation_at(robot: Robot, q: ArrayLike, *, tolerances: Tolerances = DEFAULT) -> Representations:
    """How far the pose is from the singularities of each representation, beside the arm's own rank.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        tolerances: `singular` decides for E and for J.

    Raises:
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = representation_at(open_robot("pa10"), [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
        >>> found.zyz.singular, found.quaternion.angle, found.arm.corank
        (False, inf, 0)
    """
    configuration = one_configuration(robot, q)
    arm = configuration_at(robot, configuration, "pose", tolerances).measured
    rotation = pose(robot, configuration)[:3, :3]
    coordinates = _every_coordinates(rotation)
    measures = _rate_measures(coordinates)
    turned = float(np.linalg.norm(coordinates["rotvec"]))
    representations = {name: _describe(name, coordinates[name], *measures[name], turned, tolerances) for name in NAMES}
    others = tuple(part for name, part in representations.items() if name not in MAIN)
    zyz, rpy, quaternion, rotvec = (representations[name] for name in MAIN)
    return Representations(arm, zyz, rpy, quaternion, rotvec, others)


def _every_coordinates(rotation: Array) -> dict[str, Array]:
    """The coordinates of one rotation (3, 3) by name, in the order of `NAMES`: all angles at once, one quaternion."""
    orders = ("zyz", *EULER)
    angles = dict(zip(orders, euler_angles(rotation, orders), strict=True))
    angles["rpy"] = angles[_ORDERS["rpy"]][::-1]
    quaternion = _quaternion(rotation)
    return {name: angles[name] if name in angles else _of_quaternion(quaternion, name) for name in NAMES}


def _rate_measures(coordinates: dict[str, Array]) -> dict[str, tuple[float, float | None]]:
    """(σ_min, det E) by name: 0 where coordinates are not finite; E of the quaternion is not square, its σ are 2."""
    orders = ("zyz", *EULER)
    matrices = dict(zip(orders, euler_rates(np.stack([coordinates[name] for name in orders]), orders), strict=True))
    matrices["rpy"] = matrices[_ORDERS["rpy"]][:, ::-1]
    others = coordinates.keys() - matrices.keys() - {"quaternion"}
    matrices |= {name: rate_matrix(coordinates[name], name) for name in others if np.isfinite(coordinates[name]).all()}
    square = np.stack(list(matrices.values()))
    measures = zip(sigma_of(square)[:, -1].tolist(), np.linalg.det(square).tolist(), strict=True)
    nothing = {**dict.fromkeys(coordinates, (0.0, 0.0)), "quaternion": (2.0, None)}
    return nothing | dict(zip(matrices, measures, strict=True))


def _describe(
    name: str, coordinates: Array, sigma: float, determinant: float | None, turned: float, tolerances: Tolerances
) -> Representation:
    """One set of coordinates, with the smallest singular value and determinant of E and the angle of the whole turn."""
    if name in JUMPING:
        jump = max(0.0, pi - turned)
    else:
        jump = inf
    if name in _ORDERS:
        back = _ORDERS[name][0] == _ORDERS[name][2]  # the first axis comes back
        if back:
            angle = min(abs(coordinates[1]), pi - abs(coordinates[1]))
        else:
            angle = pi / 2 - abs(coordinates[1])
    else:
        angle = max({"rotvec": 2 * pi, "mrp": 2 * pi, "rodrigues": pi, "quaternion": inf}[name] - turned, 0.0)
    singular = sigma <= tolerances.singular
    near = not singular and angle <= NEAR
    return Representation(
        name, NAMES[name], tuple(coordinates.tolist()), sigma, determinant, float(angle), float(jump), singular, near
    )
