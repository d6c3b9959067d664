"""Options of the command line, derived from records (`rankdrop.options`): names, help, units, defaults and bounds."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Annotated, Any, TypeVar, get_type_hints

from cyclopts import Parameter, Token

from rankdrop.errors import OptionError
from rankdrop.options import Options, hints, meta_of, plain_type, unit_of

Command = TypeVar("Command", bound=Callable[..., Any])
_WHOLE = re.compile(r"[+-]?\d+(_\d+)*", re.ASCII)
_LONGEST_NUMBER = 100
_MEASURES = {"rad": "angle", "m": "length"}


def command(function: Command) -> Command:
    """Replace the records among a command's parameters by those that cyclopts reads."""
    for name, hint in get_type_hints(function, include_extras=True).items():
        if isinstance(hint, type) and issubclass(hint, Options) and is_dataclass(hint):
            function.__annotations__[name] = derived(hint)
    return function


def derived(record: type[Options]) -> type[Options]:
    """A subclass of a record whose fields carry what cyclopts needs; `TITLE` of the record groups them in the help."""
    own = {
        field.name: Annotated[hint, _parameter(hint, field.default)]
        for field, hint in zip(fields(record), hints(record).values(), strict=True)  # type: ignore[arg-type]
    }
    defaults = {field.name: field.default for field in fields(record)}  # type: ignore[arg-type]
    members = {"__annotations__": own, "__doc__": "", "__module__": __name__, "__post_init__": _check_as_typed}
    made = type(record.__name__, (record,), {**members, **defaults})
    found: type[Options] = dataclass(frozen=True)(made)
    return Parameter(name="*", group=getattr(record, "TITLE", None))(found)


def _check_as_typed(options: Options) -> None:
    """The check of the record, with the option's name as it is typed."""
    try:
        Options.__post_init__(options)
    except OptionError as error:
        meta = meta_of(hints(type(options)).get(error.where or ""))
        name = ((meta.extra if meta else None) or {}).get("name") or f"--{(error.where or '').replace('_', '-')}"
        raise OptionError(error.what, where=name, got=error.got, allowed=error.allowed, mend=error.mend) from error


def _parameter(hint: Any, default: object) -> Parameter:
    """The option of one field."""
    kind, meta = plain_type(hint), meta_of(hint)
    unit, name = unit_of(hint), ((meta.extra if meta else None) or {}).get("name")
    convert = {int: whole, float: _quantity(unit)}.get(kind)
    return Parameter(
        name=name, help=_help(meta.description or "" if meta else "", unit, kind), converter=convert, negative=(),
        show_default=None if default not in (None, False, (), "") else False, allow_leading_hyphen=kind is str,
    )  # fmt: skip


def _help(words: str, unit: str, kind: Any) -> str:
    return f"{words} [{unit}]." if unit and kind is not str else f"{words}."


def _quantity(unit: str) -> Callable[[Any, Sequence[Token]], float]:
    """The reader of a number with its unit: 5deg, 3mm, pi/2, 250mm/s."""
    measure = _MEASURES.get(unit.removesuffix("/s"), "number")

    def read(_type: Any, tokens: Sequence[Token]) -> float:
        from rankdrop.robot import quantity

        return quantity(tokens[0].value, measure, where=tokens[0].keyword or "", rate=unit.endswith("/s"))

    return read


def whole(_type: Any, tokens: Sequence[Token]) -> int:
    """The number that the words of one option write: 10000, 10_000, -5.

    Raises:
        ValueError: not a whole number; cyclopts names the option.
    """
    text = tokens[0].value.strip()
    if not _WHOLE.fullmatch(text) or len(text) > _LONGEST_NUMBER:
        raise ValueError(f"this is not a whole number; got {text[:40]!r}; allowed: digits, such as 10000 or 10_000.")
    return int(text)
