"""The explanation of one configuration: its data, and how it goes to JSON, to text and to a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rankdrop.results.codec import Record, save_record
from rankdrop.results.explanation.data import ExplanationData
from rankdrop.results.explanation.record import explanation_to_dict
from rankdrop.results.explanation.text import DETAILS, PARTS, sections_of
from rankdrop.sections import Section, html, text

_SHOWN = tuple(name for name in PARTS if name not in DETAILS | {"more"})


@dataclass(frozen=True, eq=False, repr=False)
class Explanation(ExplanationData):
    """Everything rankdrop can say of one configuration; the attributes are those of `ExplanationData`."""

    def __repr__(self) -> str:
        return f"<Explanation of {self.robot.name}: {self.verdict}, {self.reason}>"

    def __str__(self) -> str:
        """What the command line prints, unwrapped."""
        return text(self.sections(parts=_SHOWN))

    def to_dict(self) -> Record:
        """Plain data: see docs/json.md and schema/explanation.schema.json."""
        return explanation_to_dict(self)

    def save(self, path: str | Path) -> None:
        """Write the explanation to a JSON file.

        Raises:
            ResultFileError: the file cannot be written.
        """
        save_record(self.to_dict(), path)

    def sections(self, *, full: bool = False, parts: Sequence[str] = ()) -> tuple[Section, ...]:
        """The explanation in words: see `rankdrop.results.explanation.text.sections_of`."""
        return sections_of(self, full=full, parts=parts)

    def _repr_html_(self) -> str:
        """For notebooks."""
        return html(self.sections(parts=_SHOWN))
