"""Scanning of programs in any language: statements over several lines, brackets, numbers."""

from __future__ import annotations

import pytest

from path.read_programs import moves, skipped
from rankdrop.path.read import fanuc_tp, program_scan, rapid, urscript
from rankdrop.path.read.program_record import Move
from rankdrop.path.read.program_scan import number, numbers_of, parts_of
from rankdrop.path.read.trajectory import TrajectoryError

ONE_LINE = {
    "a.script": "def prog():\n  home = [0.1, -1.2, 1.4, -1.0, 1.2, 0.4]\n  movej(home, a=1.4, v=1.05)\n"
                "  movej([0.3, -1.2, 1.4, -1.0, 1.2, 0.4], a=1.4, v=0.5, r=0.02)\n"
                "  movel(p[-0.35, -0.25, 0.5, 0.3, 2.2, 0.3], a=1.2, v=0.2)\n  textmsg(\"a ( b\")\n"
                "  movej([0.3, -1.2, 1.4, -1.0, 1.2, 0.6])\nend\n",
    "a.mod": "MODULE m\nCONST jointtarget j:=[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];\nPROC main()\n"
             "MoveAbsJ j, v100, fine, tool0;\nMoveL [[400,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v50, "
             "z10, tool0;\nENDPROC\nENDMODULE\n",
    "a.ls": "/MN\n1:J P[1] 50% FINE ;\n2:L P[1] 250mm/sec CNT50 Offset,PR[1] ;\n3:L P[1] 250mm/sec CNT50 ;\n"
            "/POS\nP[1]{\nGP1:\nUF : 0, UT : 0,\nX = 420.0 mm, Y = 80.0 mm, Z = 180.0 mm,\n"
            "W = 178.0 deg, P = -10.0 deg, R = 5.0 deg\n};\n/END\n",
}  # fmt: skip
"""Programs with one line for each statement."""


@pytest.mark.parametrize(("name", "broken"), [
    ("a.script", {", 1.4, -1.0, 1.2": ",  # pose ] (\n 1.4,\n\n -1.0, 1.2", "movel(": "movel(\n", ", v=": ",\n  v="}),
    ("a.mod", {"MoveL [": "MoveL\n[", ",6],[": ",6],! ;\n[", ", fine": "\n , fine", ",500]": ",\n500]"}),
    ("a.ls", {" Offset,": "\n    :  Offset,", " FINE": "\n    :  FINE"}),
])  # fmt: skip
def test_a_statement_over_several_lines_is_read_as_one(name: str, broken: dict[str, str]) -> None:
    """Breaks where the language allows them change no target and no reason; each keeps the line on which it begins."""
    readers = {"a.script": urscript.read, "a.mod": rapid.read, "a.ls": fanuc_tp.read}
    whole = ONE_LINE[name]
    text = whole
    for plain, several in broken.items():
        assert plain in text
        text = text.replace(plain, several)
    expected, found = (readers[name](written, name) for written in (whole, text))
    assert len(found.items) == len(expected.items)
    for one, other in zip(found.items, expected.items, strict=True):
        first = other.text.split()[0].split("(")[0]
        assert text.splitlines()[one.line - 1].split("(")[0].strip().startswith(first)
        assert type(one) is type(other)
        if isinstance(one, Move):
            assert repr(one.target) == repr(other.target)
            assert (one.kind, one.speed, one.blend) == (other.kind, other.speed, other.blend)
        else:
            assert one.reason == other.reason
    assert len(found.moves) >= 2


def test_a_bracket_that_is_never_closed_ends_at_the_next_statement() -> None:
    """The lines after it are read; a statement without end is refused once it is too long."""
    program = urscript.read("movej([0, 1,\n 2, 3\nmovej([0,-1,1,0,1,0])\nx = (1\n", "a.script")
    assert (skipped(program), list(moves(program))) == ({1: "expression", 4: "other"}, [3])
    with pytest.raises(TrajectoryError, match=r"a\.script, line 1: the statement is too long"):
        urscript.read("movej([0,\n" + " 1,\n" * program_scan.LONGEST_LINE, "a.script")


def test_numbers_and_brackets_are_scanned_outside_quotes() -> None:
    assert number("1" * 60) is None
    assert number("-.5E+1") == -5.0
    assert parts_of('f("a,b"), c') == ['f("a,b")', "c"]
    assert numbers_of("[1,[2,[3]]]") == [1.0, [2.0, [3.0]]]
    assert numbers_of("[[[[[[[[[[[[1]]]]]]]]]]]]") is None
