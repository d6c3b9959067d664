"""A checked path row by row, as a table: for notebooks, databases and plots of one's own."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.codec import plain, record_of
from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.path.check.record import VERDICTS
from rankdrop.path.check.survey import measures
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import known_families
from rankdrop.text.path_files import COLUMNS
from rankdrop.units import in_metres, into_metres, task_in_metres
from rankdrop.version import VERSION

if TYPE_CHECKING:
    from rankdrop.path.check.record import PathCheck

SCHEMA = "rankdrop/path-rows/1"
FORMATS = (".parquet", ".json", ".csv")
"""Endings of a file of rows."""


@dataclass(frozen=True, eq=False)
class PathRows:
    """The rows of a checked path.

    Attributes:
        columns: name -> (T,) numbers or words; every name ends in its unit, where it has one.
        about: name -> meaning.
        robot, verdict: of the path.
    """

    columns: dict[str, Any]
    about: dict[str, str]
    robot: str
    verdict: str

    def lines(self) -> Iterator[tuple[Any, ...]]:
        """The rows, None where there is no number."""
        return zip(*(plain(list(values)) for values in self.columns.values()), strict=True)

    def to_dict(self) -> dict[str, Any]:
        """The record of a JSON file: docs/json.md."""
        return record_of("path-rows", self)


def path_rows(check: PathCheck, analysis: Analysis | None = None) -> PathRows:
    """Joint values, verdict, nearest family, distances, σ and rates at every row.

    The verdict of a row is the worst of the way from it to the next row: what lies between two rows is lost in neither.
    Distances are measured at every row, about 1 ms each where families are of coupled joints.

    Args:
        check: from `check_path` or `check_poses`.
        analysis: the families that it was checked with; else from the catalogue.
    """
    robot, task, curve = check.robot, check.task, check.curve
    count = check.rows
    q = np.concatenate([curve.control[:, 0], curve.control[-1:, -1]])[:count]
    if curve.times is None:
        times = None
    else:
        times = curve.times[:count]
    families, _ = known_families(robot, task, analysis, check.tolerances)
    there, there_task, moved = in_metres(robot), task_in_metres(task, robot), into_metres(robot, q)
    _, near, ruler = measures(robot, there_task, families, check.options, check.tolerances)
    measured = ruler.measure(moved, along=True)
    which, far = measured.nearest()
    rank = generic_rank(there, there_task)
    if rank:
        sigma = singular_values(there, moved, there_task)[:, rank - 1]
    else:
        sigma = np.zeros(count)
    verdict, factor = _of_stretches(check, count)
    joints = {f"q_{joint.name}_{joint.unit}": q[:, j] for j, joint in enumerate(robot.variables)}
    ids = [near[k].id if k >= 0 else None for k in which.tolist()]
    names = [near[k].name if k >= 0 else None for k in which.tolist()]
    columns = {
        "row": np.arange(1, count + 1), "time_s": times,
        "pose": None if check.tool is None else check.tool.place[:count], **joints,
        "verdict": verdict, "family": ids, "family_name": names, "distance_rad": far,
        "at_least_rad": measured.at_least, "sigma": sigma, "speed_factor": None if times is None else factor,
    }  # fmt: skip
    columns = {name: values for name, values in columns.items() if values is not None}
    about = COLUMNS | {
        name: COLUMNS["joint"].format(joint.name) for name, joint in zip(joints, robot.variables, strict=True)
    }  # fmt: skip
    about["sigma"] = about["sigma"].format(rank, check.length_scale)
    return PathRows(columns, {name: about[name] for name in columns}, robot.name, check.verdict)


def _of_stretches(check: PathCheck, count: int) -> tuple[list[str], Any]:
    """Worst verdict, and least speed factor, between each row and the next."""
    worst = np.full(count, len(VERDICTS))
    factor = np.full(count, np.nan)
    for stretch in check.stretches:
        first = stretch.start.row - 1
        if stretch.end.share > 0.0 or stretch.end.row == stretch.start.row:
            last = stretch.end.row - 1
        else:
            last = stretch.end.row - 2
        if stretch.end.row >= count:
            last = count - 1  # the last row has no way on: it is the end of this stretch
        rows = slice(min(first, count - 1), last + 1)
        worst[rows] = np.minimum(worst[rows], VERDICTS.index(stretch.verdict))
        factor[rows] = np.fmin(factor[rows], stretch.speed_factor)
    return [VERDICTS[k] for k in worst.tolist()], factor


def check_format(target: str) -> None:
    """Find out before a long run whether rows can be written to a file.

    Raises:
        OptionError: the ending names no format.
        MissingExtraError: Parquet, and pyarrow is not installed.
    """
    _writer(Path(target).suffix.lower())


def rows_file(rows: PathRows, target: str) -> bytes:
    """The rows as a file, by the ending of its name.

    Raises:
        OptionError, MissingExtraError: as `check_format`.
    """
    return _writer(Path(target).suffix.lower())(rows)


def _writer(ending: str) -> Callable[[PathRows], bytes]:
    if ending == ".json":
        return lambda rows: (json.dumps(rows.to_dict(), ensure_ascii=False, allow_nan=False) + "\n").encode()
    if ending == ".csv":
        return _csv
    if ending != ".parquet":
        raise OptionError("the ending names no format", where="rows", got=ending, allowed=", ".join(FORMATS))
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise MissingExtraError("pyarrow", "parquet", "a Parquet file") from error

    def write(rows: PathRows) -> bytes:
        arrays = [pyarrow.array(plain(list(values))) for values in rows.columns.values()]
        fields = [
            pyarrow.field(name, array.type, metadata={"meaning": meaning})
            for (name, meaning), array in zip(rows.about.items(), arrays, strict=True)
        ]
        about = {"schema": SCHEMA, "robot": rows.robot, "verdict": rows.verdict, "version": VERSION}
        out = io.BytesIO()
        parquet.write_table(pyarrow.table(arrays, schema=pyarrow.schema(fields, metadata=about)), out)
        return out.getvalue()

    return write


def _csv(rows: PathRows) -> bytes:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(rows.columns)
    writer.writerows(rows.lines())
    return out.getvalue().encode()
