"""An arm derived with letters for its lengths, held against the same arm with numbers."""

from __future__ import annotations

from rankdrop.exact.algebra.field import residue
from rankdrop.exact.algebra.flint import flint
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.tree import Tree

_LONG = 2000  # terms of a condition that is factored at the arm's own lengths


def settled(chain: Chain, tree: Tree, plain: Tree) -> bool:
    """Whether what a tree with letters leaves open, or rules out, makes no difference for the arm's own lengths.

    So it is where the tree with numbers leaves nothing open and has nothing besides. A set that it could not look into
    is open as much as a system that it could not take apart: either may hold what the tree with letters has not.

    Args:
        chain: the arm, with letters.
        tree: of it, with letters; every system was looked into.
        plain: of the arm with numbers for its lengths.
    """
    return tree.complete and plain.finished and covered(chain, tree, plain)


def doubled(chain: Chain, tree: Tree) -> bool:
    """Whether a condition of a drop has a square in it at the arm's own lengths: a5 − d3 sin θ5 has where a5 = d3.

    There it touches zero only, and real points of it are met by chance.
    """
    values = {name: flint().fmpq(x.numerator, x.denominator) for name, x in chain.letters.items()}
    distinct = {str(f): f for drop in tree.drops for f in drop.piece.equations if len(f) <= _LONG}
    return bool(values) and any(
        power > 1 and not chain.ring.is_unit(factor)
        for f in distinct.values()
        if (own := f.subs(values)) != 0
        for factor, power in own.factor()[1]
    )


def covered(chain: Chain, tree: Tree, plain: Tree) -> bool:
    """Whether every drop of the arm with numbers lies in one that was derived with letters.

    Args:
        chain: the arm, with letters.
        tree: of it.
        plain: of the arm with numbers for its lengths.
    """
    for drop in plain.drops:
        points = [
            point.changed({name: residue(value, point.prime) for name, value in chain.letters.items()})
            for point in drop.piece.samples
        ]
        if not any(other.piece.holds_at(points) for other in tree.drops if other.rank <= drop.rank):
            return False
    return True
