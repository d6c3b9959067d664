"""Nothing leaves the machine: commands run in a network namespace without routes, and try no address at all."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

UNSHARE = shutil.which("unshare")

WATCH = """
import os, sys
def watch(event, args):
    if event in ("socket.getaddrinfo", "socket.gethostbyname", "socket.gethostbyaddr"):
        asked = repr(args)
    elif event in ("socket.connect", "socket.sendto", "socket.sendmsg"):
        if not isinstance(args[1], tuple) or args[1][0] in ("127.0.0.1", "::1"):
            return  # a pipe between its own processes, or the viewer trying its own gate
        asked = repr(args[1])
    else:
        return
    with open(os.environ["TRIED"], "a") as file:
        file.write(f"{event} {asked} by {sys.argv}\\n")
sys.addaudithook(watch)
"""
"""Installed in every Python process as it starts, those that a command starts included."""

COMMANDS = {
    "analyze planar3r --json a.json --quiet": 0,
    "analyze arm.urdf --fresh --starts 100 --quiet": 0,
    "conditions scara": 0,
    "explain ur5 --q 0,0,0,0,0,0": 4,
    "nearest scara --q 0.1,0.2,0.1,0.3": 0,
    "report a.json --out page.html": 0,
    "path planar3r p.csv --html path.html": 3,
    "monitor planar2r --header arm.h": 0,
    "robots": 0,
}
URDF = """<robot name="r">
  <link name="a"> <visual> <geometry> <mesh filename="http://mesh.invalid/a.stl"/> </geometry> </visual> </link>
  <link name="b"/> <link name="c"/>
  <joint name="j" type="continuous"> <parent link="a"/> <child link="b"/> <axis xyz="0 0 1"/> </joint>
  <joint name="k" type="continuous"> <parent link="b"/> <child link="c"/> <origin xyz="1 0 0"/>
  <axis xyz="0 1 0"/> </joint>
</robot>"""


def alone(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run Python with these arguments where there is no network but the loopback, and none is to be tried."""
    (folder / "sitecustomize.py").write_text(WATCH, encoding="utf-8")
    (folder / "arm.urdf").write_text(URDF, encoding="utf-8")
    (folder / "p.csv").write_text("q1,q2,q3\n0.5,0.5,0.5\n0.5,-0.5,0.5\n", encoding="utf-8")
    path = os.pathsep.join([str(folder), *(entry for entry in sys.path if entry)])
    more = {"PYTHONPATH": path, "TRIED": str(folder / "tried"), "HOME": str(folder), "MPLCONFIGDIR": str(folder)}
    script = f"(ip link set lo up || ifconfig lo up) 2>/dev/null; exec '{sys.executable}' {line}"
    command = ["unshare", "--map-root-user", "--net", "sh", "-c", script]
    return subprocess.run(
        command, cwd=folder, text=True, timeout=300, capture_output=True, env=os.environ | more, check=False
    )


needed = pytest.mark.skipif(
    UNSHARE is None or subprocess.run([UNSHARE, "-r", "-n", "true"], check=False, capture_output=True).returncode != 0,
    reason="no network namespace can be made here",
)


@needed
def test_an_address_that_is_tried_is_seen(tmp_path: Path) -> None:
    code = "import urllib.request as u, contextlib as c\nwith c.suppress(OSError): u.urlopen('http://there.invalid')"
    (tmp_path / "try.py").write_text(code, encoding="utf-8")
    assert alone("try.py", tmp_path).returncode == 0
    assert "there.invalid" in (tmp_path / "tried").read_text(encoding="utf-8")


@pytest.mark.by_hand
@needed
def test_no_command_tries_the_network(tmp_path: Path) -> None:
    for command, code in COMMANDS.items():
        done = alone(f"-m rankdrop {command}", tmp_path)
        assert done.returncode == code, f"{command}: {done.stdout[-500:]} {done.stderr[-500:]}"
    assert not (tmp_path / "tried").exists(), (tmp_path / "tried").read_text(encoding="utf-8")


@pytest.mark.by_hand
@needed
def test_the_viewer_is_served_without_a_network(tmp_path: Path) -> None:
    """Its page is asked for on the loopback, in the namespace."""
    pytest.importorskip("viser", reason="viser and trimesh are not installed")
    code = """
import socket
from urllib.request import urlopen
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.server import Viewer, Wishes
try:
    socket.create_connection(("192.0.2.1", 9), timeout=5)
    raise SystemExit("there is a route")
except OSError:
    pass
arm = open_robot("planar2r")
viewer = Viewer(arm, resolve_task(None, arm), Wishes(port=0))
print(urlopen(viewer.url, timeout=20).status)
viewer.close()
"""
    (tmp_path / "view.py").write_text(code, encoding="utf-8")
    done = alone("view.py", tmp_path)
    if "Cannot assign requested address" in done.stderr or "Network is unreachable" in done.stderr:
        pytest.skip("the loopback cannot be put up here: neither ip nor ifconfig")
    assert done.stdout.strip() == "200", done.stderr
    tried = (tmp_path / "tried").read_text(encoding="utf-8").splitlines()
    # the name of a loopback address is asked of the system's own table; 192.0.2.1 is the try above
    assert [line for line in tried if "192.0.2.1" not in line and "127.0.0.1" not in line] == []
