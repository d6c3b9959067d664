"""The command reference: one page for each command, its text the one that `rankdrop COMMAND --help` prints."""

from __future__ import annotations

from io import StringIO
from pathlib import Path

from pages import write_pages
from rich.console import Console
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

from rankdrop.cli.main import app as commands
from rankdrop.cli.main import whole_help

WIDTH = 84  # what a page shows without being scrolled


def names() -> list[str]:
    """The commands, as `rankdrop --help` lists them."""
    return [name for name in commands if not name.startswith("-")]


def help_of(name: str | None = None) -> str:
    """What --help prints, as plain text."""
    whole_help(name or "")
    printed = StringIO()
    console = Console(file=printed, width=WIDTH, color_system=None, force_terminal=False)
    commands.help_print([] if name is None else [name], console=console)
    return "\n".join(line.rstrip() for line in printed.getvalue().strip("\n").splitlines())


def page(name: str) -> str:
    """The page of one command, in Markdown."""
    return f"# rankdrop {name}\n\nWhat `rankdrop {name} --help` prints.\n\n```text\n{help_of(name)}\n```\n"


def index() -> str:
    """The page that lists them."""
    toctree = "\n".join(names())
    return (
        "# Commands\n\nWhat `rankdrop --help` prints; each command has a page of its own. The pages are made from the "
        f"command line itself.\n\n```text\n{help_of()}\n```\n\n```{{toctree}}\n:titlesonly:\n\n{toctree}\n```\n"
    )


def write(app: Sphinx) -> None:
    """Write the pages into the source folder, where they have changed."""
    pages = {f"{name}.md": page(name) for name in names()}
    write_pages(Path(app.srcdir) / "commands", {"index.md": index(), **pages})


def setup(app: Sphinx) -> ExtensionMetadata:
    """Write the pages before the source folder is read."""
    app.connect("builder-inited", write)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
