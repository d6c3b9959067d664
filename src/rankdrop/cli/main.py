"""The command line: which commands there are, and what every way of ending means as an exit code."""

from __future__ import annotations

import os
import sys

try:
    import errno
    import traceback
    from collections.abc import Sequence

    from cyclopts import App, CycloptsError, UnknownOptionError, UnusedCliTokensError

    from rankdrop.cli import exits
    from rankdrop.cli.analyze import analyze
    from rankdrop.cli.conditions import conditions
    from rankdrop.cli.cover import cover
    from rankdrop.cli.escape import escape
    from rankdrop.cli.explain import explain
    from rankdrop.cli.find import find
    from rankdrop.cli.jacobian import jacobian
    from rankdrop.cli.nearest import nearest
    from rankdrop.cli.path import path
    from rankdrop.cli.report import report
    from rankdrop.cli.reproduce import reproduce
    from rankdrop.cli.robots import robots
    from rankdrop.cli.terminal import encode_plainly, say
    from rankdrop.cli.tolerant import tolerant
    from rankdrop.cli.view import view
    from rankdrop.errors import RankdropError
    from rankdrop.version import VERSION
except KeyboardInterrupt:  # Ctrl-C before there is anything to keep
    sys.stderr.write("rankdrop: interrupted\n")
    sys.exit(130)

_HELP = f"""Kinematic singularities of robot arms: every family, of every corank, with its conditions.

For example:
    rankdrop analyze pa10
    rankdrop analyze arm.urdf --tip flange --json arm.json
    rankdrop conditions puma560
    rankdrop find ur5 --corank 2 --out corank2.csv
    rankdrop explain ur5 --deg --q 0,-135,45,90,-90,0
    rankdrop path ur5e pick.csv
    rankdrop cover ur5
    rankdrop report pa10 --out pa10.html
    rankdrop view pa10

{exits.HELP}"""

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF}

app = App(
    name="rankdrop",
    help=_HELP,
    help_format="plaintext",
    version=VERSION,
    version_flags=["--version"],
    suppress_keyboard_interrupt=False,
)
app.command(robots)
app.command(analyze)
app.command(conditions)
app.command(jacobian)
app.command(find)
app.command(explain)
app.command(escape)
app.command(nearest)
app.command(tolerant)
app.command(path)
app.command(cover)
app.command(view)
app.command(reproduce)
app.command(report)


def main() -> None:
    """Entry point of the `rankdrop` command."""
    try:
        encode_plainly()
        code = run(sys.argv[1:])
    except KeyboardInterrupt:  # a second Ctrl-C, on the way out
        code = exits.INTERRUPTED
    sys.exit(code)


def run(argv: Sequence[str]) -> int:
    """Run one command line in this process.

    Args:
        argv: the words after `rankdrop`.

    Returns:
        The exit code (see `rankdrop.cli.exits`).
    """
    try:
        code = app(list(argv), exit_on_error=False, print_error=False, result_action="return_value")
        sys.stdout.flush()
    except CycloptsError as error:
        say(f"error: {_in_our_words(error)}")
        return exits.BAD_INPUT
    except RankdropError as error:
        say(f"error: {error.on_command_line()}")
        return exits.BAD_INPUT
    except KeyboardInterrupt:
        say("interrupted")
        return exits.INTERRUPTED
    except BrokenPipeError:
        _close_stdout()
        return exits.BROKEN_PIPE
    except Exception as error:
        if isinstance(error, OSError) and error.errno in _NO_ROOM and error.filename is None:  # files name themselves
            _close_stdout()
            say(f"error: stdout: cannot write: {error.strerror}")
            return exits.BAD_INPUT
        traceback.print_exc()
        say(f"internal error: {type(error).__name__}: {error}; please report it with the lines above")
        return exits.INTERNAL
    return code if isinstance(code, int) else exits.FINE


def _in_our_words(error: CycloptsError) -> str:
    text = " ".join(str(error).split())
    if isinstance(error, UnusedCliTokensError):
        text = f"there is no place for {', '.join(error.unused_tokens or [])} on the command line."
    command = error.command_chain[0] if error.command_chain else ""
    if isinstance(error, UnknownOptionError) and command in app:
        text += f" Allowed: {', '.join(_options(command))}."
    return f"{text} See `{' '.join(['rankdrop', command]).strip()} --help`."


def _options(command: str) -> list[str]:
    arguments = app[command].assemble_argument_collection()
    return sorted({name for argument in arguments for name in argument.names if name.startswith("--")})


def _close_stdout() -> None:
    """The reader has gone: keep the interpreter from failing again when it flushes stdout at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    main()
