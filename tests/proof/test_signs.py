"""Certificates that an arm is not cuspidal: the structure holds exactly, and the factors are those of the theorem."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from reference import cuspidal

from rankdrop.aspects import posture_certificate
from rankdrop.cli.main import run
from rankdrop.cover import asked_about, verify, write_certificate
from rankdrop.cover.ball import points_of
from rankdrop.cover.certificates import Verified, record_of
from rankdrop.cover.setting import best_setting
from rankdrop.errors import OptionError
from rankdrop.exact.posture_changes import NO_CUSP, Decision
from rankdrop.kinematics import pose
from rankdrop.local.block import sample
from rankdrop.poses.inverse import joint_difference, solutions
from rankdrop.proof.arm import BITS, Arm, flint
from rankdrop.proof.record import SIGNS as SIGN_PROOF
from rankdrop.proof.record import STRUCTURES, claim_of, fingerprint, with_hash
from rankdrop.proof.record import _certificate as read
from rankdrop.proof.record import _link as link_of
from rankdrop.proof.signs import _DeterminantFactors
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task

Record = dict[str, Any]
ARMS = {
    **{name: name for name in (*cuspidal.STRUCTURED, "orientation")},
    **dict.fromkeys(("planar2r", "planar3r", "scara"), "planar"),
    "ur5e": "three parallel", "irb120": "axes 1, 2 meet", "stanford": "axes 1, 2 meet", "puma560": "axes 1, 2 meet",
}  # fmt: skip


@pytest.fixture(scope="module")
def honest() -> dict[str, Record]:
    return cuspidal.sign_proofs()


def arm(name: str) -> Robot:
    return cuspidal.structured(name) if name in STRUCTURES else open_robot(name)


def claimed(robot: Robot, structure: str) -> Record:
    task = resolve_task(None, robot)
    return record_of(robot, task, SIGN_PROOF, best_setting(robot, task), {"structure": structure}, {})


def judged(record: Record, folder: Path) -> Verified:
    return verify(write_certificate(with_hash(record), folder / "signs.json"))


def hashed(record: Record) -> Record:
    entry = read(record, "")["arm"]
    record["arm"]["fingerprint"] = fingerprint(entry, [link_of(joint) for joint in entry["joints"]])
    return record


@pytest.mark.parametrize("name", ARMS)
def test_arms_with_signs_of_their_own_are_proven_not_to_be_cuspidal(tmp_path: Path, name: str) -> None:
    record = posture_certificate(cuspidal.decided(arm(name)))
    assert record["claim"] == {"structure": ARMS[name]}
    Draft202012Validator(load_schema("certificate")).validate(record)
    found = judged(record, tmp_path)
    assert found.holds, found.reason
    assert f"{arm(name).name!r} is not cuspidal: no path without a singularity" in found.claim
    Draft202012Validator(load_schema("verified")).validate(found.to_dict())


@pytest.mark.parametrize("name", ARMS)
def test_solutions_of_one_pose_differ_in_a_sign(name: str) -> None:
    """What the theorem says, seen: Newton's method finds the solutions, the checker's factors have signs there."""
    robot = arm(name)
    task, claim = resolve_task(None, robot), claim_of(claimed(robot, ARMS[name]), Path())
    f, most = flint(), 0
    with f.ctx.workprec(BITS):
        factors = _DeterminantFactors(claim, ARMS[name])
        base = Arm(claim.links, claim.variables, 0, [f.arb(0)] * 3, f.arb(1))
        for q in sample(robot, task, 3, 4):
            found = solutions(robot, task, pose(robot, q), starts=100, seed=1, also=q)
            signs = [tuple(value > 0 for value in factors.values(base, [f.arb(float(x)) for x in one]))
                     for one in found]  # fmt: skip
            assert len(set(signs)) == len(signs)
            assert all(np.abs(joint_difference(robot, one, found)).max(axis=1).min() < 1e-9 for one in found)
            most = max(most, len(found))
    assert most >= 2


def turned(record: Record, joint: int, by: float) -> Record:
    """An axis tilted about its foot, by as little as it may be."""
    forged = copy.deepcopy(record)
    screw = forged["arm"]["joints"][joint]["screw"]
    v, w = np.array(screw[:3]), np.array(screw[3:])
    foot, side = np.cross(w, v), np.roll(w, 1)
    w = w + by * side
    w /= np.linalg.norm(w)
    forged["arm"]["joints"][joint]["screw"] = [*np.cross(foot, w).tolist(), *w.tolist()]
    return hashed(forged)


def shifted(record: Record, joint: int, other: int, by: float) -> Record:
    """An axis beside its place, away from another one."""
    forged = copy.deepcopy(record)
    screw = forged["arm"]["joints"][joint]["screw"]
    w = np.array(screw[3:])
    side = np.cross(w, forged["arm"]["joints"][other]["screw"][3:])
    forged["arm"]["joints"][joint]["screw"] = [*(np.array(screw[:3]) + np.cross(by * side, w)).tolist(), *w.tolist()]
    return hashed(forged)


def test_a_structure_that_is_missed_by_rounding_is_refused(honest: dict[str, Record], tmp_path: Path) -> None:
    ur, wrist, point, plane = honest.values()
    cases = [
        (turned(ur, 1, 1e-15), "axes 2 and 3 are not parallel"),
        (turned(ur, 3, 1e-15), "axes 3 and 4 are not parallel"),
        (shifted(ur, 5, 4, 1e-14), "axes 5 and 6 do not meet"),
        (shifted(wrist, 5, 4, 1e-14), "axis 6 misses that of 4 and 5"),
        (shifted(wrist, 3, 4, 1e-14), "axes 4 and 5 do not meet"),
        (shifted(wrist, 1, 0, 1e-14), "axes 1 and 2 do not meet"),
        (turned(point, 2, 1e-15), "axes 2 and 3 are not parallel"),
        (turned(plane, 1, 1e-15), "not all parallel to one axis of the base"),
    ]
    for record, words in cases:
        found = judged(record, tmp_path)
        assert not found.holds, words
        assert words in found.reason
    assert judged(shifted(ur, 2, 0, 1e-3), tmp_path).holds  # another UR, of which the same is true


def test_no_cuspidal_arm_and_no_other_structure_passes(tmp_path: Path) -> None:
    for robot in (cuspidal.wenger(), open_robot("crx10ia"), *map(cuspidal.structured, cuspidal.STRUCTURED)):
        record, own = claimed(robot, STRUCTURES[0]), cuspidal.decided(robot).decision.why
        for structure in STRUCTURES:
            found = judged(record | {"claim": {"structure": structure}}, tmp_path)
            assert found.holds == (structure == own), (robot.name, structure, found.reason)


def near_arms(record: Record) -> None:
    record["tolerance"] = {"length": 0.0, "angle": 0.0, "points": points_of(open_robot("ur5e")).tolist()}


def slides(record: Record) -> None:
    record["arm"]["joints"][2].update(kind="prismatic", screw=[0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    hashed(record)


def test_lies_about_the_arm_and_the_task_are_refused(honest: dict[str, Record], tmp_path: Path) -> None:
    lies: list[tuple[Any, str]] = [
        (near_arms, "not for arms near it"),
        (slides, "turning joints"),
        (lambda record: (record["task"].update(rows=[3, 4, 5]), record.update(rank=3)), "as many joints as rows"),
        (lambda record: record.update(rank=5), "above 5"),
        (lambda record: record["claim"].update(structure="planar"), "two or three turning joints"),
    ]
    for lie, words in lies:
        record = copy.deepcopy(honest["sign proof"])
        lie(record)
        found = judged(record, tmp_path)
        assert not found.holds
        assert words in found.reason


def tilted(record: Record) -> None:
    """The axes of the tool are turned about y, and the task takes them."""
    turn = np.array(record["arm"]["home"])
    turn[:3, :3] = turn[:3, :3] @ np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]])
    record["arm"]["home"] = turn.tolist()
    record["task"]["frame"]["axes"] = -1
    hashed(record)


def test_lies_about_a_plane_are_refused(honest: dict[str, Record], tmp_path: Path) -> None:
    """The theorem is of the rows of the plane that the axes are normal to, and of a point of the tool."""
    lies: list[tuple[Any, str]] = [
        (lambda record: record["task"].update(rows=[0, 1, 3, 5]), "here rows [0, 1, 2, 5]"),
        (lambda record: record["task"]["frame"].update(origin=0), "the point of the task"),
        (lambda record: record["task"]["frame"].update(axes=2), "the point of the task"),
        (tilted, "not along those of the arm"),
    ]
    for lie, words in lies:
        record = copy.deepcopy(honest["sign proof in a plane"])
        lie(record)
        found = judged(record, tmp_path)
        assert not found.holds, words
        assert words in found.reason


@pytest.mark.parametrize("name", ["scara", "ur5e", "irb120", "axes 1, 2 parallel", "axes 2, 3 meet"])
def test_factors_of_another_arm_do_not_multiply_to_the_determinant(monkeypatch: Any, tmp_path: Path, name: str) -> None:
    """The comparison with det J is no ornament: a factor that is twice too large, or another one, is seen."""
    record, honest = claimed(arm(name), ARMS[name]), _DeterminantFactors.values
    for forged in (lambda *args: [2 * honest(*args)[0], *honest(*args)[1:]],
                   lambda *args: [honest(*args)[0] ** 2, *honest(*args)[1:]]):  # fmt: skip
        monkeypatch.setattr(_DeterminantFactors, "values", forged)
        found = judged(record, tmp_path)
        assert not found.holds
        assert "do not multiply" in found.reason


def test_the_claim_is_compared_with_what_was_asked(honest: dict[str, Record], tmp_path: Path) -> None:
    place = write_certificate(honest["sign proof"], tmp_path / "ur5e.json")
    assert verify(place, open_robot("ur5e")).holds
    assert "another arm" in verify(place, open_robot("ur5")).reason
    assert "a sign proof, not a path" in verify(place, asked_about(open_robot("ur5e"), rows=[[0.0] * 6] * 2)).reason


def test_a_proof_that_the_checker_does_not_know_is_refused() -> None:
    planar = cuspidal.decided(open_robot("planar3r"))
    with pytest.raises(OptionError, match=r"the checker does not know this proof .* no three solutions of"):
        posture_certificate(replace(planar, decision=Decision(NO_CUSP)))
    with pytest.raises(OptionError, match=r"axes 5 and 6 do not meet: 4\.5e-17 m between them"):
        posture_certificate(cuspidal.decided(open_robot("jaka_a5")))


def test_the_command_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: Any) -> None:
    file, robot = tmp_path / "c.json", open_robot("ur5e")
    monkeypatch.setattr("rankdrop.aspects.aspects_of", lambda *_, **__: cuspidal.decided(robot))
    assert run(["aspects", "ur5e", "--certificate", str(file), "--quiet"]) == 0
    assert json.loads(file.read_text())["kind"] == "sign proof"
    assert run(["verify", str(file), "--robot", "ur5e", "--quiet"]) == 0
    assert capsys.readouterr().out.count("'ur5e' is not cuspidal") == 1
