"""Screw systems that stay dependent: planted ones are found and named, and motion bears them out."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from math import pi

import numpy as np
import pytest
from local.screws import C, Z, concurrent, other, parallel, slides
from reference import arms

from rankdrop.kinematics import jacobian
from rankdrop.local.block import generic_rank
from rankdrop.local.screw_systems import ScrewSystem, always_singular_reason, systems_at
from rankdrop.local.subgroups import closure
from rankdrop.robot.model import Array, Mimic, Robot
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.robot.screws import from_screws, helical, prismatic, revolute
from rankdrop.task import SPACE, resolve_task


def built(*screws: Array) -> Robot:
    home = np.eye(4)
    home[:3, 3] = (0.9, 0.4, 1.3)
    return from_screws(screws, order="linear-first", home=home)


def rank(robot: Robot, q: Array, numbers: tuple[int, ...]) -> int:
    columns = jacobian(robot, q)[:, [number - 1 for number in numbers]]
    return int(np.linalg.matrix_rank(columns, tol=1e-9))


PLANTED = [
    (built(*other(2), *concurrent(4), *other(1, 9)), (3, 4, 5, 6), "spherical", 3),
    (built(*other(1), *parallel(4), *other(2, 9)), (2, 3, 4, 5), "planar", 3),
    (built(*other(1), *parallel(2), prismatic((1, 2, 0)), *parallel(1, 9), *other(2, 9)), (2, 3, 4, 5), "planar", 3),
    (built(*parallel(2), prismatic(Z), *parallel(2, 9), *other(2, 9)), (1, 2, 4, 5), "planar", 3),
    (built(*other(2), *slides(4), *other(2, 9)), (3, 4, 5, 6), "translational", 3),
    (built(*slides(2), *other(1), *slides(2, 9), *other(3, 9)), (1, 2, 4, 5), "translational", 3),
    (built(*other(1), *(prismatic((1, x, 0)) for x in (0, 1, 3)), *other(3, 9)), (2, 3, 4), "translational", 2),
    (built(*other(2), prismatic(Z), prismatic(Z), *other(3, 9)), (3, 4), "translational", 1),
    (built(*other(2), revolute(Z, C), prismatic(Z), revolute(Z, C), *other(2, 9)), (3, 5), "coaxial", 1),
    (built(*other(2), revolute(Z, C), helical(Z, C, 0.2), prismatic(Z), *other(2, 9)), (3, 4, 5), "cylindrical", 2),
    (built(*parallel(3), *slides(1), helical(Z, C, 0.2), *other(2, 9)), (1, 2, 3, 4, 5), "Schönflies", 4),
    (built(*(helical(Z, p, 0.2) for p in np.eye(3)), prismatic((1, 1, 0)), *other(2)), (1, 2, 3, 4),
     "planar with a screw", 3),
]  # fmt: skip


@pytest.mark.parametrize(("robot", "numbers", "kind", "dimension"), PLANTED)
def test_a_planted_system_is_found_at_every_configuration(
    robot: Robot, numbers: tuple[int, ...], kind: str, dimension: int, rng: np.random.Generator
) -> None:
    for q in [np.zeros(robot.n), *rng.uniform(-pi, pi, (5, robot.n))]:
        found = {(s.numbers, s.kind): s for s in systems_at(robot, q)}
        assert (numbers, kind) in found
        system = found[numbers, kind]
        assert system.permanent
        assert system.structural
        assert system.dimension == dimension
        assert system.consecutive is (numbers[-1] - numbers[0] == len(numbers) - 1)
        assert system.loss == len(numbers) - dimension
        assert "dependent at every configuration" in system.words
        assert rank(robot, q, numbers) <= dimension


def test_a_line_met_again_after_turning_about_a_parallel_one_is_special() -> None:
    """Equal links folded: axes 1 and 3 on one line here, and apart when joint 2 moves."""
    robot = built(*(revolute(Z, (x, 0, 0)) for x in (0, 1, 0)), *other(3))
    found = systems_at(robot, np.zeros(6))
    assert [(s.numbers, s.kind, s.structural) for s in found] == [
        ((1, 3), "coaxial", False), ((1, 2, 3), "planar", True)
    ]  # fmt: skip


def test_parallel_screws_of_two_pitches_are_not_a_planar_system() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 2, 0]])
    robot = built(*(helical(Z, p, h) for p, h in zip(points, (0.2, 0.2, 0.2, 0.5), strict=True)), *other(2))
    assert [(s.numbers, s.kind, s.permanent) for s in systems_at(robot, np.zeros(6))] == [
        ((1, 2, 3, 4), "Schönflies", False)
    ]


def test_all_kinds_are_planted() -> None:
    assert len({(kind, dimension) for _, _, kind, dimension in PLANTED}) == 9


@pytest.mark.parametrize("name", ["pa10", "iiwa14", "fetch8", "ur5", "puma560", "stanford", "scara", "canadarm2"])
def test_motion_bears_out_what_is_said_at_the_zero_pose(name: str, rng: np.random.Generator) -> None:
    """Own joints never break a system; where the words say "here", some joint in between does."""
    robot = open_robot(name)
    for system in systems_at(robot, np.zeros(robot.n)):
        own = np.isin(np.arange(1, robot.n + 1), system.numbers)
        for _ in range(5):
            q = np.where(own, rng.uniform(-pi, pi, robot.n), 0.0)
            assert rank(robot, q, system.numbers) <= system.dimension
        anywhere = rank(robot, rng.uniform(-pi, pi, robot.n), system.numbers)
        assert (anywhere <= system.dimension) is system.structural or len(system.numbers) <= system.dimension
        assert system.permanent is (system.structural and len(system.numbers) > system.dimension)


def test_of_a_scara_the_whole_is_told_and_not_its_parts() -> None:
    found = systems_at(open_robot("scara"), np.zeros(4))
    assert [(s.numbers, s.kind, s.permanent) for s in found] == [((1, 2, 3, 4), "Schönflies", False)]


def overfull_runs(robot: Robot, q: Array) -> list[tuple[int, ...]]:
    """Runs with more joints than the proper algebra they generate has dimensions, by brackets alone."""
    screws = jacobian(robot, q, SPACE).T
    runs = [tuple(range(a, b)) for a, b in combinations(range(robot.n + 1), 2) if b - a > 1]
    return [run for run in runs if len(closure(screws[list(run)])) < min(6, len(run))]


def orthogonal_chain(rng: np.random.Generator) -> Robot:
    """Axes along X, Y, Z through points of a small grid, and slides: every system turns up by chance."""
    axes = np.eye(3)[rng.integers(0, 3, int(rng.integers(4, 8)))]
    points = rng.integers(0, 2, (len(axes), 3)).astype(float)
    return built(*(prismatic(a) if rng.random() < 0.3 else revolute(a, p) for a, p in zip(axes, points, strict=True)))


@pytest.mark.slow
def test_every_overfull_run_has_a_permanent_system(rng: np.random.Generator) -> None:
    """Coverage: what brackets find, without knowing any subgroup by name, is told."""
    met = 0
    for robot in [*(robot for robot, *_ in PLANTED), *(orthogonal_chain(rng) for _ in range(60))]:
        q = rng.uniform(-1, 1, robot.n)
        permanent = [s for s in systems_at(robot, q) if s.permanent]
        for run in overfull_runs(robot, q):
            joints, dimension = {i + 1 for i in run}, len(closure(jacobian(robot, q, SPACE).T[list(run)]))
            around = [s for s in permanent if joints <= set(s.numbers) and s.dimension <= dimension]
            assert around or any(set(s.numbers) <= joints for s in permanent), run
            met += 1
    assert met > 60


def test_structural_means_at_every_configuration_and_permanent_dependent_there(rng: np.random.Generator) -> None:
    permanent = special = 0
    for robot in (orthogonal_chain(rng) for _ in range(60)):
        for system in systems_at(robot, np.zeros(robot.n)):
            members = [number - 1 for number in system.numbers]
            dimensions = []
            for q in rng.uniform(-pi, pi, (2, robot.n)):
                dimensions.append(len(closure(jacobian(robot, q, SPACE).T[members])))
                assert not system.permanent or rank(robot, q, system.numbers) <= system.dimension
            assert system.structural is (max(dimensions) <= system.dimension), (system, dimensions)
            permanent += system.permanent
            special += not system.structural
    assert permanent > 20
    assert special > 20


@pytest.mark.slow
def test_catalogue_arms_have_no_system_that_is_dependent_for_ever() -> None:
    for name in robot_names():
        robot = open_robot(name)
        assert not [s for s in systems_at(robot, np.linspace(0.1, 0.9, robot.n)) if s.permanent]
        assert always_singular_reason(robot, resolve_task(None, robot)) is None


@pytest.mark.parametrize(("robot", "task", "told"), [
    (built(*parallel(4)), "pose", "rank 3 of 4 everywhere: joints 1–4 lie in a planar system"),
    (built(*parallel(3)), "position", "rank 2 of 3 everywhere: joints 1, 2, 3 lie in a planar system"),
    (built(*concurrent(4)), "pose", "rank 3 of 4 everywhere: joints 1–4 lie in a spherical system"),
    (built(*parallel(3), *slides(2)), "pose", "rank 4 of 5 everywhere: joints 1–5 lie in a Schönflies system"),
    (built(*parallel(2), *slides(1)), "orientation", "of dimension 4, of which this task sees 1"),
    (built(*concurrent(4), *other(2)), "pose", "rank 5 of 6 everywhere: joints 1–4 lie in a spherical system of "
     "dimension 3 and lose 1"),
    (built(revolute(Z, C), *slides(1), revolute(Z, C), *slides(4, 9), *other(1)), "pose",
     "rank 5 of 6 everywhere: joints 1–7 lie in a Schönflies system of dimension 4 and lose 3"),
    (built(prismatic((1, 0, 0)), revolute(Z, C), prismatic(Z), *(prismatic((0, 1, 0)) for _ in range(4)),
           revolute((1, 0, 0), (0, 0, 1))), "pose", "rank 5 of 6 everywhere"),
    (built(revolute(Z, C), revolute(Z, C), prismatic((1, 0, 0)), prismatic(Z)), "scara",
     "rank 3 of 4 everywhere: joints 1, 2 lie in a coaxial system of dimension 1 and lose 1"),
    (built(*slides(4), *concurrent(4)), "pose", None),
    (built(*other(1), *concurrent(4), *other(2, 9)), "pose", None),
    (built(*other(6)), "pose", None),
    (built(*other(2), revolute(Z, (0.9, 0.4, 0.0))), "position", "joint 3 moves nothing in this task"),
])  # fmt: skip
def test_why_an_arm_is_deficient_everywhere(robot: Robot, task: str, told: str | None) -> None:
    resolved = resolve_task(task, robot)
    reason = always_singular_reason(robot, resolved)
    assert (reason is None) is (generic_rank(robot, resolved) == min(resolved.m, robot.n))
    assert reason is None if told is None else told in str(reason)
    assert "accounts for" not in str(reason)


def test_a_spherical_system_that_takes_the_first_axis_in(rng: np.random.Generator) -> None:
    wrist = [revolute(axis, C) for axis in rng.normal(size=(3, 3))]
    robot = built(revolute(Z, C), *wrist, *other(1))
    reason = always_singular_reason(robot, resolve_task("pose", robot))
    assert reason is not None
    assert [loss.kind for loss in reason.losses] == ["spherical"]
    two = from_screws([revolute((1, 0, 0), (0, 0, 0)), revolute((0, 1, 0), (0, 0, 0))], order="linear-first")
    words = always_singular_reason(two, resolve_task("position", two))
    assert words is not None, "both axes through the tip: nothing moves it"


def as_told(found: tuple[ScrewSystem, ...]) -> list[tuple[object, ...]]:
    return [(s.numbers, s.kind, s.dimension, s.permanent, s.structural, s.words) for s in found]


@pytest.mark.parametrize("name", ["pa10", "stanford", "fetch8"])
def test_systems_do_not_depend_on_base_tool_or_sign(name: str, rng: np.random.Generator) -> None:
    robot = open_robot(name)
    q = np.zeros(robot.n)
    expected = as_told(systems_at(robot, q))
    for same in arms.in_other_words(robot, rng):
        assert as_told(systems_at(same, q)) == expected
    back = arms.reversed_chain(robot)
    mirrored = {(tuple(sorted(robot.n + 1 - i for i in s.numbers)), s.kind, s.permanent) for s in systems_at(back, q)}
    assert mirrored == {(s.numbers, s.kind, s.permanent) for s in systems_at(robot, q)}


def test_a_follower_goes_with_its_leader(rng: np.random.Generator) -> None:
    base = built(*parallel(4), *other(2))
    joints = list(base.joints)
    joints[1] = replace(joints[1], mimic=Mimic("joint1"))
    robot = replace(base, joints=tuple(joints))
    found = systems_at(robot, rng.normal(size=5))
    assert [(s.numbers, s.kind, s.permanent) for s in found] == [((1, 2, 3), "planar", False)]
    far = list(base.joints)
    far[5] = replace(far[5], mimic=Mimic("joint1"))  # the leader's follower turns about another axis
    split = systems_at(replace(base, joints=tuple(far)), rng.normal(size=5))
    assert [(s.numbers, s.kind) for s in split] == [((2, 3, 4), "planar")]
