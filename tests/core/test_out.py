"""Results written into the caller's own array: the same bits, and nothing but the array that was given."""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from reference import arms

from rankdrop import _core, kinematics
from rankdrop.errors import OptionError
from rankdrop.kinematics import (
    chain_of,
    jacobian,
    jacobian_derivative,
    pose,
    task_jacobian,
    task_jacobian_derivative,
    task_view,
)
from rankdrop.local.block import decompose, singular_values
from rankdrop.robot.model import Array
from rankdrop.task import resolve_task

ROBOT = arms.pa10()
TASK = resolve_task("pose", ROBOT)
Function = Callable[..., Array]


def values(q: Array, *, out: Array | None = None) -> Array:
    return singular_values(ROBOT, q, TASK, out=out)


def of(function: Function) -> Function:
    return lambda q, *, out=None: function(ROBOT, q, out=out)


CASES = [(of(pose), (4, 4)), (of(jacobian), (6, 7)), (of(jacobian_derivative), (6, 7, 7)), (values, (6,))]
NAMES = ["pose", "jacobian", "jacobian_derivative", "singular_values"]


@pytest.mark.parametrize(("function", "entry"), CASES, ids=NAMES)
@pytest.mark.parametrize("batch", [(), (1,), (3, 5), (700,), (0,)], ids=str)
def test_the_given_array_is_filled_and_returned(
    function: Function, entry: tuple[int, ...], batch: tuple[int, ...], rng: np.random.Generator
) -> None:
    q = rng.uniform(-3, 3, (*batch, 7))
    out = np.full((*batch, *entry), np.nan)
    assert function(q, out=out) is out
    np.testing.assert_array_equal(out, function(q))


@pytest.mark.parametrize(("function", "entry"), CASES, ids=NAMES)
def test_an_array_that_does_not_fit_is_refused(function: Function, entry: tuple[int, ...]) -> None:
    q = np.zeros((4, 7))
    locked = np.zeros((4, *entry))
    locked.flags.writeable = False
    wrong: list[tuple[Any, str]] = [
        (np.zeros((3, *entry)), "does not fit"), (np.zeros((4, *entry), np.float32), "does not fit"),
        ([0.0] * 4, "does not fit"), (np.zeros((8, *entry))[::2], "row by row"), (locked, "row by row"),
    ]  # fmt: skip
    for out, words in wrong:
        with pytest.raises(OptionError, match=words):
            function(q, out=out)


def test_memory_of_the_configurations_is_refused() -> None:
    memory = np.zeros(4 * 42)
    q, out = memory[:28].reshape(4, 7), memory.reshape(4, 6, 7)
    with pytest.raises(OptionError, match="share memory"):
        jacobian(ROBOT, q, out=out)
    with pytest.raises(ValueError, match="share memory"):
        _core.jacobian(chain_of(ROBOT), task_view(ROBOT, TASK), q, out)


def test_the_core_never_writes_to_a_copy() -> None:
    """What would have to be converted is refused: the result would be lost."""
    q = np.zeros((4, 7))
    for out in (np.zeros((4, 6, 7), np.float32), np.zeros((8, 6, 7))[::2], np.zeros((4, 6, 7), ">f8")):
        with pytest.raises(TypeError, match="out is"):
            _core.jacobian(chain_of(ROBOT), task_view(ROBOT, TASK), q, out)
    for out in (np.zeros((6, 7), np.float32), np.zeros((6, 14))[:, ::2], np.zeros((6, 7), ">f8"), np.zeros((7, 6))):
        assert _core.jacobian_one(ROBOT, q[0], out, None) is None
        assert not out.any()


class Own(np.ndarray):  # type: ignore[type-arg]
    """A subclass, whose results NumPy would make in its own way."""


SHORT = [
    (_core.pose_one, (4, 4)), (_core.jacobian_one, (6, 7)), (_core.derivative_one, (6, 7, 7)), (_core.sigma_one, (6,)),
]  # fmt: skip


@pytest.mark.parametrize(("function", "entry"), SHORT)
def test_one_configuration_takes_the_short_way_only_as_plain_memory(function: Function, entry: tuple[int, ...]) -> None:
    view, q = task_view(ROBOT, TASK), np.linspace(-1, 1, 7)
    truth = function(ROBOT, q, None, view)
    assert type(truth) is np.ndarray
    assert truth.shape == entry
    memory = np.zeros(7 + int(np.prod(entry)))
    memory[-7:] = q
    locked = np.zeros(entry)
    locked.flags.writeable = False
    for refused in (q.astype(np.float32), q.astype(">f8"), np.repeat(q, 2)[::2], q.view(Own), q[None], q[:6], [*q],
                    q * np.nan, None):  # fmt: skip
        assert function(ROBOT, refused, None, view) is None
    for out in (locked, np.zeros(entry).view(Own), np.zeros((*entry, 1)), memory[2:-5].reshape(entry), "out"):
        assert function(ROBOT, memory[-7:], out, view) is None
    there = memory[:-7].reshape(entry)
    assert function(ROBOT, memory[-7:], there, view) is there
    np.testing.assert_array_equal(there, truth)
    with pytest.raises(TypeError, match="a View"):
        function(ROBOT, q, None, "view")
    with pytest.raises(TypeError, match="not 2 arguments"):
        function(ROBOT, q)


def test_one_configuration_has_the_bits_of_a_batch() -> None:
    rows = np.random.default_rng(3).uniform(-2.0, 2.0, (5, 7))
    for task in (None, "position", ["vx", "wz"], TASK):
        whole, sigma = decompose(ROBOT, rows, task), singular_values(ROBOT, rows, task)
        for i, q in enumerate(rows):
            one = decompose(ROBOT, q, task)
            assert all(np.array_equal(getattr(one, part), getattr(whole, part)[i]) for part in ("u", "sigma", "v"))
            assert np.array_equal(singular_values(ROBOT, q, task), sigma[i])
            assert np.array_equal(pose(ROBOT, q), pose(ROBOT, rows)[i])
    for function in (task_jacobian, task_jacobian_derivative):
        assert all(np.array_equal(function(ROBOT, q, TASK), function(ROBOT, rows, TASK)[i]) for i, q in enumerate(rows))
    view = task_view(ROBOT, TASK)
    for refused in (rows, rows[0, :6], rows[0] * np.nan, [*rows[0]], None):
        assert _core.decompose_one(ROBOT, refused, view) is None
    with pytest.raises(TypeError, match="a View"):
        _core.decompose_one(ROBOT, rows[0], "view")


def test_a_robot_that_is_gone_is_forgotten() -> None:
    """Another object at its address is no robot."""
    robot = arms.puma()
    jacobian(robot, np.zeros(6))
    address = id(robot)
    assert _core.jacobian_one(robot, np.zeros(6), None, None) is not None
    assert address in kinematics._handles
    del robot
    gc.collect()
    assert address not in kinematics._handles
    other = arms.puma()
    assert _core.jacobian_one(other, np.zeros(6), None, None) is None, "nothing was asked of this one yet"


def test_another_robot_at_the_address_of_one_that_was_not_forgotten_has_its_own_handles(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The callback that forgets a robot can fail: at the limit of recursion no callback runs."""
    with monkeypatch.context() as patch:
        patch.setattr(kinematics.weakref, "finalize", lambda *_: None)
        gone = [arms.puma() for _ in range(200)]
        for robot in gone:
            jacobian(robot, np.zeros(6))
    addresses = {id(robot) for robot in gone}
    del robot, gone
    gc.collect()
    others = [arms.pa10() for _ in range(400)]
    there = [robot for robot in others if id(robot) in addresses]
    assert there, "no robot was made at the address of another"
    q = np.full(7, 0.3)
    fresh = arms.pa10()
    for robot in there:
        assert _core.jacobian_one(robot, np.zeros(6), None, None) is None
        assert np.array_equal(jacobian(robot, q), jacobian(fresh, q))
        assert np.array_equal(pose(robot, q), pose(fresh, q))
    for address in addresses:
        kinematics._let_go(address)
