"""A certificate checked: its claim is compared with what was asked about, proven again, and stated as a whole.

The sentences of a claim are made here, by the code that proves it: nothing else could state more than was proven.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rankdrop.proof.arm import BITS, Arm, Interval, Region, cross, dot, flint
from rankdrop.proof.covers import corank_of, verify_covering
from rankdrop.proof.curves import AskedPath, ToolPath, compare_rows
from rankdrop.proof.existence import verify_existence
from rankdrop.proof.minors import verify_in_minors
from rankdrop.proof.postures import verify_change
from rankdrop.proof.record import (
    BALL,
    CHANGE,
    COVERING,
    CROSSING,
    EXISTENCE,
    PATH,
    SCREW,
    SIGNS,
    SLIDE,
    TURN,
    Array,
    Claim,
    Link,
    Record,
    Refused,
    Unproven,
    Work,
    read_certificate,
    seal,
)
from rankdrop.proof.regions import ClaimCheck, verify_ball, verify_distance, verify_path
from rankdrop.proof.signs import verify_signs

ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")
_TRIED = 3  # configurations at which a higher rank is looked for
_ON_AXIS = 1e-9  # lengths by which the axis of a joint that moves nothing may miss the point of a translation
_VANISHES = 1e-11  # share of the Jacobian's size below which rows that the task leaves out count as zero
_SAME = 1e-9  # joint values that differ by less are the same [rad, m]


@dataclass(frozen=True, eq=False)
class Asked:
    """What a certificate must be about; None: whatever it states.

    Attributes:
        arm: entry of the arm, as a certificate has it.
        task: entry of the task, and `scale`, the unit of motion of each variable.
        q: centre of a ball, place of a singular configuration, or where a change of posture begins [rad, m].
        path: a path's file, as it was read: its curve is compared with every control point. A hash that the
            certificate states is not believed.
        limits: whether a covering, or a change of posture, is within the joint limits.
    """

    arm: Record | None = None
    task: Record | None = None
    q: Array | None = None
    path: AskedPath | None = None
    limits: bool | None = None


@dataclass(frozen=True)
class Verdict:
    """Result of checking a certificate.

    Attributes:
        holds: the claim is proven.
        kind: "ball", "path", "covering", "existence", "posture change" or "sign proof"; "" of a file that is
            damaged.
        arm: name of the arm, as the certificate has it.
        claim: what holds, in one sentence; "" where it does not.
        reason: why it is not confirmed, in one sentence; "" where it is. A proof that fails refutes nothing.
        assumed: what the proof rests on besides the numbers of the arm.
        enclosures: of interval arithmetic that were made.
        complete: False where it was interrupted.
        statement: the whole claim, entry by entry: arm, task, place, ranges.
        how: how the boxes of a covering were proven.
    """

    holds: bool
    kind: str = ""
    arm: str = ""
    claim: str = ""
    reason: str = ""
    assumed: tuple[str, ...] = ()
    enclosures: int = 0
    complete: bool = True
    statement: tuple[str, ...] = ()
    how: str = ""


def check_certificate(file: Path, asked: Asked, work: Work) -> Verdict:
    """Check a certificate: prove its claim again from the numbers of the arm that are in it.

    Raises:
        Refused: the file, its covering or its journal cannot be read, or the certificate is malformed.
        ImportError: python-flint is not installed.
    """
    context = flint().ctx
    try:
        claim = read_certificate(file)
    except Unproven as error:
        return Verdict(False, reason=str(error))
    try:
        with context.workprec(BITS):
            compare(claim, asked)
            sentence, statement, assumed, how = _prove(claim, work)
            try:
                if claim.kind == PATH or asked.path is not None:
                    statement += _of_file(claim, asked.path)
            except Unproven as error:
                reason = f"{error}. Proven: {sentence}"
                return Verdict(False, claim.kind, claim.name, "", reason, assumed, work.done, True, statement, how)
    except Unproven as error:
        return Verdict(False, claim.kind, claim.name, reason=str(error), enclosures=work.done)
    except KeyboardInterrupt:
        done, count = work.place
        if count:
            far = f": {done:,} of {count:,} were checked"
        else:
            far = ": not all of it was checked"
        if work.journal is not None:
            kept = f", which {work.journal} keeps: the same command continues"
        else:
            kept = ""
        reason = f"interrupted{far}{kept}"
        return Verdict(False, claim.kind, claim.name, reason=reason, enclosures=work.done, complete=False)
    return Verdict(True, claim.kind, claim.name, sentence, "", assumed, work.done, True, statement, how)


def compare(claim: Claim, asked: Asked) -> None:
    """Compare the claim with what was asked about.

    Raises:
        Unproven: it is another claim.
    """
    for name, differs in (("arm", _other_arm), ("task", _other_task), ("q", _other_place), ("path", _other_path),
                          ("limits", _other_limits)):  # fmt: skip
        if getattr(asked, name) is not None:
            reason = differs(claim, asked)
            if reason:
                raise Unproven(f"another claim: the certificate is about {reason}")


def _other_arm(claim: Claim, asked: Asked) -> str:
    mine, other = claim.record["arm"], asked.arm or {}
    name = f"another arm than {other['name']!r}"
    if mine["fingerprint"] != other["fingerprint"] or mine["last"] != other["last"]:
        return f"{name}: their numbers differ"
    within = claim.kind == COVERING or (claim.kind == CHANGE and claim.entries["limits"])
    if within and claim.limits is not None:
        for own, joint in zip(mine["joints"], other["joints"], strict=True):
            if (own["lower"], own["upper"]) != (joint["lower"], joint["upper"]):
                return f"{name}: the limits of joint {joint['name']!r} differ"
    return ""


def _other_task(claim: Claim, asked: Asked) -> str:
    mine, other = claim.record["task"], asked.task or {}
    if mine["rows"] != other["rows"]:
        return f"the rows {_rows(mine['rows'])}, not {_rows(other['rows'])}"
    if claim.whole_rows != [0, 1, 2, 3, 4, 5] or claim.kind == EXISTENCE:
        count = len(claim.links)
        for key in ("axes", "origin", "point"):
            a, b = mine["frame"][key], other["frame"][key]
            if a != b and sorted((a, b)) != [-1, count + 1]:
                return f"a task with another frame: {key} {a}, not {b}"
    scale = claim.entries.get("scale")
    if scale is not None and scale != other["scale"]:
        return f"motions divided by {scale}, not {other['scale']}"
    return ""


def _other_place(claim: Claim, asked: Asked) -> str:
    if claim.kind == CHANGE:
        q = claim.entries["points"][0]
    else:
        q = claim.entries.get("q")
    if q is None:
        return f"a {claim.kind}, not a configuration"
    if asked.q is None or len(asked.q) != len(q) or not np.abs(np.array(q) - asked.q).max() <= _SAME:
        return f"q = {_values(q)}"
    return ""


def _other_path(claim: Claim, asked: Asked) -> str:
    if claim.kind not in (PATH, CHANGE):
        return f"a {claim.kind}, not a path"
    if asked.path is not None and asked.path.rows is not None:
        compare_rows(claim, asked.path)
    return ""


def _of_file(claim: Claim, path: AskedPath | None) -> tuple[str, ...]:
    """What a path was compared with; a file of joint values before anything was proven, the tip is compared here.

    Raises:
        Unproven: nothing says that it is the path of the user's file.
    """
    if path is None or (path.rows is None and path.poses is None):
        raise Unproven("this is proven of the control points of the certificate alone, which were compared with no "
                       "file: name it with --path")  # fmt: skip
    if path.file:
        name = f"{path.file!r} (SHA-256 {path.sha256})"
    else:
        name = "the given rows"
    if path.rows is not None:
        return (f"compared: {len(claim.entries['points']):,} control points with {name}",)
    assert path.poses is not None
    try:
        far = ToolPath(claim, path).compare()
    except Unproven as error:
        raise Unproven("this is proven of the control points of the certificate alone, which are not proven to be the "
                       f"tool path of {path.file!r}: {error}") from error  # fmt: skip
    return (f"compared: {len(path.poses):,} poses of {name}; tip within {far}",)


def _other_limits(claim: Claim, asked: Asked) -> str:
    stated = claim.entries.get("limits")
    if stated is None:
        return f"a {claim.kind}: joint limits play no part"
    if stated:
        within = "the joint limits"
    else:
        within = "the whole joint space"
    if stated == asked.limits:
        return ""
    return f"{within} of the arm"


def _prove(claim: Claim, work: Work) -> tuple[str, tuple[str, ...], tuple[str, ...], str]:
    """The claim in one sentence and entry by entry, what it rests on, and how it was proven.

    Raises:
        Unproven: it does not hold, or could not be confirmed.
    """
    if work.journal is not None and claim.kind != COVERING:
        raise Refused("a journal is kept of all boxes of a covering", where="journal", got=f"a {claim.kind}",
                      mend="leave it out")  # fmt: skip
    lines = _state_arm(claim)
    if claim.kind == EXISTENCE:
        sentence = (f"a configuration of rank below {claim.rank} exists within {claim.entries['radius']!r} of q, joint "
                    "by joint [rad, m]")  # fmt: skip
        return sentence, (*lines, f"q = {_values(claim.entries['q'])}"), *_prove_existence(claim)
    check = ClaimCheck(arm_of(claim), claim, work)
    assumed = [*_rows_left_out(claim), *_rank_is_generic(check)]
    if claim.tolerance is None:
        assumed.append("the arm has the numbers of the certificate: nothing is said of arms near it")
    how, near = "", ""
    if claim.tolerance is not None:
        near = f"; so it is for every arm within {claim.tolerance.length!r} m and {claim.tolerance.angle!r} rad of " \
               "this one, joint by joint"
    if claim.kind == BALL:
        verify_ball(check)
        sentence = f"no configuration within {claim.entries['radius']!r} rad of q has a rank below {claim.rank}" + near
        sentence += _free_joints(check)
        lines += [f"q = {_values(claim.entries['q'])}", *_state_scale(claim)]
    elif claim.kind == COVERING:
        tree, how = verify_covering(check)
        if not tree.free_boxes:
            raise Unproven("the covering leaves out no box: nothing is claimed")
        if claim.entries["limits"]:
            where = "joint limits"
        else:
            where = "joint space"
        sentence = (f"every configuration of the {where} with a rank below {claim.rank} is in one of the "
                    f"{tree.leaves:,} boxes of {claim.entries['file']!r}")  # fmt: skip
        lines += _state_ranges(claim)
    elif claim.kind == CHANGE:
        apart = verify_change(check)
        sentence = (f"{claim.name!r} is cuspidal: on the path it goes from one solution of a pose to another and keeps "
                    f"rank {claim.rank}; the other solution, of exactly the pose of the first row, is within "
                    f"{claim.entries['radius']!r} of the last row, joint by joint [rad, m]")  # fmt: skip
        if claim.entries["limits"]:
            sentence += "; all of it is inside the joint limits"
        lines += [*_state_path(claim, []), f"the poses of its two ends agree within {apart}"]
    elif claim.kind == SIGNS:
        sentence = (f"{claim.name!r} is not cuspidal: no path without a singularity leads from one solution of a pose "
                    f"to another, as each has signs of its own: {verify_signs(claim)}")  # fmt: skip
    else:
        sentence, stated = _prove_path(check, near)
        lines += stated
    return sentence, tuple(lines), tuple(assumed), how


def _free_joints(check: ClaimCheck) -> str:
    """The joints of a ball that may stand anywhere, in words; "" where there are none."""
    free = [str(j + 1) for j in range(check.claim.variables) if j not in check.arm.moving]
    if not free:
        return ""
    if len(free) == 1:
        which = f" {free[0]}"
    else:
        which = f"s {', '.join(free[:-1])} and {free[-1]}"
    return f"; joint{which} may stand anywhere"


def _prove_path(check: ClaimCheck, near: str) -> tuple[str, list[str]]:
    """The proven claim of a path, in one sentence and entry by entry; `near`: for which arms.

    Raises:
        Unproven: it does not hold, or could not be confirmed.
    """
    claim = check.claim
    others = verify_path(check)
    verify_distance(check)
    lines: list[str] = []
    sentence = f"every point of the path has rank {claim.rank}: it meets no singularity{near}"
    if others:
        crossings = sum(span["kind"] == CROSSING for span in others)
        sentence = (f"every point of the path outside {len(others)} spans has rank {claim.rank}; {crossings} of "
                    f"them hold a singular configuration (two signs of the determinant){near}")  # fmt: skip
    if "min_distance" in claim.entries:
        least = claim.entries["min_distance"]
        sentence += f"; no configuration of this arm nearer to the path than {least!r} rad has a rank below " \
                    f"{claim.rank}"
        lines += _state_scale(claim)
    return sentence, [*lines, *_state_path(claim, others)]


def _prove_existence(claim: Claim) -> tuple[tuple[str, ...], str]:
    """By Krawczyk's test, else in rational numbers.

    Raises:
        Unproven: by neither.
    """
    if claim.tolerance is not None:
        raise Unproven("a singular configuration is shown for the numbers of the arm, not for arms near it")
    try:
        verify_existence(arm_of(claim), claim)
        return tuple(_rows_left_out(claim)), "by intervals"
    except Unproven as error:
        why = str(error)
    try:
        verify_in_minors(claim)
    except Unproven as error:
        raise Unproven(f"{why}; {error}") from error
    return (), "in rational numbers"


def _state_arm(claim: Claim) -> list[str]:
    """Arm and task, entry by entry; the hash is over all numbers and names of the arm, the rest is for readers."""
    arm, (axes, origin, point) = claim.record["arm"], claim.frame
    lines = [f"arm {claim.name!r}, {len(claim.links)} joints; SHA-256 of its numbers, names and limits: {seal(arm)}"]
    for place, (joint, link) in enumerate(zip(arm["joints"], claim.links, strict=True), start=1):
        if link.kind == SLIDE:
            axis = link.screw[:3]
        else:
            axis = link.screw[3:]
        if link.kind == SLIDE:
            foot = ""
        else:
            foot = f" through {_short(np.cross(axis, link.screw[:3]))} m"
        if joint["follows"]:
            follows = f", follows {joint['follows']!r}"
        else:
            follows = ""
        limits = "" if follows else _state_limits(joint)
        lines.append(f"joint {place} {joint['name']!r}: {link.kind}, axis {_short(axis)}{foot}{follows}{limits}")
    name = claim.record["task"]["name"]
    lines.append(f"task {name!r}: {_rows(claim.rows)} in the axes of {_link(claim, axes)}, at the point "
                 f"{_values(point)} m of {_link(claim, origin)}; rank {claim.rank}")  # fmt: skip
    if claim.tolerance is not None:
        points = ", ".join(_values(row) for row in claim.tolerance.points.tolist())
        lines.append(f"near arms: joints turned about the points {points} [m]")
    return lines


def _state_limits(joint: Record) -> str:
    """Limits of a joint, ∞ where there is none at one end; "" where the certificate states none of any joint."""
    if "lower" not in joint:
        return ""
    lower, upper = joint["lower"], joint["upper"]
    if lower is None and upper is None:
        return ", no limits"
    return f", limits {'−∞' if lower is None else repr(lower)} … {'∞' if upper is None else repr(upper)}"


def _state_scale(claim: Claim) -> list[str]:
    return [f"motions of slides are divided by {claim.entries['scale'][j]!r} m" for j in claim.slides[:1]]


def _state_ranges(claim: Claim) -> list[str]:
    entries = claim.entries
    lines = []
    ranges = zip(entries["variables"], entries["lower"], entries["upper"], entries["turns"], strict=True)
    for j, low, high, turns in ranges:
        lines.append(f"joint {j} from {low!r} to {high!r}{', a whole turn' if turns else ''}")
    free = [str(j + 1) for j in range(claim.variables) if j + 1 not in entries["variables"]]
    if free:
        lines += [f"joints that stand anywhere: {', '.join(free)}"]
    return [*lines, f"corank {corank_of(claim)} or more; boxes of {entries['file']!r}, SHA-256 {entries['sha256']}"]


def _state_path(claim: Claim, others: list[Record]) -> list[str]:
    points, source = claim.entries["points"], claim.entries.get("path")
    count = (len(points) - 1) // claim.entries["degree"]
    lines = [
        f"path of {count} stretches of degree {claim.entries['degree']} from q = {_values(points[0])} to "
        f"q = {_values(points[-1])}; SHA-256 of its control points: {seal({'points': points.tolist()})}"
    ]
    if source is not None:
        lines.append(f"the certificate names the file {source['file']!r}, SHA-256 {source['sha256']!r}: not believed")
    for span in others:
        (a, s), (b, t) = span["from"], span["to"]
        what = "nothing is claimed"
        if span["kind"] == CROSSING:
            (c, u), (d, v) = span["bracket"]
            what = f"a singular configuration lies between {c + u!r} and {d + v!r} ({u!r} and {v!r} of stretches " \
                   f"{c + 1} and {d + 1})"
        lines.append(f"from {s!r} of stretch {a + 1} to {t!r} of stretch {b + 1}: {what}")
    return lines


def _values(values: Iterable[float]) -> str:
    return f"({', '.join(repr(float(x)) for x in values)})"


def _short(values: Iterable[float]) -> str:
    return f"({', '.join(f'{float(x) + 0.0:.6g}' for x in values)})"


def _rows(rows: Iterable[int]) -> str:
    return ", ".join(ROWS[row] for row in rows)


def _link(claim: Claim, number: int) -> str:
    count = len(claim.links)
    if number == 0:
        return "the base"
    if number in (-1, count + 1):
        return "the tip"
    return f"link {number}"


def arm_of(claim: Claim) -> Arm:
    """The arm as the certificate looks at it; of a translation, and in tool axes, the point must be that of the task.

    Raises:
        Unproven: the point is another.
    """
    f = flint()
    links = claim.links
    point: list[Interval] = [f.arb(x) for x in claim.point]
    if claim.whole_rows == [0, 1, 2] or claim.in_tool_axes:
        _, origin, local = claim.frame
        pose = claim.poses.get(origin)
        if pose is None or origin == 0:
            raise Unproven("a translation is that of a point of the last link")
        point = []
        for *turn, shift in pose[:3].tolist():
            point.append(sum((f.arb(x) * y for x, y in zip(turn, local, strict=True)), f.arb(shift)))
        links = links[: claim.link]
        point = _standing_still(claim, point)
    if claim.tolerance is not None:
        if claim.in_tool_axes:
            raise Unproven("rows in tool axes depend on how the tool is mounted: nothing is proven for near arms")
        if list(claim.rows) != claim.whole_rows:
            raise Unproven("rows that the task leaves out are zero for this arm, not for those near it")
        _check_points_on_axes(claim)
    if claim.in_tool_axes:
        axes = claim.home[:3, :3]
    else:
        axes = None
    return Arm(links, claim.variables, claim.link, point, f.arb(claim.length), axes)


def _standing_still(claim: Claim, point: list[Interval]) -> list[Interval]:
    """A point of the last link as the link of the certificate carries it: the joints behind turn about axes through it.

    Where an axis misses the point by some rounding, the point moves on a circle as small; all of it is enclosed. The
    columns of these joints are left out: without them the rank is no higher.

    Raises:
        Unproven: the point does not stand still in that link.
    """
    f = flint()
    drivers = [link.driver for link in claim.links]
    near = claim.tolerance is not None or claim.in_tool_axes
    for place in range(len(claim.links) - 1, claim.link - 1, -1):
        link = claim.links[place]
        off = _distance_from_axis(link, point)
        if near or link.kind != TURN or drivers.count(link.driver) > 1 or not off < _ON_AXIS * claim.length:
            raise Unproven(f"the point of the translation does not stand still in link {claim.link}")
        point = [x + f.arb(0, (2 * off).upper()) for x in point]
    return point


def _distance_from_axis(link: Link, point: list[Interval]) -> Interval:
    """Of a point from the axis of a joint that turns [m], at most."""
    f = flint()
    v = [f.arb(float(x)) for x in link.screw[:3]]
    w = [f.arb(float(x)) for x in link.screw[3:]]
    square = dot(w, w)
    foot = [x / square for x in cross(w, v)]
    moment = cross([x - y for x, y in zip(foot, point, strict=True)], w)
    return (dot(moment, moment).nonnegative_part() / square).sqrt().abs_upper()


def _check_points_on_axes(claim: Claim) -> None:
    assert claim.tolerance is not None
    for number, (link, point) in enumerate(zip(claim.links, claim.tolerance.points, strict=True), start=1):
        if link.kind == SLIDE:
            continue
        v, w = np.array(link.screw[:3]), np.array(link.screw[3:])
        if link.kind == SCREW:
            along = w * (v @ w) / (w @ w)
        else:
            along = np.zeros(3)
        off = float(np.linalg.norm(v - along - np.cross(point, w)))
        if not off < 1e-9 * (1.0 + float(np.linalg.norm(point))):
            raise Unproven(f"the point of joint {number} is not on its axis")


def _rows_left_out(claim: Claim) -> list[str]:
    """A task that takes some rows of a block: the others are measured to be zero, and the verdict says so.

    A sign proof of an arm with parallel axes proves it.
    """
    missing = [row for row in claim.whole_rows if row not in claim.rows]
    if not missing or claim.kind == SIGNS:
        return []
    f = flint()
    axes, origin, local = claim.frame
    poses = claim.poses
    if axes not in poses or origin not in poses:
        raise Unproven("the frame of a task that takes some rows only is that of the base, the last link or the tip")
    point = poses[origin][:3, :3] @ np.array(local) + poses[origin][:3, 3]
    arm = Arm(claim.links, claim.variables, len(claim.links), [f.arb(float(x)) for x in point], f.arb(1))
    turn = poses[axes][:3, :3].T
    zeros = set(missing)
    for row in missing:
        if row < 3:  # a translation left out stays the same one in every link's axes where all turns are about it
            zeros |= {3, 4, 5} - {3 + row}
    zero = sorted(zeros)
    largest, size = 0.0, 0.0
    for q in np.random.default_rng(0).uniform(-np.pi, np.pi, (8, claim.variables)):
        seen = arm.jacobian(arm.screws_over([f.arb(float(x)) for x in q], [f.arb(0)] * claim.variables)[0])
        seen = np.concatenate([turn @ seen[:3], turn @ seen[3:]])
        largest, size = max(largest, float(np.abs(seen[zero]).max())), max(size, float(np.abs(seen).max()))
    if largest > _VANISHES * size:
        raise Unproven("the task takes some rows only, and for this arm its rank depends on the axes")
    return [f"{_rows(missing)}, which the task leaves out, are zero for this arm (measured: {largest:.1g})"]


def _rank_is_generic(check: ClaimCheck) -> list[str]:
    """No configuration tried has a higher rank: else the certificate would be about another loss.

    A covering of a higher corank is about a rank that is lower by so much than the one almost everywhere.

    Raises:
        Unproven: one has.
    """
    f, claim, arm = flint(), check.claim, check.arm
    most = min(len(claim.whole_rows), claim.variables)
    rank = claim.rank + corank_of(claim) - 1
    if rank > most:
        raise Unproven(f"the rank is at most {most}, not {rank}")
    zero = [f.arb(0)] * claim.variables
    samples = np.random.default_rng(1).uniform(-1.0, 1.0, (_TRIED, claim.variables))
    places = [Region([f.arb(float(x)) for x in q], zero) for q in samples]
    if rank < most and any(arm.keeps_rank(place, claim.whole_rows, rank + 1) for place in places):
        raise Unproven(f"the rank is above {rank} almost everywhere")
    if corank_of(claim) > 1 and not any(arm.keeps_rank(place, claim.whole_rows, rank) for place in places):
        raise Unproven(f"the rank is below {rank} at {_TRIED} configurations: the corank is not {corank_of(claim)}")
    if rank < most:
        return [f"{rank} is the rank almost everywhere (no higher one at {_TRIED} configurations)"]
    return []
