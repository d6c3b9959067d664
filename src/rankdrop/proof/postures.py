"""A change of posture proven: two solutions of one pose, and a path between them that meets no singularity.

The path is straight between its rows, the first being the first solution q0 exactly. The last row is a solution to
rounding; that an exact one q* lies next to it is proven by Krawczyk's test on

    F(q) = (R(q) x + p(q) − R(q0) x − p(q0),   ½ vee(M − M^T)) = 0,   M = R(q) R(q0)^T

with x the point of the task at q = 0, and the derivatives v + ω × (R x + p) and ½ (tr M − M) ω. A rotation M that is
symmetric is the identity or half a turn; of half a turn tr M − M is singular, and the test, which proves F′ regular,
fails. The box of the claimed radius around the last row holds q*, and
the rank is kept in all of it: q0, the path and q* lie in one aspect. A joint in which q0 and q* differ, whole turns
left out, makes them two postures.
"""

from __future__ import annotations

import numpy as np

from rankdrop.proof.arm import Arm, Interval, Matrix, Region, flint
from rankdrop.proof.record import TURN, Array, Claim, Unproven
from rankdrop.proof.regions import ClaimCheck, CurvePath
from rankdrop.proof.tip import tip_motion, unit, velocity

_ROUNDS = 8  # of Newton's iteration
_WIDTHS = (1e-16, 1e-13, 1e-10)  # half-widths of the box around the solution that are tried
_UP = 1.005  # three digits are printed, none too small


def verify_change(check: ClaimCheck) -> str:
    """Both ends of a path are solutions of one pose, no singularity is between them, and they are two postures.

    Returns:
        How far the poses of its first and of its last row are from each other at most, in words.

    Raises:
        Unproven: it is not confirmed.
    """
    claim = check.claim
    _check_task(claim)
    path = CurvePath(check)
    points, radius = claim.entries["points"], claim.entries["radius"]
    if claim.entries["limits"]:
        _check_limits(claim, points, radius)
    if not _differ(claim, points[0], points[-1], radius):
        raise Unproven("both ends of the path are one posture: no joint differs by more than the radius, whole turns "
                       "left out")  # fmt: skip
    pose = _Pose(claim, points[0])
    far = pose.solution(points[-1])
    if not far <= radius:
        raise Unproven(f"the solution next to the last row is up to {far:.3g} away, not {radius:.3g}")
    f = flint()
    centre, half = [f.arb(float(x)) for x in points[-1]], [f.arb(radius)] * claim.variables
    if not check.keeps_rank(Region(centre, half)):
        raise Unproven(f"the box of radius {radius:.3g} around the last row is not proven to be free of singularities")
    path.prove((0, 0.0), (path.count - 1, 1.0))
    return pose.distance_from(points[-1])


def _check_task(claim: Claim) -> None:
    """Postures are solutions of a pose, of the arm itself.

    Raises:
        Unproven: they are not.
    """
    if claim.tolerance is not None:
        raise Unproven("two solutions of one pose are shown for the numbers of the arm, not for arms near it")
    if claim.blocks != list(claim.rows):
        raise Unproven("a change of posture is proven for tasks that take all rows of a translation or a rotation")
    if not len(claim.rows) == claim.rank == claim.variables:
        raise Unproven(f"postures are solutions of a pose, a list only with as many joints as rows: {claim.variables} "
                       f"joints, {len(claim.rows)} rows, rank {claim.rank}")  # fmt: skip


def _check_limits(claim: Claim, points: Array, radius: float) -> None:
    """All rows, and the box around the last one, are inside the joint limits.

    Raises:
        Unproven: they are not, or the certificate states no limits.
    """
    if claim.limits is None:
        raise Unproven("the path is said to be inside the joint limits, and the certificate states none")
    lower, upper = np.array(claim.limits).T
    rows = np.concatenate([points, points[-1:] - 2 * radius, points[-1:] + 2 * radius])  # twice: sums are rounded
    outside = ~((lower <= rows) & (rows <= upper))
    if outside.any():
        raise Unproven(f"joint {int(np.argwhere(outside)[0, 1]) + 1} of the path is not inside its limits")


def _differ(claim: Claim, start: Array, end: Array, radius: float) -> bool:
    """Does some variable differ by more than the radius, of turning joints whole turns left out?"""
    f = flint()
    leaders = [joint["kind"] for joint in claim.record["arm"]["joints"] if joint["follows"] is None]
    for kind, a, b in zip(leaders, start.tolist(), end.tolist(), strict=True):
        gap = f.arb(b) - f.arb(a)
        if kind == TURN:
            gap -= 2 * f.arb.pi() * round((b - a) / (2 * np.pi))
        if abs(gap) > radius:
            return True
    return False


class _Pose:
    """The equations that the pose of a configuration q is that of another, q0.

    Args:
        claim: of a task that takes whole blocks of rows.
        start: (n,) q0.
    """

    def __init__(self, claim: Claim, start: Array) -> None:
        self._f, self._links, self._n = flint(), claim.links, claim.variables
        _, origin, local = claim.frame
        self._moves, self._turns = 0 in claim.rows, 3 in claim.rows
        if self._turns:
            home, local = claim.home, (0.0, 0.0, 0.0)  # of the whole pose any point will do
        else:
            home = claim.poses[origin]
        shift = self._f.arb_mat(home[:3, :3].tolist()) * self._f.arb_mat([[x] for x in local])
        self._point = self._f.arb_mat(home[:3, 3:].tolist()) + shift
        zero = self._f.arb(0)
        self._arm = Arm(claim.links, claim.variables, 0, [zero] * 3, self._f.arb(1))  # twists in base coordinates
        turn, place = tip_motion(claim.links, [self._f.arb(float(x)) for x in start])
        self._turn, self._place = turn, turn * self._point + place

    def _placed_tip(self, q: list[Interval]) -> tuple[Matrix, Matrix]:
        """(3, 3) M, and (3, 1) the point."""
        turn, place = tip_motion(self._links, q)
        return turn * self._turn.transpose(), turn * self._point + place

    def _equations(self, q: list[Interval]) -> tuple[Matrix, Matrix]:
        """(n, 1) F and (n, n) F′ over a box."""
        f = self._f
        turned, place = self._placed_tip(q)
        twists = [column.entries() for column in self._arm.screws_over([x.mid() for x in q], [x.rad() for x in q])[0]]
        values: list[Interval] = []
        moved: list[list[Interval]] = [[] for _ in twists]
        if self._moves:
            values += (place - self._place).entries()
            for column, twist in zip(moved, twists, strict=True):
                column += velocity(twist, place.entries())
        if self._turns:
            m = turned.tolist()
            values += [(m[2][1] - m[1][2]) / 2, (m[0][2] - m[2][0]) / 2, (m[1][0] - m[0][1]) / 2]
            half = (unit(3) * (m[0][0] + m[1][1] + m[2][2]) - turned) / 2
            for column, twist in zip(moved, twists, strict=True):
                column += (half * f.arb_mat(3, 1, twist[3:])).entries()
        return f.arb_mat(len(values), 1, values), self._by_variable(moved)

    def _by_variable(self, moved: list[list[Interval]]) -> Matrix:
        """(n, n) columns of the joints of one variable together."""
        f = self._f
        slope = [[f.arb(0)] * self._n for _ in moved[0]]
        for link, column in zip(self._links, moved, strict=True):
            for row, value in zip(slope, column, strict=True):
                row[link.driver] += link.multiplier * value
        return f.arb_mat(slope)

    def solution(self, end: Array) -> float:
        """How far from a configuration an exact solution is, at most, in the largest of the joints.

        Raises:
            Unproven: none is proven to be there.
        """
        f = self._f
        start = x = [f.arb(float(value)) for value in end]
        for _ in range(_ROUNDS):
            value, slope = self._equations(x)
            try:
                step = slope.mid().solve(value.mid())
            except ZeroDivisionError as error:
                raise Unproven("the last row of the path is singular") from error
            x = [(a - b).mid() for a, b in zip(x, step.entries(), strict=True)]
        for width in _WIDTHS:
            if self._krawczyk_inside(x, width):
                return max(float(abs(a - b).upper()) for a, b in zip(x, start, strict=True)) + width
        raise Unproven("the last row of the path is not proven to be next to a solution of the pose of its first row")

    def _krawczyk_inside(self, x: list[Interval], width: float) -> bool:
        """Krawczyk's operator maps the box of this half-width around x into its inside."""
        f, n = self._f, self._n
        value, _ = self._equations(x)
        _, slope = self._equations([x_i + f.arb(0, width) for x_i in x])
        try:
            inverse = slope.mid().inv().mid()
        except ZeroDivisionError:
            return False
        moved = (unit(n) - inverse * slope) * f.arb_mat(n, 1, [f.arb(0, width)] * n) - inverse * value
        return all(abs(x_i) < width for x_i in moved.entries())

    def distance_from(self, end: Array) -> str:
        """How far the pose of a configuration is from that of q0 at most: "1e-15 m and 2e-15 rad"."""
        f = self._f
        turned, place = self._placed_tip([f.arb(float(x)) for x in end])
        parts = []
        if self._moves:
            parts.append(f"{_length((place - self._place).entries()) * _UP:.3g} m")
        if self._turns:  # |M − 1| of Frobenius is 2 √2 sin(angle/2)
            sine = min(1.0, _length((turned - unit(3)).entries()) / 8**0.5)
            parts.append(f"{2 * float(np.arcsin(sine)) * _UP:.3g} rad")
        return " and ".join(parts)


def _length(values: list[Interval]) -> float:
    return float(np.linalg.norm([float(x.abs_upper()) for x in values]))
