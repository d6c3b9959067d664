"""A robot for a notebook, notes on how its description was read, and the ideal arm that is near."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees, isfinite, radians

from rankdrop.options import advise
from rankdrop.robot.ideal import AxesHold, Hold, Near
from rankdrop.robot.model import Robot
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.quantities import count
from rankdrop.sections import Section

_FIXED = 8
"""So many links fixed to the tip are named."""
_NOTES = {
    NoteOn.BASE: "base {name!r} chosen: the root link",
    NoteOn.TIP: "tip {name!r} chosen: end of the longest chain, {joints}{fixed}{gripper}",
    NoteOn.LEFT_OUT: "joint {name!r} left out: its {end} link {other!r} is not in the file",
    NoteOn.NO_AXIS: "joint {name!r} has no <axis>: it is X of the joint, as URDF says",
    NoteOn.NO_LIMITS: "joint {name!r} has no limits: it counts as unlimited",
    NoteOn.ONE_LIMIT: "joint {name!r} has no {end} limit: it is 0, the default of URDF",
    NoteOn.NO_LIMIT: "joint {name!r}: {end} {value:g} is read as no limit",
    NoteOn.NO_RATE: "joint {name!r}: velocity {value:g} is read as not known",
    NoteOn.FOLLOWS: "joint {name!r} follows joint {other!r}",
    NoteOn.FOLLOWS_OUTSIDE: "joint {name!r} follows {other!r}, which is not in the chain: it counts as a variable",
    NoteOn.FOLLOWS_TOGETHER: "joint {name!r} follows {other!r}, which is not in the chain: it follows {instead!r} "
    "instead",
    NoteOn.COUPLED: "joint {name!r} is coupled to {other!r} by a constraint: they count as independent",
    NoteOn.FLOATS: "body {name!r} floats freely: its own motion is not counted",
    NoteOn.TURNS: "joint {name!r}: limits of {lower:g} … {upper:g} rad are many turns; write \"{most:g} deg\" for "
    "degrees",
    NoteOn.TURNS_WITHOUT_UNITS: "joint {name!r}: limits of {lower:g} … {upper:g} rad are many turns; {most:g}° is "
    "{in_rad:.4g}",
    NoteOn.FIXED_TURNS: "a fixed angle of {value:g} rad is many turns; {value:g}° is {value_in_rad:.4g}",
    NoteOn.SQUARED: "{made_exact}; {as_written} keeps the file's numbers",
    NoteOn.IDEAL: "not the arm itself but the ideal one within {within}: {idealised}",
    NoteOn.NO_HOME: "home pose not given: the tip is taken at the base origin",
    NoteOn.SCREW_LINES: "six numbers a line: screws (direction; moment about the base origin) at q = 0, in order",
    NoteOn.DH_TEXT: "DH table of the {name} convention; without a unit lengths are in {other}, angles in {instead}",
    NoteOn.SLIDES: "joint {name!r} slides: no number is given for {other} in its column d, and its theta is constant",
    NoteOn.NOT_PLACED: "a tool or a base that the text sets is not read: poses are those of the last DH frame",
    NoteOn.SIZE: "the arm's reach is {value:.3g} m: are these numbers millimetres? Lengths are read as metres",
    NoteOn.PACKAGE: "package {name!r} found: {other}",
    NoteOn.NO_PACKAGE: "package {name!r} is not found: only files that are not read are in it",
    NoteOn.GIVEN: "{text}",
}


_TOGETHER = {
    NoteOn.NO_LIMITS: "joints {names} have no limits: they count as unlimited",
    NoteOn.NO_RATE: "joints {names}: velocity {value:g} is read as not known",
}
"""Notes that files give for most of their joints: those of several joints are one line."""

_HOLDS = {
    Hold.POINT: "axes {} in one point", Hold.SHOULDER: "a spherical shoulder", Hold.WRIST: "a spherical wrist",
    Hold.PARALLEL: "axes {} parallel", Hold.COMMON: "axes {} on one line", Hold.MEETING: "axes {} meeting",
    Hold.SQUARE: "axes {} at right angles", Hold.FLUSH: "no offset along axes {}",
}  # fmt: skip
_TOLD = 2
"""So many gains of structure are named."""


def notes_words(notes: Iterable[RobotNote]) -> tuple[str, ...]:
    """The notes on a robot description in words, a line for each; the same note of several joints is one.

    Example:
        >>> notes_words([RobotNote(NoteOn.NO_RATE, name) for name in ("hip", "knee")])
        ("joints 'hip', 'knee': velocity 0 is read as not known",)
    """
    alike: dict[tuple[object, ...], list[RobotNote]] = {}
    for place, note in enumerate(notes):
        if note.kind in _TOGETHER:
            key: tuple[object, ...] = (note.kind, note.value)
        else:
            key = (place,)
        alike.setdefault(key, []).append(note)
    lines = []
    for first, *others in alike.values():
        if others:
            names = ", ".join(repr(note.name) for note in (first, *others))
            lines.append(_TOGETHER[first.kind].format(names=names, value=first.value))
        else:
            lines.append(str(first))
    return tuple(lines)


def sections_of(robot: Robot) -> tuple[Section, ...]:
    """For notebooks: the joints with their kinds and limits, angles in degrees, and the notes."""
    rows = []
    for number, joint in enumerate(robot.variables, start=1):
        lower, upper = _limit(joint.lower, joint.unit), _limit(joint.upper, joint.unit)
        rows.append((str(number), joint.name, str(joint.kind), lower, upper))
    followers = tuple(
        f"{joint.name} follows {joint.mimic.leader}" for joint in robot.joints if joint.mimic is not None
    )
    about: tuple[str, ...] = ()
    if robot.about:
        about = (robot.about,)
    section = Section(
        robot.name, f"{robot.n} joints from {robot.base} to {robot.tip}, task {robot.task}", about,
        columns=("", "joint", "kind", "lower", "upper"), rows=tuple(rows), texts=(1, 2), after=followers,
        notes=notes_words(robot.notes),
    )  # fmt: skip
    return (section,)


def _limit(value: float, unit: str) -> str:
    """A limit of a joint: "none" where it is endless."""
    if not isfinite(value):
        return "none"
    if unit == "rad":
        text = f"{degrees(value):.4g}°"
    else:
        text = f"{value:.4g} m"
    return text.replace("-", "−")


def robot_note_words(note: RobotNote) -> str:
    """One note on a robot description.

    Example:
        >>> robot_note_words(RobotNote(NoteOn.TIP, "flange", number=6, fixed=("tool0",), gripper=("left", "right")))
        "tip 'flange' chosen: end of the longest chain, 6 moving joints; fixed to it: tool0; the gripper after it is \
left out (left, right)"
    """
    lower, upper = note.limits
    most = max((abs(limit) for limit in note.limits if isfinite(limit)), default=0.0)
    return _NOTES[note.kind].format(
        name=note.name, other=note.other, instead=note.instead, end=note.end, value=note.value,
        value_in_rad=radians(note.value), lower=lower, upper=upper, most=most, in_rad=radians(most),
        joints=count(note.number, "moving joint"), fixed=_fixed_links_words(note.fixed), gripper=_gripper(note.gripper),
        made_exact="; ".join(_made_exact(note)), idealised=_idealised_words(note), within=note.within,
        as_written=advise("as-written"), text=note.text,
    )  # fmt: skip


def _fixed_links_words(links: tuple[str, ...]) -> str:
    """Links fixed to the tip; "" where there are none."""
    if not links:
        return ""
    more = ""
    if len(links) > _FIXED:
        more = " …"
    return f"; fixed to it: {', '.join(links[:_FIXED])}{more}"


def _gripper(joints: tuple[str, ...]) -> str:
    if not joints:
        return ""
    return f"; the gripper after it is left out ({', '.join(joints)})"


def _made_exact(note: RobotNote) -> list[str]:
    """Which numbers of a file were made exact, and by how much at most."""
    parts = []
    if note.rounded.number:
        if note.rounded.number == 1:
            means = "the multiple of 15° it rounds"
        else:
            means = "the multiples of 15° they round"
        angles = count(note.rounded.number, "angle")
        parts.append(f"{angles} read as {means}, at most {note.rounded.most:.2g} rad")
    what, most = [], []
    if note.turned.number:
        what.append(count(note.turned.number, "axis", "axes"))
        most.append(f"{note.turned.most:.2g} rad")
    if note.moved.number:
        what.append(count(note.moved.number, "length"))
        most.append(f"{note.moved.most * 1e6:.2g} µm")
    if what:
        parts.append(f"{' and '.join(what)} squared, at most {', '.join(most)}")
    return parts


def _idealised_words(note: RobotNote) -> str:
    """How many numbers of an arm were moved, and by how much at most."""
    what, most = [], []
    if note.turned.number:
        what.append(count(note.turned.number, "angle"))
        most.append(f"{degrees(note.turned.most):.3g}°")
    if note.moved.number:
        what.append(count(note.moved.number, "length"))
        most.append(f"{note.moved.most * 1e3:.3g} mm")
    return f"{' and '.join(what)} moved, at most {', '.join(most)}"


def hold_words(hold: AxesHold) -> str:
    """What holds between axes, for after "with".

    Example:
        >>> hold_words(AxesHold(Hold.PARALLEL, (2, 3, 4))), hold_words(AxesHold(Hold.FLUSH, (3,)))
        ('axes 2, 3, 4 parallel', 'no offset along axis 3')
    """
    joints = hold.joints
    if len(joints) == 1:
        return f"no offset along axis {joints[0]}"
    if len(joints) == 2:
        listed = f"{joints[0]} and {joints[1]}"
    else:
        listed = ", ".join(map(str, joints))
    return _HOLDS[hold.what].format(listed)


def near_text(near: Near) -> str:
    """What an ideal arm nearby has, and how near it is: "this arm is within 0.3 mm, 0.06° of one with …"."""
    far = []
    if near.length:
        millimetres = float(f"{near.length * 1e3:.2g}")
        far.append(f"{millimetres:g} mm")
    if near.angle:
        far.append(f"{degrees(near.angle):.2g}°")
    gains = [hold_words(hold) for hold in near.gained[:_TOLD]]
    gained = " and ".join(gains)
    if len(near.gained) > _TOLD:
        gained = f"{', '.join(gains)} and {len(near.gained) - _TOLD} more"
    return f"this arm is within {', '.join(far)} of one with {gained}"


def near_line(near: Near) -> str:
    """The same, and what takes the ideal arm: the option of commands, or the function."""
    within = near.tolerance
    given = []
    if within.length is not None:
        given.append(f"length={within.length:.12g}")
    if within.angle is not None:
        given.append(f"angle={within.angle:.12g}")
    function = f"rankdrop.robot.ideal.ideal(robot, {', '.join(given)})"
    return f"{near_text(near)}: see {advise('ideal', within.text, python=function)}"
