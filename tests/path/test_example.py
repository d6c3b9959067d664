"""`path ARM --example FILE` writes a path that any arm can be tried on."""

from __future__ import annotations

from pathlib import Path

import pytest

from rankdrop.cli import main
from rankdrop.local import singular_values
from rankdrop.path.read.example import example_path
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.mark.parametrize("name", ["ur5e", "puma560", "kr16", "scara", "planar2r", "pa10"])
def test_it_begins_regular_passes_the_nearest_singularity_and_keeps_the_limits(name: str) -> None:
    arm = open_robot(name)
    task = resolve_task(None, arm)
    made = example_path(arm, task)
    assert made.q.shape == (3, arm.n)
    assert (made.q >= arm.lower).all()
    assert (made.q <= arm.upper).all()
    met = 0.5 * (made.q[1] + made.q[2])
    rank = min(arm.n, len(task.rows))
    first, least = (singular_values(arm, q, task)[rank - 1] for q in (made.q[0], met))
    assert first > 0.01
    assert least < 0.05 * first


@pytest.mark.slow
@pytest.mark.by_hand_at("csv", "npz")
@pytest.mark.parametrize("ending", ["csv", "npz", "json"])
def test_what_is_written_is_read_and_crosses(
    ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main.run(["path", "ur5e", "--example", f"a.{ending}"]) == 0
    assert f"check it: rankdrop path ur5e a.{ending}" in capsys.readouterr().err
    assert main.run(["path", "ur5e", f"a.{ending}", "--quiet"]) == 3
    assert capsys.readouterr().out.startswith("Crosses a singularity once (proven)")


def test_a_file_beside_it_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["path", "ur5e", "a.csv", "--example", "b.csv"]) == 2
    assert "no file is checked with this option" in capsys.readouterr().err
    assert main.run(["path", "--example", "b.csv"]) == 2
    assert "no arm is named" in capsys.readouterr().err
