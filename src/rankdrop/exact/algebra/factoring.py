"""Factoring in a process of its own: the one step that cannot be told to stop, so that a time limit always holds."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from rankdrop.errors import RankdropError
from rankdrop.exact.algebra.polynomial import Atom, Factors, Polynomial, flint
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import OutOfTime

SHORT = 300
"""Polynomials of so many terms are factored here: milliseconds, and a process takes 0.3 s to start."""
MEMORY = 4 << 30
"""The process may take so many bytes, where the system can hold it to that."""
_PATIENCE = 30.0 if hasattr(signal, "setitimer") else 3.0
"""Seconds waited for each second the process may take: it ends itself, where the system has a timer of its time."""
TOO_LARGE = 3
"""Exit code of a process that needs more, or whose polynomial is too long in half angles."""


def factors_within(ring: Ring, p: Polynomial, seconds: float) -> Factors | None:
    """`Ring.factor`, given up after so many seconds.

    Args:
        ring: of p.
        p: not zero, of `ring.trig`.
        seconds: of the processor's time, so that a busy machine finds the same. A
            polynomial of at most `SHORT` terms is factored whatever is left.

    Returns:
        The factors; None where time or memory did not suffice.

    Raises:
        RankdropError: the process failed otherwise.
    """
    if len(p) <= SHORT:
        return ring.factor(p)
    if seconds <= 0:
        return None
    program = f"from {__name__} import main; main()"
    message = {"revolute": ring.revolute, "prismatic": ring.prismatic, "letters": ring.letters, "terms": _plain(p),
               "seconds": seconds}  # fmt: skip
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    try:
        done = subprocess.run(
            [sys.executable, "-c", program], input=json.dumps(message), capture_output=True, text=True,
            timeout=_PATIENCE * seconds, env=environment, check=False,
        )  # fmt: skip
    except (subprocess.TimeoutExpired, OSError):
        return None
    if done.returncode > 0 and done.returncode != TOO_LARGE:
        raise RankdropError("factoring in a process of its own failed", got=done.stderr.strip()[-200:])
    return _read(ring, json.loads(done.stdout)) if done.returncode == 0 else None  # below zero: ended by a signal


def main() -> None:
    """The process: a polynomial comes in as JSON, its factors go out."""
    _hold_memory()
    given = json.load(sys.stdin)
    if hasattr(signal, "setitimer"):  # Windows has none
        signal.setitimer(signal.ITIMER_PROF, min(given["seconds"], 1e6))  # ends the process
    ring = Ring(given["revolute"], given["prismatic"], given["letters"])
    try:
        found = ring.factor(_polynomial(ring.trig, given["terms"]))
    except (MemoryError, OutOfTime):  # of half-angle terms there may be too many
        sys.exit(TOO_LARGE)
    json.dump(_written(found), sys.stdout)


def _hold_memory() -> None:
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def _plain(f: Polynomial) -> list[Any]:
    return [[[int(e) for e in powers], f"{value.p}/{value.q}"] for powers, value in f.terms()]


def _polynomial(context: Any, terms: Sequence[Any]) -> Polynomial:
    return context.from_dict({tuple(powers): _number(value) for powers, value in terms})


def _number(text: str) -> Any:
    top, bottom = text.split("/")
    return flint().fmpq(int(top), int(bottom))


def _written(found: Factors) -> dict[str, Any]:
    return {
        "content": f"{found.content.p}/{found.content.q}",
        "letters": [[_plain(f), int(power)] for f, power in found.letters],
        "atoms": [
            [atom.joint, atom.value, None if atom.f is None else _plain(atom.f), int(power)]
            for atom, power in found.atoms
        ],
    }


def _read(ring: Ring, found: Mapping[str, Any]) -> Factors:
    def atom(joint: int, value: str, terms: Any) -> Atom:
        return ring.pin(joint, value) if terms is None else ring.atom(_polynomial(ring.half, terms))

    return Factors(
        _number(found["content"]),
        tuple((_polynomial(ring.half, terms), power) for terms, power in found["letters"]),
        tuple((atom(joint, value, terms), power) for joint, value, terms, power in found["atoms"]),
    )
