"""A proof that a set holds no configuration of lower rank: elimination modulo a prime.

Where the rank is lower than r every minor of order r vanishes, so every resultant of two of them does, and every
resultant of these, down to polynomials in one variable. If these have no common zero but t = ±i, where no configuration
is, there is none. All is done modulo P with every angle turned by a random one, so that no solution stands at θ = π,
where half-angle tangents are infinite, and with the arm's own lengths for letters. What is not there for one choice of
lengths is not there for almost all: the configurations are compact, and where there is one is closed.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations, islice
from math import prod

from rankdrop.exact.algebra.field import P, roots_at
from rankdrop.exact.algebra.polynomial import ROOTS, Polynomial, flint, image_modulo
from rankdrop.exact.algebra.ring import Form, Ring
from rankdrop.exact.algebra.work import Work, spent, tick

_EACH = 6  # polynomials kept of those in the same variables
_LENGTH = 1_000_000  # letters without a value stand at random whole numbers up to this
_MINORS = 400  # of all choices of rows and columns
_TERMS = 6_000  # that a resultant may have
_COST = {1: 10**6, 2: 60_000, 3: 4_000}  # product of the numbers of terms of two polynomials, by their variables
_ROUNDS = 5  # eliminations behind one another: one for each joint but one
_SINGLE = 40  # degree of a polynomial in one variable that is put into others
_LIMIT = 3.0  # work after which there is no proof [s]
_SEED = 61


def barren(
    ring: Ring,
    columns: Sequence[Sequence[Polynomial]],
    order: int,
    pins: Mapping[int, str],
    conditions: Sequence[Polynomial],
    work: Work,
) -> bool:
    """Whether a set is proven to hold no configuration at which the rank is lower than `order`.

    Args:
        ring: of the polynomials.
        columns: of the Jacobian, entries of `ring.trig`.
        order: r.
        pins: joints at simple angles on the set.
        conditions: half-angle polynomials that vanish on it.
        work: deadline; the lengths of the arm.

    Returns:
        True with a proof modulo P; False where none was found.
    """
    rng = random.Random(_SEED)
    turned = _turned(ring, rng)
    known = _Known(ring)
    lengths = {name: _number(work.lengths.get(name, Fraction(rng.randrange(1, _LENGTH))))
               for name in ring.letters if name not in ROOTS}  # fmt: skip
    for f in conditions:
        known.add(turned(Form(ring, f.subs(lengths), ring.form(f).degrees)))
    here = [[ring.at(x.subs(lengths) if x != 0 else x, pins) for x in column] for column in columns]
    until = spent() + _LIMIT
    for minor in islice(_minors(ring, here, order), _MINORS):
        work.check()
        known.add(turned(ring.to_half(minor)))
        if known.barren:
            return True
    for _ in range(_ROUNDS):
        fresh = list(known.eliminated(work, until))
        if known.barren:
            return True
        if not fresh or spent() > until:
            break
    return False


def _number(value: Fraction) -> Polynomial:
    return flint().fmpq(value.numerator, value.denominator)


def _minors(ring: Ring, columns: Sequence[Sequence[Polynomial]], order: int) -> Iterator[Polynomial]:
    """Minors that are not zero for a plain reason, neighbouring columns first: these depend on fewest joints."""
    n, m = len(columns), len(columns[0])
    for chosen in sorted(combinations(range(n), order), key=lambda c: c[-1] - c[0]):
        for rows in combinations(range(m), order):
            minor = ring.determinant([[columns[c][r] for c in chosen] for r in rows])
            if minor != 0:
                yield minor


def _turned(ring: Ring, rng: random.Random) -> Callable[[Form], Polynomial]:
    """f ↦ f · Π (1 − u_j t_j)^D_j modulo P with each angle turned at random: tan((θ + φ) / 2) = (t + u) / (1 − u t)."""
    module = flint()
    context = module.nmod_mpoly_ctx.get(list(ring.names[: ring.moving]), P, module.Ordering.lex)
    turns = [(t + u, 1 - t * u) for t in context.gens()[: ring.angles] for u in [rng.randrange(2, P)]]

    def turned(form: Form) -> Polynomial:
        residues, degrees = image_modulo(form.f, roots_at(ring, P), P), form.degrees
        tick(20 + 12 * len(form.f) + 2 * prod(1 + degree for degree in degrees))
        powers: dict[tuple[int, int], Polynomial] = {}

        def nested(items: list[tuple[tuple[int, ...], int]], k: int) -> Polynomial:
            """Σ c t^e with the angles from the k-th on turned: one power of each is multiplied in at a time."""
            if k == ring.angles:
                return context.from_dict({(0,) * k + e[k : ring.moving]: value for e, value in items})
            groups: dict[int, list[tuple[tuple[int, ...], int]]] = {}
            for item in items:
                groups.setdefault(item[0][k], []).append(item)
            total = context.constant(0)
            for power, group in groups.items():
                inner = nested(group, k + 1)
                if degrees[k]:
                    if (k, power) not in powers:
                        top, bottom = turns[k]
                        powers[k, power] = top**power * bottom ** (degrees[k] - power)
                    inner = inner * powers[k, power]
                total += inner
            return total

        return nested([(tuple(map(int, e)), int(value)) for e, value in residues.to_dict().items()], 0)

    return turned


class _Known:
    def __init__(self, ring: Ring) -> None:
        self._angles, self._moving = ring.angles, ring.moving
        self._by_variables: dict[tuple[int, ...], list[Polynomial]] = {}
        self._single: dict[int, Polynomial] = {}  # gcd of those in one variable
        self._tried: set[tuple[int, int, int]] = set()
        self._kept: list[Polynomial] = []
        self.barren = False

    def add(self, f: Polynomial) -> bool:
        """Keep one more; whether it tells anything new."""
        if f == 0 or len(f) > _TERMS:
            return False
        degrees = f.degrees()
        places = tuple(k for k in range(self._moving) if degrees[k])
        if not places:
            self.barren = True
            return True
        if len(places) == 1:
            place = places[0]
            before = self._single.get(place)
            common = self._real(f, place) if before is None else before.gcd(f)
            self._single[place] = common
            self.barren = self.barren or common.total_degree() == 0
            return before is None or common.total_degree() < before.total_degree()
        same = self._by_variables.setdefault(places, [])
        if len(same) >= _EACH:
            return False
        if len(places) == 2 and sum(f.gcd(other).total_degree() > 0 for other in same) > 1:
            return False  # of those with a common factor two are enough
        same.append(f)
        self._kept.append(f)
        return True

    def _real(self, f: Polynomial, place: int) -> Polynomial:
        """f without its factors 1 + t²: no configuration is there."""
        if place < self._angles:
            circle = 1 + f.context().gens()[place] ** 2
            while f.total_degree() > 1:
                quotient, rest = divmod(f, circle)
                if rest != 0:
                    break
                f = quotient
        return f

    def eliminated(self, work: Work, until: float) -> Iterator[Polynomial]:
        """Resultants of pairs in few variables together, which are kept as well; none begun after so much work."""
        names = [str(g) for g in (self._kept[0].context().gens() if self._kept else ())]
        singles = [f for f in self._single.values() if f.total_degree() <= _SINGLE]
        pool = sorted([*singles, *self._kept], key=len)
        pairs = []
        for f, g in combinations(pool, 2):
            one, two = ({k for k in range(self._moving) if h.degrees()[k]} for h in (f, g))
            if one & two and len(f) * len(g) <= _COST.get(len(one | two), 0):
                pairs += [(len(one | two), len(f) * len(g), f, g, k) for k in one & two if _size(f, g, k) <= _TERMS]
        for _, cost, f, g, k in sorted(pairs, key=lambda pair: pair[:2]):
            key = (id(f), id(g), k)
            if key in self._tried:
                continue
            self._tried.add(key)
            work.check()
            if f.gcd(g).total_degree() > 0:
                continue  # the resultant is zero
            both = f.resultant(g, names[k])
            tick(50 + 1.5 * cost + 2 * _size(f, g, k))
            if self.add(both):
                yield both
            if self.barren or spent() > until:
                return


def _size(f: Polynomial, g: Polynomial, place: int) -> int:
    """Number of terms that the resultant of two polynomials may have."""
    one, two = (list(map(int, h.degrees())) for h in (f, g))
    a, b = one[place], two[place]
    return prod(1 + b * x + a * y for k, (x, y) in enumerate(zip(one, two, strict=True)) if k != place)
