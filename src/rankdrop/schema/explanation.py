"""Tables of the files of `explain`, `escape`, `nearest` and `tolerant`."""

from __future__ import annotations

from operator import attrgetter
from typing import Any, Literal

from msgspec import UNSET

from rankdrop.codec import (
    Count,
    Positive,
    list_of,
    meanings,
    nonempty,
    num,
    optional,
    pair,
    plain,
    row,
    table,
)
from rankdrop.configuration import Rank
from rankdrop.distance.tolerant import LockedJoint, SelfMotions, TolerantPlace
from rankdrop.local.circuits import Circuit
from rankdrop.local.cofactors import Hunt, HuntJoint
from rankdrop.local.ellipsoids import Ellipsoid, Ellipsoids, Index, PartSet
from rankdrop.local.nearest import Nearest
from rankdrop.local.ordered import OrderedSubset
from rankdrop.local.orientation import Representation, Representations
from rankdrop.local.rates import DirectionRates, Rates
from rankdrop.local.redundant import RankNullity, Redundancy
from rankdrop.local.relations import Relation
from rankdrop.local.screw_systems import ScrewSystem
from rankdrop.local.screws import Screw
from rankdrop.local.slowest import StraightMotion
from rankdrop.local.special import Special
from rankdrop.local.ways_out import Direction, Escape, JointEscape, LostMotion
from rankdrop.results.explained import Summary
from rankdrop.schema.arm import ARM_OF, FRAME, MOVED, PINNED, ROBOT, TOLERANCE, TOLERANCES, file
from rankdrop.text.family_conditions import local_conditions
from rankdrop.text.lost_directions import lost_text
from rankdrop.text.procedure import hunt_words
from rankdrop.text.verdict import sentence_of, summary_lines
from rankdrop.text.words import avoidable_words, boundary_words, lost_type
from rankdrop.version import VERSION

ESCAPE_SETTINGS = table(
    "escape_settings",
    near=(num("distance", ge=0), "near within this distance [rad]", attrgetter("options.near")),
    small=(num("1", ge=0), "σ_r at or below it is small", attrgetter("options.small")),
    limits=(bool, "", attrgetter("options.limits")),
    evaluations=(Count, "budget of the certified radius", attrgetter("options.evaluations")),
    step=(num("distance", ge=0), "of the motions tried [rad; slides in length scales]", attrgetter("options.step")),
    seed=(Count, "", attrgetter("options.seed")),
    length_scale=(num("m", gt=0), "translation is divided by it [m]"),
    tolerances=(TOLERANCES, "", attrgetter("here.tolerances")),
    version=(str, "of rankdrop", lambda _: VERSION),
    frame=(optional(Literal["base", "tool", "link", ""]),
        "axes in which motions are reported; empty: base, tool, and a link where they are simpler there",
        lambda explanation: explanation.options.frame or ""),
    slow=(optional(num("m/s", ge=0)), "a straight translation slower than this is slow; 0 for none",
        attrgetter("options.speed")),
    slow_turn=(optional(num("rad/s", ge=0)), "a straight rotation slower than this is slow; 0 for none",
        attrgetter("options.turn_speed")),
)
CIRCUIT = table(
    "circuit",
    of=Circuit,
    numbers=nonempty(Positive),
    coefficients=list_of(num("entry")),
    units=list_of(Literal["rad", "m"]),
    sigma=num("1", ge=0),
)
ORDERED = table("ordered", of=OrderedSubset, first=Positive, last=Positive, dimension=Count, loss=Positive)
SYSTEMS = table(
    "systems", of=ScrewSystem, numbers=list_of(Positive), dimension=Count, members=None,
    words=(str, "the whole in English."),
)  # fmt: skip
HUNT_JOINTS = table("hunt_joints", of=HuntJoint, number=Positive, share=num("1", ge=0, le=1), rate=num("1/distance"))
HUNT = table(
    "hunt", of=Hunt, shape=None, lost=None, matrix=list_of(list_of(num("1"))),
    words=(str, "why not; else whom it names, and whether finite motion agrees", hunt_words),
)  # fmt: skip
BLAME = table(
    "blame",
    circuits=(list_of(CIRCUIT), "all of `circuits`"),
    smallest=(list_of(CIRCUIT), "the smallest special ones from which all dependencies follow"),
    ordered=list_of(ORDERED),
    systems=list_of(SYSTEMS),
    always=(str | None, "why the arm is deficient everywhere"),
    complete=(bool, "false: only the first 1,000 circuits are listed, of more than 20 joints none"),
    hunt=(optional(HUNT | None), "Hunt's matrix of cofactors; null where nothing is lost"),
)
WAY = table(
    "way",
    of=JointEscape,
    number=Positive,
    gain=Count,
    order=Positive | None,
    rate=num("1/joint^order"),
    first_order=list_of(num("1/distance")),
    receptors=list_of(Positive),
    measured_gain=int,
    step=num("joint"),
    sigma_after=num("1", ge=0),
)
DIRECTION = table(
    "direction",
    of=Direction,
    delta=list_of(num("joint")),
    numbers=list_of(Positive),
    gain=int,
    order=Positive | None,
    rate=num("1/distance^order"),
    step=num("distance"),
    sigma_after=num("1", ge=0),
    measured_gain=int,
)
LOST_MOTION = table(
    "lost_motion", of=LostMotion, direction=row(num("1"), 6), type=Literal[1, 2], form=list_of(num("1")),
    words=(str, "", lambda lost: lost_type(lost.type)),
)  # fmt: skip
ESCAPE = table(
    "escape",
    of=Escape,
    corank=Count,
    floor=num("1", ge=0),
    types=list_of(LOST_MOTION),
    avoidable_words=(str, "", avoidable_words),
    avoidable_reason=optional(str),
    still_error=optional(num("1", ge=0)),
    boundary_words=(str, "", boundary_words),
    boundary_reason=optional(str),
    nearby=optional(bool),
)
_ASKED: dict[str, Any] = {
    "robot": (ROBOT, "", lambda explanation: (explanation.robot, explanation.task, explanation.rank.generic_rank)),
    "settings": (ESCAPE_SETTINGS, "what was asked for", lambda explanation: explanation),
    "q": (list_of(num("joint")), "the given configuration [rad, m]"),
    "outside_limits": (list_of(Positive), "joints beyond a limit"),
    "at_limits": (list_of(Positive), "joints that stand at a limit"),
    "verdict": Literal["regular", "near", "singular", "always-singular"],
    "reason": str,
    "rank": (Count, "", attrgetter("rank.rank")),
    "generic_rank": (Count, "almost everywhere", attrgetter("rank.generic_rank")),
    "corank": (Count, "task freedoms lost: generic_rank - rank", attrgetter("rank.corank")),
    "nullity": (Count, "joint motions that leave the task still: n - rank", attrgetter("rank.nullity")),
    "sigma": (list_of(num("1", ge=0)), "descending; translation divided by the length scale", attrgetter("rank.sigma")),
}
_WAYS: dict[str, Any] = {
    "circuits": (list_of(nonempty(Positive)), "inclusion-minimal dependent sets of joints; all where `blame.complete`",
        lambda explanation: [circuit.numbers for circuit in explanation.blame.circuits]),
    "blame": (BLAME, "which joints make the dependency"),
    "escape": (ESCAPE, "how to get out"),
}
STRAIGHT_MOTION = table(
    "straight_motion",
    of=StraightMotion,
    unit=Literal["m/s", "rad/s"],
    speed=num("entry", ge=0) | None,
    limit=num("entry", ge=0),
    direction=row(num("1"), 3),
    number=Positive,
)
SPECIAL = table(
    "special",
    of=Special,
    joint=Positive,
    value=num("rad"),
    off=num("rad", ge=0),
)
SUMMARY = table(
    "summary",
    of=Summary,
    distance=num("distance", ge=0) | None,
    length=num("m", ge=0),
    angle=num("rad", ge=0),
    pinned=list_of(pair(Positive, num("joint"))),
    lost=list_of(row(num("1"), 6)),
    slowest=STRAIGHT_MOTION | None,
    way_out=(list_of(pair(Positive, num("joint"))), "(joint, step) of one or two joints, one after the other"),
    regular_after=(optional(bool), "the verdict after them is regular"),
    sigma_after=num("1", ge=0) | None,
    next_distance=num("distance", ge=0) | None,
    next_searches=(optional(Count), "searches for it; 0 for none"),
    source=Literal["catalogue", "analysis", "on the spot"],
    radius=num("distance", ge=0) | None,
    place=(optional(list_of(SPECIAL)), "parts of the arm that are special at the singularity"),
    next_place=(optional(list_of(SPECIAL)), "the same at the next one"),
    crosses=(optional(bool), "the way out passes another singularity"),
    text=(nonempty(str),
        "five sentences: the configuration, the lost motion, the way out, the next singularity, how sure"),
)
_SUMMARY = {
    "summary": (optional(SUMMARY), "the answer: facts, then five sentences",
                lambda explanation: plain(explanation.summary) | {"text": summary_lines(explanation)}),
}  # fmt: skip
ESCAPE_FILE = file(
    "escape",
    "Written by `rankdrop escape --json`: the entries of an explanation that lead out. Twists are (v; ω), linear "
    "part first, in the task's frame.",
    **_ASKED,
    **_SUMMARY,
    **_WAYS,
    disagreements=(list_of(str), "one sentence for each pair of methods that differ; empty when all is well"),
    lie=(dict[str, Any] | None, "with --lie: the procedure of Gallardo-Alvarado and Rico-Martínez, step by step",
        lambda _: None),
)
EXPLANATION_FAMILY = table(
    "explanation_family",
    id=(str | None, "of the analysis; null where found on the spot", lambda incidence: incidence.family.id or None),
    name=(str, "", attrgetter("family.name")),
    corank=(Positive, "", attrgetter("family.corank")),
    dimension=(Count, "in joint space", attrgetter("family.dimension")),
    pinned=(list_of(PINNED), "joints with fixed values [rad, m]", attrgetter("family.pinned")),
    free=(list_of(Positive), "joints that do not matter", attrgetter("family.free")),
    coupled=(list_of(Positive), "joints tied together", attrgetter("family.coupled")),
    conditions=(list_of(str), "for reading",
        lambda incidence: list(map(str, incidence.family.equations)) or local_conditions(incidence.family)),
    equations=(list_of(str), "expressions in q1 … qn, sin, cos, pi that vanish on the family",
        attrgetter("family.equations")),
    residual=(num("distance", ge=0), "distance of the configuration to the family [rad]"),
    source=Literal["catalogue", "analysis", "on the spot"],
)
RELATIONS = table(
    "relations", of=Relation, slides=None, words=(str, 'in English: "axes 1, 3, 5, 7 aligned"', attrgetter("words")),
    joints=list_of(Positive),
)  # fmt: skip
SCREW = table(
    "screw",
    of=Screw,
    point=row(num("m"), 3) | None,
    direction=row(num("1"), 3),
    pitch=num("m/rad") | None,
    magnitude=num("twist", ge=0),
)
LOST_FRAME = table(
    "lost_frame",
    name=(str, "", attrgetter("framed.name")),
    axes=(int, "", attrgetter("framed.frame.axes")),
    origin=(int, "", attrgetter("framed.frame.origin")),
    point=(row(num("m"), 3), "", attrgetter("framed.frame.point")),
    directions=(list_of(row(num("1"), 6)), "", attrgetter("framed.directions")),
    twist_screws=list_of(SCREW),
    wrench_screws=list_of(SCREW),
)
RATES = table(
    "rates",
    of=DirectionRates,
    direction=row(num("entry"), 6),
    unit=Literal["m/s", "rad/s", "1"],
    joint_rates=list_of(num("joint/s")),
    norm=num("distance/s", ge=0) | None,
    worst=Positive | None,
    speed_smallest_rates=num("entry", ge=0) | None,
    speed=num("entry", ge=0) | None,
)
JOINT_RATES = table(
    "joint_rates",
    of=Rates,
    limits=list_of(num("joint/s") | None),
    length_scale=num("m"),
    lost_shares=optional(list_of(num("1", ge=0, le=1.000001))),
    remaining=optional(list_of(RATES | None)),
)
NEAREST = table(
    "nearest",
    of=Nearest,
    distance=num("distance", ge=0),
    q=list_of(num("joint")),
    delta=list_of(num("joint")),
    corank=Positive,
    sigma=optional(num("1", ge=0)),
    stationarity=optional(num("1", ge=0)),
    starts=optional(Positive),
    agreeing=optional(Count),
    within_limits=optional(bool),
    family=EXPLANATION_FAMILY | None,
)
FAMILIES_AWAY = table(
    "families_away",
    id=(str, "", attrgetter("family.id")),
    name=(str, "", attrgetter("family.name")),
    distance=num("distance", ge=0),
    q=list_of(num("joint")),
    delta=list_of(num("joint")),
    residual=num("distance", ge=0) | None,
    sigma=num("1", ge=0) | None,
    exact=bool,
)
CERTIFICATE = table(
    "certificate",
    radius=(num("distance", ge=0), "[rad]"),
    single=(num("distance", ge=0), "of the first enclosure"),
    at_most=num("distance", ge=0),
    q=list_of(num("joint")),
    task=str,
    rank=Count,
    setting=dict[str, Any],
    evaluations=Count,
    model=str,
    complete=bool,
    version=str,
    rows=nonempty(Literal[0, 1, 2, 3, 4, 5], min_length=1, max_length=6),
    frame=FRAME,
)
FAILURES = table(
    "failures",
    number=Positive,
    joint=str,
    sigma=(list_of(num("1", ge=0)), "singular values of the others' Jacobian, descending"),
    sigma_min=(num("1", ge=0), "the one at the generic rank of the whole arm; 0 where the rank is lower"),
    rank=Count,
    share=(num("1", ge=0, le=1.000001), "remaining share of the square root of det(J Jᵀ)"),
    lost_directions=(list_of(row(num("1"), 6)), "rows (v; ω) that the others cannot make, in the frame of lost_words",
        attrgetter("lost")),
    lost_words=list_of(str),
)
ELLIPSOID = table(
    "ellipsoid",
    of=Ellipsoid,
    axes=list_of(list_of(num("1"))),
    half_lengths=list_of(num("entry", ge=0) | None),
    semi_axes=list_of(list_of(num("entry") | None)),
)
INDEX = table("index", of=Index, value=num("entry", ge=0) | None, length_scale=num("m") | None)
SHAPE = table(
    "shape", name=str, velocity=ELLIPSOID, force=ELLIPSOID, sigma_min=INDEX, condition=INDEX, manipulability=INDEX,
)  # fmt: skip
SHAPES = table(
    "shapes", of=PartSet, by_limits=None, slide_length=None,
    ball=(str, "the unit balls of joint rates and of joint torques, in words", attrgetter("ball")),
    joints=list_of(num("joint/s") | None),
)  # fmt: skip
ELLIPSOIDS = table("ellipsoids", of=Ellipsoids, length_scale=num("m"))
RANK = table(
    "rank",
    of=Rank,
    sigma=list_of(num("1", ge=0)),
    sigma_error=num("1", ge=0),
    rank=Count,
    generic_rank=Count,
    corank=Count,
    nullity=Count,
    tolerance=num("1", ge=0),
)
CHECK = table("check", of=RankNullity, rank=Count, nullity=Count, n=Count, largest=num("1"))
REDUNDANCY = table(
    "redundancy",
    of=Redundancy,
    range_basis=list_of(list_of(num("twist"))),
    null_basis=list_of(list_of(num("joint/s"))),
    projector=list_of(list_of(num("ratio"))),
    closed_form=list_of(list_of(num("ratio"))),
    difference=num("ratio", ge=0),
    idempotent=num("ratio", ge=0),
    annihilates=num("1", ge=0),
    closed_annihilates=num("1", ge=0),
    joint_scale=list_of(num("joint")),
)
COORDINATES = table(
    "coordinates",
    of=Representation,
    coordinates=list_of(num("coordinate") | None),
    sigma_min=num("1", ge=0),
    determinant=num("1") | None,
    angle=num("rad", ge=0) | None,
    jump=num("rad") | None,
    words=(str, "what it means."),
)
_ABOUT = meanings(Representations)
REPRESENTATIONS = table(
    "representations",
    arm=(RANK, _ABOUT["arm"]),
    zyz=(COORDINATES, _ABOUT["zyz"]),
    rpy=(COORDINATES, _ABOUT["rpy"]),
    quaternion=(COORDINATES, _ABOUT["quaternion"]),
    rotvec=(COORDINATES, _ABOUT["rotvec"]),
    words=(str, "who is singular here: the arm, coordinates, both or neither."),
    others=(optional(list_of(COORDINATES)), _ABOUT["others"]),
)
HERE = table(
    "here",
    number=Positive,
    sigma=num("1", ge=0),
    distance=num("distance", ge=0) | None,
    q=list_of(num("joint")) | None,
    there=num("1", ge=0) | None,
)
EXPLANATION_IDEAL = table(
    "explanation_ideal",
    tolerance=TOLERANCE,
    moved=(list_of(MOVED), "numbers of the chain that were moved [rad, m]"),
    real=(dict[str, Any], "the arm itself, as robot"),
    families=list_of(dict[str, Any]),
    here=HERE,
)
SLOW_FAMILY = table(
    "slow_family",
    id=(str, "", attrgetter("family_id")),
    name=(str, "", attrgetter("family")),
    distance=(num("distance", ge=0), "to its nearest point"),
    ideal=(bool, "a family of the ideal arm nearby, not of the arm itself"),
    length=(num("m", ge=0), "largest difference of a length between the two arms"),
    angle=(num("rad", ge=0), "largest difference of an angle"),
)
LOST_SEEN = table(
    "lost_seen",
    frame=Literal["base", "tool", "link"],
    axes=str,
    directions=list_of(row(num("1"), 6)),
    constraints=list_of(str),
    short=list_of(str),
)


def _nearest(explanation: Any) -> dict[str, Any] | None:
    """The nearest singular configuration: q itself where it is one."""
    if explanation.rank.corank:
        return {"distance": 0.0, "q": explanation.q, "delta": 0.0 * explanation.q, "corank": explanation.rank.corank,
                "family": explanation.met[0] if explanation.met else None}  # fmt: skip
    far = explanation.far
    if far.nearest is None:
        return None
    return {**plain(far.nearest), "family": far.nearest_family}


_FAR: dict[str, Any] = {
    "nearest": (NEAREST | None, "null: none found", _nearest),
    "families_away": (list_of(FAMILIES_AWAY), "nearest first", attrgetter("far.families")),
    "certified_radius": (num("distance", ge=0) | None,
        "no singular configuration within it, proven; 0 at a singular configuration, null where nothing can "
        "be certified"),
    "certificate": (CERTIFICATE | None, "", attrgetter("far.certificate")),
    "uncertified": (str, "why there is no certificate; else empty", attrgetter("far.uncertified")),
    "near_miss": (num("1", ge=0) | None,
        "σ_r at the nonzero minimum where a descent from q ends; null unless it is the nearest",
        attrgetter("far.near_miss")),
}
EXPLANATION_FILE = file(
    "explanation",
    "Written by `rankdrop explain --json` and Explanation.save. Twists are (v; ω), linear part first, in the "
    "task's frame.",
    **_ASKED,
    sentence=(str, "verdict and reason for people, printed first and last", sentence_of),
    sigma_error=(num("1", ge=0), "bound on the error of each", attrgetter("rank.sigma_error")),
    always_singular=(bool, "generic_rank is below the smaller of rows and joints",
        attrgetter("rank.always_singular")),
    tolerance=(num("1", ge=0), "σ at or below it is zero", attrgetter("rank.tolerance")),
    nearly_lost=(Count, "further singular values at or below settings.small: freedoms nearly lost"),
    focus=(list_of(num("joint")),
        "the configuration that family, relations and blame speak of: q, or the nearest singular one where q "
        "is near it"),
    family=(EXPLANATION_FAMILY | None, "the family of the singularity; null where the verdict is regular",
        lambda explanation: explanation.met[0] if explanation.met else None),
    families=(list_of(EXPLANATION_FAMILY), "all families that hold at focus", attrgetter("met")),
    family_source=(Literal["catalogue", "analysis", "on the spot"], "", attrgetter("source")),
    relations=list_of(RELATIONS),
    lost_directions=(list_of(row(num("1"), 6)),
        "orthonormal; twists (v; ω) that cannot be made, in the task's frame. Nearly lost ones where the "
        "verdict is near", attrgetter("lost.directions")),
    lost_words=(list_of(str), "", attrgetter("lost.words")),
    blocked_wrenches=(list_of(row(num("1"), 6)), "the same numbers read as (f; τ): carried without joint torque",
        attrgetter("lost.directions")),
    blocked_words=(list_of(str), "", attrgetter("lost.blocked_words")),
    lost_frame=(LOST_FRAME | None, "the frame where they are sparsest",
        lambda explanation: explanation.lost if explanation.lost.framed is not None else None),
    weakest_direction=(row(num("1"), 6), "that of σ_r", attrgetter("lost.weakest")),
    never_possible=(list_of(row(num("1"), 6)), "twists beyond the generic rank", attrgetter("lost.never")),
    **_WAYS,
    joint_rates=(JOINT_RATES, "what motion costs", attrgetter("rates")),
    **_FAR,
    failure_bound=(num("1", ge=0) | None,
        "√((n − r)/n) σ1: no worst case is above it here; null at a singular configuration",
        attrgetter("failures.bound")),
    failures=(list_of(FAILURES), "what the failure of each joint leaves: it stands still, its column is gone",
        attrgetter("failures.single")),
    ellipsoids=(ELLIPSOIDS, "velocity and force ellipsoids"),
    redundancy=(REDUNDANCY, "range, null space and projectors"),
    representations=(REPRESENTATIONS, "singularities of coordinates of the orientation"),
    disagreements=(list_of(str), "one sentence for each pair of methods that differ; empty when all is well"),
    ideal=(optional(EXPLANATION_IDEAL),
        "with --ideal: the given arm; all else is about the ideal one", lambda _: UNSET),
    lost_seen=(list_of(LOST_SEEN), "what all motions that remain obey, from base, tool and a link; v [m/s], ω [rad/s]",
        lambda explanation: [{"frame": frame, "directions": seen.directions, **lost_text(explanation.robot, seen)}
                     for frame, seen in explanation.lost.seen.items()]),
    **_SUMMARY,
    slowest=(optional(list_of(STRAIGHT_MOTION)), "slowest straight translation and rotation; empty without rate limits",
        attrgetter("straight")),
    slow_family=(optional(SLOW_FAMILY | None), "what makes a motion slow; null where speed does not decide",
        lambda explanation: None if explanation.slow_family is None else explanation.summary),
)
NEAREST_FILE = file(
    "nearest",
    "Written by `rankdrop nearest --json`: the entries of an explanation that say how far. Twists are (v; ω), "
    "linear part first, in the task's frame.",
    **_ASKED,
    **_SUMMARY,
    **_FAR,
    disagreements=(list_of(str), "one sentence for each pair of methods that differ; empty when all is well"),
)
TOLERANT_SETTINGS = table(
    "tolerant_settings",
    measure=(Literal["sigma", "relative"], "the least σ_r left, or that divided by σ1 of the whole arm",
        lambda tolerant: "relative" if tolerant.relative else "sigma"),
    seed=Count,
    starts=Positive,
    limits=bool,
    length_scale=(num("m", gt=0), "", lambda tolerant: tolerant.task.scale(tolerant.robot)),
    tolerances=TOLERANCES,
    version=(str, "", lambda _: VERSION),
)
TOLERANT_PLACES = table(
    "tolerant_places",
    of=TolerantPlace,
    q=nonempty(num("joint")),
    value=num("1", ge=0),
    slope=num("1/distance", ge=0),
    sigma_min=(num("1", ge=0), "σ_r of the whole arm", attrgetter("failures.sigma_min")),
    failure_bound=(num("1", ge=0) | None,
        "√((n − r)/n) σ1: no worst case is above it here; null at a singular configuration",
        attrgetter("failures.bound")),
    failures=(list_of(FAILURES), "", attrgetter("failures.single")),
)
LOCKED_JOINT = table(
    "locked_joint", of=LockedJoint, number=Positive,
    ranges=(list_of(row(num("joint"), 2)), "values, from and to, on the self-motions: locked at one of "
        "them, the joint leaves the pose in reach"),
    share=(num("1", ge=0, le=1) | None, "of its range inside the limits that count, else of a whole turn; null for a "
        "slide without limits"),
)  # fmt: skip
SELF_MOTIONS = table(
    "self_motions", of=SelfMotions, tool_pose=row(row(num("pose"), 4), 4), q=nonempty(num("joint")),
    value=(num("1", ge=0), "the measure at q"),
    best=(nonempty(num("joint")), "where on the self-motions it is largest"),
    best_value=num("1", ge=0), least_value=num("1", ge=0), curves=Positive,
    usable=(Positive, "curves with configurations inside the limits, where limits count"),
    complete=(bool, "every curve that was found was followed to its end"), joints=list_of(LOCKED_JOINT),
)  # fmt: skip
TOLERANT_FILE = file(
    "tolerant",
    "Written by `rankdrop tolerant --json`: configurations that bear the failure of any one joint best.",
    robot=(ROBOT, "", ARM_OF),
    settings=(TOLERANT_SETTINGS, "", lambda tolerant: tolerant),
    complete=(bool, "false: interrupted"),
    done=(Count, "starts climbed from"),
    spare=(Count, "n − r, joints to spare"),
    bound=(num("1", ge=0, le=1), "√((n − r)/n), above every relative worst case"),
    optimal=(bool, "the best place reaches the bound"),
    free=(list_of(Positive), "joints that may take any value"),
    crucial=(list_of(Positive), "joints that cost a freedom at every configuration if they fail"),
    places=(list_of(TOLERANT_PLACES), "local maxima, best first"),
    self_motion=(optional(SELF_MOTIONS), "the self-motions of one tool pose; absent where they were not asked for",
        lambda tolerant: tolerant.self_motion or UNSET),
)
