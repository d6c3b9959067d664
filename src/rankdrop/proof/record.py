"""A certificate as a file: a closed record, read with budgets, and what is wrong with one that cannot be read.

    {"schema": "rankdrop/certificate/1", "kind": "ball" | "path" | "covering" | "existence" | "posture change" |
     "sign proof", "version": …, "units": …,
     "arm": {"name", "joints": [{"name", "kind", "screw", "variable", "follows", "multiplier", "offset", "lower",
                                 "upper"}], "home", "last", "fingerprint"},
     "task": {"name", "rows", "frame": {"axes", "origin", "point"}}, "rank": 6,
     "view": {"link", "point", "length"}, "tolerance": null | {"length", "angle", "points"},
     "claim": {…}, "proof": {…}, "sha256": …}

`view` and `proof` tell where to look and how to cut a region into parts; `version` and `units` are for people. All else
is the claim. An entry that is not in this list is refused. The hash is the SHA-256 of the rest as JSON (keys sorted, no
blanks): it reveals damage. Who changes a certificate can hash it anew; that the claim is proven again is what counts.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Record = dict[str, Any]
Reader = Callable[[Any, str], Any]
"""reader(value, where): the value, checked; ValueError else."""

SCHEMA = "rankdrop/certificate/1"
BALL, PATH, COVERING, EXISTENCE = "ball", "path", "covering", "existence"
CHANGE, SIGNS = "posture change", "sign proof"
MEET_12, PARALLEL_12 = "axes 1, 2 meet", "axes 1, 2 parallel"
MEET_23, PARALLEL_23 = "axes 2, 3 meet", "axes 2, 3 parallel"
THREE_PARALLEL, ORIENTATION, PLANAR = "three parallel", "orientation", "planar"
STRUCTURES = (MEET_12, PARALLEL_12, PARALLEL_23, MEET_23, THREE_PARALLEL, ORIENTATION, PLANAR)
"""Of arms of which each solution of a pose has signs of its own."""
SLIDE, TURN, SCREW = "prismatic", "revolute", "helical"
OPEN, CROSSING, CLEAR = "open", "crossing", "free"
"""Kinds of a span of a path."""
LARGEST = 1 << 27
"""Bytes of a certificate."""
TREE = 50_000_000
"""Letters of a tree of boxes."""
_MOST_JOINTS = 32
_MOST_NUMBERS = 20_000_000
_BIGGEST = 1e9  # of a number in it [m, rad]: no arm has such lengths

Progress = Callable[[int, int], None]
"""progress(done, all)."""


class Refused(Exception):
    """A file that cannot be used: what is wrong, where, what was read, what is allowed, how to fix it."""

    def __init__(self, what: str, **parts: Any) -> None:
        super().__init__(what)
        self.what, self.parts = what, parts


class Unproven(Exception):
    """The claim could not be confirmed; the text says what and where."""


@dataclass(frozen=True, eq=False)
class Link:
    """One joint of a chain, as a certificate has it.

    Attributes:
        kind: "revolute", "prismatic" or "helical".
        screw: six doubles (v; ω) at q = 0 in base coordinates. The axis has the direction of ω (of v for a slide),
            whatever its length, and goes through ω × v / |ω|²; the pitch of a helical joint is ω · v / |ω|².
        driver: place of the variable that moves it.
        multiplier, offset: its value is multiplier · q[driver] + offset.
    """

    kind: str
    screw: tuple[float, ...]
    driver: int
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class Tolerance:
    """How far the arms meant may be from the one of the numbers: every joint stands in the link before it so near.

    Attributes:
        length, angle: a joint is turned by at most `angle` about its point and moved by at most `length` [m, rad].
        points: (N, 3) the point of each joint at q = 0, in base coordinates [m].
    """

    length: float
    angle: float
    points: Array


@dataclass(frozen=True, eq=False)
class Claim:
    """What a certificate states, with everything of the right shape.

    Attributes:
        kind: "ball", "path", "covering", "existence", "posture change" or "sign proof".
        record: the certificate as it was read.
        links: joints of the arm.
        variables: n.
        home, last: (4, 4) poses at q = 0 of the tip, and of the frame of the last link.
        limits: (lower, upper) of each variable, ±inf where it has none; None where the certificate does not state them.
        rows: of the task.
        frame: (axes, origin, point) of the task.
        rank: the rank that is kept, or lost.
        link, point, length: where the proof looks from: link, point at q = 0 in base coordinates [m], length [m].
        tolerance: of the model; None for the numbers themselves.
        entries, proof: of the kind.
        folder: where files are that it names.
    """

    kind: str
    record: Record
    links: list[Link]
    variables: int
    home: Array
    last: Array
    limits: list[tuple[float, float]] | None
    rows: tuple[int, ...]
    frame: tuple[int, int, tuple[float, ...]]
    rank: int
    link: int
    point: tuple[float, ...]
    length: float
    tolerance: Tolerance | None
    entries: Record
    proof: Record
    folder: Path

    @property
    def name(self) -> str:
        """Name of the arm."""
        return str(self.record["arm"]["name"])

    @property
    def blocks(self) -> list[int]:
        """Rows of translation and of rotation of which the task takes some."""
        blocks = ((0, 1, 2), (3, 4, 5))
        return [row for block in blocks if set(block) & set(self.rows) for row in block]

    @property
    def in_tool_axes(self) -> bool:
        """Whether the task takes some rows in the axes of the tip, and the proof looks from the last link."""
        axes, origin, _ = self.frame
        tips = (-1, len(self.links) + 1)
        return self.blocks != list(self.rows) and axes in tips and origin in tips and self.link == len(self.links)

    @property
    def whole_rows(self) -> list[int]:
        """Rows whose rank is proven: those of the task in tool axes, else whole blocks."""
        if self.in_tool_axes:
            return list(self.rows)
        return self.blocks

    @property
    def slides(self) -> list[int]:
        """Places of the variables that slide."""
        kinds = [joint["kind"] for joint in self.record["arm"]["joints"] if joint["follows"] is None]
        return [place for place, kind in enumerate(kinds) if kind == SLIDE]

    @property
    def poses(self) -> dict[int, Array]:
        """Poses at q = 0 of the frames that the certificate has, by their numbers in the frame of a task."""
        joints = len(self.links)
        return {-1: self.home, joints + 1: self.home, joints: self.last, 0: np.eye(4)}


def with_hash(record: Record) -> Record:
    """The record with its hash."""
    return record | {"sha256": seal(record)}


def seal(record: Record) -> str:
    """SHA-256 of a record without its hash; 64 hex digits."""
    rest = {key: value for key, value in record.items() if key != "sha256"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def require(allowed: str, test: Callable[[Any], bool], made: Callable[[Any], Any] = lambda value: value) -> Reader:
    """What passes a test; `allowed` says which values do, `made` is what becomes of them."""

    def read(value: Any, where: str) -> Any:
        if not test(value):
            raise ValueError(f"{where}: {allowed}")
        return made(value)

    return read


def one_of(*words: str) -> Reader:
    """One of some words."""
    return require(f"one of {', '.join(words)}", lambda value: isinstance(value, str) and value in words)


def number(low: float = -_BIGGEST, high: float = _BIGGEST, above: float | None = None) -> Reader:
    """A finite number from `low` to `high`, or above a bound."""
    if above is None:
        begin, least = (f"from {low:g}", low)
    else:
        begin, least = (f"above {above:g}", np.nextafter(above, high))
    return require(f"a number {begin} to {high:g}",
                lambda value: type(value) in (int, float) and least <= value <= high, float)  # fmt: skip


def whole(low: int, high: int) -> Reader:
    """A whole number from `low` to `high`."""
    return require(f"a whole number from {low} to {high}", lambda value: type(value) is int and low <= value <= high)


def maybe(reader: Reader) -> Reader:
    """Null, or what the reader takes."""
    return lambda value, where: None if value is None else reader(value, where)


def listed(reader: Reader, low: int, high: int | None = None) -> Reader:
    """`low` to `high` items, exactly `low` where no `high` is given."""
    most = low if high is None else high

    def read(value: Any, where: str) -> list[Any]:
        if not isinstance(value, list) or not low <= len(value) <= most:
            raise ValueError(f"{where}: a list of {low if high is None else f'{low} … {most}'} items")
        return [reader(item, f"{where}, item {place}") for place, item in enumerate(value, start=1)]

    return read


def entries(readers: dict[str, Reader], **optional: Reader) -> Reader:
    """A record of these entries and no others."""

    def read(value: Any, where: str) -> Record:
        if not isinstance(value, dict):
            raise ValueError(f"{where}: entries")
        for key in value:
            if key not in readers and key not in optional:
                raise ValueError(f"{where}: there is no entry {str(key)[:100]!r}")
        missing = [key for key in readers if key not in value]
        if missing:
            raise ValueError(f"{where}: {missing[0]} is missing")
        return {key: (readers | optional)[key](item, f"{where}.{key}".lstrip(".")) for key, item in value.items()}

    return read


def numbers(value: Any, where: str) -> Array:
    """(M, n) table of finite numbers."""
    if isinstance(value, list) and value and isinstance(value[0], list):
        width = len(value[0])
    else:
        width = 0
    good = width and len(value) * width <= _MOST_NUMBERS
    if not good or any(not isinstance(row, list) or len(row) != width for row in value):
        raise ValueError(f"{where}: rows of as many numbers")
    for row in value:
        if not all(map(_is_number, row)):
            raise ValueError(f"{where}: numbers up to {_BIGGEST:g}")
    return np.array(value, dtype=np.float64)


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) <= _BIGGEST


def _pose(value: Any, where: str) -> Array:
    pose = numbers(value, where)
    if pose.shape != (4, 4) or np.abs(pose[:3, :3].T @ pose[:3, :3] - np.eye(3)).max() > 1e-9 or (
        pose[3] != (0, 0, 0, 1)
    ).any():
        raise ValueError(f"{where}: a rigid motion")
    return pose


def _place(value: Any, where: str) -> tuple[int, float]:
    stretch, share = listed(lambda one, _: one, 2)(value, where)
    return whole(0, 1 << 40)(stretch, where), number(0.0, 1.0)(share, where)


_line = require(
    "a text of one line", lambda value: isinstance(value, str) and len(value) <= 1000 and value.isprintable()
)
_tree = require(f"a text of at most {TREE:,} letters", lambda value: isinstance(value, str) and len(value) <= TREE)
_flag = require("true or false", lambda value: isinstance(value, bool))
_limit, _vector = maybe(number()), listed(number(), 3)
_joint = entries(
    {"name": _line, "kind": one_of(TURN, SLIDE, SCREW), "screw": listed(number(), 6),
     "variable": whole(1, _MOST_JOINTS), "follows": maybe(_line), "multiplier": number(), "offset": number()},
    lower=_limit, upper=_limit,
)  # fmt: skip
_span = entries({"from": _place, "to": _place, "kind": one_of(CLEAR, CROSSING, OPEN)}, bracket=listed(_place, 2))
_radius, _joints = number(0.0, 4.0, above=0.0), listed(number(), 1, _MOST_JOINTS)
_scale = listed(number(1e-9, _BIGGEST), 1, _MOST_JOINTS)
_nothing = entries({})
_KINDS = {
    BALL: (entries({"q": _joints, "radius": _radius, "scale": _scale}), entries({"side": _radius, "tree": _tree})),
    PATH: (
        entries({"verdict": one_of(CLEAR, "met"), "degree": whole(1, 9), "points": numbers,
                 "spans": listed(_span, 0, 1_000_000)},
                min_distance=_radius, scale=_scale, path=entries({"file": _line, "sha256": _line})),
        _nothing,
    ),
    COVERING: (
        entries({"file": _line, "sha256": _line, "variables": listed(whole(1, _MOST_JOINTS), 1, 6),
                 "lower": _joints, "upper": _joints, "turns": listed(_flag, 1, 6), "limits": _flag},
                corank=whole(1, 6)),
        _nothing,
    ),
    EXISTENCE: (entries({"q": _joints, "radius": number(0.0, 1.0)}), _nothing),
    CHANGE: (
        entries({"degree": whole(1, 1), "points": numbers, "radius": number(0.0, 1.0, above=0.0), "limits": _flag}),
        _nothing,
    ),
    SIGNS: (entries({"structure": one_of(*STRUCTURES)}), _nothing),
}  # fmt: skip
_certificate = entries(
    {
        "schema": one_of(SCHEMA), "kind": one_of(*_KINDS), "version": _line,
        "arm": entries({"name": _line, "joints": listed(_joint, 1, _MOST_JOINTS), "home": _pose, "last": _pose,
                        "fingerprint": _line}),
        "task": entries({"name": _line, "rows": listed(whole(0, 5), 1, 6),
                         "frame": entries({"axes": whole(-1, _MOST_JOINTS + 1), "origin": whole(-1, _MOST_JOINTS + 1),
                                           "point": _vector})}),
        "rank": whole(1, 6), "view": entries({"link": whole(0, _MOST_JOINTS), "point": _vector,
                                              "length": number(1e-9, _BIGGEST)}),
        "tolerance": maybe(entries({"length": number(0.0, _BIGGEST), "angle": number(0.0, 1.0), "points": numbers})),
        "claim": lambda value, where: value, "proof": lambda value, where: value, "sha256": _line,
    },
    units=entries(dict.fromkeys(("angle", "length", "time", "joint", "distance"), _line)),
)  # fmt: skip


def read_certificate(path: Path) -> Claim:
    """Read a certificate.

    Raises:
        Refused: it cannot be read, is malformed, or never was one.
        Unproven: cut off, or its hash is another.
    """
    where = str(path)
    if path.exists() and not path.is_file():
        raise Refused("this is not a file", where=where)
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, OSError):
            reason = error.strerror
        else:
            reason = str(error)
        raise Refused(f"cannot read: {reason}", where=where) from error
    if len(content) > LARGEST:
        raise Refused("too large for a certificate", where=where, allowed=f"at most {LARGEST} bytes")
    record = _parse_json(content, where)
    if not isinstance(record, dict) or record.get("schema") != SCHEMA:
        if isinstance(record, dict):
            got = record.get("schema")
        else:
            got = type(record).__name__
        raise Refused("this is no certificate", where=where, got=repr(got)[:200], allowed=f"schema {SCHEMA!r}")
    try:
        intact = record.get("sha256") == seal(record)
    except ValueError:  # 1e999 is read as infinity, which no certificate has
        intact = False
    if not intact:
        raise Unproven("the file was changed: its hash is another")
    try:
        return claim_of(record, path.parent)
    except (ValueError, OverflowError) as error:
        raise Refused("the certificate is malformed", where=where, got=str(error)) from error


def _parse_json(content: bytes, where: str) -> Any:
    def refuse(word: str) -> None:
        raise ValueError(f"{word} is no number")

    try:
        return json.loads(content, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        if SCHEMA.encode() in content[:4096]:
            raise Unproven("the file is cut off or damaged: it is not JSON any more") from error
        raise Refused("this is no certificate: it is not JSON", where=where, got=str(error)) from error


def claim_of(record: Record, folder: Path) -> Claim:
    """The claim of a certificate.

    Raises:
        ValueError: it is malformed.
        Unproven: the numbers of the arm are not those of its fingerprint.
    """
    read = _certificate(record, "")
    kind, arm, task, view = read["kind"], read["arm"], read["task"], read["view"]
    claimed, proof = (reader(read[key], key) for reader, key in zip(_KINDS[kind], ("claim", "proof"), strict=True))
    links = [_link(joint) for joint in arm["joints"]]
    variables, count = _variables(arm["joints"], links), len(links)
    if fingerprint(arm, links) != arm["fingerprint"]:
        raise Unproven("the numbers of the arm were changed: they are not those of its fingerprint")
    rows, near, frame = tuple(task["rows"]), read["tolerance"], task["frame"]
    if list(rows) != sorted(set(rows)):
        raise ValueError("rows: increasing, from 0 to 5")
    if max(frame["axes"], frame["origin"]) > count + 1 or view["link"] > count:
        raise ValueError(f"links are numbered from 0 to {count}")
    for key in ("q", "scale"):
        if len(claimed.get(key) or range(variables)) != variables:
            raise ValueError(f"claim.{key}: {variables} numbers")
    if near is not None and near["points"].shape != (count, 3):
        raise ValueError(f"tolerance.points: {count} points")
    return Claim(
        kind, record, links, variables, arm["home"], arm["last"], _limits(arm["joints"]), rows,
        (frame["axes"], frame["origin"], tuple(frame["point"])), read["rank"], view["link"], tuple(view["point"]),
        view["length"], None if near is None else Tolerance(**near), claimed, proof, folder,
    )  # fmt: skip


def _link(joint: Record) -> Link:
    kind, screw = joint["kind"], joint["screw"]
    axis = screw[:3] if kind == SLIDE else screw[3:]
    if not abs(float(np.linalg.norm(axis)) - 1.0) < 1e-9:
        raise ValueError("the axis of a joint is a unit vector")
    if kind == SLIDE and any(screw[3:]):
        raise ValueError("a slide does not turn")
    if kind == TURN and abs(float(np.dot(screw[:3], screw[3:]))) > 1e-9 * (1.0 + float(np.linalg.norm(screw[:3]))):
        raise ValueError("a turning joint has no pitch")
    if joint["follows"] is None and (joint["multiplier"], joint["offset"]) != (1.0, 0.0):
        raise ValueError("a joint that follows none has the multiplier 1 and the offset 0")
    return Link(kind, tuple(screw), joint["variable"] - 1, joint["multiplier"], joint["offset"])


def _variables(joints: list[Record], links: list[Link]) -> int:
    """How many variables there are: one for each joint that follows none, in their order."""
    leaders = [joint["name"] for joint in joints if joint["follows"] is None]
    names = [joint["follows"] or joint["name"] for joint in joints]
    if len({joint["name"] for joint in joints}) < len(joints) or not set(names) <= set(leaders):
        raise ValueError("joints have names of their own, and follow one that follows none")
    if [leaders.index(name) for name in names] != [link.driver for link in links]:
        raise ValueError("a joint has another variable than the joint it follows")
    return len(leaders)


def _limits(joints: list[Record]) -> list[tuple[float, float]] | None:
    stated: set[bool] = set()
    for joint in joints:
        stated |= {key in joint for key in ("lower", "upper")}
    if len(stated) > 1:
        raise ValueError("all joints have an entry for both limits, or none has")
    if stated != {True}:
        return None
    limits = []
    for joint in joints:
        if joint["follows"] is not None:
            continue
        low = -np.inf if joint["lower"] is None else joint["lower"]
        high = np.inf if joint["upper"] is None else joint["upper"]
        if not low <= high:
            raise ValueError("lower limit above upper limit")
        limits.append((low, high))
    return limits


def fingerprint(arm: Record, links: list[Link]) -> str:
    """SHA-256 of the kinds of an arm's joints, of what they follow, and of the numbers that decide its Jacobian."""
    names = [joint["name"] for joint in arm["joints"]]
    follows = [joint["follows"] for joint in arm["joints"]]
    structure = [(link.kind, -1 if leader is None else names.index(leader))
                 for link, leader in zip(links, follows, strict=True)]  # fmt: skip
    parts = [*(link.screw for link in links), arm["home"].reshape(-1)]
    parts += [(link.multiplier, link.offset) for link, leader in zip(links, follows, strict=True) if leader is not None]
    return hashlib.sha256(repr(structure).encode() + (np.concatenate(parts) + 0.0).astype("<f8").tobytes()).hexdigest()


class Work:
    """What a check may cost, and what it has cost.

    Args:
        most: enclosures.
        progress: progress(done, all).
        sample: of a covering, look at so many of the boxes it leaves out, chosen at random; None for all.
        every: of a covering, look at all of them, whatever `most` is.
        journal: of a covering, how many are proven is kept in this file, and read from it.
    """

    def __init__(
        self, most: int, progress: Progress | None = None, *, sample: int | None = None, every: bool = False,
        journal: Path | None = None,
    ) -> None:  # fmt: skip
        self.most, self.done, self._progress = most, 0, progress
        self.sample, self.every, self.journal = sample, every, journal
        self.place = (0, 0)

    def spend(self) -> bool:
        """Count one enclosure; False where there are no more."""
        self.done += 1
        return self.done <= self.most

    def report(self, done: int, count: int) -> None:
        """Say how far the check is."""
        self.place = (done, count)
        if self._progress is not None:
            self._progress(done, count)
