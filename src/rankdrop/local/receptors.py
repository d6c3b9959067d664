"""Actuators and receptors: which joint carries which screws out of what the screws span (GR sections 3 and 4)."""

from __future__ import annotations

import numpy as np

from rankdrop.kinematics import jacobian
from rankdrop.local.bracket import brackets
from rankdrop.local.place import Place
from rankdrop.local.taylor import taylor
from rankdrop.local.unlocked import unlocked
from rankdrop.tolerances import ENTRY


def receptors(place: Place) -> tuple[tuple[int, ...], ...]:
    """Per actuator a, the joints i (from 1) whose change leaves the span of all screws, and that are dependent at q.

    For the whole pose the change is [S_a, S_i], i > a. Tasks with fewer rows take the change of the task Jacobian's
    column, which is also there for joints before a when the reference point moves.

    What the receptors bring can cancel: an actuator with receptors need not restore the rank. D says whether it does.
    """
    if not place.corank:
        return ((),) * len(place.q)
    chain, values, _ = unlocked(place.robot, place.q)
    if place.task.m == 6 and chain is place.robot:
        change = brackets(jacobian(chain, values, place.task.frame))
        change[:, :3] /= place.task.scale(place.robot)
    else:
        change = taylor(place.robot, place.q, place.task, np.eye(len(place.q)), 1)[1]
    leaves = np.linalg.norm(np.einsum("mp,ami->api", place.u2, change), axis=1) > ENTRY
    depends = np.linalg.norm(place.v2, axis=1) > ENTRY
    return tuple(tuple(int(i) + 1 for i in np.flatnonzero(row & depends)) for row in leaves)
