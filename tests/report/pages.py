"""What a reader sees of a page."""

from __future__ import annotations

from functools import cache

from rankdrop.report.content import Content, content
from rankdrop.report.page import page
from rankdrop.results.known import shipped


@cache
def shown(name: str, *, exact: bool = True) -> Content:
    return content(shipped(name), exact=exact)


@cache
def text_of(name: str) -> str:
    return page(shown(name))
