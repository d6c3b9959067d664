"""The tab "Tour": the families one after the other, one sentence each in large type, for teaching."""

from __future__ import annotations

import numpy as np

from rankdrop.family import Family
from rankdrop.robot import count, lost_told
from rankdrop.viewer import panel
from rankdrop.viewer.controls import Controls

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
