"""Numbers, motions and screws of an explanation as text: few digits, with units, no noise.

The failure of single joints and the most fault-tolerant configurations in words.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from math import ceil, degrees, floor, inf, isinf, log10, pi, radians
from typing import TYPE_CHECKING

import numpy as np

from rankdrop.options import advise
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.quantities import count, degrees_text
from rankdrop.sections import Section
from rankdrop.text.families import FREE
from rankdrop.text.joint_values import fixed_point, joint_symbol

if TYPE_CHECKING:
    from rankdrop.distance.tolerant import LockedJoint, SelfMotions, Tolerant, TolerantPlace
    from rankdrop.local.failures import Failures
    from rankdrop.local.screws import Screw
    from rankdrop.local.ways_out import Escape

_ZERO = 1e-9  # a motion below it is not shown as one [rad, m]
MOST_TURNS = 4 * pi
"""Joint values beyond it look like degrees [rad]."""
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_NUMBER = re.compile(r"\d+$")
_EXPONENT = re.compile(r"e([+-])0*(\d+)$")

_LONGEST_WHOLE = 1e6  # from here on numbers have exponents

MORE_NEAREST = "the motion to each family, σ and the joint values: {}"
MOTION_TO_IT = "motion to it: {}"
NEVER_TURNS = "With {} joints this arm can never turn about its tool axis (Z of the tip) on its own"
"""What an arm of five joints cannot do."""
CHECKED_POINTING = "It is checked for position and tool axis (task tool-axis-free)"
"""The task that such an arm is checked for."""
NEVER_TILTS = "This arm never tilts its tool. It is checked for position and yaw (task scara)"
"""The limit of an arm of four joints with a level tool, and the task that it is checked for."""
PLACES_ALONE = "With {0} joints this arm places its tool and cannot choose how it is turned. It is checked for position"
"""The limit of an arm of two or three joints, and the task that it is checked for."""
POINTING_HERE = "For position and tool axis ({task}) it is {verdict} here, rank {rank} of {r}"
"""What the pose alone leaves out."""
NEVER_HERE = "Never possible here: {motions}; the arm has rank {r} of the {m} rows of this task at best"
"""What an arm with fewer freedoms than rows cannot do."""
NO_JOG = "no jog of one or two joints inside the limits was found"

NOT_SEARCHED = "Next: not searched."

_NEARBY = "q is only near a singularity; if it were one"
_STILL = {
    "always moves": "every joint motion moves the tool",
    "definite": "you cannot leave it with the tool held still",
    "rows": "ways out with the tool held still are not looked for with these rows in this frame",
    "no tangent": "no way out with the tool held still was found; that is no proof that there is none",
    "regular": "there is no singularity to leave",
    "stayed": "no way to leave it with the tool held still was found: every such motion that was traced stays singular "
    "(no proof)",
    "stayed so far": "motions with the tool held still that were traced stay singular; there may be others",
    "too small": "not known whether it can be left with the tool held still: σ_r is too small there",
    "untraced": "no motion with the tool held still could be traced; that is no proof that there is none",
}
_EDGE = {
    "open": "no direction of the tool is lost",
    "never whole": "whether the tool is at an edge of its reach is not decided where the arm never makes the whole "
    "task",
    "several": "whether the tool is at an edge of its reach is not decided where several directions are lost",
    "both signs": "the tool is not at an edge of its reach: it can go on to both sides",
    "one sign": "the tool is at an edge of its reach: it can go back, not on",
    "flat": "whether the tool is at an edge of its reach is not decided here",
}
_LOST_TYPE = {
    1: "the tool moves along {which} only like the square of the joint motion",
    2: "the tool moves along {which} only after a motion of the joints that leaves it still",
}

PROOF: dict[str | int, str] = {
    "definite": "u · dJ(Δ)Δ is definite over the null motions Δ for a lost direction u: each of them moves the end "
    "effector",
    "several": "the test at second order is for one lost direction of a task that the arm can make in full",
    "both signs": "u · dJ(Δ)Δ takes both signs over the null motions Δ, u the lost direction (near q only)",
    "one sign": "u · dJ(Δ)Δ has one sign over the null motions Δ, u the lost direction (near q only)",
    "flat": "u · dJ(Δ)Δ = 0 for every null motion Δ, u the lost direction",
    1: "u · dJ(Δ)Δ ≠ 0 for some null motion Δ, u the lost direction",
    2: "u · dJ(Δ)Δ = 0 for every null motion Δ, u the lost direction",
}
"""Why a sentence on ways out holds, with the formula: by its reason, or by the type of a lost motion."""

NO_TOLERANT = "No configuration of {} was found that tolerates"


def short(value: float, digits: int = 4) -> str:
    """A number with few digits: "0.1134", "2.6e−6", "180" for 178 with two of them, "∞".

    Example:
        >>> short(0.11340174), short(-2.5702e-6), short(0.0), short(178.2, 2)
        ('0.1134', '−2.57e−6', '0', '180')
    """
    if isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    rounded = f"{value:.{digits}g}"
    if "e+" in rounded and abs(value) < _LONGEST_WHOLE:
        rounded = f"{float(rounded):.0f}"
    return minus(_EXPONENT.sub(_exponent, rounded))


def rounded_down(value: float, digits: int = 2) -> str:
    """A number with few digits that is never above it: a speed that keeps a limit keeps it as it is printed.

    Example:
        >>> rounded_down(0.9999955), rounded_down(2.39e-6), rounded_down(102.6, 3), rounded_down(0.0)
        ('0.99', '2.3e−6', '102', '0')
    """
    return _rounded_by(floor, value, digits)


def rounded_up(value: float, digits: int = 2) -> str:
    """A number with few digits that is never below it: a bound that holds as it is printed.

    Example:
        >>> from math import nan
        >>> rounded_up(0.0101), rounded_up(99.1), rounded_up(1.2340001, 4), rounded_up(inf), rounded_up(nan)
        ('0.011', '100', '1.235', '∞', 'nan')
    """
    return _rounded_by(ceil, value, digits)


def _rounded_by(whole: Callable[[float], int], value: float, digits: int) -> str:
    if not 0.0 < value < inf:
        return short(value, digits)
    unit = 10.0 ** (floor(log10(value)) - digits + 1)
    rounded = whole(value / unit) * unit
    if 1.0 <= rounded < _LONGEST_WHOLE:
        return short(rounded, max(digits, len(str(round(rounded)))))
    return short(rounded, digits)


WITHOUT_BOUND = 10_000
"""Times a limit: a rate beyond it is that of a singularity, and depends on the rows next to it alone."""


def above_limit(times: float) -> str:
    """What takes so many times its limit, before "limit": "822 times the", "0.00045 % above the".

    Example:
        >>> above_limit(822.04), above_limit(1.0000045), above_limit(1e8)
        ('822 times the', '0.00045 % above the', 'more than 10,000 times the')
    """
    if times < 1.01:
        return f"{short(100.0 * (times - 1.0), 2)} % above the"
    if times > WITHOUT_BOUND:
        return f"more than {WITHOUT_BOUND:,} times the"
    return f"{short(times, 3)} times the"


def _exponent(match: re.Match[str]) -> str:
    return f"e{'-' if match[1] == '-' else ''}{match[2]}"


def degrees_hint(q: Array, robot: Robot) -> str | None:
    """A line of warning where angles look like degrees that were taken as radians; None where they do not.

    Args:
        q: (..., n) [rad, m].
        robot: whose joints they are.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> degrees_hint(np.array([0.0, 90.0]), open_robot("planar2r"))
        'angles up to 90 look like degrees and are read as radians'
    """
    angles = np.abs(q[..., [joint.unit == "rad" for joint in robot.variables]])
    most = float(angles.max(initial=0.0))
    if most > MOST_TURNS:
        return f"angles up to {most:.4g} look like degrees and are read as radians"
    return None


def minus(text: str) -> str:
    """The sign − of the printed page for the hyphen of the machine."""
    return text.replace("-", "−")


def power(value: float) -> str:
    """The power of ten at or above a rounding error: its digits are noise."""
    if value == 0:
        return "0"
    return minus(f"1e{ceil(log10(value))}")


def superscript(exponent: int) -> str:
    """An exponent: "²", "¹²"."""
    return str(exponent).translate(_RAISED)


def angle(distance: float) -> str:
    """A distance in joint space in both units: "0.4303 rad (24.7°)"."""
    return f"{short(distance)} rad ({short(degrees(distance), 3)}°)"


def angle_below(distance: float) -> str:
    """A proven distance, rounded down: what is printed is proven as well."""
    return f"{short(below(distance, 4))} rad ({short(below(degrees(distance), 3), 3)}°)"


def below(value: float, digits: int) -> float:
    """A number rounded down to so many digits: what is printed is proven as well."""
    if value <= 0.0:
        return 0.0
    unit = 10.0 ** (floor(log10(value)) + 1 - digits)
    return floor(value / unit) * unit


def motion(value: float, unit: str, digits: int = 3) -> str:
    """A joint motion with its sign: "+5.73°", "−0.02 m"; "0" where there is none."""
    if abs(value) < _ZERO:
        return "0"
    text = short(degrees(value) if unit == "rad" else value, digits)
    return f"{'' if value < 0 else '+'}{text}{'°' if unit == 'rad' else ' m'}"


def jog_step(step: float, unit: str) -> str:
    """A jog to 0.1° or to 0.1 mm: "+12°", "−5.7°", "+0.05 m"."""
    return motion(radians(round(degrees(step), 1)) if unit == "rad" else round(step, 4), unit)


def after_jog(rank: int, *, regular: bool, deficient: bool) -> str:
    """What the configuration is after a jog; `deficient`: the arm is singular at every configuration."""
    if not regular:
        return f": rank {rank} then, but still near a singularity; no jog found that ends regular"
    if deficient:
        return f"; rank {rank} from there, the most of this arm"
    return "; regular from there"


def vector(values: Iterable[float]) -> str:
    """Numbers in brackets, rounded to a millionth."""
    return f"({', '.join(short(round(float(value), 6) + 0.0) for value in values)})"


def pitch_text(pitch: float) -> str:
    """What kind of motion a twist of this pitch is."""
    if isinf(pitch):
        if pitch == inf:
            return "pure translation"
        return "pure"
    if abs(pitch) < _ZERO:
        return "pure rotation"
    return f"screw of pitch {short(pitch, 3)} m/rad"


def wrench_text(screw: Screw) -> str:
    """A wrench in words: its pitch is moment per force."""
    along = vector(screw.direction)
    if isinf(screw.pitch):
        return f"a torque about {along}"
    line = f"a force along {along} through {vector(screw.point)} m"
    if abs(screw.pitch) < _ZERO:
        return line
    return f"{line} with {short(screw.pitch)} N m about it per N"


def sweep_next() -> str:
    """Last line of what a sweep begins with."""
    every, maps = advise("all", python="sections(every=True)"), advise("html", "FILE", python="report.design_page")
    return f"Next: {every} lists every variant, {maps} draws maps of the measures."


def numbers(members: Sequence[int]) -> str:
    """Joint numbers: "1, 3, 5"."""
    return ", ".join(map(str, members))


def joint_word(number: int, name: str) -> str:
    """A joint in a sentence: "joint 4"; by its name where that has another number.

    Example:
        >>> joint_word(4, "a4"), joint_word(4, "elbow"), joint_word(4, "a3"), joint_word(4, "joint_3")
        ('joint 4', 'joint 4', 'joint a3', 'joint_3')
    """
    digits = _NUMBER.search(name)
    if digits is None or int(digits[0]) == number:
        return f"joint {number}"
    if "joint" in name.lower():
        return name
    return f"joint {name}"


def listing(words: Iterable[str]) -> str:
    """ "shoulder, elbow and wrist"."""
    listed = list(words)
    head = ", ".join(listed[:-1])
    if head:
        return f"{head} and {listed[-1]}"
    return "".join(listed)


def plural(word: str, count: int) -> str:
    """ "motion" or "motions"."""
    return word if count == 1 else f"{word}s"


def lost_count(count: int) -> str:
    """How many directions are lost, where a line has no room for them."""
    return f"{count} {plural('direction', count)} of the tool, see below"


def lost_type(kind: int, which: str = "the lost direction") -> str:
    """What the type of a lost motion means.

    Args:
        kind: 1 or 2, see `rankdrop.local.ways_out.LostMotion`.
        which: directions: "each lost direction", "lost directions 1 and 3".
    """
    return _LOST_TYPE[kind].format(which=which)


def avoidable_words(out: Escape) -> str:
    """Whether the singularity can be left with the tool held still."""
    words = _STILL.get(out.avoidable_reason, "")
    if out.still is not None:
        if out.corank:
            can = "you can leave it"
        else:
            can = "the joints can move"
        if out.still.within_limits:
            outside = ""
        else:
            outside = "; outside the joint limits"
        words = (
            f"{can} with the tool held still: σ_r = {out.still.sigma_after:.3g} after {out.still.step:.3g} rad, "
            f"the tool where it was to {max(1e-12, out.still_error):.0e}{outside}"
        )
    if out.nearby:
        return f"{_NEARBY}: {words}"
    return words


def boundary_words(out: Escape) -> str:
    """Whether the tool is at an edge of its reach."""
    words = _EDGE[out.boundary_reason]
    if out.nearby:
        return f"{_NEARBY}: {words}"
    return words


def failures_table(failures: Failures, title: str) -> Section:
    """One row per joint that stands still."""
    r, n = failures.generic_rank, len(failures.single)
    rows = tuple(
        (f"{failure.number} {failure.joint}", short(failure.sigma_min), short(round(failure.share, 6), 3),
         f"{failure.rank} of {r}", "; ".join(failure.lost_words) or "nothing")
        for failure in failures.single
    )  # fmt: skip
    least = failures.worst
    after = [f"worst case: σ{r} = {short(least.sigma_min)} without joint {numbers(failures.worst_numbers)}"]
    if failures.bound is not None and n > r:
        after[0] += f"; at most {short(failures.bound)} is possible here"
    return Section(title, "it stands still", (),
                   ("joint", f"σ{r} left", "ρ", "rank", "lost then"), rows, (0, 4), tuple(after),
                   ("ρ: the share of Yoshikawa's manipulability that is left",))  # fmt: skip


def tolerant_lines(tolerant: Tolerant) -> list[str]:
    """The answer: in general, and at the pose of the self-motions."""
    if tolerant.self_motion is None:
        return [tolerant_sentence(tolerant)]
    return [tolerant_sentence(tolerant), locked_sentence(tolerant.self_motion)]


def tolerant_sentence(tolerant: Tolerant) -> str:
    """Whether a configuration tolerates every single failure, and what the best of them keeps."""
    name = tolerant.robot.name
    if not tolerant.places:
        if tolerant.spare <= 0 or tolerant.crucial:
            template = "No configuration of {} tolerates"
        else:
            template = NO_TOLERANT
        return f"{template.format(name)} every single joint failure: {_why_none(tolerant)}."
    best, r = tolerant.places[0], tolerant.generic_rank
    if tolerant.relative:
        measure = f"σ{r} left / σ1"
    else:
        measure = f"σ{r}"
    worst = f"joint{'s' * (len(best.failures.worst_numbers) > 1)} {numbers(best.failures.worst_numbers)}"
    return (
        f"{name} tolerates the failure of any single joint: in the best configuration found, {measure} is "
        f"still {short(best.value, 5)} after the worst failure, that of {worst}."
    )


def tolerant_sections(tolerant: Tolerant) -> Iterator[Section]:
    """The places that were found, the σ that each failure leaves at the best, and the self-motions of a pose."""
    if tolerant.places:
        yield from _places_sections(tolerant)
    if tolerant.self_motion is not None:
        yield _self_motion_section(tolerant, tolerant.self_motion)


def _places_sections(tolerant: Tolerant) -> Iterator[Section]:
    best = tolerant.places[0]
    kinds = [str(joint.kind) for joint in tolerant.robot.variables]
    symbols = [joint_symbol(number, kind) for number, kind in enumerate(kinds, start=1)]
    r = tolerant.generic_rank
    places = enumerate(tolerant.places, start=1)
    rows = tuple(row for number, place in places for row in _rows(tolerant, number, place, kinds))
    if tolerant.relative:
        measure = f"σ{r} left / σ1"
    else:
        measure = f"σ{r} left"
    yield Section(
        f"Best worst case: {measure} = {short(best.value, 5)}",
        f"after the failure of any one of {tolerant.robot.n} joints",
        columns=("", measure, "worst without", "", *symbols), rows=rows, texts=(0, 2, 3),
        after=tuple(_tolerance_sentences(tolerant)),
    )  # fmt: skip
    yield failures_table(best.failures, "At the best of them")


def _self_motion_section(tolerant: Tolerant, self_motions: SelfMotions) -> Section:
    """Where each joint may be locked for the tool still to reach the pose, and where the arm stands best there."""
    measure = f"σ{tolerant.generic_rank} left" + " / σ1" * tolerant.relative
    units = [joint.unit for joint in tolerant.robot.variables]
    where = " inside the joint limits" * tolerant.limits
    asked = degrees_text(self_motions.q, units)
    best = degrees_text(self_motions.best, units)
    lines = (
        locked_sentence(self_motions),
        f"Worst failure at this pose: {measure} = {short(self_motions.value)} at {asked}, "
        f"at best {short(self_motions.best_value)} at {best}, at worst {short(self_motions.least_value)}.",
    )
    rows = tuple(
        (str(locked.number), locked.joint, _locked_ranges(locked, units[locked.number - 1]), _locked_share(locked))
        for locked in self_motions.joints
    )
    if tolerant.limits:
        of = f"{self_motions.usable} of {count(self_motions.curves, 'curve')} pass inside the joint limits"
    else:
        of = f"{count(self_motions.curves, 'curve')}, joint limits ignored"
    notes = [
        f"{of}; found from random starts, seed {tolerant.seed}: a curve may have been missed, so a share may be larger",
        "ends of ranges to some 0.5°; locked at another value, a joint takes the pose out of reach of these curves",
    ]
    if not self_motions.complete:
        notes.append("not every curve was followed to its end")
    return Section(
        "Self-motions of one tool pose", f"all configurations{where} that have the tool there", lines=lines,
        columns=("", "joint", "the pose stays in reach if locked in", "share"), rows=rows, texts=(1, 2),
        notes=tuple(notes),
    )  # fmt: skip


def locked_sentence(self_motions: SelfMotions) -> str:
    """The joint with the smallest share of values at which it may be locked, and those that may be locked anywhere."""
    shares = [(locked.number, locked.share) for locked in self_motions.joints if locked.share is not None]
    whole = [number for number, share in shares if share >= 1.0 - _ZERO]
    if whole:
        anywhere = f"; {plural('joint', len(whole))} {numbers(whole)} may be locked anywhere"
    else:
        anywhere = ""
    return (
        f"With joint {self_motions.weakest.number} locked the tool still reaches the pose at "
        f"{_locked_share(self_motions.weakest)} of its values, the least of all joints{anywhere}."
    )


def _locked_share(locked: LockedJoint) -> str:
    if locked.share is None:
        return "–"
    return f"{100 * locked.share:.3g} %"


def _locked_ranges(locked: LockedJoint, unit: str) -> str:
    """The values at which a joint may be locked: "−125° … −7°, 7° … 125°", "any"."""
    if locked.share is not None and locked.share >= 1.0 - _ZERO:
        return "any value"
    if unit == "rad":
        parts = [f"{fixed_point(degrees(low), 1)}° … {fixed_point(degrees(high), 1)}°" for low, high in locked.ranges]
    else:
        parts = [f"{low:.4g} … {high:.4g} m" for low, high in locked.ranges]
    return minus(", ".join(parts))


def _rows(tolerant: Tolerant, number: int, place: TolerantPlace, kinds: list[str]) -> Iterator[tuple[str, ...]]:
    """One place in rad, and under it in degrees."""
    def cell(j: int, text: str) -> str:
        if j + 1 in tolerant.free:
            return FREE
        return text

    if "prismatic" in kinds:
        unit = "rad, m"
    else:
        unit = "rad"
    plain = (cell(j, fixed_point(value)) for j, value in enumerate(place.q))
    yield (str(number), short(place.value, 5), numbers(place.failures.worst_numbers), unit, *plain)
    turned = (
        "" if kind == "prismatic" else cell(j, fixed_point(degrees(place.q[j]), 2)) for j, kind in enumerate(kinds)
    )
    yield ("", "", "", "deg", *turned)


def _tolerance_sentences(tolerant: Tolerant) -> Iterator[str]:
    best = tolerant.places[0]
    bound, most = short(best.failures.bound or 0.0, 5), short(tolerant.bound, 5)
    if tolerant.relative:
        if tolerant.optimal:
            reached = "; the best of them reaches it, none is better"
        else:
            reached = ""
        yield f"no configuration can have more than {most} by this measure{reached}"
    else:
        yield f"where the best of them stands no worst case can be above {bound}"
        yield f"by the relative measure, σ{tolerant.generic_rank} left / σ1, none anywhere can be above {most}"
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
    if tolerant.limits:
        where = "within the joint limits "
    else:
        where = ""
    return f"of {tolerant.done:,} starts {where}none leads to one; not finding one proves nothing"
