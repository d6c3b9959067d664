"""Sweeps and comparisons of arms in words: what was found, tables of variants, of arms, and of families.

The records are those of `rankdrop.designs`; `Any` here, since words lie below them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import degrees, inf
from typing import Any

from rankdrop.distance.share import NearShare
from rankdrop.options import advise
from rankdrop.results.aspect_summary import POSES, AspectSummary
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.quantities import count
from rankdrop.sections import Section
from rankdrop.text.aspects import aspects_and_verdict_cell, aspects_line
from rankdrop.text.brief import NO_RATE_LIMITS, compared_arms, compared_sentence, sigma_note, slow_note, slow_poses_note
from rankdrop.text.words import sweep_next

SHOWN = 20
"""Variants of the Pareto list, and structures and kinds of change, that are told."""
APART = 2.0
"""Standard errors by which shares of samples have to differ."""
_BETWEEN = "a change lies somewhere between two variants that were searched; one that comes and goes is not seen"
_ALMOST_ALL = "for almost all lengths; where two lengths are equal or one is zero more may hold"
UNITS = {"families": "", "aspects": "", "near": "share", "slow": "share", "sigma": "1", "reached": "share",
         "slow_poses": "share", "path_sigma": "1", "path_distance": "rad", "paths_free": "share",
         "free": "share"}  # fmt: skip
"""Of every measure."""
MEANINGS = {
    "families": "number of families of every corank",
    "aspects": "number of connected sets of regular configurations, joint limits ignored; – where it is not proven. "
    "Cuspidal: the arm can change its posture without a singularity (proven). Undecided: no such change was found in "
    f"{POSES} poses",
    "near": "share of the joint space near any family",
    "slow": "share of the configurations inside the limits at which some straight motion of the tool is slow",
    "sigma": "smallest, over the poses of the region, of the σ of the best posture, with proven bounds",
    "reached": "share of the region's poses for which a posture was found",
    "slow_poses": "share of the region's poses reached at which some straight motion of the tool is slow, in every "
    "posture found",
    "path_sigma": "smallest σ on the paths",
    "path_distance": "smallest distance from a singular configuration on the paths",
    "paths_free": "share of the paths proven free as a whole",
    "free": "share of the joint space proven free",
}
"""What every measure means."""
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




def sweep_sentence(designs: Any) -> str:
    """What was found, in one sentence."""
    variants = f"{len(designs.records):,} variants of {designs.robot}"
    if designs.failed:
        return f"Incomplete: {len(designs.failed):,} of {variants} could not be measured as a whole."
    if designs.unverified:
        return f"Incomplete: the families of {len(designs.unverified):,} of {variants} do not hold."
    if designs.pareto or designs.spec.goals:
        parts = [_best(designs)]
    else:
        parts = [f"{variants} were measured"]
    if designs.structures:
        sets = len(designs.structures)
        if sets == 1:
            parts.append("all have the same families")
        else:
            parts.append(f"they have {sets} different sets of families")
        parts.append("the families of each were verified by sampling")
    return f"{'; '.join(parts)}."


def _best(designs: Any) -> str:
    best, variants = len(designs.pareto), len(designs.records)
    of_all = f"{variants:,} variants of {designs.robot}"
    if not best:
        missing = [name for name in designs.spec.goals if designs.values(name).count(None) == variants]
        return f"None of {of_all} is ranked: none has {' and '.join(missing) or 'every measure'}"
    if best == 1:
        return f"Variant {designs.pareto[0] + 1} is the best of {of_all}"
    if designs.ranking.differ:
        others = variants - best
        worse = ""
        if others:
            worse = f", {count(others, 'is', 'are')} worse by more than the error"
        return f"{best:,} of {of_all} are Pareto-optimal{worse}"
    return f"{best:,} of {of_all} cannot be distinguished by their measures"


def sweep_summary(designs: Any) -> tuple[str, ...]:
    """The lines printed first: the result, the best variant or one of several, ranges of measures, the next step."""
    titles = [*(parameter.name for parameter in designs.parameters), *designs.measures]
    best = [variant_row(designs, designs.records[number]) for number in _in_order(designs, designs.pareto)[:1]]
    if len(designs.pareto) == 1:
        head = "Best"
    else:
        head = f"One of {len(designs.pareto)}"
    lines = [sweep_sentence(designs)]
    for row in best:
        cells = [f"{title} {cell}" for title, cell in zip(titles, row, strict=True)]
        lines.append(f"{head}: {', '.join(cells)}.")
    ranges = []
    for name in designs.measures:
        values = [x for x in designs.values(name) if x is not None]
        if values:
            ranges.append(f"{name} {measure_text(name, min(values))} … {measure_text(name, max(values))}")
    if ranges:
        lines.append(f"Range: {', '.join(ranges)}.")
    return (*lines, sweep_next())


def sweep_sections(designs: Any, *, every: bool = False) -> Iterator[Section]:
    """As sections of text; `every`: all variants, not only the Pareto-optimal ones."""
    yield Section("", lines=sweep_summary(designs))
    ranges = tuple(
        (parameter.name, ", ".join(map(str, parameter.places)), parameter_text(parameter.lower, parameter),
         parameter_text(parameter.upper, parameter))
        for parameter in designs.parameters
    )
    where = _limits_words(designs.spec.limits)
    spec = designs.spec
    about = f"{len(designs.records):,} variants ({spec.kind}); task {spec.task.name}; {where}; seed {spec.seed}"
    after = (f"σ has translation divided by {designs.spec.task.length_scale:.4g} m, for every variant",)
    columns = ("parameter", "sets", "from", "to")
    yield Section(f"{designs.robot}: sweep", about, columns=columns, rows=ranges, texts=(0, 1), after=after)
    yield from _ranking(designs, every)
    yield from _families(designs)
    if designs.failed or designs.unverified:
        yield _doubt(designs)
    yield Section("", lines=(sweep_sentence(designs),))


def _ranking(designs: Any, every: bool) -> Iterator[Section]:
    if every or not designs.pareto:
        title, chosen = "Variants", _in_order(designs, range(len(designs.records)))
    else:
        title, chosen = "Pareto-optimal variants", _in_order(designs, designs.pareto)
    names = designs.measures
    if not chosen or not names:
        return
    if every:
        most = len(chosen)
    else:
        most = SHOWN
    rows = tuple((str(i + 1), *variant_row(designs, designs.records[i])) for i in chosen[:most])
    summary = f"{len(chosen):,} of {len(designs.records):,}{_wants(designs)}"
    after: tuple[str, ...] = ()
    if len(chosen) > most:
        after = (f"and {len(chosen) - most:,} more: {advise('all', python='sections(every=True)')}",)
    notes = tuple(f"{name}: {MEANINGS[name]}{error_text(designs.records, name)}" for name in names)
    yield Section(title, summary,
                  columns=("variant", *(parameter.name for parameter in designs.parameters), *names), rows=rows,
                  texts=(), after=after, notes=notes)  # fmt: skip


def _wants(designs: Any) -> str:
    """What counts as better, "; better: least reach"; "" without goals."""
    wants = ", ".join(f"{want} {name}" for name, want in designs.spec.goals.items())
    if not wants:
        return ""
    return f"; better: {wants}"


def variant_row(designs: Any, record: Mapping[str, Any]) -> tuple[str, ...]:
    """Parameters and measures of a variant, for people."""
    values = [parameter_text(x, parameter) for x, parameter in zip(record["values"], designs.parameters, strict=True)]
    return (*values, *(measure_cell(name, record) for name in designs.measures))


def _in_order(designs: Any, numbers: Iterable[int]) -> list[int]:
    """Variants by the first goal, best first; variants without it last."""
    first, want = next(iter(designs.spec.goals.items()), ("", "less"))
    sign = {"less": 1.0}.get(want, -1.0)

    def cost(number: int) -> float:
        value = designs.records[number]["measures"].get(first)
        if value is None:
            return inf
        return sign * float(value)

    return sorted(numbers, key=cost)


def _families(designs: Any) -> Iterator[Section]:
    structures = designs.structures
    if not structures:
        return
    common = structures[0]
    rows = []
    for number, structure in enumerate(structures[:SHOWN], 1):
        keys = "\n".join(structure.keys)
        if number > 1:
            keys = _difference(common, structure)
        ends = zip(designs.parameters, structure.ranges, strict=True)
        where = ", ".join(f"{p.name} {parameter_text(low, p)} … {parameter_text(high, p)}" for p, (low, high) in ends)
        rows.append((str(number), f"{len(structure.variants):,}", keys, where))
    more = _not_shown(len(structures) - SHOWN, "more")
    about = "the commonest first; the others by what they have more (+) and less (−)"
    columns = ("", "variants", "families", "within")
    yield Section("Sets of families", about, columns=columns, rows=tuple(rows), texts=(2, 3), after=more)
    if designs.changes:
        yield _changes_section(designs)
    if designs.exact:
        yield _exact(designs)


def _difference(common: Any, other: Any) -> str:
    """The families that a set has more and less than the commonest one."""
    new = sorted(set(other.keys) - set(common.keys))
    gone = sorted(set(common.keys) - set(other.keys))
    return "; ".join([*(f"+ {key}" for key in new), *(f"− {key}" for key in gone)])


def _changes_section(designs: Any) -> Section:
    counts = Counter(change.what for change in designs.changes)
    rows = []
    for what, pairs in counts.most_common(SHOWN):
        kind, before, after = what
        places = [change for change in designs.changes if change.what == what]
        first, into = " and ".join(before), " and ".join(after)
        if not before:
            first, into = into, ""
        rows.append((kind, first, into, str(pairs), _brackets_words(designs, places)))
    more = _not_shown(len(counts) - SHOWN, "more kinds")
    columns = ("", "family", "into", "pairs", "between")
    return Section("Between neighbours", "differences, and where they are", columns=columns, rows=tuple(rows),
                   texts=(0, 1, 2, 4), after=more, notes=(_BETWEEN,))  # fmt: skip


def _brackets_words(designs: Any, places: Sequence[Any]) -> str:
    bracketed = []
    for parameter in designs.parameters:
        mine = [place for place in places if place.parameter == parameter.name]
        brackets = sorted({(min(p.low, p.high), max(p.low, p.high)) for p in mine})
        if brackets:
            words = ", ".join(
                f"{parameter_text(low, parameter)} and {parameter_text(high, parameter)}" for low, high in brackets[:3]
            )
            if len(brackets) > 3:
                words += " …"
            bracketed.append(f"{parameter.name}: {words}")
    if not bracketed and places:
        bracketed = [f"variants {places[0].first + 1} and {places[0].second + 1}"]
    return "; ".join(bracketed)


def _exact(designs: Any) -> Section:
    rows = []
    for derived in designs.exact:
        letters = ", ".join(f"{name} = {value:.4g}" for name, value in derived["letters"].items()).replace("-", "−")
        sets = [("; ".join(family["conditions"]), family["real"]) for family in derived["families"] if family["real"]]
        sets += [(text, "no") for text in derived["not_real"]]
        if not sets:
            families = count(len(derived["families"]), "family", "families")
            sets = [(families, "for all lengths of these signs")]
        for k, (what, real) in enumerate(sets):
            head = ("", "")
            if k == 0:
                head = (str(derived["variant"]), letters)
            rows.append((head[0], what, real, head[1]))
    about = "a variant of each of the commonest sets, with letters for the lengths; families not always real"
    columns, texts = ("variant", "conditions", "real", "its lengths [m]"), (0, 1, 2, 3)
    return Section("Derived exactly", about, columns=columns, rows=tuple(rows), texts=texts, notes=(_ALMOST_ALL,))


def _limits_words(limits: bool) -> str:
    """The configurations that were measured."""
    if limits:
        return "inside the joint limits"
    return "the whole joint space"


def _not_shown(many: int, what: str) -> tuple[str, ...]:
    """A line on what a table leaves out, if anything."""
    if many <= 0:
        return ()
    return (f"and {many} {what}, in the JSON",)


def _doubt(designs: Any) -> Section:
    lines = [f"variant {i + 1}: {designs.records[i]['error']}" for i in designs.failed[:SHOWN]]
    lines += [f"variant {i + 1}: {designs.records[i]['sentence']}" for i in designs.unverified[:SHOWN]]
    return Section("What does not hold", lines=tuple(lines))


def error_text(records: Sequence[Mapping[str, Any]], measure: str) -> str:
    """How far a share may be off, by its samples; "" for a measure without error."""
    regions = [record["region"] for record in records if (record.get("region") or {}).get("sigma") is not None]
    if measure == "slow_poses":
        return _slow_poses_error(regions)
    if measure == "sigma":
        wide_bounds = sum(not region.get("narrow") for region in regions)
        return sigma_note(len(regions), wide_bounds, sum(not region.get("covered") for region in regions))
    if measure == "slow":
        return _slow_error(records)
    if measure == "near":
        return _near_error([record["near"]["any"] for record in records if record.get("near")])
    return ""


def _near_error(shares: Sequence[Mapping[str, Any]]) -> str:
    """The largest error of shares near families, and that it may be larger; "" where no share has one."""
    most = max((float(share["error"]) for share in shares), default=0.0)
    if not most:
        return ""
    larger = ""
    if any(share["bound"] for share in shares):
        larger = " or more"
    return f", by samples: ± {APART * 100 * most:.2g} %{larger}"


def _slow_error(records: Sequence[Mapping[str, Any]]) -> str:
    """The speeds below which the tool is slow, the widest interval of the shares, and why some have none."""
    if any(record.get("slow", True) is None for record in records):
        missing = NO_RATE_LIMITS
    else:
        missing = ""
    slow = [record["slow"] for record in records if record.get("slow")]
    if not slow:
        return missing
    ends = [_slow_interval(share) for share in slow]
    wide = max(high - low for low, high in ends)
    bound = any(share["bound"] for share in slow)
    return slow_note(slow[0].get("tool_speed"), slow[0].get("turn_speed"), wide, bound=bound) + missing


def _slow_interval(slow: Mapping[str, Any]) -> tuple[float, float]:
    """95 % interval of a share by its samples, which files of earlier versions do not hold."""
    share = NearShare("", round(slow["share"] * slow["samples"]), slow["samples"], slow["bound"])
    return share.interval


def _slow_poses_error(regions: Sequence[Mapping[str, Any]]) -> str:
    slow = [region["slow"] for region in regions if region.get("slow")]
    if not slow:
        return ""
    wide = max(share["interval"][1] - share["interval"][0] for share in slow)
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
    high = "?"
    if upper is not None:
        high = f"{upper:.4g}"
    return f"{text} ({region['sigma_lower']:.4g} … {high})"


_CELLS: dict[str, Callable[[str, Mapping[str, Any]], str]] = {
    "aspects": _aspects_cell, "slow": _slow_cell, "slow_poses": _slow_poses_cell, "sigma": _sigma_cell,
}  # fmt: skip
"""Measures with bounds -> their cell, from the measure as text and the record."""


def parameter_text(value: float, parameter: Any) -> str:
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
    if UNITS[name] == "rad":
        return f"{value:.4g} rad"
    return f"{value:.4g}"


def compared_arms_sentence(comparison: Any) -> str:
    """What a comparison found, in one sentence."""
    if comparison.doubtful:
        return f"Incomplete: not all holds of {', '.join(comparison.doubtful)}."
    best = {}
    for name in comparison.measures:
        if name in _BEST:
            best[_BEST[name]] = tuple(comparison.names[i] for i in comparison.best(name))
    return compared_sentence(comparison.names, comparison.task.name, best)


def compared_arms_sections(comparison: Any, *, full: bool = True) -> Iterator[Section]:
    """A column for each arm; then each arm with all its families, or without `full` in a line."""
    yield Section("", lines=(comparison.sentence,))
    rows = [("joints", *(str(robot.n) for robot in comparison.robots)),
            ("reach", *(f"{reach(robot):.4g} m" for robot in comparison.robots))]  # fmt: skip
    rows += [(name, *_arm_cells(comparison, name)) for name in comparison.measures]
    where = _limits_words(comparison.limits)
    notes = [f"σ has translation divided by {comparison.task.length_scale:.4g} m for every arm; ← best",
             *(f"{name}: {MEANINGS[name]}{error_text(comparison.records, name)}"
               for name in comparison.measures)]  # fmt: skip
    subtitle = f"task {comparison.task.name}; {where}; seed {comparison.seed}"
    yield Section("Side by side", subtitle, columns=("", *comparison.names),
                  rows=tuple(rows), texts=(0,), notes=tuple(notes))  # fmt: skip
    if not full:
        yield compared_arms(comparison.names, comparison.records)
        return
    for name, robot, record in zip(comparison.names, comparison.robots, comparison.records, strict=True):
        yield _arm(name, robot.about, record)
    yield Section("", lines=(comparison.sentence,))


def _arm_cells(comparison: Any, measure: str) -> list[str]:
    """A measure of each arm, the best marked."""
    best = comparison.distinguished(measure)
    cells = []
    for number, record in enumerate(comparison.records):
        cell = measure_cell(measure, record)
        if number in best:
            cell += "  ←"
        cells.append(cell)
    return cells


def _families_of_arm(record: Mapping[str, Any]) -> tuple[tuple[str, str, str, str], ...]:
    """Corank, name, dimension and share of each family of an arm."""
    shares = {share["id"]: share["share"] for share in record.get("near", {}).get("families", [])}
    rows = []
    for family in record.get("families", []):
        share = "–"
        if family["id"] in shares:
            share = measure_text("near", shares[family["id"]])
        rows.append((str(family["corank"]), family["name"], str(family["dimension"]), share))
    return tuple(rows)


def _arm(name: str, about: str, record: Mapping[str, Any]) -> Section:
    rows = _families_of_arm(record)
    lines = []
    if record["error"]:
        lines.append(record["error"])
    if record.get("aspects"):
        lines.append(aspects_line(AspectSummary(**record["aspects"])))
    if record.get("sentence"):
        lines.append(record["sentence"])
    if record.get("region") and record["region"]["sigma"] is not None:
        at = ", ".join(f"{x:.3g}" for x in record["region"]["at"])
        lines.append(f"σ over the region is smallest at ({at}) m: {record['region']['sigma']:.4g}".replace("-", "−"))
    for path in record.get("paths", []):
        if path["sigma"] is None:
            detail = f": {path['why']}"
        else:
            detail = f", smallest σ {path['sigma']:.4g}"
        lines.append(f"{path['name']}: {path['verdict']}{detail}")
    columns: tuple[str, ...] = ()
    if rows:
        columns = ("corank", "family", "dim", "near")
    return Section(name, about, lines=tuple(lines), columns=columns, rows=rows, texts=(1,))
