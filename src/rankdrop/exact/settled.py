"""An arm derived with letters for its lengths, held against the same arm with numbers."""

from __future__ import annotations

from rankdrop.exact.algebra.field import residue
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.tree import Tree


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
