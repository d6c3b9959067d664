"""`rankdrop through`: can a tool path through a singular configuration be tracked, and with which time law?"""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import (
    NO_OPTIONS,
    OUTPUT,
    ROBOT,
    ArmOptions,
    Output,
    Q,
    command,
    numbers_of,
    open_arm,
    parse_configuration,
)
from rankdrop.cli.terminal import check_targets, hand_over, print_sections, say, write_json, write_text


@command
def through(
    robot: ROBOT,
    /,
    *,
    q: Q,
    along: Annotated[str, Parameter(
        help="Direction of the path: one number per row of the task, in the base's axes [m, rad].",
        allow_leading_hyphen=True,
    )],
    bend: Annotated[str | None, Parameter(
        help="How the direction changes along the path, d²x/ds², likewise. Default: a straight path.",
        allow_leading_hyphen=True,
    )] = None,
    deg: Annotated[
        bool, Parameter(negative=(), help="Angles without a unit are in degrees, and so are those printed.")
    ] = False,
    path: Annotated[str | None, Parameter(
        help="Write the motion with its times to this file (.csv); - writes it to stdout.", allow_leading_hyphen=True
    )] = None,
    arm: ArmOptions = NO_OPTIONS,
    output: Output = OUTPUT,
) -> int:  # fmt: skip
    """Check whether a path through a singularity can be tracked.

    A path in the lost direction may still lead through: with a time law s = c t^k that stands still at the singularity
    for an instant, joint rates stay finite. Others reach it from one side only. The joints are followed on the path
    itself.

    For example:
        rankdrop through planar2r --deg --q 0,180 --along 0,1
        rankdrop through puma560 --q 0.1,0.5,0.4,0.2,0,0.6 --along 1,0,0,0,0,0

    Exit code 0: trackable; 3: not, or undecided; 2: bad input.
    """
    from rankdrop.motion import through as judge

    check_targets({"--json": output.json, "--path": path}, {"--path": (".csv",)})
    model, task = open_arm(robot, arm)
    at = parse_configuration(q, model, deg=deg)
    direction = numbers_of(along, "--along")
    found = judge(model, at, direction, task, bend=None if bend is None else numbers_of(bend, "--bend"))
    csv = found.path_csv()
    hand_over(
        lambda: print_sections(found.sections(deg=deg)),
        (path if csv else None, lambda target: write_text(csv, target)),
        (output.json, lambda target: write_json(found.to_dict(), target)),
    )
    if path is not None and not csv:
        say(f"{path} is not written: there is no motion")
    return exits.FINE if found.trackable else exits.UNEXPLAINED
