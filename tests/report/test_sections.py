"""Sections of a page: angles in degrees."""

from __future__ import annotations

import re

import pytest

from report.pages import text_of


@pytest.mark.slow
def test_every_turn_is_told_in_degrees() -> None:
    text = text_of("stanford")
    assert "rad, m]" not in text
    assert re.search(r"Through a point of <b>k1\.f\d</b>: θ\d = −?[\d.]+°", text)
