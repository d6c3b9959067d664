"""Draw the PA-10 at three of its singularities, as the README and the site show it: docs/images/pa10.svg.

    python tools/draw_singularities.py docs/images/pa10.svg

Everything drawn is a result: free joints stand where the picture is clear; family, conditions, blamed axes and lost
motions come from `rankdrop.explain`. Colours near the vermilion and blue of Okabe and Ito; solid arrows translate,
dotted ones rotate.
"""

from __future__ import annotations

import sys
from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import rankdrop
from rankdrop.disk import replace_file
from rankdrop.families.record import Family
from rankdrop.kinematics import link_poses
from rankdrop.results.explanation import Explanation
from rankdrop.robot.model import Array

WIDTH, HEIGHT = 210, 440  # of one panel: words can be read where the picture is 390 px wide
TOP, BOTTOM = 62, 128  # of a panel, for the legend and for the words
_LINE = 20  # characters of a line of a panel
SHOWN = ((0, 0.3, 0.3, 0, 0.7, 1.1, 0), (0.3, -0.4, 0.2, 1.3, np.pi / 2, 0, 0), (0, 0, 0, 0, 0, 0, 0))
AZIMUTH, ELEVATION = np.radians(-62), np.radians(16)
STYLE = """
  .card { fill: #ffffff; } .text { fill: #1b1b1b; } .faint { fill: #595959; }
  .link { stroke: #8a8f94; } .edge { stroke: #41464b; } .joint { fill: #ffffff; stroke: #41464b; }
  .axis { stroke: #9aa0a6; } .blamed { stroke: #c04e00; } .number { fill: #a84400; }
  .lost { stroke: #0067a5; } .head { fill: #0067a5; }
  text { font-family: system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
  @media (prefers-color-scheme: dark) {
    .card { fill: #16191d; } .text { fill: #f2f2f2; } .faint { fill: #b4b9be; }
    .link { stroke: #6d747b; } .edge { stroke: #c4cad0; } .joint { fill: #16191d; stroke: #c4cad0; }
    .axis { stroke: #6d747b; } .blamed { stroke: #f08a3c; } .number { fill: #f08a3c; }
    .lost { stroke: #56b4e9; } .head { fill: #56b4e9; }
  }
"""


class View:
    """A parallel projection that fits given points into a panel."""

    def __init__(self, points: Array, left: float) -> None:
        s, c = np.sin(AZIMUTH), np.cos(AZIMUTH)
        sine, cosine = np.sin(ELEVATION), np.cos(ELEVATION)
        right, up = np.array([-s, c, 0.0]), np.array([-c * sine, -s * sine, cosine])
        self.across = np.stack([right, -up])  # (2, 3); y runs down in a drawing
        flat = points @ self.across.T
        low, high = flat.min(axis=0), flat.max(axis=0)
        room = WIDTH - 40, HEIGHT - TOP - BOTTOM - 24
        self.scale = float(min(room[0] / max(high[0] - low[0], 0.1), room[1] / (high[1] - low[1])))
        self.shift = np.array([left + WIDTH / 2, (TOP + HEIGHT - BOTTOM) / 2]) - self.scale * (low + high) / 2

    def __call__(self, point: Array) -> NDArray[np.float64]:
        """Drawing coordinates of points (..., 3)."""
        shown: NDArray[np.float64] = point @ self.across.T * self.scale + self.shift
        return shown


def line(kind: str, a: Array, b: Array, width: float, extra: str = "") -> str:
    """One line of a style class."""
    return (
        f'<line class="{kind}" x1="{a[0]:.1f}" y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}" '
        f'stroke-width="{width}" stroke-linecap="round"{extra}/>'
    )


def arrow(view: View, start: Array, along: Array, *, dotted: bool) -> list[str]:
    """An arrow from a point along a direction of space; a half circle would not read at this size, so dots rotate."""
    a, b = view(start), view(start + along)
    way = (b - a) / max(float(np.linalg.norm(b - a)), 1e-9)
    side, back = np.array([-way[1], way[0]]), b - 13 * way
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in (b, back + 5.5 * side, back - 5.5 * side))
    dots = ' stroke-dasharray="0.1 7"' if dotted else ""
    return [line("lost", a, back, 4, dots), f'<polygon class="head" points="{corners}"/>']


def axes_drawn(view: View, frames: Array, blamed: set[int]) -> list[str]:
    """Every joint axis; those to blame longer, in colour, numbered, those in line drawn as one."""
    found = []
    lines: list[tuple[Array, Array, list[int], list[float]]] = []  # point, direction, joints, where along it
    for i in range(len(frames) - 2):
        centre, z = frames[i, :3, 3], frames[i, :3, 2]
        if i + 1 not in blamed:
            ends = view(centre - 0.13 * z), view(centre + 0.13 * z)
            found.append(line("axis", *ends, 1.2, ' stroke-dasharray="3 4"'))
            continue
        for point, along, joints, places in lines:
            if max(np.abs(np.cross(z, along)).max(), np.abs(np.cross(centre - point, along)).max()) < 1e-9:
                joints.append(i + 1)
                places.append(float((centre - point) @ along))
                break
        else:
            lines.append((centre, z, [i + 1], [0.0]))
    for point, along, joints, places in lines:
        a, b = view(point + (min(places) - 0.27) * along), view(point + (max(places) + 0.27) * along)
        low, high = (a, b) if a[1] > b[1] else (b, a)
        x, y = low + 16 * (low - high) / np.linalg.norm(low - high) + np.array([0, 4])
        place = f'x="{x:.1f}" y="{y:.1f}" font-size="16" text-anchor="middle"'
        words = ", ".join(str(number) for number in joints)
        found += [line("blamed", a, b, 2.2), f'<text class="number" {place}>{words}</text>']
    return found


def lost_drawn(view: View, here: Explanation, frames: Array) -> list[str]:
    """An arrow for each lost translation and rotation, at the reference point where the words hold."""
    framed = here.lost.framed
    assert framed is not None
    axes, point = frames[framed.frame.axes, :3, :3], frames[framed.frame.origin, :3, 3]
    parts = [(part, dotted) for twist in framed.directions for part, dotted in ((twist[:3], False), (twist[3:], True))]
    lengths = [float(np.linalg.norm(part)) for part, _ in parts]
    return [
        piece
        for (part, dotted), length in zip(parts, lengths, strict=True)
        if length > 0.1
        for piece in arrow(view, point, axes @ part / length * 0.36, dotted=dotted)
    ]


def conditions(family: Family) -> str:
    """Joints by the values they stand at: "θ2, θ4 = 0 or π"."""
    at: dict[tuple[float, ...], list[str]] = {}
    for one in family.pinned:
        at.setdefault(one.values, []).append(f"θ{one.number}")
    names = {0.0: "0", np.pi: "π", np.pi / 2: "π/2", -np.pi / 2: "−π/2"}
    return "; ".join(f"{', '.join(joints)} = {' or '.join(names[x] for x in values)}" for values, joints in at.items())


def panel(arm: rankdrop.Robot, q: Array, left: float) -> list[str]:
    """One arm at a singular configuration, with axes, arrows and words."""
    here = rankdrop.explain(arm, q)
    family, frames = here.met[0].family, link_poses(arm, q)  # standard DH: joint i turns about z of frame i − 1
    knots = np.vstack([frames[: arm.n, :3, 3], frames[-1:, :3, 3]])
    sets = [circuit.numbers for circuit in here.blame.smallest]
    blamed = set(min(sets, key=len)) if family.corank == 1 else {number for one in sets for number in one}
    ends = [frames[i - 1, :3, 3] + way * frames[i - 1, :3, 2] for i in blamed for way in (-0.27, 0.27)]
    view = View(np.vstack([knots, *ends, knots[-1:] + np.array([0, 0, 0.2])]), left)
    flat = view(knots)
    x, y = flat[0]
    found = [line("edge", np.array([x - 22, y + 8]), np.array([x + 22, y + 8]), 2)]
    for a, b in pairwise(flat):
        found += [line("edge", a, b, 13), line("link", a, b, 10)] if np.linalg.norm(b - a) > 1 else []
    found += [f'<circle class="joint" cx="{x:.1f}" cy="{y:.1f}" r="6" stroke-width="2"/>' for x, y in flat[:-1]]
    found += axes_drawn(view, frames, blamed) + lost_drawn(view, here, frames)
    told = conditions(family)
    if len(told) > _LINE:
        cut = "; " if ";" in told else " = "
        first, second = told.split(cut, 1)
        lines = (first, second if cut == "; " else f"= {second}")
    else:
        lines = (told, "")
    rows = (
        (17, "text", HEIGHT - 92, family.name.partition(":")[0].replace(", elbow and", ", elbow,")),
        (16, "text", HEIGHT - 64, lines[0]),
        (16, "text", HEIGHT - 42, lines[1]),
        (16, "faint", HEIGHT - (18 if lines[1] else 40), f"{family.corank} of 6 freedoms lost"),
    )
    middle = f'x="{left + WIDTH / 2:.0f}" text-anchor="middle"'
    words = (f'<text class="{c}" {middle} y="{y}" font-size="{size}">{escape(t)}</text>' for size, c, y, t in rows if t)
    return [*found, *words]


def drawing() -> str:
    """The whole picture."""
    arm = rankdrop.open_robot("pa10")
    parts = [part for i, q in enumerate(SHOWN) for part in panel(arm, np.array(q, dtype=float), i * WIDTH)]
    width = WIDTH * len(SHOWN)
    words = "Mitsubishi PA-10. Orange: joint axes to blame.", "Blue: motions lost (solid translation, dotted rotation)."
    legend = "".join(
        f'<text class="faint" x="14" y="{26 + 22 * i}" font-size="17">{line}</text>' for i, line in enumerate(words)
    )
    title = "The PA-10 arm at three of its singularities, with the motions that are lost and the joint axes to blame"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {HEIGHT}" role="img" aria-label="{title}">\n'
        f"<title>{title}</title>\n<style>{STYLE}</style>\n"
        f'<rect class="card" width="{width}" height="{HEIGHT}" rx="10"/>\n{legend}\n' + "\n".join(parts) + "\n</svg>\n"
    )


if __name__ == "__main__":
    replace_file(sys.argv[1], drawing().encode())
