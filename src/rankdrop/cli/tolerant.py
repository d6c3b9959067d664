"""`rankdrop tolerant`: the configurations that tolerate the failure of any one joint best."""

from __future__ import annotations

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, OUTPUT, ROBOT, ArmOptions, Output, arm_section, command, open_arm
from rankdrop.cli.terminal import check_targets, hand_over, print_sections, reporter, results, show, write_json
from rankdrop.questions import TolerantOptions


@command
def tolerant(
    robot: ROBOT,
    /,
    *,
    options: TolerantOptions = TolerantOptions(),
    arm: ArmOptions = NO_OPTIONS,
    output: Output = OUTPUT,
) -> int:
    """Find configurations that tolerate a failed joint best.

    A joint that fails stands still: its column is gone from the Jacobian. What remains is measured by σ_r, r the rank
    of the whole arm; the worst case over all joints is made as large as it gets. Local maxima of many starts.

    For example:
        rankdrop tolerant panda --limits
        rankdrop tolerant almarkhi4 --relative --length-scale 1

    Exit code 0: a configuration tolerates every single failure; 3: none was found; 2: bad input.
    """
    from rankdrop.codec import record_of
    from rankdrop.families import most_tolerant
    from rankdrop.results import tolerant_sections

    check_targets({"--json": output.json})
    model, task = open_arm(robot, arm)
    with reporter(quiet=output.quiet) as report:
        found = most_tolerant(model, task, options, progress=lambda done, total: report("climb", done, total))
    where = "within the joint limits" if options.limits else "in the whole joint space (limits ignored)"
    lines = {"starts": f"{options.starts:,} {where}, seed {options.seed}"}

    def to_stdout() -> None:
        show(results(), arm_section(model, task, found.generic_rank, lines))
        print_sections(tolerant_sections(found), first=False)

    hand_over(to_stdout, (output.json, lambda target: write_json(record_of("tolerant", found), target)))
    if not found.complete:
        return exits.INTERRUPTED
    return exits.FINE if found.places else exits.UNEXPLAINED
