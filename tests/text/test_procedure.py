"""The procedure of Gallardo-Alvarado and Rico-Martínez, as it is printed."""

from __future__ import annotations

import json

import pytest
from jsonschema import Draft202012Validator

from rankdrop.local.ordered import OrderedScrewSet
from rankdrop.local.ordered_report import report
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.text.procedure import procedure_text


def test_a_regular_set_has_nothing_to_escape_from() -> None:
    found = report(OrderedScrewSet.of(open_robot("puma560"), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]))
    assert (found.lost, found.trials, found.printed, found.escapes) == (0, (), (), ())
    assert "not singular" in procedure_text(found)


@pytest.mark.slow
def test_escape_prints_the_ways_out_and_the_procedure_of_gallardo_and_rico(run) -> None:
    words = ("escape", "rcrrrr", "--q", "0,0,0,0,0,0,0", "--length-scale", "1", "--lie", "--full")
    text = run(*words).out
    for part in ("2.071 per rad", "0.7036 per rad", "subspace(1, 5);", "actuating screw 4 can restore (1, 5)",
                 "conclusion: actuate 3, 4", "Disagreements with the printed procedure"):  # fmt: skip
        assert part in text
    record = json.loads(run(*words, "--json", "-").out)
    Draft202012Validator(load_schema("escape")).validate(record)
    assert record["lie"]["lost"] == 1
    assert record["escape"]["single"][0]["number"] == 4
