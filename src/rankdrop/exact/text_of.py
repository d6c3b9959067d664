"""A trigonometric polynomial as plain text."""

from __future__ import annotations

from rankdrop.exact.flint import Polynomial
from rankdrop.exact.ring import Ring
from rankdrop.exact.stratum import Stratum
from rankdrop.exact.stratum_factors import Product, letters_polynomial


def text_of(ring: Ring, p: Polynomial) -> str:
    """p in s_j, c_j, q_j and lengths, with a space between factors."""
    return str(p).replace("*", " ")


def conditions_text(stratum: Stratum) -> str:
    """The conditions of a stratum in one line."""
    ring = stratum.ring
    parts = [f"{text_of(ring, p)} = 0" for p in stratum.closed] + [f"{text_of(ring, p)} ≠ 0" for p in stratum.open]
    return ", ".join(parts) or "everywhere"


def product_text(ring: Ring, product: Product) -> str:
    """A determinant as the product of its factors, or as it is where it has a square or a factor without zeros."""
    if product.outer is None:
        return text_of(ring, product.polynomial)
    parts = []
    for f, power in [*((letters_polynomial(ring, f), power) for f, power in product.letters), *product.written]:
        text = text_of(ring, f)
        text = f"({text})" if len(f) > 1 else text
        parts.append(text if power == 1 else f"{text}^{power}")
    outer = text_of(ring, product.outer)
    return " ".join([outer, *parts] if outer not in ("1", "-1") else parts) if outer != "-1" else "-" + " ".join(parts)
