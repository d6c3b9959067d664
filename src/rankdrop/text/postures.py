"""Postures in words: "shoulder left, elbow up, wrist not flipped". Records: `rankdrop.poses.arm_posture`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rankdrop.lists import flat_map

_MEANINGS = {
    "shoulder left": "shoulder left or right of the line from axis 1 to the wrist, seen from axis 1",
    "shoulder front": "shoulder front: the wrist is in front of axis 1; back: behind it",
    "elbow up": "elbow up: above the line from shoulder to wrist",
    "elbow left": "elbow left or right of the line from axis 1 to the tool",
    "wrist not flipped": "wrist not flipped: joint 5 bends the tool down while joint 4 is at 0°",
}
_SAME = {"shoulder right": "shoulder left", "shoulder back": "shoulder front", "elbow down": "elbow up",
         "elbow right": "elbow left", "wrist flipped": "wrist not flipped"}  # fmt: skip
_PARTS = ("shoulder", "elbow", "wrist")


def part_words(parts: Any) -> list[str]:
    """The parts that are known: ["shoulder left", "elbow up"]."""
    named = ((part, getattr(parts, part)) for part in _PARTS)
    return [f"{part} {value}" for part, value in named if value is not None]


def posture_words(signs: Sequence[str], parts: Any) -> str:
    """The parts in words, then the signs of what no word is known for: "elbow up, wrist +"; "–" for none."""
    words = part_words(parts)
    named = {word.partition(" ")[0] for word in words}
    others = [sign for sign in signs if sign.partition(" ")[0].rstrip(":") not in named]
    return ", ".join([*words, *others]) or "–"


def meaning_lines(every: Sequence[Any]) -> Iterator[str]:
    """What the words of some postures mean."""
    words = flat_map(part_words, every)
    for word in dict.fromkeys(_SAME.get(word, word) for word in words):
        yield _MEANINGS[word]
