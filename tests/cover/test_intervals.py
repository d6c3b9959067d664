"""What the checker encloses holds the arm's own values, at every place of a region, and is not much wider."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from reference import arms, region
from reference.displaced import displaced_arm

from rankdrop.cover.ball import ModelTolerance, points_of
from rankdrop.cover.setting import settings_for
from rankdrop.proof.arm import BITS, Arm, Region, flint
from rankdrop.proof.record import Link, Tolerance
from rankdrop.robot.model import Joint, JointKind, Mimic, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = {
    **{name: (lambda name=name: open_robot(name)) for name in ("ur5", "panda", "stanford", "almarkhi4")},
    "random screws": lambda: arms.random_chain(np.random.default_rng(5), "rhrphr"),
    "mimics": lambda: region.coupled(np.random.default_rng(6), "r p r1:0.3 p1:-0.4 r h0:2.5 r p0:0.3 r"),
}
OTHERS = {"slides": lambda: arms.random_chain(np.random.default_rng(4), "prrprr")} | {
    name: ARMS[name] for name in ("random screws", "mimics")
}
ROUNDED = 1e-11  # of the reference, in doubles


@pytest.fixture(autouse=True)
def bits():
    with flint().ctx.workprec(BITS):
        yield


def checker(robot, setting):
    """The arm as the checker sees it, and what turns numbers into intervals."""
    arb = flint().arb
    place = {joint.name: k for k, joint in enumerate(robot.variables)}
    links = [
        Link(str(joint.kind), tuple(joint.screw.tolist()), place[joint.mimic.leader if joint.mimic else joint.name],
             *((joint.mimic.multiplier, joint.mimic.offset) if joint.mimic else (1.0, 0.0)))
        for joint in robot.joints
    ]  # fmt: skip
    frame = robot.joints[setting.link - 1].frame if setting.link else np.eye(4)
    point = frame[:3, :3] @ np.array(setting.point) + frame[:3, 3]
    return Arm(links, robot.n, setting.link, [arb(float(x)) for x in point], arb(setting.length)), frame[:3, :3]


def values(robot, q, setting, turn, u, v):
    """U^T J V from the independent model, in the axes that the link has at q = 0 in base coordinates."""
    both = np.kron(np.eye(2), turn)
    full = np.zeros((6, robot.n))
    full[list(setting.rows)] = region.jacobian(robot, q, setting)
    return u.T @ (both @ full)[list(setting.rows)] @ v


def middles(found):
    low, high = np.array([[[float(x.lower()), float(x.upper())] for x in row] for row in found.tolist()]).T
    return (low.T + high.T) / 2, (high.T - low.T) / 2


@pytest.mark.spread(4)
@pytest.mark.by_hand_at(
    "False-0.3-mimics", "False-0.3-panda", "True-0.02-mimics", "True-0.02-panda", "True-0.3-mimics", "True-0.3-panda",
)
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("wide", [0.02, 0.3])
@pytest.mark.parametrize("along", [False, True])
def test_every_place_of_a_region_is_in_it(name, wide, along):
    robot = ARMS[name]()
    rng = np.random.default_rng(11)
    arb = flint().arb
    reached = 0.0
    for setting in settings_for(robot, resolve_task(None, robot))[::7]:
        arm, turn = checker(robot, setting)
        q = rng.uniform(-2, 2, robot.n)
        half = rng.uniform(0.3, 1.0, robot.n) * wide * (0.02 if along else 1.0)
        chord = rng.uniform(-1.0, 1.0, robot.n) * wide if along else np.zeros(robot.n)
        numbers = [[arb(float(x)) for x in row] for row in (q, half, chord)]
        place = Region(numbers[0], numbers[1], numbers[2] if along else None)
        found, u, v = arm.enclose(place, list(setting.rows), setting.rank)
        middle, width = middles(found)
        for k in range(60):
            s = rng.choice([-1.0, 1.0], robot.n) if k % 2 else rng.uniform(-1, 1, robot.n)
            t = rng.choice([-1.0, 1.0])
            off = np.abs(values(robot, q + half * s + chord * t, setting, turn, u, v) - middle)
            assert (off <= width + ROUNDED * (1 + np.abs(middle).max())).all()
            reached = max(reached, float((off / (width + 1e-9)).max()))
    if wide < 0.1:
        assert reached > 0.9


def test_a_region_without_size_is_a_point():
    robot = open_robot("ur5")
    setting = settings_for(robot, resolve_task(None, robot))[3]
    arm, turn = checker(robot, setting)
    q = np.array([0.3, -0.8, 1.2, 0.4, 0.9, 0.1])
    zero = [flint().arb(0)] * 6
    found, u, v = arm.enclose(Region([flint().arb(float(x)) for x in q], zero), list(setting.rows), 6)
    middle, width = middles(found)
    assert width.max() < 1e-15
    np.testing.assert_allclose(middle, values(robot, q, setting, turn, u, v), atol=1e-12)


@pytest.mark.by_hand_at("random screws-pose", "slides-pose", "ur5-pose", "stanford-pose")
@pytest.mark.by_hand_at("panda-pose", "mimics-pose")
@pytest.mark.slow_at("mimics-pose", "panda-pose", "random screws-pose", "ur5-pose", "slides-pose", "stanford-pose")
@pytest.mark.parametrize(("name", "task"), [
    ("ur5", "pose"), ("panda", "pose"), ("stanford", "pose"), ("slides", "pose"), ("stanford", "position"),
    ("random screws", "pose"), ("mimics", "pose"),
])  # fmt: skip
def test_arms_within_a_tolerance_are_in_it_and_the_worst_of_them_reach_its_ends(name, task):
    robot = OTHERS[name]() if name in OTHERS else open_robot(name)
    rng = np.random.default_rng(12)
    arb = flint().arb
    near = ModelTolerance(3e-4, 1e-3)
    told = Tolerance(near.length, near.angle, points_of(robot))
    reached, count = 0.0, len(robot.joints)
    tool_moves = task == "position"
    for setting in settings_for(robot, resolve_task(task, robot))[::5]:
        arm, turn = checker(robot, setting)
        q = rng.uniform(-2, 2, robot.n)
        zero = [arb(0)] * robot.n
        found, u, v = arm.enclose(Region([arb(float(x)) for x in q], zero), list(setting.rows), setting.rank, told)
        middle, width = middles(found)

        def value(turns, moves, tool, setting=setting, turn=turn, u=u, v=v, q=q):
            point = tuple(np.array(setting.point) + turn.T @ tool * tool_moves)
            return values(displaced_arm(robot, turns, moves), q, replace(setting, point=point), turn, u, v)

        for _ in range(60):
            parts = [rng.standard_normal((count, 3)) for _ in range(2)] + [rng.standard_normal((1, 3))]
            parts = [one / np.linalg.norm(one, axis=1, keepdims=True) for one in parts]
            off = np.abs(value(parts[0] * near.angle, parts[1] * near.length, parts[2][0] * near.length) - middle)
            assert (off <= width + ROUNDED).all()
        start, step = value(np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(3)), 1e-5
        slope = np.empty((2 * count + 1, 3, *start.shape))  # by every turn and move of every joint, and of the tool
        for k in range(2 * count + 1):
            for axis in range(3):
                some = np.zeros((2 * count + 1, 3))
                some[k, axis] = step
                slope[k, axis] = (value(some[:count], some[count:-1], some[-1]) - start) / step
        size = np.array([near.angle] * count + [near.length] * (count + 1))[:, None]
        for r in range(len(start)):
            for c in range(len(start)):
                way = slope[:, :, r, c]
                worst = size * way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-30)
                off = np.abs(value(worst[:count], worst[count:-1], worst[-1]) - middle)
                assert (off <= width + ROUNDED).all()
                if width[r, c] > 1e-6:
                    reached = max(reached, off[r, c] / width[r, c])
    assert reached > 0.9


X, Z = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
STEEP = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 1.0])
ROUND = np.array([0.0, 0.0, 5.0 / (2 * np.pi), 0.0, 0.0, 1.0])  # a whole turn carries by five
UP = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
TURN, SLIDE, SCREW = JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.HELICAL


MANY = 8  # joints before what is carried: all turned they outweigh what those turns add that are made far out
CARRIERS = {
    "slide": (SLIDE, UP, None, 5.0),
    "screw": (SCREW, ROUND, None, 2 * np.pi),
    "offset of a slide": (SLIDE, UP, Mimic("j0", 1.0, 5.0), 0.0),
    "multiplier of a slide": (SLIDE, UP, Mimic("j0", 2.5 / np.pi, 0.0), 2 * np.pi),
    "offset of a screw": (SCREW, ROUND, Mimic("j0", 1.0, 2 * np.pi), 0.0),
}


def one_entry(joints, q, link, row, angle):
    """(what arms add whose joints are all turned about x by an angle, what is allowed for it), of one entry of J."""
    robot = Robot("test", tuple(
        Joint(f"j{k}", kind, screw, mimic=mimic) for k, (kind, screw, mimic) in enumerate(joints)
    ), np.eye(4))  # fmt: skip
    arb = flint().arb
    setting = SimpleNamespace(link=link, point=(0.0, 0.0, 0.0), length=1.0, rows=(row,))
    arm, turn = checker(robot, setting)
    place = Region([arb(float(x)) for x in q], [arb(0)] * robot.n)
    found, u, v = arm.enclose(place, [row], 1, Tolerance(0.0, angle, points_of(robot)))
    middle, width = middles(found)
    turns = np.tile([angle, 0.0, 0.0], (len(joints), 1))
    other = displaced_arm(robot, turns, np.zeros((len(joints), 3)))
    return float(np.abs(values(other, np.array(q), setting, turn, u, v) - middle).item()), float(width.item())


@pytest.mark.parametrize("carrier", CARRIERS)
@pytest.mark.parametrize("end", [0, 1])
def test_how_far_a_joint_carries_counts_where_turns_do_nothing_at_first(carrier, end):
    """An entry that turns about x change by d (1 − cos θ), d how far out an axis is carried: of second order alone."""
    kind, screw, mimic, value = CARRIERS[carrier]
    many, outer = [(TURN, Z, None)] * MANY, (TURN, X, None)
    first = 2 * np.pi if carrier == "multiplier of a slide" else 0.0
    if end:  # seen from the last link
        joints = [outer, (kind, screw, mimic), *many]
        q = [first, *([] if mimic else [value]), *[0.0] * MANY]
    else:
        joints = [*many, (kind, screw, mimic), outer]
        q = [first, *[0.0] * (MANY - 1), *([] if mimic else [value]), 0.0]
    off, width = one_entry(joints, q, len(joints) * end, 1, 0.02)
    assert off > 4.9 * (1 - np.cos(MANY * 0.02))
    assert 0.2 * width < off <= width


@pytest.mark.parametrize(("joints", "link"), [
    ([(SCREW, STEEP, None)], 0), ([(SCREW, STEEP, None), (TURN, Z, None)], 2),
])  # fmt: skip
def test_the_pitch_of_a_screw_counts_where_turns_do_nothing_at_first(joints, link):
    off, width = one_entry(joints, [0.0] * len(joints), link, 2, 0.05)
    assert off > 4.9 * (1 - np.cos(0.05))
    assert 0.2 * width < off <= width
