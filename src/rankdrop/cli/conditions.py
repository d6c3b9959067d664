"""`rankdrop conditions`: the singularity conditions of an arm, exactly.

And what a user asks beside them: is mine right, which aspect is this, what parts these two.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import (
    IDEAL,
    NO_OPTIONS,
    ArmOptions,
    Whole,
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
from rankdrop.errors import OptionError, RankdropError, RobotError
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.exact import Chain, Flags
    from rankdrop.results import Conditions, Record, Verdict
    from rankdrop.robot import Robot
    from rankdrop.task import Task
    from rankdrop.verbs import Idealised

_FILE = Annotated[str | None, Parameter(allow_leading_hyphen=True)]
_ANGLES = Annotated[str | None, Parameter(allow_leading_hyphen=True)]
_SWITCH = Parameter(negative=(), show_default=False)


@command
def conditions(
    robot: str,
    /,
    *,
    arm: ArmOptions = NO_OPTIONS,
    ideal: IDEAL = None,
    method: str = "auto",
    lengths: str = "auto",
    coranks: Whole | None = None,
    time_limit: float = 60.0,
    seed: Whole = 0,
    points: Whole = 1000,
    basic: str | None = None,
    frame: Whole | None = None,
    steps: Annotated[bool, _SWITCH] = False,
    steps_out: _FILE = None,
    special: Annotated[bool, _SWITCH] = False,
    fresh: Annotated[bool, _SWITCH] = False,
    test: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    flags: _ANGLES = None,
    from_: Annotated[str | None, Parameter(name="--from", allow_leading_hyphen=True)] = None,
    to: _ANGLES = None,
    deg: Annotated[bool, _SWITCH] = False,
    latex: _FILE = None,
    python: _FILE = None,
    c: _FILE = None,
    json: _FILE = None,
    quiet: Annotated[bool, _SWITCH] = False,
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

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        ideal: The nearest arm whose axes are exactly parallel, square and meeting, to a tolerance such as 1mm,0.5deg.
            What the arm itself does on the families of the ideal one is told.
        method: For corank 1: auto, decoupling, suppression, tree, determinant, cofactors, decomposition, reciprocity or
            singular-vector. All give the same set.
        lengths: auto, letters, numbers, or letters with their values: "a=0.635,d=120mm".
        coranks: The highest corank to derive; else all.
        time_limit: Seconds of the processor's time; what was derived by then is shown, and what is left is told.
        seed: Of every random choice.
        points: Singular configurations to find numerically, as a check; 0 for none.
        basic: With --method suppression or reciprocity: the six basic screws, 2-7 or 1,2,4-7. Else they are chosen, and
            --steps says why.
        frame: With these methods: link in whose frame the screws are taken. Else the one where they are shortest.
        steps: Print the derivation of corank 1 step by step, and the determinant of the Jacobian, or its minors, in
            factors; with it --latex, --python, --c and --json have the determinants, too.
        steps_out: Write these steps to this file, with everything that is folded on the screen written out.
        special: Derive the arms of special lengths, too: which families they have besides.
        fresh: Derive anew what is shipped for the catalogue's arms.
        test: A condition: is it exactly the singular set, too small, or too large?
        flags: A configuration: the signs of the determinant's factors there (arms without redundancy).
        from_: A configuration; with --to: which families part the two.
        to: The other configuration.
        deg: Angles of configurations without a unit are in degrees.
        latex: Write the families as a LaTeX table to this file; - for stdout in place of the text.
        python: Write them as a Python module on NumPy.
        c: Write them as a C header.
        json: Write everything as JSON.
        quiet: No progress.
    """
    from rankdrop import conditions as run
    from rankdrop.exact import exact_chain
    from rankdrop.results import steps_text

    check_targets({"--steps-out": steps_out, "--latex": latex, "--python": python, "--c": c, "--json": json})
    model, task, made = open_ideal(robot, arm, ideal)
    letters = lengths_of(lengths)
    question = Question(model, test, flags, from_, to, deg=deg)
    question.check(exact_chain(model, task, lengths=letters))
    with reporter(quiet=quiet) as report:
        found = run(
            model, task, method=method, lengths=letters, seconds=time_limit, seed=seed, points=points,
            coranks=1 if question and coranks is None else coranks, special=special,
            steps=steps or steps_out is not None, basic=None if basic is None else joints_of(basic), frame=frame,
            fresh=fresh, progress=report,
        )  # fmt: skip
    answers, answered, verdict = question.answer(found)
    verdict = of_ideal(verdict, made)
    there, moved, beside = ideal_sections(made, task, found.families, seed)

    def record() -> Record:
        nearby = {} if made is None else {
            "sentence": of_ideal(found.verdict, made).sentence, "ideal": made.to_dict(task, there),
        }  # fmt: skip
        return {**found.to_dict(), **answered, **nearby}

    hand_over(
        lambda: _print(found, task, answers, verdict, made, moved, beside),
        (steps_out, lambda target: write_text(steps_text(found), target)),
        (latex, lambda target: write_text(found.latex(), target)),
        (python, lambda target: write_text(found.code("python"), target)),
        (c, lambda target: write_text(found.code("c"), target)),
        (json, lambda target: write_json(record(), target)),
    )
    if found.interrupted:
        return exits.INTERRUPTED
    return exits.FINE if verdict.holds else exits.UNEXPLAINED


def lengths_of(text: str) -> str | dict[str, float]:
    """What --lengths says: a word, or letters with values [m].

    Raises:
        OptionError: neither.
    """
    from rankdrop.robot import quantity

    if "=" not in text:
        return text.strip()
    found = {}
    for word in text.replace(";", ",").split(","):
        name, equals, value = (part.strip() for part in word.partition("="))
        if not (name and equals and value) or name in found:
            raise OptionError(
                "this is not a list of lengths", where="--lengths", got=repr(word.strip() or text),
                allowed='each letter once, with its value: "a=0.635,d=120mm"',
            )  # fmt: skip
        try:
            found[name] = quantity(value, "length", where=f"--lengths, {name}")
        except RobotError as error:
            raise OptionError(
                error.what, where=error.where, got=error.got, allowed=error.allowed, mend=error.mend,
                typed=error.typed,
            ) from error
    return found


def joints_of(text: str) -> tuple[int, ...]:
    """What --basic says.

    Raises:
        OptionError: no numbers of joints.
    """
    from rankdrop.exact import parse_joints

    try:
        return parse_joints(text)
    except OptionError as error:
        raise OptionError(error.what, where="--basic", got=error.got, allowed=error.allowed) from error


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


@dataclass(frozen=True)
class Question:
    """The options --test, --flags, --from and --to; false where none is given.

    Attributes:
        robot: the arm.
        test: a condition.
        flags, start, end: configurations as typed.
        deg: angles without a unit are in degrees.
    """

    robot: Robot
    test: str | None
    flags: str | None
    start: str | None
    end: str | None
    deg: bool

    def __bool__(self) -> bool:
        return any(one is not None for one in (self.test, self.flags, self.start, self.end))

    def check(self, chain: Chain) -> None:
        """Refuse bad input before the derivation.

        Raises:
            OptionError: a mistake in the condition, or one of --from and --to without the other.
            ConfigurationError: not a configuration.
            TaskError: flags of an arm whose Jacobian is not square.
        """
        if not self:
            return
        from rankdrop.exact import parse_conditions, signs_of

        if self.test is not None:
            parse_conditions(self.test, chain.ring, shifts=[float(shift) for shift in chain.shifts])
        if (self.start is None) != (self.end is None):
            missing, given = ("--from", "--to") if self.start is None else ("--to", "--from")
            raise OptionError(f"{given} needs {missing}", where=missing, mend="give both configurations")
        options = (("--flags", self.flags), ("--from", self.start), ("--to", self.end))
        typed = [(option, one) for option, one in options if one is not None]
        for option, one in typed:
            self._q(one, option)
        if typed:
            signs_of(chain, names=False)

    def answer(self, conditions: Conditions) -> tuple[list[Section], Record, Verdict]:
        """From what was derived: text, entries of the JSON, the verdict on the conditions and the one asked about."""
        from rankdrop.results import of_conditions

        sections: list[Section] = []
        record: Record = {"test": None, "flags": None, "between": None}
        tested = "exact"
        if self.test is not None:
            section, record["test"], tested = _tested(conditions, self.test)
            sections.append(section)
        if self.flags is not None:
            flags = conditions.flags(self._q(self.flags))
            record["flags"] = flags.to_dict()
            sections.append(self._flags("Configuration flags", flags))
        if self.start is not None and self.end is not None:
            between = conditions.between(self._q(self.start), self._q(self.end))
            record["between"] = between.to_dict()
            sections += [self._flags("From", between.first), self._flags("To", between.second)]
            sections.append(_section("What parts them", between.sentences()))
        verdict = of_conditions(conditions, tested)
        return sections, {**record, **verdict.to_dict()}, verdict

    def _q(self, text: str, option: str = "") -> list[float]:

        return parse_configuration(text, self.robot, deg=self.deg, option=option)

    def _flags(self, title: str, flags: Flags) -> Section:
        pairs = zip(flags.q, self.robot.variables, strict=True)
        shown = [degrees(x) if self.deg and joint.unit == "rad" else x for x, joint in pairs]
        values = ", ".join(f"{round(x, 12) + 0.0:.6g}".replace("-", "−") for x in shown)
        return _section(title, flags.sentences(), f"q = ({values}) [{'°' if self.deg else 'rad'}, m]")


def _tested(conditions: Conditions, condition: str) -> tuple[Section, Record | None, str]:
    try:
        result = conditions.test(condition)
    except RankdropError as error:  # the derivation ended early: what it has is shown all the same
        return _section("Your condition", (f"not tested: {error}",), condition), None, "not tested"
    return _section("Your condition", result.sentences(), condition), result.to_dict(), result.verdict


def _section(title: str, lines: tuple[str, ...], summary: str = "") -> Section:

    return Section(title, summary, lines)
