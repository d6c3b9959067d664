"""Systems that could not be taken apart with letters, settled with the arm's own lengths."""

from __future__ import annotations

from dataclasses import replace

from rankdrop.exact.algebra.field import residue
from rankdrop.exact.algebra.work import Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.tree import Tree, rank_tree


def settled(chain: Chain, tree: Tree, lowest: int, work: Work) -> bool:
    """Whether the arm with numbers for its lengths has no drop besides those of a tree with letters.

    What a system with letters may hold is then not there for this arm.

    Args:
        chain: the arm, with letters.
        tree: of it.
        lowest: rank down to which drops were looked for.
        work: deadline.

    Returns:
        False, too, where the tree with numbers is not finished, or leaves systems of its own.
    """
    again = work.again()
    plain = rank_tree(replace(chain, letters={}, written={}), again, lowest=lowest)
    return plain.complete and not again.unresolved and covered(chain, tree, plain)


def covered(chain: Chain, tree: Tree, plain: Tree) -> bool:
    """Whether every drop of the arm with numbers lies in one that was derived with letters.

    Args:
        chain: the arm, with letters.
        tree: of it.
        plain: of the arm with numbers for its lengths.
    """
    lengths = {name: residue(value) for name, value in chain.letters.items()}
    for drop in plain.drops:
        points = [{**point, **lengths} for point in drop.piece.samples]
        if not any(other.piece.holds_at(points) for other in tree.drops if other.rank <= drop.rank):
            return False
    return True
