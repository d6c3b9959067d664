"""Solutions of a pose in words: how many there are, a table of them, how they were searched, why there is none."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from typing import Any

import numpy as np

from rankdrop.local.orientation import orientation_coordinates, rotation_vector
from rankdrop.local.pointing import fitting_task
from rankdrop.options import advise
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import BASE, Task
from rankdrop.text.places import joints_words
from rankdrop.text.postures import meaning_lines, posture_words
from rankdrop.text.words import joint_word, minus, motion, plural, power, short
from rankdrop.tolerances import MISSED
from rankdrop.units import counted_exponent, counted_length

_SHAPES = {1: "curve", 2: "surface"}
_AXIS = 5e-3  # components below it are 0.00 as shown: the axis is X, Y or Z
_FAR = 30.0  # a position farther outside, in reaches of the arm, was hardly meant in metres


def tool_place(robot: Robot, pose: Array) -> str:
    """Where the tool is, in base axes: "(300.0, 200.0, 400.0) mm, roll 0.0°, pitch 68.8°, yaw 22.9°".

    The lengths of an arm that is not given in metres are printed as they are read, in m.

    Args:
        robot: the arm.
        pose: (4, 4) of the tool in the base frame.
    """
    _, angles = _place_and_angles(robot, pose)
    roll, pitch, yaw = (_fixed_point(value, 2) for value in angles)
    return f"{tip_place(robot, pose)}, roll {roll}°, pitch {pitch}°, yaw {yaw}°"


def tip_place(robot: Robot, pose: Array) -> str:
    """Where the tip is, in base axes: "(300.0, 200.0, 400.0) mm"."""
    place, _ = _place_and_angles(robot, pose)
    at = ", ".join(_fixed_point(value) for value in place)
    return f"({at}) {_length_unit(robot)}"


def tool_sentence(robot: Robot, pose: Array) -> str:
    """Where the tool is, as a sentence that fits a line: base axes, mm or m, roll, pitch and yaw in degrees."""
    place, angles = _place_and_angles(robot, pose)
    at = ", ".join(_fixed_point(value) for value in place)
    turned = ", ".join(_fixed_point(value) for value in angles)
    return f"Tool at ({at}) {_length_unit(robot)}, rpy ({turned})°, base axes."


def _place_and_angles(robot: Robot, pose: Array) -> tuple[Array, Array]:
    """(3,) place of the tool in the base [mm, or m]; (3,) roll, pitch, yaw of its axes [°]."""
    place = pose[:3, 3]
    if _length_unit(robot) == "mm":
        place = 1e3 * place
    angles = np.degrees(orientation_coordinates(pose[:3, :3], "rpy"))
    return place, angles


def _length_unit(robot: Robot) -> str:
    """The unit of printed lengths: mm, but for an arm that reaches so far that its numbers are hardly metres."""
    if counted_exponent(robot) > 0:
        return "m"
    return "mm"


def _fixed_point(value: float, digits: int = 1) -> str:
    return minus(f"{round(float(value), digits) + 0.0:.{digits}f}")


def missed_words(robot: Robot, away: float, turned: float) -> str:
    """By how much an arm with too few joints misses poses that are rounded.

    Args:
        robot: the arm.
        away: of its tip [m].
        turned: of its axes [rad].
    """
    allowed = f"{_length(counted_length(robot) * MISSED[0], robot)} and {short(degrees(MISSED[1]), 2)}°"
    return (
        f"{robot.n} joints take the nearest pose in reach: the tool misses the pose by up to {_length(away, robot)} "
        f"and {short(degrees(turned), 2)}° (at most {allowed}, for rounded poses)"
    )


def inverse_sentence(inverse: Any) -> str:
    """How many solutions a pose has, or why it has none."""
    if inverse.unreached is not None:
        return f"{inverse.robot.name}: no solution. {_why(inverse)}."
    parts = []
    if inverse.continua:
        parts.append(_continua_words(inverse))
    if inverse.branches or not inverse.continua:
        count = len(inverse.branches)
        if inverse.most and not inverse.continua:
            most = f"; a 6R arm has at most {inverse.most}"
        else:
            most = ""
        also = "isolated " if inverse.continua else ""
        parts.append(f"{count} {also}{plural('solution', count)}{most}")
    return f"{inverse.robot.name}: {'; and '.join(parts)}. {_inside_words(inverse)}."


def _continua_words(inverse: Any) -> str:
    """The self-motions: "3 self-motion curves (dimension 1): infinitely many solutions"."""
    words = []
    for dimension in sorted({continuum.dimension for continuum in inverse.continua}):
        continua = [continuum for continuum in inverse.continua if continuum.dimension == dimension]
        kind = _SHAPES.get(dimension, "set")
        if dimension == 1:
            count = f"{'at least ' if inverse.more else ''}{len(continua)} self-motion {plural(kind, len(continua))}"
        else:
            count = f"at least one self-motion {kind}"
        words.append(f"{count} (dimension {dimension}{_all_singular(continua)})")
    return f"infinitely many solutions: {' and '.join(words)}"


def _all_singular(continua: list[Any]) -> str:
    """Words behind the dimension of self-motions that are singular all over."""
    if not all(continuum.singular for continuum in continua):
        return ""
    if len(continua) == 1:
        return ", all of it singular"
    return ", all of them singular"


def _inside_words(inverse: Any) -> str:
    every = (*inverse.branches, *inverse.continua)
    if not _has_limits(inverse.robot):
        return "The arm has no joint limits"
    if inverse.continua and inverse.inside:
        return f"{_which_have(inverse.inside, len(every))} configurations inside the joint limits"
    if inverse.inside == len(every):
        if len(every) > 1:
            return "All are inside the joint limits"
        return "It is inside the joint limits"
    if inverse.inside:
        return f"{inverse.inside} of {len(every)} inside the joint limits"
    nearest = min(every, key=lambda solution: max(amount for _, amount in solution.beyond))
    beyond = f"the nearest exceeds those of {_beyond_words(inverse.robot, nearest)}"
    return f"{_none_is(inverse)} inside the joint limits; {beyond}"


def _has_limits(robot: Robot) -> bool:
    return bool(np.isfinite(robot.lower).any() or np.isfinite(robot.upper).any())


def _none_is(inverse: Any) -> str:
    """A curve is followed, so that none of it is inside; of a surface points are found."""
    if any(continuum.dimension > 1 for continuum in inverse.continua):
        return "No configuration was found"
    return "None is"


def _which_have(inside: int, count: int) -> str:
    """The start of a sentence on solutions with a place inside the limits: "It has", "All have", "1 of 7 has"."""
    if count == 1:
        return "It has"
    if inside == count:
        return "All have"
    if inside == 1:
        return f"1 of {count} has"
    return f"{inside} of {count} have"


def _beyond_words(robot: Robot, solution: Any) -> str:
    joints = robot.variables
    return ", ".join(
        f"{joint_word(number, joints[number - 1].name)} by {motion(amount, joints[number - 1].unit).lstrip('+')}"
        for number, amount in solution.beyond
    )


def _beyond_cell(robot: Robot, solution: Any) -> str:
    """Joints outside their limits: "1 by 10.9°, 4 by 20°"."""
    amounts = (
        (number, motion(amount, robot.variables[number - 1].unit).lstrip("+")) for number, amount in solution.beyond
    )
    return ", ".join(f"{number} by {amount}" for number, amount in amounts)


def _why(inverse: Any) -> str:
    """Why a pose has no solution, and how far it is out of reach."""
    why, robot = inverse.unreached, inverse.robot
    if why.kind == "tilt":
        return _tilt_words(inverse)
    if why.kind == "edge":
        return f"The pose lies beyond the edge of reach by at most {_length(why.shift, robot)}, which is rounding"
    if why.shift is None:
        shift = None
    else:
        shift = f"{_length(why.shift, robot)} with this orientation"
    turn = None
    if why.turn is not None:
        turn = f"{short(degrees(why.turn), 3)}° of {_turning(inverse.task, inverse.pose, why.turned)} at this position"
    if why.kind == "position":
        return _out_of_reach(inverse, shift)
    amounts = [amount for amount in (shift, turn) if amount is not None]
    apart = " or ".join(amounts) or "an amount that was not found"
    if why.kind == "joints":
        reached = f"{robot.n} joints reach this position with other orientations only"
        return f"{reached}: off by {apart}{_other_task(inverse)}"
    return f"This position is in reach with other orientations only: off by {apart}"


def _tilt_words(inverse: Any) -> str:
    """How far the pose is tilted, and which tilt the tool has, where no joint tilts it."""
    robot, why = inverse.robot, inverse.unreached
    _, (roll, pitch, _) = _place_and_angles(robot, why.tip)
    tilt = f"roll {_fixed_point(roll, 2)}°, pitch {_fixed_point(pitch, 2)}°"
    off = f"{short(degrees(why.turn), 3)}°"
    said = f"{robot.n} joints never tilt this tool, and the pose is tilted by {off}"
    return f"{said}. Give it the tilt of the tool: {tilt}"


def _out_of_reach(inverse: Any, shift: str | None) -> str:
    """How far the position is out of reach, and how to write it if it is one in millimetres."""
    why, robot, more = inverse.unreached, inverse.robot, ""
    if shift is not None and why.shift > 1.001 * why.position:
        more = f"; {shift}"
    if why.position > _FAR * reach(robot):
        most = float(np.abs(inverse.pose[:3, 3]).max())
        more += f". The position is read in metres; are the numbers millimetres? Write {most:.4g}mm"
    return f"Out of reach by {_length(why.position, robot)}{more}"


def other_task_note(robot: Robot, task: Task) -> str:
    """Of an arm with too few joints for a pose the task that it can do in full; "" of other arms."""
    other = fitting_task(robot, task)
    if other is None:
        return ""
    named = advise("task", other.name)
    few = f"{robot.name} has {robot.n} joints, too few for a pose"
    return f"{few}. The answer is for the pose; {named} is for all it can do"


def _other_task(inverse: Any) -> str:
    """The task that an arm with too few joints can do in full, as a sentence to be added."""
    other = fitting_task(inverse.robot, inverse.task)
    if other is None:
        return ""
    return f". {advise('task', other.name)} leaves free what they cannot do"


def _length(value: float, robot: Robot) -> str:
    unit = _length_unit(robot)
    size = value
    if unit == "mm":
        size = 1e3 * value
    if size >= 100:
        return f"{size:,.0f} {unit}"
    return f"{short(size, 3)} {unit}"


def _cells(robot: Robot, q: Array, *, deg: bool) -> Iterator[str]:
    """Joint values (n,) as cells of a table."""
    for joint, value in zip(robot.variables, q.tolist(), strict=True):
        yield _fixed_point(degrees(value), 2) if deg and joint.unit == "rad" else _fixed_point(value, 4)


def _turning(task: Task, wanted: Array, reached: Array) -> str:
    """About which axis of the base: "yaw", or "turning about (0.10, 0.99, 0.00)"."""
    vector = _needed_turn(task, wanted[:3, :3], reached[:3, :3])
    axis = vector / max(float(np.linalg.norm(vector)), 1e-300)
    large = np.flatnonzero(np.abs(axis) > _AXIS)
    if len(large) == 1:
        return ("turning about X", "turning about Y", "yaw (turning about Z)")[int(large[0])]
    return f"turning about ({', '.join(_fixed_point(x, 2) for x in axis)})"


def _needed_turn(task: Task, wanted: Array, reached: Array) -> Array:
    """(3,) along the axis in the base of the least turn from `wanted` to what the task asks of `made` (3, 3).

    A task that wants two turns leaves one axis a free. Of the tool: the turn carries R* a to R a. Of the base: it
    carries R* Rᵀ a to a. A task that wants one turn asks for the turn about its axis alone.
    """
    turns = [row - 3 for row in task.rows if row >= 3]
    whole = rotation_vector(reached @ wanted.T)
    of_tool = task.frame.axes != BASE
    if len(turns) == 3:
        return whole
    if len(turns) == 1:
        axis = np.eye(3)[turns[0]]
        if of_tool:
            axis = reached @ axis
        return np.asarray(axis * np.sign(axis @ whole))
    (free,) = {0, 1, 2} - set(turns)
    if of_tool:
        return np.cross(wanted[:, free], reached[:, free])
    axis = np.eye(3)[free]
    return np.cross(wanted @ reached.T @ axis, axis)


def inverse_sections(inverse: Any, *, deg: bool) -> tuple[Section, ...]:
    """The count, the solutions, how they were searched."""
    tone = "good" if inverse.inside else "bad"
    if {3, 4, 5} & set(inverse.task.rows):
        wanted = f"Pose: {tool_place(inverse.robot, inverse.pose)}"
    else:
        wanted = f"Position: {tip_place(inverse.robot, inverse.pose)}"
    first = Section(inverse.sentence, lines=(f"{wanted}, base axes.",), tone=tone)
    return (first, *_tables(inverse, deg=deg), Section("Search", lines=tuple(_search_lines(inverse))))


def _tables(inverse: Any, *, deg: bool) -> Iterator[Section]:
    """The isolated solutions, the self-motions, and where there is neither the nearest poses in reach."""
    robot = inverse.robot
    heads = tuple(_head(number, joint.unit, deg=deg) for number, joint in enumerate(robot.variables, start=1))
    if inverse.branches:
        rows = tuple(
            (str(number), *_branch_cells(robot, branch), *_cells(robot, branch.q, deg=deg))
            for number, branch in enumerate(inverse.branches, start=1)
        )
        yield Section("Solutions", _order_words(robot), columns=(
            "", "verdict", "posture", "joint limits", *heads), rows=rows, texts=(0, 1, 2, 3),
            notes=tuple(meaning_lines([branch.parts for branch in inverse.branches])))  # fmt: skip
    if inverse.continua:
        rows = tuple(
            (str(number), *_continuum_cells(continuum), *_cells(robot, continuum.q, deg=deg))
            for number, continuum in enumerate(inverse.continua, start=1)
        )
        yield Section("Self-motions", "the tool stands still along them; each in a usual posture", columns=(
            "", "verdict", "shape", "inside limits", *heads), rows=rows, texts=(0, 1, 2))  # fmt: skip
    why = inverse.unreached
    if why is not None and why.kind != "tilt":
        yield Section("Nearest poses in reach", "joint limits ignored", lines=_nearest_lines(robot, why, deg=deg))


def _nearest_lines(robot: Robot, why: Any, *, deg: bool) -> tuple[str, ...]:
    """The reachable poses nearest to one out of reach, and joint values that take the first."""
    tip = (f"the nearest tip: {tool_place(robot, why.tip)}", f"    at {joints_words(robot, why.near, deg=deg)}")
    if why.turned is None or why.kind == "edge":
        return tip
    return (*tip, f"the nearest orientation there: {tool_place(robot, why.turned)}")


def _order_words(robot: Robot) -> str:
    """The order of the solutions."""
    if _has_limits(robot):
        return "inside the joint limits first, then nearest to q = 0"
    return "nearest to q = 0 first"


def _head(number: int, unit: str, *, deg: bool) -> str:
    """The head of the column of a joint: its number and unit."""
    if deg and unit == "rad":
        return f"{number} [°]"
    return f"{number} [{unit}]"


def _branch_cells(robot: Robot, branch: Any) -> tuple[str, str, str]:
    """The verdict on an isolated solution, its posture, and the joints outside their limits."""
    if branch.beyond:
        limits = _beyond_cell(robot, branch)
    elif _has_limits(robot):
        limits = "inside"
    else:
        limits = "none"
    return branch.verdict, posture_words(branch.posture, branch.parts), limits


def _continuum_cells(continuum: Any) -> tuple[str, str, str]:
    """The verdict on a self-motion, its shape, and the share of it that is inside the joint limits."""
    verdict, inside = "regular", "–"
    if continuum.singular:
        verdict = "singular"
    shape = _SHAPES.get(continuum.dimension, "set")
    if continuum.closed:
        shape += ", closed"
    if continuum.dimension == 1:
        inside = f"{100 * continuum.inside:.0f} %"
    return verdict, shape, inside


def _search_lines(inverse: Any) -> Iterator[str]:
    """How the solutions were searched, and what is not proven."""
    if inverse.unreached is not None and inverse.unreached.kind == "tilt":
        yield "not searched: the tilt of the tool is the same in every configuration"
        return
    how = f"random starts of Newton's method (joint limits ignored, seed {inverse.options.seed})"
    if inverse.unreached is not None:
        yield (f"none found from {inverse.starts:,} {how}; that does not prove that there is none, and the distances "
               "are the least that were found")  # fmt: skip
        return
    yield f"found from {inverse.starts:,} {how}, of which {inverse.arrived:,} ended on a solution; not proven to be all"
    yield f"substituted back into forward kinematics: off by at most {power(max(inverse.residual, 1e-17))} (m, rad)"
    if inverse.missed is not None:
        yield missed_words(inverse.robot, *inverse.missed)
    if inverse.most is not None and len(inverse.branches) > inverse.most:
        yield f"more than {inverse.most} solutions: a fault of this package, please report it"
