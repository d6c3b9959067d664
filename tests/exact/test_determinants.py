"""Determinants said out loud are those of the numeric Jacobian, number and sign included."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from rankdrop.algebra.work import Work
from rankdrop.codec import encode
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.determinants import Minor, MinorOf, determinants_of
from rankdrop.formula.notation import Python
from rankdrop.formula.value import Value
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import sample
from rankdrop.robot.open import open_robot
from rankdrop.schema.families import DETERMINANTS
from rankdrop.task import ROWS, resolve_task


def texts(name: str, task: str | None = None) -> list[str]:
    found = determinants_of(exact_chain(open_robot(name), task), Work())
    assert not found.left
    return [f"{one.name} = {one.value.text()}" for one in found.minors]


def values(one: Minor, chain, q) -> np.ndarray:
    """What the code that is written gives."""
    text = one.value.code(Python(shifts=chain.shifts))
    joints = {f"q{j}": q[:, j - 1] for j in range(1, chain.n + 1)}
    return eval(text, {"sin": np.sin, "cos": np.cos, **chain.numbers, **joints}) + np.zeros(len(q))


def test_the_planar_arm_of_the_lecture() -> None:
    assert texts("planar2r") == ["det J = a1 a2 s2"]


def test_the_decoupled_arm_of_the_lectures() -> None:
    """ML: det J11 = a2 a3 s3 (a2 c2 + a3 c23); the sign is that of the order of rows and joints."""
    assert texts("anthropomorphic") == [
        "det J11 = −a2 d4 s3 (a2 c2 + d4 c23)", "det J22 = −s5", "det J = a2 d4 s3 s5 (a2 c2 + d4 c23)",
    ]  # fmt: skip


@pytest.mark.by_hand
def test_canadarm2_has_kg_equation_7_among_its_minors() -> None:
    said = texts("canadarm2")
    assert len(said) == 7
    assert said[0] == "|$1 $2 $3 $4 $5 $6| = d² s2 s4 (a s345 − d c45 − d c5)"
    assert said[-1] == "|$2 $3 $4 $5 $6 $7| = −d² s4 s6 (a s345 + d c3 + d c34)"


@pytest.mark.by_hand
@pytest.mark.slow_at("panda-None", "canadarm2-None")
@pytest.mark.parametrize(
    ("name", "task"),
    [("planar2r", None), ("planar3r", "planar-position"), ("scara", None), ("stanford", None), ("puma560", None),
     ("ur5", None), ("panda", None), ("canadarm2", None), ("anthropomorphic", "position")],
)  # fmt: skip
def test_they_are_the_determinants_of_the_numeric_jacobian(name: str, task: str | None) -> None:
    """Of all rows, at random configurations: about any point and in any axes, so at the tip in the base's."""
    robot = open_robot(name)
    chain = exact_chain(robot, task)
    found = determinants_of(chain, Work())
    q = sample(robot, resolve_task(task, robot), 5, 3)
    whole = [one for one in found.minors if len(one.rows) == min(chain.n, chain.task.m) and not one.block]
    assert whole
    place = {ROWS[r]: i for i, r in enumerate(chain.task.rows)}
    metres = replace(chain.task, length_scale=1.0)
    for one in whole:
        j = np.array([task_jacobian(robot, x, metres) for x in q])
        block = j[:, [place[row] for row in one.rows]][:, :, [k - 1 for k in one.joints]]
        np.testing.assert_allclose(values(one, chain, q), np.linalg.det(block), rtol=1e-9, atol=1e-9)
    if chain.n > chain.task.m:
        assert [one.joints for one in whole] == list(combinations(range(1, chain.n + 1), chain.task.m))


def test_fewer_joints_than_rows_have_minors_of_rows() -> None:
    found = determinants_of(exact_chain(open_robot("planar2r"), "planar"), Work())
    assert [one.name for one in found.minors] == ["|vx vy|", "|vx wz|", "|vy wz|"]
    assert found.minors[0].value.text() == "a1 a2 s2"


def test_multiplicities_are_told() -> None:
    """PA-10: s4 is in some minors twice; the record has it with its power."""
    chain = exact_chain(open_robot("pa10"))
    record = encode(DETERMINANTS, determinants_of(chain, Work()))
    first = record["minors"][0]
    assert (first["text"], first["sign"]) == ("−d3² d5 c5 s2 s4²", -1)
    powers = {one["text"]: one["multiplicity"] for one in first["factors"]}
    assert powers == {"d3": 2, "d5": 1, "c5": 1, "s2": 1, "s4": 2}
    assert [one["sign"] for one in record["minors"]][3] == 0  # joints 1, 2, 3, 5, 6, 7 are dependent everywhere


@pytest.mark.parametrize(
    ("of", "name", "mark"),
    [
        (MinorOf.BLOCK, "det J11", "det_J11"), (MinorOf.SCREWS, "|$1 $3|", "minor_1_3"),
        (MinorOf.COLUMNS, "|J1 J3|", "minor_1_3"), (MinorOf.ROWS, "|vx wz|", "minor_vx_wz"),
    ],
)  # fmt: skip
def test_a_minor_is_named_by_what_it_takes(of: MinorOf, name: str, mark: str) -> None:
    ring = exact_chain(open_robot("planar2r")).ring
    one = Value(ring, ring.trig.constant(1), None)
    minor = Minor(of, (1, 3), ("vx", "wz"), one, (0.0, 0.0), "J11")
    assert (minor.name, minor.mark) == (name, mark)
