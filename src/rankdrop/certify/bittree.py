"""Boxes of a joint space that are not proven free, as a tree of bits.

A box of level ℓ is one of Π 2^min(ℓ, depth_j) equal ones, halved along every variable that is not yet as narrow as a
leaf. A box that is not free all through has a mask: bit c is set where child c is not free. c counts the children in
row-major order, the first variable slowest; the bit of a variable that is not halved stays 0. Masks stand level by
level, the boxes of a level in the order in which their own bits stand in the level above; the leaves that are proven to
hold a singularity have a second set of masks, beside those of the level above the leaves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod

import numpy as np
from numpy.typing import NDArray

Masks = NDArray[np.unsignedinteger]
Flags = NDArray[np.bool_]
Cells = NDArray[np.int32]

_ONES = np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1).sum(axis=1)  # bits set in a byte
_CHUNK = 1 << 16  # parents of leaves unpacked at one go


@dataclass(frozen=True, slots=True)
class Shape:
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

    def children(self, cells: Cells, masks: Masks, level: int) -> tuple[Cells, NDArray[np.int64]]:
        """(M, d) boxes of `level` whose bits are set in masks (N,) of boxes (N, d), and (M,) whose they are."""
        parent, child = np.nonzero(bits(masks, self.variables))
        halved = self.halved(level)
        found = cells[parent] << np.array(halved, dtype=np.int32)
        for j in range(self.variables):
            found[:, j] += (child >> (self.variables - 1 - j)) & 1
        return found, parent


def bits(masks: Masks, variables: int) -> Flags:
    """(N, 2^d) the bits of masks (N,)."""
    parts = np.ascontiguousarray(masks).view(np.uint8).reshape(len(masks), masks.dtype.itemsize)
    return np.unpackbits(parts, axis=1, bitorder="little", count=1 << variables).view(np.bool_)


def counts(masks: Masks) -> NDArray[np.int64]:
    """(N,) how many bits are set in each mask."""
    parts = np.ascontiguousarray(masks).view(np.uint8).reshape(len(masks), masks.dtype.itemsize)
    return np.asarray(_ONES[parts].sum(axis=1, dtype=np.int64))


def packed(flags: Flags, kind: np.dtype[np.unsignedinteger]) -> Masks:
    """Masks (N,) of the bits (N, 2^d)."""
    parts = np.packbits(flags, axis=1, bitorder="little")
    wide = np.zeros((len(flags), kind.itemsize), dtype=np.uint8)
    wide[:, : parts.shape[1]] = parts
    return wide.reshape(-1).view(kind)


@dataclass(frozen=True, eq=False)
class BitTree:
    """The boxes that are left.

    Attributes:
        shape: how boxes are halved.
        finished: (trees,) whether each tree was made; the others count as not free.
        roots: (trees,) whether anything is left of each tree; True where it was not made.
        masks: those of level `top` to that above the leaves.
        proven: masks of the leaves that are proven to hold a singularity, beside the last of `masks`.
    """

    shape: Shape
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
        per_tree = prod(self.shape.cells(self.shape.levels)) // self.shape.trees
        return int(counts(self.masks[-1]).sum()) + int((~self.finished).sum()) * per_tree

    @cached_property
    def proven_leaves(self) -> int:
        """Number of leaves that are proven to hold a singularity."""
        return int(counts(self.proven).sum())

    @property
    def free_share(self) -> float:
        """Share of the volume that is proven free."""
        return 1.0 - self.leaves / prod(self.shape.cells(self.shape.levels))

    @cached_property
    def parents(self) -> Cells:
        """(N, d) boxes of the level above the leaves that hold leaves, in the order of the last masks."""
        shape = self.shape
        number = np.flatnonzero(self.roots & self.finished)
        cells = np.stack(np.unravel_index(number, shape.cells(shape.top)), axis=1).astype(np.int32)
        for level, masks in enumerate(self.masks[:-1], start=shape.top + 1):
            cells = shape.children(cells, masks, level)[0]
        return cells

    def parts(self, size: int = _CHUNK) -> Iterator[tuple[Cells, Flags]]:
        """The leaves of trees that were made, part by part: (M, d) boxes of the last level, (M,) whether proven."""
        shape = self.shape
        for begin in range(0, len(self.parents), size):
            part = slice(begin, begin + size)
            masks = self.masks[-1][part]
            cells, _ = shape.children(self.parents[part], masks, shape.levels)
            proven = bits(self.proven[part], shape.variables)[bits(masks, shape.variables)]
            yield cells, proven

    def payload(self) -> bytes:
        """Roots as bits, masks level by level, masks of the proven leaves; little-endian."""
        parts = [np.packbits(self.roots, bitorder="little").tobytes()]
        return b"".join([*parts, *(masks.tobytes() for masks in self.masks), self.proven.tobytes()])


def from_payload(shape: Shape, payload: bytes) -> BitTree:
    """The tree of a payload, finished.

    Raises:
        ValueError: too short or too long, or bits of children that there cannot be.
    """
    size = (shape.trees + 7) // 8
    roots = np.unpackbits(np.frombuffer(payload[:size], np.uint8), bitorder="little", count=shape.trees).view(np.bool_)
    at, count, found = size, int(roots.sum()), []
    for level in range(shape.top, shape.levels):
        masks, at = _read(shape, payload, at, count)
        if np.bitwise_and(masks, ~allowed(shape, level + 1)).any() or (masks == 0).any():
            raise ValueError("a mask of boxes that there are none of")
        found.append(masks)
        count = int(counts(masks).sum())
    proven, at = _read(shape, payload, at, len(found[-1]))
    if at != len(payload) or np.bitwise_and(proven, ~found[-1]).any():
        raise ValueError("proven leaves that are not there, or too many bytes")
    return BitTree(shape, np.ones(shape.trees, dtype=np.bool_), roots, tuple(found), proven)


def _read(shape: Shape, payload: bytes, at: int, count: int) -> tuple[Masks, int]:
    end = at + count * shape.kind.itemsize
    if end > len(payload):
        raise ValueError("too few bytes")
    return np.frombuffer(payload[at:end], shape.kind), end


def allowed(shape: Shape, level: int) -> np.unsignedinteger:
    """Mask of the children that a box above `level` has."""
    halved = shape.halved(level)
    d = shape.variables
    flags = [all(halved[j] or not (child >> (d - 1 - j)) & 1 for j in range(d)) for child in range(1 << d)]
    mask: np.unsignedinteger = packed(np.array([flags]), shape.kind)[0]
    return mask


def joined(shape: Shape, finished: Flags, trees: Sequence[tuple[Masks, NDArray[np.int32]]]) -> BitTree:
    """One tree of bits from those of the boxes of level `top`.

    Args:
        shape: how boxes are halved.
        finished: (trees,) which of them were made.
        trees: batches in the order of their boxes: masks, box by box and in each level by level (the proven last), and
            (boxes, levels + 1) how many.
    """
    parts = shape.levels - shape.top + 1
    found: list[list[Masks]] = [[] for _ in range(parts)]
    roots = ~finished
    filled: list[NDArray[np.bool_]] = []
    for masks, sizes in trees:
        which = np.repeat(np.tile(np.arange(parts), len(sizes)), sizes.reshape(-1))
        for part in range(parts):
            found[part].append(masks[which == part])
        filled.append(sizes[:, 0] > 0)
    if filled:
        roots[finished] = np.concatenate(filled)
    empty = np.zeros(0, shape.kind)
    levels = [np.concatenate([empty, *one]).astype(shape.kind) for one in found]
    return BitTree(shape, finished, roots, tuple(levels[:-1]), levels[-1])
