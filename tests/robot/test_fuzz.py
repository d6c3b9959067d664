"""Whatever the bytes of a file are, a reader gives what it is to give, or says what is wrong with them.

Long runs, guided by coverage, are `.ci/fuzz`; here the committed corpus of each reader, what once failed included, and
what hypothesis makes of it.
"""

from __future__ import annotations

import json
import random
import zlib
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scripts import tool

from rankdrop.cover.covering import load_covering
from rankdrop.errors import ResultFileError
from rankdrop.proof.boxes import MAGIC

FUZZ = tool("fuzz_readers")
SLOW_TO_START = ("bag", "mcap", "mesh", "xacro", "arguments")  # they start a process for each file, or a whole command


@cache
def reader(name: str) -> Any:
    """The reader, with a folder for its files."""
    return FUZZ.readers(Path(mkdtemp()))[name]


@pytest.mark.by_hand_at("mjcf", "mesh", "bag", "mcap")
@pytest.mark.slow_at("mjcf", "mesh", "bag", "mcap", "xacro", "arguments")
@pytest.mark.parametrize("name", FUZZ.NAMES)
def test_the_corpus_is_read_or_refused(name: str) -> None:
    cases = FUZZ.seeds(name)
    assert cases, "a corpus is committed for every reader"
    taken = [FUZZ.judged(reader(name), data) for data in cases]  # all of them, the first that is taken or not
    assert any(taken)


@pytest.mark.spread(3)
@pytest.mark.slow
@pytest.mark.by_hand_at("mjcf", "certificate", *SLOW_TO_START)
@pytest.mark.parametrize("name", FUZZ.NAMES)
@given(seed=st.integers(0, 2**32))
def test_changed_files_are_read_or_refused(name: str, seed: int) -> None:
    dice = random.Random(seed)
    for _ in range(3):
        FUZZ.judged(reader(name), FUZZ.mutated(dice, FUZZ.seeds(name)))


@pytest.mark.spread(7)
@pytest.mark.by_hand_at("tolerance", *SLOW_TO_START)
@pytest.mark.slow
@pytest.mark.parametrize("name", FUZZ.NAMES)
@given(data=st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_any_bytes_are_read_or_refused(name: str, data: bytes) -> None:
    FUZZ.judged(reader(name), data)


def test_what_a_reader_may_not_do_is_seen() -> None:
    """A reader that fails in another way, or that warns, or that passes a control character on, is told."""

    def broken(data: bytes) -> object:
        if data.startswith(b"w"):
            import warnings

            warnings.warn("of NumPy", RuntimeWarning, stacklevel=1)
        if data.startswith(b"c"):
            raise ResultFileError("\x1b[2J")
        return {}[data]

    for data, kind in ((b"w", RuntimeWarning), (b"k", KeyError)):
        with pytest.raises(kind):
            FUZZ.judged(broken, data)


class Process:
    """A process of cases, planted: it gives these lines, ends with this code, or gives nothing more."""

    def __init__(self, lines: list[str], code: int = 0) -> None:
        self.stdout, self.returncode = lines, code

    def __enter__(self) -> Process:
        return self

    def __exit__(self, *of: object) -> None:
        pass

    def wait(self) -> int:
        return self.returncode


def test_a_case_that_takes_its_process_with_it_has_failed_and_the_next_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    count = 2 + len(FUZZ.seeds("quantity"))
    fine = [json.dumps([number, True, "", 0.1, 1000]) + "\n" for number in range(count)]
    greedy = json.dumps([1, False, "2.0 GB of memory; ", 0.1, 2**31]) + "\n"
    started = iter([Process([fine[0], greedy]), Process(fine[2:4], -9), Process(fine[5:])])
    monkeypatch.setattr(FUZZ.subprocess, "Popen", lambda *_, **__: next(started))
    assert FUZZ.blind("quantity", 2, 1, tmp_path) == 2
    told = capsys.readouterr()
    record = json.loads(told.out)
    assert (record["cases"], record["failed"], record["taken"], record["memory_mb"]) == (count, 2, count - 2, 2048)
    assert "2.0 GB of memory" in told.err
    assert "the process ended with -9" in told.err
    assert len(list((tmp_path / "quantity").glob("*"))) == 2, "what failed is kept"


@pytest.mark.slow
def test_a_case_beyond_its_time_or_memory_has_failed(monkeypatch: pytest.MonkeyPatch, capfd: Any) -> None:
    monkeypatch.setattr(FUZZ, "SECONDS", -1.0)
    FUZZ.serve("quantity", 1, 0, 1)
    (number, _, fault, _, _) = json.loads(capfd.readouterr().out)
    assert (number, "s of the processor" in fault) == (0, True)
    monkeypatch.setattr(FUZZ, "MEMORY", -1)
    FUZZ.serve("quantity", 1, 0, 9)
    lines = capfd.readouterr().out.splitlines()
    assert len(lines) == 1, "after a case of much memory the process ends: its peak never falls"
    assert "GB of memory" in json.loads(lines[0])[2]


def test_a_case_is_blown_up_to_a_megabyte_at_most() -> None:
    sizes = [len(FUZZ.grown(random.Random(seed), b"one\ntwo\nthree\n")) for seed in range(200)]
    assert max(sizes) <= FUZZ.GROWN
    assert max(sizes) > FUZZ.GROWN / 2
    cases = [FUZZ.case_of("csv", 1, number, [b"a,b\n1,2\n"]) for number in range(1, 200)]
    assert cases[:50] == [FUZZ.case_of("csv", 1, number, [b"a,b\n1,2\n"]) for number in range(1, 51)]
    assert max(map(len, cases)) > FUZZ.LONGEST


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"depth": [10**9, 1], "top": 10**9}, "halvings are"),
        ({"depth": [40] * 6, "top": 39}, "too many"),
        ({"depth": [1] * 40}, "entries"),
        ({"depth": []}, "entries"),
        ({"depth": [1, -1]}, "halvings are"),
        ({"top": 9}, "halvings are"),
    ],
)
def test_a_covering_of_more_boxes_than_bytes_is_refused(changed: dict[str, Any], words: str, tmp_path: Path) -> None:
    """The number of boxes was believed: 2 to the power of what a file says."""
    (whole,) = [data for data in FUZZ.seeds("cover") if FUZZ.judged(reader("cover"), data)][:1]
    line, packed = whole.removeprefix(MAGIC).split(b"\n", 1)
    record = json.loads(line)
    record["plan"] |= changed
    path = tmp_path / "a.cover"
    path.write_bytes(MAGIC + json.dumps(record).encode() + b"\n" + packed)
    with pytest.raises(ResultFileError, match=words):
        load_covering(path)


@pytest.mark.slow
def test_a_covering_that_unpacks_to_more_than_it_says_is_refused(tmp_path: Path) -> None:
    (whole,) = [data for data in FUZZ.seeds("cover") if FUZZ.judged(reader("cover"), data)][:1]
    line, packed = whole.removeprefix(MAGIC).split(b"\n", 1)
    path = tmp_path / "a.cover"
    path.write_bytes(MAGIC + line + b"\n" + zlib.compress(zlib.decompress(packed) + bytes(2**26)))
    with pytest.raises(ResultFileError, match="ends too soon, or too late"):
        load_covering(path)
    path.write_bytes(MAGIC + b"[" * 100_000 + b"\n")
    with pytest.raises(ResultFileError, match="damaged"):
        load_covering(path)
