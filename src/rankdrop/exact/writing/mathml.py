r"""Exact conditions typeset: the LaTeX that they are written in, as MathML, which browsers show without any help.

Only what `rankdrop.exact.writing` writes is understood: letters with subscripts and powers, \frac, \sin, \cos, \theta,
\pi, \pm, \in, sets in \{ \}, numbers. A long condition is cut before its signs into pieces, so that lines can break.
"""

from __future__ import annotations

import re
from html import escape

_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|\d+(?:\.\d+)?|[A-Za-z]|[{}_^()=+\-,/]|[^\s\\]")
_SIGNS = {"\\theta": "θ", "\\pi": "π", "\\alpha": "α", "\\beta": "β"}
_WORDS = {"\\sin", "\\cos", "\\tan"}
_OPERATORS = {"\\in": "∈", "\\pm": "±", "\\cdot": "·", "\\{": "{", "\\}": "}", "-": "−", "\\ne": "≠", "\\quad": " "}
_BREAKS = {"+", "-", "="}
_SHORT = 60  # characters; a condition no longer than this stays in one piece


def typeset(latex: str) -> str:
    """One condition as HTML: MathML in pieces between which a line may break.

    Example:
        >>> typeset("a_2 = 0")
        '<math><msub><mi>a</mi><mn>2</mn></msub><mo stretchy="false" form="infix">=</mo><mn>0</mn></math>'
    """
    pieces: list[list[str]] = [[]]
    depth = 0
    breakable = len(latex) > _SHORT
    for token in _TOKEN.findall(latex):
        depth += {"{": 1, "}": -1}.get(token, 0)
        follows = bool(pieces[-1]) and pieces[-1][-1] not in {"(", "=", ","}
        if breakable and token in _BREAKS and depth == 0 and follows:
            pieces.append([])
        pieces[-1].append(token)
    return " ".join(f"<math>{_Reader(piece).row()}</math>" for piece in pieces if piece)


class _Reader:
    def __init__(self, tokens: list[str]) -> None:
        self.tokens = tokens
        self.at = 0

    def row(self, stop: str = "") -> str:
        """Everything up to a closing brace, or to the end."""
        parts = []
        while self.at < len(self.tokens) and self.tokens[self.at] != stop:
            parts.append(self.scripted())
        self.at += bool(stop)
        return "".join(parts)

    def scripted(self) -> str:
        """One thing with what is written below and above it."""
        base, below, above = self.one(), "", ""
        while self.at < len(self.tokens) and self.tokens[self.at] in {"_", "^"}:
            sign = self.tokens[self.at]
            self.at += 1
            if sign == "_":
                below = self.one()
            else:
                above = self.one()
        if below and above:
            return f"<msubsup>{base}{below}{above}</msubsup>"
        return f"<msub>{base}{below}</msub>" if below else f"<msup>{base}{above}</msup>" if above else base

    def one(self) -> str:
        """A group, a fraction, a letter, a number or a sign."""
        if self.at >= len(self.tokens):
            return "<mrow></mrow>"
        token = self.tokens[self.at]
        self.at += 1
        if token == "{":
            return f"<mrow>{self.row('}')}</mrow>"
        if token in {"\\frac", "\\tfrac"}:
            return f"<mfrac>{self.one()}{self.one()}</mfrac>"
        if token == "\\mathrm":
            return f"<mtext>{escape(self.plain())}</mtext>"
        if token in _SIGNS or token.isalpha():
            return f"<mi>{_SIGNS.get(token, token)}</mi>"
        if token in _WORDS:
            return f"<mi>{token[1:]}</mi><mspace width='0.15em'></mspace>"
        if token[0].isdigit():
            return f"<mn>{token}</mn>"
        if token == "\\,":
            return "<mspace width='0.17em'></mspace>"
        return self.operator(token)

    def plain(self) -> str:
        """The letters of a group as they are."""
        words = []
        if self.at < len(self.tokens) and self.tokens[self.at] == "{":
            end = self.tokens.index("}", self.at)
            words = [token.removeprefix("\\") for token in self.tokens[self.at + 1 : end]]
            self.at = end + 1
        return "".join(words)

    def operator(self, token: str) -> str:
        """A sign; it keeps its room where a piece begins with it."""
        infix = token in {"+", "-", "="} and (self.at > 1 or self.at < len(self.tokens)) and not self.leading()
        form = ' form="infix"' if infix else ""
        return f'<mo stretchy="false"{form}>{escape(_OPERATORS.get(token, token))}</mo>'

    def leading(self) -> bool:
        """Whether the sign just read stands before its term: after a bracket, a comma, another sign."""
        before = self.tokens[self.at - 2] if self.at > 1 else ""
        return before in {"(", ",", "{", "\\{", "=", "\\in"}
