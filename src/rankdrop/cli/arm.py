"""The options by which every command opens an arm, or the ideal one near it, and the lines that say what was assumed.

And what else they read alike: whole numbers (1.5 is refused, not rounded), and one configuration, --q 0,0.5,pi/2 (rad
and m) or with --deg.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter, Token

from rankdrop.errors import ConfigurationError, OptionError, RobotError

if TYPE_CHECKING:
    from rich.console import RenderableType

    from rankdrop.results import Verdict
    from rankdrop.robot import Robot
    from rankdrop.sections import Section
    from rankdrop.task import Task
    from rankdrop.verbs import Idealised, Nearby, Side


_SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")
_AS_TYPED = str.maketrans({"−": "-", "–": "-", "π": "pi", "{": " ", "}": " "})  # as copied from what is printed


def parse_configuration(text: str, robot: Robot, *, deg: bool, option: str = "--q") -> list[float]:
    """The joint values that a text writes, one per joint, in rad and m.

    Numbers are separated by commas, semicolons or blanks; each is arithmetic with pi and sqrt, and may carry a unit
    (deg, rad, m, mm …). A number without a unit is in rad, or in degrees with `deg`; slides are in m. The signs − and
    π are understood: what was printed can be pasted.

    Raises:
        ConfigurationError: not one number for each joint, or a word that is no number.
    """
    words = split_values(text)
    joints = robot.variables
    if len(words) != len(joints):
        raise ConfigurationError(
            f"{len(joints)} joint values are needed", where=option, got=f"{len(words)} in {text!r}",
            allowed=", ".join(f"{joint.name} [{_unit(joint.unit, deg=deg)}]" for joint in joints),
            mend=f'write them as {option}="0,0.5,…"',
        )  # fmt: skip
    return [
        value_of(word, joint.unit, f"{option}, joint {joint.name}", deg=deg)
        for word, joint in zip(words, joints, strict=True)
    ]


def split_values(text: str) -> list[str]:
    """The words of a list of quantities, however it is bracketed and separated."""
    body = _without_brackets(text.translate(_AS_TYPED).strip()).strip().rstrip(",;")
    return _SEPARATOR.split(body) if body else []


def _without_brackets(text: str) -> str:
    """[…] and (…) around the whole list, not those of the first and the last number."""
    if text[:1] == "[" and text[-1:] == "]":
        return text[1:-1]
    if text[:1] != "(" or text[-1:] != ")":
        return text
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0:
            return text[1:-1] if place == len(text) - 1 else text
    return text


def _unit(unit: str, *, deg: bool) -> str:
    return "deg" if deg and unit == "rad" else unit


def value_of(word: str, unit: str, where: str, *, deg: bool) -> float:
    """One quantity in rad or m; an angle without a unit is in degrees with `deg`.

    Raises:
        ConfigurationError: it is none.
    """
    from rankdrop.robot import quantity

    try:
        value = quantity(word, "length" if unit == "m" else "angle", where=where)
    except RobotError as error:
        raise ConfigurationError(
            error.what, where=error.where, got=error.got, allowed=error.allowed, mend=error.mend,
            typed=error.typed,
        ) from error
    plain = not re.search(r"(deg|rad|°)$", word)
    return radians(value) if deg and unit == "rad" and plain else value


def parse_speeds(text: str | None, option: str = "--speed") -> dict[str, float]:
    """Speeds of the tool below which a motion is slow, by the names that `explain` has for them [m/s, rad/s].

    Raises:
        OptionError: not one speed, or a translation and a rotation, each with its unit.
    """
    from rankdrop.robot import quantity

    if text is None:
        return {}
    if text.strip() == "0":
        return {"speed": 0.0, "turn_speed": 0.0}
    found: dict[str, float] = {}
    for part in text.split(","):
        turns = re.search(r"(deg|rad|°)\s*/s\s*$", part) is not None
        name, measure = ("turn_speed", "angle") if turns else ("speed", "length")
        allowed = "a translation, a rotation or both, such as 250mm/s,20deg/s; 0 for none"
        if name in found or not part.strip().endswith("/s"):
            raise OptionError("this is not a speed of the tool", where=option, got=repr(text), allowed=allowed)
        found[name] = quantity(part.strip().removesuffix("/s").strip(), measure, where=option)
    return found


@Parameter(name="*")
@dataclass(frozen=True, slots=True)
class ArmOptions:
    """Which part of the arm, for which task.

    Attributes:
        task: pose, position, orientation, planar, planar-position, scara, or rows (vx,vy,wz). Default: the arm's own.
        base: First link of the chain (robot files).
        tip: Last link of the chain (robot files).
        length_scale: Translation rows are divided by this length [m], else by the reach. No family, exact or not,
            depends on it.
        as_written: Keep the file's numbers: 1.5708 is not a right angle then, nor noise of 2e-5 rad and 2 µm none.
        package: NAME=PATH: where package://NAME and $(find NAME) are, if not near the file. May be given again.
        arg: NAME:=VALUE: an argument of a xacro file. May be given again.
        xacro: Expand the file though it does not end in .xacro. Expanding can run any command: trust the file.
    """

    task: str | None = None
    base: str | None = None
    tip: str | None = None
    length_scale: float | None = None
    as_written: Annotated[bool, Parameter(negative=())] = False
    package: Annotated[tuple[str, ...], Parameter(negative=(), show_default=False)] = ()
    arg: Annotated[tuple[str, ...], Parameter(negative=(), show_default=False)] = ()
    xacro: Annotated[bool, Parameter(negative=(), show_default=False)] = False


NO_OPTIONS = ArmOptions()
IDEAL = Annotated[str | None, Parameter(allow_leading_hyphen=True, show_default=False)]
FRAME = Literal["base", "tool", "link"] | None
TCP = Annotated[str | None, Parameter(allow_leading_hyphen=True, show_default=False)]


def open_arm(name: str, options: ArmOptions, tcp: str | None = None, *, deg: bool = False) -> tuple[Robot, Task]:
    """Open the arm and resolve its task.

    Args:
        name: in the catalogue, or a file.
        options: which part of it, for which task.
        tcp: the tool point, as typed; None for the arm's own tip.
        deg: its angles without a unit are in degrees.

    Raises:
        RankdropError: the arm or the task does not exist, a package is not NAME=PATH, an argument not NAME:=VALUE, the
            tool point not three or six quantities.
    """
    from rankdrop.robot import open_robot, with_tool
    from rankdrop.task import resolve_task

    robot = open_robot(
        name, tip=options.tip, base=options.base, packages=_packages(options.package), args=_arguments(options.arg),
        xacro=options.xacro, as_written=options.as_written,
    )  # fmt: skip
    if tcp is not None:
        robot = with_tool(robot, *_tool(tcp, deg=deg))
    return robot, resolve_task(options.task, robot, length_scale=options.length_scale)


def _tool(text: str, *, deg: bool) -> tuple[list[float], list[float]]:
    """x, y, z [m] and roll, pitch, yaw [rad] of a tool point."""
    from rankdrop.cli.arm import split_values, value_of

    words = split_values(text)
    if len(words) not in (3, 6):
        raise OptionError("a tool point is three lengths, then three angles if the tool is turned", where="--tcp",
                          got=f"{len(words)} numbers in {text!r}", allowed="x,y,z or x,y,z,roll,pitch,yaw [m, rad]",
                          mend='write it as --tcp="0,0,120mm"')  # fmt: skip
    return (
        [value_of(word, "m", "--tcp", deg=deg) for word in words[:3]],
        [value_of(word, "rad", "--tcp", deg=deg) for word in words[3:]] or [0.0, 0.0, 0.0],
    )


def packages_of(options: ArmOptions) -> dict[str, Path]:
    """Package name -> folder, as given.

    Raises:
        OptionError: a package is not NAME=PATH, or there is no such folder.
    """
    return _packages(options.package) or {}


def arguments_of(options: ArmOptions) -> dict[str, str]:
    """Arguments of a xacro file, name -> value, as given.

    Raises:
        OptionError: an argument is not NAME:=VALUE, or given twice.
    """
    return _arguments(options.arg)


def _packages(words: tuple[str, ...]) -> dict[str, Path] | None:
    packages = {}
    for word in words:
        name, equals, path = word.partition("=")
        if not (name and equals and path):
            raise OptionError("this is not a package", where="--package", got=repr(word), allowed="NAME=PATH")
        if not Path(path).is_dir():
            raise OptionError("there is no such folder", where=f"--package {name}", got=path)
        packages[name] = Path(path)
    return packages or None


def _arguments(words: tuple[str, ...]) -> dict[str, str]:
    arguments = {}
    for word in words:
        name, sign, value = word.partition(":=")
        if not (name and sign):
            raise OptionError("this is not an argument", where="--arg", got=repr(word), allowed="NAME:=VALUE")
        if name in arguments:
            raise OptionError("the argument is given twice", where="--arg", got=name, mend="give it once")
        arguments[name] = value
    return arguments


def arm_section(robot: Robot, task: Task, generic_rank: int, lines: dict[str, str]) -> Iterator[RenderableType]:
    """What was opened and what was assumed, before any result.

    Args:
        robot, task: the arm and its task.
        generic_rank: of the task Jacobian.
        lines: further lines of the command, label -> text.
    """
    from rich.table import Table
    from rich.text import Text

    from rankdrop.robot import count

    yield Text.assemble((robot.name, "bold"), f": {robot.about}" if robot.about else "")
    grid = Table.grid(padding=(0, 2, 0, 0))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column(overflow="fold")  # a long path keeps its end
    grid.add_row("chain", f"{count(robot.n, 'joint')} from {robot.base} to {robot.tip}")
    names = [joint.name for joint in robot.variables]
    if not all(name.endswith(str(number)) for number, name in enumerate(names, start=1)):
        grid.add_row("joints", ", ".join(f"{number} {name}" for number, name in enumerate(names, start=1)))
    freedom = robot.n - generic_rank
    grid.add_row("task", f"{task.name} ({count(task.m, 'row')}), rank {generic_rank}, redundancy {freedom}")
    whose = "the arm's reach" if task.length_scale is None else "as given"
    grid.add_row("length scale", f"{task.scale(robot):.4g} m, {whose}; no family depends on it")
    for label, text in lines.items():
        grid.add_row(label, text)
    source = robot.source.reference or robot.source.origin
    if source:
        grid.add_row("source", _first_sentence(source))
    for note in robot.notes:
        grid.add_row("note", note)
    yield grid


def _first_sentence(text: str) -> str:
    """Where numbers come from; how they were compared stands in the JSON of an analysis."""
    first = re.split(r"(?<![A-Z])\. (?=[A-Z])", text, maxsplit=1)[0]
    return first if first == text else f"{first}."


def open_ideal(
    name: str, options: ArmOptions, tolerance: str | None, tcp: str | None = None, *, deg: bool = False
) -> tuple[Robot, Task, Idealised | None]:
    """The arm to look at, its task, and how it was made where it is an ideal one.

    Raises:
        RankdropError: as `open_arm`; this is not a tolerance.
    """
    if tolerance is None:
        return *open_arm(name, options, tcp, deg=deg), None
    from rankdrop.robot import read_tolerance
    from rankdrop.verbs import idealised

    given = read_tolerance(tolerance)
    robot, task = open_arm(name, options, tcp, deg=deg)
    found = idealised(robot, given)
    return found.ideal, task, found


def near_line(robot: Robot, asked: Idealised | None) -> dict[str, str]:
    """The label and the line that says which ideal arm is near and what to type; empty where none is, or it was."""
    from rankdrop.robot import near_ideal

    found = near_ideal(robot) if asked is None else None
    return {} if found is None else {"near": found.line}


def ideal_sections(
    made: Idealised | None, task: Task, families: Sequence[Side], seed: int
) -> tuple[Sequence[Nearby], tuple[Section, ...], tuple[Section, ...]]:
    """What the arm itself does on the families of the ideal one, and in words what was moved, and this.

    Nothing where the arm is not an ideal one.
    """
    if made is None:
        return (), (), ()
    from rankdrop.verbs import moved_section, nearby, there_section

    there = nearby(made, task, families, seed=seed)
    return there, (moved_section(made),), ((there_section(there),) if there else ())


def of_ideal(verdict: Verdict, asked: Idealised | None) -> Verdict:
    """A verdict that says that it is about the ideal arm, where it is."""
    from dataclasses import replace

    if asked is None or not asked.changes:
        return verdict
    about = f"All this is said of the ideal arm within {asked.tolerance.text}, not of the arm itself."
    return replace(verdict, sentence=f"{verdict.sentence} {about}")


_WHOLE = re.compile(r"[+-]?\d+(_\d+)*", re.ASCII)
_LONGEST_NUMBER = 100


def whole(_type: Any, tokens: Sequence[Token]) -> int:
    """The number that the words of one option write: 10000, 10_000, -5.

    Raises:
        ValueError: not a whole number; cyclopts names the option.
    """
    text = tokens[0].value.strip()
    if not _WHOLE.fullmatch(text) or len(text) > _LONGEST_NUMBER:
        raise ValueError(f"this is not a whole number; got {text[:40]!r}; allowed: digits, such as 10000 or 10_000.")
    return int(text)


Whole = Annotated[int, Parameter(converter=whole)]
