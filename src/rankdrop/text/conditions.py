"""Exact conditions in words: what was derived and how, families by corank, assumptions, unreal sets, checks."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from html import escape
from itertools import chain
from typing import Any

from rankdrop.exact.family import Assumption, EqualLengths, SpecialFamily, Unreal, UnrealSet
from rankdrop.families.record import ExactConditions, Family, exact_of
from rankdrop.formula.equation import pretty_angle
from rankdrop.formula.mathml import typeset
from rankdrop.lists import flat_map
from rankdrop.options import advise
from rankdrop.robot.model import Robot
from rankdrop.robot.quantities import count
from rankdrop.sections import Formula, Section, html
from rankdrop.text.claims import answer_of as answer_of  # here too: `words_of` finds all words of conditions here
from rankdrop.text.claims import of_conditions as of_conditions
from rankdrop.text.claims import summary_of_conditions as summary_of_conditions
from rankdrop.text.code import Code
from rankdrop.text.joint_values import values_in_degrees, witness_text
from rankdrop.text.lost import lost_line, lost_note, lost_sentences
from rankdrop.text.structure import reason_text
from rankdrop.text.unfinished import cases_words, why_lowest
from rankdrop.version import VERSION

_TOGETHER = 64  # characters up to which all conditions of a family stand on one line
_CASE = 300  # characters up to which the conditions of a case that was not taken apart are printed
_LONGEST = 600  # a longer condition is for programs
_UNDERIVED = 3  # assumptions on lengths whose failing was not derived of which more are only counted
_ALIKE = 2  # sets that are not real for the same reason of which more are only counted
_LEGEND = "s_i is sin θi, c_i is cos θi, c_ij is cos(θi + θj); angles are meant modulo 2π"
_METHOD = {
    "suppression": "dependent-screw suppression", "singular-vector": "the singular vector",
    "elementary": "elementary transformations",
    **{name: f"the {name} method" for name in ("determinant", "cofactors", "reciprocity")},
}  # fmt: skip
"""What methods are called in a sentence, where it is not their own name."""
_ROUNDED = re.compile(r"\d\.\d{5}|\de[−-]\d")
_DIGITS = re.compile(r"\d{8}")
_INSET = " " * 7  # below the mark of a family

_FREEDOMS = {1: "one freedom", 2: "two freedoms", 3: "three freedoms", 4: "four freedoms", 5: "five freedoms"}

_UNREAL = {
    Unreal.PROVEN: "not real, for {proof}",
    Unreal.NOT_FOUND: "no real point was found from {tried} random starts",
    Unreal.NOR_MODULO_PRIMES: "no real point was found, nor one modulo {tried} primes",
}


def arm_lines(conditions: Any) -> dict[str, str]:
    """What was assumed of the arm, label -> text."""
    letters = ", ".join(f"{name} = {_number(value)} m" for name, value in conditions.letters.items())
    rank, rows, method = conditions.generic_rank, conditions.task.m, _method(conditions)
    always = f"rank {rank} at most, for {rows} rows of the task; coranks are counted from {rank}"
    lines = {
        "lengths": letters or "as numbers",
        "angles": angles_text(conditions.robot, conditions.shifts),
        "always": always if rank < rows else "",
        "remarks": "\n".join(map(str, conditions.remarks)),
        "method": f"rank tree{'' if method == 'tree' else f'; {_twice(conditions)} also by {method}'}",
        "reason": reason_text(conditions.reason),
    }
    return {label: text for label, text in lines.items() if text}


def angles_text(robot: Robot, shifts: Sequence[float]) -> str:
    """What the angles of conditions mean: "θ3 = q3 + 2.886; else θ = q"; "" where every θ is q.

    Args:
        robot: the arm.
        shifts: θ − q of each joint [rad].
    """
    shifted = [
        f"θ{j} = q{j} {'−' if shift < 0 else '+'} {pretty_angle(abs(shift))}"
        for j, shift in enumerate(shifts, 1)
        if shift and robot.variables[j - 1].unit == "rad"
    ]
    if shifted and len(shifted) < robot.n:
        others = "; else θ = q"
    else:
        others = ""
    return f"{', '.join(shifted)}{others}"


def _method(conditions: Any) -> str:
    name: str = conditions.method
    return _METHOD.get(name, name)


def _twice(conditions: Any) -> str:
    """The coranks that another method than the rank tree derived: "corank 1", "coranks 1 to 3"."""
    highest = min(conditions.settings.coranks or 1, conditions.generic_rank)
    if conditions.method != "reciprocity" or highest == 1:
        return "corank 1"
    between = "to" if highest > 2 else "and"
    return f"coranks 1 {between} {highest}"


def _derivation(conditions: Any) -> str:
    return f"derivation of {_twice(conditions)}, {conditions.method}"


def condition_sections(conditions: Any, *, families: bool = True) -> tuple[Section, ...]:
    """Derivation step by step where it was asked for, families, assumptions, sets that are not real, checks.

    Args:
        conditions: what was derived.
        families: False leaves out the families, of coranks that have any.
    """
    parts = (_steps, _determinants, *((_coranks,) if families else ()), _no_coranks, _undivided_sections, _assumptions,
             _not_real, _checks, _unfinished_sections)  # fmt: skip
    return tuple(flat_map(lambda part: part(conditions), parts))


def conditions_html(conditions: Any) -> str:
    """For notebooks: the verdict, the conditions of every family typeset, and what was checked."""
    rows = "".join(_row_html(family, conditions.robot) for family in conditions.families)
    head = "<tr><th></th><th>corank</th><th>family</th><th>conditions</th><th>dim</th><th>lost</th></tr>"
    if rows:
        table = f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>"
    else:
        table = ""
    return html(conditions.sections()[:1]) + table + html(condition_sections(conditions, families=False))


def _row_html(family: Family, robot: Robot) -> str:
    lost = [*lost_sentences(family.lost_freedoms), *_witness(family, robot)]
    return (
        f"<tr><td>{family.id}</td><td>{family.corank}</td><td>{escape(family.name)}</td>"
        f"<td>{'<br>'.join(map(typeset, family.latex))}</td><td>{family.dimension}</td>"
        f"<td>{'<br>'.join(map(escape, lost))}</td></tr>"
    )


def _steps(conditions: Any) -> Iterator[Section]:
    for number, step in enumerate(conditions.steps if conditions.settings.steps else ()):
        yield Section(step.title, "" if number else _derivation(conditions), step.lines)


def _determinants(conditions: Any) -> Iterator[Section]:
    if conditions.determinants is not None:
        minors = conditions.determinants
        if len(minors.minors) == 1 or minors.product:
            title = "Determinant"
        else:
            title = "Minors"
        folded = any(step.whole for step in conditions.steps) or minors.tells_sizes()
        notes = (
            (f"the whole of it: {advise('steps-out', 'FILE', python='steps_text(conditions)')}",)
            if folded
            else ()
        )
        yield Section(title, "", tuple(minors.lines()), notes=notes)


def steps_text(conditions: Any) -> str:
    """The derivation of corank 1 and the determinants with everything written out, unwrapped."""
    blocks = [[step.title, *(f"  {line}" for line in step.whole or step.lines)] for step in conditions.steps]
    if conditions.determinants is not None:
        blocks.append(["Determinants", *(f"  {line}" for line in conditions.determinants.lines(None))])
    head = [f"{conditions.robot.name}: {_derivation(conditions)}", _LEGEND]
    return "\n\n".join("\n".join(block) for block in [head, *blocks]) + "\n"


def _coranks(conditions: Any) -> Iterator[Section]:
    r = conditions.generic_rank
    for corank in range(1, _highest(conditions) + 1):
        rows = conditions.of_corank(corank)
        lines = tuple(flat_map(lambda family: _family(family, conditions.robot), rows))
        so_far = "" if conditions.complete else " so far"
        if rows:
            number = f"{count(len(rows), 'family', 'families')}{so_far}"
        else:
            number = _none(conditions)
        yield Section(f"Corank {corank}", f"rank {r - corank} of {r}: {number}", lines)


def _highest(conditions: Any) -> int:
    return max((family.corank for family in conditions.families), default=0)


def _no_coranks(conditions: Any) -> Iterator[Section]:
    r = conditions.generic_rank
    last, highest = r - conditions.lowest, _highest(conditions)
    if highest + 1 == last:
        yield Section(f"Corank {last}", _none(conditions))
    elif highest < last:
        between = "and" if highest + 2 == last else "to"
        yield Section(f"Coranks {highest + 1} {between} {last}", _none(conditions))
    notes = [*_condition_notes(conditions)]
    if last < r:
        notes.append(f"nothing is said about coranks above {last}: they {why_lowest(conditions)}")
    if notes:
        yield Section("", "", notes=tuple(notes))


def _undivided_sections(conditions: Any) -> Iterator[Section]:
    """Cases that were not taken apart, with a configuration on each."""
    lines: list[str] = []
    for number, case in enumerate(conditions.undivided, 1):
        lines += [f"case {number}: {undivided_words(case)}", f"{_INSET}{_example(case, conditions.robot)}"]
    if lines:
        cases = "the rank is lower exactly where the conditions of a case hold and its minors vanish"
        yield Section("Not taken apart", cases, tuple(lines), notes=_case_notes(conditions))


def _case_notes(conditions: Any) -> tuple[str, ...]:
    """What sines and cosines in the conditions of cases are called, where no family's conditions say so."""
    of_families = any(len(family.texts) > len(exact_of(family).pins) for family in conditions.families)
    of_cases = any(len(case.texts) > len(case.pins) for case in conditions.undivided)
    if of_cases and not of_families:
        return (_LEGEND,)
    return ()


def undivided_words(case: Any) -> str:
    """A case that was not taken apart, by its conditions and minors: "corank 1 or more where θ5 = 0, and …"."""
    if case.texts and sum(map(len, case.texts)) <= _CASE:
        parts = [*case.texts]
    else:
        parts = [pin.text() for pin in case.pins]
        if case.polynomials:
            parts.append(_polynomial_words(case.polynomials))
    minors = f"{count(case.minors, 'minor vanishes', 'minors vanish')}, of order {case.order}"
    degree = f"degree at most {case.degree} in sines and cosines"
    return f"corank {case.corank} or more where {', '.join(parts)}, and {minors} ({degree})"


def _polynomial_words(polynomials: Sequence[Any]) -> str:
    """ "2 polynomials in joints 3, 4 vanish together (degrees 4, 9 in half-angle tangents; 12, 110 terms)"."""
    joints = ", ".join(map(str, sorted({*chain.from_iterable(f.joints for f in polynomials)})))
    degrees = ", ".join(str(f.degree) for f in polynomials)
    terms = ", ".join(f"{f.terms:,}" for f in polynomials)
    size = f"{degrees} in half-angle tangents; {terms} terms"
    if len(polynomials) == 1:
        return f"1 polynomial in joints {joints} vanishes (degree {size})"
    return f"{len(polynomials)} polynomials in joints {joints} vanish together (degrees {size})"


def _example(case: Any, robot: Robot) -> str:
    """A configuration of a case, or that none was found."""
    if case.witness is None:
        return f"no real configuration was found from {case.starts} starts, which proves nothing"
    where = witness_text(robot, case.witness)
    if case.off:
        return f"for example {where}, on no family; {case.off} of {case.found} found are on none"
    return f"for example {where}; all {case.found} configurations found are on families too"


def unfinished_text(conditions: Any) -> str:
    """Why not every singular configuration is known to be on a family."""
    return "; ".join(map(str, conditions.left)) or cases_words(len(conditions.undivided))


def _condition_notes(conditions: Any) -> Iterator[str]:
    """What letters in the conditions and in lost motions mean, and where all digits stand."""
    families = conditions.families
    exact = [*map(exact_of, families)]
    texts = [*chain.from_iterable(derived.conditions[len(derived.pins) :] for derived in exact)]
    if texts:
        yield _LEGEND
    lost = lost_note(conditions.robot, chain.from_iterable(family.lost_freedoms for family in families))
    if lost:
        yield lost
    if any(_ROUNDED.search(text) for text in texts):
        yield _all_digits()


def _none(conditions: Any) -> str:
    if not conditions.complete:
        return "no family so far; the derivation is not complete"
    if conditions.undivided:
        return "no family apart from the cases below"
    if conditions.verified:
        return "no family"
    return "none derived, and a check says otherwise: see the first line"


def _family(family: Family, robot: Robot) -> Iterator[str]:
    lines, exact = [*condition_lines(family)], exact_of(family)
    shifted = {pin.joint for pin in exact.pins if exact.shifts[pin.joint - 1]}
    if shifted:
        shifted_pins = [pin for pin in family.pinned if pin.number in shifted]
        values = (f"q{pin.number} = {values_in_degrees(robot, pin.number, pin.values)}" for pin in shifted_pins)
        lines.append(f"the joint's own value: {'; '.join(values)}")
    if exact.reality:
        lines += [f"{exact.reality}; here it is"]
    lines.append(f"dimension {family.dimension}, codimension {family.codimension}")
    lines += map(lost_line, family.lost_freedoms)
    yield f"{family.id}  {family.name}"
    for line in (*lines, *_witness(family, robot)):
        yield Formula(f"{_INSET}{line}") if isinstance(line, Formula) else f"{_INSET}{line}"


def _witness(family: Family, robot: Robot) -> list[str]:
    """The witness, where what is lost there is reported."""
    if all(freedom.everywhere for freedom in family.lost_freedoms):
        return []
    return [Formula(f"witness: {witness_text(robot, family.witness)}")]


def condition_lines(family: Family) -> list[str]:
    """The conditions: simple angles together, then one equation after the other; all on one line where they fit."""
    exact = exact_of(family)
    pins = exact.pins
    if pins:
        parts = ["; ".join(pin.text() for pin in pins)]
    else:
        parts = []
    for text, condition in zip(exact.conditions[len(pins) :], exact.polynomials, strict=True):
        on = ", ".join(f"{'θ' if j in condition.ring.revolute else 'q'}{j}" for j in condition.joints)
        whole = f"whole with {advise('latex', python='latex()')}, {advise('json', python='to_dict()')}"
        parts.append(text if len(text) <= _LONGEST else f"a condition on {on}, {len(text):,} characters long ({whole})")
    line = "; ".join(parts)
    return [Formula(part) for part in ([line] if len(line) <= _TOGETHER else parts)]


def _assumptions(conditions: Any) -> Iterator[Section]:
    lines = []
    for assumption in conditions.assumptions:
        if assumption.equal and assumption.families:
            lines += [f"{assumption.text} ({_holds(assumption, conditions)}); {_case(assumption.equal)}:"]
            lines += [f"    {part}" for part in _special_losses(assumption)]
        elif not assumption.holds:
            lines.append(
                f"{assumption.text} ({_holds(assumption, conditions)}); what this arm has besides was not derived"
            )
    others = [assumption.text for assumption in conditions.assumptions if assumption.holds and not assumption.families]
    if others:
        lines += _underived_lines(others, special=conditions.settings.special)
    if lines:
        yield Section("Assumptions on the lengths", "", tuple(lines))


def _underived_lines(texts: Sequence[str], *, special: bool) -> Iterator[str]:
    """Assumptions that hold, the failing of which was not derived: the shortest, and how many more.

    Args:
        texts: of the assumptions.
        special: arms with other lengths were derived.
    """
    if special:
        more = ""
    else:
        more = f" ({advise('special')} derives arms with other lengths)"
    short = sorted((text for text in texts if not _DIGITS.search(text)), key=len)[:_UNDERIVED]
    number = len(texts) - len(short)
    yield f"true here; what happens otherwise was not derived{more}:"
    yield from (Formula(f"    {text}") for text in short)
    if number:
        every = advise("json", python="to_dict()")
        yield f"    and {number} more polynomials in the lengths (all of them: {every})"


def _holds(assumption: Assumption, conditions: Any) -> str:
    if assumption.holds:
        truth = "true here"
    else:
        truth = "NOT true here"
    equal = assumption.equal
    if equal is None or not {equal.length, equal.other} <= set(conditions.letters):
        return truth
    values = (conditions.letters[equal.length], equal.sign * conditions.letters[equal.other])
    return f"{truth}: {_number(values[0])} {'≠' if assumption.holds else '='} {_number(values[1])}"


def special_sentence(assumption: Assumption) -> str:
    """What happens where an assumption fails: "if d3 = d5, θ4 = π alone loses two freedoms"; "" if nothing is known."""
    if assumption.equal is None or not assumption.families:
        return ""
    return f"{_case(assumption.equal)}, {'; '.join(_special_losses(assumption))}"


def _case(equal: EqualLengths) -> str:
    return f"if {equal.length} = {'−' if equal.sign < 0 else ''}{equal.other}"


def _special_losses(assumption: Assumption) -> list[str]:
    """What each family of a special arm takes away, a sentence each."""
    sentences = [_loss(family) for family in assumption.families]
    if assumption.more:
        sentences[-1] += f", and {assumption.more} more families"
    return sentences


def _loss(family: SpecialFamily) -> str:
    lost = _FREEDOMS.get(family.corank, str(family.corank))
    if len(family.conditions) == 1:
        return f"{family.conditions[0]} alone loses {lost}"
    return f"{', '.join(family.conditions)} together lose {lost}"


def reality_words(exact: ExactConditions) -> str:
    """When a family has real points: "real if and only if a2 − a3 ≥ 0"; "" where it has some for all lengths."""
    if not exact.not_negative:
        return ""
    return "real if and only if " + " and ".join(f"{expression} ≥ 0" for expression in exact.not_negative)


def unreal_words(unreal: UnrealSet) -> str:
    """A set without a known real point, and why: "θ4 = 0: no real point was found from 96 random starts"."""
    return f"{unreal.conditions}: {_why_unreal(unreal)}"


def _why_unreal(unreal: UnrealSet) -> str:
    return _UNREAL[unreal.reason].format(tried=unreal.tried, proof=proof_words(unreal))


def proof_words(unreal: UnrealSet) -> str:
    """What excludes real points: "a2 − a3 ≥ 0 does not hold"; "" where that is not proven."""
    if unreal.reason is not Unreal.PROVEN:
        return ""
    if not unreal.negative:
        return "a negative discriminant"
    return f"{unreal.negative} ≥ 0 does not hold"


def _not_real(conditions: Any) -> Iterator[Section]:
    by_reason: dict[str, list[str]] = defaultdict(list)
    for unreal in conditions.not_real:
        where = unreal.conditions
        by_reason[_why_unreal(unreal)].append(where if len(where) <= _LONGEST else f"{where[:_LONGEST]} …")
    lines: list[str] = []
    for reason, sets in by_reason.items():
        lines += [reason, *(Formula(f"    {where}") for where in sets[:_ALIKE])]
        if len(sets) > _ALIKE:
            lines += [f"    and {len(sets) - _ALIKE} more sets like these"]
    if lines:
        yield Section("Not real", "sets of lower rank on which no real configuration is known", tuple(lines))


def _checks(conditions: Any) -> Iterator[Section]:
    lines = [*_tested_lines(conditions)]
    if conditions.method != "tree" and not conditions.disagreements and not conditions.left:
        lines.append(f"{_twice(conditions)} derived twice: rank tree and {_method(conditions)} agree")
    lines += [f"DISAGREEMENT: {contradiction}" for contradiction in conditions.disagreements]
    lines.append(shipped_line() if conditions.anew else f"Time taken: {conditions.seconds:.1f} s.")
    yield Section("Checks", "", tuple(lines))


def _tested_lines(conditions: Any) -> Iterator[str]:
    """At how many random points of the families the rank is as claimed, and what the numeric search says."""
    tested = sum(exact_of(family).rank_check.tested for family in conditions.families)
    agree = sum(exact_of(family).rank_check.agree for family in conditions.families)
    cloud = conditions.explained
    if tested:
        yield f"rank as claimed at {agree:,} of {tested:,} random points of the families, modulo 2^61 − 11913"
    if cloud.tested:
        agreement = f"{cloud.agree:,} of {cloud.tested:,} singular configurations found numerically lie on a family"
        yield agreement + " or in a case that was not taken apart" * bool(conditions.undivided)
    elif conditions.settings.points:
        yield "the numeric search for singular configurations found none"
    else:
        yield "no singular configuration was looked for numerically"


def _unfinished_sections(conditions: Any) -> Iterator[Section]:
    if conditions.left:
        limit = f"the limit is the work of {conditions.settings.seconds:g} s, counted in steps"
        longer = advise("time-limit", "…", python="seconds=…")
        if conditions.limited:
            more = f"; {limit}, and a longer {longer} may finish it"
        else:
            more = ""
        ended = f"the exact derivation ended after {conditions.seconds:.1f} s{more}"
        yield Section("Not finished", ended, tuple(map(str, conditions.left)))


def _number(value: float) -> str:
    return f"{value + 0.0:.12g}".replace("-", "−")


def shipped_line() -> str:
    """What is printed in place of the time that a derivation took."""
    return f"As shipped with rankdrop {VERSION}; {advise('fresh')} derives it anew."


def _all_digits() -> str:
    return f"decimals are shown with six digits; {advise('json', python='to_dict()')} has all of them"


def sections_of(conditions: Any) -> tuple[Section, ...]:
    """The answer and how it was verified, then the conditions."""
    first, second = conditions.verdict.headlines(conditions.answer)
    return (Section(first, lines=(second,)), *condition_sections(conditions))


def code_of(conditions: Any) -> Code:
    """The conditions as code and LaTeX are written from them."""
    arm, minors = conditions.robot, () if conditions.determinants is None else conditions.determinants.minors
    return Code(arm.name, arm.n, conditions.families, conditions.letters, conditions.shifts, minors)
