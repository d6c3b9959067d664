"""Lost directions: which end-effector motions no joint rate can make, in a readable basis and frame.

A readable basis of a subspace is orthonormal, with as many zeros as plane rotations find. Words:
`rankdrop.text.directions`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import hypot, isfinite

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.errors import OptionError
from rankdrop.kinematics import link_poses, one_configuration, task_jacobian
from rankdrop.local.block import decompose, generic_rank, svd
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.transform import cross
from rankdrop.sections import words_of
from rankdrop.task import BASE, TIP, Frame, Task, link_index, six_rows
from rankdrop.tolerances import ENTRY
from rankdrop.units import counted_as_radian, given_exponent, in_metres, into_metres, task_in_metres

FRAMES = ("base", "tool", "link")
"""Frames in whose axes a lost motion can be reported."""

ENTRY_SHARE = 1e-6
"""A part of a direction below this share of the other part is not there."""
AXIS = 1e-6
"""An axis is X, Y or Z when its other components are below this."""

NEARLY_SHARE = 0.25
"""A part of a direction below this share of the whole: what the other part alone says is true to 3 %."""

_NOTHING = 0.02  # parts of a unit direction that are shorter are not drawn
_TURN = 300.0  # degrees of a ring

_DEPENDENT = 1e-9  # columns of the input more dependent than this span nothing certain

_NEIGHBOURS = 16  # regular configurations around q that tell what is always lost from what is lost at q
_STILL = 1e-6  # projectors on a lost subspace that differ by less are the same
_STEP = 0.1  # how far away they are [rad; slides per reach]


def rewrite_wrench(wrench: Array, turn: Array, offset: Array) -> Array:
    """Wrenches (f; τ) written in other axes, at another point: f' = Rᵀf, τ' = Rᵀ(τ − d × f).

    The power f·v + τ·ω does not change, so what is blocked in one frame is blocked in the other.

    Args:
        wrench: (..., 6) in the old axes, moment about the old point.
        turn: (..., 3, 3) R, columns are the new axes in the old ones.
        offset: (..., 3) d, the new point seen from the old one, in the old axes [m]; batch axes broadcast.
    """
    force, moment = wrench[..., :3], wrench[..., 3:]
    return np.concatenate([force @ turn, (moment - cross(offset, force)) @ turn], axis=-1)


@dataclass(frozen=True, eq=False)
class LostDirection:
    """One lost direction; its words are in `rankdrop.text.directions`.

    Attributes:
        direction: (6,) vx vy vz wx wy wz of any length and sign, metres and radians.
        length: the direction's own unit of length, `units.counted_length` [m].
    """

    direction: ArrayLike
    length: float = 1.0


def constraint(direction: ArrayLike, length: float = 1.0) -> str:
    """A lost direction as what it does to the motions that remain: "0.63 vy + 0.7 vz + 0.098 m·ωx = 0".

    A direction u = (u_v; u_ω) is lost when u · (v; ω) = 0 for every twist the joints can make. That equation says what
    can still be done; no length has to be chosen for it. Its larger part is a unit vector, its largest number positive.

    Args:
        direction: (6,) vx vy vz wx wy wz of any length and sign, metres and radians.
        length: the direction's own unit of length, `units.counted_length` [m].

    Raises:
        OptionError: not six finite numbers, or all of them zero.

    Example:
        >>> constraint([0, -0.91, 0, 0, 0, -0.41])
        'vy + 0.451 m·ωz = 0'
        >>> constraint([0, 0, 0.05, 0.6, -0.8, 0])
        '−0.6 ωx + 0.8 ωy − 0.05 rad/m·vz = 0'
    """
    lost = LostDirection(direction, length)
    text: str = words_of(lost).constraint_text(lost)
    return text


def constraint_values(direction: ArrayLike, length: float = 1.0) -> tuple[Array, bool]:
    """(6,) coefficients of the `constraint`, its larger part first, rounding set to zero; and whether that part is ω.

    Coefficients of the larger part have no unit; the others are in m, or in rad/m where the larger part is ω.

    Args, Raises: as `constraint`.
    """
    v, w, slide, turn = parts_of_direction(direction)
    turns = turn > slide
    if turns:
        larger, smaller, per = w / turn, v / turn, 1.0 / length
    else:
        larger, smaller, per = v / slide, w / slide, length
    if np.linalg.norm(smaller) <= ENTRY_SHARE:
        smaller = np.zeros(3)
    values = np.concatenate([larger, smaller])
    values *= np.sign(larger[int(np.argmax(np.abs(larger) >= np.abs(larger).max() - AXIS))])
    values[np.abs(values) <= AXIS] = 0.0
    values[3:] *= per
    return values, turns


def is_nearly_pure(direction: ArrayLike) -> bool:
    """Whether a lost direction is nearly, but not quite, one of pure translation or pure rotation.

    Args, Raises: as `constraint`.
    """
    _, _, slide, turn = parts_of_direction(direction)
    return ENTRY_SHARE < min(slide, turn) / float(np.hypot(slide, turn)) <= NEARLY_SHARE


def in_short(direction: ArrayLike) -> str:
    """What a lost direction comes to where it is, or nearly is, one of pure translation or pure rotation; else empty.

    Args, Raises: as `constraint`.

    Example:
        >>> in_short([0, 0.6, 0.8, 0, 0, 0]), in_short([0, 0, 0.05, 1, 0, 0]), in_short([0, 0.7, 0, 0, 0.7, 0])
        ('no motion along (0, 0.6, 0.8)', 'nearly no turning about X', '')
    """
    lost = LostDirection(direction)
    text: str = words_of(lost).short_text(lost)
    return text


def words(direction: ArrayLike, frame_name: str = "the base", length: float = 1.0) -> str:
    """One lost direction as a sentence.

    A direction u = (v; ω) is lost when u · twist = 0 for every twist the joints can make. Where u is a pure translation
    or rotation, that motion cannot be made, as AM say. With both parts present it is no motion that is told but what
    ties the others together (`constraint`), and what that nearly comes to.

    Args:
        direction: (6,) vx vy vz wx wy wz of any length and sign, metres and radians.
        frame_name: whose axes: "the base", "the tool", "link 4".
        length: the direction's own unit of length, `units.counted_length` [m].

    Raises:
        OptionError: not six finite numbers, or all of them zero.

    Example:
        >>> words([0, 0, 0, 1, 0, 0])
        'cannot rotate about X of the base'
        >>> words([0, -0.91, 0, 0, 0, -0.1], "the tool")
        'can only move so that vy + 0.11 m·ωz = 0 in axes of the tool: nearly no motion along Y'
    """
    lost = LostDirection(direction, length)
    text: str = words_of(lost).lost_text(lost, frame_name)
    return text


def blocked_words(direction: ArrayLike, frame_name: str = "the base", length: float = 1.0) -> str:
    """The same direction read as the wrench (f; τ) that the structure carries with no joint torque.

    With f ≠ 0 it is a force along the line p + s f, p = f × τ/|f|², and a moment h f, h = f·τ/|f|²: power zero means
    v_p·f + h ω·f = 0. A force alone (h = 0): no point of that line can move along the line. No choice of a length is
    needed for this.

    Args, Raises: as `words`.

    Example:
        >>> blocked_words([0, 0.91, 0, 0, 0, 0.41])
        'the point (0.451, 0, 0) m from the reference point cannot move along Y of the base'
    """
    lost = LostDirection(direction, length)
    text: str = words_of(lost).blocked_text(lost, frame_name)
    return text


def arrow_of(direction: ArrayLike) -> tuple[Array, Array, bool]:
    """One lost freedom as one arrow at the reference point, with a ring about its foot where it mixes both motions.

    Args:
        direction: (6,) a lost direction (v; ω), of any length and sign, metres and radians.

    Returns:
        (3,) the arrow, at most of length one; (3,) the axis of its ring, as long as the ring is wide, zero for none;
        whether the arrow is a turning about it (dotted) and not a motion along it.

    Raises:
        OptionError: not six finite numbers, or all of them zero.

    Example:
        >>> arrow, ring, turns = arrow_of([0, 0.8, 0, 0, 0, 0.6])
        >>> arrow.round(3).tolist(), ring.round(3).tolist(), turns
        ([0.0, 0.87, 0.0], [0.0, 0.0, 0.22], False)
    """
    values = np.asarray(direction, dtype=np.float64)
    v, w, slide, turn = parts_of_direction(values / max(float(np.linalg.norm(values)), 1e-300))
    if turn < _NOTHING:
        return v / slide, np.zeros(3), False
    if slide < _NOTHING:
        return w / turn, np.zeros(3), True
    return (0.35 + 0.65 * slide) * v / slide, (0.07 + 0.25 * turn) * w / turn, False


def ring_about(axis: Array) -> Array:
    """(P, 3) points of a ring about an axis through the origin, its radius the axis's length, with a head at its end.

    It turns as the right hand does about the axis.

    Args:
        axis: (3,) not zero.
    """
    radius = float(np.linalg.norm(axis))
    z = axis / radius
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    angles = np.radians(np.linspace(0.0, _TURN, 41))[:, None]
    round_about = radius * (np.cos(angles) * x + np.sin(angles) * np.cross(z, x))
    end = round_about[-1]
    back = end - 0.36 * np.cross(z, end)
    return np.vstack([round_about, back + 0.2 * end, end, back - 0.2 * end])


def parts_of_direction(direction: ArrayLike) -> tuple[Array, Array, float, float]:
    """Translation and rotation of a direction, (3,) each, and the lengths of both.

    Args:
        direction: (6,) vx vy vz wx wy wz of any length and sign.

    Raises:
        OptionError: not six finite numbers, or all of them zero.
    """
    values = np.asarray(direction, dtype=np.float64)
    entries = values.tolist()
    if values.shape != (6,) or not all(map(isfinite, entries)) or not any(entries):
        raise OptionError("a direction is six finite numbers, not all zero", got=np.asarray(direction).tolist())
    return values[:3], values[3:], hypot(*entries[:3]), hypot(*entries[3:])


def main_axis(vector: ArrayLike) -> tuple[int, bool]:
    """The axis (0 X, 1 Y, 2 Z) with the largest component of a vector, and whether the vector is along it.

    Args:
        vector: (3,) not zero.

    Example:
        >>> main_axis([0.0, -2.0, 0.0]), main_axis([0.6, 0.0, 0.8])
        ((1, True), (2, False))
    """
    parts = [abs(float(part)) for part in np.asarray(vector).tolist()]
    whole = hypot(*parts)
    shares = [part / whole for part in parts]
    largest = next(axis for axis, share in enumerate(shares) if share >= max(shares) - AXIS)
    return largest, all(share <= AXIS for axis, share in enumerate(shares) if axis != largest)


def readable_basis(B: ArrayLike) -> Array:
    """Orthonormal basis of span(B) with the fewest non-zero entries, found by plane (Givens) rotations (AM 2.3).

    Among bases with as few entries it has the smallest sum of absolute values. Rotating columns a, b by φ changes that
    sum to Σ_i r_i (|cos(φ − α_i)| + |sin(φ − α_i)|) with r_i e^{jα_i} = a_i + j b_i. Each term is concave between the
    angles where an entry vanishes, so the best φ is one of these few angles: a plane step is exact and makes an entry
    exactly zero. Sweeps over all planes start from many bases that depend on the subspace only (zeros forced at every
    choice of rows), and the best result is kept. Then every basis is tried (with bounds) whose vectors, one after the
    other, vanish in as many rows as what is left of the space allows: a planted one of this kind is always found. For
    k = 2 the result is the global minimum; for k ≥ 3 it is a search.

    Sign: the largest entry of every column is positive (the first of them, if tied). Order: by the row of the largest
    entry. Ties (sums within 1e-6): the larger |entries| in the earlier rows; the choice is the same for every basis of
    one subspace, but jumps where the subspace passes through a tie, e.g. at a plane normal to (1, 1, 1).
    The result depends on the axes and on the unit of length, as every basis of mixed twists does.

    Args:
        B: (m, k) independent columns, k ≤ m; they need not be orthonormal.

    Returns:
        (m, k) orthonormal columns.

    Raises:
        OptionError: not a finite matrix, or its columns are dependent.

    Example:
        >>> readable_basis([[0.6, -0.8], [0.8, 0.6], [0, 0]]).round(9).tolist()
        [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]
    """
    columns = np.asarray(B, dtype=np.float64)
    if columns.ndim != 2 or not np.isfinite(columns).all():
        raise OptionError("a basis is a finite (m, k) matrix", got=columns.shape, allowed="shape (m, k), k ≤ m")
    rows, count = columns.shape
    if count == 0:
        return np.zeros((rows, 0))
    u, sigma, vt = np.linalg.svd(columns, full_matrices=False)
    if count > rows or sigma[-1] <= _DEPENDENT * sigma[0]:
        raise OptionError("the columns of a basis are independent", got=f"singular values {sigma.tolist()}")
    return np.asarray(readable_bases((u @ vt)[None])[0])


def readable_bases(orthonormal: Array) -> Array:
    """`readable_basis` of many subspaces at once.

    Args:
        orthonormal: (B, m, k) orthonormal columns, 1 ≤ k ≤ m.

    Returns:
        (B, m, k) orthonormal columns.
    """
    return _core.readable(np.ascontiguousarray(orthonormal))


@dataclass(frozen=True, slots=True)
class FramedDirections:
    """Lost directions and the frame they are written in.

    Attributes:
        directions: (k, 6) as from `lost_directions`, in `frame`.
        frame: axes and reference point.
        power: numbers of the point are reported times 10 to this power.
    """

    directions: Array
    frame: Frame
    power: int = 0

    @property
    def name(self) -> str:
        """The frame, to end a sentence with: "the base", "the tool", "link 4", "link 4 at its origin"."""
        name: str = words_of(self).frame_name(self.frame, self.power)
        return name

    def sentences(self, length: float = 1.0) -> tuple[str, ...]:
        """One sentence for each direction; `length`: the directions' own unit of length [m]."""
        return tuple(words(direction, self.name, length) for direction in self.directions)

    def blocked_sentences(self, length: float = 1.0) -> tuple[str, ...]:
        """The same directions read as wrenches; `length`: their own unit of length [m]."""
        return tuple(blocked_words(direction, self.name, length) for direction in self.directions)


def lost_directions(robot: Robot, q: ArrayLike, task: Task, corank: int) -> Array:
    """The k task motions lost at q: AM's u_{r+1} … u_m, turned into a readable basis (AM 2.3).

    Each row u is a unit vector of the left null space of the task Jacobian in metres and radians,

        u · (v; ω) = 0  for every twist (v; ω) = J(q) q̇  the joints can make,

    whatever the length scale of the task: with Ĵ = S J, S = diag(1/ℓ, 1), and ûᵀĴ = 0 it is u ∝ Sû. It can be read in
    two ways. As a twist (vx vy vz wx wy wz) [m/s, rad/s]: no attainable motion has a component along u; this reading
    takes 1 m and 1 rad as equal, as AM do. (An arm given in another unit, with a reach above 31.6 or below 0.032, has
    `units.counted_length` in the place of 1 m, and the rows are in it: they do not depend on the unit.) As a wrench
    (f; τ) [N, N m]: the structure carries it with no joint torque;
    this needs no such choice. The rows are orthonormal and span a space that depends on q and the task's frame only.

    Where the arm never reaches the rank m of the task (SCARA with all six rows), what is lost everywhere is left out:
    of the m − rank(q) null directions the k are returned that are farthest from the null spaces at regular
    configurations around q (orthogonal to them where those are all the same).

    Args:
        robot: the arm.
        q: (n,) a configuration of corank k [rad, m]. Where it is not singular, the k weakest directions are returned.
        task: rows and frame; the directions are in this frame, at its point, and zero in rows outside the task.
        corank: k = generic rank − rank J(q), at least 1.

    Returns:
        (k, 6) orthonormal rows.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: k is not in 1 … generic rank.
    """
    blocked, always = _blocked_wrenches(robot, one_configuration(robot, q), task, corank)
    return np.asarray(_readable(blocked[None], always[None], corank)[0])


def lost_in_sparsest_frame(robot: Robot, q: ArrayLike, task: Task, corank: int) -> FramedDirections:
    """`lost_directions` in the frame in which they have the fewest non-zero entries.

    Tried in this order, a later one only if it is strictly sparser: the task's frame; base, end effector and each
    link's axes (`Joint.frame`) at the task's point; base and end effector's axes at the origin of each link; each
    link's axes at its own origin. Change of frame is that of a wrench.

    Args, Raises: as `lost_directions`.
    """
    frames = _candidates(task.frame, len(robot.joints))
    return _simplest_frame(robot, _lost_in_frames(robot, one_configuration(robot, q), task, corank, frames), frames)


def lost_without(robot: Robot, q: ArrayLike, task: Task, coranks: Mapping[int, int]) -> dict[int, FramedDirections]:
    """`lost_in_sparsest_frame` of several joints, each standing still alone; frames are placed once for all.

    Args:
        robot, q, task: as for `lost_directions`.
        coranks: joint that stands still (from 0) -> k, which counts from the whole arm's rank.
    """
    if not coranks:
        return {}
    place, frames = one_configuration(robot, q), _candidates(task.frame, len(robot.joints))
    links, length = link_poses(robot, place), counted_as_radian(robot)
    always = _always_blocked(robot, place, task)
    by_joint: dict[int, FramedDirections] = {}
    for corank in sorted(set(coranks.values())):
        joints = [joint for joint, lost in coranks.items() if lost == corank]
        blocked = _blocked_without(robot, place, task, corank, joints)  # (J, p, 6)
        every = np.concatenate([blocked.reshape(-1, 6), always])
        seen = seen_in_frames(every, links, task.frame, frames, length)  # (F, J p + N, 6)
        many = len(joints) * blocked.shape[1]
        blocked_seen = seen[:, :many].reshape(len(frames), len(joints), -1, 6).swapaxes(0, 1)  # (J, F, p, 6)
        around = np.broadcast_to(seen[:, many:], (len(joints), len(frames), len(always), 6))
        together = len(joints) * len(frames)
        basis = _readable(blocked_seen.reshape(together, -1, 6), around.reshape(together, len(always), 6), corank)
        directions = basis.reshape(len(joints), len(frames), corank, 6)
        for joint, seen_by_frame in zip(joints, directions, strict=True):
            by_joint[joint] = _simplest_frame(robot, seen_by_frame, frames)
    return by_joint


def _lost_in_frames(robot: Robot, q: Array, task: Task, corank: int, frames: Sequence[Frame]) -> Array:
    """(F, k, 6) what is lost at q, in a readable basis of each frame."""
    blocked, always = _blocked_wrenches(robot, q, task, corank)
    every = np.concatenate([blocked, always])
    both = seen_in_frames(every, link_poses(robot, q), task.frame, frames, counted_as_radian(robot))
    return _readable(both[:, : len(blocked)], both[:, len(blocked) :], corank)


def _simplest_frame(robot: Robot, directions: Array, frames: Sequence[Frame]) -> FramedDirections:
    """Of directions (F, k, 6) in some frames those with the fewest entries that are not zero, the first of equals."""
    best = int((np.abs(directions) > ENTRY).sum(axis=(1, 2)).argmin())
    return FramedDirections(directions[best], frames[best], given_exponent(robot))


def lost_in_frame(robot: Robot, q: ArrayLike, task: Task, corank: int, frame: Frame) -> FramedDirections:
    """`lost_directions` seen in one frame of the chain, in a basis that can be read there.

    Args, Raises: as `lost_directions`; and
        frame: axes and reference point.

    Example:
        >>> from rankdrop.task import BODY
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("planar2r")
        >>> lost_in_frame(arm, [0.3, 0.0], resolve_task(None, arm), 1, BODY).directions.round(9).tolist()  # stretched
        [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
    """
    return _simplest_frame(robot, _lost_in_frames(robot, one_configuration(robot, q), task, corank, [frame]), [frame])


def lost_seen_from(robot: Robot, q: Array, task: Task, corank: int, frame: str) -> FramedDirections:
    """What is lost in axes of the base or of the tool, at the task's point, or in those of the sparsest frame.

    Args:
        robot, q, task, corank: as in `lost_directions`.
        frame: one of `FRAMES`.
    """
    if frame == "link":
        return lost_in_sparsest_frame(robot, q, task, corank)
    axes = {"base": BASE, "tool": TIP}[frame]
    return lost_in_frame(robot, q, task, corank, replace(task.frame, axes=axes))


def lost_over_family(
    robot: Robot, points: ArrayLike, task: Task, corank: int, *, frames: Sequence[Frame] | None = None
) -> FramedDirections | None:
    """Lost directions in a frame of the chain in which they are the same at every point of a family.

    An elbow loses translation along the line from shoulder to wrist: in the base it turns with joint 1, in the frame of
    the forearm it stands still. Tried are the axes of every link with the reference point of the task and with the
    origin of every link; of the frames in which the lost subspace does not move, the one with the fewest non-zero
    entries is taken, the first of equals.

    Args:
        robot: the arm.
        points: (P, n) configurations of corank k on the family [rad, m].
        task: rows and frame.
        corank: k.
        frames: those that are tried; None: `every_frame`.

    Returns:
        The directions, or None where they stand still in no frame.

    Raises:
        ConfigurationError: a point is not a configuration of this arm.
        OptionError: k is not in 1 … generic rank.
    """
    if frames is None:
        frames = every_frame(task.frame, len(robot.joints))
    else:
        frames = frames
    bases = []
    for q in np.asarray(points, dtype=np.float64):
        blocked, always = _blocked_wrenches(robot, one_configuration(robot, q), task, corank)
        wrenches = _readable(blocked[None], always[None], corank)[0]
        seen = seen_in_frames(wrenches, link_poses(robot, q), task.frame, frames, counted_as_radian(robot))
        bases.append(_orthonormal(seen))
    if not bases:
        return None
    projectors = np.stack([basis @ basis.swapaxes(1, 2) for basis in bases])  # (P, F, 6, 6)
    still = np.flatnonzero(np.abs(projectors - projectors[0]).max(axis=(0, 2, 3)) <= _STILL)
    if not len(still):
        return None
    return _simplest_frame(robot, readable_bases(bases[0][still]).swapaxes(1, 2), [frames[i] for i in still.tolist()])


def every_frame(task_frame: Frame, joints: int) -> list[Frame]:
    """The task's frame, then all axes with the task's point, then all axes with the origin of every link."""
    links = [BASE, TIP, *range(joints, 0, -1)]
    frames = [task_frame, *(replace(task_frame, axes=axes) for axes in links), *(Frame(i, i) for i in links)]
    return frames + [Frame(axes, origin) for origin in links for axes in links if axes != origin]


def seen_in_frames(
    wrenches: Array, links: Array, task_frame: Frame, frames: Sequence[Frame], length: float = 1.0
) -> Array:
    """Wrenches of the task's frame rewritten in other frames of the chain, at one configuration.

    Args:
        wrenches: (k, 6) in the frame `own`.
        links: (N + 2, 4, 4) from `link_poses`.
        own: the frame they are written in.
        frames: the F frames they are wanted in.
        length: what the wrenches are written with for a unit of length [m].

    Returns:
        (F, k, 6).
    """
    joints, every = len(links) - 2, [task_frame, *frames]
    axes = links[[link_index(frame.axes, joints, "axes") for frame in every], :3, :3]
    carriers = links[[link_index(frame.origin, joints, "point") for frame in every]]
    points = (carriers[:, :3, :3] @ np.array([frame.point for frame in every])[..., None])[..., 0] + carriers[:, :3, 3]
    turns = axes[0].T @ axes[1:]  # (F, 3, 3) columns are the new axes in the old ones
    offsets = (points[1:] - points[0]) @ axes[0] / length  # (F, 3) the new points seen from the old one
    return rewrite_wrench(wrenches, turns, offsets[:, None])


def _blocked_wrenches(robot: Robot, q: Array, task: Task, corank: int) -> tuple[Array, Array]:
    """(p, 6) all blocked wrenches at q, and (N, 6) those of regular configurations around it, one after the other."""
    there, inside = in_metres(robot), task_in_metres(task, robot)
    first = _first_blocked(there, inside, corank)
    u = decompose(there, into_metres(robot, q), inside).u
    return _wrenches(u[:, first:], there, inside), _always_blocked(robot, q, task)


def _blocked_without(robot: Robot, q: Array, task: Task, corank: int, joints: Sequence[int]) -> Array:
    """(J, p, 6) all blocked wrenches at q of the arm on which one joint stands still, for each of some (from 0)."""
    there, inside = in_metres(robot), task_in_metres(task, robot)
    first = _first_blocked(there, inside, corank)
    if robot.n == 1:
        u = np.eye(task.m)[None]
    else:
        jacobian = task_jacobian(there, into_metres(robot, q), inside)
        u = svd(np.stack([np.delete(jacobian, joint, axis=1) for joint in joints]))[0]
    return np.stack([_wrenches(lost[:, first:], there, inside) for lost in u])


def _first_blocked(robot: Robot, task: Task, corank: int) -> int:
    """Number (from 0) of the first left singular vector that counts as blocked."""
    generic = generic_rank(robot, task)
    if not 1 <= corank <= generic:
        raise OptionError("there is no such corank", got=corank, allowed=f"1 … {generic}")
    return generic - corank


def _always_blocked(robot: Robot, q: Array, task: Task) -> Array:
    """(N, 6) blocked wrenches of regular configurations around q, one after the other; none where all can be moved."""
    there, inside = in_metres(robot), task_in_metres(task, robot)
    generic = generic_rank(there, inside)
    if generic == inside.m:
        return np.zeros((0, 6))
    steps = np.random.default_rng(0).uniform(-_STEP, _STEP, (_NEIGHBOURS, there.n))
    steps *= [reach(there) if joint.kind is JointKind.PRISMATIC else 1.0 for joint in there.variables]
    around = decompose(there, into_metres(robot, q) + steps, inside).u[..., generic:]
    return np.concatenate([_wrenches(u, there, inside) for u in around])


def _wrenches(u: Array, robot: Robot, task: Task) -> Array:
    """Left singular vectors (m, p) of the scaled task Jacobian as (p, 6) wrenches: u = Sû, in all six rows; lengths in
    `counted_as_radian` ones.
    """
    rows = six_rows(u.T, task)
    rows[:, :3] *= counted_as_radian(robot) / task.scale(robot)
    return rows


def _readable(blocked: Array, always: Array, corank: int) -> Array:
    """(F, k, 6) readable bases, in F frames, of the part of span(blocked) farthest from what is blocked around q.

    Args:
        blocked: (F, p, 6) rows that span what is blocked at q.
        always: (F, N, 6) what is blocked at the neighbours, one after the other; N = 0 where nothing is.
        corank: k.
    """
    basis = _orthonormal(blocked)
    if basis.shape[2] > corank:
        groups = _orthonormal(always.reshape(len(always), _NEIGHBOURS, -1, 6))  # (F, G, 6, g)
        part = groups.swapaxes(2, 3) @ basis[:, None]
        overlap = (part.swapaxes(2, 3) @ part).sum(axis=1) / _NEIGHBOURS
        basis = basis @ np.linalg.eigh(overlap)[1][..., :corank]  # eigenvalue 1: blocked around q as well; 0: nowhere
    return readable_bases(basis).swapaxes(1, 2)


def _orthonormal(rows: Array) -> Array:
    """(..., 6, k) orthonormal columns with the span of rows (..., k, 6)."""
    return np.asarray(np.linalg.qr(rows.swapaxes(-1, -2))[0])


@lru_cache(maxsize=64)
def _candidates(task_frame: Frame, joints: int) -> tuple[Frame, ...]:
    links = range(joints, 0, -1)  # from the tip down: a point near the tip says more
    there = (Frame(axes, origin) for origin in links for axes in (BASE, TIP))
    turned = (replace(task_frame, axes=axes) for axes in (BASE, TIP, *links))
    return (task_frame, *turned, *there, *(Frame(i, i) for i in links))
