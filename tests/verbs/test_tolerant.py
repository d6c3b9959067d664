"""The most fault-tolerant configurations: known answers, limits, seeds, and what is said where there is none."""

from __future__ import annotations

import json

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from rankdrop.codec import json_text, record_of
from rankdrop.distance import tolerant
from rankdrop.errors import OptionError
from rankdrop.local.block import sample
from rankdrop.local.failures import worst_case
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.sections import text
from rankdrop.task import resolve_task
from rankdrop.text.words import tolerant_sections
from rankdrop.verbs.tolerant import most_tolerant


@pytest.fixture(scope="module")
def regional():
    robot = open_robot("almarkhi4")
    return robot, resolve_task("position", robot, length_scale=1.0)


@pytest.mark.slow
def test_the_optimum_that_am_s_4r_arm_was_made_for_is_found(regional):
    robot, task = regional
    found = most_tolerant(robot, task, relative=True, starts=60)
    best = found.places[0]
    assert best.value == pytest.approx(0.5, abs=1e-9)
    assert found.bound == 0.5
    assert found.optimal
    assert found.free == (1,)
    gap = best.q[1:] - [np.pi, np.pi, np.pi - np.arctan(1 / np.sqrt(2))]
    assert gap == pytest.approx([0.0] * 3, abs=1e-6)
    assert best.failures.bound == pytest.approx(0.5, abs=1e-6)
    assert "reaches it, none is better" in text(tolerant_sections(found))


def test_the_largest_sigma_left_is_larger_elsewhere(regional):
    robot, task = regional
    found = most_tolerant(robot, task, starts=60)
    assert found.places[0].value == pytest.approx(0.7718711, abs=1e-6)
    assert found.places[0].failures.worst_numbers == (1, 2, 3, 4)
    assert worst_case(robot, sample(robot, task, 20_000, 3), task).max() < found.places[0].value
    values = [place.value for place in found.places]
    assert values == sorted(values, reverse=True)
    assert "a better one may have been missed" in text(tolerant_sections(found))


@pytest.mark.slow
def test_within_limits_it_stays_inside_and_no_sample_is_better():
    robot = open_robot("panda")
    found = most_tolerant(robot, limits=True, starts=60, show=2)
    for place in found.places:
        assert (place.q >= robot.lower).all()
        assert (place.q <= robot.upper).all()
        assert place.value == pytest.approx(float(worst_case(robot, place.q, found.task)), abs=1e-9)
    assert worst_case(robot, sample(robot, found.task, 3000, 1, limits=True), found.task).max() < found.places[0].value
    assert found.free == (1, 7)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_places(regional):
    robot, task = regional
    one, other = (most_tolerant(robot, task, starts=55, seed=4) for _ in range(2))
    assert all(np.array_equal(a.q, b.q) for a, b in zip(one.places, other.places, strict=True))
    third = most_tolerant(robot, task, starts=55, seed=5)
    assert third.places[0].value == pytest.approx(one.places[0].value, abs=1e-6)


def test_the_record_is_valid_and_every_entry_is_described(regional):
    robot, task = regional
    for found in (most_tolerant(robot, task, starts=20), most_tolerant(open_robot("pa10"))):
        record = json.loads(json_text(record_of("tolerant", found)))
        Draft202012Validator(load_schema("tolerant")).validate(record)
        assert set(record) | {"self_motion"} == set(load_schema("tolerant")["properties"])
        assert not Draft202012Validator(load_schema("tolerant")).is_valid(record | {"places": [{}]})


def test_ctrl_c_keeps_what_was_climbed(regional, monkeypatch):
    robot, task = regional
    monkeypatch.setattr(tolerant, "_PART", 10)

    def stop(done: int, total: int) -> None:
        if done >= 20:
            raise KeyboardInterrupt

    found = most_tolerant(robot, task, starts=60, progress=stop)
    assert (found.done, found.complete) == (20, False)
    assert found.places


@pytest.mark.parametrize("wrong", [{"starts": 0}, {"seed": -1}, {"show": 0}])
def test_what_is_outside_is_refused(regional, wrong):
    with pytest.raises(OptionError):
        most_tolerant(*regional, **wrong)
