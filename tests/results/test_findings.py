"""Clouds in a folder: those of one search, whatever made them; ten million of them never sit in memory."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import rankdrop
from rankdrop.cli import main
from rankdrop.errors import OptionError
from rankdrop.results import findings
from rankdrop.results.findings import store_cloud

parquet = pytest.importorskip("pyarrow.parquet")
TEN_MILLION = 10_000_000


@pytest.mark.by_hand_at("ur5-2-False")
@pytest.mark.slow_at("ur5-2-False", "stanford-1-True")
@pytest.mark.parametrize(("name", "corank", "limits"), [("ur5", 2, False), ("stanford", 1, True)])
def test_a_stored_cloud_is_that_of_one_search(
    name: str, corank: int, limits: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(findings, "STARTS", 400)
    arm = rankdrop.open_robot(name)
    count = store_cloud(arm, corank, tmp_path, starts=1000, seed=3, limits=limits, workers=2)
    alone = rankdrop.search(arm, corank, starts=1000, seed=3, limits=limits)
    table = parquet.read_table(tmp_path / "parts").to_pydict()
    q = np.stack([table[f"q_{joint.name}_{joint.unit}"] for joint in arm.variables], axis=1)
    assert count == len(q) > 100
    assert (q == alone.converged).all()
    assert table["start"] == (1 + np.flatnonzero(alone.outcome == 0)).tolist()
    assert max(table["sigma"]) <= 1e-9
    assert len(list((tmp_path / "parts").iterdir())) == 3


@pytest.mark.slow
def test_the_command_stores_and_refuses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "cloud")
    line = ["find", "planar3r", "--corank", "1", "--starts", "500", "--quiet", "--store", out, "--workers", "1"]
    assert main.run(line) == 0
    assert capsys.readouterr()[0] == f"500 of 500 starts ended at corank 1 or more: {out}/parts/*.parquet\n"
    assert main.run([*line, "--json", "-"]) == 2
    assert "--json: it does not go with --store; got -; fix: leave one of them out" in capsys.readouterr()[1]
    assert main.run([*line[:-4], "--store", out, "--seed", "1"]) == 2
    assert "the folder holds another job" in capsys.readouterr()[1]
    with pytest.raises(OptionError, match="there is no such corank"):
        store_cloud(rankdrop.open_robot("scara"), 9, tmp_path / "x", starts=10)


MANY = """
import json, resource, sys
import rankdrop
from rankdrop.results import store_cloud
count = store_cloud(rankdrop.open_robot("planar3r"), 1, sys.argv[1], starts=int(sys.argv[2]))
with open("/proc/self/status") as status:  # ru_maxrss of this process would be that of the one it was begun by as well
    own = next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1024
worker = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
print(json.dumps({"count": count, "own": own, "worker": worker}))
"""


@pytest.mark.by_hand
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="peak memory is read from /proc")
def test_ten_million_are_found_stored_and_queried(tmp_path: Path) -> None:
    begun, used = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [sys.executable, "-c", MANY, str(tmp_path), str(TEN_MILLION)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    told, after = json.loads(done.stdout), resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime
    found = time.monotonic() - begun
    rows, largest, straight = 0, 0.0, 0
    for path in sorted((tmp_path / "parts").iterdir()):
        part = parquet.read_table(path, columns=["q_joint2_rad", "sigma"])
        angle = part["q_joint2_rad"].to_numpy()
        rows += part.num_rows
        largest = max(largest, float(part["sigma"].to_numpy().max()))
        straight += int((np.abs(np.sin(angle)) < 1e-6).sum())
    size = sum(path.stat().st_size for path in (tmp_path / "parts").iterdir()) / 2**20
    print(f"{rows:,} configurations: {found:.0f} s, {cpu:.0f} s of CPU time, {size:.0f} MB; peak memory "
          f"{told['own']:.0f} MB, of a worker {told['worker']:.0f} MB; queried in "
          f"{time.monotonic() - begun - found:.1f} s")  # fmt: skip
    assert rows == told["count"] > 0.99 * TEN_MILLION
    assert largest <= 1e-9
    assert straight == rows, "the planar arm is singular where θ2 and θ3 are 0 or π"
    assert max(told["own"], told["worker"]) < 500
