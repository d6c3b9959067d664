"""Coverings as files: what was covered in one line of JSON, then the tree of bits; and the journal of one being made.

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
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.bittree import BitTree, Masks, Shape, from_payload
from rankdrop.disk import replace_file
from rankdrop.errors import ResultFileError

MAGIC = b"RANKDROP COVER 1\n"
_JOURNAL = b"RANKDROP COVER JOURNAL 1\n"
_RECORD = struct.Struct("<4sqqqqqI")  # mark, first box, boxes, masks, tested, freed, CRC of what follows
_MARK = b"PART"
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
        plan = _plan(record["plan"])
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


def _plan(record: dict[str, Any]) -> Plan:
    lists: dict[str, Any] = {key: tuple(one) if isinstance(one, list) else one for key, one in record.items()}
    return Plan(**lists)


Batch = tuple[Masks, NDArray[np.int32], int, int]
"""Masks, (boxes, levels + 1) how many, boxes tested, leaves freed."""


class Journal:
    """Parts of a covering that are finished, in a file that survives whoever writes it.

    A record that was cut off, by a kill or a full disk, is dropped when the file is opened again.
    """

    def __init__(self, file: IO[bytes], plan: Plan, start: int) -> None:
        self._file, self._plan, self._start = file, plan, start

    @classmethod
    def open(cls, path: Path, plan: Plan) -> Journal:
        """Open the journal of a covering, or begin one.

        Raises:
            ResultFileError: it cannot be opened, is no journal, or that of another covering.
        """
        head = _JOURNAL + plan.line() + b"\n"
        try:
            file = path.open("r+b" if path.exists() and path.stat().st_size else "w+b")
            there = file.read(len(head))
            if not there.startswith(head[: len(there)]) or (len(there) < len(head) and there[-1:] == b"\n" and there):
                file.close()
                raise ResultFileError(
                    "this is the journal of another covering, or no journal", where=str(path),
                    mend="name another file, or delete this one",
                )
            if len(there) < len(head):
                file.seek(0)
                file.truncate()
                file.write(head)
                file.flush()
        except OSError as error:
            raise ResultFileError(f"cannot open the journal: {error.strerror}", where=str(path)) from error
        return cls(file, plan, len(head))

    def read(self) -> dict[int, Batch]:
        """The finished parts, by the number of their first box; the file ends behind the last of them from now on."""
        found: dict[int, Batch] = {}
        self._file.seek(self._start)
        end = self._start
        while (made := self._record()) is not None:
            begin, batch = made
            found[begin] = batch
            end = self._file.tell()
        self._file.seek(end)
        self._file.truncate()
        return found

    def _record(self) -> tuple[int, Batch] | None:
        head = self._file.read(_RECORD.size)
        if len(head) < _RECORD.size:
            return None
        mark, begin, boxes, count, tested, freed, told = _RECORD.unpack(head)
        shape = self._plan.shape
        parts = shape.levels - shape.top + 1
        size = boxes * parts * 4 + count * shape.kind.itemsize
        if mark != _MARK or not 0 <= size <= _LARGEST:
            return None
        body = self._file.read(size)
        if len(body) < size or zlib.crc32(head[:-4] + body) != told:
            return None
        sizes = np.frombuffer(body[: boxes * parts * 4], "<i4").reshape(boxes, parts)
        return begin, (np.frombuffer(body[boxes * parts * 4 :], shape.kind), sizes, tested, freed)

    def add(self, begin: int, batch: Batch) -> None:
        """Write one finished part.

        Raises:
            ResultFileError: it cannot be written.
        """
        masks, sizes, tested, freed = batch
        body = sizes.astype("<i4").tobytes() + masks.astype(self._plan.shape.kind).tobytes()
        head = _RECORD.pack(_MARK, begin, len(sizes), len(masks), tested, freed, 0)[:-4]
        try:
            self._file.write(head + struct.pack("<I", zlib.crc32(head + body)) + body)
            self._file.flush()
        except OSError as error:
            raise ResultFileError(f"cannot write the journal: {error.strerror}", where=self._file.name) from error

    def close(self) -> None:
        """Close the file."""
        self._file.close()

