"""`rankdrop path`: does a path reach a singularity, between its samples too, and what would avoid it?"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Output, ToolOptions, command, open_arm, parse_configuration
from rankdrop.cli.proof import model_tolerance, save_certificate
from rankdrop.cli.terminal import (
    STDOUT,
    check_targets,
    hand_over,
    print_sections,
    reporter,
    say,
    write_bytes,
    write_json,
    write_text,
)
from rankdrop.errors import OptionError
from rankdrop.motion import PathOptions, RemedyOptions
from rankdrop.options import Options, option
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.certify import ModelTolerance
    from rankdrop.motion import Mending, PathCheck
    from rankdrop.results import Analysis


@dataclass(frozen=True)
class Input(ToolOptions):
    """How files are read."""

    TITLE = "Input"

    topic: Annotated[
        str | None, option("Of a bag in which several have joint values (JointState, JointTrajectory)")
    ] = None  # fmt: skip
    start: Annotated[
        str | None, option("Configuration near the first pose, which decides the branch of the inverse kinematics. "
                           "Default: of those found, the one nearest to zero")
    ] = None  # fmt: skip
    analysis: Annotated[
        str | None, option("Families from this file (`rankdrop analyze --json`); else from the catalogue")
    ] = None  # fmt: skip


@dataclass(frozen=True)
class Remedies(RemedyOptions):
    """Which remedies are computed."""

    remedies: Annotated[bool, option("Compute changes that avoid singularities, each proven by a new check")] = False
    acceleration: Annotated[
        float, option("Limit of joint accelerations [rad/s², m/s²], for new time laws; arms state none", gt=0)
    ] | None = None  # fmt: skip
    fixed: Annotated[
        str | None, option("Write the first path that is proven free here, or retimed: .csv, .npz, .json")
    ] = None  # fmt: skip

    @property
    def wanted(self) -> bool:
        """Whether any remedy is asked for."""
        return self.remedies or self != NO_REMEDIES


@dataclass(frozen=True)
class ManyFiles(Options):
    """How several files are checked."""

    TITLE = "Many files"

    out: Annotated[
        str | None, option("Folder in which finished files are kept, with a journal; after an interruption of any kind "
                           "run the same command to continue")
    ] = None  # fmt: skip
    workers: Annotated[
        int, option("Local processes; 0: one for every processor. The result does not depend on it", ge=0)
    ] = 0  # fmt: skip
    scheduler: Annotated[
        str | None, option("Address of a Dask scheduler, whose workers see the files under the same names "
                           "(tcp://HOST:8786)")
    ] = None  # fmt: skip
    status: Annotated[str | None, option("Print the progress of the paths kept in this folder, and end")] = None


@dataclass(frozen=True)
class PathOutput(Output):
    """What is printed and written."""

    full: Annotated[bool, option("Print every crossing and every free stretch")] = False
    figure: Annotated[
        str | None, option("Draw distance, singular value and joint rates along the path: .svg, .png or .pdf")
    ] = None  # fmt: skip
    html: Annotated[str | None, option("Write a page that stands alone, with the arm playing the path: .html")] = None
    rows: Annotated[
        str | None, option("Write a table, one line for each row: .parquet, .json or .csv. Units are in the names of "
                           "the columns")
    ] = None  # fmt: skip
    certificate: Annotated[
        str | None, option("Write what is proven to this file, for `rankdrop verify`: the path, its free spans and "
                           "crossings")
    ] = None  # fmt: skip
    model_tolerance: Annotated[
        str | None, option("Prove the path free for every arm so near to this one, joint by joint: 0.3mm,1mrad")
    ] = None  # fmt: skip


PLAIN_CHECK, NO_REMEDIES, PLAIN_INPUT, ONE_FILE, TEXT_ONLY = (
    PathOptions(), Remedies(), Input(), ManyFiles(), PathOutput()
)  # fmt: skip
OF_ONE_PATH = ("figure", "html", "rows", "certificate", "model_tolerance")
"""Outputs of a single path."""


@command
def path(
    robot: str | None = None,
    /,
    *files: str,
    arm: ArmOptions = NO_OPTIONS,
    source: Input = PLAIN_INPUT,
    check: PathOptions = PLAIN_CHECK,
    mend: Remedies = NO_REMEDIES,
    many: ManyFiles = ONE_FILE,
    output: PathOutput = TEXT_ONLY,
) -> int:
    """Check a path for singularities, between its samples too.

    Free, crossing one, touching one, too fast, outside joint limits, or undecided.

    Nothing is sampled: every stretch between two samples is enclosed and halved
    until it is proven free or its crossing is bracketed. Poses of the tip are
    joined by straight moves; the joints are proven to keep the tip on them.
    Several files, or a folder of them, give a table, worst first.

    For example:
        rankdrop path ur5e pick.csv --deg
        rankdrop path panda plan.yaml --interpolate cubic --min-distance 5deg
        rankdrop path ur5e programs/ --json paths.json --out checked
        rankdrop path --status checked
        rankdrop path puma560 weld.npz --figure weld.svg
        rankdrop path ur5e pick.csv --tool-tilt 10deg --fixed mended.csv
        rankdrop path ur10e recorded.mcap --topic /joint_states
        rankdrop path ur5e poses.csv --start "0,-90deg,90deg,0,90deg,0"

    Exit code 0: proven free, --min-distance, joint limits and rates proven to
    be kept; 3: anything else, whatever remedies there are; 130: interrupted,
    with --out run the same command to continue; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        files: CSV (joints by name or q1 ... qn, a time column if there is one), .npy, .npz, JSON or YAML of a
            JointTrajectory, or ROS bags (.bag, .db3, .mcap, the folder of a recording); or folders of these. Poses of
            the tip, joined by straight moves: CSV with x, y, z and qx, qy, qz, qw or roll, pitch, yaw, or JSON or YAML
            with poses.
    """
    from rankdrop.jobs import progress_of
    from rankdrop.motion import (
        FORMATS,
        WRITTEN,
        PathQuestion,
        check_files,
        check_format,
        many_section,
        paths_to_dict,
    )
    from rankdrop.results import Analysis

    if many.status is not None:
        write_text(f"{progress_of(many.status).sentence}\n", STDOUT)
        return exits.FINE
    check_targets(
        {"--json": output.json, "--figure": output.figure, "--html": output.html, "--rows": output.rows,
         "--fixed": mend.fixed, "--certificate": output.certificate},
        {"--figure": (".svg", ".png", ".pdf"), "--html": (".html", ".htm"), "--rows": FORMATS, "--fixed": WRITTEN},
    )  # fmt: skip
    near = model_tolerance(output.model_tolerance)
    if output.rows is not None:
        check_format(output.rows)
    name, found = _files(robot, files)
    several = len(found) > 1 or many.out is not None or many.scheduler is not None
    if several:
        _check_several(output, mend)
    model, task = open_arm(name, arm, source.tcp, deg=source.deg)
    start = (
        None
        if source.start is None
        else tuple(parse_configuration(source.start, model, deg=source.deg, option="--start"))
    )
    families = None if source.analysis is None else Analysis.load(source.analysis)
    question = PathQuestion(task, families, check, source.deg, source.topic, start)
    if not several:
        from rankdrop.motion import check_file, mend_path

        with reporter(quiet=output.quiet) as report:
            result = check_file(
                model, found[0], question, say=say,
                progress=lambda done, total: report(f"{found[0].name}: stretches decided", done, total),
            )  # fmt: skip
            remedies = None
            if mend.wanted and result.complete:
                remedies = mend_path(
                    result, analysis=families, acceleration=mend.acceleration,
                    options=RemedyOptions(mend.tool_tilt, mend.base_shift, mend.blend),
                    progress=lambda kind, done, total: report(f"remedies: {kind}", done, total),
                )  # fmt: skip
        return _hand_over_one(result, remedies, near, families, output, mend.fixed, found[0])
    with reporter(quiet=output.quiet) as report:
        checked = check_files(model, found, question, out=many.out, workers=many.workers, scheduler=many.scheduler,
                              report=report)  # fmt: skip
    for line in (line for one in checked for line in one["said"]):
        say(line)

    hand_over(lambda: print_sections([many_section(checked)]),
              (output.json, lambda target: write_json(paths_to_dict(model, checked), target)))  # fmt: skip
    return _worst(checked, len(found), many.out)


def _files(robot: str | None, names: tuple[str, ...]) -> tuple[str, list[Path]]:
    """The arm, and the files named, folders as the trajectory files in them, sorted.

    Raises:
        OptionError: none is named, or a folder holds none.
    """
    from rankdrop.motion import ENDINGS, is_bag, trajectories_in

    if robot is None or not names:
        raise OptionError("no file is named", where="FILE", mend="rankdrop path ROBOT FILE",
                          allowed="trajectory files, or folders of them; or --status FOLDER")  # fmt: skip
    found: list[Path] = []
    for name in names:
        inside = [Path(name)] if not Path(name).is_dir() or is_bag(Path(name)) else trajectories_in(Path(name))
        if not inside:
            raise OptionError("there is no trajectory in the folder", where=name, allowed=", ".join(ENDINGS))
        found += inside
    return robot, found


def _check_several(output: PathOutput, mend: Remedies) -> None:
    """Refuse what is of one path.

    Raises:
        OptionError: of several files, remedies or an output of one path are asked for.
    """

    asked = [f"--{name.replace('_', '-')}" for name in OF_ONE_PATH if getattr(output, name) is not None]
    for name in (["--remedies"] if mend.wanted else []) + asked:
        raise OptionError("this option is for one path", where=name, mend="name one file, without --out")


def _hand_over_one(
    result: PathCheck, remedies: Mending | None, near: ModelTolerance | None, families: Analysis | None,
    output: PathOutput, fixed: str | None, file: Path,
) -> int:  # fmt: skip
    from rankdrop.motion import path_certificate, path_rows, proven_for_near_arms, rows_file

    sections = [*result.sections(full=output.full), *(() if remedies is None else remedies.sections())]
    kept = near is not None and result.complete and result.clear and proven_for_near_arms(result, near)
    if near is not None:
        within = f"{near.length * 1e3:g} mm and {near.angle * 1e3:g} mrad"
        arms = f"for every arm within {within} of this one, joint by joint"
        sections.append(Section("model", f"free {arms}: {'proven' if kept else 'not proven'}"))
    wanted = output.certificate is not None and result.complete
    proven = path_certificate(result, near if kept else None, file=file) if wanted else None
    record = result.to_dict() | ({} if remedies is None else {"remedies": remedies.to_dict()})

    def draw(target: str) -> None:
        from rankdrop.report.figures import rendered
        from rankdrop.report.path_page import path_figure

        write_bytes(rendered(path_figure(result), Path(target).suffix.lower()[1:]), target)

    def write_page(target: str) -> None:
        from rankdrop.report.path_page import path_page

        write_text(path_page(result), target)

    hand_over(
        lambda: print_sections(sections),
        (output.certificate, lambda target: save_certificate(proven, target)),
        (output.json, lambda target: write_json(record, target)),
        (fixed, lambda target: None if remedies is None else _write_fixed(remedies, target)),
        (output.figure, draw),
        (output.html, write_page),
        (output.rows, lambda target: write_bytes(rows_file(path_rows(result, families), target), target)),
    )
    if not result.complete or (remedies is not None and not remedies.complete):
        say("interrupted: what was proven so far holds")
        return exits.INTERRUPTED
    return exits.FINE if result.holds and (near is None or kept) else exits.UNEXPLAINED


def _write_fixed(mending: Mending, target: str) -> None:
    from rankdrop.motion import trajectory_bytes

    one = mending.best or (mending.remedies[0] if mending.remedies else None)
    if one is None:
        say(f"{target} is not written: {'no remedy was found' if mending.needed else 'the path needs none'}")
        return
    write_bytes(trajectory_bytes(one.trajectory, mending.before.robot, target), target)
    between = "" if one.interpolate == "linear" else f", read it with --interpolate {one.interpolate}"
    say(f"{target}: mended by {one.kind}, checked again: {one.check.verdict}{between}")


def _worst(many: list[dict[str, Any]], asked: int, out: str | None) -> int:

    if len(many) < asked:
        kept = f"; finished files are kept in {out}: run the same command to continue" if out else "; --out keeps them"
        say(f"interrupted: {len(many)} of {asked} files were checked{kept}")
        return exits.INTERRUPTED
    verdicts = {one["verdict"] for one in many}
    if "bad input" in verdicts:
        return exits.BAD_INPUT
    return exits.FINE if verdicts == {"free"} else exits.UNEXPLAINED
