"""Arms side by side: two to ten, each measured for the same task, with the same σ."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

from rankdrop.codec import Result, plain
from rankdrop.designs.outcome import APART, measure_text
from rankdrop.designs.ranking import rank
from rankdrop.designs.spec import GOALS, Asks
from rankdrop.errors import OptionError, RankdropError
from rankdrop.jobs import Engine, Job, finish
from rankdrop.robot.drawing import Drawing
from rankdrop.robot.numbers import reach
from rankdrop.schema.design import MEANINGS, UNITS
from rankdrop.sections import Section
from rankdrop.task import resolve_task

FEWEST, MOST = 2, 10
_BEST = {
    "near": "smallest share of the joint space near singularities",
    "sigma": "largest σ over the region",
    "reached": "most poses of the region reached",
    "path_sigma": "largest σ on the paths",
    "path_distance": "farthest from singularities on the paths",
    "paths_free": "most paths proven free",
    "free": "largest share proven free",
}
"""What the best arm by a measure has; numbers of families are told and not judged."""
Report = Callable[[str, int, int], None]


@dataclass(frozen=True, eq=False)
class SideBySide(Result):
    """Arms measured for the same task.

    Attributes:
        names: of the arms, as they were given.
        about: one line on each.
        joints: how many each has.
        reaches: of each [m].
        task: name of the task.
        length_scale: of σ, the same for all [m].
        limits: inside the joint limits.
        seed: of every random choice.
        records: of the arms, in their order; as those of a sweep.
    """

    names: tuple[str, ...]
    about: tuple[str, ...]
    joints: tuple[int, ...]
    reaches: tuple[float, ...]
    task: str
    length_scale: float
    limits: bool
    seed: int
    records: Sequence[Mapping[str, Any]]
    FILE: ClassVar[str] = "side-by-side"

    @property
    def measures(self) -> list[str]:
        """Names of the measures, in their order."""
        names = {name for record in self.records for name in record["measures"]}
        return [name for name in UNITS if name in names]

    @property
    def holds(self) -> bool:
        """Whether every arm was measured and its families, where asked for, are verified."""
        return all(one["error"] is None and one.get("verdict", "verified") == "verified" for one in self.records)

    def best(self, measure: str) -> tuple[int, ...]:
        """The arms, from 0, that are best by one measure; those within the error of the best are too."""
        records = [{**one, "error": None} for one in self.records]
        return tuple(rank(records, {measure: GOALS[measure]}).best)

    @property
    def sentence(self) -> str:
        """What was found, in one sentence."""
        doubt = [name for name, one in zip(self.names, self.records, strict=True)
                 if one["error"] is not None or one.get("verdict", "verified") != "verified"]  # fmt: skip
        if doubt:
            return f"Incomplete: not all holds of {', '.join(doubt)}."
        told = []
        for name in self.measures:
            best = self.best(name)
            if name != "families" and 0 < len(best) < len(self.names):
                told.append(f"{_BEST[name]}: {', '.join(self.names[i] for i in best)}")
        count = f"{len(self.names)} arms, task {self.task}"
        return f"{count}; {'; '.join(told)}." if told else f"{count}: no measure tells them apart."

    def sections(self) -> Iterator[Section]:
        """As sections of text: a column for each arm."""
        yield Section("", lines=(self.sentence,))
        rows = [("joints", *map(str, self.joints)), ("reach", *(f"{far:.4g} m" for far in self.reaches))]
        rows += [
            (name, *(measure_text(name, one["measures"].get(name)) + ("  ←" if i in self._ranked_best(name) else "")
                     for i, one in enumerate(self.records)))
            for name in self.measures
        ]  # fmt: skip
        where = "inside the joint limits" if self.limits else "the whole joint space"
        yield Section("Side by side", f"task {self.task}; {where}; seed {self.seed}", columns=("", *self.names),
                      rows=tuple(rows), texts=(0,), notes=(
                          f"σ has translation divided by {self.length_scale:.4g} m for every arm; ← best",
                          *(f"{name}: {MEANINGS[name]}{self._doubt(name)}" for name in self.measures)))  # fmt: skip
        for name, about, one in zip(self.names, self.about, self.records, strict=True):
            yield self._arm(name, about, one)
        yield Section("", lines=(self.sentence,))

    def _doubt(self, measure: str) -> str:
        most = max((float(one["near"]["any"]["error"]) for one in self.records
                    if measure == "near" and one["measures"].get(measure) is not None), default=0.0)  # fmt: skip
        larger = any(one.get("near", {}).get("any", {}).get("bound") for one in self.records)
        more = ", and may be larger where joints are coupled" if larger else ""
        return f", by samples: ± {APART * 100 * most:.2g} %{more}" if most else ""

    def _ranked_best(self, measure: str) -> tuple[int, ...]:
        best = self.best(measure)
        return best if measure != "families" and len(best) < len(self.names) else ()

    def _arm(self, name: str, about: str, one: Mapping[str, Any]) -> Section:
        shares = {share["id"]: share for share in one.get("near", {}).get("families", [])}
        rows = tuple(
            (str(family["corank"]), family["name"], str(family["dimension"]),
             measure_text("near", shares[family["id"]]["share"]) if family["id"] in shares else "–")
            for family in one.get("families", [])
        )  # fmt: skip
        lines = [one["error"]] if one["error"] else []
        if "sentence" in one:
            lines.append(one["sentence"])
        if one.get("region") and one["region"]["sigma"] is not None:
            at = ", ".join(f"{x:.3g}" for x in one["region"]["at"])
            lines.append(f"σ over the region is smallest at ({at}) m: {one['region']['sigma']:.4g}".replace("-", "−"))
        for path in one.get("paths", []):
            told = f": {path['why']}" if path["sigma"] is None else f", smallest σ {path['sigma']:.4g}"
            lines.append(f"{path['name']}: {path['verdict']}{told}")
        columns = ("corank", "family", "dim", "near") if rows else ()
        return Section(name, about, lines=tuple(lines), columns=columns, rows=rows, texts=(1,))


def side_by_side(
    arms: Sequence[str],
    asks: Asks,
    *,
    task: str | None = None,
    length_scale: float | None = None,
    limits: bool = False,
    seed: int = 0,
    as_written: bool = False,
    workers: int = 0,
    scheduler: str | None = None,
    report: Report | None = None,
) -> SideBySide:
    """Measure two to ten arms for the same task.

    Args:
        arms: names in the catalogue, or files.
        asks: what is asked of each, as of the variants of a sweep.
        task: name or rows; None: the task that the first arm is made for.
        length_scale: translation rows are divided by it for every arm [m]; None: the largest reach among them.
        limits: inside the joint limits.
        seed: of every random choice.
        as_written: take the numbers of files literally.
        workers, scheduler: as for `sweep`.
        report: report(label, done, total).

    Raises:
        OptionError: too few arms or too many, the same one twice.
        RobotError, TaskError: an arm cannot be read, or the task makes no sense for it.

    Example:
        >>> found = side_by_side(["planar3r", "planar2r"], Asks(near={"within": 0.1, "samples": 500}),
        ...                      task="planar-position", workers=1)
        >>> found.best("near")
        (0,)
    """
    if not FEWEST <= len(arms) <= MOST:
        raise OptionError("arms are compared side by side", got=f"{len(arms)}", allowed=f"{FEWEST} … {MOST} arms")
    drawings = [Drawing.of(name, as_written=as_written) for name in arms]
    for name in arms:
        if list(arms).count(name) > 1:
            raise OptionError("an arm is there twice", got=repr(name), mend="leave one of them out")
    robots = [one.nominal for one in drawings]
    longest = max(reach(robot) for robot in robots)
    first = resolve_task(task, robots[0])
    entries = []
    for drawing, robot in zip(drawings, robots, strict=True):
        try:
            resolved = resolve_task(first, robot, length_scale=longest if length_scale is None else length_scale)
        except RankdropError as error:
            raise OptionError(error.what, where=drawing.name, got=error.got, allowed=error.allowed) from error
        entries.append({"drawing": asdict(drawing), "task": plain(resolved)})
    plan = {"arms": entries, "asks": plain(asks), "limits": limits, "seed": seed}
    tell = report or (lambda label, done, total: None)
    job = Job("comparison", "rankdrop.designs.measure:arms", plan, len(arms), len(arms))
    made = finish(job, Engine(workers, scheduler), report=lambda done, total: tell("arms", done, total))
    records = [json.loads(content) for _, content in made]
    return SideBySide(
        tuple(arms), tuple(robot.about for robot in robots), tuple(robot.n for robot in robots),
        tuple(float(reach(robot)) for robot in robots), first.name, float(entries[0]["task"]["length_scale"]), limits,
        seed, records,
    )  # fmt: skip
