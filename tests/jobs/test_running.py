"""The engine: the same bytes from one worker, several, a cluster, and after every kind of interruption."""

from __future__ import annotations

import errno
import importlib.util
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from patience import until

from rankdrop import disk
from rankdrop.errors import MissingExtraError, OptionError, RankdropError, ResultFileError
from rankdrop.jobs import Engine, Job, finish, progress_of
from rankdrop.jobs.running import Folder

TESTS = Path(__file__).resolve().parents[1]
CHUNKS = 7


@pytest.fixture(autouse=True)
def workers_find_the_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    old = os.environ.get("PYTHONPATH")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(TESTS), *([old] if old else [])]))


def job(work: str = "squares", chunks: int = CHUNKS, **plan: Any) -> Job:
    return Job("test", f"engine.work:{work}", {"seed": 5, **plan}, chunks, chunks)


def made(one: Job, workers: int = 1, **how: Any) -> list[tuple[int, bytes]]:
    return list(finish(one, Engine(workers), **how))


@pytest.fixture(scope="module")
def truth() -> list[tuple[int, bytes]]:
    old = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join([str(TESTS), *([old] if old else [])])
    try:
        return made(job())
    finally:
        os.environ.pop("PYTHONPATH") if old is None else os.environ.update(PYTHONPATH=old)


def parts(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted((folder / "parts").iterdir())}


@pytest.mark.slow
def test_chunks_come_in_order_whatever_the_number_of_workers(truth: list[tuple[int, bytes]], tmp_path: Path) -> None:
    assert [chunk for chunk, _ in truth] == list(range(CHUNKS))
    log = tmp_path / "log"
    assert made(job(log=str(log)), 3) == truth
    lines = [line.split() for line in log.read_text().splitlines()]
    assert sorted(int(line[0]) for line in lines) == list(range(CHUNKS))
    assert {line[2] for line in lines} == {"1"}, "BLAS has more than one thread"
    assert str(os.getpid()) not in {line[1] for line in lines}


@pytest.mark.by_hand
def test_workers_wait_for_a_slow_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two workers may be a chunk each ahead of what waits to be written, two chunks at most."""
    log, ahead, keep = tmp_path / "log", [], Folder.keep

    def slowly(self: Folder, chunk: int, content: bytes) -> None:
        time.sleep(0.1)
        keep(self, chunk, content)
        ahead.append(len(log.read_text().splitlines()) - len(ahead))

    monkeypatch.setattr(Folder, "keep", slowly)
    assert len(made(job(chunks=20, log=str(log)), 2, folder=tmp_path / "out")) == 20
    assert max(ahead) <= 6


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_one_chunk(truth: list[tuple[int, bytes]], tmp_path: Path) -> None:
    log = tmp_path / "log"
    assert made(job("dies_once", mark=str(tmp_path / "mark"), log=str(log)), 2, folder=tmp_path / "out") == truth
    assert (tmp_path / "mark").exists(), "nothing was killed"
    assert len(log.read_text().splitlines()) == CHUNKS  # the chunk that died had said nothing yet


@pytest.mark.slow
def test_a_chunk_that_workers_die_of_is_told() -> None:
    with pytest.raises(RankdropError, match=r"chunk 1: workers died of a chunk; got 3 times"):
        made(job("dies"), 2)


@pytest.mark.slow
def test_errors_of_the_work_arrive_as_they_were() -> None:
    with pytest.raises(RankdropError, match=r"chunk 0: it is refused; got 5; allowed: nothing"):
        made(job("refuses"))
    with pytest.raises(RuntimeError, match="ZeroDivisionError: chunk 0"):
        made(job("breaks", chunks=1))


@pytest.mark.slow
def test_what_the_work_prints_is_not_its_answer(truth: list[tuple[int, bytes]]) -> None:
    assert made(job("talks")) == truth


@pytest.mark.slow
def test_a_folder_takes_up_where_it_was(truth: list[tuple[int, bytes]], tmp_path: Path) -> None:
    log, out = tmp_path / "log", tmp_path / "out"
    one = job(log=str(log))
    assert made(one, folder=out) == truth
    whole = parts(out)
    assert len(log.read_text().splitlines()) == CHUNKS
    assert made(one, 2, folder=out) == truth
    assert len(log.read_text().splitlines()) == CHUNKS, "finished chunks were made again"
    journal = (out / "journal").read_bytes()
    (out / "journal").write_bytes(journal[: journal.index(b"\n", 200) - 20])  # torn in the middle of a line
    (out / "parts" / "00000.json").write_bytes(b"damaged")
    assert made(one, 2, folder=out) == truth
    assert parts(out) == whole
    again = [int(line.split()[0]) for line in log.read_text().splitlines()[CHUNKS:]]
    kept = [int(line.split()[0]) for line in journal.decode().splitlines()[:2]]
    assert 0 in again
    assert not set(again) & (set(kept) - {0})


def test_a_folder_of_another_job_is_refused(tmp_path: Path) -> None:
    made(job(chunks=1), folder=tmp_path)
    with pytest.raises(ResultFileError, match=r"the folder holds another job; got test .*fix: name another folder"):
        made(job(chunks=1, other=1), folder=tmp_path)
    with pytest.raises(ResultFileError, match="there is no job in the folder"):
        progress_of(tmp_path / "nothing")


@pytest.mark.slow
def test_a_full_disk_loses_nothing_that_was_finished(
    truth: list[tuple[int, bytes]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep, count = disk.replace_file, 0

    def full(path: Path, content: bytes) -> None:
        nonlocal count
        count += 1
        if count > 4:  # job.json and three parts
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        keep(path, content)

    monkeypatch.setattr("rankdrop.jobs.running.replace_file", full)
    with pytest.raises(ResultFileError, match="No space left on device; fix: finished work is kept"):
        made(job(), folder=tmp_path)
    assert len(Folder(tmp_path, job()).finished()) == 3
    monkeypatch.undo()
    monkeypatch.setenv("PYTHONPATH", str(TESTS))
    assert made(job(), folder=tmp_path) == truth


def test_progress_is_read_from_the_folder_alone(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    generator = finish(job(chunks=3), Engine(1), folder=tmp_path, report=lambda done, total: told.append((done, total)))
    list(generator)
    assert told == [(0, 3), (1, 3), (2, 3), (3, 3)]
    found = progress_of(tmp_path)
    assert (found.kind, found.done, found.chunks) == ("test", 3, 3)
    assert found.sentence == "finished: 3 of 3 chunks of the test (3 items in all)"
    lines = (tmp_path / "journal").read_text().splitlines(keepends=True)
    (tmp_path / "journal").write_text("".join(lines[:1]))
    found = progress_of(tmp_path)
    assert (found.done, found.left is not None) == (1, True)
    assert "1 of 3 chunks" in found.sentence
    assert "left at the pace so far" in found.sentence


@pytest.mark.parametrize("workers", [-1, 100_000, True, "2"])
def test_numbers_of_workers_that_are_refused(workers: Any) -> None:
    with pytest.raises(OptionError, match="this is no number of workers"):
        made(job(), workers)


def test_a_cluster_without_its_packages_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"a cluster needs the package distributed.*\[cluster\]"):
        list(finish(job(), Engine(scheduler="tcp://127.0.0.1:1")))


KILLED = """
import sys
from rankdrop.jobs import Engine, finish
from jobs.test_running import job
list(finish(job(sleep=0.3, log=sys.argv[2]), Engine(2), folder=sys.argv[1]))
"""


@pytest.mark.by_hand
def test_a_run_that_is_killed_goes_on_and_ends_with_the_same_bytes(
    truth: list[tuple[int, bytes]], tmp_path: Path
) -> None:
    log, out = tmp_path / "log", tmp_path / "out"
    process = subprocess.Popen([sys.executable, "-c", KILLED, str(out), str(log)])
    journal = out / "journal"
    until(lambda: journal.exists() and journal.read_bytes().count(b"\n") >= 2)
    process.send_signal(signal.SIGKILL)
    process.wait()
    done = len(Folder(out, job(sleep=0.3, log=str(log))).finished())
    assert 2 <= done < CHUNKS
    time.sleep(1.0)  # its workers, whose input has ended, finish what they are at
    before = len(log.read_text().splitlines())
    assert made(job(sleep=0.3, log=str(log)), 2, folder=out) == truth
    assert len(log.read_text().splitlines()) - before == CHUNKS - done


@pytest.mark.by_hand
@pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs the extra `cluster`")
def test_a_cluster_and_one_that_loses_a_worker_give_the_same_bytes(
    truth: list[tuple[int, bytes]], tmp_path: Path
) -> None:
    import distributed

    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        assert list(finish(job(), Engine(scheduler=address), folder=tmp_path / "whole")) == truth
        lossy = job("dies_once", mark=str(tmp_path / "mark"))
        assert list(finish(lossy, Engine(scheduler=address), folder=tmp_path / "lossy")) == truth
        assert (tmp_path / "mark").exists(), "no worker was lost"
    assert parts(tmp_path / "lossy") == parts(tmp_path / "whole")


@pytest.mark.by_hand
@pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs the extra `cluster`")
def test_two_processes_on_loopback_are_a_cluster(truth: list[tuple[int, bytes]], tmp_path: Path) -> None:
    note = tmp_path / "scheduler.json"
    common = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    run = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0",
           "--no-dashboard", "--scheduler-file", str(note)]  # fmt: skip
    scheduler = subprocess.Popen(run, **common)  # type: ignore[call-overload]
    worker = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(note), "--nthreads", "1",
         "--no-dashboard"], **common,
    )  # type: ignore[call-overload]  # fmt: skip
    try:
        until(note.exists)
        import json

        assert list(finish(job(), Engine(scheduler=json.loads(note.read_text())["address"]))) == truth
    finally:
        for process in (worker, scheduler):
            process.terminate()
            process.wait()


def test_two_processes_do_not_fill_one_folder(truth: list[tuple[int, bytes]], tmp_path: Path) -> None:
    """The second is refused in one line while the first is at work; the lock ends with it."""
    out, refused = tmp_path / "out", []

    def second(chunk: int, content: bytes) -> None:
        if not refused:
            with pytest.raises(ResultFileError, match=r"out: another process is working on this; fix: wait"):
                made(job(), folder=out)
            refused.append(chunk)

    assert list(finish(job(), Engine(here=True), folder=out, each=second)) == truth
    assert refused
    assert not list(out.glob("*.lock"))
    assert made(job(), folder=out) == truth


def test_a_finished_job_is_read_without_a_lock(
    truth: list[tuple[int, bytes]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made(job(), folder=tmp_path)
    refuse = "a lock is made in a folder of results"
    monkeypatch.setattr("rankdrop.jobs.running.lock_name", lambda _: pytest.fail(refuse))
    assert made(job(), folder=tmp_path) == truth
