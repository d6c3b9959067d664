"""A singular configuration proven to exist: Krawczyk's test on J^T u = 0.

Unknowns are the joints x that decide and a unit vector u; the equations J(x)^T u = 0 and |u|² = 1 are fewer, and as
many planes through the point found are added as the set of solutions has dimensions. With Y nearly an inverse of F′ at
x0, and X a box around it, K = x0 − Y F(x0) + (1 − Y F′(X)) (X − x0) in the inside of X proves that X holds a solution,
whose rank is below the number of rows. Where the set has more dimensions than its equations let it have (the
crossing of two families, many arms with spherical wrist and shoulder) F′ has no such inverse: nothing is proven.
"""

from __future__ import annotations

import numpy as np

from rankdrop.certify.proof.intervals import Arm, Interval, Matrix, flint
from rankdrop.certify.proof.reading import Told, Unproven, number, vector

_ROUNDS = 8  # of Newton's iteration
_LEAST = 1e-7  # share of the largest singular value of F' that the smallest must have
_WIDTHS = (1e-16, 1e-13, 1e-10)  # half-widths of X that are tried


def verify_existence(arm: Arm, told: Told) -> str:
    """A configuration whose rank is below that of the certificate within the radius of its q.

    Raises:
        ValueError: the claim is malformed.
        Unproven: it could not be shown.
    """
    q, radius = vector(told.claim["q"], told.variables, "q"), number(told.claim["radius"], 0.0, 1.0, "radius")
    rows = told.whole_rows
    if len(rows) != told.rank:  # a planar task: its own rows, in base axes, where the others are zero
        rows = list(told.rows)
        if len(rows) != told.rank or told.frame[0] != 0:
            raise Unproven(f"existence is shown where all {len(rows)} rows are independent almost everywhere, not for "
                           f"rank {told.rank}")  # fmt: skip
    far, width = _Zero(arm, q, rows).proven()
    if not far + width <= radius:
        raise Unproven(f"the singular configuration that exists is up to {far + width:.3g} away, not {radius:.3g}")
    return f"a configuration of rank below {told.rank} exists within {radius:.3g} of q, joint by joint [rad, m]"


class _Zero:
    """The system of one configuration."""

    def __init__(self, arm: Arm, q: list[float], rows: list[int]) -> None:
        self._arm, self._rows, self._f = arm, rows, flint()
        self._given = q
        self._free = arm.moving
        self._d = len(self._free)

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
            if self._inside(x, start, planes, width):
                return max(float(abs(x[k] - start[k]).upper()) for k in range(self._d)), width
        raise Unproven("no box around the point is proven to hold a singular configuration: the singular set may have "
                       "more dimensions there than its equations let it have")  # fmt: skip

    def _start(self) -> list[Interval]:
        f, zero = self._f, [self._f.arb(0)] * self._arm.variables
        columns = self._arm.seen([f.arb(x) for x in self._given], zero).columns
        u = np.linalg.svd(self._arm.jacobian(columns)[self._rows])[0][:, -1]
        return [f.arb(self._given[j]) for j in self._free] + [f.arb(float(x)) for x in u]

    def _configuration(self, x: list[Interval]) -> tuple[list[Interval], list[Interval]]:
        f = self._f
        q, half = [f.arb(one) for one in self._given], [f.arb(0)] * self._arm.variables
        for place, j in enumerate(self._free):
            q[j], half[j] = x[place].mid(), x[place].rad()
        return q, half

    def _equations(self, x: list[Interval]) -> tuple[Matrix, Matrix]:
        """(n + 1, 1) F and (n + 1, d + m) F′ over a box."""
        f, arm = self._f, self._arm
        columns = arm.seen(*self._configuration(x)).columns
        u = x[self._d :]
        six = [f.arb(0)] * 6
        for row, value in zip(self._rows, u, strict=True):
            six[row] = value
        left = f.arb_mat(1, 6, six)
        value = [f.arb(0)] * (arm.variables + 1)
        slope = [[f.arb(0)] * len(x) for _ in range(arm.variables + 1)]
        for one, column in zip(arm.links, columns, strict=True):
            value[one.driver] += one.multiplier * (left * column)[0, 0]
            entries = column.entries()
            for place, row in enumerate(self._rows):
                slope[one.driver][self._d + place] += one.multiplier * entries[row]
        for i, by, moved in arm.brackets(columns):
            place = self._free.index(by)
            slope[arm.links[i].driver][place] += arm.links[i].multiplier * (left * moved)[0, 0]
        value[-1] = sum((one * one for one in u), f.arb(-1)) / 2
        for place, one in enumerate(u):
            slope[-1][self._d + place] = one
        return f.arb_mat([[one] for one in value]), f.arb_mat(slope)

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

    def _inside(self, x: list[Interval], start: list[Interval], planes: Matrix, width: float) -> bool:
        """Krawczyk's operator maps the box of this half-width around x into its inside."""
        f = self._f
        box = [one + f.arb(0, width) for one in x]
        value, _ = self._equations(x)
        _, slope = self._equations(box)
        system, right = self._square(value, slope, planes, x, start)
        try:
            inverse = system.mid().inv().mid()
        except ZeroDivisionError:
            return False
        size = len(x)
        unit = f.arb_mat(size, size, [int(r == c) for r in range(size) for c in range(size)])
        off = f.arb_mat(size, 1, [f.arb(0, width)] * size)
        moved = (unit - inverse * system) * off - inverse * right
        return all(abs(one) < width for one in moved.entries())
