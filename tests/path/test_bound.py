"""The bound along a curve: never exceeded, each of its parts reached, and no part of it missing."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms, region

from rankdrop.cover.setting import settings_for
from rankdrop.path.check.prove import Along, regular
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = {
    **{name: (lambda name=name: open_robot(name)) for name in ("panda", "pa10", "ur5", "scara", "stanford")},
    "almarkhi4": lambda: open_robot("almarkhi4"),  # position: seen from the last link
    "random slides": lambda: arms.random_chain(np.random.default_rng(4), "rprrpr"),
    "random screws": lambda: arms.random_chain(np.random.default_rng(5), "rhrphrr"),
    "mimics": lambda: region.coupled(np.random.default_rng(6), "r p r1:0.3 p1:-0.4 r h0:2.5 r p0:0.3 r"),
    "turns led by a slide": lambda: region.coupled(np.random.default_rng(8), "r p r1:2 r r1:-3 r1:2 r r"),
    "mirror": lambda: region.coupled(np.random.default_rng(9), "r r r0:1 r1:-1 r r0:1 r r"),
    "five joints": lambda: arms.random_chain(np.random.default_rng(7), "rrrrr"),
}


def cases(name: str, count: int = 3):
    """Settings of an arm with a few middles and chords each; singular and far configurations among them."""
    robot = ARMS[name]()
    rng = np.random.default_rng(11)
    middle = rng.uniform(-np.pi, np.pi, (count, robot.n))
    middle[0, 1:3] = 0.0
    middle[-1] *= 200.0
    chord = rng.uniform(-1.0, 1.0, (count, robot.n))
    for setting in settings_for(robot, resolve_task(None, robot))[::7]:
        yield Along(robot, setting), middle, chord * setting.scale


def changes(along: Along, found, i: int, middle: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """(..., r, r) |E| at configurations c + moved."""
    parts = found.sigma[i], found.u[i], found.v[i]
    return np.abs(region.change(along.robot, middle, along.setting, moved / along.setting.scale, *parts))


@pytest.mark.spread(5)
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_nothing_along_a_curve_exceeds_the_bound(name: str) -> None:
    rng = np.random.default_rng(12)
    worst, checked = 0.0, 0
    for along, middle, chord in cases(name):
        for size, loose in ((1e-3, 0.0), (0.05, 1e-3), (0.3, 0.05), (0.3, 0.0)):
            extra = loose * rng.uniform(0.0, 1.0, chord.shape) * along.setting.scale
            found = along.enclose_curves(middle, size * chord, extra)
            for i in range(len(middle)):
                tau = np.concatenate([[-1.0, 1.0], rng.uniform(-1, 1, 60)])[:, None]
                sign = np.where(rng.random((62, 1)) < 0.5, rng.choice([-1.0, 1.0], (62, chord.shape[1])), 1.0)
                error = changes(along, found, i, middle[i], size * chord[i] * tau + extra[i] * sign)
                assert (error.max(axis=0) <= found.bound[i] * (1 + 1e-12)).all()
                worst = max(worst, float((error.max(axis=0) / found.bound[i]).max()))
                checked += 1
    assert checked >= 12
    assert worst > 0.9  # the short ones without looseness are all slope


@pytest.mark.parametrize("name", ARMS)
def test_the_slope_is_that_of_the_arm_entry_by_entry(name: str) -> None:
    seen = 0
    for along, middle, chord in cases(name, count=2):
        found = along.enclose_curves(middle[:1], 1e-5 * chord[:1], np.zeros_like(chord[:1]))
        plus, minus = (
            region.change(along.robot, middle[0], along.setting, sign * 1e-5 * chord[0] / along.setting.scale,
                          found.sigma[0], found.u[0], found.v[0])
            for sign in (1, -1)
        )  # fmt: skip
        slope = np.abs(plus - minus) / 2
        plain = slope > max(3e-2 * slope.max(), 1e-8)  # the others are as small as what curvature and rounding add
        assert (slope[plain] <= found.bound[0][plain]).all()
        assert (slope[plain] >= 0.97 * found.bound[0][plain]).all()
        seen += int(plain.sum())
    assert seen >= 3


@pytest.mark.parametrize("name", ["ur5", "panda", "random slides", "random screws", "almarkhi4", "mimics"])
def test_the_curvature_is_that_of_the_arm_entry_by_entry(name: str) -> None:
    seen, steps = 0, np.array([1.0, 2.0, 3.0]) * 1e-3
    for along, middle, chord in cases(name, count=2):
        q, way = np.tile(middle[:1], (3, 1)), steps[:, None] * chord[:1]
        found = along.enclose_curves(q, way, np.zeros_like(way))
        powers = steps[:, None] ** np.arange(1, 4)
        terms = np.linalg.solve(powers, (found.bound - found.floor).reshape(3, -1)).reshape(found.bound.shape)
        h = 2e-3
        plus, minus = (
            region.change(along.robot, middle[0], along.setting, sign * h * chord[0] / along.setting.scale,
                          found.sigma[0], found.u[0], found.v[0])
            for sign in (1, -1)
        )  # fmt: skip
        bend = np.abs(plus + minus) / (2 * h * h)
        tolerance = 1e-3 * bend.max() + 1e-6
        np.testing.assert_allclose(terms[1], bend, atol=tolerance)
        seen += int((bend > 20 * tolerance).sum())
    assert seen > 5


def planar(first: float, last: float) -> Robot:
    """Two parallel axes; the lines from the tip to them meet at a right angle, so that U₁ lies along the columns."""
    height = np.sqrt(first**2 - last**2)
    joints = [
        Joint(name, JointKind.REVOLUTE, np.array([*np.cross(point, [0, 0, 1.0]), 0, 0, 1.0]))
        for name, point in (("a", [0.0, height, 0.0]), ("b", [last, 0.0, 0.0]))
    ]
    return Robot("right angle", tuple(joints), task="position")


def short_arm() -> tuple[Along, np.ndarray]:
    robot = planar(1.0, 0.01)
    (setting,) = settings_for(robot, resolve_task("position", robot))
    return Along(robot, setting), np.zeros((1, 2))


def test_the_remainder_of_third_order_is_nearly_reached() -> None:
    along, q = short_arm()
    h = 0.02
    way = np.array([[0.0, h]])
    found = along.enclose_curves(q, way, np.zeros_like(way))
    error = region.change(along.robot, q[0], along.setting, np.stack([way[0], -way[0]]), found.sigma[0], found.u[0],
                          found.v[0])  # fmt: skip
    slope = region.change(along.robot, q[0], along.setting, np.array([[0, 1e-5], [0, -1e-5]]), found.sigma[0],
                          found.u[0], found.v[0])  # fmt: skip
    third = np.abs((error[0] - error[1]) / 2 - h * (slope[0] - slope[1]) / 2e-5)
    rest = found.bound[0] - h * np.abs(slope[0] - slope[1]) / 2e-5 - np.abs(error[0] + error[1]) / 2
    assert (third <= rest * (1 + 1e-4) + 1e-11).all()
    assert (third / rest).max() > 0.9


def test_what_lies_beside_the_chord_is_nearly_reached() -> None:
    along, q = short_arm()
    beside = np.array([[0.0, 1e-3]])
    found = along.enclose_curves(q, np.zeros_like(beside), beside)
    error = changes(along, found, 0, q[0], np.stack([beside[0], -beside[0]])).max(axis=0)
    assert (error <= found.bound[0]).all()
    assert (error / found.bound[0]).max() > 0.9


def test_a_slide_beside_the_chord_is_nearly_reached() -> None:
    z = np.array([0, 0, 0, 0, 0, 1.0])
    joints = [
        Joint("turn", JointKind.REVOLUTE, z),
        Joint("slide", JointKind.PRISMATIC, np.array([1.0, 0, 0, 0, 0, 0])),
        Joint("last", JointKind.REVOLUTE, z),
    ]
    robot = Robot("turn slide turn", tuple(joints), task="position")
    (setting,) = settings_for(robot, resolve_task("position", robot))
    along, q = Along(robot, setting), np.array([[0.0, 0.02, 0.3]])
    beside = np.array([[0.0, 0.01, 0.0]])
    found = along.enclose_curves(q, np.zeros_like(beside), beside)
    error = changes(along, found, 0, q[0], np.stack([beside[0], -beside[0]])).max(axis=0)
    assert (error <= found.bound[0]).all()
    assert (error / found.bound[0]).max() > 0.9


def test_the_matrix_test_is_that_of_an_m_matrix() -> None:
    rng = np.random.default_rng(4)
    sigma = rng.uniform(0.1, 1.0, (4000, 5))
    bound = rng.uniform(0.0, 1.0, (4000, 5, 5)) * rng.uniform(0.0, 0.8, (4000, 1, 1)) * sigma[:, :, None]
    radius = np.abs(np.linalg.eigvals(bound / sigma[:, :, None])).max(axis=1)
    assert (regular(sigma, bound) == (radius < 1.0)).all()
    assert 0.1 < (radius < 1.0).mean() < 0.95
    bound[0, 0, 0] = np.nan
    assert not regular(sigma[:1], bound[:1])[0]
