"""Shapes of links for the page: so few triangles that they can be drawn without a graphics card, and sent by mail."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.robot import Array, Mesh

MOST = 6_000
"""Triangles of all links together: about 150 kB of the page."""
_GROWS = 1.15  # by how much cells grow until there are few enough triangles
_LEVELS = 8191  # steps of a coordinate over the size of its mesh: 0.1 mm in a metre


def simplified(meshes: Sequence[Mesh], most: int = MOST) -> tuple[Mesh, ...]:
    """The meshes with at most so many triangles together.

    Vertices in one cell of a grid become one, their mean; the cells grow until there are few enough triangles. What
    becomes thinner than a cell vanishes.

    Args:
        meshes: of any size.
        most: triangles of all of them together.
    """
    meshes = [one for one in meshes if len(one.faces)]
    every = sum(len(one.faces) for one in meshes)
    if not every:
        return ()
    area = sum(_area(one.vertices, one.faces) for one in meshes)
    span = max(float(np.ptp(one.vertices, axis=0).max(initial=0.0)) for one in meshes)
    cell = 1e-6 * span if every <= most else max(0.5 * np.sqrt(2 * area / most), 1e-6 * span)
    while True:
        found = [_clustered(one, cell) for one in meshes]
        if sum(len(one.faces) for one in found) <= most:
            return tuple(one for one in found if len(one.faces))
        cell *= _GROWS


def _area(vertices: Array, faces: NDArray[Any]) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def _clustered(mesh: Mesh, cell: float) -> Mesh:
    """Vertices of one cell made one; triangles that have become lines go, and all but one of equal ones."""
    keys = np.floor((mesh.vertices - mesh.vertices.min(axis=0)) / cell).astype(np.int64)
    wide = keys.max(axis=0) + 1
    _, place, count = np.unique(
        (keys[:, 0] * wide[1] + keys[:, 1]) * wide[2] + keys[:, 2], return_inverse=True, return_counts=True
    )
    vertices = np.stack([np.bincount(place, mesh.vertices[:, k]) for k in range(3)], axis=1) / count[:, None]
    faces = place[mesh.faces.astype(np.int64)]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    if len(faces):
        _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
        faces = faces[np.sort(first)]
    used, faces = np.unique(faces, return_inverse=True)
    return Mesh(mesh.link, vertices[used], faces.reshape(-1, 3).astype(np.uint32), mesh.colour)


def meshes_data(meshes: Sequence[Mesh]) -> list[dict[str, Any]]:
    """The meshes for the page's program: whole numbers, a step and a corner to make metres of them."""
    data = []
    for one in meshes:
        low = one.vertices.min(axis=0)
        step = max(float(np.ptp(one.vertices, axis=0).max()), 1e-9) / _LEVELS
        data.append({
            "link": one.link,
            "colour": "#{:02x}{:02x}{:02x}".format(*one.colour),
            "low": [float(f"{value:.7g}") for value in low],
            "step": float(f"{step:.7g}"),
            "points": np.rint((one.vertices - low) / step).astype(int).ravel().tolist(),
            "faces": one.faces.ravel().tolist(),
        })  # fmt: skip
    return data
