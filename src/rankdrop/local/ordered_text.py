"""A report on an ordered screw set as text: the printed session, the motion carried to the end, the judge."""

from __future__ import annotations

from collections.abc import Iterator

from rankdrop.local.ordered_report import OrderedReport, Trial


def render(report: OrderedReport) -> str:
    """The whole report, one line a fact; lines end without blanks.

    Example:
        >>> from rankdrop.local.ordered import OrderedScrewSet
        >>> from rankdrop.local.ordered_report import report
        >>> from rankdrop.robot.open import open_robot
        >>> text = render(report(OrderedScrewSet.of(open_robot("rcrrrr"), [0.0] * 7)))
        >>> print(text.splitlines()[0])
        7 screws of dimension 5, elsewhere 6: 1 task freedom lost, 2 dependencies
    """
    return "\n".join(_lines(report)) + "\n"


def _lines(report: OrderedReport) -> Iterator[str]:
    screws = report.dimension + report.dependencies
    lost = f"{report.lost} task freedom{'' if report.lost == 1 else 's'} lost" if report.lost else "not singular"
    both = f"{report.dependencies} dependenc{'y' if report.dependencies == 1 else 'ies'}"
    yield f"{screws} screws of dimension {report.dimension}, elsewhere {report.generic}: {lost}, {both}"
    if report.subsets:
        yield ""
        yield "Runs with a loss (screws, dimension, loss):"
        for run in report.subsets:
            marks = (", passes the msos test" if run.msos else "") + (", minimal" if run.minimal else "")
            yield f"  {run.first}–{run.last}  {run.dimension}  {run.loss}{marks}"
    yield ""
    yield "As printed (screws moved up to the end of the run only):"
    for step in report.steps:
        yield f"  {step.instruction};"
        yield from (f"    {line}" for line in step.lines)
    if report.lost:
        yield f"  conclusion: actuate {_list(report.printed)}"
        yield ""
        yield from _corrected(report)


def _corrected(report: OrderedReport) -> Iterator[str]:
    for trial in report.trials:
        if trial.dimensions != trial.carried:
            yield (
                f"newscrews({trial.actuator}, {trial.subset[1]}): dimensions {_dimensions(trial, carried=False)} as "
                f"printed, {_dimensions(trial, carried=True)} with every later screw carried along"
            )
    yield ""
    yield "Every joint, carried to the end of the chain, and judged by finite motion:"
    for joint in report.joints:
        runs = " ".join(f"{i}–{j}:{d}" for i, j, d in joint.dimensions)
        verdict = "escapes" if joint.escapes else f"gains {joint.gain}" if joint.gain else "does not escape"
        yield f"  joint {joint.number}  {verdict}, rate {joint.rate:.4f}, dimensions {runs}"
    yield f"  conclusion: actuate {_list(report.escapes)}"
    if report.disagreements:
        yield ""
        yield "Disagreements with the printed procedure:"
        yield from (f"  {told}" for told in report.disagreements)


def _dimensions(trial: Trial, *, carried: bool) -> str:
    return " ".join(f"{i}–{j}:{d}" for i, j, d in (trial.carried if carried else trial.dimensions))


def _list(numbers: tuple[int, ...]) -> str:
    return ", ".join(f"{number}" for number in numbers) or "none"
