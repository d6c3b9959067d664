"""The monitor: rank, family, lost directions and distance of many configurations, fast enough for a control loop.

Also an arm, its task and its families as a header that C and C++ read: what `rankdrop/monitor.h` declares.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from math import cbrt, isinf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.cover.setting import Setting, settings_for
from rankdrop.distance.many_distances import Distances, Ruler
from rankdrop.errors import OptionError
from rankdrop.families.record import Family
from rankdrop.formula.equation import equation_tables
from rankdrop.kinematics import chain_of, check_robot, configurations, one_configuration, task_view
from rankdrop.local.block import generic_rank, joint_scale
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Task, link_index, resolve_task
from rankdrop.tolerances import DEFAULT, Tolerances

Index = NDArray[np.int32]
Tables = dict[str, Any]
"""Families as lists by name."""
_Seen = tuple[Array, int, int, int, int, float, float, float, float, float, float]

START, STOP = 0.2, 0.02  # distances at which motion towards a family is slowed, and stopped [rad]

Value = int | float | str | list[int] | list[float] | list[str]

FORMAT = 3
"""`RANKDROP_ARM_FORMAT` of `src/rankdrop/include/rankdrop/monitor.h`."""
_LONG = 110  # characters of a line

_WORDS = "const char* const"
_TYPES = {
    **dict.fromkeys(("variable_names", "ids", "names"), _WORDS),
    **dict.fromkeys(
        ("turns", "variable", "row", "number", "corank", "first_turn", "turning", "angle", "powers", "first_term",
         "coupled", "first_equation", "first_pin", "pinned", "first_value", "periodic", "bound_row", "bound_link"),
        "int",
    ),
}  # fmt: skip

_LETTERS = {'"': r"\"", "\\": r"\\", "\n": " ", "\r": " ", "?": r"\?"}


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
        nearest: (B,) index of the family that the smallest motion reaches, singular or not. −1 without families.
        residual: (B,) largest |f|/|∇f| over the equations of `family`, or of `nearest` where that is −1 [rad; metres
            divided by the length scale]: never far above the distance to it. Where conditions have more than 100 terms
            (15 with six joints) and the configuration is regular, σ's own. inf without families.
        u: (B, m, m) left singular vectors of the task Jacobian as columns: the last m − rank are lost, weakest last.
        v: (B, n, n) right singular vectors as columns: the last n − rank do not move the task.
        distance: (B,) to `nearest` [rad; metres divided by the length scale], as in `Sighting`.
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


class Sighting:
    """What a monitor sees at one configuration.

    Attributes:
        rank, corank, family, nearest, residual: as in `Sightings`.
        distance: to `nearest` [rad; metres divided by the length scale]: the way of the pinned joints to their nearest
            values, and of the coupled ones to the nearest point that Newton's method on the family's conditions comes
            to from there in eight steps. Where the conditions have more than 100 terms (15 with six joints), eight
            walks onto the singular set by the kinematics, five looks each, two from q and six from points of it that
            lie near, drawn once for the monitor in about half a second; the least |q − x| + |D⁺F| of a place x that is
            near enough, beside the family's conditions. To first order where there is none. Where some family has no
            conditions, or none is given, σ_r/‖∇σ_r‖ if that is smaller. `Monitor.distances` looks farther around, and
            takes longer. inf where there is nothing to go by.
        approach: share of the joint motion that leads towards the nearest family, −1 (away) to 1; 0 without a motion.
        scaling: 0 to 1, what the motion is to be multiplied by (`Monitor.step`).
        rate_scaling: 0 to 1, what it is to be multiplied by for all joint rates to keep their limits.
        null_rate: 0 to 1, how much of `null_step` leads away from the nearest family; 0 where there is no such step.
    """

    __slots__ = ("_arrays", "_monitor", "approach", "corank", "distance", "family", "nearest", "null_rate", "rank",
                 "rate_scaling", "residual", "scaling")  # fmt: skip

    def __init__(self, seen: _Seen, monitor: Monitor) -> None:
        (self._arrays, self.rank, self.corank, family, nearest, self.residual, self.distance, self.approach,
         self.scaling, self.rate_scaling, self.null_rate) = seen  # fmt: skip
        numbers = monitor._numbers
        self.family, self.nearest = numbers[family], numbers[nearest]
        self._monitor = monitor

    @property
    def sigma(self) -> Array:
        """(min(m, n)) singular values of the task Jacobian, descending [1]."""
        return self._arrays[: self._monitor._s]

    @property
    def u(self) -> Array:
        """(m, m) left singular vectors as columns."""
        s, m = self._monitor._s, self._monitor._m
        return self._arrays[s : s + m * m].reshape(m, m)

    @property
    def lost(self) -> Array:
        """(m, m − rank) directions of the task that are lost, as columns, weakest last."""
        return self.u[:, self.rank :]

    @property
    def null_step(self) -> Array:
        """(n) internal motion away from the nearest family, of length 1 in scaled joint variables, or zeros
        (`Monitor.step`) [rad or m].
        """
        return self._arrays[self._monitor._s + self._monitor._m**2 :][: self._monitor.robot.n]

    @property
    def at_least(self) -> float:
        """No singular configuration is nearer, of a known family or not: proven, by enclosures made when this is
        read, about 1 ms; 0 where nothing is proven [rad; metres divided by the length scale].
        """
        q = self._arrays[-self._monitor.robot.n :]
        return float(self._monitor.ruler.at_least(q[None])[0])

    def __repr__(self) -> str:
        return (
            f"Sighting(rank={self.rank}, corank={self.corank}, family={self.family}, nearest={self.nearest}, "
            f"distance={self.distance:.6g}, scaling={self.scaling:.6g}, rate_scaling={self.rate_scaling:.6g})"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Nearby:
    """All families at one configuration, in the order of `Monitor.families`; nan for those without conditions.

    Attributes:
        distance: (F) to each, as in `Sighting`; to first order where a family is neither nearer than `start` nor
            than twice the nearest one [rad].
        residual: (F) largest |f|/|∇f| over its equations [rad].
        away: (F, n) gradient of `distance` by q: its rate is away · q̇, positive for motions that leave; zeros on the
            family itself [1; 1 over the length scale for slides].
    """

    distance: Array
    residual: Array
    away: Array


class Monitor:
    """Watches one arm and task against given families.

    Args:
        robot: the arm.
        task: what the end effector has to do, as in `analyze`; None for the task the arm is made for.
        families: of this arm and task (`Analysis.families`); those without equations are never named, σ_r/‖∇σ_r‖
            stands for them.
        tolerances: `singular` decides the rank, `explained` how near a singular configuration has to be to a family.
            Where none of the same corank is, the nearest one counts up to the cube root of `singular`: where sheets
            cross, σ is of second or third order in the distance. `Sightings.residual` says how far it is.
        start, stop: distances at which motion towards a family begins to be slowed, and is stopped (`step`) [rad].
        rates: (n,) largest joint rates [rad/s or m/s]; None for those of the robot.

    One monitor serves one thread at a time.

    Raises:
        OptionError: no families given; a family of an arm with another number of joints; start not above stop, or
            stop below zero; rates that are no n positive numbers.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("pa10")
        >>> seen = Monitor(arm, None, ()).look([[0.0] * 7, [0.1, 0.5, 0.2, 0.9, 0.3, 0.8, 0.0]])
        >>> seen.corank.tolist(), seen.family.tolist()
        ([3, 0], [-1, -1])
    """

    def __init__(
        self, robot: Robot, task: Task | str | Sequence[str] | None = None,
        families: Sequence[Family] | None = None,
        tolerances: Tolerances = DEFAULT, *, start: float = START, stop: float = STOP, rates: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        check_robot(robot)
        if families is None:
            raise OptionError("a monitor needs the families that it watches", where="families", got=None,
                              allowed="those of rankdrop.analyze(robot, task).families, or () for none")  # fmt: skip
        self.robot, self.task, self.families = robot, resolve_task(task, robot), tuple(families)
        self.generic_rank = generic_rank(robot, self.task)
        self.tolerances = tolerances
        self.start, self.stop = _thresholds(start, stop)
        self.rates = _rates(robot, rates)
        usable = [i for i, family in enumerate(self.families) if family.equations]
        order = sorted(usable, key=lambda i: (-self.families[i].corank, self.families[i].dimension, i))
        self.beyond = len(usable) < len(self.families) or not usable
        """Whether there may be singularities beyond the families' conditions."""
        self._numbers = [*order, -1]  # number in the core -> index; the core's −1 finds the last entry
        self._order = np.array(self._numbers, dtype=np.int32)
        self._table = compile_families(self.watched_families, robot, self.task)
        self._chain, self._view = chain_of(robot), task_view(robot, self.task)
        self._settings = _core.MonitorSettings(
            generic=self.generic_rank, **self.settings, start=self.start, stop=self.stop, beyond=self.beyond,
            rates=self.rates.tolist(),
        )
        _core.spread(self._chain, self._view, self._table, self._settings)
        self._watcher = _core.Watcher(self._chain, self._view, self._table, self._settings)
        self._shape = (robot.n,)
        self._s, self._m = min(self.task.m, robot.n), self.task.m

    @cached_property
    def ruler(self) -> Ruler:
        """What `distances` are measured with, in the whole joint space."""
        return Ruler(self.families, self.robot, self.task)

    @property
    def watched_families(self) -> tuple[Family, ...]:
        """The families with conditions, in the order in which they are preferred."""
        return tuple(self.families[i] for i in self._numbers[:-1])

    @property
    def numbers(self) -> list[int]:
        """Place in `families` of each of `watched`."""
        return self._numbers[:-1]

    @property
    def settings(self) -> dict[str, float]:
        """What counts as zero, and as on a family, by the core's names."""
        set_to = self.tolerances
        return {"singular": set_to.singular, "on": set_to.explained, "loose": cbrt(set_to.singular)}

    def header(self, mark: str | None = None) -> str:
        """All of it as a header for `rankdrop/monitor.hpp` and `rankdrop/monitor.h`: the constant `rankdrop_MARK_arm`.

        Args:
            mark: part of the constant's name; else made of the robot's.
        """
        return arm_header(self, mark=mark)

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
        """All of it for one configuration (n,), by the shortest way; `step` without a motion.

        Raises:
            ConfigurationError: q is not one configuration of this arm.
        """
        return self.step(q)

    def step(self, q: ArrayLike, velocity: ArrayLike | None = None) -> Sighting:
        """One step of a control loop: what is seen at q, how fast the motion may go on, and an internal motion away.

        With x = velocity/scale, joint by joint (scale: 1 for angles, the length scale for slides), and for every family
        its distance d and the gradient g of d by the scaled variables,

            c = max(0, −g·x/‖x‖)                  share of the motion that leads towards the family
            k = (d − stop)/(start − stop), kept within 0 … 1
            1/s = 1 − c + c/k,                    scaling = the least s of all families

        A motion away from every family, or along it, is not slowed, at whatever corank: s = 1. One straight towards a
        family goes at s = k, so that it comes to rest at `stop`; s has no jump where the motion turns, except at `stop`
        and nearer. At d ≤ `tolerances.explained` every motion leads away: an arm that stands on a singularity is let
        go. Distances are in joint space: neither units nor the number of joints matter, as they do to a condition
        number.

        `rate_scaling` = min(1, min_j rates_j/abs(velocity_j)) keeps joint rates, for motions that leave too: near a
        singularity a slow end effector may need fast joints. Multiply the motion by the smaller of the two.

        `null_step`, of arms with more joints than the task's rank r: with P the projection on the null space in scaled
        variables, the projection of P g of the nearest family on the cone {h: P g_f·h ≥ 0 for all families f nearer
        than `start`}, at length 1: the steepest internal motion away from the nearest one that approaches none of the
        others. Zeros where there is none, and at singular configurations, whose null space is more than internal
        motions (`escape` says what leads out of them).

        Args:
            q: (n,) [rad or m].
            velocity: (n,) joint rates that are about to be commanded [rad/s or m/s]; None for none.

        Raises:
            ConfigurationError: q or velocity is not one of this arm.

        Source: distances that slow an approach are Faverjon and Tournassoud's (ICRA 1987); the projection is by Lawson
        and Hanson's nonnegative least squares (1974).
        """
        if not (type(q) is np.ndarray and q.shape == self._shape and q.dtype == np.float64):
            q = one_configuration(self.robot, q)
        if velocity is not None and not (
            type(velocity) is np.ndarray and velocity.shape == self._shape and velocity.dtype == np.float64
        ):
            velocity = one_configuration(self.robot, velocity)
        seen = self._watcher.step(q, velocity)
        if seen is None:
            one_configuration(self.robot, q)  # says which value is not finite
            if velocity is not None:
                one_configuration(self.robot, velocity)
            raise AssertionError("the core and the check disagree")
        return Sighting(seen, self)

    def distances(self, Q: ArrayLike, *, along: bool = False) -> Distances:
        """Distances of configurations Q from every family and from the singular set, and proven bounds from below.

        `step` comes to the nearest point of the branch that it is on; these walk from many points, about 0.2 ms each
        where all joints are pinned and 1 to 4 ms where some are coupled (alone 1 and 10 ms), and agree with
        `nearest_singularity`.

        Args:
            Q: (B, n) [rad or m].
            along: they follow each other on a path: what is near to one is tried for the next.

        Raises:
            ConfigurationError: Q has the wrong shape or is not finite.
        """
        rows, _ = configurations(self.robot, Q)
        return self.ruler.measure(rows, along=along)

    def nearby(self, q: ArrayLike) -> Nearby:
        """Distance to every family at one configuration (n,), and where it grows.

        Raises:
            ConfigurationError: q is not one configuration of this arm.
        """
        self.step(one_configuration(self.robot, q))
        distance, residual, away = self._watcher.apart()
        order, count = self._order[:-1], len(self.families)
        nearest = Nearby(np.full(count, np.nan), np.full(count, np.nan), np.full((count, self.robot.n), np.nan))
        nearest.distance[order], nearest.residual[order], nearest.away[order] = distance, residual, away
        return nearest


def compile_families(families: Sequence[Family], robot: Robot, task: Task) -> _core.Families:
    """The equations of families as flat tables for the core, in the given order.

    Raises:
        OptionError: an equation with another number of joints than the arm.
    """
    return _core.make_families(**tables_of(families, robot, task))


def tables_of(families: Sequence[Family], robot: Robot, task: Task) -> Tables:
    """The same as lists by name, as `_core.make_families` takes them and an exported arm holds them.

    Raises:
        OptionError: an equation with another number of joints than the arm.
    """
    equations, coupled = [0], []
    pinned: list[int] = []
    values: list[float] = []
    pins, at = [0], [0]
    for family in families:
        held = {pin.number for pin in family.pinned}
        for equation in family.equations:
            if equation.n != robot.n:
                raise OptionError(
                    "the family is of an arm with another number of joints", where=f"family {family.id}",
                    got=equation.n, allowed=f"{robot.n}, as robot {robot.name!r} has",
                )  # fmt: skip
            coupled.append(int(not held.issuperset(equation.joints)))
        equations.append(len(coupled))
        for pin in family.pinned:
            pinned.append(pin.number - 1)
            values += pin.values
            at.append(len(values))
        pins.append(len(pinned))
    return {
        "variables": robot.n, **equation_tables(equation for family in families for equation in family.equations),
        "equations": equations, "corank": [family.corank for family in families],
        "scale": joint_scale(robot, task).tolist(), "periodic": robot.periodic.astype(int).tolist(),
        "coupled": coupled, "pins": pins, "pinned": pinned, "at": at, "values": values,
    }  # fmt: skip


def _thresholds(start: float, stop: float) -> tuple[float, float]:
    if not (np.isfinite(start) and 0.0 <= stop < start):
        raise OptionError("motion is slowed before it is stopped", where="start, stop", got=f"{start}, {stop}",
                          allowed="0 ≤ stop < start [rad]")  # fmt: skip
    return float(start), float(stop)


def _rates(robot: Robot, rates: ArrayLike | None) -> Array:
    limits = np.array([joint.velocity for joint in robot.variables] if rates is None else rates, dtype=np.float64)
    if limits.shape != (robot.n,) or not (limits > 0.0).all():
        raise OptionError("these are no joint rates", where="rates", got=np.asarray(rates).tolist(),
                          allowed=f"{robot.n} positive numbers")  # fmt: skip
    return limits


def arm_header(monitor: Monitor, *, mark: str | None = None) -> str:
    """The text of a header with one constant, `rankdrop_MARK_arm`, of type `rankdrop_arm`.

    It holds every number to the last digit, so that C++ sees what Python sees. Families are numbered as in
    `monitor.families`; the kernels need those with conditions in the order in which they are preferred, and `number`
    leads from that order to the list.

    Args:
        monitor: its arm, task, families, tolerances, thresholds and rates.
        mark: part of the constant's name; else made of the robot's.
    """
    name = monitor.robot.name
    mark = re.sub(r"[^A-Za-z0-9]+", "_", name if mark is None else mark).strip("_").lower() or "arm"
    plain = " ".join(name.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").split())
    made = _bounds_of(monitor)
    fields = _chain(made[0].with_tip_frame(monitor.robot) if made else monitor.robot) | _question(monitor, made)
    arrays: dict[str, str] = {}
    lines = [
        f"/* {plain} and its families of singular configurations, written by rankdrop. */",
        f"#ifndef RANKDROP_ARM_{mark.upper()}_H", f"#define RANKDROP_ARM_{mark.upper()}_H", "",
        "#include <math.h>", "#include <rankdrop/monitor.h>", "",
    ]  # fmt: skip
    for name, value in fields.items():
        if isinstance(value, list):
            arrays[name] = f"rankdrop_{mark}_{name}"
            lines += _array(arrays[name], value, _TYPES.get(name, "double"))
    lines += ["", f"static const rankdrop_arm rankdrop_{mark}_arm = {{"]
    lines += [f"    {arrays.get(name) or _c_number(value)}, /* {name} */" for name, value in fields.items()]
    return "\n".join([*lines, "};", "", "#endif", ""])


def _chain(robot: Robot) -> dict[str, Value]:
    """The chain, link by link; of an arm whose rows are proven in tool axes the frame of the last link is the tip's."""
    index = {joint.name: i for i, joint in enumerate(robot.variables)}
    screws: list[float] = []
    frames = _frame_numbers(np.eye(4))
    variable: list[int] = []
    multiplier: list[float] = []
    offset: list[float] = []
    for joint in robot.joints:
        screws += [float(x) for x in joint.screw]
        frames += _frame_numbers(joint.frame)
        mimic = joint.mimic
        variable.append(index[joint.name if mimic is None else mimic.leader])
        multiplier.append(1.0 if mimic is None else mimic.multiplier)
        offset.append(0.0 if mimic is None else mimic.offset)
    frames += _frame_numbers(robot.home)
    return {
        "format": FORMAT, "name": robot.name, "joints": len(robot.joints), "variables": robot.n,
        "screws": screws, "turns": [int(joint.kind is not JointKind.PRISMATIC) for joint in robot.joints],
        "frames": frames, "variable": variable, "multiplier": multiplier, "offset": offset,
        "variable_names": [joint.name for joint in robot.variables],
    }  # fmt: skip


def _frame_numbers(frame: Array) -> list[float]:
    """The rotation (9 numbers, row by row) and the place (3) of a frame (4, 4)."""
    rotation, place = frame[:3, :3], frame[:3, 3]
    return [*rotation.ravel().tolist(), *place.tolist()]


def _bounds_of(monitor: Monitor) -> Sequence[Setting]:
    """What enclosures are made from; none for a task that cannot be certified."""
    with suppress(OptionError):
        return settings_for(monitor.robot, monitor.task)
    return ()


def _question(monitor: Monitor, made: Sequence[Setting]) -> dict[str, Value]:
    """Task, families, thresholds, and what enclosures are made from."""
    task, joints, families = monitor.task, len(monitor.robot.joints), monitor.watched_families
    length, table = task.scale(monitor.robot), tables_of(monitor.watched_families, monitor.robot, task)
    points: list[float] = []
    reaches: list[float] = []
    for body in made:
        points += body.point
        reaches += body.arm.tolist()
    bound_rows = list(made[0].rows) if made else []
    return {
        "rows": task.m, "axes": link_index(task.frame.axes, joints, "axes"),
        "origin": link_index(task.frame.origin, joints, "origin"), "point": list(task.frame.point),
        "row": list(task.rows), "factor": [1.0 / length if row < 3 else 1.0 for row in task.rows],
        "families": len(families), "listed": len(monitor.families),
        "angles": len(table["shift"]), "terms": len(table["angle"]),
        "equations": len(table["coupled"]), "ids": [family.id for family in monitor.families],
        "names": [family.name for family in monitor.families], "number": monitor.numbers,
        "corank": table["corank"], "shift": table["shift"], "first_turn": table["turns"], "turning": table["turning"],
        "m": table["m"], "angle": table["angle"], "cosine": table["a"], "sine": table["b"], "powers": table["powers"],
        "first_term": table["terms"], "coupled": table["coupled"], "first_equation": table["equations"],
        "first_pin": table["pins"], "pinned": table["pinned"], "first_value": table["at"], "values": table["values"],
        "scale": table["scale"], "periodic": table["periodic"],
        "generic_rank": monitor.generic_rank, **monitor.settings, "start": monitor.start, "stop": monitor.stop,
        "beyond": int(monitor.beyond), "rates": monitor.rates.tolist(),
        "bounds": len(made), "bound_rows": len(bound_rows), "bound_row": bound_rows,
        "bound_link": [body.link for body in made], "bound_point": points,
        "bound_length": [body.length for body in made],
        "bound_reach": reaches,
        "bound_repeats": made[0].repeats if made else 1.0,
    }  # fmt: skip


def _array(name: str, values: Sequence[int | float | str], kind: str) -> list[str]:
    """A constant array; C has none without entries."""
    if not values:
        values = [""] if kind == _WORDS else [0]
    lines = [f"static {'' if kind == _WORDS else 'const '}{kind} {name}[] = {{"]
    return [*lines, *_wrap_lines(_c_number(value) for value in values), "};"]


def _wrap_lines(words: Iterable[str]) -> list[str]:
    lines = ["   "]
    for word in words:
        if len(lines[-1]) + len(word) > _LONG:
            lines.append("   ")
        lines[-1] += f" {word},"
    return lines


def _c_number(value: Value) -> str:
    if isinstance(value, str):
        return '"' + "".join(_LETTERS.get(letter, letter) for letter in value) + '"'
    if isinstance(value, float) and isinf(value):
        if value > 0:
            return "HUGE_VAL"
        return "-HUGE_VAL"
    return repr(value)
