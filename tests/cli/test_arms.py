"""The commands on the arms that are there."""

from __future__ import annotations

import json


def test_robots_finds_the_arms_of_a_maker(run) -> None:
    listed = json.loads(run("robots", "fanuc", "--json").out)
    assert len(listed) >= 5
    assert {entry["maker"] for entry in listed} == {"FANUC"}
    text = run("robots", "fanuc").out
    assert all(entry["name"] in text for entry in listed)
    assert "pa10" not in text
    assert "No arm of the catalogue fits 'robbie'" in run("robots", "robbie").out
