"""One verb: the singularity conditions of an arm, exactly: those shipped, or derived anew (`verbs/deriving.py`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from rankdrop.kinematics import check_robot
from rankdrop.options import takes
from rankdrop.questions import ConditionsOptions
from rankdrop.results.conditions import Conditions
from rankdrop.results.stored_conditions import known_conditions
from rankdrop.robot.model import Robot
from rankdrop.robot.quantities import read_joints, read_lengths
from rankdrop.task import Task

Progress = Callable[[str, int, int], None]
"""progress(label, done, total), label such as "sets derived"."""


@takes(ConditionsOptions)
def conditions(
    robot: Robot,
    task: str | Task | None = None,
    options: ConditionsOptions | None = None,
    *,
    progress: Progress | None = None,
    **given: Any,
) -> Conditions:
    """Derive the singularity conditions of an arm exactly, and check them.

    The Jacobian is written over the rational numbers in half-angle tangents, sines and cosines, and lengths. Its rank
    drops on closed sets; each is taken apart into irreducible ones, and those without real points are left out. Every
    family is checked twice, by means that know nothing of the derivation: the rank modulo a prime at random points of
    it, and `points` singular configurations found numerically, which all have to lie on one.

    Args:
        robot: revolute and prismatic joints; a joint that follows another one is of its kind, and turns at a
            whole multiple or a fraction of small numbers.
        task: as in `resolve_task`; None is the one the arm is made for.
        options: method, lengths, coranks, time limit and seed; or its fields as keywords. The time limit is one on the
            work done, counted in steps, so that the result does not depend on how fast the machine is; ten times as
            much processor time ends it in any case. What was derived by then is returned, and so it is after Ctrl-C.
        progress: called as progress(label, done, total).
        given: fields of the options. Shipped conditions answer the question with all its defaults.

    Returns:
        Conditions.

    Raises:
        RobotError: not a Robot, a helical joint, or a joint that follows another one in a way that is not algebraic.
        TaskError: the task does not exist.
        OptionError: an option outside what is allowed.
        MissingExtraError: python-flint is not installed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> [family.texts for family in conditions(open_robot("scara"), points=0).families]
        [('θ2 = 0 or π',)]
    """
    check_robot(robot)
    how = ConditionsOptions.of(options, given)
    if how == replace(ConditionsOptions(), seconds=how.seconds, special=how.special):
        anew = partial(conditions, robot, task, points=0, special=False, fresh=True)
        shipped = known_conditions(robot, task, anew=anew)
        if shipped is not None:
            return replace(shipped, settings=replace(shipped.settings, seconds=how.seconds))
    from rankdrop.verbs.deriving import derive_conditions  # what is shipped does without all that derives

    if how.basic is None:
        basic = None
    else:
        basic = read_joints(how.basic)
    return derive_conditions(robot, task, replace(how, lengths=read_lengths(how.lengths), basic=basic), progress)
