"""The server: behind its gate, on a port of its own, silent on stdout, ended by Ctrl-C."""

from __future__ import annotations

import contextlib
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from http.client import HTTPConnection
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from patience import until

from rankdrop.cli import exits, main
from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.kinematics import link_poses
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

pytest.importorskip("viser", reason="viser and trimesh are not installed")
pytest.importorskip("trimesh", reason="viser and trimesh are not installed")

from rankdrop.viewer.access import free_port
from rankdrop.viewer.server import Viewer, Wishes

HANDSHAKE = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
             "Sec-WebSocket-Key": "cmFua2Ryb3AgdGhlIGdhdA=="}  # fmt: skip


def viewer_of(name: str, **wishes: object) -> Viewer:
    arm = open_robot(name)
    return Viewer(arm, resolve_task(None, arm), Wishes(port=0, **wishes))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    made = viewer_of("puma560")
    yield made
    made.close()


def answer(viewer: Viewer, path: str = "/", **headers: str) -> tuple[int, dict[str, str]]:
    """Status and headers of a request; handshakes too, with `Upgrade`."""
    port = viewer.server.get_port()
    connection = HTTPConnection("127.0.0.1", port, timeout=180)
    try:
        given = {"Host": f"localhost:{port}", **{name.replace("_", "-"): text for name, text in headers.items()}}
        connection.request("GET", path, headers=given)
        response = connection.getresponse()
        return response.status, dict(response.headers)
    finally:
        connection.close()


def test_the_page_is_served_to_its_own_machine(viewer: Viewer) -> None:
    status, headers = answer(viewer)
    assert status == 200
    assert headers["X-Frame-Options"] == "DENY"
    assert "Set-Cookie" not in headers
    assert viewer.url == f"http://127.0.0.1:{viewer.server.get_port()}/"


def test_foreign_names_and_origins_get_neither_page_nor_websocket(viewer: Viewer) -> None:
    for more in ({}, HANDSHAKE):
        assert answer(viewer, Host="evil.example", **more)[0] == 403
        assert answer(viewer, Origin="http://evil.example", **more)[0] == 403
    own = f"http://localhost:{viewer.server.get_port()}"
    assert answer(viewer, Origin=own, Sec_WebSocket_Protocol="viser-v0", **HANDSHAKE)[0] == 101


def test_it_listens_on_the_loopback_address_only(viewer: Viewer) -> None:
    table = Path("/proc/net/tcp")
    if not table.exists():
        pytest.skip("no /proc/net/tcp on this system")
    sockets = [line.split() for line in table.read_text(encoding="ascii").splitlines()[1:]]
    port = f":{viewer.server.get_port():04X}"
    assert {words[1] for words in sockets if words[1].endswith(port) and words[3] == "0A"} == {f"0100007F{port}"}


def test_exposed_it_wants_the_token() -> None:
    viewer = viewer_of("planar2r", host="0.0.0.0", expose=True)
    try:
        path = "/" + viewer.url.rpartition("/")[2]
        assert "token=" in path
        assert answer(viewer)[0] == 403
        assert answer(viewer, **HANDSHAKE)[0] == 403
        status, headers = answer(viewer, path)
        assert status == 200
        cookie = headers["Set-Cookie"].partition(";")[0]
        assert answer(viewer, Cookie=cookie)[0] == 200
        assert answer(viewer, Cookie=cookie, Sec_WebSocket_Protocol="viser-v0", **HANDSHAKE)[0] == 101
    finally:
        viewer.close()


JUNK = {"no message": b"\xc1\xff", "text": "hello", "unknown": b"\x81\xa4type\xa3abc", "empty": b"", "list": b"\x90"}


@pytest.mark.parametrize("kind", JUNK)
def test_junk_of_a_client_is_one_line(kind: str, viewer: Viewer, caplog: pytest.LogCaptureFixture) -> None:
    """It was a traceback of 17 lines. The viewer goes on."""
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    protocol = f"viser-v{version('viser')}"
    address = f"ws://localhost:{viewer.server.get_port()}/"
    with connect(address, subprotocols=[protocol]) as page:  # type: ignore[list-item]
        page.send(JUNK[kind])
        with contextlib.suppress(ConnectionClosed):
            while True:
                page.recv(timeout=180)
    told = [caplog.handler.format(record) for record in caplog.records if record.name.startswith("rankdrop")]
    assert len(told) == 1
    assert "\n" not in told[0]
    assert "it sent what cannot be read" in told[0]
    assert answer(viewer)[0] == 200


def test_no_client_can_ask_for_a_tunnel(viewer: Viewer) -> None:
    assert viewer.server.request_share_url() is None


def test_a_port_in_use_is_an_error_or_the_next_one_is_taken() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(OptionError, match=f"the port is in use; got {port}"):
            free_port("127.0.0.1", port, next_one=False)
        assert free_port("127.0.0.1", port, next_one=True) > port


def test_the_scene_follows_the_session(viewer: Viewer) -> None:
    q = np.array([0.4, 0.3, -0.2, 0.5, 0.0, 0.1])
    viewer.session.set(q)
    poses = link_poses(viewer.controls.robot, q)
    shown = np.degrees(q).round(1).tolist()
    until(lambda: viewer.controls.found is not None and bool((viewer.controls.found.q == q).all()))
    until(lambda: all(np.allclose(drawn.position, pose[:3, 3])
                      for drawn, pose in zip(viewer.stage.links, poses, strict=True)))  # fmt: skip
    until(lambda: viewer.stage.blamed == {4: 0, 6: 0})
    until(lambda: [slider.value for slider in viewer.controls.sliders] == shown)


LATE = """
import os, signal, threading, time
from rankdrop.cli.view import _wait
threading.Thread(target=lambda: (time.sleep(0.2), os.kill(os.getpid(), signal.SIGINT))).start()
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
try:
    _wait()
except KeyboardInterrupt:
    print("ended")
"""
"""The signal reaches another thread: as where it comes while a wait begins, nothing wakes the wait of the main one."""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="needs signals of threads")
def test_a_ctrl_c_that_wakes_nothing_ends_it() -> None:
    done = subprocess.run([sys.executable, "-c", LATE], capture_output=True, text=True, timeout=180)
    assert (done.stdout, done.returncode) == ("ended\n", 0), done.stderr


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (["--host", "0.0.0.0"], "reachable from other machines"),
        (["--expose"], "not reachable from other machines"),
        (["--port", "70000"], "--port: this value is not allowed"),
        (["--q", "1,2,3"], "2 joint values are needed"),
        (["--trajectory", "missing.csv"], "missing.csv"),
        (["--analysis", "missing.json"], "missing.json"),
    ],
)
def test_bad_input_is_one_line(argv: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["view", "planar2r", "--no-browser", *argv]) == exits.BAD_INPUT
    captured = capsys.readouterr()
    assert captured.out == ""
    assert said in captured.err
    assert captured.err.count("\n") == 1


def test_without_viser_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingExtraError, match=r"s source: pip install \"\.\[viewer\]\"$"):
        viewer_of("planar2r")


def test_it_listens_on_the_other_loopback_address_too() -> None:
    try:
        free_port("::1", 0, next_one=False)
    except OptionError:
        pytest.skip("this machine has no IPv6")
    viewer = viewer_of("planar2r", host="::1")
    try:
        assert viewer.url == f"http://[::1]:{viewer.server.get_port()}/"
    finally:
        viewer.close()
