"""Derivations of corank 1 in words, step by step, as they are done by hand."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import combinations, product

from rankdrop.algebra.matrix import count_terms
from rankdrop.algebra.polynomial import Equality, Polynomial
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import joint_list, triples
from rankdrop.exact.conjunctions import Conjunction, Note, SetDerivation, conditions_on
from rankdrop.exact.decoupling import Decoupling, parting_of
from rankdrop.exact.derivation import CorankOne
from rankdrop.exact.determinants import MinorChoice, minor_name
from rankdrop.exact.stratum import Stratum
from rankdrop.exact.suppression import Case, IndependenceProof, ScrewDependence, Suppression
from rankdrop.exact.tree import RankTree
from rankdrop.formula.notation import Step, Text
from rankdrop.formula.shortest import single_angles
from rankdrop.formula.sums import fourier
from rankdrop.formula.value import Value
from rankdrop.formula.writing import Condition, atoms_text, condition_text, count_alternatives, text_of
from rankdrop.lists import flat_map
from rankdrop.sections import Formula
from rankdrop.task import ROWS
from rankdrop.text.structure import form_sentence, parting_text, structure_sentences

READABLE = 30
"""Polynomials of more terms are told by their number of terms: nobody reads them."""
LONG = 60
"""Terms of a screw's entries above which it is not written out once more with a case's angles put in."""
WRITTEN = 40
"""Terms of a reciprocal screw up to which its elements are written."""
_SHOWN = 40  # conditions that are printed

_LEFT = {
    "time": "case {number}: {conditions}",
    "full rank": "case {number}: all six freedoms are left at points of it: {conditions}",
    "no point": "case {number}: no point of it was found: {conditions}",
    "empty": "no point modulo p was found on: {conditions}",
    "determinant": "the determinant of the basic screws",
}
"""What was left of a suppression."""

_NOTES = {
    "factors": "terms of det J: {terms}; different factors: {factors}",
    "squares": "det({product}) is the sum of the squares of {minors} minors: never negative, it vanishes without a "
    "change of sign, where all of them do and nowhere else; it needs no factors",
    "cofactors": "{minors} minors, {terms} terms together",
    "common": "common factors of the minors: {factors}",
    "together": "besides them {equations} equations hold together; their factors combine in {ways} ways",
    "arm": "arm: rank J11 < 3, {minors} minors in {conditions} conditions",
    "wrist": "wrist: rank [J21 N, J22] < 3, only where det J22 = 0, at two angles of joint {joint}: {conditions} "
    "conditions",
    "basic": "joints {joints} are taken first, as asked for",
    "choices": "the exceptional loci are treated apart, by {further} further choices of joints, {different} different "
    "ones in all",
    "cases": "where these minors vanish other ones are taken, in {further} further cases, of {different} choices of "
    "joints in all",
    "square": "where it vanishes det J does, too: nothing is left out",
    "pivots": "{cases} cases of pivots, {conditions} of them with singular configurations; some may be empty, and "
    "where a case holds no more than another one it is not left out",
    "cleared": "rows and columns are cleared by entries that are numbers: {rows} rows and {columns} columns remain, "
    "which lose rank where the Jacobian does",
    "block": "a block of order {order}: its determinant has {terms} terms",
    "rest": "besides the blocks {rows} rows and {columns} columns: {minors} minors vanish together",
}
"""What the methods note on the way."""


def steps_of(chain: Chain, derived: Decoupling | Suppression | SetDerivation | RankTree | None) -> tuple[Step, ...]:
    """The derivation of corank 1 as it is done by hand; long polynomials take seconds to be put shortly."""
    if isinstance(derived, Suppression):
        return tuple(_suppression(derived))
    if isinstance(derived, Decoupling):
        return Step("Structure", structure_sentences(chain)), Step("Decoupling", tuple(_decoupling(derived)))
    if isinstance(derived, SetDerivation):
        return (_method(derived),)
    how = "on each a minor of the order of its rank was factored, and the set cut by every factor"
    lines = () if derived is None else (f"{derived.visited} irreducible sets were derived: {how}",)
    return (Step("Rank tree", lines),) if lines else ()


def every_step(chain: Chain, derivation: CorankOne) -> tuple[Step, ...]:
    """The steps of corank 1, and of the higher coranks that were derived like it."""
    steps = [*steps_of(chain, derivation.derived)]
    for higher in derivation.higher:
        steps += steps_of(chain, higher.derived)
    return tuple(steps)


def _decoupling(decoupling: Decoupling) -> Iterator[str]:
    """Reason, point, blocks and parts."""
    yield f"{parting_text(parting_of(decoupling.chain))}."
    yield form_sentence(decoupling.form)
    for block in decoupling.blocks:
        yield f"{block.name}: rows {', '.join(block.rows)} of joints {joint_list(block.joints)}."
        if not block.parts:
            yield "  never singular"
        for part in block.parts:
            lost = part.statement or "; ".join(part.lost)
            yield f"  {part.text}: {part.name}" + (f": {lost}" if lost else "")


def _suppression(suppression: Suppression) -> Iterator[Step]:
    """Screws, basic determinant, cases with dependent screws, families, what is left."""
    ring = suppression.chain.ring
    if suppression.frame_asked:
        reason = "asked for"
    else:
        reason = _frames(suppression.chain)
    screws = (_screw(ring, j, column) for j, column in enumerate(suppression.columns, 1))
    where = f"in the frame of link {suppression.frame}, z along its axis, x along the next normal"
    yield Step("Screws", (f"$j = (v; ω) of joint j {where}", f"why this frame: {reason}", *screws))
    if suppression.start.basic is not None:
        yield Step("Step 1: the determinant of the basic screws", tuple(_first(suppression)))
        yield from _cases(suppression, suppression.start)
    yield Step("Families", tuple(_families(suppression)))
    if suppression.left:
        yield Step("Not finished", tuple(map(left_text, suppression.left)))


def _frames(chain: Chain) -> str:
    terms = ", ".join(f"link {k}: {count_terms(chain.screws(k))}" for k in range(1, chain.n))
    return f"the screws are shortest there; terms, multiplied out: {terms}"


def _screw(ring: Ring, j: int, column: Sequence[Polynomial]) -> str:
    entries = [text_of(ring, x) for x in column]
    return Formula(f"${j} = ({', '.join(entries[:3])}; {', '.join(entries[3:])})")


def _first(suppression: Suppression) -> Iterator[str]:
    joints, chain = suppression.basic, suppression.chain
    known = ((three, kind) for three, kind in triples(chain) if set(three) <= set(joints))
    said = ", ".join(f"{_joints(three)} are a {kind} joint" for three, kind in known)
    yield f"basic screws: {_names(joints)}, independent in general{'; ' * bool(said) + said}"
    if chain.n > 6:
        yield f"why these: {'asked for' if suppression.basic_asked else '; '.join(_choice(suppression))}"
    yield Formula(f"|{_names(joints)}| = {suppression.determinant}")
    if chain.n == 6:
        yield "with six joints there is no other screw: the arm is singular where a factor is zero"
    yield from _branches(suppression.start)


def _choice(suppression: Suppression) -> Iterator[str]:
    """KG's conditions (a), (b), (c), with how many sixes each leaves."""
    known, free = triples(suppression.chain), [(six, terms) for six, terms in suppression.sixes if terms]
    yield f"(a) not dependent everywhere: {len(free)} of {len(suppression.sixes)} sixes"
    threes = [set(three) for three, _ in known]
    with_triple = [(six, terms) for six, terms in free if _holds_one(six, threes)]
    if with_triple:
        names = ", ".join(f"{three[0]}–{three[-1]} ({kind})" for three, kind in known)
        yield f"(b) with three joints that are one, {names}: {len(with_triple)}"
    else:
        yield "(b) no three joints are a planar or spherical one"
    yield from _nearest_to_a_row(with_triple or free)


def _holds_one(six: Iterable[int], threes: Iterable[set[int]]) -> bool:
    """Whether one of the sets of three joints is among the six."""
    return any(three.issubset(six) for three in threes)


def _nearest_to_a_row(sixes: Sequence[tuple[Sequence[int], int]]) -> Iterator[str]:
    """KG's condition (c): the sixes that are nearest to a row of joints, and the terms of their determinants."""
    least = min(six[-1] - six[0] for six, _ in sixes)
    near = [(six, terms) for six, terms in sixes if six[-1] - six[0] == least]
    if least == 5:
        how = "in a row"
    else:
        how = "as near to a row as can be"
    yield f"(c) {how}: {len(near)}"
    if len(near) > 1:
        terms = ", ".join(f"{count} for {_short(six)}" for six, count in near)
        counts = [count for _, count in near]
        if counts.count(min(counts)) > 1:
            taken = "of equals the last"
        else:
            taken = "the least"
        yield f"terms of the determinant: {terms}; {taken}"


def _cases(suppression: Suppression, case: Case) -> Iterator[Step]:
    for inner in case.cases:
        lines = tuple(_case(suppression, inner))
        if lines:
            yield Step(f"Case {inner.number}: {conditions_text(inner.stratum)}", lines)
        yield from _cases(suppression, inner)


def _case(suppression: Suppression, case: Case) -> Iterator[str]:
    ring = suppression.chain.ring
    if case.dependence is not None:
        yield from _suppressed_screw_lines(suppression, case, case.dependence)
    if case.basic is not None:
        p = case.basic.product.polynomial
        yield Formula(f"|{_names(case.basic.joints)}| = {Value(ring, p, ring.factor(p)).text()}")
        if not case.cases:
            yield "which has no zero here: no singular configuration"
    if case.split:
        yield "no screw is a combination of the same others everywhere here: the case is split"
    if case.family and len(case.joints) > 6:
        yield "every determinant of six of the screws that are left is zero here"
    yield from _branches(case)


def _suppressed_screw_lines(suppression: Suppression, case: Case, dependence: ScrewDependence) -> Iterator[str]:
    """Which screw is a combination of which others in a case, how that is proven, and which screws are left."""
    screw, on, proof = dependence.screw, dependence.on, dependence.proof
    for j in sorted((screw, *on)):  # with the case's angles put in, where that changes short ones
        column = suppression.columns[j - 1]
        short = [case.stratum.short(x) for x in column]
        if short != column and sum(map(len, short)) <= LONG:
            yield Formula(f"here {_screw(suppression.chain.ring, j, short)}")
    if proof is None:
        yield f"${screw} is zero"
    else:
        if len(on) == 1:
            kind = f"a multiple of {_names(on)}, which is not zero:"
        else:
            kind = f"a combination of {_names(on)}, which are independent:"
        yield f"${screw} is {kind}"
        yield from _proof(suppression, proof, on)
    yield f"${screw} is suppressed; left: {_names(case.joints)}"


def _proof(suppression: Suppression, proof: IndependenceProof, on: Sequence[int]) -> Iterator[str]:
    ring = suppression.chain.ring
    if proof.frame == suppression.frame:
        there = ""
    else:
        there = f" in the frame of link {proof.frame}"
    if proof.kind == "gram":
        yield f"their Gram determinant{there} is {text_of(ring, proof.polynomials[0])} ≠ 0"
        return
    for rows, minor in zip(proof.rows, proof.polynomials, strict=True):
        names = " ".join(ROWS[r] for r in rows)
        value = f"{text_of(ring, minor)}{' ≠ 0' * (proof.kind == 'minor')}"
        yield Formula(f"|{_names(on)}| of rows {names}{there} is {value}")
    if proof.kind == "minors":
        yield "which have no common zero here"


def _branches(case: Case) -> Iterator[str]:
    for inner in case.cases:
        if inner.family:
            name = f"family {inner.family}"
        else:
            name = f"case {inner.number}"
        yield Formula(f"{name}: {conditions_text(inner.stratum)}")


def _families(suppression: Suppression) -> Iterator[str]:
    """The families, why no two of them meet, and what is assumed."""
    ring, families = suppression.chain.ring, suppression.families
    for family in families:
        yield Formula(f"family {family.family}: {conditions_text(family.stratum)}")
    apart = (
        (first.family, second.family, first.stratum.separating_polynomial(second.stratum))
        for first, second in combinations(families, 2)
    )
    waiting = {(first, second): p for first, second, p in apart if p is not None}
    if waiting:
        yield "no two of them meet:"
    while waiting:  # until every pair is told apart
        p = next(iter(waiting.values()))
        zero = [family.family for family in families if p in family.stratum.equalities]
        other = [family.family for family in families if p in family.stratum.inequalities]
        yield f"{condition_text(ring, p)} in {_joints(zero)}, not in {_joints(other)}"
        told = {*product(zero, other), *product(other, zero)}
        waiting = {pair: q for pair, q in waiting.items() if pair not in told}
    for p in suppression.assumptions:
        yield Formula(f"assumed: {text_of(ring, p)} ≠ 0")


def left_text(left: tuple[str, Case]) -> str:
    """What a suppression did not finish: a key of `_LEFT`, and the case."""
    what, case = left
    return _LEFT[what].format(number=case.number, conditions=conditions_text(case.stratum, READABLE))


def conditions_text(stratum: Stratum, most: int | None = None) -> str:
    """The conditions of a stratum in one line; polynomials of more than `most` terms are not written out."""
    parts = []
    for polynomials, sign in ((stratum.equations_with_pins, "="), (stratum.open, "≠")):
        for p in polynomials:
            long = most is not None and len(p) > most
            parts.append(f"({len(p)} terms) {sign} 0" if long else condition_text(stratum.ring, p, sign))
    return ", ".join(parts) or "everywhere"


def _names(joints: Sequence[int]) -> str:
    return " ".join(f"${j}" for j in joints)


def _joints(joints: Sequence[int]) -> str:
    return ", ".join(map(str, joints))


def _short(six: Sequence[int]) -> str:
    """1–6, or 1, 2, 4, 5, 6, 7."""
    if six[-1] - six[0] == len(six) - 1:
        return f"{six[0]}–{six[-1]}"
    return _joints(six)


def _method(derivation: SetDerivation) -> Step:
    notes, words, whole = notes_of(derivation), Words(derivation.chain.ring), Words(derivation.chain.ring, whole=True)
    figures = ", ".join(f"{name}: {count:,}" for name, count in derivation.sizes.items())
    shown = [Formula(words.conjunction(conjunction)) for conjunction in derivation.conditions[:_SHOWN]]
    every = [Formula(whole.conjunction(conjunction)) for conjunction in derivation.conditions]
    more = len(derivation.conditions) - _SHOWN
    lines = (figures, *shown, *([f"… and {more} more"] if more > 0 else []), *notes)
    complete = (figures, *every, *notes)
    title = f"Method: {derivation.method.replace('_', '-')}"
    if derivation.corank > 1:
        title += f", corank {derivation.corank}"
    return Step(title, lines, () if complete == lines else complete)


def notes_of(derivation: SetDerivation) -> tuple[str, ...]:
    """What is to be said of the answer of a method."""
    words = Words(derivation.chain.ring)
    return tuple(flat_map(lambda note: _note(words, note), derivation.notes))


def _note(words: Words, note: Note) -> Iterator[str]:
    what, facts = note
    if what == "unfactored":
        yield _unfactored_words(**facts)
        return
    if what == "screws":
        yield from _screws(words, **facts)
        return
    if what != "screw":
        yield _NOTES[what].format(**facts)
        return
    case, elements = facts["case"], facts["elements"]
    if len(elements) == 6:
        screw = _screw_text(case.ring, elements)
    else:
        screw = _size(elements)
    yield Formula(f"{_case_words(words, case)}: the screw reciprocal to joints {_joints(facts['joints'])} is {screw}")
    known = list(dict.fromkeys(words.conjunction(conjunction) for conjunction in facts["vanishes"]))
    count = {6: "six", 3: "three"}.get(len(elements), str(len(elements)))
    said = f"all {count} elements vanish, and it says nothing, where {', or where '.join(known)}"
    yield f"  {said if known else 'it never vanishes there'}"


def _case_words(words: Words, case: ZeroSet) -> str:
    """Where a case is: its pinned joints, or "in general"."""
    if case.pins:
        return words.conjunction(Conjunction(conditions_on(case)))
    return "in general"


def _screw_text(ring: Ring, elements: Sequence[Polynomial]) -> str:
    """A screw by its elements, a long one by its number of terms."""
    if sum(map(len, elements)) > WRITTEN:
        return _size(elements)
    written = [text_of(ring, x) for x in elements]
    if len(written) == 6:
        return f"({', '.join(written[:3])}; {', '.join(written[3:])})"
    return f"({', '.join(written)})"


def _size(elements: Sequence[Polynomial]) -> str:
    return f"of {sum(map(len, elements))} terms"


def _screws(
    words: Words,
    case: ZeroSet,
    joints: Sequence[int],
    rows: Sequence[int],
    minor: Polynomial,
    screws: Sequence[Sequence[Polynomial]],
) -> Iterator[str]:
    """The k screws that a case rests on, and the minor that makes them independent."""
    ring = case.ring
    yield Formula(f"{_case_words(words, case)}: screws reciprocal to joints {_joints(joints) or 'none'}:")
    yield from (Formula(f"  {_screw_text(ring, screw)}") for screw in screws)
    if len(minor) > WRITTEN:
        value = f"of {len(minor)} terms"
    else:
        value = text_of(ring, minor)
    if joints:
        names = " ".join(ROWS[row] for row in rows)
        yield Formula(f"  independent where |{_names(joints)}| of rows {names} is not zero: {value}")


def _unfactored_words(choice: MinorChoice, terms: int, degree: int, zero: tuple[float, ...] | None) -> str:
    """A minor that stands as it is, and a configuration at which it vanishes."""
    of, joints, rows = choice
    name = minor_name(of, joints, [ROWS[row] for row in rows])
    if zero is None:
        where = "random configurations show no real zero"
    else:
        values = ", ".join(f"{x + 0.0:.6g}".replace("-", "−") for x in zero)
        where = f"it vanishes at q = ({values}), for example"
    return (
        f"{name} = 0, of {terms:,} terms and degree {degree} in sines, cosines and slides, was not factored: it may "
        f"have factors, and the conditions hold all the same; {where}"
    )


class Words:
    """Conditions of one ring in words; the shortest form of a polynomial is looked for once.

    Args:
        ring: of the chain.
        whole: write every polynomial out; long ones as they are, without a search for their shortest form.

    Example:
        >>> ring = Ring([1, 2])
        >>> atoms = tuple(atom for atom, _ in ring.factor(ring.s[1] * (ring.c[2] - ring.s[2])).atoms)
        >>> Words(ring).conjunction(Conjunction((Equality(atoms),), ((Equality((ring.pin(2, "pi"),)),),)))
        'θ1 = 0 or π or c2 − s2 = 0, where θ2 ≠ π'
    """

    def __init__(self, ring: Ring, *, whole: bool = False) -> None:
        self._ring, self._whole = ring, whole
        self._known: dict[tuple[str, str], str] = {}

    def conjunction(self, conjunction: Conjunction) -> str:
        """Everything that has to hold: "θ4 = 0 and (s2 = 0 or …), where θ6 ≠ 0"."""
        equal = [self.equality(equality) for equality in conjunction.equal]
        if len(equal) > 1:
            equal = [
                f"({part})" if _alternatives(equality) > 1 else part
                for part, equality in zip(equal, conjunction.equal, strict=True)
            ]
        text = " and ".join(equal) or "everywhere"
        unequal = [self._unequal(group) for group in conjunction.unequal]
        if unequal:
            return f"{text}, where {' and '.join(unequal)}"
        return text

    def equality(self, equality: Equality, sign: str = "=") -> str:
        """One polynomial that vanishes: its factors, joined by "or"; joints at simple angles together.

        Args:
            equality: the polynomial.
            sign: "≠" where it does not vanish, for an equality without alternatives.
        """
        p = equality.whole
        if p is None:
            return atoms_text(self._ring, equality.atoms, partial(self._polynomial, sign), sign)
        if len(p) <= READABLE:
            return condition_text(self._ring, p, sign)
        if self._whole:
            return f"{Text(divisors=self._ring.parts).zero(single_angles(self._ring, p))} {sign} 0"
        return f"a polynomial of {len(p)} terms {sign} 0"

    def _polynomial(self, sign: str, f: Polynomial) -> str:
        key = sign, str(f)
        if key not in self._known:
            self._known[key] = self._condition_text(f, sign)
        return self._known[key]

    def _condition_text(self, f: Polynomial, sign: str) -> str:
        """A half-angle polynomial; a long one in sines and cosines where it has whole angles, else multiplied out."""
        if len(f) <= READABLE:
            return Condition(self._ring, f).text(sign)
        if not self._whole:
            return f"a polynomial of {len(f)} half-angle terms {sign} 0"
        p = self._ring.to_trig(f)
        if p is None:
            form = fourier(self._ring.form(f))
        else:
            form = single_angles(self._ring, p)
        return f"{Text(divisors=self._ring.parts).zero(form)} {sign} 0"

    def _unequal(self, group: Sequence[Equality]) -> str:
        """That not all equalities of a group hold: "θ6 ≠ 0" of one without alternatives."""
        if len(group) > 1:
            return "not all of these hold: " + "; ".join(map(self.equality, group))
        (equality,) = group
        if _alternatives(equality) == 1:
            return self.equality(equality, "≠")
        return f"not ({self.equality(equality)})"


def _alternatives(equality: Equality) -> int:
    """How many alternatives an equality has in words."""
    if equality.whole is None:
        return count_alternatives(equality.atoms)
    return 1
