"""What a derivation did not finish, what ended it, and why there is none, in words."""

from __future__ import annotations

from typing import Any

from rankdrop.algebra.halt import Halt, HaltKind
from rankdrop.algebra.roots import PRIMES
from rankdrop.families.not_derived import NotDerived, NotDerivedKind
from rankdrop.families.unfinished import Phase, Unfinished, UnfinishedKind
from rankdrop.options import advise
from rankdrop.robot.quantities import count

_HALTS = {
    HaltKind.WORK: "the limit on work was reached",
    HaltKind.PROCESSOR: "the processor's time ran out",
    HaltKind.INTERRUPTED: "interrupted",
    HaltKind.ERROR: "{error}: {message}",
    HaltKind.COEFFICIENTS: "a condition with roots of numbers has too long coefficients",
    HaltKind.NORM: "no shift makes the norm of a polynomial squarefree",
    HaltKind.SUBSTITUTION: "a condition of {terms:,} terms would grow too long with a solution of {others:,} put in",
    HaltKind.SINES: "a condition of {terms:,} terms is too long to be written in sines and cosines",
    HaltKind.PRODUCT: "a product of polynomials of {terms:,} and {others:,} terms would grow too long",
    HaltKind.FACTORING: "a condition of {terms:,} terms is too long to be factored",
    HaltKind.MINORS: "minors",
    HaltKind.FACTORS: "factors of a polynomial of {terms} terms",
    HaltKind.ELIMINATION: "elimination",
    HaltKind.CASES: "{number} cases",
    HaltKind.EXCEPTIONAL_CASES: "{number} exceptional cases",
}
"""What ended a derivation: a limit, or the step for which no time was left."""
PHASES = {
    Phase.TREE: "the rank tree",
    Phase.FAMILIES: "the families",
    Phase.METHOD: "the method for corank 1",
    Phase.HIGHER: "coranks above 1",
    Phase.STEPS: "the steps",
    Phase.DETERMINANT: "the determinant",
    Phase.POINTS: "sets without points",
    Phase.UNDIVIDED: "the undivided cases",
    Phase.CASES: "the cases that were not taken apart",
    Phase.ASSUMPTIONS: "the assumptions",
    Phase.SPECIAL: "arms of special lengths",
}
"""Phase of a derivation -> the name that its progress shows."""
_UNFINISHED = {
    UnfinishedKind.PHASE: "{phase}: {halt}",
    UnfinishedKind.NOT_RUN: "{phase}",
    UnfinishedKind.SCREWS: "{halt}: the arm's screws were not written down",
    UnfinishedKind.RANK: "{halt} while looking for drops below rank {rank}: {number} sets were not derived to the end",
    UnfinishedKind.SYSTEMS: "{systems} could not be taken apart, three or more of them on the same joints: where they "
    "hold together the rank may drop, and no family says so; numerically found configurations (rankdrop analyze) do "
    "not depend on this",
    UnfinishedKind.UNSEARCHED: "{halt}: {number} of {total} sets were not searched for real points",
    UnfinishedKind.STRAYS: "the conditions of a set of rank {rank} hold at configurations of higher rank, too, and no "
    "further condition was found that separates them: {conditions}",
    UnfinishedKind.DEPENDENT: "a set has real points, but its conditions are dependent at all that were found: "
    "{conditions}",
    UnfinishedKind.REAL_POINTS: "the real points of a set were not all taken apart: {conditions}",
    UnfinishedKind.METHOD: "{method}{halt}",
    UnfinishedKind.ZERO_LENGTHS: "{method}the arm with {conditions} = 0, which this arm has: its conditions are not "
    "these",
    UnfinishedKind.FACTORS: "{method}factors of {polynomials}",
    UnfinishedKind.SUPPRESSION: "suppression did not finish {number} of its cases",
    UnfinishedKind.NUMERIC: "numeric configurations of corank {corank} and above: {halt}",
    UnfinishedKind.ASSUMPTION: "{conditions} is assumed, which is not true of this arm",
}
"""What was not finished; sets without points have more to say."""

_NOT_DERIVED = {
    NotDerivedKind.ERROR: "{error}: {message}",
    NotDerivedKind.TIME: "the derivation takes more than {seconds:g} s",
    NotDerivedKind.INTERRUPTED: "interrupted",
    NotDerivedKind.UNDIVIDED: "{cases}",
    NotDerivedKind.UNFINISHED: "{unfinished}",
    NotDerivedKind.STORED: "{text}",
}
"""Why the families were not derived; an error that rankdrop raises on purpose has its own words."""


def halt_words(halt: Halt) -> str:
    """What ended a derivation: "minors; 3 exceptional cases".

    Example:
        >>> halt_words(Halt(HaltKind.PRODUCT, terms=12000, others=7))
        'a product of polynomials of 12,000 and 7 terms would grow too long'
    """
    words = _HALTS[halt.kind].format(
        terms=halt.terms, others=halt.others, number=halt.number, error=halt.error, message=halt.message
    )
    if halt.waiting is None:
        return words
    return f"{words}; {halt_words(halt.waiting)}"


def unfinished_words(unfinished: Unfinished) -> str:
    """One thing that a derivation did not finish.

    Example:
        >>> unfinished_words(Unfinished(UnfinishedKind.SUPPRESSION, number=3))
        'suppression did not finish 3 of its cases'
    """
    if unfinished.kind is UnfinishedKind.NO_POINTS:
        return _without_points(unfinished)
    halt = ""
    if unfinished.halt is not None:
        halt = halt_words(unfinished.halt)
    phase = ""
    if unfinished.phase is not None:
        phase = PHASES[unfinished.phase]
    number = unfinished.number
    return _UNFINISHED[unfinished.kind].format(
        halt=halt, phase=phase, method=_method(unfinished), corank=unfinished.corank, rank=unfinished.rank,
        number=number, total=unfinished.total, conditions=unfinished.conditions,
        systems=count(number, "system of conditions", "systems of conditions"), polynomials=count(number, "polynomial"),
    )  # fmt: skip


def not_derived_words(reason: NotDerived) -> str:
    """Why the families of an arm were not derived.

    Example:
        >>> not_derived_words(NotDerived(NotDerivedKind.TIME, seconds=30.0))
        'the derivation takes more than 30 s'
    """
    if reason.kind is NotDerivedKind.ERROR and not reason.error:
        return reason.message
    return _NOT_DERIVED[reason.kind].format(
        error=reason.error, message=reason.message, seconds=reason.seconds, cases=cases_words(reason.number),
        unfinished="; ".join(map(str, reason.unfinished)), text=reason.text,
    )  # fmt: skip


def cases_words(number: int) -> str:
    """How many cases were not taken apart.

    Example:
        >>> cases_words(4)
        '4 cases were not taken apart'
    """
    return f"{count(number, 'case was', 'cases were')} not taken apart"


def _method(unfinished: Unfinished) -> str:
    """The method that did not finish: "reciprocity, corank 2: "; "" where it is not named."""
    if not unfinished.method:
        return ""
    if unfinished.corank > 1:
        return f"{unfinished.method}, corank {unfinished.corank}: "
    return f"{unfinished.method}: "


def _without_points(unfinished: Unfinished) -> str:
    """Sets of real configurations that have no point modulo the primes that are tried."""
    sets = count(unfinished.number, "set of real configurations", "sets of real configurations")
    shortest = unfinished.conditions
    if unfinished.number > 1:
        shortest = f"one is {shortest}"
    advice = f"; {advise('lengths', 'letters')} may avoid this"
    if unfinished.letters:
        advice = ""
    return (
        f"{sets} ({shortest}) could not be derived: roots of numbers that stand in the conditions exist modulo none of "
        f"the {len(PRIMES)} primes by which ranks are taken. Whether the rank drops inside is not known{advice}"
    )


def why_lowest(conditions: Any) -> str:
    """Why coranks above the last one were not derived."""
    last = conditions.generic_rank - conditions.lowest
    asked = conditions.settings.coranks
    if conditions.undivided and (asked is None or asked > last):
        return "were not derived separately, and lie on families and cases of lower corank"
    return "were not asked for"
