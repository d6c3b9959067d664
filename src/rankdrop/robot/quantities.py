"""Quantities as people write them: 1.57, "pi/2", "-3*pi/4", "90 deg", "316 mm", "sqrt(2)/2". No eval.

And the letters for the lengths of an arm: what they may be called and which values they may have.

Angles that a file writes as rounded decimals: 1.5708 stands for π/2.

A decimal that equals a multiple of π/12, rounded or cut to the decimal's own places, is that angle: a file with 1.5708
means a right angle, and taken literally its axes miss parallel and perpendicular by 3.7e-6 rad. With few places a
decimal says less, so it has to be a rarer angle: a multiple of π/4 with three places, of π/2 with two. No threshold is
needed, and zero stays zero.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Decimal, localcontext
from math import degrees, inf, isfinite, isinf, nan, pi, radians, sqrt
from operator import add, mul, neg, pos, sub, truediv
from typing import Any

from rankdrop.errors import OptionError, RobotError
from rankdrop.robot.files import LONGEST_TEXT, RANGE, allowed_range

_UNITS: dict[str, dict[str, float]] = {
    "angle": {"rad": 1.0, "deg": radians(1.0), "°": radians(1.0)},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254},
    "number": {},
}
# possessive: a character once read is not read again, so that a long text takes no longer than its length
_ARITHMETIC = re.compile(r"(?:(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?+(?![\w.])|pi\b|sqrt\b|[-+*/() ])*+")
_WITH_UNIT = re.compile(r"(?P<value>.*?)\s*(?P<unit>[A-Za-zµ°]+)?(?P<rate>/s)?", re.DOTALL)

_SIGNS: dict[type, Callable[[float], float]] = {ast.USub: neg, ast.UAdd: pos}
_OPERATORS: dict[type, Callable[[float, float], float]] = {ast.Add: add, ast.Sub: sub, ast.Mult: mul, ast.Div: truediv}

LETTERS_ALLOWED = "a letter, then letters and digits; not pi, sin, cos, nor s, c, t or q with a number"

_PI = Decimal("3.14159265358979323846264338327950288419716939937510582")
_DIGITS = 60  # of the arithmetic: more than any file prints, and than π above has
_PARTS = {2: 2, 3: 4}  # places -> parts of π
_FINEST = 12
_LARGEST = 8 * 3.15  # [rad], four turns: no drawing has a larger fixed angle
_DECIMAL = re.compile(r"[+-]?\d*\.(\d*)(?:[eE]([+-]?\d{1,3}))?", re.ASCII)
_RADIANS = re.compile(r"\s*rad\s*\Z")


def quantity(value: Any, measure: str, *, where: str, rate: bool = False, endless: bool = False) -> float:
    """A number in rad or m from a number or a text.

    A text is arithmetic with `+ - * / ( )`, `pi` and `sqrt(…)`, then at most one unit, which applies to the whole
    text: "180 - 36.5 deg" is 143.5 degrees.

    Args:
        value: the number or the text.
        measure: "angle" (rad, deg, °), "length" (m, cm, mm, in) or "number" (no unit).
        where: for the error: file, line, key.
        rate: per second ("180 deg/s").
        endless: ±inf is allowed (limits).

    Raises:
        RobotError: not a number, not finite, too large, a unit of another measure, a text that is not arithmetic.

    Example:
        >>> quantity("-3*pi/4", "angle", where="theta"), quantity("316 mm", "length", where="d")
        (-2.356194490192345, 0.316)
    """
    if isinstance(value, str):
        result = _from_text(value, measure, where, rate)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        result = _float(value)
    else:
        raise _error("this is not a number", value, measure, where, rate)
    if not (isfinite(result) or (endless and abs(result) == inf)):
        raise _error("the value is not finite", value, measure, where, rate)
    if isinf(result):
        return result
    return in_range(result, measure, where=where, got=value, rate=rate)


def in_range(value: float, measure: str, *, where: str, got: Any = None, rate: bool = False) -> float:
    """The value, where it lies in the range that all readers have for its measure.

    Args:
        value: finite [rad, m].
        measure: "angle", "length" or "number".
        where: for the error: file, line, key.
        got: as it was written; None for the value itself.
        rate: per second.

    Raises:
        RobotError: it does not.
    """
    if abs(value) > RANGE[measure]:
        raise RobotError("the value is too large", where=where, got=value if got is None else got,
                         allowed=allowed_range(measure, rate=rate))  # fmt: skip
    return value


def _from_text(text: str, measure: str, where: str, rate: bool) -> float:
    units = _UNITS[measure]
    body, factor = text.strip(), 1.0
    if len(body) > LONGEST_TEXT:  # before the expressions below see it: their time grows with the square of the length
        got = f"{len(body)} characters: {body[:40]!r} …"
        raise _error("the text is too long for a quantity", got, measure, where, rate)
    if body in {"inf", "+inf", "-inf", "nan"}:
        return float(body)
    match = _WITH_UNIT.fullmatch(body)
    if match is None:
        raise _error("the text is not a quantity", repr(text), measure, where, rate)
    unit = match["unit"]
    if unit not in {None, "pi"} or match["rate"]:
        if unit not in units or bool(match["rate"]) is not rate:
            raise _error("the unit is not one that fits here", repr(text), measure, where, rate)
        body, factor = match["value"], units[unit]
    if not body or not _ARITHMETIC.fullmatch(body):
        raise _error("the text is not a quantity", repr(text), measure, where, rate)
    try:
        return _evaluate(ast.parse(body.strip(), mode="eval").body) * factor
    except (SyntaxError, ValueError, ZeroDivisionError, OverflowError, RecursionError, MemoryError):
        raise _error("the text is not a quantity", repr(text), measure, where, rate) from None


def _evaluate(node: ast.expr) -> float:
    match node:
        case ast.Constant(value=int() | float() as number):
            return _float(number)
        case ast.Name(id="pi"):
            return pi
        case ast.UnaryOp(op=sign, operand=operand) if type(sign) in _SIGNS:
            return _SIGNS[type(sign)](_evaluate(operand))
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in _OPERATORS:
            return _OPERATORS[type(operator)](_evaluate(left), _evaluate(right))
        case ast.Call(func=ast.Name(id="sqrt"), args=[operand], keywords=[]):
            return sqrt(_evaluate(operand))
    raise ValueError


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:  # an integer beyond the doubles
        return nan


def _error(what: str, got: Any, measure: str, where: str, rate: bool) -> RobotError:
    units = ", ".join(f"{unit}/s" if rate else unit for unit in _UNITS[measure])
    return RobotError(
        what,
        where=where,
        got=got,
        allowed="a finite number, or text with + - * / ( ), pi, sqrt()" + (f" and a unit ({units})" if units else ""),
    )


def degrees_text(q: Iterable[float], units: Iterable[str]) -> str:
    """A configuration as people set it.

    Args:
        q: values of the joints [rad, m].
        units: of the joints: `Joint.unit`.

    Example:
        >>> degrees_text([0.0, -1.5707963267948966, 0.1], ["rad", "rad", "m"])
        '(0°, −90°, 0.1 m)'
        >>> degrees_text([1e-14, -2.2e-13], ["rad", "m"])  # what rounding left of zero
        '(0°, 0 m)'
    """
    parts = (f"{round(degrees(x), 9) + 0.0:.4g}°" if unit == "rad" else f"{round(x, 9) + 0.0:.4g} m"
             for x, unit in zip(q, units, strict=True))  # fmt: skip
    return f"({', '.join(parts)})".replace("-", "−")


def count(number: int, one: str, many: str = "") -> str:
    """ "1 axis", "3 axes", "1,000 starts": `many` where it is not `one` with an s."""
    return f"{number:,} {one if number == 1 else many or one + 's'}"


def is_letter(name: object) -> bool:
    """Whether conditions can write a length with this name: nothing else that they contain is called so.

    Example:
        >>> is_letter("d3"), is_letter("upper_arm"), is_letter("c23"), is_letter("2a")
        (True, True, False, False)
    """
    shape = isinstance(name, str) and re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name)
    return bool(shape) and not re.fullmatch(r"[sctqθ]\d+|pi|sin|cos", str(name))


def checked_lengths(given: Iterable[tuple[Any, Any]], where: Callable[[str], str]) -> tuple[tuple[str, float], ...]:
    """Letters and their values [m], in the order given.

    Args:
        given: (letter, number in m or text with a unit of length).
        where: place of a letter in words, for errors.

    Raises:
        RobotError: a name that means something else in conditions, or that is there twice; a value that is not a
            length or not positive.
    """
    lengths: dict[str, float] = {}
    for name, value in given:
        place = where(str(name))
        if not is_letter(name):
            raise RobotError(
                "a length cannot have this name", where=place, got=repr(name), allowed=LETTERS_ALLOWED, mend="rename it"
            )
        if name in lengths:
            raise RobotError("two lengths have the same letter", where=place, got=repr(name), mend="rename one")
        length = quantity(value, "length", where=place)
        if length <= 0.0:
            raise RobotError(
                "a length with a letter is positive", where=place, got=value, allowed="a length > 0",
                mend="leave out lengths that are zero; write the value without its sign: −a is found too",
            )
        lengths[name] = length
    return tuple(lengths.items())


def read_lengths(text: str | Mapping[str, float]) -> str | dict[str, float]:
    """Lengths in conditions, also as they are typed: a word, or letters with values [m]: "a=0.635,d=120mm".

    Raises:
        OptionError: neither.
    """
    if not isinstance(text, str):
        return dict(text)
    if "=" not in text:
        return text.strip()
    lengths: dict[str, float] = {}
    for word in text.replace(";", ",").split(","):
        name, equals, value = (part.strip() for part in word.partition("="))
        if not (name and equals and value) or name in lengths:
            raise OptionError(
                "this is not a list of lengths", where="lengths", got=repr(word.strip() or text),
                allowed='each letter once, with its value: "a=0.635,d=120mm"',
            )  # fmt: skip
        try:
            lengths[name] = quantity(value, "length", where=f"lengths, {name}")
        except RobotError as error:
            raise OptionError(**error.parts) from error
    return lengths


def read_joints(text: str | Iterable[int]) -> tuple[int, ...]:
    """Numbers of joints in order, also as people write them: "2-7", "1,2,4-7".

    Raises:
        OptionError: something else.
    """
    if not isinstance(text, str):
        return tuple(sorted(text))
    joints: list[int] = []
    for word in text.replace("–", "-").replace(",", " ").split():
        first, _, last = word.partition("-")
        if not first.isdecimal() or ("-" in word and not last.isdecimal()):
            raise OptionError("these are no joints", where="basic", got=repr(word),
                              allowed="numbers and runs, such as 2-7 or 1,2,4-7")  # fmt: skip
        joints += range(int(first), int(last or first) + 1)
    return tuple(sorted(joints))


class Written(float):
    """A float that knows how it was written; for `tomllib.loads(…, parse_float=Written)`."""

    text: str

    def __new__(cls, text: str) -> Written:
        """The float of a text, with the text."""
        made = super().__new__(cls, text)
        made.text = text
        return made


@dataclass(slots=True)
class Angles:
    """Reads the fixed angles of one file, and remembers what it changed.

    Attributes:
        as_written: take every number literally.
        changes: angle taken less angle written [rad], for each number that was changed.
        largest: of the numbers without a unit that were read, without sign [rad].
    """

    as_written: bool = False
    changes: list[float] = field(default_factory=list)
    largest: float = 0.0

    def take(self, text: str) -> float:
        """The angle [rad] that a decimal text stands for."""
        if self.as_written:
            value, change = (float(text), 0.0)
        else:
            value, change = angle(text)
        if change:
            self.changes.append(change)
        self.largest = max(self.largest, abs(value))
        return value

    def quantity(self, value: Any, *, where: str) -> float:
        """The angle [rad] of an entry of a table, as `quantity` reads it; decimals in radians by the rule of digits.

        Raises:
            RobotError: as `quantity`.
        """
        read = quantity(value, "angle", where=where)
        if isinstance(value, int | float):
            self.largest = max(self.largest, abs(read))
        if isinstance(value, Written):
            text = value.text
        elif isinstance(value, str):
            text = _RADIANS.sub("", value)
        else:
            text = ""
        if _DECIMAL.fullmatch(text.strip()):
            return self.take(text.strip())
        return read


def angle(text: str) -> tuple[float, float]:
    """The angle [rad] that a decimal stands for, and by how much that changes the number.

    Args:
        text: a number as a file writes it, "-1.5708" or "1.5708e+00"; places count after the point of the plain
            decimal.

    Returns:
        (angle, angle less the number as written): the nearest double of the multiple of π/12, and what that changes;
        (the number itself, 0.0) where the rule says nothing.

    Example:
        >>> angle("1.5708"), angle("0.35")
        ((1.5707963267948966, -3.673205103380...e-06), (0.35, 0.0))
    """
    value = float(text)
    match = _DECIMAL.fullmatch(text.strip())
    if match is None or value == 0.0 or abs(value) > _LARGEST:
        return value, 0.0
    places = len(match[1]) - int(match[2] or 0)
    if not 2 <= places <= _DIGITS - 10:
        return value, 0.0
    with localcontext() as context:
        context.prec = _DIGITS
        written = Decimal(text.strip())
        part = _PI / _PARTS.get(places, _FINEST)
        exact = round(written / part) * part
        last = Decimal(1).scaleb(-places)
        ways = [exact.quantize(last, rounding=way) for way in (ROUND_HALF_EVEN, ROUND_DOWN)]
        if exact == 0 or written not in ways:
            return value, 0.0
        taken = float(exact)
        return taken, float(exact - written) if taken != value else 0.0
