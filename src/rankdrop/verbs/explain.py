"""One verb for one configuration: is it singular, which singularity, what is lost, who is to blame, how to get out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop._handles import check_robot, one_configuration
from rankdrop.errors import OptionError
from rankdrop.families.distance import agreement
from rankdrop.local.circuits import LARGEST_CHAIN, circuits_at, make_all
from rankdrop.local.cofactors import hunt
from rankdrop.local.ellipsoids import ellipsoids
from rankdrop.local.failures import failures_at
from rankdrop.local.ordered import ordered_subsets
from rankdrop.local.rates import joint_rates
from rankdrop.local.redundant import redundancy
from rankdrop.local.relations import relations_at
from rankdrop.local.representation import representation_at
from rankdrop.local.systems import always_singular_reason, systems_at
from rankdrop.local.verdict import rank_at
from rankdrop.local.ways_out import JointEscape, escape
from rankdrop.results.analysis import Analysis
from rankdrop.results.explanation.data import Asked, Blame, ExplainSettings, Far
from rankdrop.results.explanation.explanation import Explanation
from rankdrop.results.explanation.parts import (
    checked_frame,
    how_far,
    incidences_at,
    known_families,
    lost_of,
    turned_task,
    verdict_of,
)
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, EVALUATIONS, NEAR, SMALL, Tolerances
from rankdrop.version import VERSION

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
    evaluations: int = EVALUATIONS,
    step: float = 0.1,
    coranks: int = 1,
    seed: int = 0,
    length_scale: float | None = None,
    tolerances: Tolerances = DEFAULT,
    frame: str | None = None,
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
        frame: in whose axes lost motions and the cost of motion are told: "base", "tool", or "link", the one in which
            they are simplest; None tells what is lost in all three.

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
            typed="to be told of small ones, raise --near",
        )  # fmt: skip
    resolved = resolve_task(task, robot, length_scale=length_scale)
    families, source = known_families(robot, resolved, analysis, tolerances)
    settings = ExplainSettings(
        near, small, limits, evaluations, step, seed, float(resolved.scale(robot)), tolerances, VERSION,
        checked_frame(frame),
    )  # fmt: skip
    rank = rank_at(robot, configuration, resolved, tolerances)
    return _explained(Asked(robot, configuration, resolved, rank, families, source, coranks, settings))


def _explained(asked: Asked) -> Explanation:
    """Every part, at the configuration or at the singular one it is near."""
    robot, q, task, rank, settings = asked.robot, asked.q, asked.task, asked.rank, asked.settings
    far = how_far(asked)
    verdict, reason = verdict_of(rank, far, settings.near, settings.small)
    at_hand = far.nearest if verdict == "near" and far.near_miss is None else None
    focus = q if at_hand is None else np.array(at_hand.q)
    corank = rank.corank if at_hand is None else at_hand.corank
    way_out = escape(robot, q, task, tolerances=settings.tolerances, seed=settings.seed, step=settings.step)
    return Explanation(
        robot=robot,
        task=replace(task, length_scale=settings.length_scale),
        q=q,
        settings=settings,
        verdict=verdict,
        reason=reason,
        rank=rank,
        focus=focus,
        met=incidences_at(asked, focus, corank) if corank else (),
        source=asked.source,
        relations=relations_at(robot, focus),
        lost=(lost := lost_of(asked, focus, corank or (1 if far.near_miss is not None else 0))),
        blame=_blame(asked, focus, corank),
        escape=way_out,
        rates=joint_rates(robot, q, turned_task(task, settings.frame, lost)),
        far=far,
        failures=failures_at(robot, q, task, tolerances=settings.tolerances),
        ellipsoids=ellipsoids(robot, q, task),
        redundancy=redundancy(robot, q, task),
        representations=representation_at(robot, q, tolerances=settings.tolerances),
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


def _blame(asked: Asked, q: Array, corank: int) -> Blame:
    robot, task = asked.robot, asked.task
    dependencies = robot.n - asked.rank.generic_rank + corank
    few = robot.n <= LARGEST_CHAIN
    circuits = circuits_at(robot, q, task) if few else ()
    return Blame(
        circuits=circuits,
        smallest=make_all(circuits, robot.n, dependencies) if corank else (),
        ordered=ordered_subsets(robot, q, task),
        systems=systems_at(robot, q),
        always=always_singular_reason(robot, task),
        complete=few,
        hunt=hunt(robot, q, task, asked.settings.tolerances) if corank else None,
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
