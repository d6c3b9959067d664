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
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.algebra.field import rank, residues
from rankdrop.exact.algebra.polynomial import Atom, Equality, Polynomial
from rankdrop.exact.algebra.ring import Ring, letters_polynomial
from rankdrop.exact.algebra.solving import plainly_positive
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import check_basic, triples
from rankdrop.exact.notation import SUPERSCRIPT, Step
from rankdrop.exact.stratum import (
    Basic,
    Product,
    Stratum,
    atoms_on,
    choose,
    determinants,
    joined,
    taken_apart,
    vanishes,
    why,
)
from rankdrop.exact.writing import condition_text, text_of

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

    def mixed(self, joints: Sequence[int]) -> tuple[int, ...] | None:
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
    dependence: Dependence | None = None
    basic: Basic | None = None
    cases: tuple[Case, ...] = ()
    split: bool = False
    family: int = 0
    ranks: tuple[int, ...] = ()

    @property
    def equalities(self) -> tuple[Polynomial, ...]:
        """Trigonometric polynomials that vanish, as they read with pinned joints at their angles."""
        return self.stratum.closed


ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")
LONG = 60
"""Terms of a screw's entries above which it is not written out once more with a case's angles put in."""


@dataclass(frozen=True)
class Suppression:
    """What dependent-screw suppression found.

    Attributes:
        chain: the arm over the exact ring.
        frame: link in whose frame (z along its axis, x along the normal after it) the screws are written.
        frame_reason: why that one.
        columns: the screws (v; ω) there.
        start: the first case, which holds all others.
        families: disjoint; together, with what is `left`, every singular configuration.
        assumptions: polynomials in lengths alone (trigonometric ring) that were taken for ≠ 0.
        left: what was not finished, in words.
    """

    chain: Chain
    frame: int
    frame_reason: str
    columns: list[list[Polynomial]]
    start: Case
    families: tuple[Case, ...]
    assumptions: tuple[Polynomial, ...]
    left: tuple[str, ...]

    @property
    def complete(self) -> bool:
        """Whether nothing was left unfinished."""
        return not self.left

    @property
    def basic(self) -> tuple[int, ...]:
        """The basic screws of step 1; empty where the time was up before it."""
        return self.start.basic.joints if self.start.basic is not None else ()

    @property
    def determinant(self) -> str:
        """The determinant of the basic screws, factored, as text; empty as `basic`."""
        return product_text(self.chain.ring, self.start.basic.product) if self.start.basic is not None else ""

    @property
    def factors(self) -> tuple[Polynomial, ...]:
        """The factors of that determinant which depend on the configuration."""
        return tuple(f.whole for f in self.start.basic.product.factors) if self.start.basic is not None else ()

    def steps(self) -> tuple[Step, ...]:
        """The derivation as it is done by hand: screws, basic determinant, cases with dependent screws, families."""
        found = [Step("Screws", tuple(_screws(self)))]
        if self.start.basic is not None:
            found.append(Step("Step 1: the determinant of the basic screws", tuple(_first(self))))
            found += _cases(self, self.start)
        found.append(Step("Families", tuple(_families(self))))
        return (*found, Step("Not finished", self.left)) if self.left else tuple(found)


def _screws(suppression: Suppression) -> Iterator[str]:
    ring = suppression.chain.ring
    yield f"$j = (v; ω) of joint j in the frame of link {suppression.frame}, z along its axis, x along the next normal"
    yield f"why this frame: {suppression.frame_reason}"
    for j, column in enumerate(suppression.columns, 1):
        yield _screw(j, [text_of(ring, x) for x in column])


def _screw(j: int, entries: Sequence[str]) -> str:
    return f"${j} = ({', '.join(entries[:3])}; {', '.join(entries[3:])})"


def _first(suppression: Suppression) -> Iterator[str]:
    start, chain = suppression.start, suppression.chain
    assert start.basic is not None
    joints = start.basic.joints
    known = ((three, kind) for three, kind in triples(chain) if set(three) <= set(joints))
    said = ", ".join(f"{_joints(three)} are a {kind} joint" for three, kind in known)
    yield f"basic screws: {_names(joints)}, independent in general{'; ' * bool(said) + said}"
    if chain.n > 6:
        yield f"why these: {start.basic.reason}"
    yield f"|{_names(joints)}| = {product_text(chain.ring, start.basic.product)}"
    if chain.n == 6:
        yield "with six joints there is no other screw: the arm is singular where a factor is zero"
    yield from _branches(start)


def _cases(suppression: Suppression, case: Case) -> Iterator[Step]:
    for inner in case.cases:
        lines = tuple(_case(suppression, inner))
        if lines:
            yield Step(f"Case {inner.number}: {conditions_text(inner.stratum)}", lines)
        yield from _cases(suppression, inner)


def _case(suppression: Suppression, case: Case) -> Iterator[str]:
    ring, dependence = suppression.chain.ring, case.dependence
    if dependence is not None:
        yield from _put_in(suppression, case)
        if not dependence.on:
            yield f"${dependence.screw} is zero"
        else:
            assert dependence.proof is not None
            if len(dependence.on) == 1:
                yield f"${dependence.screw} is a multiple of {_names(dependence.on)}, which is not zero:"
            else:
                yield f"${dependence.screw} is a combination of {_names(dependence.on)}, which are independent:"
            yield from _proof(suppression, dependence.proof, dependence.on)
        yield f"${dependence.screw} is suppressed; left: {_names(case.joints)}"
    if case.basic is not None:
        yield f"|{_names(case.basic.joints)}| = {product_text(ring, case.basic.product)}"
        if not case.cases:
            yield "which has no zero here: no singular configuration"
    if case.split:
        yield "no screw is a combination of the same others everywhere here: the case is split"
    if case.family and len(case.joints) > 6:
        yield "every determinant of six of the screws that are left is zero here"
    yield from _branches(case)


def _put_in(suppression: Suppression, case: Case) -> Iterator[str]:
    """The screws of the circuit with the case's angles put in, where that changes short ones."""
    assert case.dependence is not None
    ring = suppression.chain.ring
    for j in sorted((case.dependence.screw, *case.dependence.on)):
        column = suppression.columns[j - 1]
        short = [case.stratum.short(x) for x in column]
        if short != column and sum(map(len, short)) <= LONG:
            yield f"here {_screw(j, [text_of(ring, x) for x in short])}"


def _proof(suppression: Suppression, proof: Proof, on: Sequence[int]) -> Iterator[str]:
    ring = suppression.chain.ring
    there = "" if proof.frame == suppression.frame else f" in the frame of link {proof.frame}"
    if proof.kind == "gram":
        yield f"their Gram determinant{there} is {text_of(ring, proof.polynomials[0])} ≠ 0"
        return
    for rows, minor in zip(proof.rows, proof.polynomials, strict=True):
        told = " ≠ 0" if proof.kind == "minor" else ""
        names = " ".join(ROWS[r] for r in rows)
        yield f"|{_names(on)}| of rows {names}{there} is {text_of(ring, minor)}{told}"
    if proof.kind == "minors":
        yield "which have no common zero here"


def _branches(case: Case) -> Iterator[str]:
    for inner in case.cases:
        name = f"family {inner.family}" if inner.family else f"case {inner.number}"
        yield f"{name}: {conditions_text(inner.stratum)}"


def _families(suppression: Suppression) -> Iterator[str]:
    ring = suppression.chain.ring
    for family in suppression.families:
        yield f"family {family.family}: {conditions_text(family.stratum)}"
    yield from _disjointness(suppression)
    for p in suppression.assumptions:
        yield f"assumed: {text_of(ring, p)} ≠ 0"


def _disjointness(suppression: Suppression) -> Iterator[str]:
    """Why no two families meet: conditions that hold on some and not on others, until every pair is told apart."""
    families, ring = suppression.families, suppression.chain.ring
    apart = ((one.family, two.family, one.stratum.apart(two.stratum)) for one, two in combinations(families, 2))
    waiting = {(one, two): p for one, two, p in apart if p is not None}
    if waiting:
        yield "no two of them meet:"
    while waiting:
        p = next(iter(waiting.values()))
        zero = [family.family for family in families if p in family.stratum.equalities]
        other = [family.family for family in families if p in family.stratum.inequalities]
        yield f"{condition_text(ring, p)} in {_joints(zero)}, not in {_joints(other)}"
        told = {*product(zero, other), *product(other, zero)}
        waiting = {pair: q for pair, q in waiting.items() if pair not in told}


def _names(joints: Sequence[int]) -> str:
    return " ".join(f"${j}" for j in joints)


def _joints(joints: Sequence[int]) -> str:
    return ", ".join(map(str, joints))


def conditions_text(stratum: Stratum, most: int | None = None) -> str:
    """The conditions of a stratum in one line; polynomials of more than `most` terms are not written out."""
    parts = []
    for polynomials, sign in ((stratum.closed, "="), (stratum.open, "≠")):
        for p in polynomials:
            long = most is not None and len(p) > most
            parts.append(f"({len(p)} terms) {sign} 0" if long else condition_text(stratum.ring, p, sign))
    return ", ".join(parts) or "everywhere"


def product_text(ring: Ring, product: Product) -> str:
    """A determinant as the product of its factors, or as it is where that is not how it factors."""
    if product.outer is None:
        return text_of(ring, product.polynomial)
    factors = [*((letters_polynomial(ring, f), power) for f, power in product.letters), *product.written]
    outer = text_of(ring, product.outer)
    negative = outer.startswith("−")
    outer = outer.removeprefix("−")
    found = [outer] if outer != "1" or not factors else []
    for f, power in factors:
        text = text_of(ring, f)
        if text.startswith("−"):
            text = text_of(ring, -f)
            negative ^= power % 2 == 1
        text = f"({text})" if " + " in text or " − " in text else text
        found.append(text if power == 1 else text + str(power).translate(SUPERSCRIPT))
    return ("−" if negative else "") + " ".join(found)


Progress = Callable[[str, int, int], None]
"""Called with (what is done, cases done, cases known so far)."""
DEEPEST = 4
"""Most equations of a piece beside its pinned joints: more do not occur in an arm of eight joints without a fault."""
SHORT = 30
"""Most terms of a polynomial that is written out where something is said to be left."""


def suppress(
    chain: Chain,
    *,
    frame: int | None = None,
    basic: Sequence[int] | None = None,
    seconds: float = 60.0,
    seed: int = 0,
    progress: Progress | None = None,
) -> Suppression:
    """Derive the singular configurations of an arm as disjoint families (KG).

    Args:
        chain: from `exact_chain`, at least six joints, all six rows of the task.
        frame: link 1 … n − 1 whose frame the screws are written in; None is the one with the fewest terms.
        basic: numbers of the six basic screws of step 1; None chooses: with a planar or spherical triple, contiguous,
            fewest terms.
        seconds: time limit; cases that were not finished are named in `left`.
        seed: of the random points modulo p.
        progress: called now and then.

    Raises:
        TaskError: not all six rows, fewer than six joints, or the screws never span all six freedoms.
        OptionError: no such frame or basic screws, or basic screws that are always dependent.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> found = suppress(exact_chain(open_robot("puma560")))
        >>> [conditions_text(family.stratum) for family in found.families[:2]]
        ['s5 = 0', 'a3 s3 + d4 c3 = 0, s5 ≠ 0']
    """
    if chain.task.rows != (0, 1, 2, 3, 4, 5) or chain.n < 6:
        raise TaskError(
            "dependent-screw suppression is for six rows and at least six joints",
            where=f"robot {chain.robot.name!r}",
            got=f"{chain.task.m} rows, {chain.n} joints",
            mend="another method",
        )
    reason = _frame_reason(chain) if frame is None else "asked for"
    frame = chain.frame if frame is None else frame
    if not 1 <= frame < chain.n:
        raise OptionError("no such link frame", where="frame", got=str(frame), allowed=f"1 … {chain.n - 1}")
    check_basic(chain, basic)
    return _Derivation(chain, frame, reason, basic, Work(seconds, seed), progress).run()


class _Derivation:
    """The recursion, with what it gathers on the way."""

    def __init__(
        self,
        chain: Chain,
        frame: int,
        reason: str,
        basic: Sequence[int] | None,
        work: Work,
        progress: Progress | None,
    ) -> None:
        self.chain, self.ring, self.frame, self.frame_reason = chain, chain.ring, frame, reason
        self.columns = chain.screws(frame)
        self.asked = tuple(sorted(basic)) if basic is not None else None
        self.work, self.progress = work, progress
        self.families: list[Case] = []
        self.left: list[str] = []
        self.done, self.known = 0, 1

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
            self.left.append("the determinant of the basic screws")
        assumed = tuple(
            letters_polynomial(self.ring, f)
            for f in self.work.assumed.values()
            if len(f) > 1 and not plainly_positive(self.ring, f)  # a length alone is not zero
        )
        found, left = tuple(self.families), tuple(self.left)
        return Suppression(self.chain, self.frame, self.frame_reason, self.columns, start, found, assumed, left)

    def determinant(self, case: Case) -> Case:
        """Step 1 with the screws that are left: a case for each factor of the determinant of six of them."""
        first = not case.number
        options = determinants(self.columns, case.stratum, case.joints, self.asked if first else None, self.work)
        basic = choose(self.chain, case.stratum, options, self.work)
        if first and basic is not None:
            reason = "asked for" if self.asked else why(self.chain, case.stratum, options, basic.joints, self.work)
            basic = replace(basic, reason=reason)
        if basic is None:
            if first:
                raise OptionError("these basic screws are always dependent", where="basic", got=str(self.asked))
            if all(case.stratum.vanishes(p, self.work.rng) for _, p in options):
                return self.family(case)
            return self.apart(case)
        self.assume(basic.product)
        case = replace(case, basic=basic)
        return self.branch(case, basic.product.factors)

    def branch(
        self, case: Case, factors: Sequence[Equality], first: tuple[Case, ...] = ()
    ) -> Case:
        """After some first cases, a case for each factor = 0 with the earlier ones ≠ 0."""
        rest, cases = case.stratum, list(first)
        self.known += len(factors)
        for f in factors:
            here, rest = self.inhabited(rest.meet(f)), rest.avoid(f)
            if here.pieces:
                cases.append(self.finished(_inside(case, here, cases)))
            self.done += 1
            if self.progress is not None:
                self.progress("dependent-screw suppression", self.done, self.known)
        return replace(case, cases=tuple(cases))

    def finished(self, case: Case) -> Case:
        """The case followed to its end, or named in `left` where the time is up."""
        try:
            self.work.check()
            if max(len(piece.equations) for piece in case.stratum.pieces) > DEEPEST:
                raise OutOfTime
            return self.suppressed(case)
        except OutOfTime:
            self.left.append(f"case {case.number}: {conditions_text(case.stratum, SHORT)}")
            return case

    def suppressed(self, case: Case) -> Case:
        """Step 2: suppress a dependent screw and go on with the rest."""
        if not case.stratum.regular:
            return self.apart(case)
        if len(case.joints) == 6:
            return self.family(case)
        sampled = Sampled(self.columns, case.stratum, self.work.rng)
        mixed = sampled.mixed(case.joints)
        if mixed is not None:
            return self.at(case, lightest(self.chain, case.stratum, mixed, self.work))
        found, obstacle = find(self.chain, self.frame, case.stratum, sampled, case.joints, self.work)
        if found is not None:
            if found.proof is not None:
                for pins in case.stratum.combinations:
                    for p in found.proof.polynomials:
                        for f, _ in self.ring.factor(self.ring.at(p, pins)).letters:
                            self.work.assume(f)
            left = tuple(j for j in case.joints if j != found.screw)
            return self.determinant(replace(case, joints=left, dependence=found))
        return self.at(case, obstacle)

    def at(self, case: Case, obstacle: Obstacle | None) -> Case:
        """Split a case at the zeros of a minor."""
        product = taken_apart(case.stratum, obstacle.minor) if obstacle is not None else None
        if product is None or not product.factors:
            return self.apart(case)
        self.assume(product)
        return self.split(case, product.factors)

    def apart(self, case: Case) -> Case:
        """Split a case whose pieces behave differently: by a condition that holds on some of them only."""
        stratum = case.stratum
        atoms = [self.ring.pin(j, value) for one in stratum.pieces for j, value in one.pins.items()]
        atoms += [self.ring.atom(f) for one in stratum.pieces for f in one.equations]
        whole = [(condition, [condition]) for condition in joined(self.ring, list(dict.fromkeys(atoms)))]
        pairs = ((p.whole, atom) for p in joined(self.ring, atoms) for atom in p.atoms)
        single = [(Equality((atom,), p), joined(self.ring, [atom])) for p, atom in pairs]
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
        rest = self.inhabited(rest)
        first: tuple[Case, ...] = ()
        if rest.pieces:  # the larger part, so that it is done before the time is up
            first = (self.finished(_inside(case, rest, ())),)
        return self.branch(case, factors, first)

    def family(self, case: Case) -> Case:
        """The case is a family, if the rank is lost at all points of it that are met; else it is told.

        Conditions of which only some of the zeros were met may hold where the screws span all six freedoms.
        """
        sampled = Sampled(self.columns, case.stratum, self.work.rng)
        ranks = tuple(sorted(sampled.ranks(range(1, self.chain.n + 1))))
        if not ranks or ranks[-1] == 6:
            met = "all six freedoms are left at points of it" if ranks else "no point of it was met"
            self.left.append(f"case {case.number}: {met}: {conditions_text(case.stratum, SHORT)}")
            return case
        self.families.append(replace(case, family=len(self.families) + 1, ranks=ranks))
        return self.families[-1]

    def inhabited(self, stratum: Stratum) -> Stratum:
        """The stratum without pieces that lie in the excluded set, or on which no point is found, which is told."""
        kept = []
        for piece in stratum.pieces:
            if piece.point(self.work.rng) is not None:
                kept.append(piece)
            elif replace(piece, nonzero=()).point(self.work.rng) is None:
                alone = replace(stratum, pieces=(piece,))
                self.left.append(f"no point modulo p was found on: {conditions_text(alone, SHORT)}")
        return replace(stratum, pieces=tuple(kept))

    def assume(self, product: Product) -> None:
        for f, _ in product.letters:
            self.work.assume(f)


def _frame_reason(chain: Chain) -> str:
    terms = ", ".join(f"link {k}: {sum(len(x) for c in chain.screws(k) for x in c)}" for k in range(1, chain.n))
    return f"the screws are shortest there; terms, multiplied out: {terms}"


def _inside(case: Case, stratum: Stratum, before: Sequence[Case]) -> Case:
    """The next case inside one, with the same screws."""
    number = f"{case.number}." * bool(case.number) + str(len(before) + 1)
    return Case(number, stratum, case.joints)
