"""`rankdrop reproduce`: the source documents, item by item.

On the terminal a table per document, and under it why items do not simply agree.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop.cli import exits

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

    from rankdrop.reproduce.item import Item
    from rankdrop.reproduce.run import Reproduction


def reproduce(
    document: str = "all",
    /,
    *,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    markdown: str | None = None,
    figures: str | None = None,
    full: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Reproduce the tables, figures, numbers and claims of the five source documents.

    AM: Almarkhi and Maciejewski; ML: Memon's lecture; GR: Gallardo-Alvarado
    and Rico-Martínez; KG: dependent-screw suppression, Canadarm2; JL: Jin's
    lecture. Each item has what is printed, what is computed, and a verdict:
    agrees, rounding, erratum (with the reason), or unreproducible (the document
    does not say enough).

    For example:
        rankdrop reproduce GR
        rankdrop reproduce all --json reproduced.json --figures figures

    Exit code 0: every item has one of these verdicts; 3: some item differs
    without a reason; 2: bad input.

    Args:
        document: AM, ML, GR, KG, JL or all.
        json: Write the items to this file as well; - writes them to stdout in place of the table.
        markdown: Write the page docs/reproduced.md to this file.
        figures: Write the figures into this folder as svg, png and json (the numbers in them).
        full: Whole cells, and the reasons of items that agree as well.
        quiet: No progress.
    """
    from rankdrop.cli.terminal import check_targets, hand_over, reporter, write_bytes, write_json
    from rankdrop.reproduce.figures import check_folder, save_figures
    from rankdrop.reproduce.run import markdown as as_page
    from rankdrop.reproduce.run import names
    from rankdrop.reproduce.run import reproduce as run

    check_targets({"--json": json, "--markdown": markdown}, {"--markdown": (".md",)})
    wanted = names(document)
    if figures is not None:
        check_folder(figures)
    with reporter(quiet=quiet) as report:
        found = run(document, progress=report)
        if figures is not None and found.complete:
            save_figures(wanted, figures, progress=report)
    hand_over(
        lambda: print_reproduction(found, full=full),
        (json, lambda target: write_json(found.to_dict(), target)),
        (markdown, lambda target: write_bytes(as_page(found).encode(), target)),
    )
    if not found.complete:
        return exits.INTERRUPTED
    return exits.DIFFERS if found.differs else exits.FINE


_LONGEST = 90  # characters of a cell; --full, the JSON and the page have all of it
_STYLES = {"rounding": "cyan", "erratum": "yellow", "unreproducible": "dim", "differs": "bold red"}


def print_reproduction(reproduction: Reproduction, *, full: bool) -> None:
    """Print to stdout.

    Args:
        reproduction: what was reproduced.
        full: whole cells, and the reasons of items that agree as well.
    """
    from rankdrop.cli.terminal import results, show

    show(results(), _parts(reproduction, full))


def _parts(reproduction: Reproduction, full: bool) -> Iterator[RenderableType]:
    from rich.padding import Padding
    from rich.text import Text

    from rankdrop.reproduce.item import Verdict, count_words
    from rankdrop.reproduce.run import DOCUMENTS

    for name in reproduction.documents:
        items = reproduction.of(name)
        yield Text.assemble((f"{name}  ", "bold"), DOCUMENTS[name])
        yield Padding(Text(count_words(reproduction.counts(name)) or "nothing was reproduced"), (0, 0, 1, 4))
        yield _table(items, full)
        for item in items:
            if item.reason and (full or item.verdict is not Verdict.AGREES):
                head = (f"{item.verdict}: ", _STYLES.get(item.verdict, ""))
                yield Padding(Text.assemble(head, f"{item.item}, {item.about}: {item.reason}"), (0, 0, 0, 2))
        yield ""
    if len(reproduction.documents) > 1:
        yield Text.assemble(("All five  " if len(reproduction.documents) == 5 else "All  ", "bold"),
            count_words(reproduction.counts()))
    if not reproduction.complete:
        yield "Interrupted: the parts that were done."


def _table(items: tuple[Item, ...], full: bool) -> Table:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, expand=True)
    for title, ratio in (("item", 3), ("what", 5), ("printed", 5), ("ours", 5)):
        table.add_column(title, ratio=ratio, overflow="fold")
    table.add_column("verdict", min_width=8, overflow="fold")
    for item in items:
        verdict = Text(str(item.verdict), style=_STYLES.get(item.verdict, ""))
        table.add_row(item.item, *(_cut(text, full) for text in (item.about, item.printed, item.ours)), verdict)
    return table


def _cut(text: str, full: bool) -> str:
    flat = " ".join(text.split())
    return flat if full or len(flat) <= _LONGEST else f"{flat[: _LONGEST - 1]}…"
