"""LaTeX of a Denavit–Hartenberg table in plain signs: `\\frac{\\pi}{2}` as (pi)/(2), `90^\\circ` as 90°, no `\\hline`.

Line breaks stay, so that lines keep their numbers; `&` and the double backslash behind a row stay too.
"""

from __future__ import annotations

import re

_COMMAND = re.compile(r"(?P<row>\\\\)(?:\*|\[[^\]\n]{0,20}\])?|\\(?P<name>[A-Za-z]+)[ \t]*|\\(?P<sign>[^\w\s\\]| )")
_BEFORE_PI = re.compile(r"(?<=[\d)}])[ \t]*\\pi(?![A-Za-z])")
_LINE = re.compile(r"\\(?:cline|cmidrule)(?:\([^()\n]{0,10}\))?\s*\{[^{}\n]{0,20}\}")
_ENVIRONMENT = re.compile(
    r"\\(?:begin|end)[ \t]*\{[a-z]{1,20}\*?\}(?:\[[^\]\n]{0,10}\])?(?:\{[|clr@p\d. {}m]{0,60}\})?"
)
_DEGREE = re.compile(r"\^[ \t]*(?:\{[ \t]*)?°(?:[ \t]*\})?")
_BRACED = re.compile(r"([_^])[ \t]*\{([^{}\n]{0,40})\}")
_PART = r"(?:\{([^{}\n]{0,80})\}|(pi|\d))"
_FRACTION = re.compile(r"\\[dts]?frac[ \t]*" + _PART + r"[ \t]*" + _PART)
_ROOT = re.compile(r"\\sqrt[ \t]*\{([^{}\n]{0,80})\}")
_PLAIN = re.compile(
    r"\\(?:text|textrm|textbf|textit|mathrm|mathbf|mathit|mathsf|boldsymbol|bm|operatorname|mbox|unit|si|multirow"
    r"|multicolumn\s*\{\d{1,2}\}\s*\{[^{}\n]{0,20}\})[ \t]*\{([^{}\n]{0,80})\}"
)
_ANGLE = re.compile(r"\\ang[ \t]*\{([^{}\n]{0,40})\}")
_QUANTITY = re.compile(r"\\(?:SI|qty)[ \t]*\{([^{}\n]{0,40})\}[ \t]*\{([^{}\n]{0,40})\}")
_DEEPEST = 4  # a fraction in a fraction is written by nobody

_MEANINGS = {
    **dict.fromkeys(("alpha", "beta", "gamma", "delta", "phi", "psi", "ell", "theta", "pi"), ""),
    "vartheta": "theta", "varphi": "phi", "cdot": "*", "times": "*", "ast": "*", "star": "*",
    **dict.fromkeys(("circ", "degree", "textdegree"), "°"),
    **dict.fromkeys(("hline", "toprule", "midrule", "bottomrule", "left", "right", "quad", "qquad", "displaystyle",
                     "rm", "centering", "small"), " "),
    "meter": "m", "metre": "m", "mm": "mm", "cm": "cm", "radian": "rad", "rad": "rad",
}  # fmt: skip
"""Name of a command -> the signs that it stands for; "" for its own name."""
_NO_SIGN = frozenset("()[]{}!-/")
"""Signs that, behind a backslash, print nothing."""


def plain_latex(text: str) -> str:
    """The text with plain signs for commands of LaTeX; a command that is not known stays.

    Example:
        >>> plain_latex(r"2 & $-\\frac{\\pi}{2}$ & $\\theta_{2} - 90^\\circ$ \\\\ \\hline").rstrip()
        '2 & -(pi)/(2) & theta_2 - 90° \\\\\\\\'
    """
    if "\\" not in text:
        return text
    rows = _LINE.sub(" ", _ENVIRONMENT.sub(r"\\\\", text))
    plain = _COMMAND.sub(_meaning, _BEFORE_PI.sub(r"*\\pi", rows))
    plain = _DEGREE.sub("°", plain.replace("$", "").replace("~", " ").replace("{}", ""))
    plain = _BRACED.sub(r"\1\2", plain).replace("^*", "*")
    for _ in range(_DEEPEST):
        plain = _QUANTITY.sub(r"\1 \2", _ANGLE.sub(r"\1°", _PLAIN.sub(r" \1", plain)))
        plain = _ROOT.sub(r"sqrt(\1)", _FRACTION.sub(_quotient, plain))
    return plain


def rows_of_line(line: str) -> list[str]:
    """The rows of a table that stand in a line: several where the LaTeX has no line breaks.

    Example:
        >>> rows_of_line(r"1 & 0 \\\\ 2 & 90 \\\\")
        ['1 & 0 ', ' 2 & 90 ']
    """
    if "&" not in line:
        return [line]
    rows = [row for row in line.split("\\\\") if row.strip()]
    return rows or [line]


def _meaning(found: re.Match[str]) -> str:
    """The signs for a command."""
    if found["row"]:
        return found["row"]
    if found["name"]:
        meaning = _MEANINGS.get(found["name"])
        if meaning is None:
            return found[0]
        return meaning or found["name"]
    if found["sign"] in _NO_SIGN:
        return ""
    return {"_": "_", "%": "%"}.get(found["sign"], " ")


def _quotient(found: re.Match[str]) -> str:
    over, under = (found[1] or found[2], found[3] or found[4])
    return f"({over})/({under})"
