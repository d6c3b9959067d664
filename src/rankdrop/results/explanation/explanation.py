"""The explanation of one configuration: its data, and how it goes to JSON, to text and to a notebook.

An explanation as plain data: the names of docs/json.md and schema/explanation.schema.json.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rankdrop.certify.ball import Certificate
from rankdrop.family.which import Incidence
from rankdrop.results.codec import Record, plain, robot_to_dict, save_record
from rankdrop.results.explanation.data import ExplanationData, Lost
from rankdrop.results.explanation.failures import failures_to_dict
from rankdrop.results.explanation.text import DETAILS, PARTS, sections_of
from rankdrop.results.verdict import of_explanation
from rankdrop.sections import Section, html, text
from rankdrop.units import heading

SCHEMA = "rankdrop/explanation/1"


def explanation_to_dict(found: ExplanationData) -> Record:
    """Every part; what is asked for most stands at the top level."""
    rank = found.rank
    return {
        **heading(SCHEMA),
        "robot": robot_to_dict(found.robot, found.task, rank.generic_rank),
        "settings": plain(found.settings),
        "q": found.q.tolist(),
        "outside_limits": list(found.outside_limits),
        "at_limits": list(found.at_limits),
        "verdict": found.verdict,
        "reason": found.reason,
        "sentence": of_explanation(found),
        **plain(rank),
        "nearly_lost": found.nearly_lost,
        "focus": found.focus.tolist(),
        "family": incidence_to_dict(found.met[0]) if found.met else None,
        "families": [incidence_to_dict(one) for one in found.met],
        "family_source": found.source,
        "relations": plain(found.relations),
        **_lost(found.lost),
        "circuits": [list(circuit.numbers) for circuit in found.blame.circuits],
        "blame": plain(found.blame),
        "escape": plain(found.escape),
        "joint_rates": plain(found.rates),
        "nearest": nearest_to_dict(found),
        "families_away": [
            {
                "id": one.family.id,
                "name": one.family.name,
                **{key: value for key, value in plain(one).items() if key != "family"},
            }
            for one in found.far.families
        ],
        "certified_radius": found.certified_radius,
        "certificate": None if found.far.certificate is None else certificate_to_dict(found.far.certificate),
        "uncertified": found.far.uncertified,
        "near_miss": plain(found.far.near_miss),
        **failures_to_dict(found.failures),
        "ellipsoids": plain(found.ellipsoids),
        "redundancy": plain(found.redundancy),
        "representations": plain(found.representations),
        "disagreements": list(found.disagreements),
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


def nearest_to_dict(found: ExplanationData) -> Record | None:
    """The nearest singular configuration: q itself where it is one."""
    name = None if found.far.nearest_family is None else incidence_to_dict(found.far.nearest_family)
    if found.rank.corank:
        still = [0.0] * found.robot.n
        first = incidence_to_dict(found.met[0]) if found.met else None
        return {"distance": 0.0, "q": found.q.tolist(), "delta": still, "corank": found.rank.corank, "family": first}
    return None if found.far.nearest is None else {**plain(found.far.nearest), "family": name}


def far_to_dict(found: ExplanationData) -> Record:
    """What `rankdrop nearest --json` writes: the entries of an explanation that say how far."""
    return _picked(found, "rankdrop/nearest/1", "nearest", "families_away", "certified_radius", "certificate",
                   "uncertified", "near_miss")  # fmt: skip


def way_out_to_dict(found: ExplanationData, procedure: Any) -> Record:
    """What `rankdrop escape --json` writes: the entries of an explanation that lead out; `lie` GR's procedure."""
    picked = _picked(found, "rankdrop/escape/1", "circuits", "blame", "escape")
    return {**picked, "lie": plain(procedure)}


def _picked(found: ExplanationData, schema: str, *names: str) -> Record:
    whole = explanation_to_dict(found)
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
class Explanation(ExplanationData):
    """Everything rankdrop can say of one configuration; the attributes are those of `ExplanationData`."""

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
