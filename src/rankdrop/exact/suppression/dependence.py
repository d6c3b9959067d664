"""Dependent screws: one that is a combination of others everywhere on a stratum, with the proof that those are
independent there.

The circuit is found at random points modulo p. That the other screws of the circuit are independent everywhere is
proved by minors: one without zero on the stratum, or several without a common one, or the Gram determinant |KᵀK|.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product

from rankdrop.exact.algebra.field import rank, value_at
from rankdrop.exact.algebra.polynomial import Atom, Equality, Polynomial
from rankdrop.exact.algebra.work import Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.suppression.stratum import Stratum, atoms_on, vanishes

Columns = Sequence[Sequence[Polynomial]]
GRAM = 3
"""Most screws whose Gram determinant is tried: it has as many terms as all squared minors together."""
TOGETHER_AT_MOST = 6
"""Most minors that are looked at together."""
SAMPLES = 3
"""Random points of an irreducible piece at which ranks are compared."""
MORE_SAMPLES = 10
"""Of a piece with two equations or more, which may have several components."""


@dataclass(frozen=True)
class Proof:
    """Why screws are independent everywhere on a stratum.

    Attributes:
        kind: "minor", "minors" (without a common zero) or "gram".
        frame: link in whose frame the screws are taken.
        rows: of each minor, numbers 0 … 5 of (v; ω); empty for "gram".
        polynomials: the minors or the Gram determinant, as they read on the stratum.
    """

    kind: str
    frame: int
    rows: tuple[tuple[int, ...], ...]
    polynomials: tuple[Polynomial, ...]


@dataclass(frozen=True)
class Dependence:
    """Screw `screw` is a combination of the screws `on`, which are independent everywhere.

    Attributes:
        screw: number of the dependent joint.
        on: numbers of the others; empty where the screw itself is zero.
        proof: of their independence; None where there are none.
    """

    screw: int
    on: tuple[int, ...]
    proof: Proof | None

    @property
    def circuit(self) -> tuple[int, ...]:
        """All of them in order."""
        return tuple(sorted((self.screw, *self.on)))


@dataclass(frozen=True)
class Obstacle:
    """A minor of a circuit's other screws that has zeros on the stratum: a place to split it.

    Attributes:
        minor: as it reads on the stratum.
        atoms: those that are not known to be nowhere zero.
    """

    minor: Polynomial
    atoms: tuple[Atom, ...]

    @property
    def weight(self) -> int:
        """Of the atoms: how much there is to split at."""
        return sum(atom.weight for atom in self.atoms)

    @property
    def light(self) -> bool:
        """Whether the minor vanishes at pinned joints only."""
        return all(atom.pinned for atom in self.atoms)


class Sampled:
    """The screws at random points of every piece of a stratum, modulo p.

    Args:
        columns: every screw (v; ω) of the chain.
        stratum: where.
        rng: source of the points.

    Attributes:
        points: per piece, the screws at each point and the prime that they are modulo; a piece without points has none.
    """

    def __init__(self, columns: Columns, stratum: Stratum, rng: random.Random) -> None:
        self.points: list[list[tuple[list[list[int]], int]]] = []
        for piece in stratum.pieces:
            drawn = piece.points(rng, MORE_SAMPLES if piece.several else SAMPLES)
            screws = ([[value_at(stratum.ring, x, point) for x in column] for column in columns] for point in drawn)
            self.points.append([(here, point.prime) for here, point in zip(screws, drawn, strict=True)])

        self._ranks: dict[tuple[int, ...], set[int]] = {}

    def ranks(self, joints: Sequence[int]) -> set[int]:
        """Every rank that these joints' screws have at the points."""
        key = tuple(sorted(joints))
        if key not in self._ranks:
            every = (point for piece in self.points for point in piece)
            self._ranks[key] = {rank([screws[j - 1] for j in key], prime) for screws, prime in every}
        return self._ranks[key]

    def mixed(self, joints: Sequence[int]) -> tuple[int, ...] | None:
        """The smallest set of joints whose rank differs from point to point of one piece: it has several components."""
        if max(map(len, self.points), default=0) <= SAMPLES:
            return None
        for size in range(1, len(joints) + 1):
            for chosen in combinations(joints, size):
                for piece in self.points:
                    if len({rank([screws[j - 1] for j in chosen], prime) for screws, prime in piece}) > 1:
                        return chosen
        return None


def candidates(sampled: Sampled, joints: Sequence[int]) -> Iterator[tuple[int, tuple[int, ...]]]:
    """(screw, others): a screw in the span of independent others at all points, fewest others first.

    What smaller sets say of a screw is not said again with more others.
    """
    said: list[tuple[int, tuple[int, ...]]] = []
    for size in range(len(joints)):
        for screw in joints:
            for others in combinations([j for j in joints if j != screw], size):
                if any(screw == known and set(fewer) <= set(others) for known, fewer in said):
                    continue
                if sampled.ranks(others) == {size} and sampled.ranks((screw, *others)) == {size}:
                    said.append((screw, others))
                    yield screw, others


def find(
    chain: Chain, frame: int, stratum: Stratum, sampled: Sampled, joints: Sequence[int], work: Work
) -> tuple[Dependence | None, Obstacle | None]:
    """A dependent screw among these joints, fewest others and lowest number first; else the best place to split.

    Args:
        chain: whose screws they are.
        frame: link in whose frame a proof is looked for first; then, unless it is clear where to split, in those of
            the other links.
        stratum: where.
        sampled: the screws there.
        joints: numbers of the joints to look among.
        work: deadline, asked before each proof.
    """
    obstacle: Obstacle | None = None
    found = list(candidates(sampled, joints))
    for k in [frame, *(k for k in range(1, chain.n) if k != frame)]:
        for screw, others in found:
            if not others:
                return Dependence(screw, (), None), None
            work.check()
            proof, here = independent(chain, k, stratum, others, work)
            if proof is not None:
                return Dependence(screw, others, proof), None
            if here is not None and (obstacle is None or here.weight < obstacle.weight):
                obstacle = here
        if obstacle is not None and obstacle.light:
            break
    return None, obstacle


def lightest(chain: Chain, stratum: Stratum, joints: Sequence[int], work: Work) -> Obstacle | None:
    """Of all minors of some screws, in the frames of all links, the one with the least to split at."""
    found = []
    for k in range(1, chain.n):
        work.check()
        _, obstacle = independent(chain, k, stratum, joints, work)
        found += [obstacle] if obstacle is not None else []
    return min(found, key=lambda one: one.weight, default=None)


def independent(
    chain: Chain, frame: int, stratum: Stratum, joints: Sequence[int], work: Work
) -> tuple[Proof | None, Obstacle | None]:
    """A proof that screws are independent everywhere on a stratum, or the minor that comes closest to one."""
    ring, columns = stratum.ring, chain.screws(frame)
    chosen = [[stratum.short(x) for x in columns[j - 1]] for j in joints]
    minors, proofs = [], list[Proof]()
    for rows in combinations(range(6), len(joints)):
        work.check()
        minor = stratum.short(ring.determinant([[column[r] for column in chosen] for r in rows]))
        if minor == 0:
            continue
        zeros = _zeros(stratum, minor, work)
        if zeros is None:
            continue
        if not any(zeros):
            proofs.append(Proof("minor", frame, (rows,), (minor,)))
        minors.append((Obstacle(minor, tuple(atom for atoms in zeros for atom in atoms)), rows, minor, zeros))
    if proofs:
        return min(proofs, key=lambda one: (len(one.polynomials[0]), one.polynomials[0].total_degree())), None
    minors.sort(key=lambda one: one[0].weight)
    if not minors:
        return None, None
    gram = _gram(stratum, chosen, work) if len(joints) <= GRAM else None
    if gram is not None:
        return Proof("gram", frame, (), (gram,)), None
    for size in (2, 3):
        for some in combinations(minors[:TOGETHER_AT_MOST], size):
            if all(_no_common(atoms) for atoms in zip(*(zeros for *_, zeros in some), strict=True)):
                rows_of, polynomials = tuple(one[1] for one in some), tuple(one[2] for one in some)
                return Proof("minors", frame, rows_of, polynomials), None
    return None, minors[0][0]


def _zeros(stratum: Stratum, p: Polynomial, work: Work) -> list[tuple[Atom, ...]] | None:
    """Per piece the atoms under which p may vanish; None where it vanishes on a whole piece."""
    found = []
    for piece in stratum.pieces:
        atoms = atoms_on(piece, Equality((), p))
        if atoms is None or (piece.several and vanishes(piece, p, work.rng)):
            return None
        found.append(atoms)
    return found


def _gram(stratum: Stratum, chosen: Columns, work: Work) -> Polynomial | None:
    """|KᵀK| where it has no zero on the stratum."""
    ring = stratum.ring
    products = [
        [stratum.short(ring.reduce(sum((x * y for x, y in zip(a, b, strict=True)), ring.zero))) for b in chosen]
        for a in chosen
    ]
    found = stratum.short(ring.determinant(products))
    zeros = _zeros(stratum, found, work) if found != 0 else None
    return found if zeros is not None and not any(zeros) else None


def _no_common(sets: Sequence[Sequence[Atom]]) -> bool:
    """Whether no choice of one atom from each set can hold at once: two pin one joint at different angles."""
    return all(
        any(a.pinned and b.pinned and a.joint == b.joint and a.value != b.value for a, b in combinations(choice, 2))
        for choice in product(*sets)
    )
