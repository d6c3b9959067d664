"""Every question that a verb is asked, as a record: the verb and the command line take the same one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi, radians
from typing import Annotated, Literal

from rankdrop.options import Options, option
from rankdrop.tolerances import EVALUATIONS, MOST_EVALUATIONS, NEAR, SLOW, SLOW_TURN, SMALL, SPAN, TIE

_SEED = option("Seed of every random choice; the same seed gives the same result", ge=0, le=2**63 - 1)
_STARTS = option("Random starts for each corank", ge=1, le=10_000_000)
_THREADS = option("Processors to use; 0 means all. The result does not depend on it", ge=0, le=1024)
_LIMITS = option("Within the joint limits only; otherwise in the whole joint space")


@dataclass(frozen=True)
class ExplainOptions(Options):
    """What `explain` is asked."""

    near: Annotated[float, option("Near a singularity: within this distance in joint space", unit="rad", ge=0)] = NEAR
    small: Annotated[float, option("Near a singularity as well: σ_r at or below this", ge=0)] = SMALL
    speed: Annotated[
        float, option("Near as well: some straight motion of the tool is slower, a joint at its rate limit; 0: none",
                      unit="m/s", ge=0)
    ] = SLOW  # fmt: skip
    turn_speed: Annotated[float, option("The same of rotations about the tool point", unit="rad/s", ge=0)] = SLOW_TURN
    limits: Annotated[bool, option("The nearest singularity within the joint limits")] = False
    evaluations: Annotated[
        int, option("Budget of the certified radius, about 2 µs each; 0 for a quick one", ge=0, le=MOST_EVALUATIONS)
    ] = EVALUATIONS
    step: Annotated[
        float, option("Length of the motions out that are tried; slides in length scales", unit="rad", ge=1e-3, le=1)
    ] = 0.1
    coranks: Annotated[int, option("Distances to families up to this corank", ge=0)] = 1
    seed: Annotated[int, option("Seed of every random choice", ge=0, le=2**63 - 1)] = 0
    frame: Annotated[
        Literal["base", "tool", "link"] | None,
        option("Axes in which motions are reported; link: where they are simplest"),
    ] = None


@dataclass(frozen=True)
class AnalyzeOptions(Options):
    """What `analyze` is asked."""

    limits: Annotated[bool, _LIMITS] = False
    within: (
        Annotated[
            float,
            option("Report the share of the joint space within this distance of each family: 5deg", unit="rad", ge=0),
        ]
        | None
    ) = None
    speed: (
        Annotated[
            float,
            option("Report how far from each family every straight motion of the tool keeps this speed: 250mm/s",
                   unit="m/s", gt=0),
        ]
        | None
    ) = None  # fmt: skip
    around: Annotated[
        str | Sequence[float] | None,
        option("With the speed: posture around which that is proven, as for explain --q, in rad; else a usual one"),
    ] = None
    span: Annotated[
        float, option("With the speed: the region reaches so far from the posture in each joint: 20deg", unit="rad",
                      gt=0, le=3.2)
    ] = SPAN  # fmt: skip
    exact: Annotated[
        Literal["auto", "on", "off"], option("Derive the conditions exactly: auto within 30 s, on within 120 s")
    ] = "auto"
    aspects: Annotated[
        bool, option("Count the aspects and search for changes of posture, about 30 s at most; stored for known arms")
    ] = False  # fmt: skip
    fresh: Annotated[bool, option("Derive exact conditions anew where they are shipped (the catalogue's arms)")] = False
    starts: (
        Annotated[
            int,
            option("Random starts for each corank: 10000, or 2000 that test derived conditions", ge=1, le=10_000_000),
        ]
        | None
    ) = None
    seed: Annotated[int, _SEED] = 0
    threads: Annotated[int, _THREADS] = 0


@dataclass(frozen=True)
class SearchOptions(Options):
    """What `search` and `refine` are asked."""

    method: Annotated[
        Literal["lm", "gradient", "almarkhi", "reciprocal"],
        option("Levenberg-Marquardt; steepest descent; Almarkhi and Maciejewski's method; or reciprocal wrenches, for "
               "exact singular configurations of this corank or more"),
    ] = "lm"  # fmt: skip
    limits: Annotated[bool, _LIMITS] = False
    starts: Annotated[int, option("Random starts", ge=1, le=10_000_000)] = 10_000
    seed: Annotated[int, _SEED] = 0
    tie: Annotated[
        float, option("With almarkhi: relative gap below which singular values are equal; 0: none are", ge=0, le=1)
    ] = TIE
    iterations: (
        Annotated[
            int, option("Most iterations of a start; else 200, with gradient and almarkhi 3000", ge=1, le=1_000_000)
        ]
        | None
    ) = None
    step: (
        Annotated[
            float, option("With gradient and almarkhi: share of the step to the zero of a linear σ; 0: the "
                          "length that brings σ lowest, which gets stuck more often; else 0.5", ge=0, le=2)
        ]
        | None
    ) = None  # fmt: skip
    threads: Annotated[int, _THREADS] = 0


@dataclass(frozen=True)
class TolerantOptions(Options):
    """What `most_tolerant` is asked."""

    relative: Annotated[
        bool, option("Measure the remaining σ_r by σ1 of the whole arm: its bound depends on no configuration")
    ] = False
    limits: Annotated[bool, _LIMITS] = False
    starts: Annotated[int, option("Random starts", ge=1, le=10_000_000)] = 300
    seed: Annotated[int, _SEED] = 0
    show: Annotated[int, option("Local maxima to show", ge=1, le=1000)] = 5
    self_motion: Annotated[
        bool, option("Follow the self-motions of one tool pose: where a locked joint still lets the tool reach it")
    ] = False  # fmt: skip
    q: Annotated[
        str | Sequence[float] | None,
        option("With --self-motion: configuration at that pose, as for explain --q, in rad; else the best one found"),
    ] = None


@dataclass(frozen=True)
class ConditionsOptions(Options):
    """What `conditions` is asked; the result depends on the time limit only where it was met."""

    method: Annotated[
        Literal[
            "auto", "decoupling", "suppression", "tree", "determinant", "cofactors", "decomposition", "reciprocity",
            "singular-vector", "elementary",
        ],
        option("How corank 1 is derived (reciprocity: every corank up to --coranks); all methods give the same set, "
               "and auto says which it took and why"),
    ] = "auto"  # fmt: skip
    lengths: Annotated[
        str | Mapping[str, float],
        option('Lengths in conditions: auto, letters, numbers, or letters with their values: "a=0.635,d=120mm"'),
    ] = "auto"
    coranks: Annotated[int, option("The highest corank to derive; else all", ge=1)] | None = None
    seconds: Annotated[
        float, option("Limit on the work, as counted seconds: finished families are shown, and unfinished sets",
                      unit="s", gt=0, name="--time-limit")
    ] = 60.0  # fmt: skip
    seed: Annotated[int, _SEED] = 0
    points: Annotated[
        int, option("Singular configurations found numerically that the families have to explain; 0 for none",
                    ge=0, le=100_000)
    ] = 1000  # fmt: skip
    special: Annotated[bool, option("Derive the arms of special lengths as well: which families they have besides")] = (
        False
    )
    steps: Annotated[
        bool, option("Derive corank 1 step by step, as by hand, and the determinant of the Jacobian, or its minors, in "
                     "factors, for files as well")
    ] = False  # fmt: skip
    basic: (
        Annotated[
            str | tuple[int, ...],
            option("With the methods suppression and reciprocity: the six basic screws, 2-7 or 1,2,4-7; else chosen"),
        ]
        | None
    ) = None
    frame: (
        Annotated[
            int, option("With these methods: link that gives the frame of the screws; else where they are shortest")
        ]
        | None
    ) = None
    fresh: Annotated[bool, option("Derive anew the shipped results of the catalogue's arms")] = False


@dataclass(frozen=True)
class CoverOptions(Options):
    """What `cover` is asked."""

    width: Annotated[
        float, option("Width of the boxes, at most; slides divided by the length scale; 3deg is understood", unit="rad")
    ] = 0.05
    corank: Annotated[
        int, option("The boxes hold every configuration of this corank or more; above 1 by enclosures for every arm")
    ] = 1
    limits: Annotated[bool, _LIMITS] = False
    explain: Annotated[bool, option("Match the boxes to families")] = True
    budget: Annotated[
        int, option("Enclosures, about 1.5 µs each, after which no further part is begun; arms of six turning joints "
                    "need none for corank 1", ge=1)
    ] = 100_000_000  # fmt: skip
    threads: Annotated[int, _THREADS] = 0


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
    bump: Annotated[
        float, option("Around each singularity a joint may be moved by up to this angle (slides by the length scale); "
                      "0: not at all", unit="rad", ge=0, le=pi)
    ] = radians(10.0)  # fmt: skip
    detour: Annotated[
        float, option("Around a singularity that the joints cannot but cross the tool may leave its path by up to this "
                      "angle, or by as much of the length scale; 0: not at all", unit="rad", ge=0, le=pi)
    ] = radians(2.0)  # fmt: skip


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
    limits: Annotated[
        bool, option("Solutions and paths within the joint limits only; count the regions there as well")
    ] = False  # fmt: skip


@dataclass(frozen=True)
class InverseOptions(Options):
    """How the solutions of a pose are searched."""

    starts: Annotated[
        int, option("Random starts of Newton's method; more while they find new solutions", ge=1, le=1_000_000)
    ] = 2_000  # fmt: skip
    seed: Annotated[
        int, option("Seed of every random choice; the same seed gives the same result", ge=0, le=2**63 - 1)
    ] = 0  # fmt: skip
