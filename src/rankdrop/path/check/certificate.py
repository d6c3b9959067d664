"""What else is proven of a path: a distance that it keeps, and all of it for near arms; and its certificate, with every
span that is free and every crossing, for `rankdrop.verify` to prove again.
"""

from __future__ import annotations

from collections.abc import Iterable
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.cover.ball import LARGEST, ModelTolerance, certified_radius, displaced_jacobian
from rankdrop.cover.certificates import file_hash, record_of
from rankdrop.cover.setting import Setting, enclose, regular, settings_for, settings_for_near_arms
from rankdrop.path.check.prove import centre_and_half_sides, chosen, first_open
from rankdrop.path.check.record import CROSSING as CROSSES
from rankdrop.path.check.record import FREE
from rankdrop.path.curve import Curve, Place, boxes
from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.poses import holds_poses, read_poses
from rankdrop.problem import Mask
from rankdrop.proof.curves import AskedPath
from rankdrop.proof.record import (
    CLEAR,
    CROSSING,
    OPEN,
    PATH,
    Record,
)
from rankdrop.questions import PathOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.units import counted_length

if TYPE_CHECKING:
    from rankdrop.path.check.record import PathCheck, Stretch

EVALUATIONS = 500_000
"""Enclosures that the proof for near arms may cost."""
_BALL = 20_000  # enclosures of branch and bound for one ball
_SHORT = 0.5  # pieces with ρ below this share of the distance get branch and bound
_GIVEN_UP = 0.05  # … and below this are given up
_OUTRIGHT = 1e-9  # of a radius: what bisection leaves open
_SHORTEST = 1e-5  # pieces that are narrower are given up: the tolerance decides there, not their length [rad]


def path_certificate(check: PathCheck, tolerance: ModelTolerance | None = None, *, file: Path | None = None) -> Record:
    """What is proven of a path, with the numbers of the arm and the control points of the path.

    Spans that touch the singular set or are undecided are open: nothing is claimed of them. Crossings are claimed where
    the Jacobian is square; else they are open too. A distance that is proven to be kept (`min_distance`) is claimed.

    Args:
        check: a judged path.
        tolerance: the free spans are free for every arm so near to this one; found by the checker, not here.
        file: that the path was read from: its name and hash are part of the claim.

    Raises:
        OptionError: the task cannot be certified, or the tolerance is not for this arm or task.
    """
    if tolerance is None:
        settings = settings_for(check.robot, check.task)
    else:
        settings = settings_for_near_arms(check.robot, check.task)
    setting = chosen(check.robot, settings, check.curve)
    if tolerance is not None:
        displaced_jacobian(check.robot, setting, tolerance, check.task.rows)  # refuses what it is not for
    control = check.curve.control
    points = np.concatenate([control[:, :-1].reshape(-1, control.shape[2]), control[-1:, -1]])
    open_stretches = [stretch for stretch in check.stretches if stretch.verdict != FREE]
    square = check.robot.n == setting.rank == len(setting.rows)
    claim = {
        "verdict": CLEAR if not open_stretches else "met", "degree": check.curve.degree, "points": points.tolist(),
        "spans": _spans(check.curve, open_stretches, square=square),
    }  # fmt: skip
    if check.margin == "kept":
        claim |= {"min_distance": check.options.min_distance, "scale": setting.scale.tolist()}
    if file is not None:
        claim["path"] = {"file": file.name, "sha256": file_hash(file)}
    return record_of(check.robot, check.task, PATH, setting, claim, {}, tolerance)


def _spans(curve: Curve, stretches: Iterable[Stretch], *, square: bool) -> list[Record]:
    """The claim on each part of a curve, in order: clear, a crossing, or open.

    Args:
        curve: the whole of it.
        stretches: those that are not free.
        square: the Jacobian is, so that crossings can be claimed.
    """

    def spot(place: Place) -> list[Any]:
        return list(curve.spot(place))

    spans: list[Record] = []
    at, last = [0, 0.0], [len(curve.control) - 1, 1.0]
    for stretch in sorted(stretches, key=attrgetter("start")):
        (start, end), (low, high) = map(spot, (stretch.start, stretch.end)), map(spot, stretch.bracket)
        if at != start:
            spans.append({"from": at, "to": start, "kind": CLEAR})
        if stretch.verdict == CROSSES and square and not stretch.lies and start <= low < high <= end:
            spans.append({"from": start, "to": end, "kind": CROSSING, "bracket": [low, high]})
        else:
            spans.append({"from": start, "to": end, "kind": OPEN})
        at = end
    if at != last:
        spans.append({"from": at, "to": last, "kind": CLEAR})
    return spans


def path_asked(
    robot: Robot, file: str | Path, options: PathOptions | None = None, *, deg: bool = False, topic: str | None = None,
    interpolate: str | None = None,
) -> AskedPath:  # fmt: skip
    """What a file of a path says, for `rankdrop.verify` to compare with a certificate.

    Args:
        robot: whose joints, or whose tip, it moves.
        file: joint values or poses of the tip.
        options: how near the tip has to be to the lines and turns between poses.
        deg: angles without a unit are in degrees.
        topic: of a bag.
        interpolate: "linear", "cubic" or "quintic"; None: what the certificate's degree says.

    Raises:
        TrajectoryError: the file cannot be read, with the place in it.
        ResultFileError: its hash cannot be computed.
    """
    place, how = Path(file), options or PathOptions()
    if topic is None and holds_poses(place, robot):
        poses = read_poses(place, deg=deg, robot=robot)
        return AskedPath(
            place.name, file_hash(place), poses=poses.matrices, turned=poses.turned,
            tip=how.tip_tolerance * counted_length(robot), turn=how.turn_tolerance,
        )  # fmt: skip
    read = read_trajectory(place, robot, deg=deg, topic=topic)
    return AskedPath(
        place.name, file_hash(place), read.q, read.times if read.timed else None, read.velocities, read.accelerations,
        interpolate,
    )  # fmt: skip


def proven_for_near_arms(check: PathCheck, tolerance: ModelTolerance, *, evaluations: int = EVALUATIONS) -> bool:
    """Is a path proven free for every arm within a tolerance of this one?

    Boxes around runs of stretches, then around parts of one, are enclosed and halved; what arms within the tolerance
    add to the bound is that of `rankdrop.cover.ball`. False is no proof that some arm is singular.

    Args:
        check: a judged path.
        tolerance: how far the arm may be from its numbers.
        evaluations: enclosures to be spent at most.

    Raises:
        OptionError: the task cannot be certified, or the tolerance is not for this arm or task.
    """
    robot, rows = check.robot, check.task.rows
    setting = chosen(robot, settings_for_near_arms(robot, check.task), check.curve)
    displaced_jacobian(robot, setting, tolerance, rows)  # refuses what it is not for
    spent = 0

    def prove_boxes(low: Array, high: Array) -> Mask:
        nonlocal spent
        spent += len(low)
        enclosure = enclose(robot, setting, *centre_and_half_sides(low, high, setting))
        drift = displaced_jacobian(robot, setting, tolerance, rows, np.maximum(np.abs(low), np.abs(high)))
        return regular(enclosure[3], enclosure[2] + np.einsum("bi,bij->bj", drift, np.abs(enclosure[5]))[:, None, :])

    def prove_pieces(control: Array) -> tuple[Mask, Mask]:
        low, high = boxes(control)
        if spent < evaluations:
            done = prove_boxes(low, high)
        else:
            done = np.zeros(len(low), dtype=np.bool_)
        narrow = (high - low < _SHORTEST * setting.scale).all(axis=1)
        return done, ~done & (narrow | (spent >= evaluations))

    return first_open(check.curve, prove_boxes, prove_pieces) < 0


def margin(
    robot: Robot, task: Task, setting: Setting, path: Curve, distance: float, evaluations: int
) -> tuple[int, int]:
    """Try to prove that no singular configuration is nearer to the path than a distance.

    A piece of the path lies within ρ of its middle; a ball of radius d + ρ around the middle that is proven free keeps
    the distance d on all of the piece. One enclosure is tried first, branch and bound on short pieces.

    Args:
        robot, task: the arm and its task.
        setting: that the path was proven free from.
        path: the curve.
        distance: d > 0 [rad; slides divided by the length scale]; beyond π it is not tried.
        evaluations: enclosures to be spent at most.

    Returns:
        A stretch for which it could not be proven, −1 where it is proven; and the enclosures spent.
    """
    if distance >= LARGEST:
        return 0, 0
    spent = 0

    def prove_boxes(low: Array, high: Array) -> Mask:
        nonlocal spent
        spent += len(low)
        centre, rho = ball(low, high, setting)
        done = np.zeros(len(centre), dtype=np.bool_)
        tried = np.flatnonzero(distance + rho < LARGEST)
        if len(tried):
            radius = enclose(robot, setting, np.ascontiguousarray(centre[tried]), radius=LARGEST)[1]
            done[tried] = radius * (1 - _OUTRIGHT) >= distance + rho[tried]
        return done

    def prove_pieces(control: Array) -> tuple[Mask, Mask]:
        nonlocal spent
        done, lost = np.zeros((2, len(control)), dtype=np.bool_)
        if spent + len(control) > evaluations:
            spent += len(control)
            return done, ~done
        done = prove_boxes(*boxes(control))
        centre, rho = ball(*boxes(control), setting)
        for i in np.flatnonzero(~done & (rho < _SHORT * distance)):
            radius = min((distance + float(rho[i])) * (1 + _OUTRIGHT), LARGEST)
            proof = certified_radius(robot, centre[i], task, at_most=radius, evaluations=_BALL)
            spent += proof.evaluations
            done[i] = proof.radius == proof.at_most
            lost[i] = spent > evaluations or (not done[i] and rho[i] < _GIVEN_UP * distance)
            if lost[i]:
                break
        return done, lost

    return first_open(path, prove_boxes, prove_pieces), spent


def ball(low: Array, high: Array, setting: Setting) -> tuple[Array, Array]:
    """Middles of boxes, and how far their corners are [rad; slides scaled]."""
    centre, half = centre_and_half_sides(low, high, setting)
    return centre, np.linalg.norm(half[:, setting.matters], axis=1)
