"""The tab "Escape": motions out of the singularity, or away from the nearest one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rankdrop.local import Direction, Escape, JointEscape, escape, self_motion
from rankdrop.results import Explanation, motion, short
from rankdrop.viewer.controls import Controls

if TYPE_CHECKING:
    import viser

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
            self._single = [self._joint_button(number) for number in range(1, controls.robot.n + 1)]
            controls.button("stop", controls.session.stop)

    def _joint_button(self, number: int) -> viser.GuiButtonHandle:
        name = self.controls.robot.variables[number - 1].name
        return self.controls.button(f"joint {number} {name}", lambda: self._one(number))

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

    def _one(self, number: int) -> None:
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
