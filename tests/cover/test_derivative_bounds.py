"""M_i: no derivative of a column is larger, and some come close."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from reference import arms, region
from reference.measure import central_differences

from rankdrop.cover.setting import enclose, settings_for
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = {
    **{name: (lambda name=name: open_robot(name)) for name in ("panda", "pa10", "puma560", "scara", "stanford")},
    "random 7R": lambda: arms.random_chain(np.random.default_rng(3), "rrrrrrr"),
    "random slides": lambda: arms.random_chain(np.random.default_rng(4), "rprrpr"),
    "random screws": lambda: arms.random_chain(np.random.default_rng(5), "rhrphrr"),
    "mimics": lambda: region.coupled(np.random.default_rng(6), "r p r1:0.3 p1:-0.4 r h0:2.5 r p0:0.3 r"),
    "five joints": lambda: arms.random_chain(np.random.default_rng(7), "rrrrr"),
    "regional": lambda: open_robot("almarkhi4"),
}


def levers(robot, setting, arm):
    """(N, 2) bound on derivatives by turns alone, and with one slide among them, both without multipliers."""
    times = np.array([abs(joint.mimic.multiplier) if joint.mimic else 1.0 for joint in robot.joints])
    turning = np.array([joint.kind is not JointKind.PRISMATIC for joint in robot.joints])
    return np.stack([arm / times, np.where(turning, float(0 in setting.rows), 0.0)], axis=1)


def configurations(robot, count, seed):
    """Random ones, and multiples of a quarter turn: straight and folded arms, where the bound is reached."""
    rng = np.random.default_rng(seed)
    grid = np.array(list(product((0.0, np.pi / 2, np.pi), repeat=min(robot.n, 4))))
    quarter = rng.integers(-1, 3, (count, robot.n)) * (np.pi / 2)
    quarter[: len(grid), : grid.shape[1]] = grid[:count]
    return np.concatenate([quarter, rng.uniform(-np.pi, np.pi, (count, robot.n))])


@pytest.mark.spread(4)
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("task", ["pose", "position", "orientation"])
def test_no_derivative_is_larger(name, task):
    robot = ARMS[name]()
    largest = 0.0
    for setting in settings_for(robot, resolve_task(task, robot))[::9]:
        q = configurations(robot, 8, 1)
        half = np.full_like(q, 0.3)
        arm = enclose(robot, setting, q, half)[6]
        corner = q + np.random.default_rng(2).uniform(-1, 1, q.shape) * half * setting.scale  # anywhere in the box
        for row, bounds in zip(corner, arm, strict=True):
            bound = levers(robot, setting, bounds)
            for order in region.derivatives(robot, row, setting):
                for i, slides, size in order:
                    assert size <= (bound[i, slides] if slides < 2 else 0.0) * (1 + 1e-12) + 1e-13
                    largest = max(largest, size)
    assert largest > 0.0 or (name, task) == ("scara", "orientation")  # all its axes are parallel


@pytest.mark.spread(1)
@pytest.mark.by_hand_at("0-pa10", "0-panda", "1-panda", "2-pa10", "2-panda", "2-puma560")
@pytest.mark.slow_at("2-panda", "1-panda", "0-panda", "pa10", "1-puma560", "0-puma560", "2-puma560")
@pytest.mark.parametrize("name", ["panda", "pa10", "puma560"])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_bound_is_reached(name, order):
    robot = open_robot(name)
    best = np.zeros(robot.n)
    for setting in settings_for(robot, resolve_task("pose", robot))[::4]:
        q = configurations(robot, 30, 3)[:30]
        arm = enclose(robot, setting, q, np.zeros_like(q))[6]
        for row, bounds in zip(q, arm, strict=True):
            for i, _, size in region.derivatives(robot, row, setting)[order]:
                best[i] = max(best[i], size / bounds[i])
    assert best[0] > 0.98  # the first axis has the longest reach: the sum of all links counts
    assert (best > 0.98).sum() >= robot.n - 2


TURNS = 40 * np.pi
"""That carry a screw three metres [rad]."""


def row_of_axes(second, steep=0.0):
    """Axes of z a metre apart along x, the second a slide or a screw along x; the third a screw of this pitch."""
    joints = []
    for i in range(5):
        frame = np.eye(4)
        frame[0, 3] = float(i)
        axis = np.array([1.0, 0.0, 0.0] if i == 1 else [0.0, 0.0, 1.0])
        screw = np.concatenate([np.cross([float(i), 0.0, 0.0], axis), axis])
        kind = JointKind.REVOLUTE
        if i == 1 and second == "slide":
            kind, screw = JointKind.PRISMATIC, np.concatenate([axis, np.zeros(3)])
        elif i == 1:
            kind, screw = JointKind.HELICAL, screw + np.concatenate([3.0 / TURNS * axis, np.zeros(3)])
        if i == 2 and steep:
            kind, screw = JointKind.HELICAL, screw + np.concatenate([steep * axis, np.zeros(3)])
        joints.append(Joint(f"j{i + 1}", kind, screw, frame=frame))
    home = np.eye(4)
    home[0, 3] = 5.0
    return Robot("row", tuple(joints), home)


def reached(robot, q, half):
    """(N,) largest share of M_i by turns, at the far corner of a box."""
    best = np.zeros(robot.n)
    for setting in settings_for(robot, resolve_task("pose", robot)):
        scaled = half / setting.scale
        arm = enclose(robot, setting, q[None], scaled[None])[6][0]
        for order in region.derivatives(robot, q + half, setting):
            for i, slides, size in order:
                assert size <= arm[i] * (1 + 1e-12)
                if not slides and robot.joints[i].kind is not JointKind.PRISMATIC:
                    best[i] = max(best[i], size / arm[i])
    return best


@pytest.mark.parametrize(("second", "far"), [("slide", 3.0), ("screw", TURNS)])
def test_the_bound_of_an_axis_behind_what_carries_far_is_reached(second, far):
    """Stretched out along the slide, at the end of the box where it is farthest out."""
    half = np.array([0.0, 0.2, 0.0, 0.0, 0.0])
    assert reached(row_of_axes(second), np.array([0.0, far - 0.2, 0.0, 0.0, 0.0]), half)[0] > 0.95


def test_the_bound_of_a_steep_screw_is_reached_by_its_own_column_and_by_one_behind_it():
    best = reached(row_of_axes("screw", steep=200.0), np.zeros(5), np.zeros(5))
    assert (best[1:3] > 0.95).all()


@pytest.mark.slow
def test_brackets_are_the_derivatives():
    # what the two tests above call derivatives, against differences of the columns
    robot = arms.random_chain(np.random.default_rng(8), "rhprrr")
    setting = settings_for(robot, resolve_task("pose", robot))[5]
    q = np.random.default_rng(9).uniform(-1, 1, robot.n)

    def first(x):
        return central_differences(lambda y: region.columns(robot, y, setting), x)

    unit = np.array([setting.length if joint.kind is JointKind.PRISMATIC else 1.0 for joint in robot.joints])
    second = np.linalg.norm(central_differences(first, q) * unit[:, None] * unit, axis=1)
    want = [np.sort(np.linalg.norm(first(q) * unit, axis=1).ravel()), np.sort(second[:, *np.triu_indices(6)].ravel())]
    got = [np.sort([size for *_, size in order]) for order in region.derivatives(robot, q, setting)]
    for one, other in zip(got, want, strict=False):
        np.testing.assert_allclose(one, other[-len(one) :], atol=1e-8)  # what is left over are zeros
        assert np.abs(other[: -len(one)]).max() < 1e-8
    assert len(got[0]) > 5
    assert len(got[2]) > len(got[1]) > len(got[0])  # the third goes on in the same way
