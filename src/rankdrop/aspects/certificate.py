"""Certificates that an arm is cuspidal, or that it is not: for `rankdrop.verify` to prove again."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rankdrop.aspects.posture_paths import Postures
from rankdrop.cover.certificates import record_of
from rankdrop.cover.setting import best_setting, settings_for
from rankdrop.errors import OptionError
from rankdrop.exact.posture_changes import SIGNS as DECIDED_BY_SIGNS
from rankdrop.kinematics import pose, task_jacobian
from rankdrop.path.check.prove import chosen
from rankdrop.path.curve import curve
from rankdrop.poses.inverse import Aim
from rankdrop.proof.record import CHANGE, SIGNS, STRUCTURES, Record, Unproven, claim_of
from rankdrop.proof.signs import verify_signs
from rankdrop.text import no_certificate

_NEAR = 1e-9  # how far from the last row a solution is claimed at least [rad, m]
_FARTHER = 4.0  # … and so many times what is measured


def posture_certificate(postures: Postures) -> Record:
    """What shows that an arm is cuspidal, or that it is not: a path, or signs of its own for each solution of a pose.

    Args:
        found: from `aspects_of`.

    Raises:
        OptionError: nothing is proven, the proof is none that the checker knows, the numbers of the arm have the
            structure to rounding only, or the task cannot be certified.
    """
    robot, task, decision = postures.robot, postures.task, postures.decision
    if postures.change is not None:
        return change_certificate(postures)
    if decision.kind != DECIDED_BY_SIGNS or decision.why not in STRUCTURES:
        raise OptionError(no_certificate(postures), where="certificate", got=postures.verdict)
    record = record_of(robot, task, SIGNS, best_setting(robot, task), {"structure": decision.why}, {})
    try:
        verify_signs(claim_of(record, Path()))
    except Unproven as error:
        raise OptionError(f"the numbers of the arm do not have its structure exactly: {error}", where="certificate",
                          got=decision.why) from error  # fmt: skip
    return record


def change_certificate(postures: Postures) -> Record:
    """What shows that an arm is cuspidal: a path without singularity between two solutions of one pose.

    The first row is one solution exactly, next to the last one lies another: the checker proves that it exists.

    Args:
        found: from `aspects_of`, with a path.

    Raises:
        OptionError: there is no path, or the task cannot be certified.
    """
    if postures.change is None:
        raise OptionError("there is no path to certify", where="certificate", got=postures.verdict,
                          allowed="the result for a cuspidal arm with a path")  # fmt: skip
    robot, task, q = postures.robot, postures.task, postures.change.q
    setting = chosen(robot, settings_for(robot, task), curve(q, None))
    error = Aim(robot, task).error(pose(robot, q[0]), q[-1:])[0]
    step = np.linalg.solve(task_jacobian(robot, q[-1:], task)[0], error)
    radius = max(_NEAR, _FARTHER * float(np.abs(step).max()))
    claim = {"degree": 1, "points": q.tolist(), "radius": radius, "limits": postures.options.limits}
    return record_of(robot, task, CHANGE, setting, claim, {})
