"""Screw systems: joints inside one proper subgroup, and why an arm is singular everywhere.

The screws of a system span no more than the dimension of the subgroup, and no motion of these joints leaves the
subgroup: these are Hunt's systems of full-cycle mobility, which GR's second rule (section 3) excludes from the search
for a joint that escapes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.kinematics import jacobian, one_configuration, task_jacobian
from rankdrop.local.axes import Scene
from rankdrop.local.block import generic_rank, structural_sample
from rankdrop.local.departure import release_mimics
from rankdrop.local.subgroups import closure, subgroups
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, Robot, once
from rankdrop.sections import words_of
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import ALIGNED, DEPENDENT

_SYSTEM_SAMPLES = 2  # random configurations that tell what stays


class Members(StrEnum):
    """What the joints of a screw system are: turning axes only, slides only, or both."""

    AXES = "axes"
    SLIDES = "slides"
    JOINTS = "joints"


@dataclass(frozen=True, slots=True)
class ScrewSystem:
    """Joints whose motions lie in one proper subgroup.

    Attributes:
        numbers: joints from 1, all of them in the subgroup at this configuration.
        kind: "coaxial", "translational", "cylindrical", "spherical", "planar", "planar with a screw" or "Schönflies".
        dimension: of the subgroup: the most that these joints can span.
        consecutive: the numbers are a run.
        structural: in the subgroup at every configuration: the joints in between keep it as it is.
        permanent: structural, and more joints than the dimension: dependent at every configuration.
        members: whether slides are among its joints.
    """

    numbers: tuple[int, ...]
    kind: str
    dimension: int
    consecutive: bool
    structural: bool
    permanent: bool
    members: Members

    @property
    def words(self) -> str:
        """What the joints have in common, and whether they are dependent, in English."""
        words: str = words_of(self).system_words(self)
        return words

    @property
    def loss(self) -> int:
        """How many of the joints are too many for the dimension; 0 where they are not."""
        return max(0, len(self.numbers) - self.dimension)


def systems_at(robot: Robot, q: ArrayLike, tolerance: float = ALIGNED) -> tuple[ScrewSystem, ...]:
    """The screw systems at one configuration, those that lose most first.

    Told are sets with more joints than the subgroup has dimensions, and structural sets that just fill it (a spherical
    wrist). What a smaller set inside says as well is left out.

    Args:
        robot: the arm. A mimic joint goes with its leader: both have to lie in the subgroup.
        q: (n,) configuration [rad, m].
        tolerance: angles [rad] and lengths per reach below it are zero.

    Raises:
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> [(s.numbers, s.kind) for s in systems_at(open_robot("puma560"), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])]
        [((4, 5, 6), 'spherical')]
    """
    scene = Scene.at(robot, one_configuration(robot, q), tolerance, every_joint=True)
    pieces: dict[tuple[int, ...], ScrewSystem] = {}
    for kind, dimension, members, keepers in subgroups(scene):
        for joints, structural in _pieces(members, keepers):
            always = structural or (len(joints) > dimension and _stay_inside(robot, joints, dimension))
            system = _system(robot, scene, kind, dimension, joints, always)
            count = len(system.numbers)
            fills_it = structural and count == dimension >= 2
            if count <= dimension and not fills_it:
                continue
            if system.numbers not in pieces or dimension < pieces[system.numbers].dimension:
                pieces[system.numbers] = system
    kept = []
    for system in pieces.values():
        if not any(_says_more(other, system) for other in pieces.values()):
            kept.append(system)
    return tuple(sorted(kept, key=lambda s: (not s.permanent, -s.loss, s.dimension, s.numbers)))


@dataclass(frozen=True, slots=True)
class Loss:
    """Dimensions that a set of joints loses in a task at every configuration.

    Attributes:
        joints: from 0.
        lost: joints − rank of their columns.
        kind, dimension: of the screw system that holds them; "" and 0 for a joint that moves nothing in this task.
    """

    joints: frozenset[int]
    lost: int
    kind: str = ""
    dimension: int = 0


@dataclass(frozen=True, slots=True)
class AlwaysSingular:
    """Why an arm is deficient for a task at every configuration; a sentence as text and in JSON.

    Attributes:
        joints: how many the arm has.
        rank, most: at random configurations, and the smaller of rows and joints.
        dimension: of the one subgroup that holds all joints; 0 where another reason is given.
        kind: of that subgroup; "" where it is of none of the kinds of `ScrewSystem`.
        losses: sets without a common joint that lose most together, where no subgroup holds all joints; empty where
            none accounts for the loss.
        bound: rank that the losses leave at most.
    """

    joints: int
    rank: int
    most: int
    dimension: int = 0
    kind: str = ""
    losses: tuple[Loss, ...] = ()
    bound: int = 0

    def __str__(self) -> str:
        words: str = words_of(self).always_singular_words(self)
        return words

    def __json__(self) -> str:
        return str(self)


def always_singular_reason(robot: Robot, task: Task) -> AlwaysSingular | None:
    """Why an arm is deficient for a task at every configuration; None where it is not.

    Either all joints lie in one subgroup, or some sets of joints, apart from each other, have fewer dimensions than
    joints: then rank ≤ n − Σ (joints − dimension). The rank itself is that of random configurations; where the systems
    do not account for all of the loss, the words say so.

    Args:
        robot: the arm.
        task: the rows that count.

    Example:
        >>> from rankdrop.robot.screws import from_screws, revolute
        >>> from rankdrop.task import resolve_task
        >>> arm = from_screws([revolute([0, 0, 1], [x, 0, 0]) for x in range(4)], order="linear-first")
        >>> print(always_singular_reason(arm, resolve_task("pose", arm)))
        rank 3 of 4 everywhere: joints 1–4 lie in a planar system (parallel axes, slides normal to them) of dimension 3
    """
    rank = generic_rank(robot, task)
    most = min(task.m, robot.n)
    if rank == most:
        return None
    q = structural_sample(robot, task, 1)[0]
    dimension = len(closure(_twists(robot, q, task.scale(robot))))
    inside = AlwaysSingular(robot.n, rank, most, dimension, _kind_of_all(robot, q, dimension))
    if dimension < 6 and dimension == generic_rank(robot, resolve_task("pose", robot)):
        return inside
    best = max(_disjoint_choices(_losses(robot, task, q)), key=lambda chosen: (_lost_by(chosen), -len(chosen)))
    bound = min(most, robot.n - _lost_by(best))
    if bound > rank and dimension < 6:
        return inside
    if bound == most:
        return AlwaysSingular(robot.n, rank, most)
    return AlwaysSingular(robot.n, rank, most, losses=best, bound=bound)


def _lost_by(losses: Sequence[Loss]) -> int:
    """How many dimensions some sets of joints lose together."""
    return sum(loss.lost for loss in losses)


@once
def _stay_inside(robot: Robot, joints: tuple[int, ...], dimension: int) -> bool:
    """Whether some joints lie in a subgroup of this dimension at random configurations too."""
    points = structural_sample(robot, resolve_task("pose", robot), _SYSTEM_SAMPLES)
    every = (_twists(robot, q, reach(robot))[list(joints)] for q in points)
    return all(len(closure(twists, most=dimension)) <= dimension for twists in every)


def _twists(robot: Robot, q: Array, length: float) -> Array:
    """(N, 6) twists of every joint, mimic joints too, about the tip: rounding stays small."""
    free, values, _ = release_mimics(robot, q)
    twists = jacobian(free, values).T.copy()
    twists[:, :3] /= length
    return twists


def _kind_of_all(robot: Robot, q: Array, dimension: int) -> str:
    """The kind of a subgroup of this dimension that holds all joints; "" without one."""
    if dimension == 6:
        return ""
    every = tuple(range(len(robot.joints)))
    for kind, size, joints, _ in subgroups(Scene.at(robot, q, every_joint=True)):
        if joints == every and size == dimension:
            return kind
    return ""


def _losses(robot: Robot, task: Task, q: Array) -> list[Loss]:
    """Structural sets with what they lose in this task: joints − rank of their columns."""
    columns = task_jacobian(robot, q, task)
    losses = []
    for system in systems_at(robot, q):
        if not system.structural:
            continue
        chosen = frozenset(number - 1 for number in system.numbers)
        lost = len(chosen) - int((np.linalg.svd(columns[:, sorted(chosen)])[1] > DEPENDENT).sum())
        if lost > 0:
            losses.append(Loss(chosen, lost, system.kind, system.dimension))
    for i in np.flatnonzero(np.linalg.norm(columns, axis=0) <= DEPENDENT).tolist():
        losses.append(Loss(frozenset({i}), 1))
    return losses


def _disjoint_choices(losses: list[Loss]) -> Iterator[tuple[Loss, ...]]:
    """Choices of at most three sets without a common joint, the empty one included."""
    for count in range(4):
        for chosen in combinations(losses, count):
            if all(not a.joints & b.joints for a, b in combinations(chosen, 2)):
                yield chosen


def _pieces(joints: tuple[int, ...], keepers: frozenset[int]) -> Iterator[tuple[tuple[int, ...], bool]]:
    """The set itself, and its parts that surely stay together: all joints between two neighbours are keepers."""
    runs: list[list[int]] = [[joints[0]]]
    for before, joint in pairwise(joints):
        if keepers.issuperset(range(before + 1, joint)):
            runs[-1].append(joint)
        else:
            runs.append([joint])
    if len(runs) > 1:
        yield joints, False
    yield from ((tuple(run), True) for run in runs if len(run) > 1)


def _says_more(other: ScrewSystem, system: ScrewSystem) -> bool:
    """Does another system make this one superfluous? A structural one never is by one that is not."""
    if other is system or (system.structural and not other.structural):
        return False
    mine, others = set(system.numbers), set(other.numbers)
    filled_inside = system.loss == 0 and other.structural  # a part of a larger structure that is not dependent itself
    if mine < others and (other.dimension <= system.dimension or filled_inside):
        return True
    return others < mine and not system.structural and other.loss >= system.loss


def _system(
    robot: Robot, scene: Scene, kind: str, dimension: int, joints: tuple[int, ...], structural: bool
) -> ScrewSystem:
    """A set of joints in a subgroup as a record, its joints turned into variables."""
    inside = {robot.joints[i].name for i in joints}
    outside = {j.mimic.leader for j in robot.joints if j.mimic is not None and j.name not in inside}
    chosen = [i for i, joint in enumerate(robot.variables) if joint.name in inside - outside]
    slides = int(scene.slides[list(joints)].sum())
    permanent = structural and len(chosen) > dimension
    if slides == len(joints):
        members = Members.SLIDES
    elif slides:
        members = Members.JOINTS
    else:
        members = Members.AXES
    return ScrewSystem(
        numbers=tuple(i + 1 for i in chosen), kind=kind, dimension=dimension,
        consecutive=bool(chosen) and chosen[-1] - chosen[0] == len(chosen) - 1, structural=structural,
        permanent=permanent, members=members,
    )  # fmt: skip
