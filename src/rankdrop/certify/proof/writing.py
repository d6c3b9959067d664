"""Certificates made: a claim, the numbers of the arm it is about, and what a checker needs to prove it again."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.certify.ball import LARGEST, certified_radius, settings_of
from rankdrop.certify.coverfile import Plan
from rankdrop.certify.displaced import ModelTolerance, displaced_jacobian, points_of
from rankdrop.certify.enclosed import viewed
from rankdrop.certify.proof.reading import BALL, COVERING, EXISTENCE, SCHEMA, Record, sealed
from rankdrop.certify.proof.regions import FREE, LETTERS, OUTSIDE
from rankdrop.certify.setting import Setting, enclose, regular
from rankdrop.disk import replace_file
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.kinematics import one_configuration, task_jacobian
from rankdrop.local.block import generic_rank, joint_scale
from rankdrop.robot.model import Array, JointKind, Robot, fingerprint
from rankdrop.task import Task, resolve_task
from rankdrop.units import heading
from rankdrop.version import VERSION

SHARES = (0.99, 0.97, 0.94, 0.9, 0.8, 0.65, 0.5, 0.3)
"""Of the radius that is certified, the shares that a certificate claims: the first that few boxes are enough for."""
BOXES = 20_000
"""Boxes of a certificate, at most: some twenty seconds of checking."""
_SEAM = 1e-15  # corners are rounded: boxes are tested so much wider [rad]
_BATCH = 128  # boxes tested at one go, nearest first
_SIZES = 20  # boxes around the centre that are tried first, each half as wide as the one before
_NARROW = 1e-6  # boxes narrower than this are not halved [rad]
_NEAR = 1e-9  # how far from q a singular configuration is claimed at least [rad, m]


def arm_record(robot: Robot) -> Record:
    """The numbers of an arm that decide its Jacobian."""
    place = {joint.name: number for number, joint in enumerate(robot.variables, start=1)}
    joints = []
    for joint in robot.joints:
        mimic = joint.mimic
        joints.append({
            "name": joint.name, "kind": str(joint.kind), "screw": joint.screw.tolist(),
            "variable": place[mimic.leader if mimic else joint.name],
            "follows": mimic.leader if mimic else None,
            "multiplier": mimic.multiplier if mimic else 1.0, "offset": mimic.offset if mimic else 0.0,
        })  # fmt: skip
    return {
        "name": robot.name, "joints": joints, "home": robot.home.tolist(), "last": robot.joints[-1].frame.tolist(),
        "fingerprint": fingerprint(robot),
    }  # fmt: skip


def record_of(
    robot: Robot, task: Task, kind: str, setting: Setting, claim: Record, proof: Record,
    tolerance: ModelTolerance | None = None,
) -> Record:  # fmt: skip
    """A certificate with its hash."""
    frame = np.eye(4)
    if setting.link:
        frame = robot.home if setting.link > len(robot.joints) else robot.joints[setting.link - 1].frame
    point = frame[:3, :3] @ np.array(setting.point) + frame[:3, 3]
    near = None
    if tolerance is not None:
        near = {"length": tolerance.length, "angle": tolerance.angle, "points": points_of(robot).tolist()}
    return sealed({
        **heading(SCHEMA), "kind": kind, "version": VERSION, "arm": arm_record(robot),
        "task": {"name": task.name, "rows": list(task.rows), "frame": {
            "axes": task.frame.axes, "origin": task.frame.origin, "point": list(task.frame.point)}},
        "rank": setting.rank,
        "view": {"link": min(setting.link, len(robot.joints)), "point": point.tolist(), "length": setting.length},
        "tolerance": near, "claim": claim, "proof": proof,
    })  # fmt: skip


def write_certificate(record: Record, path: str | Path) -> Path:
    """Write a certificate, all or nothing.

    Raises:
        ResultFileError: it cannot be written.
    """
    place = Path(path)
    try:
        replace_file(place, (json.dumps(record, allow_nan=False) + "\n").encode())
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ResultFileError(f"cannot write: {reason}", where=str(path)) from error
    return place


def ball_certificate(
    robot: Robot,
    q: ArrayLike,
    task: str | Task | None = None,
    *,
    radius: float | None = None,
    tolerance: ModelTolerance | None = None,
    evaluations: int = 100_000,
) -> Record:
    """A certificate that no configuration within a radius of q is singular, with the boxes that show it.

    Args:
        robot: the arm.
        q: (n,) centre [rad, m].
        task: as everywhere.
        radius: to be proven [rad; slides divided by the length scale]; None: nearly as much as can be, with few boxes.
        tolerance: the ball is free for every arm so near to this one.
        evaluations: budget of the search for the radius.

    Raises:
        ConfigurationError: q is not one configuration of the arm.
        OptionError: nothing, or not so much, can be proven; a task or a tolerance that cannot be.
    """
    centre, resolved = one_configuration(robot, q), resolve_task(task, robot)
    if radius is not None and not 0.0 < radius <= LARGEST:
        raise OptionError("no such radius", where="radius", got=radius, allowed="in (0, π]")
    found = certified_radius(
        robot, centre, resolved, evaluations=evaluations, at_most=LARGEST if radius is None else radius
    )
    setting, most = found.setting, found.radius
    if tolerance is not None:
        most = max(most, 1e-12)
        spend = evaluations if radius is None else evaluations // 4  # where a radius is given the setting counts alone
        setting, most = _with_tolerance(robot, resolved, centre, tolerance, most, spend)
    test = _Test(robot, setting, resolved.rows, centre, tolerance)
    if radius is None and most < 1e-5:  # nothing to be halved any more
        raise OptionError("no ball around q is proven to be free: it is singular, or so nearly that the arms within "
                          "the tolerance may be" if tolerance else "no ball around q is proven to be free: it is "
                          "singular, or nearly", where="q", got=f"a radius of {most:.3g}")  # fmt: skip
    for share in SHARES if radius is None else (1.0,):
        wanted = most * share if radius is None else radius
        tree = tree_of(test, wanted, BOXES if share > SHARES[-1] else 50 * BOXES)
        if tree is not None:
            claim = {"q": centre.tolist(), "radius": wanted, "scale": setting.scale.tolist()}
            return record_of(robot, resolved, BALL, setting, claim, {"side": wanted, "tree": tree}, tolerance)
    raise OptionError("this radius is not proven to be free", where="radius", got=radius,
                      allowed=f"at most {most:.6g} is")  # fmt: skip


def _with_tolerance(
    robot: Robot, task: Task, q: Array, tolerance: ModelTolerance, at_most: float, evaluations: int
) -> tuple[Setting, float]:
    """The setting and the radius: every setting is tried with a fortieth of the budget, the best with all."""
    settings = settings_of(robot, task)
    tried = [free_radius(_Test(robot, one, task.rows, q, tolerance), at_most, evaluations // 40) for one in settings]
    best = settings[int(np.argmax(tried))]
    return best, free_radius(_Test(robot, best, task.rows, q, tolerance), at_most, evaluations)


@dataclass(frozen=True, eq=False)
class _Test:
    """Boxes around one configuration, offsets in units of motion."""

    robot: Robot
    setting: Setting
    rows: tuple[int, ...]
    q: Array
    tolerance: ModelTolerance | None

    @property
    def places(self) -> NDArray[np.int64]:
        """Variables that matter."""
        return np.flatnonzero(self.setting.matters)

    def free(self, centre: Array, half: Array) -> NDArray[np.bool_]:
        """(M,) which boxes (M, d) are proven free."""
        n, places, scale = self.robot.n, self.places, np.asarray(self.setting.scale)
        q, wide = np.tile(self.q, (len(centre), 1)), np.zeros((len(centre), n))
        q[:, places] += centre * scale[places]
        wide[:, places] = half * (1 + 1e-12) + _SEAM * (1.0 + np.abs(q[:, places]) / scale[places])
        found = enclose(self.robot, self.setting, q, wide)
        if self.tolerance is None:
            return np.asarray(found[0] != 0)
        far = np.abs(q) + wide * scale
        drift = displaced_jacobian(self.robot, self.setting, self.tolerance, self.rows, far)
        extra = np.einsum("bi,bij->bj", drift, np.abs(found[5]))
        return regular(found[3], found[2] + extra[:, None, :])


def free_radius(test: _Test, at_most: float, evaluations: int) -> float:
    """How far from the centre the nearest box is that is not proven free when the budget ends, boxes nearest first."""
    d = len(test.places)
    sizes = at_most * 0.5 ** np.arange(_SIZES)
    whole = test.free(np.zeros((_SIZES, d)), np.repeat(sizes[:, None], d, axis=1))
    least = float(sizes[whole].max(initial=0.0))  # of one box alone: what a small budget is sure of
    centre, half = np.zeros((1, d)), np.full((1, d), at_most)
    gap = np.zeros(1)
    spent, stuck = _SIZES, at_most
    while len(centre):
        order = np.argsort(gap, kind="stable")
        now, later = order[:_BATCH], order[_BATCH:]
        if gap[now[0]] >= stuck:
            break
        spent += len(now)
        if spent > evaluations:
            return max(least, min(stuck, float(gap.min())))
        left = now[~test.free(centre[now], half[now])]
        narrow = half[left].max(axis=1) < _NARROW
        stuck = min(stuck, *gap[left[narrow]].tolist(), np.inf)
        middle, width = _halved(centre[left[~narrow]], half[left[~narrow]])
        centre, half = np.concatenate([centre[later], middle]), np.concatenate([half[later], width])
        gap = np.linalg.norm(np.maximum(0.0, np.abs(centre) - half), axis=1)
        inside = gap < stuck
        centre, half, gap = centre[inside], half[inside], gap[inside]
    return max(least, stuck)


def _halved(centre: Array, half: Array) -> tuple[Array, Array]:
    """Both halves of boxes along their widest variable, the first of them where several are."""
    axis = np.argmax(half, axis=1)
    rows = np.arange(len(centre))
    width = half.copy()
    width[rows, axis] /= 2
    low, high = centre.copy(), centre.copy()
    low[rows, axis] -= width[rows, axis]
    high[rows, axis] += width[rows, axis]
    return np.concatenate([low, high]), np.concatenate([width, width])


def tree_of(test: _Test, radius: float, boxes: int) -> str | None:
    """The boxes that cover a ball, as a tree in preorder; None where one is not free or there are too many.

    A box outside the ball is told so only where it is so beyond rounding: the checker computes it exactly.
    """
    letters = [LETTERS[j] for j in test.places]
    d = len(letters)
    centre, half = np.zeros((1, d)), np.full((1, d), radius)
    number = np.zeros(1, dtype=np.int64)  # of each open box in `said`
    said: list[str] = [""]
    below: list[tuple[int, int] | None] = [None]
    count = 0
    while len(centre):
        gap = np.linalg.norm(np.maximum(0.0, np.abs(centre) - half), axis=1)
        outside = gap > radius * (1 + 1e-9)
        free = np.zeros(len(centre), dtype=np.bool_)
        for begin in range(0, len(centre), 1 << 14):
            part = np.flatnonzero(~outside)[begin : begin + (1 << 14)]
            free[part] = test.free(centre[part], half[part])
        count += int(free.sum())
        for node in number[outside].tolist():
            said[node] = OUTSIDE
        for node in number[free].tolist():
            said[node] = FREE
        left = ~outside & ~free
        if count + int(left.sum()) > boxes or (half[left] < _NARROW).all(axis=1).any():
            return None
        axis, open_ = np.argmax(half[left], axis=1), number[left]
        middle, width = _halved(centre[left], half[left])
        begin, size = len(said), int(left.sum())
        for k, (node, along) in enumerate(zip(open_.tolist(), axis.tolist(), strict=True)):
            said[node], below[node] = letters[along], (begin + k, begin + size + k)
        said += [""] * (2 * size)
        below += [None] * (2 * size)
        number = np.arange(begin, len(said))
        centre, half = middle, width
    out, stack = [], [0]
    while stack:
        node = stack.pop()
        out.append(said[node])
        children = below[node]
        if children is not None:
            stack += [children[1], children[0]]
    return "".join(out)


def covering_certificate(robot: Robot, plan: Plan, sha256: str, file: str, task: Task) -> Record:
    """A certificate that every configuration in no box of a covering has the generic rank, or one less than its corank.

    Args:
        robot: the arm.
        plan: of the covering.
        sha256: its hash.
        file: name of the file that holds it, beside the certificate.
        task: that it is about.
    """
    claim = {
        "file": file, "sha256": sha256, "variables": list(plan.variables), "lower": list(plan.lower),
        "upper": list(plan.upper), "turns": list(plan.turns), "limits": plan.limits, "corank": plan.corank,
    }  # fmt: skip
    return record_of(robot, task, COVERING, viewed(robot, task, plan.corank), claim, {})


def existence_certificate(
    robot: Robot, q: ArrayLike, task: str | Task | None = None, *, radius: float = _NEAR
) -> Record:
    """A certificate that a configuration of lower rank exists within a radius of q, joint by joint.

    Args:
        robot: the arm.
        q: (n,) singular to rounding [rad, m].
        task: as everywhere.
        radius: of the box [rad, m].

    Raises:
        ConfigurationError: q is not one configuration of the arm.
        OptionError: q is not singular, or nothing moves for this task.
    """
    centre, resolved = one_configuration(robot, q), resolve_task(task, robot)
    setting = _setting_of(robot, resolved)
    sigma = np.linalg.svd(task_jacobian(robot, centre[None], resolved)[0], compute_uv=False)
    if not sigma[setting.rank - 1] <= 1e-6 * sigma[0]:
        raise OptionError("q is not singular", where="q", got=f"σ{setting.rank} = {sigma[setting.rank - 1]:.3g}",
                          mend="give the singular configuration that `rankdrop nearest` finds")  # fmt: skip
    slides = [joint.kind is JointKind.PRISMATIC for joint in robot.variables]
    claim = {"q": centre.tolist(), "radius": radius * (max(1.0, setting.length) if any(slides) else 1.0)}
    return record_of(robot, resolved, EXISTENCE, setting, claim, {})


def _setting_of(robot: Robot, task: Task) -> Setting:
    """Where an existence is looked at from; of a task of some rows, which no region can be certified for, the tip.

    Raises:
        OptionError: nothing moves for this task, or the arm cannot be certified at all.
    """
    rank = generic_rank(robot, task)
    some = any(0 < len(set(block) & set(task.rows)) < 3 for block in ((0, 1, 2), (3, 4, 5)))
    try:
        return viewed(robot, task)
    except OptionError:
        if not (some and rank):
            raise
        count = len(robot.joints)
        point = robot.joints[-1].frame[:3, :3].T @ (robot.home[:3, 3] - robot.joints[-1].frame[:3, 3])
        return Setting(
            count, (float(point[0]), float(point[1]), float(point[2])), task.scale(robot), task.rows, rank,
            np.zeros(count), joint_scale(robot, task), np.ones(robot.n, dtype=np.bool_), 1.0,
        )  # fmt: skip
