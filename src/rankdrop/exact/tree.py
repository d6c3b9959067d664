"""Every set of configurations on which the rank drops, of every rank, by branching on minors.

First the freedoms that are never lost: rows and columns are cleared by entries that are numbers. Where an entry of a
matrix is a number c ≠ 0, steps of elimination with it need no division by a polynomial:

    rank [[c, r], [k, B]] = 1 + rank(B − k r / c)        (Schur's complement)

everywhere, so that all drops of rank are those of a smaller matrix. In its own link's frame an axis is such a column. A
slide of a base or a gantry moves the whole arm along a line that does not turn with the joints before it: what the
other joints do along that line does not matter, and the joints of a mobile base that only drive it along and about
fixed lines leave the problem with their rows.

Then the tree. Where the rank is lower than r, every minor of order r vanishes. One that is not zero on a set is
factored, the set is cut by each factor, and every irreducible piece is looked at in the same way. A piece whose rank,
at random points modulo a prime, is lower than r is a find; from the others the search goes on. It starts from the whole
space anew for every r: small minors have short factors, sets of lower rank inside one of higher rank may be long to
derive.

`barren` proves that a set holds no configuration of lower rank. Where the rank is lower than r every minor of order r
vanishes, so every resultant of two of them does, and every resultant of these, down to polynomials in one variable. If
these have no common zero but t = ±i, where no configuration is, there is none. All is done modulo P with every angle
turned by a random one, so that no solution stands at θ = π, where half-angle tangents are infinite, and with the arm's
own lengths for letters. What is not there for one choice of lengths is not there for almost all: the configurations are
compact, and where there is one is closed.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache
from itertools import combinations, islice
from math import prod

from rankdrop.algebra.cut import components_with_pin, cut, meet, with_points, zero_where
from rankdrop.algebra.field import P, rank, residues, roots_at, value_at
from rankdrop.algebra.gcd import image_modulo
from rankdrop.algebra.matrix import each_entry, entries, submatrix
from rankdrop.algebra.polynomial import Atom, Polynomial, flint, primitive
from rankdrop.algebra.ring import Form, Ring, Terms, replace_angles
from rankdrop.algebra.roots import ROOTS
from rankdrop.algebra.work import OutOfTime, TooLong, Work, calling_in_loops, halt_of, tick, work_spent
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import Chain
from rankdrop.families.unfinished import Unfinished, UnfinishedKind
from rankdrop.lists import flat_map
from rankdrop.local.block import generic_rank

_EACH, _PAIR = 6, 4  # polynomials kept of those in the same variables, and in the same two
_LENGTH = 1_000_000  # letters without a value stand at random whole numbers up to this
_MINORS = 400  # of all choices of rows and columns
_TERMS = 6_000  # that a resultant may have
_COST = {1: 10**6, 2: 60_000, 3: 4_000}  # product of the numbers of terms of two polynomials, by their variables
_ROUNDS = 5  # eliminations behind one another: one for each joint but one
_SINGLE = 40  # degree of a polynomial in one variable that is put into others
_LIMIT = 3.0  # work after which there is no proof [s]
_SEED = 61

_EASY = 0.2  # work on one set before a proof is tried that it holds nothing of a lower rank [s]
_STAGE = 0.8  # share of the work left that one rank may take
_TRIED = 6  # minors factored before one is chosen: more cost more than the better choice saves
_TOGETHER = 4  # minors that vanish together on a last set: more conditions show sooner that there is none
_FACTORED = 150  # terms of a trigonometric minor that is factored to tell sets apart: longer ones take seconds
_SHORT = 4  # a minor with so short factors is taken at once


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
    turned = _random_turn(ring, rng)
    known = _Known(ring)
    values = {name: work.lengths.get(name, Fraction(rng.randrange(1, _LENGTH)))
           for name in ring.letters if name not in ROOTS}  # fmt: skip
    lengths = {name: flint().fmpq(x.numerator, x.denominator) for name, x in values.items()}
    for f in conditions:
        known.add(turned(Form(ring, f.subs(lengths), ring.form(f).degrees)))
    at_pins = each_entry(lambda x: ring.at(x.subs(lengths) if x != 0 else x, pins), columns)
    until = work_spent() + _LIMIT
    for minor in islice(_nearby_minors(ring, at_pins, order), _MINORS):
        work.check()
        known.add(turned(ring.to_half(minor)))
        if known.barren:
            return True
    for _ in range(_ROUNDS):
        fresh = list(known.eliminate_pairs(work, until))
        if known.barren:
            return True
        if not fresh or work_spent() > until:
            break
    return False


def _nearby_minors(ring: Ring, columns: Sequence[Sequence[Polynomial]], order: int) -> Iterator[Polynomial]:
    """Minors that are not zero for a plain reason, neighbouring columns first: these depend on fewest joints."""
    n, m = len(columns), len(columns[0])
    for chosen in sorted(combinations(range(n), order), key=lambda c: c[-1] - c[0]):
        for rows in combinations(range(m), order):
            minor = ring.determinant(submatrix(columns, chosen, rows))
            if minor != 0:
                yield minor


def _random_turn(ring: Ring, rng: random.Random) -> Callable[[Form], Polynomial]:
    """f ↦ f · Π (1 − u_j t_j)^D_j modulo P with each angle turned at random: tan((θ + φ) / 2) = (t + u) / (1 − u t)."""
    module = flint()
    context = module.nmod_mpoly_ctx.get(list(ring.names[: ring.moving]), P, module.Ordering.lex)
    turns = [(t + u, 1 - t * u) for t in context.gens()[: ring.angles] for u in [rng.randrange(2, P)]]

    def turn_angles(form: Form) -> Polynomial:
        image, degrees = image_modulo(form.f, roots_at(ring, P), P), form.degrees
        tick(20 + 12 * len(form.f) + 2 * prod(1 + degree for degree in degrees))

        @cache
        def value(k: int, power: int) -> Polynomial:
            return turns[k][0] ** power * turns[k][1] ** (degrees[k] - power)

        def rest(items: Terms) -> Polynomial:
            return context.from_dict({(0,) * ring.angles + e[ring.angles : ring.moving]: number for e, number in items})

        terms = [(tuple(map(int, e)), int(number)) for e, number in image.to_dict().items()]
        return replace_angles(terms, ring.angles, lambda e, k: e[k], value, rest)

    return turn_angles


class _Known:
    def __init__(self, ring: Ring) -> None:
        self._angles, self._moving = ring.angles, ring.moving
        self._by_variables: dict[tuple[int, ...], list[Polynomial]] = {}
        self._single: dict[int, Polynomial] = {}  # gcd of those in one variable
        self._tried: dict[tuple[int, int, int], tuple[Polynomial, Polynomial]] = {}  # with both: ids are of what lives
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
            if before is None:
                common = self._real(f, place)
            else:
                common = before.gcd(f)
            self._single[place] = common
            self.barren = self.barren or common.total_degree() == 0
            return before is None or common.total_degree() < before.total_degree()
        same = self._by_variables.setdefault(places, [])
        if self._full(places):
            return False
        if len(places) == 2 and sum(f.gcd(other).total_degree() > 0 for other in same) > 1:
            return False  # of those with a common factor two are enough
        same.append(f)
        self._kept.append(f)
        return True

    def _full(self, places: tuple[int, ...]) -> bool:
        """Whether there are enough polynomials in these variables."""
        return len(self._by_variables.get(places, ())) >= (_PAIR if len(places) == 2 else _EACH)

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

    def _resultant_vanishes(self, f: Polynomial, g: Polynomial, place: int) -> bool:
        """Whether the resultant of two polynomials in a variable is zero: it is, but for chance, where it is zero with
        the other variables at a random point. Where it is not zero there it is not zero.
        """
        prime, names = int(f.context().modulus()), list(map(str, f.context().names()))
        rng = random.Random(_SEED)
        values = {name: rng.randrange(1, prime) for k, name in enumerate(names) if k != place}
        tick(20 + 0.2 * (len(f) + len(g)))
        f_there, g_there = f.subs(values), g.subs(values)
        return bool(f_there.gcd(g_there).total_degree() > 0)

    def eliminate_pairs(self, work: Work, until: float) -> Iterator[Polynomial]:
        """Resultants of pairs in few variables together, which are kept as well; none begun after so much work."""
        names = [str(g) for g in (self._kept[0].context().gens() if self._kept else ())]
        singles = [f for f in self._single.values() if f.total_degree() <= _SINGLE]
        pool = sorted([*singles, *self._kept], key=len)
        pairs = []
        for f, g in combinations(pool, 2):
            variables_f, variables_g = ({k for k in range(self._moving) if h.degrees()[k]} for h in (f, g))
            if variables_f & variables_g and len(f) * len(g) <= _COST.get(len(variables_f | variables_g), 0):
                cheap = (k for k in variables_f & variables_g if _size(f, g, k) <= _TERMS)
                pairs += [(variables_f | variables_g, len(f) * len(g), f, g, k) for k in cheap]
        for together, cost, f, g, k in sorted(pairs, key=lambda pair: (len(pair[0]), pair[1])):
            key = (id(f), id(g), k)
            if key in self._tried:
                continue
            self._tried[key] = f, g
            if self._full(tuple(sorted(together - {k}))):
                continue
            work.check()
            if self._resultant_vanishes(f, g, k):
                continue
            both = f.resultant(g, names[k])
            tick(50 + 1.5 * cost + 2 * _size(f, g, k))
            if self.add(both):
                yield both
            if self.barren or work_spent() > until:
                return


def _size(f: Polynomial, g: Polynomial, place: int) -> int:
    """Number of terms that the resultant of two polynomials may have."""
    degrees_f, degrees_g = (list(map(int, h.degrees())) for h in (f, g))
    a, b = degrees_f[place], degrees_g[place]
    return prod(1 + b * x + a * y for k, (x, y) in enumerate(zip(degrees_f, degrees_g, strict=True)) if k != place)


@dataclass(frozen=True)
class Drop:
    """An irreducible closed set on which the rank is `rank` almost everywhere, and lower than around it."""

    piece: ZeroSet
    rank: int


@dataclass(frozen=True)
class OpenCase:
    """Conditions that were not taken apart further: where they hold, the rank may be lower than `order`.

    All configurations of a rank lower than `order` lie on drops of the tree, or on its open cases of that order.
    """

    piece: ZeroSet
    order: int


@dataclass
class RankTree:
    """All drops of rank.

    Attributes:
        generic_rank: almost everywhere.
        cleared: by how much the rank of the matrix in use is lower, see `Chain.cleared`.
        drops: the largest sets for each rank, ranks descending: none lies inside another one of the same or lower rank.
        complete: False when time ran out or the user interrupted it.
        left: what was not finished.
        visited: sets looked at.
        unresolved: systems of conditions that could not be taken apart; what they hold is missing.
        without_points: sets without a point modulo any of the primes that may be real, the order of the minors that
            were zero on them, and whether nothing was looked for inside them; their rank is not known, nor what is in
            them.
        cases: what was not taken apart, be it for want of work or because no step makes it simpler.
        unstated: what of `left` the cases do not say: corank 1 was not divided, or an error ended the search.
        lowest: the lowest rank down to which `drops` and `cases` together hold all configurations.
    """

    generic_rank: int
    cleared: int = 0
    drops: list[Drop] = field(default_factory=list)
    complete: bool = True
    left: list[Unfinished] = field(default_factory=list)
    visited: int = 0
    unresolved: list[str] = field(default_factory=list)
    without_points: list[tuple[ZeroSet, int, bool]] = field(default_factory=list)
    cases: list[OpenCase] = field(default_factory=list)
    unstated: list[Unfinished] = field(default_factory=list)
    lowest: int = 0

    @property
    def is_divided(self) -> bool:
        """Whether every case was taken apart: drops alone hold all configurations of lower rank."""
        return self.complete and not self.cases

    @property
    def is_stated(self) -> bool:
        """Whether drops and open cases together hold every configuration of a rank down to `lowest`."""
        return self.complete or (bool(self.left) and not self.unstated)

    @property
    def is_finished(self) -> bool:
        """Whether nothing is left open: then what it has not is not there."""
        return self.complete and not self.unresolved and not self.without_points


class Unwanted(Exception):
    """The derived conditions would not be used."""


def _never() -> bool:
    return False


def rank_tree(chain: Chain, work: Work, *, lowest: int = 0, unwanted: Callable[[], bool] = _never) -> RankTree:
    """Find all sets on which rank J ≤ r, for every r from the generic rank − 1 down to `lowest`.

    Args:
        chain: the arm.
        work: deadline and random points; assumptions on lengths are noted there.
        lowest: drops to this rank are the last ones looked for.
        unwanted: asked after each set; where it says so the tree ends there, incomplete.

    Returns:
        Tree; incomplete, with what is left, where time ran out or the user interrupted it.
    """
    work.lengths = chain.letters
    whole = ZeroSet.whole(chain.ring)
    try:
        columns, never = chain.cleared_columns
    except Exception as stop:
        rank = generic_rank(chain.own, chain.own_task)
        left = [Unfinished(UnfinishedKind.SCREWS, halt=halt_of(stop))]
        return RankTree(rank, complete=False, left=left, unstated=left)
    generic = rank_on(columns, whole)
    drops: list[Drop] = []
    tree = RankTree(generic + never, never, lowest=lowest)  # the rank is `never` or more at every configuration
    lowest = max(lowest - never, 0)
    for order in range(generic, lowest, -1):
        waiting = [whole]
        systems = len(work.unresolved)
        try:
            with work.share(1.0 if order == lowest + 1 else _STAGE), calling_in_loops(work.check):
                _explore(columns, order, waiting, drops, tree, work, unwanted)
        except (Exception, KeyboardInterrupt) as stop:  # whatever fails leaves this open: the search does not need it
            tree.complete = False
            tree.left.append(
                Unfinished(UnfinishedKind.RANK, halt=halt_of(stop), rank=order + never, number=len(waiting))
            )
            _keep_cases(tree, waiting, order, stop, divided=order < generic)
            if isinstance(stop, KeyboardInterrupt):
                work.interrupt()
                break
            if isinstance(stop, Unwanted):
                break
        unresolved = dict.fromkeys(work.unresolved[systems:])
        tree.cases += [OpenCase(_system(chain.ring, *work.systems[system]), order + never) for system in unresolved]
        if not any(drop.rank < order for drop in drops):
            if any(case.order == order + never for case in tree.cases):
                tree.lowest = max(tree.lowest, order - 1 + never)
            break
    tree.drops = largest([Drop(drop.piece, drop.rank + never) for drop in drops])
    tree.without_points = [(piece, order + never, last) for piece, order, last in tree.without_points]
    tree.unresolved = list(dict.fromkeys(work.unresolved))
    return tree


def _keep_cases(tree: RankTree, waiting: Sequence[ZeroSet], order: int, stop: BaseException, *, divided: bool) -> None:
    """Note the sets that wait when a limit ends the search for a rank lower than `order`.

    Where nothing was cut yet the only set that waits is the whole space, which says nothing. Then ranks lower than
    `order` are not derived; where there are cases of a higher rank (`divided`) these and its drops hold them too.
    """
    limited = isinstance(stop, OutOfTime | TooLong)
    if limited and all(piece.codimension for piece in waiting):
        tree.cases += [OpenCase(piece, order + tree.cleared) for piece in waiting]
    elif limited and divided and tree.cases:
        tree.lowest = max(tree.lowest, order + tree.cleared)
    else:
        tree.unstated.append(tree.left[-1])


def _system(ring: Ring, pins: Mapping[int, str], system: Sequence[Polynomial]) -> ZeroSet:
    """The common zeros of some polynomials, not divided: only its conditions may be used."""
    return ZeroSet(ring, pins, rest=tuple(system), equations=tuple(system))


def largest(drops: Sequence[Drop]) -> list[Drop]:
    """The drops whose configurations do not satisfy the conditions of another one of the same rank.

    A set of higher rank lies in none of lower rank, even where it satisfies all conditions of one.
    """
    kept: list[Drop] = []
    for drop in sorted(drops, key=lambda drop: (drop.rank, drop.piece.codimension)):
        if not any(drop.piece.satisfies(other.piece) for other in kept if other.rank == drop.rank):
            kept.append(drop)
    return sorted(kept, key=lambda drop: (-drop.rank, drop.piece.codimension, drop.piece.key))


def _explore(
    columns: list[list[Polynomial]],
    order: int,
    waiting: list[ZeroSet],
    drops: list[Drop],
    tree: RankTree,
    work: Work,
    unwanted: Callable[[], bool],
) -> None:
    """Find the sets on which the rank is lower than `order`, and append them to `found`.

    A piece of the space where an m × n matrix has rank < r binds at most (m − r + 1)(n − r + 1) freedoms, so pieces
    that bind more lie inside others. Where all joints are bound that the matrix depends on its rank is one and the same
    on a whole piece, so that no part of it has a lower one. The shortest set that waits comes first: where time runs
    out, long ones are left.
    """
    n, m = len(columns), len(columns[0])
    bending = _bending(columns, waiting[0].ring)
    bound = min((m - order + 1) * (n - order + 1), bending)
    seen: list[ZeroSet] = []
    ended: list[ZeroSet] = []
    too_long: list[tuple[ZeroSet, TooLong]] = []
    while True:
        stuck = {id(piece) for piece, _ in too_long}  # these stay among the sets that wait: no limit may lose them
        open_pieces = [piece for piece in waiting if id(piece) not in stuck]
        if not open_pieces:
            break
        work.show(f"sets derived for rank < {order + tree.cleared}", len(seen) - len(open_pieces) + 1, len(seen) + 1)
        piece = min(open_pieces, key=_length)
        try:
            parts = _cut(columns, order, piece, bending, work)
        except TooLong as stop:
            too_long.append((piece, stop))
            continue
        for part in parts:
            piece_rank = rank_on(columns, part)
            if piece_rank < order:
                drop = Drop(part, piece_rank)
                if not any(part.lies_inside(other.piece) for other in drops if other.rank == piece_rank):
                    drops.append(drop)
            # the same set only: two sets might each leave their intersection to the other
            elif part.codimension < bound and not any(
                part.codimension == other.codimension and part.lies_inside(other) for other in seen
            ):
                seen.append(part)
                waiting.append(part)
            elif part.codimension >= bound:
                ended.append(part)
        tree.without_points += [(part, order, part.codimension >= bound) for part in work.without_points.values()]
        work.without_points.clear()
        waiting.remove(piece)
        tree.visited += 1
        if unwanted():
            raise Unwanted
    work.special = work.special or _lower_for_these_lengths(columns, order, ended, drops, work)
    if too_long:
        raise too_long[0][1]


def _lower_for_these_lengths(
    columns: list[list[Polynomial]], order: int, ended: Sequence[ZeroSet], drops: Sequence[Drop], work: Work
) -> bool:
    """Whether the rank of this arm is lower than `order` on a set where it is not for general lengths, off all drops.

    Where all joints are bound no minor is factored any more: a relation of lengths under which one vanishes is seen
    nowhere else.
    """
    if not work.lengths:
        return False
    lower = [drop.piece for drop in drops if drop.rank < order]
    for piece in ended:
        work.check()
        at_lengths = replace(piece, lengths=tuple(work.lengths.items()))
        for point, point_rank in zip(at_lengths.samples, _ranks(columns, at_lengths), strict=True):
            if point_rank < order and not any(piece.holds_at([point]) for piece in lower):
                return True
    return False


def _cut(
    columns: list[list[Polynomial]], order: int, piece: ZeroSet, bending: int, work: Work
) -> list[ZeroSet]:
    """The parts of a set on which minors of an order vanish, on each of which the rank is one and the same.

    A set that takes long, or leaves something open, may hold nothing of a lower rank: a proof of that comes second, for
    it costs more than most sets. Where there is none the set is cut by the first minor that does not make polynomials
    too long.
    """
    minors = _chosen(columns, piece, order, work)
    last = piece.codimension + 1 >= bending  # points: they have the lower rank, or are of no use
    # not of several sets: what one of them leaves is told apart by its points
    together = last and not piece.several

    def parts(minor: Polynomial) -> list[ZeroSet]:
        cuts = with_points(meet(piece, minors, work) if together else cut(piece, minor, work), work)
        return with_points(flat_map(lambda one: _by_rank(columns, one, work), cuts), work)

    with work.attempt(_EASY) as undo:
        open_before = len(work.unresolved)
        try:
            pieces = parts(minors[0])
            if len(work.unresolved) == open_before and not work.without_points:
                return pieces
        except OutOfTime:
            pass
        undo()
    work.check()
    if barren(piece.ring, columns, order, piece.pins, piece.equations, work):
        return []
    for minor in minors[: 0 if together else -1]:
        try:
            return parts(minor)
        except TooLong:
            continue
    return parts(minors[-1])


def _bending(columns: list[list[Polynomial]], ring: Ring) -> int:
    """Number of joints that the columns depend on: sets that bind as many are points."""
    degrees = [x.degrees() for x in entries(columns) if x != 0]
    angles = sum(any(d[2 * k] or d[2 * k + 1] for d in degrees) for k in range(ring.angles))
    return angles + sum(any(d[k + ring.angles] for d in degrees) for k in range(ring.angles, ring.moving))


def _length(piece: ZeroSet) -> int:
    return piece.codimension + sum(map(len, piece.equations))


def _by_rank(columns: list[list[Polynomial]], piece: ZeroSet, work: Work) -> Iterator[ZeroSet]:
    """A set, or, where two conditions hold on several, parts of it on each of which all of them have the same rank.

    A minor as large as the highest rank met is zero where the rank is lower. Where it is not, the rank is the highest
    one, by construction; what its factors vanish on is looked at again.
    """
    if piece.several:
        ranks = _ranks(columns, piece)
    else:
        ranks = []
    if len({*ranks}) < 2:
        yield piece
        return
    ring = piece.ring
    remaining: ZeroSet | None = piece
    for atom in _atoms(ring, _parting(columns, piece, ranks, work)):
        if remaining is None or atom.value == "pi":
            continue  # sets with a further joint at π have been taken apart from this one
        whole = remaining
        inside, remaining = whole.split_by_zero(zero_where(ring, atom), atom.f)
        if inside is None:
            continue
        if atom.is_pin:
            parts = components_with_pin(whole, atom.joint, atom.value, work, whole.codimension)
        else:
            parts = [inside]
        for part in parts:
            yield from _by_rank(columns, part, work)
    if remaining is not None:
        yield remaining


def _atoms(ring: Ring, minor: Polynomial) -> list[Atom]:
    """The irreducible conditions under one of which a minor vanishes; a very long one as it stands."""
    if len(minor) <= _FACTORED:
        return [atom for atom, _ in ring.factor(minor).atoms]
    f = primitive(ring.to_half(minor).f)
    return [Atom(0, "", f, str(f))]


def _parting(columns: list[list[Polynomial]], piece: ZeroSet, ranks: list[int], work: Work) -> Polynomial:
    """Of some minors that are not zero at a point of the highest rank, the one that is not zero at most of these."""
    highest = max(ranks)
    full = [point for point, met in zip(piece.samples, ranks, strict=True) if met == highest]
    best: tuple[int, int, Polynomial] | None = None
    for minor in islice(_minors(columns, piece, highest), _TRIED):
        work.check()
        known = [value_at(piece.ring, minor, point) != 0 for point in full]
        if any(known) and (best is None or (-sum(known), len(minor)) < best[:2]):
            best = (-sum(known), len(minor), minor)
        if all(known):
            break
    if best is None:
        raise AssertionError("at a point of rank r some minor of order r is not zero")
    return best[2]


def rank_on(columns: list[list[Polynomial]], piece: ZeroSet) -> int:
    """Rank almost everywhere on a set."""
    return max(_ranks(columns, piece), default=0)


def _ranks(columns: list[list[Polynomial]], piece: ZeroSet) -> list[int]:
    return [rank(matrix, prime) for matrix, prime in residues(piece.ring, columns, piece.samples)]


def _chosen(columns: list[list[Polynomial]], piece: ZeroSet, order: int, work: Work) -> list[Polynomial]:
    """Minors of the given order that are not zero on a set of at least that rank, those with short factors first."""
    tried: list[tuple[int, int, Polynomial]] = []
    for number, minor in enumerate(_minors(columns, piece, order)):
        work.check()
        tried.append((_weight(piece, minor), number, minor))
        if tried[-1][0] <= _SHORT or len(tried) >= _TRIED:
            break
    if not tried:
        raise AssertionError("at a point of rank r some minor of order r is not zero")
    return [minor for _, _, minor in sorted(tried, key=lambda trial: trial[:2])[:_TOGETHER]]


def _minors(columns: list[list[Polynomial]], piece: ZeroSet, order: int) -> Iterator[Polynomial]:
    """Minors of the given order that are not zero on all of a set, those with short entries first."""
    ring = piece.ring
    at_pins = each_entry(lambda x: ring.at(x, piece.pins), columns)
    lengths = each_entry(len, at_pins)
    known = residues(ring, columns, piece.samples)
    for columns_used, rows_used in by_length(lengths, order):
        if any(rank(submatrix(m, columns_used, rows_used), prime) == order for m, prime in known):
            yield ring.determinant(submatrix(at_pins, columns_used, rows_used))


def by_length(lengths: list[list[int]], order: int) -> Iterator[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Choices of columns and rows for a minor, short entries first."""
    n, m = len(lengths), len(lengths[0])
    choices = []
    for chosen in combinations(range(n), order):
        for rows in combinations(range(m), order):
            sums = [[lengths[c][r] for r in rows] for c in chosen]
            if all(map(any, sums)) and all(map(any, zip(*sums, strict=True))):
                choices.append((sum(map(sum, sums)), chosen[-1] - chosen[0], chosen, rows))
    choices.sort()
    return ((chosen, rows) for _, _, chosen, rows in choices)


def _weight(piece: ZeroSet, minor: Polynomial) -> int:
    """How long the factors of a minor are; the minor itself where it is not factored."""
    if len(minor) > _FACTORED:
        return len(minor)
    atoms: list[tuple[Atom, int]] = list(piece.ring.factor(minor).atoms)
    return sum(atom.weight for atom, _ in atoms)
