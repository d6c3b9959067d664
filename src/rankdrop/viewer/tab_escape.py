"""The tab that says how to get out, and goes there."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np

from rankdrop.local import Direction, Escape, JointEscape, escape, self_motion
from rankdrop.results import Explanation
from rankdrop.text import motion, short
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
            self.ui = SimpleNamespace(
                best=controls.button("best direction", lambda: self._move_along("best_direction"), colour="blue"),
                pair=controls.button("best two joints", lambda: self._move_along("best_pair")),
                still=controls.button("with the tool held still", self._keep_still),
                single=[controls.button(f"joint {joint}", partial(self._move_joint, number))
                        for number, joint in enumerate(controls.joints, start=1)],
                stop=controls.button("stop", controls.session.stop),
            )  # fmt: skip

    def on_explanation(self, explanation: Explanation) -> None:
        """Label the buttons with what they do from here."""
        out, r = explanation.escape, explanation.rank.generic_rank
        for way in out.single:
            usable = way.order is not None and way.within_limits and abs(way.step) > 0
            if usable:
                unit = explanation.robot.variables[way.number - 1].unit
                effect = f"{motion(way.step, unit)} → σ{r} = {short(way.sigma_after, 2)}"
            else:
                effect = _why_not(way, lost=bool(out.corank))
            _label(self.ui.single[way.number - 1], f"joint {way.number} {way.joint}: {effect}", usable)
        pair, name = out.best_pair, "best two joints"
        if pair is not None:
            name = _direction_label(f"joints {' and '.join(map(str, pair.numbers))}", pair, r)
        _label(self.ui.pair, name, pair is not None and pair.step > 0)
        _label(self.ui.best, _direction_label("best direction", out.best_direction, r), out.best_direction.step > 0)
        if out.avoidable is None:
            still = "none found"
        else:
            still = "impossible"
        _label(self.ui.still, "with the tool held still" if out.still else f"tool held still: {still}",
               out.still is not None)  # fmt: skip

    def _now(self) -> Escape:
        """Ways out from where the arm is at this moment: what was explained may be of another place."""
        live = self.controls.live
        return escape(live.robot, self.controls.session.q, live.task)

    def _move_joint(self, number: int) -> None:
        session = self.controls.session
        way = next(way for way in self._now().single if way.number == number)
        target = session.q
        target[number - 1] += way.step
        session.go(target)

    def _move_along(self, which: str) -> None:
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


def _label(button: viser.GuiButtonHandle, text: str, usable: bool) -> None:
    button.label = text
    button.disabled = not usable


def _why_not(way: JointEscape, *, lost: bool) -> str:
    if way.order is not None:
        return "no room inside the limits"
    if way.gain and lost:
        return f"gains {way.gain} of the rank, not all"
    return "no help"


def _direction_label(name: str, direction: Direction, r: int) -> str:
    if direction.step > 0:
        return f"{name} → σ{r} = {short(direction.sigma_after, 2)}"
    return f"{name}: no room inside the limits"
