"""The count of a check."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Check:
    """Of `tested` random points `agree` behaved as claimed."""

    tested: int
    agree: int

    @property
    def holds(self) -> bool:
        """All of them, and there was at least one."""
        return 0 < self.tested == self.agree
