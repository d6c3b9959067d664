"""Do the tests see a fault? One small change at a time to a file, and whether some test fails then.

    .venv/bin/python tools/mutate.py src/rankdrop/cover/covering.py --tests tests/cover/test_covering.py --most 40
    .venv/bin/python tools/mutate.py src/core/readable.cpp --tests tests/local/test_readable_planted.py --most 20

With several files, or whole folders, the tests of each line are those that reach it, as coverage.py recorded (`pip
install pytest-cov`), the ones that reach least first; what they do not see is tried with ten times as many, and a line
that none reaches is told:

    COVERAGE_FILE=build/reached .venv/bin/pytest --cov=rankdrop --cov-context=test --cov-report= tests/exact
    .venv/bin/python tools/mutate.py src/rankdrop/exact --reached build/reached --most 5

Changes of Python are made in its syntax tree: comparisons, arithmetic, and/or, not, numbers, True and False,
conditions. Changes of C++ are the same signs in its text; the core is built anew for each. Both work
on a copy of the package: the sources stay as they are. A change that no test sees is printed with its line: a test is
missing, or the change makes no difference. docs/checks.md has what was found.
"""

from __future__ import annotations

import argparse
import ast
import compileall
import copy
import json
import os
import py_compile
import random
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COMPARED = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
            ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is}  # fmt: skip
COMPUTED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Add, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
            ast.Mod: ast.Mult, ast.LShift: ast.RShift, ast.RShift: ast.LShift, ast.BitAnd: ast.BitOr,
            ast.BitOr: ast.BitAnd, ast.BitXor: ast.BitAnd, ast.MatMult: ast.Add, ast.Pow: ast.Mult}  # fmt: skip
WRITTEN = (("<=", "<"), (">=", ">"), (" < ", " <= "), (" > ", " >= "), ("==", "!="), ("!=", "=="), (" + ", " - "),
           (" - ", " + "), (" * ", " + "), (" / ", " * "), ("&&", "||"), ("||", "&&"), ("++", "--"))  # fmt: skip
ENDS = ("killed", "survived", "no build", "not reached")


@dataclass(frozen=True, slots=True)
class Mutant:
    """A changed text of the file, and where it differs."""

    text: str
    line: int
    what: str


def changes(node: ast.AST) -> Iterator[ast.AST]:
    """Copies of an expression with one small change each, in the expression itself."""
    made = copy.deepcopy(node)
    if isinstance(made, ast.Compare):
        made.ops[0] = COMPARED[type(made.ops[0])]()
        yield made
    elif isinstance(made, ast.BinOp) and type(made.op) in COMPUTED:
        made.op = COMPUTED[type(made.op)]()
        yield made
    elif isinstance(made, ast.BoolOp):
        made.op = ast.Or() if isinstance(made.op, ast.And) else ast.And()
        yield made
    elif isinstance(made, ast.UnaryOp) and isinstance(made.op, ast.Not | ast.USub):
        yield made.operand
    elif isinstance(made, ast.Constant) and isinstance(made.value, bool):
        made.value = not made.value
        yield made
    elif isinstance(made, ast.Constant) and isinstance(made.value, int | float):
        made.value = made.value + 1
        yield made
    elif isinstance(made, ast.IfExp):
        yield made.body
        yield made.orelse


def of_python(text: str) -> list[Mutant]:
    """Every mutant of a Python file; annotations and f-strings are left alone."""
    tree = ast.parse(text)
    noted = [one for node in ast.walk(tree) for name in ("annotation", "returns") if (one := getattr(node, name, None))]
    left = {id(part) for one in noted for part in ast.walk(one)}
    left |= {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in ast.walk(node)}
    lines = text.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line.encode()))
    whole, found = text.encode(), []
    for node in ast.walk(tree):
        if not isinstance(node, ast.expr) or id(node) in left:
            continue
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        begin, end = starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset
        for changed in changes(node):
            new = f"({ast.unparse(changed)})"
            old = whole[begin:end].decode()
            found.append(Mutant((whole[:begin] + new.encode() + whole[end:]).decode(), node.lineno, f"{old} -> {new}"))
    return found


def of_cpp(text: str) -> list[Mutant]:
    """Every mutant of a C++ file; comments, includes and templates' brackets are left alone."""
    found, at = [], 0
    for number, line in enumerate(text.splitlines(keepends=True), start=1):
        code = line.split("//")[0]
        if not code.lstrip().startswith(("#", "template", "namespace", "using")):
            for old, new in WRITTEN:
                for match in re.finditer(re.escape(old), code):
                    begin = at + match.start()
                    changed = text[:begin] + new + text[begin + len(old) :]
                    found.append(Mutant(changed, number, f"{code.strip()}: {old.strip()} -> {new.strip()}"))
        at += len(line)
    return found


class Reached:
    """Which tests reach a line: what `pytest --cov-context=test` recorded."""

    def __init__(self, file: Path) -> None:
        with sqlite3.connect(file) as data:
            names = dict(data.execute("select id, context from context"))
            asked = "select file.path, context_id, numbits from line_bits join file on file.id = file_id"
            rows = list(data.execute(asked))
        self.lines: dict[str, dict[str, set[int]]] = {}
        size: dict[str, int] = {}
        for path, context, bits in rows:
            test = names[context].split("|")[0]
            lines = {8 * at + bit for at, byte in enumerate(bits) for bit in range(8) if byte >> bit & 1}
            size[test] = size.get(test, 0) + len(lines)
            self.lines.setdefault(path.partition("/src/")[2], {}).setdefault(test, set()).update(lines)
        self.size = size

    def tests(self, file: Path, line: int) -> list[str]:
        """The tests that reach a line and least else; of the whole file where it is run at import alone."""
        there = self.lines.get(str(file.relative_to(ROOT / "src")), {})
        found = [test for test, lines in there.items() if line in lines]
        if "" in found:
            found = list(there)
        return sorted((test for test in found if test), key=lambda test: (self.size[test], test))


class Copy:
    """A copy of the sources in which one file is another."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for part in ("src", "tests", "tools"):
            shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
        for part in ("CMakeLists.txt", "pyproject.toml", "README.md"):
            shutil.copy(ROOT / part, folder / part)
        # by their text: a mutant may be as long as what it replaces, and written in the same second
        checked = py_compile.PycInvalidationMode.CHECKED_HASH
        compileall.compile_dir(folder / "src", quiet=2, invalidation_mode=checked)

    def build(self) -> bool:
        """Build the core of the copy; False where it does not compile."""
        place = self.folder / "build"
        asked = [sys.executable, "-m", "nanobind", "--cmake_dir"]
        nanobind = subprocess.run(asked, text=True, capture_output=True, check=True)
        told = ["cmake", "-S", self.folder, "-B", place, "-G", "Ninja", f"-DPython_EXECUTABLE={sys.executable}",
                f"-Dnanobind_ROOT={nanobind.stdout.strip()}", "-DRANKDROP_WIDE=OFF"]  # fmt: skip
        if subprocess.run([str(part) for part in told], capture_output=True, check=False).returncode:
            raise SystemExit("the core cannot be configured: cmake and ninja are needed")
        if subprocess.run(["ninja", "-C", str(place)], capture_output=True, check=False).returncode:
            return False
        for core in place.glob("_core*.so"):
            shutil.copy(core, self.folder / "src" / "rankdrop" / core.name)
        return True

    def seen(self, file: Path, text: str, tests: list[str], seconds: float) -> str:
        """How the tests take a text of a file: "killed", "survived" or "no build"; the copy is as before then."""
        place = self.folder / file.relative_to(ROOT)
        before = place.read_text(encoding="utf-8")
        place.write_text(text, encoding="utf-8")
        cores = {core: core.read_bytes() for core in (self.folder / "src" / "rankdrop").glob("_core*.so")}
        try:
            if file.suffix in (".cpp", ".hpp") and not self.build():
                return "no build"
            return self.judged(tests, seconds)
        finally:
            place.write_text(before, encoding="utf-8")
            for core, kept in cores.items():
                core.write_bytes(kept)

    def judged(self, tests: list[str], seconds: float) -> str:
        """What the tests say of the copy as it is."""
        environment = os.environ | {"PYTHONPATH": f"{self.folder / 'src'}{os.pathsep}{self.folder / 'tests'}",
                                    "PYTHONDONTWRITEBYTECODE": "1"}  # fmt: skip
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
        try:
            done = subprocess.run(
                command, cwd=self.folder, env=environment, capture_output=True, timeout=seconds, check=False
            )
        except subprocess.TimeoutExpired:
            return "killed"  # it does not end any more
        return "survived" if done.returncode == 0 else "killed"


def mutants(file: Path, most: int, seed: int) -> tuple[int, list[Mutant]]:
    """How many mutants there are in all places of a file, and so many of them, by line."""
    text = file.read_text(encoding="utf-8")
    every = of_python(text) if file.suffix == ".py" else of_cpp(text)
    return len(every), sorted(random.Random(seed).sample(every, min(most, len(every))), key=lambda one: one.line)


def main(argv: list[str] | None = None) -> int:
    """The command line; 1 where the tests fail without any change."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", type=Path, nargs="+", help="to change: files, or folders of Python")
    asked = parser.add_mutually_exclusive_group(required=True)
    asked.add_argument("--tests", nargs="+", default=[], help="files of tests that are to see it")
    asked.add_argument("--reached", type=Path, help="what pytest --cov-context=test recorded")
    parser.add_argument("--nearest", type=int, default=8, help="with --reached: tests of each line, at first")
    parser.add_argument("--most", type=int, default=50, help="mutants tried of each file, drawn at random")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--seconds", type=float, default=120.0, help="after which a test run has not ended")
    given = parser.parse_args(argv)
    reached = Reached(given.reached) if given.reached else None
    files = [one.resolve() for file in given.files for one in (sorted(file.rglob("*.py")) if file.is_dir() else [file])]
    with tempfile.TemporaryDirectory() as folder:
        copied = Copy(Path(folder) / "copy")
        first = files[0].read_text(encoding="utf-8")
        if given.tests and copied.seen(files[0], first, given.tests, 10 * given.seconds) != "survived":
            print("the tests fail as it is", file=sys.stderr)
            return 1
        for file in files:
            every, drawn = mutants(file, given.most, given.seed)
            counted = {"of": every} | dict.fromkeys(ENDS, 0)
            for mutant in drawn:
                tests = reached.tests(file, mutant.line) if reached else given.tests
                cut = given.nearest if reached else len(tests)
                ended = "survived" if tests else "not reached"
                for some in (tests[:cut], tests[cut : 11 * cut]):
                    if some and ended == "survived":
                        ended = copied.seen(file, mutant.text, some, given.seconds)
                counted[ended] += 1
                if ended in ("survived", "not reached"):
                    print(f"{file.relative_to(ROOT)}:{mutant.line}: {ended}: {mutant.what}", flush=True)
            judged = counted["killed"] + counted["survived"] + counted["not reached"]
            score = round(counted["killed"] / max(1, judged), 3)
            print(json.dumps({"file": str(file.relative_to(ROOT)), **counted, "score": score}), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
