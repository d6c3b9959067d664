"""Exact conditions as plain data: the names of docs/json.md and schema/conditions.schema.json."""

from __future__ import annotations

from rankdrop.exact.family import ExactFamily
from rankdrop.results.codec import Record, plain, robot_to_dict
from rankdrop.results.conditions.data import ConditionsData

SCHEMA = "rankdrop/conditions/1"


def conditions_to_dict(found: ConditionsData) -> Record:
    """All of it but the time spent: the same robot and settings give the same record."""
    return {
        "schema": SCHEMA,
        "robot": robot_to_dict(found.robot, found.task, found.generic_rank),
        "settings": plain(found.settings),
        "letters": dict(found.letters),
        "shifts": list(found.shifts),
        "remarks": list(found.remarks),
        "method": found.method,
        "reason": found.reason,
        "steps": plain(found.steps),
        **found.verdict.to_dict(),
        "complete": found.complete,
        "interrupted": found.interrupted,
        "verified": found.verified,
        "left": list(found.left),
        "disagreements": list(found.disagreements),
        "lowest": found.lowest,
        "families": [_family(found, family) for family in found.families],
        "assumptions": plain(found.assumptions),
        "not_real": list(found.not_real),
        "explained": {"tested": found.explained.tested, "explained": found.explained.agree},
    }


def _family(found: ConditionsData, family: ExactFamily) -> Record:
    """The entries of a family of an analysis that make sense here, and what is known exactly."""
    return {
        "id": family.id,
        "name": family.name,
        "corank": family.corank,
        "dimension": family.dimension,
        "codimension": family.codimension,
        "pinned": [
            {"joint": one.joint, "number": one.number, "values": sorted(one.values)}
            for one in family.pinned(found.robot)
        ],
        "free": list(family.free),
        "coupled": list(family.coupled),
        "conditions": list(family.texts),
        "latex": list(family.latex),
        "equations": [equation.text() for equation in family.equations],
        "terms": [equation.to_dict()["terms"] for equation in family.equations],
        "reality": family.reality,
        "witness": list(family.witness),
        "lost_words": list(family.lost_words),
        "rank_check": plain(family.rank_check),
    }
