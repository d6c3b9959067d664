"""Parts of an explanation about motion: how to get out, how far the next singularity is, what motion costs."""

from __future__ import annotations

from collections.abc import Iterator
from math import isinf
from typing import TYPE_CHECKING

import numpy as np

from rankdrop.local.rates import DirectionRates
from rankdrop.local.second_order import proof_of
from rankdrop.local.ways_out import Direction, JointEscape
from rankdrop.results.explanation.parts import turned_task
from rankdrop.results.explanation.words import angle, angle_below, motion, numbers, plural, power, raised, short
from rankdrop.sections import Section
from rankdrop.task import BASE, TIP

if TYPE_CHECKING:
    from rankdrop.results.explanation.explanation import Explanation

_SHOWN = 5  # ways out and families
_SHARE = 0.02  # a joint that moves less than this share of the fastest is left out of a direction
_IDLE = 0.01  # away from a singularity: a joint whose rate is below this share of the best does not help
_BETTER = 1.05  # a motion of several joints is told where it leads so much farther than one alone
_NONE = 1e-12  # a rate below it is rounding


def escape_part(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Joints that lead out, best first; then the best motions of several, and what is known of the end effector."""
    if explanation.rank.corank:
        yield _out(explanation, full)
    elif full or any(abs(one.rate) > _NONE for one in explanation.escape.single):
        yield _away(explanation, full)


def _out(explanation: Explanation, full: bool) -> Section:
    out, r = explanation.escape, explanation.rank.generic_rank
    helpful = [one for one in out.single if one.order is not None]
    rows = tuple(_joint_row(explanation, one) for one in (out.single if full else helpful[:_SHOWN]))
    after = [] if helpful else ["no single joint restores the full rank"]
    if out.best_pair is not None and (full or not helpful):
        after.append(f"best two joints: {_direction(explanation, out.best_pair)}")
    after.append(f"best direction: {_direction(explanation, out.best_direction)}")
    after.append(_sentence(out.avoidable_words))
    for words in dict.fromkeys(one.words for one in out.types):
        which = [i for i, one in enumerate(out.types, start=1) if one.words == words]
        one = words if len(out.types) == 1 else words.replace("the lost direction", _which_of(which, len(out.types)))
        slowly = "it can be passed slowly: " if out.boundary is False and out.types[0].type == 1 else ""
        after.append(_sentence(f"{slowly}{one}"))
    after.append(_sentence(out.boundary_words))
    columns = ("joint", "order", f"σ{r} grows by", "try", f"σ{r} then", "carries out")
    notes = ("order p, rate c: σ grows as c·tᵖ; carries out: the screws that the motion takes out of the dependency",)
    return Section("How to get out", "one joint alone, best first" if rows else "", (), columns, rows, (0, 5),
                   tuple(after), notes if rows and full else ())  # fmt: skip


def answer(explanation: Explanation) -> tuple[str, ...]:
    """The way out in sentences: which joint, which way, how far; what several do, which do not help."""
    out, r = explanation.escape, explanation.rank.generic_rank
    if not r or (explanation.rank.always_singular and not explanation.rank.corank):
        return ()
    singular = explanation.rank.corank > 0
    now = ", zero here, becomes" if singular else f" = {short(explanation.rank.sigma[r - 1])} here becomes"
    lead = "lead out" if singular else "lead farther away"
    best = max((abs(one.rate) for one in out.single), default=0.0)
    helpful = [one for one in out.single if one.order is not None]
    if not singular:
        helpful = [one for one in helpful if abs(one.rate) > max(_IDLE * best, _NONE)]
    usable = [one for one in helpful if one.within_limits and abs(one.step) >= _NONE]
    lines = []
    if usable:
        first = usable[0]
        unit = explanation.robot.variables[first.number - 1].unit
        name = f"joint {first.number}" + (f" ({first.joint})" if first.joint != f"joint{first.number}" else "")
        move = "Move" if singular else "To get farther away move"
        lines.append(f"{move} {name} by {motion(first.step, unit)}: σ{r}{now} {short(first.sigma_after)}.")
    elif helpful:
        lines.append(f"{_joints(helpful)} alone would {lead}, but the joint limits leave no room.")
    else:
        lines.append(f"No single joint {lead.replace('lead', 'leads')}.")
    several = out.best_direction
    if singular and (not usable or several.sigma_after > _BETTER * usable[0].sigma_after):
        more = "Farther out by as small a motion" if usable else "Move together"
        lines.append(f"{more}: {_direction(explanation, several)}.")
    others = [one for one in out.single if one not in helpful]
    if others and helpful and singular:
        lines.append(f"{_joints(others)} alone {'does' if len(others) == 1 else 'do'} not lead out.")
    if singular:
        lines.append(_sentence(out.avoidable_words))
        lines.append(_sentence(out.boundary_words))
    return tuple(lines)


def _joints(ways: list[JointEscape]) -> str:
    which = sorted(one.number for one in ways)
    return f"{plural('Joint', len(which))} {numbers(which)}"


def proofs_part(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Why the sentences on ways out hold, with the formulas."""
    out = explanation.escape
    said = (out.avoidable_words, *(one.words for one in out.types), out.boundary_words)
    lines = tuple(f"{_sentence(words)} {proof_of(words)}" for words in dict.fromkeys(said) if proof_of(words))
    if lines and explanation.rank.corank:
        yield Section("Why", "for the ways out", lines)


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."


def _which_of(which: list[int], count: int) -> str:
    """Which of several lost directions."""
    if len(which) == count:
        return "each lost direction"
    return f"lost {plural('direction', len(which))} {numbers(which)}"


def _away(explanation: Explanation, full: bool) -> Section:
    out, r = explanation.escape, explanation.rank.generic_rank
    best = max((abs(one.rate) for one in out.single), default=0.0)
    helpful = [one for one in out.single if one.order is not None and abs(one.rate) > max(_IDLE * best, _NONE)]
    rows = tuple(
        (f"{one.number} {one.joint}", *_rate_and_step(explanation, one))
        for one in (out.single if full else helpful[:_SHOWN])
    )
    now = f"one joint alone, best first; σ{r} = {short(explanation.rank.sigma[r - 1])} here" if r else ""
    after = (f"best direction: {_direction(explanation, out.best_direction)}",) if r else ()
    return Section("How to get away", now if rows else "", (),
                   ("joint", f"σ{r} changes by", "try", f"σ{r} then"), rows, (0,), after)  # fmt: skip


def _joint_row(explanation: Explanation, joint: JointEscape) -> tuple[str, ...]:
    name = f"{joint.number} {joint.joint}"
    if joint.order is None:
        return (name, "–", f"gains {joint.gain}, not all" if joint.gain else "no gain", "", "", "")
    return (
        name,
        str(joint.order),
        *_rate_and_step(explanation, joint),
        numbers(joint.receptors) if joint.receptors else "–",
    )


def _rate_and_step(explanation: Explanation, joint: JointEscape) -> tuple[str, str, str]:
    if joint.order is None:
        return "0", "", ""
    unit = explanation.robot.variables[joint.number - 1].unit
    per = unit if joint.order == 1 else f"{unit}{raised(joint.order)}"
    rate = f"{short(joint.rate) if abs(joint.rate) > _NONE else '0'} per {per}"
    if not joint.within_limits or abs(joint.step) < _NONE:
        return rate, "not within limits", ""
    return rate, motion(joint.step, unit), short(joint.sigma_after)


def _direction(explanation: Explanation, direction: Direction) -> str:
    """The joints that matter, in words, and what they reach."""
    joints = explanation.robot.variables
    scale = np.where([joint.unit == "m" for joint in joints], explanation.settings.length_scale, 1.0)
    size = np.abs(np.array(direction.delta)) / scale
    large = [number for number in direction.numbers if size[number - 1] >= _SHARE * size.max()]
    parts = [
        f"joint {number} {motion(direction.delta[number - 1] * direction.step, joints[number - 1].unit)}"
        for number in large
    ]
    rest = ", the others far less" if len(large) < sum(size > 1e-9) else ""
    end = f"σ{explanation.rank.generic_rank} = {short(direction.sigma_after)}"
    if not direction.within_limits:
        end += ", outside the joint limits"
    return f"{', '.join(parts)}{rest}: {end}" + ("" if direction.restores else f", gains {direction.gain} only")


def far_part(explanation: Explanation, full: bool) -> Iterator[Section]:
    """The nearest singularity that was found, the radius that is proven free, and the known families."""
    far, lines, rows = explanation.far, [], []
    units = explanation.robot.units
    if far.nearest is not None:
        name = "" if far.nearest_family is None else f" ({far.nearest_family.family.name})"
        limits = "" if far.nearest.within_limits else "; it is outside the joint limits"
        lines.append(
            f"nearest singular configuration found: {angle(far.nearest.distance)} away{name}; {far.nearest.agreeing} "
            f"of {far.nearest.starts} searches agree; σ there at most {power(far.nearest.sigma)}{limits}"
        )
        if not any(one.distance <= far.nearest.distance * (1 + 1e-9) for one in far.families):
            rows.append((f"{angle(far.nearest.distance)}  the nearest", *_deltas(far.nearest.delta, units)))
    radius = explanation.certified_radius
    if explanation.rank.always_singular:
        pass  # every configuration is deficient: nothing to certify
    elif far.certificate is not None and radius is not None:
        lines.append(
            f"certified: no singularity within {angle_below(radius)} (proven; {far.certificate.evaluations:,} "
            f"enclosures{'' if far.certificate.complete else '; interrupted'})"
        )
    elif far.uncertified and not explanation.rank.corank:
        lines.append(f"no certified radius: {far.uncertified}")
    for one in far.families[: None if full else _SHOWN]:
        rows.append((f"{angle(one.distance)}  {one.family.name} (corank {one.family.corank})",
                     *_deltas(one.delta, units)))  # fmt: skip
    if lines or rows:
        columns = (
            ("motion to it, by joint", *(f"{number}" for number in range(1, explanation.robot.n + 1))) if rows else ()
        )
        title = "How far the next one is" if explanation.rank.corank else "How far"
        yield Section(title, "", tuple(lines), columns, tuple(rows))


def _deltas(delta: tuple[float, ...], units: list[str]) -> tuple[str, ...]:
    return tuple(motion(value, unit, 4) for value, unit in zip(delta, units, strict=True))


def rates_part(explanation: Explanation, full: bool) -> Iterator[Section]:
    """Joint rates for unit speed along the axes, the weakest and the lost directions."""
    rates, n = explanation.rates, explanation.robot.n
    losing = any(rates.lost_shares)
    rows: list[tuple[str, ...]] = []
    for axis, share, left in zip(rates.axes, rates.lost_shares, rates.remaining, strict=True):
        lost = (_percent(share),) if losing else ()
        if left is None:
            rows.append((axis.name, *lost, *(["–"] if full else []), "", "0", *([""] * n if full else [])))
        else:
            rows.append((axis.name, *lost, *_costs(left, axis.unit, full, brief=losing)))
    if rates.weakest is not None:
        rows.append((rates.weakest.name, *(("",) if losing else ()), *_costs(rates.weakest, "", full, brief=losing)))
    unlimited = [number for number, limit in enumerate(rates.limits, start=1) if isinf(limit)]
    held = "held back by" if len(unlimited) < n else "fastest"
    columns = ("unit speed", *(("lost",) if losing else ()), *(("joint rates",) if full or not losing else ()), held,
               "at most")  # fmt: skip
    notes = [_limits_in_words(unlimited, explanation)]
    if "joint rates" in columns:
        notes.insert(0, "joint rates: the smallest for 1 m/s or 1 rad/s, as a norm [rad/s]")
    if losing:
        rest = (
            "lost: the share of this motion that cannot be made",
            "the other columns: the nearest motion that can be made, at 1 m/s or 1 rad/s along the axis",
        )
        notes = [*rest, *notes]
    if rates.weakest is not None:
        kept = f"σ{explanation.rank.rank}"
        notes.append(f"weakest direction: that of {kept}, the smallest that is not zero; 1 rad/s, or "
                     f"{short(rates.length_scale)} m/s")  # fmt: skip
    per_joint = tuple(f"{number}" for number in range(1, n + 1)) if full else ()
    texts = (0, columns.index(held), columns.index("at most"))
    yield Section("What motion costs", _axes_of(explanation), (), (*columns, *per_joint), tuple(rows), texts,
                  notes=tuple(notes))  # fmt: skip


def _axes_of(explanation: Explanation) -> str:
    """Along whose axes."""
    axes = turned_task(explanation.task, explanation.settings.frame, explanation.lost).frame.axes
    return {BASE: "base axes", TIP: "tool axes"}.get(axes, f"axes of link {axes}")


def _percent(share: float) -> str:
    """A share in percent: never rounded to all or nothing."""
    if share in (0.0, 1.0):
        return f"{share:.0%}".replace("%", " %")
    return "< 0.1 %" if share < 1e-3 else "> 99.9 %" if share > 0.999 else f"{100 * share:.3g} %"


def _costs(rates: DirectionRates, unit: str, full: bool, *, brief: bool) -> tuple[str, ...]:
    """Joint rates (not where it is `brief`), the joint that holds back, the largest speed [`unit` or mixed]."""
    each = tuple(short(round(rate, 6)) for rate in rates.joint_rates) if full else ()
    most = _largest(rates) if not unit or isinf(rates.speed) else f"{short(rates.speed, 3)} {unit}"
    held = "" if rates.worst is None else f"{rates.worst} {rates.worst_joint}"
    return (held, most) if brief and not full else (short(rates.norm), held, most, *each)


def _limits_in_words(unlimited: list[int], explanation: Explanation) -> str:
    if len(unlimited) == explanation.robot.n:
        return "no velocity limits are known"
    none = f"; {plural('joint', len(unlimited))} {numbers(unlimited)} without one" if unlimited else ""
    return f"at most: the largest speed within the velocity limits{none}"


def _largest(rates: DirectionRates) -> str:
    """The largest speed with its unit; of a direction that mixes both, its two parts."""
    if isinf(rates.speed):
        return "no limit"
    if rates.unit != "1":
        return f"{short(rates.speed, 3)} {rates.unit}"
    parts = [(float(np.linalg.norm(part)) * rates.speed, unit)
             for part, unit in ((rates.direction[:3], "m/s"), (rates.direction[3:], "rad/s"))]  # fmt: skip
    return ", ".join(f"{short(value, 3)} {unit}" for value, unit in parts if value > 1e-9)
