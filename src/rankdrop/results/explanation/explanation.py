"""The explanation of one configuration: its data, and how it goes to JSON, to text and to a notebook.

An explanation as plain data: the names of docs/json.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.certify.ball import Certificate
from rankdrop.configuration import Cause, Rank
from rankdrop.family.which import Incidence
from rankdrop.local.axes import Relation, relations_at
from rankdrop.local.ellipsoids import Ellipsoids, ellipsoids
from rankdrop.local.failures import Failures, failures_at
from rankdrop.local.nearest import Nearest
from rankdrop.local.orientation import Representations, representation_at
from rankdrop.local.rates import Rates, StraightMotion, joint_rates
from rankdrop.local.redundant import Redundancy, redundancy
from rankdrop.local.ways_out import Escape, escape
from rankdrop.results.codec import Record, plain, robot_to_dict, save_record
from rankdrop.results.explanation.data import (
    AT_LIMIT,
    Asked,
    Blame,
    ExplainSettings,
    Far,
    Lost,
    Summary,
)
from rankdrop.results.explanation.failures import failures_to_dict
from rankdrop.results.explanation.parts import (
    SlowFamily,
    blame_at,
    disagreements,
    incidences_at,
    lost_of,
    slow_family,
    summary_of,
    turned_task,
)
from rankdrop.results.explanation.text import (
    DETAILS,
    PARTS,
    lost_text,
    reason_of,
    sections_of,
    sentence_of,
    summary_lines,
)
from rankdrop.results.explanation.words import escape_to_dict
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section, html, text
from rankdrop.task import Task
from rankdrop.units import heading

SCHEMA = "rankdrop/explanation/1"


def explanation_to_dict(explanation: Explanation) -> Record:
    """Every part; what is asked for most stands at the top level."""
    return {
        **heading(SCHEMA),
        **_head(explanation),
        "sentence": sentence_of(explanation),
        **_summary(explanation),
        **plain(explanation.rank),
        "nearly_lost": explanation.nearly_lost,
        "focus": explanation.focus.tolist(),
        "family": incidence_to_dict(explanation.met[0]) if explanation.met else None,
        "families": [incidence_to_dict(one) for one in explanation.met],
        "family_source": explanation.source,
        "relations": plain(explanation.relations),
        **_lost(explanation),
        **_ways(explanation),
        "joint_rates": plain(explanation.rates),
        **_far(explanation),
        **failures_to_dict(explanation.failures),
        "ellipsoids": plain(explanation.ellipsoids),
        "redundancy": plain(explanation.redundancy),
        "representations": plain(explanation.representations),
        "disagreements": list(explanation.disagreements),
    }


def _head(explanation: Explanation) -> Record:
    return {
        "robot": robot_to_dict(explanation.robot, explanation.task, explanation.rank.generic_rank),
        "settings": plain(explanation.settings),
        "q": explanation.q.tolist(),
        "outside_limits": list(explanation.outside_limits),
        "at_limits": list(explanation.at_limits),
        "verdict": explanation.verdict,
        "reason": explanation.reason,
    }


def _summary(explanation: Explanation) -> Record:
    summary, slow = plain(explanation.summary), None
    if explanation.slow_family is not None:
        slow = {"id": summary["family_id"], "name": summary["family"]}
        slow |= {name: summary[name] for name in ("distance", "ideal", "length", "angle")}
    return {
        "summary": {**summary, "text": list(summary_lines(explanation))},
        "slowest": plain(explanation.straight),
        "slow_family": slow,
    }


def _ways(explanation: Explanation) -> Record:
    return {
        "circuits": [list(circuit.numbers) for circuit in explanation.blame.circuits],
        "blame": plain(explanation.blame),
        "escape": escape_to_dict(explanation.escape),
    }


def _far(explanation: Explanation) -> Record:
    far = explanation.far
    away = (({key: value for key, value in plain(one).items() if key != "family"}, one.family) for one in far.families)
    return {
        "nearest": nearest_to_dict(explanation),
        "families_away": [{"id": family.id, "name": family.name, **entries} for entries, family in away],
        "certified_radius": explanation.certified_radius,
        "certificate": None if far.certificate is None else certificate_to_dict(far.certificate),
        "uncertified": far.uncertified,
        "near_miss": plain(far.near_miss),
    }


def incidence_to_dict(met: Incidence) -> Record:
    """A family that holds: what it is called, its conditions, and how well they hold."""
    family = met.family
    keys = ("name", "corank", "dimension", "pinned", "free", "coupled")
    return {
        "id": family.id or None,
        **{key: plain(getattr(family, key)) for key in keys},
        "conditions": [str(equation) for equation in family.equations] or list(family.words),
        "equations": plain(family.equations),
        "residual": met.residual,
        "source": met.source,
    }


def _lost(explanation: Explanation) -> Record:
    lost = explanation.lost
    framed, robot = lost.framed, explanation.robot
    return {
        "lost_directions": lost.directions.tolist(),
        "lost_words": list(lost.words),
        "blocked_wrenches": lost.directions.tolist(),
        "blocked_words": list(lost.blocked_words),
        "lost_frame": None
        if framed is None
        else {
            "name": framed.name,
            **plain(framed.frame),
            "directions": framed.directions.tolist(),
            "twist_screws": plain(lost.twist_screws),
            "wrench_screws": plain(lost.wrench_screws),
        },
        "lost_seen": [
            {"frame": frame, "directions": seen.directions.tolist(), **lost_text(robot, seen)}
            for frame, seen in lost.seen.items()
        ],
        "weakest_direction": lost.weakest.tolist(),
        "never_possible": lost.never.tolist(),
    }


def nearest_to_dict(explanation: Explanation) -> Record | None:
    """The nearest singular configuration: q itself where it is one."""
    name = None if explanation.far.nearest_family is None else incidence_to_dict(explanation.far.nearest_family)
    if explanation.rank.corank:
        still = [0.0] * explanation.robot.n
        first = incidence_to_dict(explanation.met[0]) if explanation.met else None
        return {
            "distance": 0.0,
            "q": explanation.q.tolist(),
            "delta": still,
            "corank": explanation.rank.corank,
            "family": first,
        }
    return None if explanation.far.nearest is None else {**plain(explanation.far.nearest), "family": name}


def far_to_dict(explanation: Explanation) -> Record:
    """What `rankdrop nearest --json` writes: the entries of an explanation that say how far."""
    return _picked(explanation, "rankdrop/nearest/1", _far(explanation))


def way_out_to_dict(explanation: Explanation, procedure: Any) -> Record:
    """What `rankdrop escape --json` writes: the entries of an explanation that lead out; `lie` GR's procedure."""
    return {**_picked(explanation, "rankdrop/escape/1", _ways(explanation)), "lie": plain(procedure)}


def _picked(explanation: Explanation, schema: str, entries: Record) -> Record:
    rank = plain(explanation.rank)
    ranks = {name: rank[name] for name in ("rank", "generic_rank", "corank", "nullity", "sigma")}
    return {
        **heading(schema), **_head(explanation), **ranks, **entries, "disagreements": list(explanation.disagreements)
    }


def certificate_to_dict(certificate: Certificate) -> Record:
    """The certificate as an entry of JSON."""
    found: Record = plain(certificate)
    return found


_PLAIN = tuple(name for name in PARTS if name not in DETAILS | {"more"})


@dataclass(frozen=True, eq=False, repr=False)
class Explanation:
    """Everything rankdrop can say of one configuration; parts that take long are made when first asked for, and kept.

    Attributes:
        asked: the question: arm, configuration, task, rank, known families, settings.
        verdict: "regular", "near", "singular" or "always-singular".
        cause: what decides it.
        far: how far the next singularity is.
        straight: the slowest translation and the slowest rotation of the tool.
    """

    asked: Asked
    verdict: str
    cause: Cause
    far: Far
    straight: tuple[StraightMotion, ...] = ()

    @property
    def reason(self) -> str:
        """What decides the verdict, in a sentence."""
        return reason_of(self)

    @cached_property
    def slow_family(self) -> SlowFamily | None:
        """The family that makes a straight motion slow; None where speed does not decide the verdict."""
        return slow_family(self.asked, self.far) if self.cause == Cause.SLOW else None

    @property
    def distance(self) -> float | None:
        """To the nearest singular configuration found [rad; slides in length scales]; 0 at one, None where none was."""
        if self.rank.corank:
            return 0.0
        return None if self.far.nearest is None else self.far.nearest.distance

    @cached_property
    def summary(self) -> Summary:
        """The answer in facts."""
        return summary_of(self)

    @property
    def robot(self) -> Robot:
        """The arm that was asked about."""
        return self.asked.robot

    @property
    def task(self) -> Task:
        """What the tool is to do, with the length scale that was used."""
        return replace(self.asked.task, length_scale=self.asked.settings.length_scale)

    @property
    def q(self) -> Array:
        """(n,) the configuration [rad, m]."""
        return self.asked.q

    @property
    def settings(self) -> ExplainSettings:
        """Thresholds, seed, version."""
        return self.asked.settings

    @property
    def rank(self) -> Rank:
        """Singular values, rank, generic rank, corank, nullity."""
        return self.asked.rank

    @property
    def source(self) -> str:
        """Where the families come from."""
        return self.asked.source

    @cached_property
    def focus(self) -> Array:
        """(n,) what family, relations and blame speak of, q itself or the nearest singular one where q is near it."""
        return self.q if self._at_hand is None else np.array(self._at_hand.q)

    @property
    def _at_hand(self) -> Nearest | None:
        return self.far.nearest if self.cause in (Cause.DISTANCE, Cause.SMALL) else None

    @property
    def _corank(self) -> int:
        return self.rank.corank if self._at_hand is None else self._at_hand.corank

    @cached_property
    def met(self) -> tuple[Incidence, ...]:
        """Families that hold at the focus; the first is the one that says most."""
        return incidences_at(self.asked, self.focus, self._corank) if self._corank else ()

    @cached_property
    def relations(self) -> tuple[Relation, ...]:
        """What the axes have in common at the focus."""
        return relations_at(self.robot, self.focus)

    @cached_property
    def lost(self) -> Lost:
        """Directions of the tool that are lost at the focus."""
        return lost_of(self.asked, self.focus, self._corank or int(self.cause in (Cause.NEAR_MISS, Cause.SLOW)))

    @cached_property
    def blame(self) -> Blame:
        """Which joints make the dependency at the focus."""
        return blame_at(self.asked, self.focus, self._corank)

    @cached_property
    def escape(self) -> Escape:
        """Which motions lead out."""
        settings = self.settings
        return escape(self.asked.here, seed=settings.seed, step=settings.step)

    @cached_property
    def rates(self) -> Rates:
        """What motion costs the joints."""
        task = turned_task(self.asked.task, self.settings.frame, self.lost)
        return joint_rates(self.asked.here) if task == self.asked.task else joint_rates(self.robot, self.q, task)

    @cached_property
    def failures(self) -> Failures:
        """What the failure of each single joint leaves at q."""
        return failures_at(self.asked.here)

    @cached_property
    def ellipsoids(self) -> Ellipsoids:
        """How motion and force compare by direction."""
        return ellipsoids(self.asked.here)

    @cached_property
    def redundancy(self) -> Redundancy:
        """What motions of the joints leave the tool still."""
        return redundancy(self.asked.here)

    @cached_property
    def representations(self) -> Representations:
        """How far the coordinates of the orientation are from singularities of their own."""
        return representation_at(self.robot, self.q, tolerances=self.settings.tolerances)

    @cached_property
    def disagreements(self) -> tuple[str, ...]:
        """Where two methods disagree; empty when all is well."""
        return tuple(disagreements(self.far, self.escape.single))

    @property
    def nearly_lost(self) -> int:
        """Further singular values that are small but not zero: freedoms nearly lost, by offsets or by nearness."""
        kept = self.rank.sigma[: self.rank.rank]
        return int((kept <= self.settings.small).sum())

    @property
    def outside_limits(self) -> tuple[int, ...]:
        """Joints (from 1) whose value is beyond a limit by more than `AT_LIMIT`."""
        out = np.maximum(self.robot.lower - self.q, self.q - self.robot.upper) / self._scale
        return tuple(int(i) + 1 for i in np.flatnonzero(out > AT_LIMIT))

    @property
    def at_limits(self) -> tuple[int, ...]:
        """Joints (from 1) that stand at a limit, to within `AT_LIMIT`."""
        gap = np.minimum(np.abs(self.q - self.robot.lower), np.abs(self.robot.upper - self.q)) / self._scale
        return tuple(int(i) + 1 for i in np.flatnonzero(gap <= AT_LIMIT))

    @property
    def _scale(self) -> Array:
        turning = [joint.unit == "rad" for joint in self.robot.variables]
        return np.where(turning, 1.0, self.settings.length_scale)

    @cached_property
    def certified_radius(self) -> float | None:
        """Radius proven free of singularities [rad]; 0 at a singularity, None where it cannot be certified."""
        if self.rank.corank or self.rank.always_singular:
            return 0.0
        return None if self.far.certificate is None else self.far.certificate.radius

    def __repr__(self) -> str:
        return f"<Explanation of {self.robot.name}: {self.verdict}, {self.reason}>"

    def __str__(self) -> str:
        """What the command line prints, unwrapped."""
        return text(self.sections(parts=_PLAIN))

    def to_dict(self) -> Record:
        """Plain data: see docs/json.md."""
        return explanation_to_dict(self)

    def save(self, path: str | Path) -> None:
        """Write the explanation to a JSON file.

        Raises:
            ResultFileError: the file cannot be written.
        """
        save_record(self.to_dict(), path)

    def sections(self, *, full: bool = False, parts: Sequence[str] = ()) -> tuple[Section, ...]:
        """The explanation in words: see `rankdrop.results.explanation.text.sections_of`."""
        return sections_of(self, full=full, parts=parts)

    def _repr_html_(self) -> str:
        """For notebooks."""
        return html(self.sections(parts=_PLAIN))
