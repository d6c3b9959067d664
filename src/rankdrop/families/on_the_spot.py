"""A family named without an atlas: from the singular configurations around one of its members.

1. Random steps of several sizes from q, along ker D and, where D may vanish, in all directions, are driven back to the
   singular set by the search. What comes back near q, with exactly the same corank, is the neighbourhood.
2. Where D has the same rank at q as around it, the set is smooth there and all of the neighbourhood is one family.
   Where the rank differs, families meet at q: each signature that is found next to q is one of them.
3. A family's signature says which joints are pinned (their values are those of q), free and coupled; its name comes
   from the geometry of the axes, as in an atlas.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.fit import FamilyPoints, fitted_equations, group_by_signature, linear_rows, smooth
from rankdrop.families.incidence import Incidence, families_at
from rankdrop.families.inspection import Inspection, Signature, inspect
from rankdrop.families.linear_conditions import Linear, Values, canonical
from rankdrop.families.name import FamilyName
from rankdrop.families.naming import name_family, shorten_names
from rankdrop.families.record import Family, LocalConditions, Pin
from rankdrop.families.rescaling import rescale_equation, rescaled_pin, slides_of
from rankdrop.families.row import Row
from rankdrop.families.searching import refine
from rankdrop.formula.equation import Equation
from rankdrop.kinematics import one_configuration
from rankdrop.local.block import generic_rank
from rankdrop.problem import Problem, wrap
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, metre_exponent, out_of_metres, task_in_metres

SIZES = (0.01, 0.05, 0.2, 0.6)  # steps from q [rad, length scales]
EACH = 24  # starts for each size
FEW = 3  # neighbours that make a family
CLOSE = 0.1  # so near the set is its tangent, within a tenth [rad, length scales]
BACK = 3.0  # what comes back farther away than so many steps is another place of the set
HELD = 1e-5  # a value of q and one of the neighbourhood that differ by less are the same [rad, length scales]
Found = list[tuple[Signature, NDArray[np.int64]]]

NAMED = 12  # points that a name is taken from
SPREAD = 800  # points that a fit is made from: one step after the other they get far from q
FIT_WORK = 2e7  # of one fit, in floating-point operations
FIT_JOINTS = 3  # equations of more coupled joints take seconds and belong into an atlas


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


def groups_through(problem: Problem, q: Array, at: Inspection, around: Inspection, seed: int) -> Found:
    """Signatures of the neighbourhood whose linear conditions hold at q, each with its points.

    Where the set is smooth at q there is one family: the signature most neighbours of that rank have. Else every
    signature that is met next to q is a family through it. Groups where ker D is not the tangent space tell nothing.
    """
    way = wrap(around.q - q) / problem.scale
    far = np.linalg.norm(way, axis=1)
    rng = np.random.default_rng([seed, 3])
    groups = []
    for signature, every in group_by_signature(replace(around, signatures=(None, *around.signatures[1:]))):
        members = _holding(problem, signature, q, around.q, every)
        if signature.rank and len(members) >= FEW and smooth(problem, around, members, rng) and (
            _neighbours_span_kernel(way[members], far[members], problem.n - signature.rank)
        ):
            groups.append((signature, members))
    ranks = sorted(signature.rank for signature in around.signatures[1:] if signature is not None)
    rank = conormal_rank(at)
    if ranks and rank == ranks[len(ranks) // 2]:
        return sorted((item for item in groups if item[0].rank == rank), key=lambda item: -len(item[1]))[:1]
    return [(signature, members) for signature, members in groups if far[members].min() <= BACK * SIZES[0]]


def _neighbours_span_kernel(ways: Array, lengths: Array, dimension: int) -> bool:
    """Whether neighbours lie in as many directions from q as ker D has.

    One direction too many in ker D, in which the condition is of second order, is met by none of them: they come back
    to within √σ of the set, a hundredth of their step. Too few neighbours decide nothing.
    """
    near = lengths <= CLOSE
    if near.sum() < dimension + 3:
        return True
    spread = np.linalg.svd(ways[near] / np.maximum(lengths[near, None], 1e-12), compute_uv=False)
    return int((spread > 0.05 * spread[0]).sum()) >= dimension


def _holding(
    problem: Problem, signature: Signature, q: Array, points: Array, members: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Those of the members at which the pinned joints and relations have the same values as at q."""
    linear = Linear.of(problem.robot, signature.covectors(len(q)))
    off = np.abs(linear.deviation(points[members], linear.values(q[None])))
    same = off.max(axis=1, initial=0.0) <= HELD * max(1.0, problem.task.scale(problem.robot))
    return np.asarray(members[same])


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
        >>> found.dimension, found.pinned[0].number, found.pinned[0].values
        (6, 4, (0.0,))
    """
    generic = generic_rank(robot, task)
    if not 1 <= corank <= generic:
        raise OptionError("there is no such corank", got=corank, allowed=f"1 … {generic}")
    here = into_metres(robot, one_configuration(robot, q))
    problem = Problem(in_metres(robot), task_in_metres(task, robot), corank, tolerances)
    at = inspect(problem, here[None])
    sigma = at.sigma[0, problem.rank :]
    if sigma[0] > max(tolerances.singular, 1e-6):
        raise ConfigurationError(
            "the configuration does not have this corank", got=f"σ = {sigma.tolist()}",
            mend="take the corank that configuration.at(…).corank gives",
        )  # fmt: skip
    spot = _Surroundings(robot, problem, here, neighbourhood(problem, here, at, seed), seed)
    groups = groups_through(problem, here, at, spot.around, seed)
    families = [spot.describe_family(signature, members, fit=fit) for signature, members in groups]
    families = families or spot.from_shared_values() or [spot.nameless(at)]
    if len(families) == 1:
        return families[0]
    return _meeting(families)


@dataclass(frozen=True, eq=False)
class _Surroundings:
    """A configuration (n,) of an arm, and the singular configurations around it; in metres, but for the arm as given.
    """

    robot: Robot
    problem: Problem
    q: Array
    around: Inspection
    seed: int

    def describe_family(self, signature: Signature, members: NDArray[np.int64], *, fit: bool) -> Family:
        """The family through q that some of its neighbours belong to; `fit` also finds short unknown equations."""
        problem, points = self.problem, self.around.q[members]
        linear = Linear.of(problem.robot, signature.covectors(problem.n))
        how = FamilyEvidence(ObtainedFrom.NEIGHBOURS, neighbours=len(members))
        row = Row(linear, tuple((value,) for value in _values(linear, points)), (), signature, how)
        if not signature.residual:
            return self.family(row, points, whole=True)
        few = len(set(signature.coupled) - set(linear.pivots)) <= FIT_JOINTS
        if fit and few:
            residual = self.fit_equations(row, members)
        else:
            residual = None
        return self.family(replace(row, residual=residual or ()), points, whole=residual is not None)

    def fit_equations(self, row: Row, members: NDArray[np.int64]) -> tuple[Equation, ...] | None:
        """Equations of the coupled joints, or None where a small budget does not find them."""
        rng = np.random.default_rng([self.seed, 1])
        source = FamilyPoints(self.problem, row, self.around.q[members], self.around.tangent[members], rng)
        source(SPREAD)
        order = rng.permutation(len(source.q))  # a fit takes the first ones: they have to be spread over the family
        source.q, source.tangent = source.q[order], source.tangent[order]
        return fitted_equations(source, FIT_WORK)

    def from_shared_values(self) -> list[Family]:
        """Families on which D vanishes more than it should: from values that the neighbourhood shares, verified by σ.
        """
        rng = np.random.default_rng([self.seed, 2])
        near = self.around.q[self.around.exact]
        families = []
        for row in linear_rows(self.problem, near, rng):
            labels, far = row.nearest_values(self.q[None])
            if far.max() <= 1e2 * HELD:
                values = [options[label] for options, label in zip(row.sets, labels[0].tolist(), strict=True)]
                # neighbours are known badly where σ is of higher order: take the values exactly
                points = row.linear.place(near, np.repeat(np.array([values]), len(near), axis=0), rng)
                points = points[inspect(self.problem, points).exact]
                families.append(self.family(replace(row, sets=tuple((value,) for value in values)), points, whole=True))
        return families

    def family(self, row: Row, points: Array, *, whole: bool) -> Family:
        """The family of a row through q; `whole`: the equations of its coupled joints are known."""
        power, slides, signature = metre_exponent(self.robot), slides_of(self.robot), row.signature
        residual = tuple(rescale_equation(equation, slides, power) for equation in row.residual)
        values = [value for (value,) in row.sets]
        pinned = self.pins(signature.pinned, values[: len(signature.pinned)])
        relations = tuple(zip(signature.relations, values[len(pinned) :], strict=True))
        local = LocalConditions(relations, residual, whole or not signature.coupled)
        if whole:
            equations = tuple(rescale_equation(equation, slides, power) for equation in row.system.equations)
        else:
            equations = ()
        return self.record(signature, pinned, row.evidence, local, points, equations)

    def nameless(self, at: Inspection) -> Family:
        """q alone: an isolated singular configuration, or a place that neither tangents nor values explain."""
        joints, idle, rank = tuple(range(self.problem.n)), self.problem.idle.tolist(), conormal_rank(at)
        if rank == self.problem.n:
            pinned, how = self.pins(joints, self.q.tolist()), FamilyEvidence(ObtainedFrom.FULL_RANK)
            local = LocalConditions(isolated=True)
            return self.record(Signature(rank, joints, (), ()), pinned, how, local, self.q[None])
        how = FamilyEvidence(ObtainedFrom.UNCLEAR_RANK, clear_rank=False)
        free, coupled = (tuple(j for j in joints if idle[j] is still) for still in (True, False))
        return self.record(Signature(rank, (), free, coupled), (), how, LocalConditions(), self.q[None], named=False)

    def pins(self, joints: Sequence[int], values: Sequence[float]) -> tuple[Pin, ...]:
        """Joints (from 0) at values in metres, as those of the arm as given."""
        power, slides, names = metre_exponent(self.robot), slides_of(self.robot), self.robot.variables
        pairs = zip(joints, values, strict=True)
        return tuple(rescaled_pin(Pin(names[j].name, j + 1, (value,)), slides, power) for j, value in pairs)

    def record(
        self, signature: Signature, pinned: tuple[Pin, ...], how: FamilyEvidence, local: LocalConditions, points: Array,
        equations: tuple[Equation, ...] = (), *, named: bool = True,
    ) -> Family:  # fmt: skip
        """The record of a family through q; its name is taken from points (N, n) of it."""
        problem, spread = self.problem, points[:: max(1, len(points) // NAMED)][:NAMED]
        coupled = tuple(j + 1 for j in signature.coupled)
        known = coupled if named else None
        name = name_family(problem.robot, problem.task, spread, [pin.number for pin in pinned], coupled=known)
        return Family(
            id="",
            called=shorten_names([name])[0],
            named=named,
            corank=problem.corank,
            dimension=problem.n - signature.rank,
            pinned=pinned,
            free=tuple(j + 1 for j in signature.free),
            coupled=coupled,
            equations=equations,
            witness=tuple(out_of_metres(self.robot, self.q).tolist()),
            lost_directions=np.zeros((0, 6)),  # whoever asks for the family of a configuration has them already
            lost_freedoms=(),
            evidence=how,
            local=local,
            slides=tuple(i + 1 for i in slides_of(self.robot)),
        )


def families_through(
    robot: Robot,
    q: Array,
    task: Task,
    corank: int,
    families: Sequence[Family],
    *,
    source: str,
    seed: int,
    tolerances: Tolerances = DEFAULT,
) -> tuple[Incidence, ...]:
    """The families that a singular configuration lies on; named on the spot where none of its corank is known.

    Args:
        robot, q, task, corank, seed: as for `name_on_the_spot`.
        families: known families of the arm, of all coranks.
        source: of these, as `Incidence.source` says it.
        tolerances: decide which known families hold.
    """
    incidences = families_at(families, robot, q, task, tolerances, source)
    if incidences and incidences[0].family.corank >= corank:
        return incidences
    local = name_on_the_spot(robot, q, task, corank, seed=seed)
    return (Incidence(local, 0.0, "on the spot"), *incidences)


def _values(linear: Linear, points: Array) -> Values:
    """The values that covectors take on points, simple ones exact."""
    middle = points[len(points) // 2] @ linear.covectors.T
    mean = middle + np.median(linear.deviation(points, middle), axis=0)
    pairs = zip(mean.tolist(), linear.periodic.tolist(), strict=True)
    return tuple(canonical(value) if turns else value + 0.0 for value, turns in pairs)


def _meeting(families: list[Family]) -> Family:
    """Several families meet at q: the largest one first."""
    name = FamilyName(meeting=tuple(dict.fromkeys(family.called for family in families)))
    how = FamilyEvidence(ObtainedFrom.MEETING, parts=tuple(family.evidence for family in families))
    return replace(families[0], called=name, equations=(), evidence=how, local=None, parts=tuple(families))
