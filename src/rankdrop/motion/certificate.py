"""A judged path as a certificate: every span that is free, and every crossing, for `rankdrop.verify` to prove again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.ball import settings_of
from rankdrop.certify.certificates import file_hash, record_of
from rankdrop.certify.displaced import ModelTolerance, displaced_jacobian
from rankdrop.certify.setting import enclose, regular
from rankdrop.motion.curve import boxes, halves
from rankdrop.motion.prove import centred, chosen, stretches_left
from rankdrop.motion.record import CROSSING as CROSSES
from rankdrop.motion.record import FREE, Place, Stretch
from rankdrop.proof.record import CLEAR, CROSSING, OPEN, PATH, Record
from rankdrop.robot.model import Array

if TYPE_CHECKING:
    from rankdrop.motion.record import PathCheck

EVALUATIONS = 500_000
"""Enclosures that the proof for near arms may cost."""
_SHORTEST = 1e-5  # pieces that are narrower are given up: the tolerance decides there, not their length [rad]


def path_certificate(
    check: PathCheck, tolerance: ModelTolerance | None = None, *, file: Path | None = None
) -> Record:
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
    setting = chosen(check.robot, settings_of(check.robot, check.task), check.curve)
    if tolerance is not None:
        displaced_jacobian(check.robot, setting, tolerance, check.task.rows)  # refuses what it is not for
    control = check.curve.control
    points = np.concatenate([control[:, :-1].reshape(-1, control.shape[2]), control[-1:, -1]])
    square = check.robot.n == setting.rank == len(setting.rows)
    last = len(control)
    spans: list[Record] = []
    at = [0, 0.0]
    met = [one for one in check.stretches if one.verdict != FREE]
    for one in sorted(met, key=lambda one: (one.start.row, one.start.share)):
        start, end = _place(one.start, last), _place(one.end, last)
        if at != start:
            spans.append({"from": at, "to": start, "kind": CLEAR})
        spans.append(_stretch_record(one, square, last))
        at = end
    if at != [last - 1, 1.0]:
        spans.append({"from": at, "to": [last - 1, 1.0], "kind": CLEAR})
    claim = {
        "verdict": CLEAR if not met else "met", "degree": check.curve.degree, "points": points.tolist(), "spans": spans,
    }  # fmt: skip
    if check.margin == "kept":
        claim |= {"min_distance": check.options.min_distance, "scale": setting.scale.tolist()}
    if file is not None:
        claim["path"] = {"file": file.name, "sha256": file_hash(file)}
    return record_of(check.robot, check.task, PATH, setting, claim, {}, tolerance)


def proven_for_near_arms(check: PathCheck, tolerance: ModelTolerance, *, evaluations: int = EVALUATIONS) -> bool:
    """Is a path proven free for every arm within a tolerance of this one?

    Boxes around runs of stretches, then around parts of one, are enclosed and halved; what arms within the tolerance
    add to the bound is that of `rankdrop.certify.displaced`. False is no proof that some arm is singular.

    Args:
        check: a judged path.
        tolerance: how far the arm may be from its numbers.
        evaluations: enclosures to be spent at most.

    Raises:
        OptionError: the task cannot be certified, or the tolerance is not for this arm or task.
    """
    robot = check.robot
    setting = chosen(robot, settings_of(robot, check.task), check.curve)
    rows = check.task.rows
    displaced_jacobian(robot, setting, tolerance, rows)  # refuses what it is not for
    spent = 0

    def kept(low: Array, high: Array) -> NDArray[np.bool_]:
        nonlocal spent
        spent += len(low)
        found = enclose(robot, setting, *centred(low, high, setting))
        drift = displaced_jacobian(robot, setting, tolerance, rows, np.maximum(np.abs(low), np.abs(high)))
        return regular(found[3], found[2] + np.einsum("bi,bij->bj", drift, np.abs(found[5]))[:, None, :])

    control = check.curve.control[stretches_left(check.curve, kept)]
    while len(control) and spent < evaluations:
        low, high = boxes(control)
        left = ~kept(low, high)
        if (np.abs(high - low)[left] < _SHORTEST * setting.scale).all(axis=1).any():
            return False
        control = halves(control[left])
    return not len(control)


def _stretch_record(stretch: Stretch, square: bool, last: int) -> Record:
    start, end = _place(stretch.start, last), _place(stretch.end, last)
    low, high = (_place(place, last) for place in stretch.bracket)
    if stretch.verdict == CROSSES and square and not stretch.lies and start <= low < high <= end:
        return {"from": start, "to": end, "kind": CROSSING, "bracket": [low, high]}
    return {"from": start, "to": end, "kind": OPEN}


def _place(place: Place, last: int) -> list[float]:
    """[stretch from 0, share]; the last row is the end of the last stretch."""
    if place.row > last:
        return [last - 1, 1.0]
    return [place.row - 1, float(place.share)]
