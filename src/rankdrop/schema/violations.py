"""Whether data is what a published schema says: the part of JSON Schema that the schemas use, with the place."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any, NamedTuple

KEYWORDS = frozenset(
    {
        "type", "const", "enum", "anyOf", "$ref", "minimum", "maximum", "exclusiveMinimum", "pattern", "minLength",
        "minItems", "maxItems", "uniqueItems", "items", "properties", "required", "additionalProperties",
    }
)  # fmt: skip
"""What is looked at; `$defs`, titles and descriptions say nothing about the data."""
_KINDS: dict[str, tuple[type, ...]] = {
    "object": (dict,), "array": (list,), "string": (str,), "boolean": (bool,), "null": (type(None),),
    "integer": (int,), "number": (int, float),
}  # fmt: skip
_SHOWN = 60  # characters of a value in an error
_LARGEST = 2**1000  # a whole number beyond it has no double


class Violation(NamedTuple):
    """One thing that is not as it should be.

    Attributes:
        where: path of the element, "$.families[0].witness[2]".
        what: is wrong.
        got, allowed: in words; None where there is nothing to say.
    """

    where: str
    what: str
    got: str | None = None
    allowed: str | None = None


def first_violation(value: Any, schema: Mapping[str, Any]) -> Violation | None:
    """The first thing in the order of the schema that the data does not keep to; None where there is none.

    Args:
        value: data as `json.loads` makes it.
        schema: see `load_schema`; whole numbers are to be written without a point.
    """
    return next(_violations(value, schema, schema, "$"), None)


def shown(value: Any) -> str:
    """A value in an error: its beginning, or how large it is.

    Example:
        >>> shown([1, 2, 3]), shown("wrist")
        ('a list of 3', "'wrist'")
    """
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, dict):
        return f"an object of {len(value)}"
    if isinstance(value, int) and abs(value) >= _LARGEST:
        return "a number of hundreds of digits"
    text = repr(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]} …"


def _violations(value: Any, schema: Mapping[str, Any], whole: Mapping[str, Any], where: str) -> Iterator[Violation]:
    if "$ref" in schema:
        yield from _violations(value, whole["$defs"][schema["$ref"].rpartition("/")[2]], whole, where)
    kinds = schema.get("type", list(_KINDS))
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if not any(_is(value, kind) for kind in kinds):
        yield Violation(where, f"this is no {' or '.join(kinds)}", shown(value), " or ".join(kinds))
        return
    if "const" in schema and value != schema["const"]:
        yield Violation(where, "this is another value", shown(value), str(schema["const"]))
    if "enum" in schema and value not in schema["enum"]:
        yield Violation(where, "this is none of the values", shown(value), ", ".join(map(str, schema["enum"])))
    if "anyOf" in schema:
        found = [list(_violations(value, one, whole, where)) for one in schema["anyOf"]]
        if all(found):
            yield max((one[0] for one in found), key=lambda one: len(one.where))
    if isinstance(value, str):
        yield from _of_text(value, schema, where)
    elif isinstance(value, list):
        yield from _of_list(value, schema, whole, where)
    elif isinstance(value, dict):
        yield from _of_object(value, schema, whole, where)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield from _of_number(value, schema, where)


def _is(value: Any, kind: str) -> bool:
    if isinstance(value, bool):
        return kind == "boolean"
    if isinstance(value, int | float) and not (abs(value) < _LARGEST if isinstance(value, int) else isfinite(value)):
        return False
    return isinstance(value, _KINDS[kind])


def _of_text(value: str, schema: Mapping[str, Any], where: str) -> Iterator[Violation]:
    if len(value) < schema.get("minLength", 0):
        yield Violation(where, "the text is too short", shown(value), f"{schema['minLength']} characters or more")
    if "pattern" in schema and not re.search(schema["pattern"], value):
        yield Violation(where, "the text has another form", shown(value), schema["pattern"])


def _of_number(value: float, schema: Mapping[str, Any], where: str) -> Iterator[Violation]:
    if value < schema.get("minimum", value):
        yield Violation(where, "the number is too small", shown(value), f"{schema['minimum']} or more")
    if value > schema.get("maximum", value):
        yield Violation(where, "the number is too large", shown(value), f"up to {schema['maximum']}")
    if "exclusiveMinimum" in schema and value <= schema["exclusiveMinimum"]:
        yield Violation(where, "the number is too small", shown(value), f"above {schema['exclusiveMinimum']}")


def _of_list(value: list[Any], schema: Mapping[str, Any], whole: Mapping[str, Any], where: str) -> Iterator[Violation]:
    least, most = schema.get("minItems", 0), schema.get("maxItems", len(value))
    if not least <= len(value) <= most:
        allowed = f"{least} entries" if least == schema.get("maxItems") else f"{least} entries or more"
        yield Violation(where, "the list has the wrong length", f"{len(value)} entries", allowed)
    if schema.get("uniqueItems") and any(one in value[:i] for i, one in enumerate(value)):
        yield Violation(where, "an entry is there twice", shown(value))
    for i, one in enumerate(value if "items" in schema else ()):
        yield from _violations(one, schema["items"], whole, f"{where}[{i}]")


def _of_object(
    value: dict[str, Any], schema: Mapping[str, Any], whole: Mapping[str, Any], where: str
) -> Iterator[Violation]:
    for key in schema.get("required", ()):
        if key not in value:
            yield Violation(where, f"no entry {key!r}")
    properties = schema.get("properties", {})
    for key, one in properties.items():
        if key in value:
            yield from _violations(value[key], one, whole, f"{where}.{key}")
    others = schema.get("additionalProperties", True)
    if isinstance(others, Mapping):
        for key in value.keys() - properties.keys():
            yield from _violations(value[key], others, whole, f"{where}.{key}")
