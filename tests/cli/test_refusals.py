"""What the commands refuse, and what they keep when the output cannot be written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import command

import rankdrop
from rankdrop.cli import exits
from rankdrop.errors import OptionError, ResultFileError, RobotError, TaskError
from rankdrop.families.record import Check
from rankdrop.results.analysis import Analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.text.families import rounded_share, share_text

SMALL = ("--starts", "200", "--quiet")
FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")


@pytest.mark.parametrize(
    ("option", "word", "allowed"),
    [
        ("--seed", "-5", "0 … 9223372036854775807"),
        ("--seed", "99999999999999999999999", "0 … 9223372036854775807"),
        ("--starts", "999999999999999999999", "1 … 10000000"),
        ("--starts", "100000000000", "1 … 10000000"),
        ("--threads", "-1", "0 … 1024"),
        ("--threads", "9999999999999", "0 … 1024"),
        ("--starts", "100.9", "digits"),
        ("--corank", "1.5", "digits"),
    ],
)
def test_numbers_out_of_range_are_refused_in_one_line(run, option: str, word: str, allowed: str) -> None:
    corank = () if option == "--corank" else ("--corank", "1")
    lines = [("find", "scara", *corank, option, word)]
    if corank:
        lines.append(("analyze", "scara", option, word))
    for argv in lines:
        ended = run(*argv)
        assert (ended.code, ended.out, ended.err.count("\n")) == (exits.BAD_INPUT, "", 1)
        assert word in ended.err
        assert allowed in ended.err


def test_whole_numbers_may_be_written_with_underscores(run) -> None:
    ended = run("find", "scara", "--corank", "1", "--starts", "1_00", "--quiet")
    assert ended.code == exits.FINE
    assert "of 100 starts" in ended.out


@pytest.mark.parametrize("line", [("analyze", "scara", "--json", "--quiet"), ("report", "scara", "--out", "--quiet"),
                                  ("find", "scara", "--corank", "1", "--json", "--limits")])  # fmt: skip
def test_an_option_is_not_taken_for_a_file(run, line: tuple[str, ...], tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    ended = run(*line)
    assert (ended.code, ended.out) == (exits.BAD_INPUT, "")
    assert ended.err == f"rankdrop: error: {line[-2]}: it needs the name of a file; got {line[-1]}; " \
                        f"allowed: a file name, or -; fix: ./{line[-1]} if that is its name\n"  # fmt: skip
    assert list(tmp_path.iterdir()) == []


def test_find_refuses_one_file_for_two_results(run, tmp_path: Path) -> None:
    path = str(tmp_path / "a.csv")
    ended = run("find", "scara", "--corank", "1", *SMALL, "--out", path, "--history", f"{tmp_path}/./a.csv")
    assert ended.code == exits.BAD_INPUT
    assert "it is the file of --out as well" in ended.err
    assert not Path(path).exists()


@needs_full
@pytest.mark.parametrize("argv", [("analyze", "scara"), ("find", "scara", "--corank", "1")])
def test_tables_are_printed_though_the_file_cannot_be_written(run, argv: tuple[str, ...], tmp_path: Path) -> None:
    others = ("--out", str(tmp_path / "out.csv")) if argv[0] == "find" else ()
    ended = run(*argv, *SMALL, "--json", str(FULL), *others)
    assert ended.code == exits.BAD_INPUT
    assert ("Corank 1" if argv[0] == "find" else "scara has 1 family") in ended.out
    assert ended.err == "rankdrop: error: /dev/full: cannot write: No space left on device\n"
    assert len(list(tmp_path.iterdir())) == len(others) // 2


@pytest.mark.by_hand_at("argv0", "argv2")
@pytest.mark.slow_at("argv0")
@pytest.mark.slow_at("argv2")
@needs_full
@pytest.mark.parametrize("argv", [("robots",), ("--help",), ("analyze", "scara", *SMALL)])
def test_a_full_stdout_is_one_line_and_files_are_written(argv: tuple[str, ...], tmp_path: Path) -> None:
    kept = tmp_path / "kept.json"
    saving = ("--json", str(kept)) if argv[0] == "analyze" else ()
    with FULL.open("w") as full:
        done = subprocess.run(command(*argv, *saving), stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == exits.BAD_INPUT
    assert done.stderr == "rankdrop: error: stdout: cannot write: No space left on device\n"
    assert not saving or Analysis.load(kept).complete


def test_the_share_of_a_row_is_rounded_and_completeness_is_not() -> None:
    assert rounded_share(Check(3000, 2000)) == "66.7 %"
    assert rounded_share(Check(0, 0)) == "–"
    assert share_text(9999, 10_000) == "99.9 %"


def test_a_name_is_not_a_robot() -> None:
    for call in (
        lambda: rankdrop.analyze("pa10"),  # type: ignore[arg-type]
        lambda: rankdrop.jacobian("pa10", [0.0] * 7),  # type: ignore[arg-type]
        lambda: rankdrop.pose("pa10", [0.0] * 7),  # type: ignore[arg-type]
        lambda: rankdrop.search("pa10", 1),  # type: ignore[arg-type]
    ):
        with pytest.raises(RobotError, match=r"a Robot is needed; got 'pa10'; .*open_robot"):
            call()


@pytest.mark.parametrize("task", [5, 2.5, [1, 2], {"vx": 1}, b"pose", True])
def test_what_is_no_task_is_refused_in_one_line(task) -> None:
    with pytest.raises(TaskError, match="or rows out of vx"):
        resolve_task(task, open_robot("ur5e"))



def test_an_analysis_that_cannot_be_saved_says_so(found: Analysis) -> None:
    for path in ("/no/such/folder/a.json", "/", "a\0b"):
        with pytest.raises(ResultFileError, match="the file cannot be written"):
            found.save(path)


def test_analyze_takes_a_length_scale() -> None:
    assert rankdrop.analyze(open_robot("scara"), starts=100, length_scale=2.0).settings.length_scale == 2.0


def test_analyze_refuses_numbers_that_are_not_whole() -> None:
    with pytest.raises(OptionError, match=r"starts: this value is not allowed; got 2\.5; allowed: a whole number, 1"):
        rankdrop.analyze(open_robot("scara"), starts=2.5)  # type: ignore[arg-type]


def test_an_interrupt_while_the_command_is_imported_leaves_no_traceback(tmp_path: Path) -> None:
    (tmp_path / "cyclopts.py").write_text("raise KeyboardInterrupt\n", encoding="utf-8")
    paths = os.pathsep.join([str(tmp_path), *sys.path])
    done = subprocess.run(
        command("robots"), env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stderr) == (exits.INTERRUPTED, "rankdrop: interrupted\n")


def test_figures_and_tables_are_not_printed(run) -> None:
    """Where the ending of a file names its format, - is refused before the work."""
    for line in (("find", "scara", "--corank", "1", "--out", "-"), ("path", "ur5e", "p.csv", "--figure", "-")):
        ended = run(*line)
        assert ended.code == exits.BAD_INPUT
        assert "the ending names no format" in ended.err
