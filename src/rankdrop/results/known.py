"""Atlases that come with the package: the arms of the catalogue need not be analysed again.

An arm is recognised by its geometry (joint kinds, screws at q = 0, home pose), not by its name: the same arm read from
a URDF or a table of parameters is known too. Limits and names play no part: the families are those of the whole torus.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from rankdrop.errors import ResultFileError
from rankdrop.family.record import Family, Pin, family_from_metres
from rankdrop.local.directions import lost_directions, lost_in_sparsest_frame
from rankdrop.local.screws import words
from rankdrop.results.codec import Record
from rankdrop.robot.model import Robot, coarse_fingerprint, geometry
from rankdrop.task import Frame, Task
from rankdrop.units import counted, in_metres, metre_exponent, shifted
from rankdrop.version import VERSION

if TYPE_CHECKING:
    from rankdrop.results.analysis import Analysis

STARTS = 10_000
"""Random starts for each corank of the atlases that are shipped."""
SEED = 0
"""Their seed."""
ANSWERS = 2
"""Number of what is answered: whoever changes what `analyze` or `conditions` find, or how they say it, raises it by
one, and every file that is shipped is stale. A release alone changes no answer."""
INDEX = "index.json"
"""File beside them: coarse fingerprint, with the tip and without -> names of the arms that have it."""
_names: WeakKeyDictionary[Robot, dict[tuple[tuple[int, ...], Frame, bool], str | None]] = WeakKeyDictionary()
"""Of arms met so far: the name that their analysis is shipped under, by rows, frame, and whether any tip will do."""
_SAME = 1e-12  # geometry that agrees to this is the same arm: σ ≤ 1e-9 holds for both


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
    there = in_metres(robot)
    names = _names.setdefault(robot, {})
    key = (task.rows, task.frame, any_tip)
    if key not in names:
        names[key] = _known_name(there, task, any_tip=any_tip)
    name = names[key]
    if name is None:
        return None
    named = _named_after(shipped(name), there)
    return named if there is robot else _out_of_metres(named, robot)


def _known_name(robot: Robot, task: Task, *, any_tip: bool) -> str | None:
    """Of an arm in metres: the name that its analysis is shipped under."""
    for tip in (True, False)[: 1 + (any_tip and task.m == 6)]:
        mine = geometry(robot, tip=tip)
        for name in candidates(robot, tip=tip):
            found = shipped(name)
            if np.abs(geometry(found.robot, tip=tip) - mine).max() <= _SAME and _same_task(found.task, task):
                return name
    return None


def _out_of_metres(found: Analysis, robot: Robot) -> Analysis:
    """An analysis in metres as one of an arm in another unit."""
    power = metre_exponent(robot)
    length = shifted(found.settings.length_scale, power)
    return replace(
        found, robot=robot, families=tuple(family_from_metres(family, robot, power) for family in found.families),
        task=replace(found.task, length_scale=length), settings=replace(found.settings, length_scale=length),
    )  # fmt: skip


def candidates(robot: Robot, *, tip: bool = True) -> tuple[str, ...]:
    """Names of the arms with a shipped analysis that may be this one: their coarse fingerprint is the same.

    Without the `tip`: this one but for its end effector.

    Makers build one geometry under several names: the robot's own name comes first.
    """
    found = _index().get(coarse_fingerprint(robot, tip=tip), ())
    return tuple(sorted(found, key=lambda name: (name != robot.name, name)))


def known_names() -> tuple[str, ...]:
    """Names of the arms that have a shipped analysis, sorted."""
    return tuple(sorted({name for names in _index().values() for name in names}))


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
    found = Analysis.from_dict(shipped_record(name), believe=True)  # tests/known/test_atlases.py does not
    return replace(found, settings=replace(found.settings, version=VERSION))  # which ships it, and answers the same


def shipped_record(name: str) -> Record:
    """The file of one arm of the catalogue as it is; its `answers` tell which code made it."""
    record: Record = json.loads((_folder() / f"{name}.json").read_text(encoding="utf-8"))
    return record


def _same_task(shipped_task: Task, task: Task) -> bool:
    return shipped_task.rows == task.rows and (task.m == 6 or shipped_task.frame == task.frame)


def _named_after(found: Analysis, robot: Robot) -> Analysis:
    """The analysis with `robot` for its arm: pinned joints under its names, lost motions in its own link frames."""
    names = [joint.name for joint in robot.variables]
    families = found.families
    if names != [joint.name for joint in found.robot.variables]:
        families = tuple(_renamed(family, names) for family in families)
    pairs = zip(robot.joints, found.robot.joints, strict=True)
    moved = np.abs(robot.home - found.robot.home).max() > _SAME
    if moved or any(np.abs(mine.frame - other.frame).max() > _SAME for mine, other in pairs):
        families = tuple(_retold(family, robot, found.task) for family in families)
    return replace(found, robot=robot, families=families)


def _retold(family: Family, robot: Robot, task: Task) -> Family:
    """The family with its lost motions in words for other link frames than those of the file."""
    plain = lost_in_sparsest_frame(robot, family.witness, task, family.corank)
    told = tuple(f"{words(one, plain.name, counted(robot))} (at the witness)" for one in plain.directions)
    return replace(family, lost_words=told, lost_directions=lost_directions(robot, family.witness, task, family.corank))


def _renamed(family: Family, names: Sequence[str]) -> Family:
    pinned = tuple(Pin(names[one.number - 1], one.number, one.values) for one in family.pinned)
    return replace(family, pinned=pinned)


@cache
def _index() -> dict[str, list[str]]:
    record: dict[str, list[str]] = json.loads((_folder() / INDEX).read_text(encoding="utf-8"))
    return record


def _folder() -> Traversable:
    return resources.files("rankdrop") / "atlases"
