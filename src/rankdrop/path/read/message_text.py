"""A pose as ROS prints it: the fields of geometry_msgs/Pose or Transform, as YAML, JSON or Python, and tf2_echo.

Three numbers follow the word position or translation, four the word orientation, rotation or quaternion; with the names
x, y, z, w in any order, or without names in this order [m, 1]. Everything else (headers, covariances, angles after
the quaternion) is passed over.
"""

from __future__ import annotations

import re

from rankdrop.errors import OptionError

_PLACE = re.compile(r"\b(?:position|translation)\b", re.IGNORECASE)
_TURN = re.compile(r"\b(?:orientation|rotation|quaternion)\b", re.IGNORECASE)
_WORD = re.compile(
    r"\b(?P<name>[xyzw])\b[\"']?\s*[=:]\s*(?P<named>[-+]?[\d.][\d.eE+-]{0,40})|(?<![\w.])(?P<plain>[-+]?\d[\d.eE+-]{0,40})(?![\w.])"
)
_WRITTEN = "position: {x: 0.4, y: 0, z: 0.3}, orientation: {x: 1, y: 0, z: 0, w: 0}"


def message_of_text(text: str, where: str) -> list[float] | None:
    """x, y, z [m], and a quaternion x, y, z, w where there is one, from a printed message; None where it is none.

    Args:
        text: as pasted.
        where: the option, for errors.

    Raises:
        OptionError: a number of the position or the orientation is missing.

    Example:
        >>> message_of_text("position: {x: 0.4, y: 0, z: 0.3}, orientation: {x: 1, y: 0, z: 0, w: 0}", "--pose")
        [0.4, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0]
    """
    place = _PLACE.search(text)
    if place is None:
        return None
    turn = _TURN.search(text, place.end())
    if turn is None:
        return _numbers(text[place.end() :], "xyz", where)
    numbers = _numbers(text[place.end() : turn.start()], "xyz", where)
    return numbers + _numbers(text[turn.end() :], "xyzw", where)


def _numbers(text: str, names: str, where: str) -> list[float]:
    """The first numbers of a text, one for each name; by the names where they are given.

    Raises:
        OptionError: one is missing, or is no number.
    """
    try:
        return [float(word) for word in _words_for(names, text)]
    except (ValueError, KeyError, IndexError) as error:
        raise OptionError(f"a number of {', '.join(names)} is missing", where=where, got=repr(text.strip()),
                          allowed=_WRITTEN) from error  # fmt: skip


def _words_for(names: str, text: str) -> list[str]:
    """The first word for each name; the first words in order where a text has no names."""
    words = list(_WORD.finditer(text))
    named = {word["name"]: word["named"] for word in reversed(words) if word["name"]}
    if named:
        return [named[name] for name in names]
    plain = [word["plain"] for word in words if word["plain"]]
    return [plain[place] for place in range(len(names))]
