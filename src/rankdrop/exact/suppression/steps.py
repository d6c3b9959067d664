"""Dependent-screw suppression told step by step, as KG does it by hand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Protocol

from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.suppression.basic_screws import triples
from rankdrop.exact.suppression.cases import Case, SuppressedFamily
from rankdrop.exact.suppression.dependence import Proof
from rankdrop.exact.writing.text_of import condition_text, conditions_text, product_text, text_of

ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")
LONG = 60
"""Terms of a screw's entries above which it is not written out once more with a case's angles put in."""


@dataclass(frozen=True)
class Step:
    """A heading and the lines under it.

    Attributes:
        title: heading.
        lines: sentences and formulas.
    """

    title: str
    lines: tuple[str, ...]


class Derived(Protocol):
    """What is read of a `Suppression`, whose attributes these are."""

    @property
    def chain(self) -> Chain:
        """The arm over the exact ring."""

    @property
    def frame(self) -> int:
        """Link in whose frame the screws are written."""

    @property
    def frame_reason(self) -> str:
        """Why that one."""

    @property
    def columns(self) -> list[list[Polynomial]]:
        """The screws (v; ω) there."""

    @property
    def start(self) -> Case:
        """The first case."""

    @property
    def families(self) -> tuple[SuppressedFamily, ...]:
        """The families found."""

    @property
    def assumptions(self) -> tuple[Polynomial, ...]:
        """Polynomials in lengths alone taken for ≠ 0."""

    @property
    def left(self) -> tuple[str, ...]:
        """What was not finished."""


def steps(suppression: Derived) -> tuple[Step, ...]:
    """The whole derivation: screws, basic determinant, every case with its dependent screw, families."""
    found = [Step("Screws", tuple(_screws(suppression)))]
    if suppression.start.basic is not None:
        found.append(Step("Step 1: the determinant of the basic screws", tuple(_first(suppression))))
        found += _cases(suppression, suppression.start)
    found.append(Step("Families", tuple(_families(suppression))))
    if suppression.left:
        found.append(Step("Not finished", suppression.left))
    return tuple(found)


def _screws(suppression: Derived) -> Iterator[str]:
    ring = suppression.chain.ring
    yield f"$j = (v; ω) of joint j in the frame of link {suppression.frame}, z along its axis, x along the next normal"
    yield f"why this frame: {suppression.frame_reason}"
    for j, column in enumerate(suppression.columns, 1):
        yield _screw(j, [text_of(ring, x) for x in column])


def _screw(j: int, entries: Sequence[str]) -> str:
    return f"${j} = ({', '.join(entries[:3])}; {', '.join(entries[3:])})"


def _first(suppression: Derived) -> Iterator[str]:
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


def _cases(suppression: Derived, case: Case) -> Iterator[Step]:
    """A step for every case below that is not a family yet, in order."""
    for inner in case.cases:
        lines = tuple(_case(suppression, inner))
        if lines:
            yield Step(f"Case {inner.number}: {conditions_text(inner.stratum)}", lines)
        yield from _cases(suppression, inner)


def _case(suppression: Derived, case: Case) -> Iterator[str]:
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


def _put_in(suppression: Derived, case: Case) -> Iterator[str]:
    """The screws of the circuit with the case's angles put in, where that changes short ones."""
    assert case.dependence is not None
    ring = suppression.chain.ring
    for j in case.dependence.circuit:
        column = suppression.columns[j - 1]
        short = [case.stratum.short(x) for x in column]
        if short != column and sum(map(len, short)) <= LONG:
            yield f"here {_screw(j, [text_of(ring, x) for x in short])}"


def _proof(suppression: Derived, proof: Proof, on: Sequence[int]) -> Iterator[str]:
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


def _families(suppression: Derived) -> Iterator[str]:
    ring = suppression.chain.ring
    for family in suppression.families:
        yield f"family {family.number}: {conditions_text(family.stratum)}"
    yield from _disjointness(suppression)
    for p in suppression.assumptions:
        yield f"assumed: {text_of(ring, p)} ≠ 0"


def _disjointness(suppression: Derived) -> Iterator[str]:
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
