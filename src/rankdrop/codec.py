"""Tables of the entries of a file: one table encodes a record, decodes data strictly, and is its JSON Schema.

A table lists entries with their types, bounds, units and meaning; msgspec does the work. Units are metadata of the
numbers: `num("rad", ge=0)`. Where the entries are the fields of a record class, `of=` takes them over, with the
meanings from its docstring.

The tables of all files are in `rankdrop.schema`; a `Result` is what a verb returns, and is written by its table.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from functools import cache, partial
from importlib import import_module
from math import isfinite
from operator import attrgetter
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, ClassVar, Literal, Union, get_args, get_origin, get_type_hints

import msgspec
import numpy as np
from msgspec import UNSET, Meta, Struct, UnsetType

from rankdrop.disk import replace_file
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.sections import Section, html
from rankdrop.sections import text as text_of

Record = dict[str, Any]
"""Plain data of a file."""
_SHOWN = 60  # characters of a value in an error
_LARGEST = 2**53
"""Whole numbers up to here are the same in every reader of JSON."""

_GETTERS: dict[type, dict[str, Callable[[Any], Any]]] = {}
_TABLES: dict[type, type[Struct]] = {}  # of record classes

_AS_IT_IS = frozenset((str, int, bool, NoneType))

_STEERING = re.compile("[\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff]")  # JSON itself escapes the others

_ROOM = {
    "analysis": "families", "find": "families", "explanation": "explanation", "escape": "explanation",
    "nearest": "explanation", "tolerant": "explanation", "conditions": "families", "jacobian": "design",
    "path": "motion", "paths": "motion", "aspects": "motion", "through": "motion", "path-rows": "motion",
    "inverse": "motion", "program": "motion",
    "cover": "proof", "certificate": "proof", "verified": "proof", "sweep": "design", "side-by-side": "design",
}  # fmt: skip
_PARTS = {
    "robot": "arm", "family": "families", "inside": "families", "remedies": "motion", "program_remedies": "motion",
}  # fmt: skip
NAMES = tuple(_ROOM)
"""Kinds of result files: each is what the command of that name writes with --json, `explain` the explanation,
`compare` the side-by-side."""


def num(unit: str, **bounds: Any) -> Any:
    """Type of a number with its unit ("1": none) and bounds: ge, gt, le, lt."""
    return Annotated[float, Meta(extra_json_schema={"unit": unit}, extra={"unit": unit}, **bounds)]


def whole(ge: int = -_LARGEST, le: int = _LARGEST) -> Any:
    """Type of a whole number between bounds."""
    return Annotated[int, Meta(ge=ge, le=le)]


def text(**bounds: Any) -> Any:
    """Type of a text with a pattern or a min_length."""
    return Annotated[str, Meta(**bounds)]


def list_of(kind: Any) -> Any:
    """Type of a list."""
    return list[kind]


def mapping(kind: Any) -> Any:
    """Type of an object whose keys are free."""
    return dict[str, kind]


def pair(first: Any, second: Any) -> Any:
    """Type of a list of two entries."""
    return tuple[first, second]


def row(kind: Any, length: int) -> Any:
    """Type of a list of exactly so many entries."""
    return Annotated[list[kind], Meta(min_length=length, max_length=length)]


def nonempty(kind: Any, min_length: int = 1, max_length: int | None = None) -> Any:
    """Type of a list of at least one entry."""
    return Annotated[list[kind], Meta(min_length=min_length, max_length=max_length)]


def optional(kind: Any) -> Any:
    """Type of an entry that may be absent."""
    return Union[kind, UnsetType]  # noqa: UP007  # of types that are known at run time only


Count, Positive = whole(ge=0), whole(ge=1)


def table(name: str, about: str = "", /, *, of: type | None = None, **entries: Any) -> Any:
    """A table of entries.

    Args:
        name: of the table, in the schema.
        about: what such an object is.
        of: record class whose fields are entries too, in their order and before the others; fields with a default may
            be absent, since files of an earlier version do not have them.
        entries: by name (a trailing _ is dropped): a type; or (type, meaning); or (type, meaning, function of the
            record that gives the value), where the record has no attribute of that name. None leaves a field of `of`
            out.
    """
    columns = {
        key.rstrip("_"): column if isinstance(column, tuple) else (column, "") for key, column in entries.items()
    }
    if of is not None:
        columns = {**_columns_of(of, columns), **columns}
    columns = {key: column for key, column in columns.items() if column[0] is not None}
    record = msgspec.defstruct(
        name, [_field(key, *column) for key, column in columns.items()], kw_only=True, rename=_json_name,
        namespace={"__doc__": about or None},
    )  # fmt: skip
    _GETTERS[record] = {key: column[2] for key, column in columns.items() if len(column) > 2}
    if of is not None:
        _TABLES.setdefault(of, record)
    return record


def _json_name(key: str) -> str:
    return key.rstrip("_")


def _field(key: str, kind: Any, about: str = "", *_: Any) -> tuple[Any, ...]:
    if about:
        kind = Annotated[kind, Meta(description=about)]
    else:
        kind = kind
    if key in ("from", "global", "is"):
        key = f"{key}_"
    else:
        key = key
    if UnsetType in _parts(kind):
        return (key, kind, UNSET)
    return (key, kind)


def _parts(kind: Any) -> tuple[Any, ...]:
    if get_origin(kind) is Annotated:
        return _parts(get_args(kind)[0])
    if get_origin(kind) in (Union, UnionType):
        return get_args(kind)
    return (kind,)


def _columns_of(record: type, given: dict[str, Any]) -> dict[str, tuple[Any, ...]]:
    """The fields of a record class as entries; those that are given are not looked at."""
    hints, about, columns = get_type_hints(record, include_extras=True), meanings(record), {}
    for field in fields(record):
        if field.name.startswith("_"):
            continue
        if field.name in given:
            kind, meaning, *getter = given[field.name]
            columns[field.name] = (kind, meaning or about.get(field.name, ""), *getter)
            continue
        kind = _json_type(hints[field.name])
        default = field.default is not MISSING or field.default_factory is not MISSING
        columns[field.name] = (optional(kind) if default else kind, about.get(field.name, ""))
    given.update({key: columns[key] for key in given.keys() & columns.keys()})
    return columns


def _json_type(kind: Any) -> Any:
    """The type that a field has in JSON."""
    inner = get_args(kind)
    if get_origin(kind) is Annotated:
        return kind
    if isinstance(kind, type) and is_dataclass(kind):
        if kind in _TABLES:
            return _TABLES[kind]
        return table(kind.__name__, of=kind)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return Literal[tuple(member.value for member in kind)]
    if get_origin(kind) in (Union, UnionType):
        return Union[tuple(map(_json_type, inner))]  # noqa: UP007
    if get_origin(kind) in (tuple, list):
        if get_origin(kind) is list or inner[-1] is Ellipsis:
            return list[_json_type(inner[0])]  # type: ignore[misc]
        return tuple[tuple(map(_json_type, inner))]  # type: ignore[misc]
    return kind


@cache
def meanings(record: type) -> dict[str, str]:
    """Field -> what its class's docstring says of it under "Attributes:"."""
    block = re.split(r"\n\s*\n", (record.__doc__ or "").partition("Attributes:\n")[2])[0]
    texts: dict[str, str] = {}
    for part in re.split(r"\n {4,8}(?=\w+(?:, \w+)*:)", f"\n{block}")[1:]:
        names, _, about = part.partition(":")
        texts |= dict.fromkeys(names.split(", "), " ".join(about.split()))
    return texts


def encode(kind: type[Struct], record: Any) -> dict[str, Any]:
    """A record as plain data: every entry of its table."""
    data = {}
    for name, value_of, encoded in _entries(kind, isinstance(record, dict)):
        value = value_of(record)
        if value is not UNSET:
            data[name] = encoded(value)
    return data


@cache
def _entries(
    kind: type[Struct], of_dict: bool
) -> tuple[tuple[str, Callable[[Any], Any], Callable[[Any], Any]], ...]:
    """(name, function of the record, function of its value) of every entry; the record is a dict, or it is not."""
    getters = _GETTERS[kind]
    entries = []
    for field in msgspec.structs.fields(kind):
        name = field.encode_name
        if name in getters:
            value_of = getters[name]
        elif of_dict:
            value_of = partial(_item, name)
        else:
            value_of = attrgetter(name)
        entries.append((name, value_of, _encoder(field.type)))
    return tuple(entries)


def _item(name: str, record: dict[str, Any]) -> Any:
    return record.get(name, UNSET)


def _encoder(kind: Any) -> Callable[[Any], Any]:
    inner = [part for part in _parts(kind) if part not in (NoneType, UnsetType)]
    kind = inner[0] if len(inner) == 1 else None
    if get_origin(kind) is Annotated:
        return _encoder(get_args(kind)[0])
    if isinstance(kind, type) and issubclass(kind, Struct):
        return lambda value: None if value is None else encode(kind, value)
    if get_origin(kind) is list and (each := _encoder(get_args(kind)[0])) is not plain:
        return lambda value: None if value is None else [each(entry) for entry in value]
    return plain


def plain(value: Any) -> Any:
    """Data as JSON has it: fields of records become objects, arrays and tuples lists, infinities null.

    A record that is a text in JSON has a method `__json__`.
    """
    kind: Any = type(value)
    if kind in _AS_IT_IS:
        return value
    if kind is float:
        return value if isfinite(value) else None
    if kind in (tuple, list):
        return _plain_list(value)
    names = _fields_of(kind)
    if names is not None:
        return {name: plain(getattr(value, name)) for name in names}
    if hasattr(kind, "__json__"):
        return value.__json__()
    return _plain_of_python(value)


def _plain_list(values: Iterable[Any]) -> list[Any]:
    """A list or tuple as JSON has it; of numbers and words, mostly: no call for each."""
    return [
        value if type(value) in _AS_IT_IS or (type(value) is float and isfinite(value)) else plain(value)
        for value in values
    ]


def _plain_of_python(value: Any) -> Any:
    """Data of NumPy, of Python's abstract types and of enums as JSON has it; other data as it is."""
    if isinstance(value, np.ndarray | np.generic):
        if value.dtype.kind == "f" and np.isfinite(value).all():  # nothing in it becomes null
            return value.tolist()
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return _plain_list(value)
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, Enum):
        return value.value
    return value


@cache
def _fields_of(kind: type[Any]) -> tuple[str, ...] | None:
    """The fields of a record that files hold; None for what is no record, or is a text."""
    if is_dataclass(kind) and not hasattr(kind, "__json__"):
        return tuple(field.name for field in fields(kind) if field.name[0] != "_")
    return None


def restore(kind: Any, data: Any) -> Any:
    """What `plain` made data of, by the types of the fields: `restore(type(x), plain(x))` is equal to x.

    Entries that a record does not have are a later version's and left out; those that are missing were not known to an
    earlier one and have their defaults.

    Args:
        kind: a dataclass, or what a field is annotated with.
        data: plain data.

    Raises:
        ValueError: an entry without a default is missing, or is something else.
    """
    try:
        return msgspec.convert(data, kind, dec_hook=lambda _, numbers: np.array(numbers))
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from error


def json_text(record: Any) -> str:
    """JSON for people too: indented, a row of numbers on one line; NaN and infinities are refused."""
    dense = json.dumps(record, ensure_ascii=False, allow_nan=False)
    text = msgspec.json.format(dense, indent=1)  # json itself would indent in Python, at half the speed
    text = _STEERING.sub(lambda letter: f"\\u{ord(letter[0]):04x}", text)  # the same text to a reader of JSON
    # strings hold no raw line break, so only arrays of numbers match
    return re.sub(r"\[\n[\s\d.,eE+-]+\]", lambda row: f"[{' '.join(row[0][1:-1].split())}]", text) + "\n"


def save_record(record: Any, path: str | Path) -> None:
    """Write a record to a JSON file.

    Raises:
        ResultFileError: the file cannot be written; an old one of this name is as it was.
    """
    try:
        replace_file(path, json_text(record).encode())
    except (OSError, ValueError) as error:
        if isinstance(error, OSError):
            reason = error.strerror
        else:
            reason = str(error)
        raise ResultFileError(f"the file cannot be written: {reason}", where=str(path)) from error


def decode(kind: type[Struct], data: Any) -> Any:
    """Data as an instance of a table.

    Raises:
        ResultFileError: with the path of the first element that is not as the table says.
    """
    try:
        return msgspec.convert(data, kind)
    except msgspec.ValidationError as error:
        what, _, where = str(error).partition(" - at `")
        path = where.removesuffix("`") or "$"
        raise ResultFileError(what.replace("`", ""), where=path, got=value_in_error(element(data, path))) from None


def element(data: Any, path: str) -> Any:
    """The element of data at a path, "$.families[0].witness[2]"; the last one that exists on the way."""
    for key, index in re.findall(r"\.([^.\[]+)|\[(\d+)\]", path):
        try:
            data = data[key] if key else data[int(index)]
        except (KeyError, IndexError, TypeError):
            return data
    return data


def value_in_error(value: Any) -> str:
    """A value in an error: its beginning, or how large it is.

    Example:
        >>> value_in_error([1, 2, 3]), value_in_error("wrist")
        ('a list of 3', "'wrist'")
    """
    if isinstance(value, list | dict):
        return f"{'a list' if isinstance(value, list) else 'an object'} of {len(value)}"
    if isinstance(value, int) and abs(value) > _LARGEST**2:
        return "a number of hundreds of digits"
    words = repr(value)
    if len(words) <= _SHOWN:
        return words
    return f"{words[:_SHOWN]} …"


def json_schema(kind: type[Struct]) -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a table, other tables under `$defs`."""
    _, rest = msgspec.json.schema_components([kind], ref_template="#/$defs/{name}")
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **rest.pop(kind.__name__), "$defs": rest}


def table_of(kind: str) -> type[Struct]:
    """The table of a kind of file, or of a part that has a name in `_PARTS`; imported when it is first used.

    Raises:
        OptionError: there is no such kind.
    """
    if kind in _PARTS:
        part: type[Struct] = getattr(import_module(f"rankdrop.schema.{_PARTS[kind]}"), kind.upper())
        return part
    if kind not in _ROOM:
        raise OptionError("there is no such schema", got=repr(kind), allowed=", ".join(NAMES))
    name = f"{kind.upper().replace('-', '_')}_FILE"
    record: type[Struct] = getattr(import_module(f"rankdrop.schema.{_ROOM[kind]}"), name)
    return record


def load_schema(name: str) -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a kind of file, generated from its table.

    Args:
        name: "analysis" (`rankdrop analyze --json`), "find", "explanation" (`rankdrop explain --json`), "escape",
            "nearest", "tolerant", "conditions", "jacobian", "path", "paths" (`rankdrop path --json` with several
            files), "program" (`rankdrop path` of a robot program), "aspects", "through", "inverse" (`rankdrop explain
            --pose`), "path-rows" (`rankdrop path --rows OUT.json`), "cover", "certificate"
            (--certificate), "verified" (`rankdrop verify --json`), "sweep" or "side-by-side" (`rankdrop compare`).

    Raises:
        OptionError: there is no such schema.

    Example:
        >>> load_schema("analysis")["properties"]["schema"]["const"]
        'rankdrop/analysis/1'
    """
    schema = json_schema(table_of(name))
    entry = schema["properties"]["schema"]
    entry["const"] = entry.pop("enum")[0]
    number = entry["const"].rpartition("/")[2]
    return schema | {"$id": f"urn:rankdrop:{name}:{number}", "title": f"rankdrop {name}, version {number}"}


def check_record(kind: str, record: Any) -> None:
    """Compare plain data with the table of a kind of file.

    Raises:
        ResultFileError: with the path of the first element that is not as it should be.
    """
    try:
        decode(table_of(kind), record)
    except ResultFileError as error:
        what = f"the {kind} is damaged: {error.what}"
        raise ResultFileError(what, where=error.where, got=error.got, mend="make the file again") from None


def record_of(kind: str, result: Any) -> dict[str, Any]:
    """A result as the plain data of its file."""
    return encode(table_of(kind), result)


class Result:
    """What a verb returns: plain data, a JSON file, text, a table in a notebook. `FILE` is its kind of file."""

    FILE: ClassVar[str]

    def sections(self) -> Iterable[Section]:
        """As sections of text."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """The record of its JSON file: docs/json.md."""
        return record_of(self.FILE, self)

    def save(self, path: str | Path) -> None:
        """Write it to a JSON file.

        Raises:
            ResultFileError: the file cannot be written; an old one of this name is as it was.
        """
        save_record(self.to_dict(), path)

    def __str__(self) -> str:
        return text_of(self.sections())

    def _repr_html_(self) -> str:
        """For notebooks."""
        return html(self.sections())
