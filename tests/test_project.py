"""What pages and scripts of the project say of its files, tests and commands is so, and nothing foreign is in it."""

from __future__ import annotations

import ast
import re
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from sources import FILES, ROOT, SOURCE

from rankdrop.cli.main import ALIASES, COMMANDS

HERE = ROOT / "tests"
LARGEST = 2**20  # of a file [bytes]


def kept() -> list[Path]:
    """The files that are kept in the history, or all but what is built, where there is none."""
    command = ["git", "ls-files", "-z", "-co", "--exclude-standard"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode == 0 and done.stdout:
        return [ROOT / name for name in sorted(done.stdout.split("\0")) if name and (ROOT / name).is_file()]
    built = {".venv", "build", ".git", "__pycache__"}
    files = [path for path in sorted(ROOT.rglob("*")) if path.is_file()]
    return [path for path in files if not built & set(path.relative_to(ROOT).parts)]


KEPT = kept()
PAGES = [path for path in KEPT if path.suffix == ".md" and (path.parent == ROOT or (ROOT / "docs") in path.parents)
         and path.name != "CHANGELOG.md"]  # fmt: skip
SCRIPTS = [path for path in KEPT if path.parent == ROOT / ".ci" and path.suffix != ".txt"]


def read(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def named_files(text: str) -> Iterator[str]:
    """Names of files of the project in a page or script: paths from its root, and code in Python and C++."""
    yield from re.findall(r"(?<![\w./-])((?:docs|examples|papers|src|tests|tools|benchmarks)/[\w/-]+\.[a-z]+)\b", text)
    yield from re.findall(r"(?<![\w./-])(\.ci/[\w.-]*\w)", text)
    yield from re.findall(r"`((?:\w+/)*\w+\.(?:py|cpp|hpp))(?:::[\w.]+)?`", text)


@pytest.fixture(scope="module")
def ends() -> set[str]:
    """Every path of a file, and each of its ends: a page says `local/block.py`, or only `block.py`."""
    parts = [path.relative_to(ROOT).parts for path in KEPT]
    return {"/".join(some[i:]) for some in parts for i in range(len(some))}


@pytest.mark.parametrize("page", [*PAGES, *SCRIPTS], ids=lambda path: str(path.relative_to(ROOT)))
def test_every_file_that_a_page_or_script_names_is_there(page: Path, ends: set[str]) -> None:
    assert set(named_files(read(page))) - ends == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_command_that_a_page_names_is_there(page: Path) -> None:
    told = set(re.findall(r"(?m)(?:^\$ |^|`|\.venv/bin/)rankdrop ([a-z][a-z-]*)\b", read(page)))
    assert told - {*COMMANDS, *ALIASES, "completion"} == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_import_that_a_page_shows_works(page: Path) -> None:
    shown = re.findall(r"(?m)^(?:>>> )?(from rankdrop[\w.]* import \w+(?:, \w+)*)", read(page))
    for line in shown:
        exec(line, {})


def test_no_file_has_marks_of_a_conflict() -> None:
    mark = re.compile(rb"^(<{7}|>{7}|\|{7})( |$)|^={7}$", re.M)
    assert [path for path in KEPT if mark.search(path.read_bytes())] == []


def test_no_file_is_large() -> None:
    assert [path for path in KEPT if path.stat().st_size > LARGEST] == []


def test_every_room_is_in_the_table_of_rooms() -> None:
    table = read(ROOT / "docs" / "rooms.md")
    rooms = {place.name for place in (ROOT / "src" / "rankdrop").iterdir() if any(place.glob("*.py"))}
    assert {room for room in rooms if f"`{room}/`" not in table} == set()


def first_sentence(module: Path) -> str:
    """Of the docstring of a module, on one line, without its full stop."""
    text = " ".join((ast.get_docstring(ast.parse(read(module))) or "").split())
    return re.split(r"[.](?= |$)", text, maxsplit=1)[0]


def listed_modules(page: str) -> dict[str, dict[str, str]]:
    """Folder -> its modules -> their line: tables under a heading that names a folder, of a page."""
    tables = {}
    for section in page.split("\n## ")[1:]:
        named = re.search(r"`([\w/]+)/`$", section.splitlines()[0])
        if named:
            tables[named[1]] = dict(re.findall(r"(?m)^\| `(\w+\.py)` \| (.+) \|$", section))
    return tables


@pytest.mark.parametrize("folder", ["path/read", "path/mend"])
def test_every_module_of_a_large_room_is_listed_by_the_beginning_of_its_docstring(folder: str) -> None:
    listed = listed_modules(read(ROOT / "docs" / "rooms.md"))[folder]
    modules = [path for path in sorted((SOURCE / folder).glob("*.py")) if path.stem != "__init__"]
    sentences = {module.name: first_sentence(module) for module in modules}
    assert list(listed) == list(sentences)
    other = {
        name: sentence for name, sentence in sentences.items()
        if not sentence.startswith(listed[name]) or sentence.removeprefix(listed[name])[:1] not in ("", ":", ";", ",")
    }  # fmt: skip
    assert not other, "the docstrings begin otherwise"


def test_every_line_of_the_changelog_is_short() -> None:
    lines = [line for line in read(ROOT / "CHANGELOG.md").splitlines() if line.startswith("- ")]
    assert lines
    assert [line for line in lines if len(line.split()) > 26] == []  # 25 words and the dash


def words_of(text: str) -> str:
    return " ".join(re.findall(r"[a-z]+", text.lower()))


@pytest.fixture(scope="module")
def said() -> str:
    """Every word of the package's source, one after the other."""
    return f" {words_of(' '.join(map(read, [*FILES, *(ROOT / 'src' / 'core').glob('*.cpp')])))} "


def is_ours(pattern: str, said: str) -> bool:
    """Whether three words of a pattern in a row, or a whole part of it that is shorter, stand in the package."""
    parts = [part.split() for part in re.split(r"[^a-z ]+", re.sub(r"\\[a-zA-Z]", "|", pattern).lower())]
    runs = [part[i : i + 3] for part in parts for i in range(max(1, len(part) - 2)) if part]
    return not runs or any(f" {' '.join(run)} " in said for run in runs)


@pytest.mark.slow
def test_expected_messages_are_the_packages_own(said: str) -> None:
    foreign = [
        f"{file.relative_to(ROOT)}:{node.value.lineno}: {node.value.value}"
        for file in sorted(HERE.rglob("test_*.py")) for node in ast.walk(ast.parse(read(file)))
        if isinstance(node, ast.keyword) and node.arg == "match" and isinstance(node.value, ast.Constant)
        and not is_ours(str(node.value.value), said)
    ]  # fmt: skip
    assert foreign == []


def test_decisions_are_numbered_without_a_gap() -> None:
    pages = [path for path in KEPT if path.parent == ROOT / "docs" / "decisions"]
    numbers = [int(page.name[:4]) for page in pages]
    assert numbers == list(range(1, len(pages) + 1))


def test_every_package_of_the_plain_install_has_its_licence_in_the_docs() -> None:
    """What rankdrop asks for itself is listed; what is listed is what the checks install."""
    page = read(ROOT / "docs" / "packages.md")
    listed = re.findall(r"^\| ([a-z-]+) \| [^|]+ \| [^|]+ \|$", page, re.MULTILINE)[1:]
    asked = tomllib.loads(read(ROOT / "pyproject.toml"))["project"]["dependencies"]
    assert {re.split(r"[<>=]", line)[0] for line in asked} <= set(listed)
    installed = re.findall(r"^([\w.-]+)==", read(ROOT / ".ci" / "constraints.txt"), re.MULTILINE)
    assert set(listed) <= {name.lower().replace("_", "-") for name in installed}
    assert f"brings {len(listed)} packages" in page


def test_no_file_of_tests_imports_another() -> None:
    """What several share stands in a file of its own beside them."""
    imported = [
        (path.name, node.module)
        for path in KEPT
        if path.is_relative_to(HERE) and path.suffix == ".py"
        for node in ast.walk(ast.parse(read(path)))
        if isinstance(node, ast.ImportFrom) and "test_" in (node.module or "")
    ]
    assert imported == []


UNNAMED = 10
"""Modules that have no file of tests in the folder of their room whose name begins with theirs."""


def has_tests(module: Path) -> bool:
    """Whether `tests/ROOM` has test_MODULE.py or test_MODULE_….py; of a module outside the rooms, any folder."""
    room = module.relative_to(SOURCE).parts[0]
    folder = HERE if module.parent == SOURCE else HERE / room
    names = [file.stem for file in folder.rglob("test_*.py")]
    return any(f"{name}_".startswith(f"test_{module.stem}_") for name in names)


def test_tests_of_a_module_are_found_by_its_name() -> None:
    modules = [file for file in FILES if not file.stem.startswith("__")]
    unnamed = [str(module.relative_to(SOURCE)) for module in modules if not has_tests(module)]
    assert len(unnamed) <= UNNAMED, "\n".join(unnamed)
