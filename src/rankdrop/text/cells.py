"""The cells of a table of families, as AM print them: values of a joint, × for free, c for coupled, shares.

Values of pinned joints within the joint limits: moved by whole turns, and those that no turn brings inside named.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import degrees, floor, isclose

import numpy as np

from rankdrop.families.distance import nearest_turns
from rankdrop.family.equation import Equation, pretty_angle
from rankdrop.family.record import Check, Family, Pin
from rankdrop.robot.model import Robot, lost_told
from rankdrop.units import counted_length

FREE, COUPLED, NOTHING = "×", "c", "–"
TESTED, MET = "tested", "met"
"""Headings of two columns: `share_text` of the soundness, `rounded_share` of the fresh points."""
_LEGEND = (
    "× any value, c coupled: see the condition under the table; dim: dimension of the family in joint space. "
    f"{TESTED}: of points solved from the row's conditions, how many are singular. "
    f"{MET}: how often the search meets the row, in percent of fresh singular points. "
    "lost: the motion taken away, anywhere on the family unless it says otherwise. "
    "Turning by 1 rad counts as much as moving by {length} m."
)
_SAME = 1e-9
_MOST_TERMS = 30  # a longer condition is for programs
_FOLDED = 8  # terms of a condition from which on it is only counted where an exact one stands beside it


def legend(robot: Robot, families: Iterable[Family] = ()) -> str:
    """What the marks and columns of a table of families mean, and letters and links in what is lost on them."""
    lost = lost_told(robot, [words for one in families for words in one.lost_words])
    return f"{_LEGEND.format(length=f'{counted_length(robot):g}')} {lost}".rstrip()


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


def joint_cell(family: Family, number: int, kind: str) -> str:
    """What a family asks of one joint: its values, × for free, c for coupled."""
    for pinned in family.pinned:
        if pinned.number == number:
            return values_text(pinned.values, kind).replace(" (", "\n(").replace("), ", "),\n")
    return FREE if number in family.free else COUPLED


def share_text(part: int, whole: int) -> str:
    """A share in percent, rounded down so that 100 % means all; – for a share of nothing."""
    return f"{floor(1000 * part / whole) / 10:g} %" if whole else NOTHING


def rounded_share(share: Check) -> str:
    """A share in percent, to a tenth; – for a share of nothing."""
    return f"{round(100 * share.agree / share.tested, 1):g} %" if share.tested else NOTHING


def coupled_conditions(family: Family, *, folded: bool = False) -> list[str]:
    """The conditions that tie the coupled joints together, for reading; `folded`: long ones are only counted."""
    if not family.named:
        return [f"no condition found; points of a set of dimension {family.dimension} at most, the witness is one"]
    coupled = set(family.coupled)
    own = [equation for equation in family.equations if coupled & set(equation.joints)]
    return [_counted(one) if folded and len(one.terms) > _FOLDED else condition_text(one) for one in own]


def _counted(equation: Equation) -> str:
    return f"fitted: {len(equation.terms)} terms on joints {', '.join(map(str, equation.joints))} (with --json)"


def condition_text(equation: Equation) -> str:
    """One condition for reading; a very long one is only counted."""
    return f"{equation.pretty()} = 0" if len(equation.terms) <= _MOST_TERMS else _counted(equation)


@dataclass(frozen=True, slots=True)
class Inside:
    """A row as the limits allow it.

    Attributes:
        pinned: the pinned joints with the values inside their limits, each moved by as few whole turns as that takes.
        outside: pinned joints with the values that lie outside at every turn.
        holds: whether every pinned joint has a value inside; otherwise the whole row lies outside the limits.
    """

    pinned: tuple[Pin, ...]
    outside: tuple[Pin, ...]

    @property
    def holds(self) -> bool:
        """Whether every pinned joint has a value inside its limits."""
        return all(one.values for one in self.pinned)

    def shown(self, family: Family) -> Family:
        """The family with the values inside; a joint that has none keeps its values."""
        kept = (mine if mine.values else given for mine, given in zip(self.pinned, family.pinned, strict=True))
        return replace(family, pinned=tuple(kept))


def inside_limits(family: Family, robot: Robot) -> Inside:
    """What the limits leave of the values of a family's pinned joints."""
    kept, left = [], []
    for one in family.pinned:
        j = one.number - 1
        bounds = np.array([robot.lower[j], robot.upper[j]])
        moved = [_moved(value, bool(robot.periodic[j]), bounds) for value in one.values]
        kept.append(replace(one, values=tuple(value for value in moved if value is not None)))
        outside = tuple(value for value, there in zip(one.values, moved, strict=True) if there is None)
        if outside:
            left.append(replace(one, values=outside))
    return Inside(tuple(kept), tuple(left))


def _moved(value: float, periodic: bool, bounds: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float | None:
    options = nearest_turns(np.array([value]), value, periodic, bounds)
    return None if not len(options) else float(options[np.abs(options - value).argmin()])


def outside_text(inside: Inside, robot: Robot) -> str:
    """What lies outside the limits, with the limits: "θ6 = −2.9218 is outside −0.0175 … 3.7525"."""
    told = []
    for one in inside.outside:
        joint = robot.variables[one.number - 1]
        kind = str(joint.kind)
        values = values_text(one.values, kind)
        verb = "is" if len(one.values) == 1 else "are"
        limits = f"{joint.lower:.4f} … {joint.upper:.4f} {joint.unit}".replace("-", "−")
        told.append(f"{joint_symbol(one.number, kind)} = {values} {verb} outside {limits}")
    return ("" if inside.holds else "the row lies outside the joint limits: ") + "; ".join(told)
