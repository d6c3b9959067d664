"""Families found numerically held against families derived exactly: have they the same points?

Neither side knows how the other came about. Random points of each family, solutions of its own equations from random
starts, are tried on the families of the other side: every point has to lie on one of them, of the same corank and
dimension. What is one family here may be several there, so a union is as good as a single one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.compare.cloud import WITHIN, Cloud, explained
from rankdrop.exact.family import ExactFamily
from rankdrop.families.signature import HIGHER
from rankdrop.family.equation import normalised
from rankdrop.family.record import Check, Family
from rankdrop.family.system import REACHED, Mask, System
from rankdrop.problem import Problem
from rankdrop.robot.model import Array
from rankdrop.tolerances import Tolerances
from rankdrop.units import as_given

STARTS = 256
"""Random starts for the points of each family: 32 combinations of values get eight each."""
CONDITIONED = 1e-3
"""Points where a family's equations have a smaller slope are known too inexactly to be tried."""
FLAT = 1e-7
"""Where no point has a slope of `CONDITIONED` but one above this, that is the equations' own, and "smaller" is measured
by it: |f| ≤ 1e-15 is 1e-8 rad."""
COMMON = 3
"""So many random points of a family on another one make them kin: a single one may be near where the two cross."""


Side = Family | ExactFamily
"""A family of either side."""


@dataclass(frozen=True, slots=True)
class Match:
    """The exact families that a numeric one consists of.

    Attributes:
        row: id of the numeric family.
        families: ids of the exact ones that lie on it.
        parts: ids of exact ones that share some of their points with it, and the rest with other rows.
    """

    row: str
    families: tuple[str, ...]
    parts: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Wider:
    """A family of either side whose conditions hold on more than the family.

    Of several sets that the conditions describe together only some are meant; the others are of a lower corank.

    Attributes:
        family: its id on its own side.
        solved, elsewhere: random solutions of its conditions, and how many of them have a lower corank.
    """

    family: str
    solved: int
    elsewhere: int


@dataclass(frozen=True, slots=True)
class Difference:
    """What does not go together: a family of one side, and in words what is wrong with it on the other.

    Attributes:
        side: "numeric" or "exact".
        family: its id on that side.
        name: in words.
        text: what is wrong.
    """

    side: str
    family: str
    name: str
    text: str

    def __str__(self) -> str:
        return f"{self.side} {self.family} ({self.name}): {self.text}"


@dataclass(frozen=True, slots=True)
class Agreement:
    """How two sets of families go together.

    Attributes:
        matches: one for each numeric family, in order.
        numeric: points of numeric families, and how many lie on an exact one.
        exact: points of exact families, and how many lie on a numeric one.
        differences: none where every point lies on both sides.
        wider: exact families to be read with care.
        loose: numeric ones; their points of a lower corank were not tried on the other side.
    """

    matches: tuple[Match, ...]
    numeric: Check
    exact: Check
    differences: tuple[Difference, ...]
    wider: tuple[Wider, ...] = ()
    loose: tuple[Wider, ...] = ()


def match(
    problem: Problem, rows: Sequence[Side], families: Sequence[Side], *, seed: int = 0
) -> Agreement:
    """Try random points of each family on the families of the other side.

    A family and another share a component when points of one lie on the other and their dimensions agree: random
    points of an irreducible set lie on another set only if all of it does.

    Args:
        problem: the arm of both sides, of whatever corank. Where it asks for limits only points within them count, and
            a family without any is left out; `explained` is the longest way from a point to a family that holds there.
        rows: found numerically. One without equations is known by its witness alone, its dimension not at all.
        families: derived exactly, of the same coranks.
        seed: of the starts.

    Returns:
        Agreement.

    Example:
        >>> from rankdrop.families.table import families
        >>> from rankdrop.families.searching import search
        >>> from rankdrop.problem import Problem
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("scara")
        >>> rows = families(search(arm, 1, starts=100)).families
        >>> match(Problem(arm, resolve_task(None, arm)), rows, rows).matches
        (Match(row='k1.f1', families=('k1.f1',), parts=()),)
    """
    kin: set[tuple[str, str]] = set()
    inside: set[tuple[str, str]] = set()
    counts = {True: Check(0, 0), False: Check(0, 0)}
    said: list[Difference] = []
    wider: dict[bool, list[Wider]] = {True: [], False: []}
    for corank in sorted({one.corank for one in (*rows, *families)}):
        here = problem.at(corank)
        mine = [row for row in rows if row.corank == corank]
        other = [family for family in families if family.corank == corank]
        for numeric, tried, there in ((True, mine, other), (False, other, mine)):
            rng = np.random.default_rng([seed, corank, numeric])
            own, others = ("numeric", "exact") if numeric else ("exact", "numeric")
            for one in tried:
                points = solutions(here, one, rng)
                met, related, around, wrong = _tried(here, one, points, there, others)
                counts[numeric] = Check(counts[numeric].tested + met.tested, counts[numeric].agree + met.agree)
                said += [Difference(own, one.id, one.name, text) for text in wrong]
                kin |= {(one.id, name) if numeric else (name, one.id) for name in related}
                if not numeric:
                    inside |= {(name, one.id) for name in around}
                if points.elsewhere:
                    wider[numeric].append(Wider(one.id, points.solved, points.elsewhere))
    matches = tuple(_match(row.id, families, kin, inside) for row in rows)
    return Agreement(matches, counts[True], counts[False], tuple(said), tuple(wider[False]), tuple(wider[True]))


def _match(row: str, families: Sequence[Side], kin: set[tuple[str, str]], inside: set[tuple[str, str]]) -> Match:
    related = [family.id for family in families if (row, family.id) in kin]
    whole = tuple(name for name in related if (row, name) in inside)
    return Match(row, whole, tuple(name for name in related if name not in whole))


@dataclass(frozen=True)
class Points:
    """Configurations on a family.

    Attributes:
        q: (N, n) its witness first, where that satisfies the equations; then random ones.
        special: how many at the beginning are not random.
        solved, elsewhere: solutions of the equations, and how many were left out for their lower corank.
    """

    q: Array
    special: int
    solved: int = 0
    elsewhere: int = 0


def _tried(
    problem: Problem, family: Side, points: Points, others: Sequence[Side], theirs: str
) -> tuple[Check, list[str], list[str], list[str]]:
    """Points of one family, tried on those of the other side, which is called `theirs`.

    Returns:
        How many of the points lie on one of the others; ids of the others that some point lies on and whose dimension
        is the same, and of those on which all of them lie; sentences on what does not go together.
    """
    q, wrong = points.q, list[str]()
    if not len(q):
        if not problem.limits:
            wrong.append("no configuration satisfies its own conditions, its witness included")
        return Check(0, 0), [], [], wrong
    on = np.array([lies_on(other, q, problem.tolerances) for other in others], dtype=np.bool_).reshape(-1, len(q))
    left = np.flatnonzero(~on.any(axis=0))
    if len(left):  # where sheets cross, the way to a family is not told from its square
        cloud = Cloud(problem.robot, problem.task, q[left], np.full(len(left), problem.corank))
        _, over = explained(cloud, [other.equations for other in others if other.equations], problem.tolerances)
        left = left[over]
    generic = on[:, points.special :] if len(q) > points.special else on
    met = [k for k, mask in enumerate(generic) if mask.sum() >= min(COMMON, len(mask))]
    vague = not family.equations or any(not others[k].equations for k in met)
    kin = [k for k in met if vague or others[k].dimension == family.dimension]
    if len(left):
        at = ", ".join(f"{x:.6g}" for x in as_given(problem.robot, q[left[0]]))
        wrong.append(
            f"{len(left)} of {len(q)} of its points lie on no {theirs} family of this corank, q = ({at}) is one"
        )
    if met and not kin:
        dimensions = ", ".join(map(str, sorted({others[k].dimension for k in met})))
        wrong.append(f"dimension {family.dimension}, but the {theirs} families on it have {dimensions}")
    around = [others[k].id for k in kin if generic[k].all()]
    return Check(len(q), len(q) - len(left)), [others[k].id for k in kin], around, wrong


def solutions(problem: Problem, family: Side, rng: np.random.Generator) -> Points:
    """Solutions of a family's equations from random starts, where these are well conditioned.

    Those of a lower corank are left out, and counted.

    Args:
        problem: the arm and the corank.
        family: of either side.
        rng: of the starts.
    """
    witness = np.array([family.witness], dtype=np.float64)
    if not family.equations:
        return Points(witness, 1)
    system = _system(family)
    witness = witness[np.abs(system.values(witness)).max(axis=1) <= problem.tolerances.explained]
    q, _ = system.solve(problem.random(STARTS, rng), iterations=60)
    q = q[np.abs(system.values(q)).max(axis=1) <= REACHED]
    slopes = np.linalg.svd(system.jacobian(q), compute_uv=False)
    slope = slopes[:, min(problem.n - family.dimension, slopes.shape[1]) - 1]
    best = float(slope.max(initial=0.0))
    q = q[slope > CONDITIONED * (best if FLAT < best < CONDITIONED else 1.0)]
    singular = problem.sigma(q)[:, problem.rank] <= HIGHER
    q = q[singular | system.zero(q)]  # what is regular and all but a zero is neither here nor there
    singular = problem.sigma(q)[:, problem.rank] <= HIGHER
    solved, q = len(q), q[singular]
    elsewhere = solved - len(q)
    witness, q = witness[problem.allowed(witness)], q[problem.allowed(q)]
    return Points(np.concatenate([witness, q]), len(witness), solved, elsewhere)


def _system(family: Side) -> System:
    return System(tuple(normalised(equation.terms) for equation in family.equations))


def lies_on(other: Side, q: Array, tolerances: Tolerances) -> Mask:
    """(N,) which points lie on a family; one without equations is known by its witness alone."""
    if not other.equations:
        near: NDArray[np.bool_] = np.linalg.norm(q - np.array(other.witness), axis=1) <= tolerances.explained
        return near
    way, _ = _system(other).nearest(q, WITHIN)
    return np.asarray(way <= tolerances.explained)
