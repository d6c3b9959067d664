"""A folder of somebody else's files: no command runs a `json.py` or a `numpy.py` that lies there."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SHADOW = """from pathlib import Path
Path(__file__).with_suffix(".run").touch()
raise SystemExit("a file of the current folder was run")
"""
SPEC = """robot = "planar2r"
parameters.a = { sets = "1.a", lower = 1, upper = 2 }
sample = { kind = "sobol", variants = 2 }
near.samples = 100
"""
XACRO = """<robot name="two" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="a"/><link name="b"/>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>
"""
COMMANDS = {
    "compare": ("compare", "planar2r", "planar3r", "--workers", "2", "--quiet"),
    "sweep": ("sweep", "designs.toml", "--workers", "2", "--quiet"),
    "cover": ("cover", "planar2r", "--width", "0.4", "--quiet"),
    "find": ("find", "planar2r", "--corank", "1", "--starts", "20", "--store", "cloud", "--workers", "2"),
    "path": ("path", "planar2r", "paths", "--workers", "2", "--quiet"),
    "xacro": ("explain", "two.xacro", "--q", "0"),
    "analyze": ("analyze", "planar2r", "--starts", "50", "--quiet"),
}


@pytest.mark.by_hand_at("analyze", "cover")
@pytest.mark.by_hand_at("sweep", "find", "path", "xacro")
@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_runs_files_of_the_current_folder(command: str, tmp_path: Path) -> None:
    for name in ("numpy", "msgspec", "flint", "xacro", "rich", "cyclopts", "rankdrop", *sys.stdlib_module_names):
        if name.isidentifier():
            (tmp_path / f"{name}.py").write_text(SHADOW, encoding="utf-8")
    (tmp_path / "designs.toml").write_text(SPEC, encoding="utf-8")
    (tmp_path / "two.xacro").write_text(XACRO, encoding="utf-8")
    (tmp_path / "paths").mkdir()
    for name in ("a.csv", "b.csv"):
        (tmp_path / "paths" / name).write_text("q1,q2\n0.1,1\n0.2,1.1\n", encoding="utf-8")
    # -P, as the installed command: its own folder comes first, not the current one
    done = subprocess.run([sys.executable, "-P", "-m", "rankdrop", *COMMANDS[command]], cwd=tmp_path, text=True,
                          capture_output=True, env=os.environ | {"PYTHONSAFEPATH": ""}, check=False)  # fmt: skip
    assert [path.name for path in tmp_path.glob("*.run")] == []
    assert done.returncode in (0, 1, 3), done.stderr
