"""ML's planar two-link arm in closed form: ¹J, its determinant and inverse, and the joint rates near θ2 = 0.

¹J has the axes of link 1 (x along the link) and the reference point at the tip:

    ¹J = [ −a2 s2        −a2 s2 ]      det ¹J = a1 a2 s2      ¹J⁻¹ =    1      [  a2 c2         a2 s2 ]
         [ a1 + a2 c2    a2 c2  ]                                   ─────────  [ −a1 − a2 c2   −a2 s2 ]
                                                                    a1 a2 s2

Copies of the lecture in which entries of the inverse have lost their factor a2 do not satisfy ¹J ¹J⁻¹ = I; this form
does, for all lengths. It gives the rates

    θ̇1 = c2/(a1 s2) ẋ + ẏ/a1,      θ̇2 = −(a1 + a2 c2)/(a1 a2 s2) ẋ − ẏ/a1

Only the entries of ẋ, along the stretched arm, grow without bound as s2 → 0; ẏ across it costs 1/a1 for ever.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, inf, isfinite, sin

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.robot import Array
from rankdrop.tolerances import DEFAULT

FORMULAS = {
    "jacobian": "¹J = [[−a2 s2, −a2 s2], [a1 + a2 c2, a2 c2]]",
    "determinant": "det ¹J = a1 a2 s2",
    "inverse": "¹J⁻¹ = [[a2 c2, a2 s2], [−a1 − a2 c2, −a2 s2]] / (a1 a2 s2)",
    "rate 1": "θ̇1 = c2/(a1 s2) ẋ + ẏ/a1",
    "rate 2": "θ̇2 = −(a1 + a2 c2)/(a1 a2 s2) ẋ − ẏ/a1",
}
"""The closed forms as text."""

LATEX = {
    "jacobian": r"{}^1J = \begin{bmatrix} -a_2 s_2 & -a_2 s_2 \\ a_1 + a_2 c_2 & a_2 c_2 \end{bmatrix}",
    "determinant": r"\det {}^1J = a_1 a_2 s_2",
    "inverse": r"{}^1J^{-1} = \frac{1}{a_1 a_2 s_2}"
    r"\begin{bmatrix} a_2 c_2 & a_2 s_2 \\ -a_1 - a_2 c_2 & -a_2 s_2 \end{bmatrix}",
    "rate 1": r"\dot\theta_1 = \frac{c_2}{a_1 s_2}\,\dot x + \frac{1}{a_1}\,\dot y",
    "rate 2": r"\dot\theta_2 = -\frac{a_1 + a_2 c_2}{a_1 a_2 s_2}\,\dot x - \frac{1}{a_1}\,\dot y",
}
"""The closed forms as LaTeX, without dollar signs."""


@dataclass(frozen=True, slots=True)
class PlanarTwoLink:
    """¹J at one angle θ2, in numbers.

    Attributes:
        a1, a2: link lengths [m].
        theta2: angle of the second joint [rad].
        jacobian: (2, 2) ¹J [m/rad].
        determinant: a1 a2 s2 [m²/rad²].
        inverse: (2, 2) ¹J⁻¹ [rad/m]; None where the arm is singular, s2 = 0.
        fails: whether it is, |s2| ≤ the tolerance for zero singular values.
        rates_x, rates_y: (θ̇1, θ̇2) for unit speed along x and across [rad/s per m/s]; infinite where there are none.
    """

    a1: float
    a2: float
    theta2: float
    jacobian: Array
    determinant: float
    inverse: Array | None
    fails: bool
    rates_x: tuple[float, float]
    rates_y: tuple[float, float]


def planar_two_link(a1: float, a2: float, theta2: float) -> PlanarTwoLink:
    """¹J, its inverse where there is one, and the joint rates (ML, all factors a2 in place).

    At s2 = 0 motion along x is impossible and the matrix has no inverse; ẏ alone can still be made there, by
    θ̇1 = ẏ/a1, θ̇2 = −ẏ/a1, which is what the formulas give with ẋ = 0.

    Args:
        a1, a2: link lengths, positive [m].
        theta2: angle of the second joint [rad].

    Raises:
        OptionError: a length not positive, or a number that is not finite.

    Example:
        >>> arm = planar_two_link(1.0, 0.7, 0.01)
        >>> [round(rate, 2) for rate in arm.rates_x]
        [100.0, -242.86]
        >>> planar_two_link(1.0, 0.7, 0.0).inverse is None
        True
    """
    for name, length in (("a1", a1), ("a2", a2)):
        if not (isfinite(length) and length > 0.0):
            raise OptionError(f"the link length {name} must be positive", got=length, allowed="a finite number above 0")
    if not isfinite(theta2):
        raise OptionError("theta2 is not finite", got=theta2, allowed="an angle [rad]")
    s2, c2 = sin(theta2), cos(theta2)
    matrix = np.array([[-a2 * s2, -a2 * s2], [a1 + a2 * c2, a2 * c2]])
    matrix.flags.writeable = False
    fails = abs(s2) <= DEFAULT.singular
    inverse = None
    if not fails:
        inverse = np.array([[a2 * c2, a2 * s2], [-a1 - a2 * c2, -a2 * s2]]) / (a1 * a2 * s2)
        inverse.flags.writeable = False
    along_x = (inf, inf) if fails else (c2 / (a1 * s2), -(a1 + a2 * c2) / (a1 * a2 * s2))
    return PlanarTwoLink(a1, a2, theta2, matrix, a1 * a2 * s2, inverse, fails, along_x, (1.0 / a1, -1.0 / a1))


def rate_table(a1: float, a2: float, angles: Iterable[float]) -> Array:
    """Joint rates near the stretched arm, a row for every θ2.

    Returns:
        (k, 5) θ2 [rad], then θ̇1, θ̇2 for ẋ = 1 m/s and θ̇1, θ̇2 for ẏ = 1 m/s [rad/s]; inf where there are none.

    Raises:
        OptionError: as `planar_two_link`.

    Example:
        >>> rate_table(1.0, 0.7, [0.1, 0.01]).round(1).tolist()
        [[0.1, 10.0, -24.3, 1.0, -1.0], [0.0, 100.0, -242.9, 1.0, -1.0]]
    """
    arms = [planar_two_link(a1, a2, angle) for angle in angles]
    return np.array([[arm.theta2, *arm.rates_x, *arm.rates_y] for arm in arms]).reshape(-1, 5)
