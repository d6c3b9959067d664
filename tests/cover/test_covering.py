"""No singular configuration is outside the boxes; boxes said to hold one do; the bytes are the same however made."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zlib
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from known.members import members
from reference import arms
from reference.coverings import covering

from rankdrop import _core
from rankdrop.cover import covering as module
from rankdrop.cover.box_matching import FamilyBoxes
from rankdrop.cover.covering import (
    Covering,
    CoveringEnd,
    batch_from_bytes,
    batch_to_bytes,
    chunk_of,
    classify_boxes,
    load_covering,
    plan_of,
    put_together,
    write_covering,
)
from rankdrop.distance.many_distances import distances
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.families.searching import search
from rankdrop.jobs import progress_of
from rankdrop.kinematics import jacobian
from rankdrop.local.block import joint_scale
from rankdrop.proof.boxes import MAGIC, BitTree, digest
from rankdrop.results.known import known_analysis
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs import cover, how_far

WIDTH = 0.4


@cache
def robot_of(name: str) -> Robot:
    return arms.random_chain(np.random.default_rng(3), "rrrrrr") if name == "random" else open_robot(name)


@cache
def covered(name: str, corank: int = 1) -> Covering:
    return covering(robot_of(name), WIDTH if corank == 1 else WIDTH / 2, corank=corank)


def hashed(found: Covering) -> str:
    return digest(found.plan, found.tree)


def singular(name: str, corank: int = 1, starts: int = 3000):
    found = search(robot_of(name), corank=corank, starts=starts, seed=5, threads=1)
    return found.q[(np.asarray(found.outcome) == 0) & (found.sigma[:, -corank] < 1e-9)]


def borders(found: Covering, q, free, rng):
    """Configurations with free joints moved onto borders of boxes, and a rounding beside them."""
    plan = found.plan
    q = q.copy()
    for j in free:
        if j + 1 not in plan.variables:
            continue
        at = plan.variables.index(j + 1)
        cells = found.tree.shape.cells(found.tree.shape.levels)[at]
        border = plan.lower[at] + rng.integers(0, cells + 1, len(q)) * ((plan.upper[at] - plan.lower[at]) / cells)
        q[:, j] = border + rng.choice([-1e-15, 0.0, 1e-15], len(q))
    return q


@pytest.mark.parametrize("name", ["ur5", "puma560", "random"])
def test_singular_configurations_lie_in_boxes(name):
    q = singular(name)
    assert len(q) > 1000
    assert covered(name).holds(q).all()
    inside = covered(name).holds(np.random.default_rng(0).uniform(-np.pi, np.pi, (20_000, 6)))
    assert inside.mean() == pytest.approx(1 - covered(name).free_share, abs=0.015)
    assert 0.3 < covered(name).free_share < 0.7


@pytest.mark.parametrize("name", ["ur5", "puma560"])
def test_members_of_families_on_the_borders_of_boxes_lie_in_boxes(name):
    robot, rng = robot_of(name), np.random.default_rng(8)
    task = resolve_task(None, robot)
    for family in known_analysis(robot, task).families:
        q = members(robot, task, family, 300)
        assert len(q) >= 50
        free = [j - 1 for j in family.free]
        for made in (q, borders(covered(name), q, free, rng), borders(covered(name), q, free[::2], rng)):
            assert covered(name).holds(made).all(), family.id


@pytest.mark.by_hand
@pytest.mark.parametrize(("name", "corank"), [("ur5", 2), ("puma560", 2), ("anthropomorphic", 3)])
def test_configurations_of_a_higher_corank_lie_in_fewer_boxes(name, corank):
    """Drawn exactly, members of the families known, and those moved onto the borders of boxes."""
    robot, found, rng = robot_of(name), covered(name, corank), np.random.default_rng(12)
    task = resolve_task(None, robot)
    assert found.complete
    assert found.plan.method == "enclosures"
    q = search(robot, corank, starts=200, method="reciprocal", seed=4).q
    assert found.holds(q).all()
    families = [one for one in known_analysis(robot, task).families if one.corank >= corank]
    assert families
    for family in families:
        made = members(robot, task, family, 60)
        for some in (made, borders(found, made, [j - 1 for j in family.free], rng)):
            assert found.holds(some).all(), family.id
    assert found.free_share > 0.97
    assert found.tree.proven_leaves == 0


def test_members_pushed_to_corners_lie_in_boxes():
    # singular points of the random arm: two joints on borders, the others solved again along f = 0
    robot, found, rng = robot_of("random"), covered("random"), np.random.default_rng(9)
    q = borders(found, singular("random"), [1, 2, 3], rng)
    for _ in range(20):  # the fifth joint takes up the rest
        f = _determinant(robot, q)
        slope = (_determinant(robot, q + 1e-6 * np.eye(6)[4]) - f) / 1e-6
        q[:, 4] -= np.clip(f / slope, -0.3, 0.3)
    on = np.abs(_determinant(robot, q)) < 1e-13
    assert on.sum() > 500
    assert found.holds(q[on]).all()


def _determinant(robot: Robot, q):
    return np.linalg.det(jacobian(robot, q))


@pytest.mark.parametrize("name", ["ur5", "puma560", "random"])
def test_what_is_left_out_has_one_sign_and_what_is_proven_has_two(name):
    robot, found, rng = robot_of(name), covered(name), np.random.default_rng(10)
    tree = found.tree
    for cells, proven in tree.parts():
        centre, half = found.boxes(cells[proven][:: max(1, proven.sum() // 300)])
        q = np.zeros((len(centre), 4000 // 10, 6))
        q[:, :, 1:5] = centre[:, None] + half * np.sign(rng.uniform(-1, 1, (len(centre), 400, 4))) * (
            1 - rng.uniform(0, 1, (len(centre), 400, 4)) ** 3
        )
        signs = np.sign(_determinant(robot, q))
        both = (signs.max(axis=1) > 0) & (signs.min(axis=1) < 0)
        assert both.mean() > 0.97  # a corner that is barely cut is not met by chance
    every = np.stack(np.meshgrid(*[np.arange(16)] * 4, indexing="ij"), axis=-1).reshape(-1, 4).astype(np.int32)
    centre, half = found.boxes(every)
    q = np.zeros((len(every), 6))
    q[:, 1:5] = centre
    free = ~found.holds(q)
    assert free.sum() == 16**4 - tree.leaves
    some = rng.choice(np.flatnonzero(free), 300, replace=False)
    q = np.zeros((300, 200, 6))
    q[:, :, 1:5] = centre[some][:, None] + half * rng.uniform(-1, 1, (300, 200, 4))
    signs = np.sign(_determinant(robot, q))
    assert (signs == signs[:, :1]).all()


@pytest.mark.slow
def test_the_bytes_do_not_depend_on_threads_or_lanes():
    robot = robot_of("ur5")
    usual = hashed(covered("ur5"))
    assert hashed(covering(robot, WIDTH, threads=2)) == hashed(covering(robot, WIDTH, threads=1)) == usual
    chosen = _core.instruction_set()
    try:
        for name in _core.instruction_sets():
            assert _core.choose_instruction_set(name)
            assert hashed(covering(robot, WIDTH, threads=1)) == usual
    finally:
        _core.choose_instruction_set(chosen)


def test_an_interrupted_covering_tells_what_is_done():
    def stop(label: str, done: int, total: int) -> None:
        if done >= total // 3:
            raise KeyboardInterrupt

    part = covering(robot_of("ur5"), WIDTH, report=stop)
    assert (part.complete, part.stopped) == (False, CoveringEnd.INTERRUPTED)
    assert 0.3 < part.tree.finished.mean() < 0.5
    assert part.free_share < covered("ur5").free_share
    assert part.holds(np.random.default_rng(1).uniform(-np.pi, np.pi, (2000, 6))).mean() > 0.6


@pytest.mark.by_hand
@pytest.mark.slow_at("almarkhi4-0.1", "ur5-0.4")
@pytest.mark.parametrize(("name", "width"), [("ur5", WIDTH), ("almarkhi4", 0.1)])
def test_an_interrupted_command_goes_on_to_the_same_file(name, width, tmp_path, monkeypatch):
    robot, out, calls = open_robot(name), tmp_path / "half", []

    def stop(label: str, done: int, total: int) -> None:
        if done > total // 3:
            raise KeyboardInterrupt

    some = cover(robot, width=width, out=out, explain=False, report=stop)
    assert (some.complete, some.covering.stopped) == (False, CoveringEnd.INTERRUPTED)
    assert some.to_dict()["stopped"] == "interrupted"
    assert 0.3 < some.covering.tree.finished.mean() < 0.5
    assert not out.exists()
    journal = tmp_path / "half.parts" / "journal"
    journal.write_bytes(journal.read_bytes()[:-20])  # the last line was cut off
    there = progress_of(tmp_path / "half.parts")
    assert how_far(tmp_path / "half") == there.sentence
    assert (there.kind, there.chunks) == ("covering", 64)
    monkeypatch.setattr("rankdrop.verbs.covering._QUICK", 0)  # the rest by processes
    monkeypatch.setattr("rankdrop.verbs.covering._QUICK_BY_ENCLOSURES", 0)
    whole = cover(robot, width=width, out=out, explain=False, threads=2, report=lambda *told: calls.append(told[1]))
    assert calls == list(range(there.done, there.chunks + 1))
    assert os.listdir(tmp_path) == ["half"]
    usual = covering(robot, width)
    assert whole.sha256 == digest(usual.plan, usual.tree) == cover(robot, width=width, out=out).sha256
    assert (whole.covering.tested, whole.covering.freed) == (usual.tested, usual.freed)


@pytest.mark.by_hand
def test_a_killed_command_goes_on_to_the_same_file(tmp_path):
    # killed in the middle by itself: nothing is flushed on the way out
    code = (
        "import os, sys, rankdrop\n"
        "from rankdrop.verbs import cover\n"
        "def tell(label, done, total):\n"
        "    if done > total // 2 and sys.argv[2] == 'kill': os.kill(os.getpid(), 9)\n"
        "cover(rankdrop.open_robot('puma560'), width=0.2, out=sys.argv[1], explain=False, report=tell)\n"
    )
    run = lambda name, how: subprocess.run([sys.executable, "-c", code, str(tmp_path / name), how]).returncode  # noqa: E731
    assert run("a", "kill") == -9
    assert len(os.listdir(tmp_path / "a.parts" / "parts")) > 30
    assert not (tmp_path / "a").exists()
    assert run("a", "go on") == 0
    assert run("b", "once") == 0
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert sorted(os.listdir(tmp_path)) == ["a", "b"]


def test_a_file_is_read_back_and_a_changed_one_refused(tmp_path):
    found, path = covered("puma560"), tmp_path / "puma.cover"
    write_covering(path, found)
    again = load_covering(path)
    assert (again.plan, again.tested, again.freed) == (found.plan, found.tested, found.freed)
    assert b"".join(again.tree.payload()) == b"".join(found.tree.payload())
    assert load_covering(path, replace(found.plan, width=0.3)) is None
    raw = path.read_bytes()
    assert len(raw) < 60_000
    head = raw.index(b"\n", 30) + 1
    flipped = raw[: head + 30] + bytes([raw[head + 30] ^ 1]) + raw[head + 31 :]
    for changed in (raw[: head + 40], raw[:-1], flipped, b"x" + raw[1:],
                    raw.replace(b'"width": 0.4', b'"width": 0.3'), raw.replace(b'"tested": ', b'"tasted": ')):
        path.write_bytes(changed)
        with pytest.raises(ResultFileError):
            load_covering(path)


def test_parts_of_another_covering_are_refused(tmp_path):
    def stop(label: str, done: int, total: int) -> None:
        raise KeyboardInterrupt

    out = tmp_path / "x"
    assert not cover(open_robot("planar3r"), width=0.1, out=out, report=stop).complete
    for arm, how in (("planar3r", {"corank": 2}), ("planar3r", {"width": 0.2}), ("almarkhi4", {"width": 0.5})):
        with pytest.raises(ResultFileError, match="another job"):
            cover(open_robot(arm), **({"width": 0.1} | how), out=out)
    assert cover(open_robot("planar3r"), width=0.1, out=out, explain=False).complete


def test_chunks_are_kept_to_the_bit_and_damaged_ones_refused():
    robot = open_robot("almarkhi4")
    plan = plan_of(robot, 0.2)
    made = chunk_of(robot, resolve_task(None, robot), plan, 20)
    content = batch_to_bytes(made)
    masks, sizes, tested, freed = batch_from_bytes(content, plan.shape)
    assert len(masks) > 10
    np.testing.assert_array_equal(masks, made[0])
    np.testing.assert_array_equal(sizes, made[1])
    assert (tested, freed) == made[2:]
    for other in (content[:-1], content[:20], content + b"x"):
        with pytest.raises(ValueError, match="chunk"):
            batch_from_bytes(other, plan.shape)


@pytest.mark.by_hand_at("0", "2")
@pytest.mark.slow
@pytest.mark.slow_at("0")
@pytest.mark.parametrize("halvings", [0, 1, 2])
def test_no_place_of_an_explained_part_is_farther_from_a_family_than_a_diagonal_of_a_leaf(halvings):
    robot = robot_of("puma560")
    task, found = resolve_task(None, robot), covered("puma560", 2)
    families = [one for one in known_analysis(robot, task).families if one.corank >= 2]
    explainer = FamilyBoxes(found, robot, families, np.ones(6), halvings)
    leaves = np.concatenate([cells for cells, _ in found.tree.parts()])
    rng = np.random.default_rng(2)
    parts = (rng.permutation(leaves)[:300] << halvings) + rng.integers(0, 1 << halvings, (300, 4), dtype=np.int32)
    q = np.zeros((len(parts), 6))
    q[:, explainer.place] = explainer.low + (parts + 0.5) * explainer.width
    far = distances(families, robot, q, task).distance.min(axis=1) + np.linalg.norm(explainer.width) / 2
    whole = 2 * np.linalg.norm(found.boxes(leaves[:1])[1])
    near = explainer.families_of(parts) >= 0
    assert (far[near] <= whole + 1e-6).all()
    assert far[near].max() > 0.9 * whole
    assert (far[~near] > 0.999 * whole).mean() > 0.95  # of one in forty the walk found no point
    assert (~near).sum() > 5


@pytest.mark.slow
def test_boxes_between_families_that_almost_touch_are_free_when_halved_long_enough():
    """σ5 of the PUMA 560 is below 0.006 for 0.13 rad around: eight boxes of two of sixteen such places."""
    robot = robot_of("puma560")
    task = resolve_task(None, robot)
    found = put_together(plan_of(robot, 0.05, corank=2), {})
    families = [one for one in known_analysis(robot, task).families if one.corank >= 2]
    scale = joint_scale(robot, task)
    places = [[1, 96, 2, 0], [2, 96, 2, 0], [2, 96, 3, 0], [3, 96, 2, 0]]
    cells = np.array([*places, *([a, b, c + 64, d] for a, b, c, d in places)], dtype=np.int32)
    judged, by = classify_boxes(
        robot, task, found, cells, threads=1,
        near=lambda parts, halvings: FamilyBoxes(found, robot, families, scale, halvings).families_of(parts),
    )  # fmt: skip
    assert set(judged.tolist()) <= {0, 3}
    assert ((by >= 0) == (judged == 3)).all()


@pytest.mark.by_hand
def test_boxes_between_families_that_almost_touch_are_explained_by_the_parts_that_are_left():
    found = cover(robot_of("puma560"), width=0.1, corank=2)
    assert found.holds
    assert found.account.diagonal == pytest.approx(2 * np.linalg.norm(found.covering.boxes(np.zeros((1, 4), int))[1]))


@pytest.mark.by_hand_at("stanford")
@pytest.mark.slow_at("stanford")
@pytest.mark.parametrize("name", ["planar3r", "almarkhi4", "anthropomorphic", "stanford"])
def test_other_arms_are_covered_by_enclosures(name):
    robot = open_robot(name)
    found = covering(robot, 0.3 if robot.n < 6 else 0.4, limits=name == "stanford")
    assert found.complete
    q = search(robot, corank=1, starts=800, seed=5, threads=1, limits=name == "stanford")
    q = q.q[np.asarray(q.outcome) == 0]
    assert len(q) > 300
    assert found.holds(q).all()
    assert found.free_share > (0.2 if robot.n < 6 else 0.02)
    if name in ("planar3r", "anthropomorphic"):
        assert found.tree.proven_leaves > 0.5 * found.tree.leaves
    assert hashed(covering(robot, found.plan.width, limits=found.plan.limits, threads=1)) == hashed(found)


@pytest.mark.slow
def test_a_covering_by_enclosures_agrees_with_the_split_one(monkeypatch):
    robot = robot_of("ur5")
    monkeypatch.setattr(module, "_splits", lambda *_: False)
    other = covering(robot, 0.8)
    monkeypatch.undo()
    found = covering(robot, 0.8)
    # a box that one of them proves to hold a singularity is free for neither
    for one, two in ((found, other), (other, found)):
        for cells, proven in one.tree.parts():
            q = np.zeros((int(proven.sum()), 6))
            q[:, 1:5] = one.boxes(cells[proven])[0]
            assert two.holds(q).all()
    assert found.free_share >= other.free_share


def test_boxes_are_the_same_however_few_are_halved_at_one_go(monkeypatch):
    """All boxes of a level were in memory together: 2.3 GB for a Panda."""
    robot = open_robot("ur5")
    task = resolve_task(None, robot)
    plan = plan_of(robot, 0.4, corank=2)
    chunks = range(8)
    whole = [chunk_of(robot, task, plan, chunk, threads=1) for chunk in chunks]
    largest, children = 0, type(plan.shape).children

    def seen(shape, cells, masks, level):
        nonlocal largest
        largest = max(largest, len(cells))
        return children(shape, cells, masks, level)

    monkeypatch.setattr(module, "_AT_ONCE", 7)
    monkeypatch.setattr(type(plan.shape), "children", seen)
    for chunk, (masks, sizes, tested, freed) in zip(chunks, whole, strict=True):
        again = chunk_of(robot, task, plan, chunk, threads=1)
        assert np.array_equal(again[0], masks)
        assert np.array_equal(again[1], sizes)
        assert again[2:] == (tested, freed)
    assert sum(len(one[0]) for one in whole) > 50
    assert largest <= max(7, -(-plan.shape.trees // module.chunks_of(plan)))


@pytest.mark.slow_at("ur5-0.4-2")
@pytest.mark.slow_at("stanford-0.3-1")
@pytest.mark.parametrize(("name", "width", "corank"), [("scara", 0.05, 1), ("stanford", 0.3, 1), ("ur5", 0.4, 2)])
def test_the_work_is_estimated_before_it_is_done(name, width, corank):
    robot = open_robot(name)
    task = resolve_task(None, robot)
    plan = plan_of(robot, width, corank=corank, limits=True)
    tested = sum(chunk_of(robot, task, plan, chunk, threads=1)[2] for chunk in range(module.chunks_of(plan)))
    told = [module.estimate(robot, task, plan, seed=seed) for seed in range(6)]
    assert np.mean(told) == pytest.approx(tested, rel=0.1)
    assert np.abs(np.array(told) / tested - 1).max() < 0.35


def test_limits_narrow_what_is_covered():
    robot = robot_of("puma560")
    joints = [replace(joint, lower=-0.3 * (i + 1), upper=1.0) for i, joint in enumerate(robot.joints)]
    narrow = Robot("narrow", tuple(joints), robot.home)
    found = covering(narrow, 0.1, limits=True)
    assert found.plan.lower == tuple(one.lower for one in joints[1:5])
    assert not any(found.plan.turns)
    assert found.tree.shape.depth == (4, 5, 5, 5)
    q = search(narrow, corank=1, starts=2000, limits=True, threads=1)
    q = q.q[np.asarray(q.outcome) == 0]
    assert len(q) > 500
    assert found.holds(q).all()
    free = np.random.default_rng(2).uniform(found.plan.lower, found.plan.upper, (2000, 4))
    free = np.pad(free, ((0, 0), (1, 1)))
    free = free[~found.holds(free)]
    assert len(free) > 500
    for joint in range(1, 5):  # outside the limits, be it of one joint, nothing is known
        outside = free.copy()
        outside[:, joint] = joints[joint].upper + 0.1
        assert found.holds(outside).all()
    assert found.holds(np.full((1, 6), 3.0)).all()


@pytest.mark.slow
def test_a_closer_look_frees_leaves_and_never_those_that_hold_a_singularity():
    freed = 0
    for name, width in (("random", 1.6), ("almarkhi4", 0.4)):
        robot = robot_of(name)
        found = covering(robot, width)
        for cells, proven in found.tree.parts():
            told, *_ = classify_boxes(robot, resolve_task(None, robot), found, cells)
            assert (told[proven] == 1).all()
            freed += int((told == 0).sum())
            q = np.zeros((len(cells), robot.n))
            q[:, np.array(found.plan.variables) - 1] = found.boxes(cells)[0]
            points = singular(name)
            half = found.boxes(cells)[1]
            place = np.array(found.plan.variables) - 1
            for centre in q[told == 0][:: max(1, int((told == 0).sum()) // 200)]:
                gap = np.abs((points[:, place] - centre[place] + np.pi) % (2 * np.pi) - np.pi)
                assert not (gap <= half * (1 - 1e-9)).all(axis=1).any()
    assert freed > 10


@pytest.mark.slow
def test_what_cannot_be_covered_is_refused():
    kinds = [JointKind.PRISMATIC] * 3
    gantry = Robot("gantry", tuple(Joint(f"j{i}", kind, np.eye(6)[i]) for i, kind in enumerate(kinds)), task="position")
    for robot, width, match in (
        (open_robot("ur5"), 0.001, "width"), (open_robot("ur5"), np.nan, "width"),
        (open_robot("fetch8"), 0.5, "too many joints"), (_unlimited(open_robot("stanford")), 0.5, "limits"),
        (gantry, 0.5, "without limits"),
    ):  # fmt: skip
        with pytest.raises(OptionError, match=match):
            covering(robot, width)
    for corank in (0, 7, True, 1.5):
        with pytest.raises(OptionError, match="corank"):
            covering(open_robot("ur5"), 0.5, corank=corank)


def _unlimited(robot: Robot) -> Robot:
    return Robot("free", tuple(replace(joint, lower=-np.inf, upper=np.inf) for joint in robot.joints), robot.home)


@pytest.mark.parametrize(("end", "words"), [(CoveringEnd.INTERRUPTED, " (interrupted)"),
    (CoveringEnd.BUDGET_SPENT, " (the budget is spent: about 90 enclosures are needed at this width)"),
    (CoveringEnd.BUDGET_TOO_SMALL, " (budget too small: about 90 enclosures are needed at this width)"),
    (None, "")])  # fmt: skip
def test_why_a_covering_ended_is_said_in_its_sentence(end, words):
    found = cover(open_robot("planar2r"), width=1.0, explain=False)
    tree = replace(found.covering.tree, finished=np.zeros_like(found.covering.tree.finished))
    part = replace(found, covering=replace(found.covering, tree=tree, stopped=end, needed=90))
    assert part.sentence.startswith(f"Not complete{words}: 0.0 % of the joint space")


def test_two_processes_do_not_make_one_file(tmp_path):
    """The second is refused in one line while the first is at work; the lock ends with it."""
    robot, out = open_robot("planar3r"), tmp_path / "one.cover"
    seen = []

    def second(label: str, done: int, total: int) -> None:
        if not seen:
            seen.append(done)
            with pytest.raises(ResultFileError, match=r"another process is working on this"):
                cover(robot, width=0.1, out=out, explain=False)

    assert cover(robot, width=0.1, out=out, explain=False, report=second).complete
    assert seen
    assert os.listdir(tmp_path) == ["one.cover"]
    assert cover(robot, width=0.1, out=out, explain=False).complete


def test_a_lock_that_its_process_left_behind_is_none(tmp_path):
    (tmp_path / "one.cover.lock").write_bytes(b"")  # kill -9: the file is there, the lock is not
    assert cover(open_robot("planar3r"), width=0.1, out=tmp_path / "one.cover", explain=False).complete


def plan_of_boxes(depth: int, variables: int = 4) -> Any:
    plan = covering(open_robot("planar3r"), 0.4).plan
    return replace(plan, variables=(1, 2, 3, 4)[:variables], lower=(0.0,) * variables, upper=(6.3,) * variables,
                   turns=(True,) * variables, depth=(depth,) * variables, top=0)  # fmt: skip


@pytest.mark.by_hand
def test_a_file_that_unpacks_to_too_much_is_refused_before_it_does(tmp_path):
    """A megabyte of the same byte: two thousand megabytes of boxes, all of which the plan has room for."""
    import tracemalloc

    plan = plan_of_boxes(9)
    head = {"plan": plan.entries(), "sha256": "0" * 64, "tested": 0, "freed": 0, "leaves": 1}
    stream = zlib.compressobj(9)
    packed = b"".join([stream.compress(b"\x01"), *(stream.compress(b"\xff" * (1 << 22)) for _ in range(200)),
                       stream.flush()])  # fmt: skip
    path = tmp_path / "bomb.cover"
    path.write_bytes(MAGIC + json.dumps(head).encode() + b"\n" + packed)
    assert len(packed) < 1_000_000
    tracemalloc.start()
    with pytest.raises(ResultFileError, match="more boxes than a file of this size holds"):
        load_covering(path)
    assert tracemalloc.get_traced_memory()[1] < 6e8
    tracemalloc.stop()
    assert how_far(path) == f"finished: 1 boxes in {path}"  # from the head alone


def test_a_covering_so_regular_that_it_packs_like_a_bomb_is_read_back(tmp_path, monkeypatch):
    """All boxes left: 2 bytes of masks for 16 boxes, the same everywhere."""
    monkeypatch.setattr("rankdrop.proof.boxes._SMALL", 0)
    plan = plan_of_boxes(5)
    shape = plan.shape
    masks = tuple(np.full(int(np.prod(shape.cells(level))), 0xFFFF, shape.kind) for level in range(shape.levels))
    roots = np.ones(1, dtype=bool)
    found = Covering(plan, BitTree(shape, roots, roots, masks, np.zeros_like(masks[-1])), 0, 0)
    write_covering(tmp_path / "all.cover", found)
    again = load_covering(tmp_path / "all.cover")
    assert again.tree.leaves == shape.leaves
    assert (tmp_path / "all.cover").stat().st_size > shape.largest / 200
    assert again.tree.free_boxes == 0
