"""Options as records: type, default, bounds, unit and one line of help of each, written once and checked once.

A question is a frozen dataclass of the base `Options`. The verb takes it, the command line derives its options from it
(`rankdrop.cli.command`), and msgspec reads and writes it and generates its schema.

    >>> from dataclasses import dataclass
    >>> from typing import Annotated
    >>> @dataclass(frozen=True)
    ... class Search(Options):
    ...     starts: Annotated[int, option("Random starts", ge=1)] = 100
    ...     within: Annotated[float, option("Distance from the family", unit="rad", ge=0)] | None = None
    >>> Search(starts=0)
    Traceback (most recent call last):
    ...
    rankdrop.errors.OptionError: starts: this value is not allowed; got 0; allowed: a whole number, at least 1
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, fields, replace
from functools import cache
from inspect import Parameter, signature
from math import isfinite
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Self, TypeVar, Union, get_args, get_origin, get_type_hints

import msgspec
from msgspec import Meta

from rankdrop.errors import OptionError

Verb = TypeVar("Verb", bound=Callable[..., Any])

_typed = False  # in every thread: the viewer's words are made in threads of its server


def option(
    help: str, *, unit: str = "", name: str = "", writes: tuple[str, ...] | None = None, **bounds: Any
) -> Meta:
    """Metadata of one field, for `Annotated`.

    Args:
        help: one line, without a full stop at its end.
        unit: of the number: "rad", "m", "s", "rad/s" …; on the command line 5deg and 3mm are understood.
        name: on the command line, where it is not that of the field: "--all".
        writes: of a file that the command writes: its endings, () for any, "-" where stdout will do beside them.
        bounds: ge, gt, le, lt of a number; numbers are finite always.
    """
    schema = {"unit": unit} if unit else None
    extra = ({"name": name} if name else {}) | ({} if writes is None else {"writes": writes})
    return Meta(description=help, extra_json_schema=schema, extra=extra or None, **bounds)


@contextmanager
def on_command_line() -> Iterator[None]:
    """Within it `advise` names options as they are typed on the command line, in every thread of this process."""
    global _typed
    before, _typed = _typed, True
    try:
        yield
    finally:
        _typed = before


def advise(name: str, value: str = "", *, python: str = "") -> str:
    """An option in a sentence of advice, as whoever reads the sentence writes it.

    Args:
        name: on the command line, without dashes.
        value: given to it; "" for a switch, "…" for a value that the reader chooses.
        python: what is written in Python, where it is not `name=value` of the call.

    Example:
        >>> advise("tip-tolerance", "…"), advise("task", "position"), advise("full")
        ('tip_tolerance=…', "task='position'", 'full=True')
        >>> with on_command_line():
        ...     advise("tip-tolerance", "…"), advise("task", "position"), advise("full")
        ('--tip-tolerance', '--task position', '--full')
    """
    if _typed:
        if value and value != "…":
            return f"--{name} {value}"
        return f"--{name}"
    if python:
        return python
    keyword = name.replace("-", "_")
    if not value:
        return f"{keyword}=True"
    if value == "…":
        return f"{keyword}={value}"
    return f"{keyword}={value!r}"


class Options:
    """Base of the records of options: a record that exists is within its bounds."""

    def __post_init__(self) -> None:
        defaults = _defaults(type(self))  # type: ignore[arg-type]  # a class is hashable
        for name, hint in hints(type(self)).items():  # type: ignore[arg-type]
            value = getattr(self, name)
            if value is defaults[name]:
                continue
            value = _plain(value)
            object.__setattr__(self, name, value)
            check_value(name, hint, value)

    @classmethod
    def of(cls, options: Self | None, given: Mapping[str, Any]) -> Self:
        """The record of a verb that was called with a record, with keywords, or with both: keywords count.

        `rng` is another name of `seed`, as in SciPy: a whole number, or a generator of NumPy that draws the seed.

        Raises:
            OptionError: no field has this name, or its value is out of range.
        """
        names = list(hints(cls))  # type: ignore[arg-type]  # a class is hashable
        if "rng" in given and "seed" in names:
            if "seed" in given:
                raise OptionError("rng and seed are the same option", where="rng", mend="give one of them")
            rng = given["rng"]
            if hasattr(rng, "integers"):
                seed = rng.integers(2**63)
            else:
                seed = rng
            given = {key: value for key, value in given.items() if key != "rng"} | {"seed": seed}
        for name in given.keys() - set(names):
            raise OptionError("no option has this name", where=name, allowed=", ".join(names))
        return cls(**given) if options is None else replace(options, **given)  # type: ignore[type-var]


def takes(record: type[Options]) -> Callable[[Verb], Verb]:
    """Let `help()` and completion show the fields of the record as keywords of a verb that takes `**given`."""

    def document_options(verb: Verb) -> Verb:
        taken = signature(verb).parameters.values()
        own = [parameter for parameter in taken if parameter.kind is not Parameter.VAR_KEYWORD]
        keywords = [
            Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type)
            for field in fields(record)  # type: ignore[arg-type]
        ]
        verb.__signature__ = signature(verb).replace(parameters=[*own, *keywords])  # type: ignore[attr-defined]
        return verb

    return document_options


@cache
def hints(record: type) -> dict[str, Any]:
    """The types of the fields, with their metadata."""
    found = get_type_hints(record, include_extras=True)
    return {field.name: found[field.name] for field in fields(record)}


@cache
def _defaults(record: type) -> dict[str, Any]:
    """The defaults of the fields, which are checked once; a field without one has a value that no option can be."""
    hints_of, found = hints(record), {}
    for field in fields(record):
        found[field.name] = field.default
        if field.default is not MISSING:
            check_value(field.name, hints_of[field.name], field.default)
    return found


def meta_of(hint: Any) -> Meta | None:
    """The metadata of a field's type, `Annotated[…] | None` included."""
    return next((part for part in parts_of(hint) if isinstance(part, Meta)), None)


def plain_type(hint: Any) -> Any:
    """The type of a field without metadata and None: int, float, bool, str, a Literal, or a tuple."""
    if get_origin(hint) is Annotated:
        return plain_type(get_args(hint)[0])
    if get_origin(hint) in (Union, UnionType):
        return plain_type(next(member for member in get_args(hint) if member is not NoneType))
    return hint


def unit_of(hint: Any) -> str:
    """The unit of a field, empty where it has none."""
    meta = meta_of(hint)
    if meta:
        return str((meta.extra_json_schema or {}).get("unit", ""))
    return ""


def allowed_values(hint: Any) -> str:
    """What a field may be, in words.

    Example:
        >>> allowed_values(Annotated[float, option("Speed", unit="m/s", gt=0)])
        'a number above 0 [m/s]'
    """
    kind, meta, unit = plain_type(hint), meta_of(hint), unit_of(hint)
    if get_origin(kind) is Literal:
        return ", ".join(map(str, get_args(kind)))
    words = {int: "a whole number", float: "a number", bool: "True or False", str: "a text"}.get(kind, str(kind))
    signs = (("ge", ", at least"), ("gt", " above"), ("le", ", at most"), ("lt", " below"))
    limits = [f"{sign} {limit}" for name, sign in signs if (limit := getattr(meta, name, None)) is not None]
    if meta is not None and meta.ge is not None and meta.le is not None:
        limits = [f", {meta.ge} … {meta.le}"]
    return "".join([words, *limits, f" [{unit}]" if unit else ""])


def parts_of(hint: Any) -> Iterator[Any]:
    """A type with all that it is made of: Annotated and unions taken apart."""
    yield hint
    if get_origin(hint) in (Annotated, Union, UnionType):
        for part in get_args(hint):
            yield from parts_of(part)


def _plain(value: Any) -> Any:
    """A number of NumPy as one of Python; a list as a tuple."""
    if isinstance(value, list):
        return tuple(value)
    if hasattr(value, "item") and getattr(value, "ndim", 1) == 0:
        return value.item()
    return value


def check_value(name: str, hint: Any, value: Any) -> None:
    """Check an option's value against its type with bounds.

    Raises:
        OptionError: the value is of another type, out of its bounds or not finite.
    """
    try:
        msgspec.convert(value, hint)
    except msgspec.ValidationError as error:
        raise OptionError(
            "this value is not allowed", where=name, got=repr(value), allowed=allowed_values(hint)
        ) from error
    if isinstance(value, float) and not isfinite(value):
        raise OptionError("the value is not finite", where=name, got=repr(value), allowed=allowed_values(hint))
