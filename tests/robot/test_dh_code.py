"""Code around a table: comments, names with values, arguments of calls, numbers of lines."""

from __future__ import annotations

import pytest

from rankdrop.robot.dh_code import call_arguments, code_of, constants_in, line_at, line_starts


def test_comments_and_signs_that_a_statement_goes_on_are_taken_out() -> None:
    assert code_of(["a = 1 # one", "b = 2; % two", "c = 3; // three", "L = f(1, ...  ", "2)"]) == (
        "a = 1 \nb = 2; \nc = 3; \nL = f(1, \n2)"
    )


def test_the_line_of_a_place_counts_the_ends_of_lines_before_it() -> None:
    code = "\n\nab\n\ncd\n"
    starts = line_starts(code)
    for place in range(len(code)):
        assert line_at(place, starts) == code.count("\n", 0, place) + 1


@pytest.mark.parametrize(
    ("line", "constants"),
    [("a2 = 0.25; a3 = h/2", {"a2": "0.25", "a3": "h/2"}), ("const double d1 = 0.1;", {"d1": "0.1"}),
     ("with l1 = 0.5 and l2 = 1.", {"l1": "0.5", "l2": "1"}), ("self.d = 2 mm", {"d": "2 mm"}),
     ("if a == 2:", {}), ("a = 1, a = 1", {"a": "1"}), ("a = 1, a = 2", {"a": "1 | 2"})],
)  # fmt: skip
def test_names_have_the_expressions_that_the_text_gives_them(line: str, constants: dict[str, str]) -> None:
    assert constants_in([line]) == constants


@pytest.mark.parametrize(
    ("text", "words", "behind"),
    [("d=1, a=2) + 3", ("d=1", "a=2"), " + 3"), (") + 3", ("",), " + 3"),
     ("f(1, 2), [3, (4)], {5: 6})", ("f(1, 2)", "[3, (4)]", "{5: 6}"), ""), ("1,\n 2\n)\n", ("1", "2"), "\n")],
)  # fmt: skip
def test_arguments_are_split_at_commas_outside_brackets(text: str, words: tuple[str, ...], behind: str) -> None:
    arguments = call_arguments(f"f({text}", 2)
    assert arguments.words == words
    assert f"f({text}"[arguments.end :] == behind
    assert arguments.closed


def test_a_call_without_an_end_is_read_to_the_bound() -> None:
    for text, end in (("1, (2", 5), ("x" * 1000 + ")", 600)):
        arguments = call_arguments(text, 0)
        assert (arguments.end, arguments.closed) == (end, False)
