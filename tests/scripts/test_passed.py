"""What a plain command passes through is little, and so is the whole, and gets less: these bounds go down only."""

from __future__ import annotations

import ast

import pytest
from sources import FILES, SOURCE, nodes

from scripts import tool

BOUNDS = {
    "analyze planar3r --starts 300 --quiet --threads 1": (39, 43),
    "conditions puma560 --quiet": (28, 23),
    "conditions puma560 --quiet --fresh --coranks 1 --points 100": (52, 57),
    "explain puma560 --q 0.1,0.2,0.3,0.4,0.5,0.6": (38, 35),
    "cover ur5 --width 0.4 --quiet": (35, 28),
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
    "certify": (6, 8),
    "cli": (15, 23),
    "designs": (6, 8),
    "errors": (1, 8),
    "exact": (30, 77),
    "families": (17, 36),
    "family": (5, 14),
    "jobs": (3, 5),
    "kinematics": (1, 1),
    "local": (14, 45),
    "motion": (18, 36),
    "options": (1, 1),
    "configuration": (1, 3),
    "problem": (1, 1),
    "proof": (10, 20),
    "questions": (1, 9),
    "report": (8, 3),
    "results": (10, 14),
    "robot": (17, 25),
    "schema": (7, 0),
    "sections": (1, 2),
    "solve": (1, 0),
    "text": (8, 5),
    "units": (1, 0),
    "verbs": (8, 4),
    "viewer": (10, 21),
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


TOTALS = {"statements": 38_500, "files": 209, "classes": 373, "functions of 8 arguments and more": 8,
          "functions of complexity above 10": 315, "functions of complexity above 20": 0}  # fmt: skip
"""Of the whole package; the aim is 32,000, 235, 260, 10, 150, 5."""
_BRANCHES = (ast.If, ast.For, ast.While, ast.IfExp, ast.ExceptHandler, ast.comprehension, ast.Assert)


def complexity(function: ast.AST) -> int:
    """Cyclomatic complexity: one more than the branches, conditions of comprehensions and operands of and, or."""
    every = [node for node in ast.walk(function) if node is not function]
    further = sum(len(node.values) - 1 for node in every if isinstance(node, ast.BoolOp))
    filters = sum(len(node.ifs) for node in every if isinstance(node, ast.comprehension))
    return 1 + sum(isinstance(node, _BRANCHES) for node in every) + further + filters


def test_the_package_does_not_grow() -> None:
    every = [node for path in FILES for node in nodes(path)]
    functions = [node for node in every if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    arguments = [node.args for node in functions]
    names = [[one.arg for one in (*args.posonlyargs, *args.args, *args.kwonlyargs)] for args in arguments]
    branching = [complexity(node) for node in functions]
    counts = {
        "statements": sum(isinstance(node, ast.stmt) for node in every),
        "files": len(FILES),
        "classes": sum(isinstance(node, ast.ClassDef) for node in every),
        "functions of 8 arguments and more": sum(len(set(some) - {"self", "cls"}) >= 8 for some in names),
        "functions of complexity above 10": sum(one > 10 for one in branching),
        "functions of complexity above 20": sum(one > 20 for one in branching),
    }
    assert {what: count for what, count in counts.items() if count > TOTALS[what]} == {}
