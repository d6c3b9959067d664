"""Wall time of the command `rankdrop analyze pa10` with 10 000 starts per corank."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import measure


def main() -> None:
    """The whole command, interpreter start and printing included, on all cores."""
    starts = 500 if measure.quick() else 10_000
    command = [sys.executable, "-m", "rankdrop.cli.main", "analyze", "pa10", "--starts", str(starts)]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "pa10.json"
        command += ["--json", str(file)]
        seconds, _ = measure.once(lambda: subprocess.run(command, check=True, capture_output=True))
        result = json.loads(file.read_text(encoding="utf-8"))
    families = [sum(row["corank"] == k for row in result["families"]) for k in (1, 2, 3)]
    row = {"starts per corank": starts, "cores": os.cpu_count(), "seconds": seconds, "families": str(families)}
    measure.report("rankdrop analyze pa10, wall time of the command: seconds", [row], ratio="seconds", target=30.0,
                   at_most=True)  # fmt: skip


if __name__ == "__main__":
    main()
