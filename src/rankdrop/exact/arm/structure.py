"""What holds between the axes of an arm at every configuration: axes that meet in one point, parallel axes.

Read off the exact twists and lengths: a length is zero or it is not, a letter never is. In the frame of link m (z along
axis m) another axis passes through the origin when the linear part of its screw is zero, and is parallel to axis m
when its direction is (0, 0, ±1); both as polynomials, hence at every configuration.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import acos, degrees

from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.geometry import Deviation, Section
from rankdrop.robot.model import JointKind
from rankdrop.robot.numbers import reach
from rankdrop.tolerances import ALIGNED
from rankdrop.units import counted_length

SMALL = 0.02
"""Lengths up to this share of the reach, and angles up to this [rad], are called small: 12 mm of a 1.2 m arm are."""


@dataclass(frozen=True, slots=True)
class ExactStructure:
    """What holds between the axes at every configuration. Joints are numbered from 1.

    Attributes:
        joints: how many there are.
        points: triples of consecutive axes that meet in one point.
        parallel: groups of two or more axes that are parallel.
        meeting: pairs of consecutive axes that meet in a point.
        near: what is missed by little.
        remarks: what was rounded to make the arm exact, from `Chain.remarks`.
    """

    joints: int
    points: tuple[tuple[int, int, int], ...]
    parallel: tuple[tuple[int, ...], ...]
    meeting: tuple[tuple[int, int], ...]
    near: tuple[Deviation, ...]
    remarks: tuple[str, ...]

    @property
    def wrist(self) -> tuple[int, ...]:
        """The last three joints where their axes meet in one point, else empty."""
        last = (self.joints - 2, self.joints - 1, self.joints)
        return last if last in self.points else ()

    @property
    def shoulder(self) -> tuple[int, ...]:
        """The first three joints where their axes meet in one point, else empty."""
        return (1, 2, 3) if (1, 2, 3) in self.points else ()

    @property
    def srs(self) -> bool:
        """Seven joints, spherical shoulder and spherical wrist: S-R-S."""
        return self.joints == 7 and bool(self.wrist and self.shoulder)

    def sentences(self) -> tuple[str, ...]:
        """All of it in words, what is missed by little and what was rounded last."""
        found = ["S-R-S: spherical shoulder, elbow, spherical wrist"] if self.srs else []
        for triple in self.points:
            part = {self.wrist: " (spherical wrist)", self.shoulder: " (spherical shoulder)"}.get(triple, "")
            found.append(f"the axes of joints {listed(triple)} meet in one point{part}")
        within = {pair for triple in self.points for pair in pairwise(triple)}
        found += [f"axes {i} and {j} meet" for i, j in self.meeting if (i, j) not in within]
        found += [f"the axes of joints {listed(group)} are parallel" for group in self.parallel]
        found += [f"near-structural: {near.text}" for near in self.near]
        if self.remarks:
            found.append(f"twists are multiples of 15° and 18° where they are that within {ALIGNED:g} rad")
            found += self.remarks
        return tuple(found)


def structure_of(chain: Chain) -> ExactStructure:
    """Recognise the structure of an arm.

    Args:
        chain: from `exact_chain`; lengths and twists are judged as they stand there, letters are never zero.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> structure_of(exact_chain(open_robot("puma560"))).sentences()[0]
        'the axes of joints 4, 5, 6 meet in one point (spherical wrist)'
    """
    revolute = [s.kind is JointKind.REVOLUTE for s in chain.sections]
    neighbours = [i for i in range(1, chain.n) if revolute[i - 1] and revolute[i]]
    triples = [(i, i + 1, i + 2) for i in neighbours if i + 1 in neighbours]
    return ExactStructure(
        joints=chain.n,
        points=tuple(triple for triple in triples if _meet_in_one(chain, triple)),
        parallel=_parallel(chain, revolute),
        meeting=tuple((i, i + 1) for i in neighbours if _meet(chain, i)),
        near=(*_nearly_in_one(chain, triples), *_nearly_parallel(chain, neighbours)),
        remarks=chain.remarks,
    )


def triples(chain: Chain) -> list[tuple[tuple[int, int, int], str]]:
    """Three successive joints that are equivalent to a spherical or a planar joint.

    In the frame of the middle one (z along its axis) their screws have v = 0, or v_z = ω_x = ω_y = 0.
    """
    found = []
    for first in range(1, chain.n - 1):
        three = chain.screws(first + 1)[first - 1 : first + 2]
        for name, rows in (("spherical", (0, 1, 2)), ("planar", (2, 3, 4))):
            if all(column[r] == 0 for column in three for r in rows):
                found.append(((first, first + 1, first + 2), name))
    return found


def check_basic(chain: Chain, basic: Sequence[int] | None) -> None:
    """Raises OptionError unless `basic` is None or six different joints of the chain."""
    if basic is not None and (len(set(basic)) != 6 or len(basic) != 6 or not set(basic) <= set(range(1, chain.n + 1))):
        raise OptionError(
            "the basic screws are six different joints", where="basic", got=str(list(basic)), allowed=f"1 … {chain.n}"
        )


def listed(joints: tuple[int, ...]) -> str:
    """ "4, 5, 6"."""
    return ", ".join(str(joint) for joint in joints)


def _meet(chain: Chain, i: int) -> bool:
    return _twisted(chain.sections[i - 1]) and chain.length(i - 1, "a") == 0


def _twisted(section: Section) -> bool:
    """Whether the axes before and after a link are not parallel."""
    return section.twist.sin != 0


def _meet_in_one(chain: Chain, triple: tuple[int, int, int]) -> bool:
    """Both normals have no length and their feet on the middle axis coincide; no two of the axes are parallel."""
    first, middle, _ = triple
    apart = all(_twisted(chain.sections[j - 1]) for j in (first, middle))
    return apart and not any(x != 0 for screw in chain.near(middle, triple) for x in screw[:3])


def _parallel(chain: Chain, revolute: list[bool]) -> tuple[tuple[int, ...], ...]:
    groups: list[list[int]] = []
    for j in (j for j in range(1, chain.n + 1) if revolute[j - 1]):
        # a joint between that is not parallel to two others turns one about itself: those in a row are enough
        axis = chain.near(groups[-1][-1], [j])[0][3:5] if groups else None
        if axis is not None and not any(x != 0 for x in axis):
            groups[-1].append(j)
        else:
            groups.append([j])
    return tuple(tuple(group) for group in groups if len(group) > 1)


def _nearly_in_one(chain: Chain, triples: list[tuple[int, int, int]]) -> list[Deviation]:
    """Triples whose normals and offset are small, not all zero."""
    found = []
    for first, middle, last in triples:
        before, own = chain.sections[first - 1], chain.sections[middle - 1]
        if not (_twisted(before) and _twisted(own)):
            continue
        miss = max(abs(float(x)) for x in (before.a, own.d, own.a))
        if 0 < miss <= SMALL * reach(chain.robot):
            joints = (first, middle, last)
            by = _in_words(miss, counted_length(chain.robot))
            text = f"the axes of joints {listed(joints)} miss a common point by {by}"
            found.append(Deviation("point", joints, miss, text))
    return found


def _nearly_parallel(chain: Chain, neighbours: list[int]) -> list[Deviation]:
    found = []
    for i in neighbours:
        twist = chain.sections[i - 1].twist
        angle = acos(min(1.0, abs(float(twist.cos))))
        if twist.sin != 0 and angle <= SMALL:
            text = f"axes {i} and {i + 1} are {degrees(angle):.2g}° from parallel"
            found.append(Deviation("parallel", (i, i + 1), angle, text))
    return found


def _in_words(length: float, unit: float) -> str:
    """In thousandths of the unit that was given; of an arm given in metres, in mm."""
    return f"{length * 1000:.4g} mm" if unit == 1.0 else f"{length:.4g} m"
