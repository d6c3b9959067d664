"""Where words go: results to stdout, everything else to stderr; plain when nobody is looking.

Progress on stderr: bars with rate and time left on a terminal, a line now and then in a log, silence when asked.
"""

from __future__ import annotations

import codecs
import sys
import unicodedata
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

from rankdrop.errors import HIDDEN

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.progress import Progress
    from rich.text import Text

    from rankdrop.results import Verdict

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


def status() -> Console:
    """Console for progress: stderr."""
    return _console(stderr=True)


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
    console = status()
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
