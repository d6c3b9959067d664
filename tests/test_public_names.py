"""The public names: few, real and documented; and nothing public in any module is without a docstring."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path

import pytest

import rankdrop

SOURCE = Path(__file__).resolve().parents[1] / "src" / "rankdrop"
FILES = sorted(SOURCE.rglob("*.py"))
NAMES: list[str] = getattr(rankdrop, "__all__", [])


def test_there_are_at_most_twenty() -> None:
    assert 0 < len([name for name in NAMES if name != "__version__"]) <= 20
    assert len(set(NAMES)) == len(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_each_exists_and_is_documented(name: str) -> None:
    value = getattr(rankdrop, name)
    if inspect.isclass(value) or inspect.isfunction(value):
        assert (inspect.getdoc(value) or "").strip()
        assert value.__module__.startswith("rankdrop.")


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
    tree = ast.parse(path.read_text(encoding="utf-8"))
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    for node in tree.body:
        if not isinstance(node, kinds) or node.name.startswith("_"):
            continue
        yield node.name, node
        if isinstance(node, ast.ClassDef):
            inner = [n for n in node.body if isinstance(n, kinds) and not n.name.startswith("_")]
            yield from ((f"{node.name}.{n.name}", n) for n in inner)


@pytest.mark.parametrize("path", FILES, ids=[path.relative_to(SOURCE).as_posix() for path in FILES])
def test_everything_public_has_a_docstring(path: Path) -> None:
    bare = [name for name, node in public_definitions(path) if not ast.get_docstring(node)]  # type: ignore[arg-type]
    assert bare == []
    if path.name != "__init__.py":
        assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
