"""Parts of the arm that are special at a singular configuration, in words: "wrist: joint 5 near 0°"."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, radians

from rankdrop.local.special import Shape, Special
from rankdrop.text.words import short

_NEAR = radians(20.0)
"""Up to this angle a condition is nearly satisfied; the angle itself is stated beyond it."""
_WORDS = {
    Shape.JOINT: "joint {joint} at {value}",
    Shape.STRETCHED: "arm stretched",
    Shape.FOLDED: "arm folded",
    Shape.ABOVE_AXIS: "wrist above axis {joint}",
}
_NEARLY = {
    Shape.JOINT: "joint {joint} near {value}",
    Shape.STRETCHED: "arm nearly stretched",
    Shape.FOLDED: "arm nearly folded",
    Shape.ABOVE_AXIS: "wrist nearly above axis {joint}",
}
_FAR = {
    Shape.JOINT: "joint {joint} {off} from {value}",
    Shape.STRETCHED: "arm {off} from stretched",
    Shape.FOLDED: "arm {off} from folded",
    Shape.ABOVE_AXIS: "wrist {off} from above axis {joint}",
}


def special_words(specials: Sequence[Special]) -> str:
    """The parts, and what is special about them where there are at most two; "" without any."""
    details = "" if len(specials) > 2 else ", ".join(map(_detail, specials))
    return parts_words(specials) + (f": {details}" if details else "")


def parts_words(specials: Sequence[Special]) -> str:
    """The parts alone: "shoulder and wrist"."""
    *first, last = list(dict.fromkeys(one.part.value for one in specials)) or [""]
    return f"{', '.join(first)} and {last}" if first else last


def _detail(one: Special) -> str:
    words = _WORDS if one.exact else _NEARLY if one.off <= _NEAR else _FAR
    value = round(degrees(one.value), 1) + 0.0
    shown, off = f"{short(180.0 if value == -180.0 else value, 4)}°", f"{short(degrees(one.off), 2)}°"
    return words[one.shape].format(joint=one.joint, value=shown, off=off)
