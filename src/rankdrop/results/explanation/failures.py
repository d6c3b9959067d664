"""The failure of single joints, and the most fault-tolerant configurations, in words."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees

from rankdrop.families.tolerant import Place, Tolerant
from rankdrop.local.failures import Failures
from rankdrop.results.explanation.words import fixed, numbers, plural, short
from rankdrop.sections import Section
from rankdrop.text.families import FREE, joint_symbol


def failures_table(failures: Failures, title: str) -> Section:
    """One row per joint that stands still."""
    r, n = failures.generic_rank, len(failures.single)
    rows = tuple(
        (f"{one.number} {one.joint}", short(one.sigma_min), short(round(one.share, 6), 3), f"{one.rank} of {r}",
         "; ".join(one.lost_words) or "nothing")
        for one in failures.single
    )  # fmt: skip
    least = failures.worst
    after = [f"worst case: σ{r} = {short(least.sigma_min)} without joint {numbers(failures.worst_numbers)}"]
    if failures.bound is not None and n > r:
        after[0] += f"; at most {short(failures.bound)} is possible here"
    return Section(title, "it stands still for good", (),
                   ("joint", f"σ{r} left", "ρ", "rank", "lost then"), rows, (0, 4), tuple(after),
                   ("ρ: the share of Yoshikawa's manipulability that is left",))  # fmt: skip


def tolerant_sections(tolerant: Tolerant) -> Iterator[Section]:
    """The places that were found, and what each failure leaves at the best."""
    if not tolerant.places:
        yield Section("No configuration bears every single failure", _why_none(tolerant))
        return
    best = tolerant.places[0]
    kinds = [str(joint.kind) for joint in tolerant.robot.variables]
    symbols = [joint_symbol(number, kind) for number, kind in enumerate(kinds, start=1)]
    r = tolerant.generic_rank
    places = enumerate(tolerant.places, start=1)
    rows = tuple(row for number, place in places for row in _rows(tolerant, number, place, kinds))
    measure = f"σ{r} left / σ1" if tolerant.relative else f"σ{r} left"
    yield Section(
        f"Best worst case: {measure} = {short(best.value, 5)}",
        f"after the failure of any one of {tolerant.robot.n} joints",
        columns=("", measure, "worst without", "", *symbols), rows=rows, texts=(0, 2, 3), after=tuple(_said(tolerant)),
    )  # fmt: skip
    yield failures_table(best.failures, "At the best of them")


def _rows(tolerant: Tolerant, number: int, place: Place, kinds: list[str]) -> Iterator[tuple[str, ...]]:
    """One place in rad, and under it in degrees."""
    def cell(j: int, text: str) -> str:
        return FREE if j + 1 in tolerant.free else text

    unit = "rad, m" if "prismatic" in kinds else "rad"
    plain = (cell(j, fixed(value)) for j, value in enumerate(place.q))
    yield (str(number), short(place.value, 5), numbers(place.failures.worst_numbers), unit, *plain)
    turned = ("" if kind == "prismatic" else cell(j, fixed(degrees(place.q[j]), 2)) for j, kind in enumerate(kinds))
    yield ("", "", "", "deg", *turned)


def _said(tolerant: Tolerant) -> Iterator[str]:
    best = tolerant.places[0]
    bound, most = short(best.failures.bound or 0.0, 5), short(tolerant.bound, 5)
    if tolerant.relative:
        reached = "; the best of them reaches it, none is better" if tolerant.optimal else ""
        yield f"no configuration can have more than {most} by this measure{reached}"
    else:
        yield f"where the best of them stands no worst case can be above {bound}"
        yield f"by --relative, σ{tolerant.generic_rank} left / σ1, none anywhere can be above {most}"
    if tolerant.free:
        yield f"{FREE}: {plural('joint', len(tolerant.free))} {numbers(tolerant.free)} may take any value"
    if not tolerant.optimal:
        yield f"local maxima of {tolerant.done:,} starts, seed {tolerant.seed}; a better one may have been missed"


def _why_none(tolerant: Tolerant) -> str:
    if tolerant.spare <= 0:
        return f"the task needs all {tolerant.robot.n} joints: each failure costs a direction of the tool everywhere"
    if tolerant.crucial:
        which = f"{plural('joint', len(tolerant.crucial))} {numbers(tolerant.crucial)}"
        return f"without {which} the rank is below {tolerant.generic_rank} at every configuration"
    where = "within the joint limits " if tolerant.limits else ""
    return f"of {tolerant.done:,} starts {where}none leads to one; absence of a find is not a proof"
