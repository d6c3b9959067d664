"""The viewer as a whole: a guarded viser server, the session, the scene and the panel."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rankdrop.families import upright, upright_start
from rankdrop.path import Trajectory
from rankdrop.results import Analysis, Explanation, known_families
from rankdrop.robot import Array, Robot, meshes_of, visuals_of
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT
from rankdrop.viewer import panel
from rankdrop.viewer.access import Gate, bound_uploads, free_port, new_token, start_gated, stop
from rankdrop.viewer.controls import Controls
from rankdrop.viewer.scene import Live, Now
from rankdrop.viewer.session import Session
from rankdrop.viewer.stage import Stage
from rankdrop.viewer.tab_escape import EscapeTab
from rankdrop.viewer.tab_families import FamiliesTab, SliceTab, TourTab
from rankdrop.viewer.tab_path import PathTab, ShareTab, state_of

if TYPE_CHECKING:
    import viser

PORT = 8765
"""Where it listens by default; a later one where this is in use."""
HOST = "127.0.0.1"
_POSED = 60  # families whose witnesses are put into good postures: hundreds, of calibrated arms, would take seconds
_SOURCES = {"catalogue": "from the catalogue", "analysis": "from the analysis given", "on the spot": "none known"}


@dataclass(frozen=True, slots=True)
class Wishes:
    """What a viewer is asked for.

    Attributes:
        q: (n,) to begin with [rad, m]; None for a plain one.
        analysis: families from it; None for those of the catalogue.
        packages: package name -> folder, for meshes.
        args: arguments of a xacro file.
        limits: the nearest singularity, families and slices within the joint limits.
        trajectory: to play; None for none.
        deg: angles of uploaded files are in degrees.
        dark: a dark page.
        host, port: to listen on; port None for the default one or a later one that is free.
        expose: let other machines in, by a token.
        frame: in whose axes motions are told, as in `explain`.
        command: what opens this arm, but for the configuration; None to be made from its name.
    """

    q: Array | None = None
    analysis: Analysis | None = None
    packages: dict[str, Path] = field(default_factory=dict)
    args: dict[str, str] = field(default_factory=dict)
    limits: bool = False
    trajectory: Trajectory | None = None
    deg: bool = False
    dark: bool = False
    host: str = HOST
    port: int | None = None
    expose: bool = False
    frame: str | None = None
    command: str | None = None


class Viewer:
    """A viewer that is open; `close` ends it.

    Attributes:
        url: the address of the page, the token in it where there is one.
        notes: what could not be drawn, one line each.
        session, stage, controls: its parts.

    Raises:
        MissingExtraError: viser is not installed.
        OptionError: the port is in use, or an analysis of another arm.
    """

    def __init__(self, robot: Robot, task: Task, wishes: Wishes) -> None:
        families, source = known_families(robot, task, wishes.analysis, DEFAULT)
        if len(families) <= _POSED:
            families = tuple(upright(robot, task, family, families) for family in families)
        live = Live(robot, task, families)
        self._wishes, self._others = wishes, list[Viewer]()
        visuals, left_out = visuals_of(robot, wishes.packages, wishes.args)
        meshes, unread = meshes_of(visuals)
        self.notes = (*left_out, *unread)
        port = free_port(wishes.host, PORT if wishes.port is None else wishes.port, next_one=wishes.port is None)
        gate = Gate(port, new_token() if wishes.expose else None)
        self.server: viser.ViserServer = start_gated(wishes.host, gate, self._on_request)
        self.url = _url(wishes.host, gate)
        if wishes.q is None:
            start = upright_start(robot, task)
        else:
            start = wishes.q
        self.session = Session(live, self, start, analysis=wishes.analysis, limits=wishes.limits,
                               frame=wishes.frame)  # fmt: skip
        self.stage = Stage(self.server, live, meshes)
        self.stage.look_at_arm(np.asarray(start))
        self.controls = Controls(self.server, self.session, self.stage)
        bound_uploads(self.server, self.controls.say)
        self._escape = EscapeTab(self.controls)
        self._families = FamiliesTab(self.controls, _SOURCES[source])
        self.path = PathTab(self.controls, deg=wishes.deg)
        self.slice = SliceTab(self.controls)
        self._tour = TourTab(self.controls)
        origin = robot.source.origin
        if origin and Path(origin).is_file():
            arm = origin
        else:
            arm = robot.name
        command = wishes.command or f"rankdrop view {shlex.quote(arm)}"
        self.share = ShareTab(self.controls, self.url.split("?")[0], command, self._another)
        self._add_look(dark=wishes.dark)
        self.session.start()
        if wishes.trajectory is not None:
            self.path.open(wishes.trajectory)

    def _add_look(self, *, dark: bool) -> None:
        gui = self.server.gui
        with self.controls.tabs.add_tab("View"):
            gui.add_html(panel.legend_html())
            for label, value, act, hint in (
                ("dark page", dark, self._paint, None),
                ("weakest motion", True, self._show_weakest, "arrows at regular configurations too"),
                ("joint numbers", True, self.stage.show_numbers, None),
                ("handle at the tip", False, self.controls.show_handle, "pull it: the joints follow"),
                ("nearest singular posture", True, self._allow_ghost, "as a ghost, while the arm is regular"),
                *([("meshes", True, self.stage.show_meshes, None)] if self.stage.has_meshes else []),
            ):
                self.controls.check(label, value, act, hint)
        self._paint(dark)

    def _show_weakest(self, shown: bool) -> None:
        self.stage.always_weakest = shown
        self.session.set(self.session.q)

    def _allow_ghost(self, shown: bool) -> None:
        self.stage.allow_ghost(shown)
        if self.controls.found is not None:
            self._show_ghost(self.controls.found)

    def _show_ghost(self, explanation: Explanation) -> None:
        now = self.controls.now
        at = now is not None and np.array_equal(now.q, explanation.q) and not now.seen.corank
        nearest = explanation.far.nearest if at else None
        self.stage.show_ghost(None if nearest is None else np.array(nearest.q))

    def _on_request(self, path: str) -> None:
        """A request for the page: a link may say where the arm is to stand."""
        session = getattr(self, "session", None)
        if session is None:
            q = None
        else:
            q = state_of(path, session.live.robot)
        if session is not None and q is not None:
            session.go(q)

    def _another(self, robot: Robot, file: str) -> str:
        """The address of a viewer of another arm, of a file of this name; closed with this one."""
        wishes = replace(self._wishes, q=None, analysis=None, trajectory=None, port=None,
                         command=f"rankdrop view {shlex.quote(file)}")  # fmt: skip
        viewer = Viewer(robot, resolve_task(None, robot), wishes)
        self._others.append(viewer)
        return viewer.url

    def _paint(self, dark: bool) -> None:
        self.server.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False,
                                        control_width="large", brand_color=(0, 114, 178))  # fmt: skip
        self.stage.paint(dark=dark)

    def on_look(self, now: Now, source: object) -> None:
        """Draw what was looked at."""
        self.stage.show(now)
        explanation = self.controls.found
        near = explanation is not None and now.verdict == "near" and np.abs(explanation.q - now.q).max() < 0.1
        circuits = now.blamed or (explanation.blame.smallest if explanation is not None and near else ())
        self.stage.blame([circuit.numbers for circuit in circuits], now)
        for part in (self.controls, self.path, self.share, self.slice):
            part.on_look(now, source)
        if now.seen.corank or self.session.moving:
            self.stage.show_ghost(None)
        elif explanation is not None:  # it may have been explained before it was drawn
            self._show_ghost(explanation)

    def on_explanation(self, explanation: Explanation) -> None:
        """Show what an explanation adds."""
        self.controls.on_explanation(explanation)
        self._escape.on_explanation(explanation)
        self._show_ghost(explanation)
        now = self.controls.now
        if now is not None and np.array_equal(now.q, explanation.q):
            self.stage.blame([circuit.numbers for circuit in explanation.blame.smallest], now)
            if not self.session.moving:
                self.stage.keep_in_view(explanation.q)

    def on_failure(self, error: BaseException) -> None:
        """Say what went wrong."""
        self.controls.say(f"{type(error).__name__}: {error}")

    def close(self) -> None:
        """End all threads and the server."""
        for other in self._others:
            other.close()
        self.session.close()
        stop(self.server)


def _url(host: str, gate: Gate) -> str:
    import socket

    if host in {"0.0.0.0", "::"}:
        name = socket.gethostname()
    elif ":" in host:
        name = f"[{host}]"
    else:
        name = host
    if gate.token:
        token = f"/?token={gate.token}"
    else:
        token = "/"
    return f"http://{name}:{gate.port}{token}"
