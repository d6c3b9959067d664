"""`rankdrop view` as its own process."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from rankdrop.cli import exits

pytest.importorskip("viser", reason="viser and trimesh are not installed")
pytest.importorskip("trimesh", reason="viser and trimesh are not installed")


@pytest.mark.slow
def test_ctrl_c_ends_it_with_exit_code_0() -> None:
    command = [sys.executable, "-m", "rankdrop.cli.main", "view", "planar2r", "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("http://127.0.0.1:")
        assert process.stderr is not None
        assert "Ctrl-C ends it" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        try:
            out, err = process.communicate(timeout=180)
        finally:
            process.kill()
    assert process.returncode == exits.FINE
    assert out == ""
    assert err == "rankdrop: the viewer is closed\n"
