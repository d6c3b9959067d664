"""Systems of conditions taken apart into irreducible sets, and an irreducible set cut by one more condition.

A condition A·t_k + B = 0 is solved for t_k and put into the others, which factor again. What the solution leaves out
is looked at apart: A = B = 0, where t_k is free, and t_k = ∞, where θ_k = π. Cut by a condition that does not hold on
all of it, an irreducible set loses exactly one dimension, everywhere (Krull); pieces of another dimension are dropped.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product

from rankdrop.exact.flint import Polynomial
from rankdrop.exact.ring import Ring, coefficients, primitive, used
from rankdrop.exact.slice import binds_more
from rankdrop.exact.variety import Solved, Variety, independent
from rankdrop.exact.work import Work

_LARGE = 1500  # product of the numbers of terms beyond which a variable is not eliminated: the result would fill pages

Done = frozenset[tuple[str, str, int]]
"""Pairs of conditions, and the place of a variable, that have been combined on the way to a system."""


def cut(one: Variety, p: Polynomial, work: Work) -> list[Variety]:
    """The irreducible components of the points of a set at which a trigonometric polynomial vanishes.

    Args:
        one: irreducible set.
        p: trigonometric polynomial.
        work: deadline; letters divided by are noted there.

    Returns:
        `[one]` where p vanishes on all of it; else components of one dimension less.

    Raises:
        OutOfTime: the deadline has passed.
    """
    ring = one.ring
    p = ring.at(p, one.pins)
    if p == 0:
        return [one]
    found = ring.factor(p)
    for letters, _ in found.letters:
        work.assume(letters)
    pieces: list[Variety] = []
    for atom, _ in found.atoms:
        if atom.pinned:
            pieces += pinned(one, atom.joint, atom.value, work)
        else:
            parts = cut_half(one, atom.f, work)
            if parts and parts[0] is one:
                return [one]
            pieces += parts
    return independent(pieces)


def pinned(one: Variety, joint: int, value: str, work: Work) -> list[Variety]:
    """The components of an irreducible set on which a joint stands at a simple angle."""
    ring = one.ring
    if joint in one.pins:
        return [one] if one.pins[joint] == value else []
    if one.stands(joint, value):
        return [one]
    conditions = [ring.half_at(f, {joint: value}) for f in one.equations]
    most = one.codimension - len(one.pins)
    found = decompose(ring, {**one.pins, joint: value}, conditions, most, work)
    return [piece for piece in found if piece.codimension == one.codimension + 1]


def cut_half(one: Variety, f: Polynomial, work: Work) -> list[Variety]:
    """As `cut`, for a half-angle polynomial that does not contain pinned joints."""
    ring = one.ring
    value, deficient = _normal(one, f)
    if value == 0 or one.half_vanishes(f):
        return [one]
    pieces: list[Variety] = []
    for joint in deficient:
        pieces += pinned(one, joint, "pi", work)
    for atom in _factors(ring, value, work):
        pieces += _with(one, atom, work)
    for edge in _edges(one, work):
        if edge.half_vanishes(f):
            pieces.append(edge)
    wanted = one.codimension + 1
    return independent([piece for piece in pieces if piece.codimension == wanted and piece.half_vanishes(f)])


def _with(one: Variety, h: Polynomial, work: Work) -> list[Variety]:
    """An irreducible set cut by an irreducible polynomial in variables that are still free on it."""
    ring = one.ring
    atom = ring.atom(h)
    if atom.pinned:
        return pinned(one, atom.joint, atom.value, work)
    h = atom.f
    if any(_divides(h, solved.denominator) for solved in one.solved):
        return []  # the solution does not exist there: see `_edges`
    if not one.rest:
        solved = _linear(ring, h)
        if solved is not None:
            return [replace(one, solved=(*one.solved, solved), equations=(*one.equations, h))]
        return [replace(one, rest=(h,), equations=(*one.equations, h))]
    return decompose(ring, one.pins, [*one.equations, h], one.codimension + 1 - len(one.pins), work)


def _normal(one: Variety, f: Polynomial) -> tuple[Polynomial, list[int]]:
    """f in the free variables of a set (times denominators), and the joints at whose π it vanishes there."""
    ring = one.ring
    angles = range(ring.angles)
    degree = list(map(int, f.degrees()))
    for solved in one.solved:
        power = degree[solved.place]
        if power:
            tops, bottoms = solved.numerator.degrees(), solved.denominator.degrees()
            for k in angles:
                degree[k] += power * max(int(tops[k]), int(bottoms[k]))
            degree[solved.place] = 0
            f = substituted(f, solved)
    if f == 0:
        return f, []
    actual = f.degrees()
    joints = [ring.revolute[k] for k in angles if degree[k] > actual[k] and ring.revolute[k] not in one.pins]
    taken = {solved.place for solved in one.solved}
    return f, [j for j in joints if ring.index[f"t{j}"] not in taken]


def _edges(one: Variety, work: Work) -> list[Variety]:
    """Components of an irreducible set at which one of its solutions has no denominator: there t_k is ∞, or free."""
    kept = one.__dict__.get("edges")
    if kept is not None:
        return list(kept)
    ring, found = one.ring, list[Variety]()
    most = one.codimension + 1 - len(one.pins)
    for place, solved in enumerate(one.solved):
        later = replace(one, solved=one.solved[place + 1 :])
        bottom, _ = _normal(later, solved.denominator)
        top, _ = _normal(later, solved.numerator)
        for factor in _factors(ring, bottom, work) if bottom != 0 else []:
            work.check()
            if solved.place < ring.angles:
                joint = ring.revolute[solved.place]
                there = [ring.half_at(f, {joint: "pi"}) for f in one.equations]
                found += decompose(ring, {**one.pins, joint: "pi"}, [*there, factor], most - 1, work)
            if top == 0:
                continue
            system = [*one.equations, factor, solved.numerator, solved.denominator]
            found += decompose(ring, one.pins, system, most, work)
    edges = [piece for piece in independent(found) if piece.codimension == one.codimension + 1]
    one.__dict__["edges"] = edges  # remembered: a set is cut many times
    return edges


def decompose(
    ring: Ring,
    pins: Mapping[int, str],
    conditions: Sequence[Polynomial],
    most: int,
    work: Work,
    done: Done = frozenset(),
) -> list[Variety]:
    """Irreducible sets that together hold every large piece of where all half-angle polynomials vanish.

    Args:
        ring: of the polynomials.
        pins: joints at simple angles; the polynomials do not contain them any more.
        conditions: polynomials.
        most: pieces of a codimension above this, the pins not counted, are not wanted.
        work: deadline; letters divided by are noted there.

    Returns:
        Sets, none inside another one; empty where there is no real solution.

    Raises:
        OutOfTime: the deadline has passed.
    """
    work.check()
    choices = [_factors(ring, f, work) for f in conditions if f != 0]
    if not all(choices):
        return []
    found: list[Variety] = []
    for system in _distinct(choices):
        found += _irreducible(ring, dict(pins), system, most, work, done)
    return independent(found)


def _irreducible(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: Done
) -> list[Variety]:
    """`decompose` for irreducible polynomials, no two of them the same: two of them bind two freedoms."""
    if min(len(system), 2) > most or binds_more(system, most, ring.moving):
        return []
    for f in system:
        atom = ring.atom(f)
        if atom.pinned:
            others = [ring.half_at(g, {atom.joint: atom.value}) for g in system if g != f]
            return decompose(ring, {**pins, atom.joint: atom.value}, others, most - 1, work, done)
    if len(system) <= 1:
        return [_single(ring, pins, system)]
    found = list(_at_infinity(ring, pins, system, most, work, done))
    inside = _eliminated(ring, pins, system, most, work, done)
    return found + (_reduced(ring, pins, system, most, work, done) if inside is None else inside)


def _single(ring: Ring, pins: dict[int, str], system: list[Polynomial]) -> Variety:
    """At most one condition."""
    if not system:
        return Variety(ring, pins)
    solved = _linear(ring, system[0])
    if solved is None:
        return Variety(ring, pins, rest=tuple(system), equations=tuple(system))
    return Variety(ring, pins, solved=(solved,), equations=tuple(system))


def _at_infinity(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: Done
) -> Iterator[Variety]:
    """Components with a further joint at π: there two leading coefficients have a common factor."""
    for k, joint in enumerate(ring.revolute):
        if joint in pins or not any(f.degrees()[k] for f in system):
            continue
        leading = [coefficients(f, k)[-1] for f in system]
        if any(_factors(ring, f.gcd(g), work) for f, g in combinations(leading, 2)):
            yield from decompose(ring, {**pins, joint: "pi"}, leading, most - 1, work, done)


def _eliminated(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: Done
) -> list[Variety] | None:
    """Solve one condition for a variable and go on with the others; None where none is linear in a variable."""
    linear = [(solved, f) for f in system if (solved := _linear(ring, f)) is not None]
    if not linear:
        return None
    solved, f = min(linear, key=lambda pair: (not _unit(ring, pair[0].denominator), len(pair[1])))
    others = [g for g in system if g != f]
    found: list[Variety] = []
    if not _unit(ring, solved.denominator):
        found += decompose(ring, pins, [*others, solved.numerator, solved.denominator], most, work, done)
    values = [substituted(g, solved) for g in others]
    for piece in decompose(ring, pins, values, most - 1, work, done):
        if not piece.half_vanishes(solved.denominator):
            found += _solved_on(piece, f, solved.place)
    return found


def _solved_on(piece: Variety, f: Polynomial, place: int) -> list[Variety]:
    """A set in the other variables, with the one that a condition is linear in added."""
    f = piece.ring.half_at(f, piece.pins)
    parts = coefficients(f, place)
    if len(parts) != 2:
        return []
    return [
        replace(
            piece,
            solved=(Solved(place, -parts[0], parts[1]), *piece.solved),
            equations=(*(primitive(h) for h, _ in f.factor()[1] if place in used(h)), *piece.equations),
        )
    ]


def _reduced(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: Done
) -> list[Variety]:
    """No condition is linear: combine two of them into one that is, or into one with a variable less."""
    known = {str(f) for f in system}
    for f, g, k in _pairs(ring, system):
        work.check()
        one, two = sorted((str(f), str(g)))
        pair = (one, two, k)
        if pair in done or len(f) * len(g) > _LARGE:
            continue
        done |= {pair}
        combined = _combined(f, g, k) if f.degrees()[k] == g.degrees()[k] == 2 else f.resultant(g, ring.names[k])
        if combined == 0:
            continue
        factors = _factors(ring, combined, work)
        if not factors:
            return []
        if any(str(h) in known for h in factors):
            continue
        if len(factors) > 1 or (_linear(ring, factors[0]) is not None):
            found: list[Variety] = []
            for h in factors:
                found += decompose(ring, pins, [*system, h], most, work, done)
            return found
    if len(system) > most:
        work.leave(pins, system)
        return []
    return [Variety(ring, pins, rest=tuple(system), equations=tuple(system))]


def _pairs(ring: Ring, system: list[Polynomial]) -> list[tuple[Polynomial, Polynomial, int]]:
    """Two conditions and a variable that both contain, low degrees first."""
    found = [
        (f, g, k)
        for f, g in combinations(system, 2)
        for k in range(ring.moving)
        if f.degrees()[k] and g.degrees()[k]
    ]
    def cost(one: tuple[Polynomial, Polynomial, int]) -> tuple[int, int, int]:
        f, g, k = one
        return len({*used(f), *used(g)}), f.degrees()[k] * g.degrees()[k], len(f) * len(g)

    return sorted(found, key=cost)


def _combined(f: Polynomial, g: Polynomial, k: int) -> Polynomial:
    """Two conditions of degree 2 in a variable, combined into one of degree 1."""
    return f * coefficients(g, k)[2] - g * coefficients(f, k)[2]


def substituted(f: Polynomial, solved: Solved) -> Polynomial:
    """f(t_k = N / D) · D^degree."""
    parts = coefficients(f, solved.place)
    powers = [f.context().constant(1)]
    for _ in parts[1:]:
        powers.append(powers[-1] * solved.denominator)
    total = f.context().constant(0)
    top = f.context().constant(1)
    for power, part in enumerate(parts):
        if part != 0:
            total += part * top * powers[len(parts) - 1 - power]
        top = top * solved.numerator
    return total


def _linear(ring: Ring, f: Polynomial) -> Solved | None:
    """f solved for the variable in which it is linear with the shortest coefficients; None where there is none."""
    best: tuple[tuple[bool, int], Solved] | None = None
    for place, degree in enumerate(f.degrees()[: ring.moving]):
        if degree == 1:
            bottom, top = coefficients(f, place)
            rank = (not _unit(ring, top), len(top) + len(bottom))
            if best is None or rank < best[0]:
                best = (rank, Solved(place, -bottom, top))
    return None if best is None else best[1]


def _unit(ring: Ring, f: Polynomial) -> bool:
    """Whether f has no configuration in it, or no real zero for a plain reason."""
    return all(place >= ring.moving for place in used(f)) or ring.is_unit(f)


def _factors(ring: Ring, f: Polynomial, work: Work) -> list[Polynomial]:
    """Irreducible factors that have real zeros, as far as that is plain; empty where there is none."""
    _, letters, atoms = ring.split(f)
    for one, _ in letters:
        work.assume(one)
    found = []
    for atom, _ in atoms:
        factor = atom.f
        if factor is None:
            root = {"0": 0, "pi/2": 1, "-pi/2": -1}[atom.value]
            factor = ring.t[atom.joint] - root
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


def _divides(h: Polynomial, f: Polynomial) -> bool:
    return f != 0 and bool(divmod(f, h)[1] == 0)


def _distinct(choices: list[list[Polynomial]]) -> list[list[Polynomial]]:
    """One factor out of each condition, in all ways, doubles left out; a system that contains another one too."""
    systems: dict[frozenset[str], list[Polynomial]] = {}
    for combination in product(*choices):
        by_text = {str(f): f for f in combination}
        systems.setdefault(frozenset(by_text), list(by_text.values()))
    return [
        system for key, system in systems.items() if not any(other < key for other in systems)
    ]
