"""What the command line does with mistakes and with what it is not asked for."""

from __future__ import annotations

import re
from typing import Any

import pytest

import rankdrop
from rankdrop.cli import exits


def test_a_bug_ends_with_one_and_a_traceback(run, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*args: object, **options: object) -> None:
        raise ZeroDivisionError("this test's own")

    monkeypatch.setattr(rankdrop, "analyze", broken)
    ended = run("analyze", "pa10")
    assert ended.code == exits.INTERNAL
    assert "Traceback" in ended.err
    assert "rankdrop: internal error: ZeroDivisionError: this test's own" in ended.err


@pytest.mark.by_hand
@pytest.mark.slow_at("zsh", "bash")
@pytest.mark.parametrize("word", ["bash", "zsh"])
def test_where_no_word_fits_names_of_files_are_offered(word: str, run: Any) -> None:
    script = run("completion", word).out
    if word == "bash":
        assert script.rstrip().endswith("complete -o default -F _rankdrop rankdrop")
        return
    lines = [line for line in script.splitlines() if re.search(r"--(json|out|html)\[|'1:.*file", line)]
    assert len(lines) > 20
    assert [line for line in lines if "]:" in line or "'1:" in line if ":_files'" not in line] == []
