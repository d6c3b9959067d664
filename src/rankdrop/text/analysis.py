"""An analysis in words: what the arm has, how sure that is, the tables of its families."""

from __future__ import annotations

from rankdrop.results.analysis import Analysis
from rankdrop.sections import Section
from rankdrop.text.aspects import aspects_line
from rankdrop.text.brief import speed_section
from rankdrop.text.claims import of_analysis, opening, summary_of_analysis
from rankdrop.text.families import overview
from rankdrop.text.joint_limits import inside_limits
from rankdrop.text.latex import latex_tables

__all__ = ["inside_limits", "latex_of", "of_analysis", "opening", "sections_of", "summary_of_analysis"]


def sections_of(analysis: Analysis) -> tuple[Section, ...]:
    """The answer and how it was verified, then a table of families for each corank."""
    first, second = analysis.verdict.headlines(analysis.answer)
    tables = overview(
        analysis.robot, analysis.generic_rank, analysis.coranks, analysis.families,
        limits=analysis.settings.limits,
    )  # fmt: skip
    speeds = speed_section(analysis)
    aspects = aspects_line(analysis.aspects)
    lines = tuple(filter(None, (second, aspects)))
    return (Section(first, lines=lines), *tables, *([] if speeds is None else [speeds]))


def latex_of(analysis: Analysis) -> str:
    """The tables as AM print them: see `rankdrop.text.latex.latex_tables`."""
    return latex_tables(
        analysis.robot, analysis.generic_rank, analysis.coranks, analysis.families, analysis.exact,
        limits=analysis.settings.limits,
    )  # fmt: skip
