"""Every numbered example runs, quickly, and prints what is recorded.

After a change that is meant, write the records again and read the difference:

    RANKDROP_GOLDEN=write pytest tests/docs/test_examples.py -m "slow or not slow" && git diff examples/output
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SCRIPTS = sorted(EXAMPLES.glob("[0-9]*_*.py"))
WRITE = os.environ.get("RANKDROP_GOLDEN") == "write"
SECONDS = 600  # most of them take one or two; an example that hangs fails


def rounded(text: str) -> str:
    """The same text whatever the last bits of values that are zero, or of points chosen among many that are as good."""
    return re.sub(r"-?−?\d(\.\d+)?e[-−]\d+", "0", text)


def printed(script: Path, tmp_path: Path) -> str:
    """What a script prints, in an empty folder."""
    environment = {**os.environ, "PYTHONIOENCODING": "utf-8", "PYTHONWARNINGS": "error"}
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, env=environment, timeout=SECONDS, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr.decode()
    assert done.stderr == b""
    return done.stdout.decode()


@pytest.mark.by_hand_at(
    "11_which_tool_offset", "01_every_family_of_an_arm", "04_how_far", "06_exact_conditions", "07_your_own_arm",
    "09_is_this_formula_right", "10_elbow_up_elbow_down", "12_inside_my_limits", "14_which_design",
)  # fmt: skip
@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_examples_print_what_is_recorded(script: Path, tmp_path: Path) -> None:
    text = printed(script, tmp_path)
    record = EXAMPLES / "output" / f"{script.stem}.txt"
    if WRITE:
        record.write_text(text, encoding="utf-8")
    assert rounded(text) == rounded(record.read_text(encoding="utf-8"))
    assert list(tmp_path.iterdir()) == []


def test_examples_are_numbered_short_and_recorded() -> None:
    assert [script.name[:2] for script in SCRIPTS] == [f"{i:02}" for i in range(1, len(SCRIPTS) + 1)]
    assert {script.stem for script in SCRIPTS} == {record.stem for record in (EXAMPLES / "output").glob("*.txt")}
    assert all(len(script.read_text(encoding="utf-8").splitlines()) <= 60 for script in SCRIPTS)
