"""How far is the nearest singularity, by search, by known families and proven; and do these agree?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from rankdrop.configuration import Configuration
from rankdrop.cover.ball import LARGEST, Certificate, certified_radius
from rankdrop.distance.distance import FamilyDistance
from rankdrop.errors import OptionError
from rankdrop.families.incidence import Incidence
from rankdrop.local.nearest import Nearest
from rankdrop.local.ways_out import JointEscape
from rankdrop.questions import ExplainOptions
from rankdrop.results.explained import Difference, DifferenceKind
from rankdrop.sections import words_of

_AS_GOOD = 1e-4  # what a radius may stay below the distance of the singularity that was found, as a share of it
_AGREE = 1e-6  # distances that differ by less are the same: σ of second order leaves half the digits [rad]


@dataclass(frozen=True, eq=False)
class Far:
    """How far the next singularity is.

    Attributes:
        configuration: from which it is measured, for a task.
        options: budgets.
        nearest: the nearest singular configuration that was found; None where none was.
        nearest_family: a family it belongs to.
        families: distance to each known family that does not hold here, nearest first.
        unasked: why a regular configuration has no certified radius; empty where it has.
        near_miss: σ_r of the smallest nonzero local minimum met from here; None unless that is what is near.
    """

    configuration: Configuration
    options: ExplainOptions
    nearest: Nearest | None
    nearest_family: Incidence | None
    families: tuple[FamilyDistance, ...]
    unasked: str = ""
    near_miss: float | None = None

    @property
    def certificate(self) -> Certificate | None:
        """Ball proven free of singularities, worked out when it is first asked for; None where the task cannot be
        certified (`uncertified` says why) or the configuration is singular."""
        return self._certificate_and_reason[0]

    @property
    def uncertified(self) -> str:
        """Why there is no certificate; empty where there is one."""
        return self._certificate_and_reason[1]

    @cached_property
    def _certificate_and_reason(self) -> tuple[Certificate | None, str]:
        """Within the limits the nearest singularity may lie farther than one outside them, and bounds nothing."""
        if self.unasked:
            return None, self.unasked
        configuration = self.configuration
        if configuration.measured.corank:
            return None, words_of(self).SINGULAR_HERE
        if self.nearest is not None and not self.options.limits:
            distance = self.nearest.distance
        else:
            distance = float("inf")
        try:
            return certified_radius(
                configuration.robot, configuration.q, configuration.task, at_most=min(LARGEST, distance * (1 + 1e-9)),
                enough=distance * (1 - _AS_GOOD), evaluations=self.options.evaluations,
            ), ""  # fmt: skip
        except OptionError as error:  # a task that cannot be certified
            return None, error.what


def differences(far: Far, single: Sequence[JointEscape]) -> Iterator[Difference]:
    """Two methods, two answers: on what a joint alone regains, and on how far."""
    for gain in single:
        if not gain.agrees:
            yield Difference(DifferenceKind.GAIN, number=gain.number, predicted=gain.gain, measured=gain.measured_gain)
    nearest, certificate = far.nearest, far.certificate
    if nearest is not None and certificate is not None and certificate.radius > nearest.distance * (1 + 1e-8):
        yield Difference(DifferenceKind.RADIUS, radius=certificate.radius, distance=nearest.distance)
    if nearest is not None and far.families and all(point.family.named for point in far.families):
        first = min(far.families, key=lambda point: point.distance)
        if first.distance < nearest.distance - _AGREE:
            yield Difference(DifferenceKind.SEARCH_MISSED, family=first.family)
        elif not first.distance <= nearest.distance + _AGREE:
            yield Difference(DifferenceKind.FAMILIES_MISSED)


def no_farther(record: FamilyDistance, nearest: Nearest, incidences: Sequence[Incidence]) -> FamilyDistance:
    """A family through the point that the search found is no farther away than that point."""
    through = any(incidence.family is record.family for incidence in incidences)
    if not through or record.distance <= nearest.distance:
        return record
    return replace(record, distance=nearest.distance, q=nearest.q, delta=nearest.delta, sigma=nearest.sigma)
