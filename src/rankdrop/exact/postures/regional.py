"""How three joints move a point, once the first one is taken out of it.

Of a point p that joints 1, 2, 3 move, two functions of joints 2 and 3 are left when joint 1 turns as it likes:

    f = |p|²,  g = p·z₁    (joint 1 turns about z₁; the origin on it)        f = p_x,  g = p_y    (it slides along z₁)

Given the point, f and g are known and joint 1 follows. det J of the three joints is ½ ∂(f, g)/∂(q₂, q₃), up to sign
(∂(f, g)/∂(q₂, q₃) for a slide): joint 1 does not occur in it, and postures are those of a map of the torus to a plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import atan2

from rankdrop.exact.algebra.polynomial import Polynomial
from rankdrop.exact.algebra.ring import Ring
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
    zero, one, phase = ring.zero, ring.one, section.phase
    d = ring.constant(section.d)
    if section.kind is JointKind.PRISMATIC:
        c, s, angle = ring.constant(phase.cos), ring.constant(phase.sin), 0.0
        d = d + ring.q[j]
    else:
        along, across = (1 - tangent**2) / (1 + tangent**2), 2 * tangent / (1 + tangent**2)
        cosine, sine = phase.cos * along - phase.sin * across, phase.sin * along + phase.cos * across
        c = ring.c[j] * ring.constant(cosine) - ring.s[j] * ring.constant(sine)
        s = ring.s[j] * ring.constant(cosine) + ring.c[j] * ring.constant(sine)
        angle = atan2(float(across), float(along))
    return [[c, -s, zero, zero], [s, c, zero, zero], [zero, zero, one, d], [zero, zero, zero, one]], angle


def _link(ring: Ring, section: Section) -> Matrix:
    """Tx(a) Rx(α)."""
    c, s, a = (ring.constant(x) for x in (section.twist.cos, section.twist.sin, section.a))
    zero, one = ring.zero, ring.one
    return [[one, zero, zero, a], [zero, c, -s, zero], [zero, s, c, zero], [zero, zero, zero, one]]
