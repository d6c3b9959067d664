"""How three joints move a point, once the first one is taken out of it; and proofs that such maps have no common zero.

Of a point p that joints 1, 2, 3 move, two functions of joints 2 and 3 are left when joint 1 turns as it likes:

    f = |p|²,  g = p·z₁    (joint 1 turns about z₁; the origin on it)        f = p_x,  g = p_y    (it slides along z₁)

Given the point, f and g are known and joint 1 follows. det J of the three joints is ½ ∂(f, g)/∂(q₂, q₃), up to sign
(∂(f, g)/∂(q₂, q₃) for a slide): joint 1 does not occur in it, and postures are those of a map of the torus to a plane.

Of three polynomials in two half-angle tangents two are eliminated against the first, by either variable. Real roots of
the two univariate polynomials that are left hold every common zero; they are isolated in balls, and a pair of balls on
which one of the three cannot be zero is thrown out. That none is left is a proof; what stays is zero to the precision
of the balls, which is not a proof that it is one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import atan2
from typing import Any

from rankdrop.exact.algebra.polynomial import Polynomial, coefficients, flint, primitive, used
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import tick
from rankdrop.exact.arm.chain import Chain, Matrix, identity, times
from rankdrop.exact.arm.geometry import Section
from rankdrop.robot.model import JointKind


@dataclass(frozen=True, eq=False)
class Regional:
    """f and g, and what they are made of.

    Attributes:
        ring: of joints 2 and 3.
        f, g: as above.
        turns: whether joints 1, 2, 3 turn.
        offsets: (2,) to be added to q₂ and q₃ to get the angles that the ring speaks of [rad].
    """

    ring: Ring
    f: Polynomial
    g: Polynomial
    turns: tuple[bool, bool, bool]
    offsets: tuple[float, float]

    def by(self, h: Polynomial, joint: int) -> Polynomial:
        """∂h/∂q_joint, reduced."""
        ring = self.ring
        names = h.context().names()
        if not self.turns[joint - 1]:
            return h.derivative(names.index(f"q{joint}"))
        s, c = names.index(f"s{joint}"), names.index(f"c{joint}")
        return ring.reduce(h.derivative(s) * ring.c[joint] - h.derivative(c) * ring.s[joint])

    @property
    def determinant(self) -> Polynomial:
        """∂(f, g)/∂(q₂, q₃), reduced."""
        f, g = self.f, self.g
        return self.ring.reduce(self.by(f, 2) * self.by(g, 3) - self.by(f, 3) * self.by(g, 2))


def regional(chain: Chain, point: tuple[Fraction, Fraction, Fraction], turned: tuple[Fraction, Fraction]) -> Regional:
    """The map of joints 1, 2, 3 and a point of link 3.

    Args:
        chain: of three joints or more, lengths as numbers: letters are not looked at.
        point: in the frame of link 3: z along axis 3, x along the normal after it.
        turned: tan of half the angles by which θ₂ and θ₃ are counted on, so that nothing of note is at θ = π.
    """
    three = chain.sections[:3]
    turns = tuple(one.kind is JointKind.REVOLUTE for one in three)
    ring = Ring([j for j in (2, 3) if turns[j - 1]], [j for j in (2, 3) if not turns[j - 1]])
    at = [ring.constant(x) for x in point]
    pose = identity(ring)
    offsets = []
    for j, (section, tangent) in enumerate(zip(three[1:], turned, strict=True), start=2):
        joint, angle = _joint(ring, j, section, tangent)
        pose = times(ring, times(ring, pose, _link(ring, three[j - 2])), joint)
        offsets.append(section.shift - angle)
    p = [ring.reduce(sum((pose[i][h] * at[h] for h in range(3)), pose[i][3])) for i in range(3)]
    if turns[0]:
        f, g = ring.reduce(sum((x * x for x in p), ring.zero)), p[2]
    else:
        f, g = p[0], p[1]
    return Regional(ring, f, g, (turns[0], turns[1], turns[2]), (offsets[0], offsets[1]))


def _joint(ring: Ring, j: int, section: Section, tangent: Fraction) -> tuple[Matrix, float]:
    """Rz(θ + phase) Tz(d) with θ counted from another place, and by what the new θ is behind the old one."""
    zero, one, phase = ring.zero, ring.one, section.phase.rational
    d = ring.constant(section.d)
    if section.kind is JointKind.PRISMATIC:
        c, s, angle = ring.constant(phase[0]), ring.constant(phase[1]), 0.0
        d = d + ring.q[j]
    else:
        along, across = (1 - tangent**2) / (1 + tangent**2), 2 * tangent / (1 + tangent**2)
        cosine, sine = phase[0] * along - phase[1] * across, phase[1] * along + phase[0] * across
        c = ring.c[j] * ring.constant(cosine) - ring.s[j] * ring.constant(sine)
        s = ring.s[j] * ring.constant(cosine) + ring.c[j] * ring.constant(sine)
        angle = atan2(float(across), float(along))
    return [[c, -s, zero, zero], [s, c, zero, zero], [zero, zero, one, d], [zero, zero, zero, one]], angle


def _link(ring: Ring, section: Section) -> Matrix:
    """Tx(a) Rx(α)."""
    c, s, a = (ring.constant(x) for x in (*section.twist.rational, section.a))
    zero, one = ring.zero, ring.one
    return [[one, zero, zero, a], [zero, c, -s, zero], [zero, s, c, zero], [zero, zero, zero, one]]


BITS = 600
"""Of the balls that the three are evaluated on: roots of degree 48 are told apart at a third of them."""
_MIX = (3, -7)


class Unbounded(Exception):
    """The three vanish together on a curve, or where one of the variables is infinite."""


def common_zeros(first: Polynomial, second: Polynomial, third: Polynomial) -> tuple[tuple[float, float], ...]:
    """Real (x, y) where all three polynomials in x and y vanish.

    Args:
        first, second, third: of one ring, in its first two variables only; the first has no factor of one variable
            that the others share.

    Returns:
        The candidates that no ball throws out, in order; empty: proven that there is none with x and y finite.

    Raises:
        Unbounded: they are zero together on a curve.

    Example:
        >>> from rankdrop.exact.algebra.ring import Ring
        >>> x, y = Ring([1, 2]).half.gens()
        >>> common_zeros(x**2 + y**2 - 2, x - y, x * y - 1)
        ((-1.0, -1.0), (1.0, 1.0))
        >>> common_zeros(x**2 + y**2 - 2, x - y, x * y + 1)
        ()
    """
    mixed = [second + factor * third for factor in _MIX]
    eliminated = []
    for place in (0, 1):  # what is left depends on this variable
        left = [_resultant(first, other, 1 - place) for other in mixed]
        found = left[0].gcd(left[1])
        if found == 0:
            raise Unbounded
        eliminated.append(found)
    return _pairs((first, second, third), eliminated)


def _pairs(system: Sequence[Polynomial], eliminated: Sequence[Polynomial]) -> tuple[tuple[float, float], ...]:
    module = flint()
    kept, module.ctx.prec = module.ctx.prec, BITS
    try:
        xs, ys = (_real_roots(f, place) for place, f in enumerate(eliminated))
        tick(40 * len(xs) * len(ys))
        found = [(float(x.mid()), float(y.mid())) for x in xs for y in ys
                 if all(_at(f, x, y).contains(0) for f in system)]  # fmt: skip
    finally:
        module.ctx.prec = kept
    return tuple(sorted(found))


def real_zeros(f: Polynomial, place: int) -> tuple[float, ...]:
    """Real zeros of a polynomial in one variable; none in the list: proven that there is none."""
    module = flint()
    kept, module.ctx.prec = module.ctx.prec, BITS
    try:
        return tuple(sorted(float(x.mid()) for x in _real_roots(f, place)))
    finally:
        module.ctx.prec = kept


def _resultant(one: Polynomial, other: Polynomial, place: int) -> Polynomial:
    if other == 0:
        return other
    if place not in used(one):
        return one**0 if other == 0 else one
    tick(2_000 * (len(one) + len(other)))
    return one.resultant(other, place)


def _real_roots(f: Polynomial, place: int) -> list[Any]:
    """Balls around the roots that may be real: all that are, and none twice."""
    if not used(f):
        return []
    module = flint()
    numbers = [int(c.leading_coefficient().p) if c != 0 else 0 for c in coefficients(primitive(f), place)]
    whole = module.fmpz_poly(numbers)
    tick(50 * len(numbers) ** 2)
    roots = []
    for factor, _ in whole.factor_squarefree()[1]:
        roots += [root.real for root, _ in factor.complex_roots() if root.imag.contains(0)]
    return roots


def _at(f: Polynomial, x: Any, y: Any) -> Any:
    arb = flint().arb
    powers = [[arb(1)], [arb(1)]]
    for known, value, degree in zip(powers, (x, y), f.degrees(), strict=False):
        for _ in range(degree):
            known.append(known[-1] * value)
    total = arb(0)
    for exponents, c in f.terms():
        total += arb(c) * powers[0][exponents[0]] * powers[1][exponents[1]]
    return total
