"""The families of one variant, quickly, by what is known of a similar arm, and with evidence of its own.

Searches, signatures, soundness and completeness are the variant's own, from random starts in the whole joint space;
from the similar arm come the forms of conditions alone (`rankdrop.families.memory`). Whatever a recalled form leaves
open is done again from nothing, and then with more starts:

    recalled forms   every row sound, every fresh point explained  →  taken
    else             the same with three times the starts: a small family may have had too few points
    else             from nothing, three and ten times the starts; what is left then is told
"""

from __future__ import annotations

from dataclasses import dataclass

from rankdrop.families.memory import Memory
from rankdrop.families.searching import search
from rankdrop.families.table import families
from rankdrop.family.record import CorankFamilies, CorankSummary, Family, family_out_of_units
from rankdrop.local.block import generic_rank
from rankdrop.results.analysis import Analysis, Settings
from rankdrop.robot.model import Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_units, task_in_units
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


def families_of(robot: Robot, task: Task, effort: Effort, memory: Memory) -> Analysis:
    """Every family of an arm, each with its own evidence.

    Args:
        robot, task: the arm.
        effort: how hard.
        memory: of a similar arm; takes up what is found here.

    Returns:
        An analysis without exact conditions, its smallest near misses not sought.
    """
    own, inner = in_units(robot), task_in_units(task, robot)
    rank = generic_rank(own, inner)
    found: list[CorankFamilies] = []
    for corank in range(1, rank + 1):
        found.append(_of_corank(own, inner, corank, effort, memory))
        if found[-1].summary.converged == 0:
            break
    rows = tuple(family_out_of_units(family, robot) for one in found for family in one.families)
    settings = Settings(effort.seed, effort.starts, effort.limits, float(task.scale(robot)), DEFAULT, VERSION)
    return Analysis(robot, task, rank, settings, tuple(one.summary for one in found), rows)


def _of_corank(robot: Robot, task: Task, corank: int, effort: Effort, memory: Memory) -> CorankFamilies:
    for times, known in ((1, memory), (MORE[0], memory), *((times, Memory()) for times in MORE)):
        found = _once(robot, task, corank, effort, times, known)
        if holds(found.summary, found.families):
            break
    return found


def _once(
    robot: Robot, task: Task, corank: int, effort: Effort, times: int, memory: Memory
) -> CorankFamilies:
    """The families of one corank."""
    cloud = search(robot, corank, task=task, starts=times * effort.starts, seed=effort.seed, limits=effort.limits,
                   threads=1)  # fmt: skip
    if not cloud.complete:
        raise KeyboardInterrupt  # the core met Ctrl-C
    return families(cloud, seed=effort.seed, threads=1, wanted=effort.fresh, near_misses=False, memory=memory)


def holds(summary: CorankSummary, rows: tuple[Family, ...]) -> bool:
    """Whether every row has conditions and is sound, and every fresh point is explained."""
    sound = all(row.named and row.soundness.holds for row in rows)
    return sound and summary.completeness.agree == summary.completeness.tested
