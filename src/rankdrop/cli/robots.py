"""`rankdrop robots`: the arms of the catalogue."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits


def robots(*, json: Annotated[bool, Parameter(negative=(), show_default=False)] = False) -> int:
    """List the arms that can be named in place of a file.

    For example:
        rankdrop robots
        rankdrop robots --json

    Args:
        json: Print the list as JSON: name, about, n, task and source of every arm.
    """
    from dataclasses import asdict

    from rankdrop.cli.files import STDOUT, write_json
    from rankdrop.robot.open import catalog_entries

    entries = catalog_entries()
    if json:
        write_json([asdict(entry) for entry in entries], STDOUT)
        return exits.FINE

    from rich import box
    from rich.table import Table

    from rankdrop.cli.terminal import results, show

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("name", no_wrap=True)
    table.add_column("joints", justify="right")
    table.add_column("task", no_wrap=True)
    table.add_column("what it is")
    for entry in entries:
        table.add_row(entry.name, str(entry.n), entry.task, entry.about)
    hint = "Or give a file: URDF, xacro, MJCF, or a DH or screw table in TOML. Where the numbers come from: --json."
    show(results(), [table, "", hint])
    return exits.FINE
