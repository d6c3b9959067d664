"""Job (e): a teacher. A live lesson: the viewer, its tour of shoulder, elbow and wrist, and a page to hand out.

What has to be known: `rankdrop view ROBOT`, the tab "Tour", and `rankdrop report ROBOT` for the page.
"""

from __future__ import annotations

import signal
import subprocess
import sys
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from jobs.shell import environment, run

pytest.importorskip("viser", reason="viser and trimesh are not installed")
pytestmark = pytest.mark.slow


@pytest.mark.by_hand
def test_the_page_opens_and_ends_with_ctrl_c(tmp_path: Path) -> None:
    viewer = subprocess.Popen(
        [sys.executable, "-m", "rankdrop", "view", "puma560", "--no-browser", "--port", "0"], cwd=tmp_path,
        env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert viewer.stdout is not None
        address = urlsplit(viewer.stdout.readline().strip())
        connection = HTTPConnection(address.hostname or "", address.port, timeout=600)
        connection.request("GET", "/?q=10,20,30,40,0,50")
        assert connection.getresponse().status == 200
        connection.close()
        viewer.send_signal(signal.SIGINT)
        assert viewer.wait(timeout=600) == 0
    finally:
        if viewer.poll() is None:
            viewer.kill()
        viewer.communicate()


@pytest.mark.by_hand
def test_the_hand_out_is_one_page(tmp_path: Path) -> None:
    done = run(tmp_path, "report", "puma560", "--out", "lesson.html", "--quiet")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "lesson.html").read_text(encoding="utf-8")
    for part in ("shoulder", "elbow", "wrist", "keep to the joint limits", "Download"):
        assert part in text
