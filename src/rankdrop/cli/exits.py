"""What every exit code means; the help texts and the README quote it."""

from __future__ import annotations

FINE = 0
INTERNAL = 1
BAD_INPUT = 2
UNEXPLAINED = 3
NEAR = 3
DIFFERS = 3
SINGULAR = 4
INTERRUPTED = 130
BROKEN_PIPE = 141

MEANING = {
    FINE: "done; everything found is explained and passed its tests",
    INTERNAL: "internal error, with a traceback",
    BAD_INPUT: "bad input: one line on stderr says what, where, and what to do",
    UNEXPLAINED: "analyze: some point is not explained, some row failed its test, or exact conditions differ; "
    "conditions: not complete, not verified, or the condition tested is not exact; explain: near a singularity; "
    "escape, nearest, tolerant: none found; path: a singularity is met or too near, or undecided; cover: not complete, "
    "or known families do not explain all; sweep, compare: a variant or an arm is not measured, or its families do not "
    "hold; aspects: undecided; through: not trackable, or undecided; verify: the claim does not hold, or is not "
    "confirmed",
    SINGULAR: "explain: the configuration is singular, or the arm deficient at every one",
    INTERRUPTED: "interrupted (Ctrl-C); what was done is printed and saved",
    BROKEN_PIPE: "the reader of the output has gone",
}

HELP = "\n".join(["Exit codes:", *(f"    {code:<4} {meaning}" for code, meaning in MEANING.items())])
