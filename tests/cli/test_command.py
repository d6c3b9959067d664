"""The runner of commands: targets first, then the work, its text and its files, and the exit code last."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import pytest
from cyclopts import App

from rankdrop.cli import exits
from rankdrop.cli.command import DRAWN, OUTPUT, PROGRESS, Done, Output, command, deliver
from rankdrop.cli.terminal import Report
from rankdrop.errors import OptionError
from rankdrop.options import Options, option
from rankdrop.sections import Section


@dataclass(frozen=True)
class Search(Options):
    """Options of each type that the command line reads in a way of its own."""

    starts: Annotated[int, option("Random starts", ge=1)] = 100
    within: Annotated[float, option("Distance", unit="rad", ge=0)] = 0.5
    lift: Annotated[float, option("Length", unit="m", ge=0)] = 0.0
    speed: Annotated[float, option("Rate", unit="rad/s", ge=0)] = 1.0
    rows: Annotated[int, option("Rows", name="--at-most", ge=1)] = 9
    fresh: Annotated[bool, option("Derive anew")] = False
    cached: Annotated[bool, option("Use the cache")] = True
    figure: Annotated[str | None, option("Draw", writes=DRAWN)] = None
    page: Annotated[str | None, option("Write a page", name="--html", writes=())] = None


def read(*words: str) -> Search:
    """The record that a command is called with."""
    seen: list[Search] = []

    @command
    def take(how: Search = Search()) -> int:  # a record of constants
        seen.append(how)
        return 7

    app = App(name="tool", result_action="return_value")
    app.default(take)
    assert app(list(words), exit_on_error=False, print_error=False) == 7
    return seen[0]


@pytest.mark.parametrize(("words", "name", "value"), [
    ("--starts 10_000", "starts", 10_000), ("--starts +7", "starts", 7),
    ("--within 90deg", "within", pytest.approx(1.5707963)), ("--within 0.25", "within", 0.25),
    ("--lift 30mm", "lift", pytest.approx(0.03)), ("--speed 180deg/s", "speed", pytest.approx(3.1415927)),
    ("--fresh", "fresh", True), ("--no-cached", "cached", False), ("--figure -", "figure", "-"),
])  # fmt: skip
def test_options_are_read_in_their_units(words: str, name: str, value: object, tmp_path: Path) -> None:
    if name == "figure":
        words = f"--figure {tmp_path / 'a.svg'}"
        value = str(tmp_path / "a.svg")
    assert getattr(read(*words.split()), name) == value


@pytest.mark.parametrize("words", ["--starts 1e4", "--starts 3.0", "--starts ٣", "--starts 0", f"--starts 1{'0' * 100}",
                                   "--no-fresh", "--within 1mm", "--within -1"])  # fmt: skip
def test_what_is_no_value_of_an_option_is_refused(words: str) -> None:
    with pytest.raises(Exception, match=r"whole number|not allowed|unit|no-fresh"):
        read(*words.split())


def test_a_value_out_of_bounds_is_refused_under_the_name_that_is_typed() -> None:
    with pytest.raises(OptionError, match="at least 1") as caught:
        read("--at-most", "0")
    assert caught.value.where == "--at-most"


def test_a_file_that_cannot_be_written_is_refused_before_the_work(tmp_path: Path) -> None:
    worked: list[Search] = []

    @command
    def work(how: Search) -> int:
        worked.append(how)
        return 0

    with pytest.raises(OptionError, match="the ending names no format") as caught:
        work(Search(figure=str(tmp_path / "figure.txt")))
    assert caught.value.where == "--figure"
    with pytest.raises(OptionError, match="no such folder") as caught:
        work(Search(page=str(tmp_path / "no" / "page.html")))
    assert caught.value.where == "--html"
    same = str(tmp_path / "same.svg")
    with pytest.raises(OptionError, match="the file of --figure as well"):
        work(Search(figure=same, page=same))
    assert worked == []


def test_what_is_made_is_written_to_the_file_of_its_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page, figure = tmp_path / "page.html", tmp_path / "figure.svg"

    @command
    def work(how: Search, output: Output = OUTPUT) -> Done:
        files = {"page": lambda: "<p>", "figure": lambda: None, "json": lambda: {"starts": how.starts}}
        return Done(lambda: [Section("Found", lines=("answer",))], files)

    assert work(Search(figure=str(figure), page=str(page))) == exits.FINE
    assert page.read_text() == "<p>"
    assert not figure.exists()  # None: nothing to draw
    assert "answer" in capsys.readouterr().out
    assert work(Search(starts=3), Output(json="-")) == exits.FINE
    out = capsys.readouterr().out
    assert '"starts": 3' in out
    assert "answer" not in out  # stdout holds the file alone


@pytest.mark.parametrize(("done", "code"), [
    ({}, exits.FINE), ({"holds": False}, exits.UNEXPLAINED), ({"complete": False}, exits.INTERRUPTED),
    ({"complete": False, "holds": False}, exits.INTERRUPTED), ({"code": 4, "complete": False}, 4),
    ({"code": 0, "holds": False}, 0),
])  # fmt: skip
def test_the_code_is_the_works_own_else_by_whether_it_is_complete_and_holds(done: dict[str, int], code: int) -> None:
    assert deliver(Done(lambda: (), **done), {}) == code


def test_each_file_is_tried_where_one_before_has_failed(tmp_path: Path) -> None:
    steps: list[str] = []

    def broken() -> str:
        raise BrokenPipeError

    def refused() -> str:
        raise OptionError("there is no such remedy")

    done = Done(lambda: (), {"a": broken, "b": refused, "c": lambda: "text", "d": lambda: "no target"},
                last=lambda: steps.append("last"))  # fmt: skip
    names = {name: str(tmp_path / name) for name in "abc"} | {"d": None}
    with pytest.raises(OptionError, match="there is no such remedy"):  # not the reader that has gone
        deliver(done, names)
    assert [path.name for path in tmp_path.iterdir()] == ["c"]
    assert steps == ["last"]


def test_a_command_with_progress_is_given_a_reporter_that_is_no_option() -> None:
    seen: list[Report] = []

    @command
    def work(how: Search = Search(), *, report: PROGRESS) -> int:
        seen.append(report)
        return 0

    assert work() == 0
    seen[0]("points", 1, 2)
    app = App(name="tool", result_action="return_value")
    app.default(work)
    with pytest.raises(Exception, match="report"):
        app(["--report", "1"], exit_on_error=False, print_error=False)
