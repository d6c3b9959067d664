"""One singular value brought down where it may tie with the smaller ones: what `minimax` is told of it.

The values are σ[rank] and all smaller ones, the tensor is that of their singular vectors (AM eqs 7 and 12), so that a
crease is told from a local minimum: on a crease some mixture of gradients leads down, at a minimum none does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rankdrop.local.block import joint_scale, limit_box
from rankdrop.local.minimax import EFFORT, Evaluate, Lowest, Model, descend, promised
from rankdrop.local.tie_gradients import gradient_tensor
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

FLAT = 1e-8
"""Fall of σ that a step of about the length of its slope has to promise, for a place to be no local minimum [1]. A line
search that ends for want of a fall of 1e-12 leaves promises of about that size at smooth minima."""


def tied_model(robot: Robot, task: Task, rank: int) -> Evaluate:
    """σ[rank], σ[rank + 1], … as one block, per scaled joint motion q / `joint_scale`."""
    scale = joint_scale(robot, task)

    def evaluate(scaled: Array) -> Model:
        sigma, tensor = gradient_tensor(robot, scaled * scale, task, rank)
        both = (tensor + tensor.swapaxes(1, 2)) / 2 * scale
        return sigma[:, None, rank:], both[:, None]

    return evaluate


def stays_up(robot: Robot, task: Task, rank: int, q: Array, *, limits: bool) -> NDArray[np.bool_]:
    """(B,) whether no mixture of gradients leads down from (B, n) configurations: local minima, to first order."""
    if not len(q):
        return np.zeros(0, dtype=np.bool_)
    scale = joint_scale(robot, task)
    box = _box(robot, task, limits)
    values, tensor = tied_model(robot, task, rank)(q / scale)
    if box is not None:  # joints at a limit that σ pushes outward do not count
        gradient = np.einsum("baan->bn", tensor[:, 0][:, :1, :1])
        at = ((q / scale <= box[0]) & (gradient > 0.0)) | ((q / scale >= box[1]) & (gradient < 0.0))
        tensor = np.where(at[:, None, None, None, :], 0.0, tensor)
    return np.asarray(promised(values, tensor, np.ones(len(q))).most <= FLAT)


def brought_down(
    robot: Robot, task: Task, rank: int, q: Array, *, limits: bool, iterations: int = 200, effort: int = EFFORT
) -> Lowest:
    """σ[rank] descended from (B, n) configurations to where it is least nearby; `q` of the result in rad and m."""
    scale, box = joint_scale(robot, task), _box(robot, task, limits)
    found = descend(tied_model(robot, task, rank), q / scale, box, iterations=iterations, effort=effort)
    return Lowest(found.q * scale, found.value, found.slope, found.iterations)


def _box(robot: Robot, task: Task, limits: bool) -> tuple[Array, Array] | None:
    if not limits:
        return None
    low, high = limit_box(robot, task)
    scale = joint_scale(robot, task)
    return low / scale, high / scale
