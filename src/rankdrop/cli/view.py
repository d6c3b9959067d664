"""`rankdrop view`: the arm in a browser page, with sliders, verdict, lost directions and ways out."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import FRAME, NO_OPTIONS, TCP, ArmOptions


def view(
    robot: str,
    /,
    *,
    q: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    frame: FRAME = None,
    tcp: TCP = None,
    analysis: str | None = None,
    trajectory: str | None = None,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    dark: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    port: int | None = None,
    no_browser: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    host: str = "127.0.0.1",
    expose: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Open the arm in a browser page: verdict, lost motions, joints to blame, ways out.

    The page is served on the loopback address of this machine only, and to no
    page of another origin. To show it on other machines give --host and
    --expose; the address that is printed then holds a token, without which
    nobody is let in. The connection is not encrypted.

    For example:
        rankdrop view pa10
        rankdrop view arm.urdf --tip flange --package arm_meshes=src/arm_meshes
        rankdrop view ur5 --deg --q 0,-135,45,90,-90,0 --trajectory pick.csv

    Exit code 0: ended by Ctrl-C; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro: with meshes; .xml, .toml).
        q: Where to begin: one number per joint, separated by commas or blanks [rad, m].
        deg: Angles without a unit are in degrees, in --q and in the trajectory.
        frame: In whose axes motions are told: base, tool, or the link in which they are simplest.
        tcp: Tool point from the tip, in its axes: x,y,z or x,y,z,roll,pitch,yaw [m, rad]; 120mm, 30deg are understood.
        analysis: Families from this file (`rankdrop analyze --json`); else from the catalogue.
        trajectory: CSV file to play: columns named after the joints or q1 … qn, and a time [s] if there is one.
        limits: The nearest singularity, the points of families and the slices within the joint limits.
        dark: A dark page; it can be changed in the page.
        port: To listen on; in use: an error. Default: 8765, or the next one that is free. 0: any.
        no_browser: Print the address, open nothing.
        host: Address to listen on; other than loopback with --expose only.
        expose: Let other machines in that know the token.
        quiet: No progress; the address alone, without notes.
    """
    from rankdrop.cli.arm import arguments_of, open_arm, packages_of, parse_configuration
    from rankdrop.cli.terminal import say
    from rankdrop.motion import read_trajectory
    from rankdrop.results import Analysis
    from rankdrop.viewer.server import Viewer, Wishes

    _check_host(host, expose=expose)
    model, task = open_arm(robot, arm, tcp, deg=deg)
    import numpy as np

    wishes = Wishes(
        q=None if q is None else np.array(parse_configuration(q, model, deg=deg)),
        analysis=None if analysis is None else Analysis.load(analysis),
        packages=packages_of(arm),
        args=arguments_of(arm),
        limits=limits,
        frame=frame,
        trajectory=None if trajectory is None else read_trajectory(trajectory, model, deg=deg),
        deg=deg,
        dark=dark,
        host=host,
        port=port,
        expose=expose,
        command=_command(robot, arm, frame, tcp),
    )
    viewer = Viewer(model, task, wishes)
    try:
        for note in () if quiet else viewer.notes:
            say(f"not drawn: {note}")
        print(viewer.url, flush=True)
        if not quiet:
            say("the viewer is open; Ctrl-C ends it")
        if not no_browser:
            _open_browser(viewer.url)
        _wait()
    except KeyboardInterrupt:
        if not quiet:
            say("the viewer is closed")
    finally:
        viewer.close()
    return exits.FINE


def _command(robot: str, arm: ArmOptions, frame: str | None, tcp: str | None) -> str:
    """What was typed of the arm, its task and its tool: the same arm opens, not another one of the same file."""
    from dataclasses import fields
    from shlex import join

    given = {"frame": frame, "tcp": tcp} | {one.name: getattr(arm, one.name) for one in fields(arm)}
    words = ["rankdrop", "view", robot]
    for name, value in given.items():
        option = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(option)
        elif isinstance(value, tuple):
            words += [f"{option}={one}" for one in value]
        elif value is not None and value is not False:
            words.append(f"{option}={value}")
    return join(words)


def _check_host(host: str, *, expose: bool) -> None:
    from rankdrop.errors import OptionError

    local = host in {"localhost", "::1"} or host.startswith("127.")
    if not local and not expose:
        raise OptionError("this address is reachable from other machines", where="--host", got=host,
                          allowed="127.0.0.1, ::1, localhost", mend="add --expose if that is meant")  # fmt: skip
    if local and expose:
        raise OptionError("this address is not reachable from other machines", where="--expose", got=f"--host {host}",
                          mend="name the address to listen on: --host 0.0.0.0 for all")  # fmt: skip


def _open_browser(url: str) -> None:
    """A browser, where there is one; the address has been printed either way."""
    import contextlib
    import webbrowser

    with contextlib.suppress(Exception):  # whatever the system's opener raises, the viewer runs without it
        webbrowser.open(url)


def _wait() -> None:
    """Until Ctrl-C, in pieces: a signal that comes as a wait begins is noticed only when that wait ends."""
    from time import sleep

    while True:
        sleep(0.5)
