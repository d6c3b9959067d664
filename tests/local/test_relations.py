"""Axes that coincide, are parallel or meet: told once, in the largest groups, what is special to q first."""

from __future__ import annotations

import numpy as np
import pytest
from local.related import relation_words
from reference import arms

from rankdrop.errors import ConfigurationError
from rankdrop.local.relations import relations_at
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, prismatic, revolute


@pytest.mark.parametrize(("theta", "words"), [(0.0, "axes 2, 3, 4, 6 parallel"), (np.pi, "axes 2, 3, 4, 6 parallel")])
def test_what_is_special_stands_first(theta: float, words: str) -> None:
    found = relations_at(open_robot("ur5"), [0.1, -0.5, 0.7, 0.3, theta, 0.2])
    assert relation_words(found)[0] == (False, words)
    assert [relation.structural for relation in found] == sorted(relation.structural for relation in found)


def test_a_structural_pair_inside_a_special_group_is_not_repeated() -> None:
    words = [text for _, text in relation_words(relations_at(open_robot("puma560"), [0.1, 0.2, 0.3, 0.0, 0.7, 0.6]))]
    assert "axes 2, 3, 5 parallel" in words
    assert "axes 2, 3 parallel" not in words


def test_the_tolerance_is_that_of_angles() -> None:
    robot = open_robot("puma560")
    near = [0.1, 0.2, 0.3, 0.4, 1e-4, 0.6]
    assert (False, "axes 4, 6 aligned") not in relation_words(relations_at(robot, near))
    assert (False, "axes 4, 6 aligned") in relation_words(relations_at(robot, near, tolerance=1e-3))


def test_slides_have_a_direction_but_no_place() -> None:
    robot = from_screws(
        [revolute((0, 0, 1), (0, 0, 0)), prismatic((0, 0, 1)), revolute((0, 0, 1), (1, 0, 0)), prismatic((1, 0, 0))],
        order="linear-first",
    )
    assert relation_words(relations_at(robot, np.zeros(4))) == [(True, "axes 1, 3 and slide 2 parallel")]


def test_planted_groups_against_all_pairs(rng: np.random.Generator) -> None:
    """Every pair of axes that coincides, is parallel or meets is inside a group of that kind or a stronger one."""
    met = 0
    for _ in range(20):
        axes = rng.integers(-1, 2, (6, 3)).astype(float)
        axes[~axes.any(axis=1), 2] = 1.0
        points = rng.integers(-1, 2, (6, 3)).astype(float)
        robot = from_screws([revolute(a, p) for a, p in zip(axes, points, strict=True)], order="linear-first")
        found = relations_at(robot, np.zeros(6))
        for i in range(6):
            for j in range(i + 1, 6):
                both = {i + 1, j + 1}
                kinds = {relation.kind for relation in found if both <= set(relation.joints)}
                skew = np.cross(axes[i], axes[j])
                if np.abs(skew).max() < 1e-12:
                    line = np.abs(np.cross(points[j] - points[i], axes[i])).max() < 1e-12
                    assert "aligned" in kinds if line else "parallel" in kinds
                else:
                    meet = bool(abs((points[j] - points[i]) @ skew) < 1e-12)
                    assert bool(kinds & {"intersecting", "concurrent"}) == meet
                    met += meet
    assert met > 50


@pytest.mark.parametrize("name", ["pa10", "rcrrrr", "stanford"])
def test_relations_do_not_depend_on_base_tool_or_sign(name: str, rng: np.random.Generator) -> None:
    robot = open_robot(name)
    q = np.zeros(robot.n)
    expected = relation_words(relations_at(robot, q))
    for same in arms.in_other_words(robot, rng):
        assert relation_words(relations_at(same, q)) == expected
    back = arms.reversed_chain(robot)
    mirrored = {(r.kind, tuple(sorted(robot.n + 1 - i for i in r.joints)), r.structural) for r in relations_at(back, q)}
    assert mirrored == {(r.kind, r.joints, r.structural) for r in relations_at(robot, q)}


def test_one_configuration_is_needed() -> None:
    with pytest.raises(ConfigurationError):
        relations_at(open_robot("pa10"), np.zeros((2, 7)))
