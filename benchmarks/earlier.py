"""`analyze` beside an earlier version of rankdrop: processor time of both in turns on one thread, and the same rows.

    python benchmarks/earlier.py [--json] [--quick]

The earlier version is built from this repository's history, into a folder that is thrown away (`RANKDROP_EARLIER` names
one where its package `rankdrop` stands built). Without a history or a compiler it ends and says so. As `analyze` is
called, the exact conditions of these arms are shipped now and were derived then; without them (`exact="off"`) both do
the same.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import measure  # first: sets the number of threads

import rankdrop

REF = "9c0e5cc6"
"""Before families got their partition, names and curves: what `analyze` found then it finds now, and more."""
ARMS = ("sawyer", "gen3", "panda", "canadarm2")
TARGET = 3.0
ROOT = Path(__file__).resolve().parents[1]
ONCE = """
import json, resource, sys
import rankdrop
robot = rankdrop.open_robot(sys.argv[1])
def used(): return resource.getrusage(resource.RUSAGE_SELF).ru_utime
rankdrop.analyze(rankdrop.open_robot("planar3r"), starts=50, threads=1)  # what is loaded once is not counted
begun = used()
found = rankdrop.analyze(robot, threads=1, exact=sys.argv[2])
seconds = used() - begun
families = found.to_dict()["families"]
rows = sorted((f["corank"], f["dimension"], sorted(p["number"] for p in f["pinned"])) for f in families)
print(json.dumps({"seconds": seconds, "rows": rows}))
"""


def build(folder: Path) -> Path:
    """The folder that holds the earlier package."""
    if there := os.environ.get("RANKDROP_EARLIER"):
        return Path(there)
    source = subprocess.run(["git", "archive", REF], cwd=ROOT, capture_output=True, check=False)
    if source.returncode:
        raise SystemExit(f"the earlier version {REF} is not in the history here: git fetch --unshallow brings it")
    with tarfile.open(fileobj=io.BytesIO(source.stdout)) as files:
        files.extractall(folder / "source", filter="data")
    wheel = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(folder), str(folder / "source")]
    if subprocess.run(wheel, capture_output=True, check=False).returncode:
        raise SystemExit(f"the earlier version {REF} cannot be built here: pip and a C++ compiler are needed")
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as files:
        files.extractall(folder / "package")
    return folder / "package"


def once(where: Path, arm: str, exact: str) -> dict[str, Any]:
    """Processor time [s] of one `analyze` of the package in a folder, and the rows it finds."""
    environment = os.environ | {"PYTHONPATH": str(where)}
    done = subprocess.run(
        [sys.executable, "-c", ONCE, arm, exact],
        env=environment,
        cwd=where,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise SystemExit(f"analyze {arm} in {where.name}: {done.stderr[-400:]}")
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def main() -> None:
    """Both versions in turns, as people call them and without exact conditions; the least of two runs."""
    rows: list[measure.Row] = []
    with tempfile.TemporaryDirectory() as folder:
        earlier = build(Path(folder))
        now = Path(rankdrop.__file__).parents[1]
        for arm in ARMS[: 1 if measure.quick() else None]:
            for exact in ("auto", "off"):
                turns = [(once(earlier, arm, exact), once(now, arm, exact)) for _ in range(1 if measure.quick() else 2)]
                before, after = (min(turn[i]["seconds"] for turn in turns) for i in (0, 1))
                rows.append({"arm": arm, "exact": exact, "earlier CPU s": before, "now CPU s": after,
                             "ratio": before / after, "same rows": turns[0][0]["rows"] == turns[0][1]["rows"],
                             "claimed": exact == "auto"})  # fmt: skip
    measure.report("analyze, as it is called, at least 3 times as quick as before, with the same rows", rows,
                   ratio="ratio", target=TARGET)  # fmt: skip


if __name__ == "__main__":
    main()
