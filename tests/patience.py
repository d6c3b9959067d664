"""Waiting for another thread or process: how long that takes is the machine's business, so the wait ends late."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic, sleep


def until(holds: Callable[[], object], seconds: float = 180.0) -> None:
    """Wait until something holds.

    Args:
        holds: is asked a hundred times a second.
        seconds: after so long the test fails: what it waits for never comes.
    """
    end = monotonic() + seconds
    while not holds():
        assert monotonic() < end, "it never came true"
        sleep(0.01)
