"""Joint values in words: 0, π, ±π/2 exactly; anything else in rad and deg."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees, isclose

from rankdrop.atlas.equation import pretty_angle

_SAME = 1e-9


def joint_symbol(number: int, kind: str) -> str:
    """θ3 for an angle, q3 for a length, as conditions write them."""
    return f"{'q' if kind == 'prismatic' else 'θ'}{number}"


def value_text(value: float, kind: str = "revolute") -> str:
    """One value: "π/2", "0.7731 (44.30°)" or, for a prismatic joint, "0.25 m"."""
    if kind == "prismatic":
        return f"{value:.6g} m"
    exact = pretty_angle(value)
    return exact if exact == "0" or "π" in exact else f"{value:.4f} ({degrees(value):.2f}°)".replace("-", "−")


def values_text(values: Iterable[float], kind: str = "revolute") -> str:
    """A set of values, v and −v merged: "0, π", "±π/2", "±0.7731 (±44.30°)"."""
    left = sorted(values, key=lambda value: (abs(value), value))
    words = []
    while left:
        value = left.pop(0)
        opposite = next((other for other in left if value and isclose(other, -value, abs_tol=_SAME)), None)
        if opposite is None:
            words.append(value_text(value, kind))
        else:
            left.remove(opposite)
            words.append("±" + value_text(abs(opposite), kind).replace("(", "(±"))
    return ", ".join(words)


def both_units(value: float, kind: str = "revolute") -> str:
    """A configuration's entry: "1.5708 rad (90.00°)" or "0.2500 m"."""
    return f"{value:.4f} m" if kind == "prismatic" else f"{value:.4f} rad ({degrees(value):.2f}°)"
