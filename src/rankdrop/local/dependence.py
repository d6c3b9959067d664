"""What axes and slides that depend on each other have in common: the pattern of a circuit.

The patterns follow Paden and Sastry (two collinear axes, three parallel coplanar ones, four that meet in a point, four
in a plane, a slide normal to the plane of two parallel axes, six that meet a line), and what these leave out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from rankdrop.kinematics import task_jacobian
from rankdrop.local.axes import Scene, inner_product
from rankdrop.robot.model import Array
from rankdrop.robot.transform import cross
from rankdrop.sections import words_of
from rankdrop.task import Task, six_rows
from rankdrop.tolerances import ALIGNED


class Common(StrEnum):
    """The pattern of dependent axes and slides."""

    MOVES_NOTHING = "moves nothing"
    DEPENDENT_SCREWS = "dependent screws"
    DEPENDENT_JOINTS = "dependent joints"
    ALIGNED = "aligned"
    PARALLEL = "parallel"
    CONCURRENT = "concurrent"
    COPLANAR = "coplanar"
    PARALLEL_AND_COPLANAR = "parallel and coplanar"
    CONCURRENT_AND_COPLANAR = "concurrent and coplanar"
    IN_ONE_PLANE_WITH_TIP = "in one plane with tip"
    PARALLEL_TO_ONE_PLANE = "parallel to one plane"
    ALL_TRANSLATIONS = "all translations"
    MEET_ONE_LINE = "meet one line"


class SlideWay(StrEnum):
    """How slides lie to axes that they depend on with."""

    NORMAL_TO_AXES = "normal to them"
    NORMAL_TO_PLANE = "normal to their plane"
    ALONG_TRANSLATION = "along their translation"
    NORMAL_TO_LINE = "normal to it"


@dataclass(frozen=True, slots=True)
class Dependence:
    """A minimal dependent set of joint screws.

    Attributes:
        common: its pattern.
        joints: from 0: its axes, or all members where there is no pattern or there are slides alone.
        slides: from 0, where axes and slides depend on each other, and how these lie.
        way: of these slides.
        sliding: the members are slides.
    """

    common: Common
    joints: tuple[int, ...]
    slides: tuple[int, ...] = ()
    way: SlideWay | None = None
    sliding: bool = False

    def __str__(self) -> str:
        """In words: "axes 1, 4, 5 concurrent and coplanar"."""
        words: str = words_of(self).dependence_words(self)
        return words


def describe(scene: Scene, circuit: tuple[int, ...], task: Task) -> str:
    """A circuit in words: see `dependence_of`."""
    return str(dependence_of(scene, circuit, task))


def dependence_of(scene: Scene, circuit: tuple[int, ...], task: Task) -> Dependence:
    """The pattern of the axes and slides of a circuit at every configuration of the scene.

    In the full pose two dependent axes are one line; three lie in one plane and meet in one point or are parallel; four
    that all meet, are all parallel or lie in one plane span a system of rank 3.

    Args:
        scene: one or more configurations.
        circuit: indices of joints from 0, a minimal dependent set at every configuration of the scene.
        task: the rows that are dependent.
    """
    if len(circuit) == 1:
        return Dependence(Common.MOVES_NOTHING, circuit)
    axes = [i for i in circuit if i in scene.axes]
    slides = [i for i in circuit if scene.slides[i]]
    if len(axes) + len(slides) == len(circuit):
        pattern = _pattern(scene, axes, slides, task)
    else:
        pattern = None
    if pattern is not None:
        return pattern
    if task.m == 6:
        return Dependence(Common.DEPENDENT_SCREWS, circuit)
    return Dependence(Common.DEPENDENT_JOINTS, circuit)


def line_meets_all(scene: Scene, task: Task) -> bool:
    """Is there a line that meets every axis (or is parallel to it) at every point of the scene?

    The blocked wrench (f; τ) of a corank-1 point, f·v_i + τ·ω_i = 0 for every joint, is a pure force along that line
    when its pitch f·τ/|f|² is zero: a force does no work on a rotation about an axis it meets. In a task without
    rotation the wrench is always a force, through the tip.
    """
    jacobians = task_jacobian(scene.robot, scene.q, task)
    if len(scene.axes) < scene.robot.n:
        return False
    left = np.linalg.svd(jacobians)[0][..., -1]  # (N, m)
    return _pure_force(six_rows(left, task))


def _pattern(scene: Scene, axes: Sequence[int], slides: Sequence[int], task: Task) -> Dependence | None:
    """What dependent axes and slides have in common; None without a pattern."""
    if task.m == 6:
        if not axes:
            how = (Common.PARALLEL, Common.PARALLEL_TO_ONE_PLANE, Common.ALL_TRANSLATIONS)[len(slides) - 2]
            return Dependence(how, tuple(slides), sliding=True)
        if slides:
            special = _translations_twice(scene, axes, slides)
        else:
            special = _three_dimensions(scene, axes)
        return special or _transversal(scene, axes, slides)
    if slides:
        return None
    if max(task.rows) < 3:  # planes through the tip count
        if len(axes) == 2 and scene.coplanar(axes, scene.tip).all():
            return Dependence(Common.IN_ONE_PLANE_WITH_TIP, tuple(axes))
        return None
    if min(task.rows) >= 3:
        return _of_directions(scene, axes)
    return None


def _of_directions(scene: Scene, axes: Sequence[int]) -> Dependence | None:
    """What the directions of dependent axes have in common, where the task asks for orientations alone."""
    if len(axes) == 2 and _parallel(scene, axes):
        return Dependence(Common.PARALLEL, tuple(axes))
    if len(axes) == 3:
        volume = inner_product(scene.z[axes[0]], cross(*scene.z[axes[1:]]))
        if (np.abs(volume) < ALIGNED).all():
            return Dependence(Common.PARALLEL_TO_ONE_PLANE, tuple(axes))
    return None


def _three_dimensions(scene: Scene, axes: Sequence[int]) -> Dependence | None:
    """Axes alone: parallel, concurrent or coplanar ones have rank 3, so that no circuit of them has more than four."""
    if len(axes) == 2:
        return Dependence(Common.ALIGNED, tuple(axes))
    if len(axes) > 4:
        return None
    if _parallel(scene, axes):
        kinds = (Common.PARALLEL_AND_COPLANAR, Common.PARALLEL)
    elif scene.common_point(axes)[1].all():
        kinds = (Common.CONCURRENT_AND_COPLANAR, Common.CONCURRENT)
    elif len(axes) == 4 and scene.coplanar(axes).all():
        return Dependence(Common.COPLANAR, tuple(axes))
    else:
        return None
    return Dependence(kinds[len(axes) - 3], tuple(axes))


def _translations_twice(scene: Scene, axes: Sequence[int], slides: Sequence[int]) -> Dependence | None:
    """Axes and slides: turning forth and back about parallel axes is a translation, and the slides make it too."""
    if not _parallel(scene, axes):
        return None
    normal = all(scene.perpendicular[axes[0], i].all() for i in slides)
    if normal:
        way = SlideWay.NORMAL_TO_AXES
    else:
        way = SlideWay.ALONG_TRANSLATION
    if len(axes) == 2 and len(slides) == 1:
        way = SlideWay.NORMAL_TO_PLANE
    return Dependence(Common.PARALLEL, tuple(axes), tuple(slides), way)


def _transversal(scene: Scene, axes: Sequence[int], slides: Sequence[int]) -> Dependence | None:
    """Six axes that meet one line; a line at infinity is met by axes and slides parallel to one plane."""
    circuit = sorted([*axes, *slides])
    if len(circuit) != 6:
        return None
    columns = scene.screws[..., circuit].transpose(0, 2, 1)
    about_tip = (columns[..., :3] + cross(columns[..., 3:], scene.tip[:, None, :])) / scene.length  # rounds least
    blocked = np.linalg.svd(np.concatenate([about_tip, columns[..., 3:]], axis=-1))[2][:, -1]
    if not _pure_force(blocked):
        return None
    if not slides:
        return Dependence(Common.MEET_ONE_LINE, tuple(axes))
    return Dependence(Common.MEET_ONE_LINE, tuple(axes), tuple(slides), SlideWay.NORMAL_TO_LINE)


def _parallel(scene: Scene, axes: Sequence[int]) -> bool:
    return bool(scene.parallel[axes[0], list(axes[1:])].all())


def _pure_force(wrench: Array) -> bool:
    """Wrenches (N, 6), moments per length scale: forces without a moment along them, and not moments alone."""
    force, moment = wrench[:, :3], wrench[:, 3:]
    pitch = np.abs(np.einsum("ni,ni->n", force, moment))
    return bool((pitch < 1e-6).all() and (np.linalg.norm(force, axis=1) > 1e-6).all())
