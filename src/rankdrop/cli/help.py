"""How is the help of a command printed: its text from a docstring, its options in two columns?"""

from __future__ import annotations

from inspect import cleandoc
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cyclopts.help import HelpEntry, HelpPanel
    from rich.console import Console, ConsoleOptions


def prose(docstring: str) -> str:
    """The text of a docstring without its arguments; paragraphs are as long as they are, indented lines stay."""
    text = cleandoc(docstring).split("\nArgs:")[0].strip()
    parts = text.split("\n\n")
    return "\n\n".join(part if "\n  " in part else " ".join(part.split()) for part in parts)


class Help:
    """Prints a panel of commands or options in two columns, the second one wrapped to the terminal's width."""

    def __call__(self, console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
        from rich.table import Table
        from rich.text import Text

        table = Table.grid(padding=(0, 2, 0, 0))
        table.add_column(overflow="fold", max_width=max(12, console.width // 3))
        table.add_column()
        for entry in panel.entries:
            table.add_row(Text(f"  {_labels(entry)}"), Text(_description(console, entry)))
        if table.row_count:
            console.print(Text(f"{panel.title}:", style="bold"), table, sep="\n")

    def render_usage(self, console: Console, options: ConsoleOptions, usage: object) -> None:
        """The line of how the command is typed."""
        console.print(f"Usage: {usage}", markup=False, highlight=False)


def _labels(entry: HelpEntry) -> str:
    names = sorted((*entry.positive_names, *entry.positive_shorts), key=lambda name: name[:2] != "--")
    return ", ".join(names or entry.display_labels)


def _description(console: Console, entry: HelpEntry) -> str:
    endless = console.options.update(max_width=10_000)
    words = "".join(segment.text for segment in console.render(entry.description or "", endless))
    if entry.choices:
        choices = f" One of {', '.join(entry.choices)}."
    else:
        choices = ""
    if entry.default not in (None, "False", "None", ""):
        default = f" Default: {entry.default}."
    else:
        default = ""
    return f"{' '.join(words.split())}{choices}{default}"
