"""Where words go: results to stdout or to files, everything else to stderr; plain when nobody is looking.

Progress on stderr: bars with rate and time left on a terminal, a line now and then in a log, silence when asked.

Sections on the terminal: a heading, then lines or rows. Result files: refused before the work when they cannot be
written, written whole or not at all.
"""

from __future__ import annotations

import codecs
import os
import sys
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from rankdrop.cli import exits
from rankdrop.errors import HIDDEN, OptionError, visible

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.progress import Progress
    from rich.text import Text

    from rankdrop.results import Explanation, Verdict
    from rankdrop.sections import Section


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


def results() -> Console:
    """Console for results: stdout, plain when it is not a terminal; width from COLUMNS or the terminal, else 80."""
    return _console(stderr=False)


def show(console: Console, parts: Iterable[RenderableType]) -> None:
    """Print to the console, without blanks at the ends of lines."""
    with console.capture() as capture:
        for part in parts:
            console.print(part)
    sys.stdout.write("".join(f"{line.rstrip()}\n" for line in capture.get().splitlines()))


TONES = {"": "bold", "good": "bold green", "warning": "bold yellow", "bad": "bold red"}
"""Style of a heading or a verdict; Rich leaves the colour out where NO_COLOR is set, and all of it off a terminal."""


def verdict_line(verdict: Verdict) -> Text:
    """The sentence that stands first and last."""
    from rich.text import Text

    return Text(verdict.sentence, style=TONES["good" if verdict.holds else "bad"])


def _console(*, stderr: bool) -> Console:
    """A console that shows control characters of names and texts as signs; its own colours are no part of a text."""
    from rich.console import Console, ConsoleOptions
    from rich.segment import Segment

    console = Console(stderr=stderr, highlight=False, markup=False, emoji=False)
    whole = console.render

    def guarded(renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for text, style, control in whole(renderable, options):
            yield Segment(text if control else text.translate(HIDDEN), style, control)

    console.render = guarded  # type: ignore[method-assign]  # all that is printed passes through it
    return console


Report = Callable[[str, int, int], None]
"""report(label, done, total)"""

_SECONDS_BETWEEN_LINES = 10.0


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
        rate = f"{done / seconds:,.0f}/s" if done and seconds > 0.2 else ""
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
            rate = (done - first) / (now - start) if now > start else 0.0
            left = f", {rate:,.0f}/s, {(total - done) / rate:,.0f} s left" if rate > 0.5 and total > done else ""
            say(f"{label}: {done} of {total}{left}")

    return report


INDENT = 2
"""Blanks before every line under a heading."""
_GAP = 2  # between columns
_LABEL = 24  # a column of words is wrapped, but not narrower than this


def print_sections(sections: Iterable[Section], *, first: bool = True) -> None:
    """Print to stdout: headings bold, notes dim, tables aligned; a blank line before each but the `first`."""
    console = results()
    for number, section in enumerate(sections):
        show(console, _parts(section, console.width, first=first and number == 0))


def interrupted(explanation: Explanation) -> int:
    """Exit code where Ctrl-C ended the proof early (what was proven holds), else 0."""
    if explanation.far.certificate is None or explanation.far.certificate.complete:
        return exits.FINE
    say("interrupted: the certified radius could have become larger")
    return exits.INTERRUPTED


def _parts(section: Section, width: int, *, first: bool) -> Iterable[RenderableType]:
    from rich.padding import Padding
    from rich.text import Text

    if not first:
        yield ""
    if section.title or section.summary:
        yield Text.assemble((section.title, TONES[section.tone]), f"  {section.summary}" if section.summary else "")
    for line in section.lines:
        yield _indented(line)
    for columns in _pieces(section, width - INDENT):
        yield Padding(_table(section, columns), (0, 0, 0, INDENT))
    for line in section.after:
        yield _indented(line)
    for note in section.notes:
        yield Padding(Text(note, style="dim"), (0, 0, 0, INDENT))


def _indented(line: str) -> RenderableType:
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
    words = max(cell_len(word) for cell in cells for word in (cell.split() or [""]))
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


STDOUT = "-"


def check_target(target: str | None, option: str, endings: tuple[str, ...] = ()) -> None:
    """Find out before a long run whether `target` can be written.

    Raises:
        OptionError: wrong ending, no such folder, a folder, or not writable.
    """
    if target is None or target == STDOUT:
        return
    if target.startswith("--"):  # an option was taken for the file that another one is to write
        raise OptionError("it needs the name of a file", where=option, got=target, allowed="a file name, or -",
                          mend=f"./{target} if that is its name")  # fmt: skip
    path = Path(target)
    if endings and path.suffix.lower() not in endings:
        raise OptionError("the ending names no format", where=option, got=target, allowed=", ".join(endings))
    if path.is_dir():
        raise OptionError("it is a folder", where=option, got=target, allowed="a file name")
    if not path.parent.is_dir():
        raise OptionError("there is no such folder", where=option, got=str(path.parent), mend="make it first")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise OptionError("no permission to write there", where=option, got=target)


def check_targets(targets: Mapping[str, str | None], endings: Mapping[str, tuple[str, ...]] | None = None) -> None:
    """Find out before a long run whether every result can be written, and whether one would overwrite another.

    Args:
        targets: option -> file, "-" for stdout, or None.
        endings: option -> what its file may end in, where that names the format.

    Raises:
        OptionError: as `check_target` and `check_different`.
    """
    for option, target in targets.items():
        check_target(target, option, (endings or {}).get(option, ()))
    check_different(targets)


def check_different(targets: Mapping[str, str | None]) -> None:
    """Find out before a long run whether one result would overwrite another.

    Args:
        targets: option -> file or None.

    Raises:
        OptionError: two options name the same file, or both stdout.
    """
    printed = [option for option, target in targets.items() if target == STDOUT]
    if len(printed) > 1:
        raise OptionError(f"stdout is taken by {printed[0]}", where=printed[1], got=STDOUT, mend="name a file")
    first: dict[Path, str] = {}
    for option, target in targets.items():
        if target is None or target == STDOUT:
            continue
        path = Path(target).resolve()
        if path in first and (path.is_file() or not path.exists()):  # not /dev/null
            raise OptionError(f"it is the file of {first[path]} as well", where=option, got=target, mend="name another")
        first.setdefault(path, option)


def kept(folder: str | None) -> str:
    """What becomes of finished work after an interruption."""
    return f"finished work is kept in {folder}; run the same command to continue" if folder else "--out keeps the work"


def hand_over(show: Callable[[], object], *results: tuple[str | None, Callable[[str], object]]) -> None:
    """Show finished work, and write every result that has a target; each is tried, even where one before has failed.

    Args:
        show: prints it; not called where a result is written to stdout in its place.
        results: where to, None for nowhere, and what writes there.

    Raises:
        OptionError, OSError: of the first that failed; a reader that has gone counts only where all else is well.
    """
    steps = [] if any(target == STDOUT for target, _ in results) else [show]
    steps += [partial(write, target) for target, write in results if target is not None]
    failed: Exception | None = None
    for step in steps:
        try:
            step()
        except (OptionError, OSError) as error:
            failed = error if failed is None or isinstance(failed, BrokenPipeError) else failed
    if failed is not None:
        raise failed


def write_json(record: Any, target: str) -> None:
    """Write `record` to a file, or to stdout when `target` is "-"."""
    from rankdrop.results import json_text

    write_text(json_text(record), target)


def write_text(text: str, target: str) -> None:
    """Write a text to a file, or to stdout when `target` is "-"."""
    if target == STDOUT:
        sys.stdout.write(visible(text))  # JSON has nothing to hide: `json_text` escapes
        sys.stdout.flush()
    else:
        write_bytes(text.encode(), target)


def write_bytes(content: bytes, target: str) -> None:
    """Write a file, whole or not at all (`rankdrop.disk`).

    Raises:
        OptionError: the file cannot be written (disk full, no permission).
    """
    from rankdrop.disk import replace_file

    try:
        replace_file(target, content)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OptionError(f"cannot write: {error.strerror}", where=target) from error
