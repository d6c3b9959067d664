"""`rankdrop verify`: does the claim of a certificate hold, and is it the claim that was asked about?"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Whole, command, open_arm, parse_configuration
from rankdrop.cli.terminal import check_targets, hand_over, print_sections, reporter, write_json
from rankdrop.errors import OptionError

if TYPE_CHECKING:
    from rankdrop.certify import Verified


@Parameter(name="*", group="The claim must be about")
@dataclass(frozen=True, slots=True)
class AboutOptions:
    """What the certificate must be about.

    Attributes:
        robot: This arm: name or file, with --task, --length-scale and so on. Default: the arm whose numbers are in it.
        q: This configuration [rad, m], of a ball or a singular configuration; needs --robot.
        path: This file of a path: its hash, and with --robot its rows.
        deg: Angles of --q and of --path are in degrees.
        limits: The joint limits (--limits) or the whole joint space (--no-limits), of a covering.
    """

    robot: str | None = None
    q: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    path: str | None = None
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False
    limits: bool | None = None


ANYTHING = AboutOptions()


@command
def verify(
    file: str,
    /,
    *,
    about: AboutOptions = ANYTHING,
    arm: ArmOptions = NO_OPTIONS,
    enclosures: Whole = 500_000,
    sample: Whole | None = None,
    everything: Annotated[bool, Parameter(name="--all", negative=(), show_default=False)] = False,
    journal: str | None = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
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

    Args:
        file: A certificate.
        enclosures: Enclosures that the check may make, about a millisecond each.
        sample: Of a covering, check so many free boxes only, chosen at random: quick, but never exit code 0.
        everything: Of a covering, check all free boxes, whatever --enclosures allows. Those of six turning joints need
            a minute or two and no --all; of other arms a box takes milliseconds, and the time is printed first.
        journal: Of a covering, keep in this file how many boxes are proven; after Ctrl-C, or a kill, the same command
            continues there. Take none from others: it is believed.
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        quiet: No progress.
    """
    from rankdrop.certify import verify as check

    check_targets({"--json": json})
    asked = _asked(about, arm)
    with reporter(quiet=quiet) as report:
        found = check(
            file, asked, enclosures=enclosures, sample=sample, every=everything, journal=journal,
            progress=lambda done, total: report("checked", done, total),
        )  # fmt: skip
    hand_over(lambda: _print(found), (json, lambda target: write_json(found.to_dict(), target)))
    if not found.complete:
        return exits.INTERRUPTED
    return exits.FINE if found.holds else exits.UNEXPLAINED


def _asked(about: AboutOptions, arm: ArmOptions) -> Any:
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


def _print(verified: Verified) -> None:

    print_sections(verified.sections())
