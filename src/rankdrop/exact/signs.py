"""The factors of a determinant: their signs, real points on them, and the part of the arm that each is.

As functions with a sign: which of them have one on the torus, and their values.

A factor of the half-angle ring of degree D_j in t_j stands for a function of sin(θ_j/2) and cos(θ_j/2), homogeneous of
degree D_j in them. A full turn of joint j multiplies it by (−1)^D_j: with an odd degree it has zeros but no sign of
its own. Products in which odd degrees cancel have one: θ = 0 and θ = π together are sin θ = 0, θ = ±π/2 together are
cos θ = 0.

Real configurations on which one atom holds are found in floating point: to look at its geometry, not to prove
anything. There the factor gets the name of a part of the arm, and the motion that is lost is told.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rankdrop.errors import ConfigurationError
from rankdrop.exact.algebra.polynomial import Atom, Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.writing.condition import RADIANS, Condition
from rankdrop.exact.writing.value import text_of
from rankdrop.family.naming import name_family
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.local.directions import lost_in_sparsest_frame, lost_over_family, words
from rankdrop.robot.model import Array
from rankdrop.robot.numbers import reach
from rankdrop.tolerances import DEFAULT, REAL_ROOT
from rankdrop.units import counted_length, out_of_units

_READABLE = 60  # terms above which a factor is not written out
_PAIRS = (("0", "pi"), ("pi/2", "-pi/2"))


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

    @property
    def pins(self) -> tuple[str, ...]:
        """Values of the one joint that the factor pins; empty where it pins none."""
        joints = {atom.joint for atom in self.atoms}
        return tuple(atom.value for atom in self.atoms) if len(joints) == 1 and self.atoms[0].pinned else ()

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
        >>> from rankdrop.exact.algebra.ring import Ring
        >>> ring = Ring([1, 2])
        >>> found = ring.factor(ring.s[1] * (1 - ring.c[2]))
        >>> [(factor.text, factor.periodic) for factor in signed_factors(ring, [atom for atom, _ in found.atoms])]
        [('s1', True), ('sin(θ2/2)', False)]
    """
    kept = list(dict.fromkeys(atoms))
    odd = [_odd(ring, (atom,)) for atom in kept]
    groups: list[tuple[int, ...]] = []
    basis = _not_needed(kept)
    candidates = (chosen for size in range(1, len(kept) + 1) for chosen in combinations(range(len(kept)), size))
    for chosen in sorted(candidates, key=lambda one: (len(one), not simple_pair([kept[i] for i in one]), one)):
        total: set[int] = set()
        for i in chosen:
            total ^= odd[i]
        if not total and _independent(basis, sum(1 << i for i in chosen)):
            groups.append(chosen)
    joined = {i for chosen in groups for i in chosen}
    alone: list[tuple[int, ...]] = [(i,) for i in range(len(kept)) if i not in joined]
    return tuple(
        _signed(ring, tuple(kept[i] for i in chosen), chosen not in alone) for chosen in sorted(groups + alone)
    )


def simple_pair(atoms: Sequence[Atom]) -> bool:
    """Together sin θ or cos θ of one joint."""
    return len(atoms) == 2 and atoms[0].joint == atoms[1].joint and tuple(a.value for a in atoms) in _PAIRS


def _not_needed(atoms: Sequence[Atom]) -> list[int]:
    """Products, as bits, that need no factor: of a joint with all four pins sine and cosine tell the quarter."""
    rows: list[int] = []
    for joint in dict.fromkeys(atom.joint for atom in atoms if atom.pinned):
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
    sine, cosine = np.sin(theta / 2), np.cos(theta / 2)
    if atom.pinned:
        s, c = sine[:, atom.joint - 1], cosine[:, atom.joint - 1]
        return np.asarray({"0": s, "pi": c, "pi/2": (s - c) / 2, "-pi/2": (s + c) / 2}[atom.value])
    degrees = [int(degree) for degree in atom.f.degrees()]
    total, size = np.zeros(len(theta)), 0.0
    for coefficient, powers in numeric_terms(ring, atom.f, letters, power):
        part = np.full(len(theta), coefficient)
        for place, j in enumerate(ring.revolute):
            if degrees[place]:
                e = powers[place]
                part = part * sine[:, j - 1] ** e * cosine[:, j - 1] ** (degrees[place] - e)
        for place, j in enumerate(ring.prismatic, ring.angles):
            if powers[place]:
                part = part * theta[:, j - 1] ** powers[place]
        total, size = total + part, size + abs(coefficient)
    return np.asarray(total / size)


def numeric_terms(
    ring: Ring, f: Polynomial, letters: Mapping[str, float], power: int = 0
) -> Iterator[tuple[float, tuple[int, ...]]]:
    """(coefficient with the lengths put in, powers) of each term of a half-angle polynomial, less a positive factor;
    slides are in units of 10 to `power`.

    Whole coefficients of calibrated arms have a hundred digits and more: they are divided by the largest first.
    """
    largest = max(abs(value) for value in f.coeffs())
    for powers, value in f.terms():
        coefficient = int((value / largest).p) / int((value / largest).q)
        for place, name in enumerate(ring.letters, ring.moving):
            coefficient *= letters[name] ** int(powers[place])
        coefficient *= 10.0 ** (power * sum(int(e) for e in powers[ring.angles : ring.moving]))
        yield coefficient, tuple(int(e) for e in powers)


def reading(ring: Ring, atom: Atom) -> tuple[str, int]:
    """(text of an atom's function, sign of that text over `half_angle_values`)."""
    if atom.pinned:
        angle = {"0": f"θ{atom.joint}/2", "pi": f"θ{atom.joint}/2"}.get(atom.value, "")
        text = {"0": f"sin({angle})", "pi": f"cos({angle})"}.get(atom.value)
        sign = "−" if atom.value == "pi/2" else "+"
        return (text or f"sin(θ{atom.joint}/2 {sign} π/4)", 1)
    trig = ring.to_trig(atom.f)
    if trig is None:
        return _text(atom.f, str(atom.f)), 1
    return _text(trig, text_of(ring, trig) if len(trig) <= _READABLE else ""), _sense(ring, atom, trig)


def _text(f: Polynomial, text: str) -> str:
    return text if len(f) <= _READABLE else f"a polynomial of {len(f):,} terms"


def _sense(ring: Ring, atom: Atom, trig: Polynomial) -> int:
    """Sign of `to_trig` over `half_angle_values`: the same everywhere, so any point that is not a zero tells it."""
    rng = np.random.default_rng(0)
    joints = max((*ring.revolute, *ring.prismatic))
    theta = rng.uniform(-np.pi, np.pi, (8, joints))
    letters = dict(zip(ring.letters, rng.uniform(1, 2, len(ring.letters)), strict=True))
    values = half_angle_values(ring, atom, theta, letters)
    best = int(np.argmax(np.abs(values)))
    point = {f"q{j}": theta[best, j - 1] for j in ring.prismatic} | letters
    for j in ring.revolute:
        point |= {f"s{j}": np.sin(theta[best, j - 1]), f"c{j}": np.cos(theta[best, j - 1])}
    names = ring.trig.names()
    largest = max(abs(value) for value in trig.coeffs())
    total = 0.0
    for powers, value in trig.terms():
        share = value / largest
        factors = [point[name] ** int(e) for name, e in zip(names, powers, strict=True)]
        total += int(share.p) / int(share.q) * float(np.prod(factors))
    return 1 if total * values[best] > 0 else -1


def _odd(ring: Ring, atoms: Sequence[Atom]) -> set[int]:
    """Revolute joints of which a full turn changes the sign of the product."""
    odd: set[int] = set()
    for atom in atoms:
        if atom.pinned:
            odd ^= {atom.joint}
        else:
            odd ^= {j for j, degree in zip(ring.revolute, atom.f.degrees(), strict=False) if degree % 2}
    return odd


def _signed(ring: Ring, atoms: tuple[Atom, ...], periodic: bool) -> SignedFactor:
    """Atoms as one factor, with the text that people read and its sign over the product of their functions."""
    if simple_pair(atoms):
        # sin θ = 2 sin(θ/2) cos(θ/2); cos θ = −2 sin(θ/2 − π/4) sin(θ/2 + π/4)
        sine = atoms[0].value == "0"
        return SignedFactor(ring, atoms, f"{'s' if sine else 'c'}{atoms[0].joint}", periodic, 1 if sine else -1)
    read = [reading(ring, atom) for atom in atoms]
    text = read[0][0] if len(read) == 1 else "·".join(f"({one})" for one, _ in read)
    return SignedFactor(ring, atoms, text, periodic, int(np.prod([sense for _, sense in read])))


_TRIES = 8  # random settings of the other joints per point wanted


def zeros_of(chain: Chain, atoms: Sequence[Atom], count: int, seed: int = 0) -> Array:
    """(N, n) configurations q of `Chain.own`, N ≤ count, on each of which one of the atoms holds, in turn.

    The joints that an atom does not fix stand at random tenths. Fewer than `count` where no real zeros were found.
    """
    rng = np.random.default_rng(seed)
    found: list[Array] = []
    for attempt in range(_TRIES * count):
        theta = _random(chain, rng)
        solved = _solve(chain, atoms[attempt % len(atoms)], theta, rng)
        if solved is not None:
            found.append(solved - chain.shifts)
        if len(found) == count:
            break
    return np.array(found).reshape(-1, chain.n)


def _random(chain: Chain, rng: np.random.Generator) -> Array:
    """θ (n,) at random tenths [rad], slides at shares of the reach."""
    theta = np.round(rng.uniform(-np.pi, np.pi, chain.n), 1)
    for j in chain.ring.prismatic:
        theta[j - 1] = np.round(rng.uniform(0.3, 1.0), 1) * reach(chain.own)
    return theta


def _solve(chain: Chain, atom: Atom, theta: Array, rng: np.random.Generator) -> Array | None:
    """θ with one joint of the atom, chosen at random, moved to a zero; None where it has no real one."""
    theta = theta.copy()
    if atom.pinned:
        theta[atom.joint - 1] = RADIANS[atom.value]
        return theta
    ring = chain.ring
    moving = [*ring.revolute, *ring.prismatic]
    degrees = [int(degree) for degree in atom.f.degrees()]
    place = int(rng.choice([i for i in range(ring.moving) if degrees[i]]))
    coefficients = np.zeros(degrees[place] + 1)  # highest power first
    for coefficient, powers in numeric_terms(ring, atom.f, chain.numbers, chain.power):
        for i, j in enumerate(moving):
            if i == place:
                continue
            x = theta[j - 1]
            if i < ring.angles:
                coefficient *= np.sin(x / 2) ** powers[i] * np.cos(x / 2) ** (degrees[i] - powers[i])
            else:
                coefficient *= x ** powers[i]
        coefficients[degrees[place] - powers[place]] += coefficient
    roots = np.roots(coefficients) if np.isfinite(coefficients).all() and coefficients.any() else np.zeros(0)
    real = roots[np.abs(roots.imag) < REAL_ROOT].real
    if not len(real):
        return None
    root = float(rng.choice(real))
    theta[moving[place] - 1] = 2 * np.arctan(root) if place < ring.angles else root
    return theta


POINTS = 8
"""Real configurations at which the geometry of a part is looked at."""
ROLES = ("shoulder", "elbow", "wrist")
_PIN = {"0": "0", "pi": "π", "pi/2": "π/2", "-pi/2": "−π/2"}


Seen = tuple[str, Array, tuple[str, ...]]
"""(name, points, lost) of a part: as `analyze` names such a family, "" where no configuration is real, or singular of
corank 1; (N, n) real configurations of `Chain.own` on it, those of corank 1 where there are such; one sentence on each
direction lost, in a frame where it stands still or at the first point."""


def merged(atoms: Sequence[Atom]) -> tuple[tuple[Atom, ...], ...]:
    """Atoms one by one, but θ = 0 with θ = π, and π/2 with −π/2, of one joint together."""
    groups: list[tuple[Atom, ...]] = []
    for atom in atoms:
        pair = next((group for group in groups if simple_pair((*group, atom))), None)
        if pair is None:
            groups.append((atom,))
        else:
            groups[groups.index(pair)] = (*pair, atom)
    return tuple(groups)


def condition_text(ring: Ring, atoms: Sequence[Atom]) -> str:
    """When the atoms hold: "θ3 = 0 or π", or a polynomial = 0."""
    if atoms[0].pinned:
        return f"θ{atoms[0].joint} = {' or '.join(_PIN[atom.value] for atom in atoms)}"
    return Condition(ring, atoms[0].f).text()


def roles_of(name: str) -> tuple[str, ...]:
    """The parts of an arm (out of `ROLES`) that a family's name speaks of."""
    head, colon, _ = name.partition(":")
    return tuple(role for role in ROLES if colon and role in head)


def look(chain: Chain, atoms: Sequence[Atom]) -> Seen:
    """Name a part by the geometry of real configurations on it, and say what is lost there.

    Names and lost directions are seen at `POINTS` random configurations; they are not proofs.
    """
    robot, task = chain.own, chain.own_task
    points = zeros_of(chain, atoms, POINTS)
    if not len(points):
        return "", points, ()
    rank = generic_rank(robot, task)
    sigma = singular_values(robot, points, task)
    simple = (sigma[:, rank - 1] <= DEFAULT.singular) & (rank == 1 or sigma[:, max(rank - 2, 0)] > DEFAULT.explained)
    if not simple.any():  # the part lies in a family of higher corank
        return "", points, ()
    points = points[simple]
    try:
        name = name_family(robot, task, points)
    except ConfigurationError:
        name = ""
    return name, points, _lost(chain, points)


def _lost(chain: Chain, points: Array) -> tuple[str, ...]:
    """Sentences on the directions lost at all points alike, else on those at the first one."""
    robot, task = chain.own, chain.own_task
    still = lost_over_family(robot, points, task, 1)
    found = still or lost_in_sparsest_frame(robot, points[0], task, 1)
    at = out_of_units(chain.robot, points[0])
    where = "" if still else f" at q = ({', '.join(f'{x:.4g}' for x in at)})"
    length = counted_length(robot)
    return tuple(words(direction, found.name, length) + where for direction in np.asarray(found.directions))
