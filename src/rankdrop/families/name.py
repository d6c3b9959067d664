"""The name of a family as facts: parts of the arm, what its axes have in common, joints with a condition, values.

Words are made of them in `rankdrop.text.names`. Files hold the facts, entry `called`, and the words for their readers.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Flag, StrEnum, auto
from math import pi

from rankdrop.local.dependence import Dependence
from rankdrop.sections import words_of

_DECIMALS = 10  # of values: the same with every library of linear algebra
_RIGHT = 1e-5  # an angle that differs by less from a multiple of a right one is one, in right angles


class ArmPart(StrEnum):
    """A part of an arm, from the base to the tool."""

    SHOULDER = "shoulder"
    ELBOW = "elbow"
    WRIST = "wrist"


class Geometry(StrEnum):
    """A relation of axes that holds on a family, and not everywhere.

    The groups of joints in `Detail.joints`: of ALIGNED one or more groups, each on one line of its own; of AGAINST the
    axes that are parallel to a bundle, then the bundle; of AXES_MEET_IN_PLANE the two axes that meet, then those of the
    plane; of CENTRE_IN_PLANE those of the plane; of STRETCHED, NEARLY_STRETCHED, LINE_MEETS_ALL and LINE_THROUGH_TIP
    none; else one group.
    """

    STRETCHED = "arm stretched or folded"
    NEARLY_STRETCHED = "as long or as short as the offsets of its wrist allow"
    ALIGNED = "on one line"
    PARALLEL = "parallel"
    PERPENDICULAR = "perpendicular"
    AGAINST = "parallel to a bundle"
    COPLANAR = "in one plane"
    PARALLEL_AND_COPLANAR = "parallel in one plane"
    COPLANAR_WITH_CENTRE = "in one plane with a centre"
    CENTRE_ON_AXIS = "centre on an axis"
    CENTRE_IN_PLANE = "centre in a plane"
    AXES_MEET_IN_PLANE = "two axes meet in a plane"
    LINE_MEETS_ALL = "one line meets all axes"
    LINE_THROUGH_TIP = "one line through the tip meets all axes"


class Centre(StrEnum):
    """A point of the arm that a detail is about."""

    WRIST = "wrist centre"
    TIP = "tip"


class Plane(StrEnum):
    """The plane through axis 1 along axis 2."""

    OF_BOTH = "axes 1 and 2 meet"
    PARALLEL = "axis 2 passes axis 1"


@dataclass(frozen=True, slots=True)
class Detail:
    """One thing that is true of the axes.

    Attributes:
        geometry: the relation.
        joints: groups of joints, from 0: see `Geometry`.
        centre, plane: of a geometry that speaks of one.
        brief: a relation that stands after others: "2 ∥ 4".
    """

    geometry: Geometry
    joints: tuple[tuple[int, ...], ...] = ()
    centre: Centre | None = None
    plane: Plane | None = None
    brief: bool = False


_GROUPS = {
    Geometry.STRETCHED: 0, Geometry.NEARLY_STRETCHED: 0, Geometry.LINE_MEETS_ALL: 0, Geometry.LINE_THROUGH_TIP: 0,
    Geometry.AGAINST: 2, Geometry.AXES_MEET_IN_PLANE: 2,
}  # fmt: skip
"""Groups of joints that a relation has; every other relation has one, `ALIGNED` one or more."""
_OF_CENTRE = {Geometry.COPLANAR_WITH_CENTRE, Geometry.CENTRE_ON_AXIS, Geometry.CENTRE_IN_PLANE}
_OF_PLANE = {Geometry.CENTRE_IN_PLANE, Geometry.AXES_MEET_IN_PLANE}
_BRIEF = {Geometry.PARALLEL, Geometry.PERPENDICULAR}


def is_whole(detail: Detail) -> bool:
    """Whether a detail has the groups of joints, the centre and the plane of its geometry, and no other.

    Example:
        >>> is_whole(Detail(Geometry.COPLANAR, ((1, 2),))), is_whole(Detail(Geometry.COPLANAR))
        (True, False)
    """
    geometry, groups = detail.geometry, len(detail.joints)
    enough = groups == _GROUPS.get(geometry, 1) or (geometry is Geometry.ALIGNED and groups > 1)
    return (
        enough
        and all(detail.joints)
        and (detail.centre is not None) == (geometry in _OF_CENTRE)
        and (detail.plane is not None) == (geometry in _OF_PLANE)
        and (not detail.brief or geometry in _BRIEF)
    )


@dataclass(frozen=True, slots=True)
class LowRank:
    """All joint screws (`full`: of the pose; else columns of the task) have this rank, and no smaller set is known."""

    joints: int
    rank: int
    full: bool


@dataclass(frozen=True, slots=True)
class Variable:
    """A joint by its number, counted from 1."""

    number: int
    slides: bool = False


@dataclass(frozen=True, slots=True)
class JointValues:
    """Values of a joint that tell the posture, in increasing order [rad; of a slide m], to ten decimals."""

    joint: Variable
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", tuple(round(value, _DECIMALS) + 0.0 for value in self.values))


def is_right(angle: float) -> bool:
    """Whether an angle is a multiple of a right one."""
    return abs(angle / (pi / 2) - round(angle / (pi / 2))) <= _RIGHT


class Shorter(Flag):
    """How a long name saves characters."""

    NOTHING = 0
    PLUS_MINUS = auto()  # ±30° for −30° or 30°
    STRETCHED = auto()  # of two axes in one plane with a centre
    CONDITION_WITHOUT_WITH = auto()
    FIRST_OF_TWO = auto()  # parallel, for parallel and coplanar
    WHOLE_DEGREES = auto()
    CONDITION_WITHOUT_JOINTS = auto()


@dataclass(frozen=True, slots=True)
class FamilyName:
    """The name of a family.

    Attributes:
        parts: of the arm that are concerned.
        independent: each part loses one freedom by itself, which their names tell; `details` join them.
        details: relations of the axes; of dependent joint screws where that has no part of the arm.
        bound: joints with a condition that the details do not tell.
        values: of single joints.
        condition: one that tells this family from others of the same name, as it is written in formulas.
        ordinal: its number among those, from 1, where no short condition does; 0: none.
        shorter: how its words save characters.
        meeting: of the families that meet in the place, if it is one of several.
        unnamed: points without a condition.
        given: the words, of a name of which a file holds no facts: a user's own, or written up to version 0.2.

    Example:
        >>> name = FamilyName((ArmPart.WRIST,), details=(Detail(Geometry.ALIGNED, ((3, 5),)),))
        >>> str(name), name.short
        ('wrist: axes 4 and 6 aligned', 'wrist')
    """

    parts: tuple[ArmPart, ...] = ()
    independent: bool = False
    details: tuple[Detail | LowRank | Dependence, ...] = ()
    bound: tuple[Variable, ...] = ()
    values: tuple[JointValues, ...] = ()
    condition: str = ""
    ordinal: int = 0
    shorter: Shorter = Shorter.NOTHING
    meeting: tuple[FamilyName, ...] = ()
    unnamed: bool = False
    given: str = ""

    def __str__(self) -> str:
        """In words."""
        words: str = words_of(self).name_words(self)
        return words

    @property
    def short(self) -> str:
        """In words, without the part that says which axes where a part of the arm is named."""
        words: str = words_of(self).short_name(self)
        return words
