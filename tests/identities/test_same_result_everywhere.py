"""The same bits from every instruction set and any number of threads."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from reference import arms
from reference import kinematics as oracle
from reference.measure import relative

from rankdrop import _core
from rankdrop.cover.ball import certified_radius
from rankdrop.cover.setting import enclose, settings_for
from rankdrop.distance.distance import family_distances
from rankdrop.distance.monitor import Monitor
from rankdrop.families.searching import METHODS, Search, search
from rankdrop.kinematics import chain_of, jacobian, jacobian_derivative, link_poses, pose, task_view
from rankdrop.local.block import block, decompose, joint_scale, singular_values
from rankdrop.results.known import shipped
from rankdrop.robot.model import Array
from rankdrop.task import BODY, Frame, resolve_task

SETS = _core.instruction_sets()


@pytest.fixture(autouse=True)
def _chosen_set_is_restored() -> Iterator[None]:
    before = _core.instruction_set()
    yield
    _core.choose_instruction_set(before)


def everything() -> list[Array]:
    """One of each result, on arms of every joint kind; 37 rows fill no set of lanes exactly."""
    results: list[Array] = []
    for kinds in ("rrrrrrr", "mrrhpmr", "rpr"):
        robot = arms.random_chain(np.random.default_rng(1), kinds)
        q = np.random.default_rng(2).uniform(-np.pi, np.pi, (37, robot.n))
        task = resolve_task("pose", robot)
        results += [pose(robot, q), jacobian(robot, q), jacobian_derivative(robot, q, Frame(1, -1))]
        parts, split = block(robot, q, task, 2), decompose(robot, q, task)
        results += [parts.f, parts.d, parts.u2, parts.v2, split.u, split.sigma, split.v, link_poses(robot, q)]
    for name in ("canadarm2", "gen3"):  # by conditions, and by the kinematics from several lanes
        found = shipped(name)
        seen = Monitor(found.robot, found.task, found.families).look(np.random.default_rng(3).uniform(-3, 3, (37, 7)))
        results += [seen.sigma, seen.family, seen.nearest, seen.residual, seen.u, seen.v, seen.distance]  # type: ignore[list-item]
    return results


def found(method: str, threads: int) -> Search:
    """A small search; the starts fill no chunk of work exactly."""
    starts = 150 if method == "lm" else 11
    return search(arms.pa10(), 2, starts=starts, seed=5, method=method, threads=threads)


def walked(kinds: str, rank: int, threads: int, limits: bool = False) -> tuple[Array, ...]:
    """Walks along the singular set from starts beside it; they fill no set of lanes and no chunk of work exactly."""
    robot = arms.pa10() if kinds == "pa10" else arms.random_chain(np.random.default_rng(4), kinds)
    task = resolve_task("pose", robot)
    scale, box = joint_scale(robot, task), np.stack([np.full(robot.n, -2.0), np.full(robot.n, 2.0)])
    starts, centre = np.random.default_rng(6).uniform(-2, 2, (150, robot.n)), np.full(robot.n, 0.4)
    chain, view = chain_of(robot), task_view(robot, task)
    within = box if limits else None
    onto = _core.SearchSettings(
        method=0, rank=rank, iterations=60, singular=1e-9, target=1e-9, stationary=1e-5, seed=0, scale=scale,
        limits=within, tie=1e-2,
    )  # fmt: skip
    along = _core.NearestSettings(
        rank=rank, evaluations=200, singular=1e-9, target=1e-13, centre=centre, scale=scale, limits=within
    )
    starts = _core.search(chain, view, starts, onto, threads=threads)[0]
    return _core.nearest(chain, view, starts, along, threads=threads)


def stepped() -> list[Array]:
    """Newton's steps to feet on the singular set, of 37 starts, and on families, whose lanes take the next start."""
    results: list[Array] = []
    for kinds in ("rrrrrrr", "rrprrr", "hrprhr", "rrrrrrrr"):
        robot = arms.random_chain(np.random.default_rng(4), kinds)
        task = resolve_task("pose", robot)
        starts, centre = np.random.default_rng(6).uniform(-2, 2, (37, robot.n)), np.full(robot.n, 0.4)
        results += _core.set_feet(
            chain_of(robot), task_view(robot, task), starts, centre=centre, scale=joint_scale(robot, task),
            turn=2 * np.pi * robot.periodic, farthest=2.0,
        )  # fmt: skip
    for name in ("gen3", "ur5"):
        known = shipped(name)
        assert known is not None
        q = np.random.default_rng(7).uniform(-2, 2, known.robot.n)
        found = family_distances(known.families, known.robot, q, known.task)
        results += [np.array([one.distance, one.residual, one.sigma, *one.q]) for one in found]
    return results


WALKS = [("rrrrrrr", 5, False), ("rrprrr", 5, True), ("mrrhpmr", 4, False), ("rrrrrrrr", 5, True), ("pa10", 3, True)]


def certified() -> list[Array]:
    """Enclosures of boxes and balls, 37 of them, and a ball by branch and bound."""
    results: list[Array] = []
    for kinds in ("rrrrrrr", "mrrhpmr", "rpr"):
        robot = arms.random_chain(np.random.default_rng(1), kinds)
        q = np.random.default_rng(2).uniform(-np.pi, np.pi, (37, robot.n))
        setting = settings_for(robot, resolve_task("pose", robot))[1]
        results += [*enclose(robot, setting, q, np.full_like(q, 0.05)), *enclose(robot, setting, q, radius=1.0)]
        found = certified_radius(robot, q[0], evaluations=300)
        results += [np.array([found.radius, found.single, found.evaluations])]
    return results


def same(a: Search, b: Search) -> None:
    """Two searches ended alike, to the last bit."""
    np.testing.assert_array_equal(a.q, b.q)
    np.testing.assert_array_equal(a.sigma, b.sigma)
    np.testing.assert_array_equal(a.outcome, b.outcome)
    np.testing.assert_array_equal(a.iterations, b.iterations)


def test_the_narrowest_set_is_always_there() -> None:
    assert SETS[:2] == ["single", "baseline"]
    assert _core.instruction_set() == SETS[-1]
    assert not _core.choose_instruction_set("no such set")


@pytest.mark.parametrize("name", SETS)
def test_every_set_equals_the_oracle(name: str, rng: np.random.Generator) -> None:
    assert _core.choose_instruction_set(name)
    robot = arms.random_chain(rng, "rrhprrr")
    q = rng.uniform(-np.pi, np.pi, (21, 7))
    assert relative(jacobian(robot, q, BODY), oracle.jacobian(robot, q, BODY)) < 1e-13
    assert relative(jacobian_derivative(robot, q), oracle.jacobian_derivative(robot, q)) < 1e-13


@pytest.mark.by_hand
@pytest.mark.slow_at("single", "baseline", "avx512", "avx2")
@pytest.mark.parametrize("name", SETS)
def test_every_set_gives_the_same_bits(name: str) -> None:
    _core.choose_instruction_set(SETS[0])
    want = everything()
    _core.choose_instruction_set(name)
    for got, expected in zip(everything(), want, strict=True):
        np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("kinds", ["rrrrrrr", "rrprrr", "rhrpr"])
def test_one_configuration_gives_the_bits_of_a_batch(kinds: str, name: str) -> None:
    """Alone, pairs of columns have lanes of their own, at singular configurations too."""
    robot = arms.random_chain(np.random.default_rng(1), kinds)
    q = np.random.default_rng(2).uniform(-np.pi, np.pi, (64, robot.n))
    q[::4], q[1::8, 1:4] = 0.0, 0.0
    for arm in (robot, arms.pa10()) if robot.n == 7 else (robot,):
        _core.choose_instruction_set(SETS[0])
        batch = decompose(arm, q)
        _core.choose_instruction_set(name)
        for row, own in enumerate(q):
            for got, expected in zip(decompose(arm, own), (batch.u, batch.sigma, batch.v), strict=True):
                np.testing.assert_array_equal(got, expected[row])
            np.testing.assert_array_equal(singular_values(arm, own), batch.sigma[row])


@pytest.mark.parametrize("name", SETS)
def test_every_set_takes_the_same_steps(name: str) -> None:
    _core.choose_instruction_set(SETS[0])
    want = stepped()
    _core.choose_instruction_set(name)
    for got, expected in zip(stepped(), want, strict=True):
        np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize("name", SETS)
def test_every_set_certifies_the_same(name: str) -> None:
    _core.choose_instruction_set(SETS[0])
    want = certified()
    _core.choose_instruction_set(name)
    for got, expected in zip(certified(), want, strict=True):
        np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize("threads", [0, 2, 3])
def test_enclosures_are_the_same_on_any_number_of_threads(threads: int) -> None:
    robot = arms.pa10()
    setting = settings_for(robot, resolve_task("pose", robot))[4]
    q = np.random.default_rng(2).uniform(-np.pi, np.pi, (333, 7))
    for got, want in zip(
        enclose(robot, setting, q, threads=threads), enclose(robot, setting, q, threads=1), strict=True
    ):
        np.testing.assert_array_equal(got, want)


@pytest.mark.slow_at("single-almarkhi", "baseline-almarkhi")
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SETS)
def test_a_search_ends_alike_on_every_set(name: str, method: str) -> None:
    _core.choose_instruction_set(SETS[0])
    want = found(method, 1)
    _core.choose_instruction_set(name)
    same(found(method, 1), want)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("threads", [0, 2, 3])
def test_a_search_ends_alike_on_any_number_of_threads(threads: int, method: str) -> None:
    same(found(method, threads), found(method, 1))


@pytest.mark.parametrize("threads", [0, 2, 3])
def test_a_monitor_sees_the_same_on_any_number_of_threads(threads: int) -> None:
    found = shipped("pa10")
    q = np.random.default_rng(4).uniform(-3, 3, (1100, 7))
    q[::3, 3] = 0.0
    monitor = Monitor(found.robot, found.task, found.families)
    one, many = monitor.look(q, threads=1), monitor.look(q, threads=threads)
    for name in ("sigma", "rank", "corank", "family", "nearest", "residual", "u", "v", "distance"):
        np.testing.assert_array_equal(getattr(many, name), getattr(one, name))


@pytest.mark.spread(8)
@pytest.mark.slow
@pytest.mark.parametrize(("kinds", "rank", "limits"), WALKS)
@pytest.mark.parametrize("name", SETS)
def test_a_walk_to_the_nearest_ends_alike_on_every_set(name: str, kinds: str, rank: int, limits: bool) -> None:
    _core.choose_instruction_set(SETS[0])
    want = walked(kinds, rank, 1, limits)
    assert np.isfinite(want[1]).sum() > 40
    _core.choose_instruction_set(name)
    for threads in (1, 3):
        for got, expected in zip(walked(kinds, rank, threads, limits), want, strict=True):
            np.testing.assert_array_equal(got, expected)


def test_more_starts_repeat_the_first_ones() -> None:
    """Start number i depends on the seed and on i alone."""
    few, many = (search(arms.pa10(), 2, starts=starts, seed=5) for starts in (40, 150))
    np.testing.assert_array_equal(many.q[:40], few.q)


KERNELS = ["Prescott", "Nehalem"]
KERNELS += [kernels for name, kernels in (("avx2", "Haswell"), ("avx2", "Zen"), ("avx512", "SkylakeX")) if name in SETS]
"""Of the linear algebra, those that this processor can run."""


@pytest.mark.by_hand
@pytest.mark.parametrize("arm", ["ur5e", "puma560"])
def test_a_result_file_has_the_same_bytes_with_every_kernel_of_the_linear_algebra(tmp_path: Path, arm: str) -> None:
    """Up to 13 numbers of `analyze --json` differed in the last digit between two processors."""
    files = []
    for kernels in KERNELS:
        path = tmp_path / f"{kernels}.json"
        words = ["analyze", arm, "--starts", "200", "--threads", "1", "--quiet", "--json", str(path)]
        subprocess.run(
            [sys.executable, "-m", "rankdrop", *words], check=True, capture_output=True,
            env={**os.environ, "OPENBLAS_CORETYPE": kernels, "OPENBLAS_NUM_THREADS": "1"},
        )  # fmt: skip
        files.append(path.read_bytes())
    assert files == files[:1] * len(KERNELS)
