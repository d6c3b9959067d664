"""Numbers, motions and screws of an explanation as text: few digits, with units, no noise.

The failure of single joints, and the most fault-tolerant configurations, in words.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from math import ceil, degrees, floor, inf, isinf, log10, pi

import numpy as np

from rankdrop.families.tolerant import Place, Tolerant
from rankdrop.local.directions import Screw
from rankdrop.local.failures import Failures
from rankdrop.local.ways_out import Escape
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.text.families import FREE, joint_symbol

_ZERO = 1e-9  # a motion below it is not shown as one [rad, m]
_TURNS = 4 * pi  # joint values beyond it look like degrees [rad]
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_EXPONENT = re.compile(r"e([+-])0*(\d+)$")


def short(value: float, digits: int = 4) -> str:
    """A number with few digits: "0.1134", "2.6e−6", "∞".

    Example:
        >>> short(0.11340174), short(-2.5702e-6), short(0.0)
        ('0.1134', '−2.57e−6', '0')
    """
    if isinf(value):
        return "∞" if value > 0 else "−∞"
    return "0" if value == 0 else minus(_EXPONENT.sub(_exponent, f"{value:.{digits}g}"))


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
        'angles up to 90 look like degrees and are taken as radians'
    """
    angles = np.abs(q[..., [joint.unit == "rad" for joint in robot.variables]])
    most = float(angles.max(initial=0.0))
    return f"angles up to {most:.4g} look like degrees and are taken as radians" if most > _TURNS else None


def minus(text: str) -> str:
    """The sign − of the printed page for the hyphen of the machine."""
    return text.replace("-", "−")


def fixed(value: float, digits: int = 4) -> str:
    """A number with so many decimals, for columns."""
    return minus(f"{round(float(value), digits) + 0.0:.{digits}f}")


def power(value: float) -> str:
    """The power of ten at or above a rounding error: its digits are noise."""
    return "0" if value == 0 else minus(f"1e{ceil(log10(value))}")


def raised(exponent: int) -> str:
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


def vector(values: Iterable[float]) -> str:
    """Numbers in brackets, rounded to a millionth."""
    return f"({', '.join(short(round(float(value), 6) + 0.0) for value in values)})"


def pitch_text(pitch: float) -> str:
    """What kind of motion a twist of this pitch is."""
    if isinf(pitch):
        return "pure translation" if pitch == inf else "pure"
    return "pure rotation" if abs(pitch) < _ZERO else f"screw of pitch {short(pitch, 3)} m/rad"


def wrench_text(screw: Screw) -> str:
    """A wrench in words: its pitch is moment per force."""
    along = vector(screw.direction)
    if isinf(screw.pitch):
        return f"a torque about {along}"
    line = f"a force along {along} through {vector(screw.point)} m"
    return line if abs(screw.pitch) < _ZERO else f"{line} with {short(screw.pitch)} N m about it per N"


def numbers(members: Sequence[int]) -> str:
    """Joint numbers: "1, 3, 5"."""
    return ", ".join(map(str, members))


def plural(word: str, count: int) -> str:
    """ "motion" or "motions"."""
    return word if count == 1 else f"{word}s"


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
    "too small": "not told whether it can be left with the tool held still: σ_r is too small there",
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
LOST_TYPE = {
    1: "the tool moves along the lost direction only like the square of the joint motion",
    2: "the tool moves along the lost direction only after a motion of the joints that leaves it still",
}
"""What the type of a lost motion means."""
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


def avoidable_words(out: Escape) -> str:
    """Whether the singularity can be left with the tool held still."""
    words = _STILL.get(out.avoidable_reason, "")
    if out.still is not None:
        can = "you can leave it" if out.corank else "the joints can move"
        outside = "" if out.still.within_limits else "; outside the joint limits"
        words = (
            f"{can} with the tool held still: σ_r = {out.still.sigma_after:.3g} after {out.still.step:.3g} rad, "
            f"the tool where it was to {max(1e-12, out.still_error):.0e}{outside}"
        )
    return f"{_NEARBY}: {words}" if out.nearby else words


def boundary_words(out: Escape) -> str:
    """Whether the tool is at an edge of its reach."""
    words = _EDGE[out.boundary_reason]
    return f"{_NEARBY}: {words}" if out.nearby else words


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
    return Section(title, "it stands still", (),
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
        columns=("", measure, "worst without", "", *symbols), rows=rows, texts=(0, 2, 3),
        after=tuple(_tolerance_sentences(tolerant)),
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


def _tolerance_sentences(tolerant: Tolerant) -> Iterator[str]:
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
