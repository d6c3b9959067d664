"""A foreign parser that takes too much, crashes or reaches for the network costs one line of error."""

from __future__ import annotations

import ctypes
import errno
import math
import os
import socket
import sys
import tempfile
from pathlib import Path

import pytest

from rankdrop.errors import OptionError, RankdropError, RobotError
from rankdrop.jobs.limited import run_limited

ON_LINUX = pytest.mark.skipif(sys.platform != "linux", reason="the system has no such limit")


def sums(numbers: list[float]) -> dict[str, float]:
    return {"sum": math.fsum(numbers)}


def raw() -> bytes:
    return b"a\nb"


def fill() -> int:
    return len(bytearray(2**31))


def spin() -> None:
    while True:
        pass


def crash() -> None:
    ctypes.string_at(0)


def write(path: str) -> None:
    with open(path, "wb", buffering=0) as stream:
        stream.write(b"x")


def connects(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), timeout=5).close()
    except OSError:
        return False
    return True


def has_namespaces() -> bool:
    libc = ctypes.CDLL(None)
    return any(libc.unshare(flags) == 0 for flags in (0x40000000, 0x50000000))


def refuse() -> None:
    raise RankdropError("no arm", where="here", allowed="an arm")


def chatter() -> int:
    os.write(1, b"printed\n")
    print("more")
    return 3


@pytest.mark.slow
def test_plain_data_and_bytes_come_back() -> None:
    assert run_limited(sums, [0.1, 0.2], file="f", parser="P") == {"sum": math.fsum([0.1, 0.2])}
    assert run_limited(raw, file="f", parser="P") == b"a\nb"
    assert run_limited(chatter, file="f", parser="P") == 3  # what a parser prints is no answer


@pytest.mark.slow
def test_errors_come_back_in_the_type_that_is_wanted() -> None:
    with pytest.raises(RobotError, match="here: no arm; allowed: an arm"):
        run_limited(refuse, file="f", parser="P")
    with pytest.raises(OptionError, match="the file cannot be read: FileNotFoundError"):
        run_limited(write, "/no/such/folder/x", file="f", parser="P", error=OptionError)


@pytest.mark.slow
@ON_LINUX
def test_memory_and_processor_time_end() -> None:
    with pytest.raises(RobotError, match=r"bomb\.xml: P needs more than 1 GB of memory"):
        run_limited(fill, file="bomb.xml", parser="P")
    with pytest.raises(RobotError, match=r"bomb\.xml: P needs more than 1 s of processor time"):
        run_limited(spin, file="bomb.xml", parser="P", cpu=1)


@pytest.mark.skipif(sys.platform == "win32", reason="no signals")
def test_a_crash_is_one_line() -> None:
    with pytest.raises(RobotError, match=r"f: P crashes on the file \(exit code -11\)"):
        run_limited(crash, file="f", parser="P")


@pytest.mark.slow
@ON_LINUX
def test_nothing_is_written(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=os.strerror(errno.EFBIG)):
        run_limited(write, str(tmp_path / "x"), file="f", parser="P")


@pytest.mark.slow
@ON_LINUX
def test_the_network_is_out_of_reach() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        assert connects(port)
        cut_off = not run_limited(connects, port, file="f", parser="P")
        assert cut_off is run_limited(has_namespaces, file="f", parser="P")


def writes(size: int) -> str:
    with tempfile.TemporaryFile() as stream:
        stream.write(bytes(size))
    kept = Path(tempfile.mkdtemp()) / "left"
    kept.write_bytes(b"x")
    return str(kept)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no such limit")
def test_a_temporary_folder_has_a_limit_and_is_removed() -> None:
    kept = Path(run_limited(writes, 1000, file="f", parser="P", scratch=1000))
    assert not kept.parent.parent.exists()
    with pytest.raises(RobotError, match=os.strerror(errno.EFBIG)):
        run_limited(writes, 1001, file="f", parser="P", scratch=1000)
