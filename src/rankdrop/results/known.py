"""What comes with the package: the arms of the catalogue need not be analysed again, nor their conditions derived.

An arm is recognised by its geometry (joint kinds, screws at q = 0, home pose), not by its name: the same arm read from
a URDF or a table of parameters is known too. Limits and names play no part: the families are those of the whole torus.

Exact conditions answer one question, that of `rankdrop conditions NAME` without options. What is asked about has to be
the same arm: screws, link frames (in which lost motions are told) and home pose, letters for lengths, and the same
task.

`known/ARM.jsonl` has two lines, and who asks for one reads no other: the analysis of an arm as docs/json.md has it, and
its conditions, null where they are not completely derived.

`results/stored_conditions.py` makes conditions of their line.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from rankdrop.codec import Record
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.families.lost import freedoms_at_witness
from rankdrop.families.record import Family
from rankdrop.families.rescaling import family_from_metres
from rankdrop.lists import flat_map
from rankdrop.local.directions import lost_directions
from rankdrop.results.aspect_summary import FILE as ASPECTS
from rankdrop.results.aspect_summary import AspectSummary
from rankdrop.robot.model import Robot, coarse_fingerprint, geometry
from rankdrop.robot.open import open_robot
from rankdrop.task import Frame, Task, resolve_task
from rankdrop.tolerances import Tolerances
from rankdrop.units import in_metres, metre_exponent, shift_decimal
from rankdrop.version import VERSION

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

    from rankdrop.results.analysis import Analysis


STARTS = 10_000
"""Random starts for each corank of the atlases that are shipped."""
SEED = 0
"""Their seed."""
ANSWERS = 3
"""Number of what is answered: whoever changes what `analyze` or `conditions` find, or how they say it, raises it by
one, and every file that is shipped is stale. A release alone changes no answer."""
FOLDER = "known"
"""Folder of the files of the catalogue's arms."""
ANALYSIS, CONDITIONS = 0, 1
"""Lines of such a file."""
INDEX = "index.json"
"""File beside them: coarse fingerprint, with the tip and without -> names of the arms that have it."""
_names: WeakKeyDictionary[Robot, dict[tuple[tuple[int, ...], Frame, bool], str | None]] = WeakKeyDictionary()
"""Of arms met so far: the name that their analysis is shipped under, by rows, frame, and whether any tip will do."""
_SAME = 1e-12  # geometry that agrees to this is the same arm: σ ≤ 1e-9 holds for both

_families: WeakKeyDictionary[Robot, dict[str, tuple[Family, ...]]] = WeakKeyDictionary()
"""Of arms met so far: their shipped families, by the name of the catalogue; none refers to the arm."""


def known_analysis(robot: Robot, task: Task, *, any_tip: bool = False) -> Analysis | None:
    """The shipped analysis of an arm with this geometry and task, or None.

    The rows of the task have to be the same; unless the task has all six, so do its axes and its reference point. The
    analysis returned is of `robot` itself, with its names. Its task may be seen in another frame than `task` (the one
    its lost directions are written in), and its length scale is its own: neither changes a family of the full pose.

    Args:
        robot: any arm.
        task: from `resolve_task`.
        any_tip: an arm that differs in its end effector only is known too where the task has all six rows: a tool
            neither makes nor removes a singularity. Motions lost are told at the arm's own tip.

    Returns:
        The analysis, read once and then kept.

    Raises:
        ResultFileError: a shipped file is damaged.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> len(known_analysis(arm, resolve_task(None, arm)).families)
        9
    """
    name = known_name(robot, task, any_tip=any_tip)
    if name is None:
        return None
    there = in_metres(robot)
    named = replace(_named_after(shipped(name), there), aspects=catalogue_aspects().get(name))
    if there is robot:
        return named
    return _out_of_metres(named, robot)


def shipped_families(robot: Robot, task: Task, *, any_tip: bool = False) -> tuple[Family, ...] | None:
    """The families of `known_analysis`, made once for each arm; None for an arm that is not known."""
    name = known_name(robot, task, any_tip=any_tip)
    if name is None:
        return None
    kept = _families.setdefault(robot, {})
    if name not in kept:
        known = known_analysis(robot, task, any_tip=any_tip)
        kept[name] = () if known is None else known.families
    return kept[name]


def known_families(
    robot: Robot, task: Task, analysis: Analysis | None, tolerances: Tolerances
) -> tuple[tuple[Family, ...], str]:
    """Known families and where they come from: the analysis given, else the atlas that is shipped, else nowhere.

    Raises:
        OptionError: the analysis is about another arm or other rows.
    """
    if analysis is None:
        known = shipped_families(robot, task, any_tip=True)
        if known is None:
            return ((), "on the spot")
        return (known, "catalogue")
    from rankdrop.results.analysis import Analysis  # who asks for conditions alone does without

    if not isinstance(analysis, Analysis):
        raise OptionError("an analysis is needed", got=repr(analysis)[:80], allowed="an Analysis, or None")
    mine, other = (geometry(arm, tip=task.m < 6) for arm in (robot, analysis.robot))
    if mine.shape != other.shape or np.abs(mine - other).max() > tolerances.value:
        raise OptionError("the analysis is about another arm", got=analysis.robot.name, allowed=robot.name)
    if analysis.task.rows != task.rows or analysis.task.frame != task.frame:
        raise OptionError("the analysis is about another task", got=analysis.task.name, allowed=task.name)
    return analysis.families, "analysis"


def known_name(robot: Robot, task: Task, *, any_tip: bool = False) -> str | None:
    """The name in the catalogue of an arm with this geometry and task, or None.

    Args:
        robot: any arm.
        task: from `resolve_task`.
        any_tip: as in `known_analysis`.
    """
    names = _names.setdefault(robot, {})
    key = (task.rows, task.frame, any_tip)
    if key not in names:
        names[key] = _known_name(in_metres(robot), task, any_tip=any_tip)
    return names[key]


def known_aspects(robot: Robot, task: Task) -> AspectSummary | None:
    """The stored number of aspects of an arm with this geometry and task, or None; joint limits play no part.

    An arm that differs from an arm of the catalogue in its end effector only is known where the task has all six rows:
    a tool neither makes nor removes a singularity.

    Args:
        robot: any arm.
        task: from `resolve_task`.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("ur5e")
        >>> known_aspects(arm, resolve_task(None, arm)).number
        8
    """
    there, tip = in_metres(robot), task.m < 6
    mine = geometry(there, tip=tip)
    for name in candidates(there, tip=tip):
        arm = open_robot(name)
        own = resolve_task(None, arm)
        same_task = own.rows == task.rows and (task.m == 6 or own.frame == task.frame)
        if same_task and np.abs(geometry(in_metres(arm), tip=tip) - mine).max() <= _SAME:
            return catalogue_aspects().get(name)
    return None


@cache
def catalogue_aspects() -> dict[str, AspectSummary]:
    """Name of an arm of the catalogue -> its number of aspects, for the task that the arm is made for."""
    return {name: AspectSummary(**entry) for name, entry in (_file("aspects", ASPECTS) or {}).items()}


def _known_name(robot: Robot, task: Task, *, any_tip: bool) -> str | None:
    for tip in (True, False)[: 1 + (any_tip and task.m == 6)]:
        mine = geometry(robot, tip=tip)
        for name in candidates(robot, tip=tip):
            analysis = shipped(name)
            if np.abs(geometry(analysis.robot, tip=tip) - mine).max() <= _SAME and (
                analysis.task.rows == task.rows and (task.m == 6 or analysis.task.frame == task.frame)
            ):
                return name
    return None


def _out_of_metres(analysis: Analysis, robot: Robot) -> Analysis:
    power = metre_exponent(robot)
    length = shift_decimal(analysis.settings.length_scale, power)
    return replace(
        analysis, robot=robot, families=tuple(family_from_metres(family, robot, power) for family in analysis.families),
        task=replace(analysis.task, length_scale=length), settings=replace(analysis.settings, length_scale=length),
    )  # fmt: skip


def candidates(robot: Robot, *, tip: bool = True) -> tuple[str, ...]:
    """Names of the arms with a shipped analysis that may be this one: their coarse fingerprint is the same.

    Without the `tip`: this one but for its end effector.

    Makers build one geometry under several names: the robot's own name comes first.
    """
    names = _index().get(coarse_fingerprint(robot, tip=tip), ())
    return tuple(sorted(names, key=lambda name: (name != robot.name, name)))


def known_names() -> tuple[str, ...]:
    """Names of the arms that have a shipped analysis, sorted."""
    return tuple(sorted(set(flat_map(list, _index().values()))))


@cache
def shipped(name: str) -> Analysis:
    """The analysis that is shipped for one arm of the catalogue.

    Raises:
        ResultFileError: there is none, or it is damaged.
    """
    from rankdrop.results.analysis import Analysis  # who asks for conditions alone does without

    if name not in known_names():
        allowed = ", ".join(known_names())
        raise ResultFileError("there is no shipped analysis of this arm", got=repr(name), allowed=allowed)
    analysis = Analysis.from_dict(shipped_record(name), believe=True)  # tests/results/test_known.py does not
    settings = replace(analysis.settings, version=VERSION)  # which ships it, and answers the same
    return replace(analysis, settings=settings)


def shipped_record(name: str) -> Record:
    """The analysis of one arm of the catalogue as its file has it; its `answers` tell which code made it."""
    record: Record = part_of_file(_shipped_file(name), ANALYSIS)
    return record


def _named_after(analysis: Analysis, robot: Robot) -> Analysis:
    """The analysis with `robot` for its arm: pinned joints under its names, lost motions in its own link frames."""
    names = [joint.name for joint in robot.variables]
    families = analysis.families
    if names != [joint.name for joint in analysis.robot.variables]:
        families = tuple(
            replace(family, pinned=tuple(replace(pin, joint=names[pin.number - 1]) for pin in family.pinned))
            for family in families
        )  # fmt: skip
    pairs = zip(robot.joints, analysis.robot.joints, strict=True)
    moved = np.abs(robot.home - analysis.robot.home).max() > _SAME
    if moved or any(np.abs(mine.frame - other.frame).max() > _SAME for mine, other in pairs):
        families = tuple(_lost_in_these_frames(family, robot, analysis.task) for family in families)
    return replace(analysis, robot=robot, families=families)


def _lost_in_these_frames(family: Family, robot: Robot, task: Task) -> Family:
    """The family with its lost motions for other link frames than those of the file."""
    at = np.array(family.witness)
    return replace(
        family, lost_freedoms=freedoms_at_witness(robot, at, task, family.corank),
        lost_directions=lost_directions(robot, at, task, family.corank),
    )  # fmt: skip


@cache
def _index() -> dict[str, list[str]]:
    record: dict[str, list[str]] = _file(FOLDER, INDEX)
    return record


def _file(folder: str, name: str) -> Any:
    """The data of a shipped file; None where there is none."""
    path = resources.files("rankdrop") / folder / name
    if path.is_file():
        return json.loads(path.read_text(encoding="utf-8"))
    return None


def _shipped_file(name: str) -> Traversable:
    return resources.files("rankdrop") / FOLDER / f"{name}.jsonl"


def part_of_file(path: Traversable, line: int) -> Any:
    """One line of the file of an arm, `ANALYSIS` or `CONDITIONS`; None where there is no file, or nothing in it."""
    if not path.is_file():
        return None
    with path.open("rb") as stream:
        for _ in range(line):
            stream.readline()
        return json.loads(stream.readline())


def file_text(analysis: Record | None, conditions: Record | None) -> str:
    """The file of an arm: what `part_of_file` reads, in its order."""
    lines = [
        json.dumps(part, ensure_ascii=False, allow_nan=False, separators=(",", ":")) for part in (analysis, conditions)
    ]
    return "\n".join(lines) + "\n"


def is_of(record: Record, robot: Robot, task: Task, *, any_tip: bool = False) -> bool:
    """Whether a stored derivation is that of this arm and task: kinds, screws, frames and home pose, letters, rows.

    With `any_tip` frames and home pose may be others where the task has all six rows: conditions do not depend on them,
    sentences on lost motions do.
    """
    mine, own = arm_and_task(robot, task), record["arm"]
    exact = all(mine[key] == own[key] for key in ("kinds", "lengths", "task"))
    keys = ("screws",) if any_tip and task.m == 6 else ("screws", "frames", "home")
    return exact and all(np.abs(np.array(mine[key]) - own[key]).max() <= _SAME for key in keys)


def arm_and_task(robot: Robot, task: Task) -> Record:
    """What stored conditions are of: joint kinds, lengths with letters, screws, link frames, home pose, rows, frame."""
    frame = task.frame
    return {
        "kinds": [str(joint.kind) for joint in robot.joints],
        "lengths": dict(robot.lengths),
        "screws": [joint.screw.tolist() for joint in robot.joints],
        "frames": [joint.frame[:3].tolist() for joint in robot.joints],
        "home": robot.home.tolist(),
        "task": {
            "name": task.name, "rows": list(task.rows), "axes": frame.axes, "origin": frame.origin,
            "point": list(frame.point),
        },
    }  # fmt: skip


def shipped_conditions_record(robot: Robot, task: Task, *, any_tip: bool = False) -> Record | None:
    """The shipped conditions of this arm and task as they stand in their file, or None; see `known_conditions`."""
    for name in candidates(robot, tip=not any_tip or task.m < 6):
        record = conditions_record(name)
        if record is not None and record.get("answers") == ANSWERS and is_of(record, robot, task, any_tip=any_tip):
            return record
    return None


@cache
def conditions_names() -> tuple[str, ...]:
    """Names of the arms whose conditions are shipped, sorted."""
    return tuple(name for name in known_names() if _has_conditions(_shipped_file(name)))


def _has_conditions(path: Traversable) -> bool:
    """Whether the second line of a file is not null; it is not read to its end."""
    with path.open("rb") as stream:
        stream.readline()
        return stream.read(4) != b"null"


@cache
def conditions_record(name: str) -> Record | None:
    """The conditions of one arm of the catalogue as its file has them; None where none are shipped."""
    record: Record | None = part_of_file(_shipped_file(name), CONDITIONS)
    return record
