"""No certified ball holds a singularity, and none is much smaller than it must be."""

from __future__ import annotations

import numpy as np
import pytest
from reference import near, region
from reference.near import cloud, distances, nearest

from rankdrop import _core
from rankdrop.cover.ball import LARGEST, certified_radius, proven_free
from rankdrop.cover.setting import enclose, settings_for
from rankdrop.errors import OptionError
from rankdrop.local.block import sample, singular_values
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

BUDGETS = (0, 8, 500, 6000)


def to_multiple(angle, first=0.0):
    """Distance of an angle from first + any multiple of π."""
    return np.abs((angle - first + np.pi / 2) % np.pi - np.pi / 2)


def pa10_distance(q):
    """From AM Table 3."""
    flat = {j: to_multiple(q[..., j - 1]) for j in (2, 4, 6)}
    right = {j: to_multiple(q[..., j - 1], np.pi / 2) for j in (3, 5)}
    rows = [flat[4], np.hypot(flat[2], right[3]), np.hypot(flat[2], flat[6]), np.hypot(right[5], flat[6])]
    return np.min(rows, axis=0)


def planar_distance(q):
    """sin θ2 = 0."""
    return to_multiple(q[..., 1])


CLOSED = {"pa10": pa10_distance, "planar3r": planar_distance}


def singles(robot, q, task=None):
    """Radius of one enclosure, of the best setting, at many configurations."""
    settings = settings_for(robot, resolve_task(task, robot))
    return np.max([enclose(robot, setting, q, radius=LARGEST)[1] for setting in settings], axis=0)


def beside(robot, q, radius, count, seed):
    """Configurations around each q, about as far away as its radius, where a search is to start."""
    noise = np.random.default_rng(seed).normal(size=(count * len(q), robot.n))
    return np.repeat(q, count, axis=0) + noise * np.repeat(radius, count)[:, None]


def an_arm(name):
    """One of the catalogue, or one with mimic joints."""
    if name == "mimics":
        return region.coupled(np.random.default_rng(6), "r p r1:0.3 r h0:0.5 r p0:0.3 r r")
    return open_robot(name)


@pytest.mark.parametrize("name", CLOSED)
def test_no_ball_reaches_a_singularity_that_is_known(name):
    robot, distance = open_robot(name), CLOSED[name]
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (400, robot.n))
    q[::4, 1] *= 1e-3  # a quarter near the singular set, some very near
    q[::8, 3 % robot.n] *= 1e-6
    radius = singles(robot, q)
    assert (radius <= distance(q)).all()
    assert (radius > 0.0).all()
    assert np.median(radius / distance(q)) > (0.35 if name == "pa10" else 0.5)
    for row in q[::20]:
        certified = certified_radius(robot, row, evaluations=1500).radius
        assert 0.0 < certified <= distance(row)
        if name == "planar3r":
            assert certified > 0.9999 * distance(row)


@pytest.mark.spread(3)
@pytest.mark.slow_at("mimics", "panda", "puma560", "ur5")
@pytest.mark.parametrize(
    "name", ["puma560", "ur5", "anthropomorphic", "panda", "stanford", "scara", "almarkhi4", "mimics"]
)
def test_no_ball_holds_a_singular_point(name):
    robot = an_arm(name)
    task = resolve_task(None, robot)
    first = settings_for(robot, task)[0]
    points = cloud(robot, task, sample(robot, task, 6000, 5))
    assert len(points) > (5000 if name not in ("almarkhi4", "mimics") else 1000)
    q = sample(robot, task, 150, 6)
    radius = singles(robot, q)
    assert (radius > 0.0).sum() > 140
    everything = np.concatenate([points, cloud(robot, task, beside(robot, q, radius, 12, 7))])
    for i in range(len(q)):
        assert radius[i] < distances(robot, q[i], everything, first.scale, first.matters).min()
    for row in q[:8]:
        found = certified_radius(robot, row, evaluations=1000)
        setting = found.setting
        assert 0.0 < found.single <= found.radius
        assert found.radius < distances(robot, row, everything, setting.scale, setting.matters).min()


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["anthropomorphic", "puma560", "ur5"])
def test_one_enclosure_reaches_half_the_distance(name):
    robot = open_robot(name)
    task = resolve_task(None, robot)
    setting = settings_for(robot, task)[0]
    points = cloud(robot, task, sample(robot, task, 4000, 5))
    q = sample(robot, task, 40, 8)
    far = [nearest(robot, task, row, points, setting.scale, setting.matters) for row in q]
    ratio = singles(robot, q) / far
    assert (ratio <= 1.0 + 1e-9).all()
    assert np.median(ratio) > 0.5


def test_boxes_cut_by_the_ball_reach_a_singularity_and_stop_there():
    """Near the set the radius is proven to a ten-thousandth, with no singularity known beforehand, and not beyond."""
    robot = open_robot("pa10")
    q = np.random.default_rng(19).uniform(-np.pi, np.pi, (60, robot.n))
    far = pa10_distance(q)
    near = np.flatnonzero((far > 0.05) & (far < 0.3))
    assert len(near) > 10
    for i in near:
        found = certified_radius(robot, q[i], at_most=1.5 * far[i], evaluations=4000)
        assert found.radius <= far[i]
        assert found.radius > 0.97 * far[i]
        enough = certified_radius(robot, q[i], at_most=1.5 * far[i], enough=0.9 * far[i], evaluations=4000)
        assert 0.9 * far[i] <= enough.radius <= found.radius
        assert enough.evaluations < found.evaluations


@pytest.mark.by_hand
@pytest.mark.parametrize("name", ["puma560", "ur5", "pa10", "panda"])
def test_branch_and_bound_reaches_nine_tenths(name):
    """Run with `pytest -m slow tests/cover`; about a minute."""
    robot = open_robot(name)
    task = resolve_task(None, robot)
    points = cloud(robot, task, sample(robot, task, 60_000, 5))
    q = sample(robot, task, 40, 9)
    ratio = []
    for row in q:
        found = certified_radius(robot, row, evaluations=20_000)
        close = cloud(robot, task, beside(robot, row[None], np.ones(1), 200, 1))
        setting = found.setting
        distance = nearest(robot, task, row, np.concatenate([points, close]), setting.scale, setting.matters)
        ratio.append(found.radius / distance)
    assert max(ratio) <= 1.0 + 1e-9
    assert np.median(ratio) > 0.9


@pytest.mark.by_hand
@pytest.mark.parametrize(
    "name", ["puma560", "ur5", "panda", "iiwa14", "canadarm2", "rcrrrr", "stanford", "fetch8", "gen3"]
)
def test_no_ball_holds_a_singular_point_of_a_large_cloud(name):
    """1 000 configurations of each arm, 60 000 points."""
    robot = open_robot(name)
    task = resolve_task(None, robot)
    setting = settings_for(robot, task)[0]
    q = sample(robot, task, 1000, 10)
    radius = singles(robot, q)
    close = cloud(robot, task, beside(robot, q, radius, 30, 11))
    points = np.concatenate([cloud(robot, task, sample(robot, task, 40_000, 12)), close])
    assert len(points) > 30_000
    for i in range(len(q)):
        assert radius[i] < distances(robot, q[i], points, setting.scale, setting.matters).min()
    for row in q[:50]:
        found = certified_radius(robot, row, evaluations=20_000)
        assert found.radius < distances(robot, row, points, found.setting.scale, found.setting.matters).min()


@pytest.mark.parametrize("name", ["pa10", "puma560", "panda", "ur5", "scara", "almarkhi4"])
def test_a_singular_configuration_has_no_ball(name):
    robot = open_robot(name)
    task = resolve_task(None, robot)
    for row in cloud(robot, task, sample(robot, task, 60, 13))[:5]:
        found = certified_radius(robot, row, evaluations=20_000)
        assert found.single == found.radius == 0.0
        assert found.evaluations < 5000  # boxes as narrow as 1e-6 are not divided: it ends before the budget does


@pytest.mark.parametrize("away", [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8])
@pytest.mark.parametrize(("name", "joint"), [("pa10", 4), ("planar3r", 2), ("puma560", 5), ("ur5", 5), ("scara", 2)])
def test_just_beside_a_singularity(name, joint, away):
    robot = open_robot(name)
    q = np.random.default_rng(14).uniform(0.7, 1.1, robot.n)
    q[joint - 1] = away
    exact = singular_values(robot, q - away * np.eye(robot.n)[joint - 1], resolve_task(None, robot))
    assert exact[settings_for(robot, resolve_task(None, robot))[0].rank - 1] < 1e-12
    found = certified_radius(robot, q, evaluations=400, at_most=20 * away)
    assert found.single <= away
    assert found.single > 0.5 * away
    assert 0.0 < found.radius <= away


@pytest.mark.parametrize("name", ["pa10", "puma560", "stanford", "planar3r", "almarkhi4"])
def test_more_budget_never_certifies_less(name):
    robot = open_robot(name)
    for row in np.random.default_rng(15).uniform(-1.5, 1.5, (4, robot.n)):
        found = [certified_radius(robot, row, evaluations=budget) for budget in BUDGETS]
        radius = [one.radius for one in found]
        assert radius == sorted(radius)
        assert radius[-1] > radius[0] == found[0].single
        settings = len(settings_for(robot, resolve_task(None, robot)))
        assert all(one.evaluations <= settings + budget for one, budget in zip(found, BUDGETS, strict=True))


@pytest.mark.parametrize("name", ["ur5", "pa10", "scara"])
def test_a_quick_proof_agrees_with_the_certificate(name):
    arm = open_robot(name)
    task = resolve_task(None, arm)
    for q in sample(arm, task, 4, seed=5):
        certified = certified_radius(arm, q, task)
        assert proven_free(arm, q, task, 0.2 * certified.radius, 2_000)
        assert not proven_free(arm, q, task, min(1.05 * certified.radius, LARGEST), 2_000)
        assert not proven_free(arm, q, task, 1.1 * LARGEST, 2_000)


def test_no_more_is_certified_than_asked_for():
    robot, q = open_robot("puma560"), np.array([0.3, -0.8, 2.2, 0.4, 1.2, 0.1])
    free = certified_radius(robot, q, evaluations=5000).radius
    for share in (0.2, 0.9):
        found = certified_radius(robot, q, at_most=share * free, evaluations=5000)
        assert found.radius == found.at_most == share * free
    found = certified_radius(robot, q, at_most=1.2 * free, evaluations=5000)
    assert found.radius < 1.2 * free
    assert certified_radius(robot, q, at_most=1e-9).radius == 1e-9


def test_one_joint_is_free_everywhere():
    robot = region.coupled(np.random.default_rng(16), "r")
    for task in ("pose", "position"):
        found = certified_radius(robot, [0.4], task)
        assert found.radius == found.at_most == LARGEST


@pytest.mark.parametrize(
    ("option", "value"),
    [("at_most", 0.0), ("at_most", 4.0), ("at_most", float("nan")), ("evaluations", -1), ("evaluations", 2.5),
     ("evaluations", True), ("evaluations", 10**12)],
)  # fmt: skip
def test_what_cannot_be_asked_is_refused(option, value):
    with pytest.raises(OptionError):
        certified_radius(open_robot("planar3r"), [0.1, 0.2, 0.3], **{option: value})


def test_what_cannot_be_certified_is_refused():
    with pytest.raises(OptionError, match="some rows"):
        certified_radius(open_robot("puma560"), [0.3] * 6, "vx,vy")
    slides = region.coupled(np.random.default_rng(17), "p p p")
    with pytest.raises(OptionError, match="no rank"):
        certified_radius(slides, [0.1] * 3, "orientation")
    many = region.coupled(np.random.default_rng(18), "r " * 33)
    with pytest.raises(OptionError, match="too many joints"):
        certified_radius(many, [0.1] * 33)


def test_the_same_arm_turned_by_thousands_of_turns():
    robot = open_robot("ur5")
    q = np.array([0.3, -0.8, 1.2, 0.4, 1.2, 0.1])
    turns = 2 * np.pi * np.array([1600, -1600, 3, 800, -5, 0])
    one, other = (certified_radius(robot, row, evaluations=500).radius for row in (q, q + turns))
    assert other == pytest.approx(one, rel=1e-8)


@pytest.mark.slow
def test_near_points_are_where_they_should_be():
    # the distance by local search, against the closed form
    robot = open_robot("pa10")
    task = resolve_task(None, robot)
    setting = settings_for(robot, task)[0]
    points = near.cloud(robot, task, sample(robot, task, 8000, 5))
    q = sample(robot, task, 20, 8)
    found = np.array([nearest(robot, task, row, points, setting.scale, setting.matters) for row in q])
    assert (found > pa10_distance(q) - 1e-6).all()  # σ = 0 to 1e-12 is θ to a millionth where two lines cross
    assert np.median(found / pa10_distance(q)) < 1.05


@pytest.mark.parametrize("name", ["puma560", "pa10", "gen3", "mimics", "almarkhi4"])
def test_the_largest_ball_of_all_settings_is_that_of_each_measured_alone(name):
    robot = an_arm(name)
    task = resolve_task(None, robot)
    settings = settings_for(robot, task)
    views, told = [x.view(robot) for x in settings], [x.core_settings(LARGEST) for x in settings]
    best = set()
    for q in np.random.default_rng(8).uniform(-np.pi, np.pi, (20, robot.n)):
        radii = [float(enclose(robot, setting, q[None], radius=LARGEST)[1][0]) for setting in settings]
        assert _core.largest_ball(settings[0].chain(robot), views, told, q) == (int(np.argmax(radii)), max(radii))
        best.add(int(np.argmax(radii)))
    assert len(best) > 1 or len(settings) < 3
