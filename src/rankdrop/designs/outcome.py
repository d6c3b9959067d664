"""What a sweep found: every variant with its measures, what differs between neighbours, the Pareto-optimal variants.

Of a Pareto-optimal variant, every better value of one measure costs something else. As Parquet a sweep is two tables,
in partitions that pandas, DuckDB and others read as one, each written whole or not at all:

    variants/part-00000.parquet    a row for each variant: number, its parameters, its measures
    families/part-00000.parquet    a row for each family of each variant

Every column has its meaning and its unit in the metadata of its field.
"""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import degrees
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from rankdrop.codec import Result
from rankdrop.designs.ranking import Change, Ranking, Structure, changes, neighbours, rank, structures
from rankdrop.designs.spec import GOALS, UNRANKED, Parameter, Spec
from rankdrop.disk import replace_file
from rankdrop.distance.share import NearShare
from rankdrop.errors import MissingExtraError, OptionError, ResultFileError
from rankdrop.options import advised
from rankdrop.results.aspect_summary import AspectSummary
from rankdrop.robot import Robot, reach
from rankdrop.schema.design import MEANINGS as MEANINGS
from rankdrop.schema.design import UNITS as UNITS
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.text.aspects import aspects_and_verdict_cell, aspects_line
from rankdrop.text.brief import NO_RATE_LIMITS, compared_arms, compared_sentence, sigma_note, slow_note, slow_poses_note
from rankdrop.text.words import sweep_next

SHOWN = 20
"""Variants of the Pareto list, and structures and kinds of change, that are told."""
_BETWEEN = "a change lies somewhere between two variants that were searched; one that comes and goes is not seen"
APART = 2.0  # standard errors by which shares of samples have to differ
_ALMOST_ALL = "for almost all lengths; where two lengths are equal or one is zero more may hold"


@dataclass(frozen=True, eq=False)
class Designs(Result):
    """A finished sweep.

    Attributes:
        spec: the arm, its parameters, the task, what is measured.
        records: of every variant, by its number; docs/howto/comparing-designs.md says what is in them.
        exact: one variant of each of the commonest sets of families, derived exactly with letters for the lengths:
            its families, and for which lengths they are real; empty where not asked for or not derived.
        folder: where parts and tables are kept; None: nowhere.
    """

    spec: Spec
    records: Sequence[Mapping[str, Any]]
    exact: tuple[Mapping[str, Any], ...] = ()
    folder: Path | None = None
    FILE: ClassVar[str] = "sweep"

    @property
    def robot(self) -> str:
        """Name of the arm that was varied."""
        return self.spec.drawing.nominal.name

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What was varied, in order."""
        return self.spec.parameters

    @property
    def measures(self) -> list[str]:
        """Names of the measures, in their order."""
        return measures_of(self.records)

    @cached_property
    def failed(self) -> tuple[int, ...]:
        """Numbers of the variants with an error, from 0."""
        return tuple(int(one["number"]) for one in self.records if one["error"] is not None)

    @cached_property
    def unverified(self) -> tuple[int, ...]:
        """Numbers of the variants whose families were asked for and do not hold, from 0."""
        return tuple(int(one["number"]) for one in self.records if one.get("verdict", "verified") != "verified")

    @property
    def holds(self) -> bool:
        """Whether every variant was measured and its families are verified."""
        return not self.failed and not self.unverified

    @cached_property
    def structures(self) -> list[Structure]:
        """Variants by their set of families."""
        return structures(self.records)

    @cached_property
    def changes(self) -> list[Change]:
        """What differs between neighbours."""
        return changes(self.records, [one.name for one in self.parameters], neighbours(self.spec, self.records))

    @cached_property
    def ranking(self) -> Ranking:
        """The variants that no other one dominates beyond the error of the samples."""
        return rank(self.records, self.spec.goals)

    @property
    def pareto(self) -> list[int]:
        """Their numbers, from 0."""
        return self.ranking.best

    def values(self, measure: str) -> list[float | None]:
        """One measure of every variant.

        Raises:
            OptionError: there is no such measure.
        """
        if measure not in self.measures:
            raise OptionError("there is no such measure", got=measure, allowed=", ".join(self.measures))
        return [one["measures"].get(measure) for one in self.records]

    @property
    def sentence(self) -> str:
        """What was found, in one sentence."""
        count = f"{len(self.records):,} variants of {self.robot}"
        if self.failed:
            return f"Incomplete: {len(self.failed):,} of {count} could not be measured as a whole."
        if self.unverified:
            return f"Incomplete: the families of {len(self.unverified):,} of {count} do not hold."
        if self.pareto or self.spec.goals:
            parts = [self._best()]
        else:
            parts = [f"{count} were measured"]
        if self.structures:
            sets = len(self.structures)
            parts.append("all have the same families" if sets == 1 else f"they have {sets} different sets of families")
            parts.append("the families of each were verified by sampling")
        return f"{'; '.join(parts)}."

    def _best(self) -> str:
        best, variants = len(self.pareto), len(self.records)
        count = f"{variants:,} variants of {self.robot}"
        if not best:
            missing = [name for name in self.spec.goals if all(value is None for value in self.values(name))]
            return f"None of {count} is ranked: none has {' and '.join(missing) or 'every measure'}"
        if best == 1:
            return f"Variant {self.pareto[0] + 1} is the best of {count}"
        if self.ranking.differ:
            others = variants - best
            if others:
                worse = f", {others:,} {'is' if others == 1 else 'are'} worse by more than the error"
            else:
                worse = ""
            return f"{best:,} of {count} are Pareto-optimal{worse}"
        return f"{best:,} of {count} cannot be distinguished by their measures"

    @property
    def summary(self) -> tuple[str, ...]:
        """The lines printed first: the result, the best variant or one of several, ranges of measures, what is next."""
        titles = [*(one.name for one in self.parameters), *self.measures]
        best = [self.row(self.records[number]) for number in self._in_order(self.pareto)[:1]]
        if len(self.pareto) == 1:
            head = "Best"
        else:
            head = f"One of {len(self.pareto)}"
        lines = [self.sentence]
        for row in best:
            cells = [f"{title} {cell}" for title, cell in zip(titles, row, strict=True)]
            lines.append(f"{head}: {', '.join(cells)}.")
        ranges = []
        for name in self.measures:
            values = [x for x in self.values(name) if x is not None]
            if values:
                ranges.append(f"{name} {measure_text(name, min(values))} … {measure_text(name, max(values))}")
        if ranges:
            lines.append(f"Range: {', '.join(ranges)}.")
        return (*lines, sweep_next())

    def sections(self, *, every: bool = False) -> Iterator[Section]:
        """As sections of text; `every`: all variants, not only the Pareto-optimal ones."""
        yield Section("", lines=self.summary)
        ranges = tuple(
            (one.name, ", ".join(map(str, one.places)), shown(one.lower, one), shown(one.upper, one))
            for one in self.parameters
        )
        if self.spec.limits:
            where = "inside the joint limits"
        else:
            where = "the whole joint space"
        spec = self.spec
        about = f"{len(self.records):,} variants ({spec.kind}); task {spec.task.name}; {where}; seed {spec.seed}"
        after = (f"σ has translation divided by {self.spec.task.length_scale:.4g} m, for every variant",)
        columns = ("parameter", "sets", "from", "to")
        yield Section(f"{self.robot}: sweep", about, columns=columns, rows=ranges, texts=(0, 1), after=after)
        yield from self._ranking(every)
        yield from self._families()
        if self.failed or self.unverified:
            yield self._doubt()
        yield Section("", lines=(self.sentence,))

    def _ranking(self, every: bool) -> Iterator[Section]:
        if every or not self.pareto:
            title, chosen = "Variants", self._in_order(range(len(self.records)))
        else:
            title, chosen = "Pareto-optimal variants", self._in_order(self.pareto)
        names = self.measures
        if not chosen or not names:
            return
        most = len(chosen) if every else SHOWN
        rows = tuple((str(i + 1), *self.row(self.records[i])) for i in chosen[:most])
        summary = f"{len(chosen):,} of {len(self.records):,}{self._wants}"
        more = f"and {len(chosen) - most:,} more: {advised('all', python='sections(every=True)')}"
        after = (more,) if len(chosen) > most else ()
        notes = tuple(f"{name}: {MEANINGS[name]}{error_text(self.records, name)}" for name in names)
        yield Section(title, summary,
                      columns=("variant", *(one.name for one in self.parameters), *names), rows=rows,
                      texts=(), after=after, notes=notes)  # fmt: skip

    @property
    def _wants(self) -> str:
        """What counts as better, "; better: least reach"; "" without goals."""
        wants = ", ".join(f"{want} {name}" for name, want in self.spec.goals.items())
        return f"; better: {wants}" if wants else ""

    def row(self, record: Mapping[str, Any]) -> tuple[str, ...]:
        """Parameters and measures of a variant, for people."""
        values = [shown(x, one) for x, one in zip(record["values"], self.parameters, strict=True)]
        return (*values, *(measure_cell(name, record) for name in self.measures))

    def _in_order(self, numbers: Iterable[int]) -> list[int]:
        """Variants by the first goal, best first; variants without it last."""
        first, want = next(iter(self.spec.goals.items()), ("", "less"))
        sign = 1.0 if want == "less" else -1.0

        def cost(number: int) -> float:
            value = self.records[number]["measures"].get(first)
            return np.inf if value is None else sign * value

        return sorted(numbers, key=cost)

    def _families(self) -> Iterator[Section]:
        found = self.structures
        if not found:
            return
        common = set(found[0].keys)
        rows = []
        for number, one in enumerate(found[:SHOWN], 1):
            gone, new = sorted(common - set(one.keys)), sorted(set(one.keys) - common)
            told = "; ".join([*(f"+ {key}" for key in new), *(f"− {key}" for key in gone)])
            where = ", ".join(
                f"{p.name} {shown(low, p)} … {shown(high, p)}"
                for p, (low, high) in zip(self.parameters, one.ranges, strict=True)
            )
            rows.append((str(number), f"{len(one.variants):,}", told if number > 1 else "\n".join(one.keys), where))
        more = (f"and {len(found) - SHOWN} more, in the JSON",) if len(found) > SHOWN else ()
        told = "the commonest first; the others by what they have more (+) and less (−)"
        columns = ("", "variants", "families", "within")
        yield Section("Sets of families", told, columns=columns, rows=tuple(rows), texts=(2, 3), after=more)
        if self.changes:
            yield self._changed()
        if self.exact:
            yield self._exact()

    def _changed(self) -> Section:
        counts = Counter(one.what for one in self.changes)
        rows = []
        for what, count in counts.most_common(SHOWN):
            kind, before, after = what
            places = [one for one in self.changes if one.what == what]
            rows.append((kind, " and ".join(before or after), " and ".join(after) if before else "", str(count),
                         self._between(places)))  # fmt: skip
        more = (f"and {len(counts) - SHOWN} more kinds, in the JSON",) if len(counts) > SHOWN else ()
        columns = ("", "family", "into", "pairs", "between")
        return Section("Between neighbours", "differences, and where they are", columns=columns, rows=tuple(rows),
                       texts=(0, 1, 2, 4), after=more, notes=(_BETWEEN,))  # fmt: skip

    def _between(self, places: Sequence[Change]) -> str:
        told = []
        for one in self.parameters:
            mine = [place for place in places if place.parameter == one.name]
            brackets = sorted({(min(p.low, p.high), max(p.low, p.high)) for p in mine})
            if brackets:
                words = ", ".join(f"{shown(low, one)} and {shown(high, one)}" for low, high in brackets[:3])
                told.append(f"{one.name}: {words}" + (" …" if len(brackets) > 3 else ""))
        if not told and places:
            told = [f"variants {places[0].first + 1} and {places[0].second + 1}"]
        return "; ".join(told)

    def _exact(self) -> Section:
        rows = []
        for one in self.exact:
            letters = ", ".join(f"{name} = {value:.4g}" for name, value in one["letters"].items()).replace("-", "−")
            told = [("; ".join(family["conditions"]), family["real"]) for family in one["families"] if family["real"]]
            told += [(text, "no") for text in one["not_real"]]
            count = len(one["families"])
            told = told or [(f"{count} famil{'y' if count == 1 else 'ies'}", "for all lengths of these signs")]
            rows += [(str(one["variant"]) if k == 0 else "", what, real, letters if k == 0 else "")
                     for k, (what, real) in enumerate(told)]  # fmt: skip
        about = "a variant of each of the commonest sets, with letters for the lengths; families not always real"
        columns, texts = ("variant", "conditions", "real", "its lengths [m]"), (0, 1, 2, 3)
        return Section("Derived exactly", about, columns=columns, rows=tuple(rows), texts=texts, notes=(_ALMOST_ALL,))

    def _doubt(self) -> Section:
        lines = [f"variant {i + 1}: {self.records[i]['error']}" for i in self.failed[:SHOWN]]
        lines += [f"variant {i + 1}: {self.records[i]['sentence']}" for i in self.unverified[:SHOWN]]
        return Section("What does not hold", lines=tuple(lines))


def measures_of(records: Sequence[Mapping[str, Any]]) -> list[str]:
    """Names of the measures of records, in their order."""
    names = {name for record in records for name in record["measures"]}
    return [name for name in UNITS if name in names]


def in_doubt(record: Mapping[str, Any]) -> bool:
    """Whether an arm could not be measured as a whole, or its families are not verified."""
    return record["error"] is not None or record.get("verdict", "verified") != "verified"


def error_text(records: Sequence[Mapping[str, Any]], measure: str) -> str:
    """How far a share may be off, by its samples; "" for a measure without error."""
    regions = [one["region"] for one in records if (one.get("region") or {}).get("sigma") is not None]
    if measure == "slow_poses":
        return _slow_poses_error(regions)
    if measure == "sigma":
        wide_bounds = sum(not one.get("narrow") for one in regions)
        return sigma_note(len(regions), wide_bounds, sum(not one.get("covered") for one in regions))
    if measure == "slow":
        return _slow_error(records)
    if measure == "near":
        return _near_error([one["near"]["any"] for one in records if one.get("near")])
    return ""


def _near_error(shares: Sequence[Mapping[str, Any]]) -> str:
    """The largest error of shares near families, and that it may be larger; "" where no share has one."""
    most = max((float(one["error"]) for one in shares), default=0.0)
    if not most:
        return ""
    larger = " or more" if any(one["bound"] for one in shares) else ""
    return f", by samples: ± {APART * 100 * most:.2g} %{larger}"


def _slow_error(records: Sequence[Mapping[str, Any]]) -> str:
    """The speeds below which the tool is slow, the widest interval of the shares, and why some have none."""
    if any("slow" in one and one["slow"] is None for one in records):
        missing = NO_RATE_LIMITS
    else:
        missing = ""
    slow = [one["slow"] for one in records if one.get("slow")]
    if not slow:
        return missing
    ends = [_slow_interval(one) for one in slow]
    wide = max(high - low for low, high in ends)
    bound = any(one["bound"] for one in slow)
    return slow_note(slow[0].get("tool_speed"), slow[0].get("turn_speed"), wide, bound=bound) + missing


def _slow_interval(slow: Mapping[str, Any]) -> tuple[float, float]:
    """95 % interval of a share by its samples, which files of earlier versions do not hold."""
    share = NearShare("", round(slow["share"] * slow["samples"]), slow["samples"], slow["bound"])
    return share.interval


def _slow_poses_error(regions: Sequence[Mapping[str, Any]]) -> str:
    slow = [one["slow"] for one in regions if one.get("slow")]
    if not slow:
        return ""
    wide = max(one["interval"][1] - one["interval"][0] for one in slow)
    return slow_poses_note(slow[0]["slower_than"], wide)


def measure_cell(name: str, record: Mapping[str, Any]) -> str:
    """A measure of a variant for people; some with their bounds: "0.305 (0.302 … 0.308)", "2 … 8"."""
    text = measure_text(name, record["measures"].get(name))
    if name in _CELLS:
        return _CELLS[name](text, record)
    return text


def _aspects_cell(text: str, record: Mapping[str, Any]) -> str:
    """The number of aspects, or its bounds; whether the arm is cuspidal or that is not decided."""
    if record.get("aspects"):
        return aspects_and_verdict_cell(AspectSummary(**record["aspects"]))
    return text


def _slow_cell(text: str, record: Mapping[str, Any]) -> str:
    """The share of slow configurations with its interval."""
    if not record.get("slow"):
        return text
    return _with_interval(text, _slow_interval(record["slow"]))


def _with_interval(text: str, interval: Sequence[float]) -> str:
    low, high = (100 * end for end in interval)
    return f"{text} ({low:.3g} … {high:.3g} %)"


def _slow_poses_cell(text: str, record: Mapping[str, Any]) -> str:
    """The share of slow poses with its interval."""
    region = record.get("region") or {}
    if not region.get("slow"):
        return text
    return _with_interval(text, region["slow"]["interval"])


def _sigma_cell(text: str, record: Mapping[str, Any]) -> str:
    """σ over a region with its proven bounds."""
    region = record.get("region") or {}
    if record["measures"].get("sigma") is None or region.get("sigma_lower") is None:
        return text
    upper = region.get("sigma_upper")
    return f"{text} ({region['sigma_lower']:.4g} … {'?' if upper is None else format(upper, '.4g')})"


_CELLS: dict[str, Callable[[str, Mapping[str, Any]], str]] = {
    "aspects": _aspects_cell, "slow": _slow_cell, "slow_poses": _slow_poses_cell, "sigma": _sigma_cell,
}  # fmt: skip
"""Measures with bounds -> their cell, from the measure as text and the record."""


def shown(value: float, parameter: Parameter) -> str:
    """A value of a parameter for people: "0.425 m", "30°"."""
    if parameter.measure == "angle":
        return f"{degrees(value):.6g}°".replace("-", "−")
    return f"{value:.6g} m".replace("-", "−")


def measure_text(name: str, value: float | None) -> str:
    """A measure for people; – where there is none."""
    if value is None:
        return "–"
    if UNITS[name] == "share":
        return f"{100 * value:.3g} %"
    if UNITS[name] == "":
        return f"{int(value)}"
    return f"{value:.4g}{' rad' if UNITS[name] == 'rad' else ''}"


ROWS = 1000
"""Variants of a partition."""
SCHEMA = "rankdrop/sweep-rows/1"
Column = tuple[str, str, str, Callable[[Mapping[str, Any]], Any]]
_FAMILY_COLUMNS: list[Column] = [
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
        ("variants", _variant_columns(designs), iter),
        ("families", _FAMILY_COLUMNS, _family_rows),
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
        shares = {one["id"]: one for one in record.get("near", {}).get("families", [])}
        for family in record.get("families", []):
            yield {**family, "variant": record["number"] + 1, "share": shares.get(family["id"])}


def _variant_columns(designs: Designs) -> list[Column]:
    return [
        ("variant", "int64", "number of the variant, from 1", lambda one: one["number"] + 1),
        *((f"{one.name}_{one.unit}", "float64", f"parameter, sets {', '.join(map(str, one.places))}",
           lambda record, k=k: record["values"][k]) for k, one in enumerate(designs.parameters)),
        *((name, "float64", MEANINGS[name] + (f"; {UNITS[name]}" if UNITS[name] else ""),
           lambda record, name=name: record["measures"].get(name)) for name in designs.measures),
        ("verdict", "string", "of its families; null where they were not asked for", lambda one: one.get("verdict")),
        ("error", "string", "why it could not be measured as a whole; null where it was", lambda one: one["error"]),
    ]  # fmt: skip


def _table(
    arrow: Any, parquet: Any, columns: Sequence[Column], rows: Sequence[Mapping[str, Any]], designs: Designs
) -> bytes:
    types = {"int64": arrow.int64(), "float64": arrow.float64(), "string": arrow.string()}
    fields = [arrow.field(name, types[kind], metadata={"meaning": meaning}) for name, kind, meaning, _ in columns]
    arrays = [arrow.array([take(row) for row in rows], types[kind]) for _, kind, _, take in columns]
    schema = arrow.schema(fields, metadata={"schema": SCHEMA, "robot": designs.robot, "task": designs.spec.task.name})
    out = io.BytesIO()
    parquet.write_table(arrow.table(arrays, schema=schema), out, compression="zstd")
    return out.getvalue()


_BEST = {
    "slow": "smallest share of the configurations inside the limits at which the tool is slow",
    "near": "smallest share of the joint space near singularities",
    "sigma": "largest σ over the region",
    "reached": "most poses of the region reached",
    "slow_poses": "fewest slow poses",
    "path_sigma": "largest σ on the paths",
    "path_distance": "largest distance from singularities on the paths",
    "paths_free": "most paths proven free",
    "free": "largest share proven free",
}
"""What the best arm by a measure has; numbers of families are told and not judged."""


@dataclass(frozen=True, eq=False)
class SideBySide(Result):
    """Arms measured for the same task.

    Attributes:
        names: of the arms, as they were given.
        robots: the arms.
        task: with the length scale of σ, the same for all.
        limits: inside the joint limits.
        seed: of every random choice.
        records: of the arms, in their order; as those of a sweep.
    """

    names: tuple[str, ...]
    robots: tuple[Robot, ...]
    task: Task
    limits: bool
    seed: int
    records: Sequence[Mapping[str, Any]]
    FILE: ClassVar[str] = "side-by-side"

    @property
    def measures(self) -> list[str]:
        """Names of the measures, in their order."""
        return measures_of(self.records)

    @property
    def holds(self) -> bool:
        """Whether every arm was measured and its families, where asked for, are verified."""
        return not any(map(in_doubt, self.records))

    def best(self, measure: str) -> tuple[int, ...]:
        """The arms, from 0, that are best by one measure; those within the error of the best are too."""
        records = [{**one, "error": None} for one in self.records]
        return tuple(rank(records, {measure: GOALS[measure]}).best)

    @property
    def sentence(self) -> str:
        """What was found, in one sentence."""
        doubt = [name for name, one in zip(self.names, self.records, strict=True) if in_doubt(one)]
        if doubt:
            return f"Incomplete: not all holds of {', '.join(doubt)}."
        best = {_BEST[name]: tuple(self.names[i] for i in self.best(name)) for name in self.measures if name in _BEST}
        return compared_sentence(self.names, self.task.name, best)

    def sections(self, *, full: bool = True) -> Iterator[Section]:
        """As sections of text: a column for each arm; then each arm with all its families, or without `full` in a line.
        """
        yield Section("", lines=(self.sentence,))
        rows = [("joints", *(str(robot.n) for robot in self.robots)),
                ("reach", *(f"{reach(robot):.4g} m" for robot in self.robots))]  # fmt: skip
        rows += [(name, *self._cells(name)) for name in self.measures]
        if self.limits:
            where = "inside the joint limits"
        else:
            where = "the whole joint space"
        notes = [f"σ has translation divided by {self.task.length_scale:.4g} m for every arm; ← best",
                 *(f"{name}: {MEANINGS[name]}{error_text(self.records, name)}" for name in self.measures)]  # fmt: skip
        yield Section("Side by side", f"task {self.task.name}; {where}; seed {self.seed}", columns=("", *self.names),
                      rows=tuple(rows), texts=(0,), notes=tuple(notes))  # fmt: skip
        if not full:
            yield compared_arms(self.names, self.records)
            return
        for name, robot, one in zip(self.names, self.robots, self.records, strict=True):
            yield _arm(name, robot.about, one)
        yield Section("", lines=(self.sentence,))

    def _cells(self, measure: str) -> list[str]:
        """A measure of each arm, the best marked."""
        best = self._ranked_best(measure)
        cells = []
        for number, record in enumerate(self.records):
            mark = "  ←" if number in best else ""
            cells.append(measure_cell(measure, record) + mark)
        return cells

    def _ranked_best(self, measure: str) -> tuple[int, ...]:
        best = self.best(measure)
        if measure not in UNRANKED and len(best) < len(self.names):
            return best
        return ()


def _families_of_arm(one: Mapping[str, Any]) -> tuple[tuple[str, str, str, str], ...]:
    """Corank, name, dimension and share of each family of an arm."""
    shares = {share["id"]: share["share"] for share in one.get("near", {}).get("families", [])}
    rows = []
    for family in one.get("families", []):
        share = "–"
        if family["id"] in shares:
            share = measure_text("near", shares[family["id"]])
        rows.append((str(family["corank"]), family["name"], str(family["dimension"]), share))
    return tuple(rows)


def _arm(name: str, about: str, one: Mapping[str, Any]) -> Section:
    rows = _families_of_arm(one)
    lines = [one["error"]] if one["error"] else []
    if one.get("aspects"):
        lines.append(aspects_line(AspectSummary(**one["aspects"])))
    if "sentence" in one:
        lines.append(one["sentence"])
    if one.get("region") and one["region"]["sigma"] is not None:
        at = ", ".join(f"{x:.3g}" for x in one["region"]["at"])
        lines.append(f"σ over the region is smallest at ({at}) m: {one['region']['sigma']:.4g}".replace("-", "−"))
    for path in one.get("paths", []):
        if path["sigma"] is None:
            told = f": {path['why']}"
        else:
            told = f", smallest σ {path['sigma']:.4g}"
        lines.append(f"{path['name']}: {path['verdict']}{told}")
    columns = ("corank", "family", "dim", "near") if rows else ()
    return Section(name, about, lines=tuple(lines), columns=columns, rows=rows, texts=(1,))
