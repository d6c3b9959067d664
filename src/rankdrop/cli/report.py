"""`rankdrop report`: a page that stands alone, or figures for papers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import IDEAL, NO_OPTIONS, ArmOptions, Whole

if TYPE_CHECKING:
    from rankdrop.cli.terminal import Report
    from rankdrop.results import Analysis, Verdict
    from rankdrop.robot import Mesh
    from rankdrop.verbs import Idealised

Format = Literal["html", "pdf", "png", "svg"]
_ANALYSIS = ".json"


def report(
    robot: str,
    /,
    *,
    arm: ArmOptions = NO_OPTIONS,
    ideal: IDEAL = None,
    out: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    format: Format = "html",
    figure: Annotated[tuple[str, ...], Parameter(negative=(), show_default=False)] = (),
    exact_seconds: float = 8.0,
    no_meshes: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    starts: Whole = 10_000,
    seed: Whole = 0,
    threads: Whole = 0,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Write a report of an arm: one page that stands alone, or figures for papers.

    The page has the arm in 3-D with sliders, at every family's witness the
    directions lost and the axes to blame, the tables of conditions, the exact
    conditions, slices of joint space, the workspace, σ along lines, and how
    everything was verified. It loads nothing from anywhere.

    For example:
        rankdrop report pa10 --out pa10.html
        rankdrop report pa10.json --format pdf --figure workspace --out figures

    Exit code 3: something in the analysis is not explained, not sound or
    contradicted; the page says which in its first line.

    Args:
        robot: Name in the catalogue, file (.urdf, .xacro, .xml, .toml), or analysis (.json, `rankdrop analyze`).
        ideal: The nearest arm whose axes are exactly parallel, square and meeting, to a tolerance such as 1mm,0.5deg.
            What the arm itself does on the families of the ideal one is told.
        out: File of the page; for figures a folder, or a file for a single one. Default: ROBOT.html, ROBOT-figures.
        format: html is the page; pdf, png and svg are figures, to be put into a paper.
        figure: arm, slice, solid, workspace, image or lines; of one family: lines-k1.f1. May be given again. Default:
            all of them.
        exact_seconds: Time limit of the exact conditions; 0 leaves them out.
        no_meshes: Draw links as rods though the robot's file has shapes of them (URDF, xacro).
        limits: Families within the joint limits only; the arm is then analysed first.
        starts: Random starts for each corank, where the arm has to be analysed first.
        seed: Of every random choice of the analysis and of the figures.
        threads: Processors to use for the analysis; 0 means all. The result does not depend on it.
        json: Write the analysis to this file as well; - writes it to stdout.
        quiet: No progress; errors only.
    """
    from rankdrop.cli.terminal import check_different, check_target, reporter, say, write_json
    from rankdrop.errors import OptionError

    if figure and format == "html":
        raise OptionError("figures are files", where="--figure", got=figure[0], mend="add --format pdf, png or svg")
    if not 0 <= exact_seconds < float("inf"):
        raise OptionError("a time limit is a number from 0 up", where="--exact-seconds", got=exact_seconds)
    given = None if out is None else _checked(out, format)
    check_target(json, "--json")
    check_different({"--out": out, "--json": json})
    search = {"starts": starts, "seed": seed, "threads": threads, "limits": limits}
    with reporter(quiet=quiet) as progress:
        analysis, made = _analysis(robot, arm, ideal, search, progress)
        target = given or _checked(_default(analysis, format), format)
        plain = no_meshes or format != "html" or robot.lower().endswith(_ANALYSIS)
        drawn = () if plain else _drawn(analysis, arm, quiet=quiet)
        written, verdict, stopped = _written(
            analysis, made, target, format, figure, exact_seconds, seed, progress, drawn
        )  # fmt: skip
    for path in () if quiet else written:
        say(f"wrote {path}")
    if json is not None:
        write_json(analysis.to_dict(), json)
    if stopped or not analysis.complete:
        say("interrupted: the page tells what was done")
        return exits.INTERRUPTED
    return exits.FINE if verdict.holds else exits.UNEXPLAINED


def _analysis(
    robot: str, arm: ArmOptions, ideal: str | None, search: dict[str, Any], progress: Report
) -> tuple[Analysis, Idealised | None]:
    """The analysis given, the one that is shipped, or a new one; and how the arm was made where it is an ideal one."""
    from rankdrop import analyze
    from rankdrop.cli.arm import open_ideal
    from rankdrop.errors import OptionError
    from rankdrop.results import Analysis, known_analysis

    if robot.lower().endswith(_ANALYSIS):
        if arm != NO_OPTIONS or ideal is not None or search["limits"]:
            raise OptionError("an analysis has its arm, task and limits already", where=robot,
                              mend="leave the options out")  # fmt: skip
        return Analysis.load(robot), None
    model, task, made = open_ideal(robot, arm, ideal)
    found = known_analysis(model, task) if arm.length_scale is None and not search["limits"] else None
    return found or analyze(model, task, progress=progress, **search), made


def _written(
    analysis: Analysis,
    made: Idealised | None,
    target: Path,
    format: Format,
    figure: tuple[str, ...],
    exact_seconds: float,
    seed: int,
    progress: Report,
    drawn: tuple[Mesh, ...],
) -> tuple[list[Path], Verdict, bool]:
    """The files, the verdict of the first line, and whether exact conditions were interrupted."""
    from rankdrop.cli.terminal import write_bytes
    from rankdrop.report.content import content
    from rankdrop.report.figures import check_figures, figure_names, figures
    from rankdrop.report.page import page

    paper = format != "html"
    if paper:
        check_figures(analysis, figure)
    shown = content(
        analysis, exact=not paper and exact_seconds > 0, exact_seconds=exact_seconds, seed=seed, made=made,
        progress=progress, meshes=drawn,
    )  # fmt: skip
    if not paper:
        write_bytes(page(shown).encode(), str(target))
        return [target], shown.verdict, shown.interrupted
    names = figure_names(shown, figure)
    single = target.suffix.lower() == f".{format}"
    if single and len(names) > 1:
        from rankdrop.errors import OptionError

        raise OptionError("one file holds one figure", where="--out", got=f"{len(names)} figures", mend="give a folder")
    if not single:
        target.mkdir(exist_ok=True)
    paths = []
    for name, content_of in figures(shown, names, format):
        path = target if single else target / f"{name}.{format}"
        write_bytes(content_of, str(path))
        paths.append(path)
    return paths, shown.verdict, shown.interrupted


def _drawn(analysis: Analysis, arm: ArmOptions, *, quiet: bool) -> tuple[Mesh, ...]:
    """The shapes of the links that the arm's file has; what cannot be drawn is told unless it is to be `quiet`."""
    from rankdrop.cli.arm import arguments_of, packages_of
    from rankdrop.cli.terminal import say
    from rankdrop.errors import MissingExtraError
    from rankdrop.report.meshes import simplified
    from rankdrop.robot import meshes_of, visuals_of

    visuals, left_out = visuals_of(analysis.robot, packages_of(arm), arguments_of(arm))
    try:
        meshes, unread = meshes_of(visuals)
    except MissingExtraError as error:
        meshes, unread = (), (str(error),)
    for note in () if quiet else (*left_out, *unread):
        say(f"not drawn: {note}")
    return simplified(meshes)


def _default(analysis: Analysis, format: Format) -> str:
    name = analysis.robot.name.replace("/", "-")
    return f"{name}.html" if format == "html" else f"{name}-figures"


def _checked(out: str, format: Format) -> Path:
    """Where to write, refused before the work where that cannot be."""
    from rankdrop.cli.terminal import check_target
    from rankdrop.errors import OptionError

    path = Path(out)
    if format == "html":
        check_target(out, "--out", (".html", ".htm"))
    elif path.suffix.lower() == f".{format}":
        check_target(out, "--out")
    elif path.exists() and not path.is_dir():
        raise OptionError("it is a file", where="--out", got=out, allowed=f"a folder, or a name ending in .{format}")
    elif not path.exists() and not path.parent.is_dir():
        raise OptionError("there is no such folder", where="--out", got=str(path.parent), mend="make it first")
    return path
