"""Which singularity: families known beforehand, and those that a configuration lies on."""

from __future__ import annotations

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.families.on_the_spot import name_on_the_spot
from rankdrop.family.record import Family
from rankdrop.family.which import Met, families_at
from rankdrop.results.analysis import Analysis
from rankdrop.results.explanation.data import Asked
from rankdrop.results.known import known_analysis
from rankdrop.robot.fingerprint import geometry
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import Tolerances


def known_families(
    robot: Robot, task: Task, analysis: Analysis | None, tolerances: Tolerances
) -> tuple[tuple[Family, ...], str]:
    """Known families and where they come from: the analysis given, else the atlas that is shipped, else nowhere.

    Raises:
        OptionError: the analysis is about another arm or other rows.
    """
    if analysis is None:
        known = known_analysis(robot, task)
        return (known.families, "catalogue") if known else ((), "on the spot")
    if not isinstance(analysis, Analysis):
        raise OptionError("an analysis is needed", got=repr(analysis)[:80], allowed="an Analysis, or None")
    mine, other = geometry(robot), geometry(analysis.robot)
    if mine.shape != other.shape or np.abs(mine - other).max() > tolerances.value:
        raise OptionError("the analysis is about another arm", got=analysis.robot.name, allowed=robot.name)
    if analysis.task.rows != task.rows or analysis.task.frame != task.frame:
        raise OptionError("the analysis is about another task", got=analysis.task.name, allowed=task.name)
    return analysis.families, "analysis"


def met_at(asked: Asked, q: Array, corank: int) -> tuple[Met, ...]:
    """The families that a singular configuration q lies on; named on the spot where none of its corank is known."""
    robot, task, settings = asked.robot, asked.task, asked.settings
    found = families_at(asked.families, robot, q, task, settings.tolerances, asked.source)
    if found and found[0].family.corank >= corank:
        return found
    local = name_on_the_spot(robot, q, task, corank, seed=settings.seed)
    return (Met(local, 0.0, "on the spot"), *found)
