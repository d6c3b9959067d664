"""Figures for papers, drawn with matplotlib: the arm at a witness, slices, sets in three joints, workspace, σ lines.

Every function returns a `matplotlib.figure.Figure`; nothing is shown, and no global state is touched.

What drawings of arms are made of, for matplotlib: joints as cylinders and boxes, axes, arrows with heads.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import BytesIO
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.families import Slice, Solid, Sweep, Workspace
from rankdrop.family import Family
from rankdrop.kinematics import link_poses
from rankdrop.local import Drawn, drawn_at
from rankdrop.report.content import Content, pieces
from rankdrop.report.svg import angle_ticks, axis_name
from rankdrop.results import Analysis
from rankdrop.robot import Array, Robot, reach
from rankdrop.text import joint_symbol
from rankdrop.viewer.scene import arrows, barrel_mesh

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LINK, BODY, AXIS, MARKED = "#7C8B9B", "#4F6073", "#A9B4C0", "#E07B00"
_RADIUS, _HALF, _APART = 0.035, 0.045, 0.11
"""Of a joint's body, and how far joints of one place are drawn from it along their axes; lengths per size."""
_HEAD, _WIDTH, _SIDES = 0.075, 0.026, 16
"""Of an arrow head, per size."""


def draw_arm(axes: Any, drawn: Drawn, size: float, marked: Sequence[int] = (), long: float = 0.09) -> None:
    """An arm on axes in space: its links, a body for each joint, its axis as a line with its number.

    Joints whose axes meet in one point are drawn apart on their axes.

    Args:
        axes: of matplotlib, with projection="3d".
        drawn: the arm.
        size: length that everything is drawn in proportion to, such as the reach [m].
        marked: numbers of joints that are drawn in another colour, with longer axes.
        long: how far axes stand out of their joints, per size.
    """
    axes.set_autoscale_on(False)  # whoever draws sets the limits
    axes.plot(*drawn.links.T, color=LINK, lw=4, solid_capstyle="round", solid_joinstyle="round")
    places = spread_out(drawn, _APART * size)
    for place, middle, axis, slides, number in zip(
        places, drawn.middles, drawn.axes, drawn.slides, drawn.numbers, strict=True
    ):
        tone = MARKED if number in marked else BODY
        if np.any(place != middle):
            axes.plot(*np.stack([middle, place]).T, color=LINK, lw=2.5)
        sides = 4 if slides else _SIDES
        half = _HALF * size * axis
        _add(axes, barrel_mesh(place - half, place + half, _RADIUS * size, sides=sides), tone)
        reached = (_HALF + (0.28 if number in marked else long)) * size
        line = np.stack([place - reached * axis, place + reached * axis])
        axes.plot(*line.T, color=MARKED if number in marked else AXIS, lw=1.1, ls="-.")
        axes.text(*(place + (reached + 0.03 * size) * axis), str(number), fontsize=7, zorder=1000,
                  color=MARKED if number in marked else "black")  # fmt: skip


def draw_arrow(axes: Any, start: Array, vector: Array, colour: str, size: float, *, dotted: bool = False,
               label: str | None = None) -> None:  # fmt: skip
    """An arrow in space: its shaft solid or dotted, its head a cone of a size that does not depend on its length."""
    start, end = np.asarray(start, dtype=np.float64), np.asarray(start + vector, dtype=np.float64)
    along = vector / np.linalg.norm(vector)
    axes.plot(*np.stack([start, end - 0.9 * _HEAD * size * along]).T, color=colour, lw=2.0, ls=":" if dotted else "-",
              label=label)  # fmt: skip
    head = barrel_mesh(end - _HEAD * size * along, end, _WIDTH * size, sides=_SIDES, taper=1e-3)
    _add(axes, head, colour)


def spread_out(drawn: Drawn, apart: float) -> Array:
    """(N, 3) where joints are drawn: those that share a point go apart on their axes, the first back, the last on."""
    places = drawn.middles.copy()
    first = 0
    while first < len(places):
        last = first
        while last + 1 < len(places) and np.linalg.norm(places[last + 1] - drawn.middles[first]) < 0.5 * apart:
            last += 1
        if last > first:
            places[first] -= apart * drawn.axes[first]
        if last > first + 1:
            places[last] += apart * drawn.axes[last]
            if np.linalg.norm(places[last] - places[first]) < 0.5 * apart:  # axes that point against each other
                places[last] += apart * drawn.axes[last]
        first = last + 1
    return places


def _add(axes: Any, shape: tuple[Array, NDArray[np.uint32]], colour: str) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    vertices, faces = shape
    axes.add_collection3d(Poly3DCollection(vertices[faces], facecolors=colour, shade=True))


KINDS = ("arm", "slice", "solid", "workspace", "image", "lines")
"""What figures there are; each but the workspace is of one family: arm-k1.f1."""
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B07D00", "#56B4E9", "#6B6B6B", "#7A4FB5")
"""Of the families, after Okabe and Ito."""
_DPI = 200
_DATE = {"pdf": {"CreationDate": None}, "svg": {"Date": None}, "png": {}}  # same input, same file


def figure_names(content: Content, wanted: Sequence[str] = ()) -> list[str]:
    """Names of the figures that there are, or of those of them that are wanted ("lines", "lines-k1.f1")."""
    ids = [family.id for family in content.analysis.families]
    names = [f"arm-{one}" for one in ids]
    names += [f"slice-{plane.family}" for plane in content.slices]
    names += [f"solid-{one.family}" for one in content.solids]
    names += ["workspace", *(f"image-{one}" for one, points in content.workspace.images if len(points))]
    names += [f"lines-{one}" for one in ids]
    kept = [name for name in names if not wanted or name in wanted or name.split("-")[0] in wanted]
    for one in wanted:
        if one not in names and not any(name.split("-")[0] == one for name in names):
            raise OptionError("this arm has no such figure", where="--figure", got=one, allowed=", ".join(names))
    return kept


def check_figures(analysis: Analysis, wanted: Sequence[str]) -> None:
    """Refuse, before the work, names that no arm has, and a missing matplotlib.

    Raises:
        OptionError: no such kind of figure, or no such family.
        MissingExtraError: matplotlib is not installed.
    """
    new_figure((1, 1))
    ids = {family.id for family in analysis.families}
    for name in wanted:
        kind, _, family = name.partition("-")
        if kind not in KINDS or (family and family not in ids):
            allowed = ", ".join(KINDS) + ", each with -FAMILY (lines-k1.f1) or without"
            raise OptionError("there is no such figure", where="--figure", got=name, allowed=allowed)


def figures(content: Content, names: Sequence[str], format: str) -> Iterator[tuple[str, bytes]]:
    """(name, file) of each figure, as pdf, png or svg; the same input gives the same file."""
    for name in names:
        yield name, rendered(figure(content, name), format)


def rendered(drawn: Figure, format: str) -> bytes:
    """One figure as a file."""
    import matplotlib

    buffer = BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "rankdrop", "pdf.fonttype": 42, "svg.fonttype": "none"}):
        drawn.savefig(buffer, format=format, dpi=_DPI, bbox_inches="tight", metadata=_DATE[format])
    return buffer.getvalue()


def figure(content: Content, name: str) -> Figure:
    """One figure by its name, as `figure_names` lists them.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    kind, _, which = name.partition("-")
    analysis, colours = content.analysis, content.colours
    index = [family.id for family in analysis.families].index(which) if which else 0
    if kind == "arm":
        return arm_figure(analysis, analysis.families[index], content.blamed[index])
    if kind == "slice":
        plane = next(one for one in content.slices if one.family == which)
        return slice_figure(analysis.robot, plane, colours)
    if kind == "solid":
        one = next(one for one in content.solids if one.family == which)
        return solid_figure(analysis.robot, one, colours[which])
    if kind == "lines":
        return lines_figure(analysis, analysis.families[index], content.sweeps[index])
    return workspace_figure(content.workspace, which or None, colours.get(which, 0))


def slice_figure(robot: Robot, plane: Slice, colours: dict[str, int]) -> Figure:
    """σ_r shaded, the families as curves and points."""
    drawn = new_figure((3.6, 3.4))
    axes = drawn.add_subplot()
    extent = (plane.x[0], plane.x[-1], plane.y[0], plane.y[-1])
    axes.imshow(plane.sigma.T, origin="lower", extent=extent, cmap="Greys_r", aspect="auto", alpha=0.75)
    for trace in plane.traces:
        tone = COLOURS[colours[trace.family] % len(COLOURS)]
        for k, line in enumerate(trace.curves):
            axes.plot(*line.T, color=tone, lw=1.8, label=trace.family if k == 0 else None)
        if len(trace.points):
            axes.plot(*trace.points.T, "o", color=tone, ms=4, label=None if trace.curves else trace.family)
    _name_axes(robot, axes, plane.joints)
    if plane.traces:
        axes.legend(fontsize=7, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False)
    return drawn


def solid_figure(robot: Robot, solid: Solid, index: int) -> Figure:
    """A family in the cube of three joints (AM Figure 5b)."""
    drawn = new_figure((4.2, 4.0))
    axes: Any = drawn.add_subplot(projection="3d")
    tone = COLOURS[index % len(COLOURS)]
    for line in solid.curves:
        for piece in pieces(line):
            axes.plot(*piece.T, color=tone, lw=1.8)
    if len(solid.triangles):
        axes.plot_trisurf(*solid.vertices.T, triangles=solid.triangles, color=tone, lw=0, alpha=0.9, antialiased=False)
    for k, set_name in enumerate((axes.set_xlabel, axes.set_ylabel, axes.set_zlabel)):
        joint = robot.variables[solid.joints[k] - 1]
        set_name(axis_name(joint_symbol(solid.joints[k], str(joint.kind)), joint.unit))
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_ticks([-pi, 0, pi], ["−180°", "0°", "180°"])
    axes.set(xlim=(-pi, pi), ylim=(-pi, pi), zlim=(-pi, pi))
    axes.set_box_aspect((1, 1, 1), zoom=0.85)
    return drawn


def workspace_figure(section: Workspace, family: str | None = None, index: int = 0) -> Figure:
    """The workspace in section with its walls, or with the image of one family."""
    drawn = new_figure((3.8, 4.4))
    axes = drawn.add_subplot()
    shade = np.where(
        section.tips > 0, 0.15 + 0.35 * np.sqrt(np.minimum(section.tips / max(section.tips.max(), 1), 1)), 0
    )
    extent = (section.x[0], section.x[-1], section.y[0], section.y[-1])
    axes.imshow(shade.T, origin="lower", extent=extent, cmap="Greys", vmin=0, vmax=1)
    if family is None:
        passed, barred = section.walls[~section.one_sided], section.walls[section.one_sided]
        axes.plot(*passed.T, ".", ms=1.2, color=COLOURS[1], label="passed in another posture", rasterized=True)
        axes.plot(*barred.T, ".", ms=1.4, color="black", label="not crossed", rasterized=True)
    else:
        points = dict(section.images)[family]
        axes.plot(*points.T, ".", ms=1.6, color=COLOURS[index % len(COLOURS)], label=family, rasterized=True)
    axes.set(xlabel=section.section.labels[0], ylabel=section.section.labels[1], aspect="equal")
    axes.legend(fontsize=7, loc="lower right", bbox_to_anchor=(1.0, 1.0), markerscale=5, frameon=False)
    return drawn


def lines_figure(analysis: Analysis, family: Family, swept: Sequence[Sweep]) -> Figure:
    """The smallest singular values as each joint moves through the witness, one panel per joint."""
    columns = min(4, len(swept))
    rows = -(-len(swept) // columns)
    drawn = new_figure((2.1 * columns, 1.6 * rows + 0.3))
    rank = analysis.generic_rank
    for k, sweep in enumerate(swept):
        axes = drawn.add_subplot(rows, columns, k + 1)
        for i in range(max(0, rank - family.corank - 1), rank):
            lost = i >= rank - family.corank
            tone, width = (COLOURS[1], 1.7) if lost else (COLOURS[0], 1.0)
            axes.plot(sweep.values, sweep.sigma[:, i], color=tone, lw=width, label=f"σ{i + 1}")
        axes.axvline(sweep.at, color="black", lw=0.7, ls=":")
        axes.set_title(
            joint_symbol(sweep.number, str(analysis.robot.variables[sweep.number - 1].kind)), fontsize=8, pad=2
        )
        axes.tick_params(labelsize=6)
        axes.set_ylim(bottom=0)
        if analysis.robot.periodic[sweep.number - 1]:
            axes.set_xticks([-pi, 0, pi], ["−180°", "0°", "180°"])
        if k == 0:
            axes.legend(fontsize=6)
    drawn.suptitle(f"{family.id}: {family.name}", fontsize=8)
    drawn.tight_layout()
    return drawn


def _name_axes(robot: Robot, axes: Any, joints: tuple[int, int]) -> None:
    ends = (axes.get_xlim(), axes.get_ylim())
    for k, (number, set_name, set_ticks) in enumerate(
        zip(joints, (axes.set_xlabel, axes.set_ylabel), (axes.set_xticks, axes.set_yticks), strict=True)
    ):
        joint = robot.variables[number - 1]
        set_name(axis_name(joint_symbol(number, str(joint.kind)), joint.unit))
        if joint.unit == "rad":
            ticks = angle_ticks(*ends[k])
            set_ticks([value for value, _ in ticks], [word for _, word in ticks])


def new_figure(size: tuple[float, float], what: str = "a figure for papers") -> Figure:
    """An empty figure of a size [inch]; `what` is named where matplotlib is not installed."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", None, what) from error
    return Figure(figsize=size)


ARROWS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Of the lost directions: blue, red, green as in AM, in tones that all eyes tell apart."""
_ARROW = 0.32  # length per reach


def arm_figure(analysis: Analysis, family: Family, blamed: Sequence[int] = ()) -> Figure:
    """The arm at the witness of a family; an arrow for each lost motion, solid, dotted, or with a ring.

    Args:
        analysis: of the arm.
        family: one of its families.
        blamed: numbers (from 1) of the joints whose axes are marked.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    robot = analysis.robot
    drawn = new_figure((3.8, 3.8))
    axes: Any = drawn.add_subplot(projection="3d")
    arm = drawn_at(robot, np.array(family.witness))
    size = reach(robot)
    draw_arm(axes, arm, size, blamed)
    lost = arrows(family.lost_directions, link_poses(robot, family.witness), analysis.task, size, _ARROW)
    for arrow, tone in zip(lost, ARROWS * len(lost), strict=False):
        if len(arrow.ring):
            axes.plot(*arrow.ring.reshape(-1, 3).T, color=tone, lw=1.3, zorder=900)
        draw_arrow(axes, arrow.start, arrow.end - arrow.start, tone, size, dotted=arrow.turns)
    _framed(axes, np.vstack([arm.links, *([arrow.start, arrow.end] for arrow in lost)]), size)
    drawn.suptitle(f"{family.id}: {family.name}", fontsize=8, y=0.96)
    return drawn


def _framed(axes: Any, points: Array, size: float) -> None:
    """A box as large as what is drawn, its floor at the base or below it; lengths are the same along all axes."""
    low, high = points.min(axis=0), points.max(axis=0)
    low[2] = min(low[2], 0.0)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2 + 0.08 * size, 0.2 * size)
    middle[2] += half[2] - (high[2] - low[2]) / 2  # room above, not under the floor
    (left, near, floor), (right, far, top) = middle - half, middle + half
    axes.set(xlim=(left, right), ylim=(near, far), zlim=(floor, top))
    axes.set_box_aspect(half, zoom=1.2)
    axes.locator_params(nbins=5)
    axes.tick_params(labelsize=6)
    for name, set_name in (("x", axes.set_xlabel), ("y", axes.set_ylabel), ("z", axes.set_zlabel)):
        set_name(f"{name} [m]", fontsize=7)
