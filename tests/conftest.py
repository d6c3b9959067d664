"""Shared by all tests: hypothesis is deterministic, `rng` gives every test the same numbers each run.

`run` and `process` run a command line, in this process and as its own; `found` and `shapes` are analyses.
"""

from __future__ import annotations

import gc
import os
import re
import signal
import subprocess
from collections import defaultdict
from collections.abc import Generator
from pathlib import Path

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # small matrices, a test process for each core: threads of a BLAS only wait

import numpy as np
import pytest
from analyses import every_shape
from command_line import Ended, Run, command
from hypothesis import settings

from rankdrop.cli import main
from rankdrop.results import known as known_exact
from rankdrop.results.analysis import Analysis
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze

Report = pytest.TestReport | pytest.CollectReport

gc.disable()  # until all tests are collected: what is made until then stays
settings.register_profile("same-every-run", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("same-every-run")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # a shell starts jobs in the background so, and all that they start: tests that press Ctrl-C would wait for ever
    signal.signal(signal.SIGINT, signal.default_int_handler)


_CROSS = Path(__file__).parent / "cross"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Marks the cases that `slow_at` and `by_hand_at` name; as slow what is run by hand, in a browser, with a peer."""
    for item in items:
        if named_by("by_hand_at", item):
            item.add_marker(pytest.mark.by_hand)
        if item.path.is_relative_to(_CROSS):
            item.add_marker(pytest.mark.cross)
        if named_by("slow_at", item) or any(item.get_closest_marker(name) for name in ("by_hand", "browser", "cross")):
            item.add_marker(pytest.mark.slow)
    leave_to_hand(items)


def leave_to_hand(items: list[pytest.Item]) -> None:
    """Marks what `spread(n)` leaves out: of a test's slow cases all but n, evenly spaced, are run by hand."""
    cases: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        marked = {mark.name for mark in item.iter_markers()}
        if {"spread", "slow"} <= marked and "by_hand" not in marked:
            cases[item.nodeid.partition("[")[0]].append(item)
    for some in cases.values():
        mark = some[0].get_closest_marker("spread")
        assert mark is not None
        kept = {k * len(some) // mark.args[0] for k in range(mark.args[0])}
        for place, item in enumerate(some):
            if place not in kept:
                item.add_marker(pytest.mark.by_hand)


def named_by(marker: str, item: pytest.Item) -> bool:
    """Whether a marker of the test names this case: a value of a parameter, or the whole id."""
    named = {word for mark in item.iter_markers(marker) for word in mark.args}
    call = getattr(item, "callspec", None)
    return call is not None and bool(named & {call.id, *call.id.split("-"), *map(str, call.params.values())})


def pytest_collection_finish() -> None:
    """Ten thousand tests stay until the end: the garbage collector need not look through them again and again."""
    gc.collect()
    gc.freeze()
    gc.enable()


REQUIRED = os.environ.get("RANKDROP_REQUIRE_ALL", "")
"""In the checks every program and package that a test needs is there: a skip for want of one is a failure.

"test": but for packages of other extras than `test`.
"""
_MISSING = re.compile(r"installed|could not import|No module named|needs the extra")
_ELSEWHERE = re.compile(r'extra "(cross|docs|browser|dev)"')


def required(report: Report) -> Report:
    """A report; one of a test that was skipped for want of a program or a package tells of a failure."""
    reason = str(report.longrepr[2]) if report.skipped and isinstance(report.longrepr, tuple) else ""
    optional = REQUIRED == "test" and _ELSEWHERE.search(reason)
    if REQUIRED and _MISSING.search(reason) and not optional:
        report.outcome = "failed"
        report.longrepr = f"{reason}: RANKDROP_REQUIRE_ALL asks for it"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, Report, Report]:
    """One test."""
    return required((yield))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, Report, Report]:
    """One file of tests."""
    return required((yield))


@pytest.fixture(autouse=True)
def _derived_anew(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests are of derivations, not of the results that are shipped, unless they are marked `shipped`."""
    if request.node.get_closest_marker("shipped") is None:
        monkeypatch.setattr(known_exact, "conditions_record", lambda name: None)


@pytest.fixture
def rng() -> np.random.Generator:
    """A random generator with a fixed seed, fresh for every test."""
    return np.random.default_rng(20240229)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """run("analyze", "pa10", width=100): one command line in this process."""

    def once(*argv: str, width: int = 100) -> Ended:
        monkeypatch.setenv("COLUMNS", str(width))
        capsys.readouterr()
        code = main.run(argv)
        text = capsys.readouterr()
        return Ended(code, text.out, text.err)

    return once


@pytest.fixture
def process() -> Run:
    """process("analyze", "pa10"): one command line as its own process."""

    def once(*argv: str, **environment: str) -> Ended:
        everything = {**os.environ, **environment}
        done = subprocess.run(command(*argv), capture_output=True, text=True, env=everything, timeout=120)
        return Ended(done.returncode, done.stdout, done.stderr)

    return once


@pytest.fixture(scope="session")
def found() -> Analysis:
    """A real analysis, small and quick: 3 coranks of an arm with prismatic and revolute joints."""
    return analyze(open_robot("scara"), starts=200)


@pytest.fixture
def shapes() -> Analysis:
    """A made-up analysis with every shape that a row can have."""
    return every_shape()
