"""`rankdrop.verify`: does what a certificate claims hold? Proven again by code other than that which made it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.certify.proof.covers import corank_of, verify_covering
from rankdrop.certify.proof.existence import verify_existence
from rankdrop.certify.proof.intervals import BITS, SCREW, SLIDE, Arm, Interval, Region, flint
from rankdrop.certify.proof.minors import verify_in_minors
from rankdrop.certify.proof.reading import (
    BALL,
    COVERING,
    EXISTENCE,
    PATH,
    Damaged,
    Told,
    Unproven,
    Work,
    read_certificate,
)
from rankdrop.certify.proof.regions import verify_ball, verify_distance, verify_path
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.robot.model import Robot, fingerprint
from rankdrop.sections import Section, html, text
from rankdrop.version import VERSION

ENCLOSURES = 500_000
"""Of interval arithmetic, at most: about a millisecond each."""
_TRIED = 3  # configurations at which a higher rank is looked for
_VANISHES = 1e-11  # share of the Jacobian's size below which rows that the task leaves out count as zero


@dataclass(frozen=True, slots=True)
class Verified:
    """What checking a certificate came to.

    Attributes:
        holds: the claim is proven.
        kind: "ball", "path", "covering" or "existence"; "" of a file that is damaged.
        arm: name of the arm, as the certificate has it.
        claim: what holds, in one sentence; "" where it does not.
        reason: why it is not confirmed, in one sentence; "" where it is. A proof that fails refutes nothing.
        assumed: what the proof rests on beside the numbers of the arm.
        enclosures: of interval arithmetic that were made.
        complete: False where it was interrupted.
    """

    holds: bool
    kind: str
    arm: str
    claim: str
    reason: str
    assumed: tuple[str, ...]
    enclosures: int
    complete: bool = True

    def __bool__(self) -> bool:
        return self.holds

    def sections(self) -> tuple[Section, ...]:
        """As sections of text."""
        of = f"{self.kind} of {self.arm}" if self.kind else "certificate"
        counted = (f"{self.enclosures:,} enclosures of interval arithmetic",) if self.enclosures else ()
        if not self.holds:
            return (Section("Not confirmed", of, (f"{self.reason}.",), notes=counted, tone="bad"),)
        return (Section("Holds", of, (f"{self.claim}.",), notes=(*counted, *self.assumed), tone="good"),)

    def __str__(self) -> str:
        return text(self.sections())

    def _repr_html_(self) -> str:
        return html(self.sections())

    def to_dict(self) -> dict[str, Any]:
        """The record that `rankdrop verify --json` writes."""
        return {
            "schema": "rankdrop/verified/1", "holds": self.holds, "kind": self.kind, "arm": self.arm,
            "claim": self.claim, "reason": self.reason, "assumed": list(self.assumed), "enclosures": self.enclosures,
            "complete": self.complete, "version": VERSION,
        }  # fmt: skip


def verify(
    file: str | Path,
    robot: Robot | None = None,
    *,
    enclosures: int = ENCLOSURES,
    sample: int | None = None,
    every: bool = False,
    journal: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Verified:
    """Check a certificate: prove its claim again from the numbers of the arm that are in it.

    Interval arithmetic with 90 bits and rounding outwards (Arb), and other mathematics than that which made it
    (`rankdrop.certify.proof.intervals`). Of the certificate nothing is believed but the claim itself, where to look
    from, and how to cut a region into boxes; a bad choice of these proves nothing, and never something wrong.

    Args:
        file: written by `rankdrop nearest`, `path`, `cover` or `explain` with --certificate.
        robot: the arm that the certificate must be about; None: the arm whose numbers are in it.
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
        >>> from rankdrop.certify.proof.writing import ball_certificate, write_certificate
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("planar3r")
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     place = write_certificate(ball_certificate(arm, [0.3, 1.2, 0.4], radius=1.1), f"{folder}/ball.json")
        ...     print(verify(place, arm).claim)
        no configuration within 1.1 rad of q has a rank below 3; joints 1 and 3 may stand anywhere
    """
    _check_whole("enclosures", enclosures)
    if sample is not None:
        _check_whole("sample", sample)
    module = flint()
    work = Work(int(enclosures), progress)
    covers = partial(verify_covering, sample=sample, every=every, journal=None if journal is None else Path(journal))
    try:
        told = read_certificate(Path(file))
    except Damaged as error:
        return Verified(False, "", "", "", str(error), (), 0)
    try:
        with module.ctx.workprec(BITS):
            claim, assumed = _proven(told, robot, work, covers)
    except Unproven as error:
        return Verified(False, told.kind, told.name, "", str(error), (), work.done)
    except (KeyError, TypeError, ValueError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise ResultFileError("the certificate is malformed", where=str(file), got=what) from error
    except KeyboardInterrupt:
        done, total = work.place
        far = f": {done:,} of {total:,} were checked" if total else ": not all of it was checked"
        kept = f", which {journal} keeps: the same command goes on there" if journal is not None else ""
        return Verified(False, told.kind, told.name, "", f"interrupted{far}{kept}", (), work.done, False)
    return Verified(True, told.kind, told.name, claim, "", assumed, work.done)


def _check_whole(name: str, value: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise OptionError("this is a whole number from 1 up", where=name, got=repr(value))


def _proven(
    told: Told, robot: Robot | None, work: Work, covers: partial[str]
) -> tuple[str, tuple[str, ...]]:
    """The claim in words, and what it rests on.

    Raises:
        Unproven: it does not hold, or could not be confirmed.
    """
    if covers.keywords["journal"] is not None and (told.kind != COVERING or covers.keywords["sample"] is not None):
        got = f"a {told.kind}" if covers.keywords["sample"] is None else "a sample"
        raise OptionError("a journal is kept of all boxes of a covering", where="journal", got=got, mend="leave it out")
    _same_arm(told, robot)
    if told.kind == EXISTENCE:
        return _existence(told)
    arm = _arm(told)
    assumed = [*_rows_left_out(told), *_rank_is_generic(arm, told), *_model(told)]
    if told.kind == BALL:
        claim = verify_ball(arm, told, work)
    elif told.kind == COVERING:
        claim = covers(arm, told, work)
    else:
        claim = verify_path(arm, told, work)
    if told.tolerance is not None:
        near = told.tolerance
        claim += f"; so it is for every arm within {near.length:g} m and {near.angle:g} rad of this one, joint by joint"
    if told.kind == PATH:
        claim = "; ".join(filter(None, (claim, verify_distance(arm, told, work))))
    return claim, tuple(assumed)


def _existence(told: Told) -> tuple[str, tuple[str, ...]]:
    """By Krawczyk's test, else in rational numbers.

    Raises:
        Unproven: by neither.
    """
    try:
        return verify_existence(_arm(told), told), tuple(_rows_left_out(told))
    except Unproven as error:
        why = str(error)
    try:
        return verify_in_minors(told), ()
    except Unproven as error:
        raise Unproven(f"{why}; {error}") from error


def _same_arm(told: Told, robot: Robot | None) -> None:
    """The certificate speaks of the arm that is meant."""
    if robot is None:
        return
    last = robot.joints[-1].frame
    if fingerprint(robot) != told.model or last.shape != told.last.shape or (last != told.last).any():
        raise Unproven(f"the certificate is about another arm than {robot.name}: their numbers differ")


def _arm(told: Told) -> Arm:
    """The arm as the certificate looks at it; of a translation the point must be that of the task.

    Raises:
        Unproven: the point is another.
    """
    f = flint()
    point: list[Interval] = [f.arb(x) for x in told.point]
    length = f.arb(told.length)
    if told.whole_rows == [0, 1, 2]:
        _, origin, local = told.frame
        joints = len(told.links)
        if origin not in (-1, joints, joints + 1) or told.link != joints:
            raise Unproven("a translation is that of a point of the last link, seen from that link")
        pose = told.last if origin == joints else told.home
        point = [
            sum((f.arb(float(pose[r, c])) * local[c] for c in range(3)), f.arb(float(pose[r, 3]))) for r in range(3)
        ]
    if told.tolerance is not None:
        if list(told.rows) != told.whole_rows:
            raise Unproven("rows that the task leaves out are zero for this arm, not for those near it")
        _points_on_axes(told)
    return Arm(told.links, told.variables, told.link, point, length)


def _points_on_axes(told: Told) -> None:
    assert told.tolerance is not None
    for number, (one, point) in enumerate(zip(told.links, told.tolerance.points, strict=True), start=1):
        if one.kind == SLIDE:
            continue
        v, w = np.array(one.screw[:3]), np.array(one.screw[3:])
        along = w * (v @ w) / (w @ w) if one.kind == SCREW else np.zeros(3)
        off = float(np.linalg.norm(v - along - np.cross(point, w)))
        if not off < 1e-9 * (1.0 + float(np.linalg.norm(point))):
            raise Unproven(f"the point of joint {number} is not on its axis")


def _rows_left_out(told: Told) -> list[str]:
    """A task that takes some rows of a block: the others are measured to be zero, which is told."""
    missing = [row for row in told.whole_rows if row not in told.rows]
    if not missing:
        return []
    f = flint()
    joints = len(told.links)
    axes, origin, local = told.frame
    poses = {-1: told.home, joints: told.last, joints + 1: told.home, 0: np.eye(4)}
    if axes not in poses or origin not in poses:
        raise Unproven("the frame of a task that takes some rows only is that of the base, the last link or the tip")
    point = poses[origin][:3, :3] @ np.array(local) + poses[origin][:3, 3]
    arm = Arm(told.links, told.variables, joints, [f.arb(float(x)) for x in point], f.arb(1))
    turn = poses[axes][:3, :3].T
    # a translation left out stays the same one in every link's axes where all turns are about it
    fixed = {3 + k for row in missing if row < 3 for k in range(3) if k != row}
    zero = sorted(set(missing) | fixed)
    largest, size = 0.0, 0.0
    for q in np.random.default_rng(0).uniform(-np.pi, np.pi, (8, told.variables)):
        seen = arm.jacobian(arm.seen([f.arb(float(x)) for x in q], [f.arb(0)] * told.variables).columns)
        seen = np.concatenate([turn @ seen[:3], turn @ seen[3:]])
        largest, size = max(largest, float(np.abs(seen[zero]).max())), max(size, float(np.abs(seen).max()))
    if largest > _VANISHES * size:
        raise Unproven("the task takes some rows only, and for this arm its rank depends on the axes")
    names = ", ".join(("vx", "vy", "vz", "wx", "wy", "wz")[row] for row in missing)
    return [f"{names}, which the task leaves out, are zero for this arm (measured: {largest:.1g})"]


def _rank_is_generic(arm: Arm, told: Told) -> list[str]:
    """No configuration tried has a higher rank: else the certificate would speak of another loss.

    A covering of a higher corank is about a rank that is lower by so much than the one almost everywhere.

    Raises:
        Unproven: one has.
    """
    f = flint()
    most = min(len(told.whole_rows), told.variables)
    rank = told.rank + corank_of(told) - 1
    if rank > most:
        raise Unproven(f"the rank is at most {most}, not {rank}")
    if rank == most:
        return []
    zero = [f.arb(0)] * told.variables
    for q in np.random.default_rng(1).uniform(-1.0, 1.0, (_TRIED, told.variables)):
        if arm.keeps_rank(Region([f.arb(float(x)) for x in q], zero), told.whole_rows, rank + 1):
            raise Unproven(f"the rank is above {rank} almost everywhere")
    return [f"{rank} is the rank almost everywhere (no higher one at {_TRIED} configurations)"]


def _model(told: Told) -> list[str]:
    if told.tolerance is None:
        return ["the arm has the numbers of the certificate: nothing is said of arms near it"]
    return []
