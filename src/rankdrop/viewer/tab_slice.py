"""The tab "Slice": the singular set over two or three joints, as points in a box beside the arm."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from rankdrop.families import in_slice
from rankdrop.family import Family
from rankdrop.robot import Array
from rankdrop.viewer import panel
from rankdrop.viewer.controls import Controls
from rankdrop.viewer.live import Now
from rankdrop.viewer.slice_box import SliceBox
from rankdrop.viewer.stage import rgb

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
        live, stage = self.controls.live, self.controls.stage
        limits = self.controls.session.limits
        found = in_slice(live.robot, live.task, q, joints, starts=starts or STARTS[len(joints)], limits=limits)
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
        self._told.content = panel.lines_html(_said(live.families, families, found.corank, found.starts))

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


def _said(
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
