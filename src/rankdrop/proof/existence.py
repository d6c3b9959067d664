"""A singular configuration proven to exist: Krawczyk's test on J^T u = 0, or on J u = 0.

Unknowns are the joints x that decide and a unit vector u, a wrench, or of an arm of fewer joints than the task has rows
a joint motion. The equations J(x)^T u = 0, or J(x) u = 0, and |u|² = 1 are fewer, and as many planes through the point
found are added as the set of solutions has dimensions. With Y nearly an inverse of F′ at x0, and X a box around it,
K = x0 − Y F(x0) + (1 − Y F′(X)) (X − x0) in the inside of X proves that X holds a solution, whose rank is below the
number of rows, or of joints. A joint whose axis goes through the point of a translation has no equation.

Where the set has more dimensions than its equations let it have (the crossing of two families, many arms with spherical
wrist and shoulder) F′ has no such inverse: nothing is proven here, but perhaps in rational numbers
(`rankdrop.proof.minors`).
"""

from __future__ import annotations

import numpy as np

from rankdrop.proof.arm import Arm, Interval, Matrix, Region, flint
from rankdrop.proof.record import Claim, Link, Unproven

_ROUNDS = 8  # of Newton's iteration
_LEAST = 1e-7  # share of the largest singular value of F' that the smallest must have
_TRIED = 8  # configurations, of which one has to have the rank
_WIDTHS = (1e-16, 1e-13, 1e-10)  # half-widths of X that are tried


def verify_existence(arm: Arm, claim: Claim) -> None:
    """A configuration whose rank is below that of the certificate exists within the radius of its q.

    Raises:
        Unproven: it could not be shown.
    """
    q, radius = claim.entries["q"], claim.entries["radius"]
    rows = claim.whole_rows
    if len(rows) != claim.rank:
        if len(claim.rows) == claim.rank and claim.frame[0] == 0:
            rows = list(claim.rows)  # a planar task: its own rows, in base axes, where the others are zero
        elif claim.rank != claim.variables:
            raise Unproven(f"by intervals existence is shown where all {len(rows)} rows, or all {claim.variables} "
                           f"joints, are independent almost everywhere, not for rank {claim.rank}")  # fmt: skip
    _check_attained(arm, claim, rows)
    far, width = _Zero(arm, q, rows).proven()
    if not far + width <= radius:
        raise Unproven(f"the singular configuration that exists is up to {far + width:.3g} away, not {radius:.3g}")


def _check_attained(arm: Arm, claim: Claim, rows: list[int]) -> None:
    """Some configuration has the rank: of an arm that never has it a lower one would be no finding.

    Raises:
        Unproven: none of some taken at random.
    """
    f = flint()
    zero = [f.arb(0)] * claim.variables
    for q in np.random.default_rng(2).uniform(-1.0, 1.0, (_TRIED, claim.variables)):
        if arm.keeps_rank(Region([f.arb(float(x)) for x in q], zero), rows, claim.rank):
            return
    raise Unproven(f"the rank is below {claim.rank} at {_TRIED} configurations taken at random")


class _Zero:
    """The system of one configuration."""

    def __init__(self, arm: Arm, q: list[float], rows: list[int]) -> None:
        self._arm, self._rows, self._f = arm, rows, flint()
        self._given = q
        self._free = arm.moving
        self._d = len(self._free)
        self._motion = len(rows) > arm.variables  # u is a joint motion that moves nothing
        self._equation = {variable: place for place, variable in enumerate(self._moving())}  # of each variable
        self._equals = (len(rows) if self._motion else len(self._equation)) + 1

    def _moving(self) -> list[int]:
        """Variables of which some column is not zero wherever the arm stands: exact zeros next to the link alone."""
        zero, arm = [self._f.arb(0)] * self._arm.variables, self._arm
        columns = arm.screws_over(zero, zero)[0]
        ends = {arm.link, arm.link - 1}  # these do not depend on the configuration
        drivers = set()
        for i, link in enumerate(arm.links):
            entries = columns[i].entries()
            if i not in ends or not all(entries[row].is_zero() for row in self._rows):
                drivers.add(link.driver)
        return sorted(drivers)

    def proven(self) -> tuple[float, float]:
        """How far the zero is from q, and how well it is known: both in the largest of the joints.

        Raises:
            Unproven: no proof.
        """
        start = self._start()
        value, slope = self._equations(start)
        planes = self._planes(slope)
        x = start
        for _ in range(_ROUNDS):
            value, slope = self._equations(x)
            system, right = self._square(value, slope, planes, x, start)
            try:
                step = system.mid().solve(right.mid())
            except ZeroDivisionError as error:
                raise Unproven("the equations of a singular configuration are degenerate there") from error
            x = [(a - b).mid() for a, b in zip(x, step.entries(), strict=True)]
        for width in _WIDTHS:
            if self._krawczyk_inside(x, start, planes, width):
                return max(float(abs(x[k] - start[k]).upper()) for k in range(self._d)), width
        raise Unproven("no box around the point is proven to hold a singular configuration: the singular set may have "
                       "more dimensions there than its equations let it have")  # fmt: skip

    def _start(self) -> list[Interval]:
        f, zero = self._f, [self._f.arb(0)] * self._arm.variables
        columns = self._arm.screws_over([f.arb(x) for x in self._given], zero)[0]
        left, _, right = np.linalg.svd(self._arm.jacobian(columns)[self._rows])
        u = right[-1] if self._motion else left[:, -1]
        return [f.arb(self._given[j]) for j in self._free] + [f.arb(float(x)) for x in u]

    def _configuration(self, x: list[Interval]) -> tuple[list[Interval], list[Interval]]:
        f = self._f
        q, half = [f.arb(angle) for angle in self._given], [f.arb(0)] * self._arm.variables
        for place, j in enumerate(self._free):
            q[j], half[j] = x[place].mid(), x[place].rad()
        return q, half

    def _equations(self, x: list[Interval]) -> tuple[Matrix, Matrix]:
        """(n + 1, 1) F and (n + 1, d + m) F′ over a box; n and m exchanged where u is a joint motion."""
        f, arm = self._f, self._arm
        columns = arm.screws_over(*self._configuration(x))[0]
        u = x[self._d :]
        value = [f.arb(0)] * self._equals
        slope = [[f.arb(0)] * len(x) for _ in range(self._equals)]
        for link, column in zip(arm.links, columns, strict=True):
            entries = column.entries()
            for row, equation, unknown in self._places_of(link):
                value[equation] += link.multiplier * u[unknown] * entries[row]
                slope[equation][self._d + unknown] += link.multiplier * entries[row]
        for i, by, bracket in arm.brackets(columns):
            link, entries, variable = arm.links[i], bracket.entries(), self._free.index(by)
            for row, equation, unknown in self._places_of(link):
                slope[equation][variable] += link.multiplier * u[unknown] * entries[row]
        value[-1] = sum((u_i * u_i for u_i in u), f.arb(-1)) / 2
        for place, u_i in enumerate(u):
            slope[-1][self._d + place] = u_i
        return f.arb_mat([[entry] for entry in value]), f.arb_mat(slope)

    def _places_of(self, link: Link) -> list[tuple[int, int, int]]:
        """(row of the task, equation, entry of u) of each entry of the column of a link that plays a part."""
        if self._motion:
            return [(row, place, link.driver) for place, row in enumerate(self._rows)]
        if link.driver not in self._equation:
            return []
        equation = self._equation[link.driver]
        return [(row, equation, place) for place, row in enumerate(self._rows)]

    def _planes(self, slope: Matrix) -> Matrix:
        """Unit normals of the planes that are added, so that the system is square."""
        matrix = np.array([[float(x.mid()) for x in row] for row in slope.tolist()])
        sigma, vt = np.linalg.svd(matrix)[1:]
        if len(matrix) > matrix.shape[1] or not sigma[-1] > _LEAST * sigma[0]:
            raise Unproven("the singular set has more dimensions there than its equations let it have: no box can be "
                           "proven to hold a point of it")  # fmt: skip
        return self._f.arb_mat([[float(x) for x in row] for row in vt[len(matrix) :]] or [[0.0] * matrix.shape[1]])

    def _square(
        self, value: Matrix, slope: Matrix, planes: Matrix, x: list[Interval], start: list[Interval]
    ) -> tuple[Matrix, Matrix]:
        rows, right = slope.tolist(), value.tolist()
        if slope.nrows() < slope.ncols():
            away = self._f.arb_mat([[a - b] for a, b in zip(x, start, strict=True)])
            rows, right = rows + planes.tolist(), right + (planes * away).tolist()
        return self._f.arb_mat(rows), self._f.arb_mat(right)

    def _krawczyk_inside(self, x: list[Interval], start: list[Interval], planes: Matrix, width: float) -> bool:
        """Krawczyk's operator maps the box of this half-width around x into its inside."""
        f = self._f
        box = [x_i + f.arb(0, width) for x_i in x]
        value, _ = self._equations(x)
        _, slope = self._equations(box)
        system, right = self._square(value, slope, planes, x, start)
        try:
            inverse = system.mid().inv().mid()
        except ZeroDivisionError:
            return False
        size = len(x)
        unit = f.arb_mat(np.eye(size, dtype=np.int64).tolist())
        off = f.arb_mat(size, 1, [f.arb(0, width)] * size)
        moved = (unit - inverse * system) * off - inverse * right
        return all(abs(x_i) < width for x_i in moved.entries())
