"""The picture of README and site is what the tool draws now, and small."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

from scripts import tool

ROOT = Path(__file__).resolve().parents[2]
PICTURE = ROOT / "docs" / "images" / "pa10.svg"


def numbers(text: str) -> list[float]:
    """Every number of a drawing."""
    return [float(number) for number in re.findall(r"-?\d+\.?\d*", text)]


def test_the_picture_is_what_is_drawn_now() -> None:
    """Up to a tenth of a pixel: the last bits of coordinates may differ from machine to machine."""
    drawn, kept = tool("draw_singularities").drawing(), PICTURE.read_text(encoding="utf-8")
    assert re.sub(r"-?\d+\.?\d*", "#", drawn) == re.sub(r"-?\d+\.?\d*", "#", kept)
    assert all(abs(a - b) < 0.11 for a, b in zip(numbers(drawn), numbers(kept), strict=True))


def test_the_picture_stands_alone_and_is_small() -> None:
    root = ElementTree.parse(PICTURE).getroot()
    assert PICTURE.stat().st_size < 200_000
    assert root.find("{http://www.w3.org/2000/svg}title") is not None
    assert "url(" not in PICTURE.read_text(encoding="utf-8")
