"""A robot over the exact ring: its joint screws as trigonometric polynomials in joint angles and lengths.

Poses are 4 × 4 matrices of reduced trigonometric polynomials.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from functools import cached_property

import numpy as np

from rankdrop.algebra.matrix import count_terms, each_entry, with_rows
from rankdrop.algebra.polynomial import Polynomial, flint, is_number, primitive, reciprocal
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.roots import ROOTS, Number, root_values, roots_of
from rankdrop.algebra.work import OutOfTime
from rankdrop.errors import RobotError, TaskError
from rankdrop.exact.arm.geometry import (
    Deviation,
    JointAndLink,
    decimals,
    exact_cosine,
    first_and_last,
    named_lengths,
    sections,
    tip_roundings,
)
from rankdrop.exact.arm.parts import in_parts, parts_of
from rankdrop.lists import flat_map
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import BODY, WORLD_ALIGNED, Task, resolve_task
from rankdrop.units import exponent, in_units, into_units, task_in_units

Matrix = list[list[Polynomial]]

WIDE = 8
"""Joints for the six rows of a pose beyond which letters, and dependent-screw suppression, take longer than they may:
the sets of lower rank bind four freedoms and more, of as many conditions in letters."""


def identity(ring: Ring) -> Matrix:
    """The pose of a frame in itself."""
    return [[ring.one if i == j else ring.zero for j in range(4)] for i in range(4)]


def times(ring: Ring, one: Matrix, two: Matrix) -> Matrix:
    """One pose after another."""
    return [[ring.reduce(_inner(ring, row, [two[k][j] for k in range(4)])) for j in range(4)] for row in one]


def _inner(ring: Ring, row: list[Polynomial], column: list[Polynomial]) -> Polynomial:
    """Σ a_k b_k, not reduced."""
    return sum((ring.product(a, b) for a, b in zip(row, column, strict=True) if a != 0 and b != 0), ring.zero)


def inverse(ring: Ring, pose: Matrix) -> Matrix:
    """Of the pose of one frame in another, the pose of the other in the one."""
    turned = [[pose[j][i] for j in range(3)] for i in range(3)]
    back = [ring.reduce(-sum((turned[i][k] * pose[k][3] for k in range(3)), ring.zero)) for i in range(3)]
    return [[*turned[i], back[i]] for i in range(3)] + [[ring.zero, ring.zero, ring.zero, ring.one]]


def joint_screw(ring: Ring, pose: Matrix, kind: JointKind) -> list[Polynomial]:
    """The screw (v; ω) of a joint along z of a pose: v = p × z; of a slide (z; 0)."""
    axis, point = [pose[i][2] for i in range(3)], [pose[i][3] for i in range(3)]
    if kind is JointKind.PRISMATIC:
        return [*axis, ring.zero, ring.zero, ring.zero]
    return [*_cross(ring, point, axis), *axis]


def multiple(ring: Ring, j: int, m: int) -> tuple[Polynomial, Polynomial]:
    """(cos, sin) of m θ_j for a whole m, from cos (k + 1)θ = cos kθ cos θ − sin kθ sin θ, and so on."""
    cosine, sine = ring.one, ring.zero
    for _ in range(abs(m)):
        cosine, sine = (
            ring.reduce(cosine * ring.c[j] - sine * ring.s[j]),
            ring.reduce(sine * ring.c[j] + cosine * ring.s[j]),
        )
    return cosine, sine if m >= 0 else -sine


def shift_screw(ring: Ring, screw: list[Polynomial], point: list[Polynomial]) -> list[Polynomial]:
    """The screw with its linear part taken at another point: v + ω × point."""
    cross = _cross(ring, screw[3:], point)
    return [*(ring.reduce(v + w) for v, w in zip(screw[:3], cross, strict=True)), *screw[3:]]


def _cross(ring: Ring, a: list[Polynomial], b: list[Polynomial]) -> list[Polynomial]:
    return [ring.reduce(ring.product(a[i - 2], b[i - 1]) - ring.product(a[i - 1], b[i - 2])) for i in range(3)]


def ring_of(robot: Robot, letters: Iterable[str]) -> Ring:
    """The ring that an arm's screws live in; variables are numbered from 1, parts of angles are known to it."""
    kinds = [joint.kind for joint in robot.variables]
    revolute, prismatic = (
        [i for i, kind in enumerate(kinds, 1) if kind is wanted] for wanted in (JointKind.REVOLUTE, JointKind.PRISMATIC)
    )
    parts = {j: part for j, part in enumerate(parts_of(robot), 1) if part > 1}
    return Ring(revolute, prismatic, tuple(letters), parts)


def numbers_in_units(numbers: Mapping[str, float], power: int) -> dict[str, float]:
    """Values of letters in a unit of 10 to a power: they are decimals, and are moved as such."""
    return {
        name: value if name in ROOTS else float(Decimal(repr(value)).scaleb(-power)) for name, value in numbers.items()
    }


def polynomial_in_units(f: Polynomial, letters: Container[str], power: int) -> Polynomial:
    """A polynomial of either ring, in lengths and slides of a unit of 10 to a power."""
    names = f.context().names()
    lengths = [i for i, name in enumerate(names) if (name in letters and name not in ROOTS) or name[0] == "q"]
    if not power or f == 0 or not any(f.degrees()[i] for i in lengths):
        return f
    ten, context = flint().fmpq(10), f.context()
    moved = {e: c * ten ** (power * sum(int(e[i]) for i in lengths)) for e, c in f.to_dict().items()}
    return primitive(context.from_dict(moved)) * (1 if f.coeffs()[0] > 0 else -1)


def clear_pivots(ring: Ring, columns: list[list[Polynomial]]) -> tuple[list[list[Polynomial]], int]:
    """The columns of a smaller matrix, and by how much its rank is lower than theirs, everywhere.

    Args:
        ring: of the entries.
        columns: of a matrix over `ring.trig`.

    Of the numbers that could clear a row and a column the one whose own row and column are shortest is taken first:
    what it adds to other entries is shortest.
    """
    left, lower = [list(column) for column in columns], 0
    while min(len(left), len(left[0])) > 1 and (place := _pivot(left)) is not None:
        j, i = place
        pivot = left.pop(j)
        row = [column.pop(i) for column in left]
        inverse = reciprocal(pivot.pop(i))
        for column, value in zip(left, row, strict=True):
            if value != 0:
                for k, entry in enumerate(pivot):
                    if entry != 0:
                        column[k] = ring.reduce(column[k] - entry * value * inverse)
        lower += 1
    return left, lower


def _pivot(columns: list[list[Polynomial]]) -> tuple[int, int] | None:
    """(column, row) of the number that is cheapest to clear with; None where no entry is a number."""
    best: tuple[int, int, int] | None = None
    for j, column in enumerate(columns):
        for i, entry in enumerate(column):
            if entry != 0 and is_number(entry):
                across = sum(len(other[i]) for other in columns if other is not column and other[i] != 0)
                down = sum(len(x) for k, x in enumerate(column) if k != i and x != 0)
                if best is None or across * down < best[0]:
                    best = (across * down, j, i)
    return None if best is None else best[1:]


@dataclass(frozen=True)
class Chain:
    """A robot made exact.

    Attributes:
        robot, task: as given.
        sections: twists, lengths and phases of the N joints, exact; joints that follow others are among them. The n
            variables are what conditions speak of, and column v of the Jacobian is Σ m_j $_j over the joints j that
            variable v moves.
        letters: value [m] of each length that is a symbol, by its name.
        written: how each length reads: (section index, "a" or "d") -> (sign, letter); absent for numbers and zeros.
            Index N is the tip: its x ("a") and z ("d") in the frame of link n, for tasks that depend on them.
        roundings: numbers of the arm that are replaced by others, lengths that are letters included.
        unused: letters of the robot that stand for no length of conditions, and their values [m].

    Conditions are written in the unit of length that the arm was given in. Whatever is computed with floating-point
    numbers is computed in the arm's own one (`units`): `own`, `own_task`, `own_numbers` and `own_polynomial`.
    """

    robot: Robot
    task: Task
    sections: tuple[JointAndLink, ...]
    letters: Mapping[str, Fraction]
    written: Mapping[tuple[int, str], tuple[int, str]]
    roundings: tuple[Deviation, ...]
    unused: tuple[tuple[str, float], ...]

    @property
    def effective_roundings(self) -> tuple[Deviation, ...]:
        """What the derivation rounds: a length that is a letter stands for any value."""
        places = ((deviation, deviation.joints[0] - 1) for deviation in self.roundings)
        counted = ((deviation, k) for deviation, k in places if self._counts(k, deviation.kind))
        return tuple(deviation for deviation, k in counted if (k, deviation.kind) not in self.written)

    def _counts(self, place: int, kind: str) -> bool:
        """Whether conditions depend on a number: not on the first offset, nor on what lies behind the last axis."""
        return 0 < place < self.links - 1 or place == self.links or kind == "twist" or (place, kind) == (0, "a")

    @property
    def n(self) -> int:
        """Number of variables: of columns of the Jacobian."""
        return self.robot.n

    @property
    def links(self) -> int:
        """Number N of joints and of the links after them; more than n where joints follow others."""
        return len(self.sections)

    @property
    def has_mimics(self) -> bool:
        """Whether some joint follows another one, so that a column of the Jacobian may be a sum of screws."""
        return self.links > self.n

    @cached_property
    def ring(self) -> Ring:
        """The ring its screws live in."""
        return ring_of(self.robot, (*self.letters, *self.roots))

    @cached_property
    def roots(self) -> list[str]:
        """Names of the roots in the arm's numbers, out of `ROOTS`."""
        turns = flat_map(lambda section: (section.twist, section.phase), self.sections)
        if self.task.m == 6:
            axes = []
        else:
            axes = [x for rows in (self._start, self._end) for row in rows for x in row]
        return roots_of([*(x for turn in turns for x in (turn.cos, turn.sin)), *axes])

    @cached_property
    def shifts(self) -> Array:
        """(n,) what is to be added to q of `parted` to get the variables of the conditions: θ = q + shift [rad, m]."""
        return np.asarray(self.whole_shifts / np.array(parts_of(self.robot)))

    @cached_property
    def whole_shifts(self) -> Array:
        """(n,) the same for q of the robot, and whole angles θ of its joints [rad, m]."""
        free = (section for section, joint in zip(self.sections, self.robot.joints, strict=True) if joint.mimic is None)
        return np.array([section.shift for section in free])

    def theta(self, q: Array) -> Array:
        """(..., n) the variables of the conditions at configurations of the robot, slides in the arm's own unit."""
        return np.asarray(into_units(self.robot, q) / np.array(parts_of(self.robot)) + self.shifts)

    @cached_property
    def numbers(self) -> dict[str, float]:
        """Values of the letters [m] and the roots as floats."""
        return {**{name: float(value) for name, value in self.letters.items()}, **root_values(self.roots)}

    @property
    def power(self) -> int:
        """Power of ten of the arm's own unit of length."""
        return exponent(self.robot)

    @cached_property
    def with_part_angles(self) -> Robot:
        """The robot with the angles that conditions speak of as its variables: itself, but for parts of angles."""
        return in_parts(self.robot)

    @property
    def own(self) -> Robot:
        """`parted` in its own unit: all that is computed with numbers during a derivation is of this arm."""
        return in_units(self.with_part_angles)

    @cached_property
    def own_task(self) -> Task:
        """The task for `own`."""
        return task_in_units(self.task, self.robot)

    @cached_property
    def own_numbers(self) -> dict[str, float]:
        """The letters' values in the arm's own unit."""
        return numbers_in_units(self.numbers, self.power)

    def own_polynomial(self, f: Polynomial) -> Polynomial:
        """A polynomial of either ring, in lengths and slides of the arm's own unit."""
        return polynomial_in_units(f, self.letters, self.power)

    @property
    def tip(self) -> tuple[Fraction, Fraction, Fraction]:
        """Position of the tip in the frame of link N, lengths as numbers."""
        x, y, z = _tip(self.robot)
        return x, y, z

    def length(self, place: int, which: str) -> Polynomial:
        """Length "a" or "d" of section `place` (from 0) as an element of the trigonometric ring."""
        return self._length(place, which, getattr(self.sections[place], which))

    def _length(self, place: int, which: str, value: Fraction) -> Polynomial:
        if (place, which) in self.written:
            sign, letter = self.written[place, which]
            return self.ring.letter[letter] * sign
        return self.ring.constant(value)

    @cached_property
    def frame(self) -> int:
        """The link frame (1 … N − 1) in which the screws are shortest.

        Raises:
            OutOfTime: they are too long in each.
        """
        if self.links == 1:
            return 1

        terms: dict[int, int] = {}
        for k in sorted(self.frames, key=lambda k: abs(2 * k - self.links)):
            try:
                terms[k] = count_terms(self.screws(k))
            except OutOfTime:
                if not terms:  # not even in the middle
                    raise
        return min(terms, key=lambda k: (terms[k], abs(2 * k - self.links)))

    @property
    def frames(self) -> range:
        """The link frames that are tried: of a long arm those in its middle, for every joint between makes the screws
        of general arms three times longer."""
        if self.links > WIDE:
            near = self.links // 4
        else:
            near = 0
        return range(1 + near, self.links - near)

    @cached_property
    def columns(self) -> list[list[Polynomial]]:
        """The n columns of the task Jacobian, one entry per row of the task, in the axes where they are shortest.

        For all six rows: the screws (v; ω) in the frame of link `frame`. For the three of translation: at the tip. The
        axes do not matter for either. Other rows are taken in the task's own axes, less a turn about the first axis
        that does not change their span.
        """
        rows = self.task.rows
        if rows == (0, 1, 2, 3, 4, 5):
            return self.screws(self.frame)
        if rows in ((0, 1, 2), (3, 4, 5)):
            return min(
                (with_rows(self.screws_at_tip(k), rows) for k in (*self.frames, self.links)),
                key=count_terms,
            )
        return with_rows(self._in_task_axes(), rows)

    @cached_property
    def cleared_columns(self) -> tuple[list[list[Polynomial]], int]:
        """Columns of a matrix, and by how much its rank is lower than that of the arm's Jacobian, everywhere.

        The smallest cleared matrix over the frames of the links, counted by its terms times its rows. Of three rows
        and less, and where a task has as many other rows as there are joints, the Jacobian as it stands.
        """
        m = self.task.m
        if m <= 3 or m == self.n < 6:
            return self.columns, 0
        columns_seen = self.screws if m == 6 else self.task_columns
        views = (clear_pivots(self.ring, columns_seen(k)) for k in self.frames or (1,))
        columns, lower = min(
            views, key=lambda view: sum(len(x) for column in view[0] for x in column if x != 0) * len(view[0][0])
        )
        return columns, lower + m - 6

    def screws(self, k: int) -> list[list[Polynomial]]:
        """The n columns (v; ω) in the frame of link k (1 … N): z along axis k, x along the normal after it.

        The screw of each joint; of a variable that moves several the sum of theirs, each times its multiplier.
        """
        if k not in self._screws:
            self._screws[k] = self._sum_followers(self.screws_near(k, range(1, self.links + 1)))
        return self._screws[k]

    def _sum_followers(self, screws: list[list[Polynomial]]) -> list[list[Polynomial]]:
        """(n, 6) columns Σ m_j $_j of the variables, from the (N, 6) screws of the joints."""
        if not self.has_mimics:
            return screws
        sums = [[self.ring.zero] * 6 for _ in range(self.n)]
        for section, screw in zip(self.sections, screws, strict=True):
            column, m = sums[section.variable - 1], self.ring.constant(section.rate)
            sums[section.variable - 1] = [x + m * y for x, y in zip(column, screw, strict=True)]
        return each_entry(self.ring.reduce, sums)

    def screws_about(self, k: int, m: int) -> list[list[Polynomial]]:
        """The n columns in the axes of link k, the linear part taken at the origin of the frame of link m."""
        pose = self.link_pose(k, m)
        point = [pose[i][3] for i in range(3)]
        if k == m:
            return self.screws(k)
        return [shift_screw(self.ring, screw, point) for screw in self.screws(k)]

    def link_pose(self, k: int, m: int) -> Matrix:
        """The pose of the frame of link m in that of link k."""
        if m != k:
            pose = next(pose for j, pose in self._poses(k) if j == m)
        else:
            pose = identity(self.ring)
        return times(self.ring, pose, self._joint(m)) if m > k else pose  # the frame before joint m turns and slides

    def task_columns(self, k: int) -> list[list[Polynomial]]:
        """The joint screws in the frame of link k, and one for each row that the task leaves out: a turn about that
        axis of the task through the tip, or a translation along it.

        Their rank is that of the task's rows, plus the number of rows left out: a combination of joint screws has no
        part in the task's rows where it is one of the added screws.
        """
        ring = self.ring
        last = self.link_pose(k, self.links)
        if self.in_body:
            first = last
        else:
            first = times(ring, self.link_pose(k, 1), inverse(ring, self._joint(1)))
        tip = self._tip_in(last)
        columns = list(self.screws(k))
        for row in sorted({*range(6)} - {*self.task.rows}):
            along = [ring.constant(x) for x in self.task_axes[row % 3]]
            axis = [ring.reduce(_inner(ring, first[i][:3], along)) for i in range(3)]
            columns.append([*_cross(ring, tip, axis), *axis] if row > 2 else [*axis, ring.zero, ring.zero, ring.zero])
        return columns

    def _tip_in(self, last: Matrix) -> list[Polynomial]:
        ring, (x, y, z) = self.ring, self.tip
        place = self.links
        tip = [self._length(place, "a", x), ring.constant(y), self._length(place, "d", z), ring.one]
        return [ring.reduce(_inner(ring, last[i], tip)) for i in range(3)]

    @cached_property
    def _screws(self) -> dict[int, list[list[Polynomial]]]:
        return {}

    def screws_near(self, k: int, joints: Sequence[int]) -> list[list[Polynomial]]:
        """Screws (v; ω) of some joints in the frame of link k: of joints near it they are short in any arm."""
        screws = {
            j: joint_screw(self.ring, pose, self.sections[j - 1].kind)  # at once: long ones end it before longer poses
            for j, pose in self._poses(k, min(*joints, k), max(*joints, k))
            if j in joints
        }
        return [screws[j] for j in joints]

    def _poses(self, k: int, first: int = 1, last: int | None = None) -> Iterator[tuple[int, Matrix]]:
        """Per joint of a stretch that holds link k (all joints) a frame with z along its axis, seen from link k."""
        ring = self.ring
        pose = identity(ring)
        for j in range(k + 1, (last or self.links) + 1):
            pose = times(ring, pose, self._link(j - 1))
            yield j, pose
            pose = times(ring, pose, self._joint(j))
        pose = identity(ring)
        for j in range(k, first - 1, -1):
            yield j, pose
            pose = times(ring, pose, inverse(ring, self._joint(j)))
            if j > 1:
                pose = times(ring, pose, inverse(ring, self._link(j - 1)))

    def _joint(self, j: int) -> Matrix:
        """Rz(θ_j) Tz(d_j)."""
        ring, section = self.ring, self.sections[j - 1]
        d = self.length(j - 1, "d")
        c, s = ring.constant(section.phase.cos), ring.constant(section.phase.sin)
        if section.kind is JointKind.PRISMATIC:
            d = d + ring.constant(section.multiplier) * ring.q[section.variable]
        else:
            cosine, sine = multiple(ring, section.variable, int(section.multiplier))
            c, s = ring.reduce(c * cosine - s * sine), ring.reduce(s * cosine + c * sine)
        zero, one = ring.zero, ring.one
        return [[c, -s, zero, zero], [s, c, zero, zero], [zero, zero, one, d], [zero, zero, zero, one]]

    def _link(self, j: int) -> Matrix:
        """Tx(a_j) Rx(α_j)."""
        ring, section = self.ring, self.sections[j - 1]
        c, s = ring.constant(section.twist.cos), ring.constant(section.twist.sin)
        zero, one = ring.zero, ring.one
        a = self.length(j - 1, "a")
        return [[one, zero, zero, a], [zero, c, -s, zero], [zero, s, c, zero], [zero, zero, zero, one]]

    def screws_at_tip(self, k: int) -> list[list[Polynomial]]:
        """The n columns in the axes of link k, the linear part taken at the tip."""
        point = self._tip_in(self.link_pose(k, self.links))
        return [shift_screw(self.ring, screw, point) for screw in self.screws(k)]

    def _in_task_axes(self) -> list[list[Polynomial]]:
        """Screws at the tip along the axes of the task's frame."""
        ring, rows = self.ring, set(self.task.rows)
        k, turned = self.links if self.in_body else 1, self.task_axes
        about_z = all(turned[2][i] in ((1, -1) if i == 2 else (0,)) for i in range(3))
        paired = all((r in rows) == (r + 1 in rows) for r in (0, 3))
        screws = self.screws_at_tip(k)
        if about_z and paired:
            return screws
        rotation = each_entry(ring.constant, turned)
        if not self.in_body:  # link 1 turned by joint 1, seen from the base
            joint = self._joint(1)
            rotation = [
                [sum((rotation[i][h] * joint[h][m] for h in range(3)), ring.zero) for m in range(3)] for i in range(3)
            ]
        return [
            [
                ring.reduce(sum((rotation[i][g] * screw[3 * h + g] for g in range(3)), ring.zero))
                for h in range(2)
                for i in range(3)
            ]
            for screw in screws
        ]

    @property
    def in_body(self) -> bool:
        """Whether the task's axes are those of the tip."""
        return self.task.frame == BODY

    @property
    def task_axes(self) -> list[list[Number]]:
        """The axes of the task in the frame of link n, or in the one before joint 1: see `in_body`."""
        if self.in_body:
            return self._end
        return self._start

    @cached_property
    def _start(self) -> list[list[Number]]:
        """Rotation from the frame before joint 1 (z its axis, x the first normal) to the base."""
        return _exact(first_and_last(self.own)[0][:3, :3])

    @cached_property
    def _end(self) -> list[list[Number]]:
        """Rotation from the frame of link n to the tip's axes."""
        return _exact(_home_in_last(self.own)[:3, :3].T)

    def with_letters(self, changed: Mapping[str, tuple[int, str]]) -> Chain:
        """The chain of a special arm: some letters replaced, each by (sign, another letter)."""
        written = {}
        for place, (sign, letter) in self.written.items():
            factor, other = changed.get(letter, (1, letter))
            written[place] = (sign * factor, other)
        letters = {name: value for name, value in self.letters.items() if name not in changed}
        return replace(self, letters=letters, written=written)


def exact_chain(
    robot: Robot,
    task: str | Task | None = None,
    *,
    lengths: str | Mapping[str, float] = "auto",
    parts: bool = False,
) -> Chain:
    """Make a robot exact: twists as quarter turns or rationals, lengths as letters or decimals.

    Equal lengths get the same letter, opposite ones that letter with a minus: an arm whose forearm is as long as its
    upper arm is another arm, and its conditions are its own. Letters are those of the robot (`Robot.lengths`) for the
    lengths of ± their value, and Denavit and Hartenberg's with the number of the link (a2, d4) for the others, unless
    the caller names them. For tasks that depend on the tip its x and z in the frame of the last link n count as
    lengths too: a{n} and d{n}.

    Args:
        robot: revolute and prismatic joints. A joint that follows another one is of the same kind; one that turns has a
            whole multiplier, or, with `parts`, a fraction of small numbers.
        task: as in `resolve_task`; None is the one that the arm is made for.
        lengths: "letters", "numbers", "auto" (letters where the twists are quarter turns, `ODD` others aside, there
            are at most `MANY` different lengths, and at most `WIDE` joints for all six rows), or a mapping from letters
            to values [m]: lengths of that value get the letter.
        parts: whether the caller knows that conditions may speak of parts of joint angles (`parts_of`).

    Raises:
        RobotError: a helical joint, or one that follows another in a way that is not algebraic.
        TaskError: no such task.
        OptionError: a letter that means something else in conditions, or that no length has.
    """
    resolved = resolve_task(task, robot)
    if not parts and max(parts_of(robot)) > 1:
        raise RobotError(
            "a joint follows another one by a fraction of its angle", where=f"robot {robot.name!r}",
            allowed="whole multipliers", mend="`conditions` and `analyze` take fractions",
        )  # fmt: skip
    if resolved.m < 6 and resolved.frame not in (WORLD_ALIGNED, BODY):
        raise TaskError(
            "exact conditions of a task with some rows only are derived in the base's or the tip's axes, at the tip",
            got=resolved.frame,
            allowed="WORLD_ALIGNED, BODY",
        )
    power = exponent(robot)
    unit = Fraction(10) ** power
    chain_sections, roundings = sections(in_units(robot), float(unit))
    chain_sections = tuple(replace(section, d=section.d * unit, a=section.a * unit) for section in chain_sections)
    if resolved.m < 6 and min(resolved.rows) < 3:
        tip = _tip(robot)
    else:
        tip = None
    if tip is not None:
        roundings += tip_roundings(_home_in_last(in_units(robot))[:3, 3], len(chain_sections) + 1, float(unit))
    if lengths == "auto" and resolved.m == 6 and len(chain_sections) > WIDE:
        lengths = "numbers"
    letters, written = named_lengths(robot, chain_sections, lengths, tip)
    unused: tuple[tuple[str, float], ...] = ()
    if letters and isinstance(lengths, str):
        unused = tuple((name, value) for name, value in robot.lengths if name not in letters)
    return Chain(robot, resolved, chain_sections, letters, written, roundings, unused)


def _home_in_last(robot: Robot) -> Array:
    """(4, 4) pose of the tip in the frame of link n."""
    return np.asarray(np.linalg.inv(first_and_last(robot)[1]) @ robot.home)


def _tip(robot: Robot) -> list[Fraction]:
    unit = Fraction(10) ** exponent(robot)
    return [length * unit for length in decimals(_home_in_last(in_units(robot))[:3, 3])]


def _exact(rotation: Array) -> list[list[Number]]:
    """The entries as cosines of multiples of 15° and 18° where they are that, else to `DIGITS` decimals."""
    return each_entry(exact_cosine, np.asarray(rotation, dtype=float).tolist())
