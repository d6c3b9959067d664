"""Remedies of a path in words: what they change, and why there is none. Records: `rankdrop.path.mend.record`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import degrees, isfinite, isnan
from operator import attrgetter
from typing import Any

import numpy as np

from rankdrop.lists import flat_map
from rankdrop.options import advise
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.text.joint_values import fixed_point
from rankdrop.text.places import interval_words, turn_far_words, when
from rankdrop.text.words import plural, short
from rankdrop.units import counted_length

_LISTED = 12  # changes of a remedy that are listed
_LARGE = 99.5  # degrees or millimetres that are printed with three digits, from here on
_SEEN = 0.02  # share of the largest joint motion below which a joint is not named
_NAMED = 10  # places that are named

GAINS = {
    "distance": ("distance to the nearest singularity known", "rad"), "speed": ("speed that keeps the limits", ""),
    "duration": ("duration", "s"),
}  # fmt: skip
"""What is compared before and after a remedy: its name and its unit."""
_ENDED = {
    "singular": "end at a singularity", "limit": "end at a joint limit", "stuck": "cannot be followed",
    "few joints": "need more joints",
    "budget": "need more rows than one path may have",
    "start": "do not reach the first pose", "turn": "need an internal turn",
    "plan": "found no way when planned over all self-motions",
}  # fmt: skip


_DONE = {
    "same start": "the same tool path from the same start, by null-space motion",
    "elsewhere": "the same tool path begun elsewhere on its self-motion, by null-space motion",
    "planned": "the same tool path from the same start, planned over the self-motions of every pose",
    "planned elsewhere": "the same tool path from another start, planned over the self-motions of every pose",
    "branch": "another branch of the inverse kinematics runs the same tool path",
    "shift": "the base of the arm moved, in its own axes",
    "tilt": "the tool tilted about an axis through its tip, in its own axes",
    "bump": "the joints moved aside around each singularity; the rest of the path stays as it is",
    "detour": "the tool led around the singularities that the joints have to cross; the rest of its path stays",
    "detour elsewhere": "another branch of the inverse kinematics, the tool led around the singularities there",
    "blend": "the corner at row {0} cut by a parabola",
    "blends": "the corners at row {0} cut by a parabola",
    "slow-down": "the same path, slower around the places where a joint is too fast; the rest as fast as it was",
    "retime": "the same path in a new time, never faster than before and slower where a limit asks for it",
}
_CHANGES = {
    "null-space": "joint motion that leaves the tool where it is along the whole path: the arm has no redundant joint",
    "flip": "other posture at the first pose",
    "tool tilt": "rotation in the task", "base shift": "translation in the task",
}  # fmt: skip
_BLENDS = {None: "only paths that are straight between their rows have corners",
           0: "no corner is near enough for the tool to stay within the bound"}  # fmt: skip
_OBSTACLES = {
    "side": "the path ends beyond the singularity, which every joint path there crosses",
    "end": "the path begins or ends too near to the singularity",
    "height": "no joint motion within {bound} avoids it",
    "rate": "no bump keeps the joint limits of rates and accelerations",
}  # fmt: skip
"""Why the joints cannot be moved aside around a singularity."""
_HINDRANCES = {
    "end": "the path begins or ends too near to the singularity",
    "tool": "the joints cannot follow the tool around the singularity within {bound}",
    "limit": "{joints} reaches its limit before the tool is past the singularity",
    "range": "{joints} reaches its limit where no singularity is near",
    "rest": "the tool cannot be followed on the new branch up to here",
}
"""Why the tool cannot be led around a singularity."""
BOUNDED = {
    True: "rates of straight stretches, accelerations of blends between their middles, from rest to rest",
    False: "by control points of the derivatives, which enclose them",
}
"""How limits are known to hold: of a path that is straight between its rows, and of a smooth one."""

NO_POSES = {
    "same": "written as joint values: the poses stay as they are, and the joints move in another way along them",
    "unproven": "written as joint values: as poses with straight moves between them it could not be proven free",
}
"""Why a remedy of a file of poses is not written as poses."""


def remedy_words(how: str, fact: Any) -> str:
    """What a remedy does."""
    return _DONE[how].format(fact)


def remedy_note(kind: str, fact: Any) -> str:
    """What was tried of a kind of remedy that has none, and what came of it.

    Args:
        kind: of the remedy; "path": of every kind that keeps the tool's path.
        fact: of a blend how many were checked, None on a smooth path; of "path" why it cannot be followed; of others
            how many candidates run the whole path, and how many of the others end for each reason; of a bump how many
            times it was tried, the bound, and for each place without one the place, why, and the bound that is needed;
            of "range" a joint, how much wider its range would have to be, and the arm; of "other branches" how many
            were tried, of how many, and how many detours were looked for.
    """
    match kind:
        case "local":
            return f"bump and detour: not tried, more than {fact} places need one"
        case "range":
            joint, beyond, robot = fact
            amount = _amount(beyond, robot.variables[joint - 1].unit)
            return f"joint limits: with {amount} more range of joint {joint} the poses are followed to the end"
        case "other branches":
            followed, count, searched = fact
            return (f"detour on other branches: {followed} of {count} were followed until "
                    f"the budget of {searched} detours was spent")  # fmt: skip
        case "unfinished":
            return f"other kinds: not tried, the poses are followed up to pose {short(fact)} only"
        case "bump":
            return _bump_note(*fact)
        case "detour" if fact is not None:
            return _detour_note(*fact)
        case "path":
            return f"the tool's path cannot be followed: {fact}"
        case "slow-down" if fact:
            return f"{kind}: the limits cannot be kept without making nearly all of the path slower"
        case "detour" | "slow-down":
            return f"{kind}: only for paths that are straight between their rows"
        case "retime":
            return f"{kind}: the limits could not be kept everywhere"
        case "blend":
            return f"{kind}: {_BLENDS.get(fact) or f'{fact} tried, none was proven free'}"
    return f"{kind}: {_tried_words(kind, *fact)}"


def _tried_words(kind: str, run: int, ended: Counter[str]) -> str:
    """How many candidates of a kind were tried, how many ended for each reason, and how many run the whole path."""
    tried = run + ended.total()
    if not tried:
        return f"there is no {_CHANGES[kind]}"
    if len(ended) == 1 and tried > 1 and not run:
        return f"all {tried} that were tried {_ENDED[next(iter(ended))]}"
    parts = [f"{count} {_ENDED[reason]}" for reason, count in sorted(ended.items())]
    if run:
        parts.append(f"{run} run it at the rows that were computed, and none was proven free")
    return f"{tried} tried: {', '.join(parts)}"


def _bump_note(tried: int, bound: float, missing: Sequence[Any]) -> str:
    """Why the joints cannot be moved aside, and which bound would do."""
    if not missing:
        return f"bump: {tried} {plural('clearance', tried)} tried, none was proven free"
    parts = []
    for place, obstacle, needed in missing[:_NAMED]:
        words = _OBSTACLES[obstacle].format(bound=_bound("bump", bound))
        if isfinite(needed):
            words += f"; {_wider('bump', needed)} does"
        parts.append((when(place), words))
    if len(missing) > _NAMED:
        more = f"; and {len(missing) - _NAMED} more"
    else:
        more = ""
    return f"bump: {_by_reason(parts)}{more}"


def _by_reason(parts: Iterable[tuple[str, str]]) -> str:
    """Places with the reason of each, a reason of several places once: "at 1 s, at 3 s: no joint motion avoids it"."""
    places: dict[str, list[str]] = {}
    for place, reason in parts:
        places.setdefault(reason, []).append(place)
    return "; ".join(f"{', '.join(each)}: {reason}" for reason, each in places.items())


def _detour_note(bound: float, missing: Sequence[Any], many: int) -> str:
    """Why the tool cannot be led around, and which bound would do; `many`: crossings, if there are too many."""
    if many:
        return f"detour: not tried, the joints have to cross {many} times"
    if not missing:
        return "detour: the rest of the tool's path cannot be followed after it, or it was not proven free"
    parts = []
    for place, hindrance, needed, joints in missing[:_NAMED]:
        named = " or ".join(f"joint {joint}" for joint in joints) or "a joint"
        words = _HINDRANCES[hindrance].format(bound=_bound("detour", bound), joints=named)
        if isfinite(needed):
            words += f"; {_wider('detour', needed)} does"
        parts.append((when(place), words))
    return f"detour: {_by_reason(parts)}"


def _bound(name: str, bound: float) -> str:
    """A bound of a remedy as it is given."""
    return advise(name, f"{short(degrees(bound), 3)}deg", python=f"{name}={short(bound, 3)}")


def _wider(name: str, needed: float) -> str:
    """The bound that is large enough, rounded up to a tenth of a degree."""
    tenths = np.ceil(10.0 * degrees(needed) * 1.001)
    return advise(
        name, f"{tenths / 10.0:g}deg", python=f"{name}={np.ceil(1e4 * np.radians(tenths / 10)) / 1e4:g}"
    )


def remedies_sentence(mending: Any) -> str:
    """Which remedies were found."""
    if not mending.needed:
        return "Remedies: none is needed."
    if mending.complete:
        stopped = ""
    else:
        stopped = ", interrupted: not all kinds were tried"
    if not mending.remedies:
        return f"Remedies: none was found{stopped}; that is no proof that there is none."
    parts = []
    for clear, what in ((True, "checked again: free, proven"), (False, "limits kept; it still meets a singularity")):
        kinds = [remedy.kind for remedy in mending.remedies if remedy.check.clear == clear]
        if kinds:
            parts.append(f"{', '.join(kinds)} ({what})")
    return f"Remedies: {'; '.join(parts)}{stopped}."


def remedy_sections(mending: Any, *, deg: bool) -> tuple[Section, ...]:
    """The remedies, and the kinds of which none was found."""
    lines = tuple(flat_map(lambda remedy: _remedy_lines(remedy, deg=deg), mending.remedies))
    if mending.notes:
        others = [Section("Remedies that were not found", lines=mending.notes)]
    else:
        others = []
    return Section(mending.sentence, lines=lines), *others


def _remedy_lines(remedy: Any, *, deg: bool) -> list[str]:
    """A remedy: its kind, what it changes and gains, how much of the limits it uses, and how far the tool strays."""
    lines = [f"{remedy.kind}: {remedy.words}"]
    robot = remedy.check.robot
    lines += [f"    {parameter[0]}: {_value(parameter, robot, deg=deg)}" for parameter in remedy.parameters]
    lines += [f"    {change_words(change, robot)}" for change in remedy.changes[:_LISTED]]
    if len(remedy.changes) > _LISTED:
        lines += [f"    and {len(remedy.changes) - _LISTED} more changes"]
    lines += [f"    {turn_far_words(turn)}" for turn in remedy.turns[:_NAMED]]
    lines += [f"    {words}" for words in _gain_words(remedy.gains)]
    lines.append(f"    checked again: {remedy.check.sentence}")
    if remedy.usage is not None:
        lines.append(f"    {_usage_words(remedy)}")
    if max(np.nan_to_num(remedy.off)) > 0.0:
        lines.append(f"    {_off_words(remedy)}")
    return lines


def _gain_words(gains: Mapping[str, tuple[float, float]]) -> Iterator[str]:
    """Each quantity that a remedy improves, before and after it; those that nobody knows are left out."""
    for what, values in gains.items():
        name, unit = GAINS[what]
        before, after = (short(value) if isfinite(value) else "not known" for value in values)
        if not np.isnan(values).all():
            yield f"{name}: {before} → {after}{' ' if unit else ''}{unit}"


def _usage_words(remedy: Any) -> str:
    """How much of the limits of rate and acceleration a remedy uses."""
    usage = remedy.usage
    if remedy.retimed and remedy.kind not in ("retime", "slow-down"):
        retimed = "new time law; "
    else:
        retimed = ""
    used = [f"{short(100 * share)} % of the {what} limits" for share, what in
            ((usage.rate, "rate"), (usage.acceleration, "acceleration")) if share > 0.0]  # fmt: skip
    return f"{retimed}at most {' and '.join(used)} at every instant ({usage.how})"


def _off_words(remedy: Any) -> str:
    """How far the tool strays, and from what."""
    if remedy.kind == "blend" or remedy.changes:
        where = "of the old path where it leaves it"
    else:
        where = "of its path between rows, measured in their middles"
    return f"the tool is within {tool_off_words(remedy.off, remedy.check.robot)} {where}"


def change_words(change: Any, robot: Robot) -> str:
    """A local change: which joints move how far, between which places, and how far the tool is moved."""
    when, off = interval_words(change.start, change.end), tool_off_words(change.off, robot)
    if not (change.longer > 0.0 or change.way.any()):
        return f"the tool moves by {off} {when}"
    if change.longer > 0.0:
        return f"slower {when}, which takes {short(change.longer, 2)} s longer"
    if not change.at_end.any():
        return f"{joint_moves(change.way, robot)} {when}; the tool moves by {off}"
    after = joint_moves(change.at_end, robot)
    return f"the tool moves by {off} {when}; at its end the arm is on another branch: {after}"


def joint_moves(way: Array, robot: Robot) -> str:
    """Joint motions, the largest first: "joint 5 by 1.5°, joint 3 by −1.1°"; what is below 1 % of it left out."""
    turns = np.array([joint.unit == "rad" for joint in robot.variables])
    size = np.abs(way) / np.where(turns, 1.0, counted_length(robot))
    order = [int(i) for i in np.argsort(-size, kind="stable") if size[i] >= _SEEN * size.max()]
    return ", ".join(f"joint {i + 1} by {_amount(float(way[i]), robot.variables[i].unit)}" for i in order)


def _amount(value: float, unit: str) -> str:
    if unit == "rad":
        number = degrees(value)
    else:
        number = 1e3 * value
    return f"{short(number, 2 if abs(number) < _LARGE else 3)}{'°' if unit == 'rad' else ' mm'}"


def tool_off_words(off: tuple[float, float], robot: Robot) -> str:
    """A deviation of the tool; what the task leaves free is left out."""
    parts = []
    if not isnan(off[0]):
        parts.append(f"{_small(1000 * off[0] / counted_length(robot))} mm")
    if not isnan(off[1]):
        parts.append(f"{_small(degrees(off[1]))}°")
    return " and ".join(parts)


def local_lines(mending: Any) -> list[str]:
    """The best local remedy, and one that keeps the times where it does not; or why there is none."""
    best = mending.best
    if best is not None:
        lines = [f"Remedy: {_in_a_sentence(best)}."]
        others = [remedy for remedy in mending.remedies if remedy.check.clear and not remedy.retimed]
        if best.retimed and others:
            lines.append(f"Or in the same time: {_in_a_sentence(others[0])}.")
        return lines
    if mending.notes:
        reasons = " ".join(f"{note[:1].upper()}{note[1:]}." for note in mending.notes)
        return [f"No local remedy. {reasons}"]
    return []


def _in_a_sentence(best: Any) -> str:
    """A remedy in one sentence, and the options that write it."""
    robot = best.check.robot
    kind = best.kind.replace(" ", "-")
    options = advise(
        "remedy", f"{kind} {advise('fixed', 'FILE')}", python=f"mend_path(check, kinds=[{best.kind!r}])"
    )
    if best.kind == "slow-down":
        where = _slower_words(best.changes)
        return f"{where} keeps the joint limits and is free (proven), the tool on its path. {options} writes it"
    change = max(best.changes, key=lambda change: float(np.abs(change.way).max()), default=None)
    if change is None:
        what = best.words
    elif change.at_end.any() or not change.way.any():
        what = f"the tool led around it {interval_words(change.start, change.end)}"
    else:
        what = f"{joint_moves(change.way, robot)} {interval_words(change.start, change.end)}"
    others = len(best.changes) - 1
    if others > 0:
        more = f", and {others} more {plural('change', others)},"
    else:
        more = ""
    turns = "".join(f"; {turn_far_words(turn)}" for turn in best.turns)
    if best.retimed:
        slower = " in a new time law"
    else:
        slower = ""
    off = tool_off_words(best.deviation, robot)
    return f"{what}{more} is free (proven){slower}, the tool within {off} of the path{turns}. {options} writes it"


def _slower_words(changes: Sequence[Any]) -> str:
    """Where a path is made slower, the longest part first, and how much longer all of it takes."""
    longest = max(changes, key=attrgetter("longer"))
    if len(changes) == 1:
        more = ""
    else:
        more = f" and at {len(changes) - 1} more {plural('place', len(changes) - 1)}"
    total = sum(stretch.longer for stretch in changes)
    return f"slower {interval_words(longest.start, longest.end)}{more}, {short(total, 2)} s longer in all,"


def _value(parameter: Any, robot: Robot, *, deg: bool) -> str:
    """The value of a parameter of a remedy, with its unit; of "rad, m" one value for each joint."""
    _, value, unit = parameter
    several = isinstance(value, tuple)
    if unit == "rad, m" and several:
        joints = zip(robot.variables, value, strict=True)
        return ", ".join(_joint_value(joint, number, deg=deg) for joint, number in joints)
    if several:
        values = value
    else:
        values = (value,)
    if unit == "rad" and deg:
        return f"{', '.join(short(degrees(number)) for number in values)}°"
    inside = ", ".join(short(number + 0.0) for number in values)
    if several:
        inside = f"({inside})"
    return f"{inside} {unit}".rstrip()


def _joint_value(joint: Any, value: float, *, deg: bool) -> str:
    """The name of a joint and its value, angles in degrees with `deg`."""
    if joint.unit == "rad" and deg:
        return f"{joint.name} {fixed_point(degrees(value), 2)}°"
    return f"{joint.name} {fixed_point(value)} {joint.unit}"


def _small(value: float) -> str:
    """A deviation; what is below 1e-9 is rounding."""
    if value >= 1e-9:
        return short(value, 2)
    return "0"


def poses_written(target: str, remedy: Any, made: Any, robot: Robot, *, arm: str, given_start: bool) -> str:
    """What was written of a mended file of poses, and the command that checks it on the branch of the remedy.

    Args:
        target: the file that is written.
        remedy: the remedy.
        made: its poses.
        robot: the arm.
        arm: as it was named.
        given_start: the branch was chosen by a start.
    """
    new = int((made.given < 0).sum())
    kept = len(made.given) - new
    count = f"{kept:,} {plural('pose', kept)} of the file and {new:,} new {plural('pose', new)}"
    words = f"{target}: mended by {remedy.kind}, {count}, checked again: free (proven)"
    if not given_start and not made.moved:
        return words
    values = ",".join(f"{x:.9g}" for x in made.start.tolist())
    start = advise("start", f'"{values}"', python=f"start=[{values}]")
    return f"{words}; its branch: rankdrop path {arm} {target} {start}"
