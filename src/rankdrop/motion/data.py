"""What is known of a path: its verdict, its stretches, where it meets a singularity, and its profile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.motion.curve import Index
from rankdrop.robot.model import Array
from rankdrop.tolerances import Tolerances

FREE, CROSSING, TOUCHING, TOO_NEAR, UNDECIDED = "free", "crossing", "touching", "too near", "undecided"
VERDICTS = (CROSSING, TOUCHING, TOO_NEAR, UNDECIDED, FREE)
"""Worst first."""
LEADS = 1e-6
"""A free stretch that comes nearer than this leads to a meeting at one of its ends [rad]."""


@dataclass(frozen=True, slots=True)
class Place:
    """A point of a path.

    Attributes:
        row: number of the sample before it, from 1.
        share: of the way to the next sample, 0 … 1.
        time: [s]; None without times.
    """

    row: int
    share: float
    time: float | None


@dataclass(frozen=True, eq=False)
class Closest:
    """Where a stretch is nearest to a singularity.

    Attributes:
        place: on the path.
        q: (n,) configuration there [rad, m].
        distance: to the nearest configuration known or found [rad; slides divided by the length scale]; 0 at a
            singularity, inf where none is known.
        foot: (n,) that configuration; empty where none is known.
        sigma: σ_r there [1].
        weak: share of the tool's travel there that goes along the direction of σ_r, the one that is lost first, 0 … 1;
            nan where the tool stands still.
    """

    place: Place
    q: Array
    distance: float
    foot: Array
    sigma: float
    weak: float


@dataclass(frozen=True, eq=False)
class Stretch:
    """A part of a path with one verdict and one nearest family.

    Attributes:
        start, end: its ends.
        bracket: two places inside, a zero between them where it is a crossing; its ends on a free stretch.
        verdict: "free" (proven), "crossing", "touching" or "undecided".
        family: id of the family met or nearest; "" where there is none.
        name: of that family.
        closest: where it is nearest to a singularity; where it meets one, the configuration.
        corank: of the singularity met; 0 on a free stretch.
        lies: all of it is singular, as far as it was looked at.
        how: how it is known.
        lost: sentences on what is lost where it meets a singularity.
        null_share: share of the joints' motion there that does not move the task, 0 … 1; nan on a free stretch.
        rates: (n,) largest joint rates of the commanded motion [rad/s, m/s]; empty without times.
        speed_factor: largest factor, at most 1, that brings them within the velocity limits; nan where there are no
            times or no limits.
        slowest: number from 1 of the joint that decides it; 0 where none does.
    """

    start: Place
    end: Place
    bracket: tuple[Place, Place]
    verdict: str
    family: str
    name: str
    closest: Closest
    corank: int
    lies: bool
    how: str
    lost: tuple[str, ...]
    null_share: float
    rates: Array
    speed_factor: float
    slowest: int


@dataclass(frozen=True, eq=False)
class Profile:
    """Numbers along the path, at places close enough to draw.

    Attributes:
        position: (P,) rows, from 1, with fractions.
        time: (P,) [s]; None without times.
        distance: (P,) to the nearest known family; nan where none is known.
        family: (P,) index into `ids` of that family; −1 where none is known.
        sigma: (P,) σ_r.
        rates: (P,) largest share of a velocity limit that the commanded motion needs; nan without.
        ids: of the families.
    """

    position: Array
    time: Array | None
    distance: Array
    family: Index
    sigma: Array
    rates: Array
    ids: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PathSettings:
    """What was asked, and the thresholds.

    Attributes:
        interpolate: between samples.
        min_distance: to be kept [rad; slides divided by the length scale]; 0: none.
        limits: distances to singularities within the joint limits only.
        evaluations: enclosures that may be spent.
        length_scale: translation is divided by it [m].
        tolerances: thresholds.
        version: of rankdrop.
        frame: in whose axes lost motions are told: "base", "tool" or "link".
    """

    interpolate: str
    min_distance: float
    limits: bool
    evaluations: int
    length_scale: float
    tolerances: Tolerances
    version: str
    frame: str = "base"


@dataclass(frozen=True, eq=False)
class ToolMotion:
    """A path that was given by poses of the tip, and how its joint values were found.

    Attributes:
        poses: how many were given.
        complete: all of them were reached.
        reached: number of the last pose reached, from 1, with the share of the way to the next.
        reason: why it ended: "" where complete, else "singular", "limit" or "stuck".
        words: the same as a sentence.
        start: (n,) configuration at the first pose.
        chosen: which branch that is, in words.
        place: (rows,) pose of each row, from 1, with shares.
        off: how far the tip leaves its straight line half way between two rows, at most [m]; measured.
    """

    poses: int
    complete: bool
    reached: float
    reason: str
    words: str
    start: tuple[float, ...]
    chosen: str
    place: Array
    off: float

    def pose_at(self, place: Place) -> float:
        """Number of the pose at a place of the path, with the share of the way to the next."""
        return float(np.interp(place.row - 1 + place.share, np.arange(len(self.place)), self.place))
