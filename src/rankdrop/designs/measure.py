"""What is measured of one arm: its families, how much of the joint space is near them, σ over a region, paths, proofs.

All of it as plain data, one record for each arm; docs/howto/comparing-designs.md says what every entry means.

Families of a variant are those of the nominal arm, derived once with letters for its lengths; the variant's lengths
take the place of the letters. Searches, soundness and completeness are the variant's own, from random starts in the
whole joint space. What is left open, where a length is special, is done again:

    nominal conditions   every family sound, every fresh point explained  →  taken
    else                 the same with three times the starts: a small family may have had too few points
    else                 conditions fitted to the points, three and ten times the starts

How well an arm does its task over a region of its workspace: see `rankdrop.designs.region`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from rankdrop.aspects.verdict import judged_summary
from rankdrop.codec import encode, plain, restore
from rankdrop.cover.covering import plan_of
from rankdrop.designs.postures import best_postures, slow_poses, targets_of
from rankdrop.designs.ranking import bits_to_text, form_of, key_of
from rankdrop.designs.region import region_bounds
from rankdrop.designs.spec import finite
from rankdrop.distance.share import NearShare, near_shares, slow_share
from rankdrop.errors import RankdropError
from rankdrop.exact import exact_chain
from rankdrop.exact.family import derived_in_units
from rankdrop.families import CorankSummary, Family, search
from rankdrop.families.corank_families import CorankFamilies
from rankdrop.families.parts import parts_of
from rankdrop.families.rescaling import family_out_of_units
from rankdrop.families.table import families
from rankdrop.local import generic_rank
from rankdrop.path import FREE, check_poses
from rankdrop.problem import Problem
from rankdrop.results import Analysis, Conditions, known_analysis, known_conditions
from rankdrop.results.analysis import Settings
from rankdrop.results.known import known_aspects
from rankdrop.robot import Array, Drawing, Robot
from rankdrop.robot.drawing import NumberPlace
from rankdrop.schema.design import FAMILY_PARTS, NEAR_SHARE
from rankdrop.schema.families import ASPECTS_SUMMARY, CALLED
from rankdrop.task import Task
from rankdrop.text.families import condition_text
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_units, task_in_units
from rankdrop.verbs.analyze import SECONDS
from rankdrop.verbs.conditions import conditions
from rankdrop.verbs.covering import covering
from rankdrop.version import VERSION

MORE = (3, 10)
"""Times the starts, where something is left open."""

Record = dict[str, Any]
Measured = tuple[Record, Record]
STARTS, FRESH = 300, 300
"""Of families that are needed but were not asked for."""

NEED_FAMILIES = ("families", "near", "paths")


def nominal_conditions(robot: Robot, task: Task) -> Conditions | None:
    """The families of a nominal arm in letters for its lengths; None where they are not derived, or with numbers."""
    try:
        derived = known_conditions(robot, task, any_tip=True)
        if derived is None:
            derived = conditions(robot, task, method="tree", seconds=SECONDS["auto"], points=0, special=False)
    except RankdropError:
        return None
    if derived.in_families and derived.letters:
        return derived
    return None


def with_lengths_of(robot: Robot, task: Task, nominal: Conditions | None) -> tuple[Family, ...] | None:
    """The families of a nominal arm with the lengths of another one, as equations in its own unit of length; None
    where its screws are others in letters too.

    Args:
        robot, task: the other arm.
        nominal: from `nominal_conditions`.
    """
    if nominal is None:
        return None
    try:
        chain = exact_chain(robot, task, lengths=nominal.settings.lengths)
    except RankdropError:
        return None
    first = nominal.chain
    same = set(chain.letters) == set(first.letters) and np.array_equal(chain.shifts, first.shifts)
    if not same or [list(map(str, x)) for x in chain.columns] != [list(map(str, x)) for x in first.columns]:
        return None
    derived = [derived_in_units(family, robot, chain.numbers) for family in nominal.families]
    return tuple(replace(family, exact=None) for family in derived)  # what else is known exactly is of the nominal arm


def families_of(
    robot: Robot, task: Task, nominal: Conditions | None, *, starts: int, fresh: int, limits: bool, seed: int
) -> Analysis:
    """Every family of an arm, each with its own evidence.

    Args:
        robot, task: the arm.
        nominal: of an arm with the same letters for lengths; None: conditions are fitted.
        starts: random starts for each corank.
        fresh: independent points for completeness, of each corank.
        limits: within the joint limits only.
        seed: of every random choice.

    Returns:
        An analysis whose smallest near misses are not sought.
    """
    scaled, inner = in_units(robot), task_in_units(task, robot)
    rank = generic_rank(scaled, inner)
    known = with_lengths_of(robot, task, nominal)
    sampling = _Sampling(scaled, inner, starts, fresh, limits, seed)
    coranks: list[CorankFamilies] = []
    while len(coranks) < rank and (not coranks or coranks[-1].summary.converged):
        coranks.append(_settle_families(sampling, len(coranks) + 1, known))
    rows: list[Family] = []
    for corank_rows in coranks:
        rows += [family_out_of_units(family, robot) for family in corank_rows.families]
    settings = Settings(seed, starts, limits, float(task.scale(robot)), DEFAULT, VERSION)
    return Analysis(robot, task, rank, settings, tuple(corank_rows.summary for corank_rows in coranks), tuple(rows))


@dataclass(frozen=True)
class _Sampling:
    """How the families of an arm are sampled.

    Attributes:
        robot, task: in the arm's own unit of length.
        starts, fresh, limits, seed: as of `families_of`.
    """

    robot: Robot
    task: Task
    starts: int
    fresh: int
    limits: bool
    seed: int


def _settle_families(sampling: _Sampling, corank: int, known: Sequence[Family] | None) -> CorankFamilies:
    """Families of one corank: with the nominal conditions, or fitted where these leave something open."""
    tries: list[tuple[int, Sequence[Family] | None]] = [(1, None)]
    if known is not None:
        of_corank = [family for family in known if family.corank == corank]
        tries = [(1, of_corank), (MORE[0], of_corank)]
    for times, given in [*tries, *((times, None) for times in MORE)]:
        families_of_corank = _sample_families(sampling, corank, times, given)
        if holds(families_of_corank.summary, families_of_corank.families):
            break
    return families_of_corank


def _sample_families(sampling: _Sampling, corank: int, times: int, given: Sequence[Family] | None) -> CorankFamilies:
    """Families of one corank from `times` times the starts, without nominal ones that these lengths make unreal."""
    seed = sampling.seed
    cloud = search(
        sampling.robot, corank, task=sampling.task, starts=times * sampling.starts, seed=seed, limits=sampling.limits,
        threads=1,
    )  # fmt: skip
    if not cloud.complete:
        raise KeyboardInterrupt  # the core received Ctrl-C
    sampled = families(cloud, known=given, seed=seed, threads=1, fresh=sampling.fresh, near_misses=False)
    unreal = {family.id for family, _ in sampled.contradictions}
    return replace(sampled, families=tuple(family for family in sampled.families if family.id not in unreal))


def holds(summary: CorankSummary, rows: tuple[Family, ...]) -> bool:
    """Whether every row has conditions and is sound, and every fresh point is explained."""
    sound = all(row.named and row.soundness.holds for row in rows)
    return sound and summary.completeness.agree == summary.completeness.tested


def measure_arm(
    robot: Robot,
    task: Task,
    asks: Mapping[str, Any],
    nominal: Conditions | None,
    *,
    limits: bool,
    seed: int,
    known: Analysis | None = None,
) -> Record:
    """Everything that is asked of an arm.

    Args:
        robot, task: the arm.
        asks: `Asks` as plain data.
        nominal: the derivation of the nominal arm, from `nominal_conditions`.
        limits: inside the joint limits.
        seed: of every random choice.
        known: its analysis, where there is one: its families are taken, and none are looked for.

    Returns:
        Plain data: `measures` (name -> number or None) and for each ask its own entry. An arm that something cannot be
        asked of has the reason in `error`, and what was found before it.
    """
    record: Record = {"measures": {}, "error": None}
    problem = Problem(robot, task, limits=limits)
    try:
        if known is None and any(asks[ask] is not None for ask in NEED_FAMILIES):
            sought = asks["families"] or {"starts": STARTS, "fresh": FRESH}
            known = families_of(robot, task, nominal, starts=sought["starts"], fresh=sought["fresh"], limits=limits,
                                seed=seed)  # fmt: skip
        for ask, measure in _MEASURES.items():
            if asks[ask] is not None:
                entries, values = measure(problem, known, asks[ask], seed)
                record |= entries
                record["measures"] |= values
    except RankdropError as error:
        record["error"] = str(error)
    return record


def _families(_: Problem, known: Analysis, _asked: Any, _seed: int) -> Measured:
    return {
        "verdict": known.verdict.word, "sentence": known.verdict.sentence, "rank": known.generic_rank,
        "families": [_family(family, known.robot, known.task) for family in known.families],
    }, {"families": len(known.families)}  # fmt: skip


def _family(family: Family, robot: Robot, task: Task) -> Record:
    coupled, form = set(family.coupled), form_of(family, robot)
    return {
        "id": family.id,
        "key": key_of(form),
        "structure": plain(form),
        "name": family.name,
        "called": encode(CALLED, family.called),
        "about": encode(FAMILY_PARTS, parts_of(robot, task, family)),
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


def _aspects(problem: Problem, _: Any, _asked: Any, _seed: int) -> Measured:
    """The number of aspects, and whether the arm is cuspidal: stored for arms of the catalogue, else found anew.

    The number is None where it is not proven.
    """
    summary = known_aspects(problem.robot, problem.task)
    if summary is None:
        summary = judged_summary(problem.robot, problem.task)
    return {"aspects": encode(ASPECTS_SUMMARY, summary)}, {"aspects": summary.number}


def _measure_near(problem: Problem, known: Analysis, asked: Mapping[str, Any], seed: int) -> Measured:
    near = near_shares(known.families, problem, asked["within"], samples=asked["samples"], seed=seed)
    entry = {"any": encode(NEAR_SHARE, near.any), "families": [encode(NEAR_SHARE, share) for share in near.families],
             "samples": near.samples, "hits": bits_to_text(near.hits)}  # fmt: skip
    return {"near": entry}, {"near": near.any.share}


def _slow(problem: Problem, _: Any, asked: Mapping[str, Any], seed: int) -> Measured:
    slow, hits = slow_share(problem, speed=asked["speed"], turn_speed=asked["turn_speed"], samples=asked["samples"],
                            seed=seed)  # fmt: skip
    if slow is None:
        return {"slow": None}, {"slow": None}
    entry = {"share": slow.share, "error": slow.error, "bound": slow.bound, "samples": slow.samples,
             "interval": list(slow.interval), "tool_speed": asked["speed"], "turn_speed": asked["turn_speed"],
             "seed": seed}  # fmt: skip
    return {"slow": entry | {"hits": bits_to_text(hits)}}, {"slow": slow.share}


def _region(problem: Problem, _: Any, asked: Mapping[str, Any], seed: int) -> Measured:
    if asked["rpy"] is None:
        rpy = None
    else:
        rpy = np.array(asked["rpy"])
    targets = targets_of(np.array(asked["lower"]), np.array(asked["upper"]), rpy, asked["points"], seed)
    sigma, q, lowest = best_postures(problem, targets, oriented=rpy is not None, starts=asked["starts"], seed=seed)
    there = np.isfinite(sigma)
    entry: Record = {
        "poses": len(targets), "reached": int(there.sum()), "each": [finite(value) for value in sigma],
        "lowest": finite(lowest), "sigma": None, "at": None, "q": None, "sigma_lower": None, "sigma_upper": None,
        "covered": None, "narrow": None, "tested": None,
    }  # fmt: skip
    if there.any():
        region = sigma[there], targets[there, :3, 3], q[there]
        bounds = region_bounds(problem, np.array(asked["lower"]), np.array(asked["upper"]), rpy, region,
                               starts=asked["starts"], seed=seed, budget=asked["budget"])  # fmt: skip
        entry |= {
            "sigma": bounds.sigma, "at": bounds.at.tolist(), "q": bounds.q.tolist(), "sigma_lower": bounds.lower,
            "sigma_upper": finite(bounds.upper), "covered": bounds.covered, "narrow": not bounds.spent,
            "tested": bounds.tested,
        }  # fmt: skip
    values: Record = {"sigma": entry["sigma"], "reached": float(there.mean())}
    if asked["speed"] is not None:
        entry["slow"] = _slow_poses(problem, targets, asked, seed, oriented=rpy is not None)
        if entry["slow"] is None:
            values["slow_poses"] = None
        else:
            values["slow_poses"] = entry["slow"]["share"]
    return {"region": entry}, values


def _slow_poses(
    problem: Problem, targets: Array, asked: Mapping[str, Any], seed: int, *, oriented: bool
) -> Record | None:  # fmt: skip
    """Share of the poses reached at which the tool is slow, with its interval; None where there is none."""
    outcome = slow_poses(problem, targets, oriented=oriented, speed=asked["speed"], starts=asked["starts"], seed=seed)
    if outcome is None or not outcome[0].any():
        return None
    there, slow, bound = outcome
    share = NearShare("", int(slow.sum()), int(there.sum()), bound)
    return {"slower_than": asked["speed"], "share": share.share, "interval": list(share.interval), "bound": bound,
            "reached": share.samples, "seed": seed, "poses": len(targets), "hits": bits_to_text(slow)}  # fmt: skip


def _paths(problem: Problem, known: Analysis, asked: Mapping[str, Any], _: int) -> Measured:
    rows = [_path(known, name, given, limits=problem.limits) for name, given in asked.items()]
    values: Record = {}
    for measure, key in (("path_sigma", "sigma"), ("path_distance", "distance")):
        each = [row[key] for row in rows]
        if None in each:
            values[measure] = None
        else:
            values[measure] = min(each)
    return {"paths": rows}, values | {"paths_free": sum(row["verdict"] == FREE for row in rows) / len(rows)}


def _path(known: Analysis, name: str, given: Mapping[str, Any], *, limits: bool) -> Record:
    try:
        judged = check_poses(known.robot, np.array(given["poses"]), given["t"], branches=False, task=known.task,
                             limits=limits, analysis=known)  # fmt: skip
    except RankdropError as error:  # the first pose is out of reach, say
        return {"name": name, "verdict": "not reached", "sigma": None, "distance": None, "q": None, "why": error.what}
    least = min(judged.stretches, key=lambda stretch: stretch.closest.sigma)
    near = min(stretch.closest.distance for stretch in judged.stretches)
    whole = judged.tool is None or judged.tool.complete
    return {
        "name": name,
        "verdict": judged.verdict if whole else "ends early",
        "sigma": float(least.closest.sigma) if whole else None,
        "distance": finite(near) if whole else None,
        "q": least.closest.q.tolist(),
        "why": "" if whole else judged.why_ended,
    }


def _measure_certified(problem: Problem, _: Any, width: float, _seed: int) -> Measured:
    robot, task = problem.robot, problem.task
    proven = covering(robot, task, plan_of(robot, width, task, limits=problem.limits))
    entry = {"free": proven.free_share, "boxes": proven.tree.leaves, "complete": proven.complete}
    return {"certified": entry}, {"free": proven.free_share if proven.complete else None}


_MEASURES: dict[str, Callable[..., Measured]] = {
    "families": _families, "aspects": _aspects, "near": _measure_near, "slow": _slow, "region": _region,
    "paths": _paths, "certified": _measure_certified,
}  # fmt: skip
"""What is measured -> measure(problem, analysis, what is asked, seed): entries of the record, and its measures."""


def variants(plan: Record, chunk: int) -> bytes:
    """The records of the variants of one chunk of a sweep.

    The families of the nominal arm are derived once in each process.
    """
    drawing, task = Drawing(**plan["drawing"]), restore(Task, plan["task"])
    places = [[NumberPlace(*place) for place in parameter] for parameter in plan["places"]]
    searched = any(plan["asks"][ask] is not None for ask in NEED_FAMILIES)
    if searched:
        nominal = _nominal(json.dumps([plan["drawing"], plan["task"]]))
    else:
        nominal = None
    size = plan["size"]
    lines = []
    for number, values in plan["variants"][chunk * size : (chunk + 1) * size]:
        given = {}
        for group, value in zip(places, values, strict=True):
            given.update(dict.fromkeys(group, value))
        try:
            robot = drawing.robot(given, f"{drawing.nominal.name} {number + 1}")
            record = measure_arm(robot, task, plan["asks"], nominal, limits=plan["limits"], seed=plan["seed"])
        except RankdropError as error:  # the numbers make no arm
            record = {"measures": {}, "error": str(error)}
        lines.append(line_of({"number": number, "values": values, **record}))
    return b"".join(lines)


def arms(plan: Record, chunk: int) -> bytes:
    """The record of one arm of a comparison; an arm of the catalogue has the families that it has there."""
    entry = plan["arms"][chunk]
    robot, task = Drawing(**entry["drawing"]).nominal, restore(Task, entry["task"])
    known = None if plan["limits"] else known_analysis(robot, task)  # what `analyze` says of it
    record = measure_arm(robot, task, plan["asks"], None, limits=plan["limits"], seed=plan["seed"], known=known)
    return line_of({"number": chunk, "values": [], **record})


def line_of(record: Record) -> bytes:
    """One line of JSON."""
    return json.dumps(record, ensure_ascii=False, allow_nan=False, sort_keys=True).encode() + b"\n"


@lru_cache(maxsize=1)
def _nominal(key: str) -> Conditions | None:
    drawing, task = json.loads(key)
    return nominal_conditions(Drawing(**drawing).nominal, restore(Task, task))
