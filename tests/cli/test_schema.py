"""The published schemas: what is written satisfies them, they describe all of it, and they refuse what is broken."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from closed_schema import closed
from jsonschema import Draft202012Validator

from rankdrop.codec import json_text, record_of
from rankdrop.errors import OptionError
from rankdrop.families.searching import search
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.schema import NAMES, load_schema
from rankdrop.units import WRITTEN
from rankdrop.verbs.explain import explain


def validator(name: str) -> Draft202012Validator:
    return Draft202012Validator(load_schema(name))


@pytest.fixture(scope="module")
def find_record() -> dict[str, Any]:
    return json.loads(json_text(record_of("find", search(open_robot("stanford"), 1, starts=20))))


PLACES = {
    "regular": ("ur5", [0.0, -2.3, 0.8, 1.5, -1.5, 0.3], None),
    "near": ("puma560", [0.1, 0.5, 0.4, 0.2, 0.01, 0.6], None),
    "singular": ("pa10", [0.0] * 7, None),
    "slides": ("fetch8", [0.1] * 8, None),
    "few rows": ("scara", [0.3, 0.0, 0.1, 0.2], "position"),
    "another length": ("rcrrrr", [0.0] * 7, None),
    "beyond its limits": ("panda", [0.0, 0.3, 0.0, 1.0, 0.0, 1.9, 0.7], None),
}


@pytest.fixture(scope="module")
def explained() -> dict[str, dict[str, Any]]:
    """Records of explain, escape and nearest at each place, by "explanation regular" and so on."""
    records = {}
    for place, (name, q, task) in PLACES.items():
        found = explain(open_robot(name), q, task, coranks=6)
        way_out, far = record_of("escape", found), record_of("nearest", found)
        written = {"explanation": found.to_dict(), "escape": way_out, "nearest": far}
        records |= {f"{kind} {place}": json.loads(json_text(record)) for kind, record in written.items()}
    return records


@pytest.mark.slow
def test_explanations_are_valid_and_every_entry_is_described(explained: dict[str, dict[str, Any]]) -> None:
    assert {record["verdict"] for record in explained.values()} == {"regular", "near", "singular"}
    for name, record in explained.items():
        Draft202012Validator(closed(load_schema(name.split()[0]))).validate(record)
        assert record["units"] == WRITTEN, name


MOST = {
    "verdict": "fine", "rank": -1, "generic_rank": 5.5, "corank": None, "nullity": "1", "sigma": [1.0, None],
    "outside_limits": [0], "at_limits": 3, "q": ["0"], "reason": None, "settings": {}, "robot": {}, "disagreements": "",
}  # fmt: skip
DAMAGE: dict[str, tuple[tuple[Any, ...], Any]] = {
    "escape: no order": (("escape", "single", 0, "order"), 0),
    "escape: a joint counted from 0": (("escape", "single", 0, "number"), 0),
    "escape: a rate as text": (("escape", "single", 0, "rate"), "2.07 per rad"),
    "escape: limits as a number": (("escape", "single", 0, "within_limits"), 1),
    "escape: avoidable in words": (("escape", "avoidable"), "yes"),
    "escape: a direction without a motion": (("escape", "best_direction"), {}),
    "escape: a third type": (("escape", "types", 0, "type"), 3),
    "escape: an empty circuit": (("circuits", 0), []),
    "escape: blame without circuits": (("blame",), {"smallest": []}),
    "nearest: a distance below zero": (("nearest", "distance"), -0.1),
    "nearest: no family": (("nearest", "family"), "wrist"),
    "nearest: a radius below zero": (("certified_radius",), -1.0),
    "explanation: five numbers lost": (("lost_directions", 0), [0.0] * 5),
    "explanation: a source of its own": (("family", "source"), "guess"),
    "explanation: a family of corank 0": (("family", "corank"), 0),
    "explanation: a relation without words": (("relations", 0), {"structural": True}),
    "explanation: a speed as text": (("joint_rates", "axes", 0, "speed"), "fast"),
    "explanation: no projector": (("redundancy", "projector"), None),
    "explanation: no quaternion": (("representations", "quaternion"), None),
    "explanation: an ellipsoid without axes": (("ellipsoids", "unit_rates", "task", "velocity"), {"unit": "m/s"}),
}


@pytest.mark.by_hand
@pytest.mark.slow_at("explanation")
@pytest.mark.parametrize("kind", ["explanation", "escape", "nearest"])
def test_records_without_an_entry_or_with_a_wrong_one_are_refused(
    explained: dict[str, dict[str, Any]], kind: str
) -> None:
    check, whole = validator(kind), explained[f"{kind} singular"]
    assert check.is_valid(whole)
    for name in set(whole) - {"units", "summary", "slowest", "slow_family"}:  # which files of 0.2.0 do not have
        assert not check.is_valid({key: value for key, value in whole.items() if key != name}), name
    for name, value in MOST.items():
        assert not check.is_valid(whole | {name: value}), name


@pytest.mark.slow
@pytest.mark.parametrize("name", DAMAGE)
def test_a_broken_explanation_is_refused(explained: dict[str, dict[str, Any]], name: str) -> None:
    kind, (path, value) = name.partition(":")[0], DAMAGE[name]
    record = copy.deepcopy(explained[f"{kind} singular"])
    place: Any = record
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    assert not validator(kind).is_valid(record)


@pytest.mark.spread(9)
@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_schemas_are_schemas(name: str) -> None:
    Draft202012Validator.check_schema(load_schema(name))


def test_what_is_written_is_valid(found: Analysis, shapes: Analysis, find_record: dict[str, Any]) -> None:
    for analysis in (found, shapes):
        validator("analysis").validate(json.loads(json_text(analysis.to_dict())))
    validator("find").validate(find_record)


def test_every_entry_written_is_described(found: Analysis, shapes: Analysis, find_record: dict[str, Any]) -> None:
    """With unknown entries forbidden everywhere, the records are still valid."""
    for name, record in (("analysis", found.to_dict()), ("analysis", shapes.to_dict()), ("find", find_record)):
        Draft202012Validator(closed(load_schema(name))).validate(json.loads(json_text(record)))


def test_letters_for_lengths_are_described() -> None:
    record = json.loads(json_text(shipped("canadarm2").to_dict()))
    assert record["robot"]["lengths"] == {"a": 0.635, "c": 0.504, "d": 6.85}
    check = Draft202012Validator(closed(load_schema("analysis")))
    check.validate(record)
    for wrong in ({"a": "635 mm"}, {"a": -1.0}, ["a"]):
        assert not check.is_valid(record | {"robot": record["robot"] | {"lengths": wrong}})


BROKEN = {
    "another version": lambda r: r.update(schema="rankdrop/analysis/2"),
    "no settings": lambda r: r.pop("settings"),
    "no seed": lambda r: r["settings"].pop("seed"),
    "a joint counted from 0": lambda r: r["robot"]["joints"][0].update(number=0),
    "an unknown kind of joint": lambda r: r["robot"]["joints"][0].update(kind="fixed"),
    "an infinity as text": lambda r: r["robot"]["joints"][0].update(lower="-inf"),
    "a pinned joint without a value": lambda r: r["families"][0]["pinned"][0].update(values=[]),
    "a direction of five numbers": lambda r: r["families"][0]["lost_directions"][0].pop(),
    "an equation that is no text": lambda r: r["families"][0]["equations"].__setitem__(0, 0.0),
    "a count below zero": lambda r: r["coranks"][0].update(near_misses=-1),
    "completeness as a share": lambda r: r["coranks"][0].update(completeness=1.0),
    "no soundness": lambda r: r["families"][0].pop("soundness"),
    "an id of another form": lambda r: r["families"][0].update(id="family 1"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_analysis_is_refused(shapes: Analysis, name: str) -> None:
    record = copy.deepcopy(json.loads(json_text(shapes.to_dict())))
    BROKEN[name](record)
    assert not validator("analysis").is_valid(record)


def test_a_broken_find_is_refused(find_record: dict[str, Any]) -> None:
    for damage in (
        lambda r: r["configurations"][0].update(outcome="found"),
        lambda r: r["configurations"][0].pop("sigma"),
        lambda r: r["settings"].update(method="magic"),
        lambda r: r.update(schema="rankdrop/analysis/1"),
    ):
        record = copy.deepcopy(find_record)
        damage(record)
        assert not validator("find").is_valid(record)


INSIDE = ("anyOf", "oneOf", "allOf", "if", "then", "else", "items", "prefixItems", "additionalProperties")


def numbers(schema: Any, name: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Every place of a schema where a number is allowed that need not be whole, and the entry that it belongs to."""
    for part in schema if isinstance(schema, list) else [schema]:
        if not isinstance(part, dict):
            continue
        if "number" in ([part["type"]] if isinstance(part.get("type"), str) else part.get("type", [])):
            yield name, part
        for key in ("properties", "$defs"):
            for inner, entry in part.get(key, {}).items():
                yield from numbers(entry, inner)
        for key in INSIDE:
            yield from numbers(part.get(key), name)


def told_units() -> set[str]:
    """The units that docs/json.md explains."""
    text = (Path(__file__).parents[2] / "docs" / "json.md").read_text(encoding="utf-8")
    table = text.partition("| `unit` | meaning |")[2].partition("```")[0]
    return {unit for row in table.splitlines()[2:] for unit in re.findall("`([^`]+)`", row.partition(" | ")[0])}


def test_every_number_has_a_unit_that_is_explained() -> None:
    known, used = told_units(), set()
    for name in NAMES:
        for entry, place in numbers(load_schema(name)):
            assert place.get("unit") in known, (name, entry, place)
            used.add(place["unit"])
    assert used == known


ELSEWHERE = {
    "at": "a place of the tool, or a share of the way", "determinant": "of a Jacobian, or of rates of coordinates",
    "direction": "lost: a unit vector; asked for: of one unit of speed", "least": "of distances, or of σ",
    "length": "of a path in joint space, or in the arm", "lower": "of a joint, or of what is varied",
    "matrix": "a Jacobian, or cofactors of the scaled one", "median": "of distances, or of σ",
    "most": "of distances, or of σ", "off": "the tool's place, or place and turn together",
    "place": "a row of a file, or a pose of a path", "points": "on an arm, or of a path",
    "ranges": "of joints, or of what is varied",
    "rate": "of σ, of a joint, or as a share of its limit", "residual": "of a configuration, or of a Jacobian",
    "rows": "of a path, or of a table", "step": "of one joint, of all, or a share of a step",
    "to": "a place of the tool, or joints after a turn", "upper": "of a joint, of what is varied, or of a share",
    "value": "of a joint, of a condition, or of what is named beside it", "values": "of joints, or of what is varied",
}  # fmt: skip


def test_an_entry_has_one_unit_in_all_files() -> None:
    units: dict[str, set[str]] = {}
    for name in NAMES:
        for entry, place in numbers(load_schema(name)):
            units.setdefault(entry, set()).add(place["unit"])
    assert {entry for entry, found in units.items() if len(found) > 1} == set(ELSEWHERE)


@pytest.mark.parametrize("name", [name for name in NAMES if list(numbers(load_schema(name)))])
def test_a_file_says_its_units_first(name: str) -> None:
    schema = closed(load_schema(name))
    assert list(schema["properties"])[:2] == ["schema", "units"]
    Draft202012Validator({**schema["properties"]["units"], "$defs": schema["$defs"]}).validate(WRITTEN)


def test_a_schema_that_does_not_exist_is_refused() -> None:
    with pytest.raises(OptionError, match="allowed: analysis, find"):
        load_schema("atlas")
