"""The language of a robot program by its first lines, for files with another ending."""

from __future__ import annotations

import re
from pathlib import Path

from rankdrop.path.read.program_record import Language
from rankdrop.path.read.trajectory import TrajectoryError

_LOOKED_THROUGH = 20_000  # characters of a file
_SIGNS = (
    (Language.TP, ".ls", re.compile(r"\s*/PROG\b")),
    (Language.INFORM, ".jbi", re.compile(r"\s*/JOB\b")),
    (Language.KRL, ".src", re.compile(r"\s*(?:&ACCESS|(?:GLOBAL )?DEF(?:FCT \w+)? +\w+ *\()")),
    (Language.RAPID, ".mod", re.compile(r"\s*(?:%%%|MODULE +\w+|PROC +\w+ *\()", re.IGNORECASE)),
)
_COMMENTS = re.compile(r"(?:[ \t]*(?:[!;#][^\n]*)?\n)*")
_URSCRIPT = re.compile(r"\s*def +\w+\([^()\n]*\): *$", re.MULTILINE)
_MOVES = re.compile(r"^[ \t]*(?:movej|movel|movep|movec)[ \t]*\(", re.MULTILINE)


def refuse_program_text(text: str, name: str) -> None:
    """Refuse a robot program under another ending.

    Args:
        text: of the file.
        name: of the file.

    Raises:
        TrajectoryError: with the ending to give it.
    """
    found = _language(text[:_LOOKED_THROUGH])
    if found is not None:
        language, ending = found
        raise TrajectoryError("this is a robot program, and the ending of the file does not say so", where=name,
                              got=f"the first line of a program in {language}",
                              mend=f"rename it {Path(name).with_suffix(ending).name}")  # fmt: skip


def _language(text: str) -> tuple[Language, str] | None:
    """The language of a program, and the ending of its files; None where the text is none."""
    start = 0
    comments = _COMMENTS.match(text)
    if comments is not None:
        start = comments.end()
    for language, ending, sign in _SIGNS:
        if sign.match(text, start):
            return language, ending
    if _URSCRIPT.match(text, start) and _MOVES.search(text):
        return Language.URSCRIPT, ".script"
    return None
