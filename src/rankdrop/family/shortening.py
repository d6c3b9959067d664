"""Names of families in few characters: what a long name gives up, and what it keeps."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from itertools import product

PARTS = ("shoulder", "elbow", "wrist")
"""Parts of an arm that a name may begin with."""
LONGEST = 60
"""Characters that a name should have at most."""


def shortened(names: Sequence[str]) -> list[str]:
    """Names of at most `LONGEST` characters that stay different; shorter ones keep every word.

    A long one gives up as little as it must: first the way its values are written, then relations of single axes, then
    other details and values. The part of the arm is always told. One that cannot be that short is the shortest that no
    other has.

    Example:
        >>> shortened(["shoulder and wrist, axes 1, 4, 6 aligned (θ2 = −112.8° or 112.8°, θ3 = −157.2° or −22.8°)"])
        ['shoulder and wrist (θ2 = ±112.8°, θ3 = −157.2° or −22.8°)']
    """
    result = list(names)
    for place, name in enumerate(names):
        if len(name) > LONGEST:
            others = {*result[:place], *names[place + 1 :]}
            tried = [one for one in _shorter(name) if one not in others]
            fitting = [one for one in tried if len(one) <= LONGEST]
            result[place] = fitting[0] if fitting else min(tried, key=len, default=name)
    return result


_HEAD = re.compile(rf"((?:{'|'.join(PARTS)})(?:(?:, | and )(?:{'|'.join(PARTS)}))*)(: |, |$)")
_DETAIL = re.compile(r"(, |; )(?=axes? |screws? |joints? |\d+ [∥⟂]|arm |with a |a line|all axes)")
_REWORDED: tuple[tuple[int, str, str | Callable[[re.Match[str]], str]], ...] = (
    (1, r"(θ\d+) = −([\d.]+°) or \2", r"\1 = ±\2"),
    (2, r"axes \d+, \d+ and wrist centre coplanar", "arm stretched or folded"),
    (4, "with a condition on", "a condition on"),
    (8, r"(concurrent|parallel) and coplanar", r"\1"),
    (12, r"\d+\.\d+(?=°)", lambda found: _whole(found[0])),
    (14, r"with a condition on [^(]*\b(?= \(|$)", "with a condition"),
)
"""(cost, words, what says nearly as much in fewer characters)."""
_RELATION, _FACT, _VALUE, _BOUND = 6, 40, 48, 80
"""Cost of leaving out "4 ⟂ 6", another fact, a value, and that there is a condition."""


def _shorter(name: str) -> list[str]:
    """What a name may become, what it loses least by first."""
    body, mark, inside = name.partition(" (") if name.endswith(")") else (name, "", "")
    values = re.split(r", (?=[θq]\d)", inside[:-1]) if mark else []
    head = _HEAD.match(body)
    part, colon = (head[1], head[2]) if head else ("", "")
    rest = body[head.end() :] if head else body
    pieces = _DETAIL.split(rest)
    details = list(zip(["", *pieces[1::2]], pieces[::2], strict=True)) if rest else []
    found: list[tuple[int, str]] = []
    for kept, told in product(_subsets([text for _, text in details], bool(part)), range(len(values) + 1)):
        lost = [text for place, (_, text) in enumerate(details) if place not in kept]
        joined = "".join(details[place][0] * (number > 0) + details[place][1] for number, place in enumerate(kept))
        text = part + colon * bool(kept) + joined + (f" ({', '.join(values[:told])})" if told else "")
        cost = sum(map(_cost, lost)) + _VALUE * (len(values) - told)
        for chosen in product((False, True), repeat=len(_REWORDED)):
            worded, spent = text, cost
            for (price, old, new), wanted in zip(_REWORDED, chosen, strict=True):
                if wanted:
                    worded, spent = re.sub(old, new, worded), spent + price
            found.append((spent, worded))
    return list(dict.fromkeys(text for _, text in sorted(found, key=lambda one: one[0])))


def _whole(degrees: str) -> str:
    """In whole degrees, unless that would be a right angle."""
    whole = round(float(degrees))
    return str(whole) if whole % 90 else degrees


def _cost(detail: str) -> int:
    """Of leaving out a detail."""
    if detail.startswith("with a"):
        return _BOUND
    return _RELATION if detail[0].isdigit() else _FACT


_MANY = 6  # details of which every choice is tried


def _subsets(details: Sequence[str], parted: bool) -> list[tuple[int, ...]]:
    """Which details may be kept, in their order: with a fact, if there is one; none where a part of the arm is told."""
    count = len(details)
    every = range(2**count) if count <= _MANY else [2**first - 1 for first in range(count + 1)]
    chosen = [tuple(i for i in range(count) if number >> i & 1) for number in every]
    facts = {i for i, text in enumerate(details) if _cost(text) == _FACT} or set(range(count))
    return [one for one in chosen if facts & set(one) or (parted and not one)]
