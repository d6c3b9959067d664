r"""MathML of LaTeX: results hold conditions as LaTeX alone.

Only what `rankdrop.formula.notation` writes is understood: letters with subscripts and powers, \frac, \sin, \cos,
\theta, \pi, \pm, \in, sets in \{ \}, numbers. A long one is cut before signs, so that lines can break.
"""

from __future__ import annotations

import re
from html import escape

_TOKEN = re.compile(r"\\mathrm\{[^}]*\}|\\[A-Za-z]+|\\.|\d+(?:\.\d+)?|[A-Za-z]|[{}_^()=+\-,/]|[^\s\\]")
_LEAVES = {
    r"\theta": "<mi>θ</mi>", r"\pi": "<mi>π</mi>", r"\alpha": "<mi>α</mi>", r"\beta": "<mi>β</mi>",
    **{rf"\{name}": f"<mi>{name}</mi><mspace width='0.15em'></mspace>" for name in ("sin", "cos", "tan")},
    r"\,": "<mspace width='0.17em'></mspace>",
}  # fmt: skip
_OPERATORS = {r"\in": "∈", r"\pm": "±", r"\cdot": "·", r"\{": "{", r"\}": "}", "-": "−", r"\ne": "≠", r"\quad": " "}
_BREAKS = {"+", "-", "="}
_LEADING = {"(", ",", "{", r"\{", "=", r"\in"}  # a sign after one of these stands before its term
_SCRIPTS = {"": "{0}", "_": "<msub>{0}{1}</msub>", "^": "<msup>{0}{1}</msup>", "_^": "<msubsup>{0}{1}{2}</msubsup>"}
_SHORT = 60  # characters; a condition no longer than this stays in one piece


def typeset(latex: str) -> str:
    """One condition as HTML: MathML in pieces between which a line may break.

    Example:
        >>> typeset("a_2 = 0")
        '<math><msub><mi>a</mi><mn>2</mn></msub><mo stretchy="false" form="infix">=</mo><mn>0</mn></math>'
    """
    pieces: list[list[str]] = [[]]
    depth, before = 0, ""
    for token in _TOKEN.findall(latex):
        depth += {"{": 1, "}": -1}.get(token, 0)
        if token in _BREAKS and len(latex) > _SHORT and depth == 0 and before not in {"", "(", "=", ","}:
            pieces.append([])
            before = ""
        pieces[-1].append(_leaf(token, before))
        before = token
    return " ".join(f"<math>{_row(piece[::-1])}</math>" for piece in pieces if piece)


def _leaf(token: str, before: str) -> str:
    """The MathML of a letter, a number or a sign; braces, scripts and fractions as they are."""
    if token in _LEAVES or token in {"{", "}", "_", "^", r"\frac", r"\tfrac"}:
        return _LEAVES.get(token, token)
    if token.startswith(r"\mathrm{"):
        plain = "".join(token[8:-1].replace("\\", "").split())
        return f"<mtext>{escape(plain)}</mtext>"
    if token.isalpha() or token[0].isdigit():
        if token.isalpha():
            return f"<mi>{token}</mi>"
        return f"<mn>{token}</mn>"
    if token in _BREAKS and before not in _LEADING:
        form = ' form="infix"'
    else:
        form = ""
    return f'<mo stretchy="false"{form}>{escape(_OPERATORS.get(token, token))}</mo>'


def _row(waiting: list[str]) -> str:
    """MathML of what waits, last first, up to a closing brace, each part with what is written below and above it."""
    parts = ""
    while waiting and waiting[-1] != "}":
        base, scripts = _part(waiting), dict[str, str]()
        while waiting and waiting[-1] in {"_", "^"}:
            mark = waiting.pop()
            scripts[mark] = _part(waiting)
        marks = sorted(scripts, reverse=True)
        parts += _SCRIPTS["".join(marks)].format(base, *(scripts[mark] for mark in marks))
    return parts


def _part(waiting: list[str]) -> str:
    """A group, a fraction, or a leaf."""
    token = waiting.pop() if waiting else "{"
    if token in {r"\frac", r"\tfrac"}:
        return f"<mfrac>{_part(waiting)}{_part(waiting)}</mfrac>"
    if token != "{":
        return token
    inside = _row(waiting)
    if waiting:
        waiting.pop()
    return f"<mrow>{inside}</mrow>"
