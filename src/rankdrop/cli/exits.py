"""What every exit code means; the help texts and the README quote it, docs/exit-codes.md explains it per command."""

from __future__ import annotations

FINE = 0
INTERNAL = 1
BAD_INPUT = 2
UNEXPLAINED = NEAR = DIFFERS = 3
SINGULAR = 4
INTERRUPTED = 130
BROKEN_PIPE = 141

MEANING = {
    FINE: "done; every claim holds",
    INTERNAL: "internal error, with a traceback",
    BAD_INPUT: "bad input: one line on stderr says what, where, and how to fix it",
    UNEXPLAINED: "a claim does not hold, or is not proven; near a singularity",
    SINGULAR: "explain: the configuration is singular",
    INTERRUPTED: "interrupted (Ctrl-C): finished work is printed and kept",
}

HELP = "\n".join(["Exit codes:", *(f"  {code:<5}{meaning}" for code, meaning in MEANING.items())])
