"""`rankdrop conditions`: the singularity conditions of an arm, exactly.

And what a user asks beside them: is mine right, which aspect is this, what parts these two.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import degrees
from typing import TYPE_CHECKING, Annotated

from rankdrop.cli import exits
from rankdrop.cli.arm import (
    NO_IDEAL,
    ROBOT,
    IdealOptions,
    Output,
    arm_section,
    command,
    ideal_sections,
    near_line,
    of_ideal,
    open_ideal,
    parse_configuration,
)
from rankdrop.cli.terminal import (
    INDENT,
    check_targets,
    hand_over,
    print_sections,
    reporter,
    results,
    show,
    verdict_line,
    write_json,
    write_text,
)
from rankdrop.errors import OptionError, RankdropError
from rankdrop.options import option
from rankdrop.questions import ConditionsOptions
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.exact import Chain, Flags
    from rankdrop.results import Conditions, Record, Verdict
    from rankdrop.robot import Robot
    from rankdrop.task import Task
    from rankdrop.verbs import Idealised


@dataclass(frozen=True)
class Question(Output):
    """What is asked of the conditions, and where they go."""

    TITLE = "Questions and output"
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
        str | None, option("Write the steps to this file, with all that is folded on the screen written out")
    ] = None
    latex: Annotated[str | None, option("Write the families as a LaTeX table to this file; - for stdout")] = None
    python: Annotated[str | None, option("Write the families as a Python module on NumPy")] = None
    c: Annotated[str | None, option("Write the families as a C header")] = None

    def __bool__(self) -> bool:
        return any(one is not None for one in (self.test, self.flags, self.start, self.end))

    def check(self, robot: Robot, chain: Chain) -> None:
        """Refuse bad input before the derivation.

        Raises:
            OptionError: a mistake in the condition, or one of --from and --to without the other.
            ConfigurationError: not a configuration.
            TaskError: flags of an arm whose Jacobian is not square.
        """
        from rankdrop.exact import parse_conditions, signs_of

        if self.test is not None:
            parse_conditions(self.test, chain.ring, shifts=[float(shift) for shift in chain.shifts])
        if (self.start is None) != (self.end is None):
            missing, given = ("--from", "--to") if self.start is None else ("--to", "--from")
            raise OptionError(f"{given} needs {missing}", where=missing, mend="give both configurations")
        typed = {"--flags": self.flags, "--from": self.start, "--to": self.end}
        configurations = [self._q(robot, one, option) for option, one in typed.items() if one is not None]
        if configurations:
            signs_of(chain, names=False)

    def answer(self, conditions: Conditions) -> tuple[list[Section], Record, Verdict]:
        """From what was derived: text, entries of the JSON, the verdict on the conditions and the one asked about."""
        from rankdrop.codec import plain
        from rankdrop.results import of_conditions

        sections: list[Section] = []
        record: Record = {"test": None, "flags": None, "between": None}
        tested, robot = "exact", conditions.robot
        if self.test is not None:
            section, record["test"], tested = _tested(conditions, self.test)
            sections.append(section)
        if self.flags is not None:
            flags = conditions.flags(self._q(robot, self.flags))
            record["flags"] = plain(flags)
            sections.append(self._flags(robot, "Configuration flags", flags))
        if self.start is not None and self.end is not None:
            between = conditions.between(self._q(robot, self.start), self._q(robot, self.end))
            record["between"] = plain(between)
            sections += [self._flags(robot, "From", between.first), self._flags(robot, "To", between.second)]
            sections.append(Section("What parts them", "", between.sentences()))
        verdict = of_conditions(conditions, tested)
        return sections, {**record, **verdict.to_dict()}, verdict

    def _q(self, robot: Robot, text: str, option: str = "") -> list[float]:
        return parse_configuration(text, robot, deg=self.deg, option=option)

    def _flags(self, robot: Robot, title: str, flags: Flags) -> Section:
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
) -> int:
    """Derive the singularity conditions of an arm exactly.

    Lengths are letters (a2, d4) where that is possible: the conditions hold
    for every arm of this kind, and what is assumed of the lengths is told.
    With --test, --flags or --from and --to, corank 1 only is derived unless
    --coranks says otherwise.

    For example:
        rankdrop conditions pa10
        rankdrop conditions canadarm2 --steps --lengths "a=0.635,c=0.504,d=6.85"
        rankdrop conditions canadarm2 --steps --method suppression --basic 2-7 --frame 5
        rankdrop conditions puma560 --test "sin(q5)*(a3*sin(q3)+d4*cos(q3))"
        rankdrop conditions ur5 --deg --from 0,-90,60,0,80,0 --to 0,-90,-60,0,80,0
        rankdrop conditions ur5 --python ur5_singularities.py

    Exit code 0: complete and verified; 3: not complete, not verified, or the
    condition of --test is not exact; 2: bad input.
    """
    from rankdrop import conditions as run
    from rankdrop.exact import exact_chain
    from rankdrop.results import steps_text
    from rankdrop.robot import read_lengths

    check_targets({"--steps-out": output.steps_out, "--latex": output.latex, "--python": output.python,
                   "--c": output.c, "--json": output.json})  # fmt: skip
    model, task, made = open_ideal(robot, arm, arm.ideal)
    if output:
        output.check(model, exact_chain(model, task, lengths=read_lengths(options.lengths)))
    steps, coranks = options.steps or output.steps_out is not None, options.coranks or (1 if output else None)
    with reporter(quiet=output.quiet) as report:
        found = run(model, task, replace(options, steps=steps, coranks=coranks), progress=report)
    answers, answered, verdict = output.answer(found)
    verdict = of_ideal(verdict, made)
    there, moved, beside = ideal_sections(made, task, found.families, options.seed)

    def record() -> Record:
        nearby = {} if made is None else {
            "sentence": of_ideal(found.verdict, made).sentence, "ideal": made.to_dict(task, there),
        }  # fmt: skip
        return {**found.to_dict(), **answered, **nearby}

    hand_over(
        lambda: _print(found, task, answers, verdict, made, moved, beside),
        (output.steps_out, lambda target: write_text(steps_text(found), target)),
        (output.latex, lambda target: write_text(found.latex(), target)),
        (output.python, lambda target: write_text(found.code("python"), target)),
        (output.c, lambda target: write_text(found.code("c"), target)),
        (output.json, lambda target: write_json(record(), target)),
    )
    if found.interrupted:
        return exits.INTERRUPTED
    return exits.FINE if verdict.holds else exits.UNEXPLAINED


def _print(
    conditions: Conditions, task: Task, answers: Sequence[Section], verdict: Verdict, made: Idealised | None,
    moved: Sequence[Section], beside: Sequence[Section],
) -> None:  # fmt: skip
    from rankdrop.results import arm_lines

    console = results()
    line = verdict_line(verdict)
    show(console, [line, ""])
    show(
        console,
        arm_section(
            conditions.robot, task, conditions.generic_rank, arm_lines(conditions) | near_line(conditions.robot, made)
        ),
    )
    print_sections((*moved, *conditions.sections(width=console.width - INDENT), *beside, *answers), first=False)
    show(console, ["", line])


def _tested(conditions: Conditions, condition: str) -> tuple[Section, Record | None, str]:
    from rankdrop.codec import plain

    try:
        result = conditions.test(condition)
    except RankdropError as error:  # the derivation ended early: what it has is shown all the same
        return Section("Your condition", condition, (f"not tested: {error}",)), None, "not tested"
    return Section("Your condition", condition, result.sentences()), plain(result), result.verdict
