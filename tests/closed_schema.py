"""JSON schemas in which nothing may stand that they do not name."""

from __future__ import annotations

from typing import Any


def closed(schema: Any) -> Any:
    if isinstance(schema, list):
        return [closed(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    inner = {key: closed(part) for key, part in schema.items()}
    kind = schema.get("type")
    closes = "properties" in schema and (kind == "object" or (isinstance(kind, list) and "object" in kind))
    return inner | {"additionalProperties": False} if closes else inner
