"""`rankdrop robots`: the arms of the catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import command
from rankdrop.cli.terminal import STDOUT, results, show, write_json

if TYPE_CHECKING:
    from rankdrop.robot import CatalogEntry

_NO_MAKER = "Documents"


@command
def robots(
    text: Annotated[str, Parameter(help="Only arms whose name, maker or description hold these words.")] = "",
    /,
    *,
    json: Annotated[
        bool, Parameter(negative=(), help="Print the list as JSON, with the source of each arm's numbers.")
    ] = False,
    quiet: Annotated[bool, Parameter(negative=(), help="No progress.")] = False,
) -> int:
    """List the arms of the catalogue.

    Their names stand in place of a file; the list is sorted by maker.

    For example:
        rankdrop robots
        rankdrop robots fanuc
        rankdrop robots "7R spherical shoulder"
        rankdrop robots --json

    Exit code 0: some arm fits; 3: none does, and similar names are listed.
    """
    from dataclasses import asdict

    from rankdrop.robot import search_catalog

    entries = search_catalog(text)
    if json:
        write_json([asdict(entry) for entry in entries], STDOUT)
    else:
        _print(entries, text)
    return exits.FINE if entries else exits.UNEXPLAINED


def _print(entries: Sequence[CatalogEntry], text: str) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text


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
    hint = "Or give a file: URDF, xacro, MJCF, or a DH or screw table in TOML. Where the numbers come from: --json."
    show(results(), [table, "", hint] if entries else [f"No arm of the catalogue fits {text!r}{_similar(text)}."])


def _similar(text: str) -> str:
    from difflib import get_close_matches

    from rankdrop.robot import search_catalog

    words = {word for entry in search_catalog("") for word in (entry.name, entry.maker.lower()) if word}
    similar = get_close_matches(text.lower(), sorted(words), n=5, cutoff=0.5)
    return f"; similar: {', '.join(similar)}" if similar else "; a file does as well as a name"
