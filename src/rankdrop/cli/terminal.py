"""Where words go: results to stdout or to files, everything else to stderr; plain when nobody is looking.

Progress on stderr: bars with rate and time left on a terminal, a line now and then in a log, silence when asked.

Sections on the terminal: a heading, then lines or rows.
"""

from __future__ import annotations

import codecs
import sys
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import accumulate
from time import monotonic
from typing import TYPE_CHECKING

from rankdrop.errors import HIDDEN
from rankdrop.sections import Formula, Section

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.progress import Progress
    from rich.text import Text

    from rankdrop.families import Verdict

    Block = Section | Iterable[RenderableType]  # blank lines stand between blocks

_ASCII = {
    "θ": "q", "π": "pi", "σ": "sigma", "ρ": "rho", "×": "x", "±": "+-", "°": " deg", "−": "-", "–": "-", "—": "-",
    "…": "...", "·": ".", "≤": "<=", "≥": ">=", "²": "^2", "³": "^3", "Δ": "d", "’": "'", "∞": "inf",
    "→": "->", "₁": "1", "₂": "2", "‖": "|", "ω": "w", "τ": "tau", "φ": "phi", "α": "alpha", "β": "beta", "γ": "gamma",
    "λ": "lambda", "Σ": "sum",
    "µ": "u", "∥": "||", "⟂": "perp", "√": "sqrt", "ᵀ": "^T", "⁺": "^+", "†": "^+",
    "ᵖ": "^p", "⁴": "^4", "⁵": "^5", "⁶": "^6", "\u0307": "'",
}  # fmt: skip
BAD = "bold red"
"""Style of what fails a test."""

TONES = {"": "bold", "good": "bold green", "warning": "bold yellow", "bad": "bold red"}
"""Style of a heading or a verdict; Rich leaves the colour out where NO_COLOR is set, and all of it off a terminal."""

Report = Callable[[str, int, int], None]
"""report(label, done, total)"""

_SECONDS_BETWEEN_LINES = 10.0

INDENT = 2
"""Blanks before every line under a heading."""
_GAP = 2  # between columns
_LABEL = 24  # a column of words is wrapped, but not narrower than this

BRIEF = 40
"""Lines of an output without --full."""

_HANG = 4

_PLAIN = 3

STDOUT = "-"


def say(text: str, *, bare: bool = False) -> None:
    """One line to stderr, under the name of the program unless it is `bare`."""
    try:
        print(f"{'' if bare else 'rankdrop: '}{text.translate(HIDDEN)}", file=sys.stderr, flush=True)
    except OSError:  # stderr is closed: there is nobody to tell
        return


def encode_plainly() -> None:
    """Let a terminal without Unicode show θ as q, π as pi and so on, rather than fail."""
    codecs.register_error("rankdrop", _spell_out)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="rankdrop")


def _spell_out(error: UnicodeError) -> tuple[str | bytes, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    bad = error.object[error.start : error.end]
    return "".join(_ASCII.get(letter) or _plain(letter) for letter in bad), error.end


def _plain(letter: str) -> str:
    """A line for the lines of tables, the letter for one with an accent."""
    if "─" <= letter <= "╿":
        return "-"
    return unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode() or "?"


def screen() -> Console:
    """Console for results: stdout, plain when it is not a terminal; width from COLUMNS or the terminal, else 80."""
    return _console(stderr=False)


def show(console: Console, parts: Iterable[RenderableType]) -> None:
    """Print to the console, without blanks at the ends of lines."""
    with console.capture() as capture:
        for part in parts:
            console.print(part)
    sys.stdout.write("".join(f"{line.rstrip()}\n" for line in capture.get().splitlines()))


def answer_lines(answer: str, verdict: Verdict, subject: str = "") -> list[Text]:
    """The answer and how sure it is, or the other way round; before both the arm that is spoken of, where that is said.
    """
    from rich.text import Text

    tone = TONES["good" if verdict.holds else "bad"]
    lines = [Text(line, style=tone if line == verdict.sentence else "bold") for line in verdict.headlines(answer)]
    if subject:
        return [Text.assemble((subject, "bold"), lines[0]), *lines[1:]]
    return lines


def _console(*, stderr: bool) -> Console:
    """A console that shows control characters of names and texts as signs; its own colours are no part of a text."""
    from rich.console import Console, ConsoleOptions
    from rich.segment import Segment

    console = Console(stderr=stderr, highlight=False, markup=False, emoji=False)
    whole = console.render

    def guard_lines(renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for text, style, control in whole(renderable, options):
            yield Segment(text if control else text.translate(HIDDEN), style, control)

    console.render = guard_lines  # type: ignore[method-assign]  # all that is printed passes through it
    return console


@contextmanager
def reporter(*, quiet: bool) -> Iterator[Report]:
    """Give a `report(label, done, total)` that shows each label as one line of progress."""
    console = _console(stderr=True)
    if quiet:
        yield lambda label, done, total: None
    elif console.is_terminal:
        with _bars(console) as bars:
            yield _bar_report(bars)
    else:
        yield _line_report()


def _bars(console: Console) -> Progress:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    return Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=None),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
        console=console,
        transient=True,
        expand=True,
    )


def _bar_report(bars: Progress) -> Report:
    tasks: dict[str, tuple[object, float]] = {}

    def report(label: str, done: int, total: int) -> None:
        if label not in tasks:
            tasks[label] = (bars.add_task(label, total=total, rate=""), monotonic())
        task, begun = tasks[label]
        seconds = monotonic() - begun
        if done and seconds > 0.2:
            rate = f"{done / seconds:,.0f}/s"
        else:
            rate = ""
        bars.update(task, completed=done, total=total, rate=rate)  # type: ignore[arg-type]  # rich's TaskID is an int

    return report


def _line_report() -> Report:
    last = monotonic()
    begun: dict[str, tuple[float, int]] = {}  # when, and how far it was: what a journal keeps was done before

    def report(label: str, done: int, total: int) -> None:
        nonlocal last
        now = monotonic()
        start, first = begun.setdefault(label, (now, done))
        if now - last >= _SECONDS_BETWEEN_LINES:
            last = now
            if now > start:
                rate = (done - first) / (now - start)
            else:
                rate = 0.0
            if rate > 0.5 and total > done:
                left = f", {rate:,.0f}/s, {(total - done) / rate:,.0f} s left"
            else:
                left = ""
            say(f"{label}: {done} of {total}{left}")

    return report


def print_blocks(blocks: Iterable[Block]) -> None:
    """Print to stdout: headings bold, notes dim, tables aligned, blank lines between."""
    console = screen()
    for number, block in enumerate(blocks):
        if isinstance(block, Section):
            parts = section_parts(block, console.width)
        else:
            parts = block
        show(console, [*([""] if number else []), *parts])


def fit_to_console(
    blocks: Sequence[Block], optional: Sequence[Section] = (), cut: Sequence[Section] = ()
) -> list[Block]:
    """Blocks in at most `BRIEF` lines of the console, as far as what may be left out allows.

    Args:
        blocks: to print.
        optional: of these, what goes first, the last one first.
        cut: of these, sections that lose rows or lines at their end after that, the last one first; the rows and lines
            left out are counted below the others.
    """
    console = screen()
    kept: list[Block] = [block if isinstance(block, Section) else list(block) for block in blocks]

    def lines() -> int:
        return sum(_height(console, block) for block in kept) + len(kept) - 1

    for section in reversed(optional):
        if lines() > BRIEF:
            kept = [block for block in kept if block is not section]
    for section in reversed(cut):
        place = next(i for i, block in enumerate(kept) if block is section)
        most = len(section.rows or section.lines)
        if lines() <= BRIEF:
            break
        low, high = 0, most - 1  # the largest number of rows that fits, 0 where none does
        while low < high:
            middle = (low + high + 1) // 2
            kept[place] = _cut(section, middle)
            if lines() <= BRIEF:
                low, high = (middle, high)
            else:
                low, high = (low, middle - 1)
        kept[place] = _cut(section, low)
    return kept


def _cut(section: Section, number: int) -> Section:
    """The first rows of a section, or its first lines where it has no rows; the others counted."""
    left = f"and {len(section.rows or section.lines) - number} more: --full"
    if section.rows:
        return replace(section, rows=section.rows[:number], after=(left, *section.after))
    return replace(section, lines=section.lines[:number], after=(left, *section.after))


def _height(console: Console, block: Block) -> int:
    """Lines of a block on a console."""
    if isinstance(block, Section):
        parts = section_parts(block, console.width)
    else:
        parts = block
    with console.capture() as capture:
        for part in parts:
            console.print(part)
    return len(capture.get().splitlines())


def section_parts(section: Section, width: int) -> Iterable[RenderableType]:
    """What Rich prints of a section."""
    from rich.padding import Padding
    from rich.text import Text

    if section.title or section.summary:
        yield Text.assemble((section.title, TONES[section.tone]), f"  {section.summary}" if section.summary else "")
    for line in section.lines:
        yield from map(_indent, formula(line, width - INDENT) if isinstance(line, Formula) else [line])
    for columns in _pieces(section, width - INDENT):
        yield Padding(_table(section, columns), (0, 0, 0, INDENT))
    for line in section.after:
        yield _indent(line)
    for note in section.notes:
        yield Padding(Text(note, style="dim"), (0, 0, 0, INDENT))


def formula(line: str, width: int) -> list[str]:
    """A formula in pieces of at most `width` characters, where its words allow that.

    It is broken before a sign or a bracket, outside of as many brackets as can be had; the rest is indented.

    Args:
        line: blanks before it are an indent.
        width: characters in a line.

    Example:
        >>> formula("a2 c2 + a3 (c23 + s23) = 0", 24)
        ['a2 c2', '    + a3 (c23 + s23) = 0']
    """
    rest = line.lstrip(" ")
    blanks = " " * (len(line) - len(rest))
    pieces = []
    while len(blanks) + len(rest) > width and (place := _place(rest, max(width - len(blanks), 20))) < len(rest):
        pieces.append(blanks + rest[:place].rstrip())
        rest = rest[place:].lstrip()
        blanks = " " * (len(line) - len(line.lstrip(" ")) + _HANG)
    return [*pieces, blanks + rest]


def _place(text: str, room: int) -> int:
    """Where to break: at the shallowest good place that is not at the beginning, else at a blank, else nowhere."""
    depths = list(accumulate((letter == "(") - (letter == ")") for letter in f" {text}"))
    near = [place for place, letter in enumerate(text[: room + 1]) if letter == " "]
    late = [place for place in near if place > room // 5] or near
    if not late:
        if " " in text:
            return text.find(" ")
        return len(text)
    kinds = {place: _kind_of_break(text[place - 1], text[place + 1 :]) for place in late}
    return min(late, key=lambda place: (kinds[place] == _PLAIN, depths[place], kinds[place], -place))


def _kind_of_break(before: str, after: str) -> int:
    """How good a break at a blank is: after a comma, before a sign, before a bracket or "= 0" at the end, elsewhere."""
    sign = after[:2] in ("+ ", "− ", "= ", "≠ ") and after != "= 0"
    return (before in ",;", sign, after[:1] == "(" or after == "= 0", True).index(True)


def _indent(line: str) -> RenderableType:
    """A sentence; blanks before it stay before its second line too."""
    from rich.padding import Padding
    from rich.text import Text

    text = line.lstrip(" ")
    return Padding(Text(text), (0, 0, 0, INDENT + len(line) - len(text)))


def _pieces(section: Section, width: int) -> list[list[int]]:
    """The columns, in as many tables as their numbers need: no number is broken, the first column leads each."""
    if not section.rows:
        return []
    widths = [_least(section, index) for index in range(len(section.columns))]
    pieces: list[list[int]] = [[0]] if widths else []
    for index in range(1, len(widths)):
        used = sum(widths[i] + _GAP for i in pieces[-1])
        if used + widths[index] > width and len(pieces[-1]) > 1:
            pieces.append([0])
        pieces[-1].append(index)
    return pieces


def _least(section: Section, index: int) -> int:
    """Characters that a column needs: its longest cell, or the longest word of a column of words."""
    from rich.cells import cell_len

    cells = [section.columns[index], *(row[index] for row in section.rows)]
    if index not in section.texts:
        return max(map(cell_len, cells))
    words = max(max(map(cell_len, cell.split()), default=0) for cell in cells)
    return max(words, min(_LABEL, max(map(cell_len, cells))))


def _table(section: Section, columns: list[int]) -> RenderableType:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for index in columns:
        words = index in section.texts
        table.add_column(
            section.columns[index], justify="left" if words else "right", overflow="fold", no_wrap=not words,
            min_width=_least(section, index),
        )  # fmt: skip
    for row in section.rows:
        table.add_row(*(row[index] for index in columns))
    return table
