"""The panel in viser: status, sliders and what can be done with the arm. The tabs stand in files of their own."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees, radians
from threading import Lock
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.local import sampling_box
from rankdrop.results import Explanation
from rankdrop.robot import Array
from rankdrop.viewer import panel
from rankdrop.viewer.live import Now
from rankdrop.viewer.session import Session
from rankdrop.viewer.stage import Stage

if TYPE_CHECKING:
    import viser

_MARGIN = 1e-6


def put(handle: Any, value: Any) -> None:
    """Set what an input shows; viser declares it read-only where it declares the type."""
    handle.value = value


class Controls:
    """Status and sliders.

    Args:
        server: of viser.
        session: the configuration.
        stage: the scene.
    """

    def __init__(self, server: viser.ViserServer, session: Session, stage: Stage) -> None:
        self.server, self.session, self.stage = server, session, stage
        self.robot, self.live = session.live.robot, session.live
        self.found: Explanation | None = None
        self.now: Now | None = None
        gui = server.gui
        self._status = gui.add_html(panel.message_html("…"))
        self._details = gui.add_html("")
        self._telling = Lock()  # two threads tell: what one says of an older configuration may not stay
        self._said = ""  # the details, while they are of the configuration that is shown
        self.message = gui.add_html("")
        self.tabs = gui.add_tab_group()
        self._unit = [degrees(1.0) if joint.unit == "rad" else 1.0 for joint in self.robot.variables]
        with self.tabs.add_tab("Joints"):
            self.sliders = [self._slider(i) for i in range(self.robot.n)]
            self.button("all joints to 0", lambda: session.go(np.zeros(self.robot.n)))
            self.button("a random configuration", lambda: session.go(self._random()))

    def _slider(self, index: int) -> viser.GuiSliderHandle[float]:
        joint = self.robot.variables[index]
        low, high = sampling_box(self.robot, self.live.task, limits=True)
        unit = self._unit[index]
        value = float(self.session.q[index] * unit)
        sign, step, digits = ("°", 0.1, 1) if joint.unit == "rad" else (" m", 0.001, 3)
        least, most = (round(bound * unit, digits) for bound in (low[index], high[index]))
        shown = round(value, digits)
        limited = np.isfinite(joint.lower) and np.isfinite(joint.upper)
        slider = self.server.gui.add_slider(
            f"{index + 1} {joint.name} [{sign.strip()}]", min(least, shown), max(most, shown), step, shown,
            hint=f"limits {joint.lower * unit:.4g} … {joint.upper * unit:.4g}{sign}" if limited else "no limits",
        )  # fmt: skip

        @slider.on_update
        def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:  # a hand moved it, not `shown`
                self.session.set_joint(index, slider.value / unit, slider)

        return slider

    def button(self, label: str, act: Callable[[], object], *, hint: str | None = None,
               colour: Any = "gray") -> viser.GuiButtonHandle:  # fmt: skip
        """A button; what goes wrong behind it is told in the panel."""
        handle = self.server.gui.add_button(label, hint=hint, color=colour)

        @handle.on_click
        def _(_event: object) -> None:
            self.attempt(act)

        return handle

    def attempt(self, act: Callable[[], object]) -> None:
        """Do it, and say what went wrong."""
        try:
            self.say("")
            act()
        except Exception as error:
            self.say(f"{error}" or type(error).__name__)

    def say(self, text: str) -> None:
        """One line below the status; empty to clear it."""
        self.message.content = panel.message_html(text) if text else ""

    def shown(self, now: Now, source: object) -> None:
        """A configuration was looked at."""
        with self._telling:
            self.now = now
            of_this = self.found is not None and np.array_equal(self.found.q, now.q)
            self._tell(now, self.found if of_this else None)
        for index, slider in enumerate(self.sliders):
            if slider is not source:
                self._place(index, float(now.q[index]) * self._unit[index])

    def _tell(self, now: Now, found: Explanation | None) -> None:
        """Status and details, of one configuration both; details of another one are dimmed until it is explained."""
        known = len(self.live.families)
        details = panel.details_html(found) if found is not None else panel.dimmed_html(self._said)
        status = panel.status_html(now, self.robot.n, self.live.generic_rank, known, found)
        if found is not None or self._said:
            self._details.content, self._said = details, details if found is not None else ""
        self._status.content = status

    def _place(self, index: int, value: float) -> None:
        """A slider to a value; its range grows where a motion goes beyond it."""
        slider = self.sliders[index]
        shown = round(value, 1 if self._unit[index] != 1.0 else 3)  # as many digits as the box has room for
        if shown < slider.min:
            slider.min = shown
        if shown > slider.max:
            slider.max = shown
        if slider.value != shown:
            put(slider, shown)

    def explained(self, found: Explanation) -> None:
        """A configuration was explained."""
        panel.details_html(found)  # what it works out late, before anybody waits for the lock
        with self._telling:
            self.found = found
            if self.now is not None and np.array_equal(self.now.q, found.q):
                self._tell(self.now, found)

    def _random(self) -> Array:
        low, high = sampling_box(self.robot, self.live.task, limits=True)
        wide = np.where(high - low > 2 * np.pi + _MARGIN, radians(180.0), np.inf)
        return np.random.default_rng().uniform(np.maximum(low, -wide), np.minimum(high, wide))
