"""Whole numbers on the command line: 1.5 is refused, not rounded."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any

from cyclopts import Parameter, Token

_WHOLE = re.compile(r"[+-]?\d+(_\d+)*", re.ASCII)
_LONGEST = 100


def whole(_type: Any, tokens: Sequence[Token]) -> int:
    """The number that the words of one option write: 10000, 10_000, -5.

    Raises:
        ValueError: not a whole number; cyclopts names the option.
    """
    text = tokens[0].value.strip()
    if not _WHOLE.fullmatch(text) or len(text) > _LONGEST:
        raise ValueError(f"this is not a whole number; got {text[:40]!r}; allowed: digits, such as 10000 or 10_000.")
    return int(text)


Whole = Annotated[int, Parameter(converter=whole)]
