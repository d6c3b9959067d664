"""One verb for one configuration: is it singular, which singularity, what is lost, who is to blame, how to get out."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from rankdrop.configuration import configuration_at
from rankdrop.errors import OptionError
from rankdrop.kinematics import check_robot, one_configuration
from rankdrop.local.pointing import asked_task
from rankdrop.options import takes
from rankdrop.questions import ExplainOptions
from rankdrop.results.analysis import Analysis
from rankdrop.results.explanation import Explanation
from rankdrop.results.known import known_families
from rankdrop.robot.model import Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances

LARGEST_TOLERANCE = 1e-3
"""A singular value above this is not zero by any measure of rounding [1]."""


@takes(ExplainOptions)
def explain(
    robot: Robot,
    q: ArrayLike,
    task: str | Task | None = None,
    options: ExplainOptions | None = None,
    *,
    analysis: Analysis | None = None,
    length_scale: float | None = None,
    tolerances: Tolerances = DEFAULT,
    **given: Any,
) -> Explanation:
    """Explain one configuration: at, near, or far from a singularity.

    Verdicts: *singular*, the rank is below the generic one (σ_r ≤ `tolerances.singular`); *near*, a singular
    configuration was found within `near`, or σ_r ≤ `small` (a near miss, where none was found), or some straight motion
    of the tool is slower than `speed` or `turn_speed` with every joint at its rate limit; *always-singular*, the arm is
    deficient for the task at every configuration and not more so here; else *regular*.

    Every part is worked out when it is first asked for, printed or written, and kept; it is the same whenever that is.

    Families come from `analysis`, else from the atlas shipped with the package where the arm is in it, else they are
    found on the spot from points around q.

    Args:
        robot: the arm.
        q: (n,) the configuration [rad, m].
        task: name, rows or Task; None is the task the arm is made for, or, of an arm of five joints that cannot do a
            pose, position and tool axis.
        options: thresholds, budgets, speeds and axes; or its fields as keywords.
        analysis: families of this arm and task, from `analyze`.
        length_scale: translation rows are divided by it [m]; None is that of the task, else the arm's reach.
        tolerances: thresholds, recorded in the result.
        given: fields of the options.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: a threshold outside what is allowed, or an analysis of another arm or task.
        TaskError: the task does not exist.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = explain(open_robot("puma560"), [0.3, 0.5, 0.4, 0.2, 0.0, 0.6])
        >>> found.verdict, found.met[0].family.name, [joint.number for joint in found.escape.single if joint.order]
        ('singular', 'wrist: axes 4 and 6 aligned', [5])
    """
    check_robot(robot)
    configuration = one_configuration(robot, q)
    configuration.flags.writeable = False
    how = ExplainOptions.of(options, given)
    if not 0.0 < tolerances.singular <= LARGEST_TOLERANCE:
        raise OptionError(
            "this is no tolerance for singular values", where="tolerance", got=tolerances.singular,
            allowed=f"above 0, up to {LARGEST_TOLERANCE:g}", mend="to report small ones, raise `near` or `small`",
            typed="to report small ones, raise --near",
        )  # fmt: skip
    resolved = resolve_task(task, robot, length_scale=length_scale)
    if task is None and analysis is None:
        resolved = asked_task(robot, resolved)
    families, source = known_families(robot, resolved, analysis, tolerances)
    here = configuration_at(robot, configuration, resolved, tolerances)
    here.check_moves()
    return Explanation(here, families, source, how)
