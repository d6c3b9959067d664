"""What every command does: read its options from records, check its targets, work, print, write, end with a code.

A command is a function of the arm and of records of options. A field of a record that names a file to
write says so (`option(…, writes=…)`): it is checked before the work. The function returns `Done`; the runner prints
its blocks, writes its files, and makes the exit code.

And what commands read alike: the arm, or the ideal one near it, with the lines that say what was assumed; one
configuration, --q 0,0.5,pi/2 (rad and m) or with --deg.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from functools import cache, partial, wraps
from inspect import cleandoc, signature
from itertools import accumulate, chain
from math import degrees, pi, radians
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, get_type_hints

from cyclopts import Group, Parameter, Token

from rankdrop import robot as arms
from rankdrop import text as text_of
from rankdrop import verbs
from rankdrop.cli import exits
from rankdrop.cli.targets import check_targets, write
from rankdrop.cli.terminal import STDOUT, Report, print_blocks, reporter, say
from rankdrop.errors import ConfigurationError, OptionError, RobotError
from rankdrop.named_tasks import task_names
from rankdrop.options import Options, check_value, hints, meta_of, option, parts_of, plain_type, unit_of
from rankdrop.sections import Section

if TYPE_CHECKING:
    from cyclopts.help import HelpEntry, HelpPanel
    from rich.console import Console, ConsoleOptions, RenderableType

    from rankdrop import results
    from rankdrop.cli.terminal import Block
    from rankdrop.cover import ModelTolerance
    from rankdrop.families import Family, Verdict
    from rankdrop.task import Task

_WHOLE = re.compile(r"[+-]?\d+(_\d+)*", re.ASCII)
_LONGEST_NUMBER = 100
_LAST = ("The arm", "Output")
DRAWN = (".svg", ".png", ".pdf")
"""Endings of figures."""
PAGES = (".html", ".htm", STDOUT)
"""Endings of pages."""
_MEASURES = {"rad": "angle", "m": "length"}
_LONGEST_TOOL = 10.0  # [m]
_WHOLE_TO = 1e-9  # of a typed angle [deg]
_SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")
_AS_TYPED = str.maketrans({"−": "-", "–": "-", "π": "pi", "{": " ", "}": " "})  # as copied from what is printed
TASKS = f"{', '.join(task_names())}, or rows: vx,vy,wz"
"""What `--task` takes."""
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


def prose(docstring: str) -> str:
    """The text of a docstring without its arguments; paragraphs are as long as they are, indented lines stay."""
    text = cleandoc(docstring).split("\nArgs:")[0].strip()
    parts = text.split("\n\n")
    return "\n\n".join(part if "\n  " in part else " ".join(part.split()) for part in parts)


class Help:
    """Prints a panel of commands or options in two columns, the second one wrapped to the terminal's width."""

    def __call__(self, console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
        from rich.table import Table
        from rich.text import Text

        table = Table.grid(padding=(0, 2, 0, 0))
        table.add_column(overflow="fold", max_width=max(12, console.width // 3))
        table.add_column()
        for entry in panel.entries:
            table.add_row(Text(f"  {_labels(entry)}"), Text(_description(console, entry)))
        if table.row_count:
            console.print(Text(f"{panel.title}:", style="bold"), table, sep="\n")

    def render_usage(self, console: Console, options: ConsoleOptions, usage: object) -> None:
        """The line of how the command is typed."""
        console.print(f"Usage: {usage}", markup=False, highlight=False)


def _labels(entry: HelpEntry) -> str:
    names = sorted((*entry.positive_names, *entry.positive_shorts), key=lambda name: name[:2] != "--")
    return ", ".join(names or entry.display_labels)


def _description(console: Console, entry: HelpEntry) -> str:
    endless = console.options.update(max_width=10_000)
    words = "".join(segment.text for segment in console.render(entry.description or "", endless))
    if entry.choices:
        choices = f" One of {', '.join(entry.choices)}."
    else:
        choices = ""
    if entry.default not in (None, "False", "None", ""):
        default = f" Default: {entry.default}."
    else:
        default = ""
    return f"{' '.join(words.split())}{choices}{default}"


def model_tolerance(text: str | None) -> ModelTolerance | None:
    """A tolerance as it is typed: 0.3mm,1mrad; one of the two alone leaves the other at zero.

    Raises:
        OptionError: not a length, an angle or both; or an angle too large.
    """
    if text is None:
        return None
    from rankdrop.cover import ModelTolerance

    given = arms.read_tolerance(text, where="--model-tolerance")
    return ModelTolerance(given.length or 0.0, given.angle or 0.0)


def parse_configuration(text: str, robot: arms.Robot, *, deg: bool, option: str = "--q") -> list[float]:
    """The joint values that a text writes, one per joint, in rad and m.

    Numbers are separated by commas, semicolons or blanks; each is arithmetic with pi and sqrt, and may carry a unit
    (deg, rad, m, mm …). A number without a unit is in rad, or in degrees with `deg`; slides are in m. The signs − and
    π are understood: what was printed can be pasted, and so can "{A1 0, A2 −90, …}" of a program, in the order of the
    joints, by their names or by letters and number.

    Raises:
        ConfigurationError: not one number for each joint, or a word that is no number.
    """
    joints = robot.variables
    words = _values_by_name(text, [joint.name for joint in joints]) or split_values(text)
    if len(words) != len(joints):
        raise ConfigurationError(
            f"{len(joints)} joint values are needed", where=option, got=f"{len(words)} in {text!r}",
            allowed=joint_units(robot, deg=deg),
            mend=_decimal_comma_fix(text, len(joints)) or f'write them as {option}="0,0.5,…"',
        )  # fmt: skip
    values = [
        value_of(word, joint.unit, f"{option}, joint {joint.name}", deg=deg)
        for word, joint in zip(words, joints, strict=True)
    ]
    typed = [degrees(abs(x)) for x, joint in zip(values, joints, strict=True) if joint.unit == "rad"]
    if deg and 0.0 < max(typed, default=0.0) <= pi and any(x % 1.0 > _WHOLE_TO for x in typed):
        say(f"note: angles up to {max(typed):.4g} look like radians and are read as degrees")
    return values


def _values_by_name(text: str, names: Sequence[str]) -> list[str]:
    """The values of a list such as {A1 0, A2 -90} or "j1: 0; j2: 1.5", one for each joint; empty for any other list."""
    items = re.split(r"[,;]", text.translate(_AS_TYPED).strip().strip("{}[]()").strip().rstrip(",;"))
    if len(items) != len(names):
        return []
    values = []
    for number, (item, name) in enumerate(zip(items, names, strict=True), start=1):
        found = re.fullmatch(r"([A-Za-z]\w*)\s*[\s:=]\s*(.+)", item.strip())
        if found is None or not (found[1] == name or re.fullmatch(rf"[A-Za-z_]+{number}", found[1])):
            return []
        values.append(found[2].strip())
    return values


def joint_units(robot: arms.Robot, *, deg: bool) -> str:
    """The joints with the units their values are read in: "elbow [deg], lift [m]"."""
    units = {"rad": "deg" if deg else "rad"}
    return ", ".join(f"{joint.name} [{units.get(joint.unit, joint.unit)}]" for joint in robot.variables)


def _decimal_comma_fix(text: str, count: int) -> str | None:
    """The fix of a list with decimal commas, 0,5; 1,2 …; None for any other list."""
    words = re.split(r"\s*;\s*|\s+", text.strip())
    commas = all(re.fullmatch(r"[-+−]?\d+(,\d+)?\D*", word) for word in words)
    fits = commas and len(words) == count
    if fits:
        return f"write decimals with points: {'; '.join(words).replace(',', '.')}"
    return None


def split_values(text: str) -> list[str]:
    """The words of a list of quantities, however it is bracketed and separated."""
    body = _without_brackets(text.translate(_AS_TYPED).strip()).strip().rstrip(",;")
    if body:
        return _SEPARATOR.split(body)
    return []


def _without_brackets(text: str) -> str:
    """[…] and (…) around the whole list, not those of the first and the last number."""
    if text[:1] == "[" and text[-1:] == "]":
        return text[1:-1]
    *depths, end = accumulate((letter == "(") - (letter == ")") for letter in text or " ")
    around = text[:1] == "(" and text[-1:] == ")" and end == 0 and all(depth > 0 for depth in depths)
    return text[1:-1] if around else text


def value_of(word: str, unit: str, where: str, *, deg: bool) -> float:
    """One quantity in rad or m; an angle without a unit is in degrees with `deg`.

    Raises:
        ConfigurationError: it is none.
    """
    try:
        value = arms.quantity(word, "length" if unit == "m" else "angle", where=where)
    except RobotError as error:
        raise ConfigurationError(**error.parts) from error
    plain = not re.search(r"(deg|rad|°)$", word)
    if deg and unit == "rad" and plain:
        return radians(value)
    return value


@dataclass(frozen=True)
class ArmOptions(Options):
    """Which part of the arm, for which task."""

    TITLE: ClassVar[str] = "The arm"
    task: Annotated[str | None, option(f"{TASKS}; else its own")] = None
    base: Annotated[str | None, option("First link of the chain (robot files)")] = None
    tip: Annotated[str | None, option("Last link of the chain (robot files)")] = None
    length_scale: (
        Annotated[
            float, option("Translation rows are divided by it; else by the reach. No family depends on it", unit="m")
        ]
        | None
    ) = None
    as_written: Annotated[
        bool, option("Keep the file's numbers: 1.5708 is no right angle then, noise of 2e-5 rad and 2 µm is kept")
    ] = False
    package: Annotated[
        tuple[str, ...], option("NAME=PATH: where package://NAME and $(find NAME) are. May be given again")
    ] = ()
    arg: Annotated[tuple[str, ...], option("NAME:=VALUE: an argument of a xacro file. May be given again")] = ()
    xacro: Annotated[
        bool, option("Expand a file that does not end in .xacro. Expanding can run any command: trust the file")
    ] = False

    @property
    def packages(self) -> dict[str, Path]:
        """Package name -> folder, as given.

        Raises:
            OptionError: a package is not NAME=PATH, or there is no such folder.
        """
        packages = _pairs(self.package, "=", "--package", "NAME=PATH")
        for name, path in packages.items():
            if not Path(path).is_dir():
                raise OptionError("there is no such folder", where=f"--package {name}", got=path)
        return {name: Path(path) for name, path in packages.items()}

    @property
    def arguments(self) -> dict[str, str]:
        """Arguments of a xacro file, name -> value, as given.

        Raises:
            OptionError: an argument is not NAME:=VALUE, or given twice.
        """
        return _pairs(self.arg, ":=", "--arg", "NAME:=VALUE")


def _pairs(words: tuple[str, ...], sign: str, option: str, form: str) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for word in words:
        name, given, value = word.partition(sign)
        if not (name and given and (value or sign == ":=")):
            raise OptionError("this is not of the form", where=option, got=repr(word), allowed=form)
        if name in pairs:
            raise OptionError("the name is given twice", where=option, got=name, mend="give it once")
        pairs[name] = value
    return pairs


@dataclass(frozen=True)
class IdealOptions(ArmOptions):
    """Which part of the arm, for which task; and how near the ideal arm is that is taken in its place."""

    ideal: Annotated[
        str | None,
        option("The nearest arm with axes exactly parallel, square and intersecting, within 1mm,0.5deg; or off"),
    ] = None


@dataclass(frozen=True)
class ToolOptions(Options):
    """How angles are typed, where the tool point is, and in which axes motions are reported."""

    deg: Annotated[bool, option("Angles without a unit are in degrees")] = False
    tcp: Annotated[
        str | None, option("Tool point from the tip, in its axes: x,y,z or x,y,z,roll,pitch,yaw [m, rad]; 120mm, 30deg")
    ] = None


@dataclass(frozen=True)
class Output(Options):
    """Where a result goes."""

    TITLE: ClassVar[str] = "Output"
    json: Annotated[
        str | None,
        option("Write the result to this file as well; - writes it to stdout instead of the text", writes=()),
    ] = None
    quiet: Annotated[bool, option("No progress; results and errors only")] = False


NO_OPTIONS, NO_IDEAL, NO_TOOL, OUTPUT = ArmOptions(), IdealOptions(), ToolOptions(), Output()
ROBOT_FILES = ", ".join(arms.format_endings())
ROBOT_HELP = f"Name in the catalogue (`rankdrop robots`) or a file ({ROBOT_FILES})."
ROBOT = Annotated[str, Parameter(help=ROBOT_HELP)]
Q = Annotated[str, Parameter(
    help="One number per joint, separated by commas or blanks [rad, m]; pi/2, 30deg, 120mm are understood.",
    allow_leading_hyphen=True,
)]  # fmt: skip

POSE = Annotated[str, Parameter(
    help="Pose of the tip in the base axes: x,y,z,roll,pitch,yaw or x,y,z,qx,qy,qz,qw, for a position x,y,z "
    "[m, rad]; 30deg, 120mm are understood. Also as makers write it: p[x,y,z,rx,ry,rz], {X 100, …, A 0, B 90, C 0}, "
    "X 100 … W 180 P 0 R 0, a robtarget of RAPID; or x,y,z,qw,qx,qy,qz wxyz.",
    allow_leading_hyphen=True,
)]  # fmt: skip


def open_arm(name: str, options: ArmOptions, tool: ToolOptions = NO_TOOL) -> tuple[arms.Robot, Task]:
    """Open the arm and resolve its task.

    Args:
        name: in the catalogue, or a file.
        options: which part of it, for which task.
        tool: the tool point, as typed.

    Raises:
        RankdropError: the arm or the task does not exist, a package is not NAME=PATH, an argument not NAME:=VALUE, the
            tool point not three or six quantities.
    """
    from rankdrop.task import resolve_task

    robot = arms.open_robot(
        name, tip=options.tip, base=options.base, packages=options.packages or None, args=options.arguments,
        xacro=options.xacro, as_written=options.as_written,
    )  # fmt: skip
    if tool.tcp is not None:
        robot = arms.with_tool(robot, *_tool(tool.tcp, deg=tool.deg))
    return robot, resolve_task(options.task, robot, length_scale=options.length_scale)


def _tool(text: str, *, deg: bool) -> tuple[list[float], list[float]]:
    words = split_values(text)
    if len(words) not in (3, 6):
        raise OptionError("a tool point is three lengths, then three angles if the tool is turned", where="--tcp",
                          got=f"{len(words)} numbers in {text!r}", allowed="x,y,z or x,y,z,roll,pitch,yaw [m, rad]",
                          mend='write it as --tcp="0,0,120mm"')  # fmt: skip
    lengths = [value_of(word, "m", "--tcp", deg=deg) for word in words[:3]]
    if max(map(abs, lengths)) > _LONGEST_TOOL:
        millimetres = ",".join(f"{word}mm" for word in words[:3])
        raise OptionError("a tool point so far from the tip is a slip of the unit", where="--tcp", got=f"{text} [m]",
                          allowed=f"up to {_LONGEST_TOOL:g} m",
                          mend=f"in millimetres: --tcp={millimetres}")  # fmt: skip
    return lengths, [value_of(word, "rad", "--tcp", deg=deg) for word in words[3:]] or [0.0, 0.0, 0.0]


def parse_pose(text: str, *, deg: bool, option: str = "--pose", robot: arms.Robot | None = None) -> list[float]:
    """The numbers of a pose: three lengths, then none, three angles or four of a quaternion, in m and rad.

    A pose in a maker's form is read by its conventions (`path.read.pose_text`), and a note says so; the arm says where
    FANUC's Z begins.

    Raises:
        OptionError: not three, six or seven quantities, or a maker's form in doubt.
        ConfigurationError: a word that is none.
    """
    made = _makers_pose(text, option, robot, deg=deg)
    if made is not None:
        return made
    words = split_values(text)
    if len(words) not in (3, 6, 7):
        raise OptionError("a pose is three lengths, then three angles or a quaternion", where=option,
                          got=f"{len(words)} numbers in {text!r}",
                          allowed="x,y,z,roll,pitch,yaw or x,y,z,qx,qy,qz,qw; for a position x,y,z [m, rad]",
                          mend=f'write it as {option}="0.3,0,0.4,180deg,0,0"')  # fmt: skip
    lengths = [value_of(word, "m", option, deg=deg) for word in words[:3]]
    if len(words) == 7:
        return lengths + [arms.quantity(word, "number", where=option) for word in words[3:]]
    turns = [value_of(word, "rad", option, deg=deg) for word in words[3:]]
    most = max((abs(turn) for turn in turns), default=0.0)
    if not deg and most > _MOST_TURN:
        say(f"note: {option}: angles up to {most:.4g} look like degrees and are read as radians; --deg reads degrees")
    return lengths + turns


def _makers_pose(text: str, option: str, robot: arms.Robot | None, *, deg: bool) -> list[float] | None:
    """The numbers of a pose in a maker's form, with notes on how it is read; None for a plain list of numbers."""
    from rankdrop.path import pose_of_text

    made = pose_of_text(text, option, deg=deg, robot=robot)
    if made is None:
        return None
    for note in made.notes:
        say(f"note: {option}: {note}")
    return made.numbers


_MOST_TURN = 4 * pi  # of a roll, pitch or yaw that is meant in rad


def numbers_of(text: str, option: str) -> list[float]:
    """Numbers separated by commas or blanks.

    Raises:
        OptionError: a word is no number.
    """
    try:
        return [float(word) for word in text.replace("−", "-").replace(",", " ").split()]
    except ValueError as error:
        raise OptionError("these are not numbers", where=option, got=repr(text), allowed="1,0,0,…") from error


def arm_section(robot: arms.Robot, task: Task, generic_rank: int, lines: dict[str, str]) -> Iterator[RenderableType]:
    """What was opened and what was assumed, before any result.

    Args:
        robot, task: the arm and its task.
        generic_rank: of the task Jacobian.
        lines: further lines of the command, label -> text.
    """
    from rich.table import Table
    from rich.text import Text

    yield Text.assemble((robot.name, "bold"), f": {robot.about}" if robot.about else "")
    grid = Table.grid(padding=(0, 2, 0, 0))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column(overflow="fold")  # a long path keeps its end
    if task.length_scale is None:
        whose = "the arm's reach"
    else:
        whose = "as given"
    source = robot.source.reference or robot.source.origin
    rows, redundancy = arms.count(task.m, "row"), robot.n - generic_rank
    facts = [
        ("chain", f"{arms.count(robot.n, 'joint')} from {robot.base} to {robot.tip}"),
        ("joints", _numbered_names([joint.name for joint in robot.variables])),
        ("task", f"{task.name} ({rows}), rank {generic_rank}, redundancy {redundancy}"),
        ("length scale", f"{task.scale(robot):.4g} m, {whose}; no family depends on it"),
        *lines.items(),
        ("source", _first_sentence(source)),
        *(("note", note) for note in text_of.notes_words(robot.notes)),
    ]
    for label, text in facts:
        if text:
            grid.add_row(label, text)
    yield grid


def _numbered_names(names: Sequence[str]) -> str:
    """The names of the joints with their numbers; empty where each name ends with its number."""
    if all(name.endswith(str(number)) for number, name in enumerate(names, start=1)):
        return ""
    return ", ".join(f"{number} {name}" for number, name in enumerate(names, start=1))


def _first_sentence(text: str) -> str:
    first = re.split(r"(?<![A-Z])\. (?=[A-Z])", text, maxsplit=1)[0]
    if first == text:
        return first
    return f"{first}."


def starts_line(starts: str, seed: int, *, limits: bool) -> dict[str, str]:
    """The label and the line that says where random starts are drawn."""
    if limits:
        where = "within the joint limits"
    else:
        where = "in the whole joint space (limits ignored)"
    return {"starts": f"{starts} {where}, seed {seed}"}


OFF = "off"
"""Of --ideal: the numbers of the file, whatever is near."""


def open_ideal(
    name: str, options: IdealOptions, tool: ToolOptions = NO_TOOL, *, intended: bool = False
) -> tuple[arms.Robot, Task, results.Idealised | None]:
    """The arm to look at, its task, and how it was made where it is an ideal one.

    Args:
        name, options, tool: as for `open_arm`; --ideal off and none at all open the arm itself.
        intended: without --ideal, take the ideal arm that the file is meant to describe, if it is near.

    Raises:
        RankdropError: as `open_arm`; this is not a tolerance.
    """
    if options.ideal in (None, OFF):
        given = None
    else:
        given = arms.read_tolerance(options.ideal)
    robot, task = open_arm(name, options, tool)
    if options.ideal is None and intended and not options.as_written:
        given = arms.intended_tolerance(robot)
    if given is None:
        return robot, task, None
    made = verbs.idealised(robot, given)
    return made.ideal, task, made


def subject(robot: arms.Robot, made: results.Idealised | None) -> str:
    """The first words of an output: whether it is about the ideal arm or the arm as written; "" where no ideal arm is
    near.
    """
    if made is not None and made.changes:
        return f"Ideal arm within {made.tolerance.text} (--ideal {OFF}: the arm as written): "
    if made is None:
        near = arms.near_ideal(robot)
    else:
        near = None
    if near is None:
        return ""
    return f"Arm as written (--ideal {near.tolerance.text}: the ideal arm near it): "


def near_line(robot: arms.Robot, made: results.Idealised | None) -> dict[str, str]:
    """The label and the line that says which ideal arm is near and what to type; empty where none is, or it was."""
    if made is None:
        near = arms.near_ideal(robot)
    else:
        near = None
    if near is None:
        return {}
    return {"near": text_of.near_line(near)}


def ideal_sections(
    made: results.Idealised | None, task: Task, families: Sequence[Family], seed: int
) -> tuple[Sequence[results.Nearby], tuple[Section, ...], tuple[Section, ...]]:
    """What the arm itself does on the families of the ideal one, and in words what was moved, and this.

    Nothing where the arm is not an ideal one.
    """
    if made is None:
        return (), (), ()
    there = verbs.nearby(made, task, families, seed=seed)
    return there, (text_of.moved_section(made),), ((text_of.there_section(there),) if there else ())


def of_ideal(verdict: Verdict, made: results.Idealised | None) -> Verdict:
    """A verdict that says that it is about the ideal arm, where it is."""
    if made is None or not made.changes:
        return verdict
    about = f"All this is said of the ideal arm within {made.tolerance.text}, not of the arm itself."
    return replace(verdict, sentence=f"{verdict.sentence} {about}")
