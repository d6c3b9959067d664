"""New time laws as remedies: the path as it is, slower around the places where it is too fast, or all of it anew."""

from __future__ import annotations

import numpy as np

from rankdrop.path.mend.local_change import LocalChange
from rankdrop.path.mend.record import RETIME, SLOW, Failure, Proposal, Remedy
from rankdrop.path.mend.retime import retime_path, usage
from rankdrop.path.mend.slow_down import slowed_down
from rankdrop.path.mend.verifier import SLOWER, Verifier


def slower(verifier: Verifier) -> Remedy | Failure:
    """The path itself, slower around the places where it is too fast."""
    verifier.report(SLOW, 0, 1)
    path = verifier.before.curve
    slowed = slowed_down(path, *verifier.limits)
    if slowed is None:
        return SLOW, path.degree == 1
    still = np.zeros(verifier.before.robot.n)
    changes = tuple(LocalChange(path.place(part.start), path.place(part.end), still, (0.0, 0.0), still, part.longer)
                    for part in slowed[1])  # fmt: skip
    proposal = Proposal(("slow-down", len(changes)), (), slowed[0], (0.0, 0.0), changes)
    remedy = verifier.as_remedy(SLOW, proposal, retimed=True)
    verifier.report(SLOW, 1, 1)
    return remedy if remedy.check.clear else (SLOW, True)


def in_new_time(verifier: Verifier) -> Remedy | Failure:
    """The path itself inside its limits."""
    verifier.report(RETIME, 0, 1)
    trajectory = retime_path(verifier.before.curve, *verifier.limits, verifier.scale)
    if usage(trajectory.curve(verifier.interpolate), *verifier.limits).slower > SLOWER:
        return RETIME, None
    remedy = verifier.as_remedy(RETIME, Proposal(("retime", None), (), trajectory, (0.0, 0.0)), retimed=True)
    verifier.report(RETIME, 1, 1)
    return remedy
