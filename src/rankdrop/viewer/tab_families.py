"""The tabs "Families", "Tour", "Escape" and "Slice": the singular set around the arm.

Families: go to the nearest point of a family, to its witness, and walk along it. Tour: the families one after the
other, one sentence each in large type, for teaching. Escape: motions out of the singularity, or away from the nearest
one. Slice: the singular set over two or three joints, as points in a box next to the arm.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from html import escape as plain
from math import radians
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.distance import family_distances
from rankdrop.families import ArmPart, Family, LostFreedom, MotionKind, Walk, in_slice
from rankdrop.local import nearest_singularity
from rankdrop.robot import Array, count
from rankdrop.text import angle, condition_sentences, lost_note, lost_sentence, lost_sentences
from rankdrop.viewer import panel
from rankdrop.viewer.controls import Controls
from rankdrop.viewer.scene import Now
from rankdrop.viewer.slice_box import SliceBox
from rankdrop.viewer.stage import rgb

STEP = radians(5.0)  # of a click [rad; slides in length scales]
PACE = 0.012  # of a walk, per frame [rad]
_ON = 1e-6  # so near a family q is on it: walking starts there [rad]

_STOPS = 8

COLOURS = (panel.BLUE, panel.VERMILION, panel.GREEN, panel.PURPLE, panel.ORANGE, panel.SKY)
"""Of the families, in their order; after the last one the first again."""
UNKNOWN = "#888888"
STARTS = {2: 1500, 3: 6000}
FOLLOWING = 400  # starts while the arm moves
_NONE = "–"


class FamiliesTab:
    """The families of the atlas.

    Args:
        controls: the panel.
        source: where the families come from, in words.
    """

    def __init__(self, controls: Controls, source: str) -> None:
        self.controls = controls
        self.families = {f"{family.id} {controls.titles[family.id]}": family for family in controls.live.families}
        gui = controls.server.gui
        with controls.tabs.add_tab("Families"):
            controls.button("go to the nearest singular configuration", self._nearest, colour="blue")
            if not self.families:
                gui.add_html(panel.message_html(
                    "No families are known for this arm. `rankdrop analyze … --json FILE` finds them; "
                    "then start with --analysis FILE."))  # fmt: skip
                return
            self.ui = SimpleNamespace(
                choice=gui.add_dropdown("family", tuple(self.families)),
                about=gui.add_html(""),
                closest=controls.button("go to its closest point", self._closest),
                witness=controls.button("go to its witness", self._witness),
                **self._walk_controls(),
                source=gui.add_html(panel.message_html(f"families: {source}")),
            )
        self.ui.choice.on_update(lambda _: self._describe())
        self._describe()

    def _walk_controls(self) -> dict[str, Any]:
        controls = self.controls
        with controls.server.gui.add_folder("walk along the family"):
            return {
                "joint": controls.server.gui.add_dropdown("by joint", controls.joints),
                "step": controls.buttons("step", {"◀ 5°": lambda: self._step(-1), "5° ▶": lambda: self._step(1)}),
                "walk": controls.buttons("walk", {"◀": lambda: self._go(-1), "■": controls.session.stop,
                                                  "▶": lambda: self._go(1)}),
                "text": controls.server.gui.add_html(""),
            }  # fmt: skip

    @property
    def family(self) -> Family:
        """The chosen one."""
        return self.families[self.ui.choice.value]

    def _describe(self) -> None:
        family, robot = self.family, self.controls.robot
        lines = [f"<b>{plain(self.controls.titles[family.id])}</b>",
                 f"corank {family.corank}, dimension {family.dimension}",
                 *map(plain, condition_sentences(robot, self.controls.live.task, family)),
                 *(f"lost: {plain(words)}" for words in lost_sentences(family.lost_freedoms)),
                 plain(lost_note(robot, family.lost_freedoms))]  # fmt: skip
        self.ui.about.content = panel.lines_html(lines)

    def _nearest(self) -> None:
        session, live = self.controls.session, self.controls.live
        nearest = nearest_singularity(live.robot, session.q, live.task, limits=session.limits)
        if nearest is None:
            self.controls.say("no singular configuration was found")
        else:
            session.go(np.array(nearest.q))

    def _witness(self) -> None:
        self.controls.session.go(np.array(self.family.witness))

    def _closest(self) -> None:
        point = self._nearest_point()
        if point is not None:
            self.controls.session.go(point)

    def _nearest_point(self) -> Array | None:
        live, session = self.controls.live, self.controls.session
        record = family_distances([self.family], live.robot, session.q, live.task, limits=session.limits)[0]
        if not record.q:
            if session.limits:
                where = " within the joint limits"
            else:
                where = ""
            self.controls.say(f"no point of {self.family.id} was reached{where}")
            return None
        self.controls.say(f"{angle(record.distance)} away" if record.distance > _ON else "")
        return np.array(record.q)

    def _start_of_walk(self) -> tuple[Walk, Array, int] | None:
        """The walk, the configuration on the family where it starts, and the joint that leads it; None: no walk."""
        live, session = self.controls.live, self.controls.session
        walk, joint = Walk(live.robot, live.task, self.family), int(self.ui.joint.value.split()[0])
        q = walk.project_onto_family(session.q)
        if q is None or np.abs(q - session.q).max() > 1e-4:
            q = self._nearest_point()
        if q is None:
            return None
        movable = walk.movable(q)
        names = ", ".join(map(str, movable))
        self.ui.text.content = panel.message_html(f"joints that move along it here: {names}")
        if joint in movable:
            return walk, q, joint
        self.controls.say(f"joint {joint} stands still along {self.family.id}; choose one of {names}")
        return None

    def _step(self, sign: int) -> None:
        if (ready := self._start_of_walk()) is not None:
            walk, q, joint = ready
            there = walk.step(q, joint, sign * STEP)
            if there is None:
                self.controls.say("the family ends here, or turns too sharply")
            else:
                self.controls.session.go(there)

    def _go(self, sign: int) -> None:
        if (ready := self._start_of_walk()) is not None:
            self.controls.session.follow(_walking(*ready, sign * PACE))


def _walking(walk: Walk, q: Array | None, joint: int, pace: float) -> Iterator[Array]:
    while q is not None:
        yield q
        q = walk.step(q, joint, pace)


def stops_of(families: tuple[Family, ...]) -> tuple[Family, ...]:
    """The families of a tour: shoulder, elbow and wrist of corank 1 first, then others of corank 1, at most eight."""
    first = [family for family in families if family.corank == 1 and family.named]
    places = {part: place for place, part in enumerate(ArmPart)}
    ranked = sorted(first, key=lambda family: min((places[part] for part in family.called.parts), default=len(places)))
    return tuple(ranked[:_STOPS])


def sentence_of(lost: LostFreedom) -> str:
    """What is lost, by the arrow that shows it, to be read from the back of a room."""
    if lost.kind is MotionKind.ROTATION:
        return "The tool cannot turn about the red arrow."
    if lost.kind is MotionKind.TRANSLATION:
        return "The tool cannot move along the red arrow."
    if lost.nearly is MotionKind.TRANSLATION:
        return "The tool can hardly move along the red arrow."
    return "Moving along the red arrow and turning are tied together: one freedom of the tool is lost."


class TourTab:
    """Forward and back through the families."""

    def __init__(self, controls: Controls) -> None:
        self.controls = controls
        self.stops = stops_of(controls.live.families)
        self.place = -1
        with controls.tabs.add_tab("Tour"):
            text = panel.message_html("No families are known for this arm: there is nothing to show.")
            if self.stops:
                controls.button("next", lambda: self.go(1), colour="blue")
                controls.button("back", lambda: self.go(-1))
                text = panel.large_html("Singularities", f"{count(len(self.stops), 'stop')}: press next.")
            self._told = controls.server.gui.add_html(text)

    def go(self, steps: int) -> None:
        """To another stop, round and round."""
        self.place = (max(self.place, 0 if steps < 0 else -1) + steps) % len(self.stops)
        family = self.stops[self.place]
        note = lost_note(self.controls.robot, family.lost_freedoms)
        title = self.controls.titles[family.id]
        self._told.content = panel.large_html(
            f"{self.place + 1} of {len(self.stops)} · {title}", sentence_of(family.lost_freedoms[0])
        ) + panel.message_html(f"The tool {lost_sentence(family.lost_freedoms[0])}.{note and f' {note}'}")
        self.controls.session.go(np.array(family.witness))


class SliceTab:
    """Choose joints, draw, and see where the arm stands in the slice."""

    def __init__(self, controls: Controls) -> None:
        self.controls = controls
        self._busy = threading.Lock()
        self._drawn: tuple[SliceBox, Array] | None = None
        gui, names = controls.server.gui, controls.joints
        with controls.tabs.add_tab("Slice"):
            if len(names) < 2:
                gui.add_html(panel.message_html("a slice needs two joints"))
                return
            first = min(1, len(names) - 2)
            self.ui = SimpleNamespace(
                axes=[
                    gui.add_dropdown("across", names, initial_value=names[first]),
                    gui.add_dropdown("up", names, initial_value=names[first + 1]),
                    gui.add_dropdown("deep", (_NONE, *names), initial_value=_NONE),
                ],
                draw=controls.button("draw the singular set", self.draw, colour="blue"),
                follow=gui.add_checkbox("follow", False, hint="draw it anew when other joints move"),
                clear=controls.button("clear", self.clear),
                text=gui.add_html(""),
            )

    def draw(self) -> None:
        """Find the points and put them into the scene, where every camera sees them."""
        with self._busy:
            q = self.controls.session.q
            self._draw(q, None)
            if self._drawn is not None:
                self.controls.stage.keep_in_view(q, self._drawn[0].ends(self.controls.robot))

    def _draw(self, q: Array, starts: int | None) -> None:
        joints = tuple(int(choice.value.split()[0]) for choice in self.ui.axes if choice.value != _NONE)
        starts = starts or STARTS[len(joints)]
        live, size, limits = self.controls.live, self.controls.stage.size, self.controls.session.limits
        points = in_slice(live.robot, live.task, q, joints, starts=starts, limits=limits)
        box = SliceBox.of(live.robot, live.task, joints, size, limits=limits)
        scene = self.controls.server.scene
        if len(points.q):
            families = live.monitor.look(points.q).family
        else:
            families = np.zeros(0, dtype=np.int32)
        colours = np.array([rgb(_colour(int(index))) for index in families], dtype=np.uint8)
        with self.controls.server.atomic():
            self._frame(box)
            scene.remove_by_name("/slice/points")
            if len(points.q):
                scene.add_point_cloud("/slice/points", box.place(points.q), colours, point_shape="circle",
                                      point_size=(0.009 if len(joints) == 2 else 0.005) * size,
                                      precision="float32")  # fmt: skip
        self._drawn = box, q.copy()
        self._mark(q)
        self.ui.text.content = panel.lines_html(_slice_notes(live.families, families, points.corank, starts))

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

    def on_look(self, now: Now, _source: object) -> None:
        """Move the mark; where the other joints have moved and it is wanted, draw anew in the background."""
        if self._drawn is None:
            return
        box, at = self._drawn
        self._mark(now.q)
        others = [j for j in range(len(at)) if j + 1 not in box.joints]
        if self.ui.follow.value and np.abs(now.q - at)[others].max(initial=0.0) > 1e-6 and self._busy.acquire(False):
            threading.Thread(target=self._redraw, daemon=True, name="rankdrop-slice").start()

    def _redraw(self) -> None:
        try:
            self._draw(self.controls.session.q, FOLLOWING * (len(self.ui.axes) - 1))
        except Exception as error:
            self.controls.say(str(error))
        finally:
            self._busy.release()


def _colour(index: int) -> str:
    if index < 0:
        return UNKNOWN
    return COLOURS[index % len(COLOURS)]


def _slice_notes(
    known: Sequence[Family], families: NDArray[np.int32], corank: NDArray[np.int64], starts: int
) -> list[str]:
    """How many points of which family, as HTML, and what a missing one does not prove."""
    if not len(corank):
        return [f"none of {starts} starts found a singularity in this slice; that is no proof"]
    lines = [f"{len(corank)} of {starts} starts arrived; the ball is where the arm stands"]
    for index in np.unique(families).tolist():
        here = families == index
        if index >= 0:
            name = f"{known[index].id} {plain(known[index].name)}"
        else:
            name = "on no known family"
        ranks = ", ".join(str(k) for k in np.unique(corank[here]))
        lines.append(f"<span style='color:{_colour(index)}'>■</span> {name}: {int(here.sum())}, corank {ranks}")
    return lines
