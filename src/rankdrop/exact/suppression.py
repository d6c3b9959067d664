"""Dependent-screw suppression (KG): every singular configuration of a redundant arm, in families that do not meet.

Step 1. The determinant of six basic screws is zero where one of its factors is: case i has factor i = 0 and the earlier
ones ≠ 0. Step 2. In each case a screw that is a combination of others everywhere, which is proved, is suppressed: the
rank of the rest is the rank of all, and step 1 is repeated with them until six are left, whose determinant says which
part of the case is singular. Where no screw is dependent everywhere, the case is split at a minor that stands in the
way. An arm of six joints has step 1 alone.

The circuit of a dependent screw is found at random points modulo p. That its other screws are independent everywhere
is proved by minors: one without zero on the stratum, or several without a common one, or the Gram determinant |KᵀK|.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import NamedTuple

from rankdrop.algebra.field import rank, residues
from rankdrop.algebra.matrix import each_entry, entries, submatrix
from rankdrop.algebra.polynomial import Atom, Equality, Polynomial
from rankdrop.algebra.ring import letters_polynomial
from rankdrop.algebra.solving import plainly_positive
from rankdrop.algebra.work import OutOfTime, Work
from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import check_basic, triples
from rankdrop.exact.stratum import Stratum, VanishingProduct, atoms_on, factor_on_stratum, join_pins, vanishes
from rankdrop.formula.value import Value
from rankdrop.lists import flat_map

Columns = Sequence[Sequence[Polynomial]]
GRAM = 3
"""Most screws whose Gram determinant is tried: it has as many terms as all squared minors together."""
TOGETHER_AT_MOST = 6
"""Most minors that are looked at together."""
SAMPLES = 3
"""Random points of an irreducible piece at which ranks are compared."""
MORE_SAMPLES = 10
"""Of a piece with two equations or more, which may have several components."""

DEEPEST = 4
"""Most equations of a piece beside its pinned joints: more do not occur in an arm of eight joints without a fault."""


@dataclass(frozen=True)
class IndependenceProof:
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
class ScrewDependence:
    """Screw `screw` is a combination of the screws `on`, which are independent everywhere.

    Attributes:
        screw: number of the dependent joint.
        on: numbers of the others; empty where the screw itself is zero.
        proof: of their independence; None where there are none.
    """

    screw: int
    on: tuple[int, ...]
    proof: IndependenceProof | None


class ZeroMinor(NamedTuple):
    """A minor of a circuit's other screws that has zeros on the stratum: a place to split it.

    Attributes:
        weight: of the atoms that are not known to be nowhere zero: how much there is to split at.
        light: whether it vanishes at pinned joints only.
        minor: as it reads on the stratum.
    """

    weight: int
    light: bool
    minor: Polynomial


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
            self.points.append(residues(stratum.ring, columns, drawn))
        self._ranks: dict[tuple[int, ...], set[int]] = {}

    def ranks(self, joints: Sequence[int]) -> set[int]:
        """Every rank that these joints' screws have at the points."""
        key = tuple(sorted(joints))
        if key not in self._ranks:
            self._ranks[key] = set().union(*(self._ranks_on(piece, key) for piece in self.points))
        return self._ranks[key]

    def _ranks_on(self, piece: list[tuple[list[list[int]], int]], joints: tuple[int, ...]) -> set[int]:
        return {rank([screws[j - 1] for j in joints], prime) for screws, prime in piece}

    def joints_of_mixed_rank(self, joints: Sequence[int]) -> tuple[int, ...] | None:
        """The smallest set of joints whose rank differs from point to point of one piece: it has several components."""
        if max(map(len, self.points), default=0) <= SAMPLES:
            return None
        subsets = (chosen for size in range(1, len(joints) + 1) for chosen in combinations(joints, size))
        several = (joint for joint in subsets if any(len(self._ranks_on(piece, joint)) > 1 for piece in self.points))
        return next(several, None)


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
) -> tuple[ScrewDependence | None, ZeroMinor | None]:
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
    obstacle: ZeroMinor | None = None
    dependences = list(candidates(sampled, joints))
    for k in [frame, *(k for k in range(1, chain.n) if k != frame)]:
        for screw, others in dependences:
            if not others:
                return ScrewDependence(screw, (), None), None
            work.check()
            proof, blocking = independent(chain, k, stratum, others, work)
            if proof is not None:
                return ScrewDependence(screw, others, proof), None
            if blocking is not None and (obstacle is None or blocking.weight < obstacle.weight):
                obstacle = blocking
        if obstacle is not None and obstacle.light:
            break
    return None, obstacle


def lightest(chain: Chain, stratum: Stratum, joints: Sequence[int], work: Work) -> ZeroMinor | None:
    """Of all minors of some screws, in the frames of all links, the one with the least to split at."""
    obstacles = []
    for k in range(1, chain.n):
        work.check()
        _, obstacle = independent(chain, k, stratum, joints, work)
        if obstacle is not None:
            obstacles += [obstacle]
    return min(obstacles, key=lambda weighed: weighed.weight, default=None)


def independent(
    chain: Chain, frame: int, stratum: Stratum, joints: Sequence[int], work: Work
) -> tuple[IndependenceProof | None, ZeroMinor | None]:
    """A proof that screws are independent everywhere on a stratum, or the minor that comes closest to one."""
    columns = chain.screws(frame)
    chosen = each_entry(stratum.short, (columns[j - 1] for j in joints))
    minors = list(_minors(stratum, chosen, work))
    proofs = [IndependenceProof("minor", frame, (rows,), (minor,)) for rows, minor, zeros in minors if not any(zeros)]
    if proofs:
        return min(proofs, key=lambda proof: (len(proof.polynomials[0]), proof.polynomials[0].total_degree())), None
    if not minors:
        return None, None
    if len(joints) <= GRAM:
        gram = _gram(stratum, chosen, work)
    else:
        gram = None
    if gram is not None:
        return IndependenceProof("gram", frame, (), (gram,)), None
    minors.sort(key=lambda minor: _weight(minor[2]))
    for size in (2, 3):
        for tried in combinations(minors[:TOGETHER_AT_MOST], size):
            if all(_no_common(atoms) for atoms in zip(*(zeros for *_, zeros in tried), strict=True)):
                rows, polynomials, _ = zip(*tried, strict=True)
                return IndependenceProof("minors", frame, rows, polynomials), None
    _, minor, zeros = minors[0]
    return None, ZeroMinor(_weight(zeros), all(atom.is_pin for atom in entries(zeros)), minor)


def _minors(
    stratum: Stratum, chosen: Columns, work: Work
) -> Iterator[tuple[tuple[int, ...], Polynomial, list[tuple[Atom, ...]]]]:
    """(rows, minor, its zeros on each piece) of the minors of some screws that vanish on no whole piece."""
    for rows in combinations(range(6), len(chosen)):
        work.check()
        minor = stratum.short(stratum.ring.determinant(submatrix(chosen, range(len(chosen)), rows)))
        if minor != 0:
            zeros = _zeros(stratum, minor, work)
        else:
            zeros = None
        if zeros is not None:
            yield rows, minor, zeros


def _weight(zeros: Sequence[Sequence[Atom]]) -> int:
    return sum(atom.weight for atom in entries(zeros))


def _zeros(stratum: Stratum, p: Polynomial, work: Work) -> list[tuple[Atom, ...]] | None:
    """Per piece the atoms under which p may vanish; None where it vanishes on a whole piece."""
    zeros = []
    for piece in stratum.pieces:
        atoms = atoms_on(piece, Equality((), p))
        if atoms is None or (piece.several and vanishes(piece, p, work.rng)):
            return None
        zeros.append(atoms)
    return zeros


def _gram(stratum: Stratum, chosen: Columns, work: Work) -> Polynomial | None:
    """|KᵀK| where it has no zero on the stratum."""
    ring = stratum.ring
    products = [
        [stratum.short(ring.reduce(sum((x * y for x, y in zip(a, b, strict=True)), ring.zero))) for b in chosen]
        for a in chosen
    ]
    determinant = stratum.short(ring.determinant(products))
    if determinant != 0:
        zeros = _zeros(stratum, determinant, work)
    else:
        zeros = None
    if zeros is not None and not any(zeros):
        return determinant
    return None


def _no_common(sets: Sequence[Sequence[Atom]]) -> bool:
    """Whether no choice of one atom from each set can hold at once: two pin one joint at different angles."""
    return all(
        any(a.is_pin and b.is_pin and a.joint == b.joint and a.value != b.value for a, b in combinations(choice, 2))
        for choice in product(*sets)
    )


class Basic(NamedTuple):
    """Six screws and their determinant on a stratum.

    Attributes:
        joints: their numbers.
        product: the determinant, taken apart.
    """

    joints: tuple[int, ...]
    product: VanishingProduct


@dataclass(frozen=True)
class Case:
    """One node of the hand calculation.

    Attributes:
        number: "1", "1.2", …; "" for the start.
        stratum: where it holds.
        joints: numbers of the screws that are left.
        dependence: of the screw suppressed in it; None where none is.
        basic: the six screws whose determinant is taken next; None where there is none to take.
        cases: what it falls into.
        split: whether the cases are there because no screw is dependent everywhere, not for a determinant's factors.
        family: number (from 1) of the family of singular configurations that the case is; 0 where it is none.
        ranks: of a family every rank of all screws found at random points of it modulo p, ascending.
    """

    number: str
    stratum: Stratum
    joints: tuple[int, ...]
    dependence: ScrewDependence | None = None
    basic: Basic | None = None
    cases: tuple[Case, ...] = ()
    split: bool = False
    family: int = 0
    ranks: tuple[int, ...] = ()

    @property
    def equalities(self) -> tuple[Polynomial, ...]:
        """Trigonometric polynomials that vanish, as they read with pinned joints at their angles."""
        return self.stratum.equations_with_pins


@dataclass(frozen=True)
class Suppression:
    """What dependent-screw suppression found.

    Attributes:
        chain: the arm over the exact ring.
        frame: link in whose frame (z along its axis, x along the normal after it) the screws are written.
        frame_asked, basic_asked: whether that frame and the basic screws were asked for.
        sixes: every six screws that could be basic, and the terms of their determinant; 0 where it vanishes on a piece.
        columns: the screws (v; ω) there.
        start: the first case, which holds all others.
        families: disjoint; together, with what is `left`, every singular configuration.
        assumptions: polynomials in lengths alone (trigonometric ring) that were taken for ≠ 0.
        left: what was not finished: "time", "full rank" (all six freedoms are left), "no point" or "empty" (no point of
            the case, or of a piece, was met), "determinant" (of the basic screws); and the case.
    """

    chain: Chain
    frame: int
    frame_asked: bool
    basic_asked: bool
    sixes: tuple[tuple[tuple[int, ...], int], ...]
    columns: list[list[Polynomial]]
    start: Case
    families: tuple[Case, ...]
    assumptions: tuple[Polynomial, ...]
    left: tuple[tuple[str, Case], ...]

    @property
    def complete(self) -> bool:
        """Whether nothing was left unfinished."""
        return not self.left

    @property
    def basic(self) -> tuple[int, ...]:
        """The basic screws of step 1; empty where the time was up before it."""
        if self.start.basic is not None:
            return self.start.basic.joints
        return ()

    @property
    def determinant(self) -> str:
        """The determinant of the basic screws, factored, as text; empty as `basic`."""
        basic = self.start.basic
        if basic is None:
            return ""
        ring, p = self.chain.ring, basic.product.polynomial
        return Value(ring, p, ring.factor(p)).text()


def suppress(
    chain: Chain,
    *,
    frame: int | None = None,
    basic: Sequence[int] | None = None,
    seconds: float = 60.0,
    seed: int = 0,
) -> Suppression:
    """Derive the singular configurations of an arm as disjoint families (KG).

    Args:
        chain: from `exact_chain`, at least six joints, all six rows of the task.
        frame: link 1 … n − 1 whose frame the screws are written in; None is the one with the fewest terms.
        basic: numbers of the six basic screws of step 1; None chooses: with a planar or spherical triple, contiguous,
            fewest terms.
        seconds: time limit; cases that were not finished are named in `left`.
        seed: of the random points modulo p.

    Raises:
        TaskError: not all six rows, fewer than six joints, or the screws never span all six freedoms.
        OptionError: no such frame or basic screws, or basic screws that are always dependent.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> found = suppress(exact_chain(open_robot("puma560")))
        >>> [(family.stratum.equalities, family.stratum.inequalities) for family in found.families[:2]]
        [((s5,), ()), ((s3*a3 + c3*d4,), (s5,))]
    """
    if chain.task.rows != (0, 1, 2, 3, 4, 5) or chain.n < 6:
        raise TaskError(
            "dependent-screw suppression is for six rows and at least six joints",
            where=f"robot {chain.robot.name!r}",
            got=f"{chain.task.m} rows, {chain.n} joints",
            mend="another method",
        )
    check_basic(chain, basic, frame)
    return _Recursion(chain, frame, basic, Work(seconds, seed)).run()


class _Recursion:
    """The recursion, with what it gathers on the way."""

    def __init__(self, chain: Chain, frame: int | None, basic: Sequence[int] | None, work: Work) -> None:
        self.chain, self.ring, self.frame_asked = chain, chain.ring, frame is not None
        if frame is None:
            self.frame = chain.frame
        else:
            self.frame = frame
        self.columns = chain.screws(self.frame)
        self.asked = tuple(sorted(basic)) if basic is not None else None
        self.work = work
        self.sixes: list[tuple[tuple[int, ...], int]] = []
        self.families: list[Case] = []
        self.left: list[tuple[str, Case]] = []

    def run(self) -> Suppression:
        whole = Stratum.whole(self.ring, self.work.assumed)
        everything = tuple(range(1, self.chain.n + 1))
        if max(Sampled(self.columns, whole, self.work.rng).ranks(everything)) < 6:
            raise TaskError(
                "the screws never span all six freedoms: every configuration is singular",
                where=f"robot {self.chain.robot.name!r}",
                mend="a task with the rows that the arm can serve",
            )
        start = Case("", whole, everything)
        try:
            start = self.determinant(start)
        except OutOfTime:
            self.left.append(("determinant", start))
        assumed = tuple(
            letters_polynomial(self.ring, f)
            for f in self.work.assumed.values()
            if len(f) > 1 and not plainly_positive(self.ring, f)  # a length alone is not zero
        )
        return Suppression(
            self.chain, self.frame, self.frame_asked, self.asked is not None, tuple(self.sixes), self.columns, start,
            tuple(self.families), assumed, tuple(self.left),
        )  # fmt: skip

    def determinant(self, case: Case) -> Case:
        """Step 1 with the screws that are left: a case for each factor of the determinant of six of them."""
        first = not case.number
        options = self.determinants(case.stratum, case.joints, self.asked if first else None)
        if first and self.asked is None:
            self.sixes = [(six, len(p) if self.nowhere_zero(case.stratum, p) else 0) for six, p in options]
        basic = self.choose(case.stratum, options)
        if basic is None and first:
            raise OptionError("these basic screws are always dependent", where="basic", got=str(self.asked))
        if basic is None:
            zero = all(case.stratum.vanishes(p, self.work.rng) for _, p in options)
            if zero:
                return self.family(case)
            return self.split_pieces(case)
        self.assume(basic.product)
        return self.branch(replace(case, basic=basic), basic.product.factors)

    def determinants(
        self, stratum: Stratum, joints: Sequence[int], asked: tuple[int, ...] | None
    ) -> list[tuple[tuple[int, ...], Polynomial]]:
        """The determinant of every six of these screws, or of the six asked for, as it reads on a stratum."""
        short = {j: [stratum.short(x) for x in self.columns[j - 1]] for j in joints}
        determinants = []
        for six in combinations(joints, 6) if asked is None else (asked,):
            self.work.check()
            rows = [[short[j][r] for j in six] for r in range(6)]
            determinants.append((six, stratum.short(self.ring.determinant(rows))))
        return determinants

    def nowhere_zero(self, stratum: Stratum, p: Polynomial) -> bool:
        """Whether a polynomial vanishes on no whole piece."""
        return p != 0 and not any(vanishes(piece, p, self.work.rng) for piece in stratum.pieces)

    def choose(self, stratum: Stratum, options: Sequence[tuple[tuple[int, ...], Polynomial]]) -> Basic | None:
        """The best six by KG's conditions: with a triple that is one joint, in a row, with the fewest terms."""
        known = [set(joints) for joints, _ in triples(self.chain)]

        def place(option: tuple[tuple[int, ...], Polynomial]) -> tuple[int, ...]:
            six, p = option
            return (not any(joints <= set(six) for joints in known), six[-1] - six[0], len(p), -six[0])

        for six, p in sorted(options, key=place):
            self.work.check()
            if self.nowhere_zero(stratum, p):
                product = factor_on_stratum(stratum, p)
            else:
                product = None
            if product is not None:
                return Basic(six, product)
        return None

    def branch(
        self, case: Case, factors: Sequence[Equality], first: tuple[Case, ...] = ()
    ) -> Case:
        """After some first cases, a case for each factor = 0 with the earlier ones ≠ 0."""
        rest, cases = case.stratum, list(first)
        for f in factors:
            vanishing, rest = self.drop_empty_pieces(rest.meet(f)), rest.avoid(f)
            if vanishing.pieces:
                cases.append(self.finish(_next_inside(case, vanishing, cases)))
        return replace(case, cases=tuple(cases))

    def finish(self, case: Case) -> Case:
        """The case followed to its end, or named in `left` where the time is up."""
        try:
            self.work.check()
            if max(len(piece.equations) for piece in case.stratum.pieces) > DEEPEST:
                raise OutOfTime
            return self.suppress_screw(case)
        except OutOfTime:
            self.left.append(("time", case))
            return case

    def suppress_screw(self, case: Case) -> Case:
        """Step 2: suppress a dependent screw and go on with the rest."""
        if not case.stratum.regular:
            return self.split_pieces(case)
        if len(case.joints) == 6:
            return self.family(case)
        sampled = Sampled(self.columns, case.stratum, self.work.rng)
        mixed = sampled.joints_of_mixed_rank(case.joints)
        if mixed is not None:
            return self.split_at_minor(case, lightest(self.chain, case.stratum, mixed, self.work))
        dependence, obstacle = find(self.chain, self.frame, case.stratum, sampled, case.joints, self.work)
        if dependence is not None:
            if dependence.proof is not None:
                for pins in case.stratum.combinations:
                    for p in dependence.proof.polynomials:
                        for f, _ in self.ring.factor(self.ring.at(p, pins)).letters:
                            self.work.assume(f)
            left = tuple(j for j in case.joints if j != dependence.screw)
            return self.determinant(replace(case, joints=left, dependence=dependence))
        return self.split_at_minor(case, obstacle)

    def split_at_minor(self, case: Case, obstacle: ZeroMinor | None) -> Case:
        """Split a case at the zeros of a minor."""
        if obstacle is not None:
            product = factor_on_stratum(case.stratum, obstacle.minor)
        else:
            product = None
        if product is None or not product.factors:
            return self.split_pieces(case)
        self.assume(product)
        return self.split(case, product.factors)

    def split_pieces(self, case: Case) -> Case:
        """Split a case whose pieces behave differently: by a condition that holds on some of them only."""
        stratum = case.stratum
        atoms = [self.ring.pin(j, value) for piece in stratum.pieces for j, value in piece.pins.items()]
        atoms += map(self.ring.atom, flat_map(lambda piece: piece.equations, stratum.pieces))
        whole = [(condition, [condition]) for condition in join_pins(self.ring, list(dict.fromkeys(atoms)))]
        pairs = ((p.whole, atom) for p in join_pins(self.ring, atoms) for atom in p.atoms)
        single = [(Equality((atom,), p), join_pins(self.ring, [atom])) for p, atom in pairs]
        for condition, factors in (*whole, *single):
            holds = [atoms_on(piece, condition) is None for piece in stratum.pieces]
            if any(holds) and not all(holds):
                return self.split(case, factors)
        raise OutOfTime  # one piece, no proof and nothing to split at: named among what is left

    def split(self, case: Case, factors: Sequence[Equality]) -> Case:
        """A case with all factors ≠ 0, and one for each factor = 0 with the earlier ones ≠ 0."""
        case = replace(case, split=True)
        rest = case.stratum
        for f in factors:
            rest = rest.avoid(f)
        rest = self.drop_empty_pieces(rest)
        first: tuple[Case, ...] = ()
        if rest.pieces:  # the larger part, so that it is done before the time is up
            first = (self.finish(_next_inside(case, rest, ())),)
        return self.branch(case, factors, first)

    def family(self, case: Case) -> Case:
        """The case is a family, if the rank is lost at all points of it that are met; else it is told.

        Conditions of which only some of the zeros were met may hold where the screws span all six freedoms.
        """
        sampled = Sampled(self.columns, case.stratum, self.work.rng)
        ranks = tuple(sorted(sampled.ranks(range(1, self.chain.n + 1))))
        if not ranks or ranks[-1] == 6:
            self.left.append(("full rank" if ranks else "no point", case))
            return case
        self.families.append(replace(case, family=len(self.families) + 1, ranks=ranks))
        return self.families[-1]

    def drop_empty_pieces(self, stratum: Stratum) -> Stratum:
        """The stratum without pieces that lie in the excluded set, or on which no point is found, which is told."""
        kept = []
        for piece in stratum.pieces:
            if piece.point(self.work.rng) is not None:
                kept.append(piece)
            elif replace(piece, nonzero=()).point(self.work.rng) is None:
                self.left.append(("empty", Case("", replace(stratum, pieces=(piece,)), ())))
        return replace(stratum, pieces=tuple(kept))

    def assume(self, product: VanishingProduct) -> None:
        for f in product.letters:
            self.work.assume(f)


def _next_inside(case: Case, stratum: Stratum, before: Sequence[Case]) -> Case:
    """The next case inside one, with the same screws."""
    number = f"{case.number}." * bool(case.number) + str(len(before) + 1)
    return Case(number, stratum, case.joints)
