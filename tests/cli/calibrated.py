"""A calibrated arm, its tolerance and a configuration."""

from __future__ import annotations

from pathlib import Path

CALIBRATED = str(Path(__file__).parents[1] / "data" / "ur5_calibrated.toml")
TOLERANCE = "1mm,0.5deg"
Q = "0.1,-2,1.5,1,0.005,0"
