"""Programs led around a singularity: how much farther does the tool leave its path than it has to?

Programs have one crossing each, at a random singularity of corank 1 (the wrist, the elbow, the shoulder, …). They are
files of joint values that come back (`dip`) or stay on the other side (`over`), and files of the tool poses of the
latter (`through`), also with the tool turned by a small angle, so that they pass by the singularity (`past`).

The product's first remedy is held against a slow optimiser of its own. At N places of a window around the crossing,
close together at it, it moves all joints of all places:

    min max_i |p(q_i) − p_i|/ℓ + ∠(R(q_i), R_i)   over   room(q_i) ≥ 0.9 · 0.2°,   |q_{i+1} − q_i| ≤ 0.35 rad,
                                      lower ≤ q_i ≤ upper,   q_0 the old one, the tool at its end on its path

where (p_i, R_i) is the old path, ℓ the task's length scale, and room = σ_r/‖∇σ_r‖, with the slope by central
differences. (Of a dip the joints at the end are the old ones; where the product keeps the posture, with a bump, they
stay within 10° of the old ones, as it does, and the room is all of the 0.2°.) Linear programs in turns with a trust
region, from tool motions in random directions that the joints can follow. Neither rates nor a shape of the window hold
it back: a new time law may keep the rates of any such path. The least over one place alone, next to the crossing, is
the `bound`, where the search for it succeeds: no path that passes nearby leaves less.

A tool that stays within 1e-4 is on its path, and counts as that. Where the optimiser finds no path, or one that is
worse than the product's by more than a tenth, the program is not judged. Programs without a remedy are counted, and it
is told whether the optimiser finds a path in the window; the rest of the program may still have none.

    python -m benchmarks.detours [--arms ur5e,pa10] [--programs 12] [--first 0] [--rows 600] [--seed 0] [--starts 4]
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import measure  # first: sets the number of threads
import mended
import numpy as np
from scipy.optimize import linprog
from scipy.sparse import bmat, csr_matrix, identity, kron, vstack
from scipy.spatial.transform import Rotation

from rankdrop.kinematics import jacobian, pose
from rankdrop.local.block import sample
from rankdrop.local.nearest import nearest_singularity
from rankdrop.local.rates import rate_limits
from rankdrop.path.check.check import check_path
from rankdrop.path.check.record import FREE, PathCheck
from rankdrop.path.check.tool_path import check_poses
from rankdrop.path.mend.mend import mend_path
from rankdrop.path.mend.record import LOCAL
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = ("irb120", "ur5e", "puma560", "kr6r900", "lrmate200id", "pa10", "iiwa7", "gen3", "panda")
KINDS = ("over", "through", "past", "dip")
TARGET = 1.2
CLEARANCE = np.radians(0.2)
NEARER = 0.9  # share of it that detours keep
ON_PATH = 1e-4
NOT_FOUND = 0.9  # tool / least below which the optimiser failed
TRIES = 120  # of a program with one crossing
SECONDS = 10.0  # processor time of a remedy
SPEED = 0.2  # of the quickest joint, as a share of its limit, at most 0.3 rad/s
SLOWEST = 0.05  # towards the singularity, where it is crossed [rad/s]
BOX = np.radians(10.0)  # of all joints around the old path, where the product keeps the posture of a dip [rad]
PLACES, HALF, STEP = 81, 1.2, 0.35  # of the optimiser; half its window [s]; joint motion between two places [rad]
WAYS, LEADS, RAMPS = 100, 0.3 * 1.5 ** np.arange(12), 2.0  # tool motions at first; their sizes in clearances
ROUNDS, TRUSTED = 60, 0.08
CORNERS = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)])
CORNERS = CORNERS / np.linalg.norm(CORNERS, axis=1)[:, None]


@dataclass(eq=False)
class Program:
    """A path across a singularity at the middle.

    Attributes:
        arm: that moves.
        kind: of `KINDS`.
        q, t: (T, n) joint values [rad] and (T,) times [s].
        poses: (T, 4, 4) wanted of the tip.
        length: ℓ [m].
    """

    arm: Robot
    kind: str
    q: Array
    t: Array
    poses: Array
    length: float

    def joints_at(self, t: Array) -> Array:
        """(N, n) the old joint path."""
        return np.stack([np.interp(t, self.t, column) for column in self.q.T], axis=1)

    def poses_at(self, t: Array) -> Array:
        """(N, 4, 4) the wanted tool path: of joint files that of the joints, of poses straight between them."""
        if self.kind in ("over", "dip"):
            return pose(self.arm, self.joints_at(t))
        row = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        share = ((t - self.t[row]) / (self.t[row + 1] - self.t[row]))[:, None]
        begin, end = self.poses[row], self.poses[row + 1]
        out = begin.copy()
        out[:, :3, 3] += share * (end[:, :3, 3] - begin[:, :3, 3])
        turn = Rotation.from_matrix(end[:, :3, :3] @ begin[:, :3, :3].swapaxes(1, 2)).as_rotvec()
        out[:, :3, :3] = Rotation.from_rotvec(share * turn).as_matrix() @ begin[:, :3, :3]
        return out


def program(name: str, kind: str, rows: int, rng: np.random.Generator) -> Program | None:
    """A path across the singularity next to a random configuration; None where that is of no use."""
    arm = open_robot(name)
    task = resolve_task(None, arm)
    near = nearest_singularity(arm, sample(arm, task, 1, int(rng.integers(2**31)))[0], task)
    crossing = np.asarray(near.q)
    t = mended.SECONDS_A_ROW * np.arange(rows)
    x = (t - t.mean())[:, None]
    most = np.minimum(SPEED * rate_limits(arm), 0.3)
    rates = most * rng.uniform(-1.0, 1.0, arm.n)
    length = float(task.scale(arm))
    _, slope = room_and_normal(arm, length, crossing[None] + 1e-3 * rng.normal(size=arm.n))
    if kind != "dip" and abs(slope[0] @ rates) < SLOWEST:
        return None
    if kind == "dip":
        rates -= slope[0] * (slope[0] @ rates)
        depth, half = np.radians(rng.uniform(0.3, 3.0)), rng.uniform(0.3, 0.8)
        q = crossing + rates * x + slope[0] * depth * (np.minimum((x / half) ** 2, 4 * np.abs(x / half) - 4) - 1.0)
    else:
        q = crossing + rates * x
    if (q < arm.lower + 0.02).any() or (q > arm.upper - 0.02).any():
        return None
    turned = np.zeros(rows)
    if kind == "past":
        turned = np.radians(10 ** rng.uniform(-2.0, np.log10(0.5))) * mended.smooth(2.0 - np.abs(x[:, 0]))
    return Program(arm, kind, q, t, mended.poses_of(arm, q, turned), length)


def check_of(made: Program) -> PathCheck:
    """The product's judgement of a program."""
    if made.kind in ("over", "dip"):
        return check_path(made.arm, made.q, made.t)
    return check_poses(made.arm, made.poses, made.t, start=made.q[0], branches=False)


def scaled_jacobian(arm: Robot, length: float, q: Array) -> Array:
    """(N, 6, n) of revolute joints, lengths divided by ℓ."""
    out = jacobian(arm, q).copy()
    out[:, :3] /= length
    return out


def room_and_normal(arm: Robot, length: float, q: Array) -> tuple[Array, Array]:
    """(N,) σ_r/‖∇σ_r‖ and (N, n) the unit slope, by central differences."""
    h, n = 1e-6, arm.n
    around = np.concatenate([q[:, None], q[:, None] + h * np.eye(n), q[:, None] - h * np.eye(n)], axis=1)
    sigma = np.linalg.svd(scaled_jacobian(arm, length, around.reshape(-1, n)), compute_uv=False)[:, 5]
    sigma = sigma.reshape(len(q), 2 * n + 1)
    slope = (sigma[:, 1 : n + 1] - sigma[:, n + 1 :]) / (2 * h)
    size = np.linalg.norm(slope, axis=1)
    return sigma[:, 0] / np.maximum(size, 1e-2), slope / np.maximum(size, 1e-12)[:, None]


def errors(arm: Robot, length: float, q: Array, wanted: Array) -> Array:
    """(N, 6) way by ℓ and turn from the wanted poses to the tool."""
    now = pose(arm, q)
    turn = Rotation.from_matrix(now[:, :3, :3] @ wanted[:, :3, :3].swapaxes(1, 2)).as_rotvec()
    return np.concatenate([(now[:, :3, 3] - wanted[:, :3, 3]) / length, turn], axis=1)


def sizes(error: Array) -> Array:
    """(N,) |v|/ℓ + |ω|."""
    return np.asarray(np.linalg.norm(error[:, :3], axis=1) + np.linalg.norm(error[:, 3:], axis=1))


def follow(arm: Robot, length: float, start: Array, wanted: Array) -> Array:
    """(N, M, n) joints from one start along M rows of poses (N, M, 4, 4), side by side by damped Newton steps; nan from
    where they jump, leave the limits, or do not arrive.
    """
    out = np.full((*wanted.shape[:2], arm.n), np.nan)
    out[0] = start
    alive = np.ones(wanted.shape[1], dtype=np.bool_)
    for k in range(1, len(wanted)):
        rows = np.flatnonzero(alive)
        before, target = out[k - 1, rows], wanted[k, rows]
        q = before.copy()
        for _ in range(15):
            error = errors(arm, length, q, target)
            if np.abs(error).max(initial=0.0) < 1e-8:
                break
            columns = scaled_jacobian(arm, length, q)
            gram = columns @ columns.swapaxes(1, 2) + 1e-10 * np.eye(6)
            move = -np.einsum("kxn,kx->kn", columns, np.linalg.solve(gram, error[:, :, None])[:, :, 0])
            q += move * np.minimum(1.0, 0.2 / np.maximum(np.abs(move).max(axis=1, keepdims=True), 1e-12))
        good = np.abs(errors(arm, length, q, target)).max(axis=1) < 1e-7
        good &= (np.abs(q - before).max(axis=1) < STEP) & (q >= arm.lower).all(axis=1) & (q <= arm.upper).all(axis=1)
        out[k, rows[good]] = q[good]
        alive[rows[~good]] = False
        if not alive.any():
            break
    return out


def crossed(arm: Robot, length: float, q: Array, room: Array, normal: Array) -> bool:
    """Whether joints (N, n) go to the other side of a singularity from place to place."""
    if arm.n == 6:
        sign = np.sign(np.linalg.det(scaled_jacobian(arm, length, q)))
        return bool((sign != sign[0]).any())
    near = np.minimum(room[1:], room[:-1]) < 0.1
    return bool((near & ((normal[1:] * normal[:-1]).sum(axis=1) < 0.0)).any())


@dataclass(eq=False)
class Optimiser:
    """Least deviation at places.

    Attributes:
        arm, length, wanted: the arm, ℓ, (N, 4, 4) poses.
        joined: places follow one another; else each is by itself.
        last: (n,) configuration at the end; None: only the tool is there.
        room: that is kept [rad].
        low, high: (N, n) between which the joints are.
    """

    arm: Robot
    length: float
    wanted: Array
    joined: bool
    last: Array | None
    room: float
    low: Array
    high: Array

    def merit(self, q: Array) -> tuple[float, float]:
        """Largest deviation, and the largest violation."""
        error = errors(self.arm, self.length, q, self.wanted)
        room, normal = room_and_normal(self.arm, self.length, q)
        short = float((self.room - room).max())
        if self.joined and crossed(self.arm, self.length, q, room, normal):
            short += 1.0
        apart = float((np.abs(np.diff(q, axis=0)) - STEP).max(initial=0.0)) if self.joined else 0.0
        end = float(sizes(error[-1:])[0]) if self.joined else 0.0
        return float(sizes(error).max()), max(short, apart, end, 0.0)

    def least(self, q: Array) -> tuple[float, Array]:
        """The least deviation found from joints (N, n) on, which may break constraints at first; inf: none kept."""
        trusted, best, best_q = TRUSTED, np.inf, q
        value, broken = self.merit(q)
        for _ in range(ROUNDS):
            step = self.program_step(q, trusted)
            if step is None:
                break
            new = self.corrected(q, step)
            new_value, new_broken = self.merit(new)
            if new_value + 20 * new_broken < value + 20 * broken - 1e-9:
                good = value + 20 * broken - new_value - 20 * new_broken
                q, value, broken, trusted = new, new_value, new_broken, min(1.5 * trusted, 0.3)
                if broken < 2e-3 * self.room and value < best:
                    best, best_q = value, q
                if good < 1e-4 * value and broken < 1e-3 * self.room:
                    break
            else:
                trusted /= 4
            if trusted < 1e-6:
                break
        return best, best_q

    def corrected(self, q: Array, step: Array) -> Array:
        """(N, n) joints after a step, brought by Newton steps to where the tool is to first order: joints that turn
        against one another beside a singularity have to, along a curve.
        """
        arm = self.arm
        meant = errors(arm, self.length, q, self.wanted)
        meant += np.einsum("kxn,kn->kx", scaled_jacobian(arm, self.length, q), step)
        new = q + step
        moving = np.ones(len(q), dtype=np.bool_)
        if self.joined:
            moving[0] = False
            moving[-1] = self.last is None
        for _ in range(4):
            columns = scaled_jacobian(arm, self.length, new)
            gram = columns @ columns.swapaxes(1, 2) + 1e-8 * np.eye(6)
            missing = errors(arm, self.length, new, self.wanted) - meant
            move = -np.einsum("kxn,kx->kn", columns, np.linalg.solve(gram, missing[:, :, None])[:, :, 0])
            far = np.abs(move).max(axis=1, keepdims=True)
            near = new + move * np.minimum(1.0, 0.1 / np.maximum(far, 1e-12)) * moving[:, None]
            new = np.clip(near, np.minimum(self.low, q), np.maximum(self.high, q))
        return new

    def program_step(self, q: Array, trusted: float) -> Array | None:
        """(N, n) joint motion that is best to first order."""
        (count, n), arm = q.shape, self.arm
        error, columns = errors(arm, self.length, q, self.wanted), scaled_jacobian(arm, self.length, q)
        room, normal = room_and_normal(arm, self.length, q)
        moves, extra = count * n, 2 * count + 2  # variables: motion; way and turn of each; s, slack
        rows, right = [], []
        for part in (0, 1):
            values, slopes = error[:, 3 * part : 3 * part + 3], columns[:, 3 * part : 3 * part + 3]
            heading = values / np.maximum(np.linalg.norm(values, axis=1), 1e-15)[:, None]
            ways = np.concatenate([np.broadcast_to(CORNERS, (count, *CORNERS.shape)), heading[:, None]], axis=1)
            over = len(CORNERS) + 1
            blocks = block_rows(np.einsum("kdx,kxn->kdn", ways, slopes))
            of_size = kron(identity(count), np.ones((over, 1)))
            nothing = csr_matrix((count * over, count))
            rest = csr_matrix((count * over, 2))
            parts = [of_size * -1, nothing] if part == 0 else [nothing, of_size * -1]
            rows.append(bmat([[blocks, *parts, rest]]))
            right.append(-np.einsum("kdx,kx->kd", ways, values).ravel())
        total = bmat([[csr_matrix((count, moves)), identity(count), identity(count),
                       csr_matrix(np.tile([-1.0, 0.0], (count, 1)))]])  # fmt: skip
        rows.append(total)
        right.append(np.zeros(count))
        near = np.flatnonzero(room < self.room + 2 * trusted * np.sqrt(n))
        keep = block_rows(-normal[:, None])[near]
        rows.append(bmat([[keep, csr_matrix((len(near), 2 * count)),
                           csr_matrix(np.tile([0.0, -1.0], (len(near), 1)))]]))  # fmt: skip
        right.append(room[near] - self.room)
        equal, equal_right = None, None
        if self.joined:
            chain = kron(csr_matrix(np.diff(np.eye(count), axis=0)), identity(n))
            gap, wide = np.diff(q, axis=0).ravel(), csr_matrix((moves - n, 2 * count + 1))
            slack = csr_matrix(-np.ones((moves - n, 1)))
            rows += [bmat([[chain, wide, slack]]), bmat([[-chain, wide, slack]])]
            right += [STEP - gap, STEP + gap]
            equal = csr_matrix((6, moves + extra)).tolil()
            equal[:, moves - n : moves] = columns[-1]
            equal_right = -error[-1]
        low, high = np.maximum(self.low - q, -trusted), np.minimum(self.high - q, trusted)
        low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
        if self.joined:
            low[0] = high[0] = 0.0
            if self.last is not None:
                low[-1] = high[-1] = 0.0
                equal = None
        bounds = np.concatenate([np.stack([low.ravel(), high.ravel()], axis=1), np.tile([0.0, np.inf], (extra, 1))])
        cost = np.zeros(moves + extra)
        cost[-2:] = 1.0, 20.0
        found = linprog(cost, vstack(rows).tocsr(), np.concatenate(right), equal, equal_right if equal is not None
                        else None, bounds=bounds, method="highs")  # fmt: skip
        return None if found.x is None else found.x[:moves].reshape(count, n)


def block_rows(blocks: Array) -> Any:
    """(N k, N n) with blocks (N, k, n) along the diagonal."""
    count, k, n = blocks.shape
    column = (n * np.arange(count))[:, None, None] + np.arange(n)[None, None]
    column = np.broadcast_to(column, (count, k, n))
    row = np.broadcast_to(np.arange(count * k).reshape(count, k, 1), (count, k, n))
    return csr_matrix((blocks.ravel(), (row.ravel(), column.ravel())), shape=(count * k, count * n))


def window_times(made: Program) -> Array:
    """(N,) times around the middle, close together there."""
    middle, fine = made.t.mean(), 12.0
    u = np.linspace(-1.0, 1.0, PLACES)
    return middle + HALF * np.sinh(np.arcsinh(fine * 8) * u) / (fine * 8)


def least_of_paths(made: Program, starts: int, room: float, box: float, rng: np.random.Generator) -> float:
    """The least largest deviation of a path in the window, no joint farther than `box` from the old one [rad], from the
    least of the tool motions in random directions that the joints can follow.
    """
    arm, length, t = made.arm, made.length, window_times(made)
    wanted, old = made.poses_at(t), made.joints_at(t)
    begin = follow(arm, length, old[0], np.stack([wanted[:1], wanted[:1]]))[-1, 0]
    dip = made.kind == "dip"
    low, high = np.maximum(arm.lower, old - box), np.minimum(arm.upper, old + box)
    optimiser = Optimiser(arm, length, wanted, True, old[-1] if dip else None, room, low, high)
    share = mended.smooth(RAMPS * (1.0 - np.abs(t - t.mean()) / HALF))
    least = np.inf
    if dip:
        _, normal = room_and_normal(arm, length, old[[0]])
        least = optimiser.least(old + share[:, None] * normal * 0.06)[0]
    twists = rng.normal(size=(WAYS, 6)) * np.repeat(10 ** rng.uniform(-2, 2, (WAYS, 2)), 3, axis=1)
    twists /= sizes(twists)[:, None]
    led = (twists[:, None] * (CLEARANCE * LEADS)[:, None]).reshape(-1, 6)
    poses = np.repeat(wanted[:, None], len(led), axis=1)
    moved = share[:, None, None] * led
    poses[:, :, :3, 3] += length * moved[:, :, :3]
    turn = Rotation.from_rotvec(moved[:, :, 3:].reshape(-1, 3)).as_matrix().reshape(len(t), len(led), 3, 3)
    poses[:, :, :3, :3] = turn @ poses[:, :, :3, :3]
    q = follow(arm, length, begin, poses)
    candidates = []
    for k in np.flatnonzero(np.isfinite(q[-1, :, 0])):
        if (dip and np.abs(q[-1, k] - old[-1]).max() > 0.5) or np.abs(q[:, k] - old).max() > box:
            continue
        free, normal = room_and_normal(arm, length, q[:, k])
        if not crossed(arm, length, q[:, k], free, normal):
            candidates.append((float(sizes(led[[k]])[0]) * max(1.0, room / float(free.min())), k // len(LEADS), k))
    tried: set[int] = set()
    for _, way, k in sorted(candidates):
        if way not in tried and len(tried) < starts:
            tried.add(way)
            joints = q[:, k].copy()
            if dip:
                joints[-1] = old[-1]
            least = min(least, optimiser.least(joints)[0])
    return least


def bound_of(made: Program, starts: int, room: float, rng: np.random.Generator) -> float:
    """The least deviation at one place next to the crossing: the largest over some of them."""
    out = 0.0
    middle = made.t.mean()
    for shift in (0.0, -0.002, 0.002):
        t = np.array([middle + shift])
        wanted, old = made.poses_at(t), made.joints_at(t)
        low, high = made.arm.lower[None], made.arm.upper[None]
        optimiser = Optimiser(made.arm, made.length, wanted, False, None, room, low, high)
        null = np.linalg.svd(scaled_jacobian(made.arm, made.length, old)[0])[2][5:]
        least = np.inf
        for _ in range(3 * starts):
            turned = rng.uniform(-2.0, 2.0, len(null)) @ null
            q = old + turned + rng.normal(size=made.arm.n) * 0.01
            least = min(least, optimiser.least(q)[0])
        out = max(out, least)
    return out


def is_crossing(made: Program, check: PathCheck) -> bool:
    """The joints cross one singularity, or of a dip one there and back, and the product says that the path meets it."""
    if check.clear:
        return False
    joints = check if check.poses is None else check_path(made.arm, made.q, made.t)
    met = [stretch for stretch in joints.stretches if stretch.verdict != FREE]
    ends = check.tool is not None and not check.tool.complete
    return len(met) == 1 + (made.kind == "dip") and (ends or any(s.verdict != FREE for s in check.stretches))


def one(name: str, kind: str, rows: int, starts: int, seed: tuple[int, ...]) -> measure.Row | None:
    """One program: made, mended, and held against the optimiser; None where it is no program with one crossing."""
    rng = np.random.default_rng(seed)
    made = program(name, kind, rows, rng)
    if made is None:
        return None
    begin = time.process_time()
    check = check_of(made)
    checked = time.process_time() - begin
    if not is_crossing(made, check):
        return None
    begin = time.process_time()
    mending = mend_path(check, kinds=LOCAL)
    if mending.best is None:
        mending = mend_path(check)
    remedy = mending.best
    spent = checked + time.process_time() - begin
    row: measure.Row = {
        "program": "-".join(str(part) for part in seed), "arm": name, "kind": kind, "remedy": "none", "tool": np.nan,
        "mm": np.nan, "deg": np.nan, "least": np.nan, "bound": np.nan, "tool / least": np.inf, "CPU s": spent,
        "its s": np.nan, "why not": "", "claimed": False,
    }  # fmt: skip
    if remedy is None:
        row["why not"] = "; ".join(mending.notes)
    kept = CLEARANCE * NEARER
    if remedy is not None:
        away, turned = remedy.deviation
        row |= {"remedy": remedy.kind, "mm": 1e3 * away, "deg": float(np.degrees(turned)),
                "tool": away / made.length + turned}  # fmt: skip
        kept = CLEARANCE if remedy.kind == "bump" else kept
    box = BOX if remedy is not None and remedy.kind == "bump" else np.inf
    begin = time.process_time()
    row["bound"] = bound_of(made, starts, kept, rng)
    if starts > 0 and not row["tool"] <= ON_PATH:
        row["least"] = least_of_paths(made, starts, kept, box, rng)
    row["its s"] = time.process_time() - begin
    if remedy is None:
        return row
    if row["tool"] <= ON_PATH:
        row["tool / least"] = 1.0
    elif np.isfinite(row["least"]):
        row["tool / least"] = row["tool"] / max(row["least"], ON_PATH)
    row["claimed"] = NOT_FOUND <= row["tool / least"] < np.inf
    return row


def main() -> None:
    """All programs asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arms", default=",".join(ARMS[:2] if measure.quick() else ARMS), help="with commas")
    parser.add_argument("--programs", type=int, default=2 if measure.quick() else 36, help="how many (36)")
    parser.add_argument("--first", type=int, default=0, help="number of the first one (0)")
    parser.add_argument("--rows", type=int, default=600, help="of each (600)")
    parser.add_argument("--seed", type=int, default=0, help="of all random choices (0)")
    parser.add_argument("--starts", type=int, default=1 if measure.quick() else 4, help="of the optimiser (4)")
    parser.add_argument("--kinds", default=",".join(KINDS), help="with commas")
    measure.options(parser)
    asked = parser.parse_args()
    arms, kinds, out = asked.arms.split(","), asked.kinds.split(","), list[measure.Row]()
    for place in range(asked.first, asked.first + asked.programs):
        name, kind = arms[place % len(arms)], kinds[(place + place // len(arms)) % len(kinds)]
        for tried in range(TRIES):
            row = one(name, kind, asked.rows, asked.starts, (asked.seed, place, tried))
            if row is not None:
                break
        else:
            print(f"{place}: no {kind} of {name} in {TRIES} tries", file=sys.stderr, flush=True)
            continue
        out.append(row)
        print(", ".join(f"{key} {measure.text(value)}" for key, value in row.items()), file=sys.stderr, flush=True)
    judged = [row for row in out if row["claimed"]]
    within = sum(row["tool / least"] <= TARGET for row in judged)
    lacking = sum(row["remedy"] == "none" for row in out)
    seconds = max(row["CPU s"] for row in out)
    measure.report(
        f"{len(out)} programs with one crossing: {lacking} without a remedy; of {len(judged)} that are judged {within} "
        f"within {TARGET} times the least deviation found; {seconds:.1f} s (CPU) at most",
        out, ratio="tool / least", target=TARGET, at_most=True, arguments=asked,
    )  # fmt: skip


if __name__ == "__main__":
    main()
