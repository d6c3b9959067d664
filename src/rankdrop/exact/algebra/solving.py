"""One condition on half-angle tangents: the degrees it counts for, its factors, and solved for a variable."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rankdrop.exact.algebra.atom import TANGENT
from rankdrop.exact.algebra.effort import tick
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.polynomial import coefficients, used
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import OutOfTime, Work

_HUGE = 20_000_000  # products of terms: a second or two

Form = tuple[Polynomial, tuple[int, ...]]
"""A polynomial and the degree it counts for in each half-angle tangent: a lower one means a zero at θ_j = π."""


@dataclass(frozen=True)
class Solved:
    """t_k = numerator / denominator.

    Attributes:
        place: of the variable in the half-angle ring.
        numerator, denominator: in variables that are neither pinned nor solved before.
    """

    place: int
    numerator: Polynomial
    denominator: Polynomial


def form(f: Polynomial, ring: Ring) -> Form:
    """A polynomial that counts for its own degrees."""
    return f, tuple(int(d) for d in f.degrees()[: ring.angles])


def free_in(h: Polynomial, place: int, ring: Ring) -> list[Form]:
    """The coefficients of a condition by one of its variables: where all vanish it holds for every value of that one.

    Each counts for the degrees that the condition has in the other variables: a coefficient of a lower one is zero
    where that joint stands at π.

    Args:
        h: half-angle polynomial.
        place: of the variable.
        ring: of h.
    """
    degree = tuple(0 if k == place else int(d) for k, d in enumerate(h.degrees()[: ring.angles]))
    return [(part, degree) for part in coefficients(h, place) if part != 0]


def at(ring: Ring, one: Form, pins: Mapping[int, str]) -> Form:
    """A form with some joints at simple angles; at π the coefficient of the power it counts for."""
    f, degree = one
    pinned = {ring.index[f"t{joint}"] for joint in pins}
    return ring.half_at(f, pins, degree), tuple(0 if place in pinned else d for place, d in enumerate(degree))


def put(ring: Ring, one: Form, solved: Solved) -> Form:
    """A form with a solved variable put in."""
    f, degree = one
    turning = solved.place < ring.angles
    power = degree[solved.place] if turning else int(f.degrees()[solved.place])
    tops, bottoms = solved.numerator.degrees(), solved.denominator.degrees()
    left = [d + power * max(int(t), int(b)) for d, t, b in zip(degree, tops, bottoms, strict=False)]
    if turning:
        left[solved.place] = 0
    missing = power - int(f.degrees()[solved.place])
    return substituted(f, solved) * solved.denominator**missing, tuple(left)


def substituted(f: Polynomial, solved: Solved) -> Polynomial:
    """f(t_k = N / D) · D^degree.

    Raises:
        OutOfTime: it would have millions of terms; the product cannot be interrupted.
    """
    parts = coefficients(f, solved.place)
    longest = max(len(solved.numerator), len(solved.denominator))
    if len(f) * longest ** (len(parts) - 1) > _HUGE:
        raise OutOfTime(f"a condition of {len(f):,} terms would grow too long with a solution of {longest:,} put in")
    powers = [f.context().constant(1)]
    for _ in parts[1:]:
        powers.append(powers[-1] * solved.denominator)
    total = f.context().constant(0)
    top = f.context().constant(1)
    for power, part in enumerate(parts):
        if part != 0:
            total += part * top * powers[len(parts) - 1 - power]
        top = top * solved.numerator
    tick(20 + 2 * len(f) + (0.5 * len(solved.numerator) + 1) * len(total))
    return total


def linear(ring: Ring, f: Polynomial) -> Solved | None:
    """f solved for the variable in which it is linear with the shortest coefficients; None where there is none."""
    best: tuple[tuple[bool, int], Solved] | None = None
    for place, degree in enumerate(f.degrees()[: ring.moving]):
        if degree == 1:
            bottom, top = coefficients(f, place)
            rank = (not unit(ring, top), len(top) + len(bottom))
            if best is None or rank < best[0]:
                best = (rank, Solved(place, -bottom, top))
    return None if best is None else best[1]


def unit(ring: Ring, f: Polynomial) -> bool:
    """Whether f has no configuration in it, or no real zero for a plain reason."""
    return all(place >= ring.moving for place in used(f)) or ring.is_unit(f)


def factors(ring: Ring, f: Polynomial, work: Work) -> list[Polynomial]:
    """Irreducible factors that have real zeros, as far as that is plain; empty where there is none."""
    _, letters, atoms = ring.split(f)
    for one, _ in letters:
        work.assume(one)
    found = []
    for atom, _ in atoms:
        factor = atom.f
        if factor is None:
            factor = ring.t[atom.joint] - TANGENT[atom.value]
        if not plainly_positive(ring, factor):
            found.append(factor)
    return found


def plainly_positive(ring: Ring, f: Polynomial) -> bool:
    """Whether all powers are even and all coefficients of one sign, one of them without a joint: no real zero."""
    sign = None
    alone = False
    for powers, value in f.terms():
        if any(e % 2 for e in powers):
            return False
        positive = value > 0
        if sign is not None and positive != sign:
            return False
        sign = positive
        alone = alone or not any(powers[: ring.moving])
    return alone


def divides(h: Polynomial, f: Polynomial) -> bool:
    """Whether the first polynomial divides the second one."""
    return f != 0 and bool(divmod(f, h)[1] == 0)
