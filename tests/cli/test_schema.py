"""The published schemas: what is written satisfies them, they describe all of it, and they refuse what is broken."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from rankdrop.atlas.search import search
from rankdrop.errors import OptionError
from rankdrop.findings import find_to_dict
from rankdrop.record import json_text
from rankdrop.result import Analysis
from rankdrop.robot.open import open_robot
from rankdrop.schema import NAMES, load_schema


def validator(name: str) -> Draft202012Validator:
    return Draft202012Validator(load_schema(name))


@pytest.fixture(scope="module")
def find_record() -> dict[str, Any]:
    return json.loads(json_text(find_to_dict(search(open_robot("stanford"), 1, starts=20))))


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


def closed(schema: Any) -> Any:
    if isinstance(schema, list):
        return [closed(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    inner = {key: closed(part) for key, part in schema.items()}
    return inner | {"additionalProperties": False} if schema.get("type") == "object" else inner


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


def test_a_schema_that_does_not_exist_is_refused() -> None:
    with pytest.raises(OptionError, match="allowed: analysis, find"):
        load_schema("atlas")
