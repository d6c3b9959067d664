"""Result files: refused before the work where they cannot be written, and written whole or not at all."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rankdrop.cli.terminal import STDOUT
from rankdrop.errors import OptionError, visible


def check_target(target: str | None, option: str, endings: tuple[str, ...] = ()) -> None:
    """Find out before a long run whether `target` can be written.

    Args:
        target: a file, "-" for stdout, or None.
        option: that names it.
        endings: what a file may end in, with "-" where stdout is allowed too; () for anything.

    Raises:
        OptionError: wrong ending, no such folder, a folder, or not writable.
    """
    if target is None or (target == STDOUT and (not endings or STDOUT in endings)):
        return
    path, formats = Path(target), [ending for ending in endings if ending != STDOUT]
    folder = path.parent.is_dir()
    refused: tuple[tuple[bool, str, dict[str, str]], ...] = (
        (target.startswith("--"), "it needs the name of a file",  # an option was taken for the file of another one
         {"got": target, "allowed": "a file name, or -", "mend": f"./{target} if that is its name"}),
        (bool(formats) and path.suffix.lower() not in formats, "the ending names no format",
         {"got": target, "allowed": ", ".join(formats)}),
        (path.is_dir(), "it is a folder", {"got": target, "allowed": "a file name"}),
        (not folder, "there is no such folder", {"got": str(path.parent), "mend": "make it first"}),
        (folder and not os.access(path if path.exists() else path.parent, os.W_OK), "no permission to write there",
         {"got": target}),
    )  # fmt: skip
    for wrong, what, rest in refused:
        if wrong:
            raise OptionError(what, where=option, **rest)


def check_targets(targets: Mapping[str, str | None], endings: Mapping[str, tuple[str, ...]] | None = None) -> None:
    """Find out before a long run whether every result can be written, and whether one would overwrite another.

    Args:
        targets: option -> file, "-" for stdout, or None.
        endings: option -> what its file may end in, where that names the format: as for `check_target`.

    Raises:
        OptionError: as `check_target`; two options name the same file, or both stdout.
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
    first: dict[str | Path, str] = {}
    for option, target in targets.items():
        if target is None:
            continue
        if target == STDOUT and STDOUT in first:
            raise OptionError(f"stdout is taken by {first[STDOUT]}", where=option, got=STDOUT, mend="name a file")
        path = STDOUT if target == STDOUT else Path(target).resolve()
        if isinstance(path, Path) and path in first and (path.is_file() or not path.exists()):  # not /dev/null
            raise OptionError(f"it is the file of {first[path]} as well", where=option, got=target, mend="name another")
        first.setdefault(path, option)


def kept_work(folder: str | None) -> str:
    """What becomes of finished work after an interruption."""
    if folder:
        return f"finished work is kept in {folder}; run the same command to continue"
    return "--out keeps the work"


def write(content: Any, target: str) -> None:
    """Write bytes, a text, or a record as JSON."""
    if isinstance(content, bytes):
        write_bytes(content, target)
    elif isinstance(content, str):
        write_text(content, target)
    else:
        write_json(content, target)


def write_json(record: Any, target: str) -> None:
    """Write `record` to a file, or to stdout when `target` is "-"."""
    from rankdrop.codec import json_text

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
