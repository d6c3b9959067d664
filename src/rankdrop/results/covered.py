"""What `cover` returns: the boxes, what known families explain of them, and what may be said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.covering import Covering
from rankdrop.codec import Result
from rankdrop.families.box_matching import Spot
from rankdrop.family.record import Family
from rankdrop.proof.boxes import digest
from rankdrop.robot.model import Robot
from rankdrop.robot.quantities import count
from rankdrop.sections import Section
from rankdrop.task import Task

_SHOWN = 20  # places in the text


@dataclass(frozen=True, eq=False)
class Account:
    """The boxes of a covering beside known families.

    Attributes:
        families: the families asked.
        source: where they come from: "catalogue", "analysis", "made here".
        explained: (F,) boxes that each explains, the first that does.
        freed: boxes that no family explained and a closer look proved free.
        spots: what is left, in groups.
        diagonal: of a leaf; no singular configuration of an explained box is farther from a known family [rad].
    """

    families: tuple[Family, ...]
    source: str
    explained: NDArray[np.int64]
    freed: int
    spots: tuple[Spot, ...]
    diagonal: float


@dataclass(frozen=True, eq=False)
class Covered(Result):
    """Every singular configuration, of the corank asked for or more, is in a box of `covering`.

    Attributes:
        robot, task: what was covered.
        covering: the boxes.
        account: what known families explain of them; None where that was not asked, or the covering is not complete.
    """

    robot: Robot
    task: Task
    covering: Covering
    account: Account | None
    FILE: ClassVar[str] = "cover"

    @property
    def complete(self) -> bool:
        """The whole joint space was covered."""
        return self.covering.complete

    @property
    def holds(self) -> bool:
        """Complete, and nothing but known families was found down to the width, where families were asked."""
        return self.complete and (self.account is None or not self.account.spots)

    @property
    def width(self) -> float:
        """The widest side of a leaf [rad; slides divided by the length scale]."""
        shape = self.covering.tree.shape
        sides = (np.array(self.covering.plan.upper) - self.covering.plan.lower) / shape.cells(shape.levels)
        turns = [self.robot.variables[j - 1].unit == "rad" for j in self.covering.plan.variables]
        return float(np.where(turns, sides, sides / self.task.scale(self.robot)).max())

    @property
    def sha256(self) -> str:
        """Hash of plan and boxes: the same for every way the covering was made; "" where it is not complete."""
        return digest(self.covering.plan, self.covering.tree) if self.complete else ""

    @property
    def sentence(self) -> str:
        """What may be said, in one sentence."""
        if not self.complete:
            share = 100 * float(self.covering.tree.finished.mean())
            why = f" ({self.covering.stopped})" if self.covering.stopped else ""
            return f"Not complete{why}: {share:.1f} % of the joint space was covered, nothing is said of the rest."
        if not self.covering.tree.leaves:
            within = " within the limits" * self.covering.plan.limits
            return f"There is no {self._what}{within}: all of the joint space is proven free."
        if self.account is None:
            return f"Covered: every {self._what} lies in one of {self.covering.tree.leaves:,} boxes."
        if not self.account.spots:
            return (
                f"Nothing else exists down to {self.width:.3g} rad. Every box that may hold a {self._what} "
                f"is explained by a known family; none lies farther than {self.account.diagonal:.3g} rad from one."
            )
        boxes = sum(one.boxes for one in self.account.spots)
        proven = sum(one.proven for one in self.account.spots)
        return (
            f"Not all is explained: known families leave {boxes:,} boxes in {count(len(self.account.spots), 'place')} "
            f"to look at, {proven:,} of them proven to hold a singularity."
        )

    @property
    def _what(self) -> str:
        corank = self.covering.plan.corank
        return "singular configuration" if corank == 1 else f"configuration of corank {corank} or more"

    def sections(self, *, deg: bool = True) -> tuple[Section, ...]:
        """As sections of text; angles of places in degrees, or radians."""
        covering, plan = self.covering, self.covering.plan
        tree = covering.tree
        joints = ", ".join(f"θ{j}" if self.robot.variables[j - 1].unit == "rad" else f"q{j}" for j in plan.variables)
        whose = "" if self.complete else " of the part done"
        left = [("boxes left", f"{tree.leaves:,}{whose}")]
        if tree.leaves:
            share = 100 * tree.proven_leaves / tree.leaves
            left = [("boxes left", f"{tree.leaves:,}; every {self._what}{whose} is in one"),
                    ("proven to hold one", f"{tree.proven_leaves:,} ({share:.1f} %)")]  # fmt: skip
        free = f"{100 * covering.free_share:.2f} % of the joint space{' within the limits' * plan.limits}"
        rows = (
            ("joints that decide", joints),
            ("method", plan.method),
            ("boxes no wider than", f"{self.width:.4g} rad"),
            ("proven free", free),
            *left,
            ("boxes tested", f"{covering.tested:,}"),
        )  # fmt: skip
        after = (f"sha256 {self.sha256}",) if self.complete else ()
        parts = [
            Section("", lines=(self.sentence,)),
            Section(f"{self.robot.name}: covering", columns=("what", "found"), rows=rows, texts=(0, 1), after=after),
        ]
        if self.account is not None:
            parts += _account_sections(self.account, plan.variables, deg=deg)
        return (*parts, Section("", lines=(self.sentence,)))


def _account_sections(account: Account, joints: tuple[int, ...], *, deg: bool) -> list[Section]:
    rows = [
        (family.id, family.name, f"{count:,}")
        for family, count in zip(account.families, account.explained, strict=True) if count
    ]  # fmt: skip
    if account.freed:
        rows.append(("", "no family, but proven free on a closer look", f"{account.freed:,}"))
    notes = ("A box counts for the first family that has a point within half a diagonal of its centre.",
             "A box that was halved on counts for a family from which nothing that is left of it is farther than a "
             "diagonal.")  # fmt: skip
    made = [
        Section("Explained", f"by families from: {account.source}", columns=("family", "", "boxes"), rows=tuple(rows),
                texts=(0, 1), notes=notes)
    ]  # fmt: skip
    if account.spots:
        made.append(_places(account.spots, joints, deg=deg))
    return made


def _places(spots: tuple[Spot, ...], joints: tuple[int, ...], *, deg: bool) -> Section:
    factor, unit = (180 / np.pi, "°") if deg else (1.0, "rad")
    rows = tuple(
        (f"{one.boxes:,}", f"{one.proven:,}", one.kind, f"{one.sigma:.2g}",
         ", ".join(f"{value * factor:.4g}" for value in one.q[np.array(joints) - 1]))
        for one in spots[:_SHOWN]
    )  # fmt: skip
    more = (f"and {len(spots) - _SHOWN:,} more places",) if len(spots) > _SHOWN else ()
    names = ", ".join(f"{j}" for j in joints)
    return Section(
        "Places to look at", "no known family explains these boxes",
        columns=("boxes", "proven", "", "σ", f"joints {names} [{unit}]"), rows=rows, texts=(2, 4), after=more,
    )  # fmt: skip
