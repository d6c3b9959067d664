"""Which singularity is nearest to a configuration, other than the one that the answer is about?"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from operator import itemgetter

import numpy as np

from rankdrop.configuration import Configuration
from rankdrop.errors import OptionError
from rankdrop.families.incidence import Incidence
from rankdrop.families.record import Family
from rankdrop.local.nearest import Elsewhere, other_sheets
from rankdrop.local.special import Special
from rankdrop.problem import wrap
from rankdrop.questions import ExplainOptions
from rankdrop.results.explained import Next
from rankdrop.results.far import Far
from rankdrop.results.slow_family import SlowFamily, loses_along, slow_normals
from rankdrop.robot.model import Array

SEEDS = 8
"""Nearest points of families that a search begins from."""
_SAME_SHEET = 1e-3  # distances that differ by less belong to the same sheet [rad]

Singularity = tuple[Family, float, Array]
"""A family, the distance to it, and its configuration (n,) there."""


@dataclass(frozen=True, eq=False)
class OtherSingularities:
    """Singularities of any sheet, without the one that an answer is about.

    Attributes:
        configuration: from which distances are measured, for a task.
        options: thresholds and budgets.
        far: how far the next singularity is.
        incidences: families that hold at the focus; the first is the one that says most.
        focus: (n,) the configuration that the answer is about.
        slow: the family that makes a motion slow, where the answer is about that.
        families_at: families on which a singular configuration lies, of a corank.
        specials_at: the parts special at a configuration, for a corank.
    """

    configuration: Configuration
    options: ExplainOptions
    far: Far
    incidences: tuple[Incidence, ...]
    focus: Array
    slow: SlowFamily | None
    families_at: Callable[[Array, int], tuple[Incidence, ...]]
    specials_at: Callable[[Array, int], tuple[Special, ...]]

    def nearest(self) -> Next:
        """The nearest of known families, of other values of their joints, and of other sheets that a search finds."""
        others = [*self._known_families(), *self._other_values()]
        again: list[Singularity] = []
        searches = 0
        nearest = self.far.nearest
        if nearest is not None and (self.slow is None or self.slow.ideal is None):
            known = nearest.q
        else:
            known = None
        with suppress(OptionError):  # a long arm: families that are known are all there is
            searches, sheets = other_sheets(
                self.configuration, known, limits=self.options.limits, seed=self.options.seed,
                seeds=tuple(point.q for point in self.far.families[:SEEDS]),
            )  # fmt: skip
            self._add_nearest_sheet(sheets, others, again)
        others = others or again[:1]
        if not others:
            return Next(None, None, searches)
        family, distance, q = min(others, key=itemgetter(1))
        return Next(family, distance, searches, q)

    def _add_nearest_sheet(
        self, sheets: Iterable[Elsewhere], others: list[Singularity], again: list[Singularity]
    ) -> None:
        """Add the first sheet that is nearer than the others; those nearer still that are the answer again apart."""
        least = min((distance for _, distance, _ in others), default=np.inf)
        for sheet in sheets:
            if sheet.distance >= least - _SAME_SHEET:
                return
            if self._is_slow_family(sheet.q, sheet.corank, sheet.distance):
                continue
            q = np.array(sheet.q)
            singularity = self.families_at(q, sheet.corank)[0].family, sheet.distance, q
            if not self._is_same_again(singularity[0], q):
                others.append(singularity)
                return
            again.append(singularity)

    def _is_same_again(self, family: Family, q: Array) -> bool:
        """Whether a singular configuration is the family of the answer again, with the same parts at the same values.

        The sheet of a family comes near to q at more than one place; that is no other singularity.
        """
        if self.slow is not None:
            about, place = self.slow.family, self.slow.q
        elif self.incidences:
            about, place = self.incidences[0].family, self.focus
        else:
            return False
        if family.name != about.name:
            return False
        parts, other_parts = (self._parts_at(at, about.corank) for at in (place, q))
        return bool(other_parts) and parts == other_parts

    def _parts_at(self, q: Array, corank: int) -> set[tuple[str, str, int, int]]:
        """The parts special at a configuration: their condition, its joint, and which half turn of it [1]."""
        specials = self.specials_at(q, corank)
        return {(part.part, part.shape, part.joint, round(abs(part.value) / np.pi)) for part in specials}

    def _known_families(self) -> Iterator[Singularity]:
        """Known families that do not hold here, but for what the answer is about."""
        if self.incidences and self.slow is None:
            about = self.incidences[0].family.name
        else:
            about = None
        for point in self.far.families:
            if point.family.name != about and not self._is_slow_family(point.q, point.family.corank, point.distance):
                yield point.family, point.distance, np.array(point.q)

    def _other_values(self) -> Iterator[Singularity]:
        """Families that hold here and pin a single joint, at their other values."""
        if self.slow is not None:
            return
        robot, q = self.configuration.robot, self.configuration.q
        for family in (incidence.family for incidence in self.incidences):
            if family.coupled or len(family.pinned) != 1 or family.corank != 1:
                continue
            joint = family.pinned[0].number - 1
            ways = np.array(family.pinned[0].values) - q[joint]
            if robot.periodic[joint]:
                ways = wrap(ways)
            ends = q[joint] + ways
            if self.options.limits:
                ways = ways[(ends >= robot.lower[joint]) & (ends <= robot.upper[joint])]
            for way in ways[np.argsort(np.abs(ways))][1:2]:
                place = q.copy()
                place[joint] += way
                yield family, float(abs(way) / self.configuration.scale[joint]), place

    def _is_slow_family(self, q: Sequence[float], corank: int, distance: float) -> bool:
        """Whether a singular configuration is what the answer is about already: near because slow."""
        if self.slow is None:
            return False
        if self.slow.ideal is None:
            return abs(distance - self.slow.distance) < _SAME_SHEET
        return any(
            loses_along(self.configuration, q, corank, normal) for normal in slow_normals(self.configuration)
        )
