"""Jobs of INFORM as engineers have them: shifts, searches, moves of other kinds; turns about fixed axes."""

from __future__ import annotations

import numpy as np

from path.program_data import DATA
from path.read_programs import about, moves
from rankdrop.path.read import inform
from rankdrop.path.read.program_file import read_program
from rankdrop.path.read.program_record import Program


def job(*lines: str) -> Program:
    head = (
        "/JOB\n//NAME A\n//POS\n///NPOS 2,0,0,0,0,0\n///TOOL 0\n///POSTYPE BASE\n///RECTAN\n///RCONF 0,0,0,0,0,0,0,0\n"
    )
    head += "C00000=400.000,100.000,200.000,180.0000,0.0000,0.0000\n//INST\n///DATE 2024/01/01 10:00\nNOP\n"
    return inform.read(head + "".join(f"{line}\n" for line in lines) + "END\n", "a.jbi")


def reasons(program: Program) -> list[str]:
    return [item.reason.value for item in program.skipped]


def test_jobs_name_moves_that_end_elsewhere() -> None:
    shift = ["SFTON P001 BF", "MOVL C00000 V=100.0", "SFTOF", "MOVL C00000 V=100.0 PL=0"]
    program = job(
        "'approach", *shift, "MOVL C00000 V=50.0 UNTIL IN#(1)=ON", "+MOVJ C00000 VJ=10.00", "SMOVL C00000 V=9.0"
    )
    assert reasons(program) == ["other", "shifted", "other", "ends early", "other move", "other move"]
    assert [(move.speed.linear, move.blend) for move in program.moves] == [(0.1, False)]


def test_inform_turns_about_fixed_axes() -> None:
    program = read_program(DATA / "inform.jbi")
    found = moves(program)[23].target.pose
    np.testing.assert_allclose(found[:3, :3], about("z", 7) @ about("y", -12) @ about("x", 178), atol=1e-15)
    np.testing.assert_allclose(found[:3, 3], [0.48, -0.09, 0.12], atol=1e-15)
    assert moves(program)[24].speed.linear == 0.1
    assert moves(program)[23].speed.share == 0.25
