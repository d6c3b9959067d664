"""Tables of the files of `sweep`, `compare` and `jacobian`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter, itemgetter
from typing import Any, Literal

from rankdrop.codec import Count, Positive, list_of, mapping, nonempty, num, optional, row, table
from rankdrop.robot.arm_reach import reach
from rankdrop.schema.arm import INSIDE_PINNED, ROBOT, file
from rankdrop.schema.families import ASPECTS_SUMMARY
from rankdrop.task import ROWS
from rankdrop.text.designs import MEANINGS, UNITS
from rankdrop.version import VERSION

SHORTEST = table(
    "shortest",
    terms=(int, "in all entries", itemgetter(0)),
    frame=(int, "link that gives the axes", itemgetter(1)),
    at=(int | None, "link with its origin at the reference point; null for the tip", itemgetter(2)),
)
ENTRIES = table(
    "entries",
    text=(str, "", lambda entry: entry[0].text()),
    latex=(str, "", lambda entry: entry[0].latex()),
    python=(str, "", lambda entry: entry[0].code(entry[1])),
)
INVERSE = table(
    "inverse",
    determinant=(str, "", lambda jacobian: jacobian.closed.determinant.text()),
    entries=(list_of(list_of(ENTRIES)), "one list per joint", attrgetter("inverse_code")),
)
NUMBERS = table(
    "numbers",
    q=list_of(num("joint")),
    matrix=list_of(list_of(num("screw"))),
    determinant=num("product") | None,
    inverse=list_of(list_of(num("rate"))) | None,
    sigma=(list_of(num("1")), "singular values, lengths in metres"),
)
CHECKS = table(
    "checks",
    what=str,
    holds=bool,
    worst=(num("1") | None, "largest relative difference; null for an exact check"),
)
JACOBIAN_FILE = file(
    "jacobian",
    "The Jacobian seen from a link: written by `rankdrop jacobian --json`.",
    robot=(ROBOT, "", lambda jacobian: (jacobian.robot, jacobian.task, min(jacobian.task.m, jacobian.robot.n))),
    frame=(Positive, "link that gives the axes"),
    at=(int | None, "link with its frame's origin at the reference point; null for the tip"),
    rows=(list_of(str), "of the task, vx … wz", lambda jacobian: [ROWS[row] for row in jacobian.task.rows]),
    letters=(mapping(num("m")), "value of each length that is a letter [m]"),
    shifts=(nonempty(num("joint")), "θ = q + shift, per joint [rad, m]"),
    matrix=(list_of(list_of(str)), "entries as text, one list per row; empty where numbers alone were asked for",
        lambda jacobian: jacobian.texts()),
    latex=(str, "matrix, determinant and inverse as displayed formulas",
        lambda jacobian: jacobian.latex() if jacobian.rows else ""),
    shortest=(list_of(SHORTEST), "terms of all axes and reference points, the shortest first"),
    inverse=(INVERSE | None, "in closed form; null where it was not asked for",
        lambda jacobian: jacobian.closed and jacobian),
    numbers=(NUMBERS | None,
        "at the configuration of --q; the inverse is null where it was not asked for, and at singular "
        "configurations"),
    checks=list_of(CHECKS),
    holds=(bool, "whether every check does"),
)
MEASURES = table(
    "measures",
    name=(str, "", str),
    unit=(str, "", UNITS.__getitem__),
    meaning=(str, "", MEANINGS.__getitem__),
)
_PIN = tuple[Positive, bool, list_of(num("deg or m")), Count]  # type: ignore[misc,valid-type]
_STRUCTURE = tuple[Positive, Count, list_of(_PIN), list_of(Positive)]  # type: ignore[misc,valid-type]
FAMILY_PARTS = table("family_parts", parts=list_of(str), either=bool, base=bool)
ARMS_FAMILY = table(
    "arms_family",
    id=str,
    key=(str, "what the family is, apart from the arm's lengths"),
    structure=(optional(_STRUCTURE),
        "the same as data: corank, dimension, pinned joints, coupled joints; of a pinned joint its number, whether it "
        "slides, values that do not depend on lengths, and how many others it has"),
    name=str,
    called=(optional(dict[str, Any]), "the name as facts, as in an analysis; since 0.3"),
    about=(optional(FAMILY_PARTS), "parts of the arm that it is about; since 0.3"),
    corank=Positive,
    dimension=Count,
    pinned=list_of(INSIDE_PINNED),
    free=list_of(int),
    coupled=list_of(int),
    conditions=list_of(str),
    named=bool,
    sound=row(int, 2),
    explained=row(int, 2),
    witness=list_of(num("joint")),
)
NEAR_SHARE = table("near_share", id=str, share=num("1"), error=num("1"), interval=row(num("1"), 2), bound=bool)
ARMS_NEAR = table(
    "arms_near",
    any=NEAR_SHARE,
    families=list_of(NEAR_SHARE),
    samples=(optional(Positive), "random configurations, the same for every variant"),
    hits=(optional(str), "which of them are near any family: a bit each, as hexadecimal digits, the first one highest"),
)
ARMS_SLOW = table(
    "arms_slow",
    share=num("1", ge=0, le=1),
    error=(num("1", ge=0), "standard error"),
    bound=(bool, "true: the share may be larger"),
    samples=Positive,
    interval=(optional(row(num("1"), 2)), "95 %, by Wilson's rule; since 0.3"),
    tool_speed=(optional(num("m/s", gt=0)), "of straight translations; since 0.3"),
    turn_speed=(optional(num("rad/s", ge=0)), "of rotations about the tool point, 0 where they do not count; since "
        "0.3"),
    seed=(optional(Count), "of the configurations, uniform in each joint inside its limits; since 0.3"),
    hits=(str, "which configurations are slow, as those of near"),
)
SLOW_POSES = table(
    "slow_poses",
    slower_than=num("m/s", gt=0),
    share=(num("1", ge=0, le=1), "of the poses reached"),
    interval=(row(num("1"), 2), "95 %, by Wilson's rule"),
    bound=(bool, "true: the share may be larger"),
    reached=Positive,
    seed=Count,
    poses=(Positive, "of the region, uniform in the box"),
    hits=(str, "which poses are slow, as those of near"),
)
REGION = table(
    "region",
    poses=int,
    reached=int,
    each=(optional(list_of(num("1") | None)), "σ of the best posture at each pose; null where none was found"),
    lowest=num("1") | None,
    sigma=(num("1") | None, "smallest σ of a best posture found"),
    at=list_of(num("m")) | None,
    q=list_of(num("joint")) | None,
    sigma_lower=(optional(num("1") | None), "proven: σ of the best posture is at least this at every pose of the box"),
    sigma_upper=(optional(num("1") | None),
        "proven: σ of the best posture is at most this at some pose of the box; null where nothing is proven"),
    covered=(optional(bool | None), "every pose of the box is proven to be reached"),
    narrow=(optional(bool | None), "the two bounds are near each other; else their budget was spent"),
    slow=optional(SLOW_POSES | None),
    tested=(optional(int | None), "cells of the box and boxes of joint space tested"),
)
ARMS_PATH = table(
    "arms_path",
    name=str,
    verdict=str,
    sigma=num("1") | None,
    distance=num("distance") | None,
    q=list_of(num("joint")) | None,
    why=str,
)
CERTIFIED = table("certified", free=num("1"), boxes=int, complete=bool)
_MEASURED: dict[str, Any] = {
    "measures": (mapping(num("entry") | None), "null where it could not be had"),
    "error": str | None,
    "verdict": optional(Literal["verified", "incomplete", "unsound", "contradicted"]),
    "sentence": optional(str),
    "rank": optional(int),
    "families": optional(list_of(ARMS_FAMILY)),
    "aspects": optional(ASPECTS_SUMMARY),
    "near": optional(ARMS_NEAR),
    "slow": optional(ARMS_SLOW | None),
    "region": optional(REGION),
    "paths": optional(list_of(ARMS_PATH)),
    "certified": optional(CERTIFIED),
}
ARMS = table(
    "arms",
    name=str,
    about=str,
    joints=int,
    reach=num("m"),
    **_MEASURED,
)

SWEEP_PARAMETERS = table(
    "sweep_parameters",
    name=str,
    unit=Literal["m", "rad"],
    sets=(list_of(str), "places in the arm", lambda parameter: [str(place) for place in parameter.places]),
    lower=num("entry"),
    upper=num("entry"),
)
STRUCTURES = table(
    "structures",
    families=(list_of(str), "", lambda structure: structure.keys),
    variants=(list_of(int), "counted from 1", lambda structure: [i + 1 for i in structure.variants]),
    ranges=list_of(list_of(num("entry"))),
)
CHANGES = table(
    "changes",
    kind=Literal["appears", "vanishes", "splits", "join"],
    before=list_of(str),
    after=list_of(str),
    variants=(row(int, 2), "counted from 1", lambda change: [change.first + 1, change.second + 1]),
    parameter=(str | None, "the one that differs; null where several do", lambda change: change.parameter or None),
    between=(list_of(num("entry")) | None, "its values",
        lambda change: [change.low, change.high] if change.parameter else None),
)
EXACT_FAMILIES = table("exact_families", id=str, name=str, corank=int, conditions=list_of(str), real=str)
SWEEP_EXACT = table(
    "sweep_exact",
    variant=int,
    letters=mapping(num("m")),
    families=list_of(EXACT_FAMILIES),
    not_real=list_of(str),
)
VARIANTS = table(
    "variants",
    number=(Positive, "", lambda variant: variant["number"] + 1),
    values=list_of(num("entry")),
    **_MEASURED,
)

TableColumn = tuple[str, str, str, Callable[[Mapping[str, Any]], Any]]
"""Of a Parquet table: name, type, meaning, and the value from a record."""
FAMILY_COLUMNS: list[TableColumn] = [
    ("variant", "int64", "number of the variant, from 1", lambda family: family["variant"]),
    ("family", "string", "id of the family in its variant", lambda family: family["id"]),
    ("key", "string", "what it is, apart from the arm's lengths", lambda family: family["key"]),
    ("name", "string", "its name", lambda family: family["name"]),
    ("corank", "int64", "rank lost on it", lambda family: family["corank"]),
    ("dimension", "int64", "of it in joint space", lambda family: family["dimension"]),
    ("conditions", "string", "of its coupled joints, one a line", lambda family: "\n".join(family["conditions"])),
    ("sound", "int64", "solutions of its conditions that are singular", lambda family: family["sound"][0]),
    ("tested", "int64", "solutions of its conditions", lambda family: family["sound"][1]),
    ("share", "float64", "share of the joint space near it; null where not asked for",
     lambda family: family["share"] and family["share"]["share"]),
    ("share_error", "float64", "standard error of the share",
     lambda family: family["share"] and family["share"]["error"]),
]  # fmt: skip
"""Of the table of families."""


def _version(_: Any) -> str:
    return VERSION


def _arms(compared: Any) -> list[dict[str, Any]]:
    columns = zip(compared.names, compared.robots, compared.records, strict=True)
    return [{**record, "name": name, "about": robot.about, "joints": robot.n, "reach": float(reach(robot))}
            for name, robot, record in columns]  # fmt: skip


SIDE_BY_SIDE_FILE = file(
    "side-by-side",
    "Written by `rankdrop compare --json`: arms side by side, measured for the same task.",
    version=(str, "of rankdrop", _version),
    task=(str, "", lambda compared: compared.task.name),
    length_scale=(num("m", gt=0), "", lambda compared: float(compared.task.length_scale)),
    limits=bool,
    seed=Count,
    sentence=str,
    holds=bool,
    measures=list_of(MEASURES),
    arms=(list_of(ARMS), "", _arms),
)
SWEEP_FILE = file(
    "sweep",
    "Written by `rankdrop sweep --json`: variants of an arm, measured for the same task. Variants and joints are "
    "numbered from 1; angles in rad, lengths in m.",
    robot=str,
    sample=(Literal["grid", "latin-hypercube", "sobol", "list"], "how variants were chosen",
        lambda designs: designs.spec.kind),
    version=(str, "of rankdrop", _version),
    task=(str, "", lambda designs: designs.spec.task.name),
    length_scale=(num("m", gt=0), "", lambda designs: float(designs.spec.task.length_scale)),
    limits=(bool, "", lambda designs: designs.spec.limits),
    seed=(Count, "", lambda designs: designs.spec.seed),
    sentence=str,
    summary=(optional(list_of(str)), "the lines that are printed first"),
    holds=bool,
    measures=list_of(MEASURES),
    parameters=list_of(SWEEP_PARAMETERS),
    goals=(mapping(Literal["less", "more"]), "", lambda designs: designs.spec.goals),
    pareto=(list_of(Positive), "variants not dominated by any other beyond the error",
        lambda designs: [number + 1 for number in designs.pareto]),
    pareto_differ=(optional(bool), "some of them differ from one another beyond the error",
        lambda designs: designs.ranking.differ),
    structures=list_of(STRUCTURES),
    changes=list_of(CHANGES),
    exact=list_of(SWEEP_EXACT),
    variants=(list_of(VARIANTS), "", lambda designs: designs.records),
)


def variant_columns(parameters: Sequence[Any], measures: Sequence[str]) -> list[TableColumn]:
    """Columns of the table of variants: number, parameters, measures, verdict, error."""
    return [
        ("variant", "int64", "number of the variant, from 1", lambda record: record["number"] + 1),
        *((f"{parameter.name}_{parameter.unit}", "float64", f"parameter, sets {', '.join(map(str, parameter.places))}",
           lambda record, k=k: record["values"][k]) for k, parameter in enumerate(parameters)),
        *((name, "float64", "; ".join(filter(None, (MEANINGS[name], UNITS[name]))),
           lambda record, name=name: record["measures"].get(name)) for name in measures),
        ("verdict", "string", "of its families; null where they were not asked for",
         lambda record: record.get("verdict")),
        ("error", "string", "why it could not be measured as a whole; null where it was",
         lambda record: record["error"]),
    ]  # fmt: skip
