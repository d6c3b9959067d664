"""The curve that a file of a path means, and the control points of a certificate compared with it.

A file of joint values has rows b_k, joined by polynomials in Bernstein form: straight, cubic (velocities v_k), or
quintic (accelerations a_k as well), with T the duration of a stretch:

    cubic    b_0,  b_0 + v_0 T/3,  b_1 − v_1 T/3,  b_1
    quintic  b_0,  b_0 + v_0 T/5,  b_0 + 2 v_0 T/5 + a_0 T²/20,  b_1 − 2 v_1 T/5 + a_1 T²/20,  b_1 − v_1 T/5,  b_1

A file of tool poses means straight lines of the tip, c(s) = c_k + s (c_{k+1} − c_k), and turns about one axis at a
constant rate, S(s) = exp(s φ) S_k. A joint path is compared with it by intervals. On a piece of it, of which the joints
go straight by Δ and s goes straight from s_0 to s_1, a function with |f″| ≤ M differs from the straight line between
its ends by at most M/8, so that

    |p − c| ≤ max(|e_0|, |e_1|) + M/8,   M = Σ_i l_i t_i² + Σ_s (|q_s| t_s² + 2 |Δ_s| t_s) + |x| θ²
    ‖R − S‖ ≤ max(‖E_0‖, ‖E_1‖) + (t_N² + θ²)/8,   angle = 2 arcsin(‖R − S‖/2)

with e and E the errors at both ends, l_i the length of link i, t_i the sum of |Δ_k| over the turning joints up to it
(t_s: before slide s), θ the turn of the tool, and x the reference point in the axes of the tip. Which place of the file
belongs to which row is a guess: a wrong one proves nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rankdrop.proof.arm import Interval, Matrix, dot, flint
from rankdrop.proof.record import SCREW, SLIDE, Array, Claim, Link, Unproven
from rankdrop.proof.tip import tip_motion, turn_about

DEGREES = {"linear": 1, "cubic": 3, "quintic": 5}
_OTHER = "another claim: the certificate is about"
_EQUAL = 1e-12  # share by which a control point may be off: one formula, rounded in another order
_ROUNDED = 1e-11  # of a place or a turn: doubles of the file, and of the axis of a turn [lengths of the arm, rad]
_HALF_TURN = 1e-4  # a turn so near to half a turn has two shortest ways [rad]
_HALVINGS = 16  # of a stretch whose tip is compared


@dataclass(frozen=True, eq=False)
class AskedPath:
    """What a file of a path says, as its reader read it.

    Attributes:
        file: its name.
        sha256: of its bytes, computed from the file itself.
        rows: (M, n) joint values [rad, m]; None of tool poses, or where the file was not read.
        times: (M,) [s]; velocities, accelerations: (M, n) [rad/s, rad/s², m …]; None where the file has none.
        interpolate: what joins the rows: "linear", "cubic" or "quintic"; None: what the certificate's degree says.
        poses: (P, 4, 4) of the tip in the base frame [m]; None of joint values.
        turned: the poses have orientations.
        tip, turn: how far the tip may be proven to be from its line [m] and its orientation [rad].
    """

    file: str
    sha256: str
    rows: Array | None = None
    times: Array | None = None
    velocities: Array | None = None
    accelerations: Array | None = None
    interpolate: str | None = None
    poses: Array | None = None
    turned: bool = True
    tip: float = 1e-4
    turn: float = 1e-4


def compare_rows(claim: Claim, path: AskedPath) -> None:
    """Compare every control point of a claim with the curve of a file of joint values.

    Raises:
        Unproven: they are those of another curve.
    """
    rows, degree, points = path.rows, claim.entries["degree"], claim.entries["points"]
    assert rows is not None
    if rows.ndim != 2 or rows.shape[1] != points.shape[1]:
        raise Unproven(f"{_OTHER} a path of {points.shape[1]} joints, not {rows.shape[-1]}")
    if path.interpolate is not None and DEGREES[path.interpolate] != degree:
        raise Unproven(f"{_OTHER} a curve of degree {degree}: {path.interpolate} interpolation has degree "
                       f"{DEGREES[path.interpolate]}")  # fmt: skip
    expected = control_points(path, degree)
    if expected is None:
        raise Unproven(f"{_OTHER} a curve of degree {degree}, which the rows of the file do not give: times, "
                       "velocities or accelerations are missing")  # fmt: skip
    if expected.shape != points.shape:
        raise Unproven(f"{_OTHER} a path through other rows than those of the file: {len(points)} control points, not "
                       f"{len(expected)}")  # fmt: skip
    off = ~(np.abs(expected - points) <= _EQUAL * (1.0 + np.abs(expected)))
    if off.any():
        place, joint = np.argwhere(off)[0].tolist()
        stated, wanted = float(points[place, joint]), float(expected[place, joint])
        raise Unproven(f"{_OTHER} a path through other rows than those of the file: control point {place + 1}, joint "
                       f"{joint + 1} is {stated!r}, not {wanted!r}")  # fmt: skip


def control_points(path: AskedPath, degree: int) -> Array | None:
    """((M − 1) d + 1, n) control points of the rows, the end of a stretch being the beginning of the next.

    None where the degree is none of these, or the file lacks what it needs. One row is a stretch of no length.
    """
    rows, times, rates, bends = path.rows, path.times, path.velocities, path.accelerations
    assert rows is not None
    if len(rows) == 1:
        if degree == 1:
            return np.repeat(rows, 2, axis=0)
        return None
    start, end = rows[:-1], rows[1:]
    if degree == 1:
        return rows
    if degree not in DEGREES.values() or times is None or rates is None:
        return None
    lasts = np.diff(times)[:, None]
    v0, v1 = rates[:-1] * lasts, rates[1:] * lasts
    if degree == 3:
        stretches = [start, start + v0 / 3, end - v1 / 3]
    else:
        if bends is None:
            return None
        a0, a1 = bends[:-1] * lasts * lasts, bends[1:] * lasts * lasts
        stretches = [start, start + v0 / 5, start + 2 * v0 / 5 + a0 / 20, end - 2 * v1 / 5 + a1 / 20, end - v1 / 5]
    return np.concatenate([np.stack(stretches, axis=1).reshape(-1, rows.shape[1]), rows[-1:]])


class ToolPath:
    """The tool path of a file of poses, compared with the tip of a joint path.

    Args:
        claim: a path.
        path: the file, with its poses.

    Raises:
        Unproven: the pose of the tip does not determine the task, the joint path is not straight between its rows, the
            file has no orientations, or a turn of it is half a turn.
    """

    def __init__(self, claim: Claim, path: AskedPath) -> None:
        assert path.poses is not None
        self._f, self._claim, self._path, self._poses = flint(), claim, path, path.poses
        self._rows: Array = claim.entries["points"]
        self._refuse_unsuited()
        axes, _, point = claim.frame
        whole = len(claim.rows) == 6
        moves, turns = _moves_and_turns(claim)
        self._point = np.array(point if moves and not whole else (0.0, 0.0, 0.0))
        if axes == 0 or not moves:
            self._moves = moves
        else:
            self._moves = [0, 1, 2]
        self._turns = bool(turns)
        self._entries = _entries_of_rotation(turns, by_rows=axes == 0 and not whole)
        self._axes = [_turn_between(a, b) for a, b in pairwise(self._poses)]
        if self._turns and any(np.linalg.norm(axis) > np.pi - _HALF_TURN for axis in self._axes):
            raise Unproven("two poses of the file are half a turn apart: which way the tool turns is a choice")
        self._points = _points_on_axes(claim.links)
        end = claim.home[:3, 3] + claim.home[:3, :3] @ self._point
        self._lengths = np.linalg.norm(np.diff(np.vstack([self._points, end]), axis=0), axis=1)
        self._slack = _ROUNDED * (1.0 + float(self._lengths.sum()))

    def _refuse_unsuited(self) -> None:
        """Refuse a claim or a file that cannot be compared with the other; see the class."""
        claim = self._claim
        axes, origin, _ = claim.frame
        tip = (-1, len(claim.links) + 1)
        moves, turns = _moves_and_turns(claim)
        if claim.entries["degree"] != 1:
            raise Unproven("a joint path that follows tool poses is straight between its rows")
        if len(claim.rows) != 6:
            origin_moves_with_tip = not moves or origin in tip
            axes_are_known = axes == 0 or axes in tip
            if not origin_moves_with_tip or not axes_are_known:
                raise Unproven("the pose of the tip does not determine what the task wants")
        if turns and not self._path.turned:
            raise Unproven("the file has positions alone, and the task wants orientations")

    def compare(self) -> str:
        """Prove that the tip of the joint path keeps to its lines and turns, within what is asked.

        Returns:
            How far it is from them at most, in words.

        Raises:
            Unproven: it is not proven somewhere.
        """
        seen = [self.tip([self._f.arb(float(value)) for value in row]) for row in self._rows]
        places = self._places([(_doubles(turn), _doubles(point)[:, 0]) for turn, point in seen])
        worst_place = worst_turn = 0.0
        for (first, start), (last, end) in pairwise(places):
            refusal = self._piece((first, last), start, end, seen[first], seen[last])
            worst_place, worst_turn = max(worst_place, refusal[0]), max(worst_turn, refusal[1])
        worst_place, worst_turn = worst_place * 1.005, worst_turn * 1.005  # three digits are printed, none too small
        return self._of_both(f"{worst_place:.3g}", f"{worst_turn:.3g}")

    def tip(self, q: list[Interval]) -> tuple[Matrix, Matrix]:
        """(3, 3) rotation and (3, 1) place of the tip at a configuration, in the base frame."""
        turn, place = tip_motion(self._claim.links, q)
        home = self._claim.home
        return turn * self._f.arb_mat(home[:3, :3].tolist()), turn * self._f.arb_mat(home[:3, 3:].tolist()) + place

    def _aim(self, place: float) -> tuple[Matrix, Matrix]:
        """(3, 3) rotation and (3, 1) place of the tool path, at a place counted in poses from 0."""
        f, last = self._f, len(self._poses) - 1
        k = min(int(place), max(last - 1, 0))
        share = f.arb(place) - k
        first, second = self._poses[k], self._poses[min(k + 1, last)]
        start, end = (f.arb_mat([[float(x)] for x in pose[:3, 3]]) for pose in (first, second))
        turn = f.arb_mat(first[:3, :3].tolist())
        if self._turns and last and np.linalg.norm(self._axes[k]) > 0.0:
            vector = [f.arb(float(x)) for x in self._axes[k]]
            angle = dot(vector, vector).sqrt()
            turn = turn_about([x / angle for x in vector], share * angle) * turn
        return turn, start + (end - start) * share

    def _errors(self, seen: tuple[Matrix, Matrix], place: float) -> tuple[float, float]:
        """How far the tip is from a place of the tool path, at most: its point [m], its axes (spectral norm)."""
        turn, at = self._aim(place)
        apart = seen[0] - turn
        point = self._f.arb_mat([[float(x)] for x in self._point])
        off = (seen[1] - at + apart * point).tolist()
        size = _size([off[k][0] for k in self._moves])
        if not self._turns:
            return size, 0.0
        # of two rotations the spectral norm is that of Frobenius, divided by √2; of one axis the length
        if len(self._entries) == 9:
            share = 2.0**-0.5
        else:
            share = 1.0
        return size, share * _size([apart[r, c] for r, c in self._entries])

    def _bends(self, rows: tuple[int, int], start: float, end: float) -> tuple[float, float]:
        """Bounds on the second derivatives of the point and of the axes, from one row to another."""
        links = self._claim.links
        values = np.array([_link_values(links, row) for row in self._rows[list(rows)]])
        step, most = np.abs(values[1] - values[0]), np.abs(values).max(axis=0)
        slides = np.array([link.kind == SLIDE for link in links])
        along = np.array([_travel_per_unit(link) for link in links])
        turn = np.cumsum(np.where(slides, 0.0, step))
        before = turn - np.where(slides, 0.0, step)
        tool = 0.0
        if self._turns and self._axes:
            axis = self._axes[min(int(start), len(self._axes) - 1)]
            tool = (end - start) * float(np.linalg.norm(axis))
        place = turn**2 @ self._lengths + ((most * before + 2 * step) * before) @ along
        place += float(np.linalg.norm(self._point)) * tool**2
        return float(place) * (1 + 1e-9), float(turn[-1] ** 2 + tool**2) * (1 + 1e-9)

    def _piece(
        self, rows: tuple[int, int], start: float, end: float, first: tuple[Matrix, Matrix],
        last: tuple[Matrix, Matrix],
    ) -> tuple[float, float]:  # fmt: skip
        """How far the tip is from the tool path between two rows, at most: its point [m], its axes [rad]."""
        tip, tilt = self._path.tip, self._path.turn
        bend = self._bends(rows, start, end)
        worst_place = worst_turn = 0.0
        a, b = ([self._f.arb(float(x)) for x in row] for row in self._rows[list(rows)])
        stack = [(0, 1, 1, self._errors(first, start), self._errors(last, end))]  # from low/parts to high/parts
        while stack:
            low, high, parts, near, far = stack.pop()
            off, apart = max(near[0], far[0]), max(near[1], far[1])  # at the ends: of the point, of the axes
            place = off + bend[0] / (8 * parts**2) + self._slack
            turn = self._angle(apart + bend[1] / (8 * parts**2) + _ROUNDED)
            if (place <= tip or not self._moves) and turn <= tilt:
                worst_place, worst_turn = max(worst_place, place), max(worst_turn, turn)
                continue
            off_at_an_end = (off > tip and self._moves) or apart > 2 * tilt
            if off_at_an_end or parts >= 1 << _HALVINGS:
                raise Unproven(f"the tip is not proven to stay within {self._of_both(f'{tip:g}', f'{tilt:g}')} of the "
                               f"lines and turns between its poses, between rows {rows[0] + 1} and "
                               f"{rows[1] + 1}")  # fmt: skip
            share = self._f.arb(low + high) / (2 * parts)
            seen = self.tip([x + (y - x) * share for x, y in zip(a, b, strict=True)])
            middle = self._errors(seen, start + (end - start) * ((low + high) / (2 * parts)))
            stack += [(low + high, 2 * high, 2 * parts, middle, far), (2 * low, low + high, 2 * parts, near, middle)]
        return worst_place, worst_turn

    def _angle(self, chord: float) -> float:
        """The angle [rad] between two rotations of which ‖R − S‖ ≤ chord, at most; 0 where turns do not count."""
        if not self._turns:
            return 0.0
        return 2 * float(np.arcsin(min(1.0, chord / 2))) * (1 + 1e-12)

    def _of_both(self, place: str, turn: str) -> str:
        """A length and an angle in words, each where it counts."""
        parts = []
        if self._moves:
            parts.append(f"{place} m")
        if self._turns:
            parts.append(f"{turn} rad")
        return " and ".join(parts)

    def _places(self, seen: list[tuple[Array, Array]]) -> list[tuple[int, float]]:
        """(row, place on the tool path, counted in poses from 0), neither ever going back; every pose is one of them.

        Raises:
            Unproven: a pose that no row reaches.
        """
        last, count = len(self._poses) - 1, len(seen)
        if not last:
            return [(row, 0.0) for row in range(count)]
        at = [0]
        for k in range(1, last):
            at.append(self._row_at_pose(seen, k, at[-1]))
        at.append(count - 1)
        places = [(0, 0.0)]
        for k, (low, high) in enumerate(pairwise(at)):
            share = 0.0
            for row in range(low + 1, high):
                share = max(share, min(1.0, self._share(seen[row], k)))
                places.append((row, k + share))
            places.append((high, k + 1.0))
        return places

    def _row_at_pose(self, seen: list[tuple[Array, Array]], k: int, begin: int) -> int:
        """The first row from `begin` on that is at pose k, or nearest to it after the first that is near enough."""
        sizes: list[float] = []
        for turn, point in seen[begin:]:
            off = (point - self._poses[k][:3, 3]) + (turn - self._poses[k][:3, :3]) @ self._point
            apart = turn - self._poses[k][:3, :3]
            of_place = float(np.linalg.norm(off[self._moves])) / self._path.tip
            of_turn = float(np.linalg.norm([apart[r, c] for r, c in self._entries])) / self._path.turn
            sizes.append(max(of_place, of_turn * self._turns))
            if len(sizes) > 1 and sizes[-2] <= 1.0 and sizes[-1] > sizes[-2]:
                return begin + len(sizes) - 2
        if not sizes or sizes[-1] > 1.0:
            raise Unproven(f"no row of the joint path reaches pose {k + 1} of the file")
        return begin + len(sizes) - 1

    def _share(self, seen: tuple[Array, Array], k: int) -> float:
        """Share of the way from pose k to the next at which the tip is nearest."""
        way, axis, length = self._poses[k + 1][:3, 3] - self._poses[k][:3, 3], self._axes[k], self._claim.length
        way = np.where(np.isin(range(3), self._moves), way, 0.0)
        along, whole = float(way @ (seen[1] - self._poses[k][:3, 3])) / length**2, float(way @ way) / length**2
        if self._turns and len(self._entries) == 9:
            turned = _log(seen[0] @ self._poses[k][:3, :3].T)
            along, whole = along + float(axis @ turned), whole + float(axis @ axis)
        return along / whole if whole > 0.0 else 0.0


def _moves_and_turns(claim: Claim) -> tuple[list[int], list[int]]:
    """Coordinates 0, 1, 2 of the translations, and of the turns, that the task of a claim asks for."""
    moves = [row for row in claim.rows if row < 3]
    turns = [row - 3 for row in claim.rows if row >= 3]
    return moves, turns


def _entries_of_rotation(turns: list[int], *, by_rows: bool) -> list[tuple[int, int]]:
    """Entries (row, column) of the rotation of the tip that a task with these turns fixes.

    Two turns leave one axis free: that of the base, a row of the rotation, or of the tip, a column of it.
    """
    entries = [(row, column) for row in range(3) for column in range(3)]
    if len(turns) != 2:
        return entries
    left = next(k for k in range(3) if k not in turns)
    if by_rows:
        return [entry for entry in entries if entry[0] == left]
    return [entry for entry in entries if entry[1] == left]


def _size(numbers: list[Interval]) -> float:
    """Length of a vector of intervals, at most; inf where it is not known."""
    largest = [float(x.abs_upper()) for x in numbers]
    size = float(np.linalg.norm(largest)) * (1 + 1e-14)
    if np.isfinite(size):
        return size
    return float("inf")


def _log(turn: Array) -> Array:
    """(3,) vector of a rotation (3, 3), shorter than half a turn."""
    twist = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    sine, cosine = float(np.linalg.norm(twist)), (float(np.trace(turn)) - 1.0) / 2
    if sine < 1e-300:
        if cosine < 0.0:
            return np.array([np.pi, 0.0, 0.0])
        return twist
    return np.asarray(twist * (np.arctan2(sine, cosine) / sine))


def _turn_between(first: Array, second: Array) -> Array:
    """(3,) turn from one pose to the next, in base axes."""
    return _log(second[:3, :3] @ first[:3, :3].T)


def _points_on_axes(links: list[Link]) -> Array:
    """(N, 3) a point on the axis of each joint at q = 0, near that of the joint before it."""
    points, near = [], np.zeros(3)
    for link in links:
        v, w = np.array(link.screw[:3]), np.array(link.screw[3:])
        if link.kind != SLIDE:
            foot, axis = np.cross(w, v) / (w @ w), w / np.linalg.norm(w)
            near = foot + axis * float(axis @ (near - foot))
        points.append(near)
    return np.array(points)


def _link_values(links: list[Link], row: Array) -> list[float]:
    """Values of all joints, mimic joints too, at the joint values of a row."""
    return [link.multiplier * row[link.driver] + link.offset for link in links]


def _travel_per_unit(link: Link) -> float:
    """How far a unit of the joint's value carries along its axis."""
    v, w = np.array(link.screw[:3]), np.array(link.screw[3:])
    if link.kind == SLIDE:
        return 1.0
    if link.kind == SCREW:
        return abs(float(v @ w) / float(w @ w))
    return 0.0


def _doubles(matrix: Matrix) -> Array:
    """The midpoints of a matrix of intervals."""
    return np.array([float(x.mid()) for x in matrix.entries()]).reshape(matrix.nrows(), matrix.ncols())
