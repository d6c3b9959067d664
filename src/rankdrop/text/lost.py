"""Motions that families take away, in words: sentences, what their letters and links mean, the line of a family.

What is lost is a fact, `rankdrop.families.lost.LostFreedom`; nothing here is read from a sentence.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from rankdrop.families.lost import LostFreedom, MotionKind
from rankdrop.local.directions import LostDirection, main_axis
from rankdrop.robot.model import Robot
from rankdrop.robot.transform import cross
from rankdrop.text.directions import axis_text, frame_name, lost_text

_TWIST = "v: velocity of the tool, at the link's origin where one is named [m/s]; ω: its turning [rad/s]."
_ON = 1e-9  # farther from an axis [m], or turned by more [rad], is not on it


@lru_cache(maxsize=4096)
def lost_sentence(freedom: LostFreedom) -> str:
    """What the tool cannot do, without a subject: "cannot rotate about X of the base".

    Example:
        >>> from rankdrop.task import Frame
        >>> lost_sentence(LostFreedom((0.0, 1.0, 0.0, 0.0, 0.0, 0.0), Frame(5, 5), everywhere=False))
        'cannot translate along Y of link 5 at its origin (at the witness)'
    """
    if freedom.kind is MotionKind.TIED:
        lost = LostDirection(freedom.direction, freedom.length)
        return lost_text(lost, frame_name(freedom.frame)) + _mark(freedom)
    return f"cannot {_motion(freedom)}{_mark(freedom)}"


def lost_sentences(freedoms: Iterable[LostFreedom]) -> tuple[str, ...]:
    """One sentence for each freedom that a family takes away: see `lost_sentence`."""
    return tuple(map(lost_sentence, freedoms))


def lost_line(freedom: LostFreedom) -> str:
    """The same as a line of its own: "lost: rotate about X of the base"; a tie is a sentence already."""
    if freedom.kind is MotionKind.TIED:
        return lost_sentence(freedom)
    return f"lost: {_motion(freedom)}{_mark(freedom)}"


def _motion(freedom: LostFreedom) -> str:
    """The motion of one that is no tie: "translate along Y of link 5 at its origin"."""
    frame = frame_name(freedom.frame)
    if freedom.kind is MotionKind.TRANSLATION:
        return f"translate along {axis_text(freedom.direction[:3])} of {frame}"
    return f"rotate about {axis_text(freedom.direction[3:])} of {frame}"


def _mark(freedom: LostFreedom) -> str:
    if freedom.everywhere:
        return ""
    return " (at the witness)"


def lost_note(robot: Robot, freedoms: Iterable[LostFreedom]) -> str:
    """What letters and links in sentences on lost motions mean; links by the joint axes, which everybody knows.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import Frame
        >>> along_y = LostFreedom((0.0, 1.0, 0.0, 0.0, 0.0, 0.0), Frame(5, 5), everywhere=True)
        >>> lost_note(open_robot("pa10"), [along_y])
        'Link 5 moves with joint 5: Y along axis 5, origin where axes 5, 6 and 7 meet.'
    """
    axes: set[tuple[int, int]] = set()  # link, axis (0 X, 1 Y, 2 Z)
    origins: set[int] = set()
    notes: list[str] = []
    for freedom in freedoms:
        frame = freedom.frame
        if freedom.kind is MotionKind.TIED:
            notes = [_TWIST]
        if frame.axes > 0:
            axes |= {(frame.axes, axis) for axis in _axes_named(freedom)}
        if frame.origin > 0 and not any(frame.point):
            origins.add(frame.origin)
    links = {link for link, _ in axes} | origins
    notes += (_link_note(robot, number, axes, number in origins) for number in sorted(links))
    return " ".join(notes)


def _link_note(robot: Robot, number: int, axes: set[tuple[int, int]], origin: bool) -> str:
    """What the axes of a link mean that sentences name, and with `origin` where its origin is."""
    said = [_axis_words(robot, number, axis) for axis in range(3) if (number, axis) in axes]
    if origin:
        said.append(_through(robot, number))
    return _link(robot, number, [words for words in said if words])


def _axes_named(freedom: LostFreedom) -> tuple[int, ...]:
    """Axes of the frame (0 X, 1 Y, 2 Z) that the sentence speaks of: the one it names, else all three."""
    if freedom.kind is MotionKind.TIED:
        return 0, 1, 2
    if freedom.kind is MotionKind.TRANSLATION:
        part = freedom.direction[:3]
    else:
        part = freedom.direction[3:]
    axis, along = main_axis(part)
    return (axis,) if along else (0, 1, 2)


def _link(robot: Robot, number: int, said: list[str]) -> str:
    """ "Link 5 moves with joint 5: Y along axis 5."."""
    joint = robot.joints[number - 1]
    if joint.name != f"joint{number}":
        own = f", {joint.name}"
    else:
        own = ""
    called = f" ({joint.link})" if joint.link else ""
    details = f": {', '.join(said)}" if said else ""
    return f"Link {number}{called} moves with joint {number}{own}{details}."


def _axis_words(robot: Robot, number: int, axis: int) -> str:
    """ "Y along axis 5", of the joints on both sides of a link, which stand still in it; empty where neither is."""
    way = robot.joints[number - 1].frame[:3, axis]
    for place, joint in enumerate(robot.joints[number - 1 : number + 1], number):
        if np.abs(cross(way, joint.axis)).max() < _ON:
            return f"{'XYZ'[axis]} along axis {place}"
    return ""


def _through(robot: Robot, number: int) -> str:
    """ "origin where axes 5, 6 and 7 meet": turning axes through a link's origin at every configuration.

    An axis farther off passes through it always if those between do, which then leave the origin where it is.
    """
    origin = robot.joints[number - 1].frame[:3, 3]
    passages = []
    for places in (range(number, 0, -1), range(number + 1, len(robot.joints) + 1)):
        for place in places:
            joint = robot.joints[place - 1]
            if joint.slides or np.abs(cross(joint.foot - origin, joint.axis)).max() > _ON:
                break
            passages.append(place)
            if abs(joint.pitch) > _ON:
                break
    passages.sort()
    if passages:
        listed = " and ".join(filter(None, (", ".join(map(str, passages[:-1])), str(passages[-1]))))
    else:
        listed = ""
    if len(passages) > 1:
        return f"origin where axes {listed} meet"
    if passages:
        return f"origin on axis {listed}"
    return ""
