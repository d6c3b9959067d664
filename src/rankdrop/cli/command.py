"""What does every command do: read its options from records, check its targets, work, print, write, end with a code?

A command is a function of the arm and of records of options. A field of a record that names a file to
write says so (`option(…, writes=…)`): it is checked before the work. The function returns `Done`; the runner prints
its blocks, writes its files, and makes the exit code.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from functools import cache, partial, wraps
from inspect import signature
from itertools import chain
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, get_type_hints

from cyclopts import Group, Parameter, Token

from rankdrop import robot as arms
from rankdrop.cli import exits
from rankdrop.cli.targets import check_targets, write
from rankdrop.cli.terminal import STDOUT, Report, print_blocks, reporter
from rankdrop.errors import OptionError
from rankdrop.options import Options, check_value, hints, meta_of, option, parts_of, plain_type, unit_of

if TYPE_CHECKING:
    from rankdrop.cli.terminal import Block

_WHOLE = re.compile(r"[+-]?\d+(_\d+)*", re.ASCII)
_LONGEST_NUMBER = 100
_LAST = ("The arm", "Output")
DRAWN = (".svg", ".png", ".pdf")
"""Endings of figures."""
PAGES = (".html", ".htm", STDOUT)
"""Endings of pages."""
_MEASURES = {"rad": "angle", "m": "length"}
PROGRESS = Annotated[Report, Parameter(parse=False)]
"""Type of the parameter `report` of a command that shows its progress; the runner gives it."""


@dataclass(frozen=True)
class Done:
    """Finished work: what the runner prints and writes, and what the exit code says.

    Attributes:
        text: makes the blocks to print; not called where a file goes to stdout in their place.
        files: field of an option -> makes the content of its file: a record, a text or bytes; None: nothing.
        holds: whether every claim holds.
        complete: whether nothing was interrupted.
        last: a step after the files, such as a line on stderr.
        code: exit code, where `complete` and `holds` do not say it.
    """

    text: Callable[[], Iterable[Block]]
    files: Mapping[str, Callable[[], Any]] = field(default_factory=dict)
    holds: bool = True
    complete: bool = True
    last: Callable[[], object] | None = None
    code: int | None = None


def command(function: Callable[..., Done | int]) -> Callable[..., int]:
    """A command as cyclopts reads it: records among its parameters become options, and its result an exit code."""
    _derive_records(function)
    parameters = signature(function).parameters
    without_report = [parameter for name, parameter in parameters.items() if name != "report"]
    typed = signature(function).replace(parameters=without_report)

    @wraps(function)
    def run(*words: Any, **options: Any) -> int:
        bound = typed.bind(*words, **options)
        bound.apply_defaults()
        records = [record for record in bound.arguments.values() if isinstance(record, Options)]
        targets = list(chain.from_iterable(map(_targets_of, records)))
        check_targets({option: file for _, option, file, _ in targets},
                      {option: endings for _, option, _, endings in targets})  # fmt: skip
        if "report" in parameters:
            with reporter(quiet=any(getattr(record, "quiet", False) for record in records)) as report:
                done = function(*bound.args, **bound.kwargs, report=report)
        else:
            done = function(*bound.args, **bound.kwargs)
        if isinstance(done, int):
            return done
        return deliver(done, {name: file for name, _, file, _ in targets})

    run.__signature__ = typed  # type: ignore[attr-defined]  # a function may have one: the parser reads it
    return run


def _derive_records(function: Callable[..., Any]) -> None:
    """Replace the records among the types of a function's parameters by those that cyclopts reads."""
    for name, hint in get_type_hints(function, include_extras=True).items():
        if isinstance(hint, type) and issubclass(hint, Options) and is_dataclass(hint):
            function.__annotations__[name] = options_class(hint)


def _targets_of(record: Options) -> Iterator[tuple[str, str, str | None, tuple[str, ...]]]:
    """The files that a record of options names: field, option, file, allowed endings."""
    for name, hint in hints(type(record)).items():  # type: ignore[arg-type]  # a class is hashable
        endings = _extra(hint).get("writes")
        if endings is not None:
            yield name, _name(hint) or f"--{name.replace('_', '-')}", getattr(record, name), endings


def deliver(done: Done, targets: Mapping[str, str | None]) -> int:
    """Print finished work and write every file that has a target; each is tried, even where one before has failed.

    Args:
        done: the work.
        targets: field of an option -> its file, "-" for stdout, or None.

    Returns:
        The exit code.

    Raises:
        OptionError, OSError: of the first that failed; a reader that has gone counts only where all else is well.
    """
    files = {name: target for name, target in targets.items() if name in done.files and target is not None}
    steps: list[Callable[[], object]] = [] if STDOUT in files.values() else [lambda: print_blocks(done.text())]
    steps += [partial(_write, make, files[name]) for name, make in done.files.items() if name in files]
    if done.last is not None:
        steps += [done.last]
    failed = [error for step in steps if (error := _failure(step)) is not None]
    if failed:
        raise min(failed, key=lambda error: isinstance(error, BrokenPipeError))
    return _exit_code(done)


def _exit_code(done: Done) -> int:
    """The code of finished work: its own, else by whether it is complete and holds."""
    if done.code is not None:
        return done.code
    if not done.complete:
        return exits.INTERRUPTED
    if done.holds:
        return exits.FINE
    return exits.UNEXPLAINED


def _failure(step: Callable[[], object]) -> Exception | None:
    try:
        step()
    except (OptionError, OSError) as error:
        return error
    return None


def _write(make: Callable[[], Any], target: str) -> None:
    content = make()
    if content is not None:
        write(content, target)


def whole(_type: Any, tokens: Sequence[Token]) -> int:
    """The number that the words of one option write: 10000, 10_000, -5.

    Raises:
        ValueError: not a whole number; cyclopts names the option.
    """
    text = tokens[0].value.strip()
    if not _WHOLE.fullmatch(text) or len(text) > _LONGEST_NUMBER:
        raise ValueError(f"this is not a whole number; got {text[:40]!r}; allowed: digits, such as 10000 or 10_000.")
    return int(text)


@cache
def options_class(record: type[Options]) -> type[Options]:
    """A class with fields that carry what cyclopts needs and that makes instances of the record.

    `TITLE` of the record groups its options in the help.
    """
    every = hints(record)  # type: ignore[arg-type]  # a class is hashable
    declared = fields(record)  # type: ignore[arg-type]  # records of options are dataclasses
    kept = {option.name: option.default for option in declared if option.default is not MISSING}
    own = {
        name: Annotated[_typed_text(hint), _parameter(hint, kept.get(name, MISSING))] for name, hint in every.items()
    }

    def make(_: type, **given: Any) -> Options:
        for name, value in given.items():
            check_value(_name(every[name]) or name, every[name], value)
        return record(**given)

    body = {"__annotations__": own, "__doc__": "", "__module__": __name__, "__new__": make, **kept}
    made: type[Options] = dataclass(frozen=True)(type(record.__name__, (record,), body))
    if hasattr(record, "TITLE"):
        flat = Parameter(name="*", group=_group(record.TITLE))
    else:
        flat = Parameter(name="*")
    return flat(made)


def _typed_text(hint: Any) -> Any:
    """The typed text of a field: of a text or something else the text, which the verb reads."""
    if plain_type(hint) is not str:
        return hint
    if NoneType in parts_of(hint):
        return str | None
    return str


@cache
def _group(title: str) -> Group:
    return Group(title, sort_key=_LAST.index(title) + 1 if title in _LAST else 0)


def _parameter(hint: Any, default: object) -> Parameter:
    kind, meta = plain_type(hint), meta_of(hint)
    unit, words = unit_of(hint), meta.description or "" if meta else ""
    convert = {int: whole, float: _quantity(unit)}.get(kind)
    return Parameter(
        name=_name(hint), help=f"{words} [{unit}]." if unit and kind is not str else f"{words}.", converter=convert,
        negative=None if kind is bool and default is not False else (),
        show_default=None if default not in (None, False, (), "", MISSING) else False,
        allow_leading_hyphen=kind is str,
    )  # fmt: skip


def _extra(hint: Any) -> dict[str, Any]:
    meta = meta_of(hint)
    return (meta.extra if meta else None) or {}


def _name(hint: Any) -> str | None:
    return _extra(hint).get("name")


def _quantity(unit: str) -> Callable[[Any, Sequence[Token]], float]:
    measure = _MEASURES.get(unit.removesuffix("/s"), "number")

    def read(_type: Any, tokens: Sequence[Token]) -> float:
        return arms.quantity(tokens[0].value, measure, where=tokens[0].keyword or "", rate=unit.endswith("/s"))

    return read


@dataclass(frozen=True)
class Output(Options):
    """Where a result goes."""

    TITLE: ClassVar[str] = "Output"
    json: Annotated[
        str | None,
        option("Write the result to this file as well; - writes it to stdout instead of the text", writes=()),
    ] = None
    quiet: Annotated[bool, option("No progress; results and errors only")] = False


OUTPUT = Output()
