"""The methods that KG lists besides its own, for comparison: each derives the whole singular set in its own way.

| method | idea | what stands in the way |
|---|---|---|
| determinant | det J, or det(J Jᵀ) | a redundant arm's is one long sum of squares: its minors vanish together |
| cofactors | all maximal minors vanish | their common solution is still to be found |
| decomposition | arm and wrist apart, from the wrist centre | spherical wrists only |
| reciprocity | a screw reciprocal to all joint screws | it vanishes somewhere itself |
| singular_vector | Jᵀ u = 0 by elimination | pivots vanish: many cases, some empty |
| elementary | rows and columns cleared by numbers, then blocks | of a redundant arm minors are left, but smaller ones |

    >>> from rankdrop.exact.arm.chain import exact_chain
    >>> from rankdrop.robot.open import open_robot
    >>> found = derive(exact_chain(open_robot("scara")), "determinant")
    >>> [[atom.key for equality in c.equal for atom in equality.atoms] for c in found.conditions]
    [['θ2=0'], ['θ2=pi']]

Each has a module of its name; the first two are in `vanishing_minors`.
"""

from __future__ import annotations

from collections.abc import Callable

from rankdrop.algebra.halt import OutOfTime
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import check_basic
from rankdrop.exact.conjunctions import SetDerivation
from rankdrop.exact.decomposition import decomposition
from rankdrop.exact.elementary import elementary
from rankdrop.exact.reciprocity import reciprocity
from rankdrop.exact.singular_vector import singular_vector
from rankdrop.exact.vanishing_minors import cofactors, determinant

_METHODS: dict[str, Callable[[SetDerivation], None]] = {
    "determinant": determinant,
    "cofactors": cofactors,
    "decomposition": decomposition,
    "reciprocity": reciprocity,
    "singular_vector": singular_vector,
    "elementary": elementary,
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
    corank: int = 1,
) -> SetDerivation:
    """Derive the singular set, or the set of a higher corank, by one of the methods.

    Args:
        chain: the arm and its task.
        method: one of `METHODS`.
        seconds: wall time that may be spent; what is not finished by then is in `Derivation.left`.
        frame: for reciprocity: link 1 … n − 1 in whose frame the screws are taken; None for the shortest one.
        basic: for reciprocity: the reciprocal screw is that of five of these joints, as far as that goes.
        corank: k of the configurations of rank m − k or less; above 1 for reciprocity alone.

    Returns:
        The conditions, and what they cost.

    Raises:
        OptionError: no such method; a rank that is not full anywhere; for decomposition no spherical wrist; a corank
            that the task or the method does not have.
    """
    if method not in _METHODS:
        raise OptionError("there is no such method", got=repr(method), allowed=", ".join(METHODS))
    if (frame is not None or basic is not None) and method != "reciprocity":
        raise OptionError("frame and basic screws are chosen for another method", got=method, allowed="reciprocity")
    if not 1 <= corank <= chain.task.m:
        raise OptionError(
            "the corank is no number of freedoms of the task", where="corank", got=corank, allowed=f"1 … {chain.task.m}"
        )
    if corank > 1 and method != "reciprocity":
        raise OptionError(
            "this method derives corank 1 only", where="corank", got=f"{corank}, {method}", allowed="reciprocity"
        )
    check_basic(chain, basic, frame)
    builder = SetDerivation(chain, method, seconds, frame=frame, basic=basic, corank=corank)
    try:
        _METHODS[method](builder)
    except OutOfTime as error:
        builder.halt(error.halt)
    builder.finish()
    return builder
