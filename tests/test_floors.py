"""Imports go down only. Floors, lowest first:

0  errors, tolerances, version, sections (text in parts), the compiled core
1  robot/, reach  the robot as data, and the numbers it is known by
2  kinematics, task, frames, units of length, and what the core is told of them
3  local/      at one configuration: what is lost, who is to blame, how to get out, how far, what motion costs
4  atlas/      over the whole joint space; certify/: proofs
5  analyze, explain: the verbs, the records they return, as JSON and as sections of text; known: the shipped results;
   motion/: paths, read and judged
6  cli/, report/, viewer/, reproduce/

A module imports from lower floors, and from its own where that makes no cycle. Imports inside functions count too.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "rankdrop"

FLOORS = {
    "errors": 0, "tolerances": 0, "version": 0, "sections": 0, "_core": 0,
    "robot": 1, "reach": 1,
    "kinematics": 2, "task": 2, "frames": 2, "units": 2, "_handles": 2,
    "local": 3,
    "atlas": 4, "certify": 4, "exact": 4,
    "analyze": 5, "result": 5, "record": 5, "known": 5, "known_conditions": 5, "findings": 5, "schema": 5,
    "conditions": 5, "derived": 5, "join": 5, "partition": 5, "joined": 5, "verdict": 5, "checks": 5, "exactly": 5,
    "beside": 5,
    "explain": 5, "explanation": 5, "motion": 5,
    "cli": 6, "report": 6, "viewer": 6, "reproduce": 6,
}  # fmt: skip

OPTIONAL = {"xacrodoc", "mujoco", "pinocchio", "viser", "sympy", "flint", "matplotlib", "plotly", "jinja2", "yourdfpy",
            "trimesh", "websockets", "playwright", "yaml"}  # fmt: skip
"""Not installed by default: only inside the function that needs them."""
FACES = {"rich", "cyclopts"}
"""For the command line alone."""


def modules() -> dict[str, Path]:
    """Every module of the package by its dotted name without `rankdrop.`; the package itself is left out."""
    found = {}
    for path in sorted(SOURCE.rglob("*.py")):
        parts = path.relative_to(SOURCE).with_suffix("").parts
        parts = parts[:-1] if parts[-1] == "__init__" else parts
        if parts:
            found[".".join(parts)] = path
    return found


MODULES = modules()


def imports(path: Path, *, at_import_only: bool = False) -> Iterator[str]:
    """Full dotted names imported by a file; `from a import b` gives a.b. Names for type checking count unless asked."""
    stack: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
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


def own_imports(module: str) -> set[str]:
    """Modules of this package that `module` imports."""
    names = set()
    for name in imports(MODULES[module]):
        if not name.startswith("rankdrop."):
            continue
        inner = name.removeprefix("rankdrop.")
        # `from rankdrop.task import Task` names a thing inside a module, `from rankdrop.cli import exits` a module
        names.add(inner if inner in MODULES else inner.rpartition(".")[0] or inner)
    return names - {module}


def floor(module: str) -> int:
    """The floor a module stands on."""
    return FLOORS[module.split(".")[0]]


def test_every_module_has_a_floor() -> None:
    assert [module for module in MODULES if module.split(".")[0] not in FLOORS] == []


@pytest.mark.parametrize("module", MODULES)
def test_imports_go_down(module: str) -> None:
    upward = [name for name in own_imports(module) if floor(name) > floor(module)]
    assert upward == []


@pytest.mark.parametrize("module", MODULES)
def test_the_package_root_is_not_imported_from_inside(module: str) -> None:
    root = [name for name in imports(MODULES[module]) if name == "rankdrop" or name.startswith("rankdrop.__")]
    assert root == []


def test_no_cycles() -> None:
    left = {module: own_imports(module) & set(MODULES) for module in MODULES}
    while ready := [module for module, needed in left.items() if not needed & set(left)]:
        for module in ready:
            del left[module]
    assert not left, f"these import each other: {sorted(left)}"


@pytest.mark.parametrize("module", MODULES)
def test_optional_packages_are_imported_where_they_are_needed(module: str) -> None:
    tops = {name.split(".")[0] for name in imports(MODULES[module], at_import_only=True)}
    assert tops & OPTIONAL == set()
    if floor(module) < 6:
        assert tops & FACES == set()


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
