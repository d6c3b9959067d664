"""What may be asked of a path: how it is checked, which remedies are tried; and of aspects."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Annotated, Literal

from rankdrop.options import Options, option


@dataclass(frozen=True)
class PathOptions(Options):
    """How a path is checked. Distances are in joint space, slides divided by the length scale."""

    TITLE = "Check"

    interpolate: Annotated[
        Literal["linear", "cubic", "quintic"],
        option("What the controller makes of the samples: straight lines, cubics through the velocities, or quintics "
               "through the accelerations too"),
    ] = "linear"  # fmt: skip
    min_distance: Annotated[float, option("Distance to be kept from every singularity", unit="rad", ge=0)] = 0.0
    limits: Annotated[bool, option("Distances to singularities within the joint limits only")] = False
    evaluations: Annotated[
        int, option("Enclosures that one path may cost; about 10 microseconds each", ge=1)
    ] = 2_000_000  # fmt: skip
    frame: Annotated[
        Literal["base", "tool", "link"],
        option("Axes in which lost motions are reported: base, tool, or the link in which they are simplest"),
    ] = "base"  # fmt: skip
    tip_tolerance: Annotated[
        float, option("Distance within which the tip of a tool path is proven to stay to its Cartesian curve", unit="m",
                      ge=1e-8)
    ] = 1e-4  # fmt: skip
    turn_tolerance: Annotated[
        float, option("Angle within which the tool is proven to stay to its orientation", unit="rad", ge=1e-8, le=3)
    ] = 1e-4  # fmt: skip


@dataclass(frozen=True)
class RemedyOptions(Options):
    """How far a remedy may change a path."""

    TITLE = "Remedies"

    tool_tilt: Annotated[float, option("The tool may be tilted by up to this angle", unit="rad", ge=0, le=pi)] = 0.0
    base_shift: Annotated[float, option("The base may be moved by up to this length", unit="m", ge=0)] = 0.0
    blend: Annotated[
        float, option("Where a corner is cut the tool point may leave the path by up to this length", unit="m", ge=0)
    ] = 0.0  # fmt: skip


@dataclass(frozen=True)
class AspectsOptions(Options):
    """How changes of posture are searched."""

    TITLE = "Search"

    poses: Annotated[
        int, option("How many random poses, where no configuration is given", ge=1, le=100_000)
    ] = 10  # fmt: skip
    most: Annotated[
        int, option("And at most how many, while no path is found and nothing is proven", ge=1, le=100_000)
    ] = 100  # fmt: skip
    starts: Annotated[int, option("Of Newton's method for the inverse of each pose", ge=1, le=1_000_000)] = 600
    seed: Annotated[
        int, option("Of every random choice; the same seed gives the same result", ge=0, le=2**63 - 1)
    ] = 0  # fmt: skip
    limits: Annotated[bool, option("Solutions and paths within the joint limits only")] = False
