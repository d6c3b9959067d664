"""The tables of families, one for each corank, as AM print them (Tables 3–5): what terminal, page, paper lay out.

Title, headings, cells, footnotes and what the starts did are said here; a face chooses type, colour and breaks. The
conditions under a table are the exact ones where they are known, the fitted ones otherwise.

A cell has the values of a joint, × for free, c for coupled, or a share.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import chain
from math import floor
from typing import NamedTuple

import numpy as np

from rankdrop.families.corank_families import CorankSummary
from rankdrop.families.record import Check, Family, Pin
from rankdrop.formula.equation import Equation
from rankdrop.options import advise
from rankdrop.robot.model import Robot
from rankdrop.robot.quantities import count
from rankdrop.sections import Section
from rankdrop.text.joint_limits import inside_limits, outside_text
from rankdrop.text.joint_values import joints_named, merge_signs, symbols, value_and_degrees, values_text, witness_text
from rankdrop.text.lost import lost_note, lost_sentences
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
_MOST_TERMS = 30  # a longer condition is for programs
Cell = str | tuple[str, ...]
"""Of a table of families: a text, or several that stand under each other."""
WORDS, NUMBER, JOINT = "words", "number", "joint"
MANY = 24  # rows of one corank: of more, those of calibrated arms, some stand for all
_SHOWN = 3  # rows of a table that stand for all
_KINDS = 3  # kinds of rows that are told apart when they are counted
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
        return tuple(map(value_and_degrees, joint_values(family, number, kind)))
    return mark


def joint_values(family: Family, number: int, kind: str) -> tuple[tuple[str, str], ...]:
    """What a family asks of one joint: each value, and the same in degrees or ""; × for free, c for coupled."""
    for pinned in family.pinned:
        if pinned.number == number:
            return tuple(merge_signs(pinned.values, kind))
    return ((FREE if number in family.free else COUPLED, ""),)


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
    if len(rows) <= MANY:
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
