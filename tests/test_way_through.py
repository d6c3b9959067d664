"""docs/way-through.md: the functions that a command passes, in the order of their first calls."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "way-through.md").read_text(encoding="utf-8")
ARM = ROOT / "tests" / "data" / "arms" / "meca500r3.urdf"
COMMANDS = {
    "From a URDF to its families": ["analyze", str(ARM), "--quiet", "--starts", "300"],
    "From a configuration to its ways out": ["explain", "puma560", "--q", "0.3,0.5,0.4,0.2,0,0.6"],
}
MOST = 25

TRACE = """
import contextlib, io, json, os, sys
import rankdrop
from rankdrop.cli.main import run
root, first = os.path.dirname(rankdrop.__file__) + os.sep, {}
def look(frame, event, _):
    code = frame.f_code
    if event == "call" and code.co_filename.startswith(root):
        module = code.co_filename[len(root):-3].replace(os.sep, ".")
        first.setdefault(f"{module}.{code.co_qualname}", len(first))
sys.setprofile(look)
with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
    run(sys.argv[1:])
sys.setprofile(None)
print(json.dumps(list(first)))
"""


@pytest.mark.by_hand_at("From a URDF to its families")
@pytest.mark.slow_at("From a URDF to its families", "From a configuration to its ways out")
@pytest.mark.parametrize("title", COMMANDS)
def test_the_functions_of_the_page_are_called_in_its_order(title: str) -> None:
    part = PAGE.split(f"## {title}")[1].split("\n## ")[0]
    listed = re.findall(r"^\| (\d+) \| `([\w.]+)` \|", part, flags=re.M)
    assert [int(number) for number, _ in listed] == list(range(1, len(listed) + 1))
    assert 15 <= len(listed) <= MOST
    done = subprocess.run([sys.executable, "-c", TRACE, *COMMANDS[title]], capture_output=True, text=True, check=True)
    passed = json.loads(done.stdout)
    names = [name for _, name in listed]
    assert [name for name in names if name not in passed] == []
    assert sorted(names, key=passed.index) == names
