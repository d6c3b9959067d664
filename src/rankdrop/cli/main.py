"""The command line: which commands there are, and what every way of ending means as an exit code."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import signal
import sys

_HANDLER = signal.getsignal(signal.SIGINT)
_OURS = _HANDLER is signal.default_int_handler

GROUPS = {
    "Main": {
        "analyze": "Find every family of singularities of an arm.",
        "explain": "Explain a configuration: lost motion, ways out.",
        "path": "Check a path for singularities, between its samples too.",
        "report": "Write a page about an arm, or figures for papers.",
        "view": "Show an arm in a browser, with sliders and verdict.",
        "robots": "List the arms of the catalogue.",
    },
    "Design": {
        "sweep": "Measure many variants of an arm.",
        "compare": "Compare arms for the same task.",
    },
    "Exact and proof": {
        "conditions": "Derive the singularity conditions of an arm exactly.",
        "cover": "Enclose all singular configurations in boxes.",
        "verify": "Check a certificate: prove its claim again.",
    },
    "Export": {
        "monitor": "Write an arm and its families as a C header.",
        "jacobian": "Write the Jacobian of a link's frame, and its inverse.",
    },
    "Research": {
        "find": "Find singular configurations of one corank.",
        "aspects": "Count the aspects of an arm, and find changes of posture without a singularity.",
        "through": "Check whether a path through a singularity can be tracked.",
        "tolerant": "Find configurations that tolerate a failed joint best.",
    },
}
"""Group -> command -> its line in the help. The file of a command is imported when the command is typed."""
FILES = {
    **dict.fromkeys(GROUPS["Design"], "design"), **dict.fromkeys(("cover", "verify"), "proof"),
    **dict.fromkeys(("robots", *GROUPS["Export"]), "arms"), **dict.fromkeys(GROUPS["Research"], "research"),
}  # fmt: skip
"""Command -> its file, where several share one; else the file has the name of the command."""
COMMANDS = tuple(name for commands in GROUPS.values() for name in commands)
ALIASES = {"escape": ("explain", "--only", "escape"), "nearest": ("explain", "--only", "nearest")}
"""First word -> the words that it stands for."""

_ZSH = """
if [[ ${funcstack[1]} == _rankdrop ]]; then
  _cyclopts_rankdrop "$@"
else
  compdef _cyclopts_rankdrop rankdrop
fi
"""
"""The script only defines a function: it is called where the file is autoloaded, and made known where it is sourced."""


def _leave_at_once(*_: object) -> None:
    """Ctrl-C before there is anything to keep. No exception: a module that is being imported may swallow it."""
    with contextlib.suppress(OSError):
        os.write(2, b"rankdrop: interrupted\n")
    os._exit(130)


with contextlib.suppress(ValueError):  # not the main thread
    if _OURS:
        signal.signal(signal.SIGINT, _leave_at_once)
try:
    import errno
    import io
    import traceback
    from collections.abc import Iterator, Sequence
    from itertools import chain
    from threading import current_thread, main_thread
    from types import FrameType
    from typing import Literal

    from cyclopts import (
        App,
        CycloptsError,
        Group,
        MissingArgumentError,
        UnknownCommandError,
        UnknownOptionError,
        UnusedCliTokensError,
    )

    from rankdrop.cli import exits
    from rankdrop.cli.help import Help, prose
    from rankdrop.cli.terminal import encode_plainly, say
    from rankdrop.errors import RankdropError
    from rankdrop.options import on_command_line
    from rankdrop.version import VERSION
except KeyboardInterrupt:  # raised by a module itself
    _leave_at_once()


_HELP = f"""Kinematic singularities of robot arms: families, conditions, proofs.

For example:
  rankdrop analyze pa10
  rankdrop explain ur5 --deg --q 0,-135,45,90,-90,0
  rankdrop path ur5e pick.csv

{exits.HELP}"""

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF}

app = App(
    name="rankdrop",
    help=_HELP,
    help_format="plaintext",
    help_formatter=Help(),
    version=VERSION,
    version_flags=["--version"],
    group_commands=Group("Other", sort_key=len(GROUPS)),
    group_parameters=Group("Options", sort_key=0),
    suppress_keyboard_interrupt=False,
)
for _place, _title in enumerate(GROUPS):
    _group = Group(_title, sort_key=_place)
    for _rank, (_name, _help) in enumerate(GROUPS[_title].items()):
        _file = f"rankdrop.cli.{FILES.get(_name, _name)}:{_name}"
        app.command(_file, name=_name, group=_group, help=_help, sort_key=_rank)


@app.command
def completion(shell: Literal["bash", "zsh", "fish"], /) -> int:
    """Print a script that completes commands and options at the Tab key.

    For example:
        rankdrop completion bash > ~/.local/share/bash-completion/completions/rankdrop
        rankdrop completion zsh > ~/.zfunc/_rankdrop
        rankdrop completion fish > ~/.config/fish/completions/rankdrop.fish

    Args:
        shell: Shell of the script.
    """
    script = app.generate_completion(prog_name="rankdrop", shell=shell)
    if shell == "bash":  # names of files where no word of ours fits
        script = script.replace("complete -F ", "complete -o default -F ")
    if shell == "zsh":
        plain = re.compile(r"^( +'(?:\*?--.*\]:[\w-]+|\d:.*[.…]))'(?= \\$|$)", re.MULTILINE)
        script = plain.sub(r"\1:_files'", script) + _ZSH
    sys.stdout.write(script)
    return exits.FINE


def main() -> None:
    """Entry point of the `rankdrop` command."""
    try:
        _fill_streams()
        encode_plainly()
        code = run(sys.argv[1:])
    except KeyboardInterrupt:  # a second Ctrl-C, on the way out
        code = exits.INTERRUPTED
    if code == exits.INTERRUPTED:  # an interpreter that met an interrupt may end by the signal, whatever the code is
        with contextlib.suppress(OSError):
            sys.stderr.flush()
        os._exit(code)
    sys.exit(code)


def run(argv: Sequence[str]) -> int:
    """Run one command line in this process.

    Args:
        argv: the words after `rankdrop`.

    Returns:
        The exit code (see `rankdrop.cli.terminal`).
    """
    interrupted = False

    def remember(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        interrupted = True
        signal.default_int_handler(number, frame)

    argv = _expand(argv)
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler and current_thread() is main_thread()
    if ours:
        signal.signal(signal.SIGINT, remember)
    try:
        code = _run(argv)
    except Exception as error:
        if interrupted:  # it was taken for something else on its way
            say("interrupted")
            return exits.INTERRUPTED
        say(f"{''.join(traceback.format_exception(error))}", bare=True)
        say(f"internal error: {type(error).__name__}: {error}; please report it with the lines above")
        return exits.INTERNAL
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)
    stopped = interrupted and list(argv[:1]) != ["view"]  # which Ctrl-C ends as it should
    if stopped and code != exits.BROKEN_PIPE:
        return exits.INTERRUPTED
    return code


def whole_help(command: str) -> None:
    """Let the help of a command be that of its file, not only its line in the list."""
    if command in COMMANDS:
        command_app = app[command]
        command_app.help = prose(getattr(command_app.default_command, "__doc__", None) or "")


def _expand(argv: Sequence[str]) -> list[str]:
    """The words with aliases in full: `rankdrop nearest …` is `rankdrop explain … --only nearest`."""
    words = list(argv)
    if words[:1] == ["help"]:
        return [*words[1:], "--help"]
    if words in (["-v"], ["-V"], ["version"]):
        return ["--version"]
    if words == ["--verbose"]:
        return ["--help"]
    if words[:1] == ["robots"]:
        words = list(_printed_json(words))
    if words:
        first, *rest = ALIASES.get(words[0], (words[0],))
    else:
        first, *rest = ("--help",)
    if {"-v", "--verbose"} & set(words) and "--full" in _options(first):
        full = ["--full"]
    else:
        full = []
    plain = {"--degrees": ["--deg"], "-v": full, "--verbose": full}
    replaced = chain.from_iterable(plain.get(word, [word]) for word in words[1:])
    return [first, *replaced, *rest]


def _printed_json(words: Sequence[str]) -> Iterator[str]:
    """The words of `rankdrop robots`; its --json needs no file name and then writes to stdout."""
    for word, following in zip(words, [*words[1:], ""], strict=True):
        yield word
        if word == "--json" and following != "-" and not following.endswith(".json"):
            yield "-"


def _run(argv: Sequence[str]) -> int:
    try:
        whole_help(argv[0])
        with on_command_line():
            code = app(list(argv), exit_on_error=False, print_error=False, result_action="return_value")
        sys.stdout.flush()
    except CycloptsError as error:
        say(f"error: {_in_our_words(error)}")
        return exits.BAD_INPUT
    except RankdropError as error:
        say(f"error: {error.on_command_line(_options(argv[0]))}")
        return exits.BAD_INPUT
    except KeyboardInterrupt:
        say("interrupted")
        return exits.INTERRUPTED
    except (BrokenPipeError, SystemExit) as error:
        if isinstance(error, SystemExit) and not isinstance(error.__context__, BrokenPipeError):
            raise
        _close_stdout()  # rich leaves by SystemExit where it prints a help
        return exits.BROKEN_PIPE
    except OSError as error:
        words = _system_words(error)
        if words is None:
            raise
        say(f"error: {words}")
        return exits.BAD_INPUT
    if isinstance(code, int):
        return code
    return exits.FINE


def _system_words(error: OSError) -> str | None:
    """What to say of stdout that is full, which is closed then, and of too long a name of a file; None of others."""
    if error.errno in _NO_ROOM and error.filename is None:  # files name themselves
        _close_stdout()
        return f"stdout: cannot write: {error.strerror}"
    if error.errno == errno.ENAMETOOLONG:
        name = os.fsdecode(error.filename or "")
        return (f"the name of a file is too long; got {len(os.fsencode(name)):,} bytes: {name[:40]!r} …; "
                "allowed: what the file system takes, most often 255 bytes between two slashes")  # fmt: skip
    return None


def _in_our_words(error: CycloptsError) -> str:
    text = " ".join(str(error).split())
    if isinstance(error, UnusedCliTokensError):
        text = _unexpected_words(error.unused_tokens or [])
    if isinstance(error, UnknownCommandError) and error.unused_tokens and (arm := _arm(error.unused_tokens[0])):
        return f"{arm} is an arm; a command comes first: rankdrop analyze {arm}. See `rankdrop --help`."
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        text = _missing(error)
    if error.command_chain:
        command = error.command_chain[0]
    else:
        command = ""
    if isinstance(error, UnknownOptionError) and command in app:
        text += f" Allowed: {', '.join(_options(command))}."
    return f"{text} See `{' '.join(['rankdrop', command]).strip()} --help`."


def _unexpected_words(words: Sequence[str]) -> str:
    """Words that no option takes, with advice where they are numbers."""
    text = f"unexpected argument {', '.join(words)}."
    if words and all(re.match(r"[-+−]?[\d.]", word) for word in words):
        text += ' Numbers of one option need commas or quotes: --q 0,-60,0 or --q "0 -60 0".'
    return text


def _arm(word: str) -> str:
    """The word, if it is a name of the catalogue or that of a file; else "".

    No file is opened: whether it describes an arm is for the command to say.
    """
    from rankdrop.robot import names_an_arm

    if names_an_arm(word):
        return shlex.quote(word)
    return ""


def _missing(error: MissingArgumentError) -> str:
    argument = error.argument
    assert argument is not None
    if error.keyword is None:
        what = f"{argument.name} is missing"
    else:
        what = f"{error.keyword} needs a value"
    about = re.split(r"\. |;|\.$", argument.parameter.help or "")[0]
    if about:
        return f"{what}: {about[0].lower()}{about[1:]}."
    return f"{what}."


def _options(command: str) -> list[str]:
    if command.startswith("-") or command not in app:
        return []
    arguments = app[command].assemble_argument_collection()
    names = chain.from_iterable(argument.names for argument in arguments)
    return sorted({name for name in names if name.startswith("--")})


def _close_stdout() -> None:
    """The reader has gone: keep the interpreter from failing again when it flushes stdout at exit."""
    with contextlib.suppress(OSError, ValueError):  # it was closed from the beginning
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fill_streams() -> None:
    """Stand-ins for streams that are closed (`>&-`), and no file of ours under their numbers."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDONLY)  # takes the lowest number that is free, which is this one
    if sys.stdout is None:
        sys.stdout = io.TextIOWrapper(io.FileIO(1, "w", closefd=False), encoding="utf-8")  # what is written to it fails
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # until the process ends


with contextlib.suppress(ValueError):
    if _OURS:
        signal.signal(signal.SIGINT, _HANDLER)

if __name__ == "__main__":
    main()
