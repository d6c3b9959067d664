"""A time limit that is asked between steps."""

from __future__ import annotations

from time import monotonic


class OutOfTime(Exception):
    """The time is up, or a case goes deeper than is followed: what was being derived is left unfinished."""


class Deadline:
    """A moment.

    Args:
        seconds: from now.
    """

    def __init__(self, seconds: float) -> None:
        self._end = monotonic() + seconds

    def check(self) -> None:
        """Raises OutOfTime when the moment has passed."""
        if monotonic() > self._end:
            raise OutOfTime
