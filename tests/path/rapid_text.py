"""Programs of RAPID from statements, what is not read of them, and the place of the last move."""

from __future__ import annotations

from rankdrop.path.read.program_record import Program
from rankdrop.path.read.rapid import read

END = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
DOWN = "[0,0,1,0]"  # X of the tool is −X of the base, Z of the tool is −Z
HEAD = f"""%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE Main
  CONST robtarget p10:=[[400,0,500],{DOWN},{END};
  CONST num up:=50;
  PROC main()
"""
GO = "v100,fine,tool0"


def of(*statements: str) -> Program:
    return read(HEAD + "".join(f"{line}\n" for line in statements), "a.mod")


def reasons(program: Program) -> list[tuple[int, str]]:
    first = len(HEAD.splitlines())
    return [(item.line - first, item.reason.value) for item in program.skipped]


def place(program: Program) -> list[float]:
    pose = program.moves[-1].target.pose
    assert pose is not None
    return [round(1e3 * value, 6) for value in pose[:3, 3]]
