"""The conditions of corank 1 by the method a person would take, step by step, held against the rank tree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import WIDE, Chain
from rankdrop.exact.arm.structure import check_basic
from rankdrop.exact.conjunctions import SetDerivation
from rankdrop.exact.decoupling import Decoupling, decouple, parting_of
from rankdrop.exact.families import real_points
from rankdrop.exact.higher_coranks import HigherCorank, higher_coranks
from rankdrop.exact.method_reason import MethodReason
from rankdrop.exact.methods import METHODS as COMPARED
from rankdrop.exact.methods import derive
from rankdrop.exact.suppression import Suppression, suppress
from rankdrop.exact.tree import RankTree
from rankdrop.families.contradiction import TREE, Contradiction, ContradictionKind
from rankdrop.families.record import Family
from rankdrop.families.unfinished import Unfinished, UnfinishedKind
from rankdrop.lists import flat_map
from rankdrop.local.block import sample, singular_values
from rankdrop.sections import words_of
from rankdrop.units import out_of_units

METHODS = ("auto", "decoupling", "suppression", "tree", *(name.replace("_", "-") for name in COMPARED))
"""What can be asked for."""
CHOOSING = ("suppression", "reciprocity")
"""Methods for which basic screws and a frame can be chosen."""
_LONG = 400  # terms of a condition from which on "auto" takes minors that vanish together, not cases
_REGULAR = 200  # random configurations on which no condition may hold


Chosen = tuple[tuple[int, ...] | None, int | None]  # basic screws, and the link in whose frame they are


@dataclass(frozen=True)
class CorankOne:
    """A derivation of corank 1, and of higher ones where the method has them and they were asked for.

    Attributes:
        method, reason: which, and why.
        derived: what was derived; None where nothing was.
        left: what was not finished.
        disagreements: what it says that the rank tree does not, and the other way round.
        higher: coranks above 1.
    """

    method: str
    reason: MethodReason
    derived: Decoupling | Suppression | SetDerivation | RankTree | None
    left: tuple[Unfinished, ...] = ()
    disagreements: tuple[Contradiction, ...] = ()
    higher: tuple[HigherCorank, ...] = ()


def check_method(
    chain: Chain, method: str, *, basic: tuple[int, ...] | None = None, frame: int | None = None
) -> None:
    """Refuse a method that there is not, decoupling of an arm that does not decouple, and screws chosen for a method
    that has none, before the rank tree is derived.

    Raises:
        OptionError: says why.
    """
    if method not in METHODS:
        raise OptionError("there is no such method", where="method", got=repr(method), allowed=", ".join(METHODS))
    if (basic, frame) != (None, None) and method not in CHOOSING:
        raise OptionError(
            "basic screws and the frame are chosen for another method", where="method", got=method,
            allowed=", ".join(CHOOSING), mend="name one of them",
        )  # fmt: skip
    check_basic(chain, basic, frame)
    if method == "suppression" and chain.has_mimics:
        raise OptionError(
            "suppression needs one screw for each column of the Jacobian", where="method",
            got="joints that follow others", mend="take auto, cofactors, reciprocity, singular-vector or tree",
        )  # fmt: skip
    if method == "decoupling" and decouple(chain) is None:
        parting = parting_of(chain)
        raise OptionError(
            "this arm does not decouple", where="method", got=words_of(parting).parting_text(parting),
            mend="take auto or another method",
        )  # fmt: skip


def corank_one(
    chain: Chain,
    method: str,
    tree: RankTree,
    families: Sequence[Family],
    work: Work,
    *,
    chosen: Chosen = (None, None),
    highest: int | None = None,
) -> CorankOne:
    """Derive corank 1 by one method, and compare with what the rank tree has found.

    Args:
        chain: the arm.
        method: one of `METHODS`; "auto" takes decoupling where blocks are square, the determinant for other arms
            without joints to spare and where the tree's conditions are long, suppression for redundant arms with all
            six rows and at most `WIDE` joints, reciprocity for other redundant arms; the tree where the rank is not
            full anywhere. Where joints follow others neither decoupling nor suppression, which need one screw for each
            column.
        tree: of the arm.
        families: made from it.
        work: deadline and random points.
        chosen: for suppression and reciprocity: numbers of the six basic screws, None for the method's own rules; link
            in whose frame the screws are, None for the one where they are shortest.
        highest: corank up to which reciprocity derives where it was asked for; None for 1.

    Raises:
        OptionError: a method that is not for this arm; says why.
    """
    check_method(chain, method)
    if method in ("auto", "decoupling"):
        decoupled = decouple(chain)
    else:
        decoupled = None
    if decoupled is not None:
        return _derive_decoupled(chain, decoupled, tree)
    if method == "auto":
        reason = _too_long(chain, tree, MethodReason(parting_of(chain)))
        name = _chosen(chain, tree, reason)
    else:
        reason = MethodReason()
        name = method
    if name == "tree":
        return CorankOne("tree", reason, tree)
    if name == "suppression":
        derived = _derive_by_suppression(chain, reason, tree, work, chosen)
    else:
        derived = _compare_methods(chain, name, reason, families, work, chosen)
    if method == "reciprocity" and highest is not None:
        basic, frame = chosen
        higher = higher_coranks(chain, highest, tree, work, basic=basic, frame=frame)
        derived = replace(derived, higher=higher)
    return _by_tree_if_open(derived, method, tree)


def _too_long(chain: Chain, tree: RankTree, reason: MethodReason) -> MethodReason:
    """A reason with the methods by cases that are not run, where a condition of a complete tree is long."""
    longest = max(map(len, flat_map(lambda drop: drop.piece.equations, tree.drops)), default=0)
    if chain.n == chain.task.m or not (_has_full_rank(chain, tree) and tree.complete and longest > _LONG):
        return reason
    not_run = []
    if _is_for_suppression(chain):
        not_run.append("suppression")
    if chain.n > chain.task.m:
        not_run.append("reciprocity")
    return replace(reason, terms=longest, not_run=(*not_run, "singular-vector"))


def _has_full_rank(chain: Chain, tree: RankTree) -> bool:
    return tree.generic_rank == min(chain.n, chain.task.m)


def _is_for_suppression(chain: Chain) -> bool:
    return chain.task.m == 6 and 6 < chain.n <= WIDE and not chain.has_mimics


def _chosen(chain: Chain, tree: RankTree, reason: MethodReason) -> str:
    """The method that "auto" takes for an arm that does not decouple."""
    if not _has_full_rank(chain, tree):
        return "tree"
    if chain.n <= chain.task.m or reason.terms:
        return "determinant"
    if _is_for_suppression(chain):
        return "suppression"
    return "reciprocity"


def _by_tree_if_open(derivation: CorankOne, asked: str, tree: RankTree) -> CorankOne:
    """A second method that nobody asked for and that did not finish says nothing against the rank tree."""
    if asked != "auto" or not derivation.left or derivation.disagreements or not tree.is_stated:
        return derivation
    return CorankOne("tree", replace(derivation.reason, unfinished=derivation.method), derivation.derived)


def _derive_decoupled(chain: Chain, decoupling: Decoupling, tree: RankTree) -> CorankOne:
    """Corank 1 by the factors of the two blocks, each held against the tree's sets of codimension 1."""
    atoms = flat_map(lambda block: block.factors.atoms, decoupling.blocks)
    said = [ZeroSet.where_atom(chain.ring, atom) for atom, _ in atoms]
    drops = [drop.piece for drop in tree.drops if drop.rank < tree.generic_rank and drop.piece.codimension == 1]
    missing, surplus = _inside_none(said, drops), _inside_none(drops, said)
    return CorankOne(
        "decoupling", MethodReason(parting_of(chain)), decoupling, (),
        _differences(chain, "decoupling", missing, surplus, tree),
    )  # fmt: skip


def _inside_none(sets: Sequence[ZeroSet], others: Sequence[ZeroSet]) -> list[ZeroSet]:
    """The sets that lie in none of the others."""
    return [piece for piece in sets if not any(piece.lies_inside(other) for other in others)]


def _differences(
    chain: Chain, method: str, missing: Sequence[ZeroSet], surplus: Sequence[ZeroSet], tree: RankTree
) -> tuple[Contradiction, ...]:
    """Sets of the method that the rank tree does not have, and the reverse: how many, and a configuration on one."""
    contradictions = []
    for own, other, sets in ((method, TREE, missing), (TREE, method, surplus)):
        if sets:
            q, rank = _configuration_on(chain, sets, tree.generic_rank)
            contradictions.append(
                Contradiction(
                    ContradictionKind.SETS, method=own, other=other, number=len(sets), q=q, rank=rank,
                    full_rank=tree.generic_rank,
                )
            )  # fmt: skip
    return tuple(contradictions)


def _configuration_on(chain: Chain, sets: Sequence[ZeroSet], full_rank: int) -> tuple[tuple[float, ...], int]:
    """A real configuration on one of the sets, and the rank there; ((), full_rank) where none was found."""
    rng = np.random.default_rng(0)
    for piece in sets:
        on_set = real_points(chain, piece, full_rank - 1, rng)
        for rank, points in ((full_rank - 1, on_set.points), (full_rank, on_set.strays)):
            if len(points):
                return tuple(points[0].tolist()), rank
    return (), full_rank


def _derive_by_suppression(
    chain: Chain, reason: MethodReason, tree: RankTree, work: Work, chosen: Chosen
) -> CorankOne:
    basic, frame = chosen
    suppression = suppress(chain, frame=frame, basic=basic, seconds=work.remaining)
    if suppression.left:
        left = (Unfinished(UnfinishedKind.SUPPRESSION, number=len(suppression.left)),)
        return CorankOne("suppression", reason, suppression, left)
    different = _suppression_differences(chain, suppression, tree, work)
    return CorankOne("suppression", reason, suppression, (), different)


def _sets_of(tree: RankTree) -> list[ZeroSet]:
    """What the rank tree found, and what it left open."""
    pieces = [drop.piece for drop in tree.drops]
    pieces += [case.piece for case in tree.cases]
    pieces += [piece for piece, _, _ in tree.without_points]
    return pieces


def _suppression_differences(
    chain: Chain, suppression: Suppression, tree: RankTree, work: Work
) -> tuple[Contradiction, ...]:
    """Random points of each method's sets, tried on those of the other; what the tree left open counts as its own."""
    held = _sets_of(tree)
    pieces = flat_map(lambda family: family.stratum.pieces, suppression.families)
    drawn = [(piece, piece.point(work.rng)) for piece in pieces]
    missing = [
        piece for piece, point in drawn
        if point is not None and not any(other.holds_at([point]) for other in held)
    ]  # fmt: skip
    surplus = [
        drop.piece for drop in tree.drops
        if not any(other.holds_at([point]) for point in drop.piece.samples for other in pieces)
    ]  # fmt: skip
    return _differences(chain, "suppression", missing, surplus, tree)


def _compare_methods(
    chain: Chain,
    method: str,
    reason: MethodReason,
    families: Sequence[Family],
    work: Work,
    chosen: Chosen,
) -> CorankOne:
    """One of the methods that KG lists; the families' witnesses satisfy it, random configurations do not."""
    seconds = max(work.remaining, 0.1)
    basic, frame = chosen
    derivation = derive(chain, method.replace("-", "_"), seconds, frame=frame, basic=basic)
    different = [
        Contradiction(ContradictionKind.WITNESS, family=family.id, method=method)
        for family in families if not derivation.left and not derivation.holds(family.witness).all()
    ]  # fmt: skip
    q = out_of_units(chain.robot, sample(chain.own, chain.own_task, _REGULAR, 0))
    sigma = singular_values(chain.with_part_angles, q, chain.task)[:, min(chain.task.m, chain.n) - 1]
    wrong = int((derivation.holds(q[sigma > 1e-3])).sum())
    if wrong:
        different.append(Contradiction(ContradictionKind.REGULAR, method=method, wrong=wrong))
    unfactored = sum(what == "unfactored" for what, _ in derivation.notes)
    reason = replace(reason, unfactored=unfactored)
    return CorankOne(method, reason, derivation, tuple(derivation.left), tuple(different))
