"""Pipes, devices and names that no file system takes: one line of error, and no wait."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")

READ = {
    "npz": ("path", "planar2r", "{}.npz"), "npy": ("path", "planar2r", "{}.npy"), "bag": ("path", "planar2r", "{}.bag"),
    "mcap": ("path", "planar2r", "{}.mcap"), "csv": ("path", "planar2r", "{}.csv"), "verify": ("verify", "{}.json"),
    "sweep": ("sweep", "{}.toml"), "robot": ("analyze", "{}.toml"), "urdf": ("analyze", "{}.urdf"),
    "analysis": ("explain", "planar2r", "--q", "0,0", "--analysis", "{}.json"),
}  # fmt: skip


@pytest.mark.parametrize("kind", READ)
def test_a_pipe_is_not_read(kind: str, tmp_path: Path, run: Any) -> None:
    words = [word.format(tmp_path / "pipe") for word in READ[kind]]
    os.mkfifo(next(word for word in words if word.startswith(str(tmp_path))))
    done = run(*words)
    assert done.code == 2
    assert "this is not a file" in done.err


@pytest.mark.parametrize("command", ["sweep", "path", "cover"])
def test_a_job_folder_with_a_pipe_is_no_job(command: str, tmp_path: Path, run: Any) -> None:
    os.mkfifo(tmp_path / "job.json")
    done = run(command, "--status", str(tmp_path))
    assert done.code == 2
    assert "there is no job in the folder" in done.err


LONG = "a" * 300
NAMED = {
    "arm": ("analyze", f"{LONG}.urdf"), "path": ("path", "planar2r", f"{LONG}.csv"), "sweep": ("sweep", f"{LONG}.toml"),
    "json": ("explain", "planar2r", "--q", "0,0", "--json", LONG), "verify": ("verify", f"{LONG}.json"),
    "report": ("report", "planar2r", "--out", LONG), "cover": ("cover", "planar2r", "--width", "1", "--out", LONG),
    "python": ("conditions", "planar2r", "--python", f"{LONG}.py"), "status": ("sweep", "--status", LONG),
    "header": ("monitor", "planar2r", "--header", f"{LONG}.h"),
}  # fmt: skip


@pytest.mark.parametrize("kind", NAMED)
def test_a_name_that_is_too_long_is_an_error_of_one_line(kind: str, run: Any) -> None:
    done = run(*NAMED[kind])
    assert done.code == 2
    assert done.err.count("error:") == 1
    assert "Traceback" not in done.err


def test_a_carriage_return_ends_a_line(tmp_path: Path, run: Any) -> None:
    (tmp_path / "old.csv").write_bytes(b"q1,q2\r0,1\r0.1,1.1\r")
    assert run("path", "planar2r", str(tmp_path / "old.csv")).code == 0
    (tmp_path / "head.csv").write_bytes(b"q1,\rq2\n0,1\n")
    assert run("path", "planar2r", str(tmp_path / "head.csv")).code == 2
