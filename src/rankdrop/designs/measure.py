"""What is measured of one arm: its families, how much of the joint space is near them, σ over a region, paths, proofs.

All of it as plain data, one record for each arm; docs/howto/comparing-designs.md says what every entry means.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees
from typing import Any

import numpy as np

from rankdrop.certify.covering import covering
from rankdrop.designs.families import Effort, families_of
from rankdrop.designs.poses import reached, targets_of
from rankdrop.designs.spec import finite
from rankdrop.errors import RankdropError
from rankdrop.families.memory import Memory
from rankdrop.families.share import NearShare, near_shares
from rankdrop.family.record import Family
from rankdrop.local.block import generic_rank
from rankdrop.motion.cartesian import check_poses
from rankdrop.motion.data import FREE
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import JointKind, Robot
from rankdrop.task import Task
from rankdrop.text.families import condition_text

Record = dict[str, Any]
STARTS, FRESH = 300, 300
"""Of families that are needed but were not asked for."""
_RIGHT = 90.0  # degrees: values at multiples of this are told, others depend on the lengths
_ROUND = 1e-6  # degrees
_ZERO = 1e-9  # [m]


def measured(
    robot: Robot, task: Task, asks: Mapping[str, Any], memory: Memory, *, limits: bool, seed: int,
    known: Analysis | None = None,
) -> Record:
    """Everything that is asked of an arm.

    Args:
        robot, task: the arm.
        asks: `Asks.to_dict`.
        memory: of a similar arm; takes up what is found here.
        limits: inside the joint limits.
        seed: of every random choice.
        known: its analysis, where there is one: its families are taken, and none are looked for.

    Returns:
        Plain data: `measures` (name -> number or None) and for each ask its own entry. An arm that something cannot be
        asked of has the reason in `error`, and what was found before it.
    """
    record: Record = {"measures": {}, "error": None}
    try:
        found = _families(robot, task, asks, memory, limits, seed, record, known)
        if asks["near"] is not None and found is not None:
            _near(found, asks["near"], limits, seed, record)
        if asks["region"] is not None:
            _region(robot, task, asks["region"], limits, seed, record)
        if asks["paths"] is not None and found is not None:
            _paths(found, asks["paths"], limits, record)
        if asks["certified"] is not None:
            _certified(robot, task, float(asks["certified"]), limits, record)
    except RankdropError as error:
        record["error"] = str(error)
    return record


def _families(
    robot: Robot, task: Task, asks: Mapping[str, Any], memory: Memory, limits: bool, seed: int, record: Record,
    known: Analysis | None,
) -> Analysis | None:
    asked = asks["families"]
    if asked is None and asks["near"] is None and asks["paths"] is None:
        return None
    starts, fresh = (asked["starts"], asked["fresh"]) if asked is not None else (STARTS, FRESH)
    found = families_of(robot, task, Effort(starts, fresh, limits, seed), memory) if known is None else known
    if asked is not None:
        record["verdict"] = found.verdict.word
        record["sentence"] = found.verdict.sentence
        record["rank"] = found.generic_rank
        record["families"] = [_family(one, robot) for one in found.families]
        record["measures"]["families"] = len(found.families)
    return found


def _family(family: Family, robot: Robot) -> Record:
    coupled = set(family.coupled)
    return {
        "id": family.id,
        "key": key_of(family, robot),
        "name": family.name,
        "corank": family.corank,
        "dimension": family.dimension,
        "pinned": [{"number": pin.number, "values": list(pin.values)} for pin in family.pinned],
        "free": list(family.free),
        "coupled": list(family.coupled),
        "conditions": [condition_text(x) for x in family.equations if coupled & set(x.joints)],
        "named": family.named,
        "sound": [family.soundness.agree, family.soundness.tested],
        "explained": [family.explained.agree, family.explained.tested],
        "witness": list(family.witness),
    }


def key_of(family: Family, robot: Robot) -> str:
    """What a family is, apart from the arm's lengths: corank, dimension, pinned joints, coupled joints.

    Values that are multiples of 90°, and zero of a slide, belong to it; others move with the lengths, and only their
    number does.
    """
    pins = []
    for pin in sorted(family.pinned, key=lambda pin: pin.number):
        slides = robot.variables[pin.number - 1].kind is JointKind.PRISMATIC
        pins.append(f"q{pin.number} = {_lengths(pin.values)}" if slides else f"θ{pin.number} = {_values(pin.values)}")
    tied = [f"joints {', '.join(map(str, family.coupled))} coupled"] if family.coupled else []
    return f"k{family.corank}, dim {family.dimension}: {'; '.join([*pins, *tied]) or 'everywhere'}"


def _lengths(values: tuple[float, ...]) -> str:
    other = sum(abs(x) > _ZERO for x in values)
    return ", ".join((["0 m"] if other < len(values) else []) + ([f"{other} other"] if other else []))


def _values(values: tuple[float, ...]) -> str:
    angles = sorted(round(degrees(x), 6) for x in values)
    told = [x for x in angles if abs(x / _RIGHT - round(x / _RIGHT)) < _ROUND]
    other = len(angles) - len(told)
    words = [f"{x + 0.0:g}°".replace("-", "−") for x in told]
    return ", ".join(words + ([f"{other} other"] if other else []))


def _near(analysis: Analysis, asked: Mapping[str, Any], limits: bool, seed: int, record: Record) -> None:
    near = near_shares(analysis.families, analysis.robot, analysis.task, asked["within"], limits=limits,
                       samples=asked["samples"], seed=seed)  # fmt: skip
    record["near"] = {"any": _share(near.any), "families": [_share(one) for one in near.families]}
    record["measures"]["near"] = near.any.share


def _share(share: NearShare) -> Record:
    return {
        "id": share.id,
        "share": share.share,
        "error": share.error,
        "interval": list(share.interval),
        "bound": share.bound,
    }


def _region(robot: Robot, task: Task, asked: Mapping[str, Any], limits: bool, seed: int, record: Record) -> None:
    rpy = None if asked["rpy"] is None else np.array(asked["rpy"])
    targets = targets_of(np.array(asked["lower"]), np.array(asked["upper"]), rpy, asked["points"], seed)
    met = reached(robot, task, generic_rank(robot, task), targets, oriented=rpy is not None, starts=asked["starts"],
                  seed=seed, limits=limits)  # fmt: skip
    worst = met.worst
    record["region"] = {
        "poses": len(targets),
        "reached": int(met.found.sum()),
        "lowest": finite(met.lowest),
        "sigma": None if worst is None else float(met.sigma[worst]),
        "at": None if worst is None else targets[worst, :3, 3].tolist(),
        "q": None if worst is None else met.q[worst].tolist(),
    }
    record["measures"]["sigma"] = record["region"]["sigma"]
    record["measures"]["reached"] = float(met.found.mean())


def _paths(analysis: Analysis, asked: Mapping[str, Any], limits: bool, record: Record) -> None:
    rows = [_path(analysis, name, given, limits) for name, given in asked.items()]
    record["paths"] = rows
    for measure, key in (("path_sigma", "sigma"), ("path_distance", "distance")):
        values = [row[key] for row in rows]
        record["measures"][measure] = None if None in values else min(values)
    record["measures"]["paths_free"] = sum(row["verdict"] == FREE for row in rows) / len(rows)


def _path(analysis: Analysis, name: str, given: Mapping[str, Any], limits: bool) -> Record:
    try:
        judged = check_poses(analysis.robot, np.array(given["poses"]), given["t"], task=analysis.task, limits=limits,
                             analysis=analysis)  # fmt: skip
    except RankdropError as error:  # the first pose is out of reach, say
        return {"name": name, "verdict": "not reached", "sigma": None, "distance": None, "q": None, "why": error.what}
    least = min(judged.stretches, key=lambda one: one.closest.sigma)
    near = min(one.closest.distance for one in judged.stretches)
    whole = judged.tool is None or judged.tool.complete
    return {
        "name": name,
        "verdict": judged.verdict if whole else "ends early",
        "sigma": float(least.closest.sigma) if whole else None,
        "distance": finite(near) if whole else None,
        "q": least.closest.q.tolist(),
        "why": "" if whole or judged.tool is None else judged.tool.words,
    }


def _certified(robot: Robot, task: Task, width: float, limits: bool, record: Record) -> None:
    found = covering(robot, width, task, limits=limits, threads=1)
    record["certified"] = {"free": found.free_share, "boxes": found.tree.leaves, "complete": found.complete}
    record["measures"]["free"] = found.free_share if found.complete else None
