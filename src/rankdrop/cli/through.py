"""`rankdrop through`: can a tool path through a singular configuration be tracked, and with which time law?"""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions


def through(
    robot: str,
    /,
    *,
    q: Annotated[str, Parameter(allow_leading_hyphen=True)],
    along: Annotated[str, Parameter(allow_leading_hyphen=True)],
    bend: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    path: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Tell whether a tool path through a singular configuration can be tracked.

    A path in the lost direction may still lead through: with a time law s = c t^k
    that stands still at the singularity for an instant, joint rates stay finite.
    Others reach it from one side only. The joints are followed on the path itself.

    For example:
        rankdrop through planar2r --deg --q 0,180 --along 0,1
        rankdrop through puma560 --q 0.1,0.5,0.4,0.2,0,0.6 --along 1,0,0,0,0,0

    Exit code 0: trackable; 3: not, or undecided; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        q: The configuration: one number per joint [rad, m].
        along: Direction of the path: one number per row of the task, in the base's axes [m, rad].
        bend: How the direction changes along the path, d²x/ds², likewise. Default: a straight path.
        deg: Joint angles without a unit are in degrees, and so are those printed.
        path: Write the motion with its times to this file (.csv); - writes it to stdout.
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        quiet: No progress.
    """
    from rankdrop.cli.arm import open_arm, parse_configuration
    from rankdrop.cli.terminal import check_targets, hand_over, print_sections, say, write_json, write_text
    from rankdrop.motion import through as judge

    check_targets({"--json": json, "--path": path}, {"--path": (".csv",)})
    model, task = open_arm(robot, arm)
    at = parse_configuration(q, model, deg=deg)
    direction = _numbers(along, "--along")
    found = judge(model, at, direction, task, bend=None if bend is None else _numbers(bend, "--bend"))
    csv = found.path_csv()
    hand_over(
        lambda: print_sections(found.sections(deg=deg)),
        (path if csv else None, lambda target: write_text(csv, target)),
        (json, lambda target: write_json(found.to_dict(), target)),
    )
    if path is not None and not csv:
        say(f"{path} is not written: there is no motion")
    return exits.FINE if found.trackable else exits.UNEXPLAINED


def _numbers(text: str, option: str) -> list[float]:
    """Numbers separated by commas or blanks.

    Raises:
        OptionError: one of them is none.
    """
    from rankdrop.errors import OptionError

    try:
        return [float(word) for word in text.replace("−", "-").replace(",", " ").split()]
    except ValueError as error:
        raise OptionError("these are not numbers", where=option, got=repr(text), allowed="1,0,0,…") from error
