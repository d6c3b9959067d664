"""GR's procedure on an ordered screw set and Hunt's matrix of cofactors, in words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from rankdrop.local.cofactors import Hunt
from rankdrop.local.instructions import Executed
from rankdrop.local.ordered import OrderedSubset, Products
from rankdrop.local.ordered_report import GREATEST_RUN, Disagreement, OrderedReport, Remark, RemarkKind
from rankdrop.robot.model import Array
from rankdrop.text.words import numbers, plural

_ROUNDING = 1e-12  # an entry of a screw below it is printed as 0

_REMARKS = {
    RemarkKind.AGREES: "",
    RemarkKind.NOT_RESTORED: "named by the printed procedure, but a finite motion does not restore the rank",
    RemarkKind.NO_GAIN: "does not escape although {products} outside the span: Σ λ_i [S_{number}, S_i] {sum}",
    RemarkKind.NAMED_BY_NO_RUN: "escapes, though no run with all its products outside names it",
    RemarkKind.LEFT_SINGULAR: "escapes, though the printed update finds runs still singular: newscrews({number}, "
    "{last}) leaves the screws behind {last} where they were, and joint {number} carries them too",
}


def step_text(step: Executed) -> tuple[str, tuple[str, ...]]:
    """An instruction of GR as it is typed, and the lines that it prints."""
    return f"{step.name}({step.first}, {step.last})", tuple(_step_lines(step))


def _step_lines(step: Executed) -> Iterator[str]:
    match step.found:
        case OrderedSubset() as subset:
            yield from _msos_lines(subset)
        case Products() as products:
            yield from _products_lines(products)
        case int() as dimension:
            yield str(dimension)
        case screws if step.name == "newscrews":
            for number, screw in enumerate(screws, step.first + 1):
                yield f"S({number}) = {_row(screw)}"
        case screws:
            yield from map(_row, screws)


def _products_lines(products: Products) -> Iterator[str]:
    for u, v, inside in products.entries:
        if inside:
            yield f"[{u}, {v}] yes"
        else:
            yield f"[{u}, {v}] no"
    for u in products.actuators:
        yield f"actuating screw {u} can restore ({products.first}, {products.last})"


def _msos_lines(subset: OrderedSubset) -> Iterator[str]:
    if subset.last - subset.first > GREATEST_RUN:  # the guard as printed: 6 < j − i
        yield "more than seven screws: take a shorter run"
        return
    yield f"dimension = {subset.dimension}"
    yield f"lost freedoms = {subset.loss}"
    if subset.msos:
        yield "a minimal singular ordered subset"
    else:
        yield "not a minimal singular ordered subset"


def _row(screw: Array) -> str:
    shown = np.where(np.abs(screw) < _ROUNDING, 0.0, screw)
    return f"[{', '.join(f'{x + 0.0:.6g}' for x in shown)}]"


def remark_text(remark: Remark) -> str:
    """Why the printed procedure and the motion of a joint disagree; empty where they agree and nothing misleads."""
    products = ", ".join(f"[{remark.number}, {later}]" for later in remark.outside)
    if len(remark.outside) == 1:
        products += " lies"
    else:
        products += " lie"
    if remark.vanishes:
        total = "vanishes"
    else:
        total = "stays in the span"
    return _REMARKS[remark.kind].format(number=remark.number, last=remark.last, products=products, sum=total)


def disagreement_text(disagreement: Disagreement) -> str:
    """Where the printed procedure and the motion differ: on disagreement joint, or from run to run."""
    if disagreement.remark is not None:
        return f"joint {disagreement.remark.number}: {remark_text(disagreement.remark)}"
    runs = "; ".join(f"{first}–{last}: {_joints(actuators)}" for first, last, actuators in disagreement.named)
    return f"what the printed procedure names depends on the run it starts from ({runs})"


def procedure_text(report: OrderedReport) -> str:
    """GR's procedure on an ordered screw set, one line a fact; lines end without blanks.

    Example:
        >>> from rankdrop.local.ordered import OrderedScrewSet
        >>> from rankdrop.local.ordered_report import report
        >>> from rankdrop.robot.open import open_robot
        >>> text = procedure_text(report(OrderedScrewSet.of(open_robot("rcrrrr"), [0.0] * 7)))
        >>> print(text.splitlines()[0])
        7 screws of dimension 5, elsewhere 6: 1 task freedom lost, 2 dependencies
    """
    return "\n".join(_procedure_lines(report)) + "\n"


def _procedure_lines(report: OrderedReport) -> Iterator[str]:
    screws = report.dimension + report.dependencies
    if report.lost:
        lost = f"{report.lost} task {plural('freedom', report.lost)} lost"
    else:
        lost = "not singular"
    if report.dependencies == 1:
        both = "1 dependency"
    else:
        both = f"{report.dependencies} dependencies"
    yield f"{screws} screws of dimension {report.dimension}, elsewhere {report.generic}: {lost}, {both}"
    if report.subsets:
        yield from ("", "Runs with a loss (screws, dimension, loss):")
    for run in report.subsets:
        marks = ", passes the msos test" * run.msos + ", minimal" * run.minimal
        yield f"  {run.first}–{run.last}  {run.dimension}  {run.loss}{marks}"
    yield from ("", "As printed (screws moved up to the end of the run only):")
    for step in report.steps:
        instruction, lines = step.text
        yield f"  {instruction};"
        yield from (f"    {line}" for line in lines)
    if report.lost:
        yield from (f"  conclusion: actuate {_joints(report.printed)}", "", *_carried_screw_lines(report))


def _carried_screw_lines(report: OrderedReport) -> Iterator[str]:
    """The same with every later screw carried along, and what finite motion says."""
    for trial in report.trials:
        if trial.dimensions != trial.carried:
            yield (
                f"newscrews({trial.actuator}, {trial.subset[1]}): dimensions {_runs(trial.dimensions)} as printed, "
                f"{_runs(trial.carried)} with every later screw carried along"
            )
    yield from ("", "Every joint, carried to the end of the chain, and judged by finite motion:")
    for joint in report.joints:
        if joint.escapes:
            verdict = "escapes"
        elif joint.gain:
            verdict = f"gains {joint.gain}"
        else:
            verdict = "does not escape"
        yield f"  joint {joint.number}  {verdict}, rate {joint.rate:.4f}, dimensions {_runs(joint.dimensions)}"
    yield f"  conclusion: actuate {_joints(report.escapes)}"
    if report.disagreements:
        yield from ("", "Disagreements with the printed procedure:")
        yield from (f"  {disagreement}" for disagreement in report.disagreements)


def _runs(dimensions: Iterable[tuple[int, int, int]]) -> str:
    return " ".join(f"{first}–{last}:{dimension}" for first, last, dimension in dimensions)


def _joints(members: Sequence[int]) -> str:
    return numbers(members) or "none"


def hunt_words(hunt: Hunt) -> str:
    """Whom Hunt's matrix of cofactors names, and whether finite motion agrees; or why it names nobody."""
    rows, joints = hunt.shape
    if rows != joints:
        return f"Hunt's matrix of cofactors is of a square Jacobian; this one has {rows} rows, {joints} joints"
    if not hunt.applies:
        if hunt.lost:
            what = f"is zero where {hunt.lost} freedoms are lost"
        else:
            what = "shows nothing at a regular configuration"
        return f"Hunt's matrix of cofactors {what}: it names no screw"
    named = [joint.number for joint in hunt.joints if joint.named]
    leading = [joint.number for joint in hunt.joints if joint.tells]
    text = f"Hunt's cofactors name the screws {numbers(named)}; they tell that "
    if leading:
        text += f"joint {numbers(leading)} leads out at first order"
    else:
        text += "no joint leads out at first order"
    return f"{text}{_finite_motion(hunt)}"


def _finite_motion(hunt: Hunt) -> str:
    """What finite motion shows of the joints that Hunt's cofactors tell to lead out, as the end of a sentence."""
    missed = [joint.number for joint in hunt.joints if joint.escapes and not joint.tells]
    wrong = [joint.number for joint in hunt.joints if joint.tells and not joint.escapes]
    if missed:
        return f"; finite motion shows that joint {numbers(missed)} leads out too, at a higher order"
    if wrong:
        return f"; finite motion does not confirm it of joint {numbers(wrong)}"
    return ", and finite motion agrees"
