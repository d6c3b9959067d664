"""`rankdrop verify`: does what a certificate claims hold?"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Whole

if TYPE_CHECKING:
    from rankdrop.certify import Verified


def verify(
    file: str,
    /,
    *,
    robot: str | None = None,
    arm: ArmOptions = NO_OPTIONS,
    enclosures: Whole = 500_000,
    sample: Whole | None = None,
    everything: Annotated[bool, Parameter(name="--all", negative=(), show_default=False)] = False,
    journal: str | None = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Check a certificate: prove its claim again.

    Interval arithmetic, rounding included, on the arm's numbers in the file.
    What nearest, explain, path and cover prove, they write with --certificate.

    For example:
        rankdrop nearest ur5 --deg --q 0,-135,45,90,-90,0 --certificate here.json
        rankdrop verify here.json
        rankdrop verify here.json --robot ur5
        rankdrop verify boxes.json --journal boxes.checked
        rankdrop verify boxes.json --sample 1000

    Exit code 0: it holds; 3: it does not, or could not be confirmed, with the
    reason; 2: no certificate, or a malformed one.

    Args:
        file: A certificate.
        robot: The arm it must be about: name or file. Default: the arm whose numbers are in it.
        enclosures: What the check may cost, about a millisecond each.
        sample: Of a covering, look at so many free boxes only, chosen at random: quick, but never exit code 0.
        everything: Of a covering, check all free boxes, whatever --enclosures allows. Those of six turning joints need
            a minute or two and no --all; of other arms a box takes milliseconds, and how long that is, is told first.
        journal: Of a covering, keep in this file how many boxes are proven; after Ctrl-C, or a kill, the same command
            goes on there. Take none from others: it is believed.
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        quiet: No progress.
    """
    from rankdrop.certify import verify as check
    from rankdrop.cli.arm import open_arm
    from rankdrop.cli.terminal import check_targets, hand_over, reporter, write_json

    check_targets({"--json": json})
    model = None if robot is None else open_arm(robot, arm)[0]
    with reporter(quiet=quiet) as report:
        found = check(
            file, model, enclosures=enclosures, sample=sample, every=everything, journal=journal,
            progress=lambda done, total: report("checked", done, total),
        )  # fmt: skip
    hand_over(lambda: _print(found), (json, lambda target: write_json(found.to_dict(), target)))
    if not found.complete:
        return exits.INTERRUPTED
    return exits.FINE if found.holds else exits.UNEXPLAINED


def _print(verified: Verified) -> None:
    from rankdrop.cli.terminal import print_sections

    print_sections(verified.sections())
