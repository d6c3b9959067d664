"""The state of a viewer: one configuration, what is known of it at once and a moment later, and motions that change it.

Three threads: one looks at the newest configuration (0.3 ms, so that nothing waits), one explains it once it stands
still for a moment or has not been explained for a while (some 50 ms), one moves it along a motion, 30 times a second.
Whoever listens is told from these threads, never from two of the same kind at once.
"""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterable, Iterator
from time import monotonic
from typing import Protocol

import numpy as np

from rankdrop import explain
from rankdrop.local import joint_scale
from rankdrop.results import Analysis, Explanation
from rankdrop.robot import Array
from rankdrop.tolerances import EVALUATIONS
from rankdrop.viewer.scene import Live, Now

FRAMES = 30.0  # of a motion, per second
FASTEST = 60.0  # configurations that are looked at, per second: no screen shows more
STILL = 0.12  # a configuration that has stood so long is explained [s]
OVERDUE = 0.4  # while it moves, it is explained this often [s]
_RATE = 1.2  # of a motion to a target [rad/s]
_LEAST, _MOST = 0.4, 3.0  # how long it takes [s]


class Listener(Protocol):
    """Whoever shows the state."""

    def on_look(self, now: Now, source: object) -> None:
        """A configuration was looked at; `source` is whoever set it."""

    def on_explanation(self, explanation: Explanation) -> None:
        """A configuration was explained."""

    def on_failure(self, error: BaseException) -> None:
        """Looking or explaining failed."""


class Session:
    """The configuration of one arm, and threads that watch it.

    Args:
        live: the arm under watch.
        listener: is told of everything.
        analysis: families for the explanations; None for those known, or found on the spot.
        limits: the nearest singularity within the joint limits.
        q: (n,) to begin with [rad, m].
    """

    def __init__(self, live: Live, listener: Listener, q: Array, *, analysis: Analysis | None = None,
                 limits: bool = False, frame: str | None = None) -> None:  # fmt: skip
        self.frame = frame
        self.live, self.listener, self.analysis, self.limits = live, listener, analysis, limits
        self.looked = self.thought = 0  # how many times
        self._changed = threading.Condition()
        self._q = np.array(q, dtype=np.float64)
        self._source: object = None
        self._version = 1
        self._moved = monotonic()
        self._motion = 0  # number of the motion under way
        self._mover: threading.Thread | None = None
        self._open = True
        self._threads = [threading.Thread(target=work, daemon=True, name=f"rankdrop-{name}")
                         for name, work in (("look", self._looking), ("explain", self._thinking))]  # fmt: skip

    def start(self) -> None:
        """Begin to watch."""
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """End all threads; what is being explained is finished first."""
        with self._changed:
            self._open = False
            self._motion += 1
            self._changed.notify_all()
        for thread in self._threads:
            if thread.is_alive() and thread is not threading.current_thread():
                thread.join(timeout=5.0)

    @property
    def q(self) -> Array:
        """(n,) where the arm is, a copy [rad, m]."""
        with self._changed:
            return self._q.copy()

    def set_joint(self, index: int, value: float, source: object = None) -> None:
        """One joint (from 0) by hand: ends a motion."""
        with self._changed:
            self._motion += 1
            q = self._q.copy()
            q[index] = value
            self._set_joints(q, source)

    def set(self, q: Array, source: object = None) -> None:
        """All joints at once: ends a motion."""
        with self._changed:
            self._motion += 1
            self._set_joints(np.array(q, dtype=np.float64), source)

    def stop(self) -> None:
        """End the motion under way, if there is one."""
        with self._changed:
            self._motion += 1

    def go(self, target: Array, source: object = None) -> None:
        """Move to a configuration, slowly at both ends; joints move together."""
        start, end = self.q, np.array(target, dtype=np.float64)
        size = float(np.linalg.norm((end - start) / joint_scale(self.live.robot, self.live.task)))
        self.follow(_ease(start, end, min(max(size / _RATE, _LEAST), _MOST)), source)

    def follow(self, path: Iterable[Array], source: object = None, done: Callable[[], None] | None = None) -> None:
        """Follow configurations, 30 a second, until they end or something else moves the arm.

        Args:
            path: of (n,) [rad, m]; asked for the next one when it is due.
            source: who moves.
            done: is called in the end, also of a motion that was ended.
        """
        with self._changed:
            self._motion += 1
            self._mover = threading.Thread(target=self._moving, args=(self._motion, iter(path), source, done),
                                           daemon=True, name="rankdrop-move")  # fmt: skip
            self._mover.start()

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        return self._mover is not None and self._mover.is_alive()

    def _set_joints(self, q: Array, source: object) -> None:
        self._q, self._source = q, source
        self._version += 1
        self._moved = monotonic()
        self._changed.notify_all()

    def _moving(self, mine: int, path: Iterator[Array], source: object, done: Callable[[], None] | None) -> None:
        begun, frame = monotonic(), 0
        try:
            for q in path:
                with self._changed:
                    if self._motion != mine:
                        break
                    self._set_joints(np.array(q, dtype=np.float64), source)
                    frame += 1
                    self._changed.wait_for(lambda: self._motion != mine, begun + frame / FRAMES - monotonic())
        except Exception as error:
            self._report(error)
        finally:
            if done is not None:
                done()

    def _looking(self) -> None:
        seen = 0
        while True:
            with self._changed:
                if not self._newer_than(seen):
                    return
                seen, q, source = self._version, self._q, self._source
            begun = monotonic()
            try:
                self.listener.on_look(self.live.look(q), source)
            except Exception as error:
                self._report(error)
            self.looked += 1
            with self._changed:
                self._changed.wait_for(lambda: not self._open, max(0.0, begun + 1 / FASTEST - monotonic()))

    def _newer_than(self, version: int) -> bool:
        """Wait, the lock being held, until the configuration has changed; False where all is to end."""
        self._changed.wait_for(lambda: self._version != version or not self._open)
        return self._open

    def _thinking(self) -> None:
        known, last = 0, 0.0
        while True:
            with self._changed:
                self._newer_than(known)
                while self._open:
                    left = min(self._moved + STILL, max(last + OVERDUE, self._moved)) - monotonic()
                    if left <= 0:
                        break
                    self._changed.wait(left)
                if not self._open:
                    return
                known, q = self._version, self._q
            try:
                explanation = explain(self.live.robot, q, self.live.task, analysis=self.analysis, limits=self.limits,
                                evaluations=EVALUATIONS, frame=self.frame)  # fmt: skip
                with self._changed:
                    if not self._open:
                        return
                self.listener.on_explanation(explanation)
            except Exception as error:
                self._report(error)
            self.thought += 1
            last = monotonic()

    def _report(self, error: Exception) -> None:
        if not self._open:
            return
        try:
            self.listener.on_failure(error)
        except Exception:  # the page has gone, or cannot show it: the terminal still can
            traceback.print_exception(error)


def _ease(start: Array, end: Array, seconds: float) -> Iterator[Array]:
    """start … end in 30 steps a second, smooth: 3s² − 2s³."""
    count = max(2, round(seconds * FRAMES))
    for i in range(1, count + 1):
        s = i / count
        yield start + (end - start) * (s * s * (3 - 2 * s)) if i < count else end
