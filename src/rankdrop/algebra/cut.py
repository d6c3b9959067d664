"""A set cut by one more condition: the components on which that holds.

Where one more condition does not hold on all of a set, an irreducible set loses exactly one dimension, everywhere
(Krull): pieces of another dimension are dropped. Of several sets given by the same two conditions those on which it
holds are first separated from the others (`ZeroSet.split_by_zero`), for which the same is true.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rankdrop.algebra.decompose import at_pins, decompose
from rankdrop.algebra.gcd import divides
from rankdrop.algebra.polynomial import COS_SIN, Atom, Polynomial, coefficients, used_by, variables_in
from rankdrop.algebra.ring import Form, Ring
from rankdrop.algebra.solving import Solved, factors, linear, substitute_into_form, without_real_root
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet, independent


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
            pieces += [replace(piece, known=(*piece.known, *at_pins(piece, given))) for piece in cuts]
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
