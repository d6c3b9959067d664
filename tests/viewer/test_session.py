"""A session looks at once, explains a moment later, moves at 30 steps a second, and can be stopped."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from html import escape
from itertools import count, pairwise
from time import sleep

import numpy as np
import pytest
from patience import until

from rankdrop.families import FamilyName
from rankdrop.results.explanation import Explanation
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.panel import bar_share, details_html, legend_html, status_html
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


def test_every_word_from_a_file_is_escaped() -> None:
    from dataclasses import replace

    arm = open_robot("puma560")
    task = resolve_task(None, arm)
    known = known_analysis(arm, task)
    assert known is not None
    families = tuple(replace(one, called=FamilyName(given="<script>x</script>")) for one in known.families)
    now = Live(arm, task, families).look(np.array(families[0].witness))
    text = status_html(now, arm.n, 6, {one.id: one.name for one in families})
    assert "<script>" not in text
    assert "&lt;script&gt;" in text
    assert "■ singular" in text


@pytest.mark.parametrize(
    ("arm", "q"),
    [("ur5e", [0, -60, 0, 40, 50, 0]), ("ur5e", [0, -60, 1, 40, 50, 0]), ("pa10", [0] * 7), ("gen3", [0] * 7),
     ("panda", [0, 17, 0, -103, 0, 109, 40])],
)  # fmt: skip
def test_no_sentence_beside_the_arm_is_longer_than_can_be_read(arm: str, q: list[float]) -> None:
    from rankdrop.verbs.explain import explain

    found = explain(open_robot(arm), np.radians(q), evaluations=0)
    lines = re.split(r"<br>|</div>|(?<=[.;:]) ", details_html(found) + legend_html())
    for line in lines:
        text = re.sub(r"<[^>]+>", "", line)
        assert len(re.findall(r"[^\W\d_]{2,}", text)) <= 25 or " = 0" in text, text  # conditions are no sentences


def test_the_panel_says_lost_motions_and_joints_to_blame() -> None:
    from rankdrop.text import lost_text
    from rankdrop.verbs.explain import explain

    found = explain(open_robot("puma560"), [0.3, 0.5, 0.4, 0.2, 0.0, 0.6], evaluations=0)
    text = details_html(found)
    assert "joints 4, 6" in text
    assert len(found.lost.seen) >= 2
    for place, framed in enumerate(found.lost.seen.values()):  # base and tool; a link would be too much
        seen = lost_text(found.robot, framed)
        assert (escape(seen["constraints"][0]) in text and escape(seen["axes"]) in text) == (place < 2)


@pytest.mark.parametrize("q", [(0.3, 0.5, 0.4, 0.2, 0.0, 0.6), (0.3, 0.5, 0.4, 0.2, 0.9, 0.6), (0.0,) * 6])
def test_the_panel_says_family_and_distance_once(q: tuple[float, ...]) -> None:
    from rankdrop.verbs.explain import explain

    arm = open_robot("puma560")
    task = resolve_task(None, arm)
    known = known_analysis(arm, task)
    assert known is not None
    now = Live(arm, task, known.families).look(np.array(q))
    found = explain(arm, q, evaluations=0)
    above, below = status_html(now, arm.n, 6, {one.id: one.name for one in known.families}, found), details_html(found)
    told = found.met or (found.far.nearest_family,)
    names = [escape(one.family.called.short) for one in told if one is not None]
    assert names
    assert all(name in below and name not in above for name in names)
    assert below.count("Verified:") == 1
    assert ("Next:" in below) or found.met


@pytest.mark.parametrize(("sigma", "share"), [(0.0, 0.0), (1e-3, 5e-4), (1.0, 0.5), (2.0, 1.0)])
def test_bars_are_linear(sigma: float, share: float) -> None:
    assert bar_share(sigma, 2.0) == pytest.approx(share)
    assert bar_share(sigma, 0.0) == 0.0
