"""What is lost: directions, the frame in which they are read, screws, and what the arm never makes."""

from __future__ import annotations

import numpy as np

from rankdrop.local.block import decompose
from rankdrop.local.directions import lost_directions, lost_in_sparsest_frame
from rankdrop.local.readable import readable_basis
from rankdrop.local.screws import screw_of
from rankdrop.local.sentences import blocked_words, words
from rankdrop.local.verdict import Rank
from rankdrop.results.explanation.data import Asked, Lost
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.units import counted, counted_length


def lost_of(asked: Asked, focus: Array, corank: int) -> Lost:
    """What is lost at the focus (`corank` directions; none where it is 0), and what is weakest at q."""
    robot, q, task, rank = asked.robot, asked.q, asked.task, asked.rank
    never = _never(robot, q, task, rank)
    empty = np.zeros((0, 6))
    weakest = lost_directions(robot, q, task, 1)[0] if rank.generic_rank else np.zeros(6)
    if not corank:
        return Lost(empty, weakest, (), (), None, (), (), never)
    length = counted_length(robot)
    framed = lost_in_sparsest_frame(robot, focus, task, corank)
    return Lost(
        directions=lost_directions(robot, focus, task, corank),
        weakest=weakest,
        words=tuple(words(one, framed.name, length) for one in framed.directions),
        blocked_words=tuple(blocked_words(one, framed.name, length) for one in framed.directions),
        framed=framed,
        twist_screws=tuple(screw_of(one).in_lengths(length) for one in framed.directions),
        wrench_screws=tuple(screw_of(np.roll(one, 3)).in_lengths(length) for one in framed.directions),
        never=never,
    )


def _never(robot: Robot, q: Array, task: Task, rank: Rank) -> Array:
    """Readable basis of what is beyond the generic rank: the arm makes it nowhere near q."""
    beyond = task.m - rank.generic_rank
    if beyond == 0:
        return np.zeros((0, 6))
    away = q + np.random.default_rng(0).uniform(-1e-3, 1e-3, robot.n) if rank.corank else q
    rows = np.zeros((beyond, 6))
    rows[:, list(task.rows)] = decompose(robot, away, task).u[:, rank.generic_rank :].T
    rows[:, :3] *= counted(robot) / task.scale(robot)
    return readable_basis(rows.T).T
