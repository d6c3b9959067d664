"""Tables of what every file holds: the arm, its task, tolerances, how near an ideal arm is."""

from __future__ import annotations

from operator import attrgetter, itemgetter
from typing import Any, Literal

from msgspec import UNSET

from rankdrop.codec import Positive, list_of, mapping, nonempty, num, optional, row, table, whole
from rankdrop.cover.ball import ModelTolerance
from rankdrop.families.record import Pin
from rankdrop.robot.ideal import near_ideal
from rankdrop.robot.model import Joint, Mimic, Source
from rankdrop.task import Frame
from rankdrop.text.robots import near_text
from rankdrop.tolerances import Tolerances
from rankdrop.units import WRITTEN

UNITS = table("units", angle=str, length=str, time=str, joint=str, distance=str)

JOINTS = table(
    "joints",
    name=str,
    number=(Positive, "counted from 1"),
    kind=Literal["revolute", "prismatic", "helical"],
    lower=(num("joint") | None, "lower limit [rad or m]; null: none given"),
    upper=(num("joint") | None, "upper limit [rad or m]; null: none given"),
)
SOURCE = table("source", of=Source)
FRAME = table("frame", of=Frame, axes=whole(ge=-1), origin=whole(ge=-1), point=row(num("m"), 3))
MIMIC = table("mimic", of=Mimic, multiplier=num("ratio"), offset=num("joint"))
CHAIN = table(
    "chain",
    of=Joint,
    kind=Literal["revolute", "prismatic", "helical"],
    screw=row(num("screw"), 6),
    lower=num("joint") | None,
    upper=num("joint") | None,
    velocity=num("joint/s") | None,
    frame=row(row(num("pose"), 4), 4),
    link=(optional(str), "name of the link after the joint, where the file gives one",
        lambda joint: joint.link or UNSET),
)
NEAR = table(
    "near",
    text=(str, "what it has, and how near it is", near_text),
    length=(num("m", ge=0), "largest change of a length on the way to it [m]"),
    angle=(num("rad", ge=0), "largest change of an angle [rad]"),
    ideal=(str, "what the option --ideal takes to find it", attrgetter("tolerance.text")),
)

ARM_OF = attrgetter("robot", "task", "generic_rank")  # what `ROBOT` is made of

TOLERANCES = table(
    "tolerances",
    of=Tolerances,
    singular=num("1", gt=0),
    target=num("1", gt=0),
    stationary=num("1", gt=0),
    block_rank=num("1/distance", gt=0),
    tangent=num("1", gt=0),
    value=num("joint", gt=0),
    fit_gap=num("1", gt=0),
    coefficient=num("1", gt=0),
    explained=num("distance", gt=0),
)
PINNED = table("pinned", of=Pin, number=Positive, values=nonempty(num("joint")))
INSIDE_PINNED = table("inside_pinned", number=Positive, values=list_of(num("joint")))
TOLERANCE = table(
    "tolerance",
    of=ModelTolerance,
    text=str,
    length=num("m", gt=0) | None,
    angle=num("rad", gt=0) | None,
)
MOVED = table(
    "moved",
    name=str,
    kind=Literal["twist", "angle", "distance", "offset", "base", "tip"],
    joints=nonempty(Positive),
    before=num("entry"),
    after=num("entry"),
    by=num("entry", ge=0),
    text=str,
)


def file(kind: str, about: str, /, **entries: Any) -> Any:
    """The table of a kind of file: `schema` and `units` first, then its entries; `units=None` leaves units out."""
    told = "units of the numbers of this file; the unit of each entry: `unit` of this schema"
    schema = f"rankdrop/{kind}/1"
    units = (optional(UNITS), told, lambda _: WRITTEN)
    return table(f"{kind}_file", about, schema=(Literal[schema], "", lambda _: schema), **{"units": units} | entries)


def _attribute_of(index: int, name: str) -> Any:
    """Attribute of one of (robot, task, generic rank)."""
    return lambda arm: getattr(arm[index], name)


def _joints(arm: Any) -> list[dict[str, Any]]:
    return [
        {"name": joint.name, "number": number, "kind": str(joint.kind), "lower": joint.lower, "upper": joint.upper}
        for number, joint in enumerate(arm[0].variables, start=1)
    ]


ROBOT = table(
    "robot",
    name=(str, "", _attribute_of(0, "name")),
    n=(Positive, "number of joint variables: length of q", _attribute_of(0, "n")),
    task=(str, "name of the task, or its rows joined by commas", _attribute_of(1, "name")),
    generic_rank=(whole(ge=0, le=6),
        "rank of the task Jacobian almost everywhere; corank k is rank generic_rank − k", itemgetter(2)),
    joints=(list_of(JOINTS), "the joint variables, in the order of q", _joints),
    base=(str, "first link", _attribute_of(0, "base")),
    tip=(str, "last link", _attribute_of(0, "tip")),
    about=(str, "", _attribute_of(0, "about")),
    lengths=(optional(mapping(num("m", gt=0))),
        "letters that exact conditions write lengths with, and their values [m]; absent where the robot has none",
        lambda arm: dict(arm[0].lengths) or UNSET),
    notes=(list_of(str), "choices made and things tolerated while reading the description",
        lambda arm: tuple(map(str, arm[0].notes))),
    near=(optional(NEAR),
        "where an ideal arm is near: the nearest one with axes exactly parallel, square and intersecting",
        lambda arm: near_ideal(arm[0]) or UNSET),
    source=(SOURCE, "where the numbers come from", _attribute_of(0, "source")),
    made_for=(str, "task the description names", _attribute_of(0, "task")),
    frame=(FRAME, "frame of the task", _attribute_of(1, "frame")),
    rows=(nonempty(whole(ge=0, le=5)), "rows of the twist (vx, vy, vz, wx, wy, wz) in the task, counted from 0",
        _attribute_of(1, "rows")),
    home=(row(row(num("pose"), 4), 4), "pose of the tip at q = 0 in the base frame", _attribute_of(0, "home")),
    chain=(nonempty(CHAIN), "every moving joint, mimic joints included, as screws (v; ω) at q = 0 in the base frame",
        _attribute_of(0, "joints")),
)
