"""`rankdrop conditions`: the singularity conditions of an arm, exactly.

Further questions: is my condition right, which aspect is this, what separates these two.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import degrees
from typing import TYPE_CHECKING, Annotated

from rankdrop import exact, formula, results, text
from rankdrop import robot as arms
from rankdrop.cli.command import PROGRESS, Done, Output, command
from rankdrop.cli.opening import (
    NO_IDEAL,
    ROBOT,
    IdealOptions,
    arm_section,
    ideal_sections,
    near_line,
    of_ideal,
    open_ideal,
    say_other_task,
    subject,
)
from rankdrop.cli.terminal import answer_lines, fit_to_console
from rankdrop.cli.values import parse_configuration
from rankdrop.errors import OptionError, RankdropError
from rankdrop.options import option
from rankdrop.questions import ConditionsOptions
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.cli.terminal import Block
    from rankdrop.families import Verdict
    from rankdrop.task import Task


@dataclass(frozen=True)
class Question(Output):
    """Questions about the conditions, and where they go."""

    TITLE = "Questions and output"
    full: Annotated[bool, option("Print every condition, lost motion, assumption and check")] = False
    test: Annotated[str | None, option("A condition: is it exactly the singular set, too small, or too large?")] = None
    flags: Annotated[
        str | None, option("A configuration: signs of the determinant's factors there (arms without redundancy)")
    ] = None
    start: Annotated[
        str | None, option("A configuration; with --to: which families separate the two", name="--from")
    ] = None
    end: Annotated[str | None, option("The other configuration", name="--to")] = None
    deg: Annotated[bool, option("Angles of configurations without a unit are in degrees")] = False
    steps_out: Annotated[
        str | None,
        option("Write the steps to this file, with all that is folded on the screen written out", writes=()),
    ] = None
    latex: Annotated[
        str | None, option("Write the families as a LaTeX table to this file; - for stdout", writes=())
    ] = None  # fmt: skip
    python: Annotated[str | None, option("Write the families as a Python module on NumPy", writes=())] = None
    c: Annotated[str | None, option("Write the families as a C header", writes=())] = None

    def __bool__(self) -> bool:
        return any(option is not None for option in (self.test, self.flags, self.start, self.end))

    def check(self, robot: arms.Robot, chain: exact.Chain) -> None:
        """Refuse bad input before the derivation.

        Raises:
            OptionError: a mistake in the condition, or one of --from and --to without the other.
            ConfigurationError: not a configuration.
            TaskError: flags of an arm with a Jacobian that is not square.
        """
        if self.test is not None:
            formula.parse_conditions(self.test, chain.ring, shifts=[float(shift) for shift in chain.whole_shifts])
        if (self.start is None) != (self.end is None):
            if self.start is None:
                missing, given = ("--from", "--to")
            else:
                missing, given = ("--to", "--from")
            raise OptionError(f"{given} needs {missing}", where=missing, mend="give both configurations")
        typed = {"--flags": self.flags, "--from": self.start, "--to": self.end}
        configurations = [self._q(robot, values, option) for option, values in typed.items() if values is not None]
        if configurations:
            exact.signs_of(chain)

    def answer(self, conditions: results.Conditions) -> tuple[list[Section], results.Record, Verdict]:
        """From what was derived: text, entries of the JSON, the verdict on the conditions and the given one."""
        sections: list[Section] = []
        record: results.Record = {"test": None, "flags": None, "between": None}
        tested, robot = "exact", conditions.robot
        if self.test is not None:
            section, record["test"], tested = _test_condition(conditions, self.test)
            sections.append(section)
        if self.flags is not None:
            flags = conditions.flags(self._q(robot, self.flags))
            record["flags"] = results.plain(flags)
            sections.append(self._flags(robot, "Configuration flags", flags))
        if self.start is not None and self.end is not None:
            between = conditions.between(self._q(robot, self.start), self._q(robot, self.end))
            record["between"] = results.plain(between)
            sections += [self._flags(robot, "From", between.first), self._flags(robot, "To", between.second)]
            sections.append(Section("What separates the two", "", between.sentences()))
        verdict = text.of_conditions(conditions, tested)
        return sections, {**record, **verdict.to_dict()}, verdict

    def _q(self, robot: arms.Robot, text: str, option: str = "") -> list[float]:
        return parse_configuration(text, robot, deg=self.deg, option=option)

    def _flags(self, robot: arms.Robot, title: str, flags: exact.Flags) -> Section:
        pairs = zip(flags.q, robot.variables, strict=True)
        shown = [degrees(x) if self.deg and joint.unit == "rad" else x for x, joint in pairs]
        values = ", ".join(f"{round(x, 12) + 0.0:.6g}".replace("-", "−") for x in shown)
        return Section(title, f"q = ({values}) [{'°' if self.deg else 'rad'}, m]", flags.sentences())


@command
def conditions(
    robot: ROBOT,
    /,
    *,
    options: ConditionsOptions = ConditionsOptions(),
    arm: IdealOptions = NO_IDEAL,
    output: Question = Question(),
    report: PROGRESS,
) -> Done:
    """Derive the singularity conditions of an arm exactly.

    Lengths are letters (a2, d4) where that is possible: the conditions hold
    for every arm of this kind; the assumptions about lengths are printed.
    With --test, --flags or --from and --to, corank 1 only is derived unless
    --coranks says otherwise.

    For example:
        rankdrop conditions pa10
        rankdrop conditions pa10 --full
        rankdrop conditions canadarm2 --steps --lengths "a=0.635,c=0.504,d=6.85"
        rankdrop conditions canadarm2 --steps --method suppression --basic 2-7 --frame 5
        rankdrop conditions puma560 --test "sin(q5)*(a3*sin(q3)+d4*cos(q3))"
        rankdrop conditions ur5 --deg --from 0,-90,60,0,80,0 --to 0,-90,-60,0,80,0
        rankdrop conditions ur5 --python ur5_singularities.py

    Exit code 0: complete and verified; 3: not complete, not verified, or the
    condition of --test is not exact; 2: bad input.
    """
    from rankdrop import conditions as run

    model, task, made = open_ideal(robot, arm, intended=True)
    say_other_task(model, task, arm)
    if output:
        output.check(model, exact.exact_chain(model, task, lengths=arms.read_lengths(options.lengths), parts=True))
    steps, coranks = options.steps or output.steps_out is not None, options.coranks or (1 if output else None)
    result = run(model, task, replace(options, steps=steps, coranks=coranks), progress=report)
    answers, answered, verdict = output.answer(result)
    verdict = of_ideal(verdict, made)
    there, moved, after = ideal_sections(made, task, result.families, options.seed)

    def record() -> results.Record:
        nearby = {} if made is None else {
            "sentence": of_ideal(result.verdict, made).sentence, "ideal": made.to_dict(task, there),
        }  # fmt: skip
        return {**result.to_dict(), **answered, **nearby}

    def blocks() -> Iterable[Block]:
        if output.full or steps:
            return whole()
        return brief()

    def brief() -> list[Block]:
        return _brief(result, task, made, verdict, answers)

    def whole() -> Iterator[Block]:
        answer = answer_lines(result.answer, verdict, subject(model, made))
        yield answer
        yield arm_section(model, task, result.generic_rank, text.arm_lines(result) | near_line(model, made))
        yield from (*moved, *result.sections()[1:], *after, *answers)
        yield answer

    return Done(
        blocks,
        {"steps_out": lambda: text.steps_text(result), "latex": result.latex, "python": lambda: result.code("python"),
         "c": lambda: result.code("c"), "json": record},
        holds=verdict.holds, complete=not result.interrupted,
    )  # fmt: skip


def _brief(
    result: results.Conditions, task: Task, made: results.Idealised | None, verdict: Verdict,
    answers: Sequence[Section],
) -> list[Block]:  # fmt: skip
    """The answer, one row per family, and what the largest families lose, in at most 40 lines."""
    model = result.robot
    about = [text.arm_line(model, task, result.generic_rank)]
    near = near_line(model, made).get("near", "")
    if near:
        about.append(f"Near: {near}")
    if made is not None and not made.changes:
        about.append(f"{made.moved}.")
    blocks: list[Block] = [answer_lines(result.answer, verdict, subject(model, made)), *answers, about]
    table = text.conditions_table(result)
    cut = [*answers[::-1], table]
    if table.rows:
        blocks.append(table)
    lost = text.lost_section(model, result.task, result.generic_rank, result.families)
    if lost is not None:
        blocks.append(lost)
    if result.left:
        left = Section("Not finished", lines=tuple(map(str, result.left)))
        blocks.append(left)
        cut = [left, *cut]
    notes = [text.assumed_line(result), text.more_line(None if result.anew else result.seconds)]
    blocks.append([note for note in notes if note])
    long = [section for section in cut if section.rows or section.lines]
    return fit_to_console(blocks, optional=[] if lost is None else [lost], cut=long)


def _test_condition(conditions: results.Conditions, condition: str) -> tuple[Section, results.Record | None, str]:
    try:
        result = conditions.test(condition)
    except RankdropError as error:  # the derivation ended early: what it has is shown all the same
        return Section("Your condition", condition, (f"not tested: {error}",)), None, "not tested"
    return Section("Your condition", condition, result.sentences()), results.plain(result), result.verdict
