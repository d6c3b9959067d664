"""Vertices and triangles of visuals, by trimesh: one file at a time, and nothing that a file points to."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import MissingExtraError, RankdropError, RobotError
from rankdrop.robot import Array, read_xml
from rankdrop.viewer.visuals import GREY, Visual

LARGEST_MESH = 100 * 2**20
"""Bytes of one file."""
MOST_FACES = 3_000_000
"""Triangles of an arm: more would not move smoothly in a browser."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles on one link.

    Attributes:
        link: index of `link_poses`.
        vertices: (V, 3) in the frame of that link [m].
        faces: (F, 3) indices.
        colour: (r, g, b) in 0 … 255.
    """

    link: int
    vertices: Array
    faces: NDArray[np.uint32]
    colour: tuple[int, int, int]


def meshes_of(visuals: tuple[Visual, ...]) -> tuple[tuple[Mesh, ...], tuple[str, ...]]:
    """All visuals as triangles, and a line for each that could not be read.

    Raises:
        MissingExtraError: trimesh is not installed.
    """
    if not visuals:
        return (), ()
    try:
        import trimesh
    except ImportError:
        raise MissingExtraError("trimesh", None, "drawing meshes") from None
    found: list[Mesh] = []
    notes: list[str] = []
    faces = 0
    for visual in visuals:
        try:
            for mesh in _read(trimesh, visual):
                faces += len(mesh.faces)
                if faces > MOST_FACES:
                    raise RobotError("the meshes have too many triangles", where=str(visual.file),
                                     allowed=f"{MOST_FACES}")  # fmt: skip
                found.append(mesh)
        except RankdropError as error:
            notes.append(str(error))
        except Exception as error:  # a mesh that is damaged: whatever its reader raises
            notes.append(f"{visual.file}: the mesh cannot be read: {type(error).__name__}: {str(error)[:200]}")
    return tuple(found), tuple(notes)


def _read(trimesh: Any, visual: Visual) -> list[Mesh]:
    if visual.file is None:
        return [_placed(_solid(trimesh, visual), visual, np.ones(3), visual.colour or GREY)]
    data = _bytes(visual.file)
    kind = visual.file.suffix.lower().removeprefix(".")
    if kind == "dae":  # refuses document types and entities
        read_xml(data.decode("utf-8", "replace"), str(visual.file))
    scene = trimesh.load_scene(io.BytesIO(data), file_type=kind, resolver=_Nothing())
    scale = np.array(visual.size) * _unit(scene)
    parts = [part for part in scene.dump() if len(getattr(part, "faces", ())) > 0]
    return [_placed(part, visual, scale, visual.colour or _own_colour(part)) for part in parts]


class _Nothing:
    """A mesh may name textures and materials in other files: none is opened."""

    def get(self, name: str) -> bytes:
        raise FileNotFoundError(name)

    def keys(self) -> list[str]:
        return []

    def __contains__(self, _name: object) -> bool:
        return False

    def namespaced(self, _name: str) -> _Nothing:
        return self


def _bytes(file: Path) -> bytes:
    with file.open("rb") as stream:
        data = stream.read(LARGEST_MESH + 1)
    if len(data) > LARGEST_MESH:
        raise RobotError("the mesh is too large", where=str(file), allowed=f"at most {LARGEST_MESH // 2**20} MB")
    return data


def _solid(trimesh: Any, visual: Visual) -> Any:
    size = visual.size
    if visual.solid == "box":
        return trimesh.creation.box(extents=size)
    if visual.solid == "cylinder":
        return trimesh.creation.cylinder(radius=size[0], height=size[1], sections=48)
    return trimesh.creation.icosphere(radius=size[0], subdivisions=3)


def _placed(mesh: Any, visual: Visual, scale: Array, colour: tuple[float, ...]) -> Mesh:
    vertices = np.asarray(mesh.vertices, dtype=np.float64) * scale
    faces = np.asarray(mesh.faces, dtype=np.uint32)
    if np.prod(scale) < 0:
        faces = faces[:, ::-1]  # a mirror turns triangles inside out
    placed = vertices @ visual.pose[:3, :3].T + visual.pose[:3, 3]
    if not np.isfinite(placed).all():
        raise RobotError("the mesh has vertices that are not finite", where=str(visual.file))
    r, g, b = (round(255 * value) for value in colour[:3])
    return Mesh(visual.link, placed, faces, (r, g, b))


def _unit(scene: Any) -> float:
    """Metres per unit of a COLLADA file; the other formats have no unit, and URDF takes them as metres."""
    for geometry in scene.geometry.values():
        match = re.match(r"([\d.eE+-]+) \* meters", str(geometry.metadata.get("units", "")))
        if match:
            return float(match[1])
    return 1.0


def _own_colour(part: Any) -> tuple[float, ...]:
    """The main colour of a part, grey where it has none."""
    visual = getattr(part, "visual", None)
    if visual is None or not visual.defined:
        return GREY
    colour = getattr(getattr(visual, "material", None), "main_color", None)
    if colour is None:
        colour = getattr(visual, "main_color", None)
    return GREY if colour is None else tuple(float(value) / 255.0 for value in colour[:3])
