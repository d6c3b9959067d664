"""Programs with 1 to 5 crossings, as files of joint values and of tool poses: how many does the command mend?

Each program goes a long way round in all joints. At each of 1 to 5 times the joint whose zero is singular does one of
two things. Of files of joint values: it dips across zero by 0.3° to 3°, for 0.2 s to 1 s, and comes back; in every
third file the last one stays on the other side. Of files of tool poses: it goes to the other side, and the tool is
turned by a small angle (0° to 0.5°; every third program exactly 0°) about a fixed axis while it does, so that the
poses pass by the singularity, or lead through it.

Each file is given to `rankdrop path ARM FILE --fixed OUT` in a process of its own: processor seconds and
memory are of the whole command. A program counts as mended where the written file is proven free by a second, plain
run of `rankdrop path`, of poses from the same start. How far the tool leaves its path is what the command tells.

    python benchmarks/mended.py [--programs 100] [--first 0] [--step 1] [--rows 50000] [--quick] [--json]
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import measure  # first: sets the number of threads
import numpy as np

from rankdrop.kinematics import pose
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

ARMS = {
    "irb120": (4, (0, -10, 10, 80, 50, 0)),
    "ur5e": (4, (0, -80, 80, -60, 50, 0)),
    "puma560": (4, (0, 20, 20, 120, 50, 0)),
    "kr6r900": (4, (0, -80, 90, 20, 50, 0)),
    "lrmate200id": (4, (0, 20, 10, 20, 50, 0)),
    "ur10e": (4, (0, -70, 80, -70, 50, 0)),
    "iiwa7": (3, (0, 30, 20, 60, 20, 40, 0)),
    "pa10": (3, (0, 30, 20, 60, 20, 40, 0)),
    "gen3": (3, (0, 30, 20, 60, 20, 40, 0)),
    "iiwa14": (3, (0, 30, 20, 60, 20, 40, 0)),
}
"""Joint whose zero is singular, counted from 0, and the middle of the program [°]."""
SECONDS_A_ROW = 0.01
KINDS = ("joints", "poses")
TARGET = 10.0
"""Processor seconds of a whole command."""


def smooth(x: Array) -> Array:
    """From 0 to 1, C²."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10 - 15 * x + 6 * x * x))


def joints(rng: np.random.Generator, arm: str, rows: int, crossings: int, *, dips: bool, stays: bool,
           misses: Array) -> tuple[Array, Array, Array]:  # fmt: skip
    """(rows, n) joint values [rad], times [s], and (rows,) how far the tool is turned [rad]."""
    joint, middle = ARMS[arm]
    last = SECONDS_A_ROW * rows
    t = np.linspace(0.0, last, rows)
    q = np.array(middle, dtype=float)[None] + sum(
        rng.uniform(-6, 6, len(middle)) * np.sin(2 * np.pi * k * t[:, None] / last + rng.uniform(0, 6, len(middle)))
        for k in range(1, 4)
    )
    turned = np.zeros(rows)
    for k in range(crossings):
        at = last * (k + 0.5) / crossings
        depth, half = rng.uniform(0.3, 3.0), rng.uniform(0.1, 0.5)
        down = smooth((t - (at - half - 2.0)) / 2.0)
        if not dips or (stays and k == crossings - 1):
            q[:, joint] *= 1 - 2 * down
            near = smooth((t - (at - half - 4.0)) / 2.0) * smooth((at + half + 4.0 - t) / 2.0)
            turned += np.radians(misses[k]) * near
            continue
        dip = down * smooth(((at + half + 2.0) - t) / 2.0)
        q[:, joint] = q[:, joint] * (1 - dip) - depth * dip
    return np.radians(q), t, turned


def poses_of(arm: Any, q: Array, turned: Array) -> Array:
    """(rows, 4, 4) of the tip, turned about an axis across the tool."""
    out = pose(arm, q)
    middle = out[len(out) // 2, :3, :3]
    axis = middle @ np.array([1.0, 2.0, 0.5]) / np.sqrt(5.25)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    s, c = np.sin(turned)[:, None, None], (1 - np.cos(turned))[:, None, None]
    out[:, :3, :3] = (np.eye(3) + s * cross + c * (cross @ cross)) @ out[:, :3, :3]
    return out


def quaternions(turn: Array) -> Array:
    """(rows, 4) x, y, z, w of rotations, without jumps of sign."""
    from scipy.spatial.transform import Rotation

    found = Rotation.from_matrix(turn).as_quat()
    flips = np.concatenate([[1.0], np.cumprod(np.sign((found[1:] * found[:-1]).sum(axis=1)))])
    return np.asarray(found * flips[:, None])


def write(file: Path, head: list[str], t: Array, rows: Array) -> None:
    """A table with seventeen digits."""
    np.savetxt(file, np.column_stack([t, rows]), fmt="%.17g", delimiter=",", header=",".join(["time", *head]),
               comments="")  # fmt: skip


def run(*arguments: str) -> tuple[int, float, float, str]:
    """Exit code, processor seconds, megabytes and stderr of one command."""
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen([sys.executable, "-m", "rankdrop", *arguments], stdout=subprocess.DEVNULL,
                                   stderr=said)  # fmt: skip
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        words = said.read().decode(errors="replace")
    return process.returncode, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / 1e6, words


def one(number: int, rows: int, folder: Path) -> measure.Row:
    """One program: made, mended by the command, and judged."""
    rng = np.random.default_rng([37, number])
    name = list(ARMS)[number % len(ARMS)]
    kind, crossings = KINDS[(number // len(ARMS) + number) % 2], 1 + (number // 2) % 5
    arm = open_robot(name)
    stays = number % 3 == 2
    exact = number % 3 == 0
    misses = np.zeros(5) if exact or kind == "joints" else 10 ** rng.uniform(-2.0, np.log10(0.5), 5)
    q, t, turned = joints(rng, name, rows, crossings, dips=kind == "joints", stays=stays, misses=misses)
    wanted = poses_of(arm, q, turned)
    file, fixed, data = folder / f"{number}.csv", folder / f"{number}-fixed.csv", folder / f"{number}.json"
    if kind == "joints":
        write(file, [f"q{k + 1}" for k in range(arm.n)], t, q)
        near: list[str] = []
    else:
        write(file, ["x", "y", "z", "qx", "qy", "qz", "qw"], t,
              np.column_stack([wanted[:, :3, 3], quaternions(wanted[:, :3, :3])]))  # fmt: skip
        near = ["--start=" + ",".join(f"{x:.9g}" for x in q[0])]
    code, seconds, megabytes, said = run("path", name, str(file), "--fixed", str(fixed), "--json",
                                         str(data), *near)  # fmt: skip
    row: measure.Row = {"program": number, "arm": name, "file": kind, "crossings": crossings,
                        "miss deg": float(misses[:crossings].min()), "CPU s": seconds, "MB": megabytes,
                        "verdict": "failed", "remedy": "none", "mended": 0.0, "tool mm": np.nan, "tool deg": np.nan,
                        "why not": ""}  # fmt: skip
    if code not in (0, 3) or not data.exists():
        row["why not"] = (said.strip().splitlines() or [f"exit code {code}"])[-1]
    else:
        told = json.loads(data.read_text(encoding="utf-8"))
        row["verdict"] = told["verdict"]
        mending = told.get("remedies") or {"found": [], "notes": []}
        row["why not"] = "; ".join(mending["notes"])
        if told["verdict"] == "free":
            row["mended"], row["remedy"] = 1.0, "not needed"
        elif fixed.exists():
            best = mending["found"][0]
            row["remedy"] = best["kind"]
            with fixed.open(encoding="utf-8") as written:
                as_joints = "joint_1" in written.readline()  # what is not free as poses is written as joint values
            again, *_ = run("path", name, str(fixed), "--quiet", *([] if as_joints else near))
            row["mended"] = float(again == 0 and best["verdict"] == "free")
            off = best["tool_off"]
            row["tool mm"], row["tool deg"] = 1e3 * off["m"], float(np.degrees(off["rad"] or 0.0))
    row["share of the target"] = seconds / TARGET
    return row


def main() -> None:
    """All programs asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=int, default=4 if measure.quick() else 100, help="how many (100)")
    parser.add_argument("--first", type=int, default=0, help="number of the first program (0)")
    parser.add_argument("--step", type=int, default=1, help="every how many-th of the programs (1)")
    parser.add_argument("--rows", type=int, default=3_000 if measure.quick() else 50_000, help="of each file (50,000)")
    measure.options(parser)
    asked = parser.parse_args()
    out = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(asked.first, asked.first + asked.programs * asked.step, asked.step):
            out.append(one(number, asked.rows, Path(folder)))
            print(f"{number}: " + ", ".join(f"{key} {measure.text(value)}" for key, value in out[-1].items()),
                  file=sys.stderr, flush=True)  # fmt: skip
    share = 100.0 * float(np.mean([row["mended"] for row in out]))
    most = max(row["MB"] for row in out)
    measure.report(
        f"{len(out)} programs of {asked.rows:,} rows with 1 to 5 crossings: {share:.0f} % mended, {most:.0f} MB at "
        "most; under 10 s (CPU) each",
        out, ratio="share of the target", target=1.0, at_most=True, arguments=asked,
    )  # fmt: skip


if __name__ == "__main__":
    main()
