"""What a report shows, worked out once: everything the page and the figures draw.

Ways out of a witness, as the buttons of the page.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rankdrop import conditions
from rankdrop.errors import MissingExtraError, RobotError
from rankdrop.families import (
    Slice,
    Solid,
    Sweep,
    Workspace,
    posed,
    solids,
    sweeps,
    telling_slices,
    workspace,
)
from rankdrop.family import Family
from rankdrop.local import LARGEST_CHAIN, Direction, blame, circuits_at, escape, generic_rank, make_all
from rankdrop.results import Analysis, Conditions, Verdict, known_conditions, motion, of_analysis, short
from rankdrop.robot import Array, Mesh, Robot
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.text import inside_limits
from rankdrop.verbs import Idealised, moved_section, nearby, there_section

_SINGLE = 3  # joints alone that are offered, the best first


@dataclass(frozen=True, slots=True)
class Way:
    """One motion that restores the full rank.

    Attributes:
        label: what is pressed: "joint 5 +5.7°".
        after: what it gives: "σ6 = 0.017".
        q: (n,) where it leads [rad, m].
    """

    label: str
    after: str
    q: tuple[float, ...]


def ways_out(robot: Robot, task: Task, family: Family) -> tuple[Way, ...]:
    """The best direction and the best joints alone that lead out of the witness inside the limits; () for none.

    Where the witness itself is outside the limits no motion counts as inside, and there are none.
    """
    q = np.array(family.witness)
    found = escape(robot, q, task)
    rank = f"σ{generic_rank(robot, task)}"
    ways = []
    for one in found.single:
        if one.order is None or not one.within_limits or one.step == 0 or one.sigma_after <= found.floor:
            continue
        target = q.copy()
        target[one.number - 1] += one.step
        told = f"joint {one.number} {motion(one.step, robot.variables[one.number - 1].unit)}"
        ways.append(Way(told, f"{rank} = {short(one.sigma_after, 2)}", tuple(target.tolist())))
    return (*_direction(q, found.best_direction, rank), *ways[:_SINGLE])


def _direction(q: Array, direction: Direction, rank: str) -> tuple[Way, ...]:
    if direction.step == 0 or not direction.restores or not direction.within_limits:
        return ()
    target = q + direction.step * np.array(direction.delta)
    return (Way("best direction", f"{rank} = {short(direction.sigma_after, 2)}", tuple(target.tolist())),)


Progress = Callable[[str, int, int], None]
"""progress(label, done, total)."""
EXACT_SECONDS = 8.0
"""Time limit of the exact conditions; what was derived by then is shown."""
EXACT_POINTS = 200
"""Singular configurations that the exact families have to explain, corank 1."""
_PARTS = 5
_EDGE = 1e-9  # a joint this far beyond a limit stands on it [rad, m]
_WITH_WAYS = 60  # of a calibrated arm's hundreds of families no reader asks for more


@dataclass(frozen=True, eq=False)
class Content:
    """All that a report shows of one arm.

    Attributes:
        analysis: the families and how they were verified, each with its witness in a posture that can be looked at
            (`rankdrop.families.posed`).
        blamed: per family the joints (from 1) of the smallest dependent sets special to its witness, one set for each
            freedom lost.
        blame_words: per family the sets from which all its dependencies follow, in words.
        exact: the conditions, exactly; None where they are not to be had, or stand in the analysis (`Analysis.exact`).
        exact_missing: why not; "" otherwise.
        slices: planes of joint space.
        solids: families in the cube of three joints.
        workspace: in section.
        sweeps: per family, each joint swept through its witness.
        ways: per family, the ways out of its witness; of the first 60 families.
        beside: what was moved to make the arm ideal, and what the arm itself does; empty for any other arm.
        meshes: shapes of the links, where the arm's file has them.
    """

    analysis: Analysis
    blamed: tuple[tuple[int, ...], ...]
    blame_words: tuple[tuple[str, ...], ...]
    exact: Conditions | None
    exact_missing: str
    slices: tuple[Slice, ...]
    solids: tuple[Solid, ...]
    workspace: Workspace
    sweeps: tuple[tuple[Sweep, ...], ...]
    ways: tuple[tuple[Way, ...], ...] = ()
    beside: tuple[Section, ...] = ()
    meshes: tuple[Mesh, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Of the analysis and of the exact conditions beside it: first and last on the page, and the exit code."""
        return of_analysis(self.analysis, self.exact)

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the derivation of the exact conditions: the page has what was derived by then."""
        joined = self.analysis.exact
        return (self.exact is not None and self.exact.interrupted) or (joined is not None and joined.interrupted)

    @property
    def colours(self) -> dict[str, int]:
        """A number for the colour of each family: those of corank 1 first, the same everywhere in the report."""
        ordered = sorted(self.analysis.families, key=lambda family: family.corank)
        return {family.id: index for index, family in enumerate(ordered)}


def content(
    analysis: Analysis, *, exact: bool = True, exact_seconds: float = EXACT_SECONDS, seed: int = 0,
    made: Idealised | None = None, progress: Progress | None = None, meshes: tuple[Mesh, ...] = (),
) -> Content:  # fmt: skip
    """Work out all that a report of this analysis shows.

    Args:
        analysis: of the arm.
        exact: derive the exact conditions as well.
        exact_seconds: their time limit.
        seed: of every random choice.
        made: how the arm was made, where it is an ideal one.
        progress: called as progress(label, done, total).
        meshes: shapes of the links (`rankdrop.report.data.simplified`).
    """
    robot, task = analysis.robot, analysis.task
    families = tuple(posed(robot, task, family, analysis.families) for family in analysis.families)
    analysis = replace(analysis, families=families)
    tell = progress or (lambda label, done, total: None)
    tell("report", 0, _PARTS)
    derived, missing = _exact(analysis, exact_seconds, seed) if exact else (None, "They were not asked for.")
    tell("report", 1, _PARTS)
    planes = telling_slices(robot, task, families, seed=seed)
    tell("report", 2, _PARTS)
    sets = solids(robot, task, families, seed=seed)
    tell("report", 3, _PARTS)
    section = workspace(robot, task, families, seed=seed)
    tell("report", 4, _PARTS)
    to_blame = [_blame(analysis, family) for family in families]
    swept = tuple(sweeps(robot, family.witness, task) for family in families)
    tell("report", 5, _PARTS)
    return Content(
        analysis=analysis,
        blamed=tuple(numbers for numbers, _ in to_blame),
        blame_words=tuple(words for _, words in to_blame),
        exact=derived,
        exact_missing=missing,
        slices=planes,
        solids=sets,
        workspace=section,
        sweeps=swept,
        ways=tuple(ways_out(robot, task, family) for family in families[:_WITH_WAYS]),
        beside=_beside(analysis, made, seed),
        meshes=meshes,
    )


def _beside(analysis: Analysis, made: Idealised | None, seed: int) -> tuple[Section, ...]:
    if made is None:
        return ()
    there = nearby(made, analysis.task, analysis.families, seed=seed)
    return (moved_section(made), *((there_section(there),) if there else ()))


def standing(analysis: Analysis, family: Family) -> str:
    """How a family stands to the joint limits.

    Returns:
        "inside": the witness is inside; "outside": a value of a pinned joint lies outside at every turn, for all its
        members; "none found": no member inside was met, which is no proof; "" for an arm without limits.
    """
    robot = analysis.robot
    if not (np.isfinite(robot.lower) | np.isfinite(robot.upper)).any():
        return ""
    q = np.array(family.witness)
    if ((q >= robot.lower - _EDGE) & (q <= robot.upper + _EDGE)).all():
        return "inside"
    return "none found" if inside_limits(family, robot).holds else "outside"


def _exact(analysis: Analysis, seconds: float, seed: int) -> tuple[Conditions | None, str]:
    """The conditions and "", or None and why not; an analysis that holds them already needs no second derivation."""
    if analysis.exact is not None and analysis.exact.families:
        return None, "They stand in the analysis."
    try:
        shipped = None if seed else known_conditions(analysis.robot, analysis.task)
        found = shipped or conditions(
            analysis.robot, analysis.task, seconds=seconds, seed=seed, points=EXACT_POINTS, special=False
        )
    except (MissingExtraError, RobotError) as error:
        return None, str(error)
    return found, ""


def _blame(analysis: Analysis, family: Family) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Joints of the smallest dependent sets special to the witness, and those sets in words."""
    robot, task = analysis.robot, analysis.task
    if robot.n > LARGEST_CHAIN:
        return (), ()
    nullity = robot.n - analysis.generic_rank + family.corank
    found = make_all(circuits_at(robot, family.witness, task), robot.n, nullity)
    smallest = blame(robot, family.witness, task)
    numbers = sorted({number for circuit in smallest for number in circuit.numbers})
    return tuple(numbers), tuple(circuit.words for circuit in found)
