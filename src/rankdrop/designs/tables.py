"""A finished sweep as Parquet: partitions that pandas, DuckDB and others read as one table.

    variants/part-00000.parquet    a row for each variant: number, its parameters, its measures
    families/part-00000.parquet    a row for each family of each variant

Every column has its meaning and its unit in the metadata of its field. Partitions are
written one after the other, each whole or not at all.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rankdrop.designs.outcome import Designs
from rankdrop.disk import replace_file
from rankdrop.errors import MissingExtraError, ResultFileError
from rankdrop.schema.design import MEANINGS, UNITS

ROWS = 1000
"""Variants of a partition."""
SCHEMA = "rankdrop/sweep-rows/1"
Column = tuple[str, str, str, Callable[[Mapping[str, Any]], Any]]


def write_tables(designs: Designs, folder: str | Path) -> tuple[Path, Path]:
    """Write the two tables of a sweep.

    Args:
        designs: the sweep.
        folder: in which `variants` and `families` are made.

    Returns:
        The two folders.

    Raises:
        MissingExtraError: pyarrow is not installed.
        ResultFileError: the folder cannot be written.
    """
    arrow, parquet = _pyarrow()
    made = []
    for name, columns, rows in (
        ("variants", _variant_columns(designs), _each),
        ("families", _family_columns(), _every),
    ):
        target = Path(folder) / name
        try:
            target.mkdir(parents=True, exist_ok=True)
            for number, first in enumerate(range(0, len(designs.records), ROWS)):
                content = _table(arrow, parquet, columns, list(rows(designs.records[first : first + ROWS])), designs)
                replace_file(target / f"part-{number:05}.parquet", content)
        except OSError as error:
            raise ResultFileError(f"cannot write: {error.strerror or error}", where=str(target)) from error
        made.append(target)
    return made[0], made[1]


def check_tables() -> None:
    """Find out before a long run whether tables can be written.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    _pyarrow()


def _pyarrow() -> tuple[Any, Any]:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise MissingExtraError("pyarrow", "parquet", "a Parquet file") from error
    return pyarrow, parquet


def _each(records: Sequence[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
    yield from records


def _every(records: Sequence[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
    for record in records:
        shares = {one["id"]: one for one in record.get("near", {}).get("families", [])}
        for family in record.get("families", []):
            yield {**family, "variant": record["number"] + 1, "share": shares.get(family["id"])}


def _picked(part: str, key: int | str) -> Callable[[Mapping[str, Any]], Any]:
    """Entry `key` of a part of a record, null where a measure is not there."""
    return lambda one: one[part][key] if isinstance(key, int) else one[part].get(key)


def _variant_columns(designs: Designs) -> list[Column]:
    columns: list[Column] = [("variant", "int64", "number of the variant, from 1", lambda one: one["number"] + 1)]
    for k, parameter in enumerate(designs.parameters):
        columns.append((f"{parameter.name}_{parameter.unit}", "float64", f"parameter, sets {_sets(parameter.places)}",
                        _picked("values", k)))  # fmt: skip
    for name in designs.measures:
        unit = f"; {UNITS[name]}" if UNITS[name] else ""
        columns.append((name, "float64", MEANINGS[name] + unit,
                        _picked("measures", name)))  # fmt: skip
    columns += [
        ("verdict", "string", "of its families; null where they were not asked for", lambda one: one.get("verdict")),
        ("error", "string", "why it could not be measured as a whole; null where it was", lambda one: one["error"]),
    ]
    return columns


def _sets(places: Sequence[object]) -> str:
    return ", ".join(map(str, places))


def _family_columns() -> list[Column]:
    return [
        ("variant", "int64", "number of the variant, from 1", lambda one: one["variant"]),
        ("family", "string", "id of the family in its variant", lambda one: one["id"]),
        ("key", "string", "what it is, apart from the arm's lengths", lambda one: one["key"]),
        ("name", "string", "its name", lambda one: one["name"]),
        ("corank", "int64", "rank lost on it", lambda one: one["corank"]),
        ("dimension", "int64", "of it in joint space", lambda one: one["dimension"]),
        ("conditions", "string", "of its coupled joints, one a line", lambda one: "\n".join(one["conditions"])),
        ("sound", "int64", "solutions of its conditions that are singular", lambda one: one["sound"][0]),
        ("tested", "int64", "solutions of its conditions", lambda one: one["sound"][1]),
        ("share", "float64", "share of the joint space near it; null where not asked for",
         lambda one: None if one["share"] is None else one["share"]["share"]),
        ("share_error", "float64", "standard error of the share",
         lambda one: None if one["share"] is None else one["share"]["error"]),
    ]  # fmt: skip


def _table(
    arrow: Any, parquet: Any, columns: Sequence[Column], rows: Sequence[Mapping[str, Any]], designs: Designs
) -> bytes:
    types = {"int64": arrow.int64(), "float64": arrow.float64(), "string": arrow.string()}
    fields = [arrow.field(name, types[kind], metadata={"meaning": meaning}) for name, kind, meaning, _ in columns]
    arrays = [arrow.array([take(row) for row in rows], types[kind]) for _, kind, _, take in columns]
    schema = arrow.schema(fields, metadata={"schema": SCHEMA, "robot": designs.robot, "task": designs.task})
    out = io.BytesIO()
    parquet.write_table(arrow.table(arrays, schema=schema), out, compression="zstd")
    return out.getvalue()
