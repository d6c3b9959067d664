"""Files are written here and nowhere else: whole or not at all, and on the disk when the call returns.

What is read as a whole is a file: a pipe or a device may have no end.
"""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def is_endless(path: Path) -> bool:
    """Whether it is there and neither a file nor a folder: a pipe, a socket or a device."""
    return path.exists() and not path.is_file() and not path.is_dir()


def read_file(path: Path, largest: int) -> bytes:
    """The bytes of a file.

    Args:
        path: of the file.
        largest: bytes that it may have.

    Raises:
        OSError: it cannot be read, is no file, or is too large.
    """
    if is_endless(path):
        raise OSError(errno.EINVAL, "this is not a file", str(path))
    with path.open("rb") as stream:
        content = stream.read(largest + 1)
    if len(content) > largest:
        raise OSError(errno.EFBIG, f"the file is too large; allowed: at most {largest / 2**20:g} MB", str(path))
    return content


def replace_file(path: str | Path, content: bytes) -> None:
    """Write a file so that its reader sees the old content or all of the new one, after a loss of power too.

    The bytes go to a file beside it, to the disk (fsync), and take its name in one step; a symbolic link is followed,
    permissions are kept. What is no file (/dev/null, a pipe) is written to as it stands.

    Args:
        path: of the file; its folder is there.
        content: all of it.

    Raises:
        OSError: disk full, no permission, no such folder; the old file is as it was, and nothing is left beside it.
        ValueError: a path that no file system takes (a zero byte).
    """
    target = Path(path)
    if target.exists() and not target.is_file():
        target.write_bytes(content)
        return
    target = target.resolve()
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name[:100]}.")  # a name has at most 255 bytes
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask())
        os.replace(name, target)
    except BaseException:  # Ctrl-C too: no half-written file stays behind; raised again
        os.unlink(name)
        raise
    _settle(target.parent)


def _settle(folder: Path) -> None:
    """Bring the new name to the disk, where folders can be synced; elsewhere the file has its old name or its new."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:  # Windows opens no folder
        return
    try:
        os.fsync(handle)
    except OSError:  # some network file systems
        return
    finally:
        os.close(handle)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


@contextmanager
def lock_name(path: str | Path) -> Iterator[None]:
    """Hold a lock on a name, for this process alone; it ends with the process, however that ends.

    The lock is that of the system on the file `path`.lock, which is removed afterwards. Where the system has no such
    locks (Windows), nothing is held.

    Args:
        path: of the file or folder that one process at a time may work on.

    Raises:
        BlockingIOError: another process holds it.
        OSError: no permission, no such folder.
    """
    try:
        import fcntl
    except ImportError:
        yield
        return
    name = f"{path}.lock"
    with open(name, "ab") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not os.path.exists(name) or os.stat(name).st_ino != os.fstat(file.fileno()).st_ino:
            raise BlockingIOError(name)  # its last holder removed it a moment ago
        try:
            yield
        finally:
            os.unlink(name)


def append_line(path: str | Path, line: str) -> None:
    """Add a line to a journal, and bring it to the disk. A torn line before it, of a writer that died, is ended first.

    Args:
        path: of the journal; made where it is not there.
        line: ASCII, without its end.

    Raises:
        OSError: disk full, no permission, no such folder.
    """
    with open(path, "ab+") as file:
        if file.tell():
            file.seek(-1, os.SEEK_END)
            torn = file.read(1) != b"\n"
        else:
            torn = False
        file.write(b"\n" * torn + line.encode("ascii") + b"\n")
        file.flush()
        os.fsync(file.fileno())
