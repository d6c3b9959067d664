"""What a notebook shows: an arm to be turned, a robot, a family, conditions typeset."""

from __future__ import annotations

import html
import json
import re

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError
from rankdrop.report.page import arm_view
from rankdrop.results.known import shipped
from rankdrop.results.stored_conditions import known_conditions
from rankdrop.robot.quantities import degrees_text
from rankdrop.text.lost import lost_sentences


def data_of(shown: str) -> dict[str, object]:
    page = html.unescape(re.search(r'srcdoc="([^"]*)"', shown)[1])
    found = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])
    assert "default-src 'none'" in page
    return found


def test_an_arm_at_a_family_shows_what_is_lost() -> None:
    found = shipped("puma560")
    for family in found.families:
        data = data_of(arm_view(found.robot, family)._repr_html_())
        assert data["q"] == list(family.witness)
        assert len(data["arrows"]) == family.corank
        assert data["blamed"]


def test_an_arm_by_itself_stands_well_and_regular() -> None:
    data = data_of(arm_view(shipped("ur5").robot)._repr_html_())
    assert data["arrows"] == []
    assert len(data["q"]) == 6


@pytest.mark.parametrize("at", [[0.0] * 5, [np.nan] * 6])
def test_a_wrong_configuration_is_refused(at: list[float]) -> None:
    with pytest.raises(ConfigurationError):
        arm_view(shipped("ur5").robot, at)


def test_a_robot_shows_its_joints_in_degrees() -> None:
    shown = shipped("stanford").robot._repr_html_()
    robot = shipped("stanford").robot
    assert all(f"<td>{joint.name}</td>" in shown for joint in robot.variables)
    assert f"{np.degrees(robot.variables[0].upper):.4g}°" in shown
    assert f"{robot.variables[2].upper:.4g} m" in shown


def test_a_family_shows_its_conditions_and_tests() -> None:
    family = shipped("ur5").families[0]
    shown = family._repr_html_()
    lost = lost_sentences(family.lost_freedoms)[0]
    for part in (family.name, "coupled, see below", lost, f"of {family.soundness.tested:,} points"):
        assert part in shown


def test_a_family_shows_where_joints_stand_in_degrees_and_slides_in_metres() -> None:
    elbow = next(family for family in shipped("panda").families if family.name.startswith("elbow"))
    assert "−26.757° or 153.24°" in elbow._repr_html_()
    slide = next(family for family in shipped("stanford").families if [one.number for one in family.pinned] == [3])
    assert "<td>0 m</td>" in slide._repr_html_()


def test_a_family_lists_its_joints_in_their_order() -> None:
    text = shipped("ur5e").families[0]._repr_html_()
    places = [text.index(f"joint {number}") for number in range(1, 7)]
    assert places == sorted(places)


@pytest.mark.shipped
def test_conditions_are_typeset_in_a_notebook() -> None:
    found = shipped("puma560")
    conditions = known_conditions(found.robot, found.task)
    shown = conditions._repr_html_()
    assert shown.count("<math>") >= sum(len(family.latex) for family in conditions.families)
    assert conditions.verdict.sentence in html.unescape(shown)
    for family in conditions.families:  # once, typeset: not in words as well
        assert shown.count(f"<td>{family.id}</td>") == shown.count(family.id) == 1


@pytest.mark.shipped
def test_a_loss_told_at_the_witness_has_the_witness_in_notebooks() -> None:
    found = shipped("puma560")
    exactly = known_conditions(found.robot, found.task)
    assert exactly is not None
    for one in (found, exactly):
        told = [family for family in one.families if not all(lost.everywhere for lost in family.lost_freedoms)]
        view = one._repr_html_()
        assert told
        assert all(degrees_text(family.witness, found.robot.units) in view for family in told)
        assert view.count("witness") == view.count("(at the witness)") + len(told)
