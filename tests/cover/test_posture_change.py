"""Certificates that an arm is cuspidal: each part of the claim is proven, and each lie about it refused."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from reference import cuspidal

from rankdrop.cli.main import run
from rankdrop.cover import asked_about, verify, write_certificate
from rankdrop.cover.ball import points_of
from rankdrop.cover.certificates import Verified, record_of
from rankdrop.cover.setting import best_setting
from rankdrop.errors import ResultFileError
from rankdrop.path import path_asked
from rankdrop.proof.record import CHANGE, fingerprint, with_hash
from rankdrop.proof.record import _certificate as read
from rankdrop.proof.record import _link as link_of
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task

Record = dict[str, Any]
POINT, POSE = "posture change", "posture change within limits"


@pytest.fixture(scope="module")
def honest() -> dict[str, Record]:
    return cuspidal.certificates()


def judged(record: Record, folder: Path, **asked: Any) -> Verified:
    about = asked_about(asked.pop("robot", None), **asked)
    return verify(write_certificate(with_hash(record), folder / "change.json"), about)


def test_what_is_proven_of_a_cuspidal_arm_holds_and_is_said_first(honest: dict[str, Record], tmp_path: Path) -> None:
    for kind, words in ((POINT, "'arm' is cuspidal: "), (POSE, "'crx10ia' is cuspidal: ")):
        record = honest[kind]
        Draft202012Validator(load_schema("certificate")).validate(record)
        assert cuspidal.true(record)
        found = judged(record, tmp_path)
        assert found.holds, found.reason
        assert found.claim.startswith(words)
        assert "exactly the pose of the first row" in found.claim
        assert found.claim.endswith("inside the joint limits") == (kind == POSE)
        assert found.statement[-1].startswith("the poses of its two ends agree within ")
        Draft202012Validator(load_schema("verified")).validate(found.to_dict())


def test_how_far_the_two_poses_are_apart_is_no_less_than_it_is(honest: dict[str, Record], tmp_path: Path) -> None:
    record = copy.deepcopy(honest[POINT])
    record["claim"]["points"][-1][2] += 1e-7
    record["claim"]["radius"] = 1e-5
    found = judged(record, tmp_path)
    assert found.holds, found.reason
    said = float(found.statement[-1].removesuffix(" m").rpartition(" ")[2])
    assert 1.5e-7 < said < 1.52e-7  # link 3 is 1.5 m long


def moved(by: float, row: int = -1) -> Any:
    def act(record: Record) -> None:
        record["claim"]["points"][row][1] += by

    return act


def claim(**entries: Any) -> Any:
    return lambda record: record["claim"].update(entries)


def whole_turn(record: Record) -> None:
    """From a solution to itself, once around with every joint."""
    points = record["claim"]["points"]
    points[-1] = [x + 2 * np.pi for x in points[0]]


def half_turn(record: Record) -> None:
    """From a pose to that with the tool turned round: M is symmetric, and the point is on the axis."""
    points = record["claim"]["points"]
    record["claim"].update(points=[points[0], [*points[0][:5], points[0][5] - np.pi]], limits=False)


def longer(record: Record) -> None:
    record["arm"]["home"][0][3] += 1e-3
    arm = read(record, "")["arm"]
    record["arm"]["fingerprint"] = fingerprint(arm, [link_of(joint) for joint in arm["joints"]])


def through(record: Record) -> None:
    """A corner in another aspect."""
    record["claim"]["points"][1] = [0.0, 1.0, -1.0]


def near_arms(record: Record) -> None:
    record["tolerance"] = {"length": 0.0, "angle": 0.0, "points": points_of(cuspidal.wenger()).tolist()}


LIES = {
    "an end that is no solution": (POINT, moved(1e-6), "away, not 1e-09"),
    "an end far from any": (POINT, moved(0.4), "is up to|not proven to be next to|not proven to be free"),
    "another beginning": (POINT, moved(1e-6, 0), "away, not 1e-09"),
    "a smaller radius": (POINT, claim(radius=1e-17), "away, not 1e-17"),
    "a radius that reaches a singularity": (POINT, claim(radius=0.9), "around the last row is not proven"),
    "one posture": (POINT, whole_turn, "one posture"),
    "two poses, half a turn apart": (POSE, half_turn, "not proven to be next to a solution"),
    "through a singularity": (POINT, through, "could not be proven free again"),
    "limits that it does not keep": (POSE, lambda record: record["arm"]["joints"][3].update(upper=3.0), "joint 4"),
    "limits that are not stated": (
        POSE, lambda record: [joint.pop(key) for joint in record["arm"]["joints"] for key in ("lower", "upper")],
        "states none"),
    "another arm": (POINT, longer, "away, not 1e-09"),
    "arms near it": (POINT, near_arms, "not for arms near it"),
    "a lower rank": (POINT, lambda record: record.update(rank=2), "above 2 almost everywhere"),
    "more rows": (POINT, lambda record: record["task"].update(rows=[0, 1, 2, 3, 4, 5]), "as many joints as rows"),
}  # fmt: skip


@pytest.mark.parametrize("lie", LIES)
def test_a_lie_about_one_part_of_the_claim_is_refused(honest: dict[str, Record], tmp_path: Path, lie: str) -> None:
    kind, change, words = LIES[lie]
    record = copy.deepcopy(honest[kind])
    change(record)
    found = judged(record, tmp_path)
    assert not found.holds
    assert any(word in found.reason for word in words.split("|")), found.reason


def test_a_task_of_some_rows_is_refused(tmp_path: Path) -> None:
    robot = open_robot("planar3r")
    task = resolve_task(None, robot)
    entries = {"degree": 1, "points": [[0.1, 0.9, 0.3], [0.2, 1.0, 0.4]], "radius": 1e-9, "limits": False}
    found = judged(record_of(robot, task, CHANGE, best_setting(robot, task), entries, {}), tmp_path)
    assert not found.holds
    assert "tasks that take all rows" in found.reason


def test_an_arm_of_which_only_the_numbers_were_changed_is_refused(honest: dict[str, Record], tmp_path: Path) -> None:
    record = copy.deepcopy(honest[POINT])
    record["arm"]["home"][0][3] += 1e-3
    assert "fingerprint" in judged(record, tmp_path).reason
    record = copy.deepcopy(honest[POINT])
    record["claim"]["radius"] = 2e-9
    assert "hash" in verify(write_certificate(record, tmp_path / "one.json")).reason
    record["claim"]["degree"] = 2
    with pytest.raises(ResultFileError, match="malformed"):
        judged(record, tmp_path)


def test_the_claim_is_compared_with_what_was_asked(honest: dict[str, Record], tmp_path: Path) -> None:
    arm, crx = cuspidal.wenger(), open_robot("crx10ia")
    change = cuspidal.postures(arm, cuspidal.WENGER)
    (tmp_path / "way.csv").write_text(change.path_csv())
    other = [*cuspidal.WENGER[:-1], [0.0, 0.0, 0.0]]
    cases: list[tuple[str, dict[str, Any], str]] = [
        (POINT, {"robot": arm, "q": cuspidal.WENGER[0]}, ""),
        (POINT, {"robot": arm, "q": cuspidal.WENGER[-1]}, "q = "),
        (POINT, {"robot": arm, "path": path_asked(arm, tmp_path / "way.csv")}, ""),
        (POINT, {"robot": arm, "rows": other}, "other rows"),
        (POINT, {"robot": crx}, "another arm"),
        (POINT, {"limits": True}, "the whole joint space"),
        (POSE, {"robot": crx, "limits": True}, ""),
        (POSE, {"robot": crx, "task": "position"}, "the rows"),
    ]
    for kind, asked, words in cases:
        found = judged(honest[kind], tmp_path, **asked)
        assert found.holds == (not words), (kind, words, found.reason)
        assert not words or words in found.reason


def test_the_command_writes_a_certificate_or_says_why_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file, arm = tmp_path / "c.json", cuspidal.wenger()
    monkeypatch.setattr("rankdrop.cli.research.open_arm", lambda *_: (arm, resolve_task(None, arm)))
    monkeypatch.setattr("rankdrop.aspects.aspects_of", lambda *_, **__: cuspidal.postures(arm, cuspidal.WENGER))
    assert run(["aspects", "arm", "--certificate", str(file), "--quiet"]) == 0
    assert json.loads(file.read_text())["kind"] == "posture change"
    assert run(["verify", str(file), "--quiet"]) == 0
    assert "'arm' is cuspidal" in capsys.readouterr().out
    file.unlink()
    monkeypatch.setattr("rankdrop.aspects.aspects_of", lambda *_, **__: cuspidal.postures(arm, None))
    assert run(["aspects", "arm", "--certificate", str(file), "--quiet"]) == 3
    assert "c.json is not written: there is no path, and nothing is proven" in capsys.readouterr().err
    assert not file.exists()
