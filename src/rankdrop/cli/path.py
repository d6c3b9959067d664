"""`rankdrop path`: does a path reach a singularity, between its samples too, and what would avoid it?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from rankdrop import cover as covers
from rankdrop import jobs, results, text
from rankdrop import path as paths
from rankdrop.cli import exits
from rankdrop.cli.command import DRAWN, PAGES, Done, Output, command
from rankdrop.cli.opening import NO_OPTIONS, ROBOT_HELP, ArmOptions, ToolOptions, open_arm
from rankdrop.cli.targets import kept_work, write_bytes, write_text
from rankdrop.cli.terminal import STDOUT, Report, reporter, say
from rankdrop.cli.values import model_tolerance, parse_configuration
from rankdrop.errors import OptionError
from rankdrop.options import Options, option
from rankdrop.questions import PathOptions, RemedyOptions
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.robot import Robot
    from rankdrop.task import Task

OF_ONE_PATH = ("figure", "html", "rows", "certificate", "model_tolerance")
"""Outputs of a single path."""


@dataclass(frozen=True)
class Input(ToolOptions):
    """How files are read."""

    TITLE = "Input"

    topic: Annotated[
        str | None, option("Of a bag in which several have joint values (JointState, JointTrajectory)")
    ] = None  # fmt: skip
    start: Annotated[
        str | None, option("Configuration near the first pose: the nearest branch of the inverse kinematics is taken. "
                           "Default: of those found, the posture that people use")
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
    remedy: Annotated[
        Literal[
            "null-space", "flip", "bump", "detour", "blend", "tool-tilt", "base-shift", "slow-down", "retime"
        ] | None,
        option("Compute this kind of remedy alone"),
    ] = None  # fmt: skip
    fixed: Annotated[
        str | None, option("Write the best path that is proven free here, or retimed: .csv, .npz, .json",
                           writes=(".csv", ".npz", ".json"))
    ] = None  # fmt: skip
    fixed_as: Annotated[
        Literal["input", "joints"],
        option("What --fixed writes of a file of poses: poses again, in the form of the file, or joint values"),
    ] = "input"  # fmt: skip

    @property
    def any_requested(self) -> bool:
        """Whether any remedy is asked for; bounds of local ones, that are computed anyway, do not ask for others."""
        return replace(self, bump=0.0, detour=0.0, fixed_as="input") != replace(NO_REMEDIES, bump=0.0, detour=0.0)

    @property
    def kinds(self) -> tuple[tuple[str, ...], ...]:
        """Those that are computed, the next where the ones before have no remedy.

        Without a question for remedies the local ones, for the advice below the verdict. Where a mended file is all
        that is asked for, the local ones first: the rest of the file stays as it is.
        """
        if self.remedy is not None:
            return ((self.remedy if self.remedy in paths.KINDS else self.remedy.replace("-", " "),),)
        if not self.any_requested:
            return (paths.LOCAL,)
        if replace(self, fixed=None, acceleration=None).any_requested:
            return (paths.KINDS,)
        return paths.LOCAL, tuple(kind for kind in paths.KINDS if kind not in paths.LOCAL)


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
        str | None, option("Address of a Dask scheduler; its workers see the files under the same names "
                           "(tcp://HOST:8786)")
    ] = None  # fmt: skip
    status: Annotated[str | None, option("Print the progress of the paths kept in this folder, and end")] = None

    @property
    def as_batch(self) -> bool:
        """Whether the work is kept in a folder or done by a cluster: even one file is checked as several are."""
        return self.out is not None or self.scheduler is not None


@dataclass(frozen=True)
class PathOutput(Output):
    """Printed and written output."""

    full: Annotated[bool, option("Print every crossing and every free stretch")] = False
    example: Annotated[
        str | None, option("Write a path to try: from a good posture of the arm through its nearest singularity; no "
                           "file is checked", writes=(".csv", ".npz", ".json"))
    ] = None  # fmt: skip
    figure: Annotated[
        str | None,
        option("Draw distance, singular value and joint rates along the path: .svg, .png or .pdf", writes=DRAWN),
    ] = None
    html: Annotated[
        str | None, option("Write a page that stands alone, with the arm playing the path: .html", writes=PAGES)
    ] = None  # fmt: skip
    rows: Annotated[
        str | None, option("Write a table, one line for each row: .parquet, .json or .csv. Units are in the names of "
                           "the columns", writes=(".parquet", ".json", ".csv"))
    ] = None  # fmt: skip
    certificate: Annotated[
        str | None, option("Write the proofs to this file, for `rankdrop verify`: the path, its free spans and "
                           "crossings", writes=())
    ] = None  # fmt: skip
    model_tolerance: Annotated[
        str | None, option("Prove the path free for every arm so near to this one, joint by joint: 0.3mm,1mrad")
    ] = None  # fmt: skip


NO_REMEDIES = Remedies()
@dataclass(frozen=True)
class MendedFrom:
    """What a mended file is written from: the arm and the file as named, families, and the unit of its angles."""

    arm: str
    source: Path
    families: results.Analysis | None
    deg: bool


@command
def path(
    robot: Annotated[str | None, Parameter(help=ROBOT_HELP)] = None,
    /,
    *files: str,
    arm: ArmOptions = NO_OPTIONS,
    source: Input = Input(),
    check: PathOptions = PathOptions(),
    mend: Remedies = NO_REMEDIES,
    many: ManyFiles = ManyFiles(),
    output: PathOutput = PathOutput(),
) -> Done | int:
    """Check a path for singularities, between its samples too.

    Free, crossing one, touching one, too fast, outside joint limits, or undecided.

    Nothing is sampled: every stretch between two samples is enclosed and halved
    until it is proven free or its crossing is bracketed. Poses of the tip are
    joined by straight moves; the joints are proven to keep the tip on them.
    Several files, or a folder of them, give a table, worst first.

    For example:
        rankdrop path ur5e --example pick.csv
        rankdrop path ur5e pick.csv
        rankdrop path panda plan.yaml --interpolate cubic --min-distance 5deg
        rankdrop path ur5e programs/ --json paths.json --out checked
        rankdrop path --status checked
        rankdrop path puma560 weld.npz --figure weld.svg
        rankdrop path ur5e pick.csv --tool-tilt 10deg --fixed mended.csv
        rankdrop path ur10e recorded.mcap --topic /joint_states
        rankdrop path ur5e poses.csv --start "0,-90deg,90deg,0,90deg,0"
        rankdrop path kr6r900 weld.src

    Exit code 0: proven free, --min-distance, joint limits and rates proven to
    be kept; 3: anything else, whatever remedies there are; 130: interrupted,
    with --out run the same command to continue; 2: bad input.

    Args:
        files: CSV (joints by name or q1 ... qn, a time column if there is one), .npy, .npz, JSON or YAML of a
            JointTrajectory, or ROS bags (.bag, .db3, .mcap, the folder of a recording); or folders of these. Poses of
            the tip, joined by straight moves: CSV with x, y, z and qx, qy, qz, qw or roll, pitch, yaw, or with
            matrices (m00 ... m23 or m00 ... m33); JSON or YAML with poses; .npy or .npz of shape (N, 4, 4) or
            (N, 3, 4). Robot programs with literal targets: .src (KUKA KRL), .mod, .modx (ABB RAPID), .script
            (URScript), .ls (FANUC TP listing), .jbi (Yaskawa INFORM); the lines that are not read are listed.
    """
    if many.status is not None:
        write_text(f"{jobs.progress_of(many.status).sentence}\n", STDOUT)
        return exits.FINE
    if output.example is not None:
        return _example(robot, files, arm, source, output.example, quiet=output.quiet)
    near = model_tolerance(output.model_tolerance)
    if output.rows is not None:
        paths.check_format(output.rows)
    name, named = _files(robot, files)
    several = len(named) > 1 or many.as_batch
    _check_asked(named, several, output, mend)
    model, task = open_arm(name, arm, source)
    question = _question(model, task, arm, source, check)
    families = question.analysis
    if not several:
        _check_target(named[0], model, mend)
    with reporter(quiet=output.quiet) as report:
        if several:
            checked = paths.check_files(model, named, question, out=many.out, workers=many.workers,
                                         scheduler=many.scheduler, report=report)  # fmt: skip
            return _of_several(model, checked, len(named), many.out)
        progress = partial(report, f"{named[0].name}: stretches decided")
        result, remedies = paths.check_any_file(model, named[0], question, say=say, progress=progress), None
        if isinstance(result, paths.ProgramCheck):
            return _of_program(result, _line_remedies(result, families, mend), output)
        if result.complete and (mend.any_requested or _needs_remedy(result)):
            remedies = _find_remedies(result, families, mend, report)
    written = MendedFrom(name, named[0], families, source.deg)
    return _of_one(result, remedies, near, families, output, mend, written)


def _question(model: Robot, task: Task, arm: ArmOptions, source: Input, check: PathOptions) -> paths.PathQuestion:
    """The question for each path; with a task only where one was named or scaled."""
    start = None
    if source.start is not None:
        start = tuple(parse_configuration(source.start, model, deg=source.deg, option="--start"))
    families = _opened_families(source.analysis)
    asked = None
    if arm.task is not None or arm.length_scale is not None:
        asked = task
    at_tool_point = source.tcp is not None
    return paths.PathQuestion(asked, families, check, source.deg, source.topic, start, at_tool_point)


def _check_target(file: Path, model: Robot, mend: Remedies) -> None:
    """Refuse a file for a mended path in the form of its input that poses cannot be written to."""
    if mend.fixed is not None and mend.fixed_as == "input" and paths.holds_poses(file, model):
        paths.check_pose_target(file, mend.fixed)


def _needs_remedy(check: paths.PathCheck) -> bool:
    """Whether a path is not free, or too fast; poses that an arm with few joints cannot take need another task."""
    if check.tool is not None and check.tool.reason == "few joints":
        return False
    return not check.clear or check.verdict == paths.TOO_FAST


def _line_remedies(
    check: paths.ProgramCheck, families: results.Analysis | None, mend: Remedies
) -> tuple[paths.LineRemedy, ...]:
    """A remedy for each line of a program that is not free; none where all are, or the check was cut short."""
    if check.holds or not check.complete:
        return ()
    options = RemedyOptions(bump=mend.bump, detour=mend.detour)
    return paths.program_remedies(check, analysis=families, options=options)


def _opened_families(file: str | None) -> results.Analysis | None:
    """The analysis of a file; None where none is named."""
    if file is None:
        return None
    return results.Analysis.load(file)


def _find_remedies(
    check: paths.PathCheck, families: results.Analysis | None, mend: Remedies, report: Report
) -> paths.Mending | None:
    """Remedies of the kinds asked for, one group after the other until one has a remedy."""
    remedies = None
    for kinds in mend.kinds:
        mending = paths.mend_path(
            check, analysis=families, acceleration=mend.acceleration, kinds=kinds,
            options=RemedyOptions(mend.tool_tilt, mend.base_shift, mend.blend, mend.bump, mend.detour),
            progress=lambda kind, done, total: report(f"remedies: {kind}", done, total),
        )  # fmt: skip
        remedies = mending if remedies is None else replace(mending, failures=remedies.failures + mending.failures)
        if remedies.best is not None or not remedies.complete:
            break
    return remedies


def _check_asked(named: list[Path], several: bool, output: PathOutput, mend: Remedies) -> None:
    """Refuse outputs and remedies that programs, or several files, do not have."""
    if any(map(paths.is_program, named)):
        _check_program(output, mend)
    if several:
        _check_several(output, mend)


def _example(
    name: str | None, files: tuple[str, ...], arm: ArmOptions, source: Input, target: str, *, quiet: bool
) -> int:
    """Write a path to try.

    Raises:
        OptionError: no arm is named, files are named as well, or the ending names no format.
    """
    if name is None:
        raise OptionError("no arm is named", where="ROBOT", mend="rankdrop path ROBOT --example FILE")
    opened = open_arm(name, arm, source)
    if files:
        raise OptionError("no file is checked with this option", where="--example", got=files[0],
                          mend=f"rankdrop path {name} --example {target}")  # fmt: skip
    made = paths.example_path(*opened)
    write_bytes(paths.trajectory_bytes(made, opened[0], target), target)
    if not quiet:
        say(f"{target}: {len(made.q)} rows, {made.times[-1]:g} s; check it: rankdrop path {name} {target}")
    return exits.FINE


def _files(robot: str | None, names: tuple[str, ...]) -> tuple[str, list[Path]]:
    """The arm, and the files named, folders as the trajectory files in them, sorted.

    Raises:
        OptionError: none is named, or a folder holds none.
    """
    if robot is None or not names:
        raise OptionError("no file is named", where="FILE", mend="rankdrop path ROBOT FILE",
                          allowed="trajectory files, or folders of them; or --status FOLDER")  # fmt: skip
    files: list[Path] = []
    if Path(robot).suffix.lower() in paths.ENDINGS and not Path(names[0]).exists():
        raise OptionError("the arm is named first, then its files", where="ROBOT", got=robot,
                          mend=f"rankdrop path {names[0]} {robot}")  # fmt: skip
    for path in map(Path, names):
        if not path.is_dir() or paths.is_bag(path):
            inside = [path]
        else:
            inside = paths.trajectories_in(path)
        if not inside:
            raise OptionError("there is no trajectory in the folder", where=str(path),
                              allowed=", ".join(paths.ENDINGS))  # fmt: skip
        files += inside
    return robot, files


def _check_several(output: PathOutput, mend: Remedies) -> None:
    """Refuse options of one path.

    Raises:
        OptionError: of several files, remedies or an output of one path are asked for.
    """
    given = [f"--{name.replace('_', '-')}" for name in OF_ONE_PATH if getattr(output, name) is not None]
    for name in (["--remedies"] if mend.any_requested else []) + given:
        raise OptionError("this option is for one path", where=name, mend="name one file, without --out")


def _check_program(output: PathOutput, mend: Remedies) -> None:
    """Refuse options that a program does not have.

    Raises:
        OptionError: remedies or an output of a joint path are asked for.
    """
    given = [f"--{name.replace('_', '-')}" for name in OF_ONE_PATH if getattr(output, name) is not None]
    for name in (["--remedies"] if mend.any_requested else []) + given:
        raise OptionError("this option is not for robot programs", where=name,
                          mend="programs are not written: the plain command names the remedy for each line, and "
                          "--json writes the joint path of every part, which can be checked and mended as a file",
                          )  # fmt: skip


def _of_program(result: paths.ProgramCheck, lines: tuple[paths.LineRemedy, ...], output: PathOutput) -> Done:
    def record() -> dict[str, Any]:
        return result.to_dict() | {"remedies": paths.remedies_to_dict(lines, result.robot)}

    return Done(
        lambda: list(result.sections(full=output.full, remedies=lines)), {"json": record}, holds=result.holds,
        complete=result.complete, last=_last_words(complete=result.complete),
    )  # fmt: skip


def _last_words(*, complete: bool) -> Callable[[], object] | None:
    """The line that ends an interrupted check."""
    if complete:
        return None
    return partial(say, "interrupted: what was proven so far holds")


def _of_one(
    result: paths.PathCheck, remedies: paths.Mending | None, near: covers.ModelTolerance | None,
    families: results.Analysis | None, output: PathOutput, mend: Remedies, written: MendedFrom,
) -> Done:  # fmt: skip
    proven = near is not None and result.complete and result.clear and paths.proven_for_near_arms(result, near)
    complete = result.complete and (not mend.any_requested or remedies is None or remedies.complete)
    holds = result.holds and (near is None or proven)
    certified = None
    if proven:
        certified = near

    def sections() -> list[Section]:
        sections = [*result.sections(full=output.full, mending=remedies, listed=mend.any_requested, target=mend.fixed)]
        if remedies is not None and mend.any_requested:
            sections += remedies.sections()
        if near is not None:
            sections.append(_near_section(near, proven=proven))
        return sections

    files: dict[str, Callable[[], Any]] = {
        "certificate": partial(_certificate, result, certified, written.source),
        "json": partial(_record, result, remedies),
        "fixed": partial(_mended_path_bytes, remedies, mend, written),
        "figure": partial(_figure, result, output.figure),
        "html": partial(_page, result),
        "rows": partial(_rows, result, families, output.rows),
    }
    return Done(sections, files, holds=holds, complete=complete, last=_last_words(complete=complete))


def _near_section(near: covers.ModelTolerance, *, proven: bool) -> Section:
    """Whether a path is proven free for every arm near to this one."""
    within = f"{near.length * 1e3:g} mm and {near.angle * 1e3:g} mrad"
    arms = f"for every arm within {within} of this one, joint by joint"
    return Section("model", f"free {arms}: {'proven' if proven else 'not proven'}")


def _certificate(
    check: paths.PathCheck, near: covers.ModelTolerance | None, file: Path
) -> results.Record | None:
    """The certificate of a path; None where the check was cut short."""
    if not check.complete:
        return None
    return paths.path_certificate(check, near, file=file)


def _record(check: paths.PathCheck, mending: paths.Mending | None) -> dict[str, Any]:
    """A checked path and its remedies for programs."""
    record: dict[str, Any] = check.to_dict()
    if mending is not None:
        record = record | {"remedies": mending.to_dict()}
    return record


def _figure(check: paths.PathCheck, target: str | None) -> bytes:
    """The figure of a path in the format of the file's ending."""
    from rankdrop.report.figures import render
    from rankdrop.report.path_page import path_figure

    return render(path_figure(check), Path(target or "").suffix.lower()[1:])


def _page(check: paths.PathCheck) -> str:
    """The page of a path."""
    from rankdrop.report.path_page import path_page

    return path_page(check)


def _rows(check: paths.PathCheck, families: results.Analysis | None, target: str | None) -> Any:
    """What holds at every row of a path, in the format of the file's ending."""
    return paths.rows_file(paths.path_rows(check, families), target or "")


def _mended_path_bytes(mending: paths.Mending | None, mend: Remedies, written: MendedFrom) -> bytes | None:
    """The mended path; what was done, or why there is none, goes to stderr."""
    target = mend.fixed
    if mending is None or target is None:
        return None
    remedy = mending.written
    if remedy is None:
        why = "the path needs none"
        if mending.needed:
            why = "no remedy was found"
        say(f"{target} is not written: {why}")
        return None
    form = ""
    if mending.before.poses is not None and mend.fixed_as == "input":
        made = paths.mended_poses(mending.before, remedy, analysis=written.families, acceleration=mend.acceleration)
        if isinstance(made, paths.MendedPoses):
            say(text.poses_written(target, remedy, made, mending.before.robot, arm=written.arm,
                                   given_start=_given_start(mending.before)))  # fmt: skip
            return paths.poses_bytes(written.source, made.matrices, made.times, made.given, deg=written.deg,
                                     robot=mending.before.robot)  # fmt: skip
        form = f"; {text.NO_POSES[made]}"
    if remedy.interpolate == "linear":
        between = ""
    else:
        between = f", read it with --interpolate {remedy.interpolate}"
    say(f"{target}: mended by {remedy.kind}, checked again: {remedy.check.verdict}{between}{form}")
    return paths.trajectory_bytes(remedy.trajectory, mending.before.robot, target)


def _given_start(check: paths.PathCheck) -> bool:
    """The branch of a tool path was chosen by --start."""
    return check.tool is not None and check.tool.given_start


def _of_several(model: Any, checked: list[dict[str, Any]], files: int, out: str | None) -> Done:
    for record in checked:
        for line in record["said"]:
            say(line)
    verdicts, complete = {record["verdict"] for record in checked}, len(checked) == files
    note = f"interrupted: {len(checked)} of {files} files were checked; {kept_work(out)}"
    return Done(
        lambda: [text.many_section(checked)], {"json": lambda: paths.paths_to_dict(model, checked)},
        holds=verdicts == {"free"}, complete=complete, last=None if complete else partial(say, note),
        code=exits.BAD_INPUT if complete and "bad input" in verdicts else None,
    )  # fmt: skip
