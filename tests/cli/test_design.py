"""The commands on sweeps."""

from __future__ import annotations

from pathlib import Path

import pytest

from rankdrop.cli import main
from rankdrop.designs import read_spec
from rankdrop.designs.sweeping import variants_of


def test_the_plan_to_try_has_the_variants_that_it_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "designs.toml"
    assert main.run(["sweep", "--example", str(file)]) == 0
    assert len(variants_of(read_spec(file))) == 8
    assert "8 variants; measure them: rankdrop sweep" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["designs.toml", "--example", "other.toml"], "fix: rankdrop sweep --example other.toml"),
        (["--example", "plan.txt"], "allowed: .toml"),
    ],
)
def test_a_plan_to_try_goes_with_no_other(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["sweep", *words]) == 2
    assert said in capsys.readouterr().err
