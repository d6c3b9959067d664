"""The module that words a record."""

from __future__ import annotations

import pytest

from rankdrop import sections
from rankdrop.local.directions import LostDirection


def test_the_module_that_words_a_class_is_looked_up_once(monkeypatch: pytest.MonkeyPatch) -> None:
    record = LostDirection([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    module = sections.words_of(record)
    monkeypatch.delattr(sections, "import_module")
    assert sections.words_of(record) is module
