"""One verb: from a robot to its singularity conditions, exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import inf
from time import monotonic
from typing import TypeVar

from rankdrop._handles import check_robot
from rankdrop.atlas.search import check_numbers
from rankdrop.derived.conditions import Conditions
from rankdrop.derived.data import ConditionSettings, Step
from rankdrop.errors import OptionError
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.arm.letters import sign_of, sum_text
from rankdrop.exact.arm.structure import structure_of
from rankdrop.exact.check import Check
from rankdrop.exact.derivation import METHODS, CorankOne, corank_one
from rankdrop.exact.describe import described
from rankdrop.exact.families import families, real_sets
from rankdrop.exact.family import Assumption, ExactFamily
from rankdrop.exact.special import assumptions
from rankdrop.exact.tree import Tree, rank_tree
from rankdrop.exact.verify import cloud, explained
from rankdrop.robot.model import Robot
from rankdrop.task import Task
from rankdrop.version import VERSION

Progress = Callable[[str, int, int], None]
"""progress(label, done, total), label such as "sets looked into"."""
T = TypeVar("T")
_TREE = 0.7  # of the time limit at most: what it finds has to be put in words
POINTS = 1000
"""Singular configurations found numerically that the families have to explain."""
MOST_POINTS = 100_000
"""More of them take longer than any derivation."""


def conditions(
    robot: Robot,
    task: str | Task | None = None,
    *,
    method: str = "auto",
    lengths: str | Mapping[str, float] = "auto",
    snap: float = 0.0,
    coranks: int | None = None,
    seconds: float = 60.0,
    seed: int = 0,
    points: int = POINTS,
    special: bool = True,
    steps: bool = False,
    progress: Progress | None = None,
) -> Conditions:
    """Derive the singularity conditions of an arm exactly, and check them.

    The Jacobian is written over the rational numbers in half-angle tangents, sines and cosines, and lengths. Its rank
    drops on closed sets; each is taken apart into irreducible ones, and those without real points are left out. Every
    family is checked twice, by means that know nothing of the derivation: the rank modulo a prime at random points of
    it, and `points` singular configurations found numerically, which all have to lie on one.

    Args:
        robot: revolute and prismatic joints, each a variable of its own.
        task: as in `resolve_task`; None is the one the arm is made for.
        method: for corank 1: "auto", or one of `METHODS`; the result says what was chosen and why. All give the same
            set. Every corank above comes from the rank tree.
        lengths: "auto", "letters", "numbers" or letters with values, see `exact_chain`.
        snap: lengths up to this are taken for zero [m].
        coranks: the highest corank to derive; None for all.
        seconds: time limit; what was derived by then is returned, and what is left is told.
        seed: of every random choice.
        points: how many singular configurations of corank 1 to try; a tenth for each corank above; 0 for none.
        steps: also write the derivation of corank 1 down, step by step as it is done by hand.
        special: also derive the arms whose lengths break an assumption.
        progress: called as progress(label, done, total).

    Returns:
        Conditions.

    Raises:
        RobotError: not a Robot, a helical joint, or a joint that follows another one.
        TaskError: the task does not exist.
        OptionError: an option outside what is allowed.
        MissingExtraError: python-flint is not installed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> [family.texts for family in conditions(open_robot("scara"), points=0).families]
        [('θ2 = 0 or π',)]
    """
    check_robot(robot)
    _check(method, coranks, seconds, points, snap, seed)
    begun = monotonic()
    chain = exact_chain(robot, task, lengths=lengths, snap=snap)
    work = Work(seconds, seed, progress)
    full = min(chain.task.m, chain.n)
    lowest = 0 if coranks is None else max(full - coranks, 0)
    with work.share(_TREE):
        tree = rank_tree(chain, work, lowest=lowest)
    broken = _broken(chain, work)
    if broken and not tree.interrupted:  # what letters rule out is so for this arm: its numbers alone tell what it does
        chain = exact_chain(robot, task, lengths="numbers", snap=snap)
        work = Work(max(work.left, 0.1), seed, progress)
        with work.share(_TREE):
            tree = rank_tree(chain, work, lowest=lowest)
    kept = _Kept(tree.interrupted, list(tree.left), work.show)
    found, not_real, extra = _families(chain, tree, work, seed, kept)
    first = kept.run(
        "corank 1 by another method",
        lambda: corank_one(chain, method, tree, found, Work(max(work.left, 0.1), seed), steps=steps),
        CorankOne("tree", "another method was not tried", ()),
    )
    kept.left += [*first.left, *_unresolved(work)]
    assumed: Sequence[Assumption] = ()
    if special:
        assumed = kept.run(
            "arms of special lengths", lambda: assumptions(chain, tree.drops, tree.generic_rank, lowest, work), ()
        )
    nothing: tuple[Check, list[str]] = (Check(0, 0), [])
    check, over = kept.run(
        "configurations found numerically",
        lambda: _cloud(chain, tree.generic_rank, lowest, found, seed, points, progress),
        nothing,
    )
    if kept.left:  # what is not on a family may be on one that is not derived yet
        kept.left += over
        over = []
    return Conditions(
        robot=robot,
        task=chain.task,
        generic_rank=tree.generic_rank,
        letters=chain.numbers,
        shifts=tuple(float(x) for x in chain.shifts),
        remarks=(*chain.remarks, *broken, *(one.text for one in structure_of(chain).near)),
        method=first.method,
        reason=first.reason,
        steps=tuple(Step(title, lines) for title, lines in first.steps),
        families=tuple(found),
        lowest=lowest,
        assumptions=tuple(assumed),
        not_real=tuple(not_real),
        explained=check,
        disagreements=(*first.disagreements, *extra, *over),
        complete=tree.complete and not kept.left,
        interrupted=kept.interrupted,
        left=tuple(kept.left),
        seconds=monotonic() - begun,
        settings=ConditionSettings(
            method=method, lengths=lengths if isinstance(lengths, str) else dict(lengths), snap=snap, coranks=coranks,
            seconds=seconds, seed=seed, points=points, special=special, steps=steps, version=VERSION,
        ),
        chain=chain,
    )  # fmt: skip


class _Kept:
    """What stays where time runs out or Ctrl-C comes: the step is skipped, and told as left.

    Attributes:
        interrupted: Ctrl-C came; no further step is begun.
        left: what was not finished.
    """

    def __init__(self, interrupted: bool, left: list[str], show: Progress) -> None:
        self.interrupted, self.left, self._show = interrupted, left, show

    def run(self, what: str, step: Callable[[], T], otherwise: T) -> T:
        """The result of a step, or `otherwise` where it was not finished."""
        if not self.interrupted:
            self._show(what, 0, 1)
            try:
                result = step()
                self._show(what, 1, 1)
                return result
            except OutOfTime:
                self.left.append(what)
                return otherwise
            except KeyboardInterrupt:
                self.interrupted = True
        self.left.append(f"interrupted: {what}")
        return otherwise


def _check(method: str, coranks: int | None, seconds: float, points: int, snap: float, seed: int) -> None:
    if method not in METHODS:
        raise OptionError("there is no such method", where="method", got=repr(method), allowed=", ".join(METHODS))
    if coranks is not None and coranks < 1:
        raise OptionError("the highest corank is at least 1", where="coranks", got=coranks)
    if not seconds > 0:
        raise OptionError("the time limit is positive", where="seconds", got=seconds)
    if not 0 <= points <= MOST_POINTS:
        raise OptionError("points is outside the range", got=points, allowed=f"0 … {MOST_POINTS}")
    if not 0 <= snap < inf:
        raise OptionError("a length to snap is not negative", where="snap", got=snap)
    check_numbers(1, seed, 0)


def _broken(chain: Chain, work: Work) -> tuple[str, ...]:
    """Assumptions on lengths that the arm's own lengths break, in words."""
    return tuple(
        f"{sum_text(chain.ring, f)} = 0 for these lengths, which letters rule out: derived with numbers"
        for f in work.assumed.values()
        if sign_of(chain, f) == 0
    )


def _families(
    chain: Chain, tree: Tree, work: Work, seed: int, kept: _Kept
) -> tuple[list[ExactFamily], list[str], list[str]]:
    """(families, sets without real points, disagreements); what time did not allow is told.

    After Ctrl-C in the tree this is still done: it makes what was found readable. A second one ends it.
    """
    try:
        sets, not_real = real_sets(chain, tree.drops, work, seed)
        found = families(chain, sets, tree.generic_rank, work, partial(described, chain, tree.generic_rank))
    except (OutOfTime, KeyboardInterrupt) as end:
        kept.interrupted |= isinstance(end, KeyboardInterrupt)
        why = "interrupted: " if isinstance(end, KeyboardInterrupt) else ""
        kept.left.append(f"{why}{len(tree.drops)} sets were found, but not looked at for real points")
        return [], [], []
    wrong = [
        f"{family.id}: the rank modulo a prime is not {tree.generic_rank - family.corank} at "
        f"{family.rank_check.tested - family.rank_check.agree} of {family.rank_check.tested} random points"
        for family in found
        if not family.rank_check.holds
    ]
    return found, not_real, wrong


def _unresolved(work: Work) -> list[str]:
    count = len(set(work.unresolved))
    if not count:
        return []
    return [
        f"{count} systems with more conditions than the freedoms they may bind could not be taken apart; if they have "
        "common zeros of that size, those are missing"
    ]


def _cloud(
    chain: Chain,
    generic_rank: int,
    lowest: int,
    found: Sequence[ExactFamily],
    seed: int,
    points: int,
    progress: Progress | None,
) -> tuple[Check, list[str]]:
    """Singular configurations found numerically, tried on the families; those left over as disagreements."""
    tested = agree = 0
    over = []
    for corank in range(1, generic_rank - lowest + 1):
        if not points:
            break
        if progress is not None:
            progress("checks", corank - 1, generic_rank - lowest)
        wanted = points if corank == 1 else max(points // 10, 1)
        met = cloud(chain.robot, chain.task, corank, wanted, seed)
        if not len(met.q):
            break
        rows = [family.equations for family in found if family.corank >= corank]
        check, remaining = explained(met, rows)
        tested, agree = tested + check.tested, agree + check.agree
        if len(remaining):
            q = ", ".join(f"{round(float(x), 9) + 0.0:.6g}".replace("-", "−") for x in met.q[remaining[0]])
            over.append(
                f"corank {corank}: {len(remaining):,} of {check.tested:,} configurations found numerically lie on no "
                f"family, q = ({q}) is one"
            )
    return Check(tested, agree), over
