"""Conditions of coranks above 1, tried at configurations that the numeric search finds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from rankdrop.exact.conjunctions import SetDerivation
from rankdrop.exact.higher_coranks import UNTRIED, HigherCorank
from rankdrop.families.descent import not_singular
from rankdrop.families.points import cloud
from rankdrop.families.record import Check
from rankdrop.local.block import singular_values
from rankdrop.problem import Mask, Problem
from rankdrop.robot.model import Array
from rankdrop.units import out_of_units

_FOUND = 50  # configurations of each corank that are looked for numerically
_CLEAR = 0.02  # σ from which on a configuration is of a lower corank for certain [1]


def tried_numerically(higher: Iterable[HigherCorank], seed: int) -> tuple[HigherCorank, ...]:
    """The finished derivations with configurations of their corank, and of the one below, that were tried.

    Args:
        higher: derivations of coranks above 1.
        seed: of the search.
    """
    return tuple(_try_corank(corank, seed) if corank.derived.complete else corank for corank in higher)


def _try_corank(corank: HigherCorank, seed: int) -> HigherCorank:
    derived = corank.derived
    return replace(corank, singular=_singular(derived, seed), regular=_regular(derived, seed))


def _singular(derived: SetDerivation, seed: int) -> Check:
    """Configurations of the corank, those left out that 50 digits show to have it nowhere but where conditions hold."""
    chain = derived.chain
    points = cloud(chain.own, chain.own_task, derived.corank, _FOUND, seed).q
    if not len(points):
        return UNTRIED

    def holds(q: Array) -> Mask:
        return derived.holds(out_of_units(chain.robot, q))

    off = points[~holds(points)]
    problem = Problem(chain.own, chain.own_task, derived.corank)
    wrong, _ = not_singular(problem, off, holds)
    return Check(len(points) - int(wrong.sum()), len(points) - len(off))


def _regular(derived: SetDerivation, seed: int) -> Check:
    """Configurations of the corank below, as far as σ shows that they have no higher one."""
    chain = derived.chain
    q: Array = out_of_units(chain.robot, cloud(chain.own, chain.own_task, derived.corank - 1, _FOUND, seed).q)
    clear = singular_values(chain.with_part_angles, q, chain.task)[:, chain.task.m - derived.corank] > _CLEAR
    held = derived.holds(q[clear])
    return Check(len(held), int((~held).sum()))
