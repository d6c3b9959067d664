"""The published JSON Schemas of the result files, as package data."""

from __future__ import annotations

import json
from importlib import resources
from typing import Any

from rankdrop.errors import OptionError

NAMES = (
    "analysis", "find", "explanation", "escape", "nearest", "tolerant", "conditions", "jacobian", "path", "paths",
    "aspects", "through", "path-rows", "cover", "certificate", "verified", "sweep", "side-by-side",
)  # fmt: skip
"""Kinds of result files: each is what the command of that name writes with --json, `explain` the explanation,
`compare` the side-by-side."""


def load_schema(name: str) -> dict[str, Any]:
    """One schema.

    Args:
        name: "analysis" (`rankdrop analyze --json`), "find", "explanation" (`rankdrop explain --json`), "escape",
            "nearest", "tolerant", "conditions", "jacobian", "path", "paths" (`rankdrop path --json` with several
            files), "aspects", "through", "path-rows" (`rankdrop path --rows OUT.json`), "cover", "certificate"
            (--certificate), "verified" (`rankdrop verify --json`), "sweep" or "side-by-side" (`rankdrop compare`).

    Raises:
        OptionError: there is no such schema.

    Example:
        >>> load_schema("analysis")["properties"]["schema"]["const"]
        'rankdrop/analysis/1'
    """
    if name not in NAMES:
        raise OptionError("there is no such schema", got=repr(name), allowed=", ".join(NAMES))
    text = (resources.files("rankdrop.schema") / f"{name}.schema.json").read_text(encoding="utf-8")
    schema: dict[str, Any] = json.loads(text)
    return schema
