"""A long job, and its folder: what was asked for, its finished chunks, and the journal that lists them.

    job.json            kind, plan, number of chunks, version: what the folder is for
    parts/00012.json    bytes of a finished chunk, written whole (`rankdrop.disk`)
    journal             a line for each finished chunk: its number and the SHA-256 of its bytes

A chunk counts as finished when its line is in the journal and its bytes have that SHA-256. The bytes reach the disk
before the line does, so that a loss of power, a kill or a full disk costs the chunks that were being made, no more.

A job is a plan in plain data, so many chunks, and a function that makes one of them. The bytes of a chunk follow from
the plan and its number alone: not from the worker, the machine's load, nor from what other chunks were made before it.
Then one process, many, a cluster and a run that was killed and resumed end with the same bytes.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

import msgspec

from rankdrop.codec import Count, decode, mapping, table, text, whole
from rankdrop.disk import append_line, locked, replace_file
from rankdrop.errors import RankdropError, ResultFileError
from rankdrop.version import VERSION

Plan = dict[str, Any]
Work = Callable[[Plan, int], bytes]


@dataclass(frozen=True)
class Job:
    """A job to do.

    Attributes:
        kind: in a word: "sweep".
        work: "module:function"; the function takes (plan, number of the chunk) and returns the chunk's bytes. It is
            named, not handed over, so that any worker of any machine can find it.
        plan: all that decides the result, as plain data of JSON.
        chunks: how many there are.
        items: how many things (variants, starts, paths) there are in all chunks; for progress.
        ending: of the files in which chunks are kept.
    """

    kind: str
    work: str
    plan: Plan
    chunks: int
    items: int
    ending: str = ".json"

    @property
    def line(self) -> str:
        """What tells the job from another one: its kind, plan and chunks, and the version of rankdrop."""
        told = {"kind": self.kind, "work": self.work, "plan": self.plan, "chunks": self.chunks, "version": VERSION}
        return json.dumps(told, sort_keys=True, ensure_ascii=False, allow_nan=False)

    @property
    def sha256(self) -> str:
        """Of its line."""
        return sha256(self.line.encode()).hexdigest()


def perform(work: str, plan: Plan, chunk: int) -> bytes:
    """One chunk, made here and now: what every worker runs.

    Raises:
        RankdropError: as the function of the job raises it.
    """
    module, _, name = work.partition(":")
    made: bytes = getattr(import_module(module), name)(plan, chunk)
    return made


def error_to_dict(error: RankdropError) -> dict[str, Any]:
    """An error as plain data, for the way from a worker."""
    return {name: None if value is None else str(value) for name, value in error.parts.items()}


def error_from_dict(record: dict[str, Any]) -> RankdropError:
    """The error of a record made by `error_to_dict`."""
    return RankdropError(**record)


@contextmanager
def alone(path: str | Path) -> Iterator[None]:
    """Work on a file or a folder as the only process.

    Raises:
        ResultFileError: another process works on it, or no lock can be made there.
    """
    with ExitStack() as held:
        try:
            held.enter_context(locked(path))
        except BlockingIOError as error:
            raise ResultFileError("another process is working on this", where=str(path),
                                  mend="wait until it has ended, or name another file") from error  # fmt: skip
        except OSError as error:
            raise ResultFileError(f"cannot write: {error.strerror}", where=str(path)) from error
        yield


JOB, PARTS, JOURNAL = "job.json", "parts", "journal"


@dataclass(frozen=True)
class Folder:
    """A folder that holds a job.

    Attributes:
        path: of the folder.
        job: what it is for.
    """

    path: Path
    job: Job

    @classmethod
    def open(cls, path: str | Path, job: Job) -> Folder:
        """Begin the job in a folder, or go on where it was.

        Raises:
            ResultFileError: the folder cannot be made or written, or holds another job, or something else.
        """
        found = cls(Path(path), job)
        note = found.path / JOB
        try:
            found.path.joinpath(PARTS).mkdir(parents=True, exist_ok=True)
            if note.exists():
                if note.read_bytes() != found._note():
                    raise ResultFileError(
                        "the folder holds another job", where=str(path), got=_describe_note(note),
                        allowed=f"{job.kind} {job.sha256[:12]}", mend="name another folder, or remove this one",
                    )  # fmt: skip
            else:
                replace_file(note, found._note())
        except OSError as error:
            raise ResultFileError(f"cannot use the folder: {error.strerror or error}", where=str(path)) from error
        return found

    def _note(self) -> bytes:
        record = {"schema": "rankdrop/job/1", "items": self.job.items, "sha256": self.job.sha256,
                  "job": json.loads(self.job.line)}  # fmt: skip
        return (json.dumps(record, indent=1, ensure_ascii=False, sort_keys=True) + "\n").encode()

    def part(self, chunk: int) -> Path:
        """Where the bytes of a chunk are."""
        return self.path / PARTS / f"{chunk:05}{self.job.ending}"

    def finished(self) -> set[int]:
        """The chunks that need not be made again: of those in the journal the ones whose bytes are as they were."""
        return {chunk for chunk, digest in journal_of(self.path) if self._is(chunk, digest)}

    def _is(self, chunk: int, digest: str) -> bool:
        try:
            return sha256(self.part(chunk).read_bytes()).hexdigest() == digest
        except OSError:
            return False

    def keep(self, chunk: int, content: bytes) -> None:
        """Write a finished chunk, then its line.

        Raises:
            ResultFileError: disk full, or no permission; what was finished before is as it was.
        """
        try:
            replace_file(self.part(chunk), content)
            append_line(self.path / JOURNAL, f"{chunk} {sha256(content).hexdigest()}")
        except OSError as error:
            raise ResultFileError(
                f"cannot write: {error.strerror or error}", where=str(self.part(chunk)),
                mend="what is finished is kept: the same command goes on there",
            ) from error  # fmt: skip

    def read(self, chunk: int) -> bytes:
        """The bytes of a finished chunk."""
        return self.part(chunk).read_bytes()


_DIGITS = 9  # of the number of a chunk
_LARGEST = 1 << 30  # bytes of job.json: a plan holds the poses of its paths


@cache
def _note_table() -> Any:
    job = table("job", kind=text(pattern="^[a-z ]{1,40}$"), work=str, plan=mapping(Any), chunks=whole(1, 10**_DIGITS),
                version=str)  # fmt: skip
    return table("note", schema=Literal["rankdrop/job/1"], items=Count, sha256=str, job=job)


def journal_of(path: Path) -> Iterator[tuple[int, str]]:
    """(chunk, SHA-256) of every whole line of a journal; the last one may be torn."""
    try:
        lines = (path / JOURNAL).read_bytes().decode("ascii", "replace").split("\n")
    except OSError:
        return
    for line in lines:
        words = line.split(" ")
        if len(words) == 2 and words[0].isdecimal() and len(words[0]) <= _DIGITS and len(words[1]) == 64:
            yield int(words[0]), words[1]


@dataclass(frozen=True, slots=True)
class Progress:
    """How far the job of a folder is.

    Attributes:
        kind: of the job.
        done, chunks: finished chunks, and all of them.
        items: things in all chunks.
        seconds: from the beginning to the last finished chunk.
        quiet: seconds since then.
        left: seconds to the end at the pace so far; None where nothing tells it.
    """

    kind: str
    done: int
    chunks: int
    items: int
    seconds: float
    quiet: float
    left: float | None

    @property
    def sentence(self) -> str:
        """For people."""
        share = f"{self.done} of {self.chunks} chunks of the {self.kind} ({self.items} items in all)"
        if self.done == self.chunks:
            return f"finished: {share}"
        left = "" if self.left is None else f"; about {self.left:.0f} s left at the pace so far"
        return f"{share}; last one {self.quiet:.0f} s ago{left}"


def progress_of(path: str | Path) -> Progress:
    """How far a job is, read from its folder alone: while it runs, after a kill, from another machine.

    Raises:
        ResultFileError: no job is in the folder.
    """
    folder = Path(path)
    note = folder / JOB
    try:
        record, begun = _read_note(note), note.stat().st_mtime
    except OSError as error:
        raise ResultFileError("there is no job in the folder", where=str(path), allowed=f"a folder with {JOB}",
                              mend="name the folder given to --out") from error  # fmt: skip
    except ResultFileError as error:
        raise ResultFileError(f"{JOB} is damaged: {error.what}", where=f"{path}, {error.where}", got=error.got,
                              mend="name another folder, or remove this one") from error  # fmt: skip
    kind, chunks, items = record.job.kind, record.job.chunks, record.items
    done = len({chunk for chunk, _ in journal_of(folder) if chunk < chunks})
    last = (folder / JOURNAL).stat().st_mtime if done else begun
    seconds = max(0.0, last - begun)
    left = seconds / done * (chunks - done) if done else None
    return Progress(kind, done, chunks, items, seconds, max(0.0, time.time() - last), left)


def _describe_note(note: Path) -> str:
    try:
        found = _read_note(note)
    except (ResultFileError, OSError):
        return f"a {JOB} that is not of a job"
    return f"{found.job.kind} {found.sha256[:12]} of version {found.job.version[:40]}"


def _read_note(note: Path) -> Any:
    """The entries of a job.json, strictly.

    Raises:
        OSError: the file cannot be read.
        ResultFileError: it is not JSON, or not of a job; names the element.
    """
    if note.stat().st_size > _LARGEST:
        raise ResultFileError("the file is too large", where="$", allowed=f"up to {_LARGEST:,} bytes")
    try:
        return decode(_note_table(), msgspec.json.decode(note.read_bytes()))
    except (ValueError, RecursionError, msgspec.MsgspecError) as error:
        raise ResultFileError("this is not JSON that can be read", where="$", got=str(error)[:80]) from error
