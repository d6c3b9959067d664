"""A program as data: reasons of lines that were not read, tools, and how many moves there may be."""

from __future__ import annotations

import pytest

from rankdrop.path.read import inform, program_record, urscript
from rankdrop.path.read.program_record import MOVES, Reason
from rankdrop.path.read.trajectory import TrajectoryError


def test_the_number_of_moves_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(program_record, "MOST_MOVES", 5)
    with pytest.raises(TrajectoryError, match="line 6: the program has too many moves; allowed: at most 5"):
        urscript.read("movej([0,0,0,0,0,0])\n" * 6, "a.script")


def test_lines_that_move_the_arm_are_told_from_others() -> None:
    assert {Reason.VARIABLE, Reason.CIRCLE, Reason.BASE} <= MOVES
    assert not MOVES & {Reason.CALL, Reason.LOOP, Reason.OTHER}
    job = "//POS\n///POSTYPE BASE\n///TOOL 2\n///RECTAN\nC00000=1,2,3,4,5,6\n//INST\nMOVL C00000\n"
    program = inform.read(job, "a.jbi")
    assert [type(one).__name__ for one in program.items] == ["Skipped", "Move"]
    assert program.skipped[0].reason is Reason.TOOL
