"""What the core does where threads or memory are refused, in a forked child, and when it is interrupted."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from reference import arms

from rankdrop import _core
from rankdrop.kinematics import chain_of, task_view
from rankdrop.robot.model import Array
from rankdrop.task import resolve_task

linux = pytest.mark.skipif(sys.platform != "linux", reason="address space can be limited on Linux alone")


def in_a_process(script: str) -> subprocess.CompletedProcess[str]:
    """Run Python code by itself: what ends a process ends that one."""
    begin = """
        import os, sys, signal, threading, time
        import numpy as np
        from reference import arms
        from rankdrop import _core
        from rankdrop.kinematics import chain_of, task_view
        from rankdrop.kinematics import jacobian, jacobian_derivative
        from rankdrop.task import resolve_task

        def room(megabytes):
            import resource
            used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (used + (megabytes << 20),) * 2)
    """
    code = textwrap.dedent(begin) + textwrap.dedent(script)
    path = os.pathsep.join(entry for entry in sys.path if entry)
    single = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120,
        env=os.environ | single | {"PYTHONPATH": path}, check=False,
    )  # fmt: skip


def answered(script: str) -> str:
    """What the code printed.

    Raises:
        AssertionError: it did not end well.
    """
    done = in_a_process(script)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.slow
@linux
def test_a_search_goes_on_where_no_thread_can_be_started() -> None:
    """A stack takes 8 MB of address space; there are 4."""
    assert (
        answered("""
        from rankdrop import search
        robot = arms.pa10()
        want = search(robot, 2, starts=300, seed=3, threads=1)
        room(4)
        try:
            threading.Thread(target=int).start()
            print("a thread could be started", end=" ")
        except RuntimeError:
            pass
        found = search(robot, 2, starts=300, seed=3, threads=8)
        print(_core.threads_kept(), np.array_equal(found.q, want.q), np.array_equal(found.outcome, want.outcome))
    """)
        == "0 True True"
    )


@pytest.mark.slow
@linux
def test_a_search_goes_on_under_a_limit_on_processes() -> None:
    """`ulimit -u`, as containers have it; the superuser is bound by none, so that he becomes another user first."""
    assert (
        answered("""
        import resource
        from rankdrop import search
        robot = arms.pa10()
        want = search(robot, 2, starts=300, seed=3, threads=1)
        resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))
        if os.geteuid() == 0:
            os.setuid(65534)
        try:
            threading.Thread(target=int).start()
            print("a thread could be started", end=" ")
        except RuntimeError:
            pass
        found = search(robot, 2, starts=300, seed=3, threads=8)
        print(_core.threads_kept(), np.array_equal(found.q, want.q), np.array_equal(found.outcome, want.outcome))
    """)
        == "0 True True"
    )


@linux
def test_no_memory_for_a_result_is_a_memory_error() -> None:
    assert (
        answered("""
        robot = arms.pa10()
        q = np.zeros((200_000, 7))
        room(100)
        try:
            jacobian_derivative(robot, q)
        except MemoryError:
            print("refused", jacobian(robot, q[:3]).shape)
    """)
        == "refused (3, 6, 7)"
    )


LONG = """
        _core.choose_instruction_set("baseline")
        n = 2000  # scratch of one thread: n × n pairs of doubles, 64 MB
        chain = _core.make_chain(
            screws=np.random.default_rng(0).normal(size=(n, 6)), turns=[0] * n, variable=list(range(n)),
            frames=np.tile(np.eye(4), (n + 2, 1, 1)), multiplier=np.ones(n), offset=np.zeros(n), variables=n,
        )
        view = _core.make_view(chain, axes=0, origin=0, point=[0.0] * 3, rows=[0, 1, 2], factors=[1.0] * 3)
        q = np.zeros((300, n))
        want = _core.singular_values(chain, view, q, threads=3)
"""


@linux
@pytest.mark.parametrize("threads", [1, 3])
def test_no_memory_for_scratch_is_a_memory_error(threads: int) -> None:
    assert (
        answered(
            LONG
            + f"""
        room(40)
        try:
            _core.singular_values(chain, view, q, threads={threads})
        except MemoryError:
            print("refused", _core.pose(chain, q[:1], threads={threads}).shape)
    """
        )
        == "refused (1, 4, 4)"
    )


@pytest.mark.slow
@linux
def test_a_thread_that_gets_no_memory_leaves_its_rows_to_the_others() -> None:
    """There is room for the scratch of one thread, three want theirs."""
    assert (
        answered(
            LONG
            + """
        room(90)
        print(all(np.array_equal(_core.singular_values(chain, view, q, threads=3), want) for _ in range(5)))
    """
        )
        == "True"
    )


def batch(rows: int) -> tuple[_core.Chain, _core.View, Array]:
    robot = arms.pa10()
    q = np.random.default_rng(1).uniform(-3, 3, (rows, 7))
    return chain_of(robot), task_view(robot, resolve_task("pose", robot)), q


@pytest.mark.parametrize("rows", [1, 256, 257, 1000, 5003])
@pytest.mark.parametrize("threads", [0, 2, 5, 64])
def test_results_do_not_depend_on_the_number_of_threads(rows: int, threads: int) -> None:
    chain, view, q = batch(rows)
    for many, one in zip(
        _core.decompose(chain, view, q, threads=threads), _core.decompose(chain, view, q, threads=1), strict=True
    ):
        np.testing.assert_array_equal(many, one)


def test_threads_are_kept_between_calls_and_no_more_than_the_machine_can_run() -> None:
    chain, view, q = batch(4000)
    _core.jacobian(chain, view, q, threads=2)
    assert _core.threads_kept() >= 1
    for _ in range(50):
        _core.jacobian(chain, view, q, threads=64)
    for _ in range(200):
        if _core.threads_kept() <= (os.cpu_count() or 1):
            break
        time.sleep(0.01)
    assert _core.threads_kept() <= (os.cpu_count() or 1)


def test_batches_of_several_python_threads_at_once() -> None:
    chain, view, q = batch(3000)
    want = _core.singular_values(chain, view, q, threads=1)
    wrong: list[int] = []

    def ask(number: int) -> None:
        for _ in range(20):
            if not np.array_equal(_core.singular_values(chain, view, q, threads=1 + number % 4), want):
                wrong.append(number)

    asking = [threading.Thread(target=ask, args=(number,)) for number in range(6)]
    for thread in asking:
        thread.start()
    for thread in asking:
        thread.join(60)
    assert not wrong
    assert not any(thread.is_alive() for thread in asking)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_a_forked_child_has_threads_of_its_own() -> None:
    """The parent's threads are not in the child; waiting for them would never end."""
    assert (
        answered("""
        robot = arms.pa10()
        q = np.random.default_rng(1).uniform(-3, 3, (3000, 7))
        want = jacobian(robot, q)
        assert _core.threads_kept() >= 1 or os.cpu_count() == 1
        child = os.fork()
        if child == 0:
            kept = _core.threads_kept()
            same = np.array_equal(jacobian(robot, q), want) and np.array_equal(jacobian(robot, q), want)
            os._exit(0 if same and kept == 0 else 3)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), np.array_equal(jacobian(robot, q), want))
    """)
        == "0 True"
    )


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.slow_at("1")
@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_ends_a_long_batch_and_leaves_the_threads_usable(threads: int) -> None:
    assert (
        answered(f"""
        robot = arms.pa10()
        chain, view = chain_of(robot), task_view(robot, resolve_task("pose", robot))
        q = np.random.default_rng(1).uniform(-3, 3, (3_000_000, 7))
        want = _core.singular_values(chain, view, q[:1000], threads=1)
        signal.signal(signal.SIGALRM, signal.default_int_handler)
        signal.setitimer(signal.ITIMER_REAL, 0.15)
        done = 0
        try:
            for _ in range(100):
                _core.singular_values(chain, view, q, threads={threads})
                done += 1
        except KeyboardInterrupt:
            again = _core.singular_values(chain, view, q[:1000], threads={threads})
            print(done < 100, np.array_equal(again, want))
    """)
        == "True True"
    )


@pytest.mark.slow
@linux
def test_searching_arms_of_thirty_joints_takes_no_more_memory_than_of_seven() -> None:
    """Scratch grows with the square of the joints, by a few hundred kilobytes: docs/limits.md tells 0.04 GB."""
    done = in_a_process("""
        import re
        from rankdrop.families.searching import search

        def most():  # of this process: what getrusage tells begins with that of the one it was forked from
            return int(re.search(r"VmHWM:\\s*([0-9]+) kB", open("/proc/self/status").read())[1]) / 1024

        found, sizes = [], []
        for n in (7, 20, 30):
            arm = arms.random_chain(np.random.default_rng(n), "r" * n)
            found.append(int((search(arm, 1, starts=100, threads=1).outcome == 0).sum()))
            sizes.append(most())
        print(min(found) > 20, sizes[-1] - sizes[0] < 10, sizes[-1] < 120)
    """)
    assert done.stdout.split() == ["True"] * 3, done.stdout + done.stderr
