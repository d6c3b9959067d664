"""What a reader feels, in bounds for each room that only go down: one step per line, functions that fit in the head.

A new capability may raise a bound of its room in the commit that adds it, which says why.
"""

from __future__ import annotations

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator
from functools import cache

import pytest
from sources import FILES, SOURCE, nodes

Function = ast.FunctionDef | ast.AsyncFunctionDef
COMPREHENSIONS = ast.ListComp | ast.SetComp | ast.GeneratorExp | ast.DictComp
BRANCHES = ast.If | ast.IfExp | ast.For | ast.While | ast.ExceptHandler | ast.comprehension | ast.Assert

CONDITIONAL, NESTED = 22, 6
"""In the whole package, for each thousand statements: conditional expressions, comprehensions inside others."""

BOUNDS: dict[str, tuple[int, int, int, int]] = {
    ".": (32, 2, 4, 0), "algebra": (27, 41, 16, 0), "aspects": (10, 7, 0, 0), "cli": (76, 2, 11, 0),
    "cover": (28, 3, 6, 0), "designs": (31, 5, 2, 0), "distance": (19, 1, 0, 0), "exact": (83, 96, 34, 0),
    "families": (76, 27, 10, 0), "formula": (54, 20, 9, 0), "jobs": (3, 0, 1, 0), "local": (45, 10, 7, 0),
    "path": (138, 11, 19, 0), "poses": (14, 1, 1, 0), "proof": (43, 18, 20, 0), "report": (65, 7, 7, 0),
    "results": (19, 5, 4, 0), "robot": (81, 5, 12, 0), "schema": (11, 0, 0, 0), "text": (176, 15, 7, 0),
    "verbs": (18, 0, 0, 0), "viewer": (37, 4, 2, 0),
}  # fmt: skip
"""Conditional expressions, nested comprehensions, functions of complexity above 10, and above 20, of each room."""


ASSIGNED_ONE = 5
"""Files that assign the name `one`, which says nothing of what it is: a family, a row, a stretch."""
EMPTY_NAMES, EMPTY = frozenset({"own", "made", "told", "some", "again", "here"}), 175
"""Further names that say nothing, and how often one of them is assigned or is the name of a parameter."""
LATE_CONSTANTS = 192
"""Constants after a definition of their module; most are tables of files that need a function before them."""
TWO_THINGS = 5
"""Names of classes that two modules give to different things, an underscore in front or not."""


def functions(tree: ast.AST) -> Iterator[Function]:
    """All functions, inner ones as well."""
    return (node for node in ast.walk(tree) if isinstance(node, Function))


def complexity(function: Function) -> int:
    """McCabe's number: one, and one more for each branch and each `and` or `or`."""
    count = 1
    for node in ast.walk(function):
        if isinstance(node, BRANCHES):
            count += 1
        elif isinstance(node, ast.BoolOp):
            count += len(node.values) - 1
    return count


def nested(node: ast.AST) -> bool:
    """Whether it is a comprehension with several loops, or one around another."""
    if not isinstance(node, COMPREHENSIONS):
        return False
    inner = sum(isinstance(other, COMPREHENSIONS) for other in ast.walk(node)) - 1
    return len(node.generators) > 1 or inner > 0


@cache
def counted() -> tuple[dict[str, tuple[int, int, int, int]], Counter[str]]:
    """What BOUNDS bounds, for each room; and the sums over the package, statements in functions among them."""
    rooms: dict[str, Counter[str]] = defaultdict(Counter)
    for path in FILES:
        parts = path.relative_to(SOURCE).parts
        room = rooms[parts[0] if len(parts) > 1 else "."]
        for function in (node for node in nodes(path) if isinstance(node, Function)):
            many = complexity(function)
            room["above 10"] += many > 10
            room["above 20"] += many > 20
        for node in nodes(path):
            room["statements"] += isinstance(node, ast.stmt)
            room["conditional"] += isinstance(node, ast.IfExp)
            room["nested"] += nested(node)
    names = ("conditional", "nested", "above 10", "above 20")
    return {room: tuple(one[name] for name in names) for room, one in rooms.items()}, sum(rooms.values(), Counter())


def test_each_room_has_bounds() -> None:
    assert set(counted()[0]) == set(BOUNDS)


@pytest.mark.parametrize("room", BOUNDS)
def test_a_room_gets_no_harder_to_read(room: str) -> None:
    found, bounds = counted()[0][room], BOUNDS[room]
    names = ("conditional expressions", "nested comprehensions", "functions above 10", "functions above 20")
    more = [f"{name}: {a} > {b}" for name, a, b in zip(names, found, bounds, strict=True) if a > b]
    assert more == [], room


def assigns_one(node: ast.AST) -> bool:
    """Whether it gives the name `one` to something: by an assignment, a loop or a comprehension."""
    return isinstance(node, ast.Name) and node.id == "one" and isinstance(node.ctx, ast.Store)


def test_things_are_called_what_they_are() -> None:
    files = [path for path in FILES if any(map(assigns_one, nodes(path)))]
    assert len(files) <= ASSIGNED_ONE


def is_empty_name(node: ast.AST) -> bool:
    """Whether it gives one of `EMPTY_NAMES` to something, or to a parameter."""
    if isinstance(node, ast.arg):
        return node.arg in EMPTY_NAMES
    return isinstance(node, ast.Name) and node.id in EMPTY_NAMES and isinstance(node.ctx, ast.Store)


def test_names_that_say_nothing_get_rarer() -> None:
    assert sum(is_empty_name(node) for path in FILES for node in nodes(path)) <= EMPTY


def late_constants(tree: ast.Module) -> int:
    """How many names a module is given values for, statement by statement, after its first function or class."""
    defined = [isinstance(node, Function | ast.ClassDef) for node in tree.body]
    first = defined.index(True) if any(defined) else len(defined)
    return sum(isinstance(node, ast.Assign | ast.AnnAssign) for node in tree.body[first:])


def test_constants_stand_at_the_top() -> None:
    assert sum(late_constants(ast.parse(path.read_text(encoding="utf-8"))) for path in FILES) <= LATE_CONSTANTS


def test_a_constant_after_a_definition_is_counted() -> None:
    assert late_constants(ast.parse("A = 1\ndef f(): pass\nB = 2\nclass C: pass\nD: int = 3")) == 2


def test_a_name_of_a_class_stands_for_one_thing() -> None:
    """A reader who searches for it finds one definition."""
    modules: dict[str, set[str]] = defaultdict(set)
    for path in FILES:
        for node in nodes(path):
            if isinstance(node, ast.ClassDef):
                modules[node.name.lstrip("_")].add(str(path))
    shared = sorted(name for name, where in modules.items() if len(where) > 1)
    assert len(shared) <= TWO_THINGS, ", ".join(shared)


def test_the_package_as_a_whole() -> None:
    whole = counted()[1]
    assert whole["conditional"] <= CONDITIONAL * whole["statements"] / 1000
    assert whole["nested"] <= NESTED * whole["statements"] / 1000


@pytest.mark.parametrize(
    ("text", "number"),
    [("def f():\n  pass", 1), ("def f(a):\n  return 1 if a and a > 2 else 0", 3),
     ("def f(a):\n  return [x for x in a if x]", 2), ("def f(a):\n  for x in a:\n    if x:\n      return x", 3)],
)
def test_complexity_counts_what_it_says(text: str, number: int) -> None:
    assert complexity(next(functions(ast.parse(text)))) == number


def test_a_comprehension_around_another_is_nested() -> None:
    flat, deep = (ast.parse(text, mode="eval").body for text in ("[x for x in a]", "[[y for y in x] for x in a]"))
    assert (nested(flat), nested(deep)) == (False, True)


@pytest.mark.parametrize(
    ("text", "number"), [("for one in a: pass", 1), ("[one for one in a]", 1), ("one = 1", 1), ("f(one)", 0)]
)
def test_a_name_that_is_assigned_is_seen(text: str, number: int) -> None:
    assert sum(map(assigns_one, ast.walk(ast.parse(text)))) == number


@pytest.mark.parametrize(("text", "number"), [("def f(made): return made", 1), ("told = [own for own in a]", 2)])
def test_a_name_that_says_nothing_is_seen(text: str, number: int) -> None:
    assert sum(map(is_empty_name, ast.walk(ast.parse(text)))) == number
