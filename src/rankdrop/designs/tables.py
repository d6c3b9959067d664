"""A sweep as Parquet: two tables, in partitions that pandas, DuckDB and others read as one, each written whole or not.

    variants/part-00000.parquet    a row for each variant: number, its parameters, its measures
    families/part-00000.parquet    a row for each family of each variant

Every column has its meaning and its unit in the metadata of its field: see `rankdrop.schema.design`.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rankdrop.designs.outcome import Designs
from rankdrop.disk import replace_file
from rankdrop.errors import MissingExtraError, ResultFileError
from rankdrop.schema.design import FAMILY_COLUMNS, TableColumn, variant_columns

ROWS = 1000
"""Variants of a partition."""
SCHEMA = "rankdrop/sweep-rows/1"


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
        ("variants", variant_columns(designs.parameters, designs.measures), iter),
        ("families", FAMILY_COLUMNS, _family_rows),
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


def _family_rows(records: Sequence[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
    for record in records:
        shares = {share["id"]: share for share in record.get("near", {}).get("families", [])}
        for family in record.get("families", []):
            yield {**family, "variant": record["number"] + 1, "share": shares.get(family["id"])}


def _table(
    arrow: Any, parquet: Any, columns: Sequence[TableColumn], rows: Sequence[Mapping[str, Any]], designs: Designs
) -> bytes:
    types = {"int64": arrow.int64(), "float64": arrow.float64(), "string": arrow.string()}
    fields = [arrow.field(name, types[kind], metadata={"meaning": meaning}) for name, kind, meaning, _ in columns]
    arrays = [arrow.array([take(row) for row in rows], types[kind]) for _, kind, _, take in columns]
    schema = arrow.schema(fields, metadata={"schema": SCHEMA, "robot": designs.robot, "task": designs.spec.task.name})
    out = io.BytesIO()
    parquet.write_table(arrow.table(arrays, schema=schema), out, compression="zstd")
    return out.getvalue()
