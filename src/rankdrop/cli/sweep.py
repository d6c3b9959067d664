"""`rankdrop sweep`: variants of an arm, measured for the same task."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import Whole

if TYPE_CHECKING:
    from rankdrop.designs import Designs


def sweep(
    spec: str | None = None,
    /,
    *,
    out: str | None = None,
    parquet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    figure: str | None = None,
    html: str | None = None,
    over: Annotated[str | None, Parameter(show_default=False)] = None,
    all: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    precision: float | None = None,
    workers: Whole = 0,
    scheduler: str | None = None,
    status: str | None = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Measure many variants of an arm: lengths, angles, offsets, base or tool as parameters.

    Per variant what the file asks for: families, and how they differ from the
    neighbour's; the share of the joint space near them; σ over a region or on
    paths; the share proven free. Then the Pareto-optimal variants: those that
    no other one dominates by more than the error of the samples.
    How to write the file: docs/howto/comparing-designs.md.

    For example:
        rankdrop sweep designs.toml
        rankdrop sweep designs.toml --out designs --parquet --html designs.html
        rankdrop sweep designs.toml --figure maps.svg --over upper_arm,offset
        rankdrop sweep designs.toml --out designs --scheduler tcp://10.0.0.1:8786
        rankdrop sweep --status designs

    Exit code 0: every variant was measured, its families verified; 3: some were
    not; 130: interrupted, with --out the same command goes on; 2: bad input.

    Args:
        spec: The file that says which arm, which parameters, and what is asked (.toml).
        out: Folder for finished parts, with a journal: after an interruption, of any kind, the same command goes on.
        parquet: Write the tables `variants` and `families` as Parquet into the folder --out.
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        figure: Draw every measure as a map over two parameters: .svg, .png or .pdf.
        html: Write a page that stands alone, with maps and every variant: .html.
        over: The two parameters of the maps, such as upper_arm,offset. Default: the first two.
        all: Every variant in the table, not only the Pareto-optimal ones.
        precision: Standard error of sampled shares, such as 0.002: takes as many samples as it needs.
        workers: Local processes; 0: one for every processor. The result does not depend on it.
        scheduler: Address of a Dask scheduler, whose workers do the work (tcp://HOST:8786).
        status: Only say how far the sweep in this folder is.
        quiet: No progress.
    """
    from rankdrop import sweep as run
    from rankdrop.cli.terminal import STDOUT, check_targets, hand_over, reporter, write_json, write_text
    from rankdrop.jobs import progress_of

    if status is not None:
        write_text(f"{progress_of(status).sentence}\n", STDOUT)
        return exits.FINE
    check_targets(
        {"--json": json, "--figure": figure, "--html": html},
        {"--figure": (".svg", ".png", ".pdf"), "--html": (".html", ".htm")},
    )
    name = _check(spec, out, parquet)
    axes = tuple(word.strip() for word in over.split(",")) if over else ()
    try:
        with reporter(quiet=quiet) as report:
            found = run(name, out=out, workers=workers, scheduler=scheduler, precision=precision, report=report)
    except KeyboardInterrupt:
        return _interrupted(out)
    hand_over(
        lambda: _print(found, every=all),
        (json, lambda target: write_json(found.to_dict(), target)),
        (figure, lambda target: _draw(found, axes, target)),
        (html, lambda target: _page(found, axes, target)),
        (out if parquet else None, lambda folder: _tables(found, folder)),
    )
    return exits.FINE if found.holds else exits.UNEXPLAINED


def _check(spec: str | None, out: str | None, parquet: bool) -> str:
    from rankdrop.cli.terminal import STDOUT
    from rankdrop.designs import check_tables
    from rankdrop.errors import OptionError

    if spec is None:
        raise OptionError("no specification is named", where="SPEC", allowed="a .toml file, or --status FOLDER")
    if out == STDOUT:
        raise OptionError("parts are not printed", where="--out", got=out, allowed="a folder")
    if parquet and out is None:
        raise OptionError("the tables need a folder", where="--parquet", mend="name one with --out")
    if parquet:
        check_tables()
    return spec


def _interrupted(out: str | None) -> int:
    from rankdrop.cli.terminal import say

    say(f"interrupted: {f'what is done is kept in {out}: the same command goes on there' if out else '--out keeps it'}")
    return exits.INTERRUPTED


def _print(designs: Designs, *, every: bool) -> None:
    from rankdrop.cli.terminal import print_sections

    print_sections(designs.sections(every=every))


def _draw(designs: Designs, axes: tuple[str, ...], target: str) -> None:
    from io import BytesIO
    from pathlib import Path

    from rankdrop.cli.terminal import write_bytes
    from rankdrop.report.design_figure import design_figure

    buffer = BytesIO()
    design_figure(designs, axes).savefig(buffer, format=Path(target).suffix[1:].lower(), dpi=200)
    write_bytes(buffer.getvalue(), target)


def _page(designs: Designs, axes: tuple[str, ...], target: str) -> None:
    from rankdrop.cli.terminal import write_text
    from rankdrop.report.design_page import design_page

    write_text(design_page(designs, axes), target)


def _tables(designs: Designs, out: str) -> None:
    from rankdrop.cli.terminal import say
    from rankdrop.designs import write_tables

    variants, families = write_tables(designs, out)
    say(f"Parquet: {variants}, {families}")
