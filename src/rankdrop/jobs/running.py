"""A long job, and its folder: what was asked for, its finished chunks, and the journal that lists them.

    job.json            kind, plan, number of chunks, version: what the folder is for
    parts/00012.json    bytes of a finished chunk, written whole (`rankdrop.disk`)
    journal             a line for each finished chunk: its number and the SHA-256 of its bytes

A chunk counts as finished when its line is in the journal and its bytes have that SHA-256. The bytes reach the disk
before the line does, so that a loss of power, a kill or a full disk costs the chunks that were being made, no more.

A job is a plan in plain data, so many chunks, and a function that makes one of them. The bytes of a chunk follow from
the plan and its number alone: not from the worker, the machine's load, nor from what other chunks were made before it.
Then one process, many, a cluster and a run that was killed and resumed end with the same bytes.

Local workers have one BLAS thread each, whose number decides the last bits of sums. A worker that dies is replaced and
its chunk made again; one that dies of the same chunk three times over is the chunk's fault, and told. Of a cluster
nothing is asked but that its workers can import rankdrop of the same version.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import IO, Any, Literal

import msgspec

from rankdrop.codec import Count, decode, mapping, table, text, whole
from rankdrop.disk import append_line, lock_name, read_file, replace_file
from rankdrop.errors import MissingExtraError, OptionError, RankdropError, ResultFileError
from rankdrop.sections import words_of
from rankdrop.version import VERSION

Plan = dict[str, Any]
Work = Callable[[Plan, int], bytes]

JOB, PARTS, JOURNAL = "job.json", "parts", "journal"

_DIGITS = 9  # of the number of a chunk
_LARGEST = 1 << 30  # bytes of job.json, a journal or a part: a plan holds the poses of its paths

MOST_WORKERS = 1024
ATTEMPTS = 3
"""Workers that may die of one chunk."""
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
Report = Callable[[int, int], None]
"""report(chunks done, chunks in all)"""
Made = tuple[int, bytes]


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
        identity = {"kind": self.kind, "work": self.work, "plan": self.plan, "chunks": self.chunks, "version": VERSION}
        return json.dumps(identity, sort_keys=True, ensure_ascii=False, allow_nan=False)

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
    result: bytes = getattr(import_module(module), name)(plan, chunk)
    return result


def error_to_dict(error: RankdropError) -> dict[str, Any]:
    """An error as plain data, for the way from a worker."""
    return {name: None if value is None else str(value) for name, value in error.parts.items()}


def error_from_dict(record: dict[str, Any]) -> RankdropError:
    """The error of a record made by `error_to_dict`."""
    return RankdropError(**record)


@contextmanager
def hold_lock(path: str | Path, inside: str = "") -> Iterator[None]:
    """Work on a file or a folder as the only process.

    Args:
        path: of the file or folder.
        inside: name in the folder next to which the lock is made; else it is made next to the path.

    Raises:
        ResultFileError: another process works on it, or no lock can be made there.
    """
    with ExitStack() as held:
        try:
            held.enter_context(lock_name(Path(path, inside)))
        except BlockingIOError as error:
            raise ResultFileError("another process is working on this", where=str(path),
                                  mend="wait until it has ended, or name another one") from error  # fmt: skip
        except OSError as error:
            raise ResultFileError(f"cannot write: {error.strerror}", where=str(path)) from error
        yield


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
        folder = cls(Path(path), job)
        note = folder.path / JOB
        try:
            folder.path.joinpath(PARTS).mkdir(parents=True, exist_ok=True)
            if note.exists():
                if read_file(note, _LARGEST) != folder._note():
                    raise ResultFileError(
                        "the folder holds another job", where=str(path), got=_describe_note(note),
                        allowed=f"{job.kind} {job.sha256[:12]}", mend="name another folder, or remove this one",
                    )  # fmt: skip
            else:
                replace_file(note, folder._note())
        except OSError as error:
            raise ResultFileError(f"cannot use the folder: {error.strerror or error}", where=str(path)) from error
        return folder

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
            return sha256(self.read(chunk)).hexdigest() == digest
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
                mend="finished work is kept: the same command continues it",
            ) from error  # fmt: skip

    def read(self, chunk: int) -> bytes:
        """The bytes of a finished chunk."""
        return read_file(self.part(chunk), _LARGEST)

    take = read
    """The bytes of a finished chunk, which the folder keeps."""


@dataclass(frozen=True)
class _ChunksInMemory:
    """Finished chunks without a folder, by their numbers."""

    chunks: dict[int, bytes]

    def finished(self) -> set[int]:
        """The chunks that need not be made again."""
        return set(self.chunks)

    def keep(self, chunk: int, content: bytes) -> None:
        """Keep a finished chunk."""
        self.chunks[chunk] = content

    def read(self, chunk: int) -> bytes:
        """The bytes of a finished chunk."""
        return self.chunks[chunk]

    def take(self, chunk: int) -> bytes:
        """The bytes of a finished chunk, which is forgotten."""
        return self.chunks.pop(chunk)


@cache
def _note_table() -> Any:
    job = table("job", kind=text(pattern="^[a-z ]{1,40}$"), work=str, plan=mapping(Any), chunks=whole(1, 10**_DIGITS),
                version=str)  # fmt: skip
    return table("note", schema=Literal["rankdrop/job/1"], items=Count, sha256=str, job=job)


def journal_of(path: Path) -> Iterator[tuple[int, str]]:
    """(chunk, SHA-256) of every whole line of a journal; the last one may be torn."""
    try:
        lines = read_file(path / JOURNAL, _LARGEST).decode("ascii", "replace").split("\n")
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
        """In words: "3 of 8 chunks of the sweep (40 items in all); last one 2 s ago"."""
        words: str = words_of(self).progress_words(self)
        return words


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
    if done:
        last = (folder / JOURNAL).stat().st_mtime
    else:
        last = begun
    seconds = max(0.0, last - begun)
    if done:
        left = seconds / done * (chunks - done)
    else:
        left = None
    return Progress(kind, done, chunks, items, seconds, max(0.0, time.time() - last), left)


def _describe_note(note: Path) -> str:
    try:
        note_read = _read_note(note)
    except (ResultFileError, OSError):
        return f"a {JOB} that is not of a job"
    return f"{note_read.job.kind} {note_read.sha256[:12]} of version {note_read.job.version[:40]}"


def _read_note(note: Path) -> Any:
    """The entries of a job.json, strictly.

    Raises:
        OSError: the file cannot be read.
        ResultFileError: it is not JSON, or not of a job; names the element.
    """
    content = read_file(note, _LARGEST)
    try:
        return decode(_note_table(), msgspec.json.decode(content))
    except (ValueError, RecursionError, msgspec.MsgspecError) as error:
        raise ResultFileError("this is not JSON that can be read", where="$", got=str(error)[:80]) from error


@dataclass(frozen=True, slots=True)
class Engine:
    """Where chunks are made.

    Attributes:
        workers: local processes; 0 for one of every processor.
        scheduler: address of a Dask scheduler ("tcp://10.0.0.1:8786"), or of none.
        here: in this process, one after another: what takes less time than processes take to begin.
    """

    workers: int = 0
    scheduler: str | None = None
    here: bool = False


def check_engine(engine: Engine) -> None:
    """Find out before a long run whether the engine is there.

    Raises:
        OptionError: a number of workers outside what is allowed.
        MissingExtraError: a scheduler, and Dask's distributed is not installed.
    """
    count = engine.workers
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= MOST_WORKERS:
        raise OptionError("this is no number of workers", where="workers", got=count, allowed=f"0 … {MOST_WORKERS}")
    if engine.scheduler is not None:
        _import_distributed()


def finish(
    job: Job,
    engine: Engine | None = None,
    *,
    folder: str | Path | None = None,
    report: Report | None = None,
    each: Callable[[int, bytes], None] | None = None,
) -> Iterator[Made]:
    """Make every chunk that is not there yet, and give all of them in order.

    Args:
        job: what is to be done.
        engine: local processes by default.
        folder: finished chunks are kept there, and taken from there; None: in memory.
        report: called with (chunks done, chunks).
        each: called with the number and the bytes of every chunk, of those that were there first, then as they are
            finished, in any order; what it raises ends the job.

    Raises:
        RankdropError: as the work of a chunk raises it; OptionError of the engine; ResultFileError of the folder.
            KeyboardInterrupt passes; what is finished is kept in the folder.
    """
    engine = engine or Engine()
    check_engine(engine)
    store: Folder | _ChunksInMemory = _ChunksInMemory({}) if folder is None else Folder.open(folder, job)
    with contextlib.ExitStack() as held:
        done = store.finished()
        if isinstance(store, Folder) and len(done) < job.chunks:
            held.enter_context(hold_lock(store.path, JOB))
            # another process may have begun another job, or finished chunks, since
            store = Folder.open(store.path, job)
            done = store.finished()
        _make_the_rest(job, engine, store, done, report or _silent, each or _silent)
    for chunk in range(job.chunks):  # one at a time: a job larger than the memory is kept in a folder
        yield chunk, store.take(chunk)


def _silent(_: int, __: object) -> None:
    """Report nothing."""


def _make_the_rest(
    job: Job, engine: Engine, store: Folder | _ChunksInMemory, done: set[int], report: Report,
    each: Callable[[int, bytes], None],
) -> None:  # fmt: skip
    """Make and keep every chunk that is not done; `each` receives those that are done first."""
    for chunk in sorted(done):
        each(chunk, store.read(chunk))
    count = len(done)
    report(count, job.chunks)
    left = [chunk for chunk in range(job.chunks) if chunk not in done]
    if not left:
        return
    with contextlib.closing(_make_chunks(job, left, engine)) as making:
        for chunk, content in making:
            store.keep(chunk, content)
            each(chunk, content)
            count += 1
            report(count, job.chunks)


def _make_chunks(job: Job, chunks: list[int], engine: Engine) -> Generator[Made, None, None]:
    if engine.scheduler is not None:
        return _on_cluster(job, chunks, engine.scheduler)
    if engine.here:
        return ((chunk, perform(job.work, job.plan, chunk)) for chunk in chunks)
    return _on_processes(job, chunks, min(engine.workers or os.cpu_count() or 1, len(chunks)))


def _on_processes(job: Job, chunks: list[int], count: int) -> Generator[Made, None, None]:
    todo: queue.SimpleQueue[int] = queue.SimpleQueue()
    answers: queue.Queue[Made | Exception] = queue.Queue(count)  # workers wait for a slow disk, not the memory for them
    for chunk in chunks:
        todo.put(chunk)
    crew = [_Worker(job) for _ in range(count)]
    threads = [threading.Thread(target=_serve, args=(worker, todo, answers), daemon=True) for worker in crew]
    for thread in threads:
        thread.start()
    try:
        for _ in chunks:
            answer = answers.get()
            if isinstance(answer, Exception):
                raise answer
            yield answer
    finally:  # done, an error, or Ctrl-C: nobody is left behind
        while not todo.empty():
            with contextlib.suppress(queue.Empty):
                todo.get_nowait()
        for worker, thread in zip(crew, threads, strict=True):
            while thread.is_alive():  # it may just have begun another process, or wait until its answer is taken
                worker.close()
                with contextlib.suppress(queue.Empty):
                    answers.get_nowait()
                thread.join(0.1)
            worker.stop()


def _serve(worker: _Worker, todo: queue.SimpleQueue[int], answers: queue.Queue[Made | Exception]) -> None:
    while True:
        try:
            chunk = todo.get_nowait()
        except queue.Empty:
            return
        try:
            answers.put((chunk, worker.make(chunk)))
        except Exception as error:  # handed to the caller, who raises it
            answers.put(error)
            return


class _Worker:
    def __init__(self, job: Job) -> None:
        self._job = job
        self._closed = False
        self._process: subprocess.Popen[bytes] | None = None

    def make(self, chunk: int) -> bytes:
        """The bytes of a chunk.

        Raises:
            RankdropError: of its work, or too many workers died of it.
            RuntimeError: an internal error of the work.
        """
        for _ in range(ATTEMPTS):
            if self._closed:
                break
            try:
                kind, content = self._ask(chunk)
            except (OSError, EOFError, ValueError):  # it was killed, or ran out of memory
                self.stop()
                continue
            if kind == "error":
                raise error_from_dict(json.loads(content))
            if kind == "broken":
                raise RuntimeError(content.decode("utf-8", "replace"))
            return content
        raise RankdropError("workers died of a chunk", where=f"chunk {chunk}", got=f"{ATTEMPTS} times",
                            mend="there may be too little memory: fewer workers")  # fmt: skip

    def _ask(self, chunk: int) -> tuple[str, bytes]:
        process = self._process or self._begin()
        stdin, answer = _pipes(process)
        stdin.write(f"{chunk}\n".encode())
        stdin.flush()
        kind, _, length = answer.readline().decode("ascii").partition(" ")
        content = answer.read(int(length))
        if len(content) < int(length):
            raise EOFError
        return kind, content

    def _begin(self) -> subprocess.Popen[bytes]:
        home = str(Path(__file__).resolve().parents[2])
        paths = [home, *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = {**os.environ, **dict.fromkeys(_THREADS, "1"), "PYTHONPATH": os.pathsep.join(paths)}
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "rankdrop.jobs.running"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            env=environment,
        )  # fmt: skip
        stdin, _ = _pipes(self._process)
        stdin.write(json.dumps({"work": self._job.work, "plan": self._job.plan}).encode() + b"\n")
        return self._process

    def stop(self) -> None:
        """End the process and close its pipes; another one is begun where a chunk is asked for."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    with contextlib.suppress(OSError):
                        pipe.close()

    def close(self) -> None:
        """End the process, also one that is at work, from another thread; no other one is begun."""
        self._closed = True
        process = self._process
        if process is not None:
            process.kill()
            process.wait()


def _pipes(process: subprocess.Popen[bytes]) -> tuple[IO[bytes], IO[bytes]]:
    if process.stdin is None or process.stdout is None:
        raise OSError("a worker without pipes")
    return process.stdin, process.stdout


def _import_distributed() -> Any:
    try:
        import distributed
        import threadpoolctl  # noqa: F401  # the workers need it, who have what the caller has
    except ImportError as error:
        raise MissingExtraError("distributed", "cluster", "a cluster") from error
    return distributed


def _on_cluster(job: Job, chunks: list[int], address: str) -> Generator[Made, None, None]:
    distributed = _import_distributed()
    try:
        client = distributed.Client(address, timeout=10)
    except (OSError, ValueError, RuntimeError) as error:  # RuntimeError: encryption is required, and not used
        raise OptionError("no scheduler answers", where="scheduler", got=address,
                          allowed="a Dask scheduler: tcp://HOST:8786 or tls://HOST:8786") from error  # fmt: skip
    try:
        plan = client.scatter(job.plan, broadcast=True, hash=False)
        futures = [
            client.submit(on_cluster, job.work, plan, chunk, VERSION, key=f"rankdrop-{job.sha256[:16]}-{chunk}",
                          pure=False, retries=ATTEMPTS)
            for chunk in chunks
        ]  # fmt: skip
        for future in distributed.as_completed(futures):
            yield future.result()
            future.release()
    finally:
        client.close()


def on_cluster(work: str, plan: dict[str, Any], chunk: int, version: str) -> Made:
    """One chunk on a worker of a cluster, with one thread of BLAS.

    Raises:
        RankdropError: of the work; another version of rankdrop is installed on the worker.
    """
    if version != VERSION:
        raise RankdropError("the cluster has another version of rankdrop", got=VERSION, allowed=version)
    import threadpoolctl

    with threadpoolctl.threadpool_limits(1):  # as many as a local worker has: the number decides last bits of sums
        return chunk, perform(work, plan, chunk)


def work() -> None:
    """Make chunks until the input ends: what a worker's process does.

    It has its own process, so that BLAS has one thread from the beginning, a crash or a kill costs one chunk, and a
    caller's script is never imported by it. In: one line of JSON with work and plan, then a line with a number for each
    chunk. Out, for each: a line "ok LENGTH", "error LENGTH" or "broken LENGTH", then so many bytes: the chunk, an error
    as JSON, or a traceback. What the work prints goes to standard error.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which then closes the input
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    job = json.loads(sys.stdin.buffer.readline())
    for line in sys.stdin.buffer:
        kind, content = _answer(job, int(line))
        try:
            answers.write(f"{kind} {len(content)}\n".encode() + content)
            answers.flush()
        except BrokenPipeError:  # the parent was killed
            os._exit(0)


def _answer(job: dict[str, object], chunk: int) -> tuple[str, bytes]:
    try:
        return "ok", perform(str(job["work"]), job["plan"], chunk)  # type: ignore[arg-type]  # plain data of a Job
    except RankdropError as error:
        return "error", json.dumps(error_to_dict(error)).encode()
    except Exception:  # whatever it is goes to the parent, which raises it with the traceback
        return "broken", traceback.format_exc().encode()


if __name__ == "__main__":
    work()
