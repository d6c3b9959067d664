"""The outcome of one search as data: JSON (schema rankdrop/find/1), CSV, NumPy archive.

Clouds that are larger than the memory: singular configurations found in chunks, kept as partitioned Parquet.

    parts/00000.parquet …    a row for each start that ended on the set

| column | meaning |
|---|---|
| start | number of the start, from 1, as `rankdrop find --out` counts them |
| q_NAME_UNIT | value of the joint [rad, m] |
| sigma | the largest singular value that is zero, σ[rank] |
| kept | the smallest one that is not, σ[rank − 1]; null where none is kept |
| iterations | of the search |

Chunks are made by `rankdrop.jobs`: on local processes or a cluster, with a journal. The configurations are those of one
`search` with all the starts, bit for bit.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import UNSET, UnsetType

from rankdrop.codec import Record
from rankdrop.errors import MissingExtraError
from rankdrop.families.searching import MOST_STARTS, History, Outcome, Search, refine
from rankdrop.jobs import Engine, Job, finish
from rankdrop.kinematics import LARGEST_SEED, check_robot, whole_number
from rankdrop.local.block import generic_rank, sampling_box
from rankdrop.results.analysis import robot_from_dict, robot_to_dict, task_from_dict
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.units import in_units, out_of_units, task_in_units

_CLOUD = "rankdrop/cloud-rows/1"
STARTS = 100_000
"""Of a chunk: some seconds of work, some megabytes of memory."""
Report = Callable[[int, int], None]


def configurations(search: Search) -> list[Record]:
    """The starts that were run, in order."""
    return [
        {"start": int(index) + 1, "outcome": Outcome(search.outcome[index]).name.lower(),
         "iterations": search.iterations[index], "q": search.q[index], "sigma": search.sigma[index]}
        for index in _run(search)
    ]  # fmt: skip


def strata(search: Search) -> list[Record] | UnsetType:
    """How many configurations are from each stratum, and the largest σ_r/σ_1 of them; only of method reciprocal."""
    if search.stratum is None:
        return UNSET
    ratio = search.sigma[:, search.rank] / search.sigma[:, 0]
    members = [search.stratum == k for k in range(len(search.strata))]
    return [
        {"name": name, "count": int(mine.sum()), "residual": float(ratio[mine].max(initial=0.0))}
        for name, mine in zip(search.strata, members, strict=True)
    ]


def find_to_csv(search: Search) -> str:
    """One line per start: start, outcome, iterations, q1 … qn, sigma1 … ."""
    n, values = search.q.shape[1], search.sigma.shape[1]
    header = ["start", "outcome", "iterations", *_numbered_names("q", n), *_numbered_names("sigma", values)]
    lines = (
        [int(index) + 1, Outcome(search.outcome[index]).name.lower(), int(search.iterations[index]),
         *search.q[index].tolist(), *search.sigma[index].tolist()]
        for index in _run(search)
    )  # fmt: skip
    return _csv(header, lines)


def find_to_npz(search: Search) -> bytes:
    """A NumPy archive: q, sigma, outcome, iterations, and start, counted from 1."""
    index = _run(search)
    return _npz(
        q=search.q[index],
        sigma=search.sigma[index],
        outcome=search.outcome[index],
        iterations=search.iterations[index],
        start=index + 1,
    )


def history_to_csv(history: History) -> str:
    """One line per start and iteration: start, iteration, turning, sigma1 … (AM Figures 1–3)."""
    starts, steps, values = history.sigma.shape
    lines = (
        [start + 1, step, "" if np.isnan(history.turning[start, step]) else float(history.turning[start, step]),
         *history.sigma[start, step].tolist()]
        for start in range(starts) for step in range(steps) if not np.isnan(history.sigma[start, step, 0])
    )  # fmt: skip
    return _csv(["start", "iteration", "turning", *_numbered_names("sigma", values)], lines)


def history_to_npz(history: History) -> bytes:
    """A NumPy archive: sigma (N, iterations + 1, values), turning (N, iterations + 1) [rad]; NaN after the end."""
    return _npz(sigma=history.sigma, turning=history.turning)


def _run(search: Search) -> np.ndarray[Any, np.dtype[np.intp]]:
    return np.flatnonzero(search.outcome != Outcome.NOT_RUN)


def _numbered_names(letter: str, count: int) -> list[str]:
    return [f"{letter}{number}" for number in range(1, count + 1)]


def _csv(header: list[str], lines: Any) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(lines)
    return text.getvalue()


def _npz(**arrays: Any) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def store_cloud(
    robot: Robot,
    corank: int,
    folder: str | Path,
    *,
    task: str | Task | None = None,
    starts: int,
    seed: int = 0,
    limits: bool = False,
    workers: int = 0,
    scheduler: str | None = None,
    report: Report | None = None,
) -> int:
    """Find singular configurations of one corank from many starts, and keep them in a folder.

    Args:
        robot, corank, task, seed, limits: as for `search`.
        folder: where `parts/*.parquet` and the journal are; after an interruption the same call goes on there.
        starts: as many as are wanted; no more than a chunk of them is in memory at a time.
        workers, scheduler: local processes, 0 for all processors; or the address of a Dask scheduler.
        report: called with (chunks done, chunks).

    Returns:
        How many configurations there are in the folder.

    Raises:
        OptionError, RobotError, TaskError: as `search`.
        MissingExtraError: pyarrow is not installed.
        ResultFileError: the folder holds another job, or cannot be written.
    """
    check_robot(robot)
    _, parquet = _pyarrow()
    starts, seed = whole_number("starts", starts, 1, MOST_STARTS), whole_number("seed", seed, 0, LARGEST_SEED)
    resolved = resolve_task(task, robot)
    rank = generic_rank(robot, resolved)
    refine(robot, np.zeros((0, robot.n)), corank, task=resolved)  # refuses what cannot be asked for
    plan = {
        "robot": robot_to_dict(robot, resolved, rank), "length_scale": resolved.length_scale, "corank": corank,
        "starts": starts, "seed": seed, "limits": limits, "size": STARTS,
    }  # fmt: skip
    job = Job("cloud", "rankdrop.results.findings:part", plan, -(-starts // STARTS), starts, ".parquet")
    rows = 0
    for _, content in finish(job, Engine(workers, scheduler), folder=folder, report=report):
        rows += parquet.read_metadata(io.BytesIO(content)).num_rows
    return rows


def part(plan: dict[str, Any], chunk: int) -> bytes:
    """One partition: where the starts of one chunk ended, where they converged."""
    robot = robot_from_dict(plan["robot"])
    task = task_from_dict(plan["robot"], plan["length_scale"])
    own, inner = in_units(robot), task_in_units(task, robot)
    first = chunk * plan["size"]
    count = min(plan["size"], plan["starts"] - first)
    q0 = _starts(own, inner, first, count, plan["seed"], plan["limits"])
    solved = refine(
        own, q0, plan["corank"], task=inner, seed=plan["seed"], limits=plan["limits"], first=first, threads=1
    )
    there = np.flatnonzero(solved.outcome == Outcome.CONVERGED)
    q, sigma = out_of_units(robot, solved.q[there]), solved.sigma[there]
    if solved.rank:
        kept = sigma[:, solved.rank - 1]
    else:
        kept = np.full(len(there), np.nan)
    return _table(robot, plan["corank"], first + there + 1, q, sigma[:, solved.rank], kept, solved.iterations[there])


def _starts(robot: Robot, task: Task, first: int, count: int, seed: int, limits: bool) -> Array:
    """(count, n) starts from number `first` on, of those that `search` draws: the generator is moved on to them."""
    low, high = sampling_box(robot, task, limits=limits)
    bits = np.random.PCG64(seed)
    bits.advance(first * robot.n)  # a double takes one step
    return np.random.Generator(bits).uniform(low, high, (count, robot.n))


def _pyarrow() -> tuple[Any, Any]:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise MissingExtraError("pyarrow", "parquet", "a stored cloud") from error
    return pyarrow, parquet


def _table(robot: Robot, corank: int, start: Any, q: Array, sigma: Array, kept: Array, iterations: Any) -> bytes:
    arrow, parquet = _pyarrow()
    columns = [("start", start.astype(np.int64), "number of the start, from 1")]
    columns += [(f"q_{joint.name}_{joint.unit}", q[:, j], f"value of {joint.name}")
                for j, joint in enumerate(robot.variables)]  # fmt: skip
    columns += [
        ("sigma", sigma, "largest singular value that is zero"), ("kept", kept, "smallest one that is not"),
        ("iterations", iterations.astype(np.int32), "of the search"),
    ]  # fmt: skip
    arrays = [arrow.array(values, from_pandas=True) for _, values, _ in columns]
    fields = [arrow.field(name, array.type, metadata={"meaning": words})
              for (name, _, words), array in zip(columns, arrays, strict=True)]  # fmt: skip
    about = {"schema": _CLOUD, "robot": robot.name, "corank": str(corank)}
    out = io.BytesIO()
    parquet.write_table(
        arrow.table(arrays, schema=arrow.schema(fields, metadata=about)), out, compression="zstd", use_dictionary=False,
        column_encoding={field.name: "BYTE_STREAM_SPLIT" for field in fields if str(field.type) == "double"},
    )  # fmt: skip
    return out.getvalue()
