"""The atlases that come with the package are those of the catalogue's arms, true, complete, and found by geometry.

One of each structure made anew and compared: `pytest -m slow tests/results/test_known.py`; two by default. The whole
catalogue, with fewer starts: `test_every_arm.py`.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from known.arms import KINDS, STRUCTURES, structures
from scripts import tool

from rankdrop.distance.monitor import Monitor
from rankdrop.errors import ResultFileError
from rankdrop.families.searching import search
from rankdrop.families.soundness import soundness
from rankdrop.formula.equation import System
from rankdrop.local.posture import fault
from rankdrop.problem import Problem
from rankdrop.results.analysis import robot_to_dict
from rankdrop.results.known import (
    ANALYSIS,
    ANSWERS,
    CONDITIONS,
    FOLDER,
    SEED,
    STARTS,
    catalogue_aspects,
    conditions_names,
    file_text,
    known_analysis,
    known_names,
    part_of_file,
    shipped,
    shipped_record,
)
from rankdrop.results.stored_conditions import shipped_conditions
from rankdrop.robot.model import Array, Robot, coarse_fingerprint
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.robot.screws import from_screws
from rankdrop.task import BODY, resolve_task
from rankdrop.verbs.analyze import analyze
from rankdrop.version import VERSION

QUICK = ("planar3r", "puma560")
WORTH = 0.15
"""An example stays unless another one is better by this much of `fault`."""
ANEW = [pytest.param(name, marks=() if name in QUICK else pytest.mark.by_hand) for name in STRUCTURES]


def test_every_arm_of_the_catalogue_has_one_and_all_are_small():
    assert known_names() == robot_names()
    files = [item for item in (resources.files("rankdrop") / FOLDER).iterdir() if item.name.endswith(".jsonl")]
    assert {item.name.removesuffix(".jsonl") for item in files} == set(robot_names())
    sizes = [len(item.read_bytes()) for item in files]
    assert max(sizes) < 1_000_000
    assert sum(sizes) < 13_000_000


@pytest.mark.spread(21)
@pytest.mark.slow
@pytest.mark.parametrize("name", robot_names())
def test_the_file_holds_the_arm_of_the_catalogue_to_the_bit(name):
    robot, found = open_robot(name), shipped(name)
    assert robot_to_dict(robot, found.task, 0) == robot_to_dict(found.robot, found.task, 0), "stale: make it anew"
    assert found.settings.seed == SEED
    assert found.settings.starts == STARTS
    assert shipped_record(name)["answers"] == ANSWERS, "made by other code: run tools/make_known.py"
    assert found.settings.version == VERSION
    assert found.complete
    assert found.verified
    assert found.residual().holds(found.settings.tolerances)
    known = known_analysis(robot, resolve_task(None, robot))
    assert known == replace(found, aspects=catalogue_aspects()[name])


@pytest.mark.spread(72)
@pytest.mark.slow
@pytest.mark.shipped
@pytest.mark.parametrize("name", robot_names())
def test_the_example_of_a_family_is_of_no_other_one(name):
    """Of the same corank; in the atlas and among the exact conditions."""
    exact = shipped_conditions(name).families if name in conditions_names() else ()
    for families in (shipped(name).families, exact):
        systems = {one.id: System(one.equations) for one in families if one.equations}
        for one in families:
            same = [it for it in families if it.id in systems and it.corank == one.corank and it is not one]
            at = np.array([one.witness])
            assert all(np.abs(systems[it.id].values(at)).max() > 1e-6 for it in same), one.id


@pytest.mark.spread(16)
@pytest.mark.by_hand_at("yumi", "tiago", "z1", *(set(robot_names()) - set(STRUCTURES)))
@pytest.mark.slow
@pytest.mark.shipped
@pytest.mark.parametrize("name", robot_names())
def test_an_example_in_a_bad_posture_has_no_better_one_inside_the_limits(name):
    """Members inside the limits by construction: conditions solved for u in q = middle + half travel · sin u."""
    found = shipped_conditions(name) if name in conditions_names() else shipped(name)
    task = resolve_task(None, found.robot)
    for one in found.families:
        least = fault(found.robot, np.array([one.witness]))[0] - WORTH
        if least > 0.0 and one.equations:
            inside = members_inside(Problem(found.robot, task, one.corank), System(one.equations))
            assert not len(inside) or fault(found.robot, inside).min() >= least, one.id


def members_inside(problem: Problem, system: System, count: int = 1000) -> Array:
    """(≤ count, n) configurations of exactly the problem's rank, inside the limits, that solve the conditions."""
    robot, rng = problem.robot, np.random.default_rng(14)
    turns = robot.periodic & (robot.upper - robot.lower > 2 * np.pi)
    low = np.where(turns, -np.pi, np.maximum(robot.lower, -np.pi))
    high = np.where(turns, np.pi, np.minimum(robot.upper, np.pi))
    middle, half = (low + high) / 2, (high - low) / 2
    u = np.arcsin(rng.uniform(-1.0, 1.0, (count, robot.n)))
    for _ in range(80):
        value, slope = system.linear(middle + half * np.sin(u))
        slope = slope * (half * np.cos(u))[:, None]
        damped = (1e-10 + 1e-3 * (value**2).sum(axis=1))[:, None, None] * np.eye(value.shape[1])
        back = np.linalg.solve(slope @ slope.transpose(0, 2, 1) + damped, value[:, :, None])
        step = -(slope.transpose(0, 2, 1) @ back)[:, :, 0]
        u += step * np.minimum(1.0, 0.5 / np.maximum(np.linalg.norm(step, axis=1), 1e-12))[:, None]
    q, solved = system.solve(middle + half * np.sin(u))
    solved &= ((q >= robot.lower - 1e-9) & (q <= robot.upper + 1e-9)).all(axis=1)
    sigma = problem.sigma(q)
    here = sigma[:, problem.rank] <= problem.tolerances.singular
    return q[solved & here & ((sigma[:, problem.rank - 1] if problem.rank else 1.0) > 1e-3)]


def test_a_file_that_other_code_made_is_stale(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    maker, path = tool("make_known"), tmp_path / "planar3r.jsonl"
    shipped_file = resources.files("rankdrop") / FOLDER / path.name
    monkeypatch.setattr(maker, "FOLDER", tmp_path)
    assert maker.stale("planar3r")
    analysis, derived = part_of_file(shipped_file, ANALYSIS), part_of_file(shipped_file, CONDITIONS)
    assert file_text(analysis, derived).encode() == shipped_file.read_bytes()
    for answers, stale in ((ANSWERS, False), (ANSWERS + 1, True), (None, True)):
        path.write_text(file_text(analysis | {"answers": answers}, derived), encoding="utf-8")
        assert maker.stale("planar3r") is stale
        path.write_text(file_text(analysis, derived | {"answers": answers}), encoding="utf-8")
        assert maker.stale("planar3r") is stale
    path.write_text(file_text(None, derived), encoding="utf-8")
    assert maker.stale("planar3r")
    path.write_text(file_text(analysis, None), encoding="utf-8")
    assert not maker.stale("planar3r")


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_every_family_is_sound_at_fresh_points(name):
    found = shipped(name)
    for number, family in enumerate(found.families):
        problem = Problem(found.robot, found.task, family.corank, found.settings.tolerances)
        rng = np.random.default_rng([4711, number])
        fresh, strangers = soundness(problem, System(family.equations), found.robot.n - family.dimension, rng)
        assert fresh.holds, (family.id, fresh)
        assert not len(strangers)


@pytest.mark.spread(15)
@pytest.mark.slow
@pytest.mark.by_hand_at("tiago", "gen3", "sawyer", "yumi")
@pytest.mark.parametrize("name", KINDS)
def test_every_configuration_of_a_fresh_search_lies_on_a_family_of_its_corank(name):
    found = shipped(name)
    monitor = Monitor(found.robot, found.task, found.families)
    coranks = np.array([family.corank for family in found.families])
    for corank in sorted(set(coranks)):
        q = search(found.robot, int(corank), starts=300, seed=31_415).converged
        assert len(q) > 50, "the search found hardly anything: this test would mean nothing"
        seen = monitor.look(q)
        exact = seen.corank == corank
        assert exact.sum() > 30
        assert (seen.family[exact] >= 0).all()
        assert (coranks[seen.family[exact]] == corank).all()


@pytest.mark.slow
def test_what_is_made_anew_is_of_many_structures():
    assert structures() == STRUCTURES
    assert set(QUICK) <= set(STRUCTURES)


@pytest.mark.by_hand_at("puma560")
@pytest.mark.slow_at("puma560")
@pytest.mark.shipped  # rows take the partition of the exact conditions, as `test_stored_conditions.py`
@pytest.mark.parametrize("name", ANEW)
def test_made_anew_it_is_the_same(name):
    found = shipped(name)
    again = analyze(open_robot(name), starts=found.settings.starts, seed=found.settings.seed, exact="auto")
    rows = [(f.id, f.name, f.corank, f.dimension, f.free, f.coupled) for f in again.families]
    assert rows == [(f.id, f.name, f.corank, f.dimension, f.free, f.coupled) for f in found.families]
    for new, old in zip(again.families, found.families, strict=True):
        assert [one.number for one in new.pinned] == [one.number for one in old.pinned]
        for a, b in zip(new.pinned, old.pinned, strict=True):
            assert np.abs(np.array(a.values) - b.values).max() < 1e-9
        # not the last digits: LAPACK's differ from machine to machine
        points = np.random.default_rng(5).uniform(-3, 3, (20, found.robot.n))
        for mine, other in zip(new.equations, old.equations, strict=True):
            assert np.abs(mine(points) - other(points)).max() < 1e-6


def other_names(robot: Robot) -> Robot:
    """The same arm from its screws, with other names and limits, rounded as another program would."""
    screws = np.stack([joint.screw for joint in robot.joints]) * (1 + 2e-16)
    kinds = [str(joint.kind) for joint in robot.joints]
    return from_screws(screws, order="linear-first", kinds=kinds, home=robot.home, name="somebody's arm")


@pytest.mark.parametrize("name", ["pa10", "ur5", "canadarm2"])
def test_an_arm_is_recognised_by_its_geometry_and_keeps_its_own_names(name):
    robot = other_names(open_robot(name))
    found = known_analysis(robot, resolve_task("pose", robot))
    assert found is not None
    assert found.robot is robot
    assert found.residual().holds(found.settings.tolerances)
    pinned = [one for family in found.families for one in family.pinned]
    assert pinned
    assert all(one.joint == robot.variables[one.number - 1].name for one in pinned)
    assert {f.equations for f in found.families} == {f.equations for f in shipped(name).families}
    assert any(family.lost_freedoms for family in found.families)
    assert type(found).from_dict(found.to_dict()) == found


def test_another_geometry_is_not_recognised():
    robot = open_robot("pa10")
    home = robot.home.copy()
    home[2, 3] += 1e-7
    joints = (replace(robot.joints[0], kind="helical"), *robot.joints[1:])
    screw = robot.joints[3].screw.copy()
    screw[0] += 1e-7
    bent = (*robot.joints[:3], replace(robot.joints[3], screw=screw), *robot.joints[4:])
    for other in (replace(robot, home=home), replace(robot, joints=joints), replace(robot, joints=bent)):
        assert known_analysis(other, resolve_task("pose", other)) is None
        assert coarse_fingerprint(other) != coarse_fingerprint(robot)


def test_geometry_off_by_a_hair_is_not_the_same_arm():
    robot = open_robot("pa10")
    home = robot.home.copy()
    home[2, 3] += 1e-11  # one fingerprint, but not the same numbers
    other = replace(robot, home=home)
    assert coarse_fingerprint(other) == coarse_fingerprint(robot)
    assert known_analysis(other, resolve_task("pose", other)) is None


def test_the_rows_of_the_task_have_to_be_the_same():
    pa10, planar = open_robot("pa10"), open_robot("planar3r")
    assert known_analysis(pa10, resolve_task("position", pa10)) is None
    assert known_analysis(pa10, resolve_task("pose", pa10, frame=BODY)) is not None
    assert known_analysis(planar, resolve_task(None, planar)) is not None
    assert known_analysis(planar, resolve_task(None, planar, frame=BODY)) is None


def test_a_file_that_is_not_there_is_said_so():
    with pytest.raises(ResultFileError, match="no shipped analysis"):
        shipped("no such arm")


def test_of_all_files_only_that_of_the_arm_is_read():
    robot = open_robot("sawyer")
    shipped.cache_clear()
    assert known_analysis(robot, resolve_task(None, robot)) is not None
    assert shipped.cache_info().misses == 1
