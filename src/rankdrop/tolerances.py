"""Every threshold of the product, once, with its reason and unit."""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class Tolerances:
    """Thresholds, all on Jacobians whose translation rows are divided by the length scale (σ has no unit then).

    Attributes:
        singular: σ at or below this counts as zero [1]. Polished points reach 1e-13; the smallest nonzero local minimum
            met on a real arm is 4e-5 (Gen3's 12 mm offset), so nine decades separate the two.
        target: the search stops a start here [1]: rounding of a Jacobian of norm 3 leaves 1e-15.
        stationary: share of F inside the range of D below which a nonzero local minimum that is told of is known [1]; a
            search says that it met one from 1e-3 on, where its value is known to a millionth.
        block_rank: singular values of D at or below this are zero, an absolute cut [1/rad].
        tangent: entry of the projector on ker D below which a joint is pinned (above one minus it: free): the square
            of an angle of 1e-7; Gen3's 12 mm offset makes angles of 1e-5 that are not zero [1].
        value: two joint values closer than this are the same, and simple values (multiples of π/12) are taken [rad, m].
        fit_gap: a null space of the fit is believed when the largest singular value inside is below this share of the
            smallest one outside [1].
        coefficient: fitted coefficients below this share of the largest are zero, where the fit is as good without
            them [1].
        explained: a singular point satisfies a family when its residual is below this [rad]; a point where families
            meet is itself only known to the square root of `target`.
    """

    singular: float = 1e-9
    target: float = 1e-13
    stationary: float = 1e-5
    block_rank: float = 2e-6
    tangent: float = 1e-14
    value: float = 1e-6
    fit_gap: float = 1e-3
    coefficient: float = 1e-8
    explained: float = 1e-5

    def to_dict(self) -> dict[str, float]:
        """The thresholds as a plain dictionary, for a result file."""
        return asdict(self)


DEFAULT = Tolerances()

# Cuts that several modules share, and that no result file holds.

DEPENDENT = 1e-7
"""σ of unit columns at or below this: dependent [1]. Looser than `singular`: short columns are made longer."""
ALIGNED = DEFAULT.value
"""Angles [rad] and lengths per reach below this are zero: axes are parallel, meet, coincide."""
ENTRY = 1e-6
"""Entries of unit vectors below this do not count as entries [1]: a thousand times what `singular` leaves in them."""

TIE = 1e-2
"""Relative gap below which AM's method takes two singular values for equal; AM do not print theirs."""

# What decides whether a set of exact conditions is a family of the arm: real points of it, and what they are.

REAL_STARTS = 96
"""Random starts from which a real point of a set is looked for. A set that one start in ten reaches is missed with a
chance of 4e-5; of one that is missed it is said that no point was found, never that there is none."""
RANK_KEPT = 1e-6
"""σ above this is not lost [1]: a thousand times `singular`, so that no point counts whose rank may be lower still."""
RANK_HIGHER = 1e-4
"""σ above this where all conditions of a set hold: the rank is higher there, and the conditions say too little [1]. In
between nothing is said: near a crossing of sheets σ is small over a long way."""
SMOOTH = 5e-7
"""Singular values of the conditions' gradients above this: the set is smooth there, of the dimension claimed [1/rad].
At a double zero |f| ≤ 1e-15 leaves gradients of 1e-7."""
CONDITION_FAILS = 1e-6
"""|f| above this, largest coefficient 1: a condition does not hold at a configuration at which others do [1]."""
REAL_ROOT = 1e-9
"""A root of a polynomial in one tangent whose imaginary part is below this is real [1]: a double root that rounding
parts is found from one that it does not, at other values of the other joints."""
ROUNDED_LENGTHS = 1e-12
"""Share of the terms' sizes below which a polynomial in the lengths of an arm is zero: lengths have as many digits."""

# What a file of an arm leaves open.

SQUARE = 2e-5
"""Angles between axes that hold to this are exact [rad]: ten times what CAD exports and six digits leave, and finer
than any arm is built (1 µm at 50 mm)."""
MEETING = 2e-6
"""Axes that meet, and distances that are equal, to this do so exactly [m]: finer than any arm is measured."""
NOTHING = 1e-9
"""Lengths below this are nothing [m]: what rounded angles leave of a zero."""

# What an explanation of one configuration asks by default; its settings record them.

NEAR = 0.05
"""A configuration is near a singularity within this distance in joint space [rad]: 2.9°."""
SMALL = 1e-3
"""… or where σ_r is below this [1]: unit end-effector speed then needs joint rates of a thousand times the usual."""
SLOW = 0.025
"""… or where some straight translation of the tool is slower than this within the joints' rate limits [m/s] …"""
SLOW_TURN = 0.08726646259971647
"""… or some rotation about the tool point is: 5°/s [rad/s]."""
SPAN = 0.3490658503988659
"""Half the width, in each joint, of the region in which a speed is proven to be kept: 20° [rad]."""
EVALUATIONS = 5_000
"""Enclosures spent on the certified radius: some 8 ms."""
MOST_EVALUATIONS = 100_000_000
"""Enclosures that may be spent on it; more is a slip of the hand."""
MISSED = (5e-5, 5e-5)
"""By how much an arm of lower rank than the task has rows may miss a pose that is rounded [m, rad]: half of the
tolerances of a tool path. Poses of two digits of a millimetre and three of a degree are within it."""
