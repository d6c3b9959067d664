"""Job (a): a cell engineer. The UR5e has stopped; the pendant shows six angles in degrees.

What has to be known: the arm's name, and that the pendant shows degrees (--deg).
What is wanted: which singularity, what is lost, and which key to press.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from jobs.shell import run
from rankdrop.local.block import singular_values
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

pytestmark = pytest.mark.slow
PENDANT = "0,-60,0,40,50,0"


def test_which_singularity_what_is_lost_and_what_to_press(tmp_path: Path) -> None:
    done = run(tmp_path, "explain", "ur5e", "--deg", "--q", PENDANT, "--json", "stopped.json")
    assert done.returncode == 4, done.stderr  # singular
    assert done.stdout.startswith("ur5e is singular: elbow")
    assert "Get out: jog joint 3 by" in done.stdout
    found = json.loads((tmp_path / "stopped.json").read_text(encoding="utf-8"))
    assert (found["verdict"], found["rank"]) == ("singular", 5)
    assert found["family"]["name"].startswith("elbow")
    assert len(found["lost_words"]) == 1

    arm, q = open_robot("ur5e"), np.radians([float(word) for word in PENDANT.split(",")])
    best = next(one for one in found["escape"]["single"] if one["order"] is not None)
    assert (best["number"], best["joint"]) == (3, "elbow_joint")
    pressed = q.copy()
    pressed[best["number"] - 1] += best["step"]
    assert singular_values(arm, pressed, resolve_task(None, arm))[5] == pytest.approx(best["sigma_after"], rel=1e-6)
    assert best["sigma_after"] > 1e-3

