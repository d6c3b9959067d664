"""Job (c): a control engineer. A loop at 1 kHz that knows how near the next singularity is, in Python and in C++.

What has to be known: `rankdrop.Monitor` and its `step`; for C++ `rankdrop monitor ROBOT --header FILE`, and where the
headers are (`python -m rankdrop.headers --include-dir`).
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from jobs.shell import environment, run

pytestmark = pytest.mark.slow
PYTHON = """
import numpy as np
from rankdrop import Monitor, open_robot
from rankdrop.results.known import shipped
found = shipped("ur5e")
monitor = Monitor(found.robot, found.task, found.families)
start, end = np.radians([0, -90, 60, 0, 80, 0]), np.radians([0, -90, -20, 0, 80, 0])
rows = np.linspace(start, end, 1000)
slowest = 1.0
for q in rows:
    slowest = min(slowest, monitor.step(q, end - start).scaling)
print(slowest)
"""


def test_a_loop_in_python_slows_down(tmp_path: Path) -> None:
    (tmp_path / "loop.py").write_text(PYTHON, encoding="utf-8")
    done = subprocess.run([sys.executable, "loop.py"], cwd=tmp_path, env=environment(), capture_output=True, text=True,
                          timeout=600, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < 0.2  # the elbow is crossed at 0°


@pytest.mark.by_hand  # tests/core/test_headers.py builds and runs the same headers
def test_the_same_in_cpp(tmp_path: Path) -> None:
    compiler = shutil.which("c++") or shutil.which("g++")
    if compiler is None or shutil.which("cmake") is None or shutil.which("make") is None:
        pytest.skip("no C++ compiler, no cmake, or no make is installed")
    source = Path(__file__).resolve().parents[2] / "examples" / "cpp"
    told = subprocess.run([sys.executable, "-m", "rankdrop.headers", "--cmake-dir"], env=environment(), check=True,
                          capture_output=True, text=True)  # fmt: skip
    for command in (
        ["cmake", "-S", str(source), "-B", "build", f"-Drankdrop_DIR={told.stdout.strip()}", "-DROBOTS=ur5e",
         f"-DPython_EXECUTABLE={sys.executable}"],
        ["cmake", "--build", "build"],
    ):  # fmt: skip
        done = subprocess.run(command, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=600,
                              check=False)  # fmt: skip
        assert done.returncode == 0, done.stdout[-800:] + done.stderr[-800:]
    start, end = np.radians([0, -90, 60, 0, 80, 0]), np.radians([0, -90, -20, 0, 80, 0])
    rows = "\n".join(" ".join(map(repr, [*q.tolist(), *(end - start).tolist()])) for q in np.linspace(start, end, 1000))
    seen = subprocess.run([tmp_path / "build" / "watch", "ur5e"], input=rows, capture_output=True, text=True,
                          timeout=600, check=False)  # fmt: skip
    assert seen.returncode == 0, seen.stderr  # 3 where a step has allocated memory
    lines = [line.split() for line in seen.stdout.splitlines()]
    assert len(lines) == 1000
    assert min(float(line[7]) for line in lines) < 0.2  # scaling


def test_the_header_of_an_arm_is_one_command(tmp_path: Path) -> None:
    done = run(tmp_path, "monitor", "ur5e", "--header", "ur5e.h")
    assert done.returncode == 0, done.stderr
    assert "rankdrop_ur5e_arm" in (tmp_path / "ur5e.h").read_text(encoding="utf-8")
