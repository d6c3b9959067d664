"""The failure of single joints in words and as data.

The most fault-tolerant configurations as data (schema rankdrop/tolerant/1) and in words.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees

from rankdrop.families.tolerant import Place, Tolerant
from rankdrop.local.failures import Failures
from rankdrop.results.codec import Record, robot_to_dict
from rankdrop.results.explanation.data import ExplanationData
from rankdrop.results.explanation.words import fixed, numbers, plural, short
from rankdrop.sections import Section
from rankdrop.text.cells import FREE, joint_symbol
from rankdrop.units import heading
from rankdrop.version import VERSION


def failures_part(found: ExplanationData, full: bool) -> Iterator[Section]:
    """What each joint's failure leaves; of arms without a joint to spare only on demand: each costs a freedom."""
    if full or found.robot.n > found.rank.generic_rank:
        yield failures_table(found.failures, "If one joint fails")


def failures_table(found: Failures, title: str) -> Section:
    """One row per joint that stands still."""
    r, n = found.generic_rank, len(found.single)
    rows = tuple(
        (f"{one.number} {one.joint}", short(one.sigma_min), short(round(one.share, 6), 3), f"{one.rank} of {r}",
         "; ".join(one.lost_words) or "nothing")
        for one in found.single
    )  # fmt: skip
    least = found.worst
    after = [f"worst case: σ{r} = {short(least.sigma_min)} without joint {numbers(found.worst_numbers)}"]
    if found.bound is not None and n > r:
        after[0] += f"; at most {short(found.bound)} is possible here"
    return Section(title, "it stands still for good", (),
                   ("joint", f"σ{r} left", "ρ", "rank", "lost then"), rows, (0, 4), tuple(after),
                   ("ρ: the share of Yoshikawa's manipulability that is left",))  # fmt: skip


def failures_to_dict(found: Failures) -> Record:
    """Plain data of every failure at one configuration."""
    return {
        "failure_bound": found.bound,
        "failures": [
            {
                "number": one.number,
                "joint": one.joint,
                "sigma": one.sigma.tolist(),
                "sigma_min": one.sigma_min,
                "rank": one.rank,
                "share": one.share,
                "lost_directions": one.lost.tolist(),
                "lost_words": list(one.lost_words),
            }
            for one in found.single
        ],
    }


SCHEMA = "rankdrop/tolerant/1"


def tolerant_to_dict(found: Tolerant) -> Record:
    """Plain data: see docs/json.md and schema/tolerant.schema.json."""
    return {
        **heading(SCHEMA),
        "robot": robot_to_dict(found.robot, found.task, found.generic_rank),
        "settings": {
            "measure": "relative" if found.relative else "sigma",
            "seed": found.seed,
            "starts": found.starts,
            "limits": found.limits,
            "length_scale": float(found.task.scale(found.robot)),
            "tolerances": found.tolerances.to_dict(),
            "version": VERSION,
        },
        "complete": found.complete,
        "done": found.done,
        "spare": found.spare,
        "bound": found.bound,
        "optimal": found.optimal,
        "free": list(found.free),
        "crucial": list(found.crucial),
        "places": [
            {
                "q": place.q.tolist(), "value": place.value, "slope": place.slope,
                "sigma_min": place.failures.sigma_min, **failures_to_dict(place.failures),
            }
            for place in found.places
        ],
    }


def tolerant_sections(found: Tolerant) -> Iterator[Section]:
    """The places that were found, and what each failure leaves at the best."""
    if not found.places:
        yield Section("No configuration bears every single failure", _why_none(found))
        return
    best = found.places[0]
    kinds = [str(joint.kind) for joint in found.robot.variables]
    symbols = [joint_symbol(number, kind) for number, kind in enumerate(kinds, start=1)]
    r = found.generic_rank
    places = enumerate(found.places, start=1)
    rows = tuple(row for number, place in places for row in _rows(found, number, place, kinds))
    measure = f"σ{r} left / σ1" if found.relative else f"σ{r} left"
    yield Section(
        f"Best worst case: {measure} = {short(best.value, 5)}",
        f"after the failure of any one of {found.robot.n} joints",
        columns=("", measure, "worst without", "", *symbols), rows=rows, texts=(0, 2, 3), after=tuple(_said(found)),
    )  # fmt: skip
    yield failures_table(best.failures, "At the best of them")


def _rows(found: Tolerant, number: int, place: Place, kinds: list[str]) -> Iterator[tuple[str, ...]]:
    """One place in rad, and under it in degrees."""
    def cell(j: int, text: str) -> str:
        return FREE if j + 1 in found.free else text

    unit = "rad, m" if "prismatic" in kinds else "rad"
    plain = (cell(j, fixed(value)) for j, value in enumerate(place.q))
    yield (str(number), short(place.value, 5), numbers(place.failures.worst_numbers), unit, *plain)
    turned = ("" if kind == "prismatic" else cell(j, fixed(degrees(place.q[j]), 2)) for j, kind in enumerate(kinds))
    yield ("", "", "", "deg", *turned)


def _said(found: Tolerant) -> Iterator[str]:
    best = found.places[0]
    bound = best.failures.bound or 0.0
    if found.relative:
        reached = "; the best of them reaches it, none is better" if found.optimal else ""
        yield f"no configuration can have more than {short(found.bound, 5)} by this measure{reached}"
    else:
        yield f"where the best of them stands no worst case can be above {short(bound, 5)}"
        yield f"by --relative, σ{found.generic_rank} left / σ1, none anywhere can be above {short(found.bound, 5)}"
    if found.free:
        yield f"{FREE}: {plural('joint', len(found.free))} {numbers(found.free)} may take any value"
    if not found.optimal:
        yield f"local maxima of {found.done:,} starts, seed {found.seed}; a better one may have been missed"


def _why_none(found: Tolerant) -> str:
    if found.spare <= 0:
        return f"the task needs all {found.robot.n} joints: each failure costs a direction of the tool everywhere"
    if found.crucial:
        which = f"{plural('joint', len(found.crucial))} {numbers(found.crucial)}"
        return f"without {which} the rank is below {found.generic_rank} at every configuration"
    where = "within the joint limits " if found.limits else ""
    return f"of {found.done:,} starts {where}none leads to one; absence of a find is not a proof"
