"""A sweep for papers and reports: every measure, and the sets of families, as maps over two parameters."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.designs import UNITS, Designs, Parameter
from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.robot import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROW = 3  # maps beside each other


def axes_of(designs: Designs, names: tuple[str, ...]) -> tuple[int, int]:
    """The two parameters of a map, from 0: those named, else the first two; the same one twice where there is one.

    Raises:
        OptionError: no such parameter, or not two of them.
    """
    known = [one.name for one in designs.parameters]
    for name in names:
        if name not in known:
            raise OptionError("there is no such parameter", where="over", got=name, allowed=", ".join(known))
    if names and len(set(names)) != 2:
        raise OptionError("a map is over two parameters", where="over", got=", ".join(names),
                          allowed="two of " + ", ".join(known))  # fmt: skip
    chosen = [known.index(name) for name in names] or [0, min(1, len(known) - 1)]
    return chosen[0], chosen[1]


def in_shown_units(parameter: Parameter, values: Array) -> Array:
    """Values of a parameter as people read them: degrees, metres."""
    return np.degrees(values) if parameter.measure == "angle" else values


def label(parameter: Parameter) -> str:
    """Its name and the unit it is drawn in."""
    return f"{parameter.name} [{'°' if parameter.measure == 'angle' else 'm'}]"


def maps_of(designs: Designs) -> list[tuple[str, Array]]:
    """(name, (V,) values) of what is drawn: the measures that differ, and the number of the set of families."""
    maps = []
    for name in designs.measures:
        values = np.array([np.nan if x is None else float(x) for x in designs.values(name)])
        if np.isfinite(values).any():
            percent = UNITS[name] == "share"
            maps.append((f"{name} [%]", 100 * values) if percent else (name, values))
    if len(designs.structures) > 1:
        sets = np.full(len(designs.records), np.nan)
        for number, one in enumerate(designs.structures, 1):
            sets[list(one.variants)] = number
        maps.append(("set of families", sets))
    return maps


def design_figure(designs: Designs, over: tuple[str, ...] = ()) -> Figure:
    """One map for each measure over two parameters; Pareto-optimal variants are ringed.

    Args:
        designs: the sweep.
        over: names of two parameters; () for the first two. Of further parameters all values are drawn in one place.

    Raises:
        OptionError: no such parameter.
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", None, "a figure of a sweep") from error
    first, second = axes_of(designs, over)
    x, y = (in_shown_units(designs.parameters[k], np.array([one["values"][k] for one in designs.records]))
            for k in (first, second))  # fmt: skip
    maps = maps_of(designs)
    rows = max(1, ceil(len(maps) / _ROW))
    drawn = Figure(figsize=(3.4 * min(_ROW, max(1, len(maps))), 2.9 * rows + 0.3))
    for place, (name, values) in enumerate(maps, 1):
        axes: Any = drawn.add_subplot(rows, min(_ROW, len(maps)), place)
        single = first == second
        high = values if single else y
        mark = "s" if designs.kind == "grid" else "o"
        dots = axes.scatter(x, high, c=values, s=_size(len(x)), marker=mark, cmap="viridis")
        best = [i for i in designs.pareto if np.isfinite(values[i])]
        axes.scatter(x[best], high[best], s=1.8 * _size(len(x)), facecolors="none", edgecolors="#D55E00", lw=1.0)
        drawn.colorbar(dots, ax=axes).ax.tick_params(labelsize=6)
        axes.set_title(name, fontsize=8)
        axes.set_xlabel(label(designs.parameters[first]), fontsize=7)
        axes.set_ylabel(name if single else label(designs.parameters[second]), fontsize=7)
        axes.tick_params(labelsize=6)
    drawn.suptitle(f"{designs.robot}: {len(designs.records):,} variants", fontsize=9)
    drawn.tight_layout()
    return drawn


def _size(count: int) -> float:
    """Area of a dot [points²]."""
    return float(np.clip(9000.0 / max(count, 1), 4.0, 120.0))


