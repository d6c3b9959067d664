"""What a derivation carries along: the clock of its work, its limits, random points, what it had to assume.

The clock ticks with the work done, not with time: what a derivation finds does not depend on the machine's load. Every
costly step says what it costs: terms read, terms written, degrees. The unit is a microsecond, roughly, of one core of
2020 that does nothing else; within a factor of two or three the clock agrees with the time.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from math import inf
from time import process_time
from typing import Any

from rankdrop.algebra.halt import INTERRUPTED, Halt, HaltKind
from rankdrop.algebra.halt import OutOfTime as OutOfTime
from rankdrop.algebra.halt import TooLong as TooLong
from rankdrop.algebra.polynomial import Polynomial, is_number, primitive
from rankdrop.algebra.polynomial import calling_in_loops as calling_in_loops

_spent = 0.0

Progress = Callable[[str, int, int], None]
"""progress(label, done, total)"""
GRACE = 5.0
"""Time left after the user has asked to stop, and for the last checks after the limit has passed [s]."""

SLOWER = 1.5
"""Seconds of a limit that a user gives for each second of work: the counted work takes about so long."""
SAFETY = 15.0
"""Seconds of the processor's time for each second of work after which it ends in any case: a machine that is ten times
slower finds the same, and so does a busy one."""


def tick(microseconds: float) -> None:
    """Count a step that takes so long on an idle machine [µs]."""
    global _spent  # one derivation runs at a time in a process: readers only ever look at differences
    _spent += microseconds


def work_spent() -> float:
    """The work done since the process began [s of an idle machine]."""
    return _spent * 1e-6


def halt_of(error: BaseException) -> Halt:
    """What ended a derivation: the limit that was reached, Ctrl-C, or the error."""
    if isinstance(error, OutOfTime):
        return error.halt
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    return Halt(HaltKind.ERROR, error=type(error).__name__, message=str(error))


class Work:
    """One derivation in progress.

    Args:
        seconds: limit on work from now on, by `work_spent`; infinity for none. The safety limit on the processor's time
            is `SAFETY` times as much.
        seed: of the random points.
        progress: called now and then as progress(label, done, total).

    Attributes:
        seed: of the random points.
        rng: source of random numbers.
        limited: a limit on work or on the processor's time was met: with a longer one more is derived.
        interrupted: the user has asked to stop; only what was found is put in order.
        unresolved: systems of conditions that could not be taken apart; what they hold is missing from the answer.
        systems: pins and polynomials of every system that could not be taken apart, by its text in `unresolved`.
        without_points: sets (`ZeroSet`, by their key) without a point modulo the prime, though they may be real.
        assumed: factors in lengths alone that were divided by, by their text: the answer holds where none vanishes.
        lengths: of the arm at hand, for letters: what is said not to be there is shown for these.
        special: conditions are dependent for these lengths that are not for general ones: what holds for general
            lengths says nothing of this arm.
    """

    def __init__(self, seconds: float = inf, seed: int = 0, progress: Progress | None = None) -> None:
        self._end = work_spent() + seconds
        self._last = process_time() + SAFETY * seconds
        self.seed = seed
        self._progress = progress
        self.rng = random.Random(seed)
        self.assumed: dict[str, Polynomial] = {}
        self.unresolved: list[str] = []
        self.systems: dict[str, tuple[dict[int, str], tuple[Polynomial, ...]]] = {}
        self.without_points: dict[str, Any] = {}
        self.lengths: Mapping[str, Fraction] = {}
        self.special = False
        self.interrupted = False
        self.limited = False

    def check(self) -> None:
        """Call this in every loop that may be long.

        Raises:
            OutOfTime: the limit has passed.
        """
        if work_spent() > self._end:
            self.limited = True
            raise OutOfTime
        if process_time() > self._last:
            self.limited = True
            raise OutOfTime(Halt(HaltKind.PROCESSOR))

    def show(self, label: str, done: int, total: int) -> None:
        """Tell how far the derivation is."""
        if self._progress is not None:
            self._progress(label, done, total)

    @contextmanager
    def share(self, part: float, least: float = -inf) -> Iterator[None]:
        """Until the end of the block the limits are this part of the work and of the processor's time that are left.

        Args:
            part: of both.
            least: work that the block has in any case, where a step before it took more than its own share [s].
        """
        end, last = self._end, self._last
        if part < 1.0:
            self._end = work_spent() + max(part * self.remaining, least)
            self._last = process_time() + part * self.time_left
        try:
            yield
        finally:
            self._end = end
            if not self.interrupted:  # else only `GRACE` is left
                self._last = last

    @contextmanager
    def attempt(self, seconds: float) -> Iterator[Callable[[], None]]:
        """Until the end of the block the limit is so much work; the function given undoes what was noted in it."""
        noted = list(self.unresolved), dict(self.without_points), dict(self.assumed), self.special, self.limited
        end = self._end
        self._end = min(end, work_spent() + seconds)

        def undo() -> None:
            self.unresolved, self.without_points, self.assumed = list(noted[0]), dict(noted[1]), dict(noted[2])
            self.special, self.limited = noted[3:]

        try:
            yield undo
        finally:
            self._end = end

    def restarted(self) -> Work:
        """A derivation begun anew, with the same limits."""
        new = Work(self.remaining, self.seed, self._progress)
        new._last = self._last
        return new

    def interrupt(self) -> None:
        """Stop: `GRACE` is left to put in order what was found."""
        self.interrupted = True
        self._last = min(self._last, process_time() + GRACE)

    @property
    def remaining(self) -> float:
        """Work until the limit [s]."""
        return self._end - work_spent()

    @property
    def time_left(self) -> float:
        """Time until the outermost limit [s]."""
        return self._last - process_time()

    def assume(self, f: Polynomial) -> None:
        """Keep a factor in lengths alone as assumed ≠ 0."""
        f = primitive(f)
        if not is_number(f):
            self.assumed.setdefault(str(f), f)

    def leave(self, pins: Mapping[int, str], system: Sequence[Polynomial]) -> None:
        """Keep a system that could not be taken apart."""
        text = "; ".join([*(f"θ{j} = {value}" for j, value in pins.items()), *(f"{f} = 0" for f in system)])
        self.unresolved.append(text)
        self.systems[text] = dict(pins), tuple(system)
