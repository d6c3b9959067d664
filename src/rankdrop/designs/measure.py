"""What is measured of one arm: its families, how much of the joint space is near them, σ over a region, paths, proofs.

All of it as plain data, one record for each arm; docs/howto/comparing-designs.md says what every entry means.

Families of a variant are those of the nominal arm, derived once with letters for its lengths; the variant's lengths
take the place of the letters. Searches, soundness and completeness are the variant's own, from random starts in the
whole joint space. What is left open, where a length is special, is done again:

    nominal conditions   every family sound, every fresh point explained  →  taken
    else                 the same with three times the starts: a small family may have had too few points
    else                 conditions fitted to the points, three and ten times the starts

How well an arm does its task over a region of its workspace is told by the best posture found at seeded poses in it.

    σ(pose) = max over the solutions q of the inverse found, within the limits, of σ_r(J(q))

The smallest of these over the region says how near to singular the arm has to come there, whatever posture it takes; a
posture that was missed can only make it larger, so that it is a bound from below at the poses looked at, and says
nothing between them. Solutions come from Newton's method with damping from random starts, all poses at once.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.covering import covering
from rankdrop.codec import plain
from rankdrop.designs.changes import form_of, key_of
from rankdrop.designs.ranking import bits_to_text
from rankdrop.designs.spec import finite
from rankdrop.errors import RankdropError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.family import ExactFamily
from rankdrop.families.searching import search
from rankdrop.families.share import NearShare, near_shares
from rankdrop.families.table import families
from rankdrop.family.record import CorankFamilies, CorankSummary, Family, family_out_of_units
from rankdrop.local.block import generic_rank, joint_scale, sample, singular_values
from rankdrop.motion.check import check_poses
from rankdrop.motion.inverse import Aim
from rankdrop.motion.record import FREE
from rankdrop.problem import Problem
from rankdrop.results.analysis import Analysis, Settings
from rankdrop.results.codec import restored
from rankdrop.results.conditions import Conditions
from rankdrop.results.known import known_analysis, known_conditions
from rankdrop.robot.drawing import Drawing, Place
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import from_xyz_rpy
from rankdrop.task import Task
from rankdrop.text.families import condition_text
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_units, task_in_units
from rankdrop.verbs.analyze import SECONDS
from rankdrop.verbs.conditions import conditions
from rankdrop.version import VERSION

MORE = (3, 10)
"""Times the starts, where something is left open."""


@dataclass(frozen=True)
class Effort:
    """How hard the families of a variant are looked for.

    Attributes:
        starts: random starts for each corank.
        fresh: independent points for completeness, of each corank.
        limits: within the joint limits only.
        seed: of every random choice.
    """

    starts: int
    fresh: int
    limits: bool
    seed: int


def nominal_conditions(robot: Robot, task: Task) -> Conditions | None:
    """The families of a nominal arm in letters for its lengths; None where they are not derived, or with numbers."""
    try:
        derived = known_conditions(robot, task, any_tip=True)
        if derived is None:
            derived = conditions(robot, task, method="tree", seconds=SECONDS["auto"], points=0, special=False)
    except RankdropError:
        return None
    return derived if derived.complete and derived.letters else None


def with_lengths_of(robot: Robot, task: Task, nominal: Conditions | None) -> tuple[ExactFamily, ...] | None:
    """The families of a nominal arm with the lengths of another one; None where its screws are others in letters too.

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
    return tuple(replace(one, numbers=chain.numbers) for one in nominal.families)


def families_of(robot: Robot, task: Task, effort: Effort, nominal: Conditions | None) -> Analysis:
    """Every family of an arm, each with its own evidence.

    Args:
        robot, task: the arm.
        effort: how hard.
        nominal: of an arm with the same letters for lengths; None: conditions are fitted.

    Returns:
        An analysis whose smallest near misses are not sought.
    """
    own, inner = in_units(robot), task_in_units(task, robot)
    rank = generic_rank(own, inner)
    derived = with_lengths_of(robot, task, nominal)
    known = None if derived is None else [one.in_units(robot).as_family(own) for one in derived]
    found: list[CorankFamilies] = []
    for corank in range(1, rank + 1):
        here = None if known is None else [one for one in known if one.corank == corank]
        found.append(_of_corank(own, inner, corank, effort, here))
        if found[-1].summary.converged == 0:
            break
    rows = tuple(family_out_of_units(family, robot) for one in found for family in one.families)
    settings = Settings(effort.seed, effort.starts, effort.limits, float(task.scale(robot)), DEFAULT, VERSION)
    return Analysis(robot, task, rank, settings, tuple(one.summary for one in found), rows)


def _of_corank(
    robot: Robot, task: Task, corank: int, effort: Effort, known: Sequence[Family] | None
) -> CorankFamilies:
    """The families of one corank: with the nominal conditions, or fitted where these leave something open."""
    for times, given in (*(((1, known), (MORE[0], known)) if known is not None else ((1, None),)),
                         *((times, None) for times in MORE)):  # fmt: skip
        found = _once(robot, task, corank, effort, times, given)
        if holds(found.summary, found.families):
            break
    return found


def _once(
    robot: Robot, task: Task, corank: int, effort: Effort, times: int, known: Sequence[Family] | None
) -> CorankFamilies:
    """The families of one corank; nominal ones that have no real configuration with these lengths are left out."""
    cloud = search(robot, corank, task=task, starts=times * effort.starts, seed=effort.seed, limits=effort.limits,
                   threads=1)  # fmt: skip
    if not cloud.complete:
        raise KeyboardInterrupt  # the core met Ctrl-C
    found = families(cloud, known=known, seed=effort.seed, threads=1, fresh=effort.fresh, near_misses=False)
    unreal = {family.id for family, _ in found.contradictions}
    return replace(found, families=tuple(one for one in found.families if one.id not in unreal))


def holds(summary: CorankSummary, rows: tuple[Family, ...]) -> bool:
    """Whether every row has conditions and is sound, and every fresh point is explained."""
    sound = all(row.named and row.soundness.holds for row in rows)
    return sound and summary.completeness.agree == summary.completeness.tested


Record = dict[str, Any]
STARTS, FRESH = 300, 300
"""Of families that are needed but were not asked for."""


def measured(
    robot: Robot, task: Task, asks: Mapping[str, Any], nominal: Conditions | None, *, limits: bool, seed: int,
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
    try:
        asked, found = asks["families"], known
        if known is None and any(asks[ask] is not None for ask in ("families", "near", "paths")):
            starts, fresh = (STARTS, FRESH) if asked is None else (asked["starts"], asked["fresh"])
            found = families_of(robot, task, Effort(starts, fresh, limits, seed), nominal)
        if asked is not None and found is not None:
            _report_families(found, record)
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


def _report_families(found: Analysis, record: Record) -> None:
    record["verdict"] = found.verdict.word
    record["sentence"] = found.verdict.sentence
    record["rank"] = found.generic_rank
    record["families"] = [_family(one, found.robot) for one in found.families]
    record["measures"]["families"] = len(found.families)


def _family(family: Family, robot: Robot) -> Record:
    coupled, form = set(family.coupled), form_of(family, robot)
    return {
        "id": family.id,
        "key": key_of(form),
        "structure": plain(form),
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


def _near(analysis: Analysis, asked: Mapping[str, Any], limits: bool, seed: int, record: Record) -> None:
    near = near_shares(analysis.families, Problem(analysis.robot, analysis.task, limits=limits), asked["within"],
                       samples=asked["samples"], seed=seed)  # fmt: skip
    record["near"] = {"any": _share(near.any), "families": [_share(one) for one in near.families],
                      "samples": near.samples, "hits": bits_to_text(near.hits)}  # fmt: skip
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
    sigma, q, lowest = reached(robot, task, targets, oriented=rpy is not None, starts=asked["starts"], seed=seed,
                               limits=limits)  # fmt: skip
    there = np.isfinite(sigma)
    worst = int(np.nanargmin(sigma)) if there.any() else None
    record["region"] = {
        "poses": len(targets),
        "reached": int(there.sum()),
        "each": [finite(value) for value in sigma],
        "lowest": finite(lowest),
        "sigma": None if worst is None else float(sigma[worst]),
        "at": None if worst is None else targets[worst, :3, 3].tolist(),
        "q": None if worst is None else q[worst].tolist(),
    }
    record["measures"]["sigma"] = record["region"]["sigma"]
    record["measures"]["reached"] = float(there.mean())


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
        "why": "" if whole else judged.why_ended,
    }


def _certified(robot: Robot, task: Task, width: float, limits: bool, record: Record) -> None:
    found = covering(robot, width, task, limits=limits, threads=1)
    record["certified"] = {"free": found.free_share, "boxes": found.tree.leaves, "complete": found.complete}
    record["measures"]["free"] = found.free_share if found.complete else None


_ITERATIONS = 40
_LONGEST = 0.5  # of a step [rad; slides scaled]
_CLOSE = 1e-9  # |e| at a solution: lengths divided by the length scale, angles in rad
_ROWS_OF_POSITION = 3


def targets_of(lower: Array, upper: Array, rpy: Array | None, count: int, seed: int) -> Array:
    """(count, 4, 4) poses in a box of the base frame [m]: the same for every arm that is asked."""
    places = np.random.default_rng([seed, 5]).uniform(lower, upper, (count, 3))
    turned = from_xyz_rpy([0.0, 0.0, 0.0], [0.0, 0.0, 0.0] if rpy is None else rpy.tolist())
    found = np.repeat(turned[None], count, axis=0)
    found[:, :3, 3] = places
    return found


def reached(
    robot: Robot, task: Task, targets: Array, *, oriented: bool, starts: int, seed: int, limits: bool
) -> tuple[Array, Array, float]:
    """The best posture found at every pose.

    Args:
        robot: the arm.
        task: whose σ counts.
        targets: (P, 4, 4) [m].
        oriented: the orientation is meant too, as far as the task has rows for it; else places alone.
        starts: random starts for each pose.
        seed: of the starts.
        limits: solutions within the joint limits only.

    Returns:
        (P,) the largest σ_r of a solution, NaN where none was found; (P, n) that solution; the smallest σ_r of any
        solution, NaN where there is none.
    """
    rows = tuple(row for row in task.rows if oriented or row < _ROWS_OF_POSITION)
    inner = Task(",".join(map(str, rows)), rows, task.frame, task.scale(robot))
    count = len(targets)
    q = sample(robot, task, count * starts, seed, limits=limits)
    which = np.repeat(np.arange(count), starts)
    good = _solve(robot, inner, targets[which], q)
    if limits:
        q, inside = _inside(robot, q)
        good &= inside
    sigma = np.where(good, singular_values(robot, q, task)[:, generic_rank(robot, task) - 1], -np.inf)
    sigma = sigma.reshape(count, starts)
    best = sigma.argmax(axis=1)
    top = sigma[np.arange(count), best]
    lowest = sigma[np.isfinite(sigma)]
    found = q.reshape(count, starts, -1)[np.arange(count), best]
    return np.where(np.isfinite(top), top, np.nan), found, float(lowest.min()) if len(lowest) else float("nan")


def _solve(robot: Robot, task: Task, targets: Array, q: Array) -> NDArray[np.bool_]:
    """Damped steps from q (N, n), in place, each to its own target (N, 4, 4): (N,) which arrived."""
    aim, scale = Aim(robot, task), joint_scale(robot, task)
    good = np.zeros(len(q), dtype=np.bool_)
    going = np.arange(len(q))
    for _ in range(_ITERATIONS):
        e = aim.error(targets[going], q[going])
        size = np.linalg.norm(e, axis=1)
        done = size <= _CLOSE
        good[going[done]] = True
        going, e, size = going[~done], e[~done], size[~done]
        if not len(going):
            break
        step = aim.step(q[going], e, np.minimum(size**2, 1.0))
        length = np.linalg.norm(step / scale, axis=1)
        q[going] += step * np.minimum(1.0, _LONGEST / np.maximum(length, 1e-300))[:, None]
    return good


def _inside(robot: Robot, q: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Solutions turned by whole turns into their limits where that is possible, and (N,) which are inside."""
    moved = np.array(q)
    inside = np.ones(len(q), dtype=np.bool_)
    for j, (low, high) in enumerate(zip(robot.lower, robot.upper, strict=True)):
        if robot.periodic[j]:
            middle = 0.5 * (low + high) if np.isfinite(low) and np.isfinite(high) else 0.0
            moved[:, j] -= 2 * np.pi * np.round((moved[:, j] - middle) / (2 * np.pi))
            if np.isfinite(low):
                moved[:, j] += 2 * np.pi * np.maximum(0, np.ceil((low - 1e-9 - moved[:, j]) / (2 * np.pi)))
        inside &= (moved[:, j] >= low - 1e-9) & (moved[:, j] <= high + 1e-9)
    return moved, inside


def variants(plan: Record, chunk: int) -> bytes:
    """The records of the variants of one chunk of a sweep.

    The families of the nominal arm are derived once in each process.
    """
    drawing, task = Drawing(**plan["drawing"]), restored(Task, plan["task"])
    places = [[Place(*one) for one in parameter] for parameter in plan["places"]]
    searched = any(plan["asks"][ask] is not None for ask in ("families", "near", "paths"))
    nominal = _nominal(json.dumps([plan["drawing"], plan["task"]])) if searched else None
    size = plan["size"]
    lines = []
    for number, values in plan["variants"][chunk * size : (chunk + 1) * size]:
        given = {place: x for group, x in zip(places, values, strict=True) for place in group}
        try:
            robot = drawing.robot(given, f"{drawing.nominal.name} {number + 1}")
            record = measured(robot, task, plan["asks"], nominal, limits=plan["limits"], seed=plan["seed"])
        except RankdropError as error:  # the numbers make no arm
            record = {"measures": {}, "error": str(error)}
        lines.append(line_of({"number": number, "values": values, **record}))
    return b"".join(lines)


def arms(plan: Record, chunk: int) -> bytes:
    """The record of one arm of a comparison; an arm of the catalogue has the families that it has there."""
    entry = plan["arms"][chunk]
    robot, task = Drawing(**entry["drawing"]).nominal, restored(Task, entry["task"])
    known = None if plan["limits"] else known_analysis(robot, task)  # what `analyze` says of it
    record = measured(robot, task, plan["asks"], None, limits=plan["limits"], seed=plan["seed"], known=known)
    return line_of({"number": chunk, "values": [], **record})


def line_of(record: Record) -> bytes:
    """One line of JSON."""
    return json.dumps(record, ensure_ascii=False, allow_nan=False, sort_keys=True).encode() + b"\n"


@lru_cache(maxsize=1)
def _nominal(key: str) -> Conditions | None:
    drawing, task = json.loads(key)
    return nominal_conditions(Drawing(**drawing).nominal, restored(Task, task))
