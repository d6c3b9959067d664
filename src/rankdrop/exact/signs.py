"""Aspects: the signs of the determinant's factors as flags of a configuration, and what parts two configurations.

An arm without redundancy is singular where one of the factors of det J is zero. A factor with a sign on the torus
cannot change it along a path without passing zero: configurations with opposite signs are parted by that family. The
converse is no theorem: with all signs equal there may be several aspects (connected sets of regular configurations).

A factor of the half-angle ring of degree D_j in t_j stands for a function of sin(θ_j/2) and cos(θ_j/2), homogeneous of
degree D_j in them. A full turn of joint j multiplies it by (−1)^D_j: with an odd degree it has zeros but no sign of
its own. Products in which odd degrees cancel have one: θ = 0 and θ = π together are sin θ = 0, θ = ±π/2 together are
cos θ = 0.

Real configurations on which one atom holds are found in floating point: to name the part of the arm and the motion that
is lost there, not to prove anything. Zeros of a factor along a segment are found by samples: sign changes halved down,
and minima of its size that reach zero.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import combinations, islice
from math import ceil, tau
from operator import xor

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.algebra.polynomial import Atom, Polynomial, number_value
from rankdrop.algebra.ring import Ring, add_terms, numeric_terms
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.errors import ConfigurationError, TaskError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.lint import round_points
from rankdrop.families.name import FamilyName
from rankdrop.families.naming import name_family
from rankdrop.formula.notation import Text
from rankdrop.formula.shortest import ratio
from rankdrop.formula.sums import Wave
from rankdrop.formula.writing import text_of
from rankdrop.kinematics import one_configuration
from rankdrop.lists import flat_map
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.local.directions import lost_in_sparsest_frame, lost_over_family, words
from rankdrop.robot.model import Array
from rankdrop.sections import words_of
from rankdrop.tolerances import DEFAULT
from rankdrop.units import counted_length, into_units, out_of_units

_READABLE = 60  # terms above which a factor is not written out
_PAIRS = (("0", "pi"), ("pi/2", "-pi/2"))

_TENTH = 0.1  # [rad]; at round degrees axes are parallel by chance
POINTS = 8
"""Real configurations at which the geometry of a part is looked at."""
Seen = tuple[FamilyName | None, Array, tuple[str, ...]]
"""(name, points, lost) of a part, as `analyze` names such a family, None where no configuration is real, or singular of
corank 1; (N, n) real configurations of `Chain.own` on it, those of corank 1 where there are such; one sentence on each
direction lost, in a frame where it stands still or at the first point."""

SAMPLES = 128
"""Points per turn at which a function is looked at along a segment."""
_ZOOMS = 16  # of an interval: to the last digit
Function = Callable[[Array], Array]  # shares of the way (N,) -> values (N,)

_LONG = 16  # characters of a factor that is not put into a label


@dataclass(frozen=True, eq=False)
class SignedFactor:
    """Atoms that have a sign together, or one that has none.

    Attributes:
        ring: the one that the atoms live in.
        atoms: their zeros are those of the factor.
        text: the function: in s_j = sin θ_j and c_j = cos θ_j, or a half-angle form where it is not periodic.
        periodic: it comes back with its sign after a full turn of any joint.
        sense: sign of `text` over the product of the atoms' functions.
    """

    ring: Ring
    atoms: tuple[Atom, ...]
    text: str
    periodic: bool
    sense: int

    def values(self, theta: Array, letters: Mapping[str, float], power: int = 0) -> Array:
        """The function at configurations; each atom is divided by the sum of the sizes of its coefficients.

        Args:
            theta: (N, n) joint variables of the conditions: q + shifts; slides in units of 10 to `power` [rad, m].
            letters: the lengths [m].
            power: of ten; of the arm's own unit, sizes of coefficients do not depend on the unit given.

        Returns:
            (N,) with the sign of `text`; |value| ≤ 1 in an arm without slides. Continuous in θ in any case.
        """
        total = np.full(len(theta), float(self.sense))
        for atom in self.atoms:
            total = total * half_angle_values(self.ring, atom, theta, letters, power)
        return total


def signed_factors(ring: Ring, atoms: Sequence[Atom]) -> tuple[SignedFactor, ...]:
    """Atoms joined into factors with a sign of their own where that can be done.

    The products of atoms in which all odd degrees cancel form a vector space over {0, 1}; the factors are a basis of it
    with as few atoms in each as possible. An atom that is in none of them has no sign, even together with others.

    Example:
        >>> from rankdrop.algebra.ring import Ring
        >>> ring = Ring([1, 2])
        >>> found = ring.factor(ring.s[1] * (1 - ring.c[2]))
        >>> [(factor.text, factor.periodic) for factor in signed_factors(ring, [atom for atom, _ in found.atoms])]
        [('s1', True), ('sin(θ2/2)', False)]
    """
    kept = list(dict.fromkeys(atoms))
    groups = _even_products(ring, kept)
    alone = [(i,) for i in range(len(kept)) if not any(i in chosen for chosen in groups)]
    every = sorted([*groups, *alone])
    return tuple(_signed_factor(ring, tuple(kept[i] for i in chosen), chosen in groups) for chosen in every)


def _even_products(ring: Ring, atoms: Sequence[Atom]) -> list[tuple[int, ...]]:
    """Places of atoms whose product has a sign: a basis of all such products, few atoms in each."""
    odd = [_odd(ring, atom) for atom in atoms]
    chosen = (indices for size in range(1, len(atoms) + 1) for indices in combinations(range(len(atoms)), size))
    even = [indices for indices in chosen if not reduce(xor, (odd[i] for i in indices))]
    even.sort(key=lambda indices: (len(indices), not simple_pair([atoms[i] for i in indices]), indices))
    basis = _not_needed(atoms)
    return [indices for indices in even if _independent(basis, sum(1 << i for i in indices))]


def simple_pair(atoms: Sequence[Atom]) -> bool:
    """Together sin θ or cos θ of one joint."""
    return len(atoms) == 2 and atoms[0].joint == atoms[1].joint and tuple(a.value for a in atoms) in _PAIRS


def _not_needed(atoms: Sequence[Atom]) -> list[int]:
    """Products, as bits, that need no factor: of a joint with all four pins sine and cosine tell the quarter."""
    rows: list[int] = []
    for joint in dict.fromkeys(atom.joint for atom in atoms if atom.is_pin):
        place = {atom.value: i for i, atom in enumerate(atoms) if atom.joint == joint}
        if len(place) == 4:
            _independent(rows, 1 << place["0"] | 1 << place["pi/2"])
    return rows


def _independent(basis: list[int], row: int) -> bool:
    """Whether a row of bits is no sum of those in `basis` (kept reduced, leading bit by leading bit); added if so."""
    for known in basis:
        row = min(row, row ^ known)
    if row:
        basis.append(row)
        basis.sort(reverse=True)
    return row != 0


def half_angle_values(ring: Ring, atom: Atom, theta: Array, letters: Mapping[str, float], power: int = 0) -> Array:
    """(N,) an atom's function of half-angles, divided by the sum of the sizes of its coefficients; `power` as in
    `SignedFactor.values`.
    """
    if atom.is_pin:
        s, c = np.sin(theta[:, atom.joint - 1] / 2), np.cos(theta[:, atom.joint - 1] / 2)
        return np.asarray({"0": s, "pi": c, "pi/2": (s - c) / 2, "-pi/2": (s + c) / 2}[atom.value])
    terms = [*numeric_terms(atom.f, letters, power)]
    return np.asarray(add_terms(terms, ring.powers_at(atom.f, theta)) / sum(abs(number) for number, _ in terms))


def reading(ring: Ring, atom: Atom) -> tuple[str, int]:
    """(text of an atom's function, sign of that text over `half_angle_values`)."""
    if atom.is_pin:
        half = Text(divisors=ring.parts).share(atom.joint, 1)
        texts = {"0": f"sin({half})", "pi": f"cos({half})", "pi/2": f"sin({half} − π/4)", "-pi/2": f"sin({half} + π/4)"}
        return texts[atom.value], 1
    trig = ring.to_trig(atom.f)
    if trig is None:
        return _text(atom.f, str(atom.f)), 1
    if number_value(ratio(ring, trig, atom.f)) > 0:
        sense = 1
    else:
        sense = -1
    return _text(trig, text_of(ring, trig) if len(trig) <= _READABLE else ""), sense


def _text(f: Polynomial, text: str) -> str:
    if len(f) <= _READABLE:
        return text
    return f"a polynomial of {len(f):,} terms"


def _odd(ring: Ring, atom: Atom) -> set[int]:
    """Revolute joints of which a full turn changes the sign of an atom's function."""
    if atom.is_pin:
        return {atom.joint}
    return {j for j, degree in zip(ring.revolute, atom.f.degrees(), strict=False) if degree % 2}


def _signed_factor(ring: Ring, atoms: tuple[Atom, ...], periodic: bool) -> SignedFactor:
    """Atoms as one factor, with the text that people read and its sign over the product of their functions."""
    if simple_pair(atoms):
        # sin θ = 2 sin(θ/2) cos(θ/2); cos θ = −2 sin(θ/2 − π/4) sin(θ/2 + π/4)
        sine = atoms[0].value == "0"
        whole = Wave("sin" if sine else "cos", ((atoms[0].joint, 2),))
        return SignedFactor(ring, atoms, Text(divisors=ring.parts).wave(whole), periodic, 1 if sine else -1)
    read = [reading(ring, atom) for atom in atoms]
    if len(read) == 1:
        text = read[0][0]
    else:
        text = "·".join(f"({factor})" for factor, _ in read)
    return SignedFactor(ring, atoms, text, periodic, int(np.prod([sense for _, sense in read])))


def zeros_of(chain: Chain, atoms: Sequence[Atom], count: int) -> Array:
    """(N, n) configurations q of `Chain.own`, N ≤ count, on each of which one of the atoms holds.

    Fewer than `count` where no real zeros were found.
    """
    points = (round_points(ZeroSet.where_atom(chain.ring, atom), chain, step=_TENTH) for atom in atoms)
    each = (islice(samples, ceil(count / len(atoms))) for samples in points)
    zeros = [into_units(chain.robot, theta) - chain.shifts for theta in flat_map(list, each)]
    return np.array(zeros[:count]).reshape(-1, chain.n)


def pair_angles(atoms: Sequence[Atom]) -> tuple[tuple[Atom, ...], ...]:
    """Atoms one by one, but θ = 0 with θ = π, and π/2 with −π/2, of one joint together."""
    groups: list[tuple[Atom, ...]] = []
    for atom in atoms:
        pair = next((k for k, group in enumerate(groups) if simple_pair((*group, atom))), len(groups))
        groups[pair : pair + 1] = [(*sum(groups[pair : pair + 1], ()), atom)]
    return tuple(groups)


def look(chain: Chain, atoms: Sequence[Atom]) -> Seen:
    """Name a part by the geometry of real configurations on it, and say what is lost there.

    Names and lost directions are seen at `POINTS` random configurations; they are not proofs.
    """
    robot, task = chain.own, chain.own_task
    points = zeros_of(chain, atoms, POINTS)
    if not len(points):
        return None, points, ()
    rank = generic_rank(robot, task)
    sigma = singular_values(robot, points, task)
    simple = (sigma[:, rank - 1] <= DEFAULT.singular) & (rank == 1 or sigma[:, max(rank - 2, 0)] > DEFAULT.explained)
    if not simple.any():  # the part lies in a family of higher corank
        return None, points, ()
    points = points[simple]
    try:
        name = name_family(robot, task, points)
    except ConfigurationError:
        return None, points, _lost(chain, points)
    return name, points, _lost(chain, points)


def _lost(chain: Chain, points: Array) -> tuple[str, ...]:
    """Sentences on the directions lost at all points alike, else on those at the first one."""
    robot, task = chain.own, chain.own_task
    still = lost_over_family(robot, points, task, 1)
    lost = still or lost_in_sparsest_frame(robot, points[0], task, 1)
    at = out_of_units(chain.robot, points[0])
    if still:
        where = ""
    else:
        where = f" at q = ({', '.join(f'{x:.4g}' for x in at)})"
    length = counted_length(robot)
    return tuple(words(direction, lost.name, length) + where for direction in np.asarray(lost.directions))


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
    zeros = [(float(share[i]), _kind(sample, int(i))) for i in np.flatnonzero(np.abs(sample) <= tolerance)]
    for i in np.flatnonzero(sample[:-1] * sample[1:] < 0):
        if min(abs(sample[i]), abs(sample[i + 1])) > tolerance:
            zeros.append((_refine_zero(value, share[i], share[i + 1], crossing=True), "crosses"))
    for k in _hollows(sample):
        lowest = _refine_zero(value, share[k - 1], share[k + 1], crossing=False)
        if abs(sample[k]) > tolerance >= abs(value(np.array([lowest]))[0]):
            zeros.append((lowest, "touches"))
    return sorted(zeros)


def _hollows(sample: Array) -> list[int]:
    """Samples of least size, of one sign with their neighbours, where the curve bends enough to reach zero between."""
    size = np.abs(sample)
    inner = size[1:-1]
    least = (inner <= size[:-2]) & (inner <= size[2:]) & (sample[:-2] * sample[2:] > 0)
    bend = np.abs(sample[:-2] - 2 * sample[1:-1] + sample[2:])  # f″h², and f ≤ f″h²/2 within h of a double zero
    return [int(k) + 1 for k in np.flatnonzero(least & (inner <= bend))]


def _kind(sample: Array, i: int) -> str:
    if i in (0, len(sample) - 1):
        return "starts on" if i == 0 else "ends on"
    if sample[i - 1] * sample[i + 1] < 0:
        return "crosses"
    return "touches"


def _refine_zero(value: Function, low: float, high: float, *, crossing: bool) -> float:
    """Where the function changes its sign in an interval, or is smallest, by ever finer samples."""
    for _ in range(_ZOOMS):
        share = np.linspace(low, high, 17)
        sample = value(share)
        if crossing:
            k = int(np.argmax(sample * sample[0] <= 0))
            low, high = share[k - 1], share[k]
        else:
            k = int(np.argmin(np.abs(sample)))
            low, high = share[max(k - 1, 0)], share[min(k + 1, 16)]
    return float(low + high) / 2


@dataclass(frozen=True, slots=True)
class Flag:
    """The sign of one factor at a configuration.

    Attributes:
        factor: the function, in s_j = sin θ_j and c_j = cos θ_j.
        called: the family where it is zero, as `analyze` names it; None where no real configurations are on it.
        sign: +1, −1, or 0 on the family; None where the factor has no sign on the torus.
        value: of the factor, scaled: |value| ≤ 1 without slides.
    """

    factor: str
    called: FamilyName | None
    sign: int | None
    value: float

    @property
    def name(self) -> str:
        """Name of the family in words; "" where there is none."""
        return str(self.called or "")

    def __json__(self) -> dict[str, str | int | float | None]:
        """As files hold it: the family by its name in words."""
        return {"factor": self.factor, "name": self.name, "sign": self.sign, "value": self.value}

    @property
    def label(self) -> str:
        """ "elbow +"; where the family is not named after a part, the factor, or "factor of det J" if that is long."""
        mark = {None: "has no sign", 1: "+", -1: "−", 0: "0"}[self.sign]
        if self.called is not None and self.called.parts:
            return f"{self.called.short} {mark}"
        if self.called is not None and len(self.factor) > _LONG:
            return f"factor of det J {mark}"
        if " " in self.factor:
            return f"({self.factor}) {mark}"
        return f"{self.factor} {mark}"


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
        sentences: tuple[str, ...] = words_of(self).flags_sentences(self)
        return sentences


@dataclass(frozen=True, slots=True)
class SegmentCrossing:
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
    crossings: tuple[SegmentCrossing, ...]

    def sentences(self) -> tuple[str, ...]:
        """The proven, the open, and the families on the straight way."""
        sentences: tuple[str, ...] = words_of(self).between_sentences(self)
        return sentences


@dataclass(frozen=True, eq=False)
class Signs:
    """The factors of det J of an arm, ready to be evaluated at many configurations.

    Attributes:
        chain: the arm.
        factors: with a sign of their own where that can be had.
    """

    chain: Chain
    factors: tuple[SignedFactor, ...]

    @cached_property
    def names(self) -> tuple[FamilyName | None, ...]:
        """Of the factors' families, by real configurations on them."""
        return tuple(look(self.chain, factor.atoms)[0] for factor in self.factors)

    def values(self, q: Array) -> Array:
        """(N, n) configurations -> (N, number of factors) scaled values."""
        chain = self.chain
        theta = chain.theta(np.atleast_2d(q))
        return np.stack([factor.values(theta, chain.numbers, chain.power) for factor in self.factors], axis=1)


def signs_of(chain: Chain) -> Signs:
    """Factor the determinant of an arm without redundancy, once for many configurations.

    Args:
        chain: from `exact_chain`.

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
    return Signs(chain, signed_factors(chain.ring, [atom for atom, _ in chain.ring.factor(determinant).atoms]))


def configuration_flags(chain: Chain, q: ArrayLike, *, signs: Signs | None = None) -> Flags:
    """The sign of each factor of det J at a configuration: elbow, shoulder, wrist + or −.

    Args:
        chain: from `exact_chain`, as many joints as the task has rows.
        q: (n,) configuration [rad, m]. Limits are not looked at.
        signs: from `signs_of`, where many configurations are asked for.

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
    if signs is not None:
        known = signs
    else:
        known = signs_of(chain)
    configuration = one_configuration(chain.robot, q)
    if known.factors:
        values = known.values(configuration)[0]
    else:
        values = ()
    flags = tuple(
        Flag(factor.text, name, _sign(float(value)) if factor.periodic else None, float(value))
        for factor, name, value in zip(known.factors, known.names, values, strict=True)
    )
    return Flags(tuple(float(x) for x in configuration), flags, DEFAULT.singular)


def families_between(chain: Chain, first: ArrayLike, second: ArrayLike, *, signs: Signs | None = None) -> Between:
    """Which families part two configurations, and which the straight segment between them meets.

    Args:
        chain, signs: as in `configuration_flags`.
        first, second: (n,) configurations [rad, m].

    Raises:
        TaskError, ConfigurationError: as `configuration_flags`.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> families_between(exact_chain(open_robot("planar2r")), [0, 0.5], [0, -0.5]).sentences()[0]
        'Every path between them crosses elbow: axes 1, 2 and tip coplanar (s2): its sign differs.'
    """
    if signs is not None:
        known = signs
    else:
        known = signs_of(chain)
    first_flags, second_flags = (configuration_flags(chain, q, signs=known) for q in (first, second))
    products = [(a.sign or 0) * (b.sign or 0) for a, b in zip(first_flags.flags, second_flags.flags, strict=True)]
    start, end = np.array(first_flags.q), np.array(second_flags.q)
    crossings = flat_map(lambda k: _crossings(known, k, start, end), range(len(known.factors)))
    return Between(
        first=first_flags,
        second=second_flags,
        parting=tuple(i for i, x in enumerate(products) if x < 0),
        equal=tuple(i for i, x in enumerate(products) if x > 0),
        open=tuple(i for i, x in enumerate(products) if x == 0),
        crossings=tuple(sorted(crossings, key=lambda crossing: (crossing.at, crossing.factor))),
    )


def _sign(value: float) -> int:
    if abs(value) <= DEFAULT.singular:
        return 0
    if value > 0:
        return 1
    return -1


def _crossings(signs: Signs, index: int, start: Array, end: Array) -> list[SegmentCrossing]:
    factor, chain = signs.factors[index], signs.chain

    def value(share: Array) -> Array:
        q = start + share[:, None] * (end - start)
        return factor.values(chain.theta(q), chain.numbers, chain.power)

    met = zeros_between(value, float(np.abs(end - start).sum()) / tau, DEFAULT.singular)
    return [SegmentCrossing(at, factor.text, str(signs.names[index] or ""), kind) for at, kind in met]
