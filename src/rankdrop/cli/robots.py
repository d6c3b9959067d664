"""`rankdrop robots`: the arms of the catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop.cli import exits

if TYPE_CHECKING:
    from rankdrop.robot import CatalogEntry

_NO_MAKER = "Documents"


def robots(
    text: str = "",
    /,
    *,
    json: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """List the arms that can be named in place of a file, by their makers.

    For example:
        rankdrop robots
        rankdrop robots fanuc
        rankdrop robots "7R spherical shoulder"
        rankdrop robots --json

    Args:
        text: Only arms whose name, maker or description hold these words.
        json: Print the list as JSON: name, maker, about, n, task, source and aliases of every arm.
        quiet: No progress.
    """
    from dataclasses import asdict

    from rankdrop.cli.terminal import STDOUT, write_json
    from rankdrop.robot import search_catalog

    entries = search_catalog(text)
    if json:
        write_json([asdict(entry) for entry in entries], STDOUT)
    else:
        _print(entries, text)
    return exits.FINE


def _print(entries: Sequence[CatalogEntry], text: str) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from rankdrop.cli.terminal import results, show

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("name", no_wrap=True)
    table.add_column("joints", justify="right")
    table.add_column("task", no_wrap=True)
    table.add_column("what it is")
    makers = sorted({entry.maker for entry in entries}, key=lambda maker: (not maker, maker.casefold()))
    for maker in makers:
        table.add_row(Text(maker or _NO_MAKER, style="bold"))
        for entry in entries:
            if entry.maker == maker:
                table.add_row(f"  {entry.name}", str(entry.n), entry.task, entry.about)
    hint = "Or give a file: URDF, xacro, MJCF, or a DH or screw table in TOML. Where the numbers come from: --json."
    none = [f"No arm of the catalogue fits {text!r}; a file does as well as a name."]
    show(results(), [table, "", hint] if entries else none)
