"""Aspects: the signs of the determinant's factors as flags of a configuration, and what parts two configurations.

An arm without redundancy is singular where one of the factors of det J is zero. A factor with a sign on the torus
cannot change it along a path without passing zero: configurations with opposite signs are parted by that family. The
converse is no theorem: with all signs equal there may be several aspects (connected sets of regular configurations).

Zeros of a factor along a segment are found by samples: sign changes halved down, and minima of its size that reach
zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from math import ceil, tau
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.signs import SignedFactor, look, signed_factors
from rankdrop.kinematics import one_configuration
from rankdrop.robot.model import Array
from rankdrop.tolerances import DEFAULT
from rankdrop.units import into_units

SAMPLES = 128
"""Points per turn at which a function is looked at along a segment."""
_HALVINGS = 60  # of an interval: to the last digit
Function = Callable[[Array], Array]  # shares of the way (N,) -> values (N,)


def zeros_between(value: Function, turns: float, tolerance: float) -> list[tuple[float, str]]:
    """Where a continuous function of the share 0 … 1 of a way is zero, and how it gets there.

    Args:
        value: of an array of shares.
        turns: how many turns all joints together make on the way; decides how many samples are taken.
        tolerance: values up to it are zero.

    Returns:
        (share, kind) each; kind is "crosses" (the sign changes), "touches", "starts on", "ends on", or "lies in" where
        every sample is zero. Two zeros between the same two samples are missed.

    Example:
        >>> zeros_between(lambda share: (share - 0.25) * (share - 0.75) ** 2, 1.0, 1e-9)
        [(0.25, 'crosses'), (0.75, 'touches')]
    """
    share = np.linspace(0.0, 1.0, SAMPLES * ceil(1 + turns) + 1)
    sample = value(share)
    if np.abs(sample).max() <= tolerance:
        return [(0.0, "lies in")]
    found = [(float(share[i]), _kind(sample, int(i))) for i in np.flatnonzero(np.abs(sample) <= tolerance)]
    for i in np.flatnonzero(sample[:-1] * sample[1:] < 0):
        if min(abs(sample[i]), abs(sample[i + 1])) > tolerance:
            found.append((_halved(value, float(share[i]), float(share[i + 1])), "crosses"))
    for k in _hollows(sample):
        lowest = _lowest(value, float(share[k - 1]), float(share[k + 1]))
        if abs(sample[k]) > tolerance >= abs(value(np.array([lowest]))[0]):
            found.append((lowest, "touches"))
    return sorted(found)


def _hollows(sample: Array) -> list[int]:
    """Samples of least size, of one sign with their neighbours, where the curve bends enough to reach zero between."""
    size = np.abs(sample)
    inner = size[1:-1]
    least = (inner <= size[:-2]) & (inner <= size[2:]) & (sample[:-2] * sample[2:] > 0)
    bend = np.abs(sample[:-2] - 2 * sample[1:-1] + sample[2:])  # f″h², and f ≤ f″h²/2 within h of a double zero
    return [int(k) + 1 for k in np.flatnonzero(least & (inner <= bend))]


def _kind(sample: Array, i: int) -> str:
    """What happens at a sample that is zero."""
    if i in (0, len(sample) - 1):
        return "starts on" if i == 0 else "ends on"
    return "crosses" if sample[i - 1] * sample[i + 1] < 0 else "touches"


def _halved(value: Function, low: float, high: float) -> float:
    """The zero between two points of opposite sign."""
    sign = value(np.array([low]))[0]
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if value(np.array([middle]))[0] * sign > 0:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def _lowest(value: Function, low: float, high: float) -> float:
    """Where the size is smallest between two points, by thirds."""
    for _ in range(_HALVINGS):
        left, right = low + (high - low) / 3, high - (high - low) / 3
        sizes = np.abs(value(np.array([left, right])))
        low, high = (low, right) if sizes[0] < sizes[1] else (left, high)
    return (low + high) / 2


_LONG = 16  # characters of a factor that is not put into a label
_ENDS = ("starts on", "ends on", "lies in")


@dataclass(frozen=True, slots=True)
class Flag:
    """The sign of one factor at a configuration.

    Attributes:
        factor: the function, in s_j = sin θ_j and c_j = cos θ_j.
        name: of the family where it is zero, as `analyze` names it; "" where no real configurations are on it.
        sign: +1, −1, or 0 on the family; None where the factor has no sign on the torus.
        value: of the factor, scaled: |value| ≤ 1 without slides.
    """

    factor: str
    name: str
    sign: int | None
    value: float

    @property
    def label(self) -> str:
        """ "elbow +"; where the family is not named after a part, the factor, or the whole name if that is long."""
        mark = {None: "has no sign", 1: "+", -1: "−", 0: "0"}[self.sign]
        head, colon, _ = self.name.partition(":")
        long = len(self.factor) > _LONG and self.name
        return f"{head if colon else self.name if long else self.factor} {mark}"


@dataclass(frozen=True, slots=True)
class Flags:
    """All flags of one configuration.

    Attributes:
        q: the configuration [rad, m].
        flags: one per factor.
        tolerance: values up to it count as zero.
    """

    q: tuple[float, ...]
    flags: tuple[Flag, ...]
    tolerance: float

    def sentences(self) -> tuple[str, ...]:
        """One per flag."""
        return tuple(_flag_words(flag) for flag in self.flags)

    def to_dict(self) -> dict[str, Any]:
        """For a result file."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class Crossing:
    """Where the straight segment meets a family.

    Attributes:
        at: share of the way, 0 … 1.
        factor, name: of the family.
        kind: "crosses" (the factor changes its sign), "touches", "starts on", "ends on", "lies in" (all of it).
    """

    at: float
    factor: str
    name: str
    kind: str


@dataclass(frozen=True, slots=True)
class Between:
    """What parts two configurations.

    Attributes:
        first, second: their flags.
        parting: indices of the flags with opposite signs: every path between the two crosses these families.
        equal: indices of those with the same sign.
        open: indices of the others: zero at one of the two, or without a sign.
        crossings: of the straight segment in joint space, found by sampling.
    """

    first: Flags
    second: Flags
    parting: tuple[int, ...]
    equal: tuple[int, ...]
    open: tuple[int, ...]
    crossings: tuple[Crossing, ...]

    def sentences(self) -> tuple[str, ...]:
        """What is proved, what is not, and what lies on the straight way."""
        flags = self.first.flags
        found = [f"Every path between them crosses {_title(flags[i])}: its sign differs." for i in self.parting]
        if not self.parting:
            found.append(
                "No factor has opposite signs at the two. That does not prove that a path without singularity exists: "
                "configurations with equal signs may lie in different aspects."
            )
        for i in self.open:
            zero = self.first.flags[i].sign == 0 or self.second.flags[i].sign == 0
            why = "it is zero at one of the two" if zero else "it has no sign of its own on the torus"
            found.append(f"{_title(flags[i])} decides nothing: {why}.")
        if self.crossings:
            for one in self.crossings:
                where = "" if one.kind in _ENDS else f" at {one.at:.6g} of its length"
                found.append(f"The straight way {one.kind} {one.name or one.factor}{where}.")
        else:
            found.append("The straight way meets no singularity at its sample points, nor between them by a sign.")
        return tuple(found)

    def to_dict(self) -> dict[str, Any]:
        """For a result file."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Signs:
    """The factors of det J of an arm, ready to be evaluated at many configurations.

    Attributes:
        chain: the arm.
        factors: with a sign of their own where that can be had.
        names: of their families.
    """

    chain: Chain
    factors: tuple[SignedFactor, ...]
    names: tuple[str, ...]

    def values(self, q: Array) -> Array:
        """(N, n) configurations -> (N, number of factors) scaled values."""
        chain = self.chain
        theta = into_units(chain.robot, np.atleast_2d(q)) + chain.shifts
        return np.stack([factor.values(theta, chain.numbers, chain.power) for factor in self.factors], axis=1)


def signs_of(chain: Chain, *, names: bool = True) -> Signs:
    """Factor the determinant of an arm without redundancy, once for many configurations.

    Args:
        chain: from `exact_chain`.
        names: look at real configurations of each family to name it.

    Raises:
        TaskError: the task Jacobian is not square, or singular at every configuration.
    """
    if chain.n != chain.task.m:
        raise TaskError(
            "configuration flags are signs of a determinant, and the task Jacobian is not square",
            got=f"{chain.task.m} rows, {chain.n} joints",
            allowed="as many joints as rows",
            mend="choose a task with as many rows as joints" if chain.n <= 6 else "",
        )
    rows = [list(row) for row in zip(*chain.columns, strict=True)]
    determinant = chain.ring.determinant(rows)
    if determinant == 0:
        raise TaskError("the determinant is zero at every configuration", got=chain.task.name)
    atoms = [atom for atom, _ in chain.ring.factor(determinant).atoms]
    factors = signed_factors(chain.ring, atoms)
    found = tuple(look(chain, factor.atoms)[0] if names else "" for factor in factors)
    return Signs(chain, factors, found)


def configuration_flags(
    chain: Chain, q: ArrayLike, *, signs: Signs | None = None, tolerance: float = DEFAULT.singular
) -> Flags:
    """The sign of each factor of det J at a configuration: elbow, shoulder, wrist + or −.

    Args:
        chain: from `exact_chain`, as many joints as the task has rows.
        q: (n,) configuration [rad, m]. Limits are not looked at.
        signs: from `signs_of`, where many configurations are asked for.
        tolerance: scaled values up to it are zero.

    Raises:
        TaskError: as `signs_of`.
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> arm = exact_chain(open_robot("anthropomorphic"))
        >>> [flag.label for flag in configuration_flags(arm, [0.0, 0.4, 0.9, 0.0, -1.0, 0.0]).flags]
        ['elbow +', 'wrist −', 'shoulder −']
    """
    if not 0.0 <= tolerance < 1.0:
        raise OptionError("the tolerance is outside the range", got=tolerance, allowed="0 … 1, 1 excluded")
    known = signs if signs is not None else signs_of(chain)
    configuration = one_configuration(chain.robot, q)
    values = known.values(configuration)[0] if known.factors else ()
    flags = tuple(
        Flag(factor.text, name, _sign(float(value), tolerance) if factor.periodic else None, float(value))
        for factor, name, value in zip(known.factors, known.names, values, strict=True)
    )
    return Flags(tuple(float(x) for x in configuration), flags, tolerance)


def between(
    chain: Chain,
    first: ArrayLike,
    second: ArrayLike,
    *,
    signs: Signs | None = None,
    tolerance: float = DEFAULT.singular,
) -> Between:
    """Which families part two configurations, and which the straight segment between them meets.

    Args:
        chain, signs, tolerance: as in `configuration_flags`.
        first, second: (n,) configurations [rad, m].

    Raises:
        TaskError, ConfigurationError: as `configuration_flags`.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> between(exact_chain(open_robot("planar2r")), [0, 0.5], [0, -0.5]).sentences()[0]
        'Every path between them crosses elbow: axes 1, 2 and tip coplanar (s2): its sign differs.'
    """
    known = signs if signs is not None else signs_of(chain)
    one, two = (configuration_flags(chain, q, signs=known, tolerance=tolerance) for q in (first, second))
    products = [0 if not (a.sign and b.sign) else a.sign * b.sign for a, b in zip(one.flags, two.flags, strict=True)]
    start, end = np.array(one.q), np.array(two.q)
    crossings = [c for k in range(len(known.factors)) for c in _crossings(known, k, start, end, tolerance)]
    return Between(
        first=one,
        second=two,
        parting=tuple(i for i, x in enumerate(products) if x < 0),
        equal=tuple(i for i, x in enumerate(products) if x > 0),
        open=tuple(i for i, x in enumerate(products) if x == 0),
        crossings=tuple(sorted(crossings, key=lambda crossing: (crossing.at, crossing.factor))),
    )


def _sign(value: float, tolerance: float) -> int:
    return 0 if abs(value) <= tolerance else (1 if value > 0 else -1)


def _title(flag: Flag) -> str:
    return f"{flag.name} ({flag.factor})" if flag.name else flag.factor


def _flag_words(flag: Flag) -> str:
    if flag.sign is None:
        return f"{_title(flag)} has no sign of its own: it changes sign over a full turn of a joint."
    return f"{flag.label}: {flag.factor} {({1: '> 0', -1: '< 0', 0: '= 0: on the family'})[flag.sign]}"


def _crossings(signs: Signs, index: int, start: Array, end: Array, tolerance: float) -> list[Crossing]:
    """Zeros of one factor along the segment."""
    factor, chain = signs.factors[index], signs.chain

    def value(share: Array) -> Array:
        q = start + share[:, None] * (end - start)
        return factor.values(into_units(chain.robot, q) + chain.shifts, chain.numbers, chain.power)

    met = zeros_between(value, float(np.abs(end - start).sum()) / tau, tolerance)
    return [Crossing(at, factor.text, signs.names[index], kind) for at, kind in met]
