"""`rankdrop verify`: does the claim of a certificate hold, and is it the claim that was asked about?"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Output, command, open_arm, parse_configuration
from rankdrop.cli.terminal import check_targets, hand_over, print_sections, reporter, write_json
from rankdrop.errors import OptionError
from rankdrop.options import option


@dataclass(frozen=True)
class VerifyOptions(Output):
    """What the certificate must be about, and how it is checked."""

    TITLE = "The claim and its check"
    robot: Annotated[
        str | None, option("This arm: name or file, with --task, --length-scale and so on; else the arm of the file")
    ] = None
    q: Annotated[
        str | None, option("This configuration [rad, m], of a ball or a singular configuration; needs --robot")
    ] = None
    path: Annotated[str | None, option("This file of a path: its hash, and with --robot its rows")] = None
    deg: Annotated[bool, option("Angles of --q and of --path are in degrees")] = False
    limits: Annotated[
        bool | None, option("The joint limits (--limits) or the whole joint space (--no-limits), of a covering")
    ] = None
    enclosures: Annotated[int, option("Enclosures that the check may make, about a millisecond each")] = 500_000
    sample: (
        Annotated[
            int,
            option("Of a covering, check so many free boxes only, chosen at random: quick, but never exit code 0"),
        ]
        | None
    ) = None
    everything: Annotated[
        bool, option("Of a covering, check all free boxes, whatever --enclosures allows; those of six turning joints "
                     "need a minute or two and no --all", name="--all")
    ] = False  # fmt: skip
    journal: Annotated[
        str | None, option("Of a covering, keep in this file how many boxes are proven: after an interruption the same "
                           "command continues there. Take none from others: it is believed")
    ] = None  # fmt: skip


@command
def verify(
    file: Annotated[str, Parameter(help="A certificate.")],
    /,
    *,
    arm: ArmOptions = NO_OPTIONS,
    output: VerifyOptions = VerifyOptions(),
) -> int:
    """Check a certificate: prove its claim again.

    Code that shares nothing with what made it, by interval arithmetic, on the
    arm's numbers in the file; the whole claim is printed.
    nearest, explain, path and cover write certificates with --certificate. The
    claim is compared with --robot, --task, --q, --path and --limits; what is not
    named is printed, and yours to compare.

    For example:
        rankdrop nearest ur5 --deg --q 0,-135,45,90,-90,0 --certificate here.json
        rankdrop verify here.json
        rankdrop verify here.json --robot ur5 --task pose --deg --q 0,-135,45,90,-90,0
        rankdrop verify pick.json --robot ur5e --path pick.csv --deg
        rankdrop verify boxes.json --journal boxes.checked
        rankdrop verify boxes.json --sample 1000

    Exit code 0: the claim holds; 3: it does not, could not be confirmed, or is
    another claim, with the reason; 2: no certificate, or a malformed one.
    """
    from rankdrop.certify import verify as check

    check_targets({"--json": output.json})
    asked = _asked(output, arm)
    with reporter(quiet=output.quiet) as report:
        found = check(
            file, asked, enclosures=output.enclosures, sample=output.sample, every=output.everything,
            journal=output.journal,
            progress=lambda done, total: report("checked", done, total),
        )  # fmt: skip
    hand_over(
        lambda: print_sections(found.sections()),
        (output.json, lambda target: write_json(found.to_dict(), target)),
    )
    if not found.complete:
        return exits.INTERRUPTED
    return exits.FINE if found.holds else exits.UNEXPLAINED


def _asked(about: VerifyOptions, arm: ArmOptions) -> Any:
    """What the claim is compared with, as `rankdrop.certify.asked_about` gives it."""

    from rankdrop.certify import asked_about
    from rankdrop.motion import holds_poses, read_trajectory

    if about.robot is None:
        for option, value in (("--q", about.q), ("--task", arm.task), ("--length-scale", arm.length_scale)):
            if value is not None:
                raise OptionError("this is compared for an arm", where=option, got=value, mend="name it with --robot")
        return asked_about(None, path=about.path, limits=about.limits)
    model, task = open_arm(about.robot, arm)
    q = None if about.q is None else parse_configuration(about.q, model, deg=about.deg)
    rows = None
    if about.path is not None and not holds_poses(Path(about.path), model):
        rows = read_trajectory(Path(about.path), model, deg=about.deg).q
    stated = task if arm.task is not None or arm.length_scale is not None else None
    return asked_about(model, stated, q=q, path=about.path, rows=rows, limits=about.limits)
