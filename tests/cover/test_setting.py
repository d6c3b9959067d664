"""|E_ij| ≤ B_ij in boxes and balls, for every joint kind; and each of the three orders as large as it says."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms, region

from rankdrop.cover.setting import enclose, settings_for, settings_for_near_arms
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = {
    **{name: (lambda name=name: open_robot(name)) for name in ("panda", "pa10", "puma560", "scara", "stanford")},
    "almarkhi4": lambda: open_robot("almarkhi4"),  # position: seen from the last link
    "random slides": lambda: arms.random_chain(np.random.default_rng(4), "rprrpr"),
    "random screws": lambda: arms.random_chain(np.random.default_rng(5), "rhrphrr"),
    "mimics": lambda: region.coupled(np.random.default_rng(6), "r p r1:0.3 p1:-0.4 r h0:2.5 r p0:0.3 r"),
    "small mimic slides": lambda: region.coupled(np.random.default_rng(7), "r r p p2:0.05 r p2:-0.05 r r"),
    "turns led by a slide": lambda: region.coupled(np.random.default_rng(8), "r p r1:2 r r1:-3 r1:2 r r"),
    "mirror": lambda: region.coupled(np.random.default_rng(9), "r r r0:1 r1:-1 r r0:1 r r"),
    "five joints": lambda: arms.random_chain(np.random.default_rng(7), "rrrrr"),
}
SIZES = (1e-3, 0.05, 0.4)


def cases(name, task=None, count=3):
    """Settings of an arm with a few configurations each, singular and far ones among them."""
    robot = ARMS[name]() if name in ARMS else open_robot(name)
    rng = np.random.default_rng(11)
    q = rng.uniform(-np.pi, np.pi, (count, robot.n))
    q[0, 1:3] = 0.0
    q[-1] *= 2000.0  # thousands of radians, or metres
    for setting in settings_for(robot, resolve_task(task, robot))[::7]:
        yield robot, setting, q


def corners(n, count, seed):
    """Corners of the unit box, and points inside."""
    rng = np.random.default_rng(seed)
    return np.concatenate([rng.choice([-1.0, 1.0], (count, n)), rng.uniform(-1, 1, (count, n))])


@pytest.mark.spread(6)
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_nothing_in_a_box_exceeds_the_bound(name):
    checked = 0
    for robot, setting, q in cases(name):
        for size in SIZES:
            half = size * np.random.default_rng(12).uniform(0.2, 1.0, q.shape)
            _, _, bound, sigma, u, v, _ = enclose(robot, setting, q, half)
            for i in range(len(q)):
                delta = corners(robot.n, 150, i) * half[i]
                error = region.change(robot, q[i], setting, delta, sigma[i], u[i], v[i])
                assert (np.abs(error).max(axis=0) <= bound[i] * (1 + 1e-12)).all()
                checked += 1
    assert checked >= 9


@pytest.mark.spread(6)
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_nothing_in_a_ball_exceeds_the_bound(name):
    closest = 0.0
    for robot, setting, q in cases(name):
        for size in SIZES:
            _, radius, bound, sigma, u, v, _ = enclose(robot, setting, q, radius=size)
            for i in np.flatnonzero(radius > 0.0):
                delta = corners(robot.n, 150, i)
                delta *= radius[i] / np.linalg.norm(delta, axis=1, keepdims=True)
                error = region.change(robot, q[i], setting, delta, sigma[i], u[i], v[i])
                assert (np.abs(error).max(axis=0) <= bound[i] * (1 + 1e-12)).all()
                closest = max(closest, float((np.abs(error).max(axis=0) / bound[i]).max()))
    assert closest > 0.5  # the directions are random


def coefficients(robot, setting, q, pattern, h=1e-3):
    """Of h, h², h³ in the bound over the box h · pattern, and Σ, U₁, V₁."""
    steps = np.arange(4) * h
    found = enclose(robot, setting, np.tile(q, (4, 1)), steps[:, None] * pattern)
    powers = steps[1:, None] ** np.arange(1, 4)
    terms = np.linalg.solve(powers, (found[2][1:] - found[2][0]).reshape(3, -1)).reshape(3, *found[2].shape[1:])
    return terms, (found[3][0], found[4][0], found[5][0])


@pytest.mark.spread(4)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["puma560", "panda", "random slides", "random screws", "almarkhi4"])
def test_first_and_second_order_are_those_of_the_arm_and_no_more(name):
    # one joint alone, then two: entries are the absolute slope, half the curvature, the cross term
    seen, h = 0, 1e-3
    for robot, setting, q in cases(name, count=2):
        unit = np.eye(robot.n)
        tolerance = 1e-4 * enclose(robot, setting, q[:1], 0 * q[:1])[6].max() ** 2
        curved = {}
        for k in range(robot.n):
            (first, second, _), parts = coefficients(robot, setting, q[0], unit[k])
            plus, minus = region.change(robot, q[0], setting, h * np.stack([unit[k], -unit[k]]), *parts)
            np.testing.assert_allclose(first, np.abs(plus - minus) / (2 * h), atol=tolerance)
            np.testing.assert_allclose(second, np.abs(plus + minus) / (2 * h * h), atol=tolerance)
            curved[k] = second
            seen += int((second > 20 * tolerance).sum())
        for k in range(robot.n):
            for j in range(k):
                (_, second, _), parts = coefficients(robot, setting, q[0], unit[k] + unit[j])
                signs = np.array([[1, 1], [-1, -1], [1, -1], [-1, 1]])
                error = region.change(robot, q[0], setting, h * signs @ unit[[k, j]], *parts)
                mixed = np.abs(error[0] + error[1] - error[2] - error[3]) / (4 * h * h)
                np.testing.assert_allclose(second - curved[k] - curved[j], mixed, atol=3 * tolerance)
                seen += int((mixed > 20 * tolerance).sum())
    assert seen > 30


@pytest.mark.spread(4)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["puma560", "panda", "random slides", "pa10"])
@pytest.mark.parametrize("size", [1e-4, 1e-2])
def test_the_bound_of_a_box_is_reached_at_a_corner(name, size):
    best = 0.0
    for robot, setting, q in cases(name, count=2):
        half = np.full((1, robot.n), size)
        _, _, bound, sigma, u, v, _ = enclose(robot, setting, q[:1], half)
        slopes = region.change(robot, q[0], setting, 1e-6 * np.eye(robot.n), sigma[0], u[0], v[0])  # (n, r, r)
        for a, j in np.ndindex(slopes.shape[1:]):
            delta = size * np.where(slopes[:, a, j] >= 0.0, 1.0, -1.0)
            error = region.change(robot, q[0], setting, np.stack([delta, -delta]), sigma[0], u[0], v[0])
            best = max(best, float(np.abs(error[:, a, j]).max() / bound[0, a, j]))
    assert 0.95 < best <= 1.0


@pytest.mark.parametrize("name", ["puma560", "panda", "random slides"])
def test_the_bound_of_a_ball_is_reached_along_the_gradient(name):
    best = 0.0
    for robot, setting, q in cases(name, count=2):
        _, radius, bound, sigma, u, v, _ = enclose(robot, setting, q[:1], radius=1e-3)
        if radius[0] == 0.0:
            continue
        slopes = region.change(robot, q[0], setting, 1e-6 * np.eye(robot.n), sigma[0], u[0], v[0])
        for a, j in np.ndindex(slopes.shape[1:]):
            delta = radius[0] * slopes[:, a, j] / max(np.linalg.norm(slopes[:, a, j]), 1e-12)
            error = region.change(robot, q[0], setting, np.stack([delta, -delta]), sigma[0], u[0], v[0])
            best = max(best, float(np.abs(error[:, a, j]).max() / bound[0, a, j]))
    assert 0.95 < best <= 1.0


def planar(first, last):
    """Two parallel axes; the lines from the tip to them meet at a right angle, so that U₁ lies along the columns."""
    height = np.sqrt(first**2 - last**2)
    joints = [
        Joint(name, JointKind.REVOLUTE, np.array([*np.cross(point, [0, 0, 1.0]), 0, 0, 1.0]))
        for name, point in (("a", [0.0, height, 0.0]), ("b", [last, 0.0, 0.0]))
    ]
    return Robot("right angle", tuple(joints), task="position")


@pytest.mark.parametrize("ball", [False, True])
def test_the_remainder_of_turns_is_nearly_reached(ball):
    # column 1 turns about axis 2: its third derivative has length 1, its reach is 1.02, and U₁ lies along it
    robot = planar(1.0, 0.02)
    (setting,) = settings_for(robot, resolve_task("position", robot))
    q, h = np.zeros((1, 2)), 0.05
    _, _, bound, sigma, u, v, _ = enclose(robot, setting, q, None if ball else np.full((1, 2), h), radius=h)
    if ball:  # the bound is that of the radius, which is smaller than h
        h = enclose(robot, setting, q, radius=h)[1][0]
    error = region.change(robot, q[0], setting, np.array([[0, h], [0, -h]]), sigma[0], u[0], v[0])
    slope = region.change(robot, q[0], setting, np.array([[0, 1e-5], [0, -1e-5]]), sigma[0], u[0], v[0])
    third = np.abs((error[0] - error[1]) / 2 - h * (slope[0] - slope[1]) / 2e-5)
    if ball:
        (first, second), _ = ball_orders(robot, setting, q)
    else:
        (first, second, _), _ = coefficients(robot, setting, q[0], np.ones(2))
    rest = bound[0] - h * first - h * h * second
    assert (third <= rest * (1 + 1e-6) + 1e-12).all()
    assert (third / rest).max() > 0.97


def ball_orders(robot, setting, q):
    """First and second coefficient of the bound in the radius, from small balls."""
    radii = np.array([1e-3, 2e-3, 3e-3])
    rows = [enclose(robot, setting, q, radius=radius) for radius in radii]
    got = np.array([row[1][0] for row in rows])
    powers = got[:, None] ** np.arange(1, 4)
    terms = np.linalg.solve(powers, np.stack([row[2][0] for row in rows]).reshape(3, -1))
    return terms[:2].reshape(2, *rows[0][2].shape[1:]), got


def test_the_remainder_of_two_turns_and_a_slide_is_nearly_reached():
    # turn about z, slide along x, turn about z at the point: T = (M t³ + 3 t² s) / 6 with a reach of almost nothing
    z = np.array([0, 0, 0, 0, 0, 1.0])
    joints = [
        Joint("first", JointKind.REVOLUTE, z),
        Joint("slide", JointKind.PRISMATIC, np.array([1.0, 0, 0, 0, 0, 0])),
        Joint("last", JointKind.REVOLUTE, z),
    ]
    robot = Robot("turn slide turn", tuple(joints), task="position")
    (setting,) = settings_for_near_arms(robot, resolve_task("position", robot))
    q, t, s = np.array([0.0, 0.02, 0.3]), 0.02, 0.02
    half = np.array([0.0, s, t])
    free = enclose(robot, setting, q[None], half[None])
    bound, parts = free[2][0], (free[3][0], free[4][0], free[5][0])
    signs = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    moved = region.change(robot, q, setting, np.c_[np.zeros(4), signs * [s, t]], *parts)
    alone = region.change(robot, q, setting, np.array([[0, s, 0], [0, -s, 0]]), *parts)
    mixed = np.abs((moved[0] + moved[1] - moved[2] - moved[3]) / 4 - (alone[0] - alone[1]) / 2)  # ½ t² s ∂³E
    (first, second, _), _ = coefficients(robot, setting, q, half / t)
    rest = bound - t * first - t * t * second
    assert (mixed <= rest).all()
    assert (mixed / rest).max() > 0.95


@pytest.mark.slow
def test_rounding_is_allowed_for():
    # boxes of no width: what is left of the bound covers U₁ᵀ J V₁ − Σ, near singularities and far from the base
    far = np.eye(4)
    for shift in (0.0, 1e3, 1e6):
        far[:3, 3] = shift
        for name in ("pa10", "puma560", "stanford"):
            robot = region.moved_base(open_robot(name), far)
            sizes = 10.0 ** np.arange(-10, 5)[np.arange(60) % 15, None]
            q = np.random.default_rng(13).uniform(-1, 1, (60, robot.n)) * sizes
            for setting in settings_for(robot, resolve_task(None, robot))[::9]:
                _, _, bound, sigma, u, v, _ = enclose(robot, setting, q, np.zeros_like(q))
                error = np.stack(
                    [region.change(robot, *one[:1], setting, 0.0, *one[1:]) for one in zip(q, sigma, u, v, strict=True)]
                )
                assert (np.abs(error) <= bound).all()
                if shift == 0.0:
                    assert bound[np.abs(q).max(axis=1) < 10].max() < 1e-9
