"""The Jacobian in the axes of a link, exactly: ML's ¹J."""

from __future__ import annotations

from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.decoupling.block_form import POSE, POSITION, flat


def frame_jacobian(chain: Chain, k: int) -> list[list[Polynomial]]:
    """ᵏJ: the task's rows of the Jacobian at the tip, in the axes of link k (z along axis k, x along the normal after).

    ᵏJ = ᵏR₀ ⁰J, row by row (ML's ¹J of the planar arm). It has the same singularities.

    Args:
        chain: from `exact_chain`.
        k: link, 1 … n.

    Returns:
        One list of n trigonometric polynomials for each row of the task.

    Raises:
        OptionError: no such link.
        TaskError: the task's rows would be others in these axes.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> [str(x) for x in frame_jacobian(exact_chain(open_robot("planar2r")), 1)[1]]
        ['c2*a2 + a1', 'c2*a2']
    """
    if not 1 <= k <= chain.n:
        raise OptionError("there is no such link", got=k, allowed=f"1 … {chain.n}")
    rows = chain.task.rows
    paired = (0 in rows) == (1 in rows)
    if rows not in (POSE, POSITION, (3, 4, 5)) and not (paired and flat(chain)):
        raise TaskError(
            "in the axes of a link the rows of this task would be others",
            got=chain.task.name,
            allowed="pose, position, orientation, or rows of a plane that all axes are perpendicular to",
        )
    return [[column[r] for column in chain.screws_at_tip(k)] for r in rows]
