"""Trigonometric polynomials and the conditions of a stratum as text."""

from __future__ import annotations

from collections.abc import Sequence

from rankdrop.exact.flint import Polynomial
from rankdrop.exact.fourier import fourier
from rankdrop.exact.notation import SUPERSCRIPT, Text
from rankdrop.exact.pins import WORDS
from rankdrop.exact.ring import SIMPLE, Ring, primitive
from rankdrop.exact.shortest import gathered, length, parts_of, shortest
from rankdrop.exact.stratum import Stratum
from rankdrop.exact.stratum_factors import Product, letters_polynomial, polynomial_of


def text_of(ring: Ring, p: Polynomial) -> str:
    """A trigonometric polynomial, equal to it: s_j is sin θ_j, c_34 is cos(θ3 + θ4).

    Example:
        >>> ring = Ring([1, 2])
        >>> text_of(ring, ring.s[1] * ring.c[2] + ring.c[1] * ring.s[2])
        's12'
    """
    if p == 0:
        return "0"
    f, multiples = ring.to_half(p)
    degrees = [2 * m for m in multiples]
    if [int(d) for d in f.degrees()[: ring.angles]] == degrees:
        form = shortest(f, ring)
    else:  # zero at θ = π, which its own degrees do not tell
        plain = fourier(f, degrees, ring)
        form = min([plain, gathered(plain)], key=length)
    return Text().sum(parts_of(form))


def condition_text(ring: Ring, p: Polynomial, sign: str = "=") -> str:
    """The condition p = 0 (or ≠ 0): "s4 = 0", "θ4 = π", "a6 + d3 s6 + d5 s6 ≠ 0"."""
    wanted = primitive(p)
    for j in ring.revolute:
        for value in SIMPLE:
            if wanted == primitive(polynomial_of(ring, ring.pin(j, value))):
                return f"θ{j} {sign} {WORDS[value]}"
    return f"{text_of(ring, wanted)} {sign} 0"


def conditions_text(stratum: Stratum) -> str:
    """The conditions of a stratum in one line."""
    ring = stratum.ring
    parts = [condition_text(ring, p) for p in stratum.closed] + [condition_text(ring, p, "≠") for p in stratum.open]
    return ", ".join(parts) or "everywhere"


def product_text(ring: Ring, product: Product) -> str:
    """A determinant as the product of its factors, or as it is where that is not how it factors."""
    if product.outer is None:
        return text_of(ring, product.polynomial)
    factors = [*((letters_polynomial(ring, f), power) for f, power in product.letters), *product.written]
    outer = text_of(ring, product.outer)
    sign = "−" if outer.startswith("−") else ""
    outer = outer.removeprefix("−")
    return sign + " ".join([*([outer] if outer != "1" or not factors else []), *_powers(ring, factors)])


def _powers(ring: Ring, factors: Sequence[tuple[Polynomial, int]]) -> list[str]:
    found = []
    for f, power in factors:
        text = text_of(ring, f)
        text = f"({text})" if " + " in text or " − " in text else text
        found.append(text if power == 1 else text + str(power).translate(SUPERSCRIPT))
    return found


