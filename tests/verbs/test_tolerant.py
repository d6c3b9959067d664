"""The most fault-tolerant configurations: known answers, limits, seeds, and what is said where there is none."""

from __future__ import annotations

import json

import pytest
from jsonschema import Draft202012Validator

from rankdrop.codec import json_text, record_of
from rankdrop.distance import tolerant
from rankdrop.errors import OptionError
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.verbs.tolerant import most_tolerant


@pytest.fixture(scope="module")
def regional():
    robot = open_robot("almarkhi4")
    return robot, resolve_task("position", robot, length_scale=1.0)


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
