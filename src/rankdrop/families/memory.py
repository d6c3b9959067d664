"""What is remembered of a similar arm: which terms the conditions of its coupled joints have.

Arms that differ in a length have families of the same form with other coefficients. Finding the form costs most of a
table; where it is known, only the coefficients are fitted, to points of the arm itself. Nothing else is taken over: the
cloud, the signatures, the soundness and the completeness of every row are the arm's own, and points that no row
explains are treated as they are without a memory. So a family that appears is met by the searches, one that vanishes
has no points, and one that splits has points of other signatures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rankdrop.families.fit import holds, refit, vanishing
from rankdrop.families.linear import FamilyPoints, Values, gathered, spread
from rankdrop.families.signature import Signature
from rankdrop.family.equation import Equation, Term, normalised
from rankdrop.robot.model import Array

HELD = 40  # points more than terms, of which every fifth is held out of the fit
FORMS = 4  # forms tried for one set of points

Form = tuple[Equation, ...]


@dataclass(eq=False)
class Memory:
    """Conditions of coupled joints as they were fitted, by corank, signature and values.

    Attributes:
        forms: what was fitted.
        names: what families of one form, pinned at the same values, are called: the first arm's name stays.
        recalled: how many sets of conditions were fitted from their known form.
        sought: how many were looked for from nothing.
    """

    forms: dict[tuple[int, Signature], dict[Values, Form]] = field(default_factory=dict)
    names: dict[tuple[int, Signature, tuple[Values, ...]], str] = field(default_factory=dict)
    recalled: int = 0
    sought: int = 0

    def keep(self, corank: int, signature: Signature, values: Values, residual: Form) -> None:
        """Note what was fitted."""
        self.forms.setdefault((corank, signature), {})[values] = residual

    def name(self, corank: int, signature: Signature, sets: tuple[Values, ...], make: Callable[[], str]) -> str:
        """The name of a family: a known one, else as it is made."""
        key = (corank, signature, sets)
        if key not in self.names:
            self.names[key] = make()
        return self.names[key]

    def recall(self, source: FamilyPoints, corank: int) -> list[Form]:
        """Conditions of a known form with coefficients fitted to the points; every form that fits, the likeliest first.

        Args:
            source: points of one family with one combination of values.
            corank: of the search.
        """
        known = self.forms.get((corank, source.signature), {})
        order = sorted(known, key=lambda values: (values != source.values, values))
        forms = list(dict.fromkeys(_terms(known[values]) for values in order))[:FORMS]
        found = (tuple(_fitted(source, one) for one in form) for form in forms)
        return [tuple(one for one in form if one is not None) for form in found if None not in form]


def _terms(form: Form) -> tuple[tuple[Term, ...], ...]:
    """The terms of each condition, without their coefficients."""
    return tuple(tuple(Term(1.0, t.kind, t.harmonics, t.powers, t.shift) for t in one.terms) for one in form)


def _fitted(source: FamilyPoints, terms: tuple[Term, ...]) -> Equation | None:
    """The one combination of the terms that vanishes on the family; None where there is none, or more than one."""
    tolerances, twins = source.problem.tolerances, source.problem.twins
    points = gathered(source(2 * len(terms) + HELD), twins)
    if len(points) < len(terms) + HELD // 2:
        return None
    values = _values(terms, points)
    held = np.arange(len(points)) % 5 == 4
    null = vanishing(values[~held], tolerances)
    if null.shape[1] != 1:
        return None
    best = refit(values[~held], null[:, 0], tolerances)
    kept = [Term(float(c), t.kind, t.harmonics, t.powers, t.shift) for c, t in zip(best, terms, strict=True) if c]
    equation = spread(normalised(kept), twins)
    return equation if holds(equation, points[held]) else None


def _values(terms: tuple[Term, ...], q: Array) -> Array:
    """(N, T) the terms at points."""
    return np.stack([Equation((term,))(q) for term in terms], axis=1)
