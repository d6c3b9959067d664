"""Triangles of mesh files (STL, COLLADA, OBJ, PLY), each file read once, in a child process with limits.

trimesh reads one file at a time, and nothing that a file points to. 3 kB of COLLADA may ask for gigabytes.
"""

from __future__ import annotations

import gc
import io
import json
import re
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.disk import read_file
from rankdrop.errors import RankdropError, RobotError
from rankdrop.jobs.limited import CPU, run_limited
from rankdrop.jobs.running import error_to_dict
from rankdrop.robot.files import LARGEST_LENGTH, allowed_range, read_xml
from rankdrop.robot.model import Array

LARGEST_MESH = 100 * 2**20
"""Bytes of one file."""
MOST_FACES = 3_000_000
"""Triangles of an arm: more would not move smoothly in a browser."""
MOST_VERTICES = 3 * MOST_FACES
"""Vertices of an arm: three for each triangle, none of them shared."""
MOST_INSTANCES = 10_000
"""Copies of meshes that one file places."""
MOST_MESHES = 500
"""Mesh files of an arm; a humanoid has a hundred."""
GREY = (0.72, 0.74, 0.77)
_PATIENCE = 10.0  # processor time of a file [s]
_SECONDS = 1.0  # more of it for each MB
_CRASHES = 3  # files over which the reader crashes, before the rest is left out
_READER = "trimesh"


@dataclass(frozen=True, eq=False)
class MeshPart:
    """Triangles of a mesh file.

    Attributes:
        vertices: (V, 3) in the frame of the file [m, before the scale of the URDF].
        faces: (F, 3) indices.
        colour: (r, g, b) in 0 … 1, as the file has it, else grey.
    """

    vertices: Array
    faces: NDArray[np.uint32]
    colour: tuple[float, ...]


def read_meshes(paths: Sequence[Path]) -> dict[Path, list[MeshPart] | RankdropError]:
    """The parts of each mesh file, or why it cannot be read. One child process reads all of them.

    Where that process crashes or meets a limit, each file is read by a process of its own, until three have crashed.
    """
    files = list(dict.fromkeys(paths))
    meshes: dict[Path, list[MeshPart] | RankdropError] = {
        path: RobotError("the arm has too many mesh files", where=str(path), allowed=f"at most {MOST_MESHES}")
        for path in files[MOST_MESHES:]
    }
    files = files[:MOST_MESHES]
    if not files:
        return meshes
    try:
        return meshes | _read_together(files)
    except RankdropError as error:
        if len(files) == 1:
            return meshes | {files[0]: error}
    crashes = 0
    for path in files:
        if crashes == _CRASHES:
            meshes[path] = RobotError("the mesh is not read: other meshes of the arm crash the reader", where=str(path))
            continue
        try:
            meshes |= _read_together([path])
        except RankdropError as error:
            crashes += 1
            meshes[path] = error
    return meshes


def _read_together(files: list[Path]) -> dict[Path, list[MeshPart] | RankdropError]:
    """The parts of each file, or its error, from one child process.

    Raises:
        RobotError: the process crashes or meets a limit.
    """
    size = sum(path.stat().st_size for path in files if path.is_file())
    content = run_limited(mesh_parts, [str(path) for path in files], file=files[0], parser=_READER,
                          cpu=CPU + int(_SECONDS * size / 1e6))  # fmt: skip
    with np.load(io.BytesIO(content)) as arrays:
        about = json.loads(str(arrays["about"]))
        meshes: dict[Path, list[MeshPart] | RankdropError] = {}
        for i, (path, told) in enumerate(zip(files, about, strict=True)):
            if "error" in told:
                meshes[path] = RobotError(**told["error"])
                continue
            meshes[path] = [MeshPart(arrays[f"v{i}_{k}"], arrays[f"f{i}_{k}"], tuple(colour))
                           for k, colour in enumerate(told["colours"])]  # fmt: skip
    return meshes


def mesh_parts(names: list[str]) -> bytes:
    """Parts of mesh files as NumPy's archive: vertices `v{i}_{k}` and faces `f{i}_{k}` of part k of file i, and `about`
    in JSON, with the colours of each file's parts, or its error. Runs in a child process.
    """
    about: list[dict[str, Any]] = []
    arrays: dict[str, Any] = {}
    faces = vertices = 0
    end = time.process_time() + 0.8 * CPU + _SECONDS * sum(Path(name).stat().st_size for name in names) / 1e6
    for i, name in enumerate(names):
        try:
            with _limited_time(name, end):
                parts = _read_parts(Path(name), MOST_FACES - faces, MOST_VERTICES - vertices)
        except RankdropError as error:
            about.append({"error": error_to_dict(error)})
        else:
            faces += sum(len(part.faces) for part in parts)
            vertices += sum(len(part.vertices) for part in parts)
            arrays |= {f"v{i}_{k}": part.vertices for k, part in enumerate(parts)}
            arrays |= {f"f{i}_{k}": part.faces for k, part in enumerate(parts)}
            about.append({"colours": [part.colour for part in parts]})
    buffer = io.BytesIO()
    np.savez(buffer, about=np.array(json.dumps(about)), **arrays)
    return buffer.getvalue()


@contextmanager
def _limited_time(name: str, end: float) -> Iterator[None]:
    """Interrupt what takes more than its processor time, where the system has timers for that.

    Args:
        name: of the file.
        end: processor time at which all files are to be read [s].

    Raises:
        RobotError: it does, or the files before it have used the time of all.
    """
    allowed = _PATIENCE + _SECONDS * Path(name).stat().st_size / 1e6
    left = min(allowed, end - time.process_time())
    error = RobotError(f"{_READER} needs more than {left:.0f} s of processor time for the file", where=name)
    if left <= 0:
        raise RobotError("the mesh is not read: the meshes before it took too long", where=name)

    def stop(*_: object) -> None:
        raise error

    if not hasattr(signal, "setitimer"):  # Windows
        yield
        return
    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, left, 1.0)  # again: a reader may catch everything
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def _read_parts(file: Path, most_faces: int, most_vertices: int) -> list[MeshPart]:
    """The parts of a file that fit into what is left of triangles and vertices.

    Raises:
        RobotError: too large, too many, out of range, damaged, or more than the memory.
    """
    try:
        return _parse_parts(file, most_faces, most_vertices)
    except RankdropError:
        raise
    except MemoryError:
        gc.collect()
        raise RobotError(f"{_READER} needs too much memory for the file", where=str(file)) from None
    except Exception as error:  # a mesh that is damaged: whatever its reader raises
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise RobotError(f"the mesh cannot be read: {reason}", where=str(file)) from None


def _parse_parts(file: Path, most_faces: int, most_vertices: int) -> list[MeshPart]:
    import trimesh

    try:
        data = read_file(file, LARGEST_MESH)
    except OSError as error:
        raise RobotError(f"the mesh cannot be read: {error.strerror or error}", where=str(file)) from None
    kind = file.suffix.lower().removeprefix(".")
    if kind == "dae":  # refuses document types and entities
        read_xml(data.decode("utf-8", "replace"), str(file))
    scene = trimesh.load_scene(io.BytesIO(data), file_type=kind)  # without a resolver no other file is opened
    placed = [scene.graph[node][1] for node in _refuse_too_many_nodes(scene.graph.nodes_geometry, str(file))]
    used = [scene.geometry[name] for name in placed]
    faces = sum(len(getattr(shape, "faces", ())) for shape in used)
    vertices = sum(len(getattr(shape, "vertices", ())) for shape in used)
    check_count(faces, vertices, str(file), most_faces, most_vertices)
    unit = _unit(scene)
    parts = [part for part in scene.dump() if len(getattr(part, "faces", ())) > 0]
    return [_part(part, unit, str(file)) for part in parts]


def _refuse_too_many_nodes(nodes: Sequence[Any], file: str) -> Sequence[Any]:
    if len(nodes) > MOST_INSTANCES:
        raise RobotError("the mesh places too many copies", where=file, got=len(nodes), allowed=f"at most "
                         f"{MOST_INSTANCES:,}")  # fmt: skip
    return nodes


def check_count(faces: int, vertices: int, file: str, most_faces: int, most_vertices: int) -> None:
    """Refuse what does not fit into the triangles and vertices that are left of an arm's.

    Raises:
        RobotError: it does not.
    """
    if faces > most_faces:
        raise RobotError("the meshes have too many triangles", where=file, allowed=f"{MOST_FACES:,} of an arm")
    if vertices > most_vertices:
        raise RobotError("the meshes have too many vertices", where=file, allowed=f"{MOST_VERTICES:,} of an arm")


def _part(mesh: Any, unit: float, file: str) -> MeshPart:
    with np.errstate(all="ignore"):
        vertices = np.asarray(mesh.vertices, dtype=np.float64) * unit
    faces = np.asarray(mesh.faces, dtype=np.uint32)
    if not (np.abs(vertices) <= LARGEST_LENGTH).all():
        raise RobotError("the mesh has a vertex that is not finite, or too far away", where=file,
                         allowed=allowed_range("length"))  # fmt: skip
    if int(faces.max(initial=0)) >= len(vertices):
        raise RobotError("a triangle of the mesh names a vertex that it does not have", where=file)
    return MeshPart(vertices, faces, tuple(float(value) for value in _own_colour(mesh)[:3]))


def _unit(scene: Any) -> float:
    """Metres per unit of a COLLADA file; the other formats have no unit, and URDF takes them as metres."""
    for geometry in scene.geometry.values():
        match = re.match(r"([\d.eE+-]+) \* meters", str(geometry.metadata.get("units", "")))
        if match:
            return float(match[1])
    return 1.0


def _own_colour(part: Any) -> tuple[float, ...]:
    visual = getattr(part, "visual", None)
    if visual is None or not visual.defined:
        return GREY
    colour = getattr(getattr(visual, "material", None), "main_color", None)
    if colour is None:
        colour = getattr(visual, "main_color", None)
    if colour is None:
        return GREY
    return tuple(float(value) / 255.0 for value in colour[:3])
