"""What is believed of a file: an analysis that was read is held against its schema, its own arm and itself.

The arm is computed with: generic rank, and for every family the rank, the singular values, the equations and the lost
directions at the witness. What cannot be computed again without searching (shares, counts) has to fit together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from rankdrop.errors import RankdropError, ResultFileError
from rankdrop.family.record import Family, Pin
from rankdrop.kinematics import jacobian
from rankdrop.local.block import generic_rank
from rankdrop.robot.files import RANGE, allowed_range
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.numbers import wrapped
from rankdrop.robot.transform import rigid
from rankdrop.task import Task, link_index, resolve_task

if TYPE_CHECKING:
    from rankdrop.results.analysis import Analysis

T = TypeVar("T")
_LOOSEST = 0.1  # of any tolerance; of `singular` 1e-3, as for `explain`
_LOOSEST_SINGULAR = 1e-3
_SAME = 1e-9  # lengths of axes, entries of rotations: what decimals of a file leave
_HIGHEST = 64  # power or harmonic of a term; those found have at most 10
_LOST = 1e-6  # |u · J| of a direction u that is lost, with J in metres of the reach


def damaged(what: str, where: str, got: object = None, allowed: object = None) -> ResultFileError:
    """The error of an element that cannot be believed."""
    return ResultFileError(f"the analysis is damaged: {what}", where=where, got=got, allowed=allowed,
                           mend="analyse the arm again")  # fmt: skip


def require(holds: bool | np.bool, what: str, where: str, got: object = None, allowed: object = None) -> None:
    """Raise the error of an element that cannot be believed, unless it holds."""
    if not holds:
        raise damaged(what, where, got, allowed)


def at(where: str, make: Callable[[], T]) -> T:
    """What `make` makes; whatever it raises becomes an error at an element.

    Raises:
        ResultFileError: `make` failed.
    """
    try:
        return make()
    except RankdropError as error:
        if error.where is not None and error.where.startswith("$"):  # it knows its place
            raise
        raise damaged(error.what, where, error.got, error.allowed) from error
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, ArithmeticError) as error:
        raise damaged(f"{type(error).__name__}: {error}", where) from error


def check_analysis(analysis: Analysis, record: dict[str, Any]) -> None:
    """Hold an analysis that was read against its own arm.

    Args:
        analysis: as read, of a record that keeps to the schema.
        record: the same as plain data.

    Raises:
        ResultFileError: with the path of the first element that contradicts the arm, or another element.
    """
    robot, task = analysis.robot, analysis.task
    _check_tolerances(analysis)
    _check_robot(robot, record["robot"])
    at("$.robot.task", lambda: _check_task(task, robot))
    rank = at("$.robot", lambda: generic_rank(robot, task))
    require(
        rank == analysis.generic_rank,
        "the arm has another generic rank", "$.robot.generic_rank", analysis.generic_rank, rank,
    )
    _check_coranks(analysis)
    ids = [family.id for family in analysis.families]
    for i, family in enumerate(analysis.families):
        where = f"$.families[{i}]"
        require(
            family.id not in ids[:i] and family.id.startswith(f"k{family.corank}."),
            "the id is that of another family", f"{where}.id", family.id,
        )
        at(where, lambda one=family, place=where: _check_family(analysis, one, place))  # type: ignore[misc]
    _check_near(analysis, ids)
    _check_exact(analysis, ids)


def _check_tolerances(analysis: Analysis) -> None:
    for name, value in analysis.settings.tolerances.to_dict().items():
        most = _LOOSEST_SINGULAR if name == "singular" else _LOOSEST
        require(value <= most, "the tolerance is too large", f"$.settings.tolerances.{name}", value, f"up to {most:g}")


def _check_robot(robot: Robot, record: dict[str, Any]) -> None:
    require(record["n"] == robot.n, "the chain has another number of variables", "$.robot.n", record["n"], robot.n)
    at("$.robot.home", lambda: rigid(robot.home, ""))
    for i, joint in enumerate(robot.joints):
        where = f"$.robot.chain[{i}]"
        at(f"{where}.frame", lambda one=joint: rigid(one.frame, ""))  # type: ignore[misc]
        _check_screw(joint, np.array(record["chain"][i]["screw"], dtype=np.float64), f"{where}.screw")
        most = RANGE["length" if joint.unit == "m" else "angle"]
        for key in ("lower", "upper", "velocity"):
            value = record["chain"][i][key]
            if value is not None and abs(value) > most:
                allowed = allowed_range("length" if joint.unit == "m" else "angle")
                raise damaged("the limit is too large", f"{where}.{key}", value, allowed)
        require(
            joint.velocity > 0.0,
            "the largest velocity is not positive", f"{where}.velocity", joint.velocity, "above 0",
        )
        mimic = joint.mimic
        if mimic is not None and not 0.0 < abs(mimic.multiplier) <= RANGE["angle"]:
            raise damaged("the joint follows at no rate", f"{where}.mimic.multiplier", mimic.multiplier)
    told = [(one["name"], one["number"], one["kind"], one["lower"], one["upper"]) for one in record["joints"]]
    chain = {one["name"]: one for one in record["chain"]}
    for i, joint in enumerate(robot.variables):
        one = chain[joint.name]
        want = (joint.name, i + 1, str(joint.kind), one["lower"], one["upper"])
        require(
            i < len(told) and told[i] == want,
            "the joint is another one than that of the chain", f"$.robot.joints[{i}]", allowed=want,
        )
    require(len(told) == robot.n, "there are more joints than in the chain", "$.robot.joints", len(told), robot.n)


def _check_screw(joint: Joint, screw: np.ndarray[Any, np.dtype[np.float64]], where: str) -> None:
    axis = screw[:3] if joint.kind is JointKind.PRISMATIC else screw[3:]
    length = float(np.linalg.norm(axis))
    require(abs(length - 1.0) <= _SAME, "the axis has another length than 1", where, length, 1)
    pitch = float(screw[:3] @ screw[3:])
    require(
        joint.kind is not JointKind.REVOLUTE or abs(pitch) <= _SAME * max(1.0, float(np.abs(screw).max())),
        "a revolute screw has no pitch", where, f"{pitch:g} m/rad", 0,
    )


def _check_task(task: Task, robot: Robot) -> None:
    resolve_task(robot.task, robot)
    require(
        resolve_task(task.name, robot, length_scale=task.length_scale).rows == task.rows,
        "the rows are not those of the task", "$.robot.rows", list(task.rows),
    )
    for what in ("axes", "origin"):
        at(f"$.robot.frame.{what}", lambda one=what: link_index(getattr(task.frame, one), len(robot.joints), one))  # type: ignore[misc]
    require(
        max(map(abs, task.frame.point)) <= RANGE["length"],
        "the point is too far away", "$.robot.frame.point", allowed=allowed_range("length"),
    )


def _check_coranks(analysis: Analysis) -> None:
    for i, row in enumerate(analysis.coranks):
        where = f"$.coranks[{i}]"
        require(
            (row.corank, row.rank) == (i + 1, analysis.generic_rank - row.corank),
            "corank and rank are not the next ones", where, (row.corank, row.rank),
            (i + 1, analysis.generic_rank - i - 1),
        )
        require(
            row.converged + row.near_misses + row.slow <= row.starts,
            "there are more ends than starts", f"{where}.starts", row.starts,
        )
        require(
            row.completeness.agree <= row.completeness.tested,
            "more points are explained than tested", f"{where}.completeness",
        )
        require(
            row.unseen.estimate <= row.unseen.upper,
            "the estimate is above its upper bound", f"{where}.unseen.estimate", row.unseen.estimate,
        )
        require(
            row.smallest_near_miss is None or row.smallest_near_miss >= 0.0,
            "a singular value is below zero", f"{where}.smallest_near_miss", row.smallest_near_miss,
        )
    require(
        analysis.complete is (analysis.unfinished is None),
        "an analysis is complete, or tells the corank that was interrupted", "$.unfinished",
    )
    require(
        analysis.unfinished in (None, len(analysis.coranks) + 1),
        "the unfinished corank is not the next one", "$.unfinished", analysis.unfinished,
    )


def _check_family(analysis: Analysis, family: Family, where: str) -> None:
    """The family against the arm: first that its numbers fit, then the rank, the equations and what is lost."""
    robot, n = analysis.robot, analysis.robot.n
    require(
        family.corank <= len(analysis.coranks),
        "nothing was searched at this corank", f"{where}.corank", family.corank, len(analysis.coranks),
    )
    require(
        len(family.witness) == n,
        "the witness has another number of joints", f"{where}.witness", len(family.witness), n,
    )
    for j, (value, joint) in enumerate(zip(family.witness, robot.variables, strict=True)):
        measure = "length" if joint.unit == "m" else "angle"
        require(
            abs(value) <= RANGE[measure],
            "the value is too large", f"{where}.witness[{j}]", value, allowed_range(measure),
        )
    kinds = sorted([*(pin.number for pin in family.pinned), *family.free, *family.coupled])
    require(kinds == list(range(1, n + 1)), "each joint is pinned, free or coupled, once", where, kinds, f"1 … {n}")
    require(
        family.soundness.agree <= family.soundness.tested and family.explained.agree <= family.explained.tested,
        "more points hold than were tested", where,
    )
    _check_equations(family, n, where)
    _check_rank(analysis, family, where)
    for i, pin in enumerate(family.pinned):
        _check_pin(robot, family, pin, f"{where}.pinned[{i}]", analysis.settings.tolerances.explained)


def _check_equations(family: Family, n: int, where: str) -> None:
    require(
        family.named is bool(family.equations),
        "a family has equations exactly where it is named", f"{where}.named", family.named,
    )
    for i, equation in enumerate(family.equations):
        place = f"{where}.terms[{i}]"
        require(equation.n == n, "the equation has another number of joints", place, equation.n, n)
        highest = max(max(map(abs, (*term.harmonics, *term.powers))) for term in equation.terms)
        require(highest <= _HIGHEST, "a power or a harmonic is too high", place, highest, f"up to {_HIGHEST}")
        require(
            not set(equation.joints) & set(family.free),
            "the equation binds a free joint", place, sorted(equation.joints),
        )
    fewest = n - len(family.equations) if family.equations else 0
    most = n
    if family.equations:
        slopes = np.stack([equation.gradient(np.array(family.witness)) for equation in family.equations])
        most = n - int(np.linalg.matrix_rank(slopes, tol=1e-6 * max(1.0, float(np.abs(slopes).max()))))
    require(
        fewest <= family.dimension <= most,
        "the equations leave another dimension", f"{where}.dimension", family.dimension, f"{fewest} … {most}",
    )


def _check_rank(analysis: Analysis, family: Family, where: str) -> None:
    tolerances = analysis.settings.tolerances
    found = analysis.residual_of(family)
    require(
        found.equation <= tolerances.explained,
        "the witness does not satisfy the equations", f"{where}.witness", f"{found.equation:.3g}",
        f"up to {tolerances.explained:g}",
    )
    require(
        found.sigma <= tolerances.singular < found.kept,
        "the witness has another corank", f"{where}.witness",
        f"σ that vanish up to {found.sigma:.3g}, σ that stay from {found.kept:.3g}",
        f"corank {family.corank}, cut at {tolerances.singular:g}",
    )
    lost, place = family.lost_directions, f"{where}.lost_directions"
    require(
        lost.shape == (family.corank, 6) and len(family.lost_words) == family.corank,
        "one direction and one sentence for each lost freedom", place, len(lost), family.corank,
    )
    require(np.abs(lost @ lost.T - np.eye(len(lost))).max() <= _LOST, "the directions are not orthonormal", place)
    rows = list(analysis.task.rows)
    whole = jacobian(analysis.robot, np.array(family.witness), analysis.task.frame)[rows]
    free = np.delete(lost, rows, axis=1)
    require(
        np.abs(lost[:, rows] @ whole).max() <= _LOST * max(1.0, float(np.abs(whole).max())) and not free.any(),
        "the directions are not those lost at the witness", place,
    )


def _check_pin(robot: Robot, family: Family, pin: Pin, where: str, tolerance: float) -> None:
    joint, at_witness = robot.variables[pin.number - 1], family.witness[pin.number - 1]
    require(pin.joint == joint.name, "the joint has another name", f"{where}.joint", pin.joint, joint.name)
    turns = bool(robot.periodic[pin.number - 1])
    gaps = [abs(value - at_witness) for value in pin.values]
    require(
        min(abs(wrapped(gap)) if turns else gap for gap in gaps) <= tolerance,
        "the witness is at none of the values", f"{where}.values", at_witness,
    )
    own = [equation for equation in family.equations if equation.joints == (pin.number,)]
    for value in pin.values:
        q = np.array(family.witness)
        q[pin.number - 1] = value
        require(
            all(abs(float(equation(q))) <= tolerance for equation in own),
            "the value does not satisfy the equations", f"{where}.values", value,
        )


def _check_near(analysis: Analysis, ids: Sequence[str]) -> None:
    if analysis.near is None:
        return
    require(
        [one.id for one in analysis.near.families] == list(ids),
        "the families are not those of the analysis", "$.near.families", allowed=", ".join(ids),
    )
    for row in (*analysis.near.families, analysis.near.any):
        require(
            row.near <= row.samples,
            "more configurations are near than there are", "$.near", row.near, f"up to {row.samples}",
        )


def _check_exact(analysis: Analysis, ids: Sequence[str]) -> None:
    exact, n = analysis.exact, analysis.robot.n
    if exact is None:
        return
    require(len(exact.shifts) in (0, n), "one shift for each joint", "$.exact.shifts", len(exact.shifts), n)
    own = [family.id for family in exact.families]
    for i, family in enumerate(exact.families):
        where = f"$.exact.families[{i}]"
        require(
            family.id not in own[:i] and family.id.startswith(f"k{family.corank}."),
            "the id is that of another family", f"{where}.id", family.id,
        )
        require(
            family.corank <= analysis.generic_rank and family.dimension <= n,
            "corank or dimension are beyond the arm's", where, (family.corank, family.dimension),
        )
        names = [joint.name for joint in analysis.robot.variables]
        for pin in family.pinned:
            require(
                pin.number <= n and names[pin.number - 1] == pin.joint,
                "the joint is another one", f"{where}.pinned", pin.joint,
            )
    if exact.derived:
        _check_ids(own, ids, "$.exact.families")
    require(
        (exact.status == "differs") is bool(exact.disagreements),
        "there are disagreements exactly where the status is differs", "$.exact.status", exact.status,
    )


def _check_ids(named: Iterable[str], known: Sequence[str], where: str) -> None:
    for one in named:
        require(one in known, "there is no such family", where, one, ", ".join(known))
