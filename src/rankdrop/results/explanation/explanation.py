"""The explanation of one configuration: its data, and how it goes to JSON, to text and to a notebook.

An explanation as plain data: the names of docs/json.md and schema/explanation.schema.json.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.certify.ball import Certificate
from rankdrop.family.which import Incidence
from rankdrop.local.ellipsoids import Ellipsoids
from rankdrop.local.failures import Failures
from rankdrop.local.rates import Rates
from rankdrop.local.redundant import Redundancy
from rankdrop.local.relations import Relation
from rankdrop.local.representation import Representations
from rankdrop.local.verdict import Rank
from rankdrop.local.ways_out import Escape
from rankdrop.results.codec import Record, plain, robot_to_dict, save_record
from rankdrop.results.explanation.data import AT_LIMIT, Blame, ExplainSettings, Far, Lost
from rankdrop.results.explanation.failures import failures_to_dict
from rankdrop.results.explanation.text import DETAILS, PARTS, sections_of
from rankdrop.results.verdict import of_explanation
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section, html, text
from rankdrop.task import Task
from rankdrop.units import heading

SCHEMA = "rankdrop/explanation/1"


def explanation_to_dict(explanation: Explanation) -> Record:
    """Every part; what is asked for most stands at the top level."""
    rank = explanation.rank
    return {
        **heading(SCHEMA),
        "robot": robot_to_dict(explanation.robot, explanation.task, rank.generic_rank),
        "settings": plain(explanation.settings),
        "q": explanation.q.tolist(),
        "outside_limits": list(explanation.outside_limits),
        "at_limits": list(explanation.at_limits),
        "verdict": explanation.verdict,
        "reason": explanation.reason,
        "sentence": of_explanation(explanation),
        **plain(rank),
        "nearly_lost": explanation.nearly_lost,
        "focus": explanation.focus.tolist(),
        "family": incidence_to_dict(explanation.met[0]) if explanation.met else None,
        "families": [incidence_to_dict(one) for one in explanation.met],
        "family_source": explanation.source,
        "relations": plain(explanation.relations),
        **_lost(explanation.lost),
        "circuits": [list(circuit.numbers) for circuit in explanation.blame.circuits],
        "blame": plain(explanation.blame),
        "escape": plain(explanation.escape),
        "joint_rates": plain(explanation.rates),
        "nearest": nearest_to_dict(explanation),
        "families_away": [
            {
                "id": one.family.id,
                "name": one.family.name,
                **{key: value for key, value in plain(one).items() if key != "family"},
            }
            for one in explanation.far.families
        ],
        "certified_radius": explanation.certified_radius,
        "certificate": None
        if explanation.far.certificate is None
        else certificate_to_dict(explanation.far.certificate),
        "uncertified": explanation.far.uncertified,
        "near_miss": plain(explanation.far.near_miss),
        **failures_to_dict(explanation.failures),
        "ellipsoids": plain(explanation.ellipsoids),
        "redundancy": plain(explanation.redundancy),
        "representations": plain(explanation.representations),
        "disagreements": list(explanation.disagreements),
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


def _lost(lost: Lost) -> Record:
    framed = lost.framed
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
        "lost_seen": plain(lost.seen),
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
    return _picked(explanation, "rankdrop/nearest/1", "nearest", "families_away", "certified_radius", "certificate",
                   "uncertified", "near_miss")  # fmt: skip


def way_out_to_dict(explanation: Explanation, procedure: Any) -> Record:
    """What `rankdrop escape --json` writes: the entries of an explanation that lead out; `lie` GR's procedure."""
    picked = _picked(explanation, "rankdrop/escape/1", "circuits", "blame", "escape")
    return {**picked, "lie": plain(procedure)}


def _picked(explanation: Explanation, schema: str, *names: str) -> Record:
    whole = explanation_to_dict(explanation)
    always = (
        "robot", "settings", "q", "outside_limits", "at_limits", "verdict", "reason", "rank", "generic_rank", "corank",
        "nullity", "sigma",
    )  # fmt: skip
    return {**heading(schema), **{name: whole[name] for name in (*always, *names, "disagreements")}}


def certificate_to_dict(certificate: Certificate) -> Record:
    """The certificate without its boxes."""
    return {key: value for key, value in plain(certificate).items() if key != "boxes"}


_SHOWN = tuple(name for name in PARTS if name not in DETAILS | {"more"})


@dataclass(frozen=True, eq=False, repr=False)
class Explanation:
    """Everything rankdrop can say of one configuration.

    Attributes:
        robot, task, q: what was asked about.
        settings: thresholds, seed, version.
        verdict: "regular", "near", "singular" or "always-singular".
        reason: one sentence for it.
        rank: singular values, rank, generic rank, corank, nullity.
        focus: (n,) the configuration that family, relations and blame speak of: q itself, or the nearest singular one
            where q is near it.
        met: families that hold at the focus; the first is the one that says most.
        source: where the families come from.
        relations: what the axes have in common at the focus.
        lost, blame, escape, rates, far: the parts.
        failures: what the failure of each single joint leaves at q.
        ellipsoids, redundancy, representations: further parts.
        disagreements: where two methods disagree; empty when all is well.
    """

    robot: Robot
    task: Task
    q: Array
    settings: ExplainSettings
    verdict: str
    reason: str
    rank: Rank
    focus: Array
    met: tuple[Incidence, ...]
    source: str
    relations: tuple[Relation, ...]
    lost: Lost
    blame: Blame
    escape: Escape
    rates: Rates
    far: Far
    failures: Failures
    ellipsoids: Ellipsoids
    redundancy: Redundancy
    representations: Representations
    disagreements: tuple[str, ...] = ()

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
        return text(self.sections(parts=_SHOWN))

    def to_dict(self) -> Record:
        """Plain data: see docs/json.md and schema/explanation.schema.json."""
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
        return html(self.sections(parts=_SHOWN))
