"""A path judged, as what `check_path` returns."""

from __future__ import annotations

from typing import Any

from rankdrop.motion.data import PathData
from rankdrop.motion.record import path_to_dict
from rankdrop.motion.text import path_sections
from rankdrop.sections import Section, html, text


class PathCheck(PathData):
    """`PathData` that can be printed, shown in a notebook and written to a file."""

    def to_dict(self) -> dict[str, Any]:
        """The record that `rankdrop path --json` writes."""
        return path_to_dict(self)

    def sections(self, *, deg: bool = True, full: bool = False) -> tuple[Section, ...]:
        """As sections of text; `full`: every stretch, not the ten worst."""
        return path_sections(self, deg=deg, full=full)

    def __str__(self) -> str:
        return text(self.sections())

    def _repr_html_(self) -> str:
        return html(self.sections())
