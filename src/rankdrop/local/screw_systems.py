"""Screw systems: joints inside one proper subgroup, and why an arm is singular everywhere.

The screws of a system span no more than the dimension of the subgroup, and no motion of these joints leaves the
subgroup: these are Hunt's systems of full-cycle mobility, which GR's second rule (section 3) excludes from the search
for a joint that escapes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.kinematics import jacobian, one_configuration, task_jacobian
from rankdrop.local.axes import Scene, numbers
from rankdrop.local.block import generic_rank, structural_sample
from rankdrop.local.departure import unlocked
from rankdrop.local.subgroups import closure, subgroups
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.numbers import reach
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import ALIGNED, DEPENDENT

_SYSTEM_SAMPLES = 2  # random configurations that tell what stays


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
        words: the whole in English.
    """

    numbers: tuple[int, ...]
    kind: str
    dimension: int
    consecutive: bool
    structural: bool
    permanent: bool
    words: str

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
    scene = Scene.of_joints(robot, one_configuration(robot, q)[None], tolerance)
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


def always_singular_reason(robot: Robot, task: Task) -> str | None:
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
    head = f"rank {rank} of {most} everywhere: "
    dimension = len(closure(_twists(robot, q, task.scale(robot))))
    if dimension < 6 and dimension == generic_rank(robot, resolve_task("pose", robot)):
        return head + _whole(robot, q, dimension, rank)
    best = max(_apart(_losses(robot, task, q)), key=lambda chosen: (_lost_by(chosen), -len(chosen)))
    bound = min(most, robot.n - _lost_by(best))
    if bound > rank and dimension < 6:
        return head + _whole(robot, q, dimension, rank)
    if bound == most:
        return f"{head}no screw system of the joints accounts for it"
    words = "; ".join(what for _, _, what in best)
    if bound > rank:
        words += f"; this accounts for rank {bound}, not for {rank}"
    return head + words


def _lost_by(losses: Sequence[_Loss]) -> int:
    """How many dimensions some sets of joints lose together."""
    return sum(loss for loss, _, _ in losses)


def _stay_inside(robot: Robot, joints: tuple[int, ...], dimension: int) -> bool:
    """Whether some joints lie in a subgroup of this dimension at random configurations too."""
    points = structural_sample(robot, resolve_task("pose", robot), _SYSTEM_SAMPLES)
    every = (_twists(robot, q, reach(robot))[list(joints)] for q in points)
    return all(len(closure(twists, most=dimension)) <= dimension for twists in every)


def _twists(robot: Robot, q: Array, length: float) -> Array:
    """(N, 6) twists of every joint, mimic joints too, about the tip: rounding stays small."""
    free, values, _ = unlocked(robot, q)
    twists = jacobian(free, values).T.copy()
    twists[:, :3] /= length
    return twists


def _whole(robot: Robot, q: Array, dimension: int, rank: int) -> str:
    """All joints in one subgroup, and what the task sees of it."""
    scene = Scene.of_joints(robot, q[None])
    every = tuple(range(len(robot.joints)))
    kinds = [kind for kind, size, joints, _ in subgroups(scene) if joints == every and size == dimension]
    if kinds:
        system = f"a {kinds[0]} system ({_MEANING[kinds[0]]})"
    else:
        system = "a system"
    words = f"joints {numbers(range(robot.n))} lie in {system} of dimension {dimension}"
    if dimension == rank:
        return words
    return f"{words}, of which this task sees {rank}"


_Loss = tuple[int, frozenset[int], str]
"""How many dimensions a set of joints loses, the joints from 0, and the set in words."""


def _losses(robot: Robot, task: Task, q: Array) -> list[_Loss]:
    """Structural sets with what they lose in this task: joints − rank of their columns."""
    columns = task_jacobian(robot, q, task)
    found = []
    for system in systems_at(robot, q):
        if not system.structural:
            continue
        chosen = frozenset(number - 1 for number in system.numbers)
        loss = len(chosen) - int((np.linalg.svd(columns[:, sorted(chosen)])[1] > DEPENDENT).sum())
        if loss > 0:
            what = f"joints {numbers(sorted(chosen))} lie in a {system.kind} system of dimension {system.dimension}"
            found.append((loss, chosen, f"{what} and lose {loss}"))
    for i in np.flatnonzero(np.linalg.norm(columns, axis=0) <= DEPENDENT).tolist():
        found.append((1, frozenset({i}), f"joint {i + 1} moves nothing in this task"))
    return found


def _apart(losses: list[_Loss]) -> Iterator[tuple[_Loss, ...]]:
    """Choices of at most three sets without a common joint, the empty one included."""
    for count in range(4):
        for chosen in combinations(losses, count):
            if all(not a[1] & b[1] for a, b in combinations(chosen, 2)):
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


_MEANING = {
    "coaxial": "one line",
    "translational": "slides",
    "cylindrical": "one line, turns and slides",
    "spherical": "axes that meet in one point",
    "planar": "parallel axes, slides normal to them",
    "planar with a screw": "parallel screws of one pitch, slides normal to them",
    "Schönflies": "parallel axes and slides",
}


def _system(
    robot: Robot, scene: Scene, kind: str, dimension: int, joints: tuple[int, ...], structural: bool
) -> ScrewSystem:
    """A set of joints in a subgroup as a record, its joints turned into variables."""
    inside = {robot.joints[i].name for i in joints}
    outside = {j.mimic.leader for j in robot.joints if j.mimic is not None and j.name not in inside}
    chosen = [i for i, joint in enumerate(robot.variables) if joint.name in inside - outside]
    slides = int(scene.slides[list(joints)].sum())
    permanent = structural and len(chosen) > dimension
    shared = _shared_in(kind, dimension, slides, len(joints))
    return ScrewSystem(
        numbers=tuple(i + 1 for i in chosen), kind=kind, dimension=dimension,
        consecutive=bool(chosen) and chosen[-1] - chosen[0] == len(chosen) - 1, structural=structural,
        permanent=permanent,
        words=f"{shared.format(numbers(chosen))} ({kind} system of dimension {dimension}), "
        f"{_WHEN[structural, permanent]}",
    )  # fmt: skip


def _shared_in(kind: str, dimension: int, slides: int, joints: int) -> str:
    """What the joints of a system have in common, some of them slides: "axes {} are parallel"."""
    if slides == joints:
        what = "slides"
    elif slides:
        what = "joints"
    else:
        what = "axes"
    if kind == "translational":
        of_axes, with_slides = _SHARED[f"{kind} {dimension}"]
    else:
        of_axes, with_slides = _SHARED[kind]
    return f"{what} {{}} {with_slides if slides else of_axes}"


_WHEN = {
    (False, False): "dependent here: no motion of these joints alone breaks it",
    (True, False): "at every configuration",
    (True, True): "dependent at every configuration",
}
"""Whether a system is structural, and permanent."""
_SHARED = {
    "coaxial": ("lie on one line", "lie on one line"),
    "translational 1": ("are parallel", "are parallel"),
    "translational 2": ("are parallel to one plane", "are parallel to one plane"),
    "translational 3": ("only translate", "only translate"),
    "cylindrical": ("lie on one line", "lie along one line"),
    "spherical": ("meet in one point", "meet in one point"),
    "planar": ("are parallel", "move in parallel planes"),
    "planar with a screw": ("move in parallel planes that rise by one pitch",) * 2,
    "Schönflies": ("are parallel", "turn about parallel axes and slide"),
}
"""What axes alone have in common in each kind of system, and joints with slides among them."""
