"""What is believed of a file: an analysis that was read is held against its schema, its own arm and itself.

The arm is computed with: generic rank, and for every family the rank, the singular values, the equations and the lost
directions at the witness. What cannot be computed again without searching (shares, counts) has to fit together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Protocol, TypeVar

import numpy as np

from rankdrop.distance.share import JointSpaceShares, SlowShare
from rankdrop.errors import RankdropError, ResultFileError
from rankdrop.families.corank_families import CorankSummary
from rankdrop.families.derivation import Derivation
from rankdrop.families.lost import LostFreedom
from rankdrop.families.record import Family, Pin
from rankdrop.families.speed_distance import SpeedDistances
from rankdrop.kinematics import jacobian
from rankdrop.local.block import generic_rank
from rankdrop.results.names import joints_of_name
from rankdrop.results.settings import Residual, Settings
from rankdrop.robot.files import RANGE, allowed_range
from rankdrop.robot.model import Array, Joint, JointKind, Robot
from rankdrop.robot.numbers import wrap_angle
from rankdrop.robot.transform import rigid
from rankdrop.task import Task, link_index, resolve_task

T = TypeVar("T")
_LOOSEST = 0.1  # of any tolerance; of `singular` 1e-3, as for `explain`
_LOOSEST_SINGULAR = 1e-3
_SAME = 1e-9  # lengths of axes, entries of rotations: what decimals of a file leave
_HIGHEST = 64  # power or harmonic of a term; those found have at most 10
_LOST = 1e-6  # |u · J| of a direction u that is lost, with J in metres of the reach

Claim = tuple[bool | np.bool, str, str, object, object]
"""Whether something holds; else what is wrong, at which element, what stands there, and what is allowed."""


class _Analysed(Protocol):
    """The facts of an analysis that are held against its arm: `rankdrop.results.analysis.Analysis` has them."""

    @property
    def robot(self) -> Robot: ...
    @property
    def task(self) -> Task: ...
    @property
    def generic_rank(self) -> int: ...
    @property
    def settings(self) -> Settings: ...
    @property
    def coranks(self) -> tuple[CorankSummary, ...]: ...
    @property
    def families(self) -> tuple[Family, ...]: ...
    @property
    def complete(self) -> bool: ...
    @property
    def unfinished(self) -> int | None: ...
    @property
    def exact(self) -> Derivation | None: ...
    @property
    def near(self) -> JointSpaceShares | None: ...
    @property
    def speeds(self) -> SpeedDistances | None: ...
    @property
    def slow(self) -> SlowShare | None: ...

    def residual_of(self, family: Family) -> Residual: ...


def damage_error(what: str, where: str, got: object = None, allowed: object = None) -> ResultFileError:
    """The error of an element that cannot be believed."""
    return ResultFileError(f"the analysis is damaged: {what}", where=where, got=got, allowed=allowed,
                           mend="analyse the arm again")  # fmt: skip


def require(*claims: Claim) -> None:
    """Raise the error of the first claim that does not hold."""
    for holds, what, where, got, allowed in claims:
        if not holds:
            raise damage_error(what, where, got, allowed)


def with_place(where: str, make: Callable[[], T]) -> T:
    """What `make` makes; whatever it raises becomes an error at an element.

    Raises:
        ResultFileError: `make` failed.
    """
    try:
        return make()
    except RankdropError as error:
        if error.where is not None and error.where.startswith("$"):  # it knows its place
            raise
        raise damage_error(error.what, where, error.got, error.allowed) from error
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, ArithmeticError) as error:
        raise damage_error(f"{type(error).__name__}: {error}", where) from error


def check_analysis(analysis: _Analysed, record: dict[str, Any]) -> None:
    """Hold an analysis that was read against its own arm.

    Args:
        analysis: as read, of a record that keeps to the schema.
        record: the same as plain data.

    Raises:
        ResultFileError: with the path of the first element that contradicts the arm, or another element.
    """
    robot, task = analysis.robot, analysis.task
    for name, value in analysis.settings.tolerances.to_dict().items():
        if name == "singular":
            most = _LOOSEST_SINGULAR
        else:
            most = _LOOSEST
        where = f"$.settings.tolerances.{name}"
        require((value <= most, "the tolerance is too large", where, value, f"up to {most:g}"))
    _check_robot(robot, record["robot"])
    with_place("$.robot.task", lambda: _check_task(task, robot))
    rank = with_place("$.robot", lambda: generic_rank(robot, task))
    require((rank == analysis.generic_rank, "the arm has another generic rank", "$.robot.generic_rank",
             analysis.generic_rank, rank))  # fmt: skip
    _check_coranks(analysis)
    ids = [family.id for family in analysis.families]
    for i, family in enumerate(analysis.families):
        where = f"$.families[{i}]"
        _check_id(family, ids[:i], where)
        with_place(where, lambda entry=family, place=where: _check_family(analysis, entry, place))  # type: ignore[misc]
    if analysis.near is not None:
        require(
            ([entry.id for entry in analysis.near.families] == ids, "the families are not those of the analysis",
             "$.near.families", None, ", ".join(ids)),
            *((row.near <= row.samples, "more configurations are near than there are", "$.near", row.near,
               f"up to {row.samples}") for row in (*analysis.near.families, analysis.near.any)),
        )  # fmt: skip
    _check_speeds(analysis, ids)
    if analysis.slow is not None:
        slow, all_ = analysis.slow.share.near, analysis.slow.share.samples
        require((slow <= all_, "more configurations are slow than there are", "$.slow.share", slow, f"up to {all_}"))
    if analysis.exact is not None:
        _check_exact(analysis, analysis.exact)
    _check_exact_conditions(analysis)


def _check_id(family: Family, before: Sequence[str], where: str) -> None:
    fits = family.id not in before and family.id.startswith(f"k{family.corank}.")
    require((fits, "the id is that of another family", f"{where}.id", family.id, None))


def _check_robot(robot: Robot, record: dict[str, Any]) -> None:
    require((record["n"] == robot.n, "the chain has another number of variables", "$.robot.n", record["n"], robot.n))
    with_place("$.robot.home", lambda: rigid(robot.home, ""))
    for i, (joint, written) in enumerate(zip(robot.joints, record["chain"], strict=True)):
        where, measure, mimic = f"$.robot.chain[{i}]", "length" if joint.unit == "m" else "angle", joint.mimic
        with_place(f"{where}.frame", lambda row=joint: rigid(row.frame, ""))  # type: ignore[misc]
        _check_screw(joint, np.array(written["screw"], dtype=np.float64), f"{where}.screw")
        require(
            *((written[key] is None or abs(written[key]) <= RANGE[measure], "the limit is too large",
               f"{where}.{key}", written[key], allowed_range(measure)) for key in ("lower", "upper", "velocity")),
            (joint.velocity > 0.0, "the largest velocity is not positive", f"{where}.velocity", joint.velocity,
             "above 0"),
            (mimic is None or 0.0 < abs(mimic.multiplier) <= RANGE["angle"], "the joint follows at no rate",
             f"{where}.mimic.multiplier", mimic and mimic.multiplier, None),
        )  # fmt: skip
    listed = [(row["name"], row["number"], row["kind"], row["lower"], row["upper"]) for row in record["joints"]]
    chain = {row["name"]: row for row in record["chain"]}
    for i, joint in enumerate(robot.variables):
        written = chain[joint.name]
        want = (joint.name, i + 1, str(joint.kind), written["lower"], written["upper"])
        require((i < len(listed) and listed[i] == want, "the joint is another one than that of the chain",
                 f"$.robot.joints[{i}]", None, want))  # fmt: skip
    require((len(listed) == robot.n, "there are more joints than in the chain", "$.robot.joints", len(listed), robot.n))


def _check_screw(joint: Joint, screw: np.ndarray[Any, np.dtype[np.float64]], where: str) -> None:
    if joint.kind is JointKind.PRISMATIC:
        axis = screw[:3]
    else:
        axis = screw[3:]
    length, pitch = float(np.linalg.norm(axis)), float(screw[:3] @ screw[3:])
    straight = joint.kind is not JointKind.REVOLUTE or abs(pitch) <= _SAME * max(1.0, float(np.abs(screw).max()))
    require(
        (abs(length - 1.0) <= _SAME, "the axis has another length than 1", where, length, 1),
        (straight, "a revolute screw has no pitch", where, f"{pitch:g} m/rad", 0),
    )


def _check_task(task: Task, robot: Robot) -> None:
    resolve_task(robot.task, robot)
    rows = resolve_task(task.name, robot, length_scale=task.length_scale).rows
    require((rows == task.rows, "the rows are not those of the task", "$.robot.rows", list(task.rows), None))
    for what in ("axes", "origin"):
        link = getattr(task.frame, what)
        with_place(f"$.robot.frame.{what}", partial(link_index, link, len(robot.joints), what))
    far = max(map(abs, task.frame.point)) > RANGE["length"]
    require((not far, "the point is too far away", "$.robot.frame.point", None, allowed_range("length")))


def _check_coranks(analysis: _Analysed) -> None:
    for i, row in enumerate(analysis.coranks):
        where, share, unseen = f"$.coranks[{i}]", row.completeness, row.unseen
        number, least = (i + 1, analysis.generic_rank - i - 1), row.smallest_near_miss
        require(
            ((row.corank, row.rank) == number, "corank and rank are not the next ones", where, (row.corank, row.rank),
             number),
            (row.converged + row.near_misses + row.slow <= row.starts, "there are more ends than starts",
             f"{where}.starts", row.starts, None),
            (share.agree <= share.tested, "more points are explained than tested", f"{where}.completeness", None, None),
            (unseen.estimate <= unseen.upper, "the estimate is above its upper bound", f"{where}.unseen.estimate",
             unseen.estimate, None),
            (least is None or least >= 0.0, "a singular value is below zero", f"{where}.smallest_near_miss", least,
             None),
        )  # fmt: skip
    unfinished = analysis.unfinished
    require(
        (analysis.complete is (unfinished is None), "an analysis is complete, or names the corank that was interrupted",
         "$.unfinished", None, None),
        (unfinished in (None, len(analysis.coranks) + 1), "the unfinished corank is not the next one", "$.unfinished",
         unfinished, None),
    )  # fmt: skip


def _check_family(analysis: _Analysed, family: Family, where: str) -> None:
    """The family against the arm: first that its numbers fit, then the rank, the equations and what is lost."""
    robot, n, witness = analysis.robot, analysis.robot.n, family.witness
    require(
        (family.corank <= len(analysis.coranks), "nothing was searched at this corank", f"{where}.corank",
         family.corank, len(analysis.coranks)),
        (len(witness) == n, "the witness has another number of joints", f"{where}.witness", len(witness), n),
    )  # fmt: skip
    for j, (value, unit) in enumerate(zip(witness, robot.units, strict=True)):
        measure = "length" if unit == "m" else "angle"
        require((abs(value) <= RANGE[measure], "the value is too large", f"{where}.witness[{j}]", value,
                 allowed_range(measure)))  # fmt: skip
    kinds = sorted([*(pin.number for pin in family.pinned), *family.free, *family.coupled])
    once = kinds == list(range(1, n + 1))
    fits = family.soundness.agree <= family.soundness.tested and family.explained.agree <= family.explained.tested
    require(
        (once, "each joint is pinned, free or coupled, once", where, kinds, f"1 … {n}"),
        (fits, "more points hold than were tested", where, None, None),
        (joints_of_name(family.called) <= set(kinds), "the name is about a joint that the arm does not have",
         f"{where}.called", max(joints_of_name(family.called), default=0), f"1 … {n}"),
    )  # fmt: skip
    _check_equations(family, n, where)
    _check_rank(analysis, family, where)
    for i, pin in enumerate(family.pinned):
        _check_pin(robot, family, pin, f"{where}.pinned[{i}]", analysis.settings.tolerances.explained)


def _check_equations(family: Family, n: int, where: str) -> None:
    named = family.named is bool(family.equations)
    require((named, "a family has equations exactly where it is named", f"{where}.named", family.named, None))
    for i, equation in enumerate(family.equations):
        place = f"{where}.terms[{i}]"
        highest = max(max(map(abs, map(float, (*term.harmonics, *term.powers)))) for term in equation.terms)
        require(
            (equation.n == n, "the equation has another number of joints", place, equation.n, n),
            (highest <= _HIGHEST, "a power or a harmonic is too high", place, highest, f"up to {_HIGHEST}"),
            (not set(equation.joints) & set(family.free), "the equation binds a free joint", place,
             sorted(equation.joints), None),
        )  # fmt: skip
    fewest, most = 0, n
    if family.equations:
        slopes = np.stack([equation.gradient(np.array(family.witness)) for equation in family.equations])
        fewest = n - len(family.equations)
        most = n - int(np.linalg.matrix_rank(slopes, tol=1e-6 * max(1.0, float(np.abs(slopes).max()))))
    require((fewest <= family.dimension <= most, "the equations leave another dimension", f"{where}.dimension",
             family.dimension, f"{fewest} … {most}"))  # fmt: skip


def _check_rank(analysis: _Analysed, family: Family, where: str) -> None:
    tolerances, residual = analysis.settings.tolerances, analysis.residual_of(family)
    lost, place, rows = family.lost_directions, f"{where}.lost_directions", list(analysis.task.rows)
    require(
        (residual.equation <= tolerances.explained, "the witness does not satisfy the equations", f"{where}.witness",
         f"{residual.equation:.3g}", f"up to {tolerances.explained:g}"),
        (residual.sigma <= tolerances.singular < residual.kept, "the witness has another corank", f"{where}.witness",
         f"σ that vanish up to {residual.sigma:.3g}, σ that stay from {residual.kept:.3g}",
         f"corank {family.corank}, cut at {tolerances.singular:g}"),
        (lost.shape == (family.corank, 6) and len(family.lost_freedoms) == family.corank,
         "one direction and one sentence for each lost freedom", place, len(lost), family.corank),
    )  # fmt: skip
    for i, freedom in enumerate(family.lost_freedoms):
        held = _is_lost(analysis.robot, np.array(family.witness), freedom)
        require((held, "the motion is not lost at the witness", f"{where}.lost_freedoms[{i}]", None, None))
    whole = jacobian(analysis.robot, np.array(family.witness), analysis.task.frame)[rows]
    slip = np.abs(lost[:, rows] @ whole).max()
    still = slip <= _LOST * max(1.0, float(np.abs(whole).max())) and not np.delete(lost, rows, axis=1).any()
    require(
        (np.abs(lost @ lost.T - np.eye(len(lost))).max() <= _LOST, "the directions are not orthonormal", place, None,
         None),
        (still, "the directions are not those lost at the witness", place, None, None),
    )  # fmt: skip


def _is_lost(robot: Robot, q: Array, freedom: LostFreedom) -> bool:
    """Whether no joint moves along the direction u: |u · J_i| = 0 for every column, J in the lengths of u."""
    columns = jacobian(robot, q, freedom.frame)
    columns[:3] /= freedom.length
    u = np.array(freedom.direction)
    size = max(1.0, float(np.abs(columns).max()))
    return bool(abs(u @ u - 1.0) <= _LOST and np.abs(u @ columns).max() <= _LOST * size)


def _check_pin(robot: Robot, family: Family, pin: Pin, where: str, tolerance: float) -> None:
    joint, at_witness = robot.variables[pin.number - 1], family.witness[pin.number - 1]
    turns = bool(robot.periodic[pin.number - 1])
    gaps = [abs(value - at_witness) for value in pin.values]
    near = min(abs(wrap_angle(gap)) if turns else gap for gap in gaps) <= tolerance
    require(
        (pin.joint == joint.name, "the joint has another name", f"{where}.joint", pin.joint, joint.name),
        (near, "the witness is at none of the values", f"{where}.values", at_witness, None),
    )
    equations = [equation for equation in family.equations if equation.joints == (pin.number,)]
    for value in pin.values:
        q = np.array(family.witness)
        q[pin.number - 1] = value
        satisfied = all(abs(float(equation(q))) <= tolerance for equation in equations)
        require((satisfied, "the value does not satisfy the equations", f"{where}.values", value, None))


def _check_speeds(analysis: _Analysed, ids: Sequence[str]) -> None:
    """Distances that keep a speed are of families of the analysis, around a posture of its arm."""
    speeds = analysis.speeds
    if speeds is None:
        return
    named = [*(speed.family for speed in speeds.distances), *speeds.others]
    require(
        (set(named) <= set(ids), "a distance is of no family of the analysis", "$.speeds", ", ".join(named),
         ", ".join(ids)),
        (len(speeds.around) == analysis.robot.n, "the posture has another number of joints", "$.speeds.around",
         len(speeds.around), analysis.robot.n),
    )  # fmt: skip


def _check_exact(analysis: _Analysed, exact: Derivation) -> None:
    n = analysis.robot.n
    require((len(exact.shifts) in (0, n), "one shift for each joint", "$.exact.shifts", len(exact.shifts), n))
    if exact.derived:
        from rankdrop.exact.arm.chain import exact_chain  # with all exact algebra

        # of this task in this frame
        with_place("$.robot.frame", lambda: exact_chain(analysis.robot, analysis.task, parts=True))
    differs = (exact.status == "differs") is bool(exact.disagreements)
    require(
        (differs, "there are disagreements exactly where the status is differs", "$.exact.status", exact.status, None)
    )


def _check_exact_conditions(analysis: _Analysed) -> None:
    """Families have exact conditions only of a derivation, of the arm's joints."""
    names = [joint.name for joint in analysis.robot.variables]
    derived = analysis.exact is not None and analysis.exact.derived
    for i, family in enumerate(analysis.families):
        where, exact = f"$.families[{i}].exact", family.exact
        if exact is None:
            continue
        texts = len(exact.stated)
        require(
            (derived, "there are exact conditions, and nothing was derived", where, None, None),
            (len(exact.pinned) <= texts, "one condition for each joint", f"{where}.pinned", len(exact.pinned), texts),
            *((names[pin.number - 1 : pin.number] == [pin.joint], "the joint is another one", f"{where}.pinned",
               pin.joint, None) for pin in exact.pinned),
        )  # fmt: skip
