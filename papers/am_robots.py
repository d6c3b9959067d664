"""AM section 3: the 4-DoF regional robot (Table 1, Figures 5 and 6) and the PA-10 (Tables 2 to 5, Figures 7 to 9)."""

from __future__ import annotations

from functools import cache
from math import acos, asin, atan, cos, degrees, pi, sin, sqrt

import numpy as np

from papers.am_method import pa10
from papers.item import Sheet, Shown, listed, rounded
from rankdrop import conditions
from rankdrop.exact import derive, exact_chain
from rankdrop.families import Family, Outcome, SingularCurve, refine, search, singular_curves
from rankdrop.kinematics import jacobian, link_poses, pose
from rankdrop.local import (
    decompose,
    failures_at,
    lost_directions,
    lost_in_sparsest_frame,
    relations_at,
    sample,
    singular_values,
    words,
)
from rankdrop.results import Analysis, known_analysis
from rankdrop.robot import Array, from_dh, open_robot, reach
from rankdrop.task import resolve_task
from rankdrop.verbs import most_tolerant

TABLE_1 = [("sqrt(2)", "pi/2", "0"), ("sqrt(2)", "-pi/2", "1"), ("sqrt(2)", "pi/2", "-1"), ("sqrt(3)/2", "0", "1/2")]
TABLE_2 = [("0", "-pi/2", "0"), ("0", "pi/2", "0"), ("0", "-pi/2", "0.45"), ("0", "pi/2", "0"), ("0", "-pi/2", "0.5"),
           ("0", "pi/2", "0"), ("0", "0", "0.45")]  # fmt: skip
"""Rows (a [m], α [rad], d [m]) as printed; θ_i is the variable."""
X, ZERO, HALF = "×", "±π, 0", "±π/2"
TABLES = {
    1: ((X, ZERO, HALF, X, X, X, X), (X, ZERO, X, X, X, ZERO, X), (X, X, X, ZERO, X, X, X), (X, X, X, X, HALF, ZERO,
    X)),
    2: ((X, ZERO, ZERO, ZERO, X, X, X), (X, ZERO, X, ZERO, X, ZERO, X), (X, X, X, ZERO, ZERO, ZERO, X),
        (X, ZERO, HALF, X, HALF, ZERO, X)),
}  # fmt: skip
"""Tables 3 and 4 by corank, a cell per joint."""
TABLE_5 = (X, ZERO, X)
"""What is left of Table 5's only row: θ1, θ2, θ3."""
FIGURE_6 = {
    "(a)": ("-3.11 3.02 -1.53 0.15", "0 1 0", "Y"),
    "(b)": ("-1.76 -1.85 -1.39 0.02", "-1 0 0", "−X"),
}
FIGURE_9 = {"(a)": (0.0,) * 7, "(b)": (pi, 0.0, pi, pi, pi, pi, pi)}
OTHER = (0.3, -0.4, 1.1, 0.9, -0.7, 1.3, 0.5)  # values for joints that do not matter: nothing special about them


@cache
def known(name: str) -> Analysis:
    """The shipped analysis of an arm: 10,000 starts for each corank, as AM have them."""
    robot = open_robot(name)
    found = known_analysis(robot, resolve_task(None, robot))
    assert found is not None, name
    return found


@cache
def curves() -> tuple[SingularCurve, ...]:
    """The singular set of the 4-DoF robot at θ1 = 0 (AM Figure 5)."""
    return singular_curves(open_robot("almarkhi4"), (2, 3, 4))


def cells(family: Family) -> tuple[str, ...]:
    """A family as a row of AM's tables; "coupled" where conditions tie joints together."""
    row = [X] * 7
    for pinned in family.pinned:
        values = tuple(sorted(abs(value) for value in pinned.values))
        zero = np.allclose(values, (0.0, pi), atol=1e-9)
        half = np.allclose(values, (pi / 2, pi / 2), atol=1e-9)
        row[pinned.number - 1] = ZERO if zero else HALF if half else listed(pinned.values)
    for number in family.coupled:
        row[number - 1] = "coupled"
    return tuple(row)


def table_rows(sheet: Sheet, item: str, name: str, printed: list[tuple[str, str, str]]) -> None:
    """A DH table beside the arm of the catalogue: screws and home pose."""
    arm, ours = from_dh([(*row, 0) for row in printed], convention="standard"), open_robot(name)
    q = sample(arm, resolve_task("pose", arm), 20, 1)
    error = max(float(np.abs(jacobian(arm, q) - jacobian(ours, q)).max()), float(np.abs(pose(arm, q) - pose(ours,
        q)).max()))
    text = "; ".join(" ".join(row) for row in printed)
    sheet.identity(item, f"DH parameters (a, α, d), read as standard DH: Jacobian and pose of {name}", text, error,
                   tolerance=1e-12)  # fmt: skip


def regional_robot(sheet: Sheet) -> None:
    """Table 1, which ranks it loses, Figure 5."""
    table_rows(sheet, "Table 1", "almarkhi4", TABLE_1)
    coranks = [summary.corank for summary in known("almarkhi4").coranks if summary.converged]
    robot = open_robot("almarkhi4")
    second = search(robot, 2, task=resolve_task(None, robot, length_scale=1.0), starts=1000, seed=0)
    sheet.same(
        "section 3.2", "ranks of singularities of the 4-DoF robot", "rank-1",
        ", ".join(f"rank-{corank}" for corank in coranks),
        reason=f"Of 1000 starts for rank 2 {second.count(Outcome.CONVERGED)} converge; the smallest local minimum of "
        f"σ2 met is {rounded(second.smallest_near_miss or 0.0, 5)} m. Not a proof.",
    )  # fmt: skip
    found = curves()
    sheet.claim(
        "Figure 5", "the singular set in (θ2, θ3, θ4)", "continuous manifolds in the joint space",
        f"{len(found)} closed curves, each once round in θ2, of lengths {listed([c.length for c in found], 1)} rad",
        len(found) == 4 and all(c.closed and c.windings == (0, 1, 0, 0) for c in found),
        reason="Traced; each times the circle of θ1, which does not matter.",
    )  # fmt: skip
    q = np.concatenate([curve.q for curve in found])
    sigma = singular_values(robot, q, resolve_task(None, robot, length_scale=1.0))
    sheet.claim("Figure 5", "every point is singular, of rank 1", "rank-1 singularities",
                f"σ3 ≤ 1e-9 and σ2 ≥ {rounded(float(sigma[:, 1].min()), 2)} m on all of them",
                bool(sigma[:, 2].max() <= 1e-9 and sigma[:, 1].min() > 0.1))  # fmt: skip
    tip = np.linalg.norm(pose(robot, found[0].q)[:, :3, 3], axis=1)
    sheet.claim(
        "section 3.2", "the manifolds are not self-motions: the end effector moves along them",
        "not the same as the self-motion manifolds",
        f"its distance from the base origin goes from {rounded(tip.min(), 2)} m to {rounded(tip.max(), 2)} m on the "
        "longest curve", bool(np.ptp(tip) > 0.1),
    )  # fmt: skip


def fault_tolerance(sheet: Sheet) -> None:
    """Section 3.2: what the failure of a joint leaves of the 4-DoF robot where it is optimal."""
    robot = open_robot("almarkhi4")
    task = resolve_task(None, robot, length_scale=1.0)
    found = most_tolerant(robot, task, relative=True, starts=60)
    best = found.places[0]
    names = [f"θ{number} any" for number in found.free]
    names += [f"θ{j + 1} = {rounded(best.q[j])}" for j in range(robot.n) if j + 1 not in found.free]
    expected = [pi, pi, pi - atan(sqrt(0.5))]
    sheet.claim(
        "section 3.2", "where the arm is optimally fault tolerant, by search over its joint space",
        "a locally optimal fault-tolerant robot (no configuration)",
        f"{', '.join(names)}: the least σ3 left by a failure is {rounded(best.value)} σ1, and no arm with 4 joints for "
        "3 freedoms can do better than √(1/4) σ1",
        bool(found.optimal and np.abs(best.q[1:] - expected).max() < 1e-5),
        reason="θ2 = θ3 = π, θ4 = π − arctan(1/√2). AM do not print it: it is in the work cited; Table 1 is enough to "
        "find it.",
    )  # fmt: skip
    q = np.array([0.3, *expected])
    parts = decompose(robot, q, task)
    null = parts.v[:, 3] * np.sign(parts.v[0, 3])
    left = failures_at(robot, q, task)
    sheet.claim(
        "section 3.2", "singular values there, null vector, σ3 left after the failure of joint 1, 2, 3, 4",
        "optimal: all σ equal, all entries of the null vector equal, √((n − m)/n) σ after each failure",
        f"{listed(parts.sigma)}; {listed(null)}; {listed([one.sigma_min for one in left.single])}",
        bool(np.ptp(parts.sigma) < 1e-9 and np.abs(null - 0.5).max() < 1e-9
             and max(abs(one.sigma_min - 0.5) for one in left.single) < 1e-9),
    )  # fmt: skip


def lost_of_regional(q: Array) -> Array:
    """(3,) the direction that the 4-DoF robot loses at q [1]."""
    robot = open_robot("almarkhi4")
    return np.asarray(decompose(robot, q, resolve_task(None, robot, length_scale=1.0)).u[:, 2])


def figure_6(sheet: Sheet) -> None:
    """Two singular configurations and the directions lost there."""
    robot = open_robot("almarkhi4")
    task = resolve_task(None, robot, length_scale=1.0)
    for part, (text, axis, name) in FIGURE_6.items():
        theta = np.array([float(word) for word in text.split()])
        found = refine(robot, [theta], 1, task=task)
        sheet.numbers(
            f"Figure 6{part}", "joint angles of the singular configuration nearby [rad]", text, found.q[0],
            reason=f"At the printed angles σ3 = {float(singular_values(robot, theta, task)[2]):.2e} m, not zero: they "
            "are rounded. Ours is where Newton's method ends from there.",
        )  # fmt: skip
        printed = np.array([float(word) for word in axis.split()])
        u3 = lost_of_regional(found.q[0])
        u3 = u3 * np.sign(u3 @ printed)
        angle = degrees(acos(min(1.0, float(u3 @ printed))))
        there = lost_of_regional(theta)
        same = degrees(acos(min(1.0, abs(float(there @ u3)))))
        sheet.numbers(
            f"Figure 6{part}", f"singular direction u3, printed as aligned with {name}", axis, u3, few=0.0,
            reason="The direction is near that axis, not along it; rounding of the angles does not explain it.",
            shown=Shown(f"u3 is {angle:.1f}° from the printed axis, and turns by {same:.2f}° between the printed and "
                        "the exact configuration.", angle > 5.0 and same < 1.0),
        )  # fmt: skip


def pa10_tables(sheet: Sheet) -> None:
    """Tables 2 to 5 and what is said about them."""
    table_rows(sheet, "Table 2", "pa10", TABLE_2)
    analysis = known("pa10")
    for corank, printed in TABLES.items():
        ours = [cells(family) for family in analysis.of_corank(corank)]
        for number, row in enumerate(printed, start=1):
            met = next((one for one in ours if one == row), ours[min(number, len(ours)) - 1])
            sheet.same(f"Table {corank + 2}, row {number}", f"rank-{corank} condition, θ1 … θ7", " | ".join(row),
                       " | ".join(met))  # fmt: skip
        summary = analysis.coranks[corank - 1]
        sheet.claim(
            f"Table {corank + 2}", "is the table complete", f"all rank-{corank} singularities, {len(printed)} rows",
            f"{len(ours)} rows, which explain {summary.completeness.agree} of {summary.completeness.tested} fresh "
            "singular points",
            len(ours) == len(printed) and summary.completeness.agree == summary.completeness.tested,
        )  # fmt: skip
    table_5(sheet, analysis)
    equal = [(*row[:2], "0.45" if number == 5 else row[2], 0) for number, row in enumerate(TABLE_2, start=1)]
    q = np.array(OTHER)
    q[3] = pi
    twin = from_dh(equal, convention="standard")
    lost = int((singular_values(twin, q, resolve_task("pose", twin)) <= 1e-9).sum())
    sheet.claim("Tables 3 to 5", "θ4 = ±π loses one freedom", "rank-1 (upper arm 0.45 m, forearm 0.5 m)",
                f"because these differ: with both 0.45 m it loses {lost}", lost == 2,
                reason="The tables hold for d3 ≠ d5, which the document does not say.")  # fmt: skip
    sheet.same("section 3.3.1", "ranks of singularities of the PA-10", "rank-1, rank-2, rank-3",
               ", ".join(f"rank-{s.corank}" for s in analysis.coranks if s.converged))  # fmt: skip
    free = {corank: {tuple(sorted({1, 7} & set(f.free))) for f in analysis.of_corank(corank)} for corank in (1, 2, 3)}
    sheet.claim("section 3.3.3", "the conditions of rank 2 do not depend on θ1 or θ7", "θ1 and θ7 do not matter",
                "; ".join(f"rank-{corank}: free together are {', '.join(map(str, sorted(rows)))}"
                          for corank, rows in free.items()), set.union(*free.values()) == {(1, 7)})  # fmt: skip


def table_5(sheet: Sheet, analysis: Analysis) -> None:
    """The only row of Table 5, whose end is missing, and the words beside it."""
    robot, task = pa10()
    (family,) = analysis.of_corank(3)
    q = np.array(OTHER)
    q[[1, 3, 4, 5]] = 0.0
    kept = float(singular_values(robot, q, task)[3])
    sheet.same(
        "Table 5, row 1", "rank-3 condition, θ1 … θ7", " | ".join((*TABLE_5, "…")), " | ".join(cells(family)),
        reason="The row is cut off in the document, and × for θ3 cannot be.",
        shown=Shown(f"At θ2 = θ4 = θ5 = θ6 = 0 and θ3 = {OTHER[2]} the rank loss is 2: σ4 = {kept:.3f}.", kept > 1e-3),
    )  # fmt: skip
    q = np.array(OTHER)
    q[[1, 3, 5]] = 0.0
    sigma = singular_values(robot, q, task)
    lost = int((sigma <= 1e-9).sum())
    sheet.claim(
        "section 3.3.4", "aligning the axes of joints 1, 3, 5, 7 (θ2 = θ4 = θ6 = 0)", "rank-3 singularities",
        f"rank-{lost} alone; rank 3 needs θ3 and θ5 in {{0, ±π}} as well", lost == 3,
        reason="Columns 1, 3, 5, 7 are then multiples of one, but columns 2, 4, 6 need not be dependent.",
        shown=Shown(f"σ4 = {sigma[3]:.3f}, σ5 = 0 there; it is row 2 of Table 4.",
                    bool(sigma[3] > 1e-3 and sigma[4] <= 1e-9)),
    )  # fmt: skip
    four = np.linalg.matrix_rank(jacobian(robot, q)[:, [0, 2, 4, 6]], tol=1e-9)
    sheet.numbers("section 3.3.4", "rank of columns 1, 3, 5, 7 of J where these axes are aligned", "1", four,
                  reason="Printed as: so that their columns are linearly dependent.")  # fmt: skip


def reciprocal_screws(sheet: Sheet) -> None:
    """Section 1: rank-2 singularities by reciprocal screws (Nokleby and Podhorodeski 2004a), against Tables 3 and 4."""
    robot, _ = pa10()
    found = conditions(robot, method="reciprocity", coranks=2)
    ours = {cells(family) for family in found.of_corank(2)}
    derived = derive(exact_chain(robot), "reciprocity", corank=2)
    count = 100
    on_rows = [derived.holds(row_configurations(row, count)).all() for row in TABLES[2]]
    beside = [derived.holds(row_configurations(row, count)).any() for row in TABLES[1]]
    sheet.claim(
        "section 1", "rank-2 singularities of a 7-DoF manipulator by the reciprocity-based methodology",
        "was extended to identify them",
        f"PA-10: {derived.sizes['cases']} cases, {len(derived.conditions)} conditions; they hold at all of {count} "
        f"random configurations on each row of Table 4 and at none on those of Table 3; the rank tree agrees",
        found.verified and ours == set(TABLES[2]) and all(on_rows) and not any(beside),
        reason="`rankdrop conditions pa10 --method reciprocity --coranks 2`; the work cited is not at hand.",
    )  # fmt: skip


def row_configurations(row: tuple[str, ...], count: int) -> Array:
    """(count, 7) random configurations on a row of Table 3 or 4."""
    robot, task = pa10()
    q = sample(robot, task, count, 7)
    signs = np.random.default_rng(7).integers(2, size=q.shape)
    zero = [cell == ZERO for cell in row]
    half = [cell == HALF for cell in row]
    q[:, zero] = pi * signs[:, zero]
    q[:, half] = pi * signs[:, half] - pi / 2
    return q


def pa10_words(sheet: Sheet) -> None:
    """What section 3.3 says of the structure."""
    robot, _ = pa10()
    q = np.array(OTHER)
    always = {relation.words for relation in relations_at(robot, q) if relation.structural}
    meets = [one for one in ("axes 1, 2, 3 meet in one point", "axes 5, 6, 7 meet in one point") if one in always]
    sheet.claim("section 3.3.1", "three joints in the shoulder and three in the wrist that act as a ball joint",
                "three spherical joints in the shoulder, one in the elbow, three in the wrist",
                "; ".join(meets), len(meets) == 2)  # fmt: skip
    gradient = []
    for e in np.eye(7):
        ahead, back = link_poses(robot, q + 1e-6 * e), link_poses(robot, q - 1e-6 * e)
        gradient.append((_shoulder_to_wrist(ahead) - _shoulder_to_wrist(back)) / 2e-6)
    moving = [number for number, rate in enumerate(gradient, start=1) if abs(rate) > 1e-6]
    sheet.same("section 3.3.2", "joints that change the distance between shoulder and wrist", "joint 4",
               ", ".join(f"joint {number}" for number in moving))  # fmt: skip


def _shoulder_to_wrist(poses: Array) -> float:
    """Distance of the wrist centre (origin of link 5) from the shoulder (origin of link 1) [m]."""
    return float(np.linalg.norm(poses[5, :3, 3] - poses[1, :3, 3]))


def row_configuration(corank: int, row: int) -> Array:
    """(7,) a configuration on one row of Table 3, 4 or 5: first values of the pinned joints, nothing special else."""
    printed = TABLES[corank][row - 1] if corank < 3 else cells(known("pa10").of_corank(3)[0])
    return np.array([{ZERO: 0.0, HALF: pi / 2}.get(cell, other) for cell, other in zip(printed, OTHER, strict=True)])


def lost_at(q: Array, corank: int) -> tuple[tuple[str, ...], Array]:
    """The motions lost at q in words and as (k, 6) rows (v; ω), in the frame where they are sparsest."""
    robot, task = pa10()
    found = lost_in_sparsest_frame(robot, q, task, corank)
    return tuple(words(row, found.name) for row in found.directions), found.directions


def printed_null_directions(q: Array, count: int) -> Array:
    """(6, count) u_{6 − count + 1} … u_6 of the Jacobian that Table 2 gives by hand: columns (z_i × p_i; z_i)."""
    pose_of: Array = np.eye(4)
    frames = [pose_of]
    for (a, alpha, d), theta in zip(TABLE_2, q, strict=True):
        twist = {"pi/2": pi / 2, "-pi/2": -pi / 2, "0": 0.0}[alpha]
        ct, st, ca, sa = cos(theta), sin(theta), cos(twist), sin(twist)
        link = [[ct, -st * ca, st * sa, float(a) * ct], [st, ct * ca, -ct * sa, float(a) * st], [0, sa, ca, float(d)],
                [0, 0, 0, 1]]  # fmt: skip
        pose_of = pose_of @ np.array(link)
        frames.append(pose_of)
    columns = [[*np.cross(one[:3, 2], frames[-1][:3, 3] - one[:3, 3]), *one[:3, 2]] for one in frames[:-1]]
    return np.asarray(np.linalg.svd(np.array(columns).T)[0][:, 6 - count :])


def angle_between(rows: Array, columns: Array) -> float:
    """Largest principal angle between the spans of (k, 6) orthonormal rows and (6, k) orthonormal columns [deg]."""
    outside = rows.T - columns @ (columns.T @ rows.T)
    return degrees(asin(min(1.0, float(np.linalg.norm(outside, 2)))))


def in_six(row: Array) -> str:
    """A direction (v; ω) with few digits."""
    return f"({listed(row[:3], 2)}; {listed(row[3:], 2)})"


ARROWS = (
    "Directions are (v; ω) in base axes at the end effector; AM print no numbers of the arrows. The u are those of the "
    "Jacobian of Table 2, made by hand, columns (z × p; z), and taken apart by LAPACK."
)


def figures_7_8_9(sheet: Sheet) -> None:
    """The PA-10 on every row, with the directions lost."""
    robot, task = pa10()
    for corank, figure in ((1, 7), (2, 8)):
        for row, part in zip(range(1, 5), "abcd", strict=True):
            q = row_configuration(corank, row)
            told, _ = lost_at(q, corank)
            ours = lost_directions(robot, q, task, corank)
            angle = angle_between(ours, printed_null_directions(q, corank))
            arrows = {1: "u6", 2: "u5, u6"}[corank]
            sheet.claim(
                f"Figure {figure}({part})", f"directions lost on row {row} of Table {corank + 2}, θ = {listed(q, 2)}",
                f"{arrows} (arrows)",
                f"{', '.join(map(in_six, ours))}, {rounded(angle, 1)}° from the span of {arrows}; {'; '.join(told)}",
                len(ours) == len(told) == corank and angle < 1e-5, reason=ARROWS,
            )  # fmt: skip
    fifth = min(float(singular_values(robot, row_configuration(1, row), task)[4]) for row in range(1, 5))
    sheet.claim("section 3.3.2", "rank-1 singular directions are well defined", "well defined",
                f"σ5 is at least {rounded(fifth, 3)} on the rows of Table 3", fifth > 1e-3)
    for part, theta in FIGURE_9.items():
        q = np.array(theta)
        sigma = singular_values(robot, q, task)
        told, _ = lost_at(q, 3)
        ours = lost_directions(robot, q, task, 3)
        angle = angle_between(ours, printed_null_directions(q, 3))
        sheet.claim(
            f"Figure 9{part}", "rank and directions lost", "rank-3; u4, u5, u6 (arrows)",
            f"rank-{int((sigma <= 1e-9).sum())}; {', '.join(map(in_six, ours))}, {rounded(angle, 1)}° from the span of "
            f"u4, u5, u6; {'; '.join(told)}",
            bool((sigma <= 1e-9).sum() == 3 and len(ours) == len(told) == 3 and angle < 1e-5), reason=ARROWS,
        )  # fmt: skip
    lengths = [float(np.linalg.norm(pose(robot, np.array(theta))[:3, 3])) for theta in FIGURE_9.values()]
    sheet.claim(
        "section 3.3.4", "where the two are in the workspace", "completely stretched out; folded back on itself",
        f"end effector {rounded(lengths[0], 2)} m from the shoulder, which is the arm's reach, and "
        f"{rounded(lengths[1], 2)} m",
        abs(lengths[0] - reach(robot)) < 1e-9 and lengths[1] < lengths[0] / sqrt(2),
    )  # fmt: skip


SECTIONS = (
    ("4-DoF robot", regional_robot), ("fault tolerance", fault_tolerance), ("Figure 6", figure_6),
    ("Tables 2 to 5", pa10_tables), ("reciprocal screws", reciprocal_screws), ("PA-10", pa10_words),
    ("Figures 7 to 9", figures_7_8_9),
)  # fmt: skip
