"""Remedies of a path as records: changed paths to be checked, remedies that a new check proved, and failures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from rankdrop.codec import Result
from rankdrop.path.check.record import PathCheck
from rankdrop.path.check.turns import FarTurn, far_turns
from rankdrop.path.mend.local_change import ON_PATH, LocalChange, size_of_off
from rankdrop.path.mend.retime import Usage
from rankdrop.path.read.trajectory import Trajectory
from rankdrop.robot.model import Array
from rankdrop.sections import Section
from rankdrop.text import remedies as text

BUMP, DETOUR, SLOW, RETIME, NULL, FLIP, BLEND, TILT, SHIFT = (
    "bump", "detour", "slow-down", "retime", "null-space", "flip", "blend", "tool tilt", "base shift",
)  # fmt: skip
KINDS = (NULL, FLIP, BUMP, DETOUR, BLEND, TILT, SHIFT, SLOW, RETIME)
LOCAL = (BUMP, DETOUR, SLOW)
"""Those that change the path around its singularities: a bump keeps the joints of the rest, a detour the tool, a
slow-down all of the path and the time that the rest takes."""
Parameter = tuple[str, float | tuple[float, ...], str]
"""A number, or some, that a remedy is made with: name, value, and unit ("rad, m": joint values; "": none)."""
Failure = tuple[str, Any]
"""A kind without a remedy, and what was tried: as `rankdrop.text.remedies.remedy_note` reads it."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A changed path to be checked.

    Attributes:
        how: what is done, and a fact about it.
        parameters: with which numbers.
        trajectory: its rows.
        off: how far off the tool is [m, rad].
        changes: the parts that are changed; empty where all of it is.
    """

    how: tuple[str, Any]
    parameters: tuple[Parameter, ...]
    trajectory: Trajectory
    off: tuple[float, float]
    changes: tuple[LocalChange, ...] = ()


@dataclass(frozen=True, eq=False)
class Remedy:
    """A path that was mended and checked again.

    Attributes:
        kind: one of `KINDS`.
        how: what is done, and a fact about it.
        parameters: what with.
        gains: distance, speed, duration -> the number before and after; inf or nan where not known. The distance is 0
            where the path reaches a singularity.
        trajectory: the new path; in time where the old one is.
        interpolate: between its rows.
        check: the new judgement: free, proven, with the distance asked for kept. Of retime, which keeps the path, it
            may be any; that kind is accepted by its limits.
        usage: shares of the rate and acceleration limits that it nowhere exceeds, at most 1; None without times or
            limits.
        off: how far the tool is from the path meant, at most, in the middle between two of its rows [m], [rad];
            at the rows it is on it. Of a blend and a bump: from the old path, at sampled points. nan for what the
            task leaves free, and for the turn of a blend.
        retimed: it has a new time law as well, because the old one would break limits.
        changes: of a local remedy the parts that it changes, in order.
    """

    kind: str
    how: tuple[str, Any]
    parameters: tuple[Parameter, ...]
    gains: dict[str, tuple[float, float]]
    trajectory: Trajectory
    interpolate: str
    check: PathCheck
    usage: Usage | None
    off: tuple[float, float]
    retimed: bool
    changes: tuple[LocalChange, ...] = ()

    @property
    def deviation(self) -> tuple[float, float]:
        """How far the tool leaves the path that it was given at most [m], [rad]: `off`, and what the tool is tilted."""
        tilt = next((value for name, value, _ in self.parameters if name == "tool tilt"), 0.0)
        assert isinstance(tilt, float)
        if not tilt:
            return self.off
        return self.off[0], float(np.nan_to_num(self.off[1])) + tilt

    @property
    def turns(self) -> tuple[FarTurn, ...]:
        """Joints that turn far on the new path."""
        return far_turns(self.check.robot, self.check.curve)

    @property
    def rank(self) -> tuple[bool, bool, float, float]:
        """What remedies are sorted by: proven free, the base where it is, deviation of the tool, duration."""
        size = size_of_off(self.deviation, self.check.length_scale)
        _, after = self.gains.get("duration", (0.0, 0.0))
        return not self.check.clear, self.kind == SHIFT, 0.0 if size < ON_PATH else size, after

    @property
    def words(self) -> str:
        """What is done, as a sentence."""
        return text.remedy_words(*self.how)


@dataclass(frozen=True, eq=False)
class Mending(Result):
    """What was tried of a path.

    Attributes:
        before: the judgement of the path as it was.
        remedies: found and proven; those first whose tool leaves its path least, then the shorter ones.
        failures: for each kind without one, what was tried.
        needed: the path needs one: it is not proven free and far enough, or breaks limits.
        complete: False where it was interrupted; what was found until then holds.
    """

    before: PathCheck
    remedies: tuple[Remedy, ...]
    failures: tuple[Failure, ...]
    needed: bool
    complete: bool
    FILE: ClassVar[str] = "remedies"

    @property
    def notes(self) -> tuple[str, ...]:
        """For each kind without a remedy, what was tried and what came of it."""
        return tuple(text.remedy_note(kind, fact) for kind, fact in self.failures)

    @property
    def best(self) -> Remedy | None:
        """The first that is proven free; None where there is none."""
        return next((remedy for remedy in self.remedies if remedy.check.clear), None)

    @property
    def written(self) -> Remedy | None:
        """The remedy that is written to a file: the best, else the first that keeps the limits; None where none is."""
        return self.best or next(iter(self.remedies), None)

    def sections(self, *, deg: bool = True) -> tuple[Section, ...]:
        """As sections of text."""
        return text.remedy_sections(self, deg=deg)

    @property
    def sentence(self) -> str:
        """One line for people."""
        return text.remedies_sentence(self)


def joint_values(name: str, values: Array, unit: str = "rad, m") -> Parameter:
    """Numbers that a remedy is made with: joint values, or others with their unit."""
    return name, tuple((values + 0.0).tolist()), unit
