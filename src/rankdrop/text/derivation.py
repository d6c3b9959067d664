"""Where the families of an analysis come from, and whether searches and tests agree with the derivation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite

from rankdrop.families.derivation import Derivation
from rankdrop.families.record import Family
from rankdrop.robot.model import Robot
from rankdrop.text.families import exact_conditions
from rankdrop.text.joint_values import joint_symbol, letters_text
from rankdrop.tolerances import DEFAULT


def agreement(derivation: Derivation | None, robot: Robot, families: Sequence[Family]) -> Iterator[tuple[str, bool]]:
    """Where the families of an analysis come from: sentences, and whether one says that a test contradicts them.

    Args:
        derivation: of the analysis; None where exact conditions were not asked for.
        robot: the arm.
        families: the rows.
    """
    if derivation is None:
        return
    if not derivation.derived:
        if derivation.first_derived:
            families_words = "Those of corank 1 are derived, the families of higher coranks are fitted to the points."
        else:
            families_words = "The families are fitted to the points."
        yield f"Exact conditions: not derived; {derivation.reason}. {families_words}", False
        return
    if derivation.disagreements:
        yield "Numerical tests CONTRADICT the exact derivation:", True
        yield from ((f"  {contradiction}", True) for contradiction in derivation.disagreements)
    printed = any(map(exact_conditions, families))
    if printed:
        symbols = _symbols(derivation, robot)
    else:
        symbols = ""
    yield f"The families are derived exactly; the searches only test them.{symbols}", False


def _symbols(derivation: Derivation, robot: Robot) -> str:
    """What the letters of exact conditions mean."""
    kinds = [str(joint.kind) for joint in robot.variables]
    shifted = [
        f"{joint_symbol(i, kind)} = q{i} {'+' if shift > 0 else '−'} {abs(shift):.6g}"
        for i, (shift, kind) in enumerate(zip(derivation.shifts, kinds, strict=True), 1)
        if shift
    ]
    letters = letters_text(derivation.letters)
    text = " In the conditions s2 is sin θ2, c23 cos(θ2+θ3)" + (f", {letters}" if letters else "")
    return text + (f"; there {', '.join(shifted)}." if shifted else ".")


def mistaken_text(corank: int, many: int, followed: int, sigma: float, digits: int) -> str:
    """Points of the searches that many digits show not to be singular; `sigma` is inf where no minimum was met."""
    if followed == many:
        which = ""
    else:
        which = f" ({followed} of them, spread over all their σ)"
    if isfinite(sigma):
        least = f", it has a minimum of {sigma:.2g}"
    else:
        least = ""
    return (
        f"corank {corank}: {many:,} points of the searches with σ ≤ {DEFAULT.singular:g} are not singular: followed "
        f"with {digits} digits{which}, σ does not vanish next to them{least}"
    )
