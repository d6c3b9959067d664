"""Values of RAPID: targets moved by Offs and RelTool, work objects, and offsets that are no numbers."""

from __future__ import annotations

import numpy as np
import pytest

from path.rapid_text import GO, of, place, reasons


def test_offs_goes_along_the_axes_of_the_object() -> None:
    assert place(of(f"MoveL Offs(p10,10,-20,up),{GO};")) == [410, -20, 550]
    work = 'PERS wobjdata w:=[FALSE,TRUE,"",[[100,0,0],[0.70710678,0,0,0.70710678]],[[0,50,0],[1,0,0,0]]];'
    assert place(of(work, f"MoveL Offs(p10,10,0,0),{GO}\\WObj:=w;")) == pytest.approx([100 - 50, 410, 500], abs=1e-4)


def test_reltool_goes_along_the_axes_of_the_tool_and_turns_about_them() -> None:
    program = of(f"MoveL RelTool(p10,10,0,-50\\Rz:=90),{GO};")
    assert place(program) == [390, 0, 550]
    made = program.moves[-1].target.pose
    assert made is not None
    np.testing.assert_allclose(made[:3, 0], [0, 1, 0], atol=1e-12)  # X turns to where Y of the tool was
    turned = of(f"MoveL RelTool(p10,0,0,0\\Rx:=90\\Rz:=90),{GO};").moves[-1].target.pose
    assert turned is not None
    np.testing.assert_allclose(turned[:3, 0], [0, 0, -1], atol=1e-12)  # about X, then the new Z: X turns to the new Y


@pytest.mark.parametrize(("text", "reason"), [
    ("MoveL Offs(p10,0,0,height),", "offset"),
    ("MoveL Offs(p77,0,0,1),", "variable"),
    ("MoveL RelTool(p10,0,0,1\\Rx:=a),", "offset"),
    ("MoveL Offs(CRobT(),0,0,1),", "expression"),
    ("MoveL " + "Offs(" * 3_000 + "p10" + ",0,0,1)" * 3_000 + ",", "expression"),
])  # fmt: skip
def test_offsets_that_are_no_numbers_are_not_guessed(text: str, reason: str) -> None:
    if len(text) > 20_000:
        text = text[:10_000]
    program = of(f"{text}{GO};", f"MoveL p10,{GO};")
    assert reasons(program)[:1] == [(1, reason)]


@pytest.mark.parametrize("held", ["[TRUE,TRUE", "[FALSE,FALSE"])
def test_a_work_object_that_moves_has_no_frame(held: str) -> None:
    work = f'PERS wobjdata w:={held},"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];'
    assert reasons(of(work, f"MoveL p10,{GO}\\WObj:=w;")) == [(2, "base frame")]
    other = 'PERS wobjdata w:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];'
    assert reasons(of(other, "w.oframe.trans.z:=3;", f"MoveL p10,{GO}\\WObj:=w;"))[-1] == (3, "base frame")
