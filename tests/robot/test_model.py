"""What a robot may be, whoever makes it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.errors import RobotError
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot


def test_no_arm_has_more_joints_whoever_makes_it(tmp_path: Path) -> None:
    def one(i: int) -> Joint:
        return Joint(f"j{i}", JointKind.REVOLUTE, np.array([0.0, 0, 0, 0, 0, 1]))

    assert Robot("long", tuple(one(i) for i in range(200))).n == 200
    with pytest.raises(RobotError, match="robot 'long': the chain has too many moving joints; got 201"):
        Robot("long", tuple(one(i) for i in range(201)))
    path = tmp_path / "screws.txt"
    path.write_text("0 0 1 0 0 0\n" * 201)
    with pytest.raises(RobotError, match=r"screws.txt, line 201: the chain has too many moving joints"):
        open_robot(path)


@pytest.mark.parametrize("bad", ["j\x1b[31m", "j\nk", "j\tk", "j\x9b", "j\u202e", "j\x07", "j\u2028"])
def test_names_that_steer_a_terminal_are_refused(bad: str) -> None:
    hinge = Joint("j", JointKind.REVOLUTE, np.array([0.0, 0, 0, 0, 0, 1]))
    for make in (lambda: Joint(bad, JointKind.REVOLUTE, hinge.screw), lambda: Robot(bad, (hinge,)),
                 lambda: Robot("r", (hinge,), base=bad), lambda: Robot("r", (hinge,), tip=bad)):  # fmt: skip
        with pytest.raises(RobotError, match="the name has a control character") as caught:
            make()
        assert str(caught.value).isprintable()
