"""Many paths of one arm: a job in chunks, one for each file (`rankdrop.jobs`), shown as a table, worst first."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import lru_cache
from hashlib import file_digest, sha256
from math import inf
from pathlib import Path

from rankdrop.codec import Record, plain, record_of
from rankdrop.errors import RankdropError, ResultFileError
from rankdrop.jobs import Engine, Job, finish
from rankdrop.local.block import generic_rank
from rankdrop.path.check.path_file import PathQuestion
from rankdrop.path.check.program import ProgramCheck, check_any_file
from rankdrop.path.check.record import CROSSING, TOUCHING, VERDICTS, PathCheck
from rankdrop.questions import PathOptions
from rankdrop.results.analysis import Analysis, robot_from_dict, robot_to_dict, task_from_dict
from rankdrop.robot.model import Robot
from rankdrop.task import Task, resolve_task
from rankdrop.text.stretches import stretch_place

_BAD = "bad input"
_HERE = 1 << 20  # bytes of files below which processes take longer to begin than the work takes


def check_files(
    robot: Robot,
    files: Sequence[str | Path],
    question: PathQuestion,
    *,
    out: str | Path | None = None,
    workers: int = 0,
    scheduler: str | None = None,
    report: Callable[[str, int, int], None] | None = None,
) -> list[Record]:
    """Every file checked, worst first, each for itself, so that one that cannot be read does not stop the others.

    Args:
        robot: the arm.
        files: trajectories, or poses of the tip (`check_any_file`).
        question: what is asked of each.
        out: folder in which what is finished is kept, with a journal; the same call goes on there after an
            interruption of any kind, and ends with the same result. None: in memory.
        workers: local processes; 0 for one of every processor. The result does not depend on it.
        scheduler: address of a Dask scheduler, whose workers see the files under the same names (extra `cluster`).
        report: report(label, done, total) of progress.

    Returns:
        One record for each file, fewer where Ctrl-C ended it: `file`, as it was named; `verdict`, "bad input" where it
        could not be read; `sentence`, then the error; `rows`, `free_share`, `met`, `nearest_rad`, None where there is
        no path or nothing is known; `name` of the family met or nearest; `said`, what a reader should know.

    Raises:
        OptionError: workers outside what is allowed, an analysis of another arm.
        MissingExtraError: a scheduler, and Dask's distributed is not installed.
        ResultFileError: `out` holds another job (other files, or their bytes changed), or cannot be written.
    """
    there, names = resolve_task(question.task, robot), [Path(file) for file in files]
    plan = {
        "robot": robot_to_dict(robot, there, generic_rank(robot, there)),
        "length_scale": there.length_scale,
        "analysis": None if question.analysis is None else question.analysis.to_dict(),
        "options": plain(question.options),
        "reading": _reading(question),
        "files": [[str(file), str(file.absolute()), _digest(file)] for file in names],
    }
    job = Job("paths", "rankdrop.path.check.many:check_chunk", plan, len(names), len(names))
    quick = not workers and scheduler is None and sum(map(_size, names)) <= _HERE
    show = report or (lambda label, done, total: None)
    done: list[Record] = []

    def each(chunk: int, content: bytes) -> None:
        done.append({"file": str(names[chunk]), **json.loads(content)})

    try:
        for _ in finish(job, Engine(workers, scheduler, quick), folder=out, each=each,
                        report=lambda count, total: show("paths checked", count, total)):  # fmt: skip
            pass
    except KeyboardInterrupt:
        pass  # the table says how many of the files there are in it
    order = (_BAD, *VERDICTS)

    def badness(record: Record) -> tuple[int, float, str]:
        nearest = record["nearest_rad"]
        return order.index(record["verdict"]), inf if nearest is None else nearest, record["file"]

    return sorted(done, key=badness)


def _reading(question: PathQuestion) -> Record:
    """How files are read; what older jobs did not ask is left out where it is not asked."""
    reading = {"deg": question.deg, "topic": question.topic, "start": plain(question.start)}
    if question.at_tool_point:
        reading["at_tool_point"] = True
    return reading


def check_chunk(plan: Record, chunk: int) -> bytes:
    """One file, as workers check it.

    Raises:
        ResultFileError: it is not what it was when the job began.
    """
    name, place, digest = plan["files"][chunk]
    if _digest(Path(place)) != digest:
        raise ResultFileError("the file is not what it was when the job began", where=name,
                              mend="begin again; workers of a cluster see files under the same names")  # fmt: skip
    robot, task, analysis = _decode_question(json.dumps([plan[key] for key in ("robot", "length_scale", "analysis")]))
    said: list[str] = []
    try:
        start = plan["reading"]["start"]
        read = plan["reading"] | {"start": None if start is None else tuple(start)}
        question = PathQuestion(task, analysis, PathOptions(**plan["options"]), **read)
        check = check_any_file(robot, Path(place), question, say=said.append)
    except RankdropError as error:
        sentence = error.on_command_line().replace(place, name)
        record = {"verdict": _BAD, "sentence": sentence, "rows": None, "free_share": None, "met": None,
                  "nearest_rad": None, "name": "", "said": said}  # fmt: skip
    else:
        if not check.complete:  # Ctrl-C: no result of this file
            raise KeyboardInterrupt
        record = _record(check) | {"said": said}
    return json.dumps(record, ensure_ascii=False, allow_nan=False).encode()


@lru_cache(1)
def _decode_question(text: str) -> tuple[Robot, Task, Analysis | None]:
    record, length_scale, analysis = json.loads(text)
    return robot_from_dict(record), task_from_dict(record, length_scale), (
        None if analysis is None else Analysis.from_dict(analysis)
    )


def _record(check: PathCheck | ProgramCheck) -> Record:
    near = min((stretch.closest.distance for stretch in check.stretches), default=inf)
    met = sum(stretch.verdict in (CROSSING, TOUCHING) for stretch in check.stretches)
    return {
        "verdict": check.verdict, "sentence": check.sentence, "rows": check.rows, "free_share": check.free_share,
        "met": met, "nearest_rad": plain(near), "name": _name(check),
    }  # fmt: skip


def _name(check: PathCheck | ProgramCheck) -> str:
    """The part of the arm that is special at the singularity reached, or nearest, or the name of its family."""
    if not check.stretches:
        return ""
    worst = check.stretches[0]
    for path in check.checks if isinstance(check, ProgramCheck) else (check,):
        if any(stretch is worst for stretch in path.stretches):
            return stretch_place(path, worst)
    return worst.name


def _parts(file: Path) -> list[Path]:
    """The file itself; of the folder of a recording those in it."""
    inside = file.iterdir() if file.is_dir() else [file]
    return sorted(part for part in inside if part.is_file())


def _digest(file: Path) -> str:
    """SHA-256 of what a file holds; "" where it cannot be read, which is an error when it is checked."""
    whole = sha256()
    try:
        for part in _parts(file):
            with part.open("rb") as stream:
                whole.update(file_digest(stream, "sha256").digest())
    except OSError:
        return ""
    return whole.hexdigest()


def _size(file: Path) -> int:
    try:
        return sum(part.stat().st_size for part in _parts(file))
    except OSError:
        return 0


def paths_to_dict(robot: Robot, many: Sequence[Record]) -> Record:
    """For a file: each path in short."""
    return record_of("paths", (robot.name, many))
