"""Tables of the files of `cover`, `verify`, and of certificates."""

from __future__ import annotations

from operator import attrgetter
from typing import Any, Literal

import numpy as np
from msgspec import UNSET

from rankdrop.codec import Count, Positive, list_of, nonempty, num, optional, pair, row, table, text, whole
from rankdrop.cover.spots import UnexplainedBoxes
from rankdrop.proof.record import Tolerance
from rankdrop.schema.arm import FRAME, ROBOT, file
from rankdrop.text.coverings import covering_end_words
from rankdrop.version import VERSION

ARM_JOINTS = table(
    "arm_joints",
    name=str,
    kind=Literal["revolute", "prismatic", "helical"],
    screw=(row(num("screw"), 6),
        "twist (v; ω) at q = 0 in base coordinates, linear part first; the axis has the direction of ω (of v "
        "for a slide), whatever its length"),
    variable=(Positive, "number of the variable that moves it"),
    follows=(str | None, "name of the joint that it follows"),
    multiplier=num("ratio"),
    offset=(num("joint"), "value = multiplier · variable + offset"),
    lower=(optional(num("joint") | None), "limit; null: none"),
    upper=(optional(num("joint") | None), "limit; null: none"),
)
ARM = table(
    "arm",
    name=str,
    joints=nonempty(ARM_JOINTS, min_length=1, max_length=32),
    home=(row(row(num("pose"), 4), 4), "of the tip at q = 0"),
    last=(row(row(num("pose"), 4), 4), "of the frame of the last link at q = 0"),
    fingerprint=(str, "of the arm's numbers, as in a covering"),
)
TASK = table("task", name=str, rows=nonempty(whole(ge=0, le=5)), frame=FRAME)
VIEW = table("view", link=Count, point=(row(num("m"), 3), "at q = 0 in base coordinates"), length=num("m", gt=0))
CERTIFICATE_TOLERANCE = table(
    "certificate_tolerance",
    of=Tolerance,
    length=num("m", ge=0),
    angle=num("rad", ge=0),
    points=list_of(row(num("m"), 3)),
)
_PLACE = (pair(Count, num("1", ge=0, le=1)), "stretch from 0, share of the way to the next row")
SPAN = table(
    "span",
    from_=_PLACE,
    to=_PLACE,
    kind=(Literal["free", "crossing", "open"],
        "free: the rank is kept; crossing: a configuration of lower rank lies between the places of `bracket`; "
        "open: nothing is claimed"),
    bracket=optional(row(_PLACE[0], 2)),
)
PATH_SOURCE = table(
    "path_source", file=str, sha256=(text(pattern="^[0-9a-f]{64}$"), "of the bytes of the file")
)
CLAIM = table(
    "claim",
    q=(optional(list_of(num("joint"))), "centre [rad, m]"),
    radius=(optional(num("distance", ge=0)),
        "of a ball: every configuration nearer to q in the joints that matter has the rank; of an existence: a "
        "configuration of lower rank differs from q by at most this in every joint; of a posture change: an exact "
        "solution of the pose of the first point differs from the last one by at most this in every joint"),
    scale=(optional(list_of(num("joint"))),
        "unit of motion of each variable: 1 for turns [rad], a length for slides [m]"),
    verdict=(optional(Literal["free", "met"]), "of a path; free: every span is"),
    degree=(optional(whole(ge=1, le=9)), "of a posture change 1"),
    points=(optional(nonempty(list_of(num("joint")), min_length=2)),
        "Bernstein control points of all stretches, the last of each the first of the next [rad, m]"),
    spans=(optional(nonempty(SPAN)), "from the first row to the last without a gap"),
    path=(optional(PATH_SOURCE), "the file that the path was read from"),
    min_distance=(optional(num("distance", gt=0)), "no configuration nearer to the path has a lower rank"),
    file=(optional(str), "name of the covering (`rankdrop cover --out`), in the same folder"),
    sha256=(optional(str), "its hash"),
    variables=optional(list_of(Positive)),
    lower=optional(list_of(num("joint"))),
    upper=optional(list_of(num("joint"))),
    turns=optional(list_of(bool)),
    limits=(optional(bool), "the boxes are within the joint limits; the posture change is"),
    structure=(optional(Literal["axes 1, 2 meet", "axes 1, 2 parallel", "axes 2, 3 parallel", "axes 2, 3 meet",
            "three parallel", "orientation", "planar"]),
        "of a sign proof: which axes meet or are parallel"),
    corank=(optional(Positive), "every configuration of this corank or more is in a box"),
)
CERTIFICATE_FILE = file(
    "certificate",
    "Written with --certificate by `rankdrop nearest`, `explain`, `path`, `cover` and `aspects`, checked by `rankdrop "
    "verify`: a claim, the numbers of the arm it is about, and what a checker needs to prove it again. Joints are"
    " numbered from 1; angles in rad, lengths in the arm's unit (m).",
    kind=Literal["ball", "path", "covering", "existence", "posture change", "sign proof"],
    version=(str, "of rankdrop that wrote it"),
    arm=ARM,
    task=TASK,
    rank=(whole(ge=1, le=6), "that is kept; of an existence, that is not reached"),
    view=(VIEW, "where the proof looks from: any would do"),
    tolerance=CERTIFICATE_TOLERANCE | None,
    claim=(CLAIM, "entries by the kind"),
    proof=(dict[str, Any], "what the checker needs"),
    sha256=(text(pattern="^[0-9a-f]{64}$"), "of the rest as JSON, keys sorted, no blanks, ASCII: reveals damage"),
)
COVER_SETTINGS = table(
    "cover_settings",
    width=num("distance", gt=0),
    limits=bool,
    corank=(whole(ge=1, le=6), "the boxes hold every configuration of this corank or more"),
    version=str,
)
LEAF = table("leaf", halvings=(list_of(Count), "", attrgetter("covering.plan.depth")), width=num("distance"))

EXPLAINED_FAMILIES = table("explained_families", id=str, name=str, boxes=Count)
PLACES = table(
    "places",
    of=UnexplainedBoxes,
    boxes=Count,
    proven=Count,
    kind=Literal["singular, proven", "singular, found", "near miss", "undecided"],
    sigma=num("1"),
    q=list_of(num("joint")),
    lower=list_of(num("joint")),
    upper=list_of(num("joint")),
)
_MOST_PLACES = 1000
EXPLAINED = table(
    "explained",
    source=Literal["catalogue", "analysis", "made here"],
    families=(list_of(EXPLAINED_FAMILIES), "", lambda account: [
        {"id": family.id, "name": family.name, "boxes": int(count)}
        for family, count in zip(account.families, account.explained, strict=True)
    ]),
    freed=Count,
    diagonal=num("distance"),
    places=(list_of(PLACES), "", lambda account: account.spots[:_MOST_PLACES]),
    places_in_all=(Count, "", lambda account: len(account.spots)),
)

VERIFIED_FILE = file(
    "verified",
    "Written by `rankdrop verify --json`: whether a certificate holds.",
    units=None,
    holds=bool,
    kind=(Literal["ball", "path", "covering", "existence", "posture change", "sign proof", ""],
        "empty: the file is damaged"),
    arm=str,
    claim=(str, "what holds; empty where it does not"),
    statement=(optional(list_of(str)), "the whole claim, entry by entry: arm, task, place, ranges"),
    reason=(str, "why it does not hold; empty where it does"),
    assumed=(list_of(str), "what the proof rests on in addition to the arm's numbers"),
    how=(optional(str), "how the boxes of a covering were proven"),
    enclosures=Count,
    complete=(bool, "false: interrupted"),
    version=(str, "", lambda _: VERSION),
)


def _cells_in_all(shape: Any) -> float:
    """Boxes of the last level, free or not; they may be more than 2⁶³."""
    return float(np.prod(shape.cells(shape.levels), dtype=np.float64))


BOXES = table(
    "boxes",
    all=(num("1"), "", lambda covering: _cells_in_all(covering.tree.shape)),
    left=(Count, "", attrgetter("tree.leaves")),
    proven=(Count, "", attrgetter("tree.proven_leaves")),
    tested=Count,
)


def _needed(covered: Any) -> Any:
    """The estimate of the work, where a covering ended early: one read again from its file has no estimate."""
    if covered.covering.stopped is None:
        return UNSET
    return covered.covering.needed or UNSET


COVER_FILE = file(
    "cover",
    "Written by `rankdrop cover --json`: boxes of the joint space that hold every singular configuration, and "
    "what known families explain of them. The boxes themselves are in the file of `--out`.",
    robot=(ROBOT, "", lambda covered: (covered.robot, covered.task, covered.covering.plan.rank)),
    settings=(COVER_SETTINGS, "", attrgetter("covering.plan")),
    method=(Literal["split determinant", "enclosures"], "", attrgetter("covering.plan.method")),
    sentence=str,
    complete=(bool, "the whole joint space was covered; else nothing is said of the rest"),
    stopped=(str | None, "", lambda covered: covering_end_words(covered.covering.stopped) or None),
    needed=(optional(Count), "of a covering that ended early: enclosures that all of it takes, estimated from random "
        "ways down its tree; since 0.3", _needed),
    joints=(list_of(Positive), "", attrgetter("covering.plan.variables")),
    ranges=(list_of(row(num("joint"), 2)), "",
        lambda covered: list(zip(covered.covering.plan.lower, covered.covering.plan.upper, strict=True))),
    leaf=(LEAF, "", lambda covered: covered),
    boxes=(BOXES, "all: boxes of the last level; left: not proven free; proven: to hold a singular configuration",
        attrgetter("covering")),
    free_share=(num("1", ge=0, le=1), "", attrgetter("covering.free_share")),
    sha256=(str | None, "", lambda covered: covered.sha256 or None),
    explained=(EXPLAINED | None, "", attrgetter("account")),
)
