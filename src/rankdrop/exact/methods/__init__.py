"""The methods that KG lists besides its own, for comparison: each derives the whole singular set in its own way.

| method | idea | what stands in the way |
|---|---|---|
| determinant | det J, or det(J Jᵀ) | a redundant arm's is one long polynomial, and never negative |
| cofactors | all maximal minors vanish | their common solution is still to be found |
| decomposition | arm and wrist apart, from the wrist centre | spherical wrists only |
| reciprocity | a screw reciprocal to all joint screws | it vanishes somewhere itself |
| singular_vector | Jᵀ u = 0 by elimination | pivots vanish: many cases, some empty |

    >>> from rankdrop.exact.arm.chain import exact_chain
    >>> from rankdrop.robot.open import open_robot
    >>> found = derive(exact_chain(open_robot("scara")), "determinant")
    >>> [[atom.key for equality in c.equal for atom in equality.atoms] for c in found.conditions]
    [['θ2=0'], ['θ2=pi']]
"""

from __future__ import annotations

from collections.abc import Callable

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.work import OutOfTime
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import check_basic
from rankdrop.exact.methods.builder import DerivationBuilder
from rankdrop.exact.methods.by_minors import cofactors, decomposition, determinant
from rankdrop.exact.methods.derivation import Conjunction, Derivation
from rankdrop.exact.methods.reciprocity import reciprocity, singular_vector

__all__ = ["METHODS", "Conjunction", "Derivation", "derive"]

_METHODS: dict[str, Callable[[DerivationBuilder], None]] = {
    "determinant": determinant,
    "cofactors": cofactors,
    "decomposition": decomposition,
    "reciprocity": reciprocity,
    "singular_vector": singular_vector,
}
METHODS = tuple(_METHODS)
"""Names of the methods."""


def derive(
    chain: Chain,
    method: str,
    seconds: float = 30.0,
    *,
    frame: int | None = None,
    basic: tuple[int, ...] | None = None,
) -> Derivation:
    """Derive the singular set by one of the methods.

    Args:
        chain: the arm and its task.
        method: one of `METHODS`.
        seconds: wall time that may be spent; what is not done by then is told in `Derivation.left`.
        frame: for reciprocity: link 1 … n in whose frame the screws are taken; None for the shortest one.
        basic: for reciprocity: the reciprocal screw is that of five of these joints, as far as that goes.

    Returns:
        The conditions, and what they cost.

    Raises:
        OptionError: no such method; a rank that is not full anywhere; for decomposition no spherical wrist.
    """
    if method not in _METHODS:
        raise OptionError("there is no such method", got=repr(method), allowed=", ".join(METHODS))
    if (frame is not None or basic is not None) and method != "reciprocity":
        raise OptionError("frame and basic screws are chosen for another method", got=method, allowed="reciprocity")
    if frame is not None and (chain.task.rows != (0, 1, 2, 3, 4, 5) or not 1 <= frame <= chain.n):
        raise OptionError("no such link frame", where="frame", got=frame, allowed=f"1 … {chain.n}, for all six rows")
    check_basic(chain, basic)
    builder = DerivationBuilder(chain, method, seconds, frame=frame, basic=basic)
    try:
        _METHODS[method](builder)
    except OutOfTime as error:
        builder.left.append(str(error))
    return builder.finished()
