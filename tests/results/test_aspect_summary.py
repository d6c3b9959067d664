"""The stored numbers of aspects are those that are counted, and are found by geometry."""

from __future__ import annotations

from dataclasses import asdict

import pytest
from jsonschema import Draft202012Validator
from scripts import tool

from rankdrop import sweep
from rankdrop.designs import compare
from rankdrop.results.analysis import Analysis
from rankdrop.results.aspect_summary import CUSPIDAL, NOT_ASKED, NOT_CUSPIDAL, NOT_FOUND, AspectSummary
from rankdrop.results.known import catalogue_aspects, known_analysis, known_aspects
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.verbs.analyze import analyze

TOOL = tool("make_aspects")


def test_the_table_has_every_arm_and_is_written_by_the_tool() -> None:
    assert tuple(sorted(catalogue_aspects())) == tuple(sorted(robot_names()))
    table = {name: asdict(one) for name, one in catalogue_aspects().items()}
    assert TOOL.read_table() == table


@pytest.mark.slow
def test_the_tool_makes_the_entry_that_is_stored() -> None:
    assert TOOL.summary_of("puma560") == catalogue_aspects()["puma560"]


@pytest.mark.by_hand
def test_arms_with_as_many_joints_as_rows_have_a_verdict_and_others_none() -> None:
    for name, one in catalogue_aspects().items():
        arm = open_robot(name)
        square = arm.n == resolve_task(None, arm).m
        assert (one.posture_change == NOT_ASKED) == (not square), name
        assert one.posture_change in (CUSPIDAL, NOT_CUSPIDAL, NOT_FOUND, NOT_ASKED), name


def test_aspects_are_known_of_the_arm_and_its_task_only() -> None:
    arm = open_robot("ur5e")
    found = known_aspects(arm, resolve_task(None, arm))
    assert found == AspectSummary(8, 8, True, NOT_CUSPIDAL)
    assert known_aspects(arm, resolve_task("position", arm)) is None
    moved = known_analysis(arm, resolve_task(None, arm))
    assert moved is not None
    assert moved.aspects == found


def test_an_analysis_has_the_aspects_of_its_arm_and_keeps_them_in_its_file() -> None:
    found = analyze(open_robot("planar2r"), starts=50, fresh=False)
    assert found.aspects == catalogue_aspects()["planar2r"]
    assert found.to_dict()["aspects"]["at_least"] == 2
    assert Analysis.from_dict(found.to_dict()).aspects == found.aspects


def test_aspects_of_another_arm_are_counted_where_asked_for() -> None:
    links = [{"d": 0.0, "a": a, "alpha": 0.0} for a in (1.0, 0.37)]
    own = from_dh(links, convention="standard", task="planar-position", name="own")
    assert analyze(own, starts=50).aspects is None
    assert analyze(own, starts=50, aspects=True).aspects == AspectSummary(2, 2, True, NOT_CUSPIDAL)


@pytest.mark.slow
def test_a_sweep_and_a_comparison_have_a_column_of_aspects() -> None:
    found = compare(["planar3r", "planar2r"], {"aspects": {}, "task": "planar-position"}, workers=1)
    assert [one["measures"]["aspects"] for one in found.records] == [1, 2]
    changes = [one["aspects"]["posture_change"] for one in found.records]
    assert changes == [NOT_ASKED, NOT_CUSPIDAL]  # the first is judged, the second stored
    table = next(one for one in found.sections() if one.title == "Side by side")
    assert ("aspects", "1", "2") in table.rows
    Draft202012Validator(load_schema("side-by-side")).validate(found.to_dict())


@pytest.mark.slow
def test_a_count_changes_where_a_family_vanishes() -> None:
    """The shoulder a1 + a2 c2 + d4 c23 = 0 of the elbow arm is real while |a1| ≤ a2 + d4 = 0.9 m."""
    plan = {"robot": "anthropomorphic", "aspects": {},
            "parameters": {"shift": {"sets": "1.a", "values": [0.6, 1.2]}}}  # fmt: skip
    found = sweep(plan, workers=1)
    assert found.values("aspects") == [8, 4]
    assert found.spec.goals == {}
    assert found.holds
    Draft202012Validator(load_schema("sweep")).validate(found.to_dict())
