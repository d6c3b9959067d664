"""Result files: refused before the work when they cannot be written, written whole or not at all."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from rankdrop.errors import OptionError, visible
from rankdrop.results import json_text

STDOUT = "-"


def check_target(target: str | None, option: str, endings: tuple[str, ...] = ()) -> None:
    """Find out before a long run whether `target` can be written.

    Raises:
        OptionError: wrong ending, no such folder, a folder, or not writable.
    """
    if target is None or target == STDOUT:
        return
    if target.startswith("--"):  # an option was taken for the file that another one is to write
        raise OptionError("it needs the name of a file", where=option, got=target, allowed="a file name, or -",
                          mend=f"./{target} if that is its name")  # fmt: skip
    path = Path(target)
    if endings and path.suffix.lower() not in endings:
        raise OptionError("the ending names no format", where=option, got=target, allowed=", ".join(endings))
    if path.is_dir():
        raise OptionError("it is a folder", where=option, got=target, allowed="a file name")
    if not path.parent.is_dir():
        raise OptionError("there is no such folder", where=option, got=str(path.parent), mend="make it first")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise OptionError("no permission to write there", where=option, got=target)


def check_targets(targets: Mapping[str, str | None], endings: Mapping[str, tuple[str, ...]] | None = None) -> None:
    """Find out before a long run whether every result can be written, and whether one would overwrite another.

    Args:
        targets: option -> file, "-" for stdout, or None.
        endings: option -> what its file may end in, where that names the format.

    Raises:
        OptionError: as `check_target` and `check_different`.
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
    printed = [option for option, target in targets.items() if target == STDOUT]
    if len(printed) > 1:
        raise OptionError(f"stdout is taken by {printed[0]}", where=printed[1], got=STDOUT, mend="name a file")
    first: dict[Path, str] = {}
    for option, target in targets.items():
        if target is None or target == STDOUT:
            continue
        path = Path(target).resolve()
        if path in first and (path.is_file() or not path.exists()):  # not /dev/null
            raise OptionError(f"it is the file of {first[path]} as well", where=option, got=target, mend="name another")
        first.setdefault(path, option)


def hand_over(show: Callable[[], object], *results: tuple[str | None, Callable[[str], object]]) -> None:
    """Show finished work, and write every result that has a target; each is tried, even where one before has failed.

    Args:
        show: prints it; not called where a result is written to stdout in its place.
        results: where to, None for nowhere, and what writes there.

    Raises:
        OptionError, OSError: of the first that failed; a reader that has gone counts only where all else is well.
    """
    steps = [] if any(target == STDOUT for target, _ in results) else [show]
    steps += [partial(write, target) for target, write in results if target is not None]
    failed: Exception | None = None
    for step in steps:
        try:
            step()
        except (OptionError, OSError) as error:
            failed = error if failed is None or isinstance(failed, BrokenPipeError) else failed
    if failed is not None:
        raise failed


def write_json(record: Any, target: str) -> None:
    """Write `record` to a file, or to stdout when `target` is "-"."""
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
