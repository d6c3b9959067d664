"""The specification of a sweep: the arm, which of its numbers are parameters, the variants, what is measured of each.

In TOML; the keys are described in docs/howto/comparing-designs.md. `TABLES` lists every key with its reader, default
and bounds. Readers name the place of a wrong value as "table.key"; `spec_of` adds the file and the line.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import degrees, isfinite, prod
from os.path import isfile
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.designs.region import BUDGET
from rankdrop.distance.share import WIDEST
from rankdrop.errors import OptionError, RankdropError, RobotError
from rankdrop.families import MOST_STARTS
from rankdrop.path import read_poses
from rankdrop.robot import Array, Drawing, quantity
from rankdrop.robot.drawing import NumberPlace
from rankdrop.robot.files import read_text
from rankdrop.robot.toml_file import Lines, line_of, lines_of, parsed_toml
from rankdrop.task import Task, resolve_task

KINDS = ("grid", "latin-hypercube", "sobol", "list")
MOST_VARIANTS = 1_000_000
MOST_PARAMETERS = 12
ASKS = ("families", "aspects", "near", "slow", "region", "paths", "certified")
GOALS = {
    "families": "less", "aspects": "less", "near": "less", "slow": "less", "sigma": "more", "reached": "more",
    "slow_poses": "less", "path_sigma": "more", "path_distance": "more", "paths_free": "more", "free": "more",
}  # fmt: skip
"""Every measure, and whether less or more of it is better."""
UNRANKED = ("families", "aspects")
"""Numbers that make no arm better by themselves: they are goals only where a plan names them in `[pareto]`."""
_MEASURES = {
    "families": ("families",), "aspects": ("aspects",), "near": ("near",), "slow": ("slow",),
    "region": ("sigma", "reached", "slow_poses"), "paths": ("path_sigma", "path_distance", "paths_free"),
    "certified": ("free",),
}  # fmt: skip

Entry = tuple[Any, ...]
"""(reader, default, further arguments of the reader)."""

_PARAMETER = ("sets", "lower", "upper", "steps", "values")


@dataclass(frozen=True)
class Parameter:
    """One number of the arm that is varied.

    Attributes:
        name: as the table and the plots call it.
        places: where it stands in the arm, each with a sign.
        measure: "length" [m] or "angle" [rad].
        values: of a grid; empty where a range is sampled.
        lower, upper: of the range, or of the values [m, rad].
    """

    name: str
    places: tuple[NumberPlace, ...]
    measure: str
    values: tuple[float, ...]
    lower: float
    upper: float

    @property
    def unit(self) -> str:
        """ "m" or "rad"."""
        if self.measure == "length":
            return "m"
        return "rad"


@dataclass(frozen=True)
class Asks:
    """What is measured of every variant; None: not measured.

    Attributes:
        families: starts, fresh and exact.
        aspects: no keys; joint limits are ignored.
        near: within [rad] and samples.
        slow: speed [m/s], turn_speed [rad/s], 0 where rotations do not count, and samples.
        region: lower, upper [m], rpy [rad] or None, points, starts, budget of each proven bound of σ, and
            speed [m/s] or None.
        paths: name of each file -> its poses (P, 4, 4) [m] and times (P,) [s] or None.
        certified: width of the boxes [rad].
    """

    families: Mapping[str, Any] | None = None
    aspects: Mapping[str, Any] | None = None
    near: Mapping[str, Any] | None = None
    slow: Mapping[str, Any] | None = None
    region: Mapping[str, Any] | None = None
    paths: Mapping[str, Any] | None = None
    certified: float | None = None

    @property
    def measures(self) -> list[str]:
        """Names of the measures that result: the columns of the table."""
        names = [name for ask in ASKS if getattr(self, ask) is not None for name in _MEASURES[ask]]
        if self.region is None:
            speed = None
        else:
            speed = self.region.get("speed")
        return [name for name in names if name != "slow_poses" or speed is not None]


@dataclass(frozen=True)
class Spec:
    """A sweep, checked.

    Attributes:
        drawing: the arm whose numbers are varied.
        task: what it is to do; its length scale is the same for every variant, so that σ can be compared.
        limits: configurations inside the joint limits only.
        seed: of every random choice.
        parameters: in their order.
        kind: how variants are chosen: one of `KINDS`.
        count: of variants, for samples.
        listed: of a list, the values of every variant by parameter [m, rad].
        asks: what is measured.
        pareto: measure -> "less" or "more"; empty for those that are measured.
    """

    drawing: Drawing
    task: Task
    limits: bool
    seed: int
    parameters: tuple[Parameter, ...]
    kind: str
    count: int
    listed: tuple[tuple[float, ...], ...]
    asks: Asks
    pareto: Mapping[str, str] = field(default_factory=dict)

    @property
    def goals(self) -> dict[str, str]:
        """What a better variant has less or more of: as given, else every measure but those of `UNRANKED`."""
        return dict(self.pareto) or {name: GOALS[name] for name in self.asks.measures if name not in UNRANKED}

    @property
    def box(self) -> tuple[Array, Array]:
        """Lower and upper corner (p,) of the ranges of the parameters [m, rad]."""
        lower = np.array([parameter.lower for parameter in self.parameters])
        upper = np.array([parameter.upper for parameter in self.parameters])
        return lower, upper

    def in_unit_box(self, values: Array) -> Array:
        """(V, p) values as shares of their ranges, 0 … 1."""
        low, high = self.box
        return np.asarray((values - low) / np.where(high > low, high - low, 1.0))


def read_spec(path: str | Path) -> Spec:
    """The specification in a file; names of files in it are relative to its folder.

    Raises:
        OptionError, RobotError: the file, a key or a value cannot be used; names file and line.
    """
    file = Path(path)
    try:
        text = read_text(file)
    except RobotError as error:
        raise OptionError(error.what, where=str(path), got=error.got, allowed=error.allowed) from None
    return spec_of(parsed_toml(text, str(path)), file=str(path), folder=file.parent, lines=lines_of(text))


def spec_of(
    document: Mapping[str, Any], *, file: str = "spec", folder: Path | None = None, lines: Lines | None = None
) -> Spec:
    """The specification of tables that are parsed already.

    Args:
        document: the tables of the TOML file, as a mapping.
        file: its name, for errors.
        folder: that names of files are relative to; None: the working one.
        lines: of its text.

    Raises:
        OptionError: a key or a value cannot be used.
    """
    folder = folder or Path(".")
    with _name_line(file, lines):
        head = _read_table(document, "")
        drawing = _drawing(head, folder)
        task = _task(head, drawing)
        parameters = _parameters(head["parameters"], drawing)
        kind, count, listed = _sample(head, parameters)
        asks = _asks(head, folder)
        pareto = _pareto(head["pareto"], asks.measures)
        return Spec(drawing, task, head["limits"], head["seed"], parameters, kind, count, listed, asks, pareto)


def question_of(document: Mapping[str, Any]) -> tuple[dict[str, Any], Asks]:
    """What a specification without an arm and without variants asks: task, length_scale, limits, seed …, and measures.

    Raises:
        OptionError: a key or a value cannot be used.
    """
    with _name_line("", None):
        head = _read_table(document, "", ("task", "length_scale", "limits", "seed", "as_written", *ASKS))
        return head, _asks(head, Path("."))


@contextmanager
def _name_line(file: str, lines: Lines | None) -> Iterator[None]:
    """Errors that name "table.key: rest" name the file and the line as well."""
    try:
        yield
    except RankdropError as error:
        raise OptionError(error.what, where=_place(error.where or "", file, lines), got=error.got,
                          allowed=error.allowed, mend=error.mend) from error  # fmt: skip


def _place(where: str, file: str, lines: Lines | None) -> str:
    """ "near.within: rest" as "designs.toml, line 12, near.within: rest"."""
    name, colon, rest = where.partition(": ")
    table, _, key = name.partition(".")
    shown, _, number = table.rstrip("]").partition("[")
    parts = [file] if file else []
    if lines is not None:
        if key or number:
            own = (shown, int(number) if number else None, key)
        else:
            own = ("", None, shown)
        titled = lines.get((name, None, ""))  # [parameters.x] has a line of its own
        parts[0] += f", line {lines.get(own) or titled or line_of(lines, *own)}"
    if shown:
        parts.append(f"{shown}.{key}" if key else shown)
    return ", ".join(parts) + colon + rest


def _read_table(table: Mapping[str, Any], name: str, keys: tuple[str, ...] = ()) -> dict[str, Any]:
    """Every key of a table of `TABLES`, read and checked; only some keys are allowed where they are given."""
    known = {key: TABLES[name][key] for key in keys or TABLES[name]}
    entry = f"{name}." if name else ""
    for key in table:
        _require(
            key in known, OptionError("unknown key", where=f"{entry}{key}", got=repr(key), allowed=", ".join(known))
        )
    return {key: read(table.get(key, default), f"{entry}{key}", *bounds)
            for key, (read, default, *bounds) in known.items()}  # fmt: skip


def _require(holds: bool, error: OptionError) -> None:
    if not holds:
        raise error


def _flag(value: Any, where: str) -> bool:
    _require(
        isinstance(value, bool),
        OptionError(f"{_key(where)} is true or false", where=where, got=repr(value), allowed="true, false"),
    )
    return bool(value)


def _text(value: Any, where: str) -> str | None:
    _require(
        value is None or (isinstance(value, str) and value != ""),
        OptionError(f"{_key(where)} is a text", where=where, got=repr(value)),
    )
    return None if value is None else str(value)


def _whole_number(value: Any, where: str, least: int, most: int, key: str = "") -> int:
    _require(
        not isinstance(value, bool) and isinstance(value, int) and least <= value <= most,
        OptionError(
            f"{key or _key(where)} is not a whole number that can be used",
            where=where,
            got=repr(value),
            allowed=f"{least} … {most}",
        ),
    )
    return int(value)


def _length(value: Any, where: str) -> float | None:
    if value is None:
        return None
    return quantity(value, "length", where=where)


def _speed(value: Any, where: str, measure: str) -> float:
    speed = quantity(value, measure, where=where, rate=True)
    _require(speed > 0.0, OptionError(f"{_key(where)} is out of range", where=where, got=speed, allowed="above 0"))
    return speed


def _turn_speed(value: Any, where: str, measure: str) -> float:
    speed = quantity(value, measure, where=where, rate=True)
    _require(speed >= 0.0, OptionError(f"{_key(where)} is out of range", where=where, got=speed, allowed="0 or more"))
    return speed


def _region_speed(value: Any, where: str, measure: str) -> float | None:
    if value is None:
        return None
    return _speed(value, where, measure)


def _width(value: Any, where: str, most: float) -> float:
    width = quantity(value, "angle", where=where)
    if not 0.0 < width <= most:
        raise OptionError(f"{_key(where)} is out of range", where=where, got=width,
                          allowed=f"above 0, up to {most:g} rad ({degrees(most):.0f}°)")  # fmt: skip
    return width


def _three(value: Any, where: str, measure: str, allowed: str) -> list[float] | None:
    if value is None and _key(where) == "rpy":
        return None
    _require(
        isinstance(value, list) and len(value) == 3,
        OptionError(f"{_key(where)} is three numbers", where=where, got=repr(value), allowed=allowed),
    )
    return [quantity(entry, measure, where=where) for entry in value]


def _files(value: Any, where: str) -> list[str]:
    _require(
        _are_texts(value),
        OptionError("files is a list of files of poses", where=where, got=repr(value), allowed='files = ["pick.csv"]'),
    )
    return list(value)


def _are_texts(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(entry, str) and entry for entry in value)


def _later(value: Any, where: str) -> Any:
    """A value that is read together with others."""
    fits = where not in TABLES or value is None or isinstance(value, Mapping)
    _require(fits, OptionError(f"{where} is a table", where=where, got=repr(value), allowed=f"[{where}]"))
    return value


def _key(where: str) -> str:
    return where.rpartition(".")[2]


TABLES: dict[str, dict[str, Entry]] = {
    "": {
        "robot": (_text, None), "tip": (_text, None), "base": (_text, None), "as_written": (_flag, False),
        "task": (_text, None), "length_scale": (_length, None), "limits": (_flag, False),
        "seed": (_whole_number, 0, 0, 2**63 - 1), "parameters": (_later, {}), "sample": (_later, {}),
        "variants": (_later, None), "families": (_later, None), "aspects": (_later, None), "near": (_later, None),
        "slow": (_later, None), "region": (_later, None), "paths": (_later, None), "certified": (_later, None),
        "pareto": (_later, {}),
    },
    "parameters": {},
    "sample": {"kind": (_later, None), "variants": (_later, 0)},
    "families": {
        "starts": (_whole_number, 300, 10, MOST_STARTS), "fresh": (_whole_number, 300, 10, 20_000),
        "exact": (_flag, True),
    },
    "aspects": {},
    "near": {
        "within": (_width, "5 deg", WIDEST),
        "samples": (_whole_number, 2000, 100, 1_000_000),
    },
    "slow": {
        "speed": (_speed, "25 mm/s", "length"), "turn_speed": (_turn_speed, "5 deg/s", "angle"),
        "samples": (_whole_number, 2000, 100, 1_000_000),
    },
    "region": {
        "lower": (_three, None, "length", "[x, y, z]"), "upper": (_three, None, "length", "[x, y, z]"),
        "rpy": (_three, None, "angle", "[roll, pitch, yaw]"), "points": (_whole_number, 40, 1, 100_000),
        "starts": (_whole_number, 12, 1, 1000), "budget": (_whole_number, BUDGET, 0, 10_000_000),
        "speed": (_region_speed, None, "length"),
    },
    "paths": {"files": (_files, None)},
    "certified": {"width": (_width, 0.2, 1.0)},
    "pareto": {"less": (_later, []), "more": (_later, [])},
}  # fmt: skip
"""Table -> key -> how it is read. The first table is the head of the file; "parameters" has the names as keys."""


def _drawing(head: Mapping[str, Any], folder: Path) -> Drawing:
    name = head["robot"]
    _require(name is not None, OptionError("the robot is not said", where="robot", allowed='robot = "ur5", or a file'))
    beside = folder / name
    try:
        return Drawing.of(str(beside) if isfile(beside) else name, head["tip"], head["base"],
                          as_written=head["as_written"])  # fmt: skip
    except RankdropError as error:
        raise _error_at("robot", error) from error


def _error_at(place: str, error: RankdropError, file: str = "") -> OptionError:
    """The error of another reader, at the place of the specification that calls it."""
    where = error.where or file
    return OptionError(error.what, where=f"{place}: {where}" if where else place, got=error.got, allowed=error.allowed,
                       mend=error.mend)  # fmt: skip


def _task(head: Mapping[str, Any], drawing: Drawing) -> Task:
    try:
        task = resolve_task(head["task"], drawing.nominal, length_scale=head["length_scale"])
        return resolve_task(task, drawing.nominal, length_scale=task.scale(drawing.nominal))
    except RankdropError as error:
        raise OptionError(error.what, where="task", got=error.got, allowed=error.allowed, mend=error.mend) from error


def _parameters(table: Mapping[str, Any], drawing: Drawing) -> tuple[Parameter, ...]:
    _require(
        1 <= len(table) <= MOST_PARAMETERS,
        OptionError(
            "there are no parameters to vary" if not table else "there are too many parameters",
            where="parameters",
            got=len(table),
            allowed=f"1 … {MOST_PARAMETERS}: [parameters], then "
            'upper_arm = { sets = "JOINT.a", lower = 0.3, upper = 0.5, steps = 5 }',
        ),
    )
    parameters = tuple(_parameter(drawing, entry, f"parameters.{name}") for name, entry in table.items())
    taken: dict[tuple[str, str], str] = {}
    for parameter in parameters:
        for place in parameter.places:
            other = taken.setdefault((place.part, place.key), parameter.name)
            _require(
                other == parameter.name,
                OptionError(
                    "two parameters set the same number",
                    where=f"parameters.{parameter.name}",
                    got=f"{place.part}.{place.key}",
                    mend=f"leave it to {other}",
                ),
            )
    return parameters


def _parameter(drawing: Drawing, entry: Any, where: str) -> Parameter:
    name = where.partition(".")[2]
    _require(
        isinstance(entry, Mapping),
        OptionError(
            "a parameter is a table",
            where=where,
            got=repr(entry),
            allowed='{ sets = "JOINT.a", lower = …, upper = …, steps = … }',
        ),
    )
    for key in entry:
        _require(
            key in _PARAMETER, OptionError("unknown key", where=where, got=repr(key), allowed=", ".join(_PARAMETER))
        )
    sets = entry.get("sets")
    texts = [sets] if isinstance(sets, str) else sets
    _require(
        _are_texts(texts),
        OptionError(
            "sets says what a parameter sets",
            where=where,
            got=repr(sets),
            allowed='"elbow_joint.a", "-2.a", "tool.z", or a list of such',
        ),
    )
    places = tuple(drawing.place(text, where) for text in texts)
    measures = {drawing.measure(place) for place in places}
    _require(len(measures) == 1, OptionError("a parameter is a length or an angle", where=where, got=", ".join(texts)))
    measure = measures.pop()
    if "values" in entry:
        values = _values(entry["values"], measure, where)
        for key in ("lower", "upper", "steps"):
            _require(
                key not in entry, OptionError(f"{key} does not go with values", where=where, allowed="one of the two")
            )
        return Parameter(name, places, measure, values, min(values), max(values))
    for key in ("lower", "upper"):
        _require(key in entry, OptionError(f"{key} is missing", where=where, allowed="lower and upper, or values"))
    lower, upper = (quantity(entry[key], measure, where=where) for key in ("lower", "upper"))
    _require(
        lower < upper, OptionError("lower is not below upper", where=where, got=f"lower {lower:g}, upper {upper:g}")
    )
    if "steps" in entry:
        steps = _whole_number(entry["steps"], where, 2, 100_000, "steps")
    else:
        steps = 0
    values = tuple(lower + (upper - lower) * i / (steps - 1) for i in range(steps))
    return Parameter(name, places, measure, values, lower, upper)


def _values(given: Any, measure: str, where: str) -> tuple[float, ...]:
    _require(
        isinstance(given, list) and len(given) > 0,
        OptionError("values is a list", where=where, got=repr(given), allowed="values = [0.3, 0.4]"),
    )
    values = tuple(quantity(entry, measure, where=where) for entry in given)
    _require(len(set(values)) == len(values), OptionError("a value is given twice", where=where, got=repr(given)))
    return values


def _sample(
    head: Mapping[str, Any], parameters: tuple[Parameter, ...]
) -> tuple[str, int, tuple[tuple[float, ...], ...]]:
    """How variants are chosen, how many there are, and the values of a list."""
    table, listed = _read_table(head["sample"], "sample"), head["variants"]
    kind = table["kind"] or ("grid" if listed is None else "list")
    _require(
        kind in KINDS,
        OptionError("there is no such sample", where="sample.kind", got=repr(kind), allowed=", ".join(KINDS)),
    )
    _require(
        (kind == "list") == (listed is not None),
        OptionError(
            "a list of variants goes with the sample list, and only with it",
            where="sample.kind",
            got=repr(kind),
            allowed='kind = "list" and [[variants]] tables',
        ),
    )
    if kind == "list":
        rows = _variants(listed, parameters)
        return kind, len(rows), rows
    for parameter in parameters:
        where = f"parameters.{parameter.name}"
        _require(
            kind != "grid" or parameter.values != (),
            OptionError("a grid needs the values", where=where, allowed="steps, or values"),
        )
        _require(
            kind == "grid" or parameter.values == (),
            OptionError(
                f"a {kind} sample draws from a range", where=where, allowed="lower and upper, without steps or values"
            ),
        )
    if kind != "grid":
        return kind, _whole_number(table["variants"], "sample.variants", 1, MOST_VARIANTS), ()
    count = prod(len(parameter.values) for parameter in parameters)
    _require(
        count <= MOST_VARIANTS,
        OptionError("the grid has too many variants", where="parameters", got=count, allowed=MOST_VARIANTS),
    )
    return kind, count, ()


def _variants(listed: Any, parameters: tuple[Parameter, ...]) -> tuple[tuple[float, ...], ...]:
    names = [parameter.name for parameter in parameters]
    _require(
        isinstance(listed, list) and 1 <= len(listed) <= MOST_VARIANTS,
        OptionError("variants is a list of tables", where="variants", allowed="[[variants]], one or more"),
    )
    for index, entry in enumerate(listed):
        if isinstance(entry, Mapping):
            got = ", ".join(entry)
        else:
            got = repr(entry)
        _require(
            isinstance(entry, Mapping) and sorted(entry) == sorted(names),
            OptionError(
                "a variant gives every parameter", where=f"variants[{index}]", got=got, allowed=", ".join(names)
            ),
        )
    return tuple(_variant(entry, parameters, f"variants[{index}]") for index, entry in enumerate(listed))


def _variant(entry: Mapping[str, Any], parameters: tuple[Parameter, ...], where: str) -> tuple[float, ...]:
    """The values of one variant, in the order of the parameters."""
    return tuple(
        quantity(entry[parameter.name], parameter.measure, where=f"{where}.{parameter.name}")
        for parameter in parameters
    )


def _asks(head: Mapping[str, Any], folder: Path) -> Asks:
    asked = {name: _read_table(head[name], name) for name in ASKS if head[name] is not None}
    _require(
        asked != {}, OptionError("nothing is asked of the variants", allowed=", ".join(f"[{name}]" for name in ASKS))
    )
    if "region" in asked:
        low, high = asked["region"]["lower"], asked["region"]["upper"]
        _require(
            bool(np.all(np.less_equal(low, high))),
            OptionError("lower is not below upper", where="region.lower", got=repr(low)),
        )
    if "paths" in asked:
        asked["paths"] = {name: _poses(folder / name, name) for name in asked["paths"]["files"]}
    return Asks(**asked | ({"certified": asked["certified"]["width"]} if "certified" in asked else {}))


def _poses(file: Path, name: str) -> dict[str, Any]:
    """The poses (P, 4, 4) of a file and their times, as plain data."""
    try:
        poses = read_poses(file)
    except OSError as error:
        what = f"the file cannot be read: {error.strerror}"
        raise OptionError(what, where="paths.files", got=name[:80]) from error
    except RankdropError as error:
        raise _error_at("paths.files", error, name) from error
    return {"poses": poses.matrices.tolist(), "t": None if poses.times is None else poses.times.tolist()}


def _pareto(table: Mapping[str, Any], known: list[str]) -> dict[str, str]:
    """Measure -> "less" or "more"."""
    goals: dict[str, str] = {}
    for want, names in _read_table(table, "pareto").items():
        where = f"pareto.{want}"
        _require(
            isinstance(names, list),
            OptionError(f"{want} is a list of measures", where=where, got=repr(names), allowed=", ".join(known)),
        )
        for name in names:
            _require(name in known, OptionError("there is no such measure here", where=where, got=repr(name),
                                                allowed=", ".join(known)))  # fmt: skip
            _require(name not in goals, OptionError("the measure is given twice", where=where, got=repr(name)))
            goals[name] = want
    return goals


def finite(value: float | None) -> float | None:
    """The number, or None for what is none: JSON has no infinity."""
    if value is None or not isfinite(value):
        return None
    return float(value)
