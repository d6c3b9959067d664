"""The arm itself where an ideal arm near it is singular: against the oracle, and how it scales."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from reference.kinematics import jacobian
from robot.calibrated import noisy

from rankdrop.families.points import members
from rankdrop.results.conditions import Conditions
from rankdrop.results.ideal_vs_actual import Idealised, Nearby
from rankdrop.results.known import known_analysis, shipped
from rankdrop.results.stored_conditions import known_conditions
from rankdrop.robot.ideal import Tolerance, read_tolerance
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs.conditions import conditions
from rankdrop.verbs.explain import explain
from rankdrop.verbs.ideal_vs_actual import ideal_vs_actual_at, idealised, nearby

CALIBRATED = Path(__file__).parents[1] / "data" / "ur5_calibrated.toml"


@pytest.fixture(scope="module")
def made() -> Idealised:
    return idealised(open_robot(str(CALIBRATED)), read_tolerance("1mm,0.5deg"))


@pytest.fixture(scope="module")
def derived(made: Idealised) -> Conditions:
    return conditions(made.ideal, points=100)


@pytest.fixture(scope="module")
def there(made: Idealised, derived: Conditions) -> tuple[Nearby, ...]:
    return nearby(made, derived.task, derived.families)


def sigma_of(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Singular values by the oracle, translations divided by the reach."""
    found = np.array(jacobian(robot, q))
    found[:3] /= resolve_task(None, robot).scale(robot)
    return np.linalg.svd(found, compute_uv=False)


def test_an_exact_arm_is_its_own_ideal_arm_and_singular_on_all_of_it() -> None:
    arm = open_robot("puma560")
    made = idealised(arm, read_tolerance("1mm,0.5deg"))
    assert made.ideal is arm
    assert made.changes == ()
    found = nearby(made, resolve_task(None, arm), shipped("puma560").families)
    assert len(found) == len(shipped("puma560").families)
    for one in found:
        assert one.points == one.singular > 0
        assert one.sigma.most < 1e-9
        assert one.distance is not None
        assert one.distance.most < 1e-12


@pytest.mark.by_hand
def test_a_calibrated_ur5_has_the_families_of_a_ur5(derived: Conditions) -> None:
    drawn = conditions(open_robot("ur5"))
    assert derived.complete
    assert derived.verified
    for mine, other in zip(derived.families, drawn.families, strict=True):
        assert (mine.id, mine.name, mine.dimension, mine.texts) == (other.id, other.name, other.dimension, other.texts)


@pytest.mark.slow
def test_sigma_there_is_that_of_the_oracle(made: Idealised, there: tuple[Nearby, ...]) -> None:
    atlas = shipped("ur5")  # its families are those of the ideal arm but for the lengths, its wrist but for nothing
    wrist = next(one for one in atlas.families if one.name.startswith("wrist"))
    mine = next(one for one in there if one.name.startswith("wrist"))
    q = members(made.ideal, resolve_task(None, made.ideal), wrist, 400, 7)
    sigma = [sigma_of(made.real, one)[5] for one in q]
    assert mine.number == 6
    assert mine.points > 150
    assert mine.sigma.median == pytest.approx(np.median(sigma), rel=0.2)
    assert mine.sigma.least < mine.sigma.median < mine.sigma.most == pytest.approx(max(sigma), rel=0.2)
    assert mine.singular == 0


@pytest.mark.slow
def test_singular_values_and_distances_grow_as_the_noise_does(derived: Conditions, made: Idealised) -> None:
    drawn = made.ideal
    found = []
    for share in (1.0, 0.1):
        rng = np.random.default_rng(5)
        real = noisy(drawn, rng, share * 1e-3, share * 3e-4)
        arm = Idealised(real, drawn, Tolerance(1e-3, 0.01), ())
        found.append(nearby(arm, derived.task, derived.families))
    for large, small in zip(*found, strict=True):
        assert large.sigma.median / small.sigma.median == pytest.approx(10, rel=0.1), large.name
        assert large.distance is not None
        assert small.distance is not None
        assert large.distance.median / small.distance.median == pytest.approx(10, rel=0.5), large.name


@pytest.mark.slow
def test_every_calibrated_family_is_within_a_fraction_of_a_degree(there: tuple[Nearby, ...]) -> None:
    assert [one.number for one in there] == [6, 6, 6, 5, 5, 5, 5, 5, 4]
    for one in there:
        assert 0 < one.sigma.least <= one.sigma.median <= one.sigma.most < 2e-3
        assert one.distance is not None
        assert 0 < one.distance.median < np.radians(0.2)


@pytest.mark.slow
def test_gen3_without_its_offsets_is_complete_and_the_arm_itself_keeps_some_of_it() -> None:
    arm = idealised(open_robot("gen3"), read_tolerance("13mm"))
    found = conditions(arm.ideal)
    assert [len(found.of_corank(corank)) for corank in (1, 2, 3, 4)] == [4, 4, 1, 0]
    assert found.complete
    assert found.verified
    told = {one.id: one for one in nearby(arm, found.task, found.families)}
    assert told["k1.f3"].sigma.median == pytest.approx(7e-5, rel=0.5)  # the shoulder and wrist of docs/conditions.md
    assert told["k1.f1"].singular == 0
    assert told["k3.f1"].singular == told["k3.f1"].points  # of the real arm too: nothing is lost by its offsets there


@pytest.mark.shipped
def test_what_is_shipped_is_not_taken_for_an_ideal_or_a_calibrated_arm(made: Idealised) -> None:
    gen3 = idealised(open_robot("gen3"), read_tolerance("13mm"))
    for robot in (made.ideal, made.real, gen3.ideal):
        task = resolve_task(None, robot)
        assert known_conditions(robot, task) is None
        assert known_analysis(robot, task) is None
    assert gen3.ideal.name == "gen3_ideal"
    assert known_conditions(gen3.real) is not None


def test_at_one_configuration_the_ideal_singularity_and_the_arm_there(made: Idealised) -> None:
    q = [0.1, -2.0, 1.5, 1.0, 0.005, 0.0]
    found = ideal_vs_actual_at(made, explain(made.ideal, q))
    assert found.number == 6
    assert found.distance is not None
    assert found.distance < 0.01
    assert found.q is not None
    assert found.there == pytest.approx(sigma_of(made.real, np.array(found.q))[5], rel=0.01)
    assert found.sigma == pytest.approx(sigma_of(made.real, np.array(q))[5], rel=0.01)
    at = ideal_vs_actual_at(made, explain(made.ideal, [0.1, -2.0, 1.5, 1.0, 0.0, 0.0]))
    assert at.distance == 0.0
    assert at.there == at.sigma > 1e-6
