"""The number of aspects and the verdict on changes of posture as one small record.

`aspects/catalogue.json` holds the record of every arm of the catalogue, for the task that the arm is made for:
`tools/make_aspects.py` writes it, `rankdrop.results.known.known_aspects` reads it.
"""

from __future__ import annotations

from dataclasses import dataclass

CUSPIDAL, NOT_CUSPIDAL, NOT_FOUND = "cuspidal", "not cuspidal", "none found"
"""Verdicts on changes of posture without a singularity: proven, impossible (proven), none found in a search."""
NOT_ASKED = "not asked"
"""Verdict of an arm with more or fewer joints than rows: solutions of a pose are curves, or there are none."""
POSES = 10
"""Random poses that are solved at most for the verdict on an arm outside the catalogue, where nothing is proven."""
FILE = "catalogue.json"
"""Name of the table of the catalogue."""


@dataclass(frozen=True)
class AspectSummary:
    """How many aspects an arm has, and whether it can change its posture without a singularity; joint limits ignored.

    Attributes:
        at_least: proven lower bound; None where nothing was counted.
        at_most: upper bound; None where nothing was counted.
        proven: whether the upper bound is proven too.
        posture_change: `CUSPIDAL`, `NOT_CUSPIDAL`, `NOT_FOUND` or `NOT_ASKED`; None where only aspects were counted.
    """

    at_least: int | None
    at_most: int | None
    proven: bool
    posture_change: str | None = None

    @property
    def number(self) -> int | None:
        """The number of aspects where it is proven; else None."""
        if self.proven and self.at_least == self.at_most:
            return self.at_least
        return None
