"""One verb: from a robot to its singularity conditions, exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from time import monotonic

import numpy as np

from rankdrop._handles import check_robot
from rankdrop.compare.cloud import cloud, explained, sets_without_points
from rankdrop.errors import OptionError
from rankdrop.exact.algebra.work import SLOWER, OutOfTime, Work
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.arm.structure import structure_of
from rankdrop.exact.derivation import METHODS, CorankOne, check_method, corank_one
from rankdrop.exact.determinants import Determinants, determinants_of
from rankdrop.exact.families import families, real_sets
from rankdrop.exact.family import Assumption, ExactFamily, described
from rankdrop.exact.letters import assumptions, decided_by_numbers, doubled, sign_of, sum_text
from rankdrop.exact.tree import Tree, rank_tree
from rankdrop.families.posture import posed
from rankdrop.families.searching import check_numbers
from rankdrop.family.record import Check, Family, Sampled
from rankdrop.results.conditions.conditions import Conditions
from rankdrop.results.conditions.data import ConditionSettings
from rankdrop.results.conditions.known import known_conditions
from rankdrop.robot.model import Robot
from rankdrop.task import Task
from rankdrop.units import out_of_units
from rankdrop.version import VERSION

Progress = Callable[[str, int, int], None]
"""progress(label, done, total), label such as "sets looked into"."""
POINTS = 1000
"""Singular configurations found numerically that the families have to explain."""
MOST_POINTS = 100_000
"""More of them take longer than any derivation."""
_SHARE = 0.7  # of the time left that a phase may take: the tree, real sets, a method, special lengths
_LETTERS = 0.5  # of the time left that the tree may take with letters that nobody asked for
_PLAIN = ("auto", "auto", None, 0, POINTS, True, False)  # what the shipped conditions answer


def conditions(
    robot: Robot,
    task: str | Task | None = None,
    *,
    method: str = "auto",
    lengths: str | Mapping[str, float] = "auto",
    coranks: int | None = None,
    seconds: float = 60.0,
    seed: int = 0,
    points: int = POINTS,
    special: bool = True,
    steps: bool = False,
    basic: Sequence[int] | None = None,
    frame: int | None = None,
    fresh: bool = False,
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
        coranks: the highest corank to derive; None for all.
        seconds: limit on the processor's time. A third of it is the limit on the work done, counted in steps, so that
            the result does not depend on how fast the machine is unless time is what ends it, which is told; how busy
            it is never counts. What was derived by then is returned, and what is left is told. So it is after Ctrl-C.
        seed: of every random choice.
        points: how many singular configurations of corank 1 to try; a tenth for each corank above; 0 for none.
        steps: also write the derivation of corank 1 down, step by step as it is done by hand, and the determinant of
            the Jacobian, or the minors that take its place, in factors.
        basic, frame: with the methods "suppression" and "reciprocity": numbers of the six basic screws, and link in
            whose frame the screws are taken; None for the rules of the method, which steps give the reasons of.
        special: also derive the arms whose lengths break an assumption.
        fresh: derive them even where the conditions of this arm are shipped with rankdrop. Those answer the question
            with all its defaults (but for the time limit), and are what a derivation gives.
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
    _check(method, coranks, seconds, points, seed)
    basic = None if basic is None else tuple(sorted(int(j) for j in basic))
    plain = (method, lengths, coranks, seed, points, special, steps) == _PLAIN
    asked_plainly = plain and basic is None and frame is None
    if asked_plainly and not fresh:
        anew = partial(conditions, robot, task, points=0, special=False, fresh=True)
        shipped = known_conditions(robot, task, anew=anew)
        if shipped is not None:
            return replace(shipped, settings=replace(shipped.settings, seconds=seconds))
    begun = monotonic()
    work = Work(seconds / SLOWER, seed, progress)
    asked = exact_chain(robot, task, lengths=lengths)
    check_method(asked, method, basic=basic, frame=frame)
    chain, tree, work, remarks = _tree(asked, coranks, lengths, work)
    lowest = _lowest(chain, coranks)
    left = list(tree.left)
    with work.share(_SHARE):
        found, not_real, wrong = _families(chain, tree, work, seed, left)
    first = _first(chain, method, tree, found, work, seed, steps, basic, frame)
    said = _said(chain, work) if steps else None
    hidden, unmet = sets_without_points(chain, tree, found, seed)
    left += [*first.left, *_unresolved(tree), *hidden]
    not_real += unmet
    assumed = _assumptions(chain, tree, lowest, work, left) if special else ()
    check, over = _cloud(chain, tree.generic_rank, lowest, found, points, work, left)
    if left:  # what is left over belongs to what was not derived
        left += over
        over = []
    return Conditions(
        robot=robot,
        task=chain.task,
        generic_rank=tree.generic_rank,
        letters=chain.numbers,
        shifts=tuple(float(x) for x in chain.shifts),
        remarks=(*chain.remarks, *remarks, *(one.text for one in structure_of(chain).near)),
        method=first.method,
        reason=first.reason,
        steps=first.steps,
        determinants=said,
        families=tuple(posed_exactly(robot, chain.task, family) for family in found),
        lowest=lowest,
        assumptions=tuple(assumed),
        not_real=tuple(not_real),
        explained=check,
        disagreements=(*first.disagreements, *wrong, *over),
        complete=tree.complete and not left,
        interrupted=work.interrupted,
        left=tuple(left),
        seconds=monotonic() - begun,
        settings=ConditionSettings(
            method=method, lengths=lengths if isinstance(lengths, str) else dict(lengths), coranks=coranks,
            seconds=seconds, seed=seed, points=points, special=special, steps=steps, version=VERSION,
            basic=basic, frame=frame,
        ),
        chain=chain,
    )  # fmt: skip


def posed_exactly(robot: Robot, task: Task, family: ExactFamily) -> ExactFamily:
    """The family with the witness that `analyze` shows: in a good posture, see `rankdrop.families.posed`."""
    sampled = posed(robot, task, Family(
        id=family.id, name=family.name, corank=family.corank, dimension=family.dimension, pinned=family.pinned(robot),
        free=family.free, coupled=family.coupled, equations=family.equations, witness=family.witness,
        lost_directions=np.empty((0, 6)), lost_words=family.lost_words,
        evidence=Sampled("exact condition", Check(0, 0), Check(0, 0)),
    ))  # fmt: skip
    return replace(family, witness=sampled.witness, lost_words=sampled.lost_words)


def _check(method: str, coranks: int | None, seconds: float, points: int, seed: int) -> None:
    if method not in METHODS:
        raise OptionError("there is no such method", where="method", got=repr(method), allowed=", ".join(METHODS))
    if coranks is not None and coranks < 1:
        raise OptionError("the highest corank is at least 1", where="coranks", got=coranks)
    if not seconds > 0:
        raise OptionError("the time limit is positive", where="seconds", got=seconds)
    if not 0 <= points <= MOST_POINTS:
        raise OptionError("points is outside the range", got=points, allowed=f"0 … {MOST_POINTS}")
    check_numbers(1, seed, 0)


def _broken(chain: Chain, work: Work) -> tuple[str, ...]:
    """Assumptions on lengths that the arm's own lengths break, in words."""
    told = ("conditions that are independent for general lengths are not for these: derived with numbers",)
    return (told if work.special else ()) + tuple(
        f"{sum_text(chain.ring, f)} = 0 for these lengths, which letters rule out: derived with numbers"
        for f in work.assumed.values()
        if sign_of(chain, f) == 0
    )


def _lowest(chain: Chain, coranks: int | None) -> int:
    return 0 if coranks is None else max(min(chain.task.m, chain.n) - coranks, 0)


def _tree(
    chain: Chain, coranks: int | None, lengths: str | Mapping[str, float], work: Work
) -> tuple[Chain, Tree, Work, tuple[str, ...]]:
    """The rank tree; with numbers where letters that nobody asked for take too long or leave systems over that matter
    for this arm, or where letters rule out its lengths.
    """
    lowest = _lowest(chain, coranks)
    optional = lengths == "auto" and bool(chain.letters)
    with work.share(_LETTERS if optional else _SHARE):
        tree = rank_tree(chain, work, lowest=lowest)
    broken = _broken(chain, work)
    over = len(tree.unresolved)
    open_ = not tree.complete and optional
    double = doubled(chain, tree)
    if double:
        broken += ("a condition has a square in it for these lengths: derived with numbers",)
    if work.interrupted or not chain.letters or not (broken or open_ or (tree.complete and over)):
        return chain, tree, work, ()
    plain, again = replace(chain, letters={}, written={}), work.again()
    with again.share(_SHARE):
        other = rank_tree(plain, again, lowest=lowest)
    if not double and decided_by_numbers(chain, tree, other):
        return chain, replace(tree, unresolved=[]), work, ()  # what letters rule out or leave over is not there
    if broken:
        return plain, other, again, broken
    if open_:
        if not other.complete and not again.interrupted:
            return chain, tree, work, ()
        return plain, other, again, ("lengths are numbers: with letters the derivation takes longer than it may",)
    if not optional or not other.finished:
        return chain, tree, work, ()
    return plain, other, again, (f"lengths are numbers: with letters {_systems(over)} could not be taken apart",)


def _families(
    chain: Chain, tree: Tree, work: Work, seed: int, left: list[str]
) -> tuple[list[ExactFamily], list[str], list[str]]:
    """(families, sets without real points, disagreements); what time did not allow is added to `left`."""
    sets, not_real = real_sets(chain, tree.drops, work, left, seed)
    found = families(chain, sets, tree.generic_rank, work, partial(described, chain, tree.generic_rank))
    wrong = [
        f"{family.id}: the rank modulo a prime is not {tree.generic_rank - family.corank} at "
        f"{family.rank_check.tested - family.rank_check.agree} of {family.rank_check.tested} random points"
        for family in found
        if not family.rank_check.holds
    ]
    return found, not_real, wrong


def _first(
    chain: Chain,
    method: str,
    tree: Tree,
    found: Sequence[ExactFamily],
    work: Work,
    seed: int,
    steps: bool,
    basic: tuple[int, ...] | None,
    frame: int | None,
) -> CorankOne:
    """Corank 1 by the method a person would take; left out where the user has asked to stop."""
    if not work.interrupted:
        work.show("the method for corank 1", 0, 1)
        try:
            own = Work(max(_SHARE * work.left, 0.1), seed)
            return corank_one(chain, method, tree, found, own, steps=steps, basic=basic, frame=frame)
        except KeyboardInterrupt:
            work.interrupt()
    return CorankOne("tree", "interrupted before another method was tried", (), ("the method for corank 1",))


def _said(chain: Chain, work: Work) -> Determinants | None:
    """The determinant, or the minors; None where the user has asked to stop."""
    if work.interrupted:
        return None
    work.show("the determinant", 0, 1)
    try:
        return determinants_of(chain, Work(max(_SHARE * work.left, 0.1), work.seed))
    except KeyboardInterrupt:
        work.interrupt()
        return None


def _systems(count: int) -> str:
    return "1 system of conditions" if count == 1 else f"{count} systems of conditions"


def _unresolved(tree: Tree) -> list[str]:
    if not tree.unresolved:
        return []
    return [
        f"{_systems(len(tree.unresolved))} could not be taken apart, three or more of them on the same joints: where "
        "they hold together the rank may drop, and no family says so; numerically found configurations "
        "(rankdrop analyze) do not depend on this"
    ]


def _assumptions(chain: Chain, tree: Tree, lowest: int, work: Work, left: list[str]) -> Sequence[Assumption]:
    if not work.interrupted:
        work.show("arms of special lengths", 0, 1)
        try:
            with work.share(_SHARE):
                return assumptions(chain, tree.drops, tree.generic_rank, lowest, work)
        except OutOfTime:
            pass
        except KeyboardInterrupt:
            work.interrupt()
    left.append("arms of special lengths")
    return ()


def _cloud(
    chain: Chain, generic_rank: int, lowest: int, found: Sequence[ExactFamily], points: int, work: Work, left: list[str]
) -> tuple[Check, list[str]]:
    """Singular configurations found numerically, tried on the families, and sentences on those left over.

    What was not looked for goes to `left`.
    """
    tested = agree = 0
    over = []
    here = [family.in_units(chain) for family in found]
    for corank in range(1, generic_rank - lowest + 1):
        if not points or work.interrupted:
            break
        if corank > 1 and work.time_left < 0:
            left.append(f"numeric configurations of corank {corank} and above: the processor's time ran out")
            break
        work.show("checks", corank - 1, generic_rank - lowest)
        wanted = points if corank == 1 else max(points // 10, 1)
        try:
            met = cloud(chain.own, chain.own_task, corank, wanted, work.seed)
            if not len(met.q):
                break
            met = met.up_to(generic_rank - lowest)
            check, remaining = explained(met, [family.equations for family in here if family.corank >= corank])
        except KeyboardInterrupt:
            work.interrupt()
            break
        tested, agree = tested + check.tested, agree + check.agree
        if len(remaining):
            one = out_of_units(chain.robot, met.q[remaining[0]])
            q = ", ".join(f"{round(float(x), 9) + 0.0:.6g}".replace("-", "−") for x in one)
            over.append(
                f"corank {corank}: {len(remaining):,} of {check.tested:,} configurations found numerically lie on no "
                f"family, q = ({q}) is one"
            )
    return Check(tested, agree), over
