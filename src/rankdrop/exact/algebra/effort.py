"""A clock that ticks with the work done, not with time: what a derivation finds does not depend on the machine's load.

Every costly step says what it costs: terms read, terms written, degrees. The unit is a microsecond, roughly, of one
core of 2020 that does nothing else; within a factor of two or three the clock agrees with the time.
"""

from __future__ import annotations

_spent = 0.0


def tick(microseconds: float) -> None:
    """Count a step that takes so long on an idle machine [µs]."""
    global _spent  # one derivation runs at a time in a process: readers only ever look at differences
    _spent += microseconds


def spent() -> float:
    """The work done since the process began [s of an idle machine]."""
    return _spent * 1e-6
