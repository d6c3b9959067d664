"""Job (f): an off-line programmer. 50,000 rows of a UR5e's program: judged, and the stretch that crosses mended.

What has to be known: `rankdrop path ROBOT FILE`, --deg for files in degrees, and --fixed for the mended one.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from jobs.shell import run

pytestmark = pytest.mark.slow
ROWS = 50_000


def program(path: Path) -> None:
    """A long way round, far from every family but for one crossing of the wrist."""
    time = np.linspace(0.0, 500.0, ROWS)
    turn = 2 * np.pi * time / 500.0
    degrees = np.stack([
        40 * np.sin(turn), -80 + 8 * np.cos(2 * turn), 90 + 10 * np.sin(3 * turn), -100 + 5 * np.sin(turn),
        -80 + 82 * np.exp(-(((time - 250) / 5) ** 2)), 10 * np.sin(turn),
    ], axis=1)  # fmt: skip
    head = "time," + ",".join(f"q{i}" for i in range(1, 7))
    np.savetxt(path, np.column_stack([time, degrees]), delimiter=",", header=head, comments="", fmt="%.8f")


@pytest.mark.by_hand
def test_fifty_thousand_rows_are_judged_and_mended(tmp_path: Path) -> None:
    program(tmp_path / "program.csv")
    done = run(tmp_path, "path", "ur5e", "program.csv", "--deg", "--fixed", "mended.csv", "--json", "judged.json",
               "--quiet", seconds=600)  # fmt: skip
    assert done.returncode == 3, done.stderr
    found = json.loads((tmp_path / "judged.json").read_text(encoding="utf-8"))
    assert (found["rows"], found["verdict"]) == (ROWS, "crossing")
    assert len(found["crossings"]) == 2  # in over 0°, and back
    assert {one["name"].split(":")[0] for one in found["crossings"]} == {"wrist"}

    again = run(tmp_path, "path", "ur5e", "mended.csv", "--json", "mended.json", "--quiet", seconds=600)
    assert again.returncode == 0, again.stdout[-800:]
    mended = json.loads((tmp_path / "mended.json").read_text(encoding="utf-8"))
    assert (mended["verdict"], mended["crossings"]) == ("free", [])
    assert mended["rows"] >= ROWS
