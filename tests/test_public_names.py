"""The public names: few, real and documented; and nothing public in any module is without a docstring."""

from __future__ import annotations

import ast
import importlib.util
import inspect
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from sources import FILES, SOURCE, parsed

import rankdrop

ROOMS = (
    "robot", "local", "families", "formula", "exact", "cover", "distance", "text", "results", "verbs", "poses", "path",
    "aspects", "jobs", "designs",
)  # fmt: skip
NAMES: list[str] = getattr(rankdrop, "__all__", [])


def test_they_are_few() -> None:
    assert 0 < len([name for name in NAMES if name != "__version__"]) <= 25
    assert len(set(NAMES)) == len(NAMES)


def test_each_exists_and_is_documented() -> None:
    for name in NAMES:
        value = getattr(rankdrop, name)
        if inspect.isclass(value) or inspect.isfunction(value):
            assert (inspect.getdoc(value) or "").strip(), name
            assert value.__module__.startswith("rankdrop."), name


def test_nothing_else_looks_public() -> None:
    """Names without an underscore in the package are exported ones or its own modules."""
    extra = [
        name
        for name, value in vars(rankdrop).items()
        if not name.startswith("_") and name not in NAMES and not inspect.ismodule(value)
    ]
    assert set(extra) <= {"annotations"}


def public_definitions(path: Path) -> Iterator[tuple[str, ast.AST]]:
    """Public functions and classes of a file, and public methods and properties of the public classes."""
    tree = parsed(path)
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    for node in tree.body:
        if not isinstance(node, kinds) or node.name.startswith("_"):
            continue
        yield node.name, node
        if isinstance(node, ast.ClassDef):
            inner = [n for n in node.body if isinstance(n, kinds) and not n.name.startswith("_")]
            yield from ((f"{node.name}.{n.name}", n) for n in inner)


def test_everything_public_has_a_docstring() -> None:
    bare = []
    for path in FILES:
        name = path.relative_to(SOURCE).as_posix()
        bare += [f"{name}: {inner}" for inner, node in public_definitions(path) if not ast.get_docstring(node)]  # type: ignore[arg-type]
        if path.name != "__init__.py" and not ast.get_docstring(parsed(path)):
            bare.append(f"{name}: the module itself")
    assert FILES
    assert not bare, "without a docstring:\n" + "\n".join(bare)


def test_the_package_is_loaded_lazily() -> None:
    """A name is loaded when it is asked for: `import rankdrop` costs a hundredth of a second, `--help` not NumPy."""
    code = "import sys, rankdrop; print(sum(m.startswith('rankdrop') for m in sys.modules), 'numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    count, numpy = done.stdout.split()
    assert int(count) <= 4
    assert numpy == "False"
    code = "import sys; from rankdrop.cli.main import run; run(['--help']); sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True).returncode == 0


WITHOUT_ALGEBRA = (
    "explain puma560 --q 0.1,0.2,0.3,0.4,0.5,0.6", "nearest ur5 --q 0,1,1,1,1,1", "path puma560 free.csv",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("line", WITHOUT_ALGEBRA)
def test_questions_about_a_known_arm_load_no_exact_algebra(line: str, tmp_path: Path) -> None:
    """Conditions come as plain data from the catalogue: a fifth of the time of such a command would go into loading."""
    code = (
        "import sys; from rankdrop.cli.main import run; run(sys.argv[1:]); "
        "sys.exit(any(name.startswith(('rankdrop.exact.', 'flint')) for name in sys.modules))"
    )
    (tmp_path / "free.csv").write_text("t,q1,q2,q3,q4,q5,q6\n0,0,0,1,0,1,0\n1,0.1,0,1,0,1,0\n")
    done = subprocess.run([sys.executable, "-c", code, *line.split(), "--quiet"], capture_output=True, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.slow
def test_a_path_of_joint_values_loads_no_coverings_and_no_checker(tmp_path: Path) -> None:
    """A third of the time of such a command was loading, a third of that for questions that nobody asked."""
    code = (
        "import sys; from rankdrop.cli.main import run; run(sys.argv[1:]); print(*(name for name in sys.modules if "
        "name.startswith(('rankdrop.proof', 'rankdrop.cover.cov', 'rankdrop.families.row', 'rankdrop.distance.tol'))))"
    )
    (tmp_path / "free.csv").write_text("t,q1,q2,q3,q4,q5,q6\n0,0,0,1,0,1,0\n1,0.1,0,1,0,1,0\n")
    words = ["path", "puma560", "free.csv", "--quiet"]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout.splitlines()[-1] == ""


def test_a_name_is_not_hidden_by_the_module_that_holds_it() -> None:
    """Rooms are lazy as well: a module of the same name, once loaded, would stand in place of the name."""
    hidden = [
        f"{room.__name__}.{name}"
        for room in (rankdrop, *(importlib.import_module(f"rankdrop.{one}") for one in ROOMS))
        for name in room.__all__
        if importlib.util.find_spec(f"{room.__name__}.{name}") is not None
    ]
    assert not hidden, "\n".join(hidden)


def test_a_task_is_told_in_the_same_way_everywhere() -> None:
    """A name, a `Task`, or nothing for the task the arm is made for: every function that takes one takes all three."""
    functions = {name: getattr(rankdrop, name) for name in NAMES if inspect.isfunction(getattr(rankdrop, name))}
    tasks = {name: inspect.signature(f).parameters.get("task") for name, f in functions.items()}
    told = {name: (task.default, set(task.annotation.split(" | "))) for name, task in tasks.items() if task is not None}
    assert len(told) > 5
    assert {name: one for name, one in told.items() if one != (None, {"Task", "str", "None"})} == {}
