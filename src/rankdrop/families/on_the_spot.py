"""A family named without an atlas: from the singular configurations around one of its members.

1. Random steps of several sizes from q, along ker D and, where D may vanish, in all directions, are driven back to the
   singular set by the search. What comes back near q, with exactly the same corank, is the neighbourhood.
2. Where D has the same rank at q as around it, the set is smooth there and all of the neighbourhood is one family.
   Where the rank differs, families meet at q: each signature that is found next to q is one of them.
3. A family's signature says which joints are pinned (their values are those of q), free and coupled; its name comes
   from the geometry of the axes, as in an atlas.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.families.fit import Budget
from rankdrop.families.linear import FamilyPoints, Linear, Values, canonical, smooth
from rankdrop.families.residual import circuit_equations
from rankdrop.families.row import Row
from rankdrop.families.rows import recognised
from rankdrop.families.searching import refine
from rankdrop.families.signature import Inspection, Signature, inspect
from rankdrop.family.equation import Equation
from rankdrop.family.naming import name_family, shortened
from rankdrop.family.record import Condition, Family, Local, Pin, Relation, condition_words, family_from_metres
from rankdrop.kinematics import one_configuration
from rankdrop.local.block import generic_rank
from rankdrop.problem import Problem, wrap
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, metre_exponent, task_in_metres

SIZES = (0.01, 0.05, 0.2, 0.6)  # steps from q [rad, length scales]
EACH = 24  # starts for each size
FEW = 3  # neighbours that make a family
CLOSE = 0.1  # so near the set is its tangent, within a tenth [rad, length scales]
BACK = 3.0  # what comes back farther away than so many steps is another place of the set
HELD = 1e-5  # a value of q and one of the neighbourhood that differ by less are the same [rad, length scales]
Found = list[tuple[Signature, NDArray[np.int64]]]


def neighbourhood(problem: Problem, q: Array, at: Inspection, seed: int) -> Inspection:
    """Singular configurations of exactly this corank around q; the first one is q itself, polished."""
    rng = np.random.default_rng(seed)
    scale = problem.scale
    sizes = np.repeat(SIZES, EACH)
    steps = rng.standard_normal((len(sizes), len(q)))
    tangential = np.arange(len(sizes)) % 2 == 0
    steps[tangential] = steps[tangential] @ at.tangent[0]
    steps *= scale * sizes[:, None] / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-12)
    starts = np.vstack([q, q + steps])
    back = refine(
        problem.robot, starts, problem.corank, task=problem.task, seed=seed, iterations=40, threads=1,
        tolerances=replace(problem.tolerances, target=1e-15),
    )  # fmt: skip
    way = np.where(problem.robot.periodic, wrap(back.q - q), back.q - q)
    near = np.linalg.norm(way / scale, axis=1) <= BACK * np.append(SIZES[0], sizes)
    good = near & (back.sigma[:, problem.rank] <= problem.tolerances.singular)
    good[0] = True
    return inspect(problem, q + way[good])


def conormal_rank(at: Inspection) -> int:
    """Rank of D at the first point: the dimension of the conormal space."""
    return int(at.q.shape[1]) - round(float(np.trace(at.tangent[0])))


def _usual_rank(around: Inspection) -> int:
    ranks = sorted(signature.rank for signature in around.signatures[1:] if signature is not None)
    return ranks[len(ranks) // 2] if ranks else -1


def groups_through(problem: Problem, q: Array, at: Inspection, around: Inspection, seed: int) -> Found:
    """Signatures of the neighbourhood whose linear conditions hold at q, each with its points.

    Where the set is smooth at q there is one family: the signature most neighbours of that rank have. Else every
    signature that is met next to q is a family through it. Groups where ker D is not the tangent space tell nothing.
    """
    groups: dict[Signature, list[int]] = {}
    for i, signature in enumerate(around.signatures):
        if i and signature is not None and signature.rank:
            groups.setdefault(replace(signature, bound=()), []).append(i)
    groups = {signature: _holding(problem, signature, q, around.q, members) for signature, members in groups.items()}
    scale = problem.scale
    far = np.linalg.norm(wrap(around.q - q) / scale, axis=1)
    rng = np.random.default_rng([seed, 3])
    ordered = [
        (signature, np.array(members))
        for signature, members in sorted(groups.items(), key=lambda item: (item[0].rank, -len(item[1]), item[0]))
        if len(members) >= FEW
        and smooth(problem, around, np.array(members), rng)
        and _filled(wrap(around.q[members] - q) / scale, far[members], len(q) - signature.rank)
    ]
    rank = conormal_rank(at)
    if rank == _usual_rank(around):
        alike = [item for item in ordered if item[0].rank == rank]
        return [max(alike, key=lambda item: len(item[1]))] if alike else []
    return [(signature, members) for signature, members in ordered if far[members].min() <= BACK * SIZES[0]]


def _filled(ways: Array, lengths: Array, dimension: int) -> bool:
    """Whether neighbours lie in as many directions from q as ker D has.

    One direction too many in ker D, in which the condition is of second order, is met by none of them: they come back
    to within √σ of the set, a hundredth of their step. Too few neighbours decide nothing.
    """
    near = lengths <= CLOSE
    if near.sum() < dimension + 3:
        return True
    spread = np.linalg.svd(ways[near] / np.maximum(lengths[near, None], 1e-12), compute_uv=False)
    return int((spread > 0.05 * spread[0]).sum()) >= dimension


def _holding(problem: Problem, signature: Signature, q: Array, points: Array, members: list[int]) -> list[int]:
    """Those of the members at which the pinned joints and relations have the same values as at q."""
    linear = Linear.of(problem.robot, signature.covectors(len(q)))
    off = linear.values(points[members]) - linear.values(q[None])
    off = np.where(linear.periodic, wrap(off), off)
    same = np.abs(off).max(axis=1, initial=0.0) <= HELD * max(1.0, problem.task.scale(problem.robot))
    return [members[i] for i in np.flatnonzero(same)]


NOT_TOLD = np.zeros((0, 6))  # lost directions: whoever asks for the family of a configuration has them already
NAMED = 12  # points that a name is taken from
SPREAD = 800  # points that a fit is made from: one step after the other they get far from q
FIT_WORK = 2e7  # of one fit, in floating-point operations
FIT_JOINTS = 3  # equations of more coupled joints take seconds and belong into an atlas


def name_on_the_spot(
    robot: Robot,
    q: ArrayLike,
    task: Task,
    corank: int,
    seed: int = 0,
    *,
    fit: bool = False,
    tolerances: Tolerances = DEFAULT,
) -> Family:
    """The family of corank k that a singular configuration lies on, without an atlas.

    Only the neighbourhood of q is looked at: other values of the pinned joints, which a row of an atlas lists, are not.
    Families that are met by too few neighbours are not found; not finding is no proof.

    Args:
        robot: the arm.
        q: (n,) a configuration of corank k [rad, m].
        task: from `resolve_task`.
        corank: k, that of `configuration.at`.
        seed: of the random steps.
        fit: also fit the equations of up to three coupled joints, with a small budget: some 0.1 s.
        tolerances: thresholds.

    Raises:
        ConfigurationError: q is not one configuration of this arm, or does not have this corank.
        OptionError: k is not in 1 … generic rank.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> found = name_on_the_spot(arm, [0.3, 0.4, 0.5, 0.0, 0.2, 0.4, 1.0], resolve_task(None, arm), 1)
        >>> found.dimension, found.words
        (6, ('θ4 = 0',))
    """
    configuration = one_configuration(robot, q)
    if metre_exponent(robot):
        there = name_on_the_spot(
            in_metres(robot),
            into_metres(robot, configuration),
            task_in_metres(task, robot),
            corank,
            seed,
            fit=fit,
            tolerances=tolerances,
        )
        return family_from_metres(there, robot, metre_exponent(robot))
    generic = generic_rank(robot, task)
    if not 1 <= corank <= generic:
        raise OptionError("there is no such corank", got=corank, allowed=f"1 … {generic}")
    problem = Problem(robot, task, corank, tolerances)
    rank = problem.rank
    at = inspect(problem, configuration[None])
    if at.sigma[0, rank] > max(tolerances.singular, 1e-6):
        raise ConfigurationError(
            "the configuration does not have this corank", got=f"σ = {at.sigma[0, rank:].tolist()}",
            mend="take the corank that configuration.at(…).corank gives",
        )  # fmt: skip
    around = neighbourhood(problem, configuration, at, seed)
    found = groups_through(problem, configuration, at, around, seed)
    families = [
        _described(problem, configuration, around, signature, members, seed, fit=fit) for signature, members in found
    ]
    if not families:
        families = _from_shared_values(problem, configuration, around, seed)
    if not families:
        return _nameless(problem, configuration, at, around)
    return families[0] if len(families) == 1 else _meeting(families)


def _described(
    problem: Problem,
    q: Array,
    around: Inspection,
    signature: Signature,
    members: NDArray[np.int64],
    seed: int,
    *,
    fit: bool,
) -> Family:
    linear = Linear.of(problem.robot, signature.covectors(problem.n))
    values = _values(linear, around.q[members])
    rest: tuple[Equation, ...] | None = None if signature.residual else ()
    if fit and signature.residual:
        rest = _fitted(problem, around, linear, values, members, seed)
    how = f"{len(members)} singular configurations around q with one tangent shape"
    row = Row(linear, tuple((value,) for value in values), rest or (), signature, how)
    return _family(problem, q, around.q[members], row, whole=rest is not None)


def _family(problem: Problem, q: Array, points: Array, row: Row, *, whole: bool) -> Family:
    """The record of one family through q; `points` are of it, and its name is taken from them.

    `whole`: the equations of its coupled joints are known.
    """
    robot, joints, signature = problem.robot, problem.robot.variables, row.signature
    values = [value for (value,) in row.sets]
    pinned = tuple(Pin(joints[j].name, j + 1, (value,)) for j, value in zip(signature.pinned, values, strict=False))
    coupled = tuple(j + 1 for j in signature.coupled)
    relations = map(Relation, signature.relations, values[len(pinned) :])
    conditions: tuple[Condition, ...] = (*pinned, *relations, *row.residual)
    spread = points[:: max(1, len(points) // NAMED)][:NAMED]
    words = condition_words(robot, conditions, () if whole else coupled)
    name = name_family(robot, problem.task, spread, [one.number for one in pinned], coupled=coupled)
    return Family(
        id="",
        name=shortened([name])[0],
        corank=problem.corank,
        dimension=robot.n - signature.rank,
        pinned=pinned,
        free=tuple(j + 1 for j in signature.free),
        coupled=coupled,
        equations=row.system.equations if whole else (),
        witness=tuple(q.tolist()),
        lost_directions=NOT_TOLD,
        lost_words=(),
        evidence=Local(row.evidence, conditions, words, len(points)),
    )


def _values(linear: Linear, points: Array) -> Values:
    """The values that covectors take on points, simple ones exact."""
    raw = linear.values(points)
    middle = raw[len(raw) // 2]
    off = raw - middle
    mean = middle + np.median(np.where(linear.periodic, wrap(off), off), axis=0)
    pairs = zip(mean.tolist(), linear.periodic.tolist(), strict=True)
    return tuple(canonical(value) if turns else value + 0.0 for value, turns in pairs)


def _fitted(
    problem: Problem,
    around: Inspection,
    linear: Linear,
    values: Values,
    members: NDArray[np.int64],
    seed: int,
) -> tuple[Equation, ...] | None:
    """Equations of the coupled joints, or None where they are long or a small budget does not find them."""
    rng = np.random.default_rng([seed, 1])
    met = [signature for i in members if (signature := around.signatures[i]) is not None]
    signature = max(met, key=met.count)  # the sets of joints bound together included
    source = FamilyPoints(problem, signature, linear, values, around.q[members], around.tangent[members], rng)
    if len(set(signature.coupled) - set(linear.pivots)) > FIT_JOINTS:
        return None
    source(SPREAD)
    order = rng.permutation(len(source.q))  # a fit takes the first ones, and they have to be spread over the family
    source.q, source.tangent = source.q[order], source.tangent[order]
    return circuit_equations(source, Budget(FIT_WORK))


def _from_shared_values(problem: Problem, q: Array, around: Inspection, seed: int) -> list[Family]:
    """Families on which D vanishes more than it should: from values that the neighbourhood shares, verified by σ."""
    rng = np.random.default_rng([seed, 2])
    near = around.q[around.exact]
    found = []
    for row in recognised(problem, near, rng):
        values = _row_values(row, q)
        if values is None:
            continue
        # neighbours are known badly where σ is of higher order: take the values exactly
        points = row.linear.place(near.copy(), np.repeat(np.array([values]), len(near), axis=0), rng)
        points = points[inspect(problem, points).exact]
        found.append(_family(problem, q, points, replace(row, sets=tuple((value,) for value in values)), whole=True))
    return found


def _row_values(row: Row, q: Array) -> Values | None:
    """The combination of a row's values that q takes; None where it takes none."""
    mine = row.linear.values(q[None])[0]
    chosen = []
    for value, options, turns in zip(mine, row.sets, row.linear.periodic, strict=True):
        off = np.array(options) - value
        off = np.abs(wrap(off) if turns else off)
        if off.min() > 1e2 * HELD:
            return None
        chosen.append(options[int(off.argmin())])
    return tuple(chosen)


def _nameless(problem: Problem, q: Array, at: Inspection, around: Inspection) -> Family:
    """q alone: an isolated singular configuration, or a place that neither tangents nor values explain."""
    robot = problem.robot
    isolated = conormal_rank(at) == robot.n
    everyone = tuple(range(1, robot.n + 1))
    pinned = tuple(Pin(joint.name, i + 1, (float(q[i]),)) for i, joint in enumerate(robot.variables))
    words = "an isolated singular configuration" if isolated else "no condition found around it"
    how = "D has full rank" if isolated else "D has no clear rank here; the dimension is an upper bound"
    name = name_family(robot, problem.task, q[None], everyone if isolated else (), coupled=() if isolated else None)
    return Family(
        id="",
        name=shortened([name])[0],
        named=isolated,
        corank=problem.corank,
        dimension=round(float(np.trace(at.tangent[0]))),
        pinned=pinned if isolated else (),
        free=() if isolated else tuple(int(j) + 1 for j in np.flatnonzero(problem.idle)),
        coupled=() if isolated else tuple(j for j in everyone if not problem.idle[j - 1]),
        equations=(),
        witness=tuple(q.tolist()),
        lost_directions=NOT_TOLD,
        lost_words=(),
        evidence=Local(how, (), (words,), len(around.q)),
    )


def _meeting(families: list[Family]) -> Family:
    """Several families meet at q: the largest one first."""
    names = "; ".join(dict.fromkeys(family.name for family in families))
    how = "; ".join(family.evidence.how for family in families)
    points = sum(family.evidence.points for family in families if isinstance(family.evidence, Local))
    words = tuple(" and ".join(family.words) for family in families)
    evidence = Local(how, (), words, points, tuple(families))
    return replace(families[0], name=f"meeting point of families: {names}", equations=(), evidence=evidence)
