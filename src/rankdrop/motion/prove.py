"""Every stretch of a path proven free of singularities, or narrowed down to slivers that are not.

First boxes around runs of 2^k stretches, all at once: free, or halved. What is left inside single stretches is halved
further with the bound along the curve (`Along`), until pieces are free or as narrow as double precision decides. The
pieces cover the path, so nothing hides between samples. Work is counted in enclosures, never in seconds.

The bound along a curve is the enclosure of a certificate with a direction.

The enclosure of a box (`rankdrop.certify`) takes the sum of what every joint can do on its own. Along a curve
q = c + Δ τ + e, |τ| ≤ 1, |e_k| ≤ ε_k, the joints move together, and with U₁, Σ, V₁ the first r singular directions at c

    U₁ᵀ J(q) V₁ = Σ + E,   |E_ij| ≤ |g_ij| + ½ |H_ij| + T_j + X_j + rounding

    g = U₁ᵀ dJ(Δ) V₁,   H = U₁ᵀ d²J(Δ, Δ) V₁             brackets at c, once and twice
    T_j = ⅙ Σ_i |v_ij| (M_i t³ + 3 t² s)                 third order, t and s of Δ: the remainder of the box
    X_j = Σ_i |v_ij| (M_i t_ε + s_ε)                     what e adds, by the mean value theorem

M_i bounds every derivative of column i by turns everywhere near the curve; t and s are sums of |Δ_k| over the turning
joints, of |Δ_k|/ℓ over the slides between joint i and the link that the screws are seen from. Where a curve only
touches the singular set g vanishes with σ, so that few pieces are enough where boxes would need a million.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.certify.setting import Setting, enclose, regular
from rankdrop.kinematics import chain_of
from rankdrop.local.departure import unlocked
from rankdrop.motion.curve import Curve, Index, boxes, halves, straightened
from rankdrop.robot.model import Array, JointKind, Robot

Progress = Callable[[int, int], None]
"""progress(decided, all): stretches."""

NARROW = 1e-9  # a piece no joint moves further on is not halved: rounding decides there [rad; slides scaled]
_WIDE = 1.0  # boxes with a longer half diagonal are halved unseen [rad]
_ALONG = 0.5  # curves with a shorter half chord get the bound along them [rad]
_BATCH = 4096  # pieces enclosed together
_LOOKS = 64  # samples that a setting is chosen by
_HOPELESS = 2.0  # σ_r at or below this many times the rounding allowance cannot be separated from zero
Mask = NDArray[np.bool_]

ROUNDED = 1e-14
"""Of a joint value per radian of it: what some thirty halvings of a curve leave of its last digits."""


@dataclass(frozen=True, eq=False)
class Enclosed:
    """The bound over P short curves.

    Attributes:
        free: (P,) the rank is kept on all of the curve, proven.
        sigma: (P, r) Σ at the middle.
        bound: (P, r, r) what |E| does not exceed.
        floor: (P, r, r) what the bound is for a curve of no length: the allowance for rounding.
        u, v: (P, m, r) and (P, n, r) the singular directions it speaks of.
    """

    free: Mask
    sigma: Array
    bound: Array
    floor: Array
    u: Array
    v: Array


@dataclass(frozen=True, eq=False)
class Along:
    """An arm seen from one setting, ready to enclose curves.

    Attributes:
        robot: the arm.
        setting: of a certificate.
    """

    robot: Robot
    setting: Setting

    @cached_property
    def _free(self) -> tuple[Robot, Array, Array]:
        """The chain with every joint a variable, its values at q = 0, and the shares (N, n) of the variables."""
        return unlocked(self.robot, np.zeros(self.robot.n))

    @cached_property
    def _view(self) -> _core.View:
        """All six rows, whatever the task takes: brackets need whole screws."""
        length = self.setting.length
        link, point = self.setting.link, list(self.setting.point)
        return _core.make_view(
            chain_of(self._free[0]), axes=link, origin=link, point=point, rows=list(range(6)),
            factors=[1 / length] * 3 + [1.0] * 3,
        )  # fmt: skip

    def enclosed(self, middle: Array, chord: Array, extra: Array) -> Enclosed:
        """Bounds over curves c + Δ τ + e.

        Args:
            middle, chord, extra: (P, n) c, Δ and ε [rad, m], as from `straightened`.
        """
        setting = self.setting
        extra = extra + ROUNDED * (setting.scale + np.abs(middle) + np.abs(chord))
        half = (np.abs(chord) + extra) / setting.scale
        _, _, _, sigma, u, v, largest = enclose(self.robot, setting, middle, half)
        floor = enclose(self.robot, setting, middle, np.zeros_like(half))[2]
        bound = (floor + self._orders(middle, chord, extra, u, v, largest)) * (1 + 1e-12)
        return Enclosed(regular(sigma, bound), sigma, bound, floor, u, v)

    def _orders(self, middle: Array, chord: Array, extra: Array, u: Array, v: Array, largest: Array) -> Array:
        """(P, r, r) all but the rounding."""
        setting = self.setting
        free, offset, share = self._free
        joints = np.ascontiguousarray(middle @ share.T + offset)
        screws = _core.jacobian(chain_of(free), self._view, joints).swapaxes(1, 2)  # (P, N, 6)
        step, slack = chord @ share.T, extra @ np.abs(share).T
        weight = np.einsum("ij,pjr->pir", share, v)  # (P, N, r)
        slides = np.array([joint.kind is JointKind.PRISMATIC for joint in free.joints])
        size = np.where(slides, np.abs(step) + slack, np.abs(step) + slack)
        size[:, slides] /= setting.length
        slack = np.where(slides, slack / setting.length, slack)
        lever = np.where(slides, 0.0, np.abs(share).sum(axis=1)) * (setting.rows[0] < 3)
        driven = np.abs(v)[:, np.abs(share).argmax(axis=1)]  # (P, N, r) |v| of the variable that drives each joint
        count, rank = len(middle), v.shape[2]
        first, second = np.zeros((count, 6, rank)), np.zeros((count, 6, rank))
        rest = np.zeros((count, rank))
        for order, sign in self._sides():
            beyond = np.zeros((count, 6, rank))
            for place in range(len(order) - 1, -1, -1):
                joint = order[place]
                nearer = np.einsum("pk,pkc->pc", step[:, order[:place]], screws[:, order[:place]])
                mover = step[:, joint, None] * screws[:, joint]
                moved = _bracket(mover, beyond)
                first += sign * moved
                second += _bracket(mover + 2 * nearer, moved)
                beyond = beyond + screws[:, joint, :, None] * weight[:, joint, None, :]
                rest += self._remainder(joint, order[:place], slides, size, slack, largest, lever)[:, None] * (
                    driven[:, joint]
                )
        rows = list(setting.rows)
        slope = np.abs(np.einsum("pcr,pcs->prs", u, first[:, rows]))
        bend = np.abs(np.einsum("pcr,pcs->prs", u, second[:, rows]))
        return np.asarray(slope + bend / 2 + rest[:, None, :])

    def _sides(self) -> tuple[tuple[list[int], float], ...]:
        """Joints from the link outwards, after it and before it, with the sign of their brackets."""
        link, count = self.setting.link, len(self.robot.joints)
        return (list(range(link, count)), 1.0), (list(range(link - 1, -1, -1)), -1.0)

    @staticmethod
    def _remainder(
        joint: int, between: list[int], slides: Mask, size: Array, slack: Array, largest: Array, lever: Array
    ) -> Array:
        """(P,) M t³/6 + t² s/2 + M t_ε + s_ε of one column."""
        turning = [k for k in between if not slides[k]]
        sliding = [k for k in between if slides[k]]
        t, s = size[:, turning].sum(axis=1), size[:, sliding].sum(axis=1)
        t_extra, s_extra = slack[:, turning].sum(axis=1), slack[:, sliding].sum(axis=1)
        return np.asarray(
            largest[:, joint] * (t**3 / 6 + t_extra) + lever[joint] * (t * t * s / 2 + s_extra)
        )


def _bracket(a: Array, b: Array) -> Array:
    """(P, 6, r) Lie brackets [a, b_j] of twists a (P, 6) and b (P, 6, r), linear part first."""
    v, w = a[:, :3, None], a[:, 3:, None]
    linear, angular = b[:, :3], b[:, 3:]
    return np.concatenate([_cross(w, linear) + _cross(v, angular), _cross(w, angular)], axis=1)


def _cross(a: Array, b: Array) -> Array:
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )


@dataclass(frozen=True, eq=False)
class Pieces:
    """Parts of stretches.

    Attributes:
        stretch: (P,) which.
        start, end: (P,) shares of it.
        control: (P, d + 1, n) control points.
    """

    stretch: Index
    start: Array
    end: Array
    control: Array

    def __len__(self) -> int:
        return len(self.stretch)

    def __getitem__(self, which: NDArray[np.bool_] | slice) -> Pieces:
        return Pieces(self.stretch[which], self.start[which], self.end[which], self.control[which])

    def halved(self) -> Pieces:
        """Both halves of each, in order."""
        middle = (self.start + self.end) / 2
        start, end = np.stack([self.start, middle], axis=1), np.stack([middle, self.end], axis=1)
        return Pieces(np.repeat(self.stretch, 2), start.reshape(-1), end.reshape(-1), halves(self.control))


@dataclass(frozen=True, eq=False)
class Sliver:
    """A connected part of the path that is not proven free.

    Attributes:
        stretches: first and last stretch it has a part of.
        shares: where it begins in the first and ends in the last.
        finished: False where the work ended before it was narrow.
    """

    stretches: tuple[int, int]
    shares: tuple[float, float]
    finished: bool


@dataclass(frozen=True, eq=False)
class Proof:
    """What is proven of a path: all of it but the slivers is free.

    Attributes:
        slivers: in order along the path.
        evaluations: enclosures spent.
        setting: of the certificate they are seen from.
        complete: False where the work was interrupted.
    """

    slivers: tuple[Sliver, ...]
    evaluations: int
    setting: Setting
    complete: bool


@dataclass(eq=False)
class _Spent:
    budget: int
    stretches: int
    progress: Progress | None
    spent: int = 0
    interrupted: bool = False
    left: list[tuple[int, float, float, bool]] = field(default_factory=list)  # stretch, start, end, finished

    def afford(self, count: int) -> bool:
        """Whether so many more enclosures may be made; counts them."""
        if self.interrupted or self.spent + count > self.budget:
            return False
        self.spent += count
        return True

    def report(self, open_stretches: int) -> None:
        """Say how many stretches are decided; whoever listens may press Ctrl-C."""
        try:
            if self.progress is not None:
                self.progress(self.stretches - open_stretches, self.stretches)
        except KeyboardInterrupt:
            self.interrupted = True


def prove(
    robot: Robot,
    settings: tuple[Setting, ...],
    path: Curve,
    *,
    singular: float,
    evaluations: int,
    progress: Progress | None = None,
) -> Proof:
    """Prove as much of a path free of singularities as can be.

    Args:
        robot: the arm.
        settings: from `settings_for`; the one that sees farthest along the path is taken.
        path: the curve.
        singular: where σ_r, as the setting has it, is below this at every point evaluated, a stretch lies in the
            singular set and is not halved down.
        evaluations: enclosures to be spent at most; what is left over then is a sliver that is not finished.
        progress: called with how many stretches are decided.
    """
    setting = chosen(robot, settings, path)
    work = _Spent(evaluations, len(path.control), progress)
    left = _runs(robot, setting, path, work)
    work.report(len(left))
    _halve(Along(robot, setting), _whole_stretches(path, left), work, singular)
    return Proof(tuple(_join_neighbours(work.left)), work.spent, setting, not work.interrupted)


def chosen(robot: Robot, settings: tuple[Setting, ...], path: Curve) -> Setting:
    """The setting whose balls are largest along the path, in the mean of their logarithms."""
    at = np.unique(np.linspace(0, len(path.control) - 1, _LOOKS).astype(np.int64))
    q = np.ascontiguousarray(path.at(at, np.full(len(at), 0.5)))
    radii = [enclose(robot, setting, q, radius=np.pi)[1] for setting in settings]
    return settings[int(np.argmax([np.log(np.maximum(one, 1e-6)).mean() for one in radii]))]


def _runs(robot: Robot, setting: Setting, path: Curve, work: _Spent) -> Index:
    """Stretches that no box around a run of 2^k of them proves free."""

    def free(low: Array, high: Array) -> NDArray[np.bool_]:
        try:
            return _free(robot, setting, low, high, work)
        except KeyboardInterrupt:
            work.interrupted = True  # nothing more is afforded: what is open stays so
            return np.zeros(len(low), dtype=np.bool_)

    return stretches_left(path, free)


def stretches_left(path: Curve, free: Callable[[Array, Array], NDArray[np.bool_]]) -> Index:
    """Stretches that are in no box for which `free(lower, upper)` holds, of boxes around runs of 2^k, k ≥ 1."""
    tree, nodes = box_tree(path), np.zeros(1, dtype=np.int64)
    for level in range(len(tree) - 1, 0, -1):
        low, high = tree[level]
        nodes = nodes[~free(low[nodes], high[nodes])]
        nodes = np.stack([2 * nodes, 2 * nodes + 1], axis=1).reshape(-1)
        nodes = nodes[nodes < len(tree[level - 1][0])]
    return nodes


def box_tree(path: Curve) -> list[tuple[Array, Array]]:
    """Lower and upper corners of boxes around runs of 1, 2, 4, … stretches; the last level is one box around all."""
    tree = [boxes(path.control)]
    while len(tree[-1][0]) > 1:
        low, high = tree[-1]
        if len(low) % 2:
            low, high = np.concatenate([low, low[-1:]]), np.concatenate([high, high[-1:]])
        tree.append((np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])))
    return tree


def _free(robot: Robot, setting: Setting, low: Array, high: Array, work: _Spent) -> NDArray[np.bool_]:
    """(P,) which boxes are proven free; those too wide to be are not tried."""
    centre, half = centred(low, high, setting)
    free = np.zeros(len(low), dtype=np.bool_)
    tried = np.flatnonzero(np.linalg.norm(half[:, setting.matters], axis=1) < _WIDE)
    for part in _batches(tried):
        if not work.afford(len(part)):
            break
        free[part] = enclose(robot, setting, centre[part], half[part])[0] != 0
    return free


def centred(low: Array, high: Array, setting: Setting) -> tuple[Array, Array]:
    """Middles of boxes, and halves of their sides in scaled joints, rounding included."""
    centre = np.ascontiguousarray((low + high) / 2)
    return centre, ((high - low) / 2 + ROUNDED * (setting.scale + np.abs(centre))) / setting.scale


def _batches(rows: Index) -> Iterator[Index]:
    return (rows[i : i + _BATCH] for i in range(0, len(rows), _BATCH))


def _whole_stretches(path: Curve, stretches: Index) -> Pieces:
    count = len(stretches)
    return Pieces(stretches, np.zeros(count), np.ones(count), path.control[stretches])


def _halve(along: Along, pieces: Pieces, work: _Spent, singular: float) -> None:
    """Halve pieces of single stretches until they are free or narrow."""
    while len(pieces):
        work.report(len(np.unique(pieces.stretch)))
        kept = []
        for i in range(0, len(pieces), _BATCH):
            part = pieces[i : i + _BATCH]
            if not work.afford(len(part)):
                _give_up(part, work, finished=False)
                continue
            try:
                left, stuck = _undecided(along, part, work, singular)
            except KeyboardInterrupt:
                work.interrupted = True
                _give_up(part, work, finished=False)
                continue
            _give_up(stuck, work, finished=True)
            if len(left):
                kept.append(left.halved())
        pieces = _together(kept) if kept else pieces[:0]


def _together(parts: list[Pieces]) -> Pieces:
    return Pieces(*(np.concatenate([getattr(part, name) for part in parts]) for name in Pieces.__dataclass_fields__))


def _undecided(along: Along, pieces: Pieces, work: _Spent, singular: float) -> tuple[Pieces, Pieces]:
    """Those that are not free: to be halved, and as narrow as can be."""
    middle, chord, extra = straightened(pieces.control)
    scale, matters = along.setting.scale, along.setting.matters
    length = np.linalg.norm(((np.abs(chord) + extra) / scale)[:, matters], axis=1)
    free = np.zeros(len(pieces), dtype=np.bool_)
    small = length < _ALONG
    low, high = boxes(pieces.control[~small])
    if len(low):
        free[~small] = _free(along.robot, along.setting, low, high, work)
    stuck = np.zeros(len(pieces), dtype=np.bool_)
    if small.any():
        found = along.enclosed(middle[small], chord[small], extra[small])
        free[small] = found.free
        stuck[small] = _stuck(along, pieces[small], found, length[small], singular)
    return pieces[~free & ~stuck], pieces[stuck & ~free]


def _stuck(along: Along, pieces: Pieces, enclosed: Enclosed, length: Array, singular: float) -> NDArray[np.bool_]:
    """Pieces that halving does not help: narrow ones, and those singular to rounding wherever one looks."""
    stuck = length <= NARROW
    hopeless = ~enclosed.free & ~stuck & ~regular(enclosed.sigma, _HOPELESS * enclosed.floor)
    hopeless |= ~enclosed.free & ~stuck & (enclosed.sigma[:, -1] <= singular)
    rows = np.flatnonzero(hopeless)
    if len(rows):
        quarters = np.array([0.0, 0.25, 0.75, 1.0])
        inside = Curve(pieces.control[rows], None)
        bad = np.ones(len(rows), dtype=np.bool_)
        for share in quarters:
            q = np.ascontiguousarray(inside.at(np.arange(len(rows)), np.full(len(rows), share)))
            _, _, floor, sigma, *_ = enclose(along.robot, along.setting, q, np.zeros_like(q))
            bad &= ~regular(sigma, _HOPELESS * floor) | (sigma[:, -1] <= singular)
        stuck[rows] = bad
    return np.asarray(stuck)


def _give_up(pieces: Pieces, work: _Spent, *, finished: bool) -> None:
    rows = zip(pieces.stretch.tolist(), pieces.start.tolist(), pieces.end.tolist(), strict=True)
    work.left += [(*row, finished) for row in rows]


def _join_neighbours(left: list[tuple[int, float, float, bool]]) -> Iterator[Sliver]:
    run: list[tuple[int, float, float, bool]] = []
    for piece in sorted(left):
        if run and not _follows(run[-1], piece):
            yield _sliver(run)
            run = []
        run.append(piece)
    if run:
        yield _sliver(run)


def _follows(first: tuple[int, float, float, bool], second: tuple[int, float, float, bool]) -> bool:
    if first[3] != second[3]:
        return False
    if first[0] == second[0]:
        return first[2] == second[1]
    return first[0] + 1 == second[0] and first[2] == 1.0 and second[1] == 0.0


def _sliver(run: list[tuple[int, float, float, bool]]) -> Sliver:
    return Sliver((run[0][0], run[-1][0]), (run[0][1], run[-1][2]), run[0][3])
