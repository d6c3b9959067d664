"""Coverings: boxes of a joint space that are not proven free, as a tree of bits, and the file that holds one.

A box of level ℓ is one of Π 2^min(ℓ, depth_j) equal ones, halved along every variable that is not yet as narrow as a
leaf. A box that is not free all through has a mask: bit c is set where child c is not free. c counts the children in
row-major order, the first variable slowest; the bit of a variable that is not halved stays 0. Masks are stored level by
level, the boxes of a level in the order of their own bits in the level above; the leaves that are proven to hold a
singularity have a second set of masks, next to those of the level above the leaves. The file:

    RANKDROP COVER 1\\n
    {"plan": …, "sha256": …}\\n     the plan, counts, and the hash, keys sorted
    zlib of the payload            a bit for each box of level `top`, masks level by level, masks of the proven leaves

The hash is the SHA-256 of the plan as JSON (keys sorted, no blanks, without the arm's name), a line feed, and the
payload as it is before it is compressed: it does not depend on threads, on interruptions, or on the version of zlib.
"""

from __future__ import annotations

import hashlib
import json
import os
import zlib
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from math import prod
from pathlib import Path
from typing import IO, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from rankdrop.proof.record import Refused

Masks = NDArray[np.unsignedinteger]
Flags = NDArray[np.bool_]
Cells = NDArray[np.int32]

MAGIC = b"RANKDROP COVER 1\n"
Content = TypeVar("Content")
_ONES = np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1).sum(axis=1, dtype=np.uint8)  # bits of a byte
_CHUNK = 1 << 12  # boxes whose children are looked at together
_PIECE = 1 << 20  # masks checked, or bytes unpacked, together
_LONGEST = 1 << 20  # bytes of the line of JSON
_DEEPEST, _MOST_VARIABLES, _MOST_TREES = 40, 6, 1 << 20  # halvings of a range, ranges, boxes of the level `top`
_LARGEST = 1 << 31  # bytes of a payload
_SMALL, _RATIO = 1 << 26, 200  # a payload has at most so many bytes, and so many more for each byte of the file


@dataclass(frozen=True, slots=True)
class BoxShape:
    """How boxes are halved.

    Attributes:
        depth: (d,) halvings of each variable down to a leaf.
        top: level whose boxes are the roots of trees that are made, and stored, one by one.
    """

    depth: tuple[int, ...]
    top: int

    @property
    def variables(self) -> int:
        """d."""
        return len(self.depth)

    @property
    def levels(self) -> int:
        """Level of the leaves."""
        return max(1, *self.depth)

    def cells(self, level: int) -> tuple[int, ...]:
        """How many boxes of a level there are along each variable."""
        return tuple(1 << min(level, depth) for depth in self.depth)

    def halved(self, level: int) -> tuple[int, ...]:
        """1 for the variables along which the boxes of `level` are halves of those above, else 0."""
        return tuple(int(depth >= level) for depth in self.depth)

    @property
    def trees(self) -> int:
        """Number of boxes of the level `top`."""
        return prod(self.cells(self.top))

    @property
    def leaves(self) -> int:
        """Number of boxes of the last level."""
        return prod(self.cells(self.levels))

    @property
    def kind(self) -> np.dtype[np.unsignedinteger]:
        """Type of a mask: 2^d bits, in whole bytes."""
        return np.dtype(f"<u{max(1, (1 << self.variables) // 8)}")

    @property
    def largest(self) -> int:
        """Bytes of a payload in which no box at all is free."""
        masks = [prod(self.cells(level)) for level in range(self.top, self.levels)]
        return (self.trees + 7) // 8 + (sum(masks) + masks[-1]) * self.kind.itemsize

    def children(self, cells: Cells, masks: Masks, level: int) -> tuple[Cells, NDArray[np.int64]]:
        """(M, d) boxes of `level` whose bits are set in masks (N,) of boxes (N, d), and (M,) whose they are."""
        parent, child = np.nonzero(bits(masks, self.variables))
        children = cells[parent] << np.array(self.halved(level), dtype=np.int32)
        for j in range(self.variables):
            children[:, j] += (child >> (self.variables - 1 - j)) & 1
        return children, parent

    def roots(self, numbers: NDArray[np.int64]) -> Cells:
        """(M, d) boxes of the level `top` by their numbers."""
        return np.stack(np.unravel_index(numbers, self.cells(self.top)), axis=1).astype(np.int32)


def bits(masks: Masks, variables: int) -> Flags:
    """(N, 2^d) the bits of masks (N,)."""
    return np.unpackbits(_bytes(masks), axis=1, bitorder="little", count=1 << variables).view(np.bool_)


def counts(masks: Masks) -> NDArray[np.int64]:
    """(N,) how many bits are set in each mask."""
    return np.asarray(_ONES[_bytes(masks)].sum(axis=1, dtype=np.int64))


def total(masks: Masks) -> int:
    """How many bits are set in all masks."""
    return sum(int(counts(part).sum()) for part in _pieces(masks))


def pack_bits(flags: Flags, kind: np.dtype[np.unsignedinteger]) -> Masks:
    """Masks (N,) of the bits (N, 2^d)."""
    parts = np.packbits(flags, axis=1, bitorder="little")
    wide = np.zeros((len(flags), kind.itemsize), dtype=np.uint8)
    wide[:, : parts.shape[1]] = parts
    return wide.reshape(-1).view(kind)


def allowed_children(shape: BoxShape, level: int) -> np.unsignedinteger:
    """Mask of the children that a box above `level` has."""
    halved, d = shape.halved(level), shape.variables
    flags = [all(halved[j] or not (child >> (d - 1 - j)) & 1 for j in range(d)) for child in range(1 << d)]
    mask: np.unsignedinteger = pack_bits(np.array([flags]), shape.kind)[0]
    return mask


def _bytes(masks: Masks) -> NDArray[np.uint8]:
    return np.ascontiguousarray(masks).view(np.uint8).reshape(len(masks), masks.dtype.itemsize)


def _pieces(masks: Masks) -> Iterator[Masks]:
    return (masks[begin : begin + _PIECE] for begin in range(0, len(masks), _PIECE))


@dataclass(frozen=True, eq=False)
class BitTree:
    """The boxes that are left.

    Attributes:
        shape: how boxes are halved.
        finished: (trees,) whether each tree was made; the others count as not free.
        roots: (trees,) whether anything is left of each tree; True where it was not made.
        masks: those of level `top` to that above the leaves.
        proven: masks of the leaves that are proven to hold a singularity, next to the last of `masks`.
    """

    shape: BoxShape
    finished: Flags
    roots: Flags
    masks: tuple[Masks, ...]
    proven: Masks

    @property
    def complete(self) -> bool:
        """Every tree was made."""
        return bool(self.finished.all())

    @cached_property
    def leaves(self) -> int:
        """Number of leaves that are not proven free, those of trees that were not made included."""
        return total(self.masks[-1]) + int((~self.finished).sum()) * (self.shape.leaves // self.shape.trees)

    @cached_property
    def proven_leaves(self) -> int:
        """Number of leaves that are proven to hold a singularity."""
        return total(self.proven)

    @property
    def free_share(self) -> float:
        """Share of the volume that is proven free."""
        return 1.0 - self.leaves / self.shape.leaves

    def walk(self, size: int = _CHUNK) -> Iterator[tuple[int, Cells, Masks, int]]:
        """Boxes with their masks, depth first, at most `size` at a time: few are in memory, however many there are.

        Yields:
            level of the children, (M, d) boxes of the level above, (M,) their masks, place of the first of the masks.
        """
        at = [0] * len(self.masks)

        def below(level: int, cells: Cells) -> Iterator[tuple[int, Cells, Masks, int]]:
            row = level - self.shape.top - 1
            begin = at[row]
            at[row] += len(cells)
            masks = self.masks[row][begin : at[row]]
            yield level, cells, masks, begin
            if level < self.shape.levels:
                kept = self.shape.children(cells, masks, level)[0]
                for part in range(0, len(kept), size):
                    yield from below(level + 1, kept[part : part + size])

        for begin in range(0, self.shape.trees, _PIECE):
            made = self.roots[begin : begin + _PIECE] & self.finished[begin : begin + _PIECE]
            numbers = begin + np.flatnonzero(made)
            for part in range(0, len(numbers), size):
                yield from below(self.shape.top + 1, self.shape.roots(numbers[part : part + size]))

    def parts(self) -> Iterator[tuple[Cells, Flags]]:
        """The leaves of trees that were made, part by part: (M, d) boxes of the last level, (M,) whether proven."""
        shape = self.shape
        for level, cells, masks, begin in self.walk():
            if level == shape.levels:
                proven = bits(self.proven[begin : begin + len(masks)], shape.variables)
                yield shape.children(cells, masks, level)[0], proven[bits(masks, shape.variables)]

    def free(self) -> Iterator[tuple[int, Cells]]:
        """(level, (M, d) boxes) that are left out, as large as they can be, part by part."""
        shape = self.shape
        for begin in range(0, shape.trees, _PIECE):
            yield shape.top, shape.roots(begin + np.flatnonzero(~self.roots[begin : begin + _PIECE]))
        for level, cells, masks, _ in self.walk():
            yield level, shape.children(cells, ~masks & allowed_children(shape, level), level)[0]

    @cached_property
    def free_boxes(self) -> int:
        """Number of the boxes that `free` gives."""
        count = int((~self.roots).sum())
        for level, masks in enumerate(self.masks, start=self.shape.top + 1):
            count += len(masks) * 2 ** sum(self.shape.halved(level)) - total(masks)
        return count

    def payload(self) -> Iterator[memoryview]:
        """Roots as bits, masks level by level, masks of the proven leaves; little-endian."""
        yield np.packbits(self.roots, bitorder="little").data
        yield from (_bytes(masks).reshape(-1).data for masks in (*self.masks, self.proven))


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
    def kept_rank(self) -> int:
        """The rank whose loss is looked for: a box that has it everywhere is free."""
        return self.rank - self.corank + 1

    @property
    def shape(self) -> BoxShape:
        """How boxes are halved."""
        return BoxShape(self.depth, self.top)

    def entries(self) -> dict[str, Any]:
        """As written; corank 1 is left out: files older than this number keep their hash."""
        return {key: value for key, value in asdict(self).items() if (key, value) != ("corank", 1)}

    def line(self) -> bytes:
        """As JSON of one line, the same for the same plan; the arm's name, which decides nothing, is left out."""
        record = {key: value for key, value in self.entries().items() if key != "robot"}
        return json.dumps(record, sort_keys=True, separators=(",", ":")).encode()


def plan_from_entries(record: dict[str, Any]) -> Plan:
    """The plan that `Plan.entries` wrote."""
    lists: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in record.items()}
    return Plan(**lists)


def digest(plan: Plan, tree: BitTree) -> str:
    """SHA-256 of a plan and its boxes; 64 hex digits."""
    hashed = hashlib.sha256(plan.line() + b"\n")
    for part in tree.payload():
        hashed.update(part)
    return hashed.hexdigest()


def covering_bytes(plan: Plan, tree: BitTree, tested: int, freed: int) -> bytes:
    """The file of a finished covering."""
    size = sum(len(part) for part in tree.payload())
    record = {"plan": plan.entries(), "sha256": digest(plan, tree), "tested": tested, "freed": freed, "bytes": size,
              "leaves": tree.leaves, "proven": tree.proven_leaves}  # fmt: skip
    content = _compress_level(tree, 6)
    if size > _allowed_bytes(plan.shape, len(content)):  # so regular that a reader would take it for a bomb
        content = _compress_level(tree, 0)
    return MAGIC + json.dumps(record, sort_keys=True).encode() + b"\n" + content


def _compress_level(tree: BitTree, level: int) -> bytes:
    stream = zlib.compressobj(level)
    return b"".join([*map(stream.compress, tree.payload()), stream.flush()])


def _allowed_bytes(shape: BoxShape, size: int) -> int:
    """Bytes that so many may be unpacked to: what the plan has room for, and no more than the file pays for."""
    return min(shape.largest, _SMALL + _RATIO * size, _LARGEST)


def load_plan(path: Path) -> tuple[Plan, dict[str, Any]]:
    """The plan of a covering file and its counts, without the boxes.

    Raises:
        Refused: it cannot be read, or is no covering.
    """
    return _read_file(path, _head)


def load(path: Path) -> tuple[Plan, BitTree, int, int]:
    """Read a covering and check its hash: plan, tree, boxes tested, leaves freed by looking into them.

    Raises:
        Refused: it cannot be read, is no covering, or was damaged or changed.
    """
    return _read_file(path, _content)


def _read_file(path: Path, reader: Callable[[IO[bytes], str], Content]) -> Content:
    where = str(path)
    if path.exists() and not path.is_file():
        raise Refused("this is not a file", where=where)
    try:
        with path.open("rb") as file:
            return reader(file, where)
    except OSError as error:
        raise Refused(f"cannot read: {error.strerror}", where=where) from error
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError, zlib.error) as error:
        raise Refused("the covering is damaged", where=where, got=str(error)) from error


def _head(file: IO[bytes], where: str) -> tuple[Plan, dict[str, Any]]:
    if file.read(len(MAGIC)) != MAGIC:
        raise Refused("this is no covering", where=where, allowed="a file of `rankdrop cover --out`")
    record = json.loads(file.readline(_LONGEST))
    plan = plan_from_entries(record["plan"])
    check_plan(plan)
    return plan, {key: int(record[key]) for key in ("tested", "freed", "leaves")} | {"sha256": record["sha256"]}


def check_plan(plan: Plan) -> None:
    """Refuse, before anything is made of them, numbers of boxes that no covering has.

    Raises:
        ValueError: of depth, top or corank.
    """
    depth = plan.depth
    if not isinstance(depth, tuple) or not 1 <= len(depth) <= _MOST_VARIABLES:
        raise ValueError(f"depth has one to {_MOST_VARIABLES} entries")
    if type(plan.corank) is not int or type(plan.rank) is not int or not 1 <= plan.corank <= plan.rank:
        raise ValueError("corank is from 1 to the rank")
    if not all(type(x) is int and 0 <= x <= _DEEPEST for x in (*depth, plan.top)) or plan.top >= plan.shape.levels:
        raise ValueError(f"halvings are 0 … {_DEEPEST}, and top is above the leaves")
    if plan.shape.trees > _MOST_TREES:
        raise ValueError(f"halvings are too many for the boxes of level top: at most {_MOST_TREES:,}")


def _content(file: IO[bytes], where: str) -> tuple[Plan, BitTree, int, int]:
    plan, record = _head(file, where)
    if os.fstat(file.fileno()).st_size > _LARGEST:
        raise ValueError("it is too large")
    tree = _unpack_tree(plan.shape, file.read())
    if digest(plan, tree) != record["sha256"]:
        raise Refused("the covering was changed: its hash is another", where=where, got=record["sha256"])
    return plan, tree, record["tested"], record["freed"]


def _unpack_tree(shape: BoxShape, content: bytes) -> BitTree:
    """The tree of a compressed payload, unpacked level by level: each says how many bytes the next one has.

    Raises:
        ValueError: too short, too long or too large, or bits of children that there cannot be.
    """
    stream, room = zlib.decompressobj(), _allowed_bytes(shape, len(content))

    def take(size: int) -> bytearray:
        nonlocal content, room
        room -= size
        if room < 0:
            raise ValueError("more boxes than a file of this size holds")
        taken = bytearray()
        while len(taken) < size:
            piece = stream.decompress(content, min(size - len(taken), _PIECE))
            content = stream.unconsumed_tail
            if not piece:
                raise ValueError("too few bytes")
            taken += piece
        return taken

    size = (shape.trees + 7) // 8
    roots = np.unpackbits(np.frombuffer(take(size), np.uint8), bitorder="little", count=shape.trees).view(np.bool_)
    masks: list[Masks] = []
    count = int(roots.sum())
    for level in range(shape.top, shape.levels):
        masks.append(np.frombuffer(take(count * shape.kind.itemsize), shape.kind))
        wrong = ~allowed_children(shape, level + 1)
        if any(np.bitwise_and(part, wrong).any() or (part == 0).any() for part in _pieces(masks[-1])):
            raise ValueError("a mask of boxes that there are none of")
        count = total(masks[-1])
    proven = np.frombuffer(take(len(masks[-1]) * shape.kind.itemsize), shape.kind)
    if any(np.bitwise_and(a, ~b).any() for a, b in zip(_pieces(proven), _pieces(masks[-1]), strict=True)):
        raise ValueError("proven leaves that are not there")
    if stream.decompress(content, 1) or not stream.eof or stream.unused_data:
        raise ValueError("it ends too soon, or too late")
    return BitTree(shape, np.ones(shape.trees, dtype=np.bool_), roots, tuple(masks), proven)
