"""Made-up analyses: for what is shown of one, not for what is true."""

from __future__ import annotations

from math import pi

import numpy as np

from rankdrop.families.corank_families import CorankSummary, Estimator, Unseen
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.linear_conditions import vanishing_on
from rankdrop.families.lost import LostFreedom
from rankdrop.families.record import Check, Family, Pin
from rankdrop.formula.equation import Equation, Term
from rankdrop.results.analysis import Analysis, Settings
from rankdrop.results.old_files import name_of_words
from rankdrop.robot.open import open_robot
from rankdrop.task import Frame, resolve_task
from rankdrop.tolerances import DEFAULT

ZERO, HALF = (0.0, pi), (pi / 2, -pi / 2)
SLIDE_X = LostFreedom((1.0, 0.0, 0.0, 0.0, 0.0, 0.0), Frame(), everywhere=True)
TURN_X = LostFreedom((0.0, 0.0, 0.0, 1.0, 0.0, 0.0), Frame(), everywhere=True)


def family(
    number: int, name: str, pins: dict[int, tuple[float, ...]], *, coupled: tuple[int, ...] = (),
    equations: tuple[Equation, ...] = (), lost: tuple[LostFreedom, ...] = (SLIDE_X,),
    singular: int = 200, named: bool = True,
) -> Family:  # fmt: skip
    """A made-up row of a 7-joint arm."""
    conditions = tuple(
        vanishing_on([int(i == j) for i in range(1, 8)], values, periodic=True) for j, values in pins.items()
    )
    return Family(
        id=f"k1.f{number}", called=name_of_words(name), corank=1, dimension=5,
        pinned=tuple(Pin(f"joint{j}", j, values) for j, values in pins.items()),
        free=tuple(j for j in range(1, 8) if j not in pins and j not in coupled), coupled=coupled,
        equations=(*conditions, *equations) if named else (),
        witness=tuple(pins.get(j, (0.3,))[0] for j in range(1, 8)), lost_directions=np.eye(6)[: len(lost)],
        lost_freedoms=lost, named=named,
        evidence=FamilyEvidence(ObtainedFrom.STORED, text="made up"),
        soundness=Check(200, singular) if named else Check(0, 0),
        explained=Check(1000, 250),
    )  # fmt: skip


def made_up(*rows: Family, explained: int = 1000, complete: bool = True) -> Analysis:
    """An analysis of the PA-10 with the rows given: for what is shown, not for what is true."""
    robot = open_robot("pa10")
    task = resolve_task(None, robot, length_scale=1.4)
    unseen = Unseen(0.0, 0.003, Estimator.GOOD_TURING, once=0, pieces=8, number=1000)
    coranks = (
        CorankSummary(1, 5, 10_000, 9_999, 1, 0, 0.0053, Check(1000, explained), 0, unseen),
        CorankSummary(2, 4, 10_000, 0, 10_000, 0, 0.3273, Check(0, 0), 0, Unseen(1.0, 1.0, Estimator.NO_POINT)),
    )
    return Analysis(
        robot, task, 6, Settings(0, 10_000, False, 1.4, DEFAULT, "0.1.0"), coranks, rows,
        complete=complete, unfinished=None if complete else 3,
    )  # fmt: skip


def every_shape() -> Analysis:
    """Every shape a row can have: a long name, exact values, other values, coupled joints, no condition, two words."""
    zero = (0,) * 7
    arm = Equation((Term(0.9087, "cos", (0, 2, 0, 0, 0, 0, 0), zero), Term(1.0, "cos", (0, 2, 2, 0, 0, 0, 0), zero)))
    tie = LostFreedom((0.0, 0.0, 0.91, 0.0, 0.41, 0.0), Frame(4), everywhere=True)
    return made_up(
        family(1, "shoulder: axes 1 and 3 aligned, upper arm at right angles", {2: ZERO, 3: HALF}),
        family(2, "elbow", {4: ZERO}, lost=(tie,)),
        family(3, "shoulder in line with the wrist", {4: (0.7731, -0.7731)}, coupled=(2, 3), equations=(arm,)),
        family(4, "unnamed", {}, coupled=(3, 5, 6), named=False, lost=(TURN_X,) * 2),
        explained=990,
    )
