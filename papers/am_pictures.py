"""The data of AM Figures 1 to 9."""

from __future__ import annotations

import numpy as np

from papers.am_descent import PAIRED_SEED, RUNS, STEPPED, Descent, descend, run
from papers.am_method import AFTER, BEFORE, OFFSET, matched, offset_directions, pa10
from papers.am_robots import FIGURE_6, FIGURE_9, curves, lost_of_regional, row_configuration
from papers.picture import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    RED,
    Arrow,
    Line,
    Panel,
    Picture,
    against,
    arm_at,
    arrows,
)
from rankdrop.families import refine
from rankdrop.kinematics import pose
from rankdrop.local import lost_directions
from rankdrop.robot import Array, Robot, open_robot
from rankdrop.task import Task, resolve_task

_NAMES = {1: ("u6",), 2: ("u5", "u6"), 3: ("u4", "u5", "u6")}
_COLOURS = {1: (BLUE,), 2: (RED, BLUE), 3: (GREEN, RED, BLUE)}

def descent(figure: int) -> Picture:
    """Figure 1, 2 or 3: singular values, and angles between successive gradients."""
    found, how = run(figure), RUNS[figure]
    panels = list(descent_panels(found, "ab", marks=figure != 2))
    end = {
        1: f"It is stuck on the crease σ5 = σ6 at {found.sigma[-1, 4]:.1e}; with ties treated it converges in "
        f"{run(1, 'almarkhi').iterations} iterations.",
        2: f"It is held up by σ4 = σ5: σ4 = {found.sigma[-1, 3]:.2g} at the end. Figure 3 has the same start.",
        3: f"The start of Figure 2, ties treated (eqs 12 to 14): it converges in {found.iterations} iterations.",
    }[figure]
    other = STEPPED[figure]
    turning = descend(other)
    panels += descent_panels(turning, "cd", marks=figure == 3)
    angles = np.degrees(turning.angles)
    share = "" if other.step == 1.0 else f"{other.step} of "
    caption = (
        f"(a), (b): descent of σ{found.rank + 1} with an exact line search from start {how.start} of seed "
        f"{PAIRED_SEED}, picked of 2,000 because it meets a tie. {end} (c), (d): with {share}the step to linearised "
        f"zero, start {other.start} of seed {other.seed}: gradients turn by up to {np.nanmax(angles):.0f}°, by "
        f"{np.nanmean(angles):.0f}° on average, σ{turning.rank + 1} = {turning.sigma[-1, turning.rank]:.1e} after "
        f"{turning.iterations} iterations. "
    )
    return Picture("AM", f"Figure {figure}", f"{caption}AM print neither start nor rule of steps.", tuple(panels), {
        "method": how.method, "seed": PAIRED_SEED, "start": how.start,
    })  # fmt: skip


def descent_panels(found: Descent, parts: str, *, marks: bool) -> tuple[Panel, Panel]:
    """Singular values of one run, and the angles between its successive gradients."""
    steps = np.arange(len(found.sigma))
    driven = {4: ((4, RED), (5, BLUE)), 3: ((3, GREEN), (4, RED), (5, BLUE))}[found.rank]
    values = tuple(
        Line(f"σ{i + 1}", against(steps, np.maximum(found.sigma[:, i], 1e-17)), colour) for i, colour in driven
    )
    dots = "" if len(steps) > 500 else "-"  # a line back and forth a thousand times is a block
    turned = Line("", against(steps[: len(found.angles)], np.degrees(found.angles)), BLACK, dots, dots == "" or marks)
    return (
        Panel(f"({parts[0]})", values, x="iteration", y="singular value", log="y", level=1e-6),
        Panel(f"({parts[1]})", (turned,), x="iteration", y="turn of the gradient [deg]", span=(0.0, 180.0)),
    )


def figure_4() -> Picture:
    """The directions of section 2.3 before and after the rotation."""
    robot = open_robot("pa10")
    q = np.zeros(7)
    tip = pose(robot, q)[:3, 3] + np.array([OFFSET, 0.0, 0.0])
    printed = np.array([float(word) for word in AFTER.split()]).reshape(6, 3)
    rotated = matched(offset_directions(), printed)  # u4, u5, u6 in AM's order and sense
    panels = tuple(
        Panel(title, (aside(robot, q, tip),), arrows(tip, list(rows.T), _NAMES[3], _COLOURS[3]), z="z [m]", tall=True,
              arms=(arm_at(robot, q),))
        for title, rows in (("(a) as the SVD gives them", unrotated(rotated)), ("(b) rotated", rotated))
    )  # fmt: skip
    caption = (
        "A rank-3 singularity. AM do not name the robot; with the PA-10 stretched and the reference point 0.45 m "
        "(fitted) aside of its line, at the end of the grey line, the printed numbers follow. (a): the vectors printed "
        "for the SVD, made orthonormal in the subspace that is lost. Solid: translation, dotted: rotation."
    )
    return Picture("AM", "Figure 4", caption, panels)


def aside(robot: Robot, q: Array, point: Array) -> Line:
    """From the tip to the reference point."""
    return Line("", np.stack([pose(robot, q)[:3, 3], point]), GREY, ":")


def unrotated(rotated: Array) -> Array:
    """(6, 3) the orthonormal basis of the span of `rotated` that is nearest to the printed SVD vectors.

    The SVD of a subspace to zero may return any basis of it. AM print theirs, to two digits: U = B P Qᵀ with
    Bᵀ B₀ = P S Qᵀ, B = `rotated`, B₀ the printed one.
    """
    before = np.array([float(word) for word in BEFORE.split()]).reshape(6, 3)
    left, _, right = np.linalg.svd(rotated.T @ before)
    return np.asarray(rotated @ left @ right)


def figure_5() -> Picture:
    """The singular set of the 4-DoF robot."""
    turned = [_wrapped(curve.q[:, 1:]) for curve in curves()]
    colours = (BLUE, RED, GREEN, BLACK)
    flat = tuple(Line("", q[:, :2], colour) for q, colour in zip(turned, colours, strict=False))
    deep = tuple(Line("", q, colour) for q, colour in zip(turned, colours, strict=False))
    return Picture("AM", "Figure 5", "Four closed curves, times the circle of θ1.", (
        Panel("(a)", flat, x="θ2 [rad]", y="θ3 [rad]"),
        Panel("(b)", deep, x="θ2 [rad]", y="θ3 [rad]", z="θ4 [rad]"),
    ), {"lengths": [curve.length for curve in curves()]})  # fmt: skip


def _wrapped(q: Array) -> Array:
    """Angles in (−π, π], with a gap where a curve leaves the box."""
    inside = q - 2 * np.pi * np.ceil((q - np.pi) / (2 * np.pi))
    jumps = np.flatnonzero(np.abs(np.diff(inside, axis=0)).max(axis=1) > np.pi) + 1
    return np.asarray(np.insert(inside, jumps, np.nan, axis=0))


def figure_6() -> Picture:
    """The 4-DoF robot in two singular configurations."""
    robot = open_robot("almarkhi4")
    task = resolve_task(None, robot, length_scale=1.0)
    panels = []
    for part, (text, axis, _) in FIGURE_6.items():
        q = refine(robot, [[float(word) for word in text.split()]], 1, task=task).q[0]
        printed = np.array([float(word) for word in axis.split()])
        u3 = lost_of_regional(q)
        tip = pose(robot, q)[:3, 3]
        both = (
            Arrow("u3", tip, u3 * np.sign(u3 @ printed), False, BLUE), Arrow("as printed", tip, printed, False, GREY),
        )  # fmt: skip
        panels.append(Panel(part, (), both, z="z [m]", tall=True, arms=(arm_at(robot, q),)))
    caption = (
        "Rank-1 singular configurations of the 4-DoF robot, those nearest to the printed angles: the direction u3 that "
        "is lost, and the axis that is printed for it."
    )
    return Picture("AM", "Figure 6", caption, tuple(panels))


def on_row(robot: Robot, task: Task, title: str, q: Array, corank: int) -> Panel:
    """The PA-10 at q with the directions lost there, in base axes at the end effector."""
    lost = lost_directions(robot, q, task, corank)
    tip = pose(robot, q)[:3, 3]
    drawn = arrows(tip, list(lost), _NAMES[corank], _COLOURS[corank])
    return Panel(title, (), drawn, z="z [m]", tall=True, arms=(arm_at(robot, q),))


def figures_7_8(figure: int) -> Picture:
    """The PA-10 on the rows of Table 3 or 4."""
    robot, task = pa10()
    corank = figure - 6
    panels = [
        on_row(robot, task, f"({part}) row {row}", row_configuration(corank, row), corank)
        for row, part in zip(range(1, 5), "abcd", strict=True)
    ]
    caption = f"Rank-{corank} singularities, one per row of Table {corank + 2}. Solid: translation, dotted: rotation."
    return Picture("AM", f"Figure {figure}", caption, tuple(panels))


NINE = (
    "Rank-3 singularities, the arm (a) stretched and (b) folded, where its forearm lies in its upper arm. Solid: "
    "translation, dotted: rotation."
)


def figure_9() -> Picture:
    """The PA-10 stretched and folded."""
    robot, task = pa10()
    panels = [on_row(robot, task, part, np.array(theta), 3) for part, theta in FIGURE_9.items()]
    return Picture("AM", "Figure 9", NINE, tuple(panels))


def pictures() -> tuple[Picture, ...]:
    """All nine."""
    return (
        *(descent(figure) for figure in (1, 2, 3)), figure_4(), figure_5(), figure_6(),
        figures_7_8(7), figures_7_8(8), figure_9(),
    )  # fmt: skip
