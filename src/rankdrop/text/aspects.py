"""Aspects and changes of posture in words: their number, the verdict, solutions of poses, the path."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from rankdrop.exact.remark import chain_remarks
from rankdrop.sections import Section
from rankdrop.text.places import joint_cells, joint_heads
from rankdrop.text.words import listing, plural

POSTURES = {
    "axes 1, 2 meet": "axes 1 and 2 meet",
    "axes 1, 2 parallel": "axes 1 and 2 are parallel",
    "axes 2, 3 parallel": "axes 2 and 3 are parallel",
    "axes 2, 3 meet": "axes 2 and 3 meet",
    "without 2": "the inverse falls apart: one of its two equations does not hold joint 2",
    "without 3": "the inverse falls apart: one of its two equations does not hold joint 3",
    "orthogonal": "orthogonal axes without offsets, or alike: θ2 and θ3 follow from one equation after the other",
    "two slides": "joints 2 and 3 slide",
    "three parallel": "axes 2, 3 and 4 are parallel, 5 and 6 meet; shoulder, elbow and wrist have two solutions each",
    "orientation": "z₁·z₃ leaves two values of θ2",
    "planar": "all axes are parallel, and the elbow has two solutions",
    "structure": "neither proof applies to an arm of this structure",
    "coupled": "neither proof applies where a joint follows another one",
    "slide": "{owner} {has} a slide",
    "repeated": "the singular curve of {owner} has a repeated part",
    "nodes": "the singular curve of {owner} has no cusp but {nodes}, and the theorem is of arms without",
    "point": "the singular curve of {owner} has no cusp but a part that is mapped to one point, and the theorem is of "
    "arms without",
}  # fmt: skip
"""Why a change of posture is impossible, or what stands in the way of the proofs."""

_NOT_COUNTED = {
    "sign": "a factor of det J changes its sign over a full turn of a joint",
    "joints": "more than three joints are left when all others are peeled off",
    "slide": "a slide is left when all other joints are peeled off",
    "factors": "det J has too many factors",
    "work": "the limit on work was reached",
    "conditions": "exact conditions of this arm are not derived",
}

_NOT_WITHIN = _NOT_COUNTED | {
    "joints": "conditions that share joints depend on {joints}, and cells are made of three at most. Without limits, a "
    "joint that stands in one of them only, as A + B cos θ + C sin θ, could be left out",
    "slide": "a slide stands in two conditions, in a higher degree than the first, or has one limit. With two limits, "
    "and in one condition as A + B q, it could be left out",
}

_CHANGE = {
    "cuspidal": "it can change its posture without a singularity (proven)",
    "not cuspidal": "it cannot change its posture without a singularity (proven)",
    "none found": "no change of posture without a singularity was found, which proves nothing",
}

_VERDICT_CELLS = {"cuspidal": "cuspidal", "none found": "undecided"}

_WITHIN_HOW = (
    "a joint with limits is a line, not a circle: θ and θ + 360° are two places; limits may cut an "
    "aspect into several regions, or leave all of it out"
)
_WITHIN = {True: "within the joint limits", False: "joint limits ignored"}


def decision_text(decision: Any) -> str:
    """What is decided about changes of posture without a search, in one sentence."""
    if decision.wrist:
        owner, has = ("the first three joints", "have")
    else:
        owner, has = ("the arm", "has")
    nodes, cusps = (f"{len(some)} {plural(word, len(some))}" for some, word in (
        (decision.nodes or (), "node"), (decision.cusps, "cusp")))  # fmt: skip
    wrist = "; the wrist, by the sign of its middle joint" * decision.wrist
    texts = {
        "signs": f"each solution has signs of its own: {POSTURES.get(decision.why)}{wrist}",
        "cusps": f"three solutions of {owner} meet at {cusps}",
        "no cusp": f"no three solutions of {owner} meet anywhere, and the singular curve has no nodes",
    }
    if decision.kind in texts or decision.why not in POSTURES:
        return texts.get(decision.kind, str(decision.why))
    return POSTURES[decision.why].format(owner=owner, has=has, nodes=nodes)


def aspects_number(postures: Any) -> str:
    """How many aspects the arm has, in one sentence."""
    name, count = postures.robot.name, postures.count
    if count.left is not None:
        return f"The aspects of {name} were not counted: {_NOT_COUNTED[count.left.value]}."
    least, most = count.at_least, count.at_most
    if not count.exact:
        seen = f"; cells show {most}, and parts smaller than a cell may be missed"
        if count.proven:
            upper = f"; at most {most} (proven)"
        else:
            upper = seen
        return f"{name} has at least {least} {plural('aspect', least)} (proven){upper}."
    each = {sign.parts.at_least for sign in count.each}
    signs = _signs_of_what(count, square=postures.robot.n == postures.task.m)
    if each == {1} and signs:
        how = f": one for each sign of {signs}"
    else:
        how = ""
    return f"{name} has {least} {plural('aspect', least)} (proven){how}."


def region_words(count: Any, factors: Sequence[int], region: Any) -> str:
    """A region of a picture: the signs of its factors, and how many regions have them: "elbow +, wrist −: 2 regions".

    Args:
        count: of the aspects.
        factors: indices of the factors of the region.
        region: from `rankdrop.aspects.picture`.
    """
    signs = ", ".join(
        f"{factor_words(count, i)} {'+' if sign > 0 else '−'}" for i, sign in zip(factors, region.signs, strict=True)
    )
    if region.number:
        return f"{signs}, region {region.number}"
    if not region.parts:
        return signs
    least = "" if count.exact else "at least "
    return f"{signs}: {least}{region.parts} {plural('region', region.parts)}"


def factor_words(count: Any, index: int) -> str:
    """A factor by the part of the arm: "elbow"; "det J" where it is the only one, else "factor 2"."""
    if count.roles[index]:
        return str(count.roles[index])
    if len(count.factors) == 1:
        return "det J"
    return f"factor {index + 1}"


def within_limits_sentence(count: Any) -> str:
    """How many regular regions are left within the joint limits, in one sentence; "" where that was not asked for."""
    if count is None:
        return ""
    if count.left is not None:
        why = _NOT_WITHIN[count.left.value].format(joints=_joint_numbers(count.shared))
        return f"Within the joint limits nothing was counted: {why}."
    least, most = count.at_least, count.at_most
    if count.exact:
        return f"Within the joint limits: {least} {plural('region', least)} (proven)."
    if count.proven:
        return f"Within the joint limits: {least} to {most} regions (proven)."
    return f"Within the joint limits: at least {least} {plural('region', least)} (proven); cells show {most}."


def aspects_line(summary: Any) -> str:
    """How many aspects an arm has and whether it can change its posture, in one sentence; "" where nothing is known.

    Example:
        >>> from rankdrop.results.aspect_summary import NOT_CUSPIDAL, AspectSummary
        >>> aspects_line(AspectSummary(8, 8, True, NOT_CUSPIDAL))
        'The arm has 8 aspects (proven): it cannot change its posture without a singularity (proven).'
    """
    if summary is None:
        return ""
    change = _CHANGE.get(summary.posture_change or "", "")
    if summary.at_least is None:
        if change:
            return f"The aspects of the arm were not counted: {change}."
        return "The aspects of the arm were not counted: rankdrop aspects says why."
    number = f"{summary.at_least} {plural('aspect', summary.at_least)} (proven)"
    if summary.number is None:
        number = f"at least {number}"
    if summary.number is None and summary.proven:
        number = f"{number} and at most {summary.at_most} (proven)"
    if change:
        return f"The arm has {number}: {change}."
    return f"The arm has {number}."


def aspects_cell(summary: Any) -> str:
    """The number of aspects in a cell: "8", "2 … 8" between proven bounds, "≥ 2" with a lower bound, or "–"."""
    if summary is None or summary.at_least is None:
        return "–"
    if summary.number is not None:
        return str(summary.number)
    if summary.proven:
        return f"{summary.at_least} … {summary.at_most}"
    return f"≥ {summary.at_least}"


def aspects_and_verdict_cell(summary: Any) -> str:
    """The number of aspects, with the verdict where the arm is cuspidal or that is not decided.

    Example:
        >>> from rankdrop.results.aspect_summary import CUSPIDAL, NOT_CUSPIDAL, AspectSummary
        >>> [aspects_and_verdict_cell(AspectSummary(2, 2, True, change)) for change in (NOT_CUSPIDAL, CUSPIDAL)]
        ['2', '2, cuspidal']
    """
    number = aspects_cell(summary)
    verdict = _VERDICT_CELLS.get(summary.posture_change or "")
    if verdict is None:
        return number
    return f"{number}, {verdict}"


def _signs_of_what(count: Any, *, square: bool) -> str:
    """ "shoulder, elbow and wrist"; "det J" where there is one factor without such a name; "" where nothing is."""
    if not count.factors:
        return ""
    if all(count.roles) and len(set(count.roles)) == len(count.roles):
        order = ["shoulder", "elbow", "wrist"]
        return listing(sorted(count.roles, key=lambda role: order.index(role) if role in order else len(order)))
    if not square:
        return listing(count.factors)
    if len(count.factors) == 1:
        return "det J"
    return f"the {len(count.factors)} factors of det J"


def aspects_sentence(postures: Any) -> str:
    """The verdict on changes of posture, and what it rests on."""
    if postures.robot.n != postures.task.m:
        return "Postures are compared for arms with as many joints as rows only."
    if postures.change is not None:
        corners, spent = len(postures.change.q), postures.change.evaluations
        return (f"It can change its posture without a singularity (cuspidal): a path of {corners} corners from one "
                f"solution of a pose to another is proven free ({spent:,} enclosures).")  # fmt: skip
    if postures.shared is not None:
        solutions, aspects = len(postures.shared.q), postures.count.at_least
        return (
            f"It can change its posture without a singularity (cuspidal): proven. One pose has {solutions} solutions, "
            f"and two of them have the same signs of all factors: they lie in one of the {aspects} aspects."
        )
    if postures.decision.impossible:
        words = decision_text(postures.decision)
        words = f"{words[:1].upper()}{words[1:]}"
        return f"It cannot change its posture without a singularity (not cuspidal): proven. {words}."
    count = len(postures.solved)
    poses = f"{count} {plural('pose', count)}{f' {_WITHIN[True]}' if postures.options.limits else ''}"
    return f"No change of posture without a singularity was found in {poses}; that is no proof of absence."


def no_certificate(postures: Any) -> str:
    """Why no certificate is written of an arm without a path and without a proof that the checker knows."""
    if postures.robot.n != postures.task.m:
        return "postures are compared for arms with as many joints as rows only"
    if postures.shared is not None:
        return "that it is cuspidal rests on the number of aspects, which no certificate states; try other poses"
    if postures.decision.impossible:
        return f"the checker does not know this proof that it is not cuspidal: {decision_text(postures.decision)}"
    return "there is no path, and nothing is proven"


def aspects_sections(postures: Any, *, deg: bool) -> Iterator[Section]:
    """Changes of posture: the number of aspects and the verdict first."""
    sentences = (aspects_number(postures), within_limits_sentence(postures.within), postures.sentence)
    yield Section(" ".join(filter(None, sentences)))
    counting = _counting_line(postures.count)
    lines = [counting] if counting else []
    if postures.within is not None and postures.within.left is None:
        lines.append(f"within the joint limits: {'; '.join((*_peeled_and_cells(postures.within), _WITHIN_HOW))}")
    if postures.robot.n != postures.task.m:
        yield Section(f"{postures.robot.name}, {postures.task.name}", lines=tuple(lines))
        return
    if not postures.decision.impossible:
        lines.append(f"without a search: {decision_text(postures.decision)}")
    lines.append(f"solutions of the inverse: Newton's method from {postures.options.starts:,} starts for each pose, "
                 f"seed {postures.options.seed}, {_WITHIN[postures.options.limits]}; more may exist")  # fmt: skip
    yield Section(f"{postures.robot.name}, {postures.task.name}", lines=tuple(lines))
    if len(postures.solved) == 1:
        yield _solutions(postures, deg=deg)
    elif postures.solved:
        times = Counter((len(solved.q), solved.per_aspect) for solved in postures.solved if not solved.near_cusp)
        rows = tuple(
            (str(count), " + ".join(map(str, sizes)), str(poses))
            for (count, sizes), poses in sorted(times.items(), key=lambda item: (-item[1], item[0]))
        )
        yield Section("Solutions by aspect", columns=("solutions", "in the aspects", "poses"), rows=rows, texts=(1,),
                      notes=(_meaning_of_numbers(postures),))  # fmt: skip
    if postures.change is not None:
        if postures.change.own:
            lines = []
        else:
            lines = ["not from the configuration first named, but between two other solutions"]
        yield Section(
            "A change of posture without a singularity", lines=tuple(lines),
            columns=("", *joint_heads(postures.robot, deg=deg)),
            rows=tuple(
                (str(k), *joint_cells(postures.robot, q, deg=deg)) for k, q in enumerate(postures.change.q, start=1)
            ),
            notes=(f"straight lines between; smallest |det J| of its sample points {postures.change.clearance:.3g}, "
                   "lengths by the length scale",),
        )  # fmt: skip
    notes = rounding_notes(postures)
    if notes:
        yield Section("Notes", lines=notes)


def rounding_notes(postures: Any) -> tuple[str, ...]:
    """What was rounded to make the arm exact; () where it is not."""
    if postures.chain is None:
        return ()
    return tuple(map(str, chain_remarks(postures.chain)))


def _counting_line(count: Any) -> str:
    """How the aspects were counted."""
    if count.left is not None:
        return ""
    how = _peeled_and_cells(count)
    number = len(count.factors)
    factors = f"{number} {plural('condition', number)} with signs that separate regular configurations"
    if not number:
        factors = "no condition stands alone, and sets of codimension 2 separate nothing"
    return "; ".join((f"aspects: {factors}", *how, "joint limits ignored"))


def _peeled_and_cells(count: Any) -> list[str]:
    """Which joints were peeled off, and which ones cells were made of."""
    how = []
    if count.peeled:
        how.append(f"{_joint_numbers(count.peeled)} peeled off")
    if count.cells:
        how.append(f"cells in {_joint_numbers(count.cells)}")
    return how


def _joint_numbers(joints: Sequence[int]) -> str:
    return f"{plural('joint', len(joints))} {listing(map(str, joints))}"


def _solutions(postures: Any, *, deg: bool) -> Section:
    solved = postures.solved[0]
    rows = tuple(
        (f"{solved.aspect[i]}{' ←' if i == 0 else ''}", solved.names[i],
         *joint_cells(postures.robot, solved.q[i], deg=deg))
        for i in sorted(range(len(solved.q)), key=lambda i: (solved.aspect[i], i))
    )  # fmt: skip
    return Section(
        f"{len(solved.q)} solutions in {len(solved.per_aspect)} aspects", rows=rows, texts=(0, 1),
        columns=("aspect", "sign", *joint_heads(postures.robot, deg=deg)),
        notes=("← the configuration that gave the pose", _meaning_of_numbers(postures)),
    )  # fmt: skip


def _meaning_of_numbers(postures: Any) -> str:
    if postures.decision.impossible:
        return "every solution lies in an aspect of its own: proven"
    if postures.count.signs_decide:
        return "solutions lie in one aspect where all factors of det J have equal signs: proven"
    joined = "solutions of one aspect are joined by paths proven free"
    if all(len(set(solved.sign)) == len(set(solved.aspect)) for solved in postures.solved):
        return f"{joined}; aspects of different signs of det J are parted by a singularity"
    return f"{joined}; of aspects with the same sign no path was found, which does not prove them two"
