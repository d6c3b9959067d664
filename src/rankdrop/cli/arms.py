"""The commands robots, monitor and jacobian: the catalogue; an arm as a C header; the Jacobian seen from a link."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop import results, verbs
from rankdrop import robot as catalogue
from rankdrop.cli import exits
from rankdrop.cli.command import OUTPUT, PROGRESS, Done, Output, command
from rankdrop.cli.opening import NO_OPTIONS, ROBOT, ArmOptions, open_arm
from rankdrop.cli.targets import check_target, write_text
from rankdrop.cli.terminal import fit_to_console
from rankdrop.cli.values import parse_configuration
from rankdrop.errors import OptionError
from rankdrop.options import Options, option

if TYPE_CHECKING:
    from rich.console import RenderableType

    from rankdrop.cli.terminal import Block

_NO_MAKER = "Documents"
_FEW = 6  # lines of a section that is printed whole


@command
def robots(
    text: Annotated[str, Parameter(help="Only arms with these words in name, maker or description.")] = "",
    /,
    *,
    output: Output = OUTPUT,
) -> Done:
    """List the arms of the catalogue.

    Their names stand in place of a file; the list is sorted by maker. JSON has the source of each arm's numbers as
    well; without a file name, --json prints it.

    For example:
        rankdrop robots
        rankdrop robots fanuc
        rankdrop robots "7R spherical shoulder"
        rankdrop robots fanuc --json fanuc.json

    Exit code 0: some arm fits; 3: none does, and similar names are listed.
    """
    entries = catalogue.search_catalog(text)
    files = {"json": lambda: [asdict(entry) for entry in entries]}
    return Done(lambda: [_list_entries(entries, text)], files, holds=bool(entries))


def _list_entries(entries: Sequence[catalogue.CatalogEntry], text: str) -> Iterator[RenderableType]:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    if not entries:
        yield f"No arm of the catalogue fits {text!r}{_similar(text)}."
        return
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("name", no_wrap=True)
    table.add_column("joints", justify="right")
    table.add_column("task", no_wrap=True)
    table.add_column("what it is")
    for maker in sorted({entry.maker for entry in entries}, key=lambda maker: (not maker, maker.casefold())):
        table.add_row(Text(maker or _NO_MAKER, style="bold"))
        for entry in entries:
            if entry.maker == maker:
                table.add_row(f"  {entry.name}", str(entry.n), entry.task, entry.about)
    hint = f"Or give a file: {catalogue.format_names()}. Where the numbers come from: --json."
    yield from (table, "", hint)


def _similar(text: str) -> str:
    words: set[str] = set()
    for entry in catalogue.search_catalog(""):
        words |= {entry.name, entry.maker.lower()} - {""}
    similar = get_close_matches(text.lower(), sorted(words), n=5, cutoff=0.5)
    if similar:
        return f"; similar: {', '.join(similar)}"
    return "; a file does as well as a name"


@dataclass(frozen=True)
class MonitorOptions(Options):
    """What the header holds."""

    start: Annotated[float, option("Distance at which motion towards a family begins to be slowed", unit="rad")] = 0.2
    stop: Annotated[float, option("Distance at which it is stopped", unit="rad")] = 0.02
    mark: Annotated[str | None, option("Part of the constant's name; else made of the robot's")] = None
    analysis: Annotated[
        str | None, option("Families from this file (rankdrop analyze --json); else those shipped, else computed now")
    ] = None
    starts: Annotated[int, option("Random starts of an analysis that is made now")] = 10_000
    quiet: Annotated[bool, option("No progress")] = False


@command
def monitor(
    robot: ROBOT,
    /,
    *,
    header: Annotated[str, Parameter(help="The file to write; - for stdout.", allow_leading_hyphen=True)],
    options: MonitorOptions = MonitorOptions(),
    arm: ArmOptions = NO_OPTIONS,
    report: PROGRESS,
) -> int:
    """Write an arm and its families as a C header.

    The header holds one constant, rankdrop_MARK_arm. With rankdrop/monitor.hpp (C++17) or rankdrop/monitor.h (C) it
    reports at every configuration: rank, families with residual, distance and gradient, lost directions, how fast a
    motion may continue, and an internal motion away. No Python is needed there. Where headers and CMake package are:
    python -m rankdrop.headers --cmake-dir.

    For example:
        rankdrop monitor ur5e --header ur5e.h
        rankdrop monitor arm.urdf --tip flange --header arm.h --start 10deg --stop 1deg

    Exit code 0: written; 2: bad input.
    """
    from rankdrop import Monitor, analyze

    check_target(header, "--header")
    model, task = open_arm(robot, arm)
    if options.analysis is None:
        analysis = results.known_analysis(model, task)
    else:
        analysis = results.Analysis.load(options.analysis)
    if analysis is None:
        analysis = analyze(model, task, starts=options.starts, progress=report)
    watched = Monitor(model, task, analysis.families, start=options.start, stop=options.stop)
    write_text(watched.header(options.mark), header)
    return exits.FINE


@dataclass(frozen=True)
class JacobianOptions(Options):
    """Which Jacobian, and in which form."""

    frame: Annotated[
        int, option("Link that gives the axes, from 1: z along its joint's axis, x along the common normal after it; "
                    "else the one that makes the matrix shortest")
    ] | None = None  # fmt: skip
    at: Annotated[str, option("Reference point: tip, or a link from 1: the origin of its frame")] = "tip"
    q: Annotated[str | None, option("A configuration [rad, m]; pi/2, 30deg, 120mm are understood")] = None
    deg: Annotated[bool, option("Angles without a unit are in degrees")] = False
    symbolic: Annotated[bool, option("The closed form in addition to the numbers of --q")] = False
    inverse: Annotated[bool, option("The inverse as well, for as many rows as joints")] = False
    full: Annotated[bool, option("Print every entry, however many lines they take")] = False
    lengths: Annotated[str, option('auto, letters, numbers, or letters with their values: "a=0.635,d=120mm"')] = "auto"
    time_limit: Annotated[float, option("Limit for the closed inverse", unit="s", gt=0)] = 60.0
    latex: Annotated[
        str | None, option("Write the closed forms as LaTeX to this file; - for stdout", writes=())
    ] = None  # fmt: skip


@command
def jacobian(
    robot: ROBOT,
    /,
    *,
    options: JacobianOptions = JacobianOptions(),
    arm: ArmOptions = NO_OPTIONS,
    output: Output = OUTPUT,
) -> Done:
    """Write the Jacobian of a link's frame, and its inverse.

    In closed form, with letters for the lengths where that is possible; with --q in numbers, with --q and --symbolic
    both. The linear part is the velocity of the tip, or with --at of the point of the end effector that is at the
    origin of a link's frame.

    For example:
        rankdrop jacobian planar2r --frame 1 --inverse
        rankdrop jacobian canadarm2 --frame 5 --at 5
        rankdrop jacobian puma560 --frame 3 --at 5 --inverse --latex puma.tex
        rankdrop jacobian ur5 --frame 4 --deg --q 0,-90,60,0,80,0 --inverse

    Exit code 0: all checks hold; 3: one fails, or there is no inverse because the configuration is singular; 2: bad
    input.
    """
    if options.latex is not None and options.q is not None and not options.symbolic:
        raise OptionError("numbers are not written as LaTeX", where="--latex", mend="give --symbolic as well")
    at = _reference_point(options.at.strip())
    model, task = open_arm(robot, arm)
    result = verbs.link_jacobian(
        model, options.frame, task, at=at,
        q=None if options.q is None else parse_configuration(options.q, model, deg=options.deg),
        symbolic=options.symbolic or options.q is None, inverse=options.inverse,
        lengths=catalogue.read_lengths(options.lengths), seconds=options.time_limit / 3.0,
    )  # fmt: skip
    missing = options.inverse and result.numbers is not None and result.numbers.inverse is None

    def blocks() -> Sequence[Block]:
        sections = result.sections()
        if options.full:
            return sections
        return fit_to_console(sections, cut=[section for section in sections if len(section.lines) > _FEW])

    return Done(blocks, {"latex": result.latex, "json": result.to_dict}, holds=result.holds and not missing)


def _reference_point(text: str) -> int | None:
    """The link at the origin of which the reference point is; None for the tip.

    Raises:
        OptionError: it names neither.
    """
    if text == "tip":
        return None
    if not text.isdecimal():
        raise OptionError("this is no reference point", where="--at", got=repr(text), allowed="tip, or a link from 1")
    return int(text)
