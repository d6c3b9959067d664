"""The monitor: rank, family, lost directions and distance of many configurations, fast enough for a control loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cbrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop._handles import chain_of, configurations, task_view
from rankdrop.errors import OptionError
from rankdrop.family.equation import Equation
from rankdrop.family.record import Family
from rankdrop.local.block import generic_rank, joint_scale
from rankdrop.local.verdict import one_configuration
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

Index = NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Sightings:
    """What a monitor sees at B configurations; r is the generic rank.

    Attributes:
        sigma: (B, min(m, n)) singular values of the task Jacobian, descending [1].
        rank: (B,) number of the first r of them above the tolerance.
        corank: (B,) r − rank.
        family: (B,) index of the family that the configuration lies on; −1 at regular configurations and where none
            of the families holds. Of several the one of highest corank, among those the one of smallest dimension; its
            corank is below that of the configuration where only larger families meet.
        nearest: (B,) index of the family that the smallest motion reaches, singular or not: of the pinned joints to
            their nearest values, of the coupled ones to first order. −1 without families.
        residual: (B,) largest |f|/|∇f| over the equations of `family`, or of `nearest` where that is −1 [rad; metres
            divided by the length scale]: never far above the distance to it. inf without families.
        u: (B, m, m) left singular vectors of the task Jacobian as columns: the last m − rank are lost, weakest last.
        v: (B, n, n) right singular vectors as columns: the last n − rank do not move the task.
        distance: (B,) σ_r/‖∇σ_r‖, the first-order distance to the singular set, joint motions divided by
            `joint_scale` [rad]; 0 at singular configurations.
    """

    sigma: Array
    rank: Index
    corank: Index
    family: Index
    nearest: Index
    residual: Array
    u: Array
    v: Array
    distance: Array


@dataclass(slots=True)
class Sighting:
    """What a monitor sees at one configuration: as `Sightings`, without its first axis and without v."""

    sigma: Array
    rank: int
    corank: int
    family: int
    nearest: int
    residual: float
    u: Array
    distance: float


class Monitor:
    """Watches one arm and task against given families.

    Args:
        robot: the arm.
        task: from `resolve_task`.
        families: of this arm and task (`Analysis.families`); those without equations are never named.
        tolerances: `singular` decides the rank, `explained` how near a singular configuration has to be to a family.
            Where none of the same corank is, the nearest one counts up to the cube root of `singular`: where sheets
            cross, σ is of second or third order in the distance. `Sightings.residual` says how far it is.

    Raises:
        OptionError: a family of an arm with another number of joints.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> seen = Monitor(arm, resolve_task(None, arm), ()).look([[0.0] * 7, [0.1, 0.5, 0.2, 0.9, 0.3, 0.8, 0.0]])
        >>> seen.corank.tolist(), seen.family.tolist()
        ([3, 0], [-1, -1])
    """

    def __init__(self, robot: Robot, task: Task, families: Sequence[Family], tolerances: Tolerances = DEFAULT) -> None:
        self.robot, self.task, self.families = robot, task, tuple(families)
        self.generic_rank = generic_rank(robot, task)
        self.tolerances = tolerances
        usable = [i for i, family in enumerate(self.families) if family.equations]
        order = sorted(usable, key=lambda i: (-self.families[i].corank, self.families[i].dimension, i))
        self._numbers = [*order, -1]  # number in the core -> index; the core's −1 finds the last entry
        self._order = np.array(self._numbers, dtype=np.int32)
        self._table = compiled([self.families[i] for i in order], robot, task)
        self._chain, self._view = chain_of(robot), task_view(robot, task)
        self._settings = _core.MonitorSettings(
            generic=self.generic_rank, singular=tolerances.singular, on=tolerances.explained,
            loose=cbrt(tolerances.singular),
        )  # fmt: skip

    def look(self, Q: ArrayLike, threads: int = 0) -> Sightings:
        """All of it for configurations Q.

        Args:
            Q: (B, n) [rad or m].
            threads: 0 for all cores; the result does not depend on it.

        Raises:
            ConfigurationError: Q has the wrong shape or is not finite.
        """
        rows, _ = configurations(self.robot, Q)
        sigma, rank, family, nearest, residual, u, v, distance = _core.monitor(
            self._chain, self._view, self._table, rows, self._settings, threads=threads
        )
        return Sightings(
            sigma, rank, self.generic_rank - rank, self._order[family], self._order[nearest], residual, u, v, distance
        )

    def look_one(self, q: ArrayLike) -> Sighting:
        """All of it for one configuration (n,), by the shortest way.

        Raises:
            ConfigurationError: q is not one configuration of this arm.
        """
        if not (type(q) is np.ndarray and q.shape == (self.robot.n,) and q.dtype == np.float64):
            q = one_configuration(self.robot, q)
        seen = _core.monitor_one(self._chain, self._view, self._table, q, self._settings)
        if seen is None:
            one_configuration(self.robot, q)  # says which value is not finite
            raise AssertionError("the core and the check disagree")
        sigma, rank, family, nearest, residual, u, distance = seen
        return Sighting(
            sigma, rank, self.generic_rank - rank, self._numbers[family], self._numbers[nearest], residual, u, distance
        )


def compiled(families: Sequence[Family], robot: Robot, task: Task) -> _core.Families:
    """The equations of families as flat tables for the core, in the given order.

    Raises:
        OptionError: an equation with another number of joints than the arm.
    """
    m: list[float] = []
    shift: list[float] = []
    a: list[float] = []
    b: list[float] = []
    powers: list[int] = []
    terms, equations, coupled = [0], [0], []
    pinned: list[int] = []
    values: list[float] = []
    pins, at = [0], [0]
    for family in families:
        held = {one.number for one in family.pinned}
        for equation in family.equations:
            _check(equation, family, robot)
            table = equation.tables
            m += table.multiples.reshape(-1).tolist()
            shift += table.shift.tolist()
            a += table.cosine.tolist()
            b += table.sine.tolist()
            powers += table.powers.reshape(-1).astype(int).tolist()
            terms.append(len(shift))
            coupled.append(int(not held.issuperset(equation.joints)))
        equations.append(len(terms) - 1)
        for one in family.pinned:
            pinned.append(one.number - 1)
            values += one.values
            at.append(len(values))
        pins.append(len(pinned))
    corank = [family.corank for family in families]
    scale = joint_scale(robot, task).tolist()
    return _core.make_families(
        variables=robot.n, m=m, shift=shift, a=a, b=b, powers=powers, terms=terms, equations=equations, corank=corank,
        scale=scale, periodic=robot.periodic.astype(int).tolist(), coupled=coupled, pins=pins, pinned=pinned, at=at,
        values=values,
    )  # fmt: skip


def _check(equation: Equation, family: Family, robot: Robot) -> None:
    if equation.n != robot.n:
        raise OptionError(
            "the family is of an arm with another number of joints", where=f"family {family.id}", got=equation.n,
            allowed=f"{robot.n}, as robot {robot.name!r} has",
        )
