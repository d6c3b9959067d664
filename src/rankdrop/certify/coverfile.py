"""Coverings as files: what was covered in one line of JSON, then the tree of bits; and chunks of one being made.

    RANKDROP COVER 1\\n
    {"arm": …, "sha256": …}\\n      the plan, counts, and the hash, keys sorted
    zlib of the payload            `BitTree.payload`

The hash is the SHA-256 of the plan as JSON (keys sorted, no blanks, without the arm's name), a line feed, and the
payload as it is before it is compressed: it does not depend on threads, on interruptions, or on the version of zlib.
"""

from __future__ import annotations

import hashlib
import json
import struct
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.bittree import BitTree, Masks, Shape, from_payload
from rankdrop.disk import replace_file
from rankdrop.errors import ResultFileError

MAGIC = b"RANKDROP COVER 1\n"
_HEAD = struct.Struct("<qqqq")  # of a chunk: boxes, masks, tested, freed
_LONGEST = 1 << 20  # bytes of the line of JSON
_LARGEST = 1 << 31  # bytes of a payload
_DEEPEST, _MOST_VARIABLES = 40, 6  # halvings of a range, and how many ranges


@dataclass(frozen=True, slots=True)
class Plan:
    """All that decides a covering.

    Attributes:
        robot, fingerprint: the arm's name and numbers.
        task, rows: name and rows of the task.
        rank: the generic one.
        method: "split determinant" or "enclosures".
        width: of leaves, as asked for [rad; slides divided by the length scale].
        limits: whether the ranges are the joint limits.
        variables: numbers from 1 of the joints covered; the others decide nothing.
        lower, upper: the ranges [rad, m].
        turns: for each, whether the range is one whole turn.
        depth: halvings of each range.
        top: level of the boxes that are made one by one.
        further: halvings by which leaves that are not proven are looked into.
        version: of rankdrop.
        corank: leaves hold every configuration of this corank or more.
    """

    robot: str
    fingerprint: str
    task: str
    rows: tuple[int, ...]
    rank: int
    method: str
    width: float
    limits: bool
    variables: tuple[int, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    turns: tuple[bool, ...]
    depth: tuple[int, ...]
    top: int
    further: int
    version: str
    corank: int = 1

    @property
    def kept(self) -> int:
        """The rank whose loss is looked for: a box that has it everywhere is free."""
        return self.rank - self.corank + 1

    @property
    def shape(self) -> Shape:
        """How boxes are halved."""
        return Shape(self.depth, self.top)

    def entries(self) -> dict[str, Any]:
        """As written; corank 1 is left out: files older than this number keep their hash."""
        return {key: value for key, value in asdict(self).items() if (key, value) != ("corank", 1)}

    def line(self) -> bytes:
        """As JSON of one line, the same for the same plan; the arm's name, which decides nothing, is left out."""
        record = {key: value for key, value in self.entries().items() if key != "robot"}
        return json.dumps(record, sort_keys=True, separators=(",", ":")).encode()


def digest(plan: Plan, payload: bytes) -> str:
    """SHA-256 of a plan and a payload; 64 hex digits."""
    return hashlib.sha256(plan.line() + b"\n" + payload).hexdigest()


def write_covering(path: Path, plan: Plan, tree: BitTree, tested: int, freed: int) -> str:
    """Write a finished covering, all or nothing, and return its hash.

    Raises:
        ResultFileError: it cannot be written.
    """
    payload = tree.payload()
    found = digest(plan, payload)
    record = {"plan": plan.entries(), "sha256": found, "tested": tested, "freed": freed, "bytes": len(payload),
              "leaves": tree.leaves, "proven": tree.proven_leaves}  # fmt: skip
    line = json.dumps(record, sort_keys=True).encode()
    try:
        replace_file(path, MAGIC + line + b"\n" + zlib.compress(payload, 6))
    except OSError as error:
        raise ResultFileError(f"cannot write: {error.strerror}", where=str(path)) from error
    return found


def load(path: Path) -> tuple[Plan, BitTree, int, int]:
    """Read a covering and check its hash: plan, tree, boxes tested, leaves freed by looking into them.

    Raises:
        ResultFileError: it cannot be read, is no covering, or was damaged or changed.
    """
    where = str(path)
    try:
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise ResultFileError("this is no covering", where=where, allowed="a file of `rankdrop cover --out`")
            line, packed = file.readline(_LONGEST), file.read(_LARGEST)
    except OSError as error:
        raise ResultFileError(f"cannot read: {error.strerror}", where=where) from error
    try:
        record = json.loads(line)
        plan = plan_from_entries(record["plan"])
        stream = zlib.decompressobj()
        _check_shape(plan)
        payload = stream.decompress(packed, min(int(record["bytes"]), _LARGEST) + 1)
        if not stream.eof or stream.unused_data:
            raise ValueError("it ends too soon, or too late")
        if plan.shape.trees > 8 * len(payload):
            raise ValueError("too few bytes")
        tree = from_payload(plan.shape, payload)
        found, told = (int(record["tested"]), int(record["freed"])), record["sha256"]
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError, zlib.error) as error:
        raise ResultFileError("the covering is damaged", where=where, got=str(error)) from error
    if digest(plan, payload) != told:
        raise ResultFileError("the covering was changed: its hash is another", where=where, got=told)
    return plan, tree, *found


def _check_shape(plan: Plan) -> None:
    """Refuse, before anything is made of them, numbers of boxes that no covering has."""
    depth = plan.depth
    if not isinstance(depth, tuple) or not 1 <= len(depth) <= _MOST_VARIABLES:
        raise ValueError(f"depth has one to {_MOST_VARIABLES} entries")
    if type(plan.corank) is not int or type(plan.rank) is not int or not 1 <= plan.corank <= plan.rank:
        raise ValueError("corank is from 1 to the rank")
    if not all(type(x) is int and 0 <= x <= _DEEPEST for x in (*depth, plan.top)) or plan.top >= plan.shape.levels:
        raise ValueError(f"halvings are 0 … {_DEEPEST}, and top is above the leaves")


def plan_from_entries(record: dict[str, Any]) -> Plan:
    """The plan that `Plan.entries` wrote."""
    lists: dict[str, Any] = {key: tuple(one) if isinstance(one, list) else one for key, one in record.items()}
    return Plan(**lists)


Batch = tuple[Masks, NDArray[np.int32], int, int]
"""Masks, (boxes, levels + 1) how many, boxes tested, leaves freed."""


def batch_to_bytes(batch: Batch) -> bytes:
    """A chunk as it is kept: counts, then sizes, then masks, all little-endian."""
    masks, sizes, tested, freed = batch
    body = sizes.astype("<i4").tobytes() + np.ascontiguousarray(masks).tobytes()
    return _HEAD.pack(len(sizes), len(masks), tested, freed) + body


def batch_from_bytes(content: bytes, shape: Shape) -> Batch:
    """What `batch_to_bytes` made of a chunk of such boxes.

    Raises:
        ValueError: it did not make this.
    """
    parts = shape.levels - shape.top + 1
    if len(content) < _HEAD.size:
        raise ValueError("a chunk of a covering that ends too soon")
    boxes, count, tested, freed = _HEAD.unpack_from(content)
    begin = _HEAD.size + boxes * parts * 4
    if len(content) != begin + count * shape.kind.itemsize:
        raise ValueError("a chunk of another covering")
    sizes = np.frombuffer(content[_HEAD.size : begin], "<i4").reshape(boxes, parts).astype(np.int32)
    return np.frombuffer(content[begin:], shape.kind), sizes, tested, freed
