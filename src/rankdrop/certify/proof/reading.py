"""A certificate as a file: what is in it, read with budgets, and what is wrong with one that cannot be read.

    {"schema": "rankdrop/certificate/1", "kind": "ball" | "path" | "covering" | "existence", "version": …,
     "arm": {"name", "joints": [{"name", "kind", "screw", "variable", "follows", "multiplier",
                                 "offset"}], "home", "last",
             "fingerprint"},
     "task": {"name", "rows", "frame": {"axes", "origin", "point"}}, "rank": 6,
     "view": {"link", "point", "length"}, "tolerance": null | {"length", "angle", "points"},
     "claim": {…}, "proof": {…}, "sha256": …}

The hash is the SHA-256 of the rest as JSON (keys sorted, no blanks): it tells damage. Who changes a certificate can
hash it anew; that the claim is proven again is what counts.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.certify.proof.intervals import SCREW, SLIDE, TURN, Link, Tolerance
from rankdrop.errors import ResultFileError, RobotError
from rankdrop.robot.model import Array, Joint, JointKind, Mimic, Robot, fingerprint

SCHEMA = "rankdrop/certificate/1"
BALL, PATH, COVERING, EXISTENCE = "ball", "path", "covering", "existence"
KINDS = (BALL, PATH, COVERING, EXISTENCE)
LARGEST = 1 << 27
"""Bytes of a certificate."""
_MOST_JOINTS = 32
_MOST_NUMBERS = 20_000_000
_BIGGEST = 1e9  # of a number in it [m, rad]: no arm has such lengths

Record = dict[str, Any]


class Damaged(Exception):
    """It was a certificate once: cut off, or changed."""


@dataclass(frozen=True, eq=False)
class Told:
    """What a certificate says, with everything of the right shape.

    Attributes:
        kind: one of `KINDS`.
        name: of the arm.
        links: its joints.
        variables: n.
        home, last: (4, 4) poses at q = 0 of the tip, and of the frame of the last link.
        model: fingerprint of the arm, as the certificate has it.
        task: name of the task.
        rows: of the task.
        frame: (axes, origin, point) of the task.
        rank: the rank that is kept, or lost.
        link, point, length: where the proof looks from: link, point at q = 0 in base coordinates [m], length [m].
        tolerance: of the model; None for the numbers themselves.
        claim, proof: as they stand.
        folder: where files are that it names.
        sha256: its hash.
    """

    kind: str
    name: str
    links: list[Link]
    variables: int
    home: Array
    last: Array
    model: str
    task: str
    rows: tuple[int, ...]
    frame: tuple[int, int, tuple[float, float, float]]
    rank: int
    link: int
    point: tuple[float, ...]
    length: float
    tolerance: Tolerance | None
    claim: Record
    proof: Record
    folder: Path
    sha256: str

    @property
    def whole_rows(self) -> list[int]:
        """Rows of translation and of rotation of which the task takes some."""
        blocks = ((0, 1, 2), (3, 4, 5))
        return [row for block in blocks if set(block) & set(self.rows) for row in block]


def sealed(record: Record) -> Record:
    """The record with its hash."""
    rest = {key: value for key, value in record.items() if key != "sha256"}
    return rest | {"sha256": seal(rest)}


def seal(record: Record) -> str:
    """SHA-256 of a record without its hash; 64 hex digits."""
    rest = {key: value for key, value in record.items() if key != "sha256"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def read_certificate(path: Path) -> Told:
    """Read a certificate.

    Raises:
        ResultFileError: it cannot be read, or never was one.
        Damaged: cut off, or its hash is another.
    """
    where = str(path)
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ResultFileError(f"cannot read: {reason}", where=where) from error
    if len(content) > LARGEST:
        raise ResultFileError("too large for a certificate", where=where, allowed=f"at most {LARGEST} bytes")
    record = _parsed(content, where)
    if not isinstance(record, dict) or record.get("schema") != SCHEMA:
        got = record.get("schema") if isinstance(record, dict) else type(record).__name__
        raise ResultFileError("this is no certificate", where=where, got=repr(got), allowed=f"schema {SCHEMA!r}")
    try:
        intact = record.get("sha256") == seal(record)
    except ValueError:  # 1e999 is read as infinity, which no certificate has
        intact = False
    if not intact:
        raise Damaged("the file was changed: its hash is another")
    try:
        return _told(record, path.parent)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise ResultFileError("the certificate is malformed", where=where, got=what) from error


def _parsed(content: bytes, where: str) -> Any:
    def refused(word: str) -> None:
        raise ValueError(f"{word} is no number")

    try:
        return json.loads(content, parse_constant=refused)
    except (ValueError, RecursionError) as error:
        if SCHEMA.encode() in content[:4096]:
            raise Damaged("the file is cut off or damaged: it is not JSON any more") from error
        raise ResultFileError("this is no certificate: it is not JSON", where=where, got=str(error)) from error


def _told(record: Record, folder: Path) -> Told:
    arm, task, view = record["arm"], record["task"], record["view"]
    kind = _one_of(record["kind"], KINDS, "kind")
    if not isinstance(arm["joints"], list) or not 1 <= len(arm["joints"]) <= _MOST_JOINTS:
        raise ValueError(f"joints: a list of 1 … {_MOST_JOINTS}")
    links = [_link(one) for one in arm["joints"]]
    variables = 1 + max(one.driver for one in links)
    if {one.driver for one in links} != set(range(variables)):
        raise ValueError("variables are numbered from 1 without a gap")
    home = _pose(arm["home"], "home")
    model = text(arm["fingerprint"], "fingerprint")
    if fingerprint(_robot(arm, links, home)) != model:
        raise Damaged("the numbers of the arm were changed: they are not those of its fingerprint")
    rows = tuple(whole(row, 0, 5, "rows") for row in task["rows"])
    if not rows or list(rows) != sorted(set(rows)):
        raise ValueError("rows: increasing, from 0 to 5")
    frame = task["frame"]
    point = vector(frame["point"], 3, "point of the task")
    return Told(
        kind=kind, name=text(arm["name"], "name"), links=links, variables=variables, home=home,
        last=_pose(arm["last"], "last"), model=model,
        task=text(task["name"], "task"), rows=rows,
        frame=(whole(frame["axes"], -1, len(links) + 1, "axes"), whole(frame["origin"], -1, len(links) + 1, "origin"),
               (point[0], point[1], point[2])),
        rank=whole(record["rank"], 1, 6, "rank"), link=whole(view["link"], 0, len(links), "link"),
        point=tuple(vector(view["point"], 3, "point of the view")),
        length=number(view["length"], 1e-9, _BIGGEST, "length of the view"),
        tolerance=_tolerance(record["tolerance"], len(links)), claim=_entries(record["claim"], "claim"),
        proof=_entries(record["proof"], "proof"), folder=folder, sha256=text(record["sha256"], "sha256"),
    )  # fmt: skip


def _link(record: Record) -> Link:
    kind = _one_of(record["kind"], (TURN, SLIDE, SCREW), "kind of a joint")
    screw = vector(record["screw"], 6, "screw")
    axis = screw[:3] if kind == SLIDE else screw[3:]
    if not abs(float(np.linalg.norm(axis)) - 1.0) < 1e-9:
        raise ValueError("the axis of a joint is a unit vector")
    if kind == SLIDE and any(screw[3:]):
        raise ValueError("a slide does not turn")
    if kind == TURN and abs(float(np.dot(screw[:3], screw[3:]))) > 1e-9 * (1.0 + float(np.linalg.norm(screw[:3]))):
        raise ValueError("a turning joint has no pitch")
    return Link(
        kind, tuple(screw), whole(record["variable"], 1, _MOST_JOINTS, "variable") - 1,
        number(record["multiplier"], -_BIGGEST, _BIGGEST, "multiplier"),
        number(record["offset"], -_BIGGEST, _BIGGEST, "offset"),
    )  # fmt: skip


def _robot(arm: Record, links: list[Link], home: Array) -> Robot:
    """The arm as data, to be known by its fingerprint."""
    joints = []
    for one, record in zip(links, arm["joints"], strict=True):
        follows = record["follows"]
        mimic = None if follows is None else Mimic(text(follows, "follows"), one.multiplier, one.offset)
        if mimic is None and (one.multiplier, one.offset) != (1.0, 0.0):
            raise ValueError("a joint that follows none has the multiplier 1 and the offset 0")
        joints.append(Joint(text(record["name"], "name"), JointKind(one.kind), np.array(one.screw), mimic=mimic))
    try:
        robot = Robot("arm", tuple(joints), home)
    except RobotError as error:
        raise ValueError(error.what) from error
    place = {joint.name: k for k, joint in enumerate(robot.variables)}
    drivers = [place[joint.mimic.leader if joint.mimic else joint.name] for joint in robot.joints]
    if drivers != [one.driver for one in links]:
        raise ValueError("a joint has another variable than the joint it follows")
    return robot


def _tolerance(record: Any, joints: int) -> Tolerance | None:
    if record is None:
        return None
    points = numbers(record["points"], (joints, 3), "points")
    return Tolerance(
        number(record["length"], 0.0, _BIGGEST, "length"), number(record["angle"], 0.0, 1.0, "angle"), points
    )


def _entries(value: Any, what: str) -> Record:
    if not isinstance(value, dict):
        raise ValueError(f"{what}: entries")
    return value


def _one_of(value: Any, allowed: tuple[str, ...], what: str) -> str:
    if not isinstance(value, str) or value not in allowed:
        raise ValueError(f"{what}: one of {', '.join(allowed)}")
    return value


def _pose(value: Any, what: str) -> Array:
    pose = numbers(value, (4, 4), what)
    if np.abs(pose[:3, :3].T @ pose[:3, :3] - np.eye(3)).max() > 1e-9 or (pose[3] != (0, 0, 0, 1)).any():
        raise ValueError(f"{what}: a rigid motion")
    return pose


def text(value: Any, what: str) -> str:
    """A text of reasonable length."""
    if not isinstance(value, str) or len(value) > 1000:
        raise ValueError(f"{what}: a text")
    return value


def number(value: Any, low: float, high: float, what: str) -> float:
    """A finite number from `low` to `high`."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high or abs(value) == inf:
        raise ValueError(f"{what}: a number from {low:g} to {high:g}")
    return float(value)


def whole(value: Any, low: int, high: int, what: str) -> int:
    """A whole number from `low` to `high`."""
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise ValueError(f"{what}: a whole number from {low} to {high}")
    return value


def vector(value: Any, size: int, what: str) -> list[float]:
    """So many finite numbers."""
    if not isinstance(value, list) or len(value) != size:
        raise ValueError(f"{what}: {size} numbers")
    return [number(one, -_BIGGEST, _BIGGEST, what) for one in value]


def numbers(value: Any, shape: tuple[int, int], what: str) -> Array:
    """A table of finite numbers; −1 in the shape is any count from 1."""
    if not isinstance(value, list) or not value or (shape[0] >= 0 and len(value) != shape[0]):
        raise ValueError(f"{what}: {'rows' if shape[0] < 0 else shape[0]} of {shape[1]} numbers")
    if len(value) * shape[1] > _MOST_NUMBERS:
        raise ValueError(f"{what}: too many numbers")
    return np.array([vector(row, shape[1], what) for row in value])


Progress = Callable[[int, int], None]
"""progress(done, all)."""


class Work:
    """What a check may cost, in enclosures, and what it has cost."""

    def __init__(self, most: int, progress: Progress | None) -> None:
        self.most, self.done, self._progress = most, 0, progress
        self.place = (0, 0)

    def spend(self) -> bool:
        """Count one enclosure; False where there are no more."""
        self.done += 1
        return self.done <= self.most

    def tell(self, done: int, total: int) -> None:
        """Say how far the check is."""
        self.place = (done, total)
        if self._progress is not None:
            self._progress(done, total)


class Unproven(Exception):
    """The claim could not be confirmed; the text says what and where."""
