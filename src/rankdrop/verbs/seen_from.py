"""One verb: the Jacobian seen from a link, in closed form and at a configuration, with its closed inverse (ML, KG)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import atan2

import numpy as np
from numpy.typing import ArrayLike

from rankdrop._handles import check_robot
from rankdrop.errors import OptionError
from rankdrop.exact.algebra.polynomial import Polynomial
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.arm.geometry import first_and_last
from rankdrop.exact.arm.link_jacobian import check_frame, frame_jacobian, sizes
from rankdrop.exact.determinants import ClosedInverse, closed_inverse
from rankdrop.exact.writing.notation import Latex, latex_name
from rankdrop.exact.writing.value import FOLDED, Quotient, form_of, number_at, single_angles, text_of
from rankdrop.kinematics import jacobian, pose
from rankdrop.local.block import sample
from rankdrop.local.verdict import one_configuration
from rankdrop.results.codec import Record, plain, robot_to_dict
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.sections import Section, text
from rankdrop.task import ROWS, Task
from rankdrop.tolerances import DEFAULT
from rankdrop.units import out_of_units

SCHEMA = "rankdrop/jacobian/1"
TRIED = 5
"""Random configurations at which the closed forms are held against the numeric Jacobian."""
AGREE = 1e-9
"""They agree to this part of the largest entry."""
_WIDTH = 76  # characters up to which a matrix stands as a table


@dataclass(frozen=True, eq=False)
class Numbers:
    """The Jacobian at one configuration.

    Attributes:
        q: (n,) [rad, m].
        matrix: (m, n) rows of the task.
        determinant: None where the matrix is not square.
        inverse: (n, m); None where the matrix is not square, or singular here.
        sigma: its singular values with lengths in metres, largest first.
    """

    q: tuple[float, ...]
    matrix: Array
    determinant: float | None
    inverse: Array | None
    sigma: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Agreement:
    """One check.

    Attributes:
        what: in words.
        holds: whether it does.
        worst: the largest difference found, relative; None for a check that is exact.
    """

    what: str
    holds: bool
    worst: float | None


@dataclass(frozen=True, eq=False, repr=False)
class LinkJacobian:
    """The Jacobian in the axes of a link.

    Attributes:
        robot, task: the arm, and the rows.
        frame: link k whose axes are taken: z along axis k, x along the common normal after it.
        at: link on whose frame's origin the reference point is; None for the tip.
        letters, shifts: values of the lengths that are letters [m]; θ = q + shift.
        rows: the entries as trigonometric polynomials, one list of n per row of the task; empty where only numbers
            were asked for.
        shortest: (terms, link, reference point) of all axes and reference points, the shortest first; as `rows`.
        closed: the inverse in closed form, where it was asked for.
        numbers: at a configuration, where one was given.
        checks: what was checked, and how.
        chain: the arm over the exact ring.
    """

    robot: Robot
    task: Task
    frame: int
    at: int | None
    letters: Mapping[str, float]
    shifts: tuple[float, ...]
    rows: tuple[tuple[Polynomial, ...], ...]
    shortest: tuple[tuple[int, int, int | None], ...]
    closed: ClosedInverse | None
    numbers: Numbers | None
    checks: tuple[Agreement, ...]
    chain: Chain

    @property
    def holds(self) -> bool:
        """Whether every check does."""
        return all(check.holds for check in self.checks)

    def __repr__(self) -> str:
        return f"<LinkJacobian of {self.robot.name}: frame {self.frame}, about {_point(self.at)}>"

    def __str__(self) -> str:
        return text(self.sections())

    def texts(self) -> tuple[tuple[str, ...], ...]:
        """The entries as text, row by row: s2 is sin θ2, c23 is cos(θ2 + θ3)."""
        return tuple(tuple(text_of(self.chain.ring, x) for x in row) for row in self.rows)

    def inverse_texts(self, most: int | None = None) -> tuple[tuple[str, ...], ...]:
        """The entries of the inverse as text, one row per joint.

        Args:
            most: sums of more characters are told by their size; None for none.
        """
        return () if self.closed is None else tuple(tuple(x.text(most) for x in row) for row in self.closed.entries)

    def latex(self) -> str:
        """The matrix, its determinant and its inverse in LaTeX, as displayed formulas."""
        name, notation, ring = f"{{}}^{{{self.frame}}}J", Latex(), self.chain.ring
        entries = [[notation.value(form_of(ring, x)) if x != 0 else "0" for x in row] for row in self.rows]
        found = [f"{name} = {_matrix(entries)}"]
        if self.closed is not None:
            found.append(rf"\det {name} = {self.closed.determinant.latex()}")
            found.append(f"{name}^{{-1}} = {_matrix([[x.latex() for x in row] for row in self.closed.entries])}")
        lengths = [rf"{latex_name(one)} = {value:.12g}\,\mathrm{{m}}" for one, value in self.letters.items()]
        said = [rf"${', '.join(lengths)}$"] if lengths else []
        return "\n".join(["% needs \\usepackage{amsmath}", *(f"\\[ {one} \\]" for one in found), *said, ""])

    def to_dict(self) -> Record:
        """Plain data: see docs/json.md and schema/jacobian.schema.json."""
        closed = self.closed
        return {
            "schema": SCHEMA,
            "robot": robot_to_dict(self.robot, self.task, min(self.task.m, self.robot.n)),
            "frame": self.frame,
            "at": self.at,
            "rows": [ROWS[r] for r in self.task.rows],
            "letters": dict(self.letters),
            "shifts": list(self.shifts),
            "matrix": [list(row) for row in self.texts()],
            "latex": self.latex() if self.rows else "",
            "shortest": [{"terms": terms, "frame": k, "at": at} for terms, k, at in self.shortest],
            "inverse": None if closed is None else {
                "determinant": closed.determinant.text(),
                "entries": [
                    [{"text": x.text(), "latex": x.latex(), "python": x.expression(shifts=self.shifts)} for x in row]
                    for row in closed.entries
                ],
            },
            "numbers": plain(self.numbers),
            "checks": plain(self.checks),
            "holds": self.holds,
        }  # fmt: skip

    def sections(self, *, most: int | None = FOLDED) -> tuple[Section, ...]:
        """In words.

        Args:
            most: sums of the inverse of more characters are told by their size; None for none.
        """
        return tuple(self._sections(most))

    def _sections(self, most: int | None) -> Iterator[Section]:
        rows = [ROWS[r] for r in self.task.rows]
        joints = [f"joint {j}" for j in range(1, self.robot.n + 1)]
        k = self.frame
        axes = f"axes of link {k} (z along axis {k}, x along the common normal after it)"
        where = f"{axes}, reference point {_point(self.at)}"
        letters = ", ".join(f"{name} = {value:.12g} m" for name, value in self.letters.items())
        yield Section(f"{self.robot.name}: Jacobian in the frame of link {k}", "",
                      (where, *([f"lengths: {letters}"] if letters and self.rows else [])))  # fmt: skip
        if self.rows:
            yield _table(f"J seen from link {k}", rows, joints, self.texts())
            yield Section("Shortest", "", tuple(self._frames()))
        if self.closed is not None:
            yield Section("Determinant", "", (f"det J = {self.closed.determinant.text(most)}",))
            yield _table("Inverse", joints, rows, self.inverse_texts(most))
        if self.numbers is not None:
            yield from _numbers(self.numbers, rows, joints)
        if self.checks:
            yield Section("Checks", "", tuple(_told(check) for check in self.checks))

    def _frames(self) -> Iterator[str]:
        """Which axes make it shortest about this point, and about all points."""
        here = [(terms, k) for terms, k, at in self.shortest if at == self.at]
        told = ", ".join(f"link {k}: {terms}" for terms, k in sorted(here))
        yield f"terms, multiplied out, about {_point(self.at)}: {told}"
        terms, k, at = self.shortest[0]
        if at != self.at or terms < here[0][0]:
            yield f"of all reference points: link {k} about {_point(at)}, {terms} terms"


def link_jacobian(
    robot: Robot,
    frame: int | None = None,
    task: str | Task | None = None,
    *,
    at: int | None = None,
    q: ArrayLike | None = None,
    symbolic: bool = True,
    inverse: bool = False,
    lengths: str | Mapping[str, float] = "auto",
    seconds: float = 60.0,
) -> LinkJacobian:
    """The Jacobian seen from a link, in closed form, at a configuration, or both.

    Args:
        robot: revolute and prismatic joints, each a variable of its own.
        frame: link 1 … n whose axes are taken; None for the one in which it is shortest (numbers alone: link 1).
        task: as in `resolve_task`.
        at: reference point: the origin of this link's frame; None for the tip.
        q: a configuration [rad, m] for numbers.
        symbolic: closed forms; needs python-flint.
        inverse: the inverse, too: closed where closed forms are asked for, and of the numbers.
        lengths: as in `exact_chain`.
        seconds: limit for the closed inverse: three times as long by the clock.

    Raises:
        RobotError: a helical joint, or one that follows another.
        TaskError: rows that would be others in the axes of a link.
        OptionError: no such link; neither closed forms nor a configuration; an inverse of a matrix that is not square;
            the limit was met.
        MissingExtraError: closed forms without python-flint.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = link_jacobian(open_robot("planar2r"), 1, inverse=True)
        >>> found.texts()
        (('−a2 s2', '−a2 s2'), ('a1 + a2 c2', 'a2 c2'))
        >>> found.inverse_texts()
        (('c2 / (a1 s2)', '1 / a1'), ('−(a1 + a2 c2) / (a1 a2 s2)', '−1 / a1'))
    """
    check_robot(robot)
    if not symbolic and q is None:
        raise OptionError("nothing is asked for", mend="closed forms: symbolic=True, or a configuration: q=…")
    chain = exact_chain(robot, task, lengths=lengths)
    check_frame(chain, 1 if frame is None else frame, at)
    if inverse and chain.n != chain.task.m:
        raise OptionError(
            "only a square Jacobian has an inverse", where=f"robot {robot.name!r}",
            got=f"{chain.task.m} rows, {chain.n} joints", mend="a task with as many rows as joints",
            typed="--task with as many rows as joints",
        )  # fmt: skip
    ordered = tuple(sizes(chain)) if symbolic else ()
    k = frame or (next(link for _, link, point in ordered if point == at) if symbolic else 1)
    rows: Sequence[Sequence[Polynomial]] = frame_jacobian(chain, k, at) if symbolic else ()
    closed = _inverse(chain, rows, seconds) if symbolic and inverse else None
    numbers = None if q is None else _at(chain, one_configuration(robot, q), k, at, inverse)
    return LinkJacobian(
        robot=robot,
        task=chain.task,
        frame=k,
        at=at,
        letters=chain.numbers,
        shifts=tuple(float(x) for x in chain.shifts),
        rows=tuple(tuple(row) for row in rows),
        shortest=ordered,
        closed=closed,
        numbers=numbers,
        checks=tuple(_checks(chain, k, at, rows, closed, numbers)),
        chain=chain,
    )


def numeric(chain: Chain, q: Array, k: int, at: int | None) -> Array:
    """(m, n) rows of the task at one configuration, lengths in metres: the core's Jacobian at the tip, turned into the
    axes of link k and moved to the origin of the frame of link `at`.
    """
    robot = chain.robot
    turn = _frame(chain, q, k)[:3, :3]
    found = jacobian(robot, q)
    linear, angular = found[:3], found[3:]
    if at is not None:
        way = _frame(chain, q, at)[:3, 3] - pose(robot, q)[:3, 3]
        linear = linear + np.cross(angular, way, axis=0)
    whole = np.concatenate([turn.T @ linear, turn.T @ angular])
    return np.asarray(whole[list(chain.task.rows)])


def _frame(chain: Chain, q: Array, k: int) -> Array:
    """(4, 4) pose in the base of the frame of link k: z along axis k, x along the normal after it."""
    found = first_and_last(chain.robot)[0]
    for j, section in enumerate(chain.sections[:k], 1):
        angle = atan2(float(section.phase.sin), float(section.phase.cos)) + section.shift
        slide = float(section.d)
        if section.kind is JointKind.REVOLUTE:
            angle += float(q[j - 1])
        else:
            slide += float(q[j - 1])
        found = found @ _screwed(angle, slide, 2)
        if j < k:
            twist = atan2(float(section.twist.sin), float(section.twist.cos))
            found = found @ _screwed(twist, float(section.a), 0)
    return np.asarray(found)


def _screwed(angle: float, slide: float, axis: int) -> Array:
    """(4, 4) a turn about and a slide along one axis."""
    found, (i, j) = np.eye(4), ((axis + 1) % 3, (axis + 2) % 3)
    found[i, i] = found[j, j] = np.cos(angle)
    found[j, i], found[i, j] = np.sin(angle), -np.sin(angle)
    found[axis, 3] = slide
    return found


def _inverse(chain: Chain, rows: Sequence[Sequence[Polynomial]], seconds: float) -> ClosedInverse:
    try:
        return closed_inverse(chain.ring, rows, Work(seconds))
    except OutOfTime as end:
        raise OptionError(
            "the closed inverse takes longer than it may", got=str(end),
            mend="allow more time, another frame, or numbers: q=… with symbolic=False",
            typed="allow more time (--time-limit), another frame, or numbers alone: --q",
        ) from end  # fmt: skip


def _at(chain: Chain, q: Array, k: int, at: int | None, inverse: bool) -> Numbers:
    matrix = numeric(chain, q, k, at)
    sigma = np.linalg.svd(matrix, compute_uv=False)
    square = matrix.shape[0] == matrix.shape[1]
    regular = square and _regular(matrix)
    return Numbers(
        tuple(float(x) for x in q), matrix, float(np.linalg.det(matrix)) if square else None,
        np.asarray(np.linalg.inv(matrix), dtype=np.float64) if inverse and regular else None,
        tuple(float(x) for x in sigma),
    )  # fmt: skip


def _regular(matrix: Array) -> bool:
    sigma = np.linalg.svd(matrix, compute_uv=False)
    return bool(sigma[-1] > DEFAULT.singular * sigma[0])


def _checks(
    chain: Chain,
    k: int,
    at: int | None,
    rows: Sequence[Sequence[Polynomial]],
    closed: ClosedInverse | None,
    numbers: Numbers | None,
) -> Iterator[Agreement]:
    if rows:
        places = list(out_of_units(chain.robot, sample(chain.own, chain.own_task, TRIED, 0)))
        forms = [[single_angles(chain.ring, x) for x in row] for row in rows]
        worst, gap = 0.0, 0.0
        for q in places:
            theta, wanted = q + chain.shifts, numeric(chain, q, k, at)
            found = np.array([[number_at(form, theta, chain.numbers) for form in row] for row in forms])
            worst = max(worst, float(np.abs(found - wanted).max() / np.abs(wanted).max()))
            if closed is not None:
                gap = max(gap, _gap(closed.entries, theta, chain.numbers, wanted))
        yield Agreement(
            f"the closed form is the numeric Jacobian, turned, at {TRIED} random configurations", worst <= AGREE, worst
        )
        if closed is not None:
            yield Agreement(
                f"J · adj J = det J · 1 at {closed.agree} of {closed.tested} random points modulo 2^61 − 11913",
                closed.agree == closed.tested, None,
            )  # fmt: skip
            yield Agreement(
                f"the closed inverse times the numeric Jacobian is the identity at {TRIED} random configurations",
                gap <= AGREE, gap,
            )  # fmt: skip
    if numbers is not None and numbers.inverse is not None:
        worst = float(np.abs(numbers.inverse @ numbers.matrix - np.eye(len(numbers.q))).max())
        yield Agreement(
            "the inverse times the Jacobian is the identity at the configuration given", worst <= AGREE, worst
        )


def _gap(entries: Sequence[Sequence[Quotient]], theta: Array, letters: Mapping[str, float], matrix: Array) -> float:
    """Largest entry of J⁻¹ J − 1, over the size of J⁻¹ times that of J."""
    found = np.array([[x.at(theta, letters) for x in row] for row in entries])
    size = np.linalg.norm(found) * np.linalg.norm(matrix)
    return float(np.abs(found @ matrix - np.eye(len(matrix))).max() / max(size, 1.0))


def _point(at: int | None) -> str:
    return "the tip" if at is None else f"the origin of link {at}"


def _told(check: Agreement) -> str:
    size = "" if check.worst is None else f" (largest difference {check.worst:.1e})".replace("-", "−")
    return f"{'' if check.holds else 'FAILS: '}{check.what}{size}"


def _table(title: str, left: Sequence[str], above: Sequence[str], entries: Sequence[Sequence[str]]) -> Section:
    """A matrix as a table where it is narrow, else entry by entry, zeros left out."""
    widths = [max(len(head), *(len(row[i]) for row in entries)) for i, head in enumerate(above)]
    if sum(widths) + 2 * len(widths) + max(map(len, left)) <= _WIDTH:
        rows = tuple((name, *row) for name, row in zip(left, entries, strict=True))
        return Section(title, "", (), ("", *above), rows, texts=tuple(range(len(above) + 1)))
    lines = tuple(
        f"{name}, {head}: {entry}"
        for name, row in zip(left, entries, strict=True)
        for head, entry in zip(above, row, strict=True)
        if entry != "0"
    )
    return Section(title, "", (*lines, "all other entries are 0"))


def _numbers(numbers: Numbers, rows: Sequence[str], joints: Sequence[str]) -> Iterator[Section]:
    def written(matrix: Array) -> list[list[str]]:
        return [[f"{x + 0.0:.6g}".replace("-", "−") for x in np.where(np.abs(row) < 1e-15, 0.0, row)] for row in matrix]

    def table(title: str, left: Sequence[str], above: Sequence[str], matrix: Array) -> Section:
        cells = tuple((name, *row) for name, row in zip(left, written(matrix), strict=True))
        return Section(title, "", (), ("", *above), cells)

    q = ", ".join(f"{x:.6g}" for x in numbers.q).replace("-", "−")
    yield table(f"At q = ({q}) [rad, m]", rows, joints, numbers.matrix)
    lines = [f"singular values, lengths in metres: {', '.join(f'{x:.4g}' for x in numbers.sigma)}"]
    if numbers.determinant is not None:
        lines.insert(0, f"determinant {numbers.determinant:.6g}".replace("-", "−"))
    if numbers.determinant is not None and not _regular(numbers.matrix):
        lines.append("no inverse: the configuration is singular")
    yield Section("", "", tuple(lines))
    if numbers.inverse is not None:
        yield table("Inverse at q", joints, rows, numbers.inverse)


def _matrix(entries: Sequence[Sequence[str]]) -> str:
    body = r" \\ ".join(" & ".join(row) for row in entries)
    return rf"\begin{{bmatrix}} {body} \end{{bmatrix}}"
