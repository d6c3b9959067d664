"""The singularity that is next: on any sheet, not the one that the answer is about, and never denied unsearched."""

from __future__ import annotations

import numpy as np
import pytest
from known.jogs import FEW, singular_configurations

from rankdrop.errors import OptionError
from rankdrop.local.block import singular_values
from rankdrop.local.nearest import nearest_singularity, other_sheets
from rankdrop.local.special import Special
from rankdrop.results import explanation, other_singularities
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task
from rankdrop.verbs.explain import explain


def next_line(found: explanation.Explanation) -> str:
    return next(line for line in found.sections()[0].lines if str(line).startswith("Next:"))


def test_the_other_value_of_the_same_joint_is_next() -> None:
    found = explain(open_robot("scara"), [0.3, 0.0, 0.1, 0.2], evaluations=0)
    assert found.summary.next_distance == pytest.approx(np.pi)
    assert found.summary.next_family == found.met[0].family.name
    assert "180°" in next_line(found)


@pytest.mark.parametrize("name", ["gen3", "sawyer", "rizon4", "gen3_6dof"])
def test_an_arm_with_one_family_hears_of_its_other_sheets(name: str) -> None:
    arm, q = next(iter(singular_configurations(name, 1, seed=3)))
    task = resolve_task(None, arm)
    found = explain(arm, q, evaluations=0)
    assert not found.far.families
    assert found.summary.next_distance is not None
    assert 0.0 < found.summary.next_distance < np.pi
    _, sheets = other_sheets(found.here, None)
    for one in sheets:
        there = np.array(one.q)
        rank = found.rank.generic_rank - one.corank
        assert singular_values(arm, there, task)[rank] <= 1e-8
        half = q + 0.9 * (there - q)  # nearer to the sheet than to q: the search from there finds the sheet, not q
        near = nearest_singularity(arm, half, task)
        assert near is not None
        assert near.distance <= 0.1 * np.linalg.norm(there - q) + 1e-6


@pytest.mark.parametrize("name", FEW[:6])
def test_no_known_family_is_nearer_than_the_next_singularity(name: str) -> None:
    for arm, q in singular_configurations(name, 1):
        found = explain(arm, q, evaluations=0)
        nearest = min((one.distance for one in found.far.families), default=np.inf)
        if found.summary.next_distance is not None:
            assert found.summary.next_distance <= nearest + 1e-9


def test_a_singularity_that_is_near_because_slow_is_not_told_twice() -> None:
    for name in ("gen3", "ur5e", "crx10ia", "gen3_6dof"):
        arm = open_robot(name)
        for share in (0.05, 0.08, 0.12, 0.2):
            found = explain(arm, np.full(arm.n, 1.0) - (1.0 - share) * (np.arange(arm.n) == arm.n - 2), evaluations=0)
            if found.slow_family is not None and found.summary.next_distance is not None:
                same = found.summary.next_family == found.summary.family
                assert not same or abs(found.summary.next_distance - found.summary.distance) > 1e-3


def test_what_was_not_searched_is_not_denied(monkeypatch) -> None:
    def refuse(*_args: object, **_named: object) -> None:
        raise OptionError("too many joints for this corank", got="22 joints", allowed="16")

    arm, q = next(iter(singular_configurations("gen3", 1, seed=3)))
    with monkeypatch.context() as patched:
        patched.setattr(other_singularities, "other_sheets", refuse)
        assert next_line(explain(arm, q, evaluations=0)) == "Next: not searched."
    monkeypatch.setattr(other_singularities, "other_sheets", lambda *_args, **_named: (40, iter(())))
    assert next_line(explain(arm, q, evaluations=0)) == "Next: none found by 40 searches."


def own_arm() -> Robot:
    """Shoulder with an offset, spherical wrist: elbow and shoulder have conditions on θ2 and θ3 alone."""
    half = np.pi / 2
    return from_dh([(0.15, -half, 0.45, 0.0), (0.6, 0.0, 0.0, -half), (0.2, -half, 0.0, 0.0), (0.0, half, 0.64, 0.0),
                    (0.0, -half, 0.0, 0.0), (0.0, 0.0, 0.1, 0.0)], convention="standard")  # fmt: skip


def test_where_no_families_are_known_the_way_to_know_them_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(other_singularities, "other_sheets", lambda *_args, **_named: (40, iter(())))
    line = next_line(explain(own_arm(), [1.3, 0.2, 0.5, 0.7, 0.0, 0.1], evaluations=0))
    assert line == "Next: none found by 40 searches; analysis=… with a file of analyze finds more."


@pytest.mark.parametrize("wrist", [
    [0.7, 0.0, 0.1], *(pytest.param(slow, marks=pytest.mark.slow) for slow in ([-2.0, 0.0, 1.0], [0.7, np.pi, 0.1])),
])  # fmt: skip
def test_at_a_wrist_singularity_of_an_own_arm_the_next_one_is_found(wrist: list[float]) -> None:
    """The nearest points of elbow and shoulder in (θ2, θ3), on a grid: the walks leave the sheet of the wrist."""
    arm, q = own_arm(), np.array([1.3, 0.2, 0.5, *wrist])
    found = explain(arm, q, evaluations=0)
    turn = np.radians(np.arange(-180.0, 180.0, 0.5))
    two, three = (part.ravel() for part in np.meshgrid(q[1] + turn, q[2] + turn, indexing="ij"))
    up = two - np.pi / 2
    radius = 0.15 + 0.6 * np.cos(up) + 0.2 * np.cos(up + three) - 0.64 * np.sin(up + three)
    elbow = 0.2 * np.sin(three) + 0.64 * np.cos(three)
    distance = np.hypot(two - q[1], three - q[2])
    lengths = [distance[np.abs(value) < 0.004].min() for value in (radius, elbow)]
    assert found.summary.next_distance == pytest.approx(min(lengths), abs=0.02)
    assert next_line(found).startswith(f"Next: {('shoulder', 'elbow')[int(np.argmin(lengths))]}, ")


@pytest.mark.slow
def test_the_next_singularity_is_not_the_same_one_farther_off() -> None:
    """The sheet of the wrist of a gen3 comes near at a second place, 3.4° away, with joint 6 near 0° again."""
    arm, q = next(iter(singular_configurations("gen3", 1, seed=5)))
    found = explain(arm, q, evaluations=0)
    places = found.summary.place, found.summary.next_place
    here, there = ({(special.part, special.joint) for special in place} for place in places)
    assert found.summary.next_distance is not None
    assert here != there


def test_the_special_parts_of_a_place_are_looked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sheets of the same family are compared with the place of the answer, each of them, and so is the sentence."""
    looked_at: list[tuple[bytes, int]] = []
    specials_at = explanation.specials_at

    def counted(robot: Robot, task: Task, q: np.ndarray, corank: int) -> tuple[Special, ...]:
        looked_at.append((q.tobytes(), corank))
        return specials_at(robot, task, q, corank)

    monkeypatch.setattr(explanation, "specials_at", counted)
    arm, q = next(iter(singular_configurations("gen3", 1, seed=3)))
    explain(arm, q, evaluations=0).to_dict()
    assert len(looked_at) > 1
    assert len(looked_at) == len(set(looked_at))


def test_the_next_singularity_is_named_by_what_is_new_where_this_one_holds_there_too() -> None:
    """iiwa14, elbow at 0: the nearest point of the wrist's family has the elbow at 0 as well, and was called elbow."""
    arm, q = open_robot("iiwa14"), np.array([0.9443, -2.2109, -2.3247, 0.0, -2.0236, 2.7059, -1.7345])
    found = explain(arm, q, evaluations=0)
    assert found.next.q is not None
    np.testing.assert_allclose(found.next.q[3:6], [0.0, -np.pi / 2, np.pi], atol=1e-6)
    assert next_line(found) == "Next: wrist, 36° of joint motion away."
