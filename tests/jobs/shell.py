"""A fresh shell: a process of its own in an empty folder, with nothing in its environment but where programs are."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

KEPT = ("PATH", "HOME", "PYTHONPATH", "OMP_NUM_THREADS")


def environment() -> dict[str, str]:
    """What a fresh shell has; the width of a terminal is told, the language is English."""
    return {name: os.environ[name] for name in KEPT if name in os.environ} | {"COLUMNS": "100", "LANG": "C.UTF-8"}


def run(folder: Path, *words: str, seconds: float = 300.0) -> subprocess.CompletedProcess[str]:
    """`rankdrop WORDS` as a user types it; the exit code is left to the job."""
    return subprocess.run([sys.executable, "-m", "rankdrop", *words], cwd=folder, env=environment(),
                          capture_output=True, text=True, timeout=seconds, check=False)  # fmt: skip
