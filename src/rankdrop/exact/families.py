"""From irreducible sets to families as people list them: real, sharp, merged over 0 and π, named, checked.

*Sharp* conditions hold on a set and nowhere else where the rank is higher. An irreducible set is solved for one
variable after the other, and the equations met on the way may hold elsewhere too: A t + B = 0 and A'B − AB' = 0 hold
where A = B = 0, whatever t is. A factor of a minor that vanishes on the set, and not there, tells the two apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain as chain_of
from itertools import combinations, islice, product

import numpy as np
from numpy.typing import NDArray

from rankdrop.algebra.cut import with_points
from rankdrop.algebra.decompose import decompose
from rankdrop.algebra.matrix import each_entry, submatrix
from rankdrop.algebra.polynomial import Polynomial, coefficients, is_number, variables_in
from rankdrop.algebra.ring import Form
from rankdrop.algebra.work import OutOfTime, TooLong, Work, calling_in_loops, halt_of
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.verify import rank_agreement
from rankdrop.exact.family import EVIDENCE, Pins, Unreal, UnrealSet, equations_of, pins_in_q, slides_at_zero
from rankdrop.exact.letters import letters_text, sign_of
from rankdrop.exact.rows import SetsInRow, merge, row_of_set
from rankdrop.exact.tidy import tidy
from rankdrop.exact.tree import Drop, by_length, largest, rank_on
from rankdrop.families.distinct_names import distinct_names
from rankdrop.families.lost import LostFreedom
from rankdrop.families.name import FamilyName
from rankdrop.families.naming import lost_motions, name_family
from rankdrop.families.record import Check, ExactConditions, Family, Order, exact_of, place_of
from rankdrop.families.unfinished import Unfinished, UnfinishedKind
from rankdrop.formula.equation import Equation, System
from rankdrop.formula.writing import RADIANS, Condition, pin_of
from rankdrop.lists import flat_map
from rankdrop.local.block import sampling_box, singular_values
from rankdrop.problem import Problem, wrap_joints
from rankdrop.robot.model import Array
from rankdrop.tolerances import CONDITION_FAILS, DEFAULT, RANK_HIGHER, RANK_KEPT, REAL_STARTS, SMOOTH
from rankdrop.units import out_of_units

_MANY_STARTS = 1_000  # a part that one start in a hundred reaches is missed with a chance of 4e-5
_MANY_TERMS = 1_000_000  # terms evaluated in a step of Newton's method from all of them
_CLEARLY = 1e-2  # σ of a configuration that is near no singular one [1]
_PAIRED = 4  # joints that conditions bind up to which two at a time are held at right angles
_HELD_STARTS = 12  # random starts for the others
_MINORS = 60  # minors that are factored in search of a condition
_ENOUGH = 6  # conditions that are compared

_SEPARATED = 3  # conditions added at most
_MARK = 20  # terms of a condition that may stand in a name
_CHECKED = 3  # random points modulo a prime at which the rank of each irreducible set is taken again
_ROUND = 0.1  # free angles of a witness stand at multiples of this [rad]


@dataclass(frozen=True, eq=False)
class Reality:
    """Real points of an irreducible set.

    Attributes:
        points: (k, n) real configurations of `Chain.own` on it, of the rank claimed; none where it is not real.
        smooth: at one of them the gradients have full rank: near it the real set has the dimension claimed.
        excluded: proven not to be real: a discriminant is negative for the arm's lengths.
        discriminants: expressions in the lengths that are not negative if and only if the set is real; none where that
            is plain. Of an excluded set the negative one alone, none where it is a number.
        strays: (k, n) real configurations of higher rank that satisfy the conditions of the set, too.
        unclear: at so many more the conditions hold, and the rank is neither lost nor clearly higher: they are near
            points at which conditions touch zero only.
    """

    points: Array
    smooth: bool
    excluded: bool
    discriminants: tuple[str, ...]
    strays: Array
    unclear: int = 0

    @property
    def real(self) -> bool:
        """Whether real points of the dimension claimed were found."""
        return self.smooth and len(self.points) > 0


def reality(chain: Chain, piece: ZeroSet, rank: int, rng: np.random.Generator) -> Reality:
    """Look for real points on a set, with the arm's own lengths.

    Args:
        chain: the arm.
        piece: irreducible set.
        rank: of the task Jacobian almost everywhere on it.
        rng: source of starts.
    """
    n = chain.n
    discriminants: list[str] = []
    for f in piece.equations:
        discriminant = _discriminant(piece, f)
        if discriminant is None:
            continue
        text = letters_text(chain.ring, discriminant)
        if sign_of(chain, discriminant) < 0:
            none = np.empty((0, n))
            if text:
                return Reality(none, False, True, (text,), none)
            return Reality(none, False, True, (), none)
        if text and not is_number(discriminant) and not _always(chain, discriminant):
            discriminants.append(text)
    return replace(real_points(chain, piece, rank, rng), discriminants=tuple(discriminants))


def real_points(chain: Chain, piece: ZeroSet, rank: int, rng: np.random.Generator) -> Reality:
    """Real configurations met on a set from random starts; arguments as in `reality`."""
    n = chain.n
    theta = rng.uniform(-np.pi, np.pi, (REAL_STARTS, n))
    low, high = sampling_box(chain.own, chain.own_task, limits=False)
    for j in chain.ring.prismatic:  # of their travel
        theta[:, j - 1] = low[j - 1] + (high[j - 1] - low[j - 1]) * (theta[:, j - 1] + np.pi) / (2 * np.pi)
    pinned = list(piece.pins)
    for j, value in piece.pins.items():
        theta[:, j - 1] = RADIANS[value]
    q = theta - chain.shifts
    equations = _equations(chain, piece.equations)
    system = System(equations)
    moving = np.delete(np.eye(n), [j - 1 for j in pinned], axis=1)
    good = np.ones(REAL_STARTS, dtype=np.bool_)
    if equations:
        starts = q
        q, good = system.solve(starts, along=moving, iterations=60)
        if not good.any():
            q, good = system.solve_flat(starts, along=moving, iterations=200)
    sigma = singular_values(chain.own, q, chain.own_task)
    if rank < sigma.shape[1]:
        full = sigma[:, rank]
    else:
        full = np.zeros(REAL_STARTS)
    strays = q[good & (full > RANK_HIGHER)]
    unclear = int((good & (full > DEFAULT.singular) & (full <= RANK_HIGHER)).sum())
    good &= full <= DEFAULT.singular
    if rank:
        good &= sigma[:, rank - 1] > RANK_KEPT
    else:
        good &= True
    q = q[good]
    if not equations or not len(q):
        return Reality(q, len(q) > 0, False, (), strays, unclear)
    smooth = full_rank(system.jacobian(q) @ moving, piece.codimension - len(pinned))
    return Reality(q[smooth] if smooth.any() else q, bool(smooth.any()), False, (), strays, unclear)


def full_rank(gradients: Array, wanted: int) -> NDArray[np.bool_]:
    """(k,) whether gradients (k, conditions, joints) of rank `wanted` are more than what rounding leaves of none."""
    return np.asarray((np.linalg.svd(gradients, compute_uv=False) > SMOOTH).sum(axis=1) >= wanted)


def _discriminant(piece: ZeroSet, f: Polynomial) -> Polynomial | None:
    """b² − 4ac of a condition on one angle alone; None for another one."""
    ring = piece.ring
    places = [place for place in variables_in(f) if place < ring.moving]
    if len(places) != 1 or f.degrees()[places[0]] != 2:
        return None
    c, b, a = coefficients(f, places[0])
    return b * b - 4 * a * c


def _always(chain: Chain, f: Polynomial) -> bool:
    """Whether f ≥ 0 for a plain reason: a number, a sum of squares times positive numbers."""
    return all(value > 0 and not any(e % 2 for e in powers) for powers, value in f.terms())


def special_strays(chain: Chain, piece: ZeroSet, rank: int) -> Array:
    """(k, n) configurations of higher rank that satisfy the conditions of a set, where few random starts lead to.

    They have joints at right angles, where conditions may vanish whatever the other joints do, or which the others have
    to fit, or they satisfy N = D = 0 of a solution t = N/D, where its condition says nothing of t; or they are on a
    part of the solutions that one start in a hundred reaches.
    """
    rng = np.random.default_rng(1)
    shape = REAL_STARTS, chain.n
    right, turned, anywhere = rng.integers(-1, 3, shape), rng.random(shape) < 0.5, rng.uniform(-np.pi, np.pi, shape)
    theta = np.array([np.where(turned, right * (np.pi / 2), anywhere), anywhere])
    theta[..., [j - 1 for j in chain.ring.prismatic]] = 0.0
    for j, value in piece.pins.items():
        theta[..., j - 1] = RADIANS[value]
    aligned, starts = theta - chain.shifts
    equations = _equations(chain, piece.equations)
    if not equations or rank >= min(chain.n, chain.own_task.m):
        return np.empty((0, chain.n))
    seeds, moving = [aligned], np.delete(np.eye(chain.n), [j - 1 for j in piece.pins], axis=1)
    for solved in piece.solved:
        both = [chain.ring.form(f).at(piece.pins).f for f in (solved.numerator, solved.denominator)]
        if all(map(variables_in, both)):
            system = System((*equations, *_equations(chain, both)))
            seeds.append(system.solve(starts, along=moving, iterations=60)[0])
    seeds += _with_right_angles(chain, piece, System(equations), starts, moving)
    q = np.concatenate(seeds)
    q = q[System(equations).zero(q)]
    strays = q[singular_values(chain.own, q, chain.own_task)[:, rank] > RANK_HIGHER]
    return np.concatenate([strays, _from_many_starts(chain, piece, System(equations), rank, moving)])


def _from_many_starts(chain: Chain, piece: ZeroSet, system: System, rank: int, moving: Array) -> Array:
    """(k, n) configurations clearly of higher rank at which two conditions or more meet, from many random starts.

    Near a multiple zero Newton's method ends a thousandth of a radian away, where σ is small and not zero: such ends
    are no strays.
    """
    terms = sum(map(len, piece.equations))
    count = min(_MANY_STARTS, _MANY_TERMS // terms)
    if len(piece.equations) < 2 or count <= REAL_STARTS:
        return np.empty((0, chain.n))
    starts = np.random.default_rng(2).uniform(-np.pi, np.pi, (count, chain.n))
    for j, value in piece.pins.items():
        starts[:, j - 1] = RADIANS[value] - chain.shifts[j - 1]
    q, good = system.solve(starts, along=moving, iterations=60)
    higher = singular_values(chain.own, q, chain.own_task)[:, rank] > _CLEARLY
    return np.asarray(q[good & higher])


def _with_right_angles(
    chain: Chain, piece: ZeroSet, system: System, starts: Array, moving: Array
) -> Iterator[Array]:
    """Solutions of the conditions of a set with one or two of the joints that they bind held at right angles.

    One irreducible condition holds on the set alone, whatever the angles are.
    """
    if len(piece.equations) < 2:
        return
    bound = sorted({j for f in piece.equations for j in Condition(chain.ring, f).joints} - {*chain.ring.prismatic})
    sizes = (1, 2) if len(bound) <= _PAIRED else (1,)
    for held in chain_of.from_iterable(combinations(bound, size) for size in sizes):
        free = moving[:, [not any(column[j - 1] for j in held) for column in moving.T]]
        for angles in product(RADIANS.values(), repeat=len(held)):
            q = starts[:_HELD_STARTS].copy()
            for j, angle in zip(held, angles, strict=True):
                q[:, j - 1] = angle - chain.shifts[j - 1]
            yield system.solve(q, along=free, iterations=60)[0]


def _equations(chain: Chain, conditions: Sequence[Polynomial]) -> tuple[Equation, ...]:
    """Half-angle polynomials as equations in configurations of `Chain.own`."""
    shifts = chain.whole_shifts.tolist()
    return tuple(
        Condition(chain.ring, chain.own_polynomial(f)).equation(chain.own_numbers, chain.n, shifts) for f in conditions
    )


def add_separating_condition(
    chain: Chain, piece: ZeroSet, rank: int, strays: Array, known: list[Polynomial], work: Work
) -> ZeroSet | None:
    """The set with one more condition, which fails at some of the strays; None where none was found.

    Args:
        chain: the arm.
        piece: irreducible set.
        rank: of the task Jacobian almost everywhere on it.
        strays: (k, n) configurations of `Chain.own`, of higher rank, at which all its conditions hold.
        known: conditions that served other sets: tried first, so that sets alike get the same words; the new one is
            added.
        work: deadline.

    Raises:
        OutOfTime: the deadline has passed.
    """
    if not len(strays):
        return None
    best: tuple[tuple[int, int], Polynomial] | None = None
    for f in islice(_candidates(chain, piece, rank, known, work), _ENOUGH + len(known)):
        away = _count_violations(chain, f, strays)
        if away and (best is None or (-away, len(f)) < best[0]):
            best = ((-away, len(f)), f)
        if away and any(f is condition for condition in known):
            best = ((-away, len(f)), f)
            break
    if best is None:
        return None
    f = best[1]
    if not any(f is condition for condition in known):
        known.append(f)
    # in `zero`, too: random points modulo a prime would else be met beside the set
    return piece.saying(f, chain.ring.trig_zero_set(f))


def _count_violations(chain: Chain, f: Polynomial, strays: Array) -> int:
    """At how many configurations a condition does not hold."""
    equation = Condition(chain.ring, chain.own_polynomial(f)).equation(
        chain.own_numbers, chain.n, chain.whole_shifts.tolist()
    )
    return int((np.abs(equation(strays)) > CONDITION_FAILS).sum())


def _candidates(
    chain: Chain, piece: ZeroSet, rank: int, known: Sequence[Polynomial], work: Work
) -> Iterator[Polynomial]:
    """Half-angle polynomials that vanish on a set: known ones, then factors of minors that are zero on it."""
    ring = piece.ring
    seen = {str(f) for f in piece.equations}
    pinned = {ring.index[f"t{joint}"] for joint in piece.pins}
    for f in known:
        if not pinned & {*variables_in(f)} and piece.half_vanishes(f):
            yield f
    matrix, lower = chain.cleared_columns
    columns = each_entry(lambda x: ring.at(x, piece.pins), matrix)
    lengths = [[len(x) if x != 0 else 0 for x in column] for column in columns]
    for columns_used, rows_used in islice(by_length(lengths, rank - lower + 1), _MINORS):
        work.check()
        minor = ring.determinant(submatrix(columns, columns_used, rows_used))
        for atom, _ in ring.factor(minor).atoms if minor != 0 else ():
            if not atom.is_pin and atom.key not in seen and piece.half_vanishes(atom.f):
                seen.add(atom.key)
                yield atom.f


def real_sets(
    chain: Chain,
    drops: Sequence[Drop],
    work: Work,
    left: list[Unfinished],
    seed: int = 0,
    cases: list[Drop] | None = None,
) -> tuple[list[tuple[Drop, Reality]], list[UnrealSet]]:
    """The sets that have real points, in short words, with these points, and the sets that have none.

    Where the real points of a set are fewer than its conditions say (a sum of squares vanishes), the set is cut down to
    them by the derivatives of its conditions.

    Args:
        chain: the arm.
        drops: of its rank tree.
        work: deadline.
        left: gets what is not finished.
        seed: of the random starts.
        cases: gets the sets that are not finished, in place of `left`: a limit was reached, their conditions hold at
            configurations of higher rank, too, or their real points are not all known. None: all go to `left`.
    """
    kept: list[tuple[Drop, Reality]] = []
    left_out: dict[UnrealSet, list[ZeroSet]] = {}  # by reason, without conditions
    known: list[Polynomial] = []
    waiting = list(drops)
    while waiting:
        work.show("sets with real points", max(len(drops) - len(waiting), 0), len(drops))
        try:
            work.check()
            drop = waiting[0]
            with calling_in_loops(work.check):
                piece, real = _sharp(chain, drop, np.random.default_rng([seed, len(kept), drop.rank]), known, work)
                systems = len(work.unresolved)
                work.without_points.clear()
                if real.real or real.excluded:
                    thinner = []
                else:
                    thinner = _thinner(chain, piece, work)
        except (Exception, KeyboardInterrupt) as stop:
            _keep_unsearched(stop, waiting, len(drops), left, cases)
            if isinstance(stop, KeyboardInterrupt):
                work.interrupt()
            break
        waiting = [*waiting[1:], *thinner]
        open_, why = _verdict(piece, real)
        if work.without_points or len(work.unresolved) > systems:
            open_ = UnfinishedKind.REAL_POINTS
            work.without_points.clear()
        elif thinner:
            open_ = None
        is_case = _keep_open(open_, drop, piece, left, cases)
        if real.real and not is_case:
            kept.append((Drop(piece, drop.rank), real))
        if why and not thinner and not open_:
            left_out.setdefault(why, []).append(piece)
    remaining = largest([drop for drop, _ in kept])
    unreal = [replace(why, conditions=row.text) for why, pieces in left_out.items() for row in merge(pieces)]
    return [pair for pair in kept if any(pair[0] is drop for drop in remaining)], unreal


def _keep_open(
    open_: UnfinishedKind | None, drop: Drop, piece: ZeroSet, left: list[Unfinished], cases: list[Drop] | None
) -> bool:
    """Keep a set of which something remains open, None for nothing: as a case, or in `left`; whether it is a case."""
    if open_ is not None and cases is not None:
        cases.append(drop)
        return True
    if open_ is not None:
        left.append(Unfinished(open_, rank=drop.rank, conditions=row_of_set(piece).text))
    return False


def _keep_unsearched(
    stop: BaseException, waiting: Sequence[Drop], total: int, left: list[Unfinished], cases: list[Drop] | None
) -> None:
    """Keep the sets that wait where the search for real points ends: as cases where a limit ended it, else in `left`.
    """
    if cases is not None and isinstance(stop, OutOfTime | TooLong):
        cases += waiting
        return
    left.append(Unfinished(UnfinishedKind.UNSEARCHED, halt=halt_of(stop), number=len(waiting), total=total))


def _verdict(piece: ZeroSet, real: Reality) -> tuple[UnfinishedKind | None, UnrealSet | None]:
    """What remains open of a set, None for nothing, and why it is left out, None where it is not."""
    if real.real and len(real.strays):
        return UnfinishedKind.STRAYS, None
    if real.real:
        return None, None
    if real.excluded:
        return None, UnrealSet("", Unreal.PROVEN, negative="".join(real.discriminants))
    if real.unclear or (len(piece.equations) > 1 and len(real.points)):
        return UnfinishedKind.DEPENDENT, None
    return None, UnrealSet("", Unreal.NOT_FOUND, tried=REAL_STARTS)


def _sharp(
    chain: Chain, drop: Drop, rng: np.random.Generator, known: list[Polynomial], work: Work
) -> tuple[ZeroSet, Reality]:
    """A set in short words, with conditions added until no configuration of higher rank satisfies them."""
    piece = tidy(drop.piece, work)
    real = reality(chain, piece, drop.rank, rng)
    for _ in range(_SEPARATED):
        more = add_separating_condition(chain, piece, drop.rank, real.strays, known, work)
        if more is None:
            break
        piece, real = more, reality(chain, more, drop.rank, rng)
    if not real.real or len(real.strays):
        return piece, real
    strays = special_strays(chain, piece, drop.rank)
    for _ in range(_SEPARATED):
        more = add_separating_condition(chain, piece, drop.rank, strays, known, work)
        if more is None:
            break
        piece, strays = more, special_strays(chain, more, drop.rank)
    return piece, replace(real, strays=strays)


def _thinner(chain: Chain, piece: ZeroSet, work: Work) -> list[Drop]:
    """The real points of a set whose condition does not change its sign: there its derivatives vanish too."""
    if len(piece.equations) != 1 or piece.zero:
        return []
    ring, form = chain.ring, chain.ring.form(piece.equations[0])
    f = form.f
    slopes = []
    for place, name in enumerate(ring.names[: ring.moving]):
        slope = f.derivative(name)
        if place < ring.angles:  # by the angle, of f / (1 + t²)^(D/2): a polynomial of degree D again
            t = f.context().gen(place)
            slope = (1 + t**2) * slope - form.degrees[place] * t * f
        slopes.append(Form(ring, slope, form.degrees))
    pieces = decompose(ring, piece.pins, [form, *slopes], chain.n, work)
    smaller = with_points([component for component in pieces if component.codimension > piece.codimension], work)
    columns, lower = chain.cleared_columns
    return [Drop(component, rank_on(columns, component) + lower) for component in smaller]


def families(
    chain: Chain, sets: Sequence[tuple[Drop, Reality]], generic_rank: int, work: Work
) -> list[Family]:
    """Merge sets that differ in the simple angle of a joint only, and describe each family.

    Args:
        chain: the arm.
        sets: from `real_sets`.
        generic_rank: of the task Jacobian.
        work: random points.

    Returns:
        Families by corank, large ones first, with their numbers.
    """
    result: list[Family] = []
    seen = {id(drop.piece): reality for drop, reality in sets}
    for corank in range(1, generic_rank + 1):
        rank = generic_rank - corank
        by_discriminants: dict[tuple[str, ...], list[ZeroSet]] = {}
        for drop, reality in sets:
            if drop.rank == rank:
                by_discriminants.setdefault(reality.discriminants, []).append(drop.piece)
        rows = flat_map(merge, by_discriminants.values())
        of_corank: list[Family] = []
        for row in rows:
            work.show("families described", len(result) + len(of_corank), len(result) + len(rows))
            realities = [seen[id(piece)] for piece in row.pieces]
            parts = [real.points for real in realities]
            bound = tuple(sorted({j for f in row.equations for j in Condition(chain.ring, f).joints}))
            description = _describe_family(chain, generic_rank, corank, parts, row.pins, bound)
            tried = (piece.points(work.rng, _CHECKED) or piece.samples[:_CHECKED] for piece in row.pieces)
            check = rank_agreement(chain, chain_of.from_iterable(tried), rank)
            of_corank.append(_family(chain, corank, row, realities[0].discriminants, description, check))
        of_corank.sort(key=_place)
        called = [family.called for family in of_corank]
        names = distinct_names(called, [partial(_marks, family) for family in of_corank])
        result += [
            replace(family, id=f"k{corank}.f{number}", called=name)
            for number, (family, name) in enumerate(zip(of_corank, names, strict=True), 1)
        ]
    return result


def _place(family: Family) -> Order:
    """Place of a family among those of its corank."""
    polynomials = [condition.polynomial for condition in exact_of(family).polynomials]
    short_first = sorted(f"{len(polynomial):06} {polynomial}" for polynomial in polynomials)
    return place_of(family.dimension, family.pinned, family.coupled, short_first)


def _marks(family: Family) -> list[str]:
    """The conditions that may tell a family from another one in a name: long ones take time to be written shortly."""
    exact = exact_of(family)
    short = [condition for condition in exact.polynomials if len(condition.polynomial) <= _MARK]
    return [*(pin.text() for pin in exact.pins), *(condition.text() for condition in short)]


def _family(
    chain: Chain,
    corank: int,
    row: SetsInRow,
    discriminants: tuple[str, ...],
    description: tuple[FamilyName, tuple[LostFreedom, ...], tuple[float, ...]],
    check: Check,
) -> Family:
    """One row of sets as a family, its number and final name still to come."""
    name, lost, witness = description
    pins = tuple(pin_of(chain.ring, *pin) for pin in sorted(row.pins.items()))
    polynomials = tuple(Condition(chain.ring, f) for f in sorted(row.equations, key=len))
    coupled = tuple(sorted(set(flat_map(lambda condition: condition.joints, polynomials))))
    shifts = tuple(float(x) for x in chain.whole_shifts)
    pinned = pins_in_q(chain.robot, pins, shifts)
    exact = ExactConditions(
        pinned=(*pinned, *slides_at_zero(chain.robot, polynomials)),
        stated=(*pins, *polynomials),
        not_negative=discriminants,
        rank_check=check,
        numbers=chain.numbers,
        shifts=shifts,
        pieces=row.pieces,
    )
    return Family(
        id="",
        called=name,
        corank=corank,
        dimension=row.pieces[0].dimension,
        pinned=pinned,
        free=tuple(j for j in range(1, chain.n + 1) if j not in row.pins and j not in coupled),
        coupled=coupled,
        equations=equations_of((*pins, *polynomials), chain.numbers, shifts),
        witness=witness,
        lost_directions=np.empty((0, 6)),
        lost_freedoms=lost,
        evidence=EVIDENCE,
        exact=exact,
    )


def _describe_family(
    chain: Chain, generic_rank: int, corank: int, parts: Sequence[Array], pins: Pins, coupled: Sequence[int]
) -> tuple[FamilyName, tuple[LostFreedom, ...], tuple[float, ...]]:
    """(name, freedoms lost, witness) of a family, seen at real points of it.

    Args:
        chain: the arm.
        generic_rank: of the task Jacobian.
        corank: of the family.
        parts: (k, n) real configurations of `Chain.own` on each of its sets, of exactly this corank; k ≥ 1.
        pins: its pinned joints.
        coupled: joints that its other conditions bind.
    """
    robot, task, points = chain.own, chain.own_task, np.concatenate(parts)
    at = _witness(chain, generic_rank - corank, points, pins)
    name = name_family(robot, task, _one_of_each_first(parts), sorted(pins), coupled=coupled)
    _, lost = lost_motions(Problem(robot, task, corank), at, points)
    return name, lost, tuple(float(x) for x in out_of_units(chain.robot, at))


def _one_of_each_first(parts: Sequence[Array]) -> Array:
    """All points of several sets, first one of each set, then a second one of each: a name is read off the first few,
    and has to be true of every set.
    """
    turn = np.concatenate([np.arange(len(part)) for part in parts])
    return np.asarray(np.concatenate(parts)[np.argsort(turn, kind="stable")])


def _witness(chain: Chain, rank: int, points: Array, pins: Pins) -> Array:
    """The point whose next singular value is largest, joints on which nothing depends set to 0, free ones rounded."""
    q = wrap_joints(chain.own, points)
    rounded = q.copy()
    for joint in range(chain.n):
        tried = rounded.copy()
        if joint in (0, chain.n - 1):
            tried[:, joint] = 0.0
        else:
            tried[:, joint] = np.round(tried[:, joint] / _ROUND) * _ROUND
        if joint + 1 not in pins and _holds(chain, rank, tried):
            rounded = tried
    sigma = singular_values(chain.own, rounded, chain.own_task)
    best = rounded[int(np.argmax(sigma[:, rank - 1] if rank else sigma[:, 0]))]
    return np.asarray(np.where(np.abs(best) < 1e-15, 0.0, np.round(best, 15)))


def _holds(chain: Chain, rank: int, q: Array) -> bool:
    sigma = singular_values(chain.own, q, chain.own_task)
    if rank < sigma.shape[1]:
        low = sigma[:, rank:].max(axis=1)
    else:
        low = np.zeros(len(q))
    if rank:
        high = sigma[:, rank - 1]
    else:
        high = np.ones(len(q))
    return bool((low <= DEFAULT.singular).all() and (high > RANK_KEPT).all())
