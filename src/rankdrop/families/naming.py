"""Names of singularity families, from the geometry of the axes at sample points; never from the arm's name.

And the motions that a family takes away, as directions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce
from itertools import compress, product
from operator import or_

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import ConfigurationError
from rankdrop.families.facts import Fact, Structure, candidate_facts, structure_of
from rankdrop.families.lost import LostFreedom, freedoms_at_witness, freedoms_of
from rankdrop.families.name import (
    ArmPart,
    Detail,
    FamilyName,
    Geometry,
    JointValues,
    LowRank,
    Shorter,
    Variable,
    is_right,
)
from rankdrop.kinematics import task_jacobian
from rankdrop.local.axes import Scene
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.local.circuits import to_blame
from rankdrop.local.dependence import Common, dependence_of, line_meets_all
from rankdrop.local.directions import lost_directions, lost_over_family
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.numbers import wrap_angle
from rankdrop.task import Task
from rankdrop.units import as_given

_POINTS = 12  # sample points looked at
_AWAY = 0.37  # how far a joint is moved to see what it breaks [rad, m]: no simple fraction of π
_LOST = 1e-6  # σ at or below this at the samples is zero; a joint moved by _AWAY lifts it by far more

_FEW = 2  # values of one joint that a name lists
_ONE = 1e-5  # values of a joint that differ by less are one [rad, m]

_PATTERNLESS = (Common.DEPENDENT_SCREWS, Common.DEPENDENT_JOINTS)

LONGEST = 60
"""Characters that a name should have at most."""

_COSTS = {
    Shorter.PLUS_MINUS: 1, Shorter.STRETCHED: 2, Shorter.CONDITION_WITHOUT_WITH: 4, Shorter.FIRST_OF_TWO: 8,
    Shorter.WHOLE_DEGREES: 12, Shorter.CONDITION_WITHOUT_JOINTS: 14,
}  # fmt: skip
_RELATION, _FACT, _VALUE, _BOUND = 6, 40, 48, 80
"""Cost of leaving out "4 ⟂ 6", another fact, a value, and that there is a condition."""

_MANY = 6  # details of which every choice is tried


def lost_motions(problem: Problem, at: Array, points: Array) -> tuple[Array, tuple[LostFreedom, ...]]:
    """Lost directions at a configuration in the task's frame, and as the freedoms that the family takes away.

    These are for the whole family where some frame of the chain sees the same directions at all its points; else they
    are for the configuration, in the frame where they are sparsest.

    Args:
        problem: the arm, and the corank of the family.
        at: (n,) a configuration on the family, of exactly its corank.
        points: (N, n) others.
    """
    robot, task, corank = problem.robot, problem.task, problem.corank
    directions = lost_directions(robot, at, task, corank)
    steady = lost_over_family(robot, np.vstack([at, points[:5]]), task, corank)
    if steady is not None:
        return directions, freedoms_of(robot, steady, everywhere=True)
    return directions, freedoms_at_witness(robot, at, task, corank)


def name_family(
    robot: Robot, task: Task, points: ArrayLike, pinned: Sequence[int] = (), *, coupled: Sequence[int] | None = None
) -> FamilyName:
    """The name of a family of singular configurations.

    1. Joints that matter: those whose motion alone raises the rank at the samples, and the pinned ones.
    2. Facts about the axes that hold at every sample but not at every configuration (`candidate_facts`), the most
       telling first, are taken until each joint that matters breaks one of them when it moves. In an arm without
       redundancy facts that cost rank by themselves come first, and have to add up to the corank.
    3. Facts that concern the shoulder, the elbow or the wrist give the name its first words.
    4. What the facts leave open: joints that other conditions bind ("with a condition on θ3–θ6"), and values that tell
       the posture: those that are no simple angles, and those of joints that break none of the facts. Without any fact:
       "all axes meet one line" where the blocked wrench is a pure force, else the smallest dependent sets of joint
       screws ("joints 2–6 dependent").

    What a name states is true at every sample point. Names are not unique, and may be long:
    `distinct_names` mends both.

    Args:
        robot: the arm.
        task: the rows that matter.
        points: (N, n) generic points of the family, singular to 1e-9 or better [rad, m]; the first twelve are looked
            at, all of them for the values of single joints.
        pinned: numbers of the family's pinned joints, if known.
        coupled: numbers of the joints that conditions bind beside the pinned ones; None: not known, not told.

    Raises:
        ConfigurationError: no points, the wrong shape, or points that are not singular.
    """
    q = np.asarray(points, dtype=np.float64)
    if q.ndim != 2 or q.shape[0] == 0 or q.shape[1] != robot.n or not np.isfinite(q).all():
        raise ConfigurationError("points of a family are needed", got=q.shape, allowed=f"(N, {robot.n}), N ≥ 1, finite")
    scene = Scene(robot, q[:_POINTS])
    generic = generic_rank(robot, task)
    corank = generic - int((singular_values(robot, scene.q, task)[:, :generic] > _LOST).sum(axis=1).max())
    if corank == 0:
        raise ConfigurationError("these points are not all singular", mend="polish them, or drop the regular ones")
    structure = structure_of(robot, task, generic)
    matter = _joints_that_matter(scene, task, generic - corank) | {number - 1 for number in pinned}
    facts, covered = _explain(structure, scene, matter, corank)
    if facts:
        name = _compose(facts, structure.tight, corank)
        if coupled is None:
            return name
        return _with_open_joints(name, robot, q, matter - covered, pinned, coupled)
    return _systematic(scene, structure, task, corank, generic)


def _with_open_joints(
    name: FamilyName, robot: Robot, q: Array, uncovered: set[int], pinned: Sequence[int], coupled: Sequence[int]
) -> FamilyName:
    """The name with what its facts leave open: joints with a condition, and values that tell the posture.

    Args:
        name: with its facts.
        robot: the arm.
        q: (N, n) points of the family.
        uncovered: joints (from 0) that matter and break none of the facts.
        pinned, coupled: numbers of joints.
    """
    bound = sorted({*(number - 1 for number in (*pinned, *coupled)), *uncovered})
    values = {j: _values(q[:, j], turns=bool(robot.periodic[j])) for j in bound}
    few = {j: joint_values for j, joint_values in values.items() if len(joint_values) <= _FEW}
    varying = [j for j in bound if j not in few]
    if uncovered & set(varying):
        conditions = tuple(_variable(robot, j) for j in varying)
    else:
        conditions = ()
    listed = tuple(
        JointValues(_variable(robot, j), tuple(_as_given(robot, j, x) for x in joint_values))
        for j, joint_values in few.items() if j in uncovered or not all(map(is_right, joint_values))
    )  # fmt: skip
    return replace(name, bound=conditions, values=listed)


def _values(column: Array, *, turns: bool) -> list[float]:
    """The different values of one joint, sorted; angles in (−π, π]."""
    values: list[float] = []
    for value in np.pi - np.mod(np.pi - column, 2 * np.pi) if turns else column:
        off = (value - other for other in values)
        if all(abs(wrap_angle(x) if turns else x) > _ONE for x in off):
            values.append(float(value))
        if len(values) > _FEW:
            break
    return sorted(values)


def _slides(robot: Robot, joint: int) -> bool:
    return robot.variables[joint].unit != "rad"


def _variable(robot: Robot, joint: int) -> Variable:
    return Variable(joint + 1, _slides(robot, joint))


def _as_given(robot: Robot, joint: int, value: float) -> float:
    """A value in the unit that the arm was given in."""
    if _slides(robot, joint):
        return float(as_given(robot, np.eye(robot.n)[joint] * value)[joint])
    return value


def _joints_that_matter(scene: Scene, task: Task, rank: int) -> set[int]:
    """Joints whose motion alone raises the rank at more than half of the samples."""
    matter = set()
    for joint in range(scene.robot.n):
        sigma = singular_values(scene.robot, scene.after_motion(joint, _AWAY).q, task)[:, rank]
        if np.mean(sigma > _LOST) > 0.5:
            matter.add(joint)
    return matter


def _explain(structure: Structure, scene: Scene, matter: set[int], corank: int) -> tuple[list[Fact], set[int]]:
    """Facts of the family, and the joints each of which breaks one of them.

    Without redundancy the facts have to cost as much rank as is lost; else none is claimed.
    """
    true = [fact for fact in candidate_facts(structure, scene) if _own_to_family(fact, structure, scene)]
    breaking = [_breaking(fact, scene, matter) for fact in true]
    chosen: list[int] = []
    if structure.tight:
        chosen = _losing(true, breaking, corank)
        lost = sum(true[i].losses for i in chosen)
        if lost < corank:
            return [], set()
    covered = set[int]().union(*(breaking[i] for i in chosen))
    for i in range(len(true)):
        if i not in chosen and breaking[i] - covered:
            chosen.append(i)
            covered |= breaking[i]
    return [true[i] for i in chosen], covered


def _own_to_family(fact: Fact, structure: Structure, scene: Scene) -> bool:
    """Whether a fact holds at every sample of the family, but not at every configuration of the arm."""
    return bool(fact.holds(scene).all()) and not structure.always(fact.holds)


def _breaking(fact: Fact, scene: Scene, joints: set[int]) -> set[int]:
    """The joints that break a fact at some sample when they move."""
    return {joint for joint in joints if not fact.holds(scene.after_motion(joint, _AWAY)).all()}


def _losing(facts: Sequence[Fact], breaking: Sequence[set[int]], corank: int) -> list[int]:
    """Numbers of facts that cost rank by themselves, until as much is lost as the corank says."""
    chosen: list[int] = []
    covered: set[int] = set()
    for i, fact in enumerate(facts):
        short = sum(facts[j].losses for j in chosen) < corank
        if fact.losses and short and (breaking[i] - covered or (fact.roles and breaking[i])):
            chosen.append(i)
            covered |= breaking[i]
    return chosen


def _compose(facts: Sequence[Fact], tight: bool, corank: int) -> FamilyName:
    """Parts and details; the parts are `independent` where each of several facts is one part's own."""
    named = set[ArmPart]().union(*(fact.roles for fact in facts))
    parts = tuple(part for part in ArmPart if part in named)
    if tight and corank > 1 and len(parts) == corank:
        return FamilyName(parts, True, _details([fact for fact in facts if len(fact.roles) != 1]))
    return FamilyName(parts, False, _details(facts))


def _details(facts: Sequence[Fact]) -> tuple[Detail, ...]:
    """The facts as a name lists them; the first in full, later relations in brief."""
    detailed = [(fact, fact.detail) for fact in facts if fact.detail is not None]
    parallel = _parallel_to_bundles(facts, [fact for fact, _ in detailed])
    if len(detailed) < len(facts):
        detailed = [(fact, detail) for fact, detail in detailed if not _said_by_elbow(fact)]
    details = [detail for fact, detail in detailed if fact.roles]
    details += [*_aligned_details(facts), *parallel, *(detail for fact, detail in detailed if not fact.roles)]
    relations = _relations(facts, {fact.joints for fact, _ in detailed})
    if relations and not details:
        first = relations.pop(0)
        details.append(Detail(first.geometry, (first.joints,)))
    details += [Detail(fact.geometry, (fact.joints,), brief=True) for fact in relations]
    return tuple(details)


def _said_by_elbow(fact: Fact) -> bool:
    """Whether the word "elbow" states a fact in full."""
    return fact.roles == (ArmPart.ELBOW,) and fact.geometry is not Geometry.NEARLY_STRETCHED


def _aligned_details(facts: Sequence[Fact]) -> list[Detail]:
    groups = tuple(fact.joints for fact in facts if fact.geometry is Geometry.ALIGNED)
    if groups:
        return [Detail(Geometry.ALIGNED, groups)]
    return []


def _relations(facts: Sequence[Fact], named: set[tuple[int, ...]]) -> list[Fact]:
    """What is parallel, then what is perpendicular, but for joints of which more is told."""
    kinds = (Geometry.PARALLEL, Geometry.PERPENDICULAR)
    others = [fact for fact in facts if fact.geometry in kinds and fact.joints not in named]
    return sorted(others, key=lambda fact: kinds.index(fact.geometry))


def _parallel_to_bundles(facts: Sequence[Fact], detailed: Sequence[Fact]) -> list[Detail]:
    """Axes parallel to a bundle, bundle by bundle, but for what other facts tell."""
    firsts: dict[tuple[int, ...], list[int]] = {}
    for first, *bundle in (fact.joints for fact in facts if fact.geometry is Geometry.AGAINST):
        if not any({first, *bundle} <= set(other.joints) for other in detailed):
            firsts.setdefault(tuple(bundle), []).append(first)
    return [Detail(Geometry.AGAINST, (tuple(first), bundle)) for bundle, first in firsts.items()]


def _systematic(scene: Scene, structure: Structure, task: Task, corank: int, generic: int) -> FamilyName:
    """A name from the smallest dependent sets of joint screws."""
    usual = task_jacobian(scene.robot, structure.scene.q, task)
    blame = to_blame(task_jacobian(scene.robot, scene.q, task), usual, corank)
    circuits = tuple(dependence_of(scene, circuit, task) for circuit in blame)
    complete = len(blame) == corank
    if complete and all(circuit.common not in _PATTERNLESS for circuit in circuits):
        return FamilyName(details=circuits)
    if corank == 1 and generic == task.m and line_meets_all(scene, task):
        if structure.tip_is_centre:
            return FamilyName(details=(Detail(Geometry.LINE_THROUGH_TIP),))
        return FamilyName(details=(Detail(Geometry.LINE_MEETS_ALL),))
    if complete and (structure.tight or min(map(len, blame)) < generic):
        return FamilyName(details=circuits)
    return FamilyName(details=(LowRank(scene.robot.n, generic - corank, task.m == 6),))


def shorten_names(names: Sequence[FamilyName]) -> list[FamilyName]:
    """Names of at most `LONGEST` characters that stay different; shorter ones keep every word.

    A long one gives up as little as it must: first the way its values are written, then relations of single axes, then
    other details and values. The part of the arm is always told. One that cannot be that short is the shortest that no
    other has.
    """
    result = list(names)
    words = [str(name) for name in names]
    for place, name in enumerate(names):
        if len(words[place]) > LONGEST:
            others = {*words[:place], *words[place + 1 :]}
            best = name
            for tried in _shorter(name):
                text = str(tried)
                if text not in others:
                    if best is name or len(text) < len(words[place]):
                        best, words[place] = tried, text
                    if len(text) <= LONGEST:
                        break
            result[place] = best
    return result


def _shorter(name: FamilyName) -> Iterator[FamilyName]:
    """What a name may become, what it loses least by first."""
    costs = _costs_of_details(name)
    many = _closing_words(name)
    choices = []
    for kept, shown in product(_subsets(costs, bool(name.parts)), range(many + 1)):
        left_out = sum(cost for place, cost in enumerate(costs) if place not in kept)
        values_left_out = _VALUE * (many - shown)
        for shorter, spent in _SPELLINGS:
            choices.append((left_out + values_left_out + spent, kept, shown, shorter))
    for _, kept, shown, shorter in sorted(choices, key=lambda choice: choice[0]):
        yield _shortened_to(name, kept, shown, shorter)


def _costs_of_details(name: FamilyName) -> list[int]:
    """Cost of leaving out each detail of a name; last that there is a condition, where there is one."""
    costs = [_RELATION if isinstance(detail, Detail) and detail.brief else _FACT for detail in name.details]
    if name.bound:
        costs.append(_BOUND)
    return costs


def _closing_words(name: FamilyName) -> int:
    """How many values, conditions and numbers end a name; a number goes with the value before it."""
    numbered = name.ordinal > 0 and not name.values
    return len(name.values) + (name.condition != "") + numbered


def _spellings() -> Iterator[tuple[Shorter, int]]:
    """Every choice of the shorter ways of writing, with its cost."""
    for chosen in product((False, True), repeat=len(_COSTS)):
        flags = list(compress(_COSTS, chosen))
        yield reduce(or_, flags, Shorter.NOTHING), sum(_COSTS[flag] for flag in flags)


_SPELLINGS = tuple(_spellings())


def _shortened_to(name: FamilyName, kept: Sequence[int], closing: int, shorter: Shorter) -> FamilyName:
    """A name with the details of numbers `kept`, the first `closing` of its closing words, and a way of writing."""
    return replace(
        name,
        details=tuple(detail for place, detail in enumerate(name.details) if place in kept),
        bound=name.bound if len(name.details) in kept else (),
        values=name.values[:closing],
        condition=name.condition if closing > len(name.values) else "",
        ordinal=name.ordinal if closing == _closing_words(name) else 0,
        shorter=shorter,
    )


def _subsets(costs: Sequence[int], parted: bool) -> list[tuple[int, ...]]:
    """Which details may be kept, in their order: with a fact, if there is one; none where a part of the arm is told."""
    count = len(costs)
    every = range(2**count) if count <= _MANY else [2**first - 1 for first in range(count + 1)]
    chosen = [tuple(i for i in range(count) if number >> i & 1) for number in every]
    facts = {i for i, cost in enumerate(costs) if cost == _FACT} or set(range(count))
    return [subset for subset in chosen if facts & set(subset) or (parted and not subset)]
