"""Figures for papers, drawn with matplotlib: the arm at a witness, slices, sets in three joints, workspace, σ lines.

Every function returns a `matplotlib.figure.Figure`; nothing is shown, and no global state is touched.

What drawings of arms are made of, for matplotlib: joints as cylinders and boxes, axes, arrows with heads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from io import BytesIO
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.distance import Workspace
from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.families import Family, Slice, Solid, Sweep
from rankdrop.kinematics import link_poses
from rankdrop.local import Drawn, drawn_at
from rankdrop.report.chart import COLOURS, joint_axes, pieces, slice_chart, sweep_chart, workspace_chart
from rankdrop.report.content import Content
from rankdrop.results import Analysis
from rankdrop.robot import Array, Robot, reach
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
_DPI = 200
_DATE = {"pdf": {"CreationDate": None}, "svg": {"Date": None}, "png": {}}  # same input, same file


def every_figure(content: Content) -> dict[str, Callable[[], Figure]]:
    """Name of each figure -> what draws it."""
    analysis, colours, section = content.analysis, content.colours, content.workspace
    robot, families = analysis.robot, analysis.families
    arms = {f"arm-{family.id}": partial(arm_figure, analysis, family, blamed)
            for family, blamed in zip(families, content.blamed, strict=True)}  # fmt: skip
    slices = {f"slice-{one.family}": partial(slice_figure, robot, one, colours) for one in content.slices}
    solids = {f"solid-{one.family}": partial(solid_figure, robot, one, colours[one.family]) for one in content.solids}
    images = {f"image-{one}": partial(workspace_figure, section, one, colours[one])
              for one, points in section.images if len(points)}  # fmt: skip
    lines = {f"lines-{family.id}": partial(lines_figure, analysis, family, swept)
             for family, swept in zip(families, content.sweeps, strict=True)}  # fmt: skip
    return {**arms, **slices, **solids, "workspace": partial(workspace_figure, section), **images, **lines}


def figure_names(content: Content, wanted: Sequence[str] = ()) -> list[str]:
    """Names of the figures that there are, or of those of them that are wanted ("lines", "lines-k1.f1").

    Raises:
        OptionError: one that is wanted does not exist for this arm.
    """
    names = {name: (name, name.split("-")[0]) for name in every_figure(content)}
    for one in wanted:
        if not any(one in known for known in names.values()):
            raise OptionError("this arm has no such figure", where="figure", got=one, allowed=", ".join(names))
    return [name for name, known in names.items() if not wanted or set(known) & set(wanted)]


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
            raise OptionError("there is no such figure", where="figure", got=name, allowed=allowed)


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
    return every_figure(content)[name]()


def slice_figure(robot: Robot, plane: Slice, colours: dict[str, int]) -> Figure:
    """σ_r shaded, the families as curves and points."""
    drawn = new_figure((3.6, 3.4))
    slice_chart(robot, plane, colours).draw(drawn.add_subplot())
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
    names, _ = joint_axes(robot, solid.joints, [(-pi, pi)] * 3)
    for axis, name in zip((axes.xaxis, axes.yaxis, axes.zaxis), names, strict=True):
        axis.set_label_text(name)
        axis.set_ticks([-pi, 0, pi], ["−180°", "0°", "180°"])
    axes.set(xlim=(-pi, pi), ylim=(-pi, pi), zlim=(-pi, pi))
    axes.set_box_aspect((1, 1, 1), zoom=0.85)
    return drawn


def workspace_figure(section: Workspace, family: str = "", index: int = 0) -> Figure:
    """The workspace in section with its walls, or with the image of one family."""
    drawn = new_figure((3.8, 4.4))
    axes = drawn.add_subplot()
    workspace_chart(section, 320.0, family, index).draw(axes)
    axes.set_aspect("equal")
    return drawn


def lines_figure(analysis: Analysis, family: Family, swept: Sequence[Sweep]) -> Figure:
    """The smallest singular values as each joint moves through the witness, one panel per joint."""
    columns = min(4, len(swept))
    rows = -(-len(swept) // columns)
    drawn = new_figure((2.1 * columns, 1.6 * rows + 0.3))
    for k, sweep in enumerate(swept, start=1):
        axes = drawn.add_subplot(rows, columns, k)
        sweep_chart(analysis.robot, sweep, family.corank).draw(axes)
        axes.tick_params(labelsize=6)
    vanish = " … ".join(sorted({f"σ{analysis.generic_rank - family.corank + 1}", f"σ{analysis.generic_rank}"}))
    drawn.suptitle(f"{family.id}: {family.name}; {vanish} in orange, the next one in blue", fontsize=8)
    drawn.tight_layout()
    return drawn


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
