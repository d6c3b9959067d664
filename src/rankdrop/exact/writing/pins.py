"""A joint that stands at one of some simple angles: θ4 = 0 or π."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.atom import SIMPLE
from rankdrop.exact.writing.programs import C, Python
from rankdrop.family.equation import Equation, Term, normalised

WORDS = {"0": "0", "pi": "π", "pi/2": "π/2", "-pi/2": "−π/2"}
LATEX = {"0": "0", "pi": r"\pi", "pi/2": r"\frac{\pi}{2}", "-pi/2": r"-\frac{\pi}{2}"}
RADIANS = {"0": 0.0, "pi": pi, "pi/2": pi / 2, "-pi/2": -pi / 2}
QUARTERS = frozenset({"pi/2", "-pi/2"})
HALVES = frozenset({"0", "pi"})


def _checked(values: Sequence[str]) -> tuple[str, ...]:
    unknown = [value for value in values if value not in SIMPLE]
    if unknown or not values:
        got = ", ".join(unknown) or "none"
        raise OptionError("not an angle a joint is pinned at", got=got, allowed=", ".join(SIMPLE))
    return tuple(value for value in SIMPLE if value in values)


def pin_text(joint: int, values: Sequence[str]) -> str:
    """For people.

    Example:
        >>> pin_text(4, ("0", "pi")), pin_text(3, ("pi/2", "-pi/2"))
        ('θ4 = 0 or π', 'θ3 = ±π/2')

    Raises:
        OptionError: a value that is not in `SIMPLE`, or none.
    """
    kept = _checked(values)
    words = [WORDS[value] for value in kept]
    if set(kept) >= QUARTERS:
        words = [*(WORDS[value] for value in kept if value not in QUARTERS), "±π/2"]
    return f"θ{joint} = {' or '.join(words)}"


def pin_latex(joint: int, values: Sequence[str]) -> str:
    r"""LaTeX, without delimiters: \theta_4 \in \{0, \pi\}.

    Raises:
        OptionError: a value that is not in `SIMPLE`, or none.
    """
    kept = _checked(values)
    name = rf"\theta_{joint}" if joint < 10 else rf"\theta_{{{joint}}}"
    if len(kept) == 1:
        return f"{name} = {LATEX[kept[0]]}"
    if set(kept) == QUARTERS:
        return rf"{name} = \pm\frac{{\pi}}{{2}}"
    return rf"{name} \in \{{{', '.join(LATEX[value] for value in kept)}\}}"


def pin_expression(joint: int, values: Sequence[str], shifts: Sequence[float] | None = None) -> str:
    """A Python expression in q that vanishes there and nowhere else.

    Example:
        >>> pin_expression(4, ("0", "pi")), pin_expression(4, ("pi",)), pin_expression(4, ("pi/2",))
        ('sin(q4)', 'cos(q4/2)', 'sin((q4 - pi/2)/2)')

    Args:
        joint: number.
        values: out of `SIMPLE`.
        shifts: θ_j = q_j + shifts[j − 1] [rad]; None for none.

    Raises:
        OptionError: a value that is not in `SIMPLE`, or none.
    """
    return _written(joint, values, Python(shifts=() if shifts is None else shifts))


def pin_c_code(joint: int, values: Sequence[str], shifts: Sequence[float] | None = None) -> str:
    """The same as a C expression in q[0] ….

    Raises:
        OptionError: a value that is not in `SIMPLE`, or none.
    """
    return _written(joint, values, C(shifts=() if shifts is None else shifts, variable="q[{1}]"))


def _written(joint: int, values: Sequence[str], notation: Python) -> str:
    kept = set(_checked(values))
    factors = []
    for pair, kind in ((HALVES, "sin"), (QUARTERS, "cos")):
        if kept >= pair:
            factors.append(f"{kind}({notation.angle(((joint, 2),))})")
            kept -= pair
    for value in _checked(tuple(kept)) if kept else ():
        kind, rest = ("cos", "0") if value == "pi" else ("sin", value)
        factors.append(f"{kind}({notation.angle(((joint, 1),), rest)})")
    return "*".join(factors)


def pin_equation(joint: int, values: Sequence[str], n: int, shifts: Sequence[float] | None = None) -> Equation:
    """The numeric equation Π sin((θ_j − value) / 2) = 0 in q.

    Args:
        joint: number.
        values: out of `SIMPLE`.
        n: number of joints.
        shifts: θ_j = q_j + shifts[j − 1] [rad]; None for none.

    Raises:
        OptionError: a value that is not in `SIMPLE`, or none.
    """
    kept = _checked(values)
    size = len(kept)
    coefficients = np.array([1.0 + 0.0j])
    for value in kept:  # sin(x) = (exp(ix) − exp(−ix)) / 2i, powers of exp(iθ/2) from −size to size
        turn = np.exp(0.5j * RADIANS[value])
        coefficients = np.convolve(coefficients, np.array([-turn, 0, 1 / turn]) / 2j)
    shift = 0.0 if shifts is None else float(shifts[joint - 1])
    terms = []
    for power in range(size, -1, -1):
        value = coefficients[power + size] * (2 if power else 1)
        harmonics = tuple(power * (i == joint - 1) for i in range(n))
        phase = -power * shift / 2 + 0.0
        for kind, part in (("cos", value.real), ("sin", -value.imag)):
            if kind == "cos" or power:
                terms.append(Term(float(part), kind, harmonics, (0,) * n, phase))
    return normalised(terms)
