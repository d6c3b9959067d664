"""Tool motions along the direction that is lost, in axes of the base and of the tip; and poses moved by them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from rankdrop.kinematics import pose
from rankdrop.path.mend.lost_direction import lost_motions, moved_along
from rankdrop.poses.inverse import Aim
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.task import BASE, TIP, Frame, resolve_task

ARM = open_robot("ur5e")
BENT = (0.4, -1.1, 0.9, 0.7, 0.8, -0.3)
SINGULAR = {"wrist": (0.4, -1.1, 0.9, 0.7, 0.0, -0.3), "elbow": (0.4, -1.1, 0.0, 0.7, 0.8, -0.3)}
POINT = (0.02, -0.01, 0.1)  # of the tool, in axes of the tip [m]
FRAMES = {"pose": None, "tool-axis-free": Frame(TIP, TIP, POINT), "position": Frame(BASE, TIP, POINT),
          "orientation": None, "across-tool-axis": None}  # fmt: skip
"""Task -> the frame in which its rows are taken; its own where None."""


def hat(way: Array) -> Array:
    x, y, z = way
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def exponential(twist: Array, point: Array) -> Array:
    """(4, 4) the motion of a constant twist (6,), its linear part taken at a point (3,)."""
    generator = np.zeros((4, 4))
    generator[:3, :3] = hat(twist[3:])
    generator[:3, 3] = twist[:3] - hat(twist[3:]) @ point
    return expm(generator)


def aim_of(name: str) -> Aim:
    return Aim(ARM, resolve_task(name, ARM, frame=FRAMES[name]))


@pytest.mark.parametrize("kind", ["way", "turn"])
@pytest.mark.parametrize("name", FRAMES)
def test_a_pose_is_moved_by_the_exponential_of_its_twist(name: str, kind: str, rng: np.random.Generator) -> None:
    """Straight, or about an axis through the reference point: from the left in axes of the base, else from the right.
    """
    aim = aim_of(name)
    chosen = np.array([(row < 3) == (kind == "way") for row in aim.rows])
    twists = rng.normal(size=(5, len(aim.rows))) * chosen
    poses = pose(ARM, rng.uniform(-2.0, 2.0, (5, 6)))
    for old, new, twist in zip(poses, moved_along(aim, poses, twists), twists, strict=True):
        whole = np.zeros(6)
        whole[aim.rows] = twist
        whole[:3] *= aim.length
        if aim.with_tip:
            wanted = old @ exponential(whole, aim.point)
        else:
            wanted = exponential(whole, old[:3, :3] @ aim.point + old[:3, 3]) @ old
        np.testing.assert_allclose(new, wanted, atol=1e-12)


@pytest.mark.parametrize("name", FRAMES)
def test_a_small_motion_is_missing_to_first_order(name: str, rng: np.random.Generator) -> None:
    """Way and turn at once: the error that Newton's method sees is the twist."""
    aim = aim_of(name)
    q = rng.uniform(-2.0, 2.0, (5, 6))
    twists = 1e-5 * rng.normal(size=(5, len(aim.rows)))
    np.testing.assert_allclose(aim.error(moved_along(aim, pose(ARM, q), twists), q), twists, atol=1e-9)


def size(motion: Array, ways: Array) -> Array:
    """|w_v| + |w_ω| of tool motions (…, m)."""
    return np.linalg.norm(motion[..., ways], axis=-1) + np.linalg.norm(motion[..., ~ways], axis=-1)


@pytest.mark.parametrize(("name", "family"), [("pose", "wrist"), ("pose", "elbow"), ("tool-axis-free", "wrist")])
def test_no_tool_motion_of_that_size_goes_farther_along_the_lost_direction(
    name: str, family: str, rng: np.random.Generator
) -> None:
    aim = aim_of(name)
    q = np.array(SINGULAR[family])
    values, left = lost_by_differences(aim, q)
    rank = int((values > 1e-6).sum()) + 1
    lost = left[:, rank - 1]
    ways = np.array([row < 3 for row in aim.rows])
    first, *others = lost_motions(aim, rank, q)
    shares = [abs(lost @ other) for other in others]
    assert size(first, ways) == pytest.approx(1.0)
    assert all(size(other, ways) == pytest.approx(1.0) for other in others)
    assert all(far <= abs(lost @ first) for far in shares)
    random = rng.normal(size=(5000, len(aim.rows)))
    random /= size(random, ways)[:, None]
    assert np.abs(random @ lost).max() <= abs(lost @ first) + 1e-9
    assert np.hypot(abs(lost @ first), *shares) == pytest.approx(1.0)  # they are the parts of û, and no more


def lost_by_differences(aim: Aim, q: Array) -> tuple[Array, Array]:
    """Singular values and left singular vectors of J, from differences of poses."""
    h = 1e-6
    here = pose(ARM, q)
    columns = []
    for joint in range(ARM.n):
        up, down = (pose(ARM, q + sign * h * np.eye(ARM.n)[joint]) for sign in (1.0, -1.0))
        ahead, behind = (tip[:3, :3] @ aim.point + tip[:3, 3] for tip in (up, down))
        way = (ahead - behind) / (2 * h)
        turning = (up[:3, :3] - down[:3, :3]) @ here[:3, :3].T / (2 * h)
        turn = np.array([turning[2, 1], turning[0, 2], turning[1, 0]])
        if aim.with_tip:
            way, turn = here[:3, :3].T @ way, here[:3, :3].T @ turn
        columns.append(np.concatenate([way / aim.length, turn])[aim.rows])
    left, values, _ = np.linalg.svd(np.array(columns).T)
    return values, left


@pytest.mark.parametrize("rank", [5, 6])
def test_the_lost_direction_is_the_singular_vector_of_the_rank_that_is_given(rank: int) -> None:
    aim = aim_of("pose")
    lost = lost_by_differences(aim, np.array(BENT))[1][:, rank - 1]
    parts = lost_motions(aim, rank, np.array(BENT))
    assert len(parts) == 2
    assert np.hypot(*(lost @ part for part in parts)) == pytest.approx(1.0)


def test_at_the_edge_of_reach_the_way_alone_is_lost() -> None:
    """The stretched arm of two links cannot move along itself, and its task has no turns."""
    robot = open_robot("planar2r")
    aim = Aim(robot, resolve_task("planar-position", robot))
    (motion,) = lost_motions(aim, 2, np.array([0.3, 0.0]))
    np.testing.assert_allclose(np.abs(motion), [np.cos(0.3), np.sin(0.3)], atol=1e-12)
    straight = moved_along(aim, pose(robot, np.array([[0.3, 0.0]])), 0.1 * motion[None])[0]
    stretched = pose(robot, np.array([0.3, 0.0]))
    np.testing.assert_array_equal(straight[:3, :3], stretched[:3, :3])
    np.testing.assert_allclose(
        np.abs(np.linalg.norm(straight[:2, 3]) - np.linalg.norm(stretched[:2, 3])), 0.1 * aim.length
    )
