"""What a plain command passes through is little, and so is the whole, and gets less: these bounds go down only."""

from __future__ import annotations

import ast

import pytest
from sources import FILES, SOURCE, nodes

from scripts import tool

BOUNDS = {
    "analyze planar3r --starts 300 --quiet --threads 1": (44, 47),
    "conditions puma560 --quiet": (28, 23),
    "conditions puma560 --quiet --fresh --coranks 1 --points 100": (59, 58),
}
"""Command line -> at most so many files of the package, at most so many types that instances are made of."""


@pytest.mark.parametrize("line", BOUNDS)
def test_a_command_passes_no_more_files_and_types_than_before(line: str) -> None:
    found = tool("count_passed").counted(line)
    assert found["exit"] == ["0"]
    assert "cli/main.py" in found["files"]
    assert "rankdrop.robot.model.Robot" in found["types"]
    for kind, bound in zip(("files", "types"), BOUNDS[line], strict=True):
        passed = found[kind]
        assert len(passed) <= bound, f"{len(passed)} {kind}, {bound} are allowed:\n" + "\n".join(passed)


WHOLE = {
    "certify": (8, 9),
    "cli": (17, 20),
    "designs": (8, 10),
    "errors": (1, 8),
    "exact": (32, 77),
    "families": (23, 38),
    "family": (6, 17),
    "jobs": (4, 5),
    "kinematics": (1, 1),
    "local": (17, 50),
    "motion": (27, 46),
    "options": (1, 1),
    "configuration": (1, 3),
    "problem": (1, 2),
    "proof": (10, 21),
    "questions": (1, 6),
    "report": (9, 3),
    "results": (15, 17),
    "robot": (17, 26),
    "schema": (7, 0),
    "sections": (1, 1),
    "solve": (1, 0),
    "text": (3, 2),
    "units": (1, 0),
    "verbs": (8, 4),
    "viewer": (12, 23),
}
"""Room -> at most so many files, at most so many classes."""


@pytest.mark.parametrize("room", WHOLE)
def test_a_room_has_no_more_files_and_classes_than_before(room: str) -> None:
    files = [path for path in FILES if path.relative_to(SOURCE).parts[0].removesuffix(".py") == room]
    classes = [
        f"{file.name}: {node.name}" for file in files for node in nodes(file) if isinstance(node, ast.ClassDef)
    ]
    most_files, most_classes = WHOLE[room]
    assert len(files) <= most_files, sorted(file.name for file in files)
    assert len(classes) <= most_classes, classes


def test_every_room_has_a_bound() -> None:
    rooms = {parts[0] for parts in (path.relative_to(SOURCE).parts for path in FILES) if len(parts) > 1}
    assert rooms - set(WHOLE) == set()


TOTALS = {"statements": 40_357, "files": 240, "classes": 394, "functions of 8 arguments and more": 12}
"""Of the whole package; the aim is 32,000, 235, 260, 10."""


def test_the_package_does_not_grow() -> None:
    every = [node for path in FILES for node in nodes(path)]
    functions = [node.args for node in every if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    names = [[one.arg for one in (*args.posonlyargs, *args.args, *args.kwonlyargs)] for args in functions]
    counts = {
        "statements": sum(isinstance(node, ast.stmt) for node in every),
        "files": len(FILES),
        "classes": sum(isinstance(node, ast.ClassDef) for node in every),
        "functions of 8 arguments and more": sum(len(set(some) - {"self", "cls"}) >= 8 for some in names),
    }
    assert {what: count for what, count in counts.items() if count > TOTALS[what]} == {}
