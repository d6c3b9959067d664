"""Reproduce the five source documents, item by item: `python -m papers AM` from a checkout.

A table per document, then the reasons of the items that do not simply agree. Exit code 0: every item agrees or is
explained; 3: some item differs without a reason; 2: bad input; 130: interrupted, the finished parts are printed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from rich import box
from rich.console import Console, RenderableType
from rich.padding import Padding
from rich.progress import Progress
from rich.table import Table
from rich.text import Text

from papers.figures import check_folder, save_figures
from papers.item import Item, Verdict, count_words
from papers.run import ALL, DOCUMENTS, Reproduction, markdown, names, reproduce
from rankdrop.disk import replace_file
from rankdrop.errors import RankdropError
from rankdrop.results import json_text

LONGEST_CELL = 90  # characters; --full, the JSON and the page have all of them
STYLES = {"rounding": "cyan", "erratum": "yellow", "unreproducible": "dim", "differs": "bold red"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Compute, print and write what the command line names; return the exit code."""
    options = _parser().parse_args(arguments)
    try:
        documents = names(options.document)
        if options.figures is not None:
            check_folder(options.figures)
        with Progress(console=Console(stderr=True), transient=True, disable=options.quiet) as bar:
            task = bar.add_task("reproduce")
            result = reproduce(
                options.document,
                progress=lambda label, done, total: bar.update(task, description=label, completed=done, total=total),
            )
            if options.figures is not None and result.complete:
                save_figures(documents, options.figures)
        if options.markdown is not None:
            replace_file(options.markdown, markdown(result).encode())
        if options.json == "-":
            sys.stdout.write(json_text(result.to_dict()))
        else:
            Console().print(*_tables(result, full=options.full), sep="\n")
            if options.json is not None:
                replace_file(options.json, json_text(result.to_dict()).encode())
    except (RankdropError, OSError) as error:
        print(f"papers: {error}", file=sys.stderr)
        return 2
    if not result.complete:
        return 130
    return 3 if result.differs else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m papers", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)  # fmt: skip
    parser.add_argument("document", nargs="?", default=ALL, help=f"{', '.join(DOCUMENTS)} or {ALL} (the default)")
    parser.add_argument("--json", metavar="FILE", help="write the items as JSON; - for standard output")
    parser.add_argument("--markdown", metavar="FILE", type=Path, help="write the page docs/reproduced.md")
    parser.add_argument("--figures", metavar="FOLDER", help="write the figures as svg, png and json")
    parser.add_argument("--full", action="store_true", help="whole cells, and the reasons of items that agree")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    return parser


def _tables(result: Reproduction, *, full: bool) -> Iterator[RenderableType]:
    for name in result.documents:
        items = result.of(name)
        yield Text.assemble((f"{name}  ", "bold"), DOCUMENTS[name])
        yield Padding(Text(count_words(result.counts(name)) or "no items"), (0, 0, 1, 4))
        yield _table(items, full)
        for item in items:
            if item.reason and (full or item.verdict is not Verdict.AGREES):
                head = (f"{item.verdict}: ", STYLES.get(item.verdict, ""))
                yield Padding(Text.assemble(head, f"{item.item}, {item.about}: {item.reason}"), (0, 0, 0, 2))
    if len(result.documents) > 1:
        yield Text.assemble(("All  ", "bold"), count_words(result.counts()))
    if not result.complete:
        yield Text("Interrupted: the finished parts only.")


def _table(items: Sequence[Item], full: bool) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, expand=True)
    for title, ratio in (("item", 3), ("what", 5), ("printed", 5), ("ours", 5)):
        table.add_column(title, ratio=ratio, overflow="fold")
    table.add_column("verdict", min_width=8, overflow="fold")
    for item in items:
        cells = (Text(_shorten(text, full)) for text in (item.about, item.printed, item.ours))
        table.add_row(Text(item.item), *cells, Text(str(item.verdict), style=STYLES.get(item.verdict, "")))
    return table


def _shorten(text: str, full: bool) -> str:
    flat = " ".join(text.split())
    return flat if full or len(flat) <= LONGEST_CELL else f"{flat[: LONGEST_CELL - 1]}…"


if __name__ == "__main__":
    sys.exit(main())
