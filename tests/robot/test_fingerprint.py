"""Fingerprints: what decides the Jacobian enters, nothing else does; the coarse one forgives rounding."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from rankdrop.robot.model import Joint, Mimic, Robot, coarse_fingerprint, fingerprint, geometry
from rankdrop.robot.open import open_robot


def with_first(robot: Robot, **changes: object) -> Robot:
    first: Joint = replace(robot.joints[0], **changes)  # type: ignore[arg-type]
    return replace(robot, joints=(first, *robot.joints[1:]))


@pytest.mark.parametrize("name", ["pa10", "stanford", "rcrrrr"])
def test_names_and_limits_do_not_enter(name: str) -> None:
    robot = open_robot(name)
    other = with_first(replace(robot, name="other", notes=()), name="first", lower=-0.5, upper=0.5)
    other = with_first(other, screw=np.where(robot.joints[0].screw == 0.0, -0.0, robot.joints[0].screw))
    assert fingerprint(other) == fingerprint(robot)
    assert coarse_fingerprint(other) == coarse_fingerprint(robot)
    assert len(fingerprint(robot)) == 64


@pytest.mark.parametrize(("by", "same"), [(1e-15, True), (1e-12, True), (1e-6, False)])
def test_the_last_digits_enter_one_of_them_only(by: float, same: bool) -> None:
    robot = open_robot("pa10")
    home = robot.home.copy()
    home[0, 3] += by
    other = replace(robot, home=home)
    assert fingerprint(other) != fingerprint(robot)
    assert (coarse_fingerprint(other) == coarse_fingerprint(robot)) is same


def test_mimic_relations_enter() -> None:
    robot = open_robot("pa10")
    last = robot.joints[-1]
    seen = set()
    for mimic in (None, Mimic("joint1"), Mimic("joint2"), Mimic("joint1", multiplier=2.0), Mimic("joint1", offset=0.1)):
        leader = None if mimic is None else replace(mimic, leader=robot.joints[int(mimic.leader[-1])].name)
        other = replace(robot, joints=(*robot.joints[:-1], replace(last, mimic=leader)))
        assert geometry(other).size == 6 * 7 + 16 + (2 if leader else 0)
        seen |= {fingerprint(other), coarse_fingerprint(other)}
    assert len(seen) == 10


OTHERS = ("j2n6s300", "kr210l150", "px150", "so101", "wx250s", "xarm5", "yumi", "ur5e")
"""Arms at odd angles: products by a BLAS of another processor gave all but the last other numbers."""


@pytest.mark.slow
@pytest.mark.parametrize("kernels", ["Nehalem", "Haswell"])
def test_a_file_is_the_same_arm_on_every_processor(kernels: str) -> None:
    """OpenBLAS takes the kernels that it is told; where NumPy is built on something else nothing is tried."""
    told = (
        "from rankdrop.robot.model import fingerprint; from rankdrop.robot.open import open_robot; "
        f"print([fingerprint(open_robot(name)) for name in {OTHERS!r}])"
    )
    ran = subprocess.run(
        [sys.executable, "-c", told], env={**os.environ, "OPENBLAS_CORETYPE": kernels}, check=True, text=True,
        stdout=subprocess.PIPE,
    )  # fmt: skip
    assert ran.stdout.strip() == repr([fingerprint(open_robot(name)) for name in OTHERS])
