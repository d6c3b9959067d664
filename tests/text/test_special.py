"""The parts of an arm in words: shoulder, elbow, wrist."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from rankdrop.families import FamilyName
from rankdrop.families.points import members
from rankdrop.local.block import singular_values
from rankdrop.local.special import specials_at
from rankdrop.results.known import shipped
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Array
from rankdrop.task import resolve_task
from rankdrop.text.special import family_label, family_title, place_name, place_words


def test_a_label_names_the_parts_and_a_title_the_axes_too() -> None:
    found = shipped("crx10ial")
    robot, task, family = found.robot, found.task, found.families[0]
    assert family_label(robot, task, family) == "shoulder, elbow or wrist"
    assert family_title(robot, task, family) == "shoulder, elbow or wrist: joints 1–6 dependent"
    own = replace(family, called=FamilyName(given="my own family"))
    assert family_label(robot, task, own) == family_title(robot, task, own) == "my own family"


@pytest.mark.parametrize("name", ["crx10ial", "yumi", "ur5e", "xarm6"])
def test_a_picture_is_called_by_the_part_of_the_arm(name: str) -> None:
    found = shipped(name)
    for family in found.families:
        title = place_name(found.robot, found.task, family)
        assert title.split(":")[0].split()[0].strip(",") in {"shoulder", "elbow", "wrist"}
        assert "screws" not in title


def test_parts_agree_with_the_conditions_of_the_families() -> None:
    """What the geometry says is what the families of an arm of ideal geometry are named after."""
    for name in ("puma560", "ur5e", "panda", "pa10"):
        found = shipped(name)
        for family in found.families[:3]:
            head = set(re.findall(r"shoulder|elbow|wrist(?! centre)", family.name))
            if "axes 3 and 5 aligned" in family.name:  # about joint 4 of the Panda, the elbow
                head = {"elbow"}
            q: Array = members(found.robot, found.task, family, 8, seed=2)[0]
            here = {one.part.value for one in specials_at(found.robot, found.task, q, family.corank)}
            assert head <= here, (name, family.name, here)


@pytest.mark.parametrize(("q", "corank", "words"), [
    ([-0.5, 0.4, 0.0], 1, "elbow: arm stretched"),
    ([-0.5, -0.6, 1.2], 1, "shoulder: tip above axis 1"),
    ([-0.5, 0.0, 0.0], 2, "shoulder and elbow: tip above axis 1, arm stretched"),
    ([-0.5, 0.3, np.pi], 2, "shoulder and elbow: tip on axis 2, arm folded"),
])  # fmt: skip
def test_the_parts_of_three_joints_that_place_a_tip(q: list[float], corank: int, words: str) -> None:
    """The lengths of the arm of ikpy issue 164."""
    arm = from_dh([(0, -np.pi / 2, 0.1138, 0), (0.12, 0, 0, -np.pi / 2), (0.12, 0, 0, 0)], convention="standard")
    sigma = singular_values(arm, np.array(q), resolve_task("position", arm))
    assert int((sigma <= 1e-9).sum()) == corank
    assert place_words(arm, resolve_task("position", arm), np.array(q), corank) == words


def test_a_pan_tilt_has_a_shoulder_and_no_elbow() -> None:
    """Its tip is on axis 1: nothing that the pan does moves it."""
    arm = from_dh([(0, np.pi / 2, 0.2, 0), (0.3, 0, 0, 0)], convention="standard")
    task, q = resolve_task("position", arm), np.array([0.4, np.pi / 2])
    assert singular_values(arm, q, task)[1] < 1e-12
    assert place_words(arm, task, q, 1) == "shoulder: tip above axis 1"
