"""Names of families as files hold them, in words, read into facts: once, at the border."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import pi, radians

from rankdrop.families.equation import pretty_angle
from rankdrop.families.name import (
    ArmPart,
    Centre,
    Detail,
    FamilyName,
    Geometry,
    JointValues,
    LowRank,
    Plane,
    Shorter,
    Variable,
)
from rankdrop.local.dependence import Common, Dependence
from rankdrop.text.names import MEETING, PATTERNS, PLANES, UNNAMED, WAYS, name_words, ordinal_word

Match = re.Match[str]
_ANY = "|".join(part.value for part in ArmPart)
_HEAD = re.compile(rf"((?:{_ANY})(?:(?:, | and )(?:{_ANY}))*)(: |, |$)")
_NEXT = re.compile(
    r", (?=ax[ei]s |axes |\d+ [∥⟂]|arm |with a |a condition|a line|all axes|wrist centre |tip |screws |joints? )|; "
)
_BOUND = re.compile(r"(with )?a condition(?: on (.*))?$")
_VARIABLE = re.compile(r"([θq])(\d+)")
_RUN = re.compile(r"([θq])(\d+)–([θq])(\d+)$")
_VALUES = re.compile(r"([θq])(\d+) = (.*)$")
_ENTRY = re.compile(r", (?=[θq]\d)")
_ANGLE = re.compile(r"(-?\d+(?:\.\d+)?)°$")
_LENGTH = re.compile(r"(-?\d[\d.e+-]*) m$")
_WHOLE = re.compile(r"(?<![\d.])\d+°")
_RIGHT_ANGLES = {pretty_angle(quarter * pi / 2): quarter * pi / 2 for quarter in range(-2, 3)}
_ORDINALS = {ordinal_word(number): number for number in range(1, 100)}


@cache
def read_name(text: str) -> FamilyName:
    """The facts of a name; one with other words than the package gives is kept as it is.

    Example:
        >>> read_name("elbow: arm stretched or folded (θ3 = −87.3° or 92.7°)").parts
        (<ArmPart.ELBOW: 'elbow'>,)
        >>> read_name("my own family").given
        'my own family'
    """
    for readers in (_FACTS, _SETS):
        try:
            found = _read(text, readers)
        except (ValueError, KeyError):
            continue
        if name_words(found) == text:
            return found
    return FamilyName(given=text)


def _read(text: str, readers: _Readers) -> FamilyName:
    if text == UNNAMED:
        return FamilyName(unnamed=True)
    if text.startswith(f"{MEETING}: "):
        return FamilyName(meeting=tuple(map(read_name, _meeting(text.removeprefix(f"{MEETING}: ")))))
    body, _, inside = text.partition(" (")
    name = _inside(inside.removesuffix(")"))
    head = _HEAD.match(body)
    if head:
        parts = tuple(part for part in ArmPart if part.value in head[1])
        name = replace(name, parts=parts, independent=head[2] == ", ")
        body = body[head.end() :]
    pieces = [piece for piece in _NEXT.split(body) if piece]
    condition = _BOUND.match((pieces or [""])[-1])
    if condition:
        pieces.pop()
        bound, shorter = _condition(condition)
        name = replace(name, bound=bound, shorter=name.shorter | shorter)
    details = tuple(_detail(piece, readers) for piece in pieces)
    return replace(name, details=details)


def _condition(found: Match) -> tuple[tuple[Variable, ...], Shorter]:
    """Joints with a condition, and how that is written: number 0 where the words leave the joints out."""
    if not found[2]:
        return (Variable(0),), Shorter.CONDITION_WITHOUT_JOINTS
    if not found[1]:
        return _variables(found[2]), Shorter.CONDITION_WITHOUT_WITH
    return _variables(found[2]), Shorter.NOTHING


def _meeting(text: str) -> list[str]:
    """The names of families that meet; a name of several dependent sets is one."""
    return text.split("; ")


def _variables(text: str) -> tuple[Variable, ...]:
    run = _RUN.match(text)
    if run:
        numbers = range(int(run[2]), int(run[4]) + 1)
        ends = {int(run[2]): run[1] == "q", int(run[4]): run[3] == "q"}
        return tuple(Variable(number, ends.get(number, False)) for number in numbers)
    return tuple(Variable(int(number), letter == "q") for letter, number in _VARIABLE.findall(text))


def _inside(text: str) -> FamilyName:
    """A name with the values, the condition or the number that stand in brackets."""
    values: list[JointValues] = []
    formula, ordinal, shorter = "", 0, Shorter.NOTHING
    for entry in _ENTRY.split(text):
        rest, _, last = entry.rpartition(", ")
        if last in _ORDINALS:
            ordinal, entry = _ORDINALS[last], rest
        if not entry:
            continue
        read = _values(entry)
        if read is None:
            formula = entry
        else:
            values.append(read[0])
            shorter |= read[1]
    return FamilyName(values=tuple(values), condition=formula, ordinal=ordinal, shorter=shorter)


def _values(entry: str) -> tuple[JointValues, Shorter] | None:
    """The values of one joint, and how they are written; None for another formula."""
    found = _VALUES.match(entry)
    if not found:
        return None
    joint, text = Variable(int(found[2]), found[1] == "q"), found[3]
    shorter = Shorter.NOTHING
    if text.startswith("±") and text.endswith("°"):
        text, shorter = f"−{text[1:]} or {text[1:]}", Shorter.PLUS_MINUS
    if _WHOLE.search(text):
        shorter |= Shorter.WHOLE_DEGREES
    read = {True: _length, False: _angle}[joint.slides]
    numbers = [read(one) for one in text.split(" or ")]
    known = tuple(number for number in numbers if number is not None)
    if len(known) < len(numbers):
        return None
    return JointValues(joint, known), shorter


def _angle(text: str) -> float | None:
    """An angle [rad] of "−26.8°" or "π/2"; None for another text."""
    found = _ANGLE.match(text.replace("−", "-"))
    if found:
        return radians(float(found[1]))
    return _RIGHT_ANGLES.get(text)


def _length(text: str) -> float | None:
    """A number of "0.3 m"; None for another text."""
    found = _LENGTH.match(text.replace("−", "-"))
    if found:
        return float(found[1])
    return None


def _joints(text: str) -> tuple[int, ...]:
    """Joints from 0 of "1, 3" or "2–6"."""
    if "–" in text:
        first, last = map(int, text.split("–"))
        return tuple(range(first - 1, last))
    return tuple(int(number) - 1 for number in text.split(", "))


def _groups(text: str) -> tuple[tuple[int, ...], ...]:
    """Groups of joints from 0 of "1 and 3" (one pair), "1, 3, 5", "1, 3 and 5, 7"."""
    groups = tuple(map(_joints, text.split(" and ")))
    if [len(group) for group in groups] == [1, 1]:
        return (groups[0] + groups[1],)
    return groups


_LIST = r"(\d+(?:, \d+)*)"
_RUNS = r"(\d+–\d+|\d+(?:, \d+)*)"
_RELATIONS = {
    "aligned": Geometry.ALIGNED, "parallel": Geometry.PARALLEL, "perpendicular": Geometry.PERPENDICULAR,
}  # fmt: skip
_PATTERNS = {words: pattern for pattern, words in PATTERNS.items()}
_WAYS = {words: way for way, words in WAYS.items()}
_PLANE = r"plane of (?:axes 1, 2|1 parallel to 2)"


def _plane(text: str) -> Plane:
    return next(plane for plane, words in PLANES.items() if words == text)


def _slides(found: Match, common: Common) -> Dependence:
    return Dependence(common, _joints(found[1]), _joints(found[2]), _WAYS[found[3]])


_SLIDES = rf"slides? {_RUNS} (normal to them|normal to their plane|along what they translate|normal to it)"
_Readers = tuple[tuple[str, Callable[[Match], Detail | LowRank | Dependence]], ...]
_FACTS: _Readers = (
    ("arm stretched or folded", lambda m: Detail(Geometry.STRETCHED)),
    ("arm nearly stretched or folded", lambda m: Detail(Geometry.NEARLY_STRETCHED)),
    ("all axes meet one line", lambda m: Detail(Geometry.LINE_MEETS_ALL)),
    ("a line through the tip meets all axes", lambda m: Detail(Geometry.LINE_THROUGH_TIP)),
    (r"(\d+(?: ∥ \d+)+)", lambda m: Detail(Geometry.PARALLEL, (_joints(m[1].replace(" ∥ ", ", ")),), brief=True)),
    (r"(\d+ ⟂ \d+)", lambda m: Detail(Geometry.PERPENDICULAR, (_joints(m[1].replace(" ⟂ ", ", ")),), brief=True)),
    (rf"ax[ei]s {_LIST} parallel to {_LIST}", lambda m: Detail(Geometry.AGAINST, (_joints(m[1]), _joints(m[2])))),
    (rf"axes {_LIST} and (wrist centre|tip) coplanar",
        lambda m: Detail(Geometry.COPLANAR_WITH_CENTRE, (_joints(m[1]),), centre=Centre(m[2]))),
    (r"(wrist centre|tip) on axis (\d+)",
        lambda m: Detail(Geometry.CENTRE_ON_AXIS, (_joints(m[2]),), centre=Centre(m[1]))),
    (rf"(wrist centre|tip) in ({_PLANE})",
        lambda m: Detail(Geometry.CENTRE_IN_PLANE, ((0, 1),), centre=Centre(m[1]), plane=_plane(m[2]))),
    (rf"axes {_LIST} meet in ({_PLANE})",
        lambda m: Detail(Geometry.AXES_MEET_IN_PLANE, (_joints(m[1]), (0, 1)), plane=_plane(m[2]))),
    (r"axes (.*) (aligned|parallel|perpendicular)", lambda m: Detail(_RELATIONS[m[2]], _groups(m[1]))),
    (rf"axes {_LIST} parallel and coplanar", lambda m: Detail(Geometry.PARALLEL_AND_COPLANAR, (_joints(m[1]),))),
    (rf"axes {_LIST} coplanar", lambda m: Detail(Geometry.COPLANAR, (_joints(m[1]),))),
    (r"(screws|joints) 1–(\d+) of rank (\d+)", lambda m: LowRank(int(m[2]), int(m[3]), m[1] == "screws")),
)  # fmt: skip
"""What a detail reads, and its facts: the first that reads all of it."""
_SETS: _Readers = (
    (rf"joint {_RUNS} moves nothing", lambda m: Dependence(Common.MOVES_NOTHING, _joints(m[1]))),
    (rf"screws {_RUNS} dependent", lambda m: Dependence(Common.DEPENDENT_SCREWS, _joints(m[1]))),
    (rf"joints {_RUNS} dependent", lambda m: Dependence(Common.DEPENDENT_JOINTS, _joints(m[1]))),
    (rf"axes {_RUNS} and the tip in one plane", lambda m: Dependence(Common.IN_ONE_PLANE_WITH_TIP, _joints(m[1]))),
    (rf"slides {_RUNS} are four translations of space",
        lambda m: Dependence(Common.ALL_TRANSLATIONS, _joints(m[1]), sliding=True)),
    (rf"axes {_RUNS} parallel, {_SLIDES}", lambda m: _slides(m, Common.PARALLEL)),
    (rf"axes {_RUNS} meet one line, {_SLIDES}", lambda m: _slides(m, Common.MEET_ONE_LINE)),
    (rf"(axes|slides) {_RUNS} (.*)", lambda m: Dependence(_PATTERNS[m[3]], _joints(m[2]), sliding=m[1] == "slides")),
)  # fmt: skip
"""The same of dependent sets of joint screws."""


def _detail(text: str, readers: _Readers) -> Detail | LowRank | Dependence:
    for pattern, facts in readers:
        found = re.fullmatch(pattern, text)
        if found:
            return facts(found)
    raise ValueError(text)
