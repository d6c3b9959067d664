"""Two verbs for many designs: `sweep` measures variants of an arm, in chunks that a journal keeps, `compare` arms.

A variant is a row of parameter values; they come in an order in which neighbours follow each other. A grid is walked
like a field is ploughed: every step changes one parameter by one value. Samples fill the box of the ranges: Latin
hypercube and Sobol by scipy.stats.qmc, scrambled by the seed, in the order of their first parameter cut into strips.
Variants that follow each other share what is known of their families (`rankdrop.designs.measure`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from math import ceil, isfinite, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.codec import Record, plain
from rankdrop.designs.measure import measure_arm
from rankdrop.designs.outcome import Designs, SideBySide
from rankdrop.designs.ranking import structures
from rankdrop.designs.spec import Asks, Spec, question_of, read_spec, spec_of
from rankdrop.errors import MissingExtraError, OptionError, RankdropError
from rankdrop.families import Family, exact_of
from rankdrop.jobs import Engine, Job, finish
from rankdrop.robot import Array, Drawing, reach
from rankdrop.robot.drawing import NumberPlace
from rankdrop.task import Task, resolve_task
from rankdrop.verbs.conditions import conditions

SIZE = 10
"""Variants of a chunk: some seconds of work, which is what a kill costs."""
DERIVED = 4
"""Sets of families of which one variant is derived exactly, the commonest first."""
_SECONDS = 60.0  # limit on one exact derivation, of the processor's time
Report = Callable[[str, int, int], None]

FINEST = 1e-4
"""Standard error of a share that is not gone below."""

FEWEST, MOST = 2, 10

FAMILIES_AND_SHARE: Mapping[str, Any] = {"families": {"starts": 1000, "fresh": 1000}, "near": {"within": "5deg"}}
"""What arms are compared by where nothing else is asked."""


def sweep(
    spec: str | Path | Mapping[str, Any],
    *,
    out: str | Path | None = None,
    workers: int = 0,
    scheduler: str | None = None,
    precision: float | None = None,
    report: Report | None = None,
) -> Designs:
    """Measure every variant of an arm, and tell what differs between them.

    Each variant has its own searches and its own evidence; from the variant before it come the forms of conditions
    alone, which saves most of the work (`rankdrop.designs.measure`). The result follows from the specification: on
    any number of workers, on a cluster, and after an interruption of any kind it is the same.

    Args:
        spec: the TOML file, or its tables as a mapping: docs/howto/comparing-designs.md.
        out: folder in which finished chunks are kept, with a journal; the same call goes on there after an
            interruption. None: in memory.
        workers: local processes; 0 for one of every processor.
        scheduler: address of a Dask scheduler, whose workers make the chunks instead (extra `cluster`).
        precision: standard error that sampled shares (`near`, `reached`) shall have at the nominal arm; the numbers of
            configurations and poses in the specification are the fewest that are taken.
        report: report(label, done, total) of progress.

    Returns:
        Designs: the measures of every variant, sets of families, changes between neighbours, the Pareto list.

    Raises:
        OptionError, RobotError: the specification cannot be used; names file and line.
        MissingExtraError: a sample needs scipy, a cluster needs Dask.
        ResultFileError: `out` holds another sweep, or cannot be written.

    Example:
        >>> found = sweep({
        ...     "robot": "planar3r", "parameters": {"first": {"sets": "1.a", "values": [0.8, 1.2]}},
        ...     "families": {"starts": 50, "exact": False},
        ... }, workers=1)
        >>> found.values("families")
        [1, 1]
    """
    if isinstance(spec, Mapping):
        read = spec_of(spec)
    else:
        read = read_spec(spec)
    if precision is not None:
        read = refine_samples(read, precision)
    values = variants_of(read)
    tell = report or (lambda label, done, total: None)
    job = job_of(read, values)
    made = finish(
        job, Engine(workers, scheduler), folder=out,
        report=lambda done, total: tell("variants", min(done * SIZE, len(values)), len(values)),
    )  # fmt: skip
    records = sorted(
        (json.loads(line) for _, content in made for line in content.splitlines()), key=lambda record: record["number"]
    )
    asked = read.asks.families
    if asked is not None and asked["exact"]:
        exact = _exact(read, records, tell)
    else:
        exact = ()
    return Designs(read, records, exact, None if out is None else Path(out))


def refine_samples(spec: Spec, precision: float) -> Spec:
    """The specification with as many samples as a standard error of its shares takes, by a trial on the nominal arm.

    Raises:
        OptionError: no such precision, or nothing is sampled.
    """
    if not (isfinite(precision) and FINEST <= precision <= 0.5):
        raise OptionError("this is no standard error of a share", where="precision", got=precision,
                          allowed=f"{FINEST:g} … 0.5")  # fmt: skip
    sampled = {"near": ("samples", "near", 1_000_000), "slow": ("samples", "slow", 1_000_000),
               "region": ("points", "reached", 100_000)}  # fmt: skip
    given = {name: table for name in sampled if (table := getattr(spec.asks, name)) is not None}
    if not given:
        raise OptionError("nothing is sampled", where="precision", allowed="with [near], [slow] or [region]")
    trial = measure_arm(spec.drawing.nominal, spec.task, plain(Asks(**given)), None, limits=spec.limits,
                     seed=spec.seed)  # fmt: skip
    asks: dict[str, Any] = {}
    for name, table in given.items():
        key, measure, most = sampled[name]
        share, count = trial["measures"].get(measure) or 0.0, table[key]
        share += 2.0 * sqrt(max(share * (1.0 - share), 1.0 / count) / count) * (1.0 if share < 0.5 else -1.0)
        asks[name] = {**table, key: min(most, max(count, ceil(share * (1.0 - share) / precision**2)))}
    return replace(spec, asks=replace(spec.asks, **asks))


def job_of(spec: Spec, values: np.ndarray[Any, np.dtype[np.float64]]) -> Job:
    """The sweep as a job: which variants there are in which chunk, and all that decides what is found."""
    order = order_of(spec, values)
    places = []
    for parameter in spec.parameters:
        places.append([[place.part, place.key, place.sign] for place in parameter.places])
    plan = {
        "drawing": asdict(spec.drawing),
        "task": plain(spec.task),
        "limits": spec.limits,
        "seed": spec.seed,
        "places": places,
        "asks": plain(spec.asks),
        "size": SIZE,
        "variants": [[number, values[number].tolist()] for number in order],
    }
    return Job("sweep", "rankdrop.designs.measure:variants", plan, -(-len(order) // SIZE), len(order))


def _exact(spec: Spec, records: Sequence[Mapping[str, Any]], tell: Report) -> tuple[Mapping[str, Any], ...]:
    """One variant of each of the commonest sets of families, derived exactly with letters for the lengths.

    The letters stand for the lengths of other variants too: where a family is real is told for all of them.
    """
    rows: list[Mapping[str, Any]] = []
    sets = structures(records)[:DERIVED]
    for done, structure in enumerate(sets):
        tell("exact conditions", done, len(sets))
        values = np.array([records[i]["values"] for i in structure.variants])
        number = structure.variants[int(np.linalg.norm(values - np.median(values, axis=0), axis=1).argmin())]
        given: dict[NumberPlace, float] = {}
        for parameter, value in zip(spec.parameters, records[number]["values"], strict=True):
            given.update(dict.fromkeys(parameter.places, value))
        try:
            robot = spec.drawing.robot(given)
            derived = conditions(robot, spec.task, method="tree", seconds=_SECONDS, points=0, special=False)
        except RankdropError:  # an arm that cannot be derived exactly has no such entry
            continue
        if derived.in_families:
            rows.append({
                "variant": number + 1,
                "letters": {name: float(value) for name, value in derived.letters.items()},
                "families": [_exact_family(family) for family in derived.families],
                "not_real": list(map(str, derived.not_real)),
            })  # fmt: skip
    tell("exact conditions", len(sets), len(sets))
    return tuple(rows)


def _exact_family(family: Family) -> Record:
    return {"id": family.id, "name": family.name, "corank": family.corank, "conditions": list(family.texts),
            "real": exact_of(family).reality}  # fmt: skip


def variants_of(spec: Spec) -> Array:
    """(V, p) parameter values of every variant [m, rad], numbered as a user counts them.

    A grid has its first parameter slowest; a list is as it was given; samples are as they were drawn.

    Raises:
        MissingExtraError: a sample, and scipy is not installed.
    """
    if spec.kind == "list":
        return np.array(spec.listed, dtype=np.float64)
    if spec.kind == "grid":
        axes = np.meshgrid(*(parameter.values for parameter in spec.parameters), indexing="ij")
        return np.stack([axis.reshape(-1) for axis in axes], axis=1)
    try:
        from scipy.stats import qmc
    except ImportError as error:
        raise MissingExtraError("scipy", "sweep", "a Latin hypercube or Sobol sample") from error
    count = len(spec.parameters)
    if spec.kind == "latin-hypercube":
        unit = qmc.LatinHypercube(count, rng=spec.seed).random(spec.count)
    else:
        unit = qmc.Sobol(count, rng=spec.seed).random_base2(ceil(np.log2(spec.count)))
    low, high = spec.box
    return np.asarray(low + unit[: spec.count] * (high - low))


def order_of(spec: Spec, values: Array) -> list[int]:
    """The variants in the order in which they are made: each near the one before."""
    if spec.kind == "list":
        return list(range(len(values)))
    if spec.kind == "grid":
        return _order_boustrophedon([len(parameter.values) for parameter in spec.parameters])
    unit = spec.in_unit_box(values)
    strips = max(1, round(sqrt(len(values) / 4)))
    strip = np.minimum((unit[:, 0] * strips).astype(int), strips - 1)
    if unit.shape[1] > 1:
        second = unit[:, 1]
    else:
        second = unit[:, 0]
    along = np.where(strip % 2 == 0, second, 1.0 - second)
    return [int(i) for i in np.lexsort((np.arange(len(values)), along, strip))]


def _order_boustrophedon(counts: list[int]) -> list[int]:
    """Indices into the grid (first axis slowest), every second row backwards."""
    order = np.zeros(1, dtype=np.intp)
    for count in counts:
        steps = np.tile(np.arange(count), (len(order), 1))
        steps[1::2] = steps[1::2, ::-1]
        order = (count * order[:, None] + steps).reshape(-1)
    return [int(index) for index in order]


def compare(
    arms: Sequence[str],
    spec: Mapping[str, Any] = FAMILIES_AND_SHARE,
    *,
    workers: int = 0,
    scheduler: str | None = None,
    report: Report | None = None,
) -> SideBySide:
    """Measure two to ten arms for the same task.

    Args:
        arms: names in the catalogue, or files.
        spec: tables as of a sweep, without arm and variants: what is measured (families, aspects, near, region,
            paths, certified), by default the families and the share of the joint space within 5° of them; task, else
            that of the first arm; length_scale, else the largest reach; limits, seed, as_written.
        workers, scheduler: as for `sweep`.
        report: report(label, done, total).

    Raises:
        OptionError: too few arms or too many, the same one twice, or a value that cannot be used.
        RobotError, TaskError: an arm cannot be read, or the task makes no sense for it.

    Example:
        >>> found = compare(["planar3r", "planar2r"], {"near": {"within": 0.1, "samples": 500},
        ...                      "task": "planar-position"}, workers=1)
        >>> found.best("near")
        (0,)
    """
    head, asks = question_of(spec)
    drawings = _drawings(arms, as_written=head["as_written"])
    robots = [drawing.nominal for drawing in drawings]
    if head["length_scale"] is None:
        scale = max(reach(robot) for robot in robots)
    else:
        scale = head["length_scale"]
    first = resolve_task(head["task"], robots[0])
    tasks = [_task_of(drawing, first, scale) for drawing in drawings]
    entries = [{"drawing": asdict(drawing), "task": plain(task)} for drawing, task in zip(drawings, tasks, strict=True)]
    plan = {"arms": entries, "asks": plain(asks), "limits": head["limits"], "seed": head["seed"]}
    tell = report or (lambda label, done, total: None)
    job = Job("comparison", "rankdrop.designs.measure:arms", plan, len(arms), len(arms))
    made = finish(job, Engine(workers, scheduler), report=lambda done, total: tell("arms", done, total))
    records = [json.loads(content) for _, content in made]
    return SideBySide(tuple(arms), tuple(robots), tasks[0], head["limits"], head["seed"], records)


def _drawings(arms: Sequence[str], *, as_written: bool) -> list[Drawing]:
    """The descriptions of two to ten different arms."""
    if not FEWEST <= len(arms) <= MOST:
        raise OptionError("arms are compared side by side", got=f"{len(arms)}", allowed=f"{FEWEST} … {MOST} arms")
    for name in arms:
        if list(arms).count(name) > 1:
            raise OptionError("an arm is given twice", got=repr(name), mend="leave one of them out")
    return [Drawing.of(name, as_written=as_written) for name in arms]


def _task_of(drawing: Drawing, task: Task, length_scale: float) -> Task:
    try:
        return resolve_task(task, drawing.nominal, length_scale=length_scale)
    except RankdropError as error:
        raise OptionError(error.what, where=drawing.name, got=error.got, allowed=error.allowed) from error
