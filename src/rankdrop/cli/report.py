"""`rankdrop report`: a page that stands alone, or figures for papers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from rankdrop import results
from rankdrop import robot as arms
from rankdrop.cli import exits
from rankdrop.cli.command import OUTPUT, PROGRESS, Output, command
from rankdrop.cli.opening import NO_IDEAL, ROBOT_FILES, IdealOptions, open_ideal
from rankdrop.cli.targets import check_different, check_target, write_bytes, write_json
from rankdrop.cli.terminal import Report, say
from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.options import Options, option
from rankdrop.questions import AnalyzeOptions

if TYPE_CHECKING:
    from rankdrop.report.content import Content

_ANALYSIS = ".json"


@dataclass(frozen=True)
class ReportOptions(Options):
    """Written files."""

    out: Annotated[
        str | None,
        option("File of the page; for figures a folder, or a file for one. Default: ROBOT.html, ROBOT-figures"),
    ] = None
    format: Annotated[
        Literal["html", "pdf", "png", "svg"], option("html is the page; pdf, png and svg are figures for a paper")
    ] = "html"
    figure: Annotated[
        tuple[str, ...], option("arm, slice, solid, workspace, image or lines; of one family: lines-k1.f1. May be "
                                "given again. Default: all of them")
    ] = ()  # fmt: skip
    exact_seconds: Annotated[float, option("Limit for the exact conditions; 0 leaves them out", unit="s", ge=0)] = 8.0
    no_meshes: Annotated[bool, option("Draw links as rods though the robot's file has shapes of them")] = False

    def target(self, default: str) -> Path:
        """Where to write.

        Raises:
            OptionError: nothing can be written there; found before the work.
        """
        paper = self.format != "html"
        if paper:
            out = self.out or f"{default}-figures"
        else:
            out = self.out or f"{default}.html"
        path = Path(out)
        if not paper or path.suffix.lower() == f".{self.format}":
            check_target(out, "--out", () if paper else (".html", ".htm"))
        elif path.exists() and not path.is_dir():
            allowed = f"a folder, or a name ending in .{self.format}"
            raise OptionError("it is a file", where="--out", got=out, allowed=allowed)
        elif not path.exists() and not path.parent.is_dir():
            raise OptionError("there is no such folder", where="--out", got=str(path.parent), mend="make it first")
        return path


@command
def report(
    robot: Annotated[str, Parameter(
        help=f"Name in the catalogue, file ({ROBOT_FILES}), or analysis (.json, `rankdrop analyze`)."
    )],
    /,
    *,
    page: ReportOptions = ReportOptions(),
    options: AnalyzeOptions = AnalyzeOptions(),
    arm: IdealOptions = NO_IDEAL,
    output: Output = OUTPUT,
    report: PROGRESS,
) -> int:  # fmt: skip
    """Write a page about an arm, or figures for papers.

    The page has the arm in 3-D with sliders, at every family's witness the directions lost and the axes to blame, the
    tables of conditions, the exact conditions, slices of joint space, the workspace, σ along lines, and how everything
    was verified. It loads nothing from anywhere.

    For example:
        rankdrop report pa10 --out pa10.html
        rankdrop report pa10.json --format pdf --figure workspace --out figures

    Exit code 3: a part of the analysis is not explained, not sound or contradicted; the page says which in its first
    line.
    """
    from rankdrop.report.content import content
    from rankdrop.report.figures import check_figures

    paper = page.format != "html"
    _check_files(page, output)
    analysis, made = _analysis(robot, arm, options, report)
    target = page.target(analysis.robot.name.replace("/", "-"))
    if paper:
        check_figures(analysis, page.figure)
    plain = page.no_meshes or paper or robot.lower().endswith(_ANALYSIS)
    shown = content(
        analysis, exact=not paper and page.exact_seconds > 0, exact_seconds=page.exact_seconds,
        seed=options.seed, made=made, progress=report,
        meshes=() if plain else _meshes(analysis, arm, quiet=output.quiet),
    )  # fmt: skip
    for path in _write(shown, page, target):
        if not output.quiet:
            say(f"wrote {path}")
    if output.json is not None:
        write_json(analysis.to_dict(), output.json)
    return _code(shown, analysis)


def _check_files(page: ReportOptions, output: Output) -> None:
    """Refuse files that cannot be written, before the work.

    Raises:
        OptionError: figures of a page, a target that cannot be written, or one file for two things.
    """
    if page.figure and page.format == "html":
        raise OptionError("figures are files", where="--figure", got=page.figure[0],
                          mend="add --format pdf, png or svg")  # fmt: skip
    if page.out is not None:
        page.target("")
    check_different({"--out": page.out, "--json": output.json})


def _code(shown: Content, analysis: results.Analysis) -> int:
    """The exit code of a page; where it was cut short that is said."""
    if shown.interrupted or not analysis.complete:
        say("interrupted: the page says what was done")
        return exits.INTERRUPTED
    if shown.verdict.holds:
        return exits.FINE
    return exits.UNEXPLAINED


def _analysis(
    robot: str, arm: IdealOptions, options: AnalyzeOptions, report: Report
) -> tuple[results.Analysis, results.Idealised | None]:
    from rankdrop import analyze

    plain = options == AnalyzeOptions(starts=options.starts, seed=options.seed, threads=options.threads)
    if robot.lower().endswith(_ANALYSIS):
        if arm != NO_IDEAL or not plain:
            raise OptionError("an analysis has its arm, task and limits already", where=robot,
                              mend="leave the options out")  # fmt: skip
        return results.Analysis.load(robot), None
    model, task, made = open_ideal(robot, arm)
    if arm.length_scale is None and plain:
        known = results.known_analysis(model, task)
    else:
        known = None
    return known or analyze(model, task, options, progress=report), made


def _write(shown: Content, page: ReportOptions, target: Path) -> list[Path]:
    from rankdrop.report.figures import figure_names, figures
    from rankdrop.report.page import page as whole_page

    if page.format == "html":
        write_bytes(whole_page(shown).encode(), str(target))
        return [target]
    names = figure_names(shown, page.figure)
    single = target.suffix.lower() == f".{page.format}"
    if single and len(names) > 1:
        raise OptionError("one file holds one figure", where="--out", got=f"{len(names)} figures", mend="give a folder")
    if not single:
        target.mkdir(exist_ok=True)
    paths = []
    for name, drawn in figures(shown, names, page.format):
        paths.append(target if single else target / f"{name}.{page.format}")
        write_bytes(drawn, str(paths[-1]))
    return paths


def _meshes(analysis: results.Analysis, arm: IdealOptions, *, quiet: bool) -> tuple[arms.Mesh, ...]:
    """The shapes of the links that the arm's file has; what cannot be drawn is reported unless it is to be `quiet`."""
    from rankdrop.report.content import simplify_meshes

    visuals, left_out = arms.visuals_of(analysis.robot, arm.packages, arm.arguments)
    try:
        meshes, unread = arms.meshes_of(visuals)
    except MissingExtraError as error:
        meshes, unread = (), (str(error),)
    for note in () if quiet else (*left_out, *unread):
        say(f"not drawn: {note}")
    return simplify_meshes(meshes)
