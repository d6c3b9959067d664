"""Reading a text file from outside: of limited size, in UTF-8 or declared Latin-1, with errors in plain words."""

from __future__ import annotations

import re
from pathlib import Path

from rankdrop.errors import RobotError
from rankdrop.robot.budgets import LARGEST_FILE

_DECLARED = re.compile(rb"""<\?xml[^>]*encoding\s*=\s*["'](iso-8859-1|latin-?1|windows-1252)["']""", re.IGNORECASE)


def read_text(path: Path, *, largest: int | None = None) -> str:
    """The text of a file.

    Args:
        path: of the file.
        largest: bytes that it may have; None for `LARGEST_FILE`.

    Raises:
        RobotError: a folder, not readable, too large, or not text.
    """
    where, largest = str(path), LARGEST_FILE if largest is None else largest
    if path.is_dir():
        raise RobotError("this is a folder", where=where, mend="name the file in it")
    if not path.is_file():  # a device or a pipe could be read for ever
        raise RobotError("this is not a file", where=where)
    try:
        with path.open("rb") as stream:
            data = stream.read(largest + 1)
    except OSError as error:
        raise RobotError(f"the file cannot be read: {error.strerror}", where=where) from None
    if len(data) > largest:
        raise RobotError("the file is too large", where=where, allowed=f"at most {largest / 2**20:g} MB")
    if b"\0" in data:
        raise RobotError("this is not a text file", where=where, allowed="TOML, URDF or xacro in UTF-8")
    declared = _DECLARED.match(data)
    if declared is not None:
        return data.decode("latin-1")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise RobotError(
            "this is not text in UTF-8", where=f"{where}, line {line}", got=f"byte 0x{data[error.start]:02x}",
            mend="save the file as UTF-8",
        ) from None
