"""Exit codes of commands."""

from __future__ import annotations

import pytest

from rankdrop.cli import exits


@pytest.mark.slow
def test_exit_codes_of_a_process(process) -> None:
    assert process("analyze", "nope").code == exits.BAD_INPUT
    assert process("--version").code == exits.FINE


def test_help_lists_every_exit_code(run) -> None:
    text = " ".join(run("--help").out.split())
    assert all(f"{code} {meaning}" in text for code, meaning in exits.MEANING.items())
