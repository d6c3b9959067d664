"""Imports go down only; CONTRIBUTING has the floors. Faces use public names; derivation and search are apart.

A module imports from lower floors, and from its own where that makes no cycle. Imports inside functions count too.
"""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from sources import FILES, ROOT, SOURCE, nodes, parsed

import rankdrop

FLOORS = {
    "errors": 0, "disk": 0, "lists": 0, "tolerances": 0, "version": 0, "sections": 0, "headers": 0, "_core": 0,
    "jobs": 0, "options": 0, "questions": 0, "codec": 0, "proof": 0, "named_tasks": 0,
    "robot": 1,
    "kinematics": 2, "task": 2, "units": 2,
    "local": 3, "problem": 3, "configuration": 3, "solve": 2,
    "algebra": 4, "families": 4, "formula": 4,
    "exact": 5, "cover": 5, "distance": 5,
    "text": 7, "results": 7, "schema": 7,
    "verbs": 8, "poses": 8, "path": 8, "aspects": 8,
    "designs": 9,
    "cli": 10, "__main__": 10, "report": 10, "viewer": 10,
}  # fmt: skip
TOP = 10
FACE_ROOMS = frozenset(room for room, place in FLOORS.items() if place == TOP)

OPTIONAL = {"xacro", "mujoco", "pinocchio", "viser", "sympy", "flint", "matplotlib", "contourpy", "mpl_toolkits",
            "plotly", "jinja2", "yourdfpy", "roboticstoolbox", "trimesh", "websockets", "playwright", "yaml",
            "rosbags", "pyarrow", "scipy", "distributed", "threadpoolctl"}  # fmt: skip
"""Not installed by default: only inside the function that needs them."""
FACES = {"rich", "cyclopts"}
"""For the command line alone."""


def modules() -> dict[str, Path]:
    """Every module of the package by its dotted name without `rankdrop.`; the package itself is left out."""
    found = {}
    for path in FILES:
        parts = path.relative_to(SOURCE).with_suffix("").parts
        parts = parts[:-1] if parts[-1] == "__init__" else parts
        if parts:
            found[".".join(parts)] = path
    return found


MODULES = modules()


def imports(path: Path, *, at_import_only: bool = False) -> Iterator[str]:
    """Full dotted names imported by a file; `from a import b` gives a.b. Names for type checking count unless asked."""
    stack: list[ast.AST] = [parsed(path)]
    while stack:
        node = stack.pop()
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif at_import_only and isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        elif at_import_only and isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            stack.extend(node.orelse)
        else:
            stack.extend(ast.iter_child_nodes(node))


@cache
def own_imports(module: str) -> frozenset[str]:
    """Modules of this package that `module` imports."""
    names = set()
    for name in imports(MODULES[module]):
        if not name.startswith("rankdrop.") or name in PUBLIC:
            continue
        inner = name.removeprefix("rankdrop.")
        # `from rankdrop.task import Task` names a thing inside a module, `from rankdrop.cli import exits` a module
        names.add(inner if inner in MODULES else inner.rpartition(".")[0] or inner)
    return frozenset(names - {module})


def floor(module: str) -> int:
    """The floor a module stands on."""
    return FLOORS[module.split(".")[0]]


def test_every_module_has_a_floor() -> None:
    assert [module for module in MODULES if module.split(".")[0] not in FLOORS] == []


def test_imports_go_down() -> None:
    upward = [
        f"{module} imports {name}" for module in MODULES for name in own_imports(module) if floor(name) > floor(module)
    ]
    assert not upward, "\n".join(upward)


PUBLIC = frozenset(f"rankdrop.{name}" for name in rankdrop.__all__)


RECORD = frozenset(
    f"families.{name}"
    for name in (
        "contradiction", "distinct_names", "evidence", "facts", "lost", "name", "naming", "not_derived", "record",
        "summary", "unfinished",
    )
)
"""What a family is, however it was found."""


def test_derivation_and_search_are_apart() -> None:
    """The derivation knows the record of a family, and nothing of the search; the search nothing of the derivation."""
    assert set(MODULES) >= RECORD
    meeting = [
        f"{module} imports {name}"
        for module in MODULES
        for name in own_imports(module) - RECORD
        if {module.split(".")[0], name.split(".")[0]} == {"exact", "families"}
    ]
    assert not meeting, "\n".join(meeting)
    assert not any("families" in name for module in RECORD for name in own_imports(module) - RECORD)


def names_used(path: Path) -> Iterator[str]:
    """Names that a file imports, and `rankdrop.room.name` of every `room.name` of a room that it imports as a whole."""
    yield from imports(path)
    rooms = {
        alias.asname or alias.name: alias.name
        for node in nodes(path) if isinstance(node, ast.ImportFrom) and node.module == "rankdrop"
        for alias in node.names
    }  # fmt: skip
    for node in nodes(path):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in rooms:
            yield f"rankdrop.{rooms[node.value.id]}.{node.attr}"


def test_faces_use_public_names() -> None:
    """From the top of the package, or from a room whose list of names (`__init__.pyi`) has them."""
    private = []
    papers = {f"papers.{path.stem}": path for path in sorted((ROOT / "papers").glob("*.py"))}
    assert papers
    for module, path in {**{name: path for name, path in MODULES.items() if floor(name) == TOP}, **papers}.items():
        for name in names_used(path):
            parts = name.split(".")
            if parts[0] != "rankdrop" or parts[1] in FACE_ROOMS or name in PUBLIC or len(parts) == 2:
                continue
            if f"rankdrop.{parts[1]}" in PUBLIC:
                continue  # `Analysis.load`, of a class at the top of the package
            room = importlib.import_module(f"rankdrop.{parts[1]}")
            listed = parts[2] in room.__all__ if hasattr(room, "__all__") else not parts[2].startswith("_")
            if len(parts) != 3 or not listed:
                private.append(f"{module} uses {name}")
    assert not private, "\n".join(private)


def test_the_package_root_is_not_imported_from_inside() -> None:
    from_the_root = [
        f"{module} imports {name}"
        for module, path in MODULES.items()
        for name in imports(path)
        if name == "rankdrop" or name.startswith("rankdrop.__") or (name in PUBLIC and floor(module) < TOP)
    ]
    assert not from_the_root, "\n".join(from_the_root)


def circles(needed: dict[str, frozenset[str]]) -> list[str]:
    """Modules on an import circle, and those that need one, sorted: what is left when every other is taken out.

    Args:
        needed: module -> modules that it imports, anywhere in its file: at the top, in functions, for the type checker.
    """
    left = {module: others & needed.keys() for module, others in needed.items()}
    while ready := [module for module, others in left.items() if not others & set(left)]:
        for module in ready:
            del left[module]
    return sorted(left)


def test_no_import_circles() -> None:
    left = circles({module: own_imports(module) for module in MODULES})
    assert not left, f"these import each other: {left}; a record reaches its words by `rankdrop.sections.words_of`"


PLANTED = """
from __future__ import annotations
from typing import TYPE_CHECKING
if TYPE_CHECKING:
    from rankdrop.results.explanation import Explanation
"""


@pytest.mark.parametrize("source", [PLANTED, "def f():\n    from rankdrop.results import explanation\n"])
def test_a_planted_circle_is_found(source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Imports for the type checker and inside functions count: explanation imports configuration, below it."""
    planted = tmp_path / "configuration.py"
    planted.write_text(source, encoding="utf-8")
    monkeypatch.setitem(MODULES, "planted", planted)
    needed = {module: own_imports(module) for module in MODULES if module != "planted"}
    found = own_imports.__wrapped__("planted")
    assert found == {"results.explanation"}
    assert circles(needed) == []
    assert {"configuration", "results.explanation"} <= set(circles(needed | {"configuration": found}))


def folder(module: str) -> str:
    """The folder a module's file is in; "" for the top of the package."""
    return MODULES[module].parent.relative_to(SOURCE).as_posix().removeprefix(".")


def test_no_two_folders_import_each_other() -> None:
    """The top of the package is no folder."""
    needed: dict[str, set[str]] = {}
    for module in MODULES:
        theirs = {folder(name) for name in own_imports(module) if name in MODULES}
        needed.setdefault(folder(module), set()).update(theirs - {folder(module), ""})
    both = {(one, other) for one in needed for other in needed[one] if one and one < other and one in needed[other]}
    assert both == set(), "these folders import each other: move what both need, or make them one"


def test_optional_packages_are_imported_where_they_are_needed() -> None:
    early = []
    for module, path in MODULES.items():
        refused = OPTIONAL if floor(module) == TOP else OPTIONAL | FACES
        tops = {name.split(".")[0] for name in imports(path, at_import_only=True)}
        early += [f"{module} imports {name}" for name in sorted(tops & refused)]
    assert not early, "\n".join(early)


def test_importing_the_package_stays_light() -> None:
    program = "import sys, rankdrop; print(*sorted({name.split('.')[0] for name in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) & (OPTIONAL | FACES) == set()


def test_the_core_knows_nothing_of_python() -> None:
    core = ROOT / "src" / "core"
    sources = [path for path in core.iterdir() if path.suffix in {".hpp", ".cpp"}]
    files = [path for path in sources if not path.name.startswith("bindings")]
    assert files
    for path in files:
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#include")]
        assert [line for line in lines if "nanobind" in line or "Python.h" in line] == [], path.name
