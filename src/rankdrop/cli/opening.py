"""Which arm does a command open, for which task, and what was assumed?

The arm as its options say, or the ideal one near it; the lines above every result say what was opened.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from cyclopts import Parameter

from rankdrop import robot as arms
from rankdrop import text as text_of
from rankdrop import verbs
from rankdrop.cli.terminal import say
from rankdrop.cli.values import split_values, value_of
from rankdrop.errors import OptionError
from rankdrop.named_tasks import task_names
from rankdrop.options import Options, option
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rich.console import RenderableType

    from rankdrop import results
    from rankdrop.families import Family, Verdict
    from rankdrop.task import Task

_LONGEST_TOOL = 10.0  # [m]
TASKS = f"{', '.join(task_names())}, or rows: vx,vy,wz"
"""What `--task` takes."""

ROBOT_FILES = ", ".join(arms.format_endings())
ROBOT_HELP = f"Name in the catalogue (`rankdrop robots`) or a file ({ROBOT_FILES})."
ROBOT = Annotated[str, Parameter(help=ROBOT_HELP)]

OFF = "off"
"""Of --ideal: the numbers of the file, whatever is near."""


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
NO_OPTIONS, NO_IDEAL, NO_TOOL = ArmOptions(), IdealOptions(), ToolOptions()


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


def say_other_task(robot: arms.Robot, task: Task, options: ArmOptions) -> None:
    """Tell of an arm with too few joints for a pose that another task is the one to ask about, where none was named."""
    if options.task is not None or robot.n >= task.m:
        return
    note = text_of.other_task_note(robot, task)
    if note:
        say(f"note: {note}")


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
    idealised = verbs.idealised(robot, given)
    return idealised.ideal, task, idealised


def subject(robot: arms.Robot, idealised: results.Idealised | None) -> str:
    """The first words of an output: whether it is about the ideal arm or the arm as written; "" where no ideal arm is
    near.
    """
    if idealised is not None and idealised.changes:
        return f"Ideal arm within {idealised.tolerance.text} (--ideal {OFF}: the arm as written): "
    if idealised is None:
        near = arms.near_ideal(robot)
    else:
        near = None
    if near is None:
        return ""
    return f"Arm as written (--ideal {near.tolerance.text}: the ideal arm near it): "


def near_line(robot: arms.Robot, idealised: results.Idealised | None) -> dict[str, str]:
    """The label and the line that says which ideal arm is near and what to type; empty where none is, or it was."""
    if idealised is None:
        near = arms.near_ideal(robot)
    else:
        near = None
    if near is None:
        return {}
    return {"near": text_of.near_line(near)}


def ideal_sections(
    idealised: results.Idealised | None, task: Task, families: Sequence[Family], seed: int
) -> tuple[Sequence[results.Nearby], tuple[Section, ...], tuple[Section, ...]]:
    """What the arm itself does on the families of the ideal one, and in words what was moved, and this.

    Nothing where the arm is not an ideal one.
    """
    if idealised is None:
        return (), (), ()
    there = verbs.nearby(idealised, task, families, seed=seed)
    return there, (text_of.moved_section(idealised),), ((text_of.there_section(there),) if there else ())


def of_ideal(verdict: Verdict, idealised: results.Idealised | None) -> Verdict:
    """A verdict that says that it is about the ideal arm, where it is."""
    if idealised is None or not idealised.changes:
        return verdict
    about = f"All this is said of the ideal arm within {idealised.tolerance.text}, not of the arm itself."
    return replace(verdict, sentence=f"{verdict.sentence} {about}")
