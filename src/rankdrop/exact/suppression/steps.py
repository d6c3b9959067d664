"""Dependent-screw suppression told step by step, as KG does it by hand: cases, families, and the text of each step.

"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product

from rankdrop.exact.algebra.polynomial import Polynomial
from rankdrop.exact.algebra.ring import Ring, letters_polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import triples
from rankdrop.exact.suppression.dependence import Dependence, Proof
from rankdrop.exact.suppression.factors import Basic, Product
from rankdrop.exact.suppression.stratum import Stratum
from rankdrop.exact.writing.notation import SUPERSCRIPT, Step
from rankdrop.exact.writing.value import condition_text, text_of


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
        family: number (from 1) of the family that the case is; 0 where it is none.
    """

    number: str
    stratum: Stratum
    joints: tuple[int, ...]
    dependence: Dependence | None = None
    basic: Basic | None = None
    cases: tuple[Case, ...] = ()
    split: bool = False
    family: int = 0


@dataclass(frozen=True)
class SuppressedFamily:
    """One family of singular configurations.

    Attributes:
        number: from 1.
        stratum: its conditions = 0 and ≠ 0.
        chain: the cases on the way to it, from the start to itself.
        ranks: every rank of all screws found at random points of it modulo p, ascending.
    """

    number: int
    stratum: Stratum
    chain: tuple[Case, ...]
    ranks: tuple[int, ...]

    @property
    def equalities(self) -> tuple[Polynomial, ...]:
        """Trigonometric polynomials that vanish, as they read with pinned joints at their angles."""
        return self.stratum.closed

    @property
    def inequalities(self) -> tuple[Polynomial, ...]:
        """Trigonometric polynomials that do not vanish."""
        return self.stratum.open


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
    families: tuple[SuppressedFamily, ...]
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
        """The derivation step by step, as it is done by hand."""
        return steps(self)


def steps(suppression: Suppression) -> tuple[Step, ...]:
    """The whole derivation: screws, basic determinant, every case with its dependent screw, families."""
    found = [Step("Screws", tuple(_screws(suppression)))]
    if suppression.start.basic is not None:
        found.append(Step("Step 1: the determinant of the basic screws", tuple(_first(suppression))))
        found += _cases(suppression, suppression.start)
    found.append(Step("Families", tuple(_families(suppression))))
    if suppression.left:
        found.append(Step("Not finished", suppression.left))
    return tuple(found)


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
    yield f"basic screws: {_names(joints)}, independent in general{_triples(chain, joints)}"
    if chain.n > 6:
        yield f"why these: {start.basic.reason}"
    yield f"|{_names(joints)}| = {product_text(chain.ring, start.basic.product)}"
    if chain.n == 6:
        yield "with six joints there is no other screw: the arm is singular where a factor is zero"
    yield from _branches(start)


def _triples(chain: Chain, joints: Sequence[int]) -> str:
    said = [f"{_joints(three)} are a {kind} joint" for three, kind in triples(chain) if set(three) <= set(joints)]
    return "; " + ", ".join(said) if said else ""


def _cases(suppression: Suppression, case: Case) -> Iterator[Step]:
    """A step for every case below that is not a family yet, in order."""
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
    for j in case.dependence.circuit:
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
        yield f"family {family.number}: {conditions_text(family.stratum)}"
    yield from _disjointness(suppression)
    for p in suppression.assumptions:
        yield f"assumed: {text_of(ring, p)} ≠ 0"


def _disjointness(suppression: Suppression) -> Iterator[str]:
    """Why no two families meet: conditions that hold on some and not on others, until every pair is told apart."""
    families, ring = suppression.families, suppression.chain.ring
    apart = ((one.number, two.number, one.stratum.apart(two.stratum)) for one, two in combinations(families, 2))
    waiting = {(one, two): p for one, two, p in apart if p is not None}
    if waiting:
        yield "no two of them meet:"
    while waiting:
        p = next(iter(waiting.values()))
        zero = [family.number for family in families if p in family.stratum.equalities]
        other = [family.number for family in families if p in family.stratum.inequalities]
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
