"""A robot program from a file, its language by the ending of its name."""

from __future__ import annotations

from pathlib import Path

from rankdrop.disk import is_endless
from rankdrop.path.read import fanuc_tp, inform, krl, rapid, urscript
from rankdrop.path.read.program_record import Program, Reader
from rankdrop.path.read.program_scan import LARGEST_PROGRAM
from rankdrop.path.read.trajectory import TrajectoryError

_KRL = (".src", ".sub")
_READERS: dict[str, Reader] = {
    **dict.fromkeys(_KRL, krl.read), **dict.fromkeys((".mod", ".modx", ".prg", ".sys", ".sysx"), rapid.read),
    **dict.fromkeys((".script", ".urscript"), urscript.read), ".ls": fanuc_tp.read, ".jbi": inform.read,
}  # fmt: skip


def read_program(path: str | Path) -> Program:
    """A robot program: the moves with literal targets, and the lines that were not read.

    Args:
        path: .src or .sub (KRL; positions also from the .dat file next to it), .mod, .modx, .sys, .sysx or .prg
            (RAPID), .script or .urscript (URScript), .ls (FANUC TP listing), .jbi (Yaskawa INFORM).

    Raises:
        TrajectoryError: it cannot be read, with file and line, or no move in it has a literal target.
    """
    file, name = Path(path), str(path)
    text, ending = _text(file), file.suffix.lower()
    if ending in _KRL:
        data = (file.with_suffix(".dat"), file.with_suffix(".DAT"))
        beside = next((path for path in data if path.is_file()), None)
        program = krl.read(text, name, "" if beside is None else _text(beside))
    else:
        program = _READERS[ending](text, name)
    if not program.moves:
        first = next(iter(program.skipped), None)
        raise TrajectoryError(
            f"no move of this {program.language} program has a literal target", where=name,
            got=None if first is None else f"line {first.line}: {first.text}",
            allowed="joint values or poses as numbers, in the moves or in declarations of the same file",
        )  # fmt: skip
    return program


def _text(file: Path) -> str:
    """The text of a program: UTF-8, or, as older controllers write, Latin-1.

    Raises:
        TrajectoryError: it cannot be read, is too large, or is no text.
    """
    where = str(file)
    if is_endless(file) or not file.is_file():
        raise TrajectoryError("this is not a file", where=where)
    try:
        with file.open("rb") as stream:
            data = stream.read(LARGEST_PROGRAM + 1)
    except OSError as error:
        raise TrajectoryError(f"the file cannot be read: {error.strerror or error}", where=where) from None
    if len(data) > LARGEST_PROGRAM:
        raise TrajectoryError("the program is too large", where=where, allowed=f"at most {LARGEST_PROGRAM // 2**20} MB")
    if b"\0" in data:
        raise TrajectoryError("this is not a text file", where=where, allowed="a program as text")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")
