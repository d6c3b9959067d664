"""`rankdrop monitor`: an arm and its families as a header, for a control loop in C or C++."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ROBOT, ArmOptions, command, open_arm
from rankdrop.cli.terminal import check_target, reporter, write_text
from rankdrop.options import Options, option


@dataclass(frozen=True)
class MonitorOptions(Options):
    """What the header holds."""

    start: Annotated[float, option("Distance at which motion towards a family begins to be slowed", unit="rad")] = 0.2
    stop: Annotated[float, option("Distance at which it is stopped", unit="rad")] = 0.02
    mark: Annotated[str | None, option("Part of the constant's name; else made of the robot's")] = None
    analysis: Annotated[
        str | None, option("Families from this file (rankdrop analyze --json); else those shipped, else computed now")
    ] = None
    starts: Annotated[int, option("Random starts of an analysis that is made now")] = 10_000
    quiet: Annotated[bool, option("No progress")] = False


@command
def monitor(
    robot: ROBOT,
    /,
    *,
    header: Annotated[str, Parameter(help="The file to write; - for stdout.", allow_leading_hyphen=True)],
    options: MonitorOptions = MonitorOptions(),
    arm: ArmOptions = NO_OPTIONS,
) -> int:
    """Write an arm and its families as a C header.

    The header holds one constant, rankdrop_MARK_arm. With rankdrop/monitor.hpp (C++17) or rankdrop/monitor.h (C) it
    reports at every configuration: rank, families with residual, distance and gradient, lost directions, how fast a
    motion may continue, and an internal motion away. No Python is needed there. Where headers and CMake package are:
    python -m rankdrop.headers --cmake-dir.

    For example:
        rankdrop monitor ur5e --header ur5e.h
        rankdrop monitor arm.urdf --tip flange --header arm.h --start 10deg --stop 1deg

    Exit code 0: written; 2: bad input.
    """
    from rankdrop import Monitor, analyze
    from rankdrop.results import Analysis, known_analysis

    check_target(header, "--header")
    model, task = open_arm(robot, arm)
    found = known_analysis(model, task) if options.analysis is None else Analysis.load(options.analysis)
    if found is None:
        with reporter(quiet=options.quiet) as report:
            found = analyze(model, task, starts=options.starts, progress=report)
    watched = Monitor(model, task, found.families, start=options.start, stop=options.stop)
    write_text(watched.header(options.mark), header)
    return exits.FINE
