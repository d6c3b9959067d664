"""What can be true of the axes of an arm at a singularity, as geometric facts that can be checked at any configuration.

Facts that hold at *every* configuration are the arm's structure (spherical wrist, spherical shoulder, parallel axes);
facts that hold on a family only are what the family is named after. Each carries how much rank it costs by itself in
an arm without redundancy (n = generic rank), with the reason beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from rankdrop.families.name import ArmPart, Centre, Detail, Geometry, Plane
from rankdrop.local.axes import Scene, Verdicts
from rankdrop.robot.model import Array, Robot
from rankdrop.task import TIP, Task

_SAMPLES = 12  # random configurations at which a fact must hold to be structure

_SHOULDER, _ELBOW, _WRIST = (ArmPart.SHOULDER,), (ArmPart.ELBOW,), (ArmPart.WRIST,)


@dataclass(frozen=True, slots=True)
class Fact:
    """One statement about the axes.

    Attributes:
        holds: at which configurations of a scene the statement is true.
        geometry: ALIGNED, PARALLEL, PERPENDICULAR, AGAINST (the first of `joints` parallel to the rest) are facts that
            a name joins with others of their kind; of any other one `detail` is what the name says.
        joints: indices from 0.
        detail: of these others.
        roles: parts of the arm it concerns.
        losses: by how much it lowers the rank of an arm without redundancy by itself.
    """

    holds: Callable[[Scene], Verdicts]
    geometry: Geometry
    joints: tuple[int, ...]
    detail: Detail | None = None
    roles: tuple[ArmPart, ...] = ()
    losses: int = 1


@dataclass(frozen=True, slots=True)
class Structure:
    """What is true of an arm at every configuration.

    Attributes:
        tight: no redundancy: as many joints as the generic rank.
        shoulder: the first three joints, where their axes meet in one point (seven joints or more); else empty.
        wrist: the last three joints, where their axes meet in one point; else empty.
        wrist_point: the first two of an offset wrist, where their axes meet (seven joints or more); else empty.
        tip_is_centre: the task leaves the rotation free, so that the tip plays the part of the wrist centre.
        bundles: groups of two or more axes that are always parallel.
        slides: joints that are not axes.
        scene: the random configurations that were looked at.
    """

    tight: bool
    shoulder: tuple[int, ...]
    wrist: tuple[int, ...]
    wrist_point: tuple[int, ...]
    tip_is_centre: bool
    bundles: tuple[tuple[int, ...], ...]
    scene: Scene

    def centre(self, scene: Scene) -> Array | None:
        """(N, 3) the wrist centre, or the tip for a task without rotation; None where there is none."""
        if self.tip_is_centre:
            return scene.tip
        if self.wrist:
            return scene.common_point(self.wrist)[0]
        return None

    @property
    def centre_kind(self) -> Centre:
        """Which point it is."""
        if self.tip_is_centre:
            return Centre.TIP
        return Centre.WRIST

    def always(self, verdict: Callable[[Scene], Verdicts]) -> bool:
        """Is it true at every configuration?"""
        return bool(verdict(self.scene).all())


def structure_of(robot: Robot, task: Task, generic_rank: int) -> Structure:
    """Find the structure at random configurations (a fixed seed; true at all of them means true always)."""
    scene = Scene(robot, np.random.default_rng(1).uniform(-np.pi, np.pi, (_SAMPLES, robot.n)))
    tight = robot.n == generic_rank
    bundles = tuple(groups(scene.axes, scene.parallel))
    if len(task.rows) < 6:
        return Structure(tight, (), (), (), _tip_is_centre(task), bundles, scene)
    shoulder, wrist = _spherical_shoulder(scene), _spherical_wrist(scene)
    wrist_point = () if wrist else _offset_wrist(scene)
    return Structure(tight, shoulder, wrist, wrist_point, False, bundles, scene)


def _tip_is_centre(task: Task) -> bool:
    """Whether a task moves the tip itself in a plane or in space, whatever the tool's orientation."""
    moves_tip = task.frame.origin == TIP and not any(task.frame.point)
    return moves_tip and {0, 1} <= set(task.rows) and not {3, 4, 5} & set(task.rows)


def _spherical_shoulder(scene: Scene) -> tuple[int, ...]:
    """The first three joints of an arm of seven or more, where their axes meet in one point."""
    joints = (0, 1, 2)
    return joints if scene.robot.n >= 7 and _meet(scene, joints) else ()


def _spherical_wrist(scene: Scene) -> tuple[int, ...]:
    """The last three joints of an arm of six or more, where their axes meet in one point."""
    n = scene.robot.n
    joints = (n - 3, n - 2, n - 1)
    return joints if n >= 6 and _meet(scene, joints) else ()


def _offset_wrist(scene: Scene) -> tuple[int, ...]:
    """The two joints before the last one of an arm of seven or more, where their axes meet."""
    n = scene.robot.n
    joints = (n - 3, n - 2)
    turning = n >= 7 and set(joints) <= set(scene.axes)
    return joints if turning and scene.meeting(*joints).all() else ()


def groups(axes: Sequence[int], related: Verdicts) -> Iterator[tuple[int, ...]]:
    """Classes of two or more axes that are related at every configuration of a scene."""
    left = list(axes)
    while left:
        first = left.pop(0)
        group = [first, *(other for other in left if related[first, other].all())]
        left = [other for other in left if other not in group]
        if len(group) > 1:
            yield tuple(group)


def candidate_facts(structure: Structure, scene: Scene) -> Iterator[Fact]:
    """Facts worth testing on a family seen at `scene`: those about a part of the arm first."""
    facts = [
        *_elbow(structure),
        *_aligned_axes_facts(structure, scene),
        *_against_bundles(structure),
        *_spherical(structure),
        *_centre(structure),
        *_parallel(structure, scene),
        *_perpendicular(scene),
    ]
    yield from sorted(facts, key=lambda fact: not fact.roles)


def _elbow(structure: Structure) -> Iterator[Fact]:
    """The reach cannot be changed: the arm is stretched or folded."""
    yield from _stretched_arm_facts(structure)
    for bundle in structure.bundles:
        yield from _coplanar_elbow(structure, bundle)


def _stretched_arm_facts(structure: Structure) -> Iterator[Fact]:
    """The wrist centre is farthest from the centre of a spherical shoulder, or nearest to it."""
    if structure.shoulder and structure.wrist:
        # a force along the line from shoulder to wrist centre meets the axes there and is reciprocal to those between
        yield _detailed_fact(lambda s: _reach_stationary(structure, s), Detail(Geometry.STRETCHED), (), _ELBOW)
    elif structure.shoulder and structure.wrist_point:
        # the same of the point that the wrist turns about, where its last axis passes it by
        nearly = Detail(Geometry.NEARLY_STRETCHED)
        yield _detailed_fact(lambda s: _reach_stationary(structure, s, structure.wrist_point), nearly, (), _ELBOW, 0)


def _coplanar_elbow(structure: Structure, bundle: tuple[int, ...]) -> Iterator[Fact]:
    """Parallel axes in one plane, with the wrist centre or the tip where one of them is the arm's centre."""
    if structure.tight and (structure.tip_is_centre or structure.wrist):
        # two parallel axes both move the centre along the normal of that plane
        for pair in pairwise(bundle):
            if pair[1] == pair[0] + 1 and not set(pair) & set(structure.wrist):
                yield _with_centre(structure, pair)
    elif structure.tip_is_centre and len(bundle) == structure.scene.robot.n:
        yield _with_centre(structure, bundle)
    elif len(bundle) >= 3:
        # parallel lines of one plane span a screw system of rank 2, those of space 3
        detail = Detail(Geometry.COPLANAR, (bundle,))
        yield _detailed_fact(_coplanar(bundle), detail, bundle, _ELBOW, 1 if len(bundle) == 3 else 0)


def _with_centre(structure: Structure, axes: tuple[int, ...]) -> Fact:
    detail = Detail(Geometry.COPLANAR_WITH_CENTRE, (axes,), centre=structure.centre_kind)
    return _detailed_fact(lambda s: s.coplanar(axes, structure.centre(s)), detail, axes, _ELBOW)


def _detailed_fact(
    holds: Callable[[Scene], Verdicts], detail: Detail, joints: tuple[int, ...], roles: tuple[ArmPart, ...] = (),
    losses: int = 1,
) -> Fact:  # fmt: skip
    """A fact with a detail of its own."""
    return Fact(holds, detail.geometry, joints, detail, roles, losses)


def _aligned_axes_facts(structure: Structure, scene: Scene) -> Iterator[Fact]:
    """Axes on one line: equal screws."""
    for group in groups(scene.axes, scene.aligned):
        in_shoulder, in_wrist = (len(set(group) & set(part)) for part in (structure.shoulder, structure.wrist))
        centre_on_axis_1 = structure.tight and group[0] == 0 and in_wrist > 0
        told = ((ArmPart.SHOULDER, in_shoulder > 1 or centre_on_axis_1), (ArmPart.WRIST, in_wrist > 1))
        roles = tuple(role for role, concerned in told if concerned)
        yield Fact(_all_pairs("aligned", group), Geometry.ALIGNED, group, roles=roles, losses=len(group) - 1)


def _against_bundles(structure: Structure) -> Iterator[Fact]:
    """The first or the last axis parallel to three parallel ones: four screws of a system of rank 3."""
    last = structure.scene.robot.n - 1
    for bundle in structure.bundles:
        if len(bundle) >= 3:
            for i, roles in ((0, _SHOULDER), (last, _WRIST)):
                if i in structure.scene.axes and i not in bundle:
                    pair = _all_pairs("parallel", (i, bundle[0]))
                    yield Fact(pair, Geometry.AGAINST, (i, *bundle), roles=roles)


def _spherical(structure: Structure) -> Iterator[Fact]:
    """Three axes through one point and in one plane: rank 2. Two of them on one line is another fact."""
    for roles, joints in ((_SHOULDER, structure.shoulder), (_WRIST, structure.wrist)):
        if joints:
            yield _detailed_fact(_fan(joints), Detail(Geometry.COPLANAR, (joints,)), joints, roles)


def _centre(structure: Structure) -> Iterator[Fact]:
    """Where the wrist centre (or the tip, or the point where the last two axes of a UR-type arm meet) can be."""
    n = structure.scene.robot.n
    if not structure.tight:
        return
    plane = _shoulder_plane(structure)
    if structure.wrist or structure.tip_is_centre:
        yield from _centre_on_axes(structure)
        if plane:
            # the line through the centre along axis 2 meets axis 1, and axes 2 and 3 (parallel, or in the same plane)
            holds = _in_shoulder_plane(structure.centre)
            in_plane = Detail(Geometry.CENTRE_IN_PLANE, ((0, 1),), centre=structure.centre_kind, plane=plane)
            yield _detailed_fact(holds, in_plane, (0, 1), _SHOULDER)
    elif n == 6 and plane and _is_ur_type(structure):
        # the line through that point along axis 2 meets or is parallel to every axis
        holds = _in_shoulder_plane(lambda s: s.common_point((4, 5))[0])
        meet = Detail(Geometry.AXES_MEET_IN_PLANE, ((4, 5), (0, 1)), plane=plane)
        yield _detailed_fact(holds, meet, (0, 1, 4, 5), _SHOULDER)


def _centre_on_axes(structure: Structure) -> Iterator[Fact]:
    """The centre lies on an axis that is not of the wrist; a rotation about that axis does not move the centre."""
    for i in structure.scene.axes:
        if i not in structure.wrist:
            on_axis = Detail(Geometry.CENTRE_ON_AXIS, ((i,),), centre=structure.centre_kind)
            yield _detailed_fact(_centre_on(structure, i), on_axis, (i,), _SHOULDER if i == 0 else ())


def _parallel(structure: Structure, scene: Scene) -> Iterator[Fact]:
    for group in groups(scene.axes, scene.parallel):
        # four parallel axes are four screws of a system of rank 3
        yield Fact(_all_pairs("parallel", group), Geometry.PARALLEL, group, losses=max(0, len(group) - 3))
        if len(group) > 2 and group not in structure.bundles:
            yield _detailed_fact(_coplanar(group), Detail(Geometry.PARALLEL_AND_COPLANAR, (group,)), group, losses=0)


def _perpendicular(scene: Scene) -> Iterator[Fact]:
    for i, j in zip(scene.axes, scene.axes[2:], strict=False):
        yield Fact(_all_pairs("perpendicular", (i, j)), Geometry.PERPENDICULAR, (i, j), losses=0)


def _meet(scene: Scene, joints: tuple[int, ...]) -> bool:
    return set(joints) <= set(scene.axes) and bool(scene.common_point(joints)[1].all())


def _is_ur_type(structure: Structure) -> bool:
    """Axes 2, 3, 4 parallel, axes 5 and 6 meeting, at every configuration."""
    triple = (1, 2, 3) in structure.bundles
    return triple and {4, 5} <= set(structure.scene.axes) and structure.always(lambda s: s.meeting(4, 5))


def _shoulder_plane(structure: Structure) -> Plane | None:
    """The plane through axis 1 along axis 2, where it decides: axes 1, 2 meet, or axes 2, 3 are parallel."""
    if not {0, 1} <= set(structure.scene.axes) or structure.always(lambda s: s.parallel[0, 1]):
        return None
    if structure.always(lambda s: s.meeting(0, 1)):
        return Plane.OF_BOTH
    if any({1, 2} <= set(bundle) for bundle in structure.bundles):
        return Plane.PARALLEL
    return None


def _reach_stationary(structure: Structure, scene: Scene, at: tuple[int, ...] = ()) -> Verdicts:
    """Whether no joint before the wrist changes the distance from shoulder to wrist centre, or to the point `at`."""
    shoulder, wrist = scene.common_point(structure.shoulder)[0], scene.common_point(at or structure.wrist)[0]
    line = (wrist - shoulder) / scene.length
    # velocity of the wrist centre, v + ω × W, for every joint
    velocity = scene.screws[:, :3] + np.cross(scene.screws[:, 3:], wrist[..., None], axis=1)
    rate = np.einsum("ni,nij->nj", line, velocity)[:, : at[0] if at else None] / scene.length
    return np.asarray((np.abs(rate) < 1e-6).all(axis=1))


def _all_pairs(question: str, group: Sequence[int]) -> Callable[[Scene], Verdicts]:
    return lambda scene: np.asarray(getattr(scene, question)[group[0], list(group[1:])].all(axis=0))


def _coplanar(axes: tuple[int, ...]) -> Callable[[Scene], Verdicts]:
    return lambda scene: scene.coplanar(axes)


def _fan(axes: tuple[int, ...]) -> Callable[[Scene], Verdicts]:
    def holds(scene: Scene) -> Verdicts:
        aligned = np.stack([scene.aligned[i, j] for i, j in combinations(axes, 2)]).any(axis=0)
        return scene.coplanar(axes) & ~aligned

    return holds


def _centre_on(structure: Structure, i: int) -> Callable[[Scene], Verdicts]:
    def holds(scene: Scene) -> Verdicts:
        centre = structure.centre(scene)
        if centre is None:
            return np.zeros(len(scene.q), dtype=bool)
        return scene.on_axis(centre, i)

    return holds


def _in_shoulder_plane(point: Callable[[Scene], Array | None]) -> Callable[[Scene], Verdicts]:
    def holds(scene: Scene) -> Verdicts:
        at = point(scene)
        if at is None:
            return np.zeros(len(scene.q), dtype=bool)
        return scene.in_plane(at, 0, scene.z[1]) & ~scene.on_axis(at, 1)  # on axis 2 is a fact of its own

    return holds
