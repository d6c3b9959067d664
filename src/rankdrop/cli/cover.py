"""`rankdrop cover`: boxes that hold every singular configuration, and whether known families explain all of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ROBOT, ArmOptions, Output, command, open_arm
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
from rankdrop.errors import OptionError
from rankdrop.options import option
from rankdrop.questions import CoverOptions

if TYPE_CHECKING:
    from rankdrop.results import Covered


@dataclass(frozen=True)
class CoverFiles(Output):
    """Where boxes are made, and where they go."""

    analysis: Annotated[
        str | None, option("Families from this file (`rankdrop analyze --json`); else the catalogue's, else found here")
    ] = None
    scheduler: Annotated[
        str | None, option("Address of a Dask scheduler, whose workers make the parts (tcp://HOST:8786)")
    ] = None
    out: Annotated[
        str | None, option("Keep the boxes in this file; finished parts are in the folder FILE.parts meanwhile")
    ] = None
    status: Annotated[str | None, option("Only say how far the covering of this file is")] = None
    certificate: Annotated[
        str | None, option("Write a certificate for `rankdrop verify`; it refers to the file of --out, in the same "
                           "folder")
    ] = None  # fmt: skip


@command
def cover(
    robot: ROBOT | None = None,
    /,
    *,
    options: CoverOptions = CoverOptions(),
    arm: ArmOptions = NO_OPTIONS,
    output: CoverFiles = CoverFiles(),
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
    """
    from rankdrop.results import Analysis
    from rankdrop.verbs import cover as covered
    from rankdrop.verbs import how_far

    if output.status is not None:
        write_text(f"{how_far(output.status)}\n", STDOUT)
        return exits.FINE
    if robot is None:
        raise OptionError("no arm is named", where="ROBOT", allowed="a name, a file, or --status FILE")
    out, certificate = output.out, output.certificate
    check_targets({"--json": output.json, "--out": out, "--certificate": certificate})
    if out == STDOUT:
        raise OptionError("a covering is not printed", where="--out", got=out, allowed="a file name")
    if certificate is not None and (out is None or Path(out).resolve().parent != Path(certificate).resolve().parent):
        raise OptionError("a certificate of a covering refers to its file", where="--certificate", got=certificate,
                          mend="name the covering with --out, in the same folder")  # fmt: skip
    model, task = open_arm(robot, arm)
    families = None if output.analysis is None else Analysis.load(output.analysis)
    with reporter(quiet=output.quiet) as report:
        result = covered(model, task, options, analysis=families, out=out, scheduler=output.scheduler, report=report)
    proven = None if certificate is None or out is None or not result.complete else _proven(result, out)
    hand_over(
        lambda: print_sections(result.sections()),
        (output.json, lambda target: write_json(result.to_dict(), target)),
        (certificate, lambda target: save_certificate(proven, target)),
    )
    if result.covering.stopped == "interrupted":
        kept = f"what is done is kept in {out}.parts: the same command goes on there" if out else "--out keeps it"
        say(f"interrupted: {kept}")
        return exits.INTERRUPTED
    return exits.FINE if result.complete and result.holds else exits.UNEXPLAINED


def _proven(result: Covered, out: str) -> dict[str, Any]:
    from rankdrop.certify import covering_certificate

    return covering_certificate(result.robot, result.covering.plan, result.sha256, Path(out).name, result.task)
