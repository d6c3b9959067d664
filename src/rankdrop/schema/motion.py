"""Tables of the files of `path`, `aspects` and `through`."""

from __future__ import annotations

from math import isnan
from operator import attrgetter, itemgetter
from typing import Any, Literal

from msgspec import UNSET

from rankdrop.codec import (
    Count,
    Positive,
    list_of,
    nonempty,
    num,
    optional,
    pair,
    plain,
    row,
    table,
    text,
    whole,
)
from rankdrop.local.block import generic_rank
from rankdrop.schema.arm import ROBOT, TOLERANCES, file
from rankdrop.text.aspects import decision_text, rounding_notes
from rankdrop.text.programs import remedy_words, why_skipped
from rankdrop.text.remedies import GAINS as UNITS
from rankdrop.text.stretches import evidence_words
from rankdrop.version import VERSION

VERDICT = Literal["crossing", "touching", "cannot be followed", "outside limits", "too fast", "too near", "undecided",
                  "free"]
"""Of a path, worst first."""
_ARM = (ROBOT, "", lambda found: (found.robot, found.task, generic_rank(found.robot, found.task)))
_VERSION = (str, "of rankdrop", lambda _: VERSION)


def _settings(found: Any) -> dict[str, Any]:
    """The options of a result, with what else decides it."""
    return {**plain(found.options), "length_scale": float(found.task.scale(found.robot)), "version": VERSION,
            "tolerances": getattr(found, "tolerances", None)}  # fmt: skip


ASPECTS_SETTINGS = table(
    "aspects_settings",
    poses=Positive,
    most=optional(Positive),
    starts=Positive,
    seed=Count,
    limits=bool,
    length_scale=num("m", gt=0),
    version=str,
)
ASPECTS_EXACT = table(
    "aspects_exact",
    kind=Literal["signs", "no cusp", "cusps", "open"],
    words=(str, "why, in one sentence", decision_text),
    cusps=list_of(row(num("rad"), 2)),
    nodes=list_of(row(num("rad"), 2)) | None,
)
ASPECTS_SIGNS = table(
    "aspects_signs",
    signs=(list_of(Literal[-1, 1]), "of the factors"),
    at_least=(Count, "connected parts, proven", attrgetter("parts.at_least")),
    at_most=(Count, "", attrgetter("parts.at_most")),
    proven=(bool, "whether `at_most` is proven as well", attrgetter("parts.proven")),
)
ASPECTS_COUNT = table(
    "aspects_count",
    at_least=(Count, "aspects, proven"),
    at_most=(Count | None, "null where they were not counted"),
    proven=(bool, "whether `at_most` is proven as well"),
    factors=(list_of(str), "of det J, in s_j = sin θ_j and c_j = cos θ_j"),
    roles=(list_of(str), "part of the arm that each is of, or empty"),
    by_signs=(list_of(ASPECTS_SIGNS), "", attrgetter("each")),
    peeled=(list_of(Positive), "joints that were peeled off"),
    cells=(list_of(Positive), "joints in which cells were counted"),
    why=(Literal["sign", "joints", "slide", "factors", "work", "conditions"] | None,
        "it was not counted: a factor changes its sign over a turn, more than three joints or a slide are left, many "
        "factors, the limit on work, no exact conditions; null where it was",
        lambda count: count.left and count.left.value),
)
SOLUTIONS = table(
    "solutions",
    q=nonempty(num("joint")),
    aspect=(Positive, "equal numbers: in one aspect, by a path proven free or by the proven number of aspects"),
    sign=(Literal[-1, 1], "of det J"),
    name=str,
)
POSES = table(
    "poses",
    solutions=(nonempty(SOLUTIONS), "the first is the configuration that gave the pose",
        lambda solved: [dict(zip(("q", "aspect", "sign", "name"), row, strict=True))
                     for row in zip(solved.q, solved.aspect, solved.sign, solved.names, strict=True)]),
    per_aspect=(nonempty(Positive), "solutions in each aspect, most first"),
    near_cusp=(bool, "chosen next to a cusp, not at random"),
)
PATH = table(
    "path",
    q=(nonempty(nonempty(num("joint")), min_length=2),
        "corners, straight lines in joint space between them; the end is a solution up to whole turns"),
    from_q=(bool, "starts at the first solution of its pose", attrgetter("own")),
    clearance=(num("1", gt=0), "smallest |det J| at its sample points, J without unit"),
    evaluations=Positive,
)
ASPECTS_FILE = file(
    "aspects",
    "Written by `rankdrop aspects --json`: solutions of the inverse by the aspect they lie in, and a path from "
    "one to another without a singularity.",
    robot=_ARM,
    settings=(ASPECTS_SETTINGS, "", _settings),
    verdict=(Literal["cuspidal", "not cuspidal", "none found", "not asked"],
        "cuspidal: with a path that is proven free, or by the number of aspects; not cuspidal: proven; none found: no "
        "proof of absence; not asked: not as many joints as rows"),
    sentence=str,
    count=(optional(ASPECTS_COUNT), "of aspects, joint limits ignored"),
    within_limits=(optional(ASPECTS_COUNT), "with --limits: connected sets of regular configurations within the joint "
        "limits; absent where they were not asked for", lambda aspects: aspects.within or UNSET),
    exact=(ASPECTS_EXACT, "", attrgetter("decision")),
    poses=(list_of(POSES), "", attrgetter("solved")),
    path=(PATH | None, "", attrgetter("change")),
    notes=(list_of(str), "", rounding_notes),
    complete=(bool, "false: interrupted"),
)
ARM_POSTURE = table(
    "arm_posture",
    shoulder=(Literal["left", "right", "front", "back"] | None,
        "left or right of the line from axis 1 to the wrist, or the wrist in front of axis 1 or behind it; null where "
        "the arm has no such part, or it is singular"),
    elbow=(Literal["up", "down", "left", "right"] | None, "seen from the line from shoulder to wrist"),
    wrist=(Literal["not flipped", "flipped"] | None, "not flipped: joint 5 bends the tool down while joint 4 is at 0"),
)
BEYOND = table("beyond", joint=(Positive, "", itemgetter(0)), excess=(num("joint", ge=0), "", itemgetter(1)))
BRANCHES = table(
    "branches",
    q=nonempty(num("joint")),
    verdict=Literal["regular", "near", "singular", "always-singular"],
    sigma=(num("1", ge=0), "σ_r"),
    posture=(list_of(str), "signs of parts of the arm, such as elbow +"),
    arm_posture=(optional(ARM_POSTURE), "the same in the words of engineers, by parts of the arm", attrgetter("parts")),
    beyond=(list_of(BEYOND), "joints outside their limits, and by how much"),
    residual=(num("1", ge=0), "largest difference between its pose and the pose asked for [m, 1]"),
)
CONTINUA = table(
    "continua",
    q=(nonempty(num("joint")), "a configuration on it"),
    dimension=(Positive, "1: a curve"),
    closed=bool,
    complete=(bool, "followed to its closing or to both of its ends"),
    singular=(bool, "every configuration of it is singular"),
    lowest_q=(nonempty(num("joint")), "of each joint along it", attrgetter("lowest")),
    highest_q=(nonempty(num("joint")), "", attrgetter("highest")),
    inside=(num("1", ge=0, le=1), "share of the curve inside the joint limits"),
    beyond=list_of(BEYOND),
    residual=num("1", ge=0),
)
UNREACHED = table(
    "unreached",
    kind=(Literal["position", "orientation", "joints", "tilt", "edge"],
        "the position is out of reach; it is in reach but not with this orientation; the arm has too few joints; no "
        "joint tilts the tool, and the pose is tilted; the pose misses the edge of reach by rounding"),
    off_position=(num("m", ge=0), "least distance from the position, whatever the orientation",
        attrgetter("position")),
    off_shift=(num("m", ge=0) | None, "the same with the orientation kept; null where the arm does not make it",
        attrgetter("shift")),
    turn=(num("rad", ge=0) | None, "least angle from the orientation, the position kept; null: not reached; of a "
        "tilted pose the angle to the tilt of the tool"),
    tip=(list_of(list_of(num("1"))), "(4, 4) the reachable pose of the least distance"),
    q=(list_of(num("joint")), "a configuration that takes it, joint limits ignored", attrgetter("near")),
    turned_tip=(list_of(list_of(num("1"))) | None,
        "(4, 4) the reachable pose of the least angle", attrgetter("turned")),
)
INVERSE_FILE = file(
    "inverse",
    "Written by `rankdrop explain --pose --json`: the solutions of the inverse that were found for a pose, or how far "
    "it is out of reach. Joint limits do not restrict the search.",
    robot=_ARM,
    version=_VERSION,
    task=(str, "", lambda found: found.task.name),
    pose=(list_of(list_of(num("1"))), "(4, 4) of the tip in the base frame, translations in m"),
    sentence=str,
    branches=(list_of(BRANCHES), "isolated solutions"),
    continua=(list_of(CONTINUA), "self-motions: configurations along which the tool stands still"),
    more=(bool, "there may be self-motions that are not listed"),
    most=(Positive | None, "no such arm has more isolated solutions; null: not stated"),
    starts=(Count, "random starts of Newton's method"),
    arrived=(Count, "starts that ended on a solution"),
    seed=(Count, "", lambda found: found.options.seed),
    unreached=UNREACHED | None,
)
COLUMNS = table("columns", name=(str, "", itemgetter(0)), meaning=(str, "", itemgetter(1)))
PATH_ROWS_FILE = file(
    "path-rows",
    "Written by `rankdrop path --rows OUT.json`: a judged path row by row. The names of the columns end in their "
    "unit; null where there is no number.",
    robot=str,
    verdict=VERDICT,
    version=_VERSION,
    columns=(nonempty(COLUMNS), "", lambda rows: list(rows.about.items())),
    rows=(nonempty(list_of(num("column") | str | None)), "", lambda rows: list(map(list, rows.lines()))),
)
PATH_SETTINGS = table(
    "path_settings",
    interpolate=(Literal["linear", "cubic", "quintic"], "curve between two rows"),
    min_distance=(num("distance", ge=0), "to singular configurations that was asked for; 0 for none [rad]"),
    limits=(bool, "whether joint limits were judged"),
    evaluations=(Positive, "budget of enclosures"),
    length_scale=(num("m", gt=0), "translation rows were divided by it [m]"),
    tolerances=(TOLERANCES, "thresholds of rank"),
    version=(str, "of rankdrop"),
    frame=(optional(Literal["base", "tool", "link"]), "axes in which lost motions are reported"),
    tip_tolerance=(optional(num("m", gt=0)), "within which the tip of a tool path is proven to stay to its curve"),
    turn_tolerance=(optional(num("rad", gt=0)), "within which the turn of the tool is proven to stay to its curve"),
)
VIOLATIONS = table(
    "violations",
    what=(Literal["rate", "range"], "rate: too fast; range: outside the joint's range"),
    joint=(Positive, "number from 1"),
    place=(num("row", ge=1), "where the rate is largest, or the first row outside the range",
        attrgetter("place.position")),
    time=(num("s") | None, "of that place; null without times", attrgetter("place.time")),
    amount=(num("1", ge=0), "of a rate, a multiple of its limit; of a range, the largest excess [rad, m]"),
    rows=(Count, "rows outside the range"),
    proven=(bool, "the limit is exceeded; false: only a bound exceeds it"),
    name=(str, "of the nearest family"),
    distance=(num("distance", ge=0) | None, "from there to that family; null where none is known"),
)
OVERRUNS = table(
    "overruns",
    joint=(Positive, "number from 1"),
    rate=(num("joint/s", gt=0), "largest [rad/s, m/s]"),
    rate_limit=(num("joint/s", ge=0), "of the joint [rad/s, m/s]", attrgetter("limit")),
    seconds=(num("s", ge=0), "how long the joint exceeds it, all parts together"),
    travel=(num("joint", ge=0), "how far it moves in that time"),
    place=(num("row", ge=1), "where the rate is largest", attrgetter("place.position")),
    rows=(pair(num("row"), num("row")), "of the first and the last part above the limit",
        lambda overrun: [overrun.start.position, overrun.end.position]),
    times=(row(num("s"), 2), "the same in time", lambda overrun: [overrun.start.time, overrun.end.time]),
)
UNDECIDED = table(
    "undecided",
    time=(num("s", ge=0) | None,
        "of the parts that are neither free nor singular; null without times", attrgetter("undecided_time")),
    share=(num("1", ge=0, le=1), "of the length in joint space", attrgetter("undecided_share")),
    length=(num("distance", ge=0), "in joint space", attrgetter("undecided_length")),
)
PATH_CROSSINGS = table(
    "path_crossings",
    rows=(row(num("row", ge=1), 2), "rows from 1; the fraction is the share of the way to the next row"),
    time=(row(num("s"), 2) | None, "[s]; null without times"),
    poses=(optional(row(num("pose", ge=1), 2) | None), "of a file of poses: the poses of these rows; else null"),
    family=(str, "id of the family; empty where it is not of an atlas"),
    name=(str, "of the family"),
    corank=(Positive, "freedoms that are lost there"),
    q=(nonempty(num("joint")), "configuration at it"),
    touching=(bool, "no change of sign: singular within the tolerance"),
    lies=(bool, "all of it is singular wherever it was computed"),
    how=(str, "what shows it, in words"),
)
CLOSEST = table(
    "closest",
    row=(num("row", ge=1), "its row, with the share of the way to the next", attrgetter("place.position")),
    time=(num("s") | None, "null without times", attrgetter("place.time")),
    q=(nonempty(num("joint")), "configuration there"),
    distance_rad=(num("distance", ge=0) | None, "to the nearest singular configuration known; null where none is",
        attrgetter("distance")),
    singular_q=(list_of(num("joint")) | None,
        "the singular configuration that is nearest; null where none is known",
        lambda closest: closest.foot.tolist() or None),
    sigma=(num("1", ge=0), "σ_r there"),
    weak_share=(num("1", ge=0, le=1.000001) | None,
        "share of the tool's travel along the direction of the smallest singular value; null where it stands "
        "still", attrgetter("weak")),
)
STRETCHES = table(
    "stretches",
    rows=(row(num("row", ge=1), 2), "rows from 1; the fraction is the share of the way to the next row"),
    time=(row(num("s"), 2) | None, "[s]; null without times"),
    poses=(optional(row(num("pose", ge=1), 2) | None), "of a file of poses: the poses of these rows; else null"),
    family=(str, "id of the family; empty where it is not of an atlas"),
    name=(str, "of the family"),
    verdict=(Literal["free", "crossing", "touching", "undecided"], "of the stretch"),
    corank=(Count, "of the nearest singularity; 0 where none is known"),
    how=(str, "what shows it, in words"),
    closest=(CLOSEST, "its place nearest to a singularity"),
    lost=(list_of(str), "motions lost at that singularity, in words"),
    null_share=(num("1", ge=0, le=1.000001) | None, "share of the joints' motion there that does not move the task"),
    rates=(list_of(num("1", ge=0)) | None, "largest joint rates of the commanded motion; null without times"),
    speed_factor=(num("1", ge=0, le=1.000001) | None,
        "factor on the speed that keeps the velocity limits; null without times or limits"),
    slowest=(Positive | None, "number of the joint that decides it"),
)
PROFILE = table(
    "profile",
    position=(list_of(num("row", ge=1)), "row of each entry, with the share of the way to the next"),
    time=(list_of(num("s")) | None, "null without times"),
    distance=(list_of(num("distance", ge=0) | None), "to the nearest singular configuration known; null where none is"),
    family=(list_of(whole(ge=-1)), "index into ids of the nearest one; -1 for none"),
    sigma=(list_of(num("1", ge=0)), "σ_r"),
    rates=(list_of(num("1", ge=0) | None), "largest joint rate as a share of its limit; null without times or limits"),
    ids=(list_of(str), "ids of families"),
)
PARAMETERS = table(
    "parameters",
    name=(str, "what the remedy chooses", itemgetter(0)),
    value=(num("entry") | list_of(num("entry")), "one number, or one for each joint or axis", itemgetter(1)),
    unit=(str, "\"rad, m\": joint values", itemgetter(2)),
)
GAINS = table(
    "gains",
    what=(Literal["distance", "speed", "duration"],
        "distance to the nearest singular configuration known, factor of the speed that keeps the limits, "
        "duration"),
    before=(num("entry") | None, "of the path as it was; null where it is not known"),
    after=(num("entry") | None, "of the mended path"),
    unit=(str, "of both"),
)
LIMITS = table(
    "limits",
    rate=(num("1"), "share of the velocity limits"),
    acceleration=(num("1"), "share of the acceleration limits"),
    how=(str, "what shows it, in words"),
)
TOOL_OFF = table(
    "tool_off",
    m=(num("m"), "distance", itemgetter(0)),
    rad=(num("rad") | None, "angle; null where the task has no orientation", itemgetter(1)),
)
TRAJECTORY = table(
    "trajectory",
    interpolate=(Literal["linear", "cubic", "quintic"], "curve between two rows"),
    t=(list_of(num("s")) | None, "null without times",
        lambda trajectory: trajectory["times"] if trajectory["timed"] else None),
    q=(list_of(list_of(num("joint"))), "one row of joint values for each"),
    velocities=(list_of(list_of(num("joint/s"))) | None, "of each row; null where the file has none"),
    accelerations=(list_of(list_of(num("joint/s²"))) | None, "of each row; null where the file has none"),
)
CHANGES = table(
    "changes",
    rows=(list_of(num("row", ge=1)), "between them the joints are moved",
        lambda change: [change.start.position, change.end.position]),
    time=(list_of(num("s")) | None,
        "of these rows; null without times",
        lambda change: None if change.start.time is None else [change.start.time, change.end.time]),
    moved=(list_of(num("joint")), "how far each joint is from the old path at most", attrgetter("way")),
    at_end=(list_of(num("joint")), "how far it is at the end; 0: back on the old path, else on another branch"),
    tool_off=(TOOL_OFF, "how far the tool is from the old path at most", attrgetter("off")),
    longer=(num("s", ge=0), "how much longer it takes, of a slow-down"),
)
FAR_TURNS = table(
    "far_turns",
    joint=(int, "number from 1"),
    angle=(num("rad"), "how far it turns in one go"),
    rows=(list_of(num("row", ge=1)), "between which it turns", lambda turn: [turn.start.position, turn.end.position]),
    time=(list_of(num("s")) | None,
        "of these rows; null without times",
        lambda turn: None if turn.start.time is None else [turn.start.time, turn.end.time]),
)
FOUND = table(
    "found",
    kind=(Literal["null-space", "flip", "bump", "detour", "blend", "tool tilt", "base shift", "slow-down",
                 "retime"], "of the remedy"),
    words=(str, "the change, in words"),
    parameters=(list_of(PARAMETERS), "numbers of the remedy"),
    gains=(list_of(GAINS), "numbers before and after",
        lambda remedy: [{"what": what, "before": gain[0], "after": gain[1], "unit": UNITS[what][1]}
                     for what, gain in remedy.gains.items()]),
    verdict=(VERDICT,
        "of the mended path: free, but of retime, which keeps the path and is judged by its limits",
        attrgetter("check.verdict")),
    sentence=(str, "verdict of the mended path, in words", attrgetter("check.sentence")),
    limits=(LIMITS | None, "shares of the limits that it nowhere exceeds; null without times or limits",
        attrgetter("usage")),
    tool_off=(TOOL_OFF,
        "how far the tool is from its path between rows, measured in their middles; of a blend from the old "
        "path", attrgetter("off")),
    retimed=(bool, "it has a new time law"),
    changes=(list_of(CHANGES), "parts that a local remedy changes; outside them the path is as it was"),
    turns=(list_of(FAR_TURNS), "joints that turn far within a short part of the new path"),
    trajectory=(TRAJECTORY, "the mended path",
        lambda remedy: {**vars(remedy.trajectory), "interpolate": remedy.interpolate}),
)
REMEDIES = table(
    "remedies",
    needed=(bool, "the path is not proven free and far enough, or breaks limits"),
    sentence=(str, "what was found, in words"),
    found=(list_of(FOUND), "remedies, best first", attrgetter("remedies")),
    notes=(list_of(str), "kinds without a remedy: what was tried and what came of it"),
    complete=(bool, "false where it was interrupted"),
)
TURN = table(
    "turn",
    place=(num("pose", ge=1), "number of the pose at which it is made"),
    q=(list_of(num("joint")), "configuration before the turn"),
    to=(list_of(num("joint")), "and after it, the tool where it was"),
    rest_complete=(bool | None, "from there the tool path can be followed to its end"),
    rest_reached=(num("pose", ge=0), "last pose reached from there, with the share of the way to the next"),
)
PASSED = table(
    "passed",
    place=(num("pose", ge=1), "number of the pose, with the share of the way to the next"),
    rest=(bool, "the arm has to rest there; false: it may pass at any speed"),
)
TOOL_BRANCH = table(
    "tool_branch",
    start=(list_of(num("joint")), "configuration at the first pose"),
    posture=(list_of(str), "signs of parts of the arm, such as elbow +"),
    arm_posture=(optional(ARM_POSTURE), "the same in the words of engineers, by parts of the arm", attrgetter("parts")),
    complete=(bool, "it can be followed to the last pose"),
    reached=(num("row", ge=1), "last pose reached, with the share of the way to the next"),
    reason=(Literal["", "start", "singular", "limit", "turn", "few joints", "stuck", "budget"],
        "why it ends; empty where it does not"),
    joint=(Count, "number of the joint at its limit; 0 for other reasons"),
    free=(bool, "proven free of singularities up to where it ends"),
    place=(num("pose", ge=0), "pose where it is first not proven free; 0 where it is"),
    singular=(bool, "it is known to be singular there"),
    chosen=(bool, "the path takes it"),
)
TOOL = table(
    "tool",
    poses=(Positive, "number of poses in the file"),
    complete=(bool, "followed to the last pose"),
    reached=(num("row", ge=1), "last pose reached, with the share of the way to the next"),
    reason=(Literal["", "start", "singular", "limit", "turn", "few joints", "stuck", "budget"],
        "why it ended; empty where it did not"),
    words=(str, "why it ended"),
    start=(list_of(num("joint")), "configuration at the first pose"),
    chosen=(str, "how the branch was chosen"),
    off=(num("m", ge=0), "the tip is proven to stay within this distance of its curve"),
    turned=(optional(num("rad", ge=0)), "and within this angle"),
    passed=(optional(list_of(PASSED)), "singularities at which the branch goes on"),
    folds=(optional(bool), "the branch folds back where it ends: there is no solution near it further on"),
    turn=(optional(TURN | None), "the internal turn after which the path goes on, where the branch needs one"),
    branches=(optional(list_of(TOOL_BRANCH)), "every branch that was found at the first pose, followed for itself"),
)
def _part(stretch: Any, ends: tuple[Any, Any], check: Any) -> dict[str, Any]:
    """A stretch between two places of it as entries."""
    poses = [place.pose for place in ends if place.pose is not None]
    return {
        **vars(stretch), "rows": [place.position for place in ends],
        "time": None if ends[0].time is None else [place.time for place in ends], "how": evidence_words(stretch, check),
        "poses": poses or None,
        "q": stretch.closest.q, "touching": stretch.verdict == "touching", "rates": stretch.rates.tolist() or None,
        "slowest": stretch.slowest or None,
    }  # fmt: skip


PATH_FILE = file(
    "path",
    "Written by `rankdrop path --json`: a path judged at every one of its points. Rows and joints are numbered "
    "from 1; angles in rad, lengths in m; stretches worst first, crossings along the path.",
    robot=_ARM,
    settings=(PATH_SETTINGS, "what was asked for", _settings),
    rows=(Positive, "of the file"),
    verdict=(VERDICT, "of the whole path"),
    sentence=(text(min_length=1), "the verdict in words"),
    summary=(optional(list_of(str)), "the lines that the command prints first"),
    free_share=(num("1", ge=0, le=1), "of the length in joint space, proven free"),
    undecided=(UNDECIDED, "parts neither proven free nor singular", lambda check: check),
    min_distance=(Literal["kept", "violated", "not proven"] | None, "null where none was asked for",
        attrgetter("margin")),
    violations=(optional(list_of(VIOLATIONS)), "joint limits that the path breaks, or may break"),
    overruns=(optional(list_of(OVERRUNS)), "joints that exceed their rate limits, the one that exceeds its limit most "
        "first; empty where that is not proven"),
    crossings=(list_of(PATH_CROSSINGS),
        "places where the path is singular",
        lambda check: [_part(crossing, crossing.bracket, check) for crossing in check.crossings]),
    stretches=(list_of(STRETCHES),
        "parts of the path near one family each",
        lambda check: [_part(stretch, (stretch.start, stretch.end), check) for stretch in check.stretches]),
    profile=(PROFILE, "numbers along the path, for drawings; family: index into ids"),
    evaluations=(Count, "enclosures that were spent"),
    source=(Literal["catalogue", "analysis", "on the spot"], "of the families"),
    notes=(list_of(str), "remarks on the file and the arm"),
    complete=(bool, "false: interrupted"),
    remedies=(optional(REMEDIES), "only where remedies were asked for: what mends the path, each judged again",
        lambda _: UNSET),
    tool=(TOOL | None, "Where poses of the tip were given: how joint values were found; else null.",
        lambda check: check.tool and {**vars(check.tool), "words": check.why_ended, "chosen": check.tool.chosen,
                                      "start": check.tool.start}),
)
PATHS = table(
    "paths",
    file=(str, "its name"),
    verdict=(VERDICT | Literal["bad input"], "of the path in it"),
    sentence=(text(min_length=1), "the verdict in words"),
    rows=(Positive | None, "of the file; null where it could not be read"),
    free_share=(num("1", ge=0, le=1.000001) | None,
        "of the length in joint space, proven free; null where it could not be read"),
    met=(Count | None, "crossings and touches"),
    nearest_rad=num("distance", ge=0) | None,
    complete=(bool, "", lambda record: record["verdict"] != "bad input"),
)
PATHS_FILE = file(
    "paths", "Written by `rankdrop path --json` for several files or a folder: each path in short, worst first.",
    robot=(str, "", itemgetter(0)), paths=(list_of(PATHS), "", itemgetter(1)),
)  # fmt: skip
PROGRAM_MET = table(
    "program_met",
    line=(Positive, "of the program"),
    text=(str, "of that line"),
    kind=(Literal["joint", "line", "arc"], "of the move"),
    family=(str, "id of the family; empty where it is not of an atlas", attrgetter("stretch.family")),
    name=(str, "", attrgetter("stretch.name")),
    verdict=(VERDICT, "", attrgetter("stretch.verdict")),
    corank=(Positive, "", attrgetter("stretch.corank")),
    q=(nonempty(num("joint")), "", attrgetter("stretch.closest.q")),
)
PROGRAM_MOVES = table(
    "program_moves",
    line=(Positive, "of the program"),
    text=(str, "of that line"),
    kind=(Literal["joint", "line", "arc"], "joints in proportion, the tip straight, or the tip on a circle"),
    verdict=(VERDICT | None, "the worst of it; null where a part begins at its target, so that nothing leads there"),
    distance=(num("distance", ge=0) | None, "to the nearest singularity known"),
    family=str,
    name=str,
    joint=(Count, "number of the joint that turns most; 0 where none turns"),
    turn=(num("rad", ge=0), "by how much"),
    seconds=(num("s", ge=0) | None, "null where its speed is not known"),
    overruns=(optional(list_of(OVERRUNS)), "joints that exceed their rate limits in it; rows are those of its part"),
    assumed=(optional(list_of(Literal["tool", "external axes", "turns", "wrist", "configuration", "arrival",
                                      "half a turn"])),
             "what it is followed with, itself or as a move before it is: its verdict holds where that is so",
             lambda move: sorted(move.assumed)),
)
PROGRAM_SKIPPED = table(
    "program_skipped",
    line=(Positive, "of the program"),
    text=(str, "of that line"),
    reason=(Literal["variable", "changed", "expression", "incomplete", "pulses", "circle", "spline", "relative",
                     "after joint values", "after a pose", "relative turn", "offset", "ends early", "shifted",
                    "other move", "base frame", "routine", "branch", "loop", "call", "tool frame", "override", "other"],
        "why it was not read"),
    words=(str, "the reason in words", lambda skipped: why_skipped(skipped.reason)),
    moves=(bool, "the line moves the arm"),
)
PROGRAM_ENDED = table(
    "program_ended",
    line=(Positive, "of the move that cannot be followed", attrgetter("move.line")),
    text=(str, "of that line", attrgetter("move.text")),
    cause=Literal["out of reach", "no such posture", "branch ends", "no circle"],
    share=(num("1", ge=0) | None, "of a straight line that was followed; null for other causes",
        lambda ended: ended.branch and max(0.0, ended.branch.reached - 1.0)),
)
PROGRAM_PARTS = table(
    "program_parts",
    lines=(row(Positive, 2), "of its first and its last move",
        lambda part: [part.moves[0].line, part.moves[-1].line]),
    begins=(Literal["joints", "start", "before", "stated", "posture"],
        "how its first configuration is known: joint values; --start; the solution of a pose nearest to where the part "
        "before it ended; the posture that its target states; the posture that people use"),
    ended=(PROGRAM_ENDED | None, "where it ends before its last move does"),
    off=(num("m", ge=0), "the tip is proven to stay within this distance of its lines"),
    turned=(num("rad", ge=0), "and within this angle"),
    line_of=(list_of(Positive), "line of the program that each stretch between two rows of the path belongs to",
        lambda part: [part.moves[index].line for index in part.owner.tolist()]),
    path=(PATH_FILE | None, "its joint path, checked; null where its first target is out of reach",
        attrgetter("check")),
)
def _number(value: float) -> float | None:
    """A number that nan stands for none of."""
    if isnan(value):
        return None
    return value


PROGRAM_REMEDIES = table(
    "program_remedies",
    line=(Positive, "of the program", lambda pair: pair[0].move.line),
    text=(str, "of that line", lambda pair: pair[0].move.text),
    advice=(Literal["turn", "joint move", "slower", "bump", "detour", "out of reach", "none"], "what to do",
        lambda pair: str(pair[0].advice)),
    words=(str, "the same in a sentence", lambda pair: remedy_words(*pair)),
    turn=(TURN | None, "the internal turn that is made before the line", lambda pair: pair[0].turn),
    speed_share=(num("1", ge=0, le=1) | None, "of its speed, that keeps the joint limits; null for other advice",
        lambda pair: _number(pair[0].factor)),
    goal=(list_of(num("joint")) | None, "configuration at the target of a joint move", lambda pair: pair[0].goal),
    change=(CHANGES | None, "of the joint path of its part, by a bump or a detour", lambda pair: pair[0].change),
    line_shares=(pair(num("1"), num("1")), "shares of the line between which it is changed; 0 and 1 where it is not",
        lambda pair: pair[0].span),
    notes=(list_of(str), "why no bump and no detour was found", lambda pair: pair[0].notes),
)
PROGRAM_FILE = file(
    "program",
    "Written by `rankdrop path --json` for a robot program: the moves that were read, the lines that were not, and the "
    "joint path of every part without a gap.",
    robot=_ARM,
    version=_VERSION,
    language=(Literal["KRL", "RAPID", "URScript", "FANUC TP", "INFORM"], "", attrgetter("program.language")),
    verdict=(VERDICT, "the worst of all parts; undecided where moves were not read and all others are free"),
    sentence=text(min_length=1),
    summary=(list_of(str), "the lines that the command prints first"),
    tool=(optional(list_of(list_of(num("1"))) | None), "(4, 4) the tool at the flange [m] that the program states for "
        "all its moves, added to the arm; null: not known, several, or left out for that of the user",
        attrgetter("tool")),
    met=(list_of(PROGRAM_MET), "singularities on the way, in the order of the program"),
    moves=(list_of(PROGRAM_MOVES), "that were read and reached"),
    skipped=(list_of(PROGRAM_SKIPPED), "lines that were not read", attrgetter("program.skipped")),
    blended=(list_of(Positive), "lines with corners that the controller rounds; they are checked as exact stops",
        lambda found: [move.line for move in found.program.moves if move.blend]),
    raised=(num("m"), "height of the maker's base frame above that of the arm"),
    parts=list_of(PROGRAM_PARTS),
    complete=(bool, "false where it was interrupted"),
    remedies=(optional(list_of(PROGRAM_REMEDIES)), "of lines that end, are too fast or cross; only from the command",
        lambda _: UNSET),
)
MOTION = table(
    "motion", times=list_of(num("s")), s=list_of(num("1")),
    q=(list_of(list_of(num("joint"))), "", attrgetter("joints")),
)
THROUGH_FILE = file(
    "through",
    "Written by `rankdrop through --json`: whether a tool path through a singular configuration can be tracked, "
    "and with which time law.",
    robot=_ARM,
    version=_VERSION,
    q=nonempty(num("joint")),
    along=(nonempty(num("task")), "dx/ds, one number for each row of the task, in the base's axes"),
    bend=(nonempty(num("task")), "d²x/ds²"),
    kind=Literal["regular", "passes", "tangent", "turns back", "corner", "not trackable", "undecided"],
    sentence=str,
    trackable=(bool, "from one side of the configuration to the other"),
    order=(Positive | None, "k of s = c t^k; 1: any smooth law"),
    side=(Literal[-1, 0, 1], "of s, on which a path that turns back is tracked"),
    outside=(num("1", ge=-1.000001, le=1.000001), "share of the direction that is lost"),
    motion=(MOTION, "followed by finite motion; empty where there is none", lambda found: found),
    off=(num("1", ge=0), "largest deviation from the path, lengths by the length scale"),
    rate=(num("distance/s", ge=0), "largest joint rate under the law"),
    exponent=(num("1"), "measured power of |s| of the joint rates at constant path speed; 0 where they stay finite"),
    turn=(optional(TURN | None), "the internal turn after which a path that is not trackable from here goes on"),
)
