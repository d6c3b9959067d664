"""Progress on stderr: bars with rate and time left on a terminal, a line now and then in a log, silence when asked."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

from rankdrop.cli.terminal import say, status

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

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
