"""What an arm does where an ideal arm near it is singular.

Of an arm whose axes nearly meet, the families of the ideal arm (`rankdrop.robot.ideal`) are places at which σ is small
and mostly not zero. At random points of each family: how large the singular values are that vanish for the ideal arm,
and how far the arm's own nearest singular configuration is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.codec import Record, plain
from rankdrop.families.record import Family, rescaled, slides_of
from rankdrop.formula.equation import System
from rankdrop.local.block import generic_rank, sample, singular_values
from rankdrop.local.nearest import nearest_singularity
from rankdrop.problem import Problem, wrapped
from rankdrop.results.analysis import robot_to_dict
from rankdrop.results.explanation import Explanation
from rankdrop.robot.ideal import Tolerance
from rankdrop.robot.ideal import ideal as ideal_of
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.numbers import Change
from rankdrop.robot.quantities import count
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_metres, into_metres, metre_exponent, task_in_metres

POINTS = 200
"""Of each family, at most: σ is known to a few percent by then."""
SEARCHED = 20
"""Of them whose nearest singular configuration is looked for: some milliseconds each."""
_STARTS = 32  # of each of these searches: q itself is nearly singular, and most of them end there


@dataclass(frozen=True, slots=True)
class Spread:
    """Smallest, median and largest of some numbers."""

    least: float
    median: float
    most: float


@dataclass(frozen=True, slots=True)
class Nearby:
    """The arm itself where one family of the ideal arm is.

    Attributes:
        id, name, corank: of the family.
        points: how many random points of it were looked at.
        number: counted from 1, of the largest singular value that vanishes for the ideal arm there: r − corank + 1.
        sigma: that singular value of the arm itself at these points [1].
        singular: at how many of them the arm itself has this corank, or more.
        searched: from how many of them its own nearest singular configuration, of any corank, was looked for.
        distance: to it, where it was found [rad; slides divided by the length scale]; None where none was.
    """

    id: str
    name: str
    corank: int
    points: int
    number: int
    sigma: Spread
    singular: int
    searched: int
    distance: Spread | None


@dataclass(frozen=True, slots=True)
class Here:
    """The arm itself, at one configuration and where the ideal arm is singular next to it.

    Attributes:
        number: counted from 1, of the largest singular value that vanishes for the ideal arm there.
        sigma: it, of the arm itself, at the configuration [1].
        distance: from there to where the ideal arm is singular [rad]; 0 where it is so here, None where none was found.
        q: (n,) that place [rad, m].
        there: the singular value of the arm itself there [1].
    """

    number: int
    sigma: float
    distance: float | None
    q: tuple[float, ...] | None
    there: float | None


@dataclass(frozen=True, eq=False)
class Idealised:
    """An arm and the ideal one near it.

    Attributes:
        real, ideal: the arm that was given, and the one of exact structure, whose notes say so.
        tolerance: it was made with.
        changes: what was moved, and by how much.
    """

    real: Robot
    ideal: Robot
    tolerance: Tolerance
    changes: tuple[Change, ...]

    def to_dict(self, task: Task, nearby: Sequence[Nearby] = ()) -> Record:
        """Plain data: the entry "ideal" of docs/json.md.

        Args:
            task: with the length scale that σ was worked out with.
            nearby: from `nearby`.
        """
        moved = [{"name": one.name, **plain(one), "by": one.by, "text": one.text} for one in self.changes]
        return {
            "tolerance": {"text": self.tolerance.text, **plain(self.tolerance)},
            "moved": moved,
            "real": robot_to_dict(self.real, task, generic_rank(self.real, task)),
            "families": plain(tuple(nearby)),
        }

    @property
    def moved(self) -> str:
        """One sentence: how much was moved, at most by how much."""
        if not self.changes:
            return f"nothing is moved within {self.tolerance.text}: the arm is as exact as it can be"
        return self.ideal.notes[-1]


def idealised(robot: Robot, tolerance: Tolerance) -> Idealised:
    """The nearest arm of exact structure, with a note that says what it is.

    Raises:
        OptionError: the tolerance is outside what is allowed.

    Example:
        >>> from rankdrop.robot.ideal import read_tolerance
        >>> from rankdrop.robot.open import open_robot
        >>> idealised(open_robot("gen3"), read_tolerance("13mm")).moved
        'not the arm itself but the ideal one within 13mm: 3 lengths moved, at most 12.8 mm'
    """
    found, changes = ideal_of(robot, length=tolerance.length, angle=tolerance.angle)
    if changes:
        found = replace(found, name=f"{robot.name}_ideal", notes=(*found.notes, _note(tolerance, changes)))
    return Idealised(robot, found, tolerance, changes)


def _note(tolerance: Tolerance, changes: Sequence[Change]) -> str:
    turned = [change.by for change in changes if change.turns]
    moved = [change.by for change in changes if not change.turns]
    what = [count(len(x), name) for x, name in ((turned, "angle"), (moved, "length")) if x]
    if turned:
        most = [f"{np.degrees(max(turned)):.3g}°"]
    else:
        most = []
    if moved:
        most += [f"{max(moved) * 1e3:.3g} mm"]
    return (
        f"not the arm itself but the ideal one within {tolerance.text}: {' and '.join(what)} moved, at most "
        f"{', '.join(most)}"
    )


def nearby(arm: Idealised, task: Task, families: Sequence[Family], *, seed: int = 0) -> tuple[Nearby, ...]:
    """What the arm itself does on each family of the ideal one; some seconds at most.

    Args:
        arm: from `idealised`.
        task: of both.
        families: of the ideal arm, for this task; one without equations is looked at where its witness is.
        seed: of every random choice.

    Example:
        >>> from rankdrop.verbs.analyze import analyze
        >>> from rankdrop.robot.ideal import read_tolerance
        >>> from rankdrop.robot.open import open_robot
        >>> arm = idealised(open_robot("gen3_6dof"), read_tolerance("1.1mm"))
        >>> found = analyze(arm.ideal, starts=300, exact="off")
        >>> [(one.id, one.sigma.median < 1e-3) for one in nearby(arm, found.task, found.of_corank(1))]
        [('k1.f1', True), ('k1.f2', True), ('k1.f3', True)]
    """
    plain_task = task_in_metres(replace(task, length_scale=task.scale(arm.ideal)), arm.ideal)
    real, model = in_metres(arm.real), in_metres(arm.ideal)
    rank = generic_rank(model, plain_task)
    return tuple(
        _nearby(real, plain_task, rank, one, _points(arm.ideal, model, plain_task, one, seed), seed) for one in families
    )


def _points(given: Robot, model: Robot, task: Task, family: Family, seed: int) -> Array:
    """(≤ POINTS, n) random configurations of `model`, the arm in metres, on a family of the arm as given."""
    power = -metre_exponent(given)
    equations = tuple(rescaled(one, slides_of(given), power) for one in family.equations)
    found = np.empty((0, model.n))
    if equations:
        q, solved = System(equations).solve(sample(model, task, POINTS, seed))
        q = wrapped(model, q[solved])
        found = q[Problem(model, task, family.corank).singular(q)]
    if len(found):
        return found
    return into_metres(given, [family.witness])


def _nearby(real: Robot, task: Task, rank: int, family: Family, q: Array, seed: int) -> Nearby:
    kept = rank - family.corank
    sigma = singular_values(real, q, task)[:, kept]
    searched = min(SEARCHED, len(q))
    found = [nearest_singularity(real, one, task, starts=_STARTS, seed=seed) for one in q[:searched]]
    away = [one.distance for one in found if one is not None]
    return Nearby(
        id=family.id, name=family.name, corank=family.corank, points=len(q), number=kept + 1, sigma=_spread(sigma),
        singular=int((sigma <= DEFAULT.singular).sum()), searched=searched, distance=_spread(away) if away else None,
    )  # fmt: skip


def _spread(values: ArrayLike) -> Spread:
    x = np.asarray(values)
    return Spread(float(x.min()), float(np.median(x)), float(x.max()))


def here(arm: Idealised, explanation: Explanation) -> Here:
    """The arm itself at the configuration explained, and where the ideal arm is singular next to it.

    Args:
        arm: from `idealised`.
        explanation: the explanation of `arm.ideal`.
    """
    r, task = explanation.rank.generic_rank, task_in_metres(explanation.task, arm.ideal)
    corank, q, distance = explanation.rank.corank, explanation.q, 0.0
    if not corank and explanation.far.nearest is not None:
        nearest = explanation.far.nearest
        corank, q, distance = nearest.corank, np.array(nearest.q), nearest.distance
    number = max(r - max(corank, 1) + 1, 1)
    rows = into_metres(arm.real, np.stack([explanation.q, q]))
    sigma = singular_values(in_metres(arm.real), rows, task)[:, number - 1]
    if not corank:
        return Here(number, float(sigma[0]), None, None, None)
    return Here(number, float(sigma[0]), distance, tuple(q.tolist()), float(sigma[1]))


def here_section(arm: Idealised, here: Here) -> Section:
    """The same in two lines."""
    name = f"σ{here.number}"
    lines = [f"{name} of the arm itself here: {_short(here.sigma)}"]
    if here.distance is None or here.there is None:
        lines.insert(0, "no singular configuration of the ideal arm was found from here")
    elif here.distance == 0.0:
        lines = [f"the ideal arm is singular here; this arm's {name} here is {_short(here.there)}"]
    else:
        away = f"{np.degrees(here.distance):.2g}° from here"
        lines.insert(0, f"the ideal arm is singular {away}; this arm's {name} there is {_short(here.there)}")
    return Section("Ideal arm", "" if arm.changes else arm.moved, tuple(lines))


def moved_section(arm: Idealised) -> Section:
    """What was moved, and by how much."""
    rows = tuple((one.name, ", ".join(map(str, one.joints)), *_moved(one)) for one in arm.changes)
    return Section(
        "What was moved", "" if rows else arm.moved,
        columns=("number", "joints", "from", "to", "by") if rows else (), rows=rows, texts=(0, 1),
        notes=("numbers not listed are unchanged",) if rows else (),
    )  # fmt: skip


def there_section(nearby: Sequence[Nearby]) -> Section:
    """σ of the arm itself on each family of the ideal one, and how far its own nearest singular configuration is."""
    rows = tuple(
        (f"{one.id}  {one.name}", f"σ{one.number}", *map(_short, astuple(one.sigma)), *_away(one)) for one in nearby
    )
    columns = ("family of the ideal arm", "", "least", "median", "largest", "nearest", "median")
    points = max(one.points for one in nearby)
    searched = max(one.searched for one in nearby)
    notes = (
        f"σ: of the arm itself at up to {points} random points of each family, the largest that vanishes for the ideal "
        "arm.",
        f"nearest, median: from {searched} of them, the ways to the nearest configurations found at which the arm "
        "itself is singular.",
    )
    return Section("The arm itself there", "", columns=columns, rows=rows, notes=notes)


def _moved(change: Change) -> tuple[str, str, str]:
    if change.kind in ("base", "tip"):
        return "", "", f"{np.degrees(change.by):.2g}°"
    before, after = change.ends
    return before, after, f"{np.degrees(change.by):.3g}°" if change.turns else f"{change.by * 1e3:.3g} mm"


def _away(nearby: Nearby) -> tuple[str, str]:
    if nearby.distance is None:
        return "none found", ""
    return f"{_degrees(nearby.distance.least)}", f"{_degrees(nearby.distance.median)}"


def _degrees(distance: float) -> str:
    if distance > DEFAULT.singular:
        return f"{np.degrees(distance):.2g}°".replace("-", "−")
    return "0°"


def _short(value: float) -> str:
    if value <= DEFAULT.singular:
        return "0"
    return f"{value:.2g}".replace("-", "−")
