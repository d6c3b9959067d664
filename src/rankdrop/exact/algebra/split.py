"""A set cut by one more condition.

Where the condition does not hold on all of it, an irreducible set loses exactly one dimension, everywhere (Krull):
pieces of another dimension are dropped. Of several sets given by the same two conditions those on which it holds are
first told from the others (`ZeroSet.parted`), for which the same is true.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rankdrop.exact.algebra.decompose import decompose
from rankdrop.exact.algebra.polynomial import COS_SIN, Atom, Polynomial, coefficients, flint, used
from rankdrop.exact.algebra.ring import Form, Ring
from rankdrop.exact.algebra.roots import norm, primitive
from rankdrop.exact.algebra.solving import Solved, divides, factors, linear, put
from rankdrop.exact.algebra.work import Work
from rankdrop.exact.algebra.zeroset import ZeroSet, independent


def cut(one: ZeroSet, p: Polynomial, work: Work) -> list[ZeroSet]:
    """The irreducible components of the points of a set at which a trigonometric polynomial vanishes.

    Where two conditions hold on several sets, those on which it vanishes are told from those that it cuts.

    Args:
        one: irreducible set, or several.
        p: trigonometric polynomial.
        work: deadline; letters divided by are noted there.

    Returns:
        `[one]` where p vanishes on all of it; else components of one dimension less, and of several sets also those
        on which p vanishes, of the same dimension.

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
    pieces: list[ZeroSet] = []
    for atom, _ in found.atoms:
        inside, outside = one.parted(zero_where(ring, atom), atom.f) if one.several else (None, one)
        if inside is not None:
            pieces += pinned(one, atom.joint, atom.value, work, one.codimension) if atom.pinned else [inside]
        if outside is None:
            return pieces
        parts = pinned(outside, atom.joint, atom.value, work) if atom.pinned else cut_half(outside, atom.f, work)
        if parts and parts[0] is one:
            return [one]
        pieces += parts
    return independent(pieces)


def meet(one: ZeroSet, polynomials: Sequence[Polynomial], work: Work) -> list[ZeroSet]:
    """The components, of one dimension less, of the points of a set at which several trigonometric polynomials vanish.

    Args:
        one: irreducible set, or several.
        polynomials: none of them vanishes on one of the sets.
        work: deadline; letters divided by are noted there.

    Returns:
        Components of all points that satisfy its conditions, in the closure of the set or not.
    """
    ring = one.ring
    conditions = [ring.form(f) for f in (*one.equations, *one.known)]
    conditions += [ring.to_half(ring.at(p, one.pins)) for p in polynomials]
    found = decompose(ring, one.pins, conditions, one.codimension + 1 - len(one.pins), work)
    return [piece for piece in found if piece.codimension == one.codimension + 1]


def zero_where(ring: Ring, atom: Atom) -> Polynomial:
    """A trigonometric polynomial that is zero, over the reals and modulo P, where an atom holds and nowhere else."""
    if not atom.pinned:
        return ring.trig_zero_set(atom.f)
    cosine, sine = COS_SIN[atom.value]
    return ring.one - ring.c[atom.joint] * cosine - ring.s[atom.joint] * sine


def pinned(one: ZeroSet, joint: int, value: str, work: Work, codimension: int = 0) -> list[ZeroSet]:
    """The components of a set on which a joint stands at a simple angle.

    Args:
        one: irreducible set, or several.
        joint, value: of `atom.SIMPLE`.
        work: deadline.
        codimension: of the components; 0 for one more than that of the set.
    """
    ring = one.ring
    if joint in one.pins:
        return [one] if one.pins[joint] == value else []
    if one.stands(joint, value):
        return [one]
    conditions = [ring.form(f).at({joint: value}) for f in (*one.equations, *one.known)]
    codimension = codimension or one.codimension + 1
    most = codimension - len(one.pins) - 1
    found = decompose(ring, {**one.pins, joint: value}, conditions, most, work)
    return [piece for piece in found if piece.codimension == codimension]


def cut_half(one: ZeroSet, f: Polynomial, work: Work) -> list[ZeroSet]:
    """As `cut`, for a half-angle polynomial that does not contain pinned joints."""
    ring = one.ring
    form = _normal(one, f)
    if form.f == 0 or one.half_vanishes(f):
        return [one]
    pieces: list[ZeroSet] = []
    taken = {solved.place for solved in one.solved}
    for joint, _ in form.at_pi:
        if joint not in one.pins and ring.index[f"t{joint}"] not in taken:
            pieces += pinned(one, joint, "pi", work)
    for factor in factors(ring, form.f, work):
        pieces += _with(one, factor, work)
    for edge in with_points(_edges(one, work), work):
        inside, _ = edge.parted(ring.trig_zero_set(f), f) if edge.several else (edge, None)
        if inside is not None and inside.half_vanishes(f):
            pieces.append(inside)
    pieces = with_points([piece for piece in pieces if piece.codimension == one.codimension + 1], work)
    return independent([piece for piece in pieces if piece.half_vanishes(f)])


def with_points(pieces: Sequence[ZeroSet], work: Work) -> list[ZeroSet]:
    """The sets that have points modulo a prime. Those that may be real all the same are noted.

    With numbers for lengths √53 may be real without being a number modulo any of the primes that are tried; with
    letters that is a matter of chance.
    """
    for piece in pieces:
        if not piece.samples and not any(_without_real_root(f) for f in piece.equations):
            work.without_points[piece.key] = piece
    return [piece for piece in pieces if piece.samples]


def _without_real_root(f: Polynomial) -> bool:
    """Whether a polynomial in one variable has no real zero; False for others."""
    f = norm(f)[0]
    places = used(f)
    if len(places) != 1:
        return False
    whole = [0] * (int(f.degrees()[places[0]]) + 1)
    for powers, value in primitive(f).terms():
        whole[int(powers[places[0]])] = int(value.p)
    # enclosures: one that holds no real number is a proof
    return not any(root.imag.contains(0) for root, _ in flint().fmpz_poly(whole).complex_roots())


def _with(one: ZeroSet, h: Polynomial, work: Work) -> list[ZeroSet]:
    """An irreducible set cut by an irreducible polynomial in variables that are still free on it."""
    ring = one.ring
    atom = ring.atom(h)
    if atom.pinned:
        return pinned(one, atom.joint, atom.value, work)
    h = atom.f
    if any(divides(h, solved.denominator) for solved in one.solved):
        return []  # the solution does not exist there: see `_edges`
    if not one.rest:
        solved = linear(ring, h)
        if solved is not None:
            factors(ring, solved.denominator, work)  # those in lengths alone are assumed not to vanish
            return [replace(one, solved=(*one.solved, solved), equations=(*one.equations, h))]
        return [replace(one, rest=(h,), equations=(*one.equations, h))]
    if len(one.rest) > 1:
        found = _on_top(one, h, work)
        if found is not None:
            return found
    system = [ring.form(f) for f in (*one.equations, *one.known, h)]
    return decompose(ring, one.pins, system, one.codimension + 1 - len(one.pins), work)


def _on_top(one: ZeroSet, h: Polynomial, work: Work) -> list[ZeroSet] | None:
    """A set held by unsolved conditions cut by a condition on a variable that they are not in; None for another one.

    It is solved for that variable. Where all of its coefficients vanish the variable is free: looked at apart.
    """
    ring = one.ring
    bound = {place for f in one.rest for place in used(f)}
    own = [place for place in used(h) if place < ring.moving and place not in bound]
    if not own:
        return None
    place = min(own, key=lambda k: int(h.degrees()[k]))
    parts = coefficients(h, place)
    system = [*(ring.form(f) for f in (*one.equations, *one.known)), *ring.form(h).coefficients(place)]
    flat = decompose(ring, one.pins, system, one.codimension + 1 - len(one.pins), work)
    kept = [piece for piece in flat if piece.codimension == one.codimension + 1]
    if len(parts) == 2:
        solved = Solved(place, -parts[0], parts[1])
        factors(ring, solved.denominator, work)  # those in lengths alone are assumed not to vanish
        return [*kept, replace(one, solved=(*one.solved, solved), equations=(*one.equations, h))]
    return [*kept, replace(one, rest=(*one.rest, h), equations=(*one.equations, h))]


def _normal(one: ZeroSet, f: Polynomial) -> Form:
    """f in the free variables of a set, times denominators; the solved variables do not occur, not even at π."""
    form = one.ring.form(f)
    for solved in one.solved:
        counted = form.degrees if solved.place < one.ring.angles else form.f.degrees()
        if counted[solved.place]:
            form = put(form, solved)
    return form


def _edges(one: ZeroSet, work: Work) -> list[ZeroSet]:
    """Components of an irreducible set at which one of its solutions has no denominator: there t_k is ∞, or free."""
    kept = one.__dict__.get("edges")
    if kept is not None:
        return list(kept)
    ring, found = one.ring, list[ZeroSet]()
    most = one.codimension + 1 - len(one.pins)
    for place, solved in enumerate(one.solved):
        later = replace(one, solved=one.solved[place + 1 :])
        bottom, top = _normal(later, solved.denominator).f, _normal(later, solved.numerator).f
        for factor in factors(ring, bottom, work) if bottom != 0 else []:
            work.check()
            if solved.place < ring.angles:
                joint = ring.revolute[solved.place]
                there = [ring.form(f).at({joint: "pi"}) for f in (*one.equations, *one.known, factor)]
                found += decompose(ring, {**one.pins, joint: "pi"}, there, most - 1, work)
            if top == 0:
                continue
            system = (*one.equations, *one.known, factor, solved.numerator, solved.denominator)
            found += decompose(ring, one.pins, [ring.form(f) for f in system], most, work)
    edges = [piece for piece in independent(found) if piece.codimension == one.codimension + 1]
    one.__dict__["edges"] = edges  # remembered: a set is cut many times
    return edges
