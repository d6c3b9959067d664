"""What the panel says of a configuration."""

from __future__ import annotations

import re
from html import escape

import numpy as np
import pytest

from rankdrop.families import FamilyName
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.panel import bar_share, details_html, legend_html, status_html
from rankdrop.viewer.scene import Live


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
