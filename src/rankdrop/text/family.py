"""One family in words, for a notebook, and how its conditions were obtained."""

from __future__ import annotations

from math import degrees

from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.record import Family
from rankdrop.sections import Section
from rankdrop.text.lost import lost_sentences

_EVIDENCE = {
    ObtainedFrom.EXACT: "exact condition",
    ObtainedFrom.VALUES: "values verified",
    ObtainedFrom.FITTED: "fitted, then verified",
    ObtainedFrom.SHARED_VALUES: "shared values, verified",
    ObtainedFrom.CLOUD: "{cloud} points of the cloud and {fresh} fresh ones, no condition found{bound}",
    ObtainedFrom.NEIGHBOURS: "{neighbours} singular configurations around q with one tangent shape",
    ObtainedFrom.FULL_RANK: "D has full rank",
    ObtainedFrom.UNCLEAR_RANK: "D has no clear rank here; the dimension is an upper bound",
    ObtainedFrom.STORED: "{text}",
}
"""What conditions were obtained from."""


def evidence_words(evidence: FamilyEvidence) -> str:
    """How the conditions of a family were obtained.

    Example:
        >>> evidence_words(FamilyEvidence(ObtainedFrom.CLOUD, cloud=12, fresh=3, clear_rank=True))
        '12 points of the cloud and 3 fresh ones, no condition found'
    """
    if evidence.kind is ObtainedFrom.MEETING:
        return "; ".join(map(str, evidence.parts))
    bound = ""
    if not evidence.clear_rank:
        bound = "; D has no clear rank there, so that the dimension is an upper bound"
    return _EVIDENCE[evidence.kind].format(
        cloud=evidence.cloud, fresh=evidence.fresh, neighbours=evidence.neighbours, bound=bound, text=evidence.text
    )


def sections_of(family: Family) -> tuple[Section, ...]:
    """For notebooks: what the family asks of each joint, what is lost, how it was tested."""
    slides = _slides(family)
    stands = {pin.number: (f"joint {pin.number}, {pin.joint}",
                           " or ".join(_format_value(value, pin.number in slides) for value in pin.values))
              for pin in family.pinned}  # fmt: skip
    stands |= {number: (f"joint {number}", "any value") for number in family.free}
    stands |= {number: (f"joint {number}", "coupled, see below") for number in family.coupled}
    bound = set(family.coupled)
    told = [f"{equation.pretty()} = 0" for equation in family.equations if bound & set(equation.joints)]
    told += [f"lost: {words}" for words in lost_sentences(family.lost_freedoms)]
    at = ", ".join(f"{value:.6g}" for value in family.witness)
    tested = (
        f"{family.soundness.agree:,} of {family.soundness.tested:,} points solved from its conditions are singular; "
        f"it explains {family.explained.agree:,} of {family.explained.tested:,} test points"
    )
    section = Section(
        f"{family.id} {family.name}", f"corank {family.corank}, dimension {family.dimension}",
        columns=("joint", "stands at"), rows=tuple(row for _, row in sorted(stands.items())), texts=(0, 1),
        after=(*told, f"witness, as functions take it [rad, m]: q = [{at}]"),
        notes=(tested,) if family.soundness.tested else (),
    )  # fmt: skip
    return (section,)


def _slides(family: Family) -> set[int]:
    """Numbers of joints that slide, as far as is known: in equations they stand as powers."""
    slides = set(family.slides)
    for equation in family.equations:
        for term in equation.terms:
            slides |= {number for number, power in enumerate(term.powers, start=1) if power}
    return slides


def _format_value(value: float, slides: bool) -> str:
    return (f"{value:.6g} m" if slides else f"{degrees(value):.5g}°").replace("-", "−")
