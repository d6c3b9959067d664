"""Signs and enclosures along a path."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.families import soundness as module
from rankdrop.families.record import Check
from rankdrop.path.check.check import check_path
from rankdrop.path.check.survey import crossings, signs_at
from rankdrop.path.curve import curve
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT


@pytest.mark.shipped
def test_a_condition_fitted_on_the_spot_that_fails_its_test_proves_no_crossing(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = open_robot("pa10")
    task = resolve_task(None, robot)
    elbow = [np.array([0.3, 0.4, 0.2, 0.0, 0.5, 0.7, 0.1])]
    tested = signs_at(robot, task, elbow, DEFAULT)
    assert len(tested) == 1
    sound, whole = module.soundness, []

    def failing(*arguments: object, **options: object) -> object:
        check, rest = sound(*arguments, **options)
        whole.append(check)
        return Check(400, 399), rest

    monkeypatch.setattr(module, "soundness", failing)
    assert signs_at(robot, task, elbow, DEFAULT) == {}
    assert whole[0].holds


@pytest.mark.shipped
@pytest.mark.slow
def test_what_is_left_of_an_unfinished_sliver_is_undecided_and_no_part_of_its_crossing() -> None:
    robot = open_robot("puma560")
    task = resolve_task(None, robot)
    path = curve(np.array([[0.1, -1.2, 1.0, 0.5, -0.4, 0.2], [0.5, -1.0, 1.3, 0.2, 0.5, 0.1]]), None)
    parts = crossings(robot, task, path, [((0, 0.2), (0, 0.8), False)], (), DEFAULT)
    assert [one.verdict for one in parts] == ["undecided", "crossing", "undecided"]
    assert path.spot(parts[0].start) == (0, 0.2)
    assert path.spot(parts[2].end) == (0, 0.8)
    assert parts[1].end.share - parts[1].start.share < 1e-8
    check = check_path(robot, path.control[0], evaluations=1)
    assert sum(one.verdict == "undecided" for one in check.stretches) == 2
    assert check.undecided_share > 0.99
