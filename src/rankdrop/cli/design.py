"""The commands sweep and compare: variants of an arm, and arms side by side, measured for the same task."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rankdrop import designs, jobs
from rankdrop.cli import exits
from rankdrop.cli.command import DRAWN, OUTPUT, PAGES, PROGRESS, Done, Output, command
from rankdrop.cli.opening import TASKS
from rankdrop.cli.targets import kept_work, write_text
from rankdrop.cli.terminal import STDOUT, fit_to_console, say
from rankdrop.errors import OptionError
from rankdrop.options import Options, option

if TYPE_CHECKING:
    from rankdrop.cli.terminal import Block


@dataclass(frozen=True)
class SweepOptions(Options):
    """Where a sweep works, and the files of its result."""

    example: Annotated[
        str | None, option("Write a plan to try: eight variants of a UR5; nothing is measured", writes=(".toml",))
    ] = None  # fmt: skip
    out: Annotated[
        str | None,
        option("Folder for finished parts, with a journal: after an interruption run the same command to continue"),
    ] = None
    parquet: Annotated[bool, option("Write the tables `variants` and `families` as Parquet into --out")] = False
    figure: Annotated[
        str | None, option("Draw every measure as a map over two parameters: .svg, .png or .pdf", writes=DRAWN)
    ] = None  # fmt: skip
    html: Annotated[
        str | None, option("Write a page that stands alone, with maps and every variant: .html", writes=PAGES)
    ] = None  # fmt: skip
    over: Annotated[str | None, option("The two parameters of the maps: upper_arm,offset; else the first two")] = None
    every: Annotated[bool, option("Every variant in the table, not only the Pareto-optimal ones", name="--all")] = False
    precision: (
        Annotated[float, option("Standard error of sampled shares, such as 0.002: takes as many samples as it needs")]
        | None
    ) = None
    workers: Annotated[int, option("Local processes; 0: one for every processor")] = 0
    scheduler: Annotated[
        str | None, option("Address of a Dask scheduler; its workers do the work (tcp://HOST:8786)")
    ] = None
    status: Annotated[str | None, option("Only report the progress of the sweep in this folder")] = None

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the parameters of the maps; none for the first two."""
        if self.over:
            return tuple(word.strip() for word in self.over.split(","))
        return ()


@command
def sweep(
    spec: Annotated[str | None, Parameter(help="File with the arm, the parameters, and the question (.toml).")] = None,
    /,
    *,
    options: SweepOptions = SweepOptions(),
    output: Output = OUTPUT,
    report: PROGRESS,
) -> Done | int:
    """Measure many variants of an arm.

    Lengths, angles, offsets, base or tool are parameters. Per variant what the file asks for: families, and how they
    differ from the neighbour's; the share of the joint space near them; the number of aspects; σ over a region or on
    paths; the share proven free. Then the Pareto-optimal variants: those not dominated by any other by more than the
    error of the samples. How to write the file: docs/howto/comparing-designs.md.

    For example:
        rankdrop sweep --example designs.toml
        rankdrop sweep designs.toml
        rankdrop sweep designs.toml --out designs --parquet --html designs.html
        rankdrop sweep designs.toml --figure maps.svg --over upper_arm,offset
        rankdrop sweep designs.toml --out designs --scheduler tcp://10.0.0.1:8786
        rankdrop sweep --status designs

    Exit code 0: every variant was measured, its families verified; 3: some were not; 130: interrupted, with --out the
    same command continues; 2: bad input.
    """
    from rankdrop import sweep as run
    if options.status is not None:
        write_text(f"{jobs.progress_of(options.status).sentence}\n", STDOUT)
        return exits.FINE
    if options.example is not None:
        return _example(spec, options.example, quiet=output.quiet)
    name = _check_options(spec, options)
    try:
        result = run(name, out=options.out, workers=options.workers, scheduler=options.scheduler,
                    precision=options.precision, report=report)  # fmt: skip
    except KeyboardInterrupt:
        say(f"interrupted: {kept_work(options.out)}")
        return exits.INTERRUPTED

    def figure() -> bytes:
        from rankdrop.report.design_page import design_figure
        from rankdrop.report.figures import render

        assert options.figure is not None
        return render(design_figure(result, options.axes), options.figure.rpartition(".")[2].lower())

    def page() -> str:
        from rankdrop.report.design_page import design_page

        return design_page(result, options.axes)

    def tables() -> None:
        if options.parquet:
            say("Parquet: {}, {}".format(*designs.write_tables(result, str(options.out))))

    files = {"json": result.to_dict, "figure": figure, "html": page}
    return Done(lambda: result.sections(every=options.every), files, holds=result.holds, last=tables)


def _example(spec: str | None, target: str, *, quiet: bool) -> int:
    """Write a plan to try.

    Raises:
        OptionError: a plan is named as well, or the ending names no format.
    """
    if spec is not None:
        raise OptionError("no plan is measured with this option", where="--example", got=spec,
                          mend=f"rankdrop sweep --example {target}")  # fmt: skip
    write_text(designs.EXAMPLE, target)
    if not quiet:
        say(f"{target}: 8 variants; measure them: rankdrop sweep {target}")
    return exits.FINE


def _check_options(spec: str | None, options: SweepOptions) -> str:
    """The specification, where the options agree.

    Raises:
        OptionError: no specification, or no folder for what needs one.
    """
    if spec is None:
        raise OptionError("no specification is named", where="SPEC",
                          allowed="a .toml file, or --status FOLDER; --example FILE writes a plan to try")  # fmt: skip
    if options.out == STDOUT:
        raise OptionError("parts are not printed", where="--out", got=options.out, allowed="a folder")
    if options.parquet and options.out is None:
        raise OptionError("the tables need a folder", where="--parquet", mend="name one with --out")
    if options.parquet:
        designs.check_tables()
    return spec


@dataclass(frozen=True)
class CompareOptions(Options):
    """By which measures arms are compared."""

    full: Annotated[bool, option("Print every family of every arm")] = False
    task: Annotated[str | None, option(f"{TASKS}; else the first arm's")] = None
    within: Annotated[str, option("Report the share of the joint space within this distance of singularities")] = "5deg"
    speed: Annotated[
        str | None,
        option("Report the shares inside the limits, and of the box, where the tool is slower along a line (25mm/s)"),
    ] = None
    lower: Annotated[str | None, option("Corner of a box of the workspace, in the base frame: x,y,z [m]; 300mm")] = None
    upper: Annotated[str | None, option("The opposite corner")] = None
    rpy: Annotated[str | None, option("Orientation of the tool in the box: roll,pitch,yaw; else any")] = None
    points: Annotated[int, option("Poses in the box", ge=1)] = 100
    path: Annotated[tuple[str, ...], option("File of tool poses (see `rankdrop path`). May be given again")] = ()
    certified: Annotated[
        str | None,
        option("Prove free what can be proven, with boxes of this width, such as 0.2; seconds to minutes an arm"),
    ] = None
    limits: Annotated[bool, option("Within the joint limits only")] = False
    length_scale: (
        Annotated[
            float, option("Translation rows are divided by it for every arm; else by the largest reach", unit="m")
        ]
        | None
    ) = None
    as_written: Annotated[bool, option("Keep the files' numbers: 1.5708 is no right angle then")] = False
    starts: Annotated[int, option("Random starts for each corank")] = 1000
    seed: Annotated[int, option("Seed of every random choice; the same seed gives the same result")] = 0
    workers: Annotated[int, option("Local processes; 0: one for every processor")] = 0
    scheduler: Annotated[
        str | None, option("Address of a Dask scheduler; its workers do the work (tcp://HOST:8786)")
    ] = None

    def document(self) -> dict[str, Any]:
        """The question, as the tables of a specification.

        Raises:
            OptionError: a corner or an orientation is not three quantities.
        """
        asked: dict[str, Any] = {
            "task": self.task, "length_scale": self.length_scale, "limits": self.limits, "seed": self.seed,
            "as_written": self.as_written, "families": {"starts": self.starts, "fresh": 1000}, "aspects": {},
            "near": {"within": self.within},
        }  # fmt: skip
        if self.speed is not None:
            asked["slow"] = {"speed": self.speed, "turn_speed": 0.0}  # straight lines alone, as analyze --speed
        if self.lower is not None or self.upper is not None:
            region = {"lower": _three(self.lower, "--lower"), "upper": _three(self.upper, "--upper")}
            if self.rpy is None:
                turned = {}
            else:
                turned = {"rpy": _three(self.rpy, "--rpy")}
            if self.speed is None:
                speed = {}
            else:
                speed = {"speed": self.speed}
            asked["region"] = {**region, "points": self.points, **turned, **speed}
        if self.path:
            asked["paths"] = {"files": list(self.path)}
        if self.certified is not None:
            asked["certified"] = {"width": self.certified}
        return asked


@command
def compare(
    *arms: Annotated[str, Parameter(help="Names in the catalogue (`rankdrop robots`) or files.")],
    options: CompareOptions = CompareOptions(),
    output: Output = OUTPUT,
    report: PROGRESS,
) -> Done:
    """Compare arms for the same task.

    Two to ten arms, by the same measures: families, aspects, the share of the joint space near singularities, and on
    request σ over a box of the workspace, on tool paths, and the share proven free. σ is divided by one length scale
    for all of them.

    For example:
        rankdrop compare ur5e gp7 irb1200
        rankdrop compare ur5 my_arm.urdf --limits --within 10deg
        rankdrop compare ur5e ur10e --lower 0.3,-0.3,0.1 --upper 0.6,0.3,0.5 --rpy 180deg,0,0
        rankdrop compare ur5e crx10ia --path weld.csv --json arms.json

    Exit code 0: every arm was measured, its families verified; 3: some were not; 2: bad input.
    """
    result = designs.compare(arms, options.document(), workers=options.workers, scheduler=options.scheduler,
                                 report=report)  # fmt: skip
    def blocks() -> Iterable[Block]:
        sections = list(result.sections(full=options.full))
        if options.full:
            return sections
        return fit_to_console(sections, cut=[sections[-1]])

    return Done(blocks, {"json": result.to_dict}, holds=result.holds)


def _three(text: str | None, option: str) -> list[float | str]:
    if text is None:
        words = []
    else:
        words = [word.strip() for word in text.split(",")]
    if len(words) != 3:
        raise OptionError("it is three numbers", where=option, got=text, allowed="such as 0.3,-0.3,0.1")
    return list(words)
