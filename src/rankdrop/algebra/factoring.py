"""Factors of polynomials: irreducible over the rationals, and over the roots that occur."""

from __future__ import annotations

import random
from collections.abc import Sequence
from functools import reduce
from math import prod
from typing import Any

from rankdrop.algebra.gcd import gcd, image_modulo, modulo_prime, quotient
from rankdrop.algebra.halt import Halt, HaltKind, TooLong
from rankdrop.algebra.polynomial import (
    Polynomial,
    coefficients,
    is_number,
    look,
    norm,
    primitive,
    reduced_roots,
    root_relations,
    roots_in,
    variables_in,
    variables_of,
)
from rankdrop.algebra.roots import residues_of_roots
from rankdrop.lists import flat_map

_SMALL = ((1 << 31) - 249, (1 << 31) - 2289)  # modulo which all roots exist; flint factors by no larger ones
_SHIFTS = 8  # each fails for few polynomials only

_SLICED = 10_000  # slices are at random whole numbers below this
_SLICED_FROM = 500  # terms from which slices are taken first where there are no roots


def factor(f: Polynomial) -> list[tuple[Polynomial, int]]:
    """Irreducible factors with their multiplicities; over the roots they are primitive.

    Most long polynomials are irreducible already on slices in two variables, which costs least: flint takes from 0.1 to
    11 s for minors of 3,500 terms that are alike.
    Over the roots a multiplicity is that modulo a prime of 61 bits: the factors are known to divide.
    """
    look()
    if not roots_in(f):
        if len(f) > _SLICED_FROM and _slices_irreducible(f):
            return [(primitive(f), 1)]
        return [(piece, int(power)) for piece, power in f.factor()[1]]
    variables, f = _without_variables(f)
    if is_number(f):
        return variables
    if _slices_irreducible(f):
        return [*variables, (primitive(f), 1)]
    return [*variables, *_factors_over_roots(f)]


def _without_variables(f: Polynomial) -> tuple[list[tuple[Polynomial, int]], Polynomial]:
    """The variables, but for roots, that divide a polynomial, with multiplicities, and the polynomial without them."""
    lowest = [min(powers) for powers in zip(*f.monoms(), strict=True)]
    roots = {place for place, _ in root_relations(f.context())}
    gens = f.context().gens()
    monomials = [(gens[place], int(power)) for place, power in enumerate(lowest) if power and place not in roots]
    if not monomials:
        return [], f
    shared = prod((x**power for x, power in monomials), start=f.context().constant(1))
    return monomials, divmod(f, shared)[0]


def _factors_over_roots(f: Polynomial) -> list[tuple[Polynomial, int]]:
    """`factor` of a polynomial with roots that no variable divides."""
    rational = reduce(lambda a, b: a.gcd(b), _components(f))
    pieces: list[Polynomial] = []
    for piece, _ in rational.factor()[1]:
        pieces += [piece] if 1 in piece.degrees() else _split(piece)
    rest = quotient(f, rational)
    if not is_number(rest):
        pieces += _split(rest)
    distinct = {str(piece): piece for piece in map(primitive, pieces)}.values()
    if len(distinct) == 1:
        piece = next(iter(distinct))
        return [(piece, _degree(f) // _degree(piece))]
    image, prime = modulo_prime(f)
    return [(piece, _multiplicity(image, modulo_prime(piece, prime)[0], prime)) for piece in distinct]


def _multiplicity(f: Polynomial, g: Polynomial, prime: int) -> int:
    """How often an irreducible g divides f, both modulo a prime of 61 bits: counted on a random line along one axis.

    On a line g meets another factor of f where their resultant is zero: for a share of deg f · deg g / prime of all
    lines. Division by g of all variables, which ends with a long remainder, takes minutes where f has 50,000 terms.
    """
    if f == 0:
        raise ArithmeticError("zero has every factor without end; it is to be noticed before factoring")
    degrees = g.degrees()
    place = min((place for place, degree in enumerate(degrees) if degree), key=lambda place: int(degrees[place]))
    rng = random.Random(_SLICED)
    others = [name for at, name in enumerate(variables_of(g.context())) if at != place]
    while True:
        values = {name: rng.randrange(prime) for name in others}
        on_line, divisor = f.subs(values), g.subs(values)
        if divisor.degrees()[place] == degrees[place] and on_line != 0:
            break
    power = 0
    while True:
        on_line, rest = divmod(on_line, divisor)
        if rest != 0:
            return power
        power += 1


def _components(f: Polynomial) -> list[Polynomial]:
    """The rational polynomials that the products of roots are multiplied by."""
    places = [place for place, _ in root_relations(f.context())]
    parts: dict[tuple[int, ...], dict[tuple[int, ...], Any]] = {}
    for e, value in f.terms():
        rest = tuple(0 if place in places else x for place, x in enumerate(e))
        parts.setdefault(tuple(e[place] for place in places), {})[rest] = value
    return [f.context().from_dict(part) for part in parts.values()]


def _split(f: Polynomial) -> list[Polynomial]:
    """The different irreducible factors of a polynomial over the roots."""
    if _stays_irreducible(f):
        return [f]
    content = _content(f)
    if content is not None:
        return flat_map(_split, (content, quotient(f, content)))
    for shift in range(_SHIFTS):
        look()
        turned = _shift_by_roots(f, shift)
        factors = norm(turned)[0].factor()[1]
        parts = [_shift_by_roots(gcd(turned, piece), -shift) for piece, _ in factors]
        if len(factors) > 1:
            return flat_map(_split, (part for part in parts if not is_number(part)))
        if factors[0][1] == 1 and all(turned.degrees()[place] for place, _ in root_relations(f.context())):
            return [f]
        if (root := _squarefree(f)) is not None:
            return _split(root)
    raise TooLong(Halt(HaltKind.NORM))


def _content(f: Polynomial) -> Polynomial | None:
    """A factor without one of the variables of f; None where every factor has them all."""
    roots = {place for place, _ in root_relations(f.context())}
    for place in variables_in(f):
        if place in roots:
            continue
        content = f.context().constant(0)
        for part in coefficients(f, place):
            if part != 0:
                content = gcd(content, part)
            else:
                content = content
            if content != 0 and is_number(content):
                break
        if not is_number(content):
            return content
    return None


def _stays_irreducible(f: Polynomial) -> bool:
    """Whether f is irreducible modulo one of two primes, each with the roots; then it is so over them."""
    for prime in _SMALL:
        image = image_modulo(f, residues_of_roots(roots_in(f), prime) or {}, prime)
        if image.total_degree() == _degree(f) and [power for _, power in image.factor()[1]] == [1]:
            return True
    return False


def _slices_irreducible(f: Polynomial) -> bool:
    """Whether slices of f in two variables x, y prove it irreducible over the roots, for one x and each other y.

    On each slice the other variables stand at whole numbers, and it is taken modulo a prime with the roots. Let its
    degrees in x and y be those of f. If f = g h, one of g and h has no x and no y where the slice is irreducible. It is
    the same one for each y, the one without x: it is a number.

    Returns:
        False where a slice has factors, which need not be those of f, or f has fewer than three variables.
    """
    roots = {place for place, _ in root_relations(f.context())}
    degrees = f.degrees()
    places = [place for place in variables_in(f) if place not in roots]
    if len(places) < 3:
        return False
    x = min(places, key=lambda place: int(degrees[place]))
    rng = random.Random(_SLICED)
    for y in places:
        if y != x and not any(_slice_irreducible(f, x, y, places, prime, rng) for prime in _SMALL):
            return False
    return True


def _slice_irreducible(
    f: Polynomial, x: int, y: int, places: Sequence[int], prime: int, rng: random.Random
) -> bool:
    """Whether f is irreducible modulo a prime, and has its degrees in x and y, on one random slice in x and y."""
    names, degrees = variables_of(f.context()), f.degrees()
    values = {names[place]: rng.randrange(2, _SLICED) for place in places if place not in (x, y)}
    image = image_modulo(f.subs(values), residues_of_roots(roots_in(f), prime) or {}, prime)
    if image == 0 or any(image.degrees()[place] != degrees[place] for place in (x, y)):
        return False
    return [power for _, power in image.factor()[1]] == [1]


def _degree(f: Polynomial) -> int:
    """Total degree of a polynomial, roots not counted."""
    roots = {place for place, _ in root_relations(f.context())}
    return max(sum(int(x) for place, x in enumerate(e) if place not in roots) for e in f.monoms())


def _squarefree(f: Polynomial) -> Polynomial | None:
    """f without repeated factors where it has one; None where it has none in its first variable."""
    name = next(name for name, degree in zip(variables_of(f.context()), f.degrees(), strict=True) if degree)
    common = gcd(f, f.derivative(name))
    if is_number(common):
        return None
    return quotient(f, common)


def _shift_by_roots(f: Polynomial, shift: int) -> Polynomial:
    """f(x + shift · Σ k w_k) for one of its variables: its norm has no square for almost every shift."""
    if shift == 0:
        return f
    gens, relations = f.context().gens(), dict(root_relations(f.context()))
    place = next(k for k, degree in enumerate(f.degrees()) if degree and k not in relations)
    step = sum(((2 * k + 1) * gens[w] for k, w in enumerate(relations)), f.context().constant(0)) * shift
    return reduced_roots(f.compose(*(x + step if k == place else x for k, x in enumerate(gens)), ctx=f.context()))
