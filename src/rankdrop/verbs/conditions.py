"""One verb: the singularity conditions of an arm, exactly: those shipped, or derived anew (`verbs/deriving.py`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from rankdrop.errors import OptionError
from rankdrop.kinematics import LARGEST_SEED, check_robot, whole_number
from rankdrop.results.conditions import Conditions, ConditionSettings
from rankdrop.results.known import known_conditions
from rankdrop.robot.model import Robot
from rankdrop.task import Task
from rankdrop.version import VERSION

Progress = Callable[[str, int, int], None]
"""progress(label, done, total), label such as "sets looked into"."""
POINTS = 1000
"""Singular configurations found numerically that the families have to explain."""
MOST_POINTS = 100_000
"""More of them take longer than any derivation."""
_PLAIN = ("auto", "auto", None, 0, POINTS, False)  # what the shipped conditions answer


def conditions(
    robot: Robot,
    task: str | Task | None = None,
    *,
    method: str = "auto",
    lengths: str | Mapping[str, float] = "auto",
    coranks: int | None = None,
    seconds: float = 60.0,
    seed: int = 0,
    points: int = POINTS,
    special: bool = False,
    steps: bool = False,
    basic: Sequence[int] | None = None,
    frame: int | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> Conditions:
    """Derive the singularity conditions of an arm exactly, and check them.

    The Jacobian is written over the rational numbers in half-angle tangents, sines and cosines, and lengths. Its rank
    drops on closed sets; each is taken apart into irreducible ones, and those without real points are left out. Every
    family is checked twice, by means that know nothing of the derivation: the rank modulo a prime at random points of
    it, and `points` singular configurations found numerically, which all have to lie on one.

    Args:
        robot: revolute and prismatic joints, each a variable of its own.
        task: as in `resolve_task`; None is the one the arm is made for.
        method: for corank 1: "auto", or one of `METHODS`; the result says what was chosen and why. All give the same
            set. Every corank above comes from the rank tree.
        lengths: "auto", "letters", "numbers" or letters with values, see `exact_chain`.
        coranks: the highest corank to derive; None for all.
        seconds: limit on the processor's time. A third of it is the limit on the work done, counted in steps, so that
            the result does not depend on how fast the machine is unless time is what ends it, which is told; how busy
            it is never counts. What was derived by then is returned, and what is left is told. So it is after Ctrl-C.
        seed: of every random choice.
        points: how many singular configurations of corank 1 to try; a tenth for each corank above; 0 for none.
        steps: also write the derivation of corank 1 down, step by step as it is done by hand, and the determinant of
            the Jacobian, or the minors that take its place, in factors.
        basic, frame: with the methods "suppression" and "reciprocity": numbers of the six basic screws, and link in
            whose frame the screws are taken; None for the rules of the method, which steps give the reasons of.
        special: also derive the arms whose lengths break an assumption, which takes as long as the derivation
            itself; else the assumptions are listed alone. Shipped conditions have these arms.
        fresh: derive them even where the conditions of this arm are shipped with rankdrop. Those answer the question
            with all its defaults (but for the time limit), and are what a derivation gives.
        progress: called as progress(label, done, total).

    Returns:
        Conditions.

    Raises:
        RobotError: not a Robot, a helical joint, or a joint that follows another one.
        TaskError: the task does not exist.
        OptionError: an option outside what is allowed.
        MissingExtraError: python-flint is not installed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> [family.texts for family in conditions(open_robot("scara"), points=0).families]
        [('θ2 = 0 or π',)]
    """
    check_robot(robot)
    _check(coranks, seconds, points, seed)
    asked = ConditionSettings(
        method=method, lengths=lengths if isinstance(lengths, str) else dict(lengths), coranks=coranks,
        seconds=seconds, seed=seed, points=points, special=special, steps=steps, version=VERSION,
        basic=None if basic is None else tuple(sorted(int(j) for j in basic)), frame=frame,
    )  # fmt: skip
    plain = (method, lengths, coranks, seed, points, steps) == _PLAIN
    if plain and basic is None and frame is None and not fresh:
        anew = partial(conditions, robot, task, points=0, special=False, fresh=True)
        shipped = known_conditions(robot, task, anew=anew)
        if shipped is not None:
            return replace(shipped, settings=replace(shipped.settings, seconds=seconds))
    from rankdrop.verbs.deriving import derived  # what is shipped does without all that derives

    return derived(robot, task, asked, progress)


def _check(coranks: int | None, seconds: float, points: int, seed: int) -> None:
    if coranks is not None and coranks < 1:
        raise OptionError("the highest corank is at least 1", where="coranks", got=coranks)
    if not seconds > 0:
        raise OptionError("the time limit is positive", where="seconds", got=seconds)
    if not 0 <= points <= MOST_POINTS:
        raise OptionError("points is outside the range", got=points, allowed=f"0 … {MOST_POINTS}")
    whole_number("seed", seed, 0, LARGEST_SEED)
