"""The result of an exact derivation: a frozen record that goes to JSON and code, and shows itself as text.

As plain data it has the names of docs/json.md.

Exact conditions in words: what was derived and how, families by corank, assumptions, checks.

Long lines on several: sentences between words, formulas where a reader breaks them.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from math import degrees
from typing import TYPE_CHECKING, ClassVar

from numpy.typing import ArrayLike

from rankdrop.codec import Result
from rankdrop.errors import OptionError
from rankdrop.exact.algebra.work import SLOWER, OutOfTime, Work
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.family import Assumption, ExactFamily
from rankdrop.exact.notation import Step
from rankdrop.family.equation import pretty_angle
from rankdrop.family.record import Check
from rankdrop.results.verdict import Verdict, of_conditions
from rankdrop.robot.model import Robot, lost_told, witness_text
from rankdrop.sections import Section, html
from rankdrop.sections import text as plain_text
from rankdrop.task import Task

if TYPE_CHECKING:
    from rankdrop.exact.aspects import Between, Flags
    from rankdrop.exact.code import Code
    from rankdrop.exact.determinants import Determinants
    from rankdrop.exact.lint import LintResult


_BREAKS = tuple(re.compile(text) for text in (r"(?<=[,;]) ", r" (?=[+−=≠] (?!0$))", r" (?=\()", r" (?== 0$)"))
"""Places for a break, the better kinds first."""
_HANG = 4
_WORD = re.compile(r"\b[a-z]{4,}\b")
_WORDS = 4  # so many words make a sentence


def either(line: str, width: int | None) -> list[str]:
    """A line of which is not known whether it is a sentence or a formula."""
    return sentence(line, width, _HANG) if len(_WORD.findall(line)) >= _WORDS else formula(line, width)


def formula(line: str, width: int | None) -> list[str]:
    """A formula in pieces of at most `width` characters, where its words allow that.

    It is broken before a sign or a bracket, outside of as many brackets as can be had; the rest is indented.

    Args:
        line: blanks before it are an indent.
        width: characters in a line; None for as many as there are.

    Example:
        >>> formula("a2 c2 + a3 (c23 + s23) = 0", 24)
        ['a2 c2', '    + a3 (c23 + s23) = 0']
    """
    if width is None or len(line) <= width:
        return [line]
    indent = len(line) - len(line.lstrip(" "))
    found, rest, inset = [], line.strip(), indent
    while len(rest) > max(width - inset, 20):
        place = _place(rest, max(width - inset, 20))
        found.append(" " * inset + rest[:place].rstrip())
        rest, inset = rest[place:].lstrip(), indent + _HANG
    return [*found, " " * inset + rest]


def sentence(line: str, width: int | None, hang: int = 0) -> list[str]:
    """A line of words in pieces of at most `width` characters; all but the first are indented by `hang` more."""
    indent = len(line) - len(line.lstrip(" "))
    if width is None or len(line) <= width:
        return [line]
    return textwrap.wrap(
        line.strip(), max(width, indent + hang + 20), initial_indent=" " * indent,
        subsequent_indent=" " * (indent + hang), break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _place(text: str, room: int) -> int:
    """Where to break: at the shallowest place that is not right at the beginning, else at a blank, else at the end."""
    depths = list(_depths(text))
    places = [(m.start(), kind) for kind, one in enumerate(_BREAKS) for m in one.finditer(text) if m.start() <= room]
    late = [(place, kind) for place, kind in places if place > room // 5] or places
    if late:
        return min(late, key=lambda found: (depths[found[0]], found[1], -found[0]))[0]
    blanks = [i for i, letter in enumerate(text) if letter == " " and 0 < i <= room]
    return blanks[-1] if blanks else next((i for i, letter in enumerate(text) if letter == " "), len(text))


def _depths(text: str) -> Iterator[int]:
    """How many brackets are open before each character."""
    depth = 0
    for letter in text:
        yield depth
        depth += (letter == "(") - (letter == ")")


_TOGETHER = 64  # characters up to which all conditions of a family stand on one line
_LONGEST = 600  # a longer condition is for programs
_UNDERIVED = 3  # assumptions on lengths whose failing was not derived of which more are only counted
_ALIKE = 2  # sets that are not real for the same reason of which more are only counted
_LEGEND = "s_i is sin θi, c_i is cos θi, c_ij is cos(θi + θj); angles are meant modulo 2π"
METHOD = {"suppression": "dependent-screw suppression", "singular-vector": "the singular vector"} | {
    name: f"the {name} method" for name in ("determinant", "cofactors", "reciprocity")
}
"""What methods are called in a sentence, where it is not their own name."""
_ROUNDED = re.compile(r"\d\.\d{5}|\de[−-]\d")
_DIGITS = re.compile(r"\d{8}")
_INSET = " " * 7  # below the mark of a family
_UNEQUAL = re.compile(r"(\w+) ≠ (−?)(\w+)")


def arm_lines(conditions: Conditions) -> dict[str, str]:
    """What was assumed of the arm, label -> text."""
    lines = {}
    letters = ", ".join(f"{name} = {_number(value)} m" for name, value in conditions.letters.items())
    lines["lengths"] = letters or "as numbers"
    shifted = [
        f"θ{j} = q{j} {'−' if shift < 0 else '+'} {pretty_angle(abs(shift))}"
        for j, shift in enumerate(conditions.shifts, 1)
        if shift and conditions.robot.variables[j - 1].unit == "rad"
    ]
    if shifted:
        lines["angles"] = ", ".join(shifted) + ("; else θ = q" if len(shifted) < conditions.robot.n else "")
    if conditions.generic_rank < conditions.task.m:
        rank, rows = conditions.generic_rank, conditions.task.m
        lines["always"] = f"rank {rank} at most, for {rows} rows of the task; coranks are counted from {rank}"
    if conditions.remarks:
        lines["remarks"] = "\n".join(conditions.remarks)
    told = "; ".join(
        part for part in conditions.reason.split("; ") if not any(one in part for one in conditions.remarks)
    )
    reason = _reason(told)
    other = (
        "" if conditions.method == "tree" else f"; corank 1 also by {METHOD.get(conditions.method, conditions.method)}"
    )
    lines["method"] = f"rank tree{other}{reason}"
    return lines


_PLAIN = 16  # words of a reason that fits into the sentence


def _reason(told: str) -> str:
    """Why these methods: in parentheses where it is short, else as sentences of their own."""
    if len(told.split()) <= _PLAIN:
        return f" ({told})" if told else ""
    sentences = []
    for part in told.split("; "):
        first, *rest = part.split(": ")
        sentences += [": ".join([first, *rest[:1]]), *rest[1:]]
    return "".join(f". {one[0].upper()}{one[1:]}" for one in sentences) + "."


def sections_of(conditions: Conditions, *, width: int | None = None, families: bool = True) -> tuple[Section, ...]:
    """Derivation step by step where it was asked for, families, assumptions, sets that are not real, checks.

    Args:
        conditions: what was derived.
        width: characters in a line of a formula; None for as many as it has.
        families: False leaves out the families, of coranks that have any.
    """
    parts = (_steps, _determinants, *((_coranks,) if families else ()), _no_coranks, _assumed, _not_real, _checks,
             _unfinished)  # fmt: skip
    sections = (section for part in parts for section in part(conditions, width))
    return tuple(
        replace(one, lines=tuple(piece for line in one.lines for piece in sentence(line, width))) for one in sections
    )


def _steps(conditions: Conditions, width: int | None) -> Iterator[Section]:
    if conditions.settings.steps:
        for number, step in enumerate(conditions.steps):
            summary = f"derivation of corank 1, {conditions.method}" if number == 0 else ""
            yield Section(step.title, summary, tuple(piece for line in step.lines for piece in either(line, width)))


def _determinants(conditions: Conditions, width: int | None) -> Iterator[Section]:
    if conditions.determinants is not None:
        said = conditions.determinants
        title = "Determinant" if len(said.minors) == 1 or said.product else "Minors"
        lines = [piece for line in said.lines() for piece in either(line, width)]
        folded = any(step.whole for step in conditions.steps) or said.folded()
        notes = ("what is folded here is whole with --steps-out and --json",) if folded else ()
        yield Section(title, "", tuple(lines), notes=notes)


def steps_text(conditions: Conditions) -> str:
    """The derivation of corank 1 and the determinants with everything written out, unwrapped."""
    blocks = [[step.title, *(f"  {line}" for line in step.whole or step.lines)] for step in conditions.steps]
    if conditions.determinants is not None:
        blocks.append(["Determinants", *(f"  {line}" for line in conditions.determinants.lines(None))])
    head = [f"{conditions.robot.name}: derivation of corank 1, {conditions.method}", _LEGEND]
    return "\n\n".join("\n".join(block) for block in [head, *blocks]) + "\n"


def _coranks(conditions: Conditions, width: int | None) -> Iterator[Section]:
    r = conditions.generic_rank
    for corank in range(1, _highest(conditions) + 1):
        rows = conditions.of_corank(corank)
        lines = [line for family in rows for line in _family(family, conditions.robot, width)]
        count = f"{len(rows)} {'family' if len(rows) == 1 else 'families'}" if rows else _none(conditions)
        if rows and not conditions.complete:
            count += " so far"
        yield Section(f"Corank {corank}", f"rank {r - corank} of {r}: {count}", tuple(lines))


def _highest(conditions: Conditions) -> int:
    return max((family.corank for family in conditions.families), default=0)


def _no_coranks(conditions: Conditions, _width: int | None) -> Iterator[Section]:
    r = conditions.generic_rank
    last, highest = r - conditions.lowest, _highest(conditions)
    if highest < last:
        between = "and" if highest + 2 == last else "to"
        name = f"Corank {last}" if highest + 1 == last else f"Coranks {highest + 1} {between} {last}"
        yield Section(name, _none(conditions))
    texts = [text for family in conditions.families for text in family.texts[len(family.pins) :]]
    notes = [_LEGEND] if texts else []
    lost = lost_told(conditions.robot, [words for family in conditions.families for words in family.lost_words])
    notes += [lost] * bool(lost)
    if any(_ROUNDED.search(text) for text in texts):
        notes.append("decimals are shown with six digits; --python, --c and --json have all of them")
    if last < r:
        notes.append(f"nothing is said about coranks above {last}: they were not asked for")
    if notes:
        yield Section("", "", notes=tuple(notes))


def _none(conditions: Conditions) -> str:
    if not conditions.complete:
        return "no family so far; the derivation is not complete"
    return "no family" if conditions.verified else "none derived, and a check says otherwise: see the first line"


def _family(family: ExactFamily, robot: Robot, width: int | None) -> Iterator[str]:
    yield from sentence(f"{family.id}  {family.name}", width, len(_INSET))
    yield from (piece for line in condition_lines(family) for piece in either(f"{_INSET}{line}", width))
    shifted = {pin.joint for pin in family.pins if family.shifts[pin.joint - 1]}
    if shifted:
        own = [one for one in family.pinned(robot) if one.number in shifted]
        told = "; ".join(f"q{one.number} = {values_in_degrees(robot, one.number, one.values)}" for one in own)
        yield from sentence(f"{_INSET}the joint's own value: {told}", width, len(_INSET))
    if family.reality:
        yield from formula(f"{_INSET}{family.reality}; here it is", width)
    yield f"{_INSET}dimension {family.dimension}, codimension {family.codimension}"
    for words in family.lost_words:
        told = words if words.startswith("can only") else f"lost: {words.removeprefix('cannot ')}"
        yield from sentence(f"{_INSET}{told}", width, len("lost: "))
    if any("witness" in words for words in family.lost_words):
        yield from sentence(f"{_INSET}witness: {witness_text(robot, family.witness)}", width, len("witness: "))


def values_in_degrees(robot: Robot, number: int, values: Sequence[float]) -> str:
    """ "0 or π", "−26.76° or 153.24°", "0.25 m"."""
    if robot.variables[number - 1].unit != "rad":
        return " or ".join(f"{value:.6g} m".replace("-", "−") for value in values)
    told = [pretty_angle(value) for value in values]
    plain = [one if "π" in one or one == "0" else f"{degrees(x):.2f}°" for one, x in zip(told, values, strict=True)]
    return " or ".join(plain).replace("-", "−")


def condition_lines(family: ExactFamily) -> list[str]:
    """The conditions: simple angles together, then one equation after the other; all on one line where they fit."""
    parts = ["; ".join(pin.text() for pin in family.pins)] if family.pins else []
    for text, condition in zip(family.texts[len(family.pins) :], family.conditions, strict=True):
        on = ", ".join(f"{'θ' if j in condition.ring.revolute else 'q'}{j}" for j in condition.joints)
        whole = "whole with --latex, --python, --c, --json"
        parts.append(text if len(text) <= _LONGEST else f"a condition on {on}, {len(text):,} characters long ({whole})")
    line = "; ".join(parts)
    return [line] if len(line) <= _TOGETHER else parts


def _assumed(conditions: Conditions, width: int | None) -> Iterator[Section]:
    lines = []
    for one in conditions.assumptions:
        if one.words:
            case, _, happens = one.words.partition(", ")
            lines += [f"{one.text} ({_holds(one, conditions)}); {case}:"]
            lines += [piece for part in happens.split("; ") for piece in sentence(f"    {part}", width, _HANG)]
        elif not one.holds:
            lines += sentence(
                f"{one.text} ({_holds(one, conditions)}); what this arm has besides was not derived", width
            )
    others = [one.text for one in conditions.assumptions if one.holds and not one.words]
    if others:
        more = "" if conditions.settings.special else " (--special derives arms with other lengths)"
        lines += sentence(f"true here; what happens otherwise was not derived{more}:", width)
        short = sorted((text for text in others if not _DIGITS.search(text)), key=len)[:_UNDERIVED]
        lines += [piece for text in short for piece in formula(f"    {text}", width)]
        if count := len(others) - len(short):
            lines += sentence(f"    and {count} more polynomials in the lengths (all of them with --json)", width)
    if lines:
        yield Section("Assumptions on the lengths", "", tuple(lines))


def _holds(assumption: Assumption, conditions: Conditions) -> str:
    said = "true here" if assumption.holds else "NOT true here"
    match = _UNEQUAL.fullmatch(assumption.text)
    if match is None or not {match[1], match[3]} <= set(conditions.letters):
        return said
    values = (conditions.letters[match[1]], (-1 if match[2] else 1) * conditions.letters[match[3]])
    return f"{said}: {_number(values[0])} {'≠' if assumption.holds else '='} {_number(values[1])}"


def _not_real(found: Conditions, width: int | None) -> Iterator[Section]:
    by_reason: dict[str, list[str]] = {}
    for text in found.not_real:
        conditions, _, reason = text.partition(": ")
        by_reason.setdefault(reason, []).append(conditions)
    lines = []
    for reason, sets in by_reason.items():
        lines += formula(reason, width)
        for conditions in sets[:_ALIKE]:
            shown = conditions if len(conditions) <= _LONGEST else f"{conditions[:_LONGEST]} …"
            lines += formula(f"    {shown}", width)
        if len(sets) > _ALIKE:
            lines.append(f"    and {len(sets) - _ALIKE} more sets like these")
    if lines:
        yield Section("Not real", "sets of lower rank on which no real configuration is known", tuple(lines))


def _checks(conditions: Conditions, width: int | None) -> Iterator[Section]:
    tested = sum(family.rank_check.tested for family in conditions.families)
    agree = sum(family.rank_check.agree for family in conditions.families)
    lines = []
    cloud = conditions.explained
    if tested:
        lines.append(f"rank as claimed at {agree:,} of {tested:,} random points of the families, modulo 2^61 − 11913")
    if cloud.tested:
        lines.append(f"{cloud.agree:,} of {cloud.tested:,} singular configurations found numerically lie on a family")
    elif conditions.settings.points:
        lines.append("the numeric search for singular configurations found none")
    else:
        lines.append("no singular configuration was looked for numerically")
    if conditions.method != "tree" and not conditions.disagreements and not conditions.left:
        lines.append(f"corank 1 derived twice: rank tree and {METHOD.get(conditions.method, conditions.method)} agree")
    lines += [f"DISAGREEMENT: {one}" for one in conditions.disagreements]
    shipped = f"As shipped with rankdrop {conditions.settings.version}; --fresh derives it anew."
    lines.append(shipped if conditions.anew else f"Time taken: {conditions.seconds:.1f} s.")
    yield Section("Checks", "", tuple(lines))


def _unfinished(conditions: Conditions, width: int | None) -> Iterator[Section]:
    if conditions.left:
        lines = tuple(piece for one in conditions.left for piece in either(one, width))
        limit = f"the limit is {conditions.settings.seconds:g} s of processor time, a third of it for the counted work"
        more = f"; {limit}, and a longer --time-limit may finish it" if conditions.limited else ""
        ended = f"the exact derivation ended after {conditions.seconds:.1f} s{more}"
        yield Section("Not finished", ended, lines)


def _number(value: float, digits: int = 12) -> str:
    return f"{value + 0.0:.{digits}g}".replace("-", "−")


SCHEMA = "rankdrop/conditions/1"
LANGUAGES = ("python", "c")
"""What conditions can be written in as code."""


@dataclass(frozen=True, slots=True)
class ConditionSettings:
    """What the derivation was asked to do; with the robot and the version it determines the result.

    Attributes:
        method: asked for, for corank 1.
        lengths: "auto", "letters", "numbers", or values by letter [m].
        coranks: the highest one asked for; None for all.
        seconds: time limit. The result depends on it only where it was met.
        seed: of every random choice.
        points: numerically found configurations tried, of corank 1.
        special: whether arms of special lengths were derived too.
        steps: whether the derivation was written down.
        version: of rankdrop.
        basic: numbers of the basic screws asked for; None for none.
        frame: link whose frame was asked for; None for none.
    """

    method: str
    lengths: str | Mapping[str, float]
    coranks: int | None
    seconds: float
    seed: int
    points: int
    special: bool
    steps: bool
    version: str
    basic: tuple[int, ...] | None = None
    frame: int | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Conditions(Result):
    """The singularity conditions of an arm, exactly.

    Attributes:
        robot, task: the arm, and the rows that matter.
        generic_rank: of the task Jacobian almost everywhere; corank k means rank `generic_rank − k`.
        letters: the lengths that are symbols, and their values [m].
        shifts: θ = q + shift, per joint: conditions speak of θ [rad, m].
        remarks: what was rounded, or is nearly so.
        method, reason: how the conditions of corank 1 were derived, and why so.
        steps: that derivation, step by step.
        families: of every corank that was derived, large ones first.
        lowest: rank down to which drops were looked for.
        assumptions: lengths for which more happens.
        not_real: sets without a real point for the arm's lengths, and why.
        explained: of singular configurations found numerically, how many lie on a family.
        disagreements: whatever two methods, or the derivation and a check, say differently. None is as it should be.
        complete: nothing was left unfinished.
        interrupted: Ctrl-C ended it.
        left: what was not finished, in words.
        seconds: spent.
        limited: a limit on work or time ended it: a longer one derives more.
        settings: what was asked for.
        determinants: the determinant of the Jacobian, or its minors, in factors; None where no steps were asked for.
        anew: None for what was derived just now; for the shipped conditions of a catalogue arm what derives them anew.
    """

    robot: Robot
    task: Task
    generic_rank: int
    letters: Mapping[str, float]
    shifts: tuple[float, ...]
    remarks: tuple[str, ...]
    method: str
    reason: str
    steps: tuple[Step, ...]
    families: tuple[ExactFamily, ...]
    lowest: int
    assumptions: tuple[Assumption, ...]
    not_real: tuple[str, ...]
    explained: Check
    disagreements: tuple[str, ...]
    complete: bool
    interrupted: bool
    left: tuple[str, ...]
    seconds: float
    settings: ConditionSettings
    limited: bool = False
    determinants: Determinants | None = None
    anew: Callable[[], Conditions] | None = None
    FILE: ClassVar[str] = "conditions"

    @cached_property
    def chain(self) -> Chain:
        """The arm over the exact ring, in which conditions are polynomials: made for whoever asks."""
        made = exact_chain(self.robot, self.task, lengths=self.settings.lengths)
        return made if self.letters else replace(made, letters={}, written={})  # with letters it took too long

    @property
    def verified(self) -> bool:
        """Whether every check that was made holds and nothing was left unfinished."""
        return self.verdict.holds

    @property
    def verdict(self) -> Verdict:
        """What may be claimed, in one sentence; the exit code follows it."""
        return of_conditions(self)

    def of_corank(self, corank: int) -> tuple[ExactFamily, ...]:
        """The families of one corank."""
        return tuple(family for family in self.families if family.corank == corank)

    def __repr__(self) -> str:
        return f"<Conditions of {self.robot.name}: {len(self.families)} families, {self.verdict.word}>"

    def __str__(self) -> str:
        verdict = Section(self.verdict.sentence)
        return plain_text((verdict, *self.sections(), verdict))

    def test(self, condition: str, *, seconds: float = 60.0) -> LintResult:
        """Is a condition exactly the singular set, too small, or too large? See `rankdrop.exact.lint.lint`.

        Args:
            condition: as people write it: "sin(q3)*(a2*cos(q2)+a3*cos(q2+q3))", "θ4 = 0 or π; s6 = 0".
            seconds: time limit.

        Raises:
            OptionError: a mistake in the text; the singular set is not known, because the derivation ended early; or
                the time limit has passed.
        """
        from rankdrop.exact.lint import lint  # a command that tests nothing does without reading

        whole = self if self.anew is None else self.anew()
        if not whole.complete:
            raise OptionError(
                "the singular set is not completely derived: nothing can be held against it", got="; ".join(whole.left),
                mend="allow more time: seconds=…", typed="allow more time: --time-limit",
            )  # fmt: skip
        pieces = [piece for family in whole.families for piece in family.pieces]
        try:
            return lint(condition, pieces, whole.chain, work=Work(seconds / SLOWER, self.settings.seed))
        except OutOfTime as end:
            raise OptionError(
                "time ran out before the condition was decided", got=f"{seconds:g} s",
                mend="allow more time: seconds=…", typed="allow more time: --time-limit",
            ) from end

    def flags(self, q: ArrayLike) -> Flags:
        """The signs of the determinant's factors at a configuration: see `exact.aspects.configuration_flags`.

        Raises:
            TaskError: the task Jacobian is not square.
            ConfigurationError: q is not one configuration of this arm.
        """
        from rankdrop.exact.aspects import configuration_flags

        return configuration_flags(self.chain, q)

    def between(self, first: ArrayLike, second: ArrayLike) -> Between:
        """Which families part two configurations: see `rankdrop.exact.aspects.between`.

        Raises:
            TaskError, ConfigurationError: as `flags`.
        """
        from rankdrop.exact.aspects import between

        return between(self.chain, first, second)

    def sections(self, *, width: int | None = None) -> tuple[Section, ...]:
        """The conditions in words: see `rankdrop.results.conditions.sections_of`."""
        return sections_of(self, width=width)

    def latex(self) -> str:
        """A table: family, corank, conditions; the lengths below it."""
        return self._code().latex()

    def code(self, language: str) -> str:
        """A module or header with one function per family, q -> residuals that vanish on it.

        Args:
            language: "python" (on NumPy) or "c" (C99).

        Raises:
            OptionError: another language.
        """
        if language not in LANGUAGES:
            raise OptionError("there is no code in this language", got=repr(language), allowed=", ".join(LANGUAGES))
        return self._code().python() if language == "python" else self._code().c()

    def _code(self) -> Code:
        from rankdrop.exact.code import Code

        said = () if self.determinants is None else self.determinants.minors
        return Code(self.robot.name, self.robot.n, self.families, self.letters, self.shifts, said)

    def _repr_html_(self) -> str:
        """For notebooks: the verdict, the conditions of every family typeset, and what was checked."""
        from rankdrop.exact.notation import typeset

        witness = {
            family.id: [f"witness: {witness_text(self.robot, family.witness)}"]
            for family in self.families if any("witness" in words for words in family.lost_words)
        }  # fmt: skip
        rows = "".join(
            f"<tr><td>{family.id}</td><td>{family.corank}</td><td>{escape(family.name)}</td>"
            f"<td>{'<br>'.join(map(typeset, family.latex))}</td><td>{family.dimension}</td>"
            f"<td>{'<br>'.join(map(escape, (*family.lost_words, *witness.get(family.id, []))))}</td></tr>"
            for family in self.families
        )
        head = "<tr><th></th><th>corank</th><th>family</th><th>conditions</th><th>dim</th><th>lost</th></tr>"
        table = f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>" if rows else ""
        verdict = Section(self.verdict.sentence)
        return html([verdict]) + table + html([*sections_of(self, families=False), verdict])
