"""Readers take time that grows with the size of a file, not with its square: a law over readers and worst cases.

Calls of functions are counted at 10 and at 100 kB, which no machine's load changes; a file of a megabyte is read or
refused within seconds of the processor's time, which finds what is slow inside one call.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import process_time
from types import FrameType
from typing import Any

import pytest

from rankdrop.cli.values import parse_configuration
from rankdrop.errors import RankdropError
from rankdrop.path.read.csv_file import parse_trajectory
from rankdrop.path.read.messages import parse_message
from rankdrop.path.read.pose_text import pose_of_text
from rankdrop.path.read.poses import read_poses
from rankdrop.path.read.program_file import read_program
from rankdrop.robot.open import open_robot

ARM = open_robot("scara")
MOST = 13.0  # times as many calls for ten times the size: n log n from 10 kB to 100 kB is 12.5
SECONDS = 30.0  # of the processor for a megabyte


def repeated(part: str | Callable[[int], str], size: int, head: str = "", tail: str = "") -> str:
    """A text of about so many bytes: a head, a part again and again, a tail."""
    make = part if callable(part) else lambda _: part
    count = max(2, (size - len(head) - len(tail)) // len(make(100)))
    return head + "".join(map(make, range(count))) + tail


def link(i: int, inside: str = "", kind: str = "revolute", name: str = "l", parent: str | None = None) -> str:
    above = f"{name}{i}" if parent is None else parent
    return (
        f'<link name="{name}{i + 1}"/><joint name="{name}j{i}" type="{kind}"><parent link="{above}"/>'
        f'<child link="{name}{i + 1}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
        f"{inside}</joint>"
    )


URDF = ('<robot name="r"><link name="l0"/>', "</robot>")
ROBOTS: dict[str, tuple[str, Callable[[int], str]]] = {
    "a chain": (".urdf", lambda size: repeated(link, size, *URDF)),
    "followers": (
        ".urdf", lambda size: repeated(lambda i: link(i, f'<mimic joint="lj{i - 1}"/>' if i else ""), size, *URDF)),
    "fixed links beside the arm": (
        ".urdf", lambda size: repeated(lambda i: link(i, kind="fixed", name="f", parent="l1" if i == 0 else None), size,
                                       URDF[0] + link(0), URDF[1])),
    "a star of links": (".urdf", lambda size: repeated(lambda i: link(i, parent="l0"), size, *URDF)),
    "shapes": (".urdf", lambda size: repeated(
        '<visual><geometry><box size="1 1 1"/></geometry></visual>', size, '<robot name="r"><link name="l0">',
        f"</link>{link(0)}</robot>")),
    "attributes": (".urdf", lambda size: repeated(lambda i: f' a{i}="1"', size, '<robot name="r"', "/>")),
    "comments": (".urdf", lambda size: repeated("<!-- -->", size, *URDF)),
    "elements inside each other": (".urdf", lambda size: repeated("<a>", size)),
    "rows of a table": (".toml", lambda size: repeated("[[joints]]\na = 1\n", size, 'convention = "standard"\n')),
    "arrays inside each other": (".toml", lambda size: repeated("[", size, "a = ")),
    "a key of many parts": (".toml", lambda size: repeated("a.", size, tail="a = 1")),
    "a long number": (".toml", lambda size: repeated("1", size, 'convention = "standard"\n[[joints]]\na = ')),
    "a long sum": (".toml", lambda size: repeated("1+", size, 'convention = "standard"\n[[joints]]\na = "', '1"')),
    "rows of a table with a heading": (".csv", lambda size: repeated("0,0,1,0\n", size, "a,alpha,d,theta\n")),
    "headings without rows": (".csv", lambda size: repeated("a,alpha,d,theta\n", size)),
    "calls of links": (".m", lambda size: repeated("L=Link([0 1 0 0]);\n", size)),
    "calls inside each other": (".m", lambda size: repeated("Link(", size)),
    "calls in one line": (".m", lambda size: repeated("Link([0 1 0 0]);", size)),
    "rows with names": (".py", lambda size: repeated("{'a': 1, 'd': 0, 'alpha': 0},\n", size)),
    "rows inside each other": (".py", lambda size: repeated("dict(", size)),
    "brackets inside each other": (".py", lambda size: repeated("{", size, tail="alpha")),
    "names in one row": (".py", lambda size: repeated("a:1,", size, "{", "}")),
    "lists of parameters": (".py", lambda size: repeated("a = [0, 0]\n", size)),
    "a long list": (".py", lambda size: repeated("0, ", size, "a = [", "0]\nd = [0]\nalpha = [0]\n")),
    "numbered names": (".py", lambda size: repeated(lambda i: f"a{i % 100} = 1\n", size)),
    "assignments": (".py", lambda size: repeated(lambda i: f"x{i} = x{i - 1}\n", size, "L = Link([0 x1 0 0])\n")),
    "blanks in an assignment": (".py", lambda size: repeated(" ", size, "a", "= 1")),
    "fractions of LaTeX": (".txt", lambda size: repeated("\\frac{1}{", size, "a & alpha & d & theta\\\\\n")),
    "blanks of LaTeX": (".txt", lambda size: repeated(" ", size, "a & alpha & d & theta\\\\\n\\frac{1}", "x")),
    "rows of LaTeX in one line": (".txt", lambda size: repeated(
        "1 & 0 & 0 & q \\\\", size, "modified\na & \\alpha & d & \\theta\\\\\n")),
    "bars": (".txt", lambda size: repeated("|", size, "alpha", "x")),
    "lines of screws": (".txt", lambda size: repeated("0 0 0 0 0 1\n", size)),
}  # fmt: skip
ROWS = "joint1,joint2,joint3,joint4\n"
PATHS: dict[str, tuple[str, Callable[[int], str]]] = {
    "rows": (".csv", lambda size: repeated("0,0,0,0\n", size, ROWS)),
    "columns": (".csv", lambda size: repeated(lambda i: f"c{i},", size, tail="\n1\n")),
    "prefixes": (".csv", lambda size: repeated(lambda i: f"p{i}_joint1,", size, tail="\n1\n")),
    "one long prefix": (".csv", lambda size: repeated("p", size, tail="_joint1,q2\n1,2\n")),
    "names that spaces separate": (".csv", lambda size: repeated("0 0 0 0\n", size, ROWS.replace(",", " "))),
    "lines above a program": (".txt", lambda size: repeated(" \n;\n", size)),
    "quotes": (".csv", lambda size: repeated('"a"', size, ROWS)),
    "empty lines": (".csv", lambda size: repeated("\n", size, tail=ROWS)),
    "comments": (".csv", lambda size: repeated("# \n", size, tail=ROWS)),
    "decimal commas": (".csv", lambda size: repeated("0,1;0,2;0,3;0,4\n", size, ROWS.replace(",", ";"))),
    "sums in cells": (".csv", lambda size: repeated("1+", size, ROWS, "1,0,0,0\n")),
    "points": (".json", lambda size: repeated('{"positions":[0,0,0,0]},', size, '{"joint_names":["a"],"points":[',
                                              "{}]}")),
    "lists inside each other": (".json", lambda size: repeated("[", size)),
    "flow": (".yaml", lambda size: repeated("[", size)),
    "aliases": (".yaml", lambda size: repeated(
        lambda i: f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9) if i else '1, 1'}]\n", size)),
    "poses": (".csv", lambda size: repeated("0.1,0.2,0.3\n", size, "x,y,z\n")),
    "blanks in a name": (".csv", lambda size: repeated(" ", size, "q1", "x,q2\n0,0\n")),
    "blanks behind the time": (".csv", lambda size: repeated(" ", size, "t", "x,q1\n0,0\n")),
    "brackets in a name": (".csv", lambda size: repeated("( ", size, "q1", ",q2\n0,0\n")),
}  # fmt: skip
PROGRAMS: dict[str, tuple[str, Callable[[int], str]]] = {
    "moves of KRL": (".src", lambda size: repeated("PTP {A1 0, A2 0, A3 0, A4 0}\n", size, "DEF p()\n", "END\n")),
    "relative moves of KRL": (".src", lambda size: repeated(
        "LIN_REL {X 1}\n", size, "DEF p()\nPTP {X 1, A 0}\n", "END\n")),
    "names of RAPID": (".mod", lambda size: repeated(
        lambda i: f"CONST jointtarget p{i}:=[[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n", size, "MODULE m\n")),
    "names of URScript": (".script", lambda size: repeated(lambda i: f"a{i} = [0, 0, 0, 0]\n", size, "def p():\n")),
    "brackets": (".script", lambda size: repeated("[", size, "movej(")),
    "blanks of a target": (".script", lambda size: repeated(" ", size, "movec(", "p[0,0,0,0,0,0])")),
    "blanks of a setting": (".src", lambda size: repeated(" ", size, "DEF p()\n$ORI_TYPE", "x\nEND\n")),
    "arcs of KRL": (".src", lambda size: repeated("CIRC {X 1, Y 1, Z 1}, {X 1, A 0}\n", size, "DEF p()\n", "END\n")),
    "points of a TP program": (".ls", lambda size: repeated(
        lambda i: f"P[{i}]{{ GP1: J1= 0 deg, J2= 0 deg }};\n", size, "/PROG p\n/POS\n")),
    "points of INFORM": (".jbi", lambda size: repeated(lambda i: f"C{i:05d}=0,0,0,0\n", size, "/JOB\n")),
}  # fmt: skip


def _robot(path: Path, text: str) -> Any:
    path.write_text(text, encoding="utf-8")
    return open_robot(path)


def _path(path: Path, text: str) -> Any:
    if path.suffix in (".json", ".yaml"):
        return parse_message(text, path.name, ARM, yaml=path.suffix == ".yaml")
    if text.startswith("x,"):
        path.write_text(text, encoding="utf-8")
        return read_poses(path)
    return parse_trajectory(text, path.name, ARM)


def _program(path: Path, text: str) -> Any:
    path.write_text(text, encoding="utf-8")
    return read_program(path)


def _words(path: Path, text: str) -> Any:
    return parse_configuration(text, ARM, deg=False)


def _pose(path: Path, text: str) -> Any:
    return pose_of_text(text, "--pose")


WORDS: dict[str, tuple[str, Callable[[int], str]]] = {
    "names and values": ("", lambda size: repeated("a=1 ", size)),
    "blanks before a name": ("", lambda size: repeated(" ", size, "a=1", "b=1")),
    "a sum": ("", lambda size: repeated("1+", size, tail="1,0,0,0")),
    "numbers": ("", lambda size: repeated("0,", size)),
    "brackets": ("", lambda size: repeated("(", size)),
    "factorials": ("", lambda size: repeated("10!", size)),
    "fields of a message": ("", lambda size: repeated("name: [a]\n", size, tail="position: [1]")),
}
POSES: dict[str, tuple[str, Callable[[int], str]]] = {
    "words before a target": ("", lambda size: repeated("a ", size, tail=":=[[1,1,1],[1,0,0,0]]")),
    "a long name": ("", lambda size: repeated("a", size, tail="=[[1,1,1],[1,0,0,0]]")),
    "pi in a pose": ("", lambda size: repeated("pi*", size, "p[", "1,0,0,0,0,0]")),
    "blanks": ("", lambda size: repeated(" ", size, "1", "x")),
    "commas": ("", lambda size: repeated(",", size, "1", "x")),
    "brackets": ("", lambda size: repeated("(", size)),
    "brackets of RAPID": ("", lambda size: repeated("[", size, "[[")),
    "numbers of URScript": ("", lambda size: repeated("0,", size, "p[")),
    "names of KRL": ("", lambda size: repeated("A 1, ", size, "{")),
    "orders of a quaternion": ("", lambda size: repeated("wxyz ", size)),
    "blanks in an array": ("", lambda size: repeated(" ", size, "np.array([1,", ", dtype")),
    "commas in an array": ("", lambda size: repeated(", ", size, "array(")),
    "modules of an array": ("", lambda size: repeated("np.", size)),
    "signs in a message": ("", lambda size: repeated("1-", size, "position: ", "x")),
    "names in a message": ("", lambda size: repeated("x = ", size, "position: ")),
    "orientations": ("", lambda size: repeated("orientation ", size, "position: ")),
}
CASES = {
    f"{kind}: {name}": (read, ending, make)
    for kind, read, table in (
        ("robot", _robot, ROBOTS), ("path", _path, PATHS), ("program", _program, PROGRAMS), ("words", _words, WORDS),
        ("pose", _pose, POSES))
    for name, (ending, make) in table.items()
}  # fmt: skip


def calls_of(work: Callable[[], object]) -> int:
    """Calls of functions, of those in C as well, until the work is done or refused."""
    count = 0

    def called(frame: FrameType, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(called)
    try:
        work()
    except RankdropError:
        pass
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.spread(7)
@pytest.mark.parametrize(
    "case", [case if case == "robot: followers" else pytest.param(case, marks=pytest.mark.slow) for case in CASES]
)
def test_ten_times_the_size_takes_ten_times_the_calls(tmp_path: Path, case: str) -> None:
    read, ending, make = CASES[case]
    small, large = (make(size) for size in (10_000, 100_000))
    path = tmp_path / f"file{ending}"
    calls_of(partial(read, path, small))  # what is imported and cached at the first call
    few, many = (calls_of(partial(read, path, text)) for text in (small, large))
    assert many <= MOST * max(few, 200)


@pytest.mark.spread(4)
@pytest.mark.by_hand_at(
    "path: aliases", "path: comments", "path: empty lines", "program: moves of KRL", "program: names of RAPID",
    "program: names of URScript", "robot: rows of a table",
)  # fmt: skip
@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_megabyte_is_read_or_refused_in_seconds(tmp_path: Path, case: str) -> None:
    read, ending, make = CASES[case]
    text = make(1_000_000)
    said = ""
    begun = process_time()
    try:
        read(tmp_path / f"file{ending}", text)
    except RankdropError as error:
        said = str(error)
    assert process_time() - begun < SECONDS
    assert len(said) < 1500


def test_a_reader_that_looks_again_at_all_before_is_found(tmp_path: Path) -> None:
    def quadratic(_: Path, text: str) -> None:
        for end in range(0, len(text), 100):
            [text.find("x", start) for start in range(0, end, 100)]

    few, many = (calls_of(partial(quadratic, tmp_path, "a" * size)) for size in (4_000, 40_000))
    assert many > MOST * few
