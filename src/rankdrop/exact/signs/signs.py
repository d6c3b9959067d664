"""Factors of a determinant as functions with a sign: which of them have one on the torus, and their values.

A factor of the half-angle ring of degree D_j in t_j stands for a function of sin(θ_j/2) and cos(θ_j/2), homogeneous of
degree D_j in them. A full turn of joint j multiplies it by (−1)^D_j: with an odd degree it has zeros but no sign of
its own. Products in which odd degrees cancel have one: θ = 0 and θ = π together are sin θ = 0, θ = ±π/2 together are
cos θ = 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rankdrop.exact.algebra.atom import Atom
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.writing.text_of import text_of
from rankdrop.robot.model import Array

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
            total = total * half_values(self.ring, atom, theta, letters, power)
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
    basis = _told(kept)
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


def _told(atoms: Sequence[Atom]) -> list[int]:
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


def half_values(ring: Ring, atom: Atom, theta: Array, letters: Mapping[str, float], power: int = 0) -> Array:
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
    """(text of an atom's function, sign of that text over `half_values`)."""
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
    """Sign of `to_trig` over `half_values`: the same everywhere, so any point that is not a zero tells it."""
    rng = np.random.default_rng(0)
    joints = max((*ring.revolute, *ring.prismatic))
    theta = rng.uniform(-np.pi, np.pi, (8, joints))
    letters = dict(zip(ring.letters, rng.uniform(1, 2, len(ring.letters)), strict=True))
    values = half_values(ring, atom, theta, letters)
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
    if simple_pair(atoms):
        # sin θ = 2 sin(θ/2) cos(θ/2); cos θ = −2 sin(θ/2 − π/4) sin(θ/2 + π/4)
        sine = atoms[0].value == "0"
        return SignedFactor(ring, atoms, f"{'s' if sine else 'c'}{atoms[0].joint}", periodic, 1 if sine else -1)
    read = [reading(ring, atom) for atom in atoms]
    text = read[0][0] if len(read) == 1 else "·".join(f"({one})" for one, _ in read)
    return SignedFactor(ring, atoms, text, periodic, int(np.prod([sense for _, sense in read])))
