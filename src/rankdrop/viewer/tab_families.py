"""The tab "Families": go to the nearest point of a family, to its witness, and walk along it.

The tab "Tour": the families one after the other, one sentence each in large type, for teaching.

The tab "Escape": motions out of the singularity, or away from the nearest one.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from html import escape as plain
from math import radians
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.families import Walk, family_distances
from rankdrop.family import Family
from rankdrop.local import Direction, Escape, JointEscape, escape, nearest_singularity, self_motion
from rankdrop.results import Explanation, angle, condition_sentences, motion, short
from rankdrop.robot import Array, count, lost_told
from rankdrop.viewer import panel
from rankdrop.viewer.controls import Controls

if TYPE_CHECKING:
    import viser


STEP = radians(5.0)  # of a click [rad; slides in length scales]
PACE = 0.012  # of a walk, per frame [rad]
_ON = 1e-6  # so near a family q is on it: walking starts there [rad]


class FamiliesTab:
    """The families of the atlas.

    Args:
        controls: the panel.
        source: where the families come from, in words.
    """

    def __init__(self, controls: Controls, source: str) -> None:
        self.controls = controls
        self.families = controls.live.families
        with controls.tabs.add_tab("Families"):
            controls.button("go to the nearest singular configuration", self._nearest, colour="blue")
            if not self.families:
                controls.server.gui.add_html(panel.message_html(
                    "No families are known for this arm. `rankdrop analyze … --json FILE` finds them; "
                    "then start with --analysis FILE."))  # fmt: skip
                return
            self._choice = controls.server.gui.add_dropdown("family", self._names(), initial_value=self._names()[0])
            self._about = controls.server.gui.add_html("")
            controls.button("go to its closest point", self._closest)
            controls.button("go to its witness", lambda: controls.session.go(np.array(self.family.witness)))
            self._add_walk()
            controls.server.gui.add_html(panel.message_html(f"families: {source}"))
            self._choice.on_update(self._chosen)
            self._chosen(None)

    def _add_walk(self) -> None:
        gui, names = self.controls.server.gui, [joint.name for joint in self.controls.robot.variables]
        with gui.add_folder("walk along the family"):
            options = [f"{number} {name}" for number, name in enumerate(names, start=1)]
            self._joint = gui.add_dropdown("by joint", tuple(options), initial_value=options[0])
            arrows: Any = gui.add_button_group("step", ("◀ 5°", "5° ▶"))
            going: Any = gui.add_button_group("walk", ("◀", "■", "▶"))
            self._told = gui.add_html("")
        arrows.on_click(lambda _: self.controls.attempt(lambda: self._step(-1 if arrows.value.startswith("◀") else 1)))
        going.on_click(lambda _: self.controls.attempt(lambda: self._go({"◀": -1, "■": 0, "▶": 1}[going.value])))

    def _names(self) -> tuple[str, ...]:
        return tuple(f"{family.id} {family.name}" for family in self.families)

    @property
    def family(self) -> Family:
        """The chosen one."""
        return self.families[self._names().index(self._choice.value)]

    def _chosen(self, _event: object) -> None:
        family = self.family
        conditions = map(plain, condition_sentences(self.controls.robot, self.controls.live.task, family))
        lines = [f"<b>{plain(family.name)}</b>", f"corank {family.corank}, dimension {family.dimension}", *conditions,
                 *(f"lost: {plain(words)}" for words in family.lost_words),
                 plain(lost_told(self.controls.robot, family.lost_words))]  # fmt: skip
        self._about.content = panel.lines_html(lines)

    def _nearest(self) -> None:
        session, live = self.controls.session, self.controls.live
        nearest = nearest_singularity(live.robot, session.q, live.task, limits=session.limits)
        if nearest is None:
            self.controls.say("no singular configuration was found")
        else:
            session.go(np.array(nearest.q))

    def _closest(self) -> None:
        point = self._nearest_point()
        if point is not None:
            self.controls.session.go(point)

    def _nearest_point(self) -> Array | None:
        live, session = self.controls.live, self.controls.session
        record = family_distances([self.family], live.robot, session.q, live.task, limits=session.limits)[0]
        if not record.q:
            where = " within the joint limits" if session.limits else ""
            self.controls.say(f"no point of {self.family.id} was reached{where}")
            return None
        self.controls.say(f"{angle(record.distance)} away" if record.distance > _ON else "")
        return np.array(record.q)

    def _walk_from_here(self) -> tuple[Walk, Array, int] | None:
        live = self.controls.live
        walk, joint = Walk(live.robot, live.task, self.family), int(self._joint.value.split()[0])
        q = walk.back(self.controls.session.q)
        if q is None or np.abs(q - self.controls.session.q).max() > 1e-4:
            q = self._nearest_point()
        if q is None:
            return None
        movable = walk.movable(q)
        self._told.content = panel.message_html(f"joints that move along it here: {', '.join(map(str, movable))}")
        if joint not in movable:
            self.controls.say(f"joint {joint} stands still along {self.family.id}; choose one of "
                              f"{', '.join(map(str, movable))}")  # fmt: skip
            return None
        return walk, q, joint

    def _step(self, sign: int) -> None:
        ready = self._walk_from_here()
        if ready is not None:
            walk, q, joint = ready
            there = walk.step(q, joint, sign * STEP)
            if there is None:
                self.controls.say("the family ends here, or turns too sharply")
            else:
                self.controls.session.go(there)

    def _go(self, sign: int) -> None:
        if sign == 0:
            self.controls.session.stop()
            return
        ready = self._walk_from_here()
        if ready is not None:
            self.controls.session.follow(_walking(*ready, sign * PACE))


def _walking(walk: Walk, q: Array, joint: int, pace: float) -> Iterator[Array]:
    here: Array | None = q
    while here is not None:
        yield here
        here = walk.step(here, joint, pace)


_PARTS = ("shoulder", "elbow", "wrist")
_STOPS = 8


def stops_of(families: tuple[Family, ...]) -> tuple[Family, ...]:
    """The families of a tour: shoulder, elbow and wrist of corank 1 first, then others of corank 1, at most eight."""
    first = [family for family in families if family.corank == 1 and family.named]
    order = {part: place for place, part in enumerate(_PARTS)}
    ranked = sorted(first, key=lambda family: order.get(family.name.split(":")[0].split(" ")[0], len(_PARTS)))
    return tuple(ranked[:_STOPS])


def sentence_of(lost: str) -> str:
    """What is lost, by the arrow that shows it, to be read from the back of a room.

    Args:
        lost: of a family (`Family.lost_words`).
    """
    if lost.startswith("cannot rotate"):
        return "The tool cannot turn about the red arrow."
    if lost.startswith("cannot translate"):
        return "The tool cannot move along the red arrow."
    if "nearly no motion along" in lost:
        return "The tool can hardly move along the red arrow."
    return "Moving along the red arrow and turning are tied together: one freedom of the tool is lost."


class TourTab:
    """Forward and back through the families."""

    def __init__(self, controls: Controls) -> None:
        self.controls = controls
        self.stops = stops_of(controls.live.families)
        self.place = -1
        gui = controls.server.gui
        with controls.tabs.add_tab("Tour"):
            if not self.stops:
                gui.add_html(panel.message_html("No families are known for this arm: there is nothing to show."))
                return
            stops = count(len(self.stops), "stop")
            controls.button("next", lambda: self.go(1), colour="blue")
            controls.button("back", lambda: self.go(-1))
            self._told = gui.add_html(panel.large_html("Singularities", f"{stops}: press next."))

    def go(self, steps: int) -> None:
        """To another stop, round and round."""
        self.place = (max(self.place, 0 if steps < 0 else -1) + steps) % len(self.stops)
        family = self.stops[self.place]
        note = lost_told(self.controls.robot, family.lost_words)
        self._told.content = panel.large_html(
            f"{self.place + 1} of {len(self.stops)} · {family.name}", sentence_of(family.lost_words[0])
        ) + panel.message_html(f"The tool {family.lost_words[0]}.{note and f' {note}'}")
        self.controls.session.go(np.array(family.witness))


_STILL = 0.6  # length of the self-motion that is followed [rad]


class EscapeTab:
    """Buttons that move the arm out: the best direction, the best two joints, each joint alone, the end effector still.
    """

    def __init__(self, controls: Controls) -> None:
        self.controls = controls
        with controls.tabs.add_tab("Escape"):
            self._best = controls.button("best direction", lambda: self._along("best_direction"), colour="blue")
            self._pair = controls.button("best two joints", lambda: self._along("best_pair"))
            self._still = controls.button("with the tool held still", self._keep_still)
            self._single = [
                controls.button(f"joint {number} {joint.name}", partial(self._move_joint, number))
                for number, joint in enumerate(controls.robot.variables, start=1)
            ]
            controls.button("stop", controls.session.stop)

    def explained(self, found: Explanation) -> None:
        """Label the buttons with what they do from here."""
        out, r = found.escape, found.rank.generic_rank
        lost = bool(out.corank)
        best = {one.number: one for one in out.single}
        for number, button in enumerate(self._single, start=1):
            one = best[number]
            unit = found.robot.variables[number - 1].unit
            name = f"joint {number} {one.joint}"
            usable = one.order is not None and one.within_limits and abs(one.step) > 0
            self._label(button, f"{name}: {motion(one.step, unit)} → σ{r} = {short(one.sigma_after, 2)}" if usable
                        else f"{name}: {_why_not(one, lost)}", usable)  # fmt: skip
        self._label(self._best, _direction_label("best direction", out.best_direction, r), out.best_direction.step > 0)
        pair = out.best_pair
        self._label(self._pair, "best two joints" if pair is None else _direction_label(
            f"joints {' and '.join(map(str, pair.numbers))}", pair, r), pair is not None and pair.step > 0)  # fmt: skip
        self._label(self._still, "with the tool held still" if out.still else "tool held still: none found"
                    if out.avoidable is None else "tool held still: impossible", out.still is not None)  # fmt: skip

    def _label(self, button: viser.GuiButtonHandle, text: str, usable: bool) -> None:
        button.label = text
        button.disabled = not usable

    def _now(self) -> Escape:
        """Ways out from where the arm is at this moment: what was explained may be of another place."""
        live = self.controls.live
        return escape(live.robot, self.controls.session.q, live.task)

    def _move_joint(self, number: int) -> None:
        session = self.controls.session
        one = next(one for one in self._now().single if one.number == number)
        target = session.q
        target[number - 1] += one.step
        session.go(target)

    def _along(self, which: str) -> None:
        session = self.controls.session
        direction: Direction | None = getattr(self._now(), which)
        if direction is None or direction.step == 0.0:
            self.controls.say("there is no room for a motion inside the limits")
            return
        session.go(session.q + direction.step * np.array(direction.delta))

    def _keep_still(self) -> None:
        session, live = self.controls.session, self.controls.live
        still = self._now().still
        if still is None:
            self.controls.say("no self-motion that restores the rank was found")
            return
        traced = self_motion(live.robot, session.q, live.task, length=max(_STILL, still.step), step=0.03,
                             direction=np.array(still.delta), limits=session.limits)  # fmt: skip
        session.follow(traced.q)


def _why_not(one: JointEscape, lost: bool) -> str:
    if one.order is not None:
        return "no room inside the limits"
    return f"gains {one.gain} of the rank, not all" if one.gain and lost else "no help"


def _direction_label(name: str, one: Direction, r: int) -> str:
    return f"{name} → σ{r} = {short(one.sigma_after, 2)}" if one.step > 0 else f"{name}: no room inside the limits"
