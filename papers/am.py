"""AM: Almarkhi and Maciejewski, Singularity Analysis for Redundant Manipulators of Arbitrary Kinematic Structure."""

from __future__ import annotations

from papers import am_descent, am_method, am_robots

SECTIONS = am_method.SECTIONS + am_descent.SECTIONS + am_robots.SECTIONS
