"""The result of an exact derivation: a frozen record that goes to JSON and code, and shows itself as text."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.work import SLOWER, OutOfTime, Work
from rankdrop.results.codec import Record, save_record
from rankdrop.results.conditions.data import ConditionsData, conditions_to_dict
from rankdrop.results.conditions.text import sections_of
from rankdrop.sections import Section, html, text

if TYPE_CHECKING:
    from rankdrop.exact.aspects import Between, Flags
    from rankdrop.exact.code import Code
    from rankdrop.exact.reading.lint import LintResult

LANGUAGES = ("python", "c")
"""What conditions can be written in as code."""


@dataclass(frozen=True, eq=False, repr=False)
class Conditions(ConditionsData):
    """The singularity conditions of an arm, exactly; the attributes are those of `ConditionsData`."""

    def __repr__(self) -> str:
        return f"<Conditions of {self.robot.name}: {len(self.families)} families, {self.verdict.word}>"

    def __str__(self) -> str:
        """What the command line prints, unwrapped."""
        return text(self._told())

    def test(self, condition: str, *, seconds: float = 60.0) -> LintResult:
        """Is a condition exactly the singular set, too small, or too large? See `rankdrop.exact.reading.lint.lint`.

        Args:
            condition: as people write it: "sin(q3)*(a2*cos(q2)+a3*cos(q2+q3))", "θ4 = 0 or π; s6 = 0".
            seconds: time limit.

        Raises:
            OptionError: a mistake in the text; the singular set is not known, because the derivation ended early; or
                the time limit has passed.
        """
        from rankdrop.exact.reading.lint import lint  # a command that tests nothing does without reading

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
        """The signs of the determinant's factors at a configuration: see `exact.signs.aspects.configuration_flags`.

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

    def to_dict(self) -> Record:
        """Plain data: see docs/json.md and schema/conditions.schema.json. The time spent is not in it."""
        return conditions_to_dict(self)

    def save(self, path: str | Path) -> None:
        """Write the conditions to a JSON file.

        Raises:
            ResultFileError: the file cannot be written.
        """
        save_record(self.to_dict(), path)

    def sections(self, *, width: int | None = None) -> tuple[Section, ...]:
        """The conditions in words: see `rankdrop.results.conditions.text.sections_of`."""
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
        from rankdrop.exact.writing.mathml import typeset

        rows = "".join(
            f"<tr><td>{family.id}</td><td>{family.corank}</td><td>{escape(family.name)}</td>"
            f"<td>{'<br>'.join(map(typeset, family.latex))}</td><td>{family.dimension}</td>"
            f"<td>{'<br>'.join(map(escape, family.lost_words))}</td></tr>"
            for family in self.families
        )
        head = "<tr><th></th><th>corank</th><th>family</th><th>conditions</th><th>dim</th><th>lost</th></tr>"
        table = f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>" if rows else ""
        verdict = Section(self.verdict.sentence)
        return html([verdict]) + table + html([*sections_of(self, families=False), verdict])

    def _told(self) -> tuple[Section, ...]:
        """The verdict first and last."""
        verdict = Section(self.verdict.sentence)
        return (verdict, *self.sections(), verdict)
