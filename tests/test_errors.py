"""Errors say in one line what is wrong, where, what was given, what is allowed and how to fix it, and steer nothing."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rankdrop.errors import (
    ConfigurationError,
    MissingExtraError,
    OptionError,
    RankdropError,
    ResultFileError,
    RobotError,
    TaskError,
    UnknownRobotError,
    visible,
)

LIMIT = OptionError(
    "the corank is too large", where="corank", got=9, allowed="1 … 6", mend="corank=1", typed="--corank 1"
)


def test_every_part_stands_in_one_line_in_its_order() -> None:
    assert str(LIMIT) == "corank: the corank is too large; got 9; allowed: 1 … 6; fix: corank=1"
    assert str(RankdropError("it is broken")) == "it is broken"
    assert str(RobotError("two\nlines", got=0)) == "two lines; got 0"


def test_a_command_shows_the_option_as_it_is_typed() -> None:
    assert LIMIT.on_command_line({"--corank"}).startswith("--corank: ")
    assert LIMIT.on_command_line({"--starts"}).startswith("corank: ")
    assert LIMIT.on_command_line().endswith("fix: --corank 1")
    plain = OptionError("too many", where="max_starts", mend="fewer")
    assert plain.on_command_line({"--max-starts"}) == "--max-starts: too many; fix: fewer"


def test_an_error_is_made_again_from_its_parts() -> None:
    again = OptionError(**LIMIT.parts)
    assert (str(again), again.parts, again.on_command_line()) == (str(LIMIT), LIMIT.parts, LIMIT.on_command_line())


STEERING = (
    *(code for code in range(0x20) if chr(code) not in "\n\t"), 0x7F, *range(0x80, 0xA0), 0x200E, 0x200F,
    *range(0x2028, 0x202F), *range(0x2066, 0x206A), 0xFEFF,
)  # fmt: skip
"""Control characters, and marks that turn the direction of writing or break a line."""


def test_signs_that_steer_are_shown_and_their_neighbours_stay() -> None:
    shown = [visible(chr(code)) for code in STEERING]
    assert all(len(sign) == 1 and ord(sign) not in STEERING for sign in shown)
    assert (visible("\x1b[2J"), visible("\x7f\x00"), visible("\x9b\u202e")) == ("␛[2J", "␡␀", "��")
    plain = "\u200d\u2010\u2027\u202f\u2065\u206a\ufefe\u00a0~ \n\t"
    assert visible(plain) == plain


@given(st.text(max_size=200))
def test_nothing_of_an_error_steers_a_terminal(text: str) -> None:
    """A line of an error has no line break, no control character, no mark of direction."""
    line = str(RobotError(text, where=text, got=text))
    assert not {ord(letter) for letter in line} & {*STEERING, ord("\n"), ord("\t")}


def test_a_long_value_shows_both_its_ends() -> None:
    line = str(RobotError("no number", got="a" * 5000 + "z"))
    assert len(line) < 250
    assert "aaa … aaa" in line
    assert line.endswith("az")


def test_every_error_is_one_of_rankdrop() -> None:
    for kind in (RobotError, UnknownRobotError, ConfigurationError, TaskError, OptionError, ResultFileError):
        with pytest.raises(RankdropError, match="wrong"):
            raise kind("wrong")
    assert issubclass(UnknownRobotError, RobotError)


@pytest.mark.parametrize(("extra", "command"), [("viewer", 'pip install ".[viewer]"'), (None, "pip install .")])
def test_a_missing_package_says_what_needs_it_and_how_it_is_installed(extra: str | None, command: str) -> None:
    error = MissingExtraError("viser", extra, "the viewer")
    assert (error.package, error.extra) == ("viser", extra)
    assert str(error) == f"the viewer needs the package viser; fix: in the folder of rankdrop's source: {command}"
