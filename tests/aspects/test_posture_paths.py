"""Cuspidal only with a path that another judge proves free; not cuspidal only where no way is found either."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from reference import cuspidal

from rankdrop.aspects import change_certificate
from rankdrop.aspects import posture_paths as search
from rankdrop.aspects.posture_paths import CUSPIDAL, NOT_CUSPIDAL, NOT_FOUND, Postures, aspects_of
from rankdrop.cli import main
from rankdrop.codec import json_text
from rankdrop.cover import verify, write_certificate
from rankdrop.errors import ConfigurationError, OptionError, TaskError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.arm.structure import structure_of
from rankdrop.exact.posture_changes import CUSPS, OPEN, Decision
from rankdrop.kinematics import pose, task_jacobian
from rankdrop.path.check.check import check_path
from rankdrop.poses.inverse import Aim, solutions
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.text.aspects import decision_text

H = np.pi / 2
WENGER = [(0, 1, -H), (1, 2, H), (0, 1.5, 0)]


def arm(rows: Any, task: str = "position") -> Robot:
    table = [{"d": float(d), "a": float(a), "alpha": float(x)} for d, a, x in rows]
    return from_dh(table, convention="standard", task=task, name="arm")


WRISTED = [(0, 1, -H), (1, 2, H), (0, 1.5, H), (0, 0, -H), (0, 0, H), (0.2, 0, 0)]
Q = {
    "crx10ia": [0.2, 0.9, 0.4, -0.6, 0.9, 0.0],  # Salunkhe et al. report it to be cuspidal
    "crb15000": [0.2, 0.9, 0.4, -0.6, 0.9, 0.0],
    "j2n6s300": [0.3, 2.0, 1.0, 0.5, 1.2, 0.4],
}


def holds(found: Postures) -> None:
    """The path begins and ends at one pose, in different postures, and is free: judged anew."""
    assert found.change is not None
    q = found.change.q
    task = resolve_task(found.task, found.robot)
    assert np.abs(Aim(found.robot, task).error(pose(found.robot, q[0]), q[-1:])).max() < 1e-9
    gap = q[-1] - q[0]
    assert np.abs(gap - 2 * np.pi * np.round(gap / (2 * np.pi))).max() > 0.01
    assert check_path(found.robot, q, task=found.task).clear
    assert found.verdict == CUSPIDAL


@pytest.mark.by_hand_at("crx10ia", "j2n6s300")
@pytest.mark.slow
@pytest.mark.parametrize("name", list(Q))
def test_arms_with_offset_wrists_change_posture_on_a_path_that_is_free(name: str) -> None:
    found = aspects_of(open_robot(name), q=Q[name], starts=300)
    holds(found)
    assert found.change is not None
    assert found.change.own
    assert np.array_equal(found.change.q[0], Q[name])
    assert "neither proof" in decision_text(found.decision)


@pytest.mark.slow
def test_wengers_arm_with_and_without_a_wrist() -> None:
    for rows, task in ((WENGER, "position"), (WRISTED, "pose")):
        found = aspects_of(arm(rows, task), poses=4, starts=200)
        holds(found)
        assert len(found.decision.cusps) == 4


def test_an_arm_with_three_parallel_axes_is_cuspidal_where_axes_5_and_6_do_not_meet(tmp_path: Path) -> None:
    """Of the kind that Elias and Wen report; where axes 5 and 6 meet (UR) each solution has signs of its own."""
    robot = cuspidal.three_parallel()
    structure = structure_of(exact_chain(robot))
    assert (structure.parallel, structure.meeting) == (((2, 3, 4),), ())
    record = change_certificate(cuspidal.postures(robot, cuspidal.PARALLEL))
    found = verify(write_certificate(record, tmp_path / "parallel.json"), robot)
    assert found.holds, found.reason
    assert cuspidal.true(record)


@pytest.mark.slow
def test_elias_and_wens_arm_is_cuspidal_between_the_two_solutions_that_they_print() -> None:
    robot = cuspidal.elias_wen()
    first, second = cuspidal.ELIAS_WEN
    found = aspects_of(robot, q=first, starts=300)
    holds(found)
    (solved,) = found.solved
    gaps = np.abs(solved.q - second).max(axis=1)
    assert gaps.min() < 1e-4
    assert solved.aspect[gaps.argmin()] == solved.aspect[0]
    assert (found.count.at_least, found.count.at_most) == (8, 8)


@pytest.mark.slow
def test_one_path_is_enough_where_signs_decide_which_solutions_share_an_aspect(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ways were searched between the solutions of every pose: 12 s of a Gen3 with six joints instead of 3 s."""
    asked, ways = [], search.Roadmap.ways
    monkeypatch.setattr(search.Roadmap, "ways", lambda self, q: asked.append(len(q)) or ways(self, q))
    found = aspects_of(open_robot("crx10ia"), poses=3, starts=100)
    assert found.verdict == CUSPIDAL
    assert len(asked) == 1
    assert [len(set(one.aspect)) for one in found.solved] == [2, 2, 2]


@pytest.mark.slow
def test_a_pose_is_chosen_near_a_cusp_where_random_ones_do_not_do() -> None:
    rows = [(0, 0.798, H), (0.133, 1.023, -H), (0, 0.251, 0)]
    found = aspects_of(arm(rows), poses=1, starts=60, seed=2)
    holds(found)
    assert [one.near_cusp for one in found.solved] == [False, True]


@pytest.mark.parametrize(("name", "count"), [("puma560", 8), ("ur5", 8), ("stanford", 8), ("scara", 2)])
def test_each_solution_has_signs_of_its_own_where_that_is_the_proof(name: str, count: int) -> None:
    q = [0.3, 0.5, 0.4, 0.6, 0.8, 0.2][: open_robot(name).n]
    found = aspects_of(open_robot(name), q=q, starts=300)
    assert (found.verdict, found.change) == (NOT_CUSPIDAL, None)
    (one,) = found.solved
    assert len(one.q) == len(set(one.names)) == len(set(one.aspect)) == count


def searched(robot: Robot, monkeypatch: pytest.MonkeyPatch, poses: int) -> Postures:
    """By search alone: nothing is known beforehand."""
    monkeypatch.setattr(search, "decide_exactly", lambda robot, task: (Decision(OPEN, "not asked"), None, ()))
    return aspects_of(robot, poses=poses, most=poses, starts=200)


@pytest.mark.slow
def test_more_poses_are_solved_until_a_path_is_proven_or_the_budget_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three random poses of Wenger's arm decide nothing with seed 1; the eighth does."""
    monkeypatch.setattr(search, "decide_exactly", lambda robot, task: (Decision(OPEN, "not asked"), None, ()))
    few = aspects_of(arm(WENGER), poses=3, most=3, starts=60, seed=1)
    more = aspects_of(arm(WENGER), poses=3, most=50, starts=60, seed=1)
    assert (few.verdict, len(few.solved)) == (NOT_FOUND, 3)
    holds(more)
    assert more.change is not None
    assert 3 < len(more.solved) < 50


@pytest.mark.slow
def test_random_poses_follow_where_those_near_cusps_show_no_path(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cusps are known and none of their neighbours is of use: before, the search ended after three random poses."""
    monkeypatch.setattr(search, "decide_exactly", lambda robot, task: (Decision(CUSPS), None, ()))
    found = aspects_of(arm(WENGER), poses=3, most=50, starts=60, seed=1)
    holds(found)
    assert 3 < len(found.solved) < 50


STRUCTURES = {
    "1, 2 meet": [(0, 0, H), (0.3, 0.7, 1.1), (0.2, 0.8, 0)],
    "1, 2 parallel": [(0, 0.4, 0), (0.3, 0.7, 1.1), (0.2, 0.8, 0)],
    "2, 3 parallel": [(0, 0.4, 1.1), (0.3, 0.7, 0), (0.2, 0.8, 0)],
    "2, 3 meet": [(0, 0.4, 1.1), (0.3, 0, 0.9), (0.2, 0.8, 0)],
    "without offsets": [(0, 1, -H), (0, 2, H), (0, 1.5, 0)],
    "no cusp": [(0, 1, -H), (0.2, 0.3, H), (0.1, 0.9, 0)],
}


@pytest.mark.spread(1)
@pytest.mark.by_hand_at("1, 2 meet", "without offsets")
@pytest.mark.slow
@pytest.mark.slow_at("without offsets", "1, 2 meet", "2, 3 meet")
@pytest.mark.parametrize("name", STRUCTURES)
def test_what_is_proven_not_cuspidal_is_not_found_to_be(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = arm(STRUCTURES[name])
    assert aspects_of(robot, poses=1).verdict == NOT_CUSPIDAL
    found = searched(robot, monkeypatch, 12)
    assert found.verdict == NOT_FOUND
    assert "no proof" in found.sentence
    assert max(len(one.q) for one in found.solved) == 4


@pytest.mark.by_hand
@pytest.mark.parametrize("name", ["puma560", "ur5", "kr3r540", "stanford", "irb6640"])
def test_nor_are_arms_of_six_joints(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert searched(open_robot(name), monkeypatch, 25).verdict == NOT_FOUND


@pytest.mark.slow
def test_the_search_alone_finds_what_the_cusps_say(monkeypatch: pytest.MonkeyPatch) -> None:
    holds(searched(arm(WENGER), monkeypatch, 10))


@pytest.mark.slow
def test_neither_sense_nor_base_nor_unit_changes_the_counts() -> None:
    q = np.array([0.4, -0.731, 3.1241])
    kept = aspects_of(arm(WENGER), q=q, starts=200)
    assert kept.solved[0].per_aspect == (2, 2)
    thousand = aspects_of(arm([(1000 * d, 1000 * a, x) for d, a, x in WENGER]), q=q, starts=200)
    mirrored = aspects_of(arm([(-d, a, -x) for d, a, x in WENGER]), q=-q, starts=200)
    for other in (thousand, mirrored):
        holds(other)
        assert other.solved[0].per_aspect == (2, 2)


def test_solutions_are_solutions_and_all_of_a_puma_are_found() -> None:
    robot = open_robot("puma560")
    task = resolve_task(None, robot)
    target = pose(robot, [0.3, 0.5, 0.4, 0.6, 0.8, 0.2])
    found = solutions(robot, task, target, starts=300, seed=1)
    assert len(found) == 8
    assert np.abs(Aim(robot, task).error(target, found)).max() < 1e-10
    assert np.abs(np.linalg.det(task_jacobian(robot, found, task))).min() > 0


@pytest.mark.slow
def test_limits_hold_for_solutions_and_path() -> None:
    robot = open_robot("crx10ia")
    found = aspects_of(robot, q=Q["crx10ia"], starts=300, limits=True)
    for q in (found.solved[0].q, *(() if found.change is None else (found.change.q,))):
        assert (q >= robot.lower - 1e-9).all()
        assert (q <= robot.upper + 1e-9).all()
    assert len(found.solved[0].q) > 1


@pytest.mark.slow
def test_solutions_outside_the_limits_are_left_out() -> None:
    free = aspects_of(arm(WENGER), q=[0.4, -0.731, 3.1241], starts=100).solved[0].q
    rows = [{"d": float(d), "a": float(a), "alpha": float(x)} for d, a, x in WENGER]
    rows[2] |= {"lower": 0.0, "upper": 2 * np.pi}
    rows[1] |= {"lower": -1.0, "upper": 3.5}
    bound = from_dh(rows, convention="standard", task="position", name="bound")
    found = aspects_of(bound, q=[0.4, -0.731, 3.1241], starts=100, limits=True).solved[0].q
    inside = [q for q in free if q[1] >= -1.0 or q[1] <= 3.5 - 2 * np.pi]
    assert len(found) == len(inside) < len(free) == 4
    assert (found[:, 2] >= 0.0).all()


def test_what_cannot_be_asked_is_refused() -> None:
    with pytest.raises(TaskError, match="without redundancy"):
        aspects_of(open_robot("panda"), q=[0.1, 0.2, 0.3, -1.0, 0.2, 1.0, 0.1])
    with pytest.raises(ConfigurationError, match="singular"):
        aspects_of(open_robot("puma560"), q=[0.1, 0.5, 0.4, 0.2, 0.0, 0.6])
    with pytest.raises(OptionError, match="poses"):
        aspects_of(open_robot("puma560"), poses=0)


@pytest.mark.slow
def test_the_record_is_valid_and_the_same_again() -> None:
    check = Draft202012Validator(load_schema("aspects"))
    for robot in (open_robot("planar2r"), arm(WENGER)):
        records = [json_text(aspects_of(robot, poses=4, starts=100).to_dict()) for _ in range(2)]
        assert records[0] == records[1]
        record = json.loads(records[0])
        check.validate(record)
        for entry in set(record) - {"units", "count"}:  # which files of 0.2.0 do not have
            assert not check.is_valid({key: value for key, value in record.items() if key != entry}), entry


def test_ctrl_c_keeps_what_was_solved() -> None:
    def stop(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    found = aspects_of(open_robot("planar2r"), poses=5, progress=stop)
    assert not found.complete
    assert len(found.solved) == 2


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Any:
    def once(*argv: str) -> tuple[int, str, str]:
        monkeypatch.setenv("COLUMNS", "120")
        capsys.readouterr()
        return (main.run([*argv, "--quiet"]), *capsys.readouterr())

    return once


@pytest.mark.by_hand
def test_the_command_writes_a_path_that_the_path_command_proves(run: Any, tmp_path: Path) -> None:
    out, none = tmp_path / "change.csv", tmp_path / "none.csv"
    q = ",".join(map(str, Q["crx10ia"]))
    code, printed, _ = run("aspects", "crx10ia", "--q", q, "--starts", "100", "--path", str(out))
    assert code == 0
    assert "8 solutions in 2 aspects" in printed
    assert "free of singularities (proven)" in " ".join(run("path", "crx10ia", str(out))[1].split())
    code, printed, said = run("aspects", "planar2r", "--json", "-", "--path", str(none))
    assert (code, json.loads(printed)["verdict"]) == (0, NOT_CUSPIDAL)
    assert "there is no path" in said
    assert not none.exists()
    table = tmp_path / "open.toml"
    rows = [(0, 0.9, -H), (0.5, 0.3, H), (0, 1.2, 0)]
    joints = "\n".join(f"[[joints]]\nd = {d}\na = {a}\nalpha = {x}" for d, a, x in rows)
    table.write_text(f'name = "open"\ntask = "position"\nconvention = "standard"\n{joints}\n')
    code, printed, _ = run("aspects", str(table), "--poses", "2")
    assert code == 3
    assert "no proof of absence" in " ".join(printed.split())
