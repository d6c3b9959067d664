"""How distances are worded, and what is proven of them."""

from __future__ import annotations

import json

from jsonschema import Draft202012Validator

from rankdrop.cli import exits
from rankdrop.schema import load_schema

REGULAR = ("ur5", "--deg", "--q", "0,-135,45,90,-90,0")


def test_nearest_prints_a_distance_and_a_proof(run) -> None:
    ended = run("nearest", *REGULAR)
    assert ended.code == exits.FINE
    assert "nearest singular configuration found: 0.4303 rad (24.7°) away" in ended.out
    assert "certified: no singularity within" in ended.out
    record = json.loads(run("nearest", *REGULAR, "--json", "-").out)
    Draft202012Validator(load_schema("nearest")).validate(record)
    assert 0.95 * record["nearest"]["distance"] < record["certified_radius"] <= record["nearest"]["distance"]
