"""Zero sets of functions given on a grid: curves in a plane (marching squares), surfaces in space (tetrahedra)."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from rankdrop.robot.model import Array

Ints = NDArray[np.int64]


def curves(values: Array, x: Array, y: Array) -> list[Array]:
    """Curves on which a function changes sign, by marching squares.

    Args:
        values: (a, b) at the nodes (x_i, y_j).
        x, y: (a,) and (b,) increasing.

    Returns:
        (k, 2) polylines; a closed one ends where it begins.
    """
    above = values >= 0
    points, across = _crossings(values, x, y, above)
    links: dict[int, list[int]] = {}
    for first, second in _segments(values, above, across):
        links.setdefault(first, []).append(second)
        links.setdefault(second, []).append(first)
    return [points[line] for line in _joined(links)]


def _crossings(values: Array, x: Array, y: Array, above: NDArray[np.bool_]) -> tuple[Array, tuple[Ints, Ints]]:
    """(N, 2) where grid edges are crossed, and their numbers per horizontal and per vertical edge (−1: not crossed)."""
    parts, numbers, count = [], [], 0
    for axis in (0, 1):
        first = (slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))
        last = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
        crossed = above[first] != above[last]
        i, j = np.nonzero(crossed)
        a, b = values[first][i, j], values[last][i, j]
        share = a / (a - b)
        di, dj = (1, 0) if axis == 0 else (0, 1)
        parts.append(np.stack([x[i] + share * (x[i + di] - x[i]), y[j] + share * (y[j + dj] - y[j])], axis=1))
        number = np.full(crossed.shape, -1, dtype=np.int64)
        number[i, j] = count + np.arange(len(i))
        numbers.append(number)
        count += len(i)
    return np.concatenate(parts), (numbers[0], numbers[1])


def _segments(values: Array, above: NDArray[np.bool_], across: tuple[Ints, Ints]) -> list[tuple[int, int]]:
    """Pairs of crossings joined inside a cell; in a cell with four, the mean of its corners tells which."""
    along_x, along_y = across
    around = np.stack([along_x[:, :-1], along_y[1:, :], along_x[:, 1:], along_y[:-1, :]], axis=-1)  # anticlockwise
    count = (around >= 0).sum(axis=-1)
    two = around[count == 2]
    pairs = [(int(row[row >= 0][0]), int(row[row >= 0][1])) for row in two]
    for i, j in zip(*np.nonzero(count == 4), strict=True):
        s, e, n, w = (int(number) for number in around[i, j])
        middle = values[i : i + 2, j : j + 2].mean() >= 0
        pairs += [(s, e), (n, w)] if middle == above[i, j] else [(s, w), (e, n)]
    return pairs


def _joined(links: dict[int, list[int]]) -> list[list[int]]:
    """Chains of crossings, open ones from an end."""
    lines = []
    ends = [node for node, others in links.items() if len(others) == 1]
    for start in [*ends, *links]:
        if not links[start]:
            continue
        line = [start]
        while links[line[-1]]:
            following = links[line[-1]].pop()
            links[following].remove(line[-1])
            line.append(following)
        lines.append(line)
    return lines


def surface(values: Array, axes: tuple[Array, Array, Array]) -> tuple[Array, Ints]:
    """The surface on which a function changes sign, by marching tetrahedra: six in every cell, around its diagonal.

    Args:
        values: (a, b, c) at the nodes.
        axes: coordinates of the nodes, increasing.

    Returns:
        (V, 3) vertices and (T, 3) triangles.
    """
    shape = values.shape
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    corner = np.stack(np.meshgrid(*(np.arange(size - 1) for size in shape), indexing="ij"), axis=-1).reshape(-1, 3)
    start = corner @ strides
    flat = values.ravel()
    edges = []
    for order in permutations(range(3)):
        steps = np.cumsum([0, *(strides[axis] for axis in order)])
        tetrahedra = start[:, None] + steps  # (cells, 4) node numbers
        edges.append(_cut(tetrahedra, flat[tetrahedra] >= 0))
    pairs = np.concatenate(edges)  # (T, 3, 2) grid edges cut by the corners of each triangle
    pairs.sort(axis=-1)
    keys, triangles = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    a, b = flat[keys[:, 0]], flat[keys[:, 1]]
    share = (a / (a - b))[:, None]
    places = [np.stack([axes[k][index[k]] for k in range(3)], axis=1)
              for index in (np.unravel_index(keys[:, 0], shape), np.unravel_index(keys[:, 1], shape))]  # fmt: skip
    return places[0] + share * (places[1] - places[0]), triangles.reshape(-1, 3)


def _cut(nodes: Ints, above: NDArray[np.bool_]) -> Ints:
    """(T, 3, 2) triangles cut out of tetrahedra, as pairs of nodes: one off three, or two off two."""
    found = []
    count = above.sum(axis=1)
    for single, lone in ((1, True), (3, False)):
        rows = nodes[count == single]
        order = np.argsort(above[count == single] != lone, axis=1, kind="stable")
        rows = np.take_along_axis(rows, order, axis=1)
        found.append(np.stack([np.stack([rows[:, 0], rows[:, k]], axis=1) for k in (1, 2, 3)], axis=1))
    rows = nodes[count == 2]
    rows = np.take_along_axis(rows, np.argsort(~above[count == 2], axis=1, kind="stable"), axis=1)
    p = [np.stack([rows[:, i], rows[:, k]], axis=1) for i, k in ((0, 2), (0, 3), (1, 3), (1, 2))]
    found.append(np.stack([p[0], p[1], p[2]], axis=1))
    found.append(np.stack([p[0], p[2], p[3]], axis=1))
    return np.concatenate(found)
