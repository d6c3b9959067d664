"""The arms of the catalogue as parameters of tests: those made from many makers' files are slow, but for a few."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import pytest

from rankdrop.robot.open import robot_names

with (Path(__file__).resolve().parents[1] / "data" / "catalogue.csv").open(encoding="utf-8", newline="") as _stream:
    FROM_FILES = frozenset(row["name"] for row in csv.DictReader(_stream))
FEW = frozenset({"ur20", "kr16", "hc10", "m1013", "fr3", "meca500", "tiago"})
"""Of each form one: offset wrist, spherical wrist, 7R, a slide."""


def some_arms() -> list[str]:
    """Names of the arms that are not from files, and `FEW`: for tests that know single families by name."""
    return [name for name in robot_names() if name not in FROM_FILES - FEW]


def every_arm() -> list[Any]:
    """All names, those from files marked slow but for `FEW`."""
    late = FROM_FILES - FEW
    return [pytest.param(name, marks=[pytest.mark.slow] if name in late else []) for name in robot_names()]
