"""An explanation in words: section by section, most useful first."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import ceil, degrees, inf, isinf, log10

import numpy as np

from rankdrop.atlas.which import Met
from rankdrop.explanation_data import ExplanationData
from rankdrop.local.escape import Direction, JointEscape
from rankdrop.local.screws import Screw
from rankdrop.sections import Section

_SHOWN = 5
_LONG = 160  # characters of an equation that is printed


def sections_of(found: ExplanationData, *, full: bool = False, parts: Sequence[str] = ()) -> tuple[Section, ...]:
    """The parts in the order in which they are asked for.

    Args:
        full: every detail; else what an engineer at a stopped robot needs.
        parts: names out of `PARTS`; none: all of them, those in `DETAILS` only with `full`.
    """
    names = parts or [name for name in PARTS if full or name not in DETAILS]
    return tuple(section for name in names for section in PARTS[name](found, full))


def _verdict(found: ExplanationData, full: bool) -> Iterator[Section]:
    rank, robot = found.rank, found.robot
    r = rank.generic_rank
    sigma = ", ".join(_short(value) if value > rank.sigma_error else "0" for value in rank.sigma)
    lines = [
        f"σ = {sigma}  (each ± {_power(rank.sigma_error)}; zero at or below {rank.tolerance:g}; task "
        f"{found.task.name}, translation divided by {found.settings.length_scale:.4g} m)",
        f"task freedoms lost: {rank.corank} of {r}; {robot.n} joints, {rank.nullity} "
        f"independent joint {_plural('motion', rank.nullity)} without effect on the task",
    ]
    rows = (
        ("rad, m" if any(joint.unit == "m" for joint in robot.variables) else "rad", *map(_fixed, found.q)),
        ("deg", *(_deg(value, unit) for value, unit in zip(found.q, _units(found), strict=True))),
    )
    yield Section(
        f"{robot.name}: {found.verdict.upper()}", found.reason, tuple(lines),
        ("q", *(f"{number} {joint.name}" for number, joint in enumerate(robot.variables, start=1))), rows,
    )  # fmt: skip


def _which(found: ExplanationData, full: bool) -> Iterator[Section]:
    if not found.met and not found.relations:
        return
    where = "" if np.array_equal(found.focus, found.q) else "at the nearest singular configuration"
    own = [met for met in found.met if met.family.corank == found.met[0].family.corank]
    others = [met.family.name for met in found.met if met not in own]
    lines = []
    for met in own:
        lines.append(f"{met.family.name}  (corank {met.family.corank}, dimension {met.family.dimension}; {met.source})")
        lines.append(f"    {_conditions(met)}")
    if others:
        lines.append(f"lies on: {'; '.join(others)}")
    special = [relation.words for relation in found.relations if not relation.structural]
    always = [relation.words for relation in found.relations if relation.structural]
    notes = []
    if special:
        lines.append(f"here: {'; '.join(special)}")
    if always:
        notes.append(f"at every configuration: {'; '.join(always)}")
    title = "Which singularity" if found.met else "Axes"
    yield Section(title, where, tuple(lines), notes=tuple(notes))


def _lost(found: ExplanationData, full: bool) -> Iterator[Section]:
    lost = found.lost
    if lost.framed is not None:
        lines = []
        screws = zip(lost.words, lost.framed.directions, lost.twist_screws, lost.wrench_screws, strict=True)
        for sentence, direction, twist, wrench in screws:
            lines.append(sentence)
            lines.append(f"    twist {_vector(direction)}: {_pitch(twist.pitch)}")
            lines.append(f"    carried without joint torque: {_wrench(wrench)}")
        title = "What is lost" if found.rank.corank else "What is nearly lost"
        yield Section(title, f"axes of {lost.framed.name}; points from its reference point", tuple(lines))
    if len(lost.never):
        rows = tuple(tuple(_fixed(value) for value in row) for row in lost.never)
        yield Section("Never possible", "for this arm and task, at any configuration nearby",
                      columns=("vx", "vy", "vz", "wx", "wy", "wz"), rows=rows, texts=())  # fmt: skip


def _blame(found: ExplanationData, full: bool) -> Iterator[Section]:
    blame = found.blame
    lines = [circuit.words for circuit in blame.smallest]
    lines += [system.words for system in blame.systems if system.permanent or full]
    if blame.always:
        lines.append(f"deficient at every configuration: {blame.always}")
    if lines:
        summary = "smallest dependent sets of joint screws" if blame.smallest else ""
        yield Section("Joints to blame", summary, tuple(lines))
    if full and blame.circuits:
        rows = tuple(
            (_set(one.numbers), "always" if one.generic else "here", _vector(one.coefficients), one.words)
            for one in blame.circuits
        )
        yield Section("Every circuit", "inclusion-minimal dependent sets", columns=("joints", "", "coefficients", ""),
                      rows=rows, texts=(0, 1, 2, 3))  # fmt: skip
    if full and blame.ordered:
        runs = tuple(
            (f"{one.first}–{one.last}", str(one.dimension), str(one.loss), "yes" if one.msos else "no",
             "yes" if one.minimal else "no")
            for one in blame.ordered
        )  # fmt: skip
        yield Section("Singular runs of joints", "Gallardo-Alvarado and Rico-Martínez",
                      columns=("joints", "dimension", "loss", "their test", "minimal"), rows=runs)  # fmt: skip


def _escape(found: ExplanationData, full: bool) -> Iterator[Section]:
    out, r = found.escape, found.rank.generic_rank
    helpful = [one for one in out.single if one.order is not None]
    shown = out.single if full else helpful[:_SHOWN]
    rows = tuple(_joint_row(found, one) for one in shown)
    columns = ("joint", "order", f"σ{r} grows by", "try", f"σ{r} then", "carries out")
    lines = []
    if found.rank.corank and not helpful:
        lines.append("no single joint restores the full rank")
    if found.rank.corank and out.best_pair is not None and (full or not helpful):
        lines.append(f"best two joints: {_direction(found, out.best_pair)}")
    if full or found.rank.corank:
        lines.append(f"best direction: {_direction(found, out.best_direction)}")
    if found.rank.corank:
        lines.append(f"with the end effector still: {out.avoidable_words}")
        for words in dict.fromkeys(one.words for one in out.types):
            which = [str(i) for i, one in enumerate(out.types, start=1) if one.words == words]
            lines.append(f"along lost direction {', '.join(which)}: {words}")
        lines.append(f"workspace: {out.boundary_words}")
    title = "How to get out" if found.rank.corank else "How to get away"
    summary = "one joint alone, best first" if rows else ""
    yield Section(title, summary, tuple(line for line in lines if line), columns, rows, texts=(0, 5))


def _joint_row(found: ExplanationData, one: JointEscape) -> tuple[str, ...]:
    unit = found.robot.variables[one.number - 1].unit
    if one.order is None:
        gained = f"gains {one.gain}, not all" if one.gain else "no gain"
        return (f"{one.number} {one.joint}", "–", gained, "", "", "")
    power = unit if one.order == 1 else f"{unit}{'²³⁴'[one.order - 2]}"
    receptors = _set(one.receptors) if one.receptors else "–"
    step = _motion(one.step, unit) if one.within_limits else "outside the limits"
    rate = f"{_short(one.rate) if abs(one.rate) > 1e-12 else '0'} per {power}"
    return (f"{one.number} {one.joint}", str(one.order), rate, step, _short(one.sigma_after),
            receptors)  # fmt: skip


def _direction(found: ExplanationData, one: Direction) -> str:
    parts = [
        f"joint {number} {_motion(one.delta[number - 1] * one.step, found.robot.variables[number - 1].unit)}"
        for number in one.numbers
        if abs(one.delta[number - 1]) > 1e-3
    ]
    end = f"σ{found.rank.generic_rank} = {_short(one.sigma_after)}"
    return f"{', '.join(parts)}: {end}" + ("" if one.restores else f", gains {one.gain} only")


def _far(found: ExplanationData, full: bool) -> Iterator[Section]:
    far, lines, rows = found.far, [], []
    if far.nearest is not None:
        name = "" if far.nearest_family is None else f" ({far.nearest_family.family.name})"
        lines.append(
            f"nearest singular configuration found: {_angle(far.nearest.distance)} away{name}; {far.nearest.agreeing} "
            f"of {far.nearest.starts} starts agree; σ there at most {_power(far.nearest.sigma)}"
        )
        rows.append(("nearest", *(_signed(d, u) for d, u in zip(far.nearest.delta, _units(found), strict=True))))
    radius = found.certified_radius
    if far.certificate is not None and radius is not None:
        lines.append(
            f"certified: no singularity within {_angle(radius)} (proven; {far.certificate.evaluations:,} enclosures)"
        )
    elif far.uncertified and not found.rank.corank:
        lines.append(f"no certified radius: {far.uncertified}")
    for one in far.families[: None if full else _SHOWN]:
        label = f"{_angle(one.distance)}  {one.family.name} (corank {one.family.corank})"
        rows.append((label, *(_signed(d, u) for d, u in zip(one.delta, _units(found), strict=True))))
    if lines or rows:
        columns = ("motion to it", *(f"{number}" for number in range(1, found.robot.n + 1))) if rows else ()
        title = "How far the next one is" if found.rank.corank else "How far"
        yield Section(title, "", tuple(lines), columns, tuple(rows))


def _rates(found: ExplanationData, full: bool) -> Iterator[Section]:
    rates = found.rates
    chosen = [one for one in (*rates.axes, rates.weakest, *rates.lost) if one is not None]
    rows: list[tuple[str, ...]] = []
    for one in chosen:
        if not one.possible:
            rows.append((one.name, "impossible", "", "0", *([""] * found.robot.n if full else [])))
            continue
        worst = "" if one.worst is None else f"{one.worst} {one.worst_joint}"
        top = "no limits known" if isinf(one.speed) else f"{one.speed:.3g} {one.unit}"
        rates_of = tuple(_short(round(rate, 6)) for rate in one.joint_rates) if full else ()
        rows.append((one.name, f"{one.norm:.4g}", worst, top, *rates_of))
    each = tuple(f"{number}" for number in range(1, found.robot.n + 1)) if full else ()
    columns = ("unit speed", "joint rates", "most of", "at most", *each)
    note = "joint rates: norm of the smallest ones [rad/s] for 1 m/s or 1 rad/s; at most: within the velocity limits"
    yield Section("What motion costs", "", (), columns, tuple(rows), texts=(0, 2, 3), notes=(note,))


def _ellipsoids(found: ExplanationData, full: bool) -> Iterator[Section]:
    shapes = found.ellipsoids
    for group in (shapes.unit_rates, shapes.rate_limits):
        if group is None:
            continue
        parts = [part for part in (group.translation, group.rotation, group.task) if part is not None]
        rows = tuple(
            (part.name, _lengths(part.velocity.half_lengths), _lengths(part.force.half_lengths),
             *(_index(index.value) for index in (part.sigma_min, part.condition, part.manipulability)))
            for part in parts
        )  # fmt: skip
        units = ", ".join(f"{part.name} {part.velocity.unit} and {part.force.unit}" for part in parts)
        yield Section(
            "Ellipsoids", group.ball, (),
            ("", "velocity half-axes", "force half-axes", "σ_min", "condition", "manipulability"), rows,
            texts=(0, 1, 2),
            notes=(f"units: {units}; the task as a whole takes {shapes.length_scale:.4g} m for 1 rad",),
        )  # fmt: skip


def _redundancy(found: ExplanationData, full: bool) -> Iterator[Section]:
    spare = found.redundancy
    lines = [
        f"rank {spare.check.rank} + nullity {spare.check.nullity} = {spare.check.n} joints: "
        + ("holds" if spare.check.holds else "DOES NOT HOLD"),
        f"projector I − J⁺J: ‖PP − P‖ ≤ {_power(spare.idempotent)}, ‖JP‖ ≤ {_power(spare.annihilates)}; "
        f"Jin's I − Jᵀ(JJᵀ)†J differs by at most {_power(spare.difference)}",
    ]
    rows = tuple(tuple(_fixed(value) for value in row) for row in spare.null_basis)
    columns = tuple(f"{number} {joint.name}" for number, joint in enumerate(found.robot.variables, start=1))
    title = "Joint motions that leave the task still"
    yield Section(title, "" if rows else "none", tuple(lines), columns if rows else (), rows, texts=(),
                  notes=("rows: joint rates [rad/s, m/s], to first order",) if rows else ())  # fmt: skip


def _representation(found: ExplanationData, full: bool) -> Iterator[Section]:
    every = found.representations
    rows = tuple(
        (one.name, ", ".join(f"{name} {_short(value)}" for name, value in zip(one.names, one.coordinates, strict=True)),
         _short(one.sigma_min), "none" if isinf(one.angle) else f"{degrees(one.angle):.3g}°",
         "SINGULAR" if one.singular else "near" if one.near else "")
        for one in (every.zyz, every.rpy, every.quaternion, every.rotvec)
    )  # fmt: skip
    yield Section("Coordinates of the orientation", every.words, (),
                  ("", "value [rad]", "σ_min of E", "nearest singularity", ""), rows, texts=(0, 1, 4))  # fmt: skip


def _lengths(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    return " ".join("∞" if isinf(value) else _short(round(float(value), 6)) for value in values)


def _closing(found: ExplanationData, full: bool) -> Iterator[Section]:
    if found.disagreements:
        yield Section("Disagreement", "two methods differ; please report it", found.disagreements)
    elif not full:
        yield Section("", "", notes=("more with --full: circuits, ellipsoids, rates, redundancy, representation",))


def _units(found: ExplanationData) -> list[str]:
    return [joint.unit for joint in found.robot.variables]


def _angle(distance: float) -> str:
    return f"{distance:.4g} rad ({degrees(distance):.3g}°)"


def _motion(value: float, unit: str) -> str:
    text = f"{degrees(value):+.3g}°" if unit == "rad" else f"{value:+.3g} m"
    return text.replace("-", "−")


def _signed(value: float, unit: str) -> str:
    if abs(value) < 1e-9:
        return "0"
    return f"{degrees(value):+.4g}°".replace("-", "−") if unit == "rad" else f"{value:+.4g} m".replace("-", "−")


def _deg(value: float, unit: str) -> str:
    return "" if unit == "m" else f"{degrees(value) + 0.0:.2f}".replace("-", "−")


def _fixed(value: float) -> str:
    return f"{round(float(value), 4) + 0.0:.4f}".replace("-", "−")


def _power(value: float) -> str:
    """The power of ten at or above a rounding error: its digits are noise."""
    return "0" if value == 0 else f"1e{ceil(log10(value))}"


def _short(value: float) -> str:
    return "0" if value == 0 else f"{value:.4g}".replace("-", "−")


def _conditions(met: Met) -> str:
    """What has to hold, one after the other; long equations by their number of terms."""
    family = met.family
    told = [f"{one} = 0" for one in family.equations] or list(getattr(family, "words", ()))
    short = [text if len(text) <= _LONG else f"a condition of {text.count('θ')} angles (--json)" for text in told]
    return "; ".join(short)


def _index(value: float) -> str:
    return "∞" if isinf(value) else _short(value)


def _vector(values: Sequence[float] | np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    return f"({', '.join(_short(round(float(value), 6) + 0.0) for value in values)})"


def _pitch(pitch: float) -> str:
    if isinf(pitch):
        return "pure translation" if pitch == inf else "pure"
    return "pure rotation" if abs(pitch) < 1e-9 else f"screw of pitch {pitch:.3g} m/rad".replace("-", "−")


def _wrench(screw: Screw) -> str:
    """A wrench in words: its pitch is moment per force."""
    along = _vector(screw.direction)
    if isinf(screw.pitch):
        return f"a torque about {along}"
    line = f"a force along {along} through {_vector(screw.point)} m"
    return line if abs(screw.pitch) < 1e-9 else f"{line} with {_short(screw.pitch)} N m about it per N"


def _set(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers))


def _plural(word: str, count: int) -> str:
    return word if count == 1 else f"{word}s"


PARTS: dict[str, Callable[[ExplanationData, bool], Iterator[Section]]] = {
    "verdict": _verdict,
    "which": _which,
    "lost": _lost,
    "blame": _blame,
    "escape": _escape,
    "rates": _rates,
    "far": _far,
    "ellipsoids": _ellipsoids,
    "redundancy": _redundancy,
    "representation": _representation,
    "closing": _closing,
}
"""Every part by its name, in order."""
DETAILS = frozenset({"ellipsoids", "redundancy", "representation"})
"""Parts that are shown only on demand."""
