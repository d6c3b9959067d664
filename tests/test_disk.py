"""Files are written whole or not at all: an old one survives a full disk, whoever writes."""

from __future__ import annotations

import ast
import errno
import os
import resource
import signal
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
import pytest
from sources import ROOT, nodes

from papers.figures import save_figures
from rankdrop import explain, open_robot
from rankdrop.cli.targets import write_json, write_text
from rankdrop.codec import save_record
from rankdrop.disk import replace_file
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.results.known import shipped

OLD = b"the good old file\n"
SCARA = open_robot("scara")
WRITERS = {"write_text", "write_bytes", "save", "savez", "savez_compressed", "savetxt", "savefig"}
"""Methods that write a file where their first argument is a path."""
INTO_MEMORY = {"buffer", "svg", "png"}
"""Names of the BytesIO objects that `savefig` and `savez` are given; all of them go to `replace_file` in the end."""


SCRATCH = {"fuzz_readers.py", "mutate.py"}
"""Tools whose files are thrown away: hundreds of thousands of cases, each waiting for the disk, would never end."""


def writing(path: Path) -> Iterator[str]:
    """Lines of a module that write to a file by themselves."""
    for node in nodes(path):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        first = ast.unparse(node.args[0]) if node.args else ""
        modes = [one.value for one in [*node.args, *(word.value for word in node.keywords if word.arg == "mode")]
                 if isinstance(one, ast.Constant) and isinstance(one.value, str)]  # fmt: skip
        opens = name in {"open", "fdopen"} and any(set(mode) & set("wax+") and len(mode) <= 3 for mode in modes)
        own = name == "save" and ast.unparse(node.func).startswith("self.")
        known = name in {"write_text", "write_bytes"} and isinstance(node.func, ast.Name)  # of rankdrop.cli.terminal
        opens &= first != "os.devnull" and not first.startswith("os.dup(")  # of a worker: its answers, down a pipe
        if opens or (name in WRITERS and first not in INTO_MEMORY and not own and not known):
            yield f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)[:80]}"


@pytest.mark.slow
def test_files_are_written_in_one_place() -> None:
    home = ROOT / "src" / "rankdrop" / "disk.py"
    assert list(writing(home)), "the look-out is blind"
    files = [path for folder in ("src/rankdrop", "tools") for path in sorted((ROOT / folder).rglob("*.py"))]
    found = [line for path in files if path != home and path.name not in SCRATCH for line in writing(path)]
    assert not found, "\n".join(found)


def save_analysis(path: Path) -> None:
    found = shipped("scara")
    assert found is not None
    found.save(path)


SAVERS: dict[str, tuple[Callable[[Path], None], type[Exception]]] = {
    "Analysis.save": (save_analysis, ResultFileError),
    "save_record": (lambda path: save_record({"numbers": list(range(9000))}, path), ResultFileError),
    "Explanation.save": (lambda path: explain(SCARA, [0.0] * 4, evaluations=0).save(path), ResultFileError),
    "write_json": (lambda path: write_json({"numbers": list(range(9000))}, str(path)), OptionError),
    "write_text": (lambda path: write_text("x" * 9000, str(path)), OptionError),
}


class FullDisk:
    """A file that takes some bytes, then none."""

    def __init__(self, file: IO[bytes], at: str) -> None:
        self.file, self.at = file, at

    def write(self, content: bytes) -> int:
        if self.at == "write":
            self.file.write(content[:100])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self.file.write(content)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.file, name)

    def __enter__(self) -> FullDisk:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()


@pytest.mark.parametrize("at", ["write", "fsync"])
@pytest.mark.parametrize("saver", SAVERS)
def test_the_old_file_survives_a_full_disk(
    saver: str, at: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save, kind = SAVERS[saver]
    path = tmp_path / "kept.json"
    path.write_bytes(OLD)
    opened = os.fdopen
    monkeypatch.setattr("rankdrop.disk.os.fdopen", lambda handle, mode: FullDisk(opened(handle, mode), at))
    if at == "fsync":  # delayed allocation: only then the disk says that it is full

        def full(_: int) -> None:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        monkeypatch.setattr("rankdrop.disk.os.fsync", full)
    with pytest.raises(kind, match=os.strerror(errno.ENOSPC)):
        save(path)
    assert path.read_bytes() == OLD
    assert [one.name for one in tmp_path.iterdir()] == ["kept.json"]
    monkeypatch.undo()
    save(path)
    assert len(path.read_bytes()) > 2000


@pytest.mark.slow
def test_figures_survive_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    [*written] = save_figures(("GR",), str(tmp_path))
    before = {path.name: path.read_bytes() for path in written}
    assert {path.suffix for path in written} == {".svg", ".png", ".json"}
    opened = os.fdopen
    monkeypatch.setattr("rankdrop.disk.os.fdopen", lambda handle, mode: FullDisk(opened(handle, mode), "write"))
    with pytest.raises(OptionError, match=os.strerror(errno.ENOSPC)):
        save_figures(("GR",), str(tmp_path))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_the_old_file_survives_the_limit_of_the_system(tmp_path: Path) -> None:
    """RLIMIT_FSIZE: the kernel itself refuses the bytes after 8,000, in a process of its own."""
    path = tmp_path / "kept.json"
    path.write_bytes(OLD)
    program = (
        "import sys\nfrom rankdrop.codec import save_record\n"
        "try:\n    save_record({'numbers': list(range(9000))}, sys.argv[1])\n"
        "except Exception as error:\n    print(type(error).__name__, error)\n"
    )

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (8000, 8000))

    done = subprocess.run(
        [sys.executable, "-c", program, str(path)], capture_output=True, text=True, preexec_fn=limit, timeout=600
    )
    assert done.stdout.startswith("ResultFileError"), done.stdout + done.stderr
    assert "File too large" in done.stdout
    assert path.read_bytes() == OLD
    assert [one.name for one in tmp_path.iterdir()] == ["kept.json"]


def test_bytes_are_on_the_disk_before_the_name_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    order = []
    sync, swap = os.fsync, os.replace

    def synced(handle: int) -> None:
        order.append("folder" if stat.S_ISDIR(os.fstat(handle).st_mode) else f"{os.fstat(handle).st_size} bytes")
        sync(handle)

    def swapped(old: str, new: Path) -> None:
        order.append("name")
        swap(old, new)

    monkeypatch.setattr("rankdrop.disk.os.fsync", synced)
    monkeypatch.setattr("rankdrop.disk.os.replace", swapped)
    replace_file(tmp_path / "one", b"12345")
    assert order == ["5 bytes", "name", "folder"]


def test_an_interrupt_leaves_the_old_file_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "kept"
    path.write_bytes(OLD)

    def stopped(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("rankdrop.disk.os.fsync", stopped)
    with pytest.raises(KeyboardInterrupt):
        replace_file(path, b"new")
    assert path.read_bytes() == OLD
    assert [one.name for one in tmp_path.iterdir()] == ["kept"]


def test_links_are_followed_and_permissions_kept(tmp_path: Path) -> None:
    (tmp_path / "real").write_bytes(OLD)
    (tmp_path / "real").chmod(0o640)
    (tmp_path / "link").symlink_to("real")
    replace_file(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"
    assert (tmp_path / "real").stat().st_mode & 0o777 == 0o640
    replace_file("/dev/null", np.zeros(10).tobytes())
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    replace_file(tmp_path / ("n" * 250), b"a long name")
