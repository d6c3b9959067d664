"""The tab "Share": a state as a link and as a command, a session as a path file, another arm from a file."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from html import escape
from math import degrees, radians
from pathlib import Path
from time import monotonic
from typing import Any
from urllib.parse import parse_qs, urlsplit

import numpy as np

from rankdrop.disk import replace_file
from rankdrop.errors import RobotError
from rankdrop.robot import Array, Robot, open_robot
from rankdrop.viewer import panel
from rankdrop.viewer.controls import Controls, put
from rankdrop.viewer.scene import Now

ROBOT_FILES = (".urdf", ".toml")
"""Robot files that are read from the page: those that cannot run a command, as a xacro file can."""
_MOST_BYTES = 5_000_000
_MOST_ROWS = 200_000


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
    return np.array([radians(x) if one.unit == "rad" else x for x, one in zip(values, robot.variables, strict=True)])


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
            self._link = gui.add_text("link", "", hint="opens this page with the arm as it stands now")
            self._line = gui.add_text("command", "", hint="the same on any machine with rankdrop")
            self._copy = gui.add_html("")
            own = gui.add_upload_button("open an arm of your own (.urdf, .toml)", mime_type=",".join(ROBOT_FILES))
            self._opened = gui.add_html("")
            self._record = controls.button("record the session", self.record)
            self._told = gui.add_html("")
            controls.button("save the record as CSV", self._save, hint="for the tab Path, and for `rankdrop path`")
        own.on_upload(lambda event: controls.attempt(lambda: self.open(event.target.value)))

    def shown(self, now: Now, _source: object) -> None:
        """A configuration was looked at."""
        text = state_text(self.controls.robot, now.q)
        link, line = f"{self._url}?q={text}", f"{self._command} --deg --q={text}"
        put(self._link, link)
        put(self._line, line)
        self._copy.content = panel.copy_html((("copy the link", link), ("copy the command", line)))
        if self.recording and len(self.rows) < _MOST_ROWS:
            self.rows.append((monotonic(), now.q))
            self._tell()

    def record(self) -> None:
        """Begin to record, anew, or end it."""
        self.recording = not self.recording
        if self.recording:
            self.rows = [(monotonic(), self.controls.session.q)]
        self._record.label = "stop recording" if self.recording else "record the session"
        self._tell()

    def _tell(self) -> None:
        full = ", as many as are kept" if len(self.rows) >= _MOST_ROWS else ""
        self._told.content = panel.message_html(f"{len(self.rows)} rows{full}" if self.rows else "")

    def _save(self) -> None:
        if not self.rows:
            self.controls.say("nothing is recorded yet")
            return
        name = "".join(one if one.isalnum() or one in "-_" else "-" for one in self.controls.robot.name)
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
        self._opened.content = panel.lines_html([told])
