"""Numbers of aspects of random arms beside a flood fill that shares no code: `benchmarks/aspects.py`."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
KINDS = ("3R", "wrist", "three parallel", "offset wrist")
DOUBLED = """
import aspects  # first: sets the number of threads
from dataclasses import replace
right = aspects.count_of_arm
def wrong(arm, task):
    count, signs = right(arm, task)
    return replace(count, each=count.each * 2), signs
aspects.count_of_arm = wrong
raise SystemExit(aspects.main(["--quick", "--each", "1", "--kinds", "3R"]))
"""


@pytest.mark.slow
def test_two_random_arms_of_each_kind_have_as_many_aspects_as_a_flood_fill_finds() -> None:
    command = [sys.executable, str(BENCHMARKS / "aspects.py"), "--quick", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = json.loads(done.stdout)["rows"]
    assert {row["kind"]: row["agree"] for row in rows} == dict.fromkeys(KINDS, 2)


@pytest.mark.slow
def test_a_wrong_number_is_noticed() -> None:
    done = subprocess.run([sys.executable, "-c", DOUBLED], cwd=BENCHMARKS, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert "3R 0: differ: rankdrop" in done.stderr
