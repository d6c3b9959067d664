"""The result of an exact derivation: a frozen record that goes to JSON and code, and shows itself as text.

As plain data it has the names of docs/json.md; `rankdrop.text.conditions` has the words.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from numpy.typing import ArrayLike

from rankdrop.algebra.work import SLOWER, OutOfTime, Work
from rankdrop.codec import Result
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.family import Assumption, UnrealSet
from rankdrop.exact.method_reason import MethodReason
from rankdrop.exact.remark import DerivationRemark
from rankdrop.exact.undivided import UndividedSet
from rankdrop.families.contradiction import Contradiction
from rankdrop.families.record import Check, Family, exact_of
from rankdrop.families.summary import FamilySummary, Verdict
from rankdrop.families.unfinished import Unfinished
from rankdrop.formula.notation import Step
from rankdrop.lists import flat_map
from rankdrop.questions import ConditionsOptions
from rankdrop.robot.model import Robot
from rankdrop.sections import Section, words_of
from rankdrop.task import Task

if TYPE_CHECKING:
    from rankdrop.exact.determinants import Determinants
    from rankdrop.exact.lint import LintResult
    from rankdrop.exact.signs import Between, Flags


SCHEMA = "rankdrop/conditions/1"
LANGUAGES = ("python", "c")
"""What conditions can be written in as code."""


@dataclass(frozen=True, eq=False, repr=False)
class Conditions(Result):
    """The singularity conditions of an arm, exactly.

    Attributes:
        robot, task: the arm, and the rows that matter.
        generic_rank: of the task Jacobian almost everywhere; corank k means rank `generic_rank − k`.
        letters: the lengths that are symbols, and their values [m].
        shifts: θ = q + shift, per joint: conditions speak of θ [rad, m].
        remarks: what was rounded, or is nearly so; `str` gives a sentence, here and of the next two.
        method, reason: how the conditions of corank 1 were derived, and why so; by reciprocity higher coranks as well.
        steps: that derivation, step by step.
        families: of every corank that was derived, large ones first, each with its exact conditions.
        lowest: rank down to which drops were looked for.
        assumptions: lengths for which more happens.
        not_real: sets without a real point for the arm's lengths, and why.
        explained: of singular configurations found numerically, how many lie on a family.
        disagreements: what two methods, or the derivation and a check, find differently. None is as it should be.
        complete: nothing was left unfinished: every singular configuration is on a family or on an undivided case.
        interrupted: Ctrl-C ended it.
        left: what was not finished, and what contradicts an unfinished derivation.
        seconds: spent.
        limited: a limit on work or time ended it: a longer one derives more.
        settings: what was asked for; with the robot and the version it determines the result.
        determinants: the determinant of the Jacobian, or its minors, in factors; None where no steps were asked for.
        undivided: cases that were not taken apart: their conditions as they stand.
        anew: None for what was derived just now; for the shipped conditions of a catalogue arm what derives them anew.
    """

    robot: Robot
    task: Task
    generic_rank: int
    letters: Mapping[str, float]
    shifts: tuple[float, ...]
    remarks: tuple[DerivationRemark, ...]
    method: str
    reason: MethodReason
    steps: tuple[Step, ...]
    families: tuple[Family, ...]
    lowest: int
    assumptions: tuple[Assumption, ...]
    not_real: tuple[UnrealSet, ...]
    explained: Check
    disagreements: tuple[Contradiction, ...]
    complete: bool
    interrupted: bool
    left: tuple[Unfinished | Contradiction, ...]
    seconds: float
    settings: ConditionsOptions
    limited: bool = False
    determinants: Determinants | None = None
    undivided: tuple[UndividedSet, ...] = ()
    anew: Callable[[], Conditions] | None = None
    FILE: ClassVar[str] = "conditions"

    @cached_property
    def chain(self) -> Chain:
        """The arm over the exact ring, in which conditions are polynomials: made for whoever asks."""
        made = exact_chain(self.robot, self.task, lengths=self.settings.lengths, parts=True)
        return made if self.letters else replace(made, letters={}, written={})  # with letters it took too long

    @property
    def in_families(self) -> bool:
        """Whether nothing was left unfinished, and every singular configuration is on a family."""
        return self.complete and not self.undivided

    @property
    def verified(self) -> bool:
        """Whether every check that was made holds and nothing was left unfinished."""
        return self.verdict.holds

    @property
    def verdict(self) -> Verdict:
        """What may be claimed, in one sentence; the exit code follows it."""
        verdict: Verdict = words_of(self).of_conditions(self)
        return verdict

    @property
    def summary(self) -> FamilySummary:
        """Facts of the answer: families by rank, and how they were verified."""
        summary: FamilySummary = words_of(self).summary_of_conditions(self)
        return summary

    @property
    def answer(self) -> str:
        """What the arm has, in one sentence."""
        answer: str = words_of(self).answer_of(self)
        return answer

    def of_corank(self, corank: int) -> tuple[Family, ...]:
        """The families of one corank."""
        return tuple(family for family in self.families if family.corank == corank)

    def __repr__(self) -> str:
        return f"<Conditions of {self.robot.name}: {len(self.families)} families, {self.verdict.word}>"

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

        if self.anew is None:
            whole = self
        else:
            whole = self.anew()
        if not whole.in_families:
            raise OptionError(
                "the singular set is not completely derived: it cannot be compared",
                got=words_of(self).unfinished_text(whole),
                mend="allow more time: seconds=…", typed="allow more time: --time-limit",
            )  # fmt: skip
        pieces = flat_map(lambda family: exact_of(family).pieces, whole.families)
        try:
            return lint(condition, pieces, whole.chain, work=Work(seconds / SLOWER, self.settings.seed))
        except OutOfTime as end:
            raise OptionError(
                "time ran out before the condition was decided",
                got=f"{seconds:g} s",
                mend="allow more time: seconds=…",
                typed="allow more time: --time-limit",
            ) from end

    def flags(self, q: ArrayLike) -> Flags:
        """The signs of the determinant's factors at a configuration: see `exact.aspects.configuration_flags`.

        Raises:
            TaskError: the task Jacobian is not square.
            ConfigurationError: q is not one configuration of this arm.
        """
        from rankdrop.exact.signs import configuration_flags

        return configuration_flags(self.chain, q)

    def between(self, first: ArrayLike, second: ArrayLike) -> Between:
        """Which families part two configurations: see `rankdrop.exact.signs.between`.

        Raises:
            TaskError, ConfigurationError: as `flags`.
        """
        from rankdrop.exact.signs import families_between

        return families_between(self.chain, first, second)

    def sections(self) -> tuple[Section, ...]:
        """The answer, then the conditions in words."""
        sections: tuple[Section, ...] = words_of(self).sections_of(self)
        return sections

    def latex(self) -> str:
        """A table: family, corank, conditions; the lengths below it."""
        table: str = words_of(self).code_of(self).latex()
        return table

    def code(self, language: str) -> str:
        """A module or header with one function per family, q -> residuals that vanish on it.

        Args:
            language: "python" (on NumPy) or "c" (C99).

        Raises:
            OptionError: another language.
        """
        if language not in LANGUAGES:
            raise OptionError("there is no code in this language", got=repr(language), allowed=", ".join(LANGUAGES))
        module = words_of(self).code_of(self)
        source: str = module.python() if language == "python" else module.c()
        return source

    def _repr_html_(self) -> str:
        """For notebooks: the verdict, the conditions of every family typeset, and what was checked."""
        page: str = words_of(self).conditions_html(self)
        return page
