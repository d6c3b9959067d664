"""Screw systems that stay dependent for ever: joints inside one subgroup of the rigid motions.

The screws of such joints span no more than the subgroup's dimension, and no motion of these joints themselves leaves
the subgroup: Hunt's systems of full-cycle mobility, which GR's second rule (section 3) takes out of the search for a
joint that escapes.

Which joints lie in one proper subgroup of the rigid motions, at one configuration.

The connected subgroups, as Lie algebras of twists (all there are up to the choice of axis, point and pitch):

    dimension 1  turns about a line, screws of one pitch along a line, slides along a direction
    dimension 2  cylindrical (a line), translations of a plane
    dimension 3  spherical (a point), planar (a normal), translations of space, planar with a screw (a normal, a pitch)
    dimension 4  Schönflies (a direction): translations of space and turns about parallel axes

A set of joints inside one of them stays inside when joints of the set move; so it does when a joint moves that only
maps the subgroup onto itself, that is one of its normaliser.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.kinematics import jacobian, one_configuration, task_jacobian
from rankdrop.local.block import generic_rank, structural_sample
from rankdrop.local.bracket import bracket, cross
from rankdrop.local.lines import Lines
from rankdrop.local.relations import numbers
from rankdrop.local.taylor import unlocked
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.numbers import reach
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import ALIGNED, DEPENDENT


@dataclass(frozen=True, slots=True)
class Member:
    """The largest set of joints inside one subgroup.

    Attributes:
        kind: "coaxial", "translational", "cylindrical", "spherical", "planar", "planar with a screw" or "Schönflies".
        dimension: of the subgroup.
        joints: indices from 0 in `Robot.joints`, mimic joints included.
        keepers: all joints, of the set or not, whose motion maps the subgroup onto itself.
    """

    kind: str
    dimension: int
    joints: tuple[int, ...]
    keepers: frozenset[int]


def members(lines: Lines) -> list[Member]:
    """The largest set of joints for every subgroup that two joints at least lie in; a set once, in the smallest."""
    found: dict[tuple[int, ...], Member] = {}
    for member in _all_members(lines):
        known = found.get(member.joints)
        if len(member.joints) > 1 and (known is None or member.dimension < known.dimension):
            found[member.joints] = member
    return list(found.values())


def closure(screws: Array, tolerance: float = 1e-7, most: int = 6) -> Array:
    """Orthonormal basis (d, 6) of the Lie algebra that some twists (N, 6) generate, lengths in one unit.

    Brackets of the basis are added until the dimension stays, or exceeds `most`: then the rest is not looked for.
    Directions below the tolerance are rounding [1].
    """
    basis = _span(screws, tolerance)
    while True:
        if len(basis) > most:
            return basis
        brackets = [bracket(a, b) for a, b in combinations(basis, 2)]
        grown = _span(np.array([*basis, *brackets]), tolerance)
        if len(grown) == len(basis):
            return basis
        basis = grown


def _all_members(lines: Lines) -> Iterator[Member]:
    turns, slides = lines.turns, lines.slides
    straight = [i for i in turns if abs(lines.h[i]) < lines.tolerance * lines.length]
    for i in turns:
        axis = [j for j in turns if lines.one_line(i, j)]
        along = [j for j in slides if lines.parallel(i, j)]
        bundle = [j for j in turns if lines.parallel(i, j)]
        keep_line, keep_direction = axis + along, bundle + slides
        across = [j for j in slides if lines.normal(i, j)]
        pitched = [j for j in bundle if lines.one_pitch(i, j)]
        yield _member("coaxial", 1, [j for j in axis if lines.one_pitch(i, j)], keep_line)
        yield _member("cylindrical", 2, axis + along, keep_line)
        yield _member("planar" if i in straight else "planar with a screw", 3, pitched + across, keep_direction)
        yield _member("Schönflies", 4, keep_direction, keep_direction)
    for i, j in combinations(straight, 2):
        on = lines.through_meeting(i, j)
        if on is not None:
            ball = [k for k in straight if on[k]]
            yield _member("spherical", 3, ball, ball)
    yield from _translations(lines)


def _translations(lines: Lines) -> Iterator[Member]:
    turns, slides = lines.turns, lines.slides
    for i in slides:
        keepers = slides + [j for j in turns if lines.parallel(i, j)]
        yield _member("translational", 1, [j for j in slides if lines.parallel(i, j)], keepers)
    for i, j in combinations(slides, 2):
        if not lines.parallel(i, j):
            normal = cross(lines.z[i], lines.z[j]) / lines.cross[i, j]
            plane = [k for k in slides if abs(normal @ lines.z[k]) < lines.tolerance]
            keepers = slides + [k for k in turns if np.linalg.norm(cross(normal, lines.z[k])) < lines.tolerance]
            yield _member("translational", 2, plane, keepers)
    yield _member("translational", 3, slides, turns + slides)


def _member(kind: str, dimension: int, joints: list[int], keepers: list[int]) -> Member:
    return Member(kind, dimension, tuple(sorted(joints)), frozenset(keepers))


def _span(rows: Array, tolerance: float) -> Array:
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    kept = rows[size[:, 0] > tolerance]
    if len(kept) == 0:
        return np.zeros((0, 6))
    _, sigma, vt = np.linalg.svd(kept / np.linalg.norm(kept, axis=1, keepdims=True))
    return np.asarray(vt[: int((sigma > tolerance).sum())])


_SAMPLES = 2  # random configurations that tell what stays


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
    lines = Lines(robot, one_configuration(robot, q), tolerance)
    elsewhere: list[Array] = []  # worked out when first needed
    pieces: dict[tuple[int, ...], ScrewSystem] = {}
    for member in members(lines):
        for joints, structural in _pieces(member):
            overfull = len(joints) > member.dimension
            if overfull and not structural and not elsewhere:
                elsewhere = _elsewhere(robot)
            always = structural or (overfull and all(
                len(closure(twists[list(joints)], most=member.dimension)) <= member.dimension for twists in elsewhere
            ))  # fmt: skip
            system = _system(robot, lines, member, joints, always)
            count = len(system.numbers)
            telling = count > system.dimension or (structural and count == system.dimension >= 2)
            known = pieces.get(system.numbers)
            if telling and (known is None or system.dimension < known.dimension):
                pieces[system.numbers] = system
    told = [system for system in pieces.values() if not any(_says_more(other, system) for other in pieces.values())]
    return tuple(sorted(told, key=lambda s: (not s.permanent, -s.loss, s.dimension, s.numbers)))


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
    losses = _losses(robot, task, q)
    best = max(_apart(losses), key=lambda chosen: (sum(loss for loss, _, _ in chosen), -len(chosen)))
    bound = min(most, robot.n - sum(loss for loss, _, _ in best))
    if bound > rank and dimension < 6:
        return head + _whole(robot, q, dimension, rank)
    if bound == most:
        return f"{head}no screw system of the joints accounts for it"
    told = "; ".join(words for _, _, words in best)
    return head + told + ("" if bound == rank else f"; this accounts for rank {bound}, not for {rank}")


def _elsewhere(robot: Robot) -> list[Array]:
    """Joint twists (N, 6) at random configurations, about the tip, lengths per reach."""
    points = structural_sample(robot, resolve_task("pose", robot), _SAMPLES)
    return [_twists(robot, q, reach(robot)) for q in points]


def _twists(robot: Robot, q: Array, length: float) -> Array:
    """(N, 6) twists of every joint, mimic joints too, about the tip: rounding stays small."""
    free, values, _ = unlocked(robot, q)
    twists = jacobian(free, values).T.copy()
    twists[:, :3] /= length
    return twists


def _whole(robot: Robot, q: Array, dimension: int, rank: int) -> str:
    """All joints in one subgroup, and what the task sees of it."""
    lines = Lines(robot, q)
    every = tuple(range(len(robot.joints)))
    whole = [member for member in members(lines) if member.joints == every and member.dimension == dimension]
    system = f"a {whole[0].kind} system ({_MEANING[whole[0].kind]})" if whole else "a system"
    told = f"joints {numbers(range(robot.n))} lie in {system} of dimension {dimension}"
    return told if dimension == rank else f"{told}, of which this task sees {rank}"


def _losses(robot: Robot, task: Task, q: Array) -> list[tuple[int, frozenset[int], str]]:
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


def _apart(losses: list[tuple[int, frozenset[int], str]]) -> Iterator[tuple[tuple[int, frozenset[int], str], ...]]:
    """Choices of at most three sets without a common joint, the empty one included."""
    for count in range(4):
        for chosen in combinations(losses, count):
            if all(not a[1] & b[1] for a, b in combinations(chosen, 2)):
                yield chosen


def _pieces(member: Member) -> Iterator[tuple[tuple[int, ...], bool]]:
    """The set itself, and its parts that surely stay together: all joints between two neighbours are keepers."""
    runs: list[list[int]] = [[member.joints[0]]]
    for before, joint in zip(member.joints, member.joints[1:], strict=False):
        if all(between in member.keepers for between in range(before + 1, joint)):
            runs[-1].append(joint)
        else:
            runs.append([joint])
    if len(runs) > 1:
        yield member.joints, False
    for run in runs:
        if len(run) > 1:
            yield tuple(run), True


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


def _system(robot: Robot, lines: Lines, member: Member, joints: tuple[int, ...], structural: bool) -> ScrewSystem:
    """A piece of a member as a record, its joints turned into variables."""
    names = [joint.name for joint in robot.variables]
    inside = {robot.joints[i].name for i in joints}
    outside = {j.mimic.leader for j in robot.joints if j.mimic is not None and j.name not in inside}
    chosen = tuple(i for i, name in enumerate(names) if name in inside - outside)
    permanent = structural and len(chosen) > member.dimension
    consecutive = bool(chosen) and chosen[-1] - chosen[0] == len(chosen) - 1
    system = ScrewSystem(
        numbers=tuple(i + 1 for i in chosen), kind=member.kind, dimension=member.dimension, consecutive=consecutive,
        structural=structural, permanent=permanent, words="",
    )
    slides = [i for i in joints if i in lines.slides]
    return replace(system, words=_words(system, bool(slides), len(slides) == len(joints)))


def _words(system: ScrewSystem, slides: bool, only_slides: bool) -> str:
    what = "slides" if only_slides else "joints" if slides else "axes"
    has = {
        "coaxial": "lie on one line",
        "translational": ("are parallel", "are parallel to one plane", "only translate")[min(system.dimension, 3) - 1],
        "cylindrical": "lie along one line" if slides else "lie on one line",
        "spherical": "meet in one point",
        "planar": "move in parallel planes" if slides else "are parallel",
        "planar with a screw": "move in parallel planes that rise by one pitch",
        "Schönflies": "turn about parallel axes and slide" if slides else "are parallel",
    }[system.kind]
    which = numbers([number - 1 for number in system.numbers])
    head = f"{what} {which} {has} ({system.kind} system of dimension {system.dimension})"
    if system.permanent:
        return f"{head}, dependent at every configuration"
    if system.structural:
        return f"{head}, at every configuration"
    return f"{head}, dependent here: no motion of these joints alone breaks it"
