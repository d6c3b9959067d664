"""The table of families of one corank, with what speaks for each family.

Where the families were derived exactly, these are the table, and the searches test it in both directions: points solved
on a family are singular, of its corank and dimension (`Tested`), and singular points lie on a family. Where no
derivation finished, conditions are fitted to the cloud:

1. Every point gets a signature from D (`signature`): joints pinned, free, coupled; whole-number relations.
2. Groups of one signature become rows (`fit`): values are snapped, completed by symmetry and verified directly by σ;
   equations of coupled joints are fitted.

Both kinds of rows are tested in the same way. Soundness: the equations are solved from random starts and the rank is
taken; a fitted row that fails there is dropped. Then they are solved at special places (`solve_at_special_values`);
solutions there that are regular are counted, and make the row unsound for everyone to see. Completeness: fresh points
from another seed, none of which was used before, lie on the rows or are listed as a family without a name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.corank_families import CorankFamilies, CorankSummary
from rankdrop.families.descent import not_singular, verify_points
from rankdrop.families.distinct_names import distinct_names
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.fit import find_rows
from rankdrop.families.inspection import HIGHER, Inspection, inspect
from rankdrop.families.linear_conditions import Linear
from rankdrop.families.name import FamilyName
from rankdrop.families.naming import lost_motions, name_family
from rankdrop.families.pictured import witness
from rankdrop.families.record import Check, Family, Pin, number_families
from rankdrop.families.rescaling import family_in_units, family_out_of_units
from rankdrop.families.row import Membership, Row, membership, on_any, row_of, stated_row
from rankdrop.families.searching import Outcome, Progress, Search, none_found, search, unseen
from rankdrop.families.soundness import solve_at_special_values, soundness
from rankdrop.formula.equation import SOLVED, Mask, pretty_angle
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.numbers import wrap_angle
from rankdrop.units import in_units, into_units, task_in_units

FRESH = 1000  # independent points wanted for completeness
MOST_FRESH = 20_000  # starts spent on them at most
OTHER_SEED = 1_000_003  # added to the seed for the fresh points
STEPS = 100  # of the progress: rows up to 60, fresh points to 80, rows finished to 100

Tested = tuple[Check, Array, int]
"""Points solved from a row's conditions: how many there are, and how many have the corank; (N, n) up to 24 of exactly
the corank; the smallest dimension of ker D at these, which no family through them exceeds, n without such points."""

VALUES = 12  # values of a pinned joint that are listed at most
SMALL = 0.5  # a group with less than this share of another's points is small beside it
Joints = tuple[int, ...]
Shape = tuple[bool, int, Joints, Joints, Joints]
"""Regular or not; rank of D; joints pinned, free, coupled."""


def families(
    cloud: Search,
    *,
    known: Sequence[Family] | None = None,
    seed: int = 0,
    fresh: Search | int = FRESH,
    threads: int = 0,
    progress: Progress | None = None,
    near_misses: bool = True,
) -> CorankFamilies:
    """All families of one corank, with soundness, completeness and an estimate of what was not seen.

    Args:
        cloud: the search whose converged points test the families, and make them where none are known.
        known: the families of this corank as they were derived; None: conditions are fitted to the cloud.
        seed: of every random choice; same seed and cloud, same table.
        fresh: another search, independent of `cloud`, for completeness; or the points of exactly this corank that one
            made here has at least (as far as 20 000 starts give them).
        threads: for the fresh search.
        progress: called with (done, total).
        near_misses: bring the smallest σ of a nonzero local minimum down; without it the summary has none.

    Returns:
        CorankFamilies: the summary, and known families in their order, or fitted ones sorted by dimension (large
        first), then by joint numbers; groups of points that no conditions hold on come last, with `named=False`.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = families(search(open_robot("scara"), 1, starts=100))
        >>> [(family.dimension, str(family.equations[0])) for family in found.families]
        [(3, 'sin θ2')]
    """
    if cloud.robot.exponent is None:
        inner = families(
            _in_units(cloud),
            known=None if known is None else [family_in_units(family, cloud.robot) for family in known],
            seed=seed, fresh=_in_units(fresh) if isinstance(fresh, Search) else fresh, threads=threads,
            progress=progress, near_misses=near_misses,
        )  # fmt: skip
        return _out_of_units(inner, cloud.robot)
    report = progress or (lambda done, total: None)
    problem = cloud.problem
    points = verify_points(problem, cloud.converged)
    inspection = inspect(problem, points, signatures=known is None)
    cover = membership(problem, points)
    rows = _rows(problem, inspection, cover, known, seed, report)
    tested = _test_rows(problem, rows, inspection, cover, seed)
    kept = list(tested)
    report(60, STEPS)
    others = verify_points(problem, _fresh(cloud, inspection, seed, threads, fresh))
    checked = inspect(problem, others, signatures=False)
    report(80, STEPS)
    new = membership(problem, others)
    explained = checked.exact & on_any(new, kept, len(others))
    off_cloud = inspection.exact & ~on_any(cover, kept, len(points))
    off_fresh = checked.exact & ~explained
    wrong, lowest = _regular_points(problem, kept, np.concatenate([points[off_cloud], others[off_fresh]]))
    wrong_of_cloud, wrong_of_fresh = np.split(wrong, [int(off_cloud.sum())])
    off_cloud[off_cloud] = ~wrong_of_cloud
    off_fresh[off_fresh] = ~wrong_of_fresh
    rest = unexplained_families(problem, inspection, off_cloud, checked, off_fresh)
    share = Check(int((explained | off_fresh).sum()), int(explained.sum()))
    listed = []
    for count, row in enumerate(kept if known is not None else sorted(kept, key=_order)):
        explains = Check(share.tested, int((checked.exact & new(row)).sum()))
        shown = witness(problem, row, np.random.default_rng([seed, cloud.corank, 8, count]))
        listed.append(_family(problem, row, tested[row], explains, shown))
        report(80 + 20 * count // len(kept), STEPS)
    ordered = _order_families(listed, [family for family, _ in rest], known, cloud.corank)
    pieces = _pieces(cover, kept, inspection) + [count for _, count in rest]
    report(STEPS, STEPS)
    summary = _summary(cloud, share, int((~checked.exact).sum()), pieces, near_misses)
    return CorankFamilies(summary, ordered, _contradicted_families(tested), int(wrong.sum()), lowest)


def _rows(
    problem: Problem, inspection: Inspection, cover: Membership, known: Sequence[Family] | None, seed: int,
    report: Progress,
) -> list[Row]:  # fmt: skip
    """Rows of the derived families; without these, rows fitted to the cloud, which is the progress up to 60."""
    if known is not None:
        return [row_of(problem, family) for family in known]
    return find_rows(problem, inspection, cover, seed, lambda done, total: report(60 * done // max(total, 1), STEPS))


def _regular_points(problem: Problem, rows: Sequence[Row], q: Array) -> tuple[Mask, float]:
    """(N,) points on no row that only look singular, and the lowest σ next to them: see `not_singular`."""
    return not_singular(problem, q, lambda at: on_any(membership(problem, at), rows, len(at)) | _solves_row(rows, at))


def _order_families(
    listed: Sequence[Family], unnamed: Sequence[Family], known: Sequence[Family] | None, corank: int
) -> tuple[Family, ...]:
    """The table: families with conditions, then groups of points without; fitted ones get ids and names here."""
    if known is None:
        return _told_apart(number_families([*listed, *unnamed], corank))
    return (*listed, *number_families(unnamed, corank, after=len(known)))


def _contradicted_families(tested: Mapping[Row, Tested]) -> tuple[tuple[Family, int | None], ...]:
    """Derived families larger than ker D at their points allows, with that dimension; None where none has a point."""
    contradicted: list[tuple[Family, int | None]] = []
    for row, (_, points, dimension) in tested.items():
        if row.family is None:
            continue
        if not len(points):
            contradicted.append((row.family, None))
        elif row.family.dimension > dimension:
            contradicted.append((row.family, dimension))
    return tuple(contradicted)


def _solves_row(rows: Sequence[Row], q: Array) -> Mask:
    """(N,) whether singular configurations solve the equations of a row, which may be flat next to a special structure.
    """
    solved = np.zeros(len(q), dtype=np.bool_)
    for row in rows:
        solved |= np.abs(row.system.values(q)).max(axis=1) <= SOLVED
    return solved


def _test_rows(
    problem: Problem, rows: Sequence[Row], inspection: Inspection, cover: Membership, seed: int
) -> dict[Row, Tested]:
    """The rows with what speaks for each.

    Of fitted rows those that are sound at random solutions; of derived ones all, but those that have no point within
    the limits where these are asked for.
    """
    marks = _marks(rows)
    outcomes: dict[Row, Tested] = {}
    for i, row in enumerate(rows):
        rng = np.random.default_rng([seed, problem.corank, 7, i])
        if row.family is None:
            stated = row
        else:
            stated = stated_row(problem, row.family)
        sound, _ = soundness(problem, stated.system, row.signature.rank, rng, exact=row.family is not None)
        points, room = _generic(problem, row, inspection.q[cover(row)], rng)
        fitted_badly = row.family is None and not sound.holds
        if fitted_badly or (not len(points) and (row.family is None or problem.limits)):
            continue
        count, regular = solve_at_special_values(problem, stated, marks, rng)
        whole = Check(sound.tested + count, sound.agree + count - len(regular))
        outcomes[row] = (whole, points, room)
    return outcomes


def _told_apart(families: Sequence[Family]) -> tuple[Family, ...]:
    names = distinct_names([family.called for family in families], [partial(_texts, family) for family in families])
    return tuple(replace(family, called=name) for family, name in zip(families, names, strict=True))


def _texts(family: Family) -> list[str]:
    """The conditions of a family for people, as far as they are short."""
    pins = [f"θ{pin.number} = {' or '.join(map(pretty_angle, pin.values))}" for pin in family.pinned]
    return [*pins, *(f"{equation} = 0" for equation in family.equations)]


def _in_units(cloud: Search) -> Search:
    robot = cloud.robot
    return replace(
        cloud, robot=in_units(robot), task=task_in_units(cloud.task, robot), q=into_units(robot, cloud.q)
    )


def _out_of_units(families: CorankFamilies, robot: Robot) -> CorankFamilies:
    """Families of an arm in its own unit of length, in the unit of `robot`."""
    return replace(families, families=tuple(family_out_of_units(family, robot) for family in families.families))


def _marks(rows: Sequence[Row]) -> dict[int, list[float]]:
    """Joint (from 0) -> the values at which some row pins it."""
    marks: dict[int, list[float]] = {}
    for row in rows:
        for joint, values in zip(row.signature.pinned, row.sets, strict=False):
            marks.setdefault(joint, []).extend(values)
    return marks


def _fresh(cloud: Search, inspection: Inspection, seed: int, threads: int, wanted: Search | int) -> Array:
    """Points of a search with another seed: at least `wanted` of exactly this corank where possible."""
    if isinstance(wanted, Search):
        return wanted.converged
    problem = cloud.problem
    rate = max(float(inspection.exact.sum()) / len(cloud.outcome), wanted / MOST_FRESH)
    parts: list[Array] = [np.zeros((0, problem.n))]
    higher, spent = 0, 0
    for attempt in range(4 if len(inspection.q) else 0):
        starts = int(min(1.1 * (wanted - higher) / rate + 50, MOST_FRESH - spent))
        if higher >= wanted or starts < 1:
            break
        part = search(
            problem.robot, problem.corank, task=problem.task, starts=starts, seed=seed + OTHER_SEED * (attempt + 1),
            limits=problem.limits, threads=threads, tolerances=problem.tolerances,
        )  # fmt: skip
        if not part.complete:
            raise KeyboardInterrupt  # the core met Ctrl-C; a count of part of the points would mislead
        sigma = part.sigma[part.outcome == Outcome.CONVERGED]
        if problem.rank:
            higher += int((sigma[:, problem.rank - 1] > HIGHER).sum())
        else:
            higher += len(sigma)
        spent += starts
        parts.append(part.converged)
    return np.concatenate(parts)


def _order(row: Row) -> tuple[int, tuple[int, ...], tuple[int, ...], tuple[tuple[float, ...], ...]]:
    """By which the rows get their random numbers: what a row is, not when it was found."""
    s = row.signature
    return (s.rank, s.pinned, s.coupled, row.sets)


def _family(problem: Problem, row: Row, tested: Tested, explains: Check, shown: Array | None) -> Family:
    """A row as a family; the id of a fitted one comes when all of them are known."""
    signature, robot, known = row.signature, problem.robot, row.family
    pinned = tuple(
        Pin(robot.variables[joint].name, joint + 1, row.sets[i]) for i, joint in enumerate(signature.pinned)
    )
    coupled = tuple(j + 1 for j in signature.coupled)
    sound, points, _ = tested
    if len(points) or known is None:
        points = points
    else:
        points = np.array([known.witness])
    at = points[0] if shown is None else shown
    directions, lost = lost_motions(problem, at, points)
    if known is None:
        name = name_family(robot, problem.task, points, [pin.number for pin in pinned], coupled=coupled)
        exact = None
    else:
        name, exact = known.called, known.exact
    return Family(
        id="" if known is None else known.id,
        called=name,
        corank=problem.corank,
        dimension=robot.n - signature.rank,
        pinned=pinned,
        free=tuple(j + 1 for j in signature.free),
        coupled=coupled,
        equations=row.system.equations,
        witness=tuple(float(x) for x in at),
        lost_directions=directions,
        lost_freedoms=lost,
        evidence=row.evidence,
        soundness=sound,
        explained=explains,
        exact=exact,
    )


def _generic(
    problem: Problem, row: Row, members: Array, rng: np.random.Generator
) -> tuple[Array, int]:
    """Up to 24 points of a row of corank exactly k, in random order, and the smallest dimension of ker D there.

    The points are sampled, or of the cloud where that is hard.
    """
    points, good = row.sample(problem, 12, rng)
    if good.sum() < 12:
        q = np.concatenate([points[good], members[:24]])
    else:
        q = points[good]
    inspection = inspect(problem, q, signatures=False)
    exact = inspection.exact & (inspection.sigma[:, problem.rank] <= problem.tolerances.singular)
    chosen = np.flatnonzero(exact)
    dimension = np.trace(inspection.tangent[exact & inspection.regular], axis1=1, axis2=2)
    return np.asarray(q[rng.permutation(chosen)[:24]]), round(float(dimension.min(initial=problem.n)))


def _pieces(cover: Membership, rows: list[Row], inspection: Inspection) -> list[int]:
    """How many points of the cloud met each piece: a row with one combination of its values."""
    counts: list[int] = []
    left = inspection.exact.copy()
    for row in rows:
        members = np.flatnonzero(left & cover(row))
        left[members] = False
        labels, _ = row.nearest_values(inspection.q[members])
        counts += [int(c) for c in np.unique(labels, axis=0, return_counts=True)[1]]
    return counts


def _summary(cloud: Search, share: Check, higher: int, pieces: list[int], near_misses: bool) -> CorankSummary:
    return CorankSummary(
        corank=cloud.corank,
        rank=cloud.rank,
        starts=len(cloud.outcome) - cloud.count(Outcome.NOT_RUN),
        converged=cloud.count(Outcome.CONVERGED),
        near_misses=cloud.count(Outcome.NEAR_MISS),
        slow=cloud.count(Outcome.SLOW),
        smallest_near_miss=cloud.smallest_near_miss if near_misses else None,
        completeness=share,
        higher=higher,
        unseen=unseen(pieces) if cloud.count(Outcome.CONVERGED) else none_found(len(cloud.outcome)),
    )


def unexplained_families(
    problem: Problem, cloud: Inspection, left_cloud: Mask, fresh: Inspection, left_fresh: Mask
) -> list[tuple[Family, int]]:
    """Families without a name: the points of exactly this corank that are left, grouped by the shape of their tangent.

    Args:
        problem: the arm, and the corank.
        cloud, fresh: the two clouds.
        left_cloud, left_fresh: (N,) points that no row explains.

    Returns:
        The families, that of most points first, and how many points of the cloud each has. The dimension is n − rank D,
        an upper bound where the points are irregular; the witness is the point farthest from a higher corank.
    """
    q = np.concatenate([cloud.q[left_cloud & cloud.exact], fresh.q[left_fresh & fresh.exact]])
    from_cloud = int((left_cloud & cloud.exact).sum())
    if not len(q):
        return []
    inspection = inspect(problem, q)
    groups: dict[Shape, list[int]] = {}
    for i in range(len(q)):
        groups.setdefault(_shape(inspection, i, problem), []).append(i)
    ordered = sorted(_merge_small_groups(groups).items(), key=lambda item: (-len(item[1]), item[1][0]))
    tested = int(fresh.exact.sum())
    return [
        _unnamed_family(problem, inspection, key, np.array(members), from_cloud, tested) for key, members in ordered
    ]


def _merge_small_groups(groups: dict[Shape, list[int]]) -> dict[Shape, list[int]]:
    """Put groups with the same pinned joints together where one is small beside the other.

    Near a degenerate geometry (offsets of a fraction of a millimetre) tangents of one set come in many shapes. What is
    coupled in one of them is coupled; the larger dimension is the bound.
    """
    joined: dict[Shape, list[int]] = {}
    for shape, members in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        home = next((s for s in joined if s[2] == shape[2] and len(members) < SMALL * len(joined[s])), None)
        if home is None:
            joined[shape] = list(members)
            continue
        everyone = sorted(joined.pop(home) + members)
        coupled = tuple(sorted({*home[4], *shape[4]}))
        free = tuple(j for j in home[3] if j not in coupled)
        joined[(home[0] and shape[0], min(home[1], shape[1]), home[2], free, coupled)] = everyone
    return joined


def _shape(inspection: Inspection, i: int, problem: Problem) -> Shape:
    """Irregular points are told apart by the dimension of ker D alone; joints that never matter are free."""
    signature = inspection.signatures[i]
    if signature is not None:
        return (True, signature.rank, signature.pinned, signature.free, signature.coupled)
    idle = problem.idle.tolist()
    free, coupled = (tuple(j for j in range(problem.n) if idle[j] is still) for still in (True, False))
    return (False, problem.n - round(float(np.trace(inspection.tangent[i]))), (), free, coupled)


def _unnamed_family(
    problem: Problem,
    inspection: Inspection,
    key: Shape,
    members: NDArray[np.int64],
    from_cloud: int,
    tested: int,
) -> tuple[Family, int]:
    regular, rank, pinned, free, coupled = key
    q, cloud = inspection.q[members], int((members < from_cloud).sum())
    if problem.rank:
        gap = inspection.sigma[members, problem.rank - 1]
    else:
        gap = np.ones(len(members))
    at = q[int(np.argmax(gap))]
    directions, lost = lost_motions(problem, at, q)
    fresh = len(members) - cloud
    names = problem.robot.variables
    family = Family(
        id="",
        called=FamilyName(unnamed=True),
        corank=problem.corank,
        dimension=problem.n - rank,
        pinned=tuple(Pin(names[j].name, j + 1, _values(problem, q, j, float(at[j]))) for j in pinned),
        free=tuple(j + 1 for j in free),
        coupled=tuple(j + 1 for j in coupled),
        equations=(),
        witness=tuple(float(x) for x in at),
        lost_directions=directions,
        lost_freedoms=lost,
        evidence=FamilyEvidence(ObtainedFrom.CLOUD, cloud=cloud, fresh=fresh, clear_rank=regular),
        explained=Check(tested, fresh),
        named=False,
    )
    return family, cloud


def _values(problem: Problem, q: Array, joint: int, at_witness: float) -> tuple[float, ...]:
    """Different values of a joint over points, at most `VALUES`, that of the witness among them."""
    linear = Linear.of(problem.robot, [tuple(int(i == joint) for i in range(problem.n))])
    values = [values[0] for values in linear.combinations(q, np.ones(len(q)), 1e-5)]
    own = min(values, key=lambda value: _apart(value, at_witness, periodic=bool(linear.periodic[0])))
    others = [value for value in sorted(values) if value != own]
    if _apart(own, at_witness, periodic=bool(linear.periodic[0])) > problem.tolerances.value:
        own = at_witness  # points of one value, each close to the next, may spread wider than `value`
    return tuple(sorted([own, *others[: VALUES - 1]]))


def _apart(value: float, other: float, *, periodic: bool) -> float:
    """Distance of two values of a joint [rad or length units]."""
    if periodic:
        return abs(wrap_angle(value - other))
    return abs(value - other)
