"""Exact conditions in words: what was derived and how, families by corank, assumptions, checks.

Long lines on several: sentences between words, formulas where a reader breaks them.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import degrees
from typing import TYPE_CHECKING

from rankdrop.exact.family import Assumption, ExactFamily
from rankdrop.family.equation import pretty_angle
from rankdrop.robot.model import Robot, lost_told, witness_text
from rankdrop.sections import Section

if TYPE_CHECKING:
    from rankdrop.results.conditions import Conditions

_BREAKS = tuple(re.compile(text) for text in (r"(?<=[,;]) ", r" (?=[+−=≠] (?!0$))", r" (?=\()", r" (?== 0$)"))
"""Places for a break, the better kinds first."""
_HANG = 4
_WORD = re.compile(r"\b[a-z]{4,}\b")
_WORDS = 4  # so many words make a sentence


def either(line: str, width: int | None) -> list[str]:
    """A line of which is not known whether it is a sentence or a formula."""
    return sentence(line, width, _HANG) if len(_WORD.findall(line)) >= _WORDS else formula(line, width)


def formula(line: str, width: int | None) -> list[str]:
    """A formula in pieces of at most `width` characters, where its words allow that.

    It is broken before a sign or a bracket, outside of as many brackets as can be had; the rest is indented.

    Args:
        line: blanks before it are an indent.
        width: characters in a line; None for as many as there are.

    Example:
        >>> formula("a2 c2 + a3 (c23 + s23) = 0", 24)
        ['a2 c2', '    + a3 (c23 + s23) = 0']
    """
    if width is None or len(line) <= width:
        return [line]
    indent = len(line) - len(line.lstrip(" "))
    found, rest, inset = [], line.strip(), indent
    while len(rest) > max(width - inset, 20):
        place = _place(rest, max(width - inset, 20))
        found.append(" " * inset + rest[:place].rstrip())
        rest, inset = rest[place:].lstrip(), indent + _HANG
    return [*found, " " * inset + rest]


def sentence(line: str, width: int | None, hang: int = 0) -> list[str]:
    """A line of words in pieces of at most `width` characters; all but the first are indented by `hang` more."""
    indent = len(line) - len(line.lstrip(" "))
    if width is None or len(line) <= width:
        return [line]
    return textwrap.wrap(
        line.strip(), max(width, indent + hang + 20), initial_indent=" " * indent,
        subsequent_indent=" " * (indent + hang), break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _place(text: str, room: int) -> int:
    """Where to break: at the shallowest place that is not right at the beginning, else at a blank, else at the end."""
    depths = list(_depths(text))
    places = [(m.start(), kind) for kind, one in enumerate(_BREAKS) for m in one.finditer(text) if m.start() <= room]
    late = [(place, kind) for place, kind in places if place > room // 5] or places
    if late:
        return min(late, key=lambda found: (depths[found[0]], found[1], -found[0]))[0]
    blanks = [i for i, letter in enumerate(text) if letter == " " and 0 < i <= room]
    return blanks[-1] if blanks else next((i for i, letter in enumerate(text) if letter == " "), len(text))


def _depths(text: str) -> Iterator[int]:
    """How many brackets are open before each character."""
    depth = 0
    for letter in text:
        yield depth
        depth += (letter == "(") - (letter == ")")


_TOGETHER = 64  # characters up to which all conditions of a family stand on one line
_LONGEST = 600  # a longer condition is for programs
_UNDERIVED = 3  # assumptions on lengths whose failing was not derived of which more are only counted
_ALIKE = 2  # sets that are not real for the same reason of which more are only counted
_LEGEND = "s_i is sin θi, c_i is cos θi, c_ij is cos(θi + θj); angles are meant modulo 2π"
METHOD = {"suppression": "dependent-screw suppression", "singular-vector": "the singular vector"} | {
    name: f"the {name} method" for name in ("determinant", "cofactors", "reciprocity")
}
"""What methods are called in a sentence, where it is not their own name."""
_ROUNDED = re.compile(r"\d\.\d{5}|\de[−-]\d")
_DIGITS = re.compile(r"\d{8}")
_INSET = " " * 7  # below the mark of a family
_UNEQUAL = re.compile(r"(\w+) ≠ (−?)(\w+)")


def arm_lines(conditions: Conditions) -> dict[str, str]:
    """What was assumed of the arm, label -> text."""
    lines = {}
    letters = ", ".join(f"{name} = {_number(value)} m" for name, value in conditions.letters.items())
    lines["lengths"] = letters or "as numbers"
    shifted = [
        f"θ{j} = q{j} {'−' if shift < 0 else '+'} {pretty_angle(abs(shift))}"
        for j, shift in enumerate(conditions.shifts, 1)
        if shift and conditions.robot.variables[j - 1].unit == "rad"
    ]
    if shifted:
        lines["angles"] = ", ".join(shifted) + ("; else θ = q" if len(shifted) < conditions.robot.n else "")
    if conditions.generic_rank < conditions.task.m:
        rank, rows = conditions.generic_rank, conditions.task.m
        lines["always"] = f"rank {rank} at most, for {rows} rows of the task; coranks are counted from {rank}"
    if conditions.remarks:
        lines["remarks"] = "\n".join(conditions.remarks)
    told = "; ".join(
        part for part in conditions.reason.split("; ") if not any(one in part for one in conditions.remarks)
    )
    reason = _reason(told)
    other = (
        "" if conditions.method == "tree" else f"; corank 1 also by {METHOD.get(conditions.method, conditions.method)}"
    )
    lines["method"] = f"rank tree{other}{reason}"
    return lines


_PLAIN = 16  # words of a reason that fits into the sentence


def _reason(told: str) -> str:
    """Why these methods: in parentheses where it is short, else as sentences of their own."""
    if len(told.split()) <= _PLAIN:
        return f" ({told})" if told else ""
    sentences = []
    for part in told.split("; "):
        first, *rest = part.split(": ")
        sentences += [": ".join([first, *rest[:1]]), *rest[1:]]
    return "".join(f". {one[0].upper()}{one[1:]}" for one in sentences) + "."


def sections_of(conditions: Conditions, *, width: int | None = None, families: bool = True) -> tuple[Section, ...]:
    """Derivation step by step where it was asked for, families, assumptions, sets that are not real, checks.

    Args:
        conditions: what was derived.
        width: characters in a line of a formula; None for as many as it has.
        families: False leaves out the families, of coranks that have any.
    """
    parts = (_steps, _determinants, *((_coranks,) if families else ()), _no_coranks, _assumed, _not_real, _checks,
             _unfinished)  # fmt: skip
    sections = (section for part in parts for section in part(conditions, width))
    return tuple(
        replace(one, lines=tuple(piece for line in one.lines for piece in sentence(line, width))) for one in sections
    )


def _steps(conditions: Conditions, width: int | None) -> Iterator[Section]:
    if conditions.settings.steps:
        for number, step in enumerate(conditions.steps):
            summary = f"derivation of corank 1, {conditions.method}" if number == 0 else ""
            yield Section(step.title, summary, tuple(piece for line in step.lines for piece in either(line, width)))


def _determinants(conditions: Conditions, width: int | None) -> Iterator[Section]:
    if conditions.determinants is not None:
        said = conditions.determinants
        title = "Determinant" if len(said.minors) == 1 or said.product else "Minors"
        lines = [piece for line in said.lines() for piece in either(line, width)]
        folded = any(step.whole for step in conditions.steps) or said.folded()
        notes = ("what is folded here is whole with --steps-out and --json",) if folded else ()
        yield Section(title, "", tuple(lines), notes=notes)


def steps_text(conditions: Conditions) -> str:
    """The derivation of corank 1 and the determinants with everything written out, unwrapped."""
    blocks = [[step.title, *(f"  {line}" for line in step.whole or step.lines)] for step in conditions.steps]
    if conditions.determinants is not None:
        blocks.append(["Determinants", *(f"  {line}" for line in conditions.determinants.lines(None))])
    head = [f"{conditions.robot.name}: derivation of corank 1, {conditions.method}", _LEGEND]
    return "\n\n".join("\n".join(block) for block in [head, *blocks]) + "\n"


def _coranks(conditions: Conditions, width: int | None) -> Iterator[Section]:
    r = conditions.generic_rank
    for corank in range(1, _highest(conditions) + 1):
        rows = conditions.of_corank(corank)
        lines = [line for family in rows for line in _family(family, conditions.robot, width)]
        count = f"{len(rows)} {'family' if len(rows) == 1 else 'families'}" if rows else _none(conditions)
        if rows and not conditions.complete:
            count += " so far"
        yield Section(f"Corank {corank}", f"rank {r - corank} of {r}: {count}", tuple(lines))


def _highest(conditions: Conditions) -> int:
    return max((family.corank for family in conditions.families), default=0)


def _no_coranks(conditions: Conditions, _width: int | None) -> Iterator[Section]:
    """The coranks above those that have families, and what letters mean."""
    r = conditions.generic_rank
    last, highest = r - conditions.lowest, _highest(conditions)
    if highest < last:
        between = "and" if highest + 2 == last else "to"
        name = f"Corank {last}" if highest + 1 == last else f"Coranks {highest + 1} {between} {last}"
        yield Section(name, _none(conditions))
    texts = [text for family in conditions.families for text in family.texts[len(family.pins) :]]
    notes = [_LEGEND] if texts else []
    lost = lost_told(conditions.robot, [words for family in conditions.families for words in family.lost_words])
    notes += [lost] * bool(lost)
    if any(_ROUNDED.search(text) for text in texts):
        notes.append("decimals are shown with six digits; --python, --c and --json have all of them")
    if last < r:
        notes.append(f"nothing is said about coranks above {last}: they were not asked for")
    if notes:
        yield Section("", "", notes=tuple(notes))


def _none(conditions: Conditions) -> str:
    if not conditions.complete:
        return "no family so far; the derivation is not complete"
    return "no family" if conditions.verified else "none derived, and a check says otherwise: see the first line"


def _family(family: ExactFamily, robot: Robot, width: int | None) -> Iterator[str]:
    """One family: name, conditions, dimension, what is lost."""
    yield from sentence(f"{family.id}  {family.name}", width, len(_INSET))
    yield from (piece for line in condition_lines(family) for piece in either(f"{_INSET}{line}", width))
    shifted = {pin.joint for pin in family.pins if family.shifts[pin.joint - 1]}
    if shifted:
        own = [one for one in family.pinned(robot) if one.number in shifted]
        told = "; ".join(f"q{one.number} = {values_in_degrees(robot, one.number, one.values)}" for one in own)
        yield from sentence(f"{_INSET}the joint's own value: {told}", width, len(_INSET))
    if family.reality:
        yield from formula(f"{_INSET}{family.reality}; here it is", width)
    yield f"{_INSET}dimension {family.dimension}, codimension {family.codimension}"
    for words in family.lost_words:
        told = words if words.startswith("can only") else f"lost: {words.removeprefix('cannot ')}"
        yield from sentence(f"{_INSET}{told}", width, len("lost: "))
    if any("witness" in words for words in family.lost_words):
        yield from sentence(f"{_INSET}witness: {witness_text(robot, family.witness)}", width, len("witness: "))


def values_in_degrees(robot: Robot, number: int, values: Sequence[float]) -> str:
    """ "0 or π", "−26.76° or 153.24°", "0.25 m"."""
    if robot.variables[number - 1].unit != "rad":
        return " or ".join(f"{value:.6g} m".replace("-", "−") for value in values)
    told = [pretty_angle(value) for value in values]
    plain = [one if "π" in one or one == "0" else f"{degrees(x):.2f}°" for one, x in zip(told, values, strict=True)]
    return " or ".join(plain).replace("-", "−")


def condition_lines(family: ExactFamily) -> list[str]:
    """The conditions: simple angles together, then one equation after the other; all on one line where they fit."""
    parts = ["; ".join(pin.text() for pin in family.pins)] if family.pins else []
    for text, condition in zip(family.texts[len(family.pins) :], family.conditions, strict=True):
        on = ", ".join(f"{'θ' if j in condition.ring.revolute else 'q'}{j}" for j in condition.joints)
        whole = "whole with --latex, --python, --c, --json"
        parts.append(text if len(text) <= _LONGEST else f"a condition on {on}, {len(text):,} characters long ({whole})")
    line = "; ".join(parts)
    return [line] if len(line) <= _TOGETHER else parts


def _assumed(conditions: Conditions, width: int | None) -> Iterator[Section]:
    lines = []
    for one in conditions.assumptions:
        if one.words:
            case, _, happens = one.words.partition(", ")
            lines += [f"{one.text} ({_holds(one, conditions)}); {case}:"]
            lines += [piece for part in happens.split("; ") for piece in sentence(f"    {part}", width, _HANG)]
        elif not one.holds:
            lines += sentence(
                f"{one.text} ({_holds(one, conditions)}); what this arm has besides was not derived", width
            )
    others = [one.text for one in conditions.assumptions if one.holds and not one.words]
    if others:
        more = "" if conditions.settings.special else " (--special derives arms with other lengths)"
        lines += sentence(f"true here; what happens otherwise was not derived{more}:", width)
        short = sorted((text for text in others if not _DIGITS.search(text)), key=len)[:_UNDERIVED]
        lines += [piece for text in short for piece in formula(f"    {text}", width)]
        if count := len(others) - len(short):
            lines += sentence(f"    and {count} more polynomials in the lengths (all of them with --json)", width)
    if lines:
        yield Section("Assumptions on the lengths", "", tuple(lines))


def _holds(assumption: Assumption, conditions: Conditions) -> str:
    said = "true here" if assumption.holds else "NOT true here"
    match = _UNEQUAL.fullmatch(assumption.text)
    if match is None or not {match[1], match[3]} <= set(conditions.letters):
        return said
    values = (conditions.letters[match[1]], (-1 if match[2] else 1) * conditions.letters[match[3]])
    return f"{said}: {_number(values[0])} {'≠' if assumption.holds else '='} {_number(values[1])}"


def _not_real(found: Conditions, width: int | None) -> Iterator[Section]:
    by_reason: dict[str, list[str]] = {}
    for text in found.not_real:
        conditions, _, reason = text.partition(": ")
        by_reason.setdefault(reason, []).append(conditions)
    lines = []
    for reason, sets in by_reason.items():
        lines += formula(reason, width)
        for conditions in sets[:_ALIKE]:
            shown = conditions if len(conditions) <= _LONGEST else f"{conditions[:_LONGEST]} …"
            lines += formula(f"    {shown}", width)
        if len(sets) > _ALIKE:
            lines.append(f"    and {len(sets) - _ALIKE} more sets like these")
    if lines:
        yield Section("Not real", "sets of lower rank on which no real configuration is known", tuple(lines))


def _checks(conditions: Conditions, width: int | None) -> Iterator[Section]:
    tested = sum(family.rank_check.tested for family in conditions.families)
    agree = sum(family.rank_check.agree for family in conditions.families)
    lines = []
    cloud = conditions.explained
    if tested:
        lines.append(f"rank as claimed at {agree:,} of {tested:,} random points of the families, modulo 2^61 − 11913")
    if cloud.tested:
        lines.append(f"{cloud.agree:,} of {cloud.tested:,} singular configurations found numerically lie on a family")
    elif conditions.settings.points:
        lines.append("the numeric search for singular configurations found none")
    else:
        lines.append("no singular configuration was looked for numerically")
    if conditions.method != "tree" and not conditions.disagreements and not conditions.left:
        lines.append(f"corank 1 derived twice: rank tree and {METHOD.get(conditions.method, conditions.method)} agree")
    lines += [f"DISAGREEMENT: {one}" for one in conditions.disagreements]
    shipped = f"As shipped with rankdrop {conditions.settings.version}; --fresh derives it anew."
    lines.append(shipped if conditions.anew else f"Time taken: {conditions.seconds:.1f} s.")
    yield Section("Checks", "", tuple(lines))


def _unfinished(conditions: Conditions, width: int | None) -> Iterator[Section]:
    if conditions.left:
        lines = tuple(piece for one in conditions.left for piece in either(one, width))
        limit = f"the limit is {conditions.settings.seconds:g} s of processor time, a third of it for the counted work"
        more = f"; {limit}, and a longer --time-limit may finish it" if conditions.limited else ""
        ended = f"the exact derivation ended after {conditions.seconds:.1f} s{more}"
        yield Section("Not finished", ended, lines)


def _number(value: float, digits: int = 12) -> str:
    return f"{value + 0.0:.{digits}g}".replace("-", "−")
