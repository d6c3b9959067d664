"""A session looks at once, explains a moment later, moves at 30 steps a second, and can be stopped."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from itertools import count, pairwise
from time import sleep

import numpy as np
import pytest
from patience import until

from rankdrop.results.explanation import Explanation
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.scene import Live, Now
from rankdrop.viewer.session import Session

START = np.array([0.3, 0.6, -0.5, 0.7, 0.8, 0.4])


class Ear:
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.nows: list[Now] = []
        self.found: list[Explanation] = []
        self.errors: list[BaseException] = []
        self.sources: list[object] = []

    def on_look(self, now: Now, source: object) -> None:
        self.nows.append(now)
        self.sources.append(source)

    def on_explanation(self, found: Explanation) -> None:
        self.found.append(found)

    def on_failure(self, error: BaseException) -> None:
        self.errors.append(error)


@pytest.fixture
def session() -> Iterator[tuple[Session, Ear]]:
    arm = open_robot("puma560")
    task = resolve_task(None, arm)
    known = known_analysis(arm, task)
    assert known is not None
    ear = Ear()
    made = Session(Live(arm, task, known.families), ear, START)
    made.start()
    yield made, ear
    made.close()
    assert not {"rankdrop-look", "rankdrop-explain"} & {thread.name for thread in threading.enumerate()}


def test_it_looks_and_explains(session: tuple[Session, Ear]) -> None:
    made, ear = session
    until(lambda: bool(ear.found and ear.nows))
    assert (ear.nows[0].q == START).all()
    made.set_joint(4, 0.0, "me")
    until(lambda: ear.nows[-1].verdict == "singular")
    assert ear.sources[-1] == "me"
    now = ear.nows[-1]
    assert now.family is not None
    assert now.family.name.startswith("wrist")
    assert [one.numbers for one in now.blamed] == [(4, 6)]
    until(lambda: ear.found[-1].verdict == "singular")
    assert ear.errors == []


@pytest.mark.slow
def test_a_motion_arrives_and_is_smooth(session: tuple[Session, Ear]) -> None:
    made, ear = session
    target = START + 0.5
    made.go(target)
    until(lambda: bool((made.q == target).all()))
    until(lambda: bool((ear.nows[-1].q == target).all()))
    steps = np.array([b.q - a.q for a, b in pairwise(ear.nows)])
    assert (steps >= 0).all()  # never back
    assert len(steps) >= 3


def test_a_hand_on_a_slider_ends_a_motion(session: tuple[Session, Ear]) -> None:
    made, _ = session
    made.go(START + 2.0)
    sleep(0.2)
    made.set_joint(0, -1.0)
    held = made.q
    sleep(0.2)
    assert (made.q == held).all()
    assert held[0] == -1.0


def test_a_path_that_fails_is_told_and_ends(session: tuple[Session, Ear]) -> None:
    made, ear = session

    def path() -> Iterator[np.ndarray]:
        yield START
        raise ValueError("no further")

    ended = threading.Event()
    made.follow(path(), done=ended.set)
    assert ended.wait(60.0)
    until(lambda: bool(ear.errors))
    assert str(ear.errors[0]) == "no further"


@pytest.mark.slow
def test_a_moving_arm_is_looked_at_again_and_again_and_explained_now_and_then(
    session: tuple[Session, Ear],
) -> None:
    made, ear = session
    until(lambda: bool(ear.found))
    before, thought = made.looked, made.thought
    made.follow(START + 0.003 * (i % 1000) for i in count())
    until(lambda: made.looked - before >= 25 and made.thought - thought >= 1)
    made.stop()
