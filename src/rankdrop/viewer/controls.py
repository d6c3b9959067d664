"""The panel in viser: status, sliders and what can be done with the arm. The tabs stand in files of their own.

The handle at the tip: pull it, and the arm follows by the damped inverse, step by step after the hand.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import degrees, radians
from threading import Lock
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.local import damped_inverse, sampling_box
from rankdrop.poses import Aim
from rankdrop.results import Explanation
from rankdrop.robot import Array, Robot
from rankdrop.task import WORLD_ALIGNED, Task
from rankdrop.text import family_title
from rankdrop.viewer import panel
from rankdrop.viewer.scene import Now, wxyz
from rankdrop.viewer.session import Session
from rankdrop.viewer.stage import Stage

if TYPE_CHECKING:
    import viser


_MARGIN = 1e-6
_FAR = 0.02  # what is missing from here on is reported [length scales, rad]

STEPS = 12  # of one pull: what a hand moves in a thirtieth of a second takes three
DAMPING, THRESHOLD = 0.08, 0.12  # λ₀ and ε of `damped_inverse`: no damping away from singularities
_MOST = 0.25  # of one step, in joints [rad] and lengths per length scale
_THERE = 1e-6  # what may be missing at the end [length scales, rad]


def set_input(handle: Any, value: Any) -> None:
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
        self.titles = {family.id: family_title(self.robot, self.live.task, family) for family in self.live.families}
        self.joints = tuple(f"{number} {joint.name}" for number, joint in enumerate(self.robot.variables, start=1))
        self._unit = [degrees(1.0) if joint.unit == "rad" else 1.0 for joint in self.robot.variables]
        self._handle = server.scene.add_transform_controls("/handle", scale=0.22 * self.live.size, visible=False)
        self._handle.on_update(self._handle_moved)
        with self.tabs.add_tab("Joints"):
            self.sliders = [self._slider(i) for i in range(self.robot.n)]
            self.button("all joints to 0", lambda: session.go(np.zeros(self.robot.n)))
            self.button("a random configuration", lambda: session.go(self._random()))

    def _slider(self, index: int) -> viser.GuiSliderHandle[float]:
        joint = self.robot.variables[index]
        low, high = sampling_box(self.robot, self.live.task, limits=True)
        unit = self._unit[index]
        value = float(self.session.q[index] * unit)
        if joint.unit == "rad":
            sign, step, digits = ("°", 0.1, 1)
        else:
            sign, step, digits = (" m", 0.001, 3)
        least, most = (round(bound * unit, digits) for bound in (low[index], high[index]))
        shown = round(value, digits)
        limited = np.isfinite(joint.lower) and np.isfinite(joint.upper)
        slider = self.server.gui.add_slider(
            f"{index + 1} {joint.name} [{sign.strip()}]", min(least, shown), max(most, shown), step, shown,
            hint=f"limits {joint.lower * unit:.4g} … {joint.upper * unit:.4g}{sign}" if limited else "no limits",
        )  # fmt: skip

        slider.on_update(lambda event: self._on_drag(event, index))
        return slider

    def _on_drag(self, event: viser.GuiEvent[Any], index: int) -> None:
        if event.client_id is not None:  # a hand moved it, not `shown`
            slider = self.sliders[index]
            self.session.set_joint(index, slider.value / self._unit[index], slider)

    def button(self, label: str, act: Callable[[], object], *, hint: str | None = None,
               colour: Any = "gray") -> viser.GuiButtonHandle:  # fmt: skip
        """A button; what goes wrong behind it is told in the panel."""
        handle = self.server.gui.add_button(label, hint=hint, color=colour)
        handle.on_click(lambda _: self.attempt(act))
        return handle

    def buttons(self, label: str, acts: Mapping[str, Callable[[], object]], *,
                visible: bool = True) -> viser.GuiButtonGroupHandle:  # fmt: skip
        """A row of buttons: word -> what it does."""
        handle = self.server.gui.add_button_group(label, tuple(acts), visible=visible)
        handle.on_click(lambda _: self.attempt(acts[handle.value]))
        return handle

    def upload(self, label: str, types: str, act: Callable[[Any], object]) -> viser.GuiUploadButtonHandle:
        """A button that gives a file of the reader's to `act`."""
        handle = self.server.gui.add_upload_button(label, mime_type=types, color="gray")
        handle.on_upload(lambda event: self.attempt(lambda: act(event.target.value)))
        return handle

    def check(self, label: str, value: bool, act: Callable[[bool], object], hint: str | None = None) -> None:
        """A box to be checked."""
        handle = self.server.gui.add_checkbox(label, value, hint=hint)
        handle.on_update(lambda _: self.attempt(lambda: act(handle.value)))

    def attempt(self, act: Callable[[], object]) -> None:
        """Do it, and say what went wrong."""
        try:
            self.say("")
            act()
        except Exception as error:
            self.say(f"{error}" or type(error).__name__)

    def say(self, text: str) -> None:
        """One line below the status; empty to clear it."""
        if text:
            self.message.content = panel.message_html(text)
        else:
            self.message.content = ""

    def on_look(self, now: Now, source: object) -> None:
        """A configuration was looked at."""
        with self._telling:
            self.now = now
            of_this = self.found is not None and np.array_equal(self.found.q, now.q)
            self._tell(now, self.found if of_this else None)
        if source is not self._handle:
            self._place_handle(now)
        for index, slider in enumerate(self.sliders):
            if slider is not source:
                self._place(index, float(now.q[index]) * self._unit[index])

    def _tell(self, now: Now, explanation: Explanation | None) -> None:
        """Status and details, of one configuration both; details of another one are dimmed until it is explained."""
        if explanation is not None:
            details = panel.details_html(explanation)
        else:
            details = panel.dimmed_html(self._said)
        status = panel.status_html(now, self.robot.n, self.live.generic_rank, self.titles, explanation)
        if explanation is not None or self._said:
            self._details.content, self._said = details, details if explanation is not None else ""
        self._status.content = status

    def _place(self, index: int, value: float) -> None:
        slider = self.sliders[index]
        shown = round(value, 1 if self._unit[index] != 1.0 else 3)  # as many digits as the box has room for
        if not slider.min <= shown <= slider.max:
            slider.min = min(slider.min, shown)
            slider.max = max(slider.max, shown)
        if slider.value != shown:
            set_input(slider, shown)

    def on_explanation(self, explanation: Explanation) -> None:
        """A configuration was explained."""
        panel.details_html(explanation)  # what it works out late, before anybody waits for the lock
        with self._telling:
            self.found = explanation
            if self.now is not None and np.array_equal(self.now.q, explanation.q):
                self._tell(self.now, explanation)

    def show_handle(self, shown: bool) -> None:
        """Show or hide the handle at the tip."""
        self._handle.visible = shown
        if self.now is not None:
            self._place_handle(self.now)

    def _place_handle(self, now: Now) -> None:
        if self._handle.visible:
            self._handle.position = now.links[-1][:3, 3]
            self._handle.wxyz = wxyz(now.links[-1][:3, :3])

    def _handle_moved(self, event: Any) -> None:
        if getattr(event, "client_id", None) is not None:  # a hand moved it, not `shown`
            from viser.transforms import SO3

            target = np.eye(4)
            target[:3, :3] = SO3(np.array(self._handle.wxyz)).as_matrix()
            target[:3, 3] = self._handle.position
            self.attempt(lambda: self.pull(target))

    def pull(self, target: Array) -> None:
        """Move the arm towards a pose (4, 4) of its tip."""
        q, missing = pull_towards(self.robot, self.live.task, self.session.q, target)
        self.session.set(q, self._handle)
        if missing > _FAR:
            self.say("the tip cannot follow to there from here: a limit, a singularity, or out of reach")

    def _random(self) -> Array:
        low, high = sampling_box(self.robot, self.live.task, limits=True)
        wide = np.where(high - low > 2 * np.pi + _MARGIN, radians(180.0), np.inf)
        return np.random.default_rng().uniform(np.maximum(low, -wide), np.minimum(high, wide))


def pull_towards(robot: Robot, task: Task, q: Array, target: Array) -> tuple[Array, float]:
    """From q towards a pose of the tip, inside the joint limits.

        q ← q + J⁺(λ) e,  e = (Δp; θ u)

    with the damped inverse of `rankdrop.local.damped_inverse`. Only what the task asks for is followed: an arm for
    positions keeps its orientation free.

    Args:
        robot, task: the arm.
        q: (n,) where it is [rad, m].
        target: (4, 4) pose of the tip in the base frame.

    Returns:
        (n,) the nearest configuration met, and what is missing there: ‖(Δp / length scale; θ)‖ of the task's rows.
    """
    aim = Aim(robot, replace(task, frame=WORLD_ALIGNED))
    units = np.where(np.array(aim.rows) < 3, aim.length, 1.0)
    lower, upper = np.minimum(robot.lower, q), np.maximum(robot.upper, q)  # where it stands beyond a limit it may stay
    best, error = q, aim.error(target, q[None])[0]
    for _ in range(STEPS):
        if np.linalg.norm(error) <= _THERE:
            break
        inverse = damped_inverse(robot, best, aim.task, damping=DAMPING, threshold=THRESHOLD)
        step = inverse @ (units * error)
        step *= min(1.0, _MOST / max(float(np.abs(step).max()), 1e-12))
        further = np.clip(best + step, lower, upper)
        left = aim.error(target, further[None])[0]
        if np.linalg.norm(left) >= np.linalg.norm(error):
            break
        best, error = further, left
    return best, float(np.linalg.norm(error))
