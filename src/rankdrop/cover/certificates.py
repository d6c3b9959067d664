"""Certificates made and verified: a claim, the numbers of the arm it is about, and what a checker needs for a proof.

The checker is `rankdrop.proof`, which imports nothing of this package; here are its errors and its text.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.codec import Result
from rankdrop.cover.ball import LARGEST, ModelTolerance, certified_radius, displaced_jacobian, points_of
from rankdrop.cover.setting import Setting, best_setting, enclose, regular, settings_for_near_arms
from rankdrop.disk import replace_file
from rankdrop.errors import MissingExtraError, OptionError, ResultFileError
from rankdrop.kinematics import one_configuration, task_jacobian
from rankdrop.local.block import generic_rank, joint_scale
from rankdrop.proof.boxes import Plan
from rankdrop.proof.check import Asked, Verdict, check_certificate
from rankdrop.proof.curves import AskedPath
from rankdrop.proof.record import BALL, COVERING, EXISTENCE, SCHEMA, Record, Refused, Work, with_hash
from rankdrop.proof.regions import FREE, LETTERS, OUTSIDE
from rankdrop.robot.model import Array, Robot, fingerprint
from rankdrop.robot.transform import unmasked
from rankdrop.sections import Section, words_of
from rankdrop.task import Task, resolve_task
from rankdrop.units import heading
from rankdrop.version import VERSION

ENCLOSURES = 500_000
"""Of interval arithmetic, at most: about a millisecond each."""
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
    """The numbers of an arm that decide its Jacobian, and its limits."""
    joints = [{
        "name": joint.name, "kind": str(joint.kind), "screw": joint.screw.tolist(), "variable": driver + 1,
        "follows": joint.mimic.leader if joint.mimic else None, "multiplier": joint.multiplier, "offset": joint.offset,
        "lower": _finite(joint.lower), "upper": _finite(joint.upper),
    } for joint, driver in zip(robot.joints, robot.drivers, strict=True)]  # fmt: skip
    return {
        "name": robot.name, "joints": joints, "home": robot.home.tolist(), "last": robot.joints[-1].frame.tolist(),
        "fingerprint": fingerprint(robot),
    }  # fmt: skip


def _finite(limit: float) -> float | None:
    return limit if np.isfinite(limit) else None


def task_record(task: Task) -> Record:
    """What a task asks for, as a certificate has it."""
    frame = {"axes": task.frame.axes, "origin": task.frame.origin, "point": list(task.frame.point)}
    return {"name": task.name, "rows": list(task.rows), "frame": frame}


def record_of(
    robot: Robot, task: Task, kind: str, setting: Setting, claim: Record, proof: Record,
    tolerance: ModelTolerance | None = None,
) -> Record:  # fmt: skip
    """A certificate with its hash."""
    point = setting.home_point(robot)
    near = None
    if tolerance is not None:
        near = {"length": tolerance.length, "angle": tolerance.angle, "points": points_of(robot).tolist()}
    return with_hash({
        **heading(SCHEMA), "kind": kind, "version": VERSION, "arm": arm_record(robot), "task": task_record(task),
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
        if isinstance(error, OSError):
            reason = error.strerror
        else:
            reason = str(error)
        raise ResultFileError(f"cannot write: {reason}", where=str(path)) from error
    return place


@dataclass(frozen=True)
class Verified(Verdict, Result):
    """Result of checking a certificate, with its sections of text; true where the claim holds."""

    FILE = "verified"

    def __bool__(self) -> bool:
        return self.holds

    def sections(self) -> tuple[Section, ...]:
        """As sections of text."""
        sections: tuple[Section, ...] = words_of(self).verified_sections(self)
        return sections


@contextmanager
def refused_as_result() -> Iterator[None]:
    """Turn what the checker refuses into an error of this package.

    Raises:
        ResultFileError: a file that it refuses.
        MissingExtraError: python-flint is not installed.
    """
    try:
        yield
    except Refused as error:
        raise ResultFileError(error.what, **error.parts) from error
    except ImportError as error:
        raise MissingExtraError("python-flint", None, "checking certificates") from error


def asked_about(
    robot: Robot | None, task: str | Task | None = None, *, q: ArrayLike | None = None,
    path: str | Path | AskedPath | None = None, rows: ArrayLike | None = None, limits: bool | None = None,
) -> Asked:  # fmt: skip
    """What a certificate must be about; what is None may be anything.

    A certificate of a path holds only for a path that is given here: its curve is compared with every control point.

    Args:
        robot: the arm.
        task: of the arm.
        q: (n,) the place [rad, m].
        path: the file of a path as its reader read it (`path.path_asked`), or its name, with `rows`.
        rows: (M, n) the rows of a path, joined by straight lines [rad, m].
        limits: a covering or a change of posture within the joint limits (True), or of the whole joint space (False).

    Raises:
        OptionError: a task without an arm.
        ResultFileError: the file of the path cannot be read.
    """
    if task is not None and robot is None:
        raise OptionError("a task is that of an arm", where="task", got=task, mend="name the arm",
                          typed="name the arm with --robot")  # fmt: skip
    about = None
    if task is not None and robot is not None:
        resolved = resolve_task(task, robot)
        about = {**task_record(resolved), "scale": joint_scale(robot, resolved).tolist()}
    return Asked(
        None if robot is None else arm_record(robot), about,
        None if q is None else np.asarray(unmasked(q, "q"), dtype=np.float64),
        _path_asked(path, rows), limits,
    )  # fmt: skip


def _path_asked(path: str | Path | AskedPath | None, rows: ArrayLike | None) -> AskedPath | None:
    if isinstance(path, AskedPath):
        return path
    if rows is None:
        given = None
    else:
        given = np.asarray(unmasked(rows, "rows"), dtype=np.float64)
    if path is None:
        if given is None:
            return None
        return AskedPath("", "", given, interpolate="linear")
    return AskedPath(Path(path).name, file_hash(Path(path)), given, interpolate="linear")


def file_hash(path: Path) -> str:
    """SHA-256 of a file; 64 hex digits.

    Raises:
        ResultFileError: it cannot be read.
    """
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise ResultFileError(f"cannot read: {error.strerror}", where=str(path)) from error


def verify(
    file: str | Path,
    about: Robot | Asked | None = None,
    *,
    enclosures: int = ENCLOSURES,
    sample: int | None = None,
    every: bool = False,
    journal: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Verified:
    """Check a certificate: prove its claim again from the numbers of the arm that are in it, and state the whole claim.

    Interval arithmetic with 90 bits and rounding outwards (Arb), and other mathematics than that which made it
    (`rankdrop.proof.arm`). Of the certificate nothing is believed but the claim itself, where to look from, and how to
    cut a region into boxes; a bad choice of these proves nothing, and never something wrong.

    Args:
        file: written by `rankdrop nearest`, `path`, `cover`, `explain` or `aspects` with --certificate.
        about: the arm that the certificate must be about, or all that is asked (`asked_about`); None: the arm whose
            numbers are in it.
        enclosures: to be spent at most, about a millisecond each.
        sample: of a covering, only so many of the boxes it leaves out; then nothing is confirmed, but a box may fail.
        every: of a covering, all boxes that it leaves out, whatever `enclosures` allows.
        journal: of a covering, this file keeps how many boxes are proven: the same call goes on there. Believed as it
            stands: take none from others.
        progress: progress(done, all).

    Returns:
        Whether it holds, what holds, and why it does not.

    Raises:
        ResultFileError: the file cannot be read, is no certificate, or is malformed.
        OptionError: a budget outside what is allowed, or a journal of what is no covering.
        MissingExtraError: python-flint is not installed.

    Example:
        >>> import tempfile
        >>> from rankdrop.cover.certificates import ball_certificate, write_certificate
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("planar3r")
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     place = write_certificate(ball_certificate(arm, [0.3, 1.2, 0.4], radius=1.1), f"{folder}/ball.json")
        ...     print(verify(place, arm).claim)
        no configuration within 1.1 rad of q has a rank below 3; joints 1 and 3 may stand anywhere
    """
    for name, value in (("enclosures", enclosures), ("sample", sample)):
        if value is not None and (isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1):
            raise OptionError("this is a whole number from 1 up", where=name, got=repr(value))
    if sample is not None and journal is not None:
        raise OptionError("a journal is kept of all boxes of a covering", where="journal", got="a sample",
                          mend="leave it out")  # fmt: skip
    kept = None if journal is None else Path(journal)
    work = Work(int(enclosures), progress, sample=sample, every=every, journal=kept)
    if about is None or isinstance(about, Robot):
        asked = asked_about(about)
    else:
        asked = about
    with refused_as_result():
        checked = check_certificate(Path(file), asked, work)
    return Verified(**vars(checked))


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
    ball = certified_radius(
        robot, centre, resolved, evaluations=evaluations, at_most=LARGEST if radius is None else radius
    )
    setting, most = ball.setting, ball.radius
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
        if radius is None:
            wanted = most * share
        else:
            wanted = radius
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
    settings = settings_for_near_arms(robot, task)
    tests = [_Test(robot, setting, task.rows, q, tolerance) for setting in settings]
    tried = [free_radius(test, at_most, evaluations // 40) for test in tests]
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
        enclosed = enclose(self.robot, self.setting, q, wide)
        if self.tolerance is None:
            return np.asarray(enclosed[0] != 0)
        far = np.abs(q) + wide * scale
        drift = displaced_jacobian(self.robot, self.setting, self.tolerance, self.rows, far)
        extra = np.einsum("bi,bij->bj", drift, np.abs(enclosed[5]))
        return regular(enclosed[3], enclosed[2] + extra[:, None, :])


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
        middle, width = _halve_boxes(centre[left[~narrow]], half[left[~narrow]])
        centre, half = np.concatenate([centre[later], middle]), np.concatenate([half[later], width])
        gap = np.linalg.norm(np.maximum(0.0, np.abs(centre) - half), axis=1)
        inside = gap < stuck
        centre, half, gap = centre[inside], half[inside], gap[inside]
    return max(least, stuck)


def _halve_boxes(centre: Array, half: Array) -> tuple[Array, Array]:
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
    letters = np.array([LETTERS[j] for j in test.places])
    d = len(letters)
    centre, half = np.zeros((1, d)), np.full((1, d), radius)
    pieces = ["", ""]  # the tree, cut where boxes are open
    count = 0
    while len(centre):
        gap = np.linalg.norm(np.maximum(0.0, np.abs(centre) - half), axis=1)
        outside = gap > radius * (1 + 1e-9)
        free = np.zeros(len(centre), dtype=np.bool_)
        for begin in range(0, len(centre), 1 << 14):
            part = np.flatnonzero(~outside)[begin : begin + (1 << 14)]
            free[part] = test.free(centre[part], half[part])
        count += int(free.sum())
        left = ~outside & ~free
        if count + int(left.sum()) > boxes or (half[left] < _NARROW).all(axis=1).any():
            return None
        marks = np.where(outside, OUTSIDE, np.where(free, FREE, letters[np.argmax(half, axis=1)]))
        joined = [pieces[0]]
        for mark, is_halved, after in zip(marks.tolist(), left.tolist(), pieces[1:], strict=True):
            joined[-1] += mark
            if is_halved:
                joined += ["", after]
            else:
                joined[-1] += after
        pieces = joined
        parts = _halve_boxes(centre[left], half[left])
        centre, half = (both.reshape(2, -1, d).swapaxes(0, 1).reshape(-1, d) for both in parts)  # halves side by side
    return "".join(pieces)


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
    return record_of(robot, task, COVERING, best_setting(robot, task, plan.corank), claim, {})


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
    slides = any(joint.slides for joint in robot.variables)
    claim = {"q": centre.tolist(), "radius": radius * (max(1.0, setting.length) if slides else 1.0)}
    return record_of(robot, resolved, EXISTENCE, setting, claim, {})


def _setting_of(robot: Robot, task: Task) -> Setting:
    """Where an existence is looked at from; of a task of some rows, which no region can be certified for, the tip.

    Raises:
        OptionError: nothing moves for this task, or the arm cannot be certified at all.
    """
    rank = generic_rank(robot, task)
    some = any(0 < len(set(block) & set(task.rows)) < 3 for block in ((0, 1, 2), (3, 4, 5)))
    try:
        return best_setting(robot, task)
    except OptionError:
        if not (some and rank):
            raise
        count = len(robot.joints)
        point = robot.joints[-1].frame[:3, :3].T @ (robot.home[:3, 3] - robot.joints[-1].frame[:3, 3])
        return Setting(
            count, (float(point[0]), float(point[1]), float(point[2])), task.scale(robot), task.rows, rank,
            np.zeros(count), joint_scale(robot, task), np.ones(robot.n, dtype=np.bool_), 1.0,
        )  # fmt: skip
