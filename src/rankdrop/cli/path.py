"""`rankdrop path`: does a path meet a singularity, between its samples too?

And its remedies: the options, what is printed, and the mended file.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, TCP, ArmOptions, Whole

if TYPE_CHECKING:
    from pathlib import Path

    from rankdrop.certify import ModelTolerance
    from rankdrop.cli.terminal import Report
    from rankdrop.motion import Mending, PathCheck
    from rankdrop.results import Analysis
    from rankdrop.robot import Robot
    from rankdrop.sections import Section


@Parameter(name="*")
@dataclass(frozen=True)
class MendOptions:
    """Options of the remedies."""

    remedies: Annotated[bool, Parameter(negative=(), show_default=False)] = False
    """What would mend the path, each computed, judged again and proven."""
    tool_tilt: str = "0"
    """The tool may be tilted by up to this angle: 10deg. Asks for --remedies; so do the four below."""
    base_shift: str = "0"
    """The base may be moved by up to this length: 50mm."""
    blend: str = "0"
    """Where a corner is cut the tool point may leave the path by up to this length: 5mm."""
    acceleration: str | None = None
    """Limit of joint accelerations [rad/s², m/s²], for new time laws; arms state none."""
    fixed: str | None = None
    """Write the first path that is mended and proven free here, or retimed: .csv, .npz, .json."""

    @property
    def asked(self) -> bool:
        """Whether any of them is given."""
        return self.remedies or self != NO_MENDING


NO_MENDING = MendOptions()


def check_options(options: MendOptions, several: bool) -> dict[str, float | None]:
    """The bounds as numbers, before any work.

    Raises:
        OptionError: a number that cannot be, or several paths.
    """
    from rankdrop.errors import OptionError, RobotError
    from rankdrop.robot import quantity

    if options.asked and several:
        raise OptionError("remedies are those of one path", where="--remedies", mend="name one file, without --out")
    bounds: dict[str, float | None] = {}
    for name, text, measure in (("tool_tilt", options.tool_tilt, "angle"), ("base_shift", options.base_shift, "length"),
                                ("blend", options.blend, "length"),
                                ("acceleration", options.acceleration, "number")):  # fmt: skip
        where = "--" + name.replace("_", "-")
        try:
            bounds[name] = None if text is None else quantity(text, measure, where=where)
        except RobotError as error:
            raise OptionError(error.what, where=error.where, got=error.got, allowed=error.allowed) from error
        value = bounds[name]
        if value is not None and (value < 0.0 or (name == "acceleration" and value == 0.0)):
            least = "above 0" if name == "acceleration" else "0 or more"
            raise OptionError("the bound is out of range", where=where, got=text, allowed=least)
    return bounds


def mended(
    result: PathCheck, bounds: dict[str, float | None], analysis: Analysis | None, report: Report
) -> Mending:
    """The remedies, with progress."""
    from rankdrop.motion import mend_path

    return mend_path(
        result, analysis=analysis, tool_tilt=bounds["tool_tilt"] or 0.0, base_shift=bounds["base_shift"] or 0.0,
        blend=bounds["blend"] or 0.0, acceleration=bounds["acceleration"],
        progress=lambda kind, done, total: report(f"remedies: {kind}", done, total),
    )  # fmt: skip


def write_fixed(mending: Mending, target: str) -> None:
    """The mended path as a file, and a line that says so."""
    from rankdrop.cli.terminal import say, write_bytes
    from rankdrop.motion import trajectory_bytes

    one = mending.best or (mending.remedies[0] if mending.remedies else None)
    if one is None:
        say(f"{target} is not written: {'no remedy was found' if mending.needed else 'the path needs none'}")
        return
    write_bytes(trajectory_bytes(one.trajectory, mending.before.robot, target), target)
    between = "" if one.interpolate == "linear" else f", read it with --interpolate {one.interpolate}"
    say(f"{target}: mended by {one.kind}, judged again: {one.check.verdict}{between}")


_OF_ONE = {
    "--figure": "a figure is", "--html": "a page is", "--rows": "rows are", "--certificate": "a certificate is",
    "--model-tolerance": "a tolerance of the model is",
}  # fmt: skip


def path(
    robot: str | None = None,
    /,
    *files: str,
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    interpolate: Literal["linear", "cubic", "quintic"] = "linear",
    min_distance: str = "0",
    arm: ArmOptions = NO_OPTIONS,
    frame: Literal["base", "tool", "link"] = "base",
    tcp: TCP = None,
    analysis: str | None = None,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    evaluations: Whole = 2_000_000,
    topic: str | None = None,
    start: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    full: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    figure: str | None = None,
    mend: MendOptions = NO_MENDING,
    html: str | None = None,
    rows: str | None = None,
    certificate: str | None = None,
    model_tolerance: str | None = None,
    out: str | None = None,
    workers: Whole = 0,
    scheduler: str | None = None,
    status: str | None = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Judge a path at every one of its points: free, crossing a singularity, touching one, or undecided.

    Nothing is sampled: every stretch between two samples is enclosed and halved
    until it is proven free or its crossing is bracketed. Several files, or a
    folder of them, give a table, worst first.

    For example:
        rankdrop path ur5e pick.csv --deg
        rankdrop path panda plan.yaml --interpolate cubic --min-distance 5deg
        rankdrop path ur5e programs/ --json paths.json --out judged
        rankdrop path --status judged
        rankdrop path puma560 weld.npz --figure weld.svg
        rankdrop path ur5e pick.csv --tool-tilt 10deg --fixed mended.csv
        rankdrop path ur10e recorded.mcap --topic /joint_states
        rankdrop path ur5e poses.csv --start "0,-90deg,90deg,0,90deg,0"

    Exit code 0: proven free, and --min-distance proven to be kept; 3: crossing,
    touching, too near, or undecided, whatever remedies there are; 130:
    interrupted, with --out the same command goes on; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        files: CSV (joints by name or q1 ... qn, a time column if there is one), .npy, .npz, JSON or YAML of a
            JointTrajectory, or ROS bags (.bag, .db3, .mcap, the folder of a recording); or folders of these. Poses of
            the tip, joined by straight moves: CSV with x, y, z and qx, qy, qz, qw or roll, pitch, yaw, or JSON or YAML
            with poses.
        deg: Angles without a unit are in degrees.
        interpolate: What the controller makes of the samples: straight lines, cubics through the velocities, or
            quintics through the accelerations too.
        min_distance: Distance in joint space to be kept from every singularity [rad; slides divided by the length
            scale]; 5deg is understood.
        analysis: Families from this file (`rankdrop analyze --json`); else from the catalogue.
        frame: In whose axes motions are told: base, tool, or the link in which they are simplest.
        tcp: Tool point from the tip, in its axes: x,y,z or x,y,z,roll,pitch,yaw [m, rad]; 120mm, 30deg are understood.
        limits: Distances to singularities within the joint limits only.
        evaluations: Enclosures that one path may cost; about 10 microseconds each.
        topic: Of a bag in which several have joint values (JointState, JointTrajectory).
        start: Configuration near the first pose: which branch of the inverse kinematics. Default: of those found, the
            one nearest to zero.
        full: Every stretch, not the ten worst.
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        figure: Draw distance, singular value and joint rates along the path: .svg, .png or .pdf.
        html: Write a page that stands alone, with the arm playing the path: .html.
        rows: Write a table, one line for each row: .parquet, .json or .csv. Units are in the names of the columns.
        certificate: Write what is proven to this file, for `rankdrop verify`: the path, its free spans and crossings.
        model_tolerance: Prove the path free for every arm so near to this one, joint by joint: 0.3mm,1mrad.
        out: Of several files: folder in which what is finished is kept, with a journal: after an interruption, of any
            kind, the same command goes on.
        workers: Of several files: local processes; 0: one for every processor. The result does not depend on it.
        scheduler: Of several files: address of a Dask scheduler, whose workers see the files under the same names
            (tcp://HOST:8786).
        status: Only say how far the paths kept in this folder are.
        quiet: No progress.
    """
    from rankdrop.cli.arm import open_arm
    from rankdrop.cli.certificates import model_tolerance as tolerance_of
    from rankdrop.cli.certificates import save_certificate
    from rankdrop.cli.terminal import STDOUT, check_targets, hand_over, reporter, say, write_json, write_text
    from rankdrop.jobs import progress_of
    from rankdrop.motion import (
        FORMATS,
        FREE,
        WRITTEN,
        HowJudged,
        check_file,
        check_files,
        check_format,
        path_certificate,
        paths_to_dict,
        proven_for_near_arms,
    )
    from rankdrop.results import Analysis

    if status is not None:
        write_text(f"{progress_of(status).sentence}\n", STDOUT)
        return exits.FINE
    check_targets(
        {"--json": json, "--figure": figure, "--html": html, "--rows": rows, "--fixed": mend.fixed,
         "--certificate": certificate},
        {"--figure": (".svg", ".png", ".pdf"), "--html": (".html", ".htm"), "--rows": FORMATS, "--fixed": WRITTEN},
    )  # fmt: skip
    near = tolerance_of(model_tolerance)
    if rows is not None:
        check_format(rows)
    name, found = _files(robot, files)
    several = len(found) > 1 or out is not None or scheduler is not None
    bounds = check_options(mend, several)
    model, task = open_arm(name, arm, tcp, deg=deg)
    least = _distance(min_distance, several, {
        "--figure": figure, "--html": html, "--rows": rows, "--certificate": certificate,
        "--model-tolerance": model_tolerance,
    })  # fmt: skip
    families = None if analysis is None else Analysis.load(analysis)
    how = HowJudged(deg, interpolate, least, limits, evaluations, topic, _start(start, model, deg=deg), frame)

    if not several:
        with reporter(quiet=quiet) as report:
            result = check_file(
                model, found[0], task=task, analysis=families, how=how, say=say,
                progress=lambda done, total: report(f"{found[0].name}: stretches decided", done, total),
            )  # fmt: skip
            remedies = mended(result, bounds, families, report) if mend.asked and result.complete else None
        kept = None if near is None else bool(result.complete and result.verdict == FREE) and proven_for_near_arms(
            result, near
        )
        wanted = certificate is not None and result.complete
        proven = path_certificate(result, near if kept else None, file=found[0]) if wanted else None
        hand_over(
            lambda: _print(result, remedies, near, full=full, kept=bool(kept)),
            (certificate, lambda target: save_certificate(proven, target)),
            (json, lambda target: write_json(_record(result, remedies), target)),
            (mend.fixed, lambda target: None if remedies is None else write_fixed(remedies, target)),
            (figure, lambda target: _draw(result, target)),
            (html, lambda target: _page(result, target)),
            (rows, lambda target: _rows(result, families, target)),
        )
        return _code(result, remedies) or (exits.UNEXPLAINED if kept is False else exits.FINE)
    with reporter(quiet=quiet) as report:
        many = check_files(model, found, task=task, analysis=families, how=how, out=out, workers=workers,
                           scheduler=scheduler, report=report)  # fmt: skip
    for line in (line for one in many for line in one["said"]):
        say(line)
    hand_over(lambda: _print_many(many), (json, lambda target: write_json(paths_to_dict(model, many), target)))
    return _worst(many, len(found), out)


def _files(robot: str | None, names: tuple[str, ...]) -> tuple[str, list[Path]]:
    """The arm, and the files named, folders as the trajectory files in them, sorted.

    Raises:
        OptionError: none is named, or a folder holds none.
    """
    from pathlib import Path

    from rankdrop.errors import OptionError
    from rankdrop.motion import ENDINGS, is_bag, trajectories_in

    if robot is None or not names:
        raise OptionError("no file is named", where="FILE", mend="rankdrop path ROBOT FILE",
                          allowed="trajectory files, or folders of them; or --status FOLDER")  # fmt: skip
    found: list[Path] = []
    for name in names:
        if not Path(name).is_dir() or is_bag(Path(name)):
            found.append(Path(name))
            continue
        inside = trajectories_in(Path(name))
        if not inside:
            raise OptionError("there is no trajectory in the folder", where=name, allowed=", ".join(ENDINGS))
        found += inside
    return robot, found


def _start(text: str | None, robot: Robot, *, deg: bool) -> tuple[float, ...] | None:
    from rankdrop.cli.arm import parse_configuration

    return None if text is None else tuple(parse_configuration(text, robot, deg=deg, option="--start"))


def _distance(text: str, several: bool, of_one: dict[str, str | None]) -> float:
    from rankdrop.errors import OptionError, RobotError
    from rankdrop.robot import quantity

    for option, target in of_one.items():
        if target is not None and several:
            raise OptionError(f"{_OF_ONE[option]} of one path", where=option, mend="name one file, without --out")
    try:
        value = quantity(text, "angle", where="--min-distance")
    except RobotError as error:
        raise OptionError(error.what, where=error.where, got=error.got, allowed=error.allowed) from error
    if value < 0.0:
        raise OptionError("the distance is below zero", where="--min-distance", got=text, allowed="0 or more")
    return value


def _print(
    result: PathCheck, remedies: Mending | None, near: ModelTolerance | None, *, full: bool, kept: bool
) -> None:
    from rankdrop.cli.terminal import print_sections

    *first, last = result.sections(full=full)
    beside = [] if near is None else [_near_section(near, kept)]
    print_sections([*first, *(() if remedies is None else remedies.sections()), last, *beside])


def _near_section(near: ModelTolerance, kept: bool) -> Section:
    from rankdrop.sections import Section

    arms = f"for every arm within {near.length * 1e3:g} mm and {near.angle * 1e3:g} mrad of this one, joint by joint"
    return Section("model", f"free {arms}: {'proven' if kept else 'not proven'}")


def _record(result: PathCheck, remedies: Mending | None) -> dict[str, object]:
    return result.to_dict() | ({} if remedies is None else {"remedies": remedies.to_dict()})


def _print_many(many: list[dict[str, Any]]) -> None:
    from rankdrop.cli.terminal import print_sections
    from rankdrop.motion import many_section

    print_sections([many_section(many)])


def _draw(result: PathCheck, target: str) -> None:
    from pathlib import Path

    from rankdrop.cli.terminal import write_bytes
    from rankdrop.report.figures import rendered
    from rankdrop.report.path_figure import path_figure

    write_bytes(rendered(path_figure(result), Path(target).suffix.lower()[1:]), target)


def _page(result: PathCheck, target: str) -> None:
    from rankdrop.cli.terminal import write_text
    from rankdrop.report.path_page import path_page

    write_text(path_page(result), target)


def _rows(result: PathCheck, families: Analysis | None, target: str) -> None:
    from rankdrop.cli.terminal import write_bytes
    from rankdrop.motion import path_rows, rows_file

    write_bytes(rows_file(path_rows(result, families), target), target)


def _code(result: PathCheck, remedies: Mending | None) -> int:
    from rankdrop.cli.terminal import say

    if not result.complete or (remedies is not None and not remedies.complete):
        say("interrupted: what was proven so far holds")
        return exits.INTERRUPTED
    return exits.FINE if result.holds else exits.UNEXPLAINED


def _worst(many: list[dict[str, Any]], asked: int, out: str | None) -> int:
    from rankdrop.cli.terminal import say

    if len(many) < asked:
        kept = f"; what is done is kept in {out}: the same command goes on there" if out else "; --out keeps it"
        say(f"interrupted: {len(many)} of {asked} files were judged{kept}")
        return exits.INTERRUPTED
    verdicts = {one["verdict"] for one in many}
    if "bad input" in verdicts:
        return exits.BAD_INPUT
    return exits.FINE if verdicts == {"free"} else exits.UNEXPLAINED
