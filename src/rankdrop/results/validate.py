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
    if rank != analysis.generic_rank:
        raise damaged("the arm has another generic rank", "$.robot.generic_rank", analysis.generic_rank, rank)
    _check_coranks(analysis)
    ids = [family.id for family in analysis.families]
    for i, family in enumerate(analysis.families):
        where = f"$.families[{i}]"
        if family.id in ids[:i] or not family.id.startswith(f"k{family.corank}."):
            raise damaged("the id is that of another family", f"{where}.id", family.id)
        at(where, lambda one=family, place=where: _check_family(analysis, one, place))  # type: ignore[misc]
    _check_near(analysis, ids)
    _check_exact(analysis, ids)


def _check_tolerances(analysis: Analysis) -> None:
    for name, value in analysis.settings.tolerances.to_dict().items():
        most = _LOOSEST_SINGULAR if name == "singular" else _LOOSEST
        if value > most:
            raise damaged("the tolerance is too large", f"$.settings.tolerances.{name}", value, f"up to {most:g}")


def _check_robot(robot: Robot, record: dict[str, Any]) -> None:
    if record["n"] != robot.n:
        raise damaged("the chain has another number of variables", "$.robot.n", record["n"], robot.n)
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
        if joint.velocity <= 0.0:
            raise damaged("the largest velocity is not positive", f"{where}.velocity", joint.velocity, "above 0")
        mimic = joint.mimic
        if mimic is not None and not 0.0 < abs(mimic.multiplier) <= RANGE["angle"]:
            raise damaged("the joint follows at no rate", f"{where}.mimic.multiplier", mimic.multiplier)
    told = [(one["name"], one["number"], one["kind"], one["lower"], one["upper"]) for one in record["joints"]]
    chain = {one["name"]: one for one in record["chain"]}
    for i, joint in enumerate(robot.variables):
        one = chain[joint.name]
        want = (joint.name, i + 1, str(joint.kind), one["lower"], one["upper"])
        if i >= len(told) or told[i] != want:
            raise damaged("the joint is another one than that of the chain", f"$.robot.joints[{i}]", allowed=want)
    if len(told) != robot.n:
        raise damaged("there are more joints than in the chain", "$.robot.joints", len(told), robot.n)


def _check_screw(joint: Joint, screw: np.ndarray[Any, np.dtype[np.float64]], where: str) -> None:
    axis = screw[:3] if joint.kind is JointKind.PRISMATIC else screw[3:]
    length = float(np.linalg.norm(axis))
    if abs(length - 1.0) > _SAME:
        raise damaged("the axis has another length than 1", where, length, 1)
    pitch = float(screw[:3] @ screw[3:])
    if joint.kind is JointKind.REVOLUTE and abs(pitch) > _SAME * max(1.0, float(np.abs(screw).max())):
        raise damaged("a revolute screw has no pitch", where, f"{pitch:g} m/rad", 0)


def _check_task(task: Task, robot: Robot) -> None:
    resolve_task(robot.task, robot)
    if resolve_task(task.name, robot, length_scale=task.length_scale).rows != task.rows:
        raise damaged("the rows are not those of the task", "$.robot.rows", list(task.rows))
    for what in ("axes", "origin"):
        at(f"$.robot.frame.{what}", lambda one=what: link_index(getattr(task.frame, one), len(robot.joints), one))  # type: ignore[misc]
    if max(map(abs, task.frame.point)) > RANGE["length"]:
        raise damaged("the point is too far away", "$.robot.frame.point", allowed=allowed_range("length"))


def _check_coranks(analysis: Analysis) -> None:
    for i, row in enumerate(analysis.coranks):
        where = f"$.coranks[{i}]"
        if row.corank != i + 1 or row.rank != analysis.generic_rank - row.corank:
            raise damaged("corank and rank are not the next ones", where, (row.corank, row.rank),
                          (i + 1, analysis.generic_rank - i - 1))  # fmt: skip
        if row.converged + row.near_misses + row.slow > row.starts:
            raise damaged("there are more ends than starts", f"{where}.starts", row.starts)
        if row.completeness.agree > row.completeness.tested:
            raise damaged("more points are explained than tested", f"{where}.completeness")
        if row.unseen.estimate > row.unseen.upper:
            raise damaged("the estimate is above its upper bound", f"{where}.unseen.estimate", row.unseen.estimate)
        if row.smallest_near_miss is not None and row.smallest_near_miss < 0.0:
            raise damaged("a singular value is below zero", f"{where}.smallest_near_miss", row.smallest_near_miss)
    if analysis.complete is not (analysis.unfinished is None):
        raise damaged("an analysis is complete, or tells the corank that was interrupted", "$.unfinished")
    if analysis.unfinished is not None and analysis.unfinished != len(analysis.coranks) + 1:
        raise damaged("the unfinished corank is not the next one", "$.unfinished", analysis.unfinished)


def _check_family(analysis: Analysis, family: Family, where: str) -> None:
    """The family against the arm: first that its numbers fit, then the rank, the equations and what is lost."""
    robot, n = analysis.robot, analysis.robot.n
    if family.corank > len(analysis.coranks):
        raise damaged("nothing was searched at this corank", f"{where}.corank", family.corank, len(analysis.coranks))
    if len(family.witness) != n:
        raise damaged("the witness has another number of joints", f"{where}.witness", len(family.witness), n)
    for j, (value, joint) in enumerate(zip(family.witness, robot.variables, strict=True)):
        measure = "length" if joint.unit == "m" else "angle"
        if abs(value) > RANGE[measure]:
            raise damaged("the value is too large", f"{where}.witness[{j}]", value, allowed_range(measure))
    kinds = sorted([*(pin.number for pin in family.pinned), *family.free, *family.coupled])
    if kinds != list(range(1, n + 1)):
        raise damaged("each joint is pinned, free or coupled, once", where, kinds, f"1 … {n}")
    if family.soundness.agree > family.soundness.tested or family.explained.agree > family.explained.tested:
        raise damaged("more points hold than were tested", where)
    _check_equations(family, n, where)
    _check_rank(analysis, family, where)
    for i, pin in enumerate(family.pinned):
        _check_pin(robot, family, pin, f"{where}.pinned[{i}]", analysis.settings.tolerances.explained)


def _check_equations(family: Family, n: int, where: str) -> None:
    if family.named is not bool(family.equations):
        raise damaged("a family has equations exactly where it is named", f"{where}.named", family.named)
    for i, equation in enumerate(family.equations):
        place = f"{where}.terms[{i}]"
        if equation.n != n:
            raise damaged("the equation has another number of joints", place, equation.n, n)
        highest = max(max(map(abs, (*term.harmonics, *term.powers))) for term in equation.terms)
        if highest > _HIGHEST:
            raise damaged("a power or a harmonic is too high", place, highest, f"up to {_HIGHEST}")
        if set(equation.joints) & set(family.free):
            raise damaged("the equation binds a free joint", place, sorted(equation.joints))
    fewest = n - len(family.equations) if family.equations else 0
    most = n
    if family.equations:
        slopes = np.stack([equation.gradient(np.array(family.witness)) for equation in family.equations])
        most = n - int(np.linalg.matrix_rank(slopes, tol=1e-6 * max(1.0, float(np.abs(slopes).max()))))
    if not fewest <= family.dimension <= most:
        raise damaged("the equations leave another dimension", f"{where}.dimension", family.dimension,
                      f"{fewest} … {most}")  # fmt: skip


def _check_rank(analysis: Analysis, family: Family, where: str) -> None:
    tolerances = analysis.settings.tolerances
    found = analysis.residual_of(family)
    if not found.equation <= tolerances.explained:
        raise damaged("the witness does not satisfy the equations", f"{where}.witness", f"{found.equation:.3g}",
                      f"up to {tolerances.explained:g}")  # fmt: skip
    if not found.sigma <= tolerances.singular < found.kept:
        raise damaged("the witness has another corank", f"{where}.witness",
                      f"σ that vanish up to {found.sigma:.3g}, σ that stay from {found.kept:.3g}",
                      f"corank {family.corank}, cut at {tolerances.singular:g}")  # fmt: skip
    lost, place = family.lost_directions, f"{where}.lost_directions"
    if lost.shape != (family.corank, 6) or len(family.lost_words) != family.corank:
        raise damaged("one direction and one sentence for each lost freedom", place, len(lost), family.corank)
    if np.abs(lost @ lost.T - np.eye(len(lost))).max() > _LOST:
        raise damaged("the directions are not orthonormal", place)
    rows = list(analysis.task.rows)
    whole = jacobian(analysis.robot, np.array(family.witness), analysis.task.frame)[rows]
    free = np.delete(lost, rows, axis=1)
    if np.abs(lost[:, rows] @ whole).max() > _LOST * max(1.0, float(np.abs(whole).max())) or free.any():
        raise damaged("the directions are not those lost at the witness", place)


def _check_pin(robot: Robot, family: Family, pin: Pin, where: str, tolerance: float) -> None:
    joint, at_witness = robot.variables[pin.number - 1], family.witness[pin.number - 1]
    if pin.joint != joint.name:
        raise damaged("the joint has another name", f"{where}.joint", pin.joint, joint.name)
    turns = bool(robot.periodic[pin.number - 1])
    gaps = [abs(value - at_witness) for value in pin.values]
    if min(abs(wrapped(gap)) if turns else gap for gap in gaps) > tolerance:
        raise damaged("the witness is at none of the values", f"{where}.values", at_witness)
    own = [equation for equation in family.equations if equation.joints == (pin.number,)]
    for value in pin.values:
        q = np.array(family.witness)
        q[pin.number - 1] = value
        if not all(abs(float(equation(q))) <= tolerance for equation in own):
            raise damaged("the value does not satisfy the equations", f"{where}.values", value)


def _check_near(analysis: Analysis, ids: Sequence[str]) -> None:
    if analysis.near is None:
        return
    if [one.id for one in analysis.near.families] != list(ids):
        raise damaged("the families are not those of the analysis", "$.near.families", allowed=", ".join(ids))
    for row in (*analysis.near.families, analysis.near.any):
        if row.near > row.samples:
            raise damaged("more configurations are near than there are", "$.near", row.near, f"up to {row.samples}")


def _check_exact(analysis: Analysis, ids: Sequence[str]) -> None:
    exact, n = analysis.exact, analysis.robot.n
    if exact is None:
        return
    if len(exact.shifts) not in (0, n):
        raise damaged("one shift for each joint", "$.exact.shifts", len(exact.shifts), n)
    own = [family.id for family in exact.families]
    for i, family in enumerate(exact.families):
        where = f"$.exact.families[{i}]"
        if family.id in own[:i] or not family.id.startswith(f"k{family.corank}."):
            raise damaged("the id is that of another family", f"{where}.id", family.id)
        if not (family.corank <= analysis.generic_rank and family.dimension <= n):
            raise damaged("corank or dimension are beyond the arm's", where, (family.corank, family.dimension))
        names = [joint.name for joint in analysis.robot.variables]
        for pin in family.pinned:
            if pin.number > n or names[pin.number - 1] != pin.joint:
                raise damaged("the joint is another one", f"{where}.pinned", pin.joint)
    if exact.derived:
        _check_ids(own, ids, "$.exact.families")
    if (exact.status == "differs") is not bool(exact.disagreements):
        raise damaged("there are disagreements exactly where the status is differs", "$.exact.status", exact.status)


def _check_ids(named: Iterable[str], known: Sequence[str], where: str) -> None:
    for one in named:
        if one not in known:
            raise damaged("there is no such family", where, one, ", ".join(known))
