"""Systems of conditions taken apart into irreducible sets, and a set cut by one more condition.

A condition A·t_k + B = 0 is solved for t_k and put into the others, which factor again. What the solution leaves out
is looked at apart: A = B = 0, where t_k is free, and t_k = ∞, where θ_k = π.

Where one more condition does not hold on all of a set, an irreducible set loses exactly one dimension, everywhere
(Krull): pieces of another dimension are dropped. Of several sets given by the same two conditions those on which it
holds are first separated from the others (`ZeroSet.parted`), for which the same is true.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, islice
from typing import NamedTuple

from rankdrop.algebra.factoring import factor
from rankdrop.algebra.field import ModularPoint, residue, roots_at, solvable_in_space, value_at
from rankdrop.algebra.gcd import divides, gcd
from rankdrop.algebra.polynomial import COS_SIN, Atom, Polynomial, coefficients, primitive, used_by, variables_in
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
            known=(*piece.known, *(_at_pins(piece, others) if variables_in(parts[1]) else ())),
        )
    ]


def _at_pins(piece: ZeroSet, conditions: list[Polynomial]) -> list[Polynomial]:
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
        return [replace(piece, known=(*piece.known, *_at_pins(piece, [g]))) for piece in pieces]
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


def cut(zero_set: ZeroSet, p: Polynomial, work: Work) -> list[ZeroSet]:
    """The irreducible components of the points of a set at which a trigonometric polynomial vanishes.

    Where two conditions hold on several sets, those on which it vanishes are told from those that it cuts.

    Args:
        zero_set: irreducible, or several of them.
        p: trigonometric polynomial.
        work: deadline; letters divided by are noted there.

    Returns:
        `[one]` where p vanishes on all of it; else components of one dimension less, and of several sets also those
        on which p vanishes, of the same dimension.

    Raises:
        OutOfTime: the deadline has passed.
    """
    ring = zero_set.ring
    p = ring.at(p, zero_set.pins)
    if p == 0:
        return [zero_set]
    factors = ring.factor(p)
    for letters, _ in factors.letters:
        work.assume(letters)
    pieces: list[ZeroSet] = []
    for atom, _ in factors.atoms:
        if zero_set.several:
            inside, outside = zero_set.split_by_zero(zero_where(ring, atom), atom.f)
        else:
            inside, outside = (None, zero_set)
        if inside is not None:
            if atom.is_pin:
                pieces += components_with_pin(zero_set, atom.joint, atom.value, work, zero_set.codimension)
            else:
                pieces += [inside]
        if outside is None:
            return pieces
        if atom.is_pin:
            parts = components_with_pin(outside, atom.joint, atom.value, work)
        else:
            parts = cut_half(outside, atom.f, work)
        if parts and parts[0] is zero_set:
            return [zero_set]
        pieces += parts
    return independent(pieces)


def meet(zero_set: ZeroSet, polynomials: Sequence[Polynomial], work: Work) -> list[ZeroSet]:
    """The components, of one dimension less, of the points of a set at which several trigonometric polynomials vanish.

    Args:
        zero_set: irreducible, or several of them.
        polynomials: none of them vanishes on one of the sets.
        work: deadline; letters divided by are noted there.

    Returns:
        Components of all points that satisfy its conditions, in the closure of the set or not.
    """
    ring = zero_set.ring
    conditions = [ring.form(f) for f in (*zero_set.equations, *zero_set.known)]
    conditions += [ring.to_half(ring.at(p, zero_set.pins)) for p in polynomials]
    pieces = decompose(ring, zero_set.pins, conditions, zero_set.codimension + 1 - len(zero_set.pins), work)
    return [piece for piece in pieces if piece.codimension == zero_set.codimension + 1]


def zero_where(ring: Ring, atom: Atom) -> Polynomial:
    """A trigonometric polynomial that is zero, over the reals and modulo P, where an atom holds and nowhere else."""
    if not atom.is_pin:
        return ring.trig_zero_set(atom.f)
    cosine, sine = COS_SIN[atom.value]
    return ring.one - ring.c[atom.joint] * cosine - ring.s[atom.joint] * sine


def components_with_pin(zero_set: ZeroSet, joint: int, value: str, work: Work, codimension: int = 0) -> list[ZeroSet]:
    """The components of a set on which a joint stands at a simple angle.

    Args:
        zero_set: irreducible, or several of them.
        joint, value: of `atom.SIMPLE`.
        work: deadline.
        codimension: of the components; 0 for one more than that of the set.
    """
    ring = zero_set.ring
    if joint in zero_set.pins:
        if zero_set.pins[joint] == value:
            return [zero_set]
        return []
    if zero_set.stands(joint, value):
        return [zero_set]
    conditions = [ring.form(f).at({joint: value}) for f in (*zero_set.equations, *zero_set.known)]
    codimension = codimension or zero_set.codimension + 1
    most = codimension - len(zero_set.pins) - 1
    pieces = decompose(ring, {**zero_set.pins, joint: value}, conditions, most, work)
    return [piece for piece in pieces if piece.codimension == codimension]


def cut_half(zero_set: ZeroSet, f: Polynomial, work: Work) -> list[ZeroSet]:
    """As `cut`, for a half-angle polynomial that does not contain pinned joints."""
    ring = zero_set.ring
    form = _normal(zero_set, f)
    if form.f == 0 or zero_set.half_vanishes(f):
        return [zero_set]
    pieces: list[ZeroSet] = []
    taken = {solved.place for solved in zero_set.solved}
    for joint, _ in form.at_pi:
        if joint not in zero_set.pins and ring.index[f"t{joint}"] not in taken:
            pieces += components_with_pin(zero_set, joint, "pi", work)
    # where a denominator vanishes, the condition as it was given still binds the solved variable
    if any(solved.place in variables_in(f) and variables_in(solved.denominator) for solved in zero_set.solved):
        given = [f]
    else:
        given = []
    for part in factors(ring, form.f, work):
        cuts = _cut_irreducible(zero_set, part, work)
        if given:
            pieces += [replace(piece, known=(*piece.known, *_at_pins(piece, given))) for piece in cuts]
        else:
            pieces += cuts
    pieces += _edges(zero_set, work)
    pieces = with_points([piece for piece in pieces if piece.codimension == zero_set.codimension + 1], work)
    zero = ring.trig_zero_set(f)
    vanishing = [piece.split_by_zero(zero, f)[0] if piece.several else piece for piece in pieces]
    return independent([piece for piece in vanishing if piece is not None and piece.half_vanishes(f)])


def with_points(pieces: Sequence[ZeroSet], work: Work) -> list[ZeroSet]:
    """The sets that have points modulo a prime. Those that may be real all the same are noted.

    With numbers for lengths √53 may be real without being a number modulo any of the primes that are tried; with
    letters that is a matter of chance.
    """
    for piece in pieces:
        if not piece.samples and not any(without_real_root(f) for f in piece.equations):
            work.without_points[piece.key] = piece
    return [piece for piece in pieces if piece.samples]


def _cut_irreducible(zero_set: ZeroSet, h: Polynomial, work: Work) -> list[ZeroSet]:
    """An irreducible set cut by an irreducible polynomial in variables that are still free on it."""
    ring = zero_set.ring
    atom = ring.atom(h)
    if atom.is_pin:
        return components_with_pin(zero_set, atom.joint, atom.value, work)
    h = atom.f
    if any(divides(h, solved.denominator) for solved in zero_set.solved):
        return []  # the solution does not exist there: see `_edges`
    if not zero_set.rest:
        solved = linear(ring, h)
        if solved is not None:
            factors(ring, solved.denominator, work)  # those in lengths alone are assumed not to vanish
            return [replace(zero_set, solved=(*zero_set.solved, solved), equations=(*zero_set.equations, h))]
        return [replace(zero_set, rest=(h,), equations=(*zero_set.equations, h))]
    if len(zero_set.rest) > 1:
        pieces = _on_top(zero_set, h, work)
        if pieces is not None:
            return pieces
    system = [ring.form(f) for f in (*zero_set.equations, *zero_set.known, h)]
    return decompose(ring, zero_set.pins, system, zero_set.codimension + 1 - len(zero_set.pins), work)


def _on_top(zero_set: ZeroSet, h: Polynomial, work: Work) -> list[ZeroSet] | None:
    """A set held by unsolved conditions cut by a condition on a variable that they are not in; None for another one.

    It is solved for that variable. Where all of its coefficients vanish the variable is free: looked at apart.
    """
    ring = zero_set.ring
    bound = used_by(zero_set.rest)
    unbound = [place for place in variables_in(h) if place < ring.moving and place not in bound]
    if not unbound:
        return None
    place = min(unbound, key=lambda k: int(h.degrees()[k]))
    parts = coefficients(h, place)
    system = [*(ring.form(f) for f in (*zero_set.equations, *zero_set.known)), *ring.form(h).coefficients(place)]
    flat = decompose(ring, zero_set.pins, system, zero_set.codimension + 1 - len(zero_set.pins), work)
    kept = [piece for piece in flat if piece.codimension == zero_set.codimension + 1]
    if len(parts) == 2:
        solved = Solved(place, -parts[0], parts[1])
        factors(ring, solved.denominator, work)  # those in lengths alone are assumed not to vanish
        return [*kept, replace(zero_set, solved=(*zero_set.solved, solved), equations=(*zero_set.equations, h))]
    return [*kept, replace(zero_set, rest=(*zero_set.rest, h), equations=(*zero_set.equations, h))]


def _normal(zero_set: ZeroSet, f: Polynomial) -> Form:
    """f in the free variables of a set, times denominators; the solved variables do not occur, not even at π."""
    form = zero_set.ring.form(f)
    for solved in zero_set.solved:
        if solved.place < zero_set.ring.angles:
            counted = form.degrees
        else:
            counted = form.f.degrees()
        if counted[solved.place]:
            form = substitute_into_form(form, solved)
    return form


def _edges(zero_set: ZeroSet, work: Work) -> list[ZeroSet]:
    """Components of an irreducible set at which one of its solutions has no denominator: there t_k is ∞, or free."""
    kept = zero_set.__dict__.get("edges")
    if kept is not None:
        return list(kept)
    ring, pieces = zero_set.ring, list[ZeroSet]()
    most = zero_set.codimension + 1 - len(zero_set.pins)
    for place, solved in enumerate(zero_set.solved):
        later = replace(zero_set, solved=zero_set.solved[place + 1 :])
        bottom, top = _normal(later, solved.denominator).f, _normal(later, solved.numerator).f
        for part in factors(ring, bottom, work) if bottom != 0 else []:
            work.check()
            if solved.place < ring.angles:
                joint = ring.revolute[solved.place]
                there = [ring.form(f).at({joint: "pi"}) for f in (*zero_set.equations, *zero_set.known, part)]
                pieces += decompose(ring, {**zero_set.pins, joint: "pi"}, there, most - 1, work)
            if top == 0:
                continue
            system = (*zero_set.equations, *zero_set.known, part, solved.numerator, solved.denominator)
            pieces += decompose(ring, zero_set.pins, [ring.form(f) for f in system], most, work)
    edges = [piece for piece in independent(pieces) if piece.codimension == zero_set.codimension + 1]
    zero_set.__dict__["edges"] = edges  # remembered: a set is cut many times
    return edges
