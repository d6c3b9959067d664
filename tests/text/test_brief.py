"""Families in one line, as comparisons show them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import rankdrop
from rankdrop.designs import compare
from rankdrop.designs.measure import _family, measure_arm
from rankdrop.results.known import shipped
from rankdrop.task import resolve_task
from rankdrop.text.brief import compared_arms
from rankdrop.text.designs import error_text
from rankdrop.text.special import place_name
from rankdrop.text.stretches import stretch_place


def test_a_comparison_and_a_path_name_the_parts_of_an_arm_with_offsets() -> None:
    """A CRX has one long condition: its stored name is "joints 1–6 dependent"."""
    found = shipped("crx10ial")
    family = found.families[0]
    record = {"error": "", "families": [_family(one, found.robot, found.task) for one in found.families]}
    (line,) = compared_arms(["crx"], [record]).lines
    assert line.startswith("crx: shoulder, elbow or wrist (corank 1)")
    q = np.array(family.witness)
    check = SimpleNamespace(robot=found.robot, task=found.task)
    closest = SimpleNamespace(q=q + 0.3, foot=q)
    stretch = SimpleNamespace(corank=0, closest=closest, name=family.name)
    assert stretch_place(check, stretch) == place_name(found.robot, found.task, family)
    assert stretch_place(check, stretch).startswith(("shoulder", "elbow", "wrist"))
    closest.foot = np.zeros(0)
    assert stretch_place(check, stretch) == family.name


@pytest.mark.by_hand
def test_arms_of_the_catalogue_have_its_families_and_shares_that_samples_cannot_part_are_equal() -> None:
    asks = {"families": {"starts": 50, "fresh": 50}, "near": {"within": 0.1, "samples": 400}}
    found = compare(["ur5e", "gp7"], asks, workers=1)
    assert found.records[0]["measures"]["families"] == len(shipped("ur5e").families)
    assert found.records[1]["sentence"] == shipped("gp7").verdict.sentence
    shares = [one["measures"]["near"] for one in found.records]
    assert 0.0 < abs(shares[0] - shares[1]) < 0.02  # of 400 samples
    assert found.best("near") == (0, 1)
    assert found.sentence == "ur5e and gp7 do not differ within the error, for task pose."


def test_the_note_of_an_arm_without_rate_limits_says_what_is_missing() -> None:
    others = ("families", "aspects", "near", "region", "paths", "certified")
    asks = {"slow": {"speed": 0.25, "turn_speed": 0.0, "samples": 100}} | dict.fromkeys(others)
    arms = [rankdrop.open_robot(name) for name in ("planar3r", "irb120")]
    records = [measure_arm(arm, resolve_task(None, arm), asks, None, limits=False, seed=0) for arm in arms]
    assert [one["measures"]["slow"] is None for one in records] == [True, False]
    assert "–: too few joints have a rate limit, state `velocity`" in error_text(records, "slow")
    assert "rate limit" not in error_text(records[1:], "slow")
