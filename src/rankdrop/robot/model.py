"""The robot as data: an ordered list of joint screws at q = 0, the home pose, what is known about each joint.

And the numbers that decide its Jacobian, to know it by; names, limits, link frames, notes stay out of these.
`fingerprint` holds every bit, for a proof that must not be used for another arm; `coarse_fingerprint` finds the same
arm read from another file, where the last digits differ. Last, what people are told of its links and joints: by names
and by the joint axes; and the arm with a tool at its tip.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from fractions import Fraction
from functools import cached_property, wraps
from math import inf, lcm
from typing import Any, TypeVar, TypeVarTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.errors import HIDDEN, RobotError
from rankdrop.robot.files import LARGEST_LENGTH, LONGEST_NAME, MOST_JOINTS, MOST_STEPS, allowed_range
from rankdrop.robot.note import RobotNote, as_note
from rankdrop.robot.quantities import checked_lengths
from rankdrop.robot.transform import Array as Array  # the name that all others take from here
from rankdrop.robot.transform import dot, from_xyz_rpy, norm, times, unmasked
from rankdrop.sections import html, words_of

MOST_TURNS = 12
"""Largest common denominator of the multipliers of joints that follow another one which is looked for."""
_SAME_RATIO = 1e-12  # multipliers that differ by less are one, rounded differently

_Given = TypeVarTuple("_Given")
_Made = TypeVar("_Made")

GRID = 1e-9
"""Numbers that agree to this have one coarse fingerprint [1, m]."""

_BEYOND = 1e-9  # a joint at its limit is inside [rad, m]

TOOL = "tool point"
"""What the tip of an arm with a tool is called."""


class JointKind(StrEnum):
    """What one joint does: turn about its axis, slide along it, or both at a fixed pitch."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"
    HELICAL = "helical"

    @property
    def measure(self) -> str:
        """What its variable is: "length", or "angle"."""
        if self is JointKind.PRISMATIC:
            return "length"
        return "angle"


def screw_of(kind: JointKind, axis: Array, point: Array, pitch: float = 0.0) -> Array:
    """(6,) screw of a joint along or about a unit axis (3,) through a point (3,) [m], linear part first."""
    if kind is JointKind.PRISMATIC:
        return np.concatenate([axis, np.zeros(3)]) + 0.0  # + 0.0 turns −0 into 0
    return np.concatenate([np.cross(point, axis) + pitch * axis, axis]) + 0.0


@dataclass(frozen=True, slots=True)
class Mimic:
    """Joint value = multiplier · (value of the joint named `leader`) + offset."""

    leader: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Source:
    """Where a robot came from: `kind` (dh, screws, urdf …), `origin` (file, URL or call), `reference` (document)."""

    kind: str
    origin: str = ""
    reference: str = ""


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint of the chain.

    Attributes:
        name: unique in the chain.
        kind: revolute [rad], prismatic [m] or helical [rad].
        screw: (6,) twist (v; ω) of the joint at q = 0 in the base frame, linear part first, reference point at the
            base origin. Revolute: (p × ω; ω), |ω| = 1, p any point on the axis. Prismatic: (v; 0), |v| = 1.
            Helical with pitch h [m/rad]: (p × ω + hω; ω).
        lower, upper: limits [rad or m]; ±inf where the source gives none.
        velocity: largest joint rate [rad/s or m/s]; inf where the source gives none.
        frame: (4, 4) pose at q = 0, in the base frame, of the frame carried by the link after this joint
            (DH frame, URDF child link; else a frame on the axis).
        mimic: set when the joint follows another one; it is then not a variable of its own.
        link: name of the link after this joint in the file; empty where it gives none.
    """

    name: str
    kind: JointKind
    screw: Array  # (6,)
    lower: float = -inf
    upper: float = inf
    velocity: float = inf
    frame: Array = field(default_factory=lambda: np.eye(4))  # (4, 4)
    mimic: Mimic | None = None
    link: str = ""

    def __post_init__(self) -> None:
        where = f"joint {self.name!r}"
        for label in (self.name, self.link):
            _check_name(label, where)
        screw = _read_only(self.screw, (6,), where, "screw")
        object.__setattr__(self, "kind", JointKind(self.kind))
        axis = screw[:3] if self.slides else screw[3:]
        length = norm(axis)
        if length < 1e-9:
            raise RobotError("the axis has no length", where=where, got=axis.tolist(), allowed="a non-zero axis")
        if self.slides and np.abs(screw[3:]).max() > 0:
            raise RobotError("a prismatic screw has no angular part", where=where, got=screw.tolist())
        if abs(length - 1.0) > 1e-15:
            screw = _read_only(screw / length, (6,), where, "screw")
        object.__setattr__(self, "screw", screw)
        object.__setattr__(self, "frame", _read_only(self.frame, (4, 4), where, "frame"))
        if not self.slides:
            _check_size(screw[:3], where, "the moment of the axis about the base origin")
        _check_size(self.frame[:3, 3], where, "the place of the joint")
        for label in ("lower", "upper", "velocity"):
            value = float(getattr(self, label))
            if np.isnan(value):
                raise RobotError(f"{label} is not a number", where=where, got=value, allowed="a number or ±inf")
            object.__setattr__(self, label, value)
        if self.lower > self.upper:
            raise RobotError(
                "lower limit above upper limit", where=where, got=f"lower {self.lower}, upper {self.upper}",
                allowed="lower ≤ upper", mend="exchange or correct the two limits",
            )

    @property
    def unit(self) -> str:
        """Unit of the joint's variable: "rad", or "m" for a prismatic joint."""
        return "m" if self.slides else "rad"

    @property
    def slides(self) -> bool:
        """Whether the joint is prismatic."""
        return self.kind is JointKind.PRISMATIC

    @property
    def axis(self) -> Array:
        """(3,) unit direction of the axis at q = 0."""
        if self.slides:
            return self.screw[:3]
        return self.screw[3:]

    @property
    def foot(self) -> Array:
        """(3,) point of the axis nearest to the base origin at q = 0; of a slide, the origin of its frame [m]."""
        if self.slides:
            return self.frame[:3, 3]
        return np.cross(self.screw[3:], self.screw[:3])

    @property
    def pitch(self) -> float:
        """Of a helical joint [m/rad]; 0 for the others."""
        if self.kind is JointKind.HELICAL:
            return dot(self.screw[:3], self.screw[3:])
        return 0.0

    @property
    def driver(self) -> str:
        """Name of the variable that moves the joint: its value is multiplier · variable + offset."""
        if self.mimic is None:
            return self.name
        return self.mimic.leader

    @property
    def multiplier(self) -> float:
        """1 for a variable of its own."""
        if self.mimic is None:
            return 1.0
        return self.mimic.multiplier

    @property
    def offset(self) -> float:
        """0 for a variable of its own [rad or m]."""
        if self.mimic is None:
            return 0.0
        return self.mimic.offset


@dataclass(frozen=True, eq=False)
class Robot:
    """A serial chain. Immutable; arrays are read-only; equality is identity.

    Pose of the tip: T(q) = exp(S_1 q_1) … exp(S_N q_N) · home.

    Attributes:
        name: of the arm.
        joints: the N moving joints from base to tip, mimic joints included.
        home: (4, 4) pose of the tip at q = 0 in the base frame.
        task: name of the task (see `rankdrop.task`) that the arm is made for.
        source: where the numbers come from.
        base, tip: names of the first and last link, where the source has names.
        notes: what a reader of the description should be told (choices made, things tolerated); a text becomes one.
        about: one line for lists ("7-DoF arm, spherical shoulder and wrist").
        lengths: letters and their values [m]: exact conditions write lengths of ± such a value with its letter.
        exponent: of an arm in its own unit of length (`rankdrop.units`): its lengths are those of the arm that was
            given, divided by 10 to this power. None for an arm as it was given.
    """

    name: str
    joints: tuple[Joint, ...]
    home: Array = field(default_factory=lambda: np.eye(4))  # (4, 4)
    task: str = "pose"
    source: Source = Source("python")
    base: str = "base"
    tip: str = "tip"
    notes: tuple[RobotNote, ...] = ()
    about: str = ""
    lengths: tuple[tuple[str, float], ...] = ()
    exponent: int | None = None

    def __post_init__(self) -> None:
        where = f"robot {self.name!r}"
        for label in (self.name, self.base, self.tip):
            _check_name(label, where)
        object.__setattr__(self, "joints", tuple(self.joints))
        object.__setattr__(self, "notes", tuple(map(as_note, self.notes)))
        object.__setattr__(self, "home", _read_only(self.home, (4, 4), where, "home pose"))
        _check_size(self.home[:3, 3], where, "the place of the tip")
        lengths = checked_lengths(self.lengths, lambda letter: f"{where}, length {letter!r}")
        object.__setattr__(self, "lengths", lengths)
        if not self.joints:
            raise RobotError("there is no moving joint", where=where, allowed="at least one", mend="name another tip")
        check_joints(len(self.joints), where)
        names = [joint.name for joint in self.joints]
        for name in names:
            if names.count(name) > 1:
                raise RobotError("two joints have the same name", where=where, got=repr(name), mend="rename one")
        leaders = {joint.name for joint in self.joints if joint.mimic is None}
        for joint in self.joints:
            if joint.mimic is not None and joint.mimic.leader not in leaders:
                raise RobotError(
                    "a mimic joint follows a joint that is not a variable of the chain",
                    where=f"{where}, joint {joint.name!r}", got=repr(joint.mimic.leader),
                    allowed=", ".join(sorted(leaders)),
                )

    @cached_property
    def variables(self) -> tuple[Joint, ...]:
        """The n joints that are variables of their own: the entries of q, in order."""
        return tuple(joint for joint in self.joints if joint.mimic is None)

    @cached_property
    def n(self) -> int:
        """Number of variables."""
        return len(self.variables)

    @cached_property
    def drivers(self) -> tuple[int, ...]:
        """(N,) place in q of the variable that moves each joint."""
        place = {joint.name: number for number, joint in enumerate(self.variables)}
        return tuple(place[joint.driver] for joint in self.joints)

    @property
    def units(self) -> list[str]:
        """Of the variables: "rad" or "m"."""
        return [joint.unit for joint in self.variables]

    @cached_property
    def lower(self) -> Array:
        """(n,) lower limits [rad or m]."""
        return _read_only_array([joint.lower for joint in self.variables])

    @cached_property
    def upper(self) -> Array:
        """(n,) upper limits [rad or m]."""
        return _read_only_array([joint.upper for joint in self.variables])

    @cached_property
    def periodic(self) -> NDArray[np.bool_]:
        """(n,) whether adding 2π to a variable gives the same arm: revolute, and so is all that follows it."""
        whole = [joint.kind is JointKind.REVOLUTE for joint in self.variables]
        for joint, driver in zip(self.joints, self.drivers, strict=True):
            whole[driver] &= joint.kind is JointKind.REVOLUTE and float(joint.multiplier).is_integer()
        return _read_only_array(whole)

    @cached_property
    def turns(self) -> NDArray[np.int64]:
        """(n,) turns of a variable after which the arm is the same; 0: it slides, or no number up to `MOST_TURNS` does.

        A joint that follows it by −1/2 or 2/3 turns a whole number of times in 2 or 3 turns of its leader.
        """
        turns = [1] * self.n
        for joint, driver in zip(self.joints, self.drivers, strict=True):
            share = Fraction(joint.multiplier).limit_denominator(MOST_TURNS)
            turns[driver] = lcm(turns[driver], share.denominator)
            if joint.kind is not JointKind.REVOLUTE or abs(float(share) - joint.multiplier) > _SAME_RATIO:
                turns[driver] = 0
            if turns[driver] > MOST_TURNS:
                turns[driver] = 0
        return _read_only_array(turns)

    def _repr_html_(self) -> str:
        """For notebooks: the joints with their kinds and limits, angles in degrees."""
        return html(words_of(self).sections_of(self))


def once(function: Callable[[Robot, *_Given], _Made]) -> Callable[[Robot, *_Given], _Made]:
    """A function of a robot and other arguments (hashable, by position) that computes each value once for a robot.

    Robots never change; values are forgotten with the robot.
    """
    known: WeakKeyDictionary[Robot, dict[Hashable, _Made]] = WeakKeyDictionary()

    @wraps(function)
    def compute(robot: Robot, *given: *_Given) -> _Made:
        values = known.get(robot)
        if values is None:
            values = known[robot] = {}
        if given not in values:
            values[given] = function(robot, *given)
        return values[given]

    return compute


def _read_only_array(values: list[Any]) -> NDArray[Any]:
    array = np.array(values)
    array.flags.writeable = False
    return array


def check_joints(moving: int, where: str, *, steps: int = 0) -> None:
    """Refuse a chain that is longer than any arm, before anything is computed of it.

    Args:
        moving: joints that move.
        where: file or robot.
        steps: all joints of the chain.

    Raises:
        RobotError: more than `MOST_JOINTS` or `MOST_STEPS`.
    """
    for got, most, what in ((moving, MOST_JOINTS, "moving joints"), (steps, MOST_STEPS, "joints")):
        if got > most:
            raise RobotError(f"the chain has too many {what}", where=where, got=got, allowed=f"at most {most}",
                             mend="name a base and a tip of a shorter chain")  # fmt: skip


def _check_name(name: str, where: str) -> None:
    """Refuse names that steer a terminal or break its lines, and those too long for the name of a file."""
    if "\n" in name or "\t" in name or name.translate(HIDDEN) != name:
        raise RobotError("the name has a control character", where=where, got=repr(name[:80]),
                         allowed="what can be printed in one line", mend="rename it")  # fmt: skip
    if len(name.encode("utf-8", "surrogatepass")) > LONGEST_NAME:
        raise RobotError("the name is too long", got=name, allowed=f"at most {LONGEST_NAME} bytes", mend="shorten it")


def _check_size(place: Array, where: str, what: str) -> None:
    """Refuse numbers beyond the range of a length: their squares would leave that of the doubles."""
    if np.abs(place).max() > LARGEST_LENGTH:
        raise RobotError(f"{what} is too large", where=where, got=place.tolist(), allowed=allowed_range("length"))


def _read_only(value: ArrayLike, shape: tuple[int, ...], where: str, what: str) -> Array:
    array = np.array(unmasked(value, what), dtype=np.float64)
    if array.shape != shape:
        raise RobotError(f"{what} has the wrong shape", where=where, got=array.shape, allowed=shape)
    if not np.isfinite(array).all():
        raise RobotError(f"{what} has values that are not finite", where=where, got=array.tolist())
    array.flags.writeable = False
    return array


def geometry(robot: Robot, *, tip: bool = True) -> Array:
    """All numbers that decide the Jacobian: screws, then home pose, then multipliers and offsets of mimic joints.

    Without the `tip`, those that decide the rank of its six rows: another tip adds ω × r to the translation.
    """
    parts = [joint.screw for joint in robot.joints] + [robot.home.reshape(-1)] * tip
    parts += [np.array([joint.mimic.multiplier, joint.mimic.offset]) for joint in robot.joints if joint.mimic]
    return np.concatenate(parts)


def fingerprint(robot: Robot) -> str:
    """SHA-256 of kinds, mimic relations and `geometry`; 64 hex digits.

    −0.0 counts as 0.0; any other difference, even of rounding, gives another fingerprint.
    """
    numbers = (geometry(robot) + 0.0).astype("<f8")
    return hashlib.sha256(_structure(robot) + numbers.tobytes()).hexdigest()


def coarse_fingerprint(robot: Robot, *, tip: bool = True) -> str:
    """24 hex digits, equal for arms that agree to `GRID` (but for numbers on the edge of a cell); see `geometry`."""
    cells = np.rint(np.clip(geometry(robot, tip=tip), -1e9, 1e9) / GRID).astype("<i8")
    return hashlib.sha256(_structure(robot) + cells.tobytes()).hexdigest()[:24]


def _structure(robot: Robot) -> bytes:
    index = {joint.name: i for i, joint in enumerate(robot.joints)}
    parts = [(str(joint.kind), index[joint.mimic.leader] if joint.mimic else -1) for joint in robot.joints]
    return repr(parts).encode()


def joints_beyond_limits(robot: Robot, q: Sequence[float]) -> tuple[int, ...]:
    """Numbers of the joints, from 1, that a configuration has beyond their limits: a family may have no others.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> joints_beyond_limits(open_robot("panda"), [0.0, 0.0, 0.0, 0.0, 0.0, 1.5, 0.0])
        (4,)
    """
    at = np.asarray(q, dtype=np.float64)
    beyond = (at < robot.lower - _BEYOND) | (at > robot.upper + _BEYOND)
    return tuple(int(place) + 1 for place in np.flatnonzero(beyond))


def first_joint_beyond_limit(robot: Robot, rows: Array) -> int:
    """Index of the joint beyond its limit in the first row (K, n) that has one; −1 for none."""
    beyond = np.argwhere((rows < robot.lower - _BEYOND) | (rows > robot.upper + _BEYOND))
    if len(beyond):
        return int(beyond[0, 1])
    return -1


def with_tool(robot: Robot, xyz: ArrayLike, rpy: Sequence[float] = (0.0, 0.0, 0.0)) -> Robot:
    """The arm with its end effector at a tool point: T(q) = exp(S_1 q_1) … exp(S_N q_N) · home · tool.

    Singularities of the full pose stay where they are; what is lost is told at the new point.

    Args:
        robot: the arm.
        xyz: (3,) the point, from the arm's tip in its axes [m].
        rpy: roll, pitch, yaw of the tool's axes in those of the tip [rad], as in URDF.

    Raises:
        RobotError: not three finite numbers each.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> with_tool(open_robot("planar2r"), (0.1, 0, 0)).home[:3, 3].tolist()
        [1.8, 0.0, 0.0]
    """
    point, turn = (np.array(unmasked(given, "the tool"), dtype=np.float64) for given in (xyz, rpy))
    for values, what in ((point, "x, y, z"), (turn, "roll, pitch, yaw")):
        if values.shape != (3,) or not np.isfinite(values).all():
            raise RobotError("this is no tool point", got=values.tolist(), allowed=f"three finite numbers {what}")
    tool = from_xyz_rpy(point.tolist(), turn.tolist())
    return replace(robot, home=times(robot.home, tool), tip=TOOL)
