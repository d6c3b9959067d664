"""Which lengths of an arm are letters: names, values, and where each stands."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from fractions import Fraction

from rankdrop.errors import OptionError
from rankdrop.exact.arm.geometry import Section, decimals
from rankdrop.robot.lengths import LETTERS_ALLOWED, is_letter
from rankdrop.robot.model import JointKind, Robot
from rankdrop.units import exponent, shifted

MANY = 14
"""More different lengths than this stay numbers unless letters are asked for."""

ODD = 1
"""Different twists that are no quarter turns, such as the 60° of a wrist, beyond which lengths stay numbers."""

Place = tuple[int, str]
"""(index of a section, "a" or "d")."""


def named_lengths(
    robot: Robot,
    found: Sequence[Section],
    lengths: str | Mapping[str, float],
    tip: Sequence[Fraction] | None,
) -> tuple[dict[str, Fraction], dict[Place, tuple[int, str]]]:
    """Letters with their values [m], and how each length reads: sign and letter. What is absent stays a number.

    Args:
        robot: its own letters come first.
        found: twists, lengths and phases along the chain.
        lengths: as in `exact_chain`.
        tip: (3,) position of the tip in the frame of the last link [m], for tasks that depend on it.

    Raises:
        OptionError: a letter that means something else in conditions, or that no length has.
    """
    given = _given(lengths)
    values = _values(found, tip)
    if lengths == "numbers" or (lengths == "auto" and _without_structure(found, values)):
        return {}, {}
    own = dict(robot.lengths) if isinstance(lengths, str) else {}
    named = given or dict(zip(own, _decimals(own.values(), exponent(robot)), strict=True))
    letters = dict(named)
    written: dict[Place, tuple[int, str]] = {}
    for (i, which), value in values.items():
        # a distance along an axis and one across it may agree by chance: they keep letters of their own, unless named
        same = [x for x, known in letters.items() if abs(known) == abs(value) and (x in named or x[0] == which)]
        if given and not same:
            continue
        name = min(same, key=lambda x: x[0] != which) if same else _free(f"{which}{min(i + 1, len(found))}", letters)
        letters.setdefault(name, value)
        written[i, which] = (1 if letters[name] == value else -1, name)
    used = {name for _, name in written.values()}
    if not used >= set(given):
        raise OptionError(
            "no length of the arm has this value",
            where="lengths",
            got=", ".join(f"{name} = {float(value)} m" for name, value in given.items() if name not in used),
            allowed=", ".join(f"{which}{i + 1} = {float(v)} m" for (i, which), v in values.items()),
        )
    return {name: value for name, value in letters.items() if name in used}, written


def _decimals(values: Iterable[float], power: int) -> list[Fraction]:
    """Lengths as decimals of 10 to a power."""
    return [one * Fraction(10) ** power for one in decimals(shifted(value, -power) for value in values)]


def _given(lengths: str | Mapping[str, float]) -> dict[str, Fraction]:
    """The caller's letters; none where a word was said."""
    if isinstance(lengths, str):
        if lengths not in ("auto", "letters", "numbers"):
            raise OptionError(
                "lengths are letters or numbers",
                got=repr(lengths),
                allowed="auto, letters, numbers, or letter = value",
            )
        return {}
    for name in lengths:
        if not is_letter(name):
            raise OptionError(
                "a length cannot have this name", where="lengths", got=repr(name), allowed=LETTERS_ALLOWED
            )
    return {name: Fraction(str(value)) for name, value in lengths.items()}


def _values(found: Sequence[Section], tip: Sequence[Fraction] | None) -> dict[Place, Fraction]:
    """Every length other than 0 that conditions may depend on; index n is the tip."""
    last = len(found)
    # neither the first nor the last offset moves a screw against another one
    places = [(i, which) for i in range(last) for which in "da" if 0 < i < last - 1 or (i, which) == (0, "a")]
    values: dict[Place, Fraction] = {place: getattr(found[place[0]], place[1]) for place in places}
    if tip is not None:
        values |= {(last, "a"): tip[0], (last, "d"): tip[2]}
    return {place: value for place, value in values.items() if value != 0}


def _without_structure(found: Sequence[Section], values: Mapping[Place, Fraction]) -> bool:
    """Whether letters would make conditions too long: several twists that are no quarter turns, or many lengths."""
    turns = [t for s in found for t in (s.twist, *([s.phase] if s.kind is JointKind.PRISMATIC else []))]
    odd = {abs(t.sin) for t in turns if t.quarters is None}
    return len({abs(value) for value in values.values()}) > MANY or len(odd) > ODD


def _free(name: str, taken: Container[str]) -> str:
    """The name, with as many _ behind it as make it a new one."""
    while name in taken:
        name += "_"
    return name
