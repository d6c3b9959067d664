"""`rankdrop aspects`: can the arm change its posture without a singularity, and how?"""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, OUTPUT, ArmOptions, Output, command, open_arm, parse_configuration
from rankdrop.cli.terminal import check_targets, hand_over, print_sections, reporter, say, write_json, write_text
from rankdrop.motion import AspectsOptions


@command
def aspects(
    robot: str,
    /,
    *,
    q: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    search: AspectsOptions = AspectsOptions(),
    path: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    output: Output = OUTPUT,
) -> int:
    """Find changes of posture without a singularity.

    An aspect is a connected set of regular configurations. The inverse of a pose
    is solved, and its solutions are sorted by aspect. Cuspidal: two lie in one,
    shown by a path between them that is proven free. Not cuspidal: proven from
    the arm's structure, or because no three solutions meet anywhere.

    For example:
        rankdrop aspects crx10ia
        rankdrop aspects crx10ia --deg --q 10,50,20,-30,50,0 --path change.csv
        rankdrop path crx10ia change.csv

    Exit code 0: a path was found, or it is proven that there is none; 3: no
    change of posture was found, which is no proof; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        q: A configuration whose pose is solved: one number per joint [rad, m]. Default: poses of random ones.
        deg: Angles without a unit are in degrees, and so are those printed.
        path: Write the path to this file (.csv), as `rankdrop path` reads it; - writes it to stdout.
    """
    from rankdrop.motion import NOT_FOUND, aspects_of

    check_targets({"--json": output.json, "--path": path}, {"--path": (".csv",)})
    model, task = open_arm(robot, arm)
    start = None if q is None else parse_configuration(q, model, deg=deg)
    with reporter(quiet=output.quiet) as report:
        found = aspects_of(
            model, task, q=start, options=search,
            progress=lambda done, total: report("poses solved", done, total),
        )  # fmt: skip
    csv = found.path_csv()
    hand_over(
        lambda: print_sections(found.sections(deg=deg)),
        (path if csv else None, lambda target: write_text(csv, target)),
        (output.json, lambda target: write_json(found.to_dict(), target)),
    )
    if path is not None and not csv:
        say(f"{path} is not written: there is no path")
    if not found.complete:
        return exits.INTERRUPTED
    return exits.UNEXPLAINED if found.verdict == NOT_FOUND else exits.FINE
