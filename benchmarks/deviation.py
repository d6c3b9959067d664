"""Programs mended by bumps: how much farther does the tool leave its path than it has to?

Programs are the files of joint values of `mended.py` whose dips all come back. `--fixed` keeps the arm in its posture,
and at least 0.2° away from the singularity. Around each crossing the largest deviation of the mended file is compared
with the least that any path could have there, found by an optimiser of its own at rows of the dip:

    min |p(q) − p_k|/ℓ + ∠(R(q), R_k)   over   s q_j ≥ 0.2°,   |q_i − q_ki| ≤ 0.3 rad for all other joints i,

where row k has the tool pose (p_k, R_k), ℓ is the arm's reach, q_j the joint whose zero is singular, and s the side on
which the program stands. (With joints farther off, the wrist turns half around: another posture, which is what
detours take.) Weighted least squares with bounds, weights renewed, from several starts; the least of all counts. A
tool that stays within 1e-4 is on its path, and counts as that.

    python benchmarks/deviation.py [--programs 20] [--first 0] [--rows 10000] [--quick] [--json]
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

import measure  # first: sets the number of threads
import mended
import numpy as np
from scipy.optimize import lsq_linear

from rankdrop.kinematics import jacobian, pose
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot

TARGET = 1.2
CLEARANCE = np.radians(0.2)
BOX = 0.3
"""How far the other joints may be from the row [rad]."""
ON_PATH = 1e-4
STARTS, ROUNDS, TRUSTED = 3, 60, 0.05
ROWS_OF_A_DIP = 5


def tool_error(arm: Robot, q: Array, wanted: Array) -> tuple[Array, Array]:
    """(3,) way [m] and (3,) turn [rad] from the wanted pose (4, 4) to the tool at q."""
    from scipy.spatial.transform import Rotation

    now = pose(arm, q[None])[0]
    turn = Rotation.from_matrix(now[:3, :3] @ wanted[:3, :3].T).as_rotvec()
    return now[:3, 3] - wanted[:3, 3], np.asarray(turn)


def size(way: Array, turn: Array, length: float) -> float:
    """|v|/ℓ + |ω|."""
    return float(np.linalg.norm(way) / length + np.linalg.norm(turn))


def least_deviation(arm: Robot, row: Array, joint: int, side: float, rng: np.random.Generator) -> float:
    """The least |v|/ℓ + |ω| at one row: min over the box, the joint at the clearance."""
    wanted, length = pose(arm, row[None])[0], reach(arm)
    others = np.delete(np.arange(arm.n), joint)
    least = np.inf
    for start in range(STARTS):
        q = row.copy()
        q[joint] = side * CLEARANCE
        if start:
            q[others] += rng.uniform(-BOX, BOX, len(others))
        smoothing = 1e-2
        for k in range(ROUNDS):
            way, turn = tool_error(arm, q, wanted)
            columns = jacobian(arm, q)[:, others]
            of_way = (way @ way / length**2 + smoothing**2) ** -0.25 / length
            of_turn = (turn @ turn + smoothing**2) ** -0.25
            weights = np.repeat([of_way, of_turn], 3)
            rows = np.vstack([weights[:, None] * columns, 1e-4 * np.eye(len(others))])
            right = -np.concatenate([weights * np.concatenate([way, turn]), np.zeros(len(others))])
            low = np.maximum(row[others] - BOX - q[others], -TRUSTED)
            high = np.minimum(row[others] + BOX - q[others], TRUSTED)
            q[others] += lsq_linear(rows, right, bounds=(low - 1e-9, high + 1e-9)).x
            least = min(least, size(*tool_error(arm, q, wanted), length))
            if k % 5 == 4:
                smoothing = max(0.4 * smoothing, 1e-7)
    return least


def deviations(arm: Robot, old: Array, new: Array) -> Array:
    """(N,) |v|/ℓ + |ω| between two files of joint values, row by row."""
    from scipy.spatial.transform import Rotation

    first, second, length = pose(arm, old), pose(arm, new), reach(arm)
    way = np.linalg.norm(second[:, :3, 3] - first[:, :3, 3], axis=1)
    turn = Rotation.from_matrix(second[:, :3, :3] @ first[:, :3, :3].swapaxes(1, 2)).magnitude()
    return np.asarray(way / length + turn)


def dips_of(program: int, rows: int, folder: Path) -> list[measure.Row]:
    """A row for each dip of one program; none where the last one stays on the other side, or no singularity is met."""
    name = list(mended.ARMS)[program % len(mended.ARMS)]
    crossings, stays = 1 + (program // 2) % 5, program % 3 == 2
    if stays:
        return []
    arm, joint = open_robot(name), mended.ARMS[name][0]
    rng = np.random.default_rng([37, program])
    q, t, _ = mended.joints(rng, name, rows, crossings, dips=True, stays=False, misses=np.zeros(5))
    file, fixed = folder / f"{program}.csv", folder / f"{program}-fixed.csv"
    data = folder / f"{program}.json"
    mended.write(file, [f"q{k + 1}" for k in range(arm.n)], t, q)
    mended.run("path", name, str(file), "--remedy", "bump", "--fixed", str(fixed), "--json", str(data))
    if json.loads(data.read_text(encoding="utf-8"))["verdict"] != "crossing":
        return []
    lacking: measure.Row = {"program": program, "arm": name, "crossings": crossings, "dip deg": np.nan,
                            "tool": np.nan, "least": np.nan, "tool / least": np.inf}  # fmt: skip
    if not fixed.exists():
        return [lacking]
    new = np.loadtxt(fixed, delimiter=",", skiprows=1)[:, 1 : 1 + arm.n]
    off = deviations(arm, q, new)
    side = float(np.sign(q[0, joint]))
    too_near = np.flatnonzero(side * q[:, joint] < CLEARANCE)
    out = []
    for dip in np.split(too_near, np.flatnonzero(np.diff(too_near) > 1) + 1):
        before, after = max(dip[0] - rows // 20, 0), dip[-1] + rows // 20
        tool = float(off[before:after].max())
        looked_at = dip[np.linspace(0, len(dip) - 1, ROWS_OF_A_DIP).astype(int)]
        least = max(least_deviation(arm, q[k], joint, side, rng) for k in looked_at)
        out.append(lacking | {
            "dip deg": float(np.degrees(-side * q[dip, joint]).max()), "tool": tool, "least": least,
            "tool / least": max(tool, ON_PATH) / max(least, ON_PATH),
        })  # fmt: skip
    return out


def main() -> None:
    """All programs asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=int, default=2 if measure.quick() else 20, help="how many (20)")
    parser.add_argument("--first", type=int, default=0, help="number of the first program (0)")
    parser.add_argument("--rows", type=int, default=10_000, help="of each file (10,000)")
    measure.options(parser)
    asked = parser.parse_args()
    out: list[measure.Row] = []
    with tempfile.TemporaryDirectory() as folder:
        for program in range(asked.first, asked.first + asked.programs):
            out += dips_of(program, asked.rows, Path(folder))
            print(f"{program}: {len(out)} dips so far", file=sys.stderr, flush=True)
    if not out:
        parser.error("none of these programs has a dip that comes back")
    measure.report(
        f"{len(out)} dips of {asked.programs} programs: the tool leaves its path by at most {TARGET} times the least",
        out, ratio="tool / least", target=TARGET, at_most=True, arguments=asked,
    )  # fmt: skip


if __name__ == "__main__":
    main()
