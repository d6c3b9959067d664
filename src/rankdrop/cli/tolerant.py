"""`rankdrop tolerant`: the configurations that bear the failure of any one joint best."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Whole


def tolerant(
    robot: str,
    /,
    *,
    arm: ArmOptions = NO_OPTIONS,
    relative: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    starts: Whole = 300,
    seed: Whole = 0,
    show: Whole = 5,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Find the configurations in which the worst single joint failure leaves most.

    A joint that fails stands still: its column is gone from the Jacobian. What
    is left is measured by σ_r, r the rank of the whole arm; the worst case over
    all joints is made as large as it gets. Local maxima of many starts.

    For example:
        rankdrop tolerant panda --limits
        rankdrop tolerant almarkhi4 --relative --length-scale 1

    Exit code 0: a configuration bears every single failure; 3: none was found,
    or there is none; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        relative: Measure σ_r left by σ1 of the whole arm: the most that it can be depends on no configuration.
        limits: Within the joint limits only.
        starts: Random starts.
        seed: Of every random choice; the same seed gives the same result.
        show: How many local maxima to show.
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        quiet: No progress.
    """
    from rankdrop.cli.arm import arm_section, open_arm
    from rankdrop.cli.terminal import check_targets, hand_over, print_sections, reporter, results, write_json
    from rankdrop.cli.terminal import show as show_parts
    from rankdrop.families import most_tolerant
    from rankdrop.results import tolerant_sections, tolerant_to_dict

    check_targets({"--json": json})
    model, task = open_arm(robot, arm)
    with reporter(quiet=quiet) as report:
        found = most_tolerant(
            model, task, relative=relative, limits=limits, starts=starts, seed=seed, show=show,
            progress=lambda done, total: report("climb", done, total),
        )  # fmt: skip
    where = "within the joint limits" if limits else "in the whole joint space (limits ignored)"
    lines = {"starts": f"{starts:,} {where}, seed {seed}"}

    def to_stdout() -> None:
        show_parts(results(), arm_section(model, task, found.generic_rank, lines))
        print_sections(tolerant_sections(found), first=False)

    hand_over(to_stdout, (json, lambda target: write_json(tolerant_to_dict(found), target)))
    if not found.complete:
        return exits.INTERRUPTED
    return exits.FINE if found.places else exits.UNEXPLAINED
