"""Two rows that differ by half a turn of one pinned joint, written as one.

On θ3 = 0 the shoulder of a UR5 is (a2 + a3)c2 + d5·s24 = 0, on θ3 = π it is (a2 − a3)c2 − d5·s24 = 0. With δ = θ3 − v,
where sin δ = 0 and cos δ = ±1, both are A + B·cos δ = 0, A and B half the sum and half the difference of the two
equations, one of them scaled so that most terms cancel. And since sin δ = 0, B·cos δ is B with δ added to every angle:
a2·c2 + a3·c23 + d5·s234 = 0.
"""

from __future__ import annotations

from math import cos, sin

import numpy as np

from rankdrop.families.row import Row, verified
from rankdrop.families.sampling import Setting
from rankdrop.family.equation import Equation, Term, normalised

MERGED = "fitted, merged over half a turn, then verified"
SAME = 1e-9  # coefficients closer than this share of the largest cancel

Key = tuple[str, tuple[int, ...], tuple[int, ...]]


def merged(setting: Setting, rows: list[Row], rng: np.random.Generator) -> list[Row]:
    """Rows with pairs of the same signature joined where one set of equations holds for both, verified anew."""
    result = list(rows)
    for first in rows:
        for second in rows:
            if first in result and second in result and first is not second:
                joined = _joined(setting, first, second, rng)
                if joined is not None:
                    result[result.index(first)] = joined
                    result.remove(second)
    return result


def _joined(setting: Setting, first: Row, second: Row, rng: np.random.Generator) -> Row | None:
    if first.signature != second.signature or not first.residual or len(first.residual) != len(second.residual):
        return None
    apart = [i for i, (a, b) in enumerate(zip(first.sets, second.sets, strict=True)) if a != b]
    if len(apart) != 1 or not first.linear.periodic[apart[0]]:
        return None
    i = apart[0]
    one, other = first.sets[i], second.sets[i]
    if len(one) != 1 or len(other) != 1 or abs(cos(one[0] - other[0]) + 1) > 1e-14:
        return None
    covector = tuple(int(m) for m in first.linear.covectors[i])
    residual = []
    for f, g in zip(first.residual, second.residual, strict=True):
        equation = _combined(f, g, covector, one[0])
        if equation is None:
            return None
        residual.append(equation)
    values = tuple(sorted((one[0], other[0]), key=lambda v: (abs(v), -v)))
    row = Row(first.linear, (*first.sets[:i], values, *first.sets[i + 1 :]), tuple(residual), first.signature, MERGED)
    need = first.signature.residual
    return row if all(verified(setting, row.linear, row.residual, need, row.combinations, rng)) else None


def _combined(f: Equation, g: Equation, covector: tuple[int, ...], value: float) -> Equation | None:
    """An equation that is f where covector·q = value and g half a turn on; None unless it is as short as both."""
    if f == g:
        return f
    a, b = _coefficients(f), _coefficients(g)
    if a is None or b is None or f.parity is None or f.parity != g.parity:
        return None
    best: list[Term] | None = None
    for ratio in sorted({round(s * a[key] / b[key], 12) for key in a.keys() & b.keys() for s in (1, -1)}):
        terms = _sum(a, {key: ratio * c for key, c in b.items()}, covector, value)
        if best is None or len(terms) < len(best):
            best = terms
    return normalised(best) if best and len(best) <= max(len(f.terms), len(g.terms)) + 2 else None


def _coefficients(equation: Equation) -> dict[Key, float] | None:
    if any(term.shift for term in equation.terms):
        return None
    return {(term.kind, term.harmonics, term.powers): term.coefficient for term in equation.terms}


def _sum(a: dict[Key, float], b: dict[Key, float], covector: tuple[int, ...], value: float) -> list[Term]:
    """(a + b)/2, and (a − b)/2 with covector·q − value added to every angle."""
    floor = SAME * max(abs(c) for c in [*a.values(), *b.values()])
    found: dict[Key, float] = {}
    for key in [*a, *(key for key in b if key not in a)]:
        kind, harmonics, powers = key
        even, odd = (a.get(key, 0.0) + b.get(key, 0.0)) / 2, (a.get(key, 0.0) - b.get(key, 0.0)) / 2
        if abs(even) > floor:
            found[key] = found.get(key, 0.0) + even
        if abs(odd) > floor:
            turned = tuple(h + 2 * m for h, m in zip(harmonics, covector, strict=True))
            # cos(x − v) = cos v cos x + sin v sin x; sin(x − v) = cos v sin x − sin v cos x
            parts = {"cos": (cos(value), sin(value)), "sin": (-sin(value), cos(value))}[kind]
            for name, part in zip(("cos", "sin"), parts, strict=True):
                if abs(part) > 1e-15:
                    found[name, turned, powers] = found.get((name, turned, powers), 0.0) + odd * part
    return [_positive(*key, c) for key, c in found.items() if abs(c) > floor]


def _positive(kind: str, harmonics: tuple[int, ...], powers: tuple[int, ...], c: float) -> Term:
    """The same term with its first harmonic positive."""
    leading = next((h for h in harmonics if h), 1)
    if leading > 0:
        return Term(c, kind, harmonics, powers)
    return Term(-c if kind == "sin" else c, kind, tuple(-h for h in harmonics), powers)

