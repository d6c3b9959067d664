"""A family as the neighbourhood of one configuration shows it, and its conditions in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rankdrop.family.equation import Equation, pretty_angle
from rankdrop.family.record import Pinned
from rankdrop.robot.model import JointKind, Robot


@dataclass(frozen=True, slots=True)
class LocalFamily:
    """The family that a configuration lies on, as its neighbourhood shows it.

    Attributes:
        name: as in an atlas; "meeting point of families: …" where several meet.
        corank: of the configuration.
        dimension: of the family in joint space; of the largest one where several meet.
        pinned: joints at a fixed value on the family, and that value: only the one met here, while a row of an atlas
            holds all of them.
        free: numbers of the joints that the family does not depend on.
        coupled: numbers of the joints bound together by a condition.
        relations: whole-number relations between joints in words, "θ3 + θ5 = 0".
        equations: every condition; empty where joints are coupled and their equation was not asked for or not found.
        words: the conditions as sentences.
        parts: the families that meet at q, each as above; empty where q lies on one only.
        points: how many neighbours speak for it.
        evidence: how it was found.
    """

    name: str
    corank: int
    dimension: int
    pinned: tuple[Pinned, ...]
    free: tuple[int, ...]
    coupled: tuple[int, ...]
    relations: tuple[str, ...]
    equations: tuple[Equation, ...]
    words: tuple[str, ...]
    parts: tuple[LocalFamily, ...]
    points: int
    evidence: str

    @property
    def meeting(self) -> bool:
        """Whether several families meet at the configuration."""
        return bool(self.parts)


def condition_words(
    robot: Robot,
    pinned: Sequence[Pinned],
    relations: Sequence[str],
    bound: Sequence[int],
    equations: Sequence[Equation],
) -> tuple[str, ...]:
    """The conditions of a family: "θ4 = 0", "θ3 + θ5 = π", and the equations of coupled joints or their numbers.

    Args:
        robot: the arm.
        pinned: with one value each.
        relations: from `relation_words`.
        bound: numbers of the joints that further equations bind; empty where there are none.
        equations: all conditions, those of `pinned` and `relations` first; empty where the rest was not fitted.
    """
    told = [f"{_symbol(robot, one.number)} = {_value(robot, one)}" for one in pinned] + list(relations)
    if bound and equations:
        told += [f"{equation.pretty()} = 0" for equation in equations[len(pinned) + len(relations) :]]
    elif bound:
        told.append(f"coupled: joints {_listed(bound)}")
    return tuple(told)


def relation_words(covector: Sequence[int], value: float) -> str:
    """m·q = c: "θ3 + θ5 = π", "2 θ2 − θ4 = 0"."""
    text = ""
    for number, m in enumerate(covector, start=1):
        if m:
            sign = ("−" if m < 0 else "") if not text else (" − " if m < 0 else " + ")
            text += sign + (f"{abs(m)} " if abs(m) > 1 else "") + f"θ{number}"
    return f"{text} = {pretty_angle(value)}"


def _symbol(robot: Robot, number: int) -> str:
    slides = robot.variables[number - 1].kind is JointKind.PRISMATIC
    return f"q{number}" if slides else f"θ{number}"


def _value(robot: Robot, one: Pinned) -> str:
    if robot.variables[one.number - 1].kind is JointKind.PRISMATIC:
        return f"{one.values[0]:.4g} m".replace("-", "−")
    return pretty_angle(one.values[0])


def _listed(numbers: Sequence[int]) -> str:
    words = [str(number) for number in numbers]
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else words[0]
