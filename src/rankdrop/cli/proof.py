"""The commands cover and verify: boxes with every singular configuration, and certificates written and checked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from rankdrop import cover as covers
from rankdrop import path as paths
from rankdrop import results, text, verbs
from rankdrop.cli import exits
from rankdrop.cli.command import PROGRESS, Done, Output, command
from rankdrop.cli.opening import NO_OPTIONS, ROBOT, ArmOptions, open_arm, say_other_task
from rankdrop.cli.targets import kept_work, write_text
from rankdrop.cli.terminal import STDOUT, say
from rankdrop.cli.values import parse_configuration
from rankdrop.errors import OptionError
from rankdrop.options import option
from rankdrop.questions import CoverOptions, PathOptions


@dataclass(frozen=True)
class CoverFiles(Output):
    """Where boxes are made, and where they go."""

    analysis: Annotated[
        str | None, option("Families from this file (`rankdrop analyze --json`); else the catalogue's, else found here")
    ] = None
    scheduler: Annotated[
        str | None, option("Address of a Dask scheduler; its workers make the parts (tcp://HOST:8786)")
    ] = None
    out: Annotated[
        str | None,
        option("Keep the boxes in this file; finished parts are in the folder FILE.parts meanwhile", writes=()),
    ] = None
    status: Annotated[str | None, option("Only say how far the covering of this file is")] = None
    certificate: Annotated[
        str | None, option("Write a certificate for `rankdrop verify`; it refers to the file of --out, in the same "
                           "folder", writes=())
    ] = None  # fmt: skip


@command
def cover(
    robot: ROBOT | None = None,
    /,
    *,
    options: CoverOptions = CoverOptions(),
    arm: ArmOptions = NO_OPTIONS,
    output: CoverFiles = CoverFiles(),
    report: PROGRESS,
) -> Done | int:
    """Enclose all singular configurations in boxes.

    Every box that is left out is proven free. The remaining boxes are compared
    with the known families: a box that none of them explains is a place to look
    at. Without such a box every singular configuration is within a box's diagonal
    of a known family, and only then the output says so.

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
    if output.status is not None:
        write_text(f"{verbs.how_far(output.status)}\n", STDOUT)
        return exits.FINE
    if robot is None:
        raise OptionError("no arm is named", where="ROBOT", allowed="a name, a file, or --status FILE")
    out = output.out
    _check_covering_files(out, output.certificate)
    model, task = open_arm(robot, arm)
    say_other_task(model, task, arm)
    if output.analysis is None:
        families = None
    else:
        families = results.Analysis.load(output.analysis)
    result = verbs.cover(model, task, options, analysis=families, out=out, scheduler=output.scheduler, report=report)
    stopped = result.covering.interrupted

    def proven() -> results.Record | None:
        if out is None or not result.complete:
            return None
        return covers.covering_certificate(model, result.covering.plan, result.sha256, Path(out).name, task)

    return Done(
        result.sections, {"json": result.to_dict, "certificate": proven},
        holds=result.complete and result.holds, complete=not stopped,
        last=partial(say, f"interrupted: {kept_work(f'{out}.parts' if out else None)}") if stopped else None,
    )  # fmt: skip


def _check_covering_files(out: str | None, certificate: str | None) -> None:
    """Refuse a covering on stdout, and a certificate in another folder than its covering.

    Raises:
        OptionError: either.
    """
    if out == STDOUT:
        raise OptionError("a covering is not printed", where="--out", got=out, allowed="a file name")
    if certificate is not None and (out is None or Path(out).resolve().parent != Path(certificate).resolve().parent):
        raise OptionError("a certificate of a covering refers to its file", where="--certificate", got=certificate,
                          mend="name the covering with --out, in the same folder")  # fmt: skip


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
    path: Annotated[
        str | None, option("The file of the path: its curve is compared with every control point; the tip with "
                           "tool poses. Needs --robot")
    ] = None  # fmt: skip
    interpolate: Annotated[
        Literal["linear", "cubic", "quintic"] | None,
        option("What joins the rows of --path; else what the certificate states, which is printed"),
    ] = None
    topic: Annotated[str | None, option("Of a bag in --path: the topic with the joint values")] = None
    tip_tolerance: Annotated[
        float, option("Distance within which the tip is to be proven to stay to the lines of --path", unit="m", ge=1e-8)
    ] = 1e-4
    turn_tolerance: Annotated[
        float, option("Angle within which the tool is to be proven to stay to its turns", unit="rad", ge=1e-8, le=3)
    ] = 1e-4
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
    report: PROGRESS,
) -> Done:
    """Check a certificate: prove its claim again.

    Code that shares nothing with what made it, by interval arithmetic, on the
    arm's numbers in the file; the whole claim is printed.
    nearest, explain, path, cover and aspects write certificates with --certificate. The
    claim is compared with --robot, --task (without it the arm's default), --q,
    --path and --limits; the rest is printed: compare it yourself. A
    path holds for the file of --path alone.

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
    verified = covers.verify(
        file, _claim(output, arm), enclosures=output.enclosures, sample=output.sample, every=output.everything,
        journal=output.journal, progress=partial(report, "checked"),
    )  # fmt: skip
    return Done(verified.sections, {"json": verified.to_dict}, holds=verified.holds, complete=verified.complete)


def _claim(about: VerifyOptions, arm: ArmOptions) -> Any:
    """What the certificate has to be about."""
    if about.robot is None:
        for option, value in (("--q", about.q), ("--path", about.path), ("--task", arm.task),
                              ("--length-scale", arm.length_scale)):  # fmt: skip
            if value is not None:
                raise OptionError("this is compared for an arm", where=option, got=value, mend="name it with --robot")
        return covers.asked_about(None, limits=about.limits)
    model, task = open_arm(about.robot, arm)
    if about.q is None:
        q = None
    else:
        q = parse_configuration(about.q, model, deg=about.deg)
    path = None
    if about.path is not None:
        near = PathOptions(tip_tolerance=about.tip_tolerance, turn_tolerance=about.turn_tolerance)
        path = paths.path_asked(model, about.path, near, deg=about.deg, topic=about.topic,
                                 interpolate=about.interpolate)  # fmt: skip
    return covers.asked_about(model, task, q=q, path=path, limits=about.limits)


def of_place(
    explanation: results.Explanation, tolerance: covers.ModelTolerance | None, evaluations: int
) -> results.Record:
    """What can be proven at a configuration: that a singular one exists there, or a ball without any.

    Raises:
        OptionError: nothing can.
    """
    place = (explanation.robot, explanation.q, explanation.task)
    if explanation.rank.corank and tolerance is None:
        return covers.existence_certificate(*place)
    return covers.ball_certificate(*place, tolerance=tolerance, evaluations=max(evaluations, 1))


def in_words(record: results.Record) -> str:
    """One line: what the certificate claims."""
    claim, near = record["claim"], record["tolerance"]
    if record["kind"] == "existence":
        return f"a singular configuration exists within {claim['radius']:.1g} of q, joint by joint"
    free = f"no singularity within {text.angle_below(claim['radius'])}"
    if near is None:
        return free
    return f"{free}, for every arm within {near['length'] * 1e3:g} mm and {near['angle'] * 1e3:g} mrad, joint by joint"
