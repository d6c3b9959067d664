"""One verb: from a robot to its singularity conditions, exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from time import monotonic

from rankdrop._handles import check_robot
from rankdrop.derived import Conditions, Step
from rankdrop.errors import OptionError
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.arm.letters import sign_of, sum_text
from rankdrop.exact.arm.structure import structure_of
from rankdrop.exact.check import Check
from rankdrop.exact.derivation import METHODS, corank_one
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
POINTS = 1000
"""Singular configurations found numerically that the families have to explain."""


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
    _check(method, coranks, seconds, points)
    begun = monotonic()
    chain = exact_chain(robot, task, lengths=lengths, snap=snap)
    work = Work(seconds, seed, progress)
    full = min(chain.task.m, chain.n)
    lowest = 0 if coranks is None else max(full - coranks, 0)
    tree = rank_tree(chain, work, lowest=lowest)
    broken = _broken(chain, work)
    if broken:  # what letters rule out is so for this arm: its numbers alone tell what it does
        chain = exact_chain(robot, task, lengths="numbers", snap=snap)
        work = Work(max(work.left, 0.1), seed, progress)
        tree = rank_tree(chain, work, lowest=lowest)
    left = list(tree.left)
    found, not_real, extra = _families(chain, tree, work, seed, left)
    first = corank_one(chain, method, tree, found, Work(max(work.left, 0.1), seed), steps=steps)
    left += [*first.left, *_unresolved(work)]
    assumed = _assumptions(chain, tree, lowest, work, left) if special else ()
    check, over = _cloud(chain, tree.generic_rank, lowest, found, seed, points, progress)
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
        complete=tree.complete and not left,
        left=tuple(left),
        seconds=monotonic() - begun,
        seed=seed,
        version=VERSION,
    )


def _check(method: str, coranks: int | None, seconds: float, points: int) -> None:
    if method not in METHODS:
        raise OptionError("there is no such method", where="method", got=repr(method), allowed=", ".join(METHODS))
    if coranks is not None and coranks < 1:
        raise OptionError("the highest corank is at least 1", where="coranks", got=coranks)
    if not seconds > 0:
        raise OptionError("the time limit is positive", where="seconds", got=seconds)
    if points < 0:
        raise OptionError("a number of points is not negative", where="points", got=points)


def _broken(chain: Chain, work: Work) -> tuple[str, ...]:
    """Assumptions on lengths that the arm's own lengths break, in words."""
    return tuple(
        f"{sum_text(chain.ring, f)} = 0 for these lengths, which letters rule out: derived with numbers"
        for f in work.assumed.values()
        if sign_of(chain, f) == 0
    )


def _families(
    chain: Chain, tree: Tree, work: Work, seed: int, left: list[str]
) -> tuple[list[ExactFamily], list[str], list[str]]:
    """(families, sets without real points, disagreements); what time did not allow is added to `left`."""
    try:
        sets, not_real = real_sets(chain, tree.drops, work, seed)
        found = families(chain, sets, tree.generic_rank, work, partial(described, chain, tree.generic_rank))
    except OutOfTime:
        left.append(f"{len(tree.drops)} sets were found, but not looked at for real points")
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


def _assumptions(chain: Chain, tree: Tree, lowest: int, work: Work, left: list[str]) -> Sequence[Assumption]:
    try:
        return assumptions(chain, tree.drops, tree.generic_rank, lowest, work)
    except OutOfTime:
        left.append("arms of special lengths")
        return ()


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
            q = ", ".join(f"{x:.6g}" for x in met.q[remaining[0]])
            over.append(
                f"corank {corank}: {len(remaining)} of {check.tested} configurations found numerically lie on no "
                f"family, q = ({q}) is one"
            )
    return Check(tested, agree), over
