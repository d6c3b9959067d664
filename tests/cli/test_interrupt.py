"""Ctrl-C: what was done is kept."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rankdrop.cli import exits
from rankdrop.families import searching as search_module
from rankdrop.results.analysis import Analysis
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze

PROGRAM = """
import sys
from rankdrop.cli import main, terminal
terminal._SECONDS_BETWEEN_LINES = 0.0
sys.exit(main.run(sys.argv[1:]))
"""


def interrupted(line: str, *argv: str) -> tuple[int, str]:
    """Start a command, send SIGINT when `line` shows on stderr; exit code and what came on stderr after it."""
    program = [sys.executable, "-c", PROGRAM, *argv]
    with subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        for text in process.stderr:
            if line in text:
                process.send_signal(signal.SIGINT)
                break
        rest = process.stderr.read()
        return process.wait(timeout=60), rest


@pytest.mark.slow
def test_an_interrupted_analysis_keeps_the_coranks_done(tmp_path: Path) -> None:
    path = tmp_path / "kept.json"
    code, rest = interrupted("corank 2: search", "analyze", "pa10", "--starts", "3000", "--json", str(path))
    assert code == exits.INTERRUPTED
    assert "Traceback" not in rest
    kept = Analysis.load(path)
    assert not kept.complete
    assert kept.unfinished == 2
    assert [summary.corank for summary in kept.coranks] == [1]
    assert len(kept.families) == 4


@pytest.mark.by_hand
def test_an_interrupted_find_keeps_the_starts_done(tmp_path: Path) -> None:
    path = tmp_path / "kept.json"
    argv = ("find", "pa10", "--corank", "3", "--starts", "300000", "--json", str(path))
    code, rest = interrupted("corank 3: search", *argv)
    assert code == exits.INTERRUPTED
    assert "Traceback" not in rest
    record = json.loads(path.read_text(encoding="utf-8"))
    assert not record["complete"]
    assert record["counts"]["not_run"] > 0
    assert len(record["configurations"]) == 300_000 - record["counts"]["not_run"] > 0


@pytest.mark.by_hand
def test_interrupted_conditions_keep_the_sets_found(tmp_path: Path) -> None:
    path = tmp_path / "kept.json"
    argv = ("conditions", "canadarm2", "--points", "0", "--json", str(path))
    code, rest = interrupted("sets derived for rank < 5: 20 of", *argv)
    assert code == exits.INTERRUPTED
    assert "Traceback" not in rest
    record = json.loads(path.read_text(encoding="utf-8"))
    assert record["interrupted"]
    assert not record["complete"]
    assert record["families"]
    assert record["left"]


@pytest.mark.slow
def test_the_unfinished_corank_is_said(run, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = search_module.search

    def interrupting(robot: Any, corank: int, **options: Any) -> Any:
        if corank == 2:
            raise KeyboardInterrupt
        return whole(robot, corank, **options)

    monkeypatch.setattr(sys.modules["rankdrop.verbs.analyze"], "search", interrupting)
    analysis = analyze(open_robot("anthropomorphic"), starts=100)
    assert (analysis.complete, analysis.unfinished, len(analysis.coranks)) == (False, 2, 1)
    ended = run("analyze", "anthropomorphic", "--starts", "100", "--quiet", "--full")
    assert ended.code == exits.INTERRUPTED
    assert "Corank 1" in ended.out
    assert "Interrupted: corank 2 is unfinished" in ended.out
