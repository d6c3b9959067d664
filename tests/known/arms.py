"""Which arms of the catalogue a test is of: laws over kinds of arms take some, only what is cheap takes all.

A test of every arm of the catalogue is a few milliseconds each, or it is `known/test_atlases.py`, made anew.
"""

from __future__ import annotations

import csv
from pathlib import Path

from rankdrop.robot.open import robot_names

with (Path(__file__).resolve().parents[1] / "data" / "catalogue.csv").open(encoding="utf-8", newline="") as _stream:
    FROM_FILES = frozenset(row["name"] for row in csv.DictReader(_stream))
DRAWN = tuple(name for name in robot_names() if name not in FROM_FILES)
"""From documents and data sheets: every form that is known, from two to eight joints, with slides."""
TRADE = ("ur20", "kr16", "hc10", "m1013", "fr3", "meca500", "tiago")
"""From makers' files, of each form one: offset wrist, spherical wrist, 7R, a slide."""
KINDS = (*DRAWN, *TRADE)
"""For a law over kinds of arms."""
FEW = ("planar3r", "scara", "stanford", "puma560", "ur5e", "iiwa14", "canadarm2", "fetch8")
"""For what costs seconds each: planar, a slide outside and inside a spherical wrist, offset wrist, 7R, 8 joints."""
