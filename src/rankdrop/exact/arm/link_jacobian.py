"""The Jacobian seen from a link, exactly: ML's ¹J, KG's screws in frame 5."""

from __future__ import annotations

from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.decoupling.block_form import POSE, POSITION, flat

ORIENTATION = (3, 4, 5)


def frame_jacobian(chain: Chain, k: int, at: int | None = None) -> list[list[Polynomial]]:
    """ᵏJ: the task's rows of the Jacobian in the axes of link k (z along axis k, x along the normal after it).

    ᵏJ = ᵏR₀ ⁰J, row by row (ML's ¹J of the planar arm). It has the same singularities.

    Args:
        chain: from `exact_chain`.
        k: link, 1 … n.
        at: the reference point is the origin of this link's frame, 1 … n, on axis `at` where the normal after it
            starts (KG: k itself); None for the tip (ML).

    Returns:
        One list of n trigonometric polynomials for each row of the task.

    Raises:
        OptionError: no such link, or another reference point than the tip for a task whose rows it changes.
        TaskError: the task's rows would be others in these axes.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> [str(x) for x in frame_jacobian(exact_chain(open_robot("planar2r")), 1)[1]]
        ['c2*a2 + a1', 'c2*a2']
    """
    check_frame(chain, k, at)
    screws = chain.screws_at_tip(k) if at is None else chain.screws_about(k, at)
    return [[column[r] for column in screws] for r in chain.task.rows]


def check_frame(chain: Chain, k: int, at: int | None) -> None:
    """Refuse axes and reference points that the task has no Jacobian for; raises as `frame_jacobian`."""
    for link, what in ((k, "frame"), (at, "at")):
        if link is not None and not 1 <= link <= chain.n:
            raise OptionError("there is no such link", where=what, got=link, allowed=f"1 … {chain.n}")
    rows = chain.task.rows
    paired = (0 in rows) == (1 in rows)
    if rows not in (POSE, POSITION, ORIENTATION) and not (paired and flat(chain)):
        raise TaskError(
            "in the axes of a link the rows of this task would be others",
            got=chain.task.name,
            allowed="pose, position, orientation, or rows of a plane that all axes are perpendicular to",
        )
    if at is not None and not moves(chain):
        raise OptionError(
            "the velocity of another point is another task", where="at", got=f"link {at}, task {chain.task.name}",
            allowed="the tip",
        )


def moves(chain: Chain) -> bool:
    """Whether the reference point may be another one than the tip: the rows know how the end effector turns."""
    rows = chain.task.rows
    return rows in (POSE, ORIENTATION) or (5 in rows and rows != POSITION)


def sizes(chain: Chain) -> list[tuple[int, int, int | None]]:
    """(terms, link of the axes, reference point) for all axes and reference points, the shortest first.

    Terms are those of all entries, multiplied out in sines and cosines of single joints.

    Raises:
        TaskError: as `frame_jacobian`.
    """
    check_frame(chain, 1, None)
    points: list[int | None] = [None, *(range(1, chain.n + 1) if moves(chain) else ())]
    found = [
        (sum(len(x) for row in frame_jacobian(chain, k, at) for x in row), k, at)
        for at in points
        for k in range(1, chain.n + 1)
    ]
    return sorted(found, key=lambda one: (one[0], one[2] is not None, one[2] or 0, one[1]))
