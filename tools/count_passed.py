"""Count what a command passes through: files of the package, functions, and types that instances are made of.

    .venv/bin/python tools/count_passed.py "analyze planar3r" "conditions puma560"
    .venv/bin/python tools/count_passed.py --names "explain pa10 --q 0,0,0,0,0,0,0"

Fewer is easier to follow: `tests/scripts/test_passed.py` holds upper bounds. Each command runs in a process of its own,
so that what another one has imported or kept plays no part. Importing a file is not passing it, nor is what its body
calls.
"""

from __future__ import annotations

import argparse
import contextlib
import inspect
import io
import json
import os
import shlex
import subprocess
import sys
from types import FrameType
from typing import Any


def passed(line: str) -> dict[str, list[str]]:
    """Names of the files, functions and types one command line passes; to be called once in a process."""
    import rankdrop
    from rankdrop.cli.main import run

    root = os.path.dirname(rankdrop.__file__) + os.sep
    files: set[str] = set()
    functions: set[str] = set()
    types: set[str] = set()
    importing = 0  # modules whose body is running: what that calls and makes is not passed by the command

    def look(frame: FrameType, event: str, _: Any) -> None:
        nonlocal importing
        code = frame.f_code
        if code.co_name == "<module>":
            importing += {"call": 1, "return": -1}.get(event, 0)
        if importing or event != "call" or not code.co_flags & inspect.CO_OPTIMIZED:
            return
        if code.co_filename.startswith(root):
            file = code.co_filename[len(root) :]
            files.add(file)
            functions.add(f"{file}:{code.co_firstlineno} {code.co_name}")
        made = None
        if code.co_name == "__init__" and code.co_varnames[:1] == ("self",):
            made = type(frame.f_locals.get("self"))
        elif code.co_name == "__new__" and code.co_varnames[:1] == ("_cls",):  # a NamedTuple
            made = frame.f_locals.get("_cls")
        if made is not None and made.__module__.partition(".")[0] == "rankdrop":
            types.add(f"{made.__module__}.{made.__qualname__}")

    sys.setprofile(look)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            code = run(shlex.split(line))
    finally:
        sys.setprofile(None)
    return {"files": sorted(files), "functions": sorted(functions), "types": sorted(types), "exit": [str(code)]}


def counted(line: str) -> dict[str, list[str]]:
    """The same, in a process of its own."""
    done = subprocess.run(
        [sys.executable, __file__, "--here", line], capture_output=True, text=True, check=True, env=os.environ
    )
    found: dict[str, list[str]] = json.loads(done.stdout)
    return found


def main(arguments: list[str]) -> int:
    """Count and print."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("lines", nargs="+", metavar="COMMAND")
    reader.add_argument("--names", action="store_true", help="name files and types as well")
    reader.add_argument("--here", action="store_true", help="in this process, as JSON")
    asked = reader.parse_args(arguments)
    for line in asked.lines:
        if asked.here:
            print(json.dumps(passed(line)))
            continue
        found = counted(line)
        numbers = ", ".join(f"{len(found[kind])} {kind}" for kind in ("files", "functions", "types"))
        print(f"{line}: exit code {found['exit'][0]}, {numbers}")
        if asked.names:
            print(*(f"  {name}" for kind in ("files", "types") for name in found[kind]), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
