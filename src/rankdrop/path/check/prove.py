"""Every stretch of a path proven free of singularities, or narrowed down to slivers that are not.

First boxes around runs of 2^k stretches, all at once: free, or halved. What is left inside single stretches is halved
further with the bound along the curve (`Along`), until pieces are free or as narrow as double precision decides. The
pieces cover the path, so nothing hides between samples. Work is counted in enclosures, never in seconds.

The bound along a curve is the enclosure of a certificate with a direction.

The enclosure of a box (`rankdrop.cover`) takes the sum of what every joint can do on its own. Along a curve
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

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.cover.setting import Setting, enclose, regular
from rankdrop.kinematics import chain_of
from rankdrop.local.departure import release_mimics
from rankdrop.path.curve import Curve, Index, Spot, boxes, chord_form, halves
from rankdrop.robot.model import Array, JointKind, Robot

Outcome = TypeVar("Outcome")
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

Sliver = tuple[Spot, Spot, bool]
"""A connected part of a path that is not proven free: start, end; False where the work ended before it was narrow."""


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
        return release_mimics(self.setting.with_tip_frame(self.robot), np.zeros(self.robot.n))

    @cached_property
    def _view(self) -> _core.View:
        """All six rows, whatever the task takes: brackets need whole screws."""
        length = self.setting.length
        link, point = self.setting.link, list(self.setting.point)
        return _core.make_view(
            chain_of(self._free[0]), axes=link, origin=link, point=point, rows=list(range(6)),
            factors=[1 / length] * 3 + [1.0] * 3,
        )  # fmt: skip

    def enclose_curves(self, middle: Array, chord: Array, extra: Array) -> Enclosed:
        """Bounds over curves c + Δ τ + e.

        Args:
            middle, chord, extra: (P, n) c, Δ and ε [rad, m], as from `chord_form`.
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
        lengths = np.where(slides, setting.length, 1.0)
        size, slack = (np.abs(step) + slack) / lengths, slack / lengths
        sums = np.stack([size * ~slides, size * slides, slack * ~slides, slack * slides])  # t, s, t_ε, s_ε by joint
        lever = np.where(slides, 0.0, np.abs(share).sum(axis=1)) * (setting.rows[0] < 3)
        driven = np.abs(v)[:, np.abs(share).argmax(axis=1)]  # (P, N, r) |v| of the variable that drives each joint
        count, rank = len(middle), v.shape[2]
        first, second = np.zeros((count, 6, rank)), np.zeros((count, 6, rank))
        rest = np.zeros((count, rank))
        link, last = setting.link, len(self.robot.joints)  # joints outwards from the link, after it and before it
        for order, sign in ((list(range(link, last)), 1.0), (list(range(link - 1, -1, -1)), -1.0)):
            beyond = np.zeros((count, 6, rank))
            for place in range(len(order) - 1, -1, -1):
                joint = order[place]
                nearer = np.einsum("pk,pkc->pc", step[:, order[:place]], screws[:, order[:place]])
                mover = step[:, joint, None] * screws[:, joint]
                moved = _bracket(mover, beyond)
                first += sign * moved
                second += _bracket(mover + 2 * nearer, moved)
                beyond = beyond + screws[:, joint, :, None] * weight[:, joint, None, :]
                t, s, t_extra, s_extra = sums[:, :, order[:place]].sum(axis=2)
                third = largest[:, joint] * (t**3 / 6 + t_extra) + lever[joint] * (t * t * s / 2 + s_extra)
                rest += third[:, None] * driven[:, joint]
        rows = list(setting.rows)
        slope = np.abs(np.einsum("pcr,pcs->prs", u, first[:, rows]))
        bend = np.abs(np.einsum("pcr,pcs->prs", u, second[:, rows]))
        return np.asarray(slope + bend / 2 + rest[:, None, :])


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
class StretchParts:
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

    def __getitem__(self, which: Mask | slice) -> StretchParts:
        return StretchParts(self.stretch[which], self.start[which], self.end[which], self.control[which])

    def halves(self) -> StretchParts:
        """Both halves of each, in order."""
        middle = (self.start + self.end) / 2
        start, end = np.stack([self.start, middle], axis=1), np.stack([middle, self.end], axis=1)
        return StretchParts(np.repeat(self.stretch, 2), start.reshape(-1), end.reshape(-1), halves(self.control))


@dataclass(eq=False)
class Proof:
    """What is proven of a path: all of it but the slivers is free.

    Attributes:
        setting: of the enclosures.
        budget: enclosures at most.
        stretches: of the path.
        progress: called with how many of them are decided.
        evaluations: enclosures spent.
        complete: False where Ctrl-C ended the work.
        rest: pieces that are not proven free: stretch, start, end, and whether they are narrow.
    """

    setting: Setting
    budget: int
    stretches: int
    progress: Progress | None
    evaluations: int = 0
    complete: bool = True
    rest: list[tuple[int, float, float, bool]] = field(default_factory=list)

    @property
    def slivers(self) -> tuple[Sliver, ...]:
        """In order along the path."""
        return tuple(join_neighbours(self.rest))

    def attempt(self, cost: int, step: Callable[[], Outcome]) -> Outcome | None:
        """What a step returns that takes so many enclosures; None beyond the budget and after Ctrl-C."""
        if not self.complete or self.evaluations + cost > self.budget:
            return None
        self.evaluations += cost
        try:
            return step()
        except KeyboardInterrupt:
            self.complete = False
            return None

    def report(self, open_stretches: int) -> None:
        """Report how many stretches are decided."""
        if self.progress is not None:
            self.attempt(0, partial(self.progress, self.stretches - open_stretches, self.stretches))

    def give_up(self, pieces: StretchParts, *, narrow: bool) -> None:
        """Leave pieces open."""
        ends = zip(pieces.stretch.tolist(), pieces.start.tolist(), pieces.end.tolist(), strict=True)
        self.rest += [(*span, narrow) for span in ends]


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
    work = Proof(setting, evaluations, len(path.control), progress)
    stretch = stretches_left(path, lambda low, high: free_boxes(robot, low, high, work))
    work.report(len(stretch))
    pieces = StretchParts(stretch, np.zeros(len(stretch)), np.ones(len(stretch)), path.control[stretch])
    along = Along(robot, setting)
    while len(pieces):
        work.report(len(np.unique(pieces.stretch)))
        halved = []
        for part in (pieces[i : i + _BATCH] for i in range(0, len(pieces), _BATCH)):
            split = work.attempt(len(part), partial(_split_undecided, along, part, work, singular))
            if split is None:
                work.give_up(part, narrow=False)
                continue
            work.give_up(split[1], narrow=True)
            halved.append(split[0].halves())
        columns = (np.concatenate([getattr(part, name) for part in halved] or [getattr(pieces, name)[:0]])
                   for name in StretchParts.__dataclass_fields__)  # fmt: skip
        pieces = StretchParts(*columns)
    return work


def chosen(robot: Robot, settings: tuple[Setting, ...], path: Curve) -> Setting:
    """The setting whose balls are largest along the path, in the mean of their logarithms."""
    at = np.unique(np.linspace(0, len(path.control) - 1, _LOOKS).astype(np.int64))
    q = np.ascontiguousarray(path.at(at, np.full(len(at), 0.5)))
    radii = [enclose(robot, setting, q, radius=np.pi)[1] for setting in settings]
    return settings[int(np.argmax([np.log(np.maximum(radius, 1e-6)).mean() for radius in radii]))]


def stretches_left(path: Curve, free: Callable[[Array, Array], Mask]) -> Index:
    """Stretches that are in no box for which `free(lower, upper)` holds, of boxes around runs of 2^k, k ≥ 1."""
    tree, nodes = box_tree(path), np.zeros(1, dtype=np.int64)
    for level in range(len(tree) - 1, 0, -1):
        low, high = tree[level]
        nodes = nodes[~free(low[nodes], high[nodes])]
        nodes = np.stack([2 * nodes, 2 * nodes + 1], axis=1).reshape(-1)
        nodes = nodes[nodes < len(tree[level - 1][0])]
    return nodes


def first_open(
    path: Curve, prove_boxes: Callable[[Array, Array], Mask], prove_pieces: Callable[[Array], tuple[Mask, Mask]]
) -> int:
    """A stretch for which something could not be shown, −1 where it is shown for all of a path.

    Args:
        path: the curve.
        prove_boxes: (lower, upper) corners of boxes -> for which it is shown: of runs of stretches, tried first.
        prove_pieces: control points of pieces -> for which it is shown, and which are given up; the others are halved.
    """
    stretch = stretches_left(path, prove_boxes)
    control = path.control[stretch]
    while len(control):
        done, lost = prove_pieces(control)
        if lost.any():
            return int(stretch[lost.argmax()])
        control, stretch = halves(control[~done]), np.repeat(stretch[~done], 2)
    return -1


def box_tree(path: Curve) -> list[tuple[Array, Array]]:
    """Lower and upper corners of boxes around runs of 1, 2, 4, … stretches; the last level is one box around all."""
    tree = [boxes(path.control)]
    while len(tree[-1][0]) > 1:
        low, high = tree[-1]
        if len(low) % 2:
            low, high = np.concatenate([low, low[-1:]]), np.concatenate([high, high[-1:]])
        tree.append((np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])))
    return tree


def free_boxes(robot: Robot, low: Array, high: Array, work: Proof) -> Mask:
    """(P,) which boxes are proven free; those too wide to be are not tried."""
    centre, half = centre_and_half_sides(low, high, work.setting)
    free = np.zeros(len(low), dtype=np.bool_)
    tried = np.flatnonzero(np.linalg.norm(half[:, work.setting.matters], axis=1) < _WIDE)
    for part in (tried[i : i + _BATCH] for i in range(0, len(tried), _BATCH)):
        enclosed = work.attempt(len(part), partial(enclose, robot, work.setting, centre[part], half[part]))
        if enclosed is None:
            break
        free[part] = enclosed[0] != 0
    return free


def centre_and_half_sides(low: Array, high: Array, setting: Setting) -> tuple[Array, Array]:
    """Middles of boxes, and halves of their sides in scaled joints, rounding included."""
    centre = np.ascontiguousarray((low + high) / 2)
    return centre, ((high - low) / 2 + ROUNDED * (setting.scale + np.abs(centre))) / setting.scale


def _split_undecided(
    along: Along, pieces: StretchParts, work: Proof, singular: float
) -> tuple[StretchParts, StretchParts]:
    """Those that are not free: to be halved, and as narrow as can be."""
    middle, chord, extra = chord_form(pieces.control)
    scale, matters = along.setting.scale, along.setting.matters
    length = np.linalg.norm(((np.abs(chord) + extra) / scale)[:, matters], axis=1)
    free = np.zeros(len(pieces), dtype=np.bool_)
    small = length < _ALONG
    low, high = boxes(pieces.control[~small])
    if len(low):
        free[~small] = free_boxes(along.robot, low, high, work)
    stuck = np.zeros(len(pieces), dtype=np.bool_)
    if small.any():
        enclosed = along.enclose_curves(middle[small], chord[small], extra[small])
        free[small] = enclosed.free
        stuck[small] = _stuck(along, pieces[small], enclosed, length[small], singular)
    return pieces[~free & ~stuck], pieces[stuck & ~free]


def _stuck(along: Along, pieces: StretchParts, enclosed: Enclosed, length: Array, singular: float) -> Mask:
    """Pieces that halving does not help: narrow ones, and those singular to rounding wherever one looks."""
    stuck = length <= NARROW
    rows = np.flatnonzero(~enclosed.free & ~stuck & _hopeless(enclosed.sigma, enclosed.floor, singular))
    share = np.tile([0.0, 0.25, 0.75, 1.0], len(rows))
    q = Curve(pieces.control[rows], None).at(np.repeat(np.arange(len(rows)), 4), share)
    if len(rows):
        _, _, floor, sigma, *_ = enclose(along.robot, along.setting, np.ascontiguousarray(q), np.zeros_like(q))
        stuck[rows] = _hopeless(sigma, floor, singular).reshape(-1, 4).all(axis=1)
    return np.asarray(stuck)


def _hopeless(sigma: Array, floor: Array, singular: float) -> Mask:
    """(P,) singular to rounding."""
    return np.asarray(~regular(sigma, _HOPELESS * floor) | (sigma[:, -1] <= singular))


def join_neighbours(rest: list[tuple[int, float, float, bool]]) -> list[Sliver]:
    """Pieces (stretch, start, end, narrow) as the slivers that they make together; what is narrow stays apart."""
    slivers: list[Sliver] = []
    for stretch, start, end, narrow in sorted(rest):
        first: Spot = (stretch, start)
        if slivers and slivers[-1][2] == narrow:
            last = slivers[-1][1]
            if last == first or (start == 0.0 and last == (stretch - 1, 1.0)):
                first = slivers.pop()[0]
        slivers.append((first, (stretch, end), narrow))
    return slivers
