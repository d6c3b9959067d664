"""Facts before words, and plain English: counts of what is left to mend, which only go down.

Sentences for users are made in `text/`, `cli/`, `report/`, `viewer/` and by errors. Whoever takes one out of another
room lowers its number here; nobody raises one.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from sources import FILES, ROOT, SOURCE, nodes, parsed

FACES = {"text", "cli", "report", "viewer", "errors", "schema", "options", "questions", "codec"}
"""Rooms in which sentences are made; the schema's are the meanings of entries, options' and questions' their help."""
FEWEST = 4  # words of a sentence
_REFUSALS = re.compile(r"Error$|^(refuse|refused|require|damaged|error|fail|wrong|warn|Unproven)$")


def room_of(path: Path) -> str:
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def words_of(node: ast.AST) -> str:
    """The text of a literal, what is put into it as x."""
    if isinstance(node, ast.JoinedStr):
        return "".join(str(one.value) if isinstance(one, ast.Constant) else "x" for one in node.values)
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def called(node: ast.Call) -> str:
    function = node.func
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def sentences(tree: ast.AST) -> Iterator[str]:
    """Texts of four words or more that are no docstring, no part of a refusal and no code."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue  # a docstring
        if isinstance(node, ast.Raise) or (isinstance(node, ast.Call) and _REFUSALS.search(called(node))):
            continue
        text = words_of(node)
        if text:
            words = re.findall(r"(?<![\w\\.,>-])[A-Za-zθσ]{2,}(?![\w(\\=>-])", text)
            if len(words) >= FEWEST and not re.search(r"[{}\\]|==", text):
                yield text
            continue
        yield from sentences(node)


SENTENCES = {
    "designs": 1, "distance": 1, "exact": 6, "families": 9, "formula": 3, "jobs": 5,
    "local": 3, "path": 1, "proof": 41, "results": 5, "robot": 23, "units": 2,
}  # fmt: skip
"""Room -> sentences in it today."""


@cache
def counted_sentences() -> Counter[str]:
    found: Counter[str] = Counter()
    for path in FILES:
        if room_of(path) not in FACES:
            found[room_of(path)] += sum(1 for _ in sentences(parsed(path)))
    return found


METHODS = {"split", "partition", "rpartition", "startswith", "endswith", "removeprefix", "removesuffix", "replace",
           "find"}  # fmt: skip


def cuts(tree: ast.AST) -> Iterator[str]:
    """Places that take a text apart: by re, by a method of str with a literal of two characters or more, by `in`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            pattern = isinstance(node.func.value, ast.Name) and node.func.value.id == "re"
            literal = node.args[0].value if node.args and isinstance(node.args[0], ast.Constant) else None
            told = isinstance(literal, str) and len(literal.strip("\n")) > 1 and literal != "utf-8"
            if pattern or (node.func.attr in METHODS and told):
                yield ast.unparse(node)
        if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.In | ast.NotIn):
            left, right = node.left, node.comparators[0]
            told = isinstance(left, ast.Constant) and isinstance(left.value, str) and len(left.value) > 2
            if told and isinstance(right, ast.Name | ast.Attribute | ast.Subscript):
                yield ast.unparse(node)


FOREIGN = {
    **dict.fromkeys(("cli/command.py", "cli/main.py", "cli/opening.py", "cli/targets.py", "cli/values.py",
                     "robot/joint_text.py"), "options as they were typed"),
    "cli/help.py": "docstrings for help", "cli/path.py": "keys", "cli/research.py": "names of files",
    "cli/view.py": "addresses of hosts",
    "codec.py": "messages of msgspec, docstrings, JSON", "options.py": "names of arguments",
    "designs/spec.py": "files of the user",
    "formula/reading.py": "conditions of the user", "distance/monitor.py": "names of arms, for C",
    **dict.fromkeys(("path/read/arrays.py", "path/read/matrices.py", "path/read/messages.py",
                     "path/read/named_poses.py", "path/read/poses.py", "path/read/written_poses.py"),
                    "files of the user"),
    **dict.fromkeys(("path/read/fanuc_tp.py", "path/read/inform.py", "path/read/krl.py", "path/read/krl_values.py",
                     "path/read/program_scan.py", "path/read/program_signs.py", "path/read/rapid.py",
                     "path/read/rapid_values.py", "path/read/urscript.py"), "programs of the user"),
    "path/read/csv_file.py": "files of the user", "path/read/pose_text.py": "poses as they were typed",
    "path/read/matrix_text.py": "matrices as they were pasted", "path/read/message_text.py": "messages of ROS",
    "proof/check.py": "keys", "proof/regions.py": "keys", "report/chart.py": "numbers",
    "results/analysis.py": "keys of files", "results/stored_conditions.py": "keys of files",
    **dict.fromkeys(("results/old_files.py", "results/old_sentences.py"), "files of versions up to 0.2"),
    "results/estimate.py": "files of the user",
    "robot/ideal.py": "tolerances of the user",
    **dict.fromkeys(("robot/dh_calls.py", "robot/dh_cells.py", "robot/dh_code.py", "robot/dh_columns.py",
                     "robot/dh_headed.py", "robot/dh_latex.py", "robot/dh_lists.py", "robot/dh_named.py",
                     "robot/dh_text.py", "robot/dh_units.py", "robot/dh_variable.py", "robot/dh_written.py"),
                    "tables as they were written"),
    **dict.fromkeys(("robot/drawing.py", "robot/files.py", "robot/formats.py", "robot/mesh_file.py",
                     "robot/mjcf.py", "robot/open.py", "robot/quantities.py", "robot/screws.py",
                     "robot/shapes.py", "robot/toml_file.py", "robot/tree.py", "robot/urdf.py", "robot/xacro.py"),
                    "files of the user"),
    "viewer/access.py": "HTTP headers",
}  # fmt: skip
"""Modules that take texts apart which are no sentences of the package, and whose or what these are."""
OWN = {
    "formula/mathml.py": 2, "formula/notation.py": 4, "formula/shortest.py": 1, "text/code.py": 6,
    "text/conditions.py": 2, "text/joint_values.py": 1, "text/latex.py": 2, "text/words.py": 3,
}  # fmt: skip
"""Module -> places that take a sentence or a name apart that the package itself made: to be fewer, never more."""


def test_only_texts_of_others_are_taken_apart() -> None:
    found = {path.relative_to(SOURCE).as_posix(): list(cuts(parsed(path))) for path in FILES}
    more = {name: places for name, places in found.items() if name not in FOREIGN and len(places) > OWN.get(name, 0)}
    assert not more, f"{more}: no code parses a text that the package made; texts of others are listed in FOREIGN"
    fewer = {name: len(found[name]) for name, most in OWN.items() if len(found[name]) < most}
    assert not fewer, f"lower the numbers in OWN to {fewer}: they only go down"


def test_nothing_is_listed_that_takes_no_text_apart() -> None:
    idle = [name for name in FOREIGN if not any(cuts(parsed(SOURCE / name)))]
    assert not idle, f"take {idle} out of FOREIGN"


@pytest.mark.parametrize(
    "line",
    ['words.partition(", ")', 'text.startswith("nearly")', '"witness" in words', 're.sub("a", "b", told)',
     'lost.removeprefix("cannot ")', 'one.replace("the lost direction", which)', 'reason.split("; ")'],
)  # fmt: skip
def test_a_place_that_takes_a_sentence_apart_is_found(line: str) -> None:
    assert len(list(cuts(ast.parse(line)))) == 1


@pytest.mark.parametrize("line", ['name in known', r'text.split("\n")', '"x" in axes', 'path.replace("/", ".")'])
def test_a_place_that_takes_no_sentence_apart_is_left_out(line: str) -> None:
    assert not list(cuts(ast.parse(line)))


PHRASES = {
    r"\b(?:is|are|was|were|be|been) told\b": 58,
    r"\btells\b": 19,
    r"\b(?:held|hold|holds) against\b": 12,
    r"\blook(?:ed|s|ing)? into\b": 8,
    r"\blook(?:ed|s|ing)? through\b": 0,
    r"\blooked at\b": 36,
    r"\btaken as\b": 10,
    r"\bas it is meant\b": 1,
    r"\bbeside\b": 40,
    r"\bwhose own\b": 1,
    r"\bgoes on there\b": 5,
    r"\bhand(?:s|ed)? over\b": 3,
    r"\basked about\b": 13,
    r"\bis there twice\b": 1,
    r"\bparts the\b": 1,
    r"\bno other one\b": 9,
    r"\babsence of a find\b": 0,
    r"\bderived apart\b": 1,
    r"\bin whose axes\b": 2,
    r"\bthere is no place\b": 0,
    r"\bmet\b": 52,
    r"\bfresh (?:singular )?points?\b": 12,
    r"\btold\b": 68,
    r"\bwhose\b": 182,
    r"\bwhat (?:is|are)\b": 259,
}
"""Phrase of the old dialect, as a pattern -> how often docstrings may contain it: to be fewer, never more."""
NAMES = re.compile(
    r"What is (?:nearly )?lost"  # heading of `explain`, and references to it
    r"|\.met\b|`met(?:\[\])?`"  # `Explanation.met` and the entries `met` of the JSON
)
"""Texts of pages and output in which a phrase is a name that stays."""
LEFT: dict[str, int] = {}
"""Module -> phrases left in its output: to be fewer, never more."""


@cache
def pages() -> dict[str, str]:
    """Page -> its text, but for pages that a build of the site makes from other texts."""
    made = {ROOT / "docs" / folder for folder in ("atlas", "commands", "gallery")}
    found = [path for path in (ROOT / "docs").rglob("*.md") if path.name != "reproduced.md"]
    found = [path for path in found if not made & set(path.parents)]
    found += [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")]
    return {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in found}


def is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


@cache
def literals() -> tuple[dict[str, str], str]:
    """Module -> its texts of two words or more (single words are keys); all docstrings but those of cli/, the help."""
    output: dict[str, str] = {}
    docstrings: list[str] = []
    for path in FILES:
        help_too = room_of(path) == "cli"
        own = {id(node.value) for node in nodes(path) if is_docstring(node) and not help_too}
        texts = [node for node in nodes(path) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
        said = [node.value for node in texts if id(node) not in own]
        output[path.relative_to(SOURCE).as_posix()] = "\n".join(text for text in said if " " in text.strip())
        docstrings += [node.value for node in texts if id(node) in own]
    return output, "\n".join(docstrings)


def phrases(text: str, pattern: str) -> list[str]:
    """The phrase in the text, with the words around it; line breaks and names do not count."""
    plain = NAMES.sub("", " ".join(text.split()))
    return [plain[max(0, one.start() - 40) : one.end() + 40] for one in re.finditer(pattern, plain, re.IGNORECASE)]


@pytest.mark.parametrize("room", sorted({room_of(path) for path in FILES} - FACES))
def test_a_room_makes_no_more_sentences_than_before(room: str) -> None:
    assert counted_sentences()[room] <= SENTENCES.get(room, 0), "sentences are made in text/, from facts"


def test_a_sentence_is_recognised() -> None:
    """The law sees sentences in returns, tuples and f-strings, and leaves out docstrings, errors and code."""
    tree = ast.parse(
        '''
def f(x):
    """The tool is at an edge of its reach."""
    if x:
        raise OptionError("there is no such joint here", got=x)
    y = damaged("the witness has another corank here", "$.families")
    require(x > 0, "the value is not above zero here", "$.families")
    z = np.einsum("pab,ca,cb->cp", x, x, x)
    return "the tool is at an edge", (f"of {x} starts {x} have converged",), "elbow", "rankdrop.designs.measure:arms"
'''
    )
    assert list(sentences(tree)) == ["the tool is at an edge", "of x starts x have converged"]


PLAIN = "see CONTRIBUTING.md on plain English: the field's verbs, and the noun in place"


@pytest.mark.parametrize("phrase", PHRASES)
def test_pages_and_output_contain_no_phrase_of_the_old_dialect(phrase: str) -> None:
    found = {name: phrases(text, phrase) for name, text in (pages() | literals()[0]).items()}
    assert not {name: places for name, places in found.items() if len(places) > LEFT.get(name, 0)}, PLAIN


def test_no_module_is_listed_that_is_free_of_phrases() -> None:
    everything = "|".join(PHRASES)
    fewer = {name: len(phrases(literals()[0][name], everything)) for name in LEFT}
    assert fewer == LEFT, "lower the numbers in LEFT: they only go down"


@pytest.mark.parametrize("phrase", PHRASES)
def test_a_phrase_of_the_old_dialect_gets_rarer_in_docstrings(phrase: str) -> None:
    assert len(phrases(literals()[1], phrase)) <= PHRASES[phrase], PLAIN


@pytest.mark.parametrize(
    ("text", "places"),
    [("the limit on work was\nmet", 1), ("What is lost", 0), ("`found.met`, `met[]`", 0), ("the axes meet", 0),
     ("What is lost: what is left", 1)],
)  # fmt: skip
def test_a_phrase_is_found_across_lines_and_no_name_is(text: str, places: int) -> None:
    assert sum(len(phrases(text, phrase)) for phrase in PHRASES) == places


TYPED = re.compile(r"(?<![\w-])--[a-z]")
NAMES_OPTIONS = {"families/reciprocal.py": 1, "robot/ideal.py": 1}
"""Module -> texts with an option of the command line in them: arguments of others, and notes in files. To be fewer."""
OWN_ROOMS = (
    "algebra", "aspects", "cover", "designs", "distance", "exact", "families", "formula", "local", "path", "poses",
    "results", "robot", "text", "verbs",
)  # fmt: skip


def typed_options(tree: ast.AST) -> Iterator[str]:
    """Texts that name an option as it is typed, but for docstrings and the `typed` mend of an error."""
    for node in ast.iter_child_nodes(tree):
        docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if docstring or (isinstance(node, ast.keyword) and node.arg == "typed"):
            continue
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and TYPED.search(node.value):
            yield node.value
        yield from typed_options(node)


@pytest.mark.parametrize("room", OWN_ROOMS)
def test_only_the_command_line_says_what_is_typed(room: str) -> None:
    """In Python "--full" is full=True: `rankdrop.options.advised` writes either."""
    for path in FILES:
        if room_of(path) == room:
            name = path.relative_to(SOURCE).as_posix()
            found = list(typed_options(parsed(path)))
            assert len(found) <= NAMES_OPTIONS.get(name, 0), f"{name}: {found}"


def test_an_option_in_a_sentence_is_found() -> None:
    tree = ast.parse(
        """
def f():
    '''See --full.'''
    g(typed="--tip t", mend="tip")
    return f"all: --full {f}"
"""
    )
    assert list(typed_options(tree)) == ["all: --full "]
