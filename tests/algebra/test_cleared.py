"""Entries that are numbers clear rows and columns: the rank falls by one with each, everywhere."""

from __future__ import annotations

import random
from dataclasses import replace
from math import pi

import pytest
from reference.arms import standard_dh

pytest.importorskip("flint")

from rankdrop.algebra.field import ModularPoint, P, complete, rank, value_at
from rankdrop.algebra.work import Work
from rankdrop.exact.arm.chain import WIDE, Chain, exact_chain
from rankdrop.exact.arm.verify import rank_modulo
from rankdrop.exact.tree import rank_tree
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import BODY, WORLD_ALIGNED, resolve_task
from rankdrop.verbs.conditions import conditions

HALF = pi / 2
WRIST = [(0, HALF, 0.35, 0), (0, -HALF, 0, 0), (0, 0, 0.1, 0)]
ELBOW = [(0, HALF, 0, 0), (0.3, 0, 0, 0), (0, HALF, 0, 0), *WRIST]


def gantry(slides: int) -> Robot:
    """An elbow arm with a spherical wrist that hangs on slides square to one another."""
    return standard_dh("gantry", [*[(0, HALF, 0, HALF, 1)] * slides, *ELBOW])


def rank_at(chain: Chain, columns, seed: int, pins: dict[int, str]) -> int:
    rng = random.Random(seed)
    point = complete(chain.ring, ModularPoint({name: rng.randrange(2, P) for name in chain.ring.names}), pins)
    assert point is not None
    return rank([[value_at(chain.ring, x, point) if x != 0 else 0 for x in column] for column in columns])


@pytest.mark.parametrize("robot", [gantry(1), gantry(2), gantry(3), open_robot("tiago")], ids=lambda one: str(one.n))
def test_the_rank_is_that_of_the_jacobian_everywhere(robot: Robot) -> None:
    chain = exact_chain(robot)
    columns, lower = chain.cleared_columns
    assert lower >= 2
    assert len(columns) == chain.n - lower
    met = set()
    for seed in range(60):
        rng = random.Random(seed)
        pins = {j: rng.choice(["0", "pi", "pi/2"]) for j in rng.sample(chain.ring.revolute, rng.randrange(7))}
        full = rank_at(chain, chain.columns, seed, pins)
        assert rank_at(chain, columns, seed, pins) + lower == full
        met.add(full)
    assert len(met) > 1


@pytest.mark.slow
@pytest.mark.parametrize("rows", ["vx,vy,vz,wx,wy", "vx,vy,vz,wz", "vx,vz,wx,wy,wz"])
@pytest.mark.parametrize("frame", [BODY, WORLD_ALIGNED])
@pytest.mark.parametrize("name", ["iiwa7", "ur5"])
def test_rows_left_out_are_screws_added(name: str, rows: str, frame: int) -> None:
    """The rank of a task's rows is that of the matrix with a screw for each other row, everywhere."""
    robot = open_robot(name)
    chain = exact_chain(robot, replace(resolve_task(rows, robot), frame=frame), lengths="numbers")
    columns, lower = chain.cleared_columns
    for seed in range(6):
        rng = random.Random(seed)
        pins = {j: rng.choice(["0", "pi", "pi/2"]) for j in rng.sample(chain.ring.revolute, seed)}
        point = complete(chain.ring, ModularPoint({x: rng.randrange(2, P) for x in chain.ring.names}), pins)
        assert point is not None
        full = rank([[value_at(chain.ring, x, point) for x in column] for column in chain.columns])
        matrix = [[value_at(chain.ring, x, point) if x != 0 else 0 for x in column] for column in columns]
        assert rank(matrix) + lower == full == rank_modulo(chain, point)


def test_slides_in_all_directions_leave_the_wrist() -> None:
    """What turns the end effector is left: three rows of it, less the axis whose own link's frame is taken."""
    chain = exact_chain(gantry(3))
    columns, lower = chain.cleared_columns
    assert (lower, len(columns[0])) == (4, 2)
    assert rank_tree(chain, Work(60.0)).generic_rank == 6


def test_a_redundant_arm_on_a_gantry_is_derived_to_the_end() -> None:
    found = conditions(gantry(3), points=300)
    assert found.chain.n > WIDE
    assert not found.letters
    assert found.complete
    assert found.method == "reciprocity"
    assert found.families
    assert found.explained.holds
