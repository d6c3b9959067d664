"""Whether a condition that a person wrote is exactly the singular set: too small, too large, with counter-examples.

The condition is taken apart into irreducible sets U_i, as the singular set is into S_j. It is too small where some S_j
does not satisfy it, too large where the Jacobian has its full rank almost everywhere on some U_i. Both are decided at
random points modulo a prime, and shown at a real configuration of the arm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees
from typing import Any

import numpy as np

from rankdrop.exact.algebra.flint import Polynomial, flint
from rankdrop.exact.algebra.split import cut_half, pinned
from rankdrop.exact.algebra.variety import Variety, independent
from rankdrop.exact.algebra.work import Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.merge import merge
from rankdrop.exact.reading.example import real_points, words
from rankdrop.exact.reading.parse import Parsed, parse_conditions
from rankdrop.exact.reading.record import Difference, Example, LintResult
from rankdrop.exact.tree import rank_on
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.robot.model import Array, JointKind
from rankdrop.units import into_units

ZERO = 1e-9
"""σ and values of conditions at or below this, beside the largest σ or the largest value, are zero."""
CLEAR = 1e-6
"""Above this they are not; a counter-example between the two is not shown."""
_LOOKED = 12  # real points of a set among which the clearest counter-example is chosen


def lint(text: str, pieces: Sequence[Variety], chain: Chain, *, work: Work | None = None) -> LintResult:
    """Compare a user's condition with the singular set of an arm.

    Args:
        text: as in `parse_conditions`; several conditions hold together.
        pieces: irreducible sets that make up the singular set (less than the generic rank); some may lie in others.
        chain: the arm; lengths that are letters there may be named.
        work: deadline and random points; None for no deadline.

    Returns:
        LintResult. Sets without a real point that was found count for neither side; a remark says so.

    Raises:
        OptionError: a mistake in the text.
        OutOfTime: the deadline has passed.
    """
    work = work or Work()
    parsed = parse_conditions(text, chain.ring, shifts=[float(shift) for shift in chain.shifts])
    general = _Comparison(chain, parsed, pieces, {}, work)
    own = general
    if chain.letters and not general.agrees:
        own = _Comparison(chain, parsed, pieces, chain.letters, work)
    same = own.sizes == general.sizes
    told = general if same else own  # with letters where they say the same
    missing, unreal = told.shown(told.missing, singular=True)
    extra, more = told.shown(told.extra, singular=False)
    remarks = [f"No real configuration was found where {one}; it is not counted." for one in (*unreal, *more)]
    for one in parsed:
        remarks += [f"For lengths with {factor} = 0 “{one.text}” always holds." for factor in one.letters]
    undecided = [*work.unresolved, *(words(one) for one in own.unknown)]
    remarks += [f"Not decided: {left}." for left in undecided]
    verdict = {(0, 0): "exact", (1, 0): "too small", (0, 1): "too large", (1, 1): "both"}[bool(missing), bool(extra)]
    any_lengths = verdict == "exact" and same if chain.letters else None
    return LintResult(text, verdict, missing, extra, own.real, any_lengths, not undecided, tuple(remarks))


class _Comparison:
    """A condition against the singular set, for general lengths or for given ones.

    Attributes:
        missing: singular sets where it does not hold.
        extra: components of its zeros where the rank is full.
        unknown: components of its zeros whose rank is not known.
    """

    def __init__(
        self, chain: Chain, parsed: Sequence[Parsed], pieces: Sequence[Variety], lengths: Mapping[str, Any], work: Work
    ) -> None:
        self.chain, self.work, self.ring = chain, work, chain.ring
        self.values = {name: flint().fmpq(x.numerator, x.denominator) for name, x in lengths.items()}
        self.columns = [[p.subs(self.values) if self.values else p for p in column] for column in chain.columns]
        self.full = self.rank(Variety.whole(self.ring))
        self.parsed = [Parsed(one.text, one.ring, self.special(one.f), one.degrees, one.root) for one in parsed]
        self.singular = independent([part for piece in independent(pieces) for part in self.specialised(piece)])
        self.users = self.zeros()
        self.unknown = [piece for piece in self.users if len(piece.rest) > 2 and not piece.samples]
        self.missing = [piece for piece in self.singular if not self.holds(piece)]
        self.extra = [piece for piece in self.users if piece.samples and self.rank(piece) == self.full]

    @property
    def agrees(self) -> bool:
        """Whether the two sets are the same, real or not."""
        return not self.missing and not self.extra

    @property
    def sizes(self) -> tuple[int, int]:
        """How many sets are missing, and extra."""
        return len(self.missing), len(self.extra)

    @property
    def real(self) -> bool:
        """Whether a real zero of the condition is found."""
        return any(next(real_points(piece, self.chain), None) is not None for piece in self.users)

    def special(self, f: Polynomial) -> Polynomial:
        """A half-angle polynomial at the given lengths."""
        return f.subs(self.values) if self.values else f

    def specialised(self, piece: Variety) -> list[Variety]:
        """The components of a singular set at the given lengths."""
        if not self.values:
            return [piece]
        found = [Variety(self.ring, {})]
        for joint, value in piece.pins.items():
            found = [part for one in found for part in pinned(one, joint, value, self.work)]
        for f in piece.equations:
            g = self.special(f)
            degrees = tuple(int(d) for d in f.degrees()[: self.ring.angles])
            found = [part for one in found for part in self.cut(one, Parsed("", self.ring, g, degrees))]
        return [one for one in independent(found) if one.samples and self.rank(one) < self.full]

    def zeros(self) -> list[Variety]:
        """The components of the set where every condition holds."""
        found = [Variety.whole(self.ring)]
        for one in self.parsed:
            self.work.check()
            found = independent([part for piece in found for part in self.cut(piece, one)])
        return found

    def cut(self, piece: Variety, one: Parsed) -> list[Variety]:
        """The components of a set where a condition holds."""
        f, ring = one.f, self.ring
        left = list(one.degrees)
        for joint, value in piece.pins.items():
            place = ring.revolute.index(joint)
            if value == "pi" and int(f.degrees()[place]) < left[place]:
                return [piece]
            f, left[place] = ring.half_at(f, {joint: value}), 0
        if f == 0:
            return [piece]
        found: list[Variety] = []
        for atom in Parsed(one.text, ring, f, tuple(left), one.root).atoms:
            if atom.pinned:
                found += pinned(piece, atom.joint, atom.value, self.work)
            else:
                found += cut_half(piece, atom.f, self.work)
        return independent(found)

    def holds(self, piece: Variety) -> bool:
        """Whether every condition holds on all of a set."""
        for one in self.parsed:
            if one.f != 0 and not any(
                piece.stands(atom.joint, atom.value) if atom.pinned else piece.half_vanishes(atom.f)
                for atom in one.atoms
            ):
                return False
        return True

    def rank(self, piece: Variety) -> int:
        """Rank of the Jacobian almost everywhere on a set."""
        return rank_on(self.columns, piece)

    def shown(self, pieces: Sequence[Variety], *, singular: bool) -> tuple[tuple[Difference, ...], list[str]]:
        """Differences with an example each, and the sets without one, in words."""
        examples, unreal = {}, []
        for piece in pieces:
            self.work.check()
            example = self.example(piece, singular=singular)
            if example is None:
                unreal.append(words(piece))
            else:
                examples[id(piece)] = example
        rows = merge([piece for piece in pieces if id(piece) in examples])
        return tuple(
            Difference(", ".join(row.texts) or "every configuration", examples[id(row.pieces[0])]) for row in rows
        ), unreal

    def example(self, piece: Variety, *, singular: bool) -> Example | None:
        """A real configuration of a set, singular where the condition does not hold, or regular where it does."""
        best: tuple[float, Example] | None = None
        for looked, theta in enumerate(real_points(piece, self.chain)):
            if looked == _LOOKED:
                break
            one, largest = self.measured(theta)
            if singular and one.sigma <= ZERO * largest and abs(one.value) > CLEAR:
                clear = abs(one.value)
            elif not singular and one.sigma > CLEAR * largest and abs(one.value) <= ZERO:
                clear = one.sigma
            else:
                continue
            if best is None or clear > 2 * best[0]:
                best = (clear, one)
        return None if best is None else best[1]

    def measured(self, theta: Array) -> tuple[Example, float]:
        """The condition and σ at angles; and the largest σ."""
        robot, task = self.chain.robot, self.chain.task
        q = theta - self.chain.shifts
        turning = [j - 1 for j in self.ring.revolute]
        q[turning] = np.pi - np.remainder(np.pi - q[turning], 2 * np.pi) + 0.0
        values = [float(one(theta, self.chain.numbers)) for one in self.parsed]
        sigma = singular_values(self.chain.own, into_units(robot, q), self.chain.own_task)
        slides = [joint.kind is JointKind.PRISMATIC for joint in robot.variables]
        shown = tuple(float(x) if slide else degrees(x) for x, slide in zip(q, slides, strict=True))
        value = max(values, key=abs)
        return Example(tuple(map(float, q)), shown, value, float(sigma[generic_rank(robot, task) - 1])), float(sigma[0])
