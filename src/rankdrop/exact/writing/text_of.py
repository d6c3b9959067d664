"""Trigonometric polynomials and the conditions of a stratum as text."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

from rankdrop.exact.algebra.atom import SIMPLE
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.polynomial import primitive
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.suppression.factors import Product, letters_polynomial, polynomial_of
from rankdrop.exact.suppression.stratum import Stratum
from rankdrop.exact.writing.form import Factor, Wave, product, total
from rankdrop.exact.writing.form import Product as Form
from rankdrop.exact.writing.fourier import fourier, symbols
from rankdrop.exact.writing.notation import SUPERSCRIPT, Text
from rankdrop.exact.writing.pins import WORDS
from rankdrop.exact.writing.shortest import gathered, length, parts_of, shortest


def text_of(ring: Ring, p: Polynomial) -> str:
    """A trigonometric polynomial, equal to it: s_j is sin θ_j, c_34 is cos(θ3 + θ4).

    Example:
        >>> ring = Ring([1, 2])
        >>> text_of(ring, ring.s[1] * ring.c[2] + ring.c[1] * ring.s[2])
        's12'
    """
    known, key = _known(ring), str(p)
    if key not in known:
        known[key] = _written(ring, p)
    return known[key]


@lru_cache(maxsize=8)
def _known(ring: Ring) -> dict[str, str]:
    """Texts found before, by polynomial: the same ones come back in every case."""
    return {}


def _written(ring: Ring, p: Polynomial) -> str:
    return "0" if p == 0 else Text().sum(parts_of(form_of(ring, p)))


def form_of(ring: Ring, p: Polynomial) -> Form:
    """The shortest form of a trigonometric polynomial that is not zero, equal to it."""
    f, multiples = ring.to_half(p)
    degrees = [2 * m for m in multiples]
    single, combined = single_angles(ring, p), fourier(f, degrees, ring)
    forms = [single, combined, gathered(single), gathered(combined)]
    if [int(d) for d in f.degrees()[: ring.angles]] == degrees:  # else zero at θ = π, which its degrees do not tell
        forms.append(shortest(f, ring))
    return min(forms, key=length)


def single_angles(ring: Ring, p: Polynomial) -> Form:
    """p as it stands, in sines and cosines of single angles."""
    waves = [Wave(kind, ((j, 2),)) for j in ring.revolute for kind in ("sin", "cos")]
    parts = []
    for powers, value in p.terms():
        angles: list[tuple[Factor, int]] = [(one, int(e)) for one, e in zip(waves, powers, strict=False) if e]
        number = Fraction(int(value.p), int(value.q))
        parts.append(product(number, angles + symbols(powers[len(waves) :], ring)))
    return total(parts)


def condition_text(ring: Ring, p: Polynomial, sign: str = "=") -> str:
    """The condition p = 0 (or ≠ 0): "s4 = 0", "θ4 = π", "a6 + d3 s6 + d5 s6 ≠ 0"."""
    wanted = primitive(p)
    for j in ring.revolute:
        for value in SIMPLE:
            if wanted == primitive(polynomial_of(ring, ring.pin(j, value))):
                return f"θ{j} {sign} {WORDS[value]}"
    text = text_of(ring, wanted)
    return f"{text_of(ring, -wanted) if text.startswith('−') else text} {sign} 0"


def conditions_text(stratum: Stratum, most: int | None = None) -> str:
    """The conditions of a stratum in one line; polynomials of more than `most` terms are not written out."""
    parts = []
    for polynomials, sign in ((stratum.closed, "="), (stratum.open, "≠")):
        for p in polynomials:
            long = most is not None and len(p) > most
            parts.append(f"({len(p)} terms) {sign} 0" if long else condition_text(stratum.ring, p, sign))
    return ", ".join(parts) or "everywhere"


def product_text(ring: Ring, product: Product) -> str:
    """A determinant as the product of its factors, or as it is where that is not how it factors."""
    if product.outer is None:
        return text_of(ring, product.polynomial)
    factors = [*((letters_polynomial(ring, f), power) for f, power in product.letters), *product.written]
    outer = text_of(ring, product.outer)
    negative = outer.startswith("−")
    outer = outer.removeprefix("−")
    found = [outer] if outer != "1" or not factors else []
    for f, power in factors:
        text = text_of(ring, f)
        if text.startswith("−"):
            text = text_of(ring, -f)
            negative ^= power % 2 == 1
        text = f"({text})" if " + " in text or " − " in text else text
        found.append(text if power == 1 else text + str(power).translate(SUPERSCRIPT))
    return ("−" if negative else "") + " ".join(found)


