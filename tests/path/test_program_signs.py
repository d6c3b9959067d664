"""Programs under other endings: those of newer controllers are read, any other names the ending to give."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from path.program_data import DATA
from rankdrop.path.read.files import read_trajectory, trajectories_in
from rankdrop.path.read.program_file import read_program
from rankdrop.path.read.program_signs import refuse_program_text
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.open import open_robot

PROGRAMS = {"krl.src": "KRL", "rapid.mod": "RAPID", "urscript.script": "URScript", "tp.ls": "FANUC TP",
            "inform.jbi": "INFORM"}  # fmt: skip


@pytest.mark.parametrize(
    ("file", "ending"),
    [("rapid.mod", ".modx"), ("rapid.mod", ".SYSX"), ("rapid.mod", ".sys"), ("krl.src", ".sub"),
     ("urscript.script", ".urscript")],
)  # fmt: skip
def test_a_program_is_the_same_under_the_other_endings_of_its_language(
    file: str, ending: str, tmp_path: Path
) -> None:
    shutil.copy(DATA / file, tmp_path / f"p{ending}")
    for data in DATA.glob(f"{Path(file).stem}.dat"):
        shutil.copy(data, tmp_path / "p.dat")
    known, other = read_program(DATA / file), read_program(tmp_path / f"p{ending}")
    assert [move.line for move in other.moves] == [move.line for move in known.moves]
    assert other.language == known.language


@pytest.mark.parametrize("file", PROGRAMS)
def test_a_program_in_a_text_file_is_refused_with_its_ending(file: str, tmp_path: Path) -> None:
    path = tmp_path / "p.txt"
    path.write_text("\n; ! # a comment\n" + (DATA / file).read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.raises(TrajectoryError, match=f"program in {PROGRAMS[file]}; fix: rename it p{Path(file).suffix}$"):
        read_trajectory(path, open_robot("ur5e"))


@pytest.mark.parametrize(
    "text",
    ["q1,q2\n0,0\n", "DEFAULT,q1\n", "module,q1\n", "def f(x):\n    return x\n", "# MODULE x\nq1,q2\n", "/tmp\n", ""],
)
def test_a_table_is_no_program(text: str) -> None:
    refuse_program_text(text, "p.txt")


def test_modules_of_the_controller_are_left_out_of_a_folder(tmp_path: Path) -> None:
    for name in ("a.modx", "b.sys", "c.sysx", "d.sub", "e.urscript"):
        (tmp_path / name).write_text("MODULE x\nENDMODULE\n")
    assert [path.name for path in trajectories_in(tmp_path)] == ["a.modx", "e.urscript"]


def test_rows_below_a_comment_are_read(tmp_path: Path) -> None:
    path = tmp_path / "p.txt"
    path.write_text("# MODULE of the cell\nq1,q2,q3,q4\n0,0,0.1,0\n")
    assert np.array_equal(read_trajectory(path, open_robot("scara")).q, [[0, 0, 0.1, 0]])
