"""Polynomials in lengths alone: their value and sign for an arm, and as text."""

from __future__ import annotations

from fractions import Fraction

from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.polynomial import primitive
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.arm.chain import Chain

_ZERO = Fraction(1, 10**12)  # share of the terms' sizes below which their sum is rounding of the lengths given


def value_of(chain: Chain, f: Polynomial) -> float:
    """f at the arm's own lengths, a float; f is of the half-angle ring and contains no joint."""
    return float(sum(_terms(chain, f)))


def sign_of(chain: Chain, f: Polynomial) -> int:
    """Sign of f at the arm's own lengths: −1, 0 or 1."""
    parts = _terms(chain, f)
    value, size = sum(parts, Fraction(0)), sum(map(abs, parts), Fraction(0))
    return 0 if abs(value) <= _ZERO * size else (1 if value > 0 else -1)


def _terms(chain: Chain, f: Polynomial) -> list[Fraction]:
    """Values of the terms at the arm's own lengths, exactly."""
    parts = []
    for powers, value in f.terms():
        part = Fraction(int(value.p), int(value.q))
        for name, power in zip(chain.ring.names, powers, strict=True):
            if power:
                part *= chain.letters[name] ** int(power)
        parts.append(part)
    return parts


def never_zero(chain: Chain, f: Polynomial) -> bool:
    """Whether f cannot vanish while every length keeps its sign: all its terms have the same one."""
    signs = set()
    for powers, value in f.terms():
        negative = value < 0
        for name, power in zip(chain.ring.names, powers, strict=True):
            if power % 2 and chain.numbers[name] < 0:
                negative = not negative
        signs.add(negative)
    return len(signs) <= 1


def letters_text(ring: Ring, f: Polynomial) -> str:
    """A polynomial in lengths alone, factored: "(d3 − d5 − a6) (d3 − d5 + a6)"; "" for a positive number."""
    content, factors = f.factor()
    negative = bool(content < 0)
    parts = []
    for factor, power in factors:
        kept = primitive(factor)
        if power % 2 and factor.coeffs()[0] < 0:
            negative = not negative
        text = sum_text(ring, kept)
        parts.append((f"({text})" if len(kept) > 1 and len(factors) + power > 2 else text) + _power(int(power)))
    text = " ".join(parts)
    return f"−{text}" if negative and text else text


def sum_text(ring: Ring, f: Polynomial) -> str:
    """A polynomial in lengths alone as a sum: "d3² − 2 d3 d5"."""
    text = ""
    for powers, value in f.terms():
        number = abs(value)
        factors = [f"{name}{_power(int(e))}" for name, e in zip(ring.names, powers, strict=True) if e]
        body = " ".join(([] if number == 1 and factors else [str(number)]) + factors)
        if text:
            text += f" {'−' if value < 0 else '+'} {body}"
        else:
            text = ("−" if value < 0 else "") + body
    return text or "0"


def _power(e: int) -> str:
    return "" if e == 1 else str(e).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
