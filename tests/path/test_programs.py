"""Remedies of robot programs by line, each tried: the program with the remedy in it holds what the remedy says."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rankdrop.cli import main
from rankdrop.codec import check_record
from rankdrop.kinematics import pose
from rankdrop.local.orientation import rotation_vector
from rankdrop.path.check.path_file import PathQuestion
from rankdrop.path.check.program import ProgramCheck, check_any_file
from rankdrop.path.mend.programs import Advice, program_remedies, remedies_to_dict
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
    assert main.run(["path", "ur5e", str(file), "--quiet", "--json", str(tmp_path / "a.json")]) == 3
    record = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    check_record("program", record)
    (told,) = record["remedies"]
    assert (told["line"], told["advice"], told["speed_share"], told["change"]) == (2, "slower", one.factor, None)
    assert told["words"] == remedy_words(one, check.robot)
    said = " ".join(capsys.readouterr().out.split())
    assert "programs are not written line 2: at 0.00595 of its speed, 1.19 mm/s for 200 mm/s" in said
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
    (told,) = remedies_to_dict([one], arm)
    check_record("program", check.to_dict() | {"remedies": [told]})
    assert (told["advice"], told["speed_share"], told["line_shares"]) == ("detour", None, list(one.span))
    assert max(told["change"]["moved"]) > 0.0
    words = remedy_words(one, arm)
    assert "% of its way is free (proven); after it the arm is in another posture: joint 4 by" in words


@pytest.mark.slow
def test_a_line_that_needs_an_internal_turn_goes_on_after_it(tmp_path: Path) -> None:
    """From the zero pose of an LR Mate to its side: joints 4 and 6 have to turn against each other first."""
    file, arm = tmp_path / "side.script", open_robot("lrmate200id")
    at = pose(arm, np.zeros(6))
    turned = rotation_vector(at[:3, :3])
    target = ",".join(f"{value:.12f}" for value in (*(at[:3, 3] + [0.0, 0.1, 0.0]), *turned))
    lines = ["movej([0,0,0,0,0,0])", f"movel(p[{target}], v=0.1)"]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    check = checked("lrmate200id", file)
    (one,) = program_remedies(check)
    assert (one.move.line, one.advice) == (2, Advice.TURN)
    assert one.turn is not None
    (told,) = remedies_to_dict([one], arm)
    check_record("program", check.to_dict() | {"remedies": [told]})
    assert told["turn"]["to"] == one.turn.to.tolist()
    lines.insert(1, f"movej([{','.join(f'{value:.12f}' for value in one.turn.to)}])")
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    after = checked("lrmate200id", file)
    assert all(part.ended is None for part in after.parts)
