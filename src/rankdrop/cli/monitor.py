"""`rankdrop monitor`: an arm and its families as a header, for a control loop in C or C++."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Whole

if TYPE_CHECKING:
    from rankdrop.cli.terminal import Report
    from rankdrop.results import Analysis
    from rankdrop.robot import Robot
    from rankdrop.task import Task


def monitor(
    robot: str,
    /,
    *,
    header: Annotated[str, Parameter(allow_leading_hyphen=True)],
    start: str = "0.2rad",
    stop: str = "0.02rad",
    mark: str | None = None,
    arm: ArmOptions = NO_OPTIONS,
    analysis: str | None = None,
    starts: Whole = 10_000,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Write an arm and its families as a header that C and C++ read.

    The header holds one constant, rankdrop_MARK_arm. With rankdrop/monitor.hpp
    (C++17) or rankdrop/monitor.h (C) it tells at every configuration: rank,
    families with residual, distance and gradient, lost directions, how fast a
    motion may go on, and an internal motion away. No Python is needed there.
    Where headers and CMake package are: python -m rankdrop.headers --cmake-dir.

    For example:
        rankdrop monitor ur5e --header ur5e.h
        rankdrop monitor arm.urdf --tip flange --header arm.h --start 10deg --stop 1deg

    Exit code 0: written; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        header: The file to write; - for stdout.
        start: Distance at which motion towards a family begins to be slowed.
        stop: Distance at which it is stopped.
        mark: Part of the constant's name; else made of the robot's.
        analysis: Families from this JSON file (rankdrop analyze --json); else those shipped, else found now.
        starts: Random starts of an analysis that is made now.
        quiet: No progress.
    """
    from rankdrop import Monitor
    from rankdrop.cli.arm import open_arm
    from rankdrop.cli.terminal import check_target, reporter, write_text

    check_target(header, "--header")
    model, task = open_arm(robot, arm)
    slow, halt = _angle(start, "--start"), _angle(stop, "--stop")
    with reporter(quiet=quiet) as report:
        found = _analysis(model, task, analysis, starts, report)
    watched = Monitor(model, task, found.families, start=slow, stop=halt)
    write_text(watched.header(mark), header)
    return exits.FINE


def _analysis(robot: Robot, task: Task, file: str | None, starts: int, progress: Report) -> Analysis:
    from rankdrop import analyze
    from rankdrop.results import Analysis, known_analysis

    if file is not None:
        return Analysis.load(file)
    return known_analysis(robot, task) or analyze(robot, task, starts=starts, progress=progress)


def _angle(text: str, option: str) -> float:
    from rankdrop.errors import OptionError, RobotError
    from rankdrop.robot import quantity

    try:
        return quantity(text, "angle", where=option)
    except RobotError as error:
        raise OptionError(error.what, where=error.where, got=error.got, allowed=error.allowed) from error
