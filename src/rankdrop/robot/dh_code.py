"""Code around a table: lines without comments, names with their values, the arguments of a call."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass

from rankdrop.errors import RobotError

_LONGEST_CALL = 600  # characters of the arguments of one call
_COMMENT = re.compile(r"[%#].*|//.*")
_GOES_ON = re.compile(r"\.\.\.\s*$")
_ASSIGNED = re.compile(
    r"(?:^|[;,{(&|:]|\b(?:and|where|with)\b)\s*(?:(?:double|float|const|self\.)\s*)*(?P<name>[A-Za-z_]\w{0,40})\s*=\s*"
    r"(?P<value>(?:(?!\s(?:and|where|with)\s)[^=;,#%\n]){1,80})"
)
_END_OF_SENTENCE = re.compile(r"(?<=\d)\.$")


def without_comment(line: str) -> str:
    """A line of Python, MATLAB or C++ without its comment."""
    return _COMMENT.sub("", line)


def code_of(lines: list[str]) -> str:
    """Lines as one text, without comments and MATLAB's signs that a statement goes on."""
    return "\n".join(_GOES_ON.sub("", without_comment(line)) for line in lines)


def line_starts(code: str) -> list[int]:
    """The places at which the lines of a text begin, for `line_at`."""
    starts = [0]
    for found in re.finditer("\n", code):
        starts.append(found.end())
    return starts


def line_at(place: int, starts: list[int]) -> int:
    """The number of the line that contains a place of a text."""
    return bisect_right(starts, place)


def constants_in(lines: list[str]) -> dict[str, str]:
    """Names with their expressions; of two different expressions both, with a bar between.

    Example:
        >>> constants_in(["a2 = 0.25, d1 = h;", "where h = 0.1 and a2 = 0.3"])
        {'a2': '0.25 | 0.3', 'd1': 'h', 'h': '0.1'}
    """
    constants: dict[str, str] = {}
    for line in lines:
        for found in _ASSIGNED.finditer(line):
            value = _END_OF_SENTENCE.sub("", found["value"].strip())
            before = constants.get(found["name"])
            if before not in (None, value):
                value = f"{before} | {value}"
            constants[found["name"]] = value
    return constants


@dataclass(frozen=True)
class CallArguments:
    """The arguments of one call.

    Attributes:
        words: the arguments, split at the commas outside brackets.
        end: the place in the text behind them.
        closed: there is a closing bracket.
    """

    words: tuple[str, ...]
    end: int
    closed: bool


def call_arguments(code: str, start: int) -> CallArguments:
    """The arguments of a call; they begin at a place, behind the opening bracket.

    Example:
        >>> call_arguments("f(d=1, qlim=[0, 2])", 2)
        CallArguments(words=('d=1', 'qlim=[0, 2]'), end=19, closed=True)
    """
    words: list[str] = []
    word_start = start
    depth = 0
    end = min(start + _LONGEST_CALL, len(code))
    for place in range(start, end):
        letter = code[place]
        if depth == 0 and letter in ",)":
            words.append(code[word_start:place].strip())
            word_start = place + 1
            if letter == ")":
                return CallArguments(tuple(words), place + 1, closed=True)
        elif letter in "([{":
            depth += 1
        elif letter in ")]}":
            depth -= 1
    words.append(code[word_start:end].strip())
    return CallArguments(tuple(words), end, closed=False)


def call_without_end(call: str, where: str) -> RobotError:
    """The refusal of a call without a closing bracket."""
    return RobotError("a call has no end", where=where, got=call,
                      allowed=f"a closing bracket within {_LONGEST_CALL} characters")  # fmt: skip
