"""Is an arm cuspidal: can it change its posture, from one solution of a pose to another, without a singularity?

Two proofs that it cannot:

1. Signs. Where the equations of the inverse can be solved one after another, each in one unknown with at most two
   solutions, the derivative of each has opposite signs at its two solutions, and is a factor of det J. Each solution
   then has signs of its own, and no path between two of them keeps them. The arms for which this is known are in
   `_signs`; for three joints that move a point they are those of Wenger (axes 1, 2 or 2, 3 parallel or meeting).
2. No cusp. Three turning joints that move a point, with a singular set without nodes (generic in Burdick's sense), are
   cuspidal if and only if three solutions of the inverse meet somewhere (Salunkhe, Spartalis, Capco, Chablat and
   Wenger 2022, arXiv:2202.08686). Such a cusp is where the direction of motion that is lost in joint space,
   the kernel of d(f, g), is tangent to the singular curve D = 0:

       D = 0,   dD(v) = 0,   v = (−∂g/∂θ₃, ∂g/∂θ₂) and (−∂f/∂θ₃, ∂f/∂θ₂);

   nodes are where D = 0, dD = 0. Both are solved exactly; that there are none is a proof.

A cusp on a smooth point of the curve joins two of its three solutions, whether there are nodes elsewhere or not; the
arm is called cuspidal when a path between two solutions is proven free, which is not done here. An arm with six joints
and a spherical wrist behind its first three is cuspidal where these are: det J is the product of theirs and the
wrist's, whose two solutions have opposite signs.

f and g (`regional`) are functions of joints 2 and 3 that are left of a point p when joint 1 turns as it likes:

    f = |p|²,  g = p·z₁    (joint 1 turns about z₁; the origin on it)        f = p_x,  g = p_y    (it slides along z₁)

Given the point, f and g are known and joint 1 follows. det J of the three joints is ½ ∂(f, g)/∂(q₂, q₃), up to sign
(∂(f, g)/∂(q₂, q₃) for a slide): joint 1 does not occur in it, and postures are those of a map of the torus to a plane.

That three polynomials in two half-angle tangents have no common zero (`common_zeros`) is proven by eliminating two of
them against the first, by either variable. Real roots of the two univariate polynomials that are left hold every common
zero; they are isolated in balls, and a pair of balls on which one of the three cannot be zero is thrown out. That none
is left is a proof; what stays is zero to the precision of the balls, which is not a proof that it is one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import atan, atan2, pi, remainder
from typing import Any

from rankdrop.algebra.polynomial import Polynomial, coefficients, flint, primitive, variables_in
from rankdrop.algebra.ring import Form, Ring
from rankdrop.algebra.work import tick
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import ORIENTATION, POSE, POSITION, structure_of
from rankdrop.robot.model import JointKind

BITS = 600
"""Of the balls that the three are evaluated on: roots of degree 48 are told apart at a third of them."""
_MIX = (3, -7)

SIGNS, NO_CUSP, CUSPS, OPEN = "signs", "no cusp", "cusps", "open"
_TURNS = ((Fraction(0), Fraction(0)), (Fraction(2, 7), Fraction(3, 11)), (Fraction(5, 13), Fraction(4, 9)),
          (Fraction(8, 17), Fraction(7, 15)))  # fmt: skip
Pair = tuple[float, float]


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

    def derivative(self, h: Polynomial, joint: int) -> Polynomial:
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
        forth = self.derivative(f, 2) * self.derivative(g, 3)
        back = self.derivative(f, 3) * self.derivative(g, 2)
        return self.ring.reduce(forth - back)


def regional(chain: Chain, point: tuple[Fraction, Fraction, Fraction], turned: tuple[Fraction, Fraction]) -> Regional:
    """The map of joints 1, 2, 3 and a point of link 3.

    Args:
        chain: of three joints or more, lengths as numbers: letters are not looked at.
        point: in the frame of link 3: z along axis 3, x along the normal after it.
        turned: tan of half the angles by which θ₂ and θ₃ are counted on, so that nothing of note is at θ = π.
    """
    first, second, third = (section.kind is JointKind.REVOLUTE for section in chain.sections[:3])
    turns = {2: second, 3: third}
    ring = Ring([j for j in turns if turns[j]], [j for j in turns if not turns[j]])
    numbers = replace(chain, letters={}, written={})
    whole, pose = numbers.ring, numbers.link_pose(1, 3)
    p = [whole.reduce(sum((pose[i][h] * whole.constant(point[h]) for h in range(3)), pose[i][3])) for i in range(3)]
    if first:
        f, g = (whole.reduce(sum((x * x for x in p), whole.zero)), p[2])
    else:
        f, g = (p[0], p[1])
    places = [whole.trig.names().index(name) for name in ring.trig.names()]
    values = dict(zip(ring.trig.names(), ring.trig.gens(), strict=True))
    offsets = []
    for j, tangent in zip(turns, turned, strict=True):
        along, across = (1 - tangent**2) / (1 + tangent**2), 2 * tangent / (1 + tangent**2)
        offsets.append(chain.sections[j - 1].shift - (atan2(float(across), float(along)) if turns[j] else 0.0))
        if turns[j]:
            cosine, sine = ring.constant(along), ring.constant(across)
            values[f"s{j}"] = ring.s[j] * cosine + ring.c[j] * sine
            values[f"c{j}"] = ring.c[j] * cosine - ring.s[j] * sine

    def shift_variables(h: Polynomial) -> Polynomial:
        own = ring.trig.from_dict({tuple(powers[k] for k in places): value for powers, value in h.terms()})
        return ring.reduce(own.compose(*values.values(), ctx=ring.trig))

    return Regional(ring, shift_variables(f), shift_variables(g), (first, second, third), (offsets[0], offsets[1]))


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
        >>> from rankdrop.algebra.ring import Ring
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
        divisor = left[0].gcd(left[1])
        if divisor == 0:
            raise Unbounded
        eliminated.append(divisor)
    return _pairs((first, second, third), eliminated)


def _pairs(system: Sequence[Polynomial], eliminated: Sequence[Polynomial]) -> tuple[tuple[float, float], ...]:
    with flint().ctx.workprec(BITS):
        xs, ys = (_real_roots(f, place) for place, f in enumerate(eliminated))
        tick(40 * len(xs) * len(ys))
        pairs = [(float(x.mid()), float(y.mid())) for x in xs for y in ys
                 if all(_value_at(f, x, y).contains(0) for f in system)]  # fmt: skip
    return tuple(sorted(pairs))


def real_zeros(f: Polynomial, place: int) -> tuple[float, ...]:
    """Real zeros of a polynomial in one variable; none in the list: proven that there is none."""
    with flint().ctx.workprec(BITS):
        return tuple(sorted(float(x.mid()) for x in _real_roots(f, place)))


def _resultant(one: Polynomial, other: Polynomial, place: int) -> Polynomial:
    if other == 0:
        return other
    if place not in variables_in(one):
        return one
    tick(2_000 * (len(one) + len(other)))
    return one.resultant(other, place)


def _real_roots(f: Polynomial, place: int) -> list[Any]:
    """Balls around the roots that may be real: all that are, and none twice."""
    if not variables_in(f):
        return []
    module = flint()
    numbers = [int(c.leading_coefficient().p) if c != 0 else 0 for c in coefficients(primitive(f), place)]
    whole = module.fmpz_poly(numbers)
    tick(50 * len(numbers) ** 2)
    roots = []
    for factor, _ in whole.factor_squarefree()[1]:
        roots += [root.real for root, _ in factor.complex_roots() if root.imag.contains(0)]
    return roots


def _value_at(f: Polynomial, x: Any, y: Any) -> Any:
    arb = flint().arb
    powers = [[arb(1)], [arb(1)]]
    for known, value, degree in zip(powers, (x, y), f.degrees(), strict=False):
        for _ in range(degree):
            known.append(known[-1] * value)
    total = arb(0)
    for exponents, c in f.terms():
        total += arb(c) * powers[0][exponents[0]] * powers[1][exponents[1]]
    return total


@dataclass(frozen=True, slots=True)
class Decision:
    """What is decided without a search.

    Attributes:
        kind: `SIGNS` and `NO_CUSP`: proven not to be cuspidal; `CUSPS`: there are cusps (to the precision of balls of
            600 bits), and near each two solutions in one aspect; `OPEN`: none of these.
        why: of `SIGNS` how the inverse is solved, of `OPEN` what stands in the way: a key of `POSTURES` of
            `text/aspects.py`, or an error's own words.
        wrist: whether the first three joints are spoken of, of an arm with a spherical wrist behind them.
        cusps: (q₂, q₃) of each [rad].
        nodes: (q₂, q₃) where the singular curve crosses itself [rad]; None where they were not looked for.
    """

    kind: str
    why: str = ""
    wrist: bool = False
    cusps: tuple[Pair, ...] = ()
    nodes: tuple[Pair, ...] | None = None

    @property
    def impossible(self) -> bool:
        """Whether it is proven that no change of posture is free of singularities."""
        return self.kind in (SIGNS, NO_CUSP)


def decide_postures(chain: Chain) -> Decision:
    """Decide from the arm's exact lengths and twists whether it is cuspidal, where one of the two proofs applies.

    Args:
        chain: from `exact_chain`, with as many joints as the task has rows. Joints turn as far as they like.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> decide_postures(exact_chain(open_robot("puma560"))).why
        'axes 1, 2 meet'
    """
    rows, n = chain.task.rows, chain.n
    if chain.has_mimics:
        return Decision(OPEN, "coupled")
    if rows == POSE and n == 6 and structure_of(chain).wrist == (4, 5, 6):
        return _of_a_point(chain, _centre(chain), wrist=True)
    if rows == POSITION and n == 3:
        return _of_a_point(chain, chain.tip, wrist=False)
    if rows == ORIENTATION and n == 3:
        return Decision(SIGNS, "orientation")
    if rows == POSE and n == 6:
        if _three_parallel(chain):
            return Decision(SIGNS, "three parallel")
        return Decision(OPEN, "structure")
    if _planar(chain):
        return Decision(SIGNS, "planar")
    return Decision(OPEN, "structure")


def _centre(chain: Chain) -> tuple[Fraction, Fraction, Fraction]:
    link, along = chain.sections[2], chain.sections[3].d
    cosine, sine = link.twist.rational
    return link.a, -sine * along, cosine * along


def _three_parallel(chain: Chain) -> bool:
    """Whether axes 2, 3, 4 are parallel, 5 and 6 meet, and six joints turn.

    The point O of axes 5 and 6 keeps its height along axis 2, which leaves two values of θ1; the angle between axes 2
    and 6 leaves two of θ5; then axis 4 is known, and an arm of two links is left. The arm is singular where one of the
    three derivatives is zero: O cannot move along axis 2; no turn about axes 2, 5, 6 has the direction missing; elbow.
    """
    known = structure_of(chain)
    turning = all(section.kind is JointKind.REVOLUTE for section in chain.sections)
    return turning and (2, 3, 4) in known.parallel and (5, 6) in known.meeting


def _planar(chain: Chain) -> bool:
    """All axes parallel, slides along them: three turning joints whose sum is prescribed, or two of which it is not."""
    count = sum(section.kind is JointKind.REVOLUTE for section in chain.sections)
    one_direction = all(section.twist.sin == 0 for section in chain.sections[:-1])
    return one_direction and chain.n - count <= 1 and count == (3 if 5 in chain.task.rows else 2)


def _of_a_point(chain: Chain, point: tuple[Fraction, Fraction, Fraction], *, wrist: bool) -> Decision:
    known = regional(chain, point, _TURNS[0])
    why = _signs(chain, known)
    if why:
        return Decision(SIGNS, why, wrist)
    if not all(known.turns):
        return Decision(OPEN, "slide", wrist)
    for turned in _TURNS:
        moved = regional(chain, point, turned)
        try:
            decision = _cusps_and_nodes(moved)
        except Unbounded:
            continue
        cusps, nodes = (_in_q(moved, places) for places in decision[:2])
        if cusps:
            return Decision(CUSPS, "", wrist, cusps, nodes)
        if nodes or decision[2]:
            return Decision(OPEN, "nodes" if nodes else "point", wrist, (), nodes)
        return Decision(NO_CUSP, "", wrist, (), ())
    return Decision(OPEN, "repeated", wrist)


def _signs(chain: Chain, known: Regional) -> str:
    """Why each solution of the inverse has signs of its own: a key; "" where none of the known reasons holds."""
    first, second = chain.sections[:2]
    alone = {(which, joint): known.derivative(getattr(known, which), joint) == 0 for which in "fg" for joint in (2, 3)}
    early, late = known.turns[0] and known.turns[1], known.turns[1] and known.turns[2]
    reasons = (
        # |p|² or p·z₁ gives joint 3, two values with opposite derivatives; the other one then joint 2, likewise
        ("axes 1, 2 meet", early and first.a == 0 and alone["f", 2]),
        ("axes 1, 2 parallel", early and first.twist.sin == 0 and alone["g", 2]),
        # θ2, θ3 move p in a plane (u, w): g gives w, f then (u + a1)², two values; then an arm of two links
        ("axes 2, 3 parallel", late and second.twist.sin == 0),
        # p keeps its distance from O where axes 2 and 3 meet, which joint 1 alone moves: two values of q1; p·z₂ gives
        # two of θ3. det J = ((p − O)·(z₂ × z₃)) (z₁·(p × O))
        ("axes 2, 3 meet", late and second.a == 0),
        # f or g gives one of the joints, and the other function the other
        *((f"without {joint}", holds) for (_, joint), holds in alone.items()),
        ("orthogonal", late and _one_factor(known)),
        # f and g on the line that one linear equation leaves: one quadratic equation
        ("two slides", not (known.turns[1] or known.turns[2])),
    )  # fmt: skip
    return next((why for why, holds in reasons if holds), "")


def _one_factor(known: Regional) -> bool:
    """f = A + B(θ₂) U(θ₃), g = C + E(θ₂) U(θ₃) with numbers A and C, or the same with 2 and 3 exchanged.

    (f − A) E − (g − C) B = 0 is of first degree in sin θ₂, cos θ₂: two values, derivative U (B E′ − E B′); U then
    leaves two values of θ₃. D is U U′ (B′ E − B E′).
    """
    f, g = (_bilinear(h) for h in (known.f, known.g))
    return _shares_a_factor(f, g) or _shares_a_factor([*zip(*f, strict=True)], [*zip(*g, strict=True)])


def _bilinear(h: Polynomial) -> list[list[Fraction]]:
    """Coefficients of h by (1, c₂, s₂) and (1, c₃, s₃)."""
    names = h.context().names()
    matrix = [[Fraction(0)] * 3 for _ in range(3)]
    for exponents, value in h.terms():
        powers = dict(zip(names, (int(e) for e in exponents), strict=True))
        row, column = (powers[f"c{j}"] + 2 * powers[f"s{j}"] for j in (2, 3))
        matrix[row][column] = Fraction(int(value.p), int(value.q))
    return matrix


def _shares_a_factor(f: Sequence[Sequence[Fraction]], g: Sequence[Sequence[Fraction]]) -> bool:
    rows = [*f[1:], *g[1:]]
    u = next((row for row in rows if any(row)), None)
    if u is None:
        return False
    along = all(u[i] * row[j] == u[j] * row[i] for row in rows for i in range(3) for j in range(i))
    return along and all(u[1] * row[2] == u[2] * row[1] for row in (f[0], g[0])) and any(u[1:])


def _cusps_and_nodes(known: Regional) -> tuple[tuple[Pair, ...], tuple[Pair, ...], int]:
    """Half-angle tangents (t₂, t₃) of both, with nothing at θ = π, and how many factors of D are mapped to points.

    On a curve that is mapped to a point dD(v) is zero throughout, and nothing is a cusp.

    Raises:
        Unbounded: they are not isolated, or one may be at θ = π.
    """
    factors = _curves(known)
    whole = known.ring.half.constant(1)
    cusps: list[Pair] = []
    points = 0
    for d in factors:
        whole = whole * d
        slopes = _slopes(known, d)
        tangents = [slopes[1] * _half(known, known.derivative(h, 2)) - slopes[0] * _half(known, known.derivative(h, 3))
                    for h in (known.g, known.f)]  # fmt: skip
        if d.gcd(tangents[0]) == d.gcd(tangents[1]) == d.gcd(d):
            points += 1
            continue
        form = known.ring.form(d)
        wider = tuple(degree + 2 for degree in form.degrees)
        cusps += _zeros((form, *(Form(known.ring, tangent, wider) for tangent in tangents)))
    form = known.ring.form(whole)
    nodes = _zeros((form, *(replace(form, f=slope) for slope in _slopes(known, whole))))
    smooth = [place for place in cusps if not any(abs(place[0] - a) + abs(place[1] - b) < 1e-9 for a, b in nodes)]
    return tuple(sorted(smooth)), nodes, points


def _slopes(known: Regional, d: Polynomial) -> list[Polynomial]:
    """∂/∂θ₂ and ∂/∂θ₃ of the form that d stands for, of the same degrees, twice."""
    generators = zip(known.ring.half.gens(), d.degrees(), strict=True)
    return [d.derivative(k) * (1 + t**2) - m * t * d for k, (t, m) in enumerate(generators)]


def _zeros(system: tuple[Form, ...]) -> tuple[Pair, ...]:
    """Common zeros of three forms.

    Raises:
        Unbounded: they may all be zero where one of the angles is π.
    """
    joints = system[0].ring.revolute
    for place, joint in enumerate(joints):
        tops = [form.at({joint: "pi"}) for form in system]
        shared = tops[0].f.gcd(tops[1].f).gcd(tops[2].f)
        corner = all(top.at({joints[1 - place]: "pi"}).f == 0 for top in tops)
        if shared == 0 or corner or real_zeros(shared, 1 - place):
            raise Unbounded
    one, two, three = system
    return common_zeros(one.f, two.f, three.f)


def _curves(known: Regional) -> list[Polynomial]:
    """The factors of D, but those without a real zero.

    Raises:
        Unbounded: a factor is repeated, or one is θ = π.
    """
    form = known.ring.to_half(known.determinant)
    if form.at_pi:
        raise Unbounded
    curves = []
    for factor, power in form.f.factor()[1]:
        degrees = factor.degrees()
        if 0 in degrees and not real_zeros(factor, 0 if degrees[0] else 1):
            continue
        if power > 1:
            raise Unbounded
        curves.append(factor)
    return curves


def _half(known: Regional, p: Polynomial) -> Polynomial:
    """p times (1 + t₂²)(1 + t₃²): p is of first degree in each joint."""
    ring = known.ring
    form = ring.to_half(p)
    half = form.f
    for t, degree in zip(ring.half.gens(), form.degrees, strict=True):
        half = half * (1 + t**2) ** (1 - degree // 2)
    return half


def _in_q(known: Regional, places: tuple[Pair, ...]) -> tuple[Pair, ...]:
    """Half-angle tangents as joint angles in [−π, π], in order."""
    angles = ([2 * atan(t) - offset for t, offset in zip(place, known.offsets, strict=True)] for place in places)
    return tuple(sorted((remainder(a, 2 * pi), remainder(b, 2 * pi)) for a, b in angles))
