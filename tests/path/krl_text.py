"""Programs of KRL from statements, what is not read of them, and the places of their moves."""

from __future__ import annotations

from rankdrop.path.read.krl import read
from rankdrop.path.read.program_record import Program

FIRST = "LIN {X 500, Y 100, Z 600, A 90, B 0, C 0}\n"
JOINTS = "PTP {A1 10, A2 -90, A3 90, A4 0, A5 20, A6 0}\n"
DAT = """DEFDAT a
DECL E6POS XP1={X 500.0,Y 0.0,Z 600.0,A 180.0,B 0.0,C 180.0,S 2,T 35,E1 0.0,E2 0.0}
DECL FDAT FP0={TOOL_NO 0,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " "}
DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,POINT2[] " "}
DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 100.0,APO_FAC 50.0,ORI_TYP #VAR}
ENDDAT
"""


def of(text: str, declarations: str = "") -> Program:
    return read(f"DEF a()\n{text}END\n", "a.src", declarations)


def reasons(program: Program) -> dict[int, str]:
    return {item.line: item.reason.value for item in program.skipped}


def places(program: Program) -> list[list[float]]:
    made = [move.target.pose for move in program.moves]
    return [[round(1e3 * value, 6) for value in pose[:3, 3]] for pose in made if pose is not None]
