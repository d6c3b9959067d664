"""Joints above their rate limits: by hand on a straight path, on a cubic, near a wrist, and in lines of a program."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from printed import one_line

from path.overrun import ARM, LIMIT
from rankdrop.path.check.check import check_path
from rankdrop.path.check.overrun import fastest, overruns
from rankdrop.path.check.path_file import PathQuestion
from rankdrop.path.check.program import check_any_file
from rankdrop.path.curve import curve
from rankdrop.path.mend.programs import program_remedies
from rankdrop.questions import PathOptions
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema


def test_a_cubic_is_above_its_limit_for_a_part_of_a_stretch() -> None:
    """q = 1.5 c (t²/2 − t³/3)·4 from rest to rest in 1 s has the rate 6 c t (1 − t): above c for 1/√3 of the time."""
    rows = np.zeros((2, 6))
    rows[1, 3] = LIMIT
    path = curve(rows, np.array([0.0, 1.0]), np.zeros((2, 6)), None, "cubic")
    (found,) = overruns(ARM, path)
    assert found.rate == pytest.approx(1.5 * LIMIT, rel=0.01)
    assert found.seconds == pytest.approx(1 / np.sqrt(3.0), abs=1 / 16)
    assert found.travel == pytest.approx(LIMIT * (1.5 - 1 / 6) / np.sqrt(3.0), rel=0.1)
    quickest = fastest(ARM, path)
    assert quickest is not None
    assert (quickest.joint, quickest.place.time) == (4, pytest.approx(0.5, abs=0.1))


@pytest.mark.slow
def test_a_free_path_far_from_singularities_has_no_such_line() -> None:
    check = check_path(ARM, [[0, -1, 1.4, 0.3, 0.8, 0], [0.1, -1, 1.4, 0.3, 0.8, 0]], [0.0, 1.0])
    assert check.verdict == "free"
    assert "Fastest" not in "\n".join(check.summary)


@pytest.mark.slow
def test_every_line_of_a_program_that_is_too_fast_is_marked(tmp_path: Path) -> None:
    """Only the worst line was: the others were free in the table, and had a remedy all the same."""
    file = tmp_path / "fast.script"
    lines = ["movej([0.1,-1.2,1.4,-0.6,0.4,0.2])", "movel([0.3,-1.2,1.4,-0.6,0.4,0.2], t=0.02)",
             "movel([0.2,-1.2,1.4,-0.6,0.4,0.2], t=0.02)", "movel([0.1,-1.2,1.4,-0.6,0.4,0.2], t=9)"]  # fmt: skip
    file.write_text("\n".join(lines))
    check = check_any_file(open_robot("ur5e"), file, PathQuestion(None, None, PathOptions()))
    assert [str(move.verdict) for move in check.moves[1:]] == ["too fast", "too fast", "free"]
    assert [remedy.move.line for remedy in program_remedies(check)] == [2, 3]
    said = one_line(check.sentence)
    assert "in line 2: movel([0.3,-1.2,1.4,-0.6,0.4,0.2], t=0.02) (and less in line 3)" in said
    text = one_line("\n".join(check.summary))
    assert "Too fast in line 2: joint 1 needs up to" in text
    assert "Too fast in line 3: joint 1 needs up to" in text
    assert "Too fast in line 4" not in text
    assert [[overrun.joint for overrun in move.overruns] for move in check.moves[1:]] == [[1], [1], []]
    written = check.to_dict()
    Draft202012Validator(load_schema("program")).validate(written)
    (over,) = written["moves"][1]["overruns"]
    assert (over["joint"], over["rate_limit"]) == (1, pytest.approx(np.pi))
    assert over["seconds"] == pytest.approx(0.02)
    assert over["travel"] == pytest.approx(0.2, rel=0.05)
    first = written["parts"][0]["path"]["overruns"]
    assert [one["joint"] for one in first] == [1]
    assert first[0]["times"][0] < first[0]["times"][1]


def test_one_row_is_no_path_of_rows() -> None:
    check = check_path(open_robot("planar3r"), [[0.3, 0.5, 0.2]])
    said = one_line("\n".join(check.summary))
    assert "1 rows" not in said
    assert "Path: one row" in said
    assert check.to_dict()["overruns"] == []
