"""A designer's job, from a fresh shell: two hundred variants of an arm ranked, interrupted on the way and resumed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from patience import until

from rankdrop.distance.share import near_shares
from rankdrop.problem import Problem
from rankdrop.robot.drawing import Drawing
from rankdrop.task import resolve_task
from rankdrop.verbs.analyze import analyze

VARIANTS = 200
SPEC = f"""
robot = "ur5"

[parameters]
upper_arm = {{ sets = "-shoulder_lift_joint.a", lower = "300 mm", upper = "550 mm" }}
forearm = {{ sets = "-elbow_joint.a", lower = "300 mm", upper = "500 mm" }}
offset = {{ sets = "wrist_2_joint.d", lower = 0.02, upper = 0.14 }}

[sample]
kind = "sobol"
variants = {VARIANTS}

[families]
exact = false

[near]
within = "5 deg"
samples = 1000

[region]
lower = [0.25, -0.25, 0.1]
upper = [0.55, 0.25, 0.5]
rpy = ["180 deg", 0, 0]
points = 10
starts = 8
"""


def shell(folder: Path, *words: str) -> subprocess.Popen[str]:
    """`rankdrop …` in a folder, with nothing of this process but where Python and the package are."""
    environment = {name: os.environ[name] for name in ("PATH", "PYTHONPATH", "HOME") if name in os.environ}
    return subprocess.Popen([sys.executable, "-m", "rankdrop", *words], cwd=folder, env=environment, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip


def done(process: subprocess.Popen[str]) -> tuple[int, str]:
    text, errors = process.communicate()
    assert "Traceback" not in errors, errors
    return process.returncode, text


@pytest.mark.by_hand
def test_two_hundred_variants_are_ranked(tmp_path: Path) -> None:
    (tmp_path / "designs.toml").write_text(SPEC)
    run = ("sweep", "designs.toml", "--out", "designs", "--parquet", "--json", "designs.json", "--html",
           "designs.html", "--quiet")  # fmt: skip
    first = shell(tmp_path, *run)
    journal = tmp_path / "designs" / "journal"
    until(lambda: first.poll() is not None or (journal.exists() and journal.read_bytes().count(b"\n") >= 2), 600)
    assert first.poll() is None, first.communicate()
    first.kill()
    first.communicate()
    code, text = done(shell(tmp_path, "sweep", "--status", "designs"))
    assert code == 0
    assert " of 20 chunks of the sweep (200 items in all); last one " in text
    kept = {path.name: path.read_bytes() for path in (tmp_path / "designs" / "parts").iterdir()}

    code, text = done(shell(tmp_path, *run))
    assert code == 0, text
    assert f"of {VARIANTS} variants of ur5" in text
    assert "the families of each were verified by sampling" in text
    assert all((tmp_path / "designs" / "parts" / name).read_bytes() == content for name, content in kept.items())
    record = json.loads((tmp_path / "designs.json").read_text())
    assert record["holds"]
    _ranked(record, tmp_path)


def _ranked(record: dict[str, Any], folder: Path) -> None:
    """The best variants of the table are those of the JSON, and the very best is as good as a fresh analysis says."""
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(folder / "designs" / "variants").to_pydict()
    assert table["variant"] == list(range(1, VARIANTS + 1))
    near = np.array(table["near"])
    order = np.argsort(near, kind="stable")
    best = record["variants"][int(order[0])]
    assert best["measures"]["near"] == near.min()
    assert record["pareto"]
    drawing = Drawing.of("ur5")
    places = [drawing.place(text, "") for one in record["parameters"] for text in one["sets"]]
    arm = drawing.robot(dict(zip(places, best["values"], strict=True)))
    task = resolve_task(None, arm, length_scale=record["length_scale"])
    alone = analyze(arm, task, starts=1000, exact="off", seed=8)
    assert sorted((one.corank, one.dimension) for one in alone.families) == sorted(
        (one["corank"], one["dimension"]) for one in best["families"]
    )
    share = near_shares(alone.families, Problem(arm, task), np.radians(5.0), samples=4000, seed=8).any
    assert share.share == pytest.approx(best["measures"]["near"], abs=5 * (0.2 / 1000) ** 0.5)
