"""Where a certificate looks at an arm from: a link in the middle, a point on it, a length for the translation rows.

And the test that ends every proof made from there: is a matrix regular, however its entries may be off?

The rank of the full twist does not depend on axes or reference point. Seen from link c, column i depends only on the
joints between axis i and that link, so the derivative bounds are short, and the first and the last joint drop out.

The translation of a point depends on the point, not on axes: it is seen from the first link that carries the point.
Where the last axis goes through it, as through the flange of most arms, the last joint drops out as well.

The rank of some rows in tool axes (a tool that may turn about its own axis) depends on them: these rows are seen from
the last link, in the axes of the tip, at the task's own point. Only the first joint drops out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.errors import OptionError
from rankdrop.kinematics import chain_of, jacobian
from rankdrop.local.block import generic_rank, joint_scale, sample
from rankdrop.robot.arm_reach import nearest, reach
from rankdrop.robot.model import Array, Joint, Robot, once
from rankdrop.robot.numbers import feet
from rankdrop.robot.transform import dot, norm
from rankdrop.task import TIP, Task

_ABSENT = 1e-12  # rows of the Jacobian below this share of its size at random configurations are zero for this arm
_LENGTHS = (0.1, 0.2, 0.4)  # lengths tried for the translation rows, in lengths of the arm
_ON_AXIS = 1e-13  # share of the size of the arm: a point so near to an axis is on it
_TRIED = 200  # random configurations at which settings are compared
_MOST_JOINTS = 32  # what the core keeps room for


@dataclass(frozen=True, eq=False)
class Setting:
    """One way to look at an arm for a certificate.

    Attributes:
        link: joints 1 … link come before it, the others after.
        point: (3,) reference point in the frame of that link [m].
        length: translation rows are divided by it [m].
        rows: of the twist.
        rank: the rank that must be kept: the generic one.
        arm: (N,) reach from the axis of each joint to the point, along a polygon from axis to axis; the travel of
            slides is added by the core [m].
        scale: (n,) unit of motion of each variable (`joint_scale`).
        matters: (n,) False for variables on which no column depends.
        repeats: square root of the largest number of joints that one variable drives.
        tool: the axes are those of the tip, and `point` is in its frame; the link is the last one, which carries it.
    """

    link: int
    point: tuple[float, float, float]
    length: float
    rows: tuple[int, ...]
    rank: int
    arm: Array
    scale: Array
    matters: NDArray[np.bool_]
    repeats: float
    tool: bool = False

    def with_tip_frame(self, robot: Robot) -> Robot:
        """The arm whose link frames the view is in: with `tool`, the frame of its last link is that of the tip."""
        if self.tool:
            return _with_tip_in_last_link(robot)
        return robot

    def chain(self, robot: Robot) -> _core.Chain:
        """The chain that the view belongs to."""
        return chain_of(self.with_tip_frame(robot))

    def view(self, robot: Robot) -> _core.View:
        """The view the core works in."""
        factors = [1.0 / self.length if row < 3 else 1.0 for row in self.rows]
        return _core.make_view(
            self.chain(robot), axes=self.link, origin=self.link, point=list(self.point), rows=list(self.rows),
            factors=factors,
        )  # fmt: skip

    def home_point(self, robot: Robot) -> Array:
        """(3,) the point at q = 0 in base coordinates [m]."""
        frame = frames_of(self.with_tip_frame(robot))[self.link]
        return np.asarray(frame[:3, :3] @ np.array(self.point) + frame[:3, 3])

    def core_settings(self, radius: float) -> _core.EnclosureSettings:
        """What the core is told besides, balls up to `radius` (scaled)."""
        return _core.EnclosureSettings(
            rank=self.rank, length=self.length, radius=radius, repeats=self.repeats, scale=self.scale, arm=self.arm
        )


@once
def settings_for(robot: Robot, task: Task) -> tuple[Setting, ...]:
    """Every setting worth trying for an arm and a task.

    The point of a translation is seen from the first link in which it stands still.

    Raises:
        OptionError: the task takes only some rows of translation or rotation, in other axes than those of the tool, and
            the others do not vanish for this arm: then its rank depends on the axes, and nothing is certified. Or the
            arm does not move for this task at all, has too many joints, or a link frame that is no rigid transform.
    """
    return _settings(robot, task, near=False)


@once
def settings_for_near_arms(robot: Robot, task: Task) -> tuple[Setting, ...]:
    """`settings_for` arms near this one, of which no axis goes through the point: the last link carries it.

    Raises:
        OptionError: as `settings_for`.
    """
    return _settings(robot, task, near=True)


def _settings(robot: Robot, task: Task, *, near: bool) -> tuple[Setting, ...]:
    rows = _whole_rows(robot, task)
    rank = generic_rank(robot, task)
    _check(robot, task, rank)
    if rows is None:
        return _of_tool_rows(robot, task, rank)
    settings = []
    size = _size(robot)
    for link, home in _viewpoints(robot, task, rows, near=near):
        frame = frames_of(robot)[link]
        point = frame[:3, :3].T @ (home - frame[:3, 3])
        arm = _arms(robot, link, home)
        if rows == (0, 1, 2):  # joints behind the link have no columns
            moved, repeats = _moving_variables(robot, link, link)
        else:
            moved, repeats = _moving_variables(robot, link, len(robot.joints))
        for share in _LENGTHS if len(rows) == 6 else (1.0,):
            settings.append(
                Setting(
                    link, (float(point[0]), float(point[1]), float(point[2])), share * size, rows, rank, arm,
                    joint_scale(robot, task), moved, repeats,
                )
            )  # fmt: skip
    return tuple(settings)


def setting_at_tip(robot: Robot, task: Task) -> Setting:
    """The setting whose Jacobian is that of the task itself, but for a rotation of its axes: it has the task's σ.

    Raises:
        OptionError: as `settings_for`; or the reference point of the task is not carried by the tip.
    """
    rows = _whole_rows(robot, task)
    rank = generic_rank(robot, task)
    _check(robot, task, rank)
    link = len(robot.joints)
    if task.frame.origin not in (TIP, link + 1):
        raise OptionError("the reference point of the task is not carried by the tip", got=task.frame,
                          allowed="a point of the tip")  # fmt: skip
    matters, repeats = _moving_variables(robot, link, link)
    tip = robot.home[:3, 3] + robot.home[:3, :3] @ np.array(task.frame.point)
    return Setting(
        link, task.frame.point, task.scale(robot), task.rows if rows is None else rows, rank, _arms(robot, link, tip),
        joint_scale(robot, task), matters, repeats, tool=True,
    )  # fmt: skip


def _check(robot: Robot, task: Task, rank: int) -> None:
    if rank == 0:
        raise OptionError("no joint moves anything this task takes: there is no rank to lose", got=task.name)
    if len(robot.joints) > _MOST_JOINTS:
        raise OptionError("too many joints for a certificate", got=len(robot.joints), allowed=f"at most {_MOST_JOINTS}")
    for joint in robot.joints:  # the derivatives hold in axes at right angles only
        turn = joint.frame[:3, :3]
        if np.abs(turn.T @ turn - np.eye(3)).max() > 1e-12:
            raise OptionError(
                "the frame of a link is not a rigid transform", where=f"joint {joint.name!r}", got=turn.tolist(),
                mend="make its rotation orthonormal",
            )  # fmt: skip


def _of_tool_rows(robot: Robot, task: Task, rank: int) -> tuple[Setting, ...]:
    """Settings of rows in tool axes: at the task's point, lengths differ."""
    link = len(robot.joints)
    matters, repeats = _moving_variables(robot, link, link)
    scale, point = joint_scale(robot, task), task.frame.point
    tip = robot.home[:3, 3] + robot.home[:3, :3] @ np.array(point)
    mixed = min(task.rows) < 3 <= max(task.rows)
    size, arm = _size(robot), _arms(robot, link, tip)
    return tuple(
        Setting(link, point, share * size, task.rows, rank, arm, scale, matters, repeats, tool=True)
        for share in (_LENGTHS if mixed else (1.0,))
    )


@once
def _with_tip_in_last_link(robot: Robot) -> Robot:
    """The same arm, the frame of the last link being that of the tip: the same screws, another frame to look from."""
    return replace(robot, joints=(*robot.joints[:-1], replace(robot.joints[-1], frame=robot.home)))


def _in_tool_axes(robot: Robot, task: Task) -> bool:
    """Are the rows taken in the axes of the tip, at a point of the tip?"""
    tips = (TIP, len(robot.joints) + 1)
    return task.frame.axes in tips and task.frame.origin in tips


def _whole_rows(robot: Robot, task: Task) -> tuple[int, ...] | None:
    """Rows of the task, with those added that are zero for this arm, so that whole blocks come out.

    None for rows in tool axes, which are judged as they are.

    Raises:
        OptionError: neither.
    """
    blocks = [block for block in ((0, 1, 2), (3, 4, 5)) if set(block) & set(task.rows)]
    rows = tuple(row for block in blocks for row in block)
    missing = [row for row in rows if row not in task.rows]
    if missing:
        full = jacobian(robot, sample(robot, task, 16, seed=5), task.frame)
        if np.abs(full[:, missing]).max() > _ABSENT * np.abs(full).max():
            if _in_tool_axes(robot, task):
                return None
            raise OptionError(
                "no region can be certified for a task that takes some rows of translation or of rotation only, in "
                "axes that the tool does not carry", got=task.name,
                allowed="pose, position, orientation, rows in tool axes (tool-axis-free, across-tool-axis), or rows "
                        "that are the only ones the arm moves",
            )  # fmt: skip
    if rows == (0, 1, 2) and task.frame.origin not in (TIP, len(robot.joints)):
        raise OptionError("no region can be certified for a point that is not fixed in the last link", got=task.frame)
    return rows


def frames_of(robot: Robot) -> list[Array]:
    """(4, 4) poses at q = 0 of the base, of the frame of every link, and of the tip."""
    return [np.eye(4), *(joint.frame for joint in robot.joints), robot.home]


def _viewpoints(
    robot: Robot, task: Task, rows: tuple[int, ...], *, near: bool
) -> Iterator[tuple[int, Array]]:
    """(link, point at q = 0 in base coordinates). Without rotation rows the point is that of the task."""
    joints = len(robot.joints)
    if rows == (0, 1, 2):
        if task.frame.origin == TIP:
            carrier = robot.home
        else:
            carrier = robot.joints[-1].frame
        point = carrier[:3, :3] @ np.array(task.frame.point) + carrier[:3, 3]
        if near:
            yield joints, point
        else:
            yield _carrying_link(robot, point), point
        return
    if joints == 1:
        yield 1, robot.home[:3, 3]
        return
    middle = middle_of(robot)
    for link in range(1, joints):
        yield from ((link, point) for point in _points_between(robot.joints[link - 1 : link + 1], middle))


def _carrying_link(robot: Robot, point: Array) -> int:
    """The first link in which a point of the last one stands still: the joints behind it turn about axes through it.

    Their columns are zero, and they move no other column. A point that is off by rounding moves less than the allowance
    for rounding covers.

    Args:
        robot: the arm.
        point: (3,) at q = 0 in base coordinates [m].
    """
    drivers = robot.drivers
    size = reach(robot)
    link = len(robot.joints)
    while link > 1:
        joint = robot.joints[link - 1]
        turns = not joint.slides and joint.pitch == 0.0 and drivers.count(drivers[link - 1]) == 1
        if not turns or norm(nearest((joint.axis, joint.foot), point) - point) > _ON_AXIS * size:
            break
        link -= 1
    return link


def middle_of(robot: Robot) -> Array:
    """A point amid the axes that does not move with the tool: the mean of the feet of their common perpendiculars."""
    lines = [(joint.axis, joint.foot) for joint in robot.joints if not joint.slides]
    middles = []
    for place, a in enumerate(lines):
        for b in lines[:place]:
            if abs(dot(a[0], b[0])) < 0.99:
                middles.append(np.mean(feet(a, b), axis=0))
    if middles:
        return np.asarray(np.mean(middles, axis=0))
    return robot.home[:3, 3]


def _size(robot: Robot) -> float:
    """Length from the first axis to the last; with slides, or where it is zero, the reach [m]."""
    if any(joint.slides for joint in robot.joints):
        return reach(robot)
    last = robot.joints[-1]
    start = nearest((last.axis, last.foot), middle_of(robot))
    total = float(_arms(robot, len(robot.joints), start)[0])
    if total > 1e-6 * reach(robot):
        return total
    return reach(robot)


def _points_between(joints: Sequence[Joint], middle: Array) -> list[Array]:
    """Points of the common normal of two axes: on the one, on the other, between; slides have no axis."""
    lines = [(joint.axis, joint.foot) for joint in joints if not joint.slides]
    if len(lines) < 2:
        return [nearest(lines[0], middle) if lines else middle]
    before, after = lines
    if 1.0 - dot(before[0], after[0]) ** 2 < 1e-9:  # parallel
        first = nearest(before, middle)
        second = nearest(after, first)
    else:
        first, second = feet(before, after)
    if norm(first - second) < 1e-9:
        return [first]
    return [first, second, (first + second) / 2]


def _arms(robot: Robot, link: int, home: Array) -> Array:
    """(N,) length of the polygon from the point to each axis, from axis to axis at q = 0."""
    arm = np.zeros(len(robot.joints))
    for order in (range(link, len(robot.joints)), range(link - 1, -1, -1)):
        at, total = home, 0.0
        for i in order:
            joint = robot.joints[i]
            if not joint.slides:
                point = nearest((joint.axis, joint.foot), at)
                size = float(np.linalg.norm(point) + np.linalg.norm(at))  # rounding is of this size, not of the length
                total += float(np.linalg.norm(point - at)) * (1 + 1e-12) + 1e-14 * size
                at = point
            arm[i] = total
    return arm


def _moving_variables(robot: Robot, link: int, count: int) -> tuple[NDArray[np.bool_], float]:
    """(n,) whether any column depends on a variable; and √ of the largest number of joints driven by one.

    Columns are those of the first `count` joints.
    """
    drivers = robot.drivers
    matters = np.zeros(robot.n, dtype=np.bool_)
    matters[[*drivers[1:link], *drivers[link : count - 1]]] = True
    return matters, float(np.sqrt(max(map(drivers.count, drivers))))


def enclose(
    robot: Robot, setting: Setting, q: Array, half: Array | None = None, *, radius: float = 3.2, threads: int = 0
) -> tuple[NDArray[np.int8], Array, Array, Array, Array, Array, Array]:
    """The core's enclosure of boxes (half (B, n) given, scaled) or balls around q (B, n).

    Returns:
        free (B,), radius (B,), bound B (B, r, r), Σ (B, r), U₁ (B, m, r), V₁ (B, n, r), M (B, N); see enclosure.hpp.
    """
    settings = setting.core_settings(radius)
    return _core.enclose(setting.chain(robot), setting.view(robot), q, half, settings, threads=threads)


def best_setting(robot: Robot, task: Task, corank: int = 1) -> Setting:
    """The setting that certifies the largest balls at random configurations.

    Args:
        robot, task: the arm and what it does.
        corank: that must not be reached in a ball: the setting's rank is the one that is kept then.

    Raises:
        OptionError: the arm or the task cannot be certified.
    """
    settings = [replace(setting, rank=setting.rank - corank + 1) for setting in settings_for(robot, task)]
    q = sample(robot, task, _TRIED, seed=7)
    sizes = [float(np.median(enclose(robot, setting, q)[1])) for setting in settings]
    return settings[int(np.argmax(sizes))]


def regular(sigma: Array, bound: Array) -> NDArray[np.bool_]:
    """(P,) is Σ + E regular for every |E| ≤ bound: is the matrix with Σ_ii − B_ii and −B_ij an M-matrix?

    It is one if it maps some positive vector to a positive one; the vector is found by elimination and multiplied out.

    Example:
        >>> sigma, half = np.ones((1, 2)), np.full((1, 2, 2), 0.5)
        >>> bool(regular(sigma, 0.99 * half)[0]), bool(regular(sigma, half)[0])
        (True, False)
    """
    rank = sigma.shape[1]
    matrix = -bound
    matrix[:, np.arange(rank), np.arange(rank)] += sigma
    ok = np.asarray(np.isfinite(matrix).all(axis=(1, 2)))
    rows = np.where(ok[:, None, None], matrix, np.eye(rank))
    y = np.ones((len(rows), rank))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        left = rows.copy()
        for p in range(rank):
            ok &= left[:, p, p] > 0.0
            pivot = np.where(ok, left[:, p, p], 1.0)
            for a in range(p + 1, rank):
                times = left[:, a, p] / pivot
                left[:, a] -= times[:, None] * left[:, p]
                y[:, a] -= times * y[:, p]
        for a in range(rank - 1, -1, -1):
            y[:, a] -= (left[:, a, a + 1 :] * y[:, a + 1 :]).sum(axis=1)
            y[:, a] /= np.where(ok, left[:, a, a], 1.0)
        ok = np.asarray(ok & (y > 0.0).all(axis=1) & np.isfinite(y).all(axis=1))
        y = np.where(ok[:, None], y, 1.0)
        product = np.einsum("pab,pb->pa", rows, y)
        size = np.einsum("pab,pb->pa", np.abs(rows), y)
    return np.asarray(ok & (product > 1e-14 * size).all(axis=1))
