"""Directions of the tool that are lost at a configuration, and those that the arm never has."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rankdrop.codec import Record
from rankdrop.local.directions import FramedDirections, constraint, in_short, is_nearly_pure
from rankdrop.results.explanation import Explanation
from rankdrop.robot.model import Robot
from rankdrop.sections import Formula, Section
from rankdrop.task import BASE, TIP
from rankdrop.text.words import (
    pitch_text,
    short,
    vector,
    wrench_text,
)
from rankdrop.units import counted_length

_FEWER = "a task with fewer rows (planar, position, …) asks only for what the arm is made for"
_TWIST = "v [m/s], ω [rad/s]: velocity and turning of the tool"
_COUNTED = "nearly: turning by 1 rad counts as much as moving by 1 m"


def focus_words(explanation: Explanation) -> str:
    """Where losses are taken; "" at the configuration itself."""
    if np.array_equal(explanation.focus, explanation.q):
        return ""
    return "at the nearest singular configuration"


def lost_sections(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Motions that remain, in each frame, and with `full` the lost twists and their wrenches."""
    lost = explanation.lost
    if lost.framed is None:
        return
    if explanation.far.near_miss is not None and not explanation.rank.corank:
        can, torque = "can hardly move other than", "with hardly any joint torque"
    else:
        can, torque = "can only move", "without joint torque"
    seen = [framed for frame, framed in lost.seen.items() if full or frame != "link"] or lost.seen.values()
    lines = [f"The tool {can} so that"]
    for framed in seen:
        lines += _remaining(explanation.robot, framed, full)
    if full:
        lines += _screws(explanation, torque)
    if explanation.rank.corank:
        title = "What is lost"
    else:
        title = "What is nearly lost"
    notes = [_TWIST]
    if full and any(_has_nearly_pure(framed) for framed in seen):
        notes.append(_COUNTED)
    yield Section(title, focus_words(explanation), tuple(lines), notes=tuple(notes))


def _remaining(robot: Robot, framed: FramedDirections, full: bool) -> Iterator[str]:
    """What all motions that remain obey, in one frame; with `full` also what that comes to."""
    words = lost_text(robot, framed)
    yield Formula(f"  in {words['axes']}: {', '.join(words['constraints'])}")
    brief = "; ".join(filter(None, words["short"]))
    if full and brief:
        yield f"      {brief}"


def _has_nearly_pure(framed: FramedDirections) -> bool:
    """Whether a lost direction is nearly a translation or nearly a rotation."""
    return any(is_nearly_pure(direction) for direction in framed.directions)


def never_sections(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Twists that the arm makes at no configuration."""
    rows = tuple(tuple(short(round(float(value), 4) + 0.0) for value in row) for row in explanation.lost.never)
    if rows:
        yield Section("Never possible", "twists that this arm makes nowhere around here",
                      columns=("vx", "vy", "vz", "ωx", "ωy", "ωz"), rows=rows, texts=(), notes=(_FEWER,))  # fmt: skip


def _screws(explanation: Explanation, torque: str) -> Iterator[str]:
    """What is lost as twists and wrenches, in the frame in which it is simplest."""
    lost, framed = explanation.lost, explanation.lost.framed
    assert framed is not None
    at_tip = framed.frame.origin == TIP and not any(framed.frame.point)
    yield f"In the axes of {framed.name}{', reference point at the tool' * at_tip}:"
    for direction, twist, wrench in zip(framed.directions, lost.twist_screws, lost.wrench_screws, strict=True):
        yield f"  lost twist {vector(direction)}: {pitch_text(twist.pitch)}"
        yield f"      carried {torque}: {wrench_text(wrench)}"


def lost_text(robot: Robot, framed: FramedDirections) -> Record:
    """What is lost as it reads in one frame, with an entry for each direction.

    Returns:
        axes: as a heading: "base axes", "axes of link 5 (wrist_2_link) at its origin"; constraints: what all motions
        that remain obey: "0.63 vy + 0.7 vz + 0.098 m·ωx = 0"; short: what that comes to: "no motion along Y", or empty.
    """
    length = counted_length(robot)
    return {
        "axes": axes_text(robot, framed),
        "constraints": [constraint(direction, length) for direction in framed.directions],
        "short": [in_short(direction) for direction in framed.directions],
    }


def axes_text(robot: Robot, framed: FramedDirections) -> str:
    """Whose axes: "base axes", "tool axes", "axes of the tool at the origin of link 5 (wrist_2_link)"."""
    frame = framed.frame
    if frame.origin == TIP and frame.axes in (BASE, TIP):
        return f"{'base' if frame.axes == BASE else 'tool'} axes"
    text = framed.name
    if frame.axes in (BASE, TIP):
        number = frame.origin
    else:
        number = frame.axes
    if number in (BASE, TIP):
        return f"axes of {text}"
    joint, link = robot.joints[number - 1], f"link {number}"
    known = joint.link or f"after {joint.name}"
    return f"axes of {text.replace(link, f'{link} ({known})', 1)}"
