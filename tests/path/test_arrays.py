"""NumPy's files: headers are judged before anything is unpacked, so that no small file costs much memory or time."""

from __future__ import annotations

import io
import os
import tracemalloc
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any
from zipfile import ZIP_BZIP2, ZIP_DEFLATED, ZIP_LZMA, ZIP_STORED, ZipFile

import numpy as np
import pytest
from numpy.lib.format import write_array_header_1_0, write_array_header_2_0

from rankdrop.path.read.arrays import read_arrays
from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.files import MOST_MEMBERS
from rankdrop.robot.open import open_robot

ARM = open_robot("scara")
NAMES = [joint.name for joint in ARM.variables]
Q = np.array([[0.1, 0.2, 0.03, 0.4], [0.2, 0.3, 0.04, 0.5]])
LARGE = 20 * 2**20


def array_of(descr: Any, shape: Any, size: int = LARGE) -> bytes:
    """A header of any type and shape, and so many zeros."""
    stream = io.BytesIO()
    write_array_header_1_0(stream, {"descr": descr, "fortran_order": False, "shape": shape})
    return stream.getvalue() + bytes(size)


def packed(path: Path, members: dict[str, bytes], how: int = ZIP_DEFLATED) -> Path:
    with ZipFile(path, "w", how) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return path


def whole(value: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.array(value))
    return stream.getvalue()


def long_header() -> bytes:
    stream = io.BytesIO()
    write_array_header_2_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (2, 4)})
    return stream.getvalue()[:8] + (LARGE).to_bytes(4, "little") + b" " * LARGE


def made(descr: Any, shape: Any, size: int = LARGE) -> Callable[[], bytes]:
    """`array_of`, 20 MB each, when a test asks for it."""
    return partial(array_of, descr, shape, size)


def held(value: Any) -> Callable[[], bytes]:
    return partial(whole, value)


REFUSED: dict[str, tuple[Callable[[], bytes], str]] = {
    "bytes": (made("|i1", (10**9, 1)), "the array is too large; got 1000000000 numbers"),
    "many rows": (made("|i1", (20_000_000, 1)), "there are too many rows; got 20000000"),
    "truth": (made("|b1", (5_000_000, 4)), "these are no numbers; got an array of bool"),
    "text": (made("<U2000000", (2, 1)), "these are no numbers; got an array of <U2000000"),
    "no text": (made("<U0", (2, 4)), "these are no numbers"),
    "nothing": (made("|V0", (2, 4)), "these are no numbers; got an array of |V0"),
    "raw": (made("|V16", (2, 4)), "these are no numbers; got an array of |V16"),
    "complex": (made("<c16", (2, 4)), "these are no numbers; got an array of complex128"),
    "dates": (made("<M8[s]", (2, 4)), r"these are no numbers; got an array of datetime64\[s\]"),
    "spans": (made("<m8[s]", (2, 4)), r"these are no numbers; got an array of timedelta64\[s\]"),
    "objects": (made("|O", (2, 4)), "these are no numbers; got an array of object"),
    "record": (made([("a", "<f8")], (2, 4)), "these are no numbers; got an array of"),
    "huge": (made("<f8", (2**62, 2**62)), "the array is too large"),
    "negative": (made("<f8", (-1, 4)), "the array has a negative size"),
    "short": (made("<f8", (1000, 4), size=0), "this is not a file of NumPy's"),
    "long header": (long_header, "this is not a file of NumPy's"),
    "plain text": (lambda: b"hello" + bytes(LARGE), "this is not a file of NumPy's"),
}


@pytest.mark.spread(15)
@pytest.mark.slow
@pytest.mark.parametrize("kind", REFUSED)
@pytest.mark.parametrize("ending", ["npy", "npz"])
def test_what_is_refused_is_not_unpacked(kind: str, ending: str, tmp_path: Path) -> None:
    make, said = REFUSED[kind]
    content = make()
    path = tmp_path / f"a.{ending}"
    if ending == "npz":
        packed(path, {"q": content})
    else:
        path.write_bytes(content)
    del content
    tracemalloc.start()
    try:
        with pytest.raises(TrajectoryError, match=said) as caught:
            read_trajectory(path, ARM)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 500
    assert peak < LARGE / 4, f"{peak:,} bytes"


MEMBERS: dict[str, tuple[dict[str, Callable[[], bytes]], str]] = {
    "times of bytes": ({"q": held(Q), "t": made("|i1", (10**8,))}, "t: the array is too large"),
    "rows of times": ({"q": held(Q), "t": made("|i1", (2 * 10**6,))}, "t: there are too many rows"),
    "names of numbers": ({"q": held(Q), "joint_names": held([1.0] * 4)}, "joint_names: these are no names"),
    "long names": ({"q": held(Q), "joint_names": made("<U100000", (4,))}, "too many or too long"),
    "many names": ({"q": held(Q), "joint_names": made("<U2", (10**6,))}, "too many or too long"),
    "empty names": ({"q": held(Q), "joint_names": made("<U0", (4,))}, "too many or too long"),
    "names of objects": ({"q": held(Q), "joint_names": made("|O", (4,))}, "these are no names"),
    "no positions": ({"x": held(Q)}, "the archive has no positions; got x"),
}  # fmt: skip


@pytest.mark.parametrize("kind", MEMBERS)
def test_every_array_of_an_archive_is_judged(kind: str, tmp_path: Path) -> None:
    members, said = MEMBERS[kind]
    path = packed(tmp_path / "a.npz", {name: make() for name, make in members.items()})
    tracemalloc.start()
    try:
        with pytest.raises(TrajectoryError, match=said):
            read_trajectory(path, ARM)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < LARGE / 4, f"{peak:,} bytes"


def test_arrays_are_counted_together(tmp_path: Path) -> None:
    one = array_of("<f8", (900_000, 70), size=0)
    path = packed(tmp_path / "a.npz", {"q": one, "qd": one})
    with pytest.raises(TrajectoryError, match=r"a\.npz: the arrays are too large; allowed: at most 500 MB together"):
        read_trajectory(path, ARM)


@pytest.mark.slow
def test_members_are_counted_before_the_archive_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = {f"x{i}": b"" for i in range(MOST_MEMBERS - 1)}
    fine = packed(tmp_path / "a.npz", {"q": whole(Q), **few}, ZIP_STORED)
    np.testing.assert_array_equal(read_trajectory(fine, ARM).q, Q)
    more = packed(tmp_path / "b.npz", {"q": whole(Q), **few, "more": b""}, ZIP_STORED)
    with pytest.raises(TrajectoryError, match=r"b\.npz: the archive has too many arrays; got 1001; allowed: at most"):
        read_trajectory(more, ARM)
    many = packed(tmp_path / "c.npz", {f"{i:0>100}": b"" for i in range(10_000)}, ZIP_STORED)
    monkeypatch.setattr("rankdrop.path.read.arrays.ZipFile", lambda *_: pytest.fail("the list of members was read"))
    with pytest.raises(TrajectoryError, match=r"c\.npz: the archive has too many arrays; allowed: at most 1,000"):
        read_trajectory(many, ARM)


@pytest.mark.parametrize("how", [ZIP_BZIP2, ZIP_LZMA])
def test_only_what_numpy_packs_is_unpacked(how: int, tmp_path: Path) -> None:
    """The head of an LZMA stream asks for up to 4 GB."""
    path = packed(tmp_path / "a.npz", {"q": whole(Q)}, how)
    with pytest.raises(TrajectoryError, match="q: the array is packed in another way than NumPy packs"):
        read_trajectory(path, ARM)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no devices here")
@pytest.mark.parametrize("ending", ["npy", "npz"])
def test_a_link_to_a_device_is_not_read(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{ending}"
    os.symlink("/dev/zero", path)
    for read in (read_trajectory, read_arrays):
        with pytest.raises(TrajectoryError, match="this is not a file"):
            read(path, ARM)


@pytest.mark.parametrize("kind", ["<f4", ">f8", "<f2", "|i1", "<i8", "<u4"])
def test_every_type_of_numbers_is_read(kind: str, tmp_path: Path) -> None:
    q = np.array([[0, 1, 0, 1], [1, 0, 0, 2]], dtype=kind)
    np.save(tmp_path / "a.npy", q)
    np.savez_compressed(tmp_path / "a.npz", positions=q, times=np.array([0, 1]), names=np.array(NAMES, dtype="S"))
    for file in ("a.npy", "a.npz"):
        np.testing.assert_array_equal(read_trajectory(tmp_path / file, ARM).q, q.astype(float))


def test_a_float_beyond_the_doubles_is_refused_with_its_row(tmp_path: Path) -> None:
    if np.finfo(np.longdouble).max == np.finfo(np.float64).max:
        pytest.skip("the longest float is a double here")
    np.save(tmp_path / "a.npy", np.full((2, 4), np.finfo(np.longdouble).max))
    with pytest.raises(TrajectoryError, match=r"a\.npy, row 1, joint .* is not finite"):
        read_trajectory(tmp_path / "a.npy", ARM)
