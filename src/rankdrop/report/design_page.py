"""The page of a sweep: maps over two parameters, Pareto-optimal ones, sets of families, every variant in a table.

A sweep for papers and reports: every measure, and the sets of families, as maps over two parameters.
"""

from __future__ import annotations

from html import escape
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.designs import UNITS, Designs
from rankdrop.errors import OptionError
from rankdrop.report.chart import Chart, plain_ticks
from rankdrop.report.figures import new_figure
from rankdrop.report.page import header, whole_page
from rankdrop.robot import Array
from rankdrop.sections import Section, html
from rankdrop.version import VERSION

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_ROW = 3  # maps beside each other

_RAMP = ((68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37))
"""Colours from least to most: those of viridis, which keep their order in grey and for every eye."""
_DRAWN = 20_000  # variants on one map
_LISTED = 5_000  # variants in the table


def axes_of(designs: Designs, names: tuple[str, ...]) -> tuple[int, int]:
    """The two parameters of a map, from 0: those named, else the first two; the same one twice where there is one.

    Raises:
        OptionError: no such parameter, or not two of them.
    """
    known = [parameter.name for parameter in designs.parameters]
    for name in names:
        if name not in known:
            raise OptionError("there is no such parameter", where="over", got=name, allowed=", ".join(known))
    if names and len(set(names)) != 2:
        raise OptionError("a map is over two parameters", where="over", got=", ".join(names),
                          allowed="two of " + ", ".join(known))  # fmt: skip
    chosen = [known.index(name) for name in names] or [0, min(1, len(known) - 1)]
    return chosen[0], chosen[1]


def maps_of(designs: Designs, over: tuple[str, ...]) -> list[tuple[str, Array, tuple[Array, Array], tuple[str, str]]]:
    """What is drawn: the measures that differ, and the number of the set of families.

    Returns:
        Name, (V,) values, (V,) places along both axes in degrees or metres, names of the axes; over one parameter alone
        the values are the second axis.
    """
    maps = []
    for name in designs.measures:
        values = np.array([np.nan if x is None else float(x) for x in designs.values(name)])
        if np.isfinite(values).any():
            percent = UNITS[name] == "share"
            maps.append((f"{name} [%]", 100 * values) if percent else (name, values))
    if len(designs.structures) > 1:
        sets = np.full(len(designs.records), np.nan)
        for number, structure in enumerate(designs.structures, 1):
            sets[list(structure.variants)] = number
        maps.append(("set of families", sets))
    places, labels = _places(designs, over)
    single = len(places) == 1
    return [
        (name, values, (places[0], values if single else places[1]), (labels[0], name if single else labels[1]))
        for name, values in maps
    ]


def _places(designs: Designs, over: tuple[str, ...]) -> tuple[list[Array], list[str]]:
    """(V,) values of the one or two parameters of a map in degrees or metres, and the names of their axes."""
    places, labels = [], []
    for k in dict.fromkeys(axes_of(designs, over)):
        values = np.array([record["values"][k] for record in designs.records])
        angle = designs.parameters[k].measure == "angle"
        places.append(np.degrees(values) if angle else values)
        labels.append(f"{designs.parameters[k].name} [{'°' if angle else 'm'}]")
    return places, labels


def design_figure(designs: Designs, over: tuple[str, ...] = ()) -> Figure:
    """One map for each measure over two parameters; Pareto-optimal variants are ringed.

    Args:
        designs: the sweep.
        over: names of two parameters; () for the first two. Of further parameters all values are drawn in one place.

    Raises:
        OptionError: no such parameter.
        MissingExtraError: matplotlib is not installed.
    """
    maps = maps_of(designs, over)
    columns, rows = min(_ROW, max(1, len(maps))), max(1, ceil(len(maps) / _ROW))
    drawn = new_figure((3.4 * columns, 2.9 * rows + 0.3), "a figure of a sweep")
    for place, (name, values, (x, y), labels) in enumerate(maps, 1):
        axes: Any = drawn.add_subplot(rows, columns, place)
        if designs.spec.kind == "grid":
            mark = "s"
        else:
            mark = "o"
        dots = axes.scatter(x, y, c=values, s=_size(len(x)), marker=mark, cmap="viridis")
        best = [i for i in designs.pareto if np.isfinite(values[i])]
        axes.scatter(x[best], y[best], s=1.8 * _size(len(x)), facecolors="none", edgecolors="#D55E00", lw=1.0)
        drawn.colorbar(dots, ax=axes).ax.tick_params(labelsize=6)
        axes.set_title(name, fontsize=8)
        axes.set_xlabel(labels[0], fontsize=7)
        axes.set_ylabel(labels[1], fontsize=7)
        axes.tick_params(labelsize=6)
    drawn.suptitle(f"{designs.robot}: {len(designs.records):,} variants", fontsize=9)
    drawn.tight_layout()
    return drawn


def _size(count: int) -> float:
    """Area of a dot [points²]."""
    return float(np.clip(9000.0 / max(count, 1), 4.0, 120.0))


def design_page(designs: Designs, over: tuple[str, ...] = ()) -> str:
    """The whole page as text: it stands alone.

    Args:
        designs: the sweep.
        over: names of the two parameters of the maps; () for the first two.

    Raises:
        OptionError: no such parameter.
    """
    css, title = "good" if designs.holds else "bad", f"{escape(designs.robot)}: designs"
    facts = [
        ("variants", f"{len(designs.records):,} ({designs.spec.kind})"),
        ("parameters", ", ".join(parameter.name for parameter in designs.parameters)),
        ("task", f"{designs.spec.task.name}, σ with lengths divided by {designs.spec.task.length_scale:.4g} m"),
        ("better", ", ".join(f"{want} {name}" for name, want in designs.spec.goals.items()) or "nothing was said"),
    ]
    sections = list(designs.sections())
    body = (
        f"{header(title, css, designs.sentence, facts)}<main>"
        f'<section id="maps"><h2>Maps</h2>{_maps(designs, over)}</section>'
        f'<section id="words"><h2>In words</h2><div class="scroll">{html(sections[1:-1])}</div></section>'
        f'<section id="variants"><h2>Every variant</h2><div class="scroll">{_table(designs)}</div></section></main>'
    )
    return whole_page(f"{designs.robot}: designs", body, {}, (), version=VERSION)


def _maps(designs: Designs, over: tuple[str, ...]) -> str:
    charts = "".join(
        f"<figure><figcaption>{escape(name)}</figcaption>{_map(designs, values, *places, names)}</figure>"
        for name, values, places, names in maps_of(designs, over)
    )
    told = '<p class="small">Every dot is a variant; the Pareto-optimal ones are ringed.</p>'
    if charts:
        return f'<div class="cards">{charts}</div>{told}'
    return "<p>Nothing was measured.</p>"


def _map(designs: Designs, numbers: Array, x: Array, y: Array, names: tuple[str, str]) -> str:
    there = np.flatnonzero(np.isfinite(numbers) & np.isfinite(y))[:_DRAWN]
    ends = (_padded_range(x[there]), _padded_range(y[there]))
    chart = Chart(*ends, names=names, ticks=(plain_ticks(*ends[0]), plain_ticks(*ends[1])))
    low, high = float(numbers[there].min()), float(numbers[there].max())
    radius = float(np.clip(260.0 / max(len(there), 1) ** 0.5 / 2, 1.5, 14.0))
    parts, best = [], set(designs.pareto)
    for i, (across, down) in zip(there.tolist(), chart.place(np.stack([x[there], y[there]], axis=1)), strict=True):
        if i in best:
            ring = ' stroke="#D55E00" stroke-width="2"'
        else:
            ring = ""
        tone = _tone((numbers[i] - low) / (high - low) if high > low else 0.5)
        parts.append(f'<circle cx="{across:.1f}" cy="{down:.1f}" r="{radius:.1f}" fill="{tone}"{ring}>'
                     f"<title>variant {i + 1}: {numbers[i]:.5g}</title></circle>")  # fmt: skip
    scale = " &ensp; ".join(f'<i class="dot" style="background:{_tone(share)}"></i> {value:.4g}'
                            for share, value in ((0.0, low), (1.0, high)))  # fmt: skip
    return f'{chart.svg(f"{names[0]}, {names[1]}", parts)}<p class="small">{scale}</p>'


def _padded_range(values: Array) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    room = 0.06 * (high - low) or 0.05 * max(abs(high), 1.0)
    return low - room, high + room


def _tone(share: float) -> str:
    steps = np.linspace(0.0, 1.0, len(_RAMP))
    return "#" + "".join(f"{round(np.interp(share, steps, channel)):02x}" for channel in zip(*_RAMP, strict=True))


def _table(designs: Designs) -> str:
    heads = ["variant", *(parameter.name for parameter in designs.parameters), *designs.measures, ""]
    rows, best = [], set(designs.pareto)
    for record in designs.records[:_LISTED]:
        note = record["error"] or ("Pareto-optimal" if record["number"] in best else "")
        rows.append((str(record["number"] + 1), *designs.row(record), note))
    left = len(designs.records) - _LISTED
    more = (f"and {left:,} more, in the JSON and the Parquet files",) if left > 0 else ()
    return html([Section("", columns=tuple(heads), rows=tuple(rows), after=more)])
