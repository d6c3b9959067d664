"""Trajectories in NumPy's files: one array of samples, or an archive with times, velocities and names; and poses.

Headers are judged before any array is unpacked.
"""

from __future__ import annotations

import io
import warnings
import zlib
from collections import Counter
from collections.abc import Callable, Container
from dataclasses import replace
from math import prod
from pathlib import Path
from tokenize import TokenError
from typing import Any, BinaryIO, TypeVar
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo, is_zipfile

import numpy as np
from numpy.lib.format import MAGIC_PREFIX, read_array, read_array_header_1_0, read_array_header_2_0, read_magic
from numpy.typing import NDArray

from rankdrop.disk import is_endless
from rankdrop.path.read.joint_columns import names_of_arm
from rankdrop.path.read.trajectory import Trajectory, TrajectoryError, increasing, trajectory_from_arrays
from rankdrop.robot.files import LARGEST_ARRAY, LONGEST_HEAD, MOST_MEMBERS, MOST_ROWS, MOST_STEPS
from rankdrop.robot.model import Array, Robot

ARRAY_ENDINGS = (".npy", ".npz")
ARRAYS = (
    ("q", "positions", "position"), ("t", "time", "times"), ("qd", "velocities", "velocity"),
    ("qdd", "accelerations", "acceleration"), ("joint_names", "names", "joints"),
)  # fmt: skip
"""Names that each array may have in an archive."""
POSES = ("poses", "pose", "matrices", "transforms", "T")
"""Names that an array of poses may have in an archive without joint values; another one is read where it is the only
array of three dimensions.
"""
_DAMAGED = (ValueError, TypeError, EOFError, BadZipFile, NotImplementedError, MemoryError, OverflowError, SyntaxError,
            RecursionError, RuntimeError, TokenError, zlib.error)  # fmt: skip
"""What NumPy raises over a file that is none: its headers are parsed as Python's literals."""
_MOST = f"at most {LARGEST_ARRAY // 2**20} MB"
_HEADER = 10_240  # bytes: NumPy itself accepts headers of 10,000
_ZIP_END = 22  # bytes of the record at the end of an archive
_ENTRY = 1024  # bytes of a member in the list of an archive

Found = TypeVar("Found")


def read_arrays(path: Path, robot: Robot, *, deg: bool = False) -> Trajectory:
    """A trajectory from a .npy file (T, n), or (T, n + 1) with a rising time in front; or from an .npz archive.

    Args:
        path: the file.
        robot: whose joints they are; in the order of the arm unless the archive has `joint_names`.
        deg: angles are in degrees.

    Raises:
        TrajectoryError: with file and row.
    """
    where = str(path)
    loaded = _load(path)
    if isinstance(loaded, np.ndarray):
        q = _doubles(loaded)
        timed = q.ndim == 2 and q.shape[1] == robot.n + 1 and len(q) > 1 and increasing(q[:, 0])
        return trajectory_from_arrays(where, robot, {"q": q[:, 1:], "t": q[:, 0]} if timed else {"q": q}, deg=deg)
    names = loaded.pop("joint_names", None)
    parts = {key: _doubles(part) for key, part in loaded.items()}
    if names is None:
        return trajectory_from_arrays(where, robot, parts, deg=deg)
    listed, notes = names_of_arm(_texts(names), [joint.name for joint in robot.variables], where)
    found = trajectory_from_arrays(where, robot, parts, listed, deg=deg)
    return replace(found, notes=(*found.notes, *notes))


def _doubles(numbers: NDArray[Any]) -> Array:
    with np.errstate(over="ignore"):  # longer floats beyond the doubles become infinite, which is refused with its row
        return numbers.astype(np.float64)


def _texts(names: NDArray[Any]) -> list[str]:
    """Names as Python's texts; an array of bytes is UTF-8."""
    listed = names.reshape(-1).tolist()
    return [name.decode("utf-8", "replace") if isinstance(name, bytes) else name for name in listed]


def pose_shape(path: Path) -> tuple[int, ...] | None:
    """The shape of the array of poses in a file, by its header alone; None where there is none.

    Raises:
        TrajectoryError: the file cannot be read.
    """

    def of_array(_: BinaryIO, begin: bytes) -> tuple[int, ...] | None:
        return _header(begin)[0]

    def of_archive(archive: ZipFile) -> tuple[int, ...] | None:
        name = _pose_name(archive, str(path))
        if name is None:
            return None
        return _shape_in(archive, name)

    return _opened(path, of_array, of_archive)


def read_pose_array(path: Path) -> tuple[Array, Array | None, str]:
    """The array of poses in a file, the times of an archive that has them, and where the poses are, for errors.

    Raises:
        TrajectoryError: the file cannot be read, or holds no poses.
    """
    where = str(path)

    def of_array(file: BinaryIO, begin: bytes) -> tuple[Array, Array | None, str]:
        return _doubles(_whole_array(file, begin, where)), None, where

    def of_archive(archive: ZipFile) -> tuple[Array, Array | None, str]:
        name = _pose_name(archive, where)
        infos = _infos(archive, where)
        if name is None:
            raise TrajectoryError("the archive has no poses", where=where, got=", ".join(infos) or "nothing",
                                  allowed=" or ".join(POSES))  # fmt: skip
        wanted = {"poses": name}
        times = _arrays_wanted(infos).get("t")
        if times is not None:
            wanted["t"] = times
        found = {key: _doubles(part) for key, part in _unpacked(archive, infos, wanted, where).items()}
        return found["poses"], found.get("t"), f"{where}, {name}"

    return _opened(path, of_array, of_archive)


def _pose_name(archive: ZipFile, where: str) -> str | None:
    """The name of the array of poses in an archive without joint values; None where there is none."""
    infos = _infos(archive, where)
    if "q" in _arrays_wanted(infos):
        return None
    named = [name for name in POSES if name in infos]
    if named:
        return named[0]
    stacks = [name for name in infos if len(_shape_in(archive, name) or ()) == 3]
    if len(stacks) == 1:
        return stacks[0]
    return None


def _shape_in(archive: ZipFile, name: str) -> tuple[int, ...] | None:
    """The shape of a member of an archive, by its header; None where it is none of NumPy's."""
    info = _infos(archive, name)[name]
    if info.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
        return None
    try:
        with archive.open(info) as stream:
            return _header(stream.read(_HEADER))[0]
    except _DAMAGED:
        return None


def _opened(
    path: Path, of_array: Callable[[BinaryIO, bytes], Found], of_archive: Callable[[ZipFile], Found]
) -> Found:
    """The result of a reader of one array, or of a reader of an archive, for a file.

    Args:
        path: the file.
        of_array: called with the file and its first bytes.
        of_archive: called with the archive; its list of members is short.

    Raises:
        TrajectoryError: the file cannot be read, is too large, or is none of NumPy's.
    """
    try:
        if is_endless(path):
            raise TrajectoryError("this is not a file", where=str(path), got="a pipe or a device")
        if path.stat().st_size > LARGEST_ARRAY:
            raise TrajectoryError("the file is too large", where=str(path), allowed=_MOST)
        with path.open("rb") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # a header of Python 2 is read as any other
            begin = file.read(_HEADER)
            if begin.startswith(MAGIC_PREFIX):  # an array may hold the bytes of an archive, too
                return of_array(file, begin)
            if not is_zipfile(file):
                raise TrajectoryError("this is not a file of NumPy's", where=str(path),
                                      got=repr(begin[: len(MAGIC_PREFIX)]))  # fmt: skip
            _check_directory(file, str(path))
            with ZipFile(file) as archive:
                return of_archive(archive)
    except OSError as error:
        raise TrajectoryError(f"the file cannot be read: {error.strerror or error}", where=str(path)) from None
    except _DAMAGED as error:
        raise TrajectoryError("this is not a file of NumPy's", where=str(path), got=str(error)[:80]) from None


def _whole_array(file: BinaryIO, begin: bytes, where: str) -> NDArray[Any]:
    """The array of a file. Its header is judged first."""
    _judge(begin, "q", where)
    file.seek(0)
    return np.asarray(read_array(file, allow_pickle=False))


def _load(path: Path) -> Array | dict[str, Array]:
    """The array, or those of the archive that are read. Headers are judged before any array is unpacked."""

    def of_array(file: BinaryIO, begin: bytes) -> Array | dict[str, Array]:
        return _whole_array(file, begin, str(path))

    def of_archive(archive: ZipFile) -> Array | dict[str, Array]:
        return _members(archive, str(path))

    return _opened(path, of_array, of_archive)


def _check_directory(file: BinaryIO, where: str) -> None:
    """Refuse an archive whose list of members is long, before `ZipFile` reads that list.

    The list's size is in the record at the end of the archive (APPNOTE 4.3.16), which is found as `zipfile` finds it.
    An archive within the limits of size needs no record of 64 bits (4.3.15), so that such an archive is refused.

    Raises:
        TrajectoryError: the list is longer than `MOST_MEMBERS` allow.
    """
    file.seek(0, io.SEEK_END)
    file.seek(max(0, file.tell() - _ZIP_END - 2**16))
    tail = file.read()
    last = len(tail) - _ZIP_END
    bare = tail.startswith(b"PK\5\6", last) and tail.endswith(b"\0\0")
    end = last if bare else tail.rfind(b"PK\5\6")
    size = int.from_bytes(tail[end + 12 : end + 16], "little")
    wide = tail[max(0, end - 20) : end].startswith(b"PK\6\7")
    if wide or size > MOST_MEMBERS * _ENTRY:
        raise TrajectoryError("the archive has too many arrays", where=where, allowed=f"at most {MOST_MEMBERS:,}")


def _members(archive: ZipFile, where: str) -> dict[str, Array]:
    """The arrays of an archive by the first name of their kind; all other members are None.

    Raises:
        TrajectoryError: too many members, two of a name, a header that is refused, or too many numbers.
    """
    infos = _infos(archive, where)
    wanted = _arrays_wanted(infos)
    if "q" not in wanted:
        raise TrajectoryError("the archive has no positions", where=where, got=", ".join(infos) or "nothing",
                              allowed=f"{' or '.join(ARRAYS[0])}; or {POSES[0]} for matrices of the tip")  # fmt: skip
    return _unpacked(archive, infos, wanted, where)


def _unpacked(archive: ZipFile, infos: dict[str, ZipInfo], wanted: dict[str, str], where: str) -> dict[str, Array]:
    """The arrays of an archive by their kinds, as `wanted` names them; all headers are judged first.

    Raises:
        TrajectoryError: a header that is refused, or too many numbers.
    """
    total = 0
    for key, name in wanted.items():
        place = f"{where}, {name}"
        if infos[name].compress_type not in (ZIP_STORED, ZIP_DEFLATED):  # others may ask for gigabytes to start
            raise TrajectoryError("the array is packed in another way than NumPy packs", where=place,
                                  mend="write it by numpy.savez or numpy.savez_compressed")  # fmt: skip
        with archive.open(infos[name]) as stream:
            total += _judge(stream.read(_HEADER), key, place)
        if total > LARGEST_ARRAY:
            raise TrajectoryError("the arrays are too large", where=where, allowed=f"{_MOST} together")
    found: dict[str, Array] = {}
    for key, name in wanted.items():
        with archive.open(infos[name]) as stream:
            found[key] = np.asarray(read_array(stream, allow_pickle=False))
    return found


def _infos(archive: ZipFile, where: str) -> dict[str, ZipInfo]:
    """The members of an archive by the names of their arrays.

    Raises:
        TrajectoryError: too many members, or two of a name.
    """
    listed = archive.infolist()
    if len(listed) > MOST_MEMBERS:
        raise TrajectoryError("the archive has too many arrays", where=where, got=len(listed),
                              allowed=f"at most {MOST_MEMBERS:,}")  # fmt: skip
    infos = {member.filename.removesuffix(".npy"): member for member in listed}
    if len(infos) < len(listed):
        counts = Counter(member.filename.removesuffix(".npy") for member in listed)
        raise TrajectoryError("two arrays of the archive have the same name",
                              where=f"{where}, {counts.most_common(1)[0][0]}", mend="name each array once")  # fmt: skip
    return infos


def _arrays_wanted(names: Container[str]) -> dict[str, str]:
    """Of each kind of array that is there the first of its names, by the kind."""
    wanted = {}
    for kind in ARRAYS:
        there = [name for name in kind if name in names]
        if there:
            wanted[kind[0]] = there[0]
    return wanted


def _judge(begin: bytes, key: str, where: str) -> int:
    """Bytes that the array takes as it is read and as doubles, by its header: shape and type.

    Args:
        begin: of the file or member; a longer header than `_HEADER` is damage.
        key: which array it is, of `ARRAYS`.
        where: for errors.

    Raises:
        TrajectoryError: the type is none of numbers (of texts, for names), or the array is too large.
        ValueError: it is no header.
    """
    shape, dtype = _header(begin)
    texts = key == "joint_names"
    if dtype.kind not in ("US" if texts else "fiu"):
        raise TrajectoryError("these are no names" if texts else "these are no numbers", where=where,
                              got=f"an array of {dtype}")  # fmt: skip
    if min(shape, default=1) < 0:
        raise TrajectoryError("the array has a negative size", where=where, got=f"shape {shape}")
    if texts and not _fits_names(shape, dtype):
        raise TrajectoryError("the names of the joints are too many or too long", where=where,
                              got=f"shape {shape} of {dtype}",
                              allowed=f"at most {MOST_STEPS:,} of {LONGEST_HEAD} characters")  # fmt: skip
    size = prod(shape) * max(8, dtype.itemsize)  # a byte of the file becomes eight
    if size > LARGEST_ARRAY:
        raise TrajectoryError("the array is too large", where=where, got=f"{prod(shape)} numbers", allowed=_MOST)
    if shape and shape[0] > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=where, got=shape[0], allowed=f"at most {MOST_ROWS}")
    return size


def _header(begin: bytes) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type of an array, by the first bytes of its file.

    Raises:
        ValueError: it is no header.
    """
    stream = io.BytesIO(begin)
    if read_magic(stream) == (1, 0):
        read_header = read_array_header_1_0
    else:
        read_header = read_array_header_2_0
    shape, _, dtype = read_header(stream)
    return shape, dtype


def _fits_names(shape: tuple[int, ...], dtype: np.dtype[Any]) -> bool:
    """Whether an array of this shape and type can hold the names of the joints: a list, not too many nor too long."""
    return len(shape) <= 1 and prod(shape) <= MOST_STEPS and 0 < dtype.itemsize <= 4 * LONGEST_HEAD
