"""Scanning that the readers of all languages of programs share: lines, statements, brackets, and numbers.

Everything here takes time proportional to the length of a line: no regular expression has a repetition inside another.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from math import isfinite

from rankdrop.errors import visible
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.files import LARGEST_TIME

LARGEST_PROGRAM, MOST_LINES, LONGEST_LINE = 10 * 2**20, 200_000, 20_000
"""Bytes of a program, its lines, and characters of a line or of a statement over several lines."""
_DEEPEST = 8  # brackets inside brackets of a literal
_SHOWN = 72  # characters of a line that are kept
_DIGITS = 50  # characters of a number
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_DEEPER = {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}  # brackets: by how much


def shorten_line(text: str) -> str:
    """The beginning of a line, for people."""
    plain = visible(" ".join(text.split()))
    if len(plain) <= _SHOWN:
        return plain
    return f"{plain[: _SHOWN - 2]} …"


def lines_of(text: str, where: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers, from 1.

    Raises:
        TrajectoryError: there are too many, or one is too long.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if len(lines) > MOST_LINES:
        raise TrajectoryError("the program has too many lines", where=where, got=len(lines),
                              allowed=f"at most {MOST_LINES:,}")  # fmt: skip
    for count, line in enumerate(lines, start=1):
        if len(line) > LONGEST_LINE:
            raise TrajectoryError("the line is too long", where=f"{where}, line {count}", got=f"{len(line)} characters",
                                  allowed=f"at most {LONGEST_LINE:,}")  # fmt: skip
        yield count, line


def check_length(size: int, where: str) -> None:
    """Refuse a statement over several lines that is longer than all readers accept.

    Args:
        size: its characters.
        where: the file, and the line on which the statement begins.

    Raises:
        TrajectoryError: the statement is longer.
    """
    if size > LONGEST_LINE:
        raise TrajectoryError("the statement is too long", where=where,
                              allowed=f"at most {LONGEST_LINE:,} characters")  # fmt: skip


def open_brackets(line: str, before: int = 0) -> int:
    """How many brackets outside quotes are open at the end of a line, of which `before` at its beginning.

    Example:
        >>> open_brackets("movej([0, 1,"), open_brackets("2], a=1)", before=2), open_brackets("])")
        (2, 0, 0)
    """
    depth = before
    for _, letter in _outside_quotes(line):
        depth = max(depth + _DEEPER.get(letter, 0), 0)
    return depth


def _outside_quotes(text: str) -> Iterator[tuple[int, str]]:
    """Places and letters of a text that are in no quotes."""
    quoted = False
    for place, letter in enumerate(text):
        if letter == '"':
            quoted = not quoted
        elif not quoted:
            yield place, letter


def number(text: str) -> float | None:
    """A number as every language writes it; None for everything else.

    Example:
        >>> number(" -1.5e2 "), number("x"), number("1e999")
        (-150.0, None, None)
    """
    plain = text.strip()
    if len(plain) <= _DIGITS and _NUMBER.fullmatch(plain):
        value = float(plain)
    else:
        value = float("nan")
    return value if isfinite(value) else None


def statements_of(
    text: str, name: str, mark: str, begins: Callable[[str], bool]
) -> Iterator[tuple[int, str]]:  # fmt: skip
    """Statements without comments, with the number of the line on which each begins.

    A statement ends with its line, or, where a bracket is open there, with the line that closes it; a line that begins
    with a word that stands in no bracket is a statement of its own.

    Args:
        text: of the program.
        name: of its file, for errors.
        mark: what a comment begins with.
        begins: whether a line begins with such a word.
    """
    begun, depth, size = 0, 0, 0
    kept: list[str] = []
    for count, line in lines_of(text, name):
        plain = without_comment(line, mark)
        if kept and begins(plain):
            yield begun, " ".join(kept)
            kept, depth, size = [], 0, 0
        if not kept:
            begun = count
        kept.append(plain)
        size += len(plain) + 1
        check_length(size - 1, f"{name}, line {begun}")
        depth = open_brackets(plain, depth)
        if depth == 0:
            yield begun, " ".join(kept)
            kept, size = [], 0
    if kept:
        yield begun, " ".join(kept)


def without_comment(line: str, mark: str) -> str:
    """A line up to a mark outside quotes."""
    for place, letter in _outside_quotes(line):
        if letter == mark:
            return line[:place]
    return line


def parts_of(text: str, mark: str = ",", *, brackets: bool = True) -> list[str]:
    """Parts between marks that are in no quotes and, with `brackets`, in no brackets; stripped.

    Example:
        >>> parts_of("[1, 2], v100, Offs(p, 0, 0, 1)")
        ['[1, 2]', 'v100', 'Offs(p, 0, 0, 1)']
    """
    parts, depth, begin = [], 0, 0
    for place, letter in _outside_quotes(text):
        if brackets:
            depth += _DEEPER.get(letter, 0)
        if letter == mark and depth == 0:
            parts.append(text[begin:place].strip())
            begin = place + 1
    return [*parts, text[begin:].strip()]


def split_bracket(text: str, opens: str = "(") -> tuple[str, str] | None:
    """What is in the bracket that a text begins with, and what follows it; None where it is not closed."""
    plain = text.lstrip()
    if not plain.startswith(opens):
        return None
    depth = 0
    for place, letter in _outside_quotes(plain):
        depth += _DEEPER.get(letter, 0)
        if depth == 0:
            return plain[1:place], plain[place + 1 :]
    return None


def numbers_of(text: str) -> list[object] | None:
    """Numbers in square brackets, nested at most `_DEEPEST` deep; None where something else is in them.

    Example:
        >>> numbers_of("[[1,2],[3]]"), numbers_of("[1, x]")
        ([[1.0, 2.0], [3.0]], None)
    """
    return _numbers(text.strip(), 0)


def _numbers(text: str, depth: int) -> list[object] | None:
    bracket = split_bracket(text, "[")
    if bracket is None or bracket[1].strip() or depth > _DEEPEST:
        return None
    listed: list[object] = []
    for part in parts_of(bracket[0]):
        value = _numbers(part, depth + 1) if part.startswith("[") else number(part)
        if value is None:
            return None
        listed.append(value)
    return listed


def flat(values: object, count: int) -> list[float] | None:
    """A list of exactly so many numbers; None for everything else."""
    if not isinstance(values, list) or len(values) != count:
        return None
    numbers = [value for value in values if isinstance(value, float)]
    if len(numbers) == count:
        return numbers
    return None


def positive(value: float | None, factor: float = 1.0) -> float | None:
    """A speed or a time in SI units; None where it is not positive, or beyond every clock."""
    if value is None or not 0.0 < value * factor <= LARGEST_TIME:
        return None
    return value * factor
