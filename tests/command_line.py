"""One command line and how it ended; the fixtures `run` and `process` of conftest.py run it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Ended:
    """How a command line ended."""

    code: int
    out: str
    err: str


Run = Callable[..., Ended]


def command(*argv: str) -> list[str]:
    """The words that start `rankdrop` with this Python."""
    return [sys.executable, "-m", "rankdrop.cli.main", *argv]
