"""The specification of a sweep: which arm, which of its numbers are parameters, which variants, what is asked of each.

In TOML; the keys are described in docs/howto/comparing-designs.md. What cannot be used is refused before anything is
computed, in one line with file, line and what is allowed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, prod
from os.path import isfile
from pathlib import Path
from typing import Any

from rankdrop.errors import OptionError, RankdropError, RobotError
from rankdrop.families.searching import MOST_STARTS
from rankdrop.families.share import WIDEST
from rankdrop.motion.pose_file import read_poses
from rankdrop.robot.drawing import Drawing, Place
from rankdrop.robot.files import read_text
from rankdrop.robot.quantities import quantity
from rankdrop.robot.toml_file import Lines, line_of, lines_of, parsed_toml
from rankdrop.task import Task, resolve_task

KINDS = ("grid", "latin-hypercube", "sobol", "list")
MOST_VARIANTS = 1_000_000
MOST_PARAMETERS = 12
_HEAD = ("robot", "tip", "base", "as_written", "task", "length_scale", "limits", "seed", "parameters", "sample",
         "variants", "families", "near", "region", "paths", "certified", "pareto")  # fmt: skip
_TABLES = ("parameters", "sample", "families", "near", "region", "paths", "certified", "pareto")
ASKS = ("families", "near", "region", "paths", "certified")
Where = Callable[..., str]
"""where(table, key, index=None): file and line."""


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
    places: tuple[Place, ...]
    measure: str
    values: tuple[float, ...]
    lower: float
    upper: float

    @property
    def unit(self) -> str:
        """ "m" or "rad"."""
        return "m" if self.measure == "length" else "rad"


@dataclass(frozen=True)
class Asks:
    """What is asked of every variant; what is None is not asked for.

    Attributes:
        families: starts, fresh and exact.
        near: within [rad] and samples.
        region: lower, upper [m], rpy [rad] or None, points and starts.
        paths: name of each file -> its poses (P, 4, 4) [m] and times (P,) [s] or None.
        certified: width of the boxes [rad].
    """

    families: Mapping[str, Any] | None = None
    near: Mapping[str, Any] | None = None
    region: Mapping[str, Any] | None = None
    paths: Mapping[str, Any] | None = None
    certified: float | None = None


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
        asks: what is asked.
        pareto: measure -> "less" or "more"; empty for those that are asked.
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
        OptionError, RobotError: a key or a value cannot be used.
    """
    return _Reader(document, file, folder or Path("."), lines).spec()


def asks_of(document: Mapping[str, Any], *, file: str = "options", folder: Path | None = None) -> Asks:
    """What is asked, of tables alone: those of a specification without the arm.

    Raises:
        OptionError: as `spec_of`.
    """
    return _Reader(document, file, folder or Path("."), None).asks()


class _Reader:
    """Reads one document; every refusal names the file and the line."""

    def __init__(self, document: Mapping[str, Any], file: str, folder: Path, lines: Lines | None) -> None:
        self.document, self.file, self.folder, self.lines = document, file, folder, lines

    def where(self, table: str, key: str = "", index: int | None = None) -> str:
        name = ".".join(part for part in (table, key) if part)
        if self.lines is None:
            return f"{self.file}, {name}" if name else self.file
        titled = None if not key else self.lines.get((name, None, ""))  # [parameters.x] has a line of its own
        line = self.lines.get((table, index, key)) or titled or line_of(self.lines, table, index, key)
        return f"{self.file}, line {line}" + (f", {name}" if name else "")

    def refuse(self, what: str, table: str, key: str = "", *, got: Any = None, allowed: Any = None,
               mend: str | None = None) -> OptionError:  # fmt: skip
        """The error to raise."""
        return OptionError(what, where=self.where(table, key), got=got, allowed=allowed, mend=mend)

    def spec(self) -> Spec:
        self._keys(self.document, _HEAD, "")
        for name in _TABLES:
            if name in self.document and not isinstance(self.document[name], Mapping):
                raise self.refuse(f"{name} is a table", "", name, got=repr(self.document[name]), allowed=f"[{name}]")
        drawing = self._drawing()
        limits, seed = (
            self._flag(self.document, "limits"), self._whole_number(self.document, "seed", "", 0, 0, 2**63 - 1),
        )  # fmt: skip
        task = self._task(drawing)
        parameters = self._parameters(drawing)
        kind, count, listed = self._sample(parameters)
        asks = self.asks()
        return Spec(drawing, task, limits, seed, parameters, kind, count, listed, asks, self._pareto(asks))

    def _keys(self, table: Mapping[str, Any], allowed: Sequence[str], name: str, entry: str = "") -> None:
        for key in table:
            if key not in allowed:
                raise self.refuse("unknown key", name, entry or key, got=repr(key), allowed=", ".join(allowed))

    def _flag(self, table: Mapping[str, Any], key: str, name: str = "", *, default: bool = False) -> bool:
        value = table.get(key, default)
        if not isinstance(value, bool):
            raise self.refuse(f"{key} is true or false", name, key, got=repr(value), allowed="true, false")
        return value

    def _text(self, key: str) -> str | None:
        value = self.document.get(key)
        if value is not None and not (isinstance(value, str) and value):
            raise self.refuse(f"{key} is a text", "", key, got=repr(value))
        return value

    def _whole_number(
        self, table: Mapping[str, Any], key: str, name: str, default: int, least: int, most: int, *, entry: str = ""
    ) -> int:
        value = table.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise self.refuse(f"{key} is not a whole number that can be used", name, entry or key, got=repr(value),
                              allowed=f"{least} … {most}")  # fmt: skip
        return value

    def _number(self, value: Any, measure: str, table: str, key: str) -> float:
        try:
            return quantity(value, measure, where=self.where(table, key))
        except RobotError as error:
            raise OptionError(error.what, where=error.where, got=error.got, allowed=error.allowed) from None

    def _drawing(self) -> Drawing:
        name = self._text("robot")
        if name is None:
            raise self.refuse("the robot is not said", "", "robot", allowed='robot = "ur5", or a file')
        beside = self.folder / name
        try:
            return Drawing.of(
                str(beside) if isfile(beside) else name, self._text("tip"), self._text("base"),
                as_written=self._flag(self.document, "as_written"),
            )
        except RankdropError as error:
            place = self.where("", "robot")
            where = f"{place}: {error.where}" if error.where else place
            raise OptionError(error.what, where=where, got=error.got, allowed=error.allowed, mend=error.mend) from error

    def _task(self, drawing: Drawing) -> Task:
        scale = self.document.get("length_scale")
        length = None if scale is None else self._number(scale, "length", "", "length_scale")
        try:
            task = resolve_task(self._text("task"), drawing.nominal, length_scale=length)
            return resolve_task(task, drawing.nominal, length_scale=task.scale(drawing.nominal))
        except RankdropError as error:
            raise OptionError(error.what, where=self.where("", "task"), got=error.got, allowed=error.allowed) from error

    def _parameters(self, drawing: Drawing) -> tuple[Parameter, ...]:
        table = self.document.get("parameters", {})
        if not 1 <= len(table) <= MOST_PARAMETERS:
            raise self.refuse("there are no parameters to vary" if not table else "there are too many parameters",
                              "parameters", got=len(table), allowed=f"1 … {MOST_PARAMETERS}: [parameters], then "
                              'upper_arm = { sets = "JOINT.a", lower = 0.3, upper = 0.5, steps = 5 }')  # fmt: skip
        found = tuple(self._parameter(drawing, name, entry) for name, entry in table.items())
        taken: dict[tuple[str, str], str] = {}
        for one in found:
            for place in one.places:
                if (other := taken.setdefault((place.part, place.key), one.name)) != one.name:
                    raise self.refuse("two parameters set the same number", "parameters", one.name,
                                      got=f"{place.part}.{place.key}", mend=f"leave it to {other}")  # fmt: skip
        return found

    def _parameter(self, drawing: Drawing, name: str, entry: Any) -> Parameter:
        if not isinstance(entry, Mapping):
            raise self.refuse("a parameter is a table", "parameters", name, got=repr(entry),
                              allowed='{ sets = "JOINT.a", lower = …, upper = …, steps = … }')  # fmt: skip
        self._keys(entry, ("sets", "lower", "upper", "steps", "values"), "parameters", name)
        sets = entry.get("sets")
        texts = [sets] if isinstance(sets, str) else sets
        if not isinstance(texts, list) or not texts or not all(isinstance(one, str) for one in texts):
            raise self.refuse("sets says what a parameter sets", "parameters", name, got=repr(sets),
                              allowed='"elbow_joint.a", "-2.a", "tool.z", or a list of such')  # fmt: skip
        places = tuple(self._place(drawing, text, name) for text in texts)
        measures = {drawing.measure(place) for place in places}
        if len(measures) > 1:
            raise self.refuse("a parameter is a length or an angle", "parameters", name, got=", ".join(texts))
        measure = measures.pop()
        if "values" in entry:
            values = self._list(entry["values"], measure, name)
            for key in ("lower", "upper", "steps"):
                if key in entry:
                    raise self.refuse(f"{key} does not go with values", "parameters", name, allowed="one of the two")
            return Parameter(name, places, measure, values, min(values), max(values))
        for key in ("lower", "upper"):
            if key not in entry:
                raise self.refuse(f"{key} is missing", "parameters", name, allowed="lower and upper, or values")
        lower, upper = (self._number(entry[key], measure, "parameters", name) for key in ("lower", "upper"))
        if not lower < upper:
            raise self.refuse("lower is not below upper", "parameters", name, got=f"lower {lower:g}, upper {upper:g}")
        steps = self._whole_number(entry, "steps", "parameters", 0, 2, 100_000, entry=name) if "steps" in entry else 0
        values = tuple(lower + (upper - lower) * i / (steps - 1) for i in range(steps))
        return Parameter(name, places, measure, values, lower, upper)

    def _place(self, drawing: Drawing, text: str, name: str) -> Place:
        try:
            return drawing.place(text, self.where("parameters", name))
        except RobotError as error:
            raise OptionError(error.what, where=error.where, got=error.got, allowed=error.allowed) from None

    def _list(self, given: Any, measure: str, name: str) -> tuple[float, ...]:
        if not isinstance(given, list) or not given:
            raise self.refuse("values is a list", "parameters", name, got=repr(given), allowed="values = [0.3, 0.4]")
        values = tuple(self._number(one, measure, "parameters", name) for one in given)
        if len(set(values)) != len(values):
            raise self.refuse("a value is there twice", "parameters", name, got=repr(given))
        return values

    def _sample(self, parameters: tuple[Parameter, ...]) -> tuple[str, int, tuple[tuple[float, ...], ...]]:
        table = self.document.get("sample", {})
        self._keys(table, ("kind", "variants"), "sample")
        listed = self.document.get("variants")
        kind = table.get("kind", "grid" if listed is None else "list")
        if kind not in KINDS:
            raise self.refuse("there is no such sample", "sample", "kind", got=repr(kind), allowed=", ".join(KINDS))
        if (kind == "list") != (listed is not None):
            raise self.refuse("a list of variants goes with the sample list, and only with it", "sample", "kind",
                              got=repr(kind), allowed='kind = "list" and [[variants]] tables')  # fmt: skip
        if kind == "list":
            rows = self._variants(listed, parameters)
            return kind, len(rows), rows
        if kind == "grid":
            for one in parameters:
                if not one.values:
                    raise self.refuse("a grid needs the values", "parameters", one.name, allowed="steps, or values")
            count = prod(len(one.values) for one in parameters)
            if count > MOST_VARIANTS:
                raise self.refuse("the grid has too many variants", "parameters", got=count, allowed=MOST_VARIANTS)
            return kind, count, ()
        for one in parameters:
            if one.values:
                raise self.refuse(f"a {kind} sample draws from a range", "parameters", one.name,
                                  allowed="lower and upper, without steps or values")  # fmt: skip
        return kind, self._whole_number(table, "variants", "sample", 0, 1, MOST_VARIANTS), ()

    def _variants(self, listed: Any, parameters: tuple[Parameter, ...]) -> tuple[tuple[float, ...], ...]:
        names = [one.name for one in parameters]
        if not isinstance(listed, list) or not 1 <= len(listed) <= MOST_VARIANTS:
            raise self.refuse("variants is a list of tables", "variants", allowed="[[variants]], one or more")
        rows = []
        for index, entry in enumerate(listed):
            where = self.where("variants", "", index)
            if not isinstance(entry, Mapping) or sorted(entry) != sorted(names):
                got = ", ".join(entry) if isinstance(entry, Mapping) else repr(entry)
                raise OptionError("a variant gives every parameter", where=where, got=got, allowed=", ".join(names))
            rows.append(tuple(self._number(entry[one.name], one.measure, "variants", one.name) for one in parameters))
        return tuple(rows)

    def asks(self) -> Asks:
        asked = {name: self.document[name] for name in ASKS if name in self.document}
        if not asked:
            raise self.refuse("nothing is asked of the variants", "", allowed=", ".join(f"[{name}]" for name in ASKS))
        return Asks(**{name: getattr(self, f"_{name}")(table) for name, table in asked.items()})

    def _families(self, table: Mapping[str, Any]) -> dict[str, Any]:
        self._keys(table, ("starts", "fresh", "exact"), "families")
        return {"starts": self._whole_number(table, "starts", "families", 300, 10, MOST_STARTS),
                "fresh": self._whole_number(table, "fresh", "families", 300, 10, 20_000),
                "exact": self._flag(table, "exact", "families", default=True)}  # fmt: skip

    def _near(self, table: Mapping[str, Any]) -> dict[str, Any]:
        self._keys(table, ("within", "samples"), "near")
        within = self._number(table.get("within", "5 deg"), "angle", "near", "within")
        if not 0.0 < within <= WIDEST:
            raise self.refuse("this is no distance to look within", "near", "within", got=within,
                              allowed=f"above 0, up to {WIDEST} rad (86°)")  # fmt: skip
        return {"within": within, "samples": self._whole_number(table, "samples", "near", 2000, 100, 1_000_000)}

    def _region(self, table: Mapping[str, Any]) -> dict[str, Any]:
        self._keys(table, ("lower", "upper", "rpy", "points", "starts"), "region")
        corners = {key: self._three(table.get(key), "length", key) for key in ("lower", "upper")}
        if not all(low <= high for low, high in zip(corners["lower"], corners["upper"], strict=True)):
            raise self.refuse("lower is not below upper", "region", "lower", got=repr(table.get("lower")))
        rpy = self._three(table["rpy"], "angle", "rpy") if "rpy" in table else None
        return {**corners, "rpy": rpy, "points": self._whole_number(table, "points", "region", 40, 1, 100_000),
                "starts": self._whole_number(table, "starts", "region", 12, 1, 1000)}  # fmt: skip

    def _three(self, given: Any, measure: str, key: str) -> list[float]:
        if not isinstance(given, list) or len(given) != 3:
            raise self.refuse(f"{key} is three numbers", "region", key, got=repr(given), allowed="[x, y, z]"
                              if measure == "length" else "[roll, pitch, yaw]")  # fmt: skip
        return [self._number(one, measure, "region", key) for one in given]

    def _paths(self, table: Mapping[str, Any]) -> dict[str, Any]:
        self._keys(table, ("files",), "paths")
        files = table.get("files")
        if not isinstance(files, list) or not files or not all(isinstance(one, str) and one for one in files):
            raise self.refuse("files is a list of files of poses", "paths", "files", got=repr(files),
                              allowed='files = ["pick.csv"]')  # fmt: skip
        found: dict[str, Any] = {}
        for name in files:
            try:
                poses = read_poses(self.folder / name)
            except OSError as error:
                what = f"the file cannot be read: {error.strerror}"
                raise self.refuse(what, "paths", "files", got=name[:80]) from error
            except RankdropError as error:
                where = f"{self.where('paths', 'files')}: {error.where or name}"
                raise OptionError(error.what, where=where, got=error.got, allowed=error.allowed) from error
            found[name] = {"poses": poses.matrices.tolist(), "t": None if poses.times is None else poses.times.tolist()}
        return found

    def _certified(self, table: Mapping[str, Any]) -> float:
        self._keys(table, ("width",), "certified")
        width = self._number(table.get("width", 0.2), "angle", "certified", "width")
        if not 0.0 < width <= 1.0:
            raise self.refuse("this is no width of a box", "certified", "width", got=width,
                              allowed="above 0, up to 1 rad")  # fmt: skip
        return width

    def _pareto(self, asks: Asks) -> dict[str, str]:
        table = self.document.get("pareto", {})
        self._keys(table, ("less", "more"), "pareto")
        known = measures(asks)
        found: dict[str, str] = {}
        for want in ("less", "more"):
            names = table.get(want, [])
            if not isinstance(names, list):
                raise self.refuse(f"{want} is a list of measures", "pareto", want, got=repr(names),
                                  allowed=", ".join(known))  # fmt: skip
            for name in names:
                if name not in known or name in found:
                    raise self.refuse("there is no such measure here" if name not in known else "it is there twice",
                                      "pareto", want, got=repr(name), allowed=", ".join(known))  # fmt: skip
                found[name] = want
        return found


GOALS = {
    "families": "less", "near": "less", "sigma": "more", "reached": "more", "path_sigma": "more",
    "path_distance": "more", "paths_free": "more", "free": "more",
}  # fmt: skip
"""Every measure, and whether less or more of it is better."""
_MEASURES = {
    "families": ("families",), "near": ("near",), "region": ("sigma", "reached"),
    "paths": ("path_sigma", "path_distance", "paths_free"), "certified": ("free",),
}  # fmt: skip


def measures(asks: Asks) -> list[str]:
    """The measures that there are where this is asked: the columns of the table."""
    return [name for ask in ASKS if getattr(asks, ask) is not None for name in _MEASURES[ask]]


def goals(spec: Spec) -> dict[str, str]:
    """What a better variant has less or more of: as given, else every measure but the number of families."""
    return dict(spec.pareto) or {name: GOALS[name] for name in measures(spec.asks) if name != "families"}


def finite(value: float | None) -> float | None:
    """The number, or None for what is none: JSON has no infinity."""
    return None if value is None or not isfinite(value) else float(value)
