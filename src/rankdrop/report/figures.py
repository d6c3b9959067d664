"""Figures for papers, drawn with matplotlib: the arm at a witness, slices, sets in three joints, workspace, σ lines.

Every function returns a `matplotlib.figure.Figure`; nothing is shown, and no global state is touched.

What drawings of arms are made of, for matplotlib: joints as cylinders and boxes, axes, arrows with heads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from itertools import pairwise
from math import degrees, pi
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.distance import Workspace
from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.families import VIEW, Family, Slice, Solid, Sweep
from rankdrop.kinematics import link_poses
from rankdrop.local import Drawn, drawn_at
from rankdrop.report.chart import COLOURS, joint_axes, pieces, slice_chart, sweep_chart, workspace_chart
from rankdrop.report.content import Content, standing
from rankdrop.results import Analysis
from rankdrop.robot import Array, Robot, reach
from rankdrop.text import place_name
from rankdrop.viewer.scene import arrows, barrel_mesh

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LINK, BODY, AXIS, MARKED = "#7C8B9B", "#4F6073", "#A9B4C0", "#E07B00"
_RADIUS, _HALF, _APART = 0.035, 0.045, 0.11
"""Of a joint's body, and how far joints of one place are drawn from it along their axes; lengths per size."""
_HEAD, _WIDTH, _SIDES = 0.075, 0.026, 16
"""Of an arrow head, per size."""

_RINGS, _AROUND = (0.7, 1.1, 1.6, 2.3, 3.2), 16
"""Where a number is tried around its joint: so many widths off the body, in so many directions."""
_WIDE, _OFF, _DENSE = 8.0, 2.0, 40
"""Width of a number and its distance from lines, at 72 dots per inch; places at which a bar is tried."""

KINDS = ("arm", "slice", "solid", "workspace", "image", "lines")
"""What figures there are; each but the workspace is of one family: arm-k1.f1."""
_DPI = 200
_DATE = {"pdf": {"CreationDate": None}, "svg": {"Date": None}, "png": {}}  # same input, same file

ARROWS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Of the lost directions: blue, red, green as in AM, in tones that all eyes tell apart."""
_ARROW, _SHARE = 0.32, 0.2  # length per reach, and at most per size of the arm as it stands
_ELEVATION, _TITLE = 12.0, 58  # of the view [°]; characters of a line of the title
_OUTSIDE = {
    "outside": " (outside the joint limits)", "none found": " (no member found inside the joint limits)",
}  # fmt: skip
_SHORT = 0.4  # an edge of the box shorter than this has no numbers: those of two edges would stand on each other
_FILLED = (0.93, 0.97)  # width and height of the box about the arm, per those of the picture; the rest is for numbers


@dataclass(frozen=True, slots=True)
class KeepOut:
    """What a number may not stand on: all within a radius of a line from one place to another [m]."""

    start: Array
    end: Array
    radius: float = 0.0


@dataclass(frozen=True, slots=True)
class ArmMarks:
    """Numbers of the joints of a drawn arm, and what they have to keep off.

    Attributes:
        numbers: texts in space at the ends of the axes, one for each joint.
        others: (N, 3) the other ends of the axes [m].
        bodies: one bar for each joint's body.
        bars: links and axes.
    """

    numbers: list[Any]
    others: Array
    bodies: list[KeepOut]
    bars: list[KeepOut]


def draw_arm(axes: Any, drawn: Drawn, size: float, marked: Sequence[int] = (), long: float = 0.09) -> ArmMarks:
    """An arm on axes in space: its links, a body for each joint, its axis as a line with its number.

    Joints whose axes meet in one point are drawn apart on their axes.

    Args:
        axes: of matplotlib, with projection="3d".
        drawn: the arm.
        size: length that everything is drawn in proportion to, such as the reach [m].
        marked: numbers of joints that are drawn in another colour, with longer axes.
        long: how far axes stand out of their joints, per size.

    Returns:
        The numbers, as texts in space; `words_apart` moves those that stand on something.
    """
    numbers, others, bodies = [], [], []
    axes.set_autoscale_on(False)  # whoever draws sets the limits
    axes.plot(*drawn.links.T, color=LINK, lw=4, solid_capstyle="round", solid_joinstyle="round")
    bars = [KeepOut(start, end) for start, end in pairwise(drawn.links)]
    places = spread_out(drawn, _APART * size)
    for place, middle, axis, slides, number in zip(
        places, drawn.middles, drawn.axes, drawn.slides, drawn.numbers, strict=True
    ):
        tone = MARKED if number in marked else BODY
        if np.any(place != middle):
            axes.plot(*np.stack([middle, place]).T, color=LINK, lw=2.5)
            bars.append(KeepOut(middle, place))
        sides = 4 if slides else _SIDES
        half = _HALF * size * axis
        _add(axes, barrel_mesh(place - half, place + half, _RADIUS * size, sides=sides), tone)
        bodies.append(KeepOut(place - half, place + half, _RADIUS * size))
        reached = (_HALF + (0.12 if number in marked else long)) * size
        line = np.stack([place - reached * axis, place + reached * axis])
        axes.plot(*line.T, color=MARKED if number in marked else AXIS, lw=1.1, ls="-.")
        bars.append(KeepOut(line[0], line[1]))
        beyond = (reached + 0.03 * size) * axis
        colour = MARKED if number in marked else "black"
        numbers.append(axes.text(*(place + beyond), str(number), fontsize=7, zorder=1000, color=colour))
        others.append(place - beyond)
    return ArmMarks(numbers, np.array(others), bodies, bars)


class Picture:
    """Where things in space are in the plane of a picture [dots]."""

    def __init__(self, axes: Any) -> None:
        self.axes, self.dot = axes, axes.figure.dpi / 72

    def flat(self, points: Array) -> Array:
        """(k, 2) the places of points (k, 3)."""
        from mpl_toolkits.mplot3d import proj3d

        projected = proj3d.proj_transform(*np.atleast_2d(points).T, self.axes.get_proj())[:2]
        return np.asarray(self.axes.transData.transform(np.stack(projected, axis=1)))

    def radius(self, bar: KeepOut) -> float:
        """The radius of a bar, seen in the middle of it."""
        middle = (bar.start + bar.end) / 2
        around = self.flat(middle + bar.radius * np.vstack([np.zeros(3), np.eye(3)]))
        return float(np.linalg.norm(around[1:] - around[0], axis=1).max())

    def edges(self) -> Array:
        """(k, 3) places of the three edges with names, as `covered` has them; drawn before."""
        share = np.linspace(0.0, 1.0, _DENSE)[:, None]
        parts = []
        for axis in (self.axes.xaxis, self.axes.yaxis, self.axes.zaxis):
            start, end = self.axes.transData.transform(axis.line.get_xydata())
            parts.append(np.column_stack([start + share * (end - start), np.zeros(_DENSE)]))
        return np.vstack(parts)

    def bar_places(self, bars: Sequence[KeepOut]) -> Array:
        """(k, 3) places of bars, and how far around each of them no number stands."""
        share = np.linspace(0.0, 1.0, _DENSE)[:, None]
        parts = []
        for bar in bars:
            line = self.flat(bar.start + share * (bar.end - bar.start))
            parts.append(np.column_stack([line, np.full(_DENSE, self.radius(bar))]))
        return np.vstack(parts)


def words_apart(axes: Any, marks: ArmMarks, more: Sequence[KeepOut] = ()) -> list[Any]:
    """Numbers of joints in the plane of the picture, off the arm, the arrows, the words of the axes and each other.

    A number is tried at both ends of its axis, then around the joint's body, farther and farther; the first free place
    is taken.

    Args:
        axes: of matplotlib, its limits and view set.
        marks: of `draw_arm`; its texts are taken away.
        more: what else is drawn.

    Returns:
        The texts that stand there now.
    """
    figure = axes.figure
    figure.draw_without_rendering()  # words of the axes have their places from then on
    picture = Picture(axes)
    covered = np.vstack([picture.bar_places([*marks.bars, *marks.bodies, *more]), picture.edges()])
    half = 0.5 * _WIDE * picture.dot
    boxes = [_grown(box, half) for box in _words_of(axes)]
    placed = []
    order = sorted(range(len(marks.numbers)), key=lambda i: marks.numbers[i].get_color() != MARKED)
    for i in order:
        number = marks.numbers[i]
        tries = _tries(picture, np.array(number.get_position_3d()), marks.others[i], marks.bodies[i])
        at = next((place for place in tries if _free(place, half, picture.dot, covered, boxes)), tries[0])
        boxes.append(np.array([at - 2 * half, at + 2 * half]))
        x, y = figure.transFigure.inverted().transform(at)
        placed.append(figure.text(
            x, y, number.get_text(), fontsize=7, color=number.get_color(), ha="center", va="center", zorder=1000,
            bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.6},
        ))  # fmt: skip
        number.remove()
    return placed


def _words_of(axes: Any) -> list[Any]:
    """Boxes of the names of the axes and of the numbers along them."""
    edges = (axes.xaxis, axes.yaxis, axes.zaxis)
    words = [text for axis in edges for text in (axis.label, *axis.get_ticklabels())]
    return [text.get_window_extent() for text in words if text.get_text()]


def _grown(box: Any, by: float) -> Array:
    """(2, 2) two corners of a box that is larger on every side."""
    return np.array([[box.x0 - by, box.y0 - by], [box.x1 + by, box.y1 + by]])


def _tries(picture: Picture, end: Array, other: Array, body: KeepOut) -> list[Array]:
    """Places for a joint's number: the ends of its axis, then around its body."""
    curves = list(picture.flat(np.stack([end, other])))
    middle = picture.flat((body.start + body.end) / 2)[0]
    reach_of_body = np.linalg.norm(picture.flat(body.end)[0] - middle)
    for ring in _RINGS:
        off = picture.radius(body) + ring * _WIDE * picture.dot
        for turn in np.linspace(0.0, 2 * pi, _AROUND, endpoint=False):
            way = np.array([np.cos(turn), np.sin(turn)])
            along = (picture.flat(body.end)[0] - middle) / max(reach_of_body, 1e-9)
            curves.append(middle + (off + abs(way @ along) * reach_of_body) * way)
    return curves


def _free(at: Array, half: float, dot: float, covered: Array, boxes: Sequence[Array]) -> bool:
    """Whether a number at a place stands on nothing."""
    near = np.abs(covered[:, :2] - at).max(axis=1) < half + covered[:, 2] + _OFF * dot
    return not near.any() and not any(((box[0] < at) & (at < box[1])).all() for box in boxes)


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


def every_figure(content: Content) -> dict[str, Callable[[], Figure]]:
    """Name of each figure -> what draws it."""
    analysis, colours, section = content.analysis, content.colours, content.workspace
    robot, families = analysis.robot, analysis.families
    titles, labels = content.titles, content.labels
    arms = {f"arm-{family.id}": partial(arm_figure, analysis, family, blamed)
            for family, blamed in zip(families, content.blamed, strict=True)}  # fmt: skip
    slices = {f"slice-{piece.family}": partial(slice_figure, robot, piece, colours, labels) for piece in content.slices}
    solids = {f"solid-{solid.family}": partial(solid_figure, robot, solid, colours[solid.family], labels[solid.family])
              for solid in content.solids}  # fmt: skip
    images = {f"image-{name}": partial(workspace_figure, section, name, colours[name], labels[name])
              for name, points in section.images if len(points)}  # fmt: skip
    lines = {f"lines-{family.id}": partial(lines_figure, analysis, family, swept, titles[family.id])
             for family, swept in zip(families, content.sweeps, strict=True)}  # fmt: skip
    return {**arms, **slices, **solids, "workspace": partial(workspace_figure, section), **images, **lines}


def figure_names(content: Content, wanted: Sequence[str] = ()) -> list[str]:
    """Names of the figures that there are, or of those of them that are wanted ("lines", "lines-k1.f1").

    Raises:
        OptionError: one that is wanted does not exist for this arm.
    """
    names = {name: (name, name.split("-")[0]) for name in every_figure(content)}
    for name in wanted:
        if not any(name in known for known in names.values()):
            raise OptionError("this arm has no such figure", where="figure", got=name, allowed=", ".join(names))
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
        yield name, render(figure(content, name), format)


def render(drawn: Figure, format: str) -> bytes:
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


def slice_figure(robot: Robot, plane: Slice, colours: dict[str, int], labels: dict[str, str]) -> Figure:
    """σ_r shaded, the families as curves and points, the legend at the right of them."""
    drawn = new_figure((3.6, 3.4))
    slice_chart(robot, plane, colours, labels).draw(drawn.add_subplot())
    return drawn


def solid_figure(robot: Robot, solid: Solid, index: int, label: str = "") -> Figure:
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
        axis.set_ticks([-pi / 2, 0, pi / 2], ["−90°", "0°", "90°"])  # at ±180° two axes share a corner
    axes.set(xlim=(-pi, pi), ylim=(-pi, pi), zlim=(-pi, pi))
    axes.set_box_aspect((1, 1, 1), zoom=0.85)
    axes.set_title(fill(f"{solid.family} {label}", _TITLE), fontsize=8)
    return drawn


def workspace_figure(section: Workspace, family: str = "", index: int = 0, label: str = "") -> Figure:
    """The workspace in section with its walls, or with the image of one family."""
    drawn = new_figure((3.8, 4.4))
    axes = drawn.add_subplot()
    workspace_chart(section, 320.0, family, index, label).draw(axes)
    axes.set_aspect("equal")
    return drawn


def lines_figure(analysis: Analysis, family: Family, swept: Sequence[Sweep], title: str) -> Figure:
    """The smallest singular values as each joint moves through the witness, one panel per joint."""
    columns = min(4, len(swept))
    rows = -(-len(swept) // columns)
    drawn = new_figure((2.1 * columns, 1.6 * rows + 0.3))
    for k, sweep in enumerate(swept, start=1):
        axes = drawn.add_subplot(rows, columns, k)
        sweep_chart(analysis.robot, sweep, family.corank).draw(axes)
        axes.tick_params(labelsize=6)
    vanish = " … ".join(sorted({f"σ{analysis.generic_rank - family.corank + 1}", f"σ{analysis.generic_rank}"}))
    drawn.suptitle(f"{family.id}: {title}; {vanish} in orange, the next one in blue", fontsize=8)
    drawn.tight_layout()
    return drawn


def new_figure(size: tuple[float, float], what: str = "a figure for papers") -> Figure:
    """An empty figure of a size [inch]; `what` is named where matplotlib is not installed."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", None, what) from error
    return Figure(figsize=size)


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
    axes.view_init(elev=_ELEVATION, azim=degrees(VIEW))
    q = np.array(family.witness)
    arm, size = drawn_at(robot, q), reach(robot)
    marks = draw_arm(axes, arm, size, blamed)
    own = float(np.linalg.norm(np.ptp(arm.links, axis=0))) / size
    lost = arrows(family.lost_directions, link_poses(robot, q), analysis.task, size, min(_ARROW, _SHARE * own))
    bars = []
    for arrow, tone in zip(lost, ARROWS * len(lost), strict=False):
        if len(arrow.ring):
            axes.plot(*arrow.ring.reshape(-1, 3).T, color=tone, lw=1.3, zorder=900)
            bars += [KeepOut(start, end) for start, end in arrow.ring.reshape(-1, 2, 3)]
        draw_arrow(axes, arrow.start, arrow.end - arrow.start, tone, size, dotted=arrow.turns)
        bars.append(KeepOut(arrow.start, arrow.end, _WIDTH * size))
    ends = spread_out(arm, _APART * size)[:, None] + _HALF * size * np.stack([-arm.axes, arm.axes], axis=1)
    _frame_arm(axes, np.vstack([arm.links, ends.reshape(-1, 3)]), np.array([arrow.end for arrow in lost]), size)
    words_apart(axes, marks, bars)
    title = f"{family.id}: {place_name(robot, analysis.task, family)}"
    title += _OUTSIDE.get(standing(analysis, family), "")
    top = drawn.get_tightbbox().y1 / drawn.get_figheight() + 0.01
    drawn.suptitle(fill(title, _TITLE), fontsize=8, y=top, va="bottom")
    return drawn


def _frame_arm(axes: Any, points: Array, heads: Array, size: float) -> None:
    """A box about the points of the arm, so large that it and the heads of the arrows fill the picture.

    Lengths are the same along all axes.
    """
    from matplotlib.ticker import MaxNLocator
    from mpl_toolkits.mplot3d import proj3d

    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2 + 0.01 * size, 0.12 * size)
    (left, near, floor), (right, far, top) = middle - half, middle + half
    axes.set(xlim=(left, right), ylim=(near, far), zlim=(floor, top))
    axes.set_position([0.0, 0.0, 1.0, 1.0])
    axes.set_box_aspect(half)
    axes.figure.canvas.draw()  # the projection is known once it has been drawn
    corners = np.array([(x, y, z) for x in (left, right) for y in (near, far) for z in (floor, top)])
    held = np.vstack([corners, heads.reshape(-1, 3)])
    flat = np.stack(proj3d.proj_transform(*held.T, axes.get_proj())[:2], axis=1)
    wide, tall = 2 * np.abs(axes.transAxes.inverted().transform(axes.transData.transform(flat)) - 0.5).max(axis=0)
    axes.set_box_aspect(half, zoom=min(_FILLED[0] / wide, _FILLED[1] / tall))
    axes.tick_params(labelsize=6, pad=-2)
    axes.tick_params(axis="z", pad=1)
    for name, share, away in zip("xyz", half / half.max(), (-7, -7, 3), strict=True):
        axis = getattr(axes, f"{name}axis")
        axis.set_major_locator(MaxNLocator(nbins=max(2, int(np.ceil(4 * share)))))
        if share < _SHORT:
            axis.set_ticklabels([])
            away = -13
        getattr(axes, f"set_{name}label")(f"{name} [m]", fontsize=7, labelpad=away)
