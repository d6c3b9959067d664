"""The parts of an explanation: lost directions, minimal dependent sets, the way out and the next singularity."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from rankdrop.kinematics import jacobian, pose
from rankdrop.local.block import joint_scale, singular_values
from rankdrop.results.explained import Difference, DifferenceKind, Lost
from rankdrop.results.explanation import Explanation
from rankdrop.robot.open import open_robot
from rankdrop.verbs.explain import explain

WRIST = np.array([0.4, -1.1, 0.9, 0.7, 0.0, -0.3])
"""Of a UR5e: axes 4 and 6 are parallel."""


@pytest.fixture(scope="module")
def wrist() -> Explanation:
    return explain(open_robot("ur5e"), WRIST)


def test_no_joint_motion_moves_the_tool_along_a_lost_direction(wrist: Explanation) -> None:
    lost = wrist.lost
    assert len(lost.directions) == wrist.rank.corank == 1
    np.testing.assert_allclose(lost.directions @ lost.directions.T, np.eye(1), atol=1e-12)
    np.testing.assert_allclose(lost.directions @ jacobian(wrist.here.robot, WRIST), 0.0, atol=1e-9)
    np.testing.assert_allclose(abs(lost.weakest @ lost.directions[0]), 1.0, atol=1e-9)
    assert len(lost.words) == len(lost.blocked_words) == len(lost.twist_screws) == len(lost.wrench_screws) == 1
    assert lost.never.shape == (0, 6)


def test_lost_directions_in_axes_of_the_tool_are_the_same_turned(wrist: Explanation) -> None:
    seen = wrist.lost.seen
    base, tool = (np.asarray(seen[name].directions) for name in ("base", "tool"))
    turn = pose(wrist.here.robot, WRIST)[:3, :3]
    turned = np.concatenate([tool[:, :3] @ turn.T, tool[:, 3:] @ turn.T], axis=1)
    np.testing.assert_allclose(np.abs((turned * base).sum(axis=1)) / np.linalg.norm(base, axis=1) ** 2, 1.0, atol=1e-9)


def test_the_smallest_dependent_sets_lose_their_dependence_with_any_joint_left_out(wrist: Explanation) -> None:
    blame = wrist.blame
    assert blame.complete
    assert set(blame.smallest) <= set(blame.circuits)
    columns = jacobian(wrist.here.robot, WRIST)
    for circuit in blame.circuits:
        numbers = [number - 1 for number in circuit.numbers]
        assert np.linalg.matrix_rank(columns[:, numbers], tol=1e-9) == len(numbers) - 1
        for number in numbers:
            rest = [other for other in numbers if other != number]
            assert np.linalg.matrix_rank(columns[:, rest], tol=1e-9) == len(rest)


def test_the_summary_says_how_to_get_out_and_where_it_is_singular(wrist: Explanation) -> None:
    summary = wrist.summary
    assert (summary.verdict, summary.cause) == (wrist.verdict, wrist.cause)
    assert summary.distance is None or summary.distance == pytest.approx(0.0, abs=1e-9)
    assert (5, 0.0) in [(number, pytest.approx(value, abs=1e-9)) for number, value in summary.pinned]
    assert summary.way_out
    q = WRIST.copy()
    for number, motion in summary.way_out:
        q[number - 1] += motion
    assert summary.regular_after
    sigma = singular_values(wrist.here.robot, q[None], wrist.task)[0, 5]
    assert sigma == pytest.approx(summary.sigma_after, rel=1e-6)


def test_the_next_singularity_is_singular_and_as_far_as_it_says(wrist: Explanation) -> None:
    following = wrist.next
    assert following.family is not None
    assert following.q is not None
    assert following.family.id != wrist.summary.family_id
    robot = wrist.here.robot
    assert singular_values(robot, following.q[None], wrist.task)[0, 5] < 1e-6
    gap = (following.q - WRIST) / joint_scale(robot, wrist.task)
    assert np.linalg.norm(gap) == pytest.approx(following.distance, rel=1e-6)


def test_a_difference_of_two_methods_holds_nothing_that_it_is_not_about() -> None:
    for kind in DifferenceKind:
        difference = Difference(kind)
        unset = [getattr(difference, field.name) for field in fields(difference) if field.name != "kind"]
        assert not any(unset)


def test_directions_that_were_not_looked_at_in_other_axes_are_in_none() -> None:
    none = np.empty((0, 6))
    first, second = (Lost(none, np.zeros(6), (), (), None, (), (), none) for _ in range(2))
    assert first.seen == {}
    assert first.seen is not second.seen
