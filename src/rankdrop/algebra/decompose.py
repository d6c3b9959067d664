"""Systems of conditions taken apart into irreducible sets.

A condition A·t_k + B = 0 is solved for t_k and put into the others, which factor again. What the solution leaves out
is looked at apart: A = B = 0, where t_k is free, and t_k = ∞, where θ_k = π.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, islice
from typing import NamedTuple

from rankdrop.algebra.factoring import factor
from rankdrop.algebra.field import ModularPoint, residue, roots_at, solvable_in_space, value_at
from rankdrop.algebra.gcd import gcd
from rankdrop.algebra.polynomial import Atom, Polynomial, coefficients, primitive, used_by, variables_in
from rankdrop.algebra.ring import Form, Ring
from rankdrop.algebra.solving import (
    Solved,
    atoms,
    binds_more,
    combine_to_linear,
    divisions,
    eliminable,
    factors,
    linear,
    nowhere,
    only_curves,
    pairs,
    remainder,
    substitute_into_form,
    unit,
    without_real_root,
    without_real_zero,
)
from rankdrop.algebra.work import Work, tick
from rankdrop.algebra.zeroset import ZeroSet, independent
from rankdrop.lists import leave_out

_TRIPLES = 3  # of conditions that are tried


class StepsTaken(NamedTuple):
    """Steps on the way to a system that are not taken again inside it.

    Attributes:
        combined: pairs of conditions, and the place of the variable in which they have been combined.
        lowered: (k, l): a division has lowered a degree in variable k, and may have raised one in variable l.
    """

    combined: frozenset[tuple[str, str, int]] = frozenset()
    lowered: frozenset[tuple[int, int]] = frozenset()

    def raised_by_lowering(self, k: int) -> set[int]:
        """Variables in which degrees may have grown, through all divisions so far, to lower those in variable k."""
        reached: set[int] = set()
        fresh = {k}
        while fresh:
            fresh = {end for begin, end in self.lowered if begin in fresh} - reached
            reached |= fresh
        return reached


NOTHING_DONE = StepsTaken()


def decompose(
    ring: Ring,
    pins: Mapping[int, str],
    conditions: Sequence[Form],
    most: int,
    work: Work,
    done: StepsTaken = NOTHING_DONE,
) -> list[ZeroSet]:
    """Irreducible sets that together hold every large piece of where all half-angle polynomials vanish.

    Args:
        ring: of the polynomials.
        pins: joints at simple angles; the polynomials do not contain them any more.
        conditions: forms.
        most: pieces of a codimension above this, the pins not counted, are not wanted.
        work: deadline; letters divided by are noted there.

    Returns:
        Sets, none inside another one; empty where there is no real solution.

    Raises:
        OutOfTime: the deadline has passed.
    """
    work.check()
    tick(500)
    choices = [atoms(form, work) for form in conditions if form.f != 0]
    if not all(choices):
        return []
    pieces: list[ZeroSet] = []
    for system in _distinct(choices):
        angles = {atom.joint: atom.value for atom in system if atom.is_pin}
        polynomials = [atom.f for atom in system if not atom.is_pin]
        if angles:
            there = [ring.form(f).at(angles) for f in polynomials]
            pieces += decompose(ring, {**pins, **angles}, there, most - len(angles), work, done)
        else:
            pieces += _irreducible(ring, dict(pins), polynomials, most, work, done)
    return independent(pieces)


def _irreducible(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: StepsTaken
) -> list[ZeroSet]:
    """`decompose` for irreducible polynomials, no two of them the same: two of them bind two freedoms."""
    if min(len(system), 2) > most:
        # two conditions without a common factor; for special lengths they may have one
        work.special = work.special or (most > 0 and bool(work.lengths) and not _bound(ring, system, most, work))
        return []
    if _bound(ring, system, most, work):
        return []
    if len(system) <= 1:
        return [_single(ring, pins, system)]
    if any(without_real_root(f) for f in system):
        return []
    for f, g, k in divisions(ring, system):
        if len(variables_in(f)) == 1:  # numbers alone: powers of the variable from its degree on are known
            others = [ring.form(h) for h in system if h is not g]
            return decompose(ring, pins, [*others, remainder(ring, g, f, k, work)], most, work, done)
    work.special = work.special or any(_always(ring, f, work) for f in system)
    pieces = list(_at_infinity(ring, pins, system, most, work, done))
    inside = _eliminate_linear(ring, pins, system, most, work, done)
    return pieces + (_lower_by_pairs(ring, pins, system, most, work, done) if inside is None else inside)


def _bound(ring: Ring, system: list[Polynomial], most: int, work: Work) -> bool:
    """Whether a system binds more than `most` freedoms: see `binds_more`."""
    return binds_more(system, most, ring.moving, work.lengths)


def _single(ring: Ring, pins: dict[int, str], system: list[Polynomial]) -> ZeroSet:
    """At most one condition."""
    if not system:
        return ZeroSet(ring, pins)
    solved = linear(ring, system[0])
    if solved is None:
        return ZeroSet(ring, pins, rest=tuple(system), equations=tuple(system))
    return ZeroSet(ring, pins, solved=(solved,), equations=tuple(system))


def _at_infinity(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: StepsTaken
) -> Iterator[ZeroSet]:
    """Components with a further joint at π: there two leading coefficients vanish together."""
    for k, joint in enumerate(ring.revolute):
        if joint in pins or not any(f.degrees()[k] for f in system):
            continue
        there = [ring.form(f).at({joint: "pi"}) for f in system]
        # more than two conditions may meet there without a common factor, where they may bind more than two freedoms
        if most > 2 < len(system) or any(_share(first, second, work) for first, second in combinations(there, 2)):
            yield from decompose(ring, {**pins, joint: "pi"}, there, most - 1, work, done)


def _share(first: Form, second: Form, work: Work) -> bool:
    """Whether two forms have a common factor, be it at π of a joint."""
    at_pi = dict(first.at_pi).keys() & dict(second.at_pi).keys()
    return bool(at_pi) or bool(factors(first.ring, gcd(first.f, second.f), work))


def _eliminate_linear(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: StepsTaken
) -> list[ZeroSet] | None:
    """Solve one condition for a variable and go on with the others; None where none is linear in a variable."""
    solvable = [(solved, f) for f in system if (solved := linear(ring, f)) is not None]
    if not solvable:
        return None
    solved, f = min(solvable, key=lambda pair: (not unit(ring, pair[0].denominator), len(pair[1])))
    others = [g for g in system if g != f]
    pieces: list[ZeroSet] = []
    factors(ring, solved.denominator, work)  # those in lengths alone are assumed not to vanish
    if not unit(ring, solved.denominator):
        both = (*others, solved.numerator, solved.denominator)
        pieces += decompose(ring, pins, [ring.form(g) for g in both], most, work, done)
    values = [substitute_into_form(ring.form(g), solved) for g in others]
    for piece in decompose(ring, pins, values, most - 1, work, done):
        if not piece.half_vanishes(solved.denominator):
            pieces += _solved_on(piece, f, solved.place, [g for g in others if solved.place in variables_in(g)])
    return pieces


def _solved_on(piece: ZeroSet, f: Polynomial, place: int, others: list[Polynomial]) -> list[ZeroSet]:
    """A set in the other variables, with the one that a condition is linear in added; other conditions on it are kept
    in mind for where it cannot be solved.
    """
    f = piece.ring.form(f).at(piece.pins).f
    parts = coefficients(f, place)
    if len(parts) != 2:
        return []
    return [
        replace(
            piece,
            solved=(Solved(place, -parts[0], parts[1]), *piece.solved),
            equations=(*(primitive(h) for h, _ in factor(f) if place in variables_in(h)), *piece.equations),
            known=(*piece.known, *(at_pins(piece, others) if variables_in(parts[1]) else ())),
        )
    ]


def at_pins(piece: ZeroSet, conditions: list[Polynomial]) -> list[Polynomial]:
    """Conditions with the joints that a set pins at their angles; those that say nothing there are left out."""
    restricted = [piece.ring.form(f).at(piece.pins).f for f in conditions]
    return [f for f in restricted if f != 0]


def _lower_by_pairs(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: StepsTaken
) -> list[ZeroSet]:
    """No condition is linear: combine two of them into one that is, or into one with a variable less."""
    pieces = _divide_conditions(ring, pins, system, most, work, done)
    if pieces is None:
        pieces = _combine_conditions(ring, pins, system, most, work, done)
    if pieces is not None:
        return pieces
    if len(system) <= 2:
        return [ZeroSet(ring, pins, rest=tuple(system), equations=tuple(system))]
    return _several(ring, pins, system, most, work)


def _divide_conditions(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: StepsTaken
) -> list[ZeroSet] | None:
    """The zeros with the remainder of one condition by another in its place; None where no division lowers a degree."""
    for f, g, k in divisions(ring, system):
        work.check()
        raised = {place for place in variables_in(f) if place < ring.moving} - {k}
        if any(k in done.raised_by_lowering(place) for place in raised):
            continue  # divisions that raise one another's degrees would never end
        there = done._replace(lowered=done.lowered | {(k, place) for place in raised})
        others = [ring.form(h) for h in system if h is not g]
        pieces = decompose(ring, pins, [*others, remainder(ring, g, f, k, work)], most, work, there)
        return [replace(piece, known=(*piece.known, *at_pins(piece, [g]))) for piece in pieces]
    return None


def _combine_conditions(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work, done: StepsTaken
) -> list[ZeroSet] | None:
    """The zeros with a combination of two conditions that has factors, or is linear; None where none has or is."""
    known = {str(f) for f in system}
    for f, g, k in pairs(ring, system):
        work.check()
        first, second = sorted((str(f), str(g)))
        pair = (first, second, k)
        if pair in done.combined or not eliminable(f, g, k):
            continue
        done = done._replace(combined=done.combined | {pair})
        both = combine_to_linear(ring, f, g, k)
        if both == 0:
            continue
        parts = factors(ring, both, work)
        if not parts:
            return []
        if any(str(h) in known for h in parts):
            continue
        if len(parts) > 1 or linear(ring, parts[0]) is not None:
            pieces: list[ZeroSet] = []
            for h in parts:
                pieces += decompose(ring, pins, [ring.form(g) for g in (*system, h)], most, work, done)
            return pieces
    return None


def _several(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, work: Work
) -> list[ZeroSet]:
    """Three or more conditions that no step makes simpler: some of them; the others tell their zeros apart.

    Two conditions without a common factor bind two freedoms, and each one after them, in a variable of its own, one
    more, but where all its coefficients vanish. So the wanted zeros of all conditions are sets, or points, of as many
    of them as freedoms are bound at most, or of as many as there are variables. Where these are not met again, the
    system is left over: nothing is dropped without a reason.
    """
    size = min(most, len(_variables(ring, system)))
    if without_real_zero(ring, system):
        return []
    pieces = _from_two(ring, pins, system, most, size, work)
    if pieces is not None:
        return pieces
    if size == 3:
        if nowhere(system, ring.moving, work.lengths):
            return []
        pieces = _from_three(ring, pins, system, work)
        if pieces is not None:
            return pieces
        pieces = _curves_alone(ring, pins, system, work)
        if pieces is not None:
            return pieces
    base, tops = _tower(ring, system)
    if tops and len(base) == 2 and len(system) <= most:
        whole = ZeroSet(ring, pins, rest=(*base, *tops), equations=tuple(system))
        return [*_free_on_top(ring, pins, base, tops, [], most, work), whole]
    work.leave(pins, system)
    return []


def _variables(ring: Ring, conditions: Sequence[Polynomial]) -> set[int]:
    """Places of the variables of joints in some conditions."""
    return {place for place in used_by(conditions) if place < ring.moving}


def _zeros_where(ring: Ring, pins: dict[int, str], system: list[Polynomial], held: list[Polynomial]) -> ZeroSet:
    """The zeros of some of the conditions at which the others vanish as well."""
    others = leave_out(system, held)
    zero = tuple(map(ring.trig_zero_set, others))
    return ZeroSet(ring, pins, rest=tuple(held), zero=zero, equations=tuple(system))


def _from_two(
    ring: Ring, pins: dict[int, str], system: list[Polynomial], most: int, size: int, work: Work
) -> list[ZeroSet] | None:
    """The sets of a system as zeros of two conditions, and of further ones in a variable of their own each.

    Args:
        ring, pins, system, most, work: as for `_several`.
        size: so many conditions hold the sets.

    Returns:
        None where no such conditions have a point in common at which all vanish.
    """
    places = _variables(ring, system)
    for f, g in combinations(sorted(system, key=len), 2):
        tops = _tops(ring, [f, g], system, size - 2)
        held = [f, g, *tops]
        if len(held) != max(size, 2) or not _variables(ring, held) >= places:
            continue
        pieces = _zeros_where(ring, pins, system, held)
        if pieces.samples:
            others = leave_out(system, held)
            return [*_free_on_top(ring, pins, [f, g], tops, others, most, work), pieces]
        if size == 2:
            break  # every zero of all is one of these two: those of another two need not be looked for
    return None


def _from_three(ring: Ring, pins: dict[int, str], system: list[Polynomial], work: Work) -> list[ZeroSet] | None:
    """The sets of a system as zeros of three conditions; None where three of few terms have no such point."""
    places = _variables(ring, system)
    for three in islice(combinations(sorted(system, key=len), 3), _TRIPLES):
        if _variables(ring, three) >= places and solvable_in_space(three, ring.moving):
            work.check()
            pieces = _zeros_where(ring, pins, system, list(three))
            if pieces.samples:
                return [pieces]
    return None


def _curves_alone(ring: Ring, pins: dict[int, str], system: list[Polynomial], work: Work) -> list[ZeroSet] | None:
    """The sets of codimension 2 of a system that has no others of codimension 3; None where that is not proven.

    Minors of a matrix are such a system: three of them may vanish on a set of codimension 2.
    """
    places = _variables(ring, system)
    for f, g in combinations(sorted(system, key=len), 2):
        if _variables(ring, [f, g]) >= places:
            work.check()
            pieces = _zeros_where(ring, pins, system, [f, g])
            if pieces.samples and only_curves(system, ring.moving, work.lengths):
                return [pieces]
            break
    return None


def _tops(ring: Ring, base: list[Polynomial], system: list[Polynomial], count: int) -> list[Polynomial]:
    """Up to so many conditions, short ones first, each in one variable that the ones before it are not in."""
    held, tops = used_by(base), list[Polynomial]()
    waiting = leave_out(sorted(system, key=len), base)
    while len(tops) < count:
        new_places = [(h, {p for p in variables_in(h) if p < ring.moving} - held) for h in waiting]
        top = next(((h, new) for h, new in new_places if len(new) == 1), None)
        if top is None:
            break
        tops.append(top[0])
        held |= top[1]
        waiting = [h for h in waiting if h is not top[0]]
    return tops


def _tower(ring: Ring, system: list[Polynomial]) -> tuple[list[Polynomial], list[Polynomial]]:
    """Conditions, and those that are each in a variable which the ones before them are not in."""
    base, tops = list(system), list[Polynomial]()
    while len(base) > 2:
        free = [
            f for f in base
            if any(
                place < ring.moving and not any(g is not f and place in variables_in(g) for g in base)
                for place in variables_in(f)
            )
        ]  # fmt: skip
        if not free:
            break
        top = max(free, key=len)
        base = [f for f in base if f is not top]
        tops.insert(0, top)
    return base, tops


def _free_on_top(
    ring: Ring,
    pins: dict[int, str],
    base: list[Polynomial],
    tops: list[Polynomial],
    besides: list[Polynomial],
    most: int,
    work: Work,
) -> list[ZeroSet]:
    """Sets on which a condition holds whatever its own variable is: all its coefficients vanish, and so do others."""
    pieces: list[ZeroSet] = []
    for number, top in enumerate(tops):
        before = [*base, *tops[:number]]
        known = used_by(before)
        variable = next(place for place in variables_in(top) if place < ring.moving and place not in known)
        others = [ring.form(f) for f in (*before, *tops[number + 1 :], *besides)]
        pieces += decompose(ring, pins, [*others, *ring.form(top).coefficients(variable)], most, work)
    return pieces


def _always(ring: Ring, f: Polynomial, work: Work) -> bool:
    """Whether a condition always holds for the arm's own lengths."""
    if not work.lengths or not any(place >= ring.moving for place in variables_in(f)):
        return False
    values = ModularPoint({name: 7 + 11 * place**3 for place, name in enumerate(ring.names)})
    values.update((name, residue(value)) for name, value in work.lengths.items())
    values.update(roots_at(ring, values.prime))
    return value_at(ring, f, values) == 0


def _distinct(choices: list[list[Atom]]) -> list[dict[Atom, None]]:
    """Systems that hold an atom of each condition, none of which contains another one or pins a joint at two angles."""
    systems: list[dict[Atom, None]] = [{}]
    for choice in choices:
        longer: list[dict[Atom, None]] = []
        for system in systems:
            if any(atom in system for atom in choice):
                longer.append(system)
                continue
            pins = {atom.joint for atom in system if atom.is_pin}
            longer += [{**system, atom: None} for atom in choice if not (atom.is_pin and atom.joint in pins)]
        systems = []
        for system in sorted(longer, key=len):
            if not any(other.keys() <= system.keys() for other in systems):
                systems.append(system)
    return systems
