"""Rigid transforms as (4, 4) arrays, exact where the angle is a multiple of π/2; brackets of screws.

What an arm's numbers are made of is multiplied here, element by element, and not by NumPy's `@`: a BLAS has kernels for
each kind of processor, which round differently, and a proof made on one machine names the arm to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sin, sqrt
from numbers import Integral, Real
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.errors import RankdropError, RobotError

Array = NDArray[np.float64]
_Values = TypeVar("_Values")
_NUMBERS = "real numbers"
_DEEPEST = 64  # axes that an array of NumPy's may have
_LARGEST_INTEGER = 2**64  # NumPy has integers below it
_EXACT = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


def unmasked(values: _Values, what: str, error: type[RankdropError] = RobotError) -> _Values:
    """The values as they are given; masked ones are refused, for NumPy would take the numbers under the mask."""
    if np.ma.is_masked(values):
        raise error(f"{what} has masked values", mend="fill them in: q.filled(…)")
    return values


def as_numbers(values: Any, what: str, error: type[RankdropError] = RobotError) -> Array:
    """What a caller hands in as a fresh or shared array of doubles: the conversion of every public function.

    Numbers of Python and NumPy, fractions, decimals and whatever has a float are taken, in lists of equal lengths.
    NumPy would also read booleans, texts, dates, the real part of complex numbers and what lies under a mask.

    Args:
        values: from the caller.
        what: its name, for errors.
        error: type of the errors.

    Raises:
        rankdrop.errors.RankdropError: of that type: something else, unequal lists, or an integer beyond the doubles.
    """
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    if _has_mask(values):
        raise error(f"{what} has masked values", mend="fill them in: q.filled(…)")
    try:
        array = np.asarray(values)
    except (ValueError, TypeError, OverflowError):
        raise error(f"{what} is no array of numbers", got=f"a {type(values).__name__}", allowed=_NUMBERS) from None
    if array.dtype.kind == "O":
        return _objects_as_numbers(array, what, error)
    if array.dtype.kind not in "fiu":
        raise error(f"{what} is no array of numbers", got=f"an array of {array.dtype}", allowed=_NUMBERS)
    if _has_boolean(values):
        raise error(f"{what} is no array of numbers", got="a bool", allowed=_NUMBERS)
    with np.errstate(over="ignore"):  # longer floats beyond the doubles become infinite
        return np.asarray(array, dtype=np.float64)


def _objects_as_numbers(array: NDArray[Any], what: str, error: type[RankdropError]) -> Array:
    """An array of objects, fractions or whole numbers of any length, as doubles.

    Raises:
        rankdrop.errors.RankdropError: of the type `error`: one is no number, or beyond the doubles.
    """
    wrong = [type(value).__name__ for value in array.flat if not _is_real(value)]
    if wrong:
        raise error(f"{what} is no array of numbers", got=f"a {wrong[0]}", allowed=_NUMBERS)
    if any(isinstance(value, Integral) and abs(int(value)) >= _LARGEST_INTEGER for value in array.flat):
        raise error(f"{what} has an integer of more than 64 bits", allowed=_NUMBERS)
    try:
        return array.astype(np.float64)
    except (ValueError, TypeError, OverflowError):
        raise error(f"{what} has a number beyond the doubles", allowed=_NUMBERS) from None


def _is_real(value: object) -> bool:
    if isinstance(value, bool):
        return False
    return isinstance(value, Real) or (hasattr(value, "__float__") and not isinstance(value, np.generic | np.ndarray))


def _has_boolean(values: Any) -> bool:
    """Whether a boolean is among the numbers of lists, as deep as NumPy reads them: it would become 0 or 1."""
    if isinstance(values, list | tuple):
        return any(map(_has_boolean, values))
    if isinstance(values, np.ndarray):
        return bool(values.dtype.kind == "b")
    return isinstance(values, bool | np.bool_)


def _has_mask(values: Any, deep: int = 0) -> bool:
    """Whether a value is masked, in lists of arrays too, as deep as NumPy reads them."""
    if isinstance(values, list | tuple):
        inside = (part for part in values if isinstance(part, list | tuple | np.ma.MaskedArray))
        return deep < _DEEPEST and any(_has_mask(part, deep + 1) for part in inside)
    return bool(np.ma.is_masked(values))


def times(first: Array, *others: Array) -> Array:
    """Product of matrices, or of matrices and a vector at the end; the same bits on every processor."""
    product = first
    for other in others:
        if other.ndim == 2:
            product = (product[:, :, None] * other).sum(1)
        else:
            product = (product * other).sum(1)
    return product


def dot(one: Array, two: Array) -> float:
    """Scalar product of two vectors; the same bits on every processor."""
    return float((one * two).sum())


def norm(vector: Array) -> float:
    """Length of a vector; the same bits on every processor."""
    return sqrt(dot(vector, vector))


def inverse(pose: Array) -> Array:
    """(4, 4) the inverse [Rᵀ −Rᵀp] of a rigid transform [R p]."""
    result = np.eye(4)
    result[:3, :3] = pose[:3, :3].T
    result[:3, 3] = -times(pose[:3, :3].T, pose[:3, 3])
    return result


def nearest_rotation(turn: Array) -> Array:
    """(3, 3) Newton's step R (3 − RᵀR) / 2 to the rotation nearest to one: an error of 1e-6 becomes 1e-12."""
    return times(turn, 1.5 * np.eye(3) - 0.5 * times(turn.T, turn))


def cos_sin(angle: float) -> tuple[float, float]:
    """(cos, sin) of an angle [rad]; exactly 0 and ±1 where the angle is the double nearest to a multiple of π/2.

    Keeps axes that are parallel or intersecting in the description exactly so in the screws.
    """
    quarter = round(angle / (pi / 2))
    if abs(angle - quarter * (pi / 2)) <= 4e-16 * max(1, abs(quarter)):
        return _EXACT[quarter % 4]
    return cos(angle), sin(angle)


def rotation(axis: str, angle: float) -> Array:
    """(4, 4) rotation about the "x", "y" or "z" axis by `angle` [rad]."""
    c, s = cos_sin(angle)
    result = np.eye(4)
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    result[j, j], result[j, k], result[k, j], result[k, k] = c, -s, s, c
    return result


def about_axis(axis: Array, angle: float) -> Array:
    """(4, 4) rotation about a unit axis (3,) through the origin by `angle` [rad]: R = c I + (1 − c) a aᵀ + s [a]×."""
    c, s = cos_sin(angle)
    x, y, z = axis
    result = np.eye(4)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result[:3, :3] = c * np.eye(3) + (1.0 - c) * np.outer(axis, axis) + s * cross
    return result


def translation(x: float, y: float, z: float) -> Array:
    """(4, 4) translation [m]."""
    result = np.eye(4)
    result[:3, 3] = x, y, z
    return result


def from_xyz_rpy(xyz: Sequence[float], rpy: Sequence[float]) -> Array:
    """(4, 4) pose Trans(xyz) · Rz(yaw) · Ry(pitch) · Rx(roll), as in URDF; metres and radians."""
    roll, pitch, yaw = rpy
    return times(translation(*xyz), rotation("z", yaw), rotation("y", pitch), rotation("x", roll))


def frame_on_axis(direction: Array, point: Array) -> Array:
    """(4, 4) a frame with its origin at `point` and its z axis along `direction` (3,)."""
    z = direction / norm(direction)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= norm(x)
    result = np.eye(4)
    result[:3, 0], result[:3, 1], result[:3, 2], result[:3, 3] = x, np.cross(z, x), z, point
    return result


def rigid(value: ArrayLike, where: str) -> Array:
    """A (4, 4) array checked to be a rigid transform within 1e-6, made orthonormal to rounding.

    Raises:
        RobotError: wrong shape, not finite, or not a rotation with a translation.
    """
    try:
        pose = np.array(unmasked(value, where), dtype=np.float64)
    except (TypeError, ValueError):
        raise RobotError("this is not a matrix of numbers", where=where, got=repr(value)) from None
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise RobotError("a pose is a finite (4, 4) matrix", where=where, got=pose.tolist(), allowed="shape (4, 4)")
    turn = pose[:3, :3]
    error = float(np.abs(times(turn, turn.T) - np.eye(3)).max())
    if error > 1e-6 or np.linalg.det(turn) < 0.0 or np.abs(pose[3] - (0.0, 0.0, 0.0, 1.0)).max() > 1e-12:
        raise RobotError(
            "the matrix is not a rigid transform", where=where, got=pose.tolist(),
            allowed="[R p; 0 0 0 1] with a rotation R",
        )
    if error > 1e-15:
        pose[:3, :3] = nearest_rotation(nearest_rotation(turn))
    return pose


def cross(a: Array, b: Array) -> Array:
    """(..., 3) a × b; several times faster than NumPy's on small arrays."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    first = y * w - z * v
    out = np.empty((*first.shape, 3))
    out[..., 0], out[..., 1], out[..., 2] = first, z * u - x * w, x * v - y * u
    return out


def hat(a: Array) -> Array:
    """(..., 3, 3) [a] with [a] b = a × b."""
    matrix = np.zeros((*a.shape[:-1], 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        matrix[..., k, j], matrix[..., j, k] = a[..., i], -a[..., i]
    return matrix


def unit(vectors: Array) -> Array:
    """(..., n) the same directions with length 1; zero stays zero."""
    squares = np.add.reduce(vectors * vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(np.sqrt(squares), 1e-300))


def bracket(left: Array, right: Array) -> Array:
    """(..., 6) [A, B] = (ω_A × v_B + v_A × ω_B ; ω_A × ω_B) of twists (v; ω) (..., 6) in one frame, broadcast.

    What one joint's motion does to another's screw: ∂S_i/∂q_k = [S_k, S_i] for k < i. GR write the same product with
    the direction first: `rankdrop.local.ordered.lie_product`.
    """
    va, wa, vb, wb = left[..., :3], left[..., 3:], right[..., :3], right[..., 3:]
    return np.concatenate([cross(wa, vb) + cross(va, wb), cross(wa, wb)], axis=-1)


def brackets(screws: Array) -> Array:
    """Every bracket of two joint screws that a motion makes: [S_a, S_i] for i > a, else 0.

    Args:
        screws: (6, N) columns (v; ω), all in one frame.

    Returns:
        (N, 6, N): [a, :, i].
    """
    columns = screws.T
    every = bracket(columns[:, None, :], columns[None, :, :])  # (N, N, 6)
    later = np.triu(np.ones((len(columns), len(columns))), 1)
    return np.swapaxes(every * later[..., None], -1, -2)
