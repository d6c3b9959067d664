"""The tab "Path": a trajectory from a CSV file, with σ and distance as time lines, played by the arm.

What the monitor sees along a joint trajectory.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.families import Monitor
from rankdrop.motion import Trajectory, parse_trajectory
from rankdrop.results import angle, short
from rankdrop.robot import Array
from rankdrop.viewer import panel
from rankdrop.viewer.controls import Controls, put
from rankdrop.viewer.scene import Now
from rankdrop.viewer.session import FRAMES

if TYPE_CHECKING:
    import viser


PLOTTED = 600
"""Points of a plot: more than a panel has pixels."""


@dataclass(frozen=True, eq=False)
class Track:
    """What the monitor sees along a trajectory.

    Attributes:
        times: (T,) [s].
        sigma: (T,) σ_r [1].
        shown: (P,) rows to plot: at most about `PLOTTED`, and of every part the one with the smallest σ, as a dip of
            one row between two that are plotted would be lost otherwise.
        distance: (P,) distance to the singular set at these rows, as `Monitor.distances` measures it [rad].
        worst: index of the row with the smallest σ_r.
        singular: number of rows that are singular.
    """

    times: Array
    sigma: Array
    shown: NDArray[np.intp]
    distance: Array
    worst: int
    singular: int


def track_of(trajectory: Trajectory, monitor: Monitor) -> Track:
    """σ at every row, and distances at those that are shown: they take a millisecond or more."""
    seen = monitor.look(trajectory.q)
    r = monitor.generic_rank
    sigma = seen.sigma[:, r - 1] if r else np.zeros(len(trajectory.q))
    shown = thinned(sigma)
    far = monitor.distances(trajectory.q[shown], along=True).nearest()[1]
    return Track(trajectory.times, sigma, shown, far, int(sigma.argmin()), int((seen.corank > 0).sum()))


def thinned(sigma: Array, count: int = PLOTTED) -> NDArray[np.intp]:
    """(P,) indices of rows to plot of those with σ (T,); see `Track.shown`."""
    total = len(sigma)
    if total <= count:
        return np.arange(total)
    edges = np.linspace(0, total, count // 2 + 1).astype(int)
    keep = {0, total - 1}
    for low, high in pairwise(edges.tolist()):
        keep |= {low, low + int(sigma[low:high].argmin())}
    return np.array(sorted(keep), dtype=np.intp)


_SMALLEST = 1e-12  # σ is plotted from here up, its logarithm being shown
_GREY = "#888888"


class PathTab:
    """Upload, play, plots.

    Args:
        controls: the panel.
        deg: angles without a unit are in degrees, in files that are uploaded.
    """

    def __init__(self, controls: Controls, *, deg: bool) -> None:
        self.controls, self.deg = controls, deg
        self.trajectory: Trajectory | None = None
        self._track: Track | None = None
        gui = controls.server.gui
        with controls.tabs.add_tab("Path"):
            upload = gui.add_upload_button("open a CSV file", mime_type="text/csv,.csv,.txt", color="gray")
            self._about = gui.add_html(panel.message_html(
                "Columns: joint names or q1 … qn, and a time if there is one."))  # fmt: skip
            self._plots: list[viser.GuiUplotHandle] = []
            self._curves: list[tuple[str, Array, str]] = []
            self._times = np.zeros(1)
            self._time = gui.add_slider("time [s]", 0.0, 1.0, 0.001, 0.0, visible=False)
            self._speed = gui.add_slider("speed", 0.1, 5.0, 0.1, 1.0, visible=False)
            self._buttons: Any = gui.add_button_group(
                "path", ("▶ play", "■ stop", "worst"), visible=False
            )
        upload.on_upload(lambda event: controls.attempt(lambda: self._uploaded(event.target.value)))
        self._time.on_update(self._dragged)
        self._buttons.on_click(lambda _: controls.attempt(self._toggle_playing))

    def _uploaded(self, file: Any) -> None:
        text = file.content.decode("utf-8-sig", errors="replace")
        self.open(parse_trajectory(text, file.name, self.controls.robot, deg=self.deg))

    def open(self, trajectory: Trajectory) -> None:
        """Show a trajectory and go to its start."""
        track = track_of(trajectory, self.controls.live.monitor)
        self.trajectory, self._track = trajectory, track
        lines = [f"{trajectory.name}: {len(trajectory.q)} rows, {trajectory.times[-1] - trajectory.times[0]:.4g} s"]
        if not trajectory.timed:
            lines.append("no times in the file: 0.1 s from row to row")
        if trajectory.unused:
            lines.append(f"not used: {', '.join(trajectory.unused)}")
        r = self.controls.live.generic_rank
        at = trajectory.times[track.worst]
        far = float(track.distance[np.searchsorted(track.shown, track.worst)])
        lines.append(f"smallest σ{r} = {short(float(track.sigma[track.worst]), 3)} at {at:.4g} s, "
                     f"{angle(far)} from the singular set")  # fmt: skip
        lines.append(f"singular rows: {track.singular}")
        self._about.content = "".join(panel.message_html(line) for line in lines)
        first, last = float(trajectory.times[0]), float(trajectory.times[-1])
        self._time.min, self._time.max = first, max(last, first + 1e-3)
        self._time.step = max((last - first) / 1000, 1e-6)
        for handle in (self._time, self._speed, self._buttons):
            handle.visible = True
        put(self._time, first)
        self._plot(track, r)
        self.controls.session.go(trajectory.q[0])

    def _plot(self, track: Track, r: int) -> None:
        for plot in self._plots:
            plot.remove()
        keep = track.shown
        self._times = track.times[keep]
        distance = np.where(np.isfinite(track.distance), track.distance, 0.0)
        self._curves = [(f"log₁₀ σ{r}", np.log10(np.maximum(track.sigma[keep], _SMALLEST)), panel.BLUE),
                        ("distance [rad]", distance, panel.VERMILION)]  # fmt: skip
        self._plots = [self._one_plot(*curve, order) for order, curve in enumerate(self._curves)]

    def _one_plot(self, name: str, values: Array, colour: str, order: int) -> viser.GuiUplotHandle:
        axis = {"stroke": _GREY, "grid": {"stroke": "rgba(128,128,128,0.25)", "width": 1}, "ticks": {"show": False}}
        options: Any = {  # uPlot's options are plain dictionaries; the stubs of viser want every key
            "series": ({"label": "t [s]"}, {"label": name, "stroke": colour, "width": 2},
                       {"label": "now", "stroke": _GREY, "width": 1}),
            "scales": {"x": {"time": False}},
            "axes": (axis, {**axis, "size": 48}),
            "legend": {"show": False},
        }  # fmt: skip
        return self.controls.server.gui.add_uplot(
            data=(self._times, values, self._marker(values)), height=140, title=name,
            order=self._time.order - 0.5 + 0.1 * order, **options,
        )  # fmt: skip

    def _marker(self, values: Array) -> Array:
        """A spike at the time of the slider, on a base line along the bottom."""
        marker = np.full(len(values), float(values.min()))
        marker[int(np.abs(self._times - self._time.value).argmin())] = float(values.max())
        return marker

    def _toggle_playing(self) -> None:
        if self.trajectory is None or self._track is None:
            return
        if self._buttons.value.startswith("■"):
            self.controls.session.stop()
        elif self._buttons.value == "worst":
            put(self._time, float(self._track.times[self._track.worst]))
            self.controls.session.go(self.trajectory.q[self._track.worst])
        else:
            self.controls.session.follow(self._playing(self.trajectory), self)

    def _playing(self, trajectory: Trajectory) -> Iterator[Array]:
        """From the slider's time to the end, from the start where it stands at the end."""
        last = float(trajectory.times[-1])
        time = self._time.value if self._time.value < last - 1e-3 else float(trajectory.times[0])
        while time < last:
            put(self._time, time)
            yield trajectory.at(time)
            time += self._speed.value / FRAMES
        put(self._time, last)
        yield trajectory.q[-1]

    def _dragged(self, event: viser.GuiEvent[Any]) -> None:
        if event.client_id is not None and self.trajectory is not None:
            self.controls.session.set(self.trajectory.at(self._time.value), self)

    def shown(self, _now: Now, source: object) -> None:
        """Move the marks of the plots, where the trajectory moves the arm."""
        if source is self:
            for plot, (_, values, _) in zip(self._plots, self._curves, strict=True):
                plot.data = (self._times, values, self._marker(values))
