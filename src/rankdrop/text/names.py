"""Names of families in words, different and short."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import degrees, pi, radians

from rankdrop.families.name import (
    Centre,
    Detail,
    FamilyName,
    Geometry,
    JointValues,
    LowRank,
    Plane,
    Shorter,
    Variable,
    is_right,
)
from rankdrop.formula.equation import pretty_angle
from rankdrop.local.axes import numbers
from rankdrop.local.dependence import Common, Dependence, SlideWay
from rankdrop.text.words import listing, plural

UNNAMED = "unnamed family"
MEETING = "meeting point of families"

_SEPARATORS = {True: ", ", False: ": "}

_SIGNS = {Geometry.PARALLEL: " ∥ ", Geometry.PERPENDICULAR: " ⟂ "}
_JOINED = {
    Geometry.ALIGNED: "aligned", Geometry.PARALLEL: "parallel", Geometry.PERPENDICULAR: "perpendicular",
}  # fmt: skip
PLANES = {
    Plane.OF_BOTH: "plane of axes 1, 2", Plane.PARALLEL: "plane of 1 parallel to 2",
}  # fmt: skip
_DETAILS = {
    Geometry.STRETCHED: "arm stretched or folded",
    Geometry.NEARLY_STRETCHED: "arm nearly stretched or folded",
    Geometry.AGAINST: "{axes} {0} parallel to {1}",
    Geometry.COPLANAR: "axes {0} coplanar",
    Geometry.PARALLEL_AND_COPLANAR: "axes {0} parallel and coplanar",
    Geometry.COPLANAR_WITH_CENTRE: "axes {0} and {centre} coplanar",
    Geometry.CENTRE_ON_AXIS: "{centre} on axis {0}",
    Geometry.CENTRE_IN_PLANE: "{centre} in {plane}",
    Geometry.AXES_MEET_IN_PLANE: "axes {0} meet in {plane}",
    Geometry.LINE_MEETS_ALL: "all axes meet one line",
    Geometry.LINE_THROUGH_TIP: "a line through the tip meets all axes",
}

_SENTENCES = {
    Common.MOVES_NOTHING: "joint {} moves nothing",
    Common.DEPENDENT_SCREWS: "joints {} dependent",
    Common.DEPENDENT_JOINTS: "joints {} dependent",
    Common.IN_ONE_PLANE_WITH_TIP: "axes {} and the tip in one plane",
}
_FIRST_OF_TWO = {Common.PARALLEL_AND_COPLANAR: "parallel", Common.CONCURRENT_AND_COPLANAR: "concurrent"}
PATTERNS = {
    Common.ALIGNED: "aligned", Common.PARALLEL: "parallel", Common.CONCURRENT: "concurrent",
    Common.COPLANAR: "coplanar", Common.PARALLEL_AND_COPLANAR: "parallel and coplanar",
    Common.CONCURRENT_AND_COPLANAR: "concurrent and coplanar",
    Common.PARALLEL_TO_ONE_PLANE: "parallel to one plane", Common.ALL_TRANSLATIONS: "are four translations of space",
    Common.MEET_ONE_LINE: "meet one line",
}  # fmt: skip
WAYS = {
    SlideWay.NORMAL_TO_AXES: "normal to them", SlideWay.NORMAL_TO_PLANE: "normal to their plane",
    SlideWay.ALONG_TRANSLATION: "along what they translate", SlideWay.NORMAL_TO_LINE: "normal to it",
}  # fmt: skip

_MOST_DECIMALS = 4

_ORDINALS = ("", "first", "second", "third", "fourth", "fifth", "sixth")


def name_words(name: FamilyName) -> str:
    """The name of a family: "elbow and wrist: axes 3, 5, 7 aligned, 4 ∥ 6"."""
    if name.given:
        return name.given
    if name.unnamed:
        return UNNAMED
    if name.meeting:
        return f"{MEETING}: {'; '.join(dict.fromkeys(map(name_words, name.meeting)))}"
    text = _SEPARATORS[name.independent].join(filter(None, (_head(name), _body(name))))
    inside = ", ".join(filter(None, (*_value_texts(name), name.condition, ordinal_word(name.ordinal))))
    if inside:
        return f"{text} ({inside})"
    return text


def short_name(name: FamilyName) -> str:
    """The parts of the arm alone ("shoulder"); without any, its first detail and the relations after it."""
    if name.parts:
        return _head(name)
    if name.given or name.unnamed:
        return name_words(name)
    if name.meeting:
        return MEETING
    details = name.details[:1]
    for detail in name.details[1:]:
        if isinstance(detail, Detail) and not detail.brief:
            break
        details = (*details, detail)
    return _body(replace(name, details=details, bound=()))


def _head(name: FamilyName) -> str:
    return listing([part.value for part in name.parts])


def _body(name: FamilyName) -> str:
    """Details, and which joints have a condition."""
    if any(isinstance(detail, Dependence) for detail in name.details):
        separator = "; "
    else:
        separator = ", "
    text = separator.join(_detail(detail, name.shorter) for detail in name.details)
    return ", ".join(filter(None, (text, _bound(name))))


def _bound(name: FamilyName) -> str:
    if not name.bound:
        return ""
    if Shorter.CONDITION_WITHOUT_WITH in name.shorter:
        return f"a condition on {_run(name.bound)}"
    if Shorter.CONDITION_WITHOUT_JOINTS in name.shorter:
        return "with a condition"
    return f"with a condition on {_run(name.bound)}"


def _detail(detail: Detail | LowRank | Dependence, shorter: Shorter) -> str:
    if isinstance(detail, Dependence):
        return dependence_words(detail, whole=Shorter.FIRST_OF_TWO not in shorter)
    if isinstance(detail, LowRank):
        return f"joints 1–{detail.joints} of rank {detail.rank}"
    return _relation(detail, shorter)


def _relation(detail: Detail, shorter: Shorter) -> str:
    geometry = detail.geometry
    if detail.brief:
        return _SIGNS[geometry].join(str(i + 1) for i in detail.joints[0])
    if Shorter.STRETCHED in shorter and _is_reach(detail):
        return _DETAILS[Geometry.STRETCHED]
    if Shorter.FIRST_OF_TWO in shorter and geometry is Geometry.PARALLEL_AND_COPLANAR:
        return f"axes {joint_numbers(detail.joints[0])} parallel"
    if geometry in _JOINED:
        return f"axes {_join_groups(detail.joints)} {_JOINED[geometry]}"
    lists = [joint_numbers(group) for group in detail.joints]
    axes = {1: "axis"}.get(len(sum(detail.joints[:1], ())), "axes")
    return _DETAILS[geometry].format(*lists, centre=detail.centre, plane=_plane(detail), axes=axes)


def _is_reach(detail: Detail) -> bool:
    """Whether two axes and the wrist centre are in one plane: then the arm is stretched or folded."""
    with_centre = detail.geometry is Geometry.COPLANAR_WITH_CENTRE and detail.centre is Centre.WRIST
    return with_centre and len(detail.joints[0]) == 2


def _plane(detail: Detail) -> str:
    if detail.plane is None:
        return ""
    return PLANES[detail.plane]


def dependence_words(dependence: Dependence, *, whole: bool = True) -> str:
    """A dependent set in words: "axes 1, 4, 5 concurrent and coplanar"; without the second word unless `whole`."""
    names = numbers(dependence.joints)
    if dependence.common in _SENTENCES:
        return _SENTENCES[dependence.common].format(names)
    how = PATTERNS[dependence.common]
    if not whole:
        how = _FIRST_OF_TWO.get(dependence.common, how)
    if dependence.sliding:
        return f"slides {names} {how}"
    if dependence.way is None:
        return f"axes {names} {how}"
    slides = f"{plural('slide', len(dependence.slides))} {numbers(dependence.slides)}"
    return f"axes {names} {how}, {slides} {WAYS[dependence.way]}"


def joint_numbers(joints: Sequence[int]) -> str:
    """Numbers from 1 of joints from 0: "1, 3"."""
    return ", ".join(str(i + 1) for i in joints)


def _join_groups(groups: Sequence[Sequence[int]]) -> str:
    """ "1 and 3" for one pair, "1, 3, 5" for one group, "1, 3 and 5, 7" for two."""
    if len(groups) == 1 and len(groups[0]) == 2:
        groups = [[joint] for joint in groups[0]]
    return " and ".join(map(joint_numbers, groups))


def _letter(joint: Variable) -> str:
    if joint.slides:
        return f"q{joint.number}"
    return f"θ{joint.number}"


def _run(joints: Sequence[Variable]) -> str:
    """ "θ3–θ6" for a run of three or more, "θ2, θ4" otherwise."""
    letters = [_letter(joint) for joint in joints]
    if len(joints) > 2 and joints[-1].number - joints[0].number == len(joints) - 1:
        return f"{letters[0]}–{letters[-1]}"
    return ", ".join(letters)


def _value_texts(name: FamilyName) -> list[str]:
    return [f"{_letter(values.joint)} = {_values_text(values, name.shorter)}" for values in name.values]


def _values_text(values: JointValues, shorter: Shorter) -> str:
    if values.joint.slides:
        return " or ".join(f"{value:.3g} m".replace("-", "−") for value in values.values)
    texts = [_angle(value) for value in values.values]
    opposite = texts[0] == f"−{texts[-1]}" and not is_right(values.values[-1])
    if Shorter.WHOLE_DEGREES in shorter:
        texts = [_whole_degrees(value, text) for value, text in zip(values.values, texts, strict=True)]
    if Shorter.PLUS_MINUS in shorter and opposite:
        return f"±{texts[-1]}"
    return " or ".join(texts)


def _angle(value: float) -> str:
    if is_right(value):
        return pretty_angle(round(value / (pi / 2)) * (pi / 2))
    return f"{degrees(value):.{_decimals(value)}f}°".replace("-", "−")


def _decimals(value: float) -> int:
    """How many decimals [°] tell an angle from a right one: 179.997° is not 180.0°."""
    for decimals in range(1, _MOST_DECIMALS):
        if not is_right(radians(round(degrees(value), decimals))):
            return decimals
    return _MOST_DECIMALS


def _whole_degrees(value: float, text: str) -> str:
    """An angle in whole degrees, unless that would be a right one."""
    if is_right(value):
        return text
    whole = round(round(degrees(value), _decimals(value)))
    if whole % 90 == 0:
        return text
    return f"{whole}°".replace("-", "−")


def ordinal_word(number: int) -> str:
    """ "second"; nothing for 0."""
    if number < len(_ORDINALS):
        return _ORDINALS[number]
    return f"{number}th"
