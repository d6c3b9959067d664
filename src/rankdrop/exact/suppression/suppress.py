"""Dependent-screw suppression (KG): every singular configuration of a redundant arm, in families that do not meet.

Step 1. The determinant of six basic screws is zero where one of its factors is: case i has factor i = 0 and the earlier
ones ≠ 0. Step 2. In each case a screw that is a combination of others everywhere, which is proved, is suppressed: the
rank of the rest is the rank of all, and step 1 is repeated with them until six are left, whose determinant says which
part of the case is singular. Where no screw is dependent everywhere, the case is split at a minor that stands in the
way. An arm of six joints has step 1 alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.algebra.polynomial import Equality, Polynomial
from rankdrop.exact.algebra.ring import letters_polynomial
from rankdrop.exact.algebra.solving import plainly_positive
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import check_basic
from rankdrop.exact.suppression.dependence import Obstacle, Sampled, find, lightest
from rankdrop.exact.suppression.factors import (
    Basic,
    Product,
    choose,
    determinants,
    joined,
    taken_apart,
    why,
)
from rankdrop.exact.suppression.steps import Case, SuppressedFamily, Suppression, conditions_text
from rankdrop.exact.suppression.stratum import Stratum, atoms_on

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
        self.families: list[SuppressedFamily] = []
        self.left: list[str] = []
        self.done, self.known = 0, 1

    def run(self) -> Suppression:
        """The derivation from step 1."""
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
            start = self.determinant(start, ())
        except OutOfTime:
            self.left.append("the determinant of the basic screws")
        assumed = tuple(
            letters_polynomial(self.ring, f)
            for f in self.work.assumed.values()
            if len(f) > 1 and not plainly_positive(self.ring, f)  # a length alone is not zero
        )
        found, left = tuple(self.families), tuple(self.left)
        return Suppression(self.chain, self.frame, self.frame_reason, self.columns, start, found, assumed, left)

    def determinant(self, case: Case, above: tuple[Case, ...]) -> Case:
        """Step 1 with the screws that are left: a case for each factor of the determinant of six of them."""
        first = not case.number
        options = determinants(self.columns, case.stratum, case.joints, self.asked if first else None, self.work)
        basic = choose(self.chain, case.stratum, options, self.work)
        if first and basic is not None:
            basic = replace(basic, reason=self.reason(case, options, basic))
        if basic is None:
            if first:
                raise OptionError("these basic screws are always dependent", where="basic", got=str(self.asked))
            if all(case.stratum.vanishes(p, self.work.rng) for _, p in options):
                return self.family(case, above)
            return self.apart(case, above)
        self.assume(basic.product)
        case = replace(case, basic=basic)
        return self.branch(case, above, basic.product.factors)

    def reason(self, case: Case, options: Sequence[tuple[tuple[int, ...], Polynomial]], basic: Basic) -> str:
        """Why these screws are the basic ones."""
        if self.asked is not None:
            return "asked for"
        return why(self.chain, case.stratum, options, basic.joints, self.work)

    def branch(
        self, case: Case, above: tuple[Case, ...], factors: Sequence[Equality], first: tuple[Case, ...] = ()
    ) -> Case:
        """After some first cases, a case for each factor = 0 with the earlier ones ≠ 0."""
        rest, cases = case.stratum, list(first)
        self.known += len(factors)
        for f in factors:
            here, rest = self.inhabited(rest.meet(f)), rest.avoid(f)
            if here.pieces:
                cases.append(self.finished(Case(_number(case, cases), here, case.joints), (*above, case)))
            self.tell()
        return replace(case, cases=tuple(cases))

    def finished(self, case: Case, above: tuple[Case, ...]) -> Case:
        """The case followed to its end, or named in `left` where the time is up."""
        try:
            self.work.check()
            if max(len(piece.equations) for piece in case.stratum.pieces) > DEEPEST:
                raise OutOfTime
            return self.suppressed(case, above)
        except OutOfTime:
            self.left.append(f"case {case.number}: {conditions_text(case.stratum, SHORT)}")
            return case

    def suppressed(self, case: Case, above: tuple[Case, ...]) -> Case:
        """Step 2: suppress a dependent screw and go on with the rest."""
        if not case.stratum.regular:
            return self.apart(case, above)
        if len(case.joints) == 6:
            return self.family(case, above)
        sampled = Sampled(self.columns, case.stratum, self.work.rng)
        mixed = sampled.mixed(case.joints)
        if mixed is not None:
            return self.at(case, above, lightest(self.chain, case.stratum, mixed, self.work))
        found, obstacle = find(self.chain, self.frame, case.stratum, sampled, case.joints, self.work)
        if found is not None:
            if found.proof is not None:
                for pins in case.stratum.combinations:
                    for p in found.proof.polynomials:
                        for f, _ in self.ring.factor(self.ring.at(p, pins)).letters:
                            self.work.assume(f)
            left = tuple(j for j in case.joints if j != found.screw)
            return self.determinant(replace(case, joints=left, dependence=found), above)
        return self.at(case, above, obstacle)

    def at(self, case: Case, above: tuple[Case, ...], obstacle: Obstacle | None) -> Case:
        """Split a case at the zeros of a minor."""
        product = taken_apart(case.stratum, obstacle.minor) if obstacle is not None else None
        if product is None or not product.factors:
            return self.apart(case, above)
        self.assume(product)
        return self.split(case, above, product.factors)

    def apart(self, case: Case, above: tuple[Case, ...]) -> Case:
        """Split a case whose pieces behave differently: by a condition that holds on some of them only."""
        stratum = case.stratum
        atoms = [self.ring.pin(j, value) for one in stratum.pieces for j, value in one.pins.items()]
        atoms += [self.ring.atom(f) for one in stratum.pieces for f in one.equations]
        for condition in joined(self.ring, list(dict.fromkeys(atoms))):
            holds = [atoms_on(piece, condition) is None for piece in stratum.pieces]
            if any(holds) and not all(holds):
                return self.split(case, above, [condition])
        for condition in (Equality((atom,), p.whole) for p in joined(self.ring, atoms) for atom in p.atoms):
            holds = [atoms_on(piece, condition) is None for piece in stratum.pieces]
            if any(holds) and not all(holds):
                return self.split(case, above, joined(self.ring, condition.atoms))
        raise OutOfTime  # one piece, no proof and nothing to split at: named among what is left

    def split(self, case: Case, above: tuple[Case, ...], factors: Sequence[Equality]) -> Case:
        """A case with all factors ≠ 0, and one for each factor = 0 with the earlier ones ≠ 0."""
        case = replace(case, split=True)
        rest = case.stratum
        for f in factors:
            rest = rest.avoid(f)
        rest = self.inhabited(rest)
        first: tuple[Case, ...] = ()
        if rest.pieces:  # the larger part, so that it is done before the time is up
            first = (self.finished(Case(_number(case, ()), rest, case.joints), (*above, case)),)
        return self.branch(case, above, factors, first)

    def family(self, case: Case, above: tuple[Case, ...]) -> Case:
        """The case is a family, if the rank is lost at all points of it that are met; else it is told.

        Conditions of which only some of the zeros were met may hold where the screws span all six freedoms.
        """
        sampled = Sampled(self.columns, case.stratum, self.work.rng)
        ranks = tuple(sorted(sampled.ranks(range(1, self.chain.n + 1))))
        if not ranks or ranks[-1] == 6:
            met = "all six freedoms are left at points of it" if ranks else "no point of it was met"
            self.left.append(f"case {case.number}: {met}: {conditions_text(case.stratum, SHORT)}")
            return case
        number = len(self.families) + 1
        case = replace(case, family=number)
        self.families.append(SuppressedFamily(number, case.stratum, (*above, case), ranks))
        return case

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
        """Take the factors in lengths alone for ≠ 0."""
        for f, _ in product.letters:
            self.work.assume(f)

    def tell(self) -> None:
        """Report a case done."""
        self.done += 1
        if self.progress is not None:
            self.progress("dependent-screw suppression", self.done, self.known)


def _frame_reason(chain: Chain) -> str:
    """In which link's frame the screws have how many terms."""
    terms = ", ".join(f"link {k}: {sum(len(x) for c in chain.screws(k) for x in c)}" for k in range(1, chain.n))
    return f"the screws are shortest there; terms, multiplied out: {terms}"


def _number(case: Case, before: Sequence[Case]) -> str:
    """The number of the next case inside one."""
    return f"{case.number}." * bool(case.number) + str(len(before) + 1)
