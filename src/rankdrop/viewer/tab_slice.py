"""The tab "Slice": the singular set over two or three joints, as points in a box beside the arm.

A slice of joint space as a box beside the arm: where a configuration stands in it.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import product
from math import degrees

import numpy as np
from numpy.typing import NDArray

from rankdrop.families import in_slice
from rankdrop.family import Family
from rankdrop.local import sampling_box
from rankdrop.robot import Array, Robot
from rankdrop.task import Task
from rankdrop.viewer import panel
from rankdrop.viewer.controls import Controls
from rankdrop.viewer.scene import Now
from rankdrop.viewer.stage import rgb

EDGE = 0.8  # of the box, as a share of the arm's size
AXES = np.array([[0.78, 0.62, 0.0], [0.0, 0.0, 1.0], [-0.62, 0.78, 0.0]]) / np.array([[0.9964], [1.0], [0.9964]])
"""Directions of the first, second, third joint: across, up and away from the camera as the viewer places it."""
CORNER = np.array([-1.3, 0.12, 0.0]) @ AXES  # left of the arm, above the floor


@dataclass(frozen=True, eq=False)
class SliceBox:
    """Two or three joints along the edges of a box; two stand upright in a plane.

    Attributes:
        joints: numbers from 1, along `AXES`.
        low, high: (d,) range of each [rad, m].
        corner: (3,) of the box [m].
        edge: [m].
    """

    joints: tuple[int, ...]
    low: Array
    high: Array
    corner: Array
    edge: float

    @classmethod
    def of(cls, robot: Robot, task: Task, joints: tuple[int, ...], size: float, *, limits: bool) -> SliceBox:
        """The box for some joints of an arm of this size [m]."""
        low, high = sampling_box(robot, task, limits=limits)
        chosen = [joint - 1 for joint in joints]
        return cls(joints, low[chosen], high[chosen], size * CORNER, EDGE * size)

    def place(self, q: Array) -> Array:
        """(N, 3) where configurations (N, n) stand in the box [m]."""
        share = (q[:, [joint - 1 for joint in self.joints]] - self.low) / np.maximum(self.high - self.low, 1e-300)
        return np.asarray(self.corner + self.edge * share @ AXES[: len(self.joints)])

    def lines(self) -> Array:
        """(E, 2, 3) edges of the box, or of the square of two joints [m]."""
        corners = [np.array(one, dtype=np.float64) for one in product((0, 1), repeat=len(self.joints))]
        edges = [[a, b] for i, a in enumerate(corners) for b in corners[i + 1 :] if np.abs(a - b).sum() == 1.0]
        return np.asarray(self.corner + self.edge * np.array(edges) @ AXES[: len(self.joints)])

    def labels(self, robot: Robot) -> list[tuple[str, Array]]:
        """What to write where: the joints at the middles of their edges, the ends of their ranges at the corners."""
        found = []
        for number, (joint, low, high) in enumerate(zip(self.joints, self.low, self.high, strict=True)):
            unit = robot.variables[joint - 1].unit
            way = AXES[number] * self.edge
            aside = -0.09 * self.edge * AXES[0 if number == 1 else 1]
            start = self.corner + (self.edge * AXES[0] if number == 2 else 0.0)
            found.append((f"{joint} {robot.variables[joint - 1].name}", start + 0.5 * way + 2.0 * aside))
            found.append((_value(low, unit), start + 0.06 * way + aside))
            found.append((_value(high, unit), start + 0.94 * way + aside))
        return found


def _value(value: float, unit: str) -> str:
    return f"{degrees(value):.0f}°" if unit == "rad" else f"{value:.3g} m"


COLOURS = (panel.BLUE, panel.VERMILION, panel.GREEN, panel.PURPLE, panel.ORANGE, panel.SKY)
"""Of the families, in their order; after the last one the first again."""
UNKNOWN = "#888888"
STARTS = {2: 1500, 3: 6000}
FOLLOWING = 400  # starts while the arm moves
_NONE = "–"


class SliceTab:
    """Choose joints, draw, and see where the arm stands in the slice."""

    def __init__(self, controls: Controls) -> None:
        self.controls = controls
        self._busy = threading.Lock()
        self._drawn: tuple[SliceBox, Array] | None = None
        robot, gui = controls.robot, controls.server.gui
        names = tuple(f"{number} {joint.name}" for number, joint in enumerate(robot.variables, start=1))
        with controls.tabs.add_tab("Slice"):
            if robot.n < 2:
                gui.add_html(panel.message_html("a slice needs two joints"))
                self._choices = []
                return
            first = min(1, robot.n - 2)
            self._choices = [
                gui.add_dropdown("across", names, initial_value=names[first]),
                gui.add_dropdown("up", names, initial_value=names[first + 1]),
                gui.add_dropdown("deep", (_NONE, *names), initial_value=_NONE),
            ]
            controls.button("draw the singular set", self.draw, colour="blue")
            self._follow = gui.add_checkbox("follow", False, hint="draw it anew when other joints move")
            controls.button("clear", self.clear)
            self._told = gui.add_html("")

    def draw(self) -> None:
        """Find the points and put them into the scene."""
        with self._busy:
            self._draw(self.controls.session.q, None)

    def _draw(self, q: Array, starts: int | None) -> None:
        joints = tuple(int(one.value.split()[0]) for one in self._choices if one.value != _NONE)
        starts = starts or STARTS[len(joints)]
        live, stage = self.controls.live, self.controls.stage
        limits = self.controls.session.limits
        found = in_slice(live.robot, live.task, q, joints, starts=starts, limits=limits)
        box = SliceBox.of(live.robot, live.task, joints, stage.size, limits=limits)
        scene = self.controls.server.scene
        families = live.monitor.look(found.q).family if len(found.q) else np.zeros(0, dtype=np.int32)
        colours = np.array([rgb(_colour(int(index))) for index in families])
        with self.controls.server.atomic():
            self._frame(box)
            if len(found.q):
                size = (0.009 if len(joints) == 2 else 0.005) * stage.size
                scene.add_point_cloud("/slice/points", box.place(found.q), colours.astype(np.uint8), point_size=size,
                                      point_shape="circle", precision="float32")  # fmt: skip
            else:
                scene.remove_by_name("/slice/points")
        self._drawn = box, q.copy()
        self._mark(q)
        self._told.content = panel.lines_html(_slice_notes(live.families, families, found.corank, starts))

    def _frame(self, box: SliceBox) -> None:
        scene, size = self.controls.server.scene, self.controls.stage.size
        scene.add_line_segments("/slice/box", box.lines().astype(np.float32), (128, 128, 128), thickness=0.004 * size)
        for i, (text, place) in enumerate(box.labels(self.controls.robot)):
            scene.add_label(f"/slice/label{i}", text, position=place, anchor="center-center", font_screen_scale=0.8)
        for i in range(3 * len(box.joints), 9):
            scene.remove_by_name(f"/slice/label{i}")

    def _mark(self, q: Array) -> None:
        if self._drawn is not None:
            size = self.controls.stage.size
            self.controls.server.scene.add_icosphere(
                "/slice/here", 0.022 * size, color=rgb(panel.ORANGE), position=self._drawn[0].place(q[None])[0]
            )

    def clear(self) -> None:
        """Take it off the scene."""
        self._drawn = None
        self.controls.server.scene.remove_by_name("/slice")

    def shown(self, now: Now, _source: object) -> None:
        """Move the mark; where the other joints have moved and it is wanted, draw anew in the background."""
        if self._drawn is None:
            return
        box, at = self._drawn
        self._mark(now.q)
        others = [j for j in range(len(at)) if j + 1 not in box.joints]
        if self._follow.value and np.abs(now.q - at)[others].max(initial=0.0) > 1e-6 and self._busy.acquire(False):
            threading.Thread(target=self._redraw, daemon=True, name="rankdrop-slice").start()

    def _redraw(self) -> None:
        try:
            self._draw(self.controls.session.q, FOLLOWING * (len(self._choices) - 1))
        except Exception as error:
            self.controls.say(str(error))
        finally:
            self._busy.release()


def _colour(index: int) -> str:
    return UNKNOWN if index < 0 else COLOURS[index % len(COLOURS)]


def _slice_notes(
    known: Sequence[Family], families: NDArray[np.int32], corank: NDArray[np.int64], starts: int
) -> list[str]:
    """How many points of which family, as HTML, and what a missing one does not prove."""
    if not len(corank):
        return [f"none of {starts} starts met a singularity in this slice; that is no proof"]
    lines = [f"{len(corank)} of {starts} starts arrived; the ball is where the arm stands"]
    for index in np.unique(families).tolist():
        here = families == index
        name = f"{known[index].id} {escape(known[index].name)}" if index >= 0 else "on no known family"
        ranks = ", ".join(str(k) for k in np.unique(corank[here]))
        lines.append(f"<span style='color:{_colour(index)}'>■</span> {name}: {int(here.sum())}, corank {ranks}")
    return lines
