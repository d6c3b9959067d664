"""How many aspects an arm has: connected regions of regular configurations, joints turning as far as they like.

An arm without redundancy is singular where a factor f_i of its determinant is zero. Each sign vector s gives a set
R_s = {s_i f_i > 0 for all i}, and the aspects are the connected parts of these sets.

*Peeling.* A joint that stands in one factor only, there as A + B cos θ + C sin θ, leaves an open arc of θ (or the
whole circle, or nothing) over each value of the other joints. Arcs are connected, so R_s has as many parts as its
shadow

    {s A + √(B² + C²) > 0}.

Where A is zero throughout, that is everything but {B = C = 0}. If B and C have no common factor this set has
codimension 2 and separates nothing: the condition is gone. A common factor g leaves {g ≠ 0}; that is gone as well where
g is a part of another factor, which is not zero on R_s, or stands for one value of a joint that no other condition
holds: a circle without a point is in one piece. A slide that stands in one factor only, as A + B q, leaves
a half-line or everything: with a number B ≠ 0 the condition is gone as well.

*Limits.* A turning joint with limits is not peeled off: the arc may fall apart at a limit. A slide between a and b that
stands in one factor only, as A + B q, leaves an interval over {max(s (A + B a), s (A + B b)) > 0}, its shadow.

Conditions that share no joint are counted apart, and the numbers multiplied. What is left of at most three joints is
counted on cells (`cells.py`).

*Redundant arms.* The regular set of an arm with more joints than rows is what the families of corank 1 leave. A set
of codimension 2 or more separates nothing: only conditions that stand alone do, and their signs take the place of the
factors. Where there is none, there is one region.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction
from itertools import product

from rankdrop.algebra.polynomial import Atom, Polynomial, order, variables_in
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work
from rankdrop.aspects.cells import ONE, Box, Either, PartCount, Positive, PositiveFunction, Shadow, count_parts
from rankdrop.aspects.waves import FourierSum, wave_of
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.signs import SignedFactor, Signs, signed_factors
from rankdrop.exact.tree import rank_tree
from rankdrop.families.name import FamilyName
from rankdrop.lists import flat_map
from rankdrop.local.block import generic_rank

MOST_JOINTS = 3
"""That cells are made of."""
MOST_FACTORS = 8
"""2 to that power sign vectors are counted."""


class Left(Enum):
    """Why the aspects were not counted."""

    SIGN = "sign"
    JOINTS = "joints"
    SLIDE = "slide"
    FACTORS = "factors"
    WORK = "work"
    CONDITIONS = "conditions"


@dataclass(frozen=True)
class SignCount:
    """The aspects with given signs of the factors.

    Attributes:
        signs: of each factor, +1 or −1.
        parts: how many; 0 where no configuration has these signs.
    """

    signs: tuple[int, ...]
    parts: PartCount


@dataclass(frozen=True)
class AspectCount:
    """How many aspects an arm has, joint limits ignored.

    Attributes:
        factors: of the determinant, or conditions that stand alone, as text in s_j = sin θ_j and c_j = cos θ_j.
        roles: part of the arm that each factor is of ("shoulder", "elbow", "wrist"); "" where it has no name.
        each: for every sign vector.
        peeled: joints (from 1) that were peeled off.
        cells: joints (from 1) in which cells were counted.
        left: why it was not counted; None where it was.
        shared: joints (from 1) that conditions share which are too many for cells; () where they are not.
    """

    factors: tuple[str, ...] = ()
    roles: tuple[str, ...] = ()
    each: tuple[SignCount, ...] = ()
    peeled: tuple[int, ...] = ()
    cells: tuple[int, ...] = ()
    left: Left | None = None
    shared: tuple[int, ...] = ()

    @property
    def at_least(self) -> int:
        """Proven lower bound."""
        return sum(vector.parts.at_least for vector in self.each)

    @property
    def at_most(self) -> int | None:
        """Upper bound, proven where `proven` says so; None where nothing was counted."""
        if self.left is not None:
            return None
        return sum(vector.parts.at_most for vector in self.each)

    @property
    def proven(self) -> bool:
        """Whether the upper bound is proven too."""
        return self.left is None and all(vector.parts.proven for vector in self.each)

    @property
    def exact(self) -> bool:
        """Whether the number is proven."""
        return self.proven and self.at_least == self.at_most

    @property
    def signs_decide(self) -> bool:
        """Whether two configurations lie in one aspect if and only if all factors have equal signs: proven."""
        return self.exact and all(vector.parts.at_most <= 1 for vector in self.each)


def walls_of(chain: Chain, work: Work) -> Signs | None:
    """The conditions that part the regular configurations of an arm with more joints than rows, by their signs.

    Sets of codimension 1 on which the rank drops; all others separate nothing.

    Args:
        chain: from `exact_chain` with `lengths="numbers"`.
        work: limit of the derivation.

    Returns:
        None where the derivation did not end: a condition may be missing.
    """
    tree = rank_tree(chain, work, lowest=generic_rank(chain.own, chain.own_task) - 1)
    if not tree.is_finished:
        return None
    atoms = []
    for drop in tree.drops:
        if drop.piece.codimension == 1:
            pins = [chain.ring.pin(joint, value) for joint, value in drop.piece.pins.items()]
            wall = [*pins, *map(chain.ring.atom, drop.piece.equations)]
            assert len(wall) == 1  # an irreducible set of codimension 1 is the zeros of one polynomial
            atoms += wall
    return Signs(chain, signed_factors(chain.ring, atoms))


def count_aspects(signs: Signs, work: Work | None = None) -> AspectCount:
    """Count the connected regions of regular configurations.

    Args:
        signs: from `signs_of` of a chain with `lengths="numbers"` (the numbers decide), or from `walls_of`.
        work: limit of the work on cells.

    Raises:
        OutOfTime: that limit was reached.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.exact.signs import signs_of
        >>> from rankdrop.robot.open import open_robot
        >>> counted = count_aspects(signs_of(exact_chain(open_robot("planar2r"), lengths="numbers")))
        >>> counted.exact, counted.at_least, counted.factors
        (True, 2, ('s2',))
    """
    return count_in_box(signs, {}, work)


def count_in_box(signs: Signs, box: Box, work: Work | None) -> AspectCount:
    """Count the connected regions of regular configurations within limits.

    Args:
        signs: as of `count_aspects`.
        box: lower and upper limits of joints, in the variables of the conditions; the others have none.
        work: limit of the work on cells.

    Raises:
        OutOfTime: that limit was reached.
    """
    signed, chain = signs.factors, signs.chain
    head = head_of(signs)
    if not all(factor.periodic for factor in signed):
        return replace(head, left=Left.SIGN)
    if len(signed) > MOST_FACTORS:
        return replace(head, left=Left.FACTORS)
    peeling = Peeling(chain.ring, chain.numbers, signed, box)
    if peeling.left is not None:
        return replace(head, peeled=tuple(peeling.peeled), left=peeling.left, shared=peeling.too_many)
    known: dict[tuple[int, tuple[int, ...]], PartCount] = {}
    each = []
    for vector in product((1, -1), repeat=len(signed)):
        parts = ONE
        for number, group in enumerate(peeling.groups):
            group_signs = tuple(vector[i] for i in group)
            key = number, group_signs
            if key not in known:
                conditions = [peeling.condition(i, vector[i]) for i in group]
                known[key] = count_parts(conditions, work, box)
            parts = parts * known[key]
        each.append(SignCount(vector, parts))
    cells = _joints_of_cells(peeling)
    return replace(head, each=tuple(each), peeled=tuple(peeling.peeled), cells=cells)


def _joints_of_cells(peeling: Peeling) -> tuple[int, ...]:
    """The joints of the conditions that are left, in order: their space is cut into cells."""
    left: set[int] = set()
    for group in peeling.groups:
        for i in group:
            left.update(peeling.condition(i, 1).joints)
    return tuple(sorted(left))


def head_of(signs: Signs) -> AspectCount:
    """A count that says which factors there are, and no numbers yet."""
    return AspectCount(tuple(factor.text for factor in signs.factors), tuple(_role(name) for name in signs.names))


def wave_of_factor(ring: Ring, numbers: Mapping[str, float], parts: Sequence[Polynomial]) -> tuple[FourierSum, ...]:
    """The Fourier sums of a factor, or of its A, B and C, divided by their largest coefficient."""
    unit = max(max(abs(value) for value in p.coeffs()) for p in parts if p != 0)
    return tuple(wave_of(ring, p, numbers, unit) for p in parts)


def _role(name: FamilyName | None) -> str:
    """The part of the arm that a family is named after."""
    return name.short if name is not None and name.parts else ""


def polynomial_of(factor: SignedFactor) -> Polynomial:
    """The trigonometric polynomial of a factor with a sign, up to a positive number and up to its sign."""
    ring = factor.ring
    f = ring.half.constant(1)
    degrees = [0] * ring.angles
    for atom in factor.atoms:
        if atom.is_pin:
            place = ring.index[f"t{atom.joint}"]
            degrees[place] += 1
            if atom.value == "pi":
                f = f
            else:
                f = f * ring.half_of(atom)
        else:
            atom_degrees = atom.f.degrees()
            degrees = [degree + int(atom_degrees[k]) for k, degree in enumerate(degrees)]
            f = ring.product(f, atom.f)
    polynomial = ring.to_trig(f, degrees)
    assert polynomial is not None  # all degrees are even
    return polynomial


@dataclass(frozen=True, eq=False)
class _Harmonic:
    """A + B cos θ + C sin θ, after θ was peeled off."""

    a: Polynomial
    b: Polynomial
    c: Polynomial


class Peeling:
    """The factors with joints peeled off, the same for all signs.

    Args:
        ring: of the factors.
        numbers: values of the roots that are in coefficients.
        factors: each with a sign of its own.
        box: limits of joints.

    Attributes:
        peeled: joints that were peeled off, in order.
        groups: indices of the factors that still are conditions, those that share joints together.
    """

    def __init__(
        self, ring: Ring, numbers: Mapping[str, float], factors: Sequence[SignedFactor], box: Box | None = None
    ) -> None:  # fmt: skip
        self.ring, self.numbers, self.box = ring, numbers, box or {}
        self.atoms = [factor.atoms for factor in factors]
        self.whole: list[Polynomial | None] = [polynomial_of(factor) for factor in factors]  # None once peeled
        self.linear: dict[int, _Harmonic] = {}  # those that one joint was peeled off
        self.ends: dict[int, tuple[Polynomial, Polynomial]] = {}  # or a slide: their values at both of its limits
        self.peeled: list[int] = []
        self._waves: dict[int, tuple[FourierSum, ...]] = {}
        while self._peel_one():
            pass
        self.groups = self._touching_groups()

    @property
    def left(self) -> Left | None:
        """Why what is left cannot be counted on cells; None where it can."""
        for group in self.groups:
            joints = set(flat_map(self._joints, group))
            if joints & set(self.ring.prismatic):
                return Left.SLIDE
            if len(joints) > MOST_JOINTS:
                return Left.JOINTS
        return None

    @property
    def too_many(self) -> tuple[int, ...]:
        """The joints of the first group that depends on more than `MOST_JOINTS`; () where there is none."""
        for group in self.groups:
            joints = set[int]().union(*map(self._joints, group))
            if len(joints) > MOST_JOINTS:
                return tuple(sorted(joints))
        return ()

    def condition(self, i: int, sign: int) -> PositiveFunction:
        """What a factor with this sign asks of the joints that are left."""
        if i not in self._waves:
            self._waves[i] = wave_of_factor(self.ring, self.numbers, self._parts(i))
        waves = self._waves[i]
        if len(waves) == 1:
            return Positive(waves[0], sign)
        if i in self.ends:
            return Either(Positive(waves[0], sign), Positive(waves[1], sign))
        a, b, c = waves
        return Shadow(a, b, c, sign)

    def _parts(self, i: int) -> tuple[Polynomial, ...]:
        whole = self.whole[i]
        if whole is not None:
            return (whole,)
        if i in self.ends:
            return self.ends[i]
        linear = self.linear[i]
        return linear.a, linear.b, linear.c

    def _alive(self) -> Iterator[int]:
        peeled = self.linear.keys() | self.ends.keys()
        return (i for i in range(len(self.whole)) if self.whole[i] is not None or i in peeled)

    def _joints(self, i: int) -> set[int]:
        parts = (p for p in self._parts(i) if p != 0)
        return set(flat_map(lambda p: joints_of(self.ring, p), parts))

    def _peel_one(self) -> bool:
        """Peel one joint off, if there is one that can be; first those that leave no condition."""
        everywhere = {i: self._joints(i) for i in self._alive()}
        for leaving, joint in product((False, True), (*self.ring.revolute, *self.ring.prismatic)):
            holders = [i for i, joints in everywhere.items() if joint in joints]
            if len(holders) == 1 and self._peel(holders[0], joint, leaving=leaving):
                self.peeled.append(joint)
                return True
        return False

    def _peel(self, i: int, joint: int, *, leaving: bool) -> bool:
        """Peel a joint off the factor that holds it; False where that cannot be done.

        Args:
            i: of the factor.
            joint: that stands in no other one.
            leaving: whether a condition on the other joints may be left.
        """
        whole = self.whole[i]
        if whole is None:
            return False
        if joint in self.ring.prismatic:
            return self._peel_slide(i, whole, joint)
        if joint in self.box:
            return False
        parts = linear_parts(self.ring, whole, joint)
        if parts is None:
            return False
        gone = parts.a == 0 and self._separate_nothing(i, shared_atoms(self.ring, parts))
        if not gone:
            if not leaving:
                return False
            self.linear[i] = parts
        self.whole[i] = None
        return True

    def _peel_slide(self, i: int, whole: Polynomial, joint: int) -> bool:
        if joint in self.box:
            low, high = (slide_at(self.ring, whole, joint, end) for end in self.box[joint])
            if low is None or high is None:
                return False
            self.ends[i] = low, high
        elif slide_part(self.ring, whole, joint) is None:
            return False
        self.whole[i] = None  # without limits A + B q with a number B: a half-line over everything
        return True

    def _separate_nothing(self, i: int, shared: Sequence[Atom]) -> bool:
        """Whether the zeros of the common factors that factor i has left part no region."""
        others = [k for k in self._alive() if k != i]
        new = [atom for atom in shared if not any(self.whole[k] is not None and atom in self.atoms[k] for k in others)]
        cut = [atom.joint for atom in new]
        held = set(flat_map(self._joints, others))
        cut_once = len(set(cut)) == len(cut)
        return all(atom.is_pin for atom in new) and cut_once and not (held | self.box.keys()) & set(cut)

    def _touching_groups(self) -> list[tuple[int, ...]]:
        return sharing({i: self._joints(i) for i in self._alive()})


def sharing(joints: Mapping[int, set[int]]) -> list[tuple[int, ...]]:
    """Factors in groups: two that depend on a common joint are in one.

    Args:
        joints: index of each factor -> the joints it depends on.
    """
    groups: list[tuple[set[int], list[int]]] = []
    for i, used in joints.items():
        together, members = set(used), [i]
        apart = []
        for others, other_members in groups:
            if others & together:
                together, members = together | others, other_members + members
            else:
                apart.append((others, other_members))
        groups = [*apart, (together, members)]
    return [tuple(sorted(members)) for _, members in groups]


def joints_of(ring: Ring, p: Polynomial) -> set[int]:
    """Joints (from 1) that a polynomial of `ring.trig` depends on."""
    names = p.context().names()
    return {int(names[place][1:]) for place in variables_in(p) if place < 2 * ring.angles + len(ring.prismatic)}


def linear_parts(ring: Ring, p: Polynomial, joint: int) -> _Harmonic | None:
    """A, B, C of p = A + B cos θ + C sin θ; None where θ stands in it in a higher degree."""
    names = p.context().names()
    sine, cosine = names.index(f"s{joint}"), names.index(f"c{joint}")
    a, b, c = dict[tuple[int, ...], object](), dict[tuple[int, ...], object](), dict[tuple[int, ...], object]()
    for powers, value in p.to_dict().items():
        degree = int(powers[sine]), int(powers[cosine])
        if sum(degree) > 1:
            return None
        part = {(0, 0): a, (0, 1): b, (1, 0): c}[degree]
        part[tuple(0 if k in (sine, cosine) else int(e) for k, e in enumerate(powers))] = value
    context = p.context()
    return _Harmonic(*(context.from_dict(part) for part in (a, b, c)))


def slide_part(ring: Ring, p: Polynomial, joint: int) -> Polynomial | None:
    """B of p = A + B q with a number B; None where q stands in it otherwise."""
    place = p.context().names().index(f"q{joint}")
    if int(p.degrees()[place]) != 1:
        return None
    b = p.derivative(place)
    return None if joints_of(ring, b) else b


def slide_at(ring: Ring, p: Polynomial, joint: int, value: float) -> Polynomial | None:
    """p = A + B q at a value of q; None where q stands in it in a higher degree."""
    place = p.context().names().index(f"q{joint}")
    if int(p.degrees()[place]) != 1:
        return None
    slope = p.derivative(place)
    context = p.context()
    rest = context.from_dict({powers: number for powers, number in p.to_dict().items() if not int(powers[place])})
    return rest + slope * ring.constant(Fraction(value))


def shared_atoms(ring: Ring, parts: _Harmonic) -> list[Atom]:
    """What B and C are both zero on in codimension 1; they are not both zero throughout."""
    each = [{atom for atom, _ in ring.factor(p).atoms} for p in (parts.b, parts.c) if p != 0]
    return sorted(set.intersection(*each), key=order)
