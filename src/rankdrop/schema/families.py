"""Tables of the files of `analyze`, `find` and `conditions`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any, Literal

from msgspec import UNSET, UnsetType

from rankdrop.codec import (
    Count,
    Positive,
    list_of,
    mapping,
    nonempty,
    num,
    optional,
    row,
    table,
    text,
    whole,
)
from rankdrop.distance.share import JointSpaceShares, SlowShare
from rankdrop.exact.determinants import Minor
from rankdrop.exact.family import EqualLengths, SpecialFamily, UnrealSet
from rankdrop.exact.lint import Example, WrongSet
from rankdrop.exact.signs import Between, Flags, SegmentCrossing
from rankdrop.exact.undivided import PolynomialSize, UndividedSet
from rankdrop.families.contradiction import Contradiction
from rankdrop.families.corank_families import CorankSummary, Unseen
from rankdrop.families.derivation import Derivation
from rankdrop.families.lost import LostFreedom
from rankdrop.families.name import Detail, FamilyName, JointValues, LowRank, Shorter, Variable
from rankdrop.families.record import Check, Family, Pin
from rankdrop.families.searching import Outcome
from rankdrop.families.speed_distance import SpeedDistance, SpeedDistances
from rankdrop.families.summary import FamilySummary, RankSummary
from rankdrop.formula.equation import Term
from rankdrop.formula.notation import C, Python, Step
from rankdrop.local.dependence import Dependence
from rankdrop.results.aspect_summary import AspectSummary
from rankdrop.results.findings import configurations, strata
from rankdrop.schema.arm import ARM_OF, FRAME, INSIDE_PINNED, MOVED, PINNED, ROBOT, TOLERANCE, TOLERANCES, file
from rankdrop.text.conditions import proof_words
from rankdrop.text.lost import lost_sentences
from rankdrop.text.structure import reason_text
from rankdrop.version import VERSION

SETTINGS = table(
    "settings",
    seed=(Count, "of every random choice"),
    starts=(Positive, "random starts for each corank"),
    limits=(bool, "whether only the space within the joint limits was searched"),
    length_scale=(num("m", gt=0), "translation rows were divided by it [m]"),
    tolerances=TOLERANCES,
    version=(str, "of rankdrop"),
)
SHARE = table(
    "share",
    tested=(Count, "independent singular configurations of exactly this corank"),
    explained=(Count, "how many of them satisfy a row", attrgetter("agree")),
)
UNSEEN = table(
    "unseen", of=Unseen, estimate=(num("1", ge=0, le=1), "Good–Turing."),
    upper=(num("1", ge=0, le=1), "upper bound at 95 % confidence."),
    how=(str, "the estimator in words, with the counts it used."),
    estimator=None, once=None, pieces=None, number=None, text=None,
)  # fmt: skip
SUMMARY = table(
    "summary", of=CorankSummary, corank=whole(ge=1, le=6), rank=whole(ge=0, le=5), starts=Count, converged=Count,
    near_misses=Count, slow=Count, smallest_near_miss=num("1") | None, completeness=SHARE, higher=Count,
)  # fmt: skip
INSIDE = table(
    "inside",
    holds=(bool, "false: the row lies outside the joint limits"),
    pinned=(list_of(INSIDE_PINNED), "values inside the limits, moved by whole turns"),
    outside=(list_of(INSIDE_PINNED), "values that no turn brings inside"),
)
TERMS = table(
    "terms",
    of=Term,
    coefficient=num("1"),
    kind=Literal["sin", "cos"],
    harmonics=list_of(num("1")),
    powers=list_of(Count),
    shift=num("rad"),
)
SOUNDNESS = table(
    "soundness",
    tested=(Count, "points solved from the equations from random starts"),
    singular=(Count, "how many of them have the corank or more", attrgetter("agree")),
)


def _absent(_: Any) -> UnsetType:
    """Value of an entry that is added to the record by whoever was asked for it."""
    return UNSET


def _sentences(field: str) -> Callable[[Any], list[str]]:
    """Function of a record that gives the sentences of its facts in a field."""
    return lambda record: list(map(str, getattr(record, field)))


def _terms(family: Any) -> list[Any]:
    return [equation.to_dict()["terms"] for equation in family.equations]


def _sorted_pins(family: Family) -> list[Pin]:
    """The pinned joints, each with its values in order."""
    return [replace(pin, values=tuple(sorted(pin.values))) for pin in family.pinned]


LOST_FREEDOM = table(
    "lost_freedom",
    of=LostFreedom,
    direction=row(num("1"), 6),
    frame=FRAME,
    everywhere=bool,
    length=num("m", gt=0),
    kind=(Literal["translation", "rotation", "tied"], "tied: translation and rotation, by u · (v; ω) = 0",
        lambda freedom: freedom.kind.value),
)


def _unless_default(field: str) -> Callable[[FamilyName], Any]:
    """Function of a name that gives a field; absent where it has its default."""
    default = getattr(FamilyName(), field)

    def value(name: FamilyName) -> Any:
        found = getattr(name, field)
        if found == default:
            return UNSET
        return found

    return value


def _details(kind: type) -> Callable[[FamilyName], Any]:
    """Function of a name that gives its details of one kind, joints from 1; absent where it has none."""

    def value(name: FamilyName) -> Any:
        return [_from_one(detail) for detail in name.details if isinstance(detail, kind)] or UNSET

    return value


def _from_one(detail: Detail | Dependence | LowRank) -> Detail | Dependence | LowRank:
    """A detail with joints counted from 1, as in every file."""
    if isinstance(detail, Detail):
        return replace(detail, joints=tuple(_numbers_from_one(group) for group in detail.joints))
    if isinstance(detail, Dependence):
        return replace(detail, joints=_numbers_from_one(detail.joints), slides=_numbers_from_one(detail.slides))
    return detail


def _numbers_from_one(joints: Sequence[int]) -> tuple[int, ...]:
    return tuple(joint + 1 for joint in joints)


def _shorter(name: FamilyName) -> Any:
    return [kind.name.lower() for kind in Shorter if kind.name and kind in name.shorter] or UNSET


_JOINTS = list_of(Positive)
CALLED = table(
    "called",
    "The name of a family as facts; entries without a value are absent.",
    parts=(optional(list_of(Literal["shoulder", "elbow", "wrist"])), "of the arm that are concerned",
        _unless_default("parts")),
    independent=(optional(bool), "each part loses one freedom by itself", _unless_default("independent")),
    relations=(optional(list_of(table("called_relation", of=Detail, joints=optional(list_of(_JOINTS))))),
        "relations of axes that hold on the family", _details(Detail)),
    dependent=(optional(list_of(table("called_dependent", of=Dependence, joints=_JOINTS, slides=optional(_JOINTS)))),
        "minimal dependent sets of joint screws", _details(Dependence)),
    low_rank=(optional(list_of(table("called_low_rank", of=LowRank, joints=Positive, rank=Count))),
        "rank of all joint screws, where no smaller dependent set is known", _details(LowRank)),
    bound=(optional(list_of(table("called_variable", of=Variable, number=Count))),
        "joints with a condition that the relations do not tell", _unless_default("bound")),
    values=(optional(list_of(table("called_values", of=JointValues, values=nonempty(num("joint"))))),
        "of single joints", _unless_default("values")),
    condition=(optional(str), "one that no other family of this name has", _unless_default("condition")),
    ordinal=(optional(Positive), "number among the families of this name, from 1", _unless_default("ordinal")),
    shorter=(optional(list_of(Literal[tuple(kind.name.lower() for kind in Shorter if kind.name)])),
        "how the words of a long name save characters", _shorter),
    unnamed=(optional(bool), "points without a condition", _unless_default("unnamed")),
    given=(optional(str), "words of a name without facts, kept as they are", _unless_default("given")),
)
NAME_FACTS = (optional(CALLED), "the name as facts, from which it is worded; since 0.3")
_EXACT: dict[str, Any] = {
    "pinned": (list_of(PINNED), "joints at fixed values of q; their conditions are the first of `conditions`."),
    "conditions": (list_of(str), 'for people: "θ4 = 0 or π", "a2 c2 + a3 c23 = 0".'),
    "latex": (list_of(str), "the same as LaTeX mathematics."),
    "reality": (str, '"" where the family is real whatever the lengths are; else when it is.'),
}
EXACT_CONDITIONS = table("exact_conditions", **_EXACT)
FAMILY = table(
    "family",
    id=text(pattern="^k[1-6]\\.f[1-9][0-9]*$"),
    name=str,
    called=NAME_FACTS,
    named=(bool, "false: points were found, but no condition"),
    corank=whole(ge=1, le=6),
    dimension=(Count, "of the family in joint space"),
    pinned=(list_of(PINNED), "joints at fixed values; every combination belongs to the family"),
    inside=(optional(INSIDE), "with --limits: what the joint limits leave of the values", _absent),
    free=(list_of(Positive), "numbers of the joints that do not matter"),
    coupled=(list_of(Positive), "numbers of the joints tied together by the remaining equations"),
    equations=(list_of(text(min_length=1)),
        "expressions in q1 … qn, sin, cos, pi (Python) that vanish on the family; all conditions, those of "
        "pinned joints included"),
    terms=(list_of(nonempty(TERMS)),
        "the same equations as sums of coefficient · kind(harmonics·q − shift) · Π q^powers",
        _terms),
    witness=(nonempty(num("joint")), "a configuration on the family [rad, m]"),
    lost_directions=(list_of(row(num("1"), 6)),
        "orthonormal rows (v; ω) lost at the witness, in the frame of the task, metres and radians"),
    lost_freedoms=(optional(list_of(LOST_FREEDOM)), "the same in the frame in which they are simplest; since 0.3"),
    lost_words=(list_of(str), "these in words, one sentence each", lambda family: lost_sentences(family.lost_freedoms)),
    soundness=SOUNDNESS,
    explained=SHARE,
    evidence=(str, "how the conditions were obtained", lambda family: str(family.evidence)),
    exact=(optional(EXACT_CONDITIONS), "its exact conditions; absent where the families were not derived; since 0.3",
        lambda family: family.exact or UNSET),
)
OLD_EXACT_FAMILIES = table("old_exact_families", **_EXACT, id=str)
CONTRADICTION = table(
    "contradiction",
    of=Contradiction,
    called=(optional(CALLED), "", lambda contradiction: contradiction.called or UNSET),
    q=list_of(num("joint")),
)


def _reason(derivation: Derivation) -> str:
    """Why nothing was derived, in words; "" where the families were derived."""
    if derivation.reason is None:
        return ""
    return str(derivation.reason)


EXACT = table(
    "exact",
    of=Derivation,
    status=Literal["agrees", "differs", "not derived"],
    asked=Literal["auto", "on"],
    seconds=num("s", gt=0),
    reason=(optional(str), 'why nothing was derived; else "".', _reason),
    letters=mapping(num("m")) | None,
    shifts=list_of(num("joint")),
    disagreements=(optional(list_of(str)), "sentences; none where derivation and numerical tests agree",
        _sentences("disagreements")),
    contradictions=(optional(list_of(CONTRADICTION)), "the same as facts; absent where there are none; since 0.3",
        lambda derivation: derivation.disagreements or UNSET),
    first_derived=(optional(bool), "true: not derived as a whole, but the families of corank 1 are; else absent; since "
        "0.3", lambda derivation: derivation.first_derived or UNSET),
    families=(optional(list_of(OLD_EXACT_FAMILIES)), "up to 0.2: the exact conditions of all families; since 0.3 each "
        "family has its own", _absent),
)
NEAR_FAMILIES = table(
    "near_families",
    id=(str, "of the family; empty for all together"),
    near=Count,
    samples=Positive,
    bound=(bool, "true: the share may be larger"),
    share=num("1", ge=0, le=1),
    error=(num("1", ge=0), "standard error"),
    low=(num("1", ge=0, le=1), "95 % confidence, Wilson", lambda share: share.interval[0]),
    high=(num("1", ge=0, le=1), "", lambda share: share.interval[1]),
)
ANALYSIS_NEAR = table(
    "analysis_near", of=JointSpaceShares, within=num("distance", gt=0), samples=Positive, seed=Count,
    families=list_of(NEAR_FAMILIES), any=NEAR_FAMILIES,
    slow=(optional(NEAR_FAMILIES | None), "configurations inside the limits at which some straight motion of the tool "
        "is slower than 25 mm/s or 5°/s; null without rate limits"),
)  # fmt: skip
ANALYSIS_SLOW = table(
    "analysis_slow", of=SlowShare, tool_speed=num("m/s", gt=0),
    share=(NEAR_FAMILIES, "configurations at which some straight translation of the tool is slower, every joint within "
        "its rate limit; `near` counts them, `samples` all: uniform in each joint inside its limits"),
    seed=Count,
)  # fmt: skip
SPEED_DISTANCES = table(
    "speed_distances", of=SpeedDistances, tool_speed=num("m/s", gt=0), around=list_of(num("joint")),
    span=num("rad", gt=0),
    free=list_of(Positive),
    distances=list_of(table(
        "speed_distance", of=SpeedDistance, number=Positive, value=num("rad"),
        end=(num("rad", ge=0), "no distance in the region is larger [`unit`]"),
        kept_from=(num("rad", ge=0) | None, "proven for every configuration of the region at least so far from the "
            "family [`unit`]; null for none"),
        slower_at=(num("rad", ge=0) | None, "largest distance at which a slower configuration was found [`unit`]"),
        slower_speed=(num("m/s", ge=0) | None, "of the tool there, in its slowest direction"), boxes=Count,
        measure=(Literal["joint", "joints", "residual"], "distances are of one joint from its value, the largest of "
            "several joints, or the size of the only condition"),
        unit=Literal["rad", "m", "1"], numbers=list_of(Positive), values=list_of(num("rad")),
    )),
)  # fmt: skip
ASPECTS_SUMMARY = table(
    "aspects_summary", of=AspectSummary,
    at_least=(Count | None, "aspects, proven; null where they were not counted"),
    at_most=(Count | None, "null where they were not counted"),
    proven=(bool, "whether `at_most` is proven as well"),
    posture_change=(Literal["cuspidal", "not cuspidal", "none found", "not asked"] | None,
        "whether the arm can change its posture without a singularity: as `verdict` of `aspects`; null where only the "
        "aspects were counted"),
)  # fmt: skip
SIGMA = table("sigma", least=num("1", ge=0), median=num("1", ge=0), most=num("1", ge=0))
DISTANCE = table("distance", least=num("distance", ge=0), median=num("distance", ge=0), most=num("distance", ge=0))
IDEAL_FAMILIES = table(
    "ideal_families", id=str, name=str, corank=Positive, points=Positive, number=Positive, sigma=SIGMA,
    singular=Count, searched=Positive, distance=DISTANCE | None,
)  # fmt: skip
IDEAL = table(
    "ideal",
    tolerance=TOLERANCE,
    moved=(list_of(MOVED), "numbers of the chain that were moved [rad, m]"),
    real=(dict[str, Any], "the arm itself, as robot"),
    families=(list_of(IDEAL_FAMILIES), "the arm itself on each family of the ideal one"),
)
ANSWER = (optional(list_of(str)), "the answer in two sentences: what the arm has, and how sure that is",
          lambda result: result.verdict.headlines(result.answer))  # fmt: skip
RANKS = table(
    "ranks", of=RankSummary, rank=(Count, "of the task Jacobian on these families"), corank=Positive, families=Positive,
    combinations=(Count, "of these, families that lie on two or more families of the smallest corank"),
    names=(dict[str, Positive], "short name -> number of families that have it"),
)  # fmt: skip
COUNTS = (
    optional(table(
        "counts", of=FamilySummary, arm=None, generic_rank=Count, ranks=list_of(RANKS),
        evidence=(Literal["derived and tested", "derived", "tested", "none"], "how the families were verified"),
        tests=(Count, "random singular configurations that were compared with the families"),
    )),
    "the answer in facts: families by rank, the highest rank first", attrgetter("summary"),
)  # fmt: skip
ANALYSIS_FILE = file(
    "analysis",
    "Every family of singular configurations of an arm.",
    robot=(ROBOT, "", ARM_OF),
    settings=SETTINGS,
    verdict=(
        optional(Literal["verified", "unchecked", "contradicted", "unsound", "incomplete", "interrupted"]),
        "the first two: exit code 0; unchecked: derived completely and tried on nothing; contradicted: two "
        "ways differ; unsound: the conditions of a row hold elsewhere too", attrgetter("verdict.word")),
    claims=(optional(list_of(Literal["sampled", "derived exactly"])), "what was done, and holds",
        attrgetter("verdict.claims")),
    sentence=(optional(str), "how sure the answer is, in a sentence", attrgetter("verdict.sentence")),
    summary=ANSWER,
    counts=COUNTS,
    complete=(bool, "false: interrupted; the coranks listed are complete"),
    unfinished=(Positive | None, "the corank that was interrupted"),
    notes=(list_of(str), "remarks for the reader"),
    coranks=(list_of(SUMMARY), "one entry per corank searched, the last one (nothing found) included"),
    families=(list_of(FAMILY), "all rows, by corank"),
    exact=(optional(EXACT), "where the families come from", lambda analysis: analysis.exact or UNSET),
    near=(optional(ANALYSIS_NEAR), "share of the joint space near each family; absent where it was not asked for",
        lambda analysis: analysis.near or UNSET),
    speeds=(optional(SPEED_DISTANCES), "how far from each family the tool keeps a speed; absent where it was not asked "
        "for", lambda analysis: analysis.speeds or UNSET),
    slow=(optional(ANALYSIS_SLOW), "share of the joint space inside the limits in which the tool is slower than the "
        "speed of `speeds`; absent without it", lambda analysis: analysis.slow or UNSET),
    aspects=(optional(ASPECTS_SUMMARY), "how many aspects the arm has, joint limits ignored; absent for arms outside "
        "the catalogue where it was not asked for", lambda analysis: analysis.aspects or UNSET),
    ideal=(optional(IDEAL), "with --ideal: the given arm; all else is about the ideal one",
        _absent),
)
RANK_CHECK = table("rank_check", of=Check, tested=(Count, "points tried"), agree=(Count, "how many have the rank"))
CONDITIONS_SETTINGS = table(
    "conditions_settings",
    method=(str, "asked for, for corank 1"),
    lengths=(Literal["auto", "letters", "numbers"] | mapping(num("m")),
        "as asked for: a word, or values by letter [m]"),
    coranks=(Positive | None, "the highest one asked for; null: all"),
    seconds=(num("s", gt=0) | None, "time limit; null: none"),
    seed=(Count, "of every random choice"),
    points=(Count, "numerically found configurations to try, of corank 1"),
    special=(bool, "whether arms of special lengths were derived too"),
    steps=(bool, "whether the derivation was written down"),
    version=(str, "of rankdrop", lambda _: VERSION),
    basic=(optional(list_of(int) | None), "numbers of the basic screws asked for"),
    frame=(optional(int | None), "link that gives the frame of the screws"),
)
STEPS = table("steps", of=Step)
FACTORS = table("factors", text=str, latex=str, multiplicity=int)


def _factors(minor: Minor) -> list[dict[str, Any]]:
    if minor.factored:
        powers = minor.value.powers()
    else:
        powers = ()
    return [{"text": text, "latex": latex, "multiplicity": power} for text, latex, power in powers]


MINORS = table(
    "minors",
    name=str,
    mark=(str, "name in code"),
    joints=(list_of(int), "of its columns, in order"),
    rows=(list_of(str), "of the task, vx … wz, in order"),
    about=str,
    factored=(bool, "whether its factors were found"),
    sign=(Literal[-1, 0, 1], "of the number before the factors",
        lambda minor: (minor.value.form.number > 0) - (minor.value.form.number < 0)),
    number=(str, "before the factors, a whole number or p/q", lambda minor: str(minor.value.form.number)),
    factors=(list_of(FACTORS), "", _factors),
    terms=(int, "of the polynomial in sines and cosines", lambda minor: len(minor.value.polynomial)),
    text=(str, "", lambda minor: minor.value.text()),
    latex=(str, "", lambda minor: minor.value.latex()),
    python=(str, "in q1 …, sin, cos and the lengths", lambda minor: minor.value.code(Python(shifts=minor.shifts))),
    c=(str, "in q[0] … and the lengths", lambda minor: minor.value.code(C(shifts=minor.shifts))),
)
DETERMINANTS = table(
    "determinants",
    product=(
        str,
        'how the determinant follows from the minors: "det J = −det J11 det J22"; "" where there is one, or none.',
    ),
    meaning=(str, "what the minors are, and where the rank drops, in a sentence."),
    minors=(
        list_of(MINORS), "the determinant or the minors, those that vanish everywhere too; of blocks first, det J last."
    ),
    left=(optional(list_of(str)),
        "what was not done within the limit on work.", lambda found: list(map(str, found.left))),
)
CONDITIONS_FAMILY = table(
    "conditions_family",
    id=text(pattern="^k[1-6]\\.f[1-9][0-9]*$"),
    name=str,
    called=NAME_FACTS,
    corank=whole(ge=1, le=6),
    dimension=(Count, "of the family in joint space"),
    codimension=(Positive, "number of joints less the dimension"),
    pinned=(list_of(PINNED), "joints at fixed values; every combination belongs to the family", _sorted_pins),
    free=(list_of(Positive), "numbers of the joints that do not matter"),
    coupled=(list_of(Positive), "numbers of the joints tied together by the remaining equations"),
    conditions=(nonempty(text(min_length=1)),
        "every condition for people, in θ = q + shift: s_i is sin θi, c_ij is cos(θi + θj)", attrgetter("texts")),
    latex=(nonempty(text(min_length=1)), "the same conditions as LaTeX mathematics"),
    equations=(nonempty(text(min_length=1)),
        "expressions in q1 … qn, sin, cos, pi (Python) that vanish on the family; all conditions, those of "
        "pinned joints included"),
    terms=(nonempty(nonempty(TERMS)),
        "the same equations as sums of coefficient · kind(harmonics·q − shift) · Π q^powers",
        _terms),
    reality=(str, "when the family has real points, in words; empty: nothing is known to stand against it",
        attrgetter("exact.reality")),
    witness=(nonempty(num("joint")), "a configuration on the family [rad, m]"),
    lost_freedoms=(optional(list_of(LOST_FREEDOM)), "what the tool cannot do on the family; since 0.3"),
    lost_words=(list_of(str),
        "the same in words, one sentence each", lambda family: lost_sentences(family.lost_freedoms)),
    rank_check=(RANK_CHECK, "rank modulo the prime 2^61 − 1 at random points of the family",
        attrgetter("exact.rank_check")),
)
ASSUMPTIONS = table(
    "assumptions",
    text=(str, "what was assumed: d3 ≠ d5"),
    holds=(bool, "whether it is true of the arm's own lengths"),
    words=(str, "what happens where it fails, in a sentence; empty where nothing is known"),
    derived=(bool, "whether the special arm was derived"),
    equal=(optional(table("equal_lengths", of=EqualLengths) | None),
        "the lengths for which it fails: length = sign · other; null for others; since 0.3"),
    families=(optional(list_of(table("special_families", of=SpecialFamily))),
        "the first families that the special arm has besides; since 0.3"),
    more=(optional(Count), "number of its other families"),
)  # fmt: skip
UNREAL = table("unreal", of=UnrealSet, tried=optional(Count), negative=None,
    proof=(optional(str), "what excludes real points, where that is proven", proof_words))  # fmt: skip
UNDIVIDED = table(
    "undivided",
    of=UndividedSet,
    corank=(Positive, "of configurations on it, or more"),
    pins=(mapping(list_of(str)), "joint number -> simple angles it stands at",
        lambda case: {str(pin.joint): list(pin.values) for pin in case.pins}),
    stated=None,
    conditions=(optional(list_of(str)), "every condition in words, short ones first; none where one is long",
        attrgetter("texts")),
    polynomials=list_of(table("polynomials", of=PolynomialSize)),
    words=(str, "the case in words"),
    order=Positive,
    minors=Positive,
    degree=Count,
    starts=Count,
    found=Count,
    off=Count,
    witness=(nonempty(num("joint")) | None,
        "one of them, on no family where there is one; null where none was found"),
)  # fmt: skip
EXAMPLE = table(
    "example",
    of=Example,
    q=nonempty(num("joint")),
    degrees=nonempty(num("deg or m")),
    value=num("1"),
    sigma=num("1", ge=0),
)
MISSING = table("missing", of=WrongSet)
TEST = table(
    "test",
    text=(str, "the condition."),
    verdict=(Literal["exact", "too small", "too large", "both"], "for the arm's own lengths."),
    missing=(list_of(MISSING), "singular sets that the condition leaves out."),
    extra=(list_of(MISSING), "sets of regular configurations that it takes in."),
    real=(bool, "whether it holds at any real configuration."),
    any_lengths=(bool | None,
        "whether it is exact for all lengths that are symbols, special ones aside; None where none is."),
    complete=(bool, "whether everything could be decided; else the verdict speaks of the rest, and `remarks` list "
        "those left."),
    remarks=(list_of(str), "sets and lengths that do not count, and what was not decided."),
)
FLAGS = table(
    "flags",
    factor=(str, "the function, in s_j = sin θ_j and c_j = cos θ_j."),
    name=(str, 'of the family where it is zero, as `analyze` names it; "" where no real configurations are on it.'),
    sign=(Literal[-1, 0, 1] | None,
        "+1, −1, or 0 on the family; None where the factor has no sign on the torus."),
    value=(num("1"), "of the factor, scaled: |value| ≤ 1 without slides."),
)
CONDITIONS_FLAGS = table(
    "conditions_flags",
    of=Flags,
    q=nonempty(num("joint")),
    flags=list_of(FLAGS),
    tolerance=num("1", ge=0),
)
CROSSINGS = table(
    "crossings",
    of=SegmentCrossing,
    at=num("1", ge=0, le=1),
    kind=Literal["crosses", "touches", "starts on", "ends on", "lies in"],
)
BETWEEN = table("between", of=Between, parting=list_of(Count), equal=list_of(Count), open=list_of(Count))


CONDITIONS_FILE = file(
    "conditions",
    "The singularity conditions of an arm, derived exactly: written by `rankdrop conditions --json` and "
    "Conditions.save.",
    robot=(ROBOT, "", ARM_OF),
    settings=CONDITIONS_SETTINGS,
    letters=(mapping(num("m")), "value of each length that is a letter [m]"),
    shifts=(nonempty(num("joint")), "θ = q + shift, per joint [rad, m]"),
    remarks=(list_of(str), "what was rounded, or is nearly so", _sentences("remarks")),
    method=(str, "how corank 1 was derived in addition to the rank tree"),
    reason=(str, "why so", lambda found: reason_text(found.reason)),
    steps=(list_of(STEPS), "that derivation, step by step"),
    determinants=(optional(DETERMINANTS | None),
        "the determinant of the Jacobian, or the minors that take its place; null where no steps were asked for"),
    verdict=(
        optional(Literal["verified", "unchecked", "contradicted", "unsound", "incomplete", "not exact", "interrupted"]),
        "the first two: exit code 0; unchecked: derived completely and tried on nothing; contradicted: two "
        "ways differ; unsound: the conditions of a row hold elsewhere too", attrgetter("verdict.word")),
    claims=(optional(list_of(Literal["sampled", "derived exactly"])), "what was done, and holds",
        attrgetter("verdict.claims")),
    sentence=(optional(str), "how sure the answer is, in a sentence", attrgetter("verdict.sentence")),
    summary=ANSWER,
    counts=COUNTS,
    complete=(bool, "nothing was left unfinished"),
    interrupted=(bool, "Ctrl-C ended the derivation"),
    verified=(bool, "complete, and every check that was made holds"),
    left=(list_of(str), "what was not finished", _sentences("left")),
    disagreements=(list_of(str),
        "what two methods, or the derivation and a check, say differently; empty when all is well",
        _sentences("disagreements")),
    lowest=(whole(ge=0, le=6), "rank down to which drops were looked for"),
    families=(list_of(CONDITIONS_FAMILY), "of all coranks, by corank"),
    assumptions=(list_of(ASSUMPTIONS), "lengths for which more happens"),
    not_real=(list_of(str), "sets on which no real point is known, and why",
        lambda derived: list(map(str, derived.not_real))),
    unreal=(optional(list_of(UNREAL)), "the same as facts; since 0.3", attrgetter("not_real")),
    undivided=(optional(list_of(UNDIVIDED)), "cases that were not taken apart, as their conditions stand; since 0.3"),
    explained=SHARE,
    test=(optional(TEST | None), "what --test says (command line only)", _absent),
    flags=(optional(CONDITIONS_FLAGS | None), "what --flags says (command line only)", _absent),
    between=(optional(BETWEEN | None), "what --from and --to say (command line only)", _absent),
    ideal=(optional(IDEAL), "with --ideal: the given arm; all else is about the ideal one",
        _absent),
)
FIND_SETTINGS = table(
    "find_settings",
    corank=whole(ge=1, le=6),
    rank=(whole(ge=0, le=5), "rank kept"),
    method=Literal["lm", "gradient", "almarkhi", "reciprocal"],
    seed=(Count, "of every random choice"),
    starts=(Positive, "random starts for each corank", lambda found: len(found.q)),
    limits=(bool, "whether only the space within the joint limits was searched"),
    step=(num("1", gt=0, le=2) | None, "share of the step to linearised zero; null: line search, or method lm",
        lambda found: found.step or None),
    tie=(num("1", ge=0, le=1), "relative gap below which almarkhi counts singular values as equal"),
    iterations=(Count, "most iterations per start; 0: none, method reciprocal", attrgetter("most")),
    length_scale=(num("m", gt=0), "translation rows were divided by it [m]",
        lambda found: found.task.scale(found.robot)),
    tolerances=TOLERANCES,
    version=(str, "of rankdrop", lambda _: VERSION),
)
STRATA = table("strata", name=str, count=Count, residual=(num("1", ge=0), "largest σ_r/σ_1 of them"))
COUNTS = table("counts", converged=Count, near_miss=Count, slow=Count, not_run=Count, crease=Count)
CONFIGURATIONS = table(
    "configurations",
    start=(Positive, "counted from 1"),
    outcome=Literal["converged", "near_miss", "slow", "crease"],
    iterations=Count,
    q=(nonempty(num("joint")), "configuration reached [rad, m]"),
    sigma=(nonempty(num("1", ge=0)), "singular values there, largest first"),
)
FIND_FILE = file(
    "find",
    "Configurations of one corank, one per start.",
    robot=(ROBOT, "", lambda found: (found.robot, found.task, found.rank + found.corank)),
    settings=(FIND_SETTINGS, "", lambda found: found),
    strata=(optional(list_of(STRATA)),
        "only of method reciprocal: what was begun with, and how many configurations came of it", strata),
    counts=(COUNTS, "starts by outcome", lambda found: {kind.name.lower(): found.count(kind) for kind in Outcome}),
    complete=(bool, "false: interrupted"),
    configurations=(list_of(CONFIGURATIONS), "one per start that was run, in order", configurations),
)
