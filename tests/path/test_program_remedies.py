"""Remedies of robot programs by line, each tried: the program with the remedy in it holds what the remedy says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.cli import main
from rankdrop.kinematics import pose
from rankdrop.path.check.check import PathQuestion
from rankdrop.path.check.program import ProgramCheck, check_any_file
from rankdrop.path.mend.programs import Advice, program_remedies
from rankdrop.questions import PathOptions
from rankdrop.robot.open import open_robot
from rankdrop.text.programs import remedy_words

DATA = Path(__file__).parents[1] / "data" / "programs"
TOO_FAST = """movej([0.1,-1.2,1.4,-0.6,0.4,0.2])
movel([0.15,-1.15,1.35,-0.55,-0.35,0.25], v={})
"""


def checked(name: str, file: Path) -> ProgramCheck:
    found = check_any_file(open_robot(name), file, PathQuestion(None, None, PathOptions()))
    assert isinstance(found, ProgramCheck)
    return found


@pytest.mark.slow
def test_the_speed_that_is_named_keeps_the_limits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "fast.script"
    file.write_text(TOO_FAST.format(0.2), encoding="utf-8")
    check = checked("ur5e", file)
    assert check.verdict == "too fast"
    (one,) = program_remedies(check)
    assert (one.move.line, one.advice) == (2, Advice.SLOWER)
    assert main.run(["path", "ur5e", str(file), "--quiet"]) == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "programs are not written line 2: at 0.00596 of its speed, 1.19 mm/s for 200 mm/s" in said
    file.write_text(TOO_FAST.format(0.2 * one.factor), encoding="utf-8")
    assert checked("ur5e", file).holds
    file.write_text(TOO_FAST.format(0.2 * one.factor * 1.01), encoding="utf-8")
    assert not checked("ur5e", file).holds


@pytest.mark.slow
def test_a_joint_move_is_named_where_the_target_is_within_reach(tmp_path: Path) -> None:
    file = DATA / "report-14.src"
    check = checked("kr3r540", file)
    (one,) = program_remedies(check)
    assert (one.move.line, one.advice) == (6, Advice.JOINT_MOVE)
    assert one.goal is not None
    target = np.array(one.move.target.pose)
    assert np.abs(pose(check.robot, one.goal) - target).max() < 1e-9
    lines = file.read_text(encoding="utf-8").splitlines()
    lines[5] = lines[5].replace("LIN", "PTP")
    (tmp_path / "joint.src").write_text("\n".join(lines), encoding="utf-8")
    assert all(part.ended is None for part in checked("kr3r540", tmp_path / "joint.src").parts)


@pytest.mark.slow
def test_a_line_that_crosses_is_led_around(tmp_path: Path) -> None:
    """A LIN of a KR 6 in its middle plane, with the wrist from +25° to −35°."""
    file, arm = tmp_path / "c.src", open_robot("kr6r900")
    end = pose(arm, np.radians([0.0, -70.0, 100.0, 0.0, -35.0, 0.0]))
    pitch = np.degrees(np.arctan2(-end[2, 0], end[0, 0]))
    where = ", ".join(f"{axis} {1e3 * value:.9f}" for axis, value in zip("XYZ", end[:3, 3], strict=True))
    file.write_text("DEF c()\n$VEL.CP=0.2\nPTP {A1 0, A2 -80, A3 100, A4 0, A5 25, A6 0}\n"
                    f"LIN {{{where}, A 0, B {pitch:.9f}, C 0}}\nEND\n", encoding="utf-8")  # fmt: skip
    check = checked("kr6r900", file)
    assert [one.line for one in check.met] == [4]
    (one,) = program_remedies(check)
    assert (one.move.line, one.advice) == (4, Advice.DETOUR)
    assert one.change is not None
    assert 0.0 < one.change.off[0] < 0.02
    assert 0.0 <= one.span[0] < 0.5 < one.span[1] <= 1.0
    words = remedy_words(one, arm)
    assert "% of its way is free (proven); after it the arm is in another posture: joint 4 by" in words
