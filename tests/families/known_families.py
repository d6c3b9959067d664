"""Families of an arm of the catalogue."""

from __future__ import annotations

from functools import cache

from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped


@cache
def known(name: str) -> Analysis:
    return shipped(name)
