"""Whether a condition that a person wrote is exactly the singular set: too small, too large, with counter-examples.

The condition is taken apart into irreducible sets U_i, as the singular set is into S_j. It is too small where some S_j
does not satisfy it, too large where the Jacobian has its full rank almost everywhere on some U_i. Both are decided at
random points modulo a prime, and shown at a real configuration of the arm, with round angles
where the set leaves them free.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import degrees, radians
from typing import Any

import numpy as np

from rankdrop.algebra.cut import components_with_pin, cut_half
from rankdrop.algebra.polynomial import flint
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet, independent
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.parts import whole_angles
from rankdrop.exact.rows import merge, row_of_set
from rankdrop.exact.tree import rank_on
from rankdrop.formula.equation import System
from rankdrop.formula.reading import Parsed, parse_conditions
from rankdrop.formula.writing import RADIANS, Condition
from rankdrop.lists import flat_map
from rankdrop.local.block import generic_rank, sampling_box, singular_values
from rankdrop.problem import wrap
from rankdrop.robot.model import Array, JointKind
from rankdrop.sections import words_of
from rankdrop.tolerances import CONDITION_FAILS, DEFAULT, RANK_KEPT
from rankdrop.units import into_units, out_of_units

STARTS = 60
"""Newton iterations begun for one set; a set where none arrives is taken to have no real point, which is no proof."""
_STEPS = 40
_ROUND = radians(5.0)

_LOOKED = 12  # real points of a set among which the clearest counter-example is chosen


@dataclass(frozen=True, slots=True)
class Example:
    """A configuration that shows the difference.

    Attributes:
        q: joint variables [rad, m].
        degrees: the same with angles in degrees, slides in m.
        value: of the user's condition there, the largest in size where there are several.
        sigma: the singular value that is zero at a singularity.
    """

    q: tuple[float, ...]
    degrees: tuple[float, ...]
    value: float
    sigma: float


@dataclass(frozen=True, slots=True)
class WrongSet:
    """A set of configurations about which the condition is wrong.

    Attributes:
        conditions: what the set is, in words.
        example: on it.
    """

    conditions: str
    example: Example


@dataclass(frozen=True, slots=True)
class LintResult:
    """A user's condition against the singular set.

    Attributes:
        text: the condition.
        verdict: "exact", "too small", "too large", or "both", for the arm's own lengths.
        missing: singular sets that the condition leaves out.
        extra: sets of regular configurations that it takes in.
        real: whether it holds at any real configuration.
        any_lengths: whether it is exact for all lengths that are symbols, special ones aside; None where none is.
        not_real: sets without a real configuration that was found, which count for neither side.
        special: (factor, condition): lengths for which the factor is zero, where the condition always holds.
        undecided: sets that could not be decided; the verdict speaks of the rest.
    """

    text: str
    verdict: str
    missing: tuple[WrongSet, ...]
    extra: tuple[WrongSet, ...]
    real: bool
    any_lengths: bool | None
    not_real: tuple[str, ...]
    special: tuple[tuple[str, str], ...]
    undecided: tuple[str, ...]

    @property
    def complete(self) -> bool:
        """Whether everything could be decided."""
        return not self.undecided

    @property
    def remarks(self) -> tuple[str, ...]:
        """What else is to be known, in words."""
        remarks: tuple[str, ...] = words_of(self).lint_remarks(self)
        return remarks

    def sentences(self) -> tuple[str, ...]:
        """The result in words."""
        sentences: tuple[str, ...] = words_of(self).lint_sentences(self)
        return sentences


def words(piece: ZeroSet) -> str:
    """The conditions of a set: "θ3 = 0 and a2 c2 + a3 c23 = 0"."""
    return " and ".join(row_of_set(piece).texts) or "every configuration"


def round_points(piece: ZeroSet, chain: Chain, *, seed: int = 0, step: float = _ROUND) -> Iterator[Array]:
    """Real points of a set at the arm's own lengths, one per start that arrives.

    Args:
        piece: its conditions are solved, for as many of its variables as there are conditions, by Newton's method.
        chain: gives the lengths and the room of the slides.
        seed: of the starts.
        step: free angles are multiples of this [rad].

    Yields:
        (n,) angles θ [rad], variables of slides [m].
    """
    rng = np.random.default_rng(seed)
    conditions = [Condition(piece.ring, chain.own_polynomial(f)) for f in piece.equations]
    equations = tuple(condition.equation(chain.own_numbers, chain.n) for condition in conditions)
    system = System(equations)
    moving = sorted(set(flat_map(lambda condition: condition.joints, conditions)) - set(piece.pins))
    low, high = sampling_box(chain.own, chain.own_task, limits=False)
    for _ in range(STARTS):
        theta = np.where([j in piece.ring.revolute for j in range(1, chain.n + 1)],
                         np.round(rng.uniform(-np.pi, np.pi, chain.n) / step) * step,
                         np.round(rng.uniform(low, high), 2))  # fmt: skip
        for joint, value in piece.pins.items():
            theta[joint - 1] = RADIANS[value]
        if equations:
            chosen = rng.choice(moving, min(len(equations), len(moving)), replace=False) - 1
            ends, arrived = system.solve(theta[None], along=np.eye(chain.n)[:, chosen], iterations=_STEPS, step=1.0)
            if not arrived[0]:
                continue
            theta = ends[0]
            turning = [j - 1 for j in piece.ring.revolute]
            theta[turning] = wrap(theta[turning])
        yield out_of_units(chain.robot, theta)


def lint(text: str, pieces: Sequence[ZeroSet], chain: Chain, *, work: Work | None = None) -> LintResult:
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
    parsed = parse_conditions(text, chain.ring, shifts=[float(shift) for shift in chain.whole_shifts])
    general = _Comparison(chain, parsed, pieces, {}, work)
    special = bool(chain.letters) and any(general.sizes)
    if special:
        at_lengths = _Comparison(chain, parsed, pieces, chain.letters, work)
    else:
        at_lengths = general
    same = at_lengths.sizes == general.sizes
    reported = general if same else at_lengths  # with letters where they say the same
    missing, unreal = reported.show_differences(reported.missing, singular=True)
    extra, more = reported.show_differences(reported.extra, singular=False)
    special_lengths: list[tuple[str, str]] = []
    for condition in parsed:
        special_lengths += [(str(factor), condition.text) for factor in condition.letters]
    undecided = (*work.unresolved, *map(words, at_lengths.unknown))
    real = any(next(round_points(piece, chain), None) is not None for piece in at_lengths.users)
    verdict = {(0, 0): "exact", (1, 0): "too small", (0, 1): "too large", (1, 1): "both"}[bool(missing), bool(extra)]
    if chain.letters:
        any_lengths = verdict == "exact" and same
    else:
        any_lengths = None
    return LintResult(
        text, verdict, missing, extra, real, any_lengths, (*unreal, *more), tuple(special_lengths), undecided
    )


class _Comparison:
    """A condition against the singular set, for general lengths or for given ones.

    Attributes:
        missing: singular sets where it does not hold.
        extra: components of its zeros where the rank is full.
        sizes: how many sets are missing, and extra.
        unknown: components of its zeros whose rank is not known.
    """

    def __init__(
        self, chain: Chain, parsed: Sequence[Parsed], pieces: Sequence[ZeroSet], lengths: Mapping[str, Any], work: Work
    ) -> None:
        self.chain, self.work, self.ring = chain, work, chain.ring
        self.values = {name: flint().fmpq(x.numerator, x.denominator) for name, x in lengths.items()}
        self.columns = [[p.subs(self.values) if self.values else p for p in column] for column in chain.columns]
        self.full = rank_on(self.columns, ZeroSet.whole(self.ring))
        self.parsed = [
            replace(condition, form=replace(condition.form, f=condition.form.f.subs(self.values)))
            for condition in parsed
        ]
        self.singular = independent(flat_map(self.specialise, independent(pieces)))
        self.users = self.zeros()
        self.unknown = [piece for piece in self.users if len(piece.rest) > 2 and not piece.samples]
        self.missing = [piece for piece in self.singular if not self.holds(piece)]
        self.extra = [piece for piece in self.users if piece.samples and rank_on(self.columns, piece) == self.full]
        self.sizes = len(self.missing), len(self.extra)

    def specialise(self, piece: ZeroSet) -> list[ZeroSet]:
        if not self.values:
            return [piece]
        pieces = [ZeroSet(self.ring, {})]
        for joint, value in piece.pins.items():
            pieces = flat_map(partial(components_with_pin, joint=joint, value=value, work=self.work), pieces)
        for f in piece.equations:
            form = replace(self.ring.form(f), f=f.subs(self.values))
            cut = partial(self.cut, condition=Parsed(form))
            pieces = flat_map(cut, pieces)
        return [piece for piece in independent(pieces) if piece.samples and rank_on(self.columns, piece) < self.full]

    def zeros(self) -> list[ZeroSet]:
        pieces = [ZeroSet.whole(self.ring)]
        for condition in self.parsed:
            self.work.check()
            pieces = independent(flat_map(partial(self.cut, condition=condition), pieces))
        return pieces

    def cut(self, piece: ZeroSet, condition: Parsed) -> list[ZeroSet]:
        form = condition.form.at(piece.pins)
        if form.f == 0:
            return [piece]
        pieces: list[ZeroSet] = []
        for atom in Parsed(form).atoms:
            if atom.is_pin:
                pieces += components_with_pin(piece, atom.joint, atom.value, self.work)
            else:
                pieces += cut_half(piece, atom.f, self.work)
        return independent(pieces)

    def holds(self, piece: ZeroSet) -> bool:
        return all(
            condition.form.f == 0
            or any(piece.stands(x.joint, x.value) if x.is_pin else piece.half_vanishes(x.f) for x in condition.atoms)
            for condition in self.parsed
        )

    def show_differences(
        self, pieces: Sequence[ZeroSet], *, singular: bool
    ) -> tuple[tuple[WrongSet, ...], list[str]]:
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
            WrongSet(", ".join(row.texts) or "every configuration", examples[id(row.pieces[0])]) for row in rows
        ), unreal

    def example(self, piece: ZeroSet, *, singular: bool) -> Example | None:
        """A real configuration of a set, singular where the condition does not hold, or regular where it does."""
        best: tuple[float, Example] | None = None
        for looked, theta in enumerate(round_points(piece, self.chain)):
            if looked == _LOOKED:
                break
            example, largest = self.measure(theta)
            if singular and example.sigma <= DEFAULT.singular * largest and abs(example.value) > CONDITION_FAILS:
                clear = abs(example.value)
            elif not singular and example.sigma > RANK_KEPT * largest and abs(example.value) <= DEFAULT.singular:
                clear = example.sigma
            else:
                continue
            if best is None or clear > 2 * best[0]:
                best = (clear, example)
        return None if best is None else best[1]

    def measure(self, theta: Array) -> tuple[Example, float]:
        """The condition and σ at angles; and the largest σ."""
        robot, task = self.chain.robot, self.chain.task
        q = theta - self.chain.shifts
        turning = [j - 1 for j in self.ring.revolute]
        q[turning] = wrap(q[turning]) + 0.0
        sigma = singular_values(self.chain.own, into_units(robot, q), self.chain.own_task)
        q = whole_angles(robot, q)
        values = [float(condition(theta, self.chain.numbers)) for condition in self.parsed]
        slides = [joint.kind is JointKind.PRISMATIC for joint in robot.variables]
        shown = tuple(float(x) if slide else degrees(x) for x, slide in zip(q, slides, strict=True))
        value = max(values, key=abs)
        return Example(tuple(map(float, q)), shown, value, float(sigma[generic_rank(robot, task) - 1])), float(sigma[0])
