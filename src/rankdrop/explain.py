"""One verb for one configuration: is it singular, which singularity, what is lost, who is to blame, how to get out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop._handles import check_robot
from rankdrop.atlas.distance import FamilyDistance, agreement, family_distances
from rankdrop.atlas.family import Family
from rankdrop.atlas.on_the_spot import name_on_the_spot
from rankdrop.atlas.search import Outcome, refine
from rankdrop.atlas.which import Met, families_at
from rankdrop.certify.ball import LARGEST, Certificate, certified_radius
from rankdrop.errors import OptionError
from rankdrop.explanation import Explanation
from rankdrop.explanation_data import Blame, ExplainSettings, Far, Lost
from rankdrop.explanation_words import angle, angle_below, short
from rankdrop.known import known_analysis
from rankdrop.local.block import decompose
from rankdrop.local.circuits import LARGEST_CHAIN, circuits_at, make_all
from rankdrop.local.directions import lost_directions, lost_in_sparsest_frame
from rankdrop.local.ellipsoids import ellipsoids
from rankdrop.local.escape import JointEscape, escape
from rankdrop.local.nearest import Nearest, nearest_singularity
from rankdrop.local.ordered import ordered_subsets
from rankdrop.local.rates import joint_rates
from rankdrop.local.readable import readable_basis
from rankdrop.local.redundancy import redundancy
from rankdrop.local.relations import relations_at
from rankdrop.local.representation import representation_at
from rankdrop.local.screws import screw_of
from rankdrop.local.systems import always_singular_reason, systems_at
from rankdrop.local.verdict import Rank, one_configuration, rank_at
from rankdrop.local.words import blocked_words, words
from rankdrop.result import Analysis
from rankdrop.robot.fingerprint import geometry
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.version import VERSION

NEAR = 0.05
"""A configuration is near a singularity within this distance in joint space [rad]: 2.9°."""
SMALL = 1e-3
"""… or where σ_r is below this [1]: unit end-effector speed then needs joint rates of a thousand times the usual."""

LARGEST_TOLERANCE = 1e-3
"""A singular value above this is not zero by any measure of rounding [1]."""


def explain(
    robot: Robot,
    q: ArrayLike,
    task: str | Task | None = None,
    *,
    analysis: Analysis | None = None,
    near: float = NEAR,
    small: float = SMALL,
    limits: bool = False,
    evaluations: int = 5_000,
    step: float = 0.1,
    coranks: int = 1,
    seed: int = 0,
    length_scale: float | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Explanation:
    """Explain one configuration: at, near, or far from a singularity.

    Verdicts: *singular*, the rank is below the generic one (σ_r ≤ `tolerances.singular`); *near*, a singular
    configuration was found within `near`, or σ_r ≤ `small` (a near miss, where none was found); *always-singular*, the
    arm is deficient for the task at every configuration and not more so here; else *regular*.

    Families come from `analysis`, else from the atlas shipped with the package where the arm is in it, else they are
    found on the spot from points around q.

    Args:
        robot: the arm.
        q: (n,) the configuration [rad, m].
        task: name, rows or Task; None is the task the arm is made for.
        analysis: families of this arm and task, from `analyze`.
        near: distance in joint space [rad; slides divided by the length scale].
        small: σ_r that counts as small [1].
        limits: the nearest singularity within the joint limits.
        evaluations: budget of the certified radius (`certified_radius`).
        step: length of the motions out that are tried [rad; slides in length scales].
        coranks: distances to known families up to this corank; every one of them lies in those of corank 1.
        seed: of every random choice.
        length_scale: translation rows are divided by it [m]; None is that of the task, else the arm's reach.
        tolerances: thresholds, recorded in the result.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: a threshold outside what is allowed, or an analysis of another arm or task.
        TaskError: the task does not exist.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = explain(open_robot("puma560"), [0.3, 0.5, 0.4, 0.2, 0.0, 0.6])
        >>> found.verdict, found.met[0].family.name, [one.number for one in found.escape.single if one.order]
        ('singular', 'wrist: axes 4 and 6 aligned', [5])
    """
    check_robot(robot)
    configuration = one_configuration(robot, q)
    configuration.flags.writeable = False
    _check_numbers(near=near, small=small, step=step)
    _check_whole(evaluations=evaluations, seed=seed, coranks=coranks)
    if not 0.0 < tolerances.singular <= LARGEST_TOLERANCE:
        raise OptionError(
            "this is no tolerance for singular values", where="tolerance", got=tolerances.singular,
            allowed=f"above 0, up to {LARGEST_TOLERANCE:g}", mend="to be told of small ones, raise `near` or `small`",
        )  # fmt: skip
    resolved = resolve_task(task, robot, length_scale=length_scale)
    resolved = replace(resolved, length_scale=resolved.scale(robot))
    families, source = _families(robot, resolved, analysis, tolerances)
    targets = tuple(one for one in families if one.corank <= coranks)
    rank = rank_at(robot, configuration, resolved, tolerances)
    far = _far(robot, configuration, resolved, rank, targets, source, limits, small, evaluations, seed, tolerances)
    verdict, reason = _verdict(rank, far, near, small)
    at_hand = far.nearest if verdict == "near" and far.near_miss is None else None
    focus = configuration if at_hand is None else np.array(at_hand.q)
    corank = rank.corank if at_hand is None else at_hand.corank
    met = _met(robot, focus, resolved, corank, families, source, seed, tolerances) if corank else ()
    way_out = escape(robot, configuration, resolved, tolerances=tolerances, seed=seed, step=step)
    return Explanation(
        robot=robot,
        task=resolved,
        q=configuration,
        settings=ExplainSettings(
            near, small, limits, evaluations, step, seed, float(resolved.scale(robot)), tolerances, VERSION
        ),
        verdict=verdict,
        reason=reason,
        rank=rank,
        focus=focus,
        met=met,
        source=source,
        relations=relations_at(robot, focus),
        lost=_lost(robot, configuration, focus, resolved, rank, corank or (1 if far.near_miss is not None else 0)),
        blame=_blame(robot, focus, resolved, corank, rank.generic_rank),
        escape=way_out,
        rates=joint_rates(robot, configuration, resolved),
        far=far,
        ellipsoids=ellipsoids(robot, configuration, resolved),
        redundancy=redundancy(robot, configuration, resolved),
        representations=representation_at(robot, configuration, tolerances=tolerances),
        disagreements=tuple(_disagreements(far, way_out.single)),
    )


def _check_numbers(**options: float) -> None:
    """Raises OptionError for what is no number from 0 up."""
    for name, value in options.items():
        if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not 0.0 <= value < np.inf:
            raise OptionError("this is a finite number from 0 up", where=name, got=repr(value))


def _check_whole(**options: int) -> None:
    """Raises OptionError for what is no whole number from 0 up."""
    for name, value in options.items():
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 0 <= value < 2**63:
            raise OptionError("this is a whole number from 0 up", where=name, got=repr(value))


def _families(
    robot: Robot, task: Task, analysis: Analysis | None, tolerances: Tolerances
) -> tuple[tuple[Family, ...], str]:
    """Known families and where they come from.

    Raises:
        OptionError: the analysis is about another arm or other rows.
    """
    if analysis is None:
        known = known_analysis(robot, task)
        return (known.families, "catalogue") if known else ((), "on the spot")
    mine, other = geometry(robot), geometry(analysis.robot)
    if mine.shape != other.shape or np.abs(mine - other).max() > tolerances.value:
        raise OptionError("the analysis is about another arm", got=analysis.robot.name, allowed=robot.name)
    if analysis.task.rows != task.rows or analysis.task.frame != task.frame:
        raise OptionError("the analysis is about another task", got=analysis.task.name, allowed=task.name)
    return analysis.families, "analysis"


def _far(
    robot: Robot, q: Array, task: Task, rank: Rank, families: Sequence[Family], source: str, limits: bool, small: float,
    evaluations: int, seed: int, tolerances: Tolerances,
) -> Far:  # fmt: skip
    away = tuple(
        one for one in family_distances(families, robot, q, task, limits=limits, seed=seed)
        if np.isfinite(one.distance) and (one.distance > tolerances.explained or not rank.corank)
    )  # fmt: skip
    if rank.corank:
        return Far(None, None, away, None, "the configuration is singular")
    if rank.generic_rank == 0:
        return Far(None, None, away, None, "the arm moves nothing")
    nearest = nearest_singularity(
        robot, q, task, limits=limits, seed=seed, seeds=tuple(one.q for one in away[:8]), tolerances=tolerances
    )
    certificate, reason = _certificate(robot, q, task, nearest, limits, evaluations)
    sigma = float(rank.sigma[rank.generic_rank - 1])
    miss = _near_miss(robot, q, task, seed, tolerances) if sigma <= small else None
    if nearest is None:
        return Far(None, None, away, certificate, reason, miss)
    there = _met(robot, np.array(nearest.q), task, nearest.corank, families, source, seed, tolerances)
    closer = [_no_farther(one, nearest, there) for one in away]
    closer.sort(key=lambda one: one.distance)
    return Far(nearest, there[0], tuple(closer), certificate, reason, miss)


def _no_farther(record: FamilyDistance, nearest: Nearest, there: Sequence[Met]) -> FamilyDistance:
    """A family through the point that the search found is no farther away than that point."""
    through = any(met.family is record.family for met in there)
    if not through or record.distance <= nearest.distance:
        return record
    return replace(record, distance=nearest.distance, q=nearest.q, delta=nearest.delta, sigma=nearest.sigma)


def _certificate(
    robot: Robot, q: Array, task: Task, nearest: Nearest | None, limits: bool, evaluations: int
) -> tuple[Certificate | None, str]:
    """Within the limits the nearest singularity may lie farther than one outside them, and bounds nothing."""
    at_most = LARGEST if nearest is None or limits else min(LARGEST, nearest.distance * (1 + 1e-9))
    try:
        return certified_radius(robot, q, task, at_most=at_most, evaluations=evaluations), ""
    except OptionError as error:
        if error.got == evaluations:  # no budget; else a task that cannot be certified
            raise
        return None, error.what


def _near_miss(robot: Robot, q: Array, task: Task, seed: int, tolerances: Tolerances) -> float | None:
    """σ_r at the nonzero local minimum that a descent from q ends in; None where it ends in a singularity."""
    found = refine(robot, q[None, :], 1, task=task, seed=seed, tolerances=tolerances, threads=1)
    return found.smallest_near_miss if found.outcome[0] == Outcome.NEAR_MISS else None


def _verdict(rank: Rank, far: Far, near: float, small: float) -> tuple[str, str]:
    r = rank.generic_rank
    sigma = float(rank.sigma[r - 1]) if r else 0.0
    lost = f"rank {rank.rank} of {r}"
    if rank.corank:
        times = "task freedom is" if rank.corank == 1 else "task freedoms are"
        return "singular", f"{lost}: {rank.corank} {times} lost{_nearly(rank, small)}"
    if rank.always_singular:
        return "always-singular", f"rank {r} here and at almost every configuration: the arm never does more"
    if far.near_miss is not None:
        least = f"σ{r} = {short(sigma, 3)} is small, but a descent from here ends at σ{r} = {short(far.near_miss, 3)}"
        return "near", f"{lost}; near miss: {least}, not at zero"
    if far.nearest is not None and far.nearest.distance <= near:
        there = f"a singular configuration is {angle(far.nearest.distance)} away"
        return "near", f"{lost}, but {there}{_several(rank, small)}"
    if sigma <= small:
        return "near", f"{lost}, but σ{r} = {short(sigma, 3)} is at most {short(small)}"
    if far.nearest is None:
        proven = f"none lies within {angle_below(far.certificate.radius)}" if far.certificate else "that is no proof"
        return "regular", f"{lost}; no singular configuration was found, and {proven}"
    return "regular", f"{lost}; the nearest singular configuration found is {angle(far.nearest.distance)} away"


def _several(rank: Rank, small: float) -> str:
    """Where more is small than what vanishes nearby: an arm without its offsets would lose it all."""
    count = int((rank.sigma[: rank.rank] <= small).sum())
    first = rank.rank - count
    return f"; {count} task freedoms are nearly lost, σ{first + 1} = {short(rank.sigma[first], 3)}" if count > 1 else ""


def _nearly(rank: Rank, small: float) -> str:
    """What is small beside what is zero: Gen3's offsets of 12 mm keep σ above zero where it would vanish without."""
    kept = rank.sigma[: rank.rank]
    return f", and σ{rank.rank} = {short(kept[-1], 3)} is nearly zero" if len(kept) and kept[-1] <= small else ""


def _met(
    robot: Robot, q: Array, task: Task, corank: int, families: Sequence[Family], source: str, seed: int,
    tolerances: Tolerances,
) -> tuple[Met, ...]:  # fmt: skip
    found = families_at(families, robot, q, task, tolerances, source)
    if found and found[0].family.corank >= corank:
        return found
    local = name_on_the_spot(robot, q, task, corank, seed=seed)
    return (Met(local, 0.0, "on the spot"), *found)


def _lost(robot: Robot, q: Array, focus: Array, task: Task, rank: Rank, corank: int) -> Lost:
    never = _never(robot, q, task, rank)
    empty = np.zeros((0, 6))
    weakest = lost_directions(robot, q, task, 1)[0] if rank.generic_rank else np.zeros(6)
    if not corank:
        return Lost(empty, weakest, (), (), None, (), (), never)
    framed = lost_in_sparsest_frame(robot, focus, task, corank)
    return Lost(
        directions=lost_directions(robot, focus, task, corank),
        weakest=weakest,
        words=tuple(words(one, framed.name) for one in framed.directions),
        blocked_words=tuple(blocked_words(one, framed.name) for one in framed.directions),
        framed=framed,
        twist_screws=tuple(screw_of(one) for one in framed.directions),
        wrench_screws=tuple(screw_of(np.roll(one, 3)) for one in framed.directions),
        never=never,
    )


def _never(robot: Robot, q: Array, task: Task, rank: Rank) -> Array:
    """Readable basis of what is beyond the generic rank: the arm makes it nowhere near q."""
    beyond = task.m - rank.generic_rank
    if beyond == 0:
        return np.zeros((0, 6))
    away = q + np.random.default_rng(0).uniform(-1e-3, 1e-3, robot.n) if rank.corank else q
    rows = np.zeros((beyond, 6))
    rows[:, list(task.rows)] = decompose(robot, away, task).u[:, rank.generic_rank :].T
    rows[:, :3] /= task.scale(robot)
    return readable_basis(rows.T).T


def _blame(robot: Robot, q: Array, task: Task, corank: int, generic_rank: int) -> Blame:
    few = robot.n <= LARGEST_CHAIN
    circuits = circuits_at(robot, q, task) if few else ()
    return Blame(
        circuits=circuits,
        smallest=make_all(circuits, robot.n, robot.n - generic_rank + corank) if corank else (),
        ordered=ordered_subsets(robot, q, task),
        systems=systems_at(robot, q),
        always=always_singular_reason(robot, task),
        complete=few,
    )


def _disagreements(far: Far, single: Sequence[JointEscape]) -> Iterator[str]:
    """Two methods, two answers."""
    for one in single:
        if not one.agrees:
            yield (
                f"joint {one.number} alone: a rank gain of {one.gain} was predicted, finite motion gains "
                f"{one.measured_gain}"
            )
    nearest, certificate = far.nearest, far.certificate
    if nearest is not None and certificate is not None and certificate.radius > nearest.distance * (1 + 1e-8):
        yield f"certified radius {certificate.radius:.6g} beyond a singularity at {nearest.distance:.6g}"
    if nearest is not None and far.families and all(one.family.named for one in far.families):
        same = agreement(far.families, nearest)
        if not same.agree:
            yield same.words
