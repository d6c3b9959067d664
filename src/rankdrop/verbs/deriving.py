"""The singularity conditions of an arm derived from nothing, and checked by what knows nothing of the derivation.

Phase after phase, each within its share of the work that is allowed: the rank tree, its real sets as families, corank 1
by the method a person would take, what stays open for want of points modulo primes, arms of special lengths, and
configurations found numerically, which all have to lie on a family.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isfinite
from time import monotonic
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from rankdrop.algebra.halt import Halt, HaltKind
from rankdrop.algebra.roots import PRIMES
from rankdrop.algebra.work import GRACE, SLOWER, OutOfTime, Work, halt_of
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.arm.parts import whole_angles
from rankdrop.exact.derivation import CorankOne, check_method, corank_one
from rankdrop.exact.determinants import Determinants, determinants_of
from rankdrop.exact.families import Reality, families, real_sets
from rankdrop.exact.family import (
    Assumption,
    EqualLengths,
    Unreal,
    UnrealSet,
    equations_in_parts,
    families_in_whole_angles,
)
from rankdrop.exact.higher_coranks import unfinished_coranks, wrong_coranks
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
from rankdrop.exact.remark import DerivationRemark, RemarkOn, chain_remarks, followers, near_structure
from rankdrop.exact.rows import merge, row_of_set
from rankdrop.exact.tree import Drop, OpenCase, RankTree, rank_tree
from rankdrop.exact.undivided import UndividedSet, cases_in_whole_angles, undivided_sets
from rankdrop.families.contradiction import Contradiction, ContradictionKind
from rankdrop.families.descent import FOLLOWED, descents
from rankdrop.families.inspection import near_misses
from rankdrop.families.pictured import pose_witness
from rankdrop.families.points import Cloud, cloud, count_explained
from rankdrop.families.record import Check, Family, exact_of
from rankdrop.families.unfinished import Phase, Unfinished, UnfinishedKind
from rankdrop.formula.equation import Equation
from rankdrop.formula.notation import Step
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.problem import Problem
from rankdrop.questions import ConditionsOptions
from rankdrop.results.conditions import Conditions
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.quantities import read_joints
from rankdrop.task import Task
from rankdrop.text.by_hand import every_step
from rankdrop.text.unfinished import PHASES
from rankdrop.tolerances import DEFAULT
from rankdrop.units import into_units, out_of_units
from rankdrop.verbs.found_coranks import tried_numerically

Made = TypeVar("Made")
_Derived = tuple[Chain, RankTree, Work, tuple[DerivationRemark, ...]]
_Left = list[Unfinished | Contradiction]
"""The chain that was derived, its rank tree, the work that is left, and remarks."""
_TREE = 0.85  # of the work left that the tree may take
_SHARE = 0.7  # of the work left that another phase may take: real sets, a method, special lengths
_LEAST = 0.15  # of all work that the real sets have in any case: without them there is no family
_LETTERS = 0.25  # of the work left that the tree may take with letters that nobody asked for
_OWN, _OWN_ALL = 2, 8  # real points of each set, and of each family, at which σ is taken with `DIGITS` digits
_ROUNDED = 1e-13  # σ that the rounding of an arm's own axes leaves, a hundred times over [1]
_NEXT = 1e-5  # from a point with rounded coordinates to the singular configuration it stands for, of a square [rad]
_POINTS = 24  # real points looked at on each set that has none modulo primes


def derive_conditions(
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
    left: _Left = []
    nothing = RankTree(generic_rank(given.own, given.own_task), complete=False)
    underived: _Derived = given, nothing, work, ()
    chain, tree, work, remarks = _guard(
        Phase.TREE, lambda: _tree(given, lowest, optional=asked.lengths == "auto", work=work), underived, left
    )
    left += _unstated_cases(tree)
    derived: list[Family] = []
    not_real: list[UnrealSet] = []
    wrong: list[Contradiction] = []
    unsettled: list[OpenCase] = []
    with work.share(_SHARE, _LEAST * asked.seconds):
        derived, not_real, wrong = _guard(
            Phase.FAMILIES, lambda: _families(chain, tree, work, left, unsettled), (derived, not_real, wrong), left
        )
    first = _unless_interrupted(
        work, left, Phase.METHOD,
        lambda phase_work: corank_one(
            chain, asked.method, tree, derived, phase_work, chosen=(basic, asked.frame), highest=asked.coranks
        ),
        CorankOne("tree", MethodReason(interrupted=True), None, (_not_run(Phase.METHOD),)),
    )  # fmt: skip
    higher = _unless_interrupted(
        work, left, Phase.HIGHER, lambda _: tried_numerically(first.higher, asked.seed), first.higher
    )
    steps: tuple[Step, ...] = ()
    if asked.steps or isinstance(first.derived, RankTree):
        steps = _unless_interrupted(work, left, Phase.STEPS, lambda _: every_step(chain, first), ())
    determinants: Determinants | None = None
    if asked.steps:
        determinants = _unless_interrupted(
            work, left, Phase.DETERMINANT, lambda phase_work: determinants_of(chain, phase_work), None
        )
    unmet: list[UnrealSet] = []
    unmet = _guard(
        Phase.POINTS,
        lambda: _sets_without_points(chain, tree, derived, asked.seed, left, unsettled), unmet, left,
    )  # fmt: skip
    left += [*first.left, *unfinished_coranks(higher)]
    lowest = _stated_rank(tree, lowest)
    stated = replace(tree, cases=[*tree.cases, *unsettled])
    undivided: Sequence[UndividedSet] = ()
    undivided = _guard(Phase.UNDIVIDED, lambda: _undivided_sets(chain, stated, derived, work, left), undivided, left)
    not_real += unmet
    assumed: Sequence[Assumption] = ()
    assumed = _guard(
        Phase.ASSUMPTIONS, lambda: _assumptions(chain, tree, lowest, work, left, derive=asked.special), assumed, left
    )
    left += _not_holding(assumed)
    check, over, misses = _cloud(chain, tree.generic_rank, lowest, (*derived, *undivided), asked.points, work, left)
    differing = [*first.disagreements, *wrong_coranks(higher)]
    if not tree.is_divided:  # another method may have what the tree has not come to
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
        remarks=(*chain_remarks(chain), *followers(robot), *remarks, *misses, *near_structure(chain)),
        method=first.method,
        reason=first.reason,
        steps=steps,
        determinants=determinants,
        families=families_in_whole_angles(robot, posed_exactly(chain.with_part_angles, chain.task, derived)),
        lowest=lowest,
        assumptions=tuple(assumed),
        not_real=tuple(not_real),
        explained=check,
        disagreements=(*differing, *wrong, *over),
        complete=tree.is_stated and not left,
        interrupted=work.interrupted,
        left=tuple(left),
        seconds=monotonic() - begun,
        limited=work.limited,
        settings=asked,
        undivided=cases_in_whole_angles(robot, undivided),
    )
    return _with_numbers_where_missed(result, over, work, progress)


def _with_numbers_where_missed(
    result: Conditions, over: Sequence[Contradiction], work: Work, progress: Callable[[str, int, int], None] | None
) -> Conditions:
    """A result; derived with numbers, in the time that is left, where its letters, that nobody asked for, miss singular
    configurations: a rank is lost for these lengths only.
    """
    asked = result.settings
    optional = bool(result.letters) and asked.lengths == "auto"
    if not (over and optional) or work.interrupted or work.remaining <= 0 or work.time_left <= 0:
        return result
    seconds = SLOWER * work.remaining
    in_numbers = replace(asked, lengths="numbers", seconds=seconds)
    with_numbers = derive_conditions(result.robot, result.task, in_numbers, progress)
    missed = DerivationRemark(RemarkOn.MISSED_BY_LETTERS)
    return replace(with_numbers, remarks=(*with_numbers.remarks, missed), settings=asked)


def _lowest_rank(chain: Chain, coranks: int | None) -> int:
    """The rank down to which conditions are derived: all of them, or so many coranks."""
    if coranks is None:
        return 0
    return max(min(chain.task.m, chain.n) - coranks, 0)


def _not_run(phase: Phase) -> Unfinished:
    return Unfinished(UnfinishedKind.NOT_RUN, phase=phase)


def _not_holding(assumptions: Sequence[Assumption]) -> list[Unfinished]:
    """Assumptions that the arm does not satisfy."""
    kind = UnfinishedKind.ASSUMPTION
    return [Unfinished(kind, conditions=assumption.text) for assumption in assumptions if not assumption.holds]


def posed_exactly(robot: Robot, task: Task, families: Sequence[Family]) -> tuple[Family, ...]:
    """Families with the witnesses that `analyze` shows: in good postures, see `rankdrop.families.pose_witness`."""
    return tuple(pose_witness(robot, task, family, families) for family in families)


def _broken(chain: Chain, work: Work) -> tuple[DerivationRemark, ...]:
    """Why conditions that hold for general lengths need not hold for this arm."""
    zero = [f for f in work.assumed.values() if sign_of(chain, f) == 0]
    ruled_out = [DerivationRemark(RemarkOn.RULED_OUT, polynomial=sum_text(chain.ring, f)) for f in zero]
    if work.special:
        return (DerivationRemark(RemarkOn.DEPENDENT), *ruled_out)
    return tuple(ruled_out)


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
    restarted = work.restarted()
    with restarted.share(_LETTERS):
        tree = rank_tree(special, restarted, lowest=lowest, unwanted=_turns_out_broken(special, restarted))
    if not tree.is_finished or _broken(special, restarted) or splits(special, tree):
        return None
    return special, tree, restarted, (DerivationRemark(RemarkOn.ONE_LETTER, equal=_equal_lengths(chain, special)),)


def _equal_lengths(chain: Chain, special: Chain) -> tuple[EqualLengths, ...]:
    """Letters that were replaced, and the letter that stands for each."""
    equal = []
    for name, length in chain.letters.items():
        if name in special.letters:
            continue
        for other in special.letters:
            if abs(chain.letters[other]) == abs(length):
                sign = 1 if length == chain.letters[other] else -1
                equal.append(EqualLengths(name, sign, other))
    return tuple(equal)


def _tree(chain: Chain, lowest: int, *, optional: bool, work: Work) -> _Derived:
    """The rank tree; with numbers where letters that nobody asked for take too long or leave systems over that matter
    for this arm, or where letters rule out its lengths.
    """
    optional = optional and bool(chain.letters)
    with work.share(_LETTERS if optional else _TREE):
        tree = rank_tree(chain, work, lowest=lowest, unwanted=_turns_out_broken(chain, work))
    broken = _broken(chain, work)
    if splits(chain, tree):
        broken += (DerivationRemark(RemarkOn.SEVERAL_FACTORS),)
    if work.interrupted or not chain.letters:
        return chain, tree, work, ()
    if broken:
        return _with_equal_lengths(chain, lowest, work) or _without_letters(chain, lowest, broken, work)
    if _leaves_over(tree, optional=optional):
        return _decided_by_numbers(chain, tree, lowest, optional=optional, work=work)
    return chain, tree, work, ()


def _without_letters(chain: Chain, lowest: int, broken: Sequence[DerivationRemark], work: Work) -> _Derived:
    """The rank tree with numbers, since conditions with letters do not hold for these lengths."""
    plain, other, restarted = _with_numbers(chain, lowest, work)
    return plain, other, restarted, tuple(broken)


def _with_numbers(chain: Chain, lowest: int, work: Work) -> tuple[Chain, RankTree, Work]:
    """The chain with numbers for all lengths, its rank tree, and the work that is left."""
    plain, restarted = replace(chain, letters={}, written={}), work.restarted()
    with restarted.share(_TREE):
        return plain, rank_tree(plain, restarted, lowest=lowest), restarted


def _decided_by_numbers(chain: Chain, tree: RankTree, lowest: int, *, optional: bool, work: Work) -> _Derived:
    """The rank tree with numbers where it decides more than the one with letters, else the latter."""
    plain, other, restarted = _with_numbers(chain, lowest, work)
    if decided_by_numbers(chain, tree, other):
        return chain, replace(tree, unresolved=[], cases=[]), work, ()  # what letters leave over is not there
    remark = _why_numbers(tree, other, restarted, optional=optional)
    if remark is None:
        return chain, tree, work, ()
    return plain, other, restarted, (remark,)


def _leaves_over(tree: RankTree, *, optional: bool) -> bool:
    """Whether numbers may decide more than a tree with letters did: one cut short, or one with unresolved systems."""
    if tree.complete:
        return bool(tree.unresolved)
    return optional


def _why_numbers(tree: RankTree, other: RankTree, restarted: Work, *, optional: bool) -> DerivationRemark | None:
    """Why the tree with numbers, `other`, replaces the one with letters; None where it does not."""
    if not tree.complete and optional:
        if not other.complete and not restarted.interrupted:
            return None
        return DerivationRemark(RemarkOn.LONGER_WITH_LETTERS)
    if not optional or not other.is_finished:
        return None
    return DerivationRemark(RemarkOn.UNDIVIDED_WITH_LETTERS, number=len(tree.unresolved))


def _families(
    chain: Chain, tree: RankTree, work: Work, left: _Left, unsettled: list[OpenCase]
) -> tuple[list[Family], list[UnrealSet], list[Contradiction]]:
    """(families, sets without real points, disagreements).

    Sets that are not finished become cases, which go to `unsettled`; they go to `left` where the tree does not state
    all cases.
    """
    cases: list[Drop] | None = None
    if tree.is_stated:
        cases = []
    open_sets: list[Unfinished] = []
    sets, not_real = real_sets(chain, tree.drops, work, open_sets, work.seed, cases)
    left += open_sets
    unsettled += [OpenCase(drop.piece, drop.rank + 1) for drop in cases or ()]
    families_found = families(chain, sets, tree.generic_rank, work)
    left += _not_singular(chain, sets, families_found, tree.generic_rank)
    wrong = []
    for family in families_found:
        check = exact_of(family).rank_check
        if not check.holds:
            rank, failed = tree.generic_rank - family.corank, check.tested - check.agree
            wrong.append(
                Contradiction(
                    ContradictionKind.RANK, family=family.id, rank=rank, wrong=failed, tested=check.tested
                )
            )  # fmt: skip
    return families_found, not_real, wrong


def _not_singular(
    chain: Chain, sets: Sequence[tuple[Drop, Reality]], families: Sequence[Family], generic_rank: int
) -> list[Contradiction]:
    """The families that have random real points at which σ does not vanish with `DIGITS` digits.

    The rank modulo a prime is taken at random lengths where lengths are letters: this is the arm with its own lengths.
    """
    met = {id(drop.piece): reality.points for drop, reality in sets}
    contradictions = []
    for family in families:
        problem = Problem(chain.own, chain.own_task, family.corank)
        points = np.concatenate([met[id(piece)][:_OWN] for piece in exact_of(family).pieces])[:_OWN_ALL]
        wrong = sum(not _vanishes(problem, q) for q in points)
        if wrong:
            number = generic_rank - family.corank + 1
            contradictions.append(
                Contradiction(
                    ContradictionKind.NOT_SINGULAR, family=family.id, number=number, wrong=wrong, tested=len(points)
                )
            )  # fmt: skip
    return contradictions


def _vanishes(problem: Problem, q: Array) -> bool:
    """Whether a configuration of the corank asked about is next to q, which satisfies its conditions to rounding.

    Where σ vanishes at q itself the arm is singular there; a descent from such a point may end elsewhere on the set.
    """
    ends = _singular_ends(problem, q)
    return bool((problem.length(ends - q) <= _NEXT).any())


def _singular_ends(problem: Problem, q: Array) -> Array:
    """(k, n) configurations of the rank of the problem, with many digits: q itself, else where descents from it end."""
    if problem.sigma(q)[problem.rank] <= _ROUNDED:
        return q[None]
    ends = [end for end, sigma in descents(problem, q) if sigma <= _ROUNDED]
    return np.array(ends).reshape(-1, len(q))


def _guard(phase: Phase, make: Callable[[], Made], otherwise: Made, left: _Left) -> Made:
    """What is made; `otherwise`, and the reason in `left`, where it fails: no failure ends what else was found."""
    try:
        return make()
    except Exception as error:
        left.append(Unfinished(UnfinishedKind.PHASE, phase=phase, halt=halt_of(error)))
        return otherwise


def _unless_interrupted(
    work: Work, left: _Left, phase: Phase, make: Callable[[Work], Made], otherwise: Made
) -> Made:
    """What is made with a share of the work that is left; `otherwise` where it fails or the user has asked to stop."""
    if not work.interrupted:
        work.show(PHASES[phase], 0, 1)
        phase_work = Work(max(_SHARE * work.remaining, 0.1), work.seed)
        try:
            return _guard(phase, lambda: make(phase_work), otherwise, left)
        except KeyboardInterrupt:
            work.interrupt()
    return otherwise


def _stated_rank(tree: RankTree, lowest: int) -> int:
    """The rank down to which families and cases hold all configurations; as asked for where a tree is left open."""
    if tree.is_stated:
        return max(lowest, tree.lowest)
    return lowest


def _undivided_sets(
    chain: Chain, tree: RankTree, families: Sequence[Family], work: Work, left: _Left
) -> tuple[UndividedSet, ...]:
    """The cases that were not taken apart; one goes to `left` where its configuration is not singular with `DIGITS`
    digits.
    """
    if not tree.is_stated:
        return ()
    if work.interrupted:
        if tree.cases:
            left.append(_not_run(Phase.CASES))
        return ()

    def off_families(q: Array, corank: int) -> NDArray[np.int64]:
        known = [_own_equations(chain, family) for family in families if family.corank >= corank]
        return count_explained(Cloud(chain.own, chain.own_task, q, np.full(len(q), corank)), known)[1]

    def follow_to_corank(corank: int, q: Array) -> Array:
        return _singular_ends(Problem(chain.own, chain.own_task, corank), q)

    cases = undivided_sets(chain, tree, off_families, follow_to_corank, work.seed)
    for place, case in enumerate(cases, 1):
        if case.witness is None:
            continue
        q = into_units(chain.robot, case.witness)
        if not _vanishes(Problem(chain.own, chain.own_task, case.corank), q):
            number = tree.generic_rank - case.corank + 1
            left.append(
                Contradiction(
                    ContradictionKind.CASE_NOT_SINGULAR, family=str(place), number=number, wrong=1, tested=1
                )
            )  # fmt: skip
    return cases


def _unstated_cases(tree: RankTree) -> list[Unfinished]:
    """What a tree leaves open: nothing where its cases hold the rest."""
    if tree.is_stated:
        return []
    if not tree.unresolved:
        return tree.left
    return [*tree.left, Unfinished(UnfinishedKind.SYSTEMS, number=len(tree.unresolved))]


def _assumptions(
    chain: Chain, tree: RankTree, lowest: int, work: Work, left: _Left, *, derive: bool
) -> Sequence[Assumption]:
    """What is assumed of the lengths; arms of special lengths are derived where that is wanted and work is left."""
    if derive and not work.interrupted:
        work.show(PHASES[Phase.SPECIAL], 0, 1)
        try:
            with work.share(_SHARE):
                return assumptions(chain, tree.drops, lowest, work, derive=True)
        except OutOfTime:
            pass
        except KeyboardInterrupt:
            work.interrupt()
    if derive:
        left.append(_not_run(Phase.SPECIAL))
    return assumptions(chain, tree.drops, lowest, work, derive=False)


def _cloud(
    chain: Chain,
    generic_rank: int,
    lowest: int,
    families: Sequence[Family | UndividedSet],
    points: int,
    work: Work,
    left: _Left,
) -> tuple[Check, list[Contradiction], list[DerivationRemark]]:
    """Singular configurations found numerically, tried on the families; those on no family; those that 50 digits show
    not to be singular.

    What was not looked for goes to `left`.
    """
    tested = agree = 0
    over: list[Contradiction] = []
    misses: list[DerivationRemark] = []
    for corank in range(1, generic_rank - lowest + 1):
        if not points or work.interrupted:
            break
        if corank > 1 and work.time_left < -GRACE:  # a tenth of the points takes little time
            left.append(Unfinished(UnfinishedKind.NUMERIC, halt=Halt(HaltKind.PROCESSOR), corank=corank))
            break
        work.show("checks", corank - 1, generic_rank - lowest)
        try:
            met = cloud(chain.own, chain.own_task, corank, _wanted_points(points, corank), work.seed)
            if not len(met.q):
                break
            on_families = _on_families(chain, met.up_to(generic_rank - lowest), corank, families)
        except KeyboardInterrupt:
            work.interrupt()
            break
        tested, agree = tested + on_families.check.tested, agree + on_families.check.agree
        if on_families.wrong:
            misses.append(_near_misses(corank, on_families))
        if len(on_families.off):
            q = tuple(on_families.off[0].tolist())
            over.append(
                Contradiction(
                    ContradictionKind.OFF_FAMILIES, corank=corank, wrong=len(on_families.off),
                    tested=on_families.check.tested, q=q,
                )
            )  # fmt: skip
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


def _near_misses(corank: int, on_families: _OnFamilies) -> DerivationRemark:
    """A remark on the configurations that many digits show not to be singular."""
    followed = min(on_families.wrong, FOLLOWED)
    sigma = None
    if isfinite(on_families.sigma):
        sigma = float(on_families.sigma)
    return DerivationRemark(
        RemarkOn.NEAR_MISSES, corank=corank, number=on_families.wrong, followed=followed, sigma=sigma
    )  # fmt: skip


def _on_families(
    chain: Chain, met: Cloud, corank: int, families: Sequence[Family | UndividedSet]
) -> _OnFamilies:
    """Points of a cloud on the families of a corank or a larger one, or on cases of these that were not taken apart;
    those on none are followed with 50 digits.
    """
    equations = [_own_equations(chain, family) for family in families if family.corank >= corank]
    check, remaining = count_explained(met, equations)
    wrong, sigma = near_misses(met, remaining, equations)
    off = whole_angles(chain.robot, out_of_units(chain.robot, met.q[np.setdiff1d(remaining, wrong)]))
    return _OnFamilies(Check(check.tested - len(wrong), check.agree), off, len(wrong), sigma)


def _own_equations(chain: Chain, family: Family | UndividedSet) -> tuple[Equation, ...]:
    """The conditions for the arm in its own unit of length."""
    if isinstance(family, UndividedSet):
        return family.equations
    return equations_in_parts(family, chain.robot)


def _wanted_points(points: int, corank: int) -> int:
    """How many numeric configurations a corank is tried with: all of them, or a tenth."""
    if corank == 1:
        return points
    return max(points // 10, 1)


def _sets_without_points(
    chain: Chain,
    tree: RankTree,
    families: Sequence[Family],
    seed: int,
    left: _Left,
    unsettled: list[OpenCase],
) -> list[UnrealSet]:
    """The sets on which no real point was found. What the tree leaves open for want of points goes to `unsettled` as
    cases; it goes to `left` where the tree does not state all cases.

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
        elif piece.key not in lost and not _is_settled(chain, tree, families, np.array(theta), order, last):
            lost[piece.key] = OpenCase(piece, order)
    unreal = [UnrealSet(row.text, Unreal.NOR_MODULO_PRIMES, tried=len(PRIMES)) for row in merge(list(unmet.values()))]
    if tree.is_stated:
        unsettled += lost.values()
    elif lost:
        shortest = min((row_of_set(case.piece) for case in lost.values()), key=lambda row: row.terms)
        left.append(
            Unfinished(
                UnfinishedKind.NO_POINTS, number=len(lost), conditions=shortest.text, letters=bool(chain.letters)
            )
        )  # fmt: skip
    return unreal


def _is_settled(
    chain: Chain,
    tree: RankTree,
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
        points = q[low & (corank == k)]
        known = [_own_equations(chain, family) for family in families if family.corank >= k]
        _, over = count_explained(Cloud(chain.own, chain.own_task, points, np.full(len(points), k)), known)
        if len(over):
            return False
    return bool(low.all()) or last
