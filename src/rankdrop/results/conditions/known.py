"""Exact conditions that come with the package: those of the catalogue's arms need not be derived again.

They answer one question, that of `rankdrop conditions NAME` without options. What is asked about has to be the same
arm: screws, link frames (in which lost motions are told) and home pose, letters for lengths, and the same task.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable

from rankdrop.errors import ResultFileError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.results.codec import Record
from rankdrop.results.conditions.conditions import Conditions
from rankdrop.results.conditions.data import ConditionsData
from rankdrop.results.conditions.stored import from_stored, is_of
from rankdrop.results.known import candidates
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task
from rankdrop.version import VERSION


def known_conditions(
    robot: Robot, task: str | Task | None = None, *, anew: Callable[[], ConditionsData] | None = None
) -> Conditions | None:
    """The shipped conditions of this arm, or None: another arm, another task, or made by another version.

    Args:
        robot: any arm.
        task: as in `resolve_task`; the length scale plays no part.
        anew: derives them once more, for `Conditions.test`.

    Returns:
        Conditions of `robot` itself, with its names; equal in all else to what a derivation gives.

    Raises:
        MissingExtraError: python-flint is not installed.
        ResultFileError: a shipped file is damaged.

    Example:
        >>> found = known_conditions(open_robot("pa10"), "position")
        >>> found is None  # shipped are those of the task that the arm is made for
        True
    """
    resolved = resolve_task(task, robot)
    for name in candidates(robot):
        record = _record(name)
        if record is not None and record["settings"]["version"] == VERSION and is_of(record, robot, resolved):
            return from_stored(record, robot, resolved, exact_chain(robot, resolved), anew=anew)
    return None


def shipped_conditions(name: str) -> Conditions:
    """The conditions that are shipped for one arm of the catalogue, whatever version made them.

    Raises:
        MissingExtraError: python-flint is not installed.
        ResultFileError: there are none, or the file is damaged.
    """
    record = _record(name)
    if record is None:
        allowed = ", ".join(conditions_names())
        raise ResultFileError("no conditions of this arm are shipped", got=repr(name), allowed=allowed)
    robot = open_robot(name)
    chain = exact_chain(robot)
    return from_stored(record, robot, chain.task, chain)


def conditions_names() -> tuple[str, ...]:
    """Names of the arms whose conditions are shipped, sorted."""
    if not _folder().is_dir():
        return ()
    return tuple(sorted(item.name.removesuffix(".json") for item in _folder().iterdir() if item.name.endswith(".json")))


@cache
def _record(name: str) -> Record | None:
    path = _folder() / f"{name}.json"
    if not path.is_file():
        return None
    record: Record = json.loads(path.read_text(encoding="utf-8"))
    return record


def _folder() -> Traversable:
    return resources.files("rankdrop") / "derivations"
