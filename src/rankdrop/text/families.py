"""The tables of families, one for each corank, as AM print them (Tables 3–5): what terminal, page, paper lay out.

Title, headings, cells, footnotes and what the starts did are said here; a face chooses type, colour and breaks. The
conditions under a table are the exact ones where they are known, the fitted ones otherwise; how the two agree is told
after it. The shares of the joint space near families are a table of their own.

A cell has the values of a joint, × for free, c for coupled, or a share. Values of pinned joints within the joint
limits: moved by whole turns, and those that no turn brings inside named.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from math import degrees, floor, isclose, isfinite
from typing import NamedTuple

import numpy as np

from rankdrop.distance.distance import nearest_turns
from rankdrop.distance.share import JointSpaceShares, NearShare, SlowShare
from rankdrop.families.corank_families import CorankSummary
from rankdrop.families.derivation import Derivation
from rankdrop.families.record import Check, Family, Pin
from rankdrop.formula.equation import Equation, pretty_angle, share_of_pi
from rankdrop.options import advise
from rankdrop.robot.model import Robot, joints_beyond_limits
from rankdrop.robot.quantities import count, degrees_text
from rankdrop.sections import Section
from rankdrop.text.lost import lost_note, lost_sentences
from rankdrop.tolerances import DEFAULT
from rankdrop.units import counted_length

FREE, COUPLED, NOTHING = "×", "c", "–"
TESTED, MET = "tested", "share"
"""Headings of two columns: `share_text` of the soundness, `rounded_share` of the fresh points."""
_LEGEND = (
    "× any value, c coupled: see the condition under the table; dim: dimension of the family in joint space. "
    f"{TESTED}: of points solved from the row's conditions, how many are singular. "
    f"{MET}: part of the searches that end on this family, in percent. "
    "lost: the motion taken away, anywhere on the family unless it says otherwise. "
    "Turning by 1 rad counts as much as moving by {length} m."
)
_NUMBERS = re.compile(r"\d+")  # in a joint's name
_ALIKE = 1e-9
_MOST_TERMS = 30  # a longer condition is for programs

Cell = str | tuple[str, ...]
"""Of a table of families: a text, or several that stand under each other."""
WORDS, NUMBER, JOINT = "words", "number", "joint"

_MANY = 24  # rows of one corank: of more, those of calibrated arms, some stand for all
_SHOWN, _LARGEST = 3, 8  # so many rows of a table, so many of the shares near families
_KINDS = 3  # kinds of rows that are told apart when they are counted
AT_LEAST = "≥"
AT = "at"
"""Label of the witness in a footnote."""
EXACTLY = "exactly"
"""Label of an exact condition; a fitted one has that of a coupled joint."""
_LONGEST = 300  # characters of a condition that is printed
_SAME = 1e-6  # values of a pinned joint that differ by less are the same [rad, m]

SPEEDS_INTERRUPTED = "interrupted: the distances that keep the speed are not done"


def legend(robot: Robot, families: Iterable[Family] = ()) -> str:
    """What the marks and columns of a table of families mean, and letters and links in what is lost on them."""
    lost = lost_note(robot, chain.from_iterable(family.lost_freedoms for family in families))
    named = joints_named(robot)
    joints = f"Joints: {named}." if named else ""
    return " ".join(filter(None, (_LEGEND.format(length=f"{counted_length(robot):g}"), joints, lost)))


def joint_symbol(number: int, kind: str) -> str:
    """θ3 for an angle, q3 for a length, as conditions write them."""
    return f"{'q' if kind == 'prismatic' else 'θ'}{number}"


def value_text(value: float, kind: str = "revolute") -> str:
    """One value: "π/2", "0.7731 (44.30°)" or, for a prismatic joint, "0.25 m"."""
    return _value_and_degrees(_value_parts(value, kind))


def _value_parts(value: float, kind: str) -> tuple[str, str]:
    """A value, and the same in degrees where that helps: ("π/2", ""), ("0.7731", "44.30°")."""
    if kind == "prismatic":
        return f"{value:.6g} m", ""
    if share_of_pi(value) is not None:
        return pretty_angle(value), ""
    return f"{value:.4f}".replace("-", "−"), f"{degrees(value):.2f}°".replace("-", "−")


def _value_and_degrees(parts: tuple[str, str]) -> str:
    number, angle = parts
    if angle:
        return f"{number} ({angle})"
    return number


def values_text(values: Iterable[float], kind: str = "revolute") -> str:
    """A set of values, v and −v merged: "0, π", "±π/2", "±0.7731 (±44.30°)"."""
    return ", ".join(map(_value_and_degrees, _merge_signs(values, kind)))


def _merge_signs(values: Iterable[float], kind: str) -> Iterator[tuple[str, str]]:
    """`_value_parts` of a set of values, v and −v as one."""
    left = sorted(values, key=lambda value: (abs(value), value))
    while left:
        value = left.pop(0)
        opposite = next((other for other in left if value and isclose(other, -value, abs_tol=_ALIKE)), None)
        if opposite is None:
            yield _value_parts(value, kind)
        else:
            left.remove(opposite)
            number, angle = _value_parts(abs(opposite), kind)
            yield f"±{number}", f"±{angle}" if angle else ""


class Column(NamedTuple):
    """A column of the table of families; terminal, page, notebook and LaTeX lay it out by what it holds.

    Attributes:
        key: "id", "name", "lost", …; "θ1" and so on of joints.
        title: heading.
        cell: of a row.
        holds: `WORDS`, `NUMBER` or `JOINT`.
        failed: whether a cell is marked as bad.
        printed: in LaTeX too.
        values: of a joint's column: each value, and the same in degrees or "".
    """

    key: str
    title: str
    cell: Callable[[Family], Cell]
    holds: str = NUMBER
    failed: Callable[[Family], bool] = lambda _: False
    printed: bool = True
    values: Callable[[Family], tuple[tuple[str, str], ...]] | None = None


def columns(robot: Robot, corank: int) -> tuple[Column, ...]:
    """The columns of a table of families: id, family, each joint, dimension, what is lost, the two tests."""
    kinds = [str(joint.kind) for joint in robot.variables]
    return (
        Column("id", "", lambda row: row.id),
        Column("name", "family", lambda row: row.name, WORDS, lambda row: not row.named),
        *(Column(name, name, partial(joint_cell, number=number, kind=kinds[number - 1]), JOINT,
                 values=partial(joint_values, number=number, kind=kinds[number - 1]))
          for number, name in enumerate(symbols(robot), start=1)),
        Column("dimension", "dim", lambda row: str(row.dimension)),
        Column("lost", "lost direction" if corank == 1 else "lost directions",
               lambda row: lost_sentences(row.lost_freedoms), WORDS),
        Column("sound", TESTED, lambda row: share_text(row.soundness.agree, row.soundness.tested),
               failed=lambda row: not row.soundness.holds, printed=False),
        Column("share", MET, lambda row: rounded_share(row.explained), printed=False),
    )  # fmt: skip


def one_line(column: Column, row: Family) -> str:
    """The cell of a row in one line."""
    return ("; " if column.holds == WORDS else ", ").join(lines_of(column, row))


def broken(column: Column, row: Family) -> str:
    """The cell of a row with breaks for a narrow column: values with degrees, and these, on lines of their own."""
    if column.values is None:
        return "\n".join(lines_of(column, row))
    values = column.values(row)
    if not any(angle for _, angle in values):
        return ", ".join(number for number, _ in values)
    return ",\n".join(f"{number}\n({angle})" if angle else number for number, angle in values)


def lines_of(column: Column, row: Family) -> tuple[str, ...]:
    """The cell of a row as its lines or values."""
    cell = column.cell(row)
    if isinstance(cell, str):
        return (cell,)
    return cell


def joint_cell(family: Family, number: int, kind: str) -> Cell:
    """What a family asks of one joint: its values, × for free, c for coupled."""
    mark = FREE if number in family.free else COUPLED
    pinned = any(pin.number == number for pin in family.pinned)
    if pinned:
        return tuple(map(_value_and_degrees, joint_values(family, number, kind)))
    return mark


def joint_values(family: Family, number: int, kind: str) -> tuple[tuple[str, str], ...]:
    """What a family asks of one joint: each value, and the same in degrees or ""; × for free, c for coupled."""
    for pinned in family.pinned:
        if pinned.number == number:
            return tuple(_merge_signs(pinned.values, kind))
    return ((FREE if number in family.free else COUPLED, ""),)


def values_in_degrees(robot: Robot, number: int, values: Sequence[float]) -> str:
    """Values as "0 or π", "−26.76° or 153.24°", "0.25 m"."""
    if robot.variables[number - 1].unit != "rad":
        return " or ".join(f"{value:.6g} m".replace("-", "−") for value in values)
    return " or ".join(map(_in_degrees, values))


def _in_degrees(value: float) -> str:
    """An angle as "π/2" or "−26.76°"."""
    if share_of_pi(value) is not None:
        return pretty_angle(value)
    return f"{degrees(value):.2f}°".replace("-", "−")


def share_text(part: int, whole: int) -> str:
    """A share in percent, rounded down so that 100 % means all; – for a share of nothing."""
    if whole:
        return f"{floor(1000 * part / whole) / 10:g} %"
    return NOTHING


def rounded_share(share: Check) -> str:
    """A share in percent, to a tenth; – for a share of nothing."""
    if share.tested:
        return f"{round(100 * share.agree / share.tested, 1):g} %"
    return NOTHING


def coupled_conditions(family: Family) -> list[str]:
    """The conditions that tie the coupled joints together, for reading."""
    if not family.named:
        return [f"no condition found; points of a set of dimension {family.dimension} at most, the witness is one"]
    coupled = set(family.coupled)
    return [condition_text(equation) for equation in family.equations if coupled & set(equation.joints)]


def condition_text(equation: Equation) -> str:
    """One condition for reading; a very long one is only counted."""
    if len(equation.terms) <= _MOST_TERMS:
        return f"{equation.pretty()} = 0"
    joints, every = ", ".join(map(str, equation.joints)), advise("json", python="to_dict()")
    return f"fitted: {len(equation.terms)} terms on joints {joints} (all of them: {every})"


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
        return all(pin.values for pin in self.pinned)

    def with_values_inside(self, family: Family) -> Family:
        """The family with the values inside; a joint that has none keeps its values."""
        kept = (mine if mine.values else given for mine, given in zip(self.pinned, family.pinned, strict=True))
        return replace(family, pinned=tuple(kept))


def inside_limits(family: Family, robot: Robot) -> Inside:
    """What the limits leave of the values of a family's pinned joints."""
    kept, left = [], []
    for pin in family.pinned:
        j = pin.number - 1
        bounds = np.array([robot.lower[j], robot.upper[j]])
        moved = [_nearest_turn_inside(value, bool(robot.periodic[j]), bounds) for value in pin.values]
        kept.append(replace(pin, values=tuple(value for value in moved if value is not None)))
        outside = tuple(value for value, there in zip(pin.values, moved, strict=True) if there is None)
        if outside:
            left.append(replace(pin, values=outside))
    return Inside(tuple(kept), tuple(left))


def _nearest_turn_inside(
    value: float, periodic: bool, bounds: np.ndarray[tuple[int], np.dtype[np.float64]]
) -> float | None:
    options = nearest_turns(np.array([value]), value, periodic, bounds)
    if not len(options):
        return None
    return float(options[np.abs(options - value).argmin()])


def outside_text(inside: Inside, robot: Robot) -> str:
    """What lies outside the limits, with the limits: "θ6 = −2.9218 is outside −0.0175 … 3.7525"."""
    told = []
    for pin in inside.outside:
        joint = robot.variables[pin.number - 1]
        kind = str(joint.kind)
        values = values_text(pin.values, kind)
        verb = "is" if len(pin.values) == 1 else "are"
        limits = f"{joint.lower:.4f} … {joint.upper:.4f} {joint.unit}".replace("-", "−")
        told.append(f"{joint_symbol(pin.number, kind)} = {values} {verb} outside {limits}")
    return ("" if inside.holds else "the row lies outside the joint limits: ") + "; ".join(told)


def title(summary: CorankSummary, generic_rank: int) -> str:
    """ "Corank 1 (rank 5 of 6)"."""
    return f"Corank {summary.corank} (rank {summary.rank} of {generic_rank})"


def nothing_found(summary: CorankSummary) -> str:
    """What is said where a corank has no row."""
    smallest = summary.smallest_near_miss
    if smallest is None:
        met = ""
    else:
        met = f", smallest σ{summary.rank + 1} found {smallest:.4g}"
    return f"none found of {count(summary.starts, 'start')}{met}. Not finding one proves nothing."


def number_of(rows: Sequence[Family]) -> str:
    """ "1 family", "4 families"."""
    return count(len(rows), "family", "families")


def explained(share: Check) -> str:
    """How many fresh points the rows of a corank explain."""
    return f"{share.agree:,} of {share.tested:,} test points explained"


def starts(summary: CorankSummary) -> str:
    """What came of the random starts of a corank."""
    near = count(summary.near_misses, "near miss", "near misses")
    line = f"Of {count(summary.starts, 'start')}: {summary.converged:,} converged, {near}, {summary.slow:,} slow."
    if summary.converged and summary.smallest_near_miss is not None:
        line += f" Smallest near miss: σ{summary.rank + 1} = {summary.smallest_near_miss:.4g}, not singular."
    return line


def joints_named(robot: Robot) -> str:
    """Which symbol is which joint, where a maker's name has another number than the symbol: "q1 rail, θ2 a1"; else "".

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> joints_named(open_robot("ur5e"))[:41], joints_named(open_robot("pa10"))
        ('θ1 shoulder_pan_joint, θ2 shoulder_lift_j', '')
    """
    named = list(zip(symbols(robot), (joint.name for joint in robot.variables), strict=True))
    numbers = [_NUMBERS.findall(name) for _, name in named]
    other = any(digits and int(digits[-1]) != place for place, digits in enumerate(numbers, start=1))
    if other:
        return ", ".join(f"{symbol} {name}" for symbol, name in named)
    return ""


def symbols(robot: Robot) -> tuple[str, ...]:
    """The joints as conditions write them: "θ1", "q3" for a slide."""
    return tuple(joint_symbol(number, str(joint.kind)) for number, joint in enumerate(robot.variables, start=1))


def restrict_to_limits(row: Family, robot: Robot, *, limits: bool) -> tuple[Family, str]:
    """The row with its values inside the limits where these were asked for, and what of it lies outside, or ""."""
    if not limits:
        return row, ""
    inside = inside_limits(row, robot)
    return inside.with_values_inside(row), outside_text(inside, robot) if inside.outside else ""


def at_witness(row: Family) -> bool:
    """Whether what is lost is told for the witness, which has to be named then."""
    return not all(freedom.everywhere for freedom in row.lost_freedoms)


def asked(robot: Robot, row: Family) -> str:
    """What a row asks of the joints, in a line: "θ3 = 0, π; θ5, θ6 coupled; θ1 free"."""
    names = symbols(robot)
    kinds = [str(joint.kind) for joint in robot.variables]
    parts = [f"{names[pin.number - 1]} = {values_text(pin.values, kinds[pin.number - 1])}" for pin in row.pinned]
    for numbers, word in ((row.coupled, "coupled"), (row.free, "free")):
        if numbers:
            parts.append(f"{', '.join(names[number - 1] for number in numbers)} {word}")
    return "; ".join(parts)


def examples(rows: Sequence[Family]) -> dict[int, Family]:
    """The rows to show, by their number: all, or of very many those of the largest shares, unsound ones first."""
    numbered = enumerate(rows, start=1)
    if len(rows) <= _MANY:
        return dict(numbered)
    ordered = sorted(numbered, key=lambda pair: (not _unsound(pair[1]), not pair[1].named, -pair[1].explained.agree))
    return dict(sorted(ordered[:_SHOWN]))


def hidden_rows_words(robot: Robot, rows: Sequence[Family]) -> str:
    """Rows that are not shown, counted by their kind."""
    kinds = Counter(_kind(robot, row) for row in rows).most_common()
    parts = [f"{count:,} {words}" for words, count in kinds[:_KINDS]]
    others = sum(count for _, count in kinds[_KINDS:])
    parts += [f"{others:,} of other kinds"] * (others > 0)
    unsound = sum(map(_unsound, rows))
    if unsound:
        sound = f"{unsound:,} of them failed their test"
    else:
        sound = "all passed their test"
    every = advise("all", python="to_dict()")
    return f"and {len(rows):,} more rows, {sound}: {'; '.join(parts)}. All of them: {every}."


def _unsound(row: Family) -> bool:
    return row.soundness.agree < row.soundness.tested


def _kind(robot: Robot, row: Family) -> str:
    """What rows have in common: which joints are fixed, which coupled, and of what dimension they are."""
    if not row.named:
        return f"without a condition, of dimension {row.dimension} at most"
    names, parts = symbols(robot), []
    for numbers, word in (([pin.number for pin in row.pinned], "fixed"), (row.coupled, "coupled")):
        if numbers:
            parts.append(f"{', '.join(names[number - 1] for number in numbers)} {word}")
    return f"with {' and '.join(parts)}, of dimension {row.dimension}"


def conditions_of(row: Family) -> list[tuple[str, str]]:
    """(label, text) of every condition of a row that its table does not say.

    Exact ones stand in place of decimals, and long ones are only counted: programs find them in the JSON.
    """
    exact = _exact_lines(row)
    if exact:
        return [(EXACTLY, text) for text in exact]
    return [(COUPLED, text) for text in coupled_conditions(row)]


def witness_text(robot: Robot, q: Sequence[float]) -> str:
    """A witness as people set it, and the joints beyond their limits: of some families every member has such.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> witness_text(open_robot("panda"), [0.0, 0.0, 0.0, 0.0, 0.0, 1.5, 0.0])
        'q = (0°, 0°, 0°, 0°, 0°, 85.94°, 0°), beyond the limits of joint 4'
    """
    values = f"q = {degrees_text(q, robot.units)}"
    beyond = joints_beyond_limits(robot, q)
    if not beyond:
        return values
    listed = ", ".join(map(str, beyond))
    if len(beyond) == 1:
        return f"{values}, beyond the limits of joint {listed}"
    return f"{values}, beyond the limits of joints {listed}"


def exact_conditions(row: Family) -> str:
    """The exact conditions of a row in one line; empty where the table says it all: joints at simple values."""
    return " and ".join(_exact_lines(row))


def _exact_lines(row: Family) -> list[str]:
    """The exact conditions of a row that its table does not say; when it is real stands after the last."""
    exact = row.exact
    if exact is None:
        return []
    pins = [text for text, pin in zip(exact.conditions, exact.pinned, strict=False) if not _in_table(row, pin)]
    lines = [*pins, *map(readable, exact.conditions[len(exact.pinned) :])]
    if lines and exact.reality:
        lines[-1] += f"; {exact.reality}"
    return lines


def readable(text: str) -> str:
    """A condition for reading; a very long one is only counted."""
    whole = f"whole with {advise('json', python='to_dict()')}"
    if len(text) <= _LONGEST:
        return text
    return f"a condition of {len(text):,} characters ({whole})"


def _in_table(row: Family, pin: Pin) -> bool:
    own = next((pinned.values for pinned in row.pinned if pinned.number == pin.number), None)
    if own is None:
        return False
    return bool((np.abs(np.subtract.outer(own, pin.values)).min(axis=1, initial=np.inf) <= _SAME).all())


def footnotes(robot: Robot, row: Family, outside: str, *, lost: bool) -> list[tuple[str, str]]:
    """(label, text) of what stands under the table of a row: limits, conditions, what is lost, the witness.

    Args:
        robot: the arm.
        row: a family.
        outside: what of it lies outside the joint limits, or "".
        lost: with the directions lost, which the table has no room for.
    """
    exactly = exact_conditions(row)
    notes = [("limits", outside)] if outside else []
    notes += [(EXACTLY, exactly)] if exactly else conditions_of(row)
    if lost:
        notes += [("lost", words) for words in lost_sentences(row.lost_freedoms)]
    if at_witness(row) or not row.named:
        notes.append((AT, f"witness {witness_text(robot, row.witness)}"))
    return notes


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


def letters_text(letters: Mapping[str, float] | None) -> str:
    """Lengths that stand as letters: "a2 = 0.4318 m, d3 = −0.1 m"."""
    return ", ".join(f"{name} = {value:.6g} m".replace("-", "−") for name, value in (letters or {}).items())


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


def overview(
    robot: Robot, generic_rank: int, coranks: Sequence[CorankSummary], families: Sequence[Family],
    *, limits: bool = False,
) -> Iterator[Section]:  # fmt: skip
    """One section for each corank, for a notebook: its table, the conditions under it, what the starts did.

    Args:
        robot, generic_rank, coranks, families: of an analysis.
        limits: values of pinned joints inside the joint limits only.
    """
    about = f": {robot.about}" if robot.about else ""
    yield Section(f"{robot.name}{about}", f"rank {generic_rank} almost everywhere")
    for summary in coranks:
        rows = [family for family in families if family.corank == summary.corank]
        if rows:
            yield _corank_section(robot, generic_rank, summary, rows, limits=limits)
        else:
            yield Section(title(summary, generic_rank), nothing_found(summary))
    if families:
        yield Section("", lines=(legend(robot, families),))


def _corank_section(
    robot: Robot, generic_rank: int, summary: CorankSummary, families: Sequence[Family], *, limits: bool
) -> Section:
    """The table of the families of one corank, the conditions under it, what the starts did."""
    table = columns(robot, summary.corank)
    rows, under = [], []
    for family in families:
        row, outside = restrict_to_limits(family, robot, limits=limits)
        rows.append(tuple(one_line(column, row) for column in table))
        for label, words in footnotes(robot, row, outside, lost=False):
            if label == AT:
                under.append(f"{row.id} {words}")
            else:
                under.append(f"{row.id} {label}: {words}")
    return Section(
        title(summary, generic_rank), f"{number_of(families)}, {explained(summary.completeness)}",
        columns=tuple(column.title for column in table), rows=tuple(rows),
        texts=tuple(i for i, column in enumerate(table) if column.holds == WORDS or column.key == "id"),
        after=tuple(under), notes=(starts(summary),),
    )  # fmt: skip


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


def near_overview(near: JointSpaceShares, families: Sequence[Family]) -> Section:
    """Shares of the joint space near the families."""
    names = {family.id: family.name for family in families}
    where = "the joint space inside the limits" if near.limits else "the joint space"
    many = len(near.families) > _MANY
    shown = sorted(near.families, key=lambda share: -share.near)[:_LARGEST] if many else near.families
    rows = [*((share.id, names.get(share.id, ""), share) for share in shown), ("any", "", near.any)]
    if near.slow is not None:
        rows.append(("slow", "tool slower than 25 mm/s or 5°/s, inside the limits", near.slow))
    notes = [f"{near.samples:,} random configurations, seed {near.seed}; ± standard error; 95 % by Wilson's rule"]
    if len(shown) < len(near.families):
        notes.append(f"the {_LARGEST} largest of {len(near.families)}; all of them in the JSON")
    if near.any.bound:
        notes.append(f"{AT_LEAST}: coupled joints (their nearest point may be missed), or a row without conditions")
    return Section(
        f"Within {degrees(near.within):.4g}° of singularities", f"share of {where}, distance over all joints",
        columns=("", "family", "share", "±", "95 %"),
        rows=tuple(
            (id, name, _percent(share), f"{100 * share.error:.2g} %", _interval_words(share))
            for id, name, share in rows
        ),
        texts=(0, 1), notes=tuple(notes),
    )  # fmt: skip


def slow_line(slow: SlowShare) -> str:
    """The share of the joint space in which the tool is slow, its interval and its samples."""
    share = slow.share
    return (
        f"At {_percent(share)} of the configurations inside the joint limits the tool is slower than "
        f"{1000 * slow.tool_speed:.4g} mm/s in its worst direction (95 %: {_close_between(share)}): "
        f"{share.samples:,} random configurations, uniform in each joint, seed {slow.seed}."
    )


def slow_configurations(slow: NearShare | None, speed: float, turn_speed: float) -> str:
    """The share of slow configurations on a page, at speeds in m/s and rad/s; without it, what the file lacks."""
    if slow is None:
        return "unknown: too few joints have a rate limit (state `velocity` of the joints in the arm's file)"
    return (
        f"below {1000 * speed:.4g} mm/s or {degrees(turn_speed):.3g}°/s in some direction: {_percent(slow)} of "
        f"configurations inside limits (95 %: {_close_between(slow)}; {slow.samples:,} random ones, uniform in each "
        "joint)"
    )


def _close_between(share: NearShare) -> str:
    """The 95 % interval to three digits."""
    low, high = (100 * end for end in share.interval)
    return f"{low:.3g} … {high:.3g} %"


def share_cell(share: NearShare) -> str:
    """A share of the joint space in a table: "7.75 %", "≥ 5.7 %"."""
    return _percent(share)


def near_total(near: JointSpaceShares) -> str:
    """The share near any family, and the share where the tool is slow."""
    total = f"any: {_percent(near.any)} ± {100 * near.any.error:.2g} %"
    if near.slow is None:
        return total
    return f"{total}; tool slower than 25 mm/s or 5°/s: {_percent(near.slow)}"


def _percent(share: NearShare) -> str:
    return f"{AT_LEAST if share.bound else ''} {100 * share.share:.3g} %".strip()


def _interval_words(share: NearShare) -> str:
    low, high = (100 * end for end in share.interval)
    return f"{low:.2g} … {high:.2g} %"
