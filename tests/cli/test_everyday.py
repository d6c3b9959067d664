"""What every user meets: closed streams, Ctrl-C, characters of a file, completion, options that all commands have."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from command_line import Ended, command

from papers.run import DOCUMENTS
from rankdrop.cli import exits, main
from rankdrop.cli.terminal import say, screen, show
from rankdrop.codec import json_text
from rankdrop.errors import MissingExtraError, visible

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = [name for name in main.app if not name.startswith("-")]


def shell(line: str) -> Ended:
    """A line of sh, in which $R is rankdrop."""
    words = " ".join(f"'{word}'" for word in command())
    done = subprocess.run(["sh", "-c", f'R="{words}"; {line.replace("$R", words)}'], capture_output=True, timeout=120)
    return Ended(done.returncode, done.stdout.decode(), done.stderr.decode())


@pytest.mark.spread(1)
@pytest.mark.by_hand_at(
    "$R analyze nosuch 2>&--2-", "$R analyze nosuch 2>/dev/full-2-", "$R robots <&- >/dev/null-0-",
    "$R robots fanuc 2>&- >/dev/null-0-", "$R robots nosuch >&- 2>&- <&--2-",
)  # fmt: skip
@pytest.mark.slow
@pytest.mark.slow_at(
    "$R robots <&- >/dev/null", "$R analyze nosuch 2>/dev/full", "$R robots fanuc 2>&- >/dev/null", "$R --help >&-",
)
@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("$R robots >&-", exits.BAD_INPUT, "rankdrop: error: stdout: cannot write: Bad file descriptor\n"),
        ("$R --help >&-", exits.BAD_INPUT, "rankdrop: error: stdout: cannot write: Bad file descriptor\n"),
        ("$R analyze planar3r --quiet --starts 100 --json - >&-", exits.BAD_INPUT,
         "rankdrop: error: stdout: cannot write: Bad file descriptor\n"),
        ("$R robots > /dev/full", exits.BAD_INPUT, "rankdrop: error: stdout: cannot write: No space left on device\n"),
        ("$R robots fanuc 2>&- >/dev/null", exits.FINE, ""),
        ("$R analyze nosuch 2>&-", exits.BAD_INPUT, ""),
        ("$R analyze nosuch 2>/dev/full", exits.BAD_INPUT, ""),
        ("$R robots <&- >/dev/null", exits.FINE, ""),
        ("$R robots nosuch >&- 2>&- <&-", exits.BAD_INPUT, ""),
    ],
)  # fmt: skip
def test_closed_and_full_streams(line: str, code: int, words: str) -> None:
    ended = shell(line)
    assert (ended.code, ended.err) == (code, words)
    assert not ended.out, "errors went to stdout"


@pytest.mark.slow
def test_a_reader_that_has_gone_is_no_error_of_ours() -> None:
    code = f"import os; os.close(1); os.execv({sys.executable!r}, {command('robots', '--json')!r})"
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(command("robots", "--json"), stdout=write, stderr=subprocess.PIPE, timeout=60)
    os.close(write)
    assert (done.returncode, done.stderr) == (exits.BROKEN_PIPE, b"")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=60)
    assert done.returncode == exits.BAD_INPUT


@pytest.mark.by_hand_at("words2", "words1")
@pytest.mark.slow
@pytest.mark.parametrize("words", [("--help",), ("explain", "--help"), ("completion", "bash")])
def test_a_help_whose_reader_has_gone_ends_like_everything_else(words: tuple[str, ...]) -> None:
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(command(*words), stdout=write, stderr=subprocess.PIPE, timeout=60)
    os.close(write)
    assert (done.returncode, done.stderr) == (exits.BROKEN_PIPE, b"")


@pytest.mark.slow
def test_files_are_written_though_stdout_is_closed(tmp_path: Path) -> None:
    ended = shell(f"$R analyze planar3r --quiet --starts 100 --json {tmp_path}/a.json >&-")
    assert ended.code == exits.BAD_INPUT
    assert (tmp_path / "a.json").stat().st_size > 1000


@pytest.mark.by_hand_at("rich.console")
@pytest.mark.slow_at("rich.console")
@pytest.mark.parametrize("module", ["importlib.metadata", "cyclopts", "numpy", "rich.console", "rankdrop.questions"])
def test_ctrl_c_while_a_module_is_imported(module: str) -> None:
    """The signal comes inside the import, deterministically: once as it is, once where the module swallows it."""
    program = """
import builtins, os, signal, sys
whole, armed = builtins.__import__, True
def importing(name, *rest):
    global armed
    if armed and name == MODULE:
        armed = False
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            raise ImportError("swallowed") from None
    return whole(name, *rest)
builtins.__import__ = importing
sys.argv = ["rankdrop", "explain", "planar3r", "--q", "0,0,0"]
from rankdrop.cli.main import main
main()
"""
    done = subprocess.run(
        [sys.executable, "-c", program.replace("MODULE", repr(module))], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stderr) == (exits.INTERRUPTED, "rankdrop: interrupted\n")


def test_ctrl_c_while_the_commands_are_put_together() -> None:
    """The imports are done, nothing runs yet."""
    program = """
import os, signal, sys
import cyclopts
def interrupted(self, *_, **__):
    os.kill(os.getpid(), signal.SIGINT)
cyclopts.App.command = interrupted
import rankdrop.cli.main
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (exits.INTERRUPTED, "rankdrop: interrupted\n")


def test_handlers_of_the_caller_are_left_alone(run: Any) -> None:
    before = signal.getsignal(signal.SIGINT)
    run("robots", "nosuch")
    assert signal.getsignal(signal.SIGINT) is before


def test_a_command_that_swallows_an_interrupt_ends_with_130(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def swallowing(_: str) -> tuple[()]:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            return ()
        raise AssertionError("no interrupt")

    monkeypatch.setattr("rankdrop.robot.search_catalog", swallowing)
    assert run("robots").code == exits.INTERRUPTED


@pytest.mark.parametrize("during", ["conditions", "slices"])
def test_an_interrupted_report_ends_with_130(
    during: str, run: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from rankdrop.report import content

    def stopping(*given: Any, **options: Any) -> Any:
        raise KeyboardInterrupt

    if during == "slices":
        monkeypatch.setattr(content, "telling_slices", stopping)
    else:  # it hands over what it has, and says that it was interrupted
        monkeypatch.setattr(content, "known_conditions", lambda *_: None)
        monkeypatch.setattr("rankdrop.verbs.deriving.corank_one", stopping)
    path = tmp_path / "a.html"
    ended = run("report", "planar3r", "--out", str(path), "--quiet")
    assert ended.code == exits.INTERRUPTED
    assert "interrupted" in ended.err
    assert path.exists() == (during == "conditions")


def test_an_interrupt_while_analyze_derives_ends_with_130(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopping(*given: Any, **options: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(import_module("rankdrop.verbs.conditions"), "conditions", stopping)
    ended = run("analyze", "planar3r", "--starts", "100", "--fresh", "--quiet")
    assert ended.code == exits.INTERRUPTED
    assert "Interrupted" in ended.out  # the derivation comes first: no corank is finished


@pytest.mark.slow
def test_many_joints_have_rank_and_singular_values(run: Any, tmp_path: Path) -> None:
    path = tmp_path / "long.toml"
    rows = "".join(f'[[joints]]\na = 0.{i + 10}\nalpha = "{i % 3 * 45} deg"\n' for i in range(40))
    path.write_text(f'convention = "standard"\n{rows}')
    ended = run("explain", str(path), "--full", "--q", ",".join(["0"] * 40))
    assert ended.code in (exits.FINE, exits.SINGULAR)
    assert re.search(r"rank \d of 6", ended.out)
    assert "σ = " in ended.out


HOSTILE = "x\x1b[31my\x9b2J\x07\u202ez"


@pytest.mark.slow
def test_nothing_of_a_file_steers_the_terminal(run: Any, tmp_path: Path) -> None:
    text = f"about = '''{HOSTILE}'''\nsource = '''{HOSTILE}'''\nnotes = ['''{HOSTILE}''']\nconvention = 'standard'\n"
    text = text.replace("\x1b", "\\u001b").replace("\x9b", "\\u009b").replace("\x07", "\\u0007").replace("'''", '"')
    path = tmp_path / "evil\x1b[2J.toml"
    path.write_text(text.replace("['", "[").replace("']", "]") + "[[joints]]\na = 1.0\n[[joints]]\na = 0.5\n")
    head = tmp_path / "head.csv"
    head.write_text("q1,q2,w\x1b[2Jx\n0,0,0\n1,1,1\n")
    for line in (
        ("analyze", str(path), "--task", "planar-position", "--starts", "50", "--quiet"),
        ("analyze", str(path), "--task", "planar-position", "--starts", "50", "--quiet", "--json", "-"),
        ("path", str(path), str(head), "--task", "planar-position"),
        ("path", str(path), "no\x1b[2J.csv", "--task", "planar-position"),
        ("analyze", "no\x1b[2Jarm"), ("analyze", "pa10", "--no\x1b[2J"), ("nosuch\x1b[2J",), ("robots", "\x1b[2J"),
    ):  # fmt: skip
        ended = run(*line)
        assert ended.out or ended.err
        for letter in "\x1b\x9b\x07\u202e":
            assert letter not in ended.out, line
            assert letter not in ended.err, line
    assert "x␛[31my" in run("analyze", str(path), "--task", "planar-position", "--starts", "50", "--quiet").out


def test_the_terminals_own_colours_are_kept(capsys: pytest.CaptureFixture[str], monkeypatch: Any) -> None:
    from rich.text import Text

    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    show(screen(), [Text(HOSTILE, style="bold red")])
    say(HOSTILE)
    text = capsys.readouterr()
    assert text.out.startswith("\x1b[1;31mx␛[31my")
    assert text.out.count("\x1b") == 2
    assert "\x1b" not in text.err
    assert visible("a\nb\tc θ²") == "a\nb\tc θ²"
    assert json_text({HOSTILE: HOSTILE}).isprintable() is False  # its line breaks
    assert all(line.isprintable() for line in json_text({HOSTILE: HOSTILE}).splitlines())


WITHOUT = {
    "--quiet": {"completion"},
    "--json": {"view", "completion", "monitor"},  # a page, a script, code in C
    "--seed": {"robots", "jacobian", "path", "through", "monitor", "cover", "sweep", "verify", "view",
               "completion"},  # nothing random, or it stands in a file
    "--threads": {"robots", "conditions", "jacobian", "explain", "tolerant", "path", "aspects",
                  "through", "monitor", "sweep", "compare", "verify", "view",
                  "completion"},  # one thread
    "--limits": {"robots", "conditions", "jacobian", "through", "monitor", "sweep",
                 "completion"},  # algebra; ways out are always inside; a path or a file says it
    "--tip": {"robots", "sweep", "completion", "compare"},  # no arm, several, or one of a file
}
"""Option -> the commands that do not have it: every other one has."""


@pytest.mark.spread(3)
@pytest.mark.slow
@pytest.mark.parametrize("option", WITHOUT)
def test_an_option_is_had_by_every_command_that_it_makes_sense_for(option: str) -> None:
    assert {name for name in COMMANDS if option not in main._options(name)} == WITHOUT[option]


def test_every_command_that_reads_a_configuration_reads_degrees() -> None:
    reading = {"--q", "--from", "--flags", "--initial"}
    options = {name: set(main._options(name)) for name in COMMANDS}
    assert [name for name, here in options.items() if reading & here and "--deg" not in here] == []


@pytest.mark.slow
def test_the_same_words_stand_beside_an_option_in_every_command(run: Any) -> None:
    """--quiet, --threads and --deg mean the same everywhere, so they are told in the same words."""
    told: dict[str, set[str]] = {}
    for name in COMMANDS:
        text = " ".join(run(name, "--help", width=1000).out.split())
        for option, words in (("--quiet", "no progress"), ("--deg", "degrees"), ("--threads", "processors")):
            if option in main._options(name):
                told.setdefault(option, set())
                if words not in text.lower():
                    told[option].add(name)
    assert told == {option: set() for option in told}


@pytest.mark.by_hand
@pytest.mark.parametrize("word", ["bash", "zsh", "fish"])
def test_completion_knows_every_command(word: str, run: Any) -> None:
    script = run("completion", word)
    assert script.code == exits.FINE
    assert [name for name in COMMANDS if name not in script.out] == []
    assert "--quiet" in script.out or "quiet" in script.out
    if shutil.which(word):
        assert subprocess.run([word, "-n"], input=script.out, text=True, capture_output=True).returncode == 0


@pytest.mark.by_hand
def test_bash_completes_commands() -> None:
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("bash is not installed")
    script = subprocess.run(command("completion", "bash"), capture_output=True, text=True, timeout=60).stdout
    ask = (
        f"{script}\nCOMP_WORDS=(rankdrop anal); COMP_CWORD=1; COMP_LINE='rankdrop anal'; COMP_POINT=13\n"
        "$(complete -p rankdrop | sed 's/.*-F \\([^ ]*\\).*/\\1/') rankdrop anal rankdrop\necho \"${COMPREPLY[@]}\""
    )
    done = subprocess.run([bash, "-c", ask], capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["analyze"], done.stderr


@pytest.mark.by_hand
def test_zsh_calls_the_script_where_it_is_autoloaded_and_knows_it_where_it_is_sourced(tmp_path: Path) -> None:
    zsh = shutil.which("zsh")
    if zsh is None:
        pytest.skip("zsh is not installed (apt-get install zsh)")
    script = subprocess.run(command("completion", "zsh"), capture_output=True, text=True, timeout=60).stdout
    (tmp_path / "_rankdrop").write_text(script, encoding="utf-8")
    called = (
        f"fpath=({tmp_path} $fpath); autoload -U _rankdrop; _arguments() {{ echo asked; return 1 }}; _rankdrop",
        f"compdef() {{ echo $1 is of $2 }}; source {tmp_path}/_rankdrop",
    )
    said = [subprocess.run([zsh, "-fc", one], capture_output=True, text=True, timeout=60).stdout for one in called]
    assert said == ["asked\n", "_cyclopts_rankdrop is of rankdrop\n"]


@pytest.mark.slow
def test_python_m_is_the_command() -> None:
    done = subprocess.run([sys.executable, "-m", "rankdrop", "--version"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert done.stdout == subprocess.run(command("--version"), capture_output=True, text=True, timeout=60).stdout


def test_nothing_tells_people_to_install_from_a_registry() -> None:
    """Whoever has the name there need not be us: `pip install` is followed by the folder of the source."""
    own = re.compile(r"""pip install (?:--quiet )?(?:-r |(?:-c \S+ )?(?:-e )?["'`]*\.(?:\[|["'`]|\s|$|\\))""")
    wrong = []
    folders = [ROOT / one for one in ("src", "docs", "examples", "tools")]
    files = [path for folder in folders for path in folder.rglob("*") if path.suffix in {".py", ".md", ".toml"}]
    for path in [*files, *ROOT.glob("*.md"), ROOT / ".ci" / "run"]:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            said = [found for found in re.finditer("pip install", line) if not own.match(line, found.start())]
            made = path.name == "errors.py" and "{source}" in line
            if (said and not made) or re.search(r"rankdrop\[\w+[\],]", line):
                wrong.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()[:100]}")
    assert not wrong, "\n".join(wrong)
    for extra in (None, "mujoco"):
        told = str(MissingExtraError("a", extra, "b"))
        assert own.search(told), told


def test_the_plain_install_has_what_the_readme_shows() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    plain = {re.split(r"[><=\[ ]", one)[0] for one in project["dependencies"]}
    assert plain >= {"python-flint", "matplotlib", "xacro", "pyyaml"}
    assert set(project["optional-dependencies"]) == {
        "viewer", "mujoco", "bags", "parquet", "sweep", "cluster", "test", "cross", "docs", "browser", "dev",
    }  # fmt: skip
    source = ROOT / "src" / "rankdrop"
    texts = [path.read_text(encoding="utf-8") for path in source.rglob("*.py")]
    named = [found for text in texts for found in re.findall(r'MissingExtraError\(\s*"([^"]+)", (None|"\w+")', text)]
    assert len(named) >= 8
    for package, extra in named:
        if extra == "None":
            assert package in plain
        else:
            assert any(one.startswith(package) for one in project["optional-dependencies"][extra.strip('"')])


def test_the_citation_names_this_version_and_the_five_documents() -> None:
    yaml = pytest.importorskip("yaml")
    told = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert told["version"] == tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert len(told["references"]) == len(DOCUMENTS) == 5
    for reference, title in zip(told["references"], DOCUMENTS.values(), strict=True):
        assert reference["title"] in title
        assert reference["authors"]
