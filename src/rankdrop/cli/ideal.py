"""The option --ideal, and the line that says that an ideal arm is near."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

if TYPE_CHECKING:
    from rankdrop.cli.arm import ArmOptions
    from rankdrop.results import Verdict
    from rankdrop.robot import Robot
    from rankdrop.task import Task
    from rankdrop.verbs import Idealised

IDEAL = Annotated[str | None, Parameter(allow_leading_hyphen=True, show_default=False)]


def open_ideal(
    name: str, options: ArmOptions, tolerance: str | None, tcp: str | None = None, *, deg: bool = False
) -> tuple[Robot, Task, Idealised | None]:
    """The arm to look at, its task, and how it was made where it is an ideal one.

    Raises:
        RankdropError: as `open_arm`; this is not a tolerance.
    """
    from rankdrop.cli.arm import open_arm
    from rankdrop.robot import read_tolerance
    from rankdrop.verbs import idealised

    given = None if tolerance is None else read_tolerance(tolerance)
    robot, task = open_arm(name, options, tcp, deg=deg)
    if given is None:
        return robot, task, None
    found = idealised(robot, given)
    return found.ideal, task, found


def near_line(robot: Robot, asked: Idealised | None) -> dict[str, str]:
    """The label and the line that says which ideal arm is near and what to type; empty where none is, or it was."""
    from rankdrop.robot import near_ideal

    found = near_ideal(robot) if asked is None else None
    return {} if found is None else {"near": found.line}


def of_ideal(verdict: Verdict, asked: Idealised | None) -> Verdict:
    """A verdict that says that it is about the ideal arm, where it is."""
    from dataclasses import replace

    if asked is None or not asked.changes:
        return verdict
    about = f"All this is said of the ideal arm within {asked.tolerance.text}, not of the arm itself."
    return replace(verdict, sentence=f"{verdict.sentence} {about}")
