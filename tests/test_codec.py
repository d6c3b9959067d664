"""Files as text: numbers, and rows of them on a line."""

from __future__ import annotations

import json

from rankdrop.codec import json_text
from rankdrop.results.analysis import Analysis


def test_the_text_holds_no_infinity_and_rows_of_numbers_stay_on_a_line(found: Analysis) -> None:
    text = json_text(found.to_dict())
    assert "Infinity" not in text
    assert "NaN" not in text
    assert json.loads(text) == found.to_dict()
    assert '"witness": [' + ", ".join(map(repr, found.families[0].witness)) + "]" in text
