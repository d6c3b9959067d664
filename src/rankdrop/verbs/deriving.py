"""The singularity conditions of an arm derived from nothing, and checked by what knows nothing of the derivation.

Phase after phase, each within its share of the work that is allowed: the rank tree, its real sets as families, corank 1
by the method a person would take, what stays open for want of points modulo primes, arms of special lengths, and
configurations found numerically, which all have to lie on a family.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from time import monotonic
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from rankdrop.algebra.polynomial import PRIMES
from rankdrop.algebra.work import GRACE, SLOWER, OutOfTime, Work, failure
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.arm.parts import whole_angles
from rankdrop.exact.derivation import CorankOne, check_method, corank_one
from rankdrop.exact.determinants import Determinants, determinants_of
from rankdrop.exact.families import Reality, families, real_sets
from rankdrop.exact.family import (
    Assumption,
    Unreal,
    UnrealSet,
    alone,
    equations_in_parts,
    families_in_whole_angles,
    merge,
)
from rankdrop.exact.letters import (
    assumptions,
    decided_by_numbers,
    sign_of,
    splits,
    sum_text,
    with_equal_lengths,
)
from rankdrop.exact.lint import round_points
from rankdrop.exact.method_reason import MethodReason
from rankdrop.exact.tree import Drop, OpenCase, Tree, rank_tree
from rankdrop.exact.undivided import UndividedSet, cases_in_whole_angles, undivided_sets
from rankdrop.families.inspection import DIGITS, FOLLOWED, descents, near_misses
from rankdrop.families.pictured import posed
from rankdrop.families.points import Cloud, cloud, explained
from rankdrop.families.record import Check, Family, exact_of
from rankdrop.formula.equation import Equation
from rankdrop.formula.notation import Step
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.problem import Problem
from rankdrop.questions import ConditionsOptions
from rankdrop.results.conditions import Conditions
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.quantities import count, read_joints
from rankdrop.task import Task
from rankdrop.text.by_hand import every_step, higher_differences_texts, higher_left_texts
from rankdrop.text.families import (
    MISSED_BY_LETTERS,
    assumption_text,
    equal_lengths_text,
    following_texts,
    near_misses_text,
    not_singular_text,
    on_no_family_text,
)
from rankdrop.text.structure import chain_remarks, near_structure_texts
from rankdrop.tolerances import DEFAULT
from rankdrop.units import into_units, out_of_units
from rankdrop.verbs.found_coranks import tried_numerically

Made = TypeVar("Made")
_Derived = tuple[Chain, Tree, Work, tuple[str, ...]]
"""The chain that was derived, its rank tree, the work that is left, and remarks."""
_TREE = 0.85  # of the work left that the tree may take
_SHARE = 0.7  # of the work left that another phase may take: real sets, a method, special lengths
_LEAST = 0.15  # of all work that the real sets have in any case: without them there is no family
_LETTERS = 0.25  # of the work left that the tree may take with letters that nobody asked for
_SYSTEM = ("system of conditions", "systems of conditions")
_OWN, _OWN_ALL = 2, 8  # real points of each set, and of each family, at which σ is taken with `DIGITS` digits
_ROUNDED = 1e-13  # σ that the rounding of an arm's own axes leaves, a hundred times over [1]
_NEXT = 1e-5  # from a point with rounded coordinates to the singular configuration it stands for, of a square [rad]
_POINTS = 24  # real points looked at on each set that has none modulo primes


def derived(
    robot: Robot,
    task: str | Task | None,
    asked: ConditionsOptions,
    progress: Callable[[str, int, int], None] | None = None,
) -> Conditions:
    """The conditions of an arm; arguments and errors are those of `rankdrop.conditions`."""
    begun = monotonic()
    work = Work(asked.seconds / SLOWER, asked.seed, progress)
    given = exact_chain(robot, task, lengths=asked.lengths, parts=True)
    basic = None if asked.basic is None else read_joints(asked.basic)
    check_method(given, asked.method, basic=basic, frame=asked.frame)
    lowest = _lowest_rank(given, asked.coranks)
    left: list[str] = []
    nothing = Tree(generic_rank(given.own, given.own_task), complete=False)
    underived: _Derived = given, nothing, work, ()
    chain, tree, work, remarks = _guarded(
        "the rank tree", lambda: _tree(given, lowest, optional=asked.lengths == "auto", work=work), underived, left
    )
    left += _unstated(tree)
    found: list[Family] = []
    not_real: list[UnrealSet] = []
    wrong: list[str] = []
    unsettled: list[OpenCase] = []
    with work.share(_SHARE, _LEAST * asked.seconds):
        found, not_real, wrong = _guarded(
            "the families", lambda: _families(chain, tree, work, left, unsettled), (found, not_real, wrong), left
        )
    first = _unless_interrupted(
        work, left, "the method for corank 1",
        lambda own: corank_one(
            chain, asked.method, tree, found, own, chosen=(basic, asked.frame), highest=asked.coranks
        ),
        CorankOne("tree", MethodReason(interrupted=True), None, ("the method for corank 1",)),
    )  # fmt: skip
    higher = _unless_interrupted(
        work, left, "coranks above 1", lambda _: tried_numerically(first.higher, asked.seed), first.higher
    )
    steps: tuple[Step, ...] = ()
    if asked.steps or isinstance(first.derived, Tree):
        steps = _unless_interrupted(work, left, "the steps", lambda _: every_step(chain, first), ())
    determinants: Determinants | None = None
    if asked.steps:
        determinants = _unless_interrupted(work, left, "the determinant", lambda own: determinants_of(chain, own), None)
    unmet: list[UnrealSet] = []
    unmet = _guarded(
        "sets without points",
        lambda: _sets_without_points(chain, tree, found, asked.seed, left, unsettled), unmet, left,
    )  # fmt: skip
    left += [*first.left, *higher_left_texts(higher)]
    lowest = _stated_rank(tree, lowest)
    stated = replace(tree, cases=[*tree.cases, *unsettled])
    undivided: Sequence[UndividedSet] = ()
    undivided = _guarded("the undivided cases", lambda: _undivided(chain, stated, found, work, left), undivided, left)
    not_real += unmet
    assumed: Sequence[Assumption] = ()
    assumed = _guarded(
        "the assumptions", lambda: _assumptions(chain, tree, lowest, work, left, derive=asked.special), assumed, left
    )
    left += _not_holding(assumed)
    check, over, misses = _cloud(chain, tree.generic_rank, lowest, (*found, *undivided), asked.points, work, left)
    differing = [*first.disagreements, *higher_differences_texts(higher)]
    if not tree.divided:  # another method may have what the tree has not come to
        left += differing
        differing = []
    if left:  # what is left over belongs to what was not derived
        left += over
        over = []
    result = Conditions(
        robot=robot,
        task=chain.task,
        generic_rank=tree.generic_rank,
        letters={name: float(value) for name, value in chain.letters.items()},
        shifts=tuple(float(x) for x in chain.whole_shifts),
        remarks=(
            *chain_remarks(chain), *following_texts(robot), *remarks, *misses, *near_structure_texts(chain)
        ),
        method=first.method,
        reason=first.reason,
        steps=steps,
        determinants=determinants,
        families=families_in_whole_angles(robot, posed_exactly(chain.parted, chain.task, found)),
        lowest=lowest,
        assumptions=tuple(assumed),
        not_real=tuple(not_real),
        explained=check,
        disagreements=(*differing, *wrong, *over),
        complete=tree.stated and not left,
        interrupted=work.interrupted,
        left=tuple(left),
        seconds=monotonic() - begun,
        limited=work.limited,
        settings=asked,
        undivided=cases_in_whole_angles(robot, undivided),
    )
    return _with_numbers_where_missed(result, over, work, progress)


def _with_numbers_where_missed(
    result: Conditions, over: Sequence[str], work: Work, progress: Callable[[str, int, int], None] | None
) -> Conditions:
    """A result; derived with numbers, in the time that is left, where its letters, that nobody asked for, miss singular
    configurations: a rank is lost for these lengths only.
    """
    asked = result.settings
    optional = bool(result.letters) and asked.lengths == "auto"
    if not (over and optional) or work.interrupted or work.left <= 0 or work.time_left <= 0:
        return result
    seconds = SLOWER * work.left
    found = derived(result.robot, result.task, replace(asked, lengths="numbers", seconds=seconds), progress)
    return replace(found, remarks=(*found.remarks, MISSED_BY_LETTERS), settings=asked)


def _lowest_rank(chain: Chain, coranks: int | None) -> int:
    """The rank down to which conditions are derived: all of them, or so many coranks."""
    if coranks is None:
        return 0
    return max(min(chain.task.m, chain.n) - coranks, 0)


def _not_holding(assumptions: Sequence[Assumption]) -> list[str]:
    """Sentences on assumptions that the arm does not satisfy."""
    return [assumption_text(one.text) for one in assumptions if not one.holds]


def posed_exactly(robot: Robot, task: Task, families: Sequence[Family]) -> tuple[Family, ...]:
    """Families with the witnesses that `analyze` shows: in good postures, see `rankdrop.families.posed`."""
    return tuple(posed(robot, task, one, families) for one in families)


def _broken(chain: Chain, work: Work) -> tuple[str, ...]:
    """Why what holds for general lengths need not hold for this arm."""
    told = ("conditions that are independent for general lengths are not for these",)
    return (told if work.special else ()) + tuple(
        f"{sum_text(chain.ring, f)} = 0 for these lengths, which letters rule out"
        for f in work.assumed.values()
        if sign_of(chain, f) == 0
    )


def _turns_out_broken(chain: Chain, work: Work) -> Callable[[], bool]:
    """A function that says whether `_broken` has anything to tell so far; assumptions are read once."""
    known: set[str] = set()

    def broken() -> bool:
        if not chain.letters:
            return False
        fresh = [key for key in work.assumed if key not in known]
        known.update(fresh)
        return work.special or any(sign_of(chain, work.assumed[key]) == 0 for key in fresh)

    return broken


def _with_equal_lengths(chain: Chain, lowest: int, work: Work) -> _Derived | None:
    """The rank tree with one letter for lengths that are equal; None where that takes too long, or does not hold."""
    special = with_equal_lengths(chain)
    if special is None:
        return None
    again = work.again()
    with again.share(_LETTERS):
        tree = rank_tree(special, again, lowest=lowest, unwanted=_turns_out_broken(special, again))
    if not tree.finished or _broken(special, again) or splits(special, tree):
        return None
    return special, tree, again, (equal_lengths_text(_equal_lengths(chain, special)),)


def _equal_lengths(chain: Chain, special: Chain) -> list[tuple[str, bool, str]]:
    """(letter that was replaced, whether its length has the same sign, letter that stands for it now)."""
    equal = []
    for name, length in chain.letters.items():
        if name in special.letters:
            continue
        for other in special.letters:
            if abs(chain.letters[other]) == abs(length):
                equal.append((name, length == chain.letters[other], other))
    return equal


def _tree(chain: Chain, lowest: int, *, optional: bool, work: Work) -> _Derived:
    """The rank tree; with numbers where letters that nobody asked for take too long or leave systems over that matter
    for this arm, or where letters rule out its lengths.
    """
    optional = optional and bool(chain.letters)
    with work.share(_LETTERS if optional else _TREE):
        tree = rank_tree(chain, work, lowest=lowest, unwanted=_turns_out_broken(chain, work))
    broken = _broken(chain, work)
    if splits(chain, tree):
        broken += ("a condition has several factors for these lengths",)
    if work.interrupted or not chain.letters:
        return chain, tree, work, ()
    if broken:
        return _with_equal_lengths(chain, lowest, work) or _without_letters(chain, lowest, broken, work)
    if _leaves_over(tree, optional=optional):
        return _decided_by_numbers(chain, tree, lowest, optional=optional, work=work)
    return chain, tree, work, ()


def _without_letters(chain: Chain, lowest: int, broken: Sequence[str], work: Work) -> _Derived:
    """The rank tree with numbers, since conditions with letters do not hold for these lengths."""
    plain, other, again = _with_numbers(chain, lowest, work)
    return plain, other, again, tuple(f"{text}: derived with numbers" for text in broken)


def _with_numbers(chain: Chain, lowest: int, work: Work) -> tuple[Chain, Tree, Work]:
    """The chain with numbers for all lengths, its rank tree, and the work that is left."""
    plain, again = replace(chain, letters={}, written={}), work.again()
    with again.share(_TREE):
        return plain, rank_tree(plain, again, lowest=lowest), again


def _decided_by_numbers(chain: Chain, tree: Tree, lowest: int, *, optional: bool, work: Work) -> _Derived:
    """The rank tree with numbers where it decides more than the one with letters, else the latter."""
    plain, other, again = _with_numbers(chain, lowest, work)
    if decided_by_numbers(chain, tree, other):
        return chain, replace(tree, unresolved=[], cases=[]), work, ()  # what letters leave over is not there
    remark = _why_numbers(tree, other, again, optional=optional)
    if remark is None:
        return chain, tree, work, ()
    return plain, other, again, (remark,)


def _leaves_over(tree: Tree, *, optional: bool) -> bool:
    """Whether numbers may decide more than a tree with letters did: one cut short, or one with unresolved systems."""
    if tree.complete:
        return bool(tree.unresolved)
    return optional


def _why_numbers(tree: Tree, other: Tree, again: Work, *, optional: bool) -> str | None:
    """Why the tree with numbers, `other`, replaces the one with letters; None where it does not."""
    if not tree.complete and optional:
        if not other.complete and not again.interrupted:
            return None
        return "lengths are numbers: with letters the derivation takes longer than it may"
    if not optional or not other.finished:
        return None
    return f"lengths are numbers: with letters {count(len(tree.unresolved), *_SYSTEM)} could not be taken apart"


def _families(
    chain: Chain, tree: Tree, work: Work, left: list[str], unsettled: list[OpenCase]
) -> tuple[list[Family], list[UnrealSet], list[str]]:
    """(families, sets without real points, disagreements).

    Sets that are not finished become cases, which go to `unsettled`; in sentences they go to `left` where the tree does
    not state all cases.
    """
    cases: list[Drop] | None = None
    if tree.stated:
        cases = []
    sets, not_real = real_sets(chain, tree.drops, work, left, work.seed, cases)
    unsettled += [OpenCase(drop.piece, drop.rank + 1) for drop in cases or ()]
    found = families(chain, sets, tree.generic_rank, work)
    left += _not_singular(chain, sets, found, tree.generic_rank)
    wrong = []
    for family in found:
        check = exact_of(family).rank_check
        if not check.holds:
            wrong.append(
                f"{family.id}: the rank modulo a prime is not {tree.generic_rank - family.corank} at "
                f"{check.tested - check.agree} of {check.tested} random points"
            )
    return found, not_real, wrong


def _not_singular(
    chain: Chain, sets: Sequence[tuple[Drop, Reality]], families: Sequence[Family], generic_rank: int
) -> list[str]:
    """Sentences on the families that have random real points at which σ does not vanish with `DIGITS` digits.

    The rank modulo a prime is taken at random lengths where lengths are letters: this is the arm with its own lengths.
    """
    met = {id(drop.piece): reality.points for drop, reality in sets}
    told = []
    for family in families:
        problem = Problem(chain.own, chain.own_task, family.corank)
        points = np.concatenate([met[id(piece)][:_OWN] for piece in exact_of(family).pieces])[:_OWN_ALL]
        wrong = sum(not _vanishes(problem, q) for q in points)
        if wrong:
            told.append(not_singular_text(family.id, generic_rank - family.corank + 1, wrong, len(points), DIGITS))
    return told


def _vanishes(problem: Problem, q: Array) -> bool:
    """Whether a configuration of the corank asked about is next to q, which satisfies its conditions to rounding.

    Where σ vanishes at q itself the arm is singular there; a descent from such a point may end elsewhere on the set.
    """
    if problem.sigma(q)[problem.rank] <= _ROUNDED:
        return True
    return any(
        sigma <= _ROUNDED and problem.length(end - q) <= _NEXT
        for end, sigma in descents(problem, q)
    )


def _guarded(label: str, make: Callable[[], Made], otherwise: Made, left: list[str]) -> Made:
    """What is made; `otherwise`, and the reason in `left`, where it fails: no failure ends what else was found."""
    try:
        return make()
    except Exception as error:
        left.append(f"{label}: {failure(error)}")
        return otherwise


def _unless_interrupted(
    work: Work, left: list[str], label: str, make: Callable[[Work], Made], otherwise: Made
) -> Made:
    """What is made with a share of the work that is left; `otherwise` where it fails or the user has asked to stop."""
    if not work.interrupted:
        work.show(label, 0, 1)
        own = Work(max(_SHARE * work.left, 0.1), work.seed)
        try:
            return _guarded(label, lambda: make(own), otherwise, left)
        except KeyboardInterrupt:
            work.interrupt()
    return otherwise


def _stated_rank(tree: Tree, lowest: int) -> int:
    """The rank down to which families and cases hold all configurations; as asked for where a tree is left open."""
    if tree.stated:
        return max(lowest, tree.lowest)
    return lowest


def _undivided(
    chain: Chain, tree: Tree, families: Sequence[Family], work: Work, left: list[str]
) -> tuple[UndividedSet, ...]:
    """The cases that were not taken apart; where the configuration on one is not singular with `DIGITS` digits a
    sentence goes to `left`.
    """
    if not tree.stated:
        return ()
    if work.interrupted:
        if tree.cases:
            left.append("the cases that were not taken apart")
        return ()

    def off_families(q: Array, corank: int) -> NDArray[np.int64]:
        known = [_own_equations(chain, one) for one in families if one.corank >= corank]
        return explained(Cloud(chain.own, chain.own_task, q, np.full(len(q), corank)), known)[1]

    cases = undivided_sets(chain, tree, off_families, work.seed)
    for number, one in enumerate(cases, 1):
        if one.witness is None:
            continue
        q = into_units(chain.robot, one.witness)
        if not _vanishes(Problem(chain.own, chain.own_task, one.corank), q):
            left.append(not_singular_text(f"case {number}", tree.generic_rank - one.corank + 1, 1, 1, DIGITS))
    return cases


def _unstated(tree: Tree) -> list[str]:
    """What a tree leaves open, in sentences: nothing where its cases hold the rest."""
    if tree.stated:
        return []
    if not tree.unresolved:
        return tree.left
    return [
        *tree.left,
        f"{count(len(tree.unresolved), *_SYSTEM)} could not be taken apart, three or more of them on the same joints: "
        "where they hold together the rank may drop, and no family says so; numerically found configurations "
        "(rankdrop analyze) do not depend on this"
    ]


def _assumptions(
    chain: Chain, tree: Tree, lowest: int, work: Work, left: list[str], *, derive: bool
) -> Sequence[Assumption]:
    """What is assumed of the lengths; arms of special lengths are derived where that is wanted and work is left."""
    if derive and not work.interrupted:
        work.show("arms of special lengths", 0, 1)
        try:
            with work.share(_SHARE):
                return assumptions(chain, tree.drops, lowest, work, derive=True)
        except OutOfTime:
            pass
        except KeyboardInterrupt:
            work.interrupt()
    if derive:
        left.append("arms of special lengths")
    return assumptions(chain, tree.drops, lowest, work, derive=False)


def _cloud(
    chain: Chain,
    generic_rank: int,
    lowest: int,
    families: Sequence[Family | UndividedSet],
    points: int,
    work: Work,
    left: list[str],
) -> tuple[Check, list[str], list[str]]:
    """Singular configurations found numerically, tried on the families, and sentences on those left over and on those
    that 50 digits show not to be singular.

    What was not looked for goes to `left`.
    """
    tested = agree = 0
    over: list[str] = []
    misses: list[str] = []
    for corank in range(1, generic_rank - lowest + 1):
        if not points or work.interrupted:
            break
        if corank > 1 and work.time_left < -GRACE:  # a tenth of the points takes little time
            left.append(f"numeric configurations of corank {corank} and above: the processor's time ran out")
            break
        work.show("checks", corank - 1, generic_rank - lowest)
        try:
            met = cloud(chain.own, chain.own_task, corank, _wanted(points, corank), work.seed)
            if not len(met.q):
                break
            found = _on_families(chain, met.up_to(generic_rank - lowest), corank, families)
        except KeyboardInterrupt:
            work.interrupt()
            break
        tested, agree = tested + found.check.tested, agree + found.check.agree
        if found.wrong:
            misses.append(near_misses_text(corank, found.wrong, min(found.wrong, FOLLOWED), found.sigma, DIGITS))
        if len(found.off):
            over.append(on_no_family_text(corank, len(found.off), found.check.tested, found.off[0]))
    return Check(tested, agree), over, misses


class _OnFamilies(NamedTuple):
    """How many points of a cloud lie on families.

    Attributes:
        check: of those that are singular.
        off: (N, n) the singular ones on no family [rad, m].
        wrong: how many are not singular.
        sigma: the smallest σ next to these.
    """

    check: Check
    off: Array
    wrong: int
    sigma: float


def _on_families(
    chain: Chain, met: Cloud, corank: int, families: Sequence[Family | UndividedSet]
) -> _OnFamilies:
    """Points of a cloud on the families of a corank or a larger one, or on cases of these that were not taken apart;
    those on none are followed with 50 digits.
    """
    equations = [_own_equations(chain, family) for family in families if family.corank >= corank]
    check, remaining = explained(met, equations)
    wrong, sigma = near_misses(met, remaining, equations)
    off = whole_angles(chain.robot, out_of_units(chain.robot, met.q[np.setdiff1d(remaining, wrong)]))
    return _OnFamilies(Check(check.tested - len(wrong), check.agree), off, len(wrong), sigma)


def _own_equations(chain: Chain, family: Family | UndividedSet) -> tuple[Equation, ...]:
    """The conditions for the arm in its own unit of length."""
    if isinstance(family, UndividedSet):
        return family.equations
    return equations_in_parts(family, chain.robot)


def _wanted(points: int, corank: int) -> int:
    """How many numeric configurations a corank is tried with: all of them, or a tenth."""
    if corank == 1:
        return points
    return max(points // 10, 1)


def _sets_without_points(
    chain: Chain,
    tree: Tree,
    families: Sequence[Family],
    seed: int,
    left: list[str],
    unsettled: list[OpenCase],
) -> list[UnrealSet]:
    """The sets on which no real point was found. What the tree leaves open for want of points goes to `unsettled` as
    cases; in a sentence it goes to `left` where the tree does not state all cases.

    A set is no loss where all real points found lie on the families of a rank as low, or where the rank is not lower
    there and no smaller set inside it is looked for. That none was found is no proof that there is none.

    The tree tells sets apart at random points modulo primes. With letters for lengths a set has such points for about
    every other value of them, with numbers modulo about every other prime; a few have none modulo all that are tried.
    """
    lost: dict[str, OpenCase] = {}
    unmet: dict[str, ZeroSet] = {}
    for piece, order, last in tree.without_points:
        theta = [point for point, _ in zip(round_points(piece, chain, seed=seed), range(_POINTS), strict=False)]
        if not theta:
            unmet[piece.key] = piece
        elif piece.key not in lost and not _settled(chain, tree, families, np.array(theta), order, last):
            lost[piece.key] = OpenCase(piece, order)
    unreal = [UnrealSet(row.text, Unreal.NOR_MODULO_PRIMES, tried=len(PRIMES)) for row in merge(list(unmet.values()))]
    if tree.stated:
        unsettled += lost.values()
    elif lost:
        left.append(_sentence([one.piece for one in lost.values()], letters=bool(chain.letters)))
    return unreal


def _sentence(lost: Sequence[ZeroSet], *, letters: bool) -> str:
    sets = count(len(lost), "set of real configurations", "sets of real configurations")
    shortest = min(map(alone, lost), key=lambda row: row.terms)
    where = f" ({'' if len(lost) == 1 else 'one is '}{shortest.text})"
    return (
        f"{sets}{where} could not be derived: roots of numbers that stand in the conditions exist modulo none of "
        f"the {len(PRIMES)} primes by which ranks are taken. Whether the rank drops inside is not "
        f"known{'' if letters else '; --lengths letters may avoid this'}"
    )


def _settled(
    chain: Chain,
    tree: Tree,
    families: Sequence[Family],
    theta: Array,
    order: int,
    last: bool,
) -> bool:
    q = into_units(chain.robot, theta - chain.shifts)
    rank = (singular_values(chain.own, q, chain.own_task) > DEFAULT.singular).sum(axis=1)
    low = rank < order
    if not low.any():
        return last
    corank = tree.generic_rank - rank
    for k in sorted(set(corank[low].tolist())):
        here = q[low & (corank == k)]
        known = [_own_equations(chain, family) for family in families if family.corank >= k]
        _, over = explained(Cloud(chain.own, chain.own_task, here, np.full(len(here), k)), known)
        if len(over):
            return False
    return bool(low.all()) or last
