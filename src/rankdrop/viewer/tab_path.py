"""The tabs "Path" and "Share": play a trajectory, record a session, link to a configuration, open another arm.

The tab "Path" shows σ and the distance along a trajectory as the monitor sees them.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from math import degrees, radians
from pathlib import Path
from time import monotonic
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

import numpy as np
from numpy.typing import NDArray

from rankdrop.disk import replace_file
from rankdrop.distance import Monitor
from rankdrop.errors import RobotError
from rankdrop.path import Trajectory, parse_trajectory
from rankdrop.robot import Array, Robot, open_robot
from rankdrop.text import angle, short
from rankdrop.viewer import panel
from rankdrop.viewer.controls import Controls, set_input
from rankdrop.viewer.scene import Now
from rankdrop.viewer.session import FRAMES

if TYPE_CHECKING:
    import viser


PLOTTED = 600
"""Points of a plot: more than a panel has pixels."""

_SMALLEST = 1e-12  # σ is plotted from here up, its logarithm being shown
_GREY = "#888888"

ROBOT_FILES = (".urdf", ".toml")
"""Robot files that are read from the page: those that cannot run a command, as a xacro file can."""
_MOST_BYTES = 5_000_000
_MOST_ROWS = 200_000


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
    if r:
        sigma = seen.sigma[:, r - 1]
    else:
        sigma = np.zeros(len(trajectory.q))
    shown = plotted_rows(sigma)
    far = monitor.distances(trajectory.q[shown], along=True).nearest()[1]
    return Track(trajectory.times, sigma, shown, far, int(sigma.argmin()), int((seen.corank > 0).sum()))


def plotted_rows(sigma: Array, count: int = PLOTTED) -> NDArray[np.intp]:
    """(P,) indices of rows to plot of those with σ (T,); see `Track.shown`."""
    total = len(sigma)
    if total <= count:
        return np.arange(total)
    edges = np.linspace(0, total, count // 2 + 1).astype(int)
    keep = {0, total - 1}
    for low, high in pairwise(edges.tolist()):
        keep |= {low, low + int(sigma[low:high].argmin())}
    return np.array(sorted(keep), dtype=np.intp)


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
        self._plots: list[tuple[viser.GuiUplotHandle, Array]] = []
        self._times = np.zeros(1)
        gui = controls.server.gui
        acts = {"▶ play": self._play, "■ stop": controls.session.stop, "worst": self._show_worst}
        with controls.tabs.add_tab("Path"):
            self.ui = SimpleNamespace(
                upload=controls.upload("open a CSV file", "text/csv,.csv,.txt", self._on_upload),
                about=gui.add_html(panel.message_html(
                    "Columns: joint names or q1 … qn, and a time if there is one.")),
                time=gui.add_slider("time [s]", 0.0, 1.0, 0.001, 0.0, visible=False),
                speed=gui.add_slider("speed", 0.1, 5.0, 0.1, 1.0, visible=False),
                buttons=controls.buttons("path", acts, visible=False),
            )  # fmt: skip
        self.ui.time.on_update(self._on_drag)

    def _on_upload(self, file: Any) -> None:
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
        self.ui.about.content = "".join(panel.message_html(line) for line in lines)
        first, last = float(trajectory.times[0]), float(trajectory.times[-1])
        time = self.ui.time
        time.min, time.max = first, max(last, first + 1e-3)
        time.step = max((last - first) / 1000, 1e-6)
        for handle in (time, self.ui.speed, self.ui.buttons):
            handle.visible = True
        set_input(time, first)
        self._plot(track, r)
        self.controls.session.go(trajectory.q[0])

    def _plot(self, track: Track, r: int) -> None:
        for plot, _ in self._plots:
            plot.remove()
        self._times = track.times[track.shown]
        sigma = np.log10(np.maximum(track.sigma[track.shown], _SMALLEST))
        distance = np.where(np.isfinite(track.distance), track.distance, 0.0)
        self._plots = [self._one_plot(f"log₁₀ σ{r}", sigma, panel.BLUE, -0.5),
                       self._one_plot("distance [rad]", distance, panel.VERMILION, -0.4)]  # fmt: skip

    def _one_plot(self, name: str, values: Array, colour: str, below: float) -> tuple[viser.GuiUplotHandle, Array]:
        axis = {"stroke": _GREY, "grid": {"stroke": "rgba(128,128,128,0.25)", "width": 1}, "ticks": {"show": False}}
        options: Any = {  # uPlot's options are plain dictionaries; the stubs of viser want every key
            "series": ({"label": "t [s]"}, {"label": name, "stroke": colour, "width": 2},
                       {"label": "now", "stroke": _GREY, "width": 1}),
            "scales": {"x": {"time": False}},
            "axes": (axis, {**axis, "size": 48}),
            "legend": {"show": False},
        }  # fmt: skip
        plot = self.controls.server.gui.add_uplot(
            data=self._with_mark(values), height=140, title=name, order=self.ui.time.order + below, **options
        )
        return plot, values

    def _with_mark(self, values: Array) -> tuple[Array, Array, Array]:
        """Times, values, and a spike at the time of the slider, on a base line along the bottom."""
        marker = np.full(len(values), float(values.min()))
        marker[int(np.abs(self._times - self.ui.time.value).argmin())] = float(values.max())
        return self._times, values, marker

    def _play(self) -> None:
        if self.trajectory is not None:
            self.controls.session.follow(self._playing(self.trajectory), self)

    def _show_worst(self) -> None:
        if self.trajectory is not None and self._track is not None:
            set_input(self.ui.time, float(self._track.times[self._track.worst]))
            self.controls.session.go(self.trajectory.q[self._track.worst])

    def _playing(self, trajectory: Trajectory) -> Iterator[Array]:
        """From the slider's time to the end, from the start where it stands at the end."""
        last = float(trajectory.times[-1])
        if self.ui.time.value < last - 1e-3:
            time = self.ui.time.value
        else:
            time = float(trajectory.times[0])
        while time < last:
            set_input(self.ui.time, time)
            yield trajectory.at(time)
            time += self.ui.speed.value / FRAMES
        set_input(self.ui.time, last)
        yield trajectory.q[-1]

    def _on_drag(self, event: viser.GuiEvent[Any]) -> None:
        if event.client_id is not None and self.trajectory is not None:
            self.controls.session.set(self.trajectory.at(self.ui.time.value), self)

    def on_look(self, _now: Now, source: object) -> None:
        """Move the marks of the plots, where the trajectory moves the arm."""
        if source is self:
            for plot, values in self._plots:
                plot.data = self._with_mark(values)


def state_text(robot: Robot, q: Array) -> str:
    """A configuration for `--deg --q` and for the link: degrees and metres, as few digits as tell it to 1e-6."""
    values = (degrees(x) if joint.unit == "rad" else x for joint, x in zip(robot.variables, q, strict=True))
    return ",".join(f"{value + 0.0:.6f}".rstrip("0").rstrip(".") for value in values)


def state_of(path: str, robot: Robot) -> Array | None:
    """(n,) the configuration that an address holds (?q=0,-90,…), [rad, m]; None where it holds none of this arm."""
    words = parse_qs(urlsplit(path).query).get("q", [""])[0].split(",")
    try:
        values = [float(word) for word in words]
    except ValueError:
        return None
    if len(values) != robot.n or not np.isfinite(values).all():
        return None
    joints = zip(values, robot.variables, strict=True)
    return np.array([radians(value) if joint.unit == "rad" else value for value, joint in joints])


def path_csv(robot: Robot, rows: Sequence[tuple[float, Array]]) -> str:
    """A recorded session as a path file: a time and the joints by name, angles in degrees."""
    units = ["deg" if joint.unit == "rad" else "m" for joint in robot.variables]
    head = ["time [s]", *(f"q{number} [{unit}]" for number, unit in enumerate(units, start=1))]
    names = ", ".join(joint.name for joint in robot.variables)
    lines = [f"# recorded in the viewer of rankdrop; joints: {names}", ",".join(head)]
    start = rows[0][0] if rows else 0.0
    for time, q in rows:
        lines.append(f"{time - start:.4f},{state_text(robot, q)}")
    return "\n".join(lines) + "\n"


class ShareTab:
    """Link, recording, another arm.

    Args:
        controls: the panel.
        url: of the page, without a token: who has the link needs a viewer of the same arm.
        command: that opens this arm, but for the configuration.
        another: opens a viewer of another arm, of a file of this name, and gives its address.
    """

    def __init__(self, controls: Controls, url: str, command: str, another: Callable[[Robot, str], str]) -> None:
        self.controls, self._url, self._command, self._another = controls, url, command, another
        self.rows: list[tuple[float, Array]] = []
        self.recording = False
        gui = controls.server.gui
        with controls.tabs.add_tab("Share"):
            self.ui = SimpleNamespace(
                link=gui.add_text("link", "", hint="opens this page with the arm as it stands now"),
                line=gui.add_text("command", "", hint="the same on any machine with rankdrop"),
                copy=gui.add_html(""),
                own=controls.upload("open an arm of your own (.urdf, .toml)", ",".join(ROBOT_FILES), self.open),
                opened=gui.add_html(""),
                record=controls.button("record the session", self.record),
                text=gui.add_html(""),
                save=controls.button("save the record as CSV", self._save,
                                     hint="for the tab Path, and for `rankdrop path`"),
            )  # fmt: skip

    def on_look(self, now: Now, _source: object) -> None:
        """A configuration was looked at."""
        text = state_text(self.controls.robot, now.q)
        link, line = f"{self._url}?q={text}", f"{self._command} --deg --q={text}"
        set_input(self.ui.link, link)
        set_input(self.ui.line, line)
        self.ui.copy.content = panel.copy_html((("copy the link", link), ("copy the command", line)))
        if self.recording and len(self.rows) < _MOST_ROWS:
            self.rows.append((monotonic(), now.q))
            self._tell()

    def record(self) -> None:
        """Begin to record, anew, or end it."""
        self.recording = not self.recording
        if self.recording:
            self.rows = [(monotonic(), self.controls.session.q)]
        if self.recording:
            self.ui.record.label = "stop recording"
        else:
            self.ui.record.label = "record the session"
        self._tell()

    def _tell(self) -> None:
        if len(self.rows) >= _MOST_ROWS:
            full = ", as many as are kept"
        else:
            full = ""
        self.ui.text.content = panel.message_html(f"{len(self.rows)} rows{full}" if self.rows else "")

    def _save(self) -> None:
        if not self.rows:
            self.controls.say("nothing is recorded yet")
            return
        letters = self.controls.robot.name
        name = "".join(letter if letter.isalnum() or letter in "-_" else "-" for letter in letters)
        content = path_csv(self.controls.robot, self.rows).encode()
        self.controls.server.send_file_download(f"{name}-session.csv", content)

    def open(self, file: Any) -> None:
        """Open an arm from a file of the reader's, in a viewer of its own.

        Raises:
            RobotError: no robot file that is read from a page, too large, or not readable as an arm.
        """
        ending = Path(file.name).suffix.lower()
        if ending not in ROBOT_FILES:
            raise RobotError("this file is not read from a page", where=file.name, got=ending or "no ending",
                             allowed=", ".join(ROBOT_FILES), mend="give it to `rankdrop view`")  # fmt: skip
        if len(file.content) > _MOST_BYTES:
            raise RobotError("the file is too large", where=file.name, got=f"{len(file.content):,} bytes",
                             allowed=f"{_MOST_BYTES:,} bytes")  # fmt: skip
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"arm{ending}"
            replace_file(path, file.content)
            try:
                robot = open_robot(path)
            except RobotError as error:
                raise RobotError(str(error).replace(str(path), file.name)) from None
        address = escape(self._another(robot, file.name))
        told = f'<a href="{address}" target="_blank">{escape(robot.name)} is open here</a>'
        self.ui.opened.content = panel.lines_html([told])
