"""How far the next singularity is: the nearest found, each known family, a radius that is proven free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rankdrop.certify.ball import LARGEST, Certificate, certified_radius
from rankdrop.errors import OptionError
from rankdrop.families.distance import FamilyDistance, family_distances
from rankdrop.families.search_record import Outcome
from rankdrop.families.searching import refine
from rankdrop.family.which import Met
from rankdrop.local.nearest import Nearest, nearest_singularity
from rankdrop.results.explanation.data import Asked, Far
from rankdrop.results.explanation.which import met_at

_SEEDS = 8  # nearest points of families that the search begins from


def how_far(asked: Asked) -> Far:
    """Distances from the configuration asked about."""
    away, rank, settings = _families_away(asked), asked.rank, asked.settings
    if rank.corank:
        return Far(None, None, away, None, "the configuration is singular")
    if rank.generic_rank == 0:
        return Far(None, None, away, None, "the arm moves nothing")
    try:
        nearest = nearest_singularity(
            asked.robot, asked.q, asked.task, limits=settings.limits, seed=settings.seed,
            seeds=tuple(one.q for one in away[:_SEEDS]), tolerances=settings.tolerances,
        )  # fmt: skip
    except OptionError as error:  # a long arm: rank, σ and all that is said at q itself do not need the distance
        return Far(None, None, away, None, f"{error.what}: {error.got}")
    certificate, reason = _certificate(asked, nearest)
    miss = _near_miss(asked) if float(rank.sigma[rank.generic_rank - 1]) <= settings.small else None
    if nearest is None:
        return Far(None, None, away, certificate, reason, miss)
    there = met_at(asked, np.array(nearest.q), nearest.corank)
    closer = sorted((_no_farther(one, nearest, there) for one in away), key=lambda one: one.distance)
    return Far(nearest, there[0], tuple(closer), certificate, reason, miss)


def _families_away(asked: Asked) -> tuple[FamilyDistance, ...]:
    """Families that were reached and do not hold here."""
    settings = asked.settings
    targets = [one for one in asked.families if one.corank <= asked.coranks]
    every = family_distances(targets, asked.robot, asked.q, asked.task, limits=settings.limits, seed=settings.seed)
    least = settings.tolerances.explained if asked.rank.corank else -np.inf
    return tuple(one for one in every if least < one.distance < np.inf)


def _no_farther(record: FamilyDistance, nearest: Nearest, there: Sequence[Met]) -> FamilyDistance:
    """A family through the point that the search found is no farther away than that point."""
    through = any(met.family is record.family for met in there)
    if not through or record.distance <= nearest.distance:
        return record
    return replace(record, distance=nearest.distance, q=nearest.q, delta=nearest.delta, sigma=nearest.sigma)


def _certificate(asked: Asked, nearest: Nearest | None) -> tuple[Certificate | None, str]:
    """Within the limits the nearest singularity may lie farther than one outside them, and bounds nothing."""
    bounded = nearest is not None and not asked.settings.limits
    at_most = min(LARGEST, nearest.distance * (1 + 1e-9)) if nearest is not None and bounded else LARGEST
    evaluations = asked.settings.evaluations
    try:
        return certified_radius(asked.robot, asked.q, asked.task, at_most=at_most, evaluations=evaluations), ""
    except OptionError as error:
        if error.got == evaluations:  # no budget; else a task that cannot be certified
            raise
        return None, error.what


def _near_miss(asked: Asked) -> float | None:
    """σ_r at the nonzero local minimum that a descent from q ends in; None where it ends in a singularity."""
    settings = asked.settings
    found = refine(
        asked.robot, asked.q[None, :], 1, task=asked.task, seed=settings.seed, tolerances=settings.tolerances, threads=1
    )
    return found.smallest_near_miss if found.outcome[0] == Outcome.NEAR_MISS else None
