"""Printed text without its line breaks."""

from __future__ import annotations


def one_line(text: object) -> str:
    return " ".join(str(text).split())
