"""Where the last link is, in intervals: the reference kinematics inside, and no wider than rounding."""

from __future__ import annotations

import flint
import numpy as np
import pytest
from reference import kinematics
from reference.arms import random_chain

from rankdrop.proof.record import Link
from rankdrop.proof.tip import tip_motion, turn_about, velocity
from rankdrop.robot.model import Robot

pytestmark = pytest.mark.usefixtures("precise")
CHAINS = ("rrr", "rpr", "rhr", "rrmrrrr")


def links_of(robot: Robot) -> list[Link]:
    """The chain as a certificate has it."""
    matrix, offset = kinematics.coupling(robot)
    return [
        Link(str(joint.kind), tuple(joint.screw.tolist()), int(np.abs(matrix[i]).argmax()),
             float(matrix[i][np.abs(matrix[i]).argmax()]), float(offset[i]))
        for i, joint in enumerate(robot.joints)
    ]  # fmt: skip


def middles(matrix: flint.arb_mat) -> np.ndarray:
    """The middles of intervals, none of which is wider than 1e-15."""
    entries = [[matrix[i, j] for j in range(matrix.ncols())] for i in range(matrix.nrows())]
    assert max(float(x.rad()) for row in entries for x in row) < 1e-15
    return np.array([[float(x.mid()) for x in row] for row in entries])


@pytest.mark.parametrize("chain", CHAINS)
def test_the_motion_of_the_last_link_is_that_of_the_reference(chain: str, rng: np.random.Generator) -> None:
    robot = random_chain(rng, chain)
    for q in rng.uniform(-2, 2, (5, robot.n)):
        turn, place = tip_motion(links_of(robot), [flint.arb(float(x)) for x in q])
        motion = kinematics.carried(robot, q)[-1]
        assert middles(turn) == pytest.approx(motion[:3, :3], abs=1e-12)
        assert middles(place)[:, 0] == pytest.approx(motion[:3, 3], abs=1e-12)


def test_a_screw_of_any_length_has_the_same_axis() -> None:
    """Its doubles are those of a file: the direction counts, and the pitch ω·v/|ω|²."""
    turning, sliding = np.array([0.3, -0.2, 0.5, 0.6, 0.0, 0.8]), np.array([0.6, 0.0, 0.8, 0.0, 0.0, 0.0])
    q = [flint.arb(0.7)]
    for kind, screw in (("revolute", turning), ("helical", turning), ("prismatic", sliding)):
        (one, at), (other, there) = (
            tip_motion([Link(kind, tuple((length * screw).tolist()), 0)], q) for length in (1.0, 2.5)
        )
        assert middles(one) == pytest.approx(middles(other), abs=1e-15)
        assert middles(at) == pytest.approx(middles(there), abs=1e-15)


def test_a_rotation_keeps_its_axis_and_lengths(rng: np.random.Generator) -> None:
    axis = np.array([2.0, -3.0, 6.0]) / 7.0
    for angle in rng.uniform(-3, 3, 5):
        turn = middles(turn_about([flint.arb(float(x)) for x in axis], flint.arb(float(angle))))
        assert turn @ axis == pytest.approx(axis, abs=1e-15)
        assert turn @ turn.T == pytest.approx(np.eye(3), abs=1e-14)
        assert np.trace(turn) == pytest.approx(1 + 2 * np.cos(angle))
        across = np.cross(axis, [1.0, 0.0, 0.0])
        assert np.cross(across, turn @ across) @ axis == pytest.approx(np.sin(angle) * (across @ across))


def test_the_velocity_of_a_point_is_its_derivative(rng: np.random.Generator) -> None:
    screw, point, step = rng.normal(size=6), rng.normal(size=3), 1e-6
    unit = screw / np.linalg.norm(screw[3:])
    ends = [kinematics.exponential(unit, x) @ [*point, 1.0] for x in (-step, step)]
    slope = (ends[1] - ends[0])[:3] / (2 * step)
    found = velocity([flint.arb(float(x)) for x in unit], [flint.arb(float(x)) for x in point])
    assert [float(x.mid()) for x in found] == pytest.approx(slope, abs=1e-8)
