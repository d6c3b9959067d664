"""Names of singularity families, from the geometry of the axes at sample points; never from the arm's name.

And the motions that a family takes away, as directions.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import ConfigurationError
from rankdrop.family.equation import pretty_angle
from rankdrop.family.facts import NEARLY, Fact, Structure, candidate_facts, listed, structure_of
from rankdrop.family.lost import LostFreedom, freedoms_at_witness, freedoms_of
from rankdrop.kinematics import task_jacobian
from rankdrop.local.axes import Scene, describe, line_meets_all, to_blame
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.local.directions import lost_directions, lost_over_family
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.numbers import wrapped
from rankdrop.task import Task
from rankdrop.units import as_given


def lost_motions(problem: Problem, at: Array, points: Array) -> tuple[Array, tuple[LostFreedom, ...]]:
    """Lost directions at a configuration in the task's frame, and as the freedoms that the family takes away.

    These are for the whole family where some frame of the chain sees the same directions at all its points; else they
    are for the configuration, in the frame where they are sparsest.

    Args:
        problem: the arm, and the corank of the family.
        at: (n,) a configuration on the family, of exactly its corank.
        points: (N, n) others.
    """
    robot, task, corank = problem.robot, problem.task, problem.corank
    directions = lost_directions(robot, at, task, corank)
    steady = lost_over_family(robot, np.vstack([at, points[:5]]), task, corank)
    if steady is not None:
        return directions, freedoms_of(robot, steady, everywhere=True)
    return directions, freedoms_at_witness(robot, at, task, corank)


_POINTS = 12  # sample points looked at
_AWAY = 0.37  # how far a joint is moved to see what it breaks [rad, m]: no simple fraction of π
_PARTS = ("shoulder", "elbow", "wrist")
_LOST = 1e-6  # σ at or below this at the samples is zero; a joint moved by _AWAY lifts it by far more


def name_family(
    robot: Robot, task: Task, points: ArrayLike, pinned: Sequence[int] = (), *, coupled: Sequence[int] | None = None
) -> str:
    """A short name for a family of singular configurations.

    1. Joints that matter: those whose motion alone raises the rank at the samples, and the pinned ones.
    2. Facts about the axes that hold at every sample but not at every configuration (`candidate_facts`), the most
       telling first, are taken until each joint that matters breaks one of them when it moves. In an arm without
       redundancy facts that cost rank by themselves come first, and have to add up to the corank.
    3. Facts that concern the shoulder, the elbow or the wrist give the name its first words.
    4. What the facts leave open: joints that other conditions bind ("with a condition on θ3–θ6"), and values that tell
       the posture: those that are no simple angles, and those of joints that break none of the facts. Without any fact:
       "all axes meet one line" where the blocked wrench is a pure force, else the smallest dependent sets of joint
       screws ("screws 2–6 dependent").

    What a name states is true at every sample point. Names are not unique: `distinct_names` makes them so.

    Args:
        robot: the arm.
        task: the rows that matter.
        points: (N, n) generic points of the family, singular to 1e-9 or better [rad, m]; the first twelve are looked
            at, all of them for the values of single joints.
        pinned: numbers of the family's pinned joints, if known.
        coupled: numbers of the joints that conditions bind beside the pinned ones; None: not known, not told.

    Raises:
        ConfigurationError: no points, the wrong shape, or points that are not singular.
    """
    q = np.asarray(points, dtype=np.float64)
    if q.ndim != 2 or q.shape[0] == 0 or q.shape[1] != robot.n or not np.isfinite(q).all():
        raise ConfigurationError("points of a family are needed", got=q.shape, allowed=f"(N, {robot.n}), N ≥ 1, finite")
    scene = Scene(robot, q[:_POINTS])
    generic = generic_rank(robot, task)
    corank = generic - int((singular_values(robot, scene.q, task)[:, :generic] > _LOST).sum(axis=1).max())
    if corank == 0:
        raise ConfigurationError("these points are not all singular", mend="polish them, or drop the regular ones")
    structure = structure_of(robot, task, generic)
    matter = _joints_that_matter(scene, task, generic - corank) | {number - 1 for number in pinned}
    facts, covered = _explain(structure, scene, matter, corank)
    if facts:
        name = _compose(facts, structure.tight, corank)
        if coupled is None:
            return name
        return name + _open(robot, q, matter - covered, pinned, coupled)
    return _systematic(scene, structure, task, corank, generic)


_ONE = 1e-5  # values of a joint that differ by less are one [rad, m]
_FEW = 2  # values of one joint that a name tells
_DECIMALS = 5  # an angle that is nearly, but not quite, a right one is told with fewer


def _open(robot: Robot, q: Array, uncovered: set[int], pinned: Sequence[int], coupled: Sequence[int]) -> str:
    """What a name's facts leave open: ", with a condition on θ3–θ6", " (θ4 = −26.8° or 153.2°)".

    Args:
        robot: the arm.
        q: (N, n) points of the family.
        uncovered: joints (from 0) that matter and break none of the facts.
        pinned, coupled: numbers of joints.
    """
    bound = sorted({*(number - 1 for number in (*pinned, *coupled)), *uncovered})
    values = {j: _values(q[:, j], turns=bool(robot.periodic[j])) for j in bound}
    few = {j: one for j, one in values.items() if len(one) <= _FEW}
    varying = [j for j in bound if j not in few]
    needed = uncovered & set(varying)
    if needed:
        tail = f", with a condition on {_run(varying, robot)}"
    else:
        tail = ""
    told = [
        f"{_letter(robot, j)} = {' or '.join(_value(robot, j, x) for x in one)}"
        for j, one in few.items() if j in uncovered or not all(map(_simple, one))
    ]  # fmt: skip
    return tail + (f" ({', '.join(told)})" if told else "")


def _values(column: Array, *, turns: bool) -> list[float]:
    """The different values of one joint, sorted; angles in (−π, π]."""
    found: list[float] = []
    for value in np.pi - np.mod(np.pi - column, 2 * np.pi) if turns else column:
        off = (value - other for other in found)
        if all(abs(wrapped(x) if turns else x) > _ONE for x in off):
            found.append(float(value))
        if len(found) > _FEW:
            break
    return sorted(found)


def _simple(value: float) -> bool:
    """Whether a value is a multiple of a right angle."""
    return abs(value / (np.pi / 2) - round(value / (np.pi / 2))) <= _ONE


def _value(robot: Robot, joint: int, value: float) -> str:
    if robot.variables[joint].unit != "rad":
        return f"{as_given(robot, np.eye(robot.n)[joint] * value)[joint]:.3g} m".replace("-", "−")
    if _simple(value):
        return pretty_angle(round(value / (np.pi / 2)) * (np.pi / 2))
    degrees = float(np.degrees(value))
    for decimals in range(1, _DECIMALS):
        if not _simple(np.radians(round(degrees, decimals))):  # 179.997° is not 180.0°
            break
    return f"{degrees:.{decimals}f}°".replace("-", "−")


def _letter(robot: Robot, joint: int) -> str:
    return f"{'θ' if robot.variables[joint].unit == 'rad' else 'q'}{joint + 1}"


def _run(joints: Sequence[int], robot: Robot) -> str:
    """ "θ3–θ6" for a run of three or more, "θ2, θ4" otherwise."""
    letters = [_letter(robot, j) for j in joints]
    if len(joints) > 2 and joints[-1] - joints[0] == len(joints) - 1:
        return f"{letters[0]}–{letters[-1]}"
    return ", ".join(letters)


def distinct_names(names: Sequence[str], conditions: Sequence[Callable[[], Sequence[str]]]) -> list[str]:
    """Names made unique: of those that are the same each gets the first short condition that only it has; then short.

    Args:
        names: of the families of one corank, in their order.
        conditions: of each, how to get its conditions for people; asked where it is needed only.

    Returns:
        The names; where no short condition tells them apart they are counted: "wrist (second)".

    Example:
        >>> distinct_names(["elbow", "wrist", "elbow"], [lambda: ["θ3 = 0"], lambda: ["θ5 = 0"], lambda: ["θ3 = π"]])
        ['elbow (θ3 = 0)', 'wrist', 'elbow (θ3 = π)']
    """
    result = list(names)
    for name, count in Counter(names).items():
        if count == 1:
            continue
        places = [place for place, other in enumerate(names) if other == name]
        texts = [conditions[place]() for place in places]
        for number, place in enumerate(places):
            others = {text for k, one in enumerate(texts) if k != number for text in one}
            own = [text for text in texts[number] if text not in others and len(text) <= _SHORT]
            if own:
                mark = own[0]
            else:
                mark = _ORDINALS.get(number, f"{number + 1}th")
            if name.endswith(")"):
                result[place] = f"{name[:-1]}, {mark})"
            else:
                result[place] = f"{name} ({mark})"
    return shortened(result)


_SHORT = 24  # characters of a condition that stands in a name
_ORDINALS = {0: "first", 1: "second", 2: "third", 3: "fourth", 4: "fifth", 5: "sixth"}


LONGEST = 60
"""Characters that a name should have at most."""


def shortened(names: Sequence[str]) -> list[str]:
    """Names of at most `LONGEST` characters that stay different; shorter ones keep every word.

    A long one gives up as little as it must: first the way its values are written, then relations of single axes, then
    other details and values. The part of the arm is always told. One that cannot be that short is the shortest that no
    other has.

    Example:
        >>> shortened(["shoulder and wrist, axes 1, 4, 6 aligned (θ2 = −112.8° or 112.8°, θ3 = −157.2° or −22.8°)"])
        ['shoulder and wrist (θ2 = ±112.8°, θ3 = −157.2° or −22.8°)']
    """
    result = list(names)
    for place, name in enumerate(names):
        if len(name) > LONGEST:
            others = {*result[:place], *names[place + 1 :]}
            tried = [one for one in _shorter(name) if one not in others]
            fitting = [one for one in tried if len(one) <= LONGEST]
            if fitting:
                result[place] = fitting[0]
            else:
                result[place] = min(tried, key=len, default=name)
    return result


_HEAD = re.compile(rf"((?:{'|'.join(_PARTS)})(?:(?:, | and )(?:{'|'.join(_PARTS)}))*)(: |, |$)")
_DETAIL = re.compile(r"(, |; )(?=axes? |screws? |joints? |\d+ [∥⟂]|arm |with a |a line|all axes)")
_REWORDED: tuple[tuple[int, str, str | Callable[[re.Match[str]], str]], ...] = (
    (1, r"(θ\d+) = −([\d.]+°) or \2", r"\1 = ±\2"),
    (2, r"axes \d+, \d+ and wrist centre coplanar", "arm stretched or folded"),
    (4, "with a condition on", "a condition on"),
    (8, r"(concurrent|parallel) and coplanar", r"\1"),
    (12, r"\d+\.\d+(?=°)", lambda found: _whole_degrees(found[0])),
    (14, r"with a condition on [^(]*\b(?= \(|$)", "with a condition"),
)
"""(cost, words, what says nearly as much in fewer characters)."""
_RELATION, _FACT, _VALUE, _BOUND = 6, 40, 48, 80
"""Cost of leaving out "4 ⟂ 6", another fact, a value, and that there is a condition."""


def _shorter(name: str) -> list[str]:
    """What a name may become, what it loses least by first."""
    if name.endswith(")"):
        body, mark, inside = name.partition(" (")
    else:
        body, mark, inside = (name, "", "")
    if mark:
        values = re.split(r", (?=[θq]\d)", inside[:-1])
    else:
        values = []
    head = _HEAD.match(body)
    if head:
        part, colon = (head[1], head[2])
    else:
        part, colon = ("", "")
    rest = body[head.end() :] if head else body
    pieces = _DETAIL.split(rest)
    if rest:
        details = list(zip(["", *pieces[1::2]], pieces[::2], strict=True))
    else:
        details = []
    found: list[tuple[int, str]] = []
    for kept, told in product(_subsets([text for _, text in details], bool(part)), range(len(values) + 1)):
        lost = [text for place, (_, text) in enumerate(details) if place not in kept]
        joined = "".join(details[place][0] * (number > 0) + details[place][1] for number, place in enumerate(kept))
        text = part + colon * bool(kept) + joined + (f" ({', '.join(values[:told])})" if told else "")
        cost = sum(map(_cost, lost)) + _VALUE * (len(values) - told)
        for chosen in product((False, True), repeat=len(_REWORDED)):
            worded, spent = text, cost
            for (price, old, new), wanted in zip(_REWORDED, chosen, strict=True):
                if wanted:
                    worded, spent = re.sub(old, new, worded), spent + price
            found.append((spent, worded))
    return list(dict.fromkeys(text for _, text in sorted(found, key=lambda one: one[0])))


def _whole_degrees(degrees: str) -> str:
    """In whole degrees, unless that would be a right angle."""
    whole = round(float(degrees))
    return str(whole) if whole % 90 else degrees


def _cost(detail: str) -> int:
    """Of leaving out a detail."""
    if detail.startswith("with a"):
        return _BOUND
    if detail[0].isdigit():
        return _RELATION
    return _FACT


_MANY = 6  # details of which every choice is tried


def _subsets(details: Sequence[str], parted: bool) -> list[tuple[int, ...]]:
    """Which details may be kept, in their order: with a fact, if there is one; none where a part of the arm is told."""
    count = len(details)
    every = range(2**count) if count <= _MANY else [2**first - 1 for first in range(count + 1)]
    chosen = [tuple(i for i in range(count) if number >> i & 1) for number in every]
    facts = {i for i, text in enumerate(details) if _cost(text) == _FACT} or set(range(count))
    return [one for one in chosen if facts & set(one) or (parted and not one)]


def _joints_that_matter(scene: Scene, task: Task, rank: int) -> set[int]:
    """Joints whose motion alone raises the rank at more than half of the samples."""
    matter = set()
    for joint in range(scene.robot.n):
        sigma = singular_values(scene.robot, scene.moved(joint, _AWAY).q, task)[:, rank]
        if np.mean(sigma > _LOST) > 0.5:
            matter.add(joint)
    return matter


def _explain(structure: Structure, scene: Scene, matter: set[int], corank: int) -> tuple[list[Fact], set[int]]:
    """Facts of the family, and the joints each of which breaks one of them.

    Without redundancy the facts have to cost as much rank as is lost; else none is claimed.
    """
    true = [f for f in candidate_facts(structure, scene) if f.holds(scene).all() and not structure.always(f.holds)]
    breaking = [{j for j in matter if not f.holds(scene.moved(j, _AWAY)).all()} for f in true]
    if structure.tight:
        chosen = _losing(true, breaking, corank)
    else:
        chosen = []
    if structure.tight and sum(true[i].losses for i in chosen) < corank:
        return [], set()
    covered = {j for i in chosen for j in breaking[i]}
    for i in range(len(true)):
        if i not in chosen and breaking[i] - covered:
            chosen.append(i)
            covered |= breaking[i]
    return [true[i] for i in chosen], covered


def _losing(facts: Sequence[Fact], breaking: Sequence[set[int]], corank: int) -> list[int]:
    """Numbers of facts that cost rank by themselves, until as much is lost as the corank says."""
    chosen: list[int] = []
    covered: set[int] = set()
    for i, fact in enumerate(facts):
        short = sum(facts[j].losses for j in chosen) < corank
        if fact.losses and short and (breaking[i] - covered or (fact.roles and breaking[i])):
            chosen.append(i)
            covered |= breaking[i]
    return chosen


def _compose(facts: Sequence[Fact], tight: bool, corank: int) -> str:
    """ "elbow: …"; the parts alone ("elbow and wrist") where each of several independent facts is one part's own."""
    named = {role for fact in facts for role in fact.roles}
    parts = [part for part in _PARTS if part in named]
    if len(parts) > 1:
        head = " and ".join([", ".join(parts[:-1]), parts[-1]])
    else:
        head = "".join(parts)
    if tight and corank > 1 and len(parts) == corank:
        body = _details([fact for fact in facts if len(fact.roles) != 1])
        return f"{head}, {body}" if body else head
    body = _details(facts)
    return f"{head}: {body}" if head else body


def _details(facts: Sequence[Fact]) -> str:
    """The facts in words; the first in full, later ones with ∥ and ⟂."""
    own = [fact for fact in facts if fact.kind == "own"]
    parallel = _parallel_to_bundles(facts, own)
    if len(own) < len(facts):  # the word "elbow" says it
        own = [fact for fact in own if fact.roles != ("elbow",) or fact.text == NEARLY]
    details = [fact.text for fact in own if fact.roles]
    details += [*_aligned(facts), *parallel, *(fact.text for fact in own if not fact.roles)]
    relations = _relations(facts, {fact.joints for fact in own})
    if relations and not details:
        first = relations.pop(0)
        details.append(f"axes {_join_groups([first.joints])} {first.kind}")
    details += [_SIGNS[fact.kind].join(str(i + 1) for i in fact.joints) for fact in relations]
    return ", ".join(details)


def _aligned(facts: Sequence[Fact]) -> list[str]:
    groups = [fact.joints for fact in facts if fact.kind == "aligned"]
    if groups:
        return [f"axes {_join_groups(groups)} aligned"]
    return []


def _relations(facts: Sequence[Fact], told: set[tuple[int, ...]]) -> list[Fact]:
    """What is parallel, then what is perpendicular, but for joints of which more is told."""
    return [fact for kind in _SIGNS for fact in facts if fact.kind == kind and fact.joints not in told]


_SIGNS = {"parallel": " ∥ ", "perpendicular": " ⟂ "}


def _parallel_to_bundles(facts: Sequence[Fact], own: Sequence[Fact]) -> list[str]:
    """Axes parallel to a bundle, bundle by bundle, but for what other facts tell."""
    firsts: dict[tuple[int, ...], list[int]] = {}
    for first, *bundle in (fact.joints for fact in facts if fact.kind == "against"):
        if not any({first, *bundle} <= set(other.joints) for other in own):
            firsts.setdefault(tuple(bundle), []).append(first)
    return [
        f"{'axis' if len(first) == 1 else 'axes'} {listed(first)} parallel to {listed(bundle)}"
        for bundle, first in firsts.items()
    ]


def _join_groups(groups: Sequence[Sequence[int]]) -> str:
    """ "1 and 3" for one pair, "1, 3, 5" for one group, "1, 3 and 5, 7" for two."""
    if len(groups) == 1 and len(groups[0]) == 2:
        groups = [[joint] for joint in groups[0]]
    return " and ".join(map(listed, groups))


def _systematic(scene: Scene, structure: Structure, task: Task, corank: int, generic: int) -> str:
    """A name from the smallest dependent sets of joint screws."""
    usual = task_jacobian(scene.robot, structure.scene.q, task)
    blame = to_blame(task_jacobian(scene.robot, scene.q, task), usual, corank)
    texts = [describe(scene, circuit, task) for circuit in blame]
    if len(blame) == corank and all("dependent" not in text for text in texts):
        return "; ".join(texts)
    if corank == 1 and generic == task.m and line_meets_all(scene, task):
        if structure.tip_is_centre:
            return "a line through the tip meets all axes"
        return "all axes meet one line"
    if len(blame) == corank and (structure.tight or min(len(circuit) for circuit in blame) < generic):
        return "; ".join(texts)
    what = "screws" if task.m == 6 else "joints"
    return f"{what} 1–{scene.robot.n} of rank {generic - corank}"
