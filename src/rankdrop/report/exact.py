"""The exact conditions, typeset."""

from __future__ import annotations

from html import escape

from rankdrop.exact import ExactFamily, typeset
from rankdrop.family import Derivation, ExactRow
from rankdrop.report.content import Content
from rankdrop.text import letters_text

_SHORT = 70  # characters of LaTeX; conditions up to this stand side by side
_LONG = 420  # a longer one is folded
_LINES = 3  # of what was left unfinished
_NO_SHIFT = 1e-12  # [rad]


def exact_section(content: Content) -> str:
    """The conditions, exactly, typeset."""
    head = '<section id="exact"><h2>Exact conditions</h2>'
    joined = content.analysis.exact
    if joined is not None and joined.families:
        return f"{head}{_joined(joined)}</section>"
    found = content.exact
    if found is None:
        return f"{head}<p>Not derived: {escape(content.exact_missing)}</p></section>"
    numbers = letters_text(found.letters)
    shifts = [
        f"θ{i} = q{i} {'−' if x < 0 else '+'} {abs(x):.4g}"
        for i, x in enumerate(found.shifts, start=1)
        if abs(x) > _NO_SHIFT
    ]
    words = [
        f"Derived over the rational numbers with lengths as letters, by the method “{escape(found.method)}”. "
        "s<sub>i</sub> is sin θ<sub>i</sub>, c<sub>23</sub> is cos(θ<sub>2</sub> + θ<sub>3</sub>).",
        escape(f"Lengths: {numbers}." if numbers else ""),
        escape(f"Offsets: {', '.join(shifts)}." if shifts else ""),
    ]
    if not found.families:
        same = f"No family: the rank is {found.generic_rank} at every configuration."
        words.append(same if found.verified else "No family was derived.")
    else:
        words.append(
            f"The rank was checked modulo a prime at random points of every family, and {found.explained.agree:,} of "
            f"{found.explained.tested:,} singular configurations found numerically lie on one (seed "
            f"{found.settings.seed})."
        )
    told = "".join(f"<p>{one}</p>" for one in words if one)
    left = "".join(f'<p class="bad">Not finished: {_cut(one)}</p>' for one in found.left[:_LINES])
    if len(found.left) > _LINES:
        left += f'<p class="bad">… and {len(found.left) - _LINES} more.</p>'
    if found.complete:  # of an unfinished derivation it says nothing that a point lies on none of its families
        left += "".join(f'<p class="bad">Disagreement: {_cut(one)}</p>' for one in found.disagreements)
    left += "".join(f'<p class="small">{escape(one)}</p>' for one in found.remarks)
    if found.not_real:
        unreal = "".join(f'<p class="small">{escape(one)}</p>' for one in found.not_real)
        left += f"<details><summary>{len(found.not_real)} sets without a real point</summary>{unreal}</details>"
    return f'{head}{told}<div class="exacts">{"".join(map(_exact_family, found.families))}</div>{left}</section>'


def _joined(derivation: Derivation) -> str:
    """The conditions of the families of the analysis, which were derived with it."""
    letters = letters_text(derivation.letters)
    told = f"The families are derived exactly.{' Lengths: ' + letters + '.' if letters else ''}"
    wrong = "".join(f'<p class="bad">Disagreement: {_cut(one)}</p>' for one in derivation.disagreements)
    return f'<p>{escape(told)}</p><div class="exacts">{"".join(map(_exact_family, derivation.families))}</div>{wrong}'


def _cut(text: str) -> str:
    return escape(text if len(text) < _LONG else text[:_LONG] + " …")


def _exact_family(family: ExactFamily | ExactRow) -> str:
    side_by_side = [f"<span>{typeset(one)}</span>" for one in family.latex if len(one) <= _SHORT]
    short = '<span class="comma">,</span> '.join(side_by_side)
    lines = f'<div class="condition">{short}</div>' if short else ""
    lines += "".join(_condition(one) for one in family.latex if len(one) > _SHORT)
    real = f'<p class="small">{escape(family.reality)}</p>' if family.reality else ""
    return (
        f'<div class="exact"><h3>{family.id}&ensp;{escape(family.name)} <small>dimension {family.dimension}</small>'
        f"</h3>{lines}{real}</div>"
    )


def _condition(latex: str) -> str:
    text = f'<div class="condition longer">{typeset(latex)}</div>'
    if len(latex) <= _LONG:
        return text
    return f"<details><summary>a condition of {len(latex):,} characters</summary>{text}</details>"
