"""The shapes that a URDF draws its links with: which mesh or solid, where on which link, and their triangles.

Files of triangles are read by `robot.mesh_file`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import MissingExtraError, RankdropError, RobotError
from rankdrop.options import advise
from rankdrop.robot.files import Element, read_text, read_xml
from rankdrop.robot.mesh_file import GREY, MOST_FACES, MOST_VERTICES, MeshPart, check_count, read_meshes
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.quantities import Angles
from rankdrop.robot.transform import from_xyz_rpy, inverse, times
from rankdrop.robot.tree import Tree, read_tree
from rankdrop.robot.urdf import joint_origin, number, three
from rankdrop.robot.xacro import EXPANDED, PLACES, expand_file, find_package

MESHES = (".stl", ".dae", ".obj", ".ply")
MOST_VISUALS = 2_000
"""Shapes of an arm; a humanoid has a hundred."""
_NOT_READ = frozenset({"collision", "inertial", "transmission", "gazebo", "sensor"})


@dataclass(frozen=True, eq=False)
class Visual:
    """One shape of one link.

    Attributes:
        link: index of `link_poses`: 0 the base, i the link after joint i.
        pose: (4, 4) of the shape in the frame of that link.
        solid: "mesh", "box", "cylinder" or "sphere".
        size: scale of a mesh, edges of a box, (radius, length) of a cylinder, (radius,) of a sphere [m].
        file: of the mesh; None for a solid.
        colour: (r, g, b) in 0 … 1, or None where the mesh's own is meant.
    """

    link: int
    pose: Array
    solid: str
    size: tuple[float, ...]
    file: Path | None
    colour: tuple[float, float, float] | None


def visuals_of(
    robot: Robot, packages: Mapping[str, Path], args: Mapping[str, str] | None = None
) -> tuple[tuple[Visual, ...], tuple[str, ...]]:
    """The shapes of the links of a robot that was read from a URDF or xacro file, and what could not be used.

    Links that hang on the chain by fixed joints belong to the link that carries them; those on moving joints outside
    the chain (the fingers of a gripper) are drawn at zero. A robot from another source has none.

    Args:
        robot: from `open_robot`.
        packages: package name -> folder, for package://; others are looked for (see `robot.xacro.find_package`).
        args: of a xacro file, which is expanded once more, as it was when the robot was opened.

    Returns:
        Shapes, and one line of text for every shape that was left out.
    """
    expanded = robot.source.origin.endswith(EXPANDED)
    file = Path(robot.source.origin.removesuffix(EXPANDED))
    if robot.source.kind != "urdf" or not file.is_file():
        return (), ()
    if expanded:
        text = expand_file(file, packages, args or {})[0]
    else:
        text = read_text(file)
    root = read_xml(text, str(file), _NOT_READ)
    tree = read_tree(root, str(file))
    if robot.base not in tree.links:
        return (), ()
    carriers = _carriers(robot, tree)
    colours = _colours(root)
    known = dict(packages)
    shapes: list[Visual] = []
    notes: list[str] = []
    every = _visual_elements(root)
    if len(every) > MOST_VISUALS:
        error = RobotError("the file has too many shapes; the first ones are used", where=str(file), got=len(every),
                           allowed=f"at most {MOST_VISUALS:,}")  # fmt: skip
        notes.append(str(error))
    for element, visual in every[:MOST_VISUALS]:
        link, pose = carriers[element.attributes["name"]]
        try:
            shapes.append(_visual(visual, link, pose, file, known, colours))
        except RobotError as error:
            notes.append(str(error))
    return tuple(shapes), tuple(notes)


def _visual_elements(root: Element) -> list[tuple[Element, Element]]:
    """Each link of a URDF file with each of its visual elements."""
    elements = []
    for link in root.children:
        if link.tag == "link":
            elements += [(link, visual) for visual in link.children if visual.tag == "visual"]
    return elements


def _carriers(robot: Robot, tree: Tree) -> dict[str, tuple[int, Array]]:
    """Of every link of the file: the index of the link of the chain that carries it, and its pose in its frame."""
    moving = {joint.name: number for number, joint in enumerate(robot.joints, start=1)}
    frames = [np.eye(4), *(joint.frame for joint in robot.joints)]
    home = {root: (0, np.eye(4)) for root in tree.links if root not in tree.above}
    for root in list(home):
        for link in tree.below_and(root)[1:]:
            joint = tree.above[link]
            index, pose = home[joint.parent]
            home[link] = moving.get(joint.name, index), times(pose, joint_origin(tree, joint, Angles()))
    base = inverse(home[robot.base][1])
    return {link: (index, times(inverse(frames[index]), base, pose)) for link, (index, pose) in home.items()}


def _colours(root: Element) -> dict[str, tuple[float, float, float]]:
    colours: dict[str, tuple[float, float, float]] = {}
    for element in [root, *chain.from_iterable(link.children for link in root.children)]:
        for material in element.children:
            name, colour = material.attributes.get("name", ""), material.first("color")
            if material.tag == "material" and name and colour is not None:
                rgb = _rgb(colour)
                if rgb is not None:
                    colours.setdefault(name, rgb)
    return colours


def _rgb(colour: Element) -> tuple[float, float, float] | None:
    words = colour.attributes.get("rgba", "").split()
    try:
        r, g, b = (min(1.0, max(0.0, float(word))) for word in words[:3])
    except ValueError:
        return None
    return r, g, b


def _visual(
    visual: Element,
    link: int,
    carrier: Array,
    file: Path,
    packages: dict[str, Path],
    colours: Mapping[str, tuple[float, float, float]],
) -> Visual:
    where = f"{file}, line {visual.line}, <visual>"
    geometry = visual.first("geometry")
    if geometry is not None:
        shape = next(iter(geometry.children), None)
    else:
        shape = None
    if shape is None:
        raise RobotError("there is no shape", where=where)
    origin, material = visual.first("origin"), visual.first("material")
    if origin is None:
        given = {}
    else:
        given = origin.attributes
    pose = carrier @ from_xyz_rpy(
        three(given.get("xyz", "0 0 0"), where, "xyz", "length"),
        three(given.get("rpy", "0 0 0"), where, "rpy", "angle"),
    )
    colour = None
    if material is not None:
        inline = material.first("color")
        if inline is not None:
            colour = _rgb(inline)
        else:
            colour = colours.get(material.attributes.get("name", ""))
    solid, size = shape.tag, _size(shape, where)
    if solid == "mesh":
        path = mesh_file(shape.attributes.get("filename", ""), file, packages, where)
    else:
        path = None
    return Visual(link, pose, solid, size, path, colour)


def _size(shape: Element, where: str) -> tuple[float, ...]:
    given = shape.attributes
    if shape.tag == "mesh":
        return tuple(three(given.get("scale", "1 1 1"), where, "scale"))
    if shape.tag == "box":
        return tuple(three(given.get("size", ""), where, "size"))
    if shape.tag == "cylinder":
        return number(given.get("radius", ""), where, "radius"), number(given.get("length", ""), where, "length")
    if shape.tag == "sphere":
        return (number(given.get("radius", ""), where, "radius"),)
    raise RobotError("the shape is not known", where=where, got=f"<{shape.tag}>", allowed="mesh, box, cylinder, sphere")


def mesh_file(name: str, file: Path, packages: dict[str, Path], where: str) -> Path:
    """The file that a mesh's name means: package://NAME/…, file://… or a path beside the URDF.

    Raises:
        RobotError: the package or the file is not found, or no mesh by its ending; nothing else is ever opened.
    """
    if name.startswith("package://"):
        package, _, rest = name.removeprefix("package://").partition("/")
        path = _package(package, file, packages, where) / rest
    elif "://" in name and not name.startswith("file://"):
        raise RobotError("meshes are read from this machine only", where=where, got=repr(name))
    else:
        path = file.parent / unquote(name.removeprefix("file://"))
    if path.suffix.lower() not in MESHES:
        raise RobotError("this is no mesh that can be read", where=where, got=repr(name), allowed=", ".join(MESHES))
    if not path.is_file():
        raise RobotError("there is no such mesh", where=where, got=str(path))
    return path


def _package(name: str, file: Path, packages: dict[str, Path], where: str) -> Path:
    """The folder of a package; `packages` keeps what was found, for the next mesh."""
    folder = find_package(name, file, packages)
    if folder is None:
        raise RobotError(
            "a package is not found", where=where, got=repr(name), allowed=f"a package of this name {PLACES}",
            mend=advise("package", f"{name}=FOLDER", python=f"packages={{{name!r}: FOLDER}}"),
        )
    packages[name] = folder
    return folder


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
        raise MissingExtraError("trimesh", "viewer", "drawing meshes") from None
    parts = read_meshes([visual.file for visual in visuals if visual.file is not None])
    meshes: list[Mesh] = []
    notes: list[str] = []
    faces = vertices = 0
    for visual in visuals:
        try:
            used = _parts(trimesh, visual, parts)
            more_faces, more_vertices = sum(len(part.faces) for part in used), sum(len(part.vertices) for part in used)
            check_count(more_faces, more_vertices, str(visual.file), MOST_FACES - faces, MOST_VERTICES - vertices)
            meshes += [_place_part(part, visual) for part in used]
        except RankdropError as error:
            notes.append(str(error))
        else:
            faces, vertices = faces + more_faces, vertices + more_vertices
    return tuple(meshes), tuple(dict.fromkeys(notes))


def _parts(trimesh: Any, visual: Visual, read: Mapping[Path, list[MeshPart] | RankdropError]) -> list[MeshPart]:
    """The triangles of a visual before scale and place.

    Raises:
        RankdropError: its mesh could not be read.
    """
    if visual.file is None:
        solid = _solid(trimesh, visual)
        return [MeshPart(np.asarray(solid.vertices, dtype=np.float64), np.asarray(solid.faces, dtype=np.uint32), GREY)]
    parts = read[visual.file]
    if isinstance(parts, RankdropError):
        raise parts
    return parts


def _solid(trimesh: Any, visual: Visual) -> Any:
    size = visual.size
    if visual.solid == "box":
        return trimesh.creation.box(extents=size)
    if visual.solid == "cylinder":
        return trimesh.creation.cylinder(radius=size[0], height=size[1], sections=48)
    return trimesh.creation.icosphere(radius=size[0], subdivisions=3)


def _place_part(part: MeshPart, visual: Visual) -> Mesh:
    if visual.file is None:
        scale = np.ones(3)
    else:
        scale = np.array(visual.size)
    faces = part.faces[:, ::-1] if np.prod(scale) < 0 else part.faces  # a mirror turns triangles inside out
    with np.errstate(all="ignore"):
        placed = (part.vertices * scale) @ visual.pose[:3, :3].T + visual.pose[:3, 3]
    if not np.isfinite(placed).all():
        raise RobotError("the mesh has vertices that are not finite", where=str(visual.file))
    r, g, b = (round(255 * value) for value in (visual.colour or part.colour)[:3])
    return Mesh(visual.link, placed, faces, (r, g, b))
