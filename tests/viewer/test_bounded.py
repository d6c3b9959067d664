"""Whoever is let in takes no more than a bounded part of the memory: silent clients, huge messages, endless uploads."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="viser and trimesh are not installed")
pytest.importorskip("trimesh", reason="viser and trimesh are not installed")
if sys.platform != "linux":
    pytest.skip("memory of another process is read from /proc", allow_module_level=True)

import viser
from viser import _messages as messages
from viser.infra._messages import Message
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from rankdrop.viewer.access import LARGEST_MESSAGE, LARGEST_UPLOAD, MOST_CLIENTS

SERVER = """
import sys
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.server import Viewer, Wishes
arm = open_robot("planar2r")
viewer = Viewer(arm, resolve_task(None, arm), Wishes(port=0))
gui = viewer.server.gui._gui_input_handle_from_uuid
button = next(key for key, one in gui.items() if "Upload" in type(one).__name__)
print(viewer.server.get_port(), button, flush=True)
for line in sys.stdin:
    states = viewer.server.gui._current_file_upload_states
    print(len(states), viewer.path.trajectory and viewer.path.trajectory.name, flush=True)
viewer.close()
"""
pytestmark = pytest.mark.slow  # seconds of waiting
MB = 2**20


class Server:
    """A viewer in a process of its own, whose memory can be read."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process
        self.port, self.button = self._line()

    def _line(self) -> list[str]:
        assert self.process.stdout is not None
        return self.process.stdout.readline().split()

    def asked(self) -> list[str]:
        """Uploads under way, and the name of the trajectory that is open."""
        assert self.process.stdin is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return self._line()

    def held(self, key: str = "VmRSS") -> int:
        """Memory [bytes]: VmRSS now, VmHWM the most there was."""
        lines = Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii").splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(key))

    def client(self) -> ClientConnection:
        """A page, as viser's own is one."""
        return connect(f"ws://127.0.0.1:{self.port}", subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
                       max_size=None, compression=None, open_timeout=180)  # fmt: skip

    def page(self) -> ClientConnection:
        """A client that says where its camera is, as pages do before anything they do counts."""
        made = self.client()
        camera = messages.ViewerCameraMessage(
            (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0, 0.1, 10.0, 100, 100, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
        )
        made.send(packed(camera))
        time.sleep(0.3)
        return made

    def start(self, transfer: str, size: int, parts: int) -> Message:
        """The message that begins an upload."""
        return messages.FileTransferStartUpload(self.button, transfer, f"{transfer}.csv", "text/csv", parts, size)

    def part(self, transfer: str, number: int, content: bytes) -> Message:
        """One part of it."""
        return messages.FileTransferPart(self.button, transfer, number, content)


def packed(message: Message) -> bytes:
    """As it goes over the wire."""
    import msgspec

    return msgspec.msgpack.encode({**message.as_serializable_dict(), "type": type(message).__name__})


def to_the_end(client: ClientConnection, message: bytes | None = None) -> None:
    """Send a message, and read until the server closes the connection."""
    if message is not None:
        client.send(message)
    while True:
        client.recv(timeout=180)


@pytest.fixture
def server() -> Iterator[Server]:
    with subprocess.Popen(
        [sys.executable, "-c", SERVER],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    ) as process:  # fmt: skip
        try:
            yield Server(process)
        finally:
            process.kill()


def settled(server: Server, wanted: str, within: float = 180.0) -> list[str]:
    """What the server answers once the open trajectory has this name."""
    end = time.monotonic() + within
    while (told := server.asked())[1] != wanted:
        assert time.monotonic() < end, told
        time.sleep(0.05)
    return told


@pytest.mark.by_hand
def test_a_hundred_silent_clients(server: Server) -> None:
    """They connect and read nothing; more than the server wants are sent away, and who leaves makes room."""
    with server.client():
        time.sleep(0.5)
    before = server.held()
    with ExitStack() as stack:
        clients = [stack.enter_context(server.client()) for _ in range(100)]
        time.sleep(1.0)
        for client in clients[MOST_CLIENTS + 1 :]:
            with pytest.raises(ConnectionClosed, match="1013"):
                to_the_end(client)
        assert server.held("VmHWM") - before < 150 * MB
    time.sleep(0.5)
    with server.client() as again:
        assert again.recv(timeout=180)


@pytest.mark.by_hand
def test_a_message_of_200_megabytes_is_refused(server: Server) -> None:
    with server.client():
        time.sleep(0.5)
    before = server.held()
    for _ in range(3):
        with server.client() as client, pytest.raises(ConnectionClosed):
            to_the_end(client, bytes(200 * MB))
    assert server.held("VmHWM") - before < 40 * MB
    with server.client() as client, pytest.raises(ConnectionClosed, match="1009"):
        to_the_end(client, bytes(LARGEST_MESSAGE + 1))


@pytest.mark.by_hand
def test_a_thousand_uploads(server: Server) -> None:
    """Whole ones, those that never end, that say too little, and that say more than is allowed."""
    rows = b"q1,q2\n" + b"0.1,0.2\n" * 4000  # 32 kB
    with server.page() as client:
        client.send(packed(server.start("first", len(rows), 1)))
        client.send(packed(server.part("first", 0, rows)))
        settled(server, "first.csv")
        before = server.held()
        for i in range(1000):
            name, kind = f"u{i}", i % 4
            if kind == 0:
                client.send(packed(server.start(name, len(rows), 1)))
                client.send(packed(server.part(name, 0, rows)))
            elif kind == 1:
                client.send(packed(server.start(name, LARGEST_UPLOAD + 1, 200)))
                client.send(packed(server.part(name, 0, bytes(512 * 1024))))
            elif kind == 2:
                client.send(packed(server.start(name, 10, 10)))
                for number in range(4):
                    client.send(packed(server.part(name, number, bytes(512 * 1024))))
            else:
                client.send(packed(server.start(name, 20 * MB, 40)))
                client.send(packed(server.part(name, 0, bytes(512 * 1024))))
        client.send(packed(server.start("late", 10, 10**9)))
    time.sleep(0.5)
    with server.page() as client:  # who left has left nothing behind
        client.send(packed(server.start("last", len(rows), 1)))
        client.send(packed(server.part("last", 0, rows)))
        assert settled(server, "last.csv")[0] == "0"
    assert server.held("VmHWM") - before < 150 * MB
