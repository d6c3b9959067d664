"""Joint values as engineers copy them from code, a message or a program: the list alone, and what its form says of it.

- Code: `q = np.array([0, -np.pi/2, …])`, `{{0, -M_PI_4, …}}`, `[0 -90 90]*pi/180`, `deg2rad([…])`, `[…]'`.
- A message of ROS: `name: […]` and `position: […]`; the values are ordered by the names of the joints.
- Programs: `{E6AXIS: A1 0, …, E1 0}`, `[[0, 0, …], [9E9, …]]`, `posj(…)`; all three in degrees.
- Lists of YAML with a dash before each value; values between bars.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from rankdrop.errors import ConfigurationError

LONGEST_PASTE = 20_000
"""Characters of a list that is searched for a form; a longer text is a plain list."""

_CONSTANTS = (
    (re.compile(r"\bM_PI_([24])\b"), r"(pi/\1)"),
    (re.compile(r"\b(?:M_PI|(?:[A-Za-z]\w{0,40}\.)?(?:pi|PI))\b"), "pi"),
)
_TURN = re.compile(r"(?:[A-Za-z]\w{0,40}\.)?\b(?:deg2rad|d2r|radians)\(([-+.\d]{1,40})\)")
_BLANKS_AROUND = re.compile(r"(?<!\s)\s*([*/])\s*")
_DASH = re.compile(r"^[ \t]*-[ \t]+", re.MULTILINE)
_ASSIGNED = re.compile(r"(?!\d)(?:[^=:(){}]|::)+:?[=:]\s*(?=[-+.\d\[({]|[A-Za-z_][\w.]*\s*[\[({])")
_NAMED = re.compile(r"[,;]\s*(?!dtype)[A-Za-z_]\w*\s*[=:]")
_VALUED = re.compile(r"(?<![\w.])[A-Za-z_]\w{0,60}\s{0,10}[=:]\s{0,10}[-+.\d]")  # a name and its number
_CALL = re.compile(r"([A-Za-z_][\w.]*)\s*\(")
_KEYWORD = re.compile(r",\s*[A-Za-z_]\w*\s*=[^=,()\[\]]*$")
_IN_RADIANS = re.compile(r"(?<=[\])])\s*(?:\*\(?pi/180(?:\.0*)?\)?|/180(?:\.0*)?\*pi|\*(?:deg2rad|d2r|deg)\b)$",
                         re.IGNORECASE)  # fmt: skip
_TRANSPOSED = re.compile(r"(?:'|\.T|\.transpose\(\))$")
_TYPED = re.compile(r"^\{\s*(?:E6)?AXIS\s*:", re.IGNORECASE)
_EXTERNAL = re.compile(r"\s*E[1-6]\s+[-+.\deE]+\s*", re.IGNORECASE)
_AXES = re.compile(r"^\{\s*A1\b", re.IGNORECASE)
_FIELD = re.compile(r"\b(name|names|joint_names|positions?)\b[\"']?\s*[=:]\s*", re.IGNORECASE)
_ITEM = re.compile(r"\s*-[ \t]+([^\n]*)")

_GROUPS = re.compile(r"\[\s*(\[[^\[\]]*\])\s*(,\s*\[[^\[\]]*\]\s*)?\]")
_NO_AXIS = re.compile(r"\b9E\+?0?9\b", re.IGNORECASE)  # the value of an external axis that the robot does not have

_OF_DEGREES = frozenset(("deg2rad", "d2r", "radians", "posj"))
"""Functions of arguments in degrees: conversions, and joint targets of programs."""
_ARITHMETIC = frozenset(("sqrt", "pi"))
_DEEPEST_CALL = 4  # np.array(list(…)) has two


@dataclass(frozen=True)
class JointText:
    """A list of joint values, taken out of what it was pasted with.

    Attributes:
        text: the list.
        degrees: its form says that angles without a unit are in degrees.
        words: one value for each joint of the arm, where the text names them; else empty.
    """

    text: str
    degrees: bool = False
    words: tuple[str, ...] = ()


def joints_of_text(text: str, names: Sequence[str], *, where: str) -> JointText:
    """The list of joint values in a pasted text.

    Args:
        text: as pasted.
        names: of the arm's joints, in their order.
        where: the option, for errors.

    Raises:
        ConfigurationError: a message names the joints, and not all of the arm's.

    Example:
        >>> joints_of_text("q = np.deg2rad([0, -90, 2.5])", ("j1", "j2", "j3"), where="--q")
        JointText(text='[0, -90, 2.5]', degrees=True, words=())
    """
    if len(text) > LONGEST_PASTE:
        return JointText(text)
    plain = with_plain_constants(text)
    message = _of_message(plain, names, where)
    if message is not None:
        return message
    if _DASH.match(plain) and len(_DASH.findall(plain)) == len(names):
        plain = ", ".join(_DASH.sub("", plain).split("\n"))
    return _of_code(plain.replace("|", ","))


def with_plain_constants(text: str) -> str:
    """The text with pi for the names that languages give it, units for conversions, no blanks around * and /."""
    plain = text.strip().rstrip(";").strip()
    for name, value in _CONSTANTS:
        plain = name.sub(value, plain)
    plain = _TURN.sub(r"\1deg", plain)
    return _BLANKS_AROUND.sub(r"\1", plain)


def _of_code(text: str) -> JointText:
    """The list without an assignment, calls, conversions and a second group around it."""
    assigned = _ASSIGNED.match(text)
    if assigned is not None and _NAMED.search(text) is None and len(_VALUED.findall(text)) < 2:
        text = text[assigned.end() :]
    column = _TRANSPOSED.sub("", text)
    body = _IN_RADIANS.sub("", column)
    degrees = body != column
    for _ in range(_DEEPEST_CALL):
        called = _inside_call(body)
        if called is None:
            break
        name, body = called
        degrees = degrees or name in _OF_DEGREES
    body = _TRANSPOSED.sub("", body.strip())
    if _TYPED.match(body) or _AXES.match(body):
        items = _TYPED.sub("{", body).strip("{} ").split(",")
        return JointText(", ".join(item for item in items if not _EXTERNAL.fullmatch(item)), degrees=True)
    return _first_group(body, degrees=degrees)


def _inside_call(text: str) -> tuple[str, str] | None:
    """The last part of the name of a function that a whole list is the argument of, and that list."""
    body = text.strip()
    call = _CALL.match(body)
    if call is None or not body.endswith(")"):
        return None
    name = call[1].rpartition(".")[2]
    inside = _KEYWORD.sub("", body[call.end() : -1].strip())
    if name in _ARITHMETIC or not re.search(r"[\s,;]", inside):
        return None
    return name, inside


def _first_group(text: str, *, degrees: bool) -> JointText:
    """Of [[…], […, 9E9]] the first group: a joint target, in degrees, with external axes; of [[…]] the only one."""
    inner = _GROUPS.fullmatch(text.strip())
    if inner is None or (inner[2] is not None and _NO_AXIS.search(inner[2]) is None):
        return JointText(text, degrees)
    return JointText(inner[1], degrees or inner[2] is not None)


def _of_message(text: str, names: Sequence[str], where: str) -> JointText | None:
    """The values of a message of ROS, ordered by its names; None where the text is none."""
    fields = {found[1].lower(): _list_after(text, found.end()) for found in reversed(list(_FIELD.finditer(text)))}
    values = fields.get("position") or fields.get("positions")
    given = fields.get("name") or fields.get("names") or fields.get("joint_names")
    if not values:
        return None
    if not given:
        return JointText(", ".join(values))
    if len(given) != len(values):
        raise ConfigurationError("the message has not one value for each of its names", where=where,
                                 got=f"{len(given)} names, {len(values)} values")  # fmt: skip
    by_name = dict(zip((name.strip("\"' ") for name in given), values, strict=True))
    return JointText(text, words=tuple(_value_for(name, by_name, where) for name in names))


def _list_after(text: str, at: int) -> list[str]:
    """The items of a list in brackets, or with a dash on each line, that begins at a place; empty for anything else."""
    if text[at : at + 1] in ("[", "("):
        ends = [end for sign in "])" if (end := text.find(sign, at)) >= 0]
        inside = text[at + 1 : min(ends, default=len(text))]
        return [item for item in re.split(r"[\s,]+", inside.strip()) if item]
    items = []
    while item := _ITEM.match(text, at):
        items.append(item[1].strip())
        at = item.end()
    return items


def _value_for(name: str, by_name: dict[str, str], where: str) -> str:
    """The value of the joint with this name, or with the only name that ends with it or that it ends with.

    Raises:
        ConfigurationError: no joint of the message is this one.
    """
    if name in by_name:
        return by_name[name]
    alike = [other for other in by_name if other.endswith(name) or name.endswith(other)]
    if len(alike) != 1:
        raise ConfigurationError("the message has no value for this joint", where=f"{where}, joint {name}",
                                 got=", ".join(by_name),
                                 mend="give the values alone, in the order of the arm's joints")  # fmt: skip
    return by_name[alike[0]]
