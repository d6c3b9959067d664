"""Steps on systems of conditions in half-angle tangents: solve one for a variable, combine two, test what they bind.

Two conditions are combined into one of a lower degree, or into one with a variable less. `binds_more` decides whether a
system binds more than so many freedoms, by its points on random planes, modulo a prime. A set of codimension c meets
every plane of dimension c in general position. So a system without a common zero on random lines (planes) has no piece
of codimension 1 (2). Zeros count wherever they are, modulo the prime or in an extension of its field, but for those
with 1 + t² = 0 for a half-angle tangent: no configuration is there.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import chain, combinations, permutations
from math import prod

from rankdrop.algebra.field import dense, modulo_prime, plane_size, residue, roots, solvable_in_space
from rankdrop.algebra.gcd import image_modulo
from rankdrop.algebra.halt import Halt, HaltKind, TooLong
from rankdrop.algebra.polynomial import (
    Atom,
    Polynomial,
    coefficient,
    coefficients,
    flint,
    norm,
    primitive,
    reduced_roots,
    roots_in,
    used_by,
    variables_in,
)
from rankdrop.algebra.ring import Form, Ring
from rankdrop.algebra.roots import PRIMES, primes_with, residues_of_roots
from rankdrop.algebra.work import Work, tick

_HUGE = 20_000_000  # products of terms: a second or two

_ROOTED = 120  # degree of a polynomial in one variable of which real roots are looked for

_LARGE = 1500  # product of the numbers of terms beyond which a variable is not eliminated: the result would fill pages
_DEGREE = 64  # product of two degrees beyond which their resultant takes seconds
_POWERS = 200_000  # and so it does where its degrees allow for more terms than this

_SEED = 20
_SLICES = 12  # primes: a piece has no zero modulo a prime on a slice with a chance of 1/e: on all of them with 6e-6

_SHEARED = 1_500  # terms that a resultant of two sheared conditions may have


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


def substitute_into_form(form: Form, solved: Solved) -> Form:
    """A form with a solved variable put in."""
    ring, f = form.ring, form.f
    turning = solved.place < ring.angles
    if turning:
        power = form.degrees[solved.place]
    else:
        power = int(f.degrees()[solved.place])
    tops, bottoms = solved.numerator.degrees(), solved.denominator.degrees()
    left = [d + power * max(int(t), int(b)) for d, t, b in zip(form.degrees, tops, bottoms, strict=False)]
    if turning:
        left[solved.place] = 0
    missing = power - int(f.degrees()[solved.place])
    return Form(ring, reduced_roots(substitute_solution(f, solved) * solved.denominator**missing), tuple(left))


def substitute_solution(f: Polynomial, solved: Solved) -> Polynomial:
    """f(t_k = N / D) · D^degree.

    Raises:
        TooLong: it would have millions of terms; the product cannot be interrupted.
    """
    parts = coefficients(f, solved.place)
    longest, power = max(len(solved.numerator), len(solved.denominator)), len(parts) - 1
    degrees = zip(f.degrees(), solved.numerator.degrees(), solved.denominator.degrees(), strict=True)
    bounds = [1 + max(int(d), 0) + power * max(int(a), int(b), 0) for d, a, b in degrees]
    dense = longest * prod(bounds) // bounds[solved.place]
    if min(len(f) * longest**power, dense) > _HUGE:
        raise TooLong(Halt(HaltKind.SUBSTITUTION, terms=len(f), others=longest))
    powers = [f.context().constant(1)]
    for _ in parts[1:]:
        powers.append(reduced_roots(powers[-1] * solved.denominator))
    total = f.context().constant(0)
    top = f.context().constant(1)
    for power, part in enumerate(parts):
        if part != 0:
            total += part * top * powers[len(parts) - 1 - power]
        top = reduced_roots(top * solved.numerator)
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
    return all(place >= ring.moving for place in variables_in(f)) or ring.is_unit(f)


def atoms(form: Form, work: Work) -> list[Atom]:
    """The irreducible conditions under one of which a form vanishes, those at π first, less those that have no real
    zero for a plain reason; empty where it never does. Lengths are assumed not to vanish.
    """
    letters, every = form.factors()
    for letter, _ in letters:
        work.assume(letter)
    return [atom for atom, _ in every if atom.is_pin or not plainly_positive(form.ring, atom.f)]


def factors(ring: Ring, f: Polynomial, work: Work) -> list[Polynomial]:
    """`atoms` of a polynomial that counts for its own degrees, as polynomials."""
    return [ring.half_of(atom) for atom in atoms(ring.form(f), work)]


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


def without_real_root(f: Polynomial) -> bool:
    """Whether a polynomial in one variable, with numbers for lengths, is proven to have no real zero."""
    if len(variables_in(f)) > 1 + len(roots_in(f)):
        return False
    f = norm(f)[0]
    places = variables_in(f)
    if len(places) != 1:
        return False
    whole = [0] * (int(f.degrees()[places[0]]) + 1)
    for powers, value in primitive(f).terms():
        whole[int(powers[places[0]])] = int(value.p)
    # enclosures: one that holds no real number is a proof
    return not any(root.imag.contains(0) for root, _ in flint().fmpz_poly(whole).complex_roots())


def without_real_zero(ring: Ring, system: Sequence[Polynomial]) -> bool:
    """Whether conditions on two variables, with numbers for lengths, are proven to have no real zero in common.

    At a common zero the resultants of any two of them in one variable vanish, and so does the greatest common divisor
    of these: where that has no real root there is no such zero. Resultants that would be long are not computed.
    """
    places = sorted(used_by(system))
    if len(places) != 2 or places[1] >= ring.moving:
        return False
    first, second = places
    kept = chain(_projections(ring, system, first, second), _projections(ring, system, second, first))
    return any(map(_never_real, kept))


def _projections(ring: Ring, system: Sequence[Polynomial], place: int, other: int) -> Iterator[Polynomial]:
    """Polynomials in one of two variables, each a divisor of the one before, that vanish at the zeros of a system."""
    common: Polynomial = system[0] * 0
    for f in system:
        if variables_in(f) == [place]:
            common = common.gcd(f)
            yield common
    for f, g in combinations(sorted(system, key=len), 2):
        m, n = f.degrees(), g.degrees()
        if not m[other] * n[other] or m[place] * n[other] + m[other] * n[place] > _ROOTED:
            continue
        tick(100 + 5 * len(f) * len(g))
        common = common.gcd(f.resultant(g, ring.names[other]))
        yield common


def _never_real(f: Polynomial) -> bool:
    """Whether a polynomial in at most one variable is seen to have no real zero."""
    return f != 0 and (not variables_in(f) or without_real_root(f))


def divisions(ring: Ring, system: list[Polynomial]) -> Iterator[tuple[Polynomial, Polynomial, int]]:
    """(divisor, condition, place): a condition whose degree in a variable falls when it is divided by another one.

    The divisor has no joint of its own and a leading coefficient without joints, so that nothing is lost. What is left
    may factor where the condition itself did not.
    """
    for f, g in permutations(system, 2):
        joints = {place for place in variables_in(f) if place < ring.moving}
        if joints < {place for place in variables_in(g) if place < ring.moving}:
            for k in joints:
                if f.degrees()[k] <= g.degrees()[k] and unit(ring, coefficients(f, k)[-1]):
                    yield f, g, k


def remainder(ring: Ring, g: Polynomial, f: Polynomial, k: int, work: Work) -> Form:
    """The pseudo-remainder of g divided by f in one variable; it counts for the degrees of g in the others.

    Raises:
        OutOfTime: the deadline has passed.
    """
    degree = list(ring.form(g).degrees)
    divisor = coefficients(f, k)
    t = f.context().gens()[k]
    while g != 0 and g.degrees()[k] >= len(divisor) - 1:
        work.check()
        top = coefficient(g, k, int(g.degrees()[k]))
        tick(20 + len(f) * len(top) + len(g) * len(divisor[-1]))
        g = reduced_roots(g * divisor[-1] - f * top * t ** (g.degrees()[k] - len(divisor) + 1))
    if k < ring.angles:
        degree[k] = int(g.degrees()[k]) if g != 0 else 0
    return Form(ring, g, tuple(degree))


def eliminable(f: Polynomial, g: Polynomial, k: int) -> bool:
    """Whether the resultant is worth its time: it cannot be interrupted."""
    m, n = f.degrees(), g.degrees()
    if len(f) * len(g) > _LARGE or int(m[k]) * int(n[k]) > _DEGREE:
        return False
    powers = (1 + a * n[k] + b * m[k] for place, (a, b) in enumerate(zip(m, n, strict=True)) if place != k)
    return prod(map(int, powers)) <= _POWERS


def pairs(ring: Ring, system: list[Polynomial]) -> list[tuple[Polynomial, Polynomial, int]]:
    """Two conditions and a variable that both contain, low degrees first."""
    solvable = [
        (f, g, k)
        for f, g in combinations(system, 2)
        for k in range(ring.moving)
        if f.degrees()[k] and g.degrees()[k]
    ]
    return sorted(solvable, key=lambda one: _cost(*one))


def _cost(f: Polynomial, g: Polynomial, k: int) -> tuple[int, int, int]:
    """Sort key: variables, degree and terms of what the two would be combined into."""
    return len({*variables_in(f), *variables_in(g)}), f.degrees()[k] * g.degrees()[k], len(f) * len(g)


def combine_to_linear(ring: Ring, f: Polynomial, g: Polynomial, k: int) -> Polynomial:
    """Two conditions of degree 2 in a variable combined into one of degree 1; others into one without the variable."""
    if f.degrees()[k] == g.degrees()[k] == 2:
        return reduced_roots(f * coefficients(g, k)[2] - g * coefficients(f, k)[2])
    resultant = f.resultant(g, ring.names[k])
    tick(100 + 5 * len(f) * len(g) + 50 * len(resultant))
    return reduced_roots(resultant)


def binds_more(
    system: Sequence[Polynomial], most: int, moving: int, lengths: Mapping[str, Fraction] | None = None
) -> bool:
    """Whether a system has no piece of codimension `most` or less that could be real.

    Only `most` of 1 and 2 are looked into; for more the answer is False.

    Args:
        system: polynomials of the half-angle ring.
        most: codimension.
        moving: so many of their first variables depend on the configuration; the others are lengths.
        lengths: that letters stand for; random numbers for those without.
    """
    if most < 1:
        return bool(system)
    lengths = lengths or {}
    if any(_have_no_common_zero(part, moving, lengths) for part in _in_two_variables(system, moving)):
        return True
    variables = {place for place in used_by(system) if place < moving}
    dimension = min(most, len(variables))  # a zero at all binds no more freedoms than there are variables
    if dimension > 2 or len(system) <= dimension:
        return False
    rng = random.Random(_SEED)
    for prime in primes_with(roots_in(system[0]))[:_SLICES]:
        zeros = _zeros(system, dimension, moving, rng, prime, lengths)
        if zeros is not None:
            return not zeros
    return False  # there are zeros, in extensions alone: real ones, for all that is known


def _in_two_variables(system: Sequence[Polynomial], moving: int) -> Iterator[list[Polynomial]]:
    """Three or more conditions of a system on the same two variables: they rarely have a zero, whatever the others."""
    places = [{place for place in variables_in(f) if place < moving} for f in system]
    for pair in {tuple(sorted(places_of_set)) for places_of_set in places if len(places_of_set) == 2}:
        part = [f for f, here in zip(system, places, strict=True) if here <= {*pair}]
        if 2 < len(part) < len(system):
            yield part


def _have_no_common_zero(system: Sequence[Polynomial], moving: int, lengths: Mapping[str, Fraction]) -> bool:
    """Whether conditions on two variables have no common zero at all."""
    return _zeros(system, 2, moving, random.Random(_SEED), PRIMES[0], lengths) is False


def _moving_places(system: Sequence[Polynomial], moving: int) -> list[int]:
    """The joints' variables, which are the first `moving` of them, that some conditions are in."""
    places = sorted(set().union(*map(variables_in, system)))
    return [place for place in places if place < moving]


def nowhere(system: Sequence[Polynomial], moving: int, lengths: Mapping[str, Fraction]) -> bool:
    """Whether four or more conditions on three variables are proven to have no common zero, by resultants modulo P.

    Where they have one so have the resultants of any two of them, and those of these, in one variable alone. Zeros with
    1 + t² = 0 do not count. False, too, where the resultants would be too long.
    """
    places = _moving_places(system, moving)
    if len(places) != 3 or len(system) < 4 or not solvable_in_space(system, moving):
        return False
    prime, module, names = PRIMES[0], flint(), system[0].context().names()
    rng = random.Random(_SEED)
    known = dict(residues_of_roots(roots_in(system[0]), prime) or {})
    for name in names[moving:]:
        known.setdefault(name, residue(lengths[name], prime) if name in lengths else rng.randrange(prime))
    context = module.nmod_mpoly_ctx.get(list("xyz"), prime, module.Ordering.lex)
    forms = []
    for f in system:
        here = modulo_prime(f, prime).subs(known).to_dict().items()
        forms.append(context.from_dict({tuple(int(e[place]) for place in places): int(c) for e, c in here}))
    for first in range(3):
        planes = _all_resultants(forms, first)
        for second in range(3):
            if second != first:
                lines = [f for f in _all_resultants(planes, second) if f != 0]
                circle = 1 + context.gens()[3 - first - second] ** 2
                if lines and _divide_out_shared(_common(lines), circle).is_constant():
                    return True
    return False


def only_curves(system: Sequence[Polynomial], moving: int, lengths: Mapping[str, Fraction]) -> bool:
    """Whether three or four conditions are proven to have no piece of codimension 3, only pieces of codimension 2.

    On slices in every three of the variables the pieces of codimension 2 are curves, the others points. Along a random
    direction no such point lies over the curves' projection c: at its projection c ≠ 0, and the resultants of any two
    conditions vanish, so these without their common factors do. All is done modulo a prime. False, too, where the
    resultants would be too long.
    """
    places = _moving_places(system, moving)
    if len(places) < 3 or not 2 < len(system) < 5:
        return False
    prime = primes_with(roots_in(system[0]))[0]
    rng = random.Random(_SEED)
    values = _values_modulo(system[0], lengths, prime, rng)
    images = [image_modulo(f, residues_of_roots(roots_in(f), prime) or {}, prime) for f in system]
    return all(_only_curves_on(images, chosen, values, rng) for chosen in combinations(places, 3))


def _slice_forms(
    images: Sequence[Polynomial], chosen: Sequence[int], values: Mapping[str, int], rng: random.Random
) -> list[Polynomial]:
    """The conditions on a slice in x, y, z, of which x and y are those of low degrees, turned to a random direction."""
    names = list(map(str, images[0].context().names()))
    prime = int(images[0].context().modulus())
    context = flint().nmod_mpoly_ctx.get(list("xyz"), prime, flint().Ordering.lex)
    others = {name: values[name] for place, name in enumerate(names) if place not in chosen}
    degrees = {place: max(int(f.degrees()[place]) for f in images) for place in chosen}
    ordered = sorted(chosen, key=lambda place: degrees[place])  # short resultants
    x, y, z = context.gens()
    turned = (x, y + rng.randrange(1, prime) * x, z)
    forms = []
    for f in images:
        terms = {}
        for exponents, number in f.subs(others).to_dict().items():
            terms[tuple(int(exponents[place]) for place in ordered)] = int(number)
        forms.append(context.from_dict(terms).compose(*turned, ctx=context))
    return forms


def _values_modulo(
    f: Polynomial, lengths: Mapping[str, Fraction], prime: int, rng: random.Random
) -> dict[str, int]:
    """Each variable of a polynomial modulo a prime: roots and lengths as they are, all others at random."""
    values = dict(residues_of_roots(roots_in(f), prime) or {})
    for name in f.context().names():
        if name in lengths:
            values.setdefault(name, residue(lengths[name], prime))
        values.setdefault(name, rng.randrange(prime))
    return values


def _only_curves_on(
    images: Sequence[Polynomial], chosen: Sequence[int], values: Mapping[str, int], rng: random.Random
) -> bool:
    """`only_curves` on one slice, in three variables; the others have these values."""
    forms = _slice_forms(images, chosen, values, rng)
    pairs_of = list(combinations(forms, 2))
    if any(f == 0 for f in forms) or any(plane_size(f, g, 0) > _SHEARED for f, g in pairs_of):
        return False
    tick(sum(500 + 100 * plane_size(f, g, 0) for f, g in pairs_of))
    planes = [f.resultant(g, "x") for f, g in pairs_of]
    if any(f == 0 for f in planes):
        return False
    curves = _common(planes)
    beside = sorted((_divide_out_shared(f, curves) for f in planes), key=lambda f: int(f.total_degree()))
    if beside[0].is_constant():
        return True
    lines = [f for f in _all_resultants(beside, 1) if f != 0]
    if not lines:
        return False
    z = lines[0].context().gens()[2]
    return bool(_divide_out_shared(_common(lines), 1 + z**2).is_constant())


def _all_resultants(polynomials: Sequence[Polynomial], place: int) -> list[Polynomial]:
    """Those without one of x, y, z, and the resultants in it of the first that has it with each other one."""
    inside = sorted((f for f in polynomials if f.degrees()[place]), key=len)
    for f in inside[1:]:
        tick(200 + 3 * len(inside[0]) * len(f))
    outside = [f for f in polynomials if not f.degrees()[place]]
    return [*outside, *(inside[0].resultant(f, "xyz"[place]) for f in inside[1:])]


def _divide_out_shared(f: Polynomial, g: Polynomial) -> Polynomial:
    """f without all factors that it shares with g."""
    while g != 0 and not f.is_constant():
        shared = f.gcd(g)
        if shared.is_constant():
            break
        f = divmod(f, shared)[0]
    return f


def _zeros(
    system: Sequence[Polynomial],
    dimension: int,
    moving: int,
    rng: random.Random,
    prime: int,
    lengths: Mapping[str, Fraction],
) -> bool | None:
    """Whether there is a common zero modulo a prime on one random slice; None where there may be others."""
    module = flint()
    context = module.nmod_mpoly_ctx.get(["x", "y"], prime, module.Ordering.lex)
    variables = context.gens()[:dimension]
    names = system[0].context().names()
    known = residues_of_roots(roots_in(system[0]), prime) or {}
    forms = []
    for place, name in enumerate(names):
        if name in lengths:
            start = residue(lengths[name], prime)
        else:
            start = rng.randrange(prime)
        form = context.constant(known.get(name, start))
        forms.append(sum((rng.randrange(prime) * v for v in variables), form) if place < moving else form)
    places = sorted(place for place in used_by(system) if place < moving)
    circles = [1 + forms[place] ** 2 for place in places if names[place][0] == "t"]
    sliced = sorted(
        (modulo_prime(f, prime).compose(*forms, ctx=context) for f in system), key=lambda f: int(f.total_degree())
    )
    tick(sum(100 + 8 * len(f) for f in system))
    return (_zero_on_line if dimension == 1 else _zero_in_plane)(sliced, circles, prime)


def _zero_on_line(sliced: Sequence[Polynomial], circles: Sequence[Polynomial], prime: int) -> bool | None:
    common = _common(sliced)
    for circle in circles:
        common = _divide_out_shared(common, circle)
    if common.is_constant():
        return False
    if roots(dense(common, 0), prime):
        return True
    return None


def _zero_in_plane(sliced: Sequence[Polynomial], circles: Sequence[Polynomial], prime: int) -> bool | None:
    sliced = [f for f in sliced if f != 0]  # for special lengths a condition may always hold
    if len(sliced) < 2:
        return True
    first = sliced[0]
    edges = [first.resultant(circle, "y") for circle in circles]
    common = first * 0
    for f in sliced[1:]:
        tick(len(first) * len(f))
        common = common.gcd(first.resultant(f, "y"))
        if common == 0:
            continue
        for edge in edges:
            common = _divide_out_shared(common, edge)
        if common.is_constant():  # the further conditions cannot change that
            return False
    if common == 0:
        return True
    # zeros of all lie over those of `common`: there the conditions are their remainders, of lower degree
    for f, g in combinations([divmod(f, common)[1] for f in sliced[1:]], 2):  # a zero of two need not be one of all
        tick(len(f) * len(g))
        both = f.resultant(g, "y")
        if both != 0:
            common = common.gcd(both)
        if common.is_constant():
            return False
    for at in roots(dense(common, 0), prime):
        there = _common([flint().nmod_poly(dense(f.subs({"x": at}), 1), prime) for f in sliced])
        if there.degree() > 0 and roots([int(value) for value in there.coeffs()], prime):
            return True
    return None


def _common(polynomials: Sequence[Polynomial]) -> Polynomial:
    """Their greatest common divisor."""
    return reduce(lambda f, g: f.gcd(g), polynomials)
