"""The answer in five lines: over every arm of the catalogue, at singular, near and regular configurations."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator

import numpy as np
import pytest
from rich.console import Console

from known.arms import STRUCTURES
from rankdrop.cli import terminal
from rankdrop.local.block import sample
from rankdrop.results.explanation import Explanation
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import resolve_task
from rankdrop.text.words import joint_word
from rankdrop.verbs.explain import explain

CONFIGURATIONS = 4  # of each arm: twice regular or near, twice singular; 40 by hand


def printed(found: Explanation) -> list[str]:
    """The lines at 80 columns."""
    out = io.StringIO()
    console = Console(file=out, width=80)
    for number, section in enumerate(found.sections()):
        console.print(*([""] if number else []), *terminal.section_parts(section, 80), sep="\n")
    return out.getvalue().rstrip("\n").split("\n")


def explained(name: str, count: int) -> Iterator[Explanation]:
    arm = open_robot(name)
    task = resolve_task(None, arm)
    for q in sample(arm, task, count // 2, seed=7):
        found = explain(arm, q, evaluations=0)
        yield found
        if found.far.nearest is not None:
            yield explain(arm, found.far.nearest.q, evaluations=0)


FEW = robot_names()[::20]


@pytest.mark.spread(24)
@pytest.mark.by_hand_at(*(set(robot_names()) - {*STRUCTURES, *FEW}))
@pytest.mark.slow
@pytest.mark.parametrize("name", robot_names())
def test_the_answer_is_in_the_first_lines_and_the_whole_on_one_screen(name: str) -> None:
    for found in explained(name, CONFIGURATIONS):
        lines, summary = printed(found), found.summary
        first = " ".join(line.strip() for line in lines[:6])
        assert found.robot.name in first
        never = 4 if found.robot.n < found.task.m else 0  # what it can do nowhere
        assert len(lines) <= 40 + never, "\n".join(lines)
        if summary.cause == "lost":
            assert any(part in first for part in ("shoulder", "elbow", "wrist", "tip", "rail")), first
            assert "Lost: " in first
        if summary.way_out:
            number, _ = summary.way_out[0]
            assert f"{joint_word(number, found.robot.variables[number - 1].name)} by" in first
        else:
            assert re.search("no (small )?jog", first) or summary.verdict == "always-singular"
        if summary.next_distance is not None:
            assert f"{np.degrees(summary.next_distance):.3g}° of joint" in first
        assert not any(len(line) > 80 for line in lines)
