"""Programs of URScript as engineers and PolyScope write them: d2r, pose_trans, get_inverse_kin with qnear."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.local.orientation import rotation_vector
from rankdrop.path.check.path_file import PathQuestion
from rankdrop.path.check.program import check_program
from rankdrop.path.read.program_record import Program
from rankdrop.path.read.urscript import read
from rankdrop.questions import PathOptions
from rankdrop.robot.open import open_robot

ASK = PathQuestion(None, None, PathOptions())
SEAM = "p[-0.35,-0.25,0.5,0,3.141592653589793,0]"


def of(*lines: str) -> Program:
    return read("".join(f"{line}\n" for line in ("def prog():", *lines, "end")), "a.script")


def reasons(program: Program) -> list[str]:
    return [item.reason.value for item in program.skipped]


def test_degrees_in_lists_of_joints() -> None:
    home = "home = [d2r(0), d2r(-90), d2r(90), 0, -d2r(9e1), d2r(d2r(3))]"
    program = of(home, "movej(home)", "movej([-d2r(90),0,0])")
    assert reasons(program) == ["other", "changed"]
    assert program.moves[0].target.joints == (-np.pi / 2, 0, 0)


def test_pose_trans_chains_poses() -> None:
    program = of(f"seam = {SEAM}", "above = pose_trans(seam, p[0,0,-0.1,0,0,0])", "movel(above, v=0.1)",
                 "movel(pose_trans(pose_trans(above, p[0.01,0,0,0,0,0]), p[0,0,0,0,0,0.5]))")  # fmt: skip
    assert not program.skipped
    first, second = (move.target.pose for move in program.moves)
    assert first is not None
    assert second is not None
    # half a turn about Y: Z of the tool points down, X of it is −X of the base
    np.testing.assert_allclose(first[:3, 3], [-0.35, -0.25, 0.6], atol=1e-12)
    np.testing.assert_allclose(second[:3, 3], [-0.36, -0.25, 0.6], atol=1e-12)
    np.testing.assert_allclose(second[:3, 0], [-np.cos(0.5), np.sin(0.5), 0], atol=1e-12)


@pytest.mark.parametrize(("goal", "reason"), [
    ("pose_trans(a, p[0,0,0,0,0,0])", "variable"), ("pose_trans([0,0,0,0,0,0], p[0,0,0,0,0,0])", "expression"),
    ("pose_trans(p[0,0,0,0,0,0])", "expression"), ("get_inverse_kin(get_actual_tcp_pose())", "expression"),
    (f"get_inverse_kin({SEAM}, here)", "variable"), ("pose_trans(" * 1_500, "expression"),
])  # fmt: skip
def test_functions_of_what_is_not_known_are_not_guessed(goal: str, reason: str) -> None:
    assert reasons(of(f"movej({goal})", "movej([0,0,0,0,0,0])"))[0] == reason


def test_functions_that_do_not_move_the_arm_are_no_calls() -> None:
    assert reasons(of("set_digital_out(0, True)", "grip()", "set_tcp(tool)")) == ["other", "call", "tool frame"]


@pytest.mark.slow
@pytest.mark.parametrize("elbow", [1.5, -1.5])
def test_the_solution_is_the_one_nearest_to_qnear(elbow: float) -> None:
    """PolyScope writes the taught joint values as qnear; the arm comes from the other elbow."""
    arm = open_robot("ur5e")
    taught = np.array([0.2, -1.3 if elbow > 0 else -0.3, elbow, -1.1, 1.2, 0.3])
    here = pose(arm, taught)
    vector = rotation_vector(here[None, :3, :3])[0]
    goal = f"p{[*here[:3, 3].tolist(), *vector.tolist()]}"
    start = [0.2, -1.0, -elbow, -1.1, 1.2, 0.3]
    program = of(f"movej({start})", f"movej(get_inverse_kin({goal}, qnear={taught.tolist()}), a=1.4, v=1.05)")
    found = check_program(arm, program, ASK)
    part = found.parts[0].check
    assert part is not None
    np.testing.assert_allclose(part.curve.control[-1, -1], taught, atol=1e-8)
