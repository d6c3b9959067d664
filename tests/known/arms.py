"""Which arms of the catalogue a test is of: laws over kinds of arms take some, only what is cheap takes all.

A test of every arm of the catalogue is a few milliseconds each, or it is `known/test_every_arm.py`, a second each. What
costs more takes one arm of each structure: many makers build the same structure with other lengths.
"""

from __future__ import annotations

import csv
from pathlib import Path

from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped
from rankdrop.robot.open import robot_names

with (Path(__file__).resolve().parents[1] / "data" / "catalogue.csv").open(encoding="utf-8", newline="") as _stream:
    FROM_FILES = frozenset(row["name"] for row in csv.DictReader(_stream))
DRAWN = tuple(name for name in robot_names() if name not in FROM_FILES)
"""From documents and data sheets: every form that is known, from two to eight joints, with slides."""
TRADE = ("kr16", "hc10", "m1013", "fr3", "tiago")
"""From makers' files, of each form one: offset wrist, spherical wrist, 7R, a slide."""
AGAIN = ("ur3", "ur3e", "ur10", "ur10e", "vx300s")
"""Of those drawn, arms whose structure another one has: the UR5e, and the anthropomorphic arm."""
KINDS = tuple(name for name in (*DRAWN, *TRADE) if name not in AGAIN)
"""For a law over kinds of arms."""
FEW = ("planar3r", "scara", "stanford", "puma560", "ur5e", "iiwa14", "canadarm2", "fetch8")
"""For what costs seconds each: planar, a slide outside and inside a spherical wrist, offset wrist, 7R, 8 joints."""


STRUCTURES = (
    "almarkhi4", "anthropomorphic", "baxter", "canadarm2", "cobotta", "crx10ia", "e0509", "fetch", "fetch8", "fr3",
    "gen3", "gen3_6dof", "gen3_lite", "gp7", "hc10", "iiwa14", "iiwa7", "irb120", "irb140", "irb6640", "j2n6s300",
    "j2s7s300", "m1013", "m430ia2f", "mycobot_pro600", "open_manipulator", "planar2r", "planar3r", "puma560", "rcrrrr",
    "reachy2",
    "rizon10", "rs030n", "sawyer", "scara", "sia5d", "so101", "stanford", "tiago", "tx2_90l", "ur5e", "xarm5", "xarm6",
    "xarm7", "yam", "yumi", "z1",
)  # fmt: skip
"""One arm of each structure of the catalogue (`structures`): for what is made anew."""


def structures() -> tuple[str, ...]:
    """One arm of each structure, told from the shipped analyses.

    As many joints of the same kinds, the same task, and rows that pin the same joints and have the same coranks and
    dimensions: such arms differ in their lengths.
    """
    found: dict[tuple[object, ...], str] = {}
    for name in sorted(robot_names(), key=lambda name: (name not in FEW, name not in KINDS, name)):
        found.setdefault(_structure(shipped(name)), name)
    return tuple(sorted(found.values()))


def _structure(found: Analysis) -> tuple[object, ...]:
    kinds = tuple(str(joint.kind) for joint in found.robot.variables)
    rows = sorted((one.corank, one.dimension, tuple(pin.number for pin in one.pinned)) for one in found.families)
    return kinds, found.task.rows, *rows
