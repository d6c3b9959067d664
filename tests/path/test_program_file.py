"""Programs from files: lines that are not read, with their reason; hostile files; older encodings."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from path.program_data import DATA
from path.read_programs import skipped
from rankdrop.errors import RankdropError
from rankdrop.path.read.program_file import read_program


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        ("krl.src", {8: "tool frame", 13: "call", 14: "changed", 15: "other", 16: "circle", 17: "expression",
                     18: "branch", 19: "incomplete", 20: "branch", 21: "relative", 25: "base frame"}),
        ("rapid.mod", {13: "tool frame", 14: "base frame", 16: "changed", 17: "circle", 18: "branch",
                       19: "other", 20: "branch", 21: "call"}),
        ("urscript.script", {8: "expression", 11: "loop", 12: "circle"}),
        ("tp.ls", {8: "tool frame", 9: "offset", 11: "circle", 13: "variable", 14: "call", 15: "incomplete"}),
        ("inform.jbi", {22: "pulses", 25: "other", 26: "circle", 27: "variable", 28: "base frame"}),
    ],
)  # fmt: skip
def test_lines_that_are_not_read_are_listed_with_their_reason(file: str, expected: dict[int, str]) -> None:
    assert skipped(read_program(DATA / file)) == expected


LONG = 19_000
HOSTILE = {
    "nothing.src": "",
    "zeros.mod": "a\0b",
    "digits.src": f"PTP {{A1 {'1' * LONG}x}}\n",
    "spaces.ls": "/MN\n" + f"   1:J P[1]{' ' * LONG}x\n" * 50 + "/POS\nP[1]{\n" + f" X {' ' * LONG}\n" * 50,
    "brackets.mod": "MoveL " + "[" * LONG + ",v100,fine,tool0;\n",
    "nested.script": "movej(" + "[" * LONG + "\n",
    "quotes.mod": 'x ";"\n' * 40_000,
    "statement.mod": "x y\n" * 20_000,
    "wide.jbi": "C" * 30_000,
    "lines.src": "\n" * 300_000,
    "infinite.src": "PTP {A1 1e999, A2 0, A3 0, A4 0, A5 0, A6 0}\n",
    "huge.src": "PTP {A1 1e9, A2 0, A3 0, A4 0, A5 0, A6 0}\n",
    "far.script": "movel(p[1e20, 0, 0, 0, 0, 0])\n",
    "long.mod": "MoveL [[0,0,0],[1,1,1,1],[0,0,0,0],[0,0,0,0,0,0]],v100,fine,tool0;\n",
    "equals.src": "=" * LONG + "\n" + "P.P=" * 4_000,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_end_in_one_line(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(HOSTILE[name])
    begun = time.process_time()
    with pytest.raises(RankdropError) as error:
        read_program(tmp_path / name)
    assert time.process_time() - begun < 5.0
    assert "\n" not in str(error.value)
    assert name in str(error.value)


def test_bytes_that_are_no_unicode_are_read_as_latin_1(tmp_path: Path) -> None:
    (tmp_path / "a.src").write_bytes(b"; Schwei\xdfnaht\r\nPTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}\r\n")
    assert [one.line for one in read_program(tmp_path / "a.src").moves] == [2]
