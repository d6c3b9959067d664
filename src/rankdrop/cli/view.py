"""`rankdrop view`: the arm in a browser page, with sliders, verdict, lost directions and ways out."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, fields
from shlex import join
from time import sleep
from typing import TYPE_CHECKING, Annotated, Literal

from rankdrop import path as paths
from rankdrop import results
from rankdrop.cli import exits
from rankdrop.cli.command import command
from rankdrop.cli.opening import NO_OPTIONS, NO_TOOL, ROBOT, ArmOptions, ToolOptions, open_arm
from rankdrop.cli.terminal import say
from rankdrop.cli.values import parse_configuration
from rankdrop.errors import OptionError
from rankdrop.options import Options, option

if TYPE_CHECKING:
    from rankdrop.viewer.server import Viewer


@dataclass(frozen=True)
class ViewOptions(Options):
    """What the page shows, and who may see it."""

    q: Annotated[str | None, option("Configuration at the start: one number per joint [rad, m]")] = None
    frame: Annotated[
        Literal["base", "tool", "link"] | None,
        option("Axes in which motions are reported; link: where they are simplest"),
    ] = None
    analysis: Annotated[
        str | None, option("Families from this file (`rankdrop analyze --json`); else from the catalogue")
    ] = None
    trajectory: Annotated[
        str | None,
        option("CSV file to play: columns named after the joints or q1 … qn, and a time [s] if there is one"),
    ] = None
    limits: Annotated[bool, option("Distances, points of families and slices within the joint limits")] = False
    dark: Annotated[bool, option("A dark page; the page can change it")] = False
    port: (
        Annotated[
            int, option("Port; in use: an error. Default: 8765, or the next one that is free. 0: any", ge=0, le=65535)
        ]
        | None
    ) = None
    no_browser: Annotated[bool, option("Print the address, open nothing")] = False
    host: Annotated[str, option("Address to listen on; other than loopback with --expose only")] = "127.0.0.1"
    expose: Annotated[bool, option("Let other machines in that know the token")] = False
    quiet: Annotated[bool, option("No progress; the address alone, without notes")] = False


@command
def view(
    robot: ROBOT = "ur5",
    /,
    *,
    options: ViewOptions = ViewOptions(),
    tool: ToolOptions = NO_TOOL,
    arm: ArmOptions = NO_OPTIONS,
) -> int:
    """Show an arm in a browser, with sliders and verdict.

    The page is served on the loopback address of this machine only, and to no page of another origin. To show it on
    other machines give --host and --expose; the address that is printed then holds a token, without which nobody is
    let in. The connection is not encrypted.

    For example:
        rankdrop view pa10
        rankdrop view arm.urdf --tip flange --package arm_meshes=src/arm_meshes
        rankdrop view ur5 --deg --q 0,-135,45,90,-90,0 --trajectory pick.csv

    Exit code 0: ended by Ctrl-C; 2: bad input.
    """
    _check_host(options.host, expose=options.expose)
    viewer = _viewer(robot, options, tool, arm)
    try:
        for note in () if options.quiet else viewer.notes:
            say(f"not drawn: {note}")
        print(viewer.url, flush=True)
        if not options.quiet:
            say("the viewer is open; Ctrl-C ends it")
        if not options.no_browser:
            _open_browser(viewer.url)
        _wait()
    except KeyboardInterrupt:
        if not options.quiet:
            say("the viewer is closed")
    finally:
        viewer.close()
    return exits.FINE


def _viewer(robot: str, options: ViewOptions, tool: ToolOptions, arm: ArmOptions) -> Viewer:
    import numpy as np

    from rankdrop.viewer.server import Viewer, Wishes

    model, task = open_arm(robot, arm, tool)
    if options.trajectory is None:
        played = None
    else:
        played = paths.read_trajectory(options.trajectory, model, deg=tool.deg)
    wishes = Wishes(
        q=None if options.q is None else np.array(parse_configuration(options.q, model, deg=tool.deg)),
        analysis=None if options.analysis is None else results.Analysis.load(options.analysis),
        packages=arm.packages,
        args=arm.arguments,
        limits=options.limits,
        frame=options.frame,
        trajectory=played,
        deg=tool.deg,
        dark=options.dark,
        host=options.host,
        port=options.port,
        expose=options.expose,
        command=_command(robot, arm, options.frame, tool.tcp),
    )
    return Viewer(model, task, wishes)


def _command(robot: str, arm: ArmOptions, frame: str | None, tcp: str | None) -> str:
    """What was typed of the arm, its task and its tool: the same arm opens, not another one of the same file."""
    given = {"frame": frame, "tcp": tcp} | {field.name: getattr(arm, field.name) for field in fields(arm)}
    words = ["rankdrop", "view", robot]
    for name, value in given.items():
        option = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(option)
        elif isinstance(value, tuple):
            words += [f"{option}={part}" for part in value]
        elif value is not None and value is not False:
            words.append(f"{option}={value}")
    return join(words)


def _check_host(host: str, *, expose: bool) -> None:
    local = host in {"localhost", "::1"} or host.startswith("127.")
    if not local and not expose:
        raise OptionError("this address is reachable from other machines", where="--host", got=host,
                          allowed="127.0.0.1, ::1, localhost", mend="add --expose if that is intended")  # fmt: skip
    if local and expose:
        raise OptionError("this address is not reachable from other machines", where="--expose", got=f"--host {host}",
                          mend="name the address to listen on: --host 0.0.0.0 for all")  # fmt: skip


def _open_browser(url: str) -> None:
    """A browser, where there is one; the address has been printed either way."""
    import webbrowser

    with contextlib.suppress(Exception):  # whatever the system's opener raises, the viewer runs without it
        webbrowser.open(url)


def _wait() -> None:
    """Until Ctrl-C, in pieces: a signal that comes as a wait begins is noticed only when that wait ends."""
    while True:
        sleep(0.5)
