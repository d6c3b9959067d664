"""What an arm does where an ideal arm near it is singular.

Of an arm whose axes nearly meet, the families of the ideal arm (`rankdrop.robot.ideal`) are places at which σ is small
and mostly not zero. At random points of each family: how large the singular values are that vanish for the ideal arm,
and how far the arm's own nearest singular configuration is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.families.record import Family
from rankdrop.families.rescaling import rescale_equation, slides_of
from rankdrop.formula.equation import System
from rankdrop.local.block import generic_rank, sample, singular_values
from rankdrop.local.nearest import nearest_singularity
from rankdrop.problem import Problem, wrap_joints
from rankdrop.results.explanation import Explanation
from rankdrop.results.ideal_vs_actual import Here, Idealised, Nearby, Spread
from rankdrop.robot.ideal import Tolerance, ideal_name
from rankdrop.robot.ideal import ideal as ideal_of
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.square_up import largest_changes
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_metres, into_metres, metre_exponent, task_in_metres

POINTS = 200
"""Of each family, at most: σ is known to a few percent by then."""
SEARCHED = 20
"""Of them whose nearest singular configuration is looked for: some milliseconds each."""
_STARTS = 32  # of each of these searches: q itself is nearly singular, and most of them end there


def idealised(robot: Robot, tolerance: Tolerance) -> Idealised:
    """The nearest arm of exact structure, with a note that says what it is.

    Raises:
        OptionError: the tolerance is outside what is allowed.

    Example:
        >>> from rankdrop.robot.ideal import read_tolerance
        >>> from rankdrop.robot.open import open_robot
        >>> idealised(open_robot("gen3"), read_tolerance("13mm")).moved
        'not the arm itself but the ideal one within 13mm: 3 lengths moved, at most 12.8 mm'
    """
    ideal, changes = ideal_of(robot, length=tolerance.length, angle=tolerance.angle)
    if changes:
        turned, moved = largest_changes(changes)
        note = RobotNote(NoteOn.IDEAL, within=tolerance.text, turned=turned, moved=moved)
        ideal = replace(ideal, name=ideal_name(robot), notes=(*ideal.notes, note))
    return Idealised(robot, ideal, tolerance, changes)


def nearby(arm: Idealised, task: Task, families: Sequence[Family], *, seed: int = 0) -> tuple[Nearby, ...]:
    """What the arm itself does on each family of the ideal one; some seconds at most.

    Args:
        arm: from `idealised`.
        task: of both.
        families: of the ideal arm, for this task; one without equations is looked at where its witness is.
        seed: of every random choice.

    Example:
        >>> from rankdrop.verbs.analyze import analyze
        >>> from rankdrop.robot.ideal import read_tolerance
        >>> from rankdrop.robot.open import open_robot
        >>> arm = idealised(open_robot("gen3_6dof"), read_tolerance("1.1mm"))
        >>> found = analyze(arm.ideal, starts=300, exact="off")
        >>> [(near.id, near.sigma.median < 1e-3) for near in nearby(arm, found.task, found.of_corank(1))]
        [('k1.f1', True), ('k1.f2', True), ('k1.f3', True)]
    """
    plain_task = task_in_metres(replace(task, length_scale=task.scale(arm.ideal)), arm.ideal)
    real, model = in_metres(arm.real), in_metres(arm.ideal)
    rank = generic_rank(model, plain_task)
    return tuple(
        _nearby(real, plain_task, rank, family, _points(arm.ideal, model, plain_task, family, seed), seed)
        for family in families
    )


def _points(given: Robot, model: Robot, task: Task, family: Family, seed: int) -> Array:
    """(≤ POINTS, n) random configurations of `model`, the arm in metres, on a family of the arm as given."""
    power = -metre_exponent(given)
    equations = tuple(rescale_equation(equation, slides_of(given), power) for equation in family.equations)
    points = np.empty((0, model.n))
    if equations:
        q, solved = System(equations).solve(sample(model, task, POINTS, seed))
        q = wrap_joints(model, q[solved])
        points = q[Problem(model, task, family.corank).singular(q)]
    if len(points):
        return points
    return into_metres(given, [family.witness])


def _nearby(real: Robot, task: Task, rank: int, family: Family, q: Array, seed: int) -> Nearby:
    kept = rank - family.corank
    sigma = singular_values(real, q, task)[:, kept]
    searched = min(SEARCHED, len(q))
    nearest = [nearest_singularity(real, start, task, starts=_STARTS, seed=seed) for start in q[:searched]]
    away = [end.distance for end in nearest if end is not None]
    return Nearby(
        id=family.id, name=family.name, corank=family.corank, points=len(q), number=kept + 1, sigma=_spread(sigma),
        singular=int((sigma <= DEFAULT.singular).sum()), searched=searched, distance=_spread(away) if away else None,
    )  # fmt: skip


def _spread(values: ArrayLike) -> Spread:
    x = np.asarray(values)
    return Spread(float(x.min()), float(np.median(x)), float(x.max()))


def ideal_vs_actual_at(arm: Idealised, explanation: Explanation) -> Here:
    """The arm itself at the configuration explained, and where the ideal arm is singular next to it.

    Args:
        arm: from `idealised`.
        explanation: the explanation of `arm.ideal`.
    """
    r, task = explanation.rank.generic_rank, task_in_metres(explanation.task, arm.ideal)
    corank, q, distance = explanation.rank.corank, explanation.q, 0.0
    if not corank and explanation.far.nearest is not None:
        nearest = explanation.far.nearest
        corank, q, distance = nearest.corank, np.array(nearest.q), nearest.distance
    number = max(r - max(corank, 1) + 1, 1)
    rows = into_metres(arm.real, np.stack([explanation.q, q]))
    sigma = singular_values(in_metres(arm.real), rows, task)[:, number - 1]
    if not corank:
        return Here(number, float(sigma[0]), None, None, None)
    return Here(number, float(sigma[0]), distance, tuple(q.tolist()), float(sigma[1]))
