"""Where a text has the rows of a Denavit–Hartenberg table: calls, a heading, names in each row, lists, numbered names.

- Calls of toolboxes: `Link([theta d a alpha])`, `Link('d', 0.1, 'a', 0, 'alpha', pi/2)`, `RevoluteMDH(d=0.1, a=0)`.
- A table with a heading that names its columns, as it is printed, in CSV, Markdown, or as a comment above an array.
- Names in each row: `{'a': 0, 'd': 0.1, 'alpha': pi/2}`, `dict(a=0, d=0.1, alpha=pi/2)`.
- A list for each parameter: `a = [0, -0.425, …]`, `d = […]`, `alpha = […]`.
- Numbered names: `a1 = 0.4`, `alpha1 = -pi/2`, or `{alpha0: 0, a0: 0, d1: 0.75, …}`.

The entries stay texts; `dh_text` makes an arm of them.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain

from rankdrop.errors import RobotError
from rankdrop.robot.dh_latex import plain_latex, rows_of_line

KEYS = ("a", "alpha", "d", "theta", "offset", "lower", "upper")
_LABEL = "label"  # the key of a first column that is none of these
_LONGEST_HEADING = 400  # characters
_LONGEST_CALL = 600  # characters of the arguments of one call
_GREEK = str.maketrans({"α": "alpha", "⍺": "alpha", "𝛼": "alpha", "θ": "theta", "ϑ": "theta", "𝜃": "theta", "π": "pi",
                        "−": "-", "–": "-",
                        "∘": "°", "º": "°", "˚": "°"})  # fmt: skip

# Calls of toolboxes

_COMMENT = re.compile(r"[%#].*|//.*")
_GOES_ON = re.compile(r"\.\.\.\s*$")
_CALL = re.compile(r"\b(?:(?P<kind>Revolute|Prismatic)(?P<modified>M?)(?:DH)?|(?P<link>Link|link|DHLink))\s*\(")
_ASSIGNED = re.compile(
    r"(?:^|[;,{(&|:]|\b(?:and|where|with)\b)\s*(?:(?:double|float|const|self\.)\s*)*(?P<name>[A-Za-z_]\w{0,40})\s*=\s*"
    r"(?P<value>(?:(?!\s(?:and|where|with)\s)[^=;,#%\n]){1,80})"
)
_END_OF_SENTENCE = re.compile(r"(?<=\d)\.$")
_TARGET = re.compile(r"(?P<name>[\w.]{1,40}(?:[({\[]\d{1,3}[)}\]])?)\s*=\s*(?:\w{1,20}\.)?$")
_LATER = re.compile(
    r"(?P<name>[\w.]{1,40}(?:[({\[]\d{1,3}[)}\]])?)\.(?P<key>offset|qlim)\s*=\s*(?P<value>[^;\n]{1,120})"
)
_WORD = re.compile(r"""^["']?(?P<key>[A-Za-z_]+)["']?\s*=?\s*""")
_TEXT = re.compile(r"""^["'](?P<text>\w+)["']$""")
_NUMBER = re.compile(r"[-+.(\d]|(?:\w{1,20}\.)?pi\b")
_FLAGS = frozenset(("modified", "standard", "revolute", "prismatic", "sym"))
"""Quoted words of a call that no value follows."""
_VECTORS = {"Link": ("theta", "d", "a", "alpha", "sigma", "offset"), "link": ("alpha", "a", "theta", "d", "sigma")}
"""Order of the numbers of one bracket; `link` is that of older versions."""

_PAIR = re.compile(r"\[\s*(?P<lower>[^,\s\]]+(?:\([^)]*\))?)\s*[,\s]\s*(?P<upper>[^\]]+?)\s*\](?P<factor>\s*\*.*)?")
_CONVERTED = re.compile(r"^(?:\w{1,20}\.)?(?:deg2rad|radians|d2r)\((?P<pair>.*)\)$")

# A table with a heading

_UNIT = re.compile(r"[(\[{]\s*(?P<unit>mm|cm|m|deg(?:rees?)?|°|rad(?:ians?)?)\s*(?:[)\]}]|$)", re.IGNORECASE)
_BEFORE_UNIT = re.compile(r"(?<=\w)[ \t]+(?=[(\[](?:mm|cm|m|deg|°|rad)[)\]])", re.IGNORECASE)
_HEADS = (
    ("alpha", re.compile(r"(?:link\s?)?(?:alpha|twist)(?:\s?angle)?")),
    ("offset", re.compile(r"(?:theta)?(?:off(?:set)?|0)")),
    ("theta", re.compile(r"theta|q|joint\s?angle|angle")),
    ("a", re.compile(r"a|link\s?length|length")),
    ("d", re.compile(r"d|r|link\s?offset|joint\s?distance")),
    ("lower", re.compile(r"q-|q\(?min\)?|min|lower(?:\s?limit)?")),
    ("upper", re.compile(r"q\+|q\(?max\)?|max|upper(?:\s?limit)?")),
)
_TWIST = re.compile(r"alpha|twist", re.IGNORECASE)
_BEFORE = re.compile(r"\(?[ijnk]?-1\)?$")
_INDEX = re.compile(r"[_{}( ]*[ijnk]?[})]?$")
_FRAME = re.compile(r"[+\-=─━═╋┼┳┻┏┓┗┛┣┫┌┐└┘├┤┬┴|┃│\s:]+|```\w*")
_BARS = str.maketrans("┃│║&", "||||")
_CLOSED = re.compile(r"\s*[└┗╚╰]")
_RULE = re.compile(r"\s*\+[-=+]+\+\s*")
_AROUND = re.compile(r"^[^|,;\t\d]*?=\s*[\w.]*\(?\s*(?=\[)")

_SPLITS = tuple(map(re.compile, (r"\|", r";", r",", r"\t+", r"\s{2,}", r"\s+")))
_DECIMAL_COMMA = re.compile(r"^(-?\d+),(\d+)$")

_VARIABLE = re.compile(
    r"(?:\b(?:q|theta|th|t)_?\{?\d{0,2}\}?(?:\[\d{1,2}\]?)?(?:\(t\))?\*?|\bd_?\{?\d{0,2}\}?\*|\*)(?!\w)",
    re.IGNORECASE,
)
_DISTANCE = re.compile(r"(?:^|.*\+)\s*(?P<name>[dD]_?\d{1,2})\s*(?:[-+].*)?")
_NO_JOINT = re.compile(r"\b(?:tool|tcp|ee|end|tip|flange|gripper|hand|interface|fixed)\b", re.IGNORECASE)
_SLIDE = re.compile(r"^q_?\{?\d{0,2}\}?\*?$|\*$|^d_?\{?\d{0,2}\}?\*$")

# Names in each row, lists and numbered names

_NAMED_ROW = re.compile(r"\{(?P<items>[^{}]*)\}|\bdict\(")
_NAMED_ENTRY = re.compile(
    r"(?<!\w)[\"']?(?P<key>alpha|theta|offset|lower|upper|a|d)[\"']?\s*[:=]\s*[\"']?(?P<value>[^,:={}\"'\n]+)"
)
_NAMED_KIND = re.compile(
    r"(?<!\w)[\"']?(?:(?:joint_?)?(?:type|kind)|sigma|prismatic)[\"']?\s*[:=](?P<value>[^,]*)", re.IGNORECASE
)
_TURNING = frozenset(("r", "revolute", "rotary", "rotational", "0", "false"))

_LIST = re.compile(
    r"(?:^|[\s.;,{\"'])(?P<name>[A-Za-z]\w{0,30})[\"']?\s*[=:]\s*[\w.]*\(?\s*[\[{](?P<items>[^\[\]{}]{1,2000})[\]}]"
)
_NAMED_LIST = re.compile(
    r"(?:(?P<before>\w{1,20}?)_|dh)??(?P<key>theta_offset|alpha|theta|offset|a|d)s?(?:_(?P<after>\w{1,20}))?"
)
_NUMBERED = re.compile(
    r"(?<!\w)(?P<key>alpha|a|d|q|theta|th|offset)_?(?P<number>\d{1,2})\s*[=:]\s*(?P<value>[^=;,:#%\n{}]{1,60})"
)


@dataclass(frozen=True)
class WrittenRow:
    """One row: its entries as they are written, by `KEYS`, and the line of the text.

    Attributes:
        slides: its d is the joint variable.
        varies: an entry names the joint variable; None where the form does not write it.
        variable: that name; "" where there is none.
        label: the cell in front of the entries: the number or the name of the link.
        assumed: the variable is a name that may be a length too: d2, without a number.
    """

    entries: Mapping[str, str]
    line: int
    slides: bool = False
    varies: bool | None = None
    variable: str = ""
    label: str = ""
    assumed: bool = False


@dataclass(frozen=True)
class WrittenTable:
    """The rows that were found, and what their form says of them.

    Attributes:
        rows: base to tip.
        convention: "standard" or "modified"; "" where the form does not say.
        units: of the columns, by `KEYS`, where the heading states them.
        radians: the form has angles in radians, whatever their size.
        constants: names with the expressions that the text gives them.
    """

    rows: tuple[WrittenRow, ...]
    convention: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    radians: bool = False
    constants: Mapping[str, str] = field(default_factory=dict)


def table_in(text: str, file: str) -> WrittenTable | None:
    """The table that a text has; None where it has none.

    Raises:
        RobotError: two arms, or a row that does not fit.
    """
    lines = plain_latex(text.translate(_GREEK)).replace("$", "").splitlines()
    rows = _of_calls(lines, file) or _of_heading(lines) or _of_named_rows(lines, file)
    return rows or _of_lists(lines, file) or _of_numbers(lines)


def is_table(text: str) -> bool:
    """Whether a text has a table."""
    try:
        return table_in(text, "") is not None
    except RobotError:
        return True  # its reader says why it cannot be read


def _of_calls(lines: list[str], file: str) -> WrittenTable | None:
    code = _code_of(lines)
    calls = [call for call in _calls_in(code, file) if call.entries or call.stray or call.empty]
    if not any(call.entries for call in calls):
        return None
    _refuse_strays(calls, file)
    _refuse_two_arms(calls, file)
    bare = code.splitlines()
    settings = chain.from_iterable(map(_LATER.finditer, bare))
    later = {(found["name"], found["key"]): found["value"] for found in settings}
    rows = tuple(_row_of(call, later) for call in calls)
    conventions = {call.convention for call in calls}
    if len(conventions) > 1:
        raise RobotError("the links are of both conventions", where=file, allowed="all standard, or all modified")
    return WrittenTable(rows, conventions.pop(), radians=True, constants=_constants(bare))


@dataclass(frozen=True)
class _Call:
    """One call: the name that it is assigned to, its arguments by key.

    Attributes:
        stray: a number without a key; "" where there is none.
        empty: it has no argument, and is a row all the same: RevoluteDH().
    """

    name: str
    entries: Mapping[str, str]
    line: int
    convention: str
    slides: bool
    stray: str
    empty: bool


def _code_of(lines: list[str]) -> str:
    """Lines as one text, without comments and MATLAB's signs that a statement goes on."""
    return "\n".join(_GOES_ON.sub("", _COMMENT.sub("", line)) for line in lines)


def _calls_in(code: str, file: str) -> Iterator[_Call]:
    """The calls in a text, each on one line or over several."""
    end, number, counted = 0, 1, 0
    while found := _CALL.search(code, end):
        number += code.count("\n", counted, found.start())
        counted = found.start()
        arguments, end, closed = _arguments(code, found.end())
        targets = _TARGET.findall(code[max(0, found.start() - 60) : found.start()])
        call = _call_of(found, arguments, "".join(targets), number)
        if call.entries and not closed:
            raise _without_end(found[0], f"{file}, line {number}")
        yield call


def _without_end(call: str, where: str) -> RobotError:
    return RobotError("a call has no end", where=where, got=call,
                      allowed=f"a closing bracket within {_LONGEST_CALL} characters")  # fmt: skip


def _refuse_strays(calls: list[_Call], file: str) -> None:
    """Refuse a number without the name of its parameter: its place says it in no toolbox alike."""
    for call in calls:
        if call.stray:
            raise RobotError("an argument has no name", where=f"{file}, line {call.line}", got=call.stray,
                             allowed="d=0.1, 'd', 0.1, or one bracket of numbers first")  # fmt: skip


def _call_of(found: re.Match[str], arguments: list[str], name: str, line: int) -> _Call:
    flags = {text["text"].lower() for word in arguments if (text := _TEXT.match(word))}
    entries, stray = _entries_of(arguments, _VECTORS.get(found["link"] or "Link", _VECTORS["Link"]))
    empty = bool(found["kind"]) and arguments == [""]
    without_d = bool(found["link"]) and "theta" in entries and "d" not in entries
    slides = [found["kind"] == "Prismatic", "prismatic" in flags, entries.get("sigma") == "1", without_d]
    modified = [bool(found["modified"]), "modified" in flags, entries.get("mdh") in ("1", "True", "true")]
    convention = ("standard", "modified")[any(modified)]
    return _Call(name, entries, line, convention, any(slides), stray, empty)


def _entries_of(arguments: list[str], order: tuple[str, ...]) -> tuple[dict[str, str], str]:
    """Arguments by key: 'd', 0.1 and d=0.1, and the numbers of one bracket; and the first number without a key."""
    entries: dict[str, str] = {}
    strays: list[str] = []
    waiting = ""
    for word in arguments:
        quoted = _TEXT.match(word)
        named = _WORD.match(word)
        if waiting:
            entries[waiting], waiting = word, ""
        elif quoted is not None:
            if quoted["text"].lower() not in _FLAGS:
                waiting = quoted["text"]
        elif named is not None and "=" in named[0]:
            entries[named["key"]] = word[named.end() :].strip()
        elif word.startswith("[") and not entries:
            entries |= dict(zip(order, re.split(r"\s*,\s*|\s+", word.strip("[] ")), strict=False))
        elif _NUMBER.match(word):
            strays.append(word)
    return entries, "".join(strays[:1])


def _arguments(code: str, at: int) -> tuple[list[str], int, bool]:
    """The arguments of a call that begins at a place, split at the commas outside brackets; where they end, and
    whether there is a closing bracket.
    """
    words: list[str] = []
    depth, word, end = 0, "", at
    for letter in code[at : at + _LONGEST_CALL]:
        end += 1
        if letter == ")" and depth == 0:
            return [*words, word.strip()], end, True
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            words.append(word.strip())
            word = ""
        else:
            word += letter
    return [*words, word.strip()], end, False


def _refuse_two_arms(calls: list[_Call], file: str) -> None:
    lines: dict[str, int] = {}
    for call in calls:
        if call.name and call.name in lines:
            raise RobotError("the file has two arms", where=f"{file}, line {call.line}",
                             got=f"{call.name} again, first in line {lines[call.name]}",
                             mend="keep the rows of one arm")  # fmt: skip
        lines[call.name] = call.line


def _row_of(call: _Call, later: Mapping[tuple[str, str], str]) -> WrittenRow:
    entries = {key: call.entries[key] for key in ("a", "alpha", "d", "theta") if key in call.entries}
    if call.slides:
        entries.pop("d", None)  # the variable
    else:
        entries.pop("theta", None)
    offset = later.get((call.name, "offset"), call.entries.get("offset", "0"))
    limits = later.get((call.name, "qlim"), call.entries.get("qlim", ""))
    return WrittenRow(entries | {"offset": offset} | _limits(limits), call.line, call.slides)


def _limits(text: str) -> dict[str, str]:
    """lower and upper of `[-pi, pi]`, `[-165 165]*deg` or `deg2rad([-360 360])`; empty for anything else."""
    converted = _CONVERTED.match(text.strip())
    inside, scale = text.strip(), ""
    if converted is not None:
        inside, scale = converted["pair"], "*pi/180"
    pair = _PAIR.match(inside)
    if pair is None:
        return {}
    factor = pair["factor"] or scale
    return {key: f"({pair[key]}){factor}" for key in ("lower", "upper")}


def _constants(lines: list[str]) -> dict[str, str]:
    """Names with their expressions; of two different expressions both, with a bar between."""
    constants: dict[str, str] = {}
    for line in lines:
        for found in _ASSIGNED.finditer(line):
            value = _END_OF_SENTENCE.sub("", found["value"].strip())
            before = constants.get(found["name"])
            if before not in (None, value):
                value = f"{before} | {value}"
            constants[found["name"]] = value
    return constants


def _of_heading(lines: list[str]) -> WrittenTable | None:
    by_line = list(map(rows_of_line, lines))
    pieces = list(chain.from_iterable(by_line))
    numbers = [number for number, rows in enumerate(by_line, 1) for _ in rows]
    constants = _constants(lines)
    for place, piece in enumerate(pieces):
        heads = _heads(piece)
        if heads is None:
            continue
        keys = (heads.keys[0] or _LABEL, *heads.keys[1:])
        below = _rows_below(pieces, place + 1, keys, constants)
        rows = tuple(replace(row, line=numbers[row.line - 1]) for row in below)
        if rows:
            return WrittenTable(rows, heads.convention, heads.units, constants=constants)
    return None


@dataclass(frozen=True)
class _Heads:
    """What a heading says: the key of each column ("" for others), units by key, the convention."""

    keys: tuple[str, ...]
    units: Mapping[str, str]
    convention: str


def _heads(line: str) -> _Heads | None:
    """The heading in a line; None where it names no a, alpha and d."""
    if len(line) > _LONGEST_HEADING or _TWIST.search(line) is None:
        return None
    cells = _cells(_BEFORE_UNIT.sub("", _AROUND.sub("", line.lstrip("#%/* "))), None)
    read = [_head(cell) for cell in cells]
    keys = [key for key, _, _ in read]
    if _named_r(cells) and "a" not in keys:
        keys = list(map(_khalil, cells, keys))
    if not {"a", "alpha", "d"} <= set(keys) or max(map(keys.count, KEYS)) > 1:
        return None
    return _heads_of(cells, keys, read)


def _heads_of(cells: list[str], keys: list[str], read: list[tuple[str, str, bool]]) -> _Heads:
    units = {key: unit for key, (_, unit, _) in zip(keys, read, strict=True) if key and unit}
    convention = ""
    if any(before for _, _, before in read) or _named_r(cells):
        convention = "modified"
    return _Heads(tuple(keys), units, convention)


def _named_r(cells: list[str]) -> bool:
    """Whether a column is called r, as in tables with the lengths d and r."""
    return any(re.fullmatch(r"r[_{]?[ijnk]?}?", cell.strip().lower()) for cell in cells)


def _khalil(cell: str, key: str) -> str:
    """Of a table with d and r, d is the length that others call a, and r their d."""
    if key == "d" and not cell.strip().lower().startswith("r"):
        return "a"
    return key


def _head(cell: str) -> tuple[str, str, bool]:
    """The key of one heading, its unit, and whether it counts the link before."""
    unit = _UNIT.search(cell)
    name = unicodedata.normalize("NFKD", _UNIT.sub("", cell)).translate(_GREEK).lower()
    name = name.replace("−", "-").replace("\\", "").replace("$", "").replace("*", "").strip(" _'\"`")
    name = re.sub(r"\s+", " ", name)
    shorter = _BEFORE.sub("", name.strip("{}")).rstrip("_{( ")
    before = shorter != name.strip("{}") and not name.startswith("q")
    if not before:
        shorter = name
    for candidate in (shorter, _INDEX.sub("", shorter)):
        for key, pattern in _HEADS:
            if pattern.fullmatch(candidate):
                return key, _unit_of(unit), before
    return "", "", False


def _unit_of(found: re.Match[str] | None) -> str:
    if found is None:
        return ""
    word = found["unit"].lower()[:3]
    return {"°": "deg"}.get(word, word)


def _rows_below(
    lines: list[str], at: int, keys: tuple[str, ...], constants: Mapping[str, str]
) -> Iterator[WrittenRow]:
    begun = False
    for number in range(at, len(lines)):
        if begun and _ends_table(lines, number):
            return
        line = _AROUND.sub("", lines[number])
        if _FRAME.fullmatch(line) or not line.strip():
            continue
        cells = _cells_of_row(line, len(keys))
        if cells:
            begun = True
            yield _row_of_cells(dict(zip(keys, cells, strict=True)), number + 1, constants)
        elif begun or _heads(lines[number]) is not None:
            return


def _cells_of_row(line: str, count: int) -> list[str]:
    """The cells of a row, as many as the heading has; empty where the line is no row."""
    cells = _cells(line, count)
    if len(cells) == count and re.search(r"\d", line) and "=" not in line:
        return cells
    return []


def _ends_table(lines: list[str], number: int) -> bool:
    """Whether a line closes the frame of a table; the printout may go on with a table of configurations."""
    if _CLOSED.match(lines[number]):
        return True
    return not lines[number].strip() and _RULE.fullmatch(lines[number - 1]) is not None


def _cells(line: str, count: int | None) -> list[str]:
    """The cells of a line, by the first separator that makes as many as are wanted; None: at least three.

    Where bars stand between cells, nothing else separates them.
    """
    body = re.sub(r"\\\\\s*$", "", _row_without_comment(line)).translate(_BARS).strip()
    around = "| \t"
    if count is None or "|" not in body:
        around = "|[](){} \t,;"
    body = body.strip(around)
    for split in _splits(body):
        cells = [cell.strip(" []{}") for cell in split.split(body)]
        if split.pattern == ";":
            cells = [_DECIMAL_COMMA.sub(r"\1.\2", cell) for cell in cells]
        if len(cells) == count or (count is None and len(cells) >= 3):
            return cells
    return []


def _splits(body: str) -> tuple[re.Pattern[str], ...]:
    """The separators that the cells of a row may have."""
    if "|" in body:
        return _SPLITS[:1]
    return _SPLITS


def _row_without_comment(line: str) -> str:
    """A row without a comment behind it and the brackets around it."""
    bare = re.split(r"\s[#%]|//", line, maxsplit=1)[0]
    if re.search(r"[\[{]", bare):
        return bare.strip("[]{}(),; \t")
    return bare


def _row_of_cells(cells: Mapping[str, str], line: int, constants: Mapping[str, str]) -> WrittenRow:
    entries = {key: cell for key, cell in cells.items() if key in KEYS}
    label = cells.get(_LABEL, "")
    variable = _VARIABLE.search(entries.get("theta", "q"))
    distance = entries.get("d", "")
    slides = bool(_SLIDE.search(distance.lower()))
    if slides:
        variable = _VARIABLE.search(distance)
    for key in ("theta", "d"):
        if key in entries:
            entries[key] = _constant_part(entries[key])
    if variable is not None:
        return WrittenRow(entries, line, slides, True, variable[0], label)
    name = _name_of_slide(distance, constants, label)
    if name:
        entries["d"] = distance.replace(name, "0", 1)
    return WrittenRow(entries, line, bool(name), bool(name), name, label, assumed=bool(name))


def _name_of_slide(distance: str, constants: Mapping[str, str], label: str) -> str:
    """The name in the column d of a row with a constant theta that no number is given for: its joint slides.

    "" where there is none, and in the row of a tool.
    """
    found = _DISTANCE.fullmatch(distance.strip())
    if found is None or found["name"] in constants or _NO_JOINT.search(label):
        return ""
    return found["name"]


def _constant_part(cell: str) -> str:
    """The part of a cell that is added to the joint variable: "- 90°" of "q2 - 90°"; all of it where it has none."""
    rest = _VARIABLE.sub("", cell, count=1).strip().rstrip("+").strip()
    return rest or "0"


def _of_named_rows(lines: list[str], file: str) -> WrittenTable | None:
    code = _code_of(lines)
    constants = _constants(code.splitlines())
    rows: list[WrittenRow] = []
    short: list[int] = []  # lines of rows without a, alpha or d
    lists = 1
    for row in _named_rows_in(code, file):
        lists += bool(rows) and row.in_another_list
        cells = {item["key"]: item["value"].strip() for item in _NAMED_ENTRY.finditer(row.items)}
        if cells.keys() >= {"a", "alpha", "d"}:
            _refuse_slide(row, file)
            rows.append(_row_of_cells(cells, row.line, constants))
        elif "alpha" in cells:
            short.append(row.line)
    if len(rows) < 2:
        return None
    _refuse_doubtful_rows(short, lists, file)
    return WrittenTable(tuple(rows), constants=constants)


@dataclass(frozen=True)
class _NamedRow:
    """What stands between the brackets of a row, its line, and whether a list ends between it and the row before."""

    items: str
    line: int
    in_another_list: bool


def _named_rows_in(code: str, file: str) -> Iterator[_NamedRow]:
    end, number, counted = 0, 1, 0
    while found := _NAMED_ROW.search(code, end):
        number += code.count("\n", counted, found.start())
        counted = found.start()
        in_another_list = "]" in code[end : found.start()]
        items, end, closed = found["items"], found.end(), True
        if items is None:
            arguments, end, closed = _arguments(code, found.end())
            items = ",".join(arguments)
        if not closed and _TWIST.search(items):
            raise _without_end(found[0], f"{file}, line {number}")
        yield _NamedRow(items, number, in_another_list)


def _refuse_slide(row: _NamedRow, file: str) -> None:
    """Refuse a row that says of its joint anything but that it turns: what its d then means is not known."""
    kind = _NAMED_KIND.search(row.items)
    if kind is not None and kind["value"].strip("\"' ").lower() not in _TURNING:
        raise RobotError("the row may be that of a slide", where=f"{file}, line {row.line}", got=kind[0].strip(),
                         mend="write a table with a heading, and q for the variable in its column d")  # fmt: skip


def _refuse_doubtful_rows(short: list[int], lists: int, file: str) -> None:
    """Refuse rows without one of a, alpha and d, and rows in several lists."""
    if short:
        raise RobotError("the row has not each of a, alpha and d", where=f"{file}, line {short[0]}",
                         mend="write all three, 0 for none")  # fmt: skip
    if lists > 1:
        raise _two_arms(file, f"rows in {lists} lists")


def _of_lists(lines: list[str], file: str) -> WrittenTable | None:
    code = _code_of(lines)
    arms: dict[tuple[str | None, str | None], dict[str, list[str]]] = {}
    for found in _LIST.finditer(code):
        name = _NAMED_LIST.fullmatch(found["name"].lower())
        if name is not None:
            lists = arms.setdefault((name["before"], name["after"]), {})
            key = name["key"].replace("theta_", "")
            items = [item for item in re.split(r"\s*[,;]\s*|\s+", found["items"].strip(" \t\r\n,;")) if item]
            if lists.setdefault(key, items) != items:
                raise _two_arms(file, f"{found['name']} again")
    whole = [lists for lists in arms.values() if _is_whole(lists)]
    if not whole:
        return None
    if len(whole) > 1:
        raise _two_arms(file, f"{len(whole)} lists of alpha")
    lists = whole[0]
    entries = zip(*lists.values(), strict=True)
    rows = tuple(WrittenRow(dict(zip(lists, values, strict=True)), 1) for values in entries)
    return WrittenTable(rows, constants=_constants(code.splitlines()))


def _is_whole(lists: Mapping[str, list[str]]) -> bool:
    """Whether there are all parameters, each for every joint."""
    return lists.keys() >= {"a", "alpha", "d"} and len(set(map(len, lists.values()))) == 1


def _two_arms(file: str, got: str) -> RobotError:
    return RobotError("the file has two arms", where=file, got=got, mend="keep the rows of one arm")


def _of_numbers(lines: list[str]) -> WrittenTable | None:
    found: dict[str, dict[int, tuple[str, int]]] = {}
    for number, line in enumerate(lines, 1):
        for item in _NUMBERED.finditer(_COMMENT.sub("", line)):
            key = {"q": "theta", "th": "theta"}.get(item["key"], item["key"])
            found.setdefault(key, {})[int(item["number"])] = (item["value"].strip().rstrip(")}]"), number)
    if not found.keys() >= {"a", "alpha", "d"}:
        return None
    before = min(found["alpha"]) == 0 and min(found["d"]) == 1
    rows = tuple(_numbered_row(found, number, int(before)) for number in sorted(found["d"]))
    if len(rows) < 2:
        return None
    return WrittenTable(rows, ("", "modified")[before], constants=_constants(lines))


def _numbered_row(found: Mapping[str, Mapping[int, tuple[str, int]]], number: int, before: int) -> WrittenRow:
    at = {"a": number - before, "alpha": number - before, "d": number, "theta": number, "offset": number}
    entries = {key: found[key][place][0] for key, place in at.items() if place in found.get(key, {})}
    varies = None
    if "theta" in entries:
        varies = bool(_VARIABLE.search(entries["theta"]))
        entries["theta"] = _constant_part(entries["theta"])
    return WrittenRow(entries, found["d"][number][1], varies=varies)
