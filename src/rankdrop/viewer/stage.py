"""The arm and its arrows in a viser scene. What is drawn where is decided in `scene` and `body`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.families import VIEW
from rankdrop.kinematics import link_poses
from rankdrop.lists import flat_map
from rankdrop.local import spine
from rankdrop.robot import Array, Mesh, Robot, reach
from rankdrop.viewer.panel import CIRCUITS, ORANGE, SKY, VERMILION
from rankdrop.viewer.scene import Live, Now, axis_lines, barrel_mesh, capsule_mesh, circuit_of, rods, wxyz

if TYPE_CHECKING:
    import viser

Rgb = tuple[int, int, int]
_LIGHT_ARM, _DARK_ARM = (196, 202, 210), (150, 158, 168)
_LIGHT_JOINT, _DARK_JOINT = (86, 98, 114), (74, 84, 98)
_DULL = 0.45  # dark meshes are lifted so far towards grey: black parts are not seen on a dark page
_LIT = (176, 34, 0)  # vermilion under the lights of the scene, which wash it out to orange
_SAME = 1e-3  # links of the ghost that differ by less are those of the arm [lengths of the arm, quaternion]
_WITHIN = 0.97  # what of the ghost turns in place is hidden in the arm, not mixed with it
_BODY = 0.05  # of links and joints about the line of the arm, per size
_NONE = np.zeros((1, 2, 3), dtype=np.float32)


FOV = np.radians(40.0)
"""Angle of view of the page from top to bottom: wider ones enlarge near parts [rad]."""
FREE = {True: (0.64, 1.0), False: (1.0, 0.5)}
"""Width and height of what the panel leaves of the window, which is wide or upright: left of it, or above it."""
_ASPECT = 1.55  # of a window that is wide, until it is known
_FILLED = 0.92  # of that part that the arm takes at the start; the rest is for its arrows
_NEAREST = 1e-3  # of the camera to a point [m]
_NOTHING = np.zeros((0, 3))
_STEEP = 0.05  # sine of the angle between the view and the upright from which the camera is moved
TOWARD = np.array([np.cos(VIEW) * np.cos(0.38), np.sin(VIEW) * np.cos(0.38), np.sin(0.38)])
"""(3,) from the arm to the camera."""


def camera_for(
    points: Array, *, wide: bool, aspect: float = _ASPECT, toward: Array = TOWARD
) -> tuple[Array, Array]:
    """Position and aim of the nearest camera that sees these points (N, 3) [m] in the free part of the window.

    A point (x, z), z towards the camera, is seen from (X, Z) inside the edges of slopes L and R where
    L (Z − z) ≤ x − X ≤ R (Z − z). Such an X exists for Z ≥ (max (x + R z) − min (x + L z)) / (R − L).

    Args:
        points: what is to be seen.
        wide: the panel is on the right; else below.
        aspect: width of the window over its height.
        toward: (3,) unit vector from the points to the camera, not upright.
    """
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    up = np.cross(toward, right)
    across, height, near = (points @ np.stack([right, up, toward], axis=1)).T
    free, half = np.array(FREE[wide]), np.tan(FOV / 2) * np.array([aspect, 1.0])
    room = (1.0 - _FILLED) * half * free
    low = half * [-1.0, 1.0 - 2.0 * free[1]] + room
    high = half * [2.0 * free[0] - 1.0, 1.0] - room
    ends = list(zip((across, height), low, high, strict=True))
    least = np.array([(place + edge * near).min() for place, edge, _ in ends])
    most = np.array([(place + edge * near).max() for place, _, edge in ends])
    depth = max(float(((most - least) / (high - low)).max()), float(near.max()) + _NEAREST)
    side = (least - low * depth + most - high * depth) / 2
    position = right * side[0] + up * side[1] + toward * depth
    return position, position - (depth - float(near.min() + near.max()) / 2) * toward


def extent(robot: Robot, q: Array) -> Array:
    """(N, 3) points about the body of the arm at q (n,) [m]."""
    ends, body = spine(robot, q[None])[0], _BODY * reach(robot)
    return np.vstack([ends - body, ends + body])


def leaves_window(points: Array, position: Array, aim: Array, aspect: float) -> bool:
    """Whether a camera at `position` (3,) that looks at `aim` (3,) does not see all the points (N, 3) [m]."""
    ahead = (aim - position) / np.linalg.norm(aim - position)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= max(float(np.linalg.norm(right)), 1e-9)
    off = points - position
    half = np.tan(FOV / 2) * (off @ ahead)
    return bool(
        (half <= 0.0).any()
        or (np.abs(off @ right) > half * aspect).any()
        or (np.abs(off @ np.cross(right, ahead)) > half).any()
    )


def rgb(colour: str) -> Rgb:
    """#rrggbb as three numbers."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


class Stage:
    """What stands in the scene.

    Args:
        server: of viser.
        live: the arm.
        meshes: of its links; empty where it has none, then its body is drawn.
    """

    def __init__(self, server: viser.ViserServer, live: Live, meshes: tuple[Mesh, ...]) -> None:
        self.server, self.live = server, live
        self.size = live.size
        self.always_weakest = True
        self.blamed: dict[int, int] = {}
        scene = server.scene
        scene.set_up_direction("+z")
        self.links = [scene.add_frame(f"/arm/{i}", show_axes=False) for i in range(len(live.robot.joints) + 2)]
        self._tip = scene.add_frame(f"/arm/{len(self.links) - 1}/axes", axes_length=0.07 * self.size,
                                    axes_radius=0.006 * self.size, origin_radius=0.0)  # fmt: skip
        self._add_body()
        self._meshes = [
            scene.add_mesh_simple(f"/arm/{mesh.link}/mesh{i}", mesh.vertices, mesh.faces, color=_lighter(mesh.colour),
                                  flat_shading=False, side="double")
            for i, mesh in enumerate(meshes)
        ]  # fmt: skip
        self.has_meshes = bool(meshes)
        self._add_marks()
        self._add_ghost()
        self.show_meshes(self.has_meshes)
        self.paint(dark=False)

    def _add_body(self) -> None:
        scene, body = self.server.scene, self.live.body
        self._capsules = self._add_bars("arm", "link")
        self._barrels = self._add_bars("arm", "joint")
        self._labels = [
            scene.add_label(f"/arm/{barrel.link}/number{barrel.joint}", str(barrel.variable),
                            position=(barrel.start + barrel.end) / 2, anchor="center-center", font_screen_scale=0.75)
            for barrel in body["joint"]
        ]  # fmt: skip
        if body["rod"]:
            radius = 2 * body["rod"][0].radius
        else:
            radius = 0.01
        self._rods = scene.add_line_segments("/rods", _NONE, _LIGHT_ARM, thickness=radius, visible=bool(body["rod"]))
        self.grid = scene.add_grid("/floor", 4 * self.size, 4 * self.size, cell_size=0.1 * self.size,
                                   section_size=0.5 * self.size, position=(0.0, 0.0, -0.002 * self.size))  # fmt: skip

    def _add_bars(self, root: str, kind: str, share: float = 1.0, **look: Any) -> list[viser.MeshHandle]:
        """Meshes of the links or joints below a root of the scene; radii and joints are shortened to a share."""
        handles = []
        for i, bar in enumerate(self.live.body[kind]):
            cut = (1 - share) / 2 * (bar.end - bar.start)
            if kind == "link":
                ends = (bar.start, bar.end)
            else:
                ends = (bar.start + cut, bar.end - cut)
            shape = (capsule_mesh if kind == "link" else barrel_mesh)(*ends, share * bar.radius)
            handles.append(self.server.scene.add_mesh_simple(f"/{root}/{bar.link}/{kind}{i}", *shape, **look))
        return handles

    def _add_marks(self) -> None:
        scene, size = self.server.scene, self.size
        shape: Any = {"shaft_radius": 0.011 * size, "head_radius": 0.03 * size, "head_length": 0.08 * size}
        red = rgb(VERMILION)
        self._solid = scene.add_arrows("/lost/translations", _NONE, red, **shape, visible=False)
        self._heads = scene.add_arrows("/lost/rotation heads", _NONE, red, **shape, visible=False)
        self._dashes = scene.add_line_segments("/lost/rotations", _NONE, red, thickness=0.022 * size, visible=False)
        self._rings = scene.add_line_segments("/lost/rings", _NONE, red, thickness=0.014 * size, visible=False)
        each = np.array([[rgb(ORANGE)] * 2], dtype=np.uint8)  # of each end: one colour cannot become many later
        self._axes = scene.add_line_segments("/blamed", _NONE, each, thickness=0.012 * size, visible=False)

    def _add_ghost(self) -> None:
        scene = self.server.scene
        self._ghost_on = True
        self._ghost = [scene.add_frame(f"/ghost/{i}", show_axes=False, visible=False) for i in range(len(self.links))]
        look: Any = {"color": rgb(VERMILION), "opacity": 0.35, "cast_shadow": False}
        for kind in ("link", "joint"):
            self._add_bars("ghost", kind, _WITHIN, **look)

    def show_ghost(self, q: Array | None) -> None:
        """The ghost at a configuration, but for links that stand there already; None hides it."""
        if q is None or not self._ghost_on:
            for frame in self._ghost:
                frame.visible = False
            return
        poses = link_poses(self.live.robot, q)
        for link, frame, turn, pose in zip(self.links, self._ghost, wxyz(poses[:, :3, :3]), poses, strict=True):
            frame.wxyz = turn
            frame.position = pose[:3, 3]
            moved = np.linalg.norm(pose[:3, 3] - link.position) / self.size + np.abs(turn - link.wxyz).max()
            frame.visible = bool(moved > _SAME)

    def allow_ghost(self, shown: bool) -> None:
        """Whether a ghost is drawn at all."""
        self._ghost_on = shown
        if not shown:
            self.show_ghost(None)

    def look_at_arm(self, q: Array) -> None:
        """Place the camera so that the arm fills what the panel leaves of the window, left of it or above it.

        Args:
            q: (n,) at which it is to be seen whole [rad, m].
        """
        self._seen = extent(self.live.robot, q)
        camera = self.server.initial_camera
        camera.position, camera.look_at = camera_for(self._seen, wide=True)
        camera.fov = FOV
        self.server.on_client_connect(self._turn_upright)

    def _turn_upright(self, client: viser.ClientHandle) -> None:
        aspect = float(client.camera.aspect)
        if aspect < 1.0:
            client.camera.position, client.camera.look_at = camera_for(self._seen, wide=False, aspect=aspect)

    def keep_in_view(self, q: Array, also: Array = _NOTHING) -> None:
        """Move the cameras that do not see the whole arm at q (n,), each along its own direction of view.

        Args:
            q: (n,) of the arm [rad, m].
            also: (N, 3) points that are to be seen as well [m].
        """
        ends = np.vstack([spine(self.live.robot, q[None])[0], also])
        seen = np.vstack([extent(self.live.robot, q), also])
        for client in self.server.get_clients().values():
            camera = client.camera
            toward = camera.position - camera.look_at
            toward = toward / np.linalg.norm(toward)
            aspect = float(camera.aspect)
            if np.hypot(*toward[:2]) > _STEEP and leaves_window(ends, camera.position, camera.look_at, aspect):
                camera.position, camera.look_at = camera_for(seen, wide=aspect >= 1.0, aspect=aspect, toward=toward)

    def paint(self, *, dark: bool) -> None:
        """Colours of the body and the floor for a light or a dark page."""
        if dark:
            arm, self._joint = (_DARK_ARM, _DARK_JOINT)
        else:
            arm, self._joint = (_LIGHT_ARM, _LIGHT_JOINT)
        for capsule in self._capsules:
            capsule.color = arm
        self._rods.colors = np.array(arm, dtype=np.uint8)
        if dark:
            self.grid.cell_color = (60, 60, 64)
        else:
            self.grid.cell_color = (222, 222, 222)
        if dark:
            self.grid.section_color = (92, 92, 98)
        else:
            self.grid.section_color = (176, 176, 176)
        self._paint_joints()

    def _paint_joints(self) -> None:
        for barrel, handle in zip(self.live.body["joint"], self._barrels, strict=True):
            index = self.blamed.get(barrel.variable)
            if index is None:
                handle.color = self._joint
            else:
                handle.color = _circuit_colour(index)

    def show_meshes(self, shown: bool) -> None:
        """Meshes, or the body of capsules."""
        shown = shown and self.has_meshes
        for mesh in self._meshes:
            mesh.visible = shown
        for handle in [*self._capsules, *self._barrels]:
            handle.visible = not shown
        self._rods.visible = bool(self.live.body["rod"]) and not shown

    def show_numbers(self, shown: bool) -> None:
        """Numbers at the joints."""
        for label in self._labels:
            label.visible = shown

    def blame(self, circuits: Sequence[Sequence[int]], now: Now) -> None:
        """Mark the joints (numbers from 1) of circuits and their axes, each circuit in its colour."""
        blamed = circuit_of(circuits)
        if blamed != self.blamed:
            self.blamed = blamed
            self._paint_joints()
        lines = axis_lines(self.live.body, now.links, list(blamed))
        self._axes.visible = bool(len(lines))
        if len(lines):
            self._axes.points = lines.astype(np.float32)
            colours = np.array([_circuit_colour(index) for index in blamed.values()], dtype=np.uint8)
            self._axes.colors = np.repeat(colours[:, None], 2, axis=1)

    def show(self, now: Now) -> None:
        """Draw a configuration."""
        with self.server.atomic():
            for link, turn, pose in zip(self.links, wxyz(now.links[:, :3, :3]), now.links, strict=True):
                link.wxyz = turn
                link.position = pose[:3, 3]
            ends = rods(self.live.body, now.links)
            if len(ends):
                self._rods.points = ends.astype(np.float32)
            self._show_arrows(now)

    def _show_arrows(self, now: Now) -> None:
        strong = now.verdict in {"singular", "near"}
        if strong or self.always_weakest:
            shown = now.arrows
        else:
            shown = ()
        if strong:
            colour, lit = (rgb(VERMILION), _LIT)
        else:
            colour, lit = (rgb(SKY), rgb(SKY))
        turning = [arrow for arrow in shown if arrow.turns]
        shafts = [[arrow.start, arrow.end] for arrow in shown if not arrow.turns]
        heads = [[1.05 * arrow.neck - 0.05 * arrow.end, arrow.end] for arrow in turning]
        self._set(self._solid, shafts, lit)
        self._set(self._heads, heads, lit)
        self._set(self._dashes, flat_map(lambda arrow: arrow.segments(), turning), colour)
        self._set(self._rings, flat_map(lambda arrow: arrow.ring, shown), colour)

    def _set(self, handle: viser.ArrowsHandle | viser.LineSegmentsHandle, lines: list[Any], colour: Rgb) -> None:
        handle.visible = bool(lines)
        if lines:
            handle.points = np.array(lines, dtype=np.float32)
            handle.colors = np.array(colour, dtype=np.uint8)


def _circuit_colour(index: int) -> Rgb:
    return rgb(CIRCUITS[min(index, len(CIRCUITS) - 1)])


def _lighter(colour: Rgb) -> Rgb:
    r, g, b = (round(value + _DULL * max(0, 110 - max(colour))) for value in colour)
    return r, g, b
