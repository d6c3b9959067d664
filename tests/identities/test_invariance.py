"""What must not depend on how an arm is described: base, tool, units, joint signs, direction of the chain.

Every law is tried at generic configurations, at exactly singular ones and next to these; none is filtered out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference import arms
from reference.measure import relative

from rankdrop.kinematics import pose
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import BODY, SPACE, WORLD_ALIGNED, Frame, resolve_task
from rankdrop.tolerances import DEFAULT

NAMED = ["pa10", "puma", "scara", "planar3r"]
RANDOM = ["rrrrrr", "rrrrrrr", "rrhrrr", "rrprrr", "rpr", "rrmrrrr", "rrrrrrrr"]


def cases(name: str, rng: np.random.Generator) -> tuple[Robot, Array]:
    """An arm with 27 configurations: generic, exactly singular (where known in closed form), and 1e-6 from singular."""
    if name in NAMED:
        robot, singular = arms.singular_configurations(name, rng, 9)
    else:
        robot = arms.random_chain(rng, name)
        singular = np.zeros((9, robot.n))
    generic = rng.uniform(-np.pi, np.pi, singular.shape)
    return robot, np.concatenate([generic, singular, singular + 1e-6 * rng.normal(size=singular.shape)])


def rank(robot: Robot, q: Array, task: str = "pose", frame: Frame = WORLD_ALIGNED) -> Array:
    """Ranks by the product's own threshold, lengths in metres."""
    return (singular_values(robot, q, resolve_task(task, robot, frame=frame)) > DEFAULT.singular).sum(axis=-1)


@pytest.mark.parametrize("name", NAMED + RANDOM)
@pytest.mark.parametrize("frame", [BODY, WORLD_ALIGNED, Frame(1, -1), Frame(1, 1, (0.1, 0.2, 0.3))], ids=str)
def test_singular_values_do_not_depend_on_where_the_base_stands(
    name: str, frame: Frame, rng: np.random.Generator
) -> None:
    """The default length scale, the reach, does not either."""
    robot, q = cases(name, rng)
    elsewhere = arms.remade(robot, motion=arms.rigid(rng))
    here = singular_values(robot, q, resolve_task("pose", robot, frame=frame))
    there = singular_values(elsewhere, q, resolve_task("pose", elsewhere, frame=frame))
    assert relative(there, here) < 1e-13


@pytest.mark.parametrize("name", NAMED + RANDOM)
def test_rank_does_not_depend_on_the_tool_or_on_the_frame(name: str, rng: np.random.Generator) -> None:
    robot, q = cases(name, rng)
    want = rank(robot, q)
    tool = replace(robot, home=robot.home @ arms.rigid(rng, shift=0.3))
    np.testing.assert_array_equal(rank(tool, q), want)
    for frame in (SPACE, BODY, Frame(1, 1, (0.3, 0.1, -0.2)), Frame(0, 1)):
        np.testing.assert_array_equal(rank(robot, q, frame=frame), want)


@pytest.mark.parametrize("name", NAMED + RANDOM)
def test_unit_of_length(name: str, rng: np.random.Generator) -> None:
    """Over the reach, σ is a pure number; with slides among the joints only the rank is, since columns mix units."""
    robot, q = cases(name, rng)
    millimetres = arms.remade(robot, length=1000.0)
    slides = np.array([joint.kind is JointKind.PRISMATIC for joint in robot.variables])
    q_mm = np.where(slides, 1000.0 * q, q)
    if slides.any():
        np.testing.assert_array_equal(rank(millimetres, q_mm), rank(robot, q))
        return
    here = singular_values(robot, q, resolve_task("pose", robot))
    there = singular_values(millimetres, q_mm, resolve_task("pose", millimetres))
    assert relative(there, here) < 1e-13


@pytest.mark.parametrize("name", NAMED + RANDOM)
def test_sign_of_the_joints(name: str, rng: np.random.Generator) -> None:
    robot, q = cases(name, rng)
    task = resolve_task("pose", robot)
    assert relative(singular_values(arms.remade(robot, sign=-1.0), -q, task), singular_values(robot, q, task)) < 1e-13


@pytest.mark.parametrize("name", [*NAMED, *(kinds for kinds in RANDOM if "m" not in kinds)])
def test_reversal_of_the_chain(name: str, rng: np.random.Generator) -> None:
    """Held at its tip, the arm has the inverse pose, the same rank, and the same σ about the same point."""
    robot, q = cases(name, rng)
    backwards, q_back = arms.reversed_chain(robot), q[:, ::-1]
    assert relative(pose(backwards, q_back), np.linalg.inv(pose(robot, q))) < 1e-12
    here = singular_values(robot, q, resolve_task("pose", robot, frame=SPACE, length_scale=1.0))
    there = singular_values(backwards, q_back, resolve_task("pose", backwards, frame=WORLD_ALIGNED, length_scale=1.0))
    assert relative(there, here) < 1e-12
    np.testing.assert_array_equal(rank(backwards, q_back), rank(robot, q))


@pytest.mark.parametrize("name", ["pa10", "puma", "rrrrrrr", "hrrrh"])
def test_first_and_last_turning_joints_do_not_matter_for_the_rank(name: str, rng: np.random.Generator) -> None:
    robot, q = cases(name, rng)
    turned = q.copy()
    turned[:, [0, -1]] = rng.uniform(-np.pi, np.pi, (len(q), 2))
    np.testing.assert_array_equal(rank(robot, turned), rank(robot, q))
    first_link = resolve_task("pose", robot, frame=Frame(1, 1))  # where the other axes do not see the two turn
    assert relative(singular_values(robot, turned, first_link), singular_values(robot, q, first_link)) < 1e-12


@pytest.mark.parametrize(
    ("name", "task", "want"),
    [
        ("pa10", "pose", 6), ("puma", "pose", 6), ("scara", "pose", 4), ("scara", "scara", 4),
        ("planar3r", "pose", 3), ("planar3r", "planar", 3), ("planar3r", "planar-position", 2),
        ("planar3r", "orientation", 1), ("pa10", "position", 3), ("pa10", "vz", 1),
    ],
)  # fmt: skip
def test_generic_rank(name: str, task: str, want: int, rng: np.random.Generator) -> None:
    robot, _ = cases(name, rng)
    assert generic_rank(robot, resolve_task(task, robot)) == want


def test_coranks_of_the_known_singular_rows_of_the_pa10(rng: np.random.Generator) -> None:
    """AM Tables 3, 4 and 5: four rows of corank 1, four of corank 2, one of corank 3."""
    robot, q = arms.singular_configurations("pa10", rng, 90)
    np.testing.assert_array_equal(6 - rank(robot, q), np.tile([1, 1, 1, 1, 2, 2, 2, 2, 3], 10))


@pytest.mark.parametrize("pinned", [{2: 0.0}, {6: 0.0}, {2: 0.0, 3: 0.0}, {5: 0.0, 6: 0.0}], ids=str)
def test_configurations_of_the_pa10_that_look_singular_and_are_not(
    pinned: dict[int, float], rng: np.random.Generator
) -> None:
    robot = arms.pa10()
    q = rng.uniform(-np.pi, np.pi, (200, 7))
    for joint, value in pinned.items():
        q[:, joint - 1] = value
    assert (rank(robot, q) == 6).all()
