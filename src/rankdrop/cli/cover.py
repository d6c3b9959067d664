"""`rankdrop cover`: boxes that hold every singular configuration, and whether known families explain all of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Whole, command, open_arm
from rankdrop.cli.certificates import save_certificate
from rankdrop.cli.terminal import (
    STDOUT,
    check_targets,
    hand_over,
    print_sections,
    reporter,
    say,
    write_json,
    write_text,
)
from rankdrop.errors import OptionError, RobotError

if TYPE_CHECKING:
    from rankdrop.results import Covered


@command
def cover(
    robot: str | None = None,
    /,
    *,
    width: str = "0.05",
    corank: Whole = 1,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    explain: bool = True,
    analysis: str | None = None,
    budget: Whole = 100_000_000,
    threads: Whole = 0,
    scheduler: str | None = None,
    out: str | None = None,
    status: str | None = None,
    certificate: str | None = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Enclose all singular configurations in boxes.

    Every box that is left out is proven free. What is left is held against the
    families that are known: a box that none of them explains is a place to look
    at. Where there is none, nothing else exists down to the width, and only
    then the output says so.

    For example:
        rankdrop cover ur5
        rankdrop cover puma560 --width 0.1 --limits
        rankdrop cover my_arm.urdf --out my_arm.cover --json my_arm.json
        rankdrop cover iiwa7 --width 0.4
        rankdrop cover ur5 --corank 2
        rankdrop cover --status my_arm.cover

    Exit code 0: complete, and all is explained; 3: some boxes are not, or the
    budget is spent; 130: interrupted, with --out the same command goes on; 2: bad
    input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        width: Of the boxes, at most [rad; slides divided by the length scale]; 3deg is understood.
        corank: The boxes hold every configuration of this corank or more; above 1 every arm takes enclosures.
        limits: Within the joint limits only.
        explain: Hold the boxes against families.
        analysis: Families from this file (`rankdrop analyze --json`); else from the catalogue, else found here.
        budget: Enclosures after which no further part is begun; about 1.5 microseconds each. Arms of six turning joints
            need none for corank 1.
        threads: Processors to use; 0 means all. The result does not depend on it.
        scheduler: Address of a Dask scheduler, whose workers make the parts (tcp://HOST:8786).
        out: Keep the boxes in this file; finished parts are in the folder FILE.parts meanwhile.
        status: Only say how far the covering of this file is.
        certificate: Write a certificate to this file, for `rankdrop verify`; it refers to the file of --out, which must
            be in the same folder.
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        quiet: No progress.
    """
    from rankdrop.results import Analysis
    from rankdrop.verbs import cover as covered
    from rankdrop.verbs import how_far

    if status is not None:
        write_text(f"{how_far(status)}\n", STDOUT)
        return exits.FINE
    if robot is None:
        raise OptionError("no arm is named", where="ROBOT", allowed="a name, a file, or --status FILE")
    check_targets({"--json": json, "--out": out, "--certificate": certificate})
    _check_certificate(certificate, out)
    _check_out(out)
    model, task = open_arm(robot, arm)
    families = None if analysis is None else Analysis.load(analysis)
    with reporter(quiet=quiet) as report:
        result = covered(
            model, task, width=_angle(width), corank=corank, limits=limits, explain=explain, analysis=families,
            out=out, budget=budget, threads=threads, scheduler=scheduler, report=report,
        )  # fmt: skip
    proven = None if certificate is None or out is None or not result.complete else _proven(result, out)
    hand_over(
        lambda: _print(result),
        (json, lambda target: write_json(result.to_dict(), target)),
        (certificate, lambda target: save_certificate(proven, target)),
    )
    return _code(result, out)


def _check_out(out: str | None) -> None:

    if out == STDOUT:
        raise OptionError("a covering is not printed", where="--out", got=out, allowed="a file name")


def _check_certificate(certificate: str | None, out: str | None) -> None:


    if certificate is None:
        return
    if out is None or Path(out).resolve().parent != Path(certificate).resolve().parent:
        raise OptionError("a certificate of a covering refers to its file", where="--certificate", got=certificate,
                          mend="name the covering with --out, in the same folder")  # fmt: skip


def _proven(result: Covered, out: str) -> dict[str, Any]:

    from rankdrop.certify import covering_certificate

    return covering_certificate(result.robot, result.covering.plan, result.sha256, Path(out).name, result.task)


def _angle(text: str) -> float:
    from rankdrop.robot import quantity

    try:
        return quantity(text, "angle", where="--width")
    except RobotError as error:
        raise OptionError(error.what, where=error.where, got=error.got, allowed=error.allowed) from error


def _print(result: Covered) -> None:

    print_sections(result.sections())


def _code(result: Covered, out: str | None) -> int:

    if result.complete:
        return exits.FINE if result.holds else exits.UNEXPLAINED
    if result.covering.stopped == "interrupted":
        kept = f"what is done is kept in {out}.parts: the same command goes on there" if out else "--out keeps it"
        say(f"interrupted: {kept}")
        return exits.INTERRUPTED
    return exits.UNEXPLAINED
