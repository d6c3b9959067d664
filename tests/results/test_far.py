"""How far the nearest singularity is: where two methods disagree, it is said."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from rankdrop.distance.distance import FamilyDistance
from rankdrop.results.explained import Difference, DifferenceKind
from rankdrop.results.far import differences
from rankdrop.robot.open import open_robot
from rankdrop.text.verdict import difference_sentence
from rankdrop.verbs.explain import explain


def test_disagreement_is_said() -> None:
    far = explain(open_robot("pa10"), [0.1, 1.2, 0.4, 0.3, 0.7, 1.3, 0.2]).far  # θ4 = 0 is the nearest
    nearest = far.nearest
    assert nearest is not None

    def verdict(some: tuple[FamilyDistance, ...], **changed: float) -> list[Difference]:
        changed_far = replace(far, families=some, nearest=replace(nearest, **changed))
        return list(differences(changed_far, ()))

    first, *rest = far.families
    assert verdict(far.families) == []
    assert verdict(tuple(rest)) == [Difference(DifferenceKind.FAMILIES_MISSED)]
    assert verdict(tuple(replace(one, distance=inf) for one in far.families)) == verdict(tuple(rest))
    unnamed = replace(first, family=replace(first.family, named=False), distance=inf)
    assert verdict((*rest, unnamed)) == []  # a family without conditions was not asked
    (missed,) = verdict(far.families, distance=0.5)
    told = f"the search missed a nearer point of family {first.family.id} ("
    assert difference_sentence(missed).startswith(told)
