"""Where the headers for C and C++ and the CMake package are: `python -m rankdrop.headers --cmake-dir`."""

from __future__ import annotations

import sys
from pathlib import Path

_USAGE = "usage: python -m rankdrop.headers --include-dir | --cmake-dir"


def get_include() -> str:
    """The folder for the compiler's `-I`, so that `#include <rankdrop/monitor.hpp>` is found."""
    return str(Path(__file__).resolve().parent / "include")


def get_cmake_dir() -> str:
    """The folder of `rankdropConfig.cmake`: `cmake -Drankdrop_DIR=…`."""
    return str(Path(__file__).resolve().parent / "cmake")


def main(words: list[str]) -> int:
    """Print one of the two folders.

    Returns:
        The exit code: 0, or 2 for anything else on the command line.
    """
    answers = {"--include-dir": get_include, "--cmake-dir": get_cmake_dir}
    if len(words) != 1 or words[0] not in answers:
        sys.stderr.write(_USAGE + "\n")
        return 2
    sys.stdout.write(answers[words[0]]() + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
