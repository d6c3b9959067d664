"""One verb for one configuration: is it singular, which singularity, what is lost, who is to blame, how to get out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.certify.ball import check_budget
from rankdrop.errors import OptionError
from rankdrop.kinematics import check_robot, one_configuration
from rankdrop.local.place import check_moves
from rankdrop.local.verdict import rank_at
from rankdrop.local.ways_out import check_step
from rankdrop.results.analysis import Analysis
from rankdrop.results.explanation.data import Asked, ExplainSettings
from rankdrop.results.explanation.explanation import Explanation
from rankdrop.results.explanation.parts import checked_frame, how_far, known_families, straight_motions, verdict_of
from rankdrop.robot.model import Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, EVALUATIONS, NEAR, SLOW, SLOW_TURN, SMALL, Tolerances
from rankdrop.version import VERSION

LARGEST_TOLERANCE = 1e-3
"""A singular value above this is not zero by any measure of rounding [1]."""


def explain(
    robot: Robot,
    q: ArrayLike,
    task: str | Task | None = None,
    *,
    analysis: Analysis | None = None,
    near: float = NEAR,
    small: float = SMALL,
    limits: bool = False,
    evaluations: int = EVALUATIONS,
    step: float = 0.1,
    coranks: int = 1,
    seed: int = 0,
    length_scale: float | None = None,
    tolerances: Tolerances = DEFAULT,
    frame: str | None = None,
    speed: float = SLOW,
    turn_speed: float = SLOW_TURN,
) -> Explanation:
    """Explain one configuration: at, near, or far from a singularity.

    Verdicts: *singular*, the rank is below the generic one (σ_r ≤ `tolerances.singular`); *near*, a singular
    configuration was found within `near`, or σ_r ≤ `small` (a near miss, where none was found), or some straight motion
    of the tool is slower than `speed` or `turn_speed` with every joint at its rate limit; *always-singular*, the arm is
    deficient for the task at every configuration and not more so here; else *regular*.

    Rank, distances and verdict are worked out at once. Every other part, the certified radius too, is worked out when
    it is first asked for, printed or written, and kept; it is the same whenever that is.

    Families come from `analysis`, else from the atlas shipped with the package where the arm is in it, else they are
    found on the spot from points around q.

    Args:
        robot: the arm.
        q: (n,) the configuration [rad, m].
        task: name, rows or Task; None is the task the arm is made for.
        analysis: families of this arm and task, from `analyze`.
        near: distance in joint space [rad; slides divided by the length scale].
        small: σ_r that counts as small [1].
        limits: the nearest singularity within the joint limits.
        evaluations: budget of the certified radius (`certified_radius`).
        step: length of the motions out that are tried [rad; slides in length scales].
        coranks: distances to known families up to this corank; every one of them lies in those of corank 1.
        seed: of every random choice.
        length_scale: translation rows are divided by it [m]; None is that of the task, else the arm's reach.
        tolerances: thresholds, recorded in the result.
        frame: in whose axes lost motions and the cost of motion are told: "base", "tool", or "link", the one in which
            they are simplest; None tells what is lost in all three.
        speed, turn_speed: of straight translations [m/s] and rotations [rad/s] that count as slow; 0 for none.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: a threshold outside what is allowed, or an analysis of another arm or task.
        TaskError: the task does not exist.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = explain(open_robot("puma560"), [0.3, 0.5, 0.4, 0.2, 0.0, 0.6])
        >>> found.verdict, found.met[0].family.name, [one.number for one in found.escape.single if one.order]
        ('singular', 'wrist: axes 4 and 6 aligned', [5])
    """
    check_robot(robot)
    configuration = one_configuration(robot, q)
    configuration.flags.writeable = False
    _check_numbers(near=near, small=small, step=step, speed=speed, turn_speed=turn_speed)
    _check_whole(evaluations=evaluations, seed=seed, coranks=coranks)
    check_budget(evaluations)
    check_step(step)
    if not 0.0 < tolerances.singular <= LARGEST_TOLERANCE:
        raise OptionError(
            "this is no tolerance for singular values", where="tolerance", got=tolerances.singular,
            allowed=f"above 0, up to {LARGEST_TOLERANCE:g}", mend="to be told of small ones, raise `near` or `small`",
            typed="to be told of small ones, raise --near",
        )  # fmt: skip
    resolved = resolve_task(task, robot, length_scale=length_scale)
    families, source = known_families(robot, resolved, analysis, tolerances)
    settings = ExplainSettings(
        near, small, limits, evaluations, step, seed, float(resolved.scale(robot)), tolerances, VERSION,
        checked_frame(frame), speed, turn_speed,
    )  # fmt: skip
    rank = rank_at(robot, configuration, resolved, tolerances)
    check_moves(robot, resolved, rank.generic_rank)
    return _explained(Asked(robot, configuration, resolved, rank, families, source, coranks, settings))


def _explained(asked: Asked) -> Explanation:
    """How far and the verdict; all else when it is asked for, at the configuration or at the singular one near it."""
    far = how_far(asked)
    straight = straight_motions(asked)
    verdict, cause = verdict_of(asked, far, [one for one in straight if one.speed < one.limit])
    return Explanation(asked, verdict, cause, far, straight)


def _check_numbers(**options: float) -> None:
    """Raises OptionError for what is no number from 0 up."""
    for name, value in options.items():
        if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not 0.0 <= value < np.inf:
            raise OptionError("this is a finite number from 0 up", where=name, got=repr(value))


def _check_whole(**options: int) -> None:
    """Raises OptionError for what is no whole number from 0 up."""
    for name, value in options.items():
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 0 <= value < 2**63:
            raise OptionError("this is a whole number from 0 up", where=name, got=repr(value))
